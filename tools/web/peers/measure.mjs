// Measures viewers for browsers side by side; tools/web/peers/run sets the variables and has the usage.
import {appendFileSync, readFileSync, writeFileSync} from 'node:fs';
import {mkdtemp, rm, symlink, writeFile} from 'node:fs/promises';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {basename, dirname, join, resolve} from 'node:path';
import {fileURLToPath} from 'node:url';
import {parseArgs} from 'node:util';
import {DRIVERS, WEBGPU} from '../../../tests/web/browsers.mjs';
import {cameraOf, renderPng} from '../../../tests/web/compare.mjs';
import {serve} from '../../../tests/web/server.mjs';

const {FLUXGS_BINARY: fluxgs, FLUXGS_PEERS_PACKAGES: packages, FLUXGS_BROWSER: program} = process.env;
const puppeteer = createRequire(join(packages, 'package.json'))('puppeteer-core');
const here = dirname(fileURLToPath(import.meta.url)), root = join(here, '../../..');

const SIZE = {width: 1280, height: 720};
const WARM_UP = 3, FRAMES = 12, ROUNDS = 3;
/** Names for people, the module, how the page is asked for it, and what the browser needs. */
const VIEWERS = {
  'ours': {module: 'ours', name: 'ours'},
  'ours-webgpu': {module: 'ours', query: 'renderer=webgpu', name: 'ours, WebGPU', arguments: WEBGPU},
  'ours-half': {module: 'ours', query: 'blend=half', name: 'ours, half floats'},
  'ours-bytes': {module: 'ours', query: 'blend=bytes', name: 'ours, 8 bits'},
  'spark': {module: 'spark', package: '@sparkjsdev/spark', name: 'Spark'},
  'gaussian-splats-3d': {module: 'gaussian_splats_3d', package: '@mkkellogg/gaussian-splats-3d', name: 'GaussianSplats3D'},
  'playcanvas': {module: 'playcanvas', package: 'playcanvas', name: 'PlayCanvas'},
};

const {values, positionals: scenes} = parseArgs({allowPositionals: true, options: {json: {type: 'string'}, driver: {type: 'string'},
  viewers: {type: 'string', default: Object.keys(VIEWERS).join(',')}}});
const drivers = values.driver ? [values.driver] : Object.keys(DRIVERS);
const viewers = values.viewers.split(',');
for (const [given, known, what] of [[drivers, DRIVERS, 'driver'], [viewers, VIEWERS, 'viewer']])
  for (const name of given)
    if (!known[name]) fail(`${what} '${name}'; expected one of ${Object.keys(known).join(', ')}`);
if (!scenes.length) fail('no scene was given');

function fail(message) {
  console.error(`peers: error: ${message}`);
  process.exit(2);
}

// ---- Processes

const ticksOf = (pid) => {
  const stat = readFileSync(`/proc/${pid}/stat`, 'utf8');
  const fields = stat.slice(stat.lastIndexOf(')') + 2).split(' ');
  return Number(fields[11]) + Number(fields[12]);  // utime + stime, 10 ms each
};
const megabytesOf = (pid) => Number(/^RssAnon:\s+(\d+)/m.exec(readFileSync(`/proc/${pid}/status`, 'utf8'))[1]) / 1024;

/** Pids of the processes that draw and that run pages. */
async function processes(browser) {
  const session = await browser.target().createCDPSession();
  const {processInfo} = await session.send('SystemInfo.getProcessInfo');
  await session.detach();
  const of = (type) => processInfo.filter((p) => p.type === type).map((p) => p.id);
  return {gpu: of('GPU')[0], renderers: of('renderer')};
}

async function memory(browser) {
  const {gpu, renderers} = await processes(browser);
  return {page: renderers.reduce((sum, pid) => sum + megabytesOf(pid), 0), gpu: megabytesOf(gpu)};
}

// ---- Cameras

/** Cameras round what a camera looks at: by so many degrees about its up axis, from a part of the distance. */
function turned({position, target, up, fovY}, degrees, distance = 1) {
  const a = degrees * Math.PI / 180, c = Math.cos(a), s = Math.sin(a);
  const v = position.map((p, i) => p - target[i]);
  const cross = [up[1] * v[2] - up[2] * v[1], up[2] * v[0] - up[0] * v[2], up[0] * v[1] - up[1] * v[0]];
  const dot = up.reduce((sum, u, i) => sum + u * v[i], 0);
  return {position: target.map((t, i) => t + distance * (c * v[i] + s * cross[i] + (1 - c) * dot * up[i])), target, up, fovY};
}

// ---- A viewer

const median = (numbers) => numbers.toSorted((a, b) => a - b)[numbers.length >> 1];

/** A fresh browser with a page; what `use` answers. */
async function withPage(driver, {query = '', arguments: more = []}, use) {
  const browser = await puppeteer.launch({executablePath: program, protocolTimeout: 600000,
    args: ['--no-sandbox', '--hide-scrollbars', ...DRIVERS[driver], ...more]});
  try {
    const page = await browser.newPage();
    const said = [];
    page.on('pageerror', (error) => said.push(String(error)));
    page.on('console', (line) => line.type() === 'error' && said.push(line.text()));
    await page.setViewport(SIZE);
    // As much as a page with nothing but a canvas that was drawn to
    await page.goto(`${server.address}blank.html`);
    await page.evaluate(() => new Promise((resolve) => {
      const gl = document.body.appendChild(document.createElement('canvas')).getContext('webgl2');
      gl.clear(gl.COLOR_BUFFER_BIT);
      setTimeout(resolve, 500);
    }));
    const empty = await memory(browser);
    await page.goto(`${server.address}page.html?${query}`);
    await page.waitForFunction(() => globalThis.harness);
    return await use({browser, page, empty, said});
  } finally {
    await browser.close();
  }
}

/** The camera that our viewer begins with. */
async function firstView(scene) {
  return withPage(drivers[0], {}, async ({page}) => {
    await page.evaluate((size, url) => globalThis.harness.open('ours', size, url), SIZE, `/${basename(scene)}`);
    const view = await page.evaluate(() => globalThis.harness.view());
    return {...cameraOf(view), up: view.slice(9)};  // the scene's up, to go round it
  });
}

async function measure(driver, viewer, scene, {walk, stills, references}) {
  const {module} = VIEWERS[viewer];
  return withPage(driver, VIEWERS[viewer], async ({browser, page, empty, said}) => {
    try {
      await page.evaluate((name, size, url) => globalThis.harness.open(name, size, url), module, SIZE, `/${basename(scene)}`);
      await page.evaluate((camera) => globalThis.harness.look(camera), walk[0]);
      const first = await page.evaluate(() => globalThis.harness.first());
      await page.evaluate((camera) => globalThis.harness.settled(camera), walk[0]);
      await page.evaluate((cameras) => globalThis.harness.walk(cameras), walk.slice(0, WARM_UP));
      const wall = [], gpu = [], renderer = [];
      for (let round = 0; round < ROUNDS; ++round) {
        const pids = await processes(browser);
        const ticks = () => [ticksOf(pids.gpu), pids.renderers.reduce((sum, pid) => sum + ticksOf(pid), 0)];
        const before = ticks();
        wall.push(...await page.evaluate((cameras) => globalThis.harness.walk(cameras), walk));
        const after = ticks();
        gpu.push((after[0] - before[0]) * 10 / walk.length);
        renderer.push((after[1] - before[1]) * 10 / walk.length);
      }
      const full = await memory(browser);
      const errors = [];
      for (const [i, camera] of stills.entries())
        errors.push(await page.evaluate((c, png) => globalThis.harness.compare(c, png), camera, references[i]));
      return {first, wall: median(wall), gpu: median(gpu), page: median(renderer), memory: full.page - empty.page, gpuMemory: full.gpu - empty.gpu,
        db: errors.map((e) => e.db), largest: Math.max(...errors.map((e) => e.largest))};
    } catch (error) {
      return {error: [error.message, ...said].join('; ').slice(0, 300)};
    }
  });
}

// ---- All of them

const work = await mkdtemp(join(tmpdir(), 'fluxgs-peers-'));
await symlink(join(packages, 'node_modules'), join(work, 'packages'));
await symlink(join(root, 'build/web/site/npm'), join(work, 'flux'));
await writeFile(join(work, 'blank.html'), '<!doctype html><title>Blank</title><body></body>');
for (const scene of scenes) await symlink(resolve(scene), join(work, basename(scene)));
const server = await serve([here, work]);
const version = (name) => JSON.parse(readFileSync(join(packages, 'node_modules', name, 'package.json'), 'utf8')).version;
if (values.json) writeFileSync(values.json, '');
try {
  console.log('| scene | driver | viewer | first picture, ms | ms a frame | GPU process, ms | page, ms | page, MiB | GPU process, MiB | dB | largest error |');
  console.log('| --- | --- | --- | ---: | ---: | ---: | ---: | ---: | ---: | ---: | ---: |');
  for (const scene of scenes) {
    const first = await firstView(scene);
    const walk = Array.from({length: FRAMES}, (_, i) => turned(first, 3 * i));
    const stills = [first, turned(first, 120), turned(first, 240, 0.6)];
    const references = [];
    for (const camera of stills) references.push(await renderPng(fluxgs, scene, camera, SIZE, work, 'reference'));
    for (const driver of drivers) {
      for (const viewer of viewers) {
        const {name, package: library} = VIEWERS[viewer];
        const label = library ? `${name} ${version(library)}` : name;
        const row = {scene: basename(scene), driver, viewer: label, ...await measure(driver, viewer, scene, {walk, stills, references})};
        if (values.json) appendFileSync(values.json, `${JSON.stringify(row)}\n`);
        const cells = row.error ? [row.error, '', '', '', '', '', '', ''] :
          [row.first, row.wall, row.gpu, row.page, row.memory, row.gpuMemory].map((n) => n.toFixed(0)).concat(row.db.map((d) => d.toFixed(1)).join(', '), row.largest);
        console.log(`| ${[row.scene, driver, label, ...cells].join(' | ')} |`);
      }
    }
  }
} finally {
  server.close();
  await rm(work, {recursive: true, force: true});
}
