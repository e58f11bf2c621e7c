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
    CHECK((left[2].origin[1] != left[1].origin[1]) == !one_key, "the control, case %d: %g", k,
          (double)left[2].origin[1]);
    world_free(&w), world_free(&v);
  }
}

void suite_spawn(void) {
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
