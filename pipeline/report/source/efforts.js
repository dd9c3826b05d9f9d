// The section on joint moments: angle, moment with its error band, and power of one joint's motion over time, left over
// right; and sentences about the curves. Heading and tables are in the page already (effort_section.cpp).
import { makeChart } from './charts.js';
import { fixed, h } from './dom.js';

export const sideOf = (name) => /_(left|right)$/.exec(name)?.[1] ?? '';

/** [i, share]: `time` lies a `share` of the way from times[i] to times[i + 1]; at the ends it stays there. */
export function between(times, time) {
  if (!(time > times[0])) return [0, 0];
  if (time >= times.at(-1)) return [times.length - 1, 0];
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  return [low, (time - times[low]) / (times[high] - times[low])];
}

const capital = (text) => text.charAt(0).toUpperCase() + text.slice(1);

/** The number of decimals (at most 3) that shows `digits` significant digits, as in effort_section.cpp. */
const decimalsOf = (value, digits) =>
  value ? Math.min(3, Math.max(0, digits - 1 - Math.floor(Math.log10(Math.abs(value))))) : 0;

const short = (value) => fixed(value, decimalsOf(value, 3));

/** "−48.3 ± 2.1": two digits of the deviation set the number of the value's digits. */
function withDeviation(value, deviation) {
  if (!(deviation > 0)) return short(value);
  const decimals = decimalsOf(deviation, 2);
  return `${fixed(value, decimals)} ± ${fixed(deviation, decimals)}`;
}

/** "60 % of the variance comes from joint centres, 30 % from masses". */
function sharesInWords(shares) {
  const parts = Object.entries(shares ?? {})
    .filter(([, share]) => share >= 0.005)
    .toSorted((a, b) => b[1] - a[1])
    .map(
      ([cause, share], i) =>
        `${fixed(100 * share, 0)} % ${i === 0 ? 'of the variance comes from' : 'from'} ${cause}`,
    );
  return parts.length > 0 ? ` ${parts.join(', ')}.` : '';
}

/** A sentence with the largest values of one coordinate's curves; `mass` in kg, or 0. */
function peakInWords({ label, peak, shares }, mass) {
  const perMass = mass > 0 ? ` (${withDeviation(peak.moment / mass, peak.deviation / mass)} N m/kg)` : '';
  return h(
    'li',
    {},
    h('strong', {}, `${capital(label)}: `),
    `peak moment ${withDeviation(peak.moment, peak.deviation)} N m${perMass} at ${fixed(peak.time, 2)} s, `,
    `peak power ${short(peak.power)} W at ${fixed(peak.power_time, 2)} s.${sharesInWords(shares)}`,
  );
}

const unique = (list) => [...new Set(list)];

/** Three stacked charts of one joint's motion, with its left and right coordinates. */
function chartsOf(efforts, coordinates, { perMass, ball }, link) {
  const scale = perMass ? 1 / efforts.mass_kg : 1;
  const times = efforts.times;
  const scaled = (values) => values?.map((v) => (v === null ? null : v * scale));
  const curves = (pick) =>
    coordinates.map((c) => ({ name: c.side || 'value', side: c.side, ...pick(c) }));
  const bands = coordinates.some((c) => c.deviation);
  const common = { ...link, times, plain: true, scrub: true, sync: 'moments' };
  const per = perMass ? '/kg' : '';
  return [
    makeChart({
      ...common,
      title: ball ? 'Joint angle: this axis’s part of the rotation vector' : 'Joint angle',
      unit: 'angle (°)',
      curves: curves((c) => ({ values: c.angle_deg })),
    }),
    makeChart({
      ...common,
      title: bands ? 'Joint moment; the band is ± 2 standard deviations' : 'Joint moment',
      unit: `moment (N m${per})`,
      curves: curves((c) => ({
        values: scaled(c.moment),
        band: scaled(c.deviation)?.map((d) => (d === null ? null : 2 * d)),
      })),
    }),
    makeChart({
      ...common,
      title: 'Joint power',
      unit: `power (W${per})`,
      curves: curves((c) => ({ values: scaled(c.power) })),
    }),
  ];
}

/**
 * Puts the charts of `efforts` (EffortSection::page) into the section that is in the page. `link` ties them to the
 * player: {origin: the time at which the player starts (s), onTime, seek}. `draw` draws them.
 */
export function fillMoments(section, efforts, link) {
  const { coordinates, mass_kg: mass = 0 } = efforts;
  if (coordinates.length === 0) return { draw() {} };
  const groups = unique(coordinates.map((c) => c.group));
  const chosen = { group: groups[0], motion: '', perMass: false };
  const charts = h('div', { class: 'moment-charts' });
  const words = h('ul', { class: 'peak-words' });
  const motionButtons = h('span', { class: 'group', role: 'group', 'aria-label': 'Motion' });
  let drawn = [];
  let now = 0;
  link.onTime?.((time) => {
    now = time;
    drawn.forEach((chart) => chart.showTime(time));
  });
  const show = () => {
    const ofGroup = coordinates.filter((c) => c.group === chosen.group);
    const motions = unique(ofGroup.map((c) => c.motion));
    if (!motions.includes(chosen.motion)) chosen.motion = motions[0];
    const shown = ofGroup.filter((c) => c.motion === chosen.motion);
    for (const button of joints)
      button.setAttribute('aria-pressed', button.textContent === capital(chosen.group));
    motionButtons.hidden = motions.length < 2;
    motionButtons.replaceChildren(
      ...motions.map((motion) =>
        h(
          'button',
          {
            class: 'small',
            'aria-pressed': String(motion === chosen.motion),
            onclick: () => choose({ motion }),
          },
          motion,
        ),
      ),
    );
    drawn.forEach((chart) => chart.remove());
    drawn = chartsOf(
      efforts,
      shown,
      { perMass: chosen.perMass, ball: motions.length === 3 },
      { origin: link.origin, seek: link.seek },
    );
    charts.replaceChildren(
      h('h3', {}, capital(`${chosen.group}, ${chosen.motion}`)),
      ...drawn.map(({ element }) => element),
    );
    words.replaceChildren(...shown.map((c) => peakInWords(c, mass)));
    for (const chart of drawn) {
      chart.draw();
      chart.showTime(now);
    }
  };
  const choose = (what) => {
    Object.assign(chosen, what);
    show();
  };
  const joints = groups.map((group) =>
    h('button', { onclick: () => choose({ group }) }, capital(group)),
  );
  const perMass = h('input', { type: 'checkbox', onchange: () => choose({ perMass: perMass.checked }) });
  section.querySelector('p').after(
    h('div', { class: 'choices', role: 'group', 'aria-label': 'Joint' }, joints),
    h(
      'div',
      { class: 'looks moment-looks' },
      motionButtons,
      mass > 0 ? h('label', { class: 'check' }, perMass, 'per kg of body mass') : null,
    ),
    charts,
    words,
  );
  return { draw: show };
}
