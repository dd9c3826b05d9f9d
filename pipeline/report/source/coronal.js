// The scan summed from front to back with joint centres and cut planes over it, and the table of the joints.
import { fixed, h, partTitle } from './dom.js';

// CSS pixels: page width from which the joints' table is beside the picture, and the table's width there
const besideTable = 812;
const jointTableWidth = 560;

// the conventions of segmentation/vocabulary/convention.hpp
const conventions = {
  deleva1996: '; its parts are cut after de Leva (1996)',
  dempster: '; its parts are cut after Dempster (1955)',
  bone: '; no plane cuts its parts: each place follows its bone',
};

/**
 * The scan summed from front to back, like a radiograph, with the parts' shadows, the joint centres and the planes
 * that cut the parts: `cuts` = {convention, lines: [{joint, from, to}]} or nothing.
 */
export function makeCoronal(volume, parts, joints, cuts) {
  const [nx, , nz] = volume.size;
  const canvas = h('canvas', {
    role: 'img',
    'aria-label': `The scan summed from front to back with the joint centres${cuts?.lines.length ? ' and the cut planes' : ''}`,
  });
  const drawing = h('svg', { 'aria-hidden': 'true' });
  const frame = h('div', { class: 'coronal-sum' }, canvas, drawing);
  const image = sumAlongDepth(volume, parts);
  canvas.width = nx;
  canvas.height = nz;
  canvas.getContext('2d').putImageData(image, 0, 0);
  const draw = () => {
    const margin = 104; // for the joints' names
    const page = frame.closest('section')?.clientWidth || 600;
    const room = page - 2 * margin - (page > besideTable ? jointTableWidth : 0);
    const scale = Math.min(620 / (nz * volume.step), Math.min(room, 420) / (nx * volume.step));
    const height = nz * volume.step * scale;
    const width = nx * volume.step * scale;
    canvas.style.width = `${width}px`;
    canvas.style.height = `${height}px`;
    canvas.style.marginLeft = canvas.style.marginRight = `${margin}px`;
    drawing.setAttribute('width', width + 2 * margin);
    drawing.setAttribute('height', height);
    const place = ([x, , z]) => [
      margin + ((x - volume.origin[0]) / volume.step + 0.5) * volume.step * scale,
      height - ((z - volume.origin[2]) / volume.step + 0.5) * volume.step * scale,
    ];
    drawing.replaceChildren(
      ...cutMarks(cuts?.lines ?? [], place),
      ...jointMarks(joints, place, { width, height, margin }),
    );
  };
  const element = h(
    'figure',
    {},
    h(
      'figcaption',
      {},
      `The scan summed from front to back, coloured by part${conventions[cuts?.convention] ?? ''}`,
    ),
    frame,
    h(
      'p',
      { class: 'key coronal-key' },
      keyOf(h('circle', { class: 'joint', cx: 11, cy: 8, r: 4.5 }), 'joint centre'),
      cuts?.lines.length ? keyOf(cutLine('M2 11L20 5'), 'cut plane') : null,
    ),
  );
  return { element, redraw: draw };
}

const keyOf = (mark, text) =>
  h('span', {}, h('svg', { class: 'on-scan', width: 22, height: 16, 'aria-hidden': 'true' }, mark), text);

function sumAlongDepth(volume, parts) {
  const [nx, ny, nz] = volume.size;
  const sums = new Float32Array(nx * nz);
  const front = new Uint8Array(nx * nz); // the part nearest the front
  for (let k = 0; k < nz; ++k)
    for (let j = 0; j < ny; ++j)
      for (let i = 0; i < nx; ++i) {
        const at = volume.at(i, j, k);
        const to = (nz - 1 - k) * nx + i;
        const label = volume.labels ? volume.labels[at] : 1;
        if (label === 0) continue;
        sums[to] += volume.grey ? volume.grey[at] ** 2 : 1; // squared, so that bone stands out
        if (!front[to]) front[to] = label;
      }
  let top = 1;
  for (const sum of sums) top = Math.max(top, sum);
  const colours = [];
  if (volume.labels)
    for (const { label, colour } of parts)
      colours[label] = [1, 3, 5].map((c) => parseInt(colour.slice(c, c + 2), 16));
  const image = new ImageData(nx, nz);
  for (let at = 0; at < sums.length; ++at) {
    const shade = 12 + 243 * (sums[at] / top) ** 0.4;
    const colour = colours[front[at]];
    for (let c = 0; c < 3; ++c)
      image.data[4 * at + c] = colour && sums[at] > 0 ? shade * (0.55 + 0.45 * (colour[c] / 255)) : shade;
    image.data[4 * at + 3] = 255;
  }
  return image;
}

/** A yellow line with a dark outline, visible on bone and outside the body. */
const cutLine = (path, title) =>
  h(
    'g',
    { class: 'cut-plane' },
    title ? h('title', {}, title) : null,
    h('path', { class: 'casing', d: path }),
    h('path', { class: 'core', d: path }),
  );

function cutMarks(lines, place) {
  return lines.map(({ joint, from, to }) => {
    const [[x1, y1], [x2, y2]] = [place(from), place(to)];
    return cutLine(`M${x1} ${y1}L${x2} ${y2}`, `${partTitle(joint)}: cut plane`);
  });
}

/** A ring at each joint centre, with a line to its name at the nearer side; names do not overlap. */
function jointMarks(joints, place, { width, height, margin }) {
  const placed = joints.map((joint) => {
    const [x, y] = place(joint.point);
    return { ...joint, x, y };
  });
  const marks = [];
  for (const side of ['left', 'right']) {
    const atSide = placed
      .filter((j) => (j.x < margin + width / 2 - 1 ? 'left' : 'right') === side)
      .sort((a, b) => a.y - b.y);
    spread(atSide, 17, height);
    for (const { name, x, y, textY } of atSide) {
      const end = side === 'left' ? margin - 6 : margin + width + 6;
      marks.push(
        h('path', { class: 'leader', d: `M${x} ${y} L${end} ${textY}` }),
        h('circle', { class: 'joint', cx: x, cy: y, r: 4.5 }),
        h(
          'text',
          {
            x: side === 'left' ? end - 4 : end + 4,
            y: textY + 4,
            'text-anchor': side === 'left' ? 'end' : 'start',
          },
          partTitle(name),
        ),
      );
    }
  }
  return marks;
}

/** Gives each mark a textY at least `gap` from the next, near its y. */
function spread(marks, gap, height) {
  let last = -Infinity;
  for (const mark of marks) last = mark.textY = Math.max(mark.y, last + gap);
  let next = height - 8;
  for (const mark of marks.toReversed()) next = (mark.textY = Math.min(mark.textY, next)) - gap;
}

export function jointTable(joints) {
  return h(
    'table',
    { class: 'numbers joints' },
    h(
      'caption',
      {},
      'Joint centres in the patient frame (mm; x to the left, y to the back, z up) and how each was found',
    ),
    h(
      'thead',
      {},
      h(
        'tr',
        {},
        ['Joint', 'x', 'y', 'z', 's.d.', 'Found by'].map((t, i) =>
          h('th', { scope: 'col', class: i > 0 && i < 5 ? 'number' : '' }, t),
        ),
      ),
    ),
    h(
      'tbody',
      {},
      joints.map(({ name, point, deviation, source }) =>
        h(
          'tr',
          {},
          h('th', { scope: 'row' }, partTitle(name)),
          point.map((c) => h('td', { class: 'number' }, fixed(c, 1))),
          h('td', { class: 'number' }, deviation > 0 ? `± ${fixed(deviation, 1)}` : '–'),
          h('td', { class: 'words' }, source),
        ),
      ),
    ),
  );
}
