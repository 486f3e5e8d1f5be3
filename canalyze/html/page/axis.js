// The common axis of time of lanes and plots: nanoseconds since the first frame.

class Axis {
  constructor() {
    this.begin = 0;
    this.end = 1;
    this.from = 0;
    this.to = 1;
    /** @type {number | null} The time of the chosen frame. */
    this.cursor = null;
    /** @type {(() => void)[]} */
    this.views = [];
    this.waiting = false;
  }

  /** @param {number} begin @param {number} end */
  reset(begin, end) {
    const pad = Math.max((end - begin) * 0.01, 1000);
    Object.assign(this, { begin: begin - pad, end: end + pad, from: begin - pad, to: end + pad, cursor: null });
    this.changed();
  }

  /** @param {number} from @param {number} to */
  show(from, to) {
    const span = Math.min(Math.max(to - from, 1000), this.end - this.begin);
    this.from = Math.min(Math.max(from, this.begin), this.end - span);
    this.to = this.from + span;
    this.changed();
  }

  /** @param {number} t @param {number} factor */
  zoom(t, factor) {
    this.show(t - (t - this.from) * factor, t + (this.to - t) * factor);
  }

  /** Moves the cursor, and into view. @param {number | null} t */
  point(t) {
    this.cursor = t;
    if (t !== null && (t < this.from || t > this.to)) {
      const half = (this.to - this.from) / 2;
      this.show(t - half, t + half);
    }
    this.changed();
  }

  changed() {
    if (this.waiting) return;
    this.waiting = true;
    requestAnimationFrame(() => {
      this.waiting = false;
      for (const draw of this.views) draw();
    });
  }

  /** @returns {{t: number, text: string}[]} */
  ticks(/** @type {number} */ most) {
    const span = this.to - this.from;
    const power = 10 ** Math.floor(Math.log10(span / most));
    const step = [1, 2, 5, 10].map((one) => one * power).find((one) => span / one <= most) ?? power * 10;
    const digits = Math.max(0, Math.ceil(-Math.log10(step / 1e9) - 1e-9));
    const found = [];
    for (let t = Math.ceil(this.from / step) * step; t <= this.to; t += step) {
      found.push({ t, text: `${(t / 1e9).toFixed(Math.min(digits, 6))} s` });
    }
    return found;
  }
}

/**
 * Lets a canvas zoom by the wheel and move by dragging; a click gives the time.
 * @param {any} canvas @param {Axis} axis @param {() => number} left @param {(t: number, y: number) => void} click
 * @param {(t: number, y: number) => void} [over]
 */
function handle(canvas, axis, left, click, over = () => {}) {
  /** @type {{x: number, from: number, to: number, moved: boolean} | null} */
  let held = null;
  const room = () => Math.max(canvas.clientWidth - left(), 1);
  const timeAt = (/** @type {number} */ x) => axis.from + ((x - left()) / room()) * (axis.to - axis.from);
  canvas.addEventListener("wheel", (/** @type {WheelEvent} */ event) => {
    if (event.shiftKey || !event.deltaY || event.offsetX < left()) return;
    event.preventDefault();
    axis.zoom(timeAt(event.offsetX), event.deltaY > 0 ? 1.25 : 0.8);
  }, { passive: false });
  canvas.addEventListener("pointerdown", (/** @type {PointerEvent} */ event) => {
    held = { x: event.offsetX, from: axis.from, to: axis.to, moved: false };
    canvas.setPointerCapture(event.pointerId);
  });
  canvas.addEventListener("pointermove", (/** @type {PointerEvent} */ event) => {
    if (!held) {
      over(timeAt(event.offsetX), event.offsetY);
      return;
    }
    const by = ((event.offsetX - held.x) / room()) * (held.to - held.from);
    if (Math.abs(event.offsetX - held.x) > 3) held.moved = true;
    if (held.moved) axis.show(held.from - by, held.to - by);
  });
  canvas.addEventListener("pointerup", (/** @type {PointerEvent} */ event) => {
    if (held && !held.moved) click(timeAt(event.offsetX), event.offsetY);
    held = null;
  });
  canvas.addEventListener("pointercancel", () => (held = null));
  canvas.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => {
    const span = axis.to - axis.from;
    const middle = axis.cursor ?? (axis.from + axis.to) / 2;
    if (event.key === "ArrowLeft") axis.show(axis.from - span / 10, axis.to - span / 10);
    else if (event.key === "ArrowRight") axis.show(axis.from + span / 10, axis.to + span / 10);
    else if (event.key === "+" || event.key === "=") axis.zoom(middle, 0.8);
    else if (event.key === "-") axis.zoom(middle, 1.25);
    else if (event.key === "0") axis.show(axis.begin, axis.end);
    else return;
    event.preventDefault();
    event.stopPropagation();
  });
}

/** Prepares a canvas for its width and the screen's resolution. @param {any} canvas @param {number} height */
function penOf(canvas, height) {
  const scale = window.devicePixelRatio || 1;
  const width = canvas.clientWidth;
  canvas.style.height = `${height}px`;
  canvas.width = Math.round(width * scale);
  canvas.height = Math.round(height * scale);
  const pen = canvas.getContext("2d");
  pen.setTransform(scale, 0, 0, scale, 0, 0);
  pen.font = "11px system-ui, sans-serif";
  pen.textBaseline = "middle";
  return { pen, width };
}

/** @param {string} name */
function colour(name) {
  return getComputedStyle(document.documentElement).getPropertyValue(name).trim();
}

/** Returns the place of the first number from a time on. @param {ArrayLike<number>} sorted @param {number} t */
function firstFrom(sorted, t) {
  let [low, high] = [0, sorted.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] < t) low = middle + 1;
    else high = middle;
  }
  return low;
}
