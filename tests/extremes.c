/* What lies at the ends of the range of floats: depths beyond it, triangles whose coordinates differ by all its exponents, slivers
   that rounding makes, u and v on edges. Against the oracle in exact arithmetic. */
#include "oracle.h"

/* --- depths beyond floats, and ends of all queries --- */

enum { SMALL_MESHES = 2, SMALL_VERTICES = 9, SMALL_TRIANGLES = 8, RAYS = 40 };

static float float_of_bits(uint32_t bits) {
  float x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

/* Returns a coordinate of any exponent, or one of few values, so that vertices meet. */
static float any_coordinate(rng *r, uint32_t kind) {
  if (kind == 0) return (float)(int)rng_below(r, 5) - 2;
  const float x = float_of_bits(rng_u32(r));
  if (kind == 1) return fabsf(x) <= PKTRT_MAX_COORD ? x : 0;
  return ldexpf(rng_sign(r), (int)rng_below(r, 30) + 60); /* about 1e17 to 1e27 */
}

static world any_world(rng *r) {
  world w = world_none();
  w.n = 1 + rng_below(r, SMALL_MESHES);
  for (uint32_t m = 0; m < w.n; m++) {
    const uint32_t kind = rng_below(r, 3), keys = rng_below(r, 4) ? 1 : 3;
    mesh to = mesh_of(SMALL_VERTICES, SMALL_TRIANGLES);
    if (keys > 1) to.p = realloc(to.p, keys * SMALL_VERTICES * 3 * sizeof *to.p), to.keys = keys;
    if (!to.p) abort();
    for (uint32_t i = 0; i < keys * SMALL_VERTICES * 3; i++) to.p[i] = any_coordinate(r, kind);
    for (uint32_t i = 0; i < 3 * SMALL_TRIANGLES; i++) to.i[i] = rng_below(r, SMALL_VERTICES);
    w.m[m] = to;
  }
  return w;
}

/* Returns a ray of any bits, or one towards a triangle whose direction is as short or as long as floats are, backwards too. */
static pktrt_ray any_ray(const world *w, rng *r) {
  const uint32_t kind = rng_below(r, 8);
  pktrt_ray x;
  for (int a = 0; a < 3; a++) {
    x.origin[a] = any_coordinate(r, kind % 3), x.direction[a] = float_of_bits(rng_u32(r));
    if (kind == 3) x.origin[a] = float_of_bits(rng_u32(r));
  }
  x.tmin = float_of_bits(rng_u32(r)), x.tmax = float_of_bits(rng_u32(r)), x.time = float_of_bits(rng_u32(r));
  if (kind & 1) x.tmin = -INFINITY;
  if (kind & 2) x.tmax = INFINITY;
  if (kind < 3) return x;

  const mesh *m = &w->m[rng_below(r, w->n)];
  const uint32_t *corner = m->i + 3 * rng_below(r, m->nt);
  const float length = ldexpf(rng_unit(r) < 0.5f ? 1.f : -1.f, -(int)rng_below(r, 170));
  double way[3], most = 0;
  for (int a = 0; a < 3; a++) {
    double middle = 0;
    for (int c = 0; c < 3; c++) middle += (double)m->p[3 * corner[c] + (uint32_t)a] / 3;
    way[a] = middle - (double)x.origin[a], most = fmax(most, fabs(way[a]));
  }
  for (int a = 0; a < 3 && most > 0; a++) x.direction[a] = (float)(way[a] / most * (double)length);
  return x;
}

typedef struct ends_count {
  size_t rays, crossings, hits, beyond, outside, endless, wrong;
} ends_count;

static bool comes_after(const pktrt_hit *a, const pktrt_hit *b) {
  if (a->t != b->t) return a->t > b->t;
  return a->mesh != b->mesh ? a->mesh > b->mesh : a->triangle > b->triangle;
}

/* Follows the chain of a ray's hits, in no more steps than there are triangles. Returns its length; SIZE_MAX: it has no end. */
static size_t chain_of(const pktrt_scene *s, const pktrt_ray *r, size_t triangles, ends_count *count) {
  pktrt_hit last, next;
  size_t steps = 0;
  for (bool hit = pktrt_intersect_after(s, r, NULL, &next); hit; hit = pktrt_intersect_after(s, r, &last, &next)) {
    count->outside += !(r->tmin < next.t && next.t < r->tmax);
    if (steps == triangles || (steps && !comes_after(&next, &last))) {
      count->endless++;
      return SIZE_MAX;
    }
    last = next;
    steps++;
  }
  return steps;
}

static void follow_ends(const pktrt_scene *s, const world *w, const pktrt_ray *rays, ends_count *count) {
  static const float ahead[3] = {1, 0, 0};
  pktrt_hit want, got, many[RAYS], all[4], after[RAYS];
  bool occluded[RAYS];
  size_t triangles = 0;
  for (uint32_t m = 0; m < w->n; m++) triangles += w->m[m].nt;
  pktrt_intersect_n(s, rays, many, RAYS);
  pktrt_occluded_n(s, rays, occluded, RAYS);
  pktrt_intersect_after_n(s, rays, NULL, after, RAYS);

  for (size_t i = 0; i < RAYS; i++) {
    const bool hit = ref_intersect(w, &rays[i], &want);
    count->hits += hit, count->rays++;
    for (uint32_t m = 0; m < w->n && ref_valid(&rays[i]); m++)
      for (uint32_t t = 0; t < w->m[m].nt; t++) {
        float p[3][3], least, most;
        for (uint32_t c = 0; c < 3; c++) ref_vertex(&w->m[m], w->m[m].i[3 * t + c], rays[i].time, p[c]);
        if (!oracle_crosses(&rays[i], p) || !oracle_t_range(&rays[i], p, &least, &most)) continue;
        count->crossings++, count->beyond += isinf(least) && isinf(most);
      }
    count->wrong += pktrt_intersect(s, &rays[i], &got) != hit || !same_bits(&got, &want, sizeof got);
    count->wrong += !same_bits(&many[i], &want, sizeof want) || !same_bits(&after[i], &want, sizeof want);
    count->wrong += occluded[i] != hit || pktrt_occluded(s, &rays[i]) != hit;

    /* What looks for the end by itself is asked where there is one. */
    pktrt_ray inside = pktrt_make_ray(rays[i].origin, ahead);
    inside.time = rays[i].time;
    const size_t n = chain_of(s, &rays[i], triangles, count);
    if (n != SIZE_MAX) count->wrong += pktrt_intersect_all(s, &rays[i], all, COUNT(all)) != n;
    if (chain_of(s, &inside, triangles, count) == SIZE_MAX) continue;
    for (uint32_t m = 0; m <= w->n; m++) (void)pktrt_winding(s, m, rays[i].origin, rays[i].time);
  }
}

static void queries_end(void) {
  ends_count count = {0, 0, 0, 0, 0, 0, 0};
  const size_t worlds = scaled(120);
  for (size_t i = 0; i < worlds; i++) {
    rng r = rng_of(7100 + i);
    pktrt_ray rays[RAYS];
    world w = any_world(&r);
    for (size_t j = 0; j < RAYS; j++) rays[j] = any_ray(&w, &r);
    for (int k = 0; k < isa_count; k++) {
      pktrt_scene *s = world_scene(&w, isas[k], 0);
      follow_ends(s, &w, rays, &count);
      pktrt_scene_destroy(s);
    }
    world_free(&w);
  }
  CHECK(!count.outside, "%zu of %zu hits are outside of their intervals", count.outside, count.hits);
  CHECK(!count.endless, "%zu chains of hits of %zu have no end", count.endless, 2 * count.rays);
  CHECK(!count.wrong, "%zu answers are not those of exact arithmetic", count.wrong);
  CHECK(count.beyond > count.rays / 100 && count.hits > count.rays / 20, "%zu crossings beyond floats, %zu hits",
      count.beyond, count.hits);
  say("%zu rays, %zu crossings, %zu of them beyond the range of floats, %zu hits", count.rays, count.crossings,
      count.beyond, count.hits);
}

/* A hit that never was, as previous: of NaN, of either infinity. */
static void odd_previous(void) {
  world w = world_of(mesh_box());
  for (int k = 0; k < isa_count; k++) {
    pktrt_scene *s = world_scene(&w, isas[k], 0);
    pktrt_ray r = ray_of(0.25f, 0.125f, 0, 0, 0, 1);
    pktrt_hit previous, next, first;
    r.tmin = -INFINITY;
    CHECK(pktrt_intersect(s, &r, &first) && first.t == -1);
    previous = first, previous.t = NAN;
    CHECK(!pktrt_intersect_after(s, &r, &previous, &next));
    previous.t = INFINITY;
    CHECK(!pktrt_intersect_after(s, &r, &previous, &next));
    previous.t = -INFINITY;
    CHECK(pktrt_intersect_after(s, &r, &previous, &next) && same_bits(&next, &first, sizeof next));
    pktrt_scene_destroy(s);
  }
  world_free(&w);
}

/* --- area --- */

static const uint8_t orders[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};

static float mixed_float(rng *r) {
  const uint32_t kind = rng_below(r, 8);
  if (kind < 2) return 0;
  if (kind == 2) return rng_below(r, 2) ? 1.f : -1.f;
  return rng_sign(r) * powf(10, (float)((int)rng_below(r, 69) - 38)); /* 1e-38 to 1e30 */
}

static bool has_area(float p[3][3]) {
  double n[3];
  oracle_normal(p, n);
  return n[0] != 0 || n[1] != 0 || n[2] != 0;
}

/* Returns a ray to a point of a triangle, or of its edge. */
static pktrt_ray ray_to_triangle(rng *r, float p[3][3]) {
  const double u = (double)rng_unit(r), v = rng_below(r, 4) ? (1 - u) * (double)rng_unit(r) : 0;
  float target[3], origin[3];
  for (int a = 0; a < 3; a++) {
    target[a] = (float)((1 - u - v) * (double)p[0][a] + u * (double)p[1][a] + v * (double)p[2][a]);
    origin[a] = rng_below(r, 2) ? mixed_float(r) : target[a];
  }
  pktrt_ray ray = ray_towards(origin, target, 0);
  ray.tmin = -INFINITY;
  if (dot3(ray.direction, ray.direction) == 0) ray.direction[rng_below(r, 3)] = 1;
  return ray;
}

static void area_in_any_order(void) {
  size_t flat = 0, counted_wrong = 0, crossings = 0, lost = 0;
  const size_t triangles = scaled(1500);
  for (size_t i = 0; i < triangles; i++) {
    rng r = rng_of(8100 + i);
    float p[3][3];
    world w = world_none();
    for (int j = 0; j < 9; j++) p[j / 3][j % 3] = mixed_float(&r);
    if (i % 8 == 0) /* on a line, exactly */
      for (int a = 0; a < 3; a++) p[1][a] = 2 * p[0][a], p[2][a] = -4 * p[0][a];
    for (int j = 0; j < 9; j++)
      if (fabsf(p[j / 3][j % 3]) > PKTRT_MAX_COORD) p[j / 3][j % 3] = 0;
    w.n = COUNT(orders);
    for (uint32_t m = 0; m < w.n; m++) {
      w.m[m] = mesh_of(3, 1);
      memcpy(w.m[m].p, p, sizeof p);
      for (int c = 0; c < 3; c++) w.m[m].i[c] = orders[m][c];
    }

    pktrt_scene *s = world_scene(&w, isas[i % (size_t)isa_count], 0);
    pktrt_scene_info info;
    pktrt_get_scene_info(s, &info);
    const bool area = has_area(p);
    flat += !area, counted_wrong += info.degenerate != (area ? 0 : COUNT(orders));
    for (int j = 0; j < 6; j++) {
      const pktrt_ray ray = ray_to_triangle(&r, p);
      if (!ref_valid(&ray) || !oracle_crosses(&ray, p)) continue;
      float least, most;
      if (!oracle_t_range(&ray, p, &least, &most) || isinf(least) || isinf(most)) continue;
      pktrt_hit all[COUNT(orders)];
      const size_t n = pktrt_intersect_all(s, &ray, all, COUNT(all));
      crossings += COUNT(orders), lost += COUNT(orders) - n;
    }
    pktrt_scene_destroy(s);
    world_free(&w);
  }
  CHECK(
      !counted_wrong, "%zu triangles are taken for degenerate, or for what they are not, in some order", counted_wrong);
  CHECK(!lost, "%zu of %zu crossings are lost", lost, crossings);
  CHECK(flat > triangles / 20 && crossings > triangles, "%zu without area, %zu crossings", flat, crossings);
  say("%zu triangles in six orders, %zu without area; %zu crossings", triangles, flat, crossings);
}

/* Tetrahedra with a corner at the origin and three near it, or not so near. */
static void thin_bodies_are_closed(void) {
  static const uint32_t face[12] = {1, 3, 2, 0, 1, 2, 0, 2, 3, 0, 3, 1};
  size_t bodies = 0, outside = 0, odd = 0, lines = 0;
  oracle_list list;
  memset(&list, 0, sizeof list);
  for (uint32_t i = 0; i < scaled(1200); i++) {
    rng r = rng_of(8500 + i);
    mesh m = mesh_of(4, 4);
    const float size = powf(10, -(float)rng_below(&r, 30));
    memcpy(m.i, face, sizeof face);
    memset(m.p, 0, 12 * sizeof *m.p);
    for (int c = 0; c < 3; c++) m.p[c] = rng_range(&r, 0.5f, 2), m.p[3 * (c + 1) + c] = size * rng_range(&r, 0.5f, 2);
    for (int turn = (int)rng_below(&r, 3); turn > 0; turn--) { /* another corner first */
      for (int t = 0; t < 4; t++) {
        const uint32_t first = m.i[3 * t];
        m.i[3 * t] = m.i[3 * t + 1], m.i[3 * t + 1] = m.i[3 * t + 2], m.i[3 * t + 2] = first;
      }
    }
    world w = world_of(m);
    pktrt_scene *s = world_scene(&w, isas[i % (uint32_t)isa_count], 0);
    oracle_soup soup = oracle_soup_of(&w, 0);
    for (int j = 0; j < 4; j++) {
      float at[3];
      pktrt_hit all[8];
      for (int a = 0; a < 3; a++) at[a] = size * rng_range(&r, 0.25f, 0.4f);
      const pktrt_ray ahead = ray_of(at[0], at[1], at[2], 1, 0, 0);
      pktrt_ray line = ray_of(at[0], at[1], at[2], rng_sign(&r), rng_sign(&r), rng_sign(&r));
      line.tmin = -INFINITY;
      oracle_crossings(&soup, &ahead, &list);
      const int winding = oracle_winding(&list);
      bodies += winding == 1, outside += pktrt_winding(s, 0, at, 0) != winding;
      const size_t crossings = oracle_crossings(&soup, &line, &list), n = pktrt_intersect_all(s, &line, all, 8);
      lines += crossings > 0, odd += n != crossings;
    }
    oracle_soup_free(&soup);
    pktrt_scene_destroy(s);
    world_free(&w);
  }
  oracle_list_free(&list);
  CHECK(
      !outside && !odd, "%zu windings of %zu are wrong, %zu lines of %zu lose crossings", outside, bodies, odd, lines);
  const size_t least = small_run ? scaled(1200) / 2 : scaled(1200);
  CHECK(bodies > least && lines > least, "%zu points inside, %zu lines", bodies, lines);
}

/* Triangles that are lines at each key, and slivers between them, where corners are rounded one by one. */
static void moving_lines_have_area(void) {
  enum { LINES = 12, KEYS = 3 };
  const float unit = 0x1p-14f; /* of floats from 512 to 1024 */
  size_t crossings = 0, lost = 0, never = 0;
  for (uint32_t i = 0; i < scaled(400); i++) {
    rng r = rng_of(8800 + i);
    mesh m = mesh_of(3 * LINES, LINES);
    float *p = m.p = realloc(m.p, KEYS * 9 * LINES * sizeof *p);
    if (!p) abort();
    m.keys = KEYS;
    for (uint32_t t = 0; t < 3 * LINES; t++) m.i[t] = t;
    for (uint32_t k = 0; k < KEYS; k++)
      for (uint32_t t = 0; t < LINES; t++) {
        const int start = 600 * 16384 + (int)rng_below(&r, 1000), rise = t ? 1 + (int)rng_below(&r, 6) : 0;
        for (int c = 0; c < 3; c++, p += 3)
          p[0] = (float)(4 * c), p[1] = (float)(start + c * rise) * unit,
          p[2] = (float)t; /* the first: along an axis */
      }
    world w = world_of(m);
    pktrt_scene *s = world_scene(&w, isas[i % (uint32_t)isa_count], 0);
    pktrt_scene_info info;
    pktrt_get_scene_info(s, &info);
    never += info.degenerate;
    for (int j = 0; j < 40; j++) {
      float q[3][3], time = rng_unit(&r);
      const uint32_t t = rng_below(&r, LINES);
      for (uint32_t c = 0; c < 3; c++) ref_vertex(&m, 3 * t + c, time, q[c]);
      pktrt_ray ray = ray_of(rng_range(&r, 0, 8), q[rng_below(&r, 3)][1], (float)t - 0.5f, 0, 0, 1);
      ray.origin[1] += unit * (float)((int)rng_below(&r, 7) - 3);
      ray.time = time, ray.tmax = 1;
      if (!oracle_crosses(&ray, q)) continue;
      pktrt_hit hit;
      crossings++, lost += !pktrt_intersect(s, &ray, &hit) || hit.triangle != t;
    }
    pktrt_scene_destroy(s);
    world_free(&w);
  }
  CHECK(!lost, "%zu of %zu crossings of slivers are lost", lost, crossings);
  CHECK(never == scaled(400), "%zu, not %zu have no area at any time", never, scaled(400));
  CHECK(crossings > scaled(400) / 4, "%zu crossings", crossings);
  say("%zu crossings of slivers", crossings);
}

/* --- u and v --- */

typedef struct uv_count {
  size_t hits, below, beyond, other;
} uv_count;

static void look_at_uv(const pktrt_hit *h, const pktrt_hit *want, size_t n, uv_count *count) {
  for (size_t i = 0; i < n; i++) {
    count->hits += h[i].mesh != PKTRT_NONE;
    count->below += !(h[i].u >= 0 && h[i].v >= 0);
    count->beyond += !((1 - h[i].u) - h[i].v >= 0);
    count->other += !same_bits(&h[i], &want[i], sizeof *h);
  }
}

/* A copy of a world, in an instance that is turned about all axes; and a ray in the same way. */
static const float turned[12] = {0.36f, 0.48f, -0.8f, 0.25f, -0.8f, 0.6f, 0, -0.125f, 0.48f, 0.64f, 0.6f, 0.5f};

static void turn_ray(pktrt_ray *r) {
  const pktrt_ray old = *r;
  for (int a = 0; a < 3; a++) {
    r->origin[a] = dot3(turned + 4 * a, old.origin) + turned[4 * a + 3];
    r->direction[a] = dot3(turned + 4 * a, old.direction);
  }
}

static pktrt_scene *placed_scene(const world *w, pktrt_isa isa) {
  const pktrt_scene_desc d = scene_desc_of(isa, 0);
  pktrt_mesh_desc meshes[WORLD_MESHES];
  pktrt_instance_desc in;
  uint32_t model = 0;
  memset(&in, 0, sizeof in);
  for (uint32_t m = 0; m < w->n; m++) meshes[m] = mesh_desc(&w->m[m]);
  pktrt_scene *s = pktrt_scene_create(&d);
  in.transforms = turned;
  CHECK(!pktrt_add_model(s, meshes, w->n, &model) && (in.model = model, !pktrt_add_instance(s, &in, NULL)) &&
        !pktrt_commit(s));
  return s;
}

/* Triangles with an edge in the plane x = 3 y, and rays in it, which meet the edge exactly: in doubles, which have fewer bits than
   the products, they pass it on either side. */
static float bits_of(float x, float most) { return roundf(x / most * 0x1p20f) * (most * 0x1p-20f); } /* 20 of them */

static world plane_world(void) {
  rng r = rng_of(77);
  mesh m = mesh_soup((uint32_t)scaled(400), 0.75f, 78);
  for (uint32_t t = 0; t < m.nt; t++) {
    const uint32_t first = rng_below(&r, 3);
    for (uint32_t c = 0; c < 2; c++) {
      float *p = m.p + 3 * m.i[3 * t + (first + c) % 3];
      p[1] = bits_of(p[1] / 4, 1), p[0] = 3 * p[1], p[2] = bits_of(p[2] + (float)c, 4);
    }
  }
  return world_of(m);
}

static void rays_in_plane(const mesh *m, uint64_t seed, pktrt_ray *rays, size_t n) {
  rng r = rng_of(seed);
  for (size_t i = 0; i < n; i++) {
    const uint32_t *corner = m->i + 3 * rng_below(&r, m->nt);
    const float *p = m->p + 3 * corner[0], *q = m->p + 3 * corner[1], *o = m->p + 3 * corner[2], f = rng_unit(&r);
    if (p[0] != 3 * p[1]) p = o;
    else if (q[0] != 3 * q[1]) q = o;
    const float y = bits_of(rng_sign(&r) * 0x1p-18f, 0x1p-18f), z = bits_of(rng_sign(&r) * 0x1p-9f, 0x1p-9f);
    const float dy = bits_of(p[1] + f * (q[1] - p[1]), 1), dz = bits_of(p[2] + f * (q[2] - p[2]), 4);
    rays[i] = ray_of(3 * y, y, z, 3 * dy, dy, dz);
  }
}

static void barycentrics_stay_inside(void) {
  enum { CHUNK = 256 };
  static const ray_kind kinds[3] = {RAYS_EDGE, RAYS_VERTEX, RAYS_AXIS};
  static pktrt_ray rays[CHUNK];
  static pktrt_hit want[CHUNK], got[CHUNK];
  uv_count count = {0, 0, 0, 0};
  for (int what = 0; what < 5; what++) { /* at rest and moving, and both in an instance; edges that are met exactly */
    world w = what == 4 ? plane_world() : what & 1 ? world_moving(2) : world_static(2);
    if (what == 2) world_place(&w, 1, 3.3f, -2.1f, 1.7f);
    for (int k = 0; k < isa_count; k++) {
      pktrt_scene *s = what & 2 ? placed_scene(&w, isas[k]) : world_scene(&w, isas[k], 0);
      pktrt_scene *plain = what & 2 ? world_scene(&w, isas[k], 0) : s;
      for (size_t first = 0; first < scaled(what == 4 ? 1280 : 5000); first += CHUNK) {
        if (what == 4) rays_in_plane(&w.m[0], 9100 + first, rays, CHUNK);
        else make_rays(&w, plain, kinds[first / CHUNK % 3], 31, first, rays, CHUNK);
        for (size_t i = 0; i < CHUNK; i++) {
          pktrt_hit at[2];
          if (what & 2) turn_ray(&rays[i]);
          pktrt_intersect(s, &rays[i], &want[i]);
          if (pktrt_intersect_all(s, &rays[i], at, 2) == 2) look_at_uv(at + 1, at + 1, 1, &count);
          pktrt_intersect_after(s, &rays[i], NULL, &got[i]);
        }
        look_at_uv(want, want, CHUNK, &count);
        look_at_uv(got, want, CHUNK, &count);
        for (int path = 0; path < 3; path++) {
          pktrt_query_desc q;
          memset(&q, 0, sizeof q);
          q.path = (pktrt_path)path;
          if (q.path == PKTRT_PATH_PAPER && first % 1024) continue;
          pktrt_intersect_ex(s, &q, rays, got, CHUNK);
          look_at_uv(got, want, CHUNK, &count);
        }
      }
      if (plain != s) pktrt_scene_destroy(plain);
      pktrt_scene_destroy(s);
    }
    world_free(&w);
  }
  CHECK(!count.below && !count.beyond, "u or v of %zu hits of %zu are below 0, and of %zu sum up to more than 1",
      count.below, count.hits, count.beyond);
  CHECK(!count.other, "%zu answers differ from single calls", count.other);
  CHECK(count.hits > scaled(30000), "%zu hits", count.hits);
  say("%zu hits on edges and at corners", count.hits);
}

/* A lattice that moves and grows, asked along an axis at its edges and corners at a time when all of them are whole numbers: the
   hits are those of the lattice that lies there. */
static void moving_lattices(void) {
  enum { EDGE = 8, PER_SIDE = 4 * EDGE + 5, ASKED = PER_SIDE * PER_SIDE };
  static pktrt_ray rays[ASKED];
  static pktrt_hit one[ASKED], many[ASKED], want[ASKED];
  size_t hits = 0, wrong = 0, control = 0;
  for (int axis = 0; axis < 3; axis++)
    for (int k = 0; k < 4; k++) {
      const float times[4] = {0.5f, 0.25f, 0.75f, 1}, time = times[k];
      mesh grid = mesh_grid(EDGE, EDGE / 2);
      const size_t n = (size_t)grid.nv * 3;
      float *keys = calloc(2 * n, sizeof *keys), *there = calloc(n, sizeof *there);
      if (!keys || !there) abort();
      for (size_t i = 0; i < n; i++) {
        const size_t to = i / 3 * 3 + (i + (size_t)axis) % 3;
        keys[to] = grid.p[i];
        keys[n + to] = 5 * grid.p[i] + (i % 3 == 1 ? 8.0f : 4.0f);
        there[to] = (1 - time) * keys[to] + time * keys[n + to];
      }
      pktrt_scene *s[2];
      for (int moves = 0; moves < 2; moves++) {
        pktrt_mesh_desc d = mesh_desc(&grid);
        d.positions = moves ? keys : there, d.key_count = moves ? 2 : 1;
        s[moves] = pktrt_scene_create(NULL);
        CHECK(pktrt_add_mesh(s[moves], &d, NULL) == PKTRT_OK && pktrt_commit(s[moves]) == PKTRT_OK);
      }
      for (uint32_t i = 0; i < ASKED; i++) { /* at corners and edges, between them, and on diagonals */
        float origin[3], direction[3];
        const float u = (float)(i % PER_SIDE) - PER_SIDE / 2, v = (float)(i / PER_SIDE) - PER_SIDE / 2;
        const float at[3] = {u, k & 1 ? 40.0f : -40.0f, v}, way[3] = {0, k & 1 ? -1.0f : 1.0f, 0};
        for (int a = 0; a < 3; a++) origin[(a + axis) % 3] = at[a], direction[(a + axis) % 3] = way[a];
        rays[i] = ray_of(origin[0], origin[1], origin[2], direction[0], direction[1], direction[2]);
        rays[i].time = time;
      }
      pktrt_intersect_n(s[0], rays, want, ASKED);
      pktrt_intersect_n(s[1], rays, many, ASKED);
      for (uint32_t i = 0; i < ASKED; i++) {
        pktrt_intersect(s[1], &rays[i], &one[i]);
        hits += want[i].mesh != PKTRT_NONE;
        wrong += !same_bits(&want[i], &one[i], sizeof want[i]);
        wrong += !same_bits(&want[i], &many[i], sizeof want[i]);
        wrong += pktrt_occluded(s[1], &rays[i]) != (want[i].mesh != PKTRT_NONE);
        rays[i].time = 0;
        pktrt_intersect(s[1], &rays[i], &one[i]);
        control += !same_bits(&want[i], &one[i], sizeof want[i]);
      }
      for (int moves = 0; moves < 2; moves++) pktrt_scene_destroy(s[moves]);
      free(keys), free(there);
      mesh_free(&grid);
    }
  CHECK(wrong == 0 && hits > 1000 && control > 1000, "%zu of %zu hits differ", wrong, hits);
  say("%zu hits: %zu answers differ; control, at another time: %zu", hits, wrong, control);
}

void suite_extremes(void) {
  run("no hit is at an infinite t, and every query ends, whatever the bits of rays and meshes", queries_end);
  run("after a hit at t = -inf comes the first, after one at NaN none", odd_previous);
  run("a triangle with area is hit whatever the order of its corners", area_in_any_order);
  run("bodies of corners far apart and near are closed", thin_bodies_are_closed);
  run("rays along axes at the edges of a moving lattice have the hits of the lattice that lies there", moving_lattices);
  run("moving triangles that are lines at each key are hit where rounding gives them area", moving_lines_have_area);
  run("u, v and (1 - u) - v are never below 0, on edges and at corners, on any path", barycentrics_stay_inside);
}
