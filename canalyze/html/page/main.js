// The page: what is opened, what is chosen, keys. Each part of it is in a file of its own.

/** @type {{lang: string, merge: boolean, options: Record<string, any>, effects: Record<string, string>}} */
const SETTINGS = embedded("settings");
/** Time before and behind the begin of a problem whose signals are drawn. */
const AROUND_NS = 2e9;
const PANELS = ["problems", "nodes", "transfers", "objects", "findings", "plots"];
/** Forms that a capture can be saved in: their name, the end of the file's name, the options of the session. */
const SAVED = /** @type {[string, string, object][]} */ ([
  ["candump", ".log", { format: "convert", to: "candump" }],
  ["asc", ".asc", { format: "convert", to: "asc" }],
  ["pcapng", ".pcapng", { format: "convert", to: "pcapng" }],
  ["mcap", ".mcap", { format: "convert", to: "mcap" }],
  ["text", ".txt", { format: "text" }],
  ["jsonl", ".jsonl", { format: "jsonl" }],
  ["sdo", ".sdo.csv", { format: "transfers-csv" }],
  ["objects", ".od.csv", { format: "objects-csv" }],
  ["history", ".history.csv", { format: "history-csv" }],
  ["signals", ".signals.csv", { format: "signals-csv" }],
]);
/** Formats that only the command line reads, with a sentence and a command that makes them readable. */
const OTHERS = /** @type {Record<string, [string, string]>} */ ({
  xz: ["html.packed", "xz -dk FILE"],
  bzip2: ["html.packed", "bzip2 -dk FILE"],
  mf4: ["html.convert", "canalyze convert FILE capture.log"],
  csv: ["html.convert", "canalyze convert FILE capture.log"],
  sqlite: ["html.convert", "canalyze convert FILE capture.log"],
});

const page = {
  /** @type {any} The answer of the worker for the capture that is open. */
  opened: null,
  /** The latest call that opens a capture, and the latest one that filters. */
  opening: {},
  filtering: {},
  /** True while a frame is chosen that the user has not asked for. */
  still: false,
  /** @type {Source[]} */
  sources: [],
  panel: "problems",
  expression: "",
  /** The language of the list of captures; empty while there is none, and once descriptions have changed. */
  indexed: "",
  /** @type {Set<string>} Panels that show what is open. */
  filled: new Set(),
};

const link = new Link((share, count) => {
  const box = element("progress");
  box.hidden = false;
  box.querySelector("progress").value = share;
  box.querySelector("span").textContent = say("html.frames", { count });
  if (!page.opened && count) {
    element("main").hidden = false;
    element("drop").hidden = true;
    list.grow(count);
  }
}, () => (element("progress").hidden = true));
const ask = (/** @type {string} */ kind, /** @type {object} */ given) => link.ask(kind, given);
const descriptions = new Descriptions(element("descriptions"), link, SETTINGS.effects, () => {
  page.indexed = "";
  again();
});
const axis = new Axis();
const list = new FrameList(element("frames"), ask, (frame) => goTo(frame));
const lanes = new LaneView(element("lanes"), axis, { time: goToTime, problem: (id) => problems.choose(id) });
const problems = new ProblemList(element("problems"), {
  frame: (frame) => goTo(frame),
  chosen: (one) => mark(one),
  filter: (expression) => filter(expression),
  lines: (frames) => ask("lines", { frames }),
  plot: (one) => {
    const [node] = [one.subject.node, ...(one.subject.nodes ?? [])].filter((/** @type {any} */ node) => node || node === 0);
    show("plots");
    const begin = problems.diagnosis?.since(one.begin?.t ?? null) ?? null;
    if (begin !== null) axis.show(begin - AROUND_NS, begin + AROUND_NS);
    fill("plots", () => plots.open([one.subject.bus, node, ""].filter((part) => part !== undefined && part !== null).join(" "), true));
  },
});
const plots = new PlotPanel(element("plots"), axis, ask, goToTime);

/** Runs what may fail; an error is shown in words. @param {() => Promise<any>} act */
async function attempt(act) {
  try {
    return await act();
  } catch (error) {
    await complain(error);
    return undefined;
  }
}

/** @param {any} error */
async function complain(error) {
  if (!(error instanceof RequestError)) {
    notice(String(error));
    throw error;
  }
  if (error.kind === "Superseded") return;
  if (error.kind === "Refused") notice(error.message);
  else if (error.kind === "Unreadable") notice(unreadable(error));
  else if (error.kind === "NotReadable") notice(say("html.not_read", { problem: error.message }));
  else {
    notice(say("html.trap", { problem: error.message }));
    link.restart();
    page.opened = null;
  }
}

/** Says what to do with a file that only the command line reads. @param {RequestError} error */
function unreadable({ message: format, file }) {
  const [key, command] = OTHERS[format] ?? ["html.unreadable", ""];
  const quoted = /^[\w.-]+$/.test(file) ? file : `'${file.replaceAll("'", "'\\''")}'`;
  return printable(say(key, { name: file, format: word("html_format", format), command: command.replace("FILE", quoted) }));
}

/** @param {string} text */
function notice(text) {
  element("notice").textContent = text;
}

/** @param {Source} source */
function given(source) {
  const network = descriptions.network(SETTINGS.options.network);
  return described(source, { ...SETTINGS.options, network, lang: language.now }, SETTINGS.merge);
}

/** @param {Source} source */
async function open(source) {
  const mine = {};
  page.opening = mine;
  link.restart();
  link.source = source;
  page.opened = null;
  page.filled.clear();
  notice("");
  for (const id of ["verdict", "extent"]) element(id).textContent = "";
  element("detail").replaceChildren();
  for (const name of PANELS) element(name).replaceChildren();
  plots.clear();
  element("index").hidden = true;
  element("back").hidden = page.sources.length < 2;
  list.reset(0);
  element("name").textContent = printable(source.name);
  document.title = `canalyze: ${printable(source.name)}`;
  await attempt(async () => {
    const opened = await ask("open", given(source));
    page.opened = opened;
    await showOpened();
  });
  if (page.opening !== mine) return;
  if (!page.opened) for (const id of ["main", "lanes"]) element(id).hidden = true;
  element("drop").hidden = Boolean(page.opened);
  document.body.dataset.state = page.opened ? "opened" : "failed";
}

/** Shows what was read, in steps between which the page answers. */
async function showOpened() {
  const { opened } = page;
  const diagnosis = new Diagnosis(opened.problems, opened.whole);
  for (const id of ["main", "lanes"]) element(id).hidden = false;
  element("drop").hidden = true;
  element("verdict").textContent = diagnosis.verdict;
  element("verdict").className = diagnosis.worst;
  element("extent").textContent = [opened.whole.extent, opened.format].join(" · ");
  const damaged = opened.damaged ? [say("html.damaged")] : [];
  if (opened.count < opened.whole.frames) damaged.push(say("html.part", { count: opened.count, all: opened.whole.frames }));
  notice([opened.whole.notice, ...damaged, ...opened.complaints.map(printable)].filter(Boolean).join("\n"));
  list.begin = opened.begin;
  list.reset(opened.count);
  const { begin, end } = opened.whole;
  axis.reset(0, begin === null || end === null ? 1 : Number(nanoseconds(end) - nanoseconds(begin)));
  element("save").disabled = false;
  showTabs();
  element("present").replaceChildren(...(opened.whole.nodes ?? []).map((/** @type {any} */ { node }) => make("option", { value: String(node) })));
  await pause();
  if (page.opened !== opened) return;
  problems.show(diagnosis);
  await pause();
  if (page.opened !== opened) return;
  lanes.show(diagnosis, opened.lanes, opened.lanes_left_out);
  element("lanes").hidden = !lanes.rows.length;
  show("problems");
  element("filter").querySelector("output").textContent = say("html.frames", { count: opened.count });
  page.still = true; // a narrow screen begins with the problems
  problems.begin(link.source?.problem ?? 0);
  page.still = false;
}

/** @returns {Promise<void>} Fulfilled when the page has drawn and answered what waits. */
function pause() {
  return new Promise((done) => setTimeout(done));
}

function showTabs() {
  const counts = /** @type {Record<string, number | string>} */ ({
    problems: page.opened?.problems.length ?? 0,
    nodes: page.opened?.whole.nodes?.length ?? 0,
    transfers: page.opened?.counts.transfers ?? 0,
    findings: page.opened?.counts.findings ?? 0,
  });
  element("tabs").replaceChildren(
    ...PANELS.map((name) => {
      const count = name in counts ? ` ${counts[name]}` : "";
      const tab = make("button", { type: "button", role: "tab", onclick: () => show(name) }, word("html_tab", name) + count);
      tab.dataset.panel = name;
      tab.setAttribute("aria-controls", name);
      tab.setAttribute("aria-selected", String(name === page.panel));
      return tab;
    }),
  );
}

/** @param {string} name */
function show(name) {
  page.panel = name;
  for (const one of PANELS) element(one).hidden = one !== name;
  for (const tab of element("tabs").children) tab.setAttribute("aria-selected", String(tab.dataset.panel === name));
  if (page.opened) fill(name, FILLED[name]);
}

/** Fills a panel once. @param {string} name @param {(() => any) | undefined} act */
function fill(name, act) {
  if (!act || (page.filled.has(name) && name !== "plots")) return;
  if (page.filled.has(name) && act === FILLED[name]) return;
  page.filled.add(name);
  attempt(async () => {
    await act();
    return true;
  }).then((done) => {
    if (!done) page.filled.delete(name);
  });
}

const FILLED = /** @type {Record<string, () => any>} */ ({
  nodes: () => {
    const box = element("nodes");
    const table = make("table");
    for (const { node, cells, problem } of page.opened.whole.nodes) {
      const [name, ...further] = cells.map(printable);
      const said = further.pop();
      const see = () => (show("problems"), problems.choose(problem));
      table.append(
        make(
          "tr",
          {},
          make("td", {}, make("button", { type: "button", className: "frame", onclick: () => filter(`node=${node}`) }, name)),
          ...further.map((/** @type {string} */ cell) => make("td", {}, cell)),
          make("td", {}, problem === null ? said : make("button", { type: "button", className: "frame", onclick: see }, said)),
        ),
      );
    }
    box.replaceChildren(table);
  },
  transfers: () => new TablePanel(element("transfers"), "transfers", ask, { go: goTo, saves: [["CSV", () => save("sdo")]] }),
  findings: () => new TablePanel(element("findings"), "findings", ask, { go: goTo }),
  objects: async () => {
    element("objects").replaceChildren(make("p", {}, say("html.reading")));
    await ask("table", { table: "od" });
    const { carriers } = descriptions.settled();
    const described = carriers.filter(([, , place]) => ["eds", "dcf"].includes(descriptions.all[place].about.form));
    const dcfs = described.map(([, node, place]) => /** @type {[string, () => void]} */ ([
      `DCF ${say("html.node", { node })}`, () => saveDcf(node, place),
    ]));
    new TablePanel(element("objects"), "od", ask, { go: goTo, saves: [["CSV", () => save("objects")], ...dcfs] });
  },
  plots: () => plots.open(),
});

/** Marks the frames of a problem. @param {Problem} one */
function mark(one) {
  list.marked = new Set(framesOf(one));
  list.draw();
}

/** Chooses a frame: the list, the axis and the explanation follow. @param {number} frame */
async function goTo(frame) {
  list.chosen = frame;
  if (!page.still && matchMedia("(max-width: 760px)").matches) element("right").scrollIntoView();
  explain(frame);
  list.reveal(await ask("place", { frame }));
}

/** @param {number} t */
async function goToTime(t) {
  goTo(await ask("frameAt", { t }));
}

/** Shows a frame in the detail: its line at once, its explanation when it comes. @param {number} frame */
async function explain(frame) {
  if (!page.opened) return;
  const row = (await ask("row", { frame })) ?? { t: null, bus: "", node: null, line: "" };
  if (row.t !== null) axis.point(row.t);
  const actions = make("div", { className: "actions" });
  const action = (/** @type {string} */ said, /** @type {() => void} */ act) =>
    actions.append(make("button", { type: "button", onclick: act }, said));
  actions.append(make("b", {}, `#${frame}`));
  const transfer = await ask("transfer", { frame, bus: row.bus });
  if (transfer) {
    const { first_frame: first, last_frame: last, node, object, name, text, status, abort_text: reason } = transfer;
    action(say("html.only_transfer"), () => filter(`service=sdo node=${node} frame=${first}-${last}`));
    for (const one of [first, last]) if (one !== frame) actions.append(frameButton(one, goTo));
    const said = [object, name, text, status, reason].filter((part) => part !== null && part !== "").map((part) => printable(String(part)));
    actions.append(make("span", { className: "quiet" }, said.join(" ")));
  }
  if (row.node !== null) action(say("html.only_node", { node: row.node }), () => filter(`node=${row.node}`));
  for (const one of page.opened.problems) {
    if (!framesOf(one).includes(frame)) continue;
    action(say("html.problem", { number: one.id }), () => (show("problems"), problems.choose(one.id)));
  }
  if (list.chosen !== frame) return;
  const words = make("pre", {}, printable(row.line));
  element("detail").replaceChildren(actions, words);
  await attempt(async () => {
    const text = await ask("explain", { frame });
    if (list.chosen === frame) words.textContent = text.trimEnd().split("\n").map(printable).join("\n");
  });
}

/** @param {string} expression */
async function filter(expression) {
  const box = element("filter");
  const [input, output] = [box.querySelector("input"), box.querySelector("output")];
  input.value = expression;
  const number = /^#?(\d+)$/.exec(expression);
  if (number && Number(number[1]) <= (page.opened?.count ?? 0) && expression.startsWith("#")) {
    goTo(Number(number[1]));
    return;
  }
  const mine = {};
  page.filtering = mine;
  output.className = "";
  output.textContent = say("html.reading");
  try {
    const count = await ask("filter", { expression });
    page.expression = expression;
    showFiltered();
    list.reset(count);
    output.textContent = say("html.frames", { count });
    remember(expression);
    if (list.chosen) list.reveal(await ask("place", { frame: list.chosen }));
  } catch (error) {
    if (error instanceof RequestError && error.kind === "Refused") {
      output.className = "wrong";
      output.textContent = error.message;
    } else await complain(error);
    if (page.filtering !== mine || !(error instanceof RequestError) || error.kind !== "Superseded") return;
    input.value = page.expression; // given up: what is shown stays
    output.textContent = say("html.frames", { count: list.length });
  }
}

/** @param {string} expression */
function remember(expression) {
  const history = element("history");
  if (!expression || [...history.children].some((one) => one.value === expression)) return;
  history.prepend(make("option", { value: expression }));
  while (history.childElementCount > 20) history.lastElementChild.remove();
}

/** Says how much is saved (a text that is searched for is no filter of a session) and leads back to all frames. */
function showFiltered() {
  const { expression } = page;
  const key = !expression ? "html.save" : expression.includes("=") ? "html.save_filtered" : "html.save_all";
  element("save").firstElementChild.textContent = say(key);
  element("all").hidden = !expression;
}

/** @param {string} name */
function save(name) {
  const [, end, options] = SAVED.find((one) => one[0] === name) ?? SAVED[0];
  const expression = page.expression.includes("=") ? { filter: page.expression } : {};
  attempt(async () => {
    const bytes = await ask("save", { options: { ...options, ...expression } });
    download(bytes, `${link.source?.name ?? "capture"}${end}`);
  });
}

/** Saves the configuration of a node. @param {number} node @param {number} number Of its description. */
function saveDcf(node, number) {
  attempt(async () => {
    const name = `node${node}.dcf`;
    const keys = [["FileName", name], ["LastEDS", descriptions.all[number].name]];
    const { error, text, count, left_out: missing } = await ask("dcf", { number, node, keys });
    if (error) {
      notice(say(error[0], error[1]));
      return;
    }
    download(text, name);
    const said = [say("od.written", { name, node, count: count - missing.length })];
    const objects = missing.map((/** @type {number[]} */ [index, sub]) => `${hex(index, 4)}h:${hex(sub, 2)}`).join(", ");
    if (objects) said.push(say("od.left_out", { name, objects }));
    notice(said.join("\n"));
  });
}

/** @param {number} value @param {number} digits */
function hex(value, digits) {
  return value.toString(16).toUpperCase().padStart(digits, "0");
}

/** @param {any} content @param {string} name */
function download(content, name) {
  const address = URL.createObjectURL(new Blob([content], { type: "application/octet-stream" }));
  make("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60000);
}

/** @param {Source[]} sources */
async function openAll(sources) {
  page.expression = "";
  element("filter").querySelector("input").value = "";
  showFiltered();
  page.sources = sources.length > 1 ? await grouped(sources) : sources;
  if (page.sources.length === 1) await open(page.sources[0]);
  else if (page.sources.length) await showIndex();
}

/** Joins files that follow one another. @param {Source[]} sources */
async function grouped(sources) {
  if (SETTINGS.merge) return [joinedSource(sources)];
  link.restart();
  /** @type {Span[]} */
  const spans = [];
  for (const source of sources) {
    link.source = source;
    const span = source.parts.length > 1 ? null : await ask("span", given(source)).catch(() => null);
    const time = (/** @type {string | null | undefined} */ t) => (t ? nanoseconds(t) : null);
    spans.push({ source, begin: time(span?.first), end: time(span?.last), buses: span?.buses ?? [] });
  }
  link.source = null;
  return recordingsOf(spans);
}

/** Shows the list of captures as it was last made, or makes it. */
function back() {
  if (page.indexed !== language.now) return showIndex();
  bareIndex();
  return undefined;
}

/** Shows the list of captures, and nothing of a capture. */
function bareIndex() {
  for (const id of ["main", "lanes", "drop", "back"]) element(id).hidden = true;
  for (const id of ["verdict", "extent", "name", "notice"]) element(id).textContent = "";
  element("index").hidden = false;
  element("save").disabled = true;
  document.title = "canalyze";
  page.opened = null;
  page.opening = {};
  link.restart();
  link.source = null;
  document.body.dataset.state = "index";
}

/** Diagnoses each of several captures and lists them, the worst first. */
async function showIndex() {
  const box = element("index");
  bareIndex();
  document.body.dataset.state = "";
  page.indexed = "";
  box.replaceChildren();
  /** @type {{source: Source, diagnosis: Diagnosis | null, problem: string}[]} */
  const found = [];
  const rank = (/** @type {Diagnosis | null} */ one) => (one ? [...STATES.slice(0, 2), "unjudged", "ended"].indexOf(one.worst) : 9);
  for (const source of page.sources) {
    link.source = source;
    try {
      const { problems: all, whole } = await ask("diagnose", given(source));
      found.push({ source, diagnosis: new Diagnosis(all, whole), problem: "" });
    } catch (error) {
      const kind = error instanceof RequestError ? error.kind : "";
      if (kind === "Superseded") return;
      found.push({ source, diagnosis: null, problem: kind === "Unreadable" ? unreadable(/** @type {any} */ (error)) : String(error) });
      if (kind === "trap") link.restart();
    }
    const count = (/** @type {Diagnosis | null} */ one) => one?.roots.filter(({ status }) => status !== "harmless").length ?? 0;
    found.sort((one, other) => rank(one.diagnosis) - rank(other.diagnosis) || count(other.diagnosis) - count(one.diagnosis));
    box.replaceChildren(make("table", {}, ...found.map((one) => indexRow(one))));
  }
  link.source = null;
  page.indexed = language.now;
  document.body.dataset.state = "index";
}

/** @param {{source: Source, diagnosis: Diagnosis | null, problem: string}} one */
function indexRow({ source, diagnosis, problem }) {
  const first = diagnosis?.roots.find(({ status }) => status !== "harmless");
  return make(
    "tr",
    { className: "pick" },
    make("td", { className: diagnosis?.worst ?? "unjudged" }, diagnosis?.verdict ?? "-"),
    make("td", {}, make("button", { type: "button", className: "frame", onclick: () => open(source) }, printable(source.name))),
    make("td", {}, first ? printable(first.texts.title) : printable(problem)),
  );
}

/** @param {string} lang */
async function speak(lang) {
  language.now = lang;
  sayAll();
  const forms = SAVED.map(([name]) => make("option", { value: name }, word("html_save", name)));
  element("save").replaceChildren(make("option", { value: "" }), ...forms);
  showFiltered();
  element("time").textContent = word("html_time", list.time);
  descriptions.draw();
  await again();
}

/** Reads again what is open, in another language or with other descriptions. */
async function again() {
  if (!element("index").hidden) await showIndex();
  else if (link.source) {
    const { chosen } = list;
    const { panel } = page;
    await open(link.source);
    if (!page.opened) return;
    show(panel);
    if (page.expression) await filter(page.expression);
    page.still = true;
    if (chosen) goTo(chosen);
    page.still = false;
  }
}

/** Takes files that were dropped or chosen: captures are opened, with the descriptions among them. @param {File[]} files */
async function take(files) {
  const taken = await attempt(async () => {
    const { others, isNews } = await descriptions.take(files);
    if (others.length) await openAll(others.map(sourceOf));
    else if (isNews) {
      page.indexed = "";
      await again();
    }
    return true;
  });
  if (!taken) document.body.dataset.state = "failed";
}

/** @param {KeyboardEvent} event */
function onKey(event) {
  const target = /** @type {any} */ (event.target);
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (target.matches?.("input, select, textarea")) {
    if (event.key === "Escape") element("frames").focus();
    return;
  }
  const step = /** @type {Record<string, number>} */ ({ j: 1, ArrowDown: 1, k: -1, ArrowUp: -1, PageDown: list.seen, PageUp: -list.seen, Home: -Infinity, End: Infinity });
  if (event.key in step && (target === element("frames") || "jk".includes(event.key))) moveBy(step[event.key]);
  else if (event.key === "n") problems.move(1);
  else if (event.key === "p") problems.move(-1);
  else if (event.key === "/") element("filter").querySelector("input").focus();
  else if (event.key === "l") element("language").click();
  else if (event.key === "t") element("time").click();
  else if (event.key === "?") element("keys").click();
  else return;
  event.preventDefault();
}

/** @param {number} by */
async function moveBy(by) {
  if (list.length < 1) return;
  const at = list.chosen ? await ask("place", { frame: list.chosen }) : -1;
  const place = Math.min(Math.max(at + by, 0), list.length - 1);
  const [row] = await ask("rows", { from: place, count: 1 });
  if (row) goTo(row.frame);
}

function begin() {
  element("file").addEventListener("change", (/** @type {any} */ event) => {
    const files = [...event.target.files];
    event.target.value = ""; // the same file may be opened again
    take(files);
  });
  element("language").addEventListener("click", () => speak(language.now === "zh" ? "en" : "zh"));
  element("all").addEventListener("click", () => filter(""));
  element("back").addEventListener("click", () => back());
  element("keys").addEventListener("click", () => element("help").showModal());
  element("cancel").addEventListener("click", () => {
    if (page.opened) ask("cancel", {});
    else link.restart();
  });
  element("time").addEventListener("click", () => {
    const forms = ["since", "date", "delta"];
    list.time = forms[(forms.indexOf(list.time) + 1) % forms.length];
    element("time").textContent = word("html_time", list.time);
    list.draw();
  });
  element("theme").addEventListener("click", () => {
    const dark = document.documentElement.dataset.theme ?? (matchMedia("(prefers-color-scheme: dark)").matches ? "dark" : "light");
    document.documentElement.dataset.theme = dark === "dark" ? "light" : "dark";
    axis.changed();
  });
  element("save").addEventListener("change", (/** @type {any} */ event) => {
    if (event.target.value) save(event.target.value);
    event.target.value = "";
  });
  element("filter").addEventListener("submit", (/** @type {Event} */ event) => {
    event.preventDefault();
    filter(element("filter").querySelector("input").value.trim());
  });
  document.addEventListener("keydown", onKey);
  for (const kind of ["dragover", "drop", "dragleave"]) {
    document.addEventListener(kind, (event) => {
      event.preventDefault();
      document.body.classList.toggle("dropping", kind === "dragover");
    });
  }
  document.addEventListener("drop", (event) => {
    take([...(event.dataTransfer?.files ?? [])]);
  });
  addEventListener("beforeprint", () => {
    problems.fillAll();
    for (const one of document.querySelectorAll("details.problem, details.near")) /** @type {any} */ (one).open = true;
  });
  speak(SETTINGS.lang);
  const inside = embeddedSources();
  document.body.dataset.state = "ready";
  if (inside.length) openAll(inside);
}

begin();
