/* 08_reflect.h - what program, exercise and check of chapter 8 share: nine balls, the rays that they send out, and what
   packets of these cost. */
#ifndef REFLECT_H
#define REFLECT_H

#include "course.h"

enum { REFLECT_SIZE = 128, REFLECT_DEPTH = 8 };

/* The exercise: at most this share of the vector tests that the library's ray types need in the same run. */
#define REFLECT_SHARE (5.0 / 6)

/* [ray] */
typedef struct reflect_ray {
  float origin[3], direction[3];
  pktrt_ray_type type;          /* PKTRT_RAY_PRIMARY, PKTRT_RAY_REFLECTION or PKTRT_RAY_REFRACTION */
  uint32_t x, y, sample, depth; /* the sample that it adds to, and its bounces since the camera */
} reflect_ray;
/* [end] */

/* The exercise: puts n rays of one depth into packets of 1 to 256 rays. Fills `order` with the numbers 0 to n-1, each
   once, and `end` with where packets end in it: packet k holds rays order[end[k-1]] to order[end[k]-1], the first one
   from order[0] on. Returns how many packets there are. Both arrays have room for n. */
uint32_t reflect_assemble(const reflect_ray *rays, uint32_t n, uint32_t *order, uint32_t *end);

/* >>scene ---------------------------------------------------------------------------------------------------------- */

/* A floor of tiles: light and dark. */
EX_UNUSED static void reflect_tiles(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    const bool dark = ((int)floorf(p->position[0][i]) + (int)floorf(p->position[2][i])) % 2 != 0;
    for (int c = 0; c < 3; c++) p->albedo[c][i] = dark ? 0.15f : 0.7f;
  }
}

EX_UNUSED static void reflect_add(pktrt_scene *s, const pktrt_mesh_desc *mesh) {
  if (pktrt_add_mesh(s, mesh, NULL)) ex_fail("%s", pktrt_last_error(s)), exit(1);
}

/* A ball, from pole to pole. Positions are snapped, so that they are the same wherever sines differ in their last bits. */
EX_UNUSED static void reflect_add_ball(pktrt_scene *s, uint32_t material, const float centre[3], float radius) {
  enum { ROWS = 24, COLUMNS = 48, CORNERS = (ROWS + 1) * (COLUMNS + 1) };
  static float positions[CORNERS][3], normals[CORNERS][3];
  static uint32_t indices[ROWS * COLUMNS * 2][3];
  pktrt_mesh_desc mesh;
  for (int i = 0; i < CORNERS; i++) {
    const double a = COURSE_TURN / COLUMNS * (i % (COLUMNS + 1)), b = COURSE_TURN / 2 / ROWS * (i / (COLUMNS + 1));
    const double n[3] = {sin(b) * sin(a), cos(b), sin(b) * cos(a)};
    for (int k = 0; k < 3; k++) {
      normals[i][k] = (float)(floor(n[k] * 65536 + 0.5) / 65536);
      positions[i][k] = centre[k] + radius * normals[i][k];
    }
  }
  for (uint32_t i = 0; i < ROWS * COLUMNS; i++) {
    const uint32_t c = i / COLUMNS * (COLUMNS + 1) + i % COLUMNS, d = c + COLUMNS + 1;
    const uint32_t corner[2][3] = {{c, d, d + 1}, {c, d + 1, c + 1}};
    memcpy(indices[2 * i], corner, sizeof corner);
  }
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = positions[0], mesh.normals = normals[0], mesh.vertex_count = CORNERS;
  mesh.indices = indices[0], mesh.triangle_count = ROWS * COLUMNS * 2, mesh.material = material;
  reflect_add(s, &mesh);
}

EX_UNUSED static void reflect_add_wall(pktrt_scene *s, uint32_t material, const float corners[12]) {
  static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
  pktrt_mesh_desc mesh;
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = corners, mesh.vertex_count = 4, mesh.indices = indices, mesh.triangle_count = 2;
  mesh.material = material;
  reflect_add(s, &mesh);
}

/* Where ball i (0 to 8) stands, and how large all are. */
#define REFLECT_RADIUS 0.9f
EX_UNUSED static void reflect_ball(int i, float centre[3]) {
  centre[0] = 2.3f * (float)(i % 3 - 1), centre[1] = REFLECT_RADIUS, centre[2] = 2.3f * (float)(i / 3 - 1);
}

/* Nine balls on a floor between walls, of which the right one is a mirror. Balls 1, 3 and 8 are glass, the others
   mirrors. */
EX_UNUSED static pktrt_scene *reflect_scene(void) {
  static const float wall[4][12] = {{-5, 0, -5, -5, 0, 9, 5, 0, 9, 5, 0, -5}, /* floor */
      {-5, 0, -5, 5, 0, -5, 5, 4, -5, -5, 4, -5},                             /* back */
      {-5, 0, 9, -5, 0, -5, -5, 4, -5, -5, 4, 9},                             /* left */
      {5, 0, -5, 5, 0, 9, 5, 4, 9, 5, 4, -5}};                                /* right */
  pktrt_material m[5];
  uint32_t index[5];
  pktrt_scene *s = pktrt_scene_create(NULL);
  memset(m, 0, sizeof m);
  m[0].texture = reflect_tiles;
  m[1].albedo[0] = 0.7f, m[1].albedo[1] = 0.45f, m[1].albedo[2] = 0.25f;
  m[2].albedo[0] = 0.3f, m[2].albedo[1] = 0.5f, m[2].albedo[2] = 0.2f;
  m[3].specular = PKTRT_SPECULAR_MIRROR, m[4].specular = PKTRT_SPECULAR_DIELECTRIC;
  for (int c = 0; c < 3; c++) m[3].reflectance[c] = 0.9f;
  for (int i = 0; i < 5; i++)
    if (!s || pktrt_add_material(s, &m[i], &index[i])) ex_fail("out of memory"), exit(1);
  for (int i = 0; i < 4; i++) reflect_add_wall(s, index[i], wall[i]);
  for (int i = 0; i < 9; i++) {
    float centre[3];
    reflect_ball(i, centre);
    reflect_add_ball(s, index[i == 1 || i == 3 || i == 8 ? 4 : 3], centre, REFLECT_RADIUS);
  }
  if (pktrt_commit(s)) ex_fail("%s", pktrt_last_error(s)), exit(1);
  return s;
}

/* How the picture is made: by the paper's packets of 8 x 8 pixels. There are no lights and hence no shadow rays, but the
   same light from everywhere. */
EX_UNUSED static pktrt_render_desc reflect_view(float *pixels) {
  pktrt_render_desc d;
  memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = d.height = REFLECT_SIZE, d.pixels = pixels, d.mode = PKTRT_MODE_WRT, d.path = PKTRT_PATH_PAPER;
  d.camera.eye[0] = -1.2f, d.camera.eye[1] = 2.6f, d.camera.eye[2] = 7.5f;
  d.camera.target[0] = 0.5f, d.camera.target[1] = 0.7f, d.camera.fov_y = 48;
  d.max_depth = REFLECT_DEPTH, d.attenuation = -1;
  for (int c = 0; c < 3; c++) d.ambient[c] = 1, d.background[c] = 0.4f + 0.2f * (float)c;
  return d;
}

/* >>rays ----------------------------------------------------------------------------------------------------------- */

typedef struct reflect_log { /* all rays of a picture, packet by packet as the library had them */
  reflect_ray *ray;
  uint32_t *end; /* of each packet */
  uint32_t n, packets, room;
} reflect_log;

/* [log] */
EX_UNUSED static void reflect_log_packet(void *user, const pktrt_packet *p) {
  reflect_log *log = (reflect_log *)user;
  if (log->n + p->n > log->room) {
    ex_fail("more rays than there is room for");
    exit(1);
  }
  for (uint32_t i = 0; i < p->n; i++) {
    reflect_ray *to = &log->ray[log->n++];
    for (int a = 0; a < 3; a++) {
      to->origin[a] = p->origin[a][i];
      to->direction[a] = p->direction[a][i];
    }
    to->type = p->type;
    to->depth = p->depth;
    to->x = p->x[i];
    to->y = p->y[i];
    to->sample = p->sample[i];
  }
  log->end[log->packets++] = log->n;
}
/* [end] */

EX_UNUSED static reflect_log reflect_log_make(void) {
  reflect_log log = {NULL, NULL, 0, 0, 1u << 19};
  log.ray = (reflect_ray *)course_memory(log.room, sizeof *log.ray);
  log.end = (uint32_t *)course_memory(log.room, sizeof *log.end);
  return log;
}
EX_UNUSED static void reflect_log_free(reflect_log *log) { free(log->ray), free(log->end); }

/* [trace] */
/* Traces rays in the packets given (see reflect_assemble), one call for each, and returns how many vector tests that
   takes. hits[i] becomes the answer of ray i. */
EX_UNUSED static uint64_t reflect_trace(const pktrt_scene *s, const reflect_ray *rays, const uint32_t *order,
    const uint32_t *end, uint32_t packets, pktrt_hit *hits) {
  pktrt_ray ray[256];
  pktrt_hit hit[256];
  pktrt_stats stats;
  pktrt_query_desc query;
  memset(&stats, 0, sizeof stats);
  memset(&query, 0, sizeof query);
  query.path = PKTRT_PATH_PAPER;
  query.stats = &stats;

  for (uint32_t k = 0, begin = 0; k < packets; begin = end[k++]) {
    const uint32_t n = query.packet_size = end[k] - begin;
    for (uint32_t i = 0; i < n; i++) {
      const reflect_ray *r = &rays[order[begin + i]];
      ray[i] = pktrt_make_ray(r->origin, r->direction);
    }
    pktrt_intersect_ex(s, &query, ray, hit, n);
    for (uint32_t i = 0; i < n; i++) hits[order[begin + i]] = hit[i];
  }
  return stats.by_type[query.type].vector_box_tests + stats.by_type[query.type].vector_triangle_tests;
}
/* [end] */

#endif
