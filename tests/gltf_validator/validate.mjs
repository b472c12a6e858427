// node validate.mjs FILE.glb…: prints what the Khronos glTF validator counts per file; ends with 1 on any error or warning.
// `npm install` in this folder first, or set GLTF_VALIDATOR to the package's folder.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import process from 'node:process';

const require = createRequire(import.meta.url);
const validator = require(process.env.GLTF_VALIDATOR ?? 'gltf-validator');

const severities = ['error', 'warning', 'info', 'hint'];
let failed = false;
for (const file of process.argv.slice(2)) {
  const { issues, info } = await validator.validateBytes(new Uint8Array(readFileSync(file)), { uri: file, maxIssues: 100 });
  console.log(
    `${file}: ${issues.numErrors} errors, ${issues.numWarnings} warnings, ${issues.numInfos} infos, ${issues.numHints} hints; ` +
      `${info?.totalTriangleCount ?? 0} triangles, ${info?.totalVertexCount ?? 0} vertices`,
  );
  for (const { severity, code, message, pointer } of issues.messages)
    console.log(`  ${severities[severity]} ${code} ${pointer ?? ''}: ${message}`);
  failed ||= issues.numErrors > 0 || issues.numWarnings > 0;
}
process.exit(failed ? 1 : 0);
