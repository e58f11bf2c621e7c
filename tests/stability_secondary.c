/* Rays that leave surfaces: they do not meet what they left, and pass no wall that is farther away than they are moved; and shadows
   where things touch are there, however large the floor is.

   How far that is, with e = 2^-24, m the largest coordinate of the mesh left and M the extent of the scene (what any vertex can be
   away from a ray's origin along an axis): u and v err by 2 e of the edges, so that the point that a ray leaves is within 8 e m of
   the true one along each axis, and along the normal it is moved by 2 sqrt(3) e m at most (>>spawn in pktrt.h); as much more as the
   first is the point that is compared with here off, which is that of u and v. Hits are exact; the far end of a shadow ray, whose
   direction is rounded, is off by sqrt(3) e M. So a surface that is more than 32 e m + 2 e M from the point left cannot be passed
   by error: leaks there are wrong, nearer ones are what floats cost. */
#include "pictures.h"
#include "stability.h"

enum { BATCH = 1024, SCALES = 6, OFFSETS = 4, KINDS = 4, CASES = KINDS * OFFSETS, VARIANTS = 4 };
typedef enum kind { CONVEX, LOOSE, GAPS, ROOMS } kind;
enum { LEFT, BODY, LEAKS, SHADOWS, WHATS };

static const char *const kind_names[KINDS] = {"convex", "loose triangles", "gaps and creases", "shadows in rooms"};
static const char *const whats[WHATS] = {"hits of the triangle left", "hits of the convex mesh left",
    "leaks beyond the offset of another surface", "false shadows beyond the offset"};
static const char *const controls[WHATS] = {"no offset", "no offset", "moved too far", "no offset"};
static const float offsets[OFFSETS] = {0, 1, 1e3f, 1e5f}; /* in sizes */
/* Powers of two keep multiples of 1/64 exact, up to 10^5 sizes away. */
static const float exact_scales[SCALES] = {0x1p-14f, 0x1p-7f, 1, 0x1p7f, 0x1p14f, 0x1p20f};
static const float scales[SCALES] = {1e-4f, 1e-2f, 1, 1e2f, 1e4f, 1e6f};

typedef struct tally {
  uint64_t rays[WHATS], found[WHATS];
} tally;

typedef struct secondary_run {
  tally of[CASES][8], control[CASES];
  uint64_t leaks[CASES];  /* nearer than that */
  double farthest[CASES]; /* of leaks, in offsets from another surface */
  pthread_mutex_t lock;
} secondary_run;

/* --- geometry in double --- */

static double dot(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

static void corners_of(const world *w, uint32_t mesh_, uint32_t triangle, float time, double p[3][3]) {
  const mesh *m = &w->m[mesh_];
  for (uint32_t c = 0; c < 3; c++) {
    float v[3];
    ref_vertex(m, m->i[3 * triangle + c], time, v);
    for (int k = 0; k < 3; k++) p[c][k] = (double)v[k];
  }
}

static void point_of(double p[3][3], double u, double v, double out[3]) {
  for (int k = 0; k < 3; k++) out[k] = p[0][k] + u * (p[1][k] - p[0][k]) + v * (p[2][k] - p[0][k]);
}

static void normal_of(double p[3][3], double n[3]) {
  double a[3], b[3];
  for (int k = 0; k < 3; k++) a[k] = p[1][k] - p[0][k], b[k] = p[2][k] - p[0][k];
  for (int k = 0; k < 3; k++) n[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static double to_segment(const double x[3], const double a[3], const double b[3]) {
  double d[3], e[3];
  for (int k = 0; k < 3; k++) d[k] = b[k] - a[k], e[k] = x[k] - a[k];
  const double l = dot(d, d), f = l > 0 ? fmin(1, fmax(0, dot(d, e) / l)) : 0;
  for (int k = 0; k < 3; k++) e[k] -= f * d[k];
  return sqrt(dot(e, e));
}

static double to_triangle(const double x[3], double p[3][3]) {
  double n[3], d[3];
  normal_of(p, n);
  bool above = dot(n, n) > 0;
  for (int c = 0; c < 3; c++) { /* above the triangle: on the inner side of each edge */
    double e[3], f[3];
    for (int k = 0; k < 3; k++) e[k] = p[(c + 1) % 3][k] - p[c][k], f[k] = x[k] - p[c][k];
    const double side[3] = {e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]};
    above &= dot(side, n) >= 0;
  }
  for (int k = 0; k < 3; k++) d[k] = x[k] - p[0][k];
  if (above) return fabs(dot(d, n)) / sqrt(dot(n, n));
  return fmin(to_segment(x, p[0], p[1]), fmin(to_segment(x, p[1], p[2]), to_segment(x, p[2], p[0])));
}

/* Of a triangle's plane: no farther than the triangle. */
static double to_plane(const double x[3], double p[3][3]) {
  double n[3], d[3];
  normal_of(p, n);
  for (int k = 0; k < 3; k++) d[k] = x[k] - p[0][k];
  return dot(n, n) > 0 ? fabs(dot(d, n)) / sqrt(dot(n, n)) : 0;
}

/* Exact for the multiples of 1/64 below: their differences have 8 bits, so products and sums fit into doubles. */
static bool same_plane(double p[3][3], double q[3][3]) {
  double n[3], d[3];
  bool same = true;
  normal_of(p, n);
  for (int c = 0; c < 3; c++) {
    for (int k = 0; k < 3; k++) d[k] = q[c][k] - p[0][k];
    same &= dot(n, d) == 0;
  }
  return same;
}

/* --- scenes --- */

static void to_lattice(mesh *m) {
  for (size_t k = 0; k < (size_t)m->keys * m->nv * 3; k++) m->p[k] = rintf(64 * m->p[k]) / 64;
}

/* Faces of a box stay plane and parallel while it moves: their vertices have a coordinate in common, at all times. */
static mesh moving_box(void) {
  mesh m = mesh_box();
  mesh_move(&m, 3, 0, 0, 0);
  for (uint32_t key = 1; key < 3; key++)
    for (uint32_t v = 0; v < m.nv; v++) {
      float *p = m.p + 3 * (key * m.nv + v);
      for (uint32_t k = 0; k < 3; k++) p[k] = p[k] * (float)(1 + (key + k) % 3) / 4 + (float)key * (float)(k + 1) / 16;
    }
  return m;
}

/* A flat tetrahedron, whose angles are sharp: who moves off one face comes through another. */
static mesh flat_tetrahedron(void) {
  static const float p[12] = {-1, 0, -1, 1, 0, -1, 0.125f, 0, 1, 0, 0.25f, -0.25f};
  static const uint32_t i[12] = {0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0};
  mesh m = mesh_of(4, 4);
  memcpy(m.p, p, sizeof p);
  memcpy(m.i, i, sizeof i);
  return m;
}

static mesh ball(void) { return mesh_sphere(1, 0, 1); }

static world convex_world(int variant) {
  static mesh (*const make[VARIANTS])(void) = {mesh_box, moving_box, flat_tetrahedron, ball};
  mesh m = make[variant]();
  to_lattice(&m);
  return world_of(m);
}

/* No vertex lies before the plane of a triangle. */
static bool is_convex(const world *w) {
  bool behind = true;
  for (uint32_t t = 0; t < w->m[0].nt; t++) {
    double p[3][3], n[3], d[3];
    corners_of(w, 0, t, 0, p);
    normal_of(p, n);
    for (uint32_t v = 0; v < w->m[0].nv; v++) {
      for (uint32_t k = 0; k < 3; k++) d[k] = (double)w->m[0].p[3 * v + k] - p[0][k];
      behind &= dot(n, d) <= 0;
    }
  }
  return behind;
}

static world loose_world(void) {
  world w = world_of(mesh_sphere(1, 0.1f, 1));
  w.m[1] = mesh_soup(40, 0.5f, 3), w.m[2] = mesh_thin(40, 4), w.n = 3;
  mesh_move(&w.m[1], 3, 0.2f, 0.2f, 2);
  return w;
}

/* Triangles of mesh 0 under those of mesh 1: apart by gaps of all widths, or folded along an edge. */
static world gaps_world(float offset) {
  const uint32_t pairs = 32;
  const float lift = 24 * 0x1p-24f * (1 + offset);
  world w = world_of(mesh_soup(pairs, 0, 1));
  w.m[1] = mesh_soup(pairs, 0, 1), w.n = 2;
  rng r = rng_of(5);
  for (uint32_t t = 0; t < pairs; t++) {
    const float gap = fminf(0.03f, lift * powf(10, rng_range(&r, -2, 4))), y = 2 * (float)t / (float)pairs - 1;
    for (uint32_t c = 0; c < 3; c++) {
      static const float corner[3][2] = {{-0.9f, -0.8f}, {0.9f, -0.7f}, {0.1f, 0.9f}};
      float *p = w.m[0].p + 9 * t + 3 * c, *q = w.m[1].p + 9 * t + 3 * c;
      p[0] = q[0] = corner[c][0] + 0.1f * rng_sign(&r), p[2] = q[2] = corner[c][1] + 0.1f * rng_sign(&r);
      p[1] = y + 0.01f * rng_sign(&r);
      q[1] = p[1] + (t % 2 && c < 2 ? 0 : gap * rng_range(&r, 0.5f, 1.5f));
    }
  }
  return w;
}

static world world_for(kind k, int scale, int offset, int variant) {
  const bool exact = k == CONVEX || k == ROOMS;
  world w = exact ? convex_world(variant) : k == LOOSE ? loose_world() : gaps_world(offsets[offset]);
  const float s = exact ? exact_scales[scale] : scales[scale], at = offsets[offset] * s;
  world_place(&w, s, at, -0.5f * at, 0.25f * at);
  CHECK(!exact || is_convex(&w), "mesh %d is convex", variant);
  return w;
}

/* --- a batch of rays that leave surfaces --- */

typedef struct point { /* of a surface, where a ray came in */
  pktrt_ray ray;
  pktrt_hit hit;
  double at[3], corner[3][3];
} point;

typedef struct leaving {
  point from[BATCH], to[BATCH]; /* to: of shadow rays */
  pktrt_ray ray[BATCH], plain[BATCH], moved[BATCH];
  pktrt_hit got[BATCH];
  bool inward[BATCH]; /* into a convex mesh */
  double away[BATCH]; /* from another surface; negative: not asked yet */
  size_t tries, n;    /* rays in, rays that leave */
} leaving;

typedef struct place {
  kind what;
  world w;
  float size, centre[3];
  double lift, beyond;           /* the offset; where leaks are errors */
  pktrt_scene *scene[8], *below; /* below: of gaps, mesh 0 alone */
  leaving *b;
} place;

/* A point of a random triangle, as often as not close to an edge. */
static void aim(const world *w, rng *r, float time, float out[3]) {
  const mesh *m = &w->m[rng_below(r, w->n)];
  const uint32_t t = rng_below(r, m->nt), c = rng_below(r, 3);
  const float x = rng_below(r, 2) ? rng_unit(r) : powf(10, rng_range(r, -8, 0)), y = rng_unit(r) * (1 - x);
  float p[3][3];
  for (uint32_t k = 0; k < 3; k++) ref_vertex(m, m->i[3 * t + (c + k) % 3], time, p[k]);
  for (int k = 0; k < 3; k++) out[k] = p[0][k] + x * (p[1][k] - p[0][k]) + y * (p[2][k] - p[0][k]);
}

static pktrt_ray incoming(const place *g, rng *r, float time) {
  float o[3], p[3];
  world below = g->w;
  if (g->below) below.n = 1;
  aim(&below, r, time, p);
  const float reach = g->what == ROOMS ? 0.05f : powf(10, rng_range(r, -2, 3));
  for (int k = 0; k < 3; k++) o[k] = (g->what == ROOMS ? g->centre[k] : p[k]) + g->size * reach * rng_sign(r);
  return ray_towards(o, p, time);
}

static void locate(const place *g, point *x) {
  corners_of(&g->w, x->hit.mesh, x->hit.triangle, x->ray.time, x->corner);
  point_of(x->corner, (double)x->hit.u, (double)x->hit.v, x->at);
}

/* Points where rays came in, of all times or one by one of the same as others. */
static void arrive(const place *g, rng *r, const point *same_time, point *out, size_t n) {
  pktrt_ray *rays = g->b->ray;
  pktrt_hit *hits = g->b->got;
  for (size_t j = 0; j < n; j++) rays[j] = incoming(g, r, same_time ? same_time[j].ray.time : rng_unit(r));
  pktrt_intersect_n(g->below ? g->below : g->scene[isa_count - 1], rays, hits, n);
  for (size_t j = 0; j < n; j++) {
    out[j].ray = rays[j], out[j].hit = hits[j];
    if (hits[j].mesh != PKTRT_NONE) locate(g, &out[j]);
  }
}

/* At random, along the surface, along an edge of it, or reflected. */
static void direction(const point *x, rng *r, float d[3]) {
  const uint32_t way = rng_below(r, 4), c = rng_below(r, 3);
  double n[3], along = 0, nn;
  for (int k = 0; k < 3; k++) n[k] = (double)x->hit.normal[k], d[k] = rng_sign(r);
  nn = dot(n, n);
  if (way == 2)
    for (int k = 0; k < 3; k++) d[k] = (float)(x->corner[(c + 1) % 3][k] - x->corner[c][k]);
  if (way == 3)
    for (int k = 0; k < 3; k++) d[k] = x->ray.direction[k];
  for (int k = 0; k < 3; k++) along += n[k] * (double)d[k];
  const double less = way == 1 ? 1 - pow(10, (double)rng_range(r, -8, -1)) : way == 3 ? 2 : 0;
  for (int k = 0; k < 3; k++) d[k] -= (float)(less * along / nn * n[k]);
}

static double along_normal(const point *x, const float d[3]) {
  double along = 0;
  for (int k = 0; k < 3; k++) along += (double)x->hit.normal[k] * (double)d[k];
  return along;
}

/* Twice the formula of "Leaving a surface" in examples/manual.md, and what doubles do not know of the plane. */
static bool gap_is_documented(const point *x, const float o[3]) {
  double p[3][3], n[3], d[3], edge[2] = {0, 0}, most = 0, rounding = 0, sum = 0;
  memcpy(p, x->corner, sizeof p);
  normal_of(p, n);
  for (int k = 0; k < 3; k++) {
    for (int c = 0; c < 2; c++) edge[c] = fmax(edge[c], fabs(p[c + 1][k] - p[0][k]));
    d[k] = (double)o[k] - p[0][k], most = fmax(most, fabs(n[k]));
    rounding += fabs(n[k] * (double)o[k]), sum += fabs((double)o[k]) + fabs(d[k]);
  }
  const double kappa = edge[0] * edge[1] / most, length = sqrt(dot(n, n));
  return fabs(dot(n, d)) / length <= 2.1 * 0x1p-24 * rounding / length +
                                         (kappa < 0x1p26 ? fmax(0x1p-46 * kappa, 0x1p-38) : 0x1p-20) * sum + 0x1p-124;
}

/* Corners are multiples of 1/64 of a power of two: so small that doubles have the normal and products with it exactly. */
static double along_exactly(const point *x, const float d[3]) {
  double p[3][3], n[3], along[3] = {(double)d[0], (double)d[1], (double)d[2]};
  memcpy(p, x->corner, sizeof p);
  normal_of(p, n);
  return dot(n, along);
}

/* Returns how far the point is from the nearest edge of its triangle. */
static double from_edges(const point *x) {
  double p[3][3], n[3], least = INFINITY;
  memcpy(p, x->corner, sizeof p);
  normal_of(p, n);

  for (int c = 0; c < 3; c++) {
    double edge[3], to[3], moment[3];
    for (int k = 0; k < 3; k++) {
      edge[k] = p[(c + 1) % 3][k] - p[c][k];
      to[k] = x->at[k] - p[c][k];
    }
    for (int k = 0; k < 3; k++) moment[k] = edge[(k + 1) % 3] * to[(k + 2) % 3] - edge[(k + 2) % 3] * to[(k + 1) % 3];
    least = fmin(least, dot(moment, n) / sqrt(dot(edge, edge) * dot(n, n)));
  }

  return least;
}

/* Ray i of the batch, spawned; and its origins in the controls. */
static void leave(const place *g, const point *x, const float d[3], size_t i) {
  leaving *b = g->b;
  const pktrt_hit *h = &x->hit;
  pktrt_spawn(g->scene[0], &x->ray, h, d, &b->ray[i]);
  CHECK(b->ray[i].tmin == 0 && b->ray[i].tmax == INFINITY && same_bits(&b->ray[i].time, &x->ray.time, sizeof(float)) &&
        same_bits(b->ray[i].direction, d, sizeof b->ray[i].direction));
  b->plain[i] = b->moved[i] = b->ray[i];
  const double n[3] = {(double)h->normal[0], (double)h->normal[1], (double)h->normal[2]};
  const double far = fmax(1e-3 * (double)g->size, 30 * g->lift) / sqrt(dot(n, n));
  const double by = along_normal(x, d) < 0 ? -far : far;
  const bool near_edge = from_edges(x) < 90. / 24 * g->lift; /* from which it moves away */
  for (int k = 0; k < 3; k++) {
    b->plain[i].origin[k] = (float)x->at[k], b->moved[i].origin[k] = (float)(x->at[k] + by * n[k]);
    CHECK(near_edge || fabs((double)b->ray[i].origin[k] - x->at[k]) <= 34. / 24 * g->lift,
        "moved by more than the offset");
  }
  CHECK(gap_is_documented(x, b->ray[i].origin), "moved farther off the plane than documented");
  b->away[i] = -1;
}

static void leave_body(const place *g, rng *r) {
  leaving *b = g->b;
  arrive(g, r, NULL, b->from, b->tries);
  for (size_t j = 0; j < b->tries; j++) {
    if (b->from[j].hit.mesh == PKTRT_NONE) continue;
    const size_t i = b->n++;
    point *x = &b->from[i];
    float d[3];
    *x = b->from[j];
    direction(x, r, d);
    if (d[0] == 0 && d[1] == 0 && d[2] == 0) d[0] = 1;
    if (rng_below(r, 2))
      for (int k = 0; k < 3; k++) d[k] = -d[k];
    b->inward[i] = along_exactly(x, d) < 0; /* normals of convex meshes look out */
    leave(g, x, d, i);
  }
}

/* From the lower triangle of a pair to about the middle of the upper one. */
static void leave_gap(const place *g, rng *r) {
  leaving *b = g->b;
  arrive(g, r, NULL, b->from, b->tries);
  for (size_t j = 0; j < b->tries; j++) {
    if (b->from[j].hit.mesh == PKTRT_NONE) continue;
    point *x = &b->from[b->n];
    double p[3][3], q[3];
    float d[3];
    *x = b->from[j];
    corners_of(&g->w, 1, x->hit.triangle, 0, p);
    point_of(p, 0.3 + 0.1 * (double)rng_unit(r), 0.3 + 0.1 * (double)rng_unit(r), q);
    for (int k = 0; k < 3; k++) d[k] = (float)(q[k] - x->at[k]);
    if (along_normal(x, d) == 0) continue; /* nothing between them */
    leave(g, x, d, b->n);
    b->ray[b->n].tmax = b->plain[b->n].tmax = b->moved[b->n].tmax = 1.5f;
    b->n++;
  }
}

static pktrt_ray shadow_ray(const pktrt_ray *from, const pktrt_ray *to) {
  pktrt_ray x = ray_towards(from->origin, to->origin, from->time);
  x.tmax = 1;
  return x;
}

/* Moves the end of a shadow ray off its surface by what rounding does to the ray's direction, 2^-22 of its length, as "Leaving a
   surface" in pktrt.h advises. */
static void move_end(const point *x, const float back[3], pktrt_ray *end) {
  double n[3], d[3];
  for (int k = 0; k < 3; k++) n[k] = (double)x->hit.normal[k], d[k] = (double)back[k];
  const double by = (dot(n, d) < 0 ? -0x1p-22 : 0x1p-22) * sqrt(dot(d, d) / dot(n, n));
  for (int k = 0; k < 3; k++) end->origin[k] = (float)((double)end->origin[k] + by * n[k]);
}

/* From wall to wall, both ends moved off. */
static void leave_wall(const place *g, rng *r) {
  leaving *b = g->b;
  arrive(g, r, NULL, b->from, b->tries);
  arrive(g, r, b->from, b->to, b->tries);
  for (size_t j = 0; j < b->tries; j++) {
    if (b->from[j].hit.mesh == PKTRT_NONE || b->to[j].hit.mesh == PKTRT_NONE) continue;
    if (same_plane(b->from[j].corner, b->to[j].corner)) continue;
    const size_t i = b->n++;
    float d[3], back[3];
    b->from[i] = b->from[j], b->to[i] = b->to[j];
    for (int k = 0; k < 3; k++) d[k] = (float)(b->to[i].at[k] - b->from[i].at[k]), back[k] = -d[k];
    leave(g, &b->to[i], back, i);
    pktrt_ray end = b->ray[i];
    const pktrt_ray plain_end = b->plain[i];
    move_end(&b->to[i], back, &end);
    leave(g, &b->from[i], d, i);
    b->ray[i] = shadow_ray(&b->ray[i], &end), b->plain[i] = shadow_ray(&b->plain[i], &plain_end);
  }
}

/* --- what rays must not do --- */

static double from_others(const place *g, point *x) {
  double away = INFINITY, p[3][3];
  for (uint32_t m = g->what == GAPS; m < g->w.n; m++)
    for (uint32_t t = 0; t < g->w.m[m].nt; t++) {
      if (g->what == GAPS && t != x->hit.triangle) continue;
      corners_of(&g->w, m, t, x->ray.time, p);
      if (to_plane(x->at, p) >= away) continue;
      if (g->what == GAPS || !same_plane(x->corner, p)) away = fmin(away, to_triangle(x->at, p));
    }
  return away;
}

static bool far_from_others(const place *g, size_t i) {
  leaving *b = g->b;
  if (b->away[i] < 0) b->away[i] = from_others(g, &b->from[i]);
  if (b->away[i] > g->beyond && g->what == ROOMS) b->away[i] = from_others(g, &b->to[i]);
  return b->away[i] > g->beyond;
}

static bool leaks(const place *g, size_t i, const pktrt_hit *h) {
  return h->mesh == PKTRT_NONE && (g->what == GAPS || (g->what == CONVEX && g->b->inward[i]));
}

static void tell(tally *t, int what, bool found) { t->rays[what]++, t->found[what] += found; }

static void judge(const place *g, tally *t) {
  const leaving *b = g->b;
  for (size_t i = 0; i < b->n; i++) {
    const pktrt_hit *h = &b->got[i], *left = &b->from[i].hit;
    const bool hit = h->mesh != PKTRT_NONE;
    const bool body = g->what == CONVEX, self = h->mesh == left->mesh && h->triangle == left->triangle;
    if (body || g->what == LOOSE) tell(t, LEFT, self);
    if (body && !b->inward[i]) tell(t, BODY, hit);
    if ((g->what == GAPS || (body && b->inward[i])) && far_from_others(g, i)) tell(t, LEAKS, leaks(g, i, h));
    if (g->what == ROOMS && far_from_others(g, i)) tell(t, SHADOWS, hit);
  }
}

static void trace(const place *g, int isa, const pktrt_ray *rays) {
  leaving *b = g->b;
  bool occluded[BATCH];
  if (g->what != ROOMS) pktrt_intersect_n(g->scene[isa], rays, b->got, b->n);
  else pktrt_occluded_n(g->scene[isa], rays, occluded, b->n);
  for (size_t i = 0; i < b->n && g->what == ROOMS; i++) b->got[i].mesh = occluded[i] ? 0 : PKTRT_NONE;
}

static void add(tally *sum, const tally *t, int what) {
  sum->rays[what] += t->rays[what], sum->found[what] += t->found[what];
}

/* All rays on all instruction sets, and their controls on one. */
static void try_batch(const place *g, tally *of, tally *control, uint64_t *near_leaks, double *farthest) {
  leaving *b = g->b;
  tally plain, moved;
  memset(&plain, 0, sizeof plain);
  memset(&moved, 0, sizeof moved);
  for (int isa = 0; isa < isa_count; isa++) trace(g, isa, b->ray), judge(g, &of[isa]);
  for (size_t i = 0; i < b->n; i++)
    if (leaks(g, i, &b->got[i])) {
      *near_leaks += !far_from_others(g, i);
      *farthest = fmax(*farthest, b->away[i] / g->lift);
    }
  trace(g, isa_count - 1, b->plain), judge(g, &plain);
  add(control, &plain, LEFT), add(control, &plain, BODY), add(control, &plain, SHADOWS);
  if (g->what != CONVEX && g->what != GAPS) return;
  trace(g, isa_count - 1, b->moved), judge(g, &moved);
  add(control, &moved, LEAKS);
}

/* --- jobs: a case at one scale --- */

static void set_bounds(place *g) {
  float lo[3] = {INFINITY, INFINITY, INFINITY}, hi[3] = {-INFINITY, -INFINITY, -INFINITY}, most = 0, extent = 0;
  for (uint32_t i = 0; i < g->w.n; i++)
    for (size_t v = 0; v < (size_t)g->w.m[i].nv * g->w.m[i].keys; v++)
      for (int k = 0; k < 3; k++) {
        const float p = g->w.m[i].p[3 * v + (size_t)k];
        lo[k] = fminf(lo[k], p), hi[k] = fmaxf(hi[k], p), most = fmaxf(most, fabsf(p));
      }
  for (int k = 0; k < 3; k++) extent = fmaxf(extent, hi[k] - lo[k]), g->centre[k] = lo[k] / 2 + hi[k] / 2;
  g->size = extent / 2;
  g->lift = 24 * 0x1p-24 * (double)most;
  g->beyond = 0x1p-24 * (32 * (double)most + 2 * ((double)extent + 2 * g->lift));
}

static void set_up(place *g, int which, int scale, int variant) {
  memset(g, 0, sizeof *g);
  g->what = (kind)(which / OFFSETS);
  g->w = world_for(g->what, scale, which % OFFSETS, variant);
  set_bounds(g);
  for (int i = 0; i < isa_count; i++) g->scene[i] = world_scene(&g->w, isas[i], 0);
  world below = g->w;
  below.n = 1;
  if (g->what == GAPS) g->below = world_scene(&below, PKTRT_ISA_AUTO, 0);
  g->b = malloc(sizeof *g->b);
  if (!g->b) abort();
}

static void tear_down(place *g) {
  for (int i = 0; i < isa_count; i++) pktrt_scene_destroy(g->scene[i]);
  pktrt_scene_destroy(g->below);
  world_free(&g->w);
  free(g->b);
}

static void secondary_job(void *arg, size_t job) {
  secondary_run *run_ = arg;
  const int which = (int)(job % CASES), scale = (int)(job / CASES);
  const kind what = (kind)(which / OFFSETS);
  const int variants = what == CONVEX || what == ROOMS ? VARIANTS : 1;
  const size_t rays = thorough(1000000) / SCALES / (size_t)variants + 1;
  tally of[8], control;
  uint64_t near_leaks = 0;
  double farthest = 0;
  memset(of, 0, sizeof of);
  memset(&control, 0, sizeof control);
  for (int variant = 0; variant < variants; variant++) {
    place g;
    set_up(&g, which, scale, variant);
    for (size_t done = 0, batch = 0; done < rays; done += g.b->n, batch++) {
      rng r = rng_of(((uint64_t)job * VARIANTS + (uint64_t)variant) << 32 | batch);
      g.b->n = 0, g.b->tries = rays - done < BATCH / 2 ? 2 * (rays - done) : BATCH;
      if (what == GAPS) leave_gap(&g, &r);
      else if (what == ROOMS) leave_wall(&g, &r);
      else leave_body(&g, &r);
      if (!CHECK(g.b->n > 0 || g.b->tries < 64, "%s: rays reach surfaces", kind_names[what])) break;
      try_batch(&g, of, &control, &near_leaks, &farthest);
    }
    tear_down(&g);
  }
  pthread_mutex_lock(&run_->lock);
  for (int w = 0; w < WHATS; w++) {
    for (int i = 0; i < isa_count; i++) add(&run_->of[which][i], &of[i], w);
    add(&run_->control[which], &control, w);
  }
  run_->leaks[which] += near_leaks, run_->farthest[which] = fmax(run_->farthest[which], farthest);
  pthread_mutex_unlock(&run_->lock);
}

static void secondary_figures(const secondary_run *run_) {
  for (int c = 0; c < CASES; c++) {
    char name[64];
    snprintf(name, sizeof name, "%s, %g sizes away", kind_names[c / OFFSETS], (double)offsets[c % OFFSETS]);
    for (int w = 0; w < WHATS; w++) {
      for (int i = 0; i < isa_count; i++) {
        const tally *t = &run_->of[c][i];
        if (t->rays[w]) count_figure("secondary", name, isas[i], t->rays[w], whats[w], t->found[w]);
      }
      const tally *t = &run_->control[c];
      if (t->rays[w]) control_figure("secondary", name, whats[w], controls[w], t->rays[w], t->found[w]);
    }
    const uint64_t tried = run_->of[c][isa_count - 1].rays[LEAKS];
    if (!tried && !run_->leaks[c]) continue;
    value_figure(
        "secondary", name, PKTRT_ISA_AUTO, tried, "rays farther from another surface", (double)tried, INFINITY);
    value_figure("secondary", name, PKTRT_ISA_AUTO, tried, "leaks nearer than that", (double)run_->leaks[c], INFINITY);
    value_figure("secondary", name, PKTRT_ISA_AUTO, tried, "farthest leak in offsets", run_->farthest[c], INFINITY);
  }
}

static void secondary(void) {
  secondary_run *run_ = calloc(1, sizeof *run_);
  if (!run_) abort();
  pthread_mutex_init(&run_->lock, NULL);
  jobs_for(CASES * SCALES, secondary_job, run_);
  secondary_figures(run_);
  pthread_mutex_destroy(&run_->lock);
  free(run_);
}

/* --- shadows where a box stands on a floor --- */

enum { FLOORS = 6, VIEW = 160 };
typedef enum start { SPAWNED, LARGEST, NOT_MOVED } start; /* the controls: 24 e of the largest coordinate; not at all */

/* Turns by an angle of a triangle of sides 3, 4 and 5, so that corners of the floors stay floats. */
static void tilt(bool tilted, double x, double y, double z, float out[3]) {
  out[0] = (float)(tilted ? (4 * x - 3 * y) / 5 : x), out[1] = (float)(tilted ? (3 * x + 4 * y) / 5 : y),
  out[2] = (float)z;
}

static world floor_and_box(float half, bool tilted) {
  world w = world_of(mesh_grid(1, half));
  w.m[1] = mesh_box(), w.n = 2;
  for (uint32_t i = 0; i < 2; i++)
    for (uint32_t v = 0; v < w.m[i].nv; v++) {
      float *p = w.m[i].p + 3 * v;
      const double size = i ? 0.1 : 1;
      tilt(tilted, size * (double)p[0], size * ((double)p[1] + i), size * (double)p[2], p);
    }
  return w;
}

static size_t shadowed(const world *w, const pktrt_scene *s, float half, bool tilted, start from) {
  size_t n = 0;
  float eye[3], light[3], up[3];
  tilt(tilted, 0.15, 0.5, 0.6, eye), tilt(tilted, 0.5, 1, 0.3, light), tilt(tilted, 0, 1, 0, up);
  for (int i = 0; i < VIEW * VIEW; i++) {
    float at[3];
    tilt(tilted, 0.5 * (i % VIEW + 0.5) / VIEW - 0.25, 0, 0.5 * (i / VIEW + 0.5) / VIEW - 0.25, at);
    for (int k = 0; k < 3; k++) at[k] -= eye[k];
    pktrt_ray ray = pktrt_make_ray(eye, at), shadow;
    pktrt_hit hit;
    if (!CHECK(pktrt_intersect(s, &ray, &hit)) || hit.mesh) continue;
    pktrt_spawn(s, &ray, &hit, light, &shadow);
    if (from != SPAWNED) {
      point x = {.ray = ray, .hit = hit};
      corners_of(w, 0, hit.triangle, 0, x.corner);
      point_of(x.corner, (double)hit.u, (double)hit.v, x.at);
      const double by = from == LARGEST ? 24 * 0x1p-24 * (double)half : 0;
      for (int k = 0; k < 3; k++) shadow.origin[k] = (float)(x.at[k] + by * (double)up[k]);
    }
    n += pktrt_occluded(s, &shadow);
  }
  return n;
}

/* The same in a picture: pixels that no light reaches, those of the box among them. */
static size_t dark_pixels(float half, bool tilted, pktrt_mode mode) {
  float *pixels = stage_pixels(VIEW * VIEW * 3);
  world w = floor_and_box(half, tilted);
  pktrt_scene *s = stage_open();
  pktrt_material grey = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
  const uint32_t material = stage_material(s, &grey);
  pktrt_light l = light_of(PKTRT_LIGHT_DIRECTIONAL, 1);
  float eye[3], target[3];
  tilt(tilted, -0.5, -1, -0.3, l.direction), tilt(tilted, 0.15, 0.5, 0.6, eye), tilt(tilted, 0, 0, 0, target);
  for (uint32_t i = 0; i < 2; i++) stage_mesh(s, &w.m[i], material);
  stage_light(s, &l), stage_commit(s);
  pktrt_render_desc d = stage_view(mode, VIEW, VIEW, pixels, vec_from(eye), vec_from(target));
  stage_render(s, &d);
  size_t n = 0;
  for (int i = 0; i < VIEW * VIEW; i++) n += !(pixels[3 * i] > 0);
  pktrt_scene_destroy(s);
  world_free(&w);
  free(pixels);
  return n;
}

static bool within_a_hundredth(size_t n, size_t want) { return 100 * (n < want ? want - n : n - want) <= want; }

static void contact_shadows(void) {
  for (int tilted = 0; tilted < 2; tilted++) {
    size_t first[2] = {0, 0};
    float half = 10;
    for (int i = 0; i < FLOORS; i++, half *= 10) {
      world w = floor_and_box(half, tilted);
      pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
      const size_t n = shadowed(&w, s, half, tilted, SPAWNED), dark = dark_pixels(half, tilted, PKTRT_MODE_WRT);
      const size_t old = shadowed(&w, s, half, tilted, LARGEST), none = shadowed(&w, s, half, tilted, NOT_MOVED);
      if (i == 0) first[0] = n, first[1] = dark;
      say("%s floor of half-width %g: %zu shadow rays of %d meet the box; moved by its size %zu, not moved %zu; %zu "
          "dark pixels",
          tilted ? "tilted" : "flat", (double)half, n, VIEW * VIEW, old, none, dark);
      CHECK(n > 400 && within_a_hundredth(n, first[0]), "%zu, not %zu", n, first[0]);
      CHECK(dark > 200 && within_a_hundredth(dark, first[1]), "%zu dark pixels, not %zu", dark, first[1]);
      if (i >= 4) CHECK(!within_a_hundredth(old, first[0]), "the control: moved by the floor's size, %zu", old);
      if (i >= 4) CHECK(!within_a_hundredth(none, first[0]), "the control: not moved, %zu", none);
      const char *name = tilted ? "a box on a tilted floor" : "a box on a floor", *what = "lost by a hundredth or more";
      count_figure("shadows", name, PKTRT_ISA_AUTO, n, what, !within_a_hundredth(n, first[0]));
      control_figure("shadows", name, what, "moved by the floor's size", n, !within_a_hundredth(old, first[0]));
      pktrt_scene_destroy(s);
      world_free(&w);
    }
  }
}

void suite_stability_secondary(void) {
  run("stable: a box on a floor has the same shadow, however large the floor", contact_shadows);
  run("stable: spawned rays do not meet what they left, and leak no farther than they are moved", secondary);
}
