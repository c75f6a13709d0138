// site.mjs OUT: the project's page around what tools/web/site put into OUT: the guide from README and docs/,
// the start page from docs/site/, the viewer. Ends with an error where a link leads nowhere.
import {cp, mkdir, readFile, readdir, stat, writeFile} from 'node:fs/promises';
import {existsSync} from 'node:fs';
import {createRequire} from 'node:module';
import {dirname, join, relative, resolve} from 'node:path';
import {fileURLToPath} from 'node:url';

const out = resolve(process.argv[2]);
const root = join(dirname(fileURLToPath(import.meta.url)), '../..');
const {Marked} = createRequire(join(process.env.FLUXGS_WEB_PACKAGES, 'package.json'))('marked');
const text = (path) => readFile(path, 'utf8');

/** Texts of the repository that become pages of the guide, and files that these show. */
const PAGES = /^(README|CHANGELOG|CONTRIBUTING|SECURITY)\.md$|^docs\/.*\.md$|^shared-format\/schema\/README\.md$/;
const FILES = /^LICENSE$|^docs\/(?!site\/).*\.(png|jpg|jsonl)$/;

async function list(folder = '') {
  const names = [];
  for (const entry of await readdir(join(root, folder), {withFileTypes: true})) {
    const name = join(folder, entry.name);
    if (!entry.isDirectory()) names.push(name);
    else if (/^(docs|shared-format)$/.test(folder || entry.name) || folder.startsWith('docs')) names.push(...await list(name));
  }
  return names;
}

/** As GitHub makes them: lower case, without punctuation, a dash for each space. */
const anchorOf = (heading) => heading.replace(/<[^>]*>/g, '').replace(/&[a-z]+;|&#\d+;/g, '').toLowerCase()
  .replace(/[^\p{L}\p{N} _-]/gu, '').replaceAll(' ', '-');

function page({title, body, at}) {
  const home = relative(dirname(at), '.') || '.';
  return `<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>${title}</title>
<link rel="icon" href="${home}/icon.svg">
<link rel="stylesheet" href="${home}/style.css">
<script type="module" src="${home}/flux-gs-viewer.js"></script>
</head>
<body>
<header><strong><a href="${home}/index.html">Flux-GS</a></strong> <a href="${home}/guide/README.html">Guide</a>
<a href="${home}/guide/docs/web.html">Web</a> <a href="${home}/guide/docs/phone.html">Phone</a>
<a href="${home}/guide/docs/method.html">Method</a> <a href="${home}/api/index.html">API</a>
<a href="${home}/guide/CHANGELOG.html">Changes</a></header>
<main>
${body}
</main>
<footer>Flux-GS is free software under the <a href="${home}/guide/LICENSE">Apache License 2.0</a>.</footer>
</body>
</html>
`;
}

async function write(name, content) {
  await mkdir(dirname(join(out, name)), {recursive: true});
  await writeFile(join(out, name), content);
}

/** A page of the guide. Links to other texts lead to their pages; those to sources become plain text. */
function guidePage(markdown, name, known) {
  let title = 'Flux-GS';
  const anchors = new Map();
  const marked = new Marked({renderer: {
    heading({tokens, depth}) {
      const inner = this.parser.parseInline(tokens), anchor = anchorOf(inner), again = anchors.get(anchor) ?? 0;
      anchors.set(anchor, again + 1);
      if (depth === 1) title = inner.replace(/<[^>]*>/g, '');
      return `<h${depth} id="${anchor}${again ? `-${again}` : ''}">${inner}</h${depth}>\n`;
    },
    link({href, tokens}) {
      const inner = this.parser.parseInline(tokens);
      if (/^([a-z]+:|#)/.test(href)) return `<a href="${href}">${inner}</a>`;
      const [path, anchor] = href.split('#'), target = join(dirname(name), path);
      if (!known.has(target)) {
        if (existsSync(join(root, target))) return inner;
        throw new Error(`${name}: a link to ${href}, which does not exist`);
      }
      return `<a href="${path.replace(/\.md$/, '.html')}${anchor ? `#${anchor}` : ''}">${inner}</a>`;
    },
  }});
  const body = marked.parse(markdown).replaceAll('<table>', '<div class="table"><table>').replaceAll('</table>', '</table></div>');
  return {title, body};
}

/** Every href and src of the pages leads to a file, and to a heading of it where it names one. */
async function checkLinks(names) {
  const wrong = [];
  for (const name of names) {
    for (const [, link] of (await text(join(out, name))).matchAll(/(?:href|src|poster)="([^"]+)"/g)) {
      if (/^[a-z]+:/.test(link)) continue;
      const [path, anchor] = link.split('#'), file = path ? join(out, dirname(name), path) : join(out, name);
      if (!existsSync(file)) wrong.push(`${name}: ${link}`);
      else if (anchor && !(await text(file)).includes(`id="${decodeURIComponent(anchor)}"`)) wrong.push(`${name}: ${link}, which has no such heading`);
    }
  }
  if (wrong.length) throw new Error(`links that lead nowhere:\n  ${wrong.join('\n  ')}`);
}

const all = await list();
const pages = all.filter((name) => PAGES.test(name)), files = all.filter((name) => FILES.test(name));
const known = new Set([...pages, ...files]);
const made = ['index.html'];
for (const name of pages) {
  const at = join('guide', name.replace(/\.md$/, '.html'));
  const {title, body} = guidePage(await text(join(root, name)), name, known);
  await write(at, page({title, body, at}));
  made.push(at);
}
for (const name of files) await cp(join(root, name), join(out, 'guide', name));
for (const name of ['flux-gs-viewer.js', 'flux.wasm']) await cp(join(root, 'build/web/site/npm', name), join(out, name));
await cp(join(root, 'app/src/main/web/icon.svg'), join(out, 'icon.svg'));
await cp(join(root, 'docs/site/style.css'), join(out, 'style.css'));
const kilobytes = Math.round((await stat(join(out, 'sample/sample.glb'))).size / 1000);
const body = (await text(join(root, 'docs/site/index.html'))).replace('{{sample-kB}}', kilobytes);
await write('index.html', page({title: 'Flux-GS: 3D Gaussian Splatting for phones', body, at: 'index.html'}));
await checkLinks(made);
console.log(`build/site: ${made.length} pages`);
