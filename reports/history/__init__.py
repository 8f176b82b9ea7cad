"""The history of runs: a database to which every `verify` and `gate` run is appended."""

from reports.history.entry import CellEntry, Entry, SceneEntry, entry_of, read_entry
from reports.history.store import History

__all__ = ["CellEntry", "Entry", "History", "SceneEntry", "entry_of", "read_entry"]
