// Values into colours, as reports/page/pictures.py does it; arrays come a component each.
const rgb = (code) => [1, 3, 5].map((at) => parseInt(code.slice(at, at + 2), 16));
const byte = (share) => Math.round(255 * Math.min(1, Math.max(0, share)));

function srgb(linear) {
  const x = Math.min(1, Math.max(0, linear));
  return Math.round(255 * (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055));
}

function valueColor(name, low, high) {
  const quantity = data.quantities[name], nothing = rgb(data.nothing);
  if (quantity.mask) {
    const mask = quantity.mask.map(rgb);
    return ([v]) => mask[Math.min(1, Math.max(-1, v)) + 1];
  }
  if (quantity.discrete) {
    const colors = data.categories.map(rgb);
    return ([v]) => (v < 0 ? nothing : colors[v % colors.length]);
  }
  const given = (color) => (v) => (v.every(Number.isFinite) ? color(v) : nothing);
  if (quantity.components === 1) {
    const steps = data.viridis.map(rgb), width = high[0] - low[0] || 1;
    return given(([v]) => steps[Math.min(63, Math.max(0, Math.round(63 * (v - low[0]) / width)))]);
  }
  if (name === "color") return given((v) => v.map(srgb));
  if (name === "barycentric") return given(([b, g]) => [b, g, 1 - b - g].map(byte));
  if (quantity.kind === "direction") return given((v) => v.map((x) => byte((x + 1) / 2)));
  return given((v) => v.map((x, k) => byte((x - low[k]) / (high[k] > low[k] ? high[k] - low[k] : 1))));
}

const TICKS = { linear: [-4, -2, -1, 0, 1, 2, 4], log: [-64, -16, -4, -1, 0, 1, 4, 16, 64] };

// Where on the signed scale, −1…1, an error over tolerance stands.
function signedPlace(ratio, scale) {
  const size = Math.abs(ratio);
  const place = scale === "linear" ? size / 4 : Math.log2(1 + 4 * size) / Math.log2(1 + 4 * 64);
  return Math.sign(ratio) * Math.min(1, place);
}

function differenceColor(scale) {
  const bands = data.bands.map(rgb), hatch = data.hatch.map(rgb), nothing = hatch[1];
  if (scale === "bands") {
    return ([ratio]) => {
      if (Number.isNaN(ratio)) return nothing;
      const index = data.bounds.findIndex((bound) => bound >= Math.abs(ratio));
      return bands[index < 0 ? bands.length - 1 : index];
    };
  }
  const knots = data.diverging.map(rgb), middle = (knots.length - 1) / 2;
  return ([ratio]) => {
    if (Number.isNaN(ratio)) return nothing;
    const at = middle * (1 + signedPlace(ratio, scale));
    const from = Math.min(knots.length - 2, Math.floor(at)), share = at - from;
    return knots[from].map((c, k) => Math.round(c + share * (knots[from + 1][k] - c)));
  };
}

function painted(planes, ny, nx, color) {
  const canvas = element("canvas", { width: nx, height: ny });
  const context = canvas.getContext("2d");
  const image = context.createImageData(nx, ny), value = planes.map(() => 0);
  for (let i = 0; i < ny * nx; i++) {
    for (let k = 0; k < planes.length; k++) value[k] = planes[k][i];
    const [r, g, b] = color(value);
    image.data.set([r, g, b, 255], 4 * i);
  }
  context.putImageData(image, 0, 0);
  return canvas;
}
