// Keeps the viewer itself, and the scenes that were looked at last, for when there is no connection.
const KEPT = 'flux-gs-1';
const MOST = 12;  // files that are kept

self.addEventListener('install', (event) => {
  self.skipWaiting();
  event.waitUntil(caches.open(KEPT).then((cache) => cache.addAll(['./', 'viewer.js', 'flux.wasm', 'manifest.webmanifest', 'icon.svg'])));
});
self.addEventListener('activate', (event) => event.waitUntil(self.clients.claim()));

async function keep(request, answer) {
  const cache = await caches.open(KEPT);
  await cache.put(request, answer);
  const keys = await cache.keys();
  for (const key of keys.slice(5, Math.max(5, keys.length - MOST))) await cache.delete(key);
}

// The network first: what is kept may be old
self.addEventListener('fetch', (event) => {
  const {request} = event;
  if (request.method !== 'GET' || !request.url.startsWith(self.registration.scope)) return;
  event.respondWith((async () => {
    try {
      const answer = await fetch(request);
      if (answer.ok && answer.status === 200) event.waitUntil(keep(request, answer.clone()).catch(() => {}));
      return answer;
    } catch (error) {
      const kept = await caches.match(request, {ignoreSearch: request.mode === 'navigate'});
      if (kept) return kept;
      throw error;
    }
  })());
});
