# The web page, the course, and the pictures that READMEs show. Included by the Makefile.

#:
#: --- web page, course, pictures ---
.PHONY: web web-serve test-web test-web-node test-serve
.PHONY: course course-check course-test course-text course-check-text course-pictures
.PHONY: readme-pictures example-pictures web-picture
FOLDERS += build/web $(WEB) $(B)/course $(B)/course/tcc out/course

# --- the web page ---

# The page is a folder of static files. Its module needs WebAssembly's vectors; in a browser without them the page says so. Debian's
# emcc looks for its parser in NODE_PATH.
WEB = out/web
WEB_CC = NODE_PATH=/usr/share/nodejs$(if $(NODE_PATH),:$(NODE_PATH)) emcc -O2 -msimd128 $(STRICT)
WEB_OBJECTS = build/web/pktrt.o \
  $(patsubst examples/web/%.c,build/web/%.o,$(filter-out %/walk_events.c,$(wildcard examples/web/*.c)))
WEB_LINK = -s MODULARIZE=1 -s EXPORT_NAME=pktrt -s ENVIRONMENT=web,worker,node -s ALLOW_MEMORY_GROWTH=1 -s FILESYSTEM=0 \
  -s EXPORTED_RUNTIME_METHODS=UTF8ToString --no-entry
WEB_PAGE = $(patsubst examples/web/%,$(WEB)/%,$(wildcard $(addprefix examples/web/*.,html css js)))
# What the page links to, so that the folder needs no other place.
WEB_TEXTS = $(addprefix $(WEB)/,pktrt.h project.txt course.txt licence.txt)
PORT ?= 8000
EMCC := $(shell command -v emcc 2>/dev/null)
web:
ifeq ($(EMCC),)
	@echo "web: emcc is not installed (make deps-extra installs emscripten), there is no page"; exit 1
else
	$(BUILD) $(WEB)/pktrt.js $(WEB_PAGE) $(WEB_TEXTS)
	@echo "web: $(WEB) is ready, $$(cd $(WEB) && cat *.html *.css *.js *.wasm | gzip -9 | wc -c) bytes compressed; make web-serve shows it"
endif

#: web-serve         shows the page out/web at http://localhost:8000; PORT=8001 elsewhere
web-serve: web
	python3 examples/web/serve.py $(WEB) $(PORT)

# What node can see of it: the bits of build/render and build/walk_events, memory that stays, time (ARGS=--quick leaves out the last
# two), whether the course's links lead where they say, and models from files, hostile ones too. Then the page as someone would use
# it, in Chromium; ONLY="pictures walk" picks functions of tests/web_page.js.
#: test-web          drives the page in Chromium by keys, mouse and touch; deps-web installs Chromium
#: test-web-node     tests what needs no browser; test-serve tests serve.py, which keeps to its folder
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
$(B)/walk_events: examples/web/walk_events.c $(EXAMPLE_HEADERS) $(B)/all/pktrt.o $(B)/all/web.o $(B)/all/web_file.o
	$(PROGRAM)
$(B)/all/web.o $(B)/all/web_file.o: $(B)/all/%.o: examples/web/%.c examples/web/web.h $(EXAMPLE_HEADERS) pktrt.h | $(B)/all
	$(CC) $(CFLAGS) $(STRICT) $(SHARED) -c $< -o $@

$(WEB_PAGE): $(WEB)/%: examples/web/% | $(WEB)
	cp $< $@

$(WEB)/pktrt.h: pktrt.h | $(WEB)
	cp $< $@
$(WEB)/project.txt: README.md | $(WEB)
	cp $< $@
$(WEB)/course.txt: examples/course/README.md $(sort $(wildcard examples/course/[0-9]*.md)) | $(WEB)
	cat $^ >$@
$(WEB)/licence.txt: pktrt.h | $(WEB)
	sed -n '/^\/\* >>licence/,/\*\//{ /^\/\* >>licence/d; s/ *\*\/$$//; s/^   //; p; }' $< >$@

# --- the course ---

# Without root, and on systems that are not Debian's: a compiler and make must be there. From Debian's package where apt-get can get
# it, otherwise from stb's repository, as it was in April 2026.
STB_URL ?= https://raw.githubusercontent.com/nothings/stb/31c1ad37456438565541f4919958214b6e762fb4
.PHONY: deps-local
deps-local:
	@mkdir -p $(LOCAL)/stb
	@cd $(LOCAL) && if rm -f libstb-dev_*.deb && apt-get -q download libstb-dev 2>/dev/null && dpkg -x libstb-dev_*.deb debian 2>/dev/null; \
	  then cp debian/usr/include/stb/stb_image.h debian/usr/include/stb/stb_image_write.h stb/; \
	  else for header in stb_image.h stb_image_write.h; do \
	    { curl -fsSL -o stb/$$header $(STB_URL)/$$header || wget -q -O stb/$$header $(STB_URL)/$$header; } 2>/dev/null || \
	      { rm -f stb/$$header; echo "deps-local: neither curl nor wget could fetch $(STB_URL)/$$header;" \
	        "put stb_image.h and stb_image_write.h into $(LOCAL)/stb by hand"; exit 1; }; done; fi
	@echo "deps-local: $(LOCAL)/stb has stb_image.h and stb_image_write.h; make finds them there"

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
	@grep -hv '^= ' $(COURSE_RUN:%=out/course/%.txt)

# (Rules with more letters stand first: make 3.81, which macOS has, takes the first that fits.)
# What the check of a chapter says of the solution, for figures of the text.
out/course/%_check.txt: $(B)/course/%_solution | out/course
	$< >$@ || { cat $@; exit 1; }

out/course/%.txt: $(B)/course/% | out/course
	$< >$@ || { cat $@; exit 1; }

# An answer is compiled with the check of its chapter, which may include programs.
COURSE_ANSWER = $(COURSE_CC) $< $(COURSE)/$(@F).c $(COURSE_LIBRARY) -o $@ $(LDFLAGS) $(LDLIBS)
COURSE_INCLUDED = $(COURSE_PROGRAMS:%=$(COURSE)/%.c) $(COURSE_HEADERS) $(B)/pktrt.o
$(B)/course/%_exercise: $(COURSE)/%_check.c $(COURSE)/%_exercise.c $(COURSE_INCLUDED) | $(B)/course
	$(COURSE_ANSWER)
$(B)/course/%_solution: $(COURSE)/%_check.c $(COURSE)/%_solution.c $(COURSE_INCLUDED) | $(B)/course
	$(COURSE_ANSWER)

COURSE_LIBRARY = $(B)/pktrt.o
$(B)/course/%: $(COURSE)/%.c $(COURSE_HEADERS) $(B)/pktrt.o | $(B)/course
	$(COURSE_CC) $< $(COURSE_LIBRARY) -o $@ $(LDFLAGS) $(LDLIBS)

# This program compares instruction sets.
$(B)/course/lab_differences: COURSE_LIBRARY = $(B)/all/pktrt.o
$(B)/course/lab_differences: $(B)/all/pktrt.o

# Chapter 13 reads counts of the fast path.
COURSE_COUNTING = $(addprefix $(B)/course/13_,fast exercise solution)
$(COURSE_COUNTING): COURSE_LIBRARY = $(B)/all/pktrt.o
$(COURSE_COUNTING): $(B)/all/pktrt.o

# These programs include solutions.
$(B)/course/11_picture: $(COURSE)/11_solution.c
$(B)/course/13_fast: $(COURSE)/05_solution.c $(COURSE)/13_solution.c

.SECONDARY: $(COURSE_PROGRAMS:%=$(B)/course/%)

COURSE_CHECK_LIBRARY = $(if $(filter 13,$(CHAPTER)),$(B)/all/pktrt.o,$(B)/pktrt.o)
course-check: | $(B)/course out/course
	@[ -f "$(COURSE)/$(CHAPTER)_check.c" ] && [ -f "$(FILE)" ] || \
	  { echo "course-check: of which chapter, and which file? As in make course-check N=2 FILE=mine_02.c"; exit 1; }
	@$(MAKE) --no-print-directory -q $(COURSE_CHECK_LIBRARY) || $(MAKE) --no-print-directory $(COURSE_CHECK_LIBRARY)
	@$(COURSE_CC) $(COURSE)/$(CHAPTER)_check.c $(FILE) $(COURSE_CHECK_LIBRARY) -o $(B)/course/$(CHAPTER)_mine $(LDFLAGS) $(LDLIBS)
	@$(B)/course/$(CHAPTER)_mine

#: course-test       tests solutions, which pass, skeletons, which fail, listings and figures of the
#:                   texts; course-check-text tests listings and figures alone
TCC := $(shell command -v tcc 2>/dev/null)
MINGW := $(shell command -v x86_64-w64-mingw32-gcc 2>/dev/null)
course-test: course-check-text | out/course
	$(BUILD) $(COURSE_PROGRAMS:%=$(B)/course/%) $(foreach n,$(COURSE_CHECKS),$(B)/course/$n_exercise $(B)/course/$n_solution) \
	  $(if $(TCC),$(COURSE_FILES:%=$(B)/course/tcc/%.o)) $(if $(MINGW),$(COURSE_FILES:%=$(B)/course/mingw/%.ok))
	@echo "course-test: $(if $(TCC),all $(words $(COURSE_FILES)) files compile with tcc,tcc is not installed (make deps-extra), nothing is compiled by it)"
	@echo "course-test: $(if $(MINGW),all of them compile for Windows,MinGW is not installed (make deps-extra)$(comma) nothing is compiled for Windows)"
	tests/concepts.sh
	tests/course.sh $(B)/course $(COURSE_CHECKS)

$(B)/course/tcc/%.o: $(COURSE)/%.c $(COURSE_HEADERS) pktrt.h | $(B)/course/tcc
	$(TCC) -std=c99 -Wall -Werror $(SHARED) -c $< -o $@

# The headers of Windows take words that other systems leave to programs.
$(B)/course/mingw/%.ok: $(COURSE)/%.c $(COURSE_HEADERS) pktrt.h | $(B)/course/mingw/include/stb
	$(MINGW) -std=c99 -fsyntax-only -Wall -Werror $(SHARED) -isystem $(B)/course/mingw/include $<
	@touch $@

# stb's headers alone: the others beside them are not those of Windows.
$(B)/course/mingw/include/stb:
	mkdir -p $(@D)
	ln -sfn $(if $(LOCAL_FLAGS),$(abspath $(LOCAL)/stb),/usr/include/stb) $@

# Listings are the code between marks, and figures what programs print: see listings.awk and figures.awk there.
COURSE_PRINTED = $(COURSE_PROGRAMS:%=out/course/%.txt) $(COURSE_CHECKS:%=out/course/%_check.txt)
COURSE_FILL = mkdir -p $(B)/course/texts && awk -f $(COURSE)/listings.awk $$text >$(B)/course/texts/$${text\#\#*/} && \
  awk -f $(COURSE)/figures.awk $(COURSE_PRINTED) $(B)/course/texts/$${text\#\#*/} >$(B)/course/text
#: course-text       copies code and figures into the texts of examples/course; changes tracked files
course-text: | $(B)/course
	$(BUILD) $(COURSE_PRINTED)
	@set -e; for text in $(COURSE_TEXTS); do $(COURSE_FILL); cmp -s $(B)/course/text $$text || cp $(B)/course/text $$text; done

course-check-text: | $(B)/course
	$(BUILD) $(COURSE_PRINTED)
	@good=0; for text in $(COURSE_TEXTS); do $(COURSE_FILL) || good=1; diff -u $$text $(B)/course/text || good=1; done; \
	[ $$good = 0 ] && echo "course-check-text: listings and figures of $(words $(COURSE_TEXTS)) texts are those of code and programs"

# The pictures that texts show are kept under version control, if they are small.
#: course-pictures   copies the pictures of these texts to .pictures/course; changes tracked files
course-pictures: course
	mkdir -p .pictures/course
	@for name in $$(grep -ohE '\.pictures/course/[A-Za-z0-9_]+\.(png|svg)' $(COURSE_TEXTS) | sort -u); do \
	  file=out/course/$${name##*/}; case $$file in *.svg) most=100000 ;; *) most=60000 ;; esac; \
	  [ -s $$file ] || { echo "$$file is not made by a program of the course"; exit 1; }; \
	  [ $$(wc -c <$$file) -le $$most ] || { echo "$$file has more than $$most bytes"; exit 1; }; \
	  cmp -s $$file $$name || cp $$file $$name; \
	done

# --- the pictures of READMEs ---

# The pictures of the demo with more samples per pixel; they are kept under version control.
#: readme-pictures   makes the pictures of READMEs, then example-pictures; changes tracked files
readme-pictures: effects
	$(BUILD) $(B)/render
	mkdir -p .pictures
	@set -e; $(PICTURE); for scene in $(SCENES); do for mode in rcs wrt drt; do \
	  picture --scene $$scene --mode $$mode --spp 256 --size 512x512 $(LOOK) -o .pictures/$$scene-$$mode.png; \
	done; done
	@$(PICTURE); picture --scene rtrt --mode drt --spp 256 --size 1024x640 $(LOOK) -o .pictures/rtrt-large.png
	cp out/effects-*.png .pictures/
ifeq ($(ASSIMP),)
	@echo "readme-pictures: without assimp there is no model.png"
else
	@$(MAKE) --no-print-directory model
	cp out/model.png .pictures/
endif
	@$(MAKE) --no-print-directory example-pictures

# The pictures of examples/README.md are 256 pixels wide. Those of render are made from the pictures of the README.
GALLERY = .pictures/examples
SMALL = small() { $(B)/shrink "$$1" $(GALLERY)/$$2.png 256; }
#: example-pictures  makes the small pictures of examples/README.md; changes tracked files
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

# The page as it is at first, after some passes.
#: web-picture       makes the small picture of the page by Chromium; changes a tracked file
web-picture: web | out
	$(BUILD) $(B)/shrink
	ONLY=gallery tests/web.sh $(WEB) $(B)
	@$(SMALL); small out/web-page.png web

$(B)/shrink: tests/view/shrink.c examples/common.h $(B)/pktrt.o | $(B)
	$(PROGRAM)
