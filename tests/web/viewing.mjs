// The viewer in a browser: pictures, inputs, and what goes wrong.
import {spawnSync} from 'node:child_process';
import {copyFile, readFile, writeFile} from 'node:fs/promises';
import {basename, join} from 'node:path';
import {pathToFileURL} from 'node:url';
import {expect, expectEqual} from './checks.mjs';
import {comparePng, renderPng} from './compare.mjs';

const SIZE = {width: 320, height: 240};
const LEAST_PSNR = 50;
const settle = (ms) => new Promise((resolve) => setTimeout(resolve, ms));

/** A page with the viewer; what it logs as an error fails the test, but for what `allowed` matches. */
async function opened(browser, address, {size = SIZE, allowed = /$^/, density = 1, touch = false} = {}) {
  const page = await browser.newPage();
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

async function testPictures(checks, {browser, server, fluxgs, work, scenes}) {
  for (const file of scenes) {
    await checks.test(`draws ${basename(file)} as fluxgs render does`, async () => {
      const viewer = await opened(browser, `${server.address}?url=${basename(file)}`);
      await viewer.shown();
      const first = await viewer.view();
      // From where it begins, from the side and from near
      const turned = (view, angle) => {
        const [w, x, y, z] = view.slice(3, 7), [c, s] = [Math.cos(angle / 2), Math.sin(angle / 2)];
        const up = view.slice(9, 12).map((u) => u * s);
        return [...view.slice(0, 3), c * w - up[0] * x - up[1] * y - up[2] * z, c * x + up[0] * w + up[1] * z - up[2] * y,
          c * y - up[0] * z + up[1] * w + up[2] * x, c * z + up[0] * y - up[1] * x + up[2] * w, ...view.slice(7)];
      };
      const views = [first, turned(first, 0.8), [...first.slice(0, 7), first[7] * 0.6, ...first.slice(8)]];
      for (const [i, view] of views.entries()) {
        if (i) {
          await viewer.page.evaluate((v) => document.querySelector('flux-gs-viewer').goTo(v), view);
          await viewer.rested();
        }
        const png = await renderPng(fluxgs, file, await viewer.view(), SIZE, work);
        const db = await viewer.page.evaluate(comparePng, png);
        console.log(`  view ${i + 1}: ${db.toFixed(1)} dB`);
        expect(`view ${i + 1} has ${db.toFixed(1)} dB; at least ${LEAST_PSNR} were expected`, db >= LEAST_PSNR);
      }
      await viewer.close();
    });
  }
}

async function testInputs(checks, {browser, server, scenes}) {
  const scene = basename(scenes[0]);
  const started = async (options) => {
    const viewer = await opened(browser, `${server.address}?url=${scene}`, options);
    await viewer.shown();
    await viewer.rested();
    return viewer;
  };
  const changes = async (viewer, what, act) => {
    const before = JSON.stringify(await viewer.view());
    await act();
    for (let i = 0; i < 50 && JSON.stringify(await viewer.view()) === before; ++i) await settle(100);  // events are on their way
    await viewer.rested();
    expect(`${what} changes the view`, JSON.stringify(await viewer.view()) !== before);
  };
  await checks.test('mouse, wheel, keys and reset', async () => {
    const viewer = await started(), {mouse, keyboard} = viewer.page;
    const home = await viewer.view();
    await changes(viewer, 'a drag', async () => {
      await mouse.move(160, 120);
      await mouse.down();
      await mouse.move(220, 130, {steps: 5});
      await mouse.up();
    });
    await changes(viewer, 'the wheel', () => mouse.wheel({deltaY: -300}));
    await changes(viewer, 'a key', async () => {
      await keyboard.down('KeyW');
      await settle(300);
      await keyboard.up('KeyW');
    });
    await changes(viewer, 'a double click', () => mouse.click(200, 140, {count: 2}));
    await keyboard.press('KeyR');
    await settle(500);
    await viewer.rested();
    const back = await viewer.view();
    expect(`R leads back: ${back}`, home.every((n, i) => Math.abs(n - back[i]) < 1e-3));
    await viewer.close();
  });
  await checks.test('one finger, a pinch and a double tap', async () => {
    const viewer = await started({touch: true});
    const client = await viewer.page.createCDPSession();
    const touch = (type, ...points) => client.send('Input.dispatchTouchEvent', {type, touchPoints: points.map(([x, y], id) => ({x, y, id}))});
    await changes(viewer, 'a finger', async () => {
      await touch('touchStart', [160, 120]);
      for (let i = 1; i <= 5; ++i) await touch('touchMove', [160 + 12 * i, 120]);
      await touch('touchEnd');
    });
    const before = (await viewer.view())[7];
    await changes(viewer, 'a pinch', async () => {
      await touch('touchStart', [140, 120]);
      await touch('touchStart', [140, 120], [180, 120]);
      for (let i = 1; i <= 5; ++i) await touch('touchMove', [140 - 8 * i, 120], [180 + 8 * i, 120]);
      await touch('touchEnd');
    });
    expect('fingers that part come nearer', (await viewer.view())[7] < before);
    await changes(viewer, 'a double tap', async () => {
      for (let i = 0; i < 2; ++i) {
        await touch('touchStart', [200, 140]);
        await touch('touchEnd');
      }
    });
    await viewer.close();
  });
  await checks.test('the picker and a dropped file', async () => {
    const viewer = await opened(browser, server.address);
    const picker = await viewer.page.evaluateHandle(() => document.querySelector('flux-gs-viewer').shadowRoot.querySelector('input[type=file]'));
    await picker.uploadFile(scenes[0]);
    await viewer.shown();
    expectEqual('name', (await viewer.state()).loading.name, scene);
    const bytes = (await readFile(scenes[1])).toString('base64');
    await viewer.page.evaluate((data, name) => {
      const file = new File([Uint8Array.from(atob(data), (c) => c.charCodeAt(0))], name);
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(file);
      document.querySelector('flux-gs-viewer').dispatchEvent(new DragEvent('drop', {dataTransfer, cancelable: true}));
    }, bytes, basename(scenes[1]));
    await viewer.page.waitForFunction(async (name) => {
      const {drawn, loading} = await document.querySelector('flux-gs-viewer').state();
      return drawn && loading.phase === 'ready' && loading.name === name;
    }, {}, basename(scenes[1]));
    await viewer.close();
  });
  await checks.test('a link has its view, and the page can be embedded', async () => {
    const first = await started();
    await changes(first, 'a drag', async () => {
      await first.page.mouse.move(100, 100);
      await first.page.mouse.down();
      await first.page.mouse.move(160, 100, {steps: 4});
      await first.page.mouse.up();
    });
    const view = await first.view();
    await first.close();
    const second = await opened(browser, `${server.address}?url=${scene}&noui#view=${view.join()}`);
    await second.shown();
    const found = await second.view();
    expect('the same view', view.every((n, i) => Math.abs(n - found[i]) < 1e-6));
    const hidden = await second.page.evaluate(() => document.querySelector('flux-gs-viewer').shadowRoot.querySelector('.bar').hidden);
    expectEqual('no buttons', hidden, true);
    const answer = await second.page.evaluate(() => new Promise((resolve) => {
      addEventListener('message', ({data}) => data.id === 7 && data.result && resolve(data.result.loading.phase));
      postMessage({call: 'state', id: 7}, '*');
    }));
    expectEqual('answers messages', answer, 'ready');
    await second.close();
  });
  await checks.test('buttons have names and can be reached by keyboard', async () => {
    const viewer = await started();
    const buttons = await viewer.page.evaluate(() => [...document.querySelector('flux-gs-viewer').shadowRoot.querySelectorAll('.bar button')]
      .map((b) => b.getAttribute('aria-label')));
    expect(`${buttons.length} buttons with names`, buttons.length === 6 && buttons.every(Boolean));
    for (let i = 0; i < 4; ++i) await viewer.page.keyboard.press('Tab');
    const focused = await viewer.page.evaluate(() => document.querySelector('flux-gs-viewer').shadowRoot.activeElement?.tagName);
    expectEqual('the focus', focused, 'BUTTON');
    await viewer.close();
  });
  await checks.test('statistics, settings, a picture and kept views', async () => {
    const viewer = await started();
    const done = await viewer.page.evaluate(async () => {
      const element = document.querySelector('flux-gs-viewer'), root = element.shadowRoot;
      for (const name of ['settings', 'statistics', 'save']) root.querySelector(`[data-name=${name}]`).click();
      const picture = await element.picture();
      await element.set({maxSplats: 1000, shDegree: 0, background: [0, 0, 1]});
      await new Promise((resolve) => setTimeout(resolve, 1500));
      const {stats} = await element.state();
      return {text: root.querySelector('.statistics').textContent, picture: picture.size, shown: stats.shown,
        kept: root.querySelectorAll('.panel label button').length};
    });
    expect(`statistics: ${done.text}`, /splats/.test(done.text));
    expect('a picture', done.picture > 1000);
    expectEqual('splats at most', done.shown, 1000);
    expectEqual('a kept view has two buttons', done.kept, 2);
    await viewer.close();
  });
}

async function testTroubles(checks, {browser, server, scenes, work, fluxgs}) {
  const scene = basename(scenes[0]);
  for (const [what, url, problem, text] of [['404', 'missing.glb', 'network', /404/], ['a web page', `html/${scene}`, 'network', /web page/],
    ['a cut download', `cut/${scene}`, 'read', /ended after/], ['no scene', 'viewer.js', '', /the content is text; expected one of/]]) {
    await checks.test(`${what} is one line`, async () => {
      const viewer = await opened(browser, `${server.address}?url=${url}`, {allowed: /Failed to load resource/});
      const loading = await viewer.failed();
      expect(`problem ${loading.problem}`, problem === loading.problem);
      expect(loading.error, text.test(loading.error) && !loading.error.includes('\n'));
      const note = await viewer.page.evaluate(() => document.querySelector('flux-gs-viewer').shadowRoot.querySelector('.note').innerText);
      expect(`people see it: ${note}`, note.includes(loading.error));
      await viewer.close();
    });
  }
  await checks.test('another server that does not allow it', async () => {
    const viewer = await opened(browser, `${server.address}?url=${server.address.replace('127.0.0.1', 'localhost')}${scene}`, {allowed: /CORS|Failed to load/});
    expect('says what the server must send', /Access-Control-Allow-Origin/.test((await viewer.failed()).error));
    await viewer.close();
  });
  await checks.test('a length that nobody tells, and a slow server', async () => {
    for (const how of ['unknown', 'slow']) {
      const viewer = await opened(browser, `${server.address}?url=${how}/${scene}`);
      await viewer.shown();
      await viewer.close();
    }
  });
  await checks.test('two scenes opened one after the other', async () => {
    const viewer = await opened(browser, server.address);
    await viewer.page.evaluate((a, b) => {
      const element = document.querySelector('flux-gs-viewer');
      for (let i = 0; i < 5; ++i) element.open(`slow/${a}`);
      element.open(b);
    }, scene, basename(scenes[1]));
    await viewer.shown();
    expectEqual('the last', (await viewer.state()).loading.name, basename(scenes[1]));
    await viewer.close();
  });
  await checks.test('the context is lost and comes back', async () => {
    const viewer = await opened(browser, `${server.address}?url=${scene}`, {allowed: /CONTEXT_LOST|context/i});
    await viewer.shown();
    const image = () => viewer.page.evaluate(() => [...document.querySelector('flux-gs-viewer').viewer.image().data.subarray(0, 4000)].join());
    const before = await image();
    await viewer.page.evaluate(() => {
      const gl = document.querySelector('flux-gs-viewer').shadowRoot.querySelector('canvas').getContext('webgl2');
      window.lose = gl.getExtension('WEBGL_lose_context');
      window.lose.loseContext();
    });
    await settle(300);
    expectEqual('lost', (await viewer.state()).lost, true);
    await viewer.page.evaluate(() => window.lose.restoreContext());
    await viewer.page.waitForFunction(async () => {
      const state = await document.querySelector('flux-gs-viewer').state();
      return !state.lost && state.contexts === 2 && state.drawn;
    }, {timeout: 20000});
    await settle(500);
    expect('the same picture', before === await image());
    await viewer.close();
  });
  await checks.test('a window of 1×1 and three pixels for one', async () => {
    for (const options of [{size: {width: 1, height: 1}}, {density: 3}]) {
      const viewer = await opened(browser, `${server.address}?url=${scene}`, options);
      await viewer.shown();
      const {stats} = await viewer.state();
      expectEqual('the canvas', stats.width, options.density ? 2 * SIZE.width : 1);
      await viewer.close();
    }
  });
  await checks.test('without WebGL 2 people are told', async () => {
    const page = await browser.newPage();
    await page.evaluateOnNewDocument(() => {
      const get = HTMLCanvasElement.prototype.getContext;
      HTMLCanvasElement.prototype.getContext = function(kind, ...rest) { return kind === 'webgl2' ? null : get.call(this, kind, ...rest); };
    });
    await page.goto(server.address);
    await page.waitForFunction(() => /WebGL 2/.test(document.querySelector('flux-gs-viewer').shadowRoot.querySelector('.note')?.textContent));
    await page.close();
  });
  await checks.test('one file from a disk', async () => {
    const file = join(work, 'page.html');
    const made = spawnSync(fluxgs, ['web', scenes[0], '-o', file, '--force', '--title', 'A <scene> & more'], {encoding: 'utf8'});
    expect(made.stderr, made.status === 0);
    const viewer = await opened(browser, pathToFileURL(file).href);
    await viewer.shown();
    expectEqual('title', await viewer.page.title(), 'A <scene> & more');
    await viewer.close();
  });
  await checks.test('without a connection what was seen is there', async () => {
    const viewer = await opened(browser, `${server.address}?url=${scene}`, {allowed: /Failed to load|ERR_INTERNET/});
    await viewer.shown();
    await viewer.page.evaluate(() => navigator.serviceWorker.ready.then(() => new Promise((resolve) => setTimeout(resolve, 500))));
    await viewer.page.reload();
    await viewer.shown();
    await viewer.page.setOfflineMode(true);
    await viewer.page.reload();
    await viewer.shown();
    await viewer.page.setOfflineMode(false);
    await viewer.close();
  });
}

export async function testViewing(checks, tools) {
  await testPictures(checks, tools);
  await testInputs(checks, tools);
  await testTroubles(checks, tools);
}
