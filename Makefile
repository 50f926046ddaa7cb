# orbsoc: `make demo` sets up and runs the main job, `make test` sets up and checks everything.
# Needs Python >= 3.11, a Rust toolchain and a C compiler; scripts/require_tools.sh names what is missing.

PYTHON ?= python3
FUZZ   ?= 20
T      ?= tests --ignore=tests/integration/test_wheel.py
ROUTE  ?=
PROBLEM ?=
VENV   := .venv
BIN    := $(VENV)/bin
PIP    := $(BIN)/python -m pip --disable-pip-version-check --quiet

# Everything the wheel is made of. Stamps live in $(VENV), so that removing it starts afresh.
SOURCES := Cargo.toml Cargo.lock pyproject.toml README.md LICENSE rust-toolchain.toml scripts/build_wheel.sh \
           $(wildcard rtl/*.svh flight/* flight/missions/*) \
           $(shell find rust python hw_model -type f -not -path '*/__pycache__/*' -not -name '*.so' \
                   -not -path 'rust/*/tests/*' -not -path 'rust/*/benches/*')
READY     := $(VENV)/build-tools.stamp
RUNTIME   := $(VENV)/runtime.stamp
TESTING   := $(VENV)/test.stamp
BENCHING  := $(VENV)/bench.stamp
WRITING   := $(VENV)/docs.stamp
ROUTING   := $(VENV)/route.stamp
WHEEL     := $(VENV)/wheel.stamp
INSTALLED := $(VENV)/installed.stamp
FILE_LIST := $(VENV)/sources.list

# A computer for an FPGA, step by step; its program comes last (scripts/board/flow.py).
BOARD   := out/board
CIRCUIT := $(wildcard rtl/*.sv* rtl/fpu/* rtl/engine/* rtl/axi/* rtl/board/*.*) requirements/route.txt

# The extension beside the Python sources, for `make check`; git, the wheel and `make test` do not see it.
EXTENSION := python/orbsoc/_core.abi3.so
PROFILE   := $(or $(shell sed -n 's/^\[profile\.\(edit\)\]/\1/p' Cargo.toml),release)

export PYO3_PYTHON := $(CURDIR)/$(BIN)/python

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.NOTPARALLEL: # pip installs into one environment; compilers use all cores by themselves
.PHONY: help demo test check lint docs bench results units area route bitstream netlist long fuzz memcheck lock clean FORCE

help: ## list the targets
	@sed -n 's/^\([a-z]*\):.*## \(.*\)/  make \1\t\2/p' $(MAKEFILE_LIST) | expand -t 16

demo: $(INSTALLED) ## plan the insertion rec1 on the emulated computer, into out/demo
	$(BIN)/orbsoc plan scenarios/rec1.toml --out out/demo --deadline-ms 50

test: $(INSTALLED) $(TESTING) ## Rust tests, then Python tests against the installed wheel, on all cores
	cargo test --workspace --exclude orbsoc-py --locked
	$(BIN)/pytest -n auto --dist loadfile

check: $(EXTENSION) $(TESTING) ## the Python tests T=tests/conic on the sources: no wheel, Rust compiled when it has changed
	PYTHONPATH=$(CURDIR)/python:$(CURDIR) $(BIN)/pytest $(T)

lint: $(INSTALLED) $(TESTING) ## formats, clippy, rustdoc, ruff, mypy, stubs against the built extension
	cargo fmt --all --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked --quiet
	$(BIN)/ruff format --check
	$(BIN)/ruff check
	$(BIN)/mypy
	$(BIN)/stubtest orbsoc._core

docs: $(INSTALLED) $(WRITING) ## write the site into out/site: tutorials, gallery, reference; it needs no network
	$(BIN)/python -m sphinx -W --keep-going -q -b html docs out/site

bench: $(INSTALLED) $(BENCHING) ## time the solver beside its peers (ECOS is GPL: this target only)
	$(BIN)/python -m benchmarks.run --family mission004 --solvers orbsoc,clarabel,ecos,qoco --repeats 30 \
	    --out out/bench --readme docs/mission004-benchmark.md

results: $(INSTALLED) $(BENCHING) ## measure all that is required beside the peers, into docs/results.md (20 min)
	$(BIN)/python -m benchmarks.results --out out/results --page docs/results.md

units: $(INSTALLED) $(TESTING) ## a million vectors per floating-point unit and format, in Verilator
	ORBSOC_REQUIRE_RTL=1 ORBSOC_UNIT_VECTORS=1000000 $(BIN)/pytest tests/rtl/test_units.py

area: $(INSTALLED) ## synthesise the RTL with yosys, and hold the area formula against it (30 min)
	PYTHONPATH=$(CURDIR) $(BIN)/python -m scripts.record_synthesis xc7

route: $(INSTALLED) $(ROUTING) ## place and route the RTL, ROUTE=units or modules, all of it in hours; a stopped run goes on
	PYTHONPATH=$(CURDIR) $(BIN)/python -m scripts.record_route $(ROUTE)
	PATH=$(abspath $(BIN)):$$PATH PYTHONPATH=$(CURDIR) $(BIN)/python -m scripts.record_synthesis ultra

bitstream: $(BOARD)/routed.config | $(INSTALLED) $(ROUTING) ## out/board/board.bit for a ULX3S 85F: core, engine, and a program that solves PROBLEM on it
	PYTHONPATH=$(CURDIR) $(BIN)/python -m scripts.board.flow bitstream $(PROBLEM)

netlist: bitstream ## simulate what was placed and routed beside its RTL, with the program, and compare their words
	PYTHONPATH=$(CURDIR) $(BIN)/python -m scripts.board.simulate

long: $(INSTALLED) $(TESTING) ## the tests that take minutes each (tests/long.py), every command of the guides among them (70 min)
	$(BIN)/pytest -n auto --long -o faulthandler_timeout=10800

fuzz: $(INSTALLED) $(TESTING) ## the fuzzing of every entry point with new seeds, FUZZ=20 times as long as in the suite
	ORBSOC_FUZZ=$(FUZZ) cargo test --release -p orbsoc --lib --locked
	ORBSOC_FUZZ=$(FUZZ) $(BIN)/pytest tests/solving/test_fuzz.py tests/solving/test_bundle.py tests/solving/test_warm_start.py

memcheck: ## the core's Rust tests under valgrind, with a fiftieth of their random cases
	@command -v valgrind > /dev/null || { echo "make memcheck needs valgrind: apt-get install valgrind"; exit 2; }
	ORBSOC_FUZZ=0.02 cargo test --release -p orbsoc --lib --tests --locked \
	    --config "target.'cfg(all())'.runner='valgrind --quiet --error-exitcode=9'"

lock: ## renew requirements/*.txt from pyproject.toml
	$(PYTHON) scripts/lock_requirements.py

clean: ## remove everything that was built, the environment included
	rm -rf $(VENV) target dist out .pytest_cache .mypy_cache .ruff_cache .hypothesis

$(READY): requirements/build.txt
	@scripts/require_tools.sh $(PYTHON)
	$(PYTHON) -m venv $(VENV)
	$(PIP) install -r $<
	@touch $@

$(RUNTIME): requirements/runtime.txt $(READY)
	$(PIP) install -r $<
	@touch $@

$(TESTING): requirements/test.txt $(RUNTIME)
	$(PIP) install -r $<
	@touch $@

$(BENCHING): requirements/bench.txt $(RUNTIME)
	$(PIP) install -r $<
	@touch $@

$(WRITING): requirements/docs.txt $(RUNTIME)
	$(PIP) install -r $<
	@rustup target add wasm32-unknown-unknown || true # docs/extensions/page_solver.py says what is missing
	@touch $@

$(ROUTING): requirements/route.txt $(RUNTIME)
	$(PIP) install -r $<
	@touch $@

$(BOARD)/netlist.json: $(CIRCUIT) | $(INSTALLED) $(ROUTING)
	PYTHONPATH=$(CURDIR) $(BIN)/python -m scripts.board.flow netlist

$(BOARD)/routed.config: $(BOARD)/netlist.json
	PYTHONPATH=$(CURDIR) $(BIN)/python -m scripts.board.flow routed

$(EXTENSION): Cargo.toml Cargo.lock $(shell find rust -path '*/src/*' -o -name Cargo.toml) $(wildcard rtl/*.svh flight/* flight/missions/*) | $(READY)
	cargo build --profile $(PROFILE) --locked -p orbsoc-py --features extension-module
	install target/$(PROFILE)/lib_core.so $@

# Changes only when a source appears or disappears: no file's date tells of a deletion.
$(FILE_LIST): FORCE | $(READY)
	@printf '%s\n' $(SOURCES) | sort | cmp -s - $@ || printf '%s\n' $(SOURCES) | sort > $@

# While the crates compile, pip waits for its downloads: what the wheel needs is installed beside.
$(WHEEL): $(SOURCES) $(FILE_LIST) $(READY)
	@scripts/require_tools.sh $(BIN)/python
	rm -rf dist
	@[ $(RUNTIME) -nt requirements/runtime.txt ] || { $(PIP) install -r requirements/runtime.txt && touch $(RUNTIME); } & \
	scripts/build_wheel.sh $(BIN)/python dist || status=$$?; wait; exit $${status:-0}
	@touch $@

$(INSTALLED): $(WHEEL) $(RUNTIME)
	$(PIP) install --no-deps --force-reinstall dist/orbsoc-*.whl
	@touch $@
