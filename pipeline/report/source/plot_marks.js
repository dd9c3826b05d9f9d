// Draws a plot's contents within its axes: curves with dots, squares and triangles, crosses at the upper edge, tiles.
import { css, darkScheme, h } from './dom.js';

// colours of plot_style.cpp that are invisible on a dark page
const onDark = {
  '#0072B2': '#4c9be8',
  '#000000': '#f0f0f0',
  '#F5EDA0': '#6f6523',
  '#E6F3EC': '#1f3a2c',
  '#1A1A1A': '#f2f2f2',
  '#FFFFFF': '#22262c',
  '#D9D9D9': '#464c55',
};

export const colourOf = (colour) => (darkScheme.matches && onDark[colour]) || colour;

const dashOf = ({ dash }) => (dash === 'none' ? [] : dash.split(' ').map(Number));

/** Draws within the axes; `pen` paints in device pixels, `unit` of them are a CSS pixel. */
function within(chart, draw) {
  const { ctx, bbox } = chart;
  ctx.save();
  ctx.beginPath();
  ctx.rect(bbox.left, bbox.top, bbox.width, bbox.height);
  ctx.clip();
  draw(ctx, window.devicePixelRatio);
  ctx.restore();
}

const at = (chart, x, y) => [chart.valToPos(x, 'x', true), chart.valToPos(y, 'y', true)];

/** A uPlot path builder that draws at once and returns no path. `halo`: an outline against the tiles behind. */
export function drawCurve(chart, curve, halo) {
  within(chart, (pen, unit) => {
    const line = (colour, width, dash) => {
      pen.strokeStyle = colour;
      pen.lineWidth = width * unit;
      pen.lineJoin = 'round';
      pen.lineCap = curve.broad ? 'round' : 'butt';
      pen.setLineDash(dash.map((length) => length * unit));
      pen.beginPath();
      let broken = true;
      curve.x.forEach((x, i) => {
        const y = curve.y[i];
        if (x === null || y === null) return void (broken = true);
        const [u, v] = at(chart, x, y);
        if (!Number.isFinite(u) || !Number.isFinite(v)) return void (broken = true);
        if (broken) pen.moveTo(u, v);
        pen.lineTo(u, v);
        broken = false;
      });
      pen.stroke();
    };
    if (halo) line(css('--paper'), 4.5, []);
    line(colourOf(curve.colour), curve.broad ? 9 : 1.7, dashOf(curve));
    if (!curve.marks) return;
    pen.setLineDash([]);
    pen.lineWidth = unit;
    pen.strokeStyle = colourOf(curve.colour);
    const hollow = new Set(curve.hollow);
    curve.x.forEach((x, i) => {
      if (x === null || curve.y[i] === null) return;
      pen.fillStyle = hollow.has(i) ? css('--paper') : colourOf(curve.colour);
      const [u, v] = at(chart, x, curve.y[i]);
      if (!Number.isFinite(u) || !Number.isFinite(v)) return;
      pen.beginPath();
      outline(pen, curve.shape, u, v, unit);
      pen.fill();
      pen.stroke();
    });
  });
  return null;
}

function outline(pen, shape, u, v, unit) {
  if (shape === 0) return void pen.arc(u, v, 3.2 * unit, 0, 2 * Math.PI);
  if (shape === 1) return void pen.rect(u - 3 * unit, v - 3 * unit, 6 * unit, 6 * unit);
  pen.moveTo(u, v - 4.2 * unit);
  pen.lineTo(u + 3.8 * unit, v + 2.4 * unit);
  pen.lineTo(u - 3.8 * unit, v + 2.4 * unit);
  pen.closePath();
}

/** Runs without a value. */
export function drawEdge(chart, marks) {
  if (marks.length === 0) return;
  within(chart, (pen, unit) => {
    pen.strokeStyle = css('--ink');
    pen.lineWidth = 1.2 * unit;
    pen.beginPath();
    for (const { x } of marks) {
      const u = Math.min(Math.max(chart.valToPos(x, 'x', true), chart.bbox.left + 6 * unit), chart.bbox.left + chart.bbox.width - 6 * unit);
      const v = chart.bbox.top + 8 * unit;
      pen.moveTo(u - 4 * unit, v - 4 * unit);
      pen.lineTo(u + 4 * unit, v + 4 * unit);
      pen.moveTo(u - 4 * unit, v + 4 * unit);
      pen.lineTo(u + 4 * unit, v - 4 * unit);
    }
    pen.stroke();
  });
}

export function drawTiles(chart, { tiles = [], kinds = [] }) {
  if (tiles.length === 0) return;
  within(chart, (pen) => {
    const fills = kinds.map((kind) => fillOf(pen, kind));
    for (const [xLow, xHigh, yLow, yHigh, kind] of tiles) {
      const [left, bottom] = at(chart, xLow, yLow).map(Math.round);
      const [right, top] = at(chart, xHigh, yHigh).map(Math.round);
      pen.fillStyle = fills[kind];
      pen.fillRect(left, top, right - left, bottom - top);
    }
  });
}

/** A colour, or a square of it with its hatching as a pattern. */
function fillOf(pen, { colour, hatch }) {
  if (!hatch) return colourOf(colour);
  const unit = window.devicePixelRatio;
  const square = document.createElement('canvas');
  square.width = square.height = Math.round(8 * unit);
  const ink = square.getContext('2d');
  ink.fillStyle = colourOf(colour);
  ink.fillRect(0, 0, square.width, square.height);
  ink.scale(square.width / 8, square.height / 8);
  ink.strokeStyle = hatchColour();
  ink.lineWidth = 0.8;
  ink.stroke(new Path2D(hatch));
  return pen.createPattern(square, 'repeat');
}

const hatchColour = () => (darkScheme.matches ? '#cfd3d9' : '#333333');

/** A curve's line and mark, for the legend. */
export function sampleOf(curve) {
  const colour = colourOf(curve.colour);
  const shapes = [
    () => h('circle', { cx: 14, cy: 7, r: 3.2, fill: colour }),
    () => h('rect', { x: 11, y: 4, width: 6, height: 6, fill: colour }),
    () => h('path', { d: 'M14 2.8l3.8 6.6h-7.6z', fill: colour }),
  ];
  return h(
    'svg',
    { width: 28, height: 14, viewBox: '0 0 28 14', 'aria-hidden': 'true' },
    h('path', {
      d: 'M1 7h26',
      fill: 'none',
      stroke: colour,
      'stroke-width': curve.broad ? 8 : 1.7,
      'stroke-dasharray': curve.dash,
    }),
    curve.marks ? shapes[curve.shape]() : null,
  );
}

/** A tile's colour and hatching, for the legend. */
export const swatchOf = ({ colour, hatch }) =>
  h(
    'svg',
    { class: 'tile-sample', width: 18, height: 12, viewBox: '0 0 18 12', 'aria-hidden': 'true' },
    h('rect', { width: 18, height: 12, fill: colourOf(colour) }),
    hatch
      ? [0, 8, 16].flatMap((x) =>
          [0, 8].map((y) =>
            h('path', { d: hatch, fill: 'none', stroke: hatchColour(), 'stroke-width': 0.8, transform: `translate(${x} ${y})` }),
          ),
        )
      : null,
  );
