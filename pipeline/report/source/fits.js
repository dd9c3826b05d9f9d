// Pictures of the bone on which joint centres were measured, with the circle of the sphere or cylinder.
import { fixed, h, partTitle } from './dom.js';

const shown = 150; // pixels on screen

/** `about` = {pixels, fits: [{joint, radius, deviation, source, side, planes}]}; `bytes`: one picture after another. */
export function makeFits(about, bytes) {
  const { pixels, fits } = about;
  let at = 0;
  const picture = (plane, { joint, radius, side }) => {
    const canvas = h('canvas', { width: pixels, height: pixels });
    const image = new ImageData(pixels, pixels);
    for (let n = 0; n < pixels * pixels; ++n) {
      image.data.fill(bytes[at + n], 4 * n, 4 * n + 3);
      image.data[4 * n + 3] = 255;
    }
    at += pixels * pixels;
    canvas.getContext('2d').putImageData(image, 0, 0);
    const circle = (kind) => h('circle', { class: kind, cx: shown / 2, cy: shown / 2, r: (radius / side) * shown });
    return h(
      'div',
      { class: 'fit' },
      canvas,
      h(
        'svg',
        { width: shown, height: shown, role: 'img', 'aria-label': `${partTitle(joint)}, ${plane}` },
        circle('casing'),
        circle('core'),
      ),
      h('span', { class: 'letter top' }, plane),
    );
  };
  return h(
    'div',
    { class: 'fits' },
    fits.map((fit) =>
      h(
        'figure',
        {},
        h('div', { class: 'fit-planes' }, fit.planes.map((plane) => picture(plane, fit))),
        h(
          'figcaption',
          { title: fit.source },
          h('strong', {}, partTitle(fit.joint)),
          ` radius ${fixed(fit.radius, 1)} mm, centre ± ${fixed(fit.deviation, 1)} mm`,
        ),
      ),
    ),
  );
}
