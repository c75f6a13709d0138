// engines.mjs [webkit | firefox]: a picture of the viewer in other browsers, against `fluxgs render`. Needs a
// display (Xvfb) and their packages; tests/web/engines sets the variables. Not part of tools/test.
import {spawn} from 'node:child_process';
import {createRequire} from 'node:module';
import {mkdtemp, rm, writeFile} from 'node:fs/promises';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {cameraOf, comparePng, renderPng} from './compare.mjs';
import {serve} from './server.mjs';

const {FLUXGS_BINARY: fluxgs, FLUXGS_WEB_TEST_PACKAGES: packages} = process.env;
const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
const LEAST_PSNR = 50;
const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** Runs a function in WebKit's MiniBrowser by the WebDriver protocol. */
async function openWebkit() {
  const port = 4478;
  const driver = spawn('WebKitWebDriver', [`--port=${port}`], {stdio: 'ignore',
    env: {...process.env, LIBGL_ALWAYS_SOFTWARE: '1', WEBKIT_DISABLE_SANDBOX_THIS_IS_DANGEROUS: '1'}});
  await sleep(1500);
  const call = async (method, path, body) => {
    const answer = await (await fetch(`http://127.0.0.1:${port}${path}`, {method, body: body && JSON.stringify(body)})).json();
    if (answer.value?.error) throw new Error(JSON.stringify(answer.value).slice(0, 600));
    return answer.value;
  };
  const {sessionId} = await call('POST', '/session', {capabilities: {alwaysMatch: {'webkitgtk:browserOptions':
    {binary: '/usr/lib/x86_64-linux-gnu/webkit2gtk-4.1/MiniBrowser', args: ['--automation']}}}});
  const at = `/session/${sessionId}`;
  return {
    open: (url) => call('POST', `${at}/url`, {url}),
    run: (script, ...values) => call('POST', `${at}/execute/async`,
      {script: `const values = [...arguments], done = values.pop(); (${script})(...values).then(done, (e) => done('error: ' + e));`, args: values}),
    picture: async () => Buffer.from(await call('GET', `${at}/screenshot`), 'base64'),
    close: async () => (await call('DELETE', at).catch(() => {}), driver.kill()),
  };
}

async function openFirefox() {
  const puppeteer = createRequire(join(packages, 'package.json'))('puppeteer-core');
  const browser = await puppeteer.launch({browser: 'firefox', executablePath: '/usr/bin/firefox-esr', headless: false,
    env: {...process.env, LIBGL_ALWAYS_SOFTWARE: '1'},
    extraPrefsFirefox: {'webgl.force-enabled': true, 'gfx.x11-egl.force-enabled': true, 'widget.dmabuf.enabled': false}});
  const page = await browser.newPage();
  return {
    open: (url) => page.goto(url),
    run: (script, ...values) => page.evaluate(`(${script})(...${JSON.stringify(values)})`),
    picture: () => page.screenshot(),
    close: () => browser.close(),
  };
}

async function stateOf() {
  const element = document.querySelector('flux-gs-viewer');
  if (!element?.viewer) return null;
  const state = await element.state();
  const canvas = element.shadowRoot.querySelector('canvas'), gl = canvas.getContext('webgl2');
  return {...state, width: canvas.width, height: canvas.height, agent: navigator.userAgent, renderer: gl.getParameter(gl.RENDERER)};
}

const work = await mkdtemp(join(tmpdir(), 'fluxgs-engines-'));
const sample = join(root, 'app/src/main/assets/sample.glb');
const server = await serve([join(root, 'build/web/site/page'), dirname(sample)]);
const browsers = {webkit: openWebkit, firefox: openFirefox};
let status = 0;
for (const name of process.argv[2] ? [process.argv[2]] : Object.keys(browsers)) {
  const began = performance.now();
  const browser = await browsers[name]();
  try {
    await browser.open(`${server.address}?url=sample.glb`);
    let state = null;
    for (let i = 0; i < 120; ++i, await sleep(500)) {
      state = await browser.run(String(stateOf));
      if (state?.drawn && state.resting && state.loading.phase === 'ready') break;
      if (state?.loading?.phase === 'failed') throw new Error(state.loading.error);
    }
    const seconds = (performance.now() - began) / 1000;
    const png = await renderPng(fluxgs, sample, cameraOf(state.view), state, work);
    const db = await browser.run(String(comparePng), png);
    await writeFile(join(root, `build/web/${name}.png`), await browser.picture());
    console.log(`${name}: ${Number(db).toFixed(1)} dB at ${state.width}x${state.height}, ${seconds.toFixed(1)} s to the picture, ${state.renderer}; ${state.agent}`);
    if (!(db >= LEAST_PSNR)) status = 1;
  } catch (error) {
    console.log(`${name}: FAILED ${error.message ?? error}`);
    status = 1;
  } finally {
    await browser.close();
  }
}
server.close();
await rm(work, {recursive: true, force: true});
process.exit(status);
