// A web server for the tests: files of several folders, and answers that go wrong.
import {createReadStream, existsSync, statSync} from 'node:fs';
import {createServer} from 'node:http';
import {extname, join} from 'node:path';

const TYPES = {'.html': 'text/html', '.css': 'text/css', '.js': 'text/javascript', '.mjs': 'text/javascript', '.wasm': 'application/wasm', '.svg': 'image/svg+xml', '.jpg': 'image/jpeg',
  '.png': 'image/png', '.webmanifest': 'application/manifest+json'};

/** Files of the first of the folders that has them; a path is that of a file in one. */
export function serve(folders) {
  const server = createServer((request, answer) => {
    const path = decodeURIComponent(new URL(request.url, 'http://x').pathname);
    // /cut/FILE: promises all of a file and sends a third; /page/FILE: a web page; /slow/FILE: in parts
    const [, how, name] = /^\/(cut|html|slow|unknown)(\/.*)$/.exec(path) ?? [, '', path];
    if (how === 'html') return answer.writeHead(200, {'content-type': 'text/html'}).end('<p>Sign in</p>');
    const file = folders.map((folder) => join(folder, name === '/' ? 'index.html' : name)).find((f) => existsSync(f) && statSync(f).isFile());
    if (!file) return answer.writeHead(404).end('no such file');
    const size = statSync(file).size;
    const headers = {'content-type': TYPES[extname(file)] ?? 'application/octet-stream', 'cache-control': 'no-store'};
    if (how !== 'unknown') headers['content-length'] = size;
    answer.writeHead(200, headers);
    if (how === 'cut') createReadStream(file, {end: Math.floor(size / 3)}).on('end', () => answer.destroy()).pipe(answer, {end: false});
    else if (how === 'slow') sendSlowly(file, answer);
    else createReadStream(file).pipe(answer);
  });
  return new Promise((resolve) => server.listen(0, '127.0.0.1', () => resolve({
    address: `http://127.0.0.1:${server.address().port}/`,
    close: () => (server.closeAllConnections(), server.close()),
  })));
}

async function sendSlowly(file, answer) {
  for await (const part of createReadStream(file, {highWaterMark: 1 << 14})) {
    answer.write(part);
    await new Promise((resolve) => setTimeout(resolve, 30));
  }
  answer.end();
}
