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
    {"poolhall", 318196,
        {{{3262, 0, 46988, 0, 0, 0, 3127, 542}, {2911, 336726, 43033, 2721, 2686, 7159, 420, 7991},
             {39331, 0, 45930, 0, 0, 0, 0, 0}},
            {{7538, 0, 75293, 0, 0, 0, 1113, 793}, {6179, 1122148, 76464, 6073, 5214, 448, 0, 33285},
                {43349, 0, 69759, 0, 0, 0, 0, 0}}}},
    {"conference", 291194,
        {{{3035, 0, 55571, 0, 0, 0, 2286, 300}, {2840, 335727, 66906, 2693, 2974, 6196, 799, 7676},
             {31481, 0, 58730, 0, 0, 0, 0, 0}},
            {{7629, 0, 97242, 0, 0, 0, 1074, 514}, {6208, 1141930, 108836, 6399, 5159, 558, 0, 33139},
                {40440, 0, 101245, 0, 0, 0, 0, 0}}}},
    {"rtrt", 84846,
        {{{2677, 0, 46786, 0, 0, 0, 2656, 184}, {2428, 305000, 45231, 2353, 3210, 6060, 557, 4891},
             {30013, 0, 46202, 0, 0, 0, 0, 0}},
            {{7403, 0, 88412, 0, 0, 0, 527, 327}, {5103, 956046, 94083, 5307, 5473, 645, 0, 24907},
                {31934, 0, 82815, 0, 0, 0, 0, 0}}}},
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
        if (path == PKTRT_PATH_FAST && (!COUNTS_FAST || !has_frusta(PKTRT_ISA_AUTO)))
          continue; /* streams only: other work */
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
