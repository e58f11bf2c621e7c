/* 06_check.c - checks the exercise of chapter 6: tries every set of steps, and compares. */
#define PKTRT_IMPLEMENTATION
#include "06_ablate.h"

enum { WIDTH = 64, RAYS = WIDTH * WIDTH, SETS = 64 };

static const char *const kinds[] = {"box tests", "triangle tests", "vector tests"};
static const struct demand {
  bool mirrored; /* rays from the camera, or those that a mirror would make of them */
  uint32_t packet;
  int count;
  ablate_cost cost;
} demands[] = {
    {false, 256, 1, ABLATE_TRIANGLE_TESTS},
    {false, 256, 2, ABLATE_TRIANGLE_TESTS},
    {false, 64, 0, ABLATE_BOX_TESTS},
    {false, 16, 1, ABLATE_BOX_TESTS},
    {false, 256, 2, ABLATE_VECTOR_TESTS},
    {true, 256, 2, ABLATE_VECTOR_TESTS},
    {true, 16, 3, ABLATE_VECTOR_TESTS},
    {true, 64, 6, ABLATE_BOX_TESTS},
    {true, 64, 6, ABLATE_VECTOR_TESTS},
};
enum { DEMANDS = sizeof demands / sizeof demands[0] };

static void print_steps(uint32_t steps) {
  static const char *const names[] = {"group", "intervals", "frustum", "trim", "leaf boxes", "order"};
  const char *between = "";
  for (int i = 0; i < 6; i++)
    if (steps >> i & 1) printf("%s%s", between, names[i]), between = " + ";
  if (!(steps & 63)) printf("no step");
}

static int count_of(uint32_t steps) {
  int n = 0;
  for (; steps; steps &= steps - 1) n++;
  return n;
}

/* Tests of each set, and whether the hits are the same bits as with all steps. */
static bool measure(const pktrt_scene *s, const pktrt_ray *rays, uint32_t packet, uint64_t tests[3][SETS]) {
  static pktrt_hit hits[RAYS], all[RAYS];
  for (uint32_t steps = SETS; steps-- > 0;) {
    pktrt_stats stats;
    pktrt_query_desc query;
    memset(&stats, 0, sizeof stats), memset(&query, 0, sizeof query);
    query.path = PKTRT_PATH_PAPER, query.packet_size = packet;
    query.paper_steps = steps ? steps : PKTRT_PAPER_STEP_NONE, query.stats = &stats;
    pktrt_intersect_ex(s, &query, rays, hits, RAYS);
    const pktrt_counts *c = &stats.by_type[query.type];
    tests[ABLATE_BOX_TESTS][steps] = c->box_tests, tests[ABLATE_TRIANGLE_TESTS][steps] = c->triangle_tests;
    tests[ABLATE_VECTOR_TESTS][steps] = c->vector_box_tests + c->vector_triangle_tests;
    if (steps == SETS - 1) memcpy(all, hits, sizeof hits);
    if (memcmp(all, hits, sizeof hits)) return false;
  }
  return true;
}

/* Returns what is wrong with the answer to a question, or NULL. */
static const char *fault(const pktrt_scene *s, const pktrt_ray *rays, const struct demand *d) {
  static uint64_t tests[3][SETS];
  if (!measure(s, rays, d->packet, tests)) return "hits differ between sets of steps";
  const uint64_t *t = tests[d->cost];
  uint32_t best = 0;
  for (uint32_t i = 1; i < SETS; i++)
    if (count_of(i) <= d->count && t[i] < t[best]) best = i;
  const uint32_t answer = ablate_fewest(s, rays, RAYS, d->packet, d->count, d->cost);
  const uint32_t steps = answer == PKTRT_PAPER_STEP_NONE ? 0 : answer;
  printf("%s rays, packets of %u, fewest %s with at most %d of the steps: ", d->mirrored ? "mirrored" : "camera",
      (unsigned)d->packet, kinds[d->cost], d->count);
  if (answer == 0)
    return printf("got 0, which means all steps; none is PKTRT_PAPER_STEP_NONE\n"), "an answer is 0, which is no set";
  if (answer > PKTRT_PAPER_STEP_NONE)
    return printf("got %u, which is no such set\n", (unsigned)answer), "an answer is no set of steps";
  print_steps(steps);
  if (count_of(steps) > d->count)
    return printf(", which are %d\n", count_of(steps)), "a set has more steps than were asked for";
  printf(", %.1f a ray\n", (double)t[steps] / RAYS);
  if (t[steps] == t[best]) return NULL;
  printf("  expected: ");
  print_steps(best);
  printf(", %.1f a ray\n", (double)t[best] / RAYS);
  return "another set takes fewer tests";
}

int main(void) {
  static pktrt_ray rays[2][RAYS];
  scene room;
  const char *why = NULL;
  pktrt_scene *s = pktrt_scene_create(NULL);
  if (!s || !scene_make("conference", &room)) return ex_fail("out of memory"), 1;
  if (scene_add(s, &room) || pktrt_commit(s)) return ex_fail("%s", pktrt_last_error(s)), 1;
  ablate_camera_rays(&room.camera, WIDTH, rays[0]);
  memcpy(rays[1], rays[0], sizeof rays[0]);
  ablate_reflect(s, rays[1], RAYS);
  for (int i = 0; i < DEMANDS && !why; i++) why = fault(s, rays[demands[i].mirrored], &demands[i]);
  if (!why) printf("Hits are the same bits with every set.\n");
  pktrt_scene_destroy(s);
  scene_free(&room);
  return course_result(6, why);
}
