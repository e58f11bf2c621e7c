/* 08_figures.h - the figures and drawings of 08_reflect.c: the rays of a block from above, and counts by bounce. */
#ifndef REFLECT_FIGURES_H
#define REFLECT_FIGURES_H

#include "08_reflect.h"
#include "../svg.h"

enum { EDGE = 8, BLOCKS = REFLECT_SIZE / EDGE }; /* pixels along an edge of a block, blocks along one of the picture */

typedef struct block_cost { /* of the rays of one bounce that descend from a block */
  uint32_t rays, reflected, packets;
  double tests_per_ray; /* vector tests */
} block_cost;

/* The log's ray as the library takes rays. */
static pktrt_ray query_ray(const reflect_ray *r) { return pktrt_make_ray(r->origin, r->direction); }

/* The number of the block of 8 x 8 pixels from which the ray descends. */
static uint32_t block_of(const reflect_ray *r) { return r->y / EDGE * BLOCKS + r->x / EDGE; }

/* >>figures -------------------------------------------------------------------------------------------------------- */

/* [lanes] */
/* Box and triangle tests of single rays. */
static double tests(const pktrt_counts *c) { return (double)(c->box_tests + c->triangle_tests); }

/* Tests of vectors of eight lanes. */
static double vectors(const pktrt_counts *c) { return (double)(c->vector_box_tests + c->vector_triangle_tests); }

/* The mean number of lanes, of eight, in which a vector test had a ray to test. */
static double lanes(const pktrt_counts *c) { return tests(c) / vectors(c); }
/* [end] */

/* Prints the figure `name.depth.what`. */
static void figure_at(const char *name, uint32_t depth, const char *what, const char *format, double value) {
  char full_name[64];
  snprintf(full_name, sizeof full_name, "%s.%u.%s", name, (unsigned)depth, what);
  course_figure(full_name, format, value);
}

/* Prints the figures of one bounce of a block. */
static void print_block_figures(const char *name, uint32_t depth, block_cost cost) {
  figure_at(name, depth, "price", "%.1f", cost.tests_per_ray);
  figure_at(name, depth, "rays", "%.0f", cost.rays);
  figure_at(name, depth, "packets", "%.0f", cost.packets);
  figure_at(name, depth, "per-packet", "%.1f", (double)cost.rays / cost.packets);
  if (depth == 0) return;
  figure_at(name, depth, "reflected", "%.0f", cost.reflected);
  figure_at(name, depth, "refracted", "%.0f", cost.rays - cost.reflected);
}

/* Prints figures of a bounce: of single rays, and of packets of ray types. */
static void print_bounce_figures(const pktrt_counts *single, const pktrt_counts *packets, uint32_t depth) {
  const double rays = (double)packets->rays;
  figure_at("bounce", depth, "rays", "%.0f", rays);
  figure_at("bounce", depth, "alone", "%.1f", tests(single) / rays);
  figure_at("bounce", depth, "shared", "%.1f", tests(packets) / rays);
  figure_at("bounce", depth, "lanes", "%.1f", lanes(packets));
  figure_at("bounce", depth, "price", "%.1f", vectors(packets) / rays);
}

/* Splits the growth of vector tests per ray, from bounce `from` to the last one, into three factors: fewer lanes in use,
   rays that need more tests alone, and fewer tests that a packet spares. */
static void print_growth(const pktrt_counts *single, const pktrt_counts *packets, uint32_t from) {
  const pktrt_counts *packets_from = &packets[from];
  const pktrt_counts *packets_to = &packets[REFLECT_DEPTH];
  const double idle = lanes(packets_from) / lanes(packets_to);
  const double more_rays = (double)packets_to->rays / (double)packets_from->rays;
  const double alone = tests(&single[REFLECT_DEPTH]) / tests(&single[from]) / more_rays;
  const double all = vectors(packets_to) / vectors(packets_from) / more_rays;
  figure_at("growth", from, "all", "%.1f", all);
  figure_at("growth", from, "idle", "%.2f", idle);
  figure_at("growth", from, "alone", "%.2f", alone);
  figure_at("growth", from, "sharing", "%.2f", all / idle / alone);
}

/* Prints a table of what rays of each bounce need alone, in packets of ray types, and in packets of runs. */
static void print_bounces(const pktrt_stats *types, const pktrt_stats *runs, const pktrt_stats *single) {
  printf("by bounce: rays; tests per ray, alone and in packets of ray types;\n"
         "           lanes in use, of 8, and vector tests per ray, of ray types and of runs\n");
  for (int depth = 0; depth <= REFLECT_DEPTH; depth++) {
    const pktrt_counts *t = &types->by_depth[depth], *r = &runs->by_depth[depth], *o = &single->by_depth[depth];
    printf("  %d: %6u  %6.1f %6.1f  %5.1f %5.1f  %6.1f %6.1f\n", depth, (unsigned)t->rays, tests(o) / (double)o->rays,
        tests(t) / (double)t->rays, lanes(t), lanes(r), vectors(t) / (double)t->rays, vectors(r) / (double)r->rays);
  }
  for (uint32_t depth = 0; depth <= REFLECT_DEPTH; depth++)
    print_bounce_figures(&single->by_depth[depth], &types->by_depth[depth], depth);
  print_growth(single->by_depth, types->by_depth, 0);
  print_growth(single->by_depth, types->by_depth, 2);
}

/* >>drawings ------------------------------------------------------------------------------------------------------- */

static const char *const colours[] = {"#999", "#27b", "#e80", "#c22"};

/* Draws the rays that descend from a block of pixels, seen from above. */
static void draw_block(
    svg *g, const pktrt_scene *s, const reflect_log *log, uint32_t block, double left, const char *name) {
  const double scale = 45, x0 = left + 5.2 * scale, y0 = 36 + 5.2 * scale;
  const double right_wall = x0 + 5 * scale, left_wall = x0 - 5 * scale, back = y0 - 5 * scale, front = y0 + 9 * scale;
  svg_text(g, left + 8, 24, 17, SVG_LEFT, "%s", name);

  /* The walls; the right one is the mirror. Then the balls. */
  svg_line(g, right_wall, back, right_wall, front, "#444", 5);
  svg_line(g, left_wall, back, right_wall, back, "#b74", 5);
  svg_line(g, left_wall, back, left_wall, front, "#583", 5);
  for (int i = 0; i < 9; i++) {
    float c[3];
    reflect_ball(i, c);
    const bool glass = i == 1 || i == 3 || i == 8;
    svg_dot(g, x0 + scale * (double)c[0], y0 + scale * (double)c[2], scale * 0.9, glass ? "#def" : "#ddd");
  }

  /* The rays, those of late bounces first. */
  for (uint32_t depth = 4; depth-- > 0;)
    for (uint32_t i = 0; i < log->n; i++) {
      const reflect_ray *r = &log->ray[i];
      if (r->depth != depth || block_of(r) != block) continue;
      const pktrt_ray ray = query_ray(r);
      pktrt_hit hit;
      const float t = pktrt_intersect(s, &ray, &hit) ? hit.t : 1.5f; /* to the sky */
      const double x = x0 + scale * (double)r->origin[0], y = y0 + scale * (double)r->origin[2];
      svg_line(g, x, y, x + scale * (double)(t * r->direction[0]), y + scale * (double)(t * r->direction[2]),
          colours[depth], depth ? 1.0 : 0.6);
    }
}

/* Draws bars by bounce for ray types and runs: lanes in use, or vector tests per ray. */
static void draw_bars(svg *g, double left, const char *title, const pktrt_stats stats[2], bool of_lanes) {
  svg_text(g, left, 20, 13, SVG_LEFT, "%s", title);
  svg_line(g, left, 200, left + 330, 200, "#888", 1);
  if (of_lanes) {
    svg_line(g, left, 40, left + 330, 40, "#888", 1);
    svg_text(g, left + 336, 44, 11, SVG_LEFT, "8");
  }
  for (uint32_t depth = 0; depth <= REFLECT_DEPTH; depth++) {
    const double x = left + 6 + 36 * depth;
    svg_text(g, x + 14, 214, 11, SVG_MIDDLE, "%u", (unsigned)depth);
    for (int k = 0; k < 2; k++) {
      const pktrt_counts *c = &stats[k].by_depth[depth];
      const double value = of_lanes ? lanes(c) : vectors(c) / (double)c->rays;
      const double y = 200 - value * (of_lanes ? 20 : 2);
      svg_box(g, x + 14 * k, y, x + 14 * k + 13, 200, k ? "#e84" : "#47a", NULL);
      svg_text(g, x + 14 * k + 7, y - 3, 8, SVG_MIDDLE, of_lanes ? "%.1f" : "%.0f", value);
    }
  }
}

#endif
