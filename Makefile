# What a newcomer needs: `make demo` and `make test`. Both make the virtual environment where it is missing.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
BIN := .venv/bin

.PHONY: demo test slow check smoke catalog baseline bench lock

demo: .venv/installed
	$(BIN)/luxloop run sumo-crossing

test: .venv/installed
	$(BIN)/pytest -n 2

# What takes minutes: a thousand broken scenario files, runs killed at every moment, two thousand runs of a sweep.
slow: .venv/installed
	$(BIN)/pytest -n 2 -m slow

check: .venv/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# Scenarios as tests: the few for every change, and all; then held against the committed baseline. luxloop.html shows them.
BASELINE := scenarios/baseline/catalog.jsonl

smoke: .venv/installed
	$(BIN)/pytest scenarios/catalog -m smoke -n 2 --luxloop-out runs/smoke --junitxml luxloop.xml --luxloop-report luxloop.html
	$(BIN)/luxloop compare $(BASELINE) runs/smoke

catalog: .venv/installed
	$(BIN)/pytest scenarios/catalog -n 2 --luxloop-out runs/catalog --junitxml luxloop.xml --luxloop-report luxloop.html
	$(BIN)/luxloop compare $(BASELINE) runs/catalog

# After `make catalog`, when its runs are what later ones are to be held against.
baseline:
	$(BIN)/luxloop baseline runs/catalog --out $(BASELINE)

bench: .venv/installed
	$(BIN)/python -m benchmarks

.venv/installed: constraints.txt pyproject.toml
	$(PYTHON) -m venv .venv
	$(BIN)/pip install --quiet --disable-pip-version-check --require-hashes -r constraints.txt
	$(BIN)/pip install --quiet --disable-pip-version-check --no-deps --no-build-isolation --editable .
	touch $@

# Pin anew what pyproject.toml asks for; needs uv.
lock:
	uv pip compile pyproject.toml --all-extras --universal --python-version 3.11 --generate-hashes \
	    --no-header --no-annotate --output-file constraints.txt $(UPGRADE)
