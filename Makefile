# pktrt.h is one header; this file builds and runs the programs beside it. The rules of the web page, the course, the pictures, the
# tests and the benchmarks are in the files that it includes below.
# Lines that begin with `#:` are what `make help` prints; `make help-all` prints those of the included files, too.

CC ?= cc
config ?= release

# A fused multiply-add would change bits. The header forbids them in its own code, the flag in everything else here.
WARNINGS = -Wall -Wextra -Wpedantic -Wshadow -Wconversion
STRICT = -std=c99 -ffp-contract=off $(WARNINGS) $(LOCAL_FLAGS)
CFLAGS ?= $(FLAGS_$(config))
LDLIBS = -lm -lpthread
FLAGS_release = -O2
FLAGS_debug = -O0 -g
# `undefined` does not include float division by zero and overflow of casts; functions that mean them say so. Undefined behaviour
# traps. With VERBOSE=1 the sanitizer prints a sentence instead, and clang takes half as long again.
SANITIZERS = -fsanitize=address,undefined,float-divide-by-zero,float-cast-overflow -fno-sanitize-recover=all \
  -fno-omit-frame-pointer $(if $(VERBOSE),,-fsanitize-undefined-trap-on-error)
# SETS=-DPKTRT_NO_AVX512 leaves an instruction set out, here and in `make fuzz`: the source is the same, the time a third.
FLAGS_sanitize = -O1 -g1 $(SETS) $(SANITIZERS)
# Workers run the same code whatever the width of its vectors.
FLAGS_threads = -O1 -g1 $(THREADS) -DPKTRT_NO_SSE2 -DPKTRT_NO_AVX512
THREADS = -fsanitize=thread
ifeq ($(FLAGS_$(config)),)
$(error config=$(config) is none of: debug, release, sanitize, threads)
endif

# What is built goes to build/, what programs make goes to out/.
B = $(if $(filter release,$(config)),build,build/$(config))
# Measurements are kept here; `make bench-publish` alone moves them to bench/results.
RESULTS = out/results
# Folders that rules need before they run.
FOLDERS = $(B) $(B)/all out

# All instruction sets, and kernels of the fast path that count: tests and benchmarks compare them. What CFLAGS leave out stays out.
ALL_SETS = -DPKTRT_SCALAR -DPKTRT_AVX512 -DPKTRT_COUNT_FAST

# Where nobody may install anything, `make deps-local` puts stb's headers into this folder.
LOCAL = build/local
LOCAL_FLAGS = $(if $(wildcard $(LOCAL)/stb/stb_image_write.h),-isystem $(LOCAL))

# Optional: assimp reads mesh files other than .tri, SDL2 opens the viewer's window, OpenMPI runs a program on many machines, and
# Embree is what benchmarks compare with. (mpirun is not in OpenMPI's pkg-config file; Embree 3 has no such file.)
has = $(shell pkg-config --exists $(1) 2>/dev/null && echo yes)
# The headers of others are nothing to warn about.
system_flags = $(patsubst -I%,-isystem %,$(shell pkg-config --cflags $(1)))
ASSIMP := $(call has,assimp)
ASSIMP_FLAGS := $(if $(ASSIMP),-DHAVE_ASSIMP $(shell pkg-config --cflags assimp))
ASSIMP_LIBS := $(if $(ASSIMP),$(shell pkg-config --libs assimp))
SDL := $(call has,sdl2)
SDL_FLAGS := $(if $(SDL),$(call system_flags,sdl2))
SDL_LIBS := $(if $(SDL),$(shell pkg-config --libs sdl2))
MPI := $(if $(shell command -v mpirun 2>/dev/null),$(call has,ompi-c))
MPI_FLAGS := $(if $(MPI),$(call system_flags,ompi-c))
MPI_LIBS := $(if $(MPI),$(shell pkg-config --libs ompi-c))
EMBREE := $(wildcard /usr/include/embree3/rtcore.h /usr/local/include/embree3/rtcore.h)

# Goals in a row, as in `make deps demo`, are made one after the other; what a goal is built from, side by side.
JOBS ?= $(shell nproc 2>/dev/null || echo 1)
BUILD = @$(MAKE) --no-print-directory -j$(JOBS)
ifeq ($(MAKELEVEL),0)
.NOTPARALLEL:
endif
.DELETE_ON_ERROR:

#: deps              installs what demo and test need, on Debian 12; deps-extra installs the rest;
#:                   without root, deps-local puts stb_image_write into build/local
#: demo              makes nine pictures in out/: three scenes, in three modes each
#: test              runs all tests; ONLY="words" picks tests by their sentences
#: all               builds the examples and the tests; examples/README.md shows what each example does
.PHONY: all help help-all
all:
	$(BUILD) $(EXAMPLES) $(B)/test
	@$(if $(SDL),:,echo "all: without SDL2 the viewer is not built (make deps-extra installs it)")
	@$(if $(MPI),:,echo "all: without OpenMPI the program for many machines is not built (make deps-extra installs it)")

help:
	@sed -n 's/^#: \{0,1\}//p' Makefile

help-all: help
	@sed -n 's/^#: \{0,1\}//p' examples/examples.mk tests/tests.mk bench/bench.mk

# --- examples ---

PLAIN_EXAMPLES = $(addprefix $(B)/,hello spinner cornell query packets pick lightmap instances changes distance effects deform model)
EXAMPLES = $(PLAIN_EXAMPLES) $(addprefix $(B)/,render $(if $(SDL),view) $(if $(MPI),mpi))
EXAMPLE_HEADERS = $(wildcard examples/*.h)

# Each example is a program by itself, as `cc -O2 examples/hello.c -lm` shows. Here they share one implementation, which takes nearly
# all of the time to compile: with these defines an example does not compile its own.
SHARED = -DPK_IMPLEMENTED -DPK_ENTRY_POINTS
$(B)/pktrt.o: pktrt.h | $(B)
	$(CC) $(CFLAGS) $(STRICT) -DPKTRT_IMPLEMENTATION -x c -c $< -o $@

# The implementation with all instruction sets, and the programs that compare these, are in a folder of their own.
$(B)/all/pktrt.o: pktrt.h | $(B)/all
	$(CC) $(CFLAGS) $(ALL_SETS) $(STRICT) -DPKTRT_IMPLEMENTATION -x c -c $< -o $@

# Compiles a program of one file, and links it with the objects that it depends on.
PROGRAM = $(CC) $(CFLAGS) $(STRICT) $(SHARED) $< $(filter %.o,$^) -o $@ $(LDFLAGS) $(LDLIBS)

$(B)/render $(B)/all/render: examples/render.c $(EXAMPLE_HEADERS)
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) $(ASSIMP_FLAGS) $< $(@D)/pktrt.o -o $@ $(LDFLAGS) $(ASSIMP_LIBS) $(LDLIBS)
	@$(if $(ASSIMP),:,echo "render: built without assimp; it reads .tri meshes only (make deps-extra installs assimp)")

$(B)/view: examples/view.c $(EXAMPLE_HEADERS) $(B)/pktrt.o
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) $(SDL_FLAGS) $(ASSIMP_FLAGS) $< $(B)/pktrt.o -o $@ $(LDFLAGS) $(SDL_LIBS) $(ASSIMP_LIBS) $(LDLIBS)

$(B)/mpi $(B)/all/mpi: examples/mpi.c examples/render.c $(EXAMPLE_HEADERS)
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) $(ASSIMP_FLAGS) $(MPI_FLAGS) $< $(@D)/pktrt.o -o $@ $(LDFLAGS) $(MPI_LIBS) $(ASSIMP_LIBS) $(LDLIBS)

$(B)/render $(B)/mpi: $(B)/pktrt.o
$(B)/all/render $(B)/all/mpi: $(B)/all/pktrt.o

$(addprefix $(B)/,spinner cornell pick lightmap instances changes distance effects deform model): $(EXAMPLE_HEADERS)

$(PLAIN_EXAMPLES): $(B)/%: examples/%.c $(B)/pktrt.o
	$(PROGRAM)

SCENES = poolhall conference rtrt
PICTURE = picture() { echo "$(B)/render $$*"; $(B)/render "$$@"; echo; }
# The curve keeps what is brighter than white.
LOOK = --tone curve --exposure 1.5
.PHONY: demo effects deform model view mpi
# One fine picture first, so that there is something to see within a minute.
demo: | out
	@mkdir -p $(B); date +%s >$(B)/demo.begun
	$(BUILD) $(B)/render
	@set -e; $(PICTURE); first=poolhall; \
	  picture --scene $$first --mode drt --spp 32 --lights one --size 512x512 $(LOOK) -o out/$$first-drt.png; \
	  took=$$(($$(date +%s) - $$(cat $(B)/demo.begun))); \
	  echo "demo: the first picture is out/$$first-drt.png, $$took s after the start; eight more follow"; echo; \
	  for scene in $(SCENES); do \
	    picture --scene $$scene --mode rcs --spp 16 --size 512x512 $(LOOK) -o out/$$scene-rcs.png; \
	    picture --scene $$scene --mode wrt --spp 16 --size 512x512 $(LOOK) -o out/$$scene-wrt.png; \
	    [ $$scene = $$first ] || \
	      picture --scene $$scene --mode drt --spp 64 --lights one --size 512x512 $(LOOK) -o out/$$scene-drt.png; \
	  done

#: effects           makes out/effects-*.png: depth of field, motion blur, soft shadows, gloss
effects: | out
	$(BUILD) $(B)/effects
	$(B)/effects

#: deform            makes the frames out/deform-*.png; ARGS="--frames 3 --size 96x64"
deform: | out
	$(BUILD) $(B)/deform
	$(B)/deform $(ARGS)

#: model             makes build/model.glb, a still life, by examples/model.c, and draws out/model.png
MODEL_SPP = 64
model: | out
	$(BUILD) $(B)/model $(B)/render
	$(B)/model $(B)/model.glb
ifeq ($(ASSIMP),)
	@echo "model: $(B)/model.glb is made; assimp, which reads it, is not installed (make deps-extra), so there is no picture"
else
	$(B)/render --mesh $(B)/model.glb --mode drt --spp $(MODEL_SPP) --size 512x512 -o out/model.png
endif

#: view              looks around in a scene or file: ARGS=model.glb, ARGS="--scene rtrt", ARGS=--help
view:
ifeq ($(SDL),)
	@echo "view: SDL2 is not installed (make deps-extra installs libsdl2-dev), there is no window"; exit 1
else
	$(BUILD) $(B)/view
	$(B)/view $(ARGS)
endif

#: mpi               builds build/mpi, which renders on many machines: mpirun -n 8 build/mpi --help
mpi:
ifeq ($(MPI),)
	@echo "mpi: OpenMPI is not installed (make deps-extra installs libopenmpi-dev and openmpi-bin), there is no program for many machines"; exit 1
else
	$(BUILD) $(B)/mpi
endif

#: web               makes the page out/web, to look around in a browser; web-serve shows it
#: course            runs the programs of the course; N=2: of chapter 2. See examples/course/README.md
#: course-check      N=2 FILE=mine_02.c tells whether the file solves the exercise of chapter 2
#: bench             measures the results of the paper; NAME="table1 figure6": some of them
include examples/examples.mk tests/tests.mk bench/bench.mk

# --- installing ---

#: install           copies the header, with files for pkg-config and CMake: PREFIX=/usr/local DESTDIR=
#: uninstall         removes these files
# Nothing is compiled. The files for pkg-config and CMake find the header from their own place, so the folder may be moved.
PREFIX ?= /usr/local
VERSION = $(shell awk '$$2 == "PKTRT_VERSION" { printf "%d.%d.%d", $$3 / 10000, $$3 / 100 % 100, $$3 % 100; exit }' pktrt.h)
quoted = '$(subst ','\'',$(1))'
INSTALLED_HEADER = $(call quoted,$(DESTDIR)$(PREFIX)/include/pktrt.h)
INSTALLED_PC = $(call quoted,$(DESTDIR)$(PREFIX)/share/pkgconfig/pktrt.pc)
INSTALLED_CMAKE = $(call quoted,$(DESTDIR)$(PREFIX)/lib/cmake/pktrt)
CMAKE_FILES = pktrtConfig.cmake pktrtConfigVersion.cmake
.PHONY: install uninstall deps deps-extra deps-web clean
install:
	umask 022; install -d $(call quoted,$(DESTDIR)$(PREFIX)/include) $(call quoted,$(DESTDIR)$(PREFIX)/share/pkgconfig) $(INSTALLED_CMAKE)
	install -m 644 pktrt.h $(INSTALLED_HEADER)
	install -m 644 $(addprefix examples/cmake/,$(CMAKE_FILES)) $(INSTALLED_CMAKE)
	@rm -f $(INSTALLED_PC)
	umask 022; printf '%s\n' 'prefix=$${pcfiledir}/../..' 'includedir=$${prefix}/include' '' 'Name: pktrt' \
	  'Description: packet ray tracing in one C header' 'Version: $(VERSION)' 'Cflags: -I$${includedir}' 'Libs: -lm' \
	  >$(INSTALLED_PC)

# Folders stay, since somebody else may have made them. The folder of pktrt's files for CMake goes if it is empty.
uninstall:
	rm -f $(INSTALLED_HEADER) $(INSTALLED_PC) $(addprefix $(INSTALLED_CMAKE)/,$(CMAKE_FILES))
	@rmdir $(INSTALLED_CMAKE) 2>/dev/null || :

# What to install, on Debian 12 and its relatives.
DEPS = gcc g++ libc6-dev libstb-dev
DEPS_EXTRA = pkg-config glpk-utils libassimp-dev libembree-dev clang clang-format libclang-rt-14-dev lld tcc gcc-mingw-w64-x86-64 \
  clang-tools universal-ctags cmake git aspell aspell-en \
  g++-mingw-w64-x86-64 gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user gnuplot valgrind libsdl2-dev xvfb xdotool \
  gcc-i686-linux-gnu libc6-dev-i386-cross gcc-riscv64-linux-gnu libc6-dev-riscv64-cross gcc-s390x-linux-gnu \
  libc6-dev-s390x-cross musl-tools wine64 emscripten nodejs \
  python3-cffi python3-numpy python3-matplotlib python3-pip python3-setuptools python3-wheel libopenmpi-dev openmpi-bin
INSTALL = $(if $(filter 0,$(shell id -u)),,sudo) env DEBIAN_FRONTEND=noninteractive apt-get

deps:
	@echo "Installing what the demo and the tests need: $(DEPS)"
	$(INSTALL) -q update
	$(INSTALL) -q install -y --no-install-recommends $(DEPS)

deps-extra:
	@echo "Installing what the optional parts need: $(DEPS_EXTRA)"
	$(INSTALL) -q update
	$(INSTALL) -q install -y --no-install-recommends $(DEPS_EXTRA)

# Chromium and npm are large, so deps-extra leaves them out. A nodejs that is not Debian's brings its own npm, and conflicts with
# Debian's.
deps-web: deps-extra
	$(INSTALL) -q install -y --no-install-recommends chromium $$(command -v npm >/dev/null || echo npm)

#: clean             removes build/ and out/, with measurements that are not published
clean:
	rm -rf build out

#: help-all          lists the other tests, checks, pictures and measurements, too
#: config=release    or debug, sanitize, threads, each in its own folder; also CC=clang, B=FOLDER
$(sort $(FOLDERS)):
	mkdir -p $@
