/* What the paper path tells of a packet: each nearer hit, once, and what became of each child of each node. */
#include "tree.h"

enum { MOST_RAYS = 256, MOST_EVENTS = 1 << 15, MOST_NODES = 1 << 12 };

typedef struct told { /* one packet, and what was told of it */
  const world *w;
  const pktrt_scene *s;
  const pktrt_ray *ray;
  uint32_t n;
  bool any_hit;
  pktrt_hit hit[MOST_RAYS];
  bool occluded[MOST_RAYS];
  pktrt_counts counts;
  pktrt_event event[MOST_EVENTS];
  size_t events;
} told;

static void hear(void *user, const pktrt_event *e) {
  told *p = user;
  if (CHECK(p->events < MOST_EVENTS)) p->event[p->events++] = *e;
}

static void ask(told *p) {
  static pktrt_stats stats;
  pktrt_query_desc q;
  memset(&q, 0, sizeof q);
  memset(&stats, 0, sizeof stats);
  q.path = PKTRT_PATH_PAPER, q.packet_size = p->n, q.stats = &stats, q.trace = hear, q.user = p;
  p->events = 0;
  if (p->any_hit) pktrt_occluded_ex(p->s, &q, p->ray, p->occluded, p->n);
  else pktrt_intersect_ex(p->s, &q, p->ray, p->hit, p->n);
  p->counts = stats.by_type[0];
}

/* --- hits --- */

static bool nearer(const pktrt_hit *a, const pktrt_hit *b) { /* than nothing, too */
  if (b->mesh == PKTRT_NONE || a->t != b->t) return b->mesh == PKTRT_NONE || a->t < b->t;
  return a->mesh != b->mesh ? a->mesh < b->mesh : a->triangle < b->triangle;
}

/* Whether a ray hits the triangle in a lane, as the reference has it. */
static bool hits_lane(
    const told *p, uint32_t group, uint32_t block, uint32_t lane, const pktrt_ray *ray, pktrt_hit *hit) {
  float corner[9];
  uint32_t index[3] = {0, 1, 2}, mesh_index, triangle;
  world one = world_none();
  if (!tree_lane(p->s, group, block, lane, &mesh_index, &triangle)) return false;
  const mesh *m = &p->w->m[mesh_index];
  for (uint32_t c = 0; c < 3; c++) ref_vertex(m, m->i[3 * triangle + c], ray->time, corner + 3 * c);
  one.m[0].p = corner, one.m[0].i = index, one.m[0].nv = 3, one.m[0].nt = one.m[0].keys = 1, one.n = 1;
  if (!ref_intersect(&one, ray, hit)) return false;
  hit->mesh = mesh_index, hit->triangle = triangle;
  return true;
}

typedef struct heard {    /* of one ray */
  uint32_t hits;          /* told */
  pktrt_hit best, before; /* told last; before the leaf at hand */
  uint32_t group, lanes;  /* of the leaf at hand; its lanes that were told */
} heard;

/* In a leaf where a ray has hit something it has met all triangles: those told are all that, from lane to lane, are nearer. */
static size_t faults_in_leaf(const told *p, uint32_t block, heard *ray) {
  size_t faults = 0;
  for (uint32_t r = 0; r < p->n; r++) {
    heard *h = &ray[r];
    uint32_t lanes = 0;
    pktrt_hit best = h->before, hit;
    for (uint32_t lane = 0; h->lanes && lane < 8; lane++)
      if (hits_lane(p, h->group, block, lane, &p->ray[r], &hit) && nearer(&hit, &best)) best = hit, lanes |= 1u << lane;
    if (p->any_hit) lanes &= h->lanes; /* one of them will do */
    faults += lanes != h->lanes;
    h->before = h->best, h->lanes = 0;
  }
  return faults;
}

static size_t hear_hit(const told *p, const pktrt_event *e, uint32_t block, heard *ray) {
  if (e->ray >= p->n || e->index != block) return 1;
  heard *h = &ray[e->ray];
  pktrt_hit hit;
  h->hits++;
  for (uint32_t g = 0; g < tree_groups(p->s); g++)
    if (hits_lane(p, g, e->index, e->child, &p->ray[e->ray], &hit) && nearer(&hit, &h->best)) {
      h->best = hit, h->group = g, h->lanes |= 1u << e->child;
      return 0;
    }
  return 1;
}

/* What is wrong with the hits that were told, and how many there were. */
static size_t faults_of_hits(const told *p, size_t *told_hits) {
  static heard ray[MOST_RAYS];
  size_t faults = 0;
  uint32_t block = PKTRT_NONE;
  memset(ray, 0, sizeof ray);
  for (uint32_t r = 0; r < p->n; r++) ray[r].best.mesh = ray[r].before.mesh = PKTRT_NONE;
  for (size_t i = 0; i < p->events; i++) {
    const pktrt_event *e = &p->event[i];
    if (e->kind == PKTRT_EVENT_HIT) faults += hear_hit(p, e, block, ray);
    if (e->kind == PKTRT_EVENT_LEAF) faults += faults_in_leaf(p, block, ray), block = e->index;
  }
  faults += faults_in_leaf(p, block, ray);
  for (uint32_t r = 0; r < p->n; r++) {
    const pktrt_hit *best = &ray[r].best, *hit = &p->hit[r];
    *told_hits += ray[r].hits;
    if (p->any_hit) faults += ray[r].hits != (p->occluded[r] ? 1 : 0);
    else if (hit->mesh == PKTRT_NONE) faults += ray[r].hits != 0;
    else faults += !ray[r].hits || best->mesh != hit->mesh || best->triangle != hit->triangle || best->t != hit->t;
  }
  return faults;
}

/* --- children: of scenes with one tree --- */

static bool is_verdict(const pktrt_event *e) {
  return (e->kind >= PKTRT_EVENT_FIRST_HIT && e->kind <= PKTRT_EVENT_ALL_MISS) || e->kind == PKTRT_EVENT_NONE_LEFT;
}
static bool enters(const pktrt_event *e) {
  return e->kind == PKTRT_EVENT_FIRST_HIT || e->kind == PKTRT_EVENT_LATER_HIT;
}

/* Nodes opened since the walk began, whose children did not each have one verdict. */
static size_t close_walk(const told *p, bool *open, uint8_t *seen) {
  size_t faults = 0;
  for (uint32_t n = 0; n < MOST_NODES; n++) faults += open[n] && seen[n] != tree_children(p->s, 0, n);
  memset(open, 0, MOST_NODES * sizeof *open), memset(seen, 0, MOST_NODES);
  return faults;
}

static size_t faults_of_children(const told *p, uint64_t *children) {
  static bool open[MOST_NODES];
  static uint8_t seen[MOST_NODES];
  size_t faults = 0;
  memset(open, 0, sizeof open), memset(seen, 0, sizeof seen);
  for (size_t i = 0; i < p->events; i++) {
    const pktrt_event *e = &p->event[i];
    const bool opens = e->kind == PKTRT_EVENT_NODE, begins = opens && e->index == 0;
    if (e->index >= MOST_NODES) return faults + 1;
    if (begins) faults += close_walk(p, open, seen);
    if (opens) faults += open[e->index], open[e->index] = true;
    if ((opens && !begins) || e->kind == PKTRT_EVENT_LEAF) faults += !i || !enters(e - 1);
    if (!is_verdict(e)) continue;
    faults += !open[e->index] || (seen[e->index] >> e->child & 1);
    seen[e->index] |= (uint8_t)(1u << e->child);
    ++*children;
  }
  return faults + close_walk(p, open, seen);
}

static size_t faults_of_counts(const told *p, uint64_t children) {
  const pktrt_counts *c = &p->counts;
  uint64_t n[PKTRT_EVENT_LEAF_TEST + 1];
  memset(n, 0, sizeof n);
  for (size_t i = 0; i < p->events; i++) n[p->event[i].kind]++;
  return (size_t)(c->node_visits != n[PKTRT_EVENT_NODE]) + (c->first_hits != n[PKTRT_EVENT_FIRST_HIT]) +
         (c->later_hits != n[PKTRT_EVENT_LATER_HIT]) + (c->interval_culls != n[PKTRT_EVENT_INTERVAL_CULL]) +
         (c->frustum_culls != n[PKTRT_EVENT_FRUSTUM_CULL]) + (c->ray_culls != n[PKTRT_EVENT_ALL_MISS]) +
         (!p->any_hit && n[PKTRT_EVENT_NONE_LEFT]) +
         (c->first_hits + c->later_hits + c->interval_culls + c->frustum_culls + c->ray_culls +
                 n[PKTRT_EVENT_NONE_LEFT] !=
             children);
}

/* --- packets --- */

static uint32_t main_axis(const pktrt_ray *r) {
  const float x = fabsf(r->direction[0]), y = fabsf(r->direction[1]), z = fabsf(r->direction[2]);
  return x >= y && x >= z ? 0 : y >= z ? 1 : 2;
}

/* Rays that hit something, in a group of eight whose main axes differ. */
static size_t hits_at_odds(const told *p) {
  size_t hits = 0;
  for (uint32_t r = 0; r < p->n; r += 8) {
    bool odds = false;
    const uint32_t end = r + 8 < p->n ? r + 8 : p->n;
    for (uint32_t i = r; i < end; i++) odds = odds || main_axis(&p->ray[i]) != main_axis(&p->ray[r]);
    for (uint32_t i = r; i < end; i++) hits += odds && (p->any_hit ? p->occluded[i] : p->hit[i].mesh != PKTRT_NONE);
  }
  return hits;
}

static world world_of_kind(int kind) {
  world w = kind == 2 ? world_moving(2) : world_static(2);
  for (uint32_t i = 0; kind == 1 && i < w.n; i++) mesh_move(&w.m[i], 4, 0.1f, 0.02f, i + 3);
  return w;
}
static const char *const world_names[3] = {"static", "four keys", "five trees"};
static const ray_kind kinds[3] = {RAYS_CAMERA, RAYS_BUNDLES, RAYS_RANDOM};

static told *packet_of(const world *w, const pktrt_scene *s) {
  told *p = calloc(1, sizeof *p);
  if (!p) abort();
  p->w = w, p->s = s;
  return p;
}

/* Every instruction set, coherent rays and rays at odds, the closest hit and any. */
static void told_of_world(int kind, bool of_children) {
  static const uint32_t sizes[4] = {64, 256, 8, 21};
  enum { RAYS = 1536 };
  static pktrt_ray ray[RAYS];
  world w = world_of_kind(kind);
  size_t faults = 0, hits = 0, at_odds[3] = {0, 0, 0};
  uint64_t children = 0;
  for (int isa = 0; isa < isa_count; isa++) {
    pktrt_scene *s = world_scene(&w, isas[isa], 0);
    told *p = packet_of(&w, s);
    for (int k = 0; k < 3; k++) {
      make_rays(&w, s, kinds[k], 5, 0, ray, RAYS);
      for (uint32_t i = 0, turn = 0; i < (small_run ? 256u : (uint32_t)RAYS); i += p->n, turn++) {
        p->ray = ray + i, p->n = sizes[(turn + (uint32_t)k) % 4];
        if (p->n > RAYS - i) p->n = RAYS - i;
        for (int any = 0; any < 2; any++) {
          uint64_t counted = 0;
          p->any_hit = any;
          ask(p);
          if (of_children) faults += faults_of_children(p, &counted), faults += faults_of_counts(p, counted);
          else faults += faults_of_hits(p, &hits);
          children += counted, at_odds[k] += hits_at_odds(p);
        }
      }
    }
    free(p);
    pktrt_scene_destroy(s);
  }
  CHECK(faults == 0, "%s: %zu faults", world_names[kind], faults);
  CHECK(at_odds[2] > 2 * at_odds[0] && (of_children ? children : hits) > 0, "%s: nothing was looked at",
      world_names[kind]);
  if (of_children) say("%s: %llu children, a verdict each", world_names[kind], (unsigned long long)children);
  else
    say("%s: %zu hits told; rays that hit, in groups of eight whose main axes differ: %zu of a camera, %zu others",
        world_names[kind], hits, at_odds[0], at_odds[1] + at_odds[2]);
  world_free(&w);
}

static void hits_are_told(void) {
  for (int kind = 0; kind < 3; kind++) told_of_world(kind, false);
}
static void children_are_accounted_for(void) {
  for (int kind = 0; kind < 2; kind++) told_of_world(kind, true);
}

/* --- one leaf, where every hit on the way to the nearest is known --- */

static void each_nearer_hit(void) {
  world w = world_of(mesh_of(24, 8));
  static pktrt_ray ray[64];
  size_t told_hits = 0, faults = 0, want = 0;
  rng g = rng_of(11);
  for (uint32_t i = 0; i < 24; i++) { /* eight triangles behind each other */
    w.m[0].p[3 * i] = i % 3 == 1 ? 9.0f : -3.0f, w.m[0].p[3 * i + 1] = i % 3 == 2 ? 9.0f : -3.0f;
    w.m[0].p[3 * i + 2] = -(float)(1 + i / 3), w.m[0].i[i] = i;
  }
  for (uint32_t i = 0; i < 64;
       i++) { /* eight from the front, eight from the back; of half of these, each second is flat */
    const float back = i / 8 % 2 ? 1.0f : -1.0f, flat = i % 2 && i % 32 < 16 ? 1.4f : 0.2f;
    const float x = flat * rng_unit(&g), y = flat * rng_range(&g, 0.8f, 1);
    ray[i] = ray_of(rng_sign(&g), rng_sign(&g), back < 0 ? 0.0f : -9.0f, x, y, back);
  }
  for (int isa = 0; isa < isa_count; isa++) {
    pktrt_scene *s = world_scene(&w, isas[isa], 0);
    told *p = packet_of(&w, s);
    p->ray = ray, p->n = 64;
    ask(p);
    faults += faults_of_hits(p, &told_hits);
    for (uint32_t r = 0; r < p->n; r++) {
      pktrt_hit hit, best;
      best.mesh = PKTRT_NONE;
      for (uint32_t lane = 0; lane < 8; lane++)
        if (hits_lane(p, 0, 0, lane, &ray[r], &hit) && nearer(&hit, &best)) best = hit, want++;
    }
    free(p);
    pktrt_scene_destroy(s);
  }
  CHECK(faults == 0 && told_hits == want, "%zu faults, %zu hits told of %zu", faults, told_hits, want);
  CHECK(want > 64 * (size_t)isa_count * 3 / 2, "each ray hits several triangles on its way to the nearest");
  say("%zu hits told, of %zu rays", told_hits, 64 * (size_t)isa_count);
  world_free(&w);
}

/* --- the controls: what is left out, told twice or wrong is noticed --- */

static void without(told *p, size_t i) {
  memmove(&p->event[i], &p->event[i + 1], (--p->events - i) * sizeof *p->event);
}
static void twice(told *p, size_t i) { memmove(&p->event[i + 1], &p->event[i], (p->events++ - i) * sizeof *p->event); }

static void faults_are_noticed(void) {
  world w = world_static(2);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  told *p = packet_of(&w, s), *copy = packet_of(&w, s);
  static pktrt_ray ray[64];
  size_t tried = 0, n = 0;
  uint64_t children = 0;
  make_rays(&w, s, RAYS_CAMERA, 5, 4096, ray, 64);
  p->ray = ray, p->n = 64;
  for (int any = 0; any < 2; any++) {
    p->any_hit = any;
    ask(p);
    CHECK(faults_of_hits(p, &n) == 0 && faults_of_children(p, &children) == 0);
    for (size_t i = 0; i < p->events; i++) {
      const bool hit = p->event[i].kind == PKTRT_EVENT_HIT, child = is_verdict(&p->event[i]);
      for (int how = 0; how < 3 && (hit || child); how++, tried++) {
        memcpy(copy, p, sizeof *p);
        if (how == 0) without(copy, i);
        else if (how == 1) twice(copy, i);
        else if (hit) copy->event[i].ray ^= 1;
        else copy->event[i].child ^= 1;
        CHECK(
            (hit ? faults_of_hits(copy, &n) : faults_of_children(copy, &children)) > 0, "event %zu, fault %d", i, how);
      }
    }
  }
  CHECK(tried > 200, "%zu faults tried", tried);
  say("%zu faults made, each was noticed", tried);
  free(p), free(copy);
  pktrt_scene_destroy(s);
  world_free(&w);
}

void suite_events(void) {
  run("the paper path tells each nearer hit once, the last one is the answer, and a ray that misses has none",
      hits_are_told);
  run("each nearer hit of a leaf is told, also of rays whose main axes differ", each_nearer_hit);
  run("each child of a node that a packet opens has one event, and the counts add up to them",
      children_are_accounted_for);
  run("hits and children that are told twice, wrongly or not at all are noticed", faults_are_noticed);
}
