# What a newcomer needs: `make demo` and `make test`. Both make the virtual environment where it is missing.
PYTHON ?= $(shell command -v python3.11 || command -v python3)
BIN := .venv/bin

.PHONY: demo test check smoke catalog bench lock

demo: .venv/installed
	$(BIN)/luxloop run sumo-crossing

test: .venv/installed
	$(BIN)/pytest -n 2

check: .venv/installed
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

# Scenarios as tests: the few for every change, and all. luxloop.html shows what came out.
smoke: .venv/installed
	$(BIN)/pytest scenarios/catalog -m smoke -n 2 --junitxml luxloop.xml --luxloop-report luxloop.html

catalog: .venv/installed
	$(BIN)/pytest scenarios/catalog -n 2 --junitxml luxloop.xml --luxloop-report luxloop.html

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
	    --no-header --no-annotate --upgrade --output-file constraints.txt
