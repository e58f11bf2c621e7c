/* Materials of triangles, and meshes that share a pool of vertices: a mesh of several materials is compared with a mesh for
   each, and a mesh of a pool with one that has its vertices alone. */
#include "pictures.h"

enum { SIDE = 24, KINDS = 7 };

/* --- pools --- */

/* Vertices of many things, in one array, with the material of each triangle. */
typedef struct pool {
  float *p, *n, *t; /* normals, texture coordinates; not NULL */
  uint32_t *i, *material, nv, nt, keys;
} pool;

static void *fresh(size_t count, size_t size) {
  void *p = calloc(count ? count : 1, size);
  if (!p) abort();
  return p;
}
static pool pool_of(uint32_t nv, uint32_t nt, uint32_t keys) {
  pool q = {fresh(3u * nv * keys, 4), fresh(3u * nv * keys, 4), fresh(2u * nv, 4), fresh(3u * nt, 4), fresh(nt, 4), nv,
      nt, keys};
  return q;
}
static void pool_free(pool *q) { free(q->p), free(q->n), free(q->t), free(q->i), free(q->material); }
static pktrt_mesh_desc pool_desc(const pool *q) {
  pktrt_mesh_desc d;
  memset(&d, 0, sizeof d);
  d.positions = q->p, d.normals = q->n, d.texcoords = q->t, d.indices = q->i;
  d.vertex_count = q->nv, d.triangle_count = q->nt, d.key_count = q->keys, d.triangle_materials = q->material;
  return d;
}

/* Balls and boxes, of material 0, 1, 2, ...: in a ring, but that thing 2, of glass, holds two others. Their triangles and vertices are shuffled among each other. */
static pool pool_of_things(uint32_t things, uint32_t keys, uint64_t seed) {
  rng r = rng_of(seed);
  uint32_t nv = 0, nt = 0;
  for (int pass = 0; pass < 2; pass++) {
    static pool q;
    static uint32_t *at;
    if (pass) {
      q = pool_of(nv, nt, keys), at = fresh(nv, 4);
      for (uint32_t v = 0; v < nv; v++) {
        const uint32_t other = rng_below(&r, v + 1);
        at[v] = at[other], at[other] = v;
      }
      nv = nt = 0;
    }
    for (uint32_t k = 0; k < things; k++) {
      mesh m = k % 3 == 1 ? mesh_box() : mesh_sphere(2, 0, k);
      m.nt -= k == 0; /* which is open, so that they all together are */
      const double turn = 2 * PI * k / things;
      const bool within = k == 3 || k == 4; /* in thing 2; the latter is behind the former */
      mesh_scale(&m, within ? 0.2f : k == 2 ? 0.7f : 0.3f);
      if (within) mesh_shift(&m, 0.05f, 0.1f, k == 3 ? 0.7f : 0);
      else if (k == 2) mesh_shift(&m, 0, 0, 0.3f);
      else mesh_shift(&m, (float)(1.3 * cos(turn)), (float)(1.1 * sin(turn)), k % 2 ? 0.2f : -0.3f);
      for (uint32_t v = 0; pass && v < m.nv; v++) {
        double sum = 0;
        for (uint32_t key = 0; key < keys; key++)
          for (int a = 0; a < 3; a++)
            q.p[3 * (key * q.nv + at[nv + v]) + (uint32_t)a] =
                m.p[3 * v + (uint32_t)a] + (a == (int)(k % 3) ? 0.1f * (float)key : 0);
        for (int a = 0; a < 3; a++) sum += (double)m.p[3 * v + (uint32_t)a] * (double)m.p[3 * v + (uint32_t)a];
        for (uint32_t key = 0; key < keys; key++)
          for (uint32_t a = 0; a < 3; a++)
            q.n[3 * (key * q.nv + at[nv + v]) + a] = (float)((double)m.p[3 * v + a] / sqrt(sum)) + 0.05f * (float)key;
        for (uint32_t a = 0; a < 2; a++) q.t[2 * at[nv + v] + a] = m.p[3 * v + a];
      }
      for (uint32_t t = 0; pass && t < m.nt; t++) {
        for (uint32_t c = 0; c < 3; c++) q.i[3 * (nt + t) + c] = at[nv + m.i[3 * t + c]];
        q.material[nt + t] = k;
      }
      nv += m.nv, nt += m.nt;
      mesh_free(&m);
    }
    if (!pass) continue;
    for (uint32_t t = 0; t < nt; t++) {
      const uint32_t other = rng_below(&r, t + 1);
      for (uint32_t c = 0; c < 3; c++) {
        const uint32_t swap = q.i[3 * t + c];
        q.i[3 * t + c] = q.i[3 * other + c], q.i[3 * other + c] = swap;
      }
      const uint32_t swap = q.material[t];
      q.material[t] = q.material[other], q.material[other] = swap;
    }
    free(at);
    return q;
  }
  abort();
}

/* The triangles of one material of a pool, over all its vertices, or over its own alone. */
static pool part_of(const pool *q, uint32_t material, bool own) {
  uint32_t *number = fresh(q->nv, 4), nv = 0, nt = 0;
  for (uint32_t t = 0; t < q->nt; t++) {
    if (q->material[t] != material) continue;
    for (uint32_t c = 0; c < 3; c++) number[q->i[3 * t + c]] = 1;
    nt++;
  }
  for (uint32_t v = 0; v < q->nv; v++)
    if (number[v] || !own) number[v] = nv++;
    else number[v] = PKTRT_NONE;
  pool r = pool_of(nv, nt, q->keys);
  for (uint32_t v = 0; v < q->nv; v++) {
    if (number[v] == PKTRT_NONE) continue;
    for (uint32_t key = 0; key < q->keys; key++) {
      memcpy(r.p + 3 * (key * nv + number[v]), q->p + 3 * (key * q->nv + v), 12);
      memcpy(r.n + 3 * (key * nv + number[v]), q->n + 3 * (key * q->nv + v), 12);
    }
    memcpy(r.t + 2 * number[v], q->t + 2 * v, 8);
  }
  nt = 0;
  for (uint32_t t = 0; t < q->nt; t++) {
    if (q->material[t] != material) continue;
    for (uint32_t c = 0; c < 3; c++) r.i[3 * nt + c] = number[q->i[3 * t + c]];
    r.material[nt++] = material;
  }
  free(number);
  return r;
}

/* --- what they are made of --- */

/* Transparent in stripes. */
static void stripes(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t k = 0; k < p->n; k++) {
    const float x = p->texcoord[0][k] * 9;
    p->opacity[k] = x - floorf(x) < 0.5f ? 0.0f : 1.0f;
    p->albedo[1][k] = 0.1f;
  }
}

/* Materials 1 to KINDS - 1: mirror, two glasses, gloss, a cutout, what shines. 0 is the default. */
static void add_materials(pktrt_scene *s) {
  pktrt_material m = material_of(0.1, PKTRT_SPECULAR_MIRROR, 0.8);
  stage_material(s, &m);
  m = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  m.ior[0] = 1.5f, m.absorption[0] = 2, m.absorption[1] = 0.5f;
  stage_material(s, &m);
  m.ior[0] = 1.2f, m.absorption[0] = 0, m.absorption[2] = 3;
  stage_material(s, &m);
  m = material_of(0.3, PKTRT_SPECULAR_COAT, 0);
  m.lobe = PKTRT_LOBE_PHONG, m.exponent = 30;
  stage_material(s, &m);
  m = material_of(0.8, PKTRT_SPECULAR_NONE, 0);
  m.texture = stripes, m.cutout = true;
  stage_material(s, &m);
  m = lamp_of(2);
  m.emission[1] = 0.5f;
  stage_material(s, &m);
}
static void add_surroundings(pktrt_scene *s) {
  pktrt_light l = light_of(PKTRT_LIGHT_POINT, 9), area = light_of(PKTRT_LIGHT_SPHERE, 4);
  const quad wall = quad_of(vec_of(0, 0, -1.5), vec_of(4, 0, 0), vec_of(0, 4, 0));
  l.position[0] = 1, l.position[1] = 2, l.position[2] = 3;
  area.position[0] = -2, area.position[2] = 2, area.radius = 0.3f, area.visible = true;
  stage_light(s, &l), stage_light(s, &area);
  stage_quad(s, &wall, 0);
}

static void look_from(pktrt_scene *s, pktrt_mode mode, pktrt_light_choice lights, vec eye, float *pixels) {
  pktrt_render_desc d = stage_view(mode, SIDE, SIDE, pixels, eye, vec_of(0, 0, 0));
  d.samples = mode == PKTRT_MODE_DRT ? 4 : 1, d.lights = lights;
  d.camera.shutter = 1, d.max_depth = 5;
  stage_render(s, &d);
}
/* Counts pictures, of all modes, that differ; the camera stands before the things, and in one. */
static size_t pictures_differ(pktrt_scene *a, pktrt_scene *b) {
  static float x[3 * SIDE * SIDE], y[3 * SIDE * SIDE];
  size_t differ = 0;
  for (int i = 0; i < 8; i++) {
    const pktrt_mode mode = i < 6 ? (pktrt_mode)(i % 3) : PKTRT_MODE_DRT;
    const vec eye = i / 3 % 2 ? vec_of(0.35, 0.2, 0.35) : vec_of(0.3, 0.2, 4); /* the former in thing 2 */
    const pktrt_light_choice lights = i < 6 ? PKTRT_LIGHTS_ALL : PKTRT_LIGHTS_ONE;
    look_from(a, mode, lights, eye, x), look_from(b, mode, lights, eye, y);
    differ += !same_bits(x, y, sizeof x);
  }
  return differ;
}

static pktrt_scene *scene_of_pool(const pool *q, uint32_t kinds, bool apart, bool own) {
  pktrt_scene *s = stage_open();
  add_materials(s);
  add_surroundings(s);
  if (!apart) {
    const pktrt_mesh_desc d = pool_desc(q);
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  }
  for (uint32_t k = 0; apart && k < kinds; k++) {
    pool part = part_of(q, k, own);
    pktrt_mesh_desc d = pool_desc(&part);
    d.triangle_materials = NULL, d.material = k;
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
    pool_free(&part);
  }
  stage_commit(s);
  return s;
}

static void one_mesh_is_many(void) {
  for (uint32_t keys = 1; keys <= 2; keys++) {
    pool q = pool_of_things(KINDS, keys, 3 + keys);
    pktrt_scene *one = scene_of_pool(&q, KINDS, false, false), *many = scene_of_pool(&q, KINDS, true, true),
                *over = scene_of_pool(&q, KINDS, true, false);
    CHECK(pictures_differ(one, many) == 0, "%u keys: %zu pictures differ", keys, pictures_differ(one, many));
    CHECK(pictures_differ(over, many) == 0, "%u keys, pools: %zu pictures differ", keys, pictures_differ(over, many));
    uint32_t t = 0;
    while (q.material[t] != 2) t++;
    q.material[t] = 3; /* the control: glass that is open */
    pktrt_scene *other = scene_of_pool(&q, KINDS, false, false);
    CHECK(pictures_differ(one, other) > 0, "one triangle of another glass is not seen");
    pktrt_scene_destroy(one), pktrt_scene_destroy(many), pktrt_scene_destroy(over), pktrt_scene_destroy(other);
    pool_free(&q);
  }
}

static void models_too(void) {
  static const float place[12] = {0.9f, 0.1f, 0, 0.1f, -0.1f, 0.9f, 0, 0, 0, 0.1f, -1.1f, 0.1f}; /* mirrored */
  pool q = pool_of_things(KINDS, 1, 5);
  pktrt_scene *s[2];
  uint32_t instance = 0;
  for (int apart = 0; apart < 2; apart++) {
    pktrt_mesh_desc d[KINDS];
    pool part[KINDS];
    pktrt_instance_desc in;
    uint32_t model = 0;
    s[apart] = stage_open();
    memset(&in, 0, sizeof in);
    add_materials(s[apart]), add_surroundings(s[apart]);
    d[0] = pool_desc(&q);
    for (uint32_t k = 0; k < KINDS; k++) {
      part[k] = part_of(&q, k, true);
      if (!apart) continue;
      d[k] = pool_desc(&part[k]);
      d[k].triangle_materials = NULL, d[k].material = k;
    }
    CHECK(pktrt_add_model(s[apart], d, apart ? KINDS : 1, &model) == PKTRT_OK, "%s", pktrt_last_error(s[apart]));
    in.model = model, in.transforms = place;
    CHECK(pktrt_add_instance(s[apart], &in, &instance) == PKTRT_OK, "%s", pktrt_last_error(s[apart]));
    stage_commit(s[apart]);
    for (int k = 0; k < KINDS; k++) pool_free(&part[k]);
  }
  CHECK(pictures_differ(s[0], s[1]) == 0, "%zu pictures differ", pictures_differ(s[0], s[1]));

  pktrt_ray ray = {{0.1f, 0.1f, 5}, 0, {0, 0, -1}, INFINITY, 0};
  size_t seen = 0, wrong = 0;
  for (int i = 0; i < 400; i++) {
    pktrt_hit hit;
    pktrt_surface_info x;
    ray.origin[0] = (float)(i % 20) * 0.15f - 1.5f, ray.origin[1] = (float)(i / 20) * 0.15f - 1.5f;
    if (!pktrt_intersect(s[0], &ray, &hit) || hit.mesh == 0) continue;
    pktrt_surface(s[0], &ray, &hit, &x);
    seen++, wrong += x.material != q.material[hit.triangle] || x.instance != instance;
  }
  CHECK(seen > 50 && wrong == 0, "%zu of %zu hits", wrong, seen);
  CHECK(pktrt_remove_instance(s[0], instance) == PKTRT_OK);
  stage_commit(s[0]);
  CHECK(pktrt_remove_model(s[0], 0) == PKTRT_OK, "%s", pktrt_last_error(s[0]));
  pktrt_scene_destroy(s[0]), pktrt_scene_destroy(s[1]);
  pool_free(&q);
}

/* --- pools, and what is asked of them --- */

/* Compares what rays find in meshes over a pool with what they find in meshes that have their vertices alone. Counts hits
   of all meshes but the wall. */
static size_t hits_differ(const pktrt_scene *a, const pktrt_scene *b, uint64_t seed, uint32_t wall, size_t *hits) {
  rng r = rng_of(seed);
  size_t differ = 0;
  for (int i = 0; i < 4000; i++) {
    const float from[3] = {rng_range(&r, -2, 2), rng_range(&r, -2, 2), 4},
                to[3] = {rng_range(&r, -0.3f, 0.3f), rng_range(&r, -0.3f, 0.3f), -1};
    pktrt_ray ray = pktrt_make_ray(from, to);
    pktrt_hit x, y;
    pktrt_surface_info u, v;
    ray.time = rng_range(&r, 0, 1);
    const bool hit = pktrt_intersect(a, &ray, &x), also = pktrt_intersect(b, &ray, &y);
    pktrt_surface(a, &ray, &x, &u), pktrt_surface(b, &ray, &y, &v);
    *hits += hit && x.mesh != wall;
    differ += hit != also || !same_bits(&x, &y, sizeof x) || !same_bits(u.position, v.position, sizeof u.position) ||
              !same_bits(u.shading_normal, v.shading_normal, sizeof u.normal) || u.material != v.material ||
              !same_bits(u.texcoord, v.texcoord, sizeof u.texcoord);
  }
  return differ;
}

static void pools_deform(void) {
  enum { KEYS = 3 };
  pool q = pool_of_things(KINDS, KEYS, 8), moved = pool_of_things(KINDS, KEYS, 8);
  pktrt_scene *over = scene_of_pool(&q, KINDS, true, false), *alone = scene_of_pool(&q, KINDS, true, true);
  size_t hits = 0, differ = hits_differ(over, alone, 1, 0, &hits);
  CHECK(hits > 300 && differ == 0, "%zu of %zu hits differ", differ, hits);
  for (uint32_t i = 0; i < 3 * q.nv * KEYS; i++) moved.p[i] = q.p[i] * 0.9f + 0.01f * (float)(i % 3), moved.n[i] *= -1;
  for (uint32_t round = 0; round < 2; round++) {
    for (uint32_t k = 0; k < KINDS; k++) {
      if (k % 2 == round) continue;
      pool part = part_of(&moved, k, true);
      for (uint32_t key = round; key < KEYS; key++) { /* mesh 0 is the wall */
        CHECK(pktrt_set_positions(over, 1 + k, key, moved.p + 3 * key * moved.nv) == PKTRT_OK);
        CHECK(pktrt_set_positions(alone, 1 + k, key, part.p + 3 * key * part.nv) == PKTRT_OK);
        CHECK(pktrt_set_normals(over, 1 + k, key, moved.n + 3 * key * moved.nv) == PKTRT_OK);
        CHECK(pktrt_set_normals(alone, 1 + k, key, part.n + 3 * key * part.nv) == PKTRT_OK);
      }
      pool_free(&part);
    }
    if (round) stage_commit(over), stage_commit(alone);
    else CHECK(pktrt_refit(over) == PKTRT_OK && pktrt_refit(alone) == PKTRT_OK);
    const size_t before = hits;
    hits = 0, differ = hits_differ(over, alone, 2 + round, 0, &hits);
    CHECK(hits > 300 && differ == 0, "round %u: %zu of %zu hits differ", round, differ, hits);
    CHECK(hits != before, "nothing moved");
  }
  pktrt_scene_destroy(over), pktrt_scene_destroy(alone);
  pool_free(&q), pool_free(&moved);
}

/* Meshes with a stride, and a soup with vertices left over. */
static void strides_and_soups(void) {
  enum { STRIDE = 5, N = 90 };
  float wide[STRIDE * N], tight[3 * N];
  uint32_t some[30];
  rng r = rng_of(4);
  pktrt_scene *s[2] = {stage_open(), stage_open()};
  for (int i = 0; i < STRIDE * N; i++) wide[i] = rng_range(&r, -1, 1);
  for (int i = 0; i < 30; i++) some[i] = 60 + 5 * (uint32_t)(i * 7 % 6);
  for (int round = 0; round < 2; round++) {
    for (int i = 0; round && i < STRIDE * N; i++) wide[i] *= 0.8f;
    for (int i = 0; i < N; i++) memcpy(tight + 3 * i, wide + STRIDE * i, 12);
    for (int k = 0; k < 2; k++) {
      pktrt_mesh_desc d;
      uint32_t index = 0;
      memset(&d, 0, sizeof d);
      d.positions = k ? tight : wide, d.position_stride = k ? 0 : 4 * STRIDE, d.vertex_count = N, d.triangle_count = 10;
      if (!round) CHECK(pktrt_add_mesh(s[k], &d, &index) == PKTRT_OK && index == 0); /* a soup of 30 vertices */
      d.indices = some;
      if (!round) CHECK(pktrt_add_mesh(s[k], &d, &index) == PKTRT_OK && index == 1);
      for (index = 0; round && index < 2; index++)
        CHECK(pktrt_set_positions(s[k], index, 0, d.positions) == PKTRT_OK, "%s", pktrt_last_error(s[k]));
      stage_commit(s[k]);
    }
    size_t hits = 0;
    CHECK(hits_differ(s[0], s[1], 3, PKTRT_NONE, &hits) == 0 && hits > 100, "%zu hits", hits);
    for (int i = 0; i < 10; i++) {
      pktrt_hit hit;
      float middle[3] = {0, 0, 0};
      for (int c = 0; c < 3; c++)
        for (int a = 0; a < 3; a++) middle[a] += tight[3 * (3 * i + c) + a] / 3;
      const float from[3] = {middle[0], middle[1], 5}, to[3] = {0, 0, -1};
      pktrt_ray ray = pktrt_make_ray(from, to);
      bool found = false;
      for (bool more = pktrt_intersect(s[0], &ray, &hit); more; more = pktrt_intersect_after(s[0], &ray, &hit, &hit))
        found = found || (hit.mesh == 0 && hit.triangle == (uint32_t)i);
      CHECK(found, "triangle %d of the soup", i);
    }
  }
  pktrt_scene_destroy(s[0]), pktrt_scene_destroy(s[1]);
}

static uint64_t bytes_of(const pktrt_scene *s) {
  pktrt_scene_info info;
  pktrt_get_scene_info(s, &info);
  return info.mesh_bytes;
}

static void a_pool_costs_little(void) {
  enum { PARTS = 64 };
  const uint32_t n = small_run ? 256 : 512, each = 2 * n * n / PARTS;
  mesh g = mesh_grid(n, 1);
  pktrt_mesh_desc d = mesh_desc(&g);
  pktrt_scene *one = stage_open(), *many = stage_open(), *told = stage_open(), *same = stage_open();
  uint32_t *material = fresh(g.nt, 4);
  CHECK(pktrt_add_mesh(one, &d, NULL) == PKTRT_OK);
  CHECK(bytes_of(one) == 12ull * g.nv + 12ull * g.nt, "%llu bytes", (unsigned long long)bytes_of(one));
  for (uint32_t k = 0; k < PARTS; k++) {
    pktrt_mesh_desc part = d;
    pktrt_mesh_info info;
    uint32_t index = 0;
    part.indices = d.indices + (size_t)3 * k * each, part.triangle_count = each;
    CHECK(pktrt_add_mesh(many, &part, &index) == PKTRT_OK, "%s", pktrt_last_error(many));
    CHECK(pktrt_get_mesh_info(many, index, &info) == PKTRT_NOT_COMMITTED);
  }
  stage_commit(one), stage_commit(many);
  pktrt_scene_report report;
  pktrt_get_scene_report(many, NULL, &report);
  const double ratio = (double)bytes_of(many) / (double)bytes_of(one);
  say("%u triangles in %d meshes over a pool take %.3f times the bytes of one mesh", g.nt, PARTS, ratio);
  CHECK(ratio > 1 && ratio <= 1.25, "%.3f", ratio);
  CHECK(report.positions + report.indices == bytes_of(many), "the report has %llu",
      (unsigned long long)(report.positions + report.indices));

  const pktrt_material m = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
  for (int i = 0; i < 3; i++) stage_material(told, &m), stage_material(same, &m);
  for (uint32_t t = 0; t < g.nt; t++) material[t] = t % 2 ? 3 : 0;
  d.triangle_materials = material;
  CHECK(pktrt_add_mesh(told, &d, NULL) == PKTRT_OK);
  const uint64_t more = bytes_of(told) - bytes_of(one);
  CHECK(more >= 4ull * g.nt && more < 4ull * g.nt + 100, "%llu bytes for materials", (unsigned long long)more);
  for (uint32_t t = 0; t < g.nt; t++) material[t] = 2;
  CHECK(pktrt_add_mesh(same, &d, NULL) == PKTRT_OK);
  stage_commit(same);
  CHECK(bytes_of(same) == bytes_of(one), "all of one material");
  const float from[3] = {0.01f, 1, 0.02f}, to[3] = {0, -1, 0};
  const pktrt_ray ray = pktrt_make_ray(from, to);
  pktrt_hit hit;
  pktrt_surface_info x;
  CHECK(pktrt_intersect(same, &ray, &hit));
  pktrt_surface(same, &ray, &hit, &x);
  CHECK(x.material == 2, "material %u", x.material);
  pktrt_scene_destroy(one), pktrt_scene_destroy(many), pktrt_scene_destroy(told), pktrt_scene_destroy(same);
  mesh_free(&g), free(material);
}

/* --- misuse --- */

static bool refused(pktrt_scene *s, pktrt_status status, const char *words) {
  return CHECK(status == PKTRT_INVALID_ARGUMENT && strstr(pktrt_last_error(s), words), "status %d, \"%s\", not \"%s\"",
      (int)status, pktrt_last_error(s), words);
}
static void mistakes_are_refused(void) {
  pool q = pool_of_things(3, 1, 2);
  pktrt_scene *s = stage_open();
  pktrt_mesh_desc d = pool_desc(&q);
  uint32_t index = 7, t = 0, model = 7, v = 0;
  refused(s, pktrt_add_mesh(s, &d, &index), "it names material");
  CHECK(index == 7);
  add_materials(s);
  q.material[5] = 7;
  refused(s, pktrt_add_mesh(s, &d, &index), "mesh 0, triangle 5: it names material 7, of 6 that were added");
  refused(s, pktrt_add_model(s, &d, 1, &model), "model 0: mesh 0, triangle 5: it names material 7, of 6");
  q.material[5] = PKTRT_NONE;
  refused(s, pktrt_add_mesh(s, &d, &index), "mesh 0, triangle 5: it names material 4294967295, of 6 that were added");
  q.material[5] = 6;
  d.material = 99; /* is not looked at */
  CHECK(pktrt_add_mesh(s, &d, &index) == PKTRT_OK && index == 0, "%s", pktrt_last_error(s));
  CHECK(pktrt_add_model(s, &d, 1, &model) == PKTRT_OK && model == 0, "%s", pktrt_last_error(s));
  stage_commit(s);
  static float pixels[3 * SIDE * SIDE];
  look_from(s, PKTRT_MODE_WRT, PKTRT_LIGHTS_ALL, vec_of(0, 0, 4), pixels);

  /* Of a part of a pool, vertices are those of the pool; all are looked at. */
  pool part = part_of(&q, 1, false);
  while (part.i[0] == v || part.i[1] == v) v++;
  for (t = 0; t < 3 * part.nt; t++)
    if (part.i[t] == v) v++, t = 0;
  char words[80];
  d = pool_desc(&part);
  part.p[3 * v + 1] = NAN;
  snprintf(words, sizeof words, "mesh 1, key 0, vertex %u: y is NaN", v);
  refused(s, pktrt_add_mesh(s, &d, &index), words);
  part.p[3 * v + 1] = 0, part.t[2 * v] = INFINITY;
  snprintf(words, sizeof words, "mesh 1, texcoord %u: u is inf", v);
  refused(s, pktrt_add_mesh(s, &d, &index), words);
  part.t[2 * v] = 0;
  CHECK(pktrt_add_mesh(s, &d, &index) == PKTRT_OK && index == 1, "%s", pktrt_last_error(s));
  stage_commit(s);
  const uint32_t last = part.i[3 * part.nt - 1];
  part.p[3 * last + 2] = NAN;
  snprintf(words, sizeof words, "mesh 1, key 0, vertex %u: z is NaN", last);
  refused(s, pktrt_set_positions(s, index, 0, part.p), words);
  part.p[3 * last + 2] = 0, part.n[3 * v] = NAN;
  snprintf(words, sizeof words, "mesh 1, key 0, normal %u: x is NaN", v);
  refused(s, pktrt_set_normals(s, index, 0, part.n), words);
  refused(s, pktrt_set_positions(s, index, 0, NULL), "the array is NULL");
  CHECK(pktrt_remove_mesh(s, index) == PKTRT_OK);
  stage_commit(s);
  part.n[3 * v] = 0;
  CHECK(pktrt_add_mesh(s, &d, &index) == PKTRT_OK && index == 1, "%s", pktrt_last_error(s));

  /* A mesh without triangles names no vertex. */
  d.triangle_count = 0;
  CHECK(pktrt_add_mesh(s, &d, &index) == PKTRT_OK && index == 2, "%s", pktrt_last_error(s));
  CHECK(pktrt_set_positions(s, index, 0, part.p) == PKTRT_OK, "%s", pktrt_last_error(s));
  stage_commit(s);
  pktrt_scene_destroy(s);
  pool_free(&q), pool_free(&part);
}

/* --- lamps --- */

enum { PANELS = 4 };
/* Panels of a ceiling as quads, each of two triangles. */
static quad panel(int k) {
  return quad_of(vec_of(k * 0.8 - 1.2, 1, k % 2 * 0.5), vec_of(0.3, 0, 0), vec_of(0, 0, 0.2));
}
static const float shines[PANELS] = {1, 4, 0, 0.25f};

static pktrt_material material_of_panel(int k) {
  pktrt_material m = lamp_of((double)shines[k]);
  m.emission[1] = shines[PANELS - 1 - k], m.emission[2] = 0;
  return m;
}
/* A floor, glossy if asked for, and the panels, as one mesh or several, that are lights. */
static pktrt_scene *lit_room(bool together, bool glossy, bool lights) {
  pktrt_scene *s = stage_open();
  const quad ground = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 6), vec_of(6, 0, 0));
  pktrt_material floor =
      material_of(glossy ? 0 : 0.7, glossy ? PKTRT_SPECULAR_MIRROR : PKTRT_SPECULAR_NONE, glossy ? 0.9 : 0);
  pktrt_light l = light_of(PKTRT_LIGHT_MESH, 1);
  mesh all = mesh_of(4 * PANELS, 2 * PANELS);
  uint32_t material[2 * PANELS];
  if (glossy) floor.lobe = PKTRT_LOBE_PHONG, floor.exponent = 20;
  stage_quad(s, &ground, stage_material(s, &floor));
  for (int k = 0; k < PANELS; k++) {
    const quad q = panel(k);
    const pktrt_material m = material_of_panel(k);
    const uint32_t index = stage_material(s, &m);
    static const uint32_t corner[6] = {0, 1, 2, 0, 2, 3};
    for (uint32_t c = 0; c < 4; c++) {
      const vec at = quad_at(&q, c == 1 || c == 2, c >= 2);
      vec_put(at, all.p + 3 * (4 * (uint32_t)k + c));
    }
    for (int c = 0; c < 6; c++) all.i[6 * k + c] = 4 * (uint32_t)k + corner[c];
    material[2 * k] = material[2 * k + 1] = index;
    if (together) continue;
    l.mesh = stage_quad(s, &q, index);
    if (lights) stage_light(s, &l);
  }
  if (together) {
    pktrt_mesh_desc d = mesh_desc(&all);
    d.triangle_materials = material;
    CHECK(pktrt_add_mesh(s, &d, &l.mesh) == PKTRT_OK, "%s", pktrt_last_error(s));
    if (lights) stage_light(s, &l);
  }
  mesh_free(&all);
  stage_commit(s);
  return s;
}

static void lamps_of_several_materials(void) {
  const vec at = vec_of(0.4, -1, 0.3);
  double want[3] = {0, 0, 0}, flat = 0;
  for (int k = 0; k < PANELS; k++) {
    const quad q = panel(k);
    const double seen = quad_form_factor(at, vec_of(0, 1, 0), &q);
    want[0] += 0.7 * seen * (double)shines[k], want[1] += 0.7 * seen * (double)shines[PANELS - 1 - k];
    flat += 0.7 * seen * 1.3125; /* the mean of what they shine */
  }
  pktrt_render_desc d = stage_spot(vec_of(0.4, 3, 5), at);
  for (int one = 0; one < 2; one++) {
    d.lights = one ? PKTRT_LIGHTS_ONE : PKTRT_LIGHTS_ALL;
    pktrt_scene *s = lit_room(true, false, true);
    const estimate e = stage_estimate(s, &d, 16);
    check_estimate("red", &e, want[0], flat, 0.01);
    CHECK(agrees(&e, 1, want[1]), "green: %.6f +- %.6f, not %.6f", e.mean[1], e.error[1], want[1]);
    CHECK(e.mean[2] <= 0, "blue");
    pktrt_scene_destroy(s);
  }

  /* As points, in the middle of their light, and afar. */
  float x[3], y[3];
  pktrt_render_desc far = stage_view(PKTRT_MODE_RCS, 1, 1, x, vec_of(0, 3, 90), vec_of(0, -1, 40));
  pktrt_scene *one = lit_room(true, false, true), *many = lit_room(false, false, true);
  far.camera.fov_y = 0.01f;
  const quad afar = quad_of(vec_of(0, -1, 40), vec_of(0, 0, 6), vec_of(6, 0, 0));
  stage_quad(one, &afar, 1), stage_quad(many, &afar, 1);
  stage_commit(one), stage_commit(many);
  stage_render(one, &far);
  far.pixels = y;
  stage_render(many, &far);
  const double sum = (double)x[0] + (double)x[1], other = (double)y[0] + (double)y[1];
  CHECK(fabs(sum - other) < 0.002 * other && other > 0, "as points: %g, not %g", sum, other);
  for (int a = 0; a < 2; a++) /* whose middle is that of all colours */
    CHECK(fabsf(x[a] - y[a]) < 0.03f * y[a], "as points: %g, not %g", (double)x[a], (double)y[a]);
  pktrt_scene_destroy(one), pktrt_scene_destroy(many);
}

/* A ceiling of many dark triangles, of which two shine, is as little noisy as these two alone. */
static void dark_triangles_are_not_asked(void) {
  const quad ground = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 3), vec_of(3, 0, 0));
  const pktrt_render_desc d = stage_spot(vec_of(0.4, 0.5, 2), vec_of(0, -1, 0));
  estimate e[2];
  for (int alone = 0; alone < 2; alone++) {
    pktrt_scene *s = stage_open();
    pktrt_light l = light_of(PKTRT_LIGHT_MESH, 1);
    const pktrt_material white = material_of(0.7, PKTRT_SPECULAR_NONE, 0), shine = lamp_of(9);
    mesh ceiling = mesh_grid(16, 2);
    pktrt_mesh_desc m = mesh_desc(&ceiling);
    uint32_t *material = fresh(ceiling.nt, 4);
    mesh_shift(&ceiling, 0, 1, 0);
    stage_quad(s, &ground, stage_material(s, &white));
    material[100] = material[101] = stage_material(s, &shine);
    m.triangle_materials = material;
    if (alone) m.triangle_materials = NULL, m.material = 2, m.indices += 300, m.triangle_count = 2;
    CHECK(pktrt_add_mesh(s, &m, &l.mesh) == PKTRT_OK, "%s", pktrt_last_error(s));
    stage_light(s, &l);
    stage_commit(s);
    e[alone] = stage_estimate(s, &d, 16);
    pktrt_scene_destroy(s);
    mesh_free(&ceiling), free(material);
  }
  CHECK(agrees(&e[0], 0, e[1].mean[0]) && e[1].mean[0] > 0.001, "%g, not %g", e[0].mean[0], e[1].mean[0]);
  CHECK(e[0].error[0] < 2 * e[1].error[0], "%g +- %g, alone +- %g", e[0].mean[0], e[0].error[0], e[1].error[0]);
}

/* What lobes get of such lamps is shared between their rays and samples, as it is of separate lamps; and what the lamps
   show of themselves is the same, bit for bit. */
static void lamps_in_lobes(void) {
  pktrt_render_desc d = stage_spot(vec_of(0.4, 1, 0.9), vec_of(0.4, -1, 0.5));
  estimate e[3];
  d.max_depth = 2;
  for (int k = 0; k < 3; k++) {
    pktrt_scene *s = lit_room(k > 0, true, k < 2);
    e[k] = stage_estimate(s, &d, 16);
    pktrt_scene_destroy(s);
  }
  say("red %.4f +- %.4f, of separate lamps %.4f +- %.4f, by lobes alone +- %.4f", e[1].mean[0], e[1].error[0],
      e[0].mean[0], e[0].error[0], e[2].error[0]);
  CHECK(e[0].mean[0] > 0.05 && fabs(e[0].mean[0] - e[0].mean[1]) > 0.05, "%g, %g", e[0].mean[0], e[0].mean[1]);
  for (int a = 0; a < 2; a++)
    for (int k = 1; k < 3; k++) {
      const double error = sqrt(e[0].error[a] * e[0].error[a] + e[k].error[a] * e[k].error[a]);
      CHECK(fabs(e[k].mean[a] - e[0].mean[a]) <= 4 * error + 1e-5, "channel %d: %.6f, not %.6f +- %.6f", a,
          e[k].mean[a], e[0].mean[a], error);
    }
  CHECK(small_run || e[1].error[0] < 0.7 * e[2].error[0], "lights are found by lobes alone: %g, %g", e[1].error[0],
      e[2].error[0]);
}

void suite_pool(void) {
  run("a mesh of several materials looks as a mesh for each, bit for bit: mirrors, glass, cutouts", one_mesh_is_many);
  run("so does a model, and its triangles tell their materials", models_too);
  run("meshes over a pool deform as those that have their vertices alone", pools_deform);
  run("of strided vertices and soups what triangles name is kept", strides_and_soups);
  run("64 meshes over a pool take little more memory than one mesh", a_pool_costs_little);
  run("materials that there are not and bad vertices of a pool are refused by name", mistakes_are_refused);
  run("triangles of a lamp shine by their own materials", lamps_of_several_materials);
  run("dark triangles of a lamp are not asked for light", dark_triangles_are_not_asked);
  run("lobes find lamps of several materials", lamps_in_lobes);
}
