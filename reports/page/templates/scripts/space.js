// One pixel in space, drawn by hand: the virtual screen, the pixel's rays, the objects as wires.
const KINDS = {
  ray: { color: "--wire-ray", dash: [], words: "ray" }, normal: { color: "--wire-normal", dash: [2, 3], words: "normal" },
  shadow: { color: "--wire-shadow", dash: [10, 4], words: "shadow ray" },
  reflected: { color: "--wire-reflected", dash: [6, 3, 2, 3], words: "reflected ray" },
  refracted: { color: "--wire-refracted", dash: [14, 3, 3, 3], words: "refracted ray" },
};
const space = { shown: null, turn: 0.6, tilt: 0.35, away: 1, center: [0, 0, 0], size: 1 };
const plus = (a, b, t = 1) => a.map((x, k) => x + t * b[k]);
const minus = (a, b) => a.map((x, k) => x - b[k]);
const across = ([a, b, c], [x, y, z]) => [b * z - c * y, c * x - a * z, a * y - b * x];
const length = (a) => Math.hypot(...a);
const scaled = (a, to = 1) => a.map((x) => (x * to) / (length(a) || 1));
const inner = (a, b) => a.reduce((sum, x, k) => sum + x * b[k], 0);

function showSpace(given) {
  const section = one("#space");
  section.hidden = !given;
  space.shown = given;
  if (!given) return;
  const lines = given.explanation.lines.map(({ kind, start, direction, length: far, meets }) => ({ kind, start, direction, far, meets }));
  const { P0, screen, objects } = given.space;
  const hit = lines[1]?.start ?? plus(P0, lines[0].direction);
  const near = objects.filter((o) => o.center).map((o) => length(minus(o.center, hit)) + o.radius);
  space.size = Math.max(length(minus(hit, P0)), ...screen.map((c) => length(minus(c, P0))), Math.min(...near, Infinity) === Infinity ? 0 : Math.min(...near));
  space.center = plus(P0, minus(hit, P0), 0.6);
  const up = scaled(minus(screen[3], screen[0])), plane = scaled(across(minus(screen[1], screen[0]), up));
  const back = scaled(plane, inner(plane, minus(P0, screen[0])) < 0 ? -1 : 1);
  Object.assign(space, { lines, hit, up, back, right: across(up, back), turn: 0.7, tilt: 0.35, away: 1 });
  one("#space-table").replaceChildren(spaceTable(given, lines));
  drawSpace();
}

function spaceTable({ space: { P0, screen, objects } }, lines) {
  const point = (p) => element("td", { className: "num" }, p.map((x) => spelled(x, 6)).join(", "));
  const row = (words, start, end, meets) => element("tr", {}, element("th", { scope: "row" }, words), point(start), end ? point(end) : element("td", {}, "–"), element("td", {}, meets));
  const rows = [row("observer P0", P0, null, "")];
  screen.forEach((corner, k) => rows.push(row(`screen, corner ${k + 1}`, corner, null, "")));
  for (const { kind, start, direction, far, meets } of lines) {
    const words = far === null ? (meets ? `${meets}; shown is a unit further` : "unit length") : `${meets}, ${spelled(far, 6)} away`;
    rows.push(row(KINDS[kind].words, start, plus(start, direction, far ?? 1), words));
  }
  for (const o of objects) {
    const left = o["left out"] ? `; ${o["left out"]} edges not drawn` : "";
    rows.push(element("tr", {}, element("th", { scope: "row" }, `${o.type} '${o.name}'`), o.center ? point(o.center) : point(o.vertices[0] ?? [0, 0, 0]),
      element("td", {}, o.center ? `radius ${spelled(o.radius, 6)}` : `first of ${counted(o.vertices.length, "corner")}`), element("td", {}, `${o.edges ? counted(o.edges.length, "edge") : "centre"}${left}`)));
  }
  return table("Coordinates of what is drawn", ["what", "from", "to", "meets"], rows);
}

// From the world to the canvas; null behind the eye.
function projector(width, height) {
  const { turn, tilt, away, up, right, back, center, size } = space;
  const [ct, st, cp, sp] = [Math.cos(turn), Math.sin(turn), Math.cos(tilt), Math.sin(tilt)];
  const backward = plus(plus(scaled(back, ct * cp), scaled(right, st * cp)), scaled(up, sp));
  const x = scaled(across(up, backward)), y = across(backward, x);
  const eye = plus(center, backward, 2.2 * size * away), focus = 1.25 * Math.min(width, height * 1.3);
  return { eye, backward, near: 0.02 * size * away, at(p) {
    const d = minus(p, eye), depth = -inner(d, backward);
    return [width / 2 + (focus * inner(d, x)) / depth, height / 2 - (focus * inner(d, y)) / depth];
  }, depth: (p) => -inner(minus(p, eye), backward) };
}

function drawSpace() {
  const view = one("#space-canvas"), dots = devicePixelRatio || 1;
  if (!space.shown || !view.clientWidth) return;
  Object.assign(view, { width: Math.round(view.clientWidth * dots), height: Math.round(view.clientHeight * dots) });
  const ink = view.getContext("2d"), style = getComputedStyle(view), project = projector(view.width, view.height);
  const css = (name) => style.getPropertyValue(name).trim();
  const stroke = (points, color, width, dash = [], close = false) => {
    ink.strokeStyle = color;
    ink.lineWidth = width * dots;
    ink.setLineDash(dash.map((d) => d * dots));
    const ends = close ? [...points, points[0]] : points;
    ink.beginPath();
    for (let k = 1; k < ends.length; k++) {
      const part = clipped(ends[k - 1], ends[k], project);
      if (part) {
        ink.moveTo(...project.at(part[0]));
        ink.lineTo(...project.at(part[1]));
      }
    }
    ink.stroke();
  };
  ink.clearRect(0, 0, view.width, view.height);
  const { P0, screen, objects } = space.shown.space;
  objects.forEach((o) => drawObject(o, stroke, css, project));
  stroke(screen, css("--wire-screen"), 2, [], true);
  screen.forEach((corner) => stroke([P0, corner], css("--wire-screen"), 0.7, [3, 4]));
  for (const { kind, start, direction, far } of space.lines) {
    const reach = kind === "normal" ? 0.12 * space.size : far ?? 0.9 * space.size;
    const end = plus(start, direction, reach), { color, dash } = KINDS[kind];
    stroke([start, end], css(color), kind === "ray" ? 3 : 2.2, dash);
    label(ink, project, plus(start, direction, reach * (kind === "ray" ? 0.55 : 0.75)), KINDS[kind].words, css(color), css("--card"), dots);
  }
  dot(ink, project, P0, css("--ink"), dots);
  label(ink, project, P0, "P0", css("--ink"), css("--card"), dots);
  if (space.lines.length > 1) dot(ink, project, space.hit, css("--wire-ray"), dots);
}

function clipped(a, b, { depth, near }) {
  const da = depth(a) - near, db = depth(b) - near;
  if (da < 0 && db < 0) return null;
  if (da >= 0 && db >= 0) return [a, b];
  const cut = plus(a, minus(b, a), da / (da - db));
  return da < 0 ? [cut, b] : [a, cut];
}

function drawObject(o, stroke, css, project) {
  const color = css("--wire");
  if (!o.center) {
    for (const [a, b] of o.edges) stroke([o.vertices[a], o.vertices[b]], color, o.edges.length > 60 ? 0.6 : 1.3);
    return;
  }
  const axes = [[0, 1], [1, 2], [0, 2]].map(([i, j]) => [0, 1, 2].map((k) => [k === i ? 1 : 0, k === j ? 1 : 0]));
  const away = scaled(minus(project.eye, o.center)), side = scaled(across(away, Math.abs(away[1]) < 0.9 ? [0, 1, 0] : [1, 0, 0]));
  const rim = [side, across(away, side)];
  const round = (u, v) => Array.from({ length: 49 }, (_, k) => plus(plus(o.center, u, o.radius * Math.cos((k * Math.PI) / 24)), v, o.radius * Math.sin((k * Math.PI) / 24)));
  for (const axis of axes) stroke(round(axis.map((p) => p[0]), axis.map((p) => p[1])), color, 0.7);
  stroke(round(...rim), color, 1.5);
}

function dot(ink, project, point, color, dots) {
  if (project.depth(point) < project.near) return;
  ink.fillStyle = color;
  ink.beginPath();
  ink.arc(...project.at(point), 4 * dots, 0, 2 * Math.PI);
  ink.fill();
}

function label(ink, project, point, words, color, halo, dots) {
  if (project.depth(point) < project.near) return;
  const [x, y] = project.at(point);
  ink.font = `${12 * dots}px system-ui, sans-serif`;
  ink.setLineDash([]);
  ink.lineWidth = 4 * dots;
  ink.strokeStyle = halo;
  ink.strokeText(words, x + 6 * dots, y - 6 * dots);
  ink.fillStyle = color;
  ink.fillText(words, x + 6 * dots, y - 6 * dots);
}

function turnSpace(turn, tilt, away = 1) {
  space.turn += turn;
  space.tilt = Math.min(1.55, Math.max(-1.55, space.tilt + tilt));
  space.away = Math.min(8, Math.max(0.05, space.away * away));
  drawSpace();
}

function startSpace() {
  const view = one("#space-canvas"), keys = {
    ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1],
    "+": [0, 0, 0.85], "=": [0, 0, 0.85], "-": [0, 0, 1.18],
  };
  view.addEventListener("keydown", (event) => {
    if (event.key === "0") Object.assign(space, { turn: 0.7, tilt: 0.35, away: 1 });
    else if (!keys[event.key]) return;
    event.preventDefault();
    event.stopPropagation();
    turnSpace(...(keys[event.key] ?? [0, 0]));
  });
  view.addEventListener("pointerdown", (event) => { view.setPointerCapture(event.pointerId); view.focus(); });
  view.addEventListener("pointermove", (event) => {
    if (view.hasPointerCapture(event.pointerId)) turnSpace(-event.movementX * 0.01, event.movementY * 0.01);
  });
  view.addEventListener("wheel", (event) => {
    if (document.activeElement !== view) return;
    event.preventDefault();
    turnSpace(0, 0, event.deltaY > 0 ? 1.1 : 0.9);
  }, { passive: false });
  for (const button of all("[data-turn]")) button.addEventListener("click", () => turnSpace(...button.dataset.turn.split(" ").map(Number)));
  new ResizeObserver(drawSpace).observe(view);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", drawSpace);
}
