// Our viewer, as the npm package has it. ?blend=half or ?blend=bytes hides the browser's float targets;
// ?renderer=webgpu draws in WebGPU.

/** Twelve numbers, see View in flux-gs-viewer.d.ts. */
function viewOf({position, target, up, fovY}) {
  const minus = (a, b) => a.map((v, i) => v - b[i]);
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const unit = (a) => a.map((v) => v / Math.hypot(...a));
  const forward = unit(minus(target, position)), right = unit(cross(forward, up)), down = cross(forward, right);
  // Camera axes x right, y down, z forward as the columns of a rotation, as a quaternion
  const m = [right, down, forward];
  const w = Math.sqrt(Math.max(0, 1 + m[0][0] + m[1][1] + m[2][2])) / 2;
  const x = Math.sqrt(Math.max(0, 1 + m[0][0] - m[1][1] - m[2][2])) / 2 * Math.sign(m[1][2] - m[2][1] || 1);
  const y = Math.sqrt(Math.max(0, 1 - m[0][0] + m[1][1] - m[2][2])) / 2 * Math.sign(m[2][0] - m[0][2] || 1);
  const z = Math.sqrt(Math.max(0, 1 - m[0][0] - m[1][1] + m[2][2])) / 2 * Math.sign(m[0][1] - m[1][0] || 1);
  return [...target, w, x, y, z, Math.hypot(...minus(target, position)), fovY * Math.PI / 180, ...unit(up)];
}

function hideExtensions() {
  const blend = new URLSearchParams(location.search).get('blend');
  const hidden = {half: /EXT_float_blend/, bytes: /EXT_float_blend|EXT_color_buffer/}[blend];
  if (!hidden) return;
  const prototype = WebGL2RenderingContext.prototype;
  const {getSupportedExtensions, getExtension} = prototype;
  prototype.getSupportedExtensions = function() { return getSupportedExtensions.call(this).filter((e) => !hidden.test(e)); };
  prototype.getExtension = function(name) { return hidden.test(name) ? null : getExtension.call(this, name); };
}

/** Resolves to the device that the viewer asks for. */
function watchDevice() {
  const prototype = globalThis.GPUAdapter?.prototype, request = prototype?.requestDevice;
  return new Promise((resolve) => {
    if (request) prototype.requestDevice = function(...options) {
      const device = request.apply(this, options);
      device.then(resolve);
      return device;
    };
  });
}

export async function open(size, url, callWaiting) {
  hideExtensions();
  const device = watchDevice(), renderer = new URLSearchParams(location.search).get('renderer') ?? 'webgl';
  await import('/flux/flux-gs-viewer.js');
  const element = document.createElement('flux-gs-viewer');
  element.setAttribute('noui', '');
  element.setAttribute('renderer', renderer);
  element.setAttribute('src', url);
  document.body.append(element);
  for (let drawn = false; !drawn; drawn = (await element.state())?.drawn) {
    callWaiting();
    await new Promise((resolve) => setTimeout(resolve, 20));
  }
  element.viewer.set({scale: 1, movingScale: 1});
  if ((await element.state()).renderer !== renderer) throw new Error(`this browser cannot draw in ${renderer}`);
  return {
    ...(renderer === 'webgpu' && {finish: async () => (await device).queue.onSubmittedWorkDone()}),
    canvas: element.shadowRoot.querySelector('canvas'),
    // A flight to a view takes less than a second: it is over within the frame
    look: (camera) => element.viewer.goTo(viewOf(camera)),
    frameMs: 5000,
    get view() { return element.viewer.view; },
  };
}
