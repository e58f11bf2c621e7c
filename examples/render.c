/* Renders a scene or a mesh file: the command line of pktrt.h. `render --help` says what it takes.
   Everything that arrives from outside, arguments and files, is checked before it is used; what is wrong is said in one line. */
#include "common.h"

#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

#include "mesh_file.h"
#include "scenes.h"
#include <getopt.h>
#include <limits.h>

/* >>options -------------------------------------------------------------------------------------------------------- */

typedef struct options {
  const char *scene, *mesh, *output;
  unsigned width, height, packet, tile, threads;
  pktrt_mode mode;
  pktrt_path path;
  pktrt_isa isa;
  bool up_z, has_camera, progress, count;
  float camera[6]; /* eye, target */
} options;

static const char *const mode_names[] = {"rcs", NULL};
static const char *const path_names[] = {"fast", "paper", "single", NULL};
static const char *const up_names[] = {"y", "z", NULL};

static void print_help(void) {
  printf("usage: render [--scene NAME | --mesh FILE] [options] [-o FILE]\n\n"
         "  --scene NAME     a built-in scene (default %s):",
         scene_names()[0]);
  for (int i = 0; scene_names()[i]; i++) printf(" %s", scene_names()[i]);
  printf("\n"
         "  --mesh FILE      a mesh: .tri%s\n"
         "  --camera EX,EY,EZ,TX,TY,TZ\n"
         "                   eye and target (default: the scene's, or one that frames the mesh)\n"
         "  --up y|z         what is up in a mesh file (default y)\n"
         "  --mode rcs       ray casting with shadows\n"
         "  --size WxH       picture size in pixels (default 1024x1024)\n"
         "  --packet N       rays along a packet's edge: 2, 4, 8 or 16 (default 8)\n"
         "  --path PATH      fast, paper or single (default fast): all give the same picture\n"
         "  --isa ISA        scalar, sse2, avx2, avx512 or neon (default: the widest here)\n"
         "  --threads N      threads for build and picture (default: one per processor)\n"
         "  --tile N         pixels along a tile's edge, 1 to 1024 (default 64)\n"
         "  --no-count       do not count rays and tests, which costs a little time\n"
         "  --no-progress    no progress bar; without a terminal there is none anyway\n"
         "  -o FILE          .png (8 bit sRGB) or .pfm (linear floats); without it no picture is written\n"
         "  --help           this text\n",
#ifdef HAVE_ASSIMP
         ", and what assimp reads: .obj .ply .gltf .glb .stl ..."
#else
         " (built without assimp: nothing else)"
#endif
  );
}

/* A decimal number, alone, within [lo, hi]. */
static bool parse_uint(const char *name, const char *text, unsigned long lo, unsigned long hi, unsigned *value) {
  char *end = NULL;
  errno = 0;
  unsigned long v = strtoul(text, &end, 10);
  if (text[0] < '0' || text[0] > '9' || *end || errno || v < lo || v > hi)
    return ex_fail("--%s: \"%s\" is not a whole number from %lu to %lu", name, text, lo, hi);
  *value = (unsigned)v;
  return true;
}

static bool parse_size(const char *text, unsigned *width, unsigned *height) {
  char first[16];
  const char *x = strchr(text, 'x');
  if (!x || (size_t)(x - text) >= sizeof first) return ex_fail("--size: \"%s\" is not of the form 1024x768", text);
  memcpy(first, text, (size_t)(x - text));
  first[x - text] = 0;
  return parse_uint("size", first, 1, EX_MAX_SIZE, width) && parse_uint("size", x + 1, 1, EX_MAX_SIZE, height);
}

/* The place of text in a list of words, which is also the value of the enumeration. */
static bool parse_word(const char *name, const char *text, const char *const *words, int *value) {
  char all[128] = "";
  for (int i = 0; words[i]; i++) {
    if (!strcmp(text, words[i])) {
      *value = i;
      return true;
    }
    snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", i ? ", " : "", words[i]);
  }
  return ex_fail("--%s: \"%s\" is none of: %s", name, text, all);
}

static bool parse_isa(const char *text, pktrt_isa *isa) {
  for (int i = PKTRT_ISA_SCALAR; i <= PKTRT_ISA_NEON; i++)
    if (!strcmp(text, pktrt_isa_string((pktrt_isa)i))) {
      *isa = (pktrt_isa)i;
      return pktrt_isa_available(*isa) || ex_fail("--isa: this machine or this build has no %s", text);
    }
  return ex_fail("--isa: \"%s\" is none of: scalar, sse2, avx2, avx512, neon", text);
}

static bool parse_camera(const char *text, float camera[6]) {
  const char *at = text;
  for (int i = 0; i < 6; i++) {
    char *end = NULL;
    camera[i] = strtof(at, &end);
    if (end == at || !(fabsf(camera[i]) <= 1e18f) || *end != (i < 5 ? ',' : '\0'))
      return ex_fail("--camera: \"%s\" is not six numbers with commas between, each up to 1e18", text);
    at = end + 1;
  }
  for (int i = 0; i < 3; i++)
    if (camera[i] != camera[3 + i]) return true;
  return ex_fail("--camera: eye and target are the same point");
}

static bool parse_packet(const char *text, unsigned *packet) {
  return parse_uint("packet", text, 2, 16, packet) && (*packet == 2 || *packet == 4 || *packet == 8 || *packet == 16 ||
                                                       ex_fail("--packet: %s is none of: 2, 4, 8, 16", text));
}

static bool parse_output(const char *text, const char **output) {
  *output = text;
  return ex_has_suffix(text, ".png") || ex_has_suffix(text, ".pfm") ||
         ex_fail("-o: \"%s\" ends neither in .png nor in .pfm", text);
}

static bool parse_scene(const char *text, const char **name) {
  int i = 0;
  if (!parse_word("scene", text, scene_names(), &i)) return false;
  *name = scene_names()[i];
  return true;
}

static bool parse_option(options *o, int option) {
  int word = 0;
  bool ok = true;
  switch (option) {
  case 's': return parse_scene(optarg, &o->scene);
  case 'm': o->mesh = optarg; return true;
  case 'o': return parse_output(optarg, &o->output);
  case 'c': o->has_camera = true; return parse_camera(optarg, o->camera);
  case 'S': return parse_size(optarg, &o->width, &o->height);
  case 'p': return parse_packet(optarg, &o->packet);
  case 'i': return parse_isa(optarg, &o->isa);
  case 't': return parse_uint("threads", optarg, 1, EX_MAX_THREADS, &o->threads);
  case 'T': return parse_uint("tile", optarg, 1, 1024, &o->tile);
  case 'M':
    ok = parse_word("mode", optarg, mode_names, &word);
    o->mode = (pktrt_mode)word;
    return ok;
  case 'P':
    ok = parse_word("path", optarg, path_names, &word);
    o->path = (pktrt_path)word;
    return ok;
  case 'u':
    ok = parse_word("up", optarg, up_names, &word);
    o->up_z = word == 1;
    return ok;
  case 'n': o->progress = false; return true;
  case 'C': o->count = false; return true;
  case 'h': print_help(); exit(0);
  }
  return false;
}

static bool parse_options(options *o, int argc, char **argv) {
  static const struct option list[] = {{"scene", required_argument, NULL, 's'},
                                       {"mesh", required_argument, NULL, 'm'},
                                       {"camera", required_argument, NULL, 'c'},
                                       {"up", required_argument, NULL, 'u'},
                                       {"mode", required_argument, NULL, 'M'},
                                       {"size", required_argument, NULL, 'S'},
                                       {"packet", required_argument, NULL, 'p'},
                                       {"path", required_argument, NULL, 'P'},
                                       {"isa", required_argument, NULL, 'i'},
                                       {"threads", required_argument, NULL, 't'},
                                       {"tile", required_argument, NULL, 'T'},
                                       {"no-count", no_argument, NULL, 'C'},
                                       {"no-progress", no_argument, NULL, 'n'},
                                       {"help", no_argument, NULL, 'h'},
                                       {NULL, 0, NULL, 0}};
  memset(o, 0, sizeof *o);
  o->width = o->height = 1024;
  o->packet = 8;
  o->tile = 64;
  o->threads = ex_processors();
  o->progress = o->count = true;
  opterr = 0; /* our own line instead */
  for (;;) {
    int at = optind, option = getopt_long(argc, argv, "o:h", list, NULL);
    if (option == -1) break;
    if (option == '?')
      return ex_fail("%s: unknown, ambiguous, or its value is missing or too much; see --help", argv[at]);
    if (!parse_option(o, option)) return false;
  }
  if (optind < argc) return ex_fail("%s: an argument without an option; see --help", argv[optind]);
  if (o->scene && o->mesh) return ex_fail("--scene and --mesh exclude each other");
  if (!o->scene && !o->mesh) o->scene = scene_names()[0];
  return true;
}

/* >>views ---------------------------------------------------------------------------------------------------------- */

/* A camera that sees the whole bounding sphere, from the front, a little right and above. In double, whose range holds squares
   of any coordinate that the library takes. */
static void frame_bounds(const pktrt_scene_info *info, const options *o, pktrt_camera *camera) {
  static const double from[2][3] = {{0.45, 0.35, 0.82}, {0.45, -0.82, 0.35}}; /* y up, z up */
  double center[3], radius = 0, aspect = (double)o->width / o->height;
  for (int a = 0; a < 3; a++) {
    double lo = (double)info->bounds_lo[a], hi = (double)info->bounds_hi[a];
    center[a] = 0.5 * (lo + hi);
    radius += 0.25 * (hi - lo) * (hi - lo);
  }
  radius = radius > 0 ? sqrt(radius) : 1;
  camera->fov_y = 40;
  /* sin(20 degrees) = 0.342; a picture higher than wide sees less across: there tan shrinks with the aspect */
  double tangent = 0.364 * (aspect < 1 ? aspect : 1), distance = radius * sqrt(1 + tangent * tangent) / tangent;
  for (int a = 0; a < 3; a++) {
    camera->target[a] = (float)center[a];
    camera->eye[a] = (float)(center[a] + distance * from[o->up_z][a]);
  }
}

static bool add_light(pktrt_scene *world, const pktrt_light *light) {
  return pktrt_add_light(world, light, NULL) == PKTRT_OK || ex_fail("%s", pktrt_last_error(world));
}

/* Light for a mesh that brings none: a key light like a sun from above, behind the camera's left shoulder, and a weaker point
   light beside the camera, which also lights interiors. */
static bool light_mesh(pktrt_scene *world, const options *o, const pktrt_camera *camera) {
  double to[3], length = 0, side[3];
  for (int a = 0; a < 3; a++) {
    to[a] = (double)camera->target[a] - (double)camera->eye[a];
    length += to[a] * to[a];
  }
  length = sqrt(length);
  const int up = o->up_z ? 2 : 1, x = 0, z = o->up_z ? 1 : 2;
  side[up] = 0; /* horizontal, to the camera's right: view x up, whose sign turns with what is up */
  side[x] = (o->up_z ? to[z] : -to[z]) / length;
  side[z] = (o->up_z ? -to[x] : to[x]) / length;
  pktrt_light key, fill;
  memset(&key, 0, sizeof key);
  memset(&fill, 0, sizeof fill);
  key.kind = PKTRT_LIGHT_DIRECTIONAL;
  fill.kind = PKTRT_LIGHT_POINT;
  for (int a = 0; a < 3; a++) {
    const double above = a == up ? 1 : 0;
    key.direction[a] = (float)(to[a] / length + 0.7 * side[a] - 1.1 * above);
    key.intensity[a] = 2.0f;
    fill.position[a] = (float)((double)camera->eye[a] + length * (0.25 * side[a] + 0.02 * above));
    fill.intensity[a] = (float)fmin(0.6 * length * length, 1e36);
  }
  return add_light(world, &key) && add_light(world, &fill);
}

/* >>scene ---------------------------------------------------------------------------------------------------------- */

typedef struct job {
  options given;
  pktrt_scene *world;
  scene built_in; /* zeroed for --mesh */
  pktrt_render_desc view;
  pktrt_stats stats;
  double load_seconds, build_seconds, render_seconds;
} job;

static bool commit(job *j) {
  double start = ex_seconds();
  if (pktrt_commit(j->world) != PKTRT_OK) return ex_fail("%s", pktrt_last_error(j->world));
  j->build_seconds = ex_seconds() - start;
  return true;
}

static void take_camera(job *j) {
  const options *o = &j->given;
  if (!o->has_camera) return;
  memcpy(j->view.camera.eye, o->camera, sizeof j->view.camera.eye);
  memcpy(j->view.camera.target, o->camera + 3, sizeof j->view.camera.target);
}

static bool load_built_in(job *j) {
  double start = ex_seconds();
  if (!scene_make(j->given.scene, &j->built_in)) return ex_fail("%s: not enough memory for the scene", j->given.scene);
  if (scene_add(j->world, &j->built_in) != PKTRT_OK)
    return ex_fail("%s: %s", j->given.scene, pktrt_last_error(j->world));
  j->view.camera = j->built_in.camera;
  memcpy(j->view.background, j->built_in.background, sizeof j->view.background);
  memcpy(j->view.ambient, j->built_in.ambient, sizeof j->view.ambient);
  take_camera(j);
  j->load_seconds = ex_seconds() - start;
  return commit(j);
}

static bool load_mesh(job *j) {
  const options *o = &j->given;
  double start = ex_seconds();
  pktrt_scene_info info;
  if (!mesh_file_load(j->world, o->mesh)) return false;
  j->load_seconds = ex_seconds() - start;
  if (!commit(j)) return false;
  pktrt_get_scene_info(j->world, &info);
  frame_bounds(&info, o, &j->view.camera);
  take_camera(j);
  j->view.camera.up[o->up_z ? 2 : 1] = 1;
  for (int c = 0; c < 3; c++) j->view.ambient[c] = 0.05f, j->view.background[c] = 0.08f + 0.03f * (float)c;
  return light_mesh(j->world, o, &j->view.camera);
}

/* >>picture -------------------------------------------------------------------------------------------------------- */

/* Finds out before the work, not after it, whether the picture can be written. Opened for appending: nothing is lost yet. */
static bool probe_output(const char *path) {
  if (!path) return true;
  FILE *file = fopen(path, "ab");
  if (!file) return ex_fail("%s: cannot be written: %s", path, strerror(errno));
  fclose(file);
  return true;
}

static bool render(job *j) {
  const options *o = &j->given;
  pktrt_render_desc *view = &j->view;
  ex_progress progress;
  view->pixels = (float *)calloc((size_t)o->width * o->height * 3, sizeof(float));
  if (!view->pixels) return ex_fail("not enough memory for a picture of %u x %u", o->width, o->height);
  view->width = o->width;
  view->height = o->height;
  view->mode = o->mode;
  view->packet_size = o->packet;
  view->tile_size = o->tile;
  view->path = o->path;
  view->stats = o->count ? &j->stats : NULL;
  view->progress = ex_progress_show;
  view->user = &progress;
  ex_progress_start(&progress, o->progress);
  double start = ex_seconds();
  pktrt_status status = pktrt_render(j->world, view);
  j->render_seconds = ex_seconds() - start;
  ex_progress_end(&progress);
  if (status != PKTRT_OK) return ex_fail("%s", pktrt_last_error(j->world));
  return !o->output || ex_write_picture(o->output, view->pixels, o->width, o->height);
}

/* >>table ---------------------------------------------------------------------------------------------------------- */

/* FNV-1a over the bits of the linear pixels: equal sums for equal pictures. */
static uint64_t checksum(const float *pixels, size_t n) {
  uint64_t sum = 14695981039346656037u;
  for (size_t i = 0; i < n; i++) {
    uint32_t bits;
    memcpy(&bits, &pixels[i], 4);
    for (int b = 0; b < 32; b += 8) sum = (sum ^ (bits >> b & 255)) * 1099511628211u;
  }
  return sum;
}

static void print_counts(const char *name, const pktrt_counts *c, double seconds) {
  double rays = c->rays ? (double)c->rays : 1;
  printf("  %-10s %12llu", name, (unsigned long long)c->rays);
  if (seconds > 0) printf(" %9.2f", 1e-6 * (double)c->rays / seconds);
  else printf(" %9s", "");
  printf(" %11.2f %16.2f %10.2f\n", (double)c->box_tests / rays, (double)c->triangle_tests / rays,
         100 * (double)c->hits / rays);
}

static void print_rays(const job *j) {
  static const char *const names[PKTRT_RAY_TYPE_COUNT] = {"primary", "shadow", "reflection", "refraction", "other"};
  pktrt_counts all;
  int types = 0;
  memset(&all, 0, sizeof all);
  printf("\n  %-10s %12s %9s %11s %16s %10s\n", "rays", "count", "Mrays/s", "boxes/ray", "triangles/ray", "hit %");
  for (int t = 0; t < PKTRT_RAY_TYPE_COUNT; t++) {
    const pktrt_counts *c = &j->stats.by_type[t];
    if (!c->rays) continue;
    types++;
    all.rays += c->rays;
    all.hits += c->hits;
    all.box_tests += c->box_tests;
    all.triangle_tests += c->triangle_tests;
    print_counts(names[t], c, 0); /* types alternate packet by packet: only all together have a time */
  }
  print_counts("all", &all, j->render_seconds);
}

static void print_table(const job *j) {
  const options *o = &j->given;
  pktrt_scene_info info;
  pktrt_get_scene_info(j->world, &info);
  printf("scene    %s: %llu triangles in %lu meshes\n", o->mesh ? o->mesh : o->scene,
         (unsigned long long)info.triangles, (unsigned long)info.mesh_count);
  printf("picture  %u x %u, %s, %s path, %s, packets %u x %u, tiles %u, threads %u\n", o->width, o->height,
         mode_names[o->mode], path_names[o->path], pktrt_isa_string(info.isa), o->packet, o->packet, o->tile,
         o->threads);
  printf("tree     %llu bytes, %llu nodes, %llu leaf blocks; meshes %llu bytes\n", (unsigned long long)info.tree_bytes,
         (unsigned long long)info.nodes, (unsigned long long)info.leaf_blocks, (unsigned long long)info.mesh_bytes);
  printf("seconds  scene %.3f, build %.3f, render %.3f%s\n", j->load_seconds, j->build_seconds, j->render_seconds,
         o->count ? " (with counting; --no-count is a little faster)" : "");
  printf("pixels   checksum %016llx\n", (unsigned long long)checksum(j->view.pixels, (size_t)o->width * o->height * 3));
  if (o->count) print_rays(j);
}

int main(int argc, char **argv) {
  static job j; /* static: zeroed */
  ex_threads threads = {1};
  pktrt_scene_desc desc;
  if (!parse_options(&j.given, argc, argv) || !probe_output(j.given.output)) return 1;
  threads.count = j.given.threads;
  memset(&desc, 0, sizeof desc);
  desc.isa = j.given.isa;
  desc.parallel_for = ex_parallel_for;
  desc.user = &threads;
  j.world = pktrt_scene_create(&desc);
  bool ok = j.world ? (j.given.mesh ? load_mesh(&j) : load_built_in(&j)) && render(&j)
                    : ex_fail("%s", pktrt_last_error(NULL));
  if (ok) print_table(&j);
  free(j.view.pixels);
  scene_free(&j.built_in);
  pktrt_scene_destroy(j.world);
  if (ok && fflush(stdout) != 0) ok = ex_fail("the table could not be written: %s", strerror(errno));
  return ok ? 0 : 1;
}
