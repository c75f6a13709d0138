// What people see while the tests run, on standard error.
import {writeSync} from 'node:fs';
import {isatty} from 'node:tty';

const STANDARD_ERROR = 2;

/**
 * Not by process.stderr or console.error: they make a pipe non-blocking for every program that
 * writes to it, and `tee` behind this one then loses output.
 */
export const tell = (text) => writeSync(STANDARD_ERROR, text);

/** Writes over the line that was written last; only on a terminal. */
export function progress(text) {
  if (isatty(STANDARD_ERROR)) tell(`\r${text}`);
}
