# pktrt.h is one header; this builds what stands beside it. `make help` lists the targets.

CC ?= cc
config ?= release

# Fused multiply-adds would change bits; the header forbids them to its own code, the flag to everything else here.
WARNINGS = -Wall -Wextra -Wpedantic -Wshadow -Wconversion
CFLAGS ?= $(FLAGS_$(config))
FLAGS_release = -O2
FLAGS_debug = -O0 -g
# Float division by zero and overflow of casts are not in `undefined`. Functions that mean it say so. Undefined behaviour traps: with
# sentences instead, VERBOSE=1, clang compiles half as long again.
SANITIZERS = -fsanitize=address,undefined,float-divide-by-zero,float-cast-overflow -fno-sanitize-recover=all \
  -fno-omit-frame-pointer $(if $(VERBOSE),,-fsanitize-undefined-trap-on-error)
# What the header builds when asked to, sets of instructions and kernels of the fast path that count: tests and benchmarks compare
# all. What CFLAGS leave out stays out.
ALL_SETS = -DPKTRT_SCALAR -DPKTRT_AVX512 -DPKTRT_COUNT_FAST
# SETS=-DPKTRT_NO_AVX512 leaves that one out, here and in `make fuzz`: it is the same source, and a third of the time to compile.
FLAGS_sanitize = -O1 -g1 $(SETS) $(SANITIZERS)
# Workers run the same code whatever the width of its vectors.
FLAGS_threads = -O1 -g1 $(THREADS) -DPKTRT_NO_SSE2 -DPKTRT_NO_AVX512
THREADS = -fsanitize=thread
ifeq ($(FLAGS_$(config)),)
$(error config=$(config) is none of: debug, release, sanitize, threads)
endif
STRICT = -std=c99 -ffp-contract=off $(WARNINGS)
LDLIBS = -lm -lpthread

B = $(if $(filter release,$(config)),build,build/$(config))

# Optional: mesh files other than .tri by assimp, a window by SDL2, and Embree to compare with. (Embree 3 brings no pkg-config file.)
ASSIMP := $(shell pkg-config --exists assimp 2>/dev/null && echo yes)
ASSIMP_FLAGS := $(if $(ASSIMP),-DHAVE_ASSIMP $(shell pkg-config --cflags assimp))
ASSIMP_LIBS := $(if $(ASSIMP),$(shell pkg-config --libs assimp))
# The viewer is built where SDL2 is. Its headers are nothing to warn about.
SDL := $(shell pkg-config --exists sdl2 2>/dev/null && echo yes)
SDL_FLAGS := $(if $(SDL),$(patsubst -I%,-isystem %,$(shell pkg-config --cflags sdl2)))
SDL_LIBS := $(if $(SDL),$(shell pkg-config --libs sdl2))
# OpenMPI, for a program that runs on many machines; the pkg-config file comes with mpicc, mpirun by itself.
MPI := $(shell pkg-config --exists ompi-c 2>/dev/null && command -v mpirun >/dev/null && echo yes)
MPI_FLAGS := $(if $(MPI),$(patsubst -I%,-isystem %,$(shell pkg-config --cflags ompi-c)))
MPI_LIBS := $(if $(MPI),$(shell pkg-config --libs ompi-c))
EMBREE := $(wildcard /usr/include/embree3/rtcore.h /usr/local/include/embree3/rtcore.h)

EXAMPLES = $(addprefix $(B)/,hello spinner cornell query packets pick lightmap instances changes distance effects deform model render $(if $(SDL),view) $(if $(MPI),mpi))
EXAMPLE_HEADERS = $(wildcard examples/*.h)
# checksum.c and stack.c are programs of their own: see `platforms`.
TEST_SOURCES = $(sort $(filter-out tests/fuzz/main.c tests/checksum.c tests/stack.c tests/mesh_file.c tests/image.c,$(wildcard tests/*.c tests/fuzz/*.c)))
TEST_OBJECTS = $(TEST_SOURCES:tests/%.c=$(B)/tests/%.o)

# Goals in a row, as in `make deps demo`, are made one after the other; what a goal is built from, side by side.
JOBS ?= $(shell nproc 2>/dev/null || echo 1)
BUILD = @$(MAKE) --no-print-directory -j$(JOBS)
ifeq ($(MAKELEVEL),0)
.NOTPARALLEL:
endif

.PHONY: all demo effects deform model view test-view mpi test-mpi web web-serve test-web test-web-node test-serve test-image test-mesh-file readme-pictures example-pictures test test-leaveout sanitize test-neon test-wasm matrix platforms checksum flags test-guards deps deps-extra deps-web format format-check clean help
.PHONY: mutants map structure figures parts bench bench-check bench-plots bench-readme bench-pictures bench-tests peers exactness before instances error error-check error-before error-before-check error-before-samples leaveout leaveout-check leaveout-before leaveout-everyday weight weight-check weight-before
.PHONY: stability stability-neon stability-sanitize sanitize-threads fuzz
.PHONY: bench-wasm bench-three
.PHONY: install uninstall dist test-install test-dist
.PHONY: test-python python-picture checksums test-threads bench-threads
.PHONY: course course-check course-test course-text course-check-text course-pictures
.DELETE_ON_ERROR:

all:
	$(BUILD) $(EXAMPLES) $(B)/test
	@$(if $(SDL),:,echo "all: without SDL2 the viewer is not built (make deps-extra installs it)")
	@$(if $(MPI),:,echo "all: without OpenMPI the program for many machines is not built (make deps-extra installs it)")

help:
	@echo "all         examples and the test binary          demo        makes nine pictures: three scenes, three modes"
	@echo "effects     makes out/effects-*.png               deform      makes the frames out/deform-*.png"
	@echo "model       writes build/model.glb, a still life that examples/model.c makes, and draws it: out/model.png"
	@echo "view        looks around in a scene or file; ARGS=model.glb, ARGS=\"--scene conference\", ARGS=--help for keys"
	@echo "test-view   drives it under Xvfb and looks at the screen"
	@echo "mpi         builds build/mpi: render on many machines, by OpenMPI; mpirun -n 8 build/mpi --help"
	@echo "test-mpi    4 and 7 ranks on this machine have the bits of render; ranks that die, runs that are resumed, in a minute"
	@echo "web         makes the page out/web, in which one looks around by WebAssembly and follows a packet down the tree"
	@echo "web-serve   shows it at http://localhost:8000, PORT=8001 elsewhere"
	@echo "test-web    drives it in Chromium by keys, mouse and touch; its pictures have the bits of render (make deps-web installs it);"
	@echo "            test-web-node  what needs no browser of it; test-serve  serve.py alone, which keeps to its folder"
	@echo "course      builds and runs the course's programs: figures and out/course/*; N=2: only that of chapter 2;"
	@echo "            the way through: examples/course/README.md"
	@echo "course-check  N=2 FILE=mine_02.c: whether that solves the exercise of chapter 2"
	@echo "course-test  solutions pass, skeletons fail, listings are the code's; course-check-text only the last"
	@echo "course-text  puts the code into the texts anew        course-pictures  keeps the small pictures of the texts"
	@echo "test        runs all tests                        sanitize    runs a smaller set under ASan and UBSan"
	@echo "test-mesh-file  mesh files that assimp reads: edges, hostile sizes, with AddressSanitizer as well"
	@echo "            test-image, the first part of it: pictures as textures and environments, also without stb_image"
	@echo "test-python  examples/python/pktrt.py, by cffi and numpy, beside C: the same bits, no copies; by pip, offline"
	@echo "test-leaveout  the PKTRT_NO_... switches, each alone and all together"
	@echo "mutants     how many of 400 single faults, planted in every room of the header, the tests notice, in three hours"
	@echo "map         whether what the header's map from the paper to the code names is there"
	@echo "structure   the header inside: tags, kernels that ctags and clang see, long functions, instruction sets in one place"
	@echo "stability   the extremes at length, in half an hour; figures go to bench/README.md"
	@echo "stability-neon  a tenth of it on ARM, emulated        stability-sanitize  a hundredth under ASan and UBSan"
	@echo "fuzz        libFuzzer for TIME=600 seconds each: TARGETS=\"scene query settings mesh_file\""
	@echo "sanitize-threads  what several threads do at once, under TSan"
	@echo "matrix      C99 to C++23, compilers, platforms    test-neon   runs a smaller set on ARM, emulated"
	@echo "test-threads  examples/threads.h by pthreads, under TSan, and by Win32 (MinGW, wine)"
	@echo "bench-threads  what threads reach of what as many copies of a program do: trees and pictures"
	@echo "test-wasm   runs a smaller set in node, by WebAssembly's vectors; SIMD= by its scalar code"
	@echo "platforms   one checksum on eleven of them: a table  checksum    writes anew what must come out, tests/checksum.txt"
	@echo "checksums   one picture by all instruction sets, some platforms, from Python and by MPI: the README's table"
	@echo "flags       compiler flags, each refused by name or without effect"
	@echo "test-guards the header behind hostile macros and windows.h; what a library exports"
	@echo "bench       measures the paper's results, all or NAME=\"table1 figure6\"; BENCH_ARGS=... passes options"
	@echo "bench-check of these, what must hold, in two minutes, and that its controls fail"
	@echo "bench-plots, bench-readme  plots, and the tables of all READMEs, of what has been measured"
	@echo "bench-pictures  measures the README's pictures, in two minutes; bench-tests  counts the rays that tests compare"
	@echo "figures     names the tables of figures that are older than the header; each must say where it is from"
	@echo "parts       whether each header of the benches compiles by itself"
	@echo "peers       races Embree in a quarter of an hour; MESHES=\"FILE DIR\" of these too, FULL=1 everything, BENCH_ARGS=... options"
	@echo "bench-wasm  WebAssembly's vectors beside its scalar code, in node, in a minute"
	@echo "bench-three  the same beside three-mesh-bvh, which npm brings, in a few minutes; SCENE=conference"
	@echo "exactness   pktrt beside copies of itself with textbook tests of triangles, in three minutes"
	@echo "before      pktrt beside itself as it was at commit BEFORE=..., in ten minutes"
	@echo "instances   instances beside the same triangles added directly, at rest and moving, in two minutes"
	@echo "error       error against run time in ten minutes; NAME=\"slopes closed\" of these; error-check what must hold, in two"
	@echo "error-before  error at equal time against release 0.5.1, by scene; SCENES=\"sky lamps\" of these, BENCH_ARGS=... options;"
	@echo "            error-before-samples the time of a sample under 1,000 lamps; error-before-check that differences are found"
	@echo "weight      bytes and seconds to compile of usual builds, for the list in pktrt.h; weight-check that none weighs more;"
	@echo "            weight-before beside those of commit BEFORE=..."
	@echo "leaveout    what features cost where a scene has them not, in ten minutes; leaveout-check what must hold;"
	@echo "            leaveout-everyday the part of it on what 0.19.0 brought; leaveout-before what pictures under point"
	@echo "            lights alone cost over the header of commit BEFORE=..."
	@echo "format      rewrites all C files by clang-format; format-check names those that it would change"
	@echo "deps        installs what demo and test need      deps-extra  installs what the other targets need"
	@echo "install     the header, its files for pkg-config and CMake: PREFIX=/usr/local DESTDIR=        uninstall   takes them away"
	@echo "test-install  in a minute: programs by pkg-config and CMake, also Debug ones, several copies of the header in one program"
	@echo "dist        packs build/pktrt-VERSION.tar.gz, the same bytes for everyone who packs this commit"
	@echo "test-dist   its bytes and what is in it; FULL=1: in a quarter of an hour, its own make deps demo test, too"
	@echo "clean       removes build/ and out/               config=     debug, release (default), sanitize, threads"
	@echo "readme-pictures  makes the pictures of the README anew        example-pictures  the small ones of examples/README.md"

# --- examples ---

# Each is a program by itself, as `cc -O2 examples/hello.c -lm` shows. Here they share one implementation, which takes nearly all of
# the time to compile: with this define that of their own is taken for made.
$(B)/pktrt.o: pktrt.h | $(B)
	$(CC) $(CFLAGS) $(STRICT) -DPKTRT_IMPLEMENTATION -x c -c $< -o $@

# The same with all instruction sets, for what compares them. Programs with it are in a folder beside.
$(B)/all/pktrt.o: pktrt.h | $(B)/all
	$(CC) $(CFLAGS) $(ALL_SETS) $(STRICT) -DPKTRT_IMPLEMENTATION -x c -c $< -o $@

SHARED = -DPKTRT__IMPLEMENTED -DPKTRT__ENTRY_POINTS
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

$(B)/%: examples/%.c $(B)/pktrt.o
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) $< $(B)/pktrt.o -o $@ $(LDFLAGS) $(LDLIBS)

$(B) $(B)/all $(B)/tests/fuzz out:
	mkdir -p $@

SCENES = poolhall conference rtrt
PICTURE = picture() { echo "$(B)/render $$*"; $(B)/render "$$@"; echo; }
# One fine picture first, so that there is something to see within a minute. The curve keeps what is brighter than white.
LOOK = --tone curve --exposure 1.5
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

effects: | out
	$(BUILD) $(B)/effects
	$(B)/effects

deform: | out
	$(BUILD) $(B)/deform
	$(B)/deform $(ARGS)

# A glTF file that the project makes itself, and what render makes of it.
MODEL_SPP = 64
model: | out
	$(BUILD) $(B)/model $(B)/render
	$(B)/model $(B)/model.glb
ifeq ($(ASSIMP),)
	@echo "model: $(B)/model.glb is made; assimp, which reads it, is not installed (make deps-extra), so there is no picture"
else
	$(B)/render --mesh $(B)/model.glb --mode drt --spp $(MODEL_SPP) --size 512x512 -o out/model.png
endif

view:
ifeq ($(SDL),)
	@echo "view: SDL2 is not installed (make deps-extra installs libsdl2-dev), there is no window"; exit 1
else
	$(BUILD) $(B)/view
	$(B)/view $(ARGS)
endif

mpi:
ifeq ($(MPI),)
	@echo "mpi: OpenMPI is not installed (make deps-extra installs libopenmpi-dev and openmpi-bin), there is no program for many machines"; exit 1
else
	$(BUILD) $(B)/mpi
endif

# --- the web page ---

# A folder of static files. The module has WebAssembly's vectors alone: who has no SIMD gets a sentence from the page. NODE_PATH:
# Debian's emcc looks for its parser there.
WEB = out/web
WEB_CC = NODE_PATH=/usr/share/nodejs$(if $(NODE_PATH),:$(NODE_PATH)) emcc -O2 -msimd128 $(STRICT)
WEB_OBJECTS = build/web/pktrt.o \
  $(patsubst examples/web/%.c,build/web/%.o,$(filter-out %/walk_events.c,$(wildcard examples/web/*.c)))
WEB_LINK = -s MODULARIZE=1 -s EXPORT_NAME=pktrt -s ENVIRONMENT=web,worker,node -s ALLOW_MEMORY_GROWTH=1 -s FILESYSTEM=0 \
  -s EXPORTED_RUNTIME_METHODS=UTF8ToString --no-entry
WEB_PAGE = $(patsubst examples/web/%,$(WEB)/%,$(wildcard $(addprefix examples/web/*.,html css js)))
PORT ?= 8000
EMCC := $(shell command -v emcc)
web:
ifeq ($(EMCC),)
	@echo "web: emcc is not installed (make deps-extra installs emscripten), there is no page"; exit 1
else
	$(BUILD) $(WEB)/pktrt.js $(WEB_PAGE)
	@echo "web: $(WEB) is ready, $$(cat $(WEB)/* | gzip -9 | wc -c) bytes compressed; make web-serve shows it"
endif

web-serve: web
	python3 examples/web/serve.py $(WEB) $(PORT)

# What node can see of it: the bits of build/render and build/walk_events, memory that stays, time (ARGS=--quick leaves out the last
# two), whether the course's links lead where they say, and models from files, hostile ones too. Then the page as someone would use
# it, in Chromium; ONLY="pictures walk" picks functions of tests/web_page.js.
test-web: test-web-node
	ONLY="$(ONLY)" tests/web.sh $(WEB) $(B)

test-serve:
	python3 tests/serve.py

test-web-node: web test-serve
	$(BUILD) $(B)/render $(B)/walk_events
	node tests/web.js $(WEB) $(B)/render $(ARGS)
	node tests/walk.js $(WEB) $(B)/walk_events
	node tests/web_files.js $(WEB) $(ARGS)

$(WEB)/pktrt.js: $(WEB_OBJECTS) | $(WEB)
	$(WEB_CC) $(WEB_OBJECTS) $(WEB_LINK) -o $@

build/web/pktrt.o: pktrt.h | build/web
	$(WEB_CC) -DPKTRT_IMPLEMENTATION -x c -c $< -o $@

build/web/%.o: examples/web/%.c examples/web/web.h $(EXAMPLE_HEADERS) pktrt.h | build/web
	$(WEB_CC) $(SHARED) -c $< -o $@

# What the page shows of a packet's walk, as text. stb's header, which walk.c includes and does not use, is among the system's.
build/web/walk.o: WEB_CC += -idirafter /usr/include
build/web/walk.o $(B)/walk_events: examples/web/walk.c examples/course/course.h examples/course/07_figure3.h
$(B)/walk_events: examples/web/walk_events.c $(EXAMPLE_HEADERS) $(B)/all/pktrt.o
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) $< $(B)/all/pktrt.o -o $@ $(LDFLAGS) $(LDLIBS)

$(WEB_PAGE): $(WEB)/%: examples/web/% | $(WEB)
	cp $< $@

build/web $(WEB):
	mkdir -p $@

# With more samples per pixel. The README shows them; they are kept under version control.
readme-pictures: effects
	$(BUILD) $(B)/render
	mkdir -p .pictures
	@set -e; $(PICTURE); for scene in $(SCENES); do for mode in rcs wrt drt; do \
	  picture --scene $$scene --mode $$mode --spp 256 --size 512x512 $(LOOK) -o .pictures/$$scene-$$mode.png; \
	done; done
	@$(PICTURE); picture --scene rtrt --mode drt --spp 256 --size 1024x640 $(LOOK) -o .pictures/rtrt-large.png
	cp out/effects-*.png .pictures/
	@$(if $(ASSIMP),$(MAKE) --no-print-directory model && cp out/model.png .pictures/,echo "readme-pictures: without assimp there is no model.png")
	@$(MAKE) --no-print-directory example-pictures

# The small ones of examples/README.md, 256 pixels wide. Those of render are made of the README's.
GALLERY = .pictures/examples
SMALL = small() { $(B)/shrink "$$1" $(GALLERY)/$$2.png 256; }
example-pictures: effects | out
	$(BUILD) $(B)/shrink $(addprefix $(B)/,hello pick cornell deform instances changes lightmap distance)
	mkdir -p $(GALLERY)
	@set -e; for program in pick cornell instances changes lightmap distance; do $(B)/$$program; done >out/examples.txt
	$(B)/hello out/hello.png
	$(B)/deform --frames 4 --size 768x480
	@set -e; $(SMALL); for name in hello cornell instances lightmap distance; do small out/$$name.png $$name; done; \
	  small out/pick-before.png pick; small out/deform-001.png deform; small out/changes-2.png changes; \
	  small out/effects-gloss.png effects; small .pictures/poolhall-drt.png poolhall; \
	  small .pictures/conference-drt.png conference; small .pictures/rtrt-large.png rtrt; \
	  small .pictures/model.png model
	@set -e; $(SMALL); if [ -n "$(PYTHON)" ] && $(PYTHON) -c 'import matplotlib'; then export PKTRT_CACHE=$(B)/python; \
	  $(PYTHON) -B examples/python/ao.py >out/ao.pgm; small out/ao.pgm ao; \
	  $(PYTHON) -B examples/python/factors.py out/factors.png; small out/factors.png factors; \
	  else echo "example-pictures: there is no python3 with cffi, numpy and matplotlib (make deps-extra), theirs stay as they are"; fi
	@most=1200000; has=$$(cat $(GALLERY)/* | wc -c); echo "$(GALLERY): $$has bytes"; [ $$has -le $$most ]

$(B)/shrink: tests/view/shrink.c examples/common.h $(B)/pktrt.o | $(B)
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) $< $(B)/pktrt.o -o $@ $(LDFLAGS) $(LDLIBS)

# --- the course ---

# Chapters and labs are found by their names, as examples/course/README.md says. A program's figures stand beside its pictures.
COURSE = examples/course
COURSE_HEADERS = $(wildcard $(COURSE)/*.h) $(EXAMPLE_HEADERS)
COURSE_FILES = $(sort $(patsubst $(COURSE)/%.c,%,$(wildcard $(COURSE)/*.c)))
COURSE_PROGRAMS = $(filter-out %_check %_exercise %_solution,$(COURSE_FILES))
COURSE_CHECKS = $(patsubst %_check,%,$(filter %_check,$(COURSE_FILES)))
COURSE_TEXTS = $(sort $(wildcard $(COURSE)/*.md))
COURSE_CC = $(CC) $(CFLAGS) $(STRICT) $(SHARED) -I$(COURSE)

# All programs, or those of chapter N.
CHAPTER = $(if $(filter 1 2 3 4 5 6 7 8 9,$(N)),0)$(N)
COURSE_RUN = $(if $(N),$(filter $(CHAPTER)_%,$(COURSE_PROGRAMS)),$(COURSE_PROGRAMS))
course:
	@[ -n "$(COURSE_RUN)" ] || { echo "course: there is no chapter $(N)"; exit 1; }
	$(BUILD) $(COURSE_RUN:%=out/course/%.txt)
	@cat $(COURSE_RUN:%=out/course/%.txt)

out/course/%.txt: $(B)/course/% | out/course
	$< >$@ || { cat $@; exit 1; }

COURSE_LIBRARY = $(B)/pktrt.o
$(B)/course/%: $(COURSE)/%.c $(COURSE_HEADERS) $(B)/pktrt.o | $(B)/course
	$(COURSE_CC) $< $(COURSE_LIBRARY) -o $@ $(LDFLAGS) $(LDLIBS)

# It compares instruction sets.
$(B)/course/lab_differences: COURSE_LIBRARY = $(B)/all/pktrt.o
$(B)/course/lab_differences: $(B)/all/pktrt.o

.SECONDARY: $(COURSE_PROGRAMS:%=$(B)/course/%)

# An answer is compiled with the check of its chapter, which may include programs.
COURSE_ANSWER = $(COURSE_CC) $< $(COURSE)/$(@F).c $(B)/pktrt.o -o $@ $(LDFLAGS) $(LDLIBS)
$(B)/course/%_exercise: $(COURSE)/%_check.c $(COURSE)/%_exercise.c $(COURSE_PROGRAMS:%=$(COURSE)/%.c) $(COURSE_HEADERS) $(B)/pktrt.o | $(B)/course
	$(COURSE_ANSWER)
$(B)/course/%_solution: $(COURSE)/%_check.c $(COURSE)/%_solution.c $(COURSE_PROGRAMS:%=$(COURSE)/%.c) $(COURSE_HEADERS) $(B)/pktrt.o | $(B)/course
	$(COURSE_ANSWER)

course-check: | $(B)/course out/course
	@[ -f "$(COURSE)/$(CHAPTER)_check.c" ] && [ -f "$(FILE)" ] || \
	  { echo "course-check: of which chapter, and which file? As in make course-check N=2 FILE=mine_02.c"; exit 1; }
	@$(MAKE) --no-print-directory -q $(B)/pktrt.o || $(MAKE) --no-print-directory $(B)/pktrt.o
	@$(COURSE_CC) $(COURSE)/$(CHAPTER)_check.c $(FILE) $(B)/pktrt.o -o $(B)/course/$(CHAPTER)_mine $(LDFLAGS) $(LDLIBS)
	@$(B)/course/$(CHAPTER)_mine

TCC := $(shell command -v tcc)
course-test: course-check-text | out/course
	$(BUILD) $(COURSE_PROGRAMS:%=$(B)/course/%) $(foreach n,$(COURSE_CHECKS),$(B)/course/$n_exercise $(B)/course/$n_solution) \
	  $(if $(TCC),$(COURSE_FILES:%=$(B)/course/tcc/%.o))
	@echo "course-test: $(if $(TCC),all $(words $(COURSE_FILES)) files compile with tcc,tcc is not installed (make deps-extra), nothing is compiled by it)"
	tests/course.sh $(B)/course $(COURSE_CHECKS)

$(B)/course/tcc/%.o: $(COURSE)/%.c $(COURSE_HEADERS) pktrt.h | $(B)/course/tcc
	$(TCC) -std=c99 -Wall -Werror $(SHARED) -c $< -o $@

# Listings are the code between marks: see listings.awk there.
course-text: | $(B)/course
	@set -e; for text in $(COURSE_TEXTS); do \
	  awk -f $(COURSE)/listings.awk $$text >$(B)/course/text; cmp -s $(B)/course/text $$text || cp $(B)/course/text $$text; \
	done

course-check-text: | $(B)/course
	@good=0; for text in $(COURSE_TEXTS); do \
	  awk -f $(COURSE)/listings.awk $$text >$(B)/course/text || good=1; diff -u $$text $(B)/course/text || good=1; \
	done; [ $$good = 0 ] && echo "course-check-text: the listings of $(words $(COURSE_TEXTS)) texts are those of the code"

# The pictures that texts show are kept under version control, if they are small.
course-pictures: course
	mkdir -p .pictures/course
	@for name in $$(grep -ohE '\.pictures/course/[A-Za-z0-9_]+\.(png|svg)' $(COURSE_TEXTS) | sort -u); do \
	  file=out/course/$${name##*/}; case $$file in *.svg) most=100000 ;; *) most=60000 ;; esac; \
	  [ -s $$file ] || { echo "$$file is not made by a program of the course"; exit 1; }; \
	  [ $$(wc -c <$$file) -le $$most ] || { echo "$$file has more than $$most bytes"; exit 1; }; \
	  cmp -s $$file $$name || cp $$file $$name; \
	done

$(B)/course $(B)/course/tcc out/course:
	mkdir -p $@

# --- tests ---

$(B)/tests/%.o: tests/%.c $(wildcard tests/*.h tests/fuzz/*.h) bench/provenance.h $(EXAMPLE_HEADERS) pktrt.h | $(B)/tests/fuzz
	$(CC) $(CFLAGS) $(ALL_SETS) $(STRICT) -c $< -o $@

$(B)/test: $(TEST_OBJECTS)
	$(CC) $(CFLAGS) $^ -o $@ $(LDFLAGS) $(LDLIBS)

test:
	$(BUILD) $(B)/test $(B)/render $(if $(ONLY),,$(B)/checksum)
	$(B)/test --jobs $(JOBS) $(ONLY)
	$(if $(ONLY),,$(B)/checksum | sed '/^by /d' | diff tests/checksum.txt - && echo "checksum: answers and pictures have the bits that are kept")
	$(if $(ONLY),,tests/render.sh $(B)/render)

# What is left out by a switch is refused by name or does not compile; what is not keeps its bits.
test-leaveout:
	tests/leaveout.sh

# Plants single faults, one at a time, and tells which of them the tests notice; a run that was ended goes on. COUNT=, SEED=, HOURS=,
# ROOMS="..." and what they mean: tests/mutants.sh.
mutants:
	CC="$(CC)" JOBS=$(JOBS) tests/mutants.sh $(ARGS)

# The viewer, as someone would use it.
test-view:
ifeq ($(SDL),)
	@echo "test-view: SDL2 is not installed (make deps-extra installs libsdl2-dev), there is no viewer"; exit 1
else
	$(BUILD) $(B)/view $(B)/render $(B)/screenshot
	tests/view.sh $(B)
endif

# Pictures, without a sanitizer, with AddressSanitizer, and without stb_image.
test-image:
	$(BUILD) $(B)/pktrt.o
	mkdir -p $(B)/image
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) tests/image.c $(B)/pktrt.o -o $(B)/image/plain $(LDFLAGS) $(LDLIBS)
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) -fsanitize=address tests/image.c $(B)/pktrt.o -o $(B)/image/asan $(LDFLAGS) $(LDLIBS)
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) -DIMAGE_NO_STB tests/image.c $(B)/pktrt.o -o $(B)/image/without $(LDFLAGS) $(LDLIBS)
	cd $(B)/image && ./plain && ./asan && ./without

# Mesh files that assimp reads, without a sanitizer and with AddressSanitizer.
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

# Many ranks on one machine: their bits, deaths and resumptions.
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
test-python:
	@if [ -n "$(PYTHON)" ]; then $(MAKE) --no-print-directory -j$(JOBS) $(B)/render $(B)/python/answers $(B)/python/notebook $(B)/python/scene.so && $(PYTHON_RUN); \
	  else echo "test-python: there is no python3 with cffi and numpy (make deps-extra), nothing is compared"; fi

# The checksum of one picture, for .ci/checksums: PICTURE="poolhall wrt 64 48".
python-picture:
	@if [ -n "$(PYTHON)" ]; then $(MAKE) -s $(B)/python/scene.so && $(PYTHON_RUN) --picture $(PICTURE); \
	  else echo "python-picture: there is no python3 with cffi and numpy (make deps-extra)" >&2; fi

$(B)/python/answers $(B)/python/notebook: $(B)/python/%: tests/python/%.c tests/python/arrays.h $(B)/all/pktrt.o | $(B)/python
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) $< $(B)/all/pktrt.o -o $@ $(LDFLAGS) $(LDLIBS)

$(B)/python/scene.so: tests/python/scene.c $(EXAMPLE_HEADERS) pktrt.h | $(B)/python
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) -fPIC -shared $< -o $@ $(LDFLAGS) -lm

$(B)/python:
	mkdir -p $@

# The smaller set: the same tests with fewer rays. ONLY="words" picks tests by their sentences. clang, where there is one, sees
# more kinds of undefined behaviour than gcc.
SANITIZE_CC ?= $(if $(shell command -v clang),clang,$(CC))
sanitize:
	$(BUILD) CC=$(SANITIZE_CC) config=sanitize build/sanitize/test
	build/sanitize/test --small $(ONLY)

# A copy of the library with less slack, which is for controls only.
build/sanitize/tests/noslack.o: SANITIZERS =
build/threads/tests/noslack.o: THREADS = -O0

# What several threads do at once, under TSan.
# Threads of the examples: what a parallel_for promises, and what it reaches.
test-threads: | $(B)
	CC="$(CC)" tests/threads/threads.sh $(B)
bench-threads: | $(B)
	bench/threads.sh

sanitize-threads:
	$(BUILD) CC=$(SANITIZE_CC) config=threads build/threads/test
	build/threads/test --small $(or $(ONLY),workers threads "settings of a thread" "a moving scene's picture" "DRT picture has the same" "no after the last")

# The cases of tests/stability_*.c as long as they get; their figures go to $(RESULTS). Elsewhere: a tenth on ARM, emulated, a
# hundredth under sanitizers. Most of the time is that of the scalar kernels, hence the flag.
stability: | $(RESULTS)
	$(BUILD) B=build/stability CFLAGS="$(CFLAGS) -DPKTRT__INLINE_SCALAR" build/stability/test
	build/stability/test --thorough 1 --results $(RESULTS) stable
	@$(MAKE) --no-print-directory bench-readme

# Without the scalar kernels, which `platforms` compares on ARM.
ARM_CC = aarch64-linux-gnu-gcc
test-neon stability-neon:
	@command -v $(ARM_CC) >/dev/null || { echo "$@: $(ARM_CC) is not installed (make deps-extra)"; exit 1; }
	@command -v qemu-aarch64 >/dev/null || { echo "$@: qemu-aarch64 is not installed (make deps-extra)"; exit 1; }
	$(BUILD) CC=$(ARM_CC) CFLAGS="-O2 -DPKTRT_NO_SCALAR" LDFLAGS=-static config=release B=build/neon build/neon/test
	qemu-aarch64 build/neon/test --small $(if $(filter stability-neon,$@),--thorough 0.1 --results build/neon stable,$(ONLY))

# WebAssembly in node, by its vectors or, with SIMD= on the command line, by scalar code. Node has no fork, hence one process, and
# threads are none without workers: parallel_for runs what it is given in turn. One test says that it is skipped, that of rounding.
SIMD = -msimd128 -DPKTRT_NO_SCALAR
WASM_TESTS = build/wasm-tests$(if $(SIMD),,-scalar)
WASM_LINK = -s SINGLE_FILE=1 -s NODERAWFS=1 -s EXIT_RUNTIME=1 -s ALLOW_MEMORY_GROWTH=1 -s MAXIMUM_MEMORY=4GB \
  -s TOTAL_MEMORY=64MB -s TOTAL_STACK=8MB
test-wasm: export NODE_PATH := /usr/share/nodejs$(if $(NODE_PATH),:$(NODE_PATH))
test-wasm:
	@for program in emcc node; do command -v $$program >/dev/null || { \
	  echo "$@: $$program is not installed (make deps-extra)"; exit 1; }; done
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
fuzz:
	@command -v clang >/dev/null || { echo "fuzz: clang is not installed (make deps-extra)"; exit 1; }
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
	@$(MAKE) --no-print-directory bench-readme
endif

$(TARGETS:%=build/fuzz/%): build/fuzz/%: tests/fuzz/main.c build/fuzz/%.o $(FUZZ_OBJECTS)
	clang $(FUZZ_FLAGS) -fsanitize=fuzzer $(STRICT) -DTARGET=fuzz_$* $^ -o $@ $(LDLIBS)

build/fuzz/%.o: tests/fuzz/%.c tests/test.h tests/meshes.h tests/fuzz/fuzz.h $(EXAMPLE_HEADERS) pktrt.h | build/fuzz
	clang $(FUZZ_FLAGS) $(STRICT) -c $< -o $@

build/fuzz/reference.o build/fuzz/oracle.o: build/fuzz/%.o: tests/%.c tests/test.h tests/meshes.h tests/oracle.h pktrt.h | build/fuzz
	clang $(FUZZ_FLAGS) $(STRICT) -c $< -o $@

build/fuzz/pktrt.o: pktrt.h | build/fuzz
	clang $(FUZZ_FLAGS) $(STRICT) -Wno-unused-function -DPKTRT_IMPLEMENTATION -x c -c $< -o $@

build/fuzz:
	mkdir -p $@

# What the opening comment's map from the paper to the code names is there, and where it says.
map:
	.ci/map

# Tags, kernels that tools see, lengths of functions, capabilities, retired words; each with headers in which it must fail.
structure:
	.ci/structure

matrix:
	.ci/matrix

# One checksum on all of them: a table. ONLY="s390x wasm" picks some; .ci/platforms --list tells their names.
platforms:
	@.ci/platforms $(ONLY)

# For a change of bits that is meant: writes the sums that must come out anew, and the one that the README shows.
$(B)/checksum: tests/checksum.c tests/scenes.h $(B)/all/pktrt.o
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) $< $(B)/all/pktrt.o -o $@ $(LDFLAGS) $(LDLIBS)

checksum: $(B)/checksum
	$< | sed '/^by /d' >$(B)/checksum.txt
	@was=$$(sed -n 's/^all *//p' tests/checksum.txt); is=$$(sed -n 's/^all *//p' $(B)/checksum.txt); \
	  sed -i "s/$$was/$$is/" README.md; mv $(B)/checksum.txt tests/checksum.txt; echo "$$was -> $$is"

# One picture's checksum from all instruction sets, some platforms, Python and MPI: the README's table of it.
checksums: | $(RESULTS)
	@NEW=1 .ci/checksums
	@cp build/checksums.csv $(RESULTS)/checksums.csv
	@$(MAKE) --no-print-directory bench-readme

# Compiler flags that change values are refused by name; under all others the bits are the same.
flags:
	.ci/flags

# The header behind macros of others; what PKTRT_STATIC and PKTRT_DEF export.
test-guards:
	tests/hostile.sh
	tests/linkage.sh

# What install puts is found by pkg-config and CMake; copies of the header bear each other in one program.
test-install:
	@CC="$(CC)" tests/install.sh

# The tarball has the same bytes wherever it is packed, from a clone or from itself. FULL=1 follows the README in it.
test-dist:
	@FULL="$(FULL)" tests/dist.sh

# --- benchmarks ---

# On the last of the cores that this process may use: the first serves most interrupts.
PIN = $(addprefix taskset -c ,$(shell taskset -cp $$$$ 2>/dev/null | grep -o '[0-9]*$$'))
RESULTS = bench/results

bench: | $(RESULTS)
	$(BUILD) $(B)/paper
	$(PIN) $(B)/paper --results $(RESULTS) $(BENCH_ARGS) $(NAME)
	@$(MAKE) --no-print-directory bench-plots bench-readme

bench-check:
	$(BUILD) $(B)/paper
	$(PIN) $(B)/paper --check $(BENCH_ARGS); held=$$?; \
	  $(PIN) $(B)/paper --check-controls $(BENCH_ARGS) && exit $$held

bench-wasm:
	@bench/wasm.sh

# SCENE=conference races in another one, ROUNDS=9 takes the best of more. What npm brings goes to build/three.
bench-three: | $(RESULTS)
	$(BUILD) $(B)/provenance
	@SCENE="$(SCENE)" ROUNDS="$(ROUNDS)" bench/three.sh $(B)/provenance $(RESULTS)
	@$(MAKE) --no-print-directory bench-readme

# Of what has been measured; the CSV files stay when the plots are made anew.
READMES = README.md $(wildcard bench/README.md bench/*/README.md)
PLOTS = table1 figure6 figure7 figure8
bench-plots:
ifeq ($(shell command -v gnuplot),)
	@echo "bench-plots: gnuplot is not installed (make deps-extra), no plots are made"
else
	@set -e; for name in $(PLOTS); do [ ! -s $(RESULTS)/$$name.csv ] || gnuplot -e "name='$$name'" bench/paper/paper.gp; done
	@set -e; for name in slopes closed scenes adaptive; do [ ! -s $(RESULTS)/error_$$name.csv ] || \
	  gnuplot -e "name='$$name'; results='$(RESULTS)'" bench/error/error.gp; done
	@[ ! -s $(RESULTS)/peers.csv ] || gnuplot -e "results='$(RESULTS)'" bench/peers/peers.gp
endif

# The tables of READMEs stand between the marks <!-- NAME --> and <!-- /NAME -->.
bench-readme:
	@set -e; for file in $(READMES); do \
	  awk -v results=$(RESULTS) -f bench/readme.awk $$file >$(RESULTS)/README.new; mv $(RESULTS)/README.new $$file; \
	done

# Which tables are older than the header; that all say where they are from, and are made of files.
figures:
	.ci/figures

# That each header of the benches includes what it uses.
parts:
	.ci/parts

# The README's table of pictures, on a quiet machine.
bench-pictures: | $(RESULTS)
	$(BUILD) $(B)/render $(B)/provenance
	bench/pictures.sh $(B) $(RESULTS)
	@$(MAKE) --no-print-directory bench-readme

# The README's count of rays compared.
bench-tests: | $(RESULTS)
	$(BUILD) $(B)/test $(B)/provenance
	bench/tests.sh $(B) $(RESULTS)
	@$(MAKE) --no-print-directory bench-readme

$(B)/provenance: bench/provenance.c bench/provenance.h pktrt.h | $(B)
	$(CC) $(CFLAGS) $(STRICT) $< -o $@ $(LDFLAGS)

$(RESULTS):
	mkdir -p $@

$(B)/paper: bench/paper/paper.c $(wildcard bench/*.h bench/paper/*.h) $(EXAMPLE_HEADERS) pktrt.h | $(B)
	$(CC) $(CFLAGS) $(ALL_SETS) $(STRICT) $(if $(EMBREE),-DHAVE_EMBREE) $< -o $@ $(LDFLAGS) $(if $(EMBREE),-lembree3) $(LDLIBS)
	@$(if $(EMBREE),:,echo "paper: built without Embree 3; it compares with none (make deps-extra installs it)")

# It pins itself, but for the part with two workers.
peers: | $(RESULTS)
ifeq ($(EMBREE),)
	@echo "peers: Embree 3 is not installed (make deps-extra installs libembree-dev), nothing to compare with"
else
	$(BUILD) $(B)/peers
	touch $(B)/peers.begun
	$(B)/peers --results $(RESULTS) $(if $(FULL),--full) $(BENCH_ARGS) $(MESHES)
	[ ! $(RESULTS)/peers.csv -nt $(B)/peers.begun ] || ! grep -q avx512 $(RESULTS)/peers.csv || \
	  grep -E '^(#|scene,|poolhall,)' $(RESULTS)/peers.csv >$(RESULTS)/peers_poolhall.csv
	@$(MAKE) --no-print-directory bench-plots bench-readme
endif

$(B)/peers: bench/peers/peers.c $(wildcard bench/*.h bench/peers/*.h) $(EXAMPLE_HEADERS) pktrt.h | $(B)
	$(CC) $(CFLAGS) $(ALL_SETS) $(STRICT) $(ASSIMP_FLAGS) $< -o $@ $(LDFLAGS) -lembree3 $(ASSIMP_LIBS) $(LDLIBS)

# pktrt beside copies of itself with textbook tests of triangles.
exactness: | $(RESULTS)
	$(BUILD) $(B)/exactness
	$(PIN) $(B)/exactness --results $(RESULTS) $(BENCH_ARGS) $(MESHES)
	@$(MAKE) --no-print-directory bench-readme

$(B)/plain-%.o: bench/plain.c bench/plain.h bench/plain_tests.h pktrt.h | $(B)
	$(CC) $(CFLAGS) $(ALL_SETS) $(STRICT) $(if $(filter moller,$*),-DPLAIN_MOLLER) $(if $(filter stages,$*),-DPLAIN_STAGES) -c $< -o $@

$(B)/exactness: bench/exactness.c $(B)/plain-kensler.o $(B)/plain-moller.o $(B)/plain-stages.o $(wildcard bench/*.h bench/peers/*.h) $(EXAMPLE_HEADERS) pktrt.h
	$(CC) $(CFLAGS) $(ALL_SETS) $(STRICT) $(ASSIMP_FLAGS) $(filter-out %.h,$^) -o $@ $(LDFLAGS) $(ASSIMP_LIBS) $(LDLIBS)

# Instances beside the same triangles added directly.
instances: | $(RESULTS)
	$(BUILD) $(B)/instances-bench
	$(PIN) $(B)/instances-bench --results $(RESULTS) $(BENCH_ARGS)
	@$(MAKE) --no-print-directory bench-readme

$(B)/instances-bench: bench/instances.c $(wildcard bench/*.h) $(EXAMPLE_HEADERS) $(B)/all/pktrt.o
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) $< $(B)/all/pktrt.o -o $@ $(LDFLAGS) $(LDLIBS)

# pktrt beside itself as it was at commit BEFORE.
BEFORE ?= HEAD
CLONE = @[ -e .git ] || { echo "this takes a header of before from git: it needs a clone"; exit 1; }
before: | $(RESULTS)
	$(CLONE)
	mkdir -p $(B)/before
	git show $(BEFORE):pktrt.h >$(B)/before/new
	cmp -s $(B)/before/new $(B)/before/pktrt.h || mv $(B)/before/new $(B)/before/pktrt.h
	$(BUILD) $(B)/before/race
	$(PIN) $(B)/before/race --results $(RESULTS) $(BENCH_ARGS) $(MESHES)
	@$(MAKE) --no-print-directory bench-readme

$(B)/before/version_before.o: $(B)/before/pktrt.h
$(B)/before/version_%.o: bench/before_version.c bench/before.h pktrt.h
	$(CC) $(CFLAGS) $(ALL_SETS) $(STRICT) -DVERSION=version_$* -DHEADER='"../$(if $(filter before,$*),$(B)/before/)pktrt.h"' -c $< -o $@

$(B)/before/race: bench/before.c $(B)/before/version_before.o $(B)/before/version_now.o $(wildcard bench/*.h bench/peers/*.h) $(EXAMPLE_HEADERS) pktrt.h
	$(CC) $(CFLAGS) $(ALL_SETS) $(STRICT) $(ASSIMP_FLAGS) $(filter-out %.h,$^) -o $@ $(LDFLAGS) $(ASSIMP_LIBS) $(LDLIBS)

# Error against run time. References are kept while header and scenes stay the same. It pins itself, but for them.
REFERENCES = $(B)/references
comma := ,
ERROR = $(B)/error --references $(REFERENCES)
# In two processes; each stays on the last of its cores.
CORES = $(shell taskset -cp $$$$ 2>/dev/null | sed 's/.*: *//')
SECOND = $(if $(findstring -,$(CORES))$(findstring $(comma),$(CORES)),$(shell echo '$(CORES)' | grep -o '^[0-9]*'))
error: | $(RESULTS)
	$(BUILD) $(B)/error $(REFERENCES)/made
ifeq ($(NAME),)
	@$(ERROR) --results $(RESULTS) $(BENCH_ARGS) estimates targets flicker blue bias split cost filter & pictures=$$!; \
	  $(if $(SECOND),taskset -c $(SECOND)) $(ERROR) --results $(RESULTS) $(BENCH_ARGS) slopes bounds closed scenes adaptive && \
	  wait $$pictures
else
	$(ERROR) --results $(RESULTS) $(BENCH_ARGS) $(NAME)
endif
	@$(MAKE) --no-print-directory bench-plots bench-readme

error-check:
	$(BUILD) $(B)/error $(REFERENCES)/made
ifeq ($(NAME),)
	@$(ERROR) --check $(BENCH_ARGS) estimate target "slope on the DRT" >build/error-check.txt 2>&1 & pictures=$$!; \
	  $(if $(SECOND),taskset -c $(SECOND)) $(ERROR) --check $(BENCH_ARGS) "slope on s" "slope on the closed" "equal time" \
	    "time of" "the same" flicker filtered instructions; curves=$$?; \
	  wait $$pictures; held=$$?; cat build/error-check.txt; [ $$curves = 0 ] && [ $$held = 0 ]
else
	$(ERROR) --check $(BENCH_ARGS) $(NAME)
endif

$(REFERENCES)/made: pktrt.h $(EXAMPLE_HEADERS)
	rm -rf $(REFERENCES)
	mkdir -p $(REFERENCES)
	touch $@

$(B)/error: bench/error/error.c $(wildcard bench/error/*.h) bench/bench.h bench/provenance.h $(EXAMPLE_HEADERS) pktrt.h $(B)/all/pktrt.o
	$(CC) $(CFLAGS) $(STRICT) $< $(B)/all/pktrt.o -o $@ $(LDFLAGS) $(LDLIBS)

# Error at equal time against pktrt as it was: at release 0.5.1 unless ERROR_BEFORE says another commit.
ERROR_BEFORE ?= 5cbfd00
VERSIONS = $(B)/error-before
VERSIONS_RUN = $(VERSIONS)/versions --references $(VERSIONS)/references
error-before: $(VERSIONS)/header
	mkdir -p $(VERSIONS)/results
	$(VERSIONS_RUN) --results $(VERSIONS)/results $(BENCH_ARGS) $(SCENES)

# The time of a sample under 1,000 lamps over that under ten, of the choice of lights that BENCH_ARGS="--lights-now one" says.
error-before-samples: $(VERSIONS)/header
	$(VERSIONS)/versions --samples $(BENCH_ARGS)

error-before-check: $(VERSIONS)/header
	$(VERSIONS_RUN) --check --size 64 --seeds 8 $(BENCH_ARGS) $(SCENES)

.PHONY: $(VERSIONS)/header
$(VERSIONS)/header:
	$(CLONE)
	mkdir -p $(VERSIONS)
	git show $(ERROR_BEFORE):pktrt.h >$(VERSIONS)/new
	cmp -s $(VERSIONS)/new $(VERSIONS)/pktrt.h || mv $(VERSIONS)/new $(VERSIONS)/pktrt.h
	$(BUILD) $(VERSIONS)/versions $(VERSIONS)/references/version_before/made $(VERSIONS)/references/version_now/made

$(VERSIONS)/pktrt.h: ;
$(VERSIONS)/version_before.o: $(VERSIONS)/pktrt.h
$(VERSIONS)/version_now.o: pktrt.h
VERSION_HEADERS = bench/error/version.h bench/error/closed.h bench/error/error.h bench/bench.h bench/provenance.h
$(VERSIONS)/version_%.o: bench/error/version.c $(VERSION_HEADERS) $(EXAMPLE_HEADERS)
	$(CC) $(CFLAGS) $(ALL_SETS) $(STRICT) -DVERSION=version_$* -DHEADER='"../../$(if $(filter before,$*),$(VERSIONS)/)pktrt.h"' -c $< -o $@

$(VERSIONS)/versions: bench/error/versions.c $(VERSIONS)/version_before.o $(VERSIONS)/version_now.o $(VERSION_HEADERS) $(EXAMPLE_HEADERS)
	$(CC) $(CFLAGS) $(STRICT) $(filter-out %.h,$^) -o $@ $(LDFLAGS) $(LDLIBS)

$(VERSIONS)/references/version_before/made: $(VERSIONS)/pktrt.h $(EXAMPLE_HEADERS)
$(VERSIONS)/references/version_now/made: pktrt.h $(EXAMPLE_HEADERS)
$(VERSIONS)/references/version_%/made:
	rm -rf $(@D)
	mkdir -p $(@D)
	touch $@

# What features cost where they are not. Objects and programs are named by the switches that they are built with, as in
# NO_RENDER+NO_SIMD; `full` has none: it is what a program gets that defines nothing.
LEAVEOUT = $(B)/leaveout
LEAVEOUT_SWITCHES = NO_MOTION NO_STATS NO_PAPER NO_LENS NO_SHUTTER NO_AREA_LIGHTS NO_GLOSS NO_DIELECTRIC NO_CONDUCTOR \
  NO_NORMALS NO_TEXTURES NO_INSTANCES NO_GROUPS NO_REMOVAL NO_SURFACES NO_POOLS NO_CLOSEST
empty :=
LEAVEOUT_ALL = $(subst $(empty) ,+,$(strip $(LEAVEOUT_SWITCHES)))
# Queries only: the first with one instruction set and meshes at rest alone, then what that leaves out comes back.
ONE_SET = NO_RENDER+NO_SSE2
MESHES_ONLY = NO_STATS+NO_PAPER+NO_INSTANCES+NO_GROUPS+NO_REMOVAL+NO_SURFACES+NO_POOLS+NO_CLOSEST
LEAVEOUT_QUERIES = $(ONE_SET)+$(MESHES_ONLY)+NO_MOTION $(ONE_SET)+$(MESHES_ONLY)+NO_MOTION+NO_FRUSTA \
  $(ONE_SET)+$(MESHES_ONLY)+NO_FRUSTA $(ONE_SET)+$(MESHES_ONLY) $(ONE_SET)+NO_STATS+NO_PAPER $(ONE_SET) \
  NO_RENDER+NO_SIMD+$(MESHES_ONLY)+NO_MOTION+NO_FRUSTA NO_RENDER+NO_SIMD NO_RENDER
LEAVEOUT_DEFINES = $(patsubst %,-DPKTRT_%,$(filter-out full,$(subst +, ,$*)))
LEAVEOUT_SETS = AVX512+SCALAR NO_SSE2
LEAVEOUT_BUILT = $(addprefix $(LEAVEOUT)/,full $(LEAVEOUT_SWITCHES) $(LEAVEOUT_ALL) $(LEAVEOUT_QUERIES:%=%.o) \
  $(LEAVEOUT_SETS:%=%.o) full-O0.o)
LEAVEOUT_RUN = CC="$(CC)" ALL=$(LEAVEOUT_ALL) QUERIES="$(LEAVEOUT_QUERIES)" SETS="$(LEAVEOUT_SETS)"
leaveout: | $(RESULTS)
	$(BUILD) $(LEAVEOUT_BUILT) $(B)/provenance
	$(LEAVEOUT_RUN) PROVENANCE=$(B)/provenance $(PIN) bench/leaveout.sh $(LEAVEOUT) $(RESULTS)
	@$(MAKE) --no-print-directory bench-readme

weight:
	$(PIN) bench/weight.sh
weight-check:
	bench/weight.sh --check
# The same builds of the header of commit BEFORE.
weight-before: | $(RESULTS)
	$(CLONE)
	mkdir -p $(B)/weight
	git show $(BEFORE):pktrt.h >$(B)/weight/pktrt.h
	$(BUILD) $(B)/provenance
	$(PIN) bench/weight.sh --before $(B)/weight/pktrt.h $(B)/provenance $(RESULTS)
	@$(MAKE) --no-print-directory bench-readme

leaveout-check:
	$(BUILD) $(LEAVEOUT_BUILT)
	$(LEAVEOUT_RUN) $(PIN) bench/leaveout.sh --check $(LEAVEOUT)
	@$(MAKE) --no-print-directory leaveout-everyday

# Against another header: that of commit BEFORE, of what renders under point lights alone cost; that just before the everyday
# things of 0.19.0, of what scenes pay that have none of these.
leaveout-everyday: BEFORE = b5b2cc4
leaveout-before leaveout-everyday:
	$(CLONE)
	mkdir -p $(LEAVEOUT)/before
	git show $(BEFORE):pktrt.h >$(LEAVEOUT)/before/pktrt.h
	$(BUILD) $(LEAVEOUT)/full
	$(LEAVEOUT_CC) -DPKTRT_IMPLEMENTATION -x c -c $(LEAVEOUT)/before/pktrt.h -o $(LEAVEOUT)/before/full.o
	$(LEAVEOUT_CC) -D_GNU_SOURCE -include $(LEAVEOUT)/before/pktrt.h bench/leaveout.c $(LEAVEOUT)/before/full.o \
	  -o $(LEAVEOUT)/before/full $(LDFLAGS) $(LDLIBS)
	ALL= QUERIES= SETS= $(PIN) bench/leaveout.sh --$(@:leaveout-%=%) $(LEAVEOUT)

LEAVEOUT_CC = $(CC) -O2 $(STRICT) $(LEAVEOUT_DEFINES)
$(LEAVEOUT)/full-O0.o: pktrt.h | $(LEAVEOUT)
	$(CC) -O0 $(STRICT) -DPKTRT_IMPLEMENTATION -x c -c $< -o $@

$(LEAVEOUT)/%.o: pktrt.h | $(LEAVEOUT)
	$(LEAVEOUT_CC) -DPKTRT_IMPLEMENTATION -x c -c $< -o $@

.PRECIOUS: $(LEAVEOUT)/%.o
$(LEAVEOUT)/%: bench/leaveout.c bench/bench.h bench/provenance.h examples/common.h $(LEAVEOUT)/%.o
	$(LEAVEOUT_CC) $< $(LEAVEOUT)/$*.o -o $@ $(LDFLAGS) $(LDLIBS)

$(LEAVEOUT):
	mkdir -p $@

# --- installing and releasing ---

# Nothing is compiled. The files for pkg-config and CMake find the header from where they lie themselves, so the folder may be moved.
PREFIX ?= /usr/local
VERSION = $(shell awk '$$2 == "PKTRT_VERSION" { printf "%d.%d.%d", $$3 / 10000, $$3 / 100 % 100, $$3 % 100; exit }' pktrt.h)
quoted = '$(subst ','\'',$(1))'
INSTALLED_HEADER = $(call quoted,$(DESTDIR)$(PREFIX)/include/pktrt.h)
INSTALLED_PC = $(call quoted,$(DESTDIR)$(PREFIX)/share/pkgconfig/pktrt.pc)
INSTALLED_CMAKE = $(call quoted,$(DESTDIR)$(PREFIX)/lib/cmake/pktrt)
CMAKE_FILES = pktrtConfig.cmake pktrtConfigVersion.cmake
install:
	umask 022; install -d $(call quoted,$(DESTDIR)$(PREFIX)/include) $(call quoted,$(DESTDIR)$(PREFIX)/share/pkgconfig) $(INSTALLED_CMAKE)
	install -m 644 pktrt.h $(INSTALLED_HEADER)
	install -m 644 $(addprefix examples/cmake/,$(CMAKE_FILES)) $(INSTALLED_CMAKE)
	@rm -f $(INSTALLED_PC)
	umask 022; printf '%s\n' 'prefix=$${pcfiledir}/../..' 'includedir=$${prefix}/include' '' 'Name: pktrt' \
	  'Description: packet ray tracing in one C header' 'Version: $(VERSION)' 'Cflags: -I$${includedir}' 'Libs: -lm' \
	  >$(INSTALLED_PC)

# Folders stay: who made them is not known. That of pktrt's files for CMake goes if nothing else is in it.
uninstall:
	rm -f $(INSTALLED_HEADER) $(INSTALLED_PC) $(addprefix $(INSTALLED_CMAKE)/,$(CMAKE_FILES))
	@rmdir $(INSTALLED_CMAKE) 2>/dev/null || :

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

# --- what to install, on Debian 12 and its relatives ---

DEPS = gcc g++ libc6-dev libstb-dev
DEPS_EXTRA = pkg-config glpk-utils libassimp-dev libembree-dev clang clang-format libclang-rt-14-dev lld tcc gcc-mingw-w64-x86-64 \
  clang-tools universal-ctags cmake git \
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

# By themselves, since they are large, and nodejs from elsewhere than Debian brings an npm and bears none beside it.
deps-web: deps-extra
	$(INSTALL) -q install -y --no-install-recommends chromium $$(command -v npm >/dev/null || echo npm)

# --- upkeep ---

# By .clang-format, as its version 14 reads it: others break lines elsewhere.
CLANG_FORMAT ?= $(firstword $(shell command -v clang-format-14 clang-format))
FORMAT_FILES = $(wildcard $(foreach folder,examples examples/* tests tests/* bench bench/*,$(folder)/*.c $(folder)/*.h)) pktrt.h
format:
	@[ -n "$(CLANG_FORMAT)" ] || { echo "format: clang-format is not installed (make deps-extra)"; exit 1; }
	$(CLANG_FORMAT) -i $(FORMAT_FILES)

# Names the files that `make format` would change.
format-check:
	@[ -n "$(CLANG_FORMAT)" ] || { echo "format-check: clang-format is not installed (make deps-extra)"; exit 1; }
	@CLANG_FORMAT="$(CLANG_FORMAT)" .ci/format $(FORMAT_FILES)

clean:
	rm -rf build out
