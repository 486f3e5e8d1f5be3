// Unpacks LZMA, by which the core is packed: a quarter less than by gzip, which browsers unpack themselves.

/** Bits of a probability. */
const BITS = 11;
const HALF = 1 << (BITS - 1);
/** Where the probabilities of each kind begin. */
const AT = { match: 0, rep: 192, rep0: 204, rep1: 216, rep2: 228, short: 240, slots: 432, special: 688, align: 816, length: 832, repLength: 1346, literal: 1860 };

/** Returns what a file of the form `.lzma` has. @param {Uint8Array} packed @returns {Uint8Array<ArrayBuffer>} */
function unlzma(packed) {
  const lc = packed[0] % 9;
  const lp = Math.floor(packed[0] / 9) % 5;
  const pb = Math.floor(packed[0] / 45);
  const odds = new Uint16Array(AT.literal + (0x300 << (lc + lp))).fill(HALF);
  let out = new Uint8Array(packed.length * 4);
  let [place, range, code] = [18, 0xffffffff, 0];
  for (let at = 14; at < 18; at += 1) code = ((code << 8) | packed[at]) >>> 0;

  const normalize = () => {
    if (range >= 0x1000000) return;
    if (place >= packed.length) throw new Error("packed data that end early");
    range = (range << 8) >>> 0;
    code = ((code << 8) | packed[place]) >>> 0;
    place += 1;
  };
  const bit = (/** @type {number} */ at) => {
    const odd = odds[at];
    const bound = (range >>> BITS) * odd;
    const one = code >= bound;
    if (one) {
      range -= bound;
      code -= bound;
      odds[at] = odd - (odd >> 5);
    } else {
      range = bound;
      odds[at] = odd + ((2 * HALF - odd) >> 5);
    }
    normalize();
    return one ? 1 : 0;
  };
  const tree = (/** @type {number} */ at, /** @type {number} */ bits) => {
    let node = 1;
    for (let count = 0; count < bits; count += 1) node = (node << 1) | bit(at + node);
    return node - (1 << bits);
  };
  /** The bits of a tree, the least one first. @param {number} at @param {number} bits */
  const reversed = (at, bits) => {
    let [node, found] = [1, 0];
    for (let count = 0; count < bits; count += 1) {
      const one = bit(at + node);
      node = (node << 1) | one;
      found |= one << count;
    }
    return found;
  };
  const direct = (/** @type {number} */ bits) => {
    let found = 0;
    for (let count = 0; count < bits; count += 1) {
      range >>>= 1;
      const one = code >= range ? 1 : 0;
      if (one) code -= range;
      normalize();
      found = found * 2 + one;
    }
    return found;
  };
  const lengthOf = (/** @type {number} */ at, /** @type {number} */ alignment) => {
    if (!bit(at)) return tree(at + 2 + (alignment << 3), 3);
    if (!bit(at + 1)) return 8 + tree(at + 130 + (alignment << 3), 3);
    return 16 + tree(at + 258, 8);
  };
  const distanceOf = (/** @type {number} */ length) => {
    const slot = tree(AT.slots + (Math.min(length, 3) << 6), 6);
    if (slot < 4) return slot;
    const bits = (slot >> 1) - 1;
    const high = (2 | (slot & 1)) * 2 ** bits;
    if (slot < 14) return high + reversed(AT.special + high - slot, bits);
    return high + direct(bits - 4) * 16 + reversed(AT.align, 4);
  };

  let [at, state, last, second, third, fourth] = [0, 0, 0, 0, 0, 0];
  for (;;) {
    if (at + 300 > out.length) {
      const longer = new Uint8Array(out.length * 2);
      longer.set(out);
      out = longer;
    }
    const alignment = at & ((1 << pb) - 1);
    if (!bit(AT.match + (state << 4) + alignment)) {
      const before = at ? out[at - 1] : 0;
      const base = AT.literal + 0x300 * (((at & ((1 << lp) - 1)) << lc) + (before >> (8 - lc)));
      let symbol = 1;
      if (state >= 7) {
        for (let like = out[at - last - 1]; symbol < 0x100; like <<= 1) {
          const wanted = (like >> 7) & 1;
          const one = bit(base + ((1 + wanted) << 8) + symbol);
          symbol = (symbol << 1) | one;
          if (one !== wanted) break;
        }
      }
      while (symbol < 0x100) symbol = (symbol << 1) | bit(base + symbol);
      out[at] = symbol;
      at += 1;
      state = state < 4 ? 0 : state < 10 ? state - 3 : state - 6;
      continue;
    }
    let length;
    if (bit(AT.rep + state)) {
      if (!bit(AT.rep0 + state)) {
        if (!bit(AT.short + (state << 4) + alignment)) {
          state = state < 7 ? 9 : 11;
          out[at] = out[at - last - 1];
          at += 1;
          continue;
        }
      } else if (!bit(AT.rep1 + state)) {
        [last, second] = [second, last];
      } else if (!bit(AT.rep2 + state)) {
        [last, second, third] = [third, last, second];
      } else {
        [last, second, third, fourth] = [fourth, last, second, third];
      }
      length = lengthOf(AT.repLength, alignment);
      state = state < 7 ? 8 : 11;
    } else {
      [second, third, fourth] = [last, second, third];
      length = lengthOf(AT.length, alignment);
      state = state < 7 ? 7 : 10;
      last = distanceOf(length);
      if (last === 0xffffffff) return out.slice(0, at);
    }
    for (let rest = length + 2; rest > 0; rest -= 1) {
      out[at] = out[at - last - 1];
      at += 1;
    }
  }
}
