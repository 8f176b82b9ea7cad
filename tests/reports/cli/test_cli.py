"""The command line: exit statuses, what goes to which stream, and errors of one sentence."""

from __future__ import annotations

import io
import json
import os
import pty
import re
import shlex
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

import minirt
from converters.frames.io import read_frame
from minirt.scene_file.atlas import atlas_names
from reference import registry
from reports import doctor as doctors
from reports.cli.main import app, run
from reports.results.record import results_json
from tests.helpers.fake_references import HOSTILE, Aborting, Faulty, Honest, Missing, small_scene
from tests.helpers.report_runs import good_run
from tests.helpers.tiers import tiered

COMMANDS = (
    "render",
    "explain",
    "verify",
    "gate",
    "fuzz",
    "export",
    "scenes",
    "rules",
    "mutants",
    "nightly",
    "exercises",
    "doctor",
)
#: Commands whose examples need files, tested in files of their own.
ELSEWHERE = ("exercises", "grade")
#: The command as a child process, where a stream of its own is what is tested.
MINIRT = (sys.executable, "-c", "from reports.cli.main import main; main()")
BALL = "atlas:ball-on-quad"


@dataclass(frozen=True)
class Done:
    """How a command ended."""

    status: int
    out: str
    err: str


Command = Callable[..., Done]


@pytest.fixture
def command(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> Command:
    """Run a command in this process, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MINIRT_REQUIRE", raising=False)

    def call(*arguments: str, stdin: str = "") -> Done:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(stdin.encode())))
        capsys.readouterr()
        status = run(arguments)
        return Done(status, *capsys.readouterr())

    return call


@pytest.fixture
def references(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """References that end in known ways, in the place of those that exist."""
    fakes = {fake.name: fake for fake in (Honest(), Faulty(), Missing(), Aborting())}
    monkeypatch.setattr(registry, "REFERENCES", fakes)
    monkeypatch.setattr(doctors, "REFERENCES", fakes)
    monkeypatch.setattr(registry, "USUAL", ("honest",))
    return fakes


@pytest.fixture
def ball(tmp_path: Path) -> str:
    """A scene file of 48 × 36 pixels."""
    path = tmp_path / "ball.json"
    path.write_text(small_scene().canonical_json, encoding="utf-8")
    return str(path)


def example(command: Command, name: str) -> list[str]:
    """The arguments of the example in a command's help."""
    text = command(name, "--help").out
    (found,) = re.findall(r"Example: minirt (.*)", text)
    return shlex.split(found)


def one_document(done: Done) -> dict[str, Any]:
    """What stands on standard output, which must be one JSON document and no more."""
    document = json.loads(done.out)
    assert isinstance(document, dict)
    return document


def test_every_command_is_tested() -> None:
    assert {entry.callback.__name__ for entry in app.registered_commands if entry.callback} == {
        *COMMANDS,
        *ELSEWHERE,
    }


#: Commands whose example takes seconds: in the fast tier they are asked for what is SHORT.
LONG = ("fuzz", "doctor", "verify", "mutants")
#: All but the one that has its own test.
TRIED = [name for name in COMMANDS if name != "nightly"]


@pytest.mark.parametrize("name", tiered(TRIED, lambda name: name not in LONG))
def test_the_example_in_the_help_runs(name: str, command: Command) -> None:
    done = command(*example(command, name))
    assert done.status == 0, done.err
    assert done.out + done.err


#: What is asked of a command whose example takes seconds: its document has the same form.
SHORT = {
    "verify": "verify atlas:one-sphere --reference embree --out report",
    "fuzz": "fuzz --seed 7 --scenes 2 --reference embree",
    "mutants": "mutants --only far-root --jobs 1",
}


@pytest.mark.parametrize("name", tiered(TRIED, lambda name: name != "doctor"))
def test_json_is_one_document_and_nothing_else(name: str, command: Command) -> None:
    words = SHORT[name].split() if name in SHORT else example(command, name)
    done = command(*words, "--json")
    assert done.status == 0, done.err
    assert one_document(done)
    assert "{" not in done.err


@pytest.mark.parametrize("arguments", [["--help"], ["--version"], ["verify", "--help"]])
def test_help_is_quick_since_nothing_heavy_is_imported(arguments: list[str]) -> None:
    code = (
        "import sys; from reports.cli.main import run; status = run(sys.argv[1:]); "
        "print(sorted({'numpy', 'rich', 'trimesh', 'OpenImageIO', 'mitsuba'} & set(sys.modules)));"
        "sys.exit(status)"
    )
    done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "[]"


def test_a_run_without_a_history_opens_no_database() -> None:
    code = "import sys, reports.run; print(sorted({'sqlalchemy', 'alembic'} & set(sys.modules)))"
    assert subprocess.check_output([sys.executable, "-c", code], text=True) == "[]\n"


def test_version(command: Command) -> None:
    assert command("--version") == Done(0, f"minirt {minirt.__version__}\n", "")


def test_without_a_command_the_help_is_shown_as_a_misuse(command: Command) -> None:
    done = command()
    assert (done.status, done.out) == (2, "")
    assert all(f"  {name} " in done.err for name in COMMANDS)


FAULTS: dict[str, tuple[list[str], str]] = {
    "no such option": (["render", "--foo"], "--foo"),
    "no such command": (["paint"], "paint"),
    "no scene": (["render", "-o", "a.exr"], "'scene'"),
    "not a number": (["explain", BALL, "--pixel", "one", "2"], "--pixel"),
    "no jobs": (["verify", BALL, "--jobs", "0"], "--jobs"),
    "unknown scene": (["render", "atlas:bal", "-o", "a.exr"], "atlas:bal: no such scene"),
    "unknown name": (["scenes", "bal"], "atlas:bal: no such scene"),
    "missing file": (["render", "nowhere.json", "-o", "a.exr"], "nowhere.json"),
    "not JSON": (["render", "-", "-o", "a.exr"], "standard input: not JSON"),
    "unknown quantity": (["render", BALL, "-o", "a.exr", "--quantities", "hut"], "'hut'"),
    "two quantities in a picture": (
        ["render", BALL, "-o", "a.png", "--quantities", "hit,color"],
        "a picture holds one quantity",
    ),
    "a picture that cannot be": (["render", BALL, "-o", "a.png", "--quantities", "t"], "PNG"),
    "unknown format": (
        ["render", BALL, "-o", "a.gif"],
        "a.gif: unknown format; got .gif; expected .exr, .npz or a folder for any quantities; "
        ".png, .pfm or .npy for one",
    ),
    "no such folder": (["render", BALL, "-o", "no/such/a.exr"], "no/such/a.exr"),
    "not a size": (["render", BALL, "-o", "a.exr", "--size", "640"], "--size: not a size"),
    "no pixels": (["render", BALL, "-o", "a.exr", "--size", "0x9"], "screen"),
    "too many pixels": (["render", BALL, "-o", "a.exr", "--size", "99999x99999"], "screen.nx"),
    "right of the image": (["explain", BALL, "--pixel", "256", "0"], "column"),
    "below the image": (["explain", BALL, "--pixel", "0", "192"], "row"),
    "unknown reference": (["verify", BALL, "--reference", "mitsubishi"], "mitsuba-llvm"),
    "unknown requirement": (["doctor", "--require", "mitsubishi"], "mitsuba-llvm"),
    "unknown language": (["export", BALL, "--to", "klingon", "-o", "a"], "klingon"),
    "a camera that cannot be": (
        ["export", "atlas:non-square-pixels", "--to", "mitsuba", "-o", "a"],
        "square pixels",
    ),
    "reports into a file": (["verify", BALL, "--out", "taken/report"], "taken/report"),
}


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("as_json", [False, True])
def test_bad_input_is_one_sentence_and_status_2(
    fault: str, as_json: bool, command: Command, tmp_path: Path
) -> None:
    arguments, hint = FAULTS[fault]
    (tmp_path / "taken").write_text("a file where a folder should be")
    done = command(*arguments, *(["--json"] if as_json else []), stdin="{")
    assert done.status == 2
    sentence, *how = done.err.splitlines()
    assert sentence.startswith("error: ")
    assert hint in sentence
    assert len(how) <= 1
    assert not any("Traceback" in line for line in how)
    if as_json:
        document = one_document(done)
        assert document["exit_status"] == 2
        assert document["error"]["what"] in sentence
    else:
        assert done.out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["taken"]


@pytest.mark.parametrize(
    ("arguments", "text", "path"),
    [
        (["explain", BALL, "--pixel", "1"], "requires 2 arguments", "minirt explain"),
        (["explain", BALL, "--pixel", "one", "2"], "--pixel", "minirt explain"),
        (["export", BALL, "--to", "pbrt", "-o", "a"], "'pbrt' is not one of", "minirt export"),
        (["paint"], "paint", "minirt"),
        (["--foo"], "--foo", "minirt"),
    ],
)
def test_a_misuse_names_the_commands_own_help(
    arguments: list[str], text: str, path: str, command: Command
) -> None:
    sentence, hint = command(*arguments).err.splitlines()
    assert text in sentence
    assert "Value error" not in sentence
    assert hint == f"'{path} --help' shows how"


def test_an_error_does_not_command_the_terminal(command: Command) -> None:
    scene = json.dumps({"minirt": 1, "name": "a", HOSTILE: 1})
    done = command("render", "-", "-o", "a.exr", stdin=scene)
    assert done.status == 2
    assert "unknown key" in done.err or "required key" in done.err
    assert not re.search(r"[\x00-\x09\x0b-\x1f\x7f-\x9f]", done.err)


def test_a_mistake_of_ours_is_called_one(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(*_: object) -> None:
        raise KeyError("spare")

    monkeypatch.setattr(minirt, "load_scene", fail)
    done = command("render", BALL, "-o", "a.exr")
    assert done.status == 3
    assert done.err.startswith("error: a mistake in minirt itself: KeyError: 'spare'\n")
    assert "Traceback" not in done.err
    monkeypatch.setenv("MINIRT_DEBUG", "1")
    assert "Traceback" in command("render", BALL, "-o", "a.exr").err


def test_an_interrupt_is_quiet(command: Command, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(minirt, "render", interrupt)
    assert command("render", BALL, "-o", "a.exr") == Done(130, "", "")


# render


@pytest.mark.parametrize("out", ["a.exr", "a.npz", "folder"])
def test_render_writes_every_quantity(out: str, command: Command, ball: str) -> None:
    done = command("render", ball, "-o", out)
    assert done.status == 0, done.err
    assert done.out == ""
    assert done.err.startswith(f"{out}: ball, 48 × 36, {len(minirt.QUANTITIES)} quantities; ")
    assert set(read_frame(out)) == set(minirt.QUANTITIES)


def test_render_gives_what_the_library_gives(command: Command) -> None:
    scene = small_scene()
    done = command("render", "-", "-o", "a.npz", stdin=scene.canonical_json)
    assert done.status == 0, done.err
    frame, expected = read_frame("a.npz"), minirt.render(scene)
    for name in minirt.QUANTITIES:
        assert np.array_equal(frame[name], expected[name], equal_nan=name not in ("hit",)), name
    assert frame.meta == expected.meta


def test_render_traces_only_what_was_asked_for(command: Command, ball: str) -> None:
    done = command("render", ball, "-o", "a.npz", "--quantities", "depth, hit", "--json")
    document = one_document(done)
    assert document["quantities"] == ["hit", "depth"]
    assert set(read_frame("a.npz")) == {"hit", "depth"}
    assert (document["nx"], document["ny"]) == (48, 36)
    assert document["megapixels_per_second"] == pytest.approx(48e-6 * 36 / document["seconds"])


@pytest.mark.parametrize(("out", "name"), [("a.png", "color"), ("b.png", "shadow"), ("c.npy", "t")])
def test_a_picture_holds_one_quantity(out: str, name: str, command: Command, ball: str) -> None:
    asked = [] if name == "color" else ["--quantities", name]
    done = command("render", ball, "-o", out, *asked, "--json")
    assert done.status == 0, done.err
    assert one_document(done)["quantities"] == [name]
    assert Path(out).stat().st_size > 48


def test_another_size_is_on_the_same_screen(command: Command) -> None:
    assert command("render", "atlas:closed-mesh", "-o", "a.npz", "--size", "24x9").status == 0
    frame = read_frame("a.npz")
    assert frame.size == (9, 24)
    corner = minirt.load_scene("atlas:closed-mesh").screen
    ray = frame["ray"][0, 0] @ np.array([corner.u, corner.v, corner.n]).T
    across, up = ray[:2] / ray[2] * corner.nu
    assert across == pytest.approx(corner.l + (corner.r - corner.l) / 24 / 2, rel=1e-12)
    assert up == pytest.approx(corner.t - (corner.t - corner.b) / 9 / 2, rel=1e-12)


# explain, scenes, export


def test_explain_prints_every_step_with_its_numbers(command: Command, ball: str) -> None:
    frame = minirt.render(minirt.load_scene(ball))
    done = command("explain", ball, "--pixel", "24", "18")
    assert done.status == 0, done.err
    rules = re.findall(r"^(S\d+) +\S", done.out, re.MULTILINE)
    assert {"S1", "S2", "S3", "S5", "S8", "S12", "S14", "S15", "S16", "S13", "S7"} <= set(rules)
    assert repr(float(frame["depth"][18, 24])) in done.out
    assert max(map(len, done.out.splitlines())) <= 100
    assert not [line for line in done.out.splitlines() if line != line.rstrip()]


def test_explain_as_json_has_every_bit(command: Command, ball: str) -> None:
    frame = minirt.render(minirt.load_scene(ball))
    document = one_document(command("explain", ball, "--pixel", "24", "18", "--json"))
    values = [step["values"] for step in document["steps"]]
    (depth,) = [v["depth"] for v in values if "depth" in v]
    (normal,) = [v["normal"] for v in values if "normal" in v]
    assert depth == frame["depth"][18, 24]
    assert normal == frame["normal"][18, 24].tolist()


def test_scenes_lists_the_atlas(command: Command) -> None:
    listed = [entry["name"] for entry in one_document(command("scenes", "--json"))["scenes"]]
    assert tuple(listed) == atlas_names()
    text = command("scenes").out
    assert [name for name in listed if f"{name}  S" not in text] == []


@pytest.mark.parametrize("name", ["telephoto", "atlas:telephoto"])
def test_scenes_shows_the_paragraphs_of_one(name: str, command: Command) -> None:
    scene = minirt.load_scene("atlas:telephoto")
    text = " ".join(command("scenes", name).out.split())
    assert " ".join(scene.proves.split()) in text
    assert " ".join(scene.failure_means.split()) in text
    document = one_document(command("scenes", name, "--json"))
    assert document["proves"] == scene.proves


def test_scenes_prints_the_schema(command: Command) -> None:
    schema = one_document(command("scenes", "--schema"))
    assert "screen" in schema["properties"]
    assert schema == one_document(command("scenes", "--schema", "--json"))


def test_export_prints_a_command_that_renders(command: Command, ball: str, tmp_path: Path) -> None:
    done = command("export", ball, "--to", "mitsuba", "-o", "there")
    assert done.status == 0, done.err
    place = Path(sys.executable).parent
    search = {**os.environ, "PATH": f"{place}{os.pathsep}{os.environ['PATH']}"}
    rendered = subprocess.run(
        shlex.split(done.out), cwd=tmp_path, env=search, capture_output=True, text=True
    )
    assert rendered.returncode == 0, rendered.stderr
    assert (tmp_path / "there" / "scene.exr").stat().st_size > 48 * 36
    assert sorted(path.name for path in tmp_path.iterdir()) == ["ball.json", "there"]
    again = command("export", ball, "--to", "mitsuba", "-o", "there")
    assert again.status == 0, again.err


@pytest.mark.parametrize(
    ("to", "out", "opened"), [("gltf", "ball.glb", "ball.glb"), ("obj", "there", "there/scene.obj")]
)
def test_export_prints_the_file_that_any_viewer_opens(
    command: Command, ball: str, to: str, out: str, opened: str, tmp_path: Path
) -> None:
    done = command("export", ball, "--to", to, "-o", out)
    assert done.status == 0, done.err
    assert done.out.strip() == opened
    assert trimesh.load_scene(tmp_path / opened).bounds is not None
    document = one_document(command("export", ball, "--to", to, "-o", out, "--json"))
    assert opened in document["files"]
    assert document["command"] is None


def test_export_does_not_replace_what_is_not_an_export(
    command: Command, ball: str, tmp_path: Path
) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("the only copy")
    done = command("export", ball, "--to", "mitsuba", "-o", "mine")
    assert done.status == 2
    assert "thesis.txt" in done.err
    assert (tmp_path / "mine" / "thesis.txt").read_text() == "the only copy"


# verify, doctor


@pytest.mark.usefixtures("references")
@pytest.mark.parametrize(
    ("arguments", "status"),
    [
        ([], 0),
        (["--reference", "honest"], 0),
        (["--reference", "faulty"], 1),
        (["--reference", "missing"], 3),
        (["--reference", "honest,missing"], 3),
        (["--require", "missing"], 3),
        (["--reference", "aborting"], 3),
        (["--reference", "faulty", "--require", "missing"], 1),
    ],
)
def test_verify_ends_with_the_verdict(
    arguments: list[str], status: int, command: Command, ball: str
) -> None:
    done = command("verify", ball, "--jobs", "1", *arguments, "--json")
    document = one_document(done)
    assert done.status == status
    assert document["verdict"]["exit_status"] == status
    assert document == json.loads(Path("report/results.json").read_text(encoding="utf-8"))
    assert document["verdict"]["sentence"] in done.err
    assert Path("report/report.html").is_file()


def test_what_is_required_comes_from_the_environment_too(
    references: dict[str, Any], command: Command, ball: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for beside_the_point in ("faulty", "aborting"):
        del references[beside_the_point]
    assert command("doctor").status == 0
    monkeypatch.setenv("MINIRT_REQUIRE", "missing")
    assert command("verify", ball).status == 3
    assert command("doctor").status == 3


def test_the_doctor_sees_what_is_missing_crashes_or_hangs(
    references: dict[str, Any], command: Command
) -> None:
    done = command("doctor", "--require", "aborting", "--json")
    assert done.status == 3
    document = one_document(done)
    states = {trial["reference"]: trial["state"] for trial in document["references"]}
    assert states == {
        "honest": "works", "faulty": "works", "missing": "missing", "aborting": "crashed",
    }  # fmt: skip
    (trial,) = [t for t in document["references"] if t["reference"] == "aborting"]
    assert "SIGABRT" in trial["reason"]
    assert "LLVM ERROR" in trial["output"]
    text = command("doctor", "--require", "aborting")
    assert "crashed: the process was ended by SIGABRT" in text.out
    assert "pip install <nothing>" in text.out


@pytest.mark.full
def test_the_doctor_names_the_command_that_brings_a_library(
    command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DRJIT_LIBLLVM_PATH", "nowhere.so")
    done = command("doctor", "--require", "mitsuba-llvm")
    assert done.status == 3
    assert re.search(r"✗ mitsuba-llvm +missing: .*pip install karellen-llvm-core", done.out)
    assert registry.choose_references(["mitsuba"])[0].name == "mitsuba-scalar"


def test_the_doctor_names_the_sandbox_or_the_command_that_brings_it(
    references: dict[str, Any], command: Command, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert list(references)
    assert one_document(command("doctor", "--json"))["machine"]["sandbox"].startswith("bubblewrap ")
    monkeypatch.setenv("PATH", "nowhere")
    said = one_document(command("doctor", "--json"))["machine"]["sandbox"]
    assert said == "bubblewrap is not installed: apt-get install bubblewrap"


def test_the_doctor_says_when_there_is_nothing_to_compare_with(
    references: dict[str, Any], command: Command
) -> None:
    for name in ("honest", "faulty", "aborting"):
        del references[name]
    done = command("doctor")
    assert done.status == 0
    assert done.out.endswith("verify has no reference to compare with.\n")


def test_a_package_that_is_missing_comes_with_its_command(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    wanted = ["numpy>=2.2", 'no-such-thing>=7,<8; extra == "mitsuba"', 'mypy; extra == "test"']
    monkeypatch.setattr(metadata, "requires", lambda _: wanted)
    numpy, absent = doctors._packages()
    assert (numpy.version, numpy.needed) == (np.__version__, True)
    assert (absent.version, absent.needed) == (None, False)
    assert absent.brings == f"{sys.executable} -m pip install 'no-such-thing>=7,<8'"


# streams


def on_a_terminal(*arguments: str, **environment: str) -> bytes:
    """What a command writes to a terminal."""
    ours, theirs = pty.openpty()
    plain = {k: v for k, v in os.environ.items() if k not in ("NO_COLOR", "FORCE_COLOR")}
    process = subprocess.Popen(
        [*MINIRT, *arguments], stdin=theirs, stdout=theirs, stderr=theirs,
        env={**plain, "TERM": "xterm-256color", **environment},
    )  # fmt: skip
    os.close(theirs)
    written = b""
    while True:
        try:
            part = os.read(ours, 65536)
        except OSError:  # Linux's word for the end
            break
        if not part:
            break
        written += part
    os.close(ours)
    assert process.wait() == 0
    return written


def test_colours_are_for_terminals_and_not_for_no_color() -> None:
    assert b"\x1b[" in on_a_terminal("scenes", "one-sphere")
    plain = on_a_terminal("scenes", "one-sphere", NO_COLOR="1")
    assert b"What it proves" in plain
    assert b"\x1b" not in plain


def test_a_pipe_gets_no_colours() -> None:
    done = subprocess.run(
        [*MINIRT, "scenes", "one-sphere"], capture_output=True, env={**os.environ, "TERM": "xterm"}
    )
    assert b"What it proves" in done.stdout
    assert b"\x1b" not in done.stdout + done.stderr


@pytest.mark.parametrize("arguments", [["scenes"], ["scenes", "--json"]])
def test_a_reader_that_has_gone_is_no_error(arguments: list[str]) -> None:
    reading, writing = os.pipe()
    os.close(reading)
    done = subprocess.run([*MINIRT, *arguments], stdout=writing, stderr=subprocess.PIPE)
    os.close(writing)
    assert (done.returncode, done.stderr) == (0, b"")


def test_rules_name_who_compared_them_only_where_a_run_is_given(
    command: Command, references: dict[str, Any], tmp_path: Path
) -> None:
    out = tmp_path / "report"
    assert (
        command("verify", "atlas:one-triangle", "--reference", "honest", "-o", str(out)).status == 0
    )
    plain = one_document(command("rules", "--json"))["rules"]
    run = one_document(command("rules", "--results", str(out / "results.json"), "--json"))["rules"]
    assert [row["rule"] for row in plain[:16]] == [f"S{k}" for k in range(1, 17)]
    assert all(row["functions"] and row["quantities"] and row["scenes"] for row in plain[:16])
    assert not any(row["compared"] for row in plain)
    by_rule = {row["rule"]: row["compared"] for row in run}
    assert by_rule["S9"] == {"honest": 1}
    assert by_rule["S8"] == {}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "not JSON"),
        ("[]", "not the results of a run"),
        ('{"scenes": [{}]}', "not the results of a run"),
    ],
)
def test_rules_refuse_what_is_no_run(
    text: str, said: str, command: Command, tmp_path: Path
) -> None:
    file = tmp_path / "results.json"
    file.write_text(text, encoding="utf-8")
    done = command("rules", "--results", str(file))
    assert done.status == 2
    assert said in done.err


def test_rules_refuse_a_run_that_contradicts_itself(command: Command, tmp_path: Path) -> None:
    file = tmp_path / "results.json"
    text = results_json(good_run()).replace('"wrong": 0', '"wrong": 7')
    file.write_text(text, encoding="utf-8")
    done = command("rules", "--results", str(file))
    assert done.status == 2
    assert "contradict themselves" in done.err
