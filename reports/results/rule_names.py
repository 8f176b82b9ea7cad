"""The lecture's rules, and the departures from its letter, in a few words each, for tables."""

from __future__ import annotations

RULE_NAMES: dict[str, str] = {
    "S1": "the viewing frame P0, u, v, n and the virtual screen n = ν",
    "S2": "pixel centres, half a pixel in; row j = 0 at the bottom",
    "S3": "from viewing to modelling coordinates",
    "S4": "a ray through each pixel; the first object hit",
    "S5": "r(t) = P0 + t·d with t = 1 at the screen; order in t",
    "S6": "RT(P0, d, t0, t1): ∅ or the first hit in [t0, t1]",
    "S7": "the colour of a ray",
    "S8": "sphere: the smallest positive root",
    "S9": "triangle: t, β, γ; its three cases",
    "S10": "a polygon's plane",
    "S11": "convex polygon: a fan of m − 2 triangles",
    "S12": "shadow: RT(M, −l, ε, ∞)",
    "S13": "illumination: ambient + diffuse + specular",
    "S14": "reflected direction ρ",
    "S15": "Snell's law",
    "S16": "refracted direction ϱ",
    "E1": "S16 with s turned along the ray that goes on",
    "E2": "total internal reflection",
    "S17": "the three exercises",
    "E3": "t ∈ [t0, t1]; only the weights lie in [0, 1]",
    "E4": "ε is the third argument of RT",
    "E5": "M is the surface point, not the pixel's centre",
    "E6": "(−δ·s)s is the projection of −δ",
    "E7": "p is the normal of the polygon's plane",
    "E8": "sphere: the same roots, without the lost digits",
}
