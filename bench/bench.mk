# The benchmarks. Included by the Makefile. Measurements write to $(RESULTS), which is out/results; no tracked file changes before
# `make bench-publish`.

#:
#: --- measurements; all write to out/results, and BENCH_ARGS=... passes options ---
.PHONY: bench bench-check bench-plots bench-readme bench-publish bench-headline bench-pictures bench-tests bench-threads bench-wasm bench-three
.PHONY: bench-lamps figures parts peers exactness instances before error error-check error-before error-before-samples error-before-check
.PHONY: leaveout leaveout-check leaveout-before leaveout-everyday weight weight-check weight-before
FOLDERS += $(RESULTS) $(LEAVEOUT)

BENCH_CC = $(CC) $(CFLAGS) $(ALL_SETS) $(STRICT)
BENCH_HEADERS = $(wildcard bench/*.h) $(EXAMPLE_HEADERS)
# Compiles and links a bench that reads mesh files: all that it depends on but headers.
BENCH_OF_MESHES = $(BENCH_CC) $(ASSIMP_FLAGS) $(filter-out %.h,$^) -o $@ $(LDFLAGS) $(ASSIMP_LIBS) $(LDLIBS)
# The last step of a measurement.
TABLES = +@$(MAKE) --no-print-directory bench-readme
PLOTS_AND_TABLES = +@$(MAKE) --no-print-directory bench-plots bench-readme

# Measurements run on the last of the cores that this process may use: the first serves most interrupts.
PIN = $(addprefix taskset -c ,$(shell taskset -cp $$$$ 2>/dev/null | grep -o '[0-9]*$$'))

# NAME="table1 figure6" measures some parts.
bench: | $(RESULTS)
	$(BUILD) $(B)/paper
	$(PIN) $(B)/paper --results $(RESULTS) $(BENCH_ARGS) $(NAME)
	$(PLOTS_AND_TABLES)

#: bench-check       measures less, in five minutes, and checks what must hold, and its controls
bench-check:
	$(BUILD) $(B)/paper
	$(PIN) $(B)/paper --check $(BENCH_ARGS); held=$$?; \
	  $(PIN) $(B)/paper --check-controls $(BENCH_ARGS) && exit $$held

#: bench-threads     compares threads with as many copies of a program, for trees and pictures
bench-threads: | $(B)
	bench/threads.sh

#: bench-wasm        compares WebAssembly's vectors with its scalar code, in node, in a minute
bench-wasm:
	@bench/wasm.sh

# ROUNDS=9 takes the best of more. What npm brings goes to build/three.
#: bench-three       compares with three-mesh-bvh, which npm brings, in a few minutes; SCENE=conference
bench-three: | $(RESULTS)
	$(BUILD) $(B)/provenance
	@SCENE="$(SCENE)" ROUNDS="$(ROUNDS)" bench/three.sh $(B)/provenance $(RESULTS)
	$(TABLES)

# Of what has been measured and is not yet published. RESULTS=bench/results makes those that are kept anew.
PLOTS = table1 figure6 figure7 figure8
#: bench-plots       draws plots of out/results
bench-plots:
ifeq ($(shell command -v gnuplot 2>/dev/null),)
	@echo "bench-plots: gnuplot is not installed (make deps-extra), no plots are made"
else
	@set -e; plot() { [ ! -s $(RESULTS)/$$1.csv ] || gnuplot -e "name='$$3'; results='$(RESULTS)'" bench/$$2.gp; }; \
	  for name in $(PLOTS); do plot $$name paper/paper $$name; done; \
	  for name in slopes closed scenes adaptive; do plot error_$$name error/error $$name; done; \
	  plot peers peers/peers peers
endif

#: bench-readme      writes the READMEs with the figures of out/results, to out/readmes
bench-readme:
	@bench/publish.sh --look $(RESULTS)

#: bench-publish     moves out/results to bench/results, READMEs, manual; changes tracked files
bench-publish: bench-plots
	@bench/publish.sh $(RESULTS)

#: figures           lists tables of figures that are older than the header; checks their origins
figures:
	.ci/figures

#: parts             checks that each header of the benches compiles by itself
parts:
	.ci/parts

# With FROM=bench/results nothing is measured: peers.csv there has the figures.
#: bench-headline    measures the README's one table of figures, in ten minutes on a quiet machine
bench-headline: | $(RESULTS)
ifeq ($(EMBREE),)
	@echo "bench-headline: Embree 3 is not installed (make deps-extra installs libembree-dev), nothing to compare with"
else
	$(BUILD) $(B)/peers $(B)/render $(B)/provenance
	FROM="$(FROM)" BENCH_ARGS="$(BENCH_ARGS)" bench/headline.sh $(B) $(RESULTS)
	$(TABLES)
endif

#: bench-pictures    measures the times of the demo's pictures, in two minutes on a quiet machine
bench-pictures: | $(RESULTS)
	$(BUILD) $(B)/render $(B)/provenance
	bench/pictures.sh $(B) $(RESULTS)
	$(TABLES)

#: bench-tests       counts the rays that tests compare, for bench/README.md
bench-tests: | $(RESULTS)
	$(BUILD) $(B)/test $(B)/provenance
	bench/tests.sh $(B) $(RESULTS)
	$(TABLES)

$(B)/provenance: bench/provenance.c bench/provenance.h pktrt.h | $(B)
	$(CC) $(CFLAGS) $(STRICT) $< -o $@ $(LDFLAGS)

$(B)/paper: bench/paper/paper.c $(wildcard bench/paper/*.h) $(BENCH_HEADERS) pktrt.h | $(B)
	$(BENCH_CC) $(if $(EMBREE),-DHAVE_EMBREE) $< -o $@ $(LDFLAGS) $(if $(EMBREE),-lembree3) $(LDLIBS)
	@$(if $(EMBREE),:,echo "paper: built without Embree 3; it compares with none (make deps-extra installs it)")

# It pins itself, but for the part with two workers.
#: peers             races Embree, in a quarter of an hour; MESHES="FILE DIR": also these, FULL=1: all
peers: | $(RESULTS)
ifeq ($(EMBREE),)
	@echo "peers: Embree 3 is not installed (make deps-extra installs libembree-dev), nothing to compare with"
else
	$(BUILD) $(B)/peers
	$(B)/peers --results $(RESULTS) $(if $(FULL),--full) $(BENCH_ARGS) $(MESHES)
	$(PLOTS_AND_TABLES)
endif

PEERS_HEADERS = $(BENCH_HEADERS) $(wildcard bench/peers/*.h)
$(B)/peers: bench/peers/peers.c $(PEERS_HEADERS) pktrt.h | $(B)
	$(BENCH_CC) $(ASSIMP_FLAGS) $< -o $@ $(LDFLAGS) -lembree3 $(ASSIMP_LIBS) $(LDLIBS)

#: exactness         compares with textbook tests of triangles in the same kernels, in three minutes
exactness: | $(RESULTS)
	$(BUILD) $(B)/exactness
	$(PIN) $(B)/exactness --results $(RESULTS) $(BENCH_ARGS) $(MESHES)
	$(TABLES)

$(B)/plain-%.o: bench/plain.c bench/plain.h bench/plain_tests.h pktrt.h | $(B)
	$(BENCH_CC) $(if $(filter moller,$*),-DPLAIN_MOLLER) $(if $(filter stages,$*),-DPLAIN_STAGES) -c $< -o $@

$(B)/exactness: bench/exactness.c $(B)/plain-kensler.o $(B)/plain-moller.o $(B)/plain-stages.o $(PEERS_HEADERS) pktrt.h
	$(BENCH_OF_MESHES)

#: instances         compares instances with the same triangles added directly, in two minutes
instances: | $(RESULTS)
	$(BUILD) $(B)/instances-bench
	$(PIN) $(B)/instances-bench --results $(RESULTS) $(BENCH_ARGS)
	$(TABLES)

$(B)/instances-bench: bench/instances.c $(BENCH_HEADERS) $(B)/all/pktrt.o
	$(PROGRAM)

BEFORE ?= HEAD
CLONE = @[ -e .git ] || { echo "this takes a header of before from git: it needs a clone"; exit 1; }
#: before            compares with the header of commit BEFORE=..., in ten minutes
before: | $(RESULTS)
	$(CLONE)
	mkdir -p $(B)/before
	git show $(BEFORE):pktrt.h >$(B)/before/new
	cmp -s $(B)/before/new $(B)/before/pktrt.h || mv $(B)/before/new $(B)/before/pktrt.h
	$(BUILD) $(B)/before/race
	$(PIN) $(B)/before/race --results $(RESULTS) $(BENCH_ARGS) $(MESHES)
	$(TABLES)

$(B)/before/version_before.o: $(B)/before/pktrt.h
$(B)/before/version_%.o: bench/before_version.c bench/before.h bench/fresh.h pktrt.h
	$(BENCH_CC) -DVERSION=version_$* -DHEADER='"../$(if $(filter before,$*),$(B)/before/)pktrt.h"' -c $< -o $@

$(B)/before/race: bench/before.c $(B)/before/version_before.o $(B)/before/version_now.o $(PEERS_HEADERS) pktrt.h
	$(BENCH_OF_MESHES)

# Error against run time. References are kept while header and scenes stay the same. It pins itself, but for them.
REFERENCES = $(B)/references
comma := ,
ERROR = $(B)/error --references $(REFERENCES)
# In two processes; each stays on the last of its cores.
CORES = $(shell taskset -cp $$$$ 2>/dev/null | sed 's/.*: *//')
SECOND = $(if $(findstring -,$(CORES))$(findstring $(comma),$(CORES)),$(shell echo '$(CORES)' | grep -o '^[0-9]*'))
#: error             measures error against run time in ten minutes; NAME="slopes closed": some parts;
#:                   error-check checks what must hold, in two minutes
error: | $(RESULTS)
	$(BUILD) $(B)/error $(REFERENCES)/made
ifeq ($(NAME),)
	@$(ERROR) --results $(RESULTS) $(BENCH_ARGS) estimates targets flicker blue bias split cost filter shown & pictures=$$!; \
	  $(if $(SECOND),taskset -c $(SECOND)) $(ERROR) --results $(RESULTS) $(BENCH_ARGS) slopes bounds closed scenes adaptive && \
	  wait $$pictures
else
	$(ERROR) --results $(RESULTS) $(BENCH_ARGS) $(NAME)
endif
	$(PLOTS_AND_TABLES)

error-check:
	$(BUILD) $(B)/error $(REFERENCES)/made
ifeq ($(NAME),)
	@$(ERROR) --check $(BENCH_ARGS) estimate target "slope on the DRT" >$(B)/error-check.txt 2>&1 & pictures=$$!; \
	  $(if $(SECOND),taskset -c $(SECOND)) $(ERROR) --check $(BENCH_ARGS) "slope on s" "slope on the closed" "equal time" \
	    "time of" "the same" "a sun" flicker filtered instructions; curves=$$?; \
	  wait $$pictures; held=$$?; cat $(B)/error-check.txt; [ $$curves = 0 ] && [ $$held = 0 ]
else
	$(ERROR) --check $(BENCH_ARGS) $(NAME)
endif

$(REFERENCES)/made: pktrt.h $(EXAMPLE_HEADERS)
	rm -rf $(REFERENCES)
	mkdir -p $(REFERENCES)
	touch $@

$(B)/error: bench/error/error.c $(wildcard bench/error/*.h) bench/bench.h bench/provenance.h $(EXAMPLE_HEADERS) pktrt.h $(B)/all/pktrt.o
	$(CC) $(CFLAGS) $(STRICT) $< $(B)/all/pktrt.o -o $@ $(LDFLAGS) $(LDLIBS)

# Error at equal time of one light for all against all lights, under many lamps, with the instruction sets of a usual build.
$(B)/lamps: bench/lamps.c pktrt.h
	$(CC) $(CFLAGS) $(STRICT) $< -o $@ $(LDFLAGS) $(LDLIBS)
#: bench-lamps       compares PKTRT_LIGHTS_ONE with all lights at equal time, under many lamps
bench-lamps: $(B)/lamps
	mkdir -p $(REFERENCES)
	for kind in quad sphere; do for exponent in 0 30 100 1000; do for lamps in 100 300 1000; do \
	  $(B)/lamps --kind $$kind --exponent $$exponent --lamps $$lamps --references $(REFERENCES) $(BENCH_ARGS) || exit 1; \
	done; done; done

# Error at equal time against pktrt as it was: at release 0.5.1 unless ERROR_BEFORE says another commit.
ERROR_BEFORE ?= 5cbfd00
VERSIONS = $(B)/error-before
VERSIONS_RUN = $(VERSIONS)/versions --references $(VERSIONS)/references
#: error-before      compares error at equal time with release 0.5.1; SCENES="sky lamps": of these;
#:                   error-before-samples times samples under 1,000 lamps; error-before-check: controls
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
	$(BENCH_CC) -DVERSION=version_$* -DHEADER='"../../$(if $(filter before,$*),$(VERSIONS)/)pktrt.h"' -c $< -o $@

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
  NO_NORMALS NO_TEXTURES NO_INSTANCES NO_GROUPS NO_REMOVAL NO_SURFACES NO_POOLS NO_CLOSEST \
  NO_QUALITIES
empty :=
LEAVEOUT_ALL = $(subst $(empty) ,+,$(strip $(LEAVEOUT_SWITCHES)))
# Queries only: the first with one instruction set and meshes at rest alone, then what that leaves out comes back.
ONE_SET = NO_RENDER+NO_SSE2
MESHES_ONLY = NO_STATS+NO_PAPER+NO_INSTANCES+NO_GROUPS+NO_REMOVAL+NO_SURFACES+NO_POOLS+NO_CLOSEST+NO_QUALITIES
LEAVEOUT_QUERIES = $(ONE_SET)+$(MESHES_ONLY)+NO_MOTION $(ONE_SET)+$(MESHES_ONLY)+NO_MOTION+NO_FRUSTA \
  $(ONE_SET)+$(MESHES_ONLY)+NO_FRUSTA $(ONE_SET)+$(MESHES_ONLY) $(ONE_SET)+NO_STATS+NO_PAPER $(ONE_SET) \
  NO_RENDER+NO_SIMD+$(MESHES_ONLY)+NO_MOTION+NO_FRUSTA NO_RENDER+NO_SIMD NO_RENDER
LEAVEOUT_DEFINES = $(patsubst %,-DPKTRT_%,$(filter-out full,$(subst +, ,$*)))
LEAVEOUT_SETS = AVX512+SCALAR NO_SSE2
LEAVEOUT_BUILT = $(addprefix $(LEAVEOUT)/,full $(LEAVEOUT_SWITCHES) $(LEAVEOUT_ALL) $(LEAVEOUT_QUERIES:%=%.o) \
  $(LEAVEOUT_SETS:%=%.o) full-O0.o)
LEAVEOUT_RUN = CC="$(CC)" ALL=$(LEAVEOUT_ALL) QUERIES="$(LEAVEOUT_QUERIES)" SETS="$(LEAVEOUT_SETS)"
#: leaveout          measures what features cost where a scene has none of them, in ten minutes;
#:                   leaveout-check checks what must hold; leaveout-everyday, of what 0.19.0 brought;
#:                   leaveout-before compares pictures with the header of commit BEFORE=...
leaveout: | $(RESULTS)
	$(BUILD) $(LEAVEOUT_BUILT) $(B)/provenance
	$(LEAVEOUT_RUN) PROVENANCE=$(B)/provenance $(PIN) bench/leaveout.sh $(LEAVEOUT) $(RESULTS)
	$(TABLES)

#: weight            measures bytes and seconds to compile of usual builds, for the list in the manual;
#:                   weight-check checks that none is heavier; weight-before compares commit BEFORE=...
weight: | $(RESULTS)
	$(PIN) bench/weight.sh $(RESULTS)
weight-check:
	bench/weight.sh --check
weight-before: | $(RESULTS)
	$(CLONE)
	mkdir -p $(B)/weight
	git show $(BEFORE):pktrt.h >$(B)/weight/pktrt.h
	$(BUILD) $(B)/provenance
	$(PIN) bench/weight.sh --before $(B)/weight/pktrt.h $(B)/provenance $(RESULTS)
	$(TABLES)

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
