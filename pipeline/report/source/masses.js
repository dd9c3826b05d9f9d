// Segment masses as bars, with the published ones as marks on them.
import { fixed, h, onResize, partTitle, significant } from './dom.js';

const rowHeight = 26;
const marks = [
  {
    key: 'deleva',
    draw: (x, y) =>
      h('path', { class: 'mark filled', d: `M${x} ${y - 6} L${x + 6} ${y} L${x} ${y + 6} L${x - 6} ${y} Z` }),
  },
  { key: 'dumas', draw: (x, y) => h('circle', { class: 'mark open', cx: x, cy: y, r: 4.6 }) },
];

/** `rows` as rowsOf() gives them, `names` the published tables' titles, `whole` what the percents are of. */
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
    const right = 66;
    const used = marks.filter(({ key }) => rows.some((row) => Number.isFinite(row.published[key]?.mass)));
    const largest = Math.max(
      1,
      ...rows.flatMap((r) => [r.share || 0, ...used.map(({ key }) => r.published[key]?.mass || 0)]),
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
      ...rows.flatMap((row, i) => barOf(row, i, x, used, width)),
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
      .map(({ key: k, draw: mark }) =>
        h('span', {}, h('svg', { width: 14, height: 14, 'aria-hidden': 'true' }, mark(7, 7)), names[k] ?? k),
      ),
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

function barOf(row, index, x, used, width) {
  const y = 6 + index * rowHeight;
  const middle = y + rowHeight / 2 - 1;
  const known = Number.isFinite(row.share);
  const value = known ? `${fixed(row.share, 2)} %` : row.completeness === 'absent' ? 'absent' : '–';
  const said = used
    .map(({ key }) =>
      Number.isFinite(row.published[key]?.mass) ? `, ${key} ${fixed(row.published[key]?.mass, 2)} %` : '',
    )
    .join('');
  return [
    h(
      'g',
      {},
      h(
        'title',
        {},
        `${partTitle(row.name)}: ${value}${said}${known ? `, ${significant(row.mass, 4)} kg` : ''}`,
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
      used.map(({ key, draw }) =>
        Number.isFinite(row.published[key]?.mass) ? draw(x(row.published[key]?.mass), middle) : null,
      ),
      h('text', { class: 'row-value', x: width - 4, y: middle + 4, 'text-anchor': 'end' }, value),
    ),
  ];
}
