// Segment masses as bars, with the published ones as marks on them.
import { fixed, h, onResize, partTitle, significant } from './dom.js';

const rowHeight = 26;
// de Leva's masses are Zatsiorsky's, so the two marks would coincide in most rows
const closest = 5; // pixels
const marks = [
  {
    key: 'deleva',
    draw: (x, y) =>
      h('path', { class: 'mark filled', d: `M${x} ${y - 6} L${x + 6} ${y} L${x} ${y + 6} L${x - 6} ${y} Z` }),
  },
  { key: 'dumas', draw: (x, y) => h('circle', { class: 'mark open', cx: x, cy: y, r: 4.6 }) },
  {
    key: 'winter',
    draw: (x, y) => h('rect', { class: 'mark open', x: x - 4, y: y - 4, width: 8, height: 8 }),
  },
  {
    key: 'zatsiorsky',
    hiddenBy: 'deleva', // drawn only if it is apart from that mark
    draw: (x, y) =>
      h('path', { class: 'mark filled', d: `M${x} ${y - 5.5} L${x + 5.5} ${y + 4.5} L${x - 5.5} ${y + 4.5} Z` }),
  },
];

/** `rows` from rowsOf(), `names` the published tables' titles, `whole` the reference of the percentages. */
export function makeMassChart(rows, names, whole) {
  const drawing = h('svg', {
    class: 'masses',
    role: 'img',
    'aria-label': `Mass of each part in percent of ${whole}, beside published values`,
  });
  const draw = () => {
    const width = drawing.parentElement?.clientWidth ?? 0;
    if (width === 0) return;
    const left = 132;
    const roomy = width > 520; // room for a value's deviation in words
    const right = roomy && rows.some(hasDeviation) ? 112 : 66;
    const used = marks.filter(({ key }) => rows.some((row) => Number.isFinite(row.published[key]?.mass)));
    const largest = Math.max(
      1,
      ...rows.flatMap((r) => [(r.share || 0) + (r.shareDeviation || 0), ...used.map(({ key }) => r.published[key]?.mass || 0)]),
    );
    const step = [0.5, 1, 2, 5, 10, 20].find((s) => largest / s <= 8) ?? 20;
    const high = Math.ceil((largest * 1.02) / step) * step;
    const x = (share) => left + ((width - left - right) * share) / high;
    const height = rows.length * rowHeight + 44;
    drawing.setAttribute('width', width);
    drawing.setAttribute('height', height);
    drawing.setAttribute('viewBox', `0 0 ${width} ${height}`);
    drawing.replaceChildren(
      cutPattern(),
      ...axisOf(x, high, step, height, whole),
      ...rows.flatMap((row, i) => barOf(row, i, x, used, names, width, roomy)),
    );
  };
  const holder = h('div', {}, drawing);
  onResize(holder, draw);
  const key = h(
    'p',
    { class: 'key' },
    h('span', {}, h('span', { class: 'swatch neutral' }), 'this body'),
    marks
      .filter(({ key: k }) => rows.some((row) => Number.isFinite(row.published[k]?.mass)))
      .map(({ key: k, hiddenBy, draw: mark }) =>
        h(
          'span',
          {},
          h('svg', { width: 14, height: 14, 'aria-hidden': 'true' }, mark(7, 7)),
          names[k] ?? k,
          hiddenBy && rows.some((row) => Number.isFinite(row.published[hiddenBy]?.mass))
            ? ` (if it differs from ${names[hiddenBy] ?? hiddenBy})`
            : '',
        ),
      ),
    rows.some(hasDeviation)
      ? h(
          'span',
          {},
          h('svg', { class: 'masses', width: 26, height: 14, 'aria-hidden': 'true' }, errorBar(3, 23, 7)),
          '± one standard deviation',
        )
      : null,
    rows.some((r) => r.completeness === 'cut')
      ? h('span', {}, h('span', { class: 'swatch hatched' }), 'cut off by the scan')
      : null,
  );
  return {
    element: h(
      'figure',
      { class: 'mass-chart' },
      h('figcaption', {}, `Mass of each part, in percent of ${whole}`),
      holder,
      key,
    ),
    draw,
  };
}

const hasDeviation = (row) => Number.isFinite(row.share) && row.shareDeviation > 0;

/** An error bar from x1 to x2, with an outline that separates it from the bar below. */
const errorBar = (x1, x2, y) => {
  const path = `M${x1} ${y}H${x2}M${x1} ${y - 3}V${y + 3}M${x2} ${y - 3}V${y + 3}`;
  return h(
    'g',
    { class: 'error-bar' },
    h('path', { class: 'casing', d: path }),
    h('path', { class: 'core', d: path }),
  );
};

const cutPattern = () =>
  h(
    'defs',
    {},
    h(
      'pattern',
      { id: 'cut', width: 6, height: 6, patternUnits: 'userSpaceOnUse', patternTransform: 'rotate(45)' },
      h('rect', { width: 2.4, height: 6, class: 'hatch' }),
    ),
  );

function axisOf(x, high, step, height, whole) {
  const base = height - 38;
  const ticks = [];
  for (let share = 0; share <= high + 1e-9; share += step) ticks.push(share);
  return [
    ...ticks.flatMap((share) => [
      h('line', { class: 'gridline', x1: x(share), x2: x(share), y1: 4, y2: base }),
      h(
        'text',
        { class: 'tick', x: x(share), y: base + 16, 'text-anchor': 'middle' },
        significantShare(share),
      ),
    ]),
    h(
      'text',
      { class: 'tick', x: x(high / 2), y: base + 34, 'text-anchor': 'middle' },
      `percent of ${whole}`,
    ),
  ];
}

const significantShare = (share) => String(Number(share.toFixed(2)));

function barOf(row, index, x, used, names, width, roomy) {
  const y = 6 + index * rowHeight;
  const middle = y + rowHeight / 2 - 1;
  const known = Number.isFinite(row.share);
  const spread = roomy && hasDeviation(row) ? ` ± ${fixed(row.shareDeviation, 2)}` : '';
  const value = known ? `${fixed(row.share, 2)}${spread} %` : row.completeness === 'absent' ? 'absent' : '–';
  const said = used
    .map(({ key }) =>
      Number.isFinite(row.published[key]?.mass) ? `, ${names[key] ?? key} ${fixed(row.published[key]?.mass, 2)} %` : '',
    )
    .join('');
  return [
    h(
      'g',
      {},
      h(
        'title',
        {},
        `${partTitle(row.name)}: ${value}${said}${known ? `, ${significant(row.mass, 4)}${row.massDeviation > 0 ? ` ± ${significant(row.massDeviation, 2)}` : ''} kg` : ''}`,
      ),
      h('text', { class: 'row-name', x: 122, y: middle + 4, 'text-anchor': 'end' }, partTitle(row.name)),
      known
        ? h('rect', {
            x: x(0),
            y: y + 4,
            width: Math.max(0, x(row.share) - x(0)),
            height: rowHeight - 10,
            rx: 2,
            fill: row.colour,
          })
        : null,
      known && row.completeness === 'cut'
        ? h('rect', {
            x: x(0),
            y: y + 4,
            width: x(row.share) - x(0),
            height: rowHeight - 10,
            rx: 2,
            fill: 'url(#cut)',
          })
        : null,
      hasDeviation(row)
        ? errorBar(
            x(Math.max(0, row.share - row.shareDeviation)),
            x(row.share + row.shareDeviation),
            middle + 7, // clear of the published marks
          )
        : null,
      // the first, de Leva's, on top
      [...used].reverse().map(({ key, hiddenBy, draw }) => {
        const at = x(row.published[key]?.mass);
        const other = hiddenBy ? x(row.published[hiddenBy]?.mass) : NaN;
        return Number.isFinite(at) && !(Math.abs(at - other) < closest) ? draw(at, middle) : null;
      }),
      h('text', { class: 'row-value', x: width - 4, y: middle + 4, 'text-anchor': 'end' }, value),
    ),
  ];
}
