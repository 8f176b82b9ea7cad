"""The gate as a pytest plugin, in a pytest of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from converters.scene_folder import plain_document
from tests.helpers.fake_references import small_scene
from tests.helpers.places import HELPERS
from tests.helpers.tiers import tiered


@pytest.fixture
def scenes(tmp_path: Path) -> str:
    """Two scenes, as the option takes them."""
    paths = []
    for name in ("ball", "second"):
        path = tmp_path / f"{name}.json"
        path.write_text(json.dumps(plain_document(small_scene(name))), encoding="utf-8")
        paths.append(str(path))
    return ",".join(paths)


def pytest_with(folder: Path, *options: str) -> tuple[int, str]:
    """Exit status and output of pytest in an empty folder."""
    empty = folder / "empty"
    empty.mkdir()
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-p", "no:cacheprovider", "-rsf", *options, str(empty)],
        cwd=HELPERS, capture_output=True, text=True, timeout=300,
        env=os.environ | {"XDG_CACHE_HOME": str(folder / "cache")},
    )  # fmt: skip
    return done.returncode, done.stdout + done.stderr


@pytest.mark.full
def test_one_test_a_scene_and_quantity_and_k_chooses(tmp_path: Path, scenes: str) -> None:
    options = ["--minirt-gate-python", "gate_subjects:few", "--minirt-gate-scenes", scenes]
    status, output = pytest_with(tmp_path, *options, "-n", "2", "-k", "ball or depth")
    assert status == 0, output
    # Of ball: 2 given and 18 not; of second: depth.
    assert "3 passed, 18 skipped" in output
    assert "not given: the frame does not hold it" in output


def test_what_is_wrong_fails_with_its_worst_pixel(tmp_path: Path, scenes: str) -> None:
    options = ["--minirt-gate-python", "gate_subjects:no_half_pixel", "-k", "second-ray"]
    status, output = pytest_with(tmp_path, *options, "--minirt-gate-scenes", scenes)
    assert status == 1
    assert "FAILED" in output
    assert "minirt-gate::second-ray" in output
    assert "ray: failed: 1728 of 1728 certain pixels wrong" in output
    assert "worst pixel (" in output


@pytest.mark.parametrize(
    ("option", "value", "words"),
    tiered(
        [
            ("scenes", "atlas:nothing-of-the-kind", "no such scene"),
            ("quantities", "dept", "unknown quantity"),
            ("precision", "float128", "float128"),
            ("delta", "wide", "delta: not what the option takes"),
            ("frames", "folder", "one implementation at a time"),
        ],
        lambda case: case[0] == "quantities",
    ),
)
def test_misuse_is_a_usage_error(tmp_path: Path, option: str, value: str, words: str) -> None:
    options = ["--minirt-gate-python", "gate_subjects:few", f"--minirt-gate-{option}", value]
    status, output = pytest_with(tmp_path, *options)
    assert status == 4
    assert words in output
    assert "Traceback" not in output


def test_without_its_options_it_does_nothing(tmp_path: Path) -> None:
    status, output = pytest_with(tmp_path)
    assert status == 5
    assert "no tests ran" in output
