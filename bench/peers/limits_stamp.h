/* limits_stamp.h - what traversal would cost if it were nothing but its tests: how many a kind of rays makes, and the
   kernels' own tests in loops over data that stays in the first cache. No include guard: pktrt.h includes it once for
   each instruction set (PK_ALSO_STAMP). For scenes of one BVH at rest.

   pktrt_stats does not tell packets from streams, and queries that count do without a shortcut of those that do not.
   Hence `walk`: pk_frustum_template and pk_drive_fast once more, with a book for each. limits.h checks that they
   open as many nodes as the library. */
#define KENSLER_ALONE
#include "../kensler_stamp.h"
#ifndef LIMITS_STAMP_H /* the same for all stamps */
#define LIMITS_STAMP_H

/* Packets and as many streams, tests of each, times they are gone through. */
enum { LIMIT_SAMPLES = 8, LIMIT_EACH = 16, LIMIT_GOES = 32 };

typedef struct tally {
  pktrt_counts packet, stream;       /* tests of frustum packets, and of all that is none */
  uint64_t boxes, blocks, triangles; /* of packets: vectors of rays against a box; blocks; vectors against a triangle */
  size_t seen[2], kept[2], stride;   /* of packets, of streams: rays, samples; rays from one sample to the next */
} tally;

/* Packets: opening a node; a vector of rays and a box; culling a block's triangles; a vector of rays and a triangle.
   Streams: opening a node; a ray and its children; a ray and a block. One ray, or eight, settled in double. Kensler and
   Shirley's test, fused, instead of the exact one: in packets, in streams. */
typedef enum limit_test {
  LIMIT_NODE,
  LIMIT_BOX,
  LIMIT_BLOCK,
  LIMIT_TRIANGLE,
  LIMIT_STREAM_NODE,
  LIMIT_SLABS,
  LIMIT_LEAF,
  LIMIT_SETTLE,
  LIMIT_SETTLE8,
  LIMIT_PLAIN_TRIANGLE,
  LIMIT_PLAIN_LEAF,
  LIMIT_TESTS
} limit_test;

typedef struct limit_set {
  size_t sample_bytes;
  void (*walk)(const pktrt_scene *, pk_batch *, uint32_t n, bool occlusion, tally *, void *samples);
  uint64_t (*go)(const pktrt_scene *, void *sample, bool occlusion, limit_test); /* returns how many tests */
} limit_set;

typedef struct limit_step { /* of a packet on its way: a node, a box or a block, and the rays that come to it */
  uint32_t ref, lanes;      /* lanes: triangles of a block that reach into the packet */
  const float *plane;
  uint64_t mask;
} limit_step;
#endif

#define limit_stream_leaf PK_NAME(limit_stream_leaf)
#define limit_closest_block PK_NAME(limit_closest_block)
#define limit_close_sample PK_NAME(limit_close_sample)
#define limit_go PK_NAME(limit_go)
#define limit_go_packet PK_NAME(limit_go_packet)
#define limit_go_settle PK_NAME(limit_go_settle)
#define limit_go_stream PK_NAME(limit_go_stream)
#define limit_go_triangles PK_NAME(limit_go_triangles)
#define limit_next_sample PK_NAME(limit_next_sample)
#define limit_note_step PK_NAME(limit_note_step)
#define limit_plain_triangle PK_NAME(limit_plain_triangle)
#define limit_sample PK_NAME(limit_sample)
#define limit_tests PK_NAME(limit_tests)
#define limit_vectors PK_NAME(limit_vectors)
#define limit_walk PK_NAME(limit_walk)
#define limit_walk_64 PK_NAME(limit_walk_64)
#define limit_walk_block PK_NAME(limit_walk_block)
#define limit_walk_frustum PK_NAME(limit_walk_frustum)
#define limit_walk_packet PK_NAME(limit_walk_packet)

typedef struct limit_sample { /* a packet, with some of its steps; a stream has none */
  pk_frustum f;
  pk_batch b; /* as it was in the end */
  limit_step node[LIMIT_EACH], box[LIMIT_EACH], block[LIMIT_EACH];
  pk_frustum_corners corners[LIMIT_EACH]; /* of the blocks */
  uint32_t nodes, boxes, blocks, octant, rays;
  uint8_t list[64];                /* rays of one octant */
  float depth_hi[64], sure_hi[64]; /* before anything was hit */
} limit_sample;

/* --- counting --- */

VOP uint64_t limit_vectors(uint64_t mask) { /* that hold its rays */
  uint64_t n = 0;
  for (uint32_t i = 0; i < 64; i += FRUSTUM_WIDTH) n += (mask >> i & (((uint64_t)1 << FRUSTUM_WIDTH) - 1)) != 0;
  return n;
}

VOP void limit_note_step(limit_step *at, uint32_t *n, uint32_t ref, const float *plane, uint64_t mask) {
  if (*n == LIMIT_EACH) return;
  at[*n].ref = ref, at[*n].plane = plane, at[*n].mask = mask;
  ++*n;
}

/* As pk_frustum_leaf. */
static uint64_t limit_walk_block(pk_frustum *f, const pk_bvh_segment *seg, pk_batch *b, uint32_t ref, uint64_t mask,
    bool occlusion, tally *t, limit_sample *s) {
  const uint64_t before = t->packet.triangle_tests;
  const uint64_t hit = pk_frustum_leaf(f, seg, b, ref & ~PK_LEAF, mask, occlusion, &t->packet);
  t->blocks++;
  t->triangles += (t->packet.triangle_tests - before) * limit_vectors(mask) / pk_popcount(mask);
  if (s) limit_note_step(s->block, &s->blocks, ref & ~PK_LEAF, NULL, mask);
  return hit;
}

/* As pk_frustum_template. */
static void limit_walk_frustum(
    pk_frustum *f, const pk_bvh_segment *seg, pk_batch *b, uint64_t mask, bool occlusion, tally *t, limit_sample *s) {
  const pk_variant packet = pk_variant_of(occlusion, false, true, &t->packet);
  const pk_variant stream = pk_variant_of(occlusion, false, true, &t->stream);
  pk_frustum_stack stack;
  uint64_t alive = mask, hit = 0;
  uint32_t ref = 0;
  stack.n = 0;
  for (;;) {
    if (pk_frustum_has_few(f, mask, ref, occlusion, false)) {
      hit = pk_stream_traverse(seg, b, f->list, mask, ref, stream);
    } else if (ref & PK_LEAF) {
      hit = limit_walk_block(f, seg, b, ref, mask, occlusion, t, s);
    } else {
      if (s) limit_note_step(s->node, &s->nodes, ref, NULL, mask);
      pk_frustum_open_node(f, seg, ref, mask, &stack, packet);
    }
    if (hit) {
      if (occlusion && !(alive &= ~hit)) return;
      pk_frustum_update_depth(f, b, alive);
      hit = 0;
    }
    do {
      if (!stack.n) return;
      const pk_frustum_entry *e = &stack.entries[--stack.n];
      const pk_frustum_parent *parent = &stack.parents[e->parent];
      mask = e->w > f->wmax ? 0 : parent->mask & alive, ref = e->ref;
      if (!mask || e->whole) continue;
      const float *plane = parent->planes + e->child;
      if (s) limit_note_step(s->box, &s->boxes, 0, plane, mask);
      t->boxes += limit_vectors(mask);
      mask = pk_frustum_test_child(f, b, plane, plane, mask, false, false);
    } while (!mask);
  }
}

/* The sample to fill, when one is due. */
static limit_sample *limit_next_sample(tally *t, void *samples, bool stream, uint32_t rays) {
  t->seen[stream] += rays;
  if (t->kept[stream] == LIMIT_SAMPLES || t->seen[stream] < t->kept[stream] * t->stride) return NULL;
  limit_sample *s = (limit_sample *)samples + 2 * t->kept[stream]++ + stream;
  memset(s, 0, sizeof *s);
  return s;
}

/* What is left of a sample when its rays are done. */
static void limit_close_sample(
    limit_sample *s, const pk_bvh_segment *seg, const pk_batch *b, uint64_t mask, uint32_t base) {
  s->b = *b;
  memset(s->b.bvh, 0, sizeof s->b.bvh);
  s->octant = b->octant[base + pk_lowest_bit(mask)];
  for (; mask; mask &= mask - 1) {
    const uint32_t r = base + pk_lowest_bit(mask);
    if (b->octant[r] == s->octant) s->list[s->rays++] = (uint8_t)r;
  }
  for (uint32_t i = 0; i < s->blocks; i++) {
    const pk_block *block = pk_segment_block(seg, s->block[i].ref, false);
    const float *k0 = &block->vertex[0][0][0];
    s->block[i].lanes = pk_frustum_cull_triangles(&s->f, k0, k0, false, &s->corners[i]) & pk_lanes_occupied(block->id);
  }
}

static void limit_walk_packet(
    const pktrt_scene *scene, pk_batch *b, uint32_t base, uint64_t mask, bool occlusion, tally *t, void *samples) {
  const pk_bvh_segment seg = pk_bvh_segment_of(scene->bvhs, 0, 0);
  limit_sample *s = limit_next_sample(t, samples, false, pk_popcount(mask));
  pk_frustum f;
  pk_frustum_setup(&f, scene, b, base, mask, occlusion);
  pk_batch_time_weights(b, base, 64, 1);
  t->packet.packets++;
  if (s) {
    s->f = f;
    memcpy(s->depth_hi, b->depth_hi + base, sizeof s->depth_hi);
    memcpy(s->sure_hi, b->sure_hi + base, sizeof s->sure_hi);
  }
  limit_walk_frustum(&f, &seg, b, mask, occlusion, t, s);
  if (s) limit_close_sample(s, &seg, b, mask, base);
}

/* As pk_drive_fast: those of [base, base + 64) that no packet takes. */
static uint64_t limit_walk_64(
    const pktrt_scene *scene, pk_batch *b, uint32_t base, uint32_t tries, bool occlusion, tally *t, void *samples) {
  uint64_t rest = b->valid[base / 64], packet;
  const bool one_way = rest && pk_drive_is_coherent(b, base, rest);
  while ((packet = pk_drive_next_packet(b, base, &rest, one_way, tries)) != 0)
    limit_walk_packet(scene, b, base, packet, occlusion, t, samples);
  return rest;
}

/* In place of pk_entry_trace, without resolve: of hits the caller is told only which rays have none, by which
   pk_query_run_batches decides how to sort the next ones. */
static void limit_walk(const pktrt_scene *scene, pk_batch *b, uint32_t n, bool occlusion, tally *t, void *samples) {
  const pk_bvh_segment seg = pk_bvh_segment_of(scene->bvhs, 0, 0);
  uint64_t left[PK_BATCH / 64];
  pk_batch_pad(b, n);
  memset(b->valid, 0, sizeof b->valid);
  memset(left, 0, sizeof left);
  for (uint32_t i = 0; i < n; i += FRUSTUM_WIDTH) b->valid[i / 64] |= (uint64_t)pk_batch_setup(scene, b, i) << i % 64;
  for (uint32_t base = 0, tries = 3; base < n; base += 64) {
    left[base / 64] = limit_walk_64(scene, b, base, tries, occlusion, t, samples);
    tries = left[base / 64] && left[base / 64] == b->valid[base / 64] ? 1 : 3; /* as pk_drive_fast does */
  }
  if (pk_batch_note_coherence(b, left, n)) {
    const pk_variant counted = pk_variant_of(occlusion, false, true, &t->stream);
    pk_drive_octants(scene, b, left, counted);
    for (uint32_t i = 0; i < PK_BATCH / 64; i++) {
      limit_sample *s = left[i] ? limit_next_sample(t, samples, true, pk_popcount(left[i])) : NULL;
      if (s) limit_close_sample(s, &seg, b, left[i], 64 * i);
    }
  }
  for (uint32_t i = 0; i < n && !occlusion; i++)
    if (b->slot[i] == PKTRT_NONE) b->id[i] = PKTRT_NONE;
}

/* --- tests in loops --- */

/* One triangle at rest against a vector of rays, by Kensler and Shirley's test, fused: kensler_rays, as wide as
   pk_frustum_test_triangle, with one origin for all where that has it. */
VOP void limit_plain_triangle(
    const pk_frustum *f, pk_batch *b, const float *k0, uint32_t r, uint32_t bits, pk_tri_common *tri) {
  float p[3], e0[3], e1[3];
  floatw n[3], d[3], o[3], i[3];
  UNROLL for (uint32_t a = 0; a < 3; a++) {
    p[a] = k0[8 * a], e0[a] = k0[24 + 8 * a] - p[a], e1[a] = p[a] - k0[48 + 8 * a];
    d[a] = fload(b->d[a] + r);
    o[a] = f->common ? fset(p[a] - b->o[a][f->first]) : fsub(fset(p[a]), fload(b->o[a] + r));
  }
  UNROLL for (uint32_t a = 0; a < 3; a++) {
    const uint32_t u = (a + 1) % 3, v = (a + 2) % 3;
    n[a] = fset(e0[u] * e1[v] - e0[v] * e1[u]);
    i[a] = ffms(o[u], d[v], fmul(o[v], d[u]));
  }
  const floatw zero = fset(0), det = ffma(n[0], d[0], ffma(n[1], d[1], fmul(n[2], d[2])));
  const floatw beta = ffma(fset(e1[0]), i[0], ffma(fset(e1[1]), i[1], fmul(fset(e1[2]), i[2])));
  const floatw gamma_ = ffma(fset(e0[0]), i[0], ffma(fset(e0[1]), i[1], fmul(fset(e0[2]), i[2])));
  const floatw alpha = fsub(fsub(det, beta), gamma_);
  bits &= ~fbits(fmand(flt(fmin_(alpha, fmin_(beta, gamma_)), zero), flt(zero, fmax_(alpha, fmax_(beta, gamma_)))));
  if (!bits) return;
  const floatw t = fdiv(ffma(n[0], o[0], ffma(n[1], o[1], fmul(n[2], o[2]))), det);
  bits &= fbits(fmand(flt(fload(b->tmin + r), t), flt(t, fload(b->t + r))));
  const maskw m = ffrom(bits);
  fstore_masked(b->t + r, m, t);
  fstore_masked_u32(b->id + r, m, tri->id);
  fstore_masked_u32(b->slot + r, m, tri->slot);
}

/* From the beginning, or what has been hit would have to be settled against itself. */
static uint64_t limit_go_triangles(limit_sample *s, const pk_bvh_segment *seg, const bool plain) {
  const uint32_t base = s->f.base;
  uint64_t tests = 0;
  memcpy(s->b.t + base, s->b.tmax + base, sizeof s->depth_hi);
  memcpy(s->b.depth_hi + base, s->depth_hi, sizeof s->depth_hi);
  memcpy(s->b.sure_hi + base, s->sure_hi, sizeof s->sure_hi);
  memset(s->b.id + base, 0, sizeof s->depth_hi);
  memset(s->b.slot + base, 0xFF, sizeof s->depth_hi);
  for (uint32_t i = 0; i < s->blocks; i++) {
    const limit_step *at = &s->block[i];
    const pk_block *block = pk_segment_block(seg, at->ref, false);
    const float *k0 = &block->vertex[0][0][0];
    for (uint32_t m = at->lanes; m; m &= m - 1) {
      const uint32_t lane = pk_lowest_bit(m);
      pk_tri_common tri;
      tri.id = block->id[lane], tri.slot = at->ref * 8 + lane, tri.planar = false;
      tri.counts = NULL;
      tri.error = s->corners[i].error[lane], tri.range = s->corners[i].range[lane], tri.far_ = s->corners[i].far_[lane];
      tests += limit_vectors(at->mask);
      if (!plain) pk_frustum_test_triangle(&s->f, seg, &s->b, &s->corners[i], lane, &tri, at->mask, false);
      for (uint32_t r = 0; plain && r < 64; r += FRUSTUM_WIDTH) {
        const uint32_t bits = (uint32_t)(at->mask >> r) & ((1u << FRUSTUM_WIDTH) - 1);
        if (bits) limit_plain_triangle(&s->f, &s->b, k0 + lane, base + r, bits, &tri);
      }
    }
  }
  return tests;
}

static uint64_t limit_go_packet(limit_sample *s, const pk_bvh_segment *seg, bool occlusion, limit_test test) {
  const pk_variant variant = pk_variant_of(occlusion, false, false, NULL);
  pk_frustum_stack stack;
  volatile uint64_t sink = 0;
  uint64_t tests = 0;
  if (test == LIMIT_NODE)
    for (; tests < s->nodes; tests++) {
      const limit_step *at = &s->node[tests];
      stack.n = 0;
      pk_frustum_open_node(&s->f, seg, at->ref, at->mask, &stack, variant);
      sink += stack.n;
    }
  if (test == LIMIT_BOX)
    for (uint32_t i = 0; i < s->boxes; i++) {
      const limit_step *at = &s->box[i];
      sink += pk_frustum_test_child(&s->f, &s->b, at->plane, at->plane, at->mask, false, false);
      tests += limit_vectors(at->mask);
    }
  if (test == LIMIT_BLOCK)
    for (; tests < s->blocks; tests++) {
      const float *k0 = &pk_segment_block(seg, s->block[tests].ref, false)->vertex[0][0][0];
      sink += pk_frustum_cull_triangles(&s->f, k0, k0, false, &s->corners[tests]);
    }
  (void)sink;
  return tests;
}

/* Traces the rays of mask through a block of a stream, one by one or, for occlusion, at once where vectors are registers. */
static void limit_stream_leaf(
    limit_sample *s, const pk_bvh_segment *seg, uint64_t mask, uint32_t block, const pk_variant variant) {
  if (PK_WITH_V8_REGISTERS && variant.occlusion && !variant.stats) {
    (void)pk_stream_any_block(seg, &s->b, s->list, mask, block, false);
    return;
  }
  for (; mask; mask &= mask - 1) (void)pk_tri_ray_block(seg, &s->b, s->list[pk_lowest_bit(mask)], NULL, block, variant);
}

static void limit_closest_block(limit_sample *s, const pk_bvh_segment *seg, uint64_t mask, uint32_t block) {
#if PK_WITH_V8_REGISTERS
  pk_stream_pending pending;
  pk_stream_closest_block(seg, &s->b, s->list, mask, block, &pending, false);
  pk_stream_record(seg, &s->b, s->list, &pending, false);
#else
  limit_stream_leaf(s, seg, mask, block, pk_variant_of(false, false, false, NULL));
#endif
}

/* Nodes and blocks from all over the scene: nothing here depends on what is hit. */
static uint64_t limit_go_stream(
    const pk_bvh *bvh, limit_sample *s, const pk_bvh_segment *seg, bool occlusion, limit_test test) {
  const pk_variant variant = pk_variant_of(occlusion, false, false, NULL);
  pk_stream_stack stack;
  const uint32_t few = s->rays < 2 ? s->rays : 2, n = test == LIMIT_STREAM_NODE ? few : s->rays;
  const uint64_t mask = n ? ~(uint64_t)0 >> (64 - n) : 0;
  for (uint32_t i = 0; n && i < LIMIT_EACH; i++) {
    const uint32_t node = (uint32_t)((uint64_t)i * bvh->node_count / LIMIT_EACH),
                   block = (uint32_t)((uint64_t)i * bvh->block_count / LIMIT_EACH);
    if (test <= LIMIT_SLABS) {
      stack.n = 0;
      pk_stream_open_node(seg, &s->b, s->list, mask, node, s->octant, &stack, variant);
    } else if (test == LIMIT_LEAF) {
      if (occlusion) limit_stream_leaf(s, seg, mask, block, variant);
      else limit_closest_block(s, seg, mask, block);
    } else {
      for (uint32_t k = 0; k < n; k++) kensler_block(seg, &s->b, s->list[k], block, false);
    }
  }
  return test == LIMIT_STREAM_NODE ? LIMIT_EACH : (uint64_t)LIMIT_EACH * n;
}

/* What was hit, against itself: both its triangle and the nearest are looked at. */
static uint64_t limit_go_settle(limit_sample *s, const pk_bvh_segment *seg, limit_test test) {
  uint64_t tests = 0;
  for (uint32_t k = 0; k < s->rays; k++) {
    const uint32_t r = s->list[k], slot = s->b.slot[r];
    uint32_t open = 1u << (r & 7);
    pk_tri_common tri;
    if (slot == PKTRT_NONE) continue;
    tri.id = s->b.id[r], tri.slot = slot, tri.planar = false;
    if (test == LIMIT_SETTLE) pk_exact_test(seg, &s->b, r, NULL, s->b.id[r], slot);
    else pk_frustum_exact_test8(seg, &s->b, r & ~7u, &open, &tri);
    tests++;
  }
  return tests;
}

static uint64_t limit_go(const pktrt_scene *scene, void *sample, bool occlusion, limit_test test) {
  limit_sample *s = (limit_sample *)sample;
  const pk_bvh_segment seg = pk_bvh_segment_of(scene->bvhs, 0, 0);
  uint64_t tests = 0;
  for (int i = 0; i < LIMIT_GOES; i++) switch (test) {
    case LIMIT_TRIANGLE:
    case LIMIT_PLAIN_TRIANGLE: tests += limit_go_triangles(s, &seg, test == LIMIT_PLAIN_TRIANGLE); break;
    case LIMIT_STREAM_NODE:
    case LIMIT_SLABS:
    case LIMIT_LEAF:
    case LIMIT_PLAIN_LEAF: tests += limit_go_stream(&scene->bvhs[0], s, &seg, occlusion, test); break;
    case LIMIT_SETTLE:
    case LIMIT_SETTLE8: tests += limit_go_settle(s, &seg, test); break;
    default: tests += limit_go_packet(s, &seg, occlusion, test);
    }
  return tests;
}

static const limit_set limit_tests = {sizeof(limit_sample), limit_walk, limit_go};
#undef KENSLER_ALONE
