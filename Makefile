# Every target works from nothing: it makes the virtual environment that it needs.
VENV := .venv
BIN := $(VENV)/bin
TOOLS_READY := $(VENV)/tools-ready
READY := $(VENV)/ready
DOCS_READY := $(VENV)/docs-ready
PEERS_READY := $(VENV)/peers-ready

.PHONY: demo reproduce test test-fast test-slow lint types sanitize bench bench-sim docs build wheels clean

# Python compiles what it imports once and keeps it, here too where the environment says otherwise: tests start some hundred
# processes.  Nothing is compiled that is never imported, as pip would.
unexport PYTHONDONTWRITEBYTECODE
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --constraint constraints.txt
CORE := CMakeLists.txt $(shell find core -name '*.[ch]pp')

# A C++ compiler builds the core.  Where there is none, the package index's is taken, Zig's, by the usual names.
# (Without the `true` Make takes a last name that is not found for a failure of all.)
ifeq ($(origin CXX)$(shell for name in c++ g++ clang++; do command -v $$name; done; true),default)
ZIG := $(abspath $(VENV))/zig
export PATH := $(ZIG):$(PATH)
export CC := $(ZIG)/cc
export CXX := $(ZIG)/c++
ZIG_TOOLS := $(ZIG)/ar $(ZIG)/c++ $(ZIG)/cc $(ZIG)/ranlib
endif

$(TOOLS_READY): constraints.txt
	python3 -m venv $(VENV)
	$(INSTALL) cmake nanobind ninja scikit-build-core $(if $(ZIG),ziglang)
	touch $@

$(ZIG_TOOLS): $(TOOLS_READY)
	mkdir -p $(@D)
	printf '#!/bin/sh\nexec "$(abspath $(BIN))/python" -m ziglang $(@F) "$$@"\n' >$@
	chmod +x $@

# Builds with the tools of $(VENV), so that a changed core is built in the time of what has changed.
$(READY): $(TOOLS_READY) $(ZIG_TOOLS) pyproject.toml $(CORE)
	$(INSTALL) --no-build-isolation --editable '.[cluster,dev,explore,figures,jax,logs,mjx,mujoco,netcdf,targets$(if $(WITH_DOCS),$(COMMA)docs)]'
	touch $@ $(if $(WITH_DOCS),$(DOCS_READY))

# What it takes comes with the rest where CI asks for both at once.
COMMA := ,
$(DOCS_READY): $(READY)
	$(INSTALL) --no-build-isolation --editable '.[docs]'
	touch $@

# Without what WISDEM asks for, some ninety packages: CCBlade, which is all that is compared, needs none.
$(PEERS_READY): $(READY)
	$(INSTALL) --no-deps wisdem
	touch $@

build: $(READY)

# NumPy's large arrays come from memory that the process keeps, instead of fresh pages from the system for
# each.  Other C libraries than glibc ignore it.
export MALLOC_MMAP_THRESHOLD_ ?= 536870912
export MALLOC_TRIM_THRESHOLD_ ?= 536870912
export MALLOC_TOP_PAD_ ?= 16777216

# Each file's tests stay together, for the tables they share.
WORKERS := 2
PYTEST := $(BIN)/python -m pytest --numprocesses $(WORKERS) --dist loadfile

demo: $(READY)
	$(BIN)/python examples/demo.py -o propmap-demo

reproduce: $(READY)
	$(BIN)/python -m papers.gill_dandrea_2017 -o propmap-reproduce

test: $(READY)
	$(PYTEST) -m 'not slow'

# Every reader, and the physics in short.
FAST := tests/io tests/vehicle tests/model tests/catalogue tests/core/test_core.py tests/rotor/test_limits.py \
	tests/docs/test_equations.py tests/docs/test_equations_are_live.py tests/oracle/test_extended_reference.py

test-fast: $(READY)
	$(PYTEST) -m 'not slow' $(FAST)

test-slow: $(READY)
	$(PYTEST) -m slow

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)
	$(BIN)/mypy

# The tests of the core on a build that stops at errors of memory and at undefined behaviour.  Python itself is built without
# the checks, so their library, and the one of C++ that it looks into, come first; it leaks on purpose.  Without `site`
# (-S) Python does not find the editable package, and takes the one of this build.  What compares many points bit by bit says
# nothing of memory that the others don't, and takes the most time here.
SANITIZED := build/sanitize
sanitize: $(READY)
	$(if $(ZIG),$(error `make sanitize` needs g++ 12 or later, which brings the checks; install it))
	$(INSTALL) --no-build-isolation --no-deps --upgrade --target $(SANITIZED)/site --config-settings=build-dir=$(SANITIZED)/core \
		--config-settings=cmake.build-type=Debug --config-settings=cmake.define.PROPMAP_SANITIZE=ON .
	LD_PRELOAD="$$($(CXX) -print-file-name=libasan.so) $$($(CXX) -print-file-name=libstdc++.so)" \
		ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1 \
		PYTHONPATH=$(SANITIZED)/site:$$(echo $(VENV)/lib/python3*/site-packages) $(BIN)/python -S -m pytest tests/core \
		-k 'not changes_no_bit and not other_processes and not thousand_points'

# An sdist, a wheel of it for every processor of this kind, and both tried where there is no checkout.
wheels: $(TOOLS_READY) $(ZIG_TOOLS)
	rm -rf dist
	$(BIN)/python -c 'from scikit_build_core.build import build_sdist; build_sdist("dist")'
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --no-build-isolation --wheel-dir dist \
		--config-settings=cmake.define.PROPMAP_PORTABLE=ON dist/*.tar.gz
	$(BIN)/python -u tools/try_wheel.py dist

# README's times; or one measurement with its arguments, as in `make bench ONLY=choice` and `make bench ONLY='table fine'`.
# The lifting line's matrices are too small for several threads.
bench: $(if $(filter peers,$(ONLY)),$(PEERS_READY),$(READY))
ifdef ONLY
	$(if $(filter lifting_line,$(ONLY)),OMP_NUM_THREADS=1) $(BIN)/python -m benchmarks.$(ONLY)
else
	$(BIN)/python -m benchmarks.speed
	$(BIN)/python -m benchmarks.identification seconds
	$(BIN)/python -m benchmarks.table
endif

# What a step costs where people simulate.
bench-sim: $(READY)
	$(BIN)/python -m benchmarks.sim
	$(BIN)/python -m benchmarks.mjx

docs: $(DOCS_READY)
	$(BIN)/sphinx-build --fail-on-warning --keep-going docs docs/_build/html

clean:
	rm -rf $(VENV) build dist .pytest_cache propmap-demo propmap-reproduce docs/_build docs/generated docs/propellers
