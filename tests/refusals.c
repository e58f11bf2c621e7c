/* Every refusal: its status, a sentence that names the culprit, and a scene that stays as it was. */
#include "meshes.h"
#include "noslack.h"

static bool has_number(const char *text, const char *number) { /* as a whole word */
  size_t n = strlen(number);
  for (const char *p = text; (p = strstr(p, number)) != NULL; p++) {
    bool before = p == text || !((p[-1] >= '0' && p[-1] <= '9') || p[-1] == '.');
    bool after = !(p[n] >= '0' && p[n] <= '9');
    if (before && after) return true;
  }
  return false;
}

/* The sentence exists, ends, and holds every word of a list separated by '|'. */
static void names(const char *what, const char *sentence, const char *words) {
  char list[128], *save = NULL;
  CHECK(sentence && strlen(sentence) > 10 && !strchr(sentence, '\n'), "%s: \"%s\" is no sentence", what, sentence);
  snprintf(list, sizeof list, "%s", words);
  for (char *w = strtok_r(list, "|", &save); w; w = strtok_r(NULL, "|", &save)) {
    bool digit = w[0] >= '0' && w[0] <= '9';
    CHECK(digit ? has_number(sentence, w) : strstr(sentence, w) != NULL, "%s: \"%s\" does not name %s", what, sentence,
        w);
  }
}

/* What queries and info say about a scene: to see that nothing changed. */
typedef struct snapshot {
  pktrt_hit hit[200];
  pktrt_scene_info info;
} snapshot;

static void take(const pktrt_scene *s, snapshot *x) {
  memset(x, 0, sizeof *x);
  for (uint32_t i = 0; i < COUNT(x->hit); i++) {
    rng r = rng_of(i);
    float o[3] = {3 * rng_sign(&r), 3 * rng_sign(&r), 3 * rng_sign(&r)},
          p[3] = {rng_sign(&r), rng_sign(&r), rng_sign(&r)};
    pktrt_ray ray = ray_towards(o, p, rng_unit(&r));
    pktrt_intersect(s, &ray, &x->hit[i]);
  }
  pktrt_get_scene_info(s, &x->info);
}

static bool same_snapshot(const snapshot *a, const snapshot *b) {
  return same_bits(a->hit, b->hit, sizeof a->hit) && a->info.mesh_count == b->info.mesh_count &&
         a->info.triangles == b->info.triangles && a->info.nodes == b->info.nodes &&
         a->info.mesh_bytes == b->info.mesh_bytes;
}

/* A scene with mesh 0, a moving mesh 1 of 3 keys, mesh 2 with normals. */
static pktrt_scene *some_scene(void) {
  pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
  pktrt_scene *s = pktrt_scene_create(&d);
  mesh a = mesh_box(), b = mesh_sphere(2, 0, 1), c = mesh_soup(20, 0.5f, 3);
  mesh_move(&b, 3, 0.2f, 0.05f, 1);
  CHECK(mesh_add(s, &a, NULL) == PKTRT_OK);
  CHECK(mesh_add(s, &b, NULL) == PKTRT_OK);
  float normals[180];
  for (int i = 0; i < 180; i++) normals[i] = i % 3 == 1;
  pktrt_mesh_desc m = mesh_desc(&c);
  m.normals = normals;
  CHECK(pktrt_add_mesh(s, &m, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  CHECK(pktrt_commit(s) == PKTRT_OK);
  mesh_free(&a), mesh_free(&b), mesh_free(&c);
  return s;
}

/* --- add_mesh --- */

static float soup[2 * 36]; /* 24 vertices: two keys of 12 */
static float odd_normals[36];
static uint32_t indices[12];

typedef struct refusal {
  const char *what, *words;
  pktrt_status status;
  void (*spoil)(pktrt_mesh_desc *);
} refusal;

static void no_positions(pktrt_mesh_desc *m) { m->positions = NULL; }
static void index_high(pktrt_mesh_desc *m) { indices[3 * 2 + 1] = 77, m->indices = indices; }
static void index_just_high(pktrt_mesh_desc *m) { indices[3 * 3] = 12, m->indices = indices; }
static void index_none(pktrt_mesh_desc *m) { indices[0] = 0xFFFFFFFFu, m->indices = indices; }
static void soup_long(pktrt_mesh_desc *m) { m->triangle_count = 5; }
static void vertex_nan(pktrt_mesh_desc *m) { soup[3 * 7 + 1] = NAN, m->indices = indices; }
static void vertex_inf(pktrt_mesh_desc *m) { (void)m, soup[3 * 8] = INFINITY; }
static void vertex_minus_inf(pktrt_mesh_desc *m) { (void)m, soup[3 * 11 + 2] = -INFINITY; }
static void vertex_nan_key(pktrt_mesh_desc *m) { soup[36 + 3 * 5] = NAN, m->key_count = 2; }
static void vertex_huge(pktrt_mesh_desc *m) { (void)m, soup[3 * 6 + 2] = -1.5e30f; }
static void vertex_beyond(pktrt_mesh_desc *m) { (void)m, soup[3 * 6] = nextafterf(PKTRT_MAX_COORD, INFINITY); }
static void vertex_nan_apart(pktrt_mesh_desc *m) { m->position_stride = 16, soup[4 * 9 + 1] = NAN; }
static void stride_small(pktrt_mesh_desc *m) { m->position_stride = 8; }
static void stride_odd(pktrt_mesh_desc *m) { m->position_stride = 13; }
static void stride_even(pktrt_mesh_desc *m) { m->position_stride = 14; }
static void keys_many(pktrt_mesh_desc *m) { m->key_count = 1025; }
static void keys_most(pktrt_mesh_desc *m) { m->key_count = 0xFFFFFFFFu; }
static void triangles_most(pktrt_mesh_desc *m) { m->triangle_count = 0xFFFFFFFFu, m->indices = indices; }
static void triangles_more(pktrt_mesh_desc *m) { m->triangle_count = PKTRT_MAX_TRIANGLES - 160 + 1; }
static void triangles_wrap(pktrt_mesh_desc *m) { m->triangle_count = 0x55555556u; } /* times 3 is 2 in 32 bits */
static void bytes_wrap(pktrt_mesh_desc *m) {
  m->vertex_count = 0xFFFFFFFFu, m->position_stride = 0xFFFFFFFCu, m->key_count = 1024;
}
static void bytes_by_keys(pktrt_mesh_desc *m) { /* within the limit for one key, beyond it for four */
  m->vertex_count = 0x80000000u, m->position_stride = 0x40000000u, m->key_count = 4;
}
static void normal_nan(pktrt_mesh_desc *m) { odd_normals[3 * 4] = NAN, m->normals = odd_normals; }
static void normal_inf(pktrt_mesh_desc *m) { odd_normals[3 * 9 + 1] = INFINITY, m->normals = odd_normals; }
static void no_vertices(pktrt_mesh_desc *m) { m->vertex_count = 0, m->indices = indices; }

static const refusal add_refusals[] = {
    {"no positions", "positions", PKTRT_INVALID_ARGUMENT, no_positions},
    {"an index far out of range", "2|77|12", PKTRT_INVALID_ARGUMENT, index_high},
    {"an index one too high", "3|12", PKTRT_INVALID_ARGUMENT, index_just_high},
    {"the index 0xFFFFFFFF", "0|4294967295", PKTRT_INVALID_ARGUMENT, index_none},
    {"a soup with too few vertices", "5|12", PKTRT_INVALID_ARGUMENT, soup_long},
    {"indices without vertices", "4|vertices", PKTRT_INVALID_ARGUMENT, no_vertices},
    {"a NaN vertex", "7|NaN", PKTRT_INVALID_ARGUMENT, vertex_nan},
    {"an infinite vertex", "8|infinite", PKTRT_INVALID_ARGUMENT, vertex_inf},
    {"a minus infinite vertex", "11|infinite", PKTRT_INVALID_ARGUMENT, vertex_minus_inf},
    {"a NaN vertex in key 1", "5|1|NaN", PKTRT_INVALID_ARGUMENT, vertex_nan_key},
    {"a vertex beyond the largest coordinate", "6|1.5e+30", PKTRT_LIMIT, vertex_huge},
    {"a vertex just beyond it", "6|1.26765e+30", PKTRT_LIMIT, vertex_beyond},
    {"a NaN vertex among others of stride 16", "9|NaN", PKTRT_INVALID_ARGUMENT, vertex_nan_apart},
    {"a stride below 12", "8", PKTRT_INVALID_ARGUMENT, stride_small},
    {"a stride that is no multiple of 4", "13", PKTRT_INVALID_ARGUMENT, stride_odd},
    {"a stride of 14", "14", PKTRT_INVALID_ARGUMENT, stride_even},
    {"too many keys", "1025|1024", PKTRT_LIMIT, keys_many},
    {"4294967295 keys", "4294967295|1024", PKTRT_LIMIT, keys_most},
    {"4294967295 triangles", "4294967295", PKTRT_LIMIT, triangles_most},
    {"one triangle more than the scene may have", "160|2147483488|2147483647", PKTRT_LIMIT, triangles_more},
    {"a triangle count whose indices overflow", "1431655766", PKTRT_INVALID_ARGUMENT, triangles_wrap},
    {"sizes that overflow", "4294967295", PKTRT_LIMIT, bytes_wrap},
    {"sizes that overflow by the number of keys", "2147483648|1073741824|4", PKTRT_LIMIT, bytes_by_keys},
    {"a NaN normal", "4", PKTRT_INVALID_ARGUMENT, normal_nan},
    {"an infinite normal", "9", PKTRT_INVALID_ARGUMENT, normal_inf},
};

static pktrt_mesh_desc good_mesh(void) {
  pktrt_mesh_desc m;
  memset(&m, 0, sizeof m);
  rng r = rng_of(3);
  for (uint32_t i = 0; i < COUNT(soup); i++) soup[i] = rng_sign(&r);
  for (uint32_t i = 0; i < COUNT(indices); i++) indices[i] = i;
  for (uint32_t i = 0; i < COUNT(odd_normals); i++) odd_normals[i] = i % 3 == 2;
  m.positions = soup, m.vertex_count = 12, m.triangle_count = 4;
  return m;
}

static void refuse_meshes(void) {
  snapshot before, after;
  pktrt_scene *s = some_scene();
  take(s, &before);
  hooks.limit = (size_t)1 << 30; /* absurd sizes are to be seen before memory is asked for; if not, there is none */
  for (uint32_t i = 0; i < COUNT(add_refusals); i++) {
    const refusal *x = &add_refusals[i];
    pktrt_mesh_desc m = good_mesh();
    x->spoil(&m);
    uint32_t index = 4242;
    pktrt_status status = pktrt_add_mesh(s, &m, &index);
    CHECK(status == x->status, "%s: status %d, not %d: %s", x->what, (int)status, (int)x->status, pktrt_last_error(s));
    CHECK(index == 4242, "%s: index written", x->what);
    names(x->what, pktrt_last_error(s), x->words);
    names(x->what, pktrt_last_error(s), "mesh 3");
    take(s, &after);
    CHECK(same_snapshot(&before, &after), "%s: the scene changed", x->what);
  }
  hooks.limit = 0;
  CHECK(pktrt_add_mesh(s, NULL, NULL) == PKTRT_INVALID_ARGUMENT);
  names("NULL mesh desc", pktrt_last_error(s), "NULL");
  CHECK(pktrt_add_mesh(NULL, NULL, NULL) == PKTRT_INVALID_ARGUMENT);
  CHECK(pktrt_commit(s) == PKTRT_OK, "commit after refusals: %s", pktrt_last_error(s));
  take(s, &after);
  CHECK(same_snapshot(&before, &after), "commit after refusals changed the scene");
  pktrt_mesh_desc m = good_mesh(); /* the control: unspoilt it is accepted, and seen */
  uint32_t index = 0;
  CHECK(pktrt_add_mesh(s, &m, &index) == PKTRT_OK && index == 3, "%s", pktrt_last_error(s));
  CHECK(pktrt_commit(s) == PKTRT_OK);
  take(s, &after);
  CHECK(!same_snapshot(&before, &after), "a good mesh does change the scene");
  pktrt_scene_destroy(s);
}

/* What is just within the limits is accepted. */
static void accept_extremes(void) {
  static float many[PKTRT_MAX_KEYS * 9];
  pktrt_scene *s = some_scene();
  pktrt_mesh_desc m = good_mesh();
  soup[3 * 6] = PKTRT_MAX_COORD, soup[3 * 7 + 1] = -PKTRT_MAX_COORD, soup[3 * 8] = 0x1p-149f;
  CHECK(pktrt_add_mesh(s, &m, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  m.positions = many, m.vertex_count = 3, m.triangle_count = 1, m.key_count = PKTRT_MAX_KEYS;
  CHECK(pktrt_add_mesh(s, &m, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  memset(&m, 0, sizeof m);
  CHECK(pktrt_add_mesh(s, &m, NULL) == PKTRT_OK, "nothing at all: %s", pktrt_last_error(s));
  CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  pktrt_scene_destroy(s);
}

/* Without a scene there is nobody to keep a sentence. */
static void refuse_no_scene(void) {
  pktrt_mesh_desc m = good_mesh();
  pktrt_light l;
  pktrt_material material;
  pktrt_render_desc d;
  float pixels[3] = {0, 0, 0};
  memset(&l, 0, sizeof l), memset(&material, 0, sizeof material), memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = d.height = 1, d.pixels = pixels, d.camera.eye[2] = 1;
  const pktrt_status status[] = {pktrt_add_mesh(NULL, &m, NULL), pktrt_commit(NULL),
      pktrt_set_positions(NULL, 0, 0, soup), pktrt_set_normals(NULL, 0, 0, soup), pktrt_refit(NULL),
      pktrt_mark_changed(NULL), pktrt_add_light(NULL, &l, NULL), pktrt_add_material(NULL, &material, NULL),
      pktrt_render(NULL, &d), pktrt_render_tile(NULL, &d, 0, 0, 1, 1)};
  for (uint32_t i = 0; i < COUNT(status); i++)
    CHECK(status[i] == PKTRT_INVALID_ARGUMENT, "call %u: %d", i, (int)status[i]);
  pktrt_scene_info info;
  pktrt_get_scene_info(NULL, &info);
  CHECK(info.triangles == 0 && info.mesh_count == 0);
}

static void refuse_refit(void) {
  snapshot before, after;
  pktrt_scene *s = some_scene();
  take(s, &before);
  pktrt_mesh_desc m = good_mesh();
  CHECK(pktrt_add_mesh(s, &m, NULL) == PKTRT_OK && pktrt_add_mesh(s, &m, NULL) == PKTRT_OK);
  CHECK(pktrt_refit(s) == PKTRT_NOT_COMMITTED);
  names("a refit before the commit", pktrt_last_error(s), "mesh 3|commit");
  take(s, &after);
  CHECK(same_bits(before.hit, after.hit, sizeof before.hit) && before.info.mesh_count == after.info.mesh_count,
      "the scene changed");
  CHECK(pktrt_commit(s) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK, "the control");
  pktrt_scene_destroy(s);
}

static void refuse_updates(void) {
  float good[20 * 9], bad[20 * 9], normals[20 * 9];
  snapshot before, after;
  pktrt_scene *s = some_scene();
  take(s, &before);
  for (int i = 0; i < 180; i++) good[i] = bad[i] = 0.01f * (float)i, normals[i] = i % 3 == 0;
  struct {
    const char *what, *words;
    pktrt_status status;
    uint32_t mesh, key;
    bool normals, null;
    uint32_t at; /* which float is spoilt; 0: none */
    float value;
  } c[] = {
      {"positions of a mesh that does not exist", "3", PKTRT_INVALID_ARGUMENT, 3, 0, false, false, 0, 0},
      {"positions of mesh 4294967295", "4294967295", PKTRT_INVALID_ARGUMENT, PKTRT_NONE, 0, false, false, 0, 0},
      {"a key that does not exist", "1|3", PKTRT_INVALID_ARGUMENT, 1, 3, false, false, 0, 0},
      {"key 1 of a static mesh", "2|1", PKTRT_INVALID_ARGUMENT, 2, 1, false, false, 0, 0},
      {"NULL positions", "positions", PKTRT_INVALID_ARGUMENT, 2, 0, false, true, 0, 0},
      {"NaN positions", "2|17|NaN", PKTRT_INVALID_ARGUMENT, 2, 0, false, false, 17 * 3 + 1, NAN},
      {"infinite positions", "2|30|infinite", PKTRT_INVALID_ARGUMENT, 2, 0, false, false, 30 * 3 + 2, INFINITY},
      {"positions beyond the largest coordinate", "2|31", PKTRT_LIMIT, 2, 0, false, false, 31 * 3, 2e30f},
      {"normals of a mesh that does not exist", "7", PKTRT_INVALID_ARGUMENT, 7, 0, true, false, 0, 0},
      {"normals of a key that does not exist", "2|5", PKTRT_INVALID_ARGUMENT, 2, 5, true, false, 0, 0},
      {"normals of a mesh that has none", "0", PKTRT_INVALID_ARGUMENT, 0, 0, true, false, 0, 0},
      {"NULL normals", "normals", PKTRT_INVALID_ARGUMENT, 2, 0, true, true, 0, 0},
      {"NaN normals", "2|19", PKTRT_INVALID_ARGUMENT, 2, 0, true, false, 19 * 3, NAN},
  };
  for (uint32_t i = 0; i < COUNT(c); i++) {
    const float *from = c[i].normals ? normals : good;
    memcpy(bad, from, sizeof bad);
    if (c[i].at) bad[c[i].at] = c[i].value;
    const float *p = c[i].null ? NULL : bad;
    pktrt_status st =
        c[i].normals ? pktrt_set_normals(s, c[i].mesh, c[i].key, p) : pktrt_set_positions(s, c[i].mesh, c[i].key, p);
    CHECK(st == c[i].status, "%s: status %d: %s", c[i].what, (int)st, pktrt_last_error(s));
    names(c[i].what, pktrt_last_error(s), c[i].words);
    CHECK(pktrt_refit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
    take(s, &after);
    CHECK(same_snapshot(&before, &after), "%s: the scene changed", c[i].what);
  }
  CHECK(pktrt_set_positions(s, 2, 0, good) == PKTRT_OK && pktrt_set_normals(s, 2, 0, normals) == PKTRT_OK);
  CHECK(pktrt_refit(s) == PKTRT_OK);
  take(s, &after);
  CHECK(!same_snapshot(&before, &after), "good positions do change the scene");
  pktrt_scene_destroy(s);
}

/* Each vertex of many is looked at before the first is changed, and each that is added. */
static void refuse_each_vertex(void) {
  enum { MANY = 201 }; /* odd, as are its floats: the last of them is looked at, too */
  static float p[9 * MANY];
  for (int i = 0; i < 9 * MANY; i++) p[i] = 0.01f * (float)(i * i % 97);
  const pktrt_scene_desc of = scene_desc_of(PKTRT_ISA_AUTO, 0);
  pktrt_scene *s = pktrt_scene_create(&of);
  pktrt_mesh_desc d;
  memset(&d, 0, sizeof d);
  d.positions = d.normals = p, d.vertex_count = 3 * MANY, d.triangle_count = MANY;
  CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  pktrt_scene_report before, after;
  pktrt_get_scene_report(s, NULL, &before);
  for (uint32_t v = 0; v < 3 * MANY; v++) {
    char words[32];
    float *x = &p[3 * v + v % 3];
    const float kept = *x;
    (void)snprintf(words, sizeof words, "vertex %u", (unsigned)v);
    *x = NAN;
    CHECK(pktrt_set_positions(s, 0, 0, p) == PKTRT_INVALID_ARGUMENT, "%s is changed", words);
    names("set", pktrt_last_error(s), words);
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_INVALID_ARGUMENT, "%s is added", words);
    names("add", pktrt_last_error(s), words);
    CHECK(pktrt_set_normals(s, 0, 0, p) == PKTRT_INVALID_ARGUMENT, "normals of %s are changed", words);
    *x = kept;
    pktrt_get_scene_report(s, NULL, &after);
    CHECK(after.bytes == before.bytes, "%s: nothing waits for a refit", words);
  }
  pktrt_scene_destroy(s);
}

typedef struct spoilt_light {
  const char *words;
  pktrt_light_kind kind;
  size_t at; /* offset of the float that is spoilt */
  float value;
} spoilt_light;

static const spoilt_light spoilt_lights[] = {
    {"position|nan", PKTRT_LIGHT_POINT, offsetof(pktrt_light, position[1]), NAN},
    {"intensity|-0.25", PKTRT_LIGHT_POINT, offsetof(pktrt_light, intensity[2]), -0.25f},
    {"intensity|inf", PKTRT_LIGHT_POINT, offsetof(pktrt_light, intensity[1]), INFINITY},
    {"direction|inf", PKTRT_LIGHT_DIRECTIONAL, offsetof(pktrt_light, direction[0]), INFINITY},
    {"direction|nan", PKTRT_LIGHT_DIRECTIONAL, offsetof(pktrt_light, direction[2]), NAN},
    {"direction|zero", PKTRT_LIGHT_DIRECTIONAL, offsetof(pktrt_light, direction[1]), 0},
    {"intensity|nan", PKTRT_LIGHT_DIRECTIONAL, offsetof(pktrt_light, intensity[0]), NAN},
    {"intensity|-3", PKTRT_LIGHT_QUAD, offsetof(pktrt_light, intensity[0]), -3},
    {"position|inf", PKTRT_LIGHT_QUAD, offsetof(pktrt_light, position[0]), -INFINITY},
    {"edge[0]|nan", PKTRT_LIGHT_QUAD, offsetof(pktrt_light, edge[0][1]), NAN},
    {"edge[1]|inf", PKTRT_LIGHT_QUAD, offsetof(pktrt_light, edge[1][2]), INFINITY},
    {"position|nan", PKTRT_LIGHT_SPHERE, offsetof(pktrt_light, position[2]), NAN},
    {"radius|-0.5", PKTRT_LIGHT_SPHERE, offsetof(pktrt_light, radius), -0.5f},
    {"radius|nan", PKTRT_LIGHT_SPHERE, offsetof(pktrt_light, radius), NAN},
    {"position|1.5e+30", PKTRT_LIGHT_SPHERE, offsetof(pktrt_light, position[0]), 1.5e30f},
    {"direction|1.5e+30", PKTRT_LIGHT_DIRECTIONAL, offsetof(pktrt_light, direction[0]), 1.5e30f},
    {"edge[0]|-1.5e+30", PKTRT_LIGHT_QUAD, offsetof(pktrt_light, edge[0][2]), -1.5e30f},
    {"radius|1.5e+30", PKTRT_LIGHT_SPHERE, offsetof(pktrt_light, radius), 1.5e30f},
    {"radius|inf", PKTRT_LIGHT_SPHERE, offsetof(pktrt_light, radius), INFINITY},
    {"intensity|nan", PKTRT_LIGHT_MESH, offsetof(pktrt_light, intensity[1]), NAN},
    {"intensity|-1", PKTRT_LIGHT_ENVIRONMENT, offsetof(pktrt_light, intensity[2]), -1},
    {"intensity|inf", PKTRT_LIGHT_ENVIRONMENT, offsetof(pktrt_light, intensity[0]), INFINITY},
};

static pktrt_light good_light(pktrt_light_kind kind) {
  pktrt_light l;
  memset(&l, 0, sizeof l);
  l.kind = kind, l.direction[1] = -2, l.edge[0][0] = l.edge[1][2] = l.radius = 1;
  return l;
}

static void refuse_lights(void) {
  pktrt_scene *s = some_scene();
  uint32_t index = 4242;
  for (size_t i = 0; i < COUNT(spoilt_lights); i++) {
    pktrt_light l = good_light(spoilt_lights[i].kind);
    memcpy((char *)&l + spoilt_lights[i].at, &spoilt_lights[i].value, sizeof(float));
    CHECK(pktrt_add_light(s, &l, &index) == PKTRT_INVALID_ARGUMENT, "light %zu: %s", i, spoilt_lights[i].words);
    names("light", pktrt_last_error(s), spoilt_lights[i].words);
    names("light", pktrt_last_error(s), "light 0");
  }
  for (int kind = -1; kind <= PKTRT_LIGHT_KIND_COUNT; kind += PKTRT_LIGHT_KIND_COUNT + 1) {
    pktrt_light l = good_light((pktrt_light_kind)kind);
    char word[16];
    snprintf(word, sizeof word, "%d", kind);
    CHECK(pktrt_add_light(s, &l, &index) == PKTRT_INVALID_ARGUMENT);
    names("kind", pktrt_last_error(s), word);
  }
  CHECK(pktrt_add_light(s, NULL, &index) == PKTRT_INVALID_ARGUMENT);
  names("NULL light", pktrt_last_error(s), "NULL");
  CHECK(index == 4242, "refused calls write no index");
  for (int kind = 0; kind < PKTRT_LIGHT_KIND_COUNT; kind++) {
    pktrt_light l = good_light((pktrt_light_kind)kind);
    CHECK(pktrt_add_light(s, &l, &index) == PKTRT_OK && index == (uint32_t)kind, "the control: %u", index);
  }
  pktrt_scene_destroy(s);
}

typedef struct spoilt_material {
  const char *words;
  pktrt_specular specular;
  size_t at;
  float value;
} spoilt_material;

static const spoilt_material spoilt_materials[] = {
    {"albedo|-0.5", PKTRT_SPECULAR_NONE, offsetof(pktrt_material, albedo[0]), -0.5f},
    {"albedo|1.25", PKTRT_SPECULAR_NONE, offsetof(pktrt_material, albedo[1]), 1.25f},
    {"albedo|nan", PKTRT_SPECULAR_NONE, offsetof(pktrt_material, albedo[2]), NAN},
    {"albedo|inf", PKTRT_SPECULAR_NONE, offsetof(pktrt_material, albedo[0]), INFINITY},
    {"reflectance|-0.125", PKTRT_SPECULAR_MIRROR, offsetof(pktrt_material, reflectance[0]), -0.125f},
    {"reflectance|1.5", PKTRT_SPECULAR_CONDUCTOR, offsetof(pktrt_material, reflectance[1]), 1.5f},
    {"reflectance|nan", PKTRT_SPECULAR_COAT, offsetof(pktrt_material, reflectance[2]), NAN},
    {"albedo|reflectance|0.75|0.5", PKTRT_SPECULAR_MIRROR, offsetof(pktrt_material, reflectance[2]),
        0.75f}, /* albedo 0.5 */
    {"ior|-1.5", PKTRT_SPECULAR_DIELECTRIC, offsetof(pktrt_material, ior[0]), -1.5f},
    {"ior|nan", PKTRT_SPECULAR_COAT, offsetof(pktrt_material, ior[0]), NAN},
    {"ior|inf", PKTRT_SPECULAR_CONDUCTOR, offsetof(pktrt_material, ior[2]), INFINITY},
    {"extinction|-2", PKTRT_SPECULAR_CONDUCTOR, offsetof(pktrt_material, extinction[1]), -2},
    {"extinction|nan", PKTRT_SPECULAR_CONDUCTOR, offsetof(pktrt_material, extinction[0]), NAN},
    {"absorption|-0.5", PKTRT_SPECULAR_DIELECTRIC, offsetof(pktrt_material, absorption[2]), -0.5f},
    {"absorption|inf", PKTRT_SPECULAR_DIELECTRIC, offsetof(pktrt_material, absorption[0]), INFINITY},
    {"absorption|nan", PKTRT_SPECULAR_DIELECTRIC, offsetof(pktrt_material, absorption[1]), NAN},
    {"exponent|-1", PKTRT_SPECULAR_MIRROR, offsetof(pktrt_material, exponent), -1},
    {"exponent|nan", PKTRT_SPECULAR_MIRROR, offsetof(pktrt_material, exponent), NAN},
    {"exponent|inf", PKTRT_SPECULAR_MIRROR, offsetof(pktrt_material, exponent), INFINITY},
    {"ior|2e+06", PKTRT_SPECULAR_DIELECTRIC, offsetof(pktrt_material, ior[0]), 2e6f},
    {"extinction|2e+06", PKTRT_SPECULAR_CONDUCTOR, offsetof(pktrt_material, extinction[2]), 2e6f},
    {"exponent|2e+09", PKTRT_SPECULAR_MIRROR, offsetof(pktrt_material, exponent), 2e9f},
    {"emission|-4", PKTRT_SPECULAR_NONE, offsetof(pktrt_material, emission[1]), -4},
    {"emission|nan", PKTRT_SPECULAR_NONE, offsetof(pktrt_material, emission[0]), NAN},
    {"emission|inf", PKTRT_SPECULAR_NONE, offsetof(pktrt_material, emission[2]), INFINITY},
    {"transmission|1.5", PKTRT_SPECULAR_THIN, offsetof(pktrt_material, transmission), 1.5f},
    {"transmission|nan", PKTRT_SPECULAR_THIN, offsetof(pktrt_material, transmission), NAN},
    {"transparency|-1", PKTRT_SPECULAR_NONE, offsetof(pktrt_material, transparency), -1},
    {"transparency|nan", PKTRT_SPECULAR_NONE, offsetof(pktrt_material, transparency), NAN},
};

static pktrt_material good_material(pktrt_specular specular) {
  pktrt_material m;
  memset(&m, 0, sizeof m);
  m.albedo[0] = m.albedo[1] = m.albedo[2] = 0.5f;
  m.specular = specular, m.lobe = PKTRT_LOBE_PHONG, m.exponent = 10;
  return m;
}

static void refuse_materials(void) {
  pktrt_scene *s = some_scene();
  uint32_t index = 4242;
  for (size_t i = 0; i < COUNT(spoilt_materials); i++) {
    pktrt_material m = good_material(spoilt_materials[i].specular);
    memcpy((char *)&m + spoilt_materials[i].at, &spoilt_materials[i].value, sizeof(float));
    CHECK(
        pktrt_add_material(s, &m, &index) == PKTRT_INVALID_ARGUMENT, "material %zu: %s", i, spoilt_materials[i].words);
    names("material", pktrt_last_error(s), spoilt_materials[i].words);
    names("material", pktrt_last_error(s), "material 1");
  }
  for (int i = 0; i < 4; i++) {
    pktrt_material m = good_material(PKTRT_SPECULAR_NONE);
    char last[32];
    snprintf(last, sizeof last, "%d|specular", (int)PKTRT_SPECULAR_COUNT);
    if (i < 2) m.specular = (pktrt_specular)(i ? PKTRT_SPECULAR_COUNT : -1);
    else m.lobe = (pktrt_lobe)(i == 2 ? 2 : -1);
    CHECK(pktrt_add_material(s, &m, &index) == PKTRT_INVALID_ARGUMENT, "case %d", i);
    names("kind", pktrt_last_error(s), i == 0 ? "-1|specular" : i == 1 ? last : i == 2 ? "2|lobe" : "-1|lobe");
  }
  CHECK(pktrt_add_material(s, NULL, &index) == PKTRT_INVALID_ARGUMENT);
  names("NULL material", pktrt_last_error(s), "NULL");
  CHECK(index == 4242, "refused calls write no index");
  for (int i = 0; i < PKTRT_SPECULAR_COUNT; i++) {
    pktrt_material m = good_material((pktrt_specular)i);
    CHECK(pktrt_add_material(s, &m, &index) == PKTRT_OK && index == (uint32_t)i + 1, "the control: %u", index);
  }
  pktrt_scene_destroy(s);
}

/* A light that names a mesh is looked at when rendering. */
static void refuse_mesh_lights(void) {
  float pixels[12];
  pktrt_light l = good_light(PKTRT_LIGHT_MESH);
  pktrt_render_desc d;
  memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = d.height = 2, d.pixels = pixels, d.camera.eye[2] = 5;
  static const uint32_t index[] = {2, 3, 17, PKTRT_NONE}; /* the last that is committed; one that is not; none */
  static const char *const named[] = {"", "0|3", "0|17|3", "0|4294967295|3"};
  for (uint32_t i = 0; i < COUNT(index); i++) {
    pktrt_scene *s = some_scene();
    pktrt_mesh_desc m = good_mesh();
    if (i) CHECK(pktrt_add_mesh(s, &m, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
    l.mesh = index[i];
    for (int k = 0; k < 12; k++) pixels[k] = -7;
    CHECK(pktrt_add_light(s, &l, NULL) == PKTRT_OK);
    for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++) {
      d.mode = (pktrt_mode)mode;
      CHECK(pktrt_render(s, &d) == (i ? PKTRT_INVALID_ARGUMENT : PKTRT_OK), "mesh %u: %s", l.mesh, pktrt_last_error(s));
      CHECK((pixels[0] == -7) == (i > 0), "nothing is painted");
      if (i) names("mesh light", pktrt_last_error(s), named[i]);
    }
    pktrt_scene_destroy(s);
  }
}

/* --- render --- */

static float in_the_middle(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  (void)user, (void)x, (void)y, (void)sample, (void)dimension, (void)seed;
  return 0.5f;
}

/* Every enumerator of a render below its first and above its last value; render.c has what else may be wrong with it. */
static void refuse_words(void) {
  static const struct {
    size_t at;
    int count;
    const char *name;
  } words[] = {
      {offsetof(pktrt_render_desc, mode), 3, "pktrt_mode"},
      {offsetof(pktrt_render_desc, path), 3, "pktrt_path"},
      {offsetof(pktrt_render_desc, normals), 2, "pktrt_normals"},
      {offsetof(pktrt_render_desc, shadows), 2, "pktrt_shadow_packets"},
      {offsetof(pktrt_render_desc, sampler), PKTRT_SAMPLER_CUSTOM + 1, "pktrt_sampler"},
      {offsetof(pktrt_render_desc, assembly), 6, "pktrt_assembly"},
      {offsetof(pktrt_render_desc, branching), 4, "pktrt_branching"},
      {offsetof(pktrt_render_desc, lights), PKTRT_LIGHTS_ONE + 1, "pktrt_light_choice"},
      {offsetof(pktrt_render_desc, glass_shadows), 2, "pktrt_glass_shadows"},
      {offsetof(pktrt_render_desc, phong_mapping), 2, "pktrt_phong_mapping"},
      {offsetof(pktrt_render_desc, measure), 3, "pktrt_error_measure"},
      {offsetof(pktrt_render_desc, display_tone), 2, "pktrt_tone"},
      {offsetof(pktrt_render_desc, cost_of), 3, "pktrt_cost"},
  };
  pktrt_scene *s = some_scene();
  float pixels[3] = {-7, -7, -7};
  for (uint32_t i = 0; i < COUNT(words); i++) {
    for (int value = -1; value <= words[i].count; value++) {
      pktrt_render_desc d;
      char number[16];
      memset(&d, 0, sizeof d);
      d.samples = 1;
      d.width = d.height = 1, d.pixels = pixels, d.camera.eye[2] = 5, d.custom_sampler = in_the_middle;
      memcpy((char *)&d + words[i].at, &value, sizeof value); /* enumerations are as large as int here */
      const bool good = value >= 0 && value < words[i].count;
      snprintf(number, sizeof number, "%d", value);
      if (!good) pixels[0] = -7;
      CHECK(pktrt_render(s, &d) == (good ? PKTRT_OK : PKTRT_INVALID_ARGUMENT), "%s %d", words[i].name, value);
      if (good) continue;
      CHECK(pixels[0] == -7, "%s %d paints", words[i].name, value);
      names(words[i].name, pktrt_last_error(s), words[i].name);
      names(words[i].name, pktrt_last_error(s), number);
    }
  }
  pktrt_scene_destroy(s);
}

static bool at_once(void *user, float done) {
  (void)user, (void)done;
  return false;
}

/* What a render's sentence says where render.c asks for the status alone. */
static void refuse_renders(void) {
  pktrt_scene *s = some_scene();
  float pixels[12];
  static const struct {
    const char *words;
    pktrt_status status;
  } want[] = {
      {"description|NULL", PKTRT_INVALID_ARGUMENT},
      {"eye|target|same point", PKTRT_INVALID_ARGUMENT},
      {"up|parallel|time 0", PKTRT_INVALID_ARGUMENT},
      {"camera|y of eye|nan", PKTRT_INVALID_ARGUMENT},
      {"camera|z of target|inf", PKTRT_INVALID_ARGUMENT},
      {"camera|x of up|1.5e+30", PKTRT_INVALID_ARGUMENT},
      {"camera|fov_y|nan", PKTRT_INVALID_ARGUMENT},
      {"camera|time|nan", PKTRT_INVALID_ARGUMENT},
      {"background[1]|nan", PKTRT_INVALID_ARGUMENT},
      {"ambient[2]|inf", PKTRT_INVALID_ARGUMENT},
      {"aperture|1.5e+30", PKTRT_INVALID_ARGUMENT},
      {"focus|1.5e+30", PKTRT_INVALID_ARGUMENT},
      {"row_stride|5", PKTRT_INVALID_ARGUMENT},
      {"packet_size|1", PKTRT_INVALID_ARGUMENT},
      {"tiles|4294967296", PKTRT_LIMIT},
      {"progress|stop", PKTRT_CANCELLED},
      {"up|parallel|time 1", PKTRT_INVALID_ARGUMENT},
  };
  for (uint32_t i = 0; i < COUNT(want); i++) {
    pktrt_render_desc d;
    memset(&d, 0, sizeof d);
    d.samples = 1;
    d.width = d.height = 2, d.pixels = pixels, d.camera.eye[2] = 5, d.tile_size = 1;
    switch (i) {
    case 1: d.camera.target[2] = 5; break;
    case 2: d.camera.up[2] = 3; break;
    case 3: d.camera.eye[1] = NAN; break;
    case 4: d.camera.target[2] = INFINITY; break;
    case 5: d.camera.up[0] = 1.5e30f; break;
    case 6: d.camera.fov_y = NAN; break;
    case 7: d.camera.time = NAN; break;
    case 8: d.background[1] = NAN; break;
    case 9: d.ambient[2] = INFINITY; break;
    case 10: d.camera.aperture = 1.5e30f; break;
    case 11: d.camera.focus = 1.5e30f; break;
    case 12: d.row_stride = 5; break;
    case 13: d.packet_size = 1; break;
    case 14: d.width = d.height = 65536; break;
    case 15: d.progress = at_once; break;
    case 16: d.camera.moving = true, d.camera.eye_end[0] = 1, d.camera.up_end[0] = -1; break;
    default: break;
    }
    const pktrt_status status = pktrt_render(s, i ? &d : NULL);
    CHECK(status == want[i].status, "%s: status %d", want[i].words, (int)status);
    names("render", pktrt_last_error(s), want[i].words);
  }
  pktrt_scene_destroy(s);
}

/* Without mutable globals there is one sentence for all: it lists the reasons. */
static void refuse_create(void) {
  pktrt_scene_desc good = scene_desc_of(PKTRT_ISA_AUTO, 0), d;
  d = good, d.release = NULL;
  CHECK(pktrt_scene_create(&d) == NULL);
  names("allocate alone", pktrt_last_error(NULL), "release");
  d = good, d.allocate = NULL;
  CHECK(pktrt_scene_create(&d) == NULL);
  names("release alone", pktrt_last_error(NULL), "allocate");
  int refused = 0;
  for (int i = PKTRT_ISA_SCALAR; i < PKTRT_ISA_COUNT; i++) {
    d = good, d.isa = (pktrt_isa)i;
    pktrt_scene *s = pktrt_scene_create(&d);
    CHECK((s != NULL) == pktrt_isa_available((pktrt_isa)i), "isa %d", i);
    if (s) {
      pktrt_scene_info info;
      pktrt_get_scene_info(s, &info);
      CHECK(info.isa == (pktrt_isa)i, "asked for %d, got %d", i, (int)info.isa);
    } else {
      refused++;
      names("unavailable isa", pktrt_last_error(NULL), "instruction set");
    }
    pktrt_scene_destroy(s);
  }
  CHECK(refused > 0, "no machine has x86 and ARM vectors");
  d = good, d.isa = (pktrt_isa)99;
  CHECK(pktrt_scene_create(&d) == NULL);
  names("isa 99", pktrt_last_error(NULL), "range");
  for (int i = 0; i < 5; i++) {
    d = good;
    if (i < 2) d.quality = (pktrt_build_quality)(i ? -1 : PKTRT_BUILD_HIGH + 1);
    else if (i < 4) d.rebuild = (pktrt_rebuild)(i == 3 ? -1 : PKTRT_REBUILD_AUTOMATIC + 1);
    else d.isa = (pktrt_isa)-1;
    CHECK(pktrt_scene_create(&d) == NULL, "case %d", i);
    names("an enumerator", pktrt_last_error(NULL), "range");
  }
  hooks.fail_at = 1;
  CHECK(pktrt_scene_create(&good) == NULL);
  names("create without memory", pktrt_last_error(NULL), "memory");
  hooks.fail_at = 0;
  pktrt_scene *s = pktrt_scene_create(NULL); /* all defaults */
  pktrt_scene_desc zero;
  memset(&zero, 0, sizeof zero);
  pktrt_scene *z = pktrt_scene_create(&zero);
  CHECK(s != NULL && z != NULL);
  CHECK(pktrt_last_error(s) != NULL && pktrt_last_error(s)[0] == 0, "nothing failed yet");
  CHECK(pktrt_commit(s) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK);
  pktrt_scene_destroy(s);
  pktrt_scene_destroy(z);
  pktrt_scene_destroy(NULL);
}

/* The library of the tests, and the copy of noslack.c, for which no instruction set was asked. */
typedef struct library {
  const char *name;
  pktrt_scene *(*create)(const pktrt_scene_desc *);
  const char *(*error)(void);
  void (*destroy)(pktrt_scene *);
  bool asks_avx512, asks_scalar;
} library;

static const char *own_error(void) { return pktrt_last_error(NULL); }

#ifdef PKTRT_AVX512
enum { ASKS_AVX512 = 1 };
#else
enum { ASKS_AVX512 = 0 };
#endif
#ifdef PKTRT_SCALAR
enum { ASKS_SCALAR = 1 };
#else
enum { ASKS_SCALAR = 0 };
#endif
static const library libraries[2] = {
    {"the tests' library", pktrt_scene_create, own_error, pktrt_scene_destroy, ASKS_AVX512, ASKS_SCALAR},
    {"the default", noslack_create, noslack_error, noslack_destroy, false, false}};

/* Tells whether PKTRT_AVX512 would have an effect on this build. */
static bool may_have_avx512(void) {
#if !(defined(__x86_64__) || (defined(__i386__) && defined(__SSE2__))) || (defined(__MINGW32__) && !defined(__clang__))
  return false;
#elif defined(PKTRT_NO_SIMD) || defined(PKTRT_NO_AVX512)
  return false;
#else
  return true;
#endif
}

static bool machine_has_avx512(void) {
#if defined(__x86_64__) || defined(__i386__)
  return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
         __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
#else
  return false;
#endif
}

/* Returns whether a library has a set, by making a scene. */
static bool library_has(const library *l, pktrt_isa isa) {
  const pktrt_scene_desc d = scene_desc_of(isa, 0);
  pktrt_scene *s = l->create(&d);
  l->destroy(s);
  return s != NULL;
}

static void sets_are_asked_for(void) {
  for (size_t i = 0; i < COUNT(libraries); i++) {
    const library *l = &libraries[i];
    const bool scalar = library_has(l, PKTRT_ISA_SCALAR), wide = library_has(l, PKTRT_ISA_AVX512);
    const bool others = library_has(l, PKTRT_ISA_SSE2) || library_has(l, PKTRT_ISA_NEON) ||
                        library_has(l, PKTRT_ISA_WASM) || library_has(l, PKTRT_ISA_AVX2) || wide;
    CHECK(wide == (l->asks_avx512 && may_have_avx512() && machine_has_avx512()), "%s: AVX-512 is %d", l->name, wide);
#ifndef PKTRT_NO_SCALAR
    if (others) CHECK(scalar == l->asks_scalar, "%s: scalar kernels are %d", l->name, scalar);
#endif
    CHECK(scalar || others, "%s has nothing", l->name);

    const bool names_avx512 = strstr(l->error(), "PKTRT_AVX512") != NULL;
    const bool names_scalar = strstr(l->error(), "PKTRT_SCALAR") != NULL;
    CHECK(names_avx512 == (may_have_avx512() && !l->asks_avx512), "%s: %s", l->name, l->error());
    CHECK(names_scalar == !scalar, "%s: %s", l->name, l->error());
  }
}

/* Who could use AVX-512 is told once for each scene, whatever is made within it; not if an instruction set was asked for. */
static void wider_sets_are_told(void) {
  placement p;
  memset(&p, 0, sizeof p);
  p.model[0] = world_of(mesh_box()), p.models = p.n = 1, p.keys[0] = 1;
  for (int a = 0; a < 3; a++) p.transform[0][5 * a] = 1;

  for (size_t i = 0; i < COUNT(libraries); i++) {
    const library *l = &libraries[i];
    const int tells = machine_has_avx512() && may_have_avx512() && !l->asks_avx512;
    pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
    pktrt_scene *s[2];

    hooks.notes = hooks.warnings = 0, hooks.last_log[0] = 0;
    for (int k = 0; k < 2; k++) {
      s[k] = l->create(&d);
      CHECK(s[k] && hooks.notes == (k + 1) * tells && !hooks.warnings, "%s: %d notes", l->name, hooks.notes);
    }
    CHECK((strstr(hooks.last_log, "PKTRT_AVX512") != NULL) == tells, "%s: %s", l->name, hooks.last_log);
    for (int k = 0; k < 2; k++) l->destroy(s[k]);

    for (int isa = PKTRT_ISA_SCALAR; isa < PKTRT_ISA_COUNT; isa++) (void)library_has(l, (pktrt_isa)isa);
    d.log = NULL;
    l->destroy(l->create(&d));
    CHECK(hooks.notes == 2 * tells, "%s: %d notes more", l->name, hooks.notes - 2 * tells);
    say("%s: told %d times of AVX-512", l->name, hooks.notes);
  }

  const int before = hooks.notes;
  pktrt_scene *s = noslack_placed(&p, PKTRT_ISA_AUTO);
  CHECK(s && hooks.notes == before + (before > 0), "with a model and an instance: %d notes", hooks.notes - before);
  noslack_destroy(s);
  world_free(&p.model[0]);
}

static void strings(void) {
  for (int i = -2; i < 9; i++) {
    const char *t = pktrt_status_string((pktrt_status)i);
    CHECK(t && strlen(t) > 3, "status %d", i);
    for (int j = 0; j < i && i <= PKTRT_CANCELLED; j++) CHECK(strcmp(t, pktrt_status_string((pktrt_status)j)) != 0);
  }
  static const char *const name[] = {"auto", "scalar", "sse2", "avx2", "avx512", "neon", "wasm"};
  CHECK(COUNT(name) == PKTRT_ISA_COUNT, "a name for each instruction set");
  for (int i = 0; i < (int)COUNT(name); i++) CHECK(strcmp(pktrt_isa_string((pktrt_isa)i), name[i]) == 0, "%d", i);
  for (int i = -2; i < 80; i++) { /* what has no name is unknown, the first behind the last too */
    if (i >= 0 && i < PKTRT_ISA_COUNT) continue;
    CHECK(strcmp(pktrt_isa_string((pktrt_isa)i), "unknown") == 0, "%d", i);
  }
  CHECK(pktrt_isa_available(PKTRT_ISA_AUTO));
  CHECK(isa_count > 0);
  CHECK(!pktrt_isa_available((pktrt_isa)77) && !pktrt_isa_available((pktrt_isa)-1));
}

/* The detail stays until the next change; queries do not touch it. */
static void detail_lives(void) {
  pktrt_scene *s = some_scene();
  CHECK(pktrt_set_positions(s, 55, 0, soup) == PKTRT_INVALID_ARGUMENT);
  char detail[300];
  snprintf(detail, sizeof detail, "%s", pktrt_last_error(s));
  snapshot x;
  take(s, &x);
  CHECK(strcmp(detail, pktrt_last_error(s)) == 0);
  pktrt_scene *other = some_scene();
  CHECK(pktrt_set_positions(other, 66, 0, soup) == PKTRT_INVALID_ARGUMENT);
  CHECK(strcmp(detail, pktrt_last_error(s)) == 0, "each scene has its own");
  pktrt_scene_destroy(other);
  pktrt_scene_destroy(s);
}

void suite_refusals(void) {
  run("bad meshes are refused by name and leave the scene as it was", refuse_meshes);
  run("bad positions and normals are refused by name and leave the scene as it was", refuse_updates);
  run("each vertex that is not finite is refused by name", refuse_each_vertex);
  run("what is just within the limits is accepted", accept_extremes);
  run("calls without a scene are refused", refuse_no_scene);
  run("a refit that needs a commit is refused by name", refuse_refit);
  run("bad lights are refused by name", refuse_lights);
  run("bad materials are refused by name", refuse_materials);
  run("a light that is a mesh which does not exist is refused when rendering", refuse_mesh_lights);
  run("every enumerator of a render is refused by name on both its ends", refuse_words);
  run("what a render refuses is said", refuse_renders);
  run("a create that fails says why", refuse_create);
  run("instruction sets that must be asked for are there if they were, and who lacks them is told the macro",
      sets_are_asked_for);
  run("where a build could use AVX-512 and has it not, each scene tells the log hook once", wider_sets_are_told);
  run("every status and instruction set has its string", strings);
  run("the last error stays until the next change", detail_lives);
}
