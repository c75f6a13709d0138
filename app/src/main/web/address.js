// What the page's address says, for the element: before it is made, since it reads some attributes once.
const viewer = document.querySelector('flux-gs-viewer');
const query = new URLSearchParams(location.search);
viewer.setAttribute('linked', '');
for (const name of ['background', 'noui', 'turntable', 'language', 'poster', 'renderer'])
  if (query.has(name)) viewer.setAttribute(name, query.get(name));
const url = query.get('url');
if (url) viewer.setAttribute('src', url);

/** The text of the view behind the address's #. */
export const viewInAddress = () => /(?:^#|&)view=([^&]+)/.exec(location.hash)?.[1] ?? '';
if (viewInAddress()) viewer.setAttribute('view', viewInAddress());
