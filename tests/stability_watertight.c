/* Closed meshes do not leak: rays from inside them, aimed at vertices and edge points, hit something, whatever the
   scale, the offset, the shape and the motion. And lines cross convex meshes once in and once out.

   Inside means: by the winding number of the mesh around the ray's origin, computed without error, of the vertices
   as they are rounded at the ray's time. Within 1e-6 of a mesh's size of the surface a hit's own rounding
   (>>exactness: 6.25 eps M in each of two axes) might still put an origin outside. Flattened meshes are 1e-4 thick:
   there origins stay a tenth of the way to the centre away from the surface. Elsewhere they come as near as chance
   wills. */
#include "stability.h"

/* --- exact signs ---
   Sums of doubles without error (Shewchuk 1997), where a bound on the error of plain double does not decide. */

typedef struct exact { /* the sum of its parts, which do not overlap and grow */
  double part[256];
  int n;
} exact;

static void exact_add(exact *e, double x) {
  int n = 0;
  for (int i = 0; i < e->n; i++) {
    const double y = e->part[i], sum = x + y, most = sum - x, rest = (x - (sum - most)) + (y - most);
    if (rest != 0) e->part[n++] = rest;
    x = sum;
  }
  if (x != 0) e->part[n++] = x;
  e->n = n;
}

static int exact_sign(const exact *e) { return e->n == 0 ? 0 : e->part[e->n - 1] > 0 ? 1 : -1; }

/* a = high + low, of 26 bits each (Dekker 1971). */
static void split(double a, double *high, double *low) {
  const double c = 134217729 * a;
  *high = c - (c - a), *low = a - *high;
}

/* a b = product + error. No underflow: factors are multiples of 2^-149, and at most three of them meet. */
static double product(double a, double b, double *error) {
  double ah, al, bh, bl, p = a * b;
  split(a, &ah, &al), split(b, &bh, &bl);
  *error = ((ah * bh - p) + ah * bl + al * bh) + al * bl;
  return p;
}

/* a - b of floats, as a double and what it lacks. */
typedef struct pair {
  double part[2];
} pair;

static pair difference(float x, float y) {
  const double a = (double)x, b = (double)y, d = a - b, most = d - a;
  return (pair){{d, (a - (d - most)) - (b + most)}};
}

static void exact_add_product(exact *e, pair a, pair b, pair c, double sign) {
  for (int i = 0; i < 8; i++) {
    double low, rest, p = product(a.part[i & 1], b.part[i >> 1 & 1], &low);
    p = product(p, sign * c.part[i >> 2], &rest);
    exact_add(e, p), exact_add(e, rest);
    p = product(low, sign * c.part[i >> 2], &rest);
    exact_add(e, p), exact_add(e, rest);
  }
}

static int sign_of(double x) { return (x > 0) - (x < 0); }

/* The sign of (a - o) x (b - o) in the axes u and v. Filter: l and r are off by 3 roundings each, their difference by
   one more. */
static int turn_sign(const float a[3], const float b[3], const float o[3], int u, int v) {
  const pair one = {{1, 0}}, au = difference(a[u], o[u]), av = difference(a[v], o[v]), bu = difference(b[u], o[u]),
             bv = difference(b[v], o[v]);
  const double l = au.part[0] * bv.part[0], r = av.part[0] * bu.part[0], d = l - r;
  if (fabs(d) > 8 * 0x1p-53 * (fabs(l) + fabs(r))) return sign_of(d);
  exact e = {{0}, 0};
  exact_add_product(&e, au, bv, one, 1), exact_add_product(&e, av, bu, one, -1);
  return exact_sign(&e);
}

/* The sign of the determinant of a - o, b - o, c - o. Filter: 3 roundings of differences, 2 of products, 3 of sums. */
static int volume_sign(const float a[3], const float b[3], const float c[3], const float o[3]) {
  pair p[3][3];
  double sum = 0, size = 0;
  for (int k = 0; k < 3; k++)
    p[0][k] = difference(a[k], o[k]), p[1][k] = difference(b[k], o[k]), p[2][k] = difference(c[k], o[k]);
  for (int k = 0; k < 3; k++) {
    const int u = (k + 1) % 3, v = (k + 2) % 3;
    const double l = p[1][u].part[0] * p[2][v].part[0], r = p[1][v].part[0] * p[2][u].part[0];
    sum += p[0][k].part[0] * (l - r), size += fabs(p[0][k].part[0]) * (fabs(l) + fabs(r));
  }
  if (fabs(sum) > 16 * 0x1p-53 * size) return sign_of(sum);
  exact e = {{0}, 0};
  for (int k = 0; k < 3; k++) {
    const int u = (k + 1) % 3, v = (k + 2) % 3;
    exact_add_product(&e, p[0][k], p[1][u], p[2][v], 1), exact_add_product(&e, p[0][k], p[1][v], p[2][u], -1);
  }
  return exact_sign(&e);
}

/* --- the winding number --- */

/* Vertices of a mesh at a time: where the canonical formula puts them. */
typedef struct still {
  const mesh *m;
  float *p;
} still;

static still still_at(const mesh *m, float time) {
  still s = {m, calloc((size_t)m->nv * 3, sizeof(float))};
  if (!s.p) abort();
  for (uint32_t i = 0; i < m->nv; i++) ref_vertex(m, i, time, s.p + 3 * (size_t)i);
  return s;
}

static const float *corner_of(const still *s, uint32_t triangle, uint32_t corner) {
  return s->p + 3 * (size_t)s->m->i[3 * (size_t)triangle + corner];
}

/* As turn_sign, of an origin moved by (h, h^2), h > 0 beyond all measure small: to a x b that adds h (a_v - b_v) and
   then h^2 (b_u - a_u). Zero for edges along the axis alone, which such a line does not meet. */
static int moved_turn_sign(int turn, const float a[3], const float b[3], int u, int v) {
  if (turn) return turn;
  return a[v] != b[v] ? (a[v] > b[v] ? 1 : -1) : (b[u] > a[u]) - (b[u] < a[u]);
}

static bool beside(const float a[3], const float b[3], const float c[3], const float o[3], int k) {
  return (a[k] < o[k] && b[k] < o[k] && c[k] < o[k]) || (a[k] > o[k] && b[k] > o[k] && c[k] > o[k]);
}

/* How often the mesh winds around a point: crossings of the ray from there along an axis, out minus in. The ray is
   moved aside by next to nothing, so that it meets no edge; this changes nothing, unless the point lies on the
   surface: *on. */
static int winding(const still *s, const float o[3], int axis, bool *on) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  int sum = 0;
  *on = false;
  for (uint32_t t = 0; t < s->m->nt; t++) {
    const float *a = corner_of(s, t, 0), *b = corner_of(s, t, 1), *c = corner_of(s, t, 2);
    if (beside(a, b, c, o, u) || beside(a, b, c, o, v)) continue;
    if (a[axis] < o[axis] && b[axis] < o[axis] && c[axis] < o[axis]) continue;
    int x = turn_sign(b, c, o, u, v), y = turn_sign(c, a, o, u, v), z = turn_sign(a, b, o, u, v);
    if ((x < 0 || y < 0 || z < 0) && (x > 0 || y > 0 || z > 0)) continue;
    const int before = volume_sign(a, b, c, o);
    if (!before && (x || y || z || !beside(a, b, c, o, axis))) *on = true;
    x = moved_turn_sign(x, b, c, u, v), y = moved_turn_sign(y, c, a, u, v), z = moved_turn_sign(z, a, b, u, v);
    if (x && x == y && x == z && x == before) sum += x;
  }
  return sum;
}

/* The control: the same in float, a ray along the axis as it is. */
static int plain_winding(const still *s, const float o[3], int axis) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  int sum = 0;
  for (uint32_t t = 0; t < s->m->nt; t++) {
    float p[3][3];
    for (uint32_t c = 0; c < 3; c++)
      for (int k = 0; k < 3; k++) p[c][k] = corner_of(s, t, c)[k] - o[k];
    const float x = p[1][u] * p[2][v] - p[1][v] * p[2][u], y = p[2][u] * p[0][v] - p[2][v] * p[0][u];
    const float z = p[0][u] * p[1][v] - p[0][v] * p[1][u], det = x + y + z;
    if (!((x >= 0 && y >= 0 && z >= 0) || (x <= 0 && y <= 0 && z <= 0)) || det == 0) continue;
    if ((x * p[0][axis] + y * p[1][axis] + z * p[2][axis]) / det > 0) sum += det > 0 ? 1 : -1;
  }
  return sum;
}

typedef struct tally {
  uint64_t tried, wrong, plain, on;
} tally;

/* All three axes must give the number that is known, or the same one (known: 99). */
static void try_winding(const still *s, const float o[3], int known, tally *n) {
  int got[3];
  bool on = false;
  for (int k = 0; k < 3; k++) {
    bool here;
    got[k] = winding(s, o, k, &here);
    on |= here;
  }
  n->on += on;
  if (on && known == 99) return;
  if (known == 99) known = got[0];
  n->tried++;
  n->wrong += on || got[0] != known || got[1] != known || got[2] != known;
  for (int k = 0; k < 3; k++)
    if (plain_winding(s, o, k) != known) {
      n->plain++;
      break;
    }
}

/* Points of a lattice that has the vertices of box and octahedron: rays along an axis meet edges. */
static void winding_on_lattice(tally *n) {
  mesh box = mesh_box(), eight = mesh_sphere(0, 0, 0);
  const still b = still_at(&box, 0), e = still_at(&eight, 0);
  bool on;
  for (int i = 0; i < 11 * 11 * 11; i++) {
    const float o[3] = {(float)(i % 11 - 5) / 4, (float)(i / 11 % 11 - 5) / 4, (float)(i / 121 - 5) / 4};
    const float most = fmaxf(fabsf(o[0]), fmaxf(fabsf(o[1]), fabsf(o[2])));
    const float sum = fabsf(o[0]) + fabsf(o[1]) + fabsf(o[2]);
    if (most != 1) try_winding(&b, o, most < 1, n);
    else CHECK((winding(&b, o, i % 3, &on), on), "point %d is on the box", i);
    if (sum != 1) try_winding(&e, o, sum < 1, n);
    else CHECK((winding(&e, o, i % 3, &on), on), "point %d is on the octahedron", i);
  }
  free(b.p), free(e.p);
  mesh_free(&box), mesh_free(&eight);
}

/* Points an ulp or so from vertices, edges and faces, where nobody knows but all axes must agree; and clearly inside
   or out. */
static void winding_near_surface(float offset, float jitter, int times, tally *n) {
  mesh m = mesh_sphere(3, 0.1f, 1);
  mesh_move(&m, 2, 2.5f, jitter, 7);
  mesh_place(&m, (float[3]){1, 1, 1}, (float[3]){offset, -0.5f * offset, 0.25f * offset});
  const still s = still_at(&m, 0.4f);
  const float c[3] = {offset, -0.5f * offset, 0.25f * offset};
  for (int i = 0; i < times; i++) {
    rng r = rng_of((uint64_t)i);
    const uint32_t t = rng_below(&r, m.nt);
    const float f = i % 3 ? rng_unit(&r) : 0, g = i % 3 > 1 ? (1 - f) * rng_unit(&r) : 0;
    float o[3], in[3], out[3];
    for (int k = 0; k < 3; k++) {
      const float a = corner_of(&s, t, 0)[k], b = corner_of(&s, t, 1)[k] - a, e = corner_of(&s, t, 2)[k] - a;
      const float p = a + f * b + g * e;
      o[k] = rng_below(&r, 2) ? p : nextafterf(p, c[k]);
      in[k] = c[k] + 0.5f * (p - c[k]), out[k] = c[k] + 1.5f * (p - c[k]);
    }
    try_winding(&s, o, 99, n);
    if (jitter < 0.1f) try_winding(&s, in, 1, n), try_winding(&s, out, 0, n);
  }
  free(s.p);
  mesh_free(&m);
}

static void winding_numbers(void) {
  static const float offsets[3] = {0, 10, 1e5f};
  tally n = {0, 0, 0, 0};
  winding_on_lattice(&n);
  for (int i = 0; i < 6; i++) winding_near_surface(offsets[i % 3], i < 3 ? 0.01f : 0.2f, 100 + (int)thorough(3000), &n);
  count_figure("watertight", "winding numbers", PKTRT_ISA_AUTO, n.tried, "wrong winding numbers", n.wrong);
  control_figure("watertight", "winding numbers", "wrong winding numbers", "in float", n.tried, n.plain);
  say("%llu points, %llu wrong, in float %llu; %llu on the surface", (unsigned long long)n.tried,
      (unsigned long long)n.wrong, (unsigned long long)n.plain, (unsigned long long)n.on);
}

/* --- closed meshes --- */

typedef struct shape {
  const char *name;
  float scale, stretch[3], offset; /* offset: in sizes */
  uint32_t keys;
  float turn, way; /* between keys: an angle; how far it moves at most, in sizes */
} shape;

/* Of few triangles all, of many the last eight. */
static const shape shapes[] = {
    {"scale 1", 1, {1, 1, 1}, 0, 1, 0, 0},
    {"scale 1e3, offset 1e3", 1e3f, {1, 1, 1}, 1e3f, 1, 0, 0},
    {"2 keys, far", 1, {1, 1, 1}, 0, 2, 0, 50},
    {"3 keys, turning, flat 1:10000", 1, {1, 1e-4f, 1}, 0, 3, 2.5f, 0},
    {"5 keys, turning, offset 1e3", 1, {1, 1, 1}, 1e3f, 5, 2.5f, 0},
    {"scale 1e-4", 1e-4f, {1, 1, 1}, 0, 1, 0, 0},
    {"scale 1e6, offset 10", 1e6f, {1, 1, 1}, 10, 1, 0, 0},
    {"offset 1e5", 1, {1, 1, 1}, 1e5f, 1, 0, 0},
    {"flat 1:10000, offset 1", 1, {1, 1e-4f, 1}, 1, 1, 0, 0},
    {"needle 1:10000", 1, {1e-4f, 1, 1e-4f}, 0, 1, 0, 0},
    {"2 keys, turning", 1, {1, 1, 1}, 0, 2, 2, 0},
    {"3 keys, turning, far, scale 1e-4", 1e-4f, {1, 1, 1}, 0, 3, 1.5f, 10},
    {"5 keys, far, scale 1e6", 1e6f, {1, 1, 1}, 0, 5, 0.1f, 1e3f},
};
enum { LARGE = 8 };

/* Where rays start: inside the mesh at that time. Of a moving mesh four after one another have one place within it. */
typedef struct spot {
  float o[3], time;
} spot;

typedef struct closed {
  char name[64];
  world w;
  uint64_t seed;
  spot *spots;
  uint32_t spot_count, outside; /* outside: drawn, and not taken */
  float reach;                  /* of origins, from the centre to the surface and beyond */
  pktrt_ray *rays;
  size_t ray_count;
} closed;

static mesh shaped(const shape *f, int level, uint64_t seed) {
  mesh m = mesh_sphere(level, 0.03f, seed);
  const float s = f->scale, x = f->offset * s, by_itself = (f->way > 0 ? 0.5f : 0.03f) / (float)(1 << level);
  if (f->keys > 1) mesh_move(&m, f->keys, f->turn, by_itself, seed);
  const float scale[3] = {s * f->stretch[0], s * f->stretch[1], s * f->stretch[2]};
  mesh_place(&m, scale, (float[3]){x, -0.5f * x, 0.25f * x});
  for (uint32_t k = 0; k < m.keys && f->way > 0; k++) {
    rng r = rng_of(seed + k);
    float *p = m.p + 3 * (size_t)k * m.nv, by[3];
    for (int a = 0; a < 3; a++) by[a] = s * f->way * rng_sign(&r);
    for (size_t i = 0; i < (size_t)m.nv * 3; i++) p[i] += by[i % 3];
  }
  return m;
}

static void centre_of(const still *s, float out[3]) {
  double sum[3] = {0, 0, 0};
  for (size_t i = 0; i < (size_t)s->m->nv * 3; i++) sum[i % 3] += (double)s->p[i];
  for (int k = 0; k < 3; k++) out[k] = (float)(sum[k] / (double)s->m->nv);
}

/* In one spot of 16 the centre, else somewhere on the way to a vertex or a little beyond. */
static bool draw_spot(const still *s, const float c[3], uint64_t seed, float most, float out[3]) {
  rng r = rng_of(seed);
  const float f = rng_below(&r, 16) ? most * rng_unit(&r) : 0, *p = s->p + 3 * (size_t)rng_below(&r, s->m->nv);
  bool on;
  for (int k = 0; k < 3; k++) out[k] = c[k] + f * (p[k] - c[k]);
  return winding(s, out, (int)rng_below(&r, 3), &on) != 0 && !on;
}

static void draw_spots(closed *c) {
  const mesh *m = &c->w.m[0];
  still s = {m, NULL};
  float centre[3] = {0, 0, 0};
  for (uint32_t i = 0; i < c->spot_count; i++) {
    spot *x = &c->spots[i];
    rng r = rng_of(c->seed + 7777 + i);
    if (!s.p || m->keys > 1) {
      free(s.p);
      x->time = i < m->keys ? (float)i / (float)(m->keys > 1 ? m->keys - 1 : 1) : rng_unit(&r); /* at keys, between */
      s = still_at(m, x->time), centre_of(&s, centre);
    }
    const uint64_t place = c->seed * 4096 + (m->keys > 1 ? i / 4 : i);
    uint32_t drawn = 0;
    while (!draw_spot(&s, centre, place + ((uint64_t)drawn << 32), c->reach, x->o) && drawn < 100) drawn++;
    c->outside += drawn;
    CHECK(drawn < 100, "%s: no point is inside", c->name);
  }
  free(s.p);
}

/* Rays come in chunks, and these in fours of 64. */
enum { CHUNK = 256, BUNDLE = 64 };

static void target(const mesh *m, uint32_t triangle, float time, rng *r, float out[3]) {
  float a[3], b[3];
  const uint32_t c = rng_below(r, 3), edge = rng_below(r, 2);
  ref_vertex(m, m->i[3 * (size_t)triangle + c], time, a);
  memcpy(out, a, sizeof a);
  if (!edge) return;
  ref_vertex(m, m->i[3 * (size_t)triangle + (c + 1) % 3], time, b);
  const float f = rng_below(r, 8) ? rng_unit(r) : 0.5f;
  for (int k = 0; k < 3; k++) out[k] = a[k] + f * (b[k] - a[k]);
}

/* By chunk: rays from anywhere to anywhere; from one spot to neighbouring triangles; from four spots of one place
   within the mesh, at four times, to neighbouring triangles; from one spot to anywhere. */
static void aim(const closed *c, uint64_t chunk, pktrt_ray *out, size_t n) {
  const mesh *m = &c->w.m[0];
  for (size_t j = 0; j < n; j++) {
    rng r = rng_of(c->seed << 40 ^ (chunk * CHUNK + j)), b = rng_of(~c->seed << 40 ^ (chunk * CHUNK + j / BUNDLE));
    uint32_t x = rng_below(&b, c->spot_count), t = rng_below(&b, m->nt);
    const uint64_t kind = mix64(chunk) & 3;
    if (kind == 0) x = rng_below(&r, c->spot_count);
    if (kind == 2) x = x / 4 * 4 + rng_below(&r, 4);
    if (kind == 0 || kind == 3) t = rng_below(&r, m->nt);
    else t = (t + rng_below(&r, 64)) % m->nt;
    float p[3];
    target(m, t, c->spots[x].time, &r, p);
    out[j] = ray_towards(c->spots[x].o, p, c->spots[x].time);
  }
}

/* Whether each of the rays of a chunk hits: by intersection or by occlusion, of 16 chunks 12 on the fast path, 3 one
   by one, 1 on the paper's, which is slow. */
static void ask(const pktrt_scene *s, uint64_t chunk, const pktrt_ray *rays, bool *hit, size_t n, pktrt_stats *stats) {
  const uint64_t way = mix64(chunk) >> 2, path = way & 15;
  const bool any = way >> 4 & 1;
  pktrt_hit h[CHUNK];
  pktrt_query_desc q;
  memset(&q, 0, sizeof q);
  q.path = path == 0 ? PKTRT_PATH_PAPER : PKTRT_PATH_FAST;
  if ((way >> 5 & 31) == 0) q.stats = stats;
  if (path > 12) {
    for (size_t j = 0; j < n; j++) hit[j] = any ? pktrt_occluded(s, &rays[j]) : pktrt_intersect(s, &rays[j], &h[j]);
  } else if (any) {
    pktrt_occluded_ex(s, &q, rays, hit, n);
  } else {
    pktrt_intersect_ex(s, &q, rays, h, n);
    for (size_t j = 0; j < n; j++) hit[j] = h[j].mesh != PKTRT_NONE;
  }
}

static void tell_leak(const closed *c, pktrt_isa isa, uint64_t chunk, const pktrt_ray *r) {
  const float *o = r->origin, *d = r->direction;
  CHECK(false, "leak: %s, %s, chunk %llu, o %a %a %a, d %a %a %a, time %a", c->name, pktrt_isa_string(isa),
      (unsigned long long)chunk, (double)o[0], (double)o[1], (double)o[2], (double)d[0], (double)d[1], (double)d[2],
      (double)r->time);
}

static uint64_t leaks_of(const closed *c, pktrt_isa isa, pktrt_stats *stats) {
  uint64_t leaks = 0;
  pktrt_scene *s = world_scene(&c->w, isa, 0);
  if (!s) abort();
  for (size_t first = 0; first < c->ray_count; first += CHUNK) {
    const size_t n = c->ray_count - first < CHUNK ? c->ray_count - first : CHUNK;
    bool hit[CHUNK];
    ask(s, first / CHUNK, c->rays + first, hit, n, stats);
    for (size_t j = 0; j < n; j++) {
      if (hit[j]) continue;
      if (leaks++ < 2) tell_leak(c, isa, first / CHUNK, &c->rays[first + j]);
    }
  }
  pktrt_scene_destroy(s);
  return leaks;
}

typedef bool plain_trace(const world *, const pktrt_ray *, pktrt_hit *);
static plain_trace *const plain_tests[2] = {ref_kensler_shirley, ref_moller_trumbore};
static const char *const plain_names[2] = {"Kensler-Shirley", "Moeller-Trumbore"};

/* Controls look at rays of one time, at the mesh as it is then: a tree over all places that it comes to would be of no
   use. */
static void control_leaks(const closed *c) {
  const float time = c->spots[c->spot_count - 1].time;
  const size_t most = c->w.m[0].nt > 512 ? 10 + thorough(1000) : thorough(30000);
  uint64_t rays = 0, leaks[2] = {0, 0};
  const still s = still_at(&c->w.m[0], time);
  world w = world_of(mesh_of(s.m->nv, s.m->nt));
  memcpy(w.m[0].p, s.p, sizeof *s.p * 3 * s.m->nv), memcpy(w.m[0].i, s.m->i, sizeof *s.m->i * 3 * s.m->nt);
  ref_plant(&w);
  for (size_t j = 0; j < c->ray_count && rays < most; j++) {
    if (c->rays[j].time != time) continue;
    pktrt_hit h;
    for (int k = 0; k < 2; k++) leaks[k] += !plain_tests[k](&w, &c->rays[j], &h);
    rays++;
  }
  for (int k = 0; k < 2; k++) control_figure("watertight", c->name, "leaks", plain_names[k], rays, leaks[k]);
  world_free(&w);
  free(s.p);
}

typedef struct closed_sum {
  uint64_t drawn, outside, culls;
} closed_sum;

/* Job i: a shape, the last first, since they take longer. */
static void closed_case(void *arg, size_t i) {
  const shape *f = &shapes[COUNT(shapes) - 1 - (i < LARGE ? i : i - LARGE)];
  const int level = i >= LARGE ? 3 : thoroughness >= 0.1 ? 7 : 5;
  closed_sum *sum = (closed_sum *)arg + i;
  pktrt_stats *stats = calloc(1, sizeof *stats);
  closed c;
  memset(&c, 0, sizeof c);
  c.seed = i + 1, c.w = world_of(shaped(f, level, c.seed));
  c.reach = f->stretch[0] < 1 || f->stretch[1] < 1 ? 0.9f : 1.1f;
  snprintf(c.name, sizeof c.name, "bumpy %u, %s", c.w.m[0].nt, f->name);
  c.spot_count = 8 + 4 * (uint32_t)thorough(64), c.ray_count = thorough(1000000);
  c.spots = calloc(c.spot_count, sizeof *c.spots), c.rays = calloc(c.ray_count, sizeof *c.rays);
  if (!stats || !c.spots || !c.rays) abort();
  draw_spots(&c);
  for (size_t first = 0; first < c.ray_count; first += CHUNK)
    aim(&c, first / CHUNK, c.rays + first, c.ray_count - first < CHUNK ? c.ray_count - first : CHUNK);
  for (int k = 0; k < isa_count; k++)
    count_figure("watertight", c.name, isas[k], c.ray_count, "leaks", leaks_of(&c, isas[k], stats));
  control_leaks(&c);
  *sum = (closed_sum){c.spot_count + c.outside, c.outside, stats->by_type[0].frustum_culls};
  world_free(&c.w);
  free(c.spots), free(c.rays), free(stats);
}

static void closed_meshes(void) {
  closed_sum each[LARGE + COUNT(shapes)], all = {0, 0, 0};
  memset(each, 0, sizeof each);
  jobs_for(COUNT(each), closed_case, each);
  for (size_t i = 0; i < COUNT(each); i++)
    all.drawn += each[i].drawn, all.outside += each[i].outside, all.culls += each[i].culls;
  say("%llu origins drawn, %llu of them not inside", (unsigned long long)all.drawn, (unsigned long long)all.outside);
  CHECK(thoroughness < 0.01 || all.outside > 0, "winding numbers decide");
  CHECK(thoroughness < 0.1 || all.culls > 0 || !has_frusta(PKTRT_ISA_AUTO), "packets are culled by four planes");
}

/* --- convex meshes ---

   Exactly convex: no vertex lies outside the plane of a triangle, of the vertices as they are rounded at each time
   that rays have. Scales and offsets are powers of two, and offsets there are only where coordinates have few bits.

   Rays are of three kinds. Lines without ends, from anywhere to anywhere: they cross 0 or 2 times. Rays from
   outside through an inner point (a fifth of the way or more from the surface) and a vertex or an edge, where they
   enter or leave: they may meet several triangles there, at one t or at neighbouring ones, but cross at least once
   in and then at least once out. And such rays by an edge, at 2^-24 to 2^-12 of its triangle's height: they cross
   exactly twice. A ray that meets an edge, as things are rounded, hits both its triangles: that is one crossing. */

typedef struct convex {
  const char *name;
  int level; /* of mesh_sphere; -1: a box */
  float scale, flat, offset;
  uint32_t keys;
} convex;

static const convex convexes[] = {
    {"convex 2048", 4, 1, 1, 0, 1},
    {"convex 512, 3 keys", 3, 1, 1, 0, 3},
    {"convex 512, scale 2^20", 3, 0x1p20f, 1, 0, 1},
    {"convex 512, flat 2^-13", 3, 1, 0x1p-13f, 0, 1},
    {"octahedron, offset 2^17", 0, 1, 1, 0x1p17f, 1},
    {"box, scale 2^-13", -1, 0x1p-13f, 1, 0, 1},
};

typedef enum course { LINE, BY_EDGE, AT_EDGE } course;

enum { TIMES = 16 };
typedef struct hull {
  const convex *f;
  uint64_t seed;
  world w;
  float times[TIMES];
  still at[TIMES];
  size_t ray_count;
} hull;

static bool is_convex(const still *s) {
  for (uint32_t t = 0; t < s->m->nt; t++) {
    const float *a = corner_of(s, t, 0), *b = corner_of(s, t, 1), *c = corner_of(s, t, 2);
    for (uint32_t i = 0; i < s->m->nv; i++)
      if (volume_sign(a, b, c, s->p + 3 * (size_t)i) < 0) return false;
  }
  return true;
}

static mesh convex_mesh(const convex *f) {
  mesh m = f->level < 0 ? mesh_box() : mesh_sphere(f->level, 0, 0);
  const float s = f->level < 0 ? f->scale / 2 : f->scale;
  if (f->keys > 1) mesh_move(&m, f->keys, 0.7f, 0, 0);
  mesh_place(&m, (float[3]){s, s * f->flat, s}, (float[3]){f->offset, f->offset, -f->offset});
  return m;
}

/* A point of a triangle: a vertex or an edge's; or inside, near the middle of an edge. */
static void near_edge(const still *s, bool inside, rng *r, float out[3]) {
  const uint32_t t = rng_below(r, s->m->nt), c = rng_below(r, 3);
  const float *a = corner_of(s, t, c), *b = corner_of(s, t, (c + 1) % 3), *opposite = corner_of(s, t, (c + 2) % 3);
  const float f = inside ? rng_range(r, 0.25f, 0.75f) : rng_below(r, 2) ? 0 : rng_unit(r);
  const float off = inside ? exp2f(rng_range(r, -24, -12)) : 0;
  for (int k = 0; k < 3; k++) {
    const float p = a[k] + f * (b[k] - a[k]);
    out[k] = p + off * (opposite[k] - p);
  }
}

static pktrt_ray line(const hull *h, rng *r) {
  float o[3], p[3];
  for (int k = 0; k < 3; k++) o[k] = 2 * h->f->scale * rng_sign(r), p[k] = h->f->scale * rng_sign(r);
  pktrt_ray x = ray_towards(o, p, 0);
  x.tmin = -INFINITY;
  return x;
}

/* Through an inner point and an edge: from half a size or more before the edge, or from two sizes before the inner
   point. */
static pktrt_ray through(const hull *h, const still *s, bool by_edge, rng *r) {
  const float *v = s->p + 3 * (size_t)rng_below(r, s->m->nv), f = 0.8f * rng_unit(r);
  const float c[3] = {h->f->offset, h->f->offset, -h->f->offset};
  const bool enters = rng_below(r, 2);
  float p[3], o[3];
  double q[3], d[3], l = 0;
  near_edge(s, by_edge, r, p);
  for (int k = 0; k < 3; k++) q[k] = (double)c[k] + (double)f * ((double)v[k] - (double)c[k]);
  for (int k = 0; k < 3; k++) d[k] = (double)p[k] - q[k], l += d[k] * d[k];
  const double sizes = enters ? 0.5 + (double)rng_unit(r) : -2 - 0.2 * (double)rng_unit(r);
  const double far = sizes * (double)h->f->scale / sqrt(l);
  for (int k = 0; k < 3; k++) o[k] = (float)((enters ? (double)p[k] : q[k]) + far * d[k]);
  return ray_towards(o, p, 0);
}

/* On flat meshes both sides may be at one t, and far away ends of lines lie on a grid, as the edges do. */
static course course_of(const hull *h, uint64_t ray) {
  return ray % 2 || h->f->flat < 1 || h->f->offset > 0 ? AT_EDGE : ray % 4 ? BY_EDGE : LINE;
}

static uint32_t time_of(const hull *h, uint64_t ray) {
  return h->f->keys > 1 ? (uint32_t)(mix64(ray ^ h->seed) % TIMES) : 0;
}

static pktrt_ray crossing_ray(const hull *h, uint64_t ray) {
  rng r = rng_of(h->seed << 40 ^ ray);
  const course kind = course_of(h, ray);
  const uint32_t at = time_of(h, ray);
  pktrt_ray x = kind == LINE ? line(h, &r) : through(h, &h->at[at], kind == BY_EDGE, &r);
  x.time = h->times[at];
  return x;
}

/* What a ray meets, one after the other: each hit is where the next one is looked for from. */
typedef struct crossings {
  int in, out;
  bool astray; /* in after out, or without end */
  uint32_t triangle;
  float t;
} crossings;

static double facing(const still *s, uint32_t triangle, const float d[3]) {
  double e[2][3], n = 0;
  for (uint32_t j = 0; j < 2; j++)
    for (int a = 0; a < 3; a++)
      e[j][a] = (double)corner_of(s, triangle, j + 1)[a] - (double)corner_of(s, triangle, 0)[a];
  for (int k = 0; k < 3; k++) {
    const int u = (k + 1) % 3, v = (k + 2) % 3;
    n += (e[0][u] * e[1][v] - e[0][v] * e[1][u]) * (double)d[k];
  }
  return n;
}

static bool share_edge(const mesh *m, uint32_t s, uint32_t t) {
  int common = 0;
  for (int i = 0; i < 9; i++) common += m->i[3 * (size_t)s + (size_t)i / 3] == m->i[3 * (size_t)t + (size_t)i % 3];
  return common == 2;
}

static void cross(const hull *h, uint64_t ray, const pktrt_ray *x, const pktrt_hit *hit, crossings *c) {
  const still *s = &h->at[time_of(h, ray)];
  const bool in = facing(s, hit->triangle, x->direction) < 0;
  const bool first = c->in + c->out == 0, same = !first && in == (facing(s, c->triangle, x->direction) < 0);
  if (!(same && share_edge(s->m, c->triangle, hit->triangle) && hit->t - c->t <= 0x1p-20f * fabsf(hit->t))) {
    c->in += in, c->out += !in;
    c->astray |= (in && c->out > 0) || c->in + c->out > 24;
  }
  c->triangle = hit->triangle, c->t = hit->t;
}

static bool wrong(course kind, const crossings *c) {
  if (c->astray) return true;
  if (kind == AT_EDGE) return c->in < 1 || c->out < 1;
  return !(c->in == 1 && c->out == 1) && (kind == BY_EDGE || c->in + c->out > 0);
}

static uint64_t wrong_of_chunk(const hull *h, const pktrt_scene *s, uint64_t chunk, size_t n, uint64_t *lines) {
  pktrt_query_desc q;
  pktrt_ray rays[CHUNK];
  pktrt_hit hits[CHUNK];
  crossings c[CHUNK];
  uint64_t at[CHUNK], sum = 0;
  memset(&q, 0, sizeof q), memset(c, 0, sizeof c);
  q.path = mix64(chunk) % 16 == 0 ? PKTRT_PATH_PAPER : mix64(chunk) % 16 < 4 ? PKTRT_PATH_SINGLE : PKTRT_PATH_FAST;
  for (size_t j = 0; j < n; j++) at[j] = j, rays[j] = crossing_ray(h, chunk * CHUNK + j);
  for (size_t left = n, next; left; left = next) {
    pktrt_intersect_ex(s, &q, rays, hits, left);
    next = 0;
    for (size_t j = 0; j < left; j++) {
      if (hits[j].mesh == PKTRT_NONE) continue;
      cross(h, chunk * CHUNK + at[j], &rays[j], &hits[j], &c[at[j]]);
      if (c[at[j]].astray) continue;
      rays[j].tmin = hits[j].t;
      at[next] = at[j], rays[next++] = rays[j];
    }
  }
  for (size_t j = 0; j < n; j++) {
    const course kind = course_of(h, chunk * CHUNK + j);
    if (!wrong(kind, &c[j])) continue;
    if (kind == AT_EDGE) sum++;
    else ++*lines;
    CHECK(false, "%s, ray %llu, kind %d: %d in, %d out", h->f->name, (unsigned long long)(chunk * CHUNK + j), (int)kind,
        c[j].in, c[j].out);
  }
  return sum;
}

/* How many of rays 0 to n - 1 are lines or pass by an edge. */
static uint64_t lines_among(const hull *h, uint64_t n) {
  uint64_t sum = 0;
  for (uint64_t i = 0; i < n; i++) sum += course_of(h, i) != AT_EDGE;
  return sum;
}

static const char *const line_wrong = "lines that cross neither 0 nor 2 times";
static const char *const edge_wrong = "edges without entry or exit";

static void control_crossings(const hull *h, int test) {
  const uint64_t n = h->ray_count < thorough(50000) ? h->ray_count : thorough(50000);
  uint64_t edges = 0, lines = 0;
  for (uint64_t i = 0; i < n; i++) {
    pktrt_ray x = crossing_ray(h, i);
    pktrt_hit hit;
    crossings c = {0, 0, false, 0, 0};
    while (!c.astray && plain_tests[test](&h->w, &x, &hit)) cross(h, i, &x, &hit, &c), x.tmin = hit.t;
    const course kind = course_of(h, i);
    if (kind == AT_EDGE) edges += wrong(kind, &c);
    else lines += wrong(kind, &c);
  }
  const uint64_t of = lines_among(h, n);
  if (of) control_figure("watertight", h->f->name, line_wrong, plain_names[test], of, lines);
  control_figure("watertight", h->f->name, edge_wrong, plain_names[test], n - of, edges);
}

static void count_crossings(const hull *h, pktrt_isa isa) {
  uint64_t edges = 0, lines = 0;
  pktrt_scene *s = world_scene(&h->w, isa, 0);
  for (size_t first = 0; s && first < h->ray_count; first += CHUNK)
    edges += wrong_of_chunk(h, s, first / CHUNK, h->ray_count - first < CHUNK ? h->ray_count - first : CHUNK, &lines);
  pktrt_scene_destroy(s);
  const uint64_t of = lines_among(h, h->ray_count);
  if (of) count_figure("watertight", h->f->name, isa, of, line_wrong, lines);
  count_figure("watertight", h->f->name, isa, h->ray_count - of, edge_wrong, edges);
}

static void convex_case(void *arg, size_t i) {
  hull h;
  (void)arg;
  memset(&h, 0, sizeof h);
  h.f = &convexes[i], h.seed = 100 + i, h.ray_count = thorough(1000000);
  h.w = world_of(convex_mesh(h.f));
  const uint32_t times = h.f->keys > 1 ? TIMES : 1;
  rng r = rng_of(h.seed);
  for (uint32_t k = 0; k < times; k++) {
    h.times[k] = rng_unit(&r), h.at[k] = still_at(&h.w.m[0], h.times[k]);
    CHECK(is_convex(&h.at[k]), "%s is convex", h.f->name);
  }
  for (int k = 0; k < isa_count; k++) count_crossings(&h, isas[k]);
  ref_plant(&h.w);
  for (int k = 0; k < 2; k++) control_crossings(&h, k);
  for (uint32_t k = 0; k < times; k++) free(h.at[k].p);
  world_free(&h.w);
}

static void convex_meshes(void) {
  mesh bumpy = mesh_sphere(3, 0.03f, 1);
  const still s = still_at(&bumpy, 0);
  CHECK(!is_convex(&s), "a bumpy mesh is not convex");
  free(s.p), mesh_free(&bumpy);
  jobs_for(COUNT(convexes), convex_case, NULL);
}

void suite_stability_watertight(void) {
  run("stable: winding numbers are the same along all axes", winding_numbers);
  run("stable: closed meshes do not leak at vertices and edges", closed_meshes);
  run("stable: convex meshes are crossed twice or not at all", convex_meshes);
}
