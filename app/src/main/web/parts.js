// The pieces that a viewer is made of: tools/web/build puts the texts of flux.js and worker.js in.
import glue from 'flux-glue-text';
import worker from 'flux-worker-text';
import {POLICY} from './core.js';

/** What a page that holds everything has in its own text: base64 of gzip. */
export async function inlineBytes(id) {
  const element = document.getElementById(id);
  if (!element) return null;
  const packed = Uint8Array.from(atob(element.textContent.trim()), (c) => c.charCodeAt(0));
  element.remove();  // its text need not be kept
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
  return new Response(stream).arrayBuffer();
}

let compiled;  // once for all viewers of a page

async function compileModule(url) {
  if (!globalThis.WebAssembly) throw new Error('this browser has no WebAssembly, or it is switched off');
  const inline = await inlineBytes('flux-gs-module');
  if (inline) return compileBytes(inline, 'the page\'s own module');
  try {
    return await WebAssembly.compileStreaming(fetch(url));
  } catch {  // a server that does not call it application/wasm
    const answer = await fetch(url);
    if (!answer.ok) throw new Error(`${url}: the server answered ${answer.status}; expected flux.wasm beside the viewer's script`);
    return compileBytes(await answer.arrayBuffer(), url);
  }
}

async function compileBytes(bytes, name) {
  try {
    return await WebAssembly.compile(bytes);
  } catch (error) {
    if (/unsafe-eval|Content.Security.Policy/i.test(error.message)) throw new Error(`the page's Content-Security-Policy forbids WebAssembly; ${POLICY}`);
    throw new Error(`${name}: is not the viewer's module, or was cut; expected the flux.wasm that came with the script (${error.message})`);
  }
}

export const parts = {
  glue,
  worker,
  compile: () => (compiled ??= compileModule(new URL('flux.wasm', import.meta.url).href).catch((error) => {
    compiled = undefined;  // another viewer may try again
    throw error;
  })),
};
