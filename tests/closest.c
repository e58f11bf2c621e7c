/* pktrt_closest_point against all triangles, one by one, in long double: on meshes at rest and moving, instances, masks, far points,
   ties; the same bits however it is asked; and with pktrt_winding a signed distance. */
#include "placed.h"

/* --- the reference --- */

typedef struct facet {
  long double p[3][3];
  uint32_t mesh, triangle, mask;
} facet;
typedef struct facets {
  facet *f;
  size_t n, room;
} facets;

static long double dot_of(const long double a[3], const long double b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
static void cross_of(const long double a[3], const long double b[3], long double out[3]) {
  for (int i = 0; i < 3; i++) out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}
static void normal_of(const facet *f, long double n[3]) {
  long double ab[3], ac[3];
  for (int a = 0; a < 3; a++) ab[a] = f->p[1][a] - f->p[0][a], ac[a] = f->p[2][a] - f->p[0][a];
  cross_of(ab, ac, n);
}

/* Adds the triangles of a mesh at a time that have area, placed by a matrix of 3 x 4, or as they are. */
static void add_facets(facets *to, const mesh *m, float time, const double *matrix, uint32_t index, uint32_t mask) {
  const float at = (time > 0 ? time < 1 ? time : 1 : 0) * (float)(m->keys - 1);
  uint32_t key = (uint32_t)at;
  if (key && key > m->keys - 2) key = m->keys - 2;
  const float tb = at - (float)key, ta = 1 - tb;
  for (uint32_t t = 0; t < m->nt; t++) {
    facet f;
    long double n[3];
    for (int c = 0; c < 3; c++) {
      const float *k0 = m->p + ((size_t)key * m->nv + m->i[3 * t + (uint32_t)c]) * 3;
      float p[3];
      for (int a = 0; a < 3; a++) p[a] = m->keys > 1 ? ta * k0[a] + tb * k0[(size_t)m->nv * 3 + (size_t)a] : k0[a];
      for (int a = 0; a < 3; a++) {
        const double *row = matrix ? matrix + 4 * a : NULL;
        f.p[c][a] = matrix ? (long double)row[0] * (long double)p[0] + (long double)row[1] * (long double)p[1] +
                                 (long double)row[2] * (long double)p[2] + (long double)row[3]
                           : (long double)p[a];
      }
    }
    f.mesh = index, f.triangle = t, f.mask = mask ? mask : UINT32_MAX;
    normal_of(&f, n);
    if (dot_of(n, n) == 0) continue;
    if (to->n == to->room) {
      to->room = 2 * to->room + 64;
      to->f = (facet *)realloc(to->f, to->room * sizeof *to->f);
      if (!to->f) abort();
    }
    to->f[to->n++] = f;
  }
}

/* Returns the distance of a point to a triangle: the least of its edges' and, if the foot lies inside, that of its plane. */
static long double facet_distance(const facet *f, const float point[3]) {
  long double n[3], square = INFINITY, inside = 1;
  normal_of(f, n);
  for (int c = 0; c < 3; c++) {
    const long double *from = f->p[c], *to = f->p[(c + 1) % 3];
    long double edge[3], way[3], out[3], rest[3];
    for (int a = 0; a < 3; a++) edge[a] = to[a] - from[a], way[a] = (long double)point[a] - from[a];
    const long double t = fminl(fmaxl(dot_of(edge, way) / dot_of(edge, edge), 0), 1);
    for (int a = 0; a < 3; a++) rest[a] = way[a] - t * edge[a];
    square = fminl(square, dot_of(rest, rest));
    cross_of(edge, way, out);
    inside = fminl(inside, dot_of(out, n) > 0);
  }
  long double way[3];
  for (int a = 0; a < 3; a++) way[a] = (long double)point[a] - f->p[0][a];
  const long double high = fabsl(dot_of(way, n)) / sqrtl(dot_of(n, n));
  return inside > 0 ? fminl(high, sqrtl(square)) : sqrtl(square);
}

/* Returns how far the distance may be above that of a triangle: (2^-49 k + 2^-39) (d + L), at most 2^-24 of d + L. */
static long double allowed(const facet *f, long double distance) {
  long double n[3], longest = 0;
  normal_of(f, n);
  for (int c = 0; c < 3; c++) {
    long double edge[3];
    for (int a = 0; a < 3; a++) edge[a] = f->p[(c + 1) % 3][a] - f->p[c][a];
    longest = fmaxl(longest, sqrtl(dot_of(edge, edge)));
  }
  const long double k = longest * longest / sqrtl(dot_of(n, n));
  return fminl(0x1p-49L * k + 0x1p-39L, 0x1p-24L) * (distance + longest);
}

typedef struct tally {
  size_t asked, found, wrong; /* wrong: in any way */
  long double worst;          /* the largest part of what is allowed */
} tally;

/* Compares an answer with the reference. `size`: of the numbers that place instances. */
static void compare(
    const facets *list, const pktrt_point_query *q, const pktrt_closest *got, long double size, tally *t) {
  const facet *best = NULL, *named = NULL;
  long double least = INFINITY, n[3];
  for (size_t i = 0; i < list->n; i++) {
    const facet *f = &list->f[i];
    if (!(f->mask & (q->mask ? q->mask : UINT32_MAX))) continue;
    const long double d = facet_distance(f, q->point);
    if (d < least) best = f, least = d;
    if (f->mesh == got->mesh && f->triangle == got->triangle) named = f;
  }
  const long double limit = (long double)q->max_distance, found = (long double)got->distance;
  const long double off = best ? allowed(best, least) + 0x1p-50L * size : 0, rounding = 0x1p-23L * least;
  t->asked++;
  if (got->mesh == PKTRT_NONE) {
    t->wrong += (best && least + off < limit) || got->triangle != PKTRT_NONE || got->distance != INFINITY;
    return;
  }
  t->found++;
  if (!named) {
    t->wrong++;
    return;
  }
  t->worst = fmaxl(t->worst, (found - least) / (off + rounding));
  bool right = found <= least + off + rounding && found >= least - rounding - 0x1p-49L * size - 0x1p-9L * off;
  right = right && found <= limit && facet_distance(named, q->point) <= least + off;
  right = right && got->u >= 0 && got->v >= 0 && (1 - got->u) - got->v >= 0;
  normal_of(named, n);
  const long double unit = sqrtl(dot_of(n, n));
  long double way = 0, slack_of_all = 0;
  for (int a = 0; a < 3; a++) {
    const long double p0 = named->p[0][a], u = (long double)got->u, v = (long double)got->v;
    const long double e1 = named->p[1][a] - p0, e2 = named->p[2][a] - p0, at = p0 + u * e1 + v * e2;
    const long double slack = 0x1p-23L * (fabsl(at) + fabsl(e1) + fabsl(e2)) + 0x1p-49L * size;
    right = right && fabsl((long double)got->point[a] - at) <= slack;
    right = right && fabsl((long double)got->normal[a] - n[a] / unit) <= 0x1p-22L;
    way += (at - (long double)q->point[a]) * (at - (long double)q->point[a]);
    slack_of_all += slack;
  }
  right = right && sqrtl(way) <= found + rounding + slack_of_all + off;
  t->wrong += !right;
}

/* --- scenes --- */

enum { ZOO_MESHES = 7, ZOO_MODELS = 4, ZOO_INSTANCES = 8, QUERIES = 240 };
typedef struct zoo {
  mesh m[ZOO_MESHES], model[ZOO_MODELS];
  float placed[ZOO_INSTANCES][24];
  uint32_t groups; /* how many groups the meshes are in */
} zoo;
static const uint32_t zoo_masks[ZOO_MESHES + ZOO_INSTANCES] = {1, 2, 0, 4, 1, 0, 2, 1, 2, 4, 0, 1, 2, 4, 0};
static const uint32_t zoo_of[ZOO_INSTANCES] = {0, 1, 2, 0, 1, 0, 2, 3},
                      zoo_keys[ZOO_INSTANCES] = {1, 1, 2, 1, 2, 1, 1, 1};

static zoo zoo_make(uint32_t groups) {
  /* Diagonal, mirrored and sheared, moving, tiny, turned while it grows, huge and flat, far away, and far away in its model. */
  static const float placed[ZOO_INSTANCES][24] = {{0.4f, 0, 0, 3, 0, 0.7f, 0, 0, 0, 0, 0.2f, 0},
      {-0.5f, 0.3f, 0.1f, -3, 0.2f, 0.4f, 0.7f, 1, 0, -0.2f, 0.6f, 0},
      {0.3f, 0, 0, 0, 0, 0.3f, 0, 3, 0, 0, 0.3f, 0, 0.3f, 0.1f, 0, 1, 0, 0.4f, 0, 3, 0.2f, 0, 0.2f, 1},
      {1e-6f, 2e-7f, 0, 0, 0, 1e-6f, 0, -3, 0, 3e-7f, 2e-6f, 0},
      {0.3f, 0, 0, 0, 0, 0.3f, 0, 0, 0, 0, 0.3f, 4, 0.1f, 0.3f, 0, 0, -0.4f, 0.2f, 0, 0, 0, 0, 0.5f, 4},
      {2e4f, 0, 50, 0, 0, 3, 10, -30, 0, 1, 2e4f, 0}, {1, 0, 0, 7e5f, 0, 1, 0, 3e5f, 0, 0, 1, 0},
      {0.6f, -0.8f, 0.1f, -2250, 0.7f, 0.5f, 0, 297, 0.1f, 0, 0.9f, -550}};
  zoo z;
  z.m[0] = mesh_sphere(3, 0.05f, 1), z.m[1] = mesh_soup(300, 0.2f, 2), z.m[2] = mesh_thin(200, 3);
  z.m[3] = mesh_grid(9, 2), z.m[4] = mesh_box(), z.m[5] = mesh_sphere(2, 0.2f, 4), z.m[6] = mesh_soup(60, 1e-6f, 5);
  mesh_shift(&z.m[3], 0, -1.4f, 0), mesh_shift(&z.m[4], 1, 1, 1.5f), mesh_shift(&z.m[5], -2, 0, 0);
  mesh_move(&z.m[1], 3, 0.3f, 0.1f, 6), mesh_move(&z.m[5], 2, 0.4f, 0.05f, 7), mesh_move(&z.m[6], 2, 0.2f, 1e-6f, 8);
  z.model[0] = mesh_sphere(2, 0.1f, 11), z.model[1] = mesh_soup(200, 0.3f, 12), z.model[2] = mesh_thin(60, 13);
  z.model[3] = mesh_sphere(4, 0.02f, 15), mesh_shift(&z.model[3], 1000, -2000, 500);
  mesh_move(&z.model[1], 2, 0.2f, 0.1f, 14);
  memcpy(z.placed, placed, sizeof placed);
  z.groups = groups;
  return z;
}
static void zoo_free(zoo *z) {
  for (int i = 0; i < ZOO_MESHES; i++) mesh_free(&z->m[i]);
  for (int i = 0; i < ZOO_MODELS; i++) mesh_free(&z->model[i]);
}
static pktrt_scene *zoo_scene(const zoo *z, pktrt_isa isa, pktrt_build_quality quality) {
  pktrt_scene_desc sd = scene_desc_of(isa, 0);
  sd.quality = quality;
  pktrt_scene *s = pktrt_scene_create(&sd);
  if (!CHECK(s != NULL)) abort();
  for (uint32_t i = 0; i < ZOO_MESHES; i++) {
    pktrt_mesh_desc d = mesh_desc(&z->m[i]);
    d.group = z->groups ? i % z->groups : 0, d.mask = zoo_masks[i];
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  }
  for (uint32_t i = 0; i < ZOO_MODELS; i++) {
    const pktrt_mesh_desc d = mesh_desc(&z->model[i]);
    CHECK(pktrt_add_model(s, &d, 1, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  }
  for (uint32_t i = 0; i < ZOO_INSTANCES; i++) {
    const pktrt_instance_desc d = {
        zoo_of[i], zoo_keys[i], z->placed[i], zoo_masks[ZOO_MESHES + i], PKTRT_INTERPOLATION_LINEAR};
    CHECK(pktrt_add_instance(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  }
  CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  return s;
}

/* What there is at a time, but for the meshes whose bits are in `without`. */
static void zoo_facets(const zoo *z, float time, uint32_t without, facets *out) {
  out->n = 0;
  for (uint32_t i = 0; i < ZOO_MESHES; i++)
    if (!(without >> i & 1)) add_facets(out, &z->m[i], time, NULL, i, zoo_masks[i]);
  for (uint32_t i = 0; i < ZOO_INSTANCES; i++) {
    double matrix[12];
    placed_at(z->placed[i], zoo_keys[i], time, matrix);
    if (!(without >> (ZOO_MESHES + i) & 1))
      add_facets(out, &z->model[zoo_of[i]], time, matrix, ZOO_MESHES + i, zoo_masks[ZOO_MESHES + i]);
  }
}

/* Query i: about the meshes, at corners, near the surface, far and farther; of one time. */
static pktrt_point_query query_of(rng *r, const facets *list, uint32_t i, float time) {
  static const float reach[4] = {0, 0.1f, 1, 1e4f};
  const facet *f = &list->f[rng_below(r, (uint32_t)list->n)];
  pktrt_point_query q;
  memset(&q, 0, sizeof q);
  for (int a = 0; a < 3; a++) {
    const long double middle = (f->p[0][a] + f->p[1][a] + f->p[2][a]) / 3;
    q.point[a] = 4 * rng_sign(r);
    if (i % 6 == 1) q.point[a] = (float)f->p[i % 3][a];
    if (i % 6 == 2) q.point[a] = (float)middle + 0.02f * rng_sign(r);
    if (i % 6 == 3) q.point[a] = (float)((f->p[0][a] + f->p[1][a]) / 2) + (i % 12 == 3 ? 3e-5f * rng_sign(r) : 0);
    if (i % 6 == 4) q.point[a] *= powf(10, (float)(i % 19));
    if (i % 6 == 5) q.point[a] = (float)middle + 1e-6f * rng_sign(r);
  }
  q.time = time, q.mask = i % 5 ? 0 : 1u << i % 3;
  q.max_distance = i % 7 ? INFINITY : reach[i / 7 % 4];
  return q;
}

/* --- tests --- */

static void against_all_triangles(void) {
  facets list = {NULL, 0, 0};
  tally t = {0, 0, 0, 0};
  for (uint32_t turn = 0; turn < 6; turn++) {
    rng r = rng_of(turn + 1);
    const float time = turn ? (float)turn / 5 : -3;
    zoo z = zoo_make(turn % 3 * 3);
    pktrt_scene *s = zoo_scene(&z, PKTRT_ISA_AUTO, (pktrt_build_quality)(turn % 3));
    zoo_facets(&z, time, 0, &list);
    for (uint32_t i = 0; i < scaled(QUERIES) + 20; i++) {
      const pktrt_point_query q = query_of(&r, &list, i, time);
      pktrt_closest got;
      pktrt_closest_point_n(s, &q, &got, 1);
      compare(&list, &q, &got, 1e6L, &t);
    }
    pktrt_scene_destroy(s), zoo_free(&z);
  }
  CHECK(!t.wrong, "%zu of %zu", t.wrong, t.asked);
  CHECK(t.found * 20 > t.asked * 17 && t.found < t.asked, "%zu found of %zu", t.found, t.asked);
  say("%zu points; the worst distance is off by %.2f of what may be", t.asked, (double)t.worst);
  free(list.f);
}

/* Triangles from the origin that are 2^44 times as long as high: of numbers of Fibonacci, whose cross products are 1. */
static mesh mesh_of_fibonacci(uint64_t seed) {
  static const float b[3] = {5702887, 3524578, 5702887}, c[3] = {3524578, 2178309, 3524578};
  enum { N = 240 };
  rng r = rng_of(seed);
  mesh m = mesh_of(3 * N, N);
  for (uint32_t t = 0; t < N; t++) {
    float *p = m.p + 9 * (size_t)t;
    for (uint32_t a = 0; a < 3; a++) {
      const float sign = rng_below(&r, 2) ? 0x1p-22f : -0x1p-22f;
      p[3 * (t % 3) + (a + t / 3) % 3] = 0;
      p[3 * ((t + 1) % 3) + (a + t / 3) % 3] = sign * b[a];
      p[3 * ((t + 2) % 3) + (a + t / 3) % 3] = sign * c[a];
    }
    for (uint32_t i = 0; i < 3; i++) m.i[3 * t + i] = 3 * t + i;
  }
  return m;
}

/* Each mesh alone, at scales from 1e-20 to 1e20: the error bound, without that of what places instances. */
static void at_any_scale(void) {
  static const float scales[5] = {1e-20f, 1e-6f, 1, 1e12f, 1e20f};
  tally t = {0, 0, 0, 0};
  facets list = {NULL, 0, 0};
  for (uint32_t i = 0; i < 5 * 5; i++) {
    rng r = rng_of(i + 50);
    const float scale = scales[i % 5];
    mesh m = i / 5 == 0   ? mesh_sphere(3, 0.02f, i)
             : i / 5 == 1 ? mesh_soup(300, 0.1f, i)
             : i / 5 == 2 ? mesh_thin(300, i)
             : i / 5 == 3 ? mesh_fan(200, i)
                          : mesh_of_fibonacci(i);
    mesh_scale(&m, scale);
    world w = world_of(m);
    pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
    list.n = 0, add_facets(&list, &w.m[0], 0, NULL, 0, 0);
    for (uint32_t k = 0; k < scaled(QUERIES) + 10; k++) {
      pktrt_point_query q = query_of(&r, &list, k, 0);
      q.mask = 0, q.max_distance = INFINITY;
      for (int a = 0; a < 3 && (k % 6 == 0 || k % 6 == 4); a++)
        q.point[a] = (k % 6 == 0 ? 1.5f : 30.0f) * scale * rng_sign(&r);
      pktrt_closest got, other;
      pktrt_closest_point_n(s, &q, &got, 1);
      CHECK(pktrt_closest_point(s, q.point, q.max_distance, &other) && same_bits(&got, &other, sizeof got));
      compare(&list, &q, &got, 0, &t);
      CHECK(pktrt_closest_point(s, q.point, got.distance, &other) && same_bits(&got, &other, sizeof got),
          "what is at a distance of %g is not within that", (double)got.distance);
    }
    pktrt_scene_destroy(s), world_free(&w);
  }
  CHECK(!t.wrong && t.found == t.asked, "%zu of %zu, %zu found", t.wrong, t.asked, t.found);
  say("%zu points; the worst distance is off by %.2f of what may be", t.asked, (double)t.worst);
  free(list.f);
}

/* A flat model that lies far from its origin, where points are rounded by more than they are away from it. */
static void far_in_its_model(void) {
  const float matrix[12] = {1, 0, 0, -1000, 0, 1, 0, -2000, 0, 0, 1, -3000};
  double exact[12];
  facets list = {NULL, 0, 0};
  tally t = {0, 0, 0, 0};
  rng r = rng_of(6);
  mesh sheet = mesh_grid(8, 4);
  const pktrt_scene_desc sd = scene_desc_of(PKTRT_ISA_AUTO, 0);
  const pktrt_instance_desc in = {0, 1, matrix, 0, PKTRT_INTERPOLATION_LINEAR};
  pktrt_scene *s = pktrt_scene_create(&sd);
  mesh_shift(&sheet, 1000, 2000, 3000);
  const pktrt_mesh_desc d = mesh_desc(&sheet);
  CHECK(pktrt_add_model(s, &d, 1, NULL) == PKTRT_OK && pktrt_add_instance(s, &in, NULL) == PKTRT_OK);
  CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  for (int k = 0; k < 12; k++) exact[k] = (double)matrix[k];
  add_facets(&list, &sheet, 0, exact, 0, 0);
  for (int i = 0; i < 1000; i++) { /* beside edges of squares */
    pktrt_point_query q;
    pktrt_closest got;
    memset(&q, 0, sizeof q);
    q.point[0] = (float)(int)rng_below(&r, 7) - 3 + 5e-5f * rng_sign(&r);
    q.point[1] = rng_range(&r, 6.5e-5f, 1e-4f); /* 1.2e-4 there */
    q.point[2] = 5e-5f * rng_sign(&r);
    q.max_distance = INFINITY;
    pktrt_closest_point_n(s, &q, &got, 1);
    compare(&list, &q, &got, 6000, &t);
  }
  CHECK(!t.wrong, "%zu of %zu", t.wrong, t.asked);
  pktrt_scene_destroy(s), mesh_free(&sheet);
  free(list.f);
}

/* Trees of all kinds and sets, single calls and many, meshes that were built so and that were set and refitted. */
static void the_same_bits(void) {
  enum { N = 200 };
  pktrt_point_query q[N];
  pktrt_closest want[N], got[N];
  facets list = {NULL, 0, 0};
  rng r = rng_of(9);
  zoo z = zoo_make(0);
  zoo_facets(&z, 0.3f, 0, &list);
  for (uint32_t i = 0; i < N; i++) q[i] = query_of(&r, &list, i, rng_unit(&r));
  for (uint32_t way = 0; way < (uint32_t)isa_count + 5; way++) {
    static const uint32_t groups[5] = {0, 2, 7, 0, 0};
    const uint32_t build = way < (uint32_t)isa_count ? 0 : way - (uint32_t)isa_count;
    z.groups = groups[build];
    pktrt_scene *s = zoo_scene(
        &z, way < (uint32_t)isa_count ? isas[way] : PKTRT_ISA_AUTO, (pktrt_build_quality)(build < 3 ? 0 : build - 2));
    if (build == 1) { /* there and back */
      float *moved = (float *)calloc((size_t)z.m[0].nv * 3, sizeof *moved);
      CHECK(moved && pktrt_set_positions(s, 0, 0, moved) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK);
      CHECK(pktrt_set_positions(s, 0, 0, z.m[0].p) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK);
      free(moved);
    }
    pktrt_closest_point_n(s, q, way ? got : want, N);
    CHECK(!way || same_bits(got, want, sizeof want), "way %u", way);
    for (uint32_t i = 0; i < N; i++) {
      pktrt_closest one, simple;
      pktrt_closest_point_n(s, &q[i], &one, 1);
      CHECK(same_bits(&one, &want[i], sizeof one), "way %u, point %u alone", way, i);
      if (q[i].mask || q[i].time > 0) continue;
      CHECK(pktrt_closest_point(s, q[i].point, q[i].max_distance, &simple) == (simple.mesh != PKTRT_NONE));
      CHECK(same_bits(&simple, &want[i], sizeof simple), "way %u, point %u", way, i);
    }
    pktrt_scene_destroy(s);
  }
  zoo_free(&z);
  free(list.f);
}

/* At corners and edges of a convex body, and where meshes lie on one another, the first of those that are equally near. */
static void ties_go_to_the_first(void) {
  size_t wrong = 0, ties = 0;
  mesh ball = mesh_sphere(3, 0, 1), copies = mesh_copies(&ball, 3);
  world w = world_none();
  w.m[0] = mesh_soup(5, 0.1f, 3), mesh_shift(&w.m[0], 50, 0, 0);
  w.m[1] = copies, w.m[2] = ball, w.n = 3;
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  for (uint32_t i = 0; i < 3 * ball.nt; i++) {
    const uint32_t from = ball.i[i], to = ball.i[i % 3 == 2 ? i - 2 : i + 1];
    for (int kind = 0; kind < 3; kind++) { /* above a corner, above an edge, in a corner */
      float p[3];
      uint32_t first = PKTRT_NONE;
      pktrt_closest got;
      for (int a = 0; a < 3; a++) {
        const float x = ball.p[3 * from + (uint32_t)a], y = ball.p[3 * to + (uint32_t)a];
        p[a] = kind == 0 ? 1.5f * x : kind == 1 ? 0.8f * (x + y) : x;
      }
      for (uint32_t t = ball.nt; t-- > 0;) {
        int at = 0;
        for (int c = 0; c < 3; c++) {
          const uint32_t v = ball.i[3 * t + (uint32_t)c];
          at += v == from || (kind == 1 && v == to);
        }
        if (at == (kind == 1 ? 2 : 1)) first = t;
      }
      ties++;
      wrong += !pktrt_closest_point(s, p, INFINITY, &got) || got.mesh != 1 || got.triangle != first;
      wrong += kind == 2 && got.distance != 0;
    }
  }
  CHECK(!wrong, "%zu of %zu", wrong, ties);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* The tip of a pyramid of many sides, whose coordinates are so small that edges to it are rounded in doubles. */
static void ties_at_a_tip(void) {
  enum { SIDES = 40 };
  static const float tip[3] = {1.1e-9f, -2.3e-10f, 3.7e-10f};
  rng r = rng_of(8);
  mesh m = mesh_of(SIDES + 1, SIDES);
  for (uint32_t i = 0; i < SIDES; i++) {
    const float angle = 6.2831853f * (float)i / (float)SIDES, size = rng_range(&r, 500, 900);
    const float rim[3] = {size * cosf(angle), size * sinf(angle), -size};
    memcpy(m.p + 3 * (i + 1), rim, sizeof rim);
    m.i[3 * i + i % 3] = 0, m.i[3 * i + (i + 1) % 3] = i + 1, m.i[3 * i + (i + 2) % 3] = i + 1 < SIDES ? i + 2 : 1;
  }
  memcpy(m.p, tip, sizeof tip);
  world w = world_of(m);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  for (int i = 0; i < 100; i++) {
    const float p[3] = {1e-10f * rng_sign(&r), 1e-10f * rng_sign(&r), 1e-7f * (1 + rng_unit(&r))};
    pktrt_closest got;
    CHECK(pktrt_closest_point(s, p, INFINITY, &got) && got.triangle == 0, "triangle %u", got.triangle);
    CHECK(same_bits(got.point, tip, sizeof tip));
  }
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* What is removed or hidden is not there, at once with the commit; what comes back is. */
static void what_is_gone_is_not_near(void) {
  facets list = {NULL, 0, 0};
  tally t = {0, 0, 0, 0};
  rng r = rng_of(4);
  zoo z = zoo_make(0);
  pktrt_scene *s = zoo_scene(&z, PKTRT_ISA_AUTO, PKTRT_BUILD_DEFAULT);
  for (uint32_t step = 0; step < 5; step++) {
    static const uint32_t without[5] = {0, 1 << 0, 1 << 0 | 1 << 3 | 1 << 7, 1 << 3 | 1 << 9, 1 << 3 | 1 << 9};
    if (step == 1) CHECK(pktrt_set_enabled(s, 0, false) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK);
    if (step == 2)
      CHECK(pktrt_remove_mesh(s, 3) == PKTRT_OK && pktrt_set_enabled(s, 7, false) == PKTRT_OK &&
            pktrt_commit(s) == PKTRT_OK);
    if (step == 3)
      CHECK(pktrt_remove_instance(s, 2) == PKTRT_OK && pktrt_set_enabled(s, 0, true) == PKTRT_OK &&
            pktrt_set_enabled(s, 7, true) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
    if (step == 4) CHECK(pktrt_remove_mesh(s, 0) == PKTRT_OK); /* not committed */
    zoo_facets(&z, 0.6f, without[step], &list);
    for (uint32_t i = 0; i < scaled(QUERIES) + 20; i++) {
      const pktrt_point_query q = query_of(&r, &list, i, 0.6f);
      pktrt_closest got;
      pktrt_closest_point_n(s, &q, &got, 1);
      compare(&list, &q, &got, 1e6L, &t);
    }
  }
  CHECK(!t.wrong, "%zu of %zu", t.wrong, t.asked);
  pktrt_scene_destroy(s), zoo_free(&z);
  free(list.f);
}

/* A triangle that has area only later, one that has none, and none at all. */
static void what_has_no_area_is_not_there(void) {
  static const float p[36] = {
      0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 0, 5, 1, 0, 5, 0, 1, 5, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 5, 1, 0, 5, 0, 1, 5};
  const float at[3] = {0.25f, 0.25f, 1};
  pktrt_closest got;
  mesh m = mesh_of(6, 2);
  world w = world_of(m);
  mesh_move(&w.m[0], 2, 0, 0, 1);
  memcpy(w.m[0].p, p, sizeof p);
  for (uint32_t i = 0; i < 6; i++) w.m[0].i[i] = i;
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  pktrt_point_query q = {{0.25f, 0.25f, 1}, INFINITY, 0, 0};
  pktrt_closest_point_n(s, &q, &got, 1);
  CHECK(got.triangle == 1 && got.distance == 4 && got.normal[2] == 1, "triangle %u, %g away", got.triangle,
      (double)got.distance);
  q.time = 1;
  pktrt_closest_point_n(s, &q, &got, 1);
  CHECK(got.triangle == 0 && got.distance == 1, "triangle %u, %g away", got.triangle, (double)got.distance);
  pktrt_scene_destroy(s);
  w.m[0].keys = 1, w.m[0].nt = 1;
  s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  CHECK(!pktrt_closest_point(s, at, INFINITY, &got) && got.mesh == PKTRT_NONE && got.distance == INFINITY);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* What is no point, no distance or no scene; and distances that end just there. */
static void hostile_queries(void) {
  static const float odd[7] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 1.3e30f, -2e30f};
  static const float none[4] = {NAN, -1, -INFINITY, -FLT_MIN};
  const float at[3] = {0, 3, 0};
  pktrt_closest got, wanted;
  memset(&wanted, 0, sizeof wanted);
  wanted.distance = INFINITY, wanted.mesh = wanted.triangle = PKTRT_NONE;
  world w = world_of(mesh_box());
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  for (uint32_t i = 0; i < 3 * COUNT(odd); i++) {
    float p[3] = {0, 0, 0};
    p[i % 3] = odd[i / 3];
    CHECK(!pktrt_closest_point(s, p, INFINITY, &got) && same_bits(&got, &wanted, sizeof got), "%g", (double)odd[i / 3]);
  }
  for (uint32_t i = 0; i < COUNT(none); i++)
    CHECK(!pktrt_closest_point(s, at, none[i], &got) && same_bits(&got, &wanted, sizeof got), "%g", (double)none[i]);
  CHECK(pktrt_closest_point(s, at, 2, &got) && got.distance == 2, "what is at the limit counts");
  CHECK(!pktrt_closest_point(s, at, nextafterf(2, 0), &got));
  CHECK(pktrt_closest_point(s, at, FLT_MAX, &got) && got.distance == 2);
  CHECK(!pktrt_closest_point(s, at, 0, &got));
  CHECK(pktrt_closest_point(s, (const float[3]){0.5f, 1, 0}, 0, &got) && got.distance == 0, "the point itself");
  for (int i = -149; i < 100; i++) { /* the least and the largest ways there are */
    const float far[3] = {ldexpf(1, i), 0, 0};
    const float want = fabsf(1 - far[0]);
    CHECK(pktrt_closest_point(s, far, INFINITY, &got) && got.distance == want, "2^%d: %g", i, (double)got.distance);
  }
  pktrt_closest_point_n(s, NULL, NULL, 0);
  pktrt_scene_destroy(s);
  const pktrt_scene_desc sd = scene_desc_of(PKTRT_ISA_AUTO, 0);
  s = pktrt_scene_create(&sd);
  CHECK(!pktrt_closest_point(s, at, INFINITY, &got) && same_bits(&got, &wanted, sizeof got), "not committed");
  CHECK(mesh_add(s, &w.m[0], NULL) == PKTRT_OK);
  CHECK(!pktrt_closest_point(s, at, INFINITY, &got) && same_bits(&got, &wanted, sizeof got), "not committed, a mesh");
  CHECK(pktrt_commit(s) == PKTRT_OK && pktrt_closest_point(s, at, INFINITY, &got));
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* A ball's, as a mesh and as an instance of any sign, of which a ball of triangles is within 0.003. */
static void signed_distances_of_a_ball(void) {
  rng r = rng_of(2);
  size_t wrong = 0, inside = 0;
  mesh ball = mesh_sphere(5, 0, 1);
  const pktrt_mesh_desc d = mesh_desc(&ball);
  const pktrt_scene_desc sd = scene_desc_of(PKTRT_ISA_AUTO, 0);
  for (int kind = 0; kind < 3; kind++) {
    const float matrix[12] = {kind == 1 ? 2.0f : -2.0f, 0, 0, 1, 0, 0, 2, 0, 0, -2, 0, 0};
    const pktrt_instance_desc in = {0, 1, matrix, 0, PKTRT_INTERPOLATION_LINEAR};
    const float size = kind ? 2 : 1, middle = kind ? 1 : 0;
    pktrt_scene *s = pktrt_scene_create(&sd);
    CHECK(kind ? pktrt_add_model(s, &d, 1, NULL) == PKTRT_OK && pktrt_add_instance(s, &in, NULL) == PKTRT_OK
               : pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
    CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
    for (size_t i = 0; i < scaled(2000) + 50; i++) {
      float p[3];
      pktrt_closest got;
      for (int a = 0; a < 3; a++) p[a] = size * 1.5f * rng_sign(&r);
      const float want = sqrtf(dot3(p, p)) - size;
      p[0] += middle;
      wrong += !pktrt_closest_point(s, p, INFINITY, &got);
      const bool within = pktrt_winding(s, got.mesh, p, 0) != 0;
      inside += within;
      wrong += !(fabsf((within ? -got.distance : got.distance) - want) < 0.003f * size);
    }
    pktrt_scene_destroy(s);
  }
  CHECK(!wrong && inside > 20, "%zu wrong, %zu inside", wrong, inside);
  mesh_free(&ball);
}

void suite_closest(void) {
  run("the closest point is that of all triangles, also of instances, at any time and mask", against_all_triangles);
  run("it errs by no more than is said, at any scale, of needles too", at_any_scale);
  run("it is found where its instance rounds points by more than they are away", far_in_its_model);
  run("it has the same bits by any call, set and tree", the_same_bits);
  run("of points that are equally near the first triangle has it", ties_go_to_the_first);
  run("so it is where edges are rounded", ties_at_a_tip);
  run("what is removed or hidden is nowhere near", what_is_gone_is_not_near);
  run("what has no area at the time is not there", what_has_no_area_is_not_there);
  run("what is no point or no distance has no closest point; one at the limit counts", hostile_queries);
  run("with winding numbers it is a signed distance", signed_distances_of_a_ball);
}
