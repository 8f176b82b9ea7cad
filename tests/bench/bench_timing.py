"""How often a call is timed."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any

#: Seconds that short calls are timed for, and how often at most.
_SECONDS, _MOST = 0.5, 50


def timed(benchmark: Any, call: Callable[..., Any], *arguments: Any) -> Any:
    """Time a call once it is warm, three times or, where it is short, for a while; its answer."""
    start = time.perf_counter()
    call(*arguments)
    rounds = int(_SECONDS / (time.perf_counter() - start))
    rounds = max(3, min(_MOST, rounds))
    return benchmark.pedantic(call, arguments, rounds=rounds, warmup_rounds=rounds // 5)
