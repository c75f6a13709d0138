// The viewer in a browser: what goes wrong, and what people seldom do.
import {spawnSync} from 'node:child_process';
import {mkdir, readFile, writeFile} from 'node:fs/promises';
import {basename, join} from 'node:path';
import {pathToFileURL} from 'node:url';
import {expect, expectEqual} from './checks.mjs';
import {expectPicture, opened, SIZE, started, until} from './page.mjs';

export async function testTroubles(checks, {browser, server, scenes, work, fluxgs, index}) {
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
  await checks.test('a walk at eye height', async () => {
    const viewer = await opened(browser, `${server.address}?url=${scene}`);
    await viewer.shown();
    const walk = () => viewer.page.evaluate(() => document.querySelector('flux-gs-viewer').shadowRoot.querySelector('[data-name=walk]').click());
    const motionIs = (motion) => until(`motion '${motion}'`, async () => (await viewer.state()).motion === motion);
    await walk();
    await motionIs('walk');
    await viewer.rested();
    const before = await viewer.view();
    await viewer.page.keyboard.down('KeyW');
    await until('forward', async () => {
      const view = await viewer.view();
      return Math.hypot(...[0, 1, 2].map((i) => view[i] - before[i])) > 1e-3;
    });
    await viewer.page.keyboard.up('KeyW');
    await viewer.rested();
    await walk();
    await motionIs('');
    await viewer.close();
  });
  await checks.test('little memory: fewer splats, then plain words', async () => {
    const viewer = await opened(browser, server.address);
    const open = (memory) => viewer.page.evaluate((url, bytes) => document.querySelector('flux-gs-viewer').open(url, {memory: bytes}), scene, memory);
    await open(1_000_000);
    await viewer.shown();
    const {stats, loading} = await viewer.state();
    expect(`${stats.shown} of ${loading.splats} splats`, stats.shown > 1000 && stats.shown < loading.splats);
    await open(1000);
    const failed = await viewer.failed();
    expectEqual('problem', failed.problem, 'memory');
    expect(failed.error, /sample\.glb: memory: /.test(failed.error) && !failed.error.includes('\n'));
    expect('the scene before is still there', (await viewer.state()).hasScene);
    await viewer.close();
  });
  await checks.test('a tab in the background', async () => {
    const viewer = await opened(browser, server.address);
    // As browsers do there: no frames until people come back
    await viewer.page.evaluate(() => {
      const asked = [], request = globalThis.requestAnimationFrame;
      globalThis.requestAnimationFrame = (call) => asked.push(call);
      Object.defineProperty(document, 'hidden', {get: () => true, configurable: true});
      globalThis.comeBack = () => {
        globalThis.requestAnimationFrame = request;
        delete document.hidden;
        asked.forEach((call) => request(call));
        document.dispatchEvent(new Event('visibilitychange'));
      };
    });
    await viewer.page.evaluate((url) => document.querySelector('flux-gs-viewer').open(url), scene);
    await viewer.page.waitForFunction(async () => (await document.querySelector('flux-gs-viewer').state()).loading.phase === 'ready', {polling: 100});
    expectEqual('drawn', (await viewer.state()).drawn, false);
    await viewer.page.evaluate(() => globalThis.comeBack());
    await viewer.shown();
    await viewer.close();
  });
  await checks.test('calls with values that are none change nothing', async () => {
    const viewer = await opened(browser, `${server.address}?url=${scene}`);
    await viewer.shown();
    const said = await viewer.page.evaluate(async (url) => {
      const element = document.querySelector('flux-gs-viewer'), answers = [];
      for (const call of [() => element.set({background: null}), () => element.set({shDegree: -1}), () => element.set({scale: 0.1}),
        () => element.set({colour: 1}), () => element.goTo([1, 2]), () => element.open(url, {view: [1, 2]}), () => element.open(7)])
        answers.push(await call().then(() => 'nothing', (error) => error.message));
      await element.set({background: [1, 0, 0]});
      return answers;
    }, scene);
    for (const [i, text] of ['background is null', 'shDegree is -1; expected 0, 1, 2 or 3', 'scale is 0.1', "no setting 'colour'", 'a view has 12',
      'a view has 12', 'expected a URL'].entries())
      expect(`${i}: ${said[i]}`, said[i].includes(text));
    const {loading, error} = await viewer.state();
    expectEqual('still shown', [loading.phase, error], ['ready', '']);
    await viewer.close();
  });
  await checks.test('addresses that are none', async () => {
    for (const [url, text] of [['http://', /is no address/], ['100%25.glb', /404/], ['ftp://example.org/a.glb', /begins with ftp: cannot be fetched; expected https:/]]) {
      const viewer = await opened(browser, `${server.address}?url=${encodeURIComponent(url)}`, {allowed: /Failed to load/});
      expect(url, text.test((await viewer.failed()).error));
      await viewer.close();
    }
  });
  await checks.test('calls with wrong arguments are rejected', async () => {
    const viewer = await started(browser, `${server.address}?url=${scene}`);
    const said = (call, ...given) => viewer.page.evaluate((name, values) => document.querySelector('flux-gs-viewer')[name](...values).then(() => 'done', String), call, given);
    for (const [given, text] of [[['open', ' '], 'TypeError: open: expected a URL, a File or a Blob'], [['open', scene, {memory: -1}], 'RangeError: open: memory is -1; expected bytes'],
      [['goTo', [1, 2]], 'TypeError: a view has 12 finite numbers'], [['set', null], 'TypeError: set: expected an object of settings'],
      [['set', {shDegree: 9}], 'RangeError: set: shDegree is 9; expected 0, 1, 2 or 3']])
      expectEqual(given[0], await said(...given), text);
    expectEqual('the scene stays', (await viewer.state()).loading.phase, 'ready');
    await viewer.close();
  });
  await checks.test('a viewer that cannot start says why, and rejects calls', async () => {
    const policy = "default-src 'self'; style-src 'unsafe-inline'";
    const faults = [
      [/flux\.wasm$/, {status: 404}, /flux\.wasm: the server answered 404; expected flux\.wasm beside/],
      [/flux\.wasm$/, {contentType: 'text/html', body: '<p>Sign in</p>'}, /flux\.wasm: is not the viewer's module, or was cut/],
      [/\/$/, {contentType: 'text/html', headers: {'content-security-policy': policy}, body: await readFile(index, 'utf8')}, /Content-Security-Policy forbids .* 'wasm-unsafe-eval'/],
      [/\/$/, {contentType: 'text/html', headers: {'content-security-policy': `${policy}; script-src 'self' 'wasm-unsafe-eval'`}, body: await readFile(index, 'utf8')},
        /Content-Security-Policy forbids the viewer's script; it must allow blob:/],
    ];
    for (const [address, answer, says] of faults) {
      const page = await browser.newPage();
      await page.setBypassServiceWorker(true);
      await page.setRequestInterception(true);
      page.on('request', (request) => address.test(request.url()) ? request.respond(answer) : request.continue());
      await page.goto(server.address);
      const note = () => page.evaluate(() => document.querySelector('flux-gs-viewer').shadowRoot?.querySelector('.note')?.innerText ?? '');
      await until(`${says}`, async () => (await note()).startsWith('The viewer cannot start.'));
      expect(await note(), says.test(await note()));
      const rejected = await page.evaluate(() => document.querySelector('flux-gs-viewer').open('a.glb').then(() => 'done', ({message}) => message));
      expect(rejected, says.test(rejected));
      await page.close();
    }
  });
  await checks.test('a folder that is opened from a disk says what it needs', async () => {
    const folder = join(work, 'folder');
    const made = spawnSync(fluxgs, ['web', scenes[0], '-o', folder, '--force'], {encoding: 'utf8'});
    expect(made.stderr, made.status === 0);
    const page = await browser.newPage();
    await page.goto(pathToFileURL(join(folder, 'index.html')).href);
    const shown = () => page.evaluate(() => {
      const {content, opacity, animationName} = getComputedStyle(document.querySelector('flux-gs-viewer'), '::before');
      return `${content} ${opacity} ${animationName}`;
    });
    await until('a text, at once', async () => /must come from a web server.* 1 none$/.test(await shown()));
    await page.close();
  });
  await checks.test('a turntable draws on', async () => {
    const viewer = await opened(browser, `${server.address}?url=${scene}&turntable`);
    await viewer.shown();
    await until('it turns', async () => (await viewer.state()).motion === 'drift');
    const before = await viewer.view();
    await until('another view', async () => (await viewer.view()).some((n, i) => Math.abs(n - before[i]) > 1e-3));
    expect('the scene is drawn', (await viewer.state()).drawn);
    await viewer.close();
  });
  await checks.test('ready is told of the scene that was opened last', async () => {
    const viewer = await opened(browser, `${server.address}?url=${scene}`);
    await viewer.shown();
    const told = await viewer.page.evaluate(async (url) => {
      const element = document.querySelector('flux-gs-viewer'), told = [];
      for (const name of ['ready', 'error']) element.addEventListener(name, () => told.push(name));
      await element.open('missing.glb');
      element.viewer.drift(true);  // frames of the scene before
      while (!told.length) await new Promise((resolve) => setTimeout(resolve, 50));
      await element.open(url);
      while (told.length < 2) await new Promise((resolve) => setTimeout(resolve, 50));
      return told;
    }, scene).catch((error) => String(error));
    expectEqual('events', told, ['error', 'ready']);
    await viewer.page.close();
  });
  await checks.test('an element before, out of and back in its page', async () => {
    const viewer = await opened(browser, server.address);
    const drawn = await viewer.page.evaluate(async (url) => {
      const element = document.createElement('flux-gs-viewer');
      const opened = element.open(url);
      document.body.append(element);
      await opened;
      for (let i = 0; i < 10; ++i) document.body.append(element);
      while (!(await element.state())?.drawn) await new Promise((resolve) => setTimeout(resolve, 50));
      const {view} = await element.state();
      view[7] *= 2;
      await element.set({maxSplats: 1000});
      await element.goTo(view);
      while (Math.abs((await element.state()).view[7] / view[7] - 1) > 1e-3) await new Promise((resolve) => setTimeout(resolve, 50));
      element.remove();
      document.body.append(element);
      while (!(await element.state())?.drawn) await new Promise((resolve) => setTimeout(resolve, 50));
      const {stats, view: after} = await element.state();
      return {shown: stats.shown, farther: after[7] / view[7]};
    }, scene);
    expectEqual('its settings', drawn.shown, 1000);
    expect(`its view: ${drawn.farther} as far away`, Math.abs(drawn.farther - 1) < 1e-3);
    await viewer.close();
  });
  await checks.test('the language of an address, and a view that changes in it', async () => {
    const viewer = await opened(browser, `${server.address}?url=${scene}&language=de`);
    await viewer.shown();
    const text = await viewer.page.evaluate(() => document.querySelector('flux-gs-viewer').shadowRoot.querySelector('[data-name=settings]').title);
    expectEqual('settings', text, 'Einstellungen');
    const view = await viewer.view();
    view[7] *= 2;
    await viewer.page.evaluate((numbers) => { location.hash = `view=${numbers.join()}`; }, view);
    await until('farther away', async () => Math.abs((await viewer.view())[7] / view[7] - 1) < 1e-3);
    await viewer.close();
  });
  await checks.test('a key that comes up beside another', async () => {
    const viewer = await started(browser, `${server.address}?url=${scene}`);
    await viewer.page.evaluate(() => document.querySelector('flux-gs-viewer').shadowRoot.querySelector('canvas').focus());
    for (const [how, key] of [['down', 'KeyD'], ['down', 'AltLeft'], ['up', 'KeyD'], ['up', 'AltLeft']]) await viewer.page.keyboard[how](key);
    await viewer.rested();
    await viewer.close();
  });
  await checks.test('a length that nobody tells, and a slow server', async () => {
    for (const how of ['unknown', 'slow']) {
      const viewer = await opened(browser, `${server.address}?url=${how}/${scene}`);
      await viewer.shown();
      await viewer.close();
    }
  });
  await checks.test('scenes of several files', async () => {
    const folder = join(work, 'several');
    await mkdir(join(folder, 'out'), {recursive: true});
    const unpacked = spawnSync('python3', ['-m', 'zipfile', '-e', join(work, 'sample.sog'), folder], {encoding: 'utf8'});
    expect(unpacked.stderr, unpacked.status === 0);
    // A .gltf with its buffer beside it
    const glb = await readFile(scenes[0]), jsonBytes = glb.readUInt32LE(12), text = JSON.parse(glb.subarray(20, 20 + jsonBytes));
    text.buffers[0].uri = 'the%20buffer.bin';
    await writeFile(join(folder, 'the buffer.bin'), glb.subarray(28 + jsonBytes));
    await writeFile(join(folder, 'scene.gltf'), JSON.stringify(text));
    // A streamed scene of one level and one file
    const count = JSON.parse(await readFile(join(folder, 'meta.json'))).count;
    await writeFile(join(work, 'lod-meta.json'), JSON.stringify({lodLevels: 1, filenames: ['several/meta.json'],
      tree: {children: [{lods: {0: {file: 0, offset: 0, count}}}]}}));
    for (const [file, same] of [['several/meta.json', join(work, 'sample.sog')], ['several/scene.gltf', scenes[0]], ['lod-meta.json', join(work, 'sample.sog')]]) {
      const viewer = await started(browser, `${server.address}?url=${file}`);
      await expectPicture(viewer, {fluxgs, work}, same);
      await viewer.close();
    }
    const meta = JSON.parse(await readFile(join(folder, 'meta.json')));
    const images = Object.values(meta).flatMap(({files = []}) => files);
    for (const [names, same] of [[['meta.json', ...images], join(work, 'sample.sog')], [['the buffer.bin', 'scene.gltf'], scenes[0]]]) {
      const viewer = await opened(browser, server.address);
      const picker = await viewer.page.evaluateHandle(() => document.querySelector('flux-gs-viewer').shadowRoot.querySelector('input[type=file]'));
      await picker.uploadFile(...names.map((name) => join(folder, name)));
      await viewer.shown();
      await viewer.rested();
      await expectPicture(viewer, {fluxgs, work}, same);
      await picker.uploadFile(join(folder, names.find((name) => /json|gltf/.test(name))));
      const {problem, error} = await viewer.failed();
      expect(`one of several files: ${error}`, problem === 'files' && /: was not chosen with it$/.test(error));
      await viewer.close();
    }
    const troubles = {
      'is missing': [{...meta, means: {...meta.means, files: ['none.webp', 'none.webp']}}, /none\.webp: the server answered 404/],
      'lies elsewhere': [{...meta, means: {...meta.means, files: ['../sample.spz', 'b.webp']}}, /"\.\.\/sample\.spz" is not read; expected a file in the same folder/],
      'is one of a streamed scene': [{lodLevels: 2, filenames: ['a'], tree: {}}, /no splats of level 0/],
      'has a name that is none': [{asset: {version: '2.0'}, buffers: [{uri: '%zz', byteLength: 4}]}, /"%zz" is no address of a file/],
      'has an address': [{...meta, means: {...meta.means, files: ['https://example.org/a.webp', 'b.webp']}}, /is not read/],
    };
    for (const [what, [json, says]] of Object.entries(troubles)) {
      await writeFile(join(folder, 'bad.json'), JSON.stringify(json));
      const viewer = await opened(browser, `${server.address}?url=several/bad.json`, {allowed: /404/});
      const {error} = await viewer.failed();
      expect(`a file that ${what}: ${error}`, says.test(error));
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
    const viewer = await started(browser, `${server.address}?url=${scene}`, {allowed: /CONTEXT_LOST|context/i});
    const image = () => viewer.page.evaluate(() => [...document.querySelector('flux-gs-viewer').viewer.image().data.subarray(0, 4000)].join());
    const before = await image();
    await viewer.page.evaluate(() => {
      const gl = document.querySelector('flux-gs-viewer').shadowRoot.querySelector('canvas').getContext('webgl2');
      window.lose = gl.getExtension('WEBGL_lose_context');
      window.lose.loseContext();
    });
    await until('lost', async () => (await viewer.state()).lost);
    await viewer.page.evaluate(() => window.lose.restoreContext());
    await viewer.page.waitForFunction(async () => {
      const state = await document.querySelector('flux-gs-viewer').state();
      return !state.lost && state.contexts === 2 && state.drawn;
    }, {timeout: 20000});
    await viewer.rested();
    expect('the same picture', before === await image());
    await viewer.close();
  });
  await checks.test('a window of 1×1 and three pixels for one', async () => {
    for (const options of [{size: {width: 1, height: 1}}, {density: 3}]) {
      const viewer = await opened(browser, `${server.address}?url=${scene}`, options);
      await viewer.shown();
      await viewer.page.evaluate(() => document.querySelector('flux-gs-viewer').set({scale: 1}));  // also where frames are slow
      await viewer.rested();
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
