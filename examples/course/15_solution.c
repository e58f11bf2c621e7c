/* A solution of exercise 15. */
#include "15_exercise.h"

typedef struct walk {
  account sum;
  uint32_t rays;
  bool active[256];
} walk;

/* Counts a test of a group, from ray `from` on. */
static void test_group(walk *w, uint32_t group, uint32_t from) {
  uint32_t lanes = 0;
  for (uint32_t r = 8 * group; r < 8 * group + 8 && r < w->rays; r++) lanes += r >= from && w->active[r];
  w->sum.boxes += lanes;
  w->sum.box_vectors += lanes > 0;
}

account account_of(const pktrt_event *event, size_t events, uint32_t rays, bool shadow) {
  uint32_t begin[64], end[64]; /* ranges of the nodes on the way down */
  uint32_t leaf_group = 0;
  walk w;
  memset(&w, 0, sizeof w);
  w.rays = rays;
  for (uint32_t r = 0; r < rays; r++) w.active[r] = true;

  for (const pktrt_event *e = event; e < event + events; e++) {
    const uint32_t group = e->ray / 8;

    if (e->kind == PKTRT_EVENT_NODE) {
      w.sum.nodes++;
      begin[e->depth] = e->ray;
      end[e->depth] = e->ray + e->active;
    }
    if (e->kind == PKTRT_EVENT_HIT && shadow) w.active[e->ray] = false;
    if (e->kind == PKTRT_EVENT_LEAF) leaf_group = group;
    if (e->kind == PKTRT_EVENT_LEAF_TEST && group != leaf_group) test_group(&w, group, 0);
    if (e->kind < PKTRT_EVENT_FIRST_HIT || e->kind > PKTRT_EVENT_ALL_MISS) continue;

    uint32_t first = begin[e->depth - 1];
    const uint32_t last = end[e->depth - 1];
    while (!w.active[first]) first++;
    test_group(&w, first / 8, first);
    w.sum.culled += e->kind == PKTRT_EVENT_INTERVAL_CULL || e->kind == PKTRT_EVENT_FRUSTUM_CULL;

    if (e->kind == PKTRT_EVENT_ALL_MISS)
      for (uint32_t g = first / 8 + 1; 8 * g < last; g++) test_group(&w, g, 0);
    if (e->kind != PKTRT_EVENT_LATER_HIT || group == first / 8) continue;

    for (uint32_t g = first / 8 + 1; g <= group; g++) test_group(&w, g, 0);
    for (uint32_t g = (last - 1) / 8; g > group; g--) {
      test_group(&w, g, 0);
      if (8 * g < e->ray + e->active) break;
    }
  }
  return w.sum;
}

account_split account_predict(const account *alone, const account *packet, size_t packets, double node_cost) {
  double vectors = 0, tests = 0, cost = 0, tests_alone = 0, cost_alone = 0;

  for (size_t k = 0; k < packets; k++) {
    vectors += (double)packet[k].box_vectors;
    tests += (double)packet[k].boxes;
    tests_alone += (double)alone[k].boxes;
    cost += (double)packet[k].box_vectors + node_cost * (double)packet[k].nodes;
    cost_alone += (double)alone[k].box_vectors + node_cost * (double)alone[k].nodes;
  }
  account_split split = {cost_alone / cost, tests / vectors, tests_alone / tests, 0};
  split.rest = split.speedup / (split.lanes * split.fewer);
  return split;
}
