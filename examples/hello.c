/* A pyramid on a floor, ray cast with shadows, as a PNG.    cc -O2 examples/hello.c -o hello -lm && ./hello */
#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

enum { WIDTH = 640, HEIGHT = 480 };
static float pixels[HEIGHT][WIDTH][3];      /* linear RGB, as rendered */
static unsigned char png[HEIGHT][WIDTH][3]; /* the same, as a screen wants it */

/* What the library wonders about, such as a scene without light. */
static void warn(void *user, int level, const char *sentence) {
  (void)user;
  if (level == 0) fprintf(stderr, "warning: %s\n", sentence);
}

int main(int argc, char **argv) {
  static const float floor_xyz[] = {-9, 0, -9, -9, 0, 9, 9, 0, 9, 9, 0, -9};
  static const uint32_t floor_triangles[] = {0, 1, 2, 0, 2, 3};
  static const float pyramid_xyz[] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1, 0, 1.5f, 0};
  static const uint32_t pyramid_triangles[] = {0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4};
  static pktrt_scene_desc setup;
  static pktrt_mesh_desc ground, pyramid; /* static, hence zeroed, hence full of sensible defaults */
  static pktrt_material red;
  static pktrt_light sun;
  static pktrt_render_desc view;
  ground.positions = floor_xyz, ground.vertex_count = 4;
  ground.indices = floor_triangles, ground.triangle_count = 2;
  pyramid.positions = pyramid_xyz, pyramid.vertex_count = 5;
  pyramid.indices = pyramid_triangles, pyramid.triangle_count = 4;
  red.albedo[0] = 0.75f, red.albedo[1] = 0.2f, red.albedo[2] = 0.12f;
  pyramid.material = 1; /* the first that is added */
  sun.kind = PKTRT_LIGHT_DIRECTIONAL;
  sun.direction[0] = -4, sun.direction[1] = -2, sun.direction[2] = 0.6f;
  sun.intensity[0] = 3.8f, sun.intensity[1] = 3.6f, sun.intensity[2] = 3.1f;
  view.width = WIDTH, view.height = HEIGHT, view.pixels = &pixels[0][0][0];
  view.camera.eye[0] = 2, view.camera.eye[1] = 2.5f, view.camera.eye[2] = 4, view.camera.target[1] = 0.5f;
  view.background[0] = 0.25f, view.background[1] = 0.4f, view.background[2] = 0.7f;
  view.ambient[0] = view.ambient[1] = view.ambient[2] = 0.15f; /* so that shadows are not black */

  setup.log = warn;
  pktrt_scene *scene = pktrt_scene_create(&setup);
  if (pktrt_add_material(scene, &red, NULL) || pktrt_add_mesh(scene, &ground, NULL) ||
      pktrt_add_mesh(scene, &pyramid, NULL) || pktrt_add_light(scene, &sun, NULL) || pktrt_commit(scene) ||
      pktrt_render(scene, &view))
    return fprintf(stderr, "error: %s\n", pktrt_last_error(scene)), 1;
  pktrt_scene_destroy(scene);

  pktrt_to_srgb8(view.pixels, WIDTH * HEIGHT, 0, PKTRT_TONE_CLAMP, &png[0][0][0]);
  if (!stbi_write_png(argc > 1 ? argv[1] : "hello.png", WIDTH, HEIGHT, 3, png, 0))
    return fprintf(stderr, "error: the picture could not be written\n"), 1;
  return 0;
}
