/* Each allocation failing in turn: a status, a scene that still answers as before, and nothing leaked. */
#include "noslack.h"
#include "stability.h"

enum { RAYS = 300 };
typedef struct answers {
  pktrt_hit hit[RAYS];
} answers;

static void ask_all(const pktrt_scene *s, answers *a) {
  for (uint32_t i = 0; i < RAYS; i++) {
    rng r = rng_of(i);
    pktrt_ray x = ray_of(3 * rng_sign(&r), 3 * rng_sign(&r), 3, rng_sign(&r), rng_sign(&r), -3);
    x.time = rng_unit(&r);
    pktrt_intersect(s, &x, &a->hit[i]);
  }
}

typedef struct fixture {
  world first, second, moved; /* second: what is added; moved: first, deformed */
  answers before;
  pktrt_scene *s;
  uint64_t failed, wrong;   /* allocations made to fail, and what was not as it should be then */
  uint64_t passed, changed; /* the control: operations that passed, and those after which answers were others */
} fixture;

/* The largest tree has several tasks, and with `scrambled` the old tree is bad for the new positions. */
static void set_up(fixture *f, int workers, pktrt_build_quality quality, pktrt_rebuild rebuild, bool scrambled) {
  pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, workers);
  memset(f, 0, sizeof *f);
  d.quality = quality, d.rebuild = rebuild;
  f->first = world_moving(5), f->second = world_static(3), f->moved = world_moving(5);
  for (uint32_t i = 0; i < 4; i++) mesh_place(&f->moved.m[i], (float[3]){1, 0.5f, 1}, (float[3]){0.1f, 0, 0});
  rng r = rng_of(7);
  for (size_t i = 0; i < (size_t)f->moved.m[0].nv * 6 && scrambled; i++) f->moved.m[0].p[i] = rng_sign(&r);
  f->s = pktrt_scene_create(&d);
  if (!CHECK(f->s != NULL)) abort();
  for (uint32_t i = 0; i < 4; i++) {
    pktrt_mesh_desc m = mesh_desc(&f->first.m[i]);
    m.normals = i == 1 ? m.positions : NULL; /* as good as any */
    CHECK(pktrt_add_mesh(f->s, &m, NULL) == PKTRT_OK);
  }
  CHECK(pktrt_commit(f->s) == PKTRT_OK);
  ask_all(f->s, &f->before);
}

static void tear_down(fixture *f) {
  pktrt_scene_destroy(f->s);
  world_free(&f->first), world_free(&f->second), world_free(&f->moved);
}

static pktrt_status op_add(fixture *f) { return mesh_add(f->s, &f->second.m[0], NULL); }
static pktrt_status op_commit(fixture *f) { return pktrt_commit(f->s); }
static pktrt_status op_refit(fixture *f) { return pktrt_refit(f->s); }
static pktrt_status op_positions(fixture *f) {
  pktrt_status s = PKTRT_OK;
  for (uint32_t i = 0; i < 4 && s == PKTRT_OK; i++) {
    const mesh *m = &f->moved.m[i];
    for (uint32_t k = 0; k < m->keys && s == PKTRT_OK; k++)
      s = pktrt_set_positions(f->s, i, k, m->p + (size_t)k * m->nv * 3);
  }
  return s;
}
static pktrt_status op_normals(fixture *f) { return pktrt_set_normals(f->s, 1, 0, f->moved.m[1].p); }
static float picture[32 * 32 * 3];
static pktrt_status op_render(fixture *f) {
  pktrt_render_desc d;
  memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = d.height = 32, d.pixels = picture, d.tile_size = 8;
  d.camera.eye[2] = 5;
  return pktrt_render(f->s, &d);
}
static pktrt_status op_light(fixture *f) {
  pktrt_light l;
  memset(&l, 0, sizeof l);
  pktrt_status s = PKTRT_OK;
  for (int i = 0; i < 40 && s == PKTRT_OK; i++) s = pktrt_add_light(f->s, &l, NULL);
  return s;
}
static pktrt_status op_material(fixture *f) {
  pktrt_material m;
  memset(&m, 0, sizeof m);
  pktrt_status s = PKTRT_OK;
  for (int i = 0; i < 40 && s == PKTRT_OK; i++) s = pktrt_add_material(f->s, &m, NULL);
  return s;
}

typedef pktrt_status operation(fixture *);

/* What an operation that ran out of memory must leave: a status, a sentence, the answers that were. */
static bool left_as_it_was(fixture *f, const char *name, size_t n, pktrt_status s, const answers *now) {
  const bool status = CHECK(s == PKTRT_OUT_OF_MEMORY, "%s: status %d at allocation %zu", name, (int)s, n);
  const bool said = CHECK(strstr(pktrt_last_error(f->s), "memory") != NULL, "%s: \"%s\"", name, pktrt_last_error(f->s));
  const bool same = same_bits(now, &f->before, sizeof *now);
  return CHECK(same, "%s: answers changed at failing allocation %zu", name, n) && status && said;
}

/* Fails allocation 1, 2, 3, ... of op until it passes; `changes`: whether answers change once it passes. */
static size_t fail_each(fixture *f, const char *name, operation *op, bool changes) {
  for (size_t n = 1; n < 100000; n++) {
    answers now;
    hooks.fail_at = n, hooks.failed = 0;
    hooks.fail_after = n % 2 == 0; /* one failure, or all from there on */
    pktrt_status s = op(f);
    hooks.fail_at = 0, hooks.fail_after = false;
    ask_all(f->s, &now);
    if (s == PKTRT_OK) {
      const bool other = !same_bits(&now, &f->before, sizeof now);
      f->wrong += !CHECK(hooks.failed == 0, "%s: allocation %zu failed and nobody noticed", name, n);
      CHECK(changes == other, "%s: what it should change it changes", name);
      f->passed++, f->changed += other;
      f->before = now;
      return n - 1;
    }
    f->failed++;
    f->wrong += !left_as_it_was(f, name, n, s, &now);
  }
  CHECK(false, "%s never passes", name);
  return 0;
}

static void fail_to_create(int workers) {
  for (size_t n = 1;; n++) {
    hooks.fail_at = n;
    pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, workers);
    pktrt_scene *s = pktrt_scene_create(&d);
    hooks.fail_at = 0;
    bool made = s != NULL;
    pktrt_scene_destroy(s);
    CHECK(hooks.live_blocks == 0, "create leaks");
    if (made) break;
  }
}

/* Ends a fixture: the figures of its failures, and of what is left when the scene is gone. */
static void report(fixture *f, const char *name) {
  static const char wrong[] = "failed allocations that change or hide",
                    leaks[] = "blocks left after failed allocations";
  const size_t blocks = hooks.live_blocks;
  tear_down(f);
  count_figure("tree", name, PKTRT_ISA_AUTO, f->failed, wrong, f->wrong);
  control_figure("tree", name, wrong, "changes seen once it passed", f->passed, f->changed);
  count_figure("tree", name, PKTRT_ISA_AUTO, f->failed, leaks, hooks.live_blocks);
  control_figure("tree", name, leaks, "before the scene is destroyed", blocks, blocks);
}

static void each_allocation(int workers) {
  fixture f;
  fail_to_create(workers);
  for (int q = PKTRT_BUILD_DEFAULT; q <= PKTRT_BUILD_HIGH; q++) {
    set_up(&f, workers, (pktrt_build_quality)q, PKTRT_REBUILD_NEVER, false);
    size_t add = fail_each(&f, "add", op_add, false), commit = fail_each(&f, "commit", op_commit, true);
    size_t light = fail_each(&f, "light", op_light, false), material = fail_each(&f, "material", op_material, false);
    size_t set = fail_each(&f, "positions", op_positions, false), normals = fail_each(&f, "normals", op_normals, false);
    size_t refit = fail_each(&f, "refit", op_refit, true);
    CHECK(pktrt_mark_changed(f.s) == PKTRT_OK);
    size_t again = fail_each(&f, "commit again", op_commit, false), render = fail_each(&f, "render", op_render, false);
    say("failed in turn: add %zu, commit %zu, light %zu, material %zu, positions %zu, normals %zu, refit %zu, "
        "commit %zu, render %zu",
        add, commit, light, material, set, normals, refit, again, render);
    CHECK(add > 0 && commit > 0 && light > 0 && material > 0 && set > 0 && normals > 0 && again > 0 && render > 0,
        "the control: they do allocate");
    CHECK(refit == 0, "a refit without rebuild allocates nothing");
    report(&f, workers ? "allocation failures, 3 workers" : "allocation failures, no workers");
  }
}

/* A refit that rebuilds by itself and has no memory for it says so, passes, and keeps the refitted tree: answers are
   those of the new positions all the same. */
static void failing_rebuild(void) {
  for (int workers = 0; workers <= 3; workers += 3) {
    fixture f;
    answers want, now;
    uint64_t rebuilt = 0, n = 1;
    for (; !rebuilt && n < 1000; n++) {
      set_up(&f, workers, PKTRT_BUILD_DEFAULT, PKTRT_REBUILD_AUTOMATIC, true);
      CHECK(op_positions(&f) == PKTRT_OK);
      hooks.fail_at = (size_t)n, hooks.fail_after = n % 2 == 0, hooks.failed = 0, hooks.warnings = hooks.notes = 0;
      CHECK(pktrt_refit(f.s) == PKTRT_OK, "allocation %llu: %s", (unsigned long long)n, pktrt_last_error(f.s));
      hooks.fail_at = 0, hooks.fail_after = false;
      rebuilt = hooks.failed == 0;
      CHECK(rebuilt ? hooks.notes > 0 : strstr(hooks.last_log, "memory") != NULL, "it says: %s", hooks.last_log);
      ask_all(f.s, &now);
      pktrt_scene *fresh = world_scene(&f.moved, PKTRT_ISA_AUTO, 0);
      ask_all(fresh, &want);
      pktrt_scene_destroy(fresh);
      f.failed = !rebuilt, f.wrong = !rebuilt && !same_bits(&now, &want, sizeof now);
      f.passed = 1, f.changed = !same_bits(&now, &f.before, sizeof now);
      report(&f, "rebuilds without memory");
    }
    CHECK(n > 8, "the control: a rebuild allocates");
    say("%d workers: %llu allocations failed in turn", workers, (unsigned long long)n - 2);
  }
}

/* The same of a first commit, which has no groups to go back to, and builds four. */
static void first_commit(void) {
  for (int workers = 0; workers <= 3; workers += 3) {
    world w = world_moving(1);
    answers want, now;
    pktrt_scene *whole = world_scene(&w, PKTRT_ISA_AUTO, 0);
    ask_all(whole, &want);
    pktrt_scene_destroy(whole);
    size_t n = 1, made = 0;
    for (pktrt_status status = PKTRT_OUT_OF_MEMORY; status != PKTRT_OK && n < 1000; n++) {
      pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, workers);
      pktrt_scene *s = pktrt_scene_create(&d);
      for (uint32_t i = 0; i < w.n; i++) CHECK(mesh_add(s, &w.m[i], NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
      const size_t blocks = hooks.live_blocks;
      hooks.fail_at = n, hooks.fail_after = n % 2 == 0, hooks.failed = 0;
      status = pktrt_commit(s);
      hooks.fail_at = 0, hooks.fail_after = false;
      CHECK(status == (hooks.failed ? PKTRT_OUT_OF_MEMORY : PKTRT_OK), "allocation %zu: status %d", n, (int)status);
      const size_t left = hooks.live_blocks - blocks;
      if (status != PKTRT_OK) CHECK(left == 0, "allocation %zu: %zu blocks are left", n, left);
      else made = left;
      CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
      ask_all(s, &now);
      CHECK(same_bits(&now, &want, sizeof now), "allocation %zu: other answers", n);
      pktrt_scene_destroy(s);
      CHECK(hooks.live_blocks == 0, "allocation %zu: %zu blocks outlive the scene", n, hooks.live_blocks);
      hooks.live_blocks = hooks.live_bytes = 0;
    }
    say("%d workers: %zu allocations failed in turn, %zu blocks when none does", workers, n - 2, made);
    CHECK(n > 20 && made > 12, "the control: commits allocate");
    world_free(&w);
  }
}

static void each_allocation_serial(void) { each_allocation(0); }
static void each_allocation_parallel(void) { each_allocation(3); }

/* After a failure halfway the very scene that results is that of a fresh one. */
static void usable_after_failure(void) {
  fixture f;
  answers a, b;
  set_up(&f, 0, PKTRT_BUILD_DEFAULT, PKTRT_REBUILD_ADVISE, false);
  hooks.fail_at = 2;
  CHECK(op_add(&f) == PKTRT_OUT_OF_MEMORY || hooks.fail_at);
  hooks.fail_at = 0;
  uint32_t index = 0;
  CHECK(mesh_add(f.s, &f.second.m[0], &index) == PKTRT_OK);
  pktrt_scene_info info;
  hooks.fail_at = 3, hooks.fail_after = true;
  CHECK(pktrt_commit(f.s) == PKTRT_OUT_OF_MEMORY);
  hooks.fail_at = 0, hooks.fail_after = false;
  CHECK(pktrt_commit(f.s) == PKTRT_OK);
  ask_all(f.s, &a);
  pktrt_get_scene_info(f.s, &info);
  world w = f.first;
  w.m[w.n++] = f.second.m[0];
  CHECK(info.mesh_count == index + 1 && index >= 4);
  if (index == 4) {
    pktrt_scene *fresh = world_scene(&w, PKTRT_ISA_AUTO, 0);
    ask_all(fresh, &b);
    CHECK(same_bits(&a, &b, sizeof a));
    pktrt_scene_destroy(fresh);
  }
  tear_down(&f);
}

/* Counts too large for memory come back as a status. */
static void too_large(void) {
  mesh m = mesh_sphere(6, 0, 1);
  pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
  pktrt_scene *s = pktrt_scene_create(&d);
  CHECK(s != NULL);
  hooks.limit = 100000;
  CHECK(mesh_add(s, &m, NULL) == PKTRT_OUT_OF_MEMORY);
  hooks.limit = 0;
  CHECK(mesh_add(s, &m, NULL) == PKTRT_OK);
  hooks.limit = 400000;
  CHECK(pktrt_commit(s) == PKTRT_OUT_OF_MEMORY);
  hooks.limit = 0;
  CHECK(pktrt_commit(s) == PKTRT_OK);
  pktrt_scene_destroy(s);
  mesh_free(&m);
}

/* The sentence names whose tree it was: that of meshes at rest, or of those with so many keys. */
static void named_trees(void) {
  for (uint32_t keys = 1; keys < 4; keys++) {
    mesh m = mesh_sphere(4, 0, 1);
    if (keys > 1) mesh_move(&m, keys, 0.4f, 0.05f, 2);
    const pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
    pktrt_scene *s = pktrt_scene_create(&d);
    char want[64];
    snprintf(want, sizeof want, "the meshes with %u key%s", (unsigned)keys, keys == 1 ? "" : "s");
    CHECK(mesh_add(s, &m, NULL) == PKTRT_OK);
    hooks.limit = 10000;
    CHECK(pktrt_commit(s) == PKTRT_OUT_OF_MEMORY);
    hooks.limit = 0;
    const char *said = pktrt_last_error(s), *at = strstr(said, want);
    CHECK(at && !at[strlen(want)], "\"%s\" ends with \"%s\"", said, want);
    pktrt_scene_destroy(s);
    mesh_free(&m);
  }
}

/* Without hooks memory is malloc's, which may give none, too. */
static void scarce_memory(void) {
  world w = world_none();
  bool refused = true;
  int failed = 0;
  w.m[0] = mesh_sphere(2, 0, 1), w.n = 1;
  while (refused && CHECK(noslack_without_memory(&w, failed, &refused), "after %d times", failed)) failed += refused;
  CHECK(failed > 9, "%d in turn", failed);
  world_free(&w);
}

void suite_memory(void) {
  run("stable: each allocation failing in turn leaves the scene usable and leaks nothing", each_allocation_serial);
  run("stable: each allocation failing in turn while several threads build", each_allocation_parallel);
  run("each allocation of a first commit failing in turn leaks nothing", first_commit);
  run("stable: a rebuild that has no memory leaves the refitted tree", failing_rebuild);
  run("a scene goes on after failures as a fresh one would", usable_after_failure);
  run("without hooks, malloc giving nothing in turn is told", scarce_memory);
  run("more than the allocator gives is refused", too_large);
  run("a commit without memory names the tree that it could not build", named_trees);
}
