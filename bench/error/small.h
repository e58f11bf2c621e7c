/* small.h - eight small scenes, each with one thing that makes noise: soft shadows, a sky with a sun, glass and metal,
   forty lamps, lights out of focus, motion, mirrors that see each other, and edges. Their truth is that of the same scene
   with many passes.

   Contents: building, scenes, all of them. */
#ifndef ERROR_SMALL_H
#define ERROR_SMALL_H

#include "error.h"

/* >>building ------------------------------------------------------------------------------------------------------- */

static void small_three(float *to, double x, double y, double z) {
  to[0] = (float)x;
  to[1] = (float)y;
  to[2] = (float)z;
}

/* A diffuse material of a grey. */
static pktrt_material small_grey(double albedo) {
  pktrt_material m;
  memset(&m, 0, sizeof m);
  small_three(m.albedo, albedo, albedo, albedo);
  return m;
}

/* A mirror of the given reflectance; exponent 0: ideal. */
static pktrt_material small_mirror(double reflectance, double exponent) {
  pktrt_material m = small_grey(0);
  m.specular = PKTRT_SPECULAR_MIRROR;
  small_three(m.reflectance, reflectance, reflectance, reflectance);
  m.lobe = exponent > 0 ? PKTRT_LOBE_PHONG : PKTRT_LOBE_IDEAL;
  m.exponent = (float)exponent;
  return m;
}

static pktrt_material small_glass(void) {
  pktrt_material m = small_grey(0);
  m.specular = PKTRT_SPECULAR_DIELECTRIC;
  small_three(m.absorption, 0.1, 0.3, 0.4);
  return m;
}

static pktrt_material small_metal(double exponent) {
  pktrt_material m = small_grey(0);
  m.specular = PKTRT_SPECULAR_CONDUCTOR;
  small_three(m.ior, 0.2, 0.6, 1.3);
  small_three(m.extinction, 3.6, 2.7, 2.1);
  m.lobe = PKTRT_LOBE_PHONG;
  m.exponent = (float)exponent;
  return m;
}

static pktrt_material small_shine(double radiance) {
  pktrt_material m = small_grey(0);
  small_three(m.emission, radiance, 0.8 * radiance, 0.6 * radiance);
  return m;
}

static uint32_t small_material(const stage *g, pktrt_material m) {
  uint32_t index = 0;
  if (pktrt_add_material(g->world, &m, &index)) fatal(pktrt_last_error(g->world));
  return index;
}

/* Adds a mesh of vertices at `positions`; with two keys the second is moved by `shift`. */
static void small_mesh(const stage *g, const float *positions, uint32_t vertices, const uint32_t *indices,
    uint32_t triangles, const double shift[3], pktrt_material m) {
  enum { MOST = 1024 };
  static float keys[2 * MOST * 3];
  pktrt_mesh_desc d;
  if (vertices > MOST) fatal("a mesh has too many vertices");
  for (uint32_t i = 0; i < vertices * 3; i++) {
    keys[i] = positions[i];
    keys[vertices * 3 + i] = positions[i] + (shift ? (float)shift[i % 3] : 0.0f);
  }
  memset(&d, 0, sizeof d);
  d.positions = keys;
  d.vertex_count = vertices;
  d.key_count = shift ? 2 : 1;
  d.indices = indices;
  d.triangle_count = triangles;
  d.material = small_material(g, m);
  if (pktrt_add_mesh(g->world, &d, NULL)) fatal(pktrt_last_error(g->world));
}

/* A parallelogram from a corner along two sides. */
static void small_quad(const stage *g, const double at[3], const double u[3], const double v[3], pktrt_material m) {
  static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
  float p[12];
  for (int i = 0; i < 4; i++)
    for (int a = 0; a < 3; a++) p[3 * i + a] = (float)(at[a] + (i == 1 || i == 2 ? u[a] : 0) + (i >= 2 ? v[a] : 0));
  small_mesh(g, p, 4, indices, 2, NULL, m);
}

static void small_floor(const stage *g, pktrt_material m) {
  const double at[3] = {-20, 0, 20}, u[3] = {40, 0, 0}, v[3] = {0, 0, -40};
  small_quad(g, at, u, v, m);
}

static void small_box(
    const stage *g, double x, double y, double z, double r, double h, const double shift[3], pktrt_material m) {
  static const uint32_t indices[36] = {
      0, 1, 3, 0, 3, 2, 4, 6, 7, 4, 7, 5, 0, 4, 5, 0, 5, 1, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 5, 7, 1, 7, 3};
  float p[24];
  for (int i = 0; i < 8; i++) small_three(p + 3 * i, x + (i & 1 ? r : -r), y + (i & 2 ? h : 0), z + (i & 4 ? r : -r));
  small_mesh(g, p, 8, indices, 12, shift, m);
}

/* A ball of 16 x 24 faces, counter-clockwise from outside. */
static void small_ball(
    const stage *g, double x, double y, double z, double r, const double shift[3], pktrt_material m) {
  enum { ROWS = 16, SEGMENTS = 24 };
  float p[(ROWS + 1) * SEGMENTS * 3];
  uint32_t indices[ROWS * SEGMENTS * 6], n = 0;
  for (int i = 0; i <= ROWS; i++)
    for (int k = 0; k < SEGMENTS; k++) {
      const double theta = 180.0 * i / ROWS, phi = 360.0 * k / SEGMENTS;
      small_three(p + 3 * (i * SEGMENTS + k), x + r * sc_sin(theta) * sc_cos(phi), y + r * sc_cos(theta),
          z + r * sc_sin(theta) * sc_sin(phi));
    }
  for (uint32_t i = 0; i < ROWS; i++)
    for (uint32_t k = 0; k < SEGMENTS; k++) {
      const uint32_t a = i * SEGMENTS + k, b = i * SEGMENTS + (k + 1) % SEGMENTS, c = a + SEGMENTS, e = b + SEGMENTS;
      const uint32_t corners[6] = {a, b, c, b, e, c};
      for (int q = 0; q < 6; q++) indices[n++] = corners[q];
    }
  small_mesh(g, p, (ROWS + 1) * SEGMENTS, indices, n / 3, shift, m);
}

static void small_light(const stage *g, const pktrt_light *l) {
  if (pktrt_add_light(g->world, l, NULL)) fatal(pktrt_last_error(g->world));
}

/* A lamp of edges `size` at height y, which shines down. */
static void small_panel(const stage *g, double x, double y, double z, double size, double radiance) {
  pktrt_light l;
  memset(&l, 0, sizeof l);
  l.kind = PKTRT_LIGHT_QUAD;
  small_three(l.position, x - 0.5 * size, y, z - 0.5 * size);
  small_three(l.edge[0], size, 0, 0);
  small_three(l.edge[1], 0, 0, size);
  small_three(l.intensity, radiance, radiance, 0.9 * radiance);
  l.visible = true;
  small_light(g, &l);
}

static void small_bulb(const stage *g, double x, double y, double z, double r, double radiance, bool visible) {
  pktrt_light l;
  memset(&l, 0, sizeof l);
  l.kind = PKTRT_LIGHT_SPHERE;
  small_three(l.position, x, y, z);
  small_three(l.intensity, radiance, 0.8 * radiance, 0.5 * radiance);
  l.radius = (float)r;
  l.visible = visible;
  small_light(g, &l);
}

static void small_look(stage *g, double x, double y, double z, double at_y, double fov) {
  small_three(g->view.camera.eye, x, y, z);
  small_three(g->view.camera.target, 0, at_y, 0);
  g->view.camera.fov_y = (float)fov;
}

/* >>scenes --------------------------------------------------------------------------------------------------------- */

static void make_soft(stage *g) {
  small_floor(g, small_grey(0.7));
  for (int i = 0; i < 3; i++) small_box(g, 1.6 * (i - 1), 0, -0.5 * i, 0.4, 0.8 + 0.5 * i, NULL, small_grey(0.6));
  small_ball(g, 0.9, 0.5, 1.2, 0.5, NULL, small_grey(0.5));
  small_panel(g, -1.5, 4, 1, 1.6, 6);
  small_panel(g, 2, 3.5, 0.5, 0.8, 10);
  small_look(g, 0.5, 3, 6, 0.4, 42);
}

static void small_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const float up = direction[1][i] > 0 ? direction[1][i] : 0;
    const float to_sun = 0.48f * direction[0][i] + 0.64f * direction[1][i] + 0.6f * direction[2][i];
    for (int c = 0; c < 3; c++)
      radiance[c][i] = 0.4f + (c == 2 ? 0.6f : 0.2f) * up + (to_sun > 0.9995f ? 900.0f : 0.0f);
  }
}

static void make_under_sky(stage *g) {
  pktrt_light l;
  pktrt_material coat = small_grey(0.3);
  memset(&l, 0, sizeof l);
  l.kind = PKTRT_LIGHT_ENVIRONMENT;
  small_three(l.intensity, 1, 1, 1);
  small_light(g, &l);
  coat.specular = PKTRT_SPECULAR_COAT;
  coat.lobe = PKTRT_LOBE_PHONG;
  coat.exponent = 200;
  small_floor(g, small_grey(0.4));
  small_ball(g, -1.2, 0.8, 0, 0.8, NULL, coat);
  small_ball(g, 1.1, 0.7, 0.4, 0.7, NULL, small_grey(0.7));
  small_box(g, 0.2, 0, -1.6, 0.6, 2, NULL, small_mirror(0.8, 40));
  g->view.environment = small_sky;
  small_look(g, 0, 1.8, 6, 0.8, 42);
}

static void make_glass(stage *g) {
  small_floor(g, small_grey(0.6));
  small_ball(g, -1.3, 0.8, 0.3, 0.8, NULL, small_glass());
  small_ball(g, 0.3, 0.7, -0.8, 0.7, NULL, small_metal(300));
  small_ball(g, 1.6, 0.8, 0.5, 0.8, NULL, small_metal(20));
  small_box(g, 0.3, 0, 1.4, 0.3, 0.6, NULL, small_glass());
  small_panel(g, 0, 4, 0, 1.2, 12);
  small_bulb(g, -2.5, 2.5, 1.5, 0.12, 250, true);
  small_look(g, 0, 2.2, 6, 0.6, 42);
}

static void make_forty(stage *g) {
  uint32_t random = 1847;
  small_floor(g, small_grey(0.6));
  for (int i = 0; i < 4; i++) small_box(g, 1.5 * i - 2.2, 0, 0.8 * (i % 2), 0.35, 0.6 + 0.4 * i, NULL, small_grey(0.6));
  for (int i = 0; i < 40; i++) {
    const double x = 8 * sc_random(&random) - 4, z = 6 * sc_random(&random) - 3, y = 0.7 + 2 * sc_random(&random);
    const double r = 0.03 + 0.05 * sc_random(&random);
    small_bulb(g, x, y, z, r, 0.02 / (r * r * (0.03 + sc_random(&random))), i % 2 != 0);
  }
  g->view.lights = PKTRT_LIGHTS_ONE;
  small_look(g, 0, 3, 6.5, 0.5, 45);
}

static void make_blurred(stage *g) {
  uint32_t random = 77;
  small_floor(g, small_grey(0.2));
  for (int i = 0; i < 24; i++) {
    const double at[3] = {10 * sc_random(&random) - 5, 0.3 + 4 * sc_random(&random), -4 - 4 * sc_random(&random)};
    const double size = 0.03 + 0.1 * sc_random(&random), u[3] = {size, 0, 0}, v[3] = {0, size, 0};
    small_quad(g, at, u, v, small_shine(60));
  }
  small_ball(g, 0.4, 0.8, 2, 0.5, NULL, small_grey(0.6));
  small_panel(g, 0, 4, 2, 1, 4);
  small_look(g, 0, 1.4, 6, 1.2, 40);
  g->view.camera.aperture = 0.5f;
  g->view.camera.focus = 4;
}

static void make_moving(stage *g) {
  const double fast[3] = {1.8, 0.3, 0}, slow[3] = {0.2, 0, 0.4}, glint[3] = {1.2, 0.9, 0};
  small_floor(g, small_grey(0.6));
  small_box(g, -1.8, 0.1, 0.3, 0.4, 1, fast, small_grey(0.8));
  small_ball(g, 1.2, 0.8, -0.8, 0.7, slow, small_grey(0.5));
  small_ball(g, -0.4, 1, 1.4, 0.06, glint, small_shine(80));
  small_panel(g, 0, 4, 1, 1.5, 7);
  g->view.camera.shutter = 1;
  small_look(g, 0, 2, 6, 0.8, 42);
}

static void make_mirrors(stage *g) {
  const double left[3] = {-2.5, 0, 3}, right[3] = {2.5, 0, 3}, back[3] = {-2.5, 0, -3}, up[3] = {0, 3, 0};
  const double away[3] = {0, 0, -6}, across[3] = {5, 0, 0};
  small_floor(g, small_grey(0.5));
  small_quad(g, left, away, up, small_mirror(0.85, 0));
  small_quad(g, right, up, away, small_mirror(0.85, 0));
  small_quad(g, back, across, up, small_mirror(0.7, 400));
  small_ball(g, -0.9, 0.7, 0, 0.7, NULL, small_mirror(0.9, 0));
  small_ball(g, 0.9, 0.6, 0.6, 0.6, NULL, small_mirror(0.8, 100));
  small_bulb(g, 0.2, 2.4, 0.2, 0.1, 120, true);
  small_look(g, 0, 1.6, 5, 0.9, 48);
}

static void make_edges(stage *g) {
  uint32_t random = 5;
  for (int i = 0; i < 40; i++) {
    const double turn = 360 * sc_random(&random), size = 0.05 + 0.4 * sc_random(&random);
    const double at[3] = {5 * sc_random(&random) - 2.5, 4 * sc_random(&random) - 2, -2 * sc_random(&random)};
    const double u[3] = {2 * size * sc_cos(turn), 2 * size * sc_sin(turn), 0};
    const double v[3] = {-0.1 * sc_sin(turn), 0.1 * sc_cos(turn), 0};
    small_quad(g, at, u, v, small_shine(0.2 + 2 * sc_random(&random)));
  }
  small_look(g, 0, 0, 5, 0, 42);
}

/* >>all of them ---------------------------------------------------------------------------------------------------- */

static const struct small_scene {
  const char *name;
  void (*make)(stage *);
} small_scenes[] = {{"soft shadows", make_soft}, {"sun and sky", make_under_sky}, {"glass", make_glass},
    {"forty lamps", make_forty}, {"out of focus", make_blurred}, {"moving", make_moving}, {"mirrors", make_mirrors},
    {"edges", make_edges}};
static const char *const small_built_in[] = {"poolhall", "conference", "rtrt"};
enum { SMALL_MADE = sizeof small_scenes / sizeof *small_scenes, SMALL_SCENES = SMALL_MADE + 3 };

/* Opens one of the eight, or of the three that are built in, without its truth. *g must stay where it is. */
static void small_open(stage *g, unsigned which, uint32_t width, uint32_t height) {
  if (which >= SMALL_MADE) {
    stage_open(g, small_built_in[which - SMALL_MADE], PKTRT_MODE_DRT, width, height);
    return;
  }
  stage_open_made(g, small_scenes[which].name, small_scenes[which].make, width, height);
}

#endif /* ERROR_SMALL_H */
