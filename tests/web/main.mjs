// main.mjs [FILTER]: tests the viewer for browsers; tests/web/run sets the variables.
import {spawnSync} from 'node:child_process';
import {createRequire} from 'node:module';
import {mkdtemp, rm} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {Checks} from './checks.mjs';
import {makeModule, testDecoding} from './decoding.mjs';
import {serve} from './server.mjs';
import {testViewing} from './viewing.mjs';

const {FLUXGS_BINARY: fluxgs, FLUXGS_WEB_TEST_PACKAGES: packages, FLUXGS_BROWSER: program} = process.env;
const puppeteer = createRequire(join(packages, 'package.json'))('puppeteer-core');
const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
const began = performance.now();
const checks = new Checks(process.argv[2]);
const work = await mkdtemp(join(tmpdir(), 'fluxgs-web-'));

/** The sample scene in every format that a page reads. */
const sample = join(root, 'app/src/main/assets/sample.glb');
const scenes = [sample];
for (const name of ['sample.ply', 'sample.compressed.ply', 'sample.spz', 'sample.splat', 'sample.sog']) {
  const made = spawnSync(fluxgs, ['convert', sample, join(work, name)], {encoding: 'utf8'});
  if (made.status !== 0) throw new Error(made.stderr);
  scenes.push(join(work, name));
}
const server = await serve([join(root, 'build/web/site/page'), work, dirname(sample)]);
const browser = await puppeteer.launch({executablePath: program, protocolTimeout: 120000,
  args: ['--no-sandbox', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--hide-scrollbars']});
let status = 1;
try {
  await testDecoding(checks, {module: await makeModule(join(root, 'build/web/bin')), fluxgs, scenes, work});
  await testViewing(checks, {browser, server, fluxgs, work, scenes: [sample, join(work, 'sample.spz')]});
  status = checks.finish(began);
} finally {
  await browser.close();
  server.close();
  await rm(work, {recursive: true, force: true});
}
process.exit(status);
