# Every target creates the virtual environment that it needs.
VENV := .venv
BIN := $(VENV)/bin
TOOLS_READY := $(VENV)/tools-ready
BUILT := $(VENV)/built
READY := $(VENV)/ready
DOCS_READY := $(VENV)/docs-ready
PEERS_READY := $(VENV)/peers-ready

.PHONY: demo reproduce test test-fast test-slow lint types sanitize bench bench-sim docs build wheels matrix clean

# Keep the bytecode of imported modules even if the environment disables it, because the tests start some hundred processes.
# --no-compile stops pip from compiling modules that are never imported.
unexport PYTHONDONTWRITEBYTECODE
INSTALL := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile --constraint constraints.txt
CORE := CMakeLists.txt $(shell find core -name '*.[ch]pp')

# A C++ compiler builds the core.  If none is found, use Zig's compiler from the package index under the usual names.
# (Without `true`, Make reports a failure if the last name is not found.)
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

# Build with the tools of $(VENV), so that Ninja compiles only changed parts of the core.  The demo needs `figures`.  The
# dependencies are installed while the compiler runs.
EDITABLE := $(INSTALL) --no-build-isolation --editable
DEPENDENCIES := p = __import__("tomllib").load(open("pyproject.toml", "rb"))["project"]; \
	print(*p["dependencies"], *p["optional-dependencies"]["figures"], sep="\n")
$(BUILT): $(TOOLS_READY) $(ZIG_TOOLS) pyproject.toml $(CORE)
	$(BIN)/python -c '$(DEPENDENCIES)' >$(VENV)/dependencies.txt
	$(INSTALL) --requirement $(VENV)/dependencies.txt & $(EDITABLE) . --no-deps && wait $$!
	touch $@

# $(BUILT) is an order-only prerequisite: a change of the core does not install the extras again.
$(READY): constraints.txt pyproject.toml | $(BUILT)
	$(EDITABLE) '.[cluster,dev,explore,figures,jax,logs,mjx,mujoco,netcdf,targets$(if $(WITH_DOCS),$(COMMA)docs)]'
	touch $@ $(if $(WITH_DOCS),$(DOCS_READY))

# If CI sets WITH_DOCS, the rule above already installs the extra `docs`.
COMMA := ,
$(DOCS_READY): $(READY)
	$(EDITABLE) '.[docs]'
	touch $@

# Skip WISDEM's dependencies, about ninety packages: only CCBlade is compared, which needs none of them.
$(PEERS_READY): $(READY)
	$(INSTALL) --no-deps wisdem
	touch $@

build: $(BUILT)

# Let glibc reuse memory for NumPy's large arrays, instead of requesting new pages for each array.  Other C libraries
# ignore these variables.
export MALLOC_MMAP_THRESHOLD_ ?= 536870912
export MALLOC_TRIM_THRESHOLD_ ?= 536870912
export MALLOC_TOP_PAD_ ?= 16777216

# Tests of one file run in one process, because they share tables.
WORKERS := 2
PYTEST := $(BIN)/python -m pytest --numprocesses $(WORKERS) --dist loadfile

demo: $(BUILT)
	$(BIN)/python examples/demo.py -o propmap-demo

reproduce: $(READY)
	$(BIN)/python -m papers.gill_dandrea_2017 -o propmap-reproduce

test: $(READY)
	$(PYTEST) -m 'not slow'

# All readers and the essential physics.
FAST := tests/io tests/vehicle tests/model tests/catalogue tests/core/test_core.py tests/rotor/test_limits.py \
	tests/docs/test_equations.py tests/oracle/test_extended_reference.py

test-fast: $(READY)
	$(PYTEST) -m 'not slow' $(FAST)

test-slow: $(READY)
	$(PYTEST) -m slow

lint: $(READY)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(READY)
	$(BIN)/mypy

# Call all functions of the core in a build that stops at memory errors and undefined behavior.  Python itself is built
# without the sanitizers, so LD_PRELOAD loads their library and the C++ library first.  Python leaks memory on purpose.
# Without `site` (-S), Python imports the package of this build instead of the editable one.  The excluded tests compare
# many points bit by bit; the other tests use the same memory.
SANITIZED := build/sanitize
sanitize: $(READY)
	$(if $(ZIG),$(error `make sanitize` needs g++ 12 or later, which brings the checks; install it))
	$(INSTALL) --no-build-isolation --no-deps --upgrade --target $(SANITIZED)/site --config-settings=build-dir=$(SANITIZED)/core \
		--config-settings=cmake.build-type=Debug --config-settings=cmake.define.PROPMAP_SANITIZE=ON .
	LD_PRELOAD="$$($(CXX) -print-file-name=libasan.so) $$($(CXX) -print-file-name=libstdc++.so)" \
		ASAN_OPTIONS=detect_leaks=0 UBSAN_OPTIONS=print_stacktrace=1 \
		PYTHONPATH=$(SANITIZED)/site:$$(echo $(VENV)/lib/python3*/site-packages) $(BIN)/python -S -m pytest \
		tests/core/test_core.py tests/core/test_tables_and_vehicles.py -k 'not bit'

SDIST := rm -rf dist && $(BIN)/python -c 'from scikit_build_core.build import build_sdist; build_sdist("dist")'

# Build an sdist, and a wheel for every processor of this architecture; test both without a checkout.
wheels: $(TOOLS_READY) $(ZIG_TOOLS)
	$(SDIST)
	$(BIN)/python -m pip wheel --quiet --disable-pip-version-check --no-deps --no-build-isolation --wheel-dir dist \
		--config-settings=cmake.define.PROPMAP_PORTABLE=ON dist/*.tar.gz
	$(BIN)/python -u tools/try_wheel.py dist

# Test the sdist with other Pythons, dependencies and compilers; for example `make matrix PYTHONS='3.12 path/to/python3.14'`.
matrix: $(TOOLS_READY) $(ZIG_TOOLS)
	$(INSTALL) uv ziglang
	$(SDIST)
	$(BIN)/python -u tools/matrix.py dist $(PYTHONS)

# Measure the times on the documentation pages, or run one measurement with its arguments, for example
# `make bench ONLY=choice` and `make bench ONLY='table fine'`.  The matrices of the lifting line are too small for several threads.
bench: $(if $(filter peers,$(ONLY)),$(PEERS_READY),$(READY))
ifdef ONLY
	$(if $(filter lifting_line,$(ONLY)),OMP_NUM_THREADS=1) $(BIN)/python -m benchmarks.$(ONLY)
else
	$(BIN)/python -m benchmarks.speed
	$(BIN)/python -m benchmarks.identification seconds
	$(BIN)/python -m benchmarks.table
endif

# Measure the time of a simulation step in MuJoCo and MJX.
bench-sim: $(READY)
	$(BIN)/python -m benchmarks.sim
	$(BIN)/python -m benchmarks.mjx

docs: $(DOCS_READY)
	$(BIN)/sphinx-build --fail-on-warning --keep-going docs docs/_build/html

clean:
	rm -rf $(VENV) build dist .pytest_cache propmap-demo propmap-reproduce docs/_build docs/generated docs/propellers
