// The worker's loop: requests come as {id, ask, with}, answers go as {id, answer} or {id, error}.

/** Requests that read what is kept: they are answered at once, also while a pass runs. */
const QUICK = ["rows", "row", "place", "frameAt", "lines", "envelope", "listed", "transfer", "describes", "describe", "nodes", "cancel"];

/** @type {Requests | null} */
let requests = null;
let queue = Promise.resolve();

onmessage = ({ data }) => {
  if (data.packed || data.module) {
    queue = boot(data).catch((error) => postMessage({ failed: String(error) }));
  } else if (data.bytes) {
    const waiting = requests?.waiting;
    if (requests) requests.waiting = null;
    waiting?.(data.bytes);
  } else if (requests && QUICK.includes(data.ask)) {
    answer(data);
  } else {
    if (data.ask === "filter" || data.ask === "explain") requests?.begun(data.ask);
    queue = queue.then(() => answer(data));
  }
};

/** Begins with the core that another worker has compiled, or as the page has it: by LZMA, in base64. @param {{module?: WebAssembly.Module, packed: string}} given */
async function boot({ module, packed }) {
  const compiled = module ?? (await WebAssembly.compile(unlzma(Uint8Array.from(atob(packed), (one) => one.charCodeAt(0)))));
  requests = new Requests(await Core.of(compiled), (message, transfer = []) => postMessage(message, { transfer }));
  postMessage({ module: compiled });
}

/** @param {{id: number, ask: string, with: any}} request */
async function answer({ id, ask, with: given }) {
  try {
    const made = await /** @type {any} */ (requests)[ask](given);
    postMessage({ id, answer: made });
  } catch (error) {
    const { constructor, message: text, file } = /** @type {any} */ (error);
    const kind = error instanceof WebAssembly.RuntimeError ? "trap" : constructor.name;
    postMessage({ id, error: { kind, text, file } });
  }
}
