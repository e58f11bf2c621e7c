/* Scenes and rays of checksum.c and stack.c, programs that stand alone, and the library with them. Plain C99 without threads
   or files. Everything is made of integers and of halves, quarters and so on: nothing is rounded, so that neither a function of
   libm nor a multiply-add that a compiler fuses can decide any of it. */
#ifndef PKTRT_TEST_SCENES_H
#define PKTRT_TEST_SCENES_H
#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifndef SCENES_SEED /* another one is the control: all sums must differ */
#define SCENES_SEED 1
#endif

/* --- numbers --- */

typedef struct numbers {
  uint64_t state;
} numbers;

static numbers numbers_of(uint32_t seed) {
  numbers n = {(uint64_t)SCENES_SEED << 32 | seed};
  return n;
}

static int32_t pick(numbers *n, int32_t lo, int32_t hi) { /* of [lo, hi] */
  uint64_t x = n->state += UINT64_C(0x9E3779B97F4A7C15);
  x = (x ^ x >> 30) * UINT64_C(0xBF58476D1CE4E5B9);
  x = (x ^ x >> 27) * UINT64_C(0x94D049BB133111EB);
  return lo + (int32_t)((x >> 33) % (uint64_t)(hi - lo + 1));
}

enum { UNIT = 4096 }; /* coordinates are integers in parts of this: floats hold them exactly, and sums of a few */

static float fixed(int32_t x) { return (float)x / (float)UNIT; }

static int64_t whole_root(int64_t x) {
  int64_t root = 0;
  for (int64_t bit = (int64_t)1 << 31; bit; bit >>= 1) {
    if ((root + bit) * (root + bit) <= x) root += bit;
  }
  return root;
}

/* --- complaints --- */

static int complaints;
static const char *part_now = "", *isa_now = "";

static void complain(const char *what, const char *detail) {
  complaints++;
  printf("WRONG: %s, %s: %s%s\n", part_now, isa_now, what, detail);
}

static void expect(pktrt_scene *s, pktrt_status status) {
  if (status != PKTRT_OK) complain("", pktrt_last_error(s));
}

/* --- shapes --- */

enum { VERTICES = 700, TRIANGLES = 1200, KEYS = 3 };
typedef struct shape {
  uint32_t vertex_count, triangle_count, key_count;
  float position[KEYS * VERTICES * 3], normal[VERTICES * 3];
  uint32_t index[TRIANGLES * 3];
} shape;

static void put_vertex(shape *m, const int32_t position[3], const int32_t normal[3]) {
  for (int a = 0; a < 3; a++) {
    m->position[m->vertex_count * 3 + (uint32_t)a] = fixed(position[a]);
    m->normal[m->vertex_count * 3 + (uint32_t)a] = fixed(normal[a]);
  }
  m->vertex_count++;
}

static void put_triangle(shape *m, uint32_t a, uint32_t b, uint32_t c) {
  uint32_t *index = m->index + m->triangle_count++ * 3;
  index[0] = a, index[1] = b, index[2] = c;
}

static void put_squares(shape *m, uint32_t first, uint32_t edge) { /* over (edge + 1)^2 vertices, row by row */
  for (uint32_t i = 0; i < edge * edge; i++) {
    const uint32_t v = first + i / edge * (edge + 1) + i % edge;
    put_triangle(m, v, v + edge + 1, v + edge + 2);
    put_triangle(m, v, v + edge + 2, v + 1);
  }
}

static shape *shape_begin(void) {
  shape *m = (shape *)calloc(1, sizeof *m);
  if (!m) abort();
  m->key_count = 1;
  return m;
}

/* A cube of edge^2 squares a side, facing out; or a ball: its vertices pulled to a sphere. */
static shape *cube(const int32_t middle[3], int32_t radius, int32_t edge, bool round) {
  shape *m = shape_begin();
  for (int face = 0; face < 6; face++) {
    const int f = face % 3, g = (f + 1) % 3, h = (f + 2) % 3;
    const uint32_t first = m->vertex_count;
    for (int32_t i = 0; i <= edge; i++) {
      for (int32_t j = 0; j <= edge; j++) {
        int32_t at[3], position[3], normal[3] = {0, 0, 0};
        at[f] = face < 3 ? edge : -edge, at[g] = 2 * (face < 3 ? i : j) - edge, at[h] = 2 * (face < 3 ? j : i) - edge;
        const int64_t root = whole_root((int64_t)(at[0] * at[0] + at[1] * at[1] + at[2] * at[2]) << 24);
        normal[f] = face < 3 ? UNIT : -UNIT;
        for (int a = 0; a < 3; a++) {
          if (round) normal[a] = (int32_t)((int64_t)at[a] * UNIT * UNIT / root);
          position[a] = middle[a] + (round ? (int32_t)((int64_t)normal[a] * radius / UNIT) : at[a] * radius / edge);
        }
        put_vertex(m, position, normal);
      }
    }
    put_squares(m, first, (uint32_t)edge);
  }
  return m;
}

/* A field of hills over [-half, half]^2, facing up; half must be a multiple of edge. */
static shape *hills(int32_t edge, int32_t half, int32_t level, int32_t height, uint32_t seed) {
  shape *m = shape_begin();
  numbers n = numbers_of(seed);
  for (int32_t j = 0; j <= edge; j++) {
    for (int32_t i = 0; i <= edge; i++) {
      const int32_t position[3] = {
          (2 * i - edge) * (half / edge), level + pick(&n, -height, height), (2 * j - edge) * (half / edge)};
      const int32_t normal[3] = {pick(&n, -height, height), UNIT, pick(&n, -height, height)};
      put_vertex(m, position, normal);
    }
  }
  put_squares(m, 0, (uint32_t)edge);
  return m;
}

/* Triangles anywhere, of all sizes; some without area, some twice. */
static shape *heap(uint32_t count, uint32_t seed) {
  shape *m = shape_begin();
  numbers n = numbers_of(seed);
  for (uint32_t i = 0; i < count; i++) {
    const int32_t middle[3] = {pick(&n, -3 * UNIT, 3 * UNIT), pick(&n, 0, 3 * UNIT), pick(&n, -3 * UNIT, 3 * UNIT)};
    const int32_t size = UNIT >> pick(&n, 0, 6), up[3] = {0, UNIT, 0};
    for (int c = 0; c < 3; c++) {
      int32_t position[3];
      for (int a = 0; a < 3; a++) position[a] = middle[a] + pick(&n, -size, size);
      put_vertex(m, position, up);
    }
    put_triangle(m, 3 * i, 3 * i + 1, i % 16 == 5 ? 3 * i : 3 * i + 2);
    if (i % 16 == 7) put_triangle(m, 3 * i, 3 * i + 1, 3 * i + 2);
  }
  return m;
}

/* Gives a shape its further keys: shifted, and each vertex shaken. */
static shape *moved(shape *m, uint32_t keys, int32_t shift, int32_t shake, uint32_t seed) {
  numbers n = numbers_of(seed);
  const uint32_t floats = m->vertex_count * 3;
  for (uint32_t i = floats; i < keys * floats; i++)
    m->position[i] = m->position[i - floats] + fixed((i % 3 == 0 ? shift : 0) + pick(&n, -shake, shake));
  m->key_count = keys;
  return m;
}

static uint32_t add_shape(pktrt_scene *s, shape *m, uint32_t material, bool smooth) { /* and frees it */
  pktrt_mesh_desc d;
  uint32_t mesh = PKTRT_NONE;
  memset(&d, 0, sizeof d);
  d.positions = m->position, d.vertex_count = m->vertex_count;
  d.indices = m->index, d.triangle_count = m->triangle_count;
  d.key_count = m->key_count, d.material = material;
  if (smooth && m->key_count == 1) d.normals = m->normal;
  expect(s, pktrt_add_mesh(s, &d, &mesh));
  free(m);
  return mesh;
}

static pktrt_scene *scene_open(pktrt_isa isa) {
  pktrt_scene_desc d;
  memset(&d, 0, sizeof d);
  d.isa = isa;
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!s) {
    printf("WRONG: %s: no scene: %s\n", pktrt_isa_string(isa), pktrt_last_error(NULL));
    exit(1);
  }
  return s;
}

static const int32_t ball_middle[3] = {-UNIT, 2 * UNIT, 0}, box_middle[3] = {2 * UNIT, UNIT, UNIT};

static shape *a_ball(void) { return cube(ball_middle, UNIT * 5 / 4, 7, true); }
static shape *a_box(void) { return cube(box_middle, UNIT * 3 / 4, 1, false); }

static pktrt_scene *world(pktrt_isa isa, bool moving) {
  pktrt_scene *s = scene_open(isa);
  add_shape(s, hills(20, 6 * UNIT / 20 * 20, 0, UNIT / 3, 1), 0, false);
  add_shape(s, moving ? moved(a_ball(), 2, UNIT, UNIT / 16, 2) : a_ball(), 0, false);
  add_shape(s, a_box(), 0, false);
  add_shape(s, a_box(), 0, false); /* twice: of equal depths the lower mesh wins */
  add_shape(s, moving ? moved(heap(200, 3), 3, -UNIT, UNIT / 2, 4) : heap(200, 3), 0, false);
  expect(s, pktrt_commit(s));
  return s;
}

/* --- rays --- */

enum { RAYS = 480, KINDS = 6 };

/* Like a camera's pixels, towards points of the scene, anywhere, along axes, as short as a shadow's, and invalid ones. */
static void make_rays(pktrt_ray ray[RAYS], uint32_t seed) {
  numbers n = numbers_of(seed);
  memset(ray, 0, RAYS * sizeof *ray);
  for (int32_t i = 0; i < RAYS; i++) {
    pktrt_ray *r = &ray[i];
    const int32_t kind = i / (RAYS / KINDS), x = i % 16, y = i / 16 % 5;
    for (int a = 0; a < 3; a++) {
      r->origin[a] = fixed(pick(&n, -8 * UNIT, 8 * UNIT));
      r->direction[a] = fixed(pick(&n, -UNIT, UNIT));
    }
    r->tmax = INFINITY, r->time = fixed(pick(&n, 0, UNIT / 64) * 64);
    if (kind == 0) {
      r->origin[0] = 1, r->origin[1] = 4, r->origin[2] = 9;
      r->direction[0] = fixed((2 * x - 15) * 144), r->direction[1] = fixed((2 * y - 4) * 144 - UNIT / 4);
      r->direction[2] = -1;
    } else if (kind == 1 || kind == 4) {
      for (int a = 0; a < 3; a++) r->direction[a] = fixed(pick(&n, -2 * UNIT, 2 * UNIT)) - r->origin[a];
      r->direction[1] += 1;
      if (kind == 4) r->tmin = fixed(pick(&n, 0, UNIT / 2)), r->tmax = fixed(pick(&n, UNIT / 2, UNIT));
    } else if (kind == 3) {
      for (int a = 0; a < 3; a++) r->origin[a] = (float)(int32_t)(r->origin[a] / 2), r->direction[a] = 0;
      r->direction[i % 3] = i & 4 ? 1.0f : -0.5f;
    } else if (kind == 5) {
      if (i % 4 == 0) memset(r->direction, 0, sizeof r->direction);
      if (i % 4 == 1) r->origin[i % 3] = INFINITY;
      if (i % 4 == 2) r->direction[i % 3] = -INFINITY;
      if (i % 4 == 3) r->tmin = 2, r->tmax = 1;
    }
  }
}

/* --- rooms --- */

static void checks(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    const bool dark = (p->triangle[i] >> 1 & 1) != 0;
    for (int a = 0; a < 3; a++) p->albedo[a][i] *= dark ? 0.25f : 1.0f;
  }
}

static void by_normal(void *user, const pktrt_points *p, float *radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    for (int a = 0; a < 3; a++) radiance[a][i] = p->normal[a][i] * (p->normal[a][i] < 0 ? -0.5f : 0.25f);
  }
}

static void sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const float up = direction[1][i] < 0 ? 0.125f : direction[1][i];
    radiance[0][i] = radiance[1][i] = up * 0.5f, radiance[2][i] = up;
  }
}

static pktrt_material matt(float red, float green, float blue) {
  pktrt_material m;
  memset(&m, 0, sizeof m);
  m.albedo[0] = red, m.albedo[1] = green, m.albedo[2] = blue;
  return m;
}

static uint32_t add_material(pktrt_scene *s, const pktrt_material *m) {
  uint32_t material = 0;
  expect(s, pktrt_add_material(s, m, &material));
  return material;
}

static void add_light(pktrt_scene *s, pktrt_light_kind kind, float intensity, const float position[3], uint32_t mesh) {
  pktrt_light l;
  memset(&l, 0, sizeof l);
  l.kind = kind, l.mesh = mesh, l.radius = 0.5f;
  l.edge[0][0] = 1, l.edge[1][2] = 1;
  l.direction[0] = 0.5f, l.direction[1] = -1, l.direction[2] = -0.25f;
  for (int a = 0; a < 3; a++) l.intensity[a] = intensity, l.position[a] = position[a];
  expect(s, pktrt_add_light(s, &l, NULL));
}

enum { WIDTH = 28, HEIGHT = 24 };
enum { MIRROR = 1, METAL = 2, LOBES = 4, GLASS = 8, COAT = 16, HOOKS = 32, LAMPS = 64, SMOOTH = 128, MOVING = 256 };

/* A ball, a box and a heap on hills, made of what is asked for, under a point light and perhaps all others. */
static pktrt_scene *room(pktrt_isa isa, uint32_t has) {
  static const float above[3] = {2, 7, 3}, aside[3] = {-5, 5, 4};
  static const int32_t lamp_middle[3] = {3 * UNIT, 5 * UNIT, -UNIT};
  pktrt_scene *s = scene_open(isa);
  pktrt_material ground = matt(0.75f, 0.625f, 0.5f), ball = matt(0.25f, 0.5f, 0.75f), box = matt(0.5f, 0.25f, 0.125f),
                 scraps = matt(0.75f, 0.125f, 0.25f), lamp = matt(0, 0, 0);
  if (has & HOOKS) ground.texture = checks, scraps.shader = by_normal;
  if (has & COAT) ground.specular = PKTRT_SPECULAR_COAT;
  if (has & MIRROR) {
    box.specular = PKTRT_SPECULAR_MIRROR;
    for (int a = 0; a < 3; a++) box.reflectance[a] = 0.5f;
  }
  if (has & METAL) {
    box.specular = PKTRT_SPECULAR_CONDUCTOR;
    for (int a = 0; a < 3; a++) box.ior[a] = 0.25f + 0.5f * (float)a, box.extinction[a] = 3;
  }
  if (has & GLASS) ball.specular = PKTRT_SPECULAR_DIELECTRIC, ball.ior[0] = 1.5f, ball.absorption[0] = 0.5f;
  if (has & LOBES) ground.lobe = box.lobe = PKTRT_LOBE_PHONG, ground.exponent = 20, box.exponent = 200;
  for (int a = 0; a < 3; a++) lamp.emission[a] = 8;
  const uint32_t of_ground = add_material(s, &ground), of_ball = add_material(s, &ball), of_box = add_material(s, &box);
  const uint32_t of_scraps = add_material(s, &scraps), of_lamp = add_material(s, &lamp);
  const bool smooth = (has & SMOOTH) != 0, moving = (has & MOVING) != 0;
  add_shape(s, hills(12, 6 * UNIT / 12 * 12, 0, UNIT / 6, 7), of_ground, smooth);
  add_shape(s, a_ball(), of_ball, smooth);
  add_shape(s, moving ? moved(a_box(), 2, UNIT / 2, 0, 8) : a_box(), of_box, false);
  add_shape(s, moving ? moved(heap(40, 9), 3, UNIT / 4, UNIT / 8, 10) : heap(40, 9), of_scraps, false);
  add_light(s, PKTRT_LIGHT_POINT, 60, above, 0);
  if (has & LAMPS) {
    const uint32_t mesh = add_shape(s, cube(lamp_middle, UNIT / 2, 2, true), of_lamp, false);
    add_light(s, PKTRT_LIGHT_MESH, 1, above, mesh);
    add_light(s, PKTRT_LIGHT_QUAD, 4, aside, 0);
    add_light(s, PKTRT_LIGHT_SPHERE, 4, aside, 0);
    add_light(s, PKTRT_LIGHT_DIRECTIONAL, 0.5f, aside, 0);
    add_light(s, PKTRT_LIGHT_ENVIRONMENT, 1, aside, 0);
  }
  expect(s, pktrt_commit(s));
  return s;
}

static pktrt_render_desc view_of(pktrt_mode mode, uint32_t samples) {
  pktrt_render_desc d;
  memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = WIDTH, d.height = HEIGHT, d.mode = mode, d.samples = samples, d.seed = SCENES_SEED;
  d.camera.eye[0] = 1, d.camera.eye[1] = 4, d.camera.eye[2] = 8, d.camera.target[1] = 1.5f, d.camera.fov_y = 50;
  for (int a = 0; a < 3; a++) d.ambient[a] = 0.125f, d.background[a] = 0.25f;
  d.max_depth = 6;
  return d;
}

#endif
