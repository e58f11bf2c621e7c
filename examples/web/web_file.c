/* A model from a file, as files.js has read it, on a floor under a light: web_model_room, and from where it says on all
   corners' positions and normals, the materials' words, the triangles' materials and, if there are any, the corners'
   texture coordinates; web_image_room for each image; then web_open_model of web.c. */
#include "web.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

enum {
  MATERIAL_WORDS = 13, /* as in files.js: albedo, reflectance, emission, exponent, index of the coat, image, cutout */
  MOST_IMAGES = 16,
  MOST_EDGE = 1024, /* pixels of an image, along an edge */
  MOST_TRIANGLES = 1000000,
  MOST_MATERIALS = 20000
};

#define FLOOR_DEPTH 0.002f /* under the model, which may itself be flat */
#define FLOOR_SIZE 24.0f
#define FLOOR_NEAR 2.5f /* as far it looks as it is */
#define LIGHT_SIZE 1.6
#define LIGHT_RADIANCE 14.0

static const float zenith[3] = {0.34f, 0.47f, 0.66f}, horizon[3] = {0.70f, 0.73f, 0.77f};

typedef struct image {
  int32_t width, height;
  uint32_t pixels[]; /* from the lowest byte up red, green, blue in sRGB, and opacity */
} image;

static struct {
  float *words; /* what waits to be opened, NULL: nothing */
  unsigned triangles, materials, textured, image_count;
  image *images[MOST_IMAGES], *shown[MOST_IMAGES]; /* those that wait, and those of the model that is open */
} model;

/* Forgets what waits. */
static void forget(void) {
  for (int i = 0; i < MOST_IMAGES; i++) {
    free(model.images[i]);
    model.images[i] = NULL;
  }
  model.image_count = 0;
  free(model.words);
  model.words = NULL;
}

/* Makes room for a model, with texture coordinates if `textured` is not 0. NULL: there is not enough memory. */
WEB_EXPORT float *web_model_room(unsigned triangles, unsigned materials, unsigned textured) {
  forget();
  if (triangles == 0 || triangles > MOST_TRIANGLES || materials == 0 || materials > MOST_MATERIALS) return NULL;
  model.triangles = triangles;
  model.materials = materials;
  model.textured = textured;
  const size_t of_triangle = textured ? 25 : 19;
  model.words = (float *)malloc((triangles * of_triangle + (size_t)materials * MATERIAL_WORDS) * sizeof(float));
  return model.words;
}

/* Makes room for the next image of the model. NULL: there is not enough memory. */
WEB_EXPORT uint32_t *web_image_room(unsigned width, unsigned height) {
  if (model.image_count == MOST_IMAGES || width - 1 >= MOST_EDGE || height - 1 >= MOST_EDGE) return NULL;
  image *const made = (image *)malloc(sizeof(image) + (size_t)width * height * sizeof(uint32_t));
  if (!made) return NULL;
  made->width = (int32_t)width;
  made->height = (int32_t)height;
  model.images[model.image_count++] = made;
  return made->pixels;
}

/* Linear values of the codes of sRGB. */
static const float *linear_values(void) {
  static float values[256];
  for (int i = 0; values[255] == 0 && i < 256; i++) {
    const double code = i / 255.0;
    values[i] = (float)(code <= 0.04045 ? code / 12.92 : pow((code + 0.055) / 1.055, 2.4));
  }
  return values;
}

/* Multiplies colours by those of an image, which repeats; between the middles of pixels they are bilinear. */
static void image_texture(void *user, const pktrt_points *points) {
  const image *const from = (const image *)user;
  const float *const linear = linear_values();
  for (uint32_t i = 0; i < points->n; i++) {
    float part[2];
    int32_t at[2][2]; /* column and row of the pixels before and behind the point */
    for (int a = 0; a < 2; a++) {
      const int32_t edge = a ? from->height : from->width;
      const float place = points->texcoord[a][i], inside = (place - floorf(place)) * (float)edge + (float)edge - 0.5f;
      const int32_t before = (int32_t)inside;
      part[a] = inside - (float)before;
      at[0][a] = before % edge;
      at[1][a] = (before + 1) % edge;
    }
    float value[3] = {0, 0, 0}, opacity = 0;
    for (int k = 0; k < 4; k++) {
      const int x = k & 1, y = k >> 1;
      const uint32_t pixel = from->pixels[at[y][1] * from->width + at[x][0]];
      const float weight = (x ? part[0] : 1 - part[0]) * (y ? part[1] : 1 - part[1]);
      for (int c = 0; c < 3; c++) value[c] += weight * linear[pixel >> (8 * c) & 255];
      opacity += weight * (float)(pixel >> 24) / 255;
    }
    for (int c = 0; c < 3; c++) {
      points->albedo[c][i] *= value[c];
      points->reflectance[c][i] *= value[c];
    }
    points->opacity[i] = opacity; /* which counts for cutouts alone */
  }
}

/* Radiance from all around: a pale sky, which is the same from the horizon down. */
static void sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const float part = direction[1][i] > 0 ? sqrtf(direction[1][i]) : 0;
    for (int c = 0; c < 3; c++) radiance[c][i] = horizon[c] + part * (zenith[c] - horizon[c]);
  }
}

/* The floor turns into the horizon as it gets farther, so that no edge is seen. It is there from above alone, so that
   one can look at a model from below. */
static void floor_texture(void *user, const pktrt_points *points) {
  (void)user;
  for (uint32_t i = 0; i < points->n; i++) {
    const float x = points->position[0][i], z = points->position[2][i];
    const float part = (sqrtf(x * x + z * z) - FLOOR_NEAR) / (FLOOR_SIZE / 2 - FLOOR_NEAR);
    const float within = part < 1 ? part : 1;
    const float faded = within > 0 ? within * (2 - within) : 0;
    for (int c = 0; c < 3; c++) {
      points->albedo[c][i] *= 1 - faded;
      points->emission[c][i] = faded * horizon[c];
    }
    if (points->direction[1][i] > 0) points->opacity[i] = 0;
  }
}

static pktrt_status add_floor(pktrt_scene *scene) {
  static const float corners[4][3] = {{-FLOOR_SIZE / 2, -FLOOR_DEPTH, FLOOR_SIZE / 2},
      {FLOOR_SIZE / 2, -FLOOR_DEPTH, FLOOR_SIZE / 2}, {FLOOR_SIZE / 2, -FLOOR_DEPTH, -FLOOR_SIZE / 2},
      {-FLOOR_SIZE / 2, -FLOOR_DEPTH, -FLOOR_SIZE / 2}};
  static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
  pktrt_material material;
  memset(&material, 0, sizeof material);
  for (int c = 0; c < 3; c++) material.albedo[c] = 0.45f;
  material.texture = floor_texture;
  material.cutout = true;
  pktrt_mesh_desc mesh;
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = corners[0];
  mesh.vertex_count = 4;
  mesh.indices = indices;
  mesh.triangle_count = 2;

  const pktrt_status status = pktrt_add_material(scene, &material, &mesh.material);
  return status == PKTRT_OK ? pktrt_add_mesh(scene, &mesh, NULL) : status;
}

const double web_model_light[3] = {-1.8, 4.2, 2.4};

/* A square above and before the model, to its left. It has the same power whatever its size. */
static pktrt_status add_light(pktrt_scene *scene, double size) {
  const double edge = LIGHT_SIZE * size;
  pktrt_light light;
  memset(&light, 0, sizeof light);
  light.kind = PKTRT_LIGHT_QUAD;
  const double right[3] = {0.8, 0, 0.6}, down[3] = {-0.48, -0.6, 0.64};
  for (int a = 0; a < 3; a++) {
    light.edge[0][a] = (float)(edge * right[a]);
    light.edge[1][a] = (float)(edge * down[a]);
    light.position[a] = (float)(web_model_light[a] - 0.5 * edge * (right[a] + down[a]));
    light.intensity[a] = (float)(LIGHT_RADIANCE / (size * size));
  }
  return pktrt_add_light(scene, &light, NULL);
}

/* Adds the model's materials, which are numbered from 1 on. */
static pktrt_status add_materials(pktrt_scene *scene, const float *words) {
  for (unsigned i = 0; i < model.materials; i++, words += MATERIAL_WORDS) {
    pktrt_material material;
    memset(&material, 0, sizeof material);
    memcpy(material.albedo, words, sizeof material.albedo);
    memcpy(material.emission, words + 6, sizeof material.emission);
    if (words[10] > 0) {
      material.specular = PKTRT_SPECULAR_COAT;
      material.ior[0] = words[10];
    } else if (words[3] > 0 || words[4] > 0 || words[5] > 0) {
      material.specular = PKTRT_SPECULAR_MIRROR;
      memcpy(material.reflectance, words + 3, sizeof material.reflectance);
    }
    material.lobe = words[9] >= 0 ? PKTRT_LOBE_PHONG : PKTRT_LOBE_IDEAL;
    material.exponent = words[9] >= 0 ? words[9] : 0;
    if (words[11] >= 0 && words[11] < (float)model.image_count) {
      material.texture = image_texture;
      material.cutout = words[12] > 0;
      material.user = model.images[(int)words[11]];
    }
    const pktrt_status status = pktrt_add_material(scene, &material, NULL);
    if (status != PKTRT_OK) return status;
  }
  return PKTRT_OK;
}

static pktrt_status add_model(pktrt_scene *scene) {
  const size_t values = (size_t)model.triangles * 9;
  const float *const materials = model.words + 2 * values;
  uint32_t *const number = (uint32_t *)(model.words + 2 * values + (size_t)model.materials * MATERIAL_WORDS);
  for (unsigned i = 0; i < model.triangles; i++) number[i]++;
  pktrt_mesh_desc mesh;
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = model.words;
  mesh.normals = model.words + values;
  mesh.vertex_count = model.triangles * 3;
  mesh.triangle_count = model.triangles;
  mesh.triangle_materials = number;
  if (model.textured) mesh.texcoords = (const float *)(number + model.triangles);

  const pktrt_status status = add_materials(scene, materials);
  return status == PKTRT_OK ? pktrt_add_mesh(scene, &mesh, NULL) : status;
}

/* Looks at the middle of the model from before it, from the right and above, and as near as all corners can be seen. */
static void fit_camera(pktrt_camera *camera) {
  static const float back[3] = {0.48f, 0.36f, 0.80f}, right[3] = {0.857493f, 0, -0.514496f};
  static const float up[3] = {-0.185218f, 0.932952f, -0.308697f};
  const float slope = 0.41421356f / 1.1f; /* of half of 45 degrees, and a margin */
  const size_t values = (size_t)model.triangles * 9;
  float lo[3], hi[3], distance = 0;
  memcpy(lo, model.words, sizeof lo);
  memcpy(hi, model.words, sizeof hi);
  for (size_t i = 0; i < values; i++) {
    const float x = model.words[i];
    if (x < lo[i % 3]) lo[i % 3] = x;
    if (x > hi[i % 3]) hi[i % 3] = x;
  }
  memset(camera, 0, sizeof *camera);
  for (int a = 0; a < 3; a++) camera->target[a] = 0.5f * (lo[a] + hi[a]);

  for (size_t i = 0; i < values; i += 3) {
    float along[3] = {0, 0, 0}; /* to the right, up and back */
    for (int a = 0; a < 3; a++) {
      const float from = model.words[i + (size_t)a] - camera->target[a];
      along[0] += from * right[a];
      along[1] += from * up[a];
      along[2] += from * back[a];
    }
    const float wider = fabsf(along[0]) > fabsf(along[1]) ? fabsf(along[0]) : fabsf(along[1]);
    const float needed = along[2] + wider / slope;
    if (needed > distance) distance = needed;
  }
  for (int a = 0; a < 3; a++) camera->eye[a] = camera->target[a] + distance * back[a];
}

pktrt_scene *web_model_scene(double light_size, pktrt_render_desc *view, double *triangles) {
  if (!model.words) return NULL;
  *triangles = model.triangles;
  fit_camera(&view->camera);
  for (int c = 0; c < 3; c++) view->ambient[c] = 0.32f;
  view->environment = sky;

  pktrt_scene *scene = pktrt_scene_create(NULL);
  const bool added =
      scene && add_model(scene) == PKTRT_OK && add_floor(scene) == PKTRT_OK && add_light(scene, light_size) == PKTRT_OK;
  free(model.words); /* before the tree takes memory */
  model.words = NULL;
  const bool good = added && pktrt_commit(scene) == PKTRT_OK;
  for (int i = 0; good && i < MOST_IMAGES; i++) { /* the scene of before is not rendered any more */
    free(model.shown[i]);
    model.shown[i] = model.images[i];
    model.images[i] = NULL;
  }
  forget();
  if (good) return scene;
  pktrt_scene_destroy(scene);
  return NULL;
}
