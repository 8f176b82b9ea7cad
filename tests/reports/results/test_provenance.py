from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from reports.results.provenance import provenance


def git(folder: Path, *arguments: str) -> str:
    identity = ["-c", "user.name=t", "-c", "user.email=t@example.org"]
    done = subprocess.run(
        [shutil.which("git") or "git", *identity, *arguments],
        cwd=folder, check=True, capture_output=True, text=True,
    )  # fmt: skip
    return done.stdout.strip()


def test_commit_and_changes_of_the_working_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    git(tmp_path, "init")
    (tmp_path / "a").write_text("1", encoding="utf-8")
    git(tmp_path, "add", "a")
    git(tmp_path, "commit", "-m", "first")
    monkeypatch.chdir(tmp_path)
    clean = provenance()
    assert clean.commit == git(tmp_path, "rev-parse", "HEAD")
    assert clean.dirty is False
    (tmp_path / "a").write_text("2", encoding="utf-8")
    assert provenance().dirty is True


def test_outside_a_checkout_or_without_git_there_is_no_commit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    outside = provenance()
    assert (outside.commit, outside.dirty) == (None, None)
    monkeypatch.setenv("PATH", str(tmp_path))
    assert provenance().commit is None


def test_command_line_is_one_that_a_shell_takes(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "argv", ["/bin/minirt", "verify", "a b", "--json"])
    assert provenance().command == "minirt verify 'a b' --json"
