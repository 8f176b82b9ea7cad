"""Imported by the process that jobs are forked from, and by no other: it ends with its starter.

Forks of it hold the pipe by which it would notice, so it would live as long as a job that hangs.
"""

from __future__ import annotations

import signal

from reference.jobs.processes import SET_PDEATHSIG, prctl

prctl(SET_PDEATHSIG, signal.SIGKILL)
