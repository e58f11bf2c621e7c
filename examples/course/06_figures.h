/* 06_figures.h - the sets of steps that 06_ablate.c tries, and its tables and drawings. */
#ifndef ABLATE_FIGURES_H
#define ABLATE_FIGURES_H

#include "06_ablate.h"
#include "../svg.h"

enum { WIDTH = 256, TILE = 16, WAYS = 9, EDGES = 4 };
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

/* Returns all vector tests per ray. */
static double vectors(const cost *c) { return c->box_vectors + c->triangle_vectors; }

/* Returns one of the costs: box tests (0), triangle tests (1) or vector tests (2). */
static double cost_of_kind(const cost *c, int kind) {
  if (kind == 0) return c->boxes;
  return kind == 1 ? c->triangles : vectors(c);
}

/* Prints a table of one cost by set of steps and packet size, then each entry as the figure `name.set.size`. */
static void print_table(const char *title, const char *name, cost got[WAYS][EDGES], int kind) {
  static const char *const short_names[WAYS] = {
      "all", "no-group", "no-intervals", "no-frustum", "no-trim", "no-leaf-boxes", "no-order", "2007", "none"};
  printf("\n%-24s    2x2    4x4    8x8  16x16\n", title);
  for (int w = 0; w < WAYS; w++) {
    printf("%-24s", ways[w].name);
    for (int e = 0; e < EDGES; e++) printf(" %6.1f", cost_of_kind(&got[w][e], kind));
    printf("\n");
  }
  for (int w = 0; w < WAYS; w++)
    for (int e = 0; e < EDGES; e++) {
      char figure[64];
      snprintf(figure, sizeof figure, "%s.%s.%u", name, short_names[w], (unsigned)edges[e]);
      course_figure(figure, "%.1f", cost_of_kind(&got[w][e], kind));
    }
}

/* Draws a bar for each set of steps and packet size: vector tests of boxes, then of triangles. */
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

/* Draws one half of figure 6: tests per ray over the packet size, with all steps and with those of the paper. */
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

#endif
