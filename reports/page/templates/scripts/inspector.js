// The pixel inspector: the values of all references at one pixel, and the algorithm's own steps there.
// The pixel in the state, or else the worst one of what is shown.
function picked() {
  if (state.p) return state.p.split(",").map(Number);
  const worst = shown.reference?.worst ?? [];
  const each = worst.find((wrong) => wrong.quantity === shown.name) ?? worst[0];
  return each ? [each.column, each.row] : null;
}

// [ours, theirs, tolerance, ratio, digits] of one quantity, from the exact rows or from the arrays.
function valuesAt(name, rows, found, index) {
  const row = rows?.[name];
  if (row) {
    const [ours, theirs, tolerance, ratio] = row.map((v) => (Array.isArray(v) ? v.map(finite) : finite(v)));
    return { ours, theirs, tolerance, ratio, digits: 0 };
  }
  if (!found?.ratio) return null;
  const { arrays } = found, at = (planes) => planes.map((plane) => plane[index]);
  return {
    ours: at(found.ours), theirs: at(found.theirs), ratio: Math.abs(found.ratio[index]),
    tolerance: found.tolerance ? found.tolerance[index] : 0, about: true,
    digits: [arrays.ours.exact ? 0 : 8, arrays.theirs.exact ? 0 : 8],
  };
}

function vectorCell(values, digits, name) {
  const whole = data.quantities[name].discrete;
  const words = values.map((v) => (whole ? String(Number(v)) : spelled(v, digits)));
  return element("td", { className: "num" }, ...words.map((word) => element("span", {}, `${digits && /[0-9]/.test(word) ? "≈ " : ""}${word}`)));
}

function verdictCell(name, ratio) {
  const [state_, words] = Number.isNaN(ratio) ? ["none", "? uncertain"] : ratio > 1
    ? ["failed", `✗ ${times(ratio)}`] : ["passed", `✓ ${data.quantities[name].discrete ? "equal" : times(ratio)}`];
  return element("td", { className: state_ }, words);
}

function valueRow(head, name, values) {
  if (!values) return element("tr", {}, element("th", { scope: "row" }, head), element("td", { colSpan: 4, className: "soft" }, "not kept on this page"));
  const [a, b] = Array.isArray(values.digits) ? values.digits : [values.digits, values.digits];
  const tolerance = data.quantities[name].discrete ? "equal" : spelled(values.tolerance, values.about ? 2 : 3);
  return element("tr", { "data-quantity": name }, element("th", { scope: "row" }, head), verdictCell(name, values.ratio),
    vectorCell(values.ours, a, name), vectorCell(values.theirs, b, name), element("td", { className: "num" }, tolerance));
}

let asked = 0;
async function inspect() {
  const mine = ++asked, { scene, reference } = shown, pixel = picked();
  const box = one("#inspector-body");
  if (!scene) return;
  if (!pixel || !(pixel[0] < scene.nx && pixel[1] < scene.ny)) {
    box.replaceChildren(element("p", { className: "soft" },
      "No pixel is picked. Click one, or choose a cluster or one of the explained pixels."), explainedPixels(scene));
    showSpace(null);
    return;
  }
  const [column, row] = pixel, index = row * scene.nx + column, key = pixel.join(",");
  const kept = await more(scene), names = Object.keys(reference.quantities);
  const found = await Promise.all(names.map((name) => (reference.quantities[name].arrays ? load(scene, reference, name) : null)));
  const first = await firstStage(scene, reference);
  if (mine !== asked) return;
  const opinion = kept.rows[reference.name]?.[key], explanation = kept.explanations[key];
  const rows = names.map((name, k) => valueRow(name, name, valuesAt(name, opinion?.rows, found[k], index)));
  const parts = [
    element("h3", {}, `Pixel (${column}, ${row})`, element("span", { className: "soft" }, " column from the left, row from the top")),
    element("p", { id: "sentence" }, opinion?.sentence ?? plainSentence(reference, first, index)),
    buttons(scene, reference, column, row),
    element("div", { className: "wide values", tabIndex: 0, role: "region", "aria-label": "Values at the pixel" },
      withHeads(table(`Values at (${column}, ${row})`, ["quantity", "error ÷ tol.", "minirt", reference.name, "tolerance"], rows))),
    await everyReference(scene, kept, key, index),
  ];
  if (mine !== asked) return;
  if (rows.every((each) => each.children.length < 3)) parts.push(notKept(scene));
  parts.push(explanation ? element("section", {}, element("h4", {}, "How minirt computes it, step by step"), element("div",
    { className: "wide tall", tabIndex: 0, role: "region", "aria-label": "Steps of the algorithm" }, stepList(explanation)))
    : element("p", { className: "soft" }, "The algorithm's steps are kept for some pixels only; for this one the command above prints them."));
  parts.push(explainedPixels(scene, !explanation));
  box.replaceChildren(...parts);
  box.dataset.shows = [scene.id, reference.name, shown.name, key].join(" ");
  showSpace(explanation ? { space: kept.space, explanation } : null);
}

const withHeads = (made) => { made.className = "plain values"; return made; };

function notKept(scene) {
  return element("p", {}, scene.state === "passed"
    ? "This scene passes: the page keeps its pictures, and the values of the explained pixels below only. The command above shows this pixel."
    : "No values of this pixel are kept on this page: the command above shows them.");
}

function plainSentence(reference, first, index) {
  if (!first) return reference.clusters.length || reference.full ? "" : `${reference.name} passes on this scene.`;
  return first[index] < 0 ? `${reference.name} has no wrong value here.`
    : `The first wrong stage is ${data.stages[first[index]]}.`;
}

// Who says what of the chosen quantity at this pixel.
async function everyReference(scene, kept, key, index) {
  const name = shown.name, rows = [];
  for (const reference of scene.references) {
    const entry = reference.quantities[name];
    if (!entry) continue;
    const found = entry.arrays ? await load(scene, reference, name) : null;
    rows.push(valueRow(reference.name, name, valuesAt(name, kept.rows[reference.name]?.[key]?.rows, found, index)));
  }
  return element("section", {}, element("h4", {}, `${name} by every reference`), element("div",
    { className: "wide values", tabIndex: 0, role: "region", "aria-label": `${name} by every reference at the pixel` },
    withHeads(table(`${name} by reference`, ["reference", "error ÷ tol.", "minirt", "theirs", "tolerance"], rows))));
}

function buttons(scene, reference, column, row) {
  const filled = (text) => text.replaceAll("COLUMN", column).replaceAll("ROW", row);
  const command = filled(scene.command);
  const ask = element("button", { type: "button", onclick: () => copy(command, ask) }, "copy the command");
  const test = element("button", { type: "button", onclick: () => copy(filled(reference.test), test) }, "copy as a test");
  return element("div", { className: "again" }, element("code", { id: "command" }, command), ask, test);
}

function explainedPixels(scene, open = true) {
  const links = scene.pixels.map(([column, row]) => element("button",
    { type: "button", className: "pixel", onclick: () => pick(column, row, true) }, `(${column}, ${row})`));
  return element("details", { open }, element("summary", {}, `${counted(links.length, "pixel")} of this scene explained step by step`), element("div", { className: "pixels" }, ...links));
}

// The algorithm's own steps at a pixel, as `minirt explain` has them; nothing is computed here.
function stepList(explanation) {
  return element("ol", { className: "steps" }, ...explanation.steps.map((step) => element("li", {},
    element("h5", {}, element("span", { className: "rule" }, step.rule), ` ${step.title}`),
    element("p", {}, step.sentence),
    element("dl", {}, ...Object.entries(step.values).flatMap(([name, value]) => [
      element("dt", {}, name), element("dd", { className: "num" }, stepValue(value))])))));
}

function stepValue(value) {
  if (Array.isArray(value)) return value.map((each) => spelled(each, 12)).join("  ");
  if (typeof value === "boolean") return value ? "yes" : "no";
  return typeof value === "number" ? spelled(value) : ["inf", "-inf", "nan"].includes(value) ? spelled(value) : value ?? "none";
}
