# Start with `make demo` and `make test`. Both make the virtual environment if it is missing.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
BIN := .venv/bin

.PHONY: demo test slow soak check site smoke catalog baseline bench lock

demo: .venv/installed
	$(BIN)/luxloop run sumo-crossing

# The kernels are compiled first, so that parallel tests do not each compile them.
test: .venv/installed
	$(BIN)/luxloop warm-up --quiet
	$(BIN)/pytest -n 2

# Tests that take minutes: a thousand mutated scenario files, killed runs, sweeps of two thousand runs, the wheel.
slow: .venv/installed
	$(BIN)/luxloop warm-up --quiet
	$(BIN)/pytest -n 2 -m slow

# Tests that take up to an hour, for releases: ten thousand broken inputs, a hundred kills, a hundred thousand rows.
soak: .venv/installed
	$(BIN)/pytest -n 2 -m soak

check: .venv/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(MAKE) --no-print-directory site

# The documentation as a site, in site/. Broken links and anchors fail, but not with --quiet, which hides them.
site: .venv/installed
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

# Scenarios as tests: the smoke suite or the whole catalog, compared with the committed baseline. luxloop.html is the report.
BASELINE := scenarios/baseline/catalog.jsonl

smoke: .venv/installed
	$(BIN)/pytest scenarios/catalog -m smoke -n 2 --luxloop-out runs/smoke --junitxml luxloop.xml --luxloop-report luxloop.html
	$(BIN)/luxloop compare $(BASELINE) runs/smoke

catalog: .venv/installed
	$(BIN)/luxloop warm-up --quiet
	$(BIN)/pytest scenarios/catalog -n 2 --luxloop-out runs/catalog --junitxml luxloop.xml --luxloop-report luxloop.html
	$(BIN)/luxloop compare $(BASELINE) runs/catalog

# After `make catalog`: make its runs the new baseline.
baseline:
	$(BIN)/luxloop baseline runs/catalog --out $(BASELINE)

bench: .venv/installed
	$(BIN)/python -m benchmarks

# ouster-sdk pins versions of other packages that exclude those of rerun-sdk; it runs with the ones in constraints.txt.
# osi-python needs a newer protobuf than commonroad-io; tests read OSI traces with it in a process of its own.
.venv/installed: constraints.txt constraints-ouster.txt constraints-osi3.txt pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check --require-hashes -r constraints.txt
	$(BIN)/pip install --quiet --disable-pip-version-check --require-hashes --no-deps -r constraints-ouster.txt
	$(BIN)/pip install --quiet --disable-pip-version-check --require-hashes --upgrade --target .venv/osi3 -r constraints-osi3.txt
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	touch $@

# Pin the dependencies of pyproject.toml and of all extras but `opendrive`; needs uv. Pinned versions stay:
# `make lock UPGRADE=--upgrade` takes the newest ones.
lock:
	uv pip compile pyproject.toml --extra dev --universal --python-version 3.11 --generate-hashes \
	    --no-header --no-annotate --output-file constraints.txt $(UPGRADE)
	echo "osi-python>=3.8" | uv pip compile - --universal --python-version 3.11 --generate-hashes \
	    --no-header --no-annotate --output-file constraints-osi3.txt $(UPGRADE)
	echo "ouster-sdk>=1.0.1" | uv pip compile - --no-deps --universal --python-version 3.11 --generate-hashes \
	    --no-header --no-annotate --output-file constraints-ouster.txt $(UPGRADE)
