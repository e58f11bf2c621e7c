/* hard.h - eight small scenes, each of which is hard for a filter in a way of its own. Pictures of them are references.

     shadows   balls and a box under a large quad light: smooth penumbrae
     sky       the same under a sky that is brighter on one side
     glass     a ball of glass, one of metal and one of gloss on a chequered floor: what is seen has no features
     lamps     forty lamps, each surface asking one of them
     focus     small bright lights far behind the plane that is sharp: rare samples of great value
     motion    balls that move while the shutter is open
     mirrors   a room of mirrors with coloured balls: edges at many depths that no feature tells of
     edges     a fence of thin bars before a striped wall, in a hard light

   Contents: building, scenes, all of them. */
#ifndef ERROR_HARD_H
#define ERROR_HARD_H

#include "closed.h"
#include "error.h"

/* >>building ------------------------------------------------------------------------------------------------------- */

static uint32_t add_hard_material(stage *g, const pktrt_material *m) {
  uint32_t index = 0;
  if (pktrt_add_material(g->world, m, &index)) fatal(pktrt_last_error(g->world));
  return index;
}

/* Channels in turn: red, green, blue. */
static uint32_t matt(stage *g, double first, double second, double third) {
  pktrt_material m;
  memset(&m, 0, sizeof m);
  set3(m.albedo, first, second, third);
  return add_hard_material(g, &m);
}

static uint32_t shining(stage *g, double first, double second, double third) {
  pktrt_material m;
  memset(&m, 0, sizeof m);
  set3(m.emission, first, second, third);
  return add_hard_material(g, &m);
}

/* A mirror that reflects so much; where `exponent` is not 0, in a lobe around the mirror direction. */
static uint32_t mirroring(stage *g, double part, double exponent) {
  pktrt_material m;
  memset(&m, 0, sizeof m);
  m.specular = PKTRT_SPECULAR_MIRROR;
  set3(m.reflectance, part, part, part);
  set3(m.albedo, 0.5 * (1 - part), 0.5 * (1 - part), 0.5 * (1 - part));
  if (exponent > 0) {
    m.lobe = PKTRT_LOBE_PHONG;
    m.exponent = (float)exponent;
  }
  return add_hard_material(g, &m);
}

static void add_hard_light(stage *g, const pktrt_light *l) {
  if (pktrt_add_light(g->world, l, NULL)) fatal(pktrt_last_error(g->world));
}

/* A parallelogram from a corner along two sides; its front is the side of cross(u, v). */
static void add_sheet(stage *g, const double corner[3], const double u[3], const double v[3], uint32_t material) {
  float p[4][3];
  for (int k = 0; k < 3; k++) {
    p[0][k] = (float)corner[k];
    p[1][k] = (float)(corner[k] + u[k]);
    p[2][k] = (float)(corner[k] + u[k] + v[k]);
    p[3][k] = (float)(corner[k] + v[k]);
  }
  add_fan(g, &p[0][0], 4, 1, 1, material);
}

/* The box between two corners. */
static void add_box(stage *g, const double low[3], const double high[3], uint32_t material) {
  for (int axis = 0; axis < 3; axis++) {
    const int next = (axis + 1) % 3, last = (axis + 2) % 3;
    double u[3] = {0, 0, 0}, v[3] = {0, 0, 0}, at[3] = {low[0], low[1], low[2]};
    u[next] = high[next] - low[next];
    v[last] = high[last] - low[last];
    add_sheet(g, at, v, u, material);
    at[axis] = high[axis];
    add_sheet(g, at, u, v, material);
  }
}

enum { BALL_ROWS = 16, BALL_COLUMNS = 32, BALL_VERTICES = (BALL_ROWS + 1) * (BALL_COLUMNS + 1) };

/* A ball with smooth normals; in motion by `shift`, if not NULL, while time goes from 0 to 1. */
static void add_ball(stage *g, double x, double y, double z, double radius, const double shift[3], uint32_t material) {
  static float positions[2][BALL_VERTICES][3], normals[2][BALL_VERTICES][3];
  static uint32_t indices[BALL_ROWS * BALL_COLUMNS * 2][3];
  pktrt_mesh_desc d;
  uint32_t triangles = 0;

  for (int i = 0; i < BALL_VERTICES; i++) {
    const double down = 180.0 * (i / (BALL_COLUMNS + 1)) / BALL_ROWS;
    const double round = 360.0 * (i % (BALL_COLUMNS + 1) % BALL_COLUMNS) / BALL_COLUMNS;
    const double unit[3] = {sc_sin(down) * sc_cos(round), sc_cos(down), -sc_sin(down) * sc_sin(round)};
    for (int key = 0; key < 2; key++) {
      const double off[3] = {shift && key ? shift[0] : 0, shift && key ? shift[1] : 0, shift && key ? shift[2] : 0};
      set3(positions[key][i], x + off[0] + radius * unit[0], y + off[1] + radius * unit[1],
          z + off[2] + radius * unit[2]);
      set3(normals[key][i], unit[0], unit[1], unit[2]);
    }
  }

  for (uint32_t row = 0; row < BALL_ROWS; row++)
    for (uint32_t column = 0; column < BALL_COLUMNS; column++) {
      const uint32_t a = row * (BALL_COLUMNS + 1) + column, b = a + BALL_COLUMNS + 1;
      const uint32_t two[2][3] = {{a, b, b + 1}, {a, b + 1, a + 1}};
      memcpy(indices[triangles], two, sizeof two);
      triangles += 2;
    }

  memset(&d, 0, sizeof d);
  d.positions = &positions[0][0][0];
  d.normals = &normals[0][0][0];
  d.vertex_count = BALL_VERTICES;
  d.key_count = shift ? 2 : 1;
  d.indices = &indices[0][0];
  d.triangle_count = triangles;
  d.material = material;
  if (pktrt_add_mesh(g->world, &d, NULL)) fatal(pktrt_last_error(g->world));
}

static void add_ground(stage *g, uint32_t material) {
  static const double corner[3] = {-6, 0, 6}, u[3] = {12, 0, 0}, v[3] = {0, 0, -14};
  add_sheet(g, corner, u, v, material);
}

static void add_back(stage *g, double z, uint32_t material) {
  const double corner[3] = {-6, 0, z}, u[3] = {12, 0, 0}, v[3] = {0, 6, 0};
  add_sheet(g, corner, u, v, material);
}

/* A square light above that faces down. */
static void light_above(stage *g, double x, double y, double z, double side, double radiance) {
  pktrt_light l;
  memset(&l, 0, sizeof l);
  l.kind = PKTRT_LIGHT_QUAD;
  set3(l.position, x - 0.5 * side, y, z - 0.5 * side);
  l.edge[0][0] = (float)side;
  l.edge[1][2] = (float)side;
  set3(l.intensity, radiance, 0.95 * radiance, 0.85 * radiance);
  add_hard_light(g, &l);
}

static void look(stage *g, double x, double y, double z, double to_y) {
  set3(g->view.camera.eye, x, y, z);
  set3(g->view.camera.target, 0, to_y, 0);
  g->view.camera.fov_y = 45;
}

/* >>scenes --------------------------------------------------------------------------------------------------------- */

static void add_bodies(stage *g) {
  static const double low[3] = {0.9, 0, -1.2}, high[3] = {1.7, 1.3, -0.4};
  add_ground(g, matt(g, 0.7, 0.7, 0.68));
  add_ball(g, -0.9, 0.7, 0, 0.7, NULL, matt(g, 0.8, 0.35, 0.25));
  add_ball(g, 0.4, 0.4, 0.9, 0.4, NULL, matt(g, 0.3, 0.5, 0.8));
  add_box(g, low, high, matt(g, 0.4, 0.7, 0.4));
}

static void make_hard_shadows(stage *g) {
  add_bodies(g);
  add_back(g, -2.5, matt(g, 0.6, 0.6, 0.65));
  light_above(g, -1, 4, 1, 2.2, 13);
  look(g, 0, 2, 5.5, 0.7);
}

static void hard_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const float up = direction[1][i] > 0 ? direction[1][i] : 0;
    const float side = 0.5f + 0.5f * direction[0][i];
    const float glow = side * side * side * side;
    radiance[0][i] = 0.25f + 0.15f * up + 1.3f * glow;
    radiance[1][i] = 0.30f + 0.20f * up + 1.0f * glow;
    radiance[2][i] = 0.45f + 0.35f * up + 0.6f * glow;
  }
}

static void make_hard_sky(stage *g) {
  pktrt_light l;
  add_bodies(g);
  memset(&l, 0, sizeof l);
  l.kind = PKTRT_LIGHT_ENVIRONMENT;
  set3(l.intensity, 1, 1, 1);
  add_hard_light(g, &l);
  g->view.environment = hard_sky;
  look(g, 0, 2, 5.5, 0.7);
}

static void chequer(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    const int32_t field = sc_floor(2 * (double)p->position[0][i]) + sc_floor(2 * (double)p->position[2][i]);
    for (int c = 0; c < 3; c++) p->albedo[c][i] = field & 1 ? 0.75f : 0.15f;
  }
}

static void make_hard_glass(stage *g) {
  pktrt_material floor, glass, metal;
  memset(&floor, 0, sizeof floor);
  memset(&glass, 0, sizeof glass);
  memset(&metal, 0, sizeof metal);
  floor.texture = chequer;
  glass.specular = PKTRT_SPECULAR_DIELECTRIC;
  set3(glass.absorption, 0.3, 0.1, 0.1);
  metal.specular = PKTRT_SPECULAR_CONDUCTOR;
  set3(metal.ior, 0.2, 0.9, 1.3);
  set3(metal.extinction, 3.9, 2.4, 2.2);
  add_ground(g, add_hard_material(g, &floor));
  add_back(g, -2.5, matt(g, 0.3, 0.45, 0.6));
  add_ball(g, -1.1, 0.8, 0.3, 0.8, NULL, add_hard_material(g, &glass));
  add_ball(g, 0.8, 0.8, -0.6, 0.8, NULL, add_hard_material(g, &metal));
  add_ball(g, 1.4, 0.45, 1.1, 0.45, NULL, mirroring(g, 0.7, 60));
  light_above(g, 0.5, 4, 1, 1.2, 45);
  look(g, 0, 2, 5.5, 0.7);
}

static void make_hard_lamps(stage *g) {
  uint32_t random = 40;
  add_bodies(g);
  add_back(g, -2.5, matt(g, 0.65, 0.6, 0.55));
  for (int i = 0; i < 40; i++) {
    pktrt_light l;
    const double strength = 1 + 7 * sc_random(&random) * sc_random(&random);
    const double across = 8 * sc_random(&random) - 4, along = 6 * sc_random(&random) - 2.2;
    memset(&l, 0, sizeof l);
    l.kind = i % 2 ? PKTRT_LIGHT_SPHERE : PKTRT_LIGHT_POINT;
    l.radius = 0.06f;
    set3(l.position, across, 0.5 + 2.5 * sc_random(&random), along);
    const double unit = i % 2 ? strength / (SC_PI * 0.06 * 0.06) : strength;
    set3(l.intensity, unit * 0.35, unit * (0.15 + 0.2 * sc_random(&random)), unit * (0.1 + 0.25 * sc_random(&random)));
    add_hard_light(g, &l);
  }
  g->view.lights = PKTRT_LIGHTS_ONE;
  look(g, 0, 2, 5.5, 0.7);
}

static void make_hard_focus(stage *g) {
  uint32_t random = 7;
  add_bodies(g);
  for (int i = 0; i < 24; i++) {
    const double x = 14 * sc_random(&random) - 7, y = 0.5 + 5 * sc_random(&random);
    const double warm = sc_random(&random);
    add_ball(g, x, y, -9 - 3 * sc_random(&random), 0.07, NULL, shining(g, 60, 60 * (0.4 + 0.5 * warm), 50 * warm));
  }
  light_above(g, -1, 5, 2, 1.5, 22);
  look(g, 0, 2, 5.5, 0.7);
  g->view.camera.aperture = 0.35f;
  g->view.camera.focus = 5;
}

static void make_hard_motion(stage *g) {
  static const double aside[3] = {1.3, 0.2, 0}, up[3] = {0, 0.9, 0.3}, nearer[3] = {-0.6, 0, 1.2};
  add_ground(g, matt(g, 0.7, 0.7, 0.68));
  add_back(g, -2.5, matt(g, 0.6, 0.65, 0.7));
  add_ball(g, -1.6, 0.7, 0, 0.7, aside, matt(g, 0.8, 0.3, 0.2));
  add_ball(g, 0.8, 0.5, 0.8, 0.4, up, matt(g, 0.2, 0.4, 0.8));
  add_ball(g, 1.8, 0.6, -1, 0.5, nearer, matt(g, 0.8, 0.7, 0.2));
  light_above(g, -1, 4, 1, 1, 60);
  look(g, 0, 2, 5.5, 0.7);
  g->view.camera.shutter = 1;
}

static void make_hard_mirrors(stage *g) {
  static const double far_left[3] = {-3, 0, 3}, left_u[3] = {0, 0, -6}, up[3] = {0, 4, 0};
  static const double right[3] = {3, 0, -3}, right_u[3] = {0, 0, 6}, back[3] = {-3, 0, -3}, back_u[3] = {6, 0, 0};
  static const double floor[3] = {-3, 0, 3}, floor_v[3] = {0, 0, -6};
  const uint32_t wall = mirroring(g, 0.9, 0);
  pktrt_material chequered;
  memset(&chequered, 0, sizeof chequered);
  chequered.texture = chequer;
  add_sheet(g, far_left, left_u, up, wall);
  add_sheet(g, right, right_u, up, wall);
  add_sheet(g, back, back_u, up, wall);
  add_sheet(g, floor, back_u, floor_v, add_hard_material(g, &chequered));
  add_ball(g, -1.3, 0.6, -0.8, 0.6, NULL, mirroring(g, 0.85, 0));
  add_ball(g, 0.2, 0.8, -1.4, 0.8, NULL, mirroring(g, 0.9, 400));
  add_ball(g, 1.5, 0.5, -0.4, 0.5, NULL, matt(g, 0.8, 0.2, 0.2));
  add_ball(g, 0.1, 0.35, 0.7, 0.35, NULL, matt(g, 0.2, 0.5, 0.8));
  light_above(g, 0, 3.9, 0, 0.8, 90);
  look(g, 0, 2, 4.5, 0.9);
}

static void stripes(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    const int32_t field = sc_floor(9 * (double)p->position[0][i] + 5 * (double)p->position[1][i]);
    for (int c = 0; c < 3; c++) p->albedo[c][i] = field & 1 ? 0.85f : 0.05f + 0.2f * (float)c;
  }
}

static void make_hard_edges(stage *g) {
  pktrt_material striped;
  pktrt_light l;
  const uint32_t bars = matt(g, 0.8, 0.6, 0.3);
  memset(&striped, 0, sizeof striped);
  striped.texture = stripes;
  add_ground(g, matt(g, 0.6, 0.6, 0.6));
  add_back(g, -1.5, add_hard_material(g, &striped));
  for (int i = 0; i < 25; i++) {
    const double x = 0.21 * i - 2.6, low[3] = {x, 0, 0.5}, high[3] = {x + 0.05, 1.8, 0.55};
    add_box(g, low, high, bars);
  }
  memset(&l, 0, sizeof l);
  l.kind = PKTRT_LIGHT_DIRECTIONAL;
  set3(l.direction, 0.5, -1, -0.7);
  set3(l.intensity, 2.6, 2.5, 2.3);
  add_hard_light(g, &l);
  set3(g->view.ambient, 0.15, 0.17, 0.2);
  look(g, 0.8, 1.6, 4.5, 0.9);
}

/* >>all of them ---------------------------------------------------------------------------------------------------- */

static const struct hard_scene {
  const char *name;
  void (*make)(stage *);
  bool smooth; /* most of the picture is: noise, and nothing that a filter could blur */
} hard_scenes[] = {{"shadows", make_hard_shadows, true}, {"sky", make_hard_sky, true},
    {"glass", make_hard_glass, false}, {"lamps", make_hard_lamps, true}, {"focus", make_hard_focus, false},
    {"motion", make_hard_motion, true}, {"mirrors", make_hard_mirrors, false}, {"edges", make_hard_edges, false}};
enum { HARD_SCENES = sizeof hard_scenes / sizeof *hard_scenes };

/* Opens one of them for pictures by DRT. *g must stay where it is. */
static void hard_open(stage *g, unsigned which, uint32_t width, uint32_t height) {
  char name[sizeof g->name];
  snprintf(name, sizeof name, "hard %s", hard_scenes[which].name);
  stage_open_made(g, name, hard_scenes[which].make, width, height);
}

#endif /* ERROR_HARD_H */
