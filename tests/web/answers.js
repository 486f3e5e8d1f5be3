// Runs sessions of the core in WebAssembly under node: `node answers.js WASM CASES WORKER_FILE...`.
//
// CASES is JSON: [{file, name, format, options, pieces, descriptions}]. A line of standard output is a digest of all that a
// session gives: tests/test_web.py makes the same of the installed core.
"use strict";
const crypto = require("node:crypto");
const fs = require("node:fs");
const vm = require("node:vm");

const [wasm, cases, ...files] = process.argv.slice(2);
const source = files.map((file) => fs.readFileSync(file, "utf8")).join("\n");
const { Core, Frames, unlzma } = vm.runInThisContext(`(() => { ${source}\nreturn { Core, Frames, unlzma }; })()`);

/** A value as tests/test_web.py has it. */
function plain(value) {
  if (typeof value === "bigint" || typeof value === "number") return String(value);
  if (value instanceof Uint8Array) return Buffer.from(value).toString("hex");
  if (Array.isArray(value)) return value.map(plain);
  return value;
}

function column(one) {
  const floats = one.layout.type.startsWith("Float");
  const hex = (number) => {
    const bytes = Buffer.alloc(8);
    bytes.writeDoubleBE(number);
    return bytes.toString("hex");
  };
  return Array.from({ length: one.rows }, (_, row) => {
    const value = one.value(row);
    if (value !== null && floats) return hex(value);
    return plain(value);
  });
}

function answer(core, { file, name, format, options, pieces, descriptions = [] }) {
  const bytes = fs.readFileSync(file);
  core.exports.close();
  for (const one of descriptions) core.describe(one, fs.readFileSync(one));
  const digest = crypto.createHash("sha256");
  const rows = (flush) => {
    for (const batch of core.batches(flush)) {
      const columns = core.columns(batch);
      const listed = batch.columns.map((one) => [one.name, column(columns[one.name])]);
      digest.update(JSON.stringify([batch.table, batch.rows, listed]));
    }
  };
  core.open(options);
  core.begin(name, format);
  const length = Math.max(1, Math.ceil(bytes.length / pieces));
  for (let at = 0; at < bytes.length; at += length) digest.update(core.feed(bytes.subarray(at, at + length)));
  digest.update(core.end(false));
  digest.update(core.finish());
  rows(true);
  digest.update(JSON.stringify([core.complaints(), core.nature(), core.frames]));
  for (const call of ["tally", "nodes", "contents", "snapshot"]) {
    digest.update(core.text(core.exports[call]()));
  }
  return digest.digest("hex");
}

/** Every frame's line as it is kept, and the frames that a search finds. */
async function kept(core, { file, name, format, options, searched }) {
  const frames = new Frames(core);
  core.open(options);
  core.begin(name, format);
  core.feed(fs.readFileSync(file));
  core.end(false);
  core.finish();
  for (const batch of core.batches(true)) if (batch.table === "listing") frames.add(batch.rows, core.columns(batch));
  const places = Array.from({ length: frames.count }, (_, place) => place);
  const order = [...places.filter((place) => place % 3 === 0), ...places.filter((place) => place % 3)];
  const lines = [];
  for (const place of order) lines[place] = frames.row(place).line;
  const found = [];
  for (const text of searched) found.push([...(await frames.search(text, () => true))]);
  return JSON.stringify([lines, found]);
}

/** What a case asks for: `describe` a file, `unlzma` one, the lines `searched`, or a digest of a session. */
async function asked(core, one) {
  if (one.describe) return JSON.stringify(core.describe(one.name, fs.readFileSync(one.describe)));
  if (one.unlzma) return crypto.createHash("sha256").update(unlzma(fs.readFileSync(one.unlzma))).digest("hex");
  return one.searched ? kept(core, one) : answer(core, one);
}

(async () => {
  const core = await Core.of(await WebAssembly.compile(unlzma(fs.readFileSync(wasm))));
  for (const one of JSON.parse(fs.readFileSync(cases, "utf8"))) {
    let line;
    try {
      line = await asked(core, one);
    } catch (error) {
      line = `${error.constructor.name}: ${error.message}`;
      if (error instanceof WebAssembly.RuntimeError) throw error;
    }
    fs.writeSync(1, `${line}\n`);
  }
})();
