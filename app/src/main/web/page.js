// The page of the viewer: what its address says, and what other pages may ask of it by postMessage.
import {viewInAddress} from './address.js';
import {viewOf} from './element.js';

const viewer = document.querySelector('flux-gs-viewer');
addEventListener('hashchange', () => {
  const view = viewOf(viewInAddress());
  if (view) viewer.goTo(view);
});

// {call: 'open' | 'goTo' | 'set' | 'state' | 'picture', arguments: […], id} is answered by {id, result} or {id, error}
const CALLS = new Set(['open', 'goTo', 'set', 'state', 'picture']);
addEventListener('message', async ({data, source, origin}) => {
  if (!source || typeof data !== 'object' || !data || !('call' in data)) return;
  const target = origin === 'null' ? '*' : origin;
  try {
    if (!CALLS.has(data.call)) throw new Error(`there is no call '${data.call}'; expected one of ${[...CALLS].join(', ')}`);
    if (!Array.isArray(data.arguments ?? [])) throw new Error('arguments: expected a list');
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
