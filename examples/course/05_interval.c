/* Chapter 5: one test for a whole packet. Makes out/course/05_boxes.svg.

   Prints how many box tests each step saves.    cc -O2 examples/course/05_interval.c -o interval -lm && ./interval */
#define PKTRT_IMPLEMENTATION
#include "course.h"
#include "05_boxes.h"
#include "05_planes.h"

enum { WIDTH = 256, HEIGHT = 192, SIDE = 8, RAYS = SIDE * SIDE, PACKETS = WIDTH * HEIGHT / RAYS };

/* Makes packet i: the camera's rays through 8 x 8 pixels, or the shadow rays from the points that these rays hit, which
   share no origin. Returns false if shadow rays are wanted and one of the camera's rays hits nothing. */
static bool aim(course_ray *rays, uint32_t i, const pktrt_scene *library, bool shadow) {
  const vec light = {{-3, 7, 5}};
  for (uint32_t r = 0; r < RAYS; r++) {
    const uint32_t x = i * SIDE % WIDTH + r % SIDE, y = i * SIDE / WIDTH * SIDE + r / SIDE;
    rays[r] = course_camera_ray((float)x + 0.5f, (float)y + 0.5f, WIDTH, HEIGHT);
    if (!shadow) continue;
    const course_hit hit = course_library_hit(library, rays[r]);
    if (hit.triangle == COURSE_NONE) return false;
    rays[r].origin = vec_add(rays[r].origin, vec_scale(rays[r].direction, 0.999f * hit.t));
    rays[r].direction = vec_sub(light, rays[r].origin);
    rays[r].tmax = 1;
  }
  return true;
}

/* Traces a packet of shadow rays: a ray that has found a hit is done. */
static void occlude(const pktrt_scene *library, const course_ray *rays, uint32_t steps, course_log *log) {
  pktrt_query_desc query;
  pktrt_ray ray[RAYS];
  bool occluded[RAYS];

  memset(&query, 0, sizeof query);
  query.path = PKTRT_PATH_PAPER;
  query.packet_size = RAYS;
  query.paper_steps = steps;
  query.type = PKTRT_RAY_SHADOW;
  query.trace = course_log_event;
  query.user = log;
  for (uint32_t r = 0; r < RAYS; r++) ray[r] = course_library_ray(rays[r]);
  pktrt_occluded_ex(library, &query, ray, occluded, RAYS);
}

/* Prints a figure of a row of the text's table. */
static void row_figure(const char *row, const char *name, const char *format, double value) {
  char full[64];
  snprintf(full, sizeof full, "%s.%s", row, name);
  course_figure(full, format, value);
}

/* Traces all packets with these steps, and prints how their children are dropped: a row of the text's table. */
static void table(const pktrt_scene *library, bool shadow, const char *row, uint32_t steps) {
  double told[PKTRT_EVENT_LEAF_TEST + 1] = {0}, tests = 0, packets = 0;
  course_log log = {NULL, 0, 0};
  course_ray rays[RAYS];

  for (uint32_t i = 0; i < PACKETS; i++) {
    if (!aim(rays, i, library, shadow)) continue;
    if (shadow) occlude(library, rays, steps | PKTRT_PAPER_STEP_ORDER, &log);
    else course_library_packet(library, rays, RAYS, steps | PKTRT_PAPER_STEP_ORDER, NULL, &log);
    packets++;
  }
  for (size_t i = 0; i < log.count; i++) {
    told[log.event[i].kind]++;
    tests += log.event[i].tested;
  }

  const double intervals = told[PKTRT_EVENT_INTERVAL_CULL], planes_drop = told[PKTRT_EVENT_FRUSTUM_CULL];
  const double children = told[PKTRT_EVENT_ALL_MISS] + intervals + planes_drop;
  printf(
      "  %s: %.0f packets; of %.0f children that no ray enters, intervals drop %.0f and planes %.0f; a ray is tested "
      "against %.2f boxes\n",
      row, packets, children, intervals, planes_drop, tests / packets / RAYS);
  row_figure(row, "packets", "%.0f", packets);
  row_figure(row, "children", "%.0f", children);
  row_figure(row, "intervals", "%.0f", intervals);
  row_figure(row, "planes", "%.0f", planes_drop);
  row_figure(row, "dropped", "%.1f", 100 * (intervals + planes_drop) / children);
  row_figure(row, "boxes", "%.2f", tests / packets / RAYS);
}

/* Counts the camera's packets in which a direction component changes its sign. */
static void count_signs(const pktrt_scene *library) {
  uint32_t packets = 0;
  course_ray rays[RAYS];

  for (uint32_t i = 0; i < PACKETS; i++) {
    bool mixed = false;
    aim(rays, i, library, false);
    for (uint32_t r = 1; r < RAYS; r++)
      for (int a = 0; a < 3; a++) mixed |= signbit(rays[r].direction.at[a]) != signbit(rays[0].direction.at[a]);
    packets += mixed;
  }
  printf("  in %u packets of the camera a direction component changes its sign\n", (unsigned)packets);
  course_figure("mixed", "%u", (unsigned)packets);
}

/* Compares the planes of 05_planes.h with the library's, for all children that the first active ray misses. */
static void compare(const pktrt_scene *library, const pktrt_node *nodes) {
  uint32_t verdicts = 0, same = 0;
  course_log log = {NULL, 0, 0};
  course_ray rays[RAYS];
  for (uint32_t i = 0; i < PACKETS; i++) {
    planes p;
    aim(rays, i, library, false);
    const bool have = planes_make(&p, rays, RAYS, course_slabs_make(nodes, rays[0]).pad);
    log.count = 0;
    course_library_packet(library, rays, RAYS, PKTRT_PAPER_STEP_FRUSTUM | PKTRT_PAPER_STEP_ORDER, NULL, &log);
    for (size_t j = 0; j < log.count; j++) {
      const pktrt_event *e = &log.event[j];
      const bool dropped = e->kind == PKTRT_EVENT_FRUSTUM_CULL;
      if (!dropped && e->kind != PKTRT_EVENT_LATER_HIT && e->kind != PKTRT_EVENT_ALL_MISS) continue;
      same += (have && planes_miss(&p, nodes[e->index].lo[e->child], nodes[e->index].hi[e->child])) == dropped;
      verdicts++;
    }
  }
  printf("  our planes and the library's: %u verdicts, %u the same\n", (unsigned)verdicts, (unsigned)same);
  course_figure("verdicts", "%u", (unsigned)verdicts);
  course_figure("verdicts.same", "%u", (unsigned)same);
}

int main(void) {
  course_scene scene = course_scene_make();
  pktrt_scene *library = course_library(&scene);
  course_ray rays[RAYS];
  uint32_t count;
  pktrt_node *nodes = course_library_nodes(library, &count);

  printf("05_interval: %u packets of %u rays\n", PACKETS, RAYS);
  course_figure("packets", "%u", PACKETS);
  course_figure("rays", "%u", RAYS);
  table(library, false, "camera.none", 0);
  table(library, false, "camera.intervals", PKTRT_PAPER_STEP_INTERVALS);
  table(library, false, "camera.planes", PKTRT_PAPER_STEP_FRUSTUM);
  table(library, false, "camera.both", PKTRT_PAPER_STEP_INTERVALS | PKTRT_PAPER_STEP_FRUSTUM);
  table(library, true, "shadow.none", 0);
  table(library, true, "shadow.intervals", PKTRT_PAPER_STEP_INTERVALS);
  count_signs(library);
  compare(library, nodes);
  aim(rays, 12 * WIDTH / SIDE + 26, library, false);
  boxes_draw("out/course/05_boxes.svg", library, nodes, rays, RAYS);
  pktrt_scene_destroy(library);
  return 0;
}
