"""The landing page of all nightly runs, and the summary of one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from reports.history.difference import difference
from reports.history.entry import Entry
from reports.history.previous import Point
from reports.history.store import History
from reports.history.text import (
    SCENE_ICONS,
    cell_line,
    scenes_in_words,
    sentence_of,
    sign_of,
    verdict_of,
)
from reports.history.trends import Change, changes_of
from reports.nightly.nightly_run import NightlyRun, all_runs, unreadable_folders, write
from reports.nightly.sparkline import HEIGHT, WIDTH, sparkline
from reports.nightly.steps import previous_run
from reports.page.template import rendered
from reports.results.summary import escaped
from reports.results.words import count, times

#: Runs of each scene that the page draws, and changes that it lists.
MOST_RUNS, MOST_CHANGES = 60, 40
#: Changed cells that a summary lists.
MOST_CELLS = 30
_SIGNS = {0: "✓", 1: "✗", 2: "✗", 3: "!"}
#: Scenes that did not pass come first.
_ORDER = ("failed", "incomplete", "not compared", "passed")


def write_landing(out: Path, history: History) -> None:
    """Write `index.html` and `summary.md` of a folder of nightly runs."""
    all_nights = all_runs(out)
    finished = [night for night in all_nights if night.record.finished is not None]
    write(out / "index.html", landing_html(all_nights, history, unreadable_folders(out)))
    if finished:
        write(out / "summary.md", (finished[-1].folder / "night.md").read_text(encoding="utf-8"))


def landing_html(
    all_nights: Sequence[NightlyRun], history: History, unread: Sequence[str] = ()
) -> str:
    """The page: the last run, what changed and between which commits, the scenes, all runs.

    `unread` names the folders of runs that cannot be read.
    """
    finished = [night for night in all_nights if night.record.finished is not None]
    last = finished[-1] if finished else None
    entry = None if last is None or last.record.run is None else history.entry(last.record.run)
    trends = {} if entry is None else _trends(history, entry)
    changes = {name: changes_of(trend) for name, trend in trends.items()}
    return rendered(
        "nightly.html.j2",
        last=last,
        good=last is not None and last.record.exit_status == 0,
        sentence="no night is finished yet" if last is None else sentence(last),
        entry=entry,
        moved=_moved(history, entry),
        changes=_changes(changes),
        scenes=_scenes(entry, trends, changes),
        nights=[_night(night) for night in reversed(all_nights)],
        unread=unread,
        signs=_SIGNS,
        size=(WIDTH, HEIGHT),
    )


def sentence(night: NightlyRun) -> str:
    """The verdict on a nightly run."""
    steps = night.record.steps
    worst = [name for name, s in steps.items() if s.exit_status == night.record.exit_status]
    bad = list(dict.fromkeys([*worst, *(name for name, s in steps.items() if s.exit_status)]))
    if night.record.exit_status == 0:
        return "PASS: " + ", ".join(steps) + " all passed"
    if not bad:
        return "INCOMPLETE: no step is done"
    word = "FAIL" if night.record.exit_status == 1 else "INCOMPLETE"
    first = steps[bad[0]].sentence.removeprefix(f"{word}: ")
    also = f"; also {', '.join(bad[1:])}" if bad[1:] else ""
    return f"{word}: {bad[0]}: {first}{also}"


def night_markdown(night: NightlyRun, history: History) -> str:
    """The summary of a run: its steps, what changed since the run before, the one of verify."""
    record = night.record
    sign = "✅" if record.exit_status == 0 else "❌"
    lines = [f"# {sign} NightlyRun of {night.name}: {escaped(sentence(night))}", ""]
    lines += ["| step | | result | seconds |", "|---|---|---|---:|"]
    for name, step in record.steps.items():
        result = escaped(step.sentence)
        lines.append(f"| {name} | {_SIGNS[step.exit_status]} | {result} | {step.seconds:.0f} |")
    lines.append("")
    if record.run is not None:
        lines += _since(history, history.entry(record.run), record.run)
    summary = night.folder / "summary.md"
    if summary.exists():
        lines.append(summary.read_text(encoding="utf-8"))
    return "\n".join(lines)


def _since(history: History, entry: Entry, number: int) -> list[str]:
    before = previous_run(history, entry, number)
    if before is None:
        return ["The first run of its series: there is nothing to compare it with.", ""]
    found = difference(before, entry)
    commits = f"{(before.commit or 'none')[:10]} → {(entry.commit or 'none')[:10]}"
    lines = [f"## Since run {before.number} ({commits}): {escaped(verdict_of(found))}", ""]
    lines += [f"- {escaped(line)}" for line in (f"{sentence_of(found)}.", *scenes_in_words(found))]
    lines += [f"- {escaped(cell_line(cell))}" for cell in found.notable[:MOST_CELLS]]
    if len(found.notable) > MOST_CELLS:
        lines.append(f"- … and {len(found.notable) - MOST_CELLS} more in `compare.html`")
    return [*lines, ""]


def _trends(history: History, entry: Entry) -> dict[str, tuple[Point, ...]]:
    names = [scene.name for scene in entry.scenes]
    found = history.trends(names, entry.series, MOST_RUNS)
    return {name: by_series[entry.series] for name, by_series in found.items()}


def _moved(history: History, entry: Entry | None) -> list[str]:
    """Scenes that came, went or changed their name with the last night's run, in sentences."""
    before = (
        None if entry is None or not entry.number else previous_run(history, entry, entry.number)
    )
    if before is None or entry is None:
        return []
    found = scenes_in_words(difference(before, entry))
    return [f"From run {before.number} to run {entry.number}: {line}" for line in found]


def _changes(changes: dict[str, list[Change]]) -> list[dict[str, Any]]:
    """Every change, the newest first; scenes that changed alike between the same runs together."""
    found: dict[tuple[int, int, str], list[tuple[str, Change]]] = {}
    for name, each in changes.items():
        for change in each:
            key = (change.after.run, change.before.run, change.what)
            found.setdefault(key, []).append((name, change))
    newest = sorted(found.items(), key=lambda item: item[0], reverse=True)
    return [
        {
            "scenes": [name for name, _ in alike],
            "what": what,
            "sign": sign_of(alike[0][1]),
            "kind": {True: "better", False: "worse", None: "other"}[alike[0][1].better],
            "before": alike[0][1].before,
            "after": alike[0][1].after,
        }
        for (_, _, what), alike in newest[:MOST_CHANGES]
    ]


def _scenes(
    entry: Entry | None,
    trends: dict[str, tuple[Point, ...]],
    changes: dict[str, list[Change]],
) -> list[dict[str, Any]]:
    rows = []
    for scene in entry.scenes if entry is not None else ():
        trend, found = trends[scene.name], changes[scene.name]
        rows.append(
            {
                "name": scene.name,
                "state": scene.state,
                "icon": SCENE_ICONS.get(scene.state, "–"),
                "ratio": "none" if scene.ratio is None else times(scene.ratio),
                "stage": scene.first_wrong_stage,
                "runs": count(len(trend), "run"),
                "spark": sparkline(trend, found),
                "last": found[-1] if found else None,
                "seconds": f"{scene.seconds:.1f} s",
                "memory": f"{scene.peak_memory / 2**20:.0f} MB",
            }
        )
    return sorted(rows, key=lambda row: _ORDER.index(str(row["state"])))


def _night(night: NightlyRun) -> dict[str, Any]:
    record = night.record
    links = [
        (name, text)
        for name, text in (
            ("report.html", "report"), ("compare.html", "what changed"), ("night.md", "summary"),
            ("mutants.json", "mutants"), ("fuzz/fuzz.json", "fuzz"),
        )
        if (night.folder / name).exists()
    ]  # fmt: skip
    return {
        "name": night.name,
        "started": record.started,
        "commit": record.settings.commit,
        "finished": record.finished is not None,
        "status": record.exit_status,
        "sentence": sentence(night) if record.finished else "not finished",
        "steps": record.steps,
        "run": record.run,
        "links": [(f"{night.name}/{name}", text) for name, text in links],
        "minutes": f"{sum(step.seconds for step in record.steps.values()) / 60:.1f} min",
    }
