/* 08_reflect.c - packets of camera rays after reflection at a flat and at a curved mirror.

   Prints how full packets and vectors are by bounce. Makes out/course/08_balls.png, the scene; 08_packets.svg, two packets
   from above, one at a mirror ball and one at a mirror wall; 08_bounces.svg, lanes in use and vector tests by bounce. */
#define PKTRT_IMPLEMENTATION
#include "08_figures.h"

enum { WALL = 3, BALL = 4 + 5 }; /* numbers of meshes: a wall, and ball 5 */
/* Renders the scene, or ends the program with the library's error message. */
static void render(pktrt_scene *s, const pktrt_render_desc *d) {
  if (pktrt_render(s, d) == PKTRT_OK) return;
  ex_fail("%s", pktrt_last_error(s));
  exit(1);
}

/* [block] */
/* Returns the block of 8 x 8 pixels from which most rays descend, among the blocks all of whose camera rays hit a mesh. */
static uint32_t block_that_hits(const pktrt_scene *s, const reflect_log *log, uint32_t mesh) {
  uint32_t hitting[BLOCKS * BLOCKS] = {0}, rays[BLOCKS * BLOCKS] = {0}, best = 0;
  for (uint32_t i = 0; i < log->n; i++) {
    const reflect_ray *r = &log->ray[i];
    const pktrt_ray ray = query_ray(r);
    pktrt_hit hit;
    rays[block_of(r)]++;
    if (r->depth == 0 && pktrt_intersect(s, &ray, &hit) && hit.mesh == mesh) hitting[block_of(r)]++;
  }
  for (uint32_t b = 0; b < BLOCKS * BLOCKS; b++) {
    if (hitting[b] < EDGE * EDGE) rays[b] = 0;
    if (rays[b] > rays[best]) best = b;
  }
  return best;
}
/* [end] */

/* [cost] */
/* Traces the packets of one bounce that descend from a block, and returns how many rays and vector tests they take. */
static block_cost trace_block(const pktrt_scene *s, const reflect_log *log, uint32_t block, uint32_t depth) {
  static uint32_t order[1 << 16], end[1 << 16];
  static pktrt_hit hits[1 << 16];
  block_cost cost = {0, 0, 0, 0};

  for (uint32_t k = 0, begin = 0; k < log->packets; begin = log->end[k++]) {
    const reflect_ray *first = &log->ray[begin]; /* all rays of a packet descend from the same block */
    if (first->depth != depth || block_of(first) != block) continue;
    for (uint32_t i = begin; i < log->end[k]; i++) order[cost.rays++] = i;
    if (first->type == PKTRT_RAY_REFLECTION) cost.reflected += log->end[k] - begin;
    end[cost.packets++] = cost.rays;
  }

  if (cost.rays > 0)
    cost.tests_per_ray = (double)reflect_trace(s, log->ray, order, end, cost.packets, hits) / cost.rays;
  return cost;
}
/* [end] */

/* Prints for each bounce the packets of rays that descend from a block, and the vector tests per ray. */
static void print_block(
    const pktrt_scene *s, const reflect_log *log, uint32_t block, const char *title, const char *name) {
  enum { BOUNCES = 5 };
  block_cost cost[BOUNCES];
  uint32_t bounces = 0;
  printf("\n%s, by bounce: rays, packets, vector tests per ray\n", title);
  for (uint32_t depth = 0; depth < BOUNCES; depth++) {
    const block_cost c = trace_block(s, log, block, depth);
    if (c.rays == 0) break;
    printf("  %u: %4u %3u %6.1f\n", (unsigned)depth, (unsigned)c.rays, (unsigned)c.packets, c.tests_per_ray);
    cost[bounces++] = c;
  }
  for (uint32_t depth = 0; depth < bounces; depth++) print_block_figures(name, depth, cost[depth]);
}

int main(void) {
  enum { LARGE = 320 };
  static float pixels[LARGE * LARGE * 3];
  static pktrt_stats stats[3];
  svg g;
  pktrt_scene *s = reflect_scene();
  reflect_log log = reflect_log_make();

  /* The same picture by packets of ray types, by packets of runs, and by single rays. */
  pktrt_render_desc d = reflect_view(pixels);
  d.packet = reflect_log_packet;
  d.user = &log;
  d.stats = &stats[0];
  render(s, &d);
  d.packet = NULL;
  d.stats = &stats[1];
  d.assembly = PKTRT_ASSEMBLY_RUNS;
  render(s, &d);
  d.stats = &stats[2];
  d.path = PKTRT_PATH_SINGLE;
  render(s, &d);
  print_bounces(&stats[0], &stats[1], &stats[2]);

  const uint32_t wall = block_that_hits(s, &log, WALL);
  const uint32_t ball = block_that_hits(s, &log, BALL);
  print_block(s, &log, wall, "a packet at the mirror wall", "wall");
  print_block(s, &log, ball, "a packet at a mirror ball", "ball");

  course_make_folder();
  if (!svg_begin(&g, "out/course/08_packets.svg", 960, 700)) return 1;
  draw_block(&g, s, &log, wall, 0, "at the mirror wall");
  draw_block(&g, s, &log, ball, 488, "at a mirror ball");
  svg_text(&g, 8, 690, 15, SVG_LEFT,
      "Camera rays grey, then blue, orange, red; rays into the sky end in the air. Dark line: the mirror.");
  if (!svg_end(&g)) return 1;

  if (!svg_begin(&g, "out/course/08_bounces.svg", 720, 225)) return 1;
  draw_bars(&g, 10, "Lanes in use: ray types (blue), runs (orange)", stats, true);
  draw_bars(&g, 380, "Vector tests per ray by bounce", stats, false);
  if (!svg_end(&g)) return 1;

  d = reflect_view(pixels);
  d.width = LARGE;
  d.height = LARGE;
  d.samples = 4;
  render(s, &d);
  reflect_log_free(&log);
  pktrt_scene_destroy(s);
  return !ex_write_picture("out/course/08_balls.png", pixels, LARGE, LARGE);
}
