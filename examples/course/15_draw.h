/* 15_draw.h - the pictures of chapter 15: what packets cost by their size, tests by bounce, and where in a picture packets
   gain. */
#ifndef COURSE_15_DRAW_H
#define COURSE_15_DRAW_H

#include "../svg.h"
#include "15_table.h"

/* >>bars ----------------------------------------------------------------------------------------------------------- */

/* Draws what a ray costs by the model, alone and in packets, as bars of three parts. */
EX_UNUSED static bool draw_parts(const char *path, table_row rows[TABLE_SCENES][TABLE_SIZES]) {
  enum { PARTS = 4 };
  static const char *const colour[PARTS] = {"#47a", "#e84", "#7a5", "#999"};
  svg drawing;
  if (!svg_begin(&drawing, path, 900, 520)) return false;
  svg_text(&drawing, 10, 24, 16, SVG_LEFT, "Cost per ray by the model, in vector tests of boxes");
  for (int part = 0; part < PARTS; part++) {
    static const char *const name[PARTS] = {
        "vectors of boxes", "vectors of triangles, 5 each", "nodes, 10 each", "rays, 10 each"};
    svg_box(&drawing, 20 + 225 * part, 38, 36 + 225 * part, 52, colour[part], NULL);
    svg_text(&drawing, 42 + 225 * part, 51, 14, SVG_LEFT, "%s", name[part]);
  }

  for (int k = 0; k < TABLE_SCENES; k++)
    for (int e = 0; e < TABLE_SIZES; e++) {
      const table_counts *counts = &rows[k][e].all;
      const double y = 72 + 150 * k + 26 * e, scale = 2.5 / (double)counts->rays;
      const double part[PARTS] = {table_model.box * (double)counts->box_vectors,
          table_model.triangle * (double)counts->triangle_vectors, table_model.node * (double)counts->nodes,
          table_model.ray * (double)counts->rays};
      double x = 160;
      if (e == 0) svg_text(&drawing, 10, y + 15, 15, SVG_LEFT, "%s", table_scene[k]);
      svg_text(&drawing, 152, y + 15, 14, SVG_RIGHT, e ? "%ux%u" : "alone", (unsigned)table_edge[e],
          (unsigned)table_edge[e]);
      for (int i = 0; i < PARTS; i++) {
        svg_box(&drawing, x, y, x + scale * part[i], y + 20, colour[i], NULL);
        x += scale * part[i];
      }
      const double alone = table_cost(&rows[k][0].all, &table_model), cost = table_cost(counts, &table_model);
      svg_text(&drawing, x + 8, y + 15, 14, SVG_LEFT, e ? "%.0f: %.1f times less" : "%.0f", cost / (double)counts->rays,
          alone / cost);
    }
  return svg_end(&drawing);
}

/* >>curves --------------------------------------------------------------------------------------------------------- */

/* Draws how many times fewer tests packets of 8 x 8 make than single rays, by bounce. */
EX_UNUSED static bool draw_bounces(const char *path, table_row rows[TABLE_SCENES][TABLE_SIZES]) {
  static const char *const colour[TABLE_SCENES] = {"#c33", "#06c", "#393"};
  svg drawing;
  if (!svg_begin(&drawing, path, 760, 360)) return false;
  svg_text(&drawing, 60, 24, 16, SVG_LEFT, "Times fewer tests in packets of 8 x 8 than alone, by bounce");

  for (int tick = 0; tick <= 6; tick++) {
    const double y = 310 - 80.0 * tick / 2;
    svg_line(&drawing, 60, y, 560, y, tick == 2 ? "#000" : "#ddd", 1);
    svg_text(&drawing, 52, y + 5, 14, SVG_RIGHT, "%.1f", tick / 2.0);
  }
  svg_line(&drawing, 60, 190, 560, 190, "#e80", 2);
  svg_text(&drawing, 568, 186, 14, SVG_LEFT, "the paper's 1.5, for all rays");
  svg_text(&drawing, 568, 235, 14, SVG_LEFT, "1: as many tests");

  for (int k = 0; k < TABLE_SCENES; k++) {
    double before = 0;
    svg_text(&drawing, 450, 60 + 22 * k, 15, SVG_LEFT, "%s", table_scene[k]);
    svg_line(&drawing, 415, 55 + 22 * k, 443, 55 + 22 * k, colour[k], 3);
    for (int bounce = 0; bounce < TABLE_BOUNCES; bounce++) {
      const table_counts *packets = &rows[k][3].bounce[bounce];
      if (packets->rays == 0) break;
      const double x = 80 + 65.0 * bounce, y = 310 - 80 * table_fewer(&rows[k][0].bounce[bounce], packets);
      if (bounce) svg_line(&drawing, x - 65, before, x, y, colour[k], 2);
      svg_dot(&drawing, x, y, 4, colour[k]);
      before = y;
      if (k == 1) svg_text(&drawing, x, 330, 14, SVG_MIDDLE, "%d", bounce);
    }
  }
  svg_text(&drawing, 80, 350, 14, SVG_LEFT, "bounces since the camera (a shadow ray has one more than its surface)");
  return svg_end(&drawing);
}

/* >>picture -------------------------------------------------------------------------------------------------------- */

enum { DRAW_SIZE = 160, DRAW_BLOCK = 8 };

/* Draws the conference room in four panels: the picture, and for each block of 8 x 8 pixels lanes in use, times fewer
   tests, and the speed-up by the model. Brighter is better; the scales end at 8, 1.5 and 8. */
EX_UNUSED static void draw_lanes(const char *path) {
  enum { BLOCKS = DRAW_SIZE / DRAW_BLOCK };
  static float pixels[DRAW_SIZE * DRAW_SIZE * 3];
  static pktrt_stats stats[2];
  course_picture all = course_picture_make(2 * DRAW_SIZE, 2 * DRAW_SIZE);
  table_world world = table_open(0);
  uint32_t better = 0;

  for (uint32_t block = 0; block < BLOCKS * BLOCKS; block++) {
    const uint32_t x = block % BLOCKS * DRAW_BLOCK, y = block / BLOCKS * DRAW_BLOCK;
    table_counts counts[2];
    for (int way = 0; way < 2; way++) {
      pktrt_render_desc desc = table_describe(&world, 0, way ? 8 : 1);
      memset(&stats[way], 0, sizeof stats[way]);
      memset(&counts[way], 0, sizeof counts[way]);
      desc.width = DRAW_SIZE;
      desc.height = DRAW_SIZE;
      desc.pixels = pixels;
      desc.stats = &stats[way];
      desc.packet_size = 8; /* of camera rays */
      table_render(&world, &desc, x, y, DRAW_BLOCK);
      for (int type = 0; type < TABLE_TYPES; type++) {
        const table_counts one = table_counts_of(&stats[way].by_type[type]);
        table_add(&counts[way], &one);
      }
    }

    const double fewer = table_fewer(&counts[0], &counts[1]);
    const vec colour[4] = {{{0, 0, 0}}, course_heat((float)(table_lanes(&counts[1]) / 8)),
        course_heat((float)(fewer / 1.5)),
        course_heat((float)(table_cost(&counts[0], &table_model) / table_cost(&counts[1], &table_model) / 8))};
    if (fewer > 1) better++;
    for (uint32_t i = 0; i < 4 * DRAW_BLOCK * DRAW_BLOCK; i++) {
      const uint32_t panel = i / (DRAW_BLOCK * DRAW_BLOCK), px = x + i % DRAW_BLOCK,
                     py = y + i / DRAW_BLOCK % DRAW_BLOCK;
      vec *to = &all.pixel[(py + panel / 2 * DRAW_SIZE) * all.width + px + panel % 2 * DRAW_SIZE];
      *to = colour[panel];
      for (int c = 0; c < 3 && panel == 0; c++) { /* few shades make a small file */
        const float shade = floorf(15 * sqrtf(fminf(pixels[3 * (py * DRAW_SIZE + px) + (uint32_t)c], 1)) + 0.5f) / 15;
        to->at[c] = shade * shade;
      }
    }
  }

  course_figure("blocks", "%d", BLOCKS * BLOCKS);
  course_figure("blocks.fewer", "%u", (unsigned)better);
  course_picture_write_double(&all, path);
  table_close(&world);
}

#endif /* COURSE_15_DRAW_H */
