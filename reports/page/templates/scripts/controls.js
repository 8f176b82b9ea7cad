// The stage's controls and keys.
function fillChoices() {
  const { scene, reference, name } = shown;
  const fill = (select, entries, value) => {
    const words = entries.map(([, text]) => text).join("\n");
    if (select.dataset.words !== words) {
      select.replaceChildren(...entries.map(([id, text]) => element("option", { value: id }, text)));
      select.dataset.words = words;
    }
    select.value = value;
  };
  const sign = { failed: "✗", passed: "✓", incomplete: "!", known: "≈" };
  const mark = (s, text) => `${sign[s] ?? "–"} ${text.length > 60 ? `${text.slice(0, 59)}…` : text}`;
  fill(one("#stage-scene"), comparable().map((s) => [s.id, mark(s.state, s.name)]), scene.id);
  fill(one("#stage-reference"), scene.references.map((r) => [r.name, mark(r.state, r.name)]), reference.name);
  fill(one("#stage-quantity"), Object.entries(reference.quantities).map(([q, entry]) => [q, `${mark(entry.state, q)}: ${entry.figure}`]), name);
}

function showControls() {
  for (const button of all("[data-mode]")) button.setAttribute("aria-pressed", button.dataset.mode === state.m);
  for (const box of all("[data-overlay]")) box.checked = shows(box.dataset.overlay);
  one("#stage-scale").value = state.d;
  one("#stage-scale-label").hidden = state.m !== "difference";
  one("#stage-cut-label").hidden = state.m !== "slider";
  one("#stage-hold").hidden = !["swap", "blink"].includes(state.m);
  one("#stage-hold").textContent = state.m === "blink" && !calm.matches ? "hold to see the reference" : "hold to see the reference (key x)";
}

const KEYS = {
  "?": () => one("#help").showModal(),
  "[": () => nextScene(-1), "]": () => nextScene(1),
  "+": () => zoom(1, center()), "=": () => zoom(1, center()), "-": () => zoom(-1), 0: () => change({ v: "" }),
};
MODES.forEach((mode, k) => { KEYS[k + 1] = () => change({ m: mode }); });

const center = () => picked()?.map((v) => v + 0.5) ?? null;
const ARROWS = { ArrowRight: [1, 0], ArrowDown: [0, 1], ArrowLeft: [-1, 0], ArrowUp: [0, -1] };

function typed(event) {
  const typing = event.target.closest("input:not([type=checkbox]), select, textarea, dialog");
  if (typing || event.ctrlKey || event.metaKey || event.altKey || !shown.scene) return;
  const arrow = ARROWS[event.key];
  if (arrow && event.target === canvas) {
    event.preventDefault();
    if (event.shiftKey) stepPixel(arrow);
    else nextCluster(arrow[0] + arrow[1]);
  } else if (event.key === "x") swap(true);
  else if (KEYS[event.key]) {
    event.preventDefault();
    KEYS[event.key]();
  }
}

function stepPixel([right, down]) {
  const { nx, ny } = shown.scene, [column, row] = picked() ?? [nx >> 1, ny >> 1];
  const to = [Math.min(nx - 1, Math.max(0, column + right)), Math.min(ny - 1, Math.max(0, row + down))];
  pick(...to);
  const { x, y, scale } = shown.view, pane = shown.panes[0];
  const outside = Math.abs(to[0] + 0.5 - x) > pane.width / scale / 2 || Math.abs(to[1] + 0.5 - y) > pane.height / scale / 2;
  if (outside) look(to[0] + 0.5, to[1] + 0.5, scale);
}

// Dragging pans; a click without it picks the pixel.
function startPointer() {
  let from = null, moved = false;
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    from = { x: event.offsetX, y: event.offsetY, x0: shown.view.x, y0: shown.view.y, scale: shown.view.scale };
    moved = false;
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!from) return;
    const dots = canvas.width / canvas.clientWidth;
    const [dx, dy] = [event.offsetX - from.x, event.offsetY - from.y].map((d) => (d * dots) / from.scale);
    moved ||= Math.hypot(event.offsetX - from.x, event.offsetY - from.y) > 4;
    if (moved) look(from.x0 - dx, from.y0 - dy, from.scale);
  });
  canvas.addEventListener("pointerup", (event) => {
    const spot = from && !moved ? under(event) : null;
    from = null;
    canvas.focus();
    if (spot?.pixel) pick(...spot.pixel);
  });
  canvas.addEventListener("wheel", (event) => {
    if (document.activeElement !== canvas) return;
    event.preventDefault();
    zoom(event.deltaY < 0 ? 1 : -1, under(event)?.place);
  }, { passive: false });
}

// Brings a check onto the stage, at its worst pixel where that is known.
function lookAt(s, r, q) {
  const entry = data.scenes.find((each) => each.id === s);
  const worst = entry.references.find((each) => each.name === r)?.worst.find((each) => each.quantity === q);
  change({ s, r, q, v: "", p: worst ? `${worst.column},${worst.row}` : "" });
  one("#stage").scrollIntoView();
  canvas.focus({ preventScroll: true });
}

function startControls() {
  const set = (id, key, also = {}) => one(id).addEventListener("change", (event) => change({ [key]: event.target.value, ...also }));
  set("#stage-scene", "s", { r: "", q: "", p: "", v: "" });
  set("#stage-reference", "r");
  set("#stage-quantity", "q");
  set("#stage-scale", "d");
  for (const button of all("[data-mode]")) button.addEventListener("click", () => change({ m: button.dataset.mode }));
  for (const box of all("[data-overlay]")) {
    box.addEventListener("change", () => change({ o: `${all("[data-overlay]").filter((b) => b.checked).map((b) => b.dataset.overlay).join("")}p` }));
  }
  for (const button of all("[data-key]")) button.addEventListener("click", () => KEYS[button.dataset.key]());
  for (const button of all("[data-cluster]")) button.addEventListener("click", () => nextCluster(Number(button.dataset.cluster)));
  one("#help-close").addEventListener("click", () => one("#help").close());
  one("#stage-cut").addEventListener("input", (event) => { shown.cut = event.target.value / 100; draw(); });
  const hold = one("#stage-hold");
  for (const [event, other] of [["pointerdown", true], ["pointerup", false], ["pointerleave", false]]) hold.addEventListener(event, () => swap(other));
  hold.addEventListener("keydown", (event) => { if (event.key === " " || event.key === "Enter") swap(true); });
  hold.addEventListener("keyup", () => swap(false));
  addEventListener("keydown", typed);
  addEventListener("keyup", (event) => { if (event.key === "x") swap(false); });
  startPointer();
  new ResizeObserver(() => { if (shown.loaded) draw(); }).observe(one("#stage-box"));
  calm.addEventListener("change", blink);
  for (const link of all("[data-look]")) link.addEventListener("click", () => lookAt(...JSON.parse(link.dataset.look)));
  for (const link of all("[data-of]")) {
    const place = [link.closest("details.scene").id, link.dataset.of, link.closest(".quantity").dataset.quantity];
    link.addEventListener("click", () => lookAt(...place));
  }
  on(["s", "r", "q"], showStage);
  on(["m", "d", "o", "v", "p"], draw);
  on(["m", "d", "o"], showControls);
  on(["m", "d", "o", "shown"], () => { if (shown.loaded) legend(); });
  on(["m"], blink);
  on(["shown"], showLists);
  on(["shown", "p"], inspect);
  startSpace();
  showControls();
}
