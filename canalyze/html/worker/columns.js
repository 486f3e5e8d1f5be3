// Columns in Arrow's memory layout, as canalyze/core/web/src/layout.rs describes them.

/** @type {Record<string, any>} */
const NUMBERS = {
  Int8: Int8Array,
  Int16: Int16Array,
  Int32: Int32Array,
  Int64: BigInt64Array,
  UInt8: Uint8Array,
  UInt16: Uint16Array,
  UInt32: Uint32Array,
  UInt64: BigUint64Array,
  Float32: Float32Array,
  Float64: Float64Array,
  Dictionary: Int32Array,
};

class Column {
  /** @param {ArrayBuffer} memory @param {Layout} layout */
  constructor(memory, layout) {
    this.memory = memory;
    this.layout = layout;
    this.rows = layout.rows;
    this.words = layout.words ?? [];
    const { nulls, buffers, type } = layout;
    /** @type {any} One typed array, by the type: numbers, bits, or the ends of texts and lists in what follows. */
    this.numbers = null;
    /** @type {any} */
    this.bits = null;
    /** @type {any} */
    this.ends = null;
    /** @type {any} */
    this.bytes = null;
    /** @type {any} */
    this.items = null;
    this.valid = nulls && new Uint8Array(memory, nulls[0], nulls[1]);
    const [address, bytes] = buffers[0];
    if (type in NUMBERS) {
      this.numbers = new NUMBERS[type](memory, address, bytes / NUMBERS[type].BYTES_PER_ELEMENT);
    } else if (type === "Boolean") {
      this.bits = new Uint8Array(memory, address, bytes);
    } else {
      this.ends = new Int32Array(memory, address, bytes / 4);
      if (layout.values) this.items = new Column(memory, layout.values);
      else this.bytes = new Uint8Array(memory, ...buffers[1]);
    }
  }

  /** @param {number} row */
  isNull(row) {
    if (!this.valid || !this.layout.nulls) return false;
    const bit = row + this.layout.nulls[2];
    return !((this.valid[bit >> 3] >> (bit & 7)) & 1);
  }

  /** @param {number} row @returns {any} */
  value(row) {
    if (this.isNull(row)) return null;
    if (this.numbers) {
      const number = this.numbers[row];
      return this.layout.type === "Dictionary" ? this.words[number] : number;
    }
    if (this.bits) {
      const bit = row + this.layout.offset;
      return Boolean((this.bits[bit >> 3] >> (bit & 7)) & 1);
    }
    const [from, to] = [this.ends[row], this.ends[row + 1]];
    if (this.items) {
      return Array.from({ length: to - from }, (_, place) => this.items.value(from + place));
    }
    const bytes = this.bytes.slice(from, to);
    return this.layout.type === "Utf8" ? new TextDecoder().decode(bytes) : bytes;
  }

  /** The value for the page: numbers of 64 bits as numbers. @param {number} row @returns {any} */
  plain(row) {
    const value = this.value(row);
    return typeof value === "bigint" ? Number(value) : value;
  }
}
