"""The house rules that a machine can hold: imports one way, nothing at the root that does not
belong there, nothing in the tree that only one machine has."""

from __future__ import annotations

import ast
import re
import shutil
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from pathlib import Path

from tests.helpers.places import ROOT

PACKAGES = ("minirt", "converters", "reference", "reports")
FOLDERS = {*PACKAGES, "tests", "docs", ".ci", ".github"}
#: What every project has, and these folders beside it.
FILES = {
    "README.md", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", "LICENSE", "Makefile",
    "pyproject.toml", "requirements.lock", ".pre-commit-config.yaml", ".gitignore",
}  # fmt: skip
OF_A_MACHINE = re.compile(r"(?<![\w.}])/(work|home|root|Users)/")


def ignored(name: str) -> bool:
    patterns = (ROOT / ".gitignore").read_text(encoding="utf-8").split()
    return name == ".git" or any(fnmatch(name, pattern.rstrip("/")) for pattern in patterns)


def product_files() -> list[Path]:
    """Every file of the product, whether or not git is at hand."""
    tops = [path for path in ROOT.iterdir() if path.name in FOLDERS | FILES]
    found = [path for top in tops for path in (top, *top.rglob("*")) if path.is_file()]
    return [path for path in found if not any(map(ignored, path.relative_to(ROOT).parts))]


def test_the_root_holds_what_a_project_has_and_nothing_else() -> None:
    names = {path.name for path in ROOT.iterdir() if not ignored(path.name)}
    assert names >= FOLDERS | FILES
    assert names <= FOLDERS | FILES | {".gitattributes"}
    assert {path.name for path in (ROOT / ".github").iterdir()} == {
        "ISSUE_TEMPLATE", "PULL_REQUEST_TEMPLATE.md", "report.png", "workflows",
    }  # fmt: skip


def test_no_file_names_a_place_of_one_machine() -> None:
    files = product_files()
    texts = {path: path.read_bytes().decode("utf-8", errors="replace") for path in files}
    assert ROOT / "Makefile" in texts
    assert [path for path, text in texts.items() if OF_A_MACHINE.search(text)] == []


def test_a_place_of_one_machine_is_seen() -> None:
    planted = "open('/" + "home/ana/scene.json')"
    assert OF_A_MACHINE.search(planted)
    assert not OF_A_MACHINE.search("https://example.org/home/page and minirt/work/")


def packages_imported(folder: Path) -> set[str]:
    """Packages outside the standard library that the modules of a folder import, wherever."""
    names: set[str] = set()
    for path in folder.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names.update(alias.name for alias in node.names)
            elif isinstance(node, ast.ImportFrom):
                names.add(node.module or "")
    return {name.partition(".")[0] for name in names} - sys.stdlib_module_names


def test_minirt_imports_numpy_and_pydantic_and_no_other_package() -> None:
    assert packages_imported(ROOT / "minirt") == {"minirt", "numpy", "pydantic", "pydantic_core"}


#: Imports that break a contract, by the contract's id. `make architecture` checks the real tree.
PLANTED = {
    "culling": ("minirt -> minirt.culling.tree", "reference -> minirt.culling.slabs"),
    "layers": ("minirt -> reports", "converters -> reference"),
    "light": ("minirt -> trimesh",),
    "renderers": ("reference -> mitsuba", "reference -> embreex"),
    "judge": ("reference -> flint",),
    "cluster": ("reports -> distributed",),
}


def test_a_planted_import_breaks_its_contract(tmp_path: Path) -> None:
    """All are planted into one tree; the report names each under its own contract."""
    for name in PACKAGES:
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("*.json"))
    shutil.copy(ROOT / "pyproject.toml", tmp_path)
    for arrow in (arrow for arrows in PLANTED.values() for arrow in arrows):
        package, imported = arrow.split(" -> ")
        name = f"planted_{imported}".replace(".", "_")
        file = tmp_path / package / f"{name}.py"
        file.write_text(f'"""Planted."""\n\nimport {imported}\n', encoding="utf-8")
    command = [str(Path(sys.executable).with_name("lint-imports")), "--no-logo", "--no-cache"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 1
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    names = {each["id"]: each["name"] for each in settings["tool"]["importlinter"]["contracts"]}
    assert set(PLANTED) == set(names), "each contract has its planted import"
    broken = done.stdout.partition("Broken contracts")[2]
    for contract, arrows in PLANTED.items():
        section = re.split(r"^-+$", broken.partition(f"\n{names[contract]}\n")[2], flags=re.M)[1]
        for arrow in arrows:
            package, imported = arrow.split(" -> ")
            name = f"planted_{imported}".replace(".", "_")
            assert f"{package}.{name} -> {imported} (l.3)" in section, done.stdout
