// The core in WebAssembly: the only file that knows its memory. canalyze/core/web/src/lib.rs has the other side.

/**
 * @typedef {[number, number]} Place Address and length in bytes.
 * @typedef {{name: string, type: string, rows: number, offset: number, nulls: [number, number, number] | null,
 *   buffers: Place[], words: string[] | null, values: Layout | null}} Layout
 * @typedef {{table: string, rows: number, columns: Layout[]}} Batch
 */

/** An error in the words of the core, for people. */
class Refused extends Error {}

class Core {
  /** @param {any} exports */
  constructor(exports) {
    this.exports = exports;
    this.decoder = new TextDecoder();
    this.encoder = new TextEncoder();
  }

  /** @param {WebAssembly.Module} module */
  static async of(module) {
    return new Core((await WebAssembly.instantiate(module, {})).exports);
  }

  /** @param {Uint8Array} bytes */
  put(bytes) {
    const address = this.exports.input(bytes.length);
    new Uint8Array(this.exports.memory.buffer, address, bytes.length).set(bytes);
  }

  /** @param {unknown} value */
  putJson(value) {
    this.put(this.encoder.encode(JSON.stringify(value)));
  }

  /** @param {number} address @param {number} length @returns {Uint8Array<ArrayBuffer>} A copy of bytes of its memory. */
  copied(address, length) {
    return new Uint8Array(this.exports.memory.buffer, address, length).slice();
  }

  /** @param {number} length @returns {Uint8Array<ArrayBuffer>} A copy of the last output. */
  taken(length) {
    return this.copied(this.exports.output(), length);
  }

  /** @param {number} length */
  text(length) {
    return this.decoder.decode(this.taken(length));
  }

  /** @param {number} length Of an error; 0 without one. */
  accept(length) {
    if (length) throw new Refused(this.text(length));
  }

  /** Begins to unpack a file packed by zstd. @returns {number} Its number, until the next session begins. */
  unpack() {
    return this.exports.unpack();
  }

  /** @param {number} number @param {Uint8Array} packed @returns {Uint8Array<ArrayBuffer>} As far as it is sound. */
  unpacked(number, packed) {
    this.put(packed);
    return this.taken(this.exports.unpacked(number));
  }

  /** True if all that was unpacked is sound and ends where it has to. @param {number} number */
  isSound(number) {
    return Boolean(this.exports.sound(number));
  }

  /** Packs bytes that are kept. @param {Uint8Array} bytes @returns {Uint8Array<ArrayBuffer>} */
  packed(bytes) {
    this.put(bytes);
    return this.taken(this.exports.packed());
  }

  /** Restores bytes that were packed. @param {Uint8Array} packed @param {number} length @returns {Uint8Array<ArrayBuffer>} */
  restored(packed, length) {
    this.put(packed);
    return this.taken(this.exports.restored(length));
  }

  /** True if a file that begins so is a device description. @param {Uint8Array} head */
  describes(head) {
    this.put(head);
    return Boolean(this.exports.describes());
  }

  /** Reads a device description, which gets the next number. @param {string} name @param {Uint8Array} content @returns {any} */
  describe(name, content) {
    const named = this.encoder.encode(name);
    this.put(joined([named, content]));
    return JSON.parse(this.text(this.exports.describe(named.length)));
  }

  /**
   * Makes a DCF of a description.
   * @param {{number: number, node: number, values: [number, number, number[]][], keys: [string, string][]}} given @returns {any}
   */
  configured(given) {
    this.putJson(given);
    return JSON.parse(this.text(this.exports.configured()));
  }

  /** Reads node-IDs such as `1-4,7`. @param {string} spelled @returns {number[] | null} */
  spelledNodes(spelled) {
    this.put(this.encoder.encode(spelled));
    return JSON.parse(this.text(this.exports.spelled_nodes()));
  }

  /** Begins a session. @param {object} options By the names of canalyze/running/reading.py. */
  open(options) {
    this.putJson(options);
    this.accept(this.exports.open());
  }

  /** @param {Uint8Array} head @param {boolean} complete */
  sniff(head, complete) {
    this.put(head);
    return this.text(this.exports.sniffed(complete));
  }

  /** @param {string} name @param {string} format @param {number} [place] Of several files that are joined by time. */
  begin(name, format, place = 0) {
    this.putJson({ name, format, regular: true });
    this.accept(this.exports.begin(place));
  }

  /** @param {Uint8Array} bytes @param {number} [place] */
  feed(bytes, place = 0) {
    this.put(bytes);
    return this.taken(this.exports.feed(place));
  }

  /** @param {{kind: string, offset: number, bytes: number | null}} damage @param {number} [place] */
  damaged(damage, place = 0) {
    this.putJson(damage);
    this.accept(this.exports.damaged(place));
  }

  /** @param {boolean} interrupted @param {number} [place] */
  end(interrupted, place = 0) {
    return this.taken(this.exports.end(place, interrupted));
  }

  /** @returns {number} The place of the file that has to be fed next; -1 if there is none. */
  get wants() {
    return this.exports.wants();
  }

  finish() {
    return this.taken(this.exports.finish());
  }

  get done() {
    return Boolean(this.exports.done());
  }

  /** @returns {number} */
  get frames() {
    return this.exports.frames();
  }

  /** @returns {string[]} */
  complaints() {
    return JSON.parse(this.text(this.exports.complaints()) || "[]");
  }

  /** @param {string} call One of tally, nodes, snapshot, contents: their JSON. */
  json(call) {
    return JSON.parse(this.text(this.exports[call]()) || "null");
  }

  nature() {
    return this.text(this.exports.nature());
  }

  /** Takes batches; their columns can be read until the next call. @param {boolean} flush @returns {Batch[]} */
  batches(flush) {
    const length = this.exports.batches(flush);
    return length ? JSON.parse(this.text(length)) : [];
  }

  /** @param {Batch} batch @returns {Record<string, Column>} */
  columns(batch) {
    const buffer = this.exports.memory.buffer;
    return Object.fromEntries(batch.columns.map((one) => [one.name, new Column(buffer, one)]));
  }
}

/** @param {Uint8Array[]} pieces */
function joined(pieces) {
  const all = new Uint8Array(pieces.reduce((length, piece) => length + piece.length, 0));
  let at = 0;
  for (const piece of pieces) {
    all.set(piece, at);
    at += piece.length;
  }
  return all;
}
