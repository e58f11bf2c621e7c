/* What C gets from pktrt.h of a scene with images, instances, and lights and materials that change, for
   tests/python/test.py, which asks the same from Python. Reads what Python has written to the current directory; writes
   an array for each call. The hooks for images are written anew here. */
#include "../../pktrt.h"
#include <math.h>
#include <string.h>

#include "arrays.h"

enum { WIDTH = 48, HEIGHT = 32, CAPACITY = 3, SAMPLES = 64, DIMENSIONS = 5 };

/* --- images --- */

typedef struct picture {
  float *texel[3]; /* by channel, rows from the upper edge; `wide` texels a row */
  long wide, high;
  bool repeats; /* to both sides; else its edges do */
} picture;

typedef enum coding { SRGB, LINEAR, SIGNED, FLOATS } coding;

static float decoded(unsigned char code, coding as) {
  const double value = code / 255.0;
  if (as == LINEAR) return (float)value;
  if (as == SIGNED) return (float)(code / 127.5 - 1);
  return (float)(value <= 0.04045 ? value / 12.92 : pow((value + 0.055) / 1.055, 2.4));
}

static picture read_picture(const char *name, long wide, size_t channels, coding as, bool repeats) {
  size_t count;
  unsigned char *bytes = (unsigned char *)load(name, as == FLOATS ? sizeof(float) : 1, &count);
  picture made;
  memset(&made, 0, sizeof made);
  made.wide = wide, made.high = (long)(count / channels) / wide, made.repeats = repeats;
  for (size_t c = 0; c < 3; c++) {
    made.texel[c] = (float *)calloc(count / channels, sizeof(float));
    if (!made.texel[c]) fail(name, "there is no memory");
    for (size_t i = 0; i < count / channels; i++) {
      const size_t from = i * channels + (channels == 3 ? c : 0);
      if (as == FLOATS) memcpy(&made.texel[c][i], bytes + 4 * from, sizeof(float));
      else made.texel[c][i] = decoded(bytes[from], as);
    }
  }
  free(bytes);
  return made;
}

static long inside(long i, long size, bool repeats) {
  if (repeats) return (i % size + size) % size;
  return i < 0 ? 0 : i < size ? i : size - 1;
}

/* One channel at (u, v), v upwards, of the four texels around. */
static float picture_at(const picture *image, int channel, double u, double v, bool repeats_upwards) {
  const double x = (image->repeats ? u - floor(u) : fmin(fmax(u, 0), 1)) * (double)image->wide - 0.5;
  const double down = 1 - v;
  const double y = (repeats_upwards ? down - floor(down) : fmin(fmax(down, 0), 1)) * (double)image->high - 0.5;
  const float right = (float)(x - floor(x)), below = (float)(y - floor(y));
  float row[2];
  for (long k = 0; k < 2; k++) {
    const float *texel = image->texel[channel] + inside((long)floor(y) + k, image->high, repeats_upwards) * image->wide;
    const float here = texel[inside((long)floor(x), image->wide, image->repeats)];
    const float next = texel[inside((long)floor(x) + 1, image->wide, image->repeats)];
    row[k] = (1 - right) * here + right * next;
  }
  return (1 - below) * row[0] + below * row[1];
}

static picture albedo, grey, shine, rough, leaf, glow, bumps, sky;

static float texture_at(const picture *image, int channel, const pktrt_points *p, uint32_t i) {
  return picture_at(image, channel, (double)p->texcoord[0][i], (double)p->texcoord[1][i], image->repeats);
}

static void painted(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++)
    for (int c = 0; c < 3; c++) p->albedo[c][i] *= texture_at(&albedo, c, p, i);
}

static void polished(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    for (int c = 0; c < 3; c++) p->albedo[c][i] *= texture_at(&grey, c, p, i);
    for (int c = 0; c < 3; c++) p->reflectance[c][i] *= texture_at(&shine, c, p, i);
    p->exponent[i] = texture_at(&rough, 0, p, i);
  }
}

static void leafy(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    for (int c = 0; c < 3; c++) p->emission[c][i] *= texture_at(&glow, c, p, i);
    p->opacity[i] = texture_at(&leaf, 0, p, i);
  }
}

static void bumpy(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    float bent[3], cosine = 0;
    for (int c = 0; c < 3; c++) bent[c] = texture_at(&bumps, c, p, i);
    for (int c = 0; c < 3; c++) cosine += bent[c] * p->normal[c][i];
    for (int c = 0; c < 3; c++) p->normal_out[c][i] = cosine < 0 ? -bent[c] : bent[c];
  }
}

static void surrounded(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  const double turn = 2 * 3.14159265358979323846;
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const double x = (double)direction[0][i], y = (double)direction[1][i], z = (double)direction[2][i];
    const double u = 0.5 + atan2(x, -z) / turn, v = 0.5 + atan2(y, sqrt(x * x + z * z)) / (turn / 2);
    for (int c = 0; c < 3; c++) radiance[c][i] = picture_at(&sky, c, u, v, false);
  }
}

/* --- the scene --- */

static void must(pktrt_scene *s, pktrt_status status) {
  if (status) fail("the scene", pktrt_last_error(s));
}

static void set3(float to[3], float x, float y, float z) { to[0] = x, to[1] = y, to[2] = z; }

static void add_looks(pktrt_scene *s) {
  pktrt_material look[4];
  memset(look, 0, sizeof look);
  set3(look[0].albedo, 1, 0.9f, 0.8f);
  look[0].texture = painted;
  look[1].specular = PKTRT_SPECULAR_MIRROR, look[1].lobe = PKTRT_LOBE_PHONG, look[1].texture = polished;
  set3(look[1].albedo, 0.5f, 0.5f, 0.5f);
  set3(look[1].reflectance, 0.5f, 0.5f, 0.5f);
  look[2].cutout = true, look[2].texture = leafy;
  set3(look[2].albedo, 0.25f, 0.5f, 0);
  set3(look[2].emission, 1, 1, 1);
  look[3].texture = bumpy;
  set3(look[3].albedo, 0.75f, 0.75f, 0.75f);
  for (int i = 0; i < 4; i++) must(s, pktrt_add_material(s, &look[i], NULL));
}

static void add_meshes(pktrt_scene *s) {
  size_t vertices, triangles;
  pktrt_mesh_desc mesh;
  pktrt_instance_desc place;
  uint32_t model, spare, instance;
  memset(&mesh, 0, sizeof mesh);
  memset(&place, 0, sizeof place);
  mesh.positions = (const float *)load("floor", 12, &vertices);
  mesh.texcoords = (const float *)load("floor_texcoords", 8, &vertices);
  mesh.indices = (const uint32_t *)load("floor_triangles", 12, &triangles);
  mesh.triangle_materials = (const uint32_t *)load("floor_materials", 4, &triangles);
  mesh.vertex_count = (uint32_t)vertices, mesh.triangle_count = (uint32_t)triangles;
  mesh.mask = 1;
  must(s, pktrt_add_mesh(s, &mesh, NULL));
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = (const float *)load("body", 12, &vertices);
  mesh.indices = (const uint32_t *)load("body_triangles", 12, &triangles);
  mesh.vertex_count = (uint32_t)vertices, mesh.triangle_count = (uint32_t)triangles;
  must(s, pktrt_add_model(s, &mesh, 1, &spare));
  must(s, pktrt_add_model(s, &mesh, 1, &model));
  must(s, pktrt_remove_model(s, spare));
  place.model = model, place.key_count = 2, place.mask = 2;
  place.interpolation = PKTRT_INTERPOLATION_RIGID;
  place.transforms = (const float *)load("places", 96, &vertices);
  must(s, pktrt_add_instance(s, &place, NULL));
  memset(&place, 0, sizeof place);
  place.model = model, place.mask = 4;
  must(s, pktrt_add_instance(s, &place, &instance));
  must(s, pktrt_set_transform(s, instance, 0, (const float *)load("place", 48, &vertices)));
  must(s, pktrt_commit(s));
  must(s, pktrt_set_transforms(s, 0, (const float *)load("places_later", 96, &vertices)));
  must(s, pktrt_refit(s));
}

static void add_lights(pktrt_scene *s) {
  pktrt_light light;
  uint32_t first;
  memset(&light, 0, sizeof light);
  light.kind = PKTRT_LIGHT_POINT;
  set3(light.position, 0, 5, 0);
  set3(light.intensity, 90, 90, 90);
  must(s, pktrt_add_light(s, &light, &first));
  must(s, pktrt_add_light(s, &light, NULL));
  must(s, pktrt_remove_light(s, first));
  memset(&light, 0, sizeof light);
  light.kind = PKTRT_LIGHT_ENVIRONMENT;
  set3(light.intensity, 1, 0.5f, 1);
  must(s, pktrt_set_light(s, 1, &light));
}

/* --- what is asked --- */

static void save_pictures(pktrt_scene *s) {
  static float pixels[WIDTH * HEIGHT * 3], error[WIDTH * HEIGHT], blocks[WIDTH * HEIGHT];
  static unsigned char codes[WIDTH * HEIGHT * 3];
  static char text[10000];
  pktrt_render_desc view;
  pktrt_report report;
  pktrt_scene_report scene;
  pktrt_material look;
  memset(&view, 0, sizeof view);
  view.width = WIDTH, view.height = HEIGHT, view.pixels = pixels, view.pixel_error = error, view.block_error = blocks;
  view.mode = PKTRT_MODE_DRT, view.samples = 2, view.passes = 3, view.environment = surrounded, view.report = &report;
  set3(view.camera.eye, 1, 3, 6);
  view.camera.projection = PKTRT_PROJECTION_ORTHOGRAPHIC, view.camera.width = 9, view.camera.shutter = 1;
  view.camera.shift[0] = 0.1f;
  must(s, pktrt_prepare_environment(s, &view));
  must(s, pktrt_render(s, &view));
  save("stage", pixels, sizeof pixels);
  save("pixel_error", error, sizeof error);
  save("block_error", blocks, sizeof(float) * ((WIDTH + 15) / 16) * ((HEIGHT + 15) / 16));
  save("report", &report, sizeof report);
  pktrt_to_srgb8(pixels, WIDTH * HEIGHT, 1.5f, PKTRT_TONE_CURVE, codes);
  save("codes", codes, sizeof codes);
  pktrt_get_scene_report(s, &view, &scene);
  save("text", text, pktrt_scene_report_text(&scene, text, sizeof text));

  memset(&look, 0, sizeof look);
  set3(look.albedo, 0.5f, 0, 0);
  must(s, pktrt_set_material(s, 1, &look));
  must(s, pktrt_render(s, &view));
  save("repainted", pixels, sizeof pixels);
}

static void save_camera_rays(void) {
  size_t n;
  const double *place = (const double *)load("camera_places", 2 * sizeof(double), &n);
  const float *lens = (const float *)load("camera_lens", 2 * sizeof(float), &n);
  const float *time = (const float *)load("camera_times", sizeof(float), &n);
  pktrt_ray *ray = (pktrt_ray *)calloc(n, sizeof *ray);
  pktrt_camera camera;
  if (!ray) fail("camera", "there is no memory");
  memset(&camera, 0, sizeof camera);
  set3(camera.eye, 1, 2, 6);
  set3(camera.eye_end, 2, 2, 6);
  camera.fov_y = 50, camera.aperture = 0.5f, camera.moving = true;
  for (size_t i = 0; i < n; i++)
    if (!pktrt_camera_ray(&camera, 64, 48, place[2 * i], place[2 * i + 1], lens + 2 * i, time[i], &ray[i]))
      fail("camera", "it is refused");
  save("camera_rays", ray, n * sizeof *ray);
}

static void save_samples(void) {
  static float set[SAMPLES][DIMENSIONS], disk[SAMPLES][2], sphere[SAMPLES][3], cosine[SAMPLES][3], phong[SAMPLES][3];
  static float glass[SAMPLES], metal[SAMPLES];
  const pktrt_sampling sampling = {PKTRT_SAMPLER_HALTON, SAMPLES, 9};
  const float normal[3] = {0.6f, 0, 0.8f};
  for (uint32_t i = 0; i < SAMPLES; i++) {
    pktrt_sample(&sampling, 3, 4, i, 0, DIMENSIONS, set[i]);
    pktrt_map_disk(set[i], disk[i]);
    pktrt_map_sphere(set[i], sphere[i]);
    pktrt_map_cosine(set[i], normal, cosine[i]);
    pktrt_map_phong(set[i], normal, 20 * set[i][2], phong[i]);
    glass[i] = pktrt_fresnel_dielectric(set[i][0], 1.5f);
    metal[i] = pktrt_fresnel_conductor(set[i][0], set[i][1], 3);
  }
  save("set", set, sizeof set);
  save("disk", disk, sizeof disk);
  save("sphere", sphere, sizeof sphere);
  save("cosine", cosine, sizeof cosine);
  save("phong", phong, sizeof phong);
  save("glass", glass, sizeof glass);
  save("metal", metal, sizeof metal);
}

static void save_queries(pktrt_scene *s) {
  size_t n;
  const pktrt_ray *ray = (const pktrt_ray *)load("rays", sizeof *ray, &n);
  pktrt_hit *all = (pktrt_hit *)calloc(n * CAPACITY, sizeof *all), *hit = (pktrt_hit *)calloc(n, sizeof *hit);
  size_t *counts = (size_t *)calloc(n, sizeof *counts);
  bool *blocked = (bool *)calloc(n, sizeof *blocked);
  float *directions = (float *)calloc(n, 3 * sizeof(float)), *points = (float *)calloc(n, 3 * sizeof(float));
  float *times = (float *)calloc(n, sizeof(float));
  int *winding = (int *)calloc(n, sizeof *winding);
  pktrt_ray *left = (pktrt_ray *)calloc(n, sizeof *left);
  pktrt_point_query *query = (pktrt_point_query *)calloc(n, sizeof *query);
  pktrt_closest *closest = (pktrt_closest *)calloc(n, sizeof *closest);
  pktrt_stats *stats = (pktrt_stats *)calloc(1, sizeof *stats);
  pktrt_query_desc desc;
  pktrt_mesh_info info[2];
  if (!all || !hit || !counts || !blocked || !directions || !left) fail("memory", "there is none");
  if (!query || !closest || !stats || !times || !points || !winding) fail("memory", "there is none");
  for (size_t i = 0; i < n; i++) {
    for (size_t k = 0; k < CAPACITY; k++) {
      all[i * CAPACITY + k].t = ray[i].tmax;
      all[i * CAPACITY + k].mesh = all[i * CAPACITY + k].triangle = PKTRT_NONE;
    }
    memcpy(directions + 3 * i, ray[i].direction, sizeof ray[i].direction);
    memcpy(points + 3 * i, ray[i].origin, sizeof ray[i].origin);
    memcpy(query[i].point, ray[i].origin, sizeof query[i].point);
    query[i].max_distance = 2, query[i].time = times[i] = ray[i].time, query[i].mask = 3;
  }
  pktrt_intersect_all_n(s, ray, all, CAPACITY, counts, n);
  save("all", all, n * CAPACITY * sizeof *all);
  save("counts", counts, n * sizeof *counts);
  pktrt_closest_point_n(s, query, closest, n);
  save("closest", closest, n * sizeof *closest);
  pktrt_winding_n(s, 1, points, times, winding, n);
  save("winding", winding, n * sizeof *winding);
  memset(&desc, 0, sizeof desc);
  desc.mask = 4, desc.path = PKTRT_PATH_PAPER, desc.stats = stats, desc.type = PKTRT_RAY_OTHER;
  pktrt_intersect_ex(s, &desc, ray, hit, n);
  pktrt_occluded_ex(s, &desc, ray, blocked, n);
  save("masked", hit, n * sizeof *hit);
  save("masked_blocked", blocked, n);
  save("stats", stats, sizeof *stats);
  pktrt_intersect_n(s, ray, hit, n);
  pktrt_spawn_at_n(s, hit, times, directions, left, n);
  save("staged", hit, n * sizeof *hit);
  save("left", left, n * sizeof *left);
  must(s, pktrt_get_mesh_info(s, 0, &info[0]));
  must(s, pktrt_get_mesh_info(s, 1, &info[1]));
  save("mesh_infos", info, sizeof info);
}

int main(void) {
  pktrt_scene *s = pktrt_scene_create(NULL);
  if (!s) fail("memory", "there is none");
  albedo = read_picture("image_albedo", 7, 3, SRGB, true);
  grey = read_picture("image_grey", 5, 1, SRGB, false);
  shine = read_picture("image_shine", 4, 3, SRGB, false);
  rough = read_picture("image_rough", 2, 1, FLOATS, true);
  leaf = read_picture("image_leaf", 9, 1, LINEAR, true);
  glow = read_picture("image_glow", 3, 3, FLOATS, true);
  bumps = read_picture("image_bumps", 6, 3, SIGNED, true);
  sky = read_picture("image_sky", 16, 3, FLOATS, true);
  add_looks(s);
  add_meshes(s);
  add_lights(s);
  save_queries(s);
  save_camera_rays();
  save_samples();
  save_pictures(s);
  pktrt_scene_destroy(s);
  return 0;
}
