// The histogram of grey values, of the whole scan and of the body, with the tissues' thresholds.
import { fixed, h, onResize } from './dom.js';

const axisNames = {
  hu: ['CT number (HU)', 'HU'],
  density_kgm3: ['mass density (kg/m³)', 'kg/m³'],
  mr: ['signal (arbitrary units)', 'units'],
  labels: ['label', 'labels'],
};
const left = 52;
const right = 14;
const plotHeight = 190;
const rowHeight = 17;
const textWidth = 6.6; // largest width of a letter in the tissues' names

/** `counts` = {low, width, all, body?, below, above, tissues: [{name, to}]} as report.cpp writes it. */
export function makeHistogram(counts, quantity) {
  const [axis, unit] = axisNames[quantity] ?? axisNames.mr;
  const drawing = h('svg', {
    class: 'histogram',
    role: 'img',
    'aria-label': `Voxels by ${axis}, on a logarithmic scale${counts.tissues.length > 0 ? ', with the thresholds between tissues' : ''}`,
  });
  const holder = h('div', {}, drawing);
  const draw = () => {
    const width = holder.clientWidth;
    if (width === 0) return;
    const { low, width: step, all, body } = counts;
    const high = low + step * all.length;
    const x = (value) => left + ((width - left - right) * (value - low)) / (high - low);
    const tissues = bandsOf(counts, low, high, x, width);
    const top = 8 + rowHeight * Math.max(0, ...tissues.map(({ row }) => row + 1));
    const base = top + plotHeight;
    const decades = Math.ceil(Math.log10(Math.max(10, ...all)));
    const y = (count) => base - (plotHeight * Math.log10(Math.max(count, 1))) / decades;
    drawing.setAttribute('width', width);
    drawing.setAttribute('height', base + 42);
    drawing.setAttribute('viewBox', `0 0 ${width} ${base + 42}`);
    drawing.replaceChildren(
      ...countAxis(decades, y, width),
      ...valueAxis(low, high, x, base, axis),
      h('path', { class: 'all-voxels', d: outline(all, low, step, x, y, base) }),
      body ? h('path', { class: 'body-voxels', d: outline(body, low, step, x, y, base) }) : h('g', {}),
      ...thresholds(tissues, x, base),
      h(
        'text',
        {
          class: 'tick',
          x: 0,
          y: 0,
          'text-anchor': 'middle',
          transform: `translate(12 ${base - plotHeight / 2}) rotate(-90)`,
        },
        `voxels per ${step} ${unit}`,
      ),
    );
  };
  onResize(holder, draw);
  const beyond = [
    [counts.below, 'below'],
    [counts.above, 'above'],
  ]
    .filter(([n]) => n > 0)
    .map(([n, where]) => `${n} voxels lie ${where} these values.`)
    .join(' ');
  const element = h(
    'figure',
    { class: 'histogram-figure' },
    h('figcaption', {}, `How often each grey value occurs, on a logarithmic scale. ${beyond}`),
    holder,
    h(
      'p',
      { class: 'key' },
      h('span', {}, h('span', { class: 'swatch all-voxels' }), 'the whole scan'),
      counts.body ? h('span', {}, h('span', { class: 'swatch body-voxels' }), 'the labelled body') : null,
      counts.tissues.length > 0
        ? h('span', {}, h('span', { class: 'swatch threshold' }), 'threshold between tissues')
        : null,
    ),
  );
  return { element, draw };
}

/** The steps of the counts, down to the axis. */
function outline(bins, low, step, x, y, base) {
  let path = `M${x(low).toFixed(1)} ${base}`;
  bins.forEach((count, bin) => {
    const up = count > 0 ? y(count) - 1 : base; // a single voxel is visible too
    path += `V${up.toFixed(1)}H${x(low + step * (bin + 1)).toFixed(1)}`;
  });
  return `${path}V${base}Z`;
}

/**
 * Each tissue within the shown values: {name, from, to, text, at, row}; its text is in the highest row in which
 * neither it nor the line up to it crosses another's.
 */
function bandsOf({ tissues }, low, high, x, width) {
  const bands = [];
  const ends = []; // end of the last text in each row
  let from = null;
  for (const { name, to } of tissues) {
    const band = { name, from, to };
    from = to;
    if ((band.from ?? low) >= high || (to ?? high) <= low) continue;
    band.text =
      band.from === null
        ? `${name} below ${fixed(to, 0)}`
        : to === null
          ? `${name} above ${fixed(band.from, 0)}`
          : `${name} to ${fixed(to, 0)}`;
    const length = band.text.length * textWidth;
    band.at = Math.max(2, Math.min(x(Math.max(band.from ?? low, low)) + 4, width - length - 2));
    band.row = 1 + ends.findLastIndex((end) => end + 8 > band.at);
    ends[band.row] = band.at + length;
    bands.push(band);
  }
  return bands;
}

/** A line at each threshold, up to the text of the tissue above it, or below the text if that was moved to the left. */
function thresholds(bands, x, base) {
  const end = ({ from, at, row }) => 4 + (at > x(from) ? row : row + 1) * rowHeight;
  return bands.flatMap((band) => [
    band.from === null
      ? h('g', {})
      : h('path', { class: 'threshold', d: `M${x(band.from)} ${base}V${end(band)}` }),
    h('text', { class: 'tissue', x: band.at, y: 14 + band.row * rowHeight }, band.text),
  ]);
}

function countAxis(decades, y, width) {
  const marks = [];
  for (let decade = 0; decade <= decades; ++decade) {
    const at = y(10 ** decade);
    marks.push(
      h('line', { class: 'gridline', x1: left, x2: width - right, y1: at, y2: at }),
      h('text', { class: 'tick', x: left - 6, y: at + 4, 'text-anchor': 'end' }, powerOfTen(decade)),
    );
  }
  return marks;
}

const powerOfTen = (decade) =>
  decade < 4 ? String(10 ** decade) : `10${[...String(decade)].map((d) => '⁰¹²³⁴⁵⁶⁷⁸⁹'[Number(d)]).join('')}`;

function valueAxis(low, high, x, base, axis) {
  const span = x(high) - x(low);
  const most = Math.max(2, span / 64);
  const power = 10 ** Math.floor(Math.log10((high - low) / most));
  const step = power * ([1, 2, 5, 10].find((digit) => (high - low) / (digit * power) <= most) ?? 10);
  const marks = [
    h('line', { class: 'axis', x1: x(low), x2: x(high), y1: base, y2: base }),
    h('text', { class: 'tick', x: (x(low) + x(high)) / 2, y: base + 36, 'text-anchor': 'middle' }, axis),
  ];
  for (let value = Math.ceil(low / step) * step; value <= high; value += step)
    marks.push(
      h('line', { class: 'axis', x1: x(value), x2: x(value), y1: base, y2: base + 4 }),
      h('text', { class: 'tick', x: x(value), y: base + 18, 'text-anchor': 'middle' }, fixed(value, 0)),
    );
  return marks;
}
