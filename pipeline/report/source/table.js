// The inertia table with published values, in four views that print below each other.
import { fixed, h, partTitle, signed } from './dom.js';
import { inWords } from './words.js';

const tables = {
  deleva: ['deleva1996', 'de Leva (1996)'],
  dumas: ['dumas2007', 'Dumas et al. (2007)'],
  winter: ['winter2009', 'Dempster after Winter (2009)'],
  zatsiorsky: ['zatsiorsky2002', 'Zatsiorsky (2002)'],
};

/**
 * The rows of inertia/table.json (inertia/table_file.hpp) as the page uses them, in the order of report.parts:
 * {name, colour, completeness, mass (kg), massDeviation, share (%), shareDeviation, volume (l), centre (mm), tensor, anatomical, principal, frame,
 * length (mm), centreShare (%), radii (% about x, y, z), notes, confidence, published: {deleva, dumas: {mass, centreShare,
 * radii, whyNot}}}.
 */
export function rowsOf(report) {
  if (!report.table) return [];
  const entries = new Map(report.table.parts.map((entry) => [entry.part, entry]));
  return report.parts
    .filter(({ name }) => entries.has(name))
    .map(({ name, colour }) => {
      const e = entries.get(name);
      const d = e.derived ?? {};
      const found = report.segmentation?.parts?.[name];
      return {
        name,
        colour,
        completeness: e.completeness,
        mass: e.mass_kg,
        massDeviation: e.deviations?.mass_kg?.total,
        share: d.mass_pct,
        shareDeviation: e.deviations?.mass_pct?.total,
        volume: scaled(e.volume_m3, 1e3),
        centre: e.centre_m?.map((c) => c * 1e3),
        tensor: e.tensor_kgm2,
        inertia:
          e.centre_m && d.principal_moments_kgm2 && d.principal_axes_columns
            ? { mass: e.mass_kg, centre: e.centre_m, moments: d.principal_moments_kgm2, axes: d.principal_axes_columns }
            : null,
        anatomical: d.anatomical_tensor_kgm2,
        principal: d.principal_moments_kgm2,
        frame: e.frame,
        length: scaled(d.length_m, 1e3),
        centreShare: d.centre_pct,
        radii: d.radii_pct,
        flaw: e.flaw,
        confidence: found?.confidence,
        notes: [
          ...new Set(
            [e.flaw && `No body can have this tensor: ${e.flaw}`, found?.note, ...(e.notes ?? [])].filter(
              Boolean,
            ),
          ),
        ],
        published: Object.fromEntries(
          Object.entries(tables).map(([key, [field]]) => [key, published(d[field])]),
        ),
      };
    });
}

const scaled = (value, factor) => (Number.isFinite(value) ? value * factor : undefined);
const published = (p) =>
  p && { mass: p.mass_pct, centreShare: p.centre_pct, radii: p.radii_pct, whyNot: p.why_not };

/** The published tables with values for this one, {key: title}. */
export function sourcesOf(rows) {
  const says = (key) =>
    rows.some(
      ({ published: p }) => p[key] && (p[key].mass !== undefined || p[key].centreShare !== undefined),
    );
  return Object.fromEntries(
    Object.entries(tables)
      .filter(([key]) => says(key))
      .map(([key, [, title]]) => [key, title]),
  );
}

/** `pick` is called with the name of the part whose row is pressed; null if there is no scene. */
export function makeTables(report, rows, sources, pick) {
  const having = (value) =>
    Object.keys(sources).filter((key) => rows.some(({ published: p }) => p[key]?.[value] !== undefined));
  const views = {
    Mass: [massTable(rows, having('mass'), sources, isWhole(report))],
    'Gravity centre': [centreTable(rows, having('centreShare'), sources)],
    'Radii of gyration': [radiiTable(rows, having('radii'), sources)],
    'Inertia tensor': tensorTables(rows),
    'How measured': [notesTable(rows)],
  };
  const element = h('div', {}, madeFrom(report.table.source), tabs(views));
  if (pick)
    for (const cell of element.querySelectorAll('tbody th[data-part]')) {
      const button = h('button', { class: 'pick', title: 'Show it in the scene', onclick: () => pick(cell.dataset.part) });
      button.append(...cell.childNodes);
      cell.append(button);
    }
  return element;
}

/** The table's sources, in a sentence or two. */
function madeFrom(source) {
  if (!source) return null;
  const density = source.density_curve
    ? `Densities from CT numbers by the curve of ${inWords(source.density_curve)}${source.density_source ? ` (${source.density_source})` : ''}. `
    : '';
  const cuts = source.cuts ? `Parts are cut after ${inWords(source.cuts)}. ` : '';
  const pose = source.pose ? `The body was scanned ${source.pose}. ` : '';
  const sex = source.sex
    ? `Published values are those for the ${source.sex} sex.`
    : 'No sex was stated, so there are no published values to compare with.';
  return h('p', { class: 'quiet made-from' }, density, cuts, pose, sex);
}

/** Tabs after the ARIA pattern; all panels are shown in print. */
function tabs(views) {
  const names = Object.keys(views);
  const id = (name, kind) => `${kind}-${name.replaceAll(' ', '-').toLowerCase()}`;
  const buttons = names.map((name) =>
    h(
      'button',
      { role: 'tab', id: id(name, 'tab'), 'aria-controls': id(name, 'panel'), onclick: () => show(name) },
      name,
    ),
  );
  const panels = names.map((name) =>
    h(
      'div',
      {
        role: 'tabpanel',
        id: id(name, 'panel'),
        'aria-labelledby': id(name, 'tab'),
        class: 'scroll',
        tabindex: 0,
      },
      views[name],
    ),
  );
  const show = (chosen, focus) =>
    names.forEach((name, i) => {
      const on = name === chosen;
      buttons[i].setAttribute('aria-selected', on);
      buttons[i].tabIndex = on ? 0 : -1;
      panels[i].classList.toggle('shown', on);
      if (on && focus) buttons[i].focus();
    });
  const list = h(
    'div',
    {
      role: 'tablist',
      'aria-label': 'Columns of the table',
      onkeydown: (event) => {
        const step = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
        if (!step) return;
        const at = buttons.findIndex((b) => b.getAttribute('aria-selected') === 'true');
        show(names.at((at + step) % names.length), true);
      },
    },
    buttons,
  );
  show(names[0]);
  return h('div', { class: 'tabs' }, list, panels);
}

/** Whether shares are of the whole body; the table's rows may be some of its segments only. */
export const isWhole = (report) => report.table?.body?.completeness === 'whole';

const number = (text, extra = '') => h('td', { class: `number ${extra}` }, text);
const head = (text, extra = {}) => h('th', { scope: 'col', class: 'number', ...extra }, text);

function table(caption, headRows, rows, cells, foot = null) {
  return h(
    'table',
    { class: 'numbers' },
    h('caption', {}, caption),
    h(
      'thead',
      {},
      headRows.map((cellsOfHead) => h('tr', {}, cellsOfHead)),
    ),
    h(
      'tbody',
      {},
      rows.map((row) =>
        h(
          'tr',
          { class: row.completeness === 'whole' ? '' : row.completeness },
          partCell(row),
          row.completeness === 'absent'
            ? h('td', { colspan: 20, class: 'quiet' }, row.notes.find((note) => note === 'stated as absent') ?? 'not in the scan')
            : cells(row),
        ),
      ),
    ),
    foot ? h('tfoot', {}, foot) : null,
  );
}

const partHead = (rowspan = 1) => h('th', { scope: 'col', rowspan }, 'Part');
const partCell = (row) =>
  h(
    'th',
    { scope: 'row', 'data-part': row.name },
    h('span', { class: 'swatch', style: { background: row.colour } }),
    partTitle(row.name),
    row.completeness === 'cut'
      ? h('span', { class: 'badge' }, row.notes.some((note) => note.startsWith('stump: ')) ? 'stump' : 'cut')
      : null,
    row.flaw ? h('span', { class: 'badge', title: row.flaw }, 'impossible') : null,
  );

/** Percentage by which `value` differs from `reference`; nothing for a cut part. */
function difference(row, value, reference) {
  if (
    row.completeness !== 'whole' ||
    !Number.isFinite(value) ||
    !Number.isFinite(reference) ||
    reference === 0
  )
    return number('–', 'quiet');
  return number(`${signed((100 * (value - reference)) / reference, 1)} %`, 'difference');
}

function massTable(rows, used, sources, ofBody) {
  const sum = (get) => rows.reduce((total, row) => total + (get(row) || 0), 0);
  const mass = sum((r) => r.mass);
  const volume = sum((r) => r.volume);
  const compared =
    used.length > 0 ? '; differences are relative to the published values' : '';
  return table(
    `Volume, mass and share of ${ofBody ? 'the body’s mass' : 'the mass in the scan'}${compared}`,
    [
      [
        partHead(2),
        head('volume (l)', { rowspan: 2 }),
        head('density (kg/l)', { rowspan: 2 }),
        head('mass (kg)', { rowspan: 2 }),
        head('share (%)', { rowspan: 2 }),
        used.map((key) => h('th', { scope: 'colgroup', colspan: 2, class: 'group-head' }, sources[key])),
      ],
      used.flatMap(() => [head('share (%)'), head('differs')]),
    ],
    rows,
    (r) => [
      number(fixed(r.volume, 3)),
      number(fixed(r.mass / r.volume, 3)),
      number(fixed(r.mass, 3)),
      number(fixed(r.share, 2)),
      used.map((key) => [
        number(fixed(r.published[key]?.mass, 2)),
        difference(r, r.share, r.published[key]?.mass),
      ]),
    ],
    h(
      'tr',
      {},
      h('th', { scope: 'row' }, 'All parts'),
      number(fixed(volume, 3)),
      number(fixed(mass / volume, 3)),
      number(fixed(mass, 3)),
      number(
        fixed(
          sum((r) => r.share),
          2,
        ),
      ),
      used.map(() => [number(''), number('')]),
    ),
  );
}

// de Leva's names of the endpoints
const endpoints = {
  VERT: 'vertex',
  CERV: 'cervicale',
  SUPR: 'suprasternale',
  MIDS: 'between the shoulder joints',
  XYPH: 'xiphion',
  OMPH: 'omphalion',
  MIDH: 'between the hip joints',
  MIDG: 'gonion',
  SJC: 'shoulder joint centre',
  EJC: 'elbow joint centre',
  WJC: 'wrist joint centre',
  STYL: 'stylion',
  MET3: 'head of the third metacarpal',
  DAC3: 'tip of the middle finger',
  HJC: 'hip joint centre',
  KJC: 'knee joint centre',
  AJC: 'ankle joint centre',
  LMAL: 'lateral malleolus',
  SPHY: 'sphyrion',
  HEEL: 'heel',
  TTIP: 'tip of the longest toe',
};

const endpoint = (code) => (endpoints[code] ? h('abbr', { title: endpoints[code] }, code) : code);
const ends = ({ frame }) => (frame?.from ? [endpoint(frame.from), ' – ', endpoint(frame.to)] : ['–']);

function centreTable(rows, used, sources) {
  return table(
    'Gravity centre in the patient frame (x to the left, y to the back, z up), and along the segment from its first endpoint',
    [
      [
        partHead(2),
        h('th', { scope: 'colgroup', colspan: 3, class: 'group-head' }, 'gravity centre (mm)'),
        h('th', { scope: 'col', rowspan: 2 }, 'endpoints'),
        head('length (mm)', { rowspan: 2 }),
        head('centre (%)', { rowspan: 2 }),
        used.map((key) => h('th', { scope: 'colgroup', colspan: 2, class: 'group-head' }, sources[key])),
      ],
      [...['x', 'y', 'z'].map((c) => head(c)), ...used.flatMap(() => [head('centre (%)'), head('differs')])],
    ],
    rows,
    (r) => [
      [0, 1, 2].map((c) => number(fixed(r.centre?.[c], 1))),
      h('td', {}, ends(r)),
      number(fixed(r.length, 1)),
      number(fixed(r.centreShare, 1)),
      used.map((key) => [
        number(fixed(r.published[key]?.centreShare, 1)),
        difference(r, r.centreShare, r.published[key]?.centreShare),
      ]),
    ],
  );
}

// the anatomical axes in the order in which published tables give them, by their place in x, y, z
const turns = [
  ['sagittal', 'about x, which points forward', 0],
  ['transverse', 'about z, which points to the right', 2],
  ['longitudinal', 'about y, along the segment', 1],
];

function radiiTable(rows, used, sources) {
  const groups = (title) => h('th', { scope: 'colgroup', colspan: 3, class: 'group-head' }, title);
  return table(
    'Radii of gyration about the segment’s anatomical axes through its gravity centre, in percent of its length',
    [
      [partHead(2), groups('this body'), used.map((key) => groups(sources[key]))],
      ['own', ...used].flatMap(() => turns.map(([name, where]) => head(name, { title: where }))),
    ],
    rows,
    (r) => [
      turns.map(([, , i]) => number(fixed(r.radii?.[i], 1))),
      used.map((key) => turns.map(([, , i]) => number(fixed(r.published[key]?.radii?.[i], 1)))),
    ],
  );
}

function tensorTables(rows) {
  const entries = [
    ['xx', 0, 0],
    ['yy', 1, 1],
    ['zz', 2, 2],
    ['xy', 0, 1],
    ['xz', 0, 2],
    ['yz', 1, 2],
  ];
  const tensor = (title) => h('th', { scope: 'colgroup', colspan: 6, class: 'group-head' }, title);
  const moment = (kgm2) => number(fixed(Number.isFinite(kgm2) ? kgm2 * 1e4 : undefined, 2));
  const cells = (matrix) => entries.map(([, i, j]) => moment(matrix?.[i]?.[j]));
  return [
    table(
      'Inertia tensor about the gravity centre in patient axes (x left, y back, z up), as the matrix’s entries (Ixy = −∫ xy dm), and its principal moments; kg cm²',
      [
        [
          partHead(2),
          tensor('patient axes'),
          h('th', { scope: 'colgroup', colspan: 3, class: 'group-head' }, 'principal moments'),
        ],
        [...entries.map(([name]) => head(name)), ...['smallest', 'middle', 'largest'].map((t) => head(t))],
      ],
      rows,
      (r) => [cells(r.tensor), [0, 1, 2].map((i) => moment(r.principal?.[i]))],
    ),
    table(
      'The same tensor in the segment’s anatomical axes (x forward, y along the segment upwards, z to the right; a foot’s x from heel to toe); kg cm²',
      [[partHead(2), tensor('anatomical axes')], entries.map(([name]) => head(name))],
      rows,
      (r) => cells(r.anatomical),
    ),
  ];
}

/** Ends, cuts and axes of each segment, and the reason if it has no published value. */
function notesTable(rows) {
  const words = (...texts) =>
    h(
      'td',
      { class: 'words' },
      texts
        .flat()
        .filter(Boolean)
        .map((text) => h('div', {}, text)),
    );
  return table(
    'How each part was measured, and why it is not compared with published values',
    [
      [
        partHead(),
        head('confidence', { title: 'of its boundaries: 1 if the landmarks that bound the part are certain' }),
        ...['measured between', 'cuts', 'axes', 'remarks'].map((t) => h('th', { scope: 'col' }, t)),
      ],
    ],
    rows,
    (r) => [
      number(fixed(r.confidence, 2)),
      h('td', {}, ends(r)),
      words(r.frame?.cuts && inWords(r.frame.cuts)),
      words(r.frame?.axes),
      words(r.notes, whyNot(r)),
    ],
  );
}

/** The reasons for missing published values, each once with the tables concerned. */
function whyNot(row) {
  const reasons = new Map();
  for (const [key, [, title]] of Object.entries(tables)) {
    const reason = row.published[key]?.whyNot;
    if (reason) reasons.set(reason, [...(reasons.get(reason) ?? []), title]);
  }
  return [...reasons].map(([reason, titles]) => `${titles.join(', ')}: ${reason}`);
}
