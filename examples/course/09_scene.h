/* 09_scene.h - the scene, the camera and the effects of chapter 9, and what 09_blur.c counts and writes with them. */
#include "course.h"

enum { WIDTH = 112, HEIGHT = 84, SAMPLES = 64 };
typedef enum effect { IDEAL, LENS, SHUTTER, LAMP, LOBE, EFFECTS } effect;
static const char *const names[EFFECTS] = {"ideal", "lens", "shutter", "lamp", "lobe"};

/* Ends the program with the library's error message. */
static void fail(const pktrt_scene *scene) {
  ex_fail("%s", pktrt_last_error(scene));
  exit(1);
}

/* Which parts of the scene reflect: all of them, the ball of glass alone, the ring and the coated knot, or ball and knot. */
typedef enum reflecting { ALL_REFLECT, BALL_REFLECTS, METAL_REFLECTS, RING_MATTE } reflecting;

/* [motion] */
/* Adds a part of the scene. A part that moves has its positions twice: for time 0, and for time 1. */
static void add_part(
    pktrt_scene *scene, const course_scene *s, uint32_t first, uint32_t last, uint32_t material, vec step) {
  vec *positions = (vec *)course_memory(2 * s->vertices, sizeof *positions);
  memcpy(positions, s->position, s->vertices * sizeof *positions);
  for (uint32_t i = 0; i < s->vertices; i++) positions[s->vertices + i] = vec_add(positions[i], step);
  const pktrt_mesh_desc mesh = {.positions = positions[0].at,
      .vertex_count = s->vertices,
      .indices = s->corner[first],
      .triangle_count = last - first,
      .key_count = vec_dot(step, step) > 0 ? 2 : 1,
      .material = material};
  if (pktrt_add_mesh(scene, &mesh, NULL)) fail(scene);
  free(positions);
}
/* [end] */

/* Makes the course's scene in parts: uneven ground, a knot that moves, a ring of metal, a ball of glass. */
static pktrt_scene *make_scene(effect with, reflecting parts) {
  enum { GROUND = 512, KNOT = 2048, RING = 2832 }; /* where the triangles of a part end */
  course_scene s = course_scene_make();
  pktrt_material materials[4] = {{.albedo = {0.5f, 0.45f, 0.4f}},
      {.albedo = {0.6f, 0.1f, 0.05f}, .specular = PKTRT_SPECULAR_COAT},
      {.specular = PKTRT_SPECULAR_CONDUCTOR,
          .ior = {0.18f, 0.42f, 1.37f},
          .extinction = {3.42f, 2.35f, 1.77f},
          .lobe = with == LOBE ? PKTRT_LOBE_PHONG : PKTRT_LOBE_IDEAL,
          .exponent = 60},
      {.specular = PKTRT_SPECULAR_DIELECTRIC}};
  const float size = with == LAMP ? 2 : 0.02f, radiance = 400 / (size * size); /* as much light from any size */
  const pktrt_light lamp = {.kind = PKTRT_LIGHT_QUAD,
      .position = {-3 - size / 2, 7, 2 - size / 2},
      .edge = {{size, 0, 0}, {0, 0, size}},
      .intensity = {radiance, radiance, radiance}};
  if (parts == BALL_REFLECTS) {
    materials[1].specular = PKTRT_SPECULAR_NONE;
    materials[2].specular = PKTRT_SPECULAR_NONE;
  }
  if (parts == RING_MATTE) materials[2].specular = PKTRT_SPECULAR_NONE;
  if (parts == METAL_REFLECTS) materials[3].specular = PKTRT_SPECULAR_NONE;

  const vec still = {{0, 0, 0}}, step = {{-0.6f, 0.3f, 0.6f}};
  pktrt_scene *scene = pktrt_scene_create(NULL);
  for (int i = 0; i < 4; i++) pktrt_add_material(scene, &materials[i], NULL);
  add_part(scene, &s, 0, GROUND, 1, still);
  add_part(scene, &s, GROUND, KNOT, 2, step);
  add_part(scene, &s, KNOT, RING, 3, still);
  add_part(scene, &s, RING, s.triangles, 4, still);
  if ((with < EFFECTS && pktrt_add_light(scene, &lamp, NULL)) || pktrt_commit(scene)) fail(scene);
  return scene;
}

/* [camera] */
/* Returns the camera. Each effect has one number that switches it on; without it the middle of its range is used. */
static pktrt_camera make_camera(effect with) {
  const pktrt_camera camera = {.eye = {2.7f, 4.1f, 7.3f},
      .target = {0.1f, 1.2f, -0.1f},
      .fov_y = 39.6f,
      .aperture = with == LENS ? 0.6f : 0, /* a diameter; what is at `focus` stays sharp */
      .focus = 7.2f,
      .time = with == SHUTTER ? 0 : 0.5f,
      .shutter = with == SHUTTER ? 1.0f : 0}; /* open from time 0 to 1 */
  return camera;
}
/* [end] */

/* Renders a picture of the scene with an effect. */
static void render(pktrt_scene *scene, pktrt_render_desc *view, effect with) {
  view->width = WIDTH;
  view->height = HEIGHT;
  view->mode = PKTRT_MODE_DRT;
  view->camera = make_camera(with);
  for (int c = 0; c < 3; c++) {
    view->background[c] = 0.25f + 0.1f * (float)c;
    view->ambient[c] = 0.2f;
  }
  if (pktrt_render(scene, view)) fail(scene);
}

/* Writes a strip of pictures with each pixel as `scale` x `scale` pixels, so that a reader sees them. Leaves out `margin`
   columns at both sides of each picture. */
static void write_enlarged(const course_picture *strip, uint32_t scale, uint32_t margin, const char *path) {
  const uint32_t kept = WIDTH - 2 * margin;
  course_picture large = course_picture_make(strip->width / WIDTH * kept * scale, strip->height * scale);
  for (uint32_t y = 0; y < large.height; y++)
    for (uint32_t x = 0; x < large.width; x++) {
      const uint32_t column = x / scale / kept * WIDTH + margin + x / scale % kept;
      large.pixel[y * large.width + x] = strip->pixel[y / scale * strip->width + column];
    }
  course_picture_write(&large, path);
  free(large.pixel);
}

/* Prints the figure `name.kind.what`. */
static void figure(const char *name, const char *kind, const char *what, const char *format, double value) {
  char full_name[64];
  snprintf(full_name, sizeof full_name, "%s.%s.%s", name, kind, what);
  course_figure(full_name, format, value);
}

/* Returns box tests per ray of a type. */
static double boxes(const pktrt_stats *stats, pktrt_ray_type type) {
  return (double)stats->by_type[type].box_tests / (double)stats->by_type[type].rays;
}

/* Renders with an effect into `pixels`, alone or in packets, and returns what the library counts. */
static pktrt_stats count(effect with, reflecting parts, pktrt_path path, float *pixels, uint32_t row_stride) {
  pktrt_stats stats = {0};
  pktrt_render_desc view = {.pixels = pixels, .row_stride = row_stride};
  pktrt_scene *scene = make_scene(with, parts);
  view.samples = SAMPLES;
  view.path = path;
  view.stats = &stats;
  render(scene, &view, with);
  pktrt_scene_destroy(scene);
  return stats;
}

/* Prints box tests per reflected ray if some parts of the scene do not reflect. */
static void reflections(void) {
  static vec pixels[WIDTH * HEIGHT];
  static const char *const parts_names[] = {"all", "ball", "metal", "matte-ring"};
  for (int parts = BALL_REFLECTS; parts <= RING_MATTE; parts++)
    for (int with = IDEAL; with < EFFECTS; with++) {
      if (with == LAMP || (parts == BALL_REFLECTS && with != IDEAL)) continue;
      for (int paper = with == IDEAL ? 0 : 1; paper < 2; paper++) {
        const pktrt_path path = paper ? PKTRT_PATH_PAPER : PKTRT_PATH_SINGLE;
        const pktrt_stats stats = count((effect)with, (reflecting)parts, path, pixels[0].at, 0);
        figure(parts_names[parts], names[with], paper ? "packets" : "alone", parts == RING_MATTE ? "%.1f" : "%.0f",
            boxes(&stats, PKTRT_RAY_REFLECTION));
      }
    }
}

/* For counting only: no margin for rounding, and no care for zeros in the direction. */
static bool meets_box(const pktrt_ray *ray, const float lo[3], const float hi[3]) {
  float in = ray->tmin, out = ray->tmax;
  for (int a = 0; a < 3; a++) {
    const float t0 = (lo[a] - ray->origin[a]) / ray->direction[a], t1 = (hi[a] - ray->origin[a]) / ray->direction[a];
    in = fmaxf(in, fminf(t0, t1)), out = fminf(out, fmaxf(t0, t1));
  }
  return in <= out;
}
