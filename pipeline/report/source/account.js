// The run's account: what was read, how long each stage took, the settings, and the files beside the report.
import { bytes, fixed, h, partTitle, seconds } from './dom.js';
import { settingInWords } from './words.js';

const looks = { good: 'good', doubtful: 'doubt', refused: 'bad' };

/** The verdict in segmentation.json: {verdict, reasons (worst first), look (a class)}; null without one. */
export function segmentationVerdict(segmentation) {
  const look = looks[segmentation?.verdict];
  if (!look) return null;
  const reasons = Array.isArray(segmentation.verdict_reasons) ? segmentation.verdict_reasons.map(String) : [];
  return { verdict: segmentation.verdict, reasons, look };
}

/** Every warning of the run's stages and of segmentation, each once, as {stage, text}. */
export function warningsOf({ run, segmentation }) {
  const all = new Map();
  const collect = (stage, list) => {
    for (const text of Array.isArray(list) ? list : [])
      if (!all.has(text)) all.set(text, { stage, text: String(text) });
  };
  collect(null, run?.warnings);
  for (const stage of run?.stages ?? []) collect(stage.stage, stage.warnings);
  collect('segmentation', segmentation?.warnings);
  return [...all.values()];
}

export const totalSeconds = (run) => (run?.stages ?? []).reduce((sum, { seconds: s }) => sum + (s ?? 0), 0);

export function makeTimings(run) {
  const stages = run?.stages ?? [];
  if (stages.length === 0) return null;
  const longest = Math.max(...stages.map(({ seconds: s }) => s ?? 0), 1e-9);
  return h(
    'div',
    { class: 'scroll' },
    h(
      'table',
      { class: 'numbers timings' },
      h('caption', {}, `Stages of this run, ${seconds(totalSeconds(run))} in all, some in parallel`),
      h(
        'thead',
        {},
        h(
          'tr',
          {},
          h('th', { scope: 'col' }, 'Stage'),
          h('th', { scope: 'col', class: 'number' }, 'time'),
          h('th', { 'aria-hidden': 'true' }),
          h('th', { scope: 'col', class: 'number' }, 'peak memory'),
        ),
      ),
      h(
        'tbody',
        {},
        stages.map((stage) =>
          h(
            'tr',
            {},
            h('th', { scope: 'row' }, stage.stage),
            h('td', { class: 'number' }, seconds(stage.seconds)),
            h(
              'td',
              { class: 'bar-cell', 'aria-hidden': 'true' },
              h('span', { class: 'bar', style: { width: `${(100 * (stage.seconds ?? 0)) / longest}%` } }),
            ),
            h(
              'td',
              { class: 'number' },
              Number.isFinite(stage.peak_memory_mib) ? `${fixed(stage.peak_memory_mib, 0)} MiB` : '–',
            ),
          ),
        ),
      ),
    ),
  );
}

/** The settings as terms and values: run.json's head (all but the stages), or the stages' settings if it has none. */
export function makeSettings(run) {
  if (!run) return null;
  const rows = [];
  for (const [key, value] of Object.entries(run))
    if (key !== 'stages' && key !== 'warnings') flatten(key, value, rows);
  if (!run.settings) for (const stage of run.stages ?? []) flatten(stage.stage, stage.settings, rows);
  if (rows.length === 0) return null;
  return h(
    'details',
    {},
    h('summary', {}, 'Versions, inputs and settings'),
    h(
      'dl',
      { class: 'settings' },
      rows.flatMap(([term, value]) => [h('dt', {}, term), h('dd', {}, value)]),
    ),
  );
}

function flatten(term, value, rows) {
  if (value === null || value === undefined || value === '') return;
  if (Array.isArray(value) && value.every((v) => typeof v !== 'object')) {
    if (value.length) rows.push(settingInWords(term, value.join(', ')));
  } else if (typeof value === 'object') {
    for (const [key, inner] of Object.entries(value)) flatten(`${term} · ${key}`, inner, rows);
  } else rows.push(settingInWords(term, value));
}

const said = {
  'segmentation/labels.nii.gz': 'the parts, voxel by voxel',
  'segmentation/labels.tsv': 'the labels’ names',
  'segmentation/parts.nii.gz': 'all parts, before the segments were selected',
  'segmentation/landmarks.json': 'joint centres and bony points',
  'inertia/table.csv': 'the inertia table, for a spreadsheet',
  'inertia/table.json': 'the inertia table, for programs',
  'model/scene.toml': 'the skeleton, to read, change and simulate again',
  'motion/trajectory.h5': 'the motion: coordinates, poses, energies',
  'motion/trajectory.csv': 'the motion as a table',
  'body.glb': 'the moving body, for any 3D viewer',
  'body.png': 'a picture of the body',
  'run.json': 'the record of this run: stages, settings, warnings',
};

export function makeFiles(files) {
  if (!files?.length) return null;
  const link = ({ path, bytes: size }, text) =>
    h(
      'a',
      { href: path.split('/').map(encodeURIComponent).join('/'), download: true, title: bytes(size) },
      text,
    );
  const meshes = files.filter(({ path }) => path.startsWith('mesh/'));
  const others = files.filter(({ path }) => !path.startsWith('mesh/'));
  return h(
    'div',
    { class: 'files' },
    h('h3', {}, 'Files beside this report'),
    h(
      'ul',
      {},
      others.map((file) =>
        h(
          'li',
          {},
          link(file, file.path),
          h(
            'span',
            { class: 'quiet' },
            ` ${[said[file.path], bytes(file.bytes)].filter(Boolean).join(', ')}`,
          ),
        ),
      ),
    ),
    meshes.length
      ? h(
          'details',
          {},
          h(
            'summary',
            {},
            `${meshes.length} surfaces in mesh/ (${bytes(meshes.reduce((sum, m) => sum + m.bytes, 0))})`,
          ),
          h(
            'ul',
            { class: 'columns' },
            meshes.map((file) => h('li', {}, link(file, nameOf(file.path)))),
          ),
        )
      : null,
  );
}

function nameOf(path) {
  const [stem, extension] = path.slice('mesh/'.length).split('.');
  return `${partTitle(stem)} (${extension})`;
}
