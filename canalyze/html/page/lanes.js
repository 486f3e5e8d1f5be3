// Problems and states of nodes over time, on the common axis.

const LANE = 17;
/** Least and greatest width of the names, in pixels, and their greatest share of all. */
const NAMES = [60, 260];
const NAMES_SHARE = 0.38;
const HEAD_ROW = 18;
/** Colours of states by kind of lane and class, those of canalyze/timeline/charts.py. */
const COLOURS = /** @type {Record<string, Record<string, string>>} */ ({
  nmt: { initialising: "#3d85d6", "pre-operational": "#e0a526", operational: "#3fa34d", stopped: "#d6453d", lost: "#8e5bd0", unknown: "#8a8f98" },
  drive: {
    "not-ready-to-switch-on": "#5b6470", "switch-on-disabled": "#8a8f98", "ready-to-switch-on": "#e0a526",
    "switched-on": "#3d85d6", "operation-enabled": "#3fa34d", "quick-stop-active": "#e8772e",
    "fault-reaction-active": "#d6453d", fault: "#d6453d",
  },
  sdo: { ok: "#3d85d6", aborted: "#d6453d", failed: "#d6453d", incomplete: "#8a8f98" },
  emcy: { active: "#d6453d" },
  value: { 0: "#5b6470", 1: "#3fa34d" },
  problems: { open: "#d6453d", unknown: "#e8772e", ended: "#e0a526", harmless: "#8a8f98" },
});
const PLAIN = ["#4f7cac", "#3e8e8e", "#8d6e63", "#7a6fa8", "#9c8a4a", "#5f7a8a", "#a0698a"];

/** @typedef {{colour: string, text: string}} Look Without a colour nothing is drawn. */
/**
 * A row: when each state began, and its look by the number of the state.
 * @typedef {{name: string, id: number, cause: number, t: ArrayLike<number>, state: ArrayLike<number>,
 *   look: (state: number) => Look}} LaneRow
 */

/** @type {Look} */
const NO_LOOK = { colour: "", text: "" };

class LaneView {
  /** @param {any} box @param {Axis} axis @param {{time: (t: number) => void, problem: (id: number) => void}} act */
  constructor(box, axis, act) {
    this.canvas = box.querySelector("canvas");
    this.axis = axis;
    this.act = act;
    this.widest = 0;
    /** @type {LaneRow[]} */
    this.rows = [];
    this.left = NAMES[0];
    axis.views.push(() => this.draw());
    new ResizeObserver(() => axis.changed()).observe(box);
    handle(this.canvas, axis, () => this.left, (t, y) => this.click(t, y), (t, y) => this.point(t, y));
  }

  /**
   * @param {Diagnosis} diagnosis @param {{name: string, words: (string | null)[][], t: Float64Array, state: Uint16Array}[]} lanes
   * @param {number} others The number of lanes that are not kept.
   */
  show(diagnosis, lanes, others) {
    const { end } = this.axis;
    const problems = diagnosis.listed.filter(({ one }) => one.status !== "harmless").slice(0, 20).map(({ one }) => {
      const from = diagnosis.since(one.begin?.t ?? null);
      const to = one.end ? diagnosis.since(one.end.t) : end;
      const look = { colour: COLOURS.problems[one.status], text: printable(one.texts.title) };
      const t = from === null ? [] : [from, to ?? end];
      const looks = [look, NO_LOOK];
      return { name: say("html.problem", { number: one.id }), id: one.id, cause: one.cause?.id ?? 0, t, state: [0, 1], look: (/** @type {number} */ at) => looks[at] };
    });
    const buses = new Set(lanes.map(({ name }) => busOf(name)));
    const states = lanes.map(({ name, words, t, state }) => {
      const kind = name.slice(0, name.indexOf("/"));
      /** @type {Map<number, Look>} */
      const looks = new Map();
      const look = (/** @type {number} */ number) => {
        const [said, of] = words[number] ?? [null, null];
        const found = looks.get(number) ?? (said === null ? NO_LOOK : { colour: COLOURS[kind]?.[of ?? ""] ?? plainColour(said), text: printable(said) });
        looks.set(number, found);
        return found;
      };
      return { name: laneName(name, buses.size > 1), id: 0, cause: 0, t, state, look };
    });
    const more = { name: say("html.more_lanes", { count: others }), id: 0, cause: 0, t: [], state: [], look: () => NO_LOOK };
    this.rows = [...problems, ...states, ...(others ? [more] : [])];
    const { pen } = penOf(this.canvas, HEAD_ROW);
    this.widest = Math.max(...this.rows.map(({ name }) => pen.measureText(name).width), 0) + 14;
    this.axis.changed();
  }

  /** Shows the state below the pointer in words. @param {number} time @param {number} y */
  point(time, y) {
    const row = this.rows[Math.floor((y - HEAD_ROW) / LANE)];
    const at = row && time >= this.axis.from ? firstFrom(row.t, time + 1) - 1 : -1;
    const text = row && at >= 0 ? row.look(row.state[at]).text : "";
    this.canvas.title = text ? `${row.name}: ${text}` : (row?.name ?? say("html.lanes"));
  }

  /** @param {number} t @param {number} y */
  click(t, y) {
    const row = this.rows[Math.floor((y - HEAD_ROW) / LANE)];
    if (row?.id) this.act.problem(row.id);
    else this.act.time(t);
  }

  draw() {
    const { axis, rows } = this;
    if (!this.canvas.clientWidth) return;
    const { pen, width } = penOf(this.canvas, HEAD_ROW + rows.length * LANE + 2);
    const left = Math.min(Math.max(this.widest, NAMES[0]), NAMES[1], width * NAMES_SHARE);
    this.left = left;
    const room = Math.max(width - left, 1);
    const x = (/** @type {number} */ t) => left + ((t - axis.from) / (axis.to - axis.from)) * room;
    const [text, quiet, line] = [colour("--text"), colour("--quiet"), colour("--line")];
    for (const { t, text: said } of axis.ticks(Math.max(Math.floor(room / 110), 2))) {
      pen.fillStyle = line;
      pen.fillRect(Math.round(x(t)), 0, 1, HEAD_ROW + rows.length * LANE);
      pen.fillStyle = quiet;
      pen.fillText(said, x(t) + 3, HEAD_ROW / 2);
    }
    const timeAt = (/** @type {number} */ place) => axis.from + ((place - left) / room) * (axis.to - axis.from);
    rows.forEach(({ name, t, state, look }, number) => {
      const y = HEAD_ROW + number * LANE;
      pen.fillStyle = text;
      pen.fillText(fitted(pen, name, left - 10), 6, y + LANE / 2);
      pen.save();
      pen.beginPath();
      pen.rect(left, y, room, LANE);
      pen.clip();
      for (let at = Math.max(firstFrom(t, axis.from) - 1, 0); at < t.length && t[at] <= axis.to; ) {
        const from = x(t[at]);
        const to = Math.min(x(at + 1 < t.length ? t[at + 1] : axis.end), width);
        const { colour: filled, text: said } = look(state[at]);
        if (filled && to >= left) bar(pen, { from, to, left, y, filled, said });
        // Of states that share a pixel the last is drawn, too.
        at = to - from < 1 ? Math.max(at + 1, firstFrom(t, timeAt(from + 1)) - 1) : at + 1;
      }
      pen.restore();
    });
    this.arrows(pen, x, text);
    if (axis.cursor !== null) {
      pen.fillStyle = colour("--link");
      pen.fillRect(x(axis.cursor) - 0.75, 0, 1.5, HEAD_ROW + rows.length * LANE);
    }
  }

  /** Draws an arrow from each cause to what comes from it. @param {any} pen @param {(t: number) => number} x @param {string} text */
  arrows(pen, x, text) {
    const middle = (/** @type {number} */ row) => HEAD_ROW + row * LANE + LANE / 2;
    pen.strokeStyle = text;
    pen.fillStyle = text;
    this.rows.forEach(({ cause, t }, row) => {
      const from = cause ? this.rows.findIndex(({ id }) => id === cause) : -1;
      if (from < 0 || !t.length || !this.rows[from].t.length) return;
      const [x1, x2] = [x(this.rows[from].t[0]), x(t[0])];
      if (Math.min(x1, x2) < this.left - 8) return;
      const [y1, y2] = [middle(from) + LANE / 2 - 2, middle(row)];
      pen.beginPath();
      pen.moveTo(x1 + 1, y1);
      pen.bezierCurveTo(x1 + 1, y2, x2 - 14, y2, x2 - 3, y2);
      pen.stroke();
      pen.beginPath();
      pen.moveTo(x2, y2);
      pen.lineTo(x2 - 6, y2 - 3.5);
      pen.lineTo(x2 - 6, y2 + 3.5);
      pen.fill();
    });
  }
}

/** Draws a state. @param {any} pen @param {{from: number, to: number, left: number, y: number, filled: string, said: string}} state */
function bar(pen, { from, to, left, y, filled, said }) {
  pen.fillStyle = filled;
  pen.fillRect(from, y + 2, Math.max(to - from - 0.5, 2), LANE - 4);
  const start = Math.max(from, left) + 4;
  if (to - start <= 30) return;
  pen.save();
  pen.beginPath();
  pen.rect(start, y, to - start, LANE);
  pen.clip();
  pen.fillStyle = "#fff";
  pen.fillText(said, start, y + LANE / 2);
  pen.restore();
}

/** @param {string} name @returns {string} The bus of a lane; empty if it has none. */
function busOf(name) {
  const [, bus, node] = name.split("/");
  return /^node\d+$/.test(node ?? "") ? bus : "";
}

/** @param {string} name @param {boolean} withBus @returns {string} */
function laneName(name, withBus) {
  const [kind, ...rest] = name.split("/");
  const parts = withBus || !busOf(name) ? rest : rest.slice(1);
  const said = parts.map((part) => part.replace(/^node(\d+)$/, (_, node) => say("html.node", { node })));
  return printable([...(kind === "value" ? [] : [word("html_lane", kind)]), ...said].join(" "));
}

/** Returns a text cut to a width, without its middle: names differ at their ends. @param {any} pen @param {string} text @param {number} width @returns {string} */
function fitted(pen, text, width) {
  if (pen.measureText(text).width <= width) return text;
  const cut = (/** @type {number} */ length) => `${text.slice(0, Math.floor(length / 3))}…${text.slice(text.length - Math.ceil((2 * length) / 3))}`;
  let length = text.length;
  while (length > 1 && pen.measureText(cut(length)).width > width) length -= 1;
  return cut(length);
}

/** @param {string} state */
function plainColour(state) {
  let sum = 0;
  for (const one of state) sum = (sum * 31 + (one.codePointAt(0) ?? 0)) % 9973;
  return PLAIN[sum % PLAIN.length];
}
