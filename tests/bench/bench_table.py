"""`python bench_table.py FILE`: what pytest-benchmark measured, as a table and as exponents."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from rich.console import Console
from rich.table import Table

#: Cases over whose sizes the cost of minirt is fitted, by kind.
_FITTED = {
    "spheres, 100 to 10k": ("100 spheres", "1k spheres", "10k spheres"),
    "triangles, 5k to 1.3M": ("mesh, 5k", "mesh, 82k", "mesh, 328k", "mesh, 1.3M"),
}

#: Millions of rays a second by case and tracer.
Rates = dict[str, dict[str, float]]


def rates_of(measured: Iterable[dict[str, Any]]) -> tuple[Rates, dict[str, int]]:
    """The rates by the median time, and how many primitives each case has."""
    rates: Rates = {}
    sizes: dict[str, int] = {}
    for each in measured:
        info = each["extra_info"]
        rate = info["rays"] / each["stats"]["median"] / 1e6
        rates.setdefault(info["case"], {})[info["tracer"]] = rate
        sizes[info["case"]] = info["primitives"]
    return rates, sizes


def exponent(rates: Rates, sizes: dict[str, int], cases: Iterable[str]) -> float | None:
    """k of time ∝ Nᵏ for minirt; None where fewer than two of the cases were measured."""
    known = [case for case in cases if "minirt" in rates.get(case, {})]
    if len(known) < 2:
        return None
    n = np.log([sizes[case] for case in known])
    seconds = -np.log([rates[case]["minirt"] for case in known])
    return float(np.polyfit(n, seconds, 1)[0])


def main(path: Path) -> None:
    """Print both."""
    rates, sizes = rates_of(json.loads(path.read_bytes())["benchmarks"])
    tracers = list(dict.fromkeys(name for row in rates.values() for name in row))
    table = Table(title="millions of rays a second")
    table.add_column("case")
    for name in (*tracers, "× plain loop"):
        table.add_column(name, justify="right")
    for case, row in rates.items():
        cells = [f"{row[name]:.3g}" if name in row else "–" for name in tracers]
        loop = row.get("plain loop")
        table.add_row(case, *cells, f"{row['minirt'] / loop:.3g}" if loop else "–")
    console = Console(width=None if sys.stdout.isatty() else 140)
    console.print(table)
    for kind, cases in _FITTED.items():
        k = exponent(rates, sizes, cases)
        if k is not None:
            console.print(f"minirt: time ∝ N^{k:.2f} for {kind}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
