"""Jobs on a real Dask scheduler's workers: the same answers, whoever dies on the way."""

from __future__ import annotations

import json
import os
import pickle
import shutil
import socket
import sys
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from contextlib import closing
from pathlib import Path
from typing import Any

import pytest
from distributed import Client

import minirt
from converters.frames.io import write_frame
from minirt.errors import InputError, ReferenceError
from minirt.scene import Scene
from reference import registry
from reference.jobs import cluster as cluster_module
from reference.jobs import dask_cluster
from reference.jobs.cluster import Cluster, in_order
from reference.jobs.dask_cluster import DaskCluster
from reference.jobs.isolate import Outcome
from reference.jobs.payload import from_payload, to_payload
from reference.jobs.remote_worker import IncompatibleWorker
from reports.cli.main import run
from reports.run import run_verify
from tests.helpers.cluster_jobs import (
    Marking,
    Raising,
    fail,
    kill_itself,
    kill_worker,
    mark_and_wait,
    square,
)
from tests.helpers.dask_processes import Dask, running
from tests.helpers.fake_references import Honest, Missing, small_scene
from tests.helpers.grade_class import honest, mutant, small
from tests.reports.grade.test_cli import RUBRIC

#: What is measured in a run, and not found out by it.
MEASURED = {"seconds", "peak_memory", "kept", "provenance"}
WORKERS = ("ann", "bob", "cec")


def scene_with_mesh(folder: Path) -> Scene:
    corners = ("0 0.2 0.5", "1.5 0.2 0.5", "0 1.5 0.5", "0.4 0.6 1.5")
    faces = ("1 3 2", "1 2 4", "2 3 4", "3 1 4")
    lines = [*(f"v {corner}" for corner in corners), *(f"f {face}" for face in faces)]
    (folder / "parts").mkdir()
    (folder / "parts" / "solid.obj").write_text("\n".join(lines) + "\n", encoding="utf-8")
    document = small_scene("solid").to_dict()
    document["objects"].append(
        {"type": "mesh", "name": "solid", "material": "gray", "file": "parts/solid.obj"}
    )
    return minirt.load_scene(document, folder)


@pytest.fixture(scope="module")
def dask(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Dask]:
    """Three workers of a thread each: two as a user starts them, one without a nanny."""
    with running(tmp_path_factory.mktemp("dask")) as found:
        for name in WORKERS[:2]:
            found.worker(name)
        found.worker(WORKERS[2], "--no-nanny")
        yield found


def until(true: Any, seconds: float = 60.0) -> None:
    deadline = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < deadline
        time.sleep(0.02)


def found_out(document: Any) -> Any:
    """A document without what was measured."""
    if isinstance(document, dict):
        return {k: found_out(v) for k, v in document.items() if k not in MEASURED}
    return [found_out(each) for each in document] if isinstance(document, list) else document


def same_bits(thing: object) -> bytes:
    """A thing's bytes, whatever it shared with others before."""
    return pickle.dumps(pickle.loads(pickle.dumps(thing)))  # noqa: S301


def parent_of(pid: int) -> int:
    text = Path(f"/proc/{pid}/stat").read_text(encoding="ascii")
    return int(text.rpartition(")")[2].split()[1])


@pytest.mark.full
def test_the_same_bits_though_a_worker_is_killed_midway(dask: Dask, tmp_path: Path) -> None:
    meshes, marks = tmp_path / "meshes", tmp_path / "marks"
    meshes.mkdir()
    marks.mkdir()
    scenes = [*(small_scene(f"ball-{k}") for k in range(2)), scene_with_mesh(meshes)]
    victim = dask.processes[-1]

    def kill() -> None:
        """Once the victim renders."""

        def at_work() -> bool:
            sessions = {int(path.name.split()[1]) for path in marks.iterdir()}
            return any(parent_of(session) == victim.pid for session in sessions)

        until(at_work)
        victim.kill()

    def compared(folder: str, cluster: Cluster | None, seconds: float) -> tuple[Any, Any]:
        shared = meshes if cluster else tmp_path
        references = [Missing(), Marking("marking", marks, shared, seconds)]
        run = run_verify(scenes, references, tmp_path / folder, cluster=cluster)
        text = (tmp_path / folder / "results.json").read_text(encoding="utf-8")
        shown = [
            (result.thumbnail, result.quorum, [answer.details for answer in result.references])
            for result in run.results
        ]
        return found_out(json.loads(text)), shown

    with DaskCluster(dask.address) as cluster:
        until(lambda: cluster._capacity() == 3)
        killing = threading.Thread(target=kill)
        killing.start()
        there, seen_there = compared("there", cluster, 0.5)
        killing.join()
        assert len(list(marks.iterdir())) > len(scenes)  # one was begun again
        assert cluster._capacity() == 2
    here, seen_here = compared("here", None, 0.0)
    assert there == here
    assert len(seen_there) == len(scenes)
    assert [same_bits(each) for each in seen_there] == [same_bits(each) for each in seen_here]


@pytest.mark.full
def test_what_kills_three_workers_has_crashed_and_the_rest_goes_on(
    dask: Dask, tmp_path: Path
) -> None:
    jobs: list[Any] = [(square, (k,)) for k in range(12)]
    jobs[3] = kill_worker, (tmp_path,)
    with DaskCluster(dask.address) as cluster:
        ended = dict(cluster.outcomes(jobs))
    crashed = ended.pop(3)
    assert {k: outcome.value for k, outcome in ended.items()} == {
        k: k**2 for k in range(12) if k != 3
    }
    assert (crashed.state, crashed.value) == ("crashed", None)
    assert crashed.reason.startswith("3 workers died of it: tcp://127.0.0.1:")
    assert len(list(tmp_path.iterdir())) == 3


@pytest.mark.full
def test_jobs_that_wait_are_cancelled(dask: Dask, tmp_path: Path) -> None:
    with DaskCluster(dask.address) as cluster:
        until(lambda: cluster._capacity() >= 1)
        jobs = [(mark_and_wait, (tmp_path, k)) for k in range(40)]
        with closing(cluster.outcomes(jobs)) as ended:
            next(ended)
        begun = len(list(tmp_path.iterdir()))
    time.sleep(1.5)
    assert len(list(tmp_path.iterdir())) <= begun + len(WORKERS)


def test_a_worker_with_another_minirt_is_refused(
    dask: Dask, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster_module, "identity", lambda: "minirt 0.0.1")
    with (
        DaskCluster(dask.address) as cluster,
        pytest.raises(IncompatibleWorker, match="another minirt") as raised,
    ):
        list(cluster.outcomes([(square, (1,))]))
    error = raised.value
    assert error.where.startswith("worker tcp://127.0.0.1:")
    assert error.got.startswith(f"minirt {minirt.__version__} with the sources ")
    assert error.expected.startswith("minirt 0.0.1")
    assert error.exit_status == 2


def test_a_worker_that_cannot_take_jobs_is_said(
    dask: Dask, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(cluster_module, "perform", len)  # takes one argument
    with (
        DaskCluster(dask.address) as cluster,
        pytest.raises(IncompatibleWorker, match="cannot take jobs"),
    ):
        list(cluster.outcomes([(square, (1,))]))


@pytest.mark.full
def test_no_worker_and_no_scheduler_end_a_run_in_words(tmp_path: Path) -> None:
    with running(tmp_path) as alone, DaskCluster(alone.address, patience=0.5) as cluster:
        with pytest.raises(ReferenceError, match=r"no worker is there .* within 0\.5 s"):
            list(cluster.outcomes([(square, (1,))]))
        threading.Timer(1.5, alone.processes[0].kill).start()
        cluster._patience = 60
        with pytest.raises(ReferenceError, match=r"is lost|is gone"):
            list(cluster.outcomes([(square, (1,))]))


@pytest.mark.parametrize(
    "address", ["", "127.0.0.1", "tcp://here", "http://127.0.0.1:8786", "tcp://:1"]
)
def test_no_address_is_said(address: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(["mutants", "--cluster", address]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert f"--cluster: not the address of a scheduler; got '{address}'" in told


def test_nobody_who_answers_is_said(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(dask_cluster, "_CONNECTING", 0.5)
    with socket.create_server(("127.0.0.1", 0)) as mute:
        place = f"tcp://127.0.0.1:{mute.getsockname()[1]}"
        assert run(["mutants", "--cluster", place]) == 2
        assert f"error: {place}: no scheduler answers" in capsys.readouterr().err
    assert run(["mutants", "--cluster", place]) == 2
    assert f"error: {place}: no scheduler answers" in capsys.readouterr().err


def test_without_dask_the_extra_is_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delitem(sys.modules, "reference.jobs.dask_cluster")
    monkeypatch.setitem(sys.modules, "distributed", None)
    assert run(["mutants", "--cluster", "tcp://127.0.0.1:8786"]) == 2
    told = capsys.readouterr().err
    assert "--cluster: Dask is not installed" in told
    assert "pip install 'minirt[cluster]'" in told


def test_any_executor_does(tmp_path: Path) -> None:
    jobs: list[Any] = [(square, (3,)), (fail, (4,)), (kill_itself, ()), (square, (5,))]
    for make in (ThreadPoolExecutor, ProcessPoolExecutor):
        with make(1) as executor, Cluster(executor) as cluster:
            nine, failed, killed, last = in_order(cluster.outcomes(jobs))
        assert (nine.value, last.value) == (9, 25)
        assert (failed.state, str(failed.value)) == ("raised", "no such number; got 4")
        assert killed == Outcome("crashed", None, "the process was ended by SIGKILL")


def test_a_payload_takes_the_meshes_along(tmp_path: Path) -> None:
    home, room = tmp_path / "home", tmp_path / "room"
    home.mkdir()
    scene = scene_with_mesh(home)
    payload = to_payload({"scenes": [scene, small_scene()]})
    shutil.rmtree(home)
    with pytest.raises(InputError, match="a mesh file cannot be read"):
        to_payload(scene)
    there, plain = from_payload(payload, room)["scenes"]
    assert there.folder.is_relative_to(room)
    assert minirt.load_scene(there.to_dict(), there.folder).sha256 == scene.sha256
    assert plain.sha256 == small_scene().sha256


def test_workers_keep_freed_memory_at_hand(dask: Dask) -> None:
    name = "MALLOC_TRIM_THRESHOLD_"  # set by Dask's nannies, and a drag on all that renders
    with Client(dask.address, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=60)
        assert "65536" in client.run(os.getenv, name).values()
    with DaskCluster(dask.address) as workers:
        ended = list(workers.outcomes([(os.getenv, (name,))] * 6))
    assert [outcome for _, outcome in ended] == [Outcome("done", None)] * 6


@pytest.fixture
def place(dask: Dask, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """A working folder with a scene and a rubric; the option that names the cluster."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("MINIRT_REQUIRE", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    fakes = {"honest": Honest(), "raising": Raising()}
    monkeypatch.setattr(registry, "REFERENCES", fakes)
    (tmp_path / "ball.json").write_text(small_scene().canonical_json, encoding="utf-8")
    return ["--cluster", dask.address]


def printed(capsys: pytest.CaptureFixture[str]) -> Any:
    return found_out(json.loads(capsys.readouterr().out))


def test_verify_takes_a_cluster(place: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    words = ["verify", "ball.json", "--reference", "honest", "--no-history", "--json"]
    assert run([*words, *place]) == 0
    (scene,) = printed(capsys)["scenes"]
    assert (scene["name"], scene["state"]) == ("ball", "passed")


@pytest.mark.full
def test_fuzz_takes_a_cluster(
    place: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:  # fmt: skip
    monkeypatch.setattr("reference.fuzz.campaign.MOST_FAILURES", 1)
    words = ["fuzz", "--seed", "3", "--scenes", "9", "--reference", "honest,raising", "--json"]
    assert run([*words, *place, "--out", "cases"]) == 1
    there = printed(capsys)
    files = {path.name: path.read_bytes() for path in sorted((tmp_path / "cases").rglob("*.*"))}
    shutil.move("cases", "elsewhere")
    assert run([*words, "--out", "cases"]) == 1
    assert there == printed(capsys)
    assert len(there["failures"]) == 1
    here = sorted((tmp_path / "cases").rglob("*.*"))
    assert files == {path.name: path.read_bytes() for path in here}


@pytest.mark.full
def test_mutants_take_a_cluster(place: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    words = ["mutants", "--only", "far-root", "--json"]
    assert run([*words, *place]) == 0
    there = printed(capsys)
    assert run(words) == 0
    assert there == printed(capsys)
    assert there["killed"] == 1


@pytest.mark.full
def test_grade_takes_a_cluster(
    place: list[str], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    scene, handed = "ball-on-quad", tmp_path / "in"
    (tmp_path / "rubric.toml").write_text(RUBRIC, encoding="utf-8")
    (tmp_path / f"{scene}.json").write_text(json.dumps(small(scene).to_dict()), encoding="utf-8")
    for name, frame in (("ana", honest(scene)), ("ben", mutant("light-not-negated", scene))):
        (handed / name).mkdir(parents=True)
        write_frame(frame, handed / name / f"{scene}.npz")
    shutil.make_archive(str(handed / "cy"), "zip", handed / "ben")
    (handed / "dan").symlink_to(handed / "ana")
    (handed / "eve.zip").write_bytes(b"no archive")
    words = ["grade", "in", "--rubric", "rubric.toml", "--json", "-o"]
    assert run([*words, "there", *place]) == 0
    there = printed(capsys)
    assert run([*words, "here"]) == 0
    assert there == printed(capsys)
    assert [each["kind"] for each in there["students"]] == ["frames"] * 3 + ["nothing"] * 2
    files = [
        {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*.*")}
        for folder in (tmp_path / "there" / "students", tmp_path / "here" / "students")
    ]
    assert files[0] == files[1]
    assert len(files[0]) == 3 * 5
    assert run([*words, "there", *place]) == 0  # nothing is left to do
    assert there == printed(capsys)


@pytest.mark.full
def test_nightly_takes_a_cluster(place: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    words = ["nightly", "ball.json", "--reference", "honest", "--mutants", "far-root", "--json"]
    assert run([*words, "--budget", "1s", *place]) == 0
    steps = json.loads(capsys.readouterr().out)["steps"]
    assert [(name, step["exit_status"]) for name, step in steps.items()] == [
        ("mutants", 0), ("verify", 0), ("history", 0), ("fuzz", 0),
    ]  # fmt: skip
    assert "1 of 1 mutants killed" in steps["mutants"]["sentence"]
