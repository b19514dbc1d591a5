# Every target works from nothing: it makes the virtual environment that it needs.
VENV := .venv
BIN := $(VENV)/bin
READY := $(VENV)/ready
DOCS_READY := $(VENV)/docs-ready
PEERS_READY := $(VENV)/peers-ready

.PHONY: demo reproduce test test-fast test-readers test-numpy test-slow lint types bench bench-table bench-fine-table bench-choice bench-identification bench-peers bench-phases bench-options bench-aircraft bench-mount bench-roofline bench-accelerator convergence docs clean bench-certificates bench-lifting-line bench-interference bench-flight-twins bench-cluster bench-explore

$(READY): pyproject.toml constraints.txt
	python3 -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[cluster,dev,explore,targets]'
	touch $@

$(DOCS_READY): $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --editable '.[docs]'
	touch $@

# Without what WISDEM asks for, some ninety packages: CCBlade, which is all that is compared, needs none.
$(PEERS_READY): $(READY)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check --constraint constraints.txt --no-deps wisdem
	touch $@

# NumPy's large arrays come from memory that the process keeps, instead of fresh pages from the system for
# each: a quarter less time of the tests that compile nothing.  Other C libraries than glibc ignore it.
export MALLOC_MMAP_THRESHOLD_ ?= 536870912
export MALLOC_TRIM_THRESHOLD_ ?= 536870912
export MALLOC_TOP_PAD_ ?= 16777216

# Two processes take 8 GB, the slow tests up to 15; each file's tests stay together, for the programs and tables they share.
WORKERS := 2
PYTEST := $(BIN)/python -m pytest --numprocesses $(WORKERS) --dist loadfile

demo: $(READY)
	$(BIN)/propmap demo -o propmap-demo

reproduce: $(READY)
	$(BIN)/propmap reproduce -o propmap-reproduce

test: $(READY)
	$(PYTEST) -m 'not slow'

# What needs no compiler: every reader, and the physics on NumPy, beside each other.
READERS := tests/io tests/vehicle tests/model tests/catalogue
ON_NUMPY := tests/physics/test_tip_loss.py tests/physics/sections/test_tabulated.py tests/rotor/test_limits.py \
	tests/docs/test_equations.py tests/docs/test_equations_are_live.py tests/oracle/test_extended_reference.py

test-fast: $(READY)
	$(MAKE) --no-print-directory --jobs 2 test-readers test-numpy

test-readers: $(READY)
	$(BIN)/python -m pytest -m 'not slow' $(READERS)

test-numpy: $(READY)
	$(BIN)/python -m pytest -m 'not slow' $(ON_NUMPY)

test-slow: $(READY)
	$(PYTEST) -m slow

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)
	$(BIN)/mypy

bench-identification: $(READY)
	$(BIN)/python -m benchmarks.identification

bench-flight-twins: $(READY)
	$(BIN)/python -m benchmarks.flight_twins

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

bench-options: $(READY)
	$(BIN)/python -m benchmarks.options

bench-aircraft: $(READY)
	$(BIN)/python -m benchmarks.aircraft

bench-explore: $(READY)
	$(BIN)/python -m benchmarks.explore

bench-interference: $(READY)
	$(BIN)/python -m benchmarks.interference

bench-mount: $(READY)
	$(BIN)/python -m benchmarks.mount_drag

bench-certificates: $(READY)
	$(BIN)/python -m benchmarks.certificates
# Its matrices are too small for several threads.
bench-lifting-line: $(READY)
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.lifting_line
	OMP_NUM_THREADS=1 $(BIN)/python -m benchmarks.lifting_line.causes

bench-cluster: $(READY)
	$(BIN)/python -m benchmarks.cluster

bench-phases: $(READY)
	$(BIN)/python -m benchmarks.phases

convergence: $(READY)
	$(BIN)/python -m benchmarks.convergence

docs: $(DOCS_READY)
	$(BIN)/sphinx-build --fail-on-warning --keep-going docs docs/_build/html

clean:
	rm -rf $(VENV) .pytest_cache propmap-demo propmap-reproduce docs/_build docs/generated docs/propellers
