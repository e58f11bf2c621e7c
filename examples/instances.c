/* A field of ten thousand moving things, of one model: frames in which all of them move, and a picture with their shadows.

   A model is built once, instances place it by 3 x 4 matrices. Moving them all is ten thousand calls of
   pktrt_set_transform and a refit of the tree above their boxes; what lies in the models is not touched. With two keys an
   instance also moves while the shutter is open. `instances [SIDE]`: SIDE x SIDE of them, 100 unless told. */
#include "common.h"

#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

#include "output.h"

enum {
  RINGS = 12,
  SIDES = 24,
  VERTICES = (RINGS + 1) * SIDES,
  TRIANGLES = RINGS * SIDES * 2,
  WIDTH = 768,
  HEIGHT = 432
};

static float top[VERTICES][3], pixels[WIDTH * HEIGHT * 3];
static uint32_t faces[TRIANGLES][3];

/* A spinning top: radii over height, turned about y. */
static void make_top(void) {
  uint32_t n = 0;
  for (uint32_t i = 0; i <= RINGS; i++)
    for (uint32_t j = 0; j < SIDES; j++) {
      const float h = (float)i / (float)RINGS, angle = 6.2831853f * (float)j / (float)SIDES;
      const float radius =
          0.33f * sqrtf(h) * (h < 0.7f ? 1 : 1.05f - powf((h - 0.7f) / 0.3f, 2)) * (1 + 0.08f * cosf(3 * angle));
      top[i * SIDES + j][0] = radius * cosf(angle), top[i * SIDES + j][1] = h,
                      top[i * SIDES + j][2] = radius * sinf(angle);
    }
  for (uint32_t i = 0; i < RINGS; i++)
    for (uint32_t j = 0; j < SIDES; j++) {
      const uint32_t a = i * SIDES + j, b = i * SIDES + (j + 1) % SIDES;
      const uint32_t both[2][3] = {{a, a + SIDES, b}, {b, a + SIDES, b + SIDES}};
      memcpy(faces[n], both, sizeof both), n += 2;
    }
}

/* Where top i of `side` x `side` stands at a time: it wanders in a circle, leans, and spins. */
static void place(unsigned i, unsigned side, float time, float m[12]) {
  const float phase = (float)(i * 2654435761u >> 8) / 16777216 * 6.2831853f, spin = 20 * time + phase;
  const float lean = 0.25f * sinf(3 * time + phase), c = cosf(spin), s = sinf(spin);
  const float rows[12] = {c, lean, s, (float)(i % side) - 0.5f * (float)side + 0.3f * cosf(time + phase), 0, 1, 0, 0,
      -s, lean, c, (float)(i / side) - 0.5f * (float)side + 0.3f * sinf(time + phase)};
  memcpy(m, rows, sizeof rows);
}

/* Moves all of them to a time; they go on for a moment, the second key. */
static bool move(pktrt_scene *scene, unsigned side, float time) {
  float m[12];
  for (uint32_t i = 0; i < side * side; i++)
    for (uint32_t key = 0; key < 2; key++) {
      place(i, side, time + 0.01f * (float)key, m);
      if (pktrt_set_transform(scene, i, key, m)) return false;
    }
  return pktrt_refit(scene) == PKTRT_OK;
}

static bool fill(pktrt_scene *scene, unsigned side) {
  static const float corner[4][3] = {{-500, 0, -500}, {-500, 0, 500}, {500, 0, 500}, {500, 0, -500}};
  static const uint32_t half[2][3] = {{0, 1, 2}, {0, 2, 3}};
  pktrt_mesh_desc ground, mesh;
  pktrt_instance_desc instance;
  pktrt_material red;
  pktrt_light sun;
  memset(&ground, 0, sizeof ground), memset(&mesh, 0, sizeof mesh), memset(&instance, 0, sizeof instance);
  memset(&sun, 0, sizeof sun), memset(&red, 0, sizeof red);
  ground.positions = corner[0], ground.vertex_count = 4, ground.indices = half[0], ground.triangle_count = 2;
  mesh.positions = top[0], mesh.vertex_count = VERTICES, mesh.indices = faces[0], mesh.triangle_count = TRIANGLES;
  red.albedo[0] = 0.75f, red.albedo[1] = 0.25f, red.albedo[2] = 0.2f;
  sun.kind = PKTRT_LIGHT_DIRECTIONAL, sun.direction[0] = -3, sun.direction[1] = -4, sun.direction[2] = -1;
  for (int a = 0; a < 3; a++) sun.intensity[a] = 2.5f;
  if (pktrt_add_material(scene, &red, &mesh.material) || pktrt_add_light(scene, &sun, NULL)) return false;
  if (pktrt_add_model(scene, &mesh, 1, &instance.model)) return false;
  for (unsigned i = 0; i < side * side; i++) { /* first, so that their meshes have the numbers of instances */
    float keys[24];
    place(i, side, 0, keys), place(i, side, 0.01f, keys + 12);
    instance.key_count = 2, instance.transforms = keys;
    if (pktrt_add_instance(scene, &instance, NULL)) return false;
  }
  return !pktrt_add_mesh(scene, &ground, NULL) && !pktrt_commit(scene);
}

static bool show(pktrt_scene *scene, unsigned side) {
  pktrt_render_desc view;
  pktrt_scene_info info;
  memset(&view, 0, sizeof view);
  view.width = WIDTH, view.height = HEIGHT, view.pixels = pixels, view.mode = PKTRT_MODE_DRT, view.samples = 16;
  view.camera.eye[1] = 6, view.camera.eye[2] = 0.5f * (float)side + 8, view.camera.fov_y = 30, view.camera.shutter = 1;
  view.camera.target[1] = -1, view.camera.target[2] = 0.25f * (float)side;
  for (int a = 0; a < 3; a++) view.ambient[a] = 0.25f, view.background[a] = 0.5f + 0.15f * (float)a;
  double start = ex_seconds();
  const int frames = 10;
  for (int i = 1; i <= frames; i++)
    if (!move(scene, side, 0.02f * (float)i)) return false;
  pktrt_get_scene_info(scene, &info);
  printf("%u instances: %.2f ms to move all of them; %.2f MB of trees and meshes\n", side * side,
      1e3 * (ex_seconds() - start) / frames, (double)(info.tree_bytes + info.mesh_bytes) / 1e6);
  start = ex_seconds();
  if (pktrt_render(scene, &view)) return false;
  printf("%d x %d pixels, 16 samples: %.2f s\n", WIDTH, HEIGHT, ex_seconds() - start);
  return true;
}

int main(int argc, char **argv) {
  const unsigned side = ex_only_argument(argc, argv, "SIDE", 100, 1, 1000);
  ex_threads threads = ex_threads_of(ex_processors());
  pktrt_scene_desc desc;
  memset(&desc, 0, sizeof desc);
  desc.parallel_for = ex_parallel_for, desc.user = &threads, desc.log = ex_log;
  make_top();
  pktrt_scene *scene = pktrt_scene_create(&desc);
  const bool ok = scene && fill(scene, side) && show(scene, side);
  if (!ok) ex_fail("%s", pktrt_last_error(scene));
  pktrt_scene_destroy(scene);
  ex_threads_stop(&threads);
  return ok && ex_write_picture("out/instances.png", pixels, WIDTH, HEIGHT) ? 0 : 1;
}
