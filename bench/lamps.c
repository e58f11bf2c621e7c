/* lamps.c - error at equal time of one light for all (PKTRT_LIGHTS_ONE) against all lights, on floors under many lamps.

     make bench-lamps                                the table, for 100, 300 and 1,000 lamps
     build/lamps [--lamps N] [--kind quad|sphere] [--exponent E] [--boxes] [--seeds S] [--reference SAMPLES]
                 [--references DIRECTORY] [--check]
     build/lamps ... --only all|one --samples N      one render, for callgrind

   A floor of 20 x 20 under N lamps that fill some 17% of a ceiling 4 above it, or with nine boxes on it. Exponent 0 is matt;
   otherwise a mirror of 0.5 with a Phong lobe over albedo 0.3. The reference is the mean of renders with all lights.
   Error is the RMSE over the mean of the reference; a sample's error squared is measured over seeds. Both choices are
   timed in turns, as user time of one thread. The table has the error of one light over that of all in the same time,
   interpolated in logarithms between the numbers of samples.
     Exits with 1 if a bar is missed and --check was given: 1.5 for 100 lamps, 1 from 300 on. */
#define _GNU_SOURCE
#define PKTRT_IMPLEMENTATION
#ifndef HEADER
#define HEADER "../pktrt.h"
#endif
#include HEADER

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

enum { WIDTH = 96, HEIGHT = 72, VALUES = WIDTH * HEIGHT * 3, STEPS = 6 };

typedef struct options {
  uint32_t lamps;
  const char *kind;
  double exponent;
  uint32_t seeds, samples, reference;
  const char *only, *references;
  bool check, boxes;
} options;

/* Ends the program with what the library says, unless `status` is good. */
static void need(pktrt_scene *scene, pktrt_status status) {
  if (!status) return;
  printf("lamps: %s\n", pktrt_last_error(scene));
  exit(2);
}

static double user_seconds(void) {
  struct rusage usage;
  getrusage(RUSAGE_SELF, &usage);
  return (double)usage.ru_utime.tv_sec + 1e-6 * (double)usage.ru_utime.tv_usec;
}

static double uniform(uint32_t *state) {
  *state = *state * 1664525u + 1013904223u;
  return (double)(*state >> 8) / 16777216;
}

static void add_quad(pktrt_scene *scene, const float corners[4][3], uint32_t material) {
  static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
  pktrt_mesh_desc mesh;
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = corners[0];
  mesh.vertex_count = 4;
  mesh.indices = triangles;
  mesh.triangle_count = 2;
  mesh.material = material;
  need(scene, pktrt_add_mesh(scene, &mesh, NULL));
}

static void add_box(pktrt_scene *scene, double x, double z, double half, double height, uint32_t material) {
  const float low[3] = {(float)(x - half), 0, (float)(z - half)};
  const float high[3] = {(float)(x + half), (float)height, (float)(z + half)};
  for (int axis = 0; axis < 3; axis++)
    for (int side = 0; side < 2; side++) {
      if (axis == 1 && side == 0) continue;
      float corners[4][3];
      for (int k = 0; k < 4; k++) {
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        corners[k][axis] = side ? high[axis] : low[axis];
        corners[k][u] = k == 1 || k == 2 ? high[u] : low[u];
        corners[k][v] = k > 1 ? high[v] : low[v];
      }
      add_quad(scene, (const float(*)[3])corners, material);
    }
}

static pktrt_scene *make_scene(const options *o) {
  static const float ground[4][3] = {{-10, 0, -10}, {-10, 0, 10}, {10, 0, 10}, {10, 0, -10}};
  pktrt_scene *scene = pktrt_scene_create(NULL);
  pktrt_material surface;
  uint32_t material, random = 7;
  memset(&surface, 0, sizeof surface);
  for (int k = 0; k < 3; k++) {
    surface.albedo[k] = o->exponent > 0 ? 0.3f : 0.7f;
    surface.reflectance[k] = o->exponent > 0 ? 0.5f : 0;
  }
  if (o->exponent > 0) {
    surface.specular = PKTRT_SPECULAR_MIRROR;
    surface.lobe = PKTRT_LOBE_PHONG;
    surface.exponent = (float)o->exponent;
  }
  need(scene, pktrt_add_material(scene, &surface, &material));
  add_quad(scene, ground, material);
  for (int i = 0; i < 9 && o->boxes; i++)
    add_box(scene, 4 * (i % 3 - 1) + 0.3 * (i / 3), 4 * (i / 3 - 1), 0.5, 0.6 + 0.2 * (i % 4), material);

  const double spacing = 20 / sqrt(o->lamps);
  const uint32_t across = (uint32_t)ceil(sqrt(o->lamps));
  for (uint32_t i = 0; i < o->lamps; i++) {
    pktrt_light light;
    memset(&light, 0, sizeof light);
    const double x = -10 + 20.0 / across * (i % across + 0.15 + 0.7 * uniform(&random));
    const double z = -10 + 20.0 / across * (i / across + 0.15 + 0.7 * uniform(&random));
    const double side = 0.4 * spacing * (0.5 + uniform(&random));
    const double radiance = 1 + 9 * pow(uniform(&random), 3);
    light.kind = o->kind[0] == 'q' ? PKTRT_LIGHT_QUAD : PKTRT_LIGHT_SPHERE;
    light.position[0] = (float)(x - (o->kind[0] == 'q' ? side / 2 : 0));
    light.position[1] = 4;
    light.position[2] = (float)(z - (o->kind[0] == 'q' ? side / 2 : 0));
    light.radius = (float)(side / 2);
    light.edge[0][0] = light.edge[1][2] = (float)side;
    for (int k = 0; k < 3; k++) light.intensity[k] = (float)(radiance * (k == 1 ? 1 : 0.5 + uniform(&random)));
    need(scene, pktrt_add_light(scene, &light, NULL));
  }
  need(scene, pktrt_commit(scene));
  return scene;
}

/* Renders, and returns the user time in seconds. */
static double render(pktrt_scene *scene, bool one, uint32_t samples, uint32_t seed, float *pixels) {
  pktrt_render_desc view;
  memset(&view, 0, sizeof view);
  view.width = WIDTH;
  view.height = HEIGHT;
  view.pixels = pixels;
  view.mode = PKTRT_MODE_DRT;
  view.samples = samples;
  view.seed = seed;
  view.lights = one ? PKTRT_LIGHTS_ONE : PKTRT_LIGHTS_ALL;
  view.camera.eye[1] = 2.5f;
  view.camera.eye[2] = 9;
  view.camera.target[2] = 0;
  view.camera.fov_y = 50;
  const double start = user_seconds();
  need(scene, pktrt_render(scene, &view));
  return user_seconds() - start;
}

/* Returns the mean squared error over values, relative to the squared mean of the reference. */
static double squared_error(const float *pixels, const double *truth) {
  double sum = 0, mean = 0;
  for (int i = 0; i < VALUES; i++) {
    sum += (pixels[i] - truth[i]) * (pixels[i] - truth[i]);
    mean += truth[i];
  }
  return sum * VALUES / (mean * mean);
}

/* Makes the reference in eight sets, or reads it. Returns the square of its own error. */
static double reference(pktrt_scene *scene, const options *o, double *truth) {
  static double set[8][VALUES];
  static float pixels[VALUES];
  char path[512];
  snprintf(path, sizeof path, "%s/lamps_%u_%c_%g_%d_%u.ref", o->references, o->lamps, o->kind[0], o->exponent, o->boxes,
      o->reference);
  FILE *file = fopen(path, "rb");
  if (!file || fread(set, sizeof set, 1, file) != 1)
    for (int s = 0; s < 8; s++) {
      render(scene, false, o->reference / 8, 1000 + (uint32_t)s, pixels);
      for (int i = 0; i < VALUES; i++) set[s][i] = pixels[i];
    }
  if (file) fclose(file);
  else if ((file = fopen(path, "wb")) != NULL) {
    fwrite(set, sizeof set, 1, file);
    fclose(file);
  }
  double sum = 0, mean = 0;
  for (int i = 0; i < VALUES; i++) {
    truth[i] = 0;
    for (int s = 0; s < 8; s++) truth[i] += set[s][i] / 8;
    for (int s = 0; s < 8; s++) sum += (set[s][i] - truth[i]) * (set[s][i] - truth[i]) / 56;
    mean += truth[i];
  }
  return sum * VALUES / (mean * mean);
}

int main(int argc, char **argv) {
  static double truth[VALUES];
  static float pixels[VALUES];
  options o = {100, "quad", 0, 8, 16, 512, NULL, ".", false, false};
  for (int i = 1; i < argc; i++) {
    const char *name = argv[i], *value = i + 1 < argc ? argv[i + 1] : "";
    if (!strcmp(name, "--check")) o.check = true;
    else if (!strcmp(name, "--boxes")) o.boxes = true;
    else {
      i++;
      if (!strcmp(name, "--lamps")) o.lamps = (uint32_t)atoi(value);
      else if (!strcmp(name, "--kind")) o.kind = value;
      else if (!strcmp(name, "--exponent")) o.exponent = atof(value);
      else if (!strcmp(name, "--seeds")) o.seeds = (uint32_t)atoi(value);
      else if (!strcmp(name, "--samples")) o.samples = (uint32_t)atoi(value);
      else if (!strcmp(name, "--reference")) o.reference = (uint32_t)atoi(value);
      else if (!strcmp(name, "--references")) o.references = value;
      else if (!strcmp(name, "--only")) o.only = value;
      else return printf("lamps: no option %s\n", name), 2;
    }
  }
  pktrt_scene *scene = make_scene(&o);
  if (o.only) {
    render(scene, !strcmp(o.only, "one"), o.samples, 1, pixels);
    pktrt_scene_destroy(scene);
    return 0;
  }

  const double own = reference(scene, &o, truth);
  /* Samples of all lights: 1 and 4. Of one: as many as take about as long. */
  double seconds[2][STEPS] = {{0}}, error[2][STEPS] = {{0}};
  const uint32_t first[2] = {1, o.lamps >= 1000 ? 4 : o.lamps >= 300 ? 2 : 1};
  const int steps[2] = {2, STEPS}, growth[2] = {4, 2};
  for (uint32_t seed = 0; seed < o.seeds; seed++)
    for (int k = 0; k < STEPS; k++)
      for (int one = 0; one < 2; one++) {
        if (k >= steps[one]) continue;
        uint32_t samples = first[one];
        for (int i = 0; i < k; i++) samples *= (uint32_t)growth[one];
        seconds[one][k] += render(scene, one == 1, samples, 1 + seed, pixels) / o.seeds;
        error[one][k] += squared_error(pixels, truth) / o.seeds;
      }
  bool met = true;
  for (int one = 0; one < 2; one++)
    for (int k = 0; k < steps[one]; k++) error[one][k] = sqrt(fmax(error[one][k] - own, 1e-12));
  printf("%s %4u lamps exponent %4g:", o.kind, o.lamps, o.exponent);
  for (int k = 0; k < 2; k++) {
    int at = 0;
    while (at + 2 < STEPS && seconds[1][at + 1] < seconds[0][k]) at++;
    const double part = log(seconds[0][k] / seconds[1][at]) / log(seconds[1][at + 1] / seconds[1][at]);
    const double same = exp(log(error[1][at]) + part * log(error[1][at + 1] / error[1][at]));
    const double samples = first[1] * pow(2, at + part) / (k ? 4 : 1);
    const double ratio = same / error[0][k], bar = o.lamps >= 300 ? 1 : 1.5;
    met = met && ratio <= bar;
    printf("  all %d: %.4f in %.1f ms, one: %.4f (x%.2f) with %.1f a sample", k ? 4 : 1, error[0][k],
        1000 * seconds[0][k], same, ratio, samples);
  }
  printf("  (reference %.4f)\n", sqrt(own));
  pktrt_scene_destroy(scene);
  return o.check && !met ? 1 : 0;
}
