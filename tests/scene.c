/* What a scene means: small and degenerate input, layouts, motion, what takes effect when, threads, statistics, stack. */
#include "meshes.h"

static pktrt_scene *empty_scene(void) {
  pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!CHECK(s != NULL, "%s", pktrt_last_error(NULL))) abort();
  return s;
}

static bool hits_something(const pktrt_scene *s, const pktrt_ray *r) {
  pktrt_hit h;
  bool hit = pktrt_intersect(s, r, &h);
  CHECK(hit == (h.mesh != PKTRT_NONE) && hit == (h.triangle != PKTRT_NONE) && hit == pktrt_occluded(s, r));
  if (!hit) {
    CHECK(same_bits(&h.t, &r->tmax, 4) || (h.t != h.t && r->tmax != r->tmax), "a miss reports tmax");
    CHECK(h.u == 0 && h.v == 0 && h.normal[0] == 0 && h.normal[1] == 0 && h.normal[2] == 0);
  } else {
    double n2 = 0;
    for (int a = 0; a < 3; a++) n2 += (double)h.normal[a] * (double)h.normal[a];
    CHECK(fabs(sqrt(n2) - 1) < 0x1p-22, "a normal of length %g", sqrt(n2));
    CHECK(h.u >= 0 && h.v >= 0 && h.t > r->tmin && h.t < r->tmax);
  }
  return hit;
}

/* As many rays as make packets, of vectors that are not full too. */
static void many_miss(const pktrt_scene *s, const pktrt_ray *r, const char *when) {
  enum { N = 300 };
  pktrt_ray rays[N];
  pktrt_hit hits[N];
  bool occluded[N];
  size_t n = 0;
  for (size_t i = 0; i < N; i++) rays[i] = *r;
  pktrt_intersect_n(s, rays, hits, N);
  pktrt_occluded_n(s, rays, occluded, N);
  for (size_t i = 0; i < N; i++) n += hits[i].mesh != PKTRT_NONE || hits[i].triangle != PKTRT_NONE || occluded[i];
  CHECK(n == 0, "%s: %zu of many rays hit", when, n);
}

static void tiny_scenes(void) {
  pktrt_ray down = ray_of(0.1f, 5, 0.1f, 0, -1, 0);
  pktrt_scene *s = empty_scene();
  CHECK(!hits_something(s, &down), "not committed: a miss");
  many_miss(s, &down, "not committed");
  CHECK(pktrt_commit(s) == PKTRT_OK);
  CHECK(!hits_something(s, &down), "empty: a miss");
  many_miss(s, &down, "empty");
  pktrt_scene_info info;
  pktrt_get_scene_info(s, &info);
  CHECK(info.triangles == 0 && info.mesh_count == 0 && info.bounds_lo[0] > info.bounds_hi[0]);
  pktrt_mesh_desc zero;
  memset(&zero, 0, sizeof zero);
  CHECK(pktrt_add_mesh(s, &zero, NULL) == PKTRT_OK, "a zeroed mesh is an empty one: %s", pktrt_last_error(s));
  CHECK(pktrt_commit(s) == PKTRT_OK && !hits_something(s, &down));
  many_miss(s, &down, "an empty mesh");
  pktrt_scene_destroy(s);
  for (uint32_t n = 0; n <= 20; n++) { /* 0, 1, 2, 3, 5 triangles, and around a block and a node */
    mesh m = mesh_soup(n, 0.5f, n);
    world w = world_none();
    w.m[0] = m, w.n = 1;
    s = world_scene(&w, PKTRT_ISA_AUTO, 0);
    pktrt_get_scene_info(s, &info);
    CHECK(info.triangles == n && info.mesh_count == 1);
    for (uint32_t i = 0; i < 400; i++) {
      rng r = rng_of(i);
      float o[3] = {2 * rng_sign(&r), 2 * rng_sign(&r), 2 * rng_sign(&r)},
            p[3] = {rng_sign(&r), rng_sign(&r), rng_sign(&r)};
      if (n && i % 2) pick_edge(&w, &r, 0, p);
      pktrt_ray x = ray_towards(o, p, 0);
      pktrt_hit want, got;
      ref_intersect(&w, &x, &want);
      pktrt_intersect(s, &x, &got);
      CHECK(same_bits(&want, &got, sizeof got), "%u triangles, ray %u", n, i);
    }
    pktrt_scene_destroy(s);
    mesh_free(&m);
  }
}

/* Degenerate triangles are accepted and never hit; good ones among them are. */
static void degenerate(void) {
  for (int kind = 0; kind < 5; kind++) {
    uint32_t n = kind == 3 ? (uint32_t)scaled(40000) : 300;
    mesh m = mesh_soup(n, 0.2f, 5);
    for (uint32_t t = 0; t < n; t++) {
      float *a = m.p + 9 * t;
      for (int k = 0; k < 3; k++) {
        if (kind == 0) a[3 + k] = a[6 + k] = a[k];                                              /* a point */
        if (kind == 1) a[k] = roundf(a[k] * 64) / 64, a[3 + k] = a[k] + 1, a[6 + k] = a[k] + 2; /* collinear, exactly */
        if (kind == 2) a[6 + k] = a[3 + k];                                                     /* two corners alike */
        if (kind == 3) a[k] = m.p[k], a[3 + k] = m.p[3 + k], a[6 + k] = m.p[6 + k]; /* all triangles identical */
        if (kind == 4 && t % 2) a[3 + k] = a[6 + k] = a[k];                         /* every second one */
      }
    }
    world w = world_none();
    w.m[0] = m, w.n = 1;
    pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
    pktrt_scene_info info;
    pktrt_get_scene_info(s, &info);
    CHECK(info.degenerate == (kind == 3      ? 0
                                 : kind == 4 ? n / 2
                                             : n),
        "kind %d: %llu degenerate", kind, (unsigned long long)info.degenerate);
    uint32_t hits = 0;
    for (uint32_t i = 0; i < 300; i++) {
      rng r = rng_of(i);
      float o[3] = {3 * rng_sign(&r), 3 * rng_sign(&r), 3 * rng_sign(&r)}, p[3];
      pick_edge(&w, &r, 0, p);
      pktrt_ray x = ray_towards(o, p, 0);
      pktrt_hit h;
      if (pktrt_intersect(s, &x, &h))
        hits++, CHECK(kind != 3 || h.triangle == 0), CHECK(kind != 4 || h.triangle % 2 == 0);
    }
    CHECK(kind < 3 ? hits == 0 : hits > 10, "kind %d: %u hits", kind, hits);
    pktrt_scene_destroy(s);
    mesh_free(&m);
  }
}

/* The same triangles through strides, odd addresses and soups: the same hits, and normals do not matter to them. */
static void layouts(void) {
  mesh m = mesh_sphere(2, 0.1f, 1);
  mesh_move(&m, 2, 0.2f, 0.1f, 2);
  pktrt_hit want[200];
  for (int layout = 0; layout < 6; layout++) {
    static const uint32_t strides[6] = {0, 12, 16, 32, 1000, 0};
    uint32_t stride = strides[layout] ? strides[layout] : 12;
    size_t floats = (size_t)stride / 4 * m.nv * m.keys;
    float *p = malloc((floats + 8) * sizeof *p), *at = p + 1 + layout % 3; /* at no more than a float's alignment */
    float *soup = malloc(sizeof(float) * 9 * m.nt * m.keys);
    if (!p || !soup) abort();
    for (size_t i = 0; i < floats; i++) at[i] = NAN; /* what lies between vertices is not looked at */
    for (size_t v = 0; v < (size_t)m.nv * m.keys; v++) memcpy(at + v * stride / 4, m.p + 3 * v, 12);
    for (size_t c = 0; c < (size_t)m.nt * 3 * m.keys; c++) {
      size_t key = c / (m.nt * 3), v = m.i[c % (m.nt * 3)];
      memcpy(soup + 3 * c, m.p + 3 * (key * m.nv + v), 12);
    }
    pktrt_mesh_desc d = mesh_desc(&m);
    d.positions = at, d.position_stride = strides[layout];
    if (layout == 5) d.positions = soup, d.indices = NULL, d.vertex_count = m.nt * 3;
    pktrt_scene *s = empty_scene();
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
    if (layout < 5) CHECK(pktrt_set_positions(s, 0, 1, at + (size_t)m.nv * stride / 4) == PKTRT_OK);
    for (size_t i = 0; i < floats; i++) at[i] = 7; /* it was copied */
    CHECK(pktrt_commit(s) == PKTRT_OK);
    for (uint32_t i = 0; i < COUNT(want); i++) {
      rng r = rng_of(i);
      pktrt_hit h;
      pktrt_ray x = ray_of(3 * rng_sign(&r), 3 * rng_sign(&r), 3, rng_sign(&r), rng_sign(&r), -3);
      x.time = rng_unit(&r);
      pktrt_intersect(s, &x, &h);
      if (layout == 0) want[i] = h;
      CHECK(same_bits(&h, &want[i], sizeof h), "layout %d", layout);
    }
    pktrt_scene_destroy(s);
    free(soup);
    free(p);
  }
  mesh_free(&m);
}

static void odd_queries(void) {
  world w = world_static(2);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  pktrt_rays none_in;
  pktrt_hits none_out;
  memset(&none_in, 0, sizeof none_in);
  memset(&none_out, 0, sizeof none_out);
  pktrt_intersect_n(s, NULL, NULL, 0);
  pktrt_occluded_n(s, NULL, NULL, 0);
  pktrt_intersect_ex(s, NULL, NULL, NULL, 0);
  pktrt_occluded_ex(s, NULL, NULL, NULL, 0);
  pktrt_intersect_soa(s, &none_in, &none_out, 0);
  pktrt_occluded_soa(s, &none_in, NULL, 0);
  pktrt_intersect_soa(s, NULL, NULL, 0);
  pktrt_ray x, good = ray_of(0.01f, 5, 0.02f, 0, -1, 0);
  memset(&x, 0, sizeof x);
  CHECK(!hits_something(s, &x), "a zeroed ray hits nothing");
  CHECK(hits_something(s, &good), "the control");
  for (int i = 0; i < 24; i++) { /* each field in turn NaN, inf, -inf, ... */
    static const float odd[3] = {NAN, INFINITY, -INFINITY};
    float *field[8] = {
        &x.origin[0], &x.origin[1], &x.origin[2], &x.direction[0], &x.direction[1], &x.direction[2], &x.tmin, &x.tmax};
    x = good;
    *field[i / 3] = odd[i % 3];
    bool fine = (i / 3 == 6 && i % 3 == 2) || (i / 3 == 7 && i % 3 == 1);
    CHECK(hits_something(s, &x) == fine, "field %d value %g", i / 3, (double)odd[i % 3]);
    pktrt_ray four[4] = {good, x, good, x}; /* and between good ones, on every path */
    for (int path = 0; path < 3; path++) {
      pktrt_query_desc q;
      pktrt_hit h[4];
      memset(&q, 0, sizeof q);
      q.path = (pktrt_path)path;
      pktrt_intersect_ex(s, &q, four, h, 4);
      CHECK(h[0].mesh != PKTRT_NONE && (h[1].mesh != PKTRT_NONE) == fine && same_bits(&h[0], &h[2], sizeof h[0]));
    }
  }
  x = good, x.tmin = x.tmax = 3;
  CHECK(!hits_something(s, &x), "an empty interval");
  pktrt_query_desc q; /* values out of range are taken as their defaults */
  memset(&q, 0, sizeof q);
  q.path = (pktrt_path)9, q.packet_size = 100000, q.type = (pktrt_ray_type)44;
  pktrt_stats stats;
  memset(&stats, 0, sizeof stats);
  q.stats = &stats;
  pktrt_hit h, h1;
  pktrt_intersect_ex(s, &q, &good, &h, 1);
  pktrt_intersect(s, &good, &h1);
  CHECK(same_bits(&h, &h1, sizeof h));
  q.path = PKTRT_PATH_PAPER;
  pktrt_intersect_ex(s, &q, &good, &h, 1);
  CHECK(same_bits(&h, &h1, sizeof h));
  float o[3] = {0.01f, 5, 0.02f}, d[3] = {0, -1, 0}, t = 0; /* the twin's defaults: tmin 0, tmax INFINITY, time 0 */
  uint32_t mesh_index = 0;
  pktrt_rays in = {{&o[0], &o[1], &o[2]}, {&d[0], &d[1], &d[2]}, NULL, NULL, NULL};
  none_out.t = &t, none_out.mesh = &mesh_index;
  pktrt_intersect_soa(s, &in, &none_out, 1);
  CHECK(t == h1.t && mesh_index == h1.mesh);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* tmin < t < tmax, both strict. */
static void intervals(void) {
  pktrt_scene *s = empty_scene();
  mesh m = mesh_grid(2, 1);
  CHECK(mesh_add(s, &m, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
  pktrt_ray x = ray_of(0.3f, 2, 0.2f, 0, -1, 0);
  struct {
    float tmin, tmax;
    bool hit;
  } c[] = {{0, 3, true}, {0, 2, false}, {2, 3, false}, {nextafterf(2, 0), nextafterf(2, 3), true}, {-5, 3, true},
      {-INFINITY, 3, true}, {2.5f, 3, false}, {0, nextafterf(2, 3), true}, {nextafterf(2, 3), 9, false}};
  for (uint32_t i = 0; i < COUNT(c); i++) {
    x.tmin = c[i].tmin, x.tmax = c[i].tmax;
    CHECK(hits_something(s, &x) == c[i].hit, "case %u", i);
  }
  x = ray_of(0.3f, -2, 0.2f, 0, -1, 0); /* behind the origin: a negative t */
  CHECK(!hits_something(s, &x));
  x.tmin = -3;
  CHECK(hits_something(s, &x));
  x = ray_of(0.3f, 0, 0.2f, 0, -1, 0); /* on the surface: t = 0 */
  CHECK(!hits_something(s, &x));
  x.tmin = -1;
  CHECK(hits_something(s, &x));
  pktrt_scene_destroy(s);
  mesh_free(&m);
}

/* A mesh that moves by (1,0,0) between keys; key counts of 2 and 3 in one scene. */
static void motion(void) {
  mesh a = mesh_box(), b = mesh_box();
  mesh_move(&a, 2, 0, 0, 1);
  mesh_move(&b, 3, 0, 0, 1);
  for (uint32_t v = 0; v < 8; v++) {
    a.p[24 + 3 * v] += 10;                                                            /* 0, 10 */
    for (uint32_t k = 0; k < 3; k++) b.p[24 * k + 3 * v + 1] += k == 1 ? 30.f : 20.f; /* up and down again */
  }
  world w = world_none();
  w.m[0] = a, w.m[1] = b, w.n = 2;
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  struct {
    float time, x, y;
    uint32_t mesh;
  } c[] = {{0, 0, 0, 0}, {1, 10, 0, 0}, {0.5f, 5, 0, 0}, {-3, 0, 0, 0}, {7, 10, 0, 0}, {NAN, 0, 0, 0},
      {0.5f, 0, 0, PKTRT_NONE}, {INFINITY, 10, 0, 0}, {-INFINITY, 0, 0, 0}, {0, 0, 20, 1}, {0.5f, 0, 30, 1},
      {0.25f, 0, 25, 1}, {0.75f, 0, 25, 1}, {1, 0, 20, 1}, {2, 0, 20, 1}, {0.5f, 0, 20, PKTRT_NONE}};
  for (uint32_t i = 0; i < COUNT(c); i++) {
    pktrt_ray x = ray_of(c[i].x + 0.3f, c[i].y + 0.2f, -9, 0, 0, 1);
    x.time = c[i].time;
    pktrt_hit h;
    pktrt_intersect(s, &x, &h);
    CHECK(h.mesh == c[i].mesh, "time %g: mesh %u", (double)c[i].time, h.mesh);
    CHECK(h.mesh == PKTRT_NONE || h.t == 8, "t %g", (double)h.t);
  }
  pktrt_scene_info info;
  pktrt_get_scene_info(s, &info);
  CHECK(info.moving_meshes == 2 && info.bounds_lo[0] == -1 && info.bounds_hi[0] == 11 && info.bounds_hi[1] == 31);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* Rows that are NULL: tmin 0, tmax INFINITY, time 0, for single rays, streams and packets. */
static void rows_left_out(void) {
  enum { N = 300 };
  static pktrt_ray ray[3][N];
  static pktrt_hit want[3][N];
  static float o[3][N], d[3][N], t[N], u[N];
  static uint32_t at[N], triangle[N];
  static bool occluded[2][N];
  static const char *const named[3] = {"tmin", "tmax", "time"};
  world w = world_moving(2);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  make_rays(&w, s, RAYS_RANDOM, 5, 0, ray[0], N);
  for (int k = 0; k < 2; k++) { /* 1: the control, times of 1 */
    for (size_t i = 0; i < N; i++) {
      ray[k][i] = ray[0][i], ray[k][i].tmin = 0, ray[k][i].tmax = INFINITY, ray[k][i].time = (float)k;
      for (int a = 0; a < 3; a++) o[a][i] = ray[k][i].origin[a], d[a][i] = ray[k][i].direction[a];
      pktrt_intersect(s, &ray[k][i], &want[k][i]);
      if (k == 0) occluded[0][i] = pktrt_occluded(s, &ray[0][i]);
    }
  }
  static const size_t counts[] = {1, 20, N};
  for (size_t c = 0; c < COUNT(counts); c++) {
    const size_t n = counts[c];
    for (int row = 0; row < 4; row++) { /* one of them left out, or all */
      static float tmin[N], tmax[N], time[N];
      for (size_t i = 0; i < N; i++) tmin[i] = 0, tmax[i] = INFINITY, time[i] = 0;
      const pktrt_rays in = {{o[0], o[1], o[2]}, {d[0], d[1], d[2]}, row % 3 ? tmin : NULL,
          row == 1 || row == 3 ? NULL : tmax, row >= 2 ? NULL : time};
      const pktrt_hits out = {t, u, NULL, {NULL, NULL, NULL}, at, triangle};
      pktrt_intersect_soa(s, &in, &out, n), pktrt_occluded_soa(s, &in, occluded[1], n);
      size_t wrong = 0;
      for (size_t i = 0; i < n; i++)
        wrong += !same_bits(&t[i], &want[0][i].t, 4) || !same_bits(&u[i], &want[0][i].u, 4) ||
                 at[i] != want[0][i].mesh || triangle[i] != want[0][i].triangle || occluded[1][i] != occluded[0][i];
      CHECK(wrong == 0, "%zu of %zu answers differ without %s", wrong, n, row < 3 ? named[row] : "any");
    }
  }
  size_t other = 0;
  for (size_t i = 0; i < N; i++) other += !same_bits(&want[0][i], &want[1][i], sizeof want[0][i]);
  CHECK(other > N / 4, "the control: at time 1 %zu answers are others", other);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* --- no area just then --- */

/* The canonical test without a question for area, of one triangle. */
static bool sheared_hit(float p[3][3], const pktrt_ray *r) {
  const float *d = r->direction;
  int k = fabsf(d[1]) > fabsf(d[0]), below = 0, above = 0;
  if (fabsf(d[2]) > fabsf(d[k])) k = 2;
  const int u = (k + 1) % 3, v = (k + 2) % 3;
  double x[3], y[3];
  for (int c = 0; c < 3; c++) {
    const float z = p[c][k] - r->origin[k], across = d[u] / d[k] * z, up = d[v] / d[k] * z;
    const float pu = p[c][u] - r->origin[u], pv = p[c][v] - r->origin[v];
    x[c] = (double)(pu - across), y[c] = (double)(pv - up);
  }
  for (int c = 0; c < 3; c++) {
    const double e = x[(c + 2) % 3] * y[(c + 1) % 3] - y[(c + 2) % 3] * x[(c + 1) % 3];
    below += e<0, above += e> 0;
  }
  return (below == 0) != (above == 0);
}

/* Triangles that are lines at time 1/2, exactly, and no others, before a wall that is at rest. */
static world lines_at_half_time(void) {
  enum { N = 60 };
  mesh m = mesh_of(2 * 3 * N, N), wall = mesh_box();
  m.nv = 3 * N, m.keys = 2;
  for (uint32_t t = 0; t < N; t++) {
    rng r = rng_of(t);
    for (uint32_t a = 0; a < 3; a++) {
      const float from = roundf(64 * rng_sign(&r)) / 64, step = roundf(64 * rng_sign(&r)) / 64;
      for (uint32_t c = 0; c < 3; c++) {
        const float off = roundf(16 * rng_sign(&r)) / 64, at = from + (float)c * step; /* sums of 64ths: exact */
        m.i[3 * t + c] = 3 * t + c;
        m.p[9 * t + 3 * c + a] = at - off, m.p[9 * N + 9 * t + 3 * c + a] = at + off;
      }
    }
  }
  mesh_scale(&wall, 20);
  world w = world_none();
  w.m[0] = m, w.m[1] = wall, w.n = 2;
  return w;
}

/* Rounding makes rays hit lines now and then, which is no hit, whoever asks. */
static void no_area_at_the_time(void) {
  enum { MOST = 6000 };
  world w = lines_at_half_time();
  pktrt_ray *ray = calloc(MOST, sizeof *ray);
  pktrt_hit *want = calloc(2 * MOST, sizeof *want), *got = want + MOST;
  bool *occluded = calloc(MOST, sizeof *occluded);
  if (!ray || !want || !occluded) abort();
  size_t n = 0, looked = 0;
  for (uint32_t i = 0; i < scaled(400000) && n < MOST; i++) { /* those that would be hit, and some others */
    rng r = rng_of(i);
    const uint32_t t = rng_below(&r, w.m[0].nt);
    const float part = 2 * rng_unit(&r);
    float p[3][3], to[3], from[3];
    for (uint32_t c = 0; c < 3; c++) ref_vertex(&w.m[0], 3 * t + c, 0.5f, p[c]);
    for (int a = 0; a < 3; a++) to[a] = p[0][a] + part * (p[1][a] - p[0][a]), from[a] = 3 * rng_sign(&r);
    ray[n] = ray_towards(from, to, 0.5f);
    const bool tempted = sheared_hit(p, &ray[n]);
    looked += tempted;
    if (!tempted && i % 64) continue;
    ref_intersect(&w, &ray[n], &want[n]);
    CHECK(want[n].mesh == 1, "ray %u: lines are no hits", i);
    n++;
  }
  for (int i = 0; i < isa_count; i++) {
    pktrt_scene *s = world_scene(&w, isas[i], 0);
    size_t wrong[5] = {0, 0, 0, 0, 0}, hidden[2] = {0, 0};
    for (size_t j = 0; j < n; j++)
      pktrt_intersect(s, &ray[j], &got[j]), wrong[0] += !same_bits(&got[j], &want[j], sizeof *got);
    for (int path = 0; path <= PKTRT_PATH_SINGLE; path++) {
      pktrt_query_desc q;
      memset(&q, 0, sizeof q);
      q.path = (pktrt_path)path;
      pktrt_intersect_ex(s, &q, ray, got, n);
      for (size_t j = 0; j < n; j++) wrong[1 + path] += !same_bits(&got[j], &want[j], sizeof *got);
    }
    pktrt_intersect_n(s, ray, got, 8);
    for (size_t j = 0; j < 8 && j < n; j++) wrong[4] += !same_bits(&got[j], &want[j], sizeof *got);
    for (size_t j = 0; j < n; j++) ray[j].tmax = 1.5f; /* the wall is farther */
    pktrt_occluded_n(s, ray, occluded, n);
    for (size_t j = 0; j < n; j++)
      hidden[0] += occluded[j], hidden[1] += pktrt_occluded(s, &ray[j]), ray[j].tmax = INFINITY;
    CHECK(wrong[0] + wrong[1] + wrong[2] + wrong[3] + wrong[4] == 0,
        "%s: wrong hits: %zu of single calls, %zu, %zu, %zu of paths, %zu of eight", pktrt_isa_string(isas[i]),
        wrong[0], wrong[1], wrong[2], wrong[3], wrong[4]);
    CHECK(hidden[0] + hidden[1] == 0, "%s: %zu of packets, %zu of single calls hidden by lines",
        pktrt_isa_string(isas[i]), hidden[0], hidden[1]);
    pktrt_scene_destroy(s);
  }
  say("%zu rays, %zu of which would hit a line if nobody asked for its area", n, looked);
  CHECK(looked > (small_run ? 10 : 400), "the control: %zu", looked);
  free(ray), free(want), free(occluded);
  world_free(&w);
}

/* A line's volumes are all zero, and so is a t that is made of them: a ray that starts before 0 must not take it. */
static void line_before_the_start(void) {
  static const float corner[18] = {-1, -.25f, 0, 0, .5f, 0, 1, -.25f, 0, -1, .25f, 0, 0, -.5f, 0, 1, .25f, 0};
  const float from[3] = {0.3f, 0, 1}, down[3] = {0, 0, -1};
  world w = world_of(mesh_of(3, 1));
  mesh_move(&w.m[0], 2, 0, 0, 1);
  memcpy(w.m[0].p, corner, sizeof corner); /* two keys, and a line on the x axis half-way */
  for (uint32_t c = 0; c < 3; c++) w.m[0].i[c] = c;
  for (int i = 0; i < isa_count; i++) {
    pktrt_scene *s = world_scene(&w, isas[i], 0);
    for (int half = 0; half < 2; half++) { /* the control: it has area at time 1/4 */
      pktrt_ray rays[64];
      pktrt_hit hit, hits[64];
      size_t n = 0;
      for (int k = 0; k < 64; k++)
        rays[k] = pktrt_make_ray(from, down), rays[k].time = half ? 0.5f : 0.25f, rays[k].tmin = -1;
      const size_t one =
          pktrt_intersect(s, rays, &hit) + pktrt_occluded(s, rays) + pktrt_intersect_all(s, rays, &hit, 1);
      pktrt_intersect_n(s, rays, hits, 64);
      for (int k = 0; k < 64; k++) n += hits[k].mesh != PKTRT_NONE;
      CHECK(one == (half ? 0 : 3) && n == (half ? 0 : 64), "%s: %zu of single calls, %zu of 64 rays",
          pktrt_isa_string(isas[i]), one, n);
    }
    pktrt_scene_destroy(s);
  }
  world_free(&w);
}

/* Changes take effect at commit or refit, not before. */
/* A soup whose triangles have been shuffled: a refit leaves a bad tree, which is built anew only where it was marked. */
static void marked_scenes(void) {
  for (int k = 0; k < 8; k++) {
    const bool marked = k & 1, refitted = k & 2, moved = k & 4;
    mesh m = mesh_soup(1000, 0.02f, 5), other = mesh_soup(1000, 0.02f, 6);
    pktrt_scene *s = empty_scene();
    pktrt_scene_info built, info;
    CHECK(mesh_add(s, &m, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
    pktrt_get_scene_info(s, &built);
    CHECK(pktrt_set_positions(s, 0, 0, other.p) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
    pktrt_get_scene_info(s, &info);
    CHECK(info.rebuild_advised && info.sah_now > 5 * built.sah_now, "the control: a bad tree, %g", info.sah_now);
    if (marked) CHECK(pktrt_mark_changed(s) == PKTRT_OK);
    if (moved) CHECK(pktrt_set_positions(s, 0, 0, other.p) == PKTRT_OK);
    if (refitted) CHECK(pktrt_refit(s) == PKTRT_OK);
    CHECK(pktrt_commit(s) == PKTRT_OK);
    pktrt_get_scene_info(s, &info);
    const bool anew = marked || (moved && !refitted);
    CHECK(info.rebuild_advised == !anew && (info.sah_now < 1.2 * built.sah_now) == anew,
        "marked %d, moved %d, refitted %d: SAH %g, built %g", marked, moved, refitted, info.sah_now, built.sah_now);
    CHECK(pktrt_commit(s) == PKTRT_OK);
    pktrt_scene_destroy(s);
    mesh_free(&m), mesh_free(&other);
  }
}

static void when_changes_show(void) {
  mesh m = mesh_box();
  pktrt_scene *s = empty_scene();
  pktrt_ray here = ray_of(0.3f, 0.2f, -9, 0, 0, 1), there = ray_of(20.3f, 0.2f, -9, 0, 0, 1),
            far = ray_of(40.3f, 0.2f, -9, 0, 0, 1);
  CHECK(mesh_add(s, &m, NULL) == PKTRT_OK);
  CHECK(!hits_something(s, &here), "added, not committed");
  CHECK(pktrt_refit(s) == PKTRT_NOT_COMMITTED);
  CHECK(pktrt_last_error(s)[0] != 0);
  CHECK(!hits_something(s, &here));
  CHECK(pktrt_commit(s) == PKTRT_OK && hits_something(s, &here));
  mesh_shift(&m, 20, 0, 0);
  CHECK(pktrt_set_positions(s, 0, 0, m.p) == PKTRT_OK);
  CHECK(hits_something(s, &here) && !hits_something(s, &there), "set, not refitted");
  CHECK(pktrt_refit(s) == PKTRT_OK);
  CHECK(!hits_something(s, &here) && hits_something(s, &there));
  mesh_shift(&m, 20, 0, 0);
  CHECK(pktrt_set_positions(s, 0, 0, m.p) == PKTRT_OK);
  CHECK(mesh_add(s, &m, NULL) == PKTRT_OK);
  CHECK(pktrt_refit(s) == PKTRT_NOT_COMMITTED, "a mesh awaits its commit");
  CHECK(hits_something(s, &there) && !hits_something(s, &far), "nothing changed");
  CHECK(pktrt_set_positions(s, 1, 0, m.p) == PKTRT_OK, "an uncommitted mesh may change: %s", pktrt_last_error(s));
  CHECK(pktrt_commit(s) == PKTRT_OK);
  CHECK(!hits_something(s, &there) && hits_something(s, &far));
  pktrt_hit h;
  CHECK(pktrt_intersect(s, &far, &h) && h.mesh == 0, "a tie goes to the lower mesh");
  CHECK(pktrt_commit(s) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK && pktrt_mark_changed(s) == PKTRT_OK);
  CHECK(hits_something(s, &far));
  CHECK(pktrt_commit(s) == PKTRT_OK && hits_something(s, &far));
  pktrt_scene_destroy(s);
  mesh_free(&m);
}

enum { SET_KEYS = 3, SET_TRIANGLES = 40, SET_VERTICES = 3 * SET_TRIANGLES };

/* Adds triangles with positions and normals at SET_KEYS keys. Kind 0: loose; 1: with indices; 2: that leave out a vertex. */
static void add_set_keys(pktrt_scene *s, int kind, uint32_t keys, float *p) {
  uint32_t indices[SET_VERTICES];
  pktrt_mesh_desc d;
  memset(&d, 0, sizeof d);
  for (uint32_t i = 0; i < SET_VERTICES; i++) indices[i] = i + (kind == 2 && i == 0);
  d.positions = d.normals = p, d.vertex_count = SET_VERTICES, d.key_count = keys;
  d.indices = kind ? indices : NULL, d.triangle_count = SET_TRIANGLES;
  CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
}

/* Returns how many rays see two scenes alike, or counts those that do not. */
static uint32_t seen_alike(const pktrt_scene *a, const pktrt_scene *b, uint32_t *others) {
  uint32_t alike = 0;
  for (uint32_t i = 0; i < 60; i++) {
    rng r = rng_of(i);
    pktrt_ray ray = ray_of(rng_sign(&r), rng_sign(&r), 3, 0.2f * rng_sign(&r), 0.2f * rng_sign(&r), -1);
    pktrt_hit hit[2];
    pktrt_surface_info info[2];
    ray.time = i % 4 ? rng_unit(&r) : 0.5f * (float)rng_below(&r, 3);
    memset(hit, 0, sizeof hit), memset(info, 0, sizeof info);
    const bool hits = pktrt_intersect(a, &ray, &hit[0]), too = pktrt_intersect(b, &ray, &hit[1]);
    pktrt_surface(a, &ray, &hit[0], &info[0]), pktrt_surface(b, &ray, &hit[1], &info[1]);
    const bool same = hits == too && memcmp(&hit[0], &hit[1], sizeof *hit) == 0 &&
                      memcmp(info[0].shading_normal, info[1].shading_normal, sizeof info->shading_normal) == 0;
    alike += same && hits;
    *others += !same;
  }
  return alike;
}

/* Keys of positions and normals are set in any order, some of them twice, some refused: the next state has the last of each
   that was good, and until then all is as before. */
static void keys_set_in_any_order(void) {
  uint32_t alike = 0, others = 0, changed = 0, refused = 0;
  for (uint32_t n = 0; n < 240; n++) {
    static float now[2][SET_KEYS][SET_VERTICES * 3], given[SET_VERTICES * 3];
    rng r = rng_of(n);
    const int kind = (int)(n % 3);
    const uint32_t keys = 1 + n / 3 % SET_KEYS;
    mesh m = mesh_soup(SET_TRIANGLES, 0.6f, n);
    pktrt_scene *s = empty_scene(), *before = empty_scene();
    for (uint32_t k = 0; k < keys; k++)
      for (int i = 0; i < SET_VERTICES * 3; i++) now[0][k][i] = now[1][k][i] = m.p[i] + 0.1f * (float)k;
    add_set_keys(s, kind, keys, now[0][0]), add_set_keys(before, kind, keys, now[0][0]);

    for (uint32_t round = 0; round < 3; round++) {
      for (uint32_t step = rng_below(&r, 7); step > 0; step--) {
        const uint32_t bends = rng_below(&r, 2), key = rng_below(&r, keys);
        const bool spoilt = rng_below(&r, 3) == 0;
        for (int i = 0; i < SET_VERTICES * 3; i++) given[i] = now[bends][key][i] + 0.2f * rng_sign(&r);
        if (spoilt) given[rng_below(&r, SET_VERTICES * 3)] = rng_below(&r, 2) ? NAN : INFINITY;
        else memcpy(now[bends][key], given, sizeof given);
        const pktrt_status st = bends ? pktrt_set_normals(s, 0, key, given) : pktrt_set_positions(s, 0, key, given);
        CHECK(st == (spoilt ? PKTRT_INVALID_ARGUMENT : PKTRT_OK), "status %d: %s", (int)st, pktrt_last_error(s));
        for (int i = 0; i < SET_VERTICES * 3; i++) given[i] = 1e9f; /* it was copied */
        refused += spoilt;
      }
      alike += seen_alike(s, before, &others); /* nothing shows yet */
      CHECK((rng_below(&r, 2) ? pktrt_refit(s) : pktrt_commit(s)) == PKTRT_OK, "%s", pktrt_last_error(s));
      (void)seen_alike(s, before, &changed);
      pktrt_scene_destroy(before);
      before = empty_scene();
      add_set_keys(before, kind, keys, now[0][0]);
      for (uint32_t k = 0; k < keys; k++)
        CHECK(pktrt_set_normals(before, 0, k, now[1][k]) == PKTRT_OK && pktrt_refit(before) == PKTRT_OK);
      alike += seen_alike(s, before, &others);
    }
    pktrt_scene_destroy(s), pktrt_scene_destroy(before);
    mesh_free(&m);
  }
  CHECK(others == 0 && alike > 10000 && changed > 5000 && refused > 500, "%u differ, %u alike, %u changed, %u refused",
      others, alike, changed, refused);
  say("%u hits as they should be, %u differ; %u changed, %u sets were refused", alike, others, changed, refused);
}

/* Triangles that lie by themselves, far from thousands, are where a refit puts them, however many times it does. */
static void lone_triangles_move(void) {
  const float places[] = {50, 80, -120, 50};
  mesh ball = mesh_sphere(5, 0.05f, 1), lone = mesh_box();
  CHECK(ball.nt > 8000, "%u triangles: enough for runs of their own in the tree", (unsigned)ball.nt);
  pktrt_scene *s = empty_scene();
  CHECK(mesh_add(s, &ball, NULL) == PKTRT_OK && mesh_add(s, &lone, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
  float at = 0;
  for (size_t i = 0; i < COUNT(places); i++) {
    mesh_shift(&lone, places[i] - at, 0, 0);
    at = places[i];
    CHECK(pktrt_set_positions(s, 1, 0, lone.p) == PKTRT_OK && (i ? pktrt_refit(s) : pktrt_commit(s)) == PKTRT_OK);
    for (size_t k = 0; k < COUNT(places); k++) {
      const pktrt_ray ray = ray_of(places[k] + 0.3f, 0.2f, -9, 0, 0, 1);
      CHECK(hits_something(s, &ray) == (places[k] == at), "at %g, asked at %g", (double)at, (double)places[k]);
    }
  }
  pktrt_scene_destroy(s);
  mesh_free(&ball), mesh_free(&lone);
}

/* After a miss there is nothing, wherever the ray ends. */
static void nothing_after_a_miss(void) {
  static const float ends[] = {INFINITY, 100, 5, 0};
  mesh m = mesh_box();
  pktrt_scene *s = empty_scene();
  CHECK(mesh_add(s, &m, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
  for (size_t i = 0; i < COUNT(ends); i++) {
    pktrt_ray ray = ray_of(0.3f, 0.2f, -9, 0, 0, -1);
    pktrt_hit miss, next;
    ray.tmax = ends[i];
    CHECK(!pktrt_intersect(s, &ray, &miss));
    memset(&next, 0x77, sizeof next);
    CHECK(!pktrt_intersect_after(s, &ray, &miss, &next) && next.mesh == PKTRT_NONE && next.t == ends[i], "to %g: t %g",
        (double)ends[i], (double)next.t);
  }
  pktrt_scene_destroy(s);
  mesh_free(&m);
}

/* --- threads --- */

typedef struct concurrent {
  const pktrt_scene *s;
  const pktrt_ray *rays;
  const pktrt_hit *want;
  size_t n, wrong;
} concurrent;

static void concurrent_body(void *arg, size_t i) {
  concurrent *c = arg;
  pktrt_hit *h = calloc(c->n, sizeof *h);
  if (!h) abort();
  pktrt_query_desc q;
  memset(&q, 0, sizeof q);
  q.path = (pktrt_path)(i % 3);
  pktrt_intersect_ex(c->s, &q, c->rays, h, c->n);
  size_t wrong = 0;
  for (size_t j = 0; j < c->n; j++) wrong += !same_bits(&h[j], &c->want[j], sizeof *h);
  CHECK(wrong == 0, "%zu wrong in run %zu", wrong, i);
  free(h);
}

static void concurrent_queries(void) {
  world w = world_moving(3);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  size_t n = scaled(8000);
  pktrt_ray *rays = calloc(n, sizeof *rays);
  pktrt_hit *want = calloc(n, sizeof *want);
  if (!rays || !want) abort();
  make_rays(&w, s, RAYS_EDGE, 1, 0, rays, n);
  for (size_t j = 0; j < n; j++) pktrt_intersect(s, &rays[j], &want[j]);
  concurrent c = {s, rays, want, n, 0};
  size_t calls = hooks.calls;
  threads_for(4, 24, concurrent_body, &c);
  CHECK(hooks.calls == calls, "queries allocate nothing");
  pktrt_scene_destroy(s);
  free(rays);
  free(want);
  world_free(&w);
}

/* --- stack: paint a thread's, run, see how deep the paint is gone --- */

enum { STACK = 1 << 20, ALLOWED = 60 << 10 };
typedef struct stack_probe {
  const pktrt_scene *s;
  const pktrt_ray *rays;
  pktrt_hit *hits;
  bool *occluded;
  size_t n;
  int what;
  char *top; /* where the call began */
} stack_probe;

static void *stack_thread(void *arg) {
  stack_probe *p = arg;
  char here = 0;
  p->top = &here;
  static pktrt_query_desc q; /* static: only the stack that the library takes is asked for */
  static pktrt_stats stats;
  memset(&q, 0, sizeof q);
  memset(&stats, 0, sizeof stats);
  q.path = p->what < 2 ? PKTRT_PATH_FAST : PKTRT_PATH_PAPER;
  q.packet_size = 256;
  if (p->what % 2) q.stats = &stats;
  if (p->what == 4) {
    for (size_t i = 0; i < p->n; i++) {
      pktrt_intersect(p->s, &p->rays[i], &p->hits[i]);
      p->occluded[i] = pktrt_occluded(p->s, &p->rays[i]);
    }
  } else if (p->what < 4) {
    pktrt_intersect_ex(p->s, &q, p->rays, p->hits, p->n);
    pktrt_occluded_ex(p->s, &q, p->rays, p->occluded, p->n);
  }
  return NULL;
}

static size_t stack_used(stack_probe *p) {
  char *memory = NULL;
  if (posix_memalign((void **)&memory, 4096, STACK)) abort();
  memset(memory, 0xA5, STACK);
  run_on_stack(memory, STACK, stack_thread, p);
  char *low = memory;
  while (low < p->top && *low == (char)0xA5) low++;
  size_t used = (size_t)(p->top - low);
  free(memory);
  return used;
}

static void stack_bound(void) {
  if (SANITIZED) {
    say("skipped: sanitizers change the stack");
    return;
  }
  world w = world_moving(4);
  size_t n = 1024, most = 0;
  pktrt_ray *rays = calloc(2 * n, sizeof *rays);
  pktrt_hit *hits = calloc(2 * n, sizeof *hits);
  bool *occluded = calloc(2 * n, sizeof *occluded);
  if (!rays || !hits || !occluded) abort();
  for (int k = 0; k < 2 * isa_count; k++) { /* the second half: an instance beside */
    pktrt_scene *s = world_scene(&w, isas[k / 2], 0);
    const pktrt_mesh_desc ball = mesh_desc(&w.m[0]);
    const pktrt_instance_desc at = {0, 1, NULL, 0, PKTRT_INTERPOLATION_LINEAR};
    if (k % 2) CHECK(!pktrt_add_model(s, &ball, 1, NULL) && !pktrt_add_instance(s, &at, NULL) && !pktrt_commit(s));
    make_rays(&w, s, RAYS_CAMERA, 1, 0, rays, n);
    make_rays(&w, s, RAYS_EDGE, 1, 0, rays + n, n);
    stack_probe p = {s, rays, hits, occluded, 2 * n, 9, NULL};
    size_t nothing = stack_used(&p); /* thread start and end take some too */
    for (p.what = 0; p.what < 5; p.what++) {
      size_t used = stack_used(&p);
      CHECK(used > nothing + 64 || p.what == 4, "the probe sees something");
#ifdef __OPTIMIZE__ /* unoptimised code keeps every temporary in memory: its figure is only reported */
      CHECK(used <= ALLOWED, "%s, way %d%s: %zu bytes", pktrt_isa_string(isas[k / 2]), p.what,
          k % 2 ? ", with an instance" : "", used);
#endif
      if (used > most) most = used;
    }
    pktrt_scene_destroy(s);
  }
  say("at most %zu bytes", most);
  free(rays);
  free(hits);
  free(occluded);
  world_free(&w);
}

/* --- statistics --- */

static uint64_t event_count[PKTRT_EVENT_LEAF_TEST + 1];
static void count_event(void *user, const pktrt_event *e) {
  (void)user;
  if (CHECK((unsigned)e->kind < COUNT(event_count))) event_count[e->kind]++;
}

static void statistics(void) {
  for (int moves = 0; moves < 2; moves++) {
    world w = moves ? world_moving(4) : world_static(4);
    pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
    size_t n = small_run ? 2048 : 8192, valid = 0, hits = 0;
    pktrt_ray *rays = calloc(2 * n, sizeof *rays);
    pktrt_hit *h = calloc(2 * n, sizeof *h);
    if (!rays || !h) abort();
    make_rays(&w, s, RAYS_CAMERA, 1, 0, rays, n);
    make_rays(&w, s, RAYS_INVALID, 1, 0, rays + n, n);
    for (size_t i = 0; i < 2 * n; i++) valid += ref_valid(&rays[i]);
    for (int path = 0; path < 3; path++) {
      pktrt_query_desc q;
      pktrt_stats stats, more;
      memset(&q, 0, sizeof q);
      memset(&stats, 0, sizeof stats);
      memset(event_count, 0, sizeof event_count);
      q.path = (pktrt_path)path, q.stats = &stats, q.type = PKTRT_RAY_REFLECTION, q.trace = count_event;
      pktrt_intersect_ex(s, &q, rays, h, 2 * n);
      hits = 0;
      for (size_t i = 0; i < 2 * n; i++) hits += h[i].mesh != PKTRT_NONE;
      const pktrt_counts *c = &stats.by_type[PKTRT_RAY_REFLECTION];
      CHECK(c->rays == valid && c->hits == hits, "path %d: %llu rays, %llu hits", path, (unsigned long long)c->rays,
          (unsigned long long)c->hits);
      if (path == PKTRT_PATH_FAST && !COUNTS_FAST) {
        pktrt_counts same;
        memset(&same, 0, sizeof same);
        same.rays = valid, same.hits = hits;
        CHECK(same_bits(c, &same, sizeof same), "the fast path counts rays and hits, and nothing else");
        continue;
      }
      CHECK(c->packets > 0 && c->node_visits > 0 && c->box_tests > 0 && c->triangle_tests >= hits, "path %d", path);
      CHECK(c->canonical_tests >= hits && c->settlings <= c->canonical_tests, "path %d: %llu canonical, %llu settled",
          path, (unsigned long long)c->canonical_tests, (unsigned long long)c->settlings);
      if (path == PKTRT_PATH_PAPER) {
        CHECK(c->packets >= (2 * n + 63) / 64 / 2 && c->first_hits > 0 && c->interval_culls + c->frustum_culls > 0 &&
              c->ray_culls > 0);
        CHECK(event_count[PKTRT_EVENT_NODE] == c->node_visits, "%llu node events",
            (unsigned long long)event_count[PKTRT_EVENT_NODE]);
        CHECK(event_count[PKTRT_EVENT_FIRST_HIT] == c->first_hits &&
              event_count[PKTRT_EVENT_INTERVAL_CULL] == c->interval_culls &&
              event_count[PKTRT_EVENT_FRUSTUM_CULL] == c->frustum_culls &&
              event_count[PKTRT_EVENT_ALL_MISS] == c->ray_culls);
        CHECK(event_count[PKTRT_EVENT_LEAF] > 0 && event_count[PKTRT_EVENT_HIT] > 0);
      } else {
        CHECK(event_count[0] + event_count[1] + event_count[2] == 0, "only the paper path is traced");
      }
      if (path == PKTRT_PATH_FAST)
        CHECK(
            (c->frustum_culls > 0) == has_frusta(PKTRT_ISA_AUTO) && c->packets < 2 * n, "coherent rays go in packets");
      more = stats; /* counts are added to, in one row only */
      pktrt_intersect_ex(s, &q, rays, h, 2 * n);
      CHECK(stats.by_type[q.type].rays == 2 * more.by_type[q.type].rays);
      CHECK(stats.by_type[q.type].box_tests == 2 * more.by_type[q.type].box_tests, "work repeats");
      for (int t = 0; t < (int)PKTRT_RAY_TYPE_COUNT; t++) CHECK(t == (int)q.type || stats.by_type[t].rays == 0);
      say("%s path %d: per ray %.2f nodes, %.1f box, %.1f triangle tests; %.4f settled", moves ? "moving" : "static",
          path, (double)more.by_type[2].node_visits / (double)valid, (double)more.by_type[2].box_tests / (double)valid,
          (double)more.by_type[2].triangle_tests / (double)valid, (double)more.by_type[2].settlings / (double)valid);
    }
    pktrt_scene_destroy(s);
    free(rays);
    free(h);
    world_free(&w);
  }
}

/* Rays whose interval lies beyond the range of floats, once scaled by a direction as long as this, hit nothing, and cost
   the others of their packet nothing. */
static void beyond_range(void) {
  world w = world_static(4);
  size_t n = 1024, hits = 0;
  pktrt_ray *rays = calloc(n, sizeof *rays);
  pktrt_hit *alone = calloc(n, sizeof *alone), *together = calloc(n, sizeof *together);
  if (!rays || !alone || !together) abort();
  for (int k = 0; k < isa_count; k++) {
    pktrt_scene *s = world_scene(&w, isas[k], 0);
    make_rays(&w, s, RAYS_CAMERA, 1, 0, rays, n);
    for (size_t i = 0; i < n; i++) {
      const bool late = i % 64 >= 32, odd = i % 64 == 31; /* what follows must not decide for the packet */
      if (late && i & 64) rays[i].tmax = 1e-3f;
      else if (late) rays[i].tmin = 1e6f;
      for (int a = 0; a < 3 && odd; a++) rays[i].direction[a] *= 1e3f;
      if (odd && i & 64) rays[i].tmin = -INFINITY, rays[i].tmax = -2e38f;
      else if (odd) rays[i].tmin = 2e38f;
      pktrt_intersect(s, &rays[i], &alone[i]);
      if (odd) CHECK(alone[i].mesh == PKTRT_NONE);
    }
    for (int path = 0; path < 3; path++) {
      pktrt_query_desc q;
      memset(&q, 0, sizeof q);
      q.path = (pktrt_path)path;
      pktrt_intersect_ex(s, &q, rays, together, n);
      for (size_t i = 0; i < n; i++) {
        CHECK(together[i].mesh == alone[i].mesh && together[i].triangle == alone[i].triangle, "path %d, ray %zu", path,
            i);
        hits += together[i].mesh != PKTRT_NONE;
      }
    }
    pktrt_scene_destroy(s);
  }
  CHECK(hits > 0, "something is hit");
  free(rays);
  free(alone);
  free(together);
  world_free(&w);
}

/* Rows of one value are not read ray by ray where rays are sorted; rows that only their last value makes others are. */
static void rows_of_one_value(void) {
  enum { N = 4000 };
  static float row[9][N], t[N];
  world w = world_moving(4);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  pktrt_ray *rays = calloc(N, sizeof *rays);
  if (!rays) abort();
  make_rays(&w, s, RAYS_RANDOM, 5, 0, rays, N);
  const pktrt_rays in = {{row[0], row[1], row[2]}, {row[3], row[4], row[5]}, row[6], row[7], row[8]};
  const pktrt_hits out = {t, NULL, NULL, {NULL, NULL, NULL}, NULL, NULL};
  size_t wrong = 0, hits = 0, otherwise = 0;
  for (int last = 0; last < 2; last++) {
    for (int i = 0; i < N; i++) {
      const bool other = last && i == N - 1;
      for (int a = 0; a < 3; a++) row[a][i] = rays[i].origin[a], row[3 + a][i] = rays[i].direction[a];
      row[6][i] = rays[i].tmin = other ? 0 : 0.25f, row[7][i] = rays[i].tmax = other ? INFINITY : 3;
      row[8][i] = rays[i].time = other ? 0 : 0.75f;
    }
    pktrt_intersect_soa(s, &in, &out, N);
    for (int i = 0; i < N; i++) {
      pktrt_hit h;
      hits += pktrt_intersect(s, &rays[i], &h), wrong += !same_bits(&h.t, &t[i], sizeof t[i]);
      rays[i].tmin = 0, rays[i].tmax = INFINITY, rays[i].time = 0; /* the control */
      pktrt_intersect(s, &rays[i], &h), otherwise += !same_bits(&h.t, &t[i], sizeof t[i]);
    }
  }
  CHECK(wrong == 0 && hits > N / 2, "%zu of %zu hits wrong", wrong, hits);
  CHECK(otherwise > N / 2, "other values matter: %zu", otherwise);
  say("%zu hits of %d rays; with the values of rows left out %zu differ", hits, 2 * N, otherwise);
  pktrt_scene_destroy(s);
  free(rays);
  world_free(&w);
}

/* Where 64 rays are two bundles, they are two packets and some rays beside; rays all over are no packets. */
static void bundles_in_packets(void) {
  enum { N = 64 * 200 };
  world w = world_static(5);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  pktrt_ray *rays = calloc(N, sizeof *rays);
  pktrt_hit *h = calloc(N, sizeof *h);
  if (!rays || !h) abort();
  static const ray_kind kinds[2] = {RAYS_BUNDLES, RAYS_RANDOM};
  double culls[2];
  for (int k = 0; k < 2; k++) {
    pktrt_query_desc q;
    pktrt_stats stats;
    memset(&q, 0, sizeof q);
    memset(&stats, 0, sizeof stats);
    q.stats = &stats;
    make_rays(&w, s, kinds[k], 5, 0, rays, N);
    for (int i = 0; i < N; i += 64) pktrt_intersect_ex(s, &q, rays + i, h + i, 64); /* more would be sorted */
    culls[k] = (double)stats.by_type[0].frustum_culls / N;
  }
  say("boxes that a frustum culled, per ray: %.2f of bundles, %.2f of random rays", culls[0], culls[1]);
  if (has_frusta(PKTRT_ISA_AUTO)) CHECK(culls[0] > 0.1 && culls[1] < 0.1 * culls[0]);
  else CHECK(culls[0] == 0 && culls[1] == 0, "nothing but streams");
  pktrt_scene_destroy(s);
  free(rays), free(h);
  world_free(&w);
}

/* The paper path's vectors of eight: one ray keeps one lane busy, packets more, and coherent ones need fewer vectors. */
static void vectors_of_eight(void) {
  const uint32_t sizes[3] = {1, 8, 64};
  for (int moves = 0; moves < 2; moves++) {
    world w = moves ? world_moving(4) : world_static(4);
    pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
    size_t n = 4096;
    uint64_t before = UINT64_MAX;
    pktrt_ray *rays = calloc(n, sizeof *rays);
    pktrt_hit *h = calloc(n, sizeof *h);
    if (!rays || !h) abort();
    make_rays(&w, s, RAYS_CAMERA, 1, 0, rays, n);
    for (int k = 0; k < 3; k++) {
      pktrt_query_desc q;
      pktrt_stats stats;
      memset(&q, 0, sizeof q);
      memset(&stats, 0, sizeof stats);
      q.path = PKTRT_PATH_PAPER, q.packet_size = sizes[k], q.stats = &stats;
      pktrt_intersect_ex(s, &q, rays, h, n);
      const pktrt_counts *c = &stats.by_type[0];
      const uint64_t boxes = c->vector_box_tests, triangles = c->vector_triangle_tests;
      CHECK(boxes <= c->box_tests && c->box_tests <= 8 * boxes, "packets of %u: %llu box tests in %llu vectors",
          sizes[k], (unsigned long long)c->box_tests, (unsigned long long)boxes);
      CHECK(triangles <= c->triangle_tests && c->triangle_tests <= 8 * triangles, "packets of %u", sizes[k]);
      if (sizes[k] == 1) CHECK(boxes == c->box_tests && triangles == c->triangle_tests, "one ray, one lane");
      CHECK(boxes + triangles < before / 4 * 3, "packets of %u: no amortisation", sizes[k]);
      say("%s, packets of %u: %.1f vectors per ray, %.1f lanes of them busy", moves ? "moving" : "static", sizes[k],
          (double)(boxes + triangles) / (double)n,
          (double)(c->box_tests + c->triangle_tests) / (double)(boxes + triangles));
      before = boxes + triangles;
    }
    pktrt_scene_destroy(s);
    free(rays);
    free(h);
    world_free(&w);
  }
}

void suite_scene(void) {
  run("0 to 20 triangles answer as brute force", tiny_scenes);
  run("degenerate triangles are accepted, counted and never hit", degenerate);
  run("strides, odd addresses and soups give the same hits", layouts);
  run("odd queries: none, NULL, zeroed, NaN, infinite, out of range", odd_queries);
  run("hits lie strictly between tmin and tmax", intervals);
  run("rays beyond the range of floats hit nothing and cost their neighbours nothing", beyond_range);
  run("meshes move linearly between their keys, time is clamped", motion);
  run("rows of rays that are NULL mean tmin 0, tmax infinite and time 0", rows_left_out);
  run("rows of one value count for every ray", rows_of_one_value);
  run("a moving triangle without area at the ray's time is no hit, by rounding neither", no_area_at_the_time);
  run("a moving triangle that is a line at the ray's time is no hit behind its origin either", line_before_the_start);
  run("changes show at commit or refit, not before", when_changes_show);
  run("keys that are set in any order, twice or in vain, are those of the next state", keys_set_in_any_order);
  run("triangles far from thousands are where a refit puts them", lone_triangles_move);
  run("what is marked as changed is built anew at the next commit, refits in between or not", marked_scenes);
  run("after a miss there is nothing, wherever the ray ends", nothing_after_a_miss);
  run("several threads query one scene", concurrent_queries);
  run("a query uses at most 60 KiB of stack", stack_bound);
  run("statistics count what happened", statistics);
  if (COUNTS_FAST) run("rays in bundles go in packets, rays all over do not", bundles_in_packets);
  run("vectors of eight tests hold what is counted, and coherent packets need fewer", vectors_of_eight);
}
