# Every target works from nothing: it makes the virtual environment that it needs.
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/ready
DOCS_READY := $(VENV)/docs-ready
PEERS_READY := $(VENV)/peers-ready

.PHONY: demo reproduce test test-slow lint types bench bench-table bench-fine-table bench-choice bench-identification bench-peers bench-phases bench-roofline bench-accelerator convergence docs clean

$(READY): pyproject.toml constraints.txt
	python3 -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev,targets]'
	touch $@

$(DOCS_READY): $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[docs]'
	touch $@

# Without what WISDEM asks for, some ninety packages: CCBlade, which is all that is compared, needs none.
$(PEERS_READY): $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --no-deps wisdem
	touch $@

demo: $(READY)
	$(BIN)/propmap demo -o propmap-demo

reproduce: $(READY)
	$(BIN)/propmap reproduce -o propmap-reproduce

test: $(READY)
	$(BIN)/python -m pytest -m 'not slow'

test-slow: $(READY)
	$(BIN)/python -m pytest -m slow

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)
	$(BIN)/mypy

bench-identification: $(READY)
	$(BIN)/python -m benchmarks.identification

bench-choice: $(READY)
	$(BIN)/python -m benchmarks.choice

bench-roofline: $(READY)
	$(BIN)/python -m benchmarks.roofline

# Needs JAX's plugin for the accelerator in $(VENV); without one it says so.
bench-accelerator: $(READY)
	$(BIN)/python -m benchmarks.accelerator

bench-peers: $(PEERS_READY)
	$(BIN)/python -m benchmarks.peers

bench: $(READY)
	$(BIN)/python -m benchmarks.speed
	$(BIN)/python -m benchmarks.identification seconds
	$(BIN)/python -m benchmarks.table

bench-table: $(READY)
	$(BIN)/python -m benchmarks.table

bench-fine-table: $(READY)
	$(BIN)/python -m benchmarks.table fine

bench-phases: $(READY)
	$(BIN)/python -m benchmarks.phases

convergence: $(READY)
	$(BIN)/python -m benchmarks.convergence

docs: $(DOCS_READY)
	$(BIN)/sphinx-build --fail-on-warning --keep-going docs docs/_build/html

clean:
	rm -rf $(VENV) propmap-demo propmap-reproduce docs/_build docs/generated
