#!/usr/bin/env bash
# Gradescope: what the autograder's image needs. Beside this file lie run_autograder, rubric.toml,
# the scenes that it names, and minirt's wheel (python -m build --wheel makes it in dist/).
set -eu
apt-get update
apt-get install -y --no-install-recommends python3 python3-venv bubblewrap util-linux build-essential
python3 -m venv /autograder/venv
/autograder/venv/bin/pip install --no-cache-dir /autograder/source/minirt-*.whl
# minirt's own answers to the scenes, once for all submissions: an empty one is graded.
mkdir -p /autograder/warm/nobody
XDG_CACHE_HOME=/autograder/cache /autograder/venv/bin/minirt grade /autograder/warm \
    --rubric /autograder/source/rubric.toml --out /autograder/warmed
