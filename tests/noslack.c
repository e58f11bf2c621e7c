/* The control of the tests of culling and slack: the whole library once more, with bounds that can be scaled down. */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#define PKTRT_STATIC
#define PKTRT_NO_RENDER
#undef PKTRT_SCALAR /* the sets of the default will do: the best that runs here is asked */
#undef PKTRT_AVX512
#define PKTRT_IMPLEMENTATION
#define PK_NO_SETTINGS /* see settings.c */
#define PK_SLACK(part) slack_left.part
#define PK_SPLIT_PAD ((double)slack_left.parts * 0x1p-23)
/* malloc gives nothing after so many times; below 0: for ever. Not to be set while others allocate. */
#include <stdlib.h>
static int mallocs_left = -1;
static void *scarce_malloc(size_t size) {
  if (!mallocs_left) return NULL;
  if (mallocs_left > 0) mallocs_left--;
  return malloc(size);
}
#define malloc(size) scarce_malloc(size)
#include "noslack.h"
#undef malloc

/* A millionth, not zero: zero times the infinite depth of tmax is NaN, and everything would be lost. Those after the
   first row stay whole: they matter where the others are. */
#define NONE 1e-6f
#define ONES 1, 1, 1, 1, 1, 1, 1
#define OTHERS {1, 1}, {1, 1}, 1, 1, 1, 1, 1, {1, 1}, 1, 1, 1, {1, 1}, 1, 1, 1, 1, 1, {1, 1}, 1, 1
const slack_parts slack_whole = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, ONES, OTHERS},
                  slack_none = {NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, ONES, OTHERS};
slack_parts slack_left = {NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, NONE, ONES, OTHERS};

static pktrt_scene *open_scene(pktrt_isa isa, pktrt_build_quality quality) {
  pktrt_scene_desc d = scene_desc_of(isa, 0);
  d.quality = quality;
  return pktrt_scene_create(&d);
}

/* Returns the scene, or destroys it where something failed. */
static pktrt_scene *scene_if(bool ok, pktrt_scene *s) {
  if (ok) return s;
  pktrt_scene_destroy(s);
  return NULL;
}

static pktrt_scene *scene_of(const world *w, pktrt_isa isa, pktrt_build_quality quality) {
  pktrt_scene *s = open_scene(isa, quality);
  bool ok = s != NULL;
  for (uint32_t i = 0; i < w->n && ok; i++) {
    const pktrt_mesh_desc m = mesh_desc(&w->m[i]);
    ok = pktrt_add_mesh(s, &m, NULL) == PKTRT_OK;
  }
  return scene_if(ok && pktrt_commit(s) == PKTRT_OK, s);
}

pktrt_scene *noslack_scene(const world *w, pktrt_isa isa) { return scene_of(w, isa, PKTRT_BUILD_DEFAULT); }
pktrt_scene *noslack_split(const world *w, pktrt_isa isa) { return scene_of(w, isa, PKTRT_BUILD_HIGH); }

pktrt_scene *noslack_placed(const placement *p, pktrt_isa isa) {
  pktrt_scene *s = open_scene(isa, PKTRT_BUILD_DEFAULT);
  return scene_if(placement_fill(s, p), s);
}

void noslack_unstretch(pktrt_scene *s) {
  bool ok = true;
  for (uint32_t i = 0; i < s->instance_count; i++) {
    const pk_instance *in = &s->instances[i];
    for (uint32_t k = 0; k < in->key_count; k++) {
      float box[9];
      ok = ok && pk_instance_box(in->model, in->keys + 12 * (size_t)k, 0, box) &&
           pktrt_set_positions(s->boxes, i, k, box) == PKTRT_OK;
    }
  }
  CHECK(ok && pktrt_refit(s->boxes) == PKTRT_OK, "boxes do not fit");
  s->stretch = 1;
}

bool noslack_without_memory(const world *w, int times, bool *refused) {
  mallocs_left = times;
  pktrt_scene *s = pktrt_scene_create(NULL);
  pktrt_status status = s ? PKTRT_OK : PKTRT_OUT_OF_MEMORY;
  for (uint32_t i = 0; i < w->n && status == PKTRT_OK; i++) {
    const pktrt_mesh_desc m = mesh_desc(&w->m[i]);
    status = pktrt_add_mesh(s, &m, NULL);
  }
  if (status == PKTRT_OK) status = pktrt_commit(s);
  mallocs_left = -1;
  *refused = status == PKTRT_OUT_OF_MEMORY;
  const bool told = status == PKTRT_OK || (*refused && pktrt_last_error(s)[0]);
  pktrt_scene_destroy(s);
  return told;
}

pktrt_scene *noslack_create(const pktrt_scene_desc *d) { return pktrt_scene_create(d); }
const char *noslack_error(void) { return pktrt_last_error(NULL); }
void noslack_destroy(pktrt_scene *s) { pktrt_scene_destroy(s); }

void noslack_intersect(
    const pktrt_scene *s, const pktrt_query_desc *q, const pktrt_ray *rays, pktrt_hit *hits, size_t n) {
  pktrt_intersect_ex(s, q, rays, hits, n);
}

void noslack_occluded(
    const pktrt_scene *s, const pktrt_query_desc *q, const pktrt_ray *rays, bool *occluded, size_t n) {
  pktrt_occluded_ex(s, q, rays, occluded, n);
}

void noslack_spawn(
    const pktrt_scene *s, const pktrt_ray *ray, const pktrt_hit *hit, const float direction[3], pktrt_ray *out) {
  pktrt_spawn(s, ray, hit, direction, out);
}

void noslack_spawn_at(const pktrt_scene *s, uint32_t index, uint32_t triangle, float u, float v, float time,
    const float direction[3], pktrt_ray *out) {
  pktrt_spawn_at(s, index, triangle, u, v, time, direction, out);
}
