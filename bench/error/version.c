/* version.c - compiled once for each of the two versions of versions.c: VERSION names the struct, HEADER the pktrt.h. Scenes
   are today's, compiled against each header. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#ifdef __GNUC__ /* most of the library is not called */
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#define PKTRT_STATIC
#define PKTRT_IMPLEMENTATION
#include HEADER
#undef PKTRT_IMPLEMENTATION

/* What scenes call by another name in 0.5, and what it lacks. */
#if PKTRT_VERSION < 600
#define barycentric uv
static pktrt_status pktrt_add_model(pktrt_scene *s, const pktrt_mesh_desc *d, uint32_t count, uint32_t *model) {
  (void)s, (void)d, (void)count, (void)model;
  return PKTRT_OUT_OF_MEMORY;
}
#endif
#if PKTRT_VERSION < 1900
typedef enum pktrt_tone { PKTRT_TONE_CLAMP, PKTRT_TONE_CURVE } pktrt_tone;
static void pktrt_to_srgb8(const float *rgb, size_t pixels, float exposure, pktrt_tone tone, unsigned char *out) {
  (void)rgb, (void)pixels, (void)exposure, (void)tone, (void)out;
}
#endif

#include "closed.h"
#include "version.h"

#define TEXT_(x) #x
#define TEXT(x) TEXT_(x)

static bool open_closed(stage *g, const request *r) {
  static const char prefix[] = "closed-";
  if (strncmp(r->scene, prefix, sizeof prefix - 1) != 0) return false;
  for (unsigned i = 0; i < CLOSED_SCENES; i++)
    if (!strcmp(closed_scenes[i].name, r->scene + sizeof prefix - 1))
      return closed_open(g, i, r->width, r->height), true;
  fatal("a scene has a closed form that nobody knows");
  return false;
}

typedef struct opened {
  stage g;
  bool adaptive, shown; /* see request */
} opened;

static void *open_scene(const request *r) {
  opened *o = (opened *)calloc(1, sizeof *o);
  bench b;
  if (!o) fatal("not enough memory");
  stage *g = &o->g;
  o->adaptive = r->adaptive;
  o->shown = r->shown;
  memset(&b, 0, sizeof b);
  b.given.references = r->references, b.given.threads = r->threads;
  if (!open_closed(g, r)) {
    stage_open(g, r->scene, PKTRT_MODE_DRT, r->width, r->height);
    if (r->reference_samples) stage_reference(&b, g, r->reference_samples);
  }
  g->view.lights = (pktrt_light_choice)r->lights;
  pin(true);
  return o;
}

static void close_scene(void *scene) {
  stage_close(&((opened *)scene)->g);
  free(scene);
}

/* Takes the least time of some equal pictures where one is too short for the clock and for what else the machine does. */
static judged take_picture(void *scene, uint32_t samples, uint32_t seed) {
  enum { MOST = 16, PASSES = 4 };
  const double enough = 0.15;
  opened *of = (opened *)scene;
  const uint32_t part = !of->adaptive ? samples : samples > PASSES ? samples / PASSES : 1;
  shot s = shot_of(PKTRT_SAMPLER_SOBOL, part, samples / part, seed);
  s.adaptive = samples > part;
#if PKTRT_VERSION >= 2200
  if (of->shown) s.measure = PKTRT_ERROR_DISPLAY;
#endif
  double total = 0;
  judged j;
  j.mse = 0, j.seconds = HUGE_VAL;
  for (int i = 0; i < MOST && total < enough; i++) {
    outcome o;
    take_shot(&of->g, &s, &o);
    j.mse = of->shown ? shown_error(&of->g) : o.mse;
    j.seconds = fmin(j.seconds, o.seconds);
    total += o.seconds;
  }
  return j;
}

static const double *truth_of(const void *scene, const double **doubt) {
  const stage *g = &((const opened *)scene)->g;
  *doubt = g->doubt;
  return g->truth;
}

extern const version VERSION;
const version VERSION = {TEXT(VERSION), PKTRT_VERSION, find_cores, open_scene, close_scene, take_picture, truth_of};
