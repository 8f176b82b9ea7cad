// A tracer to begin with: hit and depth of the spheres of a scene. Node 18 or newer.
//
//     node stub.mjs scene.json OUT        OUT becomes a folder: hit.npy, depth.npy

import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { join } from "node:path";

const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

/** S8: the smallest positive root, so evaluated that far and small spheres keep digits (E8). */
function sphereT(P0, d, C, R) {
  const L = C.map((x, k) => x - P0[k]);
  const a = dot(d, d), b = dot(d, L);
  const q = L.map((x, k) => x - (b / a) * d[k]); // from the line to C
  const quarterDelta = a * (R * R - dot(q, q));
  if (quarterDelta < 0) return Infinity;
  const root = Math.sqrt(quarterDelta);
  const larger = b < 0 ? b - root : b + root;
  const roots = [larger / a, larger === 0 ? 0 : (dot(L, L) - R * R) / larger];
  return Math.min(...roots.filter((t) => t > 0)); // of none: Infinity
}

/** NumPy's format: rows from the top, little-endian. "|b1" is bool, "<f8" is double. */
function writeNpy(path, type, array, ny, nx) {
  const header = `{'descr': '${type}', 'fortran_order': False, 'shape': (${ny}, ${nx}), }`;
  const start = Buffer.from(`\x93NUMPY\x01\x00\x76\x00${header.padEnd(117)}\n`, "latin1"); // 0x76 = 118
  writeFileSync(path, Buffer.concat([start, Buffer.from(array.buffer)]));
}

const [scenePath, out] = process.argv.slice(2);
const scene = JSON.parse(readFileSync(scenePath, "utf8"));
const { P0, u, v, n, nu, l, r, b, t, nx, ny } = scene.screen;
const hit = new Uint8Array(nx * ny);
const depth = new Float64Array(nx * ny);

for (let row = 0; row < ny; row++) { // the image's rows start at the top …
  for (let i = 0; i < nx; i++) {
    const j = ny - 1 - row; // … and the screen's at the bottom (S2)
    const x = l + ((r - l) / nx) * (i + 0.5);
    const y = b + ((t - b) / ny) * (j + 0.5);
    const d = [0, 1, 2].map((k) => x * u[k] + y * v[k] + nu * n[k]); // S3, S5: t = 1 at the screen
    let nearest = Infinity;
    for (const thing of scene.objects) {
      if (thing.type === "sphere")
        nearest = Math.min(nearest, sphereT(P0, d, thing.center, thing.radius));
      // Go on here: "triangle" (S9), "polygon" (S10, S11), "mesh"; then object, t, position,
      // normal, shadow (S12), … See README.md for names and types.
    }
    hit[row * nx + i] = nearest < Infinity ? 1 : 0;
    depth[row * nx + i] = nearest * Math.abs(nu);
  }
}

mkdirSync(out, { recursive: true });
writeNpy(join(out, "hit.npy"), "|b1", hit, ny, nx);
writeNpy(join(out, "depth.npy"), "<f8", depth, ny, nx);
