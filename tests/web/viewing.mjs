// The viewer in a browser: pictures and inputs.
import {readFile} from 'node:fs/promises';
import {basename, join} from 'node:path';
import {expect, expectEqual} from './checks.mjs';
import {expectPicture, opened, started, until} from './page.mjs';

async function testPictures(checks, {browser, server, fluxgs, work, scenes}) {
  for (const file of scenes) {
    await checks.test(`draws ${basename(file)} as fluxgs render does`, async () => {
      const viewer = await started(browser, `${server.address}?url=${basename(file)}`);
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
        await expectPicture(viewer, {fluxgs, work}, file);
      }
      await viewer.close();
    });
  }
}

async function testInputs(checks, {browser, server, scenes}) {
  const scene = basename(scenes[0]);
  const begin = (options) => started(browser, `${server.address}?url=${scene}`, options);
  const changes = async (viewer, what, act, end) => {
    const before = JSON.stringify(await viewer.view());
    await act();
    await until(`${what} changes the view`, async () => JSON.stringify(await viewer.view()) !== before);
    await end?.();
    await viewer.rested();
  };
  await checks.test('mouse, wheel, keys and reset', async () => {
    const viewer = await begin(), {mouse, keyboard} = viewer.page;
    const home = await viewer.view();
    await changes(viewer, 'a drag', async () => {
      await mouse.move(160, 120);
      await mouse.down();
      await mouse.move(220, 130, {steps: 5});
      await mouse.up();
    });
    await changes(viewer, 'the wheel', () => mouse.wheel({deltaY: -300}));
    await changes(viewer, 'a key', () => keyboard.down('KeyW'), () => keyboard.up('KeyW'));
    await changes(viewer, 'a double click', () => mouse.click(200, 140, {count: 2}));
    await keyboard.press('KeyR');
    await until('R leads back', async () => {
      const view = await viewer.view();
      return home.every((n, i) => Math.abs(n - view[i]) < 1e-3);
    });
    await viewer.close();
  });
  await checks.test('one finger, a pinch and a double tap', async () => {
    const viewer = await begin({touch: true});
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
    const first = await begin();
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
    const refused = await second.page.evaluate(() => new Promise((resolve) => {
      addEventListener('message', ({data}) => data.id === 8 && data.error && resolve(data.error));
      postMessage({call: 'nothing', id: 8}, '*');
    }));
    expectEqual('a call that there is not', refused, "there is no call 'nothing'; expected one of open, goTo, set, state, picture");
    await second.close();
  });
  await checks.test('buttons have names and can be reached by keyboard', async () => {
    const viewer = await begin();
    const buttons = await viewer.page.evaluate(() => [...document.querySelector('flux-gs-viewer').shadowRoot.querySelectorAll('.bar button')]
      .map((b) => b.getAttribute('aria-label')));
    expect(`${buttons.length} buttons with names`, buttons.length === 6 && buttons.every(Boolean));
    for (let i = 0; i < 4; ++i) await viewer.page.keyboard.press('Tab');
    const focused = await viewer.page.evaluate(() => document.querySelector('flux-gs-viewer').shadowRoot.activeElement?.tagName);
    expectEqual('the focus', focused, 'BUTTON');
    await viewer.close();
  });
  await checks.test('statistics, settings, a picture and kept views', async () => {
    const viewer = await begin();
    const done = await viewer.page.evaluate(async () => {
      const element = document.querySelector('flux-gs-viewer'), root = element.shadowRoot;
      for (const name of ['settings', 'statistics', 'save']) root.querySelector(`[data-name=${name}]`).click();
      const picture = await element.picture();
      await element.set({maxSplats: 1000, shDegree: 0, background: [0, 0, 1]});
      await new Promise((resolve) => setTimeout(resolve, 1500));
      const {stats} = await element.state();
      await element.set({maxSplats: 1});
      const corner = new OffscreenCanvas(1, 1).getContext('2d');
      corner.drawImage(await createImageBitmap(await element.picture()), 0, 0);
      return {text: root.querySelector('.statistics').textContent, corner: [...corner.getImageData(0, 0, 1, 1).data], picture: picture.size, shown: stats.shown,
        kept: root.querySelectorAll('.panel label button').length};
    });
    expect(`statistics: ${done.text}`, /splats[^]*×\d+, WebGL/.test(done.text));
    expect('a picture', done.picture > 1000);
    const [red, green, blue, alpha] = done.corner;
    expect(`the background of a picture: ${done.corner}`, alpha === 255 && blue > 200 && red < 60 && green < 60);
    expectEqual('splats at most', done.shown, 1000);
    expectEqual('a kept view has two buttons', done.kept, 2);
    await viewer.close();
  });
}

export async function testViewing(checks, tools) {
  await testPictures(checks, tools);
  await testInputs(checks, tools);
}
