// The worker's loop: requests come as {id, ask, with}, answers go as {id, answer} or {id, error}.

/** Requests that read what is kept: they are answered at once, also while a pass runs. */
const QUICK = ["rows", "row", "place", "frameAt", "lines", "envelope", "listed", "transfer"];

/** @type {Requests | null} */
let requests = null;
let queue = Promise.resolve();

onmessage = ({ data }) => {
  if (data.wasm) {
    queue = boot(data.wasm).catch((error) => postMessage({ failed: String(error) }));
  } else if (data.bytes) {
    const waiting = requests?.waiting;
    if (requests) requests.waiting = null;
    waiting?.(data.bytes);
  } else if (QUICK.includes(data.ask)) {
    answer(data);
  } else {
    if (data.ask === "filter" || data.ask === "explain") requests?.begun(data.ask);
    queue = queue.then(() => answer(data));
  }
};

/** @param {Uint8Array<ArrayBuffer>} packed */
async function boot(packed) {
  const stream = new DecompressionStream("gzip");
  const to = stream.writable.getWriter();
  to.write(packed).catch(() => {});
  to.close().catch(() => {});
  const from = stream.readable.getReader();
  const pieces = [];
  for (;;) {
    const { done, value } = await from.read();
    if (done) break;
    pieces.push(value);
  }
  requests = new Requests(await Core.of(joined(pieces)), (message, transfer = []) => postMessage(message, { transfer }));
  postMessage({ ready: true });
}

/** @param {{id: number, ask: string, with: any}} request */
async function answer({ id, ask, with: given }) {
  try {
    const made = await /** @type {any} */ (requests)[ask](given);
    postMessage({ id, answer: made });
  } catch (error) {
    const kind = error instanceof WebAssembly.RuntimeError ? "trap" : /** @type {any} */ (error).constructor.name;
    postMessage({ id, error: { kind, text: /** @type {any} */ (error).message } });
  }
}
