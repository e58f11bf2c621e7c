/* 06_solution.c - which steps of the paper path are worth most? All sets are tried. */
#include "06_ablate.h"

static uint64_t tests(
    const pktrt_scene *s, const pktrt_ray *rays, size_t n, uint32_t packet_size, uint32_t steps, ablate_cost cost) {
  pktrt_hit *hits = (pktrt_hit *)course_memory(n, sizeof *hits);
  pktrt_stats stats;
  pktrt_query_desc query;
  memset(&stats, 0, sizeof stats), memset(&query, 0, sizeof query);
  query.path = PKTRT_PATH_PAPER, query.packet_size = packet_size;
  query.paper_steps = steps ? steps : PKTRT_PAPER_STEP_NONE, query.stats = &stats;
  pktrt_intersect_ex(s, &query, rays, hits, n);
  free(hits);
  const pktrt_counts *c = &stats.by_type[query.type];
  return cost == ABLATE_BOX_TESTS        ? c->box_tests
         : cost == ABLATE_TRIANGLE_TESTS ? c->triangle_tests
                                         : c->vector_box_tests + c->vector_triangle_tests;
}

uint32_t ablate_fewest(
    const pktrt_scene *s, const pktrt_ray *rays, size_t n, uint32_t packet_size, int count, ablate_cost cost) {
  uint32_t best = 0;
  uint64_t fewest = UINT64_MAX;
  for (uint32_t steps = 0; steps < 64; steps++) {
    int bits = 0;
    for (uint32_t b = steps; b; b &= b - 1) bits++;
    if (bits > count) continue;
    const uint64_t t = tests(s, rays, n, packet_size, steps, cost);
    if (t < fewest) fewest = t, best = steps;
  }
  return best ? best : PKTRT_PAPER_STEP_NONE;
}
