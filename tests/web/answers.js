// Runs sessions of the core in WebAssembly under node: `node answers.js WASM CASES WORKER_FILE...`.
//
// CASES is JSON: [{file, name, format, options, pieces}]. A line of standard output is a digest of all that a session
// gives: tests/test_web.py makes the same of the installed core.
"use strict";
const crypto = require("node:crypto");
const fs = require("node:fs");
const vm = require("node:vm");

const [wasm, cases, ...files] = process.argv.slice(2);
const source = files.map((file) => fs.readFileSync(file, "utf8")).join("\n");
const { Core } = vm.runInThisContext(`(() => { ${source}\nreturn { Core }; })()`);

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

function answer(core, { file, name, format, options, pieces }) {
  const bytes = fs.readFileSync(file);
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

(async () => {
  const core = await Core.of(fs.readFileSync(wasm));
  for (const one of JSON.parse(fs.readFileSync(cases, "utf8"))) {
    let line;
    try {
      line = answer(core, one);
    } catch (error) {
      line = `${error.constructor.name}: ${error.message}`;
      if (error instanceof WebAssembly.RuntimeError) throw error;
    }
    fs.writeSync(1, `${line}\n`);
  }
})();
