/* The control of the culling test: the whole library once more, its error bounds scaled down to a millionth. (Not to zero:
   zero times the infinite depth of tmax is NaN, and everything would be lost.) */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#define PKTRT_STATIC
#define PKTRT_IMPLEMENTATION
#define PKTRT__SLACK_SCALE 1e-6f
#include "meshes.h"

bool noslack_trace(const world *, pktrt_isa, pktrt_path, const pktrt_ray *, pktrt_hit *, size_t n);

bool noslack_trace(const world *w, pktrt_isa isa, pktrt_path path, const pktrt_ray *rays, pktrt_hit *hits, size_t n) {
  pktrt_scene_desc d;
  pktrt_query_desc q;
  memset(&d, 0, sizeof d);
  memset(&q, 0, sizeof q);
  d.isa = isa;
  q.path = path;
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!s) return false;
  bool ok = true;
  for (uint32_t i = 0; i < w->n; i++) {
    pktrt_mesh_desc m;
    memset(&m, 0, sizeof m);
    m.positions = w->m[i].p, m.vertex_count = w->m[i].nv, m.indices = w->m[i].i;
    m.triangle_count = w->m[i].nt, m.key_count = w->m[i].keys;
    ok = ok && pktrt_add_mesh(s, &m, NULL) == PKTRT_OK;
  }
  ok = ok && pktrt_commit(s) == PKTRT_OK;
  if (ok) pktrt_intersect_ex(s, &q, rays, hits, n);
  pktrt_scene_destroy(s);
  return ok;
}
