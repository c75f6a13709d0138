// main.mjs [FILTER]: tests the viewer for browsers; tests/web/run sets the variables.
import {spawnSync} from 'node:child_process';
import {createRequire} from 'node:module';
import {mkdtemp, rm} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {setTimeout as sleep} from 'node:timers/promises';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {DRIVERS, WEBGPU} from './browsers.mjs';
import {Checks} from './checks.mjs';
import {makeModule, testDecoding} from './decoding.mjs';
import {testGraphics} from './graphics.mjs';
import {testPackages} from './packages.mjs';
import {serve} from './server.mjs';
import {testTroubles} from './troubles.mjs';
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
const launch = (...more) => puppeteer.launch({executablePath: program, protocolTimeout: 120000,
  args: ['--no-sandbox', '--hide-scrollbars', ...DRIVERS.swiftshader, ...more]});
const browser = await launch(), withWebGpu = await launch(...WEBGPU);
let status = 1;
try {
  await testDecoding(checks, {module: await makeModule(join(root, 'build/web/bin')), fluxgs, scenes, work});
  const tools = {browser, server, fluxgs, work, index: join(root, 'build/web/site/page/index.html'), scenes: [sample, join(work, 'sample.spz')]};
  await testViewing(checks, tools);
  await testTroubles(checks, tools);
  await testGraphics(checks, {...tools, browser: withWebGpu, plain: browser});
  await testPackages(checks, {browser, root, work, sample});
  status = checks.finish(began);
} finally {
  // A browser that hangs is killed when this process ends
  await Promise.race([Promise.all([browser.close(), withWebGpu.close()]), sleep(10000)]);
  server.close();
  await rm(work, {recursive: true, force: true});
}
process.exit(status);
