/* What a miss spawns; and arithmetic is what the code asks for. */
#include "meshes.h"

static void spawn_of_a_miss(void) {
  world w = world_static(1);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  pktrt_ray x = ray_of(0, 50, 0, 0, 1, 0), out;
  pktrt_hit h;
  float d[3] = {0, -1, 0};
  CHECK(!pktrt_intersect(s, &x, &h));
  memset(&out, 0x77, sizeof out);
  pktrt_spawn(s, &x, &h, d, &out);
  CHECK(!pktrt_intersect(s, &out, &h) && !pktrt_occluded(s, &out));
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* A vertex far away that no triangle uses changes nothing: not rays that leave the surface, at rest or deformed, nor what a
   light that is this mesh gives. */
static void stray_vertices(void) {
  static const float floor_xyz[] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1}, far_off[3] = {9e5f, -3e6f, 2e7f};
  static const uint32_t corners[] = {0, 1, 2, 0, 2, 3};
  for (int k = 0; k < 8; k++) {
    const bool soup = k & 1, deformed = k & 2, moving = k & 4;
    pktrt_ray left[3];
    for (int with = 0; with < 3; with++) { /* 2: another triangle uses it */
      float p[2 * 10 * 3];
      uint32_t used[9] = {0, 1, 2, 0, 2, 3, 4, 4, 4}, n = soup ? 6 : 4,
               nv = soup ? with == 2 ? 9 : n + (with > 0) : n + (with > 0);
      for (uint32_t v = 0; v < n; v++) memcpy(p + 3 * v, floor_xyz + 3 * (soup ? corners[v] : v), 12);
      for (uint32_t v = n; v < nv; v++) memcpy(p + 3 * v, far_off, 12);
      memcpy(p + 3 * nv, p, 12 * nv);
      pktrt_mesh_desc d;
      memset(&d, 0, sizeof d);
      d.positions = p, d.vertex_count = nv, d.key_count = moving ? 2 : 1;
      d.triangle_count = with == 2 ? 3 : 2, d.indices = soup ? NULL : used;
      pktrt_scene_desc sd = scene_desc_of(PKTRT_ISA_AUTO, 0);
      pktrt_scene *s = pktrt_scene_create(&sd);
      CHECK(s && pktrt_add_mesh(s, &d, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
      if (deformed) {
        for (uint32_t v = 0; v < n; v++) p[3 * v + 1] += 0.25f;
        CHECK(pktrt_set_positions(s, 0, 0, p) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
      }
      pktrt_ray down = ray_of(0.3f, 2, 0.1f, 0, -1, 0);
      const float up[3] = {0, 1, 0};
      pktrt_hit h;
      CHECK(pktrt_intersect(s, &down, &h) && h.triangle < 2);
      pktrt_spawn(s, &down, &h, up, &left[with]);
      pktrt_scene_destroy(s);
    }
    CHECK(same_bits(&left[0], &left[1], sizeof left[0]), "case %d: starts at %g, with a stray vertex at %g", k,
        (double)left[0].origin[1], (double)left[1].origin[1]);
    CHECK(same_bits(&left[0], &left[2], sizeof left[0]), "nor does it count where another triangle uses it");
    CHECK(left[0].origin[1] > (deformed ? 0.25f : 0), "it starts above the floor, at %g", (double)left[0].origin[1]);
  }
}

/* How far rays start from a surface follows the mesh as it is now: grown a thousandfold or shrunk, moving or not, at a refit
   or a commit, they are those of a scene that has never been other. */
static void leaving_what_has_changed(void) {
  for (int k = 0; k < 16; k++) {
    const bool moving = k & 1, commits = k & 2, one_key = moving && k & 4;
    const float scale = k & 8 ? 1000 : 0.001f;
    mesh before = mesh_grid(2, 1), after = mesh_grid(2, scale);
    for (uint32_t i = 0; i < after.nv; i++) after.p[3 * i + 1] = 0.25f;
    if (moving) mesh_move(&before, 2, 0, 0, 1), mesh_move(&after, 2, 0, 0, 1);
    if (one_key) memcpy(after.p, before.p, (size_t)after.nv * 12); /* the second changes */
    world w = world_of(before), v = world_of(after);
    pktrt_scene *s[3] = {world_scene(&w, PKTRT_ISA_AUTO, 0), world_scene(&v, PKTRT_ISA_AUTO, 0),
        world_scene(&w, PKTRT_ISA_AUTO, 0)}; /* changed; made so; the control: not changed */
    for (uint32_t key = one_key; key < after.keys; key++)
      CHECK(pktrt_set_positions(s[0], 0, key, after.p + (size_t)key * after.nv * 3) == PKTRT_OK, "%s",
          pktrt_last_error(s[0]));
    CHECK((commits ? pktrt_commit(s[0]) : pktrt_refit(s[0])) == PKTRT_OK, "%s", pktrt_last_error(s[0]));
    const float up[3] = {0, 1, 0}, x = 0.0003f;
    pktrt_ray down = ray_of(x, 2, x / 3, 0, -1, 0), left[3];
    for (int i = 0; i < 3; i++) {
      pktrt_hit h;
      down.time = one_key ? 0 : 0.25f;
      CHECK(pktrt_intersect(s[i], &down, &h), "case %d", k);
      pktrt_spawn(s[i], &down, &h, up, &left[i]);
      pktrt_scene_destroy(s[i]);
    }
    CHECK(left[0].origin[1] == left[1].origin[1], "case %d: starts at %g, not %g", k, (double)left[0].origin[1],
        (double)left[1].origin[1]);
    CHECK(
        (left[2].origin[1] != left[1].origin[1]) == !one_key, "the control, case %d: %g", k, (double)left[2].origin[1]);
    world_free(&w), world_free(&v);
  }
}

/* What calls for many are asked, and what they answer; or what calls for one answer in their place. */
enum { ITEMS = 300, CROSSINGS = 6 };
typedef struct items {
  pktrt_ray ray[ITEMS], left[ITEMS], made[ITEMS];
  pktrt_hit hit[ITEMS], next[ITEMS], all[ITEMS][CROSSINGS];
  size_t count[ITEMS];
  bool occluded[ITEMS];
  int winding[ITEMS];
  pktrt_surface_info surface[ITEMS];
  float direction[3 * ITEMS], point[3 * ITEMS], time[ITEMS];
} items;
static void answer_one_by_one(const pktrt_scene *s, items *x) {
  for (size_t i = 0; i < ITEMS; i++) {
    pktrt_intersect(s, &x->ray[i], &x->hit[i]);
    pktrt_intersect_after(s, &x->ray[i], &x->hit[i], &x->next[i]);
    x->count[i] = pktrt_intersect_all(s, &x->ray[i], x->all[i], CROSSINGS);
    x->occluded[i] = pktrt_occluded(s, &x->ray[i]);
    x->winding[i] = pktrt_winding(s, 0, x->point + 3 * i, x->time[i]);
    pktrt_surface(s, &x->ray[i], &x->hit[i], &x->surface[i]);
    pktrt_spawn(s, &x->ray[i], &x->hit[i], x->direction + 3 * i, &x->left[i]);
    const pktrt_hit *h = &x->hit[i];
    pktrt_spawn_at(s, h->mesh, h->triangle, h->u, h->v, x->time[i], x->direction + 3 * i, &x->made[i]);
  }
}
static void answer_all_at_once(const pktrt_scene *s, items *x) {
  pktrt_intersect_n(s, x->ray, x->hit, ITEMS);
  pktrt_intersect_after_n(s, x->ray, x->hit, x->next, ITEMS);
  pktrt_intersect_all_n(s, x->ray, x->all[0], CROSSINGS, x->count, ITEMS);
  pktrt_occluded_n(s, x->ray, x->occluded, ITEMS);
  pktrt_winding_n(s, 0, x->point, x->time, x->winding, ITEMS);
  pktrt_surface_n(s, x->ray, x->hit, x->surface, ITEMS);
  pktrt_spawn_n(s, x->ray, x->hit, x->direction, x->left, ITEMS);
  pktrt_spawn_at_n(s, x->hit, x->time, x->direction, x->made, ITEMS);
}

/* Calls for many answer, item by item, what calls for one answer, where all that they are asked differs from item to item. The
   control: with one time for all, answers are others. */
static void many_are_as_many_times_one(void) {
  static items one, many, at_once;
  world w = world_moving(2);
  mesh ball = mesh_sphere(2, 0, 1);
  mesh_move(&ball, 2, 2, 0, 4);
  pktrt_scene *s = pktrt_scene_create(NULL);
  pktrt_mesh_desc d = mesh_desc(&ball);
  rng r = rng_of(31);
  CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  for (uint32_t i = 0; i < w.n; i++) {
    d = mesh_desc(&w.m[i]);
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  }
  CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));

  memset(&one, 0, sizeof one);
  make_rays(&w, s, RAYS_EDGE, 1, 0, one.ray, ITEMS);
  for (size_t i = 0; i < ITEMS; i++) {
    one.time[i] = one.ray[i].time = rng_unit(&r);
    for (int a = 0; a < 3; a++) {
      one.direction[3 * i + (size_t)a] = rng_sign(&r);
      one.point[3 * i + (size_t)a] = 1.5f * rng_sign(&r);
    }
  }
  many = at_once = one;
  for (size_t i = 0; i < ITEMS; i++) at_once.time[i] = at_once.ray[i].time = one.time[0];
  answer_one_by_one(s, &one);
  answer_all_at_once(s, &many);
  answer_all_at_once(s, &at_once);

  size_t hits = 0, windings = 0, others = 0, made = 0;
  for (size_t i = 0; i < ITEMS; i++) {
    const size_t kept = one.count[i] < CROSSINGS ? one.count[i] : CROSSINGS;
    CHECK(same_bits(&one.hit[i], &many.hit[i], sizeof one.hit[i]), "hit %zu", i);
    CHECK(same_bits(&one.next[i], &many.next[i], sizeof one.next[i]), "next hit %zu", i);
    CHECK(
        one.count[i] == many.count[i] && same_bits(one.all[i], many.all[i], kept * sizeof(pktrt_hit)), "all of %zu", i);
    CHECK(one.occluded[i] == many.occluded[i], "occluded %zu", i);
    CHECK(one.winding[i] == many.winding[i], "winding %zu: %d, %d", i, one.winding[i], many.winding[i]);
    CHECK(same_bits(&one.surface[i], &many.surface[i], sizeof one.surface[i]), "surface %zu", i);
    CHECK(same_bits(&one.left[i], &many.left[i], sizeof one.left[i]), "ray %zu that leaves", i);
    CHECK(same_bits(&one.made[i], &many.made[i], sizeof one.made[i]), "ray %zu that is made", i);
    hits += one.hit[i].mesh != PKTRT_NONE;
    windings += one.winding[i] != at_once.winding[i];
    others += !same_bits(&one.hit[i], &at_once.hit[i], sizeof one.hit[i]);
    made += !same_bits(&one.made[i], &at_once.made[i], sizeof one.made[i]);
  }
  CHECK(hits > ITEMS / 4 && windings > 3 && others > ITEMS / 8 && made > ITEMS / 8, "%zu hits, %zu, %zu, %zu others",
      hits, windings, others, made);
  say("%d items, %zu hits; control, all at one time: %zu hits, %zu windings and %zu rays are others", (int)ITEMS, hits,
      others, windings, made);
  pktrt_scene_destroy(s);
  mesh_free(&ball);
  world_free(&w);
}

void suite_spawn(void) {
  run("calls for many answer what as many calls for one do, item by item", many_are_as_many_times_one);
  run("rays leave a mesh that has changed as if it had always been so", leaving_what_has_changed);
  run("a vertex that no triangle uses changes no ray that leaves the mesh", stray_vertices);
  run("what a miss spawns hits nothing", spawn_of_a_miss);
}

/* --- arithmetic --- */

static float product_sum(float a, float b, float c) { return a * b + c; }
static double product_sum_double(double a, double b, double c) { return a * b - c; }

static void unfused(void) {
  volatile float a = 1 + 0x1p-12f, c = -(1 + 0x1p-11f);
  volatile double d = 1 + 0x1p-30, e = 1 + 0x1p-29;
  CHECK(product_sum(a, a, c) == 0, "a float product-sum was fused: compile with -ffp-contract=off");
  CHECK(product_sum_double(d, d, e) == 0, "a double product-sum was fused");
  CHECK(fmaf(a, a, c) == 0x1p-24f && fma(d, d, -e) == 0x1p-60, "the control: fused, they differ");
}

static void denormals_live(void) {
  volatile float tiny = FLT_MIN, half = 0.5f;
  CHECK(tiny * half != 0 && tiny * half < FLT_MIN, "denormals are flushed to zero");
}

void suite_arithmetic(void) {
  run("product-sums are not fused under these flags", unfused);
  run("denormals are not flushed", denormals_live);
}
