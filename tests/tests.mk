# The tests, the checks of the text, fuzzing, and the release. Included by the Makefile.

#:
#: --- tests ---
.PHONY: test test-leaveout mutants test-view test-image test-mesh-file test-mpi test-python python-picture sanitize test-threads
.PHONY: sanitize-threads stability stability-neon stability-sanitize test-neon test-wasm fuzz matrix platforms checksum checksums
.PHONY: flags test-guards test-install test-dist
.PHONY: map structure spell targets format format-check dist
FOLDERS += $(B)/tests/fuzz $(B)/python build/fuzz

# $(call needs,PROGRAM...): ends a recipe, with a sentence, where one of the programs is not installed.
needs = for program in $(1); do command -v $$program >/dev/null || { \
  echo "$@: $$program is not installed (make deps-extra)"; exit 1; }; done

# Programs of their own: checksum.c and stack.c, see `platforms`; mesh_file.c and image.c, see `test-mesh-file`.
TEST_SOURCES = $(sort $(filter-out $(addprefix tests/,fuzz/main.c checksum.c stack.c mesh_file.c image.c), \
  $(wildcard tests/*.c tests/fuzz/*.c)))
TEST_OBJECTS = $(TEST_SOURCES:tests/%.c=$(B)/tests/%.o)

$(B)/tests/%.o: tests/%.c $(wildcard tests/*.h tests/fuzz/*.h) bench/provenance.h $(EXAMPLE_HEADERS) pktrt.h | $(B)/tests/fuzz
	$(CC) $(CFLAGS) $(ALL_SETS) $(STRICT) -c $< -o $@

$(B)/test: $(TEST_OBJECTS)
	$(CC) $(CFLAGS) $^ -o $@ $(LDFLAGS) $(LDLIBS)

test:
	$(BUILD) $(B)/test $(B)/render $(if $(ONLY),,$(B)/checksum)
	$(B)/test --jobs $(JOBS) $(ONLY)
	$(if $(ONLY),,$(B)/checksum | sed '/^by /d' | diff tests/checksum.txt - && echo "checksum: answers and pictures have the bits that are kept")
	$(if $(ONLY),,tests/render.sh $(B)/render)

#: test-leaveout     tests the PKTRT_NO_... switches, each alone and all together
test-leaveout:
	tests/leaveout.sh

# Plants single faults, one at a time, and tells which of them the tests notice; a run that was ended goes on. COUNT=, SEED=, HOURS=,
# ROOMS="..." and what they mean: tests/mutants.sh.
#: mutants           counts how many of 400 faults planted in the header the tests notice, in 3 hours
mutants:
	CC="$(CC)" JOBS=$(JOBS) tests/mutants.sh $(ARGS)

#: test-view         drives the viewer under Xvfb and looks at the screen
test-view:
ifeq ($(SDL),)
	@echo "test-view: SDL2 is not installed (make deps-extra installs libsdl2-dev), there is no viewer"; exit 1
else
	$(BUILD) $(B)/view $(B)/render $(B)/screenshot
	tests/view.sh $(B)
endif

# Pictures, without a sanitizer, with AddressSanitizer, and without stb_image.
#: test-image        tests pictures as textures and environments, also without stb_image
test-image:
	$(BUILD) $(B)/pktrt.o
	mkdir -p $(B)/image
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) tests/image.c $(B)/pktrt.o -o $(B)/image/plain $(LDFLAGS) $(LDLIBS)
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) -fsanitize=address tests/image.c $(B)/pktrt.o -o $(B)/image/asan $(LDFLAGS) $(LDLIBS)
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) -DIMAGE_NO_STB tests/image.c $(B)/pktrt.o -o $(B)/image/without $(LDFLAGS) $(LDLIBS)
	cd $(B)/image && ./plain && ./asan && ./without

#: test-mesh-file    does the same, then tests mesh files that assimp reads: edges, hostile sizes
test-mesh-file: test-image
ifeq ($(ASSIMP),)
	@echo "test-mesh-file: assimp is not installed (make deps-extra installs libassimp-dev), nothing is tested"
else
	$(BUILD) $(B)/pktrt.o
	mkdir -p $(B)/mesh_file
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) $(ASSIMP_FLAGS) tests/mesh_file.c $(B)/pktrt.o -o $(B)/mesh_file/plain $(LDFLAGS) $(ASSIMP_LIBS) $(LDLIBS)
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) $(ASSIMP_FLAGS) -fsanitize=address tests/mesh_file.c $(B)/pktrt.o -o $(B)/mesh_file/asan $(LDFLAGS) $(ASSIMP_LIBS) $(LDLIBS)
	cd $(B)/mesh_file && ./plain && ./asan
endif

#: test-mpi          compares 4 and 7 ranks on this machine with render; ranks die, runs are resumed
test-mpi:
ifeq ($(MPI),)
	@echo "test-mpi: OpenMPI is not installed (make deps-extra installs libopenmpi-dev and openmpi-bin), nothing is tested"
else
	$(BUILD) $(B)/all/mpi $(B)/all/render
	tests/mpi.sh $(B)/all
endif

$(B)/screenshot: tests/view/screenshot.c examples/common.h | $(B)
	$(CC) $(CFLAGS) $(STRICT) $< -o $@ $(LDFLAGS) $(LDLIBS)

# Python by cffi and numpy: the same bits as C, no copies, the library's sentences. The library that Python loads is compiled into
# build/python, once for each header, compiler and CFLAGS.
PYTHON = $(firstword $(foreach python,python3 /usr/bin/python3,$(shell $(python) -c 'import cffi, numpy' 2>/dev/null && echo $(python))))
PYTHON_RUN = CC="$(CC)" CFLAGS="$(CFLAGS) $(ALL_SETS)" PKTRT_CACHE=$(B)/python $(PYTHON) tests/python/test.py $(B)
#: test-python       compares examples/python/pktrt.py with C: the same bits, no copies; tries pip
test-python:
	@if [ -n "$(PYTHON)" ]; then $(MAKE) --no-print-directory -j$(JOBS) $(B)/render $(B)/python/answers $(B)/python/notebook $(B)/python/scene.so && $(PYTHON_RUN); \
	  else echo "test-python: there is no python3 with cffi and numpy (make deps-extra), nothing is compared"; fi

#: python-picture    prints the checksum of a picture made from Python: PICTURE="poolhall wrt 64 48"
python-picture:
	@if [ -n "$(PYTHON)" ]; then $(MAKE) -s $(B)/python/scene.so && $(PYTHON_RUN) --picture $(PICTURE); \
	  else echo "python-picture: there is no python3 with cffi and numpy (make deps-extra)" >&2; fi

$(B)/python/answers $(B)/python/notebook: $(B)/python/%: tests/python/%.c tests/python/arrays.h $(B)/all/pktrt.o | $(B)/python
	$(PROGRAM)

$(B)/python/scene.so: tests/python/scene.c $(EXAMPLE_HEADERS) pktrt.h | $(B)/python
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) -fPIC -shared $< -o $@ $(LDFLAGS) -lm

# The smaller set: the same tests with fewer rays. ONLY="words" picks tests by their sentences. clang, where there is one, sees
# more kinds of undefined behaviour than gcc.
SANITIZE_CC ?= $(if $(shell command -v clang 2>/dev/null),clang,$(CC))
#: sanitize          runs a smaller set of tests under ASan and UBSan
sanitize:
	$(BUILD) CC=$(SANITIZE_CC) config=sanitize build/sanitize/test
	build/sanitize/test --small $(ONLY)

# A copy of the library with less slack, which is for controls only.
build/sanitize/tests/noslack.o: SANITIZERS =
build/threads/tests/noslack.o: THREADS = -O0

#: test-threads      tests examples/threads.h by pthreads, under TSan, and by Win32 (MinGW, wine)
test-threads: | $(B)
	CC="$(CC)" tests/threads/threads.sh $(B)

#: sanitize-threads  tests what several threads do at once, under TSan
sanitize-threads:
	$(BUILD) CC=$(SANITIZE_CC) config=threads build/threads/test
	build/threads/test --small $(or $(ONLY),workers threads "settings of a thread" "a moving scene's picture" "DRT picture has the same" "no after the last")

# The cases of tests/stability_*.c as long as they get; their figures go to $(RESULTS). Elsewhere: a tenth on ARM, emulated, a
# hundredth under sanitizers. Most of the time is that of the scalar kernels, hence the flag.
#: stability         tests the extremes at length, in hours; figures go to out/results
#: stability-neon    tests a tenth of them on ARM, emulated; stability-sanitize a hundredth under ASan
stability: | $(RESULTS)
	$(BUILD) B=build/stability CFLAGS="$(CFLAGS) -DPK_INLINE_SCALAR" build/stability/test
	build/stability/test --thorough 1 --results $(RESULTS) stable
	$(TABLES)

# Without the scalar kernels, which `platforms` compares on ARM.
ARM_CC = aarch64-linux-gnu-gcc
#: test-neon         runs a smaller set of tests on ARM, emulated
test-neon stability-neon:
	@$(call needs,$(ARM_CC) qemu-aarch64)
	$(BUILD) CC=$(ARM_CC) CFLAGS="-O2 -DPKTRT_NO_SCALAR" LDFLAGS=-static config=release B=build/neon build/neon/test
	qemu-aarch64 build/neon/test --small $(if $(filter stability-neon,$@),--thorough 0.1 --results build/neon stable,$(ONLY))

# WebAssembly in node, by its vectors or, with SIMD= on the command line, by scalar code. Node has no fork, hence one process, and
# threads are none without workers: parallel_for runs what it is given in turn. One test says that it is skipped, that of rounding.
SIMD = -msimd128 -DPKTRT_NO_SCALAR
WASM_TESTS = build/wasm-tests$(if $(SIMD),,-scalar)
WASM_LINK = -s SINGLE_FILE=1 -s NODERAWFS=1 -s EXIT_RUNTIME=1 -s ALLOW_MEMORY_GROWTH=1 -s MAXIMUM_MEMORY=4GB \
  -s TOTAL_MEMORY=64MB -s TOTAL_STACK=8MB
#: test-wasm         runs a smaller set in node, by WebAssembly's vectors; SIMD= by its scalar code
test-wasm: export NODE_PATH := /usr/share/nodejs$(if $(NODE_PATH),:$(NODE_PATH))
test-wasm:
	@$(call needs,emcc node)
	$(BUILD) CC=emcc CFLAGS="-O1 $(SIMD) -idirafter /usr/include" LDFLAGS="$(WASM_LINK)" config=release B=$(WASM_TESTS) \
	  $(WASM_TESTS)/test
	node $(WASM_TESTS)/test --small $(ONLY)

stability-sanitize:
	$(BUILD) CC=$(SANITIZE_CC) config=sanitize build/sanitize/test
	build/sanitize/test --small --thorough 0.01 --results build/sanitize stable

# --- fuzzing: libFuzzer comes with clang ---

# Each target for TIME seconds, from the inputs kept in tests/fuzz/corpus; what it finds interesting goes to build/fuzz, and so
# does an input that crashes. TARGETS="scene" picks some. `make test` replays the kept ones. KEEP=1 keeps how
# many inputs were tried, for bench/README.md.
TIME = 600
TARGETS = scene query settings mesh_file
FUZZ_FLAGS = -O1 -g1 $(ALL_SETS) $(SETS) -fsanitize=fuzzer-no-link $(SANITIZERS)
FUZZ_OBJECTS = $(addprefix build/fuzz/,fuzz.o reference.o oracle.o pktrt.o)
#: fuzz              fuzzes for TIME=600 seconds each of TARGETS="scene query settings mesh_file";
#:                   KEEP=1 keeps the numbers of inputs in out/results
fuzz: | $(if $(KEEP),$(RESULTS))
	@$(call needs,clang)
	$(BUILD) $(TARGETS:%=build/fuzz/%) $(if $(KEEP),$(B)/provenance)
	@set -e; for target in $(TARGETS); do \
	  echo "$$target, $(TIME) s"; mkdir -p build/fuzz/found/$$target; \
	  build/fuzz/$$target -max_total_time=$(TIME) -max_len=1024 -timeout=10 -rss_limit_mb=1024 -print_final_stats=1 \
	    -artifact_prefix=build/fuzz/$$target- build/fuzz/found/$$target tests/fuzz/corpus/$$target >build/fuzz/$$target.txt 2>&1 || \
	    { tail -40 build/fuzz/$$target.txt; exit 1; }; \
	  grep -E 'cov:|number_of_executed' build/fuzz/$$target.txt | tail -2; \
	done
ifneq ($(KEEP),)
	@{ $(B)/provenance make fuzz TIME=$(TIME); echo target,seconds,inputs; for target in $(TARGETS); do \
	  echo "$$target,$(TIME),$$(awk '/number_of_executed_units/ { print $$2 }' build/fuzz/$$target.txt)"; done; } >$(RESULTS)/fuzz.csv
	$(TABLES)
endif

$(TARGETS:%=build/fuzz/%): build/fuzz/%: tests/fuzz/main.c build/fuzz/%.o $(FUZZ_OBJECTS)
	clang $(FUZZ_FLAGS) -fsanitize=fuzzer $(STRICT) -DTARGET=fuzz_$* $^ -o $@ $(LDLIBS)

build/fuzz/%.o: tests/fuzz/%.c tests/test.h tests/meshes.h tests/fuzz/fuzz.h $(EXAMPLE_HEADERS) pktrt.h | build/fuzz
	clang $(FUZZ_FLAGS) $(STRICT) -c $< -o $@

build/fuzz/reference.o build/fuzz/oracle.o: build/fuzz/%.o: tests/%.c tests/test.h tests/meshes.h tests/oracle.h pktrt.h | build/fuzz
	clang $(FUZZ_FLAGS) $(STRICT) -c $< -o $@

build/fuzz/pktrt.o: pktrt.h | build/fuzz
	clang $(FUZZ_FLAGS) $(STRICT) -Wno-unused-function -DPKTRT_IMPLEMENTATION -x c -c $< -o $@

#: matrix            compiles and runs as C99 to C++23, by several compilers, for many platforms
matrix:
	.ci/matrix

# One checksum on all of them: a table. ONLY="s390x wasm" picks some; .ci/platforms --list tells their names.
#: platforms         compares one checksum on eleven platforms, in a table
platforms:
	@.ci/platforms $(ONLY)

# For a change of bits that is meant: writes the sums that must come out anew, and the one that bench/README.md shows.
$(B)/checksum: tests/checksum.c tests/scenes.h $(B)/all/pktrt.o
	$(PROGRAM)

#: checksum          writes the checksums that must come out: tests/checksum.txt, bench/README.md
checksum: $(B)/checksum
	$< | sed '/^by /d' >$(B)/checksum.txt
	@was=$$(sed -n 's/^all *//p' tests/checksum.txt); is=$$(sed -n 's/^all *//p' $(B)/checksum.txt); \
	  sed -i "s/$$was/$$is/" bench/README.md; mv $(B)/checksum.txt tests/checksum.txt; echo "$$was -> $$is"

#: checksums         compares a picture by all instruction sets, platforms, Python and MPI, in a table
checksums: | $(RESULTS)
	@NEW=1 .ci/checksums
	@cp build/checksums.csv $(RESULTS)/checksums.csv
	$(TABLES)

# Compiler flags that change values are refused by name; under all others the bits are the same.
#: flags             tries compiler flags: each is refused by name, or changes no bit
flags:
	.ci/flags

#: test-guards       compiles the header behind hostile macros and windows.h; checks exported names
test-guards:
	tests/hostile.sh
	tests/linkage.sh

# What install puts is found by pkg-config and CMake; copies of the header bear each other in one program.
#: test-install      installs, then builds by pkg-config and CMake, with several copies of the header
test-install:
	@CC="$(CC)" tests/install.sh

# The tarball has the same bytes wherever it is packed, from a clone or from itself. FULL=1 follows the README in it.
#: test-dist         tests the bytes of `make dist`; FULL=1 also follows the README in it
test-dist:
	@FULL="$(FULL)" tests/dist.sh

# --- checks of the text ---

#:
#: --- checks of the text, release ---
#: map               checks that what the header's map from the paper to the code names is there
map:
	.ci/map

#: structure         checks tags, kernels, lengths of functions and instruction sets in the header
# Each check is made of headers, too, in which it must fail.
structure:
	.ci/structure
	.ci/style pktrt.h

#: spell             checks the spelling of READMEs, course, other texts and comments, by aspell
spell:
	.ci/spell

#: targets           checks the makefiles: help, lengths, and that measurements change no tracked file
targets:
	.ci/targets

# By .clang-format, as its version 14 reads it: others break lines elsewhere.
CLANG_FORMAT ?= $(firstword $(shell command -v clang-format-14 clang-format 2>/dev/null))
FORMAT_FILES = $(wildcard $(foreach folder,examples examples/* tests tests/* bench bench/*,$(folder)/*.c $(folder)/*.h)) pktrt.h
#: format            rewrites all C files by clang-format; format-check names what it would change
format:
	@[ -n "$(CLANG_FORMAT)" ] || { echo "format: clang-format is not installed (make deps-extra)"; exit 1; }
	$(CLANG_FORMAT) -i $(FORMAT_FILES)

format-check:
	@[ -n "$(CLANG_FORMAT)" ] || { echo "format-check: clang-format is not installed (make deps-extra)"; exit 1; }
	@CLANG_FORMAT="$(CLANG_FORMAT)" .ci/format $(FORMAT_FILES)

# --- releasing ---

#: dist              packs build/pktrt-VERSION.tar.gz, with the same bytes for everyone
# The files that git knows, as they are now; where there is no git, as in an unpacked tarball, all but what is made. They get the
# time of the last commit, or that of SOURCE_DATE_EPOCH, and neither owner nor umask of who packs.
DIST = pktrt-$(VERSION)
dist: | $(B)
	@tar --version 2>/dev/null | grep -q 'GNU tar' || { echo "dist: GNU tar is not installed"; exit 1; }
	@[ ! -e .git ] || git --version >/dev/null 2>&1 || { echo "dist: git is not installed, and here it knows the files"; exit 1; }
	@set -e; list=$(B)/$(DIST).list tarball=$(B)/$(DIST).tar; \
	  if [ -e .git ]; then \
	    git ls-files -z >"$$list"; date=$$(git log -1 --format=%ct); \
	    git diff --quiet HEAD || echo "dist: with changes that are not committed"; \
	  else \
	    find . -type f ! -path './build/*' ! -path './out/*' ! -path './mine*.c' -printf '%P\0' >"$$list"; date=$$(date -r pktrt.h +%s); \
	  fi; \
	  LC_ALL=C sort -z -o "$$list" "$$list"; \
	  tar --null --no-recursion -T "$$list" --transform 's,^,$(DIST)/,' --format=ustar --mode=u=rwX,go=rX --owner=0 --group=0 \
	    --numeric-owner --mtime="@$${SOURCE_DATE_EPOCH:-$$date}" -cf "$$tarball"; \
	  gzip -9nf "$$tarball"; rm "$$list"
	@sha256sum $(B)/$(DIST).tar.gz
