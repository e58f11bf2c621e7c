/* Hits are those of exact arithmetic: against the oracle of oracle.h, which shares no code with the library, on scenes and rays that
   are hard. Each ray is answered by a single call, by many-ray calls of both paths, and by all its crossings in order; closed
   meshes are asked for the winding number of the ray's origin. Controls: two textbook tests in floats, and stepping from hit to
   hit by tmin. */
#include "oracle.h"
#include "stability.h"

/* --- scenes --- */

static mesh series(rng *r) { /* of sizes towards a point */
  mesh m = mesh_of(3 * 5000, 5000);
  float size = 1;
  for (uint32_t v = 0; v < m.nv; v++) {
    if (v % 3 == 0) size *= 0.995f;
    for (int a = 0; a < 3; a++) m.p[3 * v + (uint32_t)a] = size * (1 + 0.5f * rng_sign(r));
    m.i[v] = v;
  }
  return m;
}

static mesh needles(rng *r, float thin) { /* one in four shorter than it is thin: of no shape */
  mesh m = mesh_of(3 * 600, 600);
  for (uint32_t t = 0; t < m.nt; t++) {
    float o[3], along[3];
    for (int a = 0; a < 3; a++) o[a] = rng_sign(r), along[a] = rng_sign(r) * (t % 4 ? 1 : thin);
    for (uint32_t c = 0; c < 3; c++) {
      const float part = c == 0 ? 0 : c == 1 ? 1 : rng_unit(r);
      for (uint32_t a = 0; a < 3; a++) m.p[9 * t + 3 * c + a] = o[a] + part * along[a] + thin * rng_sign(r);
      m.i[3 * t + c] = 3 * t + c;
    }
  }
  return m;
}

static mesh mixture(rng *r) { /* of scales within a scene */
  mesh m = mesh_soup(600, 1, rng_u32(r));
  for (uint32_t t = 0; t < m.nt; t++) {
    const float scale = exp2f(rng_range(r, -60, 0));
    for (uint32_t i = 0; i < 9; i++) m.p[9 * t + i] *= scale;
  }
  return m;
}

/* A closed mesh whose vertices are rounded to a grid: neighbours become one, and triangles lines and points. */
static mesh coarse(int level, float grid, float offset) {
  mesh m = mesh_sphere(level, 0.05f, 7);
  for (uint32_t i = 0; i < 3 * m.nv; i++) m.p[i] = roundf(m.p[i] / grid) * grid;
  mesh_place(&m, (float[3]){1, 1, 1}, (float[3]){offset, -offset, offset});
  return m;
}

static mesh keyed(mesh m, uint32_t keys, uint64_t seed) {
  mesh_move(&m, keys, 1.3f, 0.3f, seed);
  return m;
}

/* Moves so that triangles are flat at a key, or turned over after it. */
static mesh turning(mesh m, float last) {
  mesh_move(&m, 2, 0, 0, 1);
  float *key = m.p + 3 * (size_t)m.nv;
  for (uint32_t v = 0; v < m.nv; v++) key[3 * v + 1] *= last;
  return m;
}

enum { SCENES = 19 };
typedef struct hard {
  const char *name;
  mesh m;
  bool closed;
} hard;

static hard hard_scene(size_t i) {
  rng r = rng_of(900 + i);
  const float far_ = 1e5f;
  switch (i) {
  case 0: return (hard){"globe 131072, offset 1e5", coarse(7, 0x1p-7f, far_), true};
  case 1: return (hard){"series of 5000 sizes", series(&r), false};
  case 2: return (hard){"soup", mesh_soup(2000, 0.3f, 3), false};
  case 3: return (hard){"mixture of scales", mixture(&r), false};
  case 4: return (hard){"needles 1e-6", needles(&r, 1e-6f), false};
  case 5: return (hard){"needles 1e-12", needles(&r, 1e-12f), false};
  case 6: return (hard){"grid, rays along axes", mesh_grid(64, 1), false};
  case 7: return (hard){"coarse 2^-4", coarse(5, 0x1p-4f, 0), true};
  case 8: return (hard){"coarse 2^-2, offset 1e3", coarse(5, 0x1p-2f, 1e3f), true};
  case 9: return (hard){"globe, offset 1e6", coarse(4, 0x1p-10f, 1e6f), true};
  case 10: return (hard){"soup, 2 keys", keyed(mesh_soup(500, 0.3f, 4), 2, 5), false};
  case 11: return (hard){"globe, 3 keys", keyed(coarse(3, 0x1p-6f, 0), 3, 6), true};
  case 12: return (hard){"soup, 5 keys", keyed(mesh_soup(500, 0.3f, 8), 5, 7), false};
  case 13: return (hard){"globe, flat at a key", turning(coarse(3, 0x1p-10f, 0), 0), true};
  case 14: return (hard){"globe, turned over", turning(coarse(3, 0x1p-10f, 0), -1), true};
  case 15: return (hard){"copies", mesh_copies(&(mesh){0}, 0), false};
  case 16: return (hard){"scale 2^-126", mesh_soup(500, 0.3f, 9), false};
  case 17: return (hard){"scale 2^-70", mesh_soup(500, 0.3f, 10), false};
  default: return (hard){"scale 2^97", mesh_soup(500, 0.3f, 11), false};
  }
}

static world world_of_scene(size_t i, hard *h) {
  if (i == 15) {
    mesh box = coarse(2, 0x1p-6f, 0);
    h->name = "three copies", h->m = mesh_copies(&box, 3), h->closed = true;
    mesh_free(&box);
  } else {
    *h = hard_scene(i);
  }
  world w = world_of(h->m);
  if (i >= 16) world_place(&w, i == 16 ? 0x1p-126f : i == 17 ? 0x1p-70f : 0x1p97f, 0, 0, 0);
  return w;
}

/* --- rays --- */

static void blend(float p[3][3], const float part[3], float out[3]) {
  for (int a = 0; a < 3; a++) out[a] = part[0] * p[0][a] + part[1] * p[1][a] + part[2] * p[2][a];
}

/* At a triangle: inside it, at an edge or a vertex; along an edge, in its plane, or grazing that by down to 1e-8. */
static pktrt_ray hard_ray(const oracle_soup *s, float size, float time, rng *r) {
  float(*p)[3] = s->p[rng_below(r, (uint32_t)s->n)], part[3], target[3], other[3], origin[3];
  const uint32_t kind = rng_below(r, 8), c = rng_below(r, 3);
  part[0] = rng_unit(r), part[1] = (1 - part[0]) * rng_unit(r), part[2] = 1 - part[0] - part[1];
  if (kind % 4 == 1) part[c] = 0, part[(c + 1) % 3] = 1 - part[(c + 2) % 3];
  if (kind % 4 == 2) part[c] = 1, part[(c + 1) % 3] = part[(c + 2) % 3] = 0;
  blend(p, part, target);
  if (kind == 7) memcpy(target, p[c], sizeof target), memcpy(other, p[(c + 1) % 3], sizeof other); /* along an edge */
  else blend(p, (float[3]){rng_sign(r), rng_sign(r), rng_sign(r)}, other);
  const float far_ = exp2f(rng_range(r, -3, 4)), lift = kind == 5 ? exp2f(rng_range(r, -27, -4)) : 0;
  for (int a = 0; a < 3; a++) {
    const float away = kind >= 5 ? target[a] - other[a] + lift * size * rng_sign(r) : size * rng_sign(r);
    origin[a] = target[a] + far_ * away;
  }
  pktrt_ray x = ray_towards(origin, target, time);
  if (kind == 6) x.tmin = -INFINITY;
  if (kind == 4 && rng_below(r, 2)) /* along an axis, as through a grid */
    for (int a = 0; a < 3; a++) x.direction[a] = a == (int)c ? 1 : 0, x.origin[a] = a == (int)c ? origin[a] : target[a];
  return x;
}

/* --- what is asked --- */

enum { TIMES = 6, MOST = 64, CHUNK = 128 };
typedef struct verdicts {
  uint64_t rays, triangles, lists, windings, closed; /* the last: of rays that were asked for windings */
  uint64_t chains, differ;                           /* of lists, one call for each crossing */
  uint64_t asked, plain[2], stepping, by_normals;    /* controls, the two of those that were asked */
} verdicts;

/* Whether a chain of calls gives the same list. */
static bool chain_differs(const pktrt_scene *s, const pktrt_ray *ray, const pktrt_hit *all, size_t n) {
  pktrt_hit at;
  size_t i = 0;
  for (bool on = pktrt_intersect_after(s, ray, NULL, &at); on; on = pktrt_intersect_after(s, ray, &at, &at), i++)
    if (i < MOST && !same_bits(&at, &all[i], sizeof at)) return true;
  return i != n;
}

static bool stepping_loses(const pktrt_scene *s, pktrt_ray ray, size_t n) {
  pktrt_hit at;
  size_t i = 0;
  for (; i < n && pktrt_intersect(s, &ray, &at); i++) ray.tmin = at.t;
  return i < n;
}

/* What the oracle says of a ray, once for all instruction sets. */
typedef struct truth {
  pktrt_ray ray;
  oracle_list list;
  int winds;            /* around the ray's origin */
  bool surely, winding; /* whether it is a ray at all; whether the origin is not on the surface */
} truth;

static truth truth_of(const oracle_soup *soup, const pktrt_ray *ray, bool closed) {
  static const float side[3][3] = {{0.3f, 0.5f, -0.8f}, {-0.7f, 0.2f, 0.6f}, {0.1f, -0.9f, 0.4f}};
  truth is = {*ray, {NULL, 0, 0}, 0, ref_valid(ray), closed};
  oracle_list list = {NULL, 0, 0};
  if (!is.surely) return is;
  oracle_crossings(soup, ray, &is.list);
  for (int k = 0; closed && k < 3; k++) { /* on the way to three sides nothing is at 0 */
    const pktrt_ray x = pktrt_make_ray(ray->origin, side[k]);
    oracle_crossings(soup, &x, &list);
    for (size_t i = 0; i < list.n; i++) is.winding = is.winding && list.at[i].ahead;
    is.winds = oracle_winding(&list);
  }
  oracle_list_free(&list);
  return is;
}

/* Asks for the winding number of a ray's origin. The control counts by the signs of float normals. */
static void ask_winding(const pktrt_scene *s, const truth *is, verdicts *v) {
  const pktrt_ray *ray = &is->ray;
  int winds = is->winds;
  v->closed++, v->windings += pktrt_winding(s, 0, ray->origin, ray->time) != winds;
  pktrt_ray ahead = pktrt_make_ray(ray->origin, (const float[3]){1, 0, 0});
  pktrt_hit at;
  for (ahead.time = ray->time; pktrt_intersect(s, &ahead, &at); ahead.tmin = at.t) winds -= at.normal[0] > 0 ? 1 : -1;
  v->by_normals += winds != 0;
}

static void judge(const char *name, const oracle_soup *soup, const pktrt_scene *s, const truth *is,
    const pktrt_hit got[3], verdicts *v) {
  const pktrt_ray *ray = &is->ray;
  pktrt_hit all[MOST];
  v->rays++;
  for (int k = 0; k < 3; k++) {
    const char *what = oracle_objection(soup, ray, &is->list, &got[k], got[k].mesh != PKTRT_NONE, 1);
    v->triangles += what != NULL;
    CHECK(!what, "%s: way %d: %s; o %a %a %a d %a %a %a time %a", name, k, what, (double)ray->origin[0],
        (double)ray->origin[1], (double)ray->origin[2], (double)ray->direction[0], (double)ray->direction[1],
        (double)ray->direction[2], (double)ray->time);
  }
  const size_t n = pktrt_intersect_all(s, ray, all, MOST);
  size_t least, most;
  oracle_count(ray, &is->list, &least, &most);
  const char *what = oracle_objection(soup, ray, &is->list, all, n < MOST ? n : MOST, MOST);
  if (n < least || n > most) what = "not as many as there are";
  v->lists += what != NULL;
  CHECK(!what, "%s: list of %zu: %s", name, n, what);
  if (is->winding) ask_winding(s, is, v);
  if (v->rays % 4) return; /* what follows looks for each crossing anew */
  v->chains++, v->differ += chain_differs(s, ray, all, n), v->stepping += stepping_loses(s, *ray, n);
}

/* Asks the textbook's tests, of few rays: they look at every triangle. */
static void judge_plain(const oracle_soup *soup, const world *w, const truth *is, const pktrt_hit *got, verdicts *v) {
  pktrt_hit h;
  v->asked++;
  ref_moller_trumbore(w, &is->ray, &h);
  memcpy(h.normal, got->normal, sizeof h.normal);
  v->plain[0] += oracle_objection(soup, &is->ray, &is->list, &h, h.mesh != PKTRT_NONE, 1) != NULL;
  ref_kensler_shirley(w, &is->ray, &h);
  memcpy(h.normal, got->normal, sizeof h.normal);
  v->plain[1] += oracle_objection(soup, &is->ray, &is->list, &h, h.mesh != PKTRT_NONE, 1) != NULL;
}

static void ask_chunk(const hard *h, const oracle_soup *soup, const world *w, const pktrt_scene *s, const truth *is,
    size_t n, bool plain, verdicts *v) {
  pktrt_ray rays[CHUNK];
  pktrt_hit many[CHUNK], paper[CHUNK];
  pktrt_query_desc q;
  memset(&q, 0, sizeof q);
  q.path = PKTRT_PATH_PAPER;
  for (size_t i = 0; i < n; i++) rays[i] = is[i].ray;
  pktrt_intersect_n(s, rays, many, n);
  pktrt_intersect_ex(s, &q, rays, paper, n);
  for (size_t i = 0; i < n; i++) {
    pktrt_hit got[3];
    pktrt_intersect(s, &rays[i], &got[0]);
    got[1] = many[i], got[2] = paper[i];
    if (is[i].surely) judge(h->name, soup, s, &is[i], got, v);
    if (is[i].surely && plain && i % 8 == 0) judge_plain(soup, w, &is[i], &got[0], v);
  }
}

/* A million of all together: of the globe and the series ten thousand, which cross hundreds of triangles, of scales that are
   mixed two thousand, most of which need expansions. */
static size_t rays_of_case(size_t i) {
  if (thoroughness < 0.1) return thoroughness < 0.005 ? 15 : 50;
  return thorough(i < 2 ? 10000 : i == 3 ? 2000 : 63000);
}

static void exact_case(void *arg, size_t i) {
  hard h;
  world w = world_of_scene(i, &h);
  const int times = w.m[0].keys > 1 ? TIMES : 1;
  const size_t n = rays_of_case(i) / (size_t)times + 1;
  (void)arg;
  oracle_soup soup[TIMES];
  float time[TIMES];
  ref_plant(&w);
  rng r = rng_of(i + 50);
  for (int t = 0; t < times; t++) {
    time[t] = t < 2 ? (float)t : rng_unit(&r), soup[t] = oracle_soup_of(&w, time[t]);
    oracle_plant(&soup[t]);
  }
  verdicts all[8];
  pktrt_scene *s[8] = {NULL};
  pktrt_scene_info info;
  memset(all, 0, sizeof all);
  for (int k = 0; k < isa_count; k++) s[k] = world_scene(&w, isas[k], 0);
  pktrt_get_scene_info(s[0], &info);
  const float size = info.bounds_hi[0] - info.bounds_lo[0];
  for (int t = 0; t < times; t++)
    for (size_t done = 0; done < n; done += CHUNK) {
      const size_t some = n - done < CHUNK ? n - done : CHUNK;
      truth is[CHUNK];
      for (size_t j = 0; j < some; j++) {
        const pktrt_ray x = hard_ray(&soup[t], size, time[t], &r);
        is[j] = truth_of(&soup[t], &x, h.closed);
      }
      for (int k = 0; k < isa_count; k++)
        ask_chunk(&h, &soup[t], &w, s[k], is, some, k == 0 && (i >= 2 || done % (8 * CHUNK) == 0), &all[k]);
      for (size_t j = 0; j < some; j++) oracle_list_free(&is[j].list);
    }
  for (int k = 0; k < isa_count; k++) {
    const verdicts *v = &all[k];
    pktrt_scene_destroy(s[k]);
    count_figure("exact", h.name, isas[k], 3 * v->rays, "wrong hits and misses", v->triangles);
    count_figure("exact", h.name, isas[k], v->rays, "wrong lists of crossings", v->lists);
    if (v->closed) count_figure("exact", h.name, isas[k], v->closed, "wrong winding numbers", v->windings);
    if (v->closed)
      control_figure("exact", h.name, "wrong winding numbers", "stepping by tmin", v->closed, v->by_normals);
    if (v->asked) control_figure("exact", h.name, "wrong hits and misses", "Moeller-Trumbore", v->asked, v->plain[0]);
    if (v->asked) control_figure("exact", h.name, "wrong hits and misses", "Kensler-Shirley", v->asked, v->plain[1]);
    count_figure("exact", h.name, isas[k], v->chains, "chains of calls unlike lists", v->differ);
    control_figure("exact", h.name, "chains of calls unlike lists", "stepping by tmin", v->chains, v->stepping);
    control_figure("exact", h.name, "wrong lists of crossings", "stepping by tmin", v->chains, v->stepping);
  }
  for (int t = 0; t < times; t++) oracle_soup_free(&soup[t]);
  world_free(&w);
}

static void exact_cases(void) { jobs_for(SCENES, exact_case, NULL); }

/* --- corners that doubles take for the ray's own --- */

/* Makes a ray and a triangle with a corner beside the ray, so near that doubles cannot tell. At the corner's depth the ray has gone aside
   by depth times slope; the corner lies where this product is, rounded to a double. So the distance is what was rounded off. Returns
   false if the numbers drawn give no such case. */
static bool make_beside(rng *r, pktrt_ray *ray, float p[3][3]) {
  const float depth = 1, origin = -ldexpf((float)(1 + 2 * rng_below(r, 1 << 20)), -44);
  const float slope = 0.5f * rng_unit(r);
  const double away = (double)depth - (double)origin, product = away * (double)slope;
  const float high = (float)product, low = (float)(product - (double)high);
  if ((double)high + (double)low < product || (double)high + (double)low > product)
    return false;                                               /* two floats do not hold it */
  if (!(fma(away, (double)slope, -product) != 0)) return false; /* nothing was rounded */
  *ray = ray_of(-low, 0, origin, slope, 0, 1);
  const float at[3][3] = {{high, 0, depth}, {high + 1, -1, depth}, {high + 1, 1, depth}};
  memcpy(p, at, sizeof at);
  if (rng_below(r, 2)) p[1][0] = p[2][0] = high - 1; /* on the other side */
  return true;
}
static void corners_beside_rays(void) {
  enum { TRIES = 40000 };
  size_t tried = 0, wrong = 0, crossed = 0;
  rng r = rng_of(77);
  for (size_t i = 0; i < (small_run ? TRIES / 8 : TRIES); i++) {
    pktrt_ray ray;
    float p[3][3];
    if (!make_beside(&r, &ray, p)) continue;
    const pktrt_scene_desc of = scene_desc_of(PKTRT_ISA_AUTO, 0);
    pktrt_scene *s = pktrt_scene_create(&of);
    pktrt_mesh_desc d;
    pktrt_hit hit;
    memset(&d, 0, sizeof d);
    d.positions = p[0], d.vertex_count = 3, d.triangle_count = 1;
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
    const bool want = oracle_crosses(&ray, p) != 0;
    wrong += pktrt_intersect(s, &ray, &hit) != want || pktrt_occluded(s, &ray) != want;
    tried++, crossed += want;
    pktrt_scene_destroy(s);
  }
  CHECK(wrong == 0 && tried > 20 && crossed > 5 && crossed < tried, "%zu wrong of %zu, %zu crossed", wrong, tried,
      crossed);
  say("%zu rays pass a corner by less than a rounding: %zu cross its triangle, %zu wrong", tried, crossed, wrong);
}

/* --- closed meshes --- */

/* Globes of radius 1 or so, rounded to grids; where they lie floats round them too. */
static const struct {
  float grid, offset;
} globes[] = {
    {0x1p-12f, 0}, {0x1p-7f, 0}, {0x1p-5f, 0}, {0x1p-3f, 0}, {0x1p-9f, 1e3f}, {0x1p-7f, 1e5f}, {0x1p-10f, 1e6f}};

enum { BUNDLE = 64, CALL = 4 * BUNDLE };
typedef struct leaks { /* how many of how many */
  uint64_t rays, lost, plain[2], crossings, parity, points, winds, stepped, wrong;
} leaks;

/* From within the ball of half the radius, or from around the globe, to vertices and edges: bundles of 64 from one place to
   neighbours. */
static void aim_at(const mesh *m, float offset, bool inside, rng *r, pktrt_ray out[CALL]) {
  float o[3];
  uint32_t first = 0;
  for (int j = 0; j < CALL; j++) {
    if (j % BUNDLE == 0) {
      const float far_ = inside ? 0.28f : 2;
      for (int a = 0; a < 3; a++) o[a] = far_ * rng_sign(r);
      if (!inside) o[rng_below(r, 3)] = rng_below(r, 2) ? 2 : -2;
      for (int a = 0; a < 3; a++) o[a] += a == 1 ? -offset : offset;
      first = rng_below(r, m->nt);
    }
    const uint32_t *corner = m->i + 3 * (size_t)((first + rng_below(r, 64)) % m->nt), c = rng_below(r, 3);
    const float *p = m->p + 3 * (size_t)corner[c], *q = m->p + 3 * (size_t)corner[(c + 1) % 3];
    const float f = rng_below(r, 2) ? 0 : rng_unit(r);
    float target[3];
    for (int a = 0; a < 3; a++) target[a] = p[a] + f * (q[a] - p[a]);
    out[j] = ray_towards(o, target, 0);
  }
}

static size_t count_lost(const pktrt_scene *s, const pktrt_ray rays[CALL], uint64_t way) {
  pktrt_hit hit[CALL];
  bool occluded[CALL];
  size_t n = 0;
  if (way % 16 == 0) {
    for (int j = 0; j < CALL; j++)
      n += !(way & 16 ? pktrt_occluded(s, &rays[j]) : pktrt_intersect(s, &rays[j], &hit[j]));
  } else if (way % 3) {
    pktrt_intersect_n(s, rays, hit, CALL);
    for (int j = 0; j < CALL; j++) n += hit[j].mesh == PKTRT_NONE;
  } else {
    pktrt_occluded_n(s, rays, occluded, CALL);
    for (int j = 0; j < CALL; j++) n += !occluded[j];
  }
  return n;
}

/* From within a number that is odd cross the surface, from around it an even one, and the winding number is 1 or 0. The control
   counts by stepping with tmin. */
static void count_crossings(const pktrt_scene *s, const pktrt_ray rays[CALL], bool inside, leaks *to) {
  int winds[CALL];
  float points[CALL][3];
  for (int j = 0; j < CALL; j++) {
    pktrt_ray x = rays[j];
    const size_t n = pktrt_intersect_all(s, &x, NULL, 0);
    to->crossings++, to->parity += n % 2 != (inside ? 1 : 0);
    if (j % 64 == 0) {
      pktrt_hit at;
      size_t stepped = 0;
      for (; stepped < 64 && pktrt_intersect(s, &x, &at); stepped++) x.tmin = at.t;
      to->stepped++, to->wrong += stepped % 2 != (inside ? 1 : 0);
    }
    memcpy(points[j], rays[j].origin, sizeof points[j]);
    for (int a = 0; a < 3; a++) points[j][a] += inside ? 0.1f * rays[j].direction[a] : 0;
  }
  pktrt_winding_n(s, 0, points[0], 0, winds, CALL);
  for (int j = 0; j < CALL; j++) to->points++, to->winds += winds[j] != (inside ? 1 : 0);
}

/* Part i of a globe's rays; scalar kernels, which take long, get a tenth. */
static void closed_globe(void *arg, size_t i) {
  const size_t g = i % COUNT(globes), parts = *(const size_t *)arg;
  const uint64_t rays = (thoroughness < 1 ? thorough(20000000) : 1000000000) / (3 * COUNT(globes) * parts) + 1;
  world w = world_of(coarse(g < 4 ? 6 : 5, globes[g].grid, globes[g].offset));
  pktrt_scene *s[8];
  leaks all[8];
  char name[64];
  memset(all, 0, sizeof all);
  ref_plant(&w);
  snprintf(
      name, sizeof name, "globe %u, grid %g, offset %g", w.m[0].nt, (double)globes[g].grid, (double)globes[g].offset);
  for (int k = 0; k < isa_count; k++) s[k] = world_scene(&w, isas[k], 0);
  rng r = rng_of(7000 + i);
  for (uint64_t call = 0; call * CALL < rays; call++) {
    pktrt_ray inside[CALL], around[CALL];
    aim_at(&w.m[0], globes[g].offset, true, &r, inside);
    if (call % 16 == 0) aim_at(&w.m[0], globes[g].offset, false, &r, around);
    for (int k = 0; k < isa_count; k++) {
      if (isas[k] == PKTRT_ISA_SCALAR && call % 10) continue;
      for (int j = 0; k == 0 && j < CALL; j += call % 8 ? CALL : BUNDLE) {
        pktrt_hit h;
        all[k].plain[0]++, all[k].plain[1] += !ref_moller_trumbore(&w, &inside[j], &h);
      }
      all[k].rays += CALL, all[k].lost += count_lost(s[k], inside, mix64(call));
      if (call % 16 == 0) count_crossings(s[k], inside, true, &all[k]), count_crossings(s[k], around, false, &all[k]);
    }
  }
  for (int k = 0; k < isa_count; k++) {
    pktrt_scene_destroy(s[k]);
    count_figure("exact", name, isas[k], all[k].rays, "leaks", all[k].lost);
    if (k == 0) control_figure("exact", name, "leaks", "Moeller-Trumbore", all[k].plain[0], all[k].plain[1]);
    count_figure("exact", name, isas[k], all[k].crossings, "wrong counts of crossings", all[k].parity);
    count_figure("exact", name, isas[k], all[k].points, "wrong winding numbers", all[k].winds);
    control_figure("exact", name, "wrong counts of crossings", "stepping by tmin", all[k].stepped, all[k].wrong);
  }
  world_free(&w);
}

static void closed_globes(void) {
  size_t parts = thoroughness < 1 ? 1 : 4;
  jobs_for(COUNT(globes) * parts, closed_globe, &parts);
}

void suite_stability_exact(void) {
  run("stable: a corner beside a ray by less than a double's rounding is on its side", corners_beside_rays);
  run("stable: hits, lists of crossings and winding numbers are those of exact arithmetic", exact_cases);
  run("stable: closed meshes with collapsed triangles do not leak, and each ray crosses them as often as it must",
      closed_globes);
}
