// report.html's program: reads the data that report.cpp wrote into the page and builds the sections from it.
import './viewer.css';
import { eventTable, makeCertificate, residualTable, verdictOf } from './certificate.js';
import { makeFiles, makeSettings, makeTimings, segmentationVerdict, totalSeconds, warningsOf } from './account.js';
import { motionCharts } from './charts.js';
import { jointTable, makeCoronal } from './coronal.js';
import { readBlock, readReport } from './data.js';
import { fixed, h, partTitle, seconds, section, significant } from './dom.js';
import { fillMoments } from './efforts.js';
import { makeFits } from './fits.js';
import { makeHistogram } from './histogram.js';
import { makeMassChart } from './masses.js';
import { makePlayer } from './player.js';
import { makeSlices } from './slices.js';
import { isWhole, makeTables, rowsOf, sourcesOf } from './table.js';
import { makeVolume } from './volume.js';

const readings = {
  hu: 'CT numbers (HU)',
  density_kgm3: 'Mass density (kg/m³)',
  labels: 'A map of labels',
  mr: 'MR signal',
};

async function build() {
  const report = readReport();
  const [body, grey, labels, fits] = await Promise.all(['body', 'grey', 'labels', 'fits'].map(readBlock));
  const rows = rowsOf(report);
  const facts = new Map(rows.filter((r) => Number.isFinite(r.mass)).map((r) => [r.name, r]));
  const page = document.getElementById('page');
  const redraws = [];
  const moments = document.getElementById('moments'); // with its tables, for readers without JavaScript
  const started = report.motion?.times?.[0] ?? report.efforts?.times[0];

  page.replaceChildren(header(report, rows));
  let player = null;
  if (body) {
    const holder = section('body', rows.length > 0 ? 'The moving body' : 'The moving solids');
    page.append(holder);
    try {
      player = await makePlayer(
        body,
        facts,
        report.motion?.gravity_centre
          ? { times: report.motion.times, points: report.motion.gravity_centre }
          : null,
        report.efforts?.forces.length > 0
          ? { times: report.efforts.times, forces: report.efforts.forces, origin: started }
          : null,
      );
      holder.append(player.element);
      player.start();
    } catch (problem) {
      holder.append(
        h(
          'p',
          { class: 'notice' },
          `The moving body cannot be drawn here (${problem.message}). body.glb beside this report holds it for any 3D viewer.`,
        ),
      );
    }
  }
  if (moments) {
    page.append(moments);
    const link = player?.duration > 0 ? { onTime: player.onTime, seek: player.seek } : {};
    redraws.push(fillMoments(moments, report.efforts, { ...link, origin: started }).draw);
  }
  if (rows.length > 0) page.append(anatomy(report, rows, redraws, player?.pick));
  if (report.volume && (grey || labels)) page.append(scan(report, grey, labels, fits, redraws));
  if (report.motion) page.append(motionSection(report.motion, player, redraws));
  const last = account(report);
  if (last) page.append(last);
  redraws.forEach((redraw) => redraw());
  return player;
}

function header(report, rows) {
  const { subject, source, run, motion } = report;
  const verdict = verdictOf(motion);
  const whole = report.table?.body?.mass_kg ?? 0;
  const found = rows.filter(({ completeness }) => completeness === 'whole').length;
  const cut = rows.filter(({ completeness }) => completeness === 'cut').length;
  const duration = motion?.times?.length > 1 ? motion.times.at(-1) - motion.times[0] : 0;
  const fact = (value, unit, name) =>
    h('div', {}, h('dt', {}, name), h('dd', {}, value, unit ? h('small', {}, ` ${unit}`) : null));
  const took = seconds(totalSeconds(run)).split(/\s/); // "2 min 22 s"
  const numbers = (words) => words.map((word, i) => (i % 2 ? h('small', {}, ` ${word} `) : word));
  const parts = segmentationVerdict(report.segmentation);
  const warnings = warningsOf(report).filter(({ text }) => !parts?.reasons.includes(text));
  const facts = [
    whole > 0 ? fact(significant(whole, 4), 'kg', isWhole(report) ? 'body mass' : 'in the scan') : null,
    report.length?.metres > 0
      ? fact(fixed(report.length.metres, 2), 'm', report.length.given ? 'stature' : 'from vertex to sole')
      : null,
    rows.length > 0
      ? fact(String(found), `of ${rows.length}${cut ? `, ${cut} cut` : ''}`, 'parts whole')
      : null,
    parts
      ? h('div', { class: parts.look }, h('dt', {}, 'the segmentation'), h('dd', {}, parts.verdict))
      : null,
    motion ? fact(significant(duration, 3), 's', 'of motion') : null,
    verdict
      ? h(
          'div',
          { class: verdict.trusted ? 'good' : 'bad' },
          h('dt', {}, 'the motion'),
          h('dd', {}, verdict.text),
        )
      : null,
    run?.stages?.length ? fact(numbers(took.slice(0, -1)), took.at(-1), 'of computing') : null,
  ].filter(Boolean);
  return h(
    'header',
    {},
    h('p', { class: 'wordmark' }, 'borelli'),
    h('h1', {}, subject),
    source ? h('p', { class: 'source' }, sourceText(report)) : null,
    facts.length > 0 ? h('dl', { class: 'facts' }, facts) : null,
    parts?.reasons.length > 0
      ? h(
          'aside',
          { class: `verdict ${parts.look}`, 'aria-label': 'Verdict on the segmentation' },
          h('h2', {}, `The segmentation is ${parts.verdict}`),
          h(
            'ul',
            {},
            parts.reasons.map((text) => h('li', {}, text)),
          ),
        )
      : null,
    report.segmentation?.absent
      ? h(
          'p',
          { class: 'quiet absent' },
          `Stated as absent, with the parts beyond: ${report.segmentation.absent.split(',').map(partTitle).join(', ')}.`,
        )
      : null,
    warnings.length > 0
      ? h(
          'aside',
          { class: 'warnings', 'aria-label': 'Warnings' },
          h('h2', {}, warnings.length === 1 ? 'One warning' : `${warnings.length} warnings`),
          h(
            'ul',
            {},
            warnings.map(({ stage, text }) =>
              h('li', {}, stage ? h('span', { class: 'stage-name' }, `${stage}: `) : null, text),
            ),
          ),
        )
      : null,
  );
}

function sourceText({ source, segmentation, run }) {
  const size = source.size.join(' × ');
  const spacing = source.spacing.map((s) => fixed(s, s < 1 ? 3 : 2).replace(/\.?0+$/, '')).join(' × ');
  const reading = segmentation?.reading ?? run?.stages?.find((stage) => stage.reading)?.reading;
  const what = reading?.replace(/\.$/, '') ?? readings[source.quantity] ?? source.quantity;
  return `${size} voxels of ${spacing} mm. ${what}.`;
}

function anatomy(report, rows, redraws, pick) {
  const sources = sourcesOf(rows);
  const chart = makeMassChart(rows, sources, isWhole(report) ? 'the body’s mass' : 'the mass in the scan');
  redraws.push(chart.draw);
  return section('inertia', 'Parts and their inertia', chart.element, makeTables(report, rows, sources, pick));
}

function scan(report, grey, labels, fits, redraws) {
  const volume = makeVolume({ ...report.source, ...report.volume }, grey, labels);
  const shown = report.parts.filter(({ label }) => label !== undefined);
  const slices = makeSlices(volume, shown);
  const content = [slices.element];
  redraws.push(slices.redraw);
  if (report.joints?.length > 0) {
    const coronal = makeCoronal(volume, shown, report.joints, report.cuts);
    redraws.push(coronal.redraw);
    content.push(
      h('h3', {}, report.cuts?.lines.length ? 'Joint centres and cut planes' : 'Joint centres'),
      h(
        'div',
        { class: 'joints-view' },
        coronal.element,
        h('div', { class: 'scroll' }, jointTable(report.joints)),
      ),
    );
  }
  if (fits)
    content.push(
      h('h3', {}, 'Spheres and cylinders on bone'),
      h(
        'p',
        { class: 'quiet' },
        'Where the circle runs along the bone’s edge, the joint centre is measured; where it does not, distrust it.',
      ),
      makeFits(report.fits, fits),
    );
  if (report.histogram?.all.length > 1) {
    const chart = makeHistogram(report.histogram, report.source.quantity);
    redraws.push(chart.draw);
    content.push(h('h3', {}, 'Grey values'), chart.element);
  }
  const face = { taken: ' The face was removed.', hidden: ' Grey values outside the labelled parts are left out.' };
  const step = fixed(volume.step, 1);
  return section(
    'scan',
    'The scan',
    h(
      'p',
      { class: 'quiet' },
      `Shown at ${step} mm. Drag in a picture to move the other two. As radiologists look: the patient’s right is on the left.${face[report.face] ?? ''}`,
    ),
    content,
  );
}

function motionSection(motion, player, redraws) {
  const charts = motion.kinetic && motion.potential ? motionCharts(motion, player) : [];
  redraws.push(...charts.map(({ draw }) => draw));
  const counted = (n, one, many) => `${n} ${n === 1 ? one : many}`;
  const about = `${counted(motion.solids, 'solid', 'solids')}, ${counted(motion.coordinates, 'coordinate is', 'coordinates are')} free.`;
  return section(
    'motion',
    'The motion and its certificate',
    h('p', { class: 'quiet' }, about),
    makeCertificate(motion),
    h(
      'div',
      { class: 'charts' },
      charts.map(({ element }) => element),
    ),
    residualTable(motion),
    eventTable(motion),
  );
}

function account(report) {
  const content = [makeTimings(report.run), makeFiles(report.files)].filter(Boolean);
  const settings = makeSettings(report.run);
  if (content.length === 0 && !settings) return null;
  return section('run', 'The run', h('div', { class: 'account' }, content), settings);
}

// For tests and readers' scripts: `ready` resolves when all is drawn; seek(t) poses the body at t
// seconds and draws it before it returns.
window.borelli = {
  ready: build().then((player) => {
    window.borelli.duration = player?.duration ?? 0;
    window.borelli.seek = (time) => player?.seek(time);
    document.documentElement.dataset.ready = 'true';
  }),
  seek: () => {},
  duration: 0,
};
window.borelli.ready.catch((problem) => {
  console.error(problem);
  document
    .getElementById('page')
    .append(h('p', { class: 'notice' }, `This report could not be drawn: ${problem.message}`));
});
