#include "ways.h"

void ask_masked(const pktrt_scene *s, int way, uint32_t mask, const pktrt_ray *rays, size_t n, answers *a) {
  static const uint32_t packet[WAYS] = {0, 0, 1, 64, 256, 0, 0};
  pktrt_stats stats;
  pktrt_query_desc q;
  memset(&q, 0, sizeof q), memset(&stats, 0, sizeof stats), memset(a, 0x77, sizeof *a);
  q.mask = mask;
  for (size_t i = 0, few; way == 0 && mask && i < n; i += few) { /* one by one, then some more at a time */
    few = 1 + i / 16 % 24 < n - i ? 1 + i / 16 % 24 : n - i;
    pktrt_intersect_ex(s, &q, &rays[i], &a->hit[i], few), pktrt_occluded_ex(s, &q, &rays[i], &a->occluded[i], few);
  }
  for (size_t i = 0; way == 0 && !mask && i < n; i++)
    pktrt_intersect(s, &rays[i], &a->hit[i]), a->occluded[i] = pktrt_occluded(s, &rays[i]);
  if (way == 0) return;
  q.path = way == 1 || way == 6 ? PKTRT_PATH_FAST : way == 5 ? PKTRT_PATH_SINGLE : PKTRT_PATH_PAPER;
  q.packet_size = packet[way], q.stats = way >= 5 ? &stats : NULL;
  pktrt_intersect_ex(s, &q, rays, a->hit, n);
  pktrt_occluded_ex(s, &q, rays, a->occluded, n);
}
void ask(const pktrt_scene *s, int way, const pktrt_ray *rays, size_t n, answers *a) {
  ask_masked(s, way, 0, rays, n, a);
}

size_t differ(const answers *a, const answers *b, size_t n) {
  size_t wrong = 0;
  for (size_t i = 0; i < n; i++)
    wrong += !same_bits(&a->hit[i], &b->hit[i], sizeof *a->hit) || a->occluded[i] != b->occluded[i];
  return wrong;
}
size_t hits_of(const answers *a, size_t n) {
  size_t hits = 0;
  for (size_t i = 0; i < n; i++) hits += a->hit[i].mesh != PKTRT_NONE;
  return hits;
}

/* Names the meshes of hits as the other scene does. */
static void rename_meshes(const expected_scene *want, pktrt_hit *hit, size_t n) {
  for (size_t i = 0; i < n && want->map; i++)
    if (hit[i].mesh != PKTRT_NONE) hit[i].mesh = want->map[hit[i].mesh];
}

/* Compares all crossings of a ray, and how often a mesh winds around its origin. */
static size_t crossings_differ(
    const expected_scene *want, const pktrt_scene *got, const pktrt_ray *ray, uint32_t which) {
  pktrt_hit a[16], b[16];
  const size_t na = pktrt_intersect_all(want->s, ray, a, 16), nb = pktrt_intersect_all(got, ray, b, 16);
  const size_t n = na < 16 ? na : 16;
  rename_meshes(want, a, n);
  size_t wrong = na != nb || !same_bits(a, b, n * sizeof *a);
  if (want->meshes) {
    const uint32_t in_got = want->map ? want->map[which % want->meshes] : which % want->meshes;
    wrong += pktrt_winding(want->s, which % want->meshes, ray->origin, 0.5f) !=
             pktrt_winding(got, in_got, ray->origin, 0.5f);
  }
  return wrong;
}

size_t compare_with(const expected_scene *want, const pktrt_scene *got, const world *w, size_t n, size_t *wrong) {
  static answers wanted, answered;
  static pktrt_ray rays[MANY];
  size_t hits = 0;
  for (int kind = 0; kind < RAYS_KINDS; kind++) {
    make_rays(w, want->s, (ray_kind)kind, 7, 0, rays, n);
    ask(want->s, 0, rays, n, &wanted);
    rename_meshes(want, wanted.hit, n);
    hits += hits_of(&wanted, n);
    for (int way = 0; way < WAYS; way++)
      ask_masked(got, way, want->mask, rays, n, &answered), *wrong += differ(&wanted, &answered, n);
    for (size_t i = 0; i < n / 16 && !want->mask; i++) *wrong += crossings_differ(want, got, &rays[i], (uint32_t)i);
  }
  return hits;
}
size_t compare(const pktrt_scene *want, const pktrt_scene *got, const world *w, size_t n, size_t *wrong) {
  const expected_scene all = {want, NULL, 0, w->n};
  return compare_with(&all, got, w, n, wrong);
}

bool says(pktrt_scene *s, pktrt_status status, pktrt_status want, const char *words) {
  return CHECK(status == want && strstr(pktrt_last_error(s), words), "%d, \"%s\", not \"%s\"", (int)status,
      pktrt_last_error(s), words);
}
