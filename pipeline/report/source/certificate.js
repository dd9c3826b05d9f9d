// The simulation's certificate in words.
import { h, seconds, significant } from './dom.js';

/** The certificate's method of a recorded motion: nothing was computed, so nothing was checked. */
const recordedMethod = 'captured motion';

/** One line for the page's top: {trusted, text}; null without a motion. */
export function verdictOf(motion) {
  if (!motion) return null;
  const { trusted, method } = motion.certificate;
  if (method === recordedMethod) return { trusted, text: 'recorded' };
  return { trusted, text: trusted ? 'trusted' : 'not trusted' };
}

export function makeCertificate(motion) {
  const c = motion.certificate;
  if (c.method === recordedMethod)
    return h(
      'div',
      { class: 'certificate' },
      h('h3', {}, 'This motion was recorded'),
      h('p', {}, 'Nothing was simulated, so there is no certificate. Residuals at the root show how well motion, masses and forces agree.'),
    );
  const sentences = [balanceOf(c), ...residualsOf(c), ...conservedOf(c), stepsOf(c)];
  return h(
    'div',
    { class: `certificate ${c.trusted ? 'trusted' : 'untrusted'}` },
    h('h3', {}, c.trusted ? 'This motion can be trusted' : 'This motion cannot be trusted'),
    c.vouches_for ? h('p', {}, `The certificate vouches for ${c.vouches_for}.`) : null,
    c.trusted
      ? null
      : h(
          'p',
          { class: 'reason' },
          sentence(c.reason || 'The run gave no reason'),
          Number.isFinite(c.reason_time) ? ` First at ${seconds(c.reason_time)}.` : '',
        ),
    h(
      'ul',
      {},
      sentences.filter(Boolean).map((text) => h('li', {}, text)),
      (c.notes ?? []).map((note) => h('li', {}, sentence(note))),
    ),
  );
}

const sentence = (text) => text.charAt(0).toUpperCase() + text.slice(1) + (/[.!?]$/.test(text) ? '' : '.');

function balanceOf(c) {
  if (!Number.isFinite(c.energy_drift)) return 'The energy balance is not known.';
  const share = c.energy_turnover > 0 ? c.energy_drift / c.energy_turnover : null;
  const against =
    share === null
      ? ''
      : `, ${significant(share, 2)} of the ${significant(c.energy_turnover, 3)} J that changed form (up to ${significant(c.energy_threshold, 2)} is trusted)`;
  return `Kinetic and potential energy less the work done stay constant within ${significant(c.energy_drift, 2)} J${against}; worst at ${seconds(c.energy_drift_time)}.`;
}

function residualsOf(c) {
  const impacts = c.impacts > 0 ? `, collided ${c.impacts === 1 ? 'once' : `${c.impacts} times`} and lost ${significant(c.impact_loss, 3)} J` : '';
  const contacts = c.contacts > 0 ? [`Solids may touch in ${c.contacts} ${c.contacts === 1 ? 'place' : 'places'}${impacts}.`] : [];
  if (c.constraint_rows === 0)
    return contacts.length > 0 ? contacts : ['The scene has no constraints beyond its joints.'];
  const rank = c.constraint_rank < c.constraint_rows ? `, of which ${c.constraint_rank} are independent` : '';
  const redundant = c.redundant?.length
    ? ` (redundant: ${c.redundant.join(', ')}; of the forces that fulfil the constraints, the smallest are given)`
    : '';
  return [
    ...contacts,
    `The constraints have ${c.constraint_rows} rows${rank}${redundant}; the table gives the largest error of each.`,
  ];
}

function conservedOf(c) {
  return (c.conserved ?? []).map(
    ({ name, drift, scale, time }) =>
      `${sentence(name).slice(0, -1)} is conserved within ${significant(drift, 2)}${scale > 0 ? `, ${significant(drift / scale, 2)} of its scale` : ''}; worst at ${seconds(time)}.`,
  );
}

function stepsOf(c) {
  const rejected = c.steps_rejected > 0 ? ` and rejected ${c.steps_rejected}` : '';
  const smallest =
    c.steps_accepted === 0
      ? ''
      : c.smallest_step_time === 0 // as with equal steps
        ? `; none was smaller than the first, ${seconds(c.smallest_step)}`
        : `; the smallest was ${seconds(c.smallest_step)}, at ${seconds(c.smallest_step_time)}`;
  const by = c.method ? ` (${c.method}, the ${c.equations} equations)` : '';
  return `The integrator${by} took ${c.steps_accepted} steps${rejected}, with ${c.evaluations} evaluations of the equations${smallest}.`;
}

/** The worst residual of each constraint; null if there are none. */
export function residualTable(motion) {
  const rows = motion.certificate.residuals ?? [];
  if (rows.length === 0) return null;
  return h(
    'div',
    { class: 'scroll' },
    h(
      'table',
      { class: 'numbers' },
      h('caption', {}, 'Worst residuals of the constraints, in the units of their rows'),
      h(
        'thead',
        {},
        h(
          'tr',
          {},
          ['Constraint', 'position', 'at', 'velocity', 'at', 'acceleration', 'at'].map((t, i) =>
            h('th', { scope: 'col', class: i ? 'number' : '' }, t),
          ),
        ),
      ),
      h(
        'tbody',
        {},
        rows.map((r) =>
          h(
            'tr',
            {},
            h('th', { scope: 'row' }, r.constraint),
            [
              significant(r.position, 2),
              seconds(r.position_time),
              significant(r.velocity, 2),
              seconds(r.velocity_time),
              significant(r.acceleration, 2),
              seconds(r.acceleration_time),
            ].map((t) => h('td', { class: 'number' }, t)),
          ),
        ),
      ),
    ),
  );
}

const mostEvents = 100;

const eventWords = {
  range_left: 'leaves its range',
  range_entered: 'is back in its range',
  impact: 'impact',
  contact_closed: 'contact closes',
  contact_opened: 'contact opens',
  stick: 'sticks',
  slip: 'slips',
  half_turn: 'half a turn',
  stop_reached: 'stop reached',
  stop_left: 'stop left',
  stop_slack: 'stop slack',
  stop_taut: 'stop taut',
  rank_fell: 'rank falls',
  rank_regained: 'rank is back',
};

/** The events with their times; null if there are none. */
export function eventTable(motion) {
  const events = motion.certificate.events ?? [];
  if (events.length === 0) return null;
  const shown = events.slice(0, mostEvents);
  const more = events.length > mostEvents ? `, the first ${mostEvents} of ${events.length}` : '';
  const shocks = shown.some((e) => e.impulse > 0);
  const titles = ['At', 'event', 'of', ...(shocks ? ['impulse (N s or N m s)', 'energy lost (J)'] : [])];
  const table = h(
    'div',
    { class: 'scroll' },
    h(
      'table',
      { class: 'numbers' },
      h('caption', {}, `Events and their times${more}`),
      h(
        'thead',
        {},
        h(
          'tr',
          {},
          titles.map((t, i) => h('th', { scope: 'col', class: i === 0 || i > 2 ? 'number' : '' }, t)),
        ),
      ),
      h(
        'tbody',
        {},
        shown.map((e) =>
          h(
            'tr',
            {},
            h('td', { class: 'number' }, seconds(e.time)),
            h('td', {}, eventWords[e.kind] ?? e.kind),
            h('td', {}, e.name),
            shocks
              ? [e.impulse, e.energy_lost].map((x) =>
                  h('td', { class: 'number' }, e.impulse > 0 ? significant(x, 3) : ''),
                )
              : null,
          ),
        ),
      ),
    ),
  );
  return h('details', { class: 'events' }, h('summary', {}, inWordsOf(events)), table);
}

/** "Events: 12 times impact, 3 times slips". */
function inWordsOf(events) {
  const counts = new Map();
  for (const { kind } of events) counts.set(kind, (counts.get(kind) ?? 0) + 1);
  const said = [...counts].map(([kind, n]) => `${eventWords[kind] ?? kind.replaceAll('_', ' ')}${n > 1 ? ` (${n} times)` : ''}`);
  return `Events: ${said.join(', ')}`;
}
