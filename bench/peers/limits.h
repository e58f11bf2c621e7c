/* limits.h - part of peers.c: how near the kernels are to their limit, which is the time of their tests alone;
   what settling in double costs, and what a test that loses no ray costs. The kernels' tests are those of
   limits_stamp.h, which pktrt.h stamps with its own.

   Of each kind of rays an eighth is traced again and counted; tests times their cost in the first cache, over the time
   of the rays, is the share. What is missing to 1 is misses of caches and branches, stacks, setting up, resolving,
   storing.

   Contents: kernels, counting, costs, part, race. */
#ifndef PEERS_LIMITS_H
#define PEERS_LIMITS_H

#include "race.h"
#include "rays.h"
#include "report.h"
#include "scenes.h"

/* >>kernels -------------------------------------------------------------------------------------------------------- */

static const limit_set *limits_of(pktrt_isa isa) {
  switch (isa) {
#ifdef PK_HAS_SSE2
  case PKTRT_ISA_SSE2: return &limit_tests_sse2;
#endif
#ifdef PK_HAS_AVX2
  case PKTRT_ISA_AVX2: return &limit_tests_avx2;
#endif
#ifdef PK_HAS_AVX512
  case PKTRT_ISA_AVX512: return &limit_tests_avx512;
#endif
#ifdef PK_HAS_NEON
  case PKTRT_ISA_NEON: return &limit_tests_neon;
#endif
#ifdef PK_HAS_SCALAR
  case PKTRT_ISA_SCALAR: return &limit_tests_scalar;
#endif
  default: return NULL;
  }
}

/* >>counting ------------------------------------------------------------------------------------------------------- */

static struct { /* what stands in for the kernels of a scene */
  const limit_set *set;
  tally t;
  char *samples;
} counted;

static void walk_instead(const pk_query *call, pk_batch *b, uint32_t begin, uint32_t end) {
  (void)begin; /* 0: no instances here */
  counted.set->walk(call->scene, b, end, call->occlusion, &counted.t, counted.samples);
}

/* Runs of rays from all over the set; how many there are in them. `library`: by pktrt's own counts. */
static size_t trace_some(const pktrt_scene *world, const job *j, pktrt_stats *library) {
  enum { RUN = 4096, STEP = 8 * RUN };
  pktrt_query_desc desc;
  size_t rays = 0;
  memset(&desc, 0, sizeof desc);
  desc.stats = library;
  for (size_t i = 0, n; i < j->r.count; i += STEP, rays += n) {
    n = j->r.count - i < RUN ? j->r.count - i : RUN;
    if (j->occlusion) pktrt_occluded_ex(world, &desc, j->r.ray + i, j->occluded, n);
    else pktrt_intersect_ex(world, &desc, j->r.ray + i, j->hit, n);
  }
  return rays;
}

static size_t count_tests(pktrt_scene *world, const job *j) {
  const pk_kernel_table *const own = world->kernels;
  static pktrt_stats library;
  memset(&counted.t, 0, sizeof counted.t);
  memset(&library, 0, sizeof library);
  const size_t rays = trace_some(world, j, &library);
  counted.t.stride = rays / LIMIT_SAMPLES;
  pk_kernel_table kernels = *own;
  kernels.trace = walk_instead, world->kernels = &kernels;
  trace_some(world, j, NULL);
  world->kernels = own;
  const double nodes = (double)(counted.t.packet.node_visits + counted.t.stream.node_visits),
               theirs = (double)library.by_type[0].node_visits;
  if (fabs(nodes - theirs) > 0.01 * theirs)
    printf("  note: limits_stamp.h opens %.0f nodes, pktrt %.0f: it is out of date\n", nodes, theirs);
  return rays;
}

/* >>costs ---------------------------------------------------------------------------------------------------------- */

/* Seconds of a test, over all samples: the best of some goes. */
static double cost_of(const pktrt_scene *world, bool occlusion, limit_test test) {
  enum { TRIES = 9 };
  double sum = 0, tests = 0;
  for (size_t s = 0; s < 2 * LIMIT_SAMPLES; s++) {
    if (s / 2 >= counted.t.kept[s % 2]) continue;
    void *sample = counted.samples + s * counted.set->sample_bytes;
    double best = HUGE_VAL, done = 0;
    for (int i = 0; i < TRIES; i++) {
      const double start = cpu_seconds();
      done = (double)counted.set->go(world, sample, occlusion, test);
      best = fmin(best, cpu_seconds() - start);
    }
    if (done > 0) sum += best, tests += done;
  }
  return tests > 0 ? sum / tests : 0;
}

/* Triangles to a block, on average over the scene: pktrt counts rays against triangles. */
static double occupancy(const pktrt_scene *world) {
  const pk_bvh *bvh = &world->bvhs[0];
  return (double)bvh->triangle_count / (double)bvh->block_count;
}

/* >>part ----------------------------------------------------------------------------------------------------------- */

static const char *const limit_names[LIMIT_TESTS] = {"packet node", "packet box", "packet block", "packet triangle",
    "stream node", "stream children", "stream block", "settle", "settle 8", "plain triangle", "plain block"};

typedef struct limit_share { /* of the time of a query */
  double packets, streams, settling, watertight;
} limit_share;

/* Of rays that take so many seconds. */
static limit_share share_of(const double number[LIMIT_TESTS], const double cost[LIMIT_TESTS], double seconds) {
  limit_share s;
  memset(&s, 0, sizeof s);
  for (int i = LIMIT_NODE; i <= LIMIT_TRIANGLE; i++) s.packets += number[i] * cost[i] / seconds;
  for (int i = LIMIT_STREAM_NODE; i <= LIMIT_LEAF; i++) s.streams += number[i] * cost[i] / seconds;
  s.settling = (number[LIMIT_SETTLE] * cost[LIMIT_SETTLE] + number[LIMIT_SETTLE8] * cost[LIMIT_SETTLE8]) / seconds;
  s.watertight = (number[LIMIT_TRIANGLE] * (cost[LIMIT_TRIANGLE] - cost[LIMIT_PLAIN_TRIANGLE]) +
                     number[LIMIT_LEAF] * (cost[LIMIT_LEAF] - cost[LIMIT_PLAIN_LEAF])) /
                 seconds;
  return s;
}

static void find_costs(const pktrt_scene *world, bool occlusion, double cost[LIMIT_TESTS]) {
  for (int i = 0; i < LIMIT_TESTS; i++) cost[i] = cost_of(world, occlusion, (limit_test)i);
  cost[LIMIT_STREAM_NODE] = fmax(cost[LIMIT_STREAM_NODE] - 2 * cost[LIMIT_SLABS], 0); /* which two rays went through */
  cost[LIMIT_SETTLE8] = fmin(cost[LIMIT_SETTLE8], cost[LIMIT_SETTLE]); /* of one ray of eight: the most it can be */
}

static void find_numbers(const pktrt_scene *world, double number[LIMIT_TESTS]) {
  const tally *t = &counted.t;
  memset(number, 0, LIMIT_TESTS * sizeof *number);
  number[LIMIT_NODE] = (double)t->packet.node_visits, number[LIMIT_BOX] = (double)t->boxes;
  number[LIMIT_BLOCK] = (double)t->blocks, number[LIMIT_TRIANGLE] = (double)t->triangles;
  number[LIMIT_STREAM_NODE] = (double)t->stream.node_visits, number[LIMIT_SLABS] = (double)t->stream.box_tests / 8;
  number[LIMIT_LEAF] = (double)t->stream.triangle_tests / occupancy(world);
  number[LIMIT_SETTLE] = (double)t->stream.settlings, number[LIMIT_SETTLE8] = (double)t->packet.settlings;
}

static bool has_limits(const stage *g, const setting *how, const pair *p) {
  return g->of == BUILT_IN && how->share == 0 && !how->high && p->isa > PKTRT_ISA_SSE2 && p->ours->bvh_count == 1;
}

/* Of the rays in j, which took `seconds`. */
static void add_limits(
    report *to, const stage *g, const setting *how, const pair *p, const job *j, const char *what, double seconds) {
  if (!has_limits(g, how, p)) return;
  counted.set = limits_of(p->isa);
  counted.samples = (char *)take(2 * LIMIT_SAMPLES, counted.set->sample_bytes);
  const size_t rays = count_tests(p->ours, j);
  double number[LIMIT_TESTS], cost[LIMIT_TESTS];
  find_numbers(p->ours, number);
  find_costs(p->ours, j->occlusion, cost);
  free(counted.samples);
  const limit_share s = share_of(number, cost, seconds * (double)rays / (double)j->r.count);
  for (int i = 0; i < LIMIT_TESTS; i++) {
    const char *isa = pktrt_isa_string(p->isa);
    row *r = add_row(to, g, how->name, isa, what, "pktrt", limit_names[i], "ns");
    r->median = r->best = 1e9 * cost[i];
    r = add_row(to, g, how->name, isa, what, "pktrt", limit_names[i], "tests/ray");
    r->median = r->best = number[i] / (double)rays, r->rays = rays;
  }
  ratio_row(to, g, how, p, what, "tests", s.packets + s.streams, 0)->rays = rays;
  ratio_row(to, g, how, p, what, "settling", s.settling, 0)->rays = rays;
  ratio_row(to, g, how, p, what, "watertight", s.watertight, 0)->rays = rays;
  printf("  %-18s %-6s limit: tests %.0f%% of the time (packets %.0f%%, streams %.0f%%), settling %.2f%%, watertight "
         "%.1f%%\n",
      what, pktrt_isa_string(p->isa), 1e2 * (s.packets + s.streams), 1e2 * s.packets, 1e2 * s.streams, 1e2 * s.settling,
      1e2 * s.watertight);
}

/* >>race ----------------------------------------------------------------------------------------------------------- */

/* All kinds of rays of a stage that is built. Returns for how many rays pktrt contradicts itself. */
static size_t race(report *to, const options *o, const stage *g, const setting *how, const pair *pairs, unsigned count,
    sources *s, job *j) {
  static figures f;
  size_t wrong = 0;
  make_sources(g, pairs[0].ours, rays_across(o, how), how->share > 0 && !how->refit, s);
  for (int i = 0; i < KINDS; i++) {
    const kind k = (kind)i;
    if (!(o->kinds & BIT(k))) continue;
    make_kind(g, pairs[0].ours, k, s, &j->r);
    j->occlusion = kind_occlusion(k);
    if (j->r.count == 0) continue;
    measure(pairs, count, j, o, f);
    compare_hits(g, pairs, count, j, f);
    wrong += contradictions(count, j);
    for (unsigned p = 0; p < count; p++) {
      add_figures(to, g, how, pairs, p, count, k, j->r.count, f);
      add_limits(to, g, how, &pairs[p], j, kind_names[k], f[p][0].best);
    }
  }
  return wrong;
}

#endif /* PEERS_LIMITS_H */
