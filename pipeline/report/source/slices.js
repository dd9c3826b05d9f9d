// Three orthogonal slices of the scan with the parts over it.
import { fixed, h, onResize, partTitle } from './dom.js';
import { drawPlane, planes, windowsOf } from './volume.js';

const names = { coronal: 'Coronal', sagittal: 'Sagittal', axial: 'Axial' };

export function makeSlices(volume, parts) {
  const colours = [];
  const titles = [];
  for (const { label, name, colour } of parts) {
    colours[label] = [1, 3, 5].map((at) => parseInt(colour.slice(at, at + 2), 16));
    titles[label] = partTitle(name);
  }
  const windows = windowsOf(volume);
  const look = { ...Object.values(windows)[0], opacity: volume.labels ? 0.35 : 0, outlines: true };
  const cursor = middleOf(volume);
  const reading = h('output', { class: 'reading' });
  const views = {};
  const redraw = (which = Object.keys(planes)) => {
    which.forEach((plane) => views[plane].draw());
    Object.values(views).forEach((view) => view.cross());
    reading.textContent = describe(volume, cursor, titles);
  };
  for (const plane of Object.keys(planes))
    views[plane] = makeView(volume, plane, cursor, look, colours, redraw);

  const element = h(
    'div',
    { class: 'slices' },
    Object.entries(views).map(([plane, view]) =>
      h('figure', { class: `view ${plane}` }, h('figcaption', {}, names[plane]), view.frame, view.slider),
    ),
    h('div', { class: 'slice-controls' }, controlsOf(volume, windows, look, redraw), reading),
  );
  const fit = () => {
    layOut(element, volume, views);
    redraw();
  };
  onResize(element, fit);
  return { element, redraw: fit };
}

function makeView(volume, plane, cursor, look, colours, redraw) {
  const { held, across, down, flip, letters } = planes[plane];
  const canvas = h('canvas', {
    role: 'img',
    'aria-label': `${names[plane]} slice of the scan with the parts over it`,
  });
  const lineAcross = h('div', { class: 'cross across' });
  const lineDown = h('div', { class: 'cross down' });
  const frame = h(
    'div',
    { class: 'slice' },
    canvas,
    lineAcross,
    lineDown,
    ['left', 'right', 'top', 'bottom'].map((side, i) =>
      h('span', { class: `letter ${side}`, 'aria-hidden': 'true' }, letters[i]),
    ),
  );
  const slider = h('input', {
    type: 'range',
    min: 0,
    max: volume.size[held] - 1,
    step: 1,
    value: cursor[held],
    'aria-label': `Position of the ${plane} slice`,
    oninput: () => {
      cursor[held] = Number(slider.value);
      redraw([plane]);
    },
  });
  const others = Object.keys(planes).filter((other) => other !== plane);
  const point = (event) => {
    const box = canvas.getBoundingClientRect();
    const u = Math.floor(((event.clientX - box.left) / box.width) * volume.size[across]);
    const v = Math.floor(((event.clientY - box.top) / box.height) * volume.size[down]);
    cursor[across] = Math.min(Math.max(u, 0), volume.size[across] - 1);
    cursor[down] = Math.min(Math.max(flip ? volume.size[down] - 1 - v : v, 0), volume.size[down] - 1);
    redraw(others);
  };
  frame.addEventListener('pointerdown', (event) => {
    frame.setPointerCapture(event.pointerId);
    point(event);
  });
  frame.addEventListener('pointermove', (event) => {
    if (event.buttons & 1) point(event);
  });
  const view = {
    frame,
    slider,
    plane,
    millimetres: [volume.size[across] * volume.step, volume.size[down] * volume.step],
    /** Sets the size on screen, pixels per millimetre. */
    fit(scale) {
      canvas.style.width = `${view.millimetres[0] * scale}px`;
      canvas.style.height = `${view.millimetres[1] * scale}px`;
      slider.style.width = canvas.style.width;
      view.zoom = Math.min(4, Math.max(1, Math.round(volume.step * scale * window.devicePixelRatio)));
    },
    draw() {
      const image = drawPlane(volume, plane, cursor[held], view.zoom ?? 2, look, colours);
      canvas.width = image.width;
      canvas.height = image.height;
      canvas.getContext('2d').putImageData(image, 0, 0);
    },
    cross() {
      slider.value = cursor[held];
      slider.setAttribute(
        'aria-valuetext',
        `${fixed(volume.millimetres(held, cursor[held]), 0)} millimetres`,
      );
      const place = (axis) => (cursor[axis] + 0.5) / volume.size[axis];
      lineDown.style.left = `${100 * place(across)}%`;
      lineAcross.style.top = `${100 * (flip ? 1 - place(down) : place(down))}%`;
    },
  };
  return view;
}

/** Coronal and sagittal side by side at one scale, the axial beside them, or below on a narrow page. */
function layOut(element, volume, views) {
  const room = element.clientWidth;
  const [width, depth, height] = volume.size.map((n) => n * volume.step);
  const narrow = room < 720;
  const tallest = Math.min(window.innerHeight * 0.85, 680);
  const beside = narrow ? 0 : Math.max(260, room * 0.36);
  const scale = Math.min(tallest / height, (room - beside - 48) / (width + depth));
  views.coronal.fit(scale);
  views.sagittal.fit(scale);
  const rest = narrow ? room : room - (width + depth) * scale - 56;
  views.axial.fit(Math.min(rest / width, (tallest * 0.6) / depth, 1.6));
}

function controlsOf(volume, windows, look, redraw) {
  const range = (label, low, high, step, get, set) => {
    const input = h('input', {
      type: 'range',
      min: low,
      max: high,
      step,
      value: get(),
      oninput: () => {
        set(Number(input.value));
        redraw();
      },
    });
    return h('label', {}, h('span', {}, label), input);
  };
  const all = [];
  if (volume.grey) {
    const level = range(
      'Level',
      volume.low,
      volume.high,
      'any',
      () => look.centre,
      (v) => {
        look.centre = v;
      },
    );
    const width = range(
      'Window',
      1,
      volume.high - volume.low,
      'any',
      () => look.width,
      (v) => {
        look.width = v;
      },
    );
    const preset = (name) => () => {
      Object.assign(look, windows[name]);
      level.querySelector('input').value = look.centre;
      width.querySelector('input').value = look.width;
      redraw();
    };
    all.push(
      h(
        'span',
        { class: 'group', role: 'group', 'aria-label': 'Window' },
        Object.keys(windows).map((name) => h('button', { class: 'small', onclick: preset(name) }, name)),
      ),
      level,
      width,
    );
  }
  if (volume.labels) {
    const lines = h('input', {
      type: 'checkbox',
      checked: look.outlines,
      onchange: () => {
        look.outlines = lines.checked;
        redraw();
      },
    });
    all.push(
      range(
        'Parts',
        0,
        1,
        0.01,
        () => look.opacity,
        (v) => {
          look.opacity = v;
        },
      ),
      h('label', { class: 'check' }, lines, 'Outlines'),
    );
  }
  return all;
}

/** The body's middle; without labels that of the grid. */
function middleOf({ size, labels, at }) {
  const middle = size.map((n) => n >> 1);
  if (!labels) return middle;
  const sums = [0, 0, 0];
  let count = 0;
  for (let k = 0; k < size[2]; k += 2)
    for (let j = 0; j < size[1]; j += 2)
      for (let i = 0; i < size[0]; i += 2)
        if (labels[at(i, j, k)]) {
          sums[0] += i;
          sums[1] += j;
          sums[2] += k;
          ++count;
        }
  return count ? sums.map((s) => Math.round(s / count)) : middle;
}

function describe(volume, cursor, titles) {
  const where = cursor
    .map((index, axis) => {
      const mm = volume.millimetres(axis, index);
      return `${['R', 'A', 'I'][axis] && mm < 0 ? ['R', 'A', 'I'][axis] : ['L', 'P', 'S'][axis]} ${fixed(Math.abs(mm), 0)}`;
    })
    .join(', ');
  const at = volume.at(...cursor);
  const what = volume.labels ? (titles[volume.labels[at]] ?? 'Outside') : '';
  const grey = volume.grey ? `${fixed(volume.value(volume.grey[at]), 0)} ${volume.unit}` : '';
  return [`${where} mm`, grey, what].filter(Boolean).join(' · ');
}
