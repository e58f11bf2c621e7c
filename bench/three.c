/* The WebAssembly side of bench/three.mjs: a built-in scene as one mesh, rays that are to be traced by both libraries, and pktrt's
   answers to them. bench/three.sh compiles it. JavaScript reads and writes arrays where these functions say they are. */
#define PKTRT_IMPLEMENTATION
#include "peers/rays.h"
#include <emscripten.h>

enum { THREE_SIZE = 512 }; /* of the picture whose rays are traced */

static stage all; /* one mesh */
static pktrt_scene *world;
static sources from;
static ray_set rays;
static pktrt_hit *hit;

/* Puts all meshes, at rest, into one, since three-mesh-bvh has a tree for each. */
static void merge(const scene *s, scene *out) {
  uint32_t vertices = 0, triangles = 0;
  for (size_t i = 0; i < s->mesh_count; i++)
    vertices += s->meshes[i].vertex_count, triangles += s->meshes[i].triangle_count;
  stage_room(out, 1);
  scene_mesh *m = &out->meshes[0];
  mesh_room(m, vertices, triangles);
  vertices = triangles = 0;
  for (size_t i = 0; i < s->mesh_count; i++) {
    const scene_mesh *part = &s->meshes[i];
    memcpy(m->positions + 3 * (size_t)vertices, part->positions, 3 * sizeof(float) * (size_t)part->vertex_count);
    for (size_t k = 0; k < 3 * (size_t)part->triangle_count; k++)
      m->indices[3 * (size_t)triangles + k] = part->indices[k] + vertices;
    vertices += part->vertex_count, triangles += part->triangle_count;
  }
}

EMSCRIPTEN_KEEPALIVE bool three_open(const char *name) {
  static const view_options view; /* zeroed: the scene brings its own */
  const size_t most = (size_t)THREE_SIZE * THREE_SIZE;
  stage parts;
  if (!open_stage(name, &view, &parts)) return false;
  merge(&parts.s, &all.s);
  all.s.camera = parts.s.camera;
  stage_finish(&all, parts.name, BUILT_IN);
  close_stage(&parts);
  hit = (pktrt_hit *)take(most, sizeof *hit);
  rays = rays_room(most);
  sources_room(&from, most);
  return true;
}

/* Builds the tree anew. */
EMSCRIPTEN_KEEPALIVE void three_build(bool high) {
  pktrt_scene_destroy(world);
  world = stage_scene(&all, PKTRT_ISA_AUTO, high);
  if (pktrt_commit(world) != PKTRT_OK) fatal(pktrt_last_error(world));
}

EMSCRIPTEN_KEEPALIVE const float *three_positions(void) { return all.s.meshes[0].positions; }
EMSCRIPTEN_KEEPALIVE const uint32_t *three_indices(void) { return all.s.meshes[0].indices; }
EMSCRIPTEN_KEEPALIVE unsigned three_vertices(void) { return all.s.meshes[0].vertex_count; }
EMSCRIPTEN_KEEPALIVE unsigned three_triangles(void) { return all.s.meshes[0].triangle_count; }

/* Makes the rays of a kind: nine floats each, as in pktrt_ray. Returns how many. */
EMSCRIPTEN_KEEPALIVE unsigned three_make(bool diffuse) {
  make_sources(&all, world, THREE_SIZE, false, &from);
  make_kind(&all, world, diffuse ? DIFFUSE : PRIMARY, &from, &rays);
  return (unsigned)rays.count;
}

EMSCRIPTEN_KEEPALIVE pktrt_ray *three_rays(void) { return rays.ray; }
EMSCRIPTEN_KEEPALIVE const pktrt_hit *three_hits(void) { return hit; }
EMSCRIPTEN_KEEPALIVE void three_many(void) { pktrt_intersect_n(world, rays.ray, hit, rays.count); }
EMSCRIPTEN_KEEPALIVE bool three_one(void) { return pktrt_intersect(world, rays.ray, hit); } /* the first ray */
