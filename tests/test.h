/* Small test frame of pktrt: checks, sentence names, random numbers, a counting allocator, threads.
   A test is a function; a suite lists its tests with run("a sentence", function). Every test must leave the counting
   allocator empty. Checks go on after a failure, so that one run tells all. */
#ifndef PKTRT_TEST_H
#define PKTRT_TEST_H

#if !defined(_POSIX_C_SOURCE)
#define _POSIX_C_SOURCE 200809L
#endif
#include "../pktrt.h"
#include <float.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* References must round as they are written, whatever the flags say. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#elif defined(__GNUC__)
#pragma GCC optimize("fp-contract=off")
#endif

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SANITIZED 1
#endif
#endif
#ifndef SANITIZED
#define SANITIZED 0
#endif

/* Of a function that divides by zero and means it: IEEE 754 says what comes out. */
#if defined(__clang__) || (defined(__GNUC__) && __GNUC__ >= 8)
#define DIVIDES_BY_ZERO __attribute__((no_sanitize("float-divide-by-zero")))
#else
#define DIVIDES_BY_ZERO
#endif

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

/* --- checks --- */
bool check_at(bool ok, const char *file, int line, const char *what, ...) /* prints the first few failures of a test */
#if defined(__GNUC__)
    __attribute__((format(printf, 4, 5)))
#endif
    ;
#define CHECK(...) /* CHECK(ok) or CHECK(ok, format, ...) */ \
  CHECK_PICK(__VA_ARGS__, CHECK_SAY, CHECK_SAY, CHECK_SAY, CHECK_SAY, CHECK_SAY, CHECK_SAY, CHECK_SAY, CHECK_SAY, \
      CHECK_SAY, CHECK_SAY, CHECK_SAY, CHECK_BARE, 0) \
  (__VA_ARGS__)
#define CHECK_PICK(a, b, c, d, e, f, g, h, i, j, k, l, name, ...) name
#define CHECK_BARE(ok) check_at((ok), __FILE__, __LINE__, "%s", #ok)
#define CHECK_SAY(ok, ...) check_at((ok), __FILE__, __LINE__, __VA_ARGS__)
void say(const char *format, ...) /* a remark under the test's line: counts, above all */
#if defined(__GNUC__)
    __attribute__((format(printf, 1, 2)))
#endif
    ;
void run(const char *sentence, void (*test)(void));

/* --- scale --- */
extern bool small_run;         /* --small: fewer rays and triangles, for sanitizers and emulators */
size_t scaled(size_t count);   /* count, or a fortieth of it */
extern double thoroughness;    /* --thorough X: of the cases of stability.h; 1 in `make stability` */
size_t thorough(size_t count); /* that part of count */

/* --- random numbers: a pure function of a counter --- */
static inline uint64_t mix64(uint64_t x) {
  x += 0x9E3779B97F4A7C15u;
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}
typedef struct rng {
  uint64_t state;
} rng;
extern uint64_t run_seed; /* --seed N: other rays, other meshes */
static inline rng rng_of(uint64_t seed) {
  rng r = {mix64(seed ^ run_seed << 40)};
  return r;
}
static inline uint32_t rng_u32(rng *r) { return (uint32_t)(mix64(r->state++) >> 32); }
static inline uint32_t rng_below(rng *r, uint32_t n) { return (uint32_t)(((uint64_t)rng_u32(r) * n) >> 32); }
static inline float rng_unit(rng *r) { return (float)(rng_u32(r) >> 8) * 0x1p-24f; }
static inline float rng_range(rng *r, float lo, float hi) { return lo + (hi - lo) * rng_unit(r); }
static inline float rng_sign(rng *r) { return rng_range(r, -1, 1); }

/* --- vectors --- */
static inline float dot3(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static inline bool same_bits(const void *a, const void *b, size_t size) { return memcmp(a, b, size) == 0; }
static inline pktrt_ray ray_of(float ox, float oy, float oz, float dx, float dy, float dz) {
  pktrt_ray r = {{ox, oy, oz}, 0, {dx, dy, dz}, INFINITY, 0};
  return r;
}

/* --- hooks --- */
typedef struct test_hooks { /* the user pointer of scene_desc_of() */
  pthread_mutex_t lock;
  size_t live_blocks, live_bytes, calls, failed; /* failed: those made to fail */
  size_t fail_at;                                /* the n-th allocation from now on fails, counted from 1; 0: none */
  bool fail_after;                               /* and all that follow it */
  size_t limit;                                  /* larger requests fail; 0: none */
  int workers;                                   /* of parallel_for */
  int warnings, notes;                           /* log sentences of level 0, 1 */
  char last_log[256];
  size_t peak_bytes; /* the most that live_bytes has been; to be set by who asks */
} test_hooks;
extern test_hooks hooks;                                    /* the one that all tests share */
pktrt_scene_desc scene_desc_of(pktrt_isa isa, int workers); /* workers 0: no parallel_for */
void threads_for(int workers, size_t n, void (*body)(void *arg, size_t i), void *arg);
/* On a stack of that size; memory NULL: one that crashes, where it can, on who needs more. */
void run_on_stack(void *memory, size_t size, void *(*body)(void *arg), void *arg);

/* Instruction sets that run here. */
extern pktrt_isa isas[8];
extern int isa_count;
#ifdef PKTRT_COUNT_FAST /* else the fast path counts rays and hits alone */
#define COUNTS_FAST true
#else
#define COUNTS_FAST false
#endif
bool has_frusta(pktrt_isa isa); /* AUTO: the widest. Sets that serve where there is nothing better have streams only. */

/* --- suites --- */
void suite_edges(void);
void suite_identity(void), suite_truth(void), suite_watertight(void), suite_render(void), suite_refusals(void),
    suite_scene(void), suite_memory(void), suite_tree(void), suite_spawn(void), suite_arithmetic(void),
    suite_sampler(void), suite_shading(void), suite_lights(void), suite_assembly(void), suite_pictures(void),
    suite_passes(void), suite_display(void), suite_report(void), suite_media(void), suite_mistakes(void),
    suite_events(void), suite_teaching(void), suite_counts(void), suite_instances(void), suite_groups(void),
    suite_surfaces(void), suite_slack(void), suite_splits(void), suite_work(void), suite_examples(void),
    suite_filter(void), suite_stability(void), suite_guards(void), suite_pairs(void), suite_settings(void),
    suite_mirrored(void), suite_flush(void), suite_extremes(void), suite_variance(void), suite_changes(void),
    suite_cover(void), suite_everyday(void), suite_cameras(void), suite_bent(void), suite_rigid(void), suite_pool(void),
    suite_closest(void), suite_thin(void), suite_manual(void);

#endif
