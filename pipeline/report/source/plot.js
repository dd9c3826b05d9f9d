// A plot {title, x, y, curves, edge, tiles, kinds, notes} as page_plots.cpp writes it, by uPlot: axes and their scales are
// uPlot's, curves are drawn point by point in their own order, as a finer run may be the faster one.
import uPlot from 'uplot';
import { css, h } from './dom.js';
import { colourOf, drawCurve, drawEdge, drawTiles, sampleOf, swatchOf } from './plot_marks.js';
import { tickText, ticksOf } from './plot_ticks.js';

const reach = 40; // pixels: largest distance from the pointer to a point with a readout

/** Returns {element, draw, tell}; `tips` are the page's texts, to which points refer by number. */
export function makePlot(data, tips) {
  const shown = data.curves.map((curve) => curve.shown);
  const holder = h('div', { class: 'chart-holder' });
  const tip = h('div', { class: 'tip', role: 'status', hidden: true });
  const ring = h('div', { class: 'ring', 'aria-hidden': 'true', hidden: true });
  let chart = null;
  const draw = () => {
    if (holder.clientWidth === 0) return;
    chart?.destroy();
    tip.hidden = ring.hidden = true;
    chart = new uPlot(optionsOf(data, shown, holder.clientWidth), seriesOf(data), holder);
    chart.over.append(ring);
    listen(chart.over);
    legend.replaceChildren(...legendOf(data, shown, toggle));
  };
  const toggle = (curve) => {
    shown[curve] = !shown[curve];
    tip.hidden = ring.hidden = true;
    chart.setSeries(curve + 1, { show: shown[curve] });
    for (const button of legend.querySelectorAll(`[data-curve="${curve}"]`))
      button.setAttribute('aria-pressed', String(shown[curve]));
  };
  /** Shows the readout at a position in the plotting area (pixels); null hides it. */
  const tell = (left, top) => {
    const found = nearestPoint(chart, data, shown, left, top) ?? tileAt(chart, data, left, top);
    tip.hidden = ring.hidden = !found;
    if (!found) return null;
    const [first, ...lines] = wordsOf(data, tips, found).split('\n');
    tip.replaceChildren(h('strong', {}, first), ...lines.map((line) => h('div', {}, line)));
    ring.hidden = found.left === undefined;
    ring.style.transform = `translate(${found.left}px, ${found.top}px)`;
    place(tip, chart.over, holder, found.left ?? left, found.top ?? top);
    return tip.innerText;
  };
  const listen = (over) => {
    const at = (event) => {
      if (event.buttons && event.pointerType === 'mouse') return; // a drag zooms in
      const box = over.getBoundingClientRect();
      tell(event.clientX - box.left, event.clientY - box.top);
    };
    over.addEventListener('pointermove', at);
    over.addEventListener('pointerdown', at);
    over.addEventListener('pointerleave', (event) => {
      if (event.pointerType === 'mouse') tip.hidden = ring.hidden = true; // after a touch the readout stays
    });
  };
  const legend = h('div', { class: 'legend', role: 'group', 'aria-label': 'Curves' });
  const element = h(
    'div',
    { class: 'live' },
    h('figcaption', {}, data.title),
    legend,
    h('p', { class: 'axis-name' }, data.y.label),
    h('div', { class: 'chart-frame' }, holder, tip),
    h('p', { class: 'quiet small-print' }, 'Point at a mark to read it.', h('span', { class: 'by-mouse' }, ' Drag to enlarge, double-click to see all.')),
    data.notes.map((note) => h('p', { class: 'quiet small-print' }, note)),
  );
  return { element, draw, tell, data, position: (x, y) => [chart.valToPos(x, 'x'), chart.valToPos(y, 'y')] };
}

/** Puts the tip beside a position in the plotting area, within the frame. */
function place(tip, over, holder, left, top) {
  const frame = holder.getBoundingClientRect();
  const box = over.getBoundingClientRect();
  const x = box.left - frame.left + left;
  const y = box.top - frame.top + top;
  const to = x + 14 + tip.offsetWidth > frame.width ? x - 14 - tip.offsetWidth : x + 14;
  tip.style.left = `${Math.max(0, Math.min(to, frame.width - tip.offsetWidth))}px`;
  tip.style.top = `${y + 16 + tip.offsetHeight > frame.height ? Math.max(0, y - 16 - tip.offsetHeight) : y + 16}px`;
}

/** "time 0.3 s" for the axis "time (s)"; the unit is the text in the last brackets. */
function withUnit(label, value) {
  const [, name, unit] = /^(.*?)(?: \(([^()]*)\))?$/.exec(label);
  return `${name}: ${tickText(value, false, 4)}${unit ? ` ${unit}` : ''}`;
}

function wordsOf(data, tips, { tipNumber, curve, point }) {
  if (tipNumber !== undefined && tipNumber !== null) return tips[tipNumber];
  const { name, x, y } = data.curves[curve];
  return [name, withUnit(data.y.label, y[point]), withUnit(data.x.label, x[point])].join('\n');
}

/** The drawn point or cross nearest to a position: {left, top, curve, point, tipNumber}. */
function nearestPoint(chart, data, shown, left, top) {
  let best = null;
  let least = reach;
  const offer = (x, y, found) => {
    if (x < -1 || x > chart.over.clientWidth + 1 || y < -1 || y > chart.over.clientHeight + 1) return;
    const away = Math.hypot(x - left, y - top);
    if (away >= least) return;
    least = away;
    best = { ...found, left: x, top: y };
  };
  data.curves.forEach(({ x, y, tips = [], broad }, curve) => {
    if (!shown[curve] || broad) return;
    x.forEach((value, point) => {
      if (value === null || y[point] === null) return;
      offer(chart.valToPos(value, 'x'), chart.valToPos(y[point], 'y'), { curve, point, tipNumber: tips[point] });
    });
  });
  for (const mark of data.edge ?? [])
    if (isShown(data, shown, mark)) offer(chart.valToPos(mark.x, 'x'), 8, { tipNumber: mark.tip });
  return best;
}

const isShown = (data, shown, { curve }) => data.curves.some(({ name }, i) => name === curve && shown[i]);

function tileAt(chart, { tiles = [] }, left, top) {
  const x = chart.posToVal(left, 'x');
  const y = chart.posToVal(top, 'y');
  const tile = tiles.find(([xLow, xHigh, yLow, yHigh]) => x >= xLow && x < xHigh && y >= yLow && y < yHigh);
  return tile ? { tipNumber: tile[5] } : null;
}

// uPlot needs a series, which a map of tiles may lack
const seriesOf = ({ curves }) => [null, ...curves.map(({ x, y }) => [x, y]), ...(curves.length > 0 ? [] : [[[], []]])];

function optionsOf(data, shown, width) {
  const axis = {
    stroke: css('--ink-soft'),
    grid: { stroke: css('--grid-line'), width: 1 },
    ticks: { stroke: css('--grid-line') },
    font: `12px ${css('--sans')}`,
    labelFont: `12px ${css('--sans')}`,
    filter: (_, splits) => splits,
  };
  const scale = ({ log, low, high }) => ({
    time: false,
    distr: log ? 3 : 1,
    auto: false,
    range: (_, from, to) => [from ?? low, to ?? high],
  });
  const ticks = (of, pixels) => ({
    splits: (chart, _, low, high) => ticksOf(of, low, high, Math.max(2, chart.bbox[pixels.side] / uPlot.pxRatio / pixels.each)),
    values: (_, splits) => splits.map((value) => tickText(value, of.log)),
  });
  const whole = (chart) => {
    chart.setScale('x', { min: data.x.low, max: data.x.high });
    chart.setScale('y', { min: data.y.low, max: data.y.high });
  };
  return {
    mode: 2,
    width,
    height: width < 500 ? 330 : 400,
    legend: { show: false },
    padding: [8, 14, null, null],
    cursor: {
      points: { show: false },
      x: false,
      y: false,
      drag: { x: true, y: true, uni: 20 },
      bind: {
        dblclick: (chart) => () => {
          whole(chart);
          return null;
        },
      },
    },
    scales: { x: scale(data.x), y: scale(data.y) },
    axes: [
      { ...axis, ...ticks(data.x, { side: 'width', each: 70 }), label: data.x.label, labelSize: 22, size: 34 },
      { ...axis, ...ticks(data.y, { side: 'height', each: 36 }), size: 64 },
    ],
    series: [
      {},
      ...data.curves.map((curve, i) => ({
        label: curve.name,
        show: shown[i],
        stroke: colourOf(curve.colour),
        points: { show: false },
        paths: (chart) => drawCurve(chart, curve, (data.tiles ?? []).length > 0),
      })),
      ...(data.curves.length > 0 ? [] : [{ paths: () => null }]),
    ],
    hooks: {
      ready: [whole],
      drawAxes: [(chart) => drawTiles(chart, data)],
      draw: [(chart) => drawEdge(chart, (data.edge ?? []).filter((mark) => isShown(data, shown, mark)))],
    },
  };
}

/** The kinds of tiles that occur, the curves shown at first as buttons, the others folded. */
function legendOf(data, shown, toggle) {
  const used = new Set((data.tiles ?? []).map((tile) => tile[4]));
  const kinds = (data.kinds ?? [])
    .filter((_, kind) => used.has(kind))
    .map((kind) => h('span', { class: 'key-item' }, swatchOf(kind), kind.name));
  const button = (curve, i) =>
    h(
      'button',
      { class: 'key-item', 'data-curve': i, 'aria-pressed': String(shown[i]), onclick: () => toggle(i) },
      sampleOf(curve),
      curve.name,
    );
  const [first, more] = [true, false].map((wanted) =>
    data.curves.flatMap((curve, i) => (curve.shown === wanted ? [button(curve, i)] : [])),
  );
  const folded =
    more.length > 0
      ? [h('details', { class: 'more' }, h('summary', {}, `${more.length} more curves`), h('div', { class: 'legend' }, more))]
      : [];
  return [...kinds, ...first, ...folded];
}
