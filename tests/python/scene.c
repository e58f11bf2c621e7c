/* The scenes of examples/scenes.h as a library that Python loads: it fills a pktrt_scene that Python has made, for
   pictures that build/render makes, too. */
#include "../../pktrt.h"

#include "../../examples/scenes.h"

extern bool scene_for_python(
    pktrt_scene *to, const char *name, pktrt_camera *camera, float background[3], float ambient[3]);

/* At rest. The scene is kept: materials may point into it. false: there is none of that name. */
bool scene_for_python(pktrt_scene *to, const char *name, pktrt_camera *camera, float background[3], float ambient[3]) {
  static scene made;
  scene_free(&made);
  if (!scene_make(name, &made) || scene_add(to, &made) != PKTRT_OK) return false;
  *camera = made.camera;
  memcpy(background, made.background, sizeof made.background);
  memcpy(ambient, made.ambient, sizeof made.ambient);
  return true;
}
