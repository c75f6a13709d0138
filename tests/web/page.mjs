// A page with the viewer, for the tests.
import {basename} from 'node:path';
import {expect, expectEqual} from './checks.mjs';
import {cameraOf, comparePng, renderPng} from './compare.mjs';

export const SIZE = {width: 320, height: 240};
const LEAST_PSNR = 50;

/** Waits until something holds, however slow the machine is. */
export async function until(what, holds) {
  const most = performance.now() + 20000;
  while (!await holds()) {
    expect(`${what}: not within 20 s`, performance.now() < most);
    await new Promise((resolve) => setTimeout(resolve, 50));
  }
}

/**
 * A page with the viewer; what it logs as an error fails the test, but for what `allowed` matches. `prepare` runs in
 * the page before anything else.
 */
export async function opened(browser, address, {size = SIZE, allowed = /$^/, density = 1, touch = false, prepare} = {}) {
  const page = await browser.newPage();
  if (prepare) await page.evaluateOnNewDocument(prepare);
  const errors = [];
  page.on('pageerror', (error) => errors.push(String(error)));
  page.on('console', (said) => said.type() === 'error' && !allowed.test(said.text()) && errors.push(said.text()));
  await page.setViewport({...size, deviceScaleFactor: density, hasTouch: touch});
  await page.goto(address);
  await page.waitForFunction(() => customElements.get('flux-gs-viewer') && document.querySelector('flux-gs-viewer').viewer);
  const viewer = {
    page,
    state: () => page.evaluate(() => document.querySelector('flux-gs-viewer').state()),
    view: async () => (await viewer.state()).view,
    shown: () => page.waitForFunction(async () => {
      const {drawn, loading} = await document.querySelector('flux-gs-viewer').state();
      return drawn && loading.phase === 'ready';
    }, {timeout: 60000}),
    /** Nothing moves any more. */
    rested: () => page.waitForFunction(async () => (await document.querySelector('flux-gs-viewer').state()).resting, {timeout: 60000}),
    failed: async () => {
      await page.waitForFunction(async () => (await document.querySelector('flux-gs-viewer').state()).loading.phase === 'failed', {timeout: 30000});
      return (await viewer.state()).loading;
    },
    close: async () => {
      await page.close();
      expectEqual('errors of the page', errors, []);
    },
  };
  return viewer;
}

/** The same with a scene of an address, at rest. */
export async function started(browser, address, options) {
  const viewer = await opened(browser, address, options);
  await viewer.shown();
  await viewer.rested();
  return viewer;
}

/** Compares the picture of a viewer with that of `fluxgs render` of a file, by one of its renderers. */
export async function expectPicture(viewer, {fluxgs, work}, file, renderer = 'cpu') {
  const png = await renderPng(fluxgs, file, cameraOf(await viewer.view()), SIZE, work, renderer);
  const db = await viewer.page.evaluate(comparePng, png);
  console.log(`  ${basename(file)}: ${db.toFixed(1)} dB`);
  expect(`${basename(file)} has ${db.toFixed(1)} dB; at least ${LEAST_PSNR} were expected`, db >= LEAST_PSNR);
}
