// The small copy of the scan in the report (thumbnail.hpp): grey values and part labels on one
// isotropic grid along the patient's axes (x to the Left, y to the back, z up).

/** About `about` = {size, spacing, origin, low, high, unit}; grey (null if the input was labels) and labels. */
export function makeVolume(about, grey, labels) {
  const [nx, ny, nz] = about.size;
  const step = about.spacing;
  const value = (byte) => about.low + (byte / 255) * (about.high - about.low);
  return {
    ...about,
    grey,
    labels,
    value,
    step,
    at: (i, j, k) => (k * ny + j) * nx + i,
    /** Patient millimetres of an index along one axis. */
    millimetres: (axis, index) => about.origin[axis] + step * index,
    holds: (i, j, k) => i >= 0 && j >= 0 && k >= 0 && i < nx && j < ny && k < nz,
  };
}

// The three planes: the fixed axis, the axes along the picture's width and height, and whether the picture's
// rows run against the axis. The patient is seen from the feet and from the front, as radiologists do.
export const planes = {
  coronal: { held: 1, across: 0, down: 2, flip: true, letters: ['R', 'L', 'S', 'I'] },
  sagittal: { held: 0, across: 1, down: 2, flip: true, letters: ['A', 'P', 'S', 'I'] },
  axial: { held: 2, across: 0, down: 1, flip: false, letters: ['R', 'L', 'A', 'P'] },
};

/**
 * Draws one plane into an ImageData of the size of the plane times `zoom`: grey by linear interpolation, labels
 * by majority, `opacity` over it, and a line where two labels meet.
 */
export function drawPlane(volume, plane, index, zoom, look, colours) {
  const { held, across, down, flip } = planes[plane];
  const width = volume.size[across];
  const height = volume.size[down];
  const stride = [1, volume.size[0], volume.size[0] * volume.size[1]];
  const base = index * stride[held];
  const [W, H] = [width * zoom, height * zoom];
  const image = new ImageData(W, H);
  const tone = toneTable(volume, look);
  const { grey, labels } = volume;
  const nearest = new Uint8Array(W * H);
  for (let y = 0; y < H; ++y) {
    const v = clamp((flip ? H - 1 - y : y) / zoom + 0.5 / zoom - 0.5, height - 1);
    const v0 = Math.min(Math.floor(v), Math.max(height - 2, 0));
    const dv = v - v0;
    const row0 = base + v0 * stride[down];
    const row1 = base + Math.min(v0 + 1, height - 1) * stride[down];
    for (let x = 0; x < W; ++x) {
      const u = clamp(x / zoom + 0.5 / zoom - 0.5, width - 1);
      const u0 = Math.min(Math.floor(u), Math.max(width - 2, 0));
      const du = u - u0;
      const [a, b] = [u0 * stride[across], Math.min(u0 + 1, width - 1) * stride[across]];
      const at = y * W + x;
      nearest[at] = labels ? majority(labels, row0 + a, row0 + b, row1 + a, row1 + b, du, dv) : 0;
      const shade = grey
        ? tone[
            Math.round(
              (1 - dv) * ((1 - du) * grey[row0 + a] + du * grey[row0 + b]) +
                dv * ((1 - du) * grey[row1 + a] + du * grey[row1 + b]),
            )
          ]
        : nearest[at]
          ? 70
          : 12;
      image.data.fill(shade, 4 * at, 4 * at + 3);
      image.data[4 * at + 3] = 255;
    }
  }
  paintLabels(image, nearest, look, colours);
  return image;
}

/** The label with the largest weight of linear interpolation: bounds run smoothly between voxels. */
function majority(labels, p00, p01, p10, p11, du, dv) {
  const [a, b, c, d] = [labels[p00], labels[p01], labels[p10], labels[p11]];
  if (a === b && a === c && a === d) return a;
  const [wa, wb, wc, wd] = [(1 - du) * (1 - dv), du * (1 - dv), (1 - du) * dv, du * dv];
  const weight = (l) => (a === l) * wa + (b === l) * wb + (c === l) * wc + (d === l) * wd;
  let best = a;
  for (const l of [b, c, d]) if (weight(l) > weight(best)) best = l;
  return best;
}

function paintLabels(image, nearest, { opacity, outlines }, colours) {
  const { width, height, data } = image;
  for (let y = 0; y < height; ++y) {
    for (let x = 0; x < width; ++x) {
      const at = y * width + x;
      const label = nearest[at];
      if (label === 0) continue;
      const edge =
        outlines &&
        ((x > 0 && nearest[at - 1] !== label) ||
          (x + 1 < width && nearest[at + 1] !== label) ||
          (y > 0 && nearest[at - width] !== label) ||
          (y + 1 < height && nearest[at + width] !== label));
      const weight = edge ? Math.max(opacity, 0.9) : opacity;
      const colour = colours[label] ?? [154, 154, 154];
      for (let c = 0; c < 3; ++c) data[4 * at + c] += weight * (colour[c] - data[4 * at + c]);
    }
  }
}

/** The grey level on screen of each of the 256 stored values, for a window. */
export function toneTable(volume, { centre, width }) {
  return Uint8Array.from(
    { length: 256 },
    (_, byte) => 255 * clamp((volume.value(byte) - centre) / width + 0.5, 1),
  );
}

const clamp = (value, high) => Math.min(Math.max(value, 0), high);

/** Useful windows for this quantity of grey values, each a button. */
export function windowsOf(volume) {
  const all = { centre: (volume.low + volume.high) / 2, width: volume.high - volume.low };
  if (volume.quantity === 'hu') {
    return {
      'Soft tissue': { centre: 40, width: 400 },
      Bone: { centre: 350, width: 1600 },
      Lung: { centre: -500, width: 1400 },
      'Full range': all,
    };
  }
  if (volume.quantity === 'density_kgm3') {
    return {
      'Soft tissue': { centre: 1020, width: 260 },
      Bone: { centre: 1300, width: 1300 },
      'Full range': all,
    };
  }
  return { 'Full range': all };
}
