/* Fuzz targets: each takes any bytes for a list of what to do, does it, and returns NULL, or a sentence that says what should not
   have happened. `broken`: one of the library's answers is spoilt before it is looked at, which must be noticed: the control.
   clang's libFuzzer drives them by main.c (make fuzz), `make test` replays the corpora (stability_hostile.c). */
#ifndef PKTRT_TEST_FUZZ_H
#define PKTRT_TEST_FUZZ_H
#include "../test.h"

const char *fuzz_scene(const uint8_t *data, size_t size, bool broken);     /* calls that change a scene, in any order */
const char *fuzz_query(const uint8_t *data, size_t size, bool broken);     /* any rays, against any triangles */
const char *fuzz_settings(const uint8_t *data, size_t size, bool broken);  /* materials, lights, all of a render */
const char *fuzz_mesh_file(const uint8_t *data, size_t size, bool broken); /* .tri files */

/* --- bytes: zeros at their end --- */
typedef struct feed {
  const uint8_t *p;
  size_t left;
} feed;
uint32_t take_u8(feed *);
uint32_t take_u32(feed *);
uint32_t take_below(feed *, uint32_t n); /* [0,n), n <= 256 */
float take_tame(feed *);                 /* a multiple of 1/16 in [-8,8): such meet each other's edges */
float take_float(feed *);                /* tame, or one of the values where things break, or any 32 bits */
void take_floats(feed *, float *, int n);
void take_tames(feed *, float *, int n);

/* --- memory: every block exactly as large as asked for, counted --- */
typedef struct fuzz_memory {
  size_t blocks, calls, failed; /* blocks that live */
  uint32_t fail_at;             /* the n-th allocation from now on fails; 0: none */
} fuzz_memory;
/* A serial parallel_for, backwards, if asked for. */
pktrt_scene_desc fuzz_scene_desc(fuzz_memory *, pktrt_isa, bool parallel);
void *fuzz_block(size_t size); /* malloc, or the end; sizes of 0 are fine */

/* --- what every target looks at --- */
/* After a call that was refused: one sentence, on one line. */
const char *fuzz_no_sentence(const pktrt_scene *);
/* A hit within the interval, or the miss of that ray. */
const char *fuzz_bad_hit(const pktrt_ray *, const pktrt_hit *, bool hit);
bool fuzz_all_finite(const float *, size_t n);
/* Materials and lights of any bytes, and whether they are to be accepted. */
pktrt_material fuzz_material(feed *, bool *good);
pktrt_light fuzz_light(feed *, bool *good);

#endif
