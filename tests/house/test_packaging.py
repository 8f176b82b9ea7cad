"""The wheel holds all that minirt needs, and runs beside its declared dependencies alone."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tomllib
import venv
import zipfile
from importlib import metadata
from pathlib import Path

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.helpers.places import ROOT

PACKAGES = ("minirt", "converters", "reference", "reports")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built without the network from a copy, so that nothing is left in the tree."""
    source = tmp_path_factory.mktemp("source")
    for name in PACKAGES:
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source)
    run(sys.executable, "-m", "build", "--wheel", "--no-isolation", cwd=source)
    (built,) = (source / "dist").glob("*.whl")
    return built


@pytest.fixture(scope="module")
def installed(wheel: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment with the wheel and the base dependencies it declares, and no more."""
    environment = tmp_path_factory.mktemp("environment")
    venv.create(environment, symlinks=True)
    python = environment / "bin" / "python"
    run(sys.executable, "-m", "pip", "--python", str(python), "install", "--quiet",
        "--no-deps", "--no-index", str(wheel), cwd=environment)  # fmt: skip
    (site,) = environment.glob("lib/python*/site-packages")
    for name in closure(PROJECT["dependencies"]):
        lend(name, site)
    return environment


def run(*command: str, cwd: Path) -> str:
    """Standard output of a command that ends well, away from the checkout and its settings."""
    clean = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    done = subprocess.run(command, cwd=cwd, env=clean, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def closure(requirements: list[str]) -> set[str]:
    """Canonical names of the distributions that requirements lead to here, extras left out."""
    found: set[str] = set()
    pending = [Requirement(text) for text in requirements]
    while pending:
        wanted = pending.pop()
        name = canonicalize_name(wanted.name)
        if name not in found and (wanted.marker is None or wanted.marker.evaluate({"extra": ""})):
            found.add(name)
            pending += [Requirement(text) for text in metadata.requires(name) or ()]
    return found


def lend(name: str, site: Path) -> None:
    """Link a distribution's files, as they are installed here, into another site-packages."""
    distribution = metadata.distribution(name)
    for top in {file.parts[0] for file in distribution.files or ()} - {"..", "__pycache__"}:
        if not (site / top).exists():
            (site / top).symlink_to(Path(str(distribution.locate_file(top))))


def test_wheel_holds_every_file_of_every_package(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        shipped = {name for name in archive.namelist() if ".dist-info/" not in name}
    ours = {
        path.relative_to(ROOT).as_posix()
        for package in PACKAGES
        for path in (ROOT / package).rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    assert {name for name in ours if name.startswith("minirt/atlas/")}
    assert {name for name in ours if name.startswith("reports/page/templates/")}
    assert shipped == ours


def test_wheel_states_version_license_and_command(wheel: Path) -> None:
    with zipfile.ZipFile(wheel) as archive:
        about = {Path(n).name: archive.read(n).decode() for n in archive.namelist() if "info/" in n}
    version = (ROOT / "minirt" / "version.py").read_text(encoding="utf-8").split('"')[-2]
    assert f"\nVersion: {version}\n" in about["METADATA"]
    assert "\nLicense-Expression: MIT\n" in about["METADATA"]
    assert "MIT License" in about["LICENSE"]
    assert "minirt = reports.cli.main:main" in about["entry_points.txt"]


@pytest.mark.full
def test_installed_command_lists_the_atlas(installed: Path, tmp_path: Path) -> None:
    names = [path.stem for path in (ROOT / "minirt" / "atlas").glob("*.json")]
    listed = run(str(installed / "bin" / "minirt"), "scenes", "--json", cwd=tmp_path)
    assert names
    assert [name for name in names if f'"{name}"' not in listed] == []


@pytest.mark.full
def test_installed_command_renders_away_from_the_checkout(installed: Path, tmp_path: Path) -> None:
    scene = min((ROOT / "minirt" / "atlas").glob("*.json")).stem
    run(str(installed / "bin" / "minirt"), "render", f"atlas:{scene}", "-o", "out.exr",
        cwd=tmp_path)  # fmt: skip
    assert (tmp_path / "out.exr").stat().st_size > 0
    where = run(str(installed / "bin" / "python"), "-c", "import minirt; print(minirt.__file__)",
                cwd=tmp_path)  # fmt: skip
    assert Path(where.strip()).is_relative_to(installed)


def test_lock_pins_every_dependency_and_names_no_index() -> None:
    lines = (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()
    pinned = {canonicalize_name(line.split("==")[0]) for line in lines if "==" in line[:60]}
    extras = PROJECT["optional-dependencies"].values()
    wanted = PROJECT["dependencies"] + [text for extra in extras for text in extra]
    assert len(wanted) > 10
    assert [t for t in wanted if canonicalize_name(Requirement(t).name) not in pinned] == []
    assert [line for line in lines if "://" in line or line.lstrip().startswith("-i")] == []
