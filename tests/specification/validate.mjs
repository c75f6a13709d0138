// The Khronos glTF validator on a .glb. It does not know KHR_gaussian_splatting yet: its attribute
// names are invalid to it, and it says that it cannot look into the extension. Exactly this is
// allowed, attribute by attribute, and nothing else.
import {readFileSync} from 'node:fs';

import {load} from './programs.mjs';

const validator = (await load('gltf-validator')).default;

const ourExtensions = ['KHR_gaussian_splatting', 'FLUXGS_gaussian_splatting_compact'];
const severities = ['error', 'warning', 'information', 'hint'];

const splatSemantics = new Set([
  ...['ROTATION', 'SCALE', 'OPACITY'],
  ...[0, 1, 2, 3].flatMap((l) =>
    Array.from({length: 2 * l + 1}, (_, m) => `SH_DEGREE_${l}_COEF_${m}`)),
].map((name) => `KHR_gaussian_splatting:${name}`));

/** The JSON chunk of a .glb (glTF 2.0, section 4.4). */
function jsonOf(bytes) {
  const length = bytes.readUInt32LE(12);
  return JSON.parse(bytes.toString('utf8', 20, 20 + length));
}

/** Buffer views that only the compact extension names, where the validator cannot look. */
function compactViews(json) {
  return (json.meshes ?? []).flatMap((mesh) => mesh.primitives).map((primitive) =>
    primitive.extensions?.KHR_gaussian_splatting?.extensions
      ?.FLUXGS_gaussian_splatting_compact?.bufferView);
}

/** Every message that must be there, as `severity code pointer`. */
function expectedMessages(json) {
  const messages = [];
  (json.extensionsUsed ?? []).forEach((name, i) => {
    if (ourExtensions.includes(name)) {
      messages.push(`information UNSUPPORTED_EXTENSION /extensionsUsed/${i}`);
    }
  });
  (json.meshes ?? []).forEach((mesh, m) => mesh.primitives.forEach((primitive, p) => {
    for (const name of Object.keys(primitive.attributes)) {
      if (!splatSemantics.has(name)) continue;
      messages.push('error MESH_PRIMITIVE_INVALID_ATTRIBUTE ' +
        `/meshes/${m}/primitives/${p}/attributes/${name}`);
    }
  }));
  for (const view of compactViews(json)) {
    if (view !== undefined) messages.push(`information UNUSED_OBJECT /bufferViews/${view}`);
  }
  return messages;
}

/** What the validator says beyond what it must say of such a file, and what it does not say. */
export async function unexpectedMessages(file) {
  const bytes = readFileSync(file);
  const report = await validator.validateBytes(new Uint8Array(bytes), {
    uri: 'scene.glb', maxIssues: 0, writeTimestamp: false,
    externalResourceFunction: () => Promise.reject(new Error('a .glb of ours has no other files')),
  });
  const said = report.issues.messages.map((issue) =>
    ({line: `${severities[issue.severity]} ${issue.code} ${issue.pointer}`, text: issue.message}));
  const expected = new Set(expectedMessages(jsonOf(bytes)));
  const unexpected = said.filter(({line}) => !expected.has(line))
    .map(({line, text}) => `${line}: ${text}`);
  const missing = [...expected].filter((line) => !said.some((one) => one.line === line))
    .map((line) => `not said: ${line}`);
  return [...unexpected, ...missing];
}
