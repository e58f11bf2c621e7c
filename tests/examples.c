/* The scenes of the examples: their triangles, and the work of all paths on them, as it was measured when everything
   that culls did so. What stops culling, and what culls more than it did, is noticed by its counts. */
#include "test.h"
#include "../examples/scenes.h"

enum { SIDE = 64, MANY = SIDE * SIDE, PATHS = PKTRT_PATH_SINGLE + 1, COUNTS = 8 };

static const struct example {
  const char *name;
  uint64_t triangles;
  uint32_t work[2][PATHS][COUNTS]; /* of rays of the camera and of mirrors; counts as below */
} examples[3] = {
    {"poolhall",
     318196,
     {{{3323, 0, 47242, 0, 0, 0, 3323, 605},
       {2975, 342617, 43330, 2790, 2682, 7370, 465, 8023},
       {40650, 0, 46022, 0, 0, 0, 0, 0}},
      {{7812, 0, 75115, 0, 0, 0, 1064, 772},
       {6433, 1156931, 77085, 6306, 5326, 400, 0, 34649},
       {44253, 0, 69995, 0, 0, 0, 0, 0}}}},
    {"conference",
     291194,
     {{{3065, 0, 55309, 0, 0, 0, 2367, 324},
       {2868, 341773, 66911, 2705, 2985, 6515, 817, 7682},
       {32438, 0, 58500, 0, 0, 0, 0, 0}},
      {{7770, 0, 96909, 0, 0, 0, 1048, 552},
       {6320, 1163982, 108767, 6470, 5233, 519, 0, 33870},
       {40964, 0, 100977, 0, 0, 0, 0, 0}}}},
    {"rtrt",
     84846,
     {{{2721, 0, 46976, 0, 0, 0, 2693, 200},
       {2456, 304575, 45284, 2385, 3210, 6173, 598, 4899},
       {30443, 0, 45795, 0, 0, 0, 0, 0}},
      {{7473, 0, 88516, 0, 0, 0, 521, 349},
       {5162, 963010, 93909, 5342, 5487, 695, 0, 25242},
       {32182, 0, 82726, 0, 0, 0, 0, 0}}}},
};

/* Of packets that frusta cull, and of lone rays, fewer counts tell something. */
static const struct counted {
  const char *name;
  size_t at;
  bool of[PATHS];
} counted[COUNTS] = {
    {"node visits", offsetof(pktrt_counts, node_visits), {true, true, true}},
    {"box tests", offsetof(pktrt_counts, box_tests), {false, true, false}},
    {"triangle tests", offsetof(pktrt_counts, triangle_tests), {true, true, true}},
    {"first hits", offsetof(pktrt_counts, first_hits), {true, true, true}},
    {"later hits", offsetof(pktrt_counts, later_hits), {true, true, true}},
    {"interval culls", offsetof(pktrt_counts, interval_culls), {true, true, true}},
    {"frustum culls", offsetof(pktrt_counts, frustum_culls), {true, true, true}},
    {"ray culls", offsetof(pktrt_counts, ray_culls), {true, true, true}},
};

static pktrt_scene *example(const struct example *e, scene *made) {
  const pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!CHECK(s != NULL) || !CHECK(scene_make(e->name, made))) abort();
  CHECK(scene_add(s, made) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  return s;
}

/* 64 x 64 pixels, in packets of 8 x 8; then what a mirror wherever they hit would send out. */
static void camera_rays(const scene *made, pktrt_ray *ray) {
  for (int i = 0; i < MANY; i++) {
    const int x = i / 64 % 8 * 8 + i % 8, y = i / 512 * 8 + i / 8 % 8;
    pktrt_camera_ray(&made->camera, SIDE, SIDE, x + 0.5, y + 0.5, NULL, 0, &ray[i]);
  }
}
static void mirror_rays(const pktrt_scene *s, pktrt_ray *ray) {
  for (int i = 0; i < MANY; i++) {
    const pktrt_ray from = ray[i];
    pktrt_hit h;
    float d[3] = {0, 0, 0}; /* no ray */
    if (pktrt_intersect(s, &from, &h)) {
      const float along = 2 * dot3(from.direction, h.normal) / dot3(h.normal, h.normal);
      for (int a = 0; a < 3; a++) d[a] = from.direction[a] - along * h.normal[a];
    }
    pktrt_spawn(s, &from, &h, d, &ray[i]);
  }
}

/* Within a twentieth, and some for what rounding changes from one instruction set to another. Of frusta the slots of
   nodes that are empty may count, or not. */
static void work_is_as_it_was(const struct example *e, int rays, int path, const pktrt_counts *c) {
  for (int i = 0; i < COUNTS; i++) {
    uint64_t got;
    const double want = (double)e->work[rays][path][i];
    const bool slots = path == PKTRT_PATH_FAST && counted[i].at == offsetof(pktrt_counts, frustum_culls);
    memcpy(&got, (const char *)c + counted[i].at, sizeof got);
    CHECK(!counted[i].of[path] || ((double)got >= want * (slots ? 0.3 : 0.95) - 20 && (double)got <= want * 1.05 + 20),
          "%s, %s rays, path %d: %llu %s, not %.0f", e->name, rays ? "mirror" : "camera", path, (unsigned long long)got,
          counted[i].name, want);
  }
}

static void work_on_examples(void) {
  static pktrt_ray ray[MANY];
  static pktrt_hit hit[MANY];
  for (int k = small_run ? 2 : 0; k < 3; k++) {
    scene made;
    pktrt_scene *s = example(&examples[k], &made);
    CHECK(scene_triangles(&made) == examples[k].triangles, "%s: %llu triangles", examples[k].name,
          (unsigned long long)scene_triangles(&made));
    camera_rays(&made, ray);
    for (int generation = 0; generation < 2; generation++) {
      for (int path = 0; path < PATHS; path++) {
        static pktrt_stats stats;
        pktrt_query_desc q;
        memset(&q, 0, sizeof q), memset(&stats, 0, sizeof stats);
        q.path = (pktrt_path)path, q.stats = &stats;
        pktrt_intersect_ex(s, &q, ray, hit, MANY);
        work_is_as_it_was(&examples[k], generation, path, &stats.by_type[0]);
      }
      mirror_rays(s, ray);
    }
    pktrt_scene_destroy(s);
    scene_free(&made);
  }
}

void suite_examples(void) {
  run("the scenes of the examples have the triangles they had, and cost the work they did", work_on_examples);
}
