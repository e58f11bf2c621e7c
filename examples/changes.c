/* What an editor or a game changes while it runs: a lamp moves, a slider makes a material duller, and a car turns round. For each frame
   of four: pktrt_set_light, pktrt_set_material, pktrt_set_transforms and a refit, and a picture, out/changes-0.png to -3.png; then one
   where the lamp was removed. No tree over triangles is built after the first commit. */
#include "common.h"

#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

enum { FRAMES = 5, WIDTH = 320, HEIGHT = 200, CAR_BOXES = 6 };

static float pixels[3 * WIDTH * HEIGHT];

/* Adds a car of a body, a cabin and four wheels as a model of one mesh, whose triangles have two materials. Its length is along x. */
static bool add_car(pktrt_scene *scene, uint32_t paint, uint32_t *model) {
  static const float boxes[CAR_BOXES][2][3] = {{{-1, 0.2f, -0.45f}, {1, 0.6f, 0.45f}},
      {{-0.55f, 0.6f, -0.4f}, {0.35f, 0.95f, 0.4f}}, {{-0.75f, 0, -0.5f}, {-0.4f, 0.35f, -0.4f}},
      {{0.4f, 0, -0.5f}, {0.75f, 0.35f, -0.4f}}, {{-0.75f, 0, 0.4f}, {-0.4f, 0.35f, 0.5f}},
      {{0.4f, 0, 0.4f}, {0.75f, 0.35f, 0.5f}}};
  /* Of a box whose corner i has the larger x, y, z where bits 0, 1, 2 of i are set: counter-clockwise from outside. */
  static const uint32_t faces[12][3] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4}, {2, 6, 7},
      {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  static float corners[CAR_BOXES][8][3];
  static uint32_t triangles[CAR_BOXES][12][3], materials[CAR_BOXES][12];
  static pktrt_mesh_desc car;
  for (uint32_t i = 0; i < CAR_BOXES; i++) {
    for (uint32_t c = 0; c < 8; c++)
      for (int a = 0; a < 3; a++) corners[i][c][a] = boxes[i][c >> a & 1][a];
    for (uint32_t t = 0; t < 12; t++) {
      for (int c = 0; c < 3; c++) triangles[i][t][c] = 8 * i + faces[t][c];
      materials[i][t] = i < 2 ? paint : 0;
    }
  }
  car.positions = corners[0][0], car.vertex_count = 8 * CAR_BOXES;
  car.indices = triangles[0][0], car.triangle_count = 12 * CAR_BOXES;
  car.triangle_materials = materials[0];
  return pktrt_add_model(scene, &car, 1, model) == PKTRT_OK;
}

/* Places the car at an angle and 20 degrees farther on, as two keys: it turns while the shutter is open. Columns, as in OpenGL. */
static void pose(float angle, float keys[24]) {
  for (int k = 0; k < 2; k++) {
    const float a = angle + 0.35f * (float)k, c = cosf(a), s = sinf(a);
    const float columns[16] = {c, 0, -s, 0, 0, 1, 0, 0, s, 0, c, 0, 0.9f * c, 0, -0.9f * s, 1};
    pktrt_transform_from_4x4(columns, keys + 12 * k);
  }
}

static void say(void *user, int level, const char *sentence) {
  (void)user;
  if (level == 0) fprintf(stderr, "warning: %s\n", sentence);
}

int main(void) {
  static const float ground_corners[4][3] = {{-9, 0, -9}, {-9, 0, 9}, {9, 0, 9}, {9, 0, -9}};
  static const uint32_t ground_faces[2][3] = {{0, 1, 2}, {0, 2, 3}};
  static pktrt_scene_desc desc;
  static pktrt_mesh_desc ground;
  static pktrt_instance_desc car;
  static pktrt_material paint;
  static pktrt_light lamp, sky;
  static pktrt_render_desc view;
  uint32_t material, light;
  float keys[24];

  desc.log = say;
  pktrt_scene *scene = pktrt_scene_create(&desc);
  if (!scene) return ex_fail("%s", pktrt_last_error(NULL)), 1;
  ground.positions = ground_corners[0], ground.vertex_count = 4, ground.indices = ground_faces[0],
  ground.triangle_count = 2;
  paint.specular = PKTRT_SPECULAR_MIRROR, paint.lobe = PKTRT_LOBE_PHONG, paint.exponent = 1000;
  paint.albedo[0] = 0.5f, paint.albedo[1] = paint.albedo[2] = 0.05f;
  lamp.kind = PKTRT_LIGHT_QUAD, lamp.edge[0][0] = lamp.edge[1][2] = 1.2f, lamp.visible = true;
  sky.kind = PKTRT_LIGHT_ENVIRONMENT;
  for (int a = 0; a < 3; a++) {
    paint.reflectance[a] = 0.4f, lamp.intensity[a] = 14, sky.intensity[a] = 1,
    view.background[a] = 0.15f + 0.05f * (float)a;
  }
  lamp.position[1] = 4;
  bool ok = !pktrt_add_material(scene, &paint, &material) && !pktrt_add_mesh(scene, &ground, NULL) &&
            add_car(scene, material, &car.model) && !pktrt_add_light(scene, &lamp, &light) &&
            !pktrt_add_light(scene, &sky, NULL);
  pose(0, keys);
  car.transforms = keys, car.key_count = 2;
  car.interpolation = PKTRT_INTERPOLATION_RIGID; /* between its keys it turns, where it would shrink else */
  ok = ok && !pktrt_add_instance(scene, &car, NULL) && !pktrt_commit(scene);

  view.width = WIDTH, view.height = HEIGHT, view.pixels = pixels, view.mode = PKTRT_MODE_DRT, view.samples = 32;
  view.camera.eye[0] = 1, view.camera.eye[1] = 2.4f, view.camera.eye[2] = 5, view.camera.target[1] = 0.4f;
  view.camera.fov_y = 35, view.camera.shutter = 1;
  for (int frame = 0; ok && frame < FRAMES; frame++) {
    const float part = 0.25f * (float)frame;
    char name[] = "out/changes-0.png";
    name[12] = (char)('0' + frame);
    lamp.position[0] = 3 * part - 2;
    paint.exponent = 1000 * (1 - part) * (1 - part) + 10;
    pose(6.2831853f * part, keys);
    ok = !(part < 1 ? pktrt_set_light(scene, light, &lamp) : pktrt_remove_light(scene, light));
    ok = ok && !pktrt_set_material(scene, material, &paint) && !pktrt_set_transforms(scene, 0, keys) &&
         !pktrt_refit(scene) && !pktrt_render(scene, &view);
    if (ok && !ex_write_picture(name, pixels, WIDTH, HEIGHT)) return 1;
  }
  if (!ok) ex_fail("%s", pktrt_last_error(scene));
  pktrt_scene_destroy(scene);
  return ok ? 0 : 1;
}
