"""Who is timed: each finds the first hits of a scene's primary rays, in float64 or less."""

from __future__ import annotations

import importlib
import importlib.util
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from itertools import repeat
from pathlib import Path
from tempfile import mkdtemp
from typing import TypeAlias

import numpy as np
import trimesh

import minirt
from converters.placement import fitted_placement
from converters.povray.scene import povray_scene
from minirt.geometry import Geometry
from minirt.rays import Rays
from minirt.rules import SLIDES
from minirt.scene import Scene, Sphere
from minirt.trace import RT, World
from minirt.vectors import Floats, Index
from minirt.whitted import primary_directions
from reference.renderers.mitsuba.llvm import find_llvm
from reference.renderers.mitsuba.world import load_world, start
from reference.renderers.povray.run import find_povray

#: Of a scene: t of the first hits of rays, whose origins are (3,) or (n, 3), directions (n, 3).
Shoot: TypeAlias = Callable[[Scene], Callable[[Floats, Floats], Floats | None]]


@dataclass(frozen=True)
class Tracer:
    """One that is timed.

    Attributes
    ----------
    lacking : callable
        Why it cannot run here, with the command that would bring it; None where it can.
    prepare : callable
        Builds what it needs of a scene, and gives what is timed: called with nothing, it answers
        with t of the first hits, in minirt's unit, of the pixels that `some` gives; None where it
        tells no lengths.
    most_spheres, most_triangles : int
        Primitives beyond which it would take too long; 0 where it has no such primitive.
    rays, pairs : int
        How many rays it is given at most, or pairs of a ray and a primitive, if that is more rays:
        slow ones get fewer, and are judged by the ray.
    shoot : callable or None
        As `prepare`, of a scene alone: what it gives is called with the origins and the directions
        of any rays, (n, 3). None where it draws images only.
    draw : callable or None
        As `prepare`, of a scene alone: draws the whole image, with shadows and mirrors. None where
        it follows other rules.
    """

    lacking: Callable[[], str | None]
    prepare: Callable[[Scene, int], Callable[[], Floats | None]]
    most_spheres: int = 10_000
    most_triangles: int = 2_000_000
    rays: int = 640 * 480
    pairs: int = 0
    shoot: Shoot | None = None
    draw: Callable[[Scene], Callable[[], object]] | None = None


def some(scene: Scene, rays: int) -> Index:
    """So many pixels, (rays,), spread evenly over the image."""
    return np.linspace(0, scene.screen.nx * scene.screen.ny - 1, rays).astype(np.intp)


def _pixels(shoot: Shoot) -> Callable[[Scene, int], Callable[[], Floats | None]]:
    """`prepare` of one that takes any rays: their directions are computed while it is timed."""

    def prepare(scene: Scene, rays: int) -> Callable[[], Floats | None]:
        first_hits = shoot(scene)
        P0, pixels = np.array(scene.screen.P0), some(scene, rays)
        return lambda: first_hits(P0, primary_directions(scene, SLIDES, pixels).T)

    return prepare


def _minirt(scene: Scene, rays: int) -> Callable[[], Floats | None]:
    minirt.render(scene, quantities="t")  # builds the trees
    return lambda: minirt.render(scene, quantities="t")["t"].ravel()


def _minirt_shoots(scene: Scene) -> Callable[[Floats, Floats], Floats | None]:
    world = World.of(Geometry.of(scene), SLIDES)

    def first_hits(P0: Floats, d: Floats) -> Floats:
        return RT(world, Rays.of(P0.T, d.T)).t

    first_hits(np.array([scene.screen.P0]), np.ones((1, 3)))  # builds the trees
    return first_hits


def _plain_loop(scene: Scene, rays: int) -> Callable[[], Floats | None]:
    """What a course's first tracer does: every ray against every object, kept where nearer."""
    P0 = np.array(scene.screen.P0)
    pixels = some(scene, rays)
    balls = [thing for thing in scene.objects if isinstance(thing, Sphere)]
    soup = [thing.vertices[thing.faces] for thing in scene.objects if not isinstance(thing, Sphere)]
    triangles = np.concatenate([np.zeros((0, 3, 3)), *soup])

    def trace() -> Floats:
        d = primary_directions(scene, SLIDES, pixels).T
        best = np.full(rays, np.inf)
        a = (d * d).sum(axis=1)
        for ball in balls:
            L = P0 - np.array(ball.center)
            b, c = d @ L, L @ L - ball.radius**2
            discriminant = b * b - a * c
            root = np.sqrt(np.maximum(discriminant, 0))
            for t in ((-b - root) / a, (-b + root) / a):
                np.copyto(best, t, where=(discriminant >= 0) & (t > 0) & (t < best))
        for p, q, r in triangles:
            e, f = q - p, r - p
            h = np.cross(d, f)
            with np.errstate(divide="ignore", invalid="ignore"):
                scale = 1 / (h @ e)
                s = P0 - p
                beta = (h @ s) * scale
                k = np.cross(s, e)
                gamma = (d @ k) * scale
                t = (f @ k) * scale
            inside = (beta >= 0) & (gamma >= 0) & (beta + gamma <= 1)
            np.copyto(best, t, where=inside & (t > 0) & (t < best))
        return best

    return trace


def _trimesh(engine: str, located: bool = True) -> Shoot:
    """trimesh with one of its engines: where the hits are, or no more than which faces."""

    def shoot(scene: Scene) -> Callable[[Floats, Floats], Floats | None]:
        (thing,) = scene.objects
        assert not isinstance(thing, Sphere)
        mesh = trimesh.Trimesh(thing.vertices, thing.faces, process=False)
        tracer = importlib.import_module(f"trimesh.ray.{engine}").RayMeshIntersector(mesh)

        def first_faces(P0: Floats, d: Floats) -> None:
            tracer.intersects_first(np.broadcast_to(P0, d.shape), d)

        def first_hits(P0: Floats, d: Floats) -> Floats:
            origins = np.broadcast_to(P0, d.shape)
            points, ray, _ = tracer.intersects_location(origins, d, multiple_hits=False)
            t = np.full(len(d), np.inf)
            t[ray] = np.linalg.norm(points - origins[ray], axis=1) / np.linalg.norm(d[ray], axis=1)
            return t

        return first_hits if located else first_faces

    return shoot


def _raysect(scene: Scene) -> Callable[[Floats, Floats], Floats | None]:
    core, shapes = (importlib.import_module(f"raysect.{part}") for part in ("core", "primitive"))
    world = core.World()
    for thing in scene.objects:
        if isinstance(thing, Sphere):
            shapes.Sphere(thing.radius, parent=world, transform=core.translate(*thing.center))
        else:
            shapes.Mesh(thing.vertices, thing.faces, smoothing=False, parent=world)
    world.build_accelerator()

    def first_hits(P0: Floats, d: Floats) -> Floats:
        t = np.full(len(d), np.inf)
        one = repeat(core.Point3D(*P0)) if P0.ndim == 1 else (core.Point3D(*point) for point in P0)
        for k, (origin, direction) in enumerate(zip(one, d, strict=False)):
            hit = world.hit(core.Ray(origin, core.Vector3D(*direction)))
            if hit is not None:
                t[k] = hit.ray_distance
        return t

    return first_hits


def _povray(scene: Scene, quality: str) -> Callable[[], Floats | None]:
    folder = Path(mkdtemp(prefix="minirt-bench-"))
    (folder / "scene.pov").write_text(povray_scene(scene), encoding="utf-8")
    program = str(find_povray())
    size = [f"+W{scene.screen.nx}", f"+H{scene.screen.ny}"]
    switches = ["+Iscene.pov", "+Oscene.png", "-A", "-D", "-V", "-P", "+WT1", quality]

    def draw() -> None:
        subprocess.run([program, *switches, *size], cwd=folder, check=True, capture_output=True)

    return draw


def _mitsuba_shoots(variant: str) -> Shoot:
    """All rays in one call: for a vectorised variant."""

    def shoot(scene: Scene) -> Callable[[Floats, Floats], Floats | None]:
        mi, dr = start(variant)
        placement = fitted_placement(scene)
        world = load_world(mi, dr, scene, Path(mkdtemp(prefix="minirt-bench-")), placement)

        def first_hits(P0: Floats, d: Floats) -> Floats:
            origins = placement.points(P0).T.astype(np.float32)
            ray = mi.Ray3f(mi.Point3f(origins), mi.Vector3f(d.T.astype(np.float32)))
            return np.array(world.scene.ray_intersect_preliminary(ray).t, dtype=np.float64)

        return first_hits

    return shoot


def _mitsuba(variant: str) -> Callable[[Scene, int], Callable[[], Floats | None]]:
    def prepare(scene: Scene, rays: int) -> Callable[[], Floats | None]:
        mi, dr = start(variant)
        placement = fitted_placement(scene)
        world = load_world(mi, dr, scene, Path(mkdtemp(prefix="minirt-bench-")), placement)
        depth = mi.load_dict({"type": "depth"})

        def draw() -> None:
            dr.eval(mi.render(world.scene, sensor=world.sensor, integrator=depth, spp=1))
            dr.sync_thread()

        draw()
        return draw

    return prepare


def _package(name: str, command: str) -> Callable[[], str | None]:
    return lambda: None if importlib.util.find_spec(name) else f"no {name}: {command}"


def _always() -> str | None:
    return None


def _no_povray() -> str | None:
    return None if find_povray() else "no POV-Ray: apt-get install povray"


def _no_llvm() -> str | None:
    return None if find_llvm() else "no libLLVM of version 18 or newer"


_MITSUBA = _package("mitsuba", "pip install 'minirt[mitsuba]'")

_RTREE = _package("rtree", "pip install rtree")
_EMBREE = _package("embreex", "pip install 'minirt[embree]'")
_RAYSECT = _package("raysect", "pip install raysect")
_OF_EMBREE, _OF_EMBREES_FACES = _trimesh("ray_pyembree"), _trimesh("ray_pyembree", located=False)
_OF_TRIMESH = _trimesh("ray_triangle")

TRACERS: dict[str, Tracer] = {
    "minirt": Tracer(
        _always,
        _minirt,
        shoot=_minirt_shoots,
        draw=lambda scene: lambda: minirt.render(scene, quantities="color"),
    ),
    "plain loop": Tracer(
        _always, _plain_loop, most_triangles=100_000, rays=640 * 16, pairs=640 * 480 * 100
    ),
    "raysect": Tracer(_RAYSECT, _pixels(_raysect), rays=640 * 48, shoot=_raysect),
    "POV-Ray": Tracer(
        _no_povray,
        lambda scene, rays: _povray(scene, "+Q0"),
        most_triangles=400_000,
        draw=lambda scene: _povray(scene, "+Q9"),
    ),
    "Embree": Tracer(_EMBREE, _pixels(_OF_EMBREE), 0, shoot=_OF_EMBREE),
    "Embree, faces only": Tracer(_EMBREE, _pixels(_OF_EMBREES_FACES), 0, shoot=_OF_EMBREES_FACES),
    "trimesh": Tracer(
        _RTREE, _pixels(_OF_TRIMESH), 0, most_triangles=100_000, rays=640, shoot=_OF_TRIMESH
    ),
    "Mitsuba scalar": Tracer(_MITSUBA, _mitsuba("scalar_rgb")),
    "Mitsuba LLVM": Tracer(
        lambda: _MITSUBA() or _no_llvm(),
        _mitsuba("llvm_ad_rgb"),
        most_spheres=1_000,
        shoot=_mitsuba_shoots("llvm_ad_rgb"),
    ),
}
