/* Checks exercise 4: packets log the same events as the library, one by one, and find the same hits. */
#define PKTRT_IMPLEMENTATION
#include "course.h"

void trace_packet(const course_scene *scene, const pktrt_node *nodes, const course_ray *rays, course_hit *hits,
    uint32_t n, course_log *log);

enum { WIDTH = 256, HEIGHT = 192, MOST = 256 /* rays */, CAMERA = WIDTH * HEIGHT / 64, GENERAL = 4000 /* packets */ };

/* Makes packet i of the camera, of 8 x 8 pixels. Returns the number of rays. */
static uint32_t camera_packet(course_ray *rays, uint32_t i) {
  for (uint32_t r = 0; r < 64; r++)
    rays[r] = course_camera_ray((float)(i % 32 * 8 + r % 8) + 0.5f, (float)(i / 32 * 8 + r / 8) + 0.5f, WIDTH, HEIGHT);
  return 64;
}

/* Makes a packet of 1 to 256 rays from different origins near each other, in similar directions, like reflected rays.
   Returns the number of rays. */
static uint32_t general_packet(course_ray *rays, uint32_t i) {
  uint32_t state = 1000 * i, n = i % 4 ? 1 + i % 64 : 1 + i % MOST;
  vec from, to;
  for (int a = 0; a < 3; a++) {
    from.at[a] = (a == 1 ? 3 : 8) * course_random(&state) - (a == 1 ? 0 : 4);
    to.at[a] = course_random(&state) - 0.5f;
  }
  for (uint32_t r = 0; r < n; r++) {
    for (int a = 0; a < 3; a++) {
      rays[r].origin.at[a] = from.at[a] + 0.5f * course_random(&state);
      rays[r].direction.at[a] = to.at[a] + 0.3f * course_random(&state);
    }
    rays[r].tmin = 0;
    rays[r].tmax = r % 8 ? INFINITY : 4;
  }
  return n;
}

/* Traces packets by the answer and by the library. Returns what differs, or NULL. */
static const char *check(const char *what, uint32_t (*make)(course_ray *, uint32_t), uint32_t packets,
    const course_scene *scene, const pktrt_scene *library, const pktrt_node *nodes) {
  course_log mine = {NULL, 0, 0}, theirs = {NULL, 0, 0};
  course_tally hits = {0, 0, 0};
  uint32_t same = 0;
  uint64_t events = 0;
  for (uint32_t i = 0; i < packets; i++) {
    course_ray rays[MOST];
    course_hit hit[MOST], expected[MOST];
    const uint32_t n = make(rays, i);

    for (uint32_t r = 0; r < n; r++) {
      const course_hit miss = {rays[r].tmax, 0, 0, COURSE_NONE};
      hit[r] = miss;
    }
    mine.count = theirs.count = 0;
    trace_packet(scene, nodes, rays, hit, n, &mine);
    course_library_packet(library, rays, n, PKTRT_PAPER_STEP_ORDER, expected, &theirs);
    const bool good = course_same_log(&mine, &theirs, i, same < i);
    same += good;
    events += theirs.count;
    for (uint32_t r = 0; r < n; r++) course_same_hit_of(scene, rays[r], &hit[r], &expected[r], &hits, i, r);
  }
  printf("%s: %u packets, %u events; %u packets log the library's events\n", what, (unsigned)packets, (unsigned)events,
      (unsigned)same);
  printf("%s: of %u hits %u differ from the library's\n", what, (unsigned)hits.rays, (unsigned)hits.different);
  return same < packets ? "events differ from the library's" : hits.different ? "hits differ" : NULL;
}

int main(void) {
  course_check_begins(4);
  course_scene scene = course_scene_make();
  pktrt_scene *library = course_library(&scene);
  uint32_t count;
  pktrt_node *nodes = course_library_nodes(library, &count);
  const char *why = check("camera", camera_packet, CAMERA, &scene, library, nodes),
             *other = check("general", general_packet, GENERAL, &scene, library, nodes);
  course_figure("packets.camera", "%u", CAMERA);
  course_figure("packets.general", "%u", GENERAL);
  pktrt_scene_destroy(library);
  return course_result(4, why ? why : other);
}
