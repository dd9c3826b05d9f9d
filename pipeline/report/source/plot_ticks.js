// Ticks of an axis and their texts, as plot_scale.cpp and plot.cpp choose them for the same plot as SVG.
const superscript = (number) => [...String(number)].map((c) => (c === '-' ? '⁻' : '⁰¹²³⁴⁵⁶⁷⁸⁹'[Number(c)])).join('');

/** 0.001 to 99999 as they are, others (and powers of ten on a logarithmic axis) as 2×10⁻⁶. */
export function tickText(value, logarithmic, digits = 6) {
  const size = Math.abs(value);
  if (size === 0) return '0';
  if (value < 0) return `−${tickText(size, logarithmic, digits)}`;
  if (logarithmic ? size >= 0.1 && size < 1e3 : size >= 1e-3 && size < 1e5) return String(Number(size.toPrecision(digits)));
  const exponent = Math.floor(Math.log10(size) + 1e-12);
  const factor = Number((size / 10 ** exponent).toPrecision(Math.min(digits, 3)));
  return factor === 1 ? `10${superscript(exponent)}` : `${factor}×10${superscript(exponent)}`;
}

/** At most about `most` round values within [low, high] of an axis {log, whole, ticks}. */
export function ticksOf({ log, whole, ticks }, low, high, most) {
  if (!(high > low)) return [];
  const within = (list) => list.filter((value) => value >= low * (1 - 1e-9) - 1e-300 && value <= high * (1 + 1e-9));
  if (ticks) return thinned(ticks.filter((value) => value >= low && value <= high), most);
  const decades = log ? Math.log10(high / low) : 0;
  if (log && decades >= 1) {
    const [first, last] = [Math.floor(Math.log10(low) + 1e-9), Math.ceil(Math.log10(high) - 1e-9)];
    const powers = Array.from({ length: last - first + 1 }, (_, i) => Number(`1e${first + i}`));
    const fine = within(powers.flatMap((power) => [power, 2 * power, 5 * power]));
    return decades < 2.5 && fine.length <= most ? fine : thinned(within(powers), most);
  }
  const power = 10 ** Math.floor(Math.log10((high - low) / most));
  const round = power * ([1, 2, 5, 10].find((factor) => (high - low) / (factor * power) <= most) ?? 10);
  const step = whole ? Math.max(1, Math.round(round)) : round;
  const list = [];
  for (let n = Math.ceil(low / step - 1e-9); n * step <= high + 1e-9 * step; ++n) list.push(n * step);
  return list;
}

const thinned = (list, most) => {
  const every = Math.max(1, Math.ceil(list.length / most));
  return list.filter((_, i) => i % every === 0);
};
