/* 15_times.h - speed-ups of packets: the paper's, and ours from the file of results; how that file is made. */
#ifndef COURSE_15_TIMES_H
#define COURSE_15_TIMES_H

#include "15_table.h"
#include "../../bench/provenance.h"

#define TIMES_FILE "bench/results/course_table.csv"

/* Table 1 of the paper: how many times as fast packets are as single rays. */
static const double times_paper[TABLE_SCENES][TABLE_SIZES] = {
    {0, 2.02, 2.65, 2.85, 2.53}, {0, 1.82, 2.37, 2.69, 2.65}, {0, 1.89, 2.60, 2.97, 2.96}};

/* Seconds of a scene, by packet size: with single rays but for the camera's, which are in packets; and in packets. */
typedef struct times {
  double single[TABLE_SIZES], packets[TABLE_SIZES];
} times;

/* Reads the file of results, and prints which version and machine it is of. */
EX_UNUSED static void times_read(times all[TABLE_SCENES]) {
  char line[256], scene_name[32], assembly[32];
  unsigned edge;
  double seconds;
  FILE *file = fopen(TIMES_FILE, "r");
  memset(all, 0, TABLE_SCENES * sizeof *all);
  if (!file || !fgets(line, sizeof line, file)) {
    ex_fail("%s: cannot be read", TIMES_FILE);
    exit(1);
  }
  printf("times of %s: %s", TIMES_FILE, line + 2);

  while (fgets(line, sizeof line, file)) {
    if (sscanf(line, "%31[^,],%u,%31[^,],%lf", scene_name, &edge, assembly, &seconds) != 4) continue;
    for (int k = 0; k < TABLE_SCENES; k++)
      for (int e = 1; e < TABLE_SIZES; e++)
        if (!strcmp(scene_name, table_scene[k]) && edge == table_edge[e])
          *(strcmp(assembly, "single") ? &all[k].packets[e] : &all[k].single[e]) = seconds;
  }
  fclose(file);
  for (int k = 0; k < TABLE_SCENES; k++)
    for (int e = 1; e < TABLE_SIZES; e++)
      if (!(all[k].packets[e] > 0 && all[k].single[e] > 0)) {
        ex_fail("%s: a time is missing", TIMES_FILE);
        exit(1);
      }
}

/* Returns the processor's seconds for the tiles of a scene with so many pixels along an edge. */
static double times_tiles(const table_world *world, uint32_t edge, bool single, uint32_t pixels) {
  enum { REPEATED = 2 };
  const clock_t begin = clock();
  for (int frame = 0; frame < REPEATED * TABLE_FRAMES; frame++) {
    uint32_t x, y;
    pktrt_render_desc desc = table_describe(world, frame % TABLE_FRAMES, edge);
    if (single) desc.assembly = PKTRT_ASSEMBLY_NONE;
    table_tile(frame % TABLE_FRAMES, &x, &y);
    table_render(world, &desc, x, y, pixels);
  }
  return (double)(clock() - begin) / CLOCKS_PER_SEC / REPEATED;
}

/* Returns the seconds without those for the beginning of a render, which takes milliseconds where lights are meshes. */
static double times_one(const table_world *world, uint32_t edge, bool single) {
  return times_tiles(world, edge, single, TABLE_TILE) - times_tiles(world, edge, single, 1);
}

static int times_compare(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return x < y ? -1 : x > y;
}

/* Measures, and prints the file of results: medians of rounds in which all ways take turns. */
EX_UNUSED static void times_measure(int argc, char **argv) {
  enum { ROUNDS = 7, WAYS = 2 * (TABLE_SIZES - 1) };
  char command[256];
  join_command(command, sizeof command, argc, argv);
  write_provenance(stdout, command);
  printf("scene,packet,assembly,seconds\n");
  for (int k = 0; k < TABLE_SCENES; k++) {
    static double seconds[WAYS][ROUNDS];
    table_world world = table_open(k);
    for (int round = 0; round < ROUNDS; round++)
      for (int way = 0; way < WAYS; way++)
        seconds[way][round] = times_one(&world, table_edge[1 + way / 2], way % 2 == 0);
    for (int way = 0; way < WAYS; way++) {
      qsort(seconds[way], ROUNDS, sizeof seconds[way][0], times_compare);
      printf("%s,%u,%s,%.6f\n", table_scene[k], (unsigned)table_edge[1 + way / 2], way % 2 ? "ray types" : "single",
          seconds[way][ROUNDS / 2]);
    }
    table_close(&world);
  }
}

#endif /* COURSE_15_TIMES_H */
