/* twins.h - compares functions of pktrt.h that have a scalar and a vector form; tree.c, which holds the implementation, includes
   it. Some pairs are compared where more is at hand: samples, camera rays, lights and points of surfaces in tree.c itself. */
#ifndef PKTRT_TEST_TWINS_H
#define PKTRT_TEST_TWINS_H

enum {
  TWIN_ROUNDS = 2000,
  TWIN_TRIANGLES = 64,
  TWIN_PLACES = 5 /* instances of twin_scene() */
};

/* Returns a number in [0,1), its ends often. */
static float twin_unit(rng *r) {
  const uint32_t pick = rng_below(r, 8);
  return pick == 0 ? 0 : pick == 1 ? 0.99999994f : pick == 2 ? 0.5f : rng_unit(r);
}

/* Returns a coordinate of any size, some zero. */
static float twin_coordinate(rng *r) {
  const uint32_t pick = rng_below(r, 8);
  return pick == 0 ? 0 : rng_sign(r) * (pick < 4 ? ldexpf(1, (int)rng_below(r, 60) - 30) : 1);
}

/* Returns a coordinate, or a power of two, or a zero of either sign, or a small whole number. */
static float twin_number(rng *r) {
  const uint32_t pick = rng_below(r, 16);
  const float sign = rng_below(r, 2) ? 1.0f : -1.0f;
  if (pick == 0) return sign * 0;
  if (pick == 1) return sign * ldexpf(1, (int)rng_below(r, 60) - 30);
  if (pick == 2) return sign * (float)rng_below(r, 5);
  return twin_coordinate(r);
}

/* Eight triangles and rays: corners [corner][axis], origins and directions, main axis first. */
typedef struct twin_eight {
  float p[3][3][8], o[3][8], d[3][8];
} twin_eight;

/* Fills all eight: triangles of any size, slivers, rays through corners, and values on a grid. */
static void twin_eight_of(rng *r, int round, twin_eight *e) {
  for (int k = 0; k < 8; k++) {
    const int kind = (round + k) % 4;
    float way[3], from[3];

    for (int i = 0; i < 3; i++) {
      from[i] = kind == 3 ? (float)rng_below(r, 9) - 4 : kind == 2 ? twin_number(r) : 4 * rng_sign(r);
      for (int corner = 0; corner < 3; corner++)
        e->p[corner][i][k] = kind == 3 ? (float)rng_below(r, 9) - 4 : kind == 2 ? twin_number(r) : rng_sign(r);
      if (kind == 1) e->p[2][i][k] = e->p[1][i][k] + 1e-4f * rng_sign(r);
    }
    for (int i = 0; i < 3; i++) {
      const float u = rng_unit(r), v = (1 - u) * rng_unit(r);
      const float inside = e->p[0][i][k] + u * (e->p[1][i][k] - e->p[0][i][k]) + v * (e->p[2][i][k] - e->p[0][i][k]);
      way[i] = (round % 3 ? inside : e->p[0][i][k]) - from[i];
    }

    /* The main axis comes first. */
    const int most = fabsf(way[0]) >= fabsf(way[1]) && fabsf(way[0]) >= fabsf(way[2]) ? 0
                     : fabsf(way[1]) >= fabsf(way[2])                                 ? 1
                                                                                      : 2;
    if (!(way[most] < 0 || way[most] > 0)) way[most] = 1;
    for (int i = 0; i < 3; i++) {
      e->o[i][k] = from[(most + i) % 3];
      e->d[i][k] = way[(most + i) % 3];
    }
    for (int corner = 0; corner < 3; corner++) {
      const float p[3] = {e->p[corner][0][k], e->p[corner][1][k], e->p[corner][2][k]};
      for (int i = 0; i < 3; i++) e->p[corner][i][k] = p[(most + i) % 3];
    }
  }
}

/* Returns the view of one of eight. */
static pk_exact_view twin_view_of(const twin_eight *e, int k) {
  pk_exact_view view;
  float p[9], o[3], d[3];

  for (int i = 0; i < 9; i++) p[i] = e->p[i / 3][i % 3][k];
  for (int i = 0; i < 3; i++) {
    o[i] = e->o[i][k];
    d[i] = e->d[i][k];
  }
  pk_exact_view_corners(&view, o, d, p, 1);
  return view;
}

/* Returns a ray of any size; each sixteenth may not be finite, or is empty. */
static pktrt_ray twin_ray(rng *r, uint32_t i) {
  static const float odd[] = {INFINITY, NAN, -INFINITY, FLT_MAX, 1e-40f, PKTRT_MAX_COORD};
  static const float times[] = {0, 1, 0.5f, -1, 2, NAN};
  pktrt_ray ray;

  for (int axis = 0; axis < 3; axis++) {
    ray.origin[axis] = twin_number(r);
    ray.direction[axis] = i % 5 == 1 ? ldexpf(twin_number(r), (int)rng_below(r, 120) - 60) : twin_number(r);
  }
  ray.tmin = i % 3 ? 0 : twin_number(r);
  ray.tmax = i % 4 ? INFINITY : fabsf(twin_number(r));
  ray.time = i % 2 ? rng_unit(r) : times[rng_below(r, 6)];
  if (i % 16 == 0) {
    float *const field[] = {&ray.origin[0], &ray.direction[1], &ray.tmin, &ray.tmax, &ray.direction[2]};
    *field[rng_below(r, 5)] = odd[rng_below(r, 6)];
  }
  return ray;
}

/* Fills two keys of an instance: turned and sheared in any way, or diagonal; of any scale. */
static void twin_keys(rng *r, bool diagonal, float keys[24]) {
  const int scale = rng_below(r, 4) ? 0 : (int)rng_below(r, 80) - 40;
  for (int i = 0; i < 24; i++) {
    const int row = i % 12 / 4, column = i % 4;
    float x = rng_sign(r);
    if (row == column) x = x < 0 ? x - 1 : x + 1;
    if (diagonal && row != column) x = 0;
    keys[i] = column == 3 ? twin_number(r) : ldexpf(x, scale);
  }
}

/* Returns a ray from around a place of twin_scene() to a point in it; place 0 are the trees of the scene. */
static pktrt_ray twin_ray_at(rng *r, uint32_t place, int scale) {
  float from[3], way[3];

  for (int axis = 0; axis < 3; axis++) {
    const float middle = axis ? 0 : 16 * (float)place, start = 3 * rng_sign(r);
    from[axis] = ldexpf(middle + start, scale);
    way[axis] = ldexpf(0.7f * rng_sign(r) - start, scale);
  }
  pktrt_ray ray = pktrt_make_ray(from, way);
  ray.time = twin_unit(r);
  return ray;
}

/* Returns a scene of random triangles, slivers among them, in three meshes of one to three keys; and of instances: two at rest
   and diagonal, two at rest that are turned, one that moves. All coordinates are times 2^scale. */
static pktrt_scene *twin_scene(pktrt_isa isa, int scale) {
  static float p[3 * 9 * TWIN_TRIANGLES];
  const pktrt_scene_desc desc = scene_desc_of(isa, 0);
  pktrt_scene *s = pktrt_scene_create(&desc);
  pktrt_mesh_desc body;
  uint32_t model = 0;
  rng r = rng_of(200);

  for (int i = 0; i < 3 * 9 * TWIN_TRIANGLES; i++) {
    const bool sliver = i / 9 % 4 == 1 && i % 9 >= 6;
    p[i] = sliver ? p[i - 3] + ldexpf(1e-3f * rng_sign(&r), scale) : ldexpf(rng_sign(&r), scale);
  }
  memset(&body, 0, sizeof body);
  body.positions = p;
  body.vertex_count = 3 * TWIN_TRIANGLES;
  body.triangle_count = TWIN_TRIANGLES;
  CHECK(pktrt_add_model(s, &body, 1, &model) == PKTRT_OK, "%s", pktrt_last_error(s));
  for (uint32_t keys = 1; keys <= 3; keys++) {
    body.key_count = keys;
    CHECK(pktrt_add_mesh(s, &body, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  }

  for (int i = 0; i < TWIN_PLACES; i++) {
    float keys[24];
    pktrt_instance_desc place;
    memset(&place, 0, sizeof place);
    twin_keys(&r, i < 2, keys);
    for (int k = 0; k < 24; k++) {
      const int row = k % 12 / 4, column = k % 4;
      if (column == 3) keys[k] = ldexpf(row ? 0 : 16 * (float)(1 + i), scale);
      else if (row != column) keys[k] = i < 2 ? 0 : 0.3f * rng_sign(&r);
      else keys[k] = 1 + rng_unit(&r);
    }
    place.model = model;
    place.key_count = i == TWIN_PLACES - 1 ? 2 : 1;
    place.transforms = keys;
    CHECK(pktrt_add_instance(s, &place, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  }
  CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  return s;
}

/* Each instruction set, with its short names. */
#ifdef PK_HAS_SCALAR
#define PK_STAMP PK_STAMP_SCALAR
#define TWIN_ISA PKTRT_ISA_SCALAR
#define TWIN_WIDTH 8
#define TWIN_TURNS 1
#ifdef PK_HAS_BASE
#define TWIN_WITH_FIT 0
#define TWIN_WITH_SHADE 0
#else
#define TWIN_WITH_FIT 1
#define TWIN_WITH_SHADE 1
#endif
#include "twins_stamp.h"
#undef PK_STAMP
#endif

#ifdef PK_HAS_BASE
#ifdef PK_HAS_SSE2
#define PK_STAMP PK_STAMP_SSE2
#define TWIN_ISA PKTRT_ISA_SSE2
#elif defined(PK_HAS_NEON)
#define PK_STAMP PK_STAMP_NEON
#define TWIN_ISA PKTRT_ISA_NEON
#else
#define PK_STAMP PK_STAMP_WASM
#define TWIN_ISA PKTRT_ISA_WASM
#endif
#define TWIN_WIDTH 8
#define TWIN_TURNS 2
#define TWIN_WITH_FIT 1
#define TWIN_WITH_SHADE 1
#include "twins_stamp.h"
#undef PK_STAMP
#endif

#ifdef PK_HAS_AVX2
#ifdef __clang__
#pragma clang attribute push(__attribute__((__target__("avx2,fma,bmi,bmi2,popcnt"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx2,fma,bmi,bmi2,popcnt")
#endif
#define PK_STAMP PK_STAMP_AVX2
#define TWIN_ISA PKTRT_ISA_AVX2
#define TWIN_WIDTH 8
#define TWIN_TURNS 1
#define TWIN_WITH_FIT 1
#define TWIN_WITH_SHADE 1
#include "twins_stamp.h"
#undef PK_STAMP
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

#ifdef PK_HAS_AVX512
#ifdef __clang__
#pragma clang attribute push( \
    __attribute__((__target__("avx512f,avx512dq,avx512bw,avx512vl,avx2,fma,bmi,bmi2,popcnt"))), apply_to = function)
#else
#pragma GCC push_options
#pragma GCC target("avx512f,avx512dq,avx512bw,avx512vl,avx2,fma,bmi,bmi2,popcnt")
#endif
#define PK_STAMP PK_STAMP_AVX512
#define TWIN_ISA PKTRT_ISA_AVX512
#define TWIN_WIDTH 16
#define TWIN_TURNS 1
#if defined(PK_HAS_SCALAR) || defined(PK_HAS_SSE2) || defined(PK_HAS_AVX2)
#define TWIN_WITH_FIT 0
#else
#define TWIN_WITH_FIT 1
#endif
#define TWIN_WITH_SHADE 1
#include "twins_stamp.h"
#undef PK_STAMP
#ifdef __clang__
#pragma clang attribute pop
#else
#pragma GCC pop_options
#endif
#endif

static void twins_of_kernels(void) {
#ifdef PK_HAS_SCALAR
  twins_all_scalar();
#endif
#ifdef PK_HAS_SSE2
  twins_all_sse2();
#endif
#ifdef PK_HAS_AVX2
  if (pktrt_isa_available(PKTRT_ISA_AVX2)) twins_all_avx2();
#endif
#ifdef PK_HAS_AVX512
  if (pktrt_isa_available(PKTRT_ISA_AVX512)) twins_all_avx512();
#endif
#ifdef PK_HAS_NEON
  twins_all_neon();
#endif
#ifdef PK_HAS_WASM
  twins_all_wasm();
#endif
}

#endif
