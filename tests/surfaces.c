/* What one shades with: points, normals and texture coordinates of hits against references in higher precision; rays that
   leave points of triangles; textures that look at texture coordinates, and cutouts against what is really cut. */
#include "pictures.h"
#include "placed.h"
#include "ways.h"

/* --- meshes with normals and texture coordinates, added directly and placed by instances --- */

enum { SOURCES = 4, PLACES = 6, KEYS = 2 };
typedef struct dressed {
  world w;
  mesh normals[SOURCES]; /* as positions */
  float *texcoords[SOURCES];
  float transform[PLACES][KEYS * 12];
  pktrt_scene *s; /* meshes 0 to 3 are those of the world, 4 to 7 those of instance 0, and so on */
} dressed;
static uint32_t keys_of(uint32_t instance) { return 1 + instance % KEYS; }

static pktrt_mesh_desc dressed_desc(const dressed *x, uint32_t k) {
  pktrt_mesh_desc d = mesh_desc(&x->w.m[k]);
  d.normals = k == 2 ? NULL : x->normals[k].p, d.texcoords = k == 3 ? NULL : x->texcoords[k];
  d.material = 10 + k;
  return d;
}
static void dress(dressed *x) {
  rng r = rng_of(3);
  for (uint32_t k = 0; k < SOURCES; k++) {
    const mesh *m = &x->w.m[k];
    mesh *n = &x->normals[k];
    *n = mesh_of(m->nv * m->keys, m->nt);
    memcpy(n->i, m->i, (size_t)m->nt * 3 * sizeof *m->i);
    for (uint32_t v = 0; v < n->nv; v++) {
      vec up = vec_of(0.3 * (double)rng_sign(&r), 0.3 * (double)rng_sign(&r), 1 + 0.3 * (double)rng_sign(&r));
      vec_put(vec_unit(up), n->p + 3 * (size_t)v);
    }
    n->nv = m->nv, n->keys = m->keys;
    x->texcoords[k] = malloc((size_t)m->nv * 2 * sizeof(float));
    if (!x->texcoords[k]) abort();
    for (size_t i = 0; i < (size_t)m->nv * 2; i++) x->texcoords[k][i] = k == 1 ? 1e20f * rng_sign(&r) : rng_unit(&r);
  }
}
/* Turned, sheared and scaled unevenly; every third mirrored; those of two keys move. */
static void place_randomly(dressed *x) {
  rng r = {mix64(4)}; /* whatever the seed: others may flatten */
  for (uint32_t k = 0; k < PLACES; k++)
    for (int i = 0; i < 24; i++) {
      float *t = x->transform[k] + i;
      *t = i % 4 == 3 ? 2 * rng_sign(&r) : 0.25f * rng_sign(&r);
      if (i % 12 % 5 == 0) *t += k % 3 == 1 && i % 12 == 0 ? -0.9f : 0.3f + 0.5f * (float)(i % 3);
      if (i >= 12) *t = x->transform[k][i - 12] + 0.1f * rng_sign(&r);
    }
}
static void dressed_open(dressed *x, bool moving) {
  pktrt_mesh_desc d[SOURCES];
  memset(x, 0, sizeof *x);
  x->w = moving ? world_moving(2) : world_static(2);
  dress(x), place_randomly(x);
  x->s = stage_open();
  for (uint32_t k = 0; k < SOURCES; k++) {
    d[k] = dressed_desc(x, k);
    CHECK(pktrt_add_mesh(x->s, &d[k], NULL) == PKTRT_OK, "%s", pktrt_last_error(x->s));
  }
  CHECK(pktrt_add_model(x->s, d, SOURCES, NULL) == PKTRT_OK, "%s", pktrt_last_error(x->s));
  for (uint32_t i = 0; i < PLACES; i++) {
    const pktrt_instance_desc at = {0, keys_of(i), x->transform[i], 0, PKTRT_INTERPOLATION_LINEAR};
    CHECK(pktrt_add_instance(x->s, &at, NULL) == PKTRT_OK, "%s", pktrt_last_error(x->s));
  }
  stage_commit(x->s);
}
static void dressed_close(dressed *x) {
  pktrt_scene_destroy(x->s);
  for (uint32_t k = 0; k < SOURCES; k++) mesh_free(&x->normals[k]), free(x->texcoords[k]);
  world_free(&x->w);
}

/* --- references, in long double where rounding counts --- */

static uint32_t instance_of(uint32_t index) { return index < SOURCES ? PKTRT_NONE : index / SOURCES - 1; }
static void matrix_of(const dressed *x, uint32_t index, float time, double m[12]) {
  const uint32_t i = instance_of(index);
  memset(m, 0, 12 * sizeof *m);
  m[0] = m[5] = m[10] = 1;
  if (i != PKTRT_NONE) (void)placed_at(x->transform[i], keys_of(i), time, m);
}
static void corners_of(const mesh *m, uint32_t triangle, float time, long double p[3][3]) {
  for (uint32_t c = 0; c < 3; c++) {
    float at[3];
    ref_vertex(m, m->i[3 * (size_t)triangle + c], time, at);
    for (int a = 0; a < 3; a++) p[c][a] = (long double)at[a];
  }
}
/* Moves a point to the scene; returns the largest coordinate that comes in on the way. */
static long double move_out(const double m[12], const long double in[3], long double largest, long double out[3]) {
  long double most = largest;
  for (int a = 0; a < 3; a++) {
    long double sum = fabsl((long double)m[4 * a + 3]);
    out[a] = (long double)m[4 * a + 3];
    for (int b = 0; b < 3; b++)
      out[a] += (long double)m[4 * a + b] * in[b], sum += fabsl((long double)m[4 * a + b]) * largest;
    most = fmaxl(most, sum);
  }
  return most;
}
static void cross_of_edges(long double p[3][3], long double n[3]) {
  for (int a = 0; a < 3; a++) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    n[a] = (p[1][b] - p[0][b]) * (p[2][c] - p[0][c]) - (p[1][c] - p[0][c]) * (p[2][b] - p[0][b]);
  }
}

/* Where the documented ray of a hit meets the triangle's plane, in the scene; returns the largest coordinate concerned. */
static long double point_of(const dressed *x, const pktrt_ray *ray, const pktrt_hit *hit, long double out[3]) {
  const uint32_t i = instance_of(hit->mesh);
  const pktrt_ray in = i == PKTRT_NONE ? *ray : ray_within(x->transform[i], keys_of(i), ray);
  long double p[3][3], n[3], at[3], up = 0, along = 0, largest = 0;
  double m[12];
  corners_of(&x->w.m[hit->mesh % SOURCES], hit->triangle, ray->time, p);
  cross_of_edges(p, n);
  for (int a = 0; a < 3; a++) {
    up += n[a] * (p[0][a] - (long double)in.origin[a]), along += n[a] * (long double)in.direction[a];
    for (int c = 0; c < 3; c++) largest = fmaxl(largest, fabsl(p[c][a]));
    largest = fmaxl(largest, fabsl((long double)in.origin[a]));
  }
  for (int a = 0; a < 3; a++) at[a] = (long double)in.origin[a] + up / along * (long double)in.direction[a];
  matrix_of(x, hit->mesh, ray->time, m);
  return move_out(m, at, largest, out);
}

/* The shading normal, but for its side. */
static vec shading_normal_of(const dressed *x, const pktrt_ray *ray, const pktrt_hit *hit, bool corner_only) {
  const mesh *n = &x->normals[hit->mesh % SOURCES];
  const double weight[3] = {1 - (double)hit->u - (double)hit->v, (double)hit->u, (double)hit->v};
  double m[12];
  vec sum = vec_of(0, 0, 0);
  matrix_of(x, hit->mesh, ray->time, m);
  const vec column[3] = {vec_of(m[0], m[4], m[8]), vec_of(m[1], m[5], m[9]), vec_of(m[2], m[6], m[10])};
  for (uint32_t c = 0; c < (corner_only ? 1 : 3); c++) {
    float at[3];
    ref_vertex(n, n->i[3 * (size_t)hit->triangle + c], ray->time, at);
    vec to = vec_mul(vec_cross(column[1], column[2]), (double)at[0]);
    to = vec_add(to, vec_mul(vec_cross(column[2], column[0]), (double)at[1]));
    to = vec_add(to, vec_mul(vec_cross(column[0], column[1]), (double)at[2]));
    sum = vec_add(sum, vec_mul(instance_of(hit->mesh) == PKTRT_NONE ? to : vec_unit(to), corner_only ? 1 : weight[c]));
  }
  return vec_unit(sum);
}

static void texcoord_of(const dressed *x, const pktrt_hit *hit, double out[2], double corner[2], double *largest) {
  const mesh *m = &x->w.m[hit->mesh % SOURCES];
  const double weight[3] = {1 - (double)hit->u - (double)hit->v, (double)hit->u, (double)hit->v};
  out[0] = out[1] = corner[0] = corner[1] = *largest = 0;
  for (uint32_t c = 0; c < 3 && hit->mesh % SOURCES != 3; c++)
    for (size_t i = 0; i < 2; i++) {
      const double t = (double)x->texcoords[hit->mesh % SOURCES][2 * (size_t)m->i[3 * (size_t)hit->triangle + c] + i];
      out[i] += weight[c] * t, *largest = fmax(*largest, fabs(t));
      if (c == 0) corner[i] = t;
    }
}

/* Returns -1 where an instance mirrors its model, else 1. */
static double side_of(const dressed *x, uint32_t index, float time) {
  double m[12];
  matrix_of(x, index, time, m);
  const vec column[3] = {vec_of(m[0], m[4], m[8]), vec_of(m[1], m[5], m[9]), vec_of(m[2], m[6], m[10])};
  return vec_dot(vec_cross(column[0], column[1]), column[2]) < 0 ? -1 : 1;
}

/* --- surfaces --- */

typedef struct errors {
  size_t hits, wrong, of_instances, inside, mirrored;
  double position, normal, shading, texcoord;                 /* the worst, relative */
  size_t position_control, shading_control, texcoord_control; /* a millionth beyond; of one corner */
} errors;

static double between(vec a, vec b) { return vec_length(vec_sub(a, b)); }
/* Of a hit: everything that pktrt_surface tells. */
static void look_at_surface(const dressed *x, const pktrt_ray *ray, const pktrt_hit *hit, errors *e) {
  pktrt_surface_info f;
  long double at[3];
  double texcoord[2], corner_texcoord[2], size;
  memset(&f, 0x77, sizeof f);
  pktrt_surface(x->s, ray, hit, &f);
  const long double largest = point_of(x, ray, hit, at);
  const vec n = vec_from(f.normal), ns = vec_from(f.shading_normal), d = vec_unit(vec_from(ray->direction));
  const double side = side_of(x, hit->mesh, ray->time);
  const vec outwards = vec_mul(vec_unit(vec_from(hit->normal)), side); /* as the model has it */
  const double away = vec_dot(outwards, d);
  for (int a = 0; a < 3; a++) {
    const long double beyond = 0x1p-20L * (long double)hit->t * (long double)ray->direction[a];
    e->position = fmax(e->position, (double)(fabsl(at[a] - (long double)f.position[a]) / largest));
    e->position_control += fabsl(at[a] + beyond - (long double)f.position[a]) > largest * 0x1p-22L;
  }
  e->normal = fmax(e->normal, between(n, vec_mul(outwards, f.inside ? -1 : 1)));
  e->wrong += vec_dot(n, d) > 1e-6 || vec_dot(n, ns) < 0 || (fabs(away) > 1e-6 && f.inside != (away > 0));
  if (hit->mesh % SOURCES == 2) {
    e->wrong += !same_bits(f.normal, f.shading_normal, sizeof f.normal);
  } else {
    vec want = shading_normal_of(x, ray, hit, false), corner = shading_normal_of(x, ray, hit, true);
    if (vec_dot(want, n) < 0) want = vec_mul(want, -1), corner = vec_mul(corner, -1);
    if (fabs(vec_dot(want, n)) > 1e-5) e->shading = fmax(e->shading, between(want, ns));
    e->shading_control += between(corner, ns) > 1e-5;
  }
  texcoord_of(x, hit, texcoord, corner_texcoord, &size);
  for (int i = 0; i < 2; i++) {
    const double off = fabs(texcoord[i] - (double)f.texcoord[i]);
    if (size > 0) e->texcoord = fmax(e->texcoord, off / size);
    else e->wrong += f.texcoord[i] != 0;
    e->texcoord_control += fabs(corner_texcoord[i] - (double)f.texcoord[i]) > 0x1p-21 * size;
  }
  e->wrong += f.material != 10 + hit->mesh % SOURCES || f.instance != instance_of(hit->mesh);
  e->hits++, e->of_instances += f.instance != PKTRT_NONE, e->inside += f.inside;
  e->mirrored += side < 0;
}

static void surfaces_are_what_was_hit(void) {
  enum { N = 3000 };
  static const ray_kind kinds[4] = {RAYS_CAMERA, RAYS_RANDOM, RAYS_EDGE, RAYS_VERTEX};
  static pktrt_ray rays[N];
  errors e;
  memset(&e, 0, sizeof e);
  for (int moving = 0; moving < 2; moving++) {
    dressed x;
    dressed_open(&x, moving);
    for (int k = 0; k < 4; k++) {
      const size_t n = small_run ? N / 10 : N;
      make_rays(&x.w, x.s, kinds[k], 5, 0, rays, n);
      for (size_t i = 0; i < n; i++) {
        pktrt_hit hit;
        if (pktrt_intersect(x.s, &rays[i], &hit)) look_at_surface(&x, &rays[i], &hit, &e);
      }
    }
    dressed_close(&x);
  }
  CHECK(e.wrong == 0, "%zu of %zu are wrong", e.wrong, e.hits);
  CHECK(e.position < 0x1p-22 && e.normal < 1e-6 && e.shading < 1e-5 && e.texcoord < 0x1p-21,
      "positions are off by %g, normals %g, shading normals %g, texcoords %g", e.position, e.normal, e.shading,
      e.texcoord);
  CHECK(e.hits > 1000 && e.of_instances > e.hits / 5 && e.inside > e.hits / 20 && e.mirrored > e.hits / 50,
      "%zu hits, %zu of instances, %zu mirrored, %zu inside", e.hits, e.of_instances, e.mirrored, e.inside);
  CHECK(e.position_control > e.hits / 4 && e.shading_control > e.hits / 4 && e.texcoord_control > e.hits / 4,
      "controls: %zu %zu %zu", e.position_control, e.shading_control, e.texcoord_control);
  say("%zu hits, %zu of instances: %zu wrong; positions within 2^%.1f of the largest coordinate, normals %.1e, shading "
      "normals %.1e, texcoords %.1e",
      e.hits, e.of_instances, e.wrong, log2(e.position), e.normal, e.shading, e.texcoord);
  say("controls: %zu coordinates of points a millionth of t beyond are farther off, %zu shading normals and %zu "
      "texcoords of a "
      "corner",
      e.position_control, e.shading_control, e.texcoord_control);
}

static bool is_nothing(const pktrt_surface_info *f) {
  pktrt_surface_info none;
  memset(&none, 0, sizeof none);
  none.instance = PKTRT_NONE;
  return same_bits(f, &none, sizeof none);
}
/* Of misses and of what is not there nothing is told; many at once are told as one by one. */
static void misses_and_many_at_once(void) {
  enum { N = 1000 };
  static pktrt_ray rays[N], spawned[2][N];
  static pktrt_hit hits[N];
  static pktrt_surface_info many[N];
  static float directions[3 * N];
  dressed x;
  size_t misses = 0, wrong = 0, hit = 0;
  rng r = rng_of(6);
  dressed_open(&x, true);
  make_rays(&x.w, x.s, RAYS_INVALID, 1, 0, rays, N);
  pktrt_intersect_n(x.s, rays, hits, N);
  hits[0].mesh = SOURCES * (PLACES + 1), hits[0].triangle = 0, hits[1].mesh = 2, hits[1].triangle = 12;
  for (int i = 0; i < 3 * N; i++) directions[i] = rng_sign(&r);
  pktrt_surface_n(x.s, rays, hits, many, N);
  pktrt_spawn_n(x.s, rays, hits, directions, spawned[1], N);
  for (size_t i = 0; i < N; i++) {
    pktrt_surface_info f;
    memset(&f, 0x77, sizeof f);
    pktrt_surface(x.s, &rays[i], &hits[i], &f),
        pktrt_spawn(x.s, &rays[i], &hits[i], directions + 3 * i, &spawned[0][i]);
    const bool none = i < 2 || hits[i].mesh == PKTRT_NONE;
    misses += none, hit += !none;
    wrong += !same_bits(&f, &many[i], sizeof f) || is_nothing(&f) != none;
  }
  CHECK(same_bits(spawned[0], spawned[1], sizeof spawned[0]), "many spawn as one by one");
  CHECK(wrong == 0 && misses > 100 && hit > 100, "%zu wrong of %zu misses and %zu hits", wrong, misses, hit);
  pktrt_surface_n(x.s, NULL, NULL, NULL, 0), pktrt_spawn_n(x.s, NULL, NULL, NULL, NULL, 0);
  pktrt_spawn_at_n(x.s, NULL, NULL, NULL, NULL, 0);
  dressed_close(&x);
}

/* Normals lie side by side, however far apart the vertices lie. */
static void normals_lie_side_by_side(void) {
  enum { FLOATS = 5 }; /* from vertex to vertex */
  mesh ball = mesh_sphere(2, 0.1f, 1);
  float *apart = malloc(sizeof(float) * FLOATS * ball.nv);
  if (!apart) abort();
  for (uint32_t v = 0; v < ball.nv; v++) memcpy(apart + FLOATS * (size_t)v, ball.p + 3 * (size_t)v, 12);
  for (uint32_t v = 0; v < ball.nv; v++) apart[FLOATS * v + 3] = apart[FLOATS * v + 4] = NAN;
  pktrt_scene *s[2];
  for (int i = 0; i < 2; i++) {
    pktrt_mesh_desc d = mesh_desc(&ball);
    d.normals = ball.p;
    if (i) d.positions = apart, d.position_stride = FLOATS * sizeof(float);
    const pktrt_scene_desc of = scene_desc_of(PKTRT_ISA_AUTO, 0);
    s[i] = pktrt_scene_create(&of);
    CHECK(pktrt_add_mesh(s[i], &d, NULL) == PKTRT_OK && pktrt_commit(s[i]) == PKTRT_OK, "%s", pktrt_last_error(s[i]));
  }
  size_t hits = 0, wrong = 0;
  for (uint32_t i = 0; i < 200; i++) {
    rng r = rng_of(i);
    const pktrt_ray x = ray_of(rng_sign(&r), rng_sign(&r), 3, 0.1f * rng_sign(&r), 0.1f * rng_sign(&r), -1);
    pktrt_hit h;
    if (!pktrt_intersect(s[0], &x, &h)) continue;
    pktrt_surface_info f[2];
    for (int k = 0; k < 2; k++) pktrt_surface(s[k], &x, &h, &f[k]);
    hits++, wrong += !same_bits(&f[0], &f[1], sizeof f[0]);
  }
  CHECK(hits > 50 && wrong == 0, "%zu of %zu surfaces differ", wrong, hits);
  pktrt_scene_destroy(s[0]), pktrt_scene_destroy(s[1]);
  free(apart);
  mesh_free(&ball);
}

/* What is deformed has the surfaces of a scene that was never other. */
static void surfaces_follow_what_has_changed(void) {
  dressed x;
  dressed_open(&x, false);
  mesh *m = &x.w.m[0];
  const pktrt_ray out = ray_of(0.1f, 0, 0.2f, 0.1f, 1, -0.2f); /* from within the sphere */
  pktrt_hit hit;
  errors e;
  memset(&e, 0, sizeof e);
  for (int i = 0; i < 3; i++) {
    if (i) mesh_scale(m, 1.3f), mesh_scale(&x.normals[0], 0.5f);
    for (uint32_t v = 0; v < m->nv && i; v++) x.normals[0].p[3 * v] += 0.4f;
    if (i) CHECK(!pktrt_set_positions(x.s, 0, 0, m->p) && !pktrt_set_normals(x.s, 0, 0, x.normals[0].p));
    if (i) CHECK((i > 1 ? pktrt_refit(x.s) : pktrt_commit(x.s)) == PKTRT_OK);
    CHECK(pktrt_set_transform(x.s, 0, 0, x.transform[1]) == PKTRT_OK); /* waits, and is not seen */
    bool more = pktrt_intersect(x.s, &out, &hit);
    while (more && hit.mesh != 0) more = pktrt_intersect_after(x.s, &out, &hit, &hit);
    if (CHECK(more)) look_at_surface(&x, &out, &hit, &e);
    CHECK(pktrt_set_transform(x.s, 0, 0, x.transform[0]) == PKTRT_OK);
  }
  CHECK(e.wrong == 0 && e.hits == 3 && e.position < 0x1p-22 && e.shading < 1e-5, "%zu wrong, positions %g, normals %g",
      e.wrong, e.position, e.shading);
  dressed_close(&x);
}

/* --- rays from points of triangles --- */

enum { DIRECTIONS = 14, POINTS = 7 };
static const float points[POINTS][2] = {{0.25f, 0.5f}, {0, 0}, {1, 0}, {0, 1}, {0.5f, 0.5f}, {0.3f, 0}, {-2, 5}};
typedef struct leaving {
  size_t rays, met, wrong_side, far_off, moved, apart,
      control; /* apart: from pktrt_spawn after a hit, as `compared` were */
  size_t compared, degenerate;
} leaving;

/* Random directions, along the edges and the normal, nearly in the plane, along an axis, very long and very short ones. */
static void direction_of(int k, long double p[3][3], rng *r, float d[3]) {
  long double n[3], length = 0, edge = 0;
  cross_of_edges(p, n);
  for (int a = 0; a < 3; a++) length = fmaxl(length, fabsl(n[a])), edge = fmaxl(edge, fabsl(p[1][a] - p[0][a]));
  for (int a = 0; a < 3; a++) {
    const long double e[2] = {p[1][a] - p[0][a], p[2][a] - p[0][a]}, up = length > 0 ? n[a] / length * edge : 0;
    switch (k) {
    case 0: d[a] = (float)e[0]; break;
    case 1: d[a] = (float)-e[1]; break;
    case 2: d[a] = (float)(e[0] - e[1]); break;
    case 3: d[a] = (float)(up / 2); break;
    case 4: d[a] = (float)(-up / 2); break;
    case 5: d[a] = (float)(e[0] + 1e-6L * up); break;
    case 6: d[a] = (float)(e[1] - 1e-7L * up); break;
    case 7: d[a] = a == 1; break;
    case 8: d[a] = -(float)(a == 0); break;
    case 9: d[a] = 1e-20f * rng_sign(r); break;
    case 10: d[a] = 1e20f * rng_sign(r); break;
    default: d[a] = rng_sign(r);
    }
  }
}

static bool meets(const pktrt_scene *s, const pktrt_ray *ray, uint32_t index, uint32_t triangle) {
  pktrt_hit hit;
  bool met = false;
  for (bool more = pktrt_intersect(s, ray, &hit); more && !met; more = pktrt_intersect_after(s, ray, &hit, &hit))
    met = hit.mesh == index && hit.triangle == triangle;
  return met;
}

/* Where the origin should be: beside that point on the side that the direction leads to, no farther than 2^-22 of it; near
   an edge, from which it moves away, no farther than 2^-22 of it from the plane, and not outside by more. What a needle's plane is doubles do not tell, nor is that of an instance quite what it is without. */
static void check_origin(
    long double p[3][3], const float uv[2], const pktrt_ray *out, long double largest, bool placed, leaving *l) {
  long double n[3], nn = 0, ee[2] = {0, 0}, up = 0, sum = 0, along = 0, size = 0, off = 0;
  cross_of_edges(p, n);
  for (int a = 0; a < 3; a++) {
    const long double d = (long double)out->direction[a], q = (long double)out->origin[a] - p[0][a];
    for (int i = 0; i < 2; i++) ee[i] += (p[i + 1][a] - p[0][a]) * (p[i + 1][a] - p[0][a]);
    nn += n[a] * n[a], up += n[a] * q, sum += fabsl(n[a] * q), along += n[a] * d, size += fabsl(n[a] * d);
    const long double at = (long double)uv[0] * (p[1][a] - p[0][a]) + (long double)uv[1] * (p[2][a] - p[0][a]);
    off = fmaxl(off, fabsl(q - at));
  }
  if (!(nn > 0x1p-40L * ee[0] * ee[1])) return;
  const long double allowed = 0x1p-22L * largest * (placed ? 4 : 1) + 1e-36L;
  long double least = INFINITY;
  for (int c = 0; c < 3; c++) {
    long double m = 0, edge = 0;
    for (int a = 0; a < 3; a++) {
      const int b = (a + 1) % 3, k = (a + 2) % 3, next = (c + 1) % 3;
      const long double eb = p[next][b] - p[c][b], ek = p[next][k] - p[c][k];
      edge += eb * eb;
      m += n[a] * (eb * ((long double)out->origin[k] - p[c][k]) - ek * ((long double)out->origin[b] - p[c][b]));
    }
    least = fminl(least, m / sqrtl(edge * nn));
  }
  const bool moved = least < 32 * allowed && least > -allowed;
  l->far_off += (moved ? fabsl(up) / sqrtl(nn) : off) > allowed;
  l->moved += moved && off > allowed;
  if (placed || fabsl(along) <= 1e-9L * size || fabsl(up) <= 1e-14L * sum) return; /* in the plane, or nearly */
  l->wrong_side += (up > 0) != (along > 0);
}

/* Rays from points of a triangle of a scene, whose corners at the time are given. */
static void leave_triangle(
    const pktrt_scene *s, const pktrt_hit *of, float time, long double p[3][3], bool placed, rng *r, leaving *l) {
  long double n[3], nn = 0;
  cross_of_edges(p, n);
  for (int a = 0; a < 3; a++) nn += fabsl(n[a]);
  for (int k = 0; k < DIRECTIONS; k++) {
    const float *uv = points[rng_below(r, POINTS)], random[2] = {0.9f * rng_unit(r), 0.1f * rng_unit(r)};
    float d[3];
    pktrt_ray out, plain;
    long double largest = 0;
    direction_of(k, p, r, d);
    if (k % 3 == 0) uv = random;
    pktrt_spawn_at(s, of->mesh, of->triangle, uv[0], uv[1], time, d, &out);
    if (!(fabsf(d[0]) + fabsf(d[1]) + fabsf(d[2]) > 0)) continue;
    l->degenerate += nn <= 0, l->rays++;
    l->met += meets(s, &out, of->mesh, of->triangle);
    plain = out;
    for (int a = 0; a < 3; a++) {
      const long double e0 = p[1][a] - p[0][a], e1 = p[2][a] - p[0][a];
      plain.origin[a] = (float)(p[0][a] + (long double)uv[0] * e0 + (long double)uv[1] * e1);
      largest =
          fmaxl(largest, fmaxl(fabsl(p[0][a]), 0) + fabsl((long double)uv[0] * e0) + fabsl((long double)uv[1] * e1));
    }
    l->control += meets(s, &plain, of->mesh, of->triangle);
    if (out.tmax > 0) check_origin(p, uv, &out, largest, placed, l);
    else l->wrong_side += nn > 0;
  }
}

static void check_leaving(const char *name, const leaving *l, size_t least) {
  CHECK(l->met == 0, "%s: %zu of %zu rays meet the triangle that they left", name, l->met, l->rays);
  CHECK(l->wrong_side == 0, "%s: %zu of %zu start on the wrong side, or not at all", name, l->wrong_side, l->rays);
  CHECK(l->far_off == 0, "%s: %zu of %zu start too far away", name, l->far_off, l->rays);
  CHECK(l->rays > least && l->control > l->rays / 50, "%s: %zu rays, control %zu", name, l->rays, l->control);
  say("%-28s %zu rays: %zu meet the triangle that they left, %zu on its wrong side, %zu too far off; control without "
      "offset: %zu meet it",
      name, l->rays, l->met, l->wrong_side, l->far_off, l->control);
}

static void rays_leave_points_of_dressed_meshes(void) {
  leaving direct, placed;
  memset(&direct, 0, sizeof direct), memset(&placed, 0, sizeof placed);
  rng r = rng_of(8);
  for (int moving = 0; moving < 2; moving++) {
    dressed x;
    dressed_open(&x, moving);
    for (size_t i = 0; i < scaled(3000); i++) {
      pktrt_hit of;
      long double p[3][3];
      double m[12];
      const float time = rng_range(&r, -0.2f, 1.2f);
      memset(&of, 0, sizeof of);
      of.mesh = rng_below(&r, SOURCES * (PLACES + 1));
      of.triangle = rng_below(&r, x.w.m[of.mesh % SOURCES].nt);
      corners_of(&x.w.m[of.mesh % SOURCES], of.triangle, time, p);
      matrix_of(&x, of.mesh, time, m);
      for (int c = 0; c < 3; c++) {
        const long double in[3] = {p[c][0], p[c][1], p[c][2]};
        (void)move_out(m, in, 0, p[c]);
      }
      const bool out = instance_of(of.mesh) != PKTRT_NONE;
      leave_triangle(x.s, &of, time, p, out, &r, out ? &placed : &direct);
    }
    dressed_close(&x);
  }
  check_leaving("meshes", &direct, scaled(8000)), check_leaving("instances", &placed, scaled(40000));
}

static void rays_leave_points_of_extreme_meshes(void) {
  static const float scales[4] = {1e-30f, 1e-8f, 1, 1e28f};
  static const char *const names[6] = {
      "needles, 1e-30", "needles, 1e-8", "needles", "needles, 1e28", "far off", "huge beside tiny"};
  for (int k = 0; k < 6; k++) {
    leaving l;
    memset(&l, 0, sizeof l);
    rng r = rng_of(9);
    world w = world_of(k < 4 ? mesh_thin(300, 7) : mesh_soup(300, k == 4 ? 1e-3f : 1, 8));
    if (k < 4) mesh_scale(&w.m[0], scales[k]);
    if (k == 4) mesh_shift(&w.m[0], 1e4f, -3e3f, 17);
    for (size_t i = 0; i < (size_t)w.m[0].nv * 3 && k == 5; i++) w.m[0].p[i] *= i / 9 % 2 ? 1e-12f : 1e12f;
    w.m[0].i[3] = w.m[0].i[4]; /* triangle 1 has no area */
    pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
    for (uint32_t i = 0; i < (small_run ? 30 : 300); i++) {
      pktrt_hit of;
      long double p[3][3];
      memset(&of, 0, sizeof of);
      of.triangle = i;
      corners_of(&w.m[0], i, 0, p);
      leave_triangle(s, &of, 0, p, false, &r, &l);
    }
    CHECK(l.degenerate > 0);
    check_leaving(names[k], &l, 300);
    pktrt_scene_destroy(s);
    world_free(&w);
  }
}

/* From the point of a hit a ray starts where pktrt_spawn lets it start, as far as both know the point: u and v are known to
   2^-23, and each rounds to floats, off the plane, within 2^-22 of the point. */
static void leaving_a_hit_or_its_point_is_the_same(void) {
  enum { N = 4000 };
  static pktrt_ray rays[N], many[N], none[N];
  static pktrt_hit hits[N];
  static float times[N], directions[3 * N];
  size_t compared = 0, apart = 0, single = 0, bare = 0;
  double worst = 0;
  rng r = rng_of(10);
  dressed x;
  dressed_open(&x, true);
  make_rays(&x.w, x.s, RAYS_RANDOM, 8, 0, rays, N);
  pktrt_intersect_n(x.s, rays, hits, N);
  for (int i = 0; i < N; i++) times[i] = rays[i].time;
  for (int i = 0; i < 3 * N; i++) directions[i] = rng_sign(&r);
  pktrt_spawn_at_n(x.s, hits, times, directions, many, N), pktrt_spawn_at_n(x.s, hits, NULL, directions, none, N);
  for (size_t i = 0; i < N; i++) {
    pktrt_ray one, at_0, out;
    long double p[3][3], size = 0, off = 0;
    pktrt_spawn_at(x.s, hits[i].mesh, hits[i].triangle, hits[i].u, hits[i].v, times[i], directions + 3 * i, &one);
    pktrt_spawn_at(x.s, hits[i].mesh, hits[i].triangle, hits[i].u, hits[i].v, 0, directions + 3 * i, &at_0);
    single += !same_bits(&one, &many[i], sizeof one) || !same_bits(&at_0, &none[i], sizeof one);
    if (hits[i].mesh == PKTRT_NONE) continue;
    pktrt_spawn(x.s, &rays[i], &hits[i], directions + 3 * i, &out);
    corners_of(&x.w.m[hits[i].mesh % SOURCES], hits[i].triangle, times[i], p);
    if (instance_of(hits[i].mesh) != PKTRT_NONE) continue; /* whose rays are rounded on their way in */
    for (int a = 0; a < 3; a++) {
      const long double point = (long double)one.origin[a], edges = fabsl(p[1][a] - p[0][a]) + fabsl(p[2][a] - p[0][a]);
      size = fmaxl(size, 0x1p-22L * edges + 0x1p-21L * fabsl(point));
      off = fmaxl(off, fabsl(point - (long double)out.origin[a]));
    }
    const float floats[3] = {rays[i].origin[0] + hits[i].t * rays[i].direction[0], 0, 0};
    bare += fabsl((long double)floats[0] - (long double)out.origin[0]) > 0;
    worst = fmax(worst, (double)(off / size)), apart += off > size * sqrtl(3), compared++;
    apart += !same_bits(one.direction, out.direction, sizeof out.direction) || out.time != one.time || one.tmin != 0 ||
             one.tmax != out.tmax;
  }
  CHECK(single == 0, "%zu of many are not as one by one", single);
  CHECK(apart == 0 && compared > N / 8 && bare > compared / 4, "%zu of %zu are apart, control %zu", apart, compared,
      bare);
  say("%zu origins, the farthest apart %.2f of what u and v allow; %zu are farther; control: origin + t direction is "
      "another in %zu",
      compared, worst, apart, bare);
  dressed_close(&x);
}

/* From what is not there, or has no area, or no number, nothing comes. */
static void nothing_leaves_what_is_not_there(void) {
  static const float odd[4] = {NAN, INFINITY, -INFINITY, 1e38f};
  const float up[3] = {0.1f, 1, 0.2f};
  world w = world_of(mesh_grid(2, 1));
  w.m[0].i[3] = w.m[0].i[4];
  for (uint32_t v = 0; v < w.m[0].nv; v++) w.m[0].p[3 * v + 1] = 0.1f * (float)(v % 3);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  pktrt_ray down = ray_of(0.2f, 5, 0.3f, 0, -1, 0);
  CHECK(pktrt_occluded(s, &down), "the control: there is something");
  for (int k = 0; k < 13; k++) {
    const uint32_t index = k == 0   ? 1
                           : k == 1 ? PKTRT_NONE
                                    : 0,
                   triangle = k == 2   ? 8
                              : k == 3 ? PKTRT_NONE
                              : k == 4 ? 1
                                       : 0;
    float d[3] = {up[0], up[1], up[2]}, u = k > 4 && k < 9 ? odd[k - 5] : 0.2f;
    pktrt_ray out;
    memset(&out, 0x77, sizeof out);
    if (k >= 9) d[k % 3] = odd[k % 3];
    if (k == 12) d[0] = d[1] = d[2] = 0;
    pktrt_spawn_at(s, index, triangle, u, 0.3f, 0.5f, d, &out);
    pktrt_hit hit;
    CHECK(!pktrt_intersect(s, &out, &hit) && !pktrt_occluded(s, &out), "case %d hits", k);
    CHECK(k > 4 || (out.tmax == 0 && out.time == 0.5f), "case %d: tmax %g", k, (double)out.tmax);
  }
  pktrt_ray out, to;
  pktrt_spawn_at(s, 0, 0, 0.2f, 0.3f, 0, (const float[3]){0, 1, 0}, &out);
  for (int a = 0; a < 3; a++) to.origin[a] = out.origin[a] + (a == 1), to.direction[a] = -(float)(a == 1);
  to.tmin = 0, to.tmax = INFINITY, to.time = 0;
  CHECK(out.tmax == INFINITY && pktrt_occluded(s, &to), "the control: rays leave what is there");
  pktrt_scene_destroy(s);
  world_free(&w);
  s = stage_open();
  pktrt_spawn_at(s, 0, 0, 0, 0, 0, up, &out);
  CHECK(out.tmax == 0, "nor an empty scene");
  pktrt_scene_destroy(s);
}

/* --- textures that look at texture coordinates --- */

enum { W = 48, H = 36, FLOATS = W * H * 3 };

typedef struct checker { /* the mesh that a texture interpolates by itself; NULL: it looks at texcoord */
  const mesh *m;
  const float *texcoords;
  bool swapped;
  size_t points, wrong; /* texcoords that are not what barycentrics say */
} checker;
static void draw_checkers(void *user, const pktrt_points *p) {
  checker *c = user;
  for (uint32_t i = 0; i < p->n; i++) {
    const float u = p->barycentric[0][i], v = p->barycentric[1][i], weight[3] = {1 - u - v, u, v};
    float at[2] = {p->texcoord[0][i], p->texcoord[1][i]}, own[2] = {0, 0};
    for (uint32_t k = 0; k < 3 && p->mesh[i] != 1; k++) /* mesh 1 has none */
      for (size_t a = 0; a < 2; a++)
        own[a] += weight[k] * c->texcoords[2 * (size_t)c->m->i[3 * (size_t)p->triangle[i] + k] + a];
    c->wrong += fabsf(at[0] - own[0]) + fabsf(at[1] - own[1]) > 1e-5f, c->points++;
    if (c->swapped) at[0] = own[1], at[1] = -own[0];
    const int field = (int)floorf(6 * at[0]) + (int)floorf(6 * at[1]);
    for (int a = 0; a < 3; a++) p->albedo[a][i] = field & 1 ? 0.2f : 0.3f * (float)(a + 1);
  }
}
/* A sphere, another without texture coordinates, and an instance of the first, all with one texture. */
static void checkered_picture(checker *c, int mode, float *pixels) {
  pktrt_scene *s = stage_open();
  pktrt_material look = material_of(0.5, mode == 1 ? PKTRT_SPECULAR_COAT : PKTRT_SPECULAR_NONE, 0);
  look.texture = draw_checkers, look.user = c;
  mesh beside = mesh_sphere(2, 0, 1);
  mesh_shift(&beside, -1.5f, 0.5f, -1);
  pktrt_mesh_desc d = mesh_desc(c->m), none = mesh_desc(&beside);
  d.material = none.material = stage_material(s, &look), d.texcoords = c->texcoords;
  static const float aside[12] = {0.6f, 0.2f, 0, 1.6f, 0, -0.7f, 0, 0.3f, 0.1f, 0, 0.5f, 0.4f};
  const pktrt_instance_desc at = {0, 1, aside, 0, PKTRT_INTERPOLATION_LINEAR};
  CHECK(!pktrt_add_mesh(s, &d, NULL) && !pktrt_add_mesh(s, &none, NULL) && !pktrt_add_model(s, &d, 1, NULL) &&
            !pktrt_add_instance(s, &at, NULL),
      "%s", pktrt_last_error(s));
  pktrt_light point = light_of(PKTRT_LIGHT_POINT, 60);
  point.position[0] = 3, point.position[1] = 5, point.position[2] = 4;
  stage_light(s, &point), stage_commit(s);
  pktrt_render_desc view = stage_view((pktrt_mode)mode, W, H, pixels, vec_of(0.5, 1, 4.5), vec_of(0, 0.2, 0));
  view.samples = 4;
  stage_render(s, &view);
  pktrt_scene_destroy(s);
  mesh_free(&beside);
}
static void textures_get_texcoords(void) {
  static float want[FLOATS], got[FLOATS], other[FLOATS];
  mesh ball = mesh_sphere(3, 0.05f, 1);
  float *texcoords = malloc((size_t)ball.nv * 2 * sizeof *texcoords);
  if (!texcoords) abort();
  for (uint32_t v = 0; v < ball.nv; v++)
    texcoords[2 * v] = 0.3f * ball.p[3 * v] + ball.p[3 * v + 1], texcoords[2 * v + 1] = ball.p[3 * v + 2];
  checker c = {&ball, texcoords, false, 0, 0};
  for (int mode = 0; mode < 3; mode++) {
    checker own = c, swapped = c;
    checkered_picture(&c, mode, got);
    own.swapped = swapped.swapped = true;
    float *turned = malloc((size_t)ball.nv * 2 * sizeof *turned); /* so that swapped they are what they were */
    if (!turned) abort();
    for (uint32_t v = 0; v < ball.nv; v++) turned[2 * v] = -texcoords[2 * v + 1], turned[2 * v + 1] = texcoords[2 * v];
    own.texcoords = turned;
    checkered_picture(&own, mode, want), checkered_picture(&swapped, mode, other);
    CHECK(same_bits(want, got, sizeof got), "mode %d: drawn by texcoord, it is another picture", mode);
    CHECK(!same_bits(other, got, sizeof got), "mode %d: the control: swapped, it is another one", mode);
    free(turned);
  }
  CHECK(c.wrong == 0 && c.points > 2000, "%zu of %zu points have other texcoords", c.wrong, c.points);
  say("%zu points in three modes, %zu with other texcoords than barycentrics say", c.points, c.wrong);
  free(texcoords), mesh_free(&ball);
}

/* --- cutouts --- */

enum { CUT, REALLY_CUT, WHOLE, CUTS };
typedef struct fence_look {
  uint32_t stride;   /* triangles of the mesh for each that is there */
  float there, gone; /* opacities */
} fence_look;
static void draw_fence(void *user, const pktrt_points *p) {
  const fence_look *f = user;
  for (uint32_t i = 0; i < p->n; i++) {
    const uint32_t k = p->triangle[i] / f->stride;
    for (uint32_t a = 0; a < 3; a++) p->albedo[a][i] = 0.2f + 0.15f * (float)((k >> a) % 4);
    p->opacity[i] = p->triangle[i] % f->stride ? f->gone : f->there;
  }
}

/* A mesh of which every other triangle is there: by its texture, or because there are no others. */
static mesh fence_of(int cut, uint32_t n) {
  mesh m = mesh_grid(n, 1.2f);
  for (uint32_t v = 0; v < m.nv; v++) {
    float *p = m.p + 3 * (size_t)v;
    p[1] = p[2], p[2] = 0.1f * p[0] * p[1];
  }
  if (cut != REALLY_CUT) return m;
  m.nt /= 2;
  for (uint32_t t = 1; t < m.nt; t++) memcpy(m.i + 3 * (size_t)t, m.i + 6 * (size_t)t, 3 * sizeof *m.i);
  return m;
}
static void add_fence(pktrt_scene *s, int cut, uint32_t material, float z, uint32_t keys, bool placed) {
  static const float aside[12] = {-0.5f, 0.2f, 0, -1.3f, 0.1f, 0.6f, 0, 0.5f, 0.2f, 0, 0.5f, 0.9f};
  const pktrt_instance_desc at = {0, 1, aside, 0, PKTRT_INTERPOLATION_LINEAR};
  mesh m = fence_of(cut, 9);
  mesh_shift(&m, 0, 0, z);
  if (keys > 1) mesh_move(&m, keys, 0.15f, 0, 1);
  pktrt_mesh_desc d = mesh_desc(&m);
  d.material = material;
  CHECK(!(placed ? pktrt_add_model(s, &d, 1, NULL) || pktrt_add_instance(s, &at, NULL) : pktrt_add_mesh(s, &d, NULL)),
      "%s", pktrt_last_error(s));
  mesh_free(&m);
}

typedef struct fences {
  pktrt_isa isa;
  int cut;
  pktrt_specular specular; /* of the first one */
} fences;
/* Two fences one behind the other, the second of them moving, a third one as an instance, a floor, a mirror and glass. */
static pktrt_scene *fence_scene(const fences *f, fence_look *look) {
  const pktrt_scene_desc sd = scene_desc_of(f->isa, 0);
  pktrt_scene *s = pktrt_scene_create(&sd);
  const pktrt_material mirror = material_of(0.1, PKTRT_SPECULAR_MIRROR, 0.8),
                       glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  *look = (fence_look){f->cut == REALLY_CUT ? 1 : 2, 0.5f, f->cut == WHOLE ? 1 : 0.49f};
  pktrt_material first = material_of(0.5, f->specular, 0.4), second = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
  first.texture = second.texture = draw_fence, first.user = second.user = look;
  first.cutout = second.cutout = f->cut != REALLY_CUT;
  const uint32_t looks[2] = {stage_material(s, &first), stage_material(s, &second)};
  mesh floor = mesh_grid(4, 6), ball = mesh_sphere(2, 0, 1), drop = mesh_sphere(2, 0, 1);
  mesh_shift(&floor, 0, -1.3f, 0);
  mesh_scale(&ball, 0.8f), mesh_shift(&ball, 0.4f, -0.2f, -2);
  mesh_scale(&drop, 0.5f), mesh_shift(&drop, 1.5f, -0.5f, 0.6f);
  stage_mesh(s, &floor, 0), stage_mesh(s, &ball, stage_material(s, &mirror));
  add_fence(s, f->cut, looks[0], 0, 1, false), add_fence(s, f->cut, looks[1], -0.5f, 2, false);
  stage_mesh(s, &drop, stage_material(s, &glass)), add_fence(s, f->cut, looks[1], 0.2f, 1, true);
  pktrt_light point = light_of(PKTRT_LIGHT_POINT, 50), square = light_of(PKTRT_LIGHT_QUAD, 3);
  point.position[0] = 2, point.position[1] = 3, point.position[2] = 5;
  square.position[0] = -2, square.position[1] = 3, square.position[2] = -3;
  square.edge[0][0] = square.edge[1][2] = 1;
  stage_light(s, &point), stage_light(s, &square), stage_commit(s);
  mesh_free(&floor), mesh_free(&ball), mesh_free(&drop);
  return s;
}

enum { LOOKS = 3, SHADOWS = 2, VIEWS = 3 * SHADOWS };
typedef struct picture {
  float pixels[FLOATS], depth[W * H], normal[FLOATS], albedo[FLOATS];
} picture;
/* One of VIEWS; `variant` chooses among settings that change no pixel. */
static void fence_picture(pktrt_scene *s, int view, uint32_t variant, picture *out) {
  static const uint32_t packets[4] = {0, 2, 4, 16};
  static pktrt_stats stats;
  pktrt_render_desc d =
      stage_view((pktrt_mode)(view % 3), W, H, out->pixels, vec_of(0.4, 0.6, 4.2), vec_of(0, -0.1, -0.3));
  for (int a = 0; a < 3; a++) d.background[a] = 0.2f + 0.1f * (float)a, d.ambient[a] = 0.1f;
  d.samples = 2, d.max_depth = 5, d.camera.time = 0.2f, d.camera.shutter = 0.6f;
  d.glass_shadows = view < 3 ? PKTRT_GLASS_SHADOWS_PASS : PKTRT_GLASS_SHADOWS_BLOCK;
  d.depth = out->depth, d.normal = out->normal, d.albedo = out->albedo;
  d.path = (pktrt_path)(variant % 3), d.packet_size = packets[variant % 4];
  d.assembly = (pktrt_assembly)(variant % 6), d.shadows = (pktrt_shadow_packets)(variant / 2 % 2);
  if (variant % 5 == 4) d.stats = &stats;
  stage_render(s, &d);
}
static void cutouts_are_as_if_really_cut(void) {
  static const pktrt_specular looks[LOOKS] = {PKTRT_SPECULAR_NONE, PKTRT_SPECULAR_MIRROR, PKTRT_SPECULAR_DIELECTRIC};
  static picture want[VIEWS], got;
  size_t pictures = 0, wrong = 0, control = 0, odd = 0;
  for (int look = 0; look < LOOKS; look++) {
    fence_look f;
    fences x = {PKTRT_ISA_AUTO, REALLY_CUT, looks[look]};
    pktrt_scene *really = fence_scene(&x, &f);
    for (int v = 0; v < VIEWS; v++) fence_picture(really, v, 0, &want[v]);
    pktrt_scene_destroy(really);
    x.cut = WHOLE;
    pktrt_scene *whole = fence_scene(&x, &f);
    for (int v = 0; v < VIEWS; v++) {
      fence_picture(whole, v, 0, &got);
      control += !same_bits(&got.pixels, &want[v].pixels, sizeof got.pixels);
    }
    pktrt_scene_destroy(whole);
    for (int k = 0; k < isa_count; k++) {
      x.isa = isas[k], x.cut = CUT;
      pktrt_scene *s = fence_scene(&x, &f);
      for (int v = 0; v < VIEWS; v++, pictures++) {
        fence_picture(s, v, (uint32_t)(7 * k + 3 * look + 5 * v), &got);
        wrong += !CHECK(same_bits(&got, &want[v], sizeof got),
            "look %d, view %d, %s: cut by its texture it is another picture", look, v, pktrt_isa_string(isas[k]));
      }
      for (int i = 0; i < 20; i++) {
        const pktrt_ray ray = ray_of(0.1f * (float)i - 1.03f, 0.2f, 3, 0, 0, -1);
        pktrt_hit hit;
        for (bool more = pktrt_intersect(s, &ray, &hit); more; more = pktrt_intersect_after(s, &ray, &hit, &hit))
          odd += hit.mesh == 2 && hit.triangle % 2;
      }
      pktrt_scene_destroy(s);
    }
  }
  CHECK(wrong == 0 && control == LOOKS * VIEWS, "%zu of %zu differ, control %zu", wrong, pictures, control);
  CHECK(odd >= (size_t)(LOOKS * isa_count), "queries see all of a mesh: %zu", odd);
  say("%zu pictures, %zu differ from those of what is really cut; control, opaque: %zu of %d", pictures, wrong, control,
      LOOKS * VIEWS);
}

/* --- refusals --- */

static void mistakes_are_refused_by_name(void) {
  const pktrt_status no = PKTRT_INVALID_ARGUMENT;
  static const float odd[3] = {NAN, INFINITY, -INFINITY};
  mesh m = mesh_box();
  float texcoords[16];
  pktrt_scene *s = stage_open();
  pktrt_mesh_desc d = mesh_desc(&m);
  pktrt_material look = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
  d.texcoords = texcoords;
  for (int k = 0; k < 3; k++) {
    for (int i = 0; i < 16; i++) texcoords[i] = (float)i * (k ? 1e37f : 1);
    texcoords[5 + 4 * k] = odd[k];
    const char *const words[3] = {"mesh 0, texcoord 2: v is", "mesh 0, texcoord 4: v is", "mesh 0, texcoord 6: v is"};
    says(s, pktrt_add_mesh(s, &d, NULL), no, words[k]);
    texcoords[5 + 4 * k] = 0, texcoords[8] = odd[k];
    says(s, pktrt_add_mesh(s, &d, NULL), no, "mesh 0, texcoord 4: u is");
    says(s, pktrt_add_model(s, &d, 1, NULL), no, "texcoord 4: u is");
    texcoords[8] = 0;
  }
  look.cutout = true;
  says(s, pktrt_add_material(s, &look, NULL), no, "material 1 is a cutout, but has no texture");
  look.texture = draw_fence;
  uint32_t material = 0, index = PKTRT_NONE;
  CHECK(pktrt_add_material(s, &look, &material) == PKTRT_OK && material == 1, "the control: %s", pktrt_last_error(s));
  CHECK(pktrt_add_mesh(s, &d, &index) == PKTRT_OK && index == 0, "the control: %s", pktrt_last_error(s));
  pktrt_scene_destroy(s);
  mesh_free(&m);
}

void suite_surfaces(void) {
  run("what pktrt_surface tells of a hit is as exact as it says", surfaces_are_what_was_hit);
  run("surfaces of misses are nothing, of many hits as one by one, and so are rays that leave them",
      misses_and_many_at_once);
  run("normals lie side by side, however far apart vertices lie", normals_lie_side_by_side);
  run("surfaces follow what has changed", surfaces_follow_what_has_changed);
  run("rays leave points of triangles, at rest, moving and placed, without meeting these",
      rays_leave_points_of_dressed_meshes);
  run("rays leave points of needles, of tiny and of huge triangles without meeting these",
      rays_leave_points_of_extreme_meshes);
  run("rays that leave a hit and its point start from the same place", leaving_a_hit_or_its_point_is_the_same);
  run("nothing leaves a triangle that is not there or has no area", nothing_leaves_what_is_not_there);
  run("textures get the texture coordinates that barycentrics say", textures_get_texcoords);
  run("a cutout's pictures have the bits of those of what is really cut", cutouts_are_as_if_really_cut);
  run("texture coordinates that are no numbers, and cutouts without texture, are refused by name",
      mistakes_are_refused_by_name);
}
