// node validate.mjs FILE.glb…: prints what the Khronos glTF validator counts per file; ends with 1 on any error or warning, with 2 where
// a file cannot be read. `npm install` in this folder first, or set GLTF_VALIDATOR to the package's folder.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import process from 'node:process';

const require = createRequire(import.meta.url);
const validator = require(process.env.GLTF_VALIDATOR ?? 'gltf-validator');

const severities = ['error', 'warning', 'info', 'hint'];
const files = process.argv.slice(2);
if (files.length === 0) {
  console.error('usage: node validate.mjs FILE.glb…');
  process.exit(2);
}

let failed = false;
for (const file of files) {
  let bytes;
  try {
    bytes = new Uint8Array(readFileSync(file));
  } catch (error) {
    console.error(`${file}: ${error.message}`);
    process.exit(2);
  }
  const { issues, info } = await validator.validateBytes(bytes, { uri: file, maxIssues: 100 });
  console.log(
    `${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} infos, ${issues.numHints} hints; ` +
      `${info?.totalTriangleCount ?? 0} triangles, ${info?.totalVertexCount ?? 0} vertices`,
  );
  for (const { severity, code, message, pointer } of issues.messages)
    console.log(`  ${severities[severity]} ${code} ${pointer ?? ''}: ${message}`);
  failed ||= issues.numErrors > 0 || issues.numWarnings > 0;
}
process.exit(failed ? 1 : 0);
