// WebGPU and WebGL: that their pictures are right, and which of them draws.
import {readFile, writeFile} from 'node:fs/promises';
import {basename, join} from 'node:path';
import {expect, expectEqual} from './checks.mjs';
import {hardScenes} from './hard_scenes.mjs';
import {expectPicture, SIZE, started} from './page.mjs';

/** A scene in one of the renderers, at rest. */
const inRenderer = ({browser, server}, scene, renderer, options) =>
  started(browser, `${server.address}?renderer=${renderer}&url=${scene}`, options);

async function openAnother(viewer, {server}, scene) {
  await viewer.page.evaluate((url) => document.querySelector('flux-gs-viewer').open(url), server.address + scene);
  await viewer.shown();
  await viewer.rested();
}

const rendererOf = async (viewer) => (await viewer.state()).renderer;

async function testHardScenes(checks, tools) {
  const scenes = hardScenes(await readFile(tools.scenes[1])), names = Object.keys(scenes);
  for (const name of names) await writeFile(join(tools.work, name), scenes[name]);
  const halves = () => {  // as graphics cards blend
    const has = GPUSupportedFeatures.prototype.has;
    GPUSupportedFeatures.prototype.has = function(name) { return name !== 'float32-blendable' && has.call(this, name); };
  };
  for (const [what, renderer, prepare] of [['WebGPU', 'webgpu'], ['WebGPU with half floats', 'webgpu', halves], ['WebGL', 'webgl']])
    await checks.test(`hard scenes in ${what} against doubles`, async () => {
      const viewer = await inRenderer(tools, names[0], renderer, {prepare});
      for (const name of names) {
        await openAnother(viewer, tools, name);
        expectEqual('renderer', await rendererOf(viewer), renderer);
        await expectPicture(viewer, tools, join(tools.work, name), 'reference');
      }
      await viewer.close();
    });
}

async function testWebGpu(checks, tools) {
  const file = tools.scenes[0], scene = basename(file);
  await checks.test('WebGPU: pictures, inputs, settings, another scene', async () => {
    const viewer = await inRenderer(tools, scene, 'webgpu'), {page} = viewer;
    expectEqual('renderer', await rendererOf(viewer), 'webgpu');
    await expectPicture(viewer, tools, file);
    const before = await viewer.view();
    await page.mouse.move(160, 120);
    await page.mouse.down();
    await page.mouse.move(230, 140, {steps: 5});
    await page.mouse.up();
    await page.waitForFunction((view) => document.querySelector('flux-gs-viewer').viewer.view[3] !== view[3], {}, before);
    await viewer.rested();
    await expectPicture(viewer, tools, file);
    const call = (name, ...values) => page.evaluate((n, v) => document.querySelector('flux-gs-viewer')[n](...v), name, values);
    await call('set', {maxSplats: 5000, background: [1, 1, 1]});
    await viewer.rested();
    const {stats} = await viewer.state();
    expectEqual('splats shown', stats.shown, 5000);
    expect(`${stats.drawn} splats drawn`, stats.drawn > 0 && stats.drawn <= 5000);
    await call('set', {maxSplats: 0, background: [0, 0, 0], scale: 0.5});
    await viewer.rested();
    expectEqual('width at half the scale', (await viewer.state()).stats.width, SIZE.width / 2);
    await call('set', {scale: 1});
    await openAnother(viewer, tools, basename(tools.scenes[1]));
    await expectPicture(viewer, tools, tools.scenes[1]);
    await page.setViewport({width: 1, height: 1});
    await viewer.rested();
    await page.setViewport(SIZE);
    await viewer.rested();
    await expectPicture(viewer, tools, tools.scenes[1]);
    await viewer.close();
  });
  await checks.test('WebGPU of a processor only where it is asked for', async () => {
    const viewer = await inRenderer(tools, scene, '');
    expectEqual('renderer', await rendererOf(viewer), 'webgl');
    await viewer.close();
  });
  await checks.test('WebGPU that is lost: WebGL goes on from the same view', async () => {
    const viewer = await inRenderer(tools, scene, 'webgpu', {prepare: () => {
      const request = GPUAdapter.prototype.requestDevice;
      GPUAdapter.prototype.requestDevice = async function(...options) { return (globalThis.device = await request.apply(this, options)); };
    }});
    expectEqual('renderer', await rendererOf(viewer), 'webgpu');
    const before = await viewer.view();
    await viewer.page.evaluate(() => globalThis.device.destroy());
    await viewer.page.waitForFunction(async () => (await document.querySelector('flux-gs-viewer').state()).renderer === 'webgl');
    await viewer.shown();
    await viewer.rested();
    expectEqual('view', await viewer.view(), before);
    await expectPicture(viewer, tools, file);
    await viewer.page.mouse.move(160, 120);
    await viewer.page.mouse.wheel({deltaY: -300});
    await viewer.page.waitForFunction((d) => document.querySelector('flux-gs-viewer').viewer.view[7] !== d, {}, before[7]);
    await viewer.close();
  });
  const faults = {
    'does not answer': () => (GPU.prototype.requestAdapter = () => new Promise(() => {})),
    'has no device': () => (GPUAdapter.prototype.requestDevice = () => Promise.reject(new Error('no device'))),
    'sorts wrongly': () => {
      const create = GPUDevice.prototype.createShaderModule;
      GPUDevice.prototype.createShaderModule = function({code}) { return create.call(this, {code: code.replace('same += countOneBits(mask);', 'same = countOneBits(mask);')}); };
    },
    'does not compile': () => {
      const create = GPUDevice.prototype.createShaderModule;
      GPUDevice.prototype.createShaderModule = function({code}) { return create.call(this, {code: code.replace('fn project', 'fn fn')}); };
    },
    'has too little memory': () => {
      const create = GPUDevice.prototype.createBuffer;
      GPUDevice.prototype.createBuffer = function({size, ...rest}) { return create.call(this, {size: size > 1e6 ? 2 ** 42 : size, ...rest}); };
    },
  };
  for (const [what, prepare] of Object.entries(faults))
    await checks.test(`WebGPU that ${what}: WebGL draws`, async () => {
      const viewer = await inRenderer(tools, scene, 'webgpu', {prepare});
      await viewer.page.waitForFunction(async () => (await document.querySelector('flux-gs-viewer').state()).renderer === 'webgl');
      await viewer.shown();
      await viewer.rested();
      await expectPicture(viewer, tools, file);
      await viewer.close();
    });
}

/** `browser` has both, `plain` WebGL only. */
export async function testGraphics(checks, {browser, plain, ...tools}) {
  await testHardScenes(checks, {browser, ...tools});
  await testWebGpu(checks, {browser, ...tools});
  await checks.test('a browser without WebGPU: WebGL draws', async () => {
    const viewer = await inRenderer({browser: plain, ...tools}, basename(tools.scenes[0]), 'webgpu');
    expectEqual('renderer', await rendererOf(viewer), 'webgl');
    await viewer.close();
  });
}
