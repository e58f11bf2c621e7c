/* Renders a scene or a mesh file: the command line of pktrt.h. `render --help` says what it takes. A file is seen
   with its materials and textures (material_file.h says how they are mapped), under its lights and by its camera if
   it has any. Everything that arrives from outside, arguments and files, is checked before it is used; what is
   wrong is said in one line. */
#include "common.h"

#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

#include "filter.h"
#include "heat.h"
#include "image.h"
#include "mesh_file.h"
#include "mesh_view.h"
#include "output.h"
#include "scenes.h"
#include "words.h"
#include <getopt.h>

/* >>options -------------------------------------------------------------------------------------------------------- */

enum {
  MANY_LIGHTS = 16,
  MAX_FRAMES = 1000000,
  MAX_INSTANCES = 1000000,
  DRT_SAMPLES = 64,
  WHITTED_SAMPLES = 4,
  PASS_SAMPLES = 8
};

typedef struct options {
  const char *scene, *mesh, *environment, *output, *buffers, *error_map;
  unsigned width, height, packet, tile, threads, samples, seed, depth, frame, frames;
  unsigned instances;                                          /* 0: the scene itself */
  unsigned passes;                                             /* 0: as many as it takes */
  int mode, path, sampler, assembly, branching, glass_shadows; /* values of the library's enumerations */
  int normals, shadows, phong, tone;                           /* the same */
  int measure, heat, lights;                                   /* such values; -1: not given */
  unsigned said_samples, said_passes;                          /* before others are chosen */
  int said_measure;
  pktrt_isa isa;
  bool up_z, has_camera, has_frame, has_mode, progress, count, adaptive, explain, filter;
  float camera[6];                             /* eye, target */
  double aperture, focus, shutter, light_size; /* negative: not given */
  double attenuation;                          /* negative: off; 0: the library's own */
  double exposure;                             /* 0: by the picture; negative: not given */
  double target_error, time;                   /* 0: not given */
} options;

static const char *const assembly_names[] = {"types", "runs", "materials", "octants", "blind", "none", NULL};
static const char *const branching_names[] = {"mode", "both", "choose", "first", NULL};
static const char *const light_names[] = {"all", "one", "one-everywhere", NULL};
static const char *const glass_names[] = {"pass", "block", NULL};
static const char *const normal_names[] = {"smooth", "geometric", NULL};
static const char *const shadow_names[] = {"per-light", "together", NULL};
static const char *const phong_names[] = {"careful", "naive", NULL};
static const char *const tone_names[] = {"clamp", "curve", NULL};
static const char *const up_names[] = {"y", "z", NULL};
static const char *const measure_names[] = {"rmse", "relative", "display", NULL};

static void print_help_picture(void) {
  printf("\nthe picture:\n"
         "  --mode MODE      rcs: ray casting with shadows (default, but for mesh files that reflect or shine)\n"
         "                   wrt: Whitted's, with mirrors and glass\n"
         "                   drt: distribution ray tracing, with lens, shutter, area lights and gloss\n"
         "  --size WxH       in pixels (default 1024x1024)\n"
         "  --spp N          samples per pixel, 1 to 65536 (default: drt %d, else %d)\n",
      DRT_SAMPLES, WHITTED_SAMPLES);
  print_words("  --sampler NAME   where the samples lie:", sampler_words());
  printf(
      "  --seed N         of the sampler (default 0)\n"
      "  --depth N        generations of secondary rays, 1 to %d (default %d)\n"
      "  --attenuation A  do not follow rays that could add less than this to a sample, or off (default 1/256)\n"
      "  --branching WHEN at glass: follow both rays, choose one, both where a primary ray ends and choose deeper, or\n"
      "                   as the mode does (default):",
      PKTRT_MAX_DEPTH, PKTRT_MAX_DEPTH);
  print_words("", branching_names);
  printf(
      "  --lights all|one drt: deeper than where a primary ray ends, ask all lights or one at random (default all,\n"
      "                   or from 17 lights of a mesh file on one-everywhere);\n"
      "                   one-everywhere: one where it ends, too, as for the 1,000 of --scene lamps\n"
      "  --glass-shadows pass|block\n"
      "                   whether light passes glass (default pass; rcs: block)\n"
      "  --normals smooth|geometric\n"
      "                   interpolated where the mesh has normals (default), or of the triangle everywhere\n"
      "  --phong careful|naive\n"
      "                   drt: how directions of glossy reflections are drawn (default careful; naive to compare)\n"
      "  --exposure E     factor on the picture as it is written, or auto: nine tenths of it stay below 0.8 (default: "
      "1,\n"
      "                   of a mesh file with lights auto)\n"
      "  --tone NAME      of a .png: clamp (default), or curve, which keeps what is brighter than white\n"
      "  -o FILE          .png (8 bit sRGB) or .pfm (linear floats); without it no picture is written. A device or\n"
      "                   a pipe of any other name gets a .png\n"
      "  --heat WHAT      instead of the picture what it costs: boxes, triangles or vectors (paper path) tested per "
      "sample;\n"
      "                   finer for small --packet; .png: in colours, white is the number beside the bar; .pfm: "
      "numbers\n"
      "  --buffers PREFIX also write PREFIX-depth.pfm, PREFIX-normal.pfm and PREFIX-albedo.pfm\n");
}

static void print_help_error(void) {
  printf(
      "\nhow wrong it may be by chance:\n"
      "  --passes N       2 to 65536 passes, independent of each other: the error is estimated from their scatter\n"
      "  --target-error E stop when the estimate is not above E; one that is unreliable does not count\n"
      "  --measure WHAT   what E means and --adaptive lowers; display: RMSE of the .png's channels, from 0 to 1, as\n"
      "                   --exposure and --tone show them (default for a .png, unless its exposure is by the "
      "picture);\n"
      "                   rmse: of a channel, in units of radiance (default otherwise);\n"
      "                   or relative: relative MSE, 0.0025 for 5%% of the radiance around\n"
      "  --time SECONDS   stop when another pass would take longer than this in all, building not counted\n"
      "                   (one is always made, adaptively two)\n"
      "  --adaptive       give passes to cells of 8 pixels by the error around them; --passes is a mean then. Without "
      "rules,\n"
      "                   --spp is a mean, made in 4 passes\n"
      "  --error-map FILE the error of each pixel; .pfm: in units of radiance, or of white where the measure is\n"
      "                   display; .png: as a part of white then, or else of the pixel's\n"
      "                   value, from black (0.1%% or less) over red (3%%) to white (100%% or more), green where\n"
      "                   it is unknown (a tenth of the mean is added to all values, for the sake of dark ones)\n"
      "  --filter         take noise out of the picture: pixels that passes cannot tell apart share their means. The\n"
      "                   samples are made in 2 to 8 passes; an error map is of the picture before\n"
      "With --passes, --target-error or --time, --spp is that of each pass (default %d), and the first of these\n"
      "rules stops. With --error-map alone, half of the samples each are made in two passes.\n",
      PASS_SAMPLES);
}

static void print_help_work(void) {
  printf("\nhow it is made, which changes no pixel:\n"
         "  --path PATH      fast, paper or single (default fast)\n"
         "  --packet N       rays along a packet's edge: 2, 4, 8 or 16 (default 8)\n"
         "  --assembly HOW   how secondary rays become packets:");
  print_words("", assembly_names);
  printf("                   (default types; materials, octants and blind are ways of the paper)\n"
         "  --shadows per-light|together\n"
         "                   packets of shadow rays: one for each light (default), or one for all lights\n"
         "  --isa ISA        sse2, avx2, neon, or, if built in, scalar or avx512 (default: the widest here)\n"
         "  --threads N      threads for build and picture (default: one per processor)\n"
         "  --tile N         pixels along a tile's edge, 1 to 1024 (default 64)\n"
         "  --explain        say first what the scene has, what of it runs, and where its bytes are\n"
         "  --no-count       do not count rays\n"
         "  --no-progress    no progress bar; without a terminal there is none anyway\n"
         "  --help           this text\n"
         "\nFiles get their names when all are written: a run that fails, or is ended by SIGINT, SIGTERM or\n"
         "SIGHUP, leaves none, and those of before as they were. Warnings and errors are lines on standard error.\n"
         "Exit status: 0, 1 after an error, 128 and the number of the signal (Ctrl-C: 130).\n");
}

static void print_help(void) {
  printf("usage: render [--scene NAME | --mesh FILE] [options] [-o FILE]\n\n");
  print_words("what is seen:\n  --scene NAME     a built-in scene (default the first):", scene_names());
  printf("  --frame N        its pose, and the camera on its path, at frame N (default: rest)\n"
         "  --frames N       frames of the animation, which is a loop (default 240)\n"
         "  --shutter S      part of the loop that the shutter stays open, 0 to 1 (default: drt one frame, else 0)\n"
         "  --light-size F   quads, spheres and lamp meshes F times as wide about their middles, power unchanged\n"
         "  --mesh FILE      a mesh: .tri%s\n"
         "                   Materials, textures, normals, lights, the first camera and instances are the file's; what "
         "is\n"
         "                   not used of it is said in one line. Files that reflect or shine are made in drt\n"
         "  --up y|z         what is up in a mesh file (default y)\n"
         "  --environment FILE\n"
         "                   a picture of all directions, twice as wide as high, lights what is seen: .hdr, or .png, "
         ".jpg,\n"
         "                   .bmp, .tga; in place of the light that a mesh else gets, beside a scene's own\n"
         "  --instances N    the mesh or scene as a model, built once and shown N times, 1 to %d, in a square\n"
         "                   field; a scene is then without its own lights and camera, seen and lit as a mesh is\n"
         "  --camera EX,EY,EZ,TX,TY,TZ\n"
         "                   eye and target (default: the scene's or file's, or one that frames the mesh)\n"
         "  --aperture D     diameter of the lens (default: the scene's; seen in drt)\n"
         "  --focus D        distance of what is sharp (default: the scene's, else that of the target)\n",
#ifdef HAVE_ASSIMP
      ", and what assimp reads: .obj .ply .gltf .glb .stl ...",
#else
      " (built without assimp: nothing else)",
#endif
      MAX_INSTANCES);
  print_help_picture();
  print_help_error();
  print_help_work();
}

static bool parse_isa(const char *text, pktrt_isa *isa) {
  for (int i = PKTRT_ISA_SCALAR; i < PKTRT_ISA_COUNT; i++)
    if (!strcmp(text, pktrt_isa_string((pktrt_isa)i))) {
      *isa = (pktrt_isa)i;
      return pktrt_isa_available(*isa) || ex_fail("--isa: this machine or this build has no %s%s", text,
                                              *isa == PKTRT_ISA_AVX512   ? " (PKTRT_AVX512 builds it)"
                                              : *isa == PKTRT_ISA_SCALAR ? " (PKTRT_SCALAR builds it)"
                                                                         : "");
    }
  return ex_fail("--isa: \"%s\" is none of: scalar, sse2, avx2, avx512, neon", text);
}

static bool parse_camera(const char *text, float camera[6]) {
  const char *at = text;
  for (int i = 0; i < 6; i++) {
    char *end = NULL;
    camera[i] = strtof(at, &end);
    if (end == at || !(fabsf(camera[i]) <= PKTRT_MAX_COORD) || *end != (i < 5 ? ',' : '\0'))
      return ex_fail("--camera: \"%s\" is not six numbers with commas between, each up to 2^100", text);
    at = end + 1;
  }
  for (int i = 0; i < 3; i++)
    if (camera[i] != camera[3 + i]) return true;
  return ex_fail("--camera: eye and target are the same point");
}

static bool parse_packet(const char *text, unsigned *packet) {
  return ex_parse_uint("packet", text, 2, 16, packet) &&
         (*packet == 2 || *packet == 4 || *packet == 8 || *packet == 16 ||
             ex_fail("--packet: %s is none of: 2, 4, 8, 16", text));
}

static bool parse_output(const char *option, const char *text, const char **output) {
  bool is_stdout;
  *output = text;
  return ex_has_suffix(text, ".png") || ex_has_suffix(text, ".pfm") || output_is_direct(text, &is_stdout) ||
         ex_fail("%s: \"%s\" ends neither in .png nor in .pfm", option, text);
}

static bool parse_scene(const char *text, const char **name) {
  int i = 0;
  if (!ex_parse_word("scene", text, scene_names(), &i)) return false;
  *name = scene_names()[i];
  return true;
}

static bool parse_up(const char *text, bool *up_z) {
  int word = 0;
  if (!ex_parse_word("up", text, up_names, &word)) return false;
  *up_z = word == 1;
  return true;
}

static bool parse_exposure(const char *text, double *exposure) {
  if (strcmp(text, "auto") != 0) return ex_parse_real("exposure", text, 1e-6, 1e6, exposure);
  *exposure = 0;
  return true;
}

/* To the library 0 means its default and a negative value off; here 0 is off, too, for it cuts nothing. */
static bool parse_attenuation(const char *text, double *attenuation) {
  if (!strcmp(text, "off")) *attenuation = 0;
  else if (!ex_parse_real("attenuation", text, 0, 1, attenuation)) return false;
  if (*attenuation <= 0) *attenuation = -1;
  return true;
}

/* clang-format off */
enum option_name {
  OPT_SCENE = 256, OPT_MESH, OPT_ENVIRONMENT, OPT_INSTANCES, OPT_CAMERA, OPT_UP, OPT_FRAME, OPT_FRAMES, OPT_SHUTTER, OPT_LIGHT_SIZE,
  OPT_APERTURE, OPT_FOCUS, OPT_MODE, OPT_SIZE, OPT_SPP, OPT_SAMPLER, OPT_SEED, OPT_DEPTH, OPT_ATTENUATION,
  OPT_BRANCHING, OPT_LIGHTS, OPT_GLASS_SHADOWS, OPT_NORMALS, OPT_SHADOWS, OPT_PHONG, OPT_EXPOSURE, OPT_TONE, OPT_HEAT, OPT_BUFFERS, OPT_PASSES,
  OPT_TARGET_ERROR, OPT_MEASURE, OPT_TIME, OPT_ADAPTIVE, OPT_ERROR_MAP, OPT_FILTER, OPT_PATH, OPT_PACKET, OPT_ASSEMBLY,
  OPT_ISA, OPT_THREADS, OPT_TILE, OPT_EXPLAIN, OPT_NO_COUNT, OPT_NO_PROGRESS
};
/* clang-format on */

static const struct option option_list[] = {{"scene", required_argument, NULL, OPT_SCENE},
    {"mesh", required_argument, NULL, OPT_MESH}, {"environment", required_argument, NULL, OPT_ENVIRONMENT},
    {"instances", required_argument, NULL, OPT_INSTANCES}, {"camera", required_argument, NULL, OPT_CAMERA},
    {"up", required_argument, NULL, OPT_UP}, {"frame", required_argument, NULL, OPT_FRAME},
    {"frames", required_argument, NULL, OPT_FRAMES}, {"shutter", required_argument, NULL, OPT_SHUTTER},
    {"light-size", required_argument, NULL, OPT_LIGHT_SIZE}, {"aperture", required_argument, NULL, OPT_APERTURE},
    {"focus", required_argument, NULL, OPT_FOCUS}, {"mode", required_argument, NULL, OPT_MODE},
    {"size", required_argument, NULL, OPT_SIZE}, {"spp", required_argument, NULL, OPT_SPP},
    {"sampler", required_argument, NULL, OPT_SAMPLER}, {"seed", required_argument, NULL, OPT_SEED},
    {"depth", required_argument, NULL, OPT_DEPTH}, {"attenuation", required_argument, NULL, OPT_ATTENUATION},
    {"branching", required_argument, NULL, OPT_BRANCHING}, {"lights", required_argument, NULL, OPT_LIGHTS},
    {"glass-shadows", required_argument, NULL, OPT_GLASS_SHADOWS}, {"normals", required_argument, NULL, OPT_NORMALS},
    {"shadows", required_argument, NULL, OPT_SHADOWS}, {"phong", required_argument, NULL, OPT_PHONG},
    {"exposure", required_argument, NULL, OPT_EXPOSURE}, {"tone", required_argument, NULL, OPT_TONE},
    {"heat", required_argument, NULL, OPT_HEAT}, {"buffers", required_argument, NULL, OPT_BUFFERS},
    {"passes", required_argument, NULL, OPT_PASSES}, {"target-error", required_argument, NULL, OPT_TARGET_ERROR},
    {"measure", required_argument, NULL, OPT_MEASURE}, {"time", required_argument, NULL, OPT_TIME},
    {"adaptive", no_argument, NULL, OPT_ADAPTIVE}, {"error-map", required_argument, NULL, OPT_ERROR_MAP},
    {"filter", no_argument, NULL, OPT_FILTER}, {"path", required_argument, NULL, OPT_PATH},
    {"packet", required_argument, NULL, OPT_PACKET}, {"assembly", required_argument, NULL, OPT_ASSEMBLY},
    {"isa", required_argument, NULL, OPT_ISA}, {"threads", required_argument, NULL, OPT_THREADS},
    {"tile", required_argument, NULL, OPT_TILE}, {"explain", no_argument, NULL, OPT_EXPLAIN},
    {"no-count", no_argument, NULL, OPT_NO_COUNT}, {"no-progress", no_argument, NULL, OPT_NO_PROGRESS},
    {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};

static bool parse_option(options *o, int option, const char *text) {
  switch (option) {
  case OPT_SCENE: return parse_scene(text, &o->scene);
  case OPT_MESH: o->mesh = text; return true;
  case OPT_ENVIRONMENT: o->environment = text; return true;
  case OPT_INSTANCES: return ex_parse_uint("instances", text, 1, MAX_INSTANCES, &o->instances);
  case OPT_CAMERA: o->has_camera = true; return parse_camera(text, o->camera);
  case OPT_UP: return parse_up(text, &o->up_z);
  case OPT_FRAME: o->has_frame = true; return ex_parse_uint("frame", text, 0, MAX_FRAMES - 1, &o->frame);
  case OPT_FRAMES: return ex_parse_uint("frames", text, 1, MAX_FRAMES, &o->frames);
  case OPT_SHUTTER: return ex_parse_real("shutter", text, 0, 1, &o->shutter);
  case OPT_LIGHT_SIZE: return ex_parse_real("light-size", text, 0.001, 1000, &o->light_size);
  case OPT_APERTURE: return ex_parse_real("aperture", text, 0, 1e6, &o->aperture);
  case OPT_FOCUS: return ex_parse_real("focus", text, 1e-6, 1e6, &o->focus);
  case OPT_MODE: o->has_mode = true; return ex_parse_word("mode", text, mode_words, &o->mode);
  case OPT_SIZE: return ex_parse_size(text, &o->width, &o->height);
  case OPT_SPP: return ex_parse_uint("spp", text, 1, 65536, &o->samples);
  case OPT_SAMPLER: return ex_parse_word("sampler", text, sampler_words(), &o->sampler);
  case OPT_SEED: return ex_parse_uint("seed", text, 0, UINT32_MAX, &o->seed);
  case OPT_DEPTH: return ex_parse_uint("depth", text, 1, PKTRT_MAX_DEPTH, &o->depth);
  case OPT_ATTENUATION: return parse_attenuation(text, &o->attenuation);
  case OPT_BRANCHING: return ex_parse_word("branching", text, branching_names, &o->branching);
  case OPT_LIGHTS: return ex_parse_word("lights", text, light_names, &o->lights);
  case OPT_GLASS_SHADOWS: return ex_parse_word("glass-shadows", text, glass_names, &o->glass_shadows);
  case OPT_NORMALS: return ex_parse_word("normals", text, normal_names, &o->normals);
  case OPT_SHADOWS: return ex_parse_word("shadows", text, shadow_names, &o->shadows);
  case OPT_PHONG: return ex_parse_word("phong", text, phong_names, &o->phong);
  case OPT_EXPOSURE: return parse_exposure(text, &o->exposure);
  case OPT_TONE: return ex_parse_word("tone", text, tone_names, &o->tone);
  case OPT_HEAT: return ex_parse_word("heat", text, heat_words, &o->heat);
  case OPT_BUFFERS: o->buffers = text; return true;
  case OPT_PASSES: return ex_parse_uint("passes", text, 2, 65536, &o->passes);
  case OPT_TARGET_ERROR: return ex_parse_real("target-error", text, 1e-9, 1e9, &o->target_error);
  case OPT_MEASURE: return ex_parse_word("measure", text, measure_names, &o->measure);
  case OPT_TIME: return ex_parse_real("time", text, 1e-3, 1e9, &o->time);
  case OPT_ADAPTIVE: o->adaptive = true; return true;
  case OPT_ERROR_MAP: return parse_output("--error-map", text, &o->error_map);
  case OPT_FILTER: o->filter = true; return true;
  case OPT_PATH: return ex_parse_word("path", text, path_words, &o->path);
  case OPT_PACKET: return parse_packet(text, &o->packet);
  case OPT_ASSEMBLY: return ex_parse_word("assembly", text, assembly_names, &o->assembly);
  case OPT_ISA: return parse_isa(text, &o->isa);
  case OPT_THREADS: return ex_parse_uint("threads", text, 1, EX_MAX_THREADS, &o->threads);
  case OPT_TILE: return ex_parse_uint("tile", text, 1, 1024, &o->tile);
  case OPT_EXPLAIN: o->explain = true; return true;
  case OPT_NO_COUNT: o->count = false; return true;
  case OPT_NO_PROGRESS: o->progress = false; return true;
  case 'o': return parse_output("-o", text, &o->output);
  case 'h': print_help(); exit(0);
  }
  return false;
}

/* Splits the samples into passes for the filter or adaptive ones, of at least two samples each where there are four. */
static bool split_samples(options *o) {
  if (o->filter && o->samples < 2) return ex_fail("--filter: one sample has no known error; see --spp, --passes");
  if (o->adaptive && o->samples < 8) return ex_fail("--adaptive: takes 8 samples at least; see --spp, --passes");
  o->passes = o->samples < 8 ? 2 : o->samples < 16 || o->adaptive ? 4 : 8;
  o->samples = (o->samples + o->passes - 1) / o->passes;
  return true;
}

/* What errors are measured by unless the options say so: as the file shows them, if it has 8 bits and its exposure is
   known before the picture. */
static int default_measure(const options *o, bool wanted) {
  const bool known = o->exposure > 0 || (o->exposure < 0 && !o->mesh);
  const bool eight_bits = o->output && !ex_has_suffix(o->output, ".pfm");
  return wanted && known && eight_bits && o->heat < 0 && !o->filter ? PKTRT_ERROR_DISPLAY : PKTRT_ERROR_RMSE;
}

/* One unsplit set of samples, or passes: by the options, or as two halves if nothing but their error is wanted. */
static bool complete_passes(options *o) {
  const bool rules = o->passes > 0 || o->target_error > 0 || o->time > 0;
  if (o->measure >= 0 && !o->adaptive && !(o->target_error > 0))
    return ex_fail("--measure: says how --target-error or --adaptive measure, and there is neither");
  if (o->measure == PKTRT_ERROR_DISPLAY && o->exposure == 0)
    return ex_fail("--measure display: --exposure auto is known after the picture only; give a number");
  if (o->measure < 0) o->measure = default_measure(o, o->adaptive || o->target_error > 0);
  if (o->samples == 0) o->samples = rules ? PASS_SAMPLES : o->mode == PKTRT_MODE_DRT ? DRT_SAMPLES : WHITTED_SAMPLES;
  if ((uint64_t)o->passes * o->samples > UINT32_MAX)
    return ex_fail("--passes, --spp: %u passes of %u samples are too many, 2^32 or more", o->passes, o->samples);
  if (o->filter && o->adaptive) return ex_fail("--filter, --adaptive: the filter takes passes over the whole picture");
  if (rules) return true;
  if (o->filter || o->adaptive) return split_samples(o);
  o->passes = o->error_map ? 2 : 1;
  if (o->error_map && o->samples < 2) return ex_fail("--error-map: one sample has no known error; see --spp, --passes");
  if (o->error_map) o->samples = (o->samples + 1) / 2;
  return true;
}

/* What only several options together can be wrong about, and the defaults that depend on other options. */
static bool complete_options(options *o) {
  if (o->scene && o->mesh) return ex_fail("--scene and --mesh exclude each other");
  if (o->mesh && (o->has_frame || o->shutter > 0)) return ex_fail("--frame, --shutter: a mesh file has no animation");
  if (o->mesh && o->light_size > 0) return ex_fail("--light-size: the lights of a mesh file have no size");
  if (o->instances > 0 && o->light_size > 0)
    return ex_fail("--light-size, --instances: a scene in instances is without its lights");
  if (o->frame >= o->frames) return ex_fail("--frame: %u is beyond the last of %u frames", o->frame, o->frames);
  if (o->heat == PKTRT_COST_VECTORS && o->path != PKTRT_PATH_PAPER)
    return ex_fail("--heat: vectors are counted on the paper path only; see --path");
  if (o->heat >= 0 && o->filter) return ex_fail("--heat, --filter: what a picture costs has no noise to take out");
  if (!o->scene && !o->mesh) o->scene = scene_names()[0];
  if (o->scene) o->up_z = false;
  if (o->shutter < 0) o->shutter = o->mode == PKTRT_MODE_DRT && !o->mesh ? 1.0 / o->frames : 0;
  o->said_samples = o->samples, o->said_passes = o->passes, o->said_measure = o->measure;
  return complete_passes(o);
}

static void default_options(options *o) {
  memset(o, 0, sizeof *o);
  o->width = o->height = 1024;
  o->packet = 8;
  o->tile = 64;
  o->depth = PKTRT_MAX_DEPTH;
  o->frames = 240;
  o->threads = ex_processors();
  o->progress = o->count = true;
  o->aperture = o->focus = o->shutter = o->light_size = -1;
  o->exposure = -1;
  o->measure = o->heat = o->lights = -1;
}

static bool parse_options(options *o, int argc, char **argv) {
  default_options(o);
  opterr = 0; /* our own line instead */
  for (;;) {
    int at = optind, option = getopt_long(argc, argv, "o:h", option_list, NULL);
    if (option == -1) break;
    if (option == '?')
      return ex_fail("%s: unknown, ambiguous, or its value is missing or too much; see --help", argv[at]);
    if (!parse_option(o, option, optarg)) return false;
  }
  if (optind < argc) return ex_fail("%s: an argument without an option; see --help", argv[optind]);
  return complete_options(o);
}

/* >>views ---------------------------------------------------------------------------------------------------------- */

/* What the pictures are of. */
static const char *seen_name(const options *o) { return o->mesh ? o->mesh : o->scene; }

/* >>environment ---------------------------------------------------------------------------------------------------- */

/* The picture of --environment, which is read once, and how it is looked at. */
static image sky_picture;
static image_environment_user sky_seen = {&sky_picture, 0, 1, false};

static void sky_of_file(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user; /* the render's, which is for its progress */
  image_environment(&sky_seen, n, direction, radiance);
}

/* >>scene ---------------------------------------------------------------------------------------------------------- */

enum { BUFFERS = 3 };
static const struct {
  const char *name;
  unsigned channels;
} buffer_kinds[BUFFERS] = {{"depth", 1}, {"normal", 3}, {"albedo", 3}};

enum { OUTPUT_PICTURE, OUTPUT_ERROR_MAP, OUTPUT_BUFFERS, OUTPUTS = OUTPUT_BUFFERS + BUFFERS };

typedef struct job {
  options given;
  output_file outputs[OUTPUTS];
  pktrt_scene *world;
  scene built_in; /* zeroed for --mesh */
  mesh_file file; /* zeroed for --scene */
  bool own_light; /* of the file */
  double exposure;
  pktrt_render_desc view;
  float *buffers[BUFFERS];
  float *error; /* of each pixel, for the map; NULL: not wanted */
  float *cost;  /* of each pixel, for --heat; NULL: not wanted */
  pktrt_report report;
  pktrt_stats stats;
  double load_seconds, build_seconds, render_seconds;
  filter_halves halves; /* of the passes, for --filter */
  double filter_seconds, filtered_rmse;
  bool filter_doubted; /* the estimate filtered_rmse is unreliable */
  uint64_t checksum;
} job;

static bool commit(job *j) {
  double start = ex_seconds();
  if (pktrt_commit(j->world) != PKTRT_OK) return ex_fail("%s", pktrt_last_error(j->world));
  j->build_seconds += ex_seconds() - start;
  return true;
}

/* Moving meshes get two keys, where they are when the shutter opens and when it closes. To the library, whose time
   runs from the first key to the last, the shutter is therefore open all the time. With --frame the camera travels
   meanwhile. */
static void take_animated_camera(job *j, double time) {
  const options *o = &j->given;
  pktrt_camera *camera = &j->view.camera, end;
  *camera = j->built_in.camera;
  if (o->has_frame) scene_camera(&j->built_in, time, camera);
  camera->time = 0;
  camera->shutter = o->shutter > 0 ? 1 : 0;
  if (!o->has_frame || !(o->shutter > 0)) return;
  end = *camera;
  scene_camera(&j->built_in, time + o->shutter - floor(time + o->shutter), &end);
  camera->moving = true;
  memcpy(camera->eye_end, end.eye, sizeof end.eye);
  memcpy(camera->target_end, end.target, sizeof end.target);
}

/* What the command line says of the camera. */
static void override_camera(job *j) {
  const options *o = &j->given;
  pktrt_camera *camera = &j->view.camera;
  if (o->has_camera) {
    memcpy(camera->eye, o->camera, sizeof camera->eye);
    memcpy(camera->target, o->camera + 3, sizeof camera->target);
    camera->focus = 0; /* the target's: the scene's own was made for another view */
    camera->moving = false;
  }
  if (o->aperture >= 0) camera->aperture = (float)o->aperture;
  if (o->focus > 0) camera->focus = (float)o->focus;
}

static bool load_built_in(job *j) {
  const options *o = &j->given;
  const double start = ex_seconds(), time = (double)o->frame / o->frames;
  if (!scene_make(o->scene, &j->built_in)) return ex_fail("%s: not enough memory for the scene", o->scene);
  if (o->light_size > 0) scene_resize_lights(&j->built_in, o->light_size);
  const pktrt_status status = scene_add_at(j->world, &j->built_in, time, o->shutter);
  if (status != PKTRT_OK)
    return ex_fail(
        "%s: %s", o->scene, status == PKTRT_OUT_OF_MEMORY ? "not enough memory" : pktrt_last_error(j->world));
  memcpy(j->view.background, j->built_in.background, sizeof j->view.background);
  memcpy(j->view.ambient, j->built_in.ambient, sizeof j->view.ambient);
  j->view.environment = j->built_in.environment;
  take_animated_camera(j, time);
  override_camera(j);
  j->load_seconds = ex_seconds() - start;
  return commit(j);
}

/* A view and light for what brings neither, or those of the file. */
static bool view_bounds(job *j) {
  const options *o = &j->given;
  pktrt_scene_info info;
  mesh_view view = {seen_name(o), (double)o->width / o->height, o->up_z, o->instances > 0, o->environment != NULL};
  bool ok = true;
  pktrt_get_scene_info(j->world, &info);
  const bool own_camera = j->file.has_camera && !o->has_camera && !view.field;
  if (own_camera) mesh_view_take_camera(&j->file, &info, &j->view.camera);
  else j->view.camera.fov_y = 40;
  if (!o->has_camera && !own_camera && !mesh_view_frame_bounds(&view, &info, &j->view.camera)) return false;
  override_camera(j);
  j->view.camera.shutter = o->shutter > 0 ? 1 : 0; /* as in take_animated_camera */
  if (!own_camera) j->view.camera.up[o->up_z ? 2 : 1] = 1;
  j->own_light = mesh_view_light(&view, o->mesh ? &j->file : NULL, j->world, &j->view, &ok);
  return ok;
}

/* Unless the command line says a mode, takes the one that alone shows what the file has: gloss and light with
   extent. */
static bool choose_mode(job *j) {
  options *o = &j->given;
  if (o->has_mode || !(j->file.scatters || j->file.lights > 0)) return true;
  o->mode = PKTRT_MODE_DRT;
  o->samples = o->said_samples;
  o->passes = o->said_passes;
  o->measure = o->said_measure;
  return complete_passes(o);
}

static bool has_area(job *j) {
  pktrt_scene_info info;
  pktrt_get_scene_info(j->world, &info);
  return info.degenerate < info.triangles ||
         ex_fail("%s: there is nothing to see: as floats, none of its %llu triangles has an area", seen_name(&j->given),
             (unsigned long long)info.triangles);
}

static bool load_mesh(job *j) {
  const options *o = &j->given;
  double start = ex_seconds();
  if (!mesh_file_open(&j->file, j->world, o->mesh, false)) return false;
  j->load_seconds = ex_seconds() - start;
  return choose_mode(j) && commit(j) && has_area(j) && view_bounds(j);
}

/* >>field ---------------------------------------------------------------------------------------------------------- */

/* Places in a row of the field, which has as many rows, or fewer where there is nothing to fill them. */
static unsigned field_side(const options *o) { return (unsigned)ceil(sqrt((double)o->instances)); }

static bool add_instance(job *j, uint32_t model, const float *transform) {
  pktrt_instance_desc instance;
  memset(&instance, 0, sizeof instance);
  instance.model = model;
  instance.transforms = transform;
  return pktrt_add_instance(j->world, &instance, NULL) == PKTRT_OK ||
         ex_fail("%s: %s", seen_name(&j->given), pktrt_last_error(j->world));
}

/* Shows a model where it was made, and when it is known how large that is, in the places to the right and behind. */
static bool place_instances(job *j, uint32_t model) {
  const options *o = &j->given;
  const unsigned side = field_side(o), back = o->up_z ? 1 : 2;
  pktrt_scene_info info;
  double step[3], largest = 0;
  if (!add_instance(j, model, NULL) || !commit(j) || !has_area(j)) return false;
  pktrt_get_scene_info(j->world, &info);
  for (int a = 0; a < 3; a++) {
    step[a] = 1.25 * ((double)info.bounds_hi[a] - (double)info.bounds_lo[a]);
    largest = fmax(largest, step[a]);
  }
  for (int a = 0; a < 3; a++) step[a] = fmax(step[a], 0.01 * largest); /* flat things stand behind each other, too */
  for (unsigned i = 1; i < o->instances; i++) {
    float place[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    place[3] = (float)(step[0] * (i % side));
    place[4 * back + 3] = (float)(step[back] * (i / side) * (o->up_z ? 1 : -1));
    if (!add_instance(j, model, place)) return false;
  }
  return commit(j);
}

static bool load_field(job *j) {
  const options *o = &j->given;
  const double start = ex_seconds();
  uint32_t model = 0;
  const bool loaded =
      o->mesh ? mesh_file_open(&j->file, j->world, o->mesh, true)
              : scene_make(o->scene, &j->built_in) || ex_fail("%s: not enough memory for the scene", o->scene);
  const double built = ex_seconds();
  j->load_seconds = built - start;
  pktrt_status status = PKTRT_OK;
  if (loaded)
    status = o->mesh ? pktrt_add_model(j->world, j->file.kept.mesh, j->file.kept.count, &model)
                     : scene_add_model(j->world, &j->built_in, (double)o->frame / o->frames, o->shutter, &model);
  j->build_seconds = ex_seconds() - built;
  mesh_file_free(&j->file.kept);
  if (status != PKTRT_OK)
    return ex_fail(
        "%s: %s", seen_name(o), status == PKTRT_OUT_OF_MEMORY ? "not enough memory" : pktrt_last_error(j->world));
  return loaded && choose_mode(j) && place_instances(j, model) && view_bounds(j);
}

/* Lights what is seen by the picture of --environment, in place of ambient light and of an environment of the scene. */
static bool add_environment(job *j) {
  bool is_light = false;
  if (!sky_picture.width && !image_load(&sky_picture, j->given.environment, true)) return false;
  sky_seen.up_z = j->given.up_z;
  j->view.environment = sky_of_file;
  memset(j->view.ambient, 0, sizeof j->view.ambient);
  if (j->given.instances == 0)
    for (size_t i = 0; i < j->built_in.light_count; i++)
      is_light = is_light || j->built_in.lights[i].kind == PKTRT_LIGHT_ENVIRONMENT;
  pktrt_light light;
  memset(&light, 0, sizeof light);
  light.kind = PKTRT_LIGHT_ENVIRONMENT;
  for (int c = 0; c < 3; c++) light.intensity[c] = 1;
  return is_light || mesh_view_add_light(j->world, &light);
}

/* What is seen, its tree, and where one looks from. */
static bool load(job *j) {
  const options *o = &j->given;
  const bool loaded = o->instances ? load_field(j) : o->mesh ? load_mesh(j) : load_built_in(j);
  return loaded && (!o->environment || add_environment(j));
}

/* >>picture -------------------------------------------------------------------------------------------------------- */

static bool name_output(output_file *file, const char *format, const char *option, const char *buffer) {
  const int n = snprintf(file->name, sizeof file->name, format, option, buffer);
  return (n > 0 && (size_t)n < sizeof file->name) || ex_fail("%.40s...: the name is too long", option);
}

/* Finds out before the work, not after it, whether the pictures can be written. */
static bool check_outputs(job *j) {
  const options *o = &j->given;
  output_file *files = j->outputs;
  bool ok = (!o->output || name_output(&files[OUTPUT_PICTURE], "%s", o->output, "")) &&
            (!o->error_map || name_output(&files[OUTPUT_ERROR_MAP], "%s", o->error_map, ""));
  for (int b = 0; ok && o->buffers && b < BUFFERS; b++)
    ok = name_output(&files[OUTPUT_BUFFERS + b], "%s-%s.pfm", o->buffers, buffer_kinds[b].name);
  for (int i = 0; ok && i < OUTPUTS; i++) ok = !files[i].name[0] || output_check(&files[i]);
  return ok;
}

static bool allocate(job *j) {
  const options *o = &j->given;
  const size_t pixels = (size_t)o->width * o->height;
  j->view.pixels = (float *)calloc(pixels * 3, sizeof(float));
  bool ok = j->view.pixels != NULL;
  for (int b = 0; ok && (o->buffers || o->filter) && b < BUFFERS; b++) {
    j->buffers[b] = (float *)calloc(pixels * buffer_kinds[b].channels, sizeof(float));
    ok = j->buffers[b] != NULL;
  }
  if (ok && o->error_map) {
    j->error = (float *)calloc(pixels, sizeof(float));
    ok = j->error != NULL;
  }
  if (ok && o->heat >= 0) {
    j->cost = (float *)calloc((size_t)o->width * o->height, sizeof *j->cost);
    ok = j->cost != NULL;
  }
  if (ok && o->filter) ok = filter_begin(&j->halves, o->width, o->height);
  j->view.depth = j->buffers[0], j->view.normal = j->buffers[1], j->view.albedo = j->buffers[2];
  return ok || ex_fail("not enough memory for a picture of %u x %u", o->width, o->height);
}

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

/* Colour of a relative error, linear: from black over red to white as its logarithm grows from 0.1% to 100%. */
static void error_colour(double error, float rgb[3]) {
  static const float none[3] = {0, 1, 0};
  if (error < INFINITY) heat_colour(error > 0 ? (log10(error) + 3) / 3 : 0, rgb);
  else memcpy(rgb, none, sizeof none);
}

/* The squared mean of the pixels in [x, x+w) x [y, y+h) whose error is known. */
static double squared_mean(const job *j, size_t x, size_t y, size_t w, size_t h) {
  double sum[3] = {0, 0, 0}, known = 0;
  for (size_t k = 0; k < w * h; k++) {
    const size_t i = (y + k / w) * j->given.width + x + k % w;
    if (!(j->error[i] < INFINITY)) continue;
    for (size_t c = 0; c < 3; c++) sum[c] += (double)j->view.pixels[3 * i + c];
    known++;
  }
  return known > 0 ? (sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]) / (known * known) : 0;
}

/* Relative as in the relative MSE, see pktrt_error_measure: block by block. pixel_error has sqrt(V / 3). Errors as
   shown are parts of white. */
static void colour_errors(const job *j, float *colours) {
  const size_t all = (size_t)j->given.width * j->given.height;
  for (size_t i = 0; j->view.measure == PKTRT_ERROR_DISPLAY && i < all; i++)
    error_colour((double)j->error[i], colours + 3 * i);
  if (j->view.measure == PKTRT_ERROR_DISPLAY) return;

  const size_t width = j->given.width, height = j->given.height, edge = PKTRT_ERROR_BLOCK;
  const double least = squared_mean(j, 0, 0, width, height) / 100;
  for (size_t y = 0; y < height; y += edge)
    for (size_t x = 0; x < width; x += edge) {
      const size_t w = width - x < edge ? width - x : edge, h = height - y < edge ? height - y : edge;
      const double scale = squared_mean(j, x, y, w, h) + least;
      for (size_t k = 0; k < w * h; k++) {
        const size_t i = (y + k / w) * width + x + k % w;
        const double error = (double)j->error[i];
        error_colour(error > 0 && scale > 0 ? sqrt(3 * error * error / scale) : error, colours + 3 * i);
      }
    }
}

/* To be called while the picture is as it was rendered. */
static bool write_error_map(job *j) {
  const options *o = &j->given;
  output_file *file = &j->outputs[OUTPUT_ERROR_MAP];
  const size_t n = (size_t)o->width * o->height;
  if (ex_has_suffix(o->error_map, ".pfm")) return output_write(file, j->error, o->width, o->height, 1);
  float *colours = (float *)malloc(n * 3 * sizeof *colours);
  if (!colours) return ex_fail("%s: not enough memory", o->error_map);
  colour_errors(j, colours);
  const bool ok = output_write(file, colours, o->width, o->height, 3);
  free(colours);
  return ok;
}

/* Paints over the picture. */
static bool write_heat(job *j) {
  const options *o = &j->given;
  output_file *file = &j->outputs[OUTPUT_PICTURE];
  if (ex_has_suffix(o->output, ".pfm")) return output_write(file, j->cost, o->width, o->height, 1);
  const double scale = heat_scale(j->cost, (size_t)o->width * o->height);
  const heat_picture to = {j->view.pixels, o->width, o->height};
  if (scale < 0) return ex_fail("%s: not enough memory", o->output);
  heat_paint(j->cost, scale, &to);
  return output_write(file, j->view.pixels, o->width, o->height, 3);
}

static bool write_pictures(job *j) {
  const options *o = &j->given;
  const size_t n = (size_t)o->width * o->height * 3;
  j->checksum = checksum(j->view.pixels, n); /* of what was rendered: exposure is a matter of looking at it */
  if (o->error_map && !write_error_map(j)) return false;
  if (o->exposure > 0) j->exposure = o->exposure;
  else if (o->exposure < 0 && (!j->own_light || j->view.measure == PKTRT_ERROR_DISPLAY)) j->exposure = 1;
  else j->exposure = mesh_view_exposure(&j->view, j->view.pixels);
  for (size_t i = 0; i < n; i++) j->view.pixels[i] *= (float)j->exposure;
  ex_tone = j->cost ? PKTRT_TONE_CLAMP : (pktrt_tone)o->tone;
  bool ok = !o->output || (j->cost ? write_heat(j)
                                   : output_write(&j->outputs[OUTPUT_PICTURE], j->view.pixels, o->width, o->height, 3));
  for (int b = 0; ok && o->buffers && b < BUFFERS; b++)
    ok = output_write(&j->outputs[OUTPUT_BUFFERS + b], j->buffers[b], o->width, o->height, buffer_kinds[b].channels);
  return ok;
}

/* All of them or none. A pipe that nobody reads any more is an error, not the end at once. */
static bool put_pictures(job *j) {
  void (*const before)(int) = signal(SIGPIPE, SIG_IGN);
  interrupt_does = INTERRUPT_WAITS;
  bool ok = !interrupt_number && write_pictures(j);
  interrupt_does = INTERRUPT_TOO_LATE;
  ok = ok && !interrupt_number;
  for (int i = 0; ok && i < OUTPUTS; i++) ok = output_publish(&j->outputs[i]);
  for (int i = 0; i < OUTPUTS; i++) output_discard(&j->outputs[i]);
  interrupt_does = INTERRUPT_ENDS;
  signal(SIGPIPE, before);
  return ok;
}

static void describe(job *j) {
  const options *o = &j->given;
  pktrt_render_desc *view = &j->view;
  view->width = o->width;
  view->height = o->height;
  view->mode = (pktrt_mode)o->mode;
  view->samples = o->samples;
  view->sampler = (pktrt_sampler)o->sampler;
  view->seed = o->seed;
  view->max_depth = o->depth;
  view->attenuation = (float)o->attenuation;
  view->branching = (pktrt_branching)o->branching;
  view->lights = (pktrt_light_choice)(o->lights >= 0 ? o->lights : j->file.lights > MANY_LIGHTS ? PKTRT_LIGHTS_ONE : 0);
  view->glass_shadows = (pktrt_glass_shadows)o->glass_shadows;
  view->normals = (pktrt_normals)o->normals;
  view->shadows = (pktrt_shadow_packets)o->shadows;
  view->phong_mapping = (pktrt_phong_mapping)o->phong;
  view->path = (pktrt_path)o->path;
  view->packet_size = o->packet;
  view->assembly = (pktrt_assembly)o->assembly;
  view->tile_size = o->tile;
  view->stats = o->count ? &j->stats : NULL;
  view->passes = o->passes;
  view->target_error = (float)o->target_error;
  view->measure = (pktrt_error_measure)o->measure;
  view->display_exposure = o->exposure > 0 ? (float)o->exposure : 0;
  view->display_tone = (pktrt_tone)o->tone;
  view->time_budget = o->time;
  view->adaptive = o->adaptive;
  view->report = &j->report;
  view->pixel_error = j->error;
  view->cost = j->cost;
  view->cost_of = (pktrt_cost)(j->cost ? o->heat : 0);
}

/* Before the picture, which may take long. */
static void explain(const job *j) {
  enum { ROOM = 4096 };
  char text[ROOM];
  pktrt_scene_report report;
  pktrt_get_scene_report(j->world, &j->view, &report);
  pktrt_scene_report_text(&report, text, sizeof text);
  printf("%s\n", text);
  fflush(stdout);
}

/* What the hooks of the render see. */
typedef struct watch {
  ex_progress progress;
  job *of;
} watch;

/* The bar, and false after an interrupt, which cancels the picture. */
static bool go_on(void *user, float done) {
  return ex_progress_show(&((watch *)user)->progress, done) && !interrupt_number;
}

static bool gather_pass(void *user, const pktrt_report *report) {
  job *j = ((watch *)user)->of;
  (void)report;
  filter_add_pass(&j->halves, j->view.pixels);
  filter_add_features(&j->halves, j->view.depth, j->view.normal, j->view.albedo);
  return true;
}

/* Filters in place, and sums up what error it leaves. */
static bool filter(job *j) {
  const size_t pixels = (size_t)j->given.width * j->given.height;
  const double start = ex_seconds();
  double sum = 0;
  filter_picture picture;
  if (!filter_finish(&j->halves, &picture)) return true; /* of one pass, which the table tells */
  picture.depth = j->buffers[0], picture.normal = j->buffers[1], picture.albedo = j->buffers[2];
  const size_t tiles = filter_tiles(&picture);
  float *error = (float *)malloc(pixels * sizeof *error);
  bool *failed = (bool *)calloc(tiles, sizeof *failed), ok = error && failed;
  filter_job work = {&picture, j->view.pixels, error, failed};
  ex_threads threads = ex_threads_of(j->given.threads);
  if (ok) ex_parallel_for(&threads, tiles, filter_tile, &work);
  ex_threads_stop(&threads);
  for (size_t i = 0; ok && i < tiles; i++) ok = !failed[i];
  for (size_t i = 0; ok && i < pixels; i++)
    if (error[i] < INFINITY) sum += (double)error[i];
  j->filter_doubted = ok && filter_unreliable(&picture, error);
  free(error);
  free(failed);
  j->filtered_rmse = sqrt(fmax(0, sum) / (3 * (double)pixels));
  j->filter_seconds = ex_seconds() - start;
  return ok || ex_fail("--filter: not enough memory");
}

static bool render(job *j) {
  watch seen;
  seen.of = j;
  if (!allocate(j)) return false;
  describe(j);
  if (j->given.explain) explain(j);
  j->view.progress = go_on;
  j->view.pass = j->given.filter ? gather_pass : NULL;
  j->view.user = &seen;
  ex_progress_start(&seen.progress, j->given.progress);
  double start = ex_seconds();
  interrupt_does = INTERRUPT_CANCELS;
  pktrt_status status = pktrt_render(j->world, &j->view);
  interrupt_does = INTERRUPT_WAITS;
  j->render_seconds = ex_seconds() - start;
  ex_progress_end(&seen.progress);
  if (status != PKTRT_OK && interrupt_number) return false; /* which has been said */
  if (status != PKTRT_OK) return ex_fail("%s", pktrt_last_error(j->world));
  return (!j->given.filter || filter(j)) && put_pictures(j);
}

/* >>table ---------------------------------------------------------------------------------------------------------- */

static void print_counts(const char *name, const pktrt_counts *c, double seconds) {
  double rays = c->rays ? (double)c->rays : 1;
  printf("  %-10s %12llu", name, (unsigned long long)c->rays);
  if (seconds > 0) printf(" %9.2f", 1e-6 * (double)c->rays / seconds);
  else printf(" %9s", "");
  printf(" %10.2f", 100 * (double)c->hits / rays);
  if (c->box_tests) printf(" %11.2f %16.2f", (double)c->box_tests / rays, (double)c->triangle_tests / rays);
  printf("\n");
}

/* Rays per sample, all of them and by the bounces between them and the camera; shadow rays count as one more than their
   surface. */
static void print_tree(const pktrt_stats *s, uint64_t rays) {
  enum { SHOWN = 8, DEPTHS = PKTRT_MAX_DEPTH + 2 };
  const double samples = s->samples ? (double)s->samples : 1;
  uint64_t deeper = 0;
  for (int d = SHOWN; d < DEPTHS; d++) deeper += s->by_depth[d].rays;
  printf("\n  per sample: %.2f rays, ray tree %.2f deep on average\n  rays by depth:", (double)rays / samples,
      (double)s->tree_depth / samples);
  for (int d = 0; d < SHOWN; d++) printf("  %d: %.3f", d, (double)s->by_depth[d].rays / samples);
  printf("  deeper: %.3f\n", (double)deeper / samples);
}

static void print_rays(const job *j) {
  static const char *const names[PKTRT_RAY_TYPE_COUNT] = {"primary", "shadow", "reflection", "refraction", "other"};
  pktrt_counts all;
  memset(&all, 0, sizeof all);
  /* The fast path counts no tests, unless the header is built with PKTRT_COUNT_FAST. */
  const bool tests = j->stats.by_type[PKTRT_RAY_PRIMARY].box_tests != 0;
  printf(
      "\n  %-10s %12s %9s %10s%s\n", "rays", "count", "Mrays/s", "hit %", tests ? "   boxes/ray    triangles/ray" : "");
  for (int t = 0; t < PKTRT_RAY_TYPE_COUNT; t++) {
    const pktrt_counts *c = &j->stats.by_type[t];
    if (!c->rays) continue;
    all.rays += c->rays;
    all.hits += c->hits;
    all.box_tests += c->box_tests;
    all.triangle_tests += c->triangle_tests;
    print_counts(names[t], c, 0); /* types alternate packet by packet: only all together have a time */
  }
  print_counts("all", &all, j->render_seconds);
  print_tree(&j->stats, all.rays);
}

static void print_settings(const job *j) {
  const options *o = &j->given;
  const pktrt_camera *camera = &j->view.camera;
  printf("samples  %u per pixel%s, %s, seed %u, depth %u, attenuation ", o->samples, o->passes == 1 ? "" : " and pass",
      sampler_words()[o->sampler], o->seed, o->depth);
  if (o->attenuation < 0) printf("off\n");
  else printf("%g\n", o->attenuation > 0 ? o->attenuation : 1.0 / 256);
  if (o->mode == PKTRT_MODE_DRT)
    printf("camera   aperture %g, focus %g, shutter %g of the loop\n", (double)camera->aperture, (double)camera->focus,
        o->shutter);
}

/* How wrong the picture is by chance, what that took, and why no more was done. */
static void print_error(const job *j) {
  const pktrt_report *r = &j->report;
  const double seconds = j->render_seconds;
  if (!(r->rmse < INFINITY)) {
    printf("error    not estimated: %s\n", r->samples_max > j->given.samples ? "no pixel is finite"
                                           : j->given.passes == 1
                                               ? "--error-map, --passes and others ask for it, see --help"
                                               : "the time was up after one pass");
    return;
  }
  printf("error    RMSE %.4g, relative MSE %.4g, estimated; RMSE x sqrt(seconds) %.4g\n", r->rmse, r->relative_mse,
      r->rmse * sqrt(seconds));
  printf("         RMSE %.4g to %.4g (95%%), carried by %.0f pixels%s\n", r->rmse_low, r->rmse_high,
      r->effective_pixels[0], r->unreliable[0] ? ": unreliable" : "");
  if (j->view.measure == PKTRT_ERROR_DISPLAY)
    printf("         as shown %.4g of white, %.4g to %.4g (95%%), carried by %.0f pixels%s\n", r->display_error,
        r->display_error_low, r->display_error_high, r->effective_pixels[PKTRT_ERROR_DISPLAY],
        r->unreliable[PKTRT_ERROR_DISPLAY] ? ": unreliable" : "");
  if (r->unreliable[1])
    printf("         the relative MSE is unreliable, carried by %.0f pixels\n", r->effective_pixels[1]);
  if (r->unknown > 0) printf("         %llu pixels are not finite and left out\n", (unsigned long long)r->unknown);
  printf("used     %u to %u samples per pixel, mean %.2f, in %u rounds; stopped: %s\n", (unsigned)r->samples_min,
      (unsigned)r->samples_max, r->samples_mean, (unsigned)r->rounds,
      r->stop == PKTRT_STOP_ERROR  ? "the target is reached"
      : r->stop == PKTRT_STOP_TIME ? "the time is up"
                                   : "all passes are done");
}

static void print_filter(const job *j) {
  if (j->halves.passes < 2) printf("filter   not applied: the time was up after one pass\n");
  else
    printf("filter   RMSE %.4g, estimated%s; %.3f seconds\n", j->filtered_rmse,
        j->filter_doubted ? ", unreliable: few pixels carry it" : "", j->filter_seconds);
}

/* The lines above count the triangles of a model once, and its meshes for each instance. */
static void print_field(const job *j) {
  const options *o = &j->given;
  pktrt_scene_report report;
  pktrt_get_scene_report(j->world, NULL, &report);
  printf("field    %u instances of it, %u in a row; %llu bytes in all%s\n", o->instances, field_side(o),
      (unsigned long long)report.bytes, o->scene ? "; without the scene's own lights" : "");
}

static void print_table(const job *j) {
  const options *o = &j->given;
  pktrt_scene_info info;
  pktrt_get_scene_info(j->world, &info);
  printf("scene    %s: %llu triangles in %lu meshes, %lu of them moving\n", seen_name(o),
      (unsigned long long)info.triangles, (unsigned long)info.mesh_count, (unsigned long)info.moving_meshes);
  if (o->instances > 0) print_field(j);
  printf("picture  %u x %u, %s, %s path, %s, packets %u x %u by %s, tiles %u, threads %u\n", o->width, o->height,
      mode_words[o->mode], path_words[o->path], pktrt_isa_string(info.isa), o->packet, o->packet,
      assembly_names[o->assembly], o->tile, o->threads);
  print_settings(j);
  printf("tree     %llu bytes, %llu nodes, %llu leaf blocks; meshes %llu bytes\n", (unsigned long long)info.tree_bytes,
      (unsigned long long)info.nodes, (unsigned long long)info.leaf_blocks, (unsigned long long)info.mesh_bytes);
  printf("seconds  scene %.3f, build %.3f, render %.3f%s\n", j->load_seconds, j->build_seconds, j->render_seconds,
      o->count ? " (with counting; --no-count is a little faster)" : "");
  printf("pixels   checksum %016llx\n", (unsigned long long)j->checksum);
  print_error(j);
  if (o->filter) print_filter(j);
  if (o->count) print_rays(j);
}

int main(int argc, char **argv) {
  static job j; /* static: zeroed */
  ex_threads threads = ex_threads_of(1);
  pktrt_scene_desc desc;
  if (!parse_options(&j.given, argc, argv)) return 1;
  interrupt_does = INTERRUPT_WAITS;
  interrupt_take();
  if (!check_outputs(&j)) return 1;
  if (interrupt_number) return interrupt_status();
  interrupt_does = INTERRUPT_ENDS;
  threads.count = j.given.threads;
  memset(&desc, 0, sizeof desc);
  desc.isa = j.given.isa;
  desc.parallel_for = ex_parallel_for;
  desc.user = &threads;
  desc.log = ex_log;
  j.world = pktrt_scene_create(&desc);
  bool ok = j.world ? load(&j) && render(&j) : ex_fail("%s", pktrt_last_error(NULL));
  if (ok) print_table(&j);
  free(j.view.pixels);
  free(j.error);
  free(j.cost);
  filter_end(&j.halves);
  for (int b = 0; b < BUFFERS; b++) free(j.buffers[b]);
  scene_free(&j.built_in);
  image_free(&sky_picture);
  pktrt_scene_destroy(j.world);
  mesh_file_close(&j.file);
  ex_threads_stop(&threads);
  if (ok && fflush(stdout) != 0) ok = ex_fail("the table could not be written: %s", strerror(errno));
  return ok ? 0 : interrupt_number ? interrupt_status() : 1;
}
