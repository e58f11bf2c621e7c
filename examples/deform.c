/* Animates a scene: for each frame the deforming meshes get their pose, the tree is refitted, and a Whitted picture is
   made.

   The connectivity of the meshes stays, and so do the nodes of the tree; only its boxes follow. That takes a few
   milliseconds where a build takes ten times that, but boxes that things have moved out of each other's way for fit
   worse and worse. The surface area heuristic tells how much: it is the expected number of nodes that a random line
   visits. `deform --help` */
#include "common.h"

#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

#include "scenes.h"
#include <getopt.h>

typedef struct options {
  const char *scene;
  unsigned frames, width, height;
  int rebuild; /* a pktrt_rebuild */
} options;

static const char *const rebuild_names[] = {"advise", "never", "automatic", NULL};

static void print_help(void) {
  printf("usage: deform [options]: writes out/deform-000.png, out/deform-001.png, ...\n\n"
         "  --scene NAME     which scene (default rtrt):");
  for (int i = 0; scene_names()[i]; i++) printf(" %s", scene_names()[i]);
  printf("\n  --frames N       of the loop, 1 to 1000 (default 24)\n"
         "  --size WxH       in pixels (default 512x512)\n"
         "  --rebuild WHAT   if the tree has become bad: advise (say so, default), never, automatic\n");
}

static bool parse_options(options *o, int argc, char **argv) {
  static const struct option list[] = {{"scene", required_argument, NULL, 's'},
      {"frames", required_argument, NULL, 'f'}, {"size", required_argument, NULL, 'S'},
      {"rebuild", required_argument, NULL, 'r'}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};
  bool ok = true;
  int word = 0;
  o->scene = "rtrt", o->frames = 24, o->width = o->height = 512, o->rebuild = PKTRT_REBUILD_ADVISE;
  opterr = 0;
  while (ok) {
    int at = optind, option = getopt_long(argc, argv, "h", list, NULL);
    if (option == -1) break;
    switch (option) {
    case 's':
      ok = ex_parse_word("scene", optarg, scene_names(), &word);
      o->scene = scene_names()[word];
      break;
    case 'f': ok = ex_parse_uint("frames", optarg, 1, 1000, &o->frames); break;
    case 'S': ok = ex_parse_size(optarg, &o->width, &o->height); break;
    case 'r': ok = ex_parse_word("rebuild", optarg, rebuild_names, &o->rebuild); break;
    case 'h': print_help(); exit(0);
    default: ok = ex_fail("%s: unknown, ambiguous, or its value is missing; see --help", argv[at]);
    }
  }
  return ok && (optind >= argc || ex_fail("%s: an argument without an option; see --help", argv[optind]));
}

/* One frame, and its line in the table. */
static bool animate(pktrt_scene *world, const scene *s, const options *o, unsigned frame, pktrt_render_desc *view) {
  const double time = (double)frame / o->frames;
  char path[64];
  pktrt_scene_info before, after;
  pktrt_get_scene_info(world, &before);
  const double start = ex_seconds();
  if (scene_pose(world, s, time, 0) != PKTRT_OK) return ex_fail("frame %u could not be posed", frame);
  const double posed = ex_seconds();
  if (pktrt_refit(world) != PKTRT_OK) return ex_fail("%s", pktrt_last_error(world));
  const double fitted = ex_seconds();
  scene_camera(s, time, &view->camera);
  view->camera.time = view->camera.shutter = view->camera.aperture = 0; /* an instant and a pinhole, all that WRT has */
  if (pktrt_render(world, view) != PKTRT_OK) return ex_fail("%s", pktrt_last_error(world));
  const double rendered = ex_seconds();
  pktrt_get_scene_info(world, &after);
  printf("  %03u %9.2f %9.2f %9.3f %9.2f %9.2f%s\n", frame, 1e3 * (posed - start), 1e3 * (fitted - posed),
      rendered - fitted, after.sah_now, after.sah_at_build,
      after.rebuild_advised                       ? "  rebuild advised"
      : after.sah_at_build != before.sah_at_build ? "  rebuilt"
                                                  : "");
  fflush(stdout);
  snprintf(path, sizeof path, "out/deform-%03u.png", frame);
  return ex_write_picture(path, view->pixels, o->width, o->height);
}

static bool animation(pktrt_scene *world, const scene *s, const options *o) {
  pktrt_render_desc view;
  bool ok = true;
  memset(&view, 0, sizeof view);
  view.mode = PKTRT_MODE_WRT;
  view.width = o->width, view.height = o->height;
  view.camera = s->camera;
  memcpy(view.background, s->background, sizeof view.background);
  memcpy(view.ambient, s->ambient, sizeof view.ambient);
  view.environment = s->environment;
  if (scene_add(world, s) != PKTRT_OK || pktrt_commit(world) != PKTRT_OK)
    return ex_fail("%s: %s", o->scene, pktrt_last_error(world));
  view.pixels = (float *)calloc((size_t)o->width * o->height * 3, sizeof(float));
  if (!view.pixels) return ex_fail("not enough memory for a picture of %u x %u", o->width, o->height);
  printf("frame   pose ms  refit ms  render s   SAH now  at build\n");
  for (unsigned frame = 0; ok && frame < o->frames; frame++) ok = animate(world, s, o, frame, &view);
  free(view.pixels);
  return ok;
}

int main(int argc, char **argv) {
  options o;
  scene s;
  pktrt_scene_desc desc;
  ex_threads threads = ex_threads_of(ex_processors());
  memset(&desc, 0, sizeof desc);
  if (!parse_options(&o, argc, argv)) return 1;
  if (!scene_make(o.scene, &s)) return ex_fail("%s: not enough memory for the scene", o.scene), 1;
  desc.parallel_for = ex_parallel_for;
  desc.user = &threads;
  desc.log = ex_log;
  desc.rebuild = (pktrt_rebuild)o.rebuild;
  pktrt_scene *world = pktrt_scene_create(&desc);
  bool ok = world ? animation(world, &s, &o) : ex_fail("%s", pktrt_last_error(NULL));
  pktrt_scene_destroy(world);
  ex_threads_stop(&threads);
  scene_free(&s);
  return ok ? 0 : 1;
}
