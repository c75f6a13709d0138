// bundle.mjs MODULE-FOLDER OUT: the files of the viewer for browsers, from flux.js and flux.wasm.
//   OUT/page/          a folder for any static host: index.html, viewer.js, flux.wasm, …
//   OUT/page.html      the same in one file, which works from file:// too
//   OUT/npm/           the npm package: <flux-gs-viewer>
import {createRequire} from 'node:module';
import {cp, mkdir, readFile, rm, writeFile} from 'node:fs/promises';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {brotliCompressSync, constants, gzipSync} from 'node:zlib';

const [moduleFolder, out] = process.argv.slice(2);
const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
const sources = join(root, 'app/src/main/web');
const esbuild = createRequire(join(process.env.FLUXGS_WEB_PACKAGES, 'package.json'))('esbuild');
const text = (path) => readFile(path, 'utf8');
const minified = async (path) => (await esbuild.transform(await text(path), {minify: true, target: 'es2022'})).code;

/** flux.js and worker.js as texts: pages and workers run them from Blobs. */
const texts = {'flux-glue-text': await minified(join(moduleFolder, 'flux.js')), 'flux-worker-text': await minified(join(sources, 'worker.js'))};
/** Shaders without comments and indentation. */
const bare = (shader) => shader.replace(/\/\/.*$/gm, '').replace(/\s*\n\s*/g, '\n');
const textPlugin = {
  name: 'texts',
  setup(build) {
    build.onLoad({filter: /\.wgsl$/}, async ({path}) => ({contents: bare(await text(path)), loader: 'text'}));
    build.onResolve({filter: /^flux-.*-text$/}, ({path}) => ({path, namespace: 'texts'}));
    build.onLoad({filter: /.*/, namespace: 'texts'}, ({path}) => ({contents: texts[path], loader: 'text'}));
  },
};
async function bundle(entry) {
  const {outputFiles} = await esbuild.build({entryPoints: [join(sources, entry)], bundle: true, minify: true, format: 'esm',
    target: 'es2022', charset: 'utf8', write: false, plugins: [textPlugin]});
  return outputFiles[0].text;
}

const wasm = await readFile(join(moduleFolder, 'flux.wasm'));
const viewer = await bundle('page.js'), element = await bundle('element.js');
const index = await text(join(sources, 'index.html'));
const page = join(out, 'page'), npm = join(out, 'npm');
await rm(out, {recursive: true, force: true});
await mkdir(page, {recursive: true});
await mkdir(npm, {recursive: true});

await writeFile(join(page, 'index.html'), index);
await writeFile(join(page, 'viewer.js'), viewer);
await writeFile(join(page, 'flux.wasm'), wasm);
for (const name of ['offline.js', 'manifest.webmanifest', 'icon.svg']) await cp(join(sources, name), join(page, name));

// What is inside of a <script> must not end it
const inside = (script) => script.replace(/<\/script/gi, '<\\/script').replace(/<!--/g, '<\\!--');
const icon = `data:image/svg+xml;base64,${Buffer.from(await text(join(sources, 'icon.svg'))).toString('base64')}`;
const single = index
  .replace(/<link rel="manifest"[^>]*>\n/, '')
  .replace('href="icon.svg"', () => `href="${icon}"`)
  .replace(/<script type="module" src="viewer.js".*\n/, '')
  .replace('</body>', () => `<script type="text/plain" id="flux-gs-module">${gzipSync(wasm, {level: 9}).toString('base64')}</script>\n` +
    `<!-- scene -->\n<script type="module">${inside(viewer)}</script>\n</body>`);
await writeFile(join(out, 'page.html'), single);

const version = /project\(fluxgs VERSION (\S+)/.exec(await text(join(root, 'CMakeLists.txt')))[1];
await writeFile(join(npm, 'flux-gs-viewer.js'), element);
await writeFile(join(npm, 'flux.wasm'), wasm);
await cp(join(sources, 'flux-gs-viewer.d.ts'), join(npm, 'flux-gs-viewer.d.ts'));
await cp(join(sources, 'npm-readme.md'), join(npm, 'README.md'));
await cp(join(root, 'LICENSE'), join(npm, 'LICENSE'));
await writeFile(join(npm, 'package.json'), `${JSON.stringify({name: 'flux-gs-viewer', version, type: 'module',
  description: 'A viewer of 3D Gaussian Splatting scenes: <flux-gs-viewer src>', license: 'Apache-2.0', main: 'flux-gs-viewer.js',
  types: 'flux-gs-viewer.d.ts', exports: {'.': {types: './flux-gs-viewer.d.ts', default: './flux-gs-viewer.js'}, './flux.wasm': './flux.wasm'},
  files: ['flux-gs-viewer.js', 'flux-gs-viewer.d.ts', 'flux.wasm'], sideEffects: true}, null, 2)}\n`);

const sizes = [];
for (const [name, bytes] of [['flux.wasm', wasm], ['viewer.js', Buffer.from(viewer)], ['page.html', Buffer.from(single)]]) {
  const brotli = brotliCompressSync(bytes, {params: {[constants.BROTLI_PARAM_QUALITY]: 11, [constants.BROTLI_PARAM_LGWIN]: 24}});
  sizes.push({name, raw: bytes.length, gzip: gzipSync(bytes, {level: 9}).length, brotli: brotli.length});
}
await writeFile(join(out, 'sizes.json'), `${JSON.stringify(sizes, null, 2)}\n`);
console.table(sizes);
