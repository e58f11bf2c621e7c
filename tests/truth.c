/* The library against brute force, bit for bit, and against an oracle in exact arithmetic; watertightness. */
#include "oracle.h"

/* Everything a ray can be answered by, one call after the other: -1 if all agree with *want, else the number of the way. */
enum { WAYS = 6, CHUNK = 128 };
/* The paper path is slow on incoherent rays: it sees every fourth chunk of them. */
static bool spared(pktrt_path path, size_t first, size_t shift) {
  return path == PKTRT_PATH_PAPER && (first / CHUNK + shift) % 4 != 0;
}

static int other_answer(const pktrt_scene *s, const pktrt_ray *rays, const pktrt_hit *want, size_t n, size_t *where) {
  static const uint32_t packet[WAYS] = {0, 0, 64, 7, 256, 0};
  pktrt_hit got[CHUNK];
  bool occluded[CHUNK];
  for (int way = 0; way < WAYS; way++) {
    pktrt_query_desc q;
    memset(&q, 0, sizeof q);
    q.path = way < 2 ? PKTRT_PATH_FAST : way < 5 ? PKTRT_PATH_PAPER : PKTRT_PATH_SINGLE;
    q.packet_size = packet[way];
    for (size_t first = 0; first < n; first += CHUNK) {
      size_t m = n - first < CHUNK ? n - first : CHUNK;
      if (n > 4 * CHUNK && spared(q.path, first, (size_t)way)) continue;
      memset(got, 0x77, sizeof got);
      if (way == 0) {
        for (size_t j = 0; j < m; j++) {
          bool hit = pktrt_intersect(s, &rays[first + j], &got[j]);
          occluded[j] = pktrt_occluded(s, &rays[first + j]);
          if (hit != (got[j].mesh != PKTRT_NONE)) got[j].mesh ^= 0x55;
        }
      } else {
        pktrt_intersect_ex(s, &q, rays + first, got, m);
        pktrt_occluded_ex(s, &q, rays + first, occluded, m);
      }
      for (size_t j = 0; j < m; j++) {
        bool hit = want[first + j].mesh != PKTRT_NONE;
        if (!same_bits(&got[j], &want[first + j], sizeof *got) || occluded[j] != hit) {
          *where = first + j;
          return way;
        }
      }
    }
  }
  return -1;
}

static void report(
    const char *name, pktrt_isa isa, int way, const pktrt_ray *r, const pktrt_hit *want, const pktrt_scene *s) {
  pktrt_hit h;
  pktrt_intersect(s, r, &h);
  CHECK(false, "%s, %s, way %d: o %a %a %a", name, pktrt_isa_string(isa), way, (double)r->origin[0],
      (double)r->origin[1], (double)r->origin[2]);
  CHECK(false, "  d %a %a %a  [%a, %a]", (double)r->direction[0], (double)r->direction[1], (double)r->direction[2],
      (double)r->tmin, (double)r->tmax);
  CHECK(false, "  want mesh %u triangle %u t %a, single gives %u %u %a", want->mesh, want->triangle, (double)want->t,
      h.mesh, h.triangle, (double)h.t);
}

/* All ways and instruction sets of the library against brute force. */
static size_t against_brute_force(const char *name, const world *w, const pktrt_ray *rays, size_t n) {
  size_t hits = 0, where = 0;
  pktrt_hit *want = calloc(n, sizeof *want);
  if (!want) abort();
  for (size_t j = 0; j < n; j++) hits += ref_intersect(w, &rays[j], &want[j]);
  for (int i = 0; i < isa_count; i++) {
    pktrt_scene *s = world_scene(w, isas[i], 0);
    if (!s) continue;
    int way = other_answer(s, rays, want, n, &where);
    if (way >= 0) report(name, isas[i], way, &rays[where], &want[where], s);
    pktrt_scene_destroy(s);
  }
  free(want);
  return hits;
}

/* Rays of every kind on a world, with windows of t and all lengths of direction where wild. */
static void rays_of_all_kinds(const world *w, uint64_t seed, bool wild, pktrt_ray *out, size_t n) {
  pktrt_scene *s = world_scene(w, PKTRT_ISA_AUTO, 0);
  size_t part = n / RAYS_KINDS, at = 0;
  for (int k = 0; k < RAYS_KINDS; k++) {
    size_t m = k == RAYS_KINDS - 1 ? n - at : part;
    make_rays(w, s, (ray_kind)k, seed, 0, out + at, m);
    at += m;
  }
  pktrt_scene_destroy(s);
  rng r = rng_of(seed + 5);
  for (size_t j = 0; j < n && wild; j++) {
    float length = powf(10, rng_range(&r, -15, 15));
    for (int a = 0; a < 3; a++) out[j].direction[a] *= length;
    switch (rng_below(&r, 6)) {
    case 0: out[j].tmin = -INFINITY; break;
    case 1: out[j].tmin = -2 / length; break;
    case 2: out[j].tmax = FLT_MAX; break;
    case 3: out[j].tmin = rng_unit(&r) / length; break;
    case 4: out[j].tmax = rng_unit(&r) / length; break;
    default: break;
    }
  }
}

static size_t rays_traced;
static size_t brute_alone(
    const char *name, world w, uint64_t seed, bool wild, size_t most) { /* returns how many rays */
  size_t n = 70 + scaled(4000000 / (1 + w.m[0].nt));
  if (n > most) n = most;
  pktrt_ray *rays = calloc(n, sizeof *rays);
  if (!rays) abort();
  rays_of_all_kinds(&w, seed, wild, rays, n);
  size_t hits = against_brute_force(name, &w, rays, n);
  CHECK(hits > 0, "%s: rays hit something", name);
  free(rays);
  world_free(&w);
  return n;
}
static void brute(const char *name, world w, uint64_t seed, bool wild) {
  rays_traced += brute_alone(name, w, seed, wild, 4000);
}

static void brute_static(void) {
  rays_traced = 0;
  brute("sphere", world_of(mesh_sphere(3, 0.05f, 1)), 1, true);
  brute("soup", world_of(mesh_soup(900, 0.3f, 7)), 2, true);
  brute("box", world_of(mesh_box()), 3, true);
  brute("grid", world_of(mesh_grid(20, 1)), 4, true);
  brute("one triangle", world_of(mesh_soup(1, 1, 9)), 5, true);
  say("%zu rays", rays_traced);
}

static void brute_moving(void) {
  static const uint32_t keys[4] = {2, 3, 5, 17};
  rays_traced = 0;
  for (int i = 0; i < 4; i++) {
    mesh m = mesh_soup(600, 0.3f, 7);
    mesh_move(&m, keys[i], 0.2f, 0.1f, 11);
    brute("moving soup", world_of(m), 6, true);
    m = mesh_sphere(2, 0.05f, 1);
    mesh_move(&m, keys[i], 0.3f, 0.02f, 12);
    world w = world_of(m);
    w.m[w.n++] = mesh_soup(200, 0.2f, 8);
    w.m[w.n] = mesh_box();
    mesh_move(&w.m[w.n++], 4, 0.2f, 0.1f, 13);
    brute("mixed key counts", w, 7, true);
  }
  say("%zu rays", rays_traced);
}

static void brute_thin(void) {
  rays_traced = 0;
  brute("thin", world_of(mesh_thin(800, 3)), 8, true);
  world w = world_of(mesh_thin(300, 4));
  mesh_move(&w.m[0], 3, 0.1f, 1e-4f, 5);
  brute("thin, moving", w, 9, true);
  say("%zu rays", rays_traced);
}

static void brute_ties(void) {
  rays_traced = 0;
  mesh m = mesh_soup(150, 0.4f, 21), c = mesh_copies(&m, 6), g = mesh_grid(6, 1), gg = mesh_copies(&g, 4);
  world w = world_of(c);
  w.m[w.n++] = mesh_copies(&m, 2); /* the same again in a second mesh */
  brute("copies", w, 10, false);
  w = world_of(gg);
  w.m[w.n++] = mesh_copies(&g, 3);
  mesh moving = mesh_copies(&g, 1);
  mesh_move(&moving, 2, 0, 0, 1); /* moves nowhere: ties across groups of different key counts */
  w.m[w.n++] = moving;
  brute("coplanar copies", w, 11, false);
  mesh_free(&m);
  mesh_free(&g);
  say("%zu rays", rays_traced);
}

enum { SCALES = 8 };
static void brute_scale(void *traced, size_t i) { /* at rest, and moving */
  static const float scales[SCALES] = {1e-20f, 1e-30f, 1e-8f, 1e8f, 1e20f, 1e29f, 1e-38f, 1e-42f};
  const float scale = scales[i / 2];
  const bool moves = i % 2;
  world w = world_of(mesh_soup(200, 0.5f, 5 + i / 2));
  if (moves) mesh_move(&w.m[0], 2, 0.1f, 0.1f, 3);
  world_place(&w, scale, 0, 0, 0);
  char name[64];
  snprintf(name, sizeof name, "scale %g%s", (double)scale, moves ? ", moving" : "");
  const size_t most =
      (scale < 1e-35f ? 400u : 2000u) / (small_run ? 3 : 1); /* arithmetic on denormal numbers is slow */
  ((size_t *)traced)[i] = brute_alone(name, w, 20 + i / 2, scale > 1e-21f && scale < 1e21f, most);
}

static void brute_scales(void) {
  size_t traced[2 * SCALES], sum = 0;
  threads_for(2, 2 * SCALES, brute_scale, traced);
  for (size_t i = 0; i < 2 * SCALES; i++) sum += traced[i];
  say("%zu rays", sum);
}

static void brute_offsets(void) {
  static const float offsets[5] = {1e-3f, 1, 1e3f, 1e5f, 1e6f};
  rays_traced = 0;
  for (int i = 0; i < 5; i++) {
    for (int moves = 0; moves < 2; moves++) {
      world w = world_of(mesh_sphere(2, 0.05f, 5));
      w.m[w.n++] = mesh_soup(150, 0.3f, 6);
      if (moves) mesh_move(&w.m[0], 2, 0.1f, 0.02f, 3);
      world_place(&w, 1, offsets[i], -0.7f * offsets[i], 0.3f * offsets[i]);
      char name[64];
      snprintf(name, sizeof name, "offset %g%s", (double)offsets[i], moves ? ", moving" : "");
      brute(name, w, 30 + (uint64_t)i, true);
    }
  }
  say("%zu rays", rays_traced);
}

/* Rays of which something is denormal, huge, or on the border of validity. */
static void brute_odd_rays(void) {
  world w = world_of(mesh_soup(300, 0.5f, 77));
  size_t n = scaled(20000);
  pktrt_ray *rays = calloc(n, sizeof *rays);
  if (!rays) abort();
  rays_of_all_kinds(&w, 40, false, rays, n);
  rng r = rng_of(41);
  for (size_t j = 0; j < n; j++) {
    pktrt_ray *x = &rays[j];
    static const float sizes[8] = {1e-40f, 1e-44f, 1e-38f, 1e37f, 1e30f, 1e-30f, 1e-37f, 1e25f};
    float s = sizes[rng_below(&r, 8)];
    uint32_t a = rng_below(&r, 3);
    switch (rng_below(&r, 7)) {
    case 0:
      for (int k = 0; k < 3; k++) x->direction[k] *= s;
      break;
    case 1: x->direction[a] = 1e-42f * rng_sign(&r); break;
    case 2: x->direction[a] *= 1e-30f; break;
    case 3:
      x->tmin = -1e-41f;
      x->tmax = s;
      break;
    case 4: x->origin[a] = rng_sign(&r) * PKTRT_MAX_COORD; break;
    case 5:
      x->tmin = -FLT_MAX;
      x->tmax = 1e-44f;
      break;
    default: x->origin[a] = 1e-41f * rng_sign(&r); break;
    }
  }
  size_t hits = against_brute_force("odd rays", &w, rays, n);
  CHECK(hits > n / 100, "%zu hits", hits);
  say("%zu rays, %zu hits", n, hits);
  free(rays);
  world_free(&w);
}

/* --- oracle --- */

typedef struct verdicts {
  size_t rays, hits, wrong;  /* of the library */
  size_t wrong_mt, wrong_ks; /* of the controls */
} verdicts;

static const char *objection(const oracle_soup *soup, const pktrt_ray *r, const oracle_list *list, const pktrt_hit *h) {
  return oracle_objection(soup, r, list, h, h->mesh != PKTRT_NONE, 1);
}

static void oracle(world w, uint64_t seed, verdicts *c) {
  size_t n = 70 + scaled(40000 / (1 + w.m[0].nt / 100));
  pktrt_ray *rays = calloc(n, sizeof *rays);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  oracle_soup soup = oracle_soup_of(&w, 0);
  oracle_list list = {NULL, 0, 0};
  if (!rays || !s) abort();
  if (w.m[0].keys < 2) oracle_plant(&soup);
  rays_of_all_kinds(&w, seed, false, rays, n);
  rng r = rng_of(seed);
  for (size_t j = 0; j < n; j++) { /* half of them moved off their targets by little */
    for (int k = 0; k < 3 && j % 2; k++) rays[j].direction[k] *= 1 + rng_sign(&r) * powf(10, rng_range(&r, -7, -3));
    if (!ref_valid(&rays[j])) continue;
    if (w.m[0].keys > 1) oracle_soup_move(&soup, &w, rays[j].time);
    oracle_crossings(&soup, &rays[j], &list);
    pktrt_hit h, mt, ks;
    c->hits += pktrt_intersect(s, &rays[j], &h);
    c->rays++;
    const char *what = objection(&soup, &rays[j], &list, &h);
    c->wrong += what != NULL;
    CHECK(!what, "seed %u ray %zu: mesh %u triangle %u t %.9g: %s", (unsigned)seed, j, h.mesh, h.triangle, (double)h.t,
        what);
    ref_moller_trumbore(&w, &rays[j], &mt);
    ref_kensler_shirley(&w, &rays[j], &ks);
    memcpy(mt.normal, h.normal, sizeof h.normal), memcpy(ks.normal, h.normal, sizeof h.normal);
    c->wrong_mt += objection(&soup, &rays[j], &list, &mt) != NULL;
    c->wrong_ks += objection(&soup, &rays[j], &list, &ks) != NULL;
  }
  oracle_list_free(&list);
  oracle_soup_free(&soup);
  pktrt_scene_destroy(s);
  free(rays);
  world_free(&w);
}

static void oracle_all(void) {
  verdicts c;
  memset(&c, 0, sizeof c);
  oracle(world_of(mesh_sphere(3, 0.05f, 1)), 1, &c);
  oracle(world_of(mesh_soup(500, 0.3f, 2)), 2, &c);
  oracle(world_of(mesh_thin(500, 3)), 3, &c);
  oracle(world_of(mesh_box()), 4, &c);
  world w = world_of(mesh_sphere(2, 0.05f, 1));
  world_place(&w, 1, 300, -200, 1000);
  oracle(w, 5, &c);
  w = world_of(mesh_soup(300, 0.3f, 4));
  mesh_move(&w.m[0], 3, 0.2f, 0.1f, 5);
  oracle(w, 6, &c);
  say("%zu rays, %zu hits, %zu wrong; Moeller-Trumbore in float %zu wrong, Kensler-Shirley %zu", c.rays, c.hits,
      c.wrong, c.wrong_mt, c.wrong_ks);
  CHECK(c.wrong == 0);
  CHECK(c.hits > c.rays / 20);
  CHECK(c.wrong_mt > c.hits / 100 && c.wrong_ks > c.hits / 100, "the controls fail");
}

void suite_truth(void) {
  run("static triangles answer as brute force, bit for bit", brute_static);
  run("moving triangles answer as brute force, bit for bit", brute_moving);
  run("needles and slivers answer as brute force", brute_thin);
  run("ties of equal triangles go to the lower mesh, then the lower triangle", brute_ties);
  run("scales from 1e-42 to 1e29 answer as brute force", brute_scales);
  run("scenes far from the origin answer as brute force", brute_offsets);
  run("denormal, huge and borderline rays answer as brute force", brute_odd_rays);
  run("answers are those of exact arithmetic: triangle, t, u, v and normal", oracle_all);
}

/* --- watertightness: more of it in stability_watertight.c --- */

/* A ray at the hub of a fan of triangles: whatever rounding does, one of the blades is hit, and hit alike. */
static void watertight_fans(void) {
  size_t leak = 0, mt = 0, n = scaled(3000);
  for (size_t i = 0; i < n; i++) {
    world w = world_of(mesh_fan(6, i));
    pktrt_scene *s = world_scene(&w, isas[i % (size_t)isa_count], 0);
    pktrt_hit h;
    rng r = rng_of(i + 99);
    for (int j = 0; j < 16; j++) {
      float o[3] = {rng_sign(&r), rng_sign(&r), -2 + rng_unit(&r)};
      pktrt_ray x = ray_towards(o, w.m[0].p, 0);
      leak += !pktrt_intersect(s, &x, &h);
      mt += !ref_moller_trumbore(&w, &x, &h);
    }
    pktrt_scene_destroy(s);
    world_free(&w);
  }
  say("%zu rays, %zu leaks; Moeller-Trumbore in float %zu", n * 16, leak, mt);
  CHECK(leak == 0);
  CHECK(small_run || mt > 0, "the control leaks");
}

void suite_watertight(void) { run("fans have no pinhole at the hub", watertight_fans); }
