# From nothing to the answer: `make verify` and `make test` each set up .venv by themselves.

PYTHON ?=
# One more than there are cores: tests wait for the programs that they start.
JOBS ?= $(shell expr $$(nproc) + 1)
REPORT ?= report

VENV := .venv
BIN := $(VENV)/bin
LOCKED := $(VENV)/.installed-lock
READY := $(VENV)/.installed-minirt
TESTABLE := $(VENV)/.installed-for-tests
UV := uv==0.13.9

# The tests start hundreds of short Python processes: our modules are compiled once, not in each.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help verify test bench setup format lock clean again
.DELETE_ON_ERROR:

help:  ## this list
	@sed -n 's/^\([a-z]*\):.*## /make \1\t/p' $(MAKEFILE_LIST) | expand -t 16

verify: $(READY)  ## render the atlas here and in Mitsuba, compare, leave the report in report/
	$(BIN)/minirt verify --out $(REPORT)

test: $(READY) $(TESTABLE)  ## lint, format, types, architecture, tests
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/pytest -n $(JOBS)

bench: $(READY) $(TESTABLE)  ## minirt's speed beside that of whatever else is here
	$(BIN)/pytest tests/bench -c tests/bench/pytest.toml --benchmark-json=bench.json
	$(BIN)/python -m tests.bench.bench_table bench.json

setup: $(READY)  ## only set up .venv

format: $(READY)  ## apply the linter's fixes and the format
	$(BIN)/ruff check --fix
	$(BIN)/ruff format

lock: $(READY)  ## resolve pyproject.toml anew into requirements.lock
	$(BIN)/python -m pip install --quiet $(UV)
	$(BIN)/uv pip compile --quiet --upgrade --universal --python-version 3.11 \
	    --fork-strategy fewest --all-extras --generate-hashes \
	    --no-emit-index-url --no-emit-find-links --custom-compile-command 'make lock' \
	    --output-file requirements.lock pyproject.toml

clean:  ## remove .venv, the report with its history, and every cache
	rm -rf $(VENV) $(REPORT) bench.json .benchmarks build dist *.egg-info .hypothesis .*_cache
	find minirt converters reference reports tests -name __pycache__ -prune -exec rm -rf {} +

# An environment whose python does not run is made again. PYTHON=... names the one to use.
$(LOCKED): requirements.lock $(if $(shell $(BIN)/python -c 'print(1)' 2>/dev/null),,again)
	@set -e; \
	python="$(PYTHON)"; [ -n "$$python" ] || python=$$(.ci/find-python); \
	.ci/system-packages "$$python"; \
	$(BIN)/python -c 'import pip' 2>/dev/null || "$$python" -m venv --clear $(VENV)
	@echo "Installing what requirements.lock pins into $(VENV), once" >&2
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check \
	    --require-hashes --requirement requirements.lock
	@touch $@

$(READY): $(LOCKED) pyproject.toml
	@$(BIN)/python -m pip install -qq --disable-pip-version-check \
	    --no-deps --no-build-isolation --editable .
	@touch $@

$(TESTABLE): .ci/system-packages $(LOCKED)
	@.ci/system-packages $(BIN)/python test
	@touch $@
