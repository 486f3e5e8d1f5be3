// The problems of a capture: the verdict, each with its cause, its steps, what to check, and one click to each frame.

/** @typedef {Record<string, any>} Problem */

const STATES = ["open", "unknown", "ended", "harmless"];
/** Problems whose details are made at once. */
const FILLED_AT_ONCE = 4;
/** Frames of a problem that are listed with those around them. */
const MOST_STEPS = 16;

class Diagnosis {
  /** @param {Problem[]} problems @param {Record<string, any>} whole */
  constructor(problems, whole) {
    this.whole = whole;
    this.problems = problems;
    this.byId = new Map(problems.map((one) => [one.id, one]));
    /** @type {Problem[]} The problems that no other has caused, most important first. */
    this.roots = (whole.order ?? []).map((/** @type {number} */ id) => this.byId.get(id)).filter(Boolean);
  }

  /** @returns {string} The status of the worst problem; `unjudged` where that there is none says nothing. */
  get worst() {
    return this.whole.verdict.status;
  }

  /** @returns {string} */
  get verdict() {
    return this.whole.verdict.text;
  }

  /** Lines about what was looked at and what belongs to no problem. @returns {string[]} */
  get beside() {
    const { notice, looked, well, loose_text: loose } = this.whole;
    const healthy = this.roots.some((one) => one.status !== "harmless") || notice ? [] : [looked, well];
    return [...healthy, loose].filter(Boolean);
  }

  /**
   * Returns a problem and all that comes from it, each with the number of causes between.
   * @param {Problem} root @param {number} [depth] @returns {{depth: number, one: Problem}[]}
   */
  tree(root, depth = 0) {
    const below = root.effects.map((/** @type {number} */ id) => this.byId.get(id)).filter((/** @type {any} */ one) => one && !one.root);
    return [{ depth, one: root }, ...below.flatMap((/** @type {Problem} */ one) => this.tree(one, depth + 1))];
  }

  /** Problems in the order in which they are listed. */
  get listed() {
    return STATES.flatMap((status) => this.roots.filter((one) => one.status === status)).flatMap((root) => this.tree(root));
  }

  /** Nanoseconds since the first frame. @param {string | null} t */
  since(t) {
    return t === null || this.whole.begin === null ? null : Number(nanoseconds(t) - nanoseconds(this.whole.begin));
  }
}

/** A time in text in nanoseconds. @param {string} t */
function nanoseconds(t) {
  const [whole, part = ""] = t.split(".");
  const sign = whole.startsWith("-") ? -1n : 1n;
  return BigInt(whole) * 1000000000n + sign * BigInt(part.padEnd(9, "0").slice(0, 9));
}

/** @param {Problem} one @returns {number[]} The frames of a problem. */
function framesOf(one) {
  const { begin, end, steps, findings } = one;
  const found = [begin?.frame, end?.frame, ...steps.map((/** @type {any} */ step) => step.frame)];
  for (const finding of findings) found.push(finding.about_frame ?? finding.frame);
  return [...new Set(found.filter((frame) => typeof frame === "number"))];
}

class ProblemList {
  /**
   * @param {any} box
   * @param {{frame: (frame: number) => void, chosen: (one: Problem) => void, filter: (expression: string) => void,
   *   plot: (one: Problem) => void, lines: (frames: number[]) => Promise<{frame: number, line: string}[]>}} act
   */
  constructor(box, act) {
    this.box = box;
    this.act = act;
    /** @type {Map<number, any>} */
    this.shown = new Map();
    /** @type {Map<number, () => void>} Those whose details are not made yet. */
    this.unfilled = new Map();
    this.chosen = 0;
  }

  /** Opens on a problem, without one on the most important. @param {number} id */
  begin(id) {
    const [first] = this.diagnosis?.listed.filter(({ one }) => one.status !== "harmless") ?? [];
    const one = this.diagnosis?.byId.get(id) ?? first?.one;
    if (one?.begin?.frame) this.open(one, one.begin.frame);
  }

  /** @param {Diagnosis} diagnosis */
  show(diagnosis) {
    this.diagnosis = diagnosis;
    this.shown.clear();
    this.unfilled.clear();
    this.box.replaceChildren();
    let status = "";
    for (const { depth, one } of diagnosis.listed) {
      if (!depth && one.status !== status) {
        status = one.status;
        this.box.append(make("h2", { className: status }, word("problem_heading", status)));
      }
      const shown = this.problem(one, depth);
      this.shown.set(one.id, shown);
      this.box.append(shown);
    }
    for (const line of diagnosis.beside) this.box.append(make("p", { className: "quiet" }, line));
    this.fillSome(diagnosis);
  }

  /** Makes the details of problems, a few at a time. @param {Diagnosis} diagnosis */
  fillSome(diagnosis) {
    if (diagnosis !== this.diagnosis) return;
    for (const id of [...this.unfilled.keys()].slice(0, FILLED_AT_ONCE)) this.fill(id);
    if (this.unfilled.size) setTimeout(() => this.fillSome(diagnosis), 10);
  }

  /** Makes the details of a problem, if they are not there. @param {number} id */
  fill(id) {
    const made = this.unfilled.get(id);
    this.unfilled.delete(id);
    made?.();
  }

  fillAll() {
    for (const id of [...this.unfilled.keys()]) this.fill(id);
  }

  /** @param {Problem} one @param {number} depth */
  problem(one, depth) {
    const shown = make("details", { className: "problem", id: `problem-${one.id}` });
    shown.style.marginLeft = `${Math.min(depth, 5) * 16}px`;
    const head = make(
      "summary",
      {},
      make("b", { className: one.status }, `${depth ? "→ " : ""}${one.id}`),
      make("span", { className: "words" }, printable(one.texts.title)),
      frameButton(one.begin?.frame ?? null, (frame) => this.open(one, frame)),
    );
    head.addEventListener("click", (/** @type {any} */ event) => {
      if (event.target.closest("button")) event.preventDefault();
      else this.choose(one.id);
    });
    shown.append(head);
    shown.addEventListener("toggle", () => this.fill(one.id));
    this.unfilled.set(one.id, () => shown.append(...this.body(one)));
    return shown;
  }

  /** @param {Problem} one @param {number} frame */
  open(one, frame) {
    this.fill(one.id);
    this.shown.get(one.id).open = true;
    this.choose(one.id);
    this.act.frame(frame);
  }

  /** @param {Problem} one @returns {any[]} */
  body(one) {
    const { diagnosis } = this;
    if (!diagnosis) return [];
    const grade = word("problem_grade", one.grade);
    const said = [
      make("p", { className: "quiet" }, [word("problem_status", one.status), word("problem_impact", one.impact), grade].join(" · ")),
    ];
    const { because, why, delay, repeats } = one.texts;
    if (repeats) said.push(make("p", { className: "quiet" }, repeats));
    if (because) {
      const choose = () => this.choose(one.cause.id);
      said.push(
        make("p", {}, make("button", { type: "button", className: "frame", onclick: choose }, printable(because))),
        make("p", { className: "quiet" }, [why, delay].filter(Boolean).join("; ")),
      );
    }
    if (one.checks_left.length) {
      said.push(make("p", { className: "quiet" }, say("diagnose.html_check")), bullets(one.checks_left.map(printable)));
    }
    if (one.apart.length) {
      const lines = one.apart.map((/** @type {any} */ tell) => `${tell.told ? "+" : "?"} ${printable(tell.text)}`);
      said.push(make("p", { className: "quiet" }, say("diagnose.html_apart")), bullets(lines));
    }
    const steps = one.steps.length ? one.steps : [{ ...one.begin, role: "sign", text: one.texts.title }];
    const table = make("table", { className: "steps" });
    for (const step of steps.slice(0, 40)) {
      const t = diagnosis.since(step.t);
      table.append(
        make(
          "tr",
          {},
          make("td", {}, t === null ? "" : `${(t / 1e9).toFixed(3)} s`),
          make("td", {}, step.frame ? frameButton(step.frame, (frame) => this.open(one, frame)) : ""),
          make("td", {}, word("problem_role", step.role)),
          make("td", {}, printable(step.text)),
        ),
      );
    }
    said.push(table);
    const codes = new Map();
    for (const { code, about_frame: about, frame } of one.findings) codes.set(code, [...(codes.get(code) ?? []), about ?? frame]);
    if (codes.size) {
      const line = make("p", { className: "quiet" });
      for (const [code, frames] of codes) {
        line.append(`${code} `);
        for (const frame of frames.slice(0, 8)) line.append(frameButton(frame, (number) => this.open(one, number)), " ");
      }
      said.push(line);
    }
    const nodes = [one.subject.node, ...(one.subject.nodes ?? [])].filter((node) => node !== undefined && node !== null);
    const actions = make("div", { className: "actions" });
    const action = (/** @type {string} */ text, /** @type {() => void} */ act) =>
      actions.append(make("button", { type: "button", onclick: act }, text));
    const frames = framesOf(one);
    if (frames.length) action(say("html.only_problem"), () => this.act.filter(`frame=${around(frames)}`));
    for (const node of [...new Set(nodes)].slice(0, 4)) {
      action(say("html.only_node", { node }), () => this.act.filter(`node=${node}`));
    }
    if (nodes.length) action(say("html.plot"), () => this.act.plot(one));
    const near = make("details", { className: "near" }, make("summary", {}, say("html.near")), make("div"));
    said.push(actions, near);
    this.list(near.lastElementChild, frames);
    return said;
  }

  /** Lists frames with those around them; printed with the problem. @param {any} box @param {number[]} frames */
  async list(box, frames) {
    const wanted = frames.slice(0, MOST_STEPS).flatMap((frame) => [-2, -1, 0, 1, 2].map((by) => frame + by));
    const lines = await this.act.lines(wanted);
    const own = new Set(frames);
    let before = 0;
    for (const { frame, line } of lines) {
      if (before && frame > before + 1) box.append(make("p", {}, "…"));
      before = frame;
      const button = frameButton(frame, this.act.frame);
      box.append(make("p", { className: own.has(frame) ? "own" : "" }, button, ` ${printable(line)}`));
    }
  }

  /** @param {number} id */
  choose(id) {
    const one = this.diagnosis?.byId.get(id);
    if (!one) return;
    this.shown.get(this.chosen)?.classList.remove("chosen");
    this.chosen = id;
    const shown = this.shown.get(id);
    shown.classList.add("chosen");
    shown.scrollIntoView({ block: "nearest" });
    this.act.chosen(one);
  }

  /** Chooses the next problem, or an earlier one. @param {number} by */
  move(by) {
    const listed = this.diagnosis?.listed ?? [];
    if (!listed.length) return;
    const at = listed.findIndex(({ one }) => one.id === this.chosen);
    const { one } = listed[at < 0 ? 0 : Math.min(Math.max(at + by, 0), listed.length - 1)];
    if (one.begin?.frame) this.open(one, one.begin.frame);
    else this.choose(one.id);
  }
}

/** Ranges of frames for a filter: each with two before and behind. @param {number[]} frames */
function around(frames) {
  return frames.slice(0, 200).map((frame) => `${Math.max(frame - 2, 1)}-${frame + 2}`).join(",");
}

/** @param {string[]} lines */
function bullets(lines) {
  return make("ul", {}, ...lines.map((line) => make("li", {}, line)));
}
