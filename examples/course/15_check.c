/* Checks exercise 15: accounts of packets are the library's statistics, packet by packet, and the prediction is that of
   sums. As controls, accounts and predictions with a known fault must be refused. */
#define PKTRT_IMPLEMENTATION
#include "15_exercise.h"

enum { WIDTH = 128, HEIGHT = 96, ROOM = WIDTH * HEIGHT, KINDS = 3, SIZES = 5 };

static const char *const kind_name[KINDS] = {"camera", "reflected", "shadow"};
static const uint32_t size_of_packet[SIZES] = {64, 1, 12, 100, 256};

typedef account account_rule(const pktrt_event *, size_t, uint32_t, bool);
typedef account_split predict_rule(const account *, const account *, size_t, double);

/* Rays of one kind, in blocks of 16 x 16 pixels row by row. */
typedef struct ray_list {
  pktrt_ray *ray;
  uint32_t rays;
} ray_list;

/* Makes the rays of all kinds: the camera's, those of mirrors where these end, and shadow rays to a lamp. */
static void make_rays(const pktrt_scene *library, ray_list list[KINDS]) {
  const vec lamp = {{-2.5f, 6, 3}};
  for (int k = 0; k < KINDS; k++) {
    list[k].ray = (pktrt_ray *)course_memory(ROOM, sizeof *list[k].ray);
    list[k].rays = 0;
  }

  for (uint32_t i = 0; i < ROOM; i++) {
    const uint32_t block = i / 256, x = block % (WIDTH / 16) * 16 + i % 16, y = block / (WIDTH / 16) * 16 + i / 16 % 16;
    const pktrt_ray camera = course_library_ray(course_camera_ray((float)x + 0.5f, (float)y + 0.5f, WIDTH, HEIGHT));
    pktrt_surface_info surface;
    pktrt_hit hit;
    vec direction;
    float along = 0;
    list[0].ray[list[0].rays++] = camera;
    if (!pktrt_intersect(library, &camera, &hit)) continue;

    pktrt_surface(library, &camera, &hit, &surface);
    for (int a = 0; a < 3; a++) along += camera.direction[a] * surface.shading_normal[a];
    for (int a = 0; a < 3; a++) direction.at[a] = camera.direction[a] - 2 * along * surface.shading_normal[a];
    pktrt_spawn(library, &camera, &hit, direction.at, &list[1].ray[list[1].rays++]);

    pktrt_ray *shadow = &list[2].ray[list[2].rays++];
    for (int a = 0; a < 3; a++) direction.at[a] = lamp.at[a] - (camera.origin[a] + hit.t * camera.direction[a]);
    pktrt_spawn(library, &camera, &hit, direction.at, shadow);
    for (int a = 0; a < 3; a++) shadow->direction[a] = lamp.at[a] - shadow->origin[a];
    shadow->tmax = 1;
  }
}

/* Traces a packet, logs its events, and returns the library's account. */
static account trace(const pktrt_scene *library, const pktrt_ray *rays, uint32_t n, bool shadow, course_log *log) {
  static pktrt_stats stats;
  pktrt_hit hit[256];
  bool occluded[256];
  pktrt_query_desc query;
  const pktrt_counts *counts = &stats.by_type[PKTRT_RAY_PRIMARY];
  memset(&stats, 0, sizeof stats);
  memset(&query, 0, sizeof query);
  query.path = PKTRT_PATH_PAPER;
  query.packet_size = n;
  query.stats = &stats;
  query.trace = course_log_event;
  query.user = log;
  log->count = 0;
  if (shadow) pktrt_occluded_ex(library, &query, rays, occluded, n);
  else pktrt_intersect_ex(library, &query, rays, hit, n);
  for (size_t i = 0; i < log->count; i++) log->event[i].tested = 0;

  const account theirs = {
      counts->node_visits, counts->interval_culls + counts->frustum_culls, counts->vector_box_tests, counts->box_tests};
  return theirs;
}

static void add(account *sum, const account *one) {
  sum->nodes += one->nodes;
  sum->culled += one->culled;
  sum->box_vectors += one->box_vectors;
  sum->boxes += one->boxes;
}

/* Compares an account with the library's; if aloud, says what differs first. */
static bool same(const account *mine, const account *theirs, bool aloud) {
  const struct {
    const char *name;
    uint64_t mine, theirs;
  } part[] = {{"nodes", mine->nodes, theirs->nodes}, {"culled", mine->culled, theirs->culled},
      {"box_vectors", mine->box_vectors, theirs->box_vectors}, {"boxes", mine->boxes, theirs->boxes}};

  for (size_t i = 0; i < sizeof part / sizeof *part; i++) {
    if (part[i].mine == part[i].theirs) continue;
    if (aloud)
      printf("  expected: %s = %u\n  got: %s = %u\n", part[i].name, (unsigned)part[i].theirs, part[i].name,
          (unsigned)part[i].mine);
    return false;
  }
  return true;
}

/* Returns for how many of the first events of a packet, one after the other, the account is right: finds where a wrong one
   begins to differ. A library that stopped there would have the sum of `tested` up to there. */
static size_t first_wrong(
    account_rule *rule, const pktrt_scene *library, const pktrt_ray *rays, uint32_t n, bool shadow, course_log *log) {
  static uint64_t boxes[1 << 16];
  uint64_t sum = 0;
  pktrt_query_desc query;
  pktrt_hit hit[256];
  bool occluded[256];
  memset(&query, 0, sizeof query);
  query.path = PKTRT_PATH_PAPER;
  query.packet_size = n;
  query.trace = course_log_event;
  query.user = log;
  log->count = 0;
  if (shadow) pktrt_occluded_ex(library, &query, rays, occluded, n);
  else pktrt_intersect_ex(library, &query, rays, hit, n);
  if (log->count > 1 << 16) return log->count;

  for (size_t i = 0; i < log->count; i++) {
    sum += log->event[i].tested;
    log->event[i].tested = 0;
    boxes[i] = sum;
  }
  for (size_t i = 0; i < log->count; i++) {
    /* Tests before a LATER_HIT may be told with its TRIM. */
    if (log->event[i].kind == PKTRT_EVENT_TRIM) continue;
    const account mine = rule(log->event, i + 1, n, shadow);
    if (mine.boxes == boxes[i]) continue;
    printf("  the first event that makes boxes differ: number %u, ", (unsigned)i + 1);
    printf("boxes up to it expected: %u, got: %u\n", (unsigned)boxes[i], (unsigned)mine.boxes);
    if (log->event[i].kind == PKTRT_EVENT_LEAF_TEST)
      printf("  the event: LEAF_TEST, index %u, ray %u\n", (unsigned)log->event[i].index, (unsigned)log->event[i].ray);
    else course_say_event("the event", log, i);
    return i;
  }
  return log->count;
}

/* Judges a rule of accounts on all packets. Returns how many are wrong; if aloud, says what is wrong with the first. */
static uint32_t judge_accounts(
    account_rule *rule, const pktrt_scene *library, const ray_list list[KINDS], bool aloud, uint32_t *packets) {
  static course_log log;
  uint32_t wrong = 0;
  *packets = 0;

  for (int size = 0; size < SIZES; size++)
    for (int k = 0; k < KINDS; k++)
      for (uint32_t begin = 0; begin < list[k].rays; begin += size_of_packet[size]) {
        /* Of single rays every sixteenth will do. */
        if (size_of_packet[size] == 1 && begin % 16) continue;
        const uint32_t left = list[k].rays - begin, n = left < size_of_packet[size] ? left : size_of_packet[size];
        const account theirs = trace(library, list[k].ray + begin, n, k == 2, &log);
        const account mine = rule(log.event, log.count, n, k == 2);
        const bool first = aloud && wrong == 0;
        (*packets)++;
        if (same(&mine, &theirs, false)) continue;
        wrong++;
        if (!first) continue;
        printf("packet %u, of %u %s rays, with %u events:\n", (unsigned)*packets - 1, (unsigned)n, kind_name[k],
            (unsigned)log.count);
        same(&mine, &theirs, true);
        (void)first_wrong(rule, library, list[k].ray + begin, n, k == 2, &log);
      }
  return wrong;
}

/* Returns true if numbers are the same but for rounding. */
static bool near(double a, double b) { return fabs(a - b) <= 1e-9 * fabs(b); }

/* Judges a prediction for packets of 64 rays of each kind by the library's statistics. */
static bool judge_prediction(predict_rule *rule, const pktrt_scene *library, const ray_list list[KINDS], bool aloud) {
  static course_log log;
  static account alone[ROOM / 64 + 1], packet[ROOM / 64 + 1];

  for (int k = 0; k < KINDS; k++)
    for (int cost = 0; cost <= 8; cost += 4) {
      account sum[2];
      size_t packets = 0;
      memset(sum, 0, sizeof sum);
      for (uint32_t begin = 0; begin < list[k].rays; begin += 64, packets++) {
        const uint32_t n = list[k].rays - begin < 64 ? list[k].rays - begin : 64;
        packet[packets] = trace(library, list[k].ray + begin, n, k == 2, &log);
        memset(&alone[packets], 0, sizeof *alone);
        for (uint32_t i = 0; i < n; i++) {
          const account one = trace(library, list[k].ray + begin + i, 1, k == 2, &log);
          add(&alone[packets], &one);
        }
        add(&sum[0], &alone[packets]);
        add(&sum[1], &packet[packets]);
      }

      const double node = cost,
                   expected[4] = {((double)sum[0].box_vectors + node * (double)sum[0].nodes) /
                                      ((double)sum[1].box_vectors + node * (double)sum[1].nodes),
                       (double)sum[1].boxes / (double)sum[1].box_vectors, (double)sum[0].boxes / (double)sum[1].boxes,
                       ((double)sum[0].box_vectors + node * (double)sum[0].nodes) /
                           ((double)sum[1].box_vectors + node * (double)sum[1].nodes) * (double)sum[1].box_vectors /
                           (double)sum[0].boxes};
      const account_split split = rule(alone, packet, packets, node);
      const double got[4] = {split.speedup, split.lanes, split.fewer, split.rest};
      static const char *const name[4] = {"speedup", "lanes", "fewer", "rest"};
      for (int i = 0; i < 4; i++) {
        if (near(got[i], expected[i])) continue;
        if (aloud)
          printf("%u packets of %s rays, packet 0 to %u, node_cost %d:\n  expected: %s = %.6f\n  got: %s = %.6f\n",
              (unsigned)packets, kind_name[k], (unsigned)packets - 1, cost, name[i], expected[i], name[i], got[i]);
        return false;
      }
      if (aloud)
        printf("  %-9s rays, a node as dear as %d vectors: %.2f times as fast = lanes %.2f * fewer %.2f * rest %.2f\n",
            kind_name[k], cost, got[0], got[1], got[2], got[3]);
    }
  return true;
}

/* >>controls ------------------------------------------------------------------------------------------------------- */

/* Counts one vector for each verdict, and eight lanes for each vector. */
static account careless_account(const pktrt_event *event, size_t events, uint32_t rays, bool shadow) {
  account sum = {0, 0, 0, 0};
  (void)rays;
  (void)shadow;
  for (const pktrt_event *e = event; e < event + events; e++) {
    sum.nodes += e->kind == PKTRT_EVENT_NODE;
    sum.culled += e->kind == PKTRT_EVENT_INTERVAL_CULL || e->kind == PKTRT_EVENT_FRUSTUM_CULL;
    sum.box_vectors += e->kind >= PKTRT_EVENT_FIRST_HIT && e->kind <= PKTRT_EVENT_ALL_MISS;
  }
  sum.boxes = 8 * sum.box_vectors;
  return sum;
}

/* Takes all rays for active to the end. */
static account forgetful_account(const pktrt_event *event, size_t events, uint32_t rays, bool shadow) {
  (void)shadow;
  return account_of(event, events, rays, false);
}

/* Takes the mean of the packets' speed-ups for the speed-up of all. */
static account_split mean_prediction(const account *alone, const account *packet, size_t packets, double node_cost) {
  account_split split = account_predict(alone, packet, packets, node_cost);
  double sum = 0;
  for (size_t k = 0; k < packets; k++) {
    const double cost = (double)packet[k].box_vectors + node_cost * (double)packet[k].nodes;
    sum += ((double)alone[k].box_vectors + node_cost * (double)alone[k].nodes) / cost;
  }
  split.speedup = sum / (double)packets;
  return split;
}

int main(void) {
  const course_scene scene_ = course_scene_make();
  pktrt_scene *library = course_library(&scene_);
  ray_list list[KINDS];
  uint32_t packets;
  course_check_begins(15);
  make_rays(library, list);

  const uint32_t wrong = judge_accounts(account_of, library, list, true, &packets);
  printf("  %u of %u accounts differ from the library's statistics\n", (unsigned)wrong, (unsigned)packets);
  if (wrong > 0) return course_result(15, "accounts are not the library's statistics");
  course_figure("packets", "%u", (unsigned)packets);
  for (int k = 0; k < KINDS; k++) course_figure(kind_name[k], "%u", (unsigned)list[k].rays);
  if (!judge_prediction(account_predict, library, list, true))
    return course_result(15, "the prediction is not that of the sums");

  if (judge_accounts(careless_account, library, list, false, &packets) < packets / 2 ||
      judge_accounts(forgetful_account, library, list, false, &packets) == 0 ||
      judge_prediction(mean_prediction, library, list, false))
    return course_result(15, "the check lets through what is wrong");
  return course_result(15, NULL);
}
