// Tables of the core beside the frames: searched and sorted by the worker, a click leads to the frame.

/** Rows that are drawn at once. */
const DRAWN = 100;
/** Columns whose values have words. */
const WORDED = ["direction", "status", "severity"];
/** Columns of sentences, which may take several lines. */
const WIDE = ["name", "text", "message", "abort_text"];

class TablePanel {
  /**
   * @param {any} box @param {string} table @param {(kind: string, given: object) => Promise<any>} ask
   * @param {{go: (frame: number) => void, saves?: [string, () => void][]}} act `saves` are buttons that write a file.
   */
  constructor(box, table, ask, act) {
    this.table = table;
    this.ask = ask;
    this.act = act;
    /** @type {string | null} */
    this.sorted = null;
    this.down = false;
    /** @type {string[]} */
    this.columns = [];
    this.drawn = 0;
    this.number = 0;
    this.search = make("input", { type: "search", placeholder: say("html.search"), oninput: () => this.draw() });
    this.count = make("span", { className: "quiet" });
    this.head = make("tr");
    this.body = make("tbody");
    this.more = make("button", { type: "button", hidden: true, onclick: () => this.further() }, say("html.more"));
    const saves = (act.saves ?? []).flatMap(([said, onclick]) => [make("button", { type: "button", onclick }, said), " "]);
    box.replaceChildren(
      make("p", {}, this.search, " ", this.count, " ", ...saves),
      make("table", {}, make("thead", {}, this.head), this.body),
      this.more,
    );
    this.draw();
  }

  /** @param {string} name */
  sort(name) {
    this.down = this.sorted === name && !this.down;
    this.sorted = name;
    this.draw();
  }

  /** @param {number} from */
  async rows(from) {
    this.number += 1;
    const { number, table, sorted: sort, down } = this;
    const search = this.search.value.trim();
    const words = Object.fromEntries(WORDED.map((column) => [column, wordsOf(column)]));
    const found = await this.ask("listed", { table, search, sort, down, from, count: DRAWN, words });
    return number === this.number ? found : null; // an answer to an earlier question
  }

  async draw() {
    const found = await this.rows(0);
    if (!found) return;
    this.columns = found.columns;
    this.head.replaceChildren(
      ...found.columns.map((/** @type {string} */ name) => make("th", { onclick: () => this.sort(name) }, word("html_column", name))),
    );
    this.body.replaceChildren();
    this.drawn = 0;
    this.append(found);
  }

  async further() {
    const found = await this.rows(this.drawn);
    if (found) this.append(found);
  }

  /** @param {any} found */
  append({ rows, shown, count }) {
    this.count.textContent = say("html.rows", { shown, count });
    this.body.append(...rows.map((/** @type {any} */ row) => this.line(row)));
    this.drawn += rows.length;
    this.more.hidden = this.drawn >= shown;
  }

  /** @param {{cells: string[], frame: number | null, severity: string}} row */
  line({ cells, frame, severity }) {
    const className = (/** @type {number} */ place) => (WIDE.includes(this.columns[place]) ? "wide" : "");
    const line = make("tr", {}, ...cells.map((cell, place) => make("td", { className: className(place) }, printable(cell))));
    if (severity) line.classList.add(severity);
    if (frame === null) return line;
    line.classList.add("pick");
    line.tabIndex = 0;
    line.addEventListener("click", () => this.act.go(frame));
    line.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => event.key === "Enter" && this.act.go(frame));
    return line;
  }
}
