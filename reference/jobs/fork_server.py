"""Set up the process that jobs are forked from: it alone imports this module.

It ends with the process that started it. It would notice the end of that one by a pipe, but its
forks hold the pipe too, so that it would live as long as a job that hangs.
"""

from __future__ import annotations

import signal

from reference.jobs.processes import SET_PDEATHSIG, prctl

prctl(SET_PDEATHSIG, signal.SIGKILL)
