// The algorithm's own steps at a pixel, as `minirt explain` has them; nothing is computed here.
function stepList(story) {
  return element("ol", { className: "steps" }, ...story.steps.map((step) => element("li", {},
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
