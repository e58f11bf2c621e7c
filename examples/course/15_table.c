/* Chapter 15: table 1 in counts. Makes out/course/15_parts.svg, what packets cost by their size; 15_bounces.svg, tests by
   bounce; 15_lanes.png, where in a picture packets gain. Prints counts, predicted speed-ups beside measured ones, the way
   from the paper's packets to the library's, and tables 2 and 3 in counts.

   cc -O2 examples/course/15_table.c -o table -lm && ./table

   With the argument "times" it measures, and prints the file of results that it reads without. */
#define PKTRT_IMPLEMENTATION
#include "15_draw.h"
#include "15_figures.h"
#include "15_modes.h"
#include "15_times.h"
#include "15_walk.h"

/* [predict] */
/* Returns how many times as fast packets are by a model. Camera rays are in packets either way, as in table 1. */
static double predict(const table_row *alone, const table_row *packets, const table_weights *model) {
  double single = table_cost(&packets->type[PKTRT_RAY_PRIMARY], model);
  double together = single;

  for (int type = 1; type < TABLE_TYPES; type++) {
    single += table_cost(&alone->type[type], model);
    together += table_cost(&packets->type[type], model);
  }
  return single / together;
}
/* [end] */

/* Prints speed-ups: the paper's, measured ones, and those predicted by vectors alone and by the model. */
static void print_speedups(table_row rows[TABLE_SCENES][TABLE_SIZES]) {
  static const table_weights vectors_alone = {1, 1, 0, 0};
  static times measured[TABLE_SCENES];
  double worst[2] = {1, 1};
  times_read(measured);
  printf("speed-ups: the paper's; measured; predicted by vectors, by the model\n");

  for (int k = 0; k < TABLE_SCENES; k++)
    for (int e = 1; e < TABLE_SIZES; e++) {
      const double ours = measured[k].single[e] / measured[k].packets[e];
      const double by_vectors = predict(&rows[k][0], &rows[k][e], &vectors_alone);
      const double by_model = predict(&rows[k][0], &rows[k][e], &table_model);
      char key[64];
      worst[0] = fmax(worst[0], fmax(ours / by_vectors, by_vectors / ours));
      worst[1] = fmax(worst[1], fmax(ours / by_model, by_model / ours));
      printf("  %-10s %2ux%-2u  %.2f   %.2f   %.2f   %.2f\n", table_scene[k], (unsigned)table_edge[e],
          (unsigned)table_edge[e], times_paper[k][e], ours, by_vectors, by_model);
      snprintf(key, sizeof key, "speed.%s.%u", table_scene[k], (unsigned)table_edge[e]);
      figures_print(key, "paper", 2, times_paper[k][e]);
      figures_print(key, "measured", 2, ours);
      figures_print(key, "vectors", 2, by_vectors);
      figures_print(key, "model", 2, by_model);
    }
  printf("\n");
  course_figure("worst.vectors", "%.2f", worst[0]);
  course_figure("worst.model", "%.2f", worst[1]);
}

/* [ways] */
/* From the paper's packets to the library's: each way has one change more than the way before. */
enum { WAYS = 6 };
static const walk_way way[WAYS] = {
    {"paper", 4, false, false, false, false},
    {"lanes", 8, false, false, false, false},
    {"morton", 8, true, false, false, false},
    {"trim", 8, true, true, false, false},
    {"eight", 8, true, true, false, true},
    {"leaf-boxes", 8, true, true, true, true},
};
/* [end] */

/* Prints a row of the way from the paper's packets to the library's: alone, in packets of 2 x 2 and of 8 x 8. */
static void print_way(const char *title, const char *name, const table_counts counts[3]) {
  const double nodes = (double)counts[1].nodes / (double)counts[2].nodes;
  const double vectors = table_vectors(&counts[1]) / table_vectors(&counts[2]);
  const double all = table_vectors(&counts[0]) / table_vectors(&counts[2]);
  const double rays = (double)counts[0].rays;
  char key[64];
  printf("  %-10s  %5.1f %5.1f   %4.2f %4.2f %4.2f   %4.2f %4.2f\n", name, table_tests(&counts[0]) / rays,
      table_tests(&counts[2]) / rays, table_lanes(&counts[2]), table_fewer(&counts[0], &counts[2]), all, vectors,
      nodes);
  snprintf(key, sizeof key, "way.%s.%s", title, name);
  figures_print(key, "alone", 1, table_tests(&counts[0]) / rays);
  figures_print(key, "tests", 1, table_tests(&counts[2]) / rays);
  figures_print(key, "triangles", 1, (double)counts[2].triangles / rays);
  figures_print(key, "lanes", 2, table_lanes(&counts[2]));
  figures_print(key, "fewer", 2, table_fewer(&counts[0], &counts[2]));
  figures_print(key, "product", 2, all);
  figures_print(key, "over", 2, vectors);
  figures_print(key, "nodes", 2, nodes);
}

/* Walks the rays of smaller tiles in all ways, and compares the last way with the library. */
static void print_ways(const table_world *world) {
  enum { TILE = 16 };
  const char *title = table_scene[world->number];
  walk_rays rays[2];
  walk_tree wide = walk_wide(world), binary = walk_binary(&wide);
  static pktrt_stats stats;
  table_counts counts[3], theirs;
  memset(rays, 0, sizeof rays);
  memset(&stats, 0, sizeof stats);
  memset(&theirs, 0, sizeof theirs);

  for (int size = 0; size < 2; size++)
    for (int frame = 0; frame < TABLE_FRAMES; frame++) {
      uint32_t x, y;
      pktrt_render_desc desc = table_describe(world, frame, size ? 8 : 2);
      table_tile(frame, &x, &y);
      desc.stats = size ? &stats : NULL;
      desc.packet = walk_record;
      desc.user = &rays[size];
      table_render(world, &desc, x, y, TILE);
    }

  printf("%s, from the paper's packets to the library's: tests per ray alone, in 8x8; lanes, fewer, product;\n"
         "           vectors and nodes of 2x2 over those of 8x8\n",
      title);
  for (int i = 0; i < WAYS; i++) {
    const walk_tree *tree = way[i].eight ? &wide : &binary;
    for (int k = 0; k < 3; k++) counts[k] = walk_all(tree, &way[i], &rays[k == 2], k == 0);
    print_way(title, way[i].name, counts);
  }
  for (int type = 0; type < TABLE_TYPES; type++) {
    const table_counts one = table_counts_of(&stats.by_type[type]);
    table_add(&theirs, &one);
  }
  const double ours = table_vectors(&counts[2]) / (double)counts[2].rays;
  const double library = table_vectors(&theirs) / (double)theirs.rays;
  printf("  the last in vectors per ray: %.2f, the library's %.2f\n\n", ours, library);
  figures_print(title, "walk.vectors", 2, ours);
  figures_print(title, "walk.library", 2, library);
  walk_free(&wide, &binary);
  for (int size = 0; size < 2; size++) walk_rays_free(&rays[size]);
}

/* Makes all pictures and prints all figures. */
int main(int argc, char **argv) {
  static table_row rows[TABLE_SCENES][TABLE_SIZES];
  if (argc > 1 && !strcmp(argv[1], "times")) {
    times_measure(argc, argv);
    return 0;
  }

  course_make_folder();
  for (int k = 0; k < TABLE_SCENES; k++) {
    table_world world = table_open(k);
    for (int e = 0; e < TABLE_SIZES; e++) rows[k][e] = table_count(&world, table_edge[e]);
    figures_scene(table_scene[k], rows[k]);
    print_ways(&world);
    modes_print(&world);
    table_close(&world);
  }
  print_speedups(rows);
  if (!draw_parts("out/course/15_parts.svg", rows) || !draw_bounces("out/course/15_bounces.svg", rows)) return 1;
  draw_lanes("out/course/15_lanes.png");
  return 0;
}
