// The frames of a capture with their meaning: numbers in arrays, lines packed in blocks.

/** Frames that are kept: more would not fit into the memory of a page. */
const MOST_FRAMES = 10000000;
/** Rows of a block of lines: as many as are restored in some milliseconds. */
const BLOCK_ROWS = 4096;
/** Blocks that stay restored. */
const MOST_BLOCKS = 4;

/**
 * Rows that have come at once. A block has the lines of BLOCK_ROWS rows.
 * @typedef {{rows: number, t: BigInt64Array, valid: Uint8Array | null, bus: Int32Array, buses: string[], node: Uint8Array,
 *   severity: Uint8Array, ends: Int32Array, blocks: Uint8Array<ArrayBuffer>[]}} FramePart
 */

class Frames {
  /** @param {Core} core */
  constructor(core) {
    this.core = core;
    /** @type {FramePart[]} */
    this.parts = [];
    /** @type {Map<Uint8Array, Uint8Array<ArrayBuffer>>} Blocks that are restored, the latest last. */
    this.restored = new Map();
    /** @type {number[]} */
    this.starts = [];
    this.count = 0;
    /** @type {Uint32Array | null} The rows that a filter shows; null for all. */
    this.shown = null;
    this.begin = 0n;
    this.hasTime = false;
  }

  /** @param {number} rows @param {Record<string, Column>} columns Of the table listing. */
  add(rows, columns) {
    if (this.count >= MOST_FRAMES) return;
    const { t_ns: t, bus, node, severity, line } = columns;
    const levels = severity.words.map((word) => LEVELS.indexOf(word) + 1);
    const marks = new Uint8Array(rows);
    for (let row = 0; row < rows; row += 1) if (!severity.isNull(row)) marks[row] = levels[severity.numbers[row]];
    if (!this.hasTime) {
      for (let row = 0; row < rows && !this.hasTime; row += 1) {
        if (!t.isNull(row)) [this.begin, this.hasTime] = [t.value(row), true];
      }
    }
    this.starts.push(this.count);
    this.count += rows;
    const valid = t.valid && Uint8Array.from({ length: rows }, (_, row) => Number(!t.isNull(row)));
    const ends = line.ends.slice(0, rows + 1);
    const address = line.bytes.byteOffset;
    /** @type {FramePart} */
    const part = {
      rows,
      valid,
      t: t.numbers.slice(0, rows),
      bus: bus.numbers.slice(0, rows),
      buses: bus.words,
      node: Uint8Array.from({ length: rows }, (_, row) => (node.isNull(row) ? NO_NODE : node.numbers[row])),
      severity: marks,
      ends,
      blocks: [],
    };
    this.parts.push(part);
    // From here on the core's memory may grow, and the columns are gone.
    for (let row = 0; row < rows; row += BLOCK_ROWS) {
      const [from, to] = blockOf(part, row);
      part.blocks.push(this.core.packed(this.core.copied(address + from, to - from)));
    }
  }

  /** Returns the lines of the block that a row is in. @param {FramePart} part @param {number} row */
  text(part, row) {
    const packed = part.blocks[Math.floor(row / BLOCK_ROWS)];
    const [from, to] = blockOf(part, row);
    const text = this.restored.get(packed) ?? this.core.restored(packed, to - from);
    this.restored.delete(packed);
    this.restored.set(packed, text);
    for (const oldest of this.restored.keys()) {
      if (this.restored.size <= MOST_BLOCKS) break;
      this.restored.delete(oldest);
    }
    return text;
  }

  /** @param {FramePart} part @param {number} row @returns {string} */
  line(part, row) {
    const [from] = blockOf(part, row);
    return DECODER.decode(this.text(part, row).subarray(part.ends[row] - from, part.ends[row + 1] - from));
  }

  /** @param {number} index @returns {[FramePart, number]} The part of a row and its place in it. */
  find(index) {
    let [low, high] = [0, this.starts.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.starts[middle] <= index) low = middle;
      else high = middle - 1;
    }
    return [this.parts[low], index - this.starts[low]];
  }

  /** @param {number} index @returns {number | null} Nanoseconds since the first frame. */
  time(index) {
    const [part, row] = this.find(index);
    return part.valid && !part.valid[row] ? null : Number(part.t[row] - this.begin);
  }

  /** @param {number} frame @returns {any} Null for a frame that is not kept. */
  of(frame) {
    if (frame < 1 || frame > this.count) return null;
    const [part, row] = this.find(frame - 1);
    const node = part.node[row];
    return {
      t: this.time(frame - 1),
      bus: part.buses[part.bus[row]] ?? "",
      node: node === NO_NODE ? null : node,
      line: this.line(part, row),
    };
  }

  /** @param {number} place Among the rows that are shown. */
  row(place) {
    const index = this.shown ? this.shown[place] : place;
    const [part, row] = this.find(index);
    const before = place ? this.time(this.shown ? this.shown[place - 1] : place - 1) : null;
    const t = this.time(index);
    return {
      frame: index + 1,
      t,
      delta: t === null || before === null ? null : t - before,
      bus: part.buses[part.bus[row]] ?? "",
      severity: LEVELS[part.severity[row] - 1] ?? "",
      line: this.line(part, row),
    };
  }

  get length() {
    return this.shown ? this.shown.length : this.count;
  }

  /** @param {number} from @param {number} count */
  rows(from, count) {
    const rows = [];
    for (let place = Math.max(from, 0); place < Math.min(from + count, this.length); place += 1) rows.push(this.row(place));
    return rows;
  }

  /** @param {number} frame @returns {number} The place of a frame, or of the next one that is shown. */
  place(frame) {
    if (!this.shown) return Math.min(Math.max(frame - 1, 0), Math.max(this.count - 1, 0));
    let [low, high] = [0, this.shown.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.shown[middle] < frame - 1) low = middle + 1;
      else high = middle;
    }
    return Math.min(low, Math.max(this.shown.length - 1, 0));
  }

  /** @param {number} t Nanoseconds since the first frame. @returns {number} The first frame from then on. */
  at(t) {
    const wanted = this.begin + BigInt(Math.round(t));
    let [low, high] = [0, this.count];
    while (low < high) {
      const middle = (low + high) >> 1;
      const [part, row] = this.find(middle);
      if (part.t[row] < wanted) low = middle + 1;
      else high = middle;
    }
    return Math.min(low + 1, this.count);
  }

  /**
   * Searches lines for a text, in small parts so that other work goes on between them.
   * @param {string} text @param {() => boolean} wanted
   */
  async search(text, wanted) {
    // Each byte is one character here, so that places of characters are places of bytes.
    const bytes = new TextDecoder("windows-1252");
    const lower = bytes.decode(new TextEncoder().encode(text)).toLowerCase();
    const found = [];
    for (let number = 0; number < this.parts.length; number += 1) {
      await new Promise((done) => setTimeout(done));
      if (!wanted()) throw new Superseded();
      const part = this.parts[number];
      for (let first = 0; first < part.rows; first += BLOCK_ROWS) {
        const [from, to] = blockOf(part, first);
        const packed = part.blocks[first / BLOCK_ROWS];
        const all = bytes.decode(this.core.restored(packed, to - from)).toLowerCase();
        const last = Math.min(first + BLOCK_ROWS, part.rows);
        let row = first;
        for (let at = all.indexOf(lower); at >= 0 && row < last; at = all.indexOf(lower, at + 1)) {
          while (row < last && part.ends[row + 1] - from <= at) row += 1;
          if (row >= last || at + lower.length > part.ends[row + 1] - from) continue;
          found.push(this.starts[number] + row);
          at = part.ends[row + 1] - from - 1;
        }
      }
    }
    return Uint32Array.from(found);
  }
}

/** Returns where the lines of the block of a row begin and end. @param {FramePart} part @param {number} row */
function blockOf({ rows, ends }, row) {
  const first = row - (row % BLOCK_ROWS);
  return [ends[first], ends[Math.min(first + BLOCK_ROWS, rows)]];
}

const NO_NODE = 255;
const LEVELS = ["info", "warning", "error"];
const DECODER = new TextDecoder();
