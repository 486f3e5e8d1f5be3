// A capture file: its pieces, unpacked, and passes of the core over them.

/** Bytes that are read at once. */
const PIECE = 1 << 20;
/** Packed bytes that are unpacked at once: they may become ten thousand times as many. */
const PACKED = 1 << 14;
/** Bytes within which the format shows. */
const HEAD = 1 << 16;
/** The formats that the core reads; those of python-can and other compressions are the command line's. */
const FORMATS = ["candump", "asc", "blf", "mcap", "pcap", "pcapng", "rows", "trc"];

/** A later request has made this one needless. */
class Superseded extends Error {}

/** A file is of a format that the page cannot read: the message. */
class Unreadable extends Error {
  /** @param {string} format @param {string} file */
  constructor(format, file) {
    super(format);
    this.file = file;
  }
}

/**
 * @typedef {AsyncGenerator<Uint8Array<ArrayBuffer>>} Pieces
 * @typedef {(table: string, rows: number, columns: Record<string, Column>) => void} Take
 * @typedef {{take?: Take, write?: (bytes: Uint8Array<ArrayBuffer>) => void, progress?: (share: number) => void,
 *   wanted?: () => boolean}} Sinks
 */

/**
 * A file as the page describes it; with a format it is not looked at for one.
 * @typedef {{name: string, size: number, format?: string, damage?: {kind: string, offset: number, bytes: number | null} | null}} Part
 */

class Capture {
  /** @param {Core} core @param {Part} part @param {(at: number, length: number) => Promise<Uint8Array<ArrayBuffer>>} read */
  constructor(core, { name, size, format = "", damage = null }, read) {
    this.core = core;
    this.name = name;
    this.size = size;
    this.read = read;
    this.format = format;
    this.damage = damage;
    /** @type {((pieces: Pieces) => Pieces)[]} Compression and encoding around the capture, from outside. */
    this.layers = [];
    /** Bytes of the file that have been read. */
    this.at = 0;
    /** True if what is packed is damaged. */
    this.damaged = false;
    if (format) this.layers.push((pieces) => this.unpacked(pieces)); // inside a page all is packed
  }

  /** Finds out the format, as canalyze/sources does. */
  async look() {
    while (!this.format) {
      const { form, head } = await this.sniffed();
      if (form === "gzip" && !this.layers.length) {
        this.layers.push((pieces) => this.unpacked(pieces));
      } else if (form === "zstd" && !this.layers.length) {
        this.layers.push((pieces) => this.unpackedZstd(pieces));
      } else if ((form.startsWith("utf-16") || form === "gbk") && this.layers.length < 2) {
        const encoding = form !== "utf-16" ? form : head[0] === 0xff ? "utf-16le" : "utf-16be";
        this.layers.push((pieces) => transcoded(pieces, encoding));
      } else if (FORMATS.includes(form)) {
        this.format = form;
      } else {
        throw new Unreadable(form, this.name);
      }
    }
  }

  async sniffed() {
    let head = new Uint8Array(0);
    for await (const piece of this.pieces()) {
      head = joined([head, piece]);
      const form = this.core.sniff(head.subarray(0, HEAD), false);
      if (form) return { form, head };
    }
    return { form: this.core.sniff(head, true) || "candump", head };
  }

  /** @returns {Pieces} */
  async *plain() {
    for (this.at = 0; this.at < this.size; ) {
      const piece = await this.read(this.at, PIECE);
      if (!piece.length) return;
      this.at += piece.length;
      yield piece;
    }
  }

  pieces() {
    return this.layers.reduce((pieces, layer) => layer(pieces), this.plain());
  }

  /** @param {Pieces} packed @returns {Pieces} */
  async *unpacked(packed) {
    const stream = new DecompressionStream("gzip");
    const to = stream.writable.getWriter();
    const from = stream.readable.getReader();
    let over = false;
    const fed = (async () => {
      for await (const piece of packed) {
        if (over) return;
        await to.ready;
        await to.write(piece);
      }
      await to.close();
    })();
    fed.catch(() => {}); // the reader has the same error
    try {
      for (;;) {
        const { done, value } = await from.read().catch(() => {
          this.damaged = true;
          return { done: true, value: undefined };
        });
        if (done || !value) return;
        yield value;
      }
    } finally {
      over = true;
      from.cancel().catch(() => {});
    }
  }

  /** @param {Pieces} packed @returns {Pieces} */
  async *unpackedZstd(packed) {
    const number = this.core.unpack();
    for await (const piece of packed) {
      for (let at = 0; at < piece.length; at += PACKED) {
        const made = this.core.unpacked(number, piece.subarray(at, at + PACKED));
        if (made.length) yield made;
      }
    }
    this.damaged ||= !this.core.isSound(number);
  }

  /** Ends the file in the session. @param {number} place */
  end(place) {
    if (this.damage) this.core.damaged(this.damage, place);
    return this.core.end(this.damaged, place);
  }
}

/** The files of one capture, one after the other or joined by time. */
class Recording {
  /** @param {Core} core @param {Capture[]} captures @param {boolean} merge */
  constructor(core, captures, merge) {
    this.core = core;
    this.captures = captures;
    this.merge = merge;
  }

  get damaged() {
    return this.captures.some((one) => one.damaged);
  }

  get format() {
    return [...new Set(this.captures.map((one) => one.format))].join(", ");
  }

  get share() {
    const [at, size] = this.captures.reduce(([sum, whole], one) => [sum + one.at, whole + one.size], [0, 0]);
    return size ? at / size : 1;
  }

  async look() {
    for (const one of this.captures) await one.look();
  }

  /** Runs a session over all files. @param {object} options @param {Sinks} sinks */
  async pass(options, { take, write, progress, wanted }) {
    const { core } = this;
    core.open(options);
    const taken = (/** @type {boolean} */ flush) => {
      if (take) for (const batch of core.batches(flush)) take(batch.table, batch.rows, core.columns(batch));
    };
    const out = (/** @type {Uint8Array<ArrayBuffer>} */ bytes) => {
      if (wanted && !wanted()) throw new Superseded();
      if (bytes.length && write) write(bytes);
      taken(false);
      progress?.(this.share);
    };
    for (const one of this.captures) Object.assign(one, { at: 0, damaged: false });
    for (const group of this.merge ? [this.captures] : this.captures.map((one) => [one])) {
      const pieces = group.map((one, place) => {
        core.begin(one.name, one.format, place);
        return one.pieces();
      });
      for (let place = core.wants; place >= 0 && !core.done; place = core.wants) {
        const { done, value } = await pieces[place].next();
        out(done ? group[place].end(place) : core.feed(value, place));
      }
      for (const one of pieces) await one.return(undefined);
    }
    out(core.finish());
    taken(true);
  }
}

/** @param {Pieces} pieces @param {string} encoding @returns {Pieces} */
async function* transcoded(pieces, encoding) {
  const decoder = new TextDecoder(encoding);
  const encoder = new TextEncoder();
  for await (const piece of pieces) yield encoder.encode(decoder.decode(piece, { stream: true }));
  const rest = encoder.encode(decoder.decode());
  if (rest.length) yield rest;
}
