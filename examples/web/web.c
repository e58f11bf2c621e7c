/* Pictures for a web page: what its workers ask of the library. Each worker has a module of its own, hence a scene of its
   own, and no two share memory; the bits are the same everywhere, so a picture may be made by all of them, band by band.

   web_open or web_open_model, web_resize, then for each picture web_pose, web_camera, web_settings and web_render_band, whose floats stand
   where web_pixels says. Functions that may fail return 0 if they have not; web_error has the sentence. */
#include "web.h"

#include "../scenes.h"
#include <stdio.h>

static struct {
  scene built_in;
  pktrt_scene *world; /* in the pose of time and shutter */
  bool from_file;     /* the world is a model that stands still; of the built-in scene the camera alone is there */
  double triangles;
  double time, shutter;
  pktrt_isa isa;
  pktrt_render_desc view; /* but for what a band brings along */
  float *cost;            /* of each pixel */
  pktrt_stats stats;      /* of the latest band, if web_settings asked for them */
  const char *error;
} web;

pktrt_scene *web_scene(void) { return web.world; }
const pktrt_render_desc *web_view(void) { return &web.view; }

void web_use_isa(pktrt_isa isa) { web.isa = isa; }

void web_light(float at[3]) {
  const scene *const s = &web.built_in;
  for (int a = 0; web.from_file && a < 3; a++) at[a] = (float)web_model_light[a];
  if (web.from_file) return;
  for (size_t i = 0; i < s->light_count; i++) {
    const pktrt_light *l = &s->lights[i];
    if (l->kind == PKTRT_LIGHT_DIRECTIONAL) continue;
    for (int a = 0; a < 3; a++) {
      if (l->kind != PKTRT_LIGHT_MESH) at[a] = l->position[a] + (l->edge[0][a] + l->edge[1][a]) / 2;
      else {
        const scene_mesh *const m = &s->meshes[l->mesh];
        double sum = 0;
        for (uint32_t v = 0; v < m->vertex_count; v++) sum += (double)m->positions[3 * v + (uint32_t)a];
        at[a] = (float)(sum / m->vertex_count);
      }
    }
    return;
  }
}

int web_fail(const char *sentence) {
  web.error = sentence;
  return 1;
}

void web_features(float *depth, float *normal, float *albedo) {
  web.view.depth = depth;
  web.view.normal = normal;
  web.view.albedo = albedo;
}

/* Tells what went wrong last. */
WEB_EXPORT const char *web_error(void) { return web.error ? web.error : ""; }

/* Names a scene, "" if there is none of that number. */
WEB_EXPORT const char *web_scene_name(unsigned number) {
  for (unsigned i = 0; scene_names()[i]; i++)
    if (i == number) return scene_names()[i];
  return "";
}

/* Builds the trees anew, in a pose. */
static int build(double time, double shutter) {
  pktrt_scene_desc desc;
  memset(&desc, 0, sizeof desc);
  desc.rebuild = PKTRT_REBUILD_AUTOMATIC;
  desc.isa = web.isa;
  pktrt_scene_destroy(web.world);
  web.world = pktrt_scene_create(&desc);
  if (!web.world) return web_fail(pktrt_last_error(NULL));
  const pktrt_status status = scene_add_at(web.world, &web.built_in, time, shutter);
  if (status == PKTRT_OUT_OF_MEMORY) return web_fail("not enough memory for the scene");
  if (status != PKTRT_OK || pktrt_commit(web.world) != PKTRT_OK) return web_fail(pktrt_last_error(web.world));
  web.time = time, web.shutter = shutter;
  return 0;
}

/* Makes a scene and builds it, at rest. Area lights get light_size times their width, at the same power. */
WEB_EXPORT int web_open(unsigned number, double light_size) {
  pktrt_scene_destroy(web.world); /* first, so that two scenes need not be there at once */
  web.world = NULL;
  web.from_file = false;
  scene_free(&web.built_in);
  if (!scene_make(web_scene_name(number), &web.built_in)) return web_fail("no such scene, or not enough memory for it");
  if (light_size > 0) scene_resize_lights(&web.built_in, light_size);
  web.view.camera = web.built_in.camera;
  memcpy(web.view.background, web.built_in.background, sizeof web.view.background);
  memcpy(web.view.ambient, web.built_in.ambient, sizeof web.view.ambient);
  web.view.environment = web.built_in.environment;
  web.triangles = (double)scene_triangles(&web.built_in);
  return build(0, 0);
}

/* Opens the model that web_model_room has been filled with. If that fails, the scene of before stays. */
WEB_EXPORT int web_open_model(double light_size) {
  pktrt_render_desc view = web.view;
  double triangles = 0;
  pktrt_scene *const made = web_model_scene(light_size > 0 ? light_size : 1, &view, &triangles);
  if (!made) return web_fail("there is not enough memory for the model");
  pktrt_scene_destroy(web.world);
  scene_free(&web.built_in);
  web.world = made;
  web.view = view;
  web.built_in.camera = view.camera;
  web.triangles = triangles;
  web.from_file = true;
  web.time = web.shutter = 0;
  return 0;
}

/* Lets things move to where they are at `time`, a part of the animation, by a refit. While the shutter is open, for a part
   of the animation too, what moves has two keys: opening and shutting it builds everything anew. */
WEB_EXPORT int web_pose(double time, double shutter) {
  if (!web.world) return web_fail("there is no scene");
  if (web.from_file) return 0;
  if ((shutter > 0) != (web.shutter > 0)) return build(time, shutter);
  if (time == web.time && shutter == web.shutter) return 0;
  if (scene_pose(web.world, &web.built_in, time, shutter) != PKTRT_OK)
    return web_fail("not enough memory for the pose");
  if (pktrt_refit(web.world) != PKTRT_OK) return web_fail(pktrt_last_error(web.world));
  web.time = time, web.shutter = shutter;
  return 0;
}

/* Makes room for a picture; what was in it is lost if it is of another size. */
WEB_EXPORT int web_resize(unsigned width, unsigned height) {
  const size_t n = (size_t)width * height;
  if (web.view.pixels && width == web.view.width && height == web.view.height) return 0;
  free(web.view.pixels);
  free(web.cost);
  web.view.pixels = (float *)calloc(n * 3, sizeof(float));
  web.cost = (float *)calloc(n, sizeof(float));
  web.view.width = width, web.view.height = height;
  return web.view.pixels && web.cost ? 0 : web_fail("not enough memory for the picture");
}

/* Looks from the eye to the target. Diameter of the lens, and the distance that is sharp (0: the target's). */
WEB_EXPORT void web_camera(double eye_x, double eye_y, double eye_z, double target_x, double target_y, double target_z,
    double aperture, double focus) {
  pktrt_camera *c = &web.view.camera;
  c->eye[0] = (float)eye_x, c->eye[1] = (float)eye_y, c->eye[2] = (float)eye_z;
  c->target[0] = (float)target_x, c->target[1] = (float)target_y, c->target[2] = (float)target_z;
  c->aperture = (float)aperture, c->focus = (float)focus;
}

/* Mode as in pktrt_mode, rays along a packet's edge, and what is counted for web_cost: 0 nothing, else, less 1, a
   pktrt_cost. Rays that could add less than `attenuation` are not followed; 0: the library's own 1/256. */
WEB_EXPORT void web_settings(unsigned mode, unsigned packet, unsigned cost, double attenuation) {
  web.view.mode = (pktrt_mode)mode;
  web.view.packet_size = packet;
  web.view.cost = cost ? web.cost : NULL;
  web.view.attenuation = (float)attenuation;
  web.view.cost_of = (pktrt_cost)(cost ? cost - 1 : 0);
}

/* Path as in pktrt_path, steps of the paper's path as in pktrt_paper_step, and whether web_work is to know of the next
   bands. Where it is not, paths count nothing that they need not. */
WEB_EXPORT void web_path(unsigned path, unsigned steps, unsigned counted) {
  web.view.path = (pktrt_path)path;
  web.view.paper_steps = steps;
  web.view.stats = counted ? &web.stats : NULL;
}

/* Renders rows of a pass into their place. These are the passes of pktrt_render: their mean is its picture, but for the
   rounding of sums. A pass has another seed, as in >>tiles of the header; the page sums up passes by itself, for no
   worker sees all of a picture. */
WEB_EXPORT int web_render_band(unsigned y, unsigned rows, unsigned samples, unsigned pass) {
  pktrt_render_desc view = web.view;
  if (!web.world || !view.pixels) return web_fail("there is no scene or no picture");
  view.camera.time = 0; /* the shutter is open from the first key to the last */
  view.camera.shutter = web.shutter > 0 ? 1 : 0;
  view.samples = samples;
  memset(&web.stats, 0, sizeof web.stats);
  view.seed = pass * 0x9E3779B9u;
  return pktrt_render_tile(web.world, &view, 0, y, view.width, rows) == PKTRT_OK
             ? 0
             : web_fail("the picture could not be rendered: a setting is out of range, or memory is lacking");
}

/* Three linear floats for each pixel, row 0 at the top. Resizing moves them, and so may growth of the memory. */
WEB_EXPORT const float *web_pixels(void) { return web.view.pixels; }

/* Boxes or triangles tested for a sample of each pixel, if web_settings asked for it. */
WEB_EXPORT const float *web_cost(void) { return web.cost; }

/* Of the latest band: rays of all types, nodes opened, tests of a ray against a box, and against a triangle. The fast path
   counts rays alone. */
WEB_EXPORT const double *web_work(void) {
  static double told[4];
  memset(told, 0, sizeof told);
  for (int type = 0; type < PKTRT_RAY_TYPE_COUNT; type++) {
    const pktrt_counts *c = &web.stats.by_type[type];
    told[0] += (double)c->rays;
    told[1] += (double)c->node_visits;
    told[2] += (double)c->box_tests;
    told[3] += (double)c->triangle_tests;
  }
  return told;
}

/* The scene's own camera: eye, target, vertical angle in degrees, aperture, focus. */
WEB_EXPORT const float *web_first_camera(void) {
  static float told[9];
  const pktrt_camera *c = &web.built_in.camera;
  memcpy(told, c->eye, sizeof c->eye);
  memcpy(told + 3, c->target, sizeof c->target);
  told[6] = c->fov_y > 0 ? c->fov_y : 45, told[7] = c->aperture, told[8] = c->focus;
  return told;
}

WEB_EXPORT double web_triangles(void) { return web.triangles; }

/* FNV-1a over the bits of all pixels, in hexadecimal digits: that of build/render for the same picture. */
WEB_EXPORT const char *web_checksum(void) {
  static char digits[17];
  const size_t n = (size_t)web.view.width * web.view.height * 3;
  uint64_t sum = 14695981039346656037u;
  for (size_t i = 0; web.view.pixels && i < n; i++) {
    uint32_t bits;
    memcpy(&bits, &web.view.pixels[i], 4);
    for (int b = 0; b < 32; b += 8) sum = (sum ^ (bits >> b & 255)) * 1099511628211u;
  }
  snprintf(digits, sizeof digits, "%016llx", (unsigned long long)sum);
  return digits;
}
