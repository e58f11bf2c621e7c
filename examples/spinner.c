/* A thing spins in the terminal: for each frame a matrix, a refit and a picture. `spinner [FRAMES]`, 60 unless told. */
#include "common.h"
#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

int main(int argc, char **argv) {
  static float corners[24][3], pixels[48][48][3];
  static pktrt_mesh_desc mesh; /* static, hence zeroed: what is not set is a sensible default */
  static pktrt_instance_desc instance;
  static pktrt_light lamp;
  static pktrt_render_desc view;
  const unsigned frames = ex_only_argument(argc, argv, "FRAMES", 60, 1, 1000000);
  for (int i = 0; i < 24; i++) corners[i][i % 3] = i / 3 >> i % 3 & 1 ? 1.0f : -1.0f; /* a triangle in each octant */
  mesh.positions = corners[0], mesh.vertex_count = 24, mesh.triangle_count = 8;
  lamp.position[0] = -3, lamp.position[1] = 3, lamp.position[2] = 4, lamp.intensity[0] = 99, view.ambient[0] = 0.1f;
  view.width = view.height = 48, view.pixels = pixels[0][0], view.camera.eye[1] = 1, view.camera.eye[2] = 3;
  pktrt_scene *scene = pktrt_scene_create(NULL);
  bool ok = scene && !pktrt_add_model(scene, &mesh, 1, NULL) && !pktrt_add_instance(scene, &instance, NULL) &&
            !pktrt_add_light(scene, &lamp, NULL) && !pktrt_commit(scene);
  for (unsigned frame = 0; ok && frame < frames; frame++, usleep(30000)) {
    const float a = 0.05f * (float)frame, m[] = {cosf(a), 0, sinf(a), 0, 0, 1, 0, 0, -sinf(a), 0, cosf(a), 0};
    ok = !pktrt_set_transform(scene, 0, 0, m) && !pktrt_refit(scene) && !pktrt_render(scene, &view);
    printf("%s", frame ? "\x1b[24A" : ""); /* back up, over the last picture */
    for (int i = 0; i < 49 * 24; i++)      /* every second row: a character is twice as high as wide */
      putchar(i % 49 < 48 ? " .:-=+*#%@"[(int)(9 * fminf(pixels[i / 49 * 2][i % 49][0], 1))] : '\n');
  }
  if (!ok) ex_fail("%s", pktrt_last_error(scene));
  return pktrt_scene_destroy(scene), ok ? 0 : 1;
}
