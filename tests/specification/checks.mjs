// The checks: what is written by whom, read by whom, and compared with what. Each returns results
// as in report.mjs, and leaves its files in `folder`.
import {mkdirSync} from 'node:fs';
import path from 'node:path';

import {reordered, worstDifferences} from './cloud.mjs';
import {
  decodingTolerance, splatLevelTurn, withOtherSplatLevels, writtenFormats,
} from './formats.mjs';
import {countGlb, quantizeGlb, readGlb} from './glb.mjs';
import {numbered, numbersOf} from './order.mjs';
import {readPly, writePly} from './ply.mjs';
import {fluxgs, splatTransform} from './programs.mjs';
import {comparison} from './report.mjs';
import {unexpectedMessages} from './validate.mjs';

/** fluxgs' own reading of a file. */
async function readByUs(file) {
  const out = `${file}.fluxgs.ply`;
  await fluxgs('convert', file, out, '--force');
  return readPly(out);
}

/** Where splat-transform's .ply of a file lies. */
const otherPly = (file) => `${file}.other.ply`;

async function readBySplatTransform(file) {
  const out = otherPly(file);
  await splatTransform(file, out);
  return readPly(out);
}

const isGlb = (file) => file.endsWith('.glb');

/** The independent reader of a file; splat-transform does not read .glb. */
const otherReader = (file) => isGlb(file) ? 'glTF-Transform' : 'splat-transform';
const readByOther = (file) => isGlb(file) ? readGlb(file) : readBySplatTransform(file);

/** Two readings of the same bytes. */
const sameReading = (label, program, ours, other) =>
  comparison(label, program, other.count, worstDifferences(other, ours), decodingTolerance(ours));

/** Our reading of a file and that of the independent reader. */
const asOther = (file, label, ours, other) => sameReading(label, `fluxgs = ${otherReader(file)}`,
  file.endsWith('.splat') ? withOtherSplatLevels(ours) : ours, other);

/** The Khronos validator has nothing to say but what it must. */
const validate = async (label, file) =>
  ({file: label, program: 'glTF validator', problems: await unexpectedMessages(file)});

/** A scene in a format that we write. */
const write = (source, file, format) =>
  fluxgs('convert', source, file, ...(format.options ?? []));

/** The cloud in the order in which the format stores it. */
async function asStored(cloud, file, format) {
  if (!format.reorders) return cloud;
  const source = `${file}.numbered.ply`, stored = `${file}.numbered${format.extension}`;
  writePly(source, numbered(cloud));
  await write(source, stored, format);
  return reordered(cloud, numbersOf(await readByUs(stored)));
}

/** A file as we read it, against what it was made from: only its quantization may lie between. */
async function thereAndBack(cloud, file, format) {
  const label = path.basename(file), source = await asStored(cloud, file, format);
  const {allowed, measures} = await format.quantization(source, file);
  const fewerBands = format.maxDegree < cloud.degree;
  const against = (program, reading, more = {}) => comparison(label, program, reading.count,
    worstDifferences(source, reading, {measures, fewerBands}), {...allowed, ...more});
  const ours = await readByUs(file);
  return {ours, allowed, against, results: [against('there and back', ours)]};
}

/** Only there and back, for large scenes: `source` in every format that we write. */
export async function roundTrips(folder, name, source) {
  const cloud = await readByUs(source);
  const results = [];
  for (const format of writtenFormats) {
    const file = path.join(folder, `${name}${format.extension}`);
    await write(source, file, format);
    results.push(...(await thereAndBack(cloud, file, format)).results);
  }
  return results;
}

/** A scene in a format that we write: there and back, and through an independent reader. */
export async function written(folder, name, source, format) {
  const file = path.join(folder, `${name}${format.extension}`), label = path.basename(file);
  await write(source, file, format);
  const {ours, allowed, against, results} = await thereAndBack(readPly(source), file, format);
  const other = await readByOther(file);
  const more = format.extension === '.splat' ? {rotation: allowed.rotation + splatLevelTurn} : {};
  results.push(against(`${otherReader(file)} reads`, other, more));
  results.push(asOther(file, label, ours, other));
  if (isGlb(file)) results.push(await validate(label, file));
  return results;
}

/**
 * The kinds of compact .glb: with plain attributes glTF-Transform finds in the file what we decode;
 * without, the extension is required, and we decode the same.
 */
export async function compact(folder, name, source) {
  const required = path.join(folder, `${name}.compact.glb`);
  const plain = path.join(folder, `${name}.compact-plain.glb`);
  await fluxgs('convert', source, required, '--compact');
  await fluxgs('convert', source, plain, '--compact', '--plain-attributes');
  const ours = await readByUs(required), oursPlain = await readByUs(plain);
  const label = path.basename(plain);
  return [
    await validate(path.basename(required), required), await validate(label, plain),
    sameReading(label, 'fluxgs = glTF-Transform', oursPlain, await readGlb(plain)),
    sameReading(label, 'as without attributes', ours, oursPlain),
  ];
}

/** Attributes that glTF-Transform turned into integers: we decode what it decodes. */
export async function quantizedByOther(folder, name, source) {
  const plain = path.join(folder, `${name}.to-quantize.glb`), results = [];
  await fluxgs('convert', source, plain);
  for (const bits of [8, 16]) {
    const file = path.join(folder, `${name}.other-${bits}-bit.glb`);
    await quantizeGlb(plain, file, bits);
    const ours = await readByUs(file), other = await readGlb(file);
    results.push(asOther(file, `glTF-Transform: ${name}.${bits}-bit.glb`, ours, other));
  }
  return results;
}

/** A scene without splats, as .glb. */
export async function empty(folder, name, source) {
  const results = [];
  for (const options of [[], ['--compact'], ['--compact', '--plain-attributes']]) {
    const label = [name, ...options.map((option) => option.slice(2)), 'glb'].join('.');
    const file = path.join(folder, label);
    await fluxgs('convert', source, file, ...options);
    const count = await countGlb(file);
    results.push(await validate(label, file), {
      file: label, program: 'glTF-Transform reads',
      problems: count === 0 ? [] : [`${count} splats in an empty scene`],
    });
  }
  return results;
}

/** A file of another program: what it reads from it and what we read from it agree. */
export async function readTheirs(label, file) {
  const other = await readByOther(file);
  const results = [asOther(file, label, await readByUs(file), other)];
  if (!isGlb(file)) {
    // What splat-transform makes of its file is one more file for us to read
    const again = await readByUs(otherPly(file));
    results.push(sameReading(label, 'its .ply, read by fluxgs', again, other));
  }
  return results;
}

/** A scene in a format that splat-transform writes. `output` is a file's name or `folder/name`. */
export async function writtenBySplatTransform(folder, name, source, {output, options = []}) {
  const file = path.join(folder, 'splat-transform', name, output);
  mkdirSync(path.dirname(file), {recursive: true});
  await splatTransform(...options, source, file);
  return readTheirs(`splat-transform: ${name}/${output}`, file);
}
