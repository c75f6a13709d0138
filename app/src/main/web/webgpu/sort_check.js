// A trial of the sort before anything is drawn with it. Of all shaders it asks most of a driver (barriers, atomics, shared
// memory), and WebGL can draw in its place.

const KEYS = 5000;  // two blocks of the sort and a part of one
const BITS = 24;

/** Keys of which some are dropped and many are equal. */
function makeKeys() {
  let seed = 1;
  return Array.from({length: KEYS}, () => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    if (seed % 5 === 0) return 0xffffffff;
    return seed % 3 ? seed >>> 8 : seed >>> 29;
  });
}

/** Resolves to whether a Gpu sorts as it should. */
export async function sortsRightly(gpu) {
  const keys = makeKeys(), device = gpu.device;
  // The largest key first, and of equal ones the last
  const wanted = keys.map((_, i) => i).filter((i) => keys[i] !== 0xffffffff).sort((a, b) => keys[b] - keys[a] || b - a);
  const scene = gpu.makeBuffers(KEYS, 0, 0);
  const bytes = 4 * (1 + wanted.length);
  const read = device.createBuffer({size: bytes, usage: GPUBufferUsage.MAP_READ | GPUBufferUsage.COPY_DST});
  device.queue.writeBuffer(scene.buffers.pairs[0], 0, Uint32Array.from(keys.flatMap((key, i) => [key, i])));
  device.queue.writeBuffer(scene.buffers.state, 0, new Uint32Array([KEYS]));
  const encoder = device.createCommandEncoder(), pass = encoder.beginComputePass();
  gpu.sort(pass, scene, BITS);
  pass.end();
  encoder.copyBufferToBuffer(scene.buffers.state, 0, read, 0, 4);
  encoder.copyBufferToBuffer(scene.buffers.order, 0, read, 4, bytes - 4);
  device.queue.submit([encoder.finish()]);
  await read.mapAsync(GPUMapMode.READ);
  const [count, ...order] = new Uint32Array(read.getMappedRange());
  const right = count === wanted.length && order.every((splat, i) => splat === wanted[i]);
  read.destroy();
  gpu.destroyBuffers(scene);
  return right;
}
