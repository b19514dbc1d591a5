# Every target works from nothing: it makes the virtual environment that it needs.
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/ready

.PHONY: demo reproduce test test-slow lint types bench bench-identification convergence clean

$(READY): pyproject.toml constraints.txt
	python3 -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[dev]'
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

bench: $(READY)
	$(BIN)/python -m benchmarks.speed

convergence: $(READY)
	$(BIN)/python -m benchmarks.convergence

clean:
	rm -rf $(VENV) propmap-demo propmap-reproduce
