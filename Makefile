# From nothing to the answer: `make verify` and `make test` each set up .venv by themselves.

PYTHON ?=
# Two more than there are cores: tests wait for the programs that they start.
JOBS ?= $(shell expr $$(nproc) + 2)
REPORT ?= report
# The tests of a file stay together where they can: they share what is costly to make.
PYTEST := -n $(JOBS) --dist worksteal

VENV := .venv
BIN := $(VENV)/bin
LOCKED := $(VENV)/.installed-lock
READY := $(VENV)/.installed-minirt
TESTABLE := $(VENV)/.installed-for-tests
UV := uv==0.13.9

# The tests start hundreds of short Python processes: our modules are compiled once, not in each.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.PHONY: help verify test test-all test-fast test-rest lint types architecture
.PHONY: bench setup format lock clean again
.DELETE_ON_ERROR:

help:  ## this list
	@sed -n 's/^\([a-z-]*\):.*## /make \1\t/p' $(MAKEFILE_LIST) | expand -t 20

verify: $(READY)  ## render the atlas here and in the references, compare, leave report/
	$(BIN)/minirt verify --out $(REPORT)

test: $(READY) $(TESTABLE)  ## lint, types, architecture and the fast tests, side by side: 4 minutes
	@$(MAKE) --no-print-directory --keep-going --jobs=4 lint types architecture test-fast

test-all: test  ## every test
	@$(MAKE) --no-print-directory test-rest

# Two tiers (tests/conftest.py): each test is in exactly one.
test-fast: $(READY) $(TESTABLE)  ## only the fast tests
	$(BIN)/pytest $(PYTEST) -m 'not full'

test-rest: $(READY) $(TESTABLE)  ## only the tests that `make test` leaves out
	$(BIN)/pytest $(PYTEST) -m 'full'

# A check says one line where all is well, and all that it found where it is not.
said = @found=$$({ $(1); } 2>&1) && echo "$@: no fault" || { echo "$$found"; exit 1; }

lint: $(READY)  ## the linter and the format
	$(call said,$(BIN)/ruff check && $(BIN)/ruff format --check)

types: $(READY)  ## mypy, strict
	$(call said,$(BIN)/mypy)

architecture: $(READY)  ## imports go one way
	$(call said,$(BIN)/lint-imports --no-logo)

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
