// The list of frames: as many rows as are seen, of any number.

/** Height of a row in pixels, as in page.css. */
const ROW = 20;
/** Most pixels that a browser can scroll. */
const TALLEST = 8000000;
const BLOCK = 200;
const BLOCKS = 30;

class FrameList {
  /** @param {any} box @param {(kind: string, given: object) => Promise<any>} ask @param {(frame: number) => void} choose */
  constructor(box, ask, choose) {
    this.box = box;
    this.ask = ask;
    this.height = box.querySelector(".height");
    this.rows = box.querySelector(".rows");
    this.choose = choose;
    this.length = 0;
    this.top = 0;
    this.scrolled = 0;
    this.chosen = 0;
    /** @type {Set<number>} Frames that belong to what is looked at. */
    this.marked = new Set();
    this.time = "since";
    this.begin = /** @type {string | null} */ (null);
    /** @type {Map<number, any[] | null>} */
    this.blocks = new Map();
    this.generation = 0;
    /** @type {number | null} The place that stays in view until the list is scrolled. */
    this.kept = null;
    box.addEventListener("scroll", () => this.onScroll());
    box.addEventListener("wheel", (/** @type {WheelEvent} */ event) => this.onWheel(event), { passive: false });
    new ResizeObserver(() => (this.kept === null ? this.draw() : this.reveal(this.kept))).observe(box);
    this.rows.addEventListener("click", (/** @type {any} */ event) => {
      const row = event.target.closest(".row");
      if (row?.dataset.frame) this.choose(Number(row.dataset.frame));
    });
  }

  get seen() {
    return Math.max(Math.ceil(this.box.clientHeight / ROW), 1);
  }

  get last() {
    return Math.max(this.length - Math.floor(this.box.clientHeight / ROW), 0);
  }

  /** @param {number} length */
  grow(length) {
    if (length === this.length) return;
    this.blocks.delete(Math.floor(this.length / BLOCK));
    this.length = length;
    this.height.style.height = `${Math.min(length * ROW, TALLEST)}px`;
    this.draw();
  }

  /** Shows other rows. @param {number} length */
  reset(length) {
    this.generation += 1;
    this.blocks.clear();
    this.kept = null;
    this.length = -1;
    this.grow(length);
    this.moveTo(0);
  }

  onScroll() {
    const { box } = this;
    if (Math.abs(box.scrollTop - this.scrolled) > 1) {
      const most = Math.max(box.scrollHeight - box.clientHeight, 1);
      this.top = (box.scrollTop / most) * this.last;
      this.kept = null;
      this.scrolled = box.scrollTop;
    }
    this.draw();
  }

  /** @param {WheelEvent} event */
  onWheel(event) {
    if (this.length * ROW <= TALLEST || event.ctrlKey || !event.deltaY) return;
    event.preventDefault();
    this.kept = null;
    this.moveTo(this.top + (event.deltaMode ? event.deltaY * 3 : event.deltaY / ROW));
  }

  /** @param {number} top */
  moveTo(top) {
    const { box } = this;
    this.top = Math.min(Math.max(top, 0), this.last);
    const most = Math.max(box.scrollHeight - box.clientHeight, 0);
    box.scrollTop = this.last ? (this.top / this.last) * most : 0;
    this.scrolled = box.scrollTop;
    this.draw();
  }

  /** Brings a place into view. @param {number} place */
  reveal(place) {
    this.kept = place;
    if (place < this.top || place > this.top + this.seen - 2) this.moveTo(place - Math.floor(this.seen / 3));
    else this.draw();
  }

  /** @param {number} block */
  async load(block) {
    const { generation } = this;
    this.blocks.set(block, null);
    const rows = await this.ask("rows", { from: block * BLOCK, count: BLOCK }).catch(() => null);
    if (generation !== this.generation || !this.blocks.has(block)) return;
    if (rows) this.blocks.set(block, rows);
    else this.blocks.delete(block);
    for (const old of this.blocks.keys()) {
      if (this.blocks.size <= BLOCKS) break;
      if (old !== block) this.blocks.delete(old);
    }
    if (rows) this.draw();
  }

  draw() {
    const first = Math.floor(this.top);
    const count = Math.min(this.seen + 1, Math.max(this.length - first, 0));
    while (this.rows.childElementCount < count) this.rows.append(emptyRow());
    while (this.rows.childElementCount > count) this.rows.lastElementChild.remove();
    const rest = this.top >= this.last ? 0 : this.top - first;
    this.rows.style.transform = `translateY(${-Math.round(rest * ROW)}px)`;
    for (let at = 0; at < count; at += 1) {
      const place = first + at;
      const block = Math.floor(place / BLOCK);
      if (!this.blocks.has(block)) this.load(block);
      this.fill(this.rows.children[at], this.blocks.get(block)?.[place % BLOCK]);
    }
  }

  /** @param {any} row @param {any} data */
  fill(row, data) {
    const [number, t, bus, raw, meaning] = row.children;
    if (!data) {
      row.className = "row";
      delete row.dataset.frame;
      for (const cell of row.children) cell.textContent = "";
      return;
    }
    const { frame, severity, line } = data;
    row.dataset.frame = frame;
    row.className = "row";
    row.classList.toggle("chosen", frame === this.chosen);
    row.classList.toggle("marked", this.marked.has(frame));
    row.setAttribute("aria-selected", String(frame === this.chosen));
    const split = line.indexOf("# ");
    number.textContent = frame;
    t.textContent = this.timeOf(data);
    bus.textContent = printable(data.bus);
    raw.textContent = printable(split < 0 ? line : line.slice(0, split).trimEnd());
    meaning.textContent = split < 0 ? "" : printable(line.slice(split + 2).replace(/\s*\n\s*(# )?/g, " · "));
    meaning.className = severity ? `severity-${severity}` : "";
  }

  /** @param {{t: number | null, delta: number | null}} data */
  timeOf({ t, delta }) {
    if (t === null) return "";
    if (this.time === "delta") return delta === null ? "" : seconds(delta);
    return this.time === "date" && this.begin ? dateOf(BigInt(this.begin) + BigInt(t)) : seconds(t);
  }
}

function emptyRow() {
  const names = ["number", "t", "bus", "raw", ""];
  return make("div", { className: "row", role: "row" }, ...names.map((className) => make("span", { className })));
}

/** A time of day where the stamps have a date, else seconds. @param {bigint} ns */
function dateOf(ns) {
  const whole = ns / 1000000000n;
  const part = String(ns % 1000000000n).padStart(9, "0").slice(0, 6);
  if (whole < 86400000n) return `${whole}.${part}`;
  return `${new Date(Number(whole) * 1000).toISOString().slice(11, 19)}.${part}`;
}
