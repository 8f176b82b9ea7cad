// The comparison stage: one canvas, five modes, one zoom and pan for all; pixels square and sharp.
const MODES = ["swap", "slider", "blink", "side", "difference"];
const SCALES = [1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 24, 32, 48, 64];
const GAP = 8;
const canvas = one("#stage-canvas"), pen = canvas?.getContext("2d");
const shown = { scene: null, reference: null, name: "", loaded: null, first: null, objects: null,
  swapped: false, cut: 0.5, view: null, panes: [] };
const calm = matchMedia("(prefers-reduced-motion: reduce)");

function chosen() {
  const scene = data.scenes.find((each) => each.id === state.s) ?? firstScene();
  const reference = scene?.references.find((each) => each.name === state.r)
    ?? scene?.references.find((each) => each.full) ?? scene?.references[0];
  const names = reference ? Object.keys(reference.quantities) : [];
  const name = names.includes(state.q) ? state.q
    : names.find((each) => reference.quantities[each].state === "failed")
      ?? ["color", "normal", "depth"].find((each) => names.includes(each)) ?? names[0];
  return { scene, reference, name };
}

const comparable = () => data.scenes.filter((scene) => scene.references.length);
const firstScene = () => comparable().find((s) => s.references.some((r) => r.full)) ?? comparable()[0];

// The arrays stand at the page's end, so that all before them can be used while they are read.
const whole = new Promise((done) => {
  if (document.readyState !== "loading") done();
  else addEventListener("DOMContentLoaded", done);
});

let request = 0;
async function showStage() {
  const mine = ++request;
  await whole;
  const choice = chosen();
  if (!choice.scene) return;
  const { scene, reference, name } = choice;
  canvas.setAttribute("aria-busy", "true");
  const [found, first, objects] = await Promise.all(
    [load(scene, reference, name), firstStage(scene, reference), objectsOf(scene)]);
  if (mine !== request) return;  // something else was chosen meanwhile
  if (shown.scene !== scene) shown.view = null;
  Object.assign(shown, choice, { loaded: found, first, objects });
  fillChoices();
  draw();
  canvas.removeAttribute("aria-busy");
  tell(["shown"]);
}

// Where the image's pixels lie on the canvas.
function layout() {
  const { nx, ny } = shown.scene, dots = devicePixelRatio || 1;
  const box = one("#stage-box"), width = Math.round(box.clientWidth * dots);
  const most = Math.round(Math.max(320, innerHeight * 0.62) * dots);
  const split = state.m === "side", stacked = split && box.clientWidth < 560;
  const paneWidth = split && !stacked ? Math.floor((width - GAP) / 2) : width;
  const paneMost = stacked ? Math.floor((most - GAP) / 2) : most;
  const fit = Math.max(1, Math.floor(Math.min(paneWidth / nx, paneMost / ny)));
  const paneHeight = Math.min(paneMost, Math.max(ny * fit, Math.round((split ? 300 : 400) * dots)));
  const height = stacked ? 2 * paneHeight + GAP : paneHeight;
  const pane = (x, y) => ({ x, y, width: paneWidth, height: paneHeight });
  shown.panes = !split ? [pane(0, 0)] : stacked ? [pane(0, 0), pane(0, paneHeight + GAP)]
    : [pane(0, 0), pane(paneWidth + GAP, 0)];
  const [x, y, scale] = state.v.split(",").map(Number);
  shown.view = state.v && scale ? { x, y, scale } : { x: nx / 2, y: ny / 2, scale: fit };
  for (const each of shown.panes) {
    each.left = each.x + Math.round(each.width / 2 - shown.view.x * shown.view.scale);
    each.top = each.y + Math.round(each.height / 2 - shown.view.y * shown.view.scale);
  }
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  canvas.style.height = `${height / dots}px`;
}

function draw() {
  if (!shown.loaded || !one("#stage-box").clientWidth) return;
  layout();
  const { layers } = shown.loaded, [pane, second] = shown.panes;
  pen.setTransform(1, 0, 0, 1, 0, 0);
  pen.clearRect(0, 0, canvas.width, canvas.height);
  const other = shown.swapped;
  if (state.m === "side") {
    drawPane(pane, layers.ours);
    drawPane(second, layers.theirs);
  } else if (state.m === "difference") {
    drawPane(pane, layers[state.d] ?? layers.bands);
  } else if (state.m === "slider") {
    const cut = Math.round(pane.width * shown.cut);
    drawPane(pane, layers.ours, 0, cut);
    drawPane(pane, layers.theirs, cut, pane.width);
    pen.fillStyle = "#000";
    pen.fillRect(cut - 2, 0, 4, pane.height);
    pen.fillStyle = "#fff";
    pen.fillRect(cut - 1, 0, 2, pane.height);
  } else {
    drawPane(pane, other ? layers.theirs : layers.ours);
  }
  canvas.dataset.view = JSON.stringify({ ...shown.view, panes: shown.panes, mode: state.m });
  caption();
}

function drawPane(pane, layer, from = 0, to = pane.width) {
  const { scale } = shown.view, { factor } = shown.loaded;
  pen.save();
  pen.beginPath();
  pen.rect(pane.x + from, pane.y, to - from, pane.height);
  pen.clip();
  pen.imageSmoothingEnabled = false;
  pen.drawImage(layer, pane.left, pane.top, layer.width * factor * scale, layer.height * factor * scale);
  drawOverlays(pane);
  pen.restore();
}

function caption() {
  const { reference, name, loaded: { factor } } = shown;
  const theirs = reference.name, scaled = state.d === "bands" ? "in bands" : `signed, ${state.d === "log" ? "logarithmic" : "linear"}`;
  const what = {
    side: shown.panes[1]?.y ? `above minirt, below ${theirs}` : `left minirt, right ${theirs}`,
    difference: `error ÷ tolerance, ${scaled}`,
    slider: `left of the line minirt, right of it ${theirs}`,
    swap: shown.swapped ? theirs : "minirt",
    blink: shown.swapped ? theirs : "minirt",
  }[state.m];
  one("#stage-caption").textContent = `${name}: ${what}`;
  const check = reference.quantities[name];
  const wrong = check.wrong ? `${counted(check.wrong, "wrong pixel")}` : `${check.state}, ${check.figure}`;
  canvas.setAttribute("aria-label", `${shown.scene.name}, ${name}, minirt and ${theirs}: ${wrong}`);
  one("#stage-note").textContent = factor > 1
    ? `Small pictures: one pixel in ${factor} × ${factor}, none mixed; of error ÷ tolerance the largest.`
    : shown.loaded.ratio ? "" : "Pictures only: the values of what passes are not kept on this page.";
}

function zoom(step, at = null) {
  const { view } = shown, here = SCALES.findIndex((scale) => scale >= view.scale);
  const scale = SCALES[Math.min(SCALES.length - 1, Math.max(0, here + step))];
  const to = at ?? [view.x, view.y];
  const share = 1 - view.scale / scale;
  look(view.x + (to[0] - view.x) * share, view.y + (to[1] - view.y) * share, scale);
}

function look(x, y, scale) {
  const { nx, ny } = shown.scene;
  const inside = (value, most) => Math.round(100 * Math.min(most, Math.max(0, value))) / 100;
  change({ v: [inside(x, nx), inside(y, ny), scale].join(",") });
}

// The image's pixel under a place on the canvas, and the place in image coordinates.
function under(event) {
  const dots = canvas.width / canvas.clientWidth;
  const x = event.offsetX * dots, y = event.offsetY * dots;
  const pane = shown.panes.find((p) => x >= p.x && x < p.x + p.width && y >= p.y && y < p.y + p.height);
  if (!pane) return null;
  const place = [(x - pane.left) / shown.view.scale, (y - pane.top) / shown.view.scale];
  const [column, row] = place.map(Math.floor);
  const inside = column >= 0 && row >= 0 && column < shown.scene.nx && row < shown.scene.ny;
  return { place, pixel: inside ? [column, row] : null };
}

function pick(column, row, center = false) {
  change({ p: `${column},${row}` });
  if (center) look(column + 0.5, row + 0.5, Math.max(shown.view.scale, 8));
}

let blinking = 0;
function blink() {
  clearInterval(blinking);
  shown.swapped = false;
  if (state.m !== "blink" || calm.matches) return;
  blinking = setInterval(() => { shown.swapped = !shown.swapped; draw(); }, 700);
}

function swap(other) {
  if (!["swap", "blink"].includes(state.m) || shown.swapped === other) return;
  shown.swapped = other;
  draw();
}
