/* Where a mesh is seen from, and its light, where a file says neither; and both, where it does. Include after
   mesh_file.h. */
#ifndef EXAMPLES_MESH_VIEW_H
#define EXAMPLES_MESH_VIEW_H

#include "mesh_file.h"

typedef struct mesh_view {
  const char *name; /* for what is said */
  double aspect;    /* width over height */
  bool up_z, field; /* a field of instances */
  bool lit;         /* by an environment */
} mesh_view;

/* >>frame ---------------------------------------------------------------------------------------------------------- */

/* How far floats about x are apart. */
static double mesh_view_spacing(double x) {
  int exponent = 0;
  frexp(x, &exponent);
  return ldexp(1, (x > 0 && exponent > -125 ? exponent : -125) - 24);
}

/* Where one looks from: the front, a little right and above, upon a field more from above. */
static const double *mesh_view_eye_direction(const mesh_view *v) {
  static const double from[2][2][3] = {{{0.45, 0.35, 0.82}, {0.45, -0.82, 0.35}}, /* y up, z up */
      {{0.35, 0.6, 0.72}, {0.35, -0.72, 0.6}}};
  return from[v->field][v->up_z];
}

/* From the other side where the eye would lie beyond the largest coordinate. False: there, too. */
static bool mesh_view_place_eye(const double center[3], double distance, const double from[3], pktrt_camera *camera) {
  const double most = (double)PKTRT_MAX_COORD;
  for (int a = 0; a < 3; a++) {
    double eye = center[a] + distance * from[a];
    if (fabs(eye) > most) eye = center[a] - distance * from[a];
    if (fabs(eye) > most) return false;
    camera->eye[a] = (float)eye;
    camera->target[a] = (float)center[a];
  }
  return true;
}

/* The tangent of half the angle in which a sphere is seen from the eye, the target in the middle. */
static double mesh_view_tangent_of_sphere(const pktrt_camera *camera, const double center[3], double radius) {
  double distance2 = 0, aside2 = 0;
  for (int a = 0; a < 3; a++) {
    const double to = (double)camera->target[a] - (double)camera->eye[a], aside = center[a] - (double)camera->target[a];
    distance2 += to * to;
    aside2 += aside * aside;
  }
  radius += sqrt(aside2);
  return radius / sqrt(distance2 - radius * radius);
}

/* How far the eye must be from the middle of a box to see all its corners, `tangent` of half the angle up and down. */
static double mesh_view_distance_of_box(
    const double half[3], const double from[3], bool up_z, double tangent, double aspect) {
  const int up = up_z ? 2 : 1, x = 0, z = up_z ? 1 : 2;
  const double level = sqrt(from[x] * from[x] + from[z] * from[z]), turn = up_z ? -1 : 1;
  double distance = 0;
  for (int corner = 0; corner < 8; corner++) {
    double p[3];
    for (int a = 0; a < 3; a++) p[a] = corner >> a & 1 ? half[a] : -half[a];
    const double towards = p[0] * from[0] + p[1] * from[1] + p[2] * from[2];
    const double across = turn * (p[x] * from[z] - p[z] * from[x]) / level,
                 above = (p[up] - towards * from[up]) / level;
    distance = fmax(distance, towards + fmax(fabs(across) / aspect, fabs(above)) / tangent);
  }
  return 1.03 * distance;
}

/* A camera that sees the whole bounding sphere, or all corners of a field's box. In double, whose range holds
   squares of any coordinate that the library takes. Where floats are too coarse to place an eye near the mesh, it
   is farther away and its angle smaller. */
static bool mesh_view_frame_bounds(const mesh_view *v, const pktrt_scene_info *info, pktrt_camera *camera) {
  const double degrees = 57.29577951308232, aspect = v->aspect, narrow = aspect < 1 ? aspect : 1;
  const double *from = mesh_view_eye_direction(v);
  double center[3], half[3], radius = 0, largest = 0;
  for (int a = 0; a < 3; a++) {
    double lo = (double)info->bounds_lo[a], hi = (double)info->bounds_hi[a];
    center[a] = 0.5 * (lo + hi);
    half[a] = 0.5 * (hi - lo);
    radius += 0.25 * (hi - lo) * (hi - lo);
    largest = fmax(largest, fmax(fabs(lo), fabs(hi)));
  }
  radius = sqrt(radius);
  /* sin(20 degrees) = 0.342; a picture higher than wide sees less across: there tan shrinks with the aspect */
  const double tangent = 0.364 * narrow, least = 64 * mesh_view_spacing(largest);
  const double distance = v->field ? mesh_view_distance_of_box(half, from, v->up_z, 0.364, aspect)
                                   : radius * sqrt(1 + tangent * tangent) / tangent;
  if (!mesh_view_place_eye(center, fmax(distance, least), from, camera))
    return ex_fail(
        "%s: a camera that sees all of it would lie beyond 2^100, the largest coordinate; see --camera", v->name);
  if (distance < least)
    camera->fov_y = (float)(2 * degrees * atan(mesh_view_tangent_of_sphere(camera, center, radius) / narrow));
  return true;
}

/* >>light ---------------------------------------------------------------------------------------------------------- */

static bool mesh_view_add_light(pktrt_scene *world, const pktrt_light *light) {
  return pktrt_add_light(world, light, NULL) == PKTRT_OK || ex_fail("%s", pktrt_last_error(world));
}

/* Light for a mesh that brings none: a key light like a sun from above, behind the camera's left shoulder, and a
   weaker point light beside the camera, which also lights interiors. Where no float can hold its intensity, because the
   mesh is tiny or huge, another sun takes its place. */
static bool mesh_view_light_mesh(const mesh_view *v, pktrt_scene *world, const pktrt_camera *camera) {
  double to[3], length = 0, side[3];
  for (int a = 0; a < 3; a++) {
    to[a] = (double)camera->target[a] - (double)camera->eye[a];
    length += to[a] * to[a];
  }
  length = sqrt(length);
  const int up = v->up_z ? 2 : 1, x = 0, z = v->up_z ? 1 : 2;
  side[up] = 0; /* horizontal, to the camera's right: view x up, whose sign turns with what is up */
  side[x] = (v->up_z ? to[z] : -to[z]) / length;
  side[z] = (v->up_z ? -to[x] : to[x]) / length;
  pktrt_light key, fill;
  memset(&key, 0, sizeof key);
  memset(&fill, 0, sizeof fill);
  key.kind = PKTRT_LIGHT_DIRECTIONAL;
  const double strength = 0.6 * length * length;
  const bool near = strength >= 1e-36 && strength <= 1e36;
  fill.kind = near ? PKTRT_LIGHT_POINT : PKTRT_LIGHT_DIRECTIONAL;
  for (int a = 0; a < 3; a++) {
    const double above = a == up ? 1 : 0;
    key.direction[a] = (float)(to[a] / length + 0.7 * side[a] - 1.1 * above);
    key.intensity[a] = 2.0f;
    const double beside = 0.25 * side[a] + 0.02 * above;
    if (near) fill.position[a] = (float)((double)camera->eye[a] + length * beside);
    else fill.direction[a] = (float)(to[a] / length - beside);
    fill.intensity[a] = (float)(near ? strength : 0.6);
  }
  return mesh_view_add_light(world, &key) && mesh_view_add_light(world, &fill);
}

/* A sky for what reflects: radiance over the horizon, above, and of the ground. Static: environments get the `user`
   of the render. */
static float mesh_view_strength;
static bool mesh_view_up_z;

static void mesh_view_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  static const float colours[3][3] = {{0.28f, 0.25f, 0.22f}, {0.85f, 0.87f, 0.9f}, {0.3f, 0.45f, 0.75f}};
  const float *up = direction[mesh_view_up_z ? 2 : 1];
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const float height = up[i] > 0 ? sqrtf(up[i]) : 0;
    const float part = up[i] > 0 ? height : material_within(-20 * up[i], 0, 1);
    const float *from = colours[1], *to = colours[up[i] > 0 ? 2 : 0];
    for (int c = 0; c < 3; c++) radiance[c][i] = mesh_view_strength * (from[c] + part * (to[c] - from[c]));
  }
}

/* Returns about how much light of the file arrives at the middle of the scene: irradiance. Emitting meshes alone
   that give hardly any, as lamps on a dashboard, do not count: 0. */
static double mesh_view_irradiance(const mesh_file *file, const pktrt_scene_info *info) {
  double square = 0, aside = 0;
  const double points = file->light_sum[1];
  for (int a = 0; a < 3; a++) {
    const double lo = (double)info->bounds_lo[a], hi = (double)info->bounds_hi[a];
    square += 0.25 * (hi - lo) * (hi - lo);
    if (points > 0) aside += pow(file->light_place[a] / points - 0.5 * (lo + hi), 2);
  }
  if (!(square > 0 && square < 1e30)) return file->light_sum[0];
  const double glow = file->glow / (4 * 3.14159265358979 * square);
  if (file->own_lights == 0 && glow < 0.1) return 0;
  return file->light_sum[0] + points / fmax(aside, 0.25 * square) + glow;
}

/* Gives the scene light and the render surroundings. Returns whether the light is the file's; *ok is false after
   saying what went wrong. */
static bool mesh_view_light(
    const mesh_view *v, const mesh_file *file, pktrt_scene *world, pktrt_render_desc *view, bool *ok) {
  pktrt_scene_info info;
  pktrt_get_scene_info(world, &info);
  const double own = file ? mesh_view_irradiance(file, &info) : 0;
  const float scale = own > 0 ? (float)(0.25 * own / 3.14159265358979) : 1;
  for (int c = 0; c < 3; c++) {
    view->ambient[c] = own > 0 ? 0.2f * scale : 0.05f;
    view->background[c] = scale * (0.08f + 0.03f * (float)c);
  }
  if (file && file->scatters) {
    mesh_view_strength = own > 0 ? scale : 0.6f;
    mesh_view_up_z = v->up_z;
    view->environment = mesh_view_sky;
  }
  *ok = own > 0 || v->lit || mesh_view_light_mesh(v, world, &view->camera);
  return own > 0;
}

/* The file's camera, which sees what is in the middle of the scene sharp. */
static void mesh_view_take_camera(const mesh_file *file, const pktrt_scene_info *info, pktrt_camera *camera) {
  double along = 0, square = 0;
  *camera = file->camera;
  for (int a = 0; a < 3; a++) {
    const double lo = (double)info->bounds_lo[a], hi = (double)info->bounds_hi[a];
    along += (0.5 * (lo + hi) - (double)camera->eye[a]) * (double)camera->target[a];
    square += 0.25 * (hi - lo) * (hi - lo);
  }
  const double distance = fmax(along, 0.1 * sqrt(square));
  for (int a = 0; a < 3; a++)
    camera->target[a] = (float)((double)camera->eye[a] + distance * (double)camera->target[a]);
}

/* Tells whether a pixel shows what is behind everything. */
static bool mesh_view_is_background(const pktrt_render_desc *view, uint32_t x, uint32_t y, const float *pixel) {
  float behind[3], unit[3];
  pktrt_ray ray;
  memcpy(behind, view->background, sizeof behind);
  if (view->environment) {
    if (!pktrt_camera_ray(&view->camera, view->width, view->height, x + 0.5, y + 0.5, NULL, 0, &ray)) return false;
    memcpy(unit, ray.direction, sizeof unit);
    if (!material_normalise(unit)) return false;
    const float *const direction[3] = {&unit[0], &unit[1], &unit[2]};
    float *const radiance[3] = {&behind[0], &behind[1], &behind[2]};
    view->environment(view->user, 1, direction, radiance);
  }
  for (int c = 0; c < 3; c++)
    if (!(fabsf(pixel[c] - behind[c]) <= 0.01f * behind[c])) return false;
  return true;
}

/* Returns the factor that makes 0.8 of the brightness that nine tenths of the pixels stay below; those that show the
   background or are black do not count. 1 where there are no others. pixels: of view->width x view->height. */
EX_UNUSED static double mesh_view_exposure(const pktrt_render_desc *view, const float *pixels) {
  enum { STEPS = 4096 };
  static size_t count[STEPS]; /* by the logarithm, 32 to an octave, from 2^-64 to 2^64 */
  size_t all = 0, below = 0;
  memset(count, 0, sizeof count);
  for (uint32_t y = 0; y < view->height; y++)
    for (uint32_t x = 0; x < view->width; x++) {
      const float *pixel = pixels + 3 * ((size_t)y * view->width + x);
      const float most = material_most(pixel);
      if (!(most > 0 && most < 1e18f) || mesh_view_is_background(view, x, y, pixel)) continue;
      const int step = (int)((log2((double)most) + 64) * 32);
      count[step < 0 ? 0 : step < STEPS ? step : STEPS - 1]++;
      all++;
    }
  for (int i = 0; i < STEPS && all > 0; i++) {
    below += count[i];
    if (10 * below >= 9 * all) return 0.8 / exp2((i + 1) / 32.0 - 64);
  }
  return 1;
}

#endif /* EXAMPLES_MESH_VIEW_H */
