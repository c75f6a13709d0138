// meta.json of a bundled .sog, which is a ZIP archive.
import {readFileSync} from 'node:fs';

import {load} from './programs.mjs';

const {unzipSync, strFromU8} = await load('fflate');

export function readSogMeta(file) {
  const files = unzipSync(readFileSync(file), {filter: ({name}) => name === 'meta.json'});
  if (!files['meta.json']) throw new Error('no meta.json in the archive');
  return JSON.parse(strFromU8(files['meta.json']));
}
