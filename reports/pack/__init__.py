"""Packs: reference images that say what confirms them, and that prove themselves again."""

from reports.pack.check import Difference, differences
from reports.pack.make import approve_pack, make_pack
from reports.pack.manifest import Manifest, read_manifest

__all__ = [
    "Difference", "Manifest", "approve_pack", "differences", "make_pack", "read_manifest",
]  # fmt: skip
