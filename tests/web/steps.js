// What tests do in the page, and read of it.

/** Drop a file whose bytes are given in base64. */
function drop(name, data) {
  const files = new DataTransfer();
  files.items.add(new File([Uint8Array.from(atob(data), (one) => one.charCodeAt(0))], name));
  document.dispatchEvent(new DragEvent("drop", { dataTransfer: files, bubbles: true, cancelable: true }));
}

/** Type the nodes of a description. */
function describe(name, nodes) {
  const chips = [...document.querySelectorAll("#descriptions .chip")];
  const field = chips.find((one) => one.querySelector("b").textContent === name).querySelector("input");
  field.value = nodes;
  field.dispatchEvent(new Event("change"));
}

/** Keep what the page saves, and its name. */
function keepSaved() {
  window.saved = null;
  window.made ??= URL.createObjectURL;
  URL.createObjectURL = (blob) => {
    blob.text().then((text) => {
      window.saved = text;
    });
    return window.made(blob);
  };
  HTMLAnchorElement.prototype.click = function () {
    window.named = this.download;
  };
}

/** Save in a form. */
function save(form) {
  const box = document.querySelector("#save");
  box.value = form;
  box.dispatchEvent(new Event("change"));
}

/** Type a filter, and forget what was said of the one before. */
function filter(expression) {
  document.querySelector("#filter output").textContent = "";
  ask(expression);
}

/** Type a filter or the number of a frame. */
function ask(expression) {
  const form = document.querySelector("#filter");
  form.querySelector("input").value = expression;
  form.requestSubmit();
}

/** Keep each text that is drawn. */
function keepDrawn() {
  window.drawn = [];
  const draw = CanvasRenderingContext2D.prototype.fillText;
  CanvasRenderingContext2D.prototype.fillText = function (text, ...rest) {
    window.drawn.push(text);
    return draw.call(this, text, ...rest);
  };
}

/** The texts of all that a selector finds. */
function texts(selector) {
  return [...document.querySelectorAll(selector)].map((one) => one.textContent);
}

/** An attribute of all that have it. */
function attributes(name) {
  return [...document.querySelectorAll(`[${name}]`)].map((one) => one.getAttribute(name));
}

/** Search in the table of objects. */
function searchObjects(text) {
  const field = document.querySelector("#objects input");
  field.value = text;
  field.dispatchEvent(new Event("input"));
}

/** The number of points that are drawn in a plot. */
function plotted() {
  const canvas = document.querySelector("#plots canvas");
  const { data } = canvas.getContext("2d").getImageData(60, 20, canvas.width - 60, canvas.height - 20);
  let count = 0;
  for (let at = 3; at < data.length; at += 4) count += data[at] > 0;
  return count;
}

/** Press and let go in the lanes. */
function pressLanes(x, y) {
  const canvas = document.querySelector("#lanes canvas");
  const box = canvas.getBoundingClientRect();
  const [clientX, clientY] = [box.left + x, box.top + y];
  const at = { clientX, clientY, pointerId: 1, bubbles: true, cancelable: true };
  canvas.setPointerCapture = () => {};
  for (const kind of ["pointerdown", "pointerup"]) canvas.dispatchEvent(new PointerEvent(kind, at));
}

/** Ask a server in each way that there is; count what is refused. */
function request(address) {
  window.refused = 0;
  document.addEventListener("securitypolicyviolation", () => {
    window.refused += 1;
  });
  fetch(address).catch(() => {});
  new Image().src = address;
  const script = document.createElement("script");
  script.textContent = "window.hacked = 1";
  document.body.append(script);
}

/** Keep the lengths of long tasks. */
function keepTasks() {
  window.tasks = [0];
  const noted = (list) => {
    for (const one of list.getEntries()) window.tasks.push(one.duration);
  };
  new PerformanceObserver(noted).observe({ type: "longtask" });
}

/** Ask for a filter and cancel it. */
function askAndCancel(expression) {
  ask(expression);
  document.querySelector("#cancel").click();
}

/** Keep the longest time in which the page did nothing else. */
function keepLongest() {
  window.longest = 0;
  let last = performance.now();
  (function tick() {
    const now = performance.now();
    window.longest = Math.max(window.longest, now - last);
    last = now;
    setTimeout(tick);
  })();
}
