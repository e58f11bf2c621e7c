/* What a miss spawns; and arithmetic is not fused. */
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

void suite_spawn(void) {
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
