/* The tree at the extremes: ten million triangles in the memory that the manual states, sizes over twelve orders of
   magnitude, triangles without area, a million of them in one place, refits over a thousand frames, rays along axes.
   (Failing allocations are in memory.c and pictures.c, and report to this part.) */
#include "stability.h"
#include "tree.h"
#include <time.h>

static const char part[] = "tree";

static double processor_seconds(void) { return (double)clock() / CLOCKS_PER_SEC; }

static void *room(size_t count, size_t size) {
  void *p = calloc(count ? count : 1, size);
  if (!p) abort();
  return p;
}

static pktrt_scene *scene_of(const world *w, pktrt_isa isa, pktrt_build_quality quality, int workers) {
  pktrt_scene_desc d = scene_desc_of(isa, workers);
  d.quality = quality, d.rebuild = PKTRT_REBUILD_NEVER;
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!s) abort();
  for (uint32_t m = 0; m < w->n; m++) CHECK(mesh_add(s, &w->m[m], NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  return s;
}

/* The depth that the manual promises ("at most 38 levels deep"), and that nothing in the trees is wrong. */
static void check_tree(const char *name, pktrt_isa isa, const pktrt_scene *s) {
  const char *fault = tree_fault(s);
  count_figure(part, name, isa, 1, "trees with a fault", fault != NULL);
  CHECK(!fault, "%s: %s", name, fault);
  value_figure(part, name, isa, 1, "levels of the tree", tree_depth(s), 40);
}

/* --- rays against the reference --- */

enum { CHUNK = 512, MOST_ISAS = 8, CONTROLS = 8 /* one ray in so many is asked of a control too */ };

typedef struct tally {
  uint64_t wrong[MOST_ISAS], hits, plain;
} tally;

typedef struct trial {
  const char *name;
  world w; /* planted */
  pktrt_scene *s[MOST_ISAS];
  size_t chunks;
  tally *of; /* each chunk */
} trial;

/* Answers of many-ray calls, of single ones, or only whether anything is hit. */
enum { ASK_MANY, ASK_SINGLE, ASK_ANY, WAYS };
static uint64_t wrong_answers(const pktrt_scene *s, const pktrt_ray *rays, const pktrt_hit *want, int way) {
  pktrt_hit got[CHUNK];
  bool some[CHUNK];
  uint64_t wrong = 0;
  if (way == ASK_MANY) pktrt_intersect_n(s, rays, got, CHUNK);
  if (way == ASK_ANY) pktrt_occluded_n(s, rays, some, CHUNK);
  for (size_t i = 0; i < CHUNK; i++) {
    if (way == ASK_SINGLE) pktrt_intersect(s, &rays[i], &got[i]);
    if (way == ASK_ANY) wrong += some[i] != (want[i].mesh != PKTRT_NONE);
    else wrong += !same_bits(&got[i], &want[i], sizeof *got);
  }
  return wrong;
}

/* To vertices and points of edges, from about as far away as they are from the origin, which is amid the world. */
static void rays_nearby(const world *w, size_t first, pktrt_ray *rays) {
  for (size_t j = 0; j < CHUNK; j++) {
    rng r = rng_of(first + j);
    float o[3], p[3];
    if (j % 2) pick_edge(w, &r, 0, p);
    else pick_vertex(w, &r, 0, p);
    const float far = 2 * fmaxf(fabsf(p[0]), fmaxf(fabsf(p[1]), fabsf(p[2])));
    for (int k = 0; k < 3; k++) o[k] = p[k] + far * rng_sign(&r);
    rays[j] = ray_towards(o, p, 0);
  }
}

/* One chunk in eight: from anywhere, where the references must look at all that is small. */
static void try_chunk(void *arg, size_t i) {
  static const ray_kind kinds[4] = {RAYS_EDGE, RAYS_VERTEX, RAYS_RANDOM, RAYS_AXIS};
  trial *t = arg;
  pktrt_ray rays[CHUNK];
  pktrt_hit want[CHUNK], plain;
  if (i % 8 == 7) make_rays(&t->w, t->s[0], kinds[i / 8 % 4], 1, i * CHUNK, rays, CHUNK);
  else rays_nearby(&t->w, i * CHUNK, rays);
  for (size_t j = 0; j < CHUNK; j++) {
    t->of[i].hits += ref_intersect(&t->w, &rays[j], &want[j]);
    if (j % CONTROLS) continue;
    ref_moller_trumbore(&t->w, &rays[j], &plain);
    t->of[i].plain += plain.mesh != want[j].mesh || plain.triangle != want[j].triangle;
  }
  for (int k = 0; k < isa_count; k++) t->of[i].wrong[k] = wrong_answers(t->s[k], rays, want, (int)(i % WAYS));
}

/* A million rays against trees of a world, which it takes; of another quality for each instruction set. */
static void try_world(const char *name, world w) {
  trial t = {name, w, {NULL}, (thorough(1000000) + CHUNK - 1) / CHUNK, NULL};
  tally all;
  memset(&all, 0, sizeof all);
  ref_plant(&t.w);
  t.of = room(t.chunks, sizeof *t.of);
  for (int k = 0; k < isa_count; k++) t.s[k] = scene_of(&t.w, isas[k], (pktrt_build_quality)(k % 3), 0);
  jobs_for(t.chunks, try_chunk, &t);
  for (size_t i = 0; i < t.chunks; i++) {
    for (int k = 0; k < isa_count; k++) all.wrong[k] += t.of[i].wrong[k];
    all.hits += t.of[i].hits, all.plain += t.of[i].plain;
  }
  const uint64_t rays = (uint64_t)t.chunks * CHUNK;
  for (int k = 0; k < isa_count; k++) {
    count_figure(part, name, isas[k], rays, "wrong answers", all.wrong[k]);
    check_tree(name, isas[k], t.s[k]);
    pktrt_scene_destroy(t.s[k]);
  }
  control_figure(part, name, "wrong answers", "Moeller-Trumbore", rays / CONTROLS, all.plain);
  CHECK(all.hits > rays / 10, "%s: %llu hits", name, (unsigned long long)all.hits);
  free(t.of);
  world_free(&t.w);
}

/* --- sizes --- */

static void three_corners(mesh *m, uint32_t t) {
  for (uint32_t c = 0; c < 3; c++) m->i[3 * t + c] = 3 * t + c;
}

/* Around the origin, as large as they are far away, nearly: from 1e-6 to 1e6. */
static mesh nested(uint32_t nt) {
  mesh m = mesh_of(3 * nt, nt);
  for (uint32_t t = 0; t < nt; t++) {
    rng r = rng_of(t);
    const float s = powf(10, -6 + 12 * (float)t / (float)(nt - 1));
    float centre[3];
    for (int k = 0; k < 3; k++) centre[k] = s * rng_sign(&r);
    for (uint32_t k = 0; k < 9; k++) m.p[9 * t + k] = centre[k % 3] + 0.4f * s * rng_sign(&r);
    three_corners(&m, t);
  }
  return m;
}

/* Grains of 1e-6 in a cube of 1e-3, and a wall of up to 1e6 for every fifteen of them. */
static mesh dust(uint32_t nt) {
  mesh m = mesh_of(3 * nt, nt);
  for (uint32_t t = 0; t < nt; t++) {
    rng r = rng_of(t);
    const float s = t % 16 == 15 ? powf(10, rng_range(&r, -3, 6)) : 1e-6f;
    float centre[3];
    for (int k = 0; k < 3; k++) centre[k] = fmaxf(s, 1e-3f) * rng_sign(&r);
    for (uint32_t k = 0; k < 9; k++) m.p[9 * t + k] = centre[k % 3] + s * rng_sign(&r);
    three_corners(&m, t);
  }
  return m;
}

static void sizes(void) {
  const uint32_t nt = 144; /* every ray looks at all that is smaller than 2^-20 of the whole: half of them */
  try_world("sizes from 1e-6 to 1e6", world_of(nested(nt)));
  try_world("dust of 1e-6 among walls of 1e6", world_of(dust(nt)));
}

/* --- where there is nothing to split by --- */

/* Processor time of a build, and the tree. Each level of the tree costs one pass over the triangles. Loose triangles
   have log2(n / 8) levels of halving at least, 17 of a million, and nothing has more than 40: a bad input may cost
   40 / 17 times as much. Clocks and caches get the rest. */
static pktrt_scene *built(const char *name, const world *w) {
  const double start = processor_seconds();
  pktrt_scene *s = scene_of(w, PKTRT_ISA_AUTO, PKTRT_BUILD_DEFAULT, 0);
  const double mine = processor_seconds() - start;
  check_tree(name, PKTRT_ISA_AUTO, s);
  if (w->m[0].nt < 100000) return s; /* over within a tick of the clock */
  world loose = world_of(mesh_soup(w->m[0].nt, 0.01f, 3));
  const double again = processor_seconds();
  pktrt_scene_destroy(scene_of(&loose, PKTRT_ISA_AUTO, PKTRT_BUILD_DEFAULT, 0));
  const double theirs = processor_seconds() - again;
  world_free(&loose);
  value_figure(part, name, PKTRT_ISA_AUTO, w->m[0].nt, "build time against loose triangles", mine / theirs, 4);
  return s;
}

/* All corners on the line through the origin and (3, 5, 7), exactly: by multiples of 2^-17 below 2. */
static mesh on_a_line(uint32_t nt) {
  mesh m = mesh_of(3 * nt, nt);
  for (uint32_t t = 0; t < nt; t++) {
    rng r = rng_of(t);
    uint32_t at[3];
    for (int c = 0; c < 3; c++) at[c] = c ? at[0] + rng_below(&r, 8) : rng_below(&r, 1 << 18);
    for (uint32_t i = 0; i < 9; i++)
      m.p[9 * (size_t)t + i] = ((float)at[i / 3] * 0x1p-17f - 1) * (float)(3 + 2 * (i % 3));
    three_corners(&m, t);
  }
  return m;
}

static void rays_at_line(const world *w, size_t first, pktrt_ray *rays) {
  for (size_t j = 0; j < CHUNK; j++) {
    rng r = rng_of(first + j);
    float o[3] = {3 * rng_sign(&r), 3 * rng_sign(&r), 3 * rng_sign(&r)}, p[3];
    if (j % 2) pick_edge(w, &r, 0, p);
    else pick_vertex(w, &r, 0, p);
    rays[j] = ray_towards(o, p, 0);
  }
}

typedef struct line_trial {
  const world *w;
  const pktrt_scene *s;
  uint64_t *hits; /* of each chunk */
} line_trial;

static void try_line(void *arg, size_t i) {
  line_trial *t = arg;
  pktrt_ray rays[CHUNK];
  pktrt_hit hit[CHUNK];
  rays_at_line(t->w, i * CHUNK, rays);
  if (i == 0) rays[0] = ray_of(-6, -10, -14, 3, 5, 7); /* along it, through all boxes */
  pktrt_intersect_n(t->s, rays, hit, CHUNK);
  for (size_t j = 0; j < CHUNK; j++) t->hits[i] += hit[j].mesh != PKTRT_NONE;
}

/* A textbook test finds area in the rounding of some. */
static void line_control(const char *name, const char *what) {
  world w = world_of(on_a_line(2000));
  pktrt_ray rays[CHUNK];
  pktrt_hit hit;
  uint64_t found = 0;
  ref_plant(&w);
  for (size_t i = 0; i < 8; i++) {
    rays_at_line(&w, i * CHUNK, rays);
    for (size_t j = 0; j < CHUNK; j++) found += ref_moller_trumbore(&w, &rays[j], &hit);
  }
  control_figure(part, name, what, "Moeller-Trumbore", 8 * CHUNK, found);
  world_free(&w);
}

static void collinear(void) {
  static const char name[] = "all collinear", what[] = "hits of triangles without area";
  world w = world_of(on_a_line((uint32_t)thorough(1000000)));
  const size_t chunks = (thorough(1000000) + CHUNK - 1) / CHUNK;
  pktrt_scene *s = built(name, &w);
  pktrt_scene_info info;
  pktrt_get_scene_info(s, &info);
  CHECK(info.degenerate == w.m[0].nt, "%llu of %u without area", (unsigned long long)info.degenerate, w.m[0].nt);
  for (int k = 0; k < isa_count; k++) {
    line_trial t = {&w, s, room(chunks, sizeof *t.hits)};
    tree_asked_by(s, isas[k]);
    jobs_for(chunks, try_line, &t);
    uint64_t hits = 0;
    for (size_t i = 0; i < chunks; i++) hits += t.hits[i];
    count_figure(part, name, isas[k], chunks * CHUNK, what, hits);
    free(t.hits);
  }
  line_control(name, what);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* One triangle many times; or triangles of one centre, of sizes from 0 to 1, or from 1e-6 to 1e6. */
enum { ALIKE, CENTRED, CENTRED_WIDELY };
static mesh in_one_place(uint32_t nt, int how) {
  mesh m = mesh_of(3 * nt, nt);
  for (uint32_t t = 0; t < nt; t++) {
    rng r = rng_of(t);
    const float s = how == ALIKE ? 1 : how == CENTRED ? rng_unit(&r) : powf(10, rng_range(&r, -6, 6));
    const float a[9] = {-s, 0, -s, s, 0, -s, 0, 0, 2 * s};
    memcpy(m.p + 9 * (size_t)t, a, sizeof a);
    three_corners(&m, t);
  }
  return m;
}

typedef struct place_trial {
  world answer; /* what is asked for the truth: of equal triangles the first */
  pktrt_scene *s;
  size_t rays;
  uint64_t wrong[16], hits[16]; /* of each job */
} place_trial;

static void try_place(void *arg, size_t job) {
  place_trial *t = arg;
  for (size_t i = job; i < t->rays; i += 16) {
    rng r = rng_of(i);
    const float o[3] = {rng_sign(&r), 1 + rng_unit(&r), rng_sign(&r)}, p[3] = {rng_sign(&r), 0, rng_sign(&r)};
    const pktrt_ray ray = ray_towards(o, p, 0);
    pktrt_hit got, want;
    t->hits[job] += ref_intersect(&t->answer, &ray, &want);
    pktrt_intersect(t->s, &ray, &got);
    t->wrong[job] += !same_bits(&got, &want, sizeof got);
  }
}

/* Every ray that hits looks at all of them: the million rays are those of "8 times". */
static void rays_in_one_place(const char *name, const world *w, int how, size_t rays) {
  place_trial t = {{{{NULL, NULL, 0, 0, 0}}, 0, NULL}, NULL, rays, {0}, {0}};
  t.answer = *w;
  if (how == ALIKE) t.answer.m[0].nt = 1;
  t.s = built(name, w);
  for (int k = 0; k < isa_count; k++) {
    uint64_t wrong = 0, hits = 0;
    memset(t.wrong, 0, sizeof t.wrong), memset(t.hits, 0, sizeof t.hits);
    tree_asked_by(t.s, isas[k]);
    jobs_for(16, try_place, &t);
    for (int i = 0; i < 16; i++) wrong += t.wrong[i], hits += t.hits[i];
    count_figure(part, name, isas[k], rays, "wrong answers", wrong);
    CHECK(hits > rays / 8, "%s: %llu hits", name, (unsigned long long)hits);
  }
  pktrt_scene_destroy(t.s);
}

static void coincident(void) {
  static const char *const names[3] = {
      "one triangle a million times", "of one centre", "of one centre, from 1e-6 to 1e6"};
  for (int how = ALIKE; how <= CENTRED_WIDELY; how++) {
    world w = world_of(in_one_place((uint32_t)(how == ALIKE ? scaled(1000000) : thorough(100000)), how));
    rays_in_one_place(names[how], &w, how, how == ALIKE ? 6 + thorough(10) : 30 + thorough(50));
    world_free(&w);
  }
  mesh sphere = mesh_sphere(3, 0.1f, 1);
  try_world("each triangle 8 times", world_of(mesh_copies(&sphere, 8)));
  mesh_free(&sphere);
}

/* --- ten million triangles, and memory --- */

typedef struct memory_stated {
  double scene, built, key, fast;
} memory_stated;

/* The manual's sentence holds the figures, here they are found; so text and test cannot part. */
static memory_stated stated_memory(void) {
  static char text[1 << 20];
  memory_stated m = {0, 0, 0, 0};
  FILE *f = fopen("examples/manual.md", "r");
  if (!CHECK(f != NULL, "examples/manual.md is not below the working directory")) return m;
  text[fread(text, 1, sizeof text - 1, f)] = 0;
  fclose(f);
  const char *at = strstr(text, "An indexed mesh takes");
  const int found = !at ? 0
                        : sscanf(at,
                              "An indexed mesh takes up to %lf bytes per triangle , tree and copy together , "
                              "%lf while its tree is first built , and %lf more for each further motion key",
                              &m.scene, &m.built, &m.key);
  at = strstr(text, "`PKTRT_BUILD_FAST` holds up to");
  const int fast = at && sscanf(at, "`PKTRT_BUILD_FAST` holds up to %lf bytes per triangle", &m.fast) == 1;
  CHECK(found == 3 && fast, "the manual states the memory in other words than those looked for here");
  return m;
}

/* A height field of n x n cells over [-1, 1]^2 whose vertices are moved a little. */
static mesh terrain(uint32_t n) {
  mesh m = mesh_grid(n, 1);
  for (size_t v = 0; v < m.nv; v++) {
    rng r = rng_of(v);
    float *p = m.p + 3 * v;
    p[1] = 0.02f * sinf(20 * p[0]) * cosf(17 * p[2]) + 0.4f / (float)n * rng_sign(&r);
    p[0] += 0.4f / (float)n * rng_sign(&r), p[2] += 0.4f / (float)n * rng_sign(&r);
  }
  return m;
}

/* The scene, when its memory was seen to. */
static pktrt_scene *measured(const char *name, const world *w, pktrt_build_quality quality, const memory_stated *most) {
  const uint32_t nt = w->m[0].nt;
  const double keys = w->m[0].keys - 1;
  const size_t before = hooks.peak_bytes = hooks.live_bytes;
  pktrt_scene *s = scene_of(w, PKTRT_ISA_AUTO, quality, 2);
  const double bytes = (double)(hooks.live_bytes - before) / nt, peak = (double)(hooks.peak_bytes - before) / nt;
  value_figure(part, name, PKTRT_ISA_AUTO, nt, "bytes per triangle", bytes,
      (quality == PKTRT_BUILD_FAST ? most->fast : most->scene) + keys * most->key);
  value_figure(part, name, PKTRT_ISA_AUTO, nt, "bytes while built", peak, most->built + keys * most->key);
  check_tree(name, PKTRT_ISA_AUTO, s);
  return s;
}

static void memory(void) {
  const memory_stated most = stated_memory();
  static const struct {
    const char *name;
    pktrt_build_quality quality;
    uint32_t keys;
  } cases[4] = {{"terrain, fast build", PKTRT_BUILD_FAST, 1}, {"terrain, high quality", PKTRT_BUILD_HIGH, 1},
      {"terrain, 2 keys", PKTRT_BUILD_DEFAULT, 2}, {"terrain, 5 keys", PKTRT_BUILD_DEFAULT, 5}};
  for (int i = 0; i < 4; i++) {
    world w = world_of(terrain(1 + (uint32_t)sqrt((double)(10000 + thorough(290000)) / 2)));
    if (cases[i].keys > 1) mesh_move(&w.m[0], cases[i].keys, 0.01f, 0.0001f, 1);
    pktrt_scene_destroy(measured(cases[i].name, &w, cases[i].quality, &most));
    world_free(&w);
  }
}

/* A part of the terrain: cells [x0, x1) x [z0, z1). A ray that stays above its inner cells hits only them, so that the
   reference need not know the rest. */
enum { PARTS = 24, MARGIN = 3 };
typedef struct piece {
  uint32_t n, x0, x1, z0, z1;
  world w;
} piece;

typedef struct terrain_trial {
  const mesh *m;
  const pktrt_scene *s;
  uint32_t n;
  size_t rays; /* of each part */
  pktrt_ray *ray;
  pktrt_hit *want;
  uint64_t plain[PARTS], hits[PARTS], wrong[PARTS];
} terrain_trial;

/* Squares of 64 cells, and strips of 14 across all of it, along x and along z. */
static piece piece_of(uint32_t n, size_t i) {
  rng r = rng_of(i);
  const uint32_t size[3][2] = {{n < 64 ? n : 64, n < 64 ? n : 64}, {n, 14}, {14, n}}, *cells = size[i % 3];
  const uint32_t x0 = rng_below(&r, n - cells[0] + 1), z0 = rng_below(&r, n - cells[1] + 1);
  piece p = {n, x0, x0 + cells[0], z0, z0 + cells[1], {{{NULL, NULL, 0, 0, 0}}, 0, NULL}};
  return p;
}

static void cut(piece *p, const mesh *m) {
  const uint32_t wide = p->x1 - p->x0, high = p->z1 - p->z0;
  mesh cells = mesh_of((wide + 1) * (high + 1), 2 * wide * high);
  for (uint32_t z = 0; z <= high; z++)
    memcpy(cells.p + 3 * z * (wide + 1), m->p + 3 * ((size_t)(p->z0 + z) * (p->n + 1) + p->x0), 12 * (wide + 1));
  for (uint32_t c = 0; c < wide * high; c++) { /* the triangles of mesh_grid, in its order */
    const uint32_t a = c / wide * (wide + 1) + c % wide, b = a + wide + 1, two[6] = {a, b, a + 1, a + 1, b, b + 1};
    memcpy(cells.i + 6 * (size_t)c, two, sizeof two);
  }
  p->w = world_of(cells);
  ref_plant(&p->w);
}

/* In the column over the inner cells. */
static void point_over(const piece *p, rng *r, float y, float out[3]) {
  const float cell = 2 / (float)p->n;
  out[0] = cell * rng_range(r, (float)(p->x0 + MARGIN), (float)(p->x1 - MARGIN)) - 1, out[1] = y;
  out[2] = cell * rng_range(r, (float)(p->z0 + MARGIN), (float)(p->z1 - MARGIN)) - 1;
}

/* Through an inner vertex, or a point of an inner edge; it ends 1/2000 of its length behind: at most 1/1000 of the
   whole width, less than the margin. */
static pktrt_ray ray_over(const piece *p, rng *r) {
  const uint32_t wide = p->x1 - p->x0, high = p->z1 - p->z0;
  const uint32_t x = MARGIN + rng_below(r, wide - 2 * MARGIN), z = MARGIN + rng_below(r, high - 2 * MARGIN);
  const float *a = p->w.m[0].p + 3 * (z * (wide + 1) + x), f = rng_below(r, 2) ? 0 : rng_unit(r);
  float o[3], target[3];
  point_over(p, r, rng_range(r, -0.02f, 0.04f), o);
  for (int k = 0; k < 3; k++) target[k] = a[k] + f * (a[3 + k] - a[k]);
  pktrt_ray ray = ray_towards(o, target, 0);
  ray.tmax = 1.0005f;
  return ray;
}

static void terrain_truth(void *arg, size_t i) {
  terrain_trial *t = arg;
  piece p = piece_of(t->n, i);
  const uint32_t wide = p.x1 - p.x0;
  cut(&p, t->m);
  for (size_t j = 0; j < t->rays; j++) {
    rng r = rng_of(i * t->rays + j);
    pktrt_ray *ray = &t->ray[i * t->rays + j];
    pktrt_hit *want = &t->want[i * t->rays + j], plain;
    *ray = ray_over(&p, &r);
    t->hits[i] += ref_intersect(&p.w, ray, want);
    if (j % CONTROLS == 0) {
      ref_moller_trumbore(&p.w, ray, &plain);
      t->plain[i] += plain.triangle != want->triangle;
    }
    const uint32_t cell = want->triangle / 2;
    if (want->mesh != PKTRT_NONE)
      want->triangle = 2 * ((p.z0 + cell / wide) * p.n + p.x0 + cell % wide) + want->triangle % 2;
  }
  world_free(&p.w);
}

static void terrain_answers(void *arg, size_t i) {
  terrain_trial *t = arg;
  pktrt_hit *got = room(t->rays, sizeof *got);
  pktrt_intersect_n(t->s, t->ray + i * t->rays, got, t->rays);
  t->wrong[i] = 0;
  for (size_t j = 0; j < t->rays; j++) t->wrong[i] += !same_bits(&got[j], &t->want[i * t->rays + j], sizeof *got);
  free(got);
}

static void rays_over_terrain(const char *name, uint32_t n, const mesh *m, pktrt_scene *s) {
  terrain_trial t = {m, s, n, (thorough(1000000) + PARTS - 1) / PARTS, NULL, NULL, {0}, {0}, {0}};
  const size_t rays = t.rays * PARTS;
  t.ray = room(rays, sizeof *t.ray), t.want = room(rays, sizeof *t.want);
  jobs_for(PARTS, terrain_truth, &t);
  uint64_t plain = 0, hits = 0;
  for (int i = 0; i < PARTS; i++) plain += t.plain[i], hits += t.hits[i];
  for (int k = 0; k < isa_count; k++) {
    uint64_t wrong = 0;
    tree_asked_by(s, isas[k]);
    jobs_for(PARTS, terrain_answers, &t);
    for (int i = 0; i < PARTS; i++) wrong += t.wrong[i];
    count_figure(part, name, isas[k], rays, "wrong answers", wrong);
  }
  control_figure(part, name, "wrong answers", "Moeller-Trumbore", rays / CONTROLS, plain);
  CHECK(hits > rays / 2 && hits < rays, "%s: %llu hits", name, (unsigned long long)hits);
  free(t.ray), free(t.want);
}

static void ten_million(void) {
  const memory_stated most = stated_memory();
  const uint32_t n = 1 + (uint32_t)sqrt((double)thorough(10000000) / 2);
  world w = world_of(terrain(n));
  char name[64];
  snprintf(name, sizeof name, "terrain of %.3g million triangles", (double)w.m[0].nt * 1e-6);
  pktrt_scene *s = measured(name, &w, PKTRT_BUILD_DEFAULT, &most);
  rays_over_terrain(name, n, &w.m[0], s);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* --- refits --- */

enum { DEFORMATIONS = 10, ONE_MESH = 8 };

static float deformed(float x, int how, size_t i, rng *r) {
  switch (how) {
  case 0: return x + 0.02f * rng_sign(r);
  case 1: return x * -2 + 100;     /* far away, turned over */
  case 2: return 3 * rng_sign(r);  /* scrambled */
  case 3: return i % 3 ? 0.0f : x; /* a line: no area left */
  case 4: return 1e-20f * rng_sign(r);
  case 5: return 0.5f;     /* a point */
  case 6: return x * 1e6f; /* an explosion */
  case 7: return x;        /* and back */
  case ONE_MESH: return x + 0.5f * rng_sign(r);
  default: return 1000 + 1e-3f * x; /* few bits left */
  }
}

typedef struct film {
  bool moves;
  pktrt_isa isa;
  uint64_t frames, asked; /* asked: those whose answers are compared */
  uint64_t bounds, off, stale_bounds, stale_off, faults;
  uint64_t rays, wrong, stale_rays, stale_wrong;
} film;

/* The bits of the meshes that change in a frame. */
static uint32_t deform(world *w, const world *rest, uint64_t frame) {
  const int how = (int)(frame % DEFORMATIONS);
  const uint32_t changed = how == ONE_MESH ? 1u << frame / DEFORMATIONS % w->n : (1u << w->n) - 1;
  for (uint32_t m = 0; m < w->n; m++) {
    rng r = rng_of(frame * WORLD_MESHES + m);
    if (changed >> m & 1)
      for (size_t i = 0; i < (size_t)w->m[m].nv * 3 * w->m[m].keys; i++)
        w->m[m].p[i] = deformed(rest->m[m].p[i], how, i, &r);
  }
  return changed;
}

static void refit_to(pktrt_scene *s, const world *w, uint32_t changed) {
  for (uint32_t m = 0; m < w->n; m++)
    for (uint32_t k = 0; k < w->m[m].keys && changed >> m & 1; k++)
      CHECK(pktrt_set_positions(s, m, k, w->m[m].p + (size_t)k * w->m[m].nv * 3) == PKTRT_OK);
  CHECK(pktrt_refit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
}

static uint64_t differing(const pktrt_hit *a, const pktrt_hit *b, size_t n) {
  uint64_t differ = 0;
  for (size_t i = 0; i < n; i++) differ += !same_bits(&a[i], &b[i], sizeof *a);
  return differ;
}

/* The refitted scene against one that is built anew: answers, and what is known of the scene. */
static void ask_fresh(
    film *f, const pktrt_scene *s, const world *w, const pktrt_ray *rays, const pktrt_hit *stale, size_t n) {
  pktrt_scene *fresh = scene_of(w, PKTRT_ISA_AUTO, PKTRT_BUILD_FAST, 0);
  pktrt_hit *want = room(n, sizeof *want), *got = room(n, sizeof *got);
  pktrt_scene_info a, b;
  pktrt_intersect_n(fresh, rays, want, n), pktrt_intersect_n(s, rays, got, n);
  f->rays += n, f->wrong += differing(got, want, n);
  f->stale_rays += n, f->stale_wrong += differing(stale, want, n);
  pktrt_get_scene_info(s, &a), pktrt_get_scene_info(fresh, &b);
  CHECK(a.degenerate == b.degenerate, "%llu, %llu without area", (unsigned long long)a.degenerate,
      (unsigned long long)b.degenerate);
  pktrt_scene_destroy(fresh);
  free(want), free(got);
}

static void one_frame(film *f, pktrt_scene *s, world *w, const world *rest, uint64_t frame) {
  const uint64_t apart = f->frames > 100 ? DEFORMATIONS - 1 : 1; /* all deformations have their turn */
  const size_t n = frame % apart ? 0 : (size_t)(thorough(125000) * apart / f->frames) + 20;
  const uint32_t changed = deform(w, rest, frame);
  pktrt_ray *rays = room(n, sizeof *rays);
  pktrt_hit *stale = room(n, sizeof *stale);
  make_rays(w, s, RAYS_EDGE, frame, 0, rays, n / 2);
  make_rays(w, s, RAYS_RANDOM, frame, 0, rays + n / 2, n - n / 2);
  pktrt_intersect_n(s, rays, stale, n);
  if (n) f->stale_off += tree_bounds_off(s, w, &f->stale_bounds);
  refit_to(s, w, changed);
  f->off += tree_bounds_off(s, w, &f->bounds);
  if (n) f->faults += tree_fault(s) != NULL, f->asked++, ask_fresh(f, s, w, rays, stale, n);
  free(rays), free(stale);
}

static void show_film(void *arg, size_t i) {
  film *f = (film *)arg + i;
  world w = f->moves ? world_moving(3) : world_static(4), rest = f->moves ? world_moving(3) : world_static(4);
  pktrt_scene *s = scene_of(&w, f->isa, PKTRT_BUILD_DEFAULT, 0);
  for (uint64_t frame = 0; frame < f->frames; frame++) one_frame(f, s, &w, &rest, frame);
  pktrt_scene_destroy(s);
  world_free(&w), world_free(&rest);
}

static void thousand_frames(void) {
  film films[2 * MOST_ISAS];
  memset(films, 0, sizeof films);
  for (int i = 0; i < 2 * isa_count; i++) { /* the widest, which is the default, at full length */
    const size_t frames = thorough(i / 2 == isa_count - 1 ? 1000 : 100);
    films[i].moves = i % 2, films[i].isa = isas[i / 2], films[i].frames = frames < 10 ? 10 : frames;
  }
  jobs_for((size_t)(2 * isa_count), show_film, films);
  for (int i = 0; i < 2 * isa_count; i++) {
    const film *f = &films[i];
    const char *name = f->moves ? "refits of what moves" : "refits of what rests";
    count_figure(part, name, f->isa, f->bounds, "bounds that differ after refits", f->off);
    count_figure(part, name, f->isa, f->asked, "trees with a fault", f->faults);
    count_figure(part, name, f->isa, f->rays, "wrong answers", f->wrong);
    control_figure(part, name, "bounds that differ after refits", "the refit left out", f->stale_bounds, f->stale_off);
    control_figure(part, name, "wrong answers", "the refit left out", f->stale_rays, f->stale_wrong);
  }
}

/* --- rays along axes ---
   A box that such a ray touches has, from the ray on, some extent to one side at least along each of the other two
   axes. So one of the four rays that lean to these sides, from the same origin, enters it, if it leans little enough:
   it visits at most what those four visit together, four times their mean. (A box without extent is met by all of
   them: the worlds below are 9 wide, where a slope of 2^-22 takes a ray less far from it than the slabs are padded.)
   Where zeros in a direction opened doors, all of the tree would be visited. */

enum { BUNDLE = 64, AXIS_JOBS = 32 };

/* Boxes in rows, whose sides lie in common planes. */
static mesh city(void) {
  mesh box = mesh_box(), m = mesh_of(8 * 512, 12 * 512);
  mesh_scale(&box, 0.25f);
  for (uint32_t b = 0; b < 512; b++) {
    for (uint32_t i = 0; i < 36; i++) m.i[36 * b + i] = box.i[i] + 8 * b;
    for (uint32_t i = 0; i < 24; i++) m.p[24 * b + i] = box.p[i] + (float)(b >> 3 * (i % 3) & 7) - 3.5f;
  }
  mesh_free(&box);
  return m;
}

typedef struct axis_trial {
  const world *w;
  pktrt_scene *s;
  bool on_vertices;
  size_t bundles;
  uint64_t visits[AXIS_JOBS], beside[AXIS_JOBS];
} axis_trial;

/* Rays side by side along one axis; on coordinates of vertices, hence in the planes of boxes, or anywhere. */
static void axis_bundle(const axis_trial *t, size_t i, pktrt_ray *rays) {
  rng shared = rng_of(i);
  float near[3];
  pick_vertex(t->w, &shared, 0, near);
  const uint32_t axis = (uint32_t)(i % 3);
  for (size_t j = 0; j < BUNDLE; j++) {
    rng r = rng_of(i * BUNDLE + j);
    float o[3];
    for (uint32_t k = 0; k < 3; k++) o[k] = near[k] + 0.7f * rng_sign(&r);
    if (t->on_vertices) {
      float a[3], b[3];
      pick_vertex(t->w, &r, 0, a), pick_vertex(t->w, &r, 0, b);
      o[(axis + 1) % 3] = a[(axis + 1) % 3], o[(axis + 2) % 3] = b[(axis + 2) % 3];
    }
    o[axis] = i & 8 ? -5.0f : 5.0f;
    rays[j] = ray_of(o[0], o[1], o[2], i & 16 ? 0.0f : -0.0f, i & 32 ? 0.0f : -0.0f, i & 64 ? 0.0f : -0.0f);
    rays[j].direction[axis] = i & 8 ? 1.0f : -1.0f;
  }
}

static uint64_t visits_of(const axis_trial *t, pktrt_path path, const pktrt_ray *rays) {
  pktrt_query_desc q;
  pktrt_stats stats;
  pktrt_hit hit[BUNDLE];
  memset(&q, 0, sizeof q), memset(&stats, 0, sizeof stats);
  q.path = path, q.stats = &stats;
  pktrt_intersect_ex(t->s, &q, rays, hit, BUNDLE);
  return stats.by_type[0].node_visits;
}

static void axis_job(void *arg, size_t job) {
  axis_trial *t = arg;
  t->visits[job] = t->beside[job] = 0;
  for (size_t i = job; i < t->bundles; i += AXIS_JOBS) {
    const pktrt_path path = (pktrt_path)(i / 3 % 3);
    pktrt_ray rays[BUNDLE], lean[BUNDLE];
    axis_bundle(t, i, rays);
    t->visits[job] += visits_of(t, path, rays);
    for (int side = 0; side < 4; side++) {
      memcpy(lean, rays, sizeof lean);
      for (size_t j = 0; j < BUNDLE; j++) {
        lean[j].direction[(i + 1) % 3] = side & 1 ? 0x1p-22f : -0x1p-22f;
        lean[j].direction[(i + 2) % 3] = side & 2 ? 0x1p-22f : -0x1p-22f;
      }
      t->beside[job] += visits_of(t, path, lean);
    }
  }
}

static void along_axes_of(const char *name, world w, bool on_vertices) {
  axis_trial t = {&w, scene_of(&w, PKTRT_ISA_AUTO, PKTRT_BUILD_DEFAULT, 0), on_vertices, 0, {0}, {0}};
  t.bundles = (thorough(1000000) / 15 + BUNDLE - 1) / BUNDLE + AXIS_JOBS; /* each ray and four beside it; three cases */
  for (int k = 0; k < isa_count; k++) {
    uint64_t visits = 0, beside = 0;
    tree_asked_by(t.s, isas[k]);
    jobs_for(AXIS_JOBS, axis_job, &t);
    for (int i = 0; i < AXIS_JOBS; i++) visits += t.visits[i], beside += t.beside[i];
    const double ratio = 4 * (double)visits / (double)beside;
    value_figure(part, name, isas[k], 5 * t.bundles * BUNDLE, "visits against rays beside", ratio, 4);
  }
  pktrt_scene_destroy(t.s);
  world_free(&w);
}

static void along_axes(void) {
  along_axes_of("along axes", world_static(4), false);
  along_axes_of("along axes through vertices", world_static(4), true);
  along_axes_of("along axes in planes of boxes", world_of(city()), true);
}

void suite_stability_tree(void) {
  run("stable: ten million triangles in the memory that the manual states", ten_million);
  run("stable: all qualities and motion in the memory that the manual states", memory);
  run("stable: sizes over twelve orders of magnitude answer as the reference", sizes);
  run("stable: a line of triangles without area is built and never hit", collinear);
  run("stable: a million coincident triangles build and answer", coincident);
  run("stable: refits leave exactly the bounds and hits of fresh builds", thousand_frames);
  run("stable: rays along axes visit what those beside them visit", along_axes);
}
