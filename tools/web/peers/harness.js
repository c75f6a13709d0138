// Drives one viewer, ?viewer=NAME: measure.mjs calls the functions of globalThis.harness.
//
// Each viewer is a module with open(size, url, callWaiting), which answers with
//   canvas           what it draws to
//   look(camera)     {position, target, up: three numbers each, fovY: degrees}, in the axes of the file
//   draw()           draws one frame; not needed where the viewer waits for requestAnimationFrame()
//   finish()         resolves when the driver has drawn; not needed where the canvas is one of WebGL
//   frameMs          by how much its clock goes on in a frame

// Frames come when they are asked for here, so that each is measured alone
const waiting = new Map();
let clock = performance.now(), asked = 0;
globalThis.requestAnimationFrame = (call) => (waiting.set(++asked, call), asked);
globalThis.cancelAnimationFrame = (id) => waiting.delete(id);

const pause = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
const pixel = new Uint8Array(4);
let viewer;

function callWaiting() {
  const calls = [...waiting.values()];
  waiting.clear();
  for (const call of calls) call(clock);
}

/** Pixels of a canvas of WebGL; waits until the driver has drawn. */
function readPixels(width, height, bytes) {
  const gl = viewer.canvas.getContext('webgl2'), bound = gl.getParameter(gl.READ_FRAMEBUFFER_BINDING);
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, bytes);
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, bound);
}

/** Draws; what to wait for until the driver has drawn. */
function frame() {
  clock += viewer.frameMs ?? 16;
  viewer.draw?.();
  callWaiting();
  return viewer.finish ? viewer.finish() : readPixels(1, 1, pixel);
}

function somethingIsSeen() {
  const {width, height} = viewer.canvas;
  if (!viewer.finish) {
    const image = new Uint32Array(width * height);
    readPixels(width, height, new Uint8Array(image.buffer));
    return image.some((pixel) => pixel & 0xFFFFFF);
  }
  const context = new OffscreenCanvas(width, height).getContext('2d');
  context.drawImage(viewer.canvas, 0, 0);
  return new Uint32Array(context.getImageData(0, 0, width, height).data.buffer).some((pixel) => pixel & 0xFFFFFF);
}

/** Draws until the picture no longer changes: the order of the splats comes from a worker. */
async function settled(camera) {
  viewer.look(camera);
  let last = '', same = 0;
  for (let i = 0; i < 100 && same < 4; ++i) {
    frame();  // not waited for: a canvas of WebGPU can be read only until it is shown
    const now = viewer.canvas.toDataURL();
    same = now === last ? same + 1 : 0;
    last = now;
    await pause(100);
  }
  return last;
}

async function pixels(url) {
  const bitmap = await createImageBitmap(await (await fetch(url)).blob());
  const context = new OffscreenCanvas(bitmap.width, bitmap.height).getContext('2d');
  context.drawImage(bitmap, 0, 0);
  return context.getImageData(0, 0, bitmap.width, bitmap.height).data;
}

globalThis.harness = {
  async open(name, size, url) {
    viewer = await (await import(`./${name}.js`)).open(size, url, callWaiting);
  },
  look: (camera) => viewer.look(camera),
  /** Draws until something is to be seen: ms since the page was asked for. */
  async first() {
    for (;; await pause(5)) {
      frame();
      if (somethingIsSeen()) return performance.now();
    }
  },
  /** Wall time of each frame, ms, in a walk along cameras. */
  async walk(cameras) {
    const times = [];
    for (const camera of cameras) {
      const began = performance.now();
      viewer.look(camera);
      await frame();
      times.push(performance.now() - began);
      await pause(0);  // an order may come
    }
    return times;
  },
  settled,
  /** The view that our viewer begins with: twelve numbers. */
  view: () => viewer.view,
  /** Decibels and the largest difference of 255 between a settled picture and another. */
  async compare(camera, reference) {
    const [own, other] = [await pixels(await settled(camera)), await pixels(reference)];
    let sum = 0, largest = 0;
    for (let i = 0; i < own.length; ++i) {
      if (i % 4 === 3) continue;
      sum += (own[i] - other[i]) ** 2;
      largest = Math.max(largest, Math.abs(own[i] - other[i]));
    }
    return {db: 10 * Math.log10(255 ** 2 * own.length * 0.75 / Math.max(sum, 1)), largest};
  },
};
