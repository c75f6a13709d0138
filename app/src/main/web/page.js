// The page of the viewer: what its address says, and what other pages may ask of it by postMessage.
import {viewOf} from './element.js';

const viewer = document.querySelector('flux-gs-viewer');
const query = new URLSearchParams(location.search);

for (const name of ['background', 'noui', 'turntable', 'language', 'poster'])
  if (query.has(name)) viewer.setAttribute(name, query.get(name));
const view = /(?:^#|&)view=([^&]+)/.exec(location.hash)?.[1];
if (viewOf(view)) viewer.setAttribute('view', view);
const url = query.get('url');
if (url) viewer.setAttribute('src', url);

// {call: 'open' | 'goTo' | 'set' | 'state' | 'picture', arguments: […], id} is answered by {id, result} or {id, error}
const CALLS = new Set(['open', 'goTo', 'set', 'state', 'picture']);
addEventListener('message', async ({data, source, origin}) => {
  if (!source || !data || !CALLS.has(data.call)) return;
  const target = origin === 'null' ? '*' : origin;
  try {
    const result = await viewer[data.call](...(data.arguments ?? []));
    source.postMessage({id: data.id, result}, {targetOrigin: target});
  } catch (error) {
    source.postMessage({id: data.id, error: String(error.message ?? error)}, {targetOrigin: target});
  }
});
if (parent !== window)
  for (const name of ['ready', 'error'])
    viewer.addEventListener(name, ({detail}) => parent.postMessage({event: name, detail}, '*'));

// Installable, and without a connection what was seen last; only where a server sends the page
if ('serviceWorker' in navigator && document.querySelector('link[rel=manifest]'))
  navigator.serviceWorker.register('offline.js').catch(() => {});
