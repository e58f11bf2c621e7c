/* Groups, masks, removal and hiding of meshes: the bits of a scene of the meshes that are seen, alone and without groups; what
   waits, what is refused, memory, and work. */
#include "pictures.h"
#include "ways.h"

/* --- a world cut to pieces, each a mesh --- */

enum { PIECES = 40, SOURCES = 4 };
typedef struct piece {
  uint32_t source, first, count; /* a run of triangles of a mesh of the world */
  uint32_t group, mask, index;   /* index: in the scene */
  bool there, hidden;
} piece;
typedef struct parts {
  world w;
  piece of[PIECES];
  pktrt_scene *s;
} parts;

/* WHY these: up to four trees of groups are visited one by one, more have a tree above them. */
typedef enum grouping {
  NO_GROUPS,
  FOUR_TREES,
  SOME_IN_FEW,
  FIVE_TREES,
  EACH_ITS_OWN,
  SOME_THEIR_OWN,
  GROUPINGS
} grouping;
static uint32_t group_of(grouping g, uint32_t k) {
  switch (g) {
  case FOUR_TREES: return 7; /* of 1, 2, 3 and 5 keys */
  case SOME_IN_FEW: return k % SOURCES < 2 ? 1 + k % SOURCES : 0;
  case FIVE_TREES: return k == 5 ? 9 : 7;
  case EACH_ITS_OWN: return k + 1;
  case SOME_THEIR_OWN: return k % 3 ? UINT32_MAX - k : 0;
  default: return 0;
  }
}

static pktrt_scene *open_scene(pktrt_isa isa) {
  const pktrt_scene_desc d = scene_desc_of(isa, 0);
  return pktrt_scene_create(&d);
}
/* Of rays on an instruction set: the scalar one is slow. */
static size_t rays_on(pktrt_isa isa, size_t n) { return small_run ? 20 : isa == PKTRT_ISA_SCALAR ? n / 3 : n; }
static void settle(pktrt_scene *s, bool refit) {
  CHECK((refit ? pktrt_refit(s) : pktrt_commit(s)) == PKTRT_OK, "%s", pktrt_last_error(s));
}

static pktrt_mesh_desc piece_desc(const parts *p, const piece *x) {
  pktrt_mesh_desc d = mesh_desc(&p->w.m[x->source]);
  d.indices += 3 * (size_t)x->first, d.triangle_count = x->count;
  return d;
}
static void add_piece(parts *p, uint32_t k) {
  pktrt_mesh_desc d = piece_desc(p, &p->of[k]);
  d.group = p->of[k].group, d.mask = p->of[k].mask;
  CHECK(pktrt_add_mesh(p->s, &d, &p->of[k].index) == PKTRT_OK, "%s", pktrt_last_error(p->s));
  p->of[k].there = true, p->of[k].hidden = false;
}
/* Cuts a world, which it takes, and adds the pieces to a scene, which is committed. */
static void parts_open(parts *p, world w, grouping g, pktrt_isa isa) {
  memset(p, 0, sizeof *p);
  p->w = w, p->s = open_scene(isa);
  for (uint32_t k = 0; k < PIECES; k++) {
    piece *x = &p->of[k];
    const uint32_t nt = w.m[k % SOURCES].nt, part = k / SOURCES, parts_of_each = PIECES / SOURCES;
    x->source = k % SOURCES, x->first = nt * part / parts_of_each,
    x->count = nt * (part + 1) / parts_of_each - x->first;
    x->group = group_of(g, k);
    add_piece(p, k);
  }
  settle(p->s, false);
}
static void parts_close(parts *p) {
  pktrt_scene_destroy(p->s);
  world_free(&p->w);
}

/* Makes the scene of what queries of a mask (0: all) must see, in order of indices, without groups and masks. */
static pktrt_scene *seen_scene(const parts *p, uint32_t mask, pktrt_isa isa, uint32_t map[PIECES], uint32_t *n) {
  pktrt_scene *s = open_scene(isa);
  *n = 0;
  for (uint32_t index = 0; index < 4 * PIECES; index++)
    for (uint32_t k = 0; k < PIECES; k++) {
      const piece *x = &p->of[k];
      if (!x->there || x->hidden || x->index != index || (mask && x->mask && !(x->mask & mask))) continue;
      const pktrt_mesh_desc d = piece_desc(p, x);
      CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
      map[(*n)++] = index;
    }
  settle(s, false);
  return s;
}
static size_t compare_parts(const parts *p, uint32_t mask, size_t n, size_t *wrong) {
  uint32_t map[PIECES];
  expected_scene want = {NULL, map, mask, 0};
  pktrt_scene *s = seen_scene(p, mask, PKTRT_ISA_AUTO, map, &want.meshes);
  want.s = s;
  const size_t hits = compare_with(&want, p->s, &p->w, n, wrong);
  pktrt_scene_destroy(s);
  return hits;
}

/* --- groups --- */

static void groups_change_no_bits(void) {
  size_t wrong = 0, hits = 0, control = 0, scenes = 0;
  for (int moving = 0; moving < 2; moving++)
    for (int k = 0; k < isa_count; k++)
      for (int g = FOUR_TREES; g < GROUPINGS; g++) {
        parts p;
        if (small_run && (g + k) % 3 != moving) continue;
        scenes++;
        parts_open(&p, moving ? world_moving(2) : world_static(2), (grouping)g, isas[k]);
        hits += compare_parts(&p, 0, rays_on(isas[k], 96), &wrong);
        mesh *m = &p.w.m[0];
        m->p[3 * m->i[0]] += 0.001f; /* of what it is compared with */
        if (k == 0) (void)compare_parts(&p, 0, 96, &control);
        parts_close(&p);
      }
  CHECK(wrong == 0, "%zu answers differ", wrong);
  CHECK(control > 5 && hits > 63 * scenes, "%zu hits, control %zu", hits, control);
  say("%zu scenes, %zu hits, seven ways each: %zu differ; control, a vertex moved by a thousandth: %zu differ", scenes,
      hits, wrong, control);
}

/* --- a scene that changes --- */

static void deform(parts *p, uint32_t source, uint64_t seed) {
  mesh *m = &p->w.m[source];
  rng r = rng_of(seed);
  for (size_t i = 0; i < (size_t)m->keys * m->nv * 3; i++) m->p[i] += 0.02f * rng_sign(&r);
  for (uint32_t k = 0; k < PIECES; k++)
    for (uint32_t key = 0; key < m->keys && p->of[k].source == source && p->of[k].there; key++)
      CHECK(pktrt_set_positions(p->s, p->of[k].index, key, m->p + (size_t)key * m->nv * 3) == PKTRT_OK, "%s",
          pktrt_last_error(p->s));
}
static void show(parts *p, uint32_t k, bool enabled) {
  if (!p->of[k].there) return;
  CHECK(pktrt_set_enabled(p->s, p->of[k].index, enabled) == PKTRT_OK, "%s", pktrt_last_error(p->s));
  p->of[k].hidden = !enabled;
}
static void take_away(parts *p, uint32_t k) {
  if (!p->of[k].there) return;
  CHECK(pktrt_remove_mesh(p->s, p->of[k].index) == PKTRT_OK, "%s", pktrt_last_error(p->s));
  p->of[k].there = false;
}

static void deform_two(parts *p) { deform(p, 0, 1), deform(p, 1, 2); }
static void deform_others(parts *p) { deform(p, 2, 3), deform(p, 3, 4); }
static void hide_some(parts *p) {
  for (uint32_t k = 0; k < PIECES; k += 3) show(p, k, false);
}
static void hide_others(parts *p) {
  for (uint32_t k = 0; k < PIECES; k++) show(p, k, k % SOURCES != 1 && k % 5 != 2);
}
static void show_all(parts *p) {
  for (uint32_t k = 0; k < PIECES; k++) show(p, k, true);
}
static void remove_some(parts *p) {
  for (uint32_t k = 1; k < PIECES; k += 4) take_away(p, k);
  take_away(p, 3), take_away(p, 8);
}
static void add_again(parts *p) {
  for (uint32_t k = PIECES; k-- > 0;)
    if (!p->of[k].there) add_piece(p, k);
}
static void change_all_at_once(parts *p) {
  hide_some(p), deform_two(p), remove_some(p), deform_others(p), show(p, 6, true);
  CHECK(pktrt_mark_changed(p->s) == PKTRT_OK);
}
static void remove_nearly_all(parts *p) {
  for (uint32_t k = 3; k < PIECES; k++) take_away(p, k);
}
static void add_to_one_group(parts *p) {
  for (uint32_t k = 0; k < PIECES; k++) p->of[k].group = p->of[k].there ? p->of[k].group : 1;
  add_again(p);
}
static void remove_all(parts *p) {
  for (uint32_t k = 0; k < PIECES; k++) take_away(p, k);
}
static void add_in_many(parts *p) {
  for (uint32_t k = 0; k < PIECES; k++) p->of[k].group = 100 + k % 13;
  add_again(p);
}
static void add_hidden(parts *p) { add_in_many(p), hide_some(p); }

static const struct step {
  const char *name;
  void (*change)(parts *);
  bool refit;
} steps[] = {
    {"deformed, refitted", deform_two, true},
    {"others deformed, committed", deform_others, false},
    {"some hidden, refitted", hide_some, true},
    {"others hidden, committed", hide_others, false},
    {"what is hidden deformed, refitted", deform_two, true},
    {"all shown, refitted", show_all, true},
    {"some hidden, committed", hide_some, false},
    {"all shown, committed", show_all, false},
    {"some removed", remove_some, false},
    {"some deformed beside what is gone, refitted", deform_others, true},
    {"added again", add_again, false},
    {"all of that at once", change_all_at_once, false},
    {"added again, some hidden", add_again, false},
    {"nearly all removed", remove_nearly_all, false},
    {"added to one group", add_to_one_group, false},
    {"all removed", remove_all, false},
    {"added in many groups, some hidden from the start", add_hidden, false},
    {"these shown, refitted", show_all, true},
};

typedef struct course {
  size_t wrong, hits, early, changed; /* early: answers that did not wait; changed: the control of it */
} course;
static void take_step(parts *p, const struct step *step, size_t n, course *c) {
  static pktrt_ray rays[MANY];
  static answers before, waiting, after;
  size_t wrong = 0;
  make_rays(&p->w, p->s, RAYS_RANDOM, 3, 0, rays, n);
  ask(p->s, 1, rays, n, &before);
  step->change(p);
  ask(p->s, 1, rays, n, &waiting);
  c->early += differ(&before, &waiting, n);
  ask(p->s, 0, rays, n, &waiting);
  c->early += differ(&before, &waiting, n);
  settle(p->s, step->refit);
  ask(p->s, 1, rays, n, &after);
  const size_t changed = differ(&before, &after, n);
  c->hits += compare_parts(p, 0, n, &wrong);
  c->wrong += wrong, c->changed += changed;
  CHECK(wrong == 0, "%s: %zu answers differ", step->name, wrong);
}

static void what_is_seen_has_the_bits_of_a_scene_of_it(void) {
  static const grouping groupings[3] = {EACH_ITS_OWN, SOME_IN_FEW, NO_GROUPS};
  course c = {0, 0, 0, 0};
  for (int k = 0; k < isa_count; k++)
    for (int g = 0; g < 3; g++) { /* all of them on the widest set, others on some */
      parts p;
      if (g != k % 3 && k != isa_count - 1) continue;
      parts_open(&p, world_moving(1), groupings[g], isas[k]);
      for (size_t i = 0; i < COUNT(steps); i++) take_step(&p, &steps[i], rays_on(isas[k], 72), &c);
      parts_close(&p);
    }
  CHECK(c.wrong == 0 && c.hits > 1000, "%zu of %zu hits", c.wrong, c.hits);
  CHECK(
      c.early == 0 && c.changed > 100, "%zu answers changed before the commit or refit, %zu by it", c.early, c.changed);
  say("%zu changes, %zu hits: %zu answers differ from those of a scene of what is seen, %zu did not wait; control: %zu "
      "changed at the commit or refit",
      COUNT(steps) * (size_t)(isa_count + 2), c.hits, c.wrong, c.early, c.changed);
}

/* What was hidden is shown with the bits that it had, and is nowhere meanwhile. */
static void hidden_meshes_come_back(void) {
  static pktrt_ray rays[MANY];
  static answers before, hidden, now;
  parts p;
  size_t seen = 0, were = 0;
  parts_open(&p, world_moving(2), SOME_THEIR_OWN, PKTRT_ISA_AUTO);
  make_rays(&p.w, p.s, RAYS_RANDOM, 1, 0, rays, MANY);
  ask(p.s, 1, rays, MANY, &before);
  for (int refits = 0; refits < 4; refits++) {
    for (uint32_t k = 0; k < PIECES; k += 2) show(&p, k, false);
    settle(p.s, refits & 1);
    ask(p.s, 1, rays, MANY, &hidden);
    for (size_t i = 0; i < MANY; i++) {
      seen += hidden.hit[i].mesh != PKTRT_NONE && hidden.hit[i].mesh % 2 == 0;
      were += before.hit[i].mesh != PKTRT_NONE && before.hit[i].mesh % 2 == 0;
    }
    for (uint32_t k = 0; k < PIECES; k += 2) show(&p, k, true);
    settle(p.s, refits & 2);
    ask(p.s, 1, rays, MANY, &now);
    CHECK(differ(&before, &now, MANY) == 0, "%d: %zu answers differ", refits, differ(&before, &now, MANY));
    CHECK(differ(&before, &hidden, MANY) > 50, "the control: hidden, they differ");
  }
  CHECK(seen == 0 && were > 100, "%zu hits of hidden meshes; shown: %zu", seen, were);
  say("%zu hits of hidden meshes; control, shown: %zu", seen, were);
  parts_close(&p);
}

/* Groups of nothing, of triangles without area, and of one triangle in a plane along two axes: of all axes, or of one. */
static world odd_world(int axis) {
  static const float flat[3][9] = {
      {1, -1, -1, 1, 1, -1, 1, 0, 1}, {-1, 1, -1, 1, 1, -1, 0, 1, 1}, {-1, -1, 1, 1, -1, 1, 0, 1, 1}};
  world w = world_none();
  for (w.n = 0; w.n < 8; w.n++) {
    mesh *m = &w.m[w.n];
    *m = mesh_of(3, w.n != 3);
    for (uint32_t c = 0; c < 9 && w.n != 4; c++)
      m->p[c] = flat[axis < 3 ? axis : (int)w.n % 3][c] * (w.n < 3 ? 1 : 0.75f);
    for (uint32_t c = 0; c < 3; c++) m->p[3 * c + (uint32_t)axis % 3] += 0.125f * (float)w.n * (w.n != 4);
    for (uint32_t c = 0; c < 3 && m->nt; c++) m->i[c] = c;
  }
  return w;
}
static void odd_groups_harm_nothing(void) {
  size_t wrong = 0, hits = 0, control = 0;
  for (int k = 0; k < isa_count; k++)
    for (int axis = 0; axis < 4; axis++) {
      world w = odd_world(axis);
      pktrt_scene *want = world_scene(&w, isas[k], 0), *s = open_scene(isas[k]);
      for (uint32_t i = 0; i < w.n; i++) {
        pktrt_mesh_desc d = mesh_desc(&w.m[i]);
        d.group = 1 + i;
        CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
      }
      settle(s, false);
      hits += compare(want, s, &w, 96, &wrong);
      CHECK(pktrt_set_enabled(s, 1, false) == PKTRT_OK), settle(s, true);
      (void)compare(want, s, &w, 32, &control);
      CHECK(pktrt_set_enabled(s, 1, true) == PKTRT_OK), settle(s, true);
      (void)compare(want, s, &w, 32, &wrong);
      pktrt_scene_destroy(want), pktrt_scene_destroy(s);
      world_free(&w);
    }
  CHECK(wrong == 0 && hits > 250 * (size_t)isa_count && control > 100, "%zu of %zu differ, control %zu", wrong, hits,
      control);
  say("%zu hits, %zu differ; control, one hidden: %zu differ", hits, wrong, control);
}

/* Trees of groups that a refit builds anew by itself, below the tree above them, with hidden meshes among them. */
static void rebuilds_of_groups(void) {
  size_t wrong = 0, hits = 0;
  for (int workers = 0; workers < 3; workers += 2) {
    parts p;
    pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, workers);
    parts_open(&p, world_moving(3), NO_GROUPS, PKTRT_ISA_AUTO);
    pktrt_scene_destroy(p.s);
    d.rebuild = PKTRT_REBUILD_AUTOMATIC, p.s = pktrt_scene_create(&d);
    for (uint32_t k = 0; k < PIECES; k++) p.of[k].group = 1 + k % 20, add_piece(&p, k);
    settle(p.s, false);
    hide_some(&p), settle(p.s, true);
    mesh *m = &p.w.m[0];
    rng r = rng_of(3);
    for (size_t i = 0; i < (size_t)m->keys * m->nv * 3; i++) m->p[i] = rng_sign(&r);
    deform(&p, 0, 3);
    hooks.notes = 0;
    settle(p.s, true);
    CHECK(hooks.notes > 0, "the control: trees are built anew");
    hits += compare_parts(&p, 0, 64, &wrong);
    show_all(&p), settle(p.s, true);
    hits += compare_parts(&p, 0, 64, &wrong);
    parts_close(&p);
  }
  CHECK(wrong == 0 && hits > 500, "%zu of %zu differ", wrong, hits);
}

/* --- masks --- */

static const uint32_t mesh_masks[7] = {0, 1, 2, 0x80000000u, 3, 4, 6};
static const uint32_t query_masks[6] = {1, 2, 4, 0x80000001u, 8, UINT32_MAX};

/* Gives masks to pieces that are in the scene, anew: masks are those of what is added. */
static void give_masks(parts *p, grouping g) {
  remove_all(p);
  for (uint32_t k = 0; k < PIECES; k++) p->of[k].mask = mesh_masks[k % 7], p->of[k].group = group_of(g, k);
  add_again(p);
  settle(p->s, false);
}

static void masks_choose_meshes(void) {
  static const grouping groupings[3] = {NO_GROUPS, FIVE_TREES, EACH_ITS_OWN};
  size_t wrong = 0, hits = 0, control = 0, all = 0;
  for (int k = 0; k < isa_count; k++)
    for (int g = 0; g < 3; g++) {
      const size_t n = rays_on(isas[k], 72);
      parts p;
      if (g != k % 3 && k != isa_count - 1) continue;
      parts_open(&p, g == 2 ? world_static(1) : world_moving(1), NO_GROUPS, isas[k]);
      give_masks(&p, groupings[g]);
      for (int q = 0; q < 6; q++) hits += compare_parts(&p, query_masks[q], n, &wrong);
      all += compare_parts(&p, 0, n, &wrong); /* which sees everything */
      hide_some(&p), settle(p.s, true);
      hits += compare_parts(&p, 2, n, &wrong);
      for (uint32_t i = 1; i < PIECES; i += 7) p.of[i].mask = 2; /* of what it is compared with */
      (void)compare_parts(&p, 2, n, &control);
      parts_close(&p);
    }
  CHECK(wrong == 0, "%zu answers differ", wrong);
  CHECK(hits > 1000 && all > 300 && control > 10, "%zu and %zu hits, control %zu", hits, all, control);
  say("%zu hits with masks, %zu without: %zu differ from a scene of what the mask sees; control, a mesh's mask said to "
      "be another: %zu differ",
      hits, all, wrong, control);
}

/* Arrays of structures and structures of arrays agree with a mask, too. */
static void masks_in_structures_of_arrays(void) {
  enum { N = 512 };
  static pktrt_ray rays[N];
  static pktrt_hit hits[2][N];
  static float in[9][N], t[N];
  static uint32_t met[N];
  static bool occluded[2][N];
  parts p;
  size_t wrong = 0, control = 0;
  parts_open(&p, world_static(1), NO_GROUPS, PKTRT_ISA_AUTO);
  give_masks(&p, EACH_ITS_OWN);
  make_rays(&p.w, p.s, RAYS_RANDOM, 1, 0, rays, N);
  pktrt_rays soa = {{in[0], in[1], in[2]}, {in[3], in[4], in[5]}, in[6], in[7], in[8]};
  pktrt_hits out = {t, NULL, NULL, {NULL, NULL, NULL}, met, NULL};
  for (size_t i = 0; i < N; i++) {
    for (int a = 0; a < 3; a++) in[a][i] = rays[i].origin[a], in[3 + a][i] = rays[i].direction[a];
    in[6][i] = rays[i].tmin, in[7][i] = rays[i].tmax, in[8][i] = rays[i].time;
  }
  for (int k = 0; k < 6; k++) {
    pktrt_query_desc q;
    memset(&q, 0, sizeof q);
    pktrt_intersect_ex(p.s, &q, rays, hits[1], N);
    q.mask = query_masks[k];
    pktrt_intersect_ex(p.s, &q, rays, hits[0], N), pktrt_occluded_ex(p.s, &q, rays, occluded[0], N);
    pktrt_intersect_soa_ex(p.s, &q, &soa, &out, N), pktrt_occluded_soa_ex(p.s, &q, &soa, occluded[1], N);
    for (size_t i = 0; i < N; i++) {
      wrong += met[i] != hits[0][i].mesh || !same_bits(&t[i], &hits[0][i].t, sizeof t[i]) ||
               occluded[0][i] != occluded[1][i] || occluded[0][i] != (met[i] != PKTRT_NONE);
      control += met[i] != hits[1][i].mesh;
    }
  }
  CHECK(wrong == 0 && control > N, "%zu wrong; without the mask %zu differ", wrong, control);
  parts_close(&p);
}

/* --- instances with masks, hidden, removed --- */

enum { PLACES = 14 };
typedef struct placed {
  float keys[24];
  uint32_t key_count, mask, model, index, first; /* first: its first mesh in the scene */
  bool there, hidden;
} placed;
typedef struct places {
  world w;
  uint32_t mask[SOURCES]; /* of the model's meshes; the second model is without its last two */
  placed of[PLACES];
  pktrt_scene *s;
} places;

static uint32_t model_size(uint32_t model) { return model ? SOURCES - 2 : SOURCES; }
static pktrt_status add_model(const places *p, pktrt_scene *s, const bool *in, bool masked, uint32_t *model) {
  pktrt_mesh_desc d[SOURCES];
  uint32_t n = 0;
  for (uint32_t m = 0; m < SOURCES; m++) {
    if (!in[m]) continue;
    d[n] = mesh_desc(&p->w.m[m]);
    d[n++].mask = masked ? p->mask[m] : 0;
  }
  return pktrt_add_model(s, d, n, model);
}
static void add_place(places *p, uint32_t k) {
  placed *x = &p->of[k];
  const pktrt_instance_desc d = {x->model, x->key_count, x->keys, x->mask, PKTRT_INTERPOLATION_LINEAR};
  uint32_t instance = PKTRT_NONE, of = PKTRT_NONE;
  CHECK(pktrt_add_instance(p->s, &d, &x->index) == PKTRT_OK, "%s", pktrt_last_error(p->s));
  for (x->first = 0; instance != x->index || of != 0; x->first++)
    if (!CHECK(x->first < 1000)) return;
    else if (!pktrt_get_mesh_source(p->s, x->first, &instance, &of)) instance = PKTRT_NONE;
  x->first--, x->there = true, x->hidden = false;
}
static void places_open(places *p, pktrt_isa isa) {
  static const uint32_t instance_masks[4] = {0, 1, 6, 8};
  bool all[SOURCES] = {true, true, true, true};
  rng r = {mix64(5)}; /* whatever the seed: others may flatten */
  memset(p, 0, sizeof *p);
  p->w = world_moving(1), p->s = open_scene(isa);
  p->mask[1] = 1, p->mask[2] = 2, p->mask[3] = 12;
  CHECK(!add_model(p, p->s, all, true, NULL), "%s", pktrt_last_error(p->s));
  all[2] = all[3] = false;
  CHECK(!add_model(p, p->s, all, true, NULL), "%s", pktrt_last_error(p->s));
  for (uint32_t k = 0; k < PLACES; k++) {
    placed *x = &p->of[k];
    x->key_count = 1 + k % 2, x->mask = instance_masks[k % 4], x->model = k % 3 == 2;
    for (int i = 0; i < 24; i++) x->keys[i] = (i % 4 == 3 ? 1.5f : 0.2f) * rng_sign(&r) + (i % 12 % 5 == 0 ? 0.8f : 0);
    for (int i = 12; i < 24; i++) x->keys[i] = x->keys[i - 12] + 0.1f * rng_sign(&r);
    add_place(p, k);
  }
  settle(p->s, false);
}
static void places_close(places *p) {
  pktrt_scene_destroy(p->s);
  world_free(&p->w);
}

/* As seen_scene: each instance shows a model of what is seen of it. */
static pktrt_scene *seen_places(const places *p, uint32_t mask, uint32_t map[PLACES * SOURCES], uint32_t *n) {
  pktrt_scene *s = open_scene(PKTRT_ISA_AUTO);
  *n = 0;
  for (uint32_t first = 0; first < 2 * PLACES * SOURCES; first++)
    for (uint32_t k = 0; k < PLACES; k++) {
      const placed *x = &p->of[k];
      bool in[SOURCES], any = false;
      if (!x->there || x->hidden || x->first != first || (mask && x->mask && !(x->mask & mask))) continue;
      for (uint32_t m = 0; m < SOURCES; m++) {
        in[m] = m < model_size(x->model) && (!mask || !p->mask[m] || p->mask[m] & mask);
        any |= in[m];
        if (in[m]) map[(*n)++] = first + m;
      }
      pktrt_instance_desc d = {0, x->key_count, x->keys, 0, PKTRT_INTERPOLATION_LINEAR};
      if (any)
        CHECK(!add_model(p, s, in, false, &d.model) && !pktrt_add_instance(s, &d, NULL), "%s", pktrt_last_error(s));
    }
  settle(s, false);
  return s;
}
static size_t compare_places(const places *p, uint32_t mask, size_t n, size_t *wrong) {
  uint32_t map[PLACES * SOURCES];
  expected_scene want = {NULL, map, mask, 0};
  pktrt_scene *s = seen_places(p, mask, map, &want.meshes);
  want.s = s;
  const size_t hits = compare_with(&want, p->s, &p->w, n, wrong);
  pktrt_scene_destroy(s);
  return hits;
}

static void masks_choose_instances(void) {
  size_t wrong = 0, hits = 0, control = 0;
  for (int k = 0; k < isa_count; k++) {
    const size_t n = rays_on(isas[k], 96);
    places p;
    places_open(&p, isas[k]);
    hits += compare_places(&p, 0, n, &wrong);
    for (int q = 0; q < 6; q++) hits += compare_places(&p, query_masks[q], n, &wrong);
    p.mask[1] = 2;
    (void)compare_places(&p, 1, n, &control);
    places_close(&p);
  }
  CHECK(wrong == 0 && hits > 250 * (size_t)isa_count && control > 10, "%zu of %zu differ, control %zu", wrong, hits,
      control);
  say("masks of %d instances and of the meshes of two models: %zu hits, %zu differ; control, a mask said to be "
      "another: "
      "%zu differ",
      PLACES, hits, wrong, control);
}

static void show_place(places *p, uint32_t k, bool enabled) {
  placed *x = &p->of[k];
  if (!x->there) return;
  CHECK(
      pktrt_set_enabled(p->s, x->first + model_size(x->model) - 1, enabled) == PKTRT_OK, "%s", pktrt_last_error(p->s));
  x->hidden = !enabled;
}
static void take_place(places *p, uint32_t k) {
  CHECK(pktrt_remove_instance(p->s, p->of[k].index) == PKTRT_OK, "%s", pktrt_last_error(p->s));
  p->of[k].there = false;
}
static void move_place(places *p, uint32_t k) {
  p->of[k].keys[3] += 0.5f;
  CHECK(pktrt_set_transform(p->s, p->of[k].index, 0, p->of[k].keys) == PKTRT_OK, "%s", pktrt_last_error(p->s));
}
/* One of eight changes; returns whether a refit will do. */
static bool change_places(places *p, int change) {
  switch (change) {
  case 0: show_place(p, 0, false), show_place(p, 5, false), move_place(p, 1); return true;
  case 1: show_place(p, 0, true), show_place(p, 6, false), move_place(p, 5); return false;
  case 2: show_place(p, 5, true), show_place(p, 6, true); return true;
  case 3: take_place(p, 2), take_place(p, 3), take_place(p, 9), show_place(p, 4, false); return false;
  case 4: show_place(p, 4, true), move_place(p, 7); return true;
  case 5: add_place(p, 9), add_place(p, 2); return false; /* of two models */
  case 6: take_place(p, 0), take_place(p, 13), add_place(p, 3), show_place(p, 3, false); return false;
  default: add_place(p, 13), add_place(p, 0), show_place(p, 3, true); return false;
  }
}
static void hidden_and_removed_instances_are_not_seen(void) {
  static pktrt_ray rays[MANY];
  static answers before, waiting, after;
  course c = {0, 0, 0, 0};
  for (int k = 0; k < isa_count; k++) {
    const size_t n = rays_on(isas[k], 72);
    places p;
    places_open(&p, isas[k]);
    make_rays(&p.w, p.s, RAYS_RANDOM, 3, 0, rays, n);
    for (int i = 0; i < 8; i++) {
      ask(p.s, 1, rays, n, &before);
      const bool refit = change_places(&p, i);
      ask(p.s, 1, rays, n, &waiting), c.early += differ(&before, &waiting, n);
      settle(p.s, refit);
      ask(p.s, 1, rays, n, &after), c.changed += differ(&before, &after, n);
      c.hits += compare_places(&p, 0, n, &c.wrong), c.hits += compare_places(&p, 1, n, &c.wrong);
    }
    pktrt_scene_info info;
    pktrt_get_scene_info(p.s, &info);
    CHECK(info.instance_count == PLACES && p.of[0].index < PLACES && p.of[9].index < PLACES, "%u instances",
        (unsigned)info.instance_count);
    places_close(&p);
  }
  CHECK(c.wrong == 0 && c.hits > 1000, "%zu of %zu differ", c.wrong, c.hits);
  CHECK(c.early == 0 && c.changed > 13 * (size_t)isa_count, "%zu did not wait, %zu changed", c.early, c.changed);
  say("%zu hits, %zu differ from those of a scene of what is seen, %zu did not wait; control: %zu changed at the "
      "commit "
      "or refit",
      c.hits, c.wrong, c.early, c.changed);
}

/* --- refusals --- */

static void what_is_gone_is_refused_by_name(void) {
  const pktrt_status no = PKTRT_INVALID_ARGUMENT;
  places p;
  uint32_t gone = 0;
  places_open(&p, PKTRT_ISA_AUTO);
  pktrt_scene *s = p.s;
  const float *positions = p.w.m[1].p, *keys = p.of[1].keys;
  CHECK(mesh_add(s, &p.w.m[1], &gone) == PKTRT_OK);
  char named[64], of_instance[64];
  snprintf(named, sizeof named, "mesh %u was", (unsigned)gone);
  snprintf(of_instance, sizeof of_instance, "remove_mesh: mesh %u belongs to instance 1", (unsigned)p.of[1].first + 2);
  says(s, pktrt_refit(s), PKTRT_NOT_COMMITTED, named);
  says(s, pktrt_remove_mesh(s, p.of[1].first + 2), no, of_instance);
  settle(s, false);
  for (int committed = 0; committed < 2; committed++) {
    if (!committed) CHECK(!pktrt_remove_mesh(s, gone) && !pktrt_remove_instance(s, 1), "%s", pktrt_last_error(s));
    if (!committed) says(s, pktrt_refit(s), PKTRT_NOT_COMMITTED, "refit: instance 1 was removed since the last commit");
    says(s, pktrt_set_positions(s, gone, 0, positions), no, named);
    says(s, pktrt_set_normals(s, gone, 0, positions), no, named);
    says(s, pktrt_set_enabled(s, gone, false), no, named);
    says(s, pktrt_remove_mesh(s, gone), no, named);
    says(s, pktrt_set_enabled(s, p.of[1].first + 2, true), no, "was removed");
    says(s, pktrt_remove_instance(s, 1), no, "remove_instance: instance 1 was removed");
    says(s, pktrt_set_transform(s, 1, 0, keys), no, "set_transform: instance 1 was removed");
    if (!committed) settle(s, false);
  }
  says(s, pktrt_remove_mesh(s, gone + 1), no, "remove_mesh: there is no mesh 4");
  says(s, pktrt_set_enabled(s, UINT32_MAX, true), no, "set_enabled: there is no mesh 4294967295");
  says(s, pktrt_remove_instance(s, PLACES), no, "remove_instance: there is no instance 14 among 14");
  says(s, pktrt_remove_mesh(s, p.of[2].first), no, "remove_mesh: mesh");
  says(s, pktrt_remove_mesh(s, p.of[2].first), no, "belongs to instance 2");
  CHECK(
      pktrt_remove_mesh(NULL, 0) == no && pktrt_remove_instance(NULL, 0) == no && pktrt_set_enabled(NULL, 0, 1) == no);
  CHECK(mesh_add(s, &p.w.m[1], &gone) == PKTRT_OK && pktrt_remove_mesh(s, gone) == PKTRT_OK);
  says(s, pktrt_refit(s), PKTRT_NOT_COMMITTED, "was removed since the last commit");
  settle(s, false), settle(s, true);
  places_close(&p);
}

/* Those of a scene that was never other, after what was refused: it changes nothing. */
static void refusals_change_nothing(void) {
  static pktrt_ray rays[MANY];
  static answers before, after;
  places p;
  places_open(&p, PKTRT_ISA_AUTO);
  make_rays(&p.w, p.s, RAYS_RANDOM, 3, 0, rays, MANY);
  take_place(&p, 1), settle(p.s, false);
  ask(p.s, 1, rays, MANY, &before);
  CHECK(pktrt_remove_instance(p.s, 1) && pktrt_remove_mesh(p.s, p.of[2].first) &&
        pktrt_set_enabled(p.s, p.of[1].first, false) && pktrt_set_transform(p.s, 1, 0, p.of[2].keys));
  settle(p.s, true);
  ask(p.s, 1, rays, MANY, &after);
  CHECK(differ(&before, &after, MANY) == 0, "%zu answers differ", differ(&before, &after, MANY));
  show_place(&p, 2, false), settle(p.s, true);
  ask(p.s, 1, rays, MANY, &after);
  CHECK(differ(&before, &after, MANY) > 0, "the control: what is not refused does");
  places_close(&p);
}

/* --- indices and memory --- */

static uint32_t add_sphere(pktrt_scene *s, int level, uint32_t group) {
  mesh m = mesh_sphere(level, 0.05f, 3);
  pktrt_mesh_desc d = mesh_desc(&m);
  uint32_t index = PKTRT_NONE;
  d.group = group;
  CHECK(pktrt_add_mesh(s, &d, &index) == PKTRT_OK, "%s", pktrt_last_error(s));
  mesh_free(&m);
  return index;
}
/* Widens a box by those of all children in a node. */
static void widen_by_node(const pktrt_scene *s, float time, float lo[3], float hi[3]) {
  pktrt_node node;
  CHECK(pktrt_get_node(s, 0, 0, time, &node), "the tree has a root");
  for (int c = 0; c < 8; c++)
    for (int a = 0; a < 3 && node.child[c] != PKTRT_NONE; a++) {
      lo[a] = fminf(lo[a], node.lo[c][a]);
      hi[a] = fmaxf(hi[a], node.hi[c][a]);
    }
}

/* Meshes of one triangle lie among the triangles of one with many vertices, all of which go far. With the former hidden, boxes are those of
   the latter alone at each time. */
static void hidden_ones_that_move_widen_no_boxes(void) {
  enum { SMALL = 5, KEYS = 3 };
  size_t wider = 0, narrower = 0;
  for (int kind = 0; kind < 2; kind++) { /* with a commit, with a refit */
    pktrt_scene *s[2];
    for (int k = 0; k < 2; k++) s[k] = open_scene(PKTRT_ISA_AUTO);
    mesh large = mesh_sphere(1, 0.05f, 3);
    mesh_move(&large, KEYS, 0, 0, 4);
    for (uint32_t i = 0; i < KEYS * large.nv; i++) large.p[3 * i] += (float)(40 * (i / large.nv));
    pktrt_mesh_desc d = mesh_desc(&large);
    d.triangle_count = 8 - SMALL; /* all in one block */
    for (int k = 0; k < 2; k++) CHECK(pktrt_add_mesh(s[k], &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s[k]));
    d.indices = NULL, d.vertex_count = 3, d.triangle_count = 1;
    for (int i = 0; i < SMALL; i++) { /* each lies in one of the others, so that no tree parts them */
      float keys[KEYS][3][3];
      for (uint32_t k = 0; k < KEYS; k++)
        for (uint32_t c = 0; c < 3; c++)
          memcpy(keys[k][c], large.p + 3 * ((size_t)k * large.nv + large.i[3 * (i % (8 - SMALL)) + (int)c]), 12);
      d.positions = keys[0][0];
      CHECK(pktrt_add_mesh(s[0], &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s[0]));
    }
    for (int k = 0; k < 2; k++) settle(s[k], false);
    for (uint32_t i = 1; i <= SMALL; i++) CHECK(pktrt_set_enabled(s[0], i, false) == PKTRT_OK);
    settle(s[0], kind == 1);

    for (int step = 0; step <= 8; step++) {
      float lo[2][3], hi[2][3];
      for (int k = 0; k < 2; k++) {
        for (int a = 0; a < 3; a++) lo[k][a] = INFINITY, hi[k][a] = -INFINITY;
        widen_by_node(s[k], (float)step / 8, lo[k], hi[k]);
      }
      for (int a = 0; a < 3; a++) {
        wider += lo[0][a] < lo[1][a] || hi[0][a] > hi[1][a];
        narrower += lo[0][a] > lo[1][a] || hi[0][a] < hi[1][a];
      }
    }
    for (int k = 0; k < 2; k++) pktrt_scene_destroy(s[k]);
    mesh_free(&large);
  }
  CHECK(wider == 0 && narrower == 0, "%zu are wider, %zu narrower", wider, narrower);
}

static void indices_are_used_again(void) {
  pktrt_scene *s = open_scene(PKTRT_ISA_AUTO);
  pktrt_scene_info info;
  CHECK(add_sphere(s, 1, 0) == 0 && add_sphere(s, 3, 5) == 1 && add_sphere(s, 2, 0) == 2);
  settle(s, false);
  CHECK(pktrt_winding(s, 1, (const float[3]){0, 0, 0}, 0) == 1);
  CHECK(pktrt_remove_mesh(s, 1) == PKTRT_OK && pktrt_winding(s, 1, (const float[3]){0, 0, 0}, 0) == 1);
  CHECK(add_sphere(s, 1, 0) == 3, "an index is free after the commit only");
  settle(s, false);
  pktrt_get_scene_info(s, &info);
  CHECK(info.mesh_count == 4 && info.triangles == 32 + 128 + 32, "%u indices, %llu triangles",
      (unsigned)info.mesh_count, (unsigned long long)info.triangles);
  CHECK(pktrt_winding(s, 1, (const float[3]){0, 0, 0}, 0) == 0, "nothing is there");
  CHECK(add_sphere(s, 4, 0) == 1, "a larger mesh gets that index");
  CHECK(add_sphere(s, 3, 2) == 4, "once");
  CHECK(pktrt_remove_mesh(s, 2) == PKTRT_OK);
  settle(s, false);
  CHECK(add_sphere(s, 3, 0) == 2 && add_sphere(s, 1, 0) == 5 && add_sphere(s, 1, 0) == 6, "a smaller one, once");
  settle(s, false);
  pktrt_get_scene_info(s, &info);
  CHECK(info.mesh_count == 7 && info.triangles == 32 + 512 + 32 + 32 + 2048 + 512 + 32, "%u indices, %llu triangles",
      (unsigned)info.mesh_count, (unsigned long long)info.triangles);
  for (uint32_t i = 0; i < 7; i++)
    CHECK(pktrt_winding(s, i, (const float[3]){0, 0, 0}, 0) == 1, "mesh %u is there", (unsigned)i);
  pktrt_scene_destroy(s);
}

/* One of several things that come and go: of one group, of a new group each time, not committed before they go, of a mask
   each time; instances of two models. */
static const char *const rounds_of[5] = {
    "one group", "a group each time", "gone before the commit", "a mask each time", "instances"};
static uint32_t go_round(pktrt_scene *s, int what, uint32_t round, const mesh *m) {
  uint32_t index[3], most = 0;
  for (uint32_t k = 0; k < 3; k++) {
    const pktrt_instance_desc at = {k % 2, 1 + k % 2, NULL, round % 3, PKTRT_INTERPOLATION_LINEAR};
    static const float keys[24] = {1, 0, 0, 1, 0, 1, 0, 2, 0, 0, 1, 3, 1, 0, 0, 2, 0, 1, 0, 2, 0, 0, 1, 3};
    pktrt_instance_desc place = at;
    pktrt_mesh_desc d = mesh_desc(m);
    place.transforms = keys;
    d.group = what == 1 ? 1 + round * 3 + k : 1 + k, d.mask = what == 3 ? 1 + round : 0;
    d.triangle_count -= (round + k) % 4;
    CHECK((what == 4 ? pktrt_add_instance(s, &place, &index[k]) : pktrt_add_mesh(s, &d, &index[k])) == PKTRT_OK, "%s",
        pktrt_last_error(s));
    most = index[k] > most ? index[k] : most;
  }
  if (what != 2) settle(s, false);
  for (uint32_t k = 0; k < 3; k++)
    CHECK((what == 4 ? pktrt_remove_instance(s, index[k]) : pktrt_remove_mesh(s, index[k])) == PKTRT_OK, "%s",
        pktrt_last_error(s));
  settle(s, false);
  return most;
}
static void coming_and_going_takes_no_more_memory(void) {
  const uint32_t rounds = small_run ? 120 : 1000;
  world w = world_of(mesh_sphere(1, 0.05f, 2));
  for (int what = 0; what < 5; what++) {
    pktrt_scene *s = open_scene(PKTRT_ISA_AUTO);
    const pktrt_mesh_desc d = mesh_desc(&w.m[0]);
    CHECK(!pktrt_add_mesh(s, &d, NULL) && !pktrt_add_model(s, &d, 1, NULL) && !pktrt_add_model(s, &d, 1, NULL), "%s",
        pktrt_last_error(s));
    settle(s, false);
    size_t early = 0, largest = 0;
    uint32_t index = 0;
    for (uint32_t i = 0; i < rounds; i++) {
      const uint32_t most = go_round(s, what, i, &w.m[0]);
      index = most > index ? most : index;
      if (i < 20) early = hooks.live_bytes > early ? hooks.live_bytes : early;
      largest = hooks.live_bytes > largest ? hooks.live_bytes : largest;
    }
    CHECK(index < 8, "%s: index %u", rounds_of[what], (unsigned)index);
    CHECK(largest == early, "%s: %zu bytes, in the first 20 rounds %zu", rounds_of[what], largest, early);
    say("%s: %u rounds, %zu bytes at most, index %u", rounds_of[what], (unsigned)rounds, largest, (unsigned)index);
    pktrt_scene_destroy(s);
  }
  world_free(&w);
}

/* What a scene takes that had so many meshes once, and of which one is left. */
static void memory_comes_back_at_the_commit(void) {
  enum { N = 40, INDEX = 512 }; /* bytes that an index may keep, and a group */
  size_t bytes[2], before[2], full = 0, waiting = 0;
  for (int had = 0; had < 2; had++) {
    const size_t none = hooks.live_bytes;
    pktrt_scene *s = open_scene(PKTRT_ISA_AUTO);
    add_sphere(s, 2, 0);
    for (uint32_t i = 0; i < N && had; i++) add_sphere(s, 4, i % 10);
    settle(s, false);
    before[had] = hooks.live_bytes - none;
    for (uint32_t i = 1; i <= N && had; i++) CHECK(pktrt_remove_mesh(s, i) == PKTRT_OK, "%s", pktrt_last_error(s));
    waiting = hooks.live_bytes - none, full = before[had];
    settle(s, false);
    bytes[had] = hooks.live_bytes - none;
    pktrt_scene_destroy(s);
  }
  CHECK(waiting == full, "until the commit it is there");
  CHECK(bytes[1] <= bytes[0] + N * INDEX && before[1] > bytes[0] + 100 * N * INDEX,
      "%zu bytes, never had: %zu, full: %zu", bytes[1], bytes[0], before[1]);
  say("%d meshes came and went: %zu bytes, %zu with them; of a scene that never had them %zu", N, bytes[1], before[1],
      bytes[0]);
}

/* --- allocations that fail --- */

/* Pieces in nine groups, and instances of their world; then, at once, some come, some go, some are hidden or move. */
static void open_both(parts *p) {
  const bool all[SOURCES] = {true, true, true, true};
  places model;
  parts_open(p, world_moving(0), SOME_IN_FEW, PKTRT_ISA_AUTO);
  memset(&model, 0, sizeof model);
  model.w = p->w;
  const pktrt_instance_desc at = {0, 1, NULL, 0, PKTRT_INTERPOLATION_LINEAR};
  CHECK(!add_model(&model, p->s, all, false, NULL) && !pktrt_add_instance(p->s, &at, NULL) &&
            !pktrt_add_instance(p->s, &at, NULL),
      "%s", pktrt_last_error(p->s));
  remove_all(p), add_in_many(p), settle(p->s, false);
}
/* The calls of a change, of which each may fail: made again, those that are done already do no harm. */
static void change_both(parts *p) {
  const float aside[12] = {1, 0, 0, 3, 0, 1, 0, 0, 0, 0, 1, 0};
  remove_some(p), hide_others(p), deform_two(p);
  for (uint32_t k = 0; k < 4; k++)
    if (p->of[k].there) p->of[k].group = 200 + k;
  CHECK(!pktrt_remove_instance(p->s, 0) && !pktrt_set_transform(p->s, 1, 0, aside), "%s", pktrt_last_error(p->s));
}

static void ask_few(const parts *p, answers *a, size_t n) {
  static pktrt_ray rays[MANY];
  make_rays(&p->w, p->s, RAYS_CAMERA, 2, 0, rays, n); /* which depend on neither */
  ask(p->s, 1, rays, n, a);
}
typedef struct failures {
  size_t failed, wrong, left, changed;
} failures;
/* Makes the n-th allocation of a commit fail; returns whether there was one. */
static bool fail_commit(size_t n, failures *f) {
  enum { RAYS = 192 };
  static answers before, after, want;
  parts p;
  open_both(&p), change_both(&p);
  ask_few(&p, &before, RAYS);
  const size_t blocks = hooks.live_blocks;
  hooks.fail_at = n, hooks.fail_after = n % 2 == 0, hooks.failed = 0;
  const pktrt_status status = pktrt_commit(p.s);
  const bool failed = hooks.failed > 0;
  hooks.fail_at = 0, hooks.fail_after = false;
  f->failed += failed, f->wrong += status != (failed ? PKTRT_OUT_OF_MEMORY : PKTRT_OK);
  if (failed) {
    says(p.s, status, PKTRT_OUT_OF_MEMORY, "memory");
    f->left += hooks.live_blocks != blocks;
    ask_few(&p, &after, RAYS);
    f->wrong += differ(&before, &after, RAYS) != 0;
    settle(p.s, false);
  }
  ask_few(&p, &after, RAYS);
  f->changed += differ(&before, &after, RAYS) != 0;
  uint32_t map[PIECES], seen;
  pktrt_scene *s = seen_scene(&p, 0, PKTRT_ISA_AUTO, map, &seen);
  parts fresh = p;
  fresh.s = s;
  ask_few(&fresh, &want, RAYS);
  for (size_t i = 0; i < RAYS; i++) { /* but where the instance is hit */
    if (want.hit[i].mesh != PKTRT_NONE) want.hit[i].mesh = map[want.hit[i].mesh];
    f->wrong += after.hit[i].mesh < PIECES && !same_bits(&want.hit[i], &after.hit[i], sizeof want.hit[i]);
  }
  pktrt_scene_destroy(s);
  parts_close(&p);
  return failed;
}
static void failing_allocations_of_a_commit(void) {
  failures f = {0, 0, 0, 0};
  size_t n = 1;
  while (fail_commit(n, &f)) n += small_run ? 5 : 1;
  CHECK(f.wrong == 0 && f.left == 0, "%zu wrong, %zu commits left blocks behind", f.wrong, f.left);
  CHECK(n > 100 && f.changed == f.failed + 1, "%zu allocations, %zu of %zu changed", n, f.changed, f.failed + 1);
  say("%zu allocations failed in turn: %zu wrong before or after, %zu blocks left; control: %zu retries changed "
      "answers",
      f.failed, f.wrong, f.left, f.changed - 1);
}

/* Of adding: to indices that wait, for a mesh in a new group and for an instance. */
static void failing_allocations_of_what_comes_again(void) {
  enum { RAYS = 192 };
  static answers before, after;
  size_t failed = 0, wrong = 0;
  for (bool again = true; again; failed += again) {
    parts p;
    uint32_t index = 0;
    const pktrt_instance_desc at = {0, 1, NULL, 0, PKTRT_INTERPOLATION_LINEAR};
    open_both(&p), change_both(&p), settle(p.s, false);
    ask_few(&p, &before, RAYS);
    pktrt_mesh_desc d = piece_desc(&p, &p.of[3]);
    d.group = 999, d.normals = d.positions, d.texcoords = d.positions;
    hooks.fail_at = failed + 1, hooks.failed = 0;
    const pktrt_status added = pktrt_add_mesh(p.s, &d, &index), place = pktrt_add_instance(p.s, &at, NULL);
    hooks.fail_at = 0;
    again = hooks.failed > 0;
    wrong += (added == PKTRT_OUT_OF_MEMORY) + (place == PKTRT_OUT_OF_MEMORY) != again || (added && place);
    settle(p.s, false);
    CHECK(added || !pktrt_remove_mesh(p.s, index), "%s", pktrt_last_error(p.s));
    CHECK(place || !pktrt_remove_instance(p.s, 0), "instance 0 was free, and is it: %s", pktrt_last_error(p.s));
    settle(p.s, false);
    ask_few(&p, &after, RAYS);
    wrong += differ(&before, &after, RAYS) != 0;
    parts_close(&p);
  }
  CHECK(failed >= 5 && wrong == 0, "%zu failed, %zu wrong", failed, wrong);
  say("%zu allocations failed in turn, %zu wrong", failed, wrong);
}

/* --- work --- */

/* The most memory that a commit has beside what there was, after the last mesh, of few triangles, has moved. */
static size_t commit_peak(uint32_t groups, bool grouped, bool refit) {
  pktrt_scene *s = open_scene(PKTRT_ISA_AUTO);
  mesh small = mesh_sphere(2, 0.05f, 1);
  pktrt_mesh_desc d = mesh_desc(&small);
  uint32_t index;
  d.group = grouped ? groups : 0;
  for (uint32_t i = 0; i < groups; i++) add_sphere(s, small_run ? 4 : 5, grouped ? i : 0);
  CHECK(pktrt_add_mesh(s, &d, &index) == PKTRT_OK, "%s", pktrt_last_error(s));
  settle(s, false);
  mesh_scale(&small, 1.25f);
  CHECK(pktrt_set_positions(s, index, 0, small.p) == PKTRT_OK, "%s", pktrt_last_error(s));
  const size_t before = hooks.live_bytes;
  hooks.peak_bytes = before;
  settle(s, refit);
  const size_t peak = hooks.peak_bytes - before;
  pktrt_scene_destroy(s);
  mesh_free(&small);
  return peak;
}
static void a_commit_builds_the_group_that_changed(void) {
  for (uint32_t groups = 3; groups <= 24; groups += 21) {
    const size_t triangles = 128, one = commit_peak(groups, true, false), all = commit_peak(groups, false, false);
    const size_t fitted = commit_peak(groups, true, true);
    CHECK(one < 1000 * triangles && all > 5 * one, "%u groups: %zu bytes, without groups %zu", (unsigned)groups, one,
        all);
    CHECK(fitted == 0, "a refit takes %zu bytes", fitted);
    say("%u meshes of many triangles, and one of %zu that has changed: its commit takes %zu bytes; control, without "
        "groups: %zu",
        (unsigned)groups, triangles, one, all);
  }
}

/* --- pictures --- */

enum { W = 48, H = 36 };
/* Places ball i: the eighth, of glass, around the camera, the ninth beyond all else. */
static mesh picture_ball(uint32_t i) {
  mesh m = i ? mesh_sphere(i < 5 ? 1 : 2, 0.1f, i) : mesh_grid(6, 6);
  if (i == 0) mesh_shift(&m, 0, -1.5f, 0);
  else if (i < 8) mesh_scale(&m, 0.5f), mesh_shift(&m, (float)(i % 4) - 1.5f, (float)i * 0.2f - 1, (float)(i / 4) - 1);
  else if (i == 8) mesh_scale(&m, 0.4f), mesh_shift(&m, 0.5f, 1.2f, 4.5f);
  else mesh_scale(&m, 30), mesh_shift(&m, 5, 0, -90);
  if (i % 3 == 2) mesh_move(&m, 2, 0.2f, 0.02f, i);
  return m;
}
/* A floor, a mirror, glass, moving balls and an instance, in groups or not; and more that is hidden, removed or never was. */
static pktrt_scene *picture_scene(bool grouped, int more, pktrt_isa isa) {
  static const float aside[12] = {-0.4f, 0.1f, 0, 1.8f, 0, 0.3f, 0, -0.3f, 0.1f, 0, 0.5f, 0.5f};
  const pktrt_instance_desc at = {0, 1, aside, 0, PKTRT_INTERPOLATION_LINEAR};
  const pktrt_scene_desc sd = scene_desc_of(isa, 0);
  pktrt_scene *s = pktrt_scene_create(&sd);
  const pktrt_material mirror = material_of(0.2, PKTRT_SPECULAR_MIRROR, 0.6),
                       glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  const uint32_t looks[2] = {stage_material(s, &mirror), stage_material(s, &glass)};
  uint32_t hidden[2] = {0, 0};
  for (uint32_t i = 0; i < 10; i++) {
    mesh m = picture_ball(i);
    pktrt_mesh_desc d = mesh_desc(&m);
    uint32_t index = 0;
    d.group = grouped ? i % 7 : 0, d.material = i % 3 == 1 ? looks[i / 3 % 2] : i == 8 ? looks[1] : 0;
    if (i < 8 || more) CHECK(pktrt_add_mesh(s, &d, &index) == PKTRT_OK, "%s", pktrt_last_error(s));
    if (i == 3) CHECK(pktrt_add_model(s, &d, 1, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
    if (i >= 8) hidden[i - 8] = index;
    mesh_free(&m);
  }
  CHECK(pktrt_add_instance(s, &at, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  pktrt_light point = light_of(PKTRT_LIGHT_POINT, 60);
  point.position[0] = 3, point.position[1] = 5, point.position[2] = 2;
  stage_light(s, &point), settle(s, false);
  for (int i = 0; i < 2 && more; i++)
    CHECK((more == 1 ? pktrt_set_enabled(s, hidden[i], false) : pktrt_remove_mesh(s, hidden[i])) == PKTRT_OK);
  settle(s, more == 1);
  return s;
}
static void picture_of(pktrt_scene *s, int mode, pktrt_path path, float *pixels) {
  pktrt_render_desc d = stage_view((pktrt_mode)mode, W, H, pixels, vec_of(0.5, 1.2, 4.5), vec_of(0, 0, 0));
  for (int a = 0; a < 3; a++) d.background[a] = 0.25f, d.ambient[a] = 0.1f;
  d.samples = 2, d.path = path, d.camera.time = 0.3f, d.camera.shutter = 0.4f, d.max_depth = 6;
  stage_render(s, &d);
}
static void pictures_show_what_is_seen(void) {
  static float want[3][W * H * 3], got[W * H * 3];
  static const struct {
    const char *name;
    bool grouped;
    int more; /* 1: hidden, 2: removed, 3: seen, the control */
  } kinds[] = {{"in groups", true, 0}, {"with hidden meshes", false, 1}, {"with hidden meshes in groups", true, 1},
      {"with removed meshes", false, 2}, {"with removed meshes in groups", true, 2}};
  size_t pictures = 0, wrong = 0, control = 0;
  pktrt_scene *plain = picture_scene(false, 0, PKTRT_ISA_AUTO);
  for (int mode = 0; mode < 3; mode++) picture_of(plain, mode, PKTRT_PATH_FAST, want[mode]);
  for (int k = 0; k < isa_count; k++)
    for (size_t i = 0; i < COUNT(kinds); i++) {
      pktrt_scene *s = picture_scene(kinds[i].grouped, kinds[i].more, isas[k]);
      for (int mode = 0; mode < 3; mode++, pictures++) {
        picture_of(s, mode, (pktrt_path)((k + (int)i + mode) % 3), got);
        const bool same = CHECK(same_bits(want[mode], got, sizeof got), "%s: the picture differs", kinds[i].name);
        wrong += !same;
      }
      for (uint32_t m = 8; m < 10 && kinds[i].more == 1; m++) (void)pktrt_set_enabled(s, m, true);
      settle(s, true);
      picture_of(s, PKTRT_MODE_WRT, PKTRT_PATH_FAST, got);
      control += kinds[i].more == 1 && !same_bits(want[PKTRT_MODE_WRT], got, sizeof got);
      pktrt_scene_destroy(s);
    }
  CHECK(control == 2 * (size_t)isa_count, "the control, what is hidden shown: %zu differ", control);
  say("%zu pictures, %zu differ from that of what is seen; control, what is hidden shown: %zu of %d", pictures, wrong,
      control, 2 * isa_count);
  pktrt_scene_destroy(plain);
}

/* Each group alone, the first and the last as well, is where a refit puts it, among so few groups that they are visited one by one and
   among more. */
static void each_group_moves_alone(void) {
  static const uint32_t counts[] = {3, 5, 12};
  for (size_t c = 0; c < COUNT(counts); c++) {
    pktrt_scene *s = open_scene(PKTRT_ISA_AUTO);
    mesh box = mesh_box();
    for (uint32_t k = 0; k < counts[c]; k++) {
      pktrt_mesh_desc d = mesh_desc(&box);
      d.group = 1 + k;
      CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
      mesh_shift(&box, 10, 0, 0);
    }
    settle(s, false);
    for (uint32_t k = 0; k < counts[c]; k++) {
      mesh moved = mesh_box();
      mesh_shift(&moved, 10 * (float)k, 300, 0);
      CHECK(pktrt_set_positions(s, k, 0, moved.p) == PKTRT_OK);
      settle(s, true);
      pktrt_hit hit;
      const pktrt_ray there = ray_of(10 * (float)k + 0.3f, 300.2f, -9, 0, 0, 1),
                      here = ray_of(10 * (float)k + 0.3f, 0.2f, -9, 0, 0, 1);
      CHECK(pktrt_intersect(s, &there, &hit) && hit.mesh == k, "group %u of %u is where it was put", (unsigned)k,
          (unsigned)counts[c]);
      CHECK(!pktrt_intersect(s, &here, &hit), "group %u of %u is no longer where it was", (unsigned)k,
          (unsigned)counts[c]);
      mesh_free(&moved);
    }
    pktrt_scene_destroy(s);
    mesh_free(&box);
  }
}

/* What waits for a commit is said, as any change is. */
static void pictures_tell_what_waits(void) {
  static float pixels[W * H * 3];
  pktrt_scene *s = picture_scene(true, 0, PKTRT_ISA_AUTO);
  for (int k = 0; k < 4; k++) {
    hooks.warnings = 0, hooks.last_log[0] = 0;
    if (k == 1) CHECK(pktrt_set_enabled(s, 3, false) == PKTRT_OK);
    if (k == 3) CHECK(pktrt_remove_mesh(s, 5) == PKTRT_OK);
    picture_of(s, PKTRT_MODE_WRT, PKTRT_PATH_FAST, pixels);
    const bool told = strstr(hooks.last_log, k == 1 ? "mesh 3 was changed since the last commit"
                                                    : "mesh 5 was removed since the last commit") != NULL;
    CHECK(told == (k % 2 == 1) && hooks.warnings >= k % 2, "%d: \"%s\"", k, hooks.last_log);
    if (k == 1) settle(s, true);
  }
  settle(s, false);
  hooks.last_log[0] = 0;
  picture_of(s, PKTRT_MODE_WRT, PKTRT_PATH_FAST, pixels);
  CHECK(!strstr(hooks.last_log, "since the last commit"), "after the commit nothing waits, and yet: \"%s\"",
      hooks.last_log);
  pktrt_scene_destroy(s);
}

void suite_groups(void) {
  run("meshes in groups have the bits of the same meshes without, few groups and many", groups_change_no_bits);
  run("groups of nothing, of flat or of degenerate triangles have the same bits", odd_groups_harm_nothing);
  run("a refit that builds trees of groups anew has the same bits", rebuilds_of_groups);
  run("what is deformed, hidden, removed or added again has the bits of a scene of what is seen, from the commit on",
      what_is_seen_has_the_bits_of_a_scene_of_it);
  run("what is hidden is never hit, and comes back with its bits", hidden_meshes_come_back);
  run("hidden meshes that move among the triangles of another widen no boxes", hidden_ones_that_move_widen_no_boxes);
  run("a query's mask sees the meshes that share a bit with it, and nothing else", masks_choose_meshes);
  run("masks are the same in arrays of structures and in structures of arrays", masks_in_structures_of_arrays);
  run("a query's mask sees instances and the meshes in their models", masks_choose_instances);
  run("hidden and removed instances are not seen, moved ones where they are",
      hidden_and_removed_instances_are_not_seen);
  run("what was removed is refused by name, and so is a refit after it", what_is_gone_is_refused_by_name);
  run("what is refused of removed meshes and instances changes nothing", refusals_change_nothing);
  run("the index of a removed mesh is that of the next one, whatever its triangles", indices_are_used_again);
  run("meshes and instances that come and go take no more memory, and no more indices",
      coming_and_going_takes_no_more_memory);
  run("the memory of removed meshes comes back at the commit", memory_comes_back_at_the_commit);
  run("each allocation of a commit of groups failing, the scene answers as before, and then as it should",
      failing_allocations_of_a_commit);
  run("each allocation failing of what gets an index again, the scene goes on",
      failing_allocations_of_what_comes_again);
  run("a commit builds the group that changed, and not the others", a_commit_builds_the_group_that_changed);
  run("pictures show what is seen, in groups or not", pictures_show_what_is_seen);
  run("each group that moves alone is where a refit puts it", each_group_moves_alone);
  run("a render tells what was removed or hidden and waits for a commit", pictures_tell_what_waits);
}
