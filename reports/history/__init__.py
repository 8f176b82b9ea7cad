"""The history of runs: a database to which every `verify` and `gate` run is appended."""

#: The name of the history in the folder of the reports.
HISTORY_FILE = "history.sqlite"
