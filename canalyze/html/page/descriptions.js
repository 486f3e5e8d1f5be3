// Device descriptions that were dropped, and the nodes that have them, by the rules of canalyze/configuration/network.py.

/** Most bytes of a description. */
const LARGEST = 8 << 20;
/** Bytes by which a description is told from a capture. */
const HEAD = 1 << 16;
const DESCRIPTION_NAME = /\.(eds|dcf|xdd|xdc|cdcf)$/i;

/**
 * A description: `about` is the core's, `spelled` the nodes as they were typed.
 * @typedef {{name: string, bytes: ArrayBuffer, about: {form: string, node: number | null, product: string | null, objects: number,
 *   pdos: number, defects: Record<string, number>}, spelled: string, bus: string | null, nodes: number[]}} Described
 * @typedef {[string | null, number, number]} Carrier Bus, null for every bus; node-ID; place of the description.
 */

class Descriptions {
  /** @param {any} box @param {Link} link @param {Record<string, string>} effects By the code of a defect. @param {() => void} changed */
  constructor(box, link, effects, changed) {
    this.box = box;
    this.link = link;
    this.effects = effects;
    this.changed = changed;
    /** @type {Described[]} */
    this.all = [];
    /** @type {{key: string, facts: Record<string, any>}[]} Why files could not be used. */
    this.refused = [];
  }

  /** Keeps the descriptions among files. @param {File[]} files @returns {Promise<{others: File[], isNews: boolean}>} */
  async take(files) {
    const before = this.all;
    this.refused = [];
    const others = [];
    for (const file of files) {
      if (await this.isOne(file)) await this.add(file);
      else others.push(file);
    }
    this.draw();
    const added = this.all.filter((one) => !before.includes(one));
    this.box.querySelector("input.wanted")?.focus();
    return { others, isNews: added.some((one) => this.nodesOf(one).length > 0) };
  }

  /** Asks the worker, and the next one if it is restarted meanwhile. @param {string} kind @param {object} given @returns {Promise<any>} */
  async asked(kind, given) {
    for (;;) {
      try {
        return await this.link.ask(kind, given);
      } catch (error) {
        if (!(error instanceof RequestError) || error.kind !== "Superseded") throw error;
      }
    }
  }

  /** @param {File} file @returns {Promise<boolean>} */
  async isOne(file) {
    if (DESCRIPTION_NAME.test(file.name)) return true;
    const head = await file.slice(0, HEAD).arrayBuffer().catch(() => null); // reported when it is opened
    return head !== null && this.asked("describes", { head });
  }

  /** @param {File} file */
  async add(file) {
    const { name } = file;
    if (file.size > LARGEST) {
      this.refused.push({ key: "eds.large", facts: { name, most: LARGEST >> 20 } });
      return;
    }
    const bytes = await file.arrayBuffer().catch((error) => String(error));
    if (typeof bytes === "string") {
      this.refused.push({ key: "html.not_read", facts: { problem: bytes } });
      return;
    }
    const about = await this.asked("describe", { name, bytes });
    if (about.error) {
      const [key, facts] = about.error;
      this.refused.push({ key, facts: { ...facts, name } });
      return;
    }
    const before = this.all.find((one) => one.name === name);
    const { spelled, bus, nodes } = before ?? { spelled: "", bus: null, nodes: [] };
    const one = { name, bytes, about, spelled, bus, nodes };
    this.all = before ? this.all.map((other) => (other === before ? one : other)) : [...this.all, one];
    this.link.descriptions = this.all;
    if (before) this.link.restart(); // numbers are places in the list
  }

  /** @param {Described} one */
  remove(one) {
    this.all = this.all.filter((other) => other !== one);
    this.refused = [];
    this.link.descriptions = this.all;
    this.link.restart();
    this.draw();
    this.changed(); // of those that stay the numbers are others
  }

  /** Takes nodes as they were typed: `5`, `1-4,7`, `can0:5`. @param {Described} one @param {string} spelled */
  async bind(one, spelled) {
    const before = JSON.stringify(this.settled().carriers);
    const [, bus, nodes] = /^(?:(.*):)?(.*)$/.exec(spelled.trim()) ?? [];
    one.spelled = spelled.trim();
    one.bus = bus ?? null;
    const found = nodes ? await this.asked("nodes", { spelled: nodes }) : null;
    one.nodes = bus === "" ? [] : found ?? [];
    this.draw();
    if (JSON.stringify(this.settled().carriers) !== before) this.changed();
  }

  /** Returns the nodes of a description; a DCF has its own. @param {Described} one */
  nodesOf(one) {
    const own = one.about.node;
    return one.spelled || own === null ? one.nodes : [own];
  }

  /** Settles which node has which description. @returns {{carriers: Carrier[], complaints: string[]}} */
  settled() {
    /** @type {Carrier[]} */
    const carriers = [];
    /** @type {string[]} */
    const complaints = [];
    this.all.forEach((one, place) => {
      for (const node of this.nodesOf(one)) {
        const other = carriers.find(([bus, of]) => bus === one.bus && of === node);
        if (!other) carriers.push([one.bus, node, place]);
        else if (other[2] !== place) complaints.push(say("network.twice", { node, one: this.all[other[2]].name, other: one.name }));
      }
    });
    return { carriers, complaints };
  }

  /** Returns what is known of the network, with that inside the page where no dropped description is for a node. @param {any} filed */
  network(filed = {}) {
    const { carriers } = this.settled();
    if (!carriers.length) return filed;
    const first = filed.dictionaries?.length ?? 0;
    const rest = (filed.descriptions ?? []).filter(
      (/** @type {Carrier} */ [bus, node]) => !carriers.some(([other, of]) => of === node && (other === null || other === bus)),
    );
    return { ...filed, descriptions: [...carriers.map(([bus, node, place]) => [bus, node, first + place]), ...rest] };
  }

  /** Returns what is odd about a description, in the words of the command line. @param {Described} one */
  said(one) {
    const { name, about, spelled } = one;
    const nodes = this.nodesOf(one);
    const found = [];
    if (!nodes.length) found.push(say(spelled ? "html.wrong_nodes" : "html.no_nodes", { name, spelled }));
    const others = nodes.filter((node) => node !== about.node).sort((a, b) => a - b);
    if (about.form === "dcf" && about.node !== null && others.length) {
      found.push(say("network.other_node", { name, own: about.node, nodes: others.join(", ") }));
    }
    const count = (/** @type {string} */ effect) =>
      Object.entries(about.defects).reduce((sum, [code, number]) => sum + (this.effects[code] === effect ? number : 0), 0);
    const odd = ["repaired", "unused"].map((effect) => [`network.${effect}`, count(effect)]).filter(([, number]) => number);
    if (odd.length) {
      const listed = odd.map(([key, number]) => say(String(key), { count: number })).join(say("network.then"));
      found.push(say("network.defects", { name, said: listed, command: `canalyze eds ${name}` }));
    }
    return found;
  }

  draw() {
    const lines = [...this.refused.map(({ key, facts }) => say(key, facts)), ...this.settled().complaints];
    this.box.hidden = !this.all.length && !lines.length;
    this.box.replaceChildren(
      ...this.all.map((one) => this.chip(one)),
      ...[...lines, ...this.all.flatMap((one) => this.said(one))].map((line) => make("p", { className: "warning" }, printable(line))),
    );
  }

  /** @param {Described} one */
  chip(one) {
    const { name, about } = one;
    const field = make("input", {
      value: one.spelled, placeholder: about.node === null ? "5   1-4,7" : String(about.node), size: 8, spellcheck: false,
      title: say("html.nodes_help"), onchange: () => this.bind(one, field.value),
    });
    field.setAttribute("list", "present");
    field.classList.toggle("wanted", !this.nodesOf(one).length);
    const forms = [about.form === "concise" ? say("eds.concise") : about.form.toUpperCase(), about.product];
    const count = say("html.objects", { count: about.objects });
    return make(
      "span",
      { className: "chip" },
      make("b", {}, printable(name)),
      make("span", { className: "quiet" }, ` ${printable([...forms, count].filter(Boolean).join(" · "))} `),
      make("label", {}, say("html.for_nodes"), " ", field),
      make("button", { type: "button", title: say("html.remove"), "aria-label": say("html.remove"), onclick: () => this.remove(one) }, "×"),
    );
  }
}
