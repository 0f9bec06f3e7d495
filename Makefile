# Start with `make demo` and `make test`. Both make the virtual environment if it is missing, by another Python with
# `make demo PYTHON=python3.13`.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
BIN := .venv/bin
PIP := $(BIN)/pip --quiet --disable-pip-version-check

.PHONY: demo test slow soak check figures site smoke catalog baseline bench wheel lock

demo: .venv/installed
	@echo "Running the scenario sumo-crossing. The first run compiles luxloop's kernels, which takes about two minutes."
	$(BIN)/luxloop run sumo-crossing

# The kernels are compiled first, so that parallel tests do not each compile them. Each process begins with a half of the
# files and takes over tests of the other at the end, so that what the tests of a file share is mostly made once.
test: .venv/developed
	$(BIN)/luxloop warm-up --quiet
	$(BIN)/pytest -n 2 --dist worksteal

# Tests that take minutes: hundreds of mutated scenario files, killed runs, sweeps of hundreds of runs, the wheel,
# commands of pages, recorded streets, and more seeds, examples, pages and processes of what quick tests cover.
slow: .venv/developed
	$(BIN)/luxloop warm-up --quiet
	$(BIN)/pytest -n 2 --dist worksteal -m slow

# Tests that take up to an hour, for releases: a thousand mutated scenario files, ten thousand broken inputs, a hundred
# kills, a sweep of two thousand runs, a hundred thousand rows.
soak: .venv/developed
	$(BIN)/pytest -n 2 -m soak

check: .venv/developed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(BIN)/python docs/figures.py --check
	$(MAKE) --no-print-directory site

# Measured figures, tables and pictures of the pages that are older than the baseline: hours on two cores. A second call
# continues where the first was interrupted.
figures: .venv/developed
	$(BIN)/python docs/figures.py

# The documentation as a site, in site/. Broken links and anchors fail, but not with --quiet, which hides them.
site: .venv/developed
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

# Scenarios as tests: the smoke suite or the whole catalog, compared with the committed baseline. luxloop.html is the report.
BASELINE := scenarios/baseline/catalog.jsonl

smoke: .venv/developed
	$(BIN)/pytest scenarios/catalog -m smoke -n 2 --luxloop-out runs/smoke --junitxml luxloop.xml --luxloop-report luxloop.html
	$(BIN)/luxloop compare $(BASELINE) runs/smoke

catalog: .venv/developed
	$(BIN)/luxloop warm-up --quiet
	$(BIN)/pytest scenarios/catalog -n 2 --luxloop-out runs/catalog --junitxml luxloop.xml --luxloop-report luxloop.html
	$(BIN)/luxloop compare $(BASELINE) runs/catalog

# After `make catalog`: make its runs the new baseline, by which the figures of the pages are dated.
baseline:
	$(BIN)/luxloop baseline runs/catalog --out $(BASELINE)

bench: .venv/developed
	$(BIN)/python -m benchmarks

# The environment of the run time: the packages of constraints.txt, and luxloop itself. It is made anew when they change,
# because pip keeps packages that are not listed any more.
.venv/packages: constraints.txt
	@$(PYTHON) -c 'import sys; sys.exit(None if sys.version_info >= (3, 11) else "luxloop needs Python 3.11 or newer, $(PYTHON) is " + sys.version.split()[0])'
	@echo "Making the virtual environment .venv."
	$(PYTHON) -m venv --clear .venv
	@echo "Installing the packages of constraints.txt into .venv, 1.5 GB on disk. This takes a minute or more."
	$(PIP) install --require-hashes -r constraints.txt
	@touch $@

.venv/installed: .venv/packages pyproject.toml
	@echo "Installing luxloop into .venv."
	$(PIP) install --no-deps --no-build-isolation --editable .
	@touch $@

# A wheel with kernels that are compiled for one processor: a first run of this Python compiles nothing.
wheel: .venv/developed
	rm -rf dist
	$(PIP) wheel . --no-deps --no-build-isolation --wheel-dir dist
	$(BIN)/python .ci/wheel_kernels.py dist/*.whl

# The same packages and those for development. Packages that exclude some of them are installed by the tests that need
# them, in folders of their own (tests/support/separate_packages.py).
.venv/developed: .venv/installed constraints-dev.txt
	@echo "Installing the packages for development of constraints-dev.txt into .venv, 0.7 GB more. This takes a minute or more."
	$(PIP) install --require-hashes -r constraints-dev.txt
	@touch $@

# Pin the dependencies for development (all extras but `opendrive`), and those of the run time in the same versions;
# needs uv. Pinned versions stay: `make lock UPGRADE=--upgrade` takes the newest ones. numpy and scipy are the newest for
# Python 3.11, so that results are the same under every Python.
COMPILE = uv pip compile --universal --python-version 3.11 --generate-hashes --no-header --no-annotate $(UPGRADE)

lock:
	printf "numpy<2.5\nscipy<1.18\n" | $(COMPILE) pyproject.toml --extra dev --group build --constraint - \
	    --output-file constraints-dev.txt
	$(COMPILE) pyproject.toml --group build --constraint constraints-dev.txt --output-file constraints.txt
	echo "osi-python>=3.8" | $(COMPILE) - --output-file constraints-osi3.txt
	echo "ouster-sdk>=1.0.1" | $(COMPILE) - --no-deps --output-file constraints-ouster.txt
