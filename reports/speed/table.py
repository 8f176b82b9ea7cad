"""The measured speed as a table and as sentences: for the terminal, the README and the report."""

from __future__ import annotations

from collections.abc import Iterator

from reports.results.words import count
from reports.speed.results import Growth, Speed

#: What the growth of the time to build a tree is over.
TREE = "triangles, their tree built"
#: Peers whose rate is set beside minirt's as a ratio.
_RATIOS = ("plain loop", "raysect")


def heading(speed: Speed) -> list[str]:
    """The table's columns."""
    return ["thousand rays a second", *speed.tracers, *(f"× {name}" for name in _RATIOS)]


def rows(speed: Speed) -> list[list[str]]:
    """A row for each case; a dash where a tracer was not measured on it."""
    return [
        [
            case.name,
            *(_figure(case.rates[name] / 1e3) if name in case.rates else "–"
              for name in speed.tracers),
            *(_ratio(case.rates, name) for name in _RATIOS),
        ]
        for case in speed.cases
    ]  # fmt: skip


def sentences(speed: Speed) -> Iterator[str]:
    """What is not in the table: how minirt's time grows, trees, memory."""
    yield f"minirt's time grows as {'; '.join(map(_growth_in_words, speed.growth))}."
    for growth in speed.growth:
        if growth.over == TREE:
            each = 1e6 * growth.seconds[-1] / growth.sizes[-1]
            yield f"A tree takes {each:.1f} µs a triangle, of {growth.sizes[-1]:,} triangles."
    if speed.memory is not None:
        most = max(case.primitives for case in speed.cases)
        yield f"Rendering {most:,} triangles takes {speed.memory / 1e9:.2f} GB in all."


def origin(speed: Speed) -> str:
    """Where and when."""
    return f"{speed.cpu}, {count(speed.cores, 'core')}, {speed.started[:10]}"


def versions(speed: Speed) -> str:
    """Of everybody who was measured."""
    return ", ".join(f"{name} {version}" for name, version in speed.versions.items())


def markdown(speed: Speed) -> str:
    """Table and sentences as the README has them."""
    head = heading(speed)
    lines = [head, ["---", *["---:"] * (len(head) - 1)], *rows(speed)]
    table = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    return (
        f"{table}\n\n{' '.join(sentences(speed))} Measured on {origin(speed)}: {versions(speed)}.\n"
    )


def _growth_in_words(growth: Growth) -> str:
    return f"{growth.over}^{growth.exponent:.2f} ({growth.sizes[0]:,} to {growth.sizes[-1]:,})"


def _figure(value: float) -> str:
    """Three digits, no exponent.

    Examples
    --------
    >>> _figure(58321.4), _figure(12.345), _figure(0.00123)
    ('58,300', '12.3', '0.00123')
    """
    digits = float(f"{value:.3g}")
    return f"{digits:,.0f}" if digits >= 100 else f"{digits:.6f}".rstrip("0").rstrip(".")


def _ratio(rates: dict[str, float], peer: str) -> str:
    if "minirt" not in rates or peer not in rates:
        return "–"
    return _figure(rates["minirt"] / rates[peer])
