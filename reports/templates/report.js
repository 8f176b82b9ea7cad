"use strict";
const one = (selector) => document.querySelector(selector);
const all = (selector) => [...document.querySelectorAll(selector)];
const wanted = one("#filter"), onlyFailed = one("#only-failed"), shown = one("#shown");

function filter() {
  const words = wanted.value.toLowerCase().split(/\s+/).filter(Boolean);
  const fits = (part) =>
    words.every((word) => part.dataset.search.includes(word)) &&
    !(onlyFailed.checked && ["passed", "not compared"].includes(part.dataset.state));
  for (const part of all("[data-search]")) part.hidden = !fits(part);
  const scenes = all("details.scene");
  shown.textContent = `${scenes.filter((s) => !s.hidden).length} of ${scenes.length} scenes shown`;
}

function openTarget() {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  const scene = target && target.closest("details.scene");
  if (!scene) return;
  scene.hidden = false;
  scene.open = true;
  target.scrollIntoView();
}

function enlarge(entry) {
  const large = entry.querySelector(".small").classList.toggle("large");
  entry.querySelector(".larger").setAttribute("aria-pressed", large);
}

function hint() {
  for (const scroller of all(".scroller")) {
    const { scrollLeft, clientWidth, scrollWidth } = scroller.firstElementChild;
    scroller.classList.toggle("more", scrollLeft + clientWidth < scrollWidth - 2);
  }
}

wanted.addEventListener("input", filter);
onlyFailed.addEventListener("change", filter);
one("#open-all").addEventListener("click", () => {
  const scenes = all("details.scene:not([hidden])");
  const open = scenes.some((scene) => !scene.open);
  for (const scene of scenes) scene.open = open;
});
addEventListener("click", (event) => {
  const entry = event.target.closest(".larger, .small .pic")?.closest(".entry");
  if (entry) enlarge(entry);
});
for (const scroller of all(".scroller")) scroller.firstElementChild.addEventListener("scroll", hint);
for (const button of all(".larger")) button.hidden = false;
addEventListener("resize", hint);
addEventListener("hashchange", openTarget);
one(".tools").hidden = false;
filter();
hint();
openTarget();
