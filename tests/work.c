/* What culling saves: decisions about packets, told one by one and counted, and the order in which children are looked
   at. Work on larger scenes is in examples.c. */
#include "tree.h"

/* --- packets of the paper path --- */

/* Of n rays, packets of every size: none is cut where a batch ends. */
static void packets_are_whole(void) {
  enum { N = 1000 };
  static pktrt_ray ray[N];
  static pktrt_hit hit[N];
  world w = world_static(1);
  for (int isa = 0; isa < isa_count; isa++) {
    pktrt_scene *s = world_scene(&w, isas[isa], 0);
    make_rays(&w, s, RAYS_CAMERA, 1, 0, ray, N);
    for (uint32_t size = 1; size <= 256; size = size < 60 ? size + 19 : size + 5) {
      pktrt_query_desc q;
      pktrt_stats stats;
      memset(&q, 0, sizeof q), memset(&stats, 0, sizeof stats);
      q.path = PKTRT_PATH_PAPER, q.packet_size = size, q.stats = &stats;
      pktrt_intersect_ex(s, &q, ray, hit, N);
      CHECK(stats.by_type[0].packets == (N + size - 1) / size, "%s: %llu packets of %u among %d rays",
          pktrt_isa_string(isas[isa]), (unsigned long long)stats.by_type[0].packets, size, (int)N);
    }
    pktrt_scene_destroy(s);
  }
  world_free(&w);
}

/* --- the first active ray --- */

enum { MOST_NODES = 1 << 12 };
typedef struct first_rays {
  uint32_t first[MOST_NODES]; /* the first active ray of each node that is open */
  uint32_t entering;          /* that of the child entered last */
  uint64_t wrong, later, at_once;
} first_rays;

/* What is entered begins at the ray that entered it, and with that ray all its children begin. */
static void follow(void *user, const pktrt_event *e) {
  first_rays *f = user;
  if (!CHECK(e->kind == PKTRT_EVENT_LEAF || e->kind == PKTRT_EVENT_HIT || e->index < MOST_NODES)) return;
  switch (e->kind) {
  case PKTRT_EVENT_NODE:
    f->wrong += e->index && e->ray != f->entering;
    f->first[e->index] = e->ray;
    break;
  case PKTRT_EVENT_LEAF: f->wrong += e->ray != f->entering; break;
  case PKTRT_EVENT_FIRST_HIT: f->entering = e->ray, f->at_once++, f->wrong += e->ray != f->first[e->index]; break;
  case PKTRT_EVENT_LATER_HIT: f->entering = e->ray, f->later++, f->wrong += e->ray <= f->first[e->index]; break;
  case PKTRT_EVENT_INTERVAL_CULL:
  case PKTRT_EVENT_FRUSTUM_CULL:
  case PKTRT_EVENT_ALL_MISS: f->wrong += e->ray != f->first[e->index]; break;
  default: break;
  }
}

static void first_active_rays(void) {
  enum { N = 4096 };
  static pktrt_ray ray[N];
  static pktrt_hit hit[N];
  static first_rays f;
  static const ray_kind kinds[2] = {RAYS_CAMERA, RAYS_BUNDLES};
  world w = world_static(3);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  for (int k = 0; k < 2; k++) {
    pktrt_query_desc q;
    memset(&f, 0, sizeof f), memset(&q, 0, sizeof q);
    q.path = PKTRT_PATH_PAPER, q.trace = follow, q.user = &f, q.packet_size = 64;
    make_rays(&w, s, kinds[k], 5, 0, ray, N);
    pktrt_intersect_ex(s, &q, ray, hit, N);
    CHECK(f.wrong == 0, "%s: %llu children are looked at from another ray on", ray_kind_name[kinds[k]],
        (unsigned long long)f.wrong);
    CHECK(f.later > 20 && f.at_once > 100, "%s: both happen", ray_kind_name[kinds[k]]);
    say("%s: %llu children were entered by the first active ray, %llu by a later one", ray_kind_name[kinds[k]],
        (unsigned long long)f.at_once, (unsigned long long)f.later);
  }
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* --- depth: what lies behind a wall that all rays have hit --- */

static mesh wall_and_gravel(bool wall) { /* a triangle before 1000 small ones */
  mesh m = mesh_soup(1000, 0.05f, 3);
  const float over[9] = {-99, -99, 2, 99, -99, 2, 0, 99, 2};
  if (wall) memcpy(m.p, over, sizeof over), m.i[0] = 0, m.i[1] = 1, m.i[2] = 2;
  return m;
}

static pktrt_counts count_beam_of(const pktrt_scene *s, const pktrt_ray *ray, size_t n) {
  static pktrt_stats stats;
  static bool hidden[64];
  pktrt_query_desc q;
  memset(&q, 0, sizeof q), memset(&stats, 0, sizeof stats);
  q.path = PKTRT_PATH_SINGLE, q.stats = &stats;
  pktrt_occluded_ex(s, &q, ray, hidden, n);
  return stats.by_type[0];
}

static pktrt_counts of_gravel(bool wall, pktrt_path path) { /* parallel rays: no origin, and no frustum, in common */
  enum { N = 256 };
  static pktrt_ray ray[N];
  static pktrt_hit hit[N];
  static pktrt_stats stats;
  world w = world_of(wall_and_gravel(wall));
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  pktrt_query_desc q;
  memset(&q, 0, sizeof q), memset(&stats, 0, sizeof stats);
  for (int i = 0; i < N; i++)
    ray[i] = ray_of((float)(i % 16) / 16 - 0.5f, (float)(i / 16) / 16 - 0.5f, 3, 0.01f, 0.02f, -1);
  q.path = path, q.stats = &stats, q.packet_size = N;
  pktrt_intersect_ex(s, &q, ray, hit, N);
  CHECK(!wall || stats.by_type[0].hits == N);
  pktrt_scene_destroy(s);
  world_free(&w);
  return stats.by_type[0];
}

/* Rays meet nearly all boxes of a tree of triangles that cross each other everywhere, and none of these, so that as much is still
   to be done as can be: single rays answer as many do, for any hit and for the closest. */
static void boxes_of_all_overlap(void) {
  const uint32_t triangles = 70000; /* for so many nodes one above the other */
  enum { N = 64 };
  static pktrt_ray ray[N];
  static pktrt_hit hit[N];
  static bool hidden[N];
  mesh m = mesh_soup(triangles, 1, 3);
  for (uint32_t t = 0; t < triangles; t++) { /* thin, all along one diagonal of the cube, which is the box of each */
    rng r = rng_of(t);
    float *p = m.p + 9 * (size_t)t;
    for (int c = 0; c < 9; c++) p[c] = (c < 3 ? -1.0f : 1.0f) + 0.001f * rng_sign(&r);
  }
  world w = world_of(m);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  size_t wrong = 0, hits = 0;
  for (int i = 0; i < N; i++) ray[i] = ray_of(0.8f, -0.8f + 0.002f * (float)i, 3, 0.001f * (float)(i % 8), 0, -1);
  pktrt_occluded_n(s, ray, hidden, N);
  pktrt_intersect_n(s, ray, hit, N);
  for (int i = 0; i < N; i++) {
    pktrt_hit one;
    const bool found = pktrt_intersect(s, &ray[i], &one);
    wrong += !same_bits(&one, &hit[i], sizeof one) || found != hidden[i] || pktrt_occluded(s, &ray[i]) != found;
    hits += found;
  }
  const pktrt_counts c = count_beam_of(s, ray, N);
  say("%.0f nodes a ray, %zu of %d hit", (double)c.node_visits / N, hits, N);
  CHECK(c.node_visits > 1000 * (uint64_t)N, "nearly all nodes are opened");
  CHECK(wrong == 0 && hits < N, "%zu of %d are wrong, %zu hit", wrong, N, hits);
  pktrt_scene_destroy(s);
  world_free(&w);
}

static void depth_is_shortened(void) {
  const pktrt_counts c = of_gravel(true, PKTRT_PATH_PAPER), open = of_gravel(false, PKTRT_PATH_PAPER);
  const pktrt_counts fast = of_gravel(true, PKTRT_PATH_FAST), fast_open = of_gravel(false, PKTRT_PATH_FAST);
  say("behind the wall %llu children are culled by intervals, %llu ray by ray; without it %llu and %llu",
      (unsigned long long)c.interval_culls, (unsigned long long)c.ray_culls, (unsigned long long)open.interval_culls,
      (unsigned long long)open.ray_culls);
  CHECK(c.interval_culls >= 3 && c.ray_culls == 0, "nothing behind the wall is looked at ray by ray");
  CHECK(fast.ray_culls == 0 || !COUNTS_FAST, "nor by frusta: %llu children", (unsigned long long)fast.ray_culls);
  CHECK(open.node_visits > 4 * c.node_visits && (fast_open.node_visits > 2 * fast.node_visits || !COUNTS_FAST),
      "the control: without the wall it is");
}

/* --- the order of children: eight clusters at the corners of a cube, one leaf each, under one node --- */

enum { CLUSTERS = 8, IN_CLUSTER = 8 };
static float where(uint32_t cluster, uint32_t axis) { /* sums along diagonals differ, too */
  static const float half[3] = {1, 0.9f, 0.8f};
  return cluster >> axis & 1 ? half[axis] : -half[axis];
}

static mesh clusters(void) { /* of triangles across each axis: no ray along one passes between */
  mesh m = mesh_of(3 * CLUSTERS * IN_CLUSTER, CLUSTERS * IN_CLUSTER);
  for (uint32_t t = 0; t < m.nt; t++) {
    const uint32_t k = t % 3;
    for (uint32_t c = 0; c < 3; c++) {
      float *p = m.p + 9 * t + 3 * c;
      for (uint32_t a = 0; a < 3; a++) p[a] = where(t / IN_CLUSTER, a) + 0.01f * (float)(t % IN_CLUSTER);
      p[(k + 1) % 3] += c == 1 ? 0.3f : -0.1f, p[(k + 2) % 3] += c == 2 ? 0.3f : -0.1f;
      m.i[3 * t + c] = 3 * t + c;
    }
  }
  return m;
}

typedef struct leaves {
  const pktrt_scene *s;
  uint32_t cluster[64], n;
} leaves;
static void note_leaf(void *user, const pktrt_event *e) {
  leaves *l = user;
  uint32_t of, triangle;
  if (e->kind == PKTRT_EVENT_LEAF && CHECK(l->n < 64 && tree_lane(l->s, 0, e->index, 0, &of, &triangle)))
    l->cluster[l->n++] = triangle / IN_CLUSTER;
}

/* Rays of an octant, one at each cluster: leaves come in the order of their distance along the diagonal. */
static void diagonal_order(const pktrt_scene *s, uint32_t octant) {
  pktrt_ray ray[CLUSTERS];
  pktrt_hit hit[CLUSTERS];
  pktrt_query_desc q;
  leaves l = {s, {0}, 0};
  memset(&q, 0, sizeof q);
  q.path = PKTRT_PATH_PAPER, q.trace = note_leaf, q.user = &l, q.packet_size = CLUSTERS;
  for (uint32_t i = 0; i < CLUSTERS; i++) {
    ray[i] = ray_of(0, 0, 0, 0, 0, 0);
    for (uint32_t a = 0; a < 3; a++) {
      ray[i].direction[a] = octant >> a & 1 ? -1.0f : 1;
      ray[i].origin[a] = where(i, a) + 0.03f - 0.3f * ray[i].direction[a];
    }
  }
  pktrt_intersect_ex(s, &q, ray, hit, CLUSTERS);
  float before = -9;
  for (uint32_t i = 0; i < l.n; i++) {
    float along = 0;
    for (uint32_t a = 0; a < 3; a++) along += (octant >> a & 1 ? -1.0f : 1) * where(l.cluster[i], a);
    CHECK(along > before, "octant %u: leaf %u comes after one that is farther", octant, i);
    before = along;
  }
  CHECK(l.n == CLUSTERS, "octant %u: %u leaves", octant, l.n);
}

/* Rays along an axis that lean a little, so that they are of an octant, at a cluster with another one behind it. */
enum { BEAM = 64 };
static void make_beam(uint32_t octant, uint32_t axis, uint32_t line, float tmin, pktrt_ray *ray) {
  for (uint32_t i = 0; i < BEAM; i++) {
    ray[i] = ray_of(0, 0, 0, 0, 0, 0);
    ray[i].tmin = tmin;
    for (uint32_t a = 0; a < 3; a++) {
      const float sign = octant >> a & 1 ? -1.0f : 1;
      ray[i].origin[a] = a == axis ? -3 * sign : where(line, a) + 0.03f + 0.0001f * (float)i;
      ray[i].direction[a] = a == axis ? sign : 0.001f * sign;
    }
  }
}

static pktrt_counts count_beam(const pktrt_scene *s, pktrt_path path, const pktrt_ray *ray, pktrt_hit *hit) {
  static pktrt_stats stats;
  pktrt_query_desc q;
  memset(&q, 0, sizeof q), memset(&stats, 0, sizeof stats);
  q.path = path, q.stats = &stats;
  pktrt_intersect_ex(s, &q, ray, hit, BEAM);
  return stats.by_type[0];
}

/* They cost what they cost where they end before the one behind. (Streams test its triangles, but see none near enough.
   Rays that may look back are streams: frusta begin at origins.) */
static void axis_order(const pktrt_scene *s, uint32_t octant, uint32_t axis, pktrt_path path, bool stream) {
  pktrt_ray ray[BEAM];
  pktrt_hit hit[BEAM];
  for (uint32_t line = 0; line < 8; line++) {
    if (line >> axis & 1) continue;
    make_beam(octant, axis, line, stream ? -0.1f : 0, ray);
    const pktrt_counts c = count_beam(s, path, ray, hit);
    for (uint32_t i = 0; i < BEAM; i++) ray[i].tmax = hit[i].t + 0.5f;
    const pktrt_counts less = count_beam(s, path, ray, hit);
    CHECK(c.hits == BEAM && less.hits == BEAM && c.canonical_tests == less.canonical_tests &&
              (stream || c.triangle_tests == less.triangle_tests),
        "path %d, octant %u, axis %u: %llu and %llu tests, not %llu and %llu", (int)path, octant, axis,
        (unsigned long long)c.triangle_tests, (unsigned long long)c.canonical_tests,
        (unsigned long long)less.triangle_tests, (unsigned long long)less.canonical_tests);
  }
}

static void order_of_children(void) {
  world w = world_of(clusters());
  for (int isa = 0; isa < isa_count; isa++) {
    pktrt_scene *s = world_scene(&w, isas[isa], 0);
    CHECK(tree_groups(s) == 1 && tree_children(s, 0, 0) == 0xFF, "one node, eight leaves");
    for (uint32_t octant = 0; octant < 8; octant++) {
      diagonal_order(s, octant);
      for (uint32_t axis = 0; axis < 3; axis++) {
        if (has_frusta(isas[isa])) axis_order(s, octant, axis, PKTRT_PATH_FAST, false);
        axis_order(s, octant, axis, PKTRT_PATH_FAST, true);
        axis_order(s, octant, axis, PKTRT_PATH_PAPER, false);
        axis_order(s, octant, axis, PKTRT_PATH_SINGLE, false);
      }
    }
    pktrt_scene_destroy(s);
  }
  world_free(&w);
}

void suite_work(void) {
  run("packets of the paper path hold as many rays as was asked for, wherever batches end", packets_are_whole);
  run("children are looked at from the packet's first active ray on", first_active_rays);
  run("what lies behind a hit of all rays is culled at once", depth_is_shortened);
  run("single rays that meet all boxes of a tree and no triangle answer as many do", boxes_of_all_overlap);
  run("children come from near to far along every axis, in every octant, on every path", order_of_children);
}
