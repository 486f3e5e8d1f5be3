"use strict";
const root = document.documentElement;
const stories = [...document.querySelectorAll(".story")];
const links = [...document.querySelectorAll("nav a")];
function open(id) {
  for (const story of stories) story.classList.toggle("open", story.id === id);
  for (const link of links) link.classList.toggle("here", link.getAttribute("href") === "#" + id);
}
for (const link of links) {
  link.addEventListener("click", (event) => {
    event.preventDefault();
    open(link.getAttribute("href").slice(1));
  });
}
if (stories.length) open(stories[0].id);
document.getElementById("language").addEventListener("click", () => {
  root.dataset.lang = root.dataset.lang === "zh" ? "en" : "zh";
  root.lang = root.dataset.lang;
});
document.getElementById("theme").addEventListener("click", () => {
  const dark = root.dataset.theme ? root.dataset.theme === "dark" : matchMedia("(prefers-color-scheme: dark)").matches;
  root.dataset.theme = dark ? "light" : "dark";
});
const search = document.getElementById("search");
if (search) {
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
    document.getElementById("found").textContent = wanted ? String(found) : "";
  });
}
