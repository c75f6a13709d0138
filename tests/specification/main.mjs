// The specification tests. Started by tools/specification.
//
//   --json FILE   also write the results there
//
// Exit 0 if everything agrees, 1 if not.
import {copyFileSync, existsSync, mkdtempSync, rmSync, writeFileSync} from 'node:fs';
import {availableParallelism, tmpdir} from 'node:os';
import path from 'node:path';
import {parseArgs} from 'node:util';

import {
  compact, empty, quantizedByOther, readTheirs, roundTrips, written, writtenBySplatTransform,
} from './checks.mjs';
import {makeCloud} from './cloud.mjs';
import {writtenFormats} from './formats.mjs';
import {progress} from './messages.mjs';
import {writePly} from './ply.mjs';
import {versionOf} from './programs.mjs';
import {countChecks, tableOf} from './report.mjs';
import {extremeScene, mixedScene, randomScene, unitScene} from './scenes.mjs';

const scenes = {
  ...Object.fromEntries([0, 1, 2, 3].map((degree) =>
    [`random-sh${degree}`, randomScene(1000, degree, 7 + degree)])),
  one: randomScene(1, 1),
  unit: unitScene(1000, 0, 5),
  mixed: mixedScene(2400, 9),
  extreme: extremeScene(3),
};

/** What splat-transform writes, for some scenes only where that takes seconds or not all do. */
const otherFormats = [
  {output: 'scene.ply'}, {output: 'scene.compressed.ply'}, {output: 'scene.glb'},
  {output: 'scene.v3.spz', options: ['--spz-version', '3']},
  {output: 'scene.v4.spz', options: ['--spz-version', '4']}, {output: 'scene.sog'},
  {output: 'folder/meta.json', only: ['random-sh0', 'random-sh3', 'one']},
  {output: 'streamed/lod-meta.json', only: ['random-sh0', 'random-sh2', 'one']},
  {output: 'scene.splat', only: ['unit']},
];

/** In the folder FLUXGS_DATA: files of other programs, and scenes for us to write. */
const realFiles = [
  'plush-dog/point_cloud_29999_clean.ply', 'plush-dog/point_cloud_29999_clean.compressed.ply',
  'plush-dog/converted/plush-dog.splat', 'plush-dog/converted/plush-dog.v3.spz',
  'plush-dog/converted/plush-dog.v4.spz', 'plush-dog/converted/plush-dog.glb',
  'guitar/guitar.compressed.ply', 'angel-sog/angel.sog', 'biker/biker.compressed.ply',
  'biker/biker.spz',
];
const realScenes = {'plush-dog': 'plush-dog/point_cloud_29999_clean.ply'};
const largeScenes = {guitar: 'guitar/guitar.compressed.ply', biker: 'biker/biker.spz'};

/** Checks on scenes from code. */
function generatedTasks(folder) {
  const tasks = [];
  for (const [name, cloud] of Object.entries(scenes)) {
    const source = path.join(folder, `${name}.source.ply`);
    writePly(source, cloud);
    for (const format of writtenFormats) {
      tasks.push({name, run: () => written(folder, name, source, format)});
    }
    tasks.push({name, run: () => compact(folder, name, source)});
    tasks.push({name, run: () => quantizedByOther(folder, name, source)});
    for (const format of otherFormats.filter(({only}) => !only || only.includes(name))) {
      tasks.push({name, run: () => writtenBySplatTransform(folder, name, source, format)});
    }
  }
  const source = path.join(folder, 'empty.source.ply');
  writePly(source, makeCloud(0, 2));
  tasks.push({name: 'empty', run: () => empty(folder, 'empty', source)});
  return tasks;
}

/** Checks on files of the folder FLUXGS_DATA. They are copied: programs write beside them. */
function realTasks(folder) {
  const data = process.env.FLUXGS_DATA;
  if (!data) return [];
  const tasks = [];
  const add = (file, check) => {
    const from = path.join(data, 'splats', file), name = path.basename(file);
    if (!existsSync(from)) return;
    const copy = path.join(mkdtempSync(path.join(folder, 'real-')), name);
    copyFileSync(from, copy);
    tasks.push({name, run: () => check(name, copy)});
  };
  for (const file of realFiles) add(file, readTheirs);
  const target = mkdtempSync(path.join(folder, 'written-'));
  for (const [name, file] of Object.entries(largeScenes)) {
    add(file, (_, copy) => roundTrips(target, name, copy));
  }
  for (const [name, file] of Object.entries(realScenes)) {
    for (const format of writtenFormats) {
      add(file, (_, copy) => written(target, name, copy, format));
    }
  }
  return tasks;
}

/** Runs tasks beside one another; the results are in the order of the tasks. */
async function runAll(tasks) {
  const results = new Array(tasks.length);
  let next = 0, done = 0;
  const worker = async () => {
    while (next < tasks.length) {
      const at = next++, {name, run} = tasks[at];
      results[at] = await run().catch((error) =>
        [{file: name, program: 'stopped', problems: [error.message]}]);
      progress(`${++done}/${tasks.length} `);
    }
  };
  await Promise.all(Array.from({length: Math.min(4, availableParallelism())}, worker));
  progress('');
  return results.flat();
}

const units = {
  position: 'scene units', scale: 'natural logarithm', rotation: 'degrees, sign-free',
  opacity: '0 to 1', sh_dc: 'coefficient', sh_rest: 'coefficient',
};

const {values: {json}} = parseArgs({options: {json: {type: 'string'}}});
const folder = mkdtempSync(path.join(tmpdir(), 'fluxgs-specification-'));
const began = performance.now();
process.on('exit', () => rmSync(folder, {recursive: true, force: true}));
for (const signal of ['SIGINT', 'SIGTERM']) process.on(signal, () => process.exit(1));
const results = await runAll([...generatedTasks(folder), ...realTasks(folder)]);
const packages = ['gltf-validator', '@gltf-transform/core', '@playcanvas/splat-transform'];
const versions = Object.fromEntries(packages.map((name) => [name, versionOf(name)]));
const {total, failed} = countChecks(results);
const seconds = (performance.now() - began) / 1000;

const listed = (object) => Object.entries(object).map((entry) => entry.join(' ')).join(', ');

console.log(listed(versions));
console.log(`Worst difference of each attribute, in brackets what is allowed: ${listed(units)}.`);
console.log('Where (1) is allowed, steps differ from splat to splat: 1 is what a splat\'s own step allows.');
console.log('Splats are compared one by one in the order of the file, which is that of the scene or is');
console.log('told by a copy with numbered splats. A compact .glb is compared with other readings only.\n');
console.log(tableOf(results).join('\n'));
if (json) {
  const report = {versions, units, checks: total, failed, seconds, results};
  writeFileSync(json, `${JSON.stringify(report, null, 1)}\n`);
}
const agree = total - failed;
console.log(`\n${total} checks in ${seconds.toFixed(0)} s: ${agree} agree, ${failed} do not`);
process.exitCode = failed === 0 ? 0 : 1;
