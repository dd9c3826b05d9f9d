// Bundles source/ into viewer_program.js and viewer_style.css beside this file; with --check only compares with the
// ones that are there, byte for byte. Run by `npm run bundle` and `npm run check`.
import { build } from 'esbuild';
import { existsSync, readFileSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';

const here = (path) => fileURLToPath(new URL(path, import.meta.url));
const largest = 1_000_000; // bytes: every report carries the bundle

// The licences of what is bundled ask that their text goes with every copy.
function licences() {
  const { dependencies } = JSON.parse(readFileSync(here('package.json'), 'utf8'));
  return Object.entries(dependencies)
    .map(([name, version]) => {
      const text = readFileSync(here(`node_modules/${name}/LICENSE`), 'utf8')
        .trim()
        .replaceAll('*/', '* /');
      return `${name} ${version}\n\n${text}\n`;
    })
    .join('\n');
}

async function bundle() {
  const { outputFiles } = await build({
    absWorkingDir: here('.'),
    entryPoints: { viewer: 'source/viewer.js' },
    bundle: true,
    minify: true,
    write: false,
    outdir: '.',
    format: 'iife',
    target: ['chrome110', 'firefox115', 'safari16.4'],
    charset: 'utf8',
    legalComments: 'none', // the banner holds the whole licences
    banner: { js: `/*!\nThis file holds, bundled:\n\n${licences()}*/` },
    logLevel: 'warning',
  });
  return outputFiles.map(({ path, contents, text }) => {
    // CMake embeds both as C++ raw strings with this delimiter
    if (text.includes(')~~"')) throw new Error(`${path} holds )~~", which ends a raw string`);
    return {
      path: here(path.endsWith('.css') ? 'viewer_style.css' : 'viewer_program.js'),
      contents: Buffer.from(contents),
    };
  });
}

const files = await bundle();
const total = files.reduce((sum, { contents }) => sum + contents.length, 0);
if (total >= largest) {
  console.error(`the bundle has ${total} bytes, more than the ${largest} that a report may carry`);
  process.exit(1);
}
if (process.argv.includes('--check')) {
  const stale = files.filter(
    ({ path, contents }) => !existsSync(path) || !readFileSync(path).equals(contents),
  );
  for (const { path } of stale) console.error(`${path} is not what its source gives: npm run bundle`);
  if (stale.length > 0) process.exit(1);
  console.log(`the bundle is its source's (${total} bytes)`);
} else {
  for (const { path, contents } of files) writeFileSync(path, contents);
  console.log(`bundled (${total} bytes)`);
}
