// What lies over the pictures, by its letter in the state: u uncertain pixels hatched, w wrong ones
// outlined, o objects, f first wrong stages, p the picked pixel.
const shows = (letter) => state.o.includes(letter);

function drawOverlays(pane) {
  const { loaded: { ratio }, first, objects } = shown, visible = visibleIn(pane);
  if (shows("f") && first) drawStages(pane, visible, first);
  if (shows("u") && ratio) drawHatch(pane, visible, ratio);
  if (shows("o") && objects) drawObjects(pane, visible, objects);
  if (shows("w") && ratio) drawWrong(pane, visible, ratio);
  if (shows("p") && picked()) drawPicked(pane);
}

function visibleIn(pane) {
  const { nx, ny } = shown.scene, { scale } = shown.view;
  const from = (start, corner) => Math.max(0, Math.floor((start - corner) / scale));
  const to = (end, corner, most) => Math.min(most, Math.ceil((end - corner) / scale));
  return {
    left: from(pane.x, pane.left), right: to(pane.x + pane.width, pane.left, nx),
    top: from(pane.y, pane.top), bottom: to(pane.y + pane.height, pane.top, ny),
  };
}

// Adds the square of each visible pixel that `fits`, grown by `rim` dots, to a path.
function squares(path, pane, visible, fits, rim = 0) {
  const { nx } = shown.scene, { scale } = shown.view;
  for (let row = visible.top; row < visible.bottom; row++) {
    for (let column = visible.left; column < visible.right; column++) {
      if (fits(row * nx + column)) {
        path.rect(pane.left + column * scale - rim, pane.top + row * scale - rim,
          scale + 2 * rim, scale + 2 * rim);
      }
    }
  }
  return path;
}

let stripes = null;
function hatch() {
  if (stripes) return stripes;
  const tile = element("canvas", { width: 8, height: 8 }), ink = tile.getContext("2d");
  ink.fillStyle = data.hatch[1];
  ink.fillRect(0, 0, 8, 8);
  ink.strokeStyle = data.hatch[0];
  ink.lineWidth = 3;
  ink.beginPath();
  for (const shift of [-8, 0, 8]) {
    ink.moveTo(shift - 2, 10);
    ink.lineTo(shift + 10, -2);
  }
  ink.stroke();
  stripes = pen.createPattern(tile, "repeat");
  return stripes;
}

function drawHatch(pane, visible, ratio) {
  pen.fillStyle = hatch();
  pen.fill(squares(new Path2D(), pane, visible, (i) => Number.isNaN(ratio[i])));
}

// A line around wrong pixels, clear of them: one wrong pixel shows however small it is drawn.
function drawWrong(pane, visible, ratio) {
  const wrong = (i) => Math.abs(ratio[i]) > 1;
  const veil = element("canvas", { width: canvas.width, height: canvas.height });
  const ink = veil.getContext("2d"), dots = Math.max(1, Math.round(devicePixelRatio));
  ink.fillStyle = data.ring;
  ink.fill(squares(new Path2D(), pane, visible, wrong, 4 * dots));
  ink.globalCompositeOperation = "destination-out";
  ink.fill(squares(new Path2D(), pane, visible, wrong, 2 * dots));
  pen.drawImage(veil, 0, 0);
}

function drawStages(pane, visible, first) {
  for (const [number] of stagesPresent(first)) {
    pen.fillStyle = data.stageColors[number];
    pen.fill(squares(new Path2D(), pane, visible, (i) => first[i] === number));
  }
}

function stagesPresent(first) {
  const counts = new Map();
  for (const number of first) if (number >= 0) counts.set(number, (counts.get(number) ?? 0) + 1);
  return [...counts].sort((a, b) => a[0] - b[0]);
}

function drawObjects(pane, visible, objects) {
  const { nx } = shown.scene, { scale } = shown.view, middles = new Map();
  const border = new Path2D();
  for (let row = visible.top; row < visible.bottom; row++) {
    for (let column = visible.left; column < visible.right; column++) {
      const i = row * nx + column, x = pane.left + column * scale, y = pane.top + row * scale;
      if (column + 1 < nx && objects[i] !== objects[i + 1]) border.rect(x + scale - 1, y, 1, scale);
      if (i + nx < objects.length && objects[i] !== objects[i + nx]) border.rect(x, y + scale - 1, scale, 1);
      const sum = middles.get(objects[i]) ?? [0, 0, 0];
      middles.set(objects[i], [sum[0] + x, sum[1] + y, sum[2] + 1]);
    }
  }
  pen.fillStyle = "#ffffff";
  pen.fill(border);
  const size = Math.round(12 * devicePixelRatio);
  pen.font = `600 ${size}px system-ui, sans-serif`;
  pen.lineWidth = 3;
  pen.strokeStyle = "#000000";
  for (const [index, [x, y, n]] of middles) {
    if (index < 0 || n * scale * scale < 4 * size * size) continue;
    pen.strokeText(index, x / n, y / n);
    pen.fillText(index, x / n, y / n);
  }
}

function drawPicked(pane) {
  const [column, row] = picked(), { scale } = shown.view;
  const x = pane.left + column * scale, y = pane.top + row * scale, rim = 1;
  for (const [color, more] of [["#000000", 3], ["#ffffff", rim]]) {
    pen.strokeStyle = color;
    pen.lineWidth = 2;
    pen.strokeRect(x - more, y - more, scale + 2 * more, scale + 2 * more);
  }
}

// What the colours and lines stand for, in words.
function legend() {
  const box = one("#stage-legend"), { name, loaded: { arrays, ratio }, reference } = shown;
  const quantity = data.quantities[name], parts = [];
  const swatch = (color, words) => element("span", { className: "key" },
    color && element("span", { className: "swatch", style: `background:${color}` }), words);
  if (state.m === "difference") parts.push(differenceLegend(Boolean(ratio)));
  else if (quantity.legend.length) parts.push(...quantity.legend.map(([c, words]) => swatch(c, words)));
  else if (quantity.components === 1) {
    const picture = reference.quantities[name].picture;
    const [low, high] = arrays ? [arrays.low[0], arrays.high[0]] : [picture.low, picture.high];
    parts.push(element("span", { className: "key" }, spelled(low, 3), element("span", { className: "scale" }),
      `${picture.clipped ? "≥ " : ""}${spelled(high, 3)}`));
  }
  if (shows("u") && ratio) {
    const key = swatch(null, "uncertain: not judged");
    key.prepend(element("span", { className: "swatch hatched", style: `--a:${data.hatch[0]};--b:${data.hatch[1]}` }));
    parts.push(key);
  }
  if (shows("w") && ratio) {
    const key = swatch(null, "around wrong pixels");
    key.prepend(element("span", { className: "swatch", style: `border:3px solid ${data.ring}` }));
    parts.push(key);
  }
  if (shows("f") && shown.first) {
    parts.push(...stagesPresent(shown.first).map(([number, n]) =>
      swatch(data.stageColors[number], `first wrong in ${data.stages[number]}: ${n} px`)));
  }
  box.replaceChildren(...parts);
}

function differenceLegend(signed) {
  if (state.d === "bands" || !signed) {
    const words = [...data.bounds.map((b) => (b > 0 && b < 1 ? `1/${1 / b}` : `${b}`)), "∞"];
    return element("span", { className: "bands", role: "img", "aria-label": `Bands of error over tolerance, up to ${words.join(", ")}` },
      ...words.map((word, k) => element("span", { style: `--c:${data.bands[k]}`, className: word === "1" ? "one" : "" }, word)));
  }
  const ticks = TICKS[state.d], spots = Array.from({ length: 33 }, (_, k) => k / 16 - 1);
  const color = differenceColor(state.d), most = ticks.at(-1);
  const back = (place) => (state.d === "linear" ? 4 * place
    : Math.sign(place) * ((1 + 4 * most) ** Math.abs(place) - 1) / 4);
  const stops = spots.map((place) => `rgb(${color([back(place)]).join(" ")})`).join(", ");
  const marks = ticks.map((tick) => element("span", { className: Math.abs(tick) === 1 ? "tick one" : "tick",
    style: `left:${50 + 50 * signedPlace(tick, state.d)}%` }, tick < 0 ? `−${-tick}` : `${tick}`));
  const words = data.quantities[shown.name].components > 1 || data.quantities[shown.name].discrete
    ? "size only: it has no sign" : "theirs too small … too large";
  return element("span", { className: "key" }, element("span", { className: "signed", role: "img",
    "aria-label": `Signed error over tolerance from ${ticks[0]} to ${most}; 1 is the tolerance`,
    style: `--stops:${stops}` }, ...marks), words);
}
