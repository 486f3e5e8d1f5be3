// Signals over time: least and greatest value for each pixel, made in the worker.

const PLOT = 130;
const LINES = ["#3d85d6", "#e8772e", "#3fa34d", "#d6453d", "#8e5bd0", "#1fa6b8", "#d65a9d", "#9a9a2e"];

/** @typedef {{name: string, bus: string, node: number | null, pdo: string, signal: string, unit: string, count: number}} Signal */

class PlotPanel {
  /** @param {any} box @param {Axis} axis @param {(kind: string, given: object) => Promise<any>} ask @param {(t: number) => void} goTo */
  constructor(box, axis, ask, goTo) {
    this.box = box;
    this.axis = axis;
    this.ask = ask;
    this.goTo = goTo;
    /** @type {Signal[] | null} */
    this.signals = null;
    /** @type {string[]} */
    this.chosen = [];
    /** @type {any[]} */
    this.canvases = [];
    /** @type {any[]} */
    this.drawn = [];
    this.wanted = "";
    this.busy = false;
    this.again = false;
    axis.views.push(() => this.draw());
  }

  clear() {
    this.signals = null;
    this.chosen = [];
    this.box.replaceChildren();
  }

  /**
   * Lists the signals. @param {string} [wanted] Text in their names.
   * @param {boolean} [choose] Draws the first of them.
   */
  async open(wanted = "", choose = false) {
    if (!this.signals) {
      this.box.replaceChildren(make("p", {}, say("html.reading")));
      this.signals = await this.ask("signals", {});
    }
    const lower = wanted.trim().toLowerCase();
    if (choose) this.chosen = (this.signals ?? []).map(({ name }) => name).filter((name) => name.toLowerCase().startsWith(lower)).slice(0, 4);
    this.list = make("div", { className: "signals" });
    this.area = make("div");
    const search = make("input", { type: "search", placeholder: say("html.search"), value: wanted.trim(), oninput: () => this.fill(search.value) });
    this.box.replaceChildren(make("p", {}, search), this.list, this.area);
    this.fill(wanted.trim());
    await this.plot();
  }

  /** A signal for people, with its bus where there are several. @param {Signal} one */
  titleOf({ bus, node, pdo, signal }) {
    const buses = new Set((this.signals ?? []).map((one) => one.bus)).size > 1 ? [bus] : [];
    return printable([...buses, node === null ? "" : say("html.node", { node }), pdo, signal].filter(Boolean).join(" "));
  }

  /** @param {string} wanted */
  fill(wanted) {
    const lower = wanted.toLowerCase();
    const found = (this.signals ?? []).filter((one) => [one.name, this.titleOf(one)].some((text) => text.toLowerCase().includes(lower)));
    this.list.replaceChildren(
      ...found.slice(0, 300).map((one) => {
        const { name, unit, count } = one;
        const box = make("input", { type: "checkbox", checked: this.chosen.includes(name), onchange: () => this.toggle(name) });
        return make("label", {}, box, ` ${this.titleOf(one)}`, make("span", { className: "quiet" }, ` ${printable(unit)} ${count}`));
      }),
    );
    if (!found.length) this.list.append(make("p", { className: "quiet" }, say("html.no_signals")));
  }

  /** @param {string} name */
  toggle(name) {
    this.chosen = this.chosen.includes(name) ? this.chosen.filter((one) => one !== name) : [...this.chosen, name].slice(-8);
    return this.plot();
  }

  async plot() {
    if (!this.area) return;
    await this.ask("values", { names: this.chosen });
    this.canvases = this.chosen.map(() => make("canvas", { tabIndex: 0 }));
    this.area.replaceChildren(...this.canvases);
    for (const canvas of this.canvases) handle(canvas, this.axis, () => 60, (t) => this.goTo(t));
    this.draw();
  }

  async draw() {
    const [first] = this.canvases;
    if (!first?.clientWidth || !this.chosen.length) return;
    if (this.busy) {
      this.again = true;
      return;
    }
    this.busy = true;
    const { from, to } = this.axis;
    const columns = Math.max(first.clientWidth - 60, 10);
    const found = await this.ask("envelope", { names: this.chosen, from, to, columns }).catch(() => []);
    this.busy = false;
    found.forEach((/** @type {any} */ one, /** @type {number} */ at) => this.line(this.canvases[at], one, at, { from, to, columns }));
    if (this.again) {
      this.again = false;
      this.draw();
    }
  }

  /** @param {any} canvas @param {any} one @param {number} at @param {{from: number, to: number, columns: number}} span */
  line(canvas, { name, least, most, before }, at, { from, to, columns }) {
    if (!canvas) return;
    const { pen, width } = penOf(canvas, PLOT);
    let [low, high] = [Infinity, -Infinity];
    for (let column = 0; column < columns; column += 1) {
      if (least[column] < low) low = least[column];
      if (most[column] > high) high = most[column];
    }
    if (!Number.isNaN(before)) [low, high] = [Math.min(low, before), Math.max(high, before)];
    const signal = this.signals?.find((one) => one.name === name);
    pen.fillStyle = colour("--text");
    if (signal) pen.fillText(`${this.titleOf(signal)} ${printable(signal.unit)}`, 64, 8, width - 64);
    if (!(low <= high)) return;
    const marks = [...new Set([low, high])];
    if (low === high) [low, high] = [low - 1, high + 1];
    const y = (/** @type {number} */ value) => PLOT - 6 - ((value - low) / (high - low)) * (PLOT - 26);
    pen.fillStyle = colour("--quiet");
    for (const mark of marks) pen.fillText(short(mark), 2, y(mark), 56);
    pen.strokeStyle = LINES[at % LINES.length];
    pen.beginPath();
    let last = before;
    if (!Number.isNaN(last)) pen.moveTo(60, y(last));
    for (let column = 0; column < columns; column += 1) {
      if (Number.isNaN(least[column])) continue;
      const x = 60 + column;
      if (Number.isNaN(last)) pen.moveTo(x, y(least[column]));
      else pen.lineTo(x, y(last));
      pen.lineTo(x, y(least[column]));
      pen.lineTo(x, y(most[column]));
      last = most[column];
    }
    if (!Number.isNaN(last)) pen.lineTo(width, y(last));
    pen.stroke();
    if (this.axis.cursor !== null) {
      pen.fillStyle = colour("--link");
      pen.fillRect(60 + ((this.axis.cursor - from) / (to - from)) * columns, 16, 1.5, PLOT);
    }
  }
}

/** @param {number} value */
function short(value) {
  return Number.isInteger(value) ? String(value) : value.toPrecision(5);
}
