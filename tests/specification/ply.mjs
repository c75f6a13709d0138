// 3DGS .ply: binary, little-endian, float properties by name in any order.
import {readFileSync, writeFileSync} from 'node:fs';

import {makeCloud, restCount, widths} from './cloud.mjs';

const numbered = (stem, count) => Array.from({length: count}, (_, i) => `${stem}_${i}`);

/** Names of the properties of each part of a cloud. */
const propertiesOf = (degree) => ({
  position: ['x', 'y', 'z'],
  scale: numbered('scale', 3),
  rotation: numbered('rot', 4),
  opacity: ['opacity'],
  dc: numbered('f_dc', 3),
  rest: numbered('f_rest', 3 * restCount(degree)),
});

function readHeader(bytes, file) {
  const end = bytes.indexOf('end_header\n');
  const lines = bytes.toString('latin1', 0, end).split('\n');
  if (end < 0 || lines[0] !== 'ply' || lines[1] !== 'format binary_little_endian 1.0') {
    throw new Error(`${file}: not a binary little-endian .ply`);
  }
  const words = lines.map((line) => line.split(' '));
  const elements = words.filter(([word]) => word === 'element');
  const properties = words.filter(([word]) => word === 'property');
  if (elements.length !== 1 || properties.some(([, type]) => type !== 'float')) {
    throw new Error(`${file}: expected one element with float properties`);
  }
  return {
    count: Number(elements[0][2]),
    names: properties.map(([, , name]) => name),
    offset: end + 'end_header\n'.length,
  };
}

export function readPly(file) {
  const bytes = readFileSync(file);
  const {count, names, offset} = readHeader(bytes, file);
  const body = bytes.subarray(offset);
  if (body.length !== count * names.length * 4) throw new Error(`${file}: wrong size`);
  const floats = new Float32Array(new Uint8Array(body).buffer);
  const bands = names.filter((name) => name.startsWith('f_rest_')).length / 3;
  const degree = Math.sqrt(bands + 1) - 1;
  if (![0, 1, 2, 3].includes(degree)) throw new Error(`${file}: ${bands} coefficients a channel`);
  const cloud = makeCloud(count, degree);
  for (const [part, properties] of Object.entries(propertiesOf(degree))) {
    properties.forEach((name, c) => {
      const column = names.indexOf(name);
      if (column < 0) throw new Error(`${file}: no property ${name}`);
      for (let i = 0; i < count; ++i) {
        cloud[part][i * properties.length + c] = floats[i * names.length + column];
      }
    });
  }
  return cloud;
}

export function writePly(file, cloud) {
  const parts = Object.entries(propertiesOf(cloud.degree));
  const names = parts.flatMap(([, properties]) => properties);
  const floats = new Float32Array(cloud.count * names.length);
  let column = 0;
  for (const [part, width] of Object.entries(widths(cloud.degree))) {
    for (let i = 0; i < cloud.count; ++i) {
      for (let c = 0; c < width; ++c) {
        floats[i * names.length + column + c] = cloud[part][i * width + c];
      }
    }
    column += width;
  }
  const header = `ply\nformat binary_little_endian 1.0\nelement vertex ${cloud.count}\n` +
    names.map((name) => `property float ${name}\n`).join('') + 'end_header\n';
  writeFileSync(file, Buffer.concat([Buffer.from(header), Buffer.from(floats.buffer)]));
}
