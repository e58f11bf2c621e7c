/* What changes in a scene from day to day: lights, materials, models and transforms. What is changed is compared, bit for bit, with
   a scene that was made so. And what pictures are turned into for a screen. */
#include "pictures.h"
#include "stability.h"

enum { SIZE = 16, LIGHTS = 6 };

/* --- lights --- */

/* One of each kind, from 0 to 5; of two strengths. */
static pktrt_light some_light(int kind, bool other) {
  pktrt_light l = light_of((pktrt_light_kind)kind, other ? 2.5 : 1);
  l.position[0] = other ? -0.7f : 0.4f, l.position[1] = 1.5f, l.position[2] = 1;
  l.direction[0] = other ? 0.3f : -0.4f, l.direction[1] = -1;
  l.edge[0][0] = 0.8f, l.edge[1][2] = other ? 1.1f : 0.9f, l.radius = 0.2f;
  l.mesh = 1, l.visible = true;
  return l;
}

/* A ball on a floor, and a lamp of a mesh. */
static pktrt_scene *room_without_light(void) {
  pktrt_scene *s = stage_open();
  const pktrt_material white = material_of(0.7, PKTRT_SPECULAR_NONE, 0), shine = lamp_of(3);
  mesh ball = mesh_sphere(2, 0.1f, 9);
  const quad ground = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 3), vec_of(3, 0, 0)),
             lamp = quad_of(vec_of(0, 2, 0), vec_of(0.4, 0, 0), vec_of(0, 0, 0.4));
  stage_quad(s, &ground, stage_material(s, &white));
  stage_quad(s, &lamp, stage_material(s, &shine));
  stage_mesh(s, &ball, 1);
  mesh_free(&ball);
  stage_commit(s);
  return s;
}

static void look(pktrt_scene *s, pktrt_light_choice choice, float pixels[3 * SIZE * SIZE]) {
  pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, SIZE, SIZE, pixels, vec_of(0, 0.6, 4), vec_of(0, -0.2, 0));
  d.samples = 4, d.lights = choice;
  for (int a = 0; a < 3; a++) d.background[a] = 0.2f;
  stage_render(s, &d);
}
/* Tells whether two scenes look alike, whichever lights are asked. */
static bool look_alike(pktrt_scene *a, pktrt_scene *b) {
  float x[3 * SIZE * SIZE], y[3 * SIZE * SIZE];
  bool same = true;
  for (int choice = 0; choice <= PKTRT_LIGHTS_ONE; choice++) {
    look(a, (pktrt_light_choice)choice, x), look(b, (pktrt_light_choice)choice, y);
    same = same && same_bits(x, y, sizeof x);
  }
  return same;
}

/* Sets each light of a scene to another kind, in turn, and back. */
static void lights_are_set(void) {
  pktrt_scene *s = room_without_light(), *want = NULL;
  size_t differ = 0;
  for (int k = 0; k < LIGHTS; k++) {
    const pktrt_light l = some_light(k, false);
    stage_light(s, &l);
  }
  for (int turn = 0; turn < LIGHTS; turn++) {
    want = room_without_light();
    for (int k = 0; k < LIGHTS; k++) {
      const pktrt_light l = some_light((k + turn) % LIGHTS, true);
      stage_light(want, &l);
    }
    differ += !look_alike(s, want); /* the control */
    for (int k = 0; k < LIGHTS; k++) {
      const pktrt_light l = some_light((k + turn) % LIGHTS, true);
      CHECK(pktrt_set_light(s, (uint32_t)k, &l) == PKTRT_OK, "%s", pktrt_last_error(s));
    }
    CHECK(look_alike(s, want), "turn %d", turn);
    pktrt_scene_destroy(want);
  }
  CHECK(differ == LIGHTS, "%zu differ before", differ);
  pktrt_scene_destroy(s);
}

/* Removes lights and adds others, by a list of what there should be. */
static void lights_come_and_go(void) {
  enum { ROOM = 24 };
  rng r = rng_of(1);
  pktrt_scene *s = room_without_light();
  int kind[ROOM];
  bool other[ROOM];
  uint32_t most = 0, removed = 0;
  for (int i = 0; i < ROOM; i++) kind[i] = -1;
  for (int step = 0; step < 90; step++) {
    const uint32_t i = rng_below(&r, most + 1);
    uint32_t index = PKTRT_NONE, want = 0;
    if (i < most && kind[i] >= 0 && rng_below(&r, 3) == 0) {
      CHECK(pktrt_remove_light(s, i) == PKTRT_OK, "light %u: %s", i, pktrt_last_error(s));
      CHECK(pktrt_remove_light(s, i) == PKTRT_INVALID_ARGUMENT, "light %u, twice", i);
      kind[i] = -1, removed++;
    } else if (most < ROOM - 1) {
      while (kind[want] >= 0) want++;
      kind[want] = (int)rng_below(&r, LIGHTS), other[want] = rng_below(&r, 2);
      const pktrt_light l = some_light(kind[want], other[want]);
      CHECK(pktrt_add_light(s, &l, &index) == PKTRT_OK && index == want, "light %u, not %u", index, want);
      if (want == most) most++;
    }
    if (step % 10) continue;
    pktrt_scene *as = room_without_light();
    for (uint32_t k = 0; k < most; k++) {
      const pktrt_light l = some_light(kind[k], other[k]);
      if (kind[k] >= 0) stage_light(as, &l);
    }
    CHECK(look_alike(s, as), "step %d, %u lights", step, most);
    pktrt_scene_destroy(as);
  }
  CHECK(removed > 9 && most > 5, "%u removed, of %u", removed, most);
  pktrt_scene_destroy(s);
}

/* --- materials --- */

static void materials_are_set(void) {
  pktrt_scene *s = room_without_light(), *want = stage_open();
  const pktrt_light l = some_light(PKTRT_LIGHT_POINT, false);
  const pktrt_material mirror = material_of(0.1, PKTRT_SPECULAR_MIRROR, 0.8), shine = lamp_of(3);
  pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  float x[3 * SIZE * SIZE], y[3 * SIZE * SIZE], before[3 * SIZE * SIZE];
  glass.ior[0] = 1.5f;
  stage_light(s, &l);
  pktrt_scene_destroy(want);
  look(s, PKTRT_LIGHTS_ALL, before);
  const pktrt_material *to[2] = {&mirror, &glass};
  for (int i = 0; i < 2; i++) {
    want = stage_open();
    const quad ground = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 3), vec_of(3, 0, 0)),
               lamp = quad_of(vec_of(0, 2, 0), vec_of(0.4, 0, 0), vec_of(0, 0, 0.4));
    mesh ball = mesh_sphere(2, 0.1f, 9);
    stage_quad(want, &ground, stage_material(want, to[i]));
    stage_quad(want, &lamp, stage_material(want, &shine));
    stage_mesh(want, &ball, 1);
    mesh_free(&ball);
    stage_commit(want);
    stage_light(want, &l);
    CHECK(pktrt_set_material(s, 1, to[i]) == PKTRT_OK, "%s", pktrt_last_error(s));
    look(s, PKTRT_LIGHTS_ALL, x), look(want, PKTRT_LIGHTS_ALL, y);
    CHECK(same_bits(x, y, sizeof x) && !same_bits(x, before, sizeof x), "material %d", i);
    pktrt_scene_destroy(want);
  }
  pktrt_scene_destroy(s);
}

/* --- models and transforms --- */

static const float unmoved[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

static uint32_t add_ball(pktrt_scene *s, int fineness) {
  mesh ball = mesh_sphere(fineness, 0.1f, 4);
  const pktrt_mesh_desc d = mesh_desc(&ball);
  uint32_t model = PKTRT_NONE;
  CHECK(pktrt_add_model(s, &d, 1, &model) == PKTRT_OK, "%s", pktrt_last_error(s));
  mesh_free(&ball);
  return model;
}
static uint32_t show(pktrt_scene *s, uint32_t model, uint32_t keys, const float *transforms) {
  pktrt_instance_desc d;
  uint32_t instance = PKTRT_NONE;
  memset(&d, 0, sizeof d);
  d.model = model, d.key_count = keys, d.transforms = transforms;
  CHECK(pktrt_add_instance(s, &d, &instance) == PKTRT_OK, "%s", pktrt_last_error(s));
  return instance;
}
static bool says_so(pktrt_scene *s, pktrt_status status, const char *words) {
  return CHECK(status == PKTRT_INVALID_ARGUMENT && strstr(pktrt_last_error(s), words), "status %d, \"%s\", not \"%s\"",
      (int)status, pktrt_last_error(s), words);
}

static void models_are_removed(void) {
  pktrt_scene *s = stage_open();
  pktrt_scene_info large, small;
  const uint32_t kept = add_ball(s, 1), fine = add_ball(s, 4);
  const uint32_t shown = show(s, kept, 1, unmoved), gone = show(s, fine, 1, unmoved);
  pktrt_ray ray = {{0.1f, 0.2f, 5}, 0, {0, 0, -1}, INFINITY, 0};
  pktrt_hit hit, again;
  stage_commit(s);
  says_so(s, pktrt_remove_model(s, fine), "remove_model: instance 1 shows model 1; remove it and commit first");
  CHECK(pktrt_remove_instance(s, gone) == PKTRT_OK);
  says_so(s, pktrt_remove_model(s, fine), "remove_model: instance 1 shows model 1 until the next commit");
  stage_commit(s);
  pktrt_get_scene_info(s, &large);
  CHECK(pktrt_intersect(s, &ray, &hit));
  CHECK(pktrt_remove_model(s, fine) == PKTRT_OK, "%s", pktrt_last_error(s));
  pktrt_get_scene_info(s, &small);
  CHECK(small.tree_bytes < large.tree_bytes && small.mesh_bytes < large.mesh_bytes, "%llu bytes of trees, then %llu",
      (unsigned long long)large.tree_bytes, (unsigned long long)small.tree_bytes);
  CHECK(pktrt_intersect(s, &ray, &again) && same_bits(&hit, &again, sizeof hit), "the other model is seen");
  says_so(s, pktrt_remove_model(s, fine), "remove_model: model 1 was removed");
  says_so(s, pktrt_remove_model(s, 7), "remove_model: there is no model 7 among 2");
  const pktrt_instance_desc d = {fine, 1, unmoved, 0, PKTRT_INTERPOLATION_LINEAR};
  says_so(s, pktrt_add_instance(s, &d, NULL), "model 1 was removed");
  stage_commit(s);
  CHECK(add_ball(s, 2) == fine && add_ball(s, 0) == 2, "its index is given again");
  CHECK(show(s, fine, 1, unmoved) == gone && shown == 0);
  stage_commit(s);
  CHECK(pktrt_intersect(s, &ray, &hit));
  pktrt_scene_destroy(s);
}

/* Keys that turn a body round or mirror it cannot be set one by one. */
static void all_keys_at_once(void) {
  static const float turned[24] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, -1, 0, 0, 1, 0, 1, 0, 0, 0, 0, -1, 0};
  static const float mirrored[24] = {1, 0, 0, 0, 0, -2, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, -1, 0, 1, 0, 0, 1, 0};
  static const float flat[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0};
  static const float *const to[3] = {turned, mirrored, turned};
  float keys[24];
  memcpy(keys, unmoved, sizeof unmoved), memcpy(keys + 12, unmoved, sizeof unmoved);
  pktrt_scene *s = stage_open();
  const uint32_t model = add_ball(s, 2), instance = show(s, model, 2, keys);
  stage_commit(s);
  says_so(s, pktrt_set_transform(s, instance, 0, turned), "instance 0"); /* the control */
  for (int i = 0; i < 3; i++) {
    rng r = rng_of((uint64_t)i);
    size_t hits = 0;
    CHECK(pktrt_set_transforms(s, instance, to[i]) == PKTRT_OK, "%s", pktrt_last_error(s));
    CHECK((i ? pktrt_refit(s) : pktrt_commit(s)) == PKTRT_OK, "%s", pktrt_last_error(s));
    says_so(s, pktrt_set_transforms(s, instance, flat), "instance 0");
    says_so(s, pktrt_set_transforms(s, instance, NULL), "set_transforms: instance 0: the array of 2 keys is NULL");
    says_so(s, pktrt_set_transforms(s, 3, flat), "set_transforms: there is no instance 3 among 1");
    CHECK(pktrt_refit(s) == PKTRT_OK, "what is refused changes nothing");
    pktrt_scene *want = stage_open();
    show(want, add_ball(want, 2), 2, to[i]);
    stage_commit(want);
    for (int k = 0; k < 500; k++) {
      pktrt_ray ray = ray_of(0, 0, 0, 0, 0, 0);
      pktrt_hit a, b;
      for (int c = 0; c < 3; c++)
        ray.origin[c] = 3 * rng_sign(&r), ray.direction[c] = 0.5f * rng_sign(&r) - ray.origin[c];
      ray.time = rng_unit(&r);
      hits += pktrt_intersect(s, &ray, &a);
      pktrt_intersect(want, &ray, &b);
      CHECK(same_bits(&a, &b, sizeof a), "keys %d, ray %d", i, k);
    }
    CHECK(hits > 100, "%zu hits", hits);
    pktrt_scene_destroy(want);
  }
  pktrt_scene_destroy(s);
}

static void matrices_of_4x4(void) {
  static const float columns[16] = {1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0, 10, 11, 12, 1};
  static const float rows[12] = {1, 4, 7, 10, 2, 5, 8, 11, 3, 6, 9, 12};
  float got[16];
  pktrt_transform_from_4x4(columns, got);
  CHECK(same_bits(got, rows, sizeof rows));
  memcpy(got, columns, sizeof columns);
  pktrt_transform_from_4x4(got, got);
  CHECK(same_bits(got, rows, sizeof rows), "in place");
}

/* --- what a mesh is --- */

/* A ball of level 2 with its first `missing` triangles taken away and `flat` ones without area added, at some keys. */
static uint32_t add_spoilt_ball(pktrt_scene *s, uint32_t missing, uint32_t flat, uint32_t keys) {
  mesh ball = mesh_sphere(2, 0.1f, 9);
  uint32_t index = PKTRT_NONE;
  if (keys > 1) mesh_move(&ball, keys, 0.2f, 0.1f, 3);
  pktrt_mesh_desc d = mesh_desc(&ball);
  const uint32_t count = d.triangle_count - missing + flat;
  uint32_t *faces = malloc(3 * count * sizeof *faces);
  memcpy(faces, d.indices + 3 * missing, 3 * (d.triangle_count - missing) * sizeof *faces);
  for (uint32_t i = 3 * (count - flat); i < 3 * count; i++) faces[i] = i % 2; /* 0, 1, 0 and 1, 0, 1 */
  d.indices = faces, d.triangle_count = count;
  CHECK(pktrt_add_mesh(s, &d, &index) == PKTRT_OK, "%s", pktrt_last_error(s));
  free(faces), mesh_free(&ball);
  return index;
}
static void meshes_are_described(void) {
  pktrt_scene *s = stage_open();
  pktrt_mesh_info info;
  pktrt_scene_info all;
  uint64_t triangles = 0, degenerate = 0, bytes = 0;
  for (uint32_t missing = 0; missing < 3; missing++)
    for (uint32_t flat = 0; flat < 4; flat += 3)
      for (uint32_t keys = 1; keys < 4; keys++) {
        const uint32_t ball = add_spoilt_ball(s, missing, flat, keys);
        CHECK(pktrt_get_mesh_info(s, ball, &info) == PKTRT_NOT_COMMITTED);
        stage_commit(s);
        CHECK(pktrt_get_mesh_info(s, ball, &info) == PKTRT_OK);
        CHECK(info.triangles == 128 - missing + flat && info.degenerate == flat, "%llu triangles, %llu degenerate",
            (unsigned long long)info.triangles, (unsigned long long)info.degenerate);
        CHECK(
            info.closed == !missing && (missing != 1 || info.open_edges == 3) && (missing != 2 || info.open_edges > 3),
            "%u missing: %llu open edges", missing, (unsigned long long)info.open_edges);
        for (int a = 0; a < 3; a++) CHECK(info.lo[a] < -0.7f && info.hi[a] > 0.7f && info.hi[a] < 1.6f);
        triangles += info.triangles, degenerate += info.degenerate, bytes += info.bytes;
      }
  pktrt_get_scene_info(s, &all);
  CHECK(all.triangles == triangles && all.degenerate == degenerate && all.mesh_bytes == bytes, "of all together");

  /* Soups: corners are the same where their positions are. A second, turned round, closes what lacks everything. */
  static const float soup[18] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0.0f, 1, 0, 1, 0, 0, -0.0f, 0, -0.0f};
  pktrt_mesh_desc d;
  memset(&d, 0, sizeof d);
  d.positions = soup, d.vertex_count = 3, d.triangle_count = 1;
  uint32_t one = 0, two = 0;
  CHECK(pktrt_add_mesh(s, &d, &one) == PKTRT_OK);
  d.vertex_count = 6, d.triangle_count = 2;
  CHECK(pktrt_add_mesh(s, &d, &two) == PKTRT_OK);
  const uint32_t model = add_ball(s, 1), instance = show(s, model, 1, unmoved);
  uint32_t placed = 0, of = PKTRT_NONE;
  stage_commit(s);
  CHECK(pktrt_get_mesh_info(s, one, &info) == PKTRT_OK && !info.closed && info.open_edges == 3, "%llu open",
      (unsigned long long)info.open_edges);
  CHECK(pktrt_get_mesh_info(s, two, &info) == PKTRT_OK && info.closed && info.open_edges == 0);
  while (!pktrt_get_mesh_source(s, placed, &of, NULL)) placed++;
  CHECK(of == instance && pktrt_get_mesh_info(s, placed, &info) == PKTRT_OK && info.closed && info.triangles == 32);
  CHECK(
      pktrt_get_mesh_info(s, 1000, &info) == PKTRT_INVALID_ARGUMENT && info.triangles == 0 && info.lo[0] > info.hi[0]);
  CHECK(pktrt_get_mesh_info(NULL, 0, &info) == PKTRT_INVALID_ARGUMENT);
  pktrt_scene_destroy(s);
}

/* --- to a screen --- */

static double srgb(double x) { return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1 / 2.4) - 0.055; }

static void codes_of_screens(void) {
  enum { N = 3000 };
  static float linear[3 * N];
  static unsigned char codes[3 * N];
  size_t wrong = 0, control = 0;
  for (int curve = 0; curve < 2; curve++)
    for (int i = 0; i < 3 * N; i++) linear[i] = (float)i * (curve ? 5.0f : 1.2f) / (3 * N);
  for (int curve = 0; curve < 2; curve++)
    for (int brighter = 0; brighter < 2; brighter++) {
      const double exposure = brighter ? 1.7 : 1;
      pktrt_to_srgb8(linear, N, brighter ? 1.7f : 0, curve ? PKTRT_TONE_CURVE : PKTRT_TONE_CLAMP, codes);
      for (int i = 0; i < 3 * N; i++) {
        double v = (double)linear[i] * (brighter ? (double)1.7f : exposure);
        if (curve) v = v < 4 ? v * (1 + v / 16) / (1 + v) : 1;
        const double code = 255 * srgb(v < 1 ? v : 1);
        wrong += !(fabs(code - codes[i]) <= 0.5 + 1e-6); /* 1e-6: at borders, which pow and ours may put apart */
        control += !(fabs(255 * (v < 1 ? v : 1) - codes[i]) <= 0.5);
      }
    }
  CHECK(wrong == 0 && control > N, "%zu wrong; control %zu", wrong, control);
  const float odd[9] = {NAN, -1, -INFINITY, INFINITY, FLT_MAX, 1, 0, -0.0f, 1e-40f};
  static const unsigned char want[9] = {0, 0, 0, 255, 255, 255, 0, 0, 0};
  unsigned char got[10];
  for (int curve = 0; curve < 2; curve++) {
    got[9] = 77;
    pktrt_to_srgb8(odd, 3, 0, curve ? PKTRT_TONE_CURVE : PKTRT_TONE_CLAMP, got);
    for (int i = 0; i < 9; i++)
      CHECK(got[i] == (curve && i == 5 ? 193 : want[i]), "value %d, curve %d: %u", i, curve, (unsigned)got[i]);
    CHECK(got[9] == 77, "no more than asked");
  }
  pktrt_to_srgb8(NULL, 0, 1, PKTRT_TONE_CLAMP, NULL);
}

/* --- mistakes --- */

static void mistakes_are_named(void) {
  pktrt_scene *s = room_without_light();
  pktrt_light l = some_light(0, false), bad = l;
  pktrt_material m = material_of(0.5, PKTRT_SPECULAR_NONE, 0), black = m;
  float before[3 * SIZE * SIZE], after[3 * SIZE * SIZE];
  stage_light(s, &l);
  look(s, PKTRT_LIGHTS_ALL, before);
  bad.intensity[1] = -1, black.albedo[2] = 7;
  says_so(s, pktrt_set_light(s, 3, &l), "set_light: there is no light 3 (there are 1 lights)");
  says_so(s, pktrt_set_light(s, 0, &bad), "light 0: component 1 of its intensity is -1");
  says_so(s, pktrt_set_light(s, 0, NULL), "light 0: the description is NULL");
  says_so(s, pktrt_remove_light(s, 1), "remove_light: there is no light 1 (there are 1 lights)");
  says_so(s, pktrt_set_material(s, 0, &m), "set_material: material 0 is the default, which stays");
  says_so(s, pktrt_set_material(s, 9, &m), "set_material: there is no material 9 among the 2 that were added");
  says_so(s, pktrt_set_material(s, 1, &black), "material 1");
  says_so(s, pktrt_set_material(s, 1, NULL), "material 1: the description is NULL");
  look(s, PKTRT_LIGHTS_ALL, after);
  CHECK(same_bits(before, after, sizeof before), "what is refused changes nothing");
  CHECK(
      pktrt_set_light(NULL, 0, &l) == PKTRT_INVALID_ARGUMENT && pktrt_remove_light(NULL, 0) == PKTRT_INVALID_ARGUMENT);
  CHECK(pktrt_set_material(NULL, 1, &m) == PKTRT_INVALID_ARGUMENT &&
        pktrt_remove_model(NULL, 0) == PKTRT_INVALID_ARGUMENT);
  CHECK(pktrt_set_transforms(NULL, 0, unmoved) == PKTRT_INVALID_ARGUMENT);
  pktrt_scene_destroy(s);
}

/* --- what is told --- */

typedef struct told { /* all warnings, one after the other */
  char text[2000];
  size_t n;
} told;
static void hear(void *user, int level, const char *sentence) {
  told *t = user;
  if (level == 0) t->n += (size_t)snprintf(t->text + t->n, sizeof t->text - t->n, "%s\n", sentence);
}
static void hear_all(void *user, int level, const char *sentence) {
  (void)level;
  hear(user, 0, sentence);
}
static void all_white(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user, (void)direction;
  for (uint32_t i = 0; i < n; i++) radiance[0][i] = radiance[1][i] = radiance[2][i] = 1;
}

/* A typical mistake, and the same without it. */
typedef struct mistake {
  const char *words; /* the cause, and the field */
  void (*make)(pktrt_light *, pktrt_material *, pktrt_render_desc *, bool mistaken);
} mistake;
static void no_environment_light(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)m;
  l->kind = mistaken ? PKTRT_LIGHT_KIND_COUNT : PKTRT_LIGHT_ENVIRONMENT; /* COUNT: none */
  d->environment = all_white;
}
static void no_intensity(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)m, (void)d;
  for (int a = 0; a < 3 && mistaken; a++) l->intensity[a] = 0;
}
static void no_albedo(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)l, (void)d;
  for (int a = 0; a < 3 && mistaken; a++) m->albedo[a] = 0;
}
static void no_ior(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)l, (void)d;
  m->specular = PKTRT_SPECULAR_CONDUCTOR;
  for (int a = 0; a < 3 && !mistaken; a++) m->ior[a] = 0.2f, m->extinction[a] = 3;
}
static void no_reflectance(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)l, (void)d;
  m->specular = PKTRT_SPECULAR_MIRROR;
  for (int a = 0; a < 3; a++) m->albedo[a] = 0.1f, m->reflectance[a] = mistaken ? 0 : 0.8f;
}
static void no_exponent(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  no_reflectance(l, m, d, false);
  m->lobe = PKTRT_LOBE_PHONG, m->exponent = mistaken ? 0 : 20;
}
static void radians(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)l, (void)m;
  d->camera.fov_y = mistaken ? 0.8f : 46;
}
static void faces_away(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)m, (void)d;
  *l = some_light(PKTRT_LIGHT_QUAD, false);
  l->position[1] = 9;
  if (mistaken) memset(l->edge, 0, sizeof l->edge), l->edge[0][2] = l->edge[1][0] = 1;
}
static void no_area(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)m, (void)d;
  *l = some_light(PKTRT_LIGHT_QUAD, false);
  if (mistaken) memcpy(l->edge[1], l->edge[0], sizeof l->edge[0]);
}
static void no_radius(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)m, (void)d;
  *l = some_light(PKTRT_LIGHT_SPHERE, false);
  if (mistaken) l->radius = 0;
}
static void no_emission(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)d;
  *l = some_light(PKTRT_LIGHT_MESH, false);
  l->mesh = 0;
  for (int a = 0; a < 3 && !mistaken; a++) m->emission[a] = 1;
}
static void no_mesh_light(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  no_emission(l, m, d, false);
  if (mistaken) l->kind = PKTRT_LIGHT_KIND_COUNT;
}
static void texture_of_texcoords(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) p->albedo[0][i] = 0.5f + 0.4f * p->texcoord[0][i];
}
static void texture_of_places(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) p->albedo[0][i] = fabsf(p->position[0][i]) > 0.5f ? 1 : 0.5f;
}
static void texture_of_bytes(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) p->albedo[2][i] = 200;
}
static void no_texcoords(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)l, (void)d;
  m->texture = mistaken ? texture_of_texcoords : texture_of_places;
}
static void beyond_one(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)l, (void)d;
  m->texture = mistaken ? texture_of_bytes : texture_of_places;
}
/* A sun of 0.01 degrees across around the middle of a cell of a table of 512 rows, or of 10 degrees. */
static void sun_of(double half, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  const double down = 160.5 / 512 * PI, round = 120.5 / 1024 * 2 * PI;
  const double to[3] = {sin(down) * cos(round), cos(down), sin(down) * sin(round)};
  for (uint32_t i = 0; i < n; i++) {
    double off2 = 0;
    for (int a = 0; a < 3; a++) off2 += pow((double)direction[a][i] - to[a], 2);
    for (int a = 0; a < 3; a++) radiance[a][i] = sqrt(off2) < 2 * sin(half * PI / 360) ? 20000 : 0.3f;
  }
}
static void small_sun(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  sun_of(0.005, n, direction, radiance);
}
static void wide_sun(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  sun_of(5, n, direction, radiance);
}
static void too_small_a_sun(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)m;
  *l = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
  d->environment = mistaken ? small_sun : wide_sun;
}
static void one_sample(pktrt_light *l, pktrt_material *m, pktrt_render_desc *d, bool mistaken) {
  (void)l, (void)m;
  d->samples = mistaken ? 1 : 0;
}
static const mistake mistakes[] = {
    {"the texture of material 1 looks at texcoords, but mesh 0 has none", no_texcoords},
    {"the texture of material 1 writes 200 as albedo, outside [0, 1]", beyond_one},
    {"environment: towards (0.62, 0.55, 0.56) it has a source smaller than 0.03 degrees: give it as a light of kind",
        too_small_a_sun},
    {"one sample a pixel is noise: set samples", one_sample},
    {"PKTRT_LIGHT_ENVIRONMENT for `environment`", no_environment_light},
    {"light 0 gives no light: its intensity is 0", no_intensity},
    {"material 1 is black: its albedo is 0", no_albedo},
    {"material 1 is no metal that there is: its ior is 0", no_ior},
    {"material 1 reflects nothing: the reflectance", no_reflectance},
    {"material 1 has a Phong lobe of exponent 0", no_exponent},
    {"camera.fov_y is 0.8 degrees", radians},
    {"light 0, a quad, faces away from the whole scene: exchange edge[0] and edge[1]", faces_away},
    {"light 0 gives no light: edge[0] and edge[1]", no_area},
    {"light 0 gives no light: the radius", no_radius},
    {"light 0 gives no light: the emission of material 1, which mesh 0 has, is 0", no_emission},
    {"PKTRT_LIGHT_MESH for mesh 0, whose material has emission", no_mesh_light},
};

/* A ball and a floor below it of the default material, under one light. */
static void make_mistake(const mistake *x, bool mistaken, bool set, told *t) {
  pktrt_scene_desc sd;
  float pixels[3 * SIZE * SIZE];
  pktrt_light l = light_of(PKTRT_LIGHT_POINT, 5), dull = l;
  pktrt_material m = material_of(0.7, PKTRT_SPECULAR_NONE, 0), plain = m;
  pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, SIZE, SIZE, pixels, vec_of(0, 0.6, 4), vec_of(0, 0, 0));
  mesh ball = mesh_sphere(2, 0.1f, 9);
  const quad ground = quad_of(vec_of(0, -1.5, 0), vec_of(0, 0, 3), vec_of(3, 0, 0));
  memset(t, 0, sizeof *t), memset(&sd, 0, sizeof sd);
  sd.log = hear, sd.user = t;
  pktrt_scene *s = pktrt_scene_create(&sd);
  l.position[1] = dull.position[1] = 4;
  d.samples = 2;
  x->make(&l, &m, &d, mistaken);
  const uint32_t material = stage_material(s, set ? &plain : &m);
  if (set) CHECK(pktrt_set_material(s, material, &m) == PKTRT_OK, "%s", pktrt_last_error(s));
  stage_mesh(s, &ball, material);
  stage_quad(s, &ground, 0);
  if (l.kind != PKTRT_LIGHT_KIND_COUNT) {
    stage_light(s, set ? &dull : &l);
    if (set) CHECK(pktrt_set_light(s, 0, &l) == PKTRT_OK, "%s", pktrt_last_error(s));
  }
  stage_commit(s);
  stage_render(s, &d);
  mesh_free(&ball);
  pktrt_scene_destroy(s);
}
/* What shines and is no light is told, as information, where other light is there. */
static void shining_is_told(void) {
  for (int k = 0; k < 3; k++) {
    told t;
    pktrt_scene_desc sd;
    float pixels[3 * SIZE * SIZE];
    memset(&t, 0, sizeof t), memset(&sd, 0, sizeof sd);
    sd.log = hear_all, sd.user = &t;
    pktrt_scene *s = pktrt_scene_create(&sd);
    const pktrt_light l = light_of(PKTRT_LIGHT_POINT, 5);
    const pktrt_material m = lamp_of(3);
    const quad ground = quad_of(vec_of(0, -1.5, 0), vec_of(0, 0, 3), vec_of(3, 0, 0));
    pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, SIZE, SIZE, pixels, vec_of(0, 0.6, 4), vec_of(0, 0, 0));
    d.samples = 2, d.environment = k == 1 ? wide_sun : NULL;
    stage_light(s, &l);
    stage_quad(s, &ground, k == 2 ? stage_material(s, &m) : 0);
    stage_commit(s);
    stage_render(s, &d);
    const char *words = k == 1 ? "PKTRT_LIGHT_ENVIRONMENT for `environment`" : "PKTRT_LIGHT_MESH for mesh 0";
    CHECK((strstr(t.text, words) != NULL) == (k > 0), "case %d: %s", k, t.text);
    pktrt_scene_destroy(s);
  }
}

/* A sun of 0.2 degrees across, `user` cells from a corner of cells of a table of 512 rows, or of 10 degrees. */
static void sun_at_corner(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  const double off = *(const double *)user, wide = off < 0 ? 5 : 0.1;
  const double down = (200 + fmax(off, 0)) / 512 * PI, round = (300 + fmax(off, 0)) / 1024 * 2 * PI;
  const double to[3] = {sin(down) * cos(round), cos(down), sin(down) * sin(round)};
  for (uint32_t i = 0; i < n; i++) {
    double along = 0;
    for (int a = 0; a < 3; a++) along += to[a] * (double)direction[a][i];
    for (int a = 0; a < 3; a++) radiance[a][i] = along > cos(wide * PI / 180) ? 20000 : 0.3f;
  }
}
/* What no look at the environment has found, rays may meet: then the report is unreliable, and the log says why. */
static void lost_suns_are_told(void) {
  for (int k = 0; k < 3; k++) {
    told t;
    pktrt_scene_desc sd;
    pktrt_report report;
    float pixels[3 * SIZE * SIZE];
    double off = 0.5 * (k - 1); /* below 0: a wide sun; 0: lost between cells; 0.5: in the middle of one */
    memset(&t, 0, sizeof t), memset(&sd, 0, sizeof sd);
    sd.log = hear_all, sd.user = &t;
    pktrt_scene *s = pktrt_scene_create(&sd);
    const pktrt_light l = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
    const quad ground = quad_of(vec_of(0, -1.5, 0), vec_of(0, 0, 3), vec_of(3, 0, 0));
    const double down = 200.0 / 512 * PI, round = 300.0 / 1024 * 2 * PI;
    const vec sun = vec_of(sin(down) * cos(round), cos(down), sin(down) * sin(round));
    pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, SIZE, SIZE, pixels, vec_of(0, 0, 0), sun);
    d.camera.fov_y = 4;
    d.samples = 16, d.passes = 16;
    d.environment = sun_at_corner, d.user = &off, d.report = &report;
    stage_light(s, &l);
    stage_quad(s, &ground, 0);
    stage_commit(s);
    stage_render(s, &d);
    const bool lost = strstr(t.text, "rays met more than 16 times the radiance that its table knows") != NULL;
    CHECK(lost == (k == 1), "case %d: %s", k, t.text);
    CHECK(k != 1 || (report.unreliable[0] && report.unreliable[1]), "case %d: the report is called reliable", k);
    CHECK(k != 0 || !report.unreliable[0], "case %d: the report is called unreliable", k);
    pktrt_scene_destroy(s);
  }
}

static void typical_mistakes_are_told(void) {
  told t;
  for (size_t i = 0; i < COUNT(mistakes); i++)
    for (int set = 0; set < 2; set++) {
      if (set && mistakes[i].make == no_intensity) continue; /* a light that is set to 0 is switched off */
      make_mistake(&mistakes[i], true, set, &t);
      CHECK(strstr(t.text, mistakes[i].words), "\"%s\" is not in: %s", mistakes[i].words, t.text);
      make_mistake(&mistakes[i], false, set, &t);
      CHECK(t.n == 0, "without \"%s\": %s", mistakes[i].words, t.text);
    }
  pktrt_scene_desc sd;
  memset(&sd, 0, sizeof sd);
  sd.isa = (pktrt_isa)77;
  CHECK(pktrt_scene_create(&sd) == NULL);
  const char *last = pktrt_last_error(NULL), *widest = "";
  for (int isa = PKTRT_ISA_SCALAR; isa < PKTRT_ISA_COUNT; isa++)
    if (pktrt_isa_available((pktrt_isa)isa)) widest = pktrt_isa_string((pktrt_isa)isa);
  CHECK(strstr(last, "the widest") && strstr(last, widest), "%s is not in: %s", widest, last);
}

/* --- normals of hits --- */

enum { NORMAL_RAYS = 300 };

/* Sends rays at triangles of a mesh from near by, as a model's corners lie with the matrix `scale`, and measures how far
   normals are from unit length; returns the number of hits. */
static size_t measure_normals(const pktrt_scene *s, const mesh *m, const float scale[3], rng *r, double *farthest) {
  static pktrt_ray rays[NORMAL_RAYS];
  static pktrt_hit many[NORMAL_RAYS];
  size_t hits = 0;

  for (int i = 0; i < NORMAL_RAYS; i++) {
    const uint32_t *corner = m->i + 3 * (size_t)rng_below(r, m->nt);
    rays[i] = ray_of(0, 0, 0, 0, 0, 0);
    rays[i].time = rng_unit(r);
    for (int a = 0; a < 3; a++) {
      const float centre =
          (m->p[3 * corner[0] + (uint32_t)a] + m->p[3 * corner[1] + (uint32_t)a] + m->p[3 * corner[2] + (uint32_t)a]) /
          3;
      const float to = centre * scale[a], away = 0.3f * rng_sign(r) * scale[a];
      rays[i].origin[a] = to + away, rays[i].direction[a] = -away;
    }
  }
  pktrt_intersect_n(s, rays, many, NORMAL_RAYS);
  for (int i = 0; i < NORMAL_RAYS; i++) {
    pktrt_hit hit;
    double n2 = 0;
    if (!pktrt_intersect(s, &rays[i], &hit)) continue;
    CHECK(same_bits(&hit, &many[i], sizeof hit), "ray %d", i);
    for (int a = 0; a < 3; a++) n2 += (double)hit.normal[a] * (double)hit.normal[a];
    hits++;
    if (!(fabs(sqrt(n2) - 1) <= *farthest)) *farthest = fabs(sqrt(n2) - 1);
  }
  return hits;
}

static void normals_are_of_unit_length(void) {
  static const float scales[][3] = {{1, 1, 1}, {1e-17f, 1e-17f, 1e-17f}, {1e17f, 1e17f, 1e17f}, {1e-9f, 1, 1e9f},
      {3, -2, 1}, {1e12f, 1e-12f, 1e12f}, {1e-15f, 1, 1e-15f}};
  double farthest = 0;
  size_t hits = 0;
  rng r = rng_of(54);

  for (size_t k = 0; k < sizeof scales / sizeof *scales; k++)
    for (int kind = 0; kind < 8; kind++) {
      mesh m = kind % 4 == 0 ? mesh_sphere(2, 0.2f, 3) : kind % 4 == 1 ? mesh_thin(300, 4) : mesh_soup(200, 0.3f, 5);
      const float *scale = scales[k];
      const float keys[12] = {scale[0], 0, 0, 0, 0, scale[1], 0, 0, 0, 0, scale[2], 0};
      const float none[3] = {0, 0, 0};
      pktrt_scene *s = stage_open();

      if (kind % 4 == 3) mesh_move(&m, 3, 0.4f, 0.05f, 6);
      if (kind < 4) mesh_place(&m, scale, none);
      const pktrt_mesh_desc d = mesh_desc(&m);
      uint32_t model = 0;
      CHECK((kind < 4 ? pktrt_add_mesh(s, &d, NULL) : pktrt_add_model(s, &d, 1, &model)) == PKTRT_OK, "%s",
          pktrt_last_error(s));
      if (kind >= 4) show(s, model, 1, keys);
      stage_commit(s);
      hits += measure_normals(s, &m, kind < 4 ? scales[0] : scale, &r, &farthest);
      pktrt_scene_destroy(s);
      mesh_free(&m);
    }
  CHECK(hits > 5000, "%zu hits", hits);
  CHECK(farthest > 0 && farthest < 0x1p-22, "a length is off by %g * 2^-24", farthest * 0x1p24);
  say("%zu hits, lengths off by at most %.2f * 2^-24", hits, farthest * 0x1p24);
}

/* --- samples --- */

/* A description without samples makes as many as its mode and its rules ask for. */
static void samples_by_default(void) {
  static const uint32_t alone[] = {4, 4, 16};
  pktrt_scene *s = room_without_light();

  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++)
    for (int rule = 0; rule < 5; rule++) {
      float got[3 * SIZE * SIZE], want[3 * SIZE * SIZE];
      uint32_t taken[SIZE * SIZE];
      pktrt_render_desc d = stage_view((pktrt_mode)mode, SIZE, SIZE, got, vec_of(0, 0.6, 4), vec_of(0, -0.2, 0));
      d.samples = 0, d.sample_count = taken;
      for (int a = 0; a < 3; a++) d.ambient[a] = 0.5f;
      if (rule) d.passes = 2; /* ends all of them */
      if (rule == 2) d.target_error = 1e-9f;
      if (rule == 3) d.time_budget = 1000;
      if (rule == 4) d.adaptive = true;
      stage_render(s, &d);
      const uint32_t least = rule ? 2 : alone[mode];
      CHECK(taken[0] == least, "mode %d, rule %d: %u samples, not %u", mode, rule, taken[0], least);
      d.samples = rule ? 1 : alone[mode], d.pixels = want;
      stage_render(s, &d);
      CHECK(same_bits(got, want, sizeof got), "mode %d, rule %d", mode, rule);
    }
  pktrt_scene_destroy(s);
}

void suite_everyday(void) {
  run("a light that is set is as one that was added so, whatever its kind", lights_are_set);
  run("after lights come and go pictures are those of scenes that had only what is left", lights_come_and_go);
  run("a material that is set is as one that was added so", materials_are_set);
  run("a model that no instance shows is removed, and its index given again", models_are_removed);
  run("all keys of an instance are set at once: turned round, mirrored, or refused", all_keys_at_once);
  run("what a mesh is: triangles, bounds, bytes, and whether each edge has a triangle to either side",
      meshes_are_described);
  run("matrices of 4 x 4 by columns become those of instances", matrices_of_4x4);
  run("without a number of samples a picture has 4 in RCS and WRT and 16 in DRT, and a pass has one",
      samples_by_default);
  run("normals of hits are of unit length within 2^-22, of triangles and matrices of any size",
      normals_are_of_unit_length);
  run("codes for screens are the nearest, of any exposure and tone", codes_of_screens);
  run("mistakes in what is changed are named, and change nothing", mistakes_are_named);
  run("what shines and is no light is told where there is other light", shining_is_told);
  run("a source of the sky that no table has found is told where rays meet it, and makes reports unreliable",
      lost_suns_are_told);
  run("typical mistakes are told, each with its cause and the field, and what is right is not",
      typical_mistakes_are_told);
}
