// Bundles source/ into the programs and styles beside this file; with --check only compares with the ones that are
// there, byte for byte. Run by `npm run bundle` and `npm run check`.
//   uplot_program.js, page_style.css     uPlot and the style, of every page
//   viewer_program.js, viewer_style.css  the report's own
//   chart_program.js, chart_style.css    those of pages of charts
import { build } from 'esbuild';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const largest = 1_000_000; // bytes: every report carries the bundle

// entry point, outputs, packages in it
const bundles = [
  { entry: 'source/uplot.js', program: 'uplot_program.js', style: 'page_style.css', holds: ['uplot'] },
  { entry: 'source/viewer.js', program: 'viewer_program.js', style: 'viewer_style.css', holds: ['three'] },
  { entry: 'source/chart_page.js', program: 'chart_program.js', style: 'chart_style.css', holds: [] },
];

// The licences of what is bundled ask that their text goes with every copy.
function licences(names) {
  const { dependencies } = JSON.parse(readFileSync(here('package.json'), 'utf8'));
  return names
    .map((name) => [name, dependencies[name]])
    .map(([name, version]) => {
      const text = readFileSync(here(`node_modules/${name}/LICENSE`), 'utf8')
        .trim()
        .replaceAll('*/', '* /');
      return `${name} ${version}\n\n${text}\n`;
    })
    .join('\n');
}

async function bundle({ entry, program, style, holds }) {
  const { outputFiles } = await build({
    absWorkingDir: here('.'),
    entryPoints: [entry],
    alias: holds.includes('uplot') ? {} : { uplot: './source/global_uplot.js' },
    bundle: true,
    minify: true,
    write: false,
    outdir: '.',
    format: 'iife',
    target: ['chrome110', 'firefox115', 'safari16.4'],
    charset: 'utf8',
    legalComments: 'none', // the banner holds the whole licences
    banner: holds.length > 0 ? { js: `/*!\nThis file holds, bundled:\n\n${licences(holds)}*/` } : {},
    logLevel: 'warning',
  });
  return outputFiles.map(({ path, contents, text }) => {
    // CMake embeds both as C++ raw strings with this delimiter
    if (text.includes(')~~"')) throw new Error(`${path} holds )~~", which ends a raw string`);
    return {
      path: here(path.endsWith('.css') ? style : program),
      contents: Buffer.from(contents),
    };
  });
}

const files = (await Promise.all(bundles.map(bundle))).flat();
const total = files.reduce((sum, { contents }) => sum + contents.length, 0);
if (total >= largest) {
  console.error(`the bundles have ${total} bytes, more than the ${largest} that a report may carry`);
  process.exit(1);
}
if (process.argv.includes('--check')) {
  const stale = files.filter(
    ({ path, contents }) => !existsSync(path) || !readFileSync(path).equals(contents),
  );
  for (const { path } of stale) console.error(`${path} is not what its source gives: npm run bundle`);
  if (stale.length > 0) process.exit(1);
  console.log(`the bundles are their source's (${total} bytes)`);
} else {
  for (const { path, contents } of files) writeFileSync(path, contents);
  console.log(`bundled (${total} bytes)`);
}
