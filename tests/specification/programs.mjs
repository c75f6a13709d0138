// The programs and packages that take part.
import {execFile} from 'node:child_process';
import {createRequire} from 'node:module';
import path from 'node:path';
import {pathToFileURL} from 'node:url';
import {promisify} from 'node:util';

import {tell} from './messages.mjs';

const run = promisify(execFile);

/** Where tools/specification installed the packages. */
const packages = process.env.FLUXGS_SPECIFICATION_PACKAGES;
const fluxgsBinary = process.env.FLUXGS_BINARY;
if (!packages || !fluxgsBinary) throw new Error('start this with tools/specification');
const require = createRequire(path.join(packages, 'package.json'));

/** An installed package, by its name. */
export const load = (name) => import(pathToFileURL(require.resolve(name)).href);

export const versionOf = (name) =>
  require(path.join(packages, 'node_modules', name, 'package.json')).version;

/** The line in which a program says what went wrong, and how it ended. */
function reasonOf({stderr, stdout, code, signal, message}) {
  const lines = `${stderr ?? ''}\n${stdout ?? ''}`.split('\n')
    .map((line) => line.trim()).filter(Boolean);
  return `${lines.find((line) => /error/i.test(line)) ?? lines.at(-1) ?? message} ` +
    `(${signal ?? `exit ${code}`})`;
}

async function finish(program, args) {
  try {
    await run(program, args, {maxBuffer: 1 << 24});
  } catch (error) {
    throw new Error(`${path.basename(program)} ${args.join(' ')}: ${reasonOf(error)}`);
  }
}

export const fluxgs = (...args) => finish(fluxgsBinary, args);

const splatTransformCommand =
  path.join(packages, 'node_modules/@playcanvas/splat-transform/bin/cli.mjs');

/**
 * Without the GPU, and with one round of k-means: how good its SOG looks is not the question. It is
 * tried twice: that somebody else's program crashes now and then says nothing about ours.
 */
export async function splatTransform(...args) {
  const all = [
    splatTransformCommand, '-q', '-w', '-g', 'cpu', '-i', '1', '--max-workers', '0', ...args,
  ];
  try {
    await finish(process.execPath, all);
  } catch (error) {
    tell(`tried again: ${error.message}\n`);
    await finish(process.execPath, all);
  }
}
