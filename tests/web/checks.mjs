// Tests by their names: each runs, and what went wrong is told at the end.
export class Checks {
  #passed = 0;
  #failed = [];
  #filter;

  constructor(filter) {
    this.#filter = filter && new RegExp(filter);
  }

  async test(name, run) {
    if (this.#filter && !this.#filter.test(name)) return;
    const began = performance.now();
    try {
      await run();
      ++this.#passed;
      console.log(`passed ${name} (${Math.round(performance.now() - began)} ms)`);
    } catch (error) {
      this.#failed.push(name);
      console.log(`FAILED ${name}\n  ${String(error.stack ?? error).replaceAll('\n', '\n  ')}`);
    }
  }

  /** The last line, which tools/test reads, and the exit status. */
  finish(began) {
    console.log(`web: ${this.#passed} passed, ${this.#failed.length} failed in ${Math.round((performance.now() - began) / 1000)} s`);
    return this.#failed.length ? 1 : 0;
  }
}

export function expect(what, holds) {
  if (!holds) throw new Error(what);
}
export function expectEqual(what, found, wanted) {
  const [a, b] = [JSON.stringify(found), JSON.stringify(wanted)];
  if (a !== b) throw new Error(`${what}: ${a}; expected ${b}`);
}
