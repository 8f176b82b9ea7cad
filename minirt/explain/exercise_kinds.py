"""S17: the three kinds of exercise, each with its text, its solution and a judge of answers.

An exercise with many right answers is not compared with one of them: any direction is right
whose ray meets the sphere in exactly one point.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import asin, degrees, isclose
from typing import Any

import numpy as np

from minirt.api import intersect_sphere
from minirt.errors import InputError
from minirt.optics import reflect
from minirt.vectors import Floats

#: Relative error that is accepted: that of an answer with six digits, and a little more.
CLOSE = 1e-5


@dataclass(frozen=True)
class Exercise(ABC):
    """One exercise: its text, its worked solution, and a judge of answers."""

    @property
    @abstractmethod
    def text(self) -> str:
        """What is asked."""

    @property
    @abstractmethod
    def solution(self) -> tuple[str, ...]:
        """The way to the answer, step by step."""

    @property
    @abstractmethod
    def answer(self) -> dict[str, Any]:
        """One right answer, in the form that `check` takes."""

    @abstractmethod
    def check(self, answer: Mapping[str, Any]) -> str:
        """Why an answer is wrong; empty where it is right.

        Raises
        ------
        InputError
            It has not the form of an answer.
        """


@dataclass(frozen=True)
class TangentDirection(Exercise):
    """Find a direction in which a ray from P0 touches a sphere (S8: Δ = 0)."""

    P0: tuple[float, ...]
    C: tuple[float, ...]
    R: float
    d: tuple[float, ...]

    @property
    def text(self) -> str:
        """What is asked."""
        return (
            f"Find a direction d in which the ray from P0 = {_point(self.P0)} is tangent to the "
            f"sphere with centre {_point(self.C)} and radius {_exact(self.R)}."
        )

    @property
    def solution(self) -> tuple[str, ...]:
        """All tangents, which form a cone; then one of them."""
        L = np.subtract(self.C, self.P0)
        far = float(np.linalg.norm(L))
        t = float(np.dot(L, self.d) / np.dot(self.d, self.d))
        M = np.add(self.P0, t * np.array(self.d))
        angle = degrees(asin(self.R / far))
        return (
            f"L = C − P0 = {_point(L)}, of length {_exact(far)}.",
            f"A tangent and L include α with sin α = R/|L| = {self.R / far:.6g}, α = {angle:.6g}°: "
            "the tangent directions are those of a cone about L.",
            "d is one of them where (d·L)² = (1 − R²/|L|²)·(d·d)(L·L) and d·L > 0, which is Δ = 0.",
            f"For example d = {_point(self.d)}: it touches at t = {t:.6g}, in {_point(M)}, and "
            f"M − C = {_point(M - self.C)} is perpendicular to d and of length R.",
        )

    @property
    def answer(self) -> dict[str, Any]:
        """One direction."""
        return {"direction": list(self.d)}

    def check(self, answer: Mapping[str, Any]) -> str:
        """Whether the ray meets the sphere in exactly one point ahead of P0."""
        d = _vector(answer, "direction")
        if not d.any():
            return "the zero vector is not a direction"
        L = np.subtract(self.C, self.P0)
        t = float(np.dot(L, d) / np.dot(d, d))
        distance = float(np.linalg.norm(L - t * d))
        if t <= 0:
            return "the sphere lies behind the ray"
        if isclose(distance, self.R, rel_tol=CLOSE):
            return ""
        hits = intersect_sphere(self.P0, d, self.C, self.R)
        if np.isfinite(hits.near):
            return f"the ray meets the sphere twice, at t = {hits.near:.6g} and t = {hits.far:.6g}"
        return f"the ray misses the sphere: it passes the centre at {distance:.6g}, not at R"


@dataclass(frozen=True)
class TangentSphere(Exercise):
    """Find a sphere that a ray touches."""

    P0: tuple[float, ...]
    d: tuple[float, ...]
    w: tuple[float, ...]
    t: float

    @property
    def text(self) -> str:
        """What is asked."""
        return (
            f"Give centre and radius of a sphere that is tangent to the ray from "
            f"P0 = {_point(self.P0)} in direction d = {_point(self.d)}."
        )

    @property
    def solution(self) -> tuple[str, ...]:
        """All tangent spheres; then one of them."""
        M = np.add(self.P0, self.t * np.array(self.d))
        R = float(np.linalg.norm(self.w))
        return (
            "Any point M = P0 + t·d with t > 0 can be where it touches, and any w ≠ 0 with w·d = 0 "
            "the way from there to the centre: C = M + w, R = |w|.",
            f"For example t = {self.t:.6g}: M = {_point(M)}; w = {_point(self.w)} has w·d = 0.",
            f"C = {_point(M + self.w)}, R = {_exact(R)}.",
        )

    @property
    def answer(self) -> dict[str, Any]:
        """One sphere."""
        M = np.add(self.P0, self.t * np.array(self.d))
        return {"center": (M + self.w).tolist(), "radius": float(np.linalg.norm(self.w))}

    def check(self, answer: Mapping[str, Any]) -> str:
        """Whether the centre is R away from the ray, at a point ahead of P0."""
        C, R = _vector(answer, "center"), _number(answer, "radius")
        if R <= 0:
            return "a radius is positive"
        L, d = C - self.P0, np.array(self.d)
        t = float(np.dot(L, d) / np.dot(d, d))
        distance = float(np.linalg.norm(L - t * d))
        if not isclose(distance, R, rel_tol=CLOSE):
            return f"the ray passes the centre at {distance:.6g}, and the radius is {R:.6g}"
        return "" if t > 0 else "it touches behind the ray's origin"


@dataclass(frozen=True)
class Reflection(Exercise):
    """Reflect a direction at a normal (S14)."""

    delta: tuple[float, ...]
    w: tuple[float, ...]

    @property
    def s(self) -> Floats:
        """The unit normal."""
        unit: Floats = np.array(self.w, dtype=np.float64) / np.linalg.norm(self.w)
        return unit

    @property
    def text(self) -> str:
        """What is asked."""
        return (
            f"A ray with direction δ = {_point(self.delta)} meets a surface with the unit normal "
            f"s = {_point(self.w)}/{_exact(float(np.linalg.norm(self.w)))}. Give the reflected "
            "direction ρ."
        )

    @property
    def solution(self) -> tuple[str, ...]:
        """The rule with its numbers."""
        along = float(np.dot(self.delta, self.s))
        return (
            f"δ·s = {along:.6g}; (δ·s)s = {_point(along * self.s)}, δ's part along the normal.",
            f"ρ = δ − 2(δ·s)s = {_point(reflect(self.delta, self.s))}.",
        )

    @property
    def answer(self) -> dict[str, Any]:
        """The reflected direction."""
        return {"direction": [round(x, 12) for x in reflect(self.delta, self.s).tolist()]}

    def check(self, answer: Mapping[str, Any]) -> str:
        """Whether ρ is as long as δ, with δ's part along the surface, and the other along s."""
        rho, delta = _vector(answer, "direction"), np.array(self.delta)
        slack = CLOSE * float(np.linalg.norm(delta))
        if np.abs(rho - reflect(delta, self.s)).max() <= slack:
            return ""
        if np.abs(rho + reflect(delta, self.s)).max() <= slack:
            return "it points the opposite way"
        if abs(np.linalg.norm(rho) - np.linalg.norm(delta)) > slack:
            return f"it is {np.linalg.norm(rho):.6g} long, and δ {np.linalg.norm(delta):.6g}"
        return "its part along the surface is not δ's, or its part along s is not −δ's"


def _vector(answer: Mapping[str, Any], name: str) -> Floats:
    value = answer.get(name)
    if not isinstance(value, list) or len(value) != 3:
        raise InputError("not an answer", where=name, got=repr(value)[:80], expected="3 numbers")
    return np.array([_float(x, name) for x in value])


def _number(answer: Mapping[str, Any], name: str) -> float:
    return _float(answer.get(name), name)


def _float(value: Any, name: str) -> float:
    usual = isinstance(value, int | float) and not isinstance(value, bool)
    if not usual or not abs(value) < 1e150:
        raise InputError("not an answer", where=name, got=repr(value)[:80], expected="a number")
    return float(value)


def _point(values: Sequence[float] | Floats) -> str:
    return f"({', '.join(f'{float(x) + 0.0:.6g}' for x in values)})"


def _exact(value: float) -> str:
    """A number as text; √n where only its square n is whole."""
    square = round(value * value)
    if isclose(value, round(value), rel_tol=1e-12):
        return f"{round(value)}"
    return f"√{square}" if isclose(value * value, square, rel_tol=1e-12) else f"{value:.6g}"
