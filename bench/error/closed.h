/* closed.h - small scenes whose pixels have a closed form, up to a quadrature whose own error is known.

     edge       sectors of a star, antialiased: the area that a polygon has in common with a pixel
     motion     a turned square that moves while the shutter is open: that area, over time
     lens       a half-plane out of focus: the segment that a line cuts off the disk of confusion
     quad       a quad light over a diffuse floor: Lambert's formula for polygons
     penumbra   the same, with a sheet that has an edge between them: the polygon is clipped as the point sees it
     sphere     a sphere light over the floor: pi L (r / d)^2 cos
     sky        a diffuse floor under a sky of which one half, tilted, is bright: (1 + cos) / 2
     gloss      a floor with a Phong lobe under such a sky: the part of the lobe on one side of a plane

   Pixels are integrals over their area. Where the answer at a point is known, Gauss-Legendre quadrature in panels takes
   the rest; the same with panels twice as fine tells its error, which part_closed shows.

   Contents: geometry, scenes in the plane of the picture, scenes on a floor, all of them. */
#ifndef ERROR_CLOSED_H
#define ERROR_CLOSED_H

#include "error.h"

/* >>geometry ------------------------------------------------------------------------------------------------------- */

enum { MAX_CORNERS = 16, SECTORS = 7 };

typedef struct polygon { /* convex */
  unsigned n;
  double p[MAX_CORNERS][3];
} polygon;

/* What is left of it where a.p <= c (Sutherland and Hodgman). */
static polygon clip(const polygon *from, const double a[3], double c) {
  polygon to;
  to.n = 0;
  for (unsigned i = 0; i < from->n; i++) {
    const double *p = from->p[i], *q = from->p[(i + 1) % from->n];
    double off_p = -c, off_q = -c;
    for (int k = 0; k < 3; k++) off_p += a[k] * p[k], off_q += a[k] * q[k];
    if (off_p <= 0 && to.n < MAX_CORNERS) memcpy(to.p[to.n++], p, sizeof to.p[0]);
    if ((off_p < 0 && off_q > 0) || (off_p > 0 && off_q < 0)) {
      const double t = off_p / (off_p - off_q);
      if (to.n == MAX_CORNERS) fatal("a polygon has too many corners");
      for (int k = 0; k < 3; k++) to.p[to.n][k] = p[k] + t * (q[k] - p[k]);
      to.n++;
    }
  }
  return to;
}

/* The area that a polygon in the plane has in common with the unit square at (x, y). */
static double covered(const polygon *shape, double x, double y) {
  const double sides[4][4] = {{-1, 0, 0, -x}, {1, 0, 0, x + 1}, {0, -1, 0, -y}, {0, 1, 0, y + 1}};
  polygon left = *shape;
  double twice = 0;
  for (int i = 0; i < 4; i++) left = clip(&left, sides[i], sides[i][3]);
  for (unsigned i = 0; i < left.n; i++) {
    const double *p = left.p[i], *q = left.p[(i + 1) % left.n];
    twice += p[0] * q[1] - p[1] * q[0];
  }
  return 0.5 * fabs(twice);
}

/* Gauss-Legendre, three points in [-1, 1]: exact up to degree 5. */
static const double gauss_at[3] = {-0.77459666924148337704, 0, 0.77459666924148337704};
static const double gauss_weight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18}; /* of the mean */

typedef struct closed { /* `own` of a stage */
  const char *name;
  double (*at)(
      const stage *, double x, double y); /* radiance at a place of the picture, pixels; or the pixel itself: */
  double (*pixel)(const stage *, double x, double y);
  unsigned panels;
  double edge;            /* of a pixel, at distance 1 */
  polygon shape[SECTORS]; /* in pixels; or the light, in space */
  unsigned shapes;
  double shift[2];                  /* motion, pixels */
  double normal[3], offset, radius; /* line or sky; radius of confusion, sphere */
  float direction[3];               /* of the bright half of the sky, as the hook has it */
} closed;

static const closed *closed_of(const stage *g) { return (const closed *)g->own; }

static double integral(const stage *g, double x, double y, unsigned panels) {
  double sum = 0;
  const double step = 1.0 / panels;
  for (unsigned i = 0; i < panels * panels * 9; i++) {
    const unsigned px = i / 9 % panels, py = i / 9 / panels, gx = i % 3, gy = i / 3 % 3;
    const double u = x + step * (px + 0.5 + 0.5 * gauss_at[gx]), v = y + step * (py + 0.5 + 0.5 * gauss_at[gy]);
    sum += gauss_weight[gx] * gauss_weight[gy] * closed_of(g)->at(g, u, v) * step * step;
  }
  return sum;
}

/* The truth of all pixels. Returns the root mean square of how far panels twice as fine are off. */
static double answer(stage *g) {
  const closed *c = closed_of(g);
  double off = 0;
  for (size_t i = 0; i < stage_pixels(g); i++) {
    const double x = (double)(i % g->view.width), y = (double)(i / g->view.width);
    const double fine = c->pixel ? c->pixel(g, x, y) : integral(g, x, y, 2 * c->panels);
    if (!c->pixel) off += square(fine - integral(g, x, y, c->panels)) / (double)stage_pixels(g);
    for (size_t k = 0; k < 3; k++) g->truth[3 * i + k] = fine;
  }
  return sqrt(off);
}

/* --- building --- */

static void set3(float *to, double x, double y, double z) { to[0] = (float)x, to[1] = (float)y, to[2] = (float)z; }

static uint32_t glowing(stage *g) { /* a material that only shines, white */
  pktrt_material m;
  uint32_t index = 0;
  memset(&m, 0, sizeof m);
  set3(m.emission, 1, 1, 1);
  if (pktrt_add_material(g->world, &m, &index)) fatal(pktrt_last_error(g->world));
  return index;
}

/* A fan of triangles over each of n convex polygons of `corners` corners, in a mesh of `keys` keys. */
static void add_fan(stage *g, const float *positions, uint32_t corners, uint32_t n, uint32_t keys, uint32_t material) {
  uint32_t indices[3 * 64], triangles = 0;
  pktrt_mesh_desc d;
  for (uint32_t k = 0; k < n; k++)
    for (uint32_t i = 2; i < corners; i++, triangles++) {
      uint32_t *t = indices + 3 * triangles;
      t[0] = k * corners, t[1] = t[0] + i - 1, t[2] = t[0] + i;
    }
  memset(&d, 0, sizeof d);
  d.positions = positions, d.vertex_count = corners * n, d.key_count = keys, d.material = material;
  d.indices = indices, d.triangle_count = triangles;
  if (pktrt_add_mesh(g->world, &d, NULL)) fatal(pktrt_last_error(g->world));
}

/* >>scenes in the plane of the picture ----------------------------------------------------------------------------- */

#define DISTANCE 2.0 /* of what is seen, along the view; the camera looks from the origin along -z, x right, y up */

/* From pixels to that plane, and what floats made of it back to pixels. */
static void to_plane(const stage *g, double x, double y, float *to) {
  const double k = DISTANCE * closed_of(g)->edge;
  set3(to, (x - 0.5 * g->view.width) * k, (0.5 * g->view.height - y) * k, -DISTANCE);
}
static void from_plane(const stage *g, const float *p, double *to) {
  const double k = DISTANCE * closed_of(g)->edge;
  to[0] = (double)p[0] / k + 0.5 * g->view.width, to[1] = 0.5 * g->view.height - (double)p[1] / k, to[2] = 0;
}

static void look_ahead(stage *g) { g->view.camera.target[2] = -1, g->view.camera.fov_y = 60; }

static double pixel_of_edge(const stage *g, double x, double y) {
  double sum = 0;
  for (unsigned i = 0; i < closed_of(g)->shapes; i++) sum += covered(&closed_of(g)->shape[i], x, y);
  return sum;
}

static void make_edge(stage *g, closed *c) {
  float p[SECTORS][3][3];
  const double x = 0.5 * g->view.width + 0.3, y = 0.5 * g->view.height - 0.2, r = 0.46 * g->view.height;
  look_ahead(g);
  for (int i = 0; i < SECTORS; i++) {
    const double from = 360.0 / SECTORS * i + 11, to = from + 180.0 / SECTORS;
    to_plane(g, x, y, p[i][0]);
    to_plane(g, x + r * sc_cos(from), y + r * sc_sin(from), p[i][1]);
    to_plane(g, x + r * sc_cos(to), y + r * sc_sin(to), p[i][2]);
    c->shape[i].n = 3;
    for (int k = 0; k < 3; k++) from_plane(g, p[i][k], c->shape[i].p[k]);
  }
  c->shapes = SECTORS, c->pixel = pixel_of_edge;
  add_fan(g, &p[0][0][0], 3, SECTORS, 1, glowing(g));
}

static double covered_at(const stage *g, double x, double y, double t) {
  const closed *c = closed_of(g);
  return covered(&c->shape[0], x - t * c->shift[0], y - t * c->shift[1]);
}

/* The moment when a point that moves by -shift meets the line through p and q, if within (0, 1). */
static void add_moment(
    const double from[2], const double shift[2], const double *p, const double *q, double *moments, unsigned *n) {
  const double nx = q[1] - p[1], ny = p[0] - q[0], speed = nx * shift[0] + ny * shift[1];
  if (speed == 0) return;
  const double t = (nx * (from[0] - p[0]) + ny * (from[1] - p[1])) / speed;
  if (t > 0 && t < 1) moments[(*n)++] = t;
}

/* Between the moments when a corner of one crosses an edge of the other, the area is a polynomial of degree 2 in time,
   of which three Gauss points leave nothing. */
static double pixel_of_motion(const stage *g, double x, double y) {
  const closed *c = closed_of(g);
  const double square_at[4][2] = {{x, y}, {x + 1, y}, {x + 1, y + 1}, {x, y + 1}};
  const double back[2] = {-c->shift[0], -c->shift[1]};
  double moments[2 + 2 * 4 * 4], sum = 0;
  unsigned n = 2;
  moments[0] = 0, moments[1] = 1;
  for (int i = 0; i < 4; i++)
    for (int k = 0; k < 4; k++) {
      add_moment(square_at[i], c->shift, c->shape[0].p[k], c->shape[0].p[(k + 1) % 4], moments, &n);
      add_moment(c->shape[0].p[k], back, square_at[i], square_at[(i + 1) % 4], moments, &n);
    }
  qsort(moments, n, sizeof *moments, compare_doubles);
  for (unsigned i = 0; i + 1 < n; i++)
    for (int k = 0; k < 3; k++) {
      const double length = moments[i + 1] - moments[i], t = moments[i] + 0.5 * length * (1 + gauss_at[k]);
      sum += length * gauss_weight[k] * covered_at(g, x, y, t);
    }
  return sum;
}

static void make_motion(stage *g, closed *c) {
  float p[2][4][3];
  const double x = 0.38 * g->view.width, y = 0.55 * g->view.height, r = 0.3 * g->view.height;
  double end[3];
  look_ahead(g);
  g->view.camera.shutter = 1;
  for (int i = 0; i < 4; i++) {
    const double px = x + r * sc_cos(90.0 * i + 27), py = y + r * sc_sin(90.0 * i + 27);
    to_plane(g, px, py, p[0][i]);
    to_plane(g, px + 0.2 * g->view.width, py - 0.11 * g->view.height, p[1][i]);
    from_plane(g, p[0][i], c->shape[0].p[i]);
  }
  from_plane(g, p[1][0], end);
  for (int a = 0; a < 2; a++) c->shift[a] = end[a] - c->shape[0].p[0][a];
  c->shape[0].n = 4, c->shapes = 1, c->pixel = pixel_of_motion;
  add_fan(g, &p[0][0][0], 4, 1, 2, glowing(g));
}

/* Of the disk around (x, y), the part where normal.p < offset: a segment whose line lies s radii from the middle. */
static double lens_at(const stage *g, double x, double y) {
  const closed *c = closed_of(g);
  const double s = (c->offset - c->normal[0] * x - c->normal[1] * y) / c->radius;
  if (s >= 1 || s <= -1) return s > 0;
  return 0.5 + (s * sqrt(1 - s * s) + asin(s)) / SC_PI;
}

/* A point l of the lens (disk of diameter a) sees through a place of the picture, sharp at distance f, the plane at
   distance d as far beside as l (1 - d / f): the disk of confusion. */
static void make_lens(stage *g, closed *c) {
  float p[4][3];
  double corner[4][3];
  const double w = g->view.width, x = 0.5 * w + 0.17, y = 0.5 * g->view.height + 0.31;
  const double along[2] = {sc_cos(64), sc_sin(64)}, aside[2] = {along[1], -along[0]};
  look_ahead(g);
  g->view.camera.focus = 1.25f, g->view.camera.aperture = (float)(0.5 * w * c->edge);
  c->radius = 0.5 * (double)g->view.camera.aperture * (DISTANCE / 1.25 - 1) / (DISTANCE * c->edge);
  for (int i = 0; i < 4; i++) {
    const double k = 3 * w * (i == 0 || i == 3 ? -1 : 1), j = i < 2 ? 0 : 3 * w;
    to_plane(g, x + k * along[0] + j * aside[0], y + k * along[1] + j * aside[1], p[i]);
    from_plane(g, p[i], corner[i]);
  }
  c->normal[0] = -(corner[1][1] - corner[0][1]), c->normal[1] = corner[1][0] - corner[0][0];
  const double length = sqrt(square(c->normal[0]) + square(c->normal[1]));
  for (int a = 0; a < 2; a++) c->normal[a] /= length, c->offset += c->normal[a] * corner[0][a];
  c->at = lens_at, c->panels = 16;
  add_fan(g, &p[0][0], 4, 1, 1, glowing(g));
}

/* >>scenes on a floor ---------------------------------------------------------------------------------------------- */

#define ALBEDO 0.75
#define LIGHT_HEIGHT 3.0
#define SHEET_HEIGHT 1.5
#define LIGHT_RADIANCE 4.0

/* The ray through a place of the picture: its direction, and where it meets the floor, y = 0. */
static void look_down(const stage *g, double x, double y, double direction[3], double at[3]) {
  const pktrt_camera *c = &g->view.camera;
  const double k = closed_of(g)->edge, u = (x - 0.5 * g->view.width) * k, v = (0.5 * g->view.height - y) * k;
  const sc_v3 eye = sc_v((double)c->eye[0], (double)c->eye[1], (double)c->eye[2]);
  const sc_v3 ahead = sc_unit(sc_sub(sc_v((double)c->target[0], (double)c->target[1], (double)c->target[2]), eye));
  const sc_v3 right = sc_unit(sc_cross(ahead, sc_v(0, 1, 0))), up = sc_cross(right, ahead);
  const sc_v3 d = sc_unit(sc_add(ahead, sc_add(sc_mul(right, u), sc_mul(up, v))));
  const sc_v3 p = sc_add(eye, sc_mul(d, -eye.y / d.y));
  direction[0] = d.x, direction[1] = d.y, direction[2] = d.z;
  at[0] = p.x, at[1] = p.y, at[2] = p.z;
}

static void make_floor(stage *g, bool glossy) {
  static const float corners[4][3] = {{-8, 0, -8}, {-8, 0, 8}, {8, 0, 8}, {8, 0, -8}};
  pktrt_material m;
  uint32_t index = 0;
  memset(&m, 0, sizeof m);
  if (glossy) {
    m.specular = PKTRT_SPECULAR_MIRROR, m.lobe = PKTRT_LOBE_PHONG, m.exponent = 64;
    set3(m.reflectance, ALBEDO, ALBEDO, ALBEDO);
  } else set3(m.albedo, ALBEDO, ALBEDO, ALBEDO);
  if (pktrt_add_material(g->world, &m, &index)) fatal(pktrt_last_error(g->world));
  add_fan(g, &corners[0][0], 4, 1, 1, index);
  set3(g->view.camera.eye, 0.3, 1.25, 1.5), set3(g->view.camera.target, 0.1, 0, 0.1);
  g->view.camera.fov_y = 60;
}

/* Irradiance of a floor by a polygon of radiance 1 (Lambert): half the sum over its edges of the angle in which one is
   seen, times the vertical component of the unit normal of the triangle that it makes with the point. */
static double irradiance(const polygon *light, const double from[3]) {
  double sum = 0;
  for (unsigned i = 0; i < light->n; i++) {
    const double *p = light->p[i], *q = light->p[(i + 1) % light->n];
    const sc_v3 a = sc_unit(sc_v(p[0] - from[0], p[1] - from[1], p[2] - from[2]));
    const sc_v3 b = sc_unit(sc_v(q[0] - from[0], q[1] - from[1], q[2] - from[2])), n = sc_cross(a, b);
    const double sine = sqrt(sc_dot(n, n));
    if (sine > 0) sum += atan2(sine, sc_dot(a, b)) * n.y / sine;
  }
  return 0.5 * fabs(sum);
}

static double quad_at(const stage *g, double x, double y) {
  double direction[3], at[3];
  look_down(g, x, y, direction, at);
  return ALBEDO / SC_PI * LIGHT_RADIANCE * irradiance(&closed_of(g)->shape[0], at);
}

/* The sheet is met half way to the light: where the mean of point and place on the light lies before its edge. */
static double penumbra_at(const stage *g, double x, double y) {
  const closed *c = closed_of(g);
  const double k = SHEET_HEIGHT / LIGHT_HEIGHT;
  double direction[3], at[3], a[3], off = c->offset;
  look_down(g, x, y, direction, at);
  for (int i = 0; i < 3; i++) a[i] = k * c->normal[i], off -= (1 - k) * c->normal[i] * at[i];
  const polygon seen = clip(&c->shape[0], a, off);
  return ALBEDO / SC_PI * LIGHT_RADIANCE * irradiance(&seen, at);
}

static void make_quad(stage *g, closed *c) {
  pktrt_light l;
  make_floor(g, false);
  memset(&l, 0, sizeof l);
  l.kind = PKTRT_LIGHT_QUAD;
  set3(l.position, -0.7, LIGHT_HEIGHT, -0.9), set3(l.edge[0], 1.5, 0, 0.3), set3(l.edge[1], -0.2, 0, 1.25);
  set3(l.intensity, LIGHT_RADIANCE, LIGHT_RADIANCE, LIGHT_RADIANCE);
  if (pktrt_add_light(g->world, &l, NULL)) fatal(pktrt_last_error(g->world));
  for (unsigned i = 0; i < 4; i++)
    for (int a = 0; a < 3; a++)
      c->shape[0].p[i][a] =
          (double)l.position[a] + (i == 1 || i == 2 ? (double)l.edge[0][a] : 0) + (i >= 2 ? (double)l.edge[1][a] : 0);
  c->shape[0].n = 4, c->shapes = 1, c->at = quad_at, c->panels = 2;
  if ((double)l.edge[0][2] * (double)l.edge[1][0] - (double)l.edge[0][0] * (double)l.edge[1][2] > 0)
    fatal("the light shines up");
}

static void make_penumbra(stage *g, closed *c) {
  float p[4][3];
  const double along[2] = {sc_cos(28), sc_sin(28)}, aside[2] = {-along[1], along[0]};
  make_quad(g, c);
  for (int i = 0; i < 4; i++) {
    const double k = i == 0 || i == 3 ? -5 : 5, j = i < 2 ? 0 : 5;
    set3(p[i], 0.1 + k * along[0] + j * aside[0], SHEET_HEIGHT, k * along[1] + j * aside[1]);
  }
  add_fan(g, &p[0][0], 4, 1, 1, 0);
  c->normal[0] = -((double)p[1][2] - (double)p[0][2]), c->normal[2] = (double)p[1][0] - (double)p[0][0];
  c->offset = c->normal[0] * (double)p[0][0] + c->normal[2] * (double)p[0][2];
  c->at = penumbra_at, c->panels = 16;
}

static double sphere_at(const stage *g, double x, double y) {
  const closed *c = closed_of(g);
  double direction[3], at[3], d2 = 0;
  look_down(g, x, y, direction, at);
  for (int a = 0; a < 3; a++) d2 += square(c->normal[a] - at[a]);
  return ALBEDO * LIGHT_RADIANCE * square(c->radius) / d2 * c->normal[1] / sqrt(d2);
}

static void make_sphere(stage *g, closed *c) {
  pktrt_light l;
  make_floor(g, false);
  memset(&l, 0, sizeof l);
  l.kind = PKTRT_LIGHT_SPHERE, l.radius = 0.75f;
  set3(l.position, -0.3, 1.5, -0.4), set3(l.intensity, LIGHT_RADIANCE, LIGHT_RADIANCE, LIGHT_RADIANCE);
  if (pktrt_add_light(g->world, &l, NULL)) fatal(pktrt_last_error(g->world));
  for (int a = 0; a < 3; a++) c->normal[a] = (double)l.position[a];
  c->radius = (double)l.radius, c->at = sphere_at, c->panels = 2;
}

/* --- under half a sky --- */

static void half_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  const closed *c = (const closed *)user;
  for (uint32_t i = 0; i < n; i++) {
    const float side =
        direction[0][i] * c->direction[0] + direction[1][i] * c->direction[1] + direction[2][i] * c->direction[2];
    for (int a = 0; a < 3; a++) radiance[a][i] = side > 0 ? 1.0f : 0.0f;
  }
}

static void under_sky(stage *g, closed *c, double x, double y, double z) {
  const sc_v3 w = sc_unit(sc_v(x, y, z));
  set3(c->direction, w.x, w.y, w.z);
  c->normal[0] = w.x, c->normal[1] = w.y, c->normal[2] = w.z;
  g->view.environment = half_sky, g->view.user = c;
}

static double sky_at(const stage *g, double x, double y) {
  (void)x, (void)y;
  return ALBEDO * 0.5 * (1 + closed_of(g)->normal[1]); /* a lune between the floor and the sky's border */
}

static void make_sky(stage *g, closed *c) {
  pktrt_light l;
  make_floor(g, false);
  memset(&l, 0, sizeof l);
  l.kind = PKTRT_LIGHT_ENVIRONMENT;
  set3(l.intensity, 1, 1, 1);
  if (pktrt_add_light(g->world, &l, NULL)) fatal(pktrt_last_error(g->world));
  under_sky(g, c, 0.8, 0.35, 0.5);
  c->at = sky_at, c->panels = 1;
}

/* The part of a Phong lobe where d.w > 0, its axis rising by `angle` above that plane: with v = cos^(exponent+1), which
   is uniform, all of the circle of directions at angle t lies there as long as t < angle, then 1 - acos(tan(angle) /
   tan(t)) / pi of it. v = v0 (1 - s^2) takes the root out of the border. */
static double lobe_part(double sine, double exponent) {
  enum { PANELS = 24 };
  const double above = fabs(sine), cosine = sqrt(1 - above * above), v0 = pow(cosine, exponent + 1);
  double sum = 1 - v0;
  for (int i = 0; i < PANELS * 3; i++) {
    const double s = (i / 3 + 0.5 + 0.5 * gauss_at[i % 3]) / PANELS, v = v0 * (1 - s * s);
    const double k = pow(v, 1 / (exponent + 1)), ratio = above / cosine * k / sqrt(1 - k * k);
    sum += gauss_weight[i % 3] / PANELS * 2 * s * v0 * (1 - acos(fmin(1, ratio)) / SC_PI);
  }
  return sine < 0 ? 1 - sum : sum;
}

static double gloss_at(const stage *g, double x, double y) {
  const closed *c = closed_of(g);
  double d[3], at[3];
  look_down(g, x, y, d, at);
  return ALBEDO * lobe_part(c->normal[0] * d[0] - c->normal[1] * d[1] + c->normal[2] * d[2], 64);
}

/* Seen steeply: of the lobe, what would go below the floor is less than 1e-9. */
static void make_gloss(stage *g, closed *c) {
  make_floor(g, true);
  set3(g->view.camera.eye, 0.2, 2, 0.6);
  g->view.camera.fov_y = 45;
  under_sky(g, c, 0.9, 0.2, 0.55);
  c->at = gloss_at, c->panels = 2;
}

/* >>all of them ---------------------------------------------------------------------------------------------------- */

static const struct closed_scene {
  const char *name;
  void (*make)(stage *, closed *);
} closed_scenes[] = {{"edge", make_edge}, {"motion", make_motion}, {"lens", make_lens}, {"quad", make_quad},
    {"penumbra", make_penumbra}, {"sphere", make_sphere}, {"sky", make_sky}, {"gloss", make_gloss}};
enum { CLOSED_SCENES = sizeof closed_scenes / sizeof *closed_scenes };

/* *g must stay where it is. Returns the error of the truth, see `answer`. */
static double closed_open(stage *g, unsigned which, uint32_t width, uint32_t height) {
  closed *c = (closed *)calloc(1, sizeof *c);
  if (!c) fatal("not enough memory");
  memset(g, 0, sizeof *g);
  snprintf(g->name, sizeof g->name, "%s", closed_scenes[which].name);
  stage_world(g);
  stage_room(g, width, height);
  g->own = c;
  g->view.mode = PKTRT_MODE_DRT, g->view.attenuation = -1;
  c->edge = (which + 1 == CLOSED_SCENES ? 2 * (sqrt(2) - 1) : 2 / sqrt(3)) / height; /* fov_y of 45 and 60 degrees */
  closed_scenes[which].make(g, c);
  if (pktrt_commit(g->world)) fatal(pktrt_last_error(g->world));
  return answer(g);
}

#endif /* ERROR_CLOSED_H */
