// Tables of the core that are kept for the page: it is given the rows that it shows, as text.

/** Rows of a table that are kept. */
const MOST_ROWS = 100000;

const COLUMNS = /** @type {Record<string, string[]>} */ ({
  transfers: ["first_frame", "t_ns", "node", "direction", "object", "name", "text", "size", "duration_ns", "status",
    "abort_text", "last_frame", "bus"],
  findings: ["frame", "code", "severity", "node", "message"],
  od: ["node", "index", "sub", "name", "type", "access", "text", "values", "frame"],
});
/** Columns for people, from the first on. */
const SHOWN = /** @type {Record<string, number>} */ ({ transfers: 11, findings: 5, od: 8 });

class Rows {
  /** @param {string} table */
  constructor(table) {
    this.table = table;
    this.columns = COLUMNS[table];
    /** @type {any[][]} */
    this.rows = [];
    this.count = 0;
  }

  /** @param {string} name */
  at(name) {
    return this.columns.indexOf(name);
  }

  /** @param {number} count @param {Record<string, Column>} columns */
  add(count, columns) {
    this.count += count;
    const wanted = this.columns.map((name) => columns[name]);
    for (let row = 0; row < count && this.rows.length < MOST_ROWS; row += 1) {
      this.rows.push(wanted.map((column) => column.value(row)));
    }
  }

  /**
   * Returns rows that have a text, in the order of a column.
   * @param {{search: string, sort: string | null, down: boolean, from: number, count: number, words: Record<string, Record<string, string>>}} asked
   * `words` are those for values, by column.
   * @param {bigint} begin
   */
  listed({ search, sort, down, from, count, words }, begin) {
    const shown = this.columns.slice(0, SHOWN[this.table]);
    const cells = (/** @type {any[]} */ row) => shown.map((name, place) => words[name]?.[row[place]] ?? textOf(name, row[place], begin));
    const wanted = search.toLowerCase();
    let { rows } = this;
    if (wanted) rows = rows.filter((row) => cells(row).some((cell) => cell.toLowerCase().includes(wanted)));
    if (sort) {
      const place = this.at(sort);
      const sign = down ? -1 : 1;
      rows = [...rows].sort((one, other) => sign * compared(one[place], other[place]));
    }
    const frame = Math.max(this.at("frame"), this.at("first_frame"));
    const severity = this.at("severity");
    return {
      columns: shown,
      shown: rows.length,
      count: this.count,
      rows: rows.slice(from, from + count).map((row) => ({
        cells: cells(row),
        frame: row[frame] === null ? null : Number(row[frame]),
        severity: severity < 0 ? "" : row[severity],
      })),
    };
  }
}

/** @param {any} one @param {any} other */
function compared(one, other) {
  if (one === null || other === null) return Number(one === null) - Number(other === null);
  return one < other ? -1 : Number(one > other);
}

/** @param {string} name @param {any} value @param {bigint} begin @returns {string} */
function textOf(name, value, begin) {
  if (value === null) return "";
  if (name === "t_ns") return (Number(value - begin) / 1e9).toFixed(6);
  if (name === "duration_ns") return `${(Number(value) / 1e6).toFixed(1)} ms`;
  if (name === "index") return `${value.toString(16).toUpperCase().padStart(4, "0")}h`;
  if (name === "sub") return value.toString(16).toUpperCase().padStart(2, "0");
  return String(value);
}
