/* Spawned rays do not meet the surface they left; and arithmetic is not fused. */
#include "meshes.h"

typedef struct spawn_count {
  size_t rays, self, self_plain, any;
} spawn_count;

/* From random points above a surface at o onto it and off again, to its either side. */
static void spawn_off(const world *w, bool convex, float scale, const float offset[3], uint64_t seed, spawn_count *c) {
  pktrt_scene *s = world_scene(w, PKTRT_ISA_AUTO, 0);
  for (size_t i = 0; i < scaled(4000); i++) {
    rng r = rng_of(seed * 7919 + i);
    float o[3], p[3], d[3];
    for (int k = 0; k < 3; k++) o[k] = offset[k] + 3 * scale * rng_sign(&r), p[k] = offset[k] + 0.7f * scale * rng_sign(&r);
    pktrt_ray x = ray_towards(o, p, rng_unit(&r)), out;
    pktrt_hit h, next;
    if (!pktrt_intersect(s, &x, &h)) continue;
    for (int k = 0; k < 3; k++) d[k] = rng_sign(&r);
    float along = dot3(d, h.normal);
    if (fabsf(along) < 0.02f) continue;
    if (convex && along < 0) for (int k = 0; k < 3; k++) d[k] = -d[k]; /* outwards */
    pktrt_spawn(s, &x, &h, d, &out);
    CHECK(out.tmin == 0 && out.tmax == INFINITY && same_bits(&out.time, &x.time, 4) && same_bits(out.direction, d, 12));
    c->rays++;
    bool hit = pktrt_intersect(s, &out, &next);
    c->self += hit && next.mesh == h.mesh && next.triangle == h.triangle;
    c->any += hit && convex;
    for (int k = 0; k < 3; k++) { /* it starts close to the hit */
      float point = x.origin[k] + h.t * x.direction[k];
      float reach = 1e-4f * (scale + fabsf(offset[0]) + fabsf(offset[1]) + fabsf(offset[2]));
      CHECK(fabsf(out.origin[k] - point) <= reach, "moved by %g of %g", (double)(out.origin[k] - point), (double)scale);
      out.origin[k] = point;
    }
    hit = pktrt_intersect(s, &out, &next); /* the control: no offset */
    c->self_plain += hit && next.mesh == h.mesh && next.triangle == h.triangle;
  }
  pktrt_scene_destroy(s);
}

static void spawned(void) {
  static const float scales[6] = {1e-4f, 1e-2f, 1, 1e2f, 1e4f, 1e6f}, offsets[4] = {0, 1, 1e3f, 1e5f};
  spawn_count c;
  memset(&c, 0, sizeof c);
  for (int a = 0; a < 6; a++) {
    for (int b = 0; b < 4; b++) {
      for (int kind = 0; kind < 4; kind++) {
        float at[3] = {offsets[b], -0.3f * offsets[b], 0.6f * offsets[b]};
        float size = scales[a];
        if (offsets[b] > size * 1e5f) continue; /* beyond that a float cannot hold the shape */
        world w = world_none();
        w.n = 1;
        w.m[0] = kind == 0 ? mesh_grid(4, 1) : kind == 1 ? mesh_box() : kind == 2 ? mesh_sphere(2, 0, 1) : mesh_soup(60, 1, 3);
        if (kind == 3) mesh_move(&w.m[0], 3, 0.2f, 0.2f, 2);
        world_place(&w, size, at[0], at[1], at[2]);
        /* rounding to far coordinates dents a sphere: there only the triangle itself counts */
        bool convex = kind < 2 || (kind == 2 && b == 0);
        spawn_off(&w, convex, size, at, (uint64_t)(a * 100 + b * 10 + kind), &c);
        world_free(&w);
      }
    }
  }
  say("%zu spawned rays: %zu meet the triangle they left, %zu leave a convex body and meet it; without offset %zu", c.rays, c.self,
      c.any, c.self_plain);
  CHECK(c.self == 0 && c.any == 0);
  CHECK(c.self_plain > 0, "without an offset some do");
  CHECK(c.rays > scaled(50000));
}

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

void suite_spawn(void) {
  run("spawned rays do not meet the surface they left, near or far, small or large", spawned);
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
