"""`python bench_table.py FILE`: what pytest-benchmark measured goes into print, package and README.

The package's part is `reports/speed/speed.json`, whose form `reports.speed.results` documents, and
`speed.svg`, drawn from it.
"""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterable
from importlib import metadata
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from reference.renderers.povray.run import find_povray, povray_version
from reports.results.provenance import provenance
from reports.speed import table
from reports.speed.plot import plot_svg
from reports.speed.results import Case, Growth, Kind, Speed, fitted, speed_json
from tests.bench.bench_tracers import TRACERS

ROOT = Path(__file__).parents[2]
#: Between these lines the README has what was measured.
README = re.compile(r"(<!-- speed -->\n).*?(<!-- /speed -->\n)", re.DOTALL)
#: Over whose primitives the cost of minirt is fitted, from so many on.
_FITTED: dict[Kind, int] = {"spheres": 100, "triangles": 1}
_PACKAGES = ("raysect", "trimesh", "embreex", "rtree", "mitsuba")

Benchmarks = list[dict[str, Any]]


def speed_of(measured: Benchmarks) -> Speed:
    """What was measured, as the document has it; seconds are medians."""
    stamp = provenance()
    cases = cases_of(measured)
    return Speed(
        minirtSpeed=1,
        started=stamp.started,
        commit=stamp.commit,
        cpu=stamp.cpu,
        cores=stamp.cores,
        system=stamp.system,
        versions={**stamp.versions, **dict(_peers())},
        tracers=[name for name in TRACERS if any(name in case.rates for case in cases)],
        cases=cases,
        growth=[*_over_primitives(cases), *_over_others(measured)],
        memory=next(
            (m["extra_info"]["memory"] for m in measured if "memory" in m["extra_info"]), None
        ),
    )


def cases_of(measured: Benchmarks) -> list[Case]:
    """Every case with the rates of all who were measured on it."""
    found: dict[str, dict[str, Any]] = {}
    for each in measured:
        info = each["extra_info"]
        if "case" in info:
            case = found.setdefault(info["case"], {**info, "rates": {}})
            case["rates"][info["tracer"]] = float(f"{info['rays'] / _median(each):.4g}")
    return [
        Case(name=name, kind=case["kind"], primitives=case["primitives"], rates=case["rates"])
        for name, case in found.items()
    ]


def _over_primitives(cases: Iterable[Case]) -> Iterable[Growth]:
    """For as many rays among ever more primitives: seconds a million rays."""
    for kind, least in _FITTED.items():
        known = [
            (case.primitives, float(f"{1e6 / case.rates['minirt']:.4g}"))
            for case in cases
            if case.kind == kind and case.primitives >= least and "minirt" in case.rates
        ]  # fmt: skip
        if len(known) > 1:
            yield fitted(kind, *zip(*known, strict=True))


def _over_others(measured: Benchmarks) -> Iterable[Growth]:
    found: dict[str, list[tuple[int, float]]] = {}
    for each in measured:
        info = each["extra_info"]
        if "over" in info:
            found.setdefault(info["over"], []).append((info["size"], _median(each)))
    return [fitted(over, *zip(*known, strict=True)) for over, known in found.items()]


def _median(each: dict[str, Any]) -> float:
    return float(f"{each['stats']['median']:.4g}")


def _peers() -> Iterable[tuple[str, str]]:
    for name in _PACKAGES:
        if find_spec(name):
            yield name, metadata.version(name)
    if find_povray():
        yield "POV-Ray", povray_version().removeprefix("POV-Ray ")


def _print(speed: Speed) -> None:
    shown = Table(*table.heading(speed), title=table.origin(speed))
    for column in shown.columns[1:]:
        column.justify = "right"
    for row in table.rows(speed):
        shown.add_row(*row)
    console = Console(width=None if sys.stdout.isatty() else 180)
    console.print(shown)
    for sentence in table.sentences(speed):
        console.print(sentence, highlight=False)


def _print_without(measured: Benchmarks) -> None:
    """Print how many times as long each row takes without a mechanism of the culling."""
    ratios = {
        (info["row"], info["without"]): f"{info['ratio']:.2f} ×"
        for info in (each["extra_info"] for each in measured)
        if "without" in info
    }
    rows, mechanisms = (list(dict.fromkeys(names)) for names in zip(*ratios, strict=True))
    shown = Table("", *(f"without {name}" for name in mechanisms), title="What culling is worth")
    for row in rows:
        shown.add_row(row, *(ratios.get((row, name), "") for name in mechanisms))
    Console(width=None if sys.stdout.isatty() else 180).print(shown)


def main(path: Path) -> None:
    """Print it all, and put it where it is shown from."""
    measured = json.loads(path.read_bytes())["benchmarks"]
    speed = speed_of(measured)
    _print(speed)
    _print_without(measured)
    folder, readme = ROOT / "reports" / "speed", ROOT / "README.md"
    (folder / "speed.json").write_text(speed_json(speed), encoding="utf-8")
    (folder / "speed.svg").write_text(plot_svg(speed), encoding="utf-8")
    text = README.sub(
        lambda found: found[1] + table.markdown(speed) + found[2],
        readme.read_text(encoding="utf-8"),
    )
    readme.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
