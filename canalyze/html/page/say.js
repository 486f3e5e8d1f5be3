// Words: those of the page itself. What is said of a capture comes from the core.

/** @param {string} id @returns {any} */
function element(id) {
  return document.getElementById(id);
}

/** @param {string} id @returns {any} */
function embedded(id) {
  return JSON.parse(element(id).textContent);
}

/** @type {Record<string, Record<string, string>>} */
const WORDS = embedded("words");

const language = { now: "zh" };

/**
 * Returns a sentence with its facts: `{name}`, and `{count:frame|frames}` with its noun.
 * @param {string} key @param {Record<string, string | number>} [facts]
 */
function say(key, facts = {}) {
  const sentence = WORDS[language.now][key] ?? key;
  return sentence.replace(/\{(\w+)(?::([^|{}]*)\|([^|{}]*))?\}/g, (_, name, one, many) => {
    const fact = String(facts[name] ?? "");
    return one === undefined ? fact : `${fact} ${fact === "1" ? one : many}`;
  });
}

/** Returns the word for a value of the core; the value itself if there is none. @param {string} table @param {string} value */
function word(table, value) {
  return WORDS[language.now][`${table}.${value}`] ?? value;
}

/** Returns the words for the values of a table, by value. @param {string} table @returns {Record<string, string>} */
function wordsOf(table) {
  const start = `${table}.`;
  const found = Object.entries(WORDS[language.now]).filter(([key]) => key.startsWith(start));
  return Object.fromEntries(found.map(([key, said]) => [key.slice(start.length), said]));
}

/** Puts the words of the language into the page. */
function sayAll() {
  document.documentElement.lang = language.now;
  for (const one of document.querySelectorAll("[data-say]")) one.textContent = say(one.getAttribute("data-say") ?? "");
  for (const one of document.querySelectorAll("[data-say-title]")) {
    one.setAttribute("title", say(one.getAttribute("data-say-title") ?? ""));
    one.setAttribute("aria-label", one.getAttribute("title") ?? "");
  }
  for (const one of document.querySelectorAll("[data-say-placeholder]")) {
    one.setAttribute("placeholder", say(one.getAttribute("data-say-placeholder") ?? ""));
  }
}

/**
 * Makes an element. Text is never read as markup.
 * @param {string} tag @param {Record<string, any>} [properties] @param {...(Node | string | null | undefined | false)} children
 * @returns {any}
 */
function make(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name in made) /** @type {any} */ (made)[name] = value;
    else made.setAttribute(name, value);
  }
  for (const child of children) if (child !== null && child !== undefined && child !== false) made.append(child);
  return made;
}

/** Text as it can be shown: control characters and marks of direction are escaped. @param {string} text */
function printable(text) {
  return text.replace(/[\u0000-\u001f\u007f-\u009f\u200b-\u200f\u202a-\u202e\u2066-\u2069\ufeff]/g, (one) => {
    const code = one.charCodeAt(0);
    return code < 0x100 ? `\\x${code.toString(16).padStart(2, "0")}` : `\\u${code.toString(16).padStart(4, "0")}`;
  });
}

/** @param {number | null} frame @param {(frame: number) => void} go */
function frameButton(frame, go) {
  return make("button", { type: "button", className: "frame", onclick: () => frame && go(frame) }, `#${frame}`);
}

/** @param {number} ns */
function seconds(ns) {
  return (ns / 1e9).toFixed(6);
}
