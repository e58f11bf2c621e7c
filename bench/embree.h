/* embree.h - what the benchmarks need of Embree 3: scenes of the same triangles, its layouts of rays, its ways to
   trace them.

   Embree gets its rays in its own layouts and with fresh hit records, and runs with denormals flushed, as its manual
   advises. */
#ifndef BENCH_EMBREE_H
#define BENCH_EMBREE_H

#include "bench.h"
#include "../pktrt.h"
#include "../examples/scenes.h"
#include <embree3/rtcore.h>
#ifdef __SSE2__
#include <xmmintrin.h>
#endif

enum { EMBREE_STREAM = 256 }; /* rays in a call of rtcIntersect1M or rtcIntersectNp */
enum { EMBREE_ARRAYS = 0 };   /* for a width: each field an array over all rays */

/* Embree's ray of any width is 12 fields of `width` words each, its ray with hit 20: one filler, one reader. */
typedef union embree_word {
  float f;
  uint32_t u;
} embree_word;
enum {
  EMBREE_RAY_WORDS = 12,
  EMBREE_RAY_HIT_WORDS = 20,
  EMBREE_TFAR = 8, /* fields */
  EMBREE_MASK = 9,
  EMBREE_PRIM = 17,
  EMBREE_GEOM = 18,
  EMBREE_INST = 19
};
typedef char embree_words_as_assumed[sizeof(struct RTCRay) == 4 * EMBREE_RAY_WORDS &&
                                             sizeof(struct RTCRayHit) == 4 * EMBREE_RAY_HIT_WORDS &&
                                             sizeof(struct RTCRay16) == 64 * EMBREE_RAY_WORDS &&
                                             sizeof(struct RTCRayHit8) == 32 * EMBREE_RAY_HIT_WORDS &&
                                             sizeof(struct RTCRayNp) == EMBREE_RAY_WORDS * sizeof(void *) &&
                                             sizeof(struct RTCRayHitNp) == EMBREE_RAY_HIT_WORDS * sizeof(void *)
                                         ? 1
                                         : -1];

typedef struct embree_way { /* how rays are handed over */
  unsigned width;           /* of packets: 1, 8 or 16 */
  bool stream;              /* of single rays, width 1, or out of arrays, width EMBREE_ARRAYS */
  enum RTCIntersectContextFlags flags;
} embree_way;

typedef struct embree_rays {
  const pktrt_ray *ray;
  size_t count;
  bool occlusion;
  embree_word *words; /* 20 for each ray, rounded up to 16 rays, aligned to 64 bytes */
} embree_rays;

/* Words from field to field. */
static unsigned embree_step(const embree_rays *r, unsigned width) {
  return width == EMBREE_ARRAYS ? (unsigned)(r->count + 15) / 16 * 16 : width;
}

static embree_word *embree_field(const embree_rays *r, unsigned width, size_t ray, unsigned field) {
  width = embree_step(r, width);
  const size_t words = r->occlusion ? EMBREE_RAY_WORDS : EMBREE_RAY_HIT_WORDS;
  return r->words + ray / width * (words * width) + (size_t)field * width + ray % width;
}

EX_UNUSED static void embree_fill(const embree_rays *r, unsigned width) {
  const size_t unit = width == EMBREE_ARRAYS ? 1 : width, padded = (r->count + unit - 1) / unit * unit;
  const size_t step = embree_step(r, width);
  for (size_t i = 0; i < padded; i++) {
    const pktrt_ray *from = &r->ray[i < r->count ? i : 0];
    const float values[EMBREE_MASK] = {from->origin[0], from->origin[1], from->origin[2], from->tmin,
        from->direction[0], from->direction[1], from->direction[2], from->time, from->tmax};
    embree_word *to = embree_field(r, width, i, 0);
    for (unsigned k = 0; k < EMBREE_MASK; k++) to[k * step].f = values[k];
    for (unsigned k = EMBREE_MASK; k < EMBREE_RAY_WORDS; k++) to[k * step].u = k == EMBREE_MASK ? 0xFFFFFFFFu : 0;
    if (r->occlusion) continue;
    for (unsigned k = EMBREE_PRIM; k <= EMBREE_INST; k++) to[k * step].u = RTC_INVALID_GEOMETRY_ID;
  }
}

/* Rays [first, end) of those laid out; first is a multiple of EMBREE_STREAM. */
static void embree_packets(
    RTCScene in, struct RTCIntersectContext *context, const embree_rays *r, unsigned width, size_t first, size_t end) {
  const size_t step = (r->occlusion ? EMBREE_RAY_WORDS : EMBREE_RAY_HIT_WORDS) * width, n = r->count;
  RTC_ALIGN(64) int all[16];  /* Embree wants them aligned */
  RTC_ALIGN(64) int last[16]; /* of the last packet: lanes beyond the last ray are off */
  for (size_t k = 0; k < 16; k++) all[k] = -1, last[k] = n / width * width + k < n ? -1 : 0;
  embree_word *p = r->words + first / width * step;
  for (size_t i = first; i < end; i += width, p += step) {
    const int *valid = i + width <= n ? all : last;
    void *packet = p;
    if (width == 1 && r->occlusion) rtcOccluded1(in, context, (struct RTCRay *)packet);
    else if (width == 1) rtcIntersect1(in, context, (struct RTCRayHit *)packet);
    else if (width == 8 && r->occlusion) rtcOccluded8(valid, in, context, (struct RTCRay8 *)packet);
    else if (width == 8) rtcIntersect8(valid, in, context, (struct RTCRayHit8 *)packet);
    else if (r->occlusion) rtcOccluded16(valid, in, context, (struct RTCRay16 *)packet);
    else rtcIntersect16(valid, in, context, (struct RTCRayHit16 *)packet);
  }
}

static void embree_streams(
    RTCScene in, struct RTCIntersectContext *context, const embree_rays *r, size_t first, size_t end) {
  for (size_t i = first; i < end; i += EMBREE_STREAM) {
    const unsigned n = (unsigned)(end - i < EMBREE_STREAM ? end - i : EMBREE_STREAM);
    if (r->occlusion)
      rtcOccluded1M(in, context, (struct RTCRay *)(void *)(r->words + i * EMBREE_RAY_WORDS), n, 4 * EMBREE_RAY_WORDS);
    else
      rtcIntersect1M(
          in, context, (struct RTCRayHit *)(void *)(r->words + i * EMBREE_RAY_HIT_WORDS), n, 4 * EMBREE_RAY_HIT_WORDS);
  }
}

/* The structures of pointers hold 12 and 20 of them, in the order of the fields. */
static void embree_array_streams(
    RTCScene in, struct RTCIntersectContext *context, const embree_rays *r, size_t first, size_t end) {
  void *at[EMBREE_RAY_HIT_WORDS];
  struct RTCRayNp rays;
  struct RTCRayHitNp hits;
  for (size_t i = first; i < end; i += EMBREE_STREAM) {
    const unsigned n = (unsigned)(end - i < EMBREE_STREAM ? end - i : EMBREE_STREAM);
    const unsigned fields = r->occlusion ? EMBREE_RAY_WORDS : EMBREE_RAY_HIT_WORDS;
    for (unsigned k = 0; k < fields; k++) at[k] = embree_field(r, EMBREE_ARRAYS, i, k);
    if (r->occlusion) memcpy(&rays, at, sizeof rays), rtcOccludedNp(in, context, &rays, n);
    else memcpy(&hits, at, sizeof hits), rtcIntersectNp(in, context, &hits, n);
  }
}

/* Traces rays [first, end) of those that embree_fill has laid out for this width. */
EX_UNUSED static void embree_trace(RTCScene in, const embree_way *way, const embree_rays *r, size_t first, size_t end) {
  struct RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = way->flags;
#ifdef __SSE2__
  const unsigned state = _mm_getcsr();
  _mm_setcsr(state | 0x8040u); /* flush denormals, read them as zero */
#endif
  if (way->stream && way->width == EMBREE_ARRAYS) embree_array_streams(in, &context, r, first, end);
  else if (way->stream) embree_streams(in, &context, r, first, end);
  else embree_packets(in, &context, r, way->width, first, end);
#ifdef __SSE2__
  _mm_setcsr(state);
#endif
}

/* Writes the nine floats of a ray one by one, as programs that make rays do. Not inlined, lest the compiler join the stores. */
#ifdef __GNUC__
__attribute__((noinline))
#endif
EX_UNUSED static void
embree_write(const pktrt_ray *from, volatile struct RTCRay *to) {
  to->org_x = from->origin[0];
  to->dir_x = from->direction[0];
  to->org_y = from->origin[1];
  to->dir_y = from->direction[1];
  to->org_z = from->origin[2];
  to->dir_z = from->direction[2];
  to->tnear = from->tmin;
  to->tfar = from->tmax;
  to->time = from->time;
}

/* Traces rays [first, end) by single calls, each written just before its call into one record, which is used again and
   again. Words are given what embree_answer reads for width 1. */
EX_UNUSED static void embree_trace_fresh(RTCScene in, const embree_rays *r, size_t first, size_t end) {
  struct RTCIntersectContext context;
  struct RTCRayHit one;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
  memset(&one, 0, sizeof one);
  one.ray.mask = 0xFFFFFFFFu;
  one.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#ifdef __SSE2__
  const unsigned state = _mm_getcsr();
  _mm_setcsr(state | 0x8040u); /* as in embree_trace */
#endif
  for (size_t i = first; i < end; i++) {
    embree_write(&r->ray[i], &one.ray);
    if (r->occlusion) {
      rtcOccluded1(in, &context, &one.ray);
    } else {
      one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
      rtcIntersect1(in, &context, &one);
      embree_field(r, 1, i, EMBREE_GEOM)->u = one.hit.geomID;
    }
    embree_field(r, 1, i, EMBREE_TFAR)->f = one.ray.tfar;
  }
#ifdef __SSE2__
  _mm_setcsr(state);
#endif
}

/* The answer for ray i as one number: its t, 0 if only occlusion was asked; infinity on a miss. */
EX_UNUSED static float embree_answer(const embree_rays *r, unsigned width, size_t i) {
  const float t = embree_field(r, width, i, EMBREE_TFAR)->f;
  if (r->occlusion) return t < 0 ? 0.0f : INFINITY; /* Embree sets it to -infinity */
  return embree_field(r, width, i, EMBREE_GEOM)->u == RTC_INVALID_GEOMETRY_ID ? INFINITY : t;
}

EX_UNUSED static void embree_add(RTCDevice device, RTCScene to, const scene_mesh *m) {
  const RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  const size_t floats = (size_t)m->vertex_count * 3, indices = (size_t)m->triangle_count * 3;
  rtcSetGeometryTimeStepCount(g, m->key_count);
  for (unsigned k = 0; k < m->key_count; k++) {
    void *at = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, k, RTC_FORMAT_FLOAT3, 12, m->vertex_count);
    if (!at) fatal("Embree: not enough memory");
    memcpy(at, m->positions + k * floats, floats * sizeof(float));
  }
  void *at = rtcSetNewGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, m->triangle_count);
  if (!at) fatal("Embree: not enough memory");
  memcpy(at, m->indices, indices * sizeof(uint32_t));
  rtcCommitGeometry(g);
  rtcAttachGeometry(to, g);
  rtcReleaseGeometry(g);
}

#endif /* BENCH_EMBREE_H */
