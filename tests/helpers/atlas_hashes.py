"""SHA-256 of every quantity of every scene of the atlas: ``python -m tests.helpers.atlas_hashes``.

Printed as one JSON document. What is printed for the lecture's own rules is kept in
`atlas-hashes.json` beside this file; a change of it is a change of minirt's answers.
"""

from __future__ import annotations

import hashlib
import json
import sys

import minirt
from minirt.scene_file.atlas import atlas_names
from tests.helpers.places import HELPERS

KEPT = HELPERS / "atlas-hashes.json"


def hashes_of(scene: minirt.Scene, quantities: str | None = None) -> dict[str, str]:
    """SHA-256 of the bytes of each quantity, all of them or those named."""
    frame = minirt.render(scene, quantities=quantities)
    return {name: hashlib.sha256(frame[name].tobytes()).hexdigest() for name in frame}


def kept_hashes() -> dict[str, dict[str, str]]:
    """What is kept: by scene and quantity."""
    found: dict[str, dict[str, str]] = json.loads(KEPT.read_text(encoding="utf-8"))
    return found


def main() -> None:
    """Print the hashes of the whole atlas."""
    found = {name: hashes_of(minirt.load_scene(f"atlas:{name}")) for name in atlas_names()}
    sys.stdout.write(json.dumps(found, indent=1) + "\n")


if __name__ == "__main__":
    main()
