// The module without a browser: what it reads, against what `fluxgs info` says of the same files.
import {spawnSync} from 'node:child_process';
import {createRequire} from 'node:module';
import {readFile} from 'node:fs/promises';
import {join} from 'node:path';
import {expect, expectEqual} from './checks.mjs';

const MEMORY = 2 ** 30;

export async function makeModule(folder) {
  const make = createRequire(import.meta.url)(join(folder, 'flux.js'));
  return make({wasmBinary: await readFile(join(folder, 'flux.wasm'))});
}

/** Reads a file; of what it says come the state, the number of splats, and its positions. */
export function read(module, bytes, name, memory = MEMORY, come = bytes.length) {
  module.HEAPU8.set(bytes, module._flux_reader_room(bytes.length));
  const address = module.stringToNewUTF8(name);
  const done = module._flux_read(address, come, memory);
  module._free(address);
  const state = JSON.parse(module.UTF8ToString(module._flux_read_state()));
  const count = done ? module._flux_read_block_bytes(0) / 12 : 0;
  return {done: Boolean(done), state, count};
}

function info(fluxgs, file) {
  const said = spawnSync(fluxgs, ['info', '--json', file], {encoding: 'utf8', maxBuffer: 1 << 26});
  return said.status === 0 ? JSON.parse(said.stdout) : said.stderr.replace(/^fluxgs: error: /m, '').trim().split('\n').pop();
}

export async function testDecoding(checks, {module, fluxgs, scenes, work}) {
  for (const file of scenes) {
    await checks.test(`decodes ${file.split('/').pop()}`, async () => {
      const {done, state, count} = read(module, await readFile(file), file);
      const native = info(fluxgs, file);
      expect(`is read: ${state.error}`, done);
      expectEqual('splats', count, native.splats);
      expectEqual('format', state.format, native.format);
    });
  }
  await checks.test('errors are those of the desktop', async () => {
    const whole = await readFile(scenes[0]);
    const {writeFile} = await import('node:fs/promises');
    const broken = {'cut.glb': whole.subarray(0, whole.length / 2), 'empty.glb': Buffer.alloc(0), 'text.glb': Buffer.from('not a scene'),
      'flipped.glb': Buffer.from(whole)};
    broken['flipped.glb'].fill(255, 900, 1200);
    for (const [name, bytes] of Object.entries(broken)) {
      const file = join(work, name);
      await writeFile(file, bytes);
      const {done, state} = read(module, bytes, file);
      expect(`${name} is refused`, !done);
      expectEqual(name, state.error, info(fluxgs, file));
    }
  });
  await checks.test('a scene that does not fit is an error, and one that fits in part is shortened', async () => {
    const bytes = await readFile(scenes[0]), all = read(module, bytes, 'scene').count;
    const small = read(module, bytes, 'scene', 2 ** 16);
    expectEqual('problem', small.state.problem, 'memory');
    expect(`${small.state.error} is one line`, /memory: needs about .* may be used/.test(small.state.error));
    const some = read(module, bytes, 'scene', 1.5e6);
    expect(`shows ${some.count} of ${all}`, some.done && some.count > all / 20 && some.count < all);
  });
}
