"""Who is timed: each finds the first hits of a scene's primary rays, in float64 or less."""

from __future__ import annotations

import importlib
import importlib.util
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import mkdtemp

import numpy as np
import trimesh

import minirt
from converters.placement import fitted_placement
from converters.povray import povray_scene
from minirt.render import primary_directions
from minirt.rules import SLIDES
from minirt.scene import Scene, Sphere
from minirt.vectors import Floats
from reference.renderers.llvm import find_llvm
from reference.renderers.mitsuba_world import load_world, start
from reference.renderers.povray_run import find_povray


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
    rays : int
        How many rays it is given at most: slow ones get fewer, and are judged by the ray.
    """

    lacking: Callable[[], str | None]
    prepare: Callable[[Scene, int], Callable[[], Floats | None]]
    most_spheres: int = 10_000
    most_triangles: int = 2_000_000
    rays: int = 640 * 480


def some(scene: Scene, rays: int) -> tuple[int, int]:
    """The first of so many pixels in the middle of the image, and one past the last."""
    start = (scene.screen.nx * scene.screen.ny - rays) // 2
    return start, start + rays


def _minirt(scene: Scene, rays: int) -> Callable[[], Floats | None]:
    minirt.render(scene, quantities="t")  # builds the trees
    return lambda: minirt.render(scene, quantities="t")["t"].ravel()


def _plain_loop(scene: Scene, rays: int) -> Callable[[], Floats | None]:
    """What a course's first tracer does: every ray against every object, kept where nearer."""
    P0 = np.array(scene.screen.P0)
    balls = [thing for thing in scene.objects if isinstance(thing, Sphere)]
    soup = [thing.vertices[thing.faces] for thing in scene.objects if not isinstance(thing, Sphere)]
    triangles = np.concatenate([np.zeros((0, 3, 3)), *soup])

    def trace() -> Floats:
        d = primary_directions(scene, SLIDES, np.arange(*some(scene, rays))).T
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


def _trimesh(engine: str) -> Callable[[Scene, int], Callable[[], Floats | None]]:
    def prepare(scene: Scene, rays: int) -> Callable[[], Floats | None]:
        (thing,) = scene.objects
        assert not isinstance(thing, Sphere)
        mesh = trimesh.Trimesh(thing.vertices, thing.faces, process=False)
        tracer = importlib.import_module(f"trimesh.ray.{engine}").RayMeshIntersector(mesh)
        P0 = np.array(scene.screen.P0)

        def trace() -> Floats:
            d = np.ascontiguousarray(
                primary_directions(scene, SLIDES, np.arange(*some(scene, rays))).T
            )
            origins = np.broadcast_to(P0, d.shape)
            points, ray, _ = tracer.intersects_location(origins, d, multiple_hits=False)
            t = np.full(rays, np.inf)
            t[ray] = np.linalg.norm(points - P0, axis=1) / np.linalg.norm(d[ray], axis=1)
            return t

        trace()
        return trace

    return prepare


def _raysect(scene: Scene, rays: int) -> Callable[[], Floats | None]:
    core, shapes = (importlib.import_module(f"raysect.{part}") for part in ("core", "primitive"))
    world = core.World()
    for thing in scene.objects:
        if isinstance(thing, Sphere):
            shapes.Sphere(thing.radius, parent=world, transform=core.translate(*thing.center))
        else:
            shapes.Mesh(thing.vertices, thing.faces, smoothing=False, parent=world)
    world.build_accelerator()
    origin = core.Point3D(*scene.screen.P0)

    def trace() -> Floats:
        t = np.full(rays, np.inf)
        for k, d in enumerate(primary_directions(scene, SLIDES, np.arange(*some(scene, rays))).T):
            hit = world.hit(core.Ray(origin, core.Vector3D(*d)))
            if hit is not None:
                t[k] = hit.ray_distance
        return t

    return trace


def _povray(scene: Scene, rays: int) -> Callable[[], Floats | None]:
    folder = Path(mkdtemp(prefix="minirt-bench-"))
    (folder / "scene.pov").write_text(povray_scene(scene), encoding="utf-8")
    program = str(find_povray())
    size = [f"+W{scene.screen.nx}", f"+H{scene.screen.ny}"]
    switches = ["+Iscene.pov", "+Oscene.png", "-A", "-D", "-V", "-P", "+WT1", "+Q0"]

    def draw() -> None:
        subprocess.run([program, *switches, *size], cwd=folder, check=True, capture_output=True)

    return draw


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

TRACERS: dict[str, Tracer] = {
    "minirt": Tracer(_always, _minirt),
    "plain loop": Tracer(_always, _plain_loop, most_triangles=100_000, rays=640 * 16),
    "raysect": Tracer(_package("raysect", "pip install raysect"), _raysect, rays=640 * 48),
    "POV-Ray, one core": Tracer(_no_povray, _povray, most_triangles=400_000),
    "Embree by trimesh": Tracer(
        _package("embreex", "pip install 'minirt[embree]'"), _trimesh("ray_pyembree"), 0
    ),
    "trimesh's own": Tracer(
        _package("rtree", "pip install rtree"),
        _trimesh("ray_triangle"),
        0,
        most_triangles=100_000,
        rays=640,
    ),
    "Mitsuba scalar": Tracer(_MITSUBA, _mitsuba("scalar_rgb")),
    "Mitsuba LLVM": Tracer(
        lambda: _MITSUBA() or _no_llvm(), _mitsuba("llvm_ad_rgb"), most_spheres=1_000
    ),
}
