/* 15_figures.h - the tables and figures that 15_table.c prints. */
#ifndef COURSE_15_FIGURES_H
#define COURSE_15_FIGURES_H

#include "15_table.h"

static const char *const figures_kind[TABLE_TYPES] = {"camera", "shadow", "reflection", "refraction"};

/* Prints a figure whose name has two parts. */
EX_UNUSED static void figures_print(const char *key, const char *name, int digits, double value) {
  char full[96];
  snprintf(full, sizeof full, "%s.%s", key, name);
  course_figure(full, "%.*f", digits, value);
}

/* Prints what rays take alone and in packets. */
static void figures_line(const char *name, const table_counts *alone, const table_counts *packets) {
  const double rays = (double)packets->rays;
  if (packets->rays == 0) return;
  printf("  %-11s %6.0f  %5.1f %5.1f   %3.1f  %4.2f  %5.2f  %6.1f %5.1f\n", name, rays, table_tests(alone) / rays,
      table_tests(packets) / rays, table_lanes(packets), table_fewer(alone, packets),
      table_vectors(alone) / table_vectors(packets), (double)alone->nodes / rays,
      (double)packets->nodes / (double)packets->packets);
}

/* The same as figures. */
static void figures_of(const char *key, const table_counts *alone, const table_counts *packets) {
  const double rays = (double)packets->rays;
  if (packets->rays == 0) return;
  figures_print(key, "rays", 0, rays);
  figures_print(key, "alone", 1, table_tests(alone) / rays);
  figures_print(key, "tests", 1, table_tests(packets) / rays);
  figures_print(key, "lanes", 1, table_lanes(packets));
  figures_print(key, "fewer", 2, table_fewer(alone, packets));
  figures_print(key, "vectors", 1, table_vectors(packets) / rays);
  figures_print(key, "product", 2, table_vectors(alone) / table_vectors(packets));
  figures_print(key, "nodes.alone", 1, (double)alone->nodes / rays);
  figures_print(key, "nodes.ray", 2, (double)packets->nodes / rays);
  figures_print(key, "nodes.packet", 1, (double)packets->nodes / (double)packets->packets);
  figures_print(key, "packet.rays", 1, rays / (double)packets->packets);
}

/* Prints a scene's table by packet size, by kind of ray and by bounce, then all as figures. */
EX_UNUSED static void figures_scene(const char *title, const table_row rows[TABLE_SIZES]) {
  const table_row *alone = &rows[0], *packets = &rows[3];
  char key[64], name[16];

  printf("%s: rays; tests per ray alone, in packets; lanes in use, times fewer tests, their product;\n"
         "           nodes per ray alone, per packet\n",
      title);
  for (int e = 1; e < TABLE_SIZES; e++) {
    snprintf(name, sizeof name, "%ux%u", (unsigned)table_edge[e], (unsigned)table_edge[e]);
    figures_line(name, &alone->all, &rows[e].all);
  }
  printf(
      "\n%s by kind of ray, 8x8: rays; tests alone, in packets; lanes, fewer tests, product; nodes alone, per packet\n",
      title);
  for (int type = 0; type < TABLE_TYPES; type++)
    figures_line(figures_kind[type], &alone->type[type], &packets->type[type]);
  printf("\n%s by bounce, 8x8: the same\n", title);
  for (int bounce = 0; bounce < TABLE_BOUNCES; bounce++) {
    snprintf(name, sizeof name, "%d", bounce);
    figures_line(name, &alone->bounce[bounce], &packets->bounce[bounce]);
  }
  printf("\n");

  for (int e = 1; e < TABLE_SIZES; e++) {
    snprintf(key, sizeof key, "%s.%u", title, (unsigned)table_edge[e]);
    figures_of(key, &alone->all, &rows[e].all);
  }
  for (int type = 0; type < TABLE_TYPES; type++) {
    snprintf(key, sizeof key, "%s.%s", title, figures_kind[type]);
    figures_of(key, &alone->type[type], &packets->type[type]);
  }
  for (int bounce = 0; bounce < TABLE_BOUNCES; bounce++) {
    snprintf(key, sizeof key, "%s.bounce.%d", title, bounce);
    figures_of(key, &alone->bounce[bounce], &packets->bounce[bounce]);
  }
  const double rays = (double)packets->all.rays;
  snprintf(key, sizeof key, "%s.share", title);
  for (int type = 0; type < TABLE_TYPES; type++)
    figures_print(key, figures_kind[type], 0, 100 * (double)packets->type[type].rays / rays);
  figures_print(key, "deep", 0, 100 * (1 - (double)(packets->bounce[0].rays + packets->bounce[1].rays) / rays));
}

#endif /* COURSE_15_FIGURES_H */
