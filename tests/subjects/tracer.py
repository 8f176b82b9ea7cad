"""The lecture in NumPy, one file, nothing of minirt in it: rules S1 to S16, all rays at once.

As a program, ``python tracer.py scene.json OUT.npz``; as a function, ``tracer:render``, which
takes the document of a scene (meshes lie in ``scene["folder"]`` if that is there) and returns a
dictionary of arrays. Vectors are rows: (n, 3) for n rays.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Scene = dict[str, Any]


def dot(a: Array, b: Array) -> Array:
    product: Array = a * b
    return product[..., 0] + product[..., 1] + product[..., 2]


def cross(a: Array, b: Array) -> Array:
    (x, y, z), (i, j, k) = np.moveaxis(a, -1, 0), np.moveaxis(b, -1, 0)
    return np.stack((y * k - z * j, z * i - x * k, x * j - y * i), axis=-1)


def norm(a: Array) -> Array:
    length: Array = np.sqrt(dot(a, a))
    return length


def unit(a: Array) -> Array:
    length: Array = norm(a)[..., None]
    return a / length


# S1–S3, S5


def primary_directions(screen: Scene) -> Array:
    """d = P − P0 of every pixel, (ny·nx, 3), from the top row (j = ny − 1) down."""
    nx, ny = screen["nx"], screen["ny"]
    i, j = np.meshgrid(np.arange(nx), np.arange(ny)[::-1])
    u = screen["l"] + (screen["r"] - screen["l"]) / nx * (i + 0.5)
    v = screen["b"] + (screen["t"] - screen["b"]) / ny * (j + 0.5)
    d = sum(
        np.multiply.outer(amount, np.array(screen[axis], dtype=np.float64))
        for amount, axis in ((u, "u"), (v, "v"), (np.full_like(u, screen["nu"]), "n"))
    )
    return np.asarray(d).reshape(-1, 3)


# S8–S11: every ray of (r, 1, 3) with every shape of (k, 3)


def sphere_t(P0: Array, d: Array, C: Array, R: Array, t0: float) -> Array:
    """S8: the smallest root from t0 on; no digit is lost in Δ or in the smaller root (E8)."""
    L = C - P0
    a, b = dot(d, d), dot(d, L)
    q = L - (b / a)[..., None] * d
    quarter_delta = a * (R * R - dot(q, q))
    larger = b + np.copysign(np.sqrt(np.maximum(quarter_delta, 0)), b)
    roots = np.stack((larger / a, (dot(L, L) - R * R) / np.where(larger == 0, np.inf, larger)))
    roots[:, quarter_delta < 0] = np.inf
    t: Array = np.where((roots >= t0) & (roots > 0), roots, np.inf).min(axis=0)
    return t


def triangle_t(P0: Array, d: Array, abc: Array, N: Array, t0: float) -> tuple[Array, Array, Array]:
    """S9 and S10: t, +inf where the triangle is not met, and its β and γ.

    A volume of d with an edge changes nothing but its sign when the edge is walked backwards, so
    that no ray slips between two triangles.
    """
    a, b, c = np.moveaxis(abc, -2, 0)
    A, B, C = a - P0, b - P0, c - P0
    edges = ((B + C, b - c), (C + A, c - a), (A + B, a - b))
    weights = np.stack([dot(d, cross(middle, edge)) for middle, edge in edges])
    inside = (weights >= 0).all(axis=0) | (weights <= 0).all(axis=0)
    total, slope = weights.sum(axis=0), dot(d, N)
    with np.errstate(divide="ignore", invalid="ignore"):
        t = dot(A, N) / slope
        beta, gamma = weights[1:] / total
        met = inside & (total != 0) & (t >= t0) & (t > 0)
    return np.where(met, t, np.inf), beta, gamma


@dataclass
class Shapes:
    """Spheres and triangles in one list, in the scene's order; what a kind lacks is zero.

    A polygon is its fan of triangles (S11), all with the polygon's own normal.
    """

    sphere: Array
    object: Array
    triangle: Array
    C: Array
    R: Array
    abc: Array
    N: Array

    def box(self) -> tuple[Array, Array]:
        """Lower and upper corners (m, 3)."""
        ball, R = self.sphere[:, None], self.R[:, None]
        lower = np.where(ball, self.C - R, self.abc.min(axis=1))
        upper = np.where(ball, self.C + R, self.abc.max(axis=1))
        return lower, upper

    def take(self, index: Array) -> Shapes:
        return Shapes(**{name: value[index] for name, value in vars(self).items()})


@dataclass
class Hits:
    """What n rays meet first: t = +inf and −1 for nothing; `shape` is a place in the list."""

    t: Array
    object: Array
    triangle: Array
    beta: Array
    gamma: Array
    shape: Array

    @classmethod
    def none(cls, n: int) -> Hits:
        inf, nans = np.full(n, np.inf), (np.full(n, np.nan), np.full(n, np.nan))
        return cls(inf, np.full(n, -1), np.full(n, -1), *nans, np.full(n, -1))

    def take(self, index: Array) -> Hits:
        return Hits(*(value[index] for value in vars(self).values()))


@dataclass
class Box:
    """A node of the tree: two corners, and the numbers of the shapes between them, in order."""

    lower: Array
    upper: Array
    index: Array
    children: list[Box] = field(default_factory=list)


def tree_of(lower: Array, upper: Array, index: Array, pad: float) -> Box:
    """Boxes that are wider by `pad` than their shapes, which is more than all roundings."""
    inside = lower[index].min(axis=0, initial=np.inf), upper[index].max(axis=0, initial=-np.inf)
    box = Box(inside[0] - pad, inside[1] + pad, np.sort(index))
    if len(index) > 8:
        axis = int(np.argmax(box.upper - box.lower))
        middle = (lower + upper)[index, axis]
        halves = np.array_split(index[np.argsort(middle, kind="stable")], 2)
        box.children = [tree_of(lower, upper, half, pad) for half in halves]
    return box


# S6


class World:
    """The shapes of a scene in a tree; `RT` asks for all rays at once."""

    def __init__(self, scene: Scene) -> None:
        self.shapes = read_shapes(scene)
        lower, upper = self.shapes.box()
        corners = [np.abs(scene["screen"]["P0"]), np.abs(lower).ravel(), np.abs(upper).ravel()]
        index = np.arange(len(lower))
        self.tree = tree_of(lower, upper, index, 1e-12 * np.concatenate(corners).max())

    def RT(self, P0: Array, d: Array, t0: float, any_hit: bool = False) -> Hits:
        """RT(P0, d, t0, ∞) of each ray; with `any_hit`, whatever is met, first or not."""
        best = Hits.none(len(d))
        pending = [(self.tree, np.arange(len(d)))] if len(self.tree.index) else []
        while pending:
            box, rays = pending.pop()
            if any_hit:
                rays = rays[best.shape[rays] < 0]
            rays = rays[may_meet(box, P0[rays], d[rays], t0, best.t[rays])]
            if not len(rays):
                continue
            pending += [(child, rays) for child in reversed(box.children)]
            if not box.children:
                self._ask(box.index, P0, d, t0, rays, best)
        return best

    def _ask(self, leaf: Array, P0: Array, d: Array, t0: float, rays: Array, best: Hits) -> None:
        """Try some shapes on some rays, each with each, and keep what comes before the best.

        Shapes stand in the scene's order in a leaf: of equal t the first is the right one.
        """
        shapes = self.shapes.take(leaf)
        origin, along = P0[rays, None], d[rays, None]
        t, beta, gamma = np.full((3, len(rays), len(leaf)), np.nan)
        ball, flat = np.flatnonzero(shapes.sphere), np.flatnonzero(~shapes.sphere)
        if len(ball):
            t[:, ball] = sphere_t(origin, along, shapes.C[ball], shapes.R[ball], t0)
        if len(flat):
            abc, N = shapes.abc[flat], shapes.N[flat]
            t[:, flat], beta[:, flat], gamma[:, flat] = triangle_t(origin, along, abc, N, t0)
        every, first = np.arange(len(rays)), t.argmin(axis=1)
        t, place, known = t[every, first], leaf[first], best.take(rays)
        # shapes are numbered in the scene's order
        better = (t < known.t) | ((t == known.t) & (t < np.inf) & (place < known.shape))
        some, place, which = rays[better], place[better], (every[better], first[better])
        best.t[some], best.shape[some] = t[better], place
        best.beta[some], best.gamma[some] = beta[which], gamma[which]
        best.object[some], best.triangle[some] = (
            self.shapes.object[place],
            self.shapes.triangle[place],
        )


def may_meet(box: Box, P0: Array, d: Array, t0: float, t1: Array) -> Array:
    """Which rays may meet a box at a t from t0 to t1; NaN, from 0/0, excludes nothing."""
    with np.errstate(divide="ignore", invalid="ignore"):
        x, y, back = (box.lower - P0) / d, (box.upper - P0) / d, 1 / d < 0
    enter = np.fmax(np.fmax.reduce(np.where(back, y, x), axis=1), t0)
    leave = np.fmin(np.fmin.reduce(np.where(back, x, y), axis=1), t1)
    result: Array = enter <= leave * (1 + 1e-12)
    return result


# S14–S16


def reflect(delta: Array, s: Array) -> Array:
    result: Array = delta - 2 * dot(delta, s)[:, None] * s
    return result


def refract(delta: Array, normal: Array, ior: Array) -> Array:
    """S15, S16 with s turned along δ (E1); rows of NaN at total internal reflection (E2)."""
    cosine = dot(delta, normal)
    leaving = cosine > 0
    s = np.where(leaving[:, None], normal, -normal)
    ratio, cosine = np.where(leaving, ior, 1 / ior), np.abs(cosine)
    radicand = 1 - ratio * ratio * (1 - cosine * cosine)
    root = np.sqrt(np.where(radicand < 0, np.nan, radicand))
    result: Array = ratio[:, None] * delta + (root - ratio * cosine)[:, None] * s
    return result


# S4, S7, S12, S13


@dataclass
class Points:
    """The points hit, one a ray that hits; `s` is the normal turned to the viewer."""

    rays: Array
    object: Array
    M: Array
    delta: Array
    normal: Array
    s: Array


MATERIAL = (
    "ambient", "diffuse", "specular", "shininess", "reflectance", "transmittance", "ior", "alpha",
)  # fmt: skip


class Tracer:
    """The lecture's algorithm on one scene."""

    def __init__(self, scene: Scene) -> None:
        self.scene, self.world = scene, World(scene)
        self.epsilon = float(scene["epsilon"])
        self.L = unit(-np.array(scene["light"]["direction"], dtype=np.float64))
        used = [scene["materials"][thing["material"]] for thing in scene["objects"]]
        self.material = {
            name: np.array([np.nan if m[name] is None else m[name] for m in used])
            for name in MATERIAL
        }

    def points(self, P0: Array, d: Array, hits: Hits) -> Points:
        rays = np.flatnonzero(hits.shape >= 0)
        shapes = self.world.shapes.take(hits.shape[rays])
        M = P0[rays] + hits.t[rays, None] * d[rays]
        delta = unit(d[rays])
        normal = unit(np.where(shapes.sphere[:, None], M - shapes.C, shapes.N))
        s = np.where((dot(normal, delta) > 0)[:, None], -normal, normal)
        return Points(rays, shapes.object, M, delta, normal, s)

    def dark(self, points: Points) -> Array:
        """S12: whether RT(M, −l, ε, ∞) meets anything."""
        toward = np.broadcast_to(self.L, points.M.shape)
        return self.world.RT(points.M, toward, self.epsilon, any_hit=True).shape >= 0

    def local_color(self, points: Points) -> Array:
        """S13: Phong's model, or the shadow colour."""
        m = {name: values[points.object] for name, values in self.material.items()}
        facing = np.maximum(0.0, dot(points.s, self.L))
        mirror = reflect(np.broadcast_to(-self.L, points.s.shape), points.s)
        highlight = np.where(facing > 0, np.maximum(0.0, -dot(mirror, points.delta)), 0.0)
        shine = (highlight ** m["shininess"])[:, None] * m["specular"]
        light = np.array(self.scene["light"]["color"])
        lit = m["ambient"] + light * (facing[:, None] * m["diffuse"] + shine)
        own = self.scene["shadow_color"]
        shadow = m["ambient"] if own is None else np.broadcast_to(own, lit.shape)
        return np.where(self.dark(points)[:, None], shadow, lit)

    def color(self, P0: Array, d: Array, hits: Hits, generation: int = 0) -> Array:
        """S7: (1 − k_r − k_t)·local + k_r·C(ρ) + k_t·C(ϱ), (n, 3)."""
        result = np.tile(np.array(self.scene["background"], dtype=np.float64), (len(d), 1))
        points = self.points(P0, d, hits)
        if not len(points.rays):
            return result
        k_r, k_t, ior = (
            self.material[name][points.object].astype(np.float64)
            for name in ("reflectance", "transmittance", "ior")
        )
        through = refract(points.delta, points.normal, np.where(k_t > 0, ior, 1.0))
        total = np.isnan(through[:, 0])
        k_r, k_t = np.where(total, k_r + k_t, k_r), np.where(total, 0.0, k_t)
        color = (1 - k_r - k_t)[:, None] * self.local_color(points)
        if generation < self.scene["max_depth"]:
            for share, direction in ((k_r, reflect(points.delta, points.s)), (k_t, through)):
                some = np.flatnonzero(share > 0)
                M, onward = points.M[some], direction[some]
                met = self.world.RT(M, onward, self.epsilon)
                color[some] += share[some, None] * self.color(M, onward, met, generation + 1)
        result[points.rays] = color
        return result

    def frame(self) -> dict[str, Array]:
        """Every quantity, flat: (n,) or (n, k)."""
        screen = self.scene["screen"]
        d = primary_directions(screen)
        P0 = np.broadcast_to(np.array(screen["P0"], dtype=np.float64), d.shape)
        hits = self.world.RT(P0, d, 0.0)
        points = self.points(P0, d, hits)
        rays, n = points.rays, len(d)

        def at(where: Array, values: Array, miss: float, dtype: str = "float64") -> Array:
            array = np.full((n, *values.shape[1:]), miss, dtype=dtype)
            array[where] = values
            return array

        frame = {
            "ray": unit(d),
            "hit": hits.shape >= 0,
            "object": hits.object.astype(np.int32),
            "triangle": hits.triangle.astype(np.int32),
            "t": hits.t,
            "depth": hits.t * abs(screen["nu"]),
            "distance": hits.t * norm(d),
            "barycentric": np.stack((hits.beta, hits.gamma), axis=1),
            "position": at(rays, points.M, np.nan),
            "normal": at(rays, points.normal, np.nan),
            "shadow": at(rays, self.dark(points), -1, "int8"),
            "color": self.color(P0, d, hits),
            "alpha": np.zeros(n),
        }
        reflection = reflect(points.delta, points.s)
        frame |= self._onward("reflection", points.M, reflection, rays, at)
        frame["alpha"][rays] = self.material["alpha"][points.object]
        ior = self.material["ior"][points.object].astype(np.float64)
        some = np.flatnonzero(~np.isnan(ior))
        refraction = refract(points.delta[some], points.normal[some], ior[some])
        frame["tir"] = at(rays[some], np.isnan(refraction[:, 0]), -1, "int8")
        passing = ~np.isnan(refraction[:, 0])
        some = some[passing]
        return frame | self._onward(
            "refraction", points.M[some], refraction[passing], rays[some], at
        )

    def _onward(self, name: str, M: Array, direction: Array, rays: Array, at: Any) -> Scene:
        met = self.world.RT(M, direction, self.epsilon)
        return {
            name: at(rays, direction, np.nan),
            f"{name}_object": at(rays, met.object, -1, "int32"),
            f"{name}_t": at(rays, met.t, np.inf),
        }


def render(scene: Scene) -> dict[str, Array]:
    """Every quantity of a scene: (ny, nx), (ny, nx, 2) or (ny, nx, 3), row 0 at the top."""
    ny, nx = scene["screen"]["ny"], scene["screen"]["nx"]
    frame = Tracer(scene).frame()
    return {name: values.reshape(ny, nx, *values.shape[1:]) for name, values in frame.items()}


# Reading the scene

PLY_TYPES = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip


def fan(corners: list[int]) -> list[tuple[int, int, int]]:
    """S11: the triangles (P1, Pk, Pk+1)."""
    return [(corners[0], j, k) for j, k in pairwise(corners[1:])]


def read_obj(data: bytes) -> tuple[Array, Array]:
    vertices: list[list[float]] = []
    faces: list[tuple[int, int, int]] = []
    for line in data.decode("utf-8", "replace").splitlines():
        word, *rest = line.split() or [""]
        if word == "v":
            vertices.append([float(x) for x in rest[:3]])
        elif word == "f":
            corners = [int(corner.split("/")[0]) for corner in rest]
            faces += fan([k - 1 if k > 0 else len(vertices) + k for k in corners])
    return np.array(vertices), np.array(faces)


def read_ply(data: bytes) -> tuple[Array, Array]:
    header, _, body = data.partition(b"end_header")
    body = body.partition(b"\n")[2]
    lines = [line.split() for line in header.decode("ascii", "replace").splitlines()]
    kind = next(words[1] for words in lines if words and words[0] == "format")
    order = {"binary_little_endian": "<", "binary_big_endian": ">"}.get(kind)
    words, place = iter(body.split() if order is None else []), 0

    def number(name: str) -> float:
        nonlocal place
        if order is None:
            return float(next(words))
        dtype = np.dtype(order + PLY_TYPES[name])
        place += dtype.itemsize
        return float(np.frombuffer(body, dtype, 1, place - dtype.itemsize)[0])

    vertices: list[list[float]] = []
    faces: list[tuple[int, int, int]] = []
    for start, (word, *rest) in ((k, line) for k, line in enumerate(lines) if line):
        if word != "element":
            continue
        after = (k for k in range(start + 1, len(lines)) if lines[k][0] == "element")
        properties = [p for p in lines[start + 1 : next(after, len(lines))] if p[0] == "property"]
        for _ in range(int(rest[1])):
            value: dict[str, Any] = {}
            for p in properties:
                if p[1] == "list":
                    value[p[-1]] = [int(number(p[3])) for _ in range(int(number(p[2])))]
                else:
                    value[p[-1]] = number(p[1])
            if rest[0] == "vertex":
                vertices.append([value["x"], value["y"], value["z"]])
            elif rest[0] == "face":
                faces += fan(value.get("vertex_indices") or value["vertex_index"])
    return np.array(vertices), np.array(faces)


def facets(thing: Scene, folder: Path) -> tuple[Array, Array]:
    """Corners (m, 3, 3) and normals (m, 3), of any length, of a triangle, polygon or mesh."""
    if thing["type"] == "mesh":
        path = folder / thing["file"]
        vertices, faces = {".obj": read_obj, ".ply": read_ply}[path.suffix](path.read_bytes())
        if thing.get("transform") is not None:
            m = np.array(thing["transform"], dtype=np.float64)
            vertices = np.stack([dot(vertices, row[:3]) + row[3] for row in m[:3]], axis=1)
    else:
        vertices = np.array(thing["vertices"], dtype=np.float64)
        faces = np.array(fan(list(range(len(vertices)))))
    abc = vertices[faces]
    N = cross(abc[:, 1] - abc[:, 0], abc[:, 2] - abc[:, 0])
    if thing["type"] == "polygon":
        N = np.broadcast_to(N.sum(axis=0), N.shape)
    return abc, N


def read_shapes(scene: Scene) -> Shapes:
    """All spheres and triangles; a triangle without area is left out, for it is never hit."""
    folder = Path(scene.get("folder") or ".")
    nothing = np.zeros(0, dtype=np.int64)
    no_vectors = np.zeros((0, 3))
    parts = [
        Shapes(
            nothing.astype(np.bool_), nothing, nothing,
            no_vectors, np.zeros(0), np.zeros((0, 3, 3)), no_vectors,
        )
    ]  # fmt: skip
    for number, thing in enumerate(scene["objects"]):
        if thing["type"] == "sphere":
            C = np.array([thing["center"]], dtype=np.float64)
            R, none = np.array([thing["radius"]], dtype=np.float64), np.zeros((1, 3, 3))
            index = np.array([number])
            parts.append(
                Shapes(np.array([True]), index, np.array([0]), C, R, none, np.zeros((1, 3)))
            )
            continue
        abc, N = facets(thing, folder)
        m = len(abc)
        shapes = Shapes(
            np.zeros(m, dtype=np.bool_), np.full(m, number), np.arange(m),
            np.zeros((m, 3)), np.zeros(m), abc, N,
        )  # fmt: skip
        parts.append(shapes.take((N != 0).any(axis=1)))
    names = Shapes.__dataclass_fields__
    return Shapes(**{name: np.concatenate([vars(p)[name] for p in parts]) for name in names})


def main() -> None:
    """Read a scene, render it, write an archive."""
    if len(sys.argv) != 3:
        sys.exit("usage: python tracer.py scene.json OUT.npz")
    path = Path(sys.argv[1])
    scene = json.loads(path.read_text(encoding="utf-8"))
    frame: dict[str, Any] = render({"folder": str(path.parent), **scene})
    np.savez(sys.argv[2], **frame)


if __name__ == "__main__":
    main()
