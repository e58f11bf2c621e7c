/* before_version.c - compiled once for each of the two versions of before.c: VERSION names the struct, HEADER the pktrt.h. */
#define PKTRT_STATIC
#define PKTRT_IMPLEMENTATION
#ifdef __GNUC__ /* most of the library is not called */
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include HEADER
#include "before.h"
#include "fresh.h"

#define TEXT_(x) #x
#define TEXT(x) TEXT_(x)

static void *open_scene(const before_mesh *meshes, size_t count, int isa) {
  pktrt_scene_desc desc;
  memset(&desc, 0, sizeof desc);
  desc.isa = (pktrt_isa)isa;
  pktrt_scene *s = pktrt_scene_create(&desc);
  bool ok = s != NULL;
  for (size_t i = 0; ok && i < count; i++) {
    pktrt_mesh_desc d;
    memset(&d, 0, sizeof d);
    d.positions = meshes[i].positions, d.vertex_count = meshes[i].vertex_count, d.key_count = meshes[i].key_count;
    d.indices = meshes[i].indices, d.triangle_count = meshes[i].triangle_count;
    ok = pktrt_add_mesh(s, &d, NULL) == PKTRT_OK;
  }
  if (ok && pktrt_commit(s) == PKTRT_OK) return s;
  pktrt_scene_destroy(s);
  return NULL;
}

static void close_scene(void *scene) { pktrt_scene_destroy((pktrt_scene *)scene); }

static void ask_rows(const pktrt_scene *s, const question *q) {
  pktrt_rays rays;
  pktrt_hits hits;
  memset(&rays, 0, sizeof rays), memset(&hits, 0, sizeof hits);
  for (int a = 0; a < 3; a++)
    rays.origin[a] = q->row[a], rays.direction[a] = q->row[3 + a], hits.normal[a] = q->real[3 + a];
  rays.tmin = q->row[6], rays.tmax = q->row[7], rays.time = q->row[8];
  hits.t = q->real[0], hits.u = q->real[1], hits.v = q->real[2], hits.mesh = q->index[0], hits.triangle = q->index[1];
  if (q->occlusion) pktrt_occluded_soa(s, &rays, q->occluded, q->count);
  else pktrt_intersect_soa(s, &rays, &hits, q->count);
}

static void ask_fresh(const pktrt_scene *s, const question *q) {
  for (size_t i = 0; i < q->count; i++) {
    pktrt_ray ray;
    write_ray(&q->ray[i], &ray);
    if (q->occlusion) q->occluded[i] = pktrt_occluded(s, &ray);
    else pktrt_intersect(s, &ray, &q->hit[i]);
  }
}

static void ask(const void *scene, way w, const question *q) {
  const pktrt_scene *s = (const pktrt_scene *)scene;
  if (w == ROWS) ask_rows(s, q);
  else if (w == FRESH) ask_fresh(s, q);
  else if (w == MANY && q->occlusion) pktrt_occluded_n(s, q->ray, q->occluded, q->count);
  else if (w == MANY) pktrt_intersect_n(s, q->ray, q->hit, q->count);
  for (size_t i = 0; w == SINGLE && i < q->count; i++)
    if (q->occlusion) q->occluded[i] = pktrt_occluded(s, &q->ray[i]);
    else pktrt_intersect(s, &q->ray[i], &q->hit[i]);
}

static void spawn(
    const void *scene, const pktrt_ray *ray, const pktrt_hit *hit, const float direction[3], pktrt_ray *out) {
  pktrt_spawn((const pktrt_scene *)scene, ray, hit, direction, out);
}

extern const version VERSION;
const version VERSION = {TEXT(VERSION), sizeof(pktrt_ray), sizeof(pktrt_hit), open_scene, close_scene, ask, spawn};
