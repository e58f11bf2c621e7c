/* Checks exercise 3: the hits are the library's, and few nodes are opened for them. */
#define PKTRT_IMPLEMENTATION
#include "course.h"

const pktrt_node *open_node(uint32_t index);
course_hit nearest_first(const course_scene *scene, course_ray ray);

static pktrt_node *nodes;
static uint32_t node_count;
static uint64_t opened;

/* Returns a node, and counts it unless it is the root. The check fails if there is no such node. */
const pktrt_node *open_node(uint32_t index) {
  if (index >= node_count) {
    printf("there is no node %u\n", (unsigned)index);
    exit(course_result(3, "a node was asked for that is not there"));
  }
  opened += index != 0;
  return &nodes[index];
}

/* Traces rays by the answer. Returns what is wrong with the hits or with the number of opened nodes, or NULL.
   WHY 1.1: an answer that drops no child whose box begins beyond the hit opens at least a fifth more for the camera. */
static const char *check(
    const char *what, const course_scene *scene, const pktrt_scene *library, const course_ray *rays, uint32_t n) {
  const double margin = 1.1;
  course_tally tally = {0, 0, 0};
  uint32_t hits = 0;
  uint64_t library_opened = 0;

  opened = 0;
  for (uint32_t i = 0; i < n; i++) {
    const course_hit expected = course_library_hit(library, rays[i]), hit = nearest_first(scene, rays[i]);
    hits += expected.triangle != COURSE_NONE;
    library_opened += course_library_opens(library, rays[i]);
    course_same_hit(scene, rays[i], &hit, &expected, &tally);
  }

  /* The library's numbers include the root. */
  const double each = (double)opened / n, theirs = (double)library_opened / n - 1;
  printf("%s: %u rays, %u of which hit something; %u answers differ, %u more are excused at edges\n", what, (unsigned)n,
      (unsigned)hits, (unsigned)tally.different, (unsigned)tally.excused);
  printf("%s: a ray opens %.3f nodes below the root, the library %.3f; %.3f are allowed\n", what, each, theirs,
      margin * theirs);
  if (tally.different) return "hits differ from the library's";
  return each > margin * theirs ? "too many nodes are opened" : NULL;
}

int main(void) {
  enum { WIDTH = 128, HEIGHT = 96, RAYS = WIDTH * HEIGHT };
  static course_ray camera[RAYS], any[RAYS];
  course_check_begins(3);
  course_scene scene = course_scene_make();
  pktrt_scene *library = course_library(&scene);
  nodes = course_library_nodes(library, &node_count);
  uint32_t state = 3;
  for (uint32_t i = 0; i < RAYS; i++) {
    camera[i] = course_camera_ray((float)(i % WIDTH) + 0.5f, (float)(i / WIDTH) + 0.5f, WIDTH, HEIGHT);

    /* From anywhere to anywhere; every fourth ray is short. */
    for (int a = 0; a < 3; a++) {
      any[i].origin.at[a] = (a == 1 ? 3 : 8) * course_random(&state) - (a == 1 ? 0 : 4);
      any[i].direction.at[a] = course_random(&state) - 0.5f;
    }
    any[i].tmin = 0;
    any[i].tmax = i % 4 ? INFINITY : 8 * course_random(&state);
  }
  const char *why = check("camera", &scene, library, camera, RAYS),
             *other = check("anywhere", &scene, library, any, RAYS);
  course_figure("rays", "%u", RAYS);
  pktrt_scene_destroy(library);
  return course_result(3, why ? why : other);
}
