/* 15_modes.h - tables 2 and 3 of the paper in counts: ray casting, Whitted's mode and distribution ray tracing, and packets
   of a pixel's samples. */
#ifndef COURSE_15_MODES_H
#define COURSE_15_MODES_H

#include "15_figures.h"

/* A tile has 16 x 16 samples. Of a frame so many tiles are made. */
enum { MODES = 3, MODES_EDGE = 16, MODES_TILES = 48, MODES_TILES_SAMPLES = 16 };

static const char *const modes_name[MODES] = {"RCS", "WRT", "DRT"};

/* Table 2 of the paper: millions of rays per second. */
static const double modes_paper[TABLE_SCENES][MODES] = {{3.25, 1.79, 0.88}, {3.30, 2.00, 1.53}, {2.83, 0.83, 1.23}};

/* Table 3: how many times as fast packets are as single rays, with 4, 16 and 64 samples per pixel. */
static const double modes_paper_samples[3] = {1.86, 2.00, 3.03};

/* The part of the animation's loop for which a shutter is open: one frame of 240. */
static const double modes_shutter = 1.0 / 240;

/* Stores where a tile begins: at points of the R2 sequence, which covers the picture evenly. */
static void modes_place(int tile, uint32_t *x, uint32_t *y) {
  const double u = (tile + 0.5) * 0.7548776662466927, v = (tile + 0.5) * 0.5698402909980532;
  *x = (uint32_t)((u - floor(u)) * (TABLE_PIXELS / MODES_EDGE)) * MODES_EDGE;
  *y = (uint32_t)((v - floor(v)) * (TABLE_PIXELS / MODES_EDGE)) * MODES_EDGE;
}

/* Counts one frame: tiles of as many samples in each mode, of `root` x `root` samples per pixel. `edge`: of packets. */
static table_counts modes_count(
    const table_world *world, int tiles, pktrt_mode mode, uint32_t root, uint32_t edge, pktrt_assembly assembly) {
  static pktrt_stats stats;
  table_counts all;
  pktrt_render_desc desc = table_describe(world, 0, edge);
  memset(&stats, 0, sizeof stats);
  memset(&all, 0, sizeof all);
  desc.mode = mode;
  desc.samples = root * root;
  desc.assembly = assembly; /* NONE: single rays, but for the camera's */
  desc.max_depth = PKTRT_MAX_DEPTH;
  desc.attenuation = 0; /* the library's: ray trees are pruned */
  desc.camera.shutter = mode == PKTRT_MODE_DRT ? 1 : 0;
  desc.stats = &stats;

  for (int tile = 0; tile < tiles; tile++) {
    uint32_t x, y;
    modes_place(tile, &x, &y);
    table_render(world, &desc, x, y, MODES_EDGE / root);
  }
  for (int type = 0; type < TABLE_TYPES; type++) {
    const table_counts one = table_counts_of(&stats.by_type[type]);
    table_add(&all, &one);
  }
  return all;
}

/* Prints table 3: more samples, the samples of a pixel in a packet, and beside them packets of 8 x 8 for all. */
static void modes_print_samples(const table_world *moving) {
  printf("table 3: samples; vectors per ray alone, in packets of a pixel, their ratio, the paper's; lanes in use;\n"
         "         vectors per ray in packets of 8x8\n");

  for (int i = 0; i < 3; i++) {
    const uint32_t root = table_edge[i + 1];
    const int tiles = MODES_TILES_SAMPLES;
    const table_counts alone = modes_count(moving, tiles, PKTRT_MODE_DRT, root, root, PKTRT_ASSEMBLY_NONE);
    const table_counts pixel = modes_count(moving, tiles, PKTRT_MODE_DRT, root, root, PKTRT_ASSEMBLY_RAY_TYPES);
    const table_counts large = modes_count(moving, tiles, PKTRT_MODE_DRT, root, 8, PKTRT_ASSEMBLY_RAY_TYPES);
    const double rays = (double)pixel.rays;
    const double fewer = table_vectors(&alone) / table_vectors(&pixel);
    char key[64];
    printf("  %2u  %6.1f %5.1f  %4.2f  %4.2f   %3.1f  %5.1f\n", (unsigned)(root * root), table_vectors(&alone) / rays,
        table_vectors(&pixel) / rays, fewer, modes_paper_samples[i], table_lanes(&pixel), table_vectors(&large) / rays);
    snprintf(key, sizeof key, "samples.%u", (unsigned)(root * root));
    figures_print(key, "alone", 1, table_vectors(&alone) / rays);
    figures_print(key, "pixel", 1, table_vectors(&pixel) / rays);
    figures_print(key, "fewer", 2, fewer);
    figures_print(key, "paper", 2, modes_paper_samples[i]);
    figures_print(key, "lanes", 1, table_lanes(&pixel));
    figures_print(key, "large", 1, table_vectors(&large) / rays);
  }
  printf("\n");
}

/* Prints a scene's rows of table 2, in packets of 8 x 8; distribution ray tracing has 16 samples per pixel. Then table 3,
   which is of the conference room. `still`: the scene in which nothing moves. */
EX_UNUSED static void modes_print(const table_world *still) {
  const char *title = table_scene[still->number];
  table_world moving = table_open_moving(still->number, modes_shutter);
  printf("%s, table 2: rays per sample; tests and vectors per ray, lanes in use; the paper's million rays per second\n",
      title);

  for (int mode = 0; mode < MODES; mode++) {
    const bool distribution = mode == PKTRT_MODE_DRT;
    const table_counts counts = modes_count(distribution ? &moving : still, MODES_TILES, (pktrt_mode)mode,
        distribution ? 4 : 1, 8, PKTRT_ASSEMBLY_RAY_TYPES);
    const double rays = (double)counts.rays;
    const double samples = (double)MODES_TILES * MODES_EDGE * MODES_EDGE;
    const double paper = modes_paper[still->number][mode];
    char key[64];
    printf("  %s  %4.1f   %5.1f  %4.1f  %3.1f   %4.2f\n", modes_name[mode], rays / samples, table_tests(&counts) / rays,
        table_vectors(&counts) / rays, table_lanes(&counts), paper);
    snprintf(key, sizeof key, "modes.%s.%s", title, modes_name[mode]);
    figures_print(key, "rays", 1, rays / samples);
    figures_print(key, "tests", 1, table_tests(&counts) / rays);
    figures_print(key, "vectors", 1, table_vectors(&counts) / rays);
    figures_print(key, "lanes", 1, table_lanes(&counts));
    figures_print(key, "paper", 2, paper);
  }
  printf("\n");

  if (still->number == 0) modes_print_samples(&moving);
  table_close(&moving);
}

#endif /* COURSE_15_MODES_H */
