/* Scenes that change for long: numbers and memory follow what is there, whatever comes and goes, and calls that run out of memory
   leave the scene as it was. */
#if !defined(_GNU_SOURCE)
#define _GNU_SOURCE /* MAP_ANONYMOUS */
#endif
#include "meshes.h"
#ifndef __EMSCRIPTEN__
#include <sys/mman.h>
#include <unistd.h>
#endif

/* --- memory that ends where pages end, and fails when it is told to --- */

typedef struct edge_memory {
  size_t fail_at;  /* the n-th allocation from now on fails, counted from 1; 0: none */
  bool fail_after; /* and all that follow it */
  bool edges;      /* what follows a block cannot be read */
  size_t failed, blocks, bytes;
} edge_memory;

#ifdef __EMSCRIPTEN__
static unsigned char *edge_map(size_t size) { return aligned_alloc(64, (size + 63) / 64 * 64); }
static void edge_unmap(void *p, size_t size) {
  (void)size;
  free(p);
}
#else
/* Returns how many bytes of pages a block takes, without the page behind it that cannot be read. */
static size_t edge_pages(size_t size) {
  const size_t page = (size_t)sysconf(_SC_PAGESIZE);
  return (size + page - 1) / page * page;
}
static unsigned char *edge_map(size_t size) {
  const size_t page = (size_t)sysconf(_SC_PAGESIZE), pages = edge_pages(size);
  unsigned char *p = mmap(NULL, pages + page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (p == MAP_FAILED || mprotect(p + pages, page, PROT_NONE)) abort();
  return p + (pages - size) / 64 * 64;
}
static void edge_unmap(void *p, size_t size) {
  const size_t page = (size_t)sysconf(_SC_PAGESIZE), pages = edge_pages(size);
  if (munmap((unsigned char *)p - (pages - size) / 64 * 64, pages + page)) abort();
}
#endif

static void *edge_allocate(void *user, size_t size, size_t align) {
  edge_memory *m = user;
  const bool fails = m->fail_at == 1;
  void *p = NULL;
  if (m->fail_at > 1 || (fails && !m->fail_after)) m->fail_at--;
  m->failed += fails;
  if (fails) return NULL;
  if (m->edges) p = edge_map(size);
  else if (posix_memalign(&p, align, size)) abort();
  memset(p, 0xA5, size);
  m->blocks++;
  m->bytes += size;
  return p;
}
static void edge_release(void *user, void *p, size_t size) {
  edge_memory *m = user;
  m->blocks--;
  m->bytes -= size;
  if (m->edges) edge_unmap(p, size);
  else free(p);
}

static pktrt_scene *open_scene(edge_memory *memory, pktrt_build_quality quality) {
  pktrt_scene_desc d;
  memset(&d, 0, sizeof d);
  d.allocate = edge_allocate, d.release = edge_release, d.user = memory;
  d.quality = quality, d.rebuild = PKTRT_REBUILD_NEVER;
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!CHECK(s != NULL)) abort();
  return s;
}

/* --- numbers --- */

/* Fills a scene with instances of a model up to the limit of triangles; returns how many it takes. */
static uint32_t fill_with(pktrt_scene *s, uint32_t model) {
  const pktrt_instance_desc at = {model, 0, NULL, 0, PKTRT_INTERPOLATION_LINEAR};
  uint32_t count = 0;
  pktrt_status status;
  while ((status = pktrt_add_instance(s, &at, NULL)) == PKTRT_OK) count++;
  CHECK(status == PKTRT_LIMIT, "status %d: %s", (int)status, pktrt_last_error(s));
  CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  return count;
}

/* Models of ever more triangles, without area, fill the scene one after the other. */
static void a_full_scene_can_be_filled_anew(void) {
  enum { TRIANGLES = 1 << 17, ROUNDS = 3 };
  static const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  uint32_t *indices = calloc((TRIANGLES + ROUNDS) * 3, sizeof *indices), refused = 0;
  pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
  pktrt_mesh_desc flat;
  d.quality = PKTRT_BUILD_FAST;
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!indices || !s) abort();
  memset(&flat, 0, sizeof flat);
  flat.positions = corners, flat.vertex_count = 3, flat.indices = indices;

  for (uint32_t round = 0; round < ROUNDS; round++) {
    const uint32_t triangles = TRIANGLES + round, want = PKTRT_MAX_TRIANGLES / triangles;
    uint32_t model = 0, index = 0;
    flat.triangle_count = triangles;
    CHECK(pktrt_add_model(s, &flat, 1, &model) == PKTRT_OK, "%s", pktrt_last_error(s));
    const uint32_t count = fill_with(s, model);
    CHECK(count == want, "round %u: room for %u instances of %u triangles, not %u", (unsigned)round, (unsigned)count,
        (unsigned)triangles, (unsigned)want);
    refused += pktrt_add_mesh(s, &flat, NULL) == PKTRT_LIMIT;
    for (uint32_t i = 0; i < count; i++) CHECK(pktrt_remove_instance(s, i) == PKTRT_OK, "%s", pktrt_last_error(s));
    CHECK(pktrt_add_mesh(s, &flat, &index) == PKTRT_OK, "removed, though not committed: %s", pktrt_last_error(s));
    CHECK(pktrt_remove_mesh(s, index) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  }

  CHECK(refused == ROUNDS, "control: what is full is full");
  say("%d times %u instances and more triangles than before in each; control: %u meshes more refused", (int)ROUNDS,
      (unsigned)(PKTRT_MAX_TRIANGLES / TRIANGLES), (unsigned)refused);
  pktrt_scene_destroy(s);
  free(indices);
}

/* --- replacements --- */

enum { PERIOD = 12, REPLACED = 5 };
static const char *const replaced_name[REPLACED] = {
    "growing", "shrinking", "alternating", "instances", "meshes and instances"};

/* What is there at a time of a replacement: a mesh and its group, or an instance of a model of several meshes. */
typedef struct replacement {
  pktrt_scene *s;
  const mesh *of;
  uint32_t models[3];
  bool instance;
  uint32_t index;
} replacement;

/* Returns by how many triangles the next mesh is smaller than the largest. */
static uint32_t smaller_by(int what, uint32_t round) {
  const uint32_t step = round % PERIOD;
  if (what == 0) return PERIOD - 1 - step;
  if (what == 1) return step;
  return step % 2 ? 0 : step;
}

static void add_next(replacement *r, int what, uint32_t round) {
  const pktrt_instance_desc at = {r->models[round * 7 % PERIOD % 3], 0, NULL, 0, PKTRT_INTERPOLATION_LINEAR};
  pktrt_mesh_desc d = mesh_desc(r->of);
  d.triangle_count -= smaller_by(what, round);
  d.group = round % 3;
  r->instance = what == 3 || (what == 4 && round * 5 % PERIOD % 2);
  const pktrt_status status =
      r->instance ? pktrt_add_instance(r->s, &at, &r->index) : pktrt_add_mesh(r->s, &d, &r->index);
  CHECK(status == PKTRT_OK, "%s, round %u: %s", replaced_name[what], (unsigned)round, pktrt_last_error(r->s));
}
static void remove_last(const replacement *r) {
  const pktrt_status status = r->instance ? pktrt_remove_instance(r->s, r->index) : pktrt_remove_mesh(r->s, r->index);
  CHECK(status == PKTRT_OK, "%s", pktrt_last_error(r->s));
}
static void settle(pktrt_scene *s) { CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s)); }

/* Returns how many of the rays at a sphere that stays say else than that it is mesh 1. */
static uint32_t look_at_sphere(const pktrt_scene *s, pktrt_hit *seen, bool first) {
  uint32_t others = 0;
  for (uint32_t i = 0; i < 16; i++) {
    rng r = rng_of(i);
    const pktrt_ray ray = ray_of(9 + 0.5f * rng_sign(&r), 0.5f * rng_sign(&r), 5, 0, 0, -1);
    pktrt_hit hit;
    pktrt_intersect(s, &ray, &hit);
    if (first) seen[i] = hit;
    others += hit.mesh != 1 || !same_bits(&hit, &seen[i], sizeof hit);
  }
  return others;
}

/* Replaces what a scene has at its first index, before a sphere of another group that stays. */
static void replace(int what, bool before, uint32_t rounds, const mesh *of, const mesh *sphere) {
  edge_memory memory = {0, false, false, 0, 0, 0};
  replacement r = {open_scene(&memory, PKTRT_BUILD_DEFAULT), of, {0, 0, 0}, false, 0};
  pktrt_mesh_desc parts[3] = {mesh_desc(of), mesh_desc(of), mesh_desc(of)}, stays = mesh_desc(sphere);
  pktrt_scene_info info[2];
  pktrt_hit seen[16];
  size_t bytes = 0, wrong = 0;
  uint32_t others = 0, indices = 0;
  parts[1].triangle_count -= 5;
  for (uint32_t k = 0; k < 3; k++)
    CHECK(pktrt_add_model(r.s, parts, k + 1, &r.models[k]) == PKTRT_OK, "%s", pktrt_last_error(r.s));
  stays.group = 9;
  add_next(&r, 0, 0);
  CHECK(pktrt_add_mesh(r.s, &stays, NULL) == PKTRT_OK, "%s", pktrt_last_error(r.s));
  settle(r.s);
  (void)look_at_sphere(r.s, seen, true);

  for (uint32_t round = 1; round <= rounds; round++) {
    const replacement last = r;
    if (!before) remove_last(&last), settle(r.s);
    add_next(&r, what, round);
    if (before) remove_last(&last);
    settle(r.s);
    others += look_at_sphere(r.s, seen, false);
    if (round % PERIOD) continue;
    pktrt_get_scene_info(r.s, &info[1]);
    if (round == 2 * PERIOD) info[0] = info[1], bytes = memory.bytes;
    wrong += round > 2 * PERIOD && (!same_bits(&info[0], &info[1], sizeof info[0]) || bytes != memory.bytes);
    indices = info[1].mesh_count;
  }

  CHECK(others == 0, "%s: %u hits of what stays are others", replaced_name[what], (unsigned)others);
  CHECK(wrong == 0 && indices <= 9,
      "%s, %s: %zu of %u periods end with other figures, %u indices, %zu bytes, first %zu", replaced_name[what],
      before ? "added before" : "added after", wrong, (unsigned)(rounds / PERIOD), (unsigned)indices, memory.bytes,
      bytes);
  if (before)
    say("%s: %u replacements, %zu bytes and %u indices at their end as after the second dozen", replaced_name[what],
        (unsigned)rounds, memory.bytes, (unsigned)indices);
  pktrt_scene_destroy(r.s);
  CHECK(memory.blocks == 0, "%zu blocks leak", memory.blocks);
}
static void replacements_end_with_what_they_began_with(void) {
  const uint32_t rounds = (uint32_t)(scaled(480) + thorough(1000000)) / PERIOD * PERIOD;
  mesh of = mesh_sphere(1, 0.05f, 3), sphere = mesh_sphere(2, 0.05f, 4);
  mesh_shift(&sphere, 9, 0, 0);
  for (int k = 0; k < 2 * REPLACED; k++) replace(k / 2, k % 2, rounds < 4 * PERIOD ? 4 * PERIOD : rounds, &of, &sphere);
  mesh_free(&of), mesh_free(&sphere);
}

/* --- histories --- */

enum { SHAPES = 4, VARIANTS = 4, THINGS = 12, MODELS = 3, RAYS = 48, CHAINS = 8, CHAIN = 24 };

/* A mesh or an instance, as the next commit will have it. */
typedef struct thing {
  bool there, instance, hidden;
  bool fresh, gone, moved; /* since the last commit or refit */
  uint32_t shape, variant; /* of an instance, its model */
  uint32_t group, cut;
  uint32_t index, place; /* its first mesh, and what it is called */
} thing;

typedef struct answers {
  pktrt_hit hit[RAYS + CHAINS * CHAIN];
  size_t count[CHAINS];
} answers;

typedef enum action { ADD_MESH, ADD_INSTANCE, REMOVE, MOVE, HIDE, MARK, REFIT, COMMIT, ACTIONS } action;
typedef struct change {
  action what;
  uint32_t which; /* the thing */
  thing to;
} change;

typedef struct history {
  edge_memory memory;
  pktrt_scene *s;
  pktrt_build_quality quality;
  mesh shapes[SHAPES][VARIANTS];
  thing things[THINGS];
  answers want;
  bool worn;                                  /* the last commit had positions that were set: others may be rebuilt */
  size_t steps, failed, wrong, changed, hits; /* changed: answers that a commit or refit changed */
} history;

static const float variant_scale[VARIANTS] = {1, 1, 1.25f, 1.25f}, variant_shift[VARIANTS] = {0, 0.5f, 0, 0.5f};

static void ask(const pktrt_scene *s, answers *a) {
  static pktrt_ray rays[RAYS];
  memset(a, 0, sizeof *a);
  for (uint32_t i = 0; i < RAYS; i++) {
    rng r = rng_of(i);
    float from[3], to[3];
    for (int k = 0; k < 3; k++) from[k] = 3 * rng_sign(&r), to[k] = rng_sign(&r);
    if (i % 4 == 0) to[0] = to[1] = to[2] = 0; /* at edges of some */
    rays[i] = ray_towards(from, to, rng_unit(&r));
  }
  pktrt_intersect_n(s, rays, a->hit, RAYS);
  for (uint32_t i = 0; i < CHAINS; i++)
    a->count[i] = pktrt_intersect_all(s, &rays[5 * i], a->hit + RAYS + i * CHAIN, CHAIN);
}

static pktrt_mesh_desc thing_desc(const history *h, const thing *t) {
  pktrt_mesh_desc d = mesh_desc(&h->shapes[t->shape][t->variant]);
  d.group = t->group, d.triangle_count -= t->cut;
  return d;
}
static void thing_transform(const thing *t, float at[12]) {
  memset(at, 0, 12 * sizeof *at);
  at[0] = at[5] = at[10] = variant_scale[t->variant], at[3] = variant_shift[t->variant];
}
/* Model k has the first k + 1 shapes. */
static void add_models(const history *h, pktrt_scene *s) {
  pktrt_mesh_desc d[MODELS];
  for (uint32_t k = 0; k < MODELS; k++) d[k] = mesh_desc(&h->shapes[k][0]);
  for (uint32_t k = 0; k < MODELS; k++)
    CHECK(pktrt_add_model(s, d, k + 1, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
}
static pktrt_status add_thing(const history *h, pktrt_scene *s, const thing *t, uint32_t *index) {
  float at[12];
  const pktrt_mesh_desc d = thing_desc(h, t);
  const pktrt_instance_desc place = {t->shape, 1, at, 0, PKTRT_INTERPOLATION_LINEAR};
  thing_transform(t, at);
  return t->instance ? pktrt_add_instance(s, &place, index) : pktrt_add_mesh(s, &d, index);
}

/* Finds what a scene answers that only ever had what is there. */
static void ask_fresh(const history *h, answers *a) {
  edge_memory memory = {0, false, false, 0, 0, 0};
  pktrt_scene *s = open_scene(&memory, h->quality);
  uint32_t real[THINGS * MODELS], n = 0;
  add_models(h, s);
  for (uint32_t done = 0, next; done < UINT32_MAX; done = next + 1) { /* in the order of their indices */
    const thing *t = NULL;
    next = UINT32_MAX - 1;
    for (uint32_t i = 0; i < THINGS; i++)
      if (h->things[i].there && h->things[i].index >= done && h->things[i].index < next)
        t = &h->things[i], next = t->index;
    if (!t) break;
    if (t->hidden) continue;
    CHECK(add_thing(h, s, t, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
    for (uint32_t k = 0; k < (t->instance ? t->shape + 1 : 1); k++) real[n++] = t->index + k;
  }
  settle(s);
  ask(s, a);
  for (size_t i = 0; i < COUNT(a->hit); i++) {
    const bool written = i < RAYS || (i - RAYS) % CHAIN < a->count[(i - RAYS) / CHAIN];
    if (written && a->hit[i].mesh < n) a->hit[i].mesh = real[a->hit[i].mesh];
  }
  pktrt_scene_destroy(s);
}

/* Makes the one call of a change. */
static pktrt_status call(history *h, const change *c, uint32_t *index) {
  const thing *t = &h->things[c->which];
  float at[12];
  switch (c->what) {
  case ADD_MESH:
  case ADD_INSTANCE: return add_thing(h, h->s, &c->to, index);
  case REMOVE: return t->instance ? pktrt_remove_instance(h->s, t->place) : pktrt_remove_mesh(h->s, t->place);
  case MOVE:
    thing_transform(&c->to, at);
    return t->instance ? pktrt_set_transform(h->s, t->place, 0, at)
                       : pktrt_set_positions(h->s, t->place, 0, h->shapes[t->shape][c->to.variant].p);
  case HIDE: return pktrt_set_enabled(h->s, t->index, !c->to.hidden);
  case MARK: return pktrt_mark_changed(h->s);
  case REFIT: return pktrt_refit(h->s);
  default: return pktrt_commit(h->s);
  }
}

/* Tells whether something waits for a commit, or for a refit. */
static bool waits(const history *h, bool moves) {
  bool any = false;
  for (uint32_t i = 0; i < THINGS; i++) any |= h->things[i].fresh || h->things[i].gone || (moves && h->things[i].moved);
  return any;
}

/* Takes over what a change that succeeded has changed. */
static void take_over(history *h, const change *c, uint32_t index) {
  thing *t = &h->things[c->which];
  if (c->what == ADD_MESH || c->what == ADD_INSTANCE) {
    *t = c->to;
    t->there = t->fresh = true, t->index = t->place = index;
    uint32_t instance = PKTRT_NONE;
    for (uint32_t m = 0; t->instance && instance != index; m++) {
      if (!pktrt_get_mesh_source(h->s, m, &instance, NULL)) instance = PKTRT_NONE;
      t->index = m;
    }
  }
  if (c->what == REMOVE) t->there = false, t->gone = true;
  if (c->what == MOVE) t->variant = c->to.variant, t->moved = true;
  if (c->what == HIDE) t->hidden = c->to.hidden, t->moved = true;
  if (c->what < REFIT) return;
  answers now;
  ask_fresh(h, &now);
  h->changed += !same_bits(&now, &h->want, sizeof now);
  h->want = now;
  for (uint32_t i = 0; i < THINGS; i++) h->things[i].fresh = h->things[i].gone = h->things[i].moved = false;
}

/* Asks the scene, and keeps whether it answers as it should. */
static void compare(history *h, const change *c, const char *when) {
  answers now;
  ask(h->s, &now);
  const bool same = same_bits(&now, &h->want, sizeof now);
  CHECK(same, "step %zu, action %d: other answers %s", h->steps, (int)c->what, when);
  h->wrong += !same;
  for (uint32_t i = 0; i < RAYS; i++) h->hits += now.hit[i].mesh != PKTRT_NONE;
}

/* Has the scene visit all of its meshes, which stay as they are: sets the positions that they have, and then refits or commits. */
static void visit_all(const history *h, bool refits) {
  for (uint32_t i = 0; i < THINGS; i++) {
    const thing *t = &h->things[i];
    if (!t->there || t->instance) continue;
    const float *same = h->shapes[t->shape][t->variant].p;
    CHECK(pktrt_set_positions(h->s, t->place, 0, same) == PKTRT_OK, "%s", pktrt_last_error(h->s));
  }
  const pktrt_status status = refits ? pktrt_refit(h->s) : pktrt_commit(h->s);
  CHECK(status == PKTRT_OK, "%s", pktrt_last_error(h->s));
}

/* Makes a change, at first with the n-th of its allocations failing, and then, with `each`, the next one, until it succeeds. */
static void perform(history *h, const change *c, size_t n, bool each) {
  uint32_t index = 0;
  h->steps++;
  for (;; n = each ? n + 1 : 0) {
    h->memory.fail_at = n, h->memory.fail_after = n & 1;
    const size_t failed = h->memory.failed;
    const pktrt_status status = call(h, c, &index);
    h->memory.fail_at = 0;
    if (h->memory.failed == failed) {
      const pktrt_status want = c->what == REFIT && waits(h, false) ? PKTRT_NOT_COMMITTED : PKTRT_OK;
      CHECK(status == want, "step %zu, action %d: status %d, %s", h->steps, (int)c->what, (int)status,
          pktrt_last_error(h->s));
      if (status == PKTRT_OK) take_over(h, c, index);
      compare(h, c, "after it");
      return;
    }
    h->failed++;
    CHECK(status == PKTRT_OUT_OF_MEMORY && strstr(pktrt_last_error(h->s), "memory"),
        "step %zu, action %d, allocation %zu: status %d, %s", h->steps, (int)c->what, n, (int)status,
        pktrt_last_error(h->s));
    if (!waits(h, true)) {
      visit_all(h, true);
      visit_all(h, false);
    }
    compare(h, c, "after it failed");
  }
}

static void history_open(history *h, bool edges, pktrt_build_quality quality) {
  memset(h, 0, sizeof *h);
  h->memory.edges = edges, h->quality = quality;
  for (uint32_t v = 0; v < VARIANTS; v++) {
    h->shapes[0][v] = mesh_sphere(1, 0.05f, 3), h->shapes[1][v] = mesh_box(), h->shapes[2][v] = mesh_soup(40, 0.4f, 5);
    h->shapes[3][v] = mesh_sphere(2, 0.05f, 3);
    for (uint32_t k = 0; k < SHAPES; k++)
      mesh_place(&h->shapes[k][v], (float[3]){variant_scale[v], variant_scale[v], variant_scale[v]},
          (float[3]){variant_shift[v], 0, 0});
  }
  mesh_move(&h->shapes[1][0], 1, 0, 0, 0);
  h->s = open_scene(&h->memory, quality);
  add_models(h, h->s);
  settle(h->s);
  ask(h->s, &h->want);
}
static void history_close(history *h) {
  pktrt_scene_destroy(h->s);
  for (uint32_t k = 0; k < SHAPES * VARIANTS; k++) mesh_free(&h->shapes[k / VARIANTS][k % VARIANTS]);
  h->wrong += !CHECK(h->memory.blocks == 0, "%zu blocks leak", h->memory.blocks);
}

/* Draws a change that the things allow. */
static change draw(const history *h, rng *r) {
  static const action likely[] = {
      ADD_MESH, ADD_MESH, ADD_INSTANCE, REMOVE, REMOVE, MOVE, MOVE, HIDE, MARK, REFIT, REFIT, COMMIT, COMMIT, COMMIT};
  for (;;) {
    change c;
    memset(&c, 0, sizeof c);
    c.what = likely[rng_below(r, COUNT(likely))], c.which = rng_below(r, THINGS);
    const thing *t = &h->things[c.which];
    c.to = *t;
    if (c.what >= MARK) return c;
    if (c.what > ADD_INSTANCE) {
      c.to.variant = rng_below(r, VARIANTS), c.to.hidden = !t->hidden;
      if (t->there) return c;
    } else if (!t->there && !t->gone) {
      memset(&c.to, 0, sizeof c.to);
      c.to.instance = c.what == ADD_INSTANCE;
      c.to.shape = rng_below(r, c.to.instance ? MODELS : SHAPES), c.to.variant = rng_below(r, VARIANTS);
      c.to.group = rng_below(r, 8), c.to.cut = rng_below(r, 8);
      return c;
    }
  }
}

static void histories_have_the_answers_of_what_is_there(void) {
  const size_t histories = scaled(240) + thorough(20000);
  size_t steps = 0, failed = 0, wrong = 0, changed = 0, hits = 0;
  for (size_t i = 0; i < (histories < 12 ? 12 : histories); i++) {
    rng r = rng_of(i);
    history h;
    history_open(&h, false, (pktrt_build_quality)(i % 3));
    for (uint32_t k = 0; k < 40 && !h.wrong; k++) {
      const change c = draw(&h, &r);
      perform(&h, &c, rng_below(&r, 2) ? 1 + rng_below(&r, 20) : 0, false);
    }
    history_close(&h);
    steps += h.steps, failed += h.failed, wrong += h.wrong, changed += h.changed, hits += h.hits;
  }
  CHECK(wrong == 0 && failed > steps / 16 && changed > steps / 16 && hits > steps, "%zu, %zu, %zu of %zu", failed,
      changed, hits, steps);
  say("%zu histories, %zu steps, %zu of them failed at first: %zu wrong; control: %zu commits and refits changed "
      "answers",
      histories, steps, failed, wrong, changed);
}

/* Eight meshes, as many as the list has room for at first, then one change after the other. */
static void each_allocation_of_each_change_failing(void) {
  enum { FIRST = 8 };
  static const change script[] = {
      {ADD_MESH, 8, {false, false, false, false, false, false, 1, 1, 0, 3, 0, 0}},
      {MOVE, 3, {false, false, false, false, false, false, 0, 3, 0, 0, 0, 0}},
      {COMMIT, 0, {false, false, false, false, false, false, 0, 0, 0, 0, 0, 0}},
      {MOVE, 2, {false, false, false, false, false, false, 0, 1, 0, 0, 0, 0}},
      {REFIT, 0, {false, false, false, false, false, false, 0, 0, 0, 0, 0, 0}},
      {REMOVE, 0, {false, false, false, false, false, false, 0, 0, 0, 0, 0, 0}},
      {ADD_INSTANCE, 9, {false, true, false, false, false, false, 2, 1, 0, 0, 0, 0}},
      {COMMIT, 0, {false, false, false, false, false, false, 0, 0, 0, 0, 0, 0}},
      {ADD_MESH, 10, {false, false, false, false, false, false, 3, 0, 0, 0, 0, 0}},
      {HIDE, 4, {false, false, true, false, false, false, 0, 0, 0, 0, 0, 0}},
      {COMMIT, 0, {false, false, false, false, false, false, 0, 0, 0, 0, 0, 0}},
      {MOVE, 9, {false, false, false, false, false, false, 0, 2, 0, 0, 0, 0}},
      {REFIT, 0, {false, false, false, false, false, false, 0, 0, 0, 0, 0, 0}},
      {REMOVE, 9, {false, false, false, false, false, false, 0, 0, 0, 0, 0, 0}},
      {ADD_INSTANCE, 0, {false, true, false, false, false, false, 1, 3, 0, 0, 0, 0}},
      {MARK, 0, {false, false, false, false, false, false, 0, 0, 0, 0, 0, 0}},
      {COMMIT, 0, {false, false, false, false, false, false, 0, 0, 0, 0, 0, 0}},
      {ADD_INSTANCE, 9, {false, true, false, false, false, false, 0, 0, 0, 0, 0, 0}},
      {COMMIT, 0, {false, false, false, false, false, false, 0, 0, 0, 0, 0, 0}},
  };
  size_t failed = 0, wrong = 0, changed = 0;
  for (int k = 0; k < 4; k++) { /* in one group, or in so many that a tree lies above them */
    history h;
    history_open(&h, true, k / 2 ? PKTRT_BUILD_HIGH : PKTRT_BUILD_DEFAULT);
    for (uint32_t i = 0; i < FIRST; i++) {
      change c;
      memset(&c, 0, sizeof c);
      c.what = ADD_MESH, c.which = i;
      c.to.shape = i % SHAPES, c.to.variant = i / 2 % VARIANTS, c.to.group = k % 2 ? i : 0;
      perform(&h, &c, 1, true);
    }
    perform(&h, &script[2], 1, true);
    for (size_t i = 0; i < COUNT(script); i++) perform(&h, &script[i], 1, true);
    history_close(&h);
    failed += h.failed, wrong += h.wrong, changed += h.changed;
  }
  CHECK(wrong == 0 && failed > 400 && changed > 20, "%zu, %zu", failed, changed);
  say("%zu allocations failed in turn: %zu wrong; control: %zu commits and refits changed answers", failed, wrong,
      changed);
}

void suite_changes(void) {
  run("a scene that was full can be filled anew with larger models", a_full_scene_can_be_filled_anew);
  run("replacements that grow, shrink or alternate end with the memory and indices that they began with",
      replacements_end_with_what_they_began_with);
  run("histories of changes, some of them without memory at first, have the answers of what is there",
      histories_have_the_answers_of_what_is_there);
  run("each allocation of each change failing, the scene answers as before, and then as it should",
      each_allocation_of_each_change_failing);
}
