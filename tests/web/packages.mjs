// What others are given: the npm package, installed from its tarball, and the project's page.
import {spawnSync} from 'node:child_process';
import {copyFile, mkdir, readFile, readdir, writeFile} from 'node:fs/promises';
import {basename, join} from 'node:path';
import {expect, expectEqual} from './checks.mjs';
import {serve} from './server.mjs';
import {opened} from './page.mjs';

function run(program, options, cwd) {
  const ran = spawnSync(program, options, {cwd, encoding: 'utf8', env: {...process.env, npm_config_offline: 'true'}});
  expectEqual(`${program} ${options.join(' ')}: ${ran.stderr}`, ran.status, 0);
  return ran.stdout;
}
const npm = (options, cwd) => run(process.execPath, [process.env.FLUXGS_NPM, ...options], cwd);

/** Opens a page with an element in it, and waits for its picture: whether it told that it is ready. */
async function drawn(browser, address) {
  const viewer = await opened(browser, address, {size: {width: 480, height: 360}});
  await viewer.shown();
  const ready = await viewer.page.evaluate(() => globalThis.ready);
  await viewer.close();
  return ready;
}

export async function testPackages(checks, {browser, root, work, sample}) {
  await checks.test('the npm package, installed from its tarball', async () => {
    const folder = join(work, 'installed');
    await mkdir(folder);
    await writeFile(join(folder, 'package.json'), '{"name": "page", "private": true}');
    const [{filename, files}] = JSON.parse(npm(['pack', join(root, 'build/web/site/npm'), '--json'], folder));
    expectEqual('files', files.map((file) => file.path).sort(),
      ['LICENSE', 'README.md', 'flux-gs-viewer.d.ts', 'flux-gs-viewer.js', 'flux.wasm', 'package.json']);
    npm(['install', `./${filename}`, '--no-audit', '--no-fund'], folder);
    await copyFile(sample, join(folder, basename(sample)));
    await writeFile(join(folder, 'index.html'), `<!doctype html><title>A page</title><link rel="icon" href="data:,">
      <script type="importmap">{"imports": {"flux-gs-viewer": "./node_modules/flux-gs-viewer/flux-gs-viewer.js"}}</script>
      <flux-gs-viewer src="${basename(sample)}" style="width: 480px; height: 360px"></flux-gs-viewer>
      <script type="module">
        document.querySelector('flux-gs-viewer').addEventListener('ready', () => { globalThis.ready = true; });
        await import('flux-gs-viewer');
      </script>`);
    const server = await serve([folder]);
    try {
      expect('the event ready', await drawn(browser, server.address));
    } finally {
      server.close();
    }
  });
  if (spawnSync('doxygen', ['--version']).error) return console.log('skipped the project\'s page: Doxygen is missing (tools/setup --dev)');
  await checks.test('the project\'s page', async () => {
    run(join(root, 'tools/web/site'), [], root);  // fails where a link leads nowhere
    expect('pages of the guide', (await readdir(join(root, 'build/site/guide/docs'))).length > 10);
    expect('documentation of headers', (await readFile(join(root, 'build/site/api/index.html'), 'utf8')).includes('Flux-GS'));
    const server = await serve([join(root, 'build/site')]);
    try {
      await drawn(browser, server.address);
    } finally {
      server.close();
    }
  });
}
