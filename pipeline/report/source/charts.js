// The motion's energies and multipliers over time, by uPlot; a click moves the body to that moment.
import uPlot from 'uplot';
import { css, darkScheme, fixed, h, onResize, seconds, significant } from './dom.js';

// Okabe & Ito's colours, which colour-blind readers can distinguish; each with its own dashes for grey print.
const okabeIto = ['#0072b2', '#e69f00', '#009e73', '#cc79a7', '#56b4e9', '#d55e00'];
const stroke = (i) =>
  okabeIto[darkScheme.matches && i % 6 === 0 ? 4 : darkScheme.matches && i % 6 === 4 ? 0 : i % 6]; // the dark blue not on black
const dashes = [[], [9, 4], [3, 3], [9, 3, 2, 3], [14, 4], [2, 5]];

const sideNumbers = { left: 0, right: 5, '': 2 };

/** Colour of a body's side, or of sideless quantities, in every chart and in the player. */
export const sideColour = (side) => stroke(sideNumbers[side]);

/**
 * A line chart: `curves` are {name, values, colour? (its number), side? (for its colour), band? (half its height at each
 * time)}, over `times`; `unit` stands at the axis, with an SI prefix unless `plain`. `onTime` (if given) registers a
 * listener for the player's time, which is 0 at `origin`; `seek` is called with the time that was clicked, with `scrub`
 * also while dragging. Charts of one `sync` share the pointer's time.
 */
export function makeChart({
  title,
  unit,
  times,
  curves,
  onTime,
  seek,
  origin = times[0],
  plain = false,
  scrub = false,
  sync = 'motion',
  height = 230,
}) {
  const holder = h('div', { class: 'chart-holder' });
  const [prefix, factor] = !plain && unit.includes('(') ? prefixOf(curves) : ['', 1];
  const drawn = curves.map((c) => c.values.map((v) => (v === null ? null : v * factor)));
  const edges = curves.flatMap((c) => (c.band ? edgesOf(c) : []));
  const now = h('div', { class: 'now', 'aria-hidden': 'true' });
  let plot = null;
  let time = 0;
  const mark = () => {
    if (!plot) return;
    const x = plot.valToPos(origin + time, 'x');
    now.style.transform = `translateX(${x}px)`;
    now.hidden = scrub ? origin + time < times[0] || origin + time > times.at(-1) : !(time > 0);
    if (scrub) readHere();
  };
  // the legend gives the values at the pointer, else at the player's time
  const readHere = () => {
    if (plot && !(plot.cursor.left >= 0)) plot.setLegend({ idx: nearest(times, origin + time) }, false);
  };
  const draw = () => {
    if (holder.clientWidth === 0) return;
    plot?.destroy();
    plot = new uPlot(
      options(
        holder.clientWidth,
        height,
        unit.includes('(') ? unit.replace('(', `(${prefix}`) : unit,
        curves,
        { sync, scrub },
      ),
      [times, ...drawn, ...edges],
      holder,
    );
    plot.over.append(now);
    if (scrub && seek) dragToSeek(plot, (at) => seek(at - origin));
    else
      plot.over.addEventListener('click', () => {
        const { idx } = plot.cursor;
        if (seek && idx !== null && idx !== undefined) seek(times[idx] - origin);
      });
    if (scrub) plot.over.addEventListener('mouseleave', readHere);
    queueMicrotask(mark); // after uPlot's own first drawing, which clears the legend
  };
  const showTime = (to) => {
    time = to;
    mark();
  };
  onTime?.(showTime);
  onResize(holder, draw);
  darkScheme.addEventListener('change', draw);
  const remove = () => {
    darkScheme.removeEventListener('change', draw);
    plot?.destroy();
    plot = null;
  };
  const element = h('figure', { class: 'chart' }, h('figcaption', {}, title), holder);
  return { element, draw, showTime, remove };
}

/** Upper and lower edge of a curve's band. */
const edgesOf = ({ values, band }) =>
  [1, -1].map((sign) => values.map((v, i) => (v === null || band[i] === null ? null : v + sign * band[i])));

const nearest = (times, time) =>
  times.reduce((best, t, i) => (Math.abs(t - time) < Math.abs(times[best] - time) ? i : best), 0);

/** Calls `seek` with the time under the pointer, at a press and while it is dragged. */
function dragToSeek(plot, seek) {
  const { over } = plot;
  over.style.touchAction = 'pan-y';
  const go = (event) => {
    const { left, width } = over.getBoundingClientRect();
    seek(plot.posToVal(Math.min(Math.max(event.clientX - left, 0), width), 'x'));
  };
  over.addEventListener('pointerdown', (event) => {
    if (event.button !== 0) return;
    over.setPointerCapture(event.pointerId);
    go(event);
  });
  over.addEventListener('pointermove', (event) => {
    if (over.hasPointerCapture(event.pointerId)) go(event);
  });
}

/** A line at zero, darker than the grid's. */
function drawZero(plot) {
  const { ctx, bbox } = plot;
  const y = Math.round(plot.valToPos(0, 'y', true)) + 0.5;
  if (y < bbox.top || y > bbox.top + bbox.height) return;
  ctx.save();
  ctx.strokeStyle = css('--ink-soft');
  ctx.lineWidth = 1;
  ctx.beginPath();
  ctx.moveTo(bbox.left, y);
  ctx.lineTo(bbox.left + bbox.width, y);
  ctx.stroke();
  ctx.restore();
}

/** The series of the bands' edges, which follow the curves' own, and the fills between them. */
function bandOptions(curves, colours) {
  const banded = curves.flatMap(({ band }, i) => (band ? [i] : []));
  const edge = { class: 'band', width: 0, points: { show: false } };
  return {
    series: banded.flatMap(() => [edge, edge].map((one) => ({ ...one }))),
    bands: banded.map((curve, i) => ({
      series: [curves.length + 1 + 2 * i, curves.length + 2 + 2 * i],
      fill: `${colours[curve]}3d`, // a quarter opaque
    })),
  };
}

function options(width, height, unit, curves, { sync, scrub }) {
  const colours = curves.map(({ side, colour }, i) =>
    side === undefined ? stroke(colour ?? i) : sideColour(side),
  );
  const { series: edges, bands } = bandOptions(curves, colours);
  const ink = css('--ink-soft');
  const axis = {
    stroke: ink,
    grid: { stroke: css('--grid-line'), width: 1 },
    ticks: { stroke: css('--grid-line') },
    font: `12px ${css('--sans')}`,
    labelFont: `12px ${css('--sans')}`,
  };
  const shown = (value, digits) => (value === null || value === undefined ? '–' : significant(value, digits));
  return {
    width,
    height,
    cursor: { sync: { key: sync }, points: { size: 7 }, ...(scrub ? { drag: { x: false, y: false } } : {}) },
    ...(scrub ? { hooks: { drawAxes: [drawZero] } } : {}),
    bands,
    legend: { live: true },
    scales: { x: { time: false } },
    axes: [
      { ...axis, label: 'time (s)', labelSize: 22, size: 34 },
      { ...axis, label: unit, labelSize: 20, size: 62, values: (_, ticks) => ticks.map(tick) },
    ],
    series: [
      {
        label: 'time',
        value: (_, v) => (v === null || v === undefined ? '–' : scrub ? `${fixed(v, 2)} s` : seconds(v)),
      },
      ...curves.map(({ name }, i) => ({
        label: name,
        stroke: colours[i],
        width: 2,
        dash: dashes[i % dashes.length],
        pxAlign: 0,
        points: { show: false },
        value: (_, v) => shown(v, scrub ? 3 : 5),
      })),
      ...edges,
    ],
  };
}

/** The SI prefix in which the curves' largest value has one to three digits before the point. */
function prefixOf(curves) {
  const largest = Math.max(...curves.map((c) => c.values.reduce((m, v) => Math.max(m, Math.abs(v ?? 0)), 0)));
  const prefixes = [
    ['k', 1e-3],
    ['', 1],
    ['m', 1e3],
    ['µ', 1e6],
    ['n', 1e9],
    ['p', 1e12],
    ['f', 1e15],
  ];
  if (largest === 0 || largest >= 1e4) return largest === 0 ? prefixes[1] : prefixes[0];
  return prefixes.slice(1).find(([, factor]) => largest * factor >= 1) ?? prefixes.at(-1);
}

const tick = (value) => String(Number(value.toPrecision(6))).replace('-', '−');

/** Charts of a motion {times, kinetic, potential, work, multipliers: [{name, values}]}. */
export function motionCharts(motion, player) {
  const { times, kinetic, potential, work } = motion;
  const total = kinetic.map((k, i) => k + potential[i]);
  const start = total[0];
  const balance = total.map((e, i) => e - start - (work?.[i] ?? 0));
  const anyWork = work?.some((w) => w !== 0);
  const shared = { times, onTime: player?.onTime, seek: player?.seek };
  const charts = [
    makeChart({
      ...shared,
      title: 'Energy, from the start',
      unit: 'energy (J)',
      curves: [
        { name: 'kinetic', values: kinetic.map((k) => k - kinetic[0]), colour: 0 },
        { name: 'potential', values: potential.map((p) => p - potential[0]), colour: 1 },
        { name: 'total', values: total.map((e) => e - start), colour: 2 },
        ...(anyWork ? [{ name: 'work', values: work, colour: 3 }] : []),
      ],
    }),
    makeChart({
      ...shared,
      title: anyWork
        ? 'Energy not accounted for: total − start − work'
        : 'Energy not accounted for: total − start',
      unit: 'drift (J)',
      curves: [{ name: 'drift', values: balance, colour: 5 }],
    }),
  ];
  for (const { unit, rows } of multiplierGroups(motion.multipliers ?? [])) {
    charts.push(
      makeChart({ ...shared, title: 'Constraint forces', unit, curves: rows.slice(0, 6) }),
    );
  }
  return charts;
}

const multiplierGroups = (rows) => (rows.length > 0 ? [{ unit: 'N or N m', rows }] : []);
