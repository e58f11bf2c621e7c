/* 12_drawing.h - the drawing of chapter 12: points of the square, and their images on the disk and in a lobe. */
#ifndef DRAWING_H
#define DRAWING_H

#include "course.h"
#include "../svg.h"
#include "12_mapping.h"

/* Sizes of a panel in pixels: those of the upper row, and all others. */
enum { DRAWING_GRID = 16, DRAWING_POINTS = DRAWING_GRID * DRAWING_GRID, DRAWING_SIDE = 170, DRAWING_WIDE = 220 };

/* The points of a panel: `at` in pixels, `colour` 0 to 3. */
typedef struct drawing_points {
  double at[DRAWING_POINTS][2];
  int colour[DRAWING_POINTS];
  uint32_t count;
} drawing_points;

/* Draws points, colour by colour. */
static void drawing_dots(svg *s, const drawing_points *points) {
  static const char *const colours[4] = {"#27c", "#d70", "#393", "#c2a"};

  for (int colour = 0; colour < 4; colour++) {
    uint32_t first = 0;
    while (first < points->count && points->colour[first] != colour) first++;
    if (first == points->count) continue;

    fprintf(s->file, "<path stroke=\"%s\" stroke-width=\"4.5\" stroke-linecap=\"round\" d=\"", colours[colour]);
    for (uint32_t i = first; i < points->count; i++)
      if (points->colour[i] == colour) fprintf(s->file, "M%.1f %.1fh0", points->at[i][0], points->at[i][1]);
    fprintf(s->file, "\"/>\n");
  }
}

/* Sets u to the centre of a cell, and returns a colour that adjacent packets of 4 x 4 cells do not share. */
static int drawing_sample(uint32_t i, float u[2]) {
  const uint32_t column = i % DRAWING_GRID;
  const uint32_t row = i / DRAWING_GRID;
  mapping_centre(column, row, DRAWING_GRID, u);
  return (int)(column / 4 % 2 + row / 4 % 2 * 2);
}

/* Draws 64 points of a sampler over a grid of 8 x 8 cells: of one pixel; or, if interleaved, four points of each pixel of
   a tile of 4 x 4 pixels, those of one column of pixels in one colour. */
static void drawing_square(svg *s, double x, double y, pktrt_sampler sampler, const char *title) {
  const bool interleaved = sampler == PKTRT_SAMPLER_INTERLEAVED;
  const pktrt_sampling sampling = {sampler, interleaved ? 4 : 64, 1};
  drawing_points points;

  svg_text(s, x, y - 6, 13, SVG_LEFT, "%s", title);
  for (int i = 0; i <= 8; i++) {
    const double at = DRAWING_SIDE * i / 8.0;
    svg_line(s, x + at, y, x + at, y + DRAWING_SIDE, "#ddd", 1);
    svg_line(s, x, y + at, x + DRAWING_SIDE, y + at, "#ddd", 1);
  }

  points.count = 64;
  for (uint32_t i = 0; i < points.count; i++) {
    const uint32_t pixel = interleaved ? i / 4 : 0;
    float u[2];
    pktrt_sample(&sampling, pixel % 4, pixel / 4, interleaved ? i % 4 : i, 0, 2, u);
    points.at[i][0] = x + DRAWING_SIDE * (double)u[0];
    points.at[i][1] = y + DRAWING_SIDE * (1 - (double)u[1]);
    points.colour[i] = (int)(pixel % 4);
  }
  drawing_dots(s, &points);
}

/* Draws the images of the grid's centres on a disk; mapping NULL: the grid itself. */
static void drawing_disk(
    svg *s, double x, double y, void (*mapping)(const float u[2], float out[2]), const char *title) {
  const double radius = DRAWING_WIDE / 2.0;
  drawing_points points;

  svg_text(s, x, y - 6, 13, SVG_LEFT, "%s", title);
  if (mapping) {
    fprintf(s->file, "<circle cx=\"%g\" cy=\"%g\" r=\"%g\" fill=\"none\" stroke=\"#888\"/>\n", x + radius, y + radius,
        radius);
  } else {
    svg_box(s, x, y, x + 2 * radius, y + 2 * radius, NULL, "#888");
  }

  points.count = DRAWING_POINTS;
  for (uint32_t i = 0; i < points.count; i++) {
    float u[2];
    points.colour[i] = drawing_sample(i, u);
    float p[2] = {2 * u[0] - 1, 2 * u[1] - 1};
    if (mapping) mapping(u, p);
    points.at[i][0] = x + radius * (1 + (double)p[0]);
    points.at[i][1] = y + radius * (1 - (double)p[1]);
  }
  drawing_dots(s, &points);
}

/* Draws the images of the grid's centres in a lobe of exponent 10, whose axis is 70 degrees off the normal, as seen along
   the axis. The curve is the horizon; directions below the curve are below the surface. */
static void drawing_lobe(svg *s, double x, double y, lobe_mapping *mapping, const char *title) {
  const double scale = DRAWING_WIDE / 1.5;
  const double middle_x = x + DRAWING_WIDE / 2.0;
  const double middle_y = y + DRAWING_WIDE / 2.0;
  drawing_points points;
  float axis[3], normal[3], side[3], up[3];

  mapping_slanted(70, axis, normal);
  mapping_frame(axis, normal, side, up);
  svg_text(s, x, y - 6, 13, SVG_LEFT, "%s", title);
  svg_line(s, middle_x - 6, middle_y, middle_x + 6, middle_y, "#000", 2);
  svg_line(s, middle_x, middle_y - 6, middle_x, middle_y + 6, "#000", 2);

  /* A horizontal direction is x along `side` and -cos(axis, normal) sqrt(1 - x^2) along `up`. */
  for (int i = -12; i < 12; i++) {
    const double from = 0.06 * i;
    const double to = 0.06 * (i + 1);
    const double slope = scale * mapping_dot(axis, normal);
    svg_line(s, middle_x + scale * from, middle_y + slope * sqrt(1 - from * from), middle_x + scale * to,
        middle_y + slope * sqrt(1 - to * to), "#000", 1);
  }

  points.count = DRAWING_POINTS;
  for (uint32_t i = 0; i < points.count; i++) {
    float u[2], out[3];
    points.colour[i] = drawing_sample(i, u);
    mapping(u, axis, normal, 10, out);
    points.at[i][0] = middle_x + scale * mapping_dot(out, side);
    points.at[i][1] = middle_y - scale * mapping_dot(out, up);
  }
  drawing_dots(s, &points);
}

/* Makes the drawing; the program ends if the file cannot be written. */
static void drawing_make(const char *path) {
  svg s;
  if (!svg_begin(&s, path, 760, 750)) exit(1);

  drawing_square(&s, 10, 26, PKTRT_SAMPLER_RANDOM, "random");
  drawing_square(&s, 200, 26, PKTRT_SAMPLER_JITTERED, "jittered");
  drawing_square(&s, 390, 26, PKTRT_SAMPLER_SOBOL, "Sobol'");
  drawing_square(&s, 580, 26, PKTRT_SAMPLER_INTERLEAVED, "interleaved, 4 x 4 pixels");

  drawing_disk(&s, 10, 240, NULL, "grid, packets of 4 x 4");
  drawing_disk(&s, 265, 240, disk_polar, "disk, polar");
  drawing_disk(&s, 520, 240, pktrt_map_disk, "disk, concentric");

  drawing_lobe(&s, 10, 510, lobe_thrown_away, "lobe, thrown away");
  drawing_lobe(&s, 265, 510, lobe_retried, "lobe, retried");
  drawing_lobe(&s, 520, 510, lobe_folded, "lobe, folded");

  if (!svg_end(&s)) exit(1);
}

#endif
