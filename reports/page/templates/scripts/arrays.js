// Arrays as reports/page/inspector/packing.py packed them: base64, deflated, byte planes of predicted bit patterns.
const inflated = new Map();

function inflate(id) {
  if (!inflated.has(id)) inflated.set(id, inflateNow(id));
  return inflated.get(id);
}

async function inflateNow(id) {
  const text = document.getElementById(id).textContent.trim();
  const packed = Uint8Array.fromBase64?.(text) ?? Uint8Array.from(atob(text), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

async function readJson(id) {
  return JSON.parse(new TextDecoder().decode(await inflate(id)));
}

const WIDTHS = { f8: 8, f4: 4, i4: 4, b2: 2, i1: 1 };
const UNSIGNED = { 4: Uint32Array, 2: Uint16Array, 1: Uint8Array };

// One typed array a component, of ny·nx numbers.
async function unpack(packed, ny, nx, others = null) {
  const bytes = await inflate(packed.blob);
  const width = WIDTHS[packed.kind], size = ny * nx;
  return packed.predictors.map(([subtracted, orders], k) => {
    const planes = bytes.subarray(k * width * size, (k + 1) * width * size);
    const other = subtracted ? others[k] : null;
    return width === 8 ? doubles(planes, ny, nx, orders, other)
      : numbers(singles(planes, width, ny, nx, orders, other), packed.kind);
  });
}

function singles(planes, width, ny, nx, orders, other) {
  const size = ny * nx, bits = new UNSIGNED[width](size);
  for (let i = 0; i < size; i++) {
    let folded = 0;
    for (let b = width - 1; b >= 0; b--) folded = (folded << 8) | planes[b * size + i];
    bits[i] = (folded >>> 1) ^ -(folded & 1);
  }
  for (let order = 0; order < orders; order++) {
    for (let i = nx; i < size; i++) bits[i] += bits[i - nx];
    for (let i = 1; i < size; i++) if (i % nx) bits[i] += bits[i - 1];
  }
  if (other) {
    const beside = new UNSIGNED[width](other.buffer);
    for (let i = 0; i < size; i++) bits[i] += beside[i];
  }
  return bits;
}

function numbers(bits, kind) {
  if (kind === "f4") return new Float32Array(bits.buffer);
  if (kind === "i4") return new Int32Array(bits.buffer);
  if (kind === "i1") return new Int8Array(bits.buffer);
  return new Float32Array(Uint32Array.from(bits, (half) => half << 16).buffer);
}

// Bit patterns of float64 as pairs of 32 bits, the lower first.
function doubles(planes, ny, nx, orders, other) {
  const size = ny * nx, pairs = new Uint32Array(2 * size);
  const word = (b, i) => planes[b * size + i] | (planes[(b + 1) * size + i] << 8)
    | (planes[(b + 2) * size + i] << 16) | (planes[(b + 3) * size + i] << 24);
  for (let i = 0; i < size; i++) {
    const low = word(0, i), high = word(4, i), sign = -(low & 1);
    pairs[2 * i] = ((low >>> 1) | (high << 31)) ^ sign;
    pairs[2 * i + 1] = (high >>> 1) ^ sign;
  }
  const add = (i, from, j) => {
    const low = pairs[2 * i] + from[2 * j];
    pairs[2 * i] = low;
    pairs[2 * i + 1] += from[2 * j + 1] + (low > 0xffffffff ? 1 : 0);
  };
  for (let order = 0; order < orders; order++) {
    for (let i = nx; i < size; i++) add(i, pairs, i - nx);
    for (let i = 1; i < size; i++) if (i % nx) add(i, pairs, i - 1);
  }
  if (other) {
    const double = other instanceof Float64Array ? other : Float64Array.from(other);
    const beside = new Uint32Array(double.buffer);
    for (let i = 0; i < size; i++) add(i, beside, i);
  }
  return new Float64Array(pairs.buffer);
}
