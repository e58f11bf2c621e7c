/* scatter.h - pictures of one thing by several seeds, and what their scatter tells; and a stage whose shading is
   smooth, with its truth in closed form.

   Contents: piles, intervals, soft shadow. */
#ifndef ERROR_SCATTER_H
#define ERROR_SCATTER_H

#include "error.h"

/* >>piles ---------------------------------------------------------------------------------------------------------- */

typedef struct pile { /* pictures of the same size */
  float *pixels;
  size_t values; /* of a picture: pixels * 3 */
  unsigned count;
} pile;

static pile pile_of(size_t values, unsigned count) {
  pile p;
  p.values = values, p.count = count;
  p.pixels = (float *)calloc(values * count, sizeof(float));
  if (!p.pixels) fatal("not enough memory");
  return p;
}

static float *pile_at(const pile *p, unsigned i) { return p->pixels + p->values * i; }

enum { NOBODY = 0xFFFF };

/* Mean over values of the variance between pictures, without picture `left_out`. Where samplers have no bias this is
   the mean squared error of one picture, and needs no truth. */
EX_UNUSED static double pile_variance(const pile *p, unsigned left_out) {
  const double n = p->count - (left_out < p->count);
  double total = 0;
  for (size_t v = 0; v < p->values; v++) {
    const double middle = (double)p->pixels[v]; /* of differences from one of them: equal pictures give exactly 0 */
    double sum = 0, squares = 0;
    for (unsigned i = 0; i < p->count; i++) {
      const double x = i == left_out ? 0 : (double)p->pixels[p->values * i + v] - middle;
      sum += x, squares += x * x;
    }
    total += (squares - sum * sum / n) / (n - 1);
  }
  return total / (double)p->values;
}

/* A picture of a stage into a pile; by one thread, with statistics if wanted. Returns its seconds. */
static double pile_render(const stage *g, const shot *s, pktrt_stats *stats, const pile *p, unsigned i) {
  pktrt_render_desc d = g->view;
  d.pixels = pile_at(p, i), d.stats = stats;
  d.sampler = s->sampler, d.samples = s->samples, d.passes = s->passes, d.seed = s->seed;
  const double start = cpu_seconds();
  if (pktrt_render(g->world, &d) != PKTRT_OK) fatal(pktrt_last_error(g->world));
  return cpu_seconds() - start;
}

static double pile_mean(const pile *p) {
  double sum = 0;
  for (size_t v = 0; v < p->values * p->count; v++) sum += (double)p->pixels[v];
  return sum / (double)(p->values * p->count);
}

/* >>intervals ------------------------------------------------------------------------------------------------------ */

/* Student's t for 95% and n - 1 degrees of freedom. */
static double student(unsigned n) {
  static const double t[] = {
      12.71, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131};
  return n < 2 ? INFINITY : n - 2 < sizeof t / sizeof *t ? t[n - 2] : 2.1;
}

/* The jackknife: from the figure of all n seeds and those without one of them each, its interval. */
static interval jackknife(double all, const double *without, unsigned n) {
  double mean = 0, squares = 0;
  interval r;
  for (unsigned i = 0; i < n; i++) mean += without[i] / n;
  for (unsigned i = 0; i < n; i++) squares += square(without[i] - mean);
  const double half = student(n) * sqrt(squares * (n - 1) / n);
  r.value = all, r.low = all - half, r.high = all + half;
  return r;
}

/* >>soft shadow ---------------------------------------------------------------------------------------------------- */

/* A white floor at y = 0, a square lamp of edge 2 at height LAMP_Y, and below it at BLOCKER_Y all of x < 0 is covered:
   half a penumbra's width of x is in full light, half in none. The camera looks down from under the cover.

   A point (x, 0, z) sees of the lamp what lies beyond the cover's edge, seen from there: lamp points with
   x_lamp >= x (1 - LAMP_Y / BLOCKER_Y), a rectangle. Radiance is albedo / pi times irradiance, and that of a polygon
   with radiance L is (Lambert 1760) L / 2 times the sum over edges of their angle times the cosine between the floor's
   normal and that of the plane through point and edge. */
#define LAMP_Y 4.0
#define BLOCKER_Y 2.0
#define SOFT_ALBEDO 0.8f
#define SOFT_RADIANCE 5.0f
#define SOFT_EYE_Y 1.9
#define SOFT_FOV 50.0f

static double soft_irradiance(double x, double z) {
  double x0 = x * (1 - LAMP_Y / BLOCKER_Y), sum = 0;
  if (x0 < -1) x0 = -1;
  if (x0 >= 1) return 0;
  const sc_v3 corner[4] = {sc_v(x0 - x, LAMP_Y, -1 - z), sc_v(1 - x, LAMP_Y, -1 - z), sc_v(1 - x, LAMP_Y, 1 - z),
      sc_v(x0 - x, LAMP_Y, 1 - z)};
  for (int i = 0; i < 4; i++) {
    const sc_v3 a = sc_unit(corner[i]), b = sc_unit(corner[(i + 1) % 4]), across = sc_cross(b, a);
    const double sine = sqrt(sc_dot(across, across));
    if (sine > 0) sum += atan2(sine, sc_dot(a, b)) * across.y / sine;
  }
  return 0.5 * (double)SOFT_RADIANCE * sum;
}

/* The mean over a pixel by cells x cells midpoints. */
static double soft_pixel(const stage *g, uint32_t px, uint32_t py, unsigned cells) {
  const double h = SOFT_EYE_Y * tan(0.5 * (double)SOFT_FOV * SC_PI / 180), size = 2 * h / g->view.height;
  double sum = 0;
  for (unsigned j = 0; j < cells; j++)
    for (unsigned i = 0; i < cells; i++) {
      const double across = px + (i + 0.5) / cells - 0.5 * g->view.width;
      const double down = py + (j + 0.5) / cells - 0.5 * g->view.height;
      sum += soft_irradiance(across * size, down * size); /* up is -z, hence right is x */
    }
  return (double)SOFT_ALBEDO / SC_PI * sum / (cells * cells);
}

static void soft_quad(pktrt_scene *world, double x0, double x1, double y, double z, uint32_t material) {
  const float a = (float)x0, b = (float)x1, h = (float)y, c = (float)z;
  const float corners[12] = {a, h, -c, a, h, c, b, h, c, b, h, -c};
  static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
  pktrt_mesh_desc m;
  memset(&m, 0, sizeof m);
  m.positions = corners, m.vertex_count = 4, m.indices = indices, m.triangle_count = 2, m.material = material;
  if (pktrt_add_mesh(world, &m, NULL) != PKTRT_OK) fatal(pktrt_last_error(world));
}

static void open_soft_shadow(stage *g, uint32_t size) {
  pktrt_material white;
  pktrt_light lamp;
  uint32_t number = 0;
  memset(g, 0, sizeof *g), memset(&white, 0, sizeof white), memset(&lamp, 0, sizeof lamp);
  snprintf(g->name, sizeof g->name, "soft shadow");
  stage_world(g);
  lamp.kind = PKTRT_LIGHT_QUAD, lamp.position[0] = lamp.position[2] = -1, lamp.position[1] = (float)LAMP_Y;
  lamp.edge[0][0] = lamp.edge[1][2] = 2; /* x cross z is down */
  for (int c = 0; c < 3; c++) white.albedo[c] = SOFT_ALBEDO, lamp.intensity[c] = SOFT_RADIANCE;
  if (pktrt_add_material(g->world, &white, &number) != PKTRT_OK || pktrt_add_light(g->world, &lamp, NULL) != PKTRT_OK)
    fatal(pktrt_last_error(g->world));
  soft_quad(g->world, -8, 8, 0, 8, number), soft_quad(g->world, -8, 0, BLOCKER_Y, 8, number);
  if (pktrt_commit(g->world) != PKTRT_OK) fatal(pktrt_last_error(g->world));
  stage_room(g, size, size);
  g->view.mode = PKTRT_MODE_DRT;
  g->view.camera.eye[1] = (float)SOFT_EYE_Y, g->view.camera.up[2] = -1, g->view.camera.fov_y = SOFT_FOV;
  for (uint32_t y = 0; y < size; y++)
    for (uint32_t x = 0; x < size; x++) {
      const double v = soft_pixel(g, x, y, 4);
      for (int c = 0; c < 3; c++) g->truth[((size_t)y * size + x) * 3 + (size_t)c] = v;
    }
}

/* How far the truth's quadrature is from one four times as fine, root mean square. */
static double soft_quadrature(const stage *g) {
  double sum = 0;
  for (uint32_t y = 0; y < g->view.height; y += 3)
    for (uint32_t x = 0; x < g->view.width; x += 3) sum += 9 * square(soft_pixel(g, x, y, 4) - soft_pixel(g, x, y, 16));
  return sqrt(sum / (double)stage_pixels(g));
}

#endif /* ERROR_SCATTER_H */
