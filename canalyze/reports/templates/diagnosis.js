"use strict";
const root = document.documentElement;
const problems = [...document.querySelectorAll(".problem")];
const links = [...document.querySelectorAll("nav a")];
const search = document.getElementById("search");
const every = document.getElementById("every");
const ROW = 20;
const TALLEST = 10000000;

function open(id) {
  for (const problem of problems) problem.classList.toggle("shown", problem.id === id);
  for (const link of links) link.classList.toggle("here", link.getAttribute("href") === "#" + id);
}

function counted(count) {
  document.getElementById("found").textContent = search.value.trim() ? String(count) : "";
}

function searchTable() {
  const rows = [...document.querySelectorAll("#frames tr")];
  const texts = rows.map((row) => row.textContent.toLowerCase());
  search.addEventListener("input", () => {
    const wanted = search.value.trim().toLowerCase();
    let found = 0;
    rows.forEach((row, place) => {
      const fits = texts[place].includes(wanted);
      row.classList.toggle("away", !fits);
      if (fits) found += 1;
    });
    counted(found);
  });
}

// Of all frames only those are elements that can be seen: a line of the text is "NUMBER\tLINE", "\tLINE" what follows it.
function listAll() {
  const steps = new Set(every.dataset.steps.split(","));
  const texts = {};
  let shown = [];
  let marked = "";
  function lines() {
    const lang = root.dataset.lang;
    if (!texts[lang]) {
      let number = "";
      texts[lang] = document.getElementById("every-" + lang).textContent.split("\n").filter(Boolean).map((line) => {
        const at = line.indexOf("\t");
        number = line.slice(0, at) || number;
        return { number, first: at > 0, text: line.slice(at + 1) };
      });
    }
    return texts[lang];
  }
  function scale() {
    return Math.max(1, (shown.length * ROW) / TALLEST);
  }
  function draw() {
    const top = Math.floor((every.scrollTop * scale()) / ROW);
    const rows = shown.slice(top, top + Math.ceil(every.clientHeight / ROW) + 2).map((line) => {
      const row = document.createElement("div");
      row.className = steps.has(line.number) ? "step" : "";
      if (line.number === marked) row.className += " goal";
      const number = document.createElement("span");
      number.className = "number";
      number.textContent = line.first ? "#" + line.number : "";
      const text = document.createElement("span");
      text.className = "line";
      text.textContent = line.text;
      text.title = line.text;
      row.append(number, text);
      return row;
    });
    const holder = document.getElementById("rows");
    holder.replaceChildren(...rows);
  }
  function select() {
    const wanted = search.value.trim().toLowerCase();
    const all = lines();
    if (wanted) {
      const fits = new Set();
      for (const line of all) if (("#" + line.number + " " + line.text).toLowerCase().includes(wanted)) fits.add(line.number);
      shown = all.filter((line) => fits.has(line.number));
      counted(fits.size);
    } else {
      shown = all;
      counted(0);
    }
    const sheet = document.getElementById("extent");
    sheet.style.height = Math.min(shown.length * ROW, TALLEST) + "px";
    draw();
  }
  function go(number) {
    search.value = "";
    marked = number;
    select();
    const place = shown.findIndex((line) => line.number === number);
    if (place >= 0) every.scrollTop = ((place - 5) * ROW) / scale();
    draw();
    every.scrollIntoView({ block: "nearest" });
  }
  every.addEventListener("scroll", draw);
  search.addEventListener("input", () => {
    every.scrollTop = 0;
    select();
  });
  select();
  return { go, again: select };
}

let list = null;
if (every) list = listAll();
else if (search) searchTable();

document.addEventListener("click", (event) => {
  const link = event.target.closest("a[href]");
  const goal = link ? link.getAttribute("href") : "";
  if (goal.startsWith("#problem-")) {
    event.preventDefault();
    open(goal.slice(1));
  } else if (goal.startsWith("#frame-") && list) {
    event.preventDefault();
    list.go(goal.slice(7));
  }
});
document.getElementById("language").addEventListener("click", () => {
  root.dataset.lang = root.dataset.lang === "zh" ? "en" : "zh";
  root.lang = root.dataset.lang;
  if (list) list.again();
});
document.getElementById("theme").addEventListener("click", () => {
  const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  root.dataset.theme = dark ? "light" : "dark";
});
if (problems.length) open(problems[0].id);
