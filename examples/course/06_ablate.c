/* 06_ablate.c - what the steps of the packet traversal are worth: each is left out once, and tests are counted.

   Prints tests per ray for packets of 2 x 2 to 16 x 16 camera rays and all that descends from them. Draws
   out/course/06_steps.svg, vector tests by step, and out/course/06_figure6.svg, figure 6 of the paper with all steps and
   with those that the paper had. */
#define PKTRT_IMPLEMENTATION
#include "06_figures.h"

/* [cost] */
/* Returns the tests per ray, over rays of all types. */
static cost cost_of(const pktrt_stats *stats) {
  cost c = {0, 0, 0, 0};
  double rays = 0;
  for (int type = 0; type < PKTRT_RAY_TYPE_COUNT; type++) {
    const pktrt_counts *n = &stats->by_type[type];
    rays += (double)n->rays;
    c.boxes += (double)n->box_tests;
    c.triangles += (double)n->triangle_tests;
    c.box_vectors += (double)n->vector_box_tests;
    c.triangle_vectors += (double)n->vector_triangle_tests;
  }
  c.boxes /= rays;
  c.triangles /= rays;
  c.box_vectors /= rays;
  c.triangle_vectors /= rays;
  return c;
}
/* [end] */

/* [run] */
/* Renders every fourth tile of a picture of the room, which takes a quarter of the time, and returns the tests per ray. */
static cost run(const pktrt_scene *s, const scene *room, uint32_t edge, uint32_t steps, float *pixels) {
  pktrt_render_desc d;
  pktrt_stats stats;
  memset(&d, 0, sizeof d);
  memset(&stats, 0, sizeof stats);
  d.samples = 1;
  d.width = WIDTH;
  d.height = WIDTH;
  d.pixels = pixels;
  d.stats = &stats;
  d.mode = PKTRT_MODE_WRT;
  d.camera = room->camera;
  d.normals = PKTRT_NORMALS_GEOMETRIC;
  d.path = PKTRT_PATH_PAPER;
  d.packet_size = edge;
  d.paper_steps = steps;

  for (uint32_t y = 0; y < WIDTH / TILE; y++)
    for (uint32_t x = y * 2 % 4 + y / 2 % 2; x < WIDTH / TILE; x += 4)
      if (pktrt_render_tile(s, &d, x * TILE, y * TILE, TILE, TILE)) {
        ex_fail("a tile could not be rendered");
        exit(1);
      }
  return cost_of(&stats);
}
/* [end] */

int main(void) {
  static float pixels[2][WIDTH * WIDTH * 3];
  static cost got[WAYS][EDGES];
  scene room;
  svg s;
  pktrt_scene *library = pktrt_scene_create(NULL);
  if (!library || !scene_make("conference", &room)) {
    ex_fail("out of memory");
    return 1;
  }
  if (scene_add(library, &room) || pktrt_commit(library)) {
    ex_fail("%s", pktrt_last_error(library));
    return 1;
  }

  for (int e = 0; e < EDGES; e++)
    for (int w = 0; w < WAYS; w++) {
      float *mine = pixels[w + e > 0];
      got[w][e] = run(library, &room, edges[e], ways[w].steps, mine);
      if (memcmp(mine, pixels[0], sizeof pixels[0])) {
        ex_fail("%s: another picture", ways[w].name);
        return 1;
      }
    }

  printf("conference, Whitted's mode, %d x %d pixels, a quarter of the tiles: %d pictures, all the same bits\n", WIDTH,
      WIDTH, WAYS * EDGES);
  course_figure("pictures", "%d", WAYS * EDGES);
  print_table("box tests per ray", "boxes", got, 0);
  print_table("triangle tests per ray", "triangles", got, 1);
  print_table("vector tests per ray", "vectors", got, 2);
  const uint32_t neither = ALL - PKTRT_PAPER_STEP_TRIM - PKTRT_PAPER_STEP_LEAF_BOXES; /* for instructors.md */
  course_figure("triangles.neither.16", "%.1f", run(library, &room, 16, neither, pixels[1]).triangles);
  course_figure("trimming.saves", "%.1f", vectors(&got[4][3]) - vectors(&got[0][3]));
  course_make_folder();
  if (!draw_steps(got) || !svg_begin(&s, "out/course/06_figure6.svg", 720, 255)) return 1;
  draw_graph(&s, 30, "Triangle tests per ray", got, false);
  draw_graph(&s, 390, "Box tests per ray (same scale)", got, true);
  pktrt_scene_destroy(library);
  scene_free(&room);
  return !svg_end(&s);
}
