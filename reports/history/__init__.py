"""The history of runs: a database to which every `verify` and `gate` run is appended."""
