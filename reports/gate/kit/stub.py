"""A tracer to begin with: hit and depth of the spheres of a scene. It needs NumPy.

As a program, ``python stub.py scene.json OUT.npz``; as a function, ``stub:render``.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np


def primary_directions(screen: dict[str, Any]) -> Any:
    """d = P − P0 of each pixel, (ny, nx, 3): t = 1 at the screen. Source: S2, S3, S5."""
    i, j = np.arange(screen["nx"]), np.arange(screen["ny"])
    j = j[::-1, None]  # the image's rows start at the top, the screen's at the bottom
    x = screen["l"] + (screen["r"] - screen["l"]) / screen["nx"] * (i + 0.5)
    y = screen["b"] + (screen["t"] - screen["b"]) / screen["ny"] * (j + 0.5)
    u, v, n = (np.array(screen[axis], dtype=np.float64) for axis in "uvn")
    return x[..., None] * u + y[..., None] * v + screen["nu"] * n


def sphere_t(P0: Any, d: Any, C: Any, R: float) -> Any:
    """The smallest positive root, so evaluated that far spheres keep digits. Source: S8, E8."""
    L = np.array(C, dtype=np.float64) - P0
    a, b = (d * d).sum(axis=-1), (d * L).sum(axis=-1)
    q = L - (b / a)[..., None] * d  # from the line to C
    quarter_delta = a * (R * R - (q * q).sum(axis=-1))
    larger = b + np.copysign(np.sqrt(np.maximum(quarter_delta, 0.0)), b)
    smaller = ((L * L).sum() - R * R) / np.where(larger == 0, np.inf, larger)
    roots = np.stack((larger / a, smaller))
    return np.where((roots > 0) & (quarter_delta >= 0), roots, np.inf).min(axis=0)


def render(scene: dict[str, Any]) -> dict[str, Any]:
    """Some quantities of a scene, each (ny, nx) or (ny, nx, 3), row 0 at the top."""
    screen = scene["screen"]
    P0, d = np.array(screen["P0"], dtype=np.float64), primary_directions(screen)
    t = np.full((screen["ny"], screen["nx"]), np.inf)
    for thing in scene["objects"]:
        if thing["type"] == "sphere":
            t = np.minimum(t, sphere_t(P0, d, thing["center"], thing["radius"]))
        # Go on here: "triangle" (S9), "polygon" (S10, S11), "mesh", whose file lies in
        # scene["folder"]; then object, t, position, normal, shadow (S12), … See README.md.
    return {"hit": np.isfinite(t), "depth": t * abs(screen["nu"])}


def main() -> None:
    """Read a scene, render it, write an archive."""
    path = Path(sys.argv[1])
    scene = json.loads(path.read_text(encoding="utf-8"))
    np.savez(sys.argv[2], **render({"folder": str(path.parent), **scene}))


if __name__ == "__main__":
    main()
