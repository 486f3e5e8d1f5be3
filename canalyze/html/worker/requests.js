// Requests of the page to the worker: one capture, read by one core. All that takes long is done here.

/** Lanes that are handed to the page, and changes of one of them. */
const MOST_LANES = 200;
const MOST_CHANGES = 20000;
/** Values of a signal that are kept, and signals. */
const MOST_VALUES = 4000000;
const MOST_SIGNALS = 20000;

class Requests {
  /** @param {Core} core @param {(message: object, transfer?: Transferable[]) => void} post */
  constructor(core, post) {
    this.core = core;
    this.post = post;
    this.frames = new Frames(core);
    /** @type {Recording | null} */
    this.recording = null;
    this.options = {};
    /** The last request of each kind: an earlier one that still runs is given up. */
    this.last = new Map();
    /** How often what runs was given up. */
    this.cancelled = 0;
    /** @type {((bytes: Uint8Array<ArrayBuffer>) => void) | null} */
    this.waiting = null;
    /** @type {Map<string, {t: Float64Array, v: Float64Array}>} */
    this.series = new Map();
    /** @type {Map<string, Rows>} */
    this.tables = new Map();
  }

  /** @param {number} part @param {number} at @param {number} length @returns {Promise<Uint8Array<ArrayBuffer>>} */
  read(part, at, length) {
    return new Promise((done) => {
      this.waiting = done;
      this.post({ read: { part, at, length } });
    });
  }

  /** @param {{parts: Part[], merge: boolean}} given */
  async looked({ parts, merge }) {
    const captures = parts.map((part, place) => new Capture(this.core, part, (at, length) => this.read(place, at, length)));
    const recording = new Recording(this.core, captures, merge);
    await recording.look();
    return recording;
  }

  /** @param {string} kind @returns {() => boolean} True until another request of its kind has come. */
  begun(kind) {
    const number = (this.last.get(kind) ?? 0) + 1;
    this.last.set(kind, number);
    return () => this.last.get(kind) === number;
  }

  /** Gives up what runs; what is open stays. */
  cancel() {
    this.cancelled += 1;
  }

  get opened() {
    if (!this.recording) throw new Superseded();
    return this.recording;
  }

  /** @param {{parts: Part[], merge: boolean, options: object}} asked */
  async open({ parts, merge, options }) {
    this.frames = new Frames(this.core);
    this.series = new Map();
    this.options = options;
    this.recording = null;
    this.recording = await this.looked({ parts, merge });
    this.tables = new Map(["transfers", "findings"].map((table) => [table, new Rows(table)]));
    const lanes = new Lanes();
    const take = (/** @type {string} */ table, /** @type {number} */ rows, /** @type {Record<string, Column>} */ columns) => {
      if (table === "listing") this.frames.add(rows, columns);
      else if (table === "lanes") lanes.add(rows, columns);
      else this.tables.get(table)?.add(rows, columns);
    };
    /** @type {Uint8Array[]} */
    const written = [];
    await this.pass({ format: "diagnosis", tables: ["listing", ...this.tables.keys(), "lanes"] }, {
      take,
      write: (bytes) => written.push(bytes),
    });
    const records = lines(written);
    const whole = records.find((one) => one.kind === "diagnosis");
    return {
      format: this.recording.format,
      damaged: this.recording.damaged,
      problems: records.filter((one) => one.kind === "problem"),
      whole,
      counts: Object.fromEntries([...this.tables].map(([table, { count }]) => [table, count])),
      lanes: lanes.list(this.frames.begin),
      lanes_left_out: lanes.others.size,
      complaints: this.core.complaints(),
      count: this.frames.count,
      begin: this.frames.hasTime ? String(this.frames.begin) : null,
    };
  }

  /** @param {object} options @param {Sinks} sinks */
  async pass(options, sinks) {
    let shown = 0;
    const progress = (/** @type {number} */ share) => {
      const now = performance.now();
      if (now - shown < 100) return;
      shown = now;
      this.post({ progress: { share, count: this.frames.count } });
    };
    const { cancelled } = this;
    const wanted = () => this.cancelled === cancelled && (sinks.wanted?.() ?? true);
    await this.opened.pass({ ...this.options, ...options }, { progress, ...sinks, wanted });
  }

  /** Diagnoses without keeping frames, for an index. @param {{parts: Part[], merge: boolean, options: object}} asked */
  async diagnose({ parts, merge, options }) {
    const recording = await this.looked({ parts, merge });
    /** @type {Uint8Array[]} */
    const written = [];
    await recording.pass({ ...options, format: "diagnosis" }, { write: (bytes) => written.push(bytes) });
    const records = lines(written);
    const whole = records.find((one) => one.kind === "diagnosis");
    return { problems: records.filter((one) => one.kind === "problem"), whole };
  }

  /** Returns the first and last time of a file and its buses. @param {{parts: Part[], merge: boolean, options: object}} asked */
  async span({ parts, merge, options }) {
    const recording = await this.looked({ parts, merge });
    /** @type {Uint8Array[]} */
    const written = [];
    await recording.pass({ ...options, format: "info" }, { write: (bytes) => written.push(bytes) });
    const [record] = lines(written);
    return { first: record?.first_t, last: record?.last_t, buses: record?.buses.map((/** @type {any} */ one) => one.bus) };
  }

  /** Returns true for a file that is a device description. @param {{head: ArrayBuffer}} asked */
  describes({ head }) {
    return this.core.describes(new Uint8Array(head));
  }

  /** Reads a device description. @param {{name: string, bytes: ArrayBuffer}} asked */
  describe({ name, bytes }) {
    return this.core.describe(name, new Uint8Array(bytes));
  }

  /** @param {{spelled: string}} asked */
  nodes({ spelled }) {
    return this.core.spelledNodes(spelled);
  }

  /** @param {{from: number, count: number}} asked */
  rows({ from, count }) {
    return this.frames.rows(from, count);
  }

  /** Returns the row of a frame, and its node. @param {{frame: number}} asked */
  row({ frame }) {
    return this.frames.of(frame);
  }

  /** @param {{frame: number}} asked */
  place({ frame }) {
    return this.frames.place(frame);
  }

  /** Returns the lines of frames, each once. @param {{frames: number[]}} asked @returns {{frame: number, line: string}[]} */
  lines({ frames }) {
    const kept = [...new Set(frames)].sort((one, other) => one - other).filter((frame) => this.frames.of(frame));
    return kept.map((frame) => ({ frame, line: this.frames.of(frame).line }));
  }

  /** @param {{t: number}} asked */
  frameAt({ t }) {
    return this.frames.at(t);
  }

  /** Shows the frames that an expression or a text takes; all for an empty one. @param {{expression: string}} asked */
  async filter({ expression }) {
    const wanted = this.begun("filter");
    if (!expression) {
      this.frames.shown = null;
    } else if (!expression.includes("=")) {
      this.frames.shown = await this.frames.search(expression, wanted);
    } else {
      /** @type {Uint32Array[]} */
      const found = [];
      await this.pass({ format: "columns", filter: expression, tables: ["frames"] }, {
        wanted,
        take: (_, rows, { frame }) => found.push(Uint32Array.from(frame.numbers.slice(0, rows), (/** @type {bigint} */ one) => Number(one) - 1)),
      });
      const shown = new Uint32Array(found.reduce((length, one) => length + one.length, 0));
      found.reduce((at, one) => (shown.set(one, at), at + one.length), 0);
      this.frames.shown = shown.filter((index) => index < this.frames.count);
    }
    return this.frames.length;
  }

  /** @param {{frame: number}} asked */
  async explain({ frame }) {
    const wanted = this.begun("explain");
    /** @type {Uint8Array[]} */
    const written = [];
    await this.pass({ format: "text", depth: "explain", filter: `frame=${frame}`, limit: 1 }, {
      wanted,
      write: (bytes) => written.push(bytes),
    });
    return new TextDecoder().decode(joined(written));
  }

  /** Reads a table that is not taken while a capture is opened, once. @param {{table: string}} asked */
  async table({ table }) {
    if (this.tables.has(table)) return;
    const rows = new Rows(table);
    await this.pass({ format: "columns", tables: [table] }, { take: (_, count, columns) => rows.add(count, columns) });
    this.tables.set(table, rows);
  }

  /**
   * @param {{table: string, search: string, sort: string | null, down: boolean, from: number, count: number,
   *   words: Record<string, Record<string, string>>}} asked
   */
  listed(asked) {
    return (this.tables.get(asked.table) ?? new Rows(asked.table)).listed(asked, this.frames.begin);
  }

  /** Returns the SDO transfer that a frame belongs to. @param {{frame: number, bus: string}} asked */
  transfer({ frame, bus }) {
    const table = this.tables.get("transfers");
    if (!table) return null;
    const [first, last, channel] = ["first_frame", "last_frame", "bus"].map((name) => table.at(name));
    const number = BigInt(frame);
    const within = table.rows.filter((row) => row[first] <= number && number <= row[last] && (row[channel] ?? "") === bus);
    const found = within.find((row) => row[first] === number || row[last] === number) ?? (within.length === 1 ? within[0] : null);
    return found && Object.fromEntries(table.columns.map((name, place) => [name, typeof found[place] === "bigint" ? Number(found[place]) : found[place]]));
  }

  /** Returns the names of signals with their unit and number of values. */
  async signals() {
    /** @type {Map<string, {name: string, bus: string, node: number | null, pdo: string, signal: string, unit: string, count: number}>} */
    const found = new Map();
    await this.pass({ format: "columns", tables: ["signals"] }, {
      take: (_, rows, { bus, node, pdo, signal, unit, value }) => {
        for (let row = 0; row < rows; row += 1) {
          if (value.isNull(row)) continue;
          const name = signalName(bus, node, pdo, signal, row);
          const one = found.get(name);
          if (one) one.count += 1;
          else if (found.size < MOST_SIGNALS) {
            const [of, number, from, what] = [bus, node, pdo, signal].map((column) => column.value(row));
            found.set(name, { name, bus: of ?? "", node: number, pdo: from ?? "", signal: what ?? "", unit: unit.value(row) ?? "", count: 1 });
          }
        }
      },
    });
    return [...found.values()].filter((one) => one.count > 1);
  }

  /** Reads the values of signals. @param {{names: string[]}} asked */
  async values({ names }) {
    const missing = names.filter((name) => !this.series.has(name));
    if (missing.length) {
      /** @type {Map<string, {t: number[], v: number[]}>} */
      const found = new Map(missing.map((name) => [name, { t: [], v: [] }]));
      await this.pass({ format: "columns", tables: ["signals"] }, {
        take: (_, rows, { t_ns: t, bus, node, pdo, signal, value }) => {
          for (let row = 0; row < rows; row += 1) {
            if (value.isNull(row) || t.isNull(row)) continue;
            const one = found.get(signalName(bus, node, pdo, signal, row));
            if (!one || one.t.length >= MOST_VALUES) continue;
            one.t.push(Number(t.value(row) - this.frames.begin));
            one.v.push(value.value(row));
          }
        },
      });
      for (const [name, { t, v }] of found) this.series.set(name, { t: Float64Array.from(t), v: Float64Array.from(v) });
    }
    return null;
  }

  /**
   * Returns least and greatest value of each of so many equal spans of time, NaN where there is none.
   * @param {{names: string[], from: number, to: number, columns: number}} asked
   */
  envelope({ names, from, to, columns }) {
    return names.map((name) => {
      const { t, v } = this.series.get(name) ?? { t: new Float64Array(0), v: new Float64Array(0) };
      const least = new Float64Array(columns).fill(NaN);
      const most = new Float64Array(columns).fill(NaN);
      const scale = columns / Math.max(to - from, 1);
      let before = NaN;
      for (let at = lowerBound(t, from) - 1; at < t.length && !(t[at] > to); at += 1) {
        if (at < 0) continue;
        if (t[at] < from) {
          before = v[at];
          continue;
        }
        const column = Math.min(Math.floor((t[at] - from) * scale), columns - 1);
        if (!(least[column] <= v[at])) least[column] = v[at];
        if (!(most[column] >= v[at])) most[column] = v[at];
      }
      return { name, least, most, before };
    });
  }

  /**
   * Makes a DCF of what was written to a node and accepted, as canalyze/dictionary/files.py does.
   * @param {{number: number, node: number, keys: [string, string][]}} asked
   */
  async dcf({ number, node, keys }) {
    /** @type {Uint8Array[]} */
    const written = [];
    await this.pass({ format: "objects" }, { write: (bytes) => written.push(bytes) });
    const records = lines(written).filter((one) => one.node === node);
    const buses = records.filter(({ kind }) => kind === "od_node").map(({ bus }) => bus);
    if (buses.length > 1) return { error: ["od.buses", { node, buses: buses.join(", ") }] };
    if (!buses.length) return { error: ["od.no_node", { node }] };
    const accepted = records.filter(({ kind, configured }) => kind === "od_object" && configured);
    if (!accepted.length) return { error: ["od.dcf_none", { node }] };
    /** @type {[number, number, number[]][]} */
    const values = accepted.map(({ index, sub, configured: { data, size } }) => {
      const bytes = data.match(/../g)?.map((/** @type {string} */ one) => parseInt(one, 16)) ?? [];
      return [parseInt(index, 16), sub, bytes.length === size ? bytes : []];
    });
    return { count: values.length, ...this.core.configured({ number, node, values, keys }) };
  }

  /** Returns a file of another form. @param {{options: object}} asked */
  async save({ options }) {
    /** @type {Uint8Array[]} */
    const written = [];
    await this.pass(options, { write: (bytes) => written.push(bytes) });
    return joined(written);
  }
}

/**
 * The changes of lanes, as the page draws them.
 * @typedef {{name: string, words: (string | null)[][], t: Float64Array, state: Uint16Array}} Lane `state` is the place of
 *   state and class among the words.
 */
class Lanes {
  constructor() {
    /** @type {Map<string, {t: bigint[], state: number[], words: Map<string, number>}>} */
    this.found = new Map();
    /** @type {Set<string>} Names of those that are not kept. */
    this.others = new Set();
  }

  /** @param {number} rows @param {Record<string, Column>} columns */
  add(rows, { lane, t_ns: t, state, class: kind }) {
    for (let row = 0; row < rows; row += 1) {
      const name = lane.value(row);
      let one = this.found.get(name);
      if (!one) {
        if (name.startsWith("pdo/")) continue;
        if (this.found.size >= MOST_LANES) {
          this.others.add(name);
          continue;
        }
        this.found.set(name, (one = { t: [], state: [], words: new Map() }));
      }
      if (one.t.length >= MOST_CHANGES || t.isNull(row)) continue;
      const said = JSON.stringify([state.value(row), kind.value(row)]);
      if (!one.words.has(said)) one.words.set(said, Math.min(one.words.size, 65535));
      one.t.push(t.value(row));
      one.state.push(one.words.get(said) ?? 0);
    }
  }

  /** @param {bigint} begin @returns {Lane[]} */
  list(begin) {
    const kinds = ["nmt", "drive", "emcy", "sdo", "value"];
    const rank = (/** @type {string} */ name) => kinds.indexOf(name.slice(0, name.indexOf("/")));
    return [...this.found]
      .sort(([one], [other]) => rank(one) - rank(other) || one.localeCompare(other, "en", { numeric: true }))
      .map(([name, { t, state, words }]) => ({
        name,
        words: [...words.keys()].map((said) => JSON.parse(said)),
        t: Float64Array.from(t, (one) => Number(one - begin)),
        state: Uint16Array.from(state),
      }));
  }
}

/** @param {Column} bus @param {Column} node @param {Column} pdo @param {Column} signal @param {number} row */
function signalName(bus, node, pdo, signal, row) {
  return [bus.value(row), node.value(row), pdo.value(row), signal.value(row)].filter((part) => part !== null && part !== "").join(" ");
}

/** @param {Uint8Array[]} written @returns {any[]} */
function lines(written) {
  const text = new TextDecoder().decode(joined(written));
  return text.split("\n").filter(Boolean).map((line) => JSON.parse(line));
}

/** @param {Float64Array} sorted @param {number} wanted */
function lowerBound(sorted, wanted) {
  let [low, high] = [0, sorted.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] < wanted) low = middle + 1;
    else high = middle;
  }
  return low;
}
