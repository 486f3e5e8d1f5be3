// Joins files that are parts of one recording, by the rules of canalyze/sources/names.py.

/** Longest time from the end of a part to the begin of the next. */
const APART_NS = 5000000000n;
/** Least stamp of a calendar's clock (1973). */
const EPOCH_NS = 100000000n * 1000000000n;

/** @typedef {{source: Source, begin: bigint | null, end: bigint | null, buses: string[]}} Span */

/** @param {Span} one @param {Span} other */
function shared(one, other) {
  return one.buses.some((bus) => other.buses.includes(bus));
}

/** Returns true if a file goes on where another one has ended. @param {Span} one @param {Span} before */
function follows(one, before) {
  if (one.begin === null || before.end === null || !shared(one, before)) return false;
  const apart = one.begin - before.end;
  return one.begin >= EPOCH_NS && apart >= 0n && apart <= APART_NS;
}

/** Returns true if both have frames of the same bus and time. @param {Span} one @param {Span} other */
function overlaps(one, other) {
  if (one.begin === null || one.end === null || other.begin === null || other.end === null) return false;
  return shared(one, other) && one.begin < other.end && other.begin < one.end;
}

/** Returns a capture for each recording, in the order in which their first files were given. @param {Span[]} spans */
function recordingsOf(spans) {
  const begin = (/** @type {Span} */ one) => one.begin ?? 0n;
  const timed = spans.filter((one) => one.begin !== null).sort((one, other) => (begin(one) < begin(other) ? -1 : Number(begin(one) > begin(other))));
  const alone = new Set(timed.filter((one) => timed.some((other) => other !== one && overlaps(one, other))));
  /** @type {Span[][]} */
  const chains = [];
  for (const span of timed) {
    const before = [...chains].reverse().find((chain) => {
      const last = chain[chain.length - 1];
      return follows(span, last) && !alone.has(last);
    });
    if (before && !alone.has(span)) before.push(span);
    else chains.push([span]);
  }
  chains.push(...spans.filter((one) => one.begin === null).map((one) => [one]));
  const place = (/** @type {Span[]} */ chain) => Math.min(...chain.map((one) => spans.indexOf(one)));
  chains.sort((one, other) => place(one) - place(other));
  return chains.map((chain) => joinedSource(chain.map(({ source }) => source)));
}

/** @param {Source[]} sources @returns {Source} */
function joinedSource(sources) {
  return { name: sources.map(({ name }) => name).join(", "), parts: sources.flatMap(({ parts }) => parts) };
}
