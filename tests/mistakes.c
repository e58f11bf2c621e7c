/* What is easily done wrong and used to be silent; and the small calls that help against it. */
#include "pictures.h"

enum { LINES = 8 };

typedef struct heard { /* what the log said during one render */
  char line[LINES][256];
  int count;
} heard;

static void hear(void *user, int level, const char *sentence) {
  heard *h = user;
  CHECK(level == 0, "these are warnings");
  if (h->count < LINES) snprintf(h->line[h->count], sizeof h->line[0], "%s", sentence);
  h->count++;
}

static pktrt_scene *heard_scene(heard *h) {
  pktrt_scene_desc d;
  memset(&d, 0, sizeof d), memset(h, 0, sizeof *h);
  d.log = hear, d.user = h, d.isa = isas[isa_count - 1]; /* of AUTO there may be more to tell */
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!CHECK(s != NULL, "%s", pktrt_last_error(NULL))) abort();
  return s;
}

static const quad wall = {{-1, -1, 0}, {{2, 0, 0}, {0, 2, 0}}};

static pktrt_render_desc look(float *pixels) {
  return stage_view(PKTRT_MODE_RCS, 4, 4, pixels, vec_of(0.1, 0.2, 3), vec_of(0, 0, 0));
}

/* Nothing committed is no picture; an empty scene, and one that lost nothing, is. */
static void uncommitted(void) {
  float pixels[4 * 4 * 3];
  heard h;
  pktrt_scene *s = heard_scene(&h);
  pktrt_render_desc d = look(pixels);
  CHECK(pktrt_render(s, &d) == PKTRT_OK, "an empty scene may be rendered before any commit");
  stage_quad(s, &wall, 0);
  CHECK(pktrt_render(s, &d) == PKTRT_NOT_COMMITTED && strstr(pktrt_last_error(s), "commit"), "%s", pktrt_last_error(s));
  CHECK(pktrt_render_tile(s, &d, 0, 0, 4, 4) == PKTRT_NOT_COMMITTED);
  stage_commit(s);
  CHECK(pktrt_render(s, &d) == PKTRT_OK && pktrt_render_tile(s, &d, 0, 0, 4, 4) == PKTRT_OK);
  pktrt_scene_destroy(s);
}

/* One render of a wall that has or lacks this and that. */
typedef struct mistake {
  const char *words; /* of the one warning, apart by |; NULL: none is due */
  pktrt_mode mode;
  bool light, black_light, ambient, glows, shader, lens, shutter, mirror, gloss, glass, metal, moved, bent, added;
} mistake;

static void shine(void *user, const pktrt_points *p, float *radiance[3]) {
  (void)user;
  for (int k = 0; k < 3; k++) memset(radiance[k], 0, p->n * sizeof(float));
}

static void make_mistake(const mistake *k, heard *h) {
  float pixels[4 * 4 * 3];
  const float moved[12] = {-1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1}, normals[12] = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
  static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
  pktrt_scene *s = heard_scene(h);
  pktrt_material m = material_of(0.5, PKTRT_SPECULAR_NONE, 0.4);
  pktrt_mesh_desc of;
  memset(&of, 0, sizeof of);
  if (k->mirror || k->gloss) m.specular = PKTRT_SPECULAR_MIRROR;
  if (k->gloss) m.lobe = PKTRT_LOBE_PHONG, m.exponent = 20;
  if (k->glass) m.specular = PKTRT_SPECULAR_DIELECTRIC;
  if (k->metal) m.specular = PKTRT_SPECULAR_CONDUCTOR, m.ior[0] = m.ior[1] = m.ior[2] = 2;
  if (k->glows) m.emission[1] = 1;
  if (k->shader) m.shader = shine;
  of.positions = moved, of.vertex_count = 4, of.indices = corners, of.triangle_count = 2, of.normals = normals;
  of.material = stage_material(s, &m);
  CHECK(pktrt_add_mesh(s, &of, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  if (k->light || k->black_light) {
    pktrt_light l = light_of(PKTRT_LIGHT_POINT, k->light ? 5 : 0);
    l.position[2] = 3;
    stage_light(s, &l);
  }
  stage_commit(s);
  if (k->moved) CHECK(pktrt_set_positions(s, 0, 0, moved) == PKTRT_OK, "%s", pktrt_last_error(s));
  if (k->bent) CHECK(pktrt_set_normals(s, 0, 0, normals) == PKTRT_OK, "%s", pktrt_last_error(s));
  if (k->added) stage_quad(s, &wall, 0);
  pktrt_render_desc d = look(pixels);
  d.samples = 2, d.mode = k->mode, d.ambient[2] = k->ambient ? 0.1f : 0;
  d.camera.aperture = k->lens ? 0.1f : 0, d.camera.shutter = k->shutter ? 0.5f : 0;
  stage_render(s, &d);
  pktrt_scene_destroy(s);
}

static void warnings(void) {
  static const mistake cases[] = {
      {.light = true},
      {.ambient = true},
      {.glows = true},
      {.shader = true},
      {.words = "no light|no ambient"},
      {.words = "no light|no ambient", .black_light = true},
      {.words = "no light|no ambient", .mode = PKTRT_MODE_DRT},
      {.words = "PKTRT_MODE_RCS|mirror", .light = true, .mirror = true},
      {.words = "PKTRT_MODE_RCS|gloss", .light = true, .gloss = true},
      {.words = "PKTRT_MODE_RCS|dielectric", .light = true, .glass = true},
      {.words = "PKTRT_MODE_RCS|conductor", .light = true, .metal = true},
      {.words = "PKTRT_MODE_RCS|lens|shutter", .light = true, .lens = true, .shutter = true},
      {.words = "PKTRT_MODE_WRT|lens",
          .mode = PKTRT_MODE_WRT,
          .light = true,
          .lens = true,
          .mirror = true,
          .gloss = true},
      {.mode = PKTRT_MODE_WRT, .light = true, .glass = true},
      {.mode = PKTRT_MODE_DRT, .light = true, .lens = true, .shutter = true, .gloss = true},
      {.words = "mesh 0|changed|commit", .light = true, .moved = true},
      {.words = "mesh 0|changed|commit", .light = true, .bent = true},
      {.words = "mesh 1|added|commit", .light = true, .added = true},
  };
  for (size_t i = 0; i < COUNT(cases); i++) {
    heard h;
    make_mistake(&cases[i], &h);
    const int at_add = cases[i].black_light; /* told when it is added, see everyday.c */
    CHECK(h.count == at_add + (cases[i].words != NULL), "case %zu: %d warnings, the first: %s", i, h.count, h.line[0]);
    char words[128];
    snprintf(words, sizeof words, "%s", cases[i].words ? cases[i].words : "");
    for (char *word = strtok(words, "|"); word; word = strtok(NULL, "|"))
      CHECK(strstr(h.line[at_add], word) != NULL, "case %zu: no \"%s\" in: %s", i, word, h.line[at_add]);
  }
  heard all;
  const mistake worst = {.mirror = true, .lens = true, .moved = true};
  make_mistake(&worst, &all);
  CHECK(all.count == 3, "each once: %d", all.count);
}

/* --- small help --- */

static void made_rays(void) {
  const float o[3] = {1, 2, 3}, d[3] = {0, -1, 0.5f};
  pktrt_ray r = pktrt_make_ray(o, d);
  CHECK(r.tmin == 0 && r.tmax == INFINITY && r.time == 0, "from 0 to infinity, at time 0");
  for (int a = 0; a < 3; a++) CHECK(r.origin[a] == o[a] && r.direction[a] == d[a]);
  pktrt_scene *s = stage_open();
  quad floor = quad_of(vec_of(0, 0, 3), vec_of(0, 0, 9), vec_of(9, 0, 0));
  stage_quad(s, &floor, 0);
  stage_commit(s);
  pktrt_hit h;
  CHECK(pktrt_intersect(s, &r, &h) && h.t == 2, "it hits at %g", (double)h.t);
  r.tmax = 0;
  CHECK(!pktrt_intersect(s, &r, &h), "the control: with a zeroed tmax it would not");
  pktrt_scene_destroy(s);
  CHECK(pktrt_version() == PKTRT_VERSION);
}

/* The picture of a coded ground, taken by a hook that tells its rays: what pktrt_camera_ray gives meets the same points. */
typedef struct camera_case {
  const char *name;
  pktrt_camera c;
  bool control;
} camera_case;

/* Each component of each vector of a camera that is no number, or beyond the limit, is refused by its name; those of the end alone
   where the camera moves. */
static void bad_cameras(void) {
  static const char *const name[6] = {"eye", "target", "up", "eye_end", "target_end", "up_end"};
  const float bad[3] = {NAN, -INFINITY, 2 * PKTRT_MAX_COORD};
  pktrt_scene *s = stage_open();
  size_t refused = 0;
  stage_commit(s);
  for (int i = 0; i < 6 * 3 * 3; i++)
    for (int moves = 0; moves < 2; moves++) {
      float pixel[3];
      char what[32];
      pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, 1, 1, pixel, vec_of(0, 0, 1), vec_of(0, 0, 0));
      d.camera.moving = moves;
      memcpy(d.camera.eye_end, d.camera.eye, sizeof d.camera.eye);
      float *const vectors[6] = {
          d.camera.eye, d.camera.target, d.camera.up, d.camera.eye_end, d.camera.target_end, d.camera.up_end};
      vectors[i / 9][i / 3 % 3] = bad[i % 3];
      const pktrt_status status = pktrt_render(s, &d);
      snprintf(what, sizeof what, "%c of %s is", 'x' + i / 3 % 3, name[i / 9]);
      const bool counts = i < 27 || moves;
      CHECK((status == PKTRT_INVALID_ARGUMENT) == counts, "%s: status %d", what, (int)status);
      if (counts) CHECK(strstr(pktrt_last_error(s), what) != NULL, "%s: %s", what, pktrt_last_error(s));
      refused += counts;
    }
  CHECK(refused == 81, "%zu", refused);
  pktrt_scene_destroy(s);
}

static void camera_rays(void) {
  enum { SIDE = 12 };
  pktrt_camera still, moving;
  memset(&still, 0, sizeof still);
  still.eye[0] = 0.3f, still.eye[1] = 2.7f, still.eye[2] = 4.1f, still.target[1] = 0.2f, still.fov_y = 37;
  moving = still, moving.moving = true, moving.eye_end[0] = 1.3f, moving.eye_end[1] = 2.2f, moving.eye_end[2] = 4;
  moving.time = 0.3f, moving.shutter = 0.4f;
  for (int k = 0; k < 6; k++) {
    const bool lens = k % 3 == 1, drt = k % 3 > 0;
    pktrt_camera c = k < 3 ? still : moving;
    if (lens) c.aperture = 0.5f, c.focus = 3;
    float *pixels = stage_pixels(SIDE * SIDE * 3), *depth = stage_pixels(SIDE * SIDE);
    world w = world_static(2);
    pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
    pktrt_render_desc d =
        stage_view(drt ? PKTRT_MODE_DRT : PKTRT_MODE_WRT, SIDE, SIDE, pixels, vec_of(0, 0, 1), vec_of(0, 0, 0));
    d.camera = c, d.depth = depth, d.ambient[0] = 1, d.samples = 1;
    stage_render(s, &d);
    pktrt_sampling sampling = {PKTRT_SAMPLER_SOBOL, 1, 0};
    size_t same = 0, hits = 0, others = 0;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
      float u[5] = {0.5f, 0.5f, 0.5f, 0.5f, 0.5f}, time = k < 3 ? 0 : 0.5f;
      if (drt) pktrt_sample(&sampling, i % SIDE, i / SIDE, 0, 0, 5, u);
      if (k >= 3) time = drt ? (float)((double)c.time + (double)(lens ? u[4] : u[2]) * (double)c.shutter) : 0.5f;
      for (int off = 0; off < 2; off++) {
        pktrt_ray r;
        pktrt_hit h;
        double x = i % SIDE + (double)u[0] + (off ? 0.01 : 0), y = i / SIDE + (double)u[1];
        CHECK(pktrt_camera_ray(&c, SIDE, SIDE, x, y, lens ? u + 2 : NULL, time, &r), "it is a camera");
        CHECK(same_bits(&r.time, &time, sizeof time) && r.tmin == 0 && r.tmax == INFINITY);
        const bool hit = pktrt_intersect(s, &r, &h);
        double length =
            sqrt((double)r.direction[0] * (double)r.direction[0] + (double)r.direction[1] * (double)r.direction[1] +
                 (double)r.direction[2] * (double)r.direction[2]);
        const float far = hit ? (float)((double)h.t * length) : INFINITY;
        if (off) others += far != depth[i];
        else hits += hit, same += far == depth[i];
      }
    }
    CHECK(same == SIDE * SIDE && hits > SIDE && others > SIDE,
        "case %d: %zu of %d depths are the picture's, %zu hit; a hundredth of a pixel aside %zu differ", k, same,
        SIDE * SIDE, hits, others);
    pktrt_scene_destroy(s);
    world_free(&w);
    free(pixels), free(depth);
  }
  pktrt_ray r;
  pktrt_camera bad = still;
  bad.fov_y = 180;
  CHECK(!pktrt_camera_ray(&bad, 4, 4, 1, 1, NULL, 0, &r) && !(r.tmax > 0), "no camera, no ray");
  CHECK(!pktrt_camera_ray(&still, 0, 4, 1, 1, NULL, 0, &r) && !pktrt_camera_ray(NULL, 4, 4, 1, 1, NULL, 0, &r));
}

/* Boxes of glass in each other, which branch without attenuation: up to 2^50 rays. The hook is asked while the one pixel is at work. */
static bool five_times(void *user, float done) {
  int *calls = user;
  CHECK(done >= 0 && done <= 1);
  return ++*calls < 5;
}

static void cancelled_within_a_tile(void) {
  pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  for (int path = PKTRT_PATH_FAST; path <= PKTRT_PATH_SINGLE; path += small_run ? 2 : 1) {
    float pixel[3];
    int calls = 0;
    pktrt_scene *s = stage_open();
    glass.ior[0] = 2.5f;
    const uint32_t material = stage_material(s, &glass);
    for (int k = 0; k < 6; k++) {
      mesh one = mesh_box();
      mesh_scale(&one, 1 - 0.15f * (float)k);
      stage_mesh(s, &one, material);
      mesh_free(&one);
    }
    stage_commit(s);
    pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, 1, 1, pixel, vec_of(0.3, 0.2, 3), vec_of(0, 0, 0));
    d.progress = five_times, d.user = &calls, d.path = (pktrt_path)path;
    pktrt_status status = pktrt_render(s, &d);
    CHECK(status == PKTRT_CANCELLED && calls == 5, "path %d: status %d, asked %d times: %s", path, (int)status, calls,
        pktrt_last_error(s));
    d.max_depth = 3, d.progress = NULL;
    CHECK(pktrt_render(s, &d) == PKTRT_OK, "and the scene goes on");
    pktrt_scene_destroy(s);
  }
}

/* A texture that is NaN on a corner of the wall. */
static void broken(void *user, const pktrt_points *p) {
  for (uint32_t i = 0; i < p->n; i++)
    if (p->position[0][i] > 0.5f && *(bool *)user) p->albedo[0][i] = NAN;
}

static void target_of_broken_pixels(void) {
  enum { SIDE = 32 };
  static float pixels[SIDE * SIDE * 3];
  for (int k = 0; k < 8; k++) {
    bool bad = k % 2;
    pktrt_material m = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
    pktrt_light l = light_of(PKTRT_LIGHT_SPHERE, 1);
    pktrt_report report;
    pktrt_scene *s = stage_open();
    m.texture = broken, m.user = &bad, l.position[2] = 2, l.position[0] = 1, l.radius = 0.5f;
    stage_quad(s, &wall, stage_material(s, &m)), stage_light(s, &l);
    stage_commit(s);
    pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, SIDE, SIDE, pixels, vec_of(0, 0, 3), vec_of(0, 0, 0));
    d.target_error = 0.05f, d.report = &report, d.adaptive = k / 2 % 2, d.measure = (pktrt_error_measure)(k / 4);
    stage_render(s, &d);
    CHECK(report.stop == (bad ? PKTRT_STOP_PASSES : PKTRT_STOP_ERROR) && (report.unknown > 0) == bad,
        "%s, measure %d: stop %d, %u pixels unknown", d.adaptive ? "adaptive" : "uniform", (int)d.measure,
        (int)report.stop, (unsigned)report.unknown);
    pktrt_scene_destroy(s);
  }
}

/* An environment light shines as the environment or the background does: without either it is none, and the log says so. */
static void skies_of_nothing(void) {
  for (int background = 0; background < 2; background++)
    for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++) {
      float pixel[3];
      pktrt_scene *s = stage_open();
      stage_quad(s, &wall, 0);
      const pktrt_light sky = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
      stage_light(s, &sky);
      stage_commit(s);
      pktrt_render_desc d = stage_view((pktrt_mode)mode, 1, 1, pixel, vec_of(0, 0, 3), vec_of(0, 0, 0));
      for (int k = 0; k < 3; k++) d.background[k] = (float)background;
      d.samples = 2;
      hooks.warnings = 0;
      stage_render(s, &d);
      CHECK((hooks.warnings == 1) == !background && (pixel[0] > 0) == background,
          "mode %d, background %d: %d warnings, %g", mode, background, hooks.warnings, (double)pixel[0]);
      CHECK(background || strstr(hooks.last_log, "no light"), "%s", hooks.last_log);
      pktrt_scene_destroy(s);
    }
}

void suite_mistakes(void) {
  run("a picture of meshes that were never committed is refused", uncommitted);
  run("what a picture silently lacks is said once in the log", warnings);
  run("an environment light without environment or background is no light, and the log says so", skies_of_nothing);
  run("a ray that is made goes from 0 to infinity", made_rays);
  run("each bad component of a camera's vectors is refused by name", bad_cameras);
  run("a camera's ray is the renderer's, through lens and shutter, at rest and moving", camera_rays);
  run("a picture is cancelled within a pixel that would take ages", cancelled_within_a_tile);
  run("a target error is not met while pixels are not finite", target_of_broken_pixels);
}
