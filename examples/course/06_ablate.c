/* 06_ablate.c - what the steps of the packet traversal are worth: each is left out once, and tests are counted.

   Prints tests per ray for packets of 2 x 2 to 16 x 16 camera rays and all that descends from them. Draws
   out/course/06_steps.svg, vector tests by step, and out/course/06_figure6.svg, figure 6 of the paper with all steps and
   with those that the paper had. */
#define PKTRT_IMPLEMENTATION
#include "06_ablate.h"
#include "../svg.h"

enum { SIZE = 256, TILE = 16, WAYS = 9, EDGES = 4 };
static const uint32_t edges[EDGES] = {2, 4, 8, 16};

/* [ways] */
enum { ALL = 2 * PKTRT_PAPER_STEP_ORDER - 1 };
static const struct way {
  const char *name;
  uint32_t steps;
} ways[WAYS] = {
    {"all steps", ALL},
    {"without the group", ALL - PKTRT_PAPER_STEP_GROUP},
    {"without intervals", ALL - PKTRT_PAPER_STEP_INTERVALS},
    {"without the frustum", ALL - PKTRT_PAPER_STEP_FRUSTUM},
    {"without trimming", ALL - PKTRT_PAPER_STEP_TRIM},
    {"without leaf boxes", ALL - PKTRT_PAPER_STEP_LEAF_BOXES},
    {"without the order", ALL - PKTRT_PAPER_STEP_ORDER},
    {"those of 2007", PKTRT_PAPER_STEPS_2007},
    {"none", PKTRT_PAPER_STEP_NONE},
};
/* [end] */

typedef struct cost { /* per ray */
  double boxes, triangles, box_vectors, triangle_vectors;
} cost;

/* [cost] */
/* Adds up what rays of all types took. */
static cost cost_of(const pktrt_stats *stats) {
  cost c = {0, 0, 0, 0};
  double rays = 0;
  for (int type = 0; type < PKTRT_RAY_TYPE_COUNT; type++) {
    const pktrt_counts *n = &stats->by_type[type];
    rays += (double)n->rays;
    c.boxes += (double)n->box_tests, c.triangles += (double)n->triangle_tests;
    c.box_vectors += (double)n->vector_box_tests, c.triangle_vectors += (double)n->vector_triangle_tests;
  }
  c.boxes /= rays, c.triangles /= rays, c.box_vectors /= rays, c.triangle_vectors /= rays;
  return c;
}
/* [end] */

/* [run] */
/* Renders every fourth tile of a picture of the room: as good as the whole for counting, in a quarter of the time. */
static cost run(const pktrt_scene *s, const scene *room, uint32_t edge, uint32_t steps, float *pixels) {
  pktrt_render_desc d;
  pktrt_stats stats;
  memset(&d, 0, sizeof d), memset(&stats, 0, sizeof stats);
  d.samples = 1;
  d.width = d.height = SIZE, d.pixels = pixels, d.stats = &stats;
  d.mode = PKTRT_MODE_WRT, d.camera = room->camera, d.normals = PKTRT_NORMALS_GEOMETRIC;
  d.path = PKTRT_PATH_PAPER, d.packet_size = edge, d.paper_steps = steps;
  for (uint32_t y = 0; y < SIZE / TILE; y++)
    for (uint32_t x = y * 2 % 4 + y / 2 % 2; x < SIZE / TILE; x += 4)
      if (pktrt_render_tile(s, &d, x * TILE, y * TILE, TILE, TILE)) ex_fail("a tile could not be rendered"), exit(1);
  return cost_of(&stats);
}
/* [end] */

static double vectors(const cost *c) { return c->box_vectors + c->triangle_vectors; }

static void print_table(const char *what, cost got[WAYS][EDGES], int kind) {
  printf("\n%-24s    2x2    4x4    8x8  16x16\n", what);
  for (int w = 0; w < WAYS; w++) {
    printf("%-24s", ways[w].name);
    for (int e = 0; e < EDGES; e++) {
      const cost *c = &got[w][e];
      printf(" %6.1f", kind == 0 ? c->boxes : kind == 1 ? c->triangles : vectors(c));
    }
    printf("\n");
  }
}

/* A bar for each way and size of packets: tests of boxes, then those of triangles. */
static bool draw_steps(cost got[WAYS][EDGES]) {
  svg s;
  if (!svg_begin(&s, "out/course/06_steps.svg", 880, 250)) return false;
  svg_text(&s, 10, 18, 13, SVG_LEFT, "Vector tests per ray: boxes (blue), triangles (orange)");
  for (int w = 0; w < WAYS; w++) svg_text(&s, 130, 67 + 20 * w, 12, SVG_RIGHT, "%s", ways[w].name);
  for (int e = 0; e < EDGES; e++) {
    const double x = 140 + 185 * e;
    svg_text(&s, x, 45, 12, SVG_LEFT, "%u x %u", (unsigned)edges[e], (unsigned)edges[e]);
    for (int w = 0; w < WAYS; w++) {
      const cost *c = &got[w][e];
      const double y = 54 + 20 * w, boxes = 1.4 * c->box_vectors, all = 1.4 * vectors(c);
      svg_box(&s, x, y, x + boxes, y + 16, "#47a", NULL);
      svg_box(&s, x + boxes, y, x + all, y + 16, "#e84", NULL);
      svg_text(&s, x + all + 4, y + 13, 11, SVG_LEFT, "%.0f", vectors(c));
    }
  }
  return svg_end(&s);
}

/* One half of figure 6: tests per ray over the size of packets, with all steps and with those of the paper. */
static void draw_graph(svg *s, double x, const char *what, cost got[WAYS][EDGES], bool boxes) {
  static const int shown[2] = {0, 7};
  static const char *const colour[2] = {"#47a", "#c33"};
  svg_text(s, x, 20, 13, SVG_LEFT, "%s", what);
  svg_line(s, x, 230, x + 300, 230, "#888", 1);
  for (int k = 0; k < 2; k++) {
    double y0 = 0;
    for (int e = 0; e < EDGES; e++) {
      const cost *c = &got[shown[k]][e];
      const double v = boxes ? c->boxes : c->triangles, at = x + 20 + 80 * e, y = 230 - 0.75 * v;
      if (e) svg_line(s, at - 80, y0, at, y, colour[k], 2);
      svg_dot(s, at, y, 3, colour[k]);
      if (k) svg_text(s, at, y - 7, 11, SVG_MIDDLE, "%.0f", v);
      if (!k && e == EDGES - 1) svg_text(s, at + 8, y + 4, 11, SVG_LEFT, "%.0f", v);
      if (!k) svg_text(s, at, 246, 11, SVG_MIDDLE, "%ux%u", (unsigned)edges[e], (unsigned)edges[e]);
      y0 = y;
    }
    svg_text(s, x + 10, 45 + 17 * k, 12, SVG_LEFT, "%s", ways[shown[k]].name);
    svg_line(s, x - 12, 41 + 17 * k, x + 4, 41 + 17 * k, colour[k], 2);
  }
}

int main(void) {
  static float pixels[2][SIZE * SIZE * 3];
  static cost got[WAYS][EDGES];
  scene room;
  svg s;
  pktrt_scene *library = pktrt_scene_create(NULL);
  if (!library || !scene_make("conference", &room)) return ex_fail("out of memory"), 1;
  if (scene_add(library, &room) || pktrt_commit(library)) return ex_fail("%s", pktrt_last_error(library)), 1;
  for (int e = 0; e < EDGES; e++)
    for (int w = 0; w < WAYS; w++) {
      float *mine = pixels[w + e > 0];
      got[w][e] = run(library, &room, edges[e], ways[w].steps, mine);
      if (memcmp(mine, pixels[0], sizeof pixels[0])) return ex_fail("%s: another picture", ways[w].name), 1;
    }
  printf("conference, Whitted's mode, %d x %d pixels, a quarter of the tiles: %d pictures, all the same bits\n", SIZE,
      SIZE, WAYS * EDGES);
  print_table("box tests per ray", got, 0);
  print_table("triangle tests per ray", got, 1);
  print_table("vector tests per ray", got, 2);
  course_make_folder();
  if (!draw_steps(got) || !svg_begin(&s, "out/course/06_figure6.svg", 720, 255)) return 1;
  draw_graph(&s, 30, "Triangle tests per ray", got, false);
  draw_graph(&s, 390, "Box tests per ray (same scale)", got, true);
  pktrt_scene_destroy(library);
  scene_free(&room);
  return !svg_end(&s);
}
