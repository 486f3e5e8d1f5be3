// The page's side of the worker: requests and answers, bytes of the file, a new worker after a trap.

/**
 * @typedef {{name: string, size: number, format?: string, damage?: object | null,
 *   read: (at: number, length: number) => Promise<ArrayBuffer>}} Part A file of a capture.
 * @typedef {{name: string, parts: Part[], problem?: number | null}} Source A capture; the problem that it opens on.
 */

/** An error of a request; `kind` is the class of the worker's error, `file` the name of the file that it is about. */
class RequestError extends Error {
  /** @param {string} kind @param {string} text @param {string} [file] */
  constructor(kind, text, file = "") {
    super(text);
    this.kind = kind;
    this.file = file;
  }
}

class Link {
  /** @param {(share: number, count: number) => void} progress @param {() => void} idle Called when all is answered. */
  constructor(progress, idle) {
    this.progress = progress;
    this.idle = idle;
    /** @type {Source | null} */
    this.source = null;
    /** @type {{name: string, bytes: ArrayBuffer}[]} Device descriptions that each worker has, by their numbers. */
    this.descriptions = [];
    /** @type {WebAssembly.Module | null} The core, once a worker has compiled it. */
    this.module = null;
    /** @type {Map<number, {done: (answer: any) => void, failed: (error: Error) => void}>} */
    this.pending = new Map();
    this.number = 0;
    this.used = false;
    this.start();
  }

  start() {
    const script = new Blob([element("worker").textContent], { type: "text/javascript" });
    const address = URL.createObjectURL(script);
    this.worker = new Worker(address);
    URL.revokeObjectURL(address);
    this.worker.onmessage = ({ data }) => this.take(data);
    this.worker.onerror = (event) => this.fail("trap", event.message);
    this.worker.postMessage(this.module ? { module: this.module } : { packed: element("wasm").textContent });
    for (const one of this.descriptions) this.worker.postMessage({ ask: "describe", with: one });
    this.used = false;
  }

  /** Ends the worker, with all that it does, and starts another one. */
  restart() {
    if (!this.used) return;
    this.worker?.terminate();
    this.fail("Superseded", "");
    this.start();
  }

  /** @param {string} kind @param {string} text */
  fail(kind, text) {
    this.used = true;
    const pending = [...this.pending.values()];
    this.pending.clear();
    for (const { failed } of pending) failed(new RequestError(kind, text));
    this.idle();
  }

  /** @param {any} data */
  async take(data) {
    if (data.read) {
      const { worker } = this;
      const bytes = new Uint8Array(await this.piece(data.read));
      worker?.postMessage({ bytes }, [bytes.buffer]);
    } else if (data.progress) {
      this.progress(data.progress.share, data.progress.count);
    } else if (data.module) {
      this.module = data.module;
    } else if (data.failed) {
      this.fail("trap", data.failed);
    } else if (data.id) {
      const waiting = this.pending.get(data.id);
      this.pending.delete(data.id);
      if (!this.pending.size) this.idle();
      if (data.error) waiting?.failed(new RequestError(data.error.kind, data.error.text, data.error.file));
      else waiting?.done(data.answer);
    }
  }

  /** @param {{part: number, at: number, length: number}} wanted @returns {Promise<ArrayBuffer>} */
  async piece({ part, at, length }) {
    try {
      return (await this.source?.parts[part].read(at, length)) ?? new ArrayBuffer(0);
    } catch (error) {
      this.fail("NotReadable", String(error));
      return new ArrayBuffer(0);
    }
  }

  /** @param {string} kind @param {any} [given] @returns {Promise<any>} */
  ask(kind, given = {}) {
    this.number += 1;
    this.used = true;
    const id = this.number;
    const answer = new Promise((done, failed) => this.pending.set(id, { done, failed }));
    this.worker?.postMessage({ id, ask: kind, with: given });
    return answer;
  }
}

/** Returns the description of a capture for the worker. @param {Source} source @param {object} options @param {boolean} merge */
function described({ parts }, options, merge) {
  return { parts: parts.map(({ name, size, format, damage }) => ({ name, size, format, damage })), options, merge };
}

/** @param {File} file @returns {Source} */
function sourceOf(file) {
  const read = (/** @type {number} */ at, /** @type {number} */ length) => file.slice(at, at + length).arrayBuffer();
  return { name: file.name, parts: [{ name: file.name, size: file.size, read }] };
}

/** Returns the captures inside the page, whose files are packed. @returns {Source[]} */
function embeddedSources() {
  /** @type {Map<number, Source>} */
  const found = new Map();
  for (const one of document.querySelectorAll("script.capture")) {
    const { recording, name, format, damage, problem } = JSON.parse(one.nextElementSibling?.textContent ?? "{}");
    const text = one.textContent ?? "";
    const size = (text.length / 4) * 3 - (/=*$/.exec(text)?.[0].length ?? 0);
    const read = async (/** @type {number} */ at, /** @type {number} */ length) => decoded(text, at, Math.min(at + length, size));
    /** @type {Source} */
    const source = found.get(recording) ?? { name: "", parts: [], problem };
    source.parts.push({ name, size, format, damage, read });
    source.name = source.parts.map((part) => part.name).join(", ");
    found.set(recording, source);
  }
  return [...found.values()];
}

/** Returns some of the bytes that a text has in base64. @param {string} text @param {number} from @param {number} to @returns {ArrayBuffer} */
function decoded(text, from, to) {
  const first = Math.floor(from / 3);
  const bytes = atob(text.slice(first * 4, Math.ceil(to / 3) * 4));
  const found = new Uint8Array(Math.max(to - from, 0));
  for (let at = 0; at < found.length; at += 1) found[at] = bytes.charCodeAt(from - first * 3 + at);
  return found.buffer;
}
