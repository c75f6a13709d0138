// meta.json of a bundled .sog, read from the ZIP archive without a library (APPNOTE.TXT of PKWARE).
import {readFileSync} from 'node:fs';
import {inflateRawSync} from 'node:zlib';

const entrySignature = 0x02014b50, endSignature = Buffer.from('PK\x05\x06', 'latin1');

/** A file of an archive, stored or deflated. */
function unzipped(bytes, wanted) {
  const end = bytes.lastIndexOf(endSignature);
  let at = bytes.readUInt32LE(end + 16);  // of the directory
  while (bytes.readUInt32LE(at) === entrySignature) {
    const method = bytes.readUInt16LE(at + 10), size = bytes.readUInt32LE(at + 20);
    const [nameSize, extraSize, commentSize] = [28, 30, 32].map((o) => bytes.readUInt16LE(at + o));
    const local = bytes.readUInt32LE(at + 42);
    if (bytes.toString('utf8', at + 46, at + 46 + nameSize) === wanted) {
      const begin = local + 30 + bytes.readUInt16LE(local + 26) + bytes.readUInt16LE(local + 28);
      const data = bytes.subarray(begin, begin + size);
      return method === 0 ? data : inflateRawSync(data);
    }
    at += 46 + nameSize + extraSize + commentSize;
  }
  throw new Error(`no ${wanted} in the archive`);
}

export const readSogMeta = (file) => JSON.parse(unzipped(readFileSync(file), 'meta.json'));
