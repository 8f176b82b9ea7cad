// Elements and words. Texts of a run go in as text, never as markup.
const one = (selector, root = document) => root.querySelector(selector);
const all = (selector, root = document) => [...root.querySelectorAll(selector)];

function element(tag, properties = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in made && name !== "style" && name !== "list") made[name] = value;
    else made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

function table(caption, heads, rows) {
  const head = element("tr", {}, ...heads.map((text) => element("th", { scope: "col" }, text)));
  return element("table", { className: "plain" },
    element("caption", { className: "hidden" }, caption), element("thead", {}, head),
    element("tbody", {}, ...rows));
}

// A number with every digit that tells it from its neighbours; `digits` where it was rounded.
function spelled(value, digits = 0) {
  if (value === "nan" || Number.isNaN(value)) return "none";
  if (value === "inf" || value === Infinity) return "∞";
  if (value === "-inf" || value === -Infinity) return "−∞";
  if (value === null || value === undefined) return "–";
  const number = digits ? Number(value.toPrecision(digits)) : value;
  return Object.is(number, -0) ? "-0" : String(number);
}

const finite = (value) => (value === "inf" ? Infinity : value === "-inf" ? -Infinity
  : value === "nan" ? NaN : value);

function times(ratio) {
  const size = Math.abs(ratio);
  if (size === Infinity) return "∞×";
  return size === 0 ? "0×" : size < 0.01 ? "<0.01×" : size > 1e5 ? `${size.toExponential(0)}×`
    : `${Number(size.toPrecision(2))}×`;
}

const counted = (n, noun) => `${n} ${noun}${n === 1 ? "" : "s"}`;

async function copy(text, button) {
  const word = button.textContent;
  try {
    await navigator.clipboard.writeText(text);
  } catch {  // a page from a file may not: the old way
    const area = element("textarea", { value: text, className: "hidden" });
    document.body.append(area);
    area.select();
    document.execCommand("copy");
    area.remove();
    button.focus();
  }
  button.textContent = "copied";
  setTimeout(() => { button.textContent = word; }, 1500);
}
