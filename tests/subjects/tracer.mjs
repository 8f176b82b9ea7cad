// The lecture in JavaScript, for node 18 or newer and no package beside it: rules S1 to S16.
//
//     node tracer.mjs scene.json OUT.npz
//
// OUT.npz holds every quantity in double, in NumPy's own format, stored without compression.

import { readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";

// ---------------------------------------------------------------- vectors: arrays of three

const plus = (a, b) => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
const minus = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const times = (k, a) => [k * a[0], k * a[1], k * a[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];
const norm = (a) => Math.sqrt(dot(a, a));
const unit = (a) => {
  const length = norm(a);
  return [a[0] / length, a[1] / length, a[2] / length];
};

// ---------------------------------------------------------------- S1–S3, S5: the primary ray

/** d = P − P0 of pixel (i, j), (1) and (2); row j = 0 is the bottom. */
function primaryDirection({ u, v, n, nu, l, r, b, t, nx, ny }, i, j) {
  const across = l + ((r - l) / nx) * (i + 0.5);
  const up = b + ((t - b) / ny) * (j + 0.5);
  return plus(plus(times(across, u), times(up, v)), times(nu, n));
}

// ---------------------------------------------------------------- S8–S11: shapes

const NO_HIT = { t: Infinity, shape: null, object: -1, triangle: -1, beta: NaN, gamma: NaN };

class Sphere {
  constructor(object, C, R) {
    Object.assign(this, { object, triangle: 0, C, R });
    this.lower = minus(C, [R, R, R]);
    this.upper = plus(C, [R, R, R]);
  }

  /**
   * S8: Δ ≥ 0, then the smallest root from t0 on. Δ comes from the line's distance to C, and the
   * root of smaller magnitude from the product of the two, so that neither cancels (E8).
   */
  meet(P0, d, t0) {
    const { C, R } = this;
    const Lx = C[0] - P0[0], Ly = C[1] - P0[1], Lz = C[2] - P0[2];
    const a = dot(d, d);
    const b = d[0] * Lx + d[1] * Ly + d[2] * Lz;
    const nearest = b / a;
    const qx = Lx - nearest * d[0], qy = Ly - nearest * d[1], qz = Lz - nearest * d[2];
    const halfChord2 = R * R - (qx * qx + qy * qy + qz * qz);
    if (halfChord2 < 0) return NO_HIT;
    const root = Math.sqrt(a * halfChord2);
    const larger = b < 0 ? b - root : b + root;
    const one = larger / a;
    const other = larger === 0 ? 0 : (Lx * Lx + Ly * Ly + Lz * Lz - R * R) / larger;
    let t = Math.min(one, other);
    if (!(t >= t0 && t > 0)) t = Math.max(one, other);
    if (!(t >= t0 && t > 0)) return NO_HIT;
    return { t, shape: this, object: this.object, triangle: 0, beta: NaN, gamma: NaN };
  }

  normal(M) {
    return unit(minus(M, this.C));
  }
}

class Triangle {
  /** Vertices a, b, c in the plane through a with normal N, of any length. */
  constructor(object, triangle, [a, b, c], N) {
    Object.assign(this, { object, triangle, a, b, c, N, s: unit(N) });
    this.lower = a.map((x, k) => Math.min(x, b[k], c[k]));
    this.upper = a.map((x, k) => Math.max(x, b[k], c[k]));
  }

  /**
   * S9: the ray is inside when the volumes of d with the three edges, seen from P0, have one
   * sign. The volume of an edge walked backwards is the exact negative, so that of two triangles
   * that share it one is always met. S10 gives t.
   */
  meet(P0, d, t0) {
    const { a, b, c, N } = this;
    const A = minus(a, P0), B = minus(b, P0), C = minus(c, P0);
    const wa = volume(d, B, C, b, c);
    const wb = volume(d, C, A, c, a);
    const wc = volume(d, A, B, a, b);
    const inside = (wa >= 0 && wb >= 0 && wc >= 0) || (wa <= 0 && wb <= 0 && wc <= 0);
    const total = wa + wb + wc;
    if (!inside || total === 0) return NO_HIT;
    const t = dot(A, N) / dot(d, N);
    if (!(t >= t0 && t > 0 && t < Infinity)) return NO_HIT; // a parallel ray has NaN or ±∞
    const { object, triangle } = this;
    return { t, shape: this, object, triangle, beta: wb / total, gamma: wc / total };
  }

  normal() {
    return this.s;
  }
}

/** d · ((X + Y) × (x − y)): the edge from x to y, seen from P0 as X and Y. */
function volume(d, X, Y, x, y) {
  const sx = X[0] + Y[0], sy = X[1] + Y[1], sz = X[2] + Y[2];
  const ex = x[0] - y[0], ey = x[1] - y[1], ez = x[2] - y[2];
  return d[0] * (sy * ez - sz * ey) + d[1] * (sz * ex - sx * ez) + d[2] * (sx * ey - sy * ex);
}

// ---------------------------------------------------------------- S6: RT

const before = (x, y) =>
  x.t !== y.t ? x.t < y.t : x.object !== y.object ? x.object < y.object : x.triangle < y.triangle;

/** A tree of boxes; each is wider by `pad`, which is more than all the roundings of a hit. */
function boxed(shapes, pad) {
  const axes = [0, 1, 2];
  const lower = axes.map((k) => shapes.reduce((m, s) => Math.min(m, s.lower[k]), Infinity) - pad);
  const upper = axes.map((k) => shapes.reduce((m, s) => Math.max(m, s.upper[k]), -Infinity) + pad);
  if (shapes.length <= 4) return { lower, upper, shapes, left: null, right: null };
  const size = minus(upper, lower);
  const axis = size.indexOf(Math.max(...size));
  const middle = (shape) => shape.lower[axis] + shape.upper[axis];
  const sorted = [...shapes].sort((x, y) => middle(x) - middle(y));
  const half = sorted.length >> 1;
  const [left, right] = [sorted.slice(0, half), sorted.slice(half)].map((s) => boxed(s, pad));
  return { lower, upper, shapes: [], left, right };
}

/** Whether a box may be met at a t from t0 to t1; a NaN, 0 · ∞, excludes nothing. */
function mayMeet({ lower, upper }, P0, d, t0, t1) {
  for (let k = 0; k < 3; k++) {
    const x = (lower[k] - P0[k]) / d[k];
    const y = (upper[k] - P0[k]) / d[k];
    const back = 1 / d[k] < 0;
    const enter = back ? y : x, leave = back ? x : y;
    if (enter > t0) t0 = enter;
    if (leave < t1) t1 = leave;
  }
  return t0 <= t1 * (1 + 1e-12);
}

/** RT(P0, d, t0, ∞): the first hit; with `any`, any hit at all. */
function RT({ tree }, P0, d, t0, any = false) {
  let best = NO_HIT;
  const stack = [tree];
  while (stack.length) {
    const box = stack.pop();
    if (!mayMeet(box, P0, d, t0, best.t)) continue;
    for (const shape of box.shapes) {
      const hit = shape.meet(P0, d, t0);
      if (hit.shape && before(hit, best)) best = hit;
    }
    if (any && best.shape) return best;
    if (box.left) stack.push(box.right, box.left);
  }
  return best;
}

// ---------------------------------------------------------------- S14–S16: directions

const reflect = (delta, s) => minus(delta, times(2 * dot(delta, s), s));

/** S15, S16 with s turned along δ (E1); null at total internal reflection (E2). */
function refract(delta, normal, ior) {
  const leaving = dot(delta, normal) > 0;
  const s = leaving ? normal : times(-1, normal);
  const ratio = leaving ? ior : 1 / ior;
  const cosine = dot(delta, s);
  const radicand = 1 - ratio * ratio * (1 - cosine * cosine);
  if (radicand < 0) return null;
  return plus(times(ratio, delta), times(Math.sqrt(radicand) - ratio * cosine, s));
}

// ---------------------------------------------------------------- S7, S12, S13: colour

/** What is at a hit: the point, the ray's unit direction, the normal, and it turned to the viewer. */
function pointOf(P0, d, hit) {
  const M = plus(P0, times(hit.t, d));
  const delta = unit(d);
  const normal = hit.shape.normal(M);
  return { M, delta, normal, s: dot(normal, delta) > 0 ? times(-1, normal) : normal };
}

const inShadow = (scene, M) => RT(scene, M, scene.toLight, scene.epsilon, true).shape !== null;

/** Phong's model where it is lit, the shadow colour elsewhere; shininess is a whole number. */
function localColor(scene, material, { M, delta, s }) {
  const { ambient, diffuse, specular, shininess } = material;
  if (inShadow(scene, M)) return scene.shadow_color ?? ambient;
  const L = scene.toLight;
  const facing = dot(s, L);
  if (!(facing > 0)) return ambient;
  const highlight = Math.max(0, -dot(reflect(times(-1, L), s), delta));
  const shine = power(highlight, shininess);
  return ambient.map((a, k) => a + scene.light.color[k] * (diffuse[k] * facing + specular[k] * shine));
}

function power(base, exponent) {
  let result = 1;
  for (; exponent; exponent = Math.floor(exponent / 2), base *= base)
    if (exponent % 2) result *= base;
  return result;
}

function rayColor(scene, P0, d, hit, generation) {
  if (!hit.shape) return scene.background;
  const material = scene.materialOf[hit.object];
  const point = pointOf(P0, d, hit);
  const through = material.transmittance > 0 ? refract(point.delta, point.normal, material.ior) : null;
  const k_t = through ? material.transmittance : 0;
  const k_r = material.reflectance + (through ? 0 : material.transmittance);
  let color = times(1 - k_r - k_t, localColor(scene, material, point));
  if (generation === scene.max_depth) return color; // what comes from further on is black
  for (const [share, direction] of [[k_r, reflect(point.delta, point.s)], [k_t, through]]) {
    if (!(share > 0)) continue;
    const next = RT(scene, point.M, direction, scene.epsilon);
    color = plus(color, times(share, rayColor(scene, point.M, direction, next, generation + 1)));
  }
  return color;
}

// ---------------------------------------------------------------- reading the scene

const fan = (corners) => corners.slice(2).map((c, k) => [corners[0], corners[k + 1], c]);

function readObj(text) {
  const vertices = [], faces = [];
  for (const line of text.split(/\r?\n/)) {
    const [word, ...rest] = line.trim().split(/\s+/);
    if (word === "v") vertices.push(rest.slice(0, 3).map(Number));
    if (word !== "f") continue;
    const corners = rest.map((corner) => parseInt(corner, 10)); // up to the first slash
    faces.push(...fan(corners.map((k) => (k > 0 ? k - 1 : vertices.length + k))));
  }
  return { vertices, faces };
}

const PLY_TYPES = {
  char: ["Int8", 1], uchar: ["Uint8", 1], short: ["Int16", 2], ushort: ["Uint16", 2],
  int: ["Int32", 4], uint: ["Uint32", 4], float: ["Float32", 4], double: ["Float64", 8],
  int8: ["Int8", 1], uint8: ["Uint8", 1], int16: ["Int16", 2], uint16: ["Uint16", 2],
  int32: ["Int32", 4], uint32: ["Uint32", 4], float32: ["Float32", 4], float64: ["Float64", 8],
};

/** A function that gives the next number of a PLY file's body, of the type asked for. */
function plyNumbers(bytes, format) {
  if (format === "ascii") {
    const words = bytes.toString("latin1").split(/\s+/).filter(Boolean);
    let next = 0;
    return () => Number(words[next++]);
  }
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.length);
  let place = 0;
  return (type) => {
    const [name, size] = PLY_TYPES[type];
    place += size;
    return view[`get${name}`](place - size, format === "binary_little_endian");
  };
}

function readPly(bytes) {
  const end = bytes.indexOf("end_header");
  const body = bytes.subarray(bytes.indexOf("\n", end) + 1);
  const elements = [];
  let next;
  for (const line of bytes.toString("latin1", 0, end).split(/\r?\n/)) {
    const [word, ...rest] = line.trim().split(/\s+/);
    if (word === "format") next = plyNumbers(body, rest[0]);
    if (word === "element") elements.push({ name: rest[0], rows: Number(rest[1]), properties: [] });
    if (word === "property") elements.at(-1).properties.push(rest);
  }
  const vertices = [], faces = [];
  for (const { name, rows, properties } of elements) {
    for (let row = 0; row < rows; row++) {
      const value = {};
      for (const words of properties) {
        const list = words[0] === "list";
        const read = () => next(words.at(-2));
        value[words.at(-1)] = list ? Array.from({ length: next(words[1]) }, read) : read();
      }
      if (name === "vertex") vertices.push([value.x, value.y, value.z]);
      if (name === "face") faces.push(...fan(value.vertex_indices ?? value.vertex_index));
    }
  }
  return { vertices, faces };
}

function readMesh(path) {
  if (path.endsWith(".obj")) return readObj(readFileSync(path, "latin1"));
  if (path.endsWith(".ply")) return readPly(readFileSync(path));
  throw new Error(`neither .obj nor .ply: ${path}`);
}

/** The spheres and triangles of one object; a triangle without area is never hit. */
function shapesOf(thing, object, folder) {
  if (thing.type === "sphere") return [new Sphere(object, thing.center, thing.radius)];
  let { vertices } = thing;
  let faces = vertices && fan([...vertices.keys()]);
  if (thing.type === "mesh") {
    ({ vertices, faces } = readMesh(join(folder, thing.file)));
    const m = thing.transform;
    if (m) vertices = vertices.map((p) => m.slice(0, 3).map((row) => dot(row, p) + row[3]));
  }
  const corners = faces.map((face) => face.map((k) => vertices[k]));
  let normals = corners.map(([a, b, c]) => cross(minus(b, a), minus(c, a)));
  if (thing.type === "polygon") {
    const p = normals.reduce(plus); // S10: the polygon's own plane, for all the fan (S11)
    normals = normals.map(() => p);
  }
  const triangles = corners.map((abc, k) => new Triangle(object, k, abc, normals[k]));
  return triangles.filter((triangle) => dot(triangle.N, triangle.N) > 0);
}

function readScene(path) {
  const scene = JSON.parse(readFileSync(path, "utf8"));
  scene.materialOf = scene.objects.map((thing) => scene.materials[thing.material]);
  scene.toLight = unit(times(-1, scene.light.direction));
  const shapes = scene.objects.flatMap((thing, k) => shapesOf(thing, k, dirname(path)));
  const corners = [scene.screen.P0, ...shapes.flatMap((shape) => [shape.lower, shape.upper])];
  const reach = corners.flat().reduce((most, x) => Math.max(most, Math.abs(x)), 0);
  scene.tree = boxed(shapes, 1e-12 * reach);
  return scene;
}

// ---------------------------------------------------------------- S4: the image

// Name: type in NumPy's words, components, the value where nothing is hit.
const TABLE = {
  ray: ["<f8", 3, NaN], hit: ["|b1", 1, 0], object: ["<i4", 1, -1], triangle: ["<i4", 1, -1],
  t: ["<f8", 1, Infinity], depth: ["<f8", 1, Infinity], distance: ["<f8", 1, Infinity],
  position: ["<f8", 3, NaN], barycentric: ["<f8", 2, NaN], normal: ["<f8", 3, NaN],
  shadow: ["|i1", 1, -1], reflection: ["<f8", 3, NaN], reflection_object: ["<i4", 1, -1],
  reflection_t: ["<f8", 1, Infinity], tir: ["|i1", 1, -1], refraction: ["<f8", 3, NaN],
  refraction_object: ["<i4", 1, -1], refraction_t: ["<f8", 1, Infinity],
  color: ["<f8", 3, NaN], alpha: ["<f8", 1, 0],
};
const ARRAYS = { "<f8": Float64Array, "<i4": Int32Array, "|i1": Int8Array, "|b1": Uint8Array };

function tracePixel(scene, d) {
  const { P0, nu } = scene.screen;
  const hit = RT(scene, P0, d, 0);
  const seen = { ray: unit(d), color: rayColor(scene, P0, d, hit, 0) };
  if (!hit.shape) return seen;
  const { object, triangle, t } = hit;
  const { alpha, ior } = scene.materialOf[object];
  const { M, delta, normal, s } = pointOf(P0, d, hit);
  const reflection = reflect(delta, s);
  const mirrored = RT(scene, M, reflection, scene.epsilon);
  Object.assign(seen, {
    hit: 1, object, triangle, t, depth: t * Math.abs(nu), distance: t * norm(d), alpha, normal,
    position: M, barycentric: [hit.beta, hit.gamma], shadow: Number(inShadow(scene, M)),
    reflection, reflection_object: mirrored.object, reflection_t: mirrored.t,
  });
  if (ior === null) return seen;
  const refraction = refract(delta, normal, ior);
  if (!refraction) return Object.assign(seen, { tir: 1 });
  const behind = RT(scene, M, refraction, scene.epsilon);
  const [refraction_object, refraction_t] = [behind.object, behind.t];
  return Object.assign(seen, { tir: 0, refraction, refraction_object, refraction_t });
}

function render(scene) {
  const { nx, ny } = scene.screen;
  const frame = {};
  for (const [name, [type, components, miss]] of Object.entries(TABLE))
    frame[name] = new ARRAYS[type](nx * ny * components).fill(miss);
  for (let row = 0; row < ny; row++) { // row 0 is the top of the image, j = 0 its bottom
    for (let i = 0; i < nx; i++) {
      const seen = tracePixel(scene, primaryDirection(scene.screen, i, ny - 1 - row));
      for (const [name, value] of Object.entries(seen)) {
        const pixel = row * nx + i;
        if (Array.isArray(value)) frame[name].set(value, pixel * value.length);
        else frame[name][pixel] = value;
      }
    }
  }
  return frame;
}

// ---------------------------------------------------------------- writing the archive

/** NumPy's format, version 1: a magic word, a Python dict padded to 64 bytes, the numbers. */
function npy(array, type, shape) {
  const header = `{'descr': '${type}', 'fortran_order': False, 'shape': (${shape.join(", ")}), }`;
  const padded = header.padEnd(Math.ceil((header.length + 11) / 64) * 64 - 11) + "\n";
  const start = Buffer.from(`\x93NUMPY\x01\x00__${padded}`, "latin1");
  start.writeUInt16LE(padded.length, 8);
  return Buffer.concat([start, Buffer.from(array.buffer)]); // little-endian where node runs
}

const CRC_TABLE = Uint32Array.from({ length: 256 }, (_, byte) => {
  for (let bit = 0; bit < 8; bit++) byte = (byte >>> 1) ^ (byte & 1 ? 0xedb88320 : 0);
  return byte;
});

function crc32(bytes) {
  let crc = 0xffffffff;
  for (const byte of bytes) crc = CRC_TABLE[(crc ^ byte) & 255] ^ (crc >>> 8);
  return (crc ^ 0xffffffff) >>> 0;
}

/** A ZIP archive of stored members; [2 bytes] and [4 bytes] numbers as its specification orders. */
function zip(members) {
  const fields = (...pairs) => {
    const bytes = Buffer.alloc(pairs.reduce((sum, [size]) => sum + size, 0));
    pairs.reduce((place, [size, value]) => bytes.writeUIntLE(value, place, size), 0);
    return bytes;
  };
  const parts = [], directory = [];
  let place = 0;
  for (const [name, data] of members) {
    const about = [ // version, flags, method, time, date (1980-01-01), checksum, sizes, lengths
      [2, 20], [2, 0], [2, 0], [2, 0], [2, 33], [4, crc32(data)], [4, data.length],
      [4, data.length], [2, name.length], [2, 0],
    ];
    const local = Buffer.concat([fields([4, 0x04034b50], ...about), Buffer.from(name), data]);
    directory.push(
      fields([4, 0x02014b50], [2, 20], ...about, [2, 0], [2, 0], [2, 0], [4, 0], [4, place]),
      Buffer.from(name),
    );
    parts.push(local);
    place += local.length;
  }
  const index = Buffer.concat(directory);
  const count = members.length;
  const end = [[4, 0x06054b50], [2, 0], [2, 0], [2, count], [2, count], [4, index.length], [4, place]];
  return Buffer.concat([...parts, index, fields(...end, [2, 0])]);
}

function main([scenePath, out]) {
  if (!out) throw new Error("usage: node tracer.mjs scene.json OUT.npz");
  const scene = readScene(scenePath);
  const { nx, ny } = scene.screen;
  const members = Object.entries(render(scene)).map(([name, array]) => {
    const [type, components] = TABLE[name];
    const shape = components === 1 ? [ny, nx] : [ny, nx, components];
    return [`${name}.npy`, npy(array, type, shape)];
  });
  writeFileSync(out, zip(members));
}

main(process.argv.slice(2));
