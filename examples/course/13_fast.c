/* Chapter 13: the fast path. Makes out/course/13_masks.svg, 13_hull.svg and 13_choice.png.

   Prints what single rays, streams and frusta save.    cc -O2 examples/course/13_fast.c -o fast -lm && ./fast */
#define PKTRT_COUNT_FAST
#define PKTRT_IMPLEMENTATION
#include "course.h"
#include "13_fast.h"
#include "13_figures.h"

enum { FIRST = 300 * 64 }; /* ray with which the calls of the text's table begin */

/* Traces rays by our walks, 256 in a call. Adds verdicts to *v, and sets who traces each ray. */
static fast_counts our_counts(const course_scene *scene, const pktrt_node *nodes, const course_ray *rays, uint32_t n,
    bool any, fast_walk most, verdicts *v, uint8_t *walk) {
  fast_counts all = {0, 0, 0, 0, 0, 0, 0, 0};

  for (uint32_t i = 0, count; i < n; i += count) {
    count = n - i < FAST_BATCH ? n - i : FAST_BATCH;
    fast_rays f = fast_rays_make(scene, nodes, rays + i, count, any);
    f.asked = verdicts_count;
    f.user = v;
    fast_trace(&f, most);
    fast_counts_add(&all, &f.counts);
    memcpy(walk + i, f.walk, count);
    fast_rays_free(&f);
  }
  return all;
}

/* Prints counts per ray, for the text's tables. */
static void print_row(const char *kind, const char *walk, double n, double nodes, double boxes, double vectors) {
  char row[40];
  snprintf(row, sizeof row, "%.15s.%.15s", kind, walk);
  printf("  %-6s nodes %.2f, box tests %.1f, vector tests %.2f\n", walk, nodes / n, boxes / n, vectors / n);
  fast_figure(row, "nodes", "%.2f", nodes / n);
  fast_figure(row, "boxes", "%.1f", boxes / n);
  fast_figure(row, "vectors", "%.2f", vectors / n);
  fast_figure(row, "lanes", "%.1f", boxes / vectors);
}

/* Prints the least number of rays of a call that the library does not trace one by one. */
static void print_few(const pktrt_scene *library, const course_ray *rays, bool any, const char *name) {
  uint32_t n = 1;
  while (rays_library_counts(library, rays, n, any, PKTRT_PATH_FAST).packets == n) n++;
  printf("%s: as many rays are traced together: %u\n", name, (unsigned)n);
  course_figure(name, "%u", (unsigned)n);
}

/* Counts the calls of up to 256 rays for which our walks form the library's packets and drop as many children, and open
   as many nodes and test as many boxes, within 4 in 100. A library without frusta is compared with streams. */
static uint32_t same_calls(const course_scene *scene, const pktrt_scene *library, const pktrt_node *nodes,
    const course_ray *rays, uint32_t n, bool any, fast_walk most) {
  uint32_t same = 0;
  for (uint32_t i = 0, count; i < n; i += count) {
    uint8_t walk[FAST_BATCH];
    verdicts v = verdicts_none;
    count = n - i < FAST_BATCH ? n - i : FAST_BATCH;
    const fast_counts ours = our_counts(scene, nodes, rays + i, count, any, most, &v, walk);
    const pktrt_counts theirs = rays_library_counts(library, rays + i, count, any, PKTRT_PATH_FAST);
    const double opened = (double)theirs.node_visits, tested = (double)theirs.box_tests;
    same += ours.packets == theirs.packets && ours.culls == theirs.frustum_culls &&
            fabs((double)ours.nodes - opened) <= 2 + 0.04 * opened &&
            fabs((double)ours.boxes - tested) <= 16 + 0.04 * tested;
  }
  return same;
}

int main(void) {
  static course_ray rays[RAYS_PIXELS];
  static uint8_t walk[RAYS_PIXELS];
  static uint32_t pixel[RAYS_PIXELS];
  const course_scene scene = course_scene_make();
  pktrt_scene *library = course_library(&scene);
  uint32_t count, calls = 0, same = 0;
  pktrt_node *nodes = course_library_nodes(library, &count);
  course_picture choice = course_picture_make(3 * RAYS_WIDTH, RAYS_HEIGHT);
  uint32_t by[RAYS_KINDS][CALLS][FAST_WALKS] = {{{0}}};
  bool frusta = false;

  for (int kind = 0; kind < RAYS_KINDS; kind++) {
    const bool any = kind == RAYS_SHADOW;
    const char *name = rays_name[kind];
    uint32_t n = 0;
    verdicts v = verdicts_none;
    for (uint32_t i = 0; i < RAYS_PIXELS; i++)
      if (rays_aim(&rays[n], i, kind, &scene, library)) pixel[n++] = rays_pixel(i);

    printf("%s, %u rays; per ray:\n", name, (unsigned)n);
    for (int most = 0; most < FAST_WALKS; most++) {
      static const char *const walk_name[FAST_WALKS] = {"single", "stream", "fast"};
      v = verdicts_none;
      const fast_counts c = our_counts(&scene, nodes, rays, n, any, (fast_walk)most, &v, walk);
      print_row(name, walk_name[most], n, (double)c.nodes, (double)c.boxes, (double)c.vectors);
      if (most != FAST_FRUSTUM) continue;
      fast_figure(name, "thin", "%.0f", (double)c.thin);
      fast_figure(name, "whole", "%.0f", (double)c.whole);
      fast_figure(name, "tested", "%.0f", (double)c.tested);
    }
    const pktrt_counts c = rays_library_counts(library, rays, n, any, PKTRT_PATH_PAPER);
    print_row(name, "paper", n, (double)c.node_visits, (double)c.box_tests, (double)c.vector_box_tests);
    verdicts_print(&v, name, walk, n);
    calls_count(by[kind], &scene, nodes, rays + FIRST, any);

    if (kind == RAYS_CAMERA) {
      print_few(library, rays, false, "few.nearest");
      print_few(library, rays, true, "few.any");
      frusta = rays_library_counts(library, rays, n, false, PKTRT_PATH_FAST).frustum_culls > 0;
    }
    same += same_calls(&scene, library, nodes, rays, n, any, frusta ? FAST_FRUSTUM : FAST_STREAM);
    calls += (n + FAST_BATCH - 1) / FAST_BATCH;
    if (kind == RAYS_SHADOW || kind == RAYS_REFLECTED)
      choice_draw(&choice, kind == RAYS_SHADOW ? 0 : RAYS_WIDTH, RAYS_WIDTH, pixel, walk, n);
    if (kind == RAYS_SCATTERED) choice_draw(&choice, 2 * RAYS_WIDTH, RAYS_WIDTH, pixel, walk, n);
  }

  calls_print(by, rays_name, RAYS_KINDS);
  printf("of %u calls of up to 256 rays the library counts the same in %u\n", (unsigned)calls, (unsigned)same);
  course_figure("calls", "%u", (unsigned)calls);
  course_figure("calls.same", "%u", (unsigned)same);
  course_picture_write(&choice, "out/course/13_choice.png");
  draw_hulls(&scene, nodes, library);
  draw_masks(&scene, nodes, count, library);
  pktrt_scene_destroy(library);
  return 0;
}
