// Building the page: elements, numbers and the words that several sections share. All text goes in as text
// nodes, so that a subject's name can never become markup.

const svgTags = new Set([
  'svg',
  'g',
  'path',
  'rect',
  'line',
  'circle',
  'text',
  'title',
  'desc',
  'pattern',
  'defs',
  'polygon',
]);

/** An element with attributes (on* are listeners, `style` may be an object) and children (nodes or text). */
export function h(tag, attributes = {}, ...children) {
  const element = svgTags.has(tag)
    ? document.createElementNS('http://www.w3.org/2000/svg', tag)
    : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === undefined || value === null || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name === 'style' && typeof value === 'object') {
      for (const [property, setting] of Object.entries(value)) element.style.setProperty(property, setting);
    } else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined));
  return element;
}

/** A number with `digits` significant digits, without exponent for everyday sizes; a dash if it is missing. */
export function significant(value, digits = 4) {
  if (typeof value !== 'number' || !Number.isFinite(value)) return '–';
  if (value === 0) return '0';
  const size = Math.abs(value);
  if (size < 1e-4 || size >= 1e6) {
    const [mantissa, exponent] = value.toExponential(digits - 1).split('e');
    return `${minus(mantissa)}·10${superscript(Number(exponent))}`;
  }
  const decimals = Math.max(0, digits - 1 - Math.floor(Math.log10(size)));
  return minus(value.toFixed(decimals));
}

/** A number with a fixed count of decimals; a dash if it is missing. */
export function fixed(value, decimals) {
  if (typeof value !== 'number' || !Number.isFinite(value)) return '–';
  const text = value.toFixed(decimals);
  return minus(/^-0(\.0*)?$/.test(text) ? text.slice(1) : text);
}

/** A signed difference: "+3.1", "−0.4". */
export function signed(value, decimals = 1) {
  if (typeof value !== 'number' || !Number.isFinite(value)) return '–';
  const text = fixed(value, decimals);
  return value > 0 && Number(value.toFixed(decimals)) !== 0 ? `+${text}` : text;
}

export function bytes(count) {
  if (typeof count !== 'number') return '–';
  if (count < 1000) return `${count} B`;
  if (count < 1e6) return `${significant(count / 1e3, 3)} kB`;
  if (count < 1e9) return `${significant(count / 1e6, 3)} MB`;
  return `${significant(count / 1e9, 3)} GB`;
}

export function seconds(value) {
  if (typeof value !== 'number' || !Number.isFinite(value)) return '–';
  if (value === 0) return '0 s';
  if (value < 1e-3) return `${significant(value * 1e6, 3)} µs`;
  if (value < 1) return `${significant(value * 1e3, 3)} ms`;
  if (value < 120) return `${significant(value, 3)} s`;
  const whole = Math.round(value);
  return `${Math.floor(whole / 60)} min ${whole % 60} s`;
}

/** "upper_arm_left" in words: "Left upper arm". */
export function partTitle(name) {
  const [, stem, side] = /^(.*?)(?:_(left|right))?$/.exec(name);
  const words = (side ? `${side} ${stem}` : stem).replaceAll('_', ' ');
  return words.charAt(0).toUpperCase() + words.slice(1);
}

const minus = (text) => text.replace('-', '−');
const superscript = (number) =>
  [...String(number)].map((c) => (c === '-' ? '⁻' : '⁰¹²³⁴⁵⁶⁷⁸⁹'[Number(c)])).join('');

/** A section of the page with its heading; null if it has nothing to show. */
export function section(id, title, ...content) {
  return h(
    'section',
    { id, 'aria-labelledby': `${id}-title` },
    h('h2', { id: `${id}-title` }, title),
    content,
  );
}

/** Calls `redraw` when the element's width changes, once per frame. */
export function onResize(element, redraw) {
  let width = 0;
  new ResizeObserver(() => {
    if (element.clientWidth === width || element.clientWidth === 0) return;
    width = element.clientWidth;
    requestAnimationFrame(redraw);
  }).observe(element);
}

/** Value of a CSS variable of the page in the current colour scheme. */
export const css = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();

export const darkScheme = window.matchMedia('(prefers-color-scheme: dark)');
