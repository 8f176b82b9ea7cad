"""`minirt fuzz`: exit statuses, what it prints, and the files that a failure becomes."""

from __future__ import annotations

import json
import runpy
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import minirt
from reference import registry
from reports.cli.main import run
from reports.gate.subject import OutFormat, Subject, claim_of
from tests.helpers.fake_references import Honest, InsideOut, Missing
from tests.helpers.places import HELPERS

INTERSECT = """
Answer intersect(const double[3], const double[3]) {{
    Answer answer = expected;
    answer.object += {wrong};
    return answer;
}}
"""


@pytest.fixture
def fakes(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    fakes: dict[str, Any] = {fake.name: fake for fake in (Honest(), InsideOut(), Missing())}
    monkeypatch.setattr(registry, "REFERENCES", fakes)
    monkeypatch.setattr(registry, "USUAL", ("honest",))
    return fakes


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> tuple[int, Path]:
    """The exit status and the folder of a campaign that finds one failure."""
    out = tmp_path_factory.mktemp("campaign")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(registry, "REFERENCES", {"inside-out": InsideOut()})
        patch.setattr("reference.fuzz.campaign.MOST_FAILURES", 1)
        status = run(
            ["fuzz", "--seed", "7", "--scenes", "9", "--reference", "inside-out", "-o", str(out)]
        )
    (case,) = out.iterdir()
    return status, case


def test_a_failure_is_written_whole(found: tuple[int, Path]) -> None:
    status, case = found
    assert status == 1
    name = f"test_{case.name}"
    assert {path.name for path in case.iterdir()} >= {
        "scene.json", "explain.txt", f"{name}.py", f"{name}.cpp",
    }  # fmt: skip


def test_the_scene_loads_and_is_small(found: tuple[int, Path]) -> None:
    scene = minirt.load_scene(found[1] / "scene.json")
    assert len(scene.objects) == 1
    assert scene.screen.nx <= 8
    assert scene.screen.ny <= 8
    assert scene.about.startswith("inside-out fails fuzz-7-")
    assert "first in normal" in scene.about


def test_written_scene_is_the_shrunk_one_on_few_lines(found: tuple[int, Path]) -> None:
    text = (found[1] / "scene.json").read_text(encoding="utf-8")
    assert text.count("\n") < 60
    assert "null" not in text.replace('"ior": null', "")
    assert '"P0": [0.0, 0.0, 0.0]' in text


def test_the_explanation_is_of_the_pixel(found: tuple[int, Path]) -> None:
    text = (found[1] / "explain.txt").read_text(encoding="utf-8")
    assert "first in normal" in text
    assert "the pixel's centre" in text
    assert "\x1b" not in text


def generated_test(case: Path) -> Callable[[], None]:
    names = runpy.run_path(str(case / f"test_{case.name}.py"))
    test: Callable[[], None] = names[f"test_{case.name}"]
    return test


def test_the_python_test_fails_with_the_faulty_and_passes_with_an_honest_one(
    found: tuple[int, Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    test = generated_test(found[1])
    monkeypatch.setattr(registry, "REFERENCES", {"inside-out": InsideOut()})
    with pytest.raises(AssertionError, match="failed, normal: normal: 1 of 1 certain pixels"):
        test()
    monkeypatch.setattr(registry, "REFERENCES", {"inside-out": Honest()})
    test()


def compiler() -> str:
    found = shutil.which("g++") or shutil.which("c++") or shutil.which("clang++")
    assert found, "a C++ compiler is needed"
    return found


def test_the_cpp_test_compiles(found: tuple[int, Path]) -> None:
    source = found[1] / f"test_{found[1].name}.cpp"
    flags = ["-std=c++17", "-Wall", "-Wextra", "-Werror", "-fsyntax-only"]
    subprocess.run([compiler(), *flags, str(source)], check=True)


@pytest.mark.parametrize("wrong", [0, 1])
def test_the_cpp_test_judges(found: tuple[int, Path], wrong: int, tmp_path: Path) -> None:
    text = (found[1] / f"test_{found[1].name}.cpp").read_text(encoding="utf-8")
    source, program = tmp_path / "test.cpp", tmp_path / "test"
    source.write_text(text + INTERSECT.format(wrong=wrong), encoding="utf-8")
    subprocess.run([compiler(), "-std=c++17", str(source), "-o", str(program)], check=True)
    assert subprocess.run([str(program)], capture_output=True).returncode == wrong


@pytest.mark.usefixtures("fakes")
def test_nothing_found_is_status_0_and_json_is_one_document(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    arguments = ["fuzz", "--seed", "1", "--scenes", "2", "--out", str(tmp_path), "--json"]
    assert run(arguments) == 0
    document = json.loads(capsys.readouterr().out)
    assert (document["scenes"], document["compared"], document["failures"]) == (2, 2, [])
    assert document["certain_share"] >= document["certain_floor"]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("fakes")
def test_a_missing_reference_is_status_3_and_an_unknown_one_2(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    fuzz = ["fuzz", "--scenes", "1", "--out", str(tmp_path), "--reference"]
    assert run([*fuzz, "missing"]) == 3
    assert "missing is missing: not installed" in capsys.readouterr().err
    assert run([*fuzz, "nobody"]) == 2
    assert "unknown reference" in capsys.readouterr().err


FUZZ = ["fuzz", "--seed", "7", "--scenes", "1"]


@pytest.mark.full
def test_somebody_elses_function_is_fuzzed_and_its_test_is_ready(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(HELPERS)
    wrong = ["--python", "gate_subjects:no_half_pixel", "--timeout", "50"]
    assert run([*FUZZ, *wrong, "--out", str(tmp_path)]) == 1
    (case,) = tmp_path.iterdir()
    with pytest.raises(AssertionError, match="failed, ray: "):
        generated_test(case)()
    file = case / f"test_{case.name}.py"
    text = file.read_text(encoding="utf-8")
    assert "'timeout': 50.0" in text
    file.write_text(text.replace(":no_half_pixel", ":honest"), encoding="utf-8")
    generated_test(case)()


def test_an_honest_program_passes_a_campaign(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(HELPERS)
    command = f"{sys.executable} gate_subjects.py {{scene}} {{out}}"
    arguments = [*FUZZ, "--cmd", command, "--out-as", "npz", "--out", str(tmp_path)]
    assert run(arguments) == 0
    assert "1 comparison, 0 failures" in capsys.readouterr().out


def test_frames_rendered_earlier_cannot_be_campaign_sentence(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert run([*FUZZ, "--frames", str(tmp_path), "--out", str(tmp_path)]) == 2
    assert "--frames" in capsys.readouterr().err


def test_a_subject_comes_back_from_its_options(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(HELPERS)
    given = Subject(
        cmd="python3 gate_subjects.py {scene} {out}", out_as=OutFormat.npz, delta=1e-6, sandbox=True
    )
    options = given.options()
    assert options == {
        "cmd": f"python3 {Path('gate_subjects.py').absolute()} '{{scene}}' '{{out}}'",
        "out_as": "npz", "delta": 1e-6, "sandbox": True,
    }  # fmt: skip
    again = Subject.of(options)
    assert again.options() == options
    assert claim_of(again) == claim_of(given)
