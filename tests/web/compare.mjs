// The viewer's picture against that of `fluxgs render`.
import {spawnSync} from 'node:child_process';
import {readFile, writeFile} from 'node:fs/promises';
import {join} from 'node:path';

/** A camera for `fluxgs render` of a view: 12 numbers. */
export function cameraOf(view) {
  const [tx, ty, tz, w, x, y, z, distance, fov] = view;
  const forward = [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)];
  const down = [2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)];
  return {position: [tx, ty, tz].map((t, i) => t - distance * forward[i]), target: [tx, ty, tz],
    up: down.map((d) => -d), fovY: fov * 180 / Math.PI};
}

/** What a camera sees, wider than high, by one of fluxgs's renderers on the processor: a URL with the PNG in it. */
export async function renderPng(fluxgs, scene, camera, {width, height}, work, renderer = 'cpu') {
  const cameras = join(work, 'camera.json'), png = join(work, 'render.png');
  await writeFile(cameras, JSON.stringify([{name: 'view', ...camera}]));
  const made = spawnSync(fluxgs, ['render', scene, '--camera', cameras, '--size', `${width}x${height}`, '--renderer', renderer, '-o', png], {encoding: 'utf8'});
  if (made.status !== 0) throw new Error(made.stderr);
  return `data:image/png;base64,${(await readFile(png)).toString('base64')}`;
}

/** Runs in the page: decibels between the viewer's image and such a PNG. */
export async function comparePng(data) {
  const own = document.querySelector('flux-gs-viewer').viewer.image();
  const bitmap = await createImageBitmap(await (await fetch(data)).blob());
  const canvas = document.createElement('canvas');
  canvas.width = bitmap.width;
  canvas.height = bitmap.height;
  const context = canvas.getContext('2d');
  context.drawImage(bitmap, 0, 0);
  const other = context.getImageData(0, 0, bitmap.width, bitmap.height);
  if (own.width !== other.width || own.height !== other.height) return -1;
  let sum = 0;
  for (let i = 0; i < own.data.length; ++i) if (i % 4 < 3) sum += (own.data[i] - other.data[i]) ** 2;
  return sum ? 10 * Math.log10(255 ** 2 * own.data.length * 0.75 / sum) : 99;
}
