"""What would not fit is refused before it is begun."""

from __future__ import annotations

import subprocess
import sys

import pytest

import minirt
from minirt import memory
from minirt.errors import InputError
from minirt.memory import available, require_memory
from tests.helpers.fake_references import small_scene


def test_more_than_is_free_is_refused_in_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "available", lambda: 3_000_000_000)
    require_memory(3_000_000_000, "as much")
    with pytest.raises(InputError) as caught:
        require_memory(4_120_000_000, "ball: 9 triangles")
    assert str(caught.value) == (
        "ball: 9 triangles: not enough memory; got 3.00 GB free; expected 4.12 GB"
    )


def test_where_nothing_is_told_everything_is_let_through(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "available", lambda: None)
    require_memory(10**18, "anything")


def test_a_mesh_and_an_image_are_asked_about(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "available", lambda: 1000)
    with pytest.raises(InputError, match=r"pixels of hit, depth: not enough memory"):
        minirt.render(small_scene(), quantities="hit,depth")
    with pytest.raises(InputError, match=r"closed-mesh: [0-9,]+ triangles: not enough memory"):
        minirt.render(minirt.load_scene("atlas:closed-mesh"))


def test_this_machine_tells_and_a_limit_of_the_process_counts() -> None:
    free = available()
    assert free is not None
    assert 10**7 < free < 10**14
    code = (
        "import resource; from minirt.memory import available\n"
        "used = int(open('/proc/self/statm').read().split()[0]) * resource.getpagesize()\n"
        "resource.setrlimit(resource.RLIMIT_AS, (used + 10**8, -1)); print(available())"
    )
    told = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True)
    assert 0.8e8 < int(told.stdout) <= 1.01e8
