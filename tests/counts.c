/* Counters against brute force: what rays that hit nothing have to look at, ray by ray over the whole tree; and packets at a
   root whose children are placed so that it is known what becomes of each. */
#include "tree.h"

enum { RAYS = 512 };

/* Rays that end half-way to what they would hit, and pass no box so near that rounding decides. */
static uint32_t missing_rays(const world *w, const pktrt_scene *s, uint64_t seed, pktrt_ray *rays, tree_work *work) {
  rng r = rng_of(seed);
  uint32_t n = 0;
  for (int tries = 0; tries < 100000 && n < RAYS; tries++) {
    pktrt_ray ray;
    pktrt_hit hit;
    memset(&ray, 0, sizeof ray);
    random_point(w, &r, 1.5f, ray.origin);
    for (int a = 0; a < 3; a++) ray.direction[a] = rng_sign(&r);
    ray.time = rng_unit(&r), ray.tmax = INFINITY;
    if (pktrt_intersect(s, &ray, &hit)) ray.tmax = 0.5f * hit.t;
    work[n] = tree_work_of(s, &ray, true);
    if (!work[n].unsure) rays[n++] = ray;
  }
  return n;
}

static void counts_of_misses(void) {
  static pktrt_ray rays[RAYS];
  static tree_work work[RAYS];
  static pktrt_hit hits[RAYS];
  static bool occluded[RAYS];
  for (int moves = 0; moves < 2; moves++) {
    world w = moves ? world_moving(3) : world_static(3);
    for (int k = 0; k < isa_count; k++) {
      pktrt_scene *s = world_scene(&w, isas[k], 0);
      tree_work all[2]; /* the paper's path does not ask first whether a ray meets what moves */
      const uint32_t n = missing_rays(&w, s, 7, rays, work);
      CHECK(n == RAYS, "%u rays", (unsigned)n);
      memset(all, 0, sizeof all);
      for (uint32_t i = 0; i < 2 * n; i++) {
        const tree_work one = i < n ? work[i] : tree_work_of(s, &rays[i - n], false);
        all[i / n].nodes += one.nodes, all[i / n].boxes += one.boxes, all[i / n].triangles += one.triangles;
      }
      for (int path = COUNTS_FAST ? PKTRT_PATH_FAST : PKTRT_PATH_PAPER; path <= PKTRT_PATH_SINGLE; path++) {
        for (int any = 0; any < 2; any++) {
          static pktrt_stats stats;
          pktrt_query_desc q;
          memset(&q, 0, sizeof q), memset(&stats, 0, sizeof stats);
          q.path = (pktrt_path)path, q.packet_size = 1, q.stats = &stats;
          if (any) pktrt_occluded_ex(s, &q, rays, occluded, n);
          else pktrt_intersect_ex(s, &q, rays, hits, n);
          const pktrt_counts *c = &stats.by_type[0];
          const bool paper = path == PKTRT_PATH_PAPER;
          const uint64_t nodes = all[paper].nodes, boxes = all[paper].boxes, triangles = all[paper].triangles;
          const char *isa = pktrt_isa_string(isas[k]), *what = moves ? "moving" : "at rest";
          CHECK(
              c->rays == n && c->hits == 0, "%s, %s, path %d: %llu rays", isa, what, path, (unsigned long long)c->rays);
          CHECK(c->box_tests == boxes && c->triangle_tests == triangles,
              "%s, %s, path %d, any %d: %llu boxes, not %llu; %llu triangles, not %llu", isa, what, path, any,
              (unsigned long long)c->box_tests, (unsigned long long)boxes, (unsigned long long)c->triangle_tests,
              (unsigned long long)triangles);
          if (path == PKTRT_PATH_FAST) /* streams share nodes: fewer, but a stream holds 64 rays */
            CHECK(c->node_visits < nodes && c->node_visits > nodes / 64 && c->packets < n, "%s: streams", isa);
          else
            CHECK(c->node_visits == nodes && c->packets == n, "%s, %s, path %d: %llu nodes, not %llu", isa, what, path,
                (unsigned long long)c->node_visits, (unsigned long long)nodes);
          CHECK(c->vector_box_tests == (paper ? boxes : 0) && c->vector_triangle_tests == (paper ? triangles : 0),
              "%s, path %d: vectors", isa, path);
          CHECK(c->first_hits + c->later_hits + c->ray_culls + c->interval_culls + c->frustum_culls ==
                    (paper ? boxes : 0),
              "%s, path %d: culls", isa, path);
        }
      }
      say("%s, %s: %.1f nodes, %.1f boxes, %.1f triangles a ray", pktrt_isa_string(isas[k]),
          moves ? "moving" : "at rest", (double)all[0].nodes / n, (double)all[0].boxes / n,
          (double)all[0].triangles / n);
      pktrt_scene_destroy(s);
    }
    world_free(&w);
  }
}

/* A bundle of 64 rays along z, and flat clusters of eight triangles each: in front of all rays, between them, beside them. Each
   is a child of the root. */
static mesh cluster(float x, float y, float size) {
  mesh m = mesh_of(24, 8);
  for (uint32_t t = 0; t < 8; t++) {
    const float z = 10 + 0.01f * (float)t;
    const float p[9] = {x - size, y - size, z, x + size, y - size, z, x, y + size, z};
    memcpy(m.p + 9 * t, p, sizeof p);
    for (uint32_t c = 0; c < 3; c++) m.i[3 * t + c] = 3 * t + c;
  }
  return m;
}

static void counts_of_packets(void) {
  for (int k = 0; k < isa_count; k++) {
    for (uint32_t between = 0; between < 3; between++) {
      for (uint32_t beside = 0; beside < 5; beside++) {
        pktrt_scene_desc desc = scene_desc_of(isas[k], 0);
        pktrt_scene *s = pktrt_scene_create(&desc);
        pktrt_ray rays[64];
        pktrt_hit hits[64];
        static pktrt_stats stats;
        pktrt_query_desc q;
        const uint32_t children = 1 + between + beside;
        for (uint32_t i = 0; i < children; i++) { /* the first one is far behind, so that no node is saved */
          mesh m = i == 0         ? cluster(0.5f, 0.5f, 0.02f)
                   : i <= between ? cluster(0.5f + 2 * (float)i, 0.5f, 0.02f)
                                  : cluster(1000.0f * (float)i, 3000, 1);
          CHECK(mesh_add(s, &m, NULL) == PKTRT_OK);
          mesh_free(&m);
        }
        CHECK(pktrt_commit(s) == PKTRT_OK);
        for (int i = 0; i < 64; i++) rays[i] = ray_of((float)(i % 8), (float)(i / 8), 0, 0, 0, 1);
        memset(&q, 0, sizeof q), memset(&stats, 0, sizeof stats);
        q.stats = &stats;
        pktrt_intersect_ex(s, &q, rays, hits, 64);
        const pktrt_counts *c = &stats.by_type[0];
        uint32_t root = 0;
        for (uint32_t b = tree_children(s, 0, 0); b; b &= b - 1) root++;
        if (!CHECK(root == children, "the root has %u children, not %u", root, children)) continue;
        const char *isa = pktrt_isa_string(isas[k]);
        CHECK(c->rays == 64 && c->packets == 1 && c->node_visits == 1 && c->hits == 0, "%s: one node, once", isa);
        const bool planes = has_frusta(isas[k]); /* without, each ray tests each child */
        const uint32_t tested = 1 + between + (planes ? 0 : beside);
        CHECK(c->frustum_culls == (planes ? beside : 0), "%s: %llu of %u beside are culled", isa,
            (unsigned long long)c->frustum_culls, beside);
        CHECK(c->ray_culls == (planes ? tested : 0) && c->box_tests == 64 * tested,
            "%s: %llu of %u are missed, %llu boxes", isa, (unsigned long long)c->ray_culls, tested,
            (unsigned long long)c->box_tests);
        CHECK(c->triangle_tests == 0 && c->fallbacks == 0 && c->triangle_culls == 0, "%s: no leaf is reached", isa);
        pktrt_scene_destroy(s);
      }
    }
  }
}

void suite_counts(void) {
  run("what rays that miss look at is counted as brute force counts it, on all paths", counts_of_misses);
  if (COUNTS_FAST) run("a packet's culls at a root are those that the children's places ask for", counts_of_packets);
}
