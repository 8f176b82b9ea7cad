// Which scenes are shown, and in which order: text, chips, sorting; sections that are open.
const sections = all("details.scene"), groups = all("tbody[data-search]");
const openAtFirst = new Set(sections.filter((section) => section.open).map((section) => section.id));
const listed = new Map([...sections, ...groups].map((part, k) => [part, k]));
const onlys = () => state.only.split(",").filter(Boolean);

function filter() {
  const words = state.f.toLowerCase().split(/\s+/).filter(Boolean);
  const fits = (part) => words.every((word) => part.dataset.search.includes(word))
    && onlys().every((tag) => part.dataset.tags.split(" ").includes(tag));
  for (const part of [...sections, ...groups]) part.hidden = !fits(part);
  const open = sections.filter((section) => !section.hidden).length;
  one("#shown").textContent = `${open} of ${sections.length} scenes shown`;
  one("#filter").value = state.f;
  for (const chip of all("[data-only]")) chip.setAttribute("aria-pressed", onlys().includes(chip.dataset.only));
}

function sort() {
  const worst = (part) => Number(part.dataset.worst);
  const orders = {
    "": (a, b) => listed.get(a) - listed.get(b),
    worst: (a, b) => (worst(b) === worst(a) ? 0 : worst(b) - worst(a)) || listed.get(a) - listed.get(b),
    certain: (a, b) => a.dataset.certain - b.dataset.certain || listed.get(a) - listed.get(b),
    name: (a, b) => (a.dataset.name < b.dataset.name ? -1 : 1),
  };
  for (const parts of [sections, groups]) {
    if (parts.length) parts[0].parentElement.append(...[...parts].sort(orders[state.sort] ?? orders[""]));
  }
  one("#sort").value = state.sort;
}

// Sections are open as the run left them, but for those named in the state.
function openSections() {
  const turned = new Set(state.open.split(",").filter(Boolean));
  for (const section of sections) section.open = openAtFirst.has(section.id) !== turned.has(section.id);
}

function noteOpen() {
  const turned = sections.filter((section) => section.open !== openAtFirst.has(section.id));
  change({ open: turned.map((section) => section.id).join(",") });
}

function goTo() {
  const target = state.at && document.getElementById(state.at);
  if (!target) return;
  const scene = target.closest("details.scene");
  if (scene) {
    scene.hidden = false;
    scene.open = true;
  }
  target.scrollIntoView();
}

function startFilter() {
  one("#filter").addEventListener("input", (event) => change({ f: event.target.value }));
  one("#sort").addEventListener("change", (event) => change({ sort: event.target.value }));
  for (const chip of all("[data-only]")) {
    chip.addEventListener("click", () => {
      const tag = chip.dataset.only, before = onlys();
      change({ only: (before.includes(tag) ? before.filter((each) => each !== tag) : [...before, tag]).join(",") });
    });
  }
  for (const section of sections) section.addEventListener("toggle", noteOpen);
  one("#open-all").addEventListener("click", () => {
    const visible = sections.filter((section) => !section.hidden);
    const open = visible.some((section) => !section.open);
    for (const section of visible) section.open = open;
  });
  on(["f", "only"], filter);
  on(["sort"], sort);
  on(["at"], goTo);
}
