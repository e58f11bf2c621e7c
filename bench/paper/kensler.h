/* kensler.h - part of paper.c: the triangle test of Kensler and Shirley, which the paper uses (section 4), beside
   pktrt's, on the pairs of rays and leaves that traversal really meets. The kernels are in ../kensler_stamp.h, which
   pktrt.h stamps with its own.

   These are internals of pktrt.h: its vectors, blocks and batches, pk_tri_ray_block and
   pk_paper_test_triangle. There is no public way to test triangles without a tree.

   Contents: kernels, pairs, racing, edges, agreement, part. */
#ifndef PAPER_KENSLER_H
#define PAPER_KENSLER_H

#include "paper.h"
#include "system.h"

/* >>kernels -------------------------------------------------------------------------------------------------------- */

static const race_set *races_of(pktrt_isa isa) {
  switch (isa) {
#ifdef PK_HAS_SSE2
  case PKTRT_ISA_SSE2: return &kensler_races_sse2;
#endif
#ifdef PK_HAS_AVX2
  case PKTRT_ISA_AVX2: return &kensler_races_avx2;
#endif
#ifdef PK_HAS_AVX512
  case PKTRT_ISA_AVX512: return &kensler_races_avx512;
#endif
#ifdef PK_HAS_NEON
  case PKTRT_ISA_NEON: return &kensler_races_neon;
#endif
#ifdef PK_HAS_SCALAR
  case PKTRT_ISA_SCALAR: return &kensler_races_scalar;
#endif
  default: return NULL;
  }
}

/* >>pairs ---------------------------------------------------------------------------------------------------------- */

typedef struct listener { /* the `user` of events */
  course *c;
  size_t ray;
  uint32_t order;
} listener;

static void hear_leaf(void *user, const pktrt_event *e) {
  listener *l = (listener *)user;
  course *c = l->c;
  if (e->kind != PKTRT_EVENT_LEAF) return;
  if (c->count[0] == c->room) {
    c->room = c->room ? 2 * c->room : 1 << 16;
    c->visit[0] = (visit *)realloc(c->visit[0], c->room * sizeof(visit));
    if (!c->visit[0]) fatal("not enough memory");
  }
  visit *v = &c->visit[0][c->count[0]++];
  v->ray = (uint32_t)(l->ray % PK_BATCH), v->block = e->index, v->order = l->order++;
  v->bits = 1u << l->ray % 8;
}

static int by_block(const void *x, const void *y) {
  const visit *a = (const visit *)x, *b = (const visit *)y;
  return a->block != b->block ? (a->block < b->block ? -1 : 1) : a->order < b->order ? -1 : a->order > b->order;
}
static int by_order(const void *x, const void *y) {
  const visit *a = (const visit *)x, *b = (const visit *)y;
  return a->order != b->order ? (a->order < b->order ? -1 : 1) : a->block < b->block ? -1 : a->block > b->block;
}

/* The visits [from, count) of eight rays, one after the other, become those of a group: a leaf comes once, when the
   first of them comes to it, with the bits of all. */
static void make_group(course *c, size_t from, uint32_t first) {
  visit *to = c->visit[1] + c->count[1];
  const size_t n = c->count[0] - from;
  size_t kept = 0;
  memcpy(to, c->visit[0] + from, n * sizeof *to);
  qsort(to, n, sizeof *to, by_block);
  for (size_t i = 0; i < n; i++)
    if (kept && to[kept - 1].block == to[i].block) to[kept - 1].bits |= to[i].bits;
    else to[kept] = to[i], to[kept++].ray = first;
  qsort(to, kept, sizeof *to, by_order);
  c->count[1] += kept;
}

static uint64_t tests_of_visits(const course *c) {
  uint64_t n = 0;
  for (size_t i = 0; i < c->count[0]; i++) {
    const uint32_t *id = pk_segment_block(&c->seg, c->visit[0][i].block, c->moving)->id;
    for (int lane = 0; lane < 8; lane++) n += id[lane] != PKTRT_NONE;
  }
  return n;
}

/* Which leaves every ray meets when it is traced alone, in that order, as the paper path tells it. */
static course make_course(pktrt_scene *tree, const pktrt_ray *ray, size_t rays) {
  course c;
  memset(&c, 0, sizeof c);
  if (tree->bvh_count != 1) fatal("a scene with still and moving meshes has no place here");
  c.tree = tree, c.moving = tree->bvhs[0].key_count > 1, c.rays = rays;
  c.seg = pk_bvh_segment_of(&tree->bvhs[0], 0, 0);
  c.batches = (rays + PK_BATCH - 1) / PK_BATCH;
  c.batch = (pk_batch *)take(c.batches, sizeof *c.batch);
  c.fresh = (depths *)take(c.batches, sizeof *c.fresh);
  for (int g = 0; g < 2; g++) c.start[g] = (size_t *)take(c.batches + 1, sizeof(size_t));
  listener l;
  memset(&l, 0, sizeof l);
  l.c = &c;
  pktrt_query_desc desc;
  memset(&desc, 0, sizeof desc);
  desc.path = PKTRT_PATH_PAPER, desc.packet_size = 1, desc.trace = hear_leaf, desc.user = &l;
  size_t *from = (size_t *)take(rays / 8 + 2, sizeof(size_t)); /* where the visits of eight rays begin */
  for (size_t i = 0; i < rays; i++) {
    pktrt_hit hit;
    pk_batch *b = &c.batch[i / PK_BATCH];
    const size_t k = i % PK_BATCH;
    for (int a = 0; a < 3; a++) b->o[a][k] = ray[i].origin[a], b->d[a][k] = ray[i].direction[a];
    b->tmin[k] = ray[i].tmin, b->tmax[k] = ray[i].tmax, b->time[k] = ray[i].time;
    if (k == 0) c.start[0][i / PK_BATCH] = c.count[0];
    if (k % 8 == 0) from[i / 8] = c.count[0], l.order = 0;
    l.ray = i;
    pktrt_intersect_ex(tree, &desc, &ray[i], &hit, 1);
  }
  c.start[0][c.batches] = from[(rays + 7) / 8] = c.count[0];
  c.visit[1] = (visit *)take(c.count[0] + 1, sizeof(visit));
  const size_t all = c.count[0];
  for (size_t g = 0; g < (rays + 7) / 8; g++) {
    if (g * 8 % PK_BATCH == 0) c.start[1][g * 8 / PK_BATCH] = c.count[1];
    c.count[0] = from[g + 1];
    make_group(&c, from[g], (uint32_t)(g * 8 % PK_BATCH));
  }
  c.count[0] = all, c.start[1][c.batches] = c.count[1];
  c.tests = tests_of_visits(&c);
  free(from);
  return c;
}

static void free_course(course *c) {
  free(c->batch);
  free(c->fresh);
  for (int g = 0; g < 2; g++) free(c->visit[g]), free(c->start[g]);
}

/* >>racing --------------------------------------------------------------------------------------------------------- */

static void rewind_batch(pk_batch *b, const depths *fresh) {
  memcpy(b->t, b->tmax, sizeof b->t);
  memcpy(b->depth_hi, fresh->depth_hi, sizeof b->depth_hi);
  memcpy(b->sure_hi, fresh->sure_hi, sizeof b->sure_hi);
  memset(b->id, 0, sizeof b->id);
  memset(b->slot, 0xFF, sizeof b->slot);
}

/* One go over all visits; seconds. Rewinding costs both sides the same, and next to nothing. */
static double go(const course *c, const race_set *set, bool kensler, bool groups) {
  void (*const run)(const course *, size_t) = set->run[kensler][groups][c->moving];
  const double start = cpu_seconds();
  for (size_t i = 0; i < c->batches; i++) {
    rewind_batch(&c->batch[i], &c->fresh[i]);
    run(c, i);
  }
  return cpu_seconds() - start;
}

static void set_up(course *c, const race_set *set) {
  for (size_t i = 0; i < c->batches; i++) {
    for (uint32_t k = 0; k < PK_BATCH; k++) {
      pk_batch *b = &c->batch[i];
      if (k % 8 == 0) set->setup(c->tree, b, k);
      pk_time_segment(b->time[k], c->moving ? 2 : 1, &b->weight1[k]);
    }
    memcpy(c->fresh[i].depth_hi, c->batch[i].depth_hi, sizeof c->fresh[i].depth_hi);
    memcpy(c->fresh[i].sure_hi, c->batch[i].sure_hi, sizeof c->fresh[i].sure_hi);
  }
}

/* What every ray hit: the slot, PKTRT_NONE if nothing. */
static void read_slots(const course *c, uint32_t *slot) {
  for (size_t i = 0; i < c->rays; i++) slot[i] = c->batch[i / PK_BATCH].slot[i % PK_BATCH];
}

typedef struct outcome {
  double smooth_normal[2][2];      /* groups, kensler: for each test */
  size_t hits, lost, found, other; /* rays hit; Kensler's test alone misses, alone hits, hits another triangle */
} outcome;

static outcome race_tests(const bench *b, course *c, pktrt_isa isa) {
  enum { GOES = 5 }; /* of each kind in a round */
  const race_set *set = races_of(isa);
  double took[2][2][MAX_ROUNDS * GOES];
  uint32_t *slot[2];
  outcome o;
  memset(&o, 0, sizeof o);
  set_up(c, set);
  for (int s = 0; s < 2; s++) slot[s] = (uint32_t *)take(c->rays, sizeof(uint32_t));
  for (int g = 0; g < 2; g++) {
    for (int s = 0; s < 2; s++) go(c, set, s, g), read_slots(c, slot[s]);
    for (size_t i = 0; g == 0 && i < c->rays; i++) {
      o.hits += slot[0][i] != PKTRT_NONE;
      o.lost += slot[0][i] != PKTRT_NONE && slot[1][i] == PKTRT_NONE;
      o.found += slot[0][i] == PKTRT_NONE && slot[1][i] != PKTRT_NONE;
      o.other += slot[0][i] != slot[1][i] && slot[0][i] != PKTRT_NONE && slot[1][i] != PKTRT_NONE;
    }
    for (unsigned k = 0; k < b->given.rounds * GOES; k++)
      for (unsigned i = 0; i < 2; i++) took[g][(i + k) % 2][k] = go(c, set, (i + k) % 2, g);
    for (int s = 0; s < 2; s++)
      o.smooth_normal[g][s] = 1e9 * median_of(took[g][s], b->given.rounds * GOES) / (double)c->tests;
  }
  for (int s = 0; s < 2; s++) free(slot[s]);
  return o;
}

static void report_race(const bench *b, course *c, const char *rays) {
  for (int i = 0; i < 2; i++) {
    const pktrt_isa isa = i ? widest() : four_lanes();
    if (i && widest() == four_lanes()) break;
    const outcome o = race_tests(b, c, isa);
    say(&b->out, "| %s | %s | %s | %.0f | %.2f | %.2f | %.2fx | %.2f | %.2f | %.2fx | %zu of %zu |\n", rays,
        c->moving ? "two keys" : "still", pktrt_isa_string(isa), (double)c->tests / (double)c->rays,
        o.smooth_normal[0][1], o.smooth_normal[0][0], o.smooth_normal[0][0] / o.smooth_normal[0][1],
        o.smooth_normal[1][1], o.smooth_normal[1][0], o.smooth_normal[1][0] / o.smooth_normal[1][1],
        o.lost + o.found + o.other, c->rays);
    csv(&b->out, "%s,%d,%s,%zu,%llu,%.4f,%.4f,%.4f,%.4f,%.4f,%zu,%zu,%zu,%zu\n", rays, c->moving, pktrt_isa_string(isa),
        c->rays, (unsigned long long)c->tests, (double)c->count[0] / (double)c->count[1], o.smooth_normal[0][1],
        o.smooth_normal[0][0], o.smooth_normal[1][1], o.smooth_normal[1][0], o.hits, o.lost, o.found, o.other);
  }
}

static setup pool_hall(const bench *b) {
  setup s = one_frame(b, "poolhall", PKTRT_MODE_RCS, 1);
  s.path = PKTRT_PATH_FAST, s.isa = widest();
  return s;
}

/* Primary rays as the renderer packs them. */
static void primary_rays(bench *b, pktrt_ray *out, size_t rays, bool moving) {
  const setup s = pool_hall(b);
  ray_list all = make_list((size_t)b->given.size * b->given.size);
  pktrt_render_desc d;
  uint32_t random = 1;
  describe(b, &s, 0, NULL, &d);
  tap_open(b->now.tree, trace_recorded);
  tap.list[0] = &all;
  if (pktrt_render(b->now.tree, &d) != PKTRT_OK) fatal(pktrt_last_error(b->now.tree));
  tap.list[0] = NULL;
  tap_close(b->now.tree);
  const size_t chunks = rays / PK_BATCH;
  for (size_t i = 0; i < rays; i++) { /* whole batches, evenly spread */
    const size_t from = i / PK_BATCH * (all.count / PK_BATCH) / chunks * PK_BATCH + i % PK_BATCH;
    out[i] = all.ray[from];
    out[i].time = moving ? (float)sc_random(&random) : 0;
  }
  free_list(&all);
}

/* What bounces off diffusely where they hit. */
static void bounce(const pktrt_scene *tree, const pktrt_ray *from, pktrt_ray *out, size_t rays) {
  uint32_t random = 2;
  for (size_t i = 0; i < rays; i++) {
    pktrt_hit hit;
    float n[3], d[3] = {0, 0, 0}, length = 0, facing = 0;
    const float u[2] = {(float)sc_random(&random), (float)sc_random(&random)};
    pktrt_intersect(tree, &from[i], &hit);
    for (int a = 0; a < 3; a++) length += hit.normal[a] * hit.normal[a], facing += hit.normal[a] * from[i].direction[a];
    for (int a = 0; a < 3; a++) n[a] = length > 0 ? hit.normal[a] * (facing > 0 ? -1.0f : 1.0f) / sqrtf(length) : 0;
    if (length > 0) pktrt_map_cosine(u, n, d);
    pktrt_spawn(tree, &from[i], &hit, d, &out[i]); /* where nothing was hit, a ray that hits nothing */
  }
}

/* The same meshes with a second key, turned by two degrees about the vertical axis: what moves costs the same, however
   it moves. */
static pktrt_scene *turned(const scene *s, pktrt_isa isa) {
  const double c = sc_cos(2), n = sc_sin(2);
  pktrt_scene_desc desc;
  memset(&desc, 0, sizeof desc);
  desc.isa = isa;
  pktrt_scene *tree = pktrt_scene_create(&desc);
  if (!tree) fatal(pktrt_last_error(NULL));
  for (size_t i = 0; i < s->mesh_count; i++) {
    const scene_mesh *m = &s->meshes[i];
    const size_t floats = 3 * (size_t)m->vertex_count;
    float *p = (float *)calloc(2 * floats + 1, sizeof(float));
    pktrt_mesh_desc d;
    if (!p) fatal("not enough memory");
    memcpy(p, m->positions, floats * sizeof(float));
    for (size_t v = 0; v < floats; v += 3) {
      p[floats + v] = (float)(c * (double)p[v] + n * (double)p[v + 2]);
      p[floats + v + 1] = p[v + 1];
      p[floats + v + 2] = (float)(c * (double)p[v + 2] - n * (double)p[v]);
    }
    memset(&d, 0, sizeof d);
    d.positions = p, d.vertex_count = m->vertex_count, d.key_count = 2;
    d.indices = m->indices, d.triangle_count = m->triangle_count;
    if (pktrt_add_mesh(tree, &d, NULL) != PKTRT_OK) fatal(pktrt_last_error(tree));
    free(p);
  }
  if (pktrt_commit(tree) != PKTRT_OK) fatal(pktrt_last_error(tree));
  return tree;
}

/* >>edges ---------------------------------------------------------------------------------------------------------- */

enum { LATTICE = 16 }; /* of a cube's edge, half of it */

/* A point of the cube's surface, blown up to a sphere: the same bits for whoever shares it. */
static void lattice_point(int face, int i, int j, float out[3]) {
  const int a = face / 2, side = face % 2 ? LATTICE : -LATTICE;
  double p[3], length = 0;
  p[a] = side, p[(a + 1) % 3] = i - LATTICE, p[(a + 2) % 3] = j - LATTICE;
  for (int k = 0; k < 3; k++) length += p[k] * p[k];
  for (int k = 0; k < 3; k++) out[k] = (float)(p[k] / sqrt(length));
}

/* A closed surface: with a second key, if it moves, at twice the size. */
static pktrt_scene *closed_surface(float *triangles, size_t floats, bool moving, pktrt_isa isa) {
  static const int corner[6][2] = {{0, 0}, {1, 0}, {0, 1}, {0, 1}, {1, 0}, {1, 1}};
  float *to = triangles;
  pktrt_scene_desc desc;
  pktrt_mesh_desc m;
  for (int face = 0; face < 6; face++)
    for (int i = 0; i < 2 * LATTICE; i++)
      for (int j = 0; j < 2 * LATTICE; j++)
        for (int k = 0; k < 6; k++, to += 3) lattice_point(face, i + corner[k][0], j + corner[k][1], to);
  for (size_t i = 0; i < floats; i++) triangles[floats + i] = 2 * triangles[i];
  memset(&desc, 0, sizeof desc);
  desc.isa = isa;
  memset(&m, 0, sizeof m);
  m.positions = triangles, m.vertex_count = (uint32_t)(floats / 3), m.triangle_count = (uint32_t)(floats / 9);
  m.key_count = moving ? 2 : 1;
  pktrt_scene *tree = pktrt_scene_create(&desc);
  if (!tree || pktrt_add_mesh(tree, &m, NULL) != PKTRT_OK || pktrt_commit(tree) != PKTRT_OK)
    fatal(pktrt_last_error(tree));
  return tree;
}

/* From inside a closed surface to its vertices and edges: every ray that hits nothing has leaked. */
static void race_edges(const bench *b, size_t rays, bool moving) {
  const size_t floats = (size_t)6 * 2 * LATTICE * 2 * LATTICE * 18;
  float *triangles = (float *)take(2 * floats, sizeof(float));
  pktrt_ray *ray = (pktrt_ray *)take(rays, sizeof *ray);
  pktrt_scene *tree = closed_surface(triangles, floats, moving, widest());
  uint32_t random = 3;
  for (size_t i = 0; i < rays; i++) {
    const size_t triangle = (size_t)(sc_random(&random) * (double)(floats / 9));
    const float *p = triangles + 9 * triangle, *q = p + 3;
    const double along = i % 2 ? sc_random(&random) : 0;
    ray[i].tmax = INFINITY, ray[i].time = moving ? (float)sc_random(&random) : 0;
    for (int a = 0; a < 3; a++) {
      const double at = (double)p[a] + along * ((double)q[a] - (double)p[a]);
      ray[i].origin[a] = (float)(0.4 * (sc_random(&random) - 0.5));
      ray[i].direction[a] = (float)(at * (1 + (double)ray[i].time)) - ray[i].origin[a];
    }
  }
  course c = make_course(tree, ray, rays);
  for (int i = 0; i < 2; i++) {
    const pktrt_isa isa = i ? widest() : four_lanes();
    if (i && widest() == four_lanes()) break;
    const outcome o = race_tests(b, &c, isa);
    if (o.hits != rays) fatal("a ray leaked through a closed surface");
    say(&b->out, "| %s | %s | %zu | %zu | %zu |\n", moving ? "two keys" : "still", pktrt_isa_string(isa), rays, o.lost,
        rays - o.hits);
    csv(&b->out, "edges,%d,%s,%zu,%llu,,,,,,%zu,%zu,%zu,%zu\n", moving, pktrt_isa_string(isa), rays,
        (unsigned long long)c.tests, o.hits, o.lost, o.found, o.other);
  }
  free_course(&c);
  pktrt_scene_destroy(tree);
  free(ray);
  free(triangles);
}

/* >>agreement ------------------------------------------------------------------------------------------------------ */

/* Returns how many of the rays hit another triangle by Kensler and Shirley's test than by pktrt's. The control compares
   each ray with the one before it. */
static size_t count_unlike(course *c, const race_set *set, bool groups, bool control, uint32_t *slot[2]) {
  size_t differing = 0, hits = 0;

  set_up(c, set);
  for (int s = 0; s < 2; s++) {
    go(c, set, s, groups);
    read_slots(c, slot[s]);
  }

  for (size_t i = 1; i < c->rays; i++) {
    differing += slot[0][i] != slot[1][control ? i - 1 : i];
    hits += slot[0][i] != PKTRT_NONE;
  }
  if (2 * hits < c->rays) fatal("too few rays hit anything");
  return differing;
}

/* Returns how many of a thousand primary rays hit another triangle: the most on any instruction set, for one ray and for
   eight, at rest and moving. */
static double most_differing(bench *b, bool control, char *details, size_t room) {
  static const pktrt_isa sets[] = {PKTRT_ISA_SCALAR, PKTRT_ISA_SSE2, PKTRT_ISA_NEON, PKTRT_ISA_AVX2, PKTRT_ISA_AVX512};
  const size_t pixels = (size_t)b->given.size * b->given.size, rays = pixels < 16384 ? pixels : 16384;
  const setup s = pool_hall(b);
  pktrt_ray *ray = (pktrt_ray *)take(rays, sizeof *ray);
  uint32_t *slot[2];
  double most = -1;
  for (int i = 0; i < 2; i++) slot[i] = (uint32_t *)take(rays, sizeof(uint32_t));

  open_setup(&b->now, &s);
  for (int moving = 0; moving < 2; moving++) {
    pktrt_scene *tree = moving ? turned(&b->now.made, widest()) : b->now.tree;
    primary_rays(b, ray, rays, moving);
    course c = make_course(tree, ray, rays);

    for (size_t i = 0; i < 2 * sizeof sets / sizeof *sets; i++) {
      const pktrt_isa isa = sets[i / 2];
      const bool groups = i % 2;
      if (!races_of(isa) || !pktrt_isa_available(isa)) continue;
      const size_t differing = count_unlike(&c, races_of(isa), groups, control, slot);
      const double figure = 1000 * (double)differing / (double)rays;
      if (figure <= most) continue;
      most = figure;
      snprintf(details, room, "per thousand; the most, %zu of %zu, on %s, %s, %s", differing, rays,
          pktrt_isa_string(isa), groups ? "eight rays" : "one ray", moving ? "two keys" : "still");
    }
    free_course(&c);
    if (moving) pktrt_scene_destroy(tree);
  }

  for (int i = 0; i < 2; i++) free(slot[i]);
  free(ray);
  return most;
}

/* >>part ----------------------------------------------------------------------------------------------------------- */

static void kensler(bench *b) {
  const size_t pixels = (size_t)b->given.size * b->given.size, rays = pixels < 65536 ? pixels : 65536;
  const setup s = pool_hall(b);
  pktrt_ray *ray[2];
  for (int i = 0; i < 2; i++) ray[i] = (pktrt_ray *)take(rays, sizeof(pktrt_ray));
  csv(&b->out,
      "rays,moving,isa,count,tests,rays_per_group_visit,one_ray_kensler_ns,one_ray_pktrt_ns,eight_rays_kensler_ns,"
      "eight_rays_pktrt_ns,hits,kensler_misses,kensler_hits_alone,kensler_hits_another\n");
  say(&b->out,
      "Nanoseconds for a ray and a triangle of the pool hall, in the leaves that each ray meets when traced alone: "
      "one ray against a block of eight triangles, eight rays (those that meet the leaf) against one triangle. K-S: "
      "Kensler and Shirley; time: pktrt's over theirs; differ: rays whose nearest triangle is another.\n\n"
      "| rays | triangles | isa | tests/ray | 1 x 8: K-S | pktrt | time | 8 x 1: K-S | pktrt | time | differ |\n"
      "|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  open_setup(&b->now, &s);
  for (int moving = 0; moving < 2; moving++) {
    pktrt_scene *tree = moving ? turned(&b->now.made, widest()) : b->now.tree;
    primary_rays(b, ray[0], rays, moving);
    bounce(tree, ray[0], ray[1], rays);
    for (int k = 0; k < 2; k++) {
      course c = make_course(tree, ray[k], rays);
      report_race(b, &c, k ? "diffuse" : "primary");
      free_course(&c);
    }
    if (moving) pktrt_scene_destroy(tree);
  }
  say(&b->out, "\nRays from inside a closed surface to its vertices and edges, and how many leak:\n\n"
               "| triangles | isa | rays | K-S | pktrt |\n|---|---|--:|--:|--:|\n");
  for (int moving = 0; moving < 2; moving++) race_edges(b, rays, moving);
  say(&b->out, "\n");
  for (int i = 0; i < 2; i++) free(ray[i]);
}

#endif /* PAPER_KENSLER_H */
