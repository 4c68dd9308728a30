# cross.mk: libgpiod's sources, cross builds for ARM, Debian packages; included by the Makefile.
# Uses BIN, STAMPS, CMAKE, SUDO of the Makefile. GONIO_GPIOD=DIRECTORY takes other sources of libgpiod 2.
GPIOD := build/deps/gpiod
GONIO_GPIOD ?= $(CURDIR)/$(GPIOD)
CROSS := build/cross
DIST := build/dist
DIST_ARCHES := amd64 arm64 armhf
# Toolchains only: the ARM libraries are unpacked below build/cross, the machine's own packages stay as they are.
DIST_PACKAGES := gcc-aarch64-linux-gnu g++-aarch64-linux-gnu gcc-arm-linux-gnueabihf g++-arm-linux-gnueabihf qemu-user-static xz-utils dpkg-dev pkg-config \
  libusb-1.0-0-dev
export SOURCE_DATE_EPOCH ?= $(or $(shell git log -1 --format=%ct 2>/dev/null),1700000000)
# Other compilers and fortified functions warn of other things; for those `make test` has its own build.
DIST_FLAGS := -Wno-error=format-truncation -fstack-protector-strong -D_FORTIFY_SOURCE=2 -ffile-prefix-map=$(CURDIR)=. -Wl,-z,relro,-z,now
DIST_CMAKE = $(CMAKE) -S . -DGONIO_EMBREE=OFF -DGONIO_GPIOD_SOURCE=$(GONIO_GPIOD) -DCMAKE_C_FLAGS="$(DIST_FLAGS)" -DCMAKE_CXX_FLAGS="$(DIST_FLAGS)"

.PHONY: cross dist
cross: $(CROSS)/arm64/.built $(CROSS)/armhf/.built ## goniod for ARM boards, and gonio-l1 (the twin without photon map) for arm64 (build/cross)

dist: $(foreach arch,$(DIST_ARCHES),$(CROSS)/$(arch)/.built) ## Debian packages of goniod for x86-64, arm64 and armhf, with their source (build/dist)
	@packaging/deb.sh amd64 $(CROSS)/amd64/build strip $(DIST)
	@packaging/deb.sh arm64 $(CROSS)/arm64/build aarch64-linux-gnu-strip $(DIST)
	@packaging/deb.sh armhf $(CROSS)/armhf/build arm-linux-gnueabihf-strip $(DIST)
	@packaging/source.sh $(GONIO_GPIOD) $(DIST)

# Old libgpiod numbers no events; the sources are wanted wherever the system has none of version 2, and for ARM in any case.
$(GPIOD)/.unpacked: packaging/gpiod.txt | .venv/.installed
	@rm -rf $(GPIOD).new build/deps/download && mkdir -p $(GPIOD).new
	@$(BIN)/pip download -q --disable-pip-version-check --no-binary gpiod --no-deps --no-build-isolation --require-hashes -d build/deps/download -r packaging/gpiod.txt
	@tar -xzf build/deps/download/gpiod-*.tar.gz -C $(GPIOD).new --strip-components=1
	@rm -rf $(GPIOD) && mv $(GPIOD).new $(GPIOD)
	@touch $@

BUILT := $(DIST_ARCHES:%=$(CROSS)/%/.built)
SYSROOTS := $(CROSS)/arm64/.sysroot $(CROSS)/armhf/.sysroot
$(SYSROOTS): $(CROSS)/%/.sysroot: packaging/cross/sysroot.sh | $(STAMPS)/apt-dist
	@mkdir -p $(CROSS)/$*
	@packaging/cross/sysroot.sh $* $(CROSS)/$*/sysroot
	@rm -rf $(CROSS)/$*/build
	@touch $@

# The machine's own architecture goes the same way, with the same flags. CMake and Ninja know what is to be done; they are asked each time.
$(CROSS)/arm64/.built $(CROSS)/armhf/.built: $(CROSS)/%/.built: $(CROSS)/%/.sysroot
$(BUILT): $(CROSS)/%/.built: .FORCE | $(GPIOD)/.unpacked $(STAMPS)/apt-build $(STAMPS)/apt-dist .venv/.installed
	@$(DIST_CMAKE) -B $(CROSS)/$*/build $(if $(filter-out amd64,$*),-DCMAKE_TOOLCHAIN_FILE=packaging/cross/$*.cmake) > /dev/null
	@ninja -C $(CROSS)/$*/build --quiet goniod $(if $(filter arm64,$*),gonio-l1)
	@touch $@
.PHONY: .FORCE
.FORCE:

$(STAMPS)/apt-dist: PACKAGES := $(DIST_PACKAGES)
