# Makefile: everything from a clean clone: `make demo`, `make test`; `make help` lists the rest. Each set-up step runs once.
SHELL := /bin/bash
.SHELLFLAGS := -eu -o pipefail -c
.DEFAULT_GOAL := help
MAKEFLAGS += --no-print-directory

PYTHON ?= python3
SUDO := $(shell [ "$$(id -u)" = 0 ] || echo sudo)
CLANG := 14
BIN := .venv/bin
GONIO := $(BIN)/gonio
DEMO := build/demo
STAMPS := build/.stamps
CMAKE := cmake -G Ninja $(if $(shell command -v ccache),-DCMAKE_C_COMPILER_LAUNCHER=ccache -DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
FUZZ := PYTHON=$(BIN)/python firmware/fuzz/run.sh build/fuzz/logs
JOBS := 2
CORE := base motion canopen stream

BUILD_PACKAGES := build-essential cmake ninja-build python3 python3-dev python3-venv nanopb libnanopb-dev libtomlplusplus-dev libgtest-dev libembree-dev libusb-1.0-0-dev pkg-config
CHECK_PACKAGES := clang-$(CLANG) clang-tidy-$(CLANG) clang-format-$(CLANG) clang-tools-$(CLANG) libclang-rt-$(CLANG)-dev
# The virtual machine: its kernel is built from Debian's source (once, kept in the user's cache), the rest is QEMU and an independent CAN logger.
HIL_PACKAGES := qemu-system-x86 busybox-static can-utils iproute2 linux-source-6.1 flex bison bc libelf-dev libssl-dev xz-utils kmod cpio
SCHEMA := protocol/gonio.proto protocol/gonio.options protocol/records.toml protocol/generate.py
GENERATED := host/gonio/protocol/generated
include packaging/cross.mk
C_FILES = $(shell git ls-files -co --exclude-standard 'firmware/*.c' 'firmware/*.h' 'firmware/*.cpp' 'sim/*.cpp' 'sim/*.hpp' 'host/native/*.cpp' 'host/native/*.hpp')

.PHONY: help setup build demo check test test-native test-sanitize test-fuzz test-host hil bench bench-sim bench-models figures coverage soak clean

help: ## this list
	@grep -hE '^[a-z-]+:.*## ' $(MAKEFILE_LIST) | sed -E 's/^([a-z-]+):.*## /  make \1\t/' | expand -t 20

setup: $(STAMPS)/apt-build .venv/.installed $(GENERATED)/.stamp $(GPIOD)/.unpacked ## system packages, virtual environment, generated code

build: setup build/native/build.ninja ## goniod and twin
	@ninja -C build/native --quiet goniod gonio-twin gonio-twin-bench gonio-twin-devices gonio-bench-host gonio-bench-sampler _photons _sphere _model

demo: build ## measure a simulated sample from end to end; results in build/demo
	@docs/examples/demo.sh $(DEMO)

check: build $(STAMPS)/apt-check ## formatting, static analysis, types, layers
	@clang-format-$(CLANG) --dry-run -Werror $(C_FILES)
	run-clang-tidy-$(CLANG) -quiet -j $(JOBS) -p build/native '/(firmware/core|firmware/port|firmware/app|host/native|sim/devices|sim/optics|sim/python|sim/real|sim/twin)/' > build/clang-tidy.log 2>&1 \
	  || { grep -E 'warning:|error:' build/clang-tidy.log | sort -u; exit 1; }
	$(BIN)/ruff check --config host/pyproject.toml host protocol
	$(BIN)/ruff check hil-tests
	$(BIN)/ruff format --check --config host/pyproject.toml host protocol hil-tests
	cd host && ../$(BIN)/mypy gonio
	cd hil-tests && MYPYPATH=.:../host ../$(BIN)/mypy --config-file ../host/pyproject.toml --explicit-package-bases .
	cd host && ../$(BIN)/lint-imports --no-cache

test: test-native test-sanitize test-fuzz test-host hil ## all tests: sanitizer build, short fuzzing, ARM builds and the virtual machine included

test-native: build
	@ninja -C build/native --quiet
	ctest --test-dir build/native --output-on-failure

test-sanitize: setup build/sanitize/build.ninja
	@ninja -C build/sanitize --quiet
	ctest --test-dir build/sanitize --output-on-failure

test-fuzz: setup $(STAMPS)/apt-check build/fuzz/build.ninja
	@ninja -C build/fuzz --quiet fuzzers
	@$(FUZZ) -seed=1 -runs=30000 -- build/fuzz/firmware/fuzz_*
	@$(FUZZ) -seed=1 -runs=3000 -- host/fuzz/fuzz_*.py

test-host: build dist
	cd host && ../$(BIN)/pytest -n $(JOBS)

hil: build $(STAMPS)/apt-hil ## goniod on real CAN, GPIO and USB interfaces in a virtual machine; its kernel takes ten minutes, once
	@cd hil-tests && { ../$(BIN)/pytest || { echo "hil: what failed has one more boot: an emulation that stood still says nothing"; ../$(BIN)/pytest --last-failed --last-failed-no-failures none; }; }

bench: build ## the hot loops beside their peers; tables and build/bench/*.json
	$(BIN)/python host/benchmarks/bench.py build/bench

bench-sim: build ## the photon map beside Radiance's; a table and build/bench/bench_sim.json
	$(BIN)/python host/benchmarks/bench_sim.py build/bench

bench-models: build ## models and simulation files beside Radiance's chain; a table and build/bench/bench_models.json
	cd host && ../$(BIN)/python -m benchmarks.models.bench_models ../build/bench

figures: build ## accuracy of a whole scan against the twin's truth
	cd host && ../$(BIN)/python -m benchmarks.figures

coverage: setup build/coverage/build.ninja ## line coverage of the firmware core by its unit tests
	@find build/coverage -name '*.gcda' -delete
	@ninja -C build/coverage --quiet $(CORE:%=test_firmware_%)
	ctest --test-dir build/coverage --output-on-failure -R '^firmware_'
	$(BIN)/gcovr --root . --filter firmware/core build/coverage

soak: build $(STAMPS)/apt-check $(STAMPS)/apt-hil build/fuzz/build.ninja ## uncertainties of repeated scans, 100 scans in the virtual machine (half an hour), ten minutes of fuzzing per target
	$(BIN)/python host/tests/uncertainty/soak_whole_chain.py --repeats 12
	cd hil-tests && ../$(BIN)/pytest soak
	@ninja -C build/fuzz --quiet fuzzers
	@$(FUZZ) -max_total_time=600 -- build/fuzz/firmware/fuzz_* host/fuzz/fuzz_*.py

clean: ## remove what was built (the virtual environment stays)
	rm -rf build $(GENERATED) host/gonio/simulate/_photons*.so host/gonio/geometry/_sphere*.so host/gonio/model/_model*.so

$(STAMPS)/apt-build: PACKAGES := $(BUILD_PACKAGES)
$(STAMPS)/apt-check: PACKAGES := $(CHECK_PACKAGES)
$(STAMPS)/apt-%:
	@mkdir -p $(STAMPS)
	@dpkg-query -W -f '$${db:Status-Status}\n' $(PACKAGES) 2>/dev/null | grep -cx installed | grep -qx $(words $(PACKAGES)) || { \
	  $(SUDO) apt-get update -qq && $(SUDO) env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $(PACKAGES); }
	@touch $@
$(STAMPS)/apt-hil: PACKAGES := $(HIL_PACKAGES)

.venv/.installed: requirements.txt host/pyproject.toml | $(STAMPS)/apt-build
	$(PYTHON) -m venv .venv
	$(BIN)/pip install -q --disable-pip-version-check -r requirements.txt
	$(BIN)/pip install -q --disable-pip-version-check --no-deps --no-build-isolation -e host
	@touch $@

$(GENERATED)/.stamp: $(SCHEMA) .venv/.installed
	@mkdir -p $(GENERATED)
	@$(BIN)/python protocol/generate.py --python $(GENERATED)/records.py
	@$(BIN)/python -m grpc_tools.protoc -Iprotocol --python_out=$(GENERATED) --pyi_out=$(GENERATED) gonio.proto
	@echo '"""Generated from protocol/ at build time."""' > $(GENERATED)/__init__.py
	@touch $@

build/native/build.ninja: CMakeLists.txt | $(STAMPS)/apt-build .venv/.installed $(GPIOD)/.unpacked
	@$(CMAKE) -S . -B build/native > /dev/null
build/sanitize/build.ninja: CMakeLists.txt | $(STAMPS)/apt-build $(GPIOD)/.unpacked
	@$(CMAKE) -S . -B build/sanitize -DCMAKE_BUILD_TYPE=Debug -DGONIO_SANITIZE=ON > /dev/null
build/coverage/build.ninja: CMakeLists.txt | $(STAMPS)/apt-build
	@$(CMAKE) -S . -B build/coverage -DCMAKE_BUILD_TYPE=Debug -DGONIO_EMBREE=OFF -DGONIO_LINUX=OFF -DCMAKE_C_FLAGS=--coverage -DCMAKE_CXX_FLAGS=--coverage > /dev/null
build/fuzz/build.ninja: CMakeLists.txt | $(STAMPS)/apt-build $(STAMPS)/apt-check $(GPIOD)/.unpacked
	@CC=clang-$(CLANG) CXX=clang++-$(CLANG) $(CMAKE) -S . -B build/fuzz -DGONIO_EMBREE=OFF -DGONIO_SANITIZE=ON -DGONIO_FUZZ=ON > /dev/null
