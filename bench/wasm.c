/* Times rays of all kinds on the built-in scenes: prints scene, kind, and nanoseconds of a ray by the calls _n and by single ones. bench/wasm.sh
   compiles it for WebAssembly twice, with its vectors and without, and lets node run both in turns. */
#define PKTRT_IMPLEMENTATION
#include "peers/rays.h"

enum { WASM_SIZE = 192, WASM_ROUNDS = 5 };

/* Returns the least time of some rounds, per ray. */
static double time_of(
    const pktrt_scene *world, const ray_set *rays, bool occlusion, bool many, pktrt_hit *hit, bool *dark) {
  double least = INFINITY;
  for (int round = 0; round < WASM_ROUNDS; round++) {
    const double start = ex_seconds();
    if (many && occlusion) pktrt_occluded_n(world, rays->ray, dark, rays->count);
    else if (many) pktrt_intersect_n(world, rays->ray, hit, rays->count);
    for (size_t i = 0; i < rays->count && !many; i++)
      if (occlusion) dark[i] = pktrt_occluded(world, &rays->ray[i]);
      else pktrt_intersect(world, &rays->ray[i], &hit[i]);
    least = fmin(least, ex_seconds() - start);
  }
  return 1e9 * least / (double)rays->count;
}

int main(void) {
  const size_t most = (size_t)WASM_SIZE * WASM_SIZE;
  pktrt_hit *hit = (pktrt_hit *)take(most, sizeof *hit);
  bool *dark = (bool *)take(most, sizeof *dark);
  static const char *const names[] = {"poolhall", "conference", "rtrt"};
  static const view_options view; /* zeroed: the scenes bring their own */
  for (int i = 0; i < 3; i++) {
    stage g;
    sources s;
    if (!open_stage(names[i], &view, &g)) fatal("a scene cannot be made");
    pktrt_scene *world = stage_scene(&g, PKTRT_ISA_AUTO, false);
    if (pktrt_commit(world) != PKTRT_OK) fatal(pktrt_last_error(world));
    ray_set rays = rays_room(most);
    sources_room(&s, most);
    make_sources(&g, world, WASM_SIZE, false, &s);
    for (int k = 0; k < KINDS; k++) {
      make_kind(&g, world, (kind)k, &s, &rays);
      if (!rays.count) continue;
      printf("%s %s %.2f %.2f\n", g.name, kind_names[k],
          time_of(world, &rays, kind_occlusion((kind)k), true, hit, dark),
          time_of(world, &rays, kind_occlusion((kind)k), false, hit, dark));
    }
    rays_free(&rays), sources_free(&s);
    pktrt_scene_destroy(world);
    close_stage(&g);
  }
  return 0;
}
