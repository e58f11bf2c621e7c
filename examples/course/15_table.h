/* 15_table.h - what program, exercise and check of chapter 15 share: the pictures of table 1, their counts, and a cost
   model. */
#ifndef COURSE_15_TABLE_H
#define COURSE_15_TABLE_H

#include "course.h"
#include "../scenes.h"

enum { TABLE_SCENES = 3, TABLE_SIZES = 5, TABLE_TYPES = 4 };

static const char *const table_scene[TABLE_SCENES] = {"conference", "rtrt", "poolhall"};

/* Rays along a packet's edge. Size 0 stands for rays that are traced alone. */
static const uint32_t table_edge[TABLE_SIZES] = {1, 2, 4, 8, 16};

/* >>cost ----------------------------------------------------------------------------------------------------------- */

/* [cost] */
/* What packets did. Vectors have eight lanes; a lane is one ray against one box or triangle. */
typedef struct table_counts {
  uint64_t rays, packets;
  uint64_t nodes;                         /* opened */
  uint64_t box_vectors, triangle_vectors; /* tests of eight lanes at once, busy or idle */
  uint64_t boxes, triangles;              /* tests by lanes in use */
} table_counts;

/* The model: what an operation costs, in vector tests of boxes. */
typedef struct table_weights {
  double box, triangle, node, ray;
} table_weights;

static const table_weights table_model = {1, 5, 10, 10};

EX_UNUSED static double table_cost(const table_counts *counts, const table_weights *weights) {
  const double boxes = weights->box * (double)counts->box_vectors;
  const double triangles = weights->triangle * (double)counts->triangle_vectors;
  return boxes + triangles + weights->node * (double)counts->nodes + weights->ray * (double)counts->rays;
}
/* [end] */

EX_UNUSED static void table_add(table_counts *sum, const table_counts *more) {
  sum->rays += more->rays;
  sum->packets += more->packets;
  sum->nodes += more->nodes;
  sum->box_vectors += more->box_vectors;
  sum->triangle_vectors += more->triangle_vectors;
  sum->boxes += more->boxes;
  sum->triangles += more->triangles;
}

/* [split] */
EX_UNUSED static double table_vectors(const table_counts *counts) {
  return (double)(counts->box_vectors + counts->triangle_vectors);
}
EX_UNUSED static double table_tests(const table_counts *counts) { return (double)(counts->boxes + counts->triangles); }

/* Returns the mean number of lanes, of eight, in which a vector has a ray to test. */
EX_UNUSED static double table_lanes(const table_counts *counts) { return table_tests(counts) / table_vectors(counts); }

/* Returns how many times as many tests the same rays need when they are traced alone. */
EX_UNUSED static double table_fewer(const table_counts *alone, const table_counts *packets) {
  return table_tests(alone) / table_tests(packets);
}
/* [end] */

/* Returns the library's counts in our terms. */
EX_UNUSED static table_counts table_counts_of(const pktrt_counts *theirs) {
  const table_counts counts = {theirs->rays, theirs->packets, theirs->node_visits, theirs->vector_box_tests,
      theirs->vector_triangle_tests, theirs->box_tests, theirs->triangle_tests};
  return counts;
}

/* >>pictures ------------------------------------------------------------------------------------------------------- */

/* A camera path: of each of 8 frames of 512 x 512 pixels one tile of 32 x 32 is made. */
enum { TABLE_FRAMES = 8, TABLE_PIXELS = 512, TABLE_TILE = 32 };

typedef struct table_world {
  int number; /* of the scene */
  scene made;
  pktrt_scene *library;
} table_world;

/* Returns a scene in which nothing moves (shutter 0), or one for distribution ray tracing, whose meshes move while the
   shutter is open, for a part of the animation's loop. In the paper's conference room all surfaces reflect, glossily in
   distribution ray tracing, so ours are made to do so. */
EX_UNUSED static table_world table_open_moving(int number, double shutter) {
  table_world world;
  pktrt_scene_desc desc;
  world.number = number;
  if (!scene_make(table_scene[number], &world.made)) {
    ex_fail("out of memory");
    exit(1);
  }

  for (size_t i = 0; i < world.made.material_count && number == 0; i++) {
    pktrt_material *material = &world.made.materials[i].m;
    if (material->specular != PKTRT_SPECULAR_NONE) continue;
    material->specular = PKTRT_SPECULAR_MIRROR;
    if (shutter > 0) {
      material->lobe = PKTRT_LOBE_PHONG;
      material->exponent = 100;
    }
    for (int c = 0; c < 3; c++) {
      material->reflectance[c] = 0.4f;
      material->albedo[c] *= 0.6f;
    }
  }

  /* The instruction set that the bench has for the paper's path, where there is one. */
  memset(&desc, 0, sizeof desc);
  desc.isa = pktrt_isa_available(PKTRT_ISA_SSE2) ? PKTRT_ISA_SSE2 : PKTRT_ISA_AUTO;
  world.library = pktrt_scene_create(&desc);
  if (!world.library || scene_add_at(world.library, &world.made, 0, shutter) || pktrt_commit(world.library)) {
    ex_fail("%s", pktrt_last_error(world.library));
    exit(1);
  }
  return world;
}

EX_UNUSED static table_world table_open(int number) { return table_open_moving(number, 0); }

EX_UNUSED static void table_close(table_world *world) {
  pktrt_scene_destroy(world->library);
  scene_free(&world->made);
}

/* Returns how table 1 has a frame of a scene rendered, in packets of ray types or (edge 1) with single rays. */
EX_UNUSED static pktrt_render_desc table_describe(const table_world *world, int frame, uint32_t edge) {
  static float pixels[TABLE_PIXELS * TABLE_PIXELS * 3];
  pktrt_render_desc desc;
  memset(&desc, 0, sizeof desc);
  desc.width = TABLE_PIXELS;
  desc.height = TABLE_PIXELS;
  desc.pixels = pixels;
  desc.samples = 1;
  desc.mode = PKTRT_MODE_WRT;
  desc.path = PKTRT_PATH_PAPER;
  desc.packet_size = edge > 1 ? edge : 2;
  desc.assembly = edge > 1 ? PKTRT_ASSEMBLY_RAY_TYPES : PKTRT_ASSEMBLY_NONE;
  desc.camera = world->made.camera;
  scene_camera(&world->made, (double)frame / TABLE_FRAMES, &desc.camera);
  desc.camera.time = 0;
  desc.camera.shutter = 0;
  memcpy(desc.background, world->made.background, sizeof desc.background);
  memcpy(desc.ambient, world->made.ambient, sizeof desc.ambient);

  if (world->number == 0) { /* no attenuation, and five bounces */
    desc.max_depth = 5;
    desc.attenuation = -1;
    desc.normals = PKTRT_NORMALS_GEOMETRIC;
  }
  return desc;
}

/* Stores where the tile of a frame begins: at points of the R2 sequence, which covers the picture evenly. */
EX_UNUSED static void table_tile(int frame, uint32_t *x, uint32_t *y) {
  const double u = (frame + 0.5) * 0.7548776662466927, v = (frame + 0.5) * 0.5698402909980532;
  *x = (uint32_t)((u - floor(u)) * (TABLE_PIXELS / 64)) * 64;
  *y = (uint32_t)((v - floor(v)) * (TABLE_PIXELS / 64)) * 64;
}

EX_UNUSED static void table_render(
    const table_world *world, const pktrt_render_desc *desc, uint32_t x, uint32_t y, uint32_t edge) {
  if (pktrt_render_tile(world->library, desc, x, y, edge, edge) == PKTRT_OK) return;
  ex_fail("%s", pktrt_last_error(world->library));
  exit(1);
}

/* The `user` of table_alone(): the scene, and where to count. */
typedef struct table_alone_user {
  const table_world *world;
  pktrt_stats *stats;
} table_alone_user;

/* [alone] */
/* Traces the camera rays of a packet one by one. PKTRT_ASSEMBLY_NONE traces the other rays so, but leaves camera rays in
   packets. */
EX_UNUSED static void table_alone(void *user, const pktrt_packet *packet) {
  const table_alone_user *to = (const table_alone_user *)user;
  pktrt_query_desc query;
  if (packet->type != PKTRT_RAY_PRIMARY) return;

  memset(&query, 0, sizeof query);
  query.path = PKTRT_PATH_PAPER;
  query.packet_size = 1;
  query.stats = to->stats;

  for (uint32_t i = 0; i < packet->n; i++) {
    const float origin[3] = {packet->origin[0][i], packet->origin[1][i], packet->origin[2][i]};
    const float direction[3] = {packet->direction[0][i], packet->direction[1][i], packet->direction[2][i]};
    const pktrt_ray ray = pktrt_make_ray(origin, direction);
    pktrt_hit hit;
    pktrt_intersect_ex(to->world->library, &query, &ray, &hit, 1);
  }
}
/* [end] */

/* Counts of a scene, for a packet size: of all rays, by kind of ray, and by bounce (shadow rays one more than their
   surface). */
enum { TABLE_BOUNCES = 8 };
typedef struct table_row {
  table_counts all, type[TABLE_TYPES], bounce[TABLE_BOUNCES];
} table_row;

/* Counts what a scene takes in packets, or alone. */
EX_UNUSED static table_row table_count(const table_world *world, uint32_t edge) {
  static pktrt_stats stats, camera;
  const table_alone_user user = {world, &camera};
  table_row row;
  memset(&row, 0, sizeof row);
  memset(&stats, 0, sizeof stats);
  memset(&camera, 0, sizeof camera);

  for (int frame = 0; frame < TABLE_FRAMES; frame++) {
    uint32_t x, y;
    pktrt_render_desc desc = table_describe(world, frame, edge);
    desc.stats = &stats;
    desc.packet = edge > 1 ? NULL : table_alone;
    desc.user = (void *)(uintptr_t)&user;
    table_tile(frame, &x, &y);
    table_render(world, &desc, x, y, TABLE_TILE);
  }

  for (int type = 0; type < TABLE_TYPES; type++) {
    const bool alone = edge == 1 && type == PKTRT_RAY_PRIMARY;
    row.type[type] = table_counts_of(alone ? &camera.by_type[type] : &stats.by_type[type]);
    table_add(&row.all, &row.type[type]);
  }
  row.bounce[0] = row.type[PKTRT_RAY_PRIMARY];
  for (int bounce = 1; bounce < TABLE_BOUNCES; bounce++) row.bounce[bounce] = table_counts_of(&stats.by_depth[bounce]);
  return row;
}

#endif /* COURSE_15_TABLE_H */
