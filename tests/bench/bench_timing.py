"""How often a call is timed."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

#: Seconds that short calls are timed for, and how often at most.
_SECONDS, _MOST = 0.5, 50
#: Times that a call is timed with a mechanism and without it, in turns.
_TURNS = 5


def timed(benchmark: Any, call: Callable[..., Any], *arguments: Any) -> Any:
    """Time a call once it is warm, three times or, where it is short, for a while; its answer."""
    start = time.perf_counter()
    call(*arguments)
    rounds = int(_SECONDS / (time.perf_counter() - start))
    rounds = max(3, min(_MOST, rounds))
    return benchmark.pedantic(call, arguments, rounds=rounds, warmup_rounds=rounds // 5)


def times_without(
    call: Callable[[], object], switch_off: Callable[[], None], switch_on: Callable[[], None]
) -> float:
    """The processor's time of a call without a mechanism over that with it: the least of each."""
    call()
    seconds: tuple[list[float], list[float]] = ([], [])
    for _ in range(_TURNS):
        seconds[0].append(_processor_seconds(call))
        switch_off()
        seconds[1].append(_processor_seconds(call))
        switch_on()
    return min(seconds[1]) / min(seconds[0])


def _processor_seconds(call: Callable[[], object]) -> float:
    start = time.process_time()
    call()
    return time.process_time() - start
