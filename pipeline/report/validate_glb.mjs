// node validate_glb.mjs FILE...: Khronos' glTF validator on each file; fails on anything it finds, hints included.
import { readFileSync } from 'node:fs';
import validator from 'gltf-validator';

let found = 0;
for (const path of process.argv.slice(2)) {
  const { issues } = await validator.validateBytes(new Uint8Array(readFileSync(path)), { maxIssues: 20 });
  for (const { code, message, pointer } of issues.messages)
    console.error(`${path}: ${code} ${pointer}: ${message}`);
  found += issues.numErrors + issues.numWarnings + issues.numInfos + issues.numHints;
}
process.exit(found > 0 || process.argv.length < 3 ? 1 : 0);
