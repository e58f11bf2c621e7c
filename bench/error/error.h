/* error.h - error against run time: what the parts of `make error` and the checks of `make error-check` share.

   To add a part: a function void part(bench *), which prints by say(&b->out, ...) (also into NAME.md) and keeps numbers by csv()
   (into NAME.csv); one line in parts[] of error.c. To add a check: a function that returns the figure and, for its
   control, the figure of something that must fail; one line in claims[] of error.c. Then:

     stage_open(&g, "poolhall", PKTRT_MODE_DRT, 96, 64)  a scene and a pktrt_render_desc, which may be changed
     stage_reference(b, &g, spp)                         the truth of it, cached in --references, with its own noise
     shot s = shot_of(PKTRT_SAMPLER_SOBOL, 16, 2, seed)  two passes of 16 samples
     outcome o;
     take_shot(b, &g, &s, &o)                            renders: o.mse (the truth's noise subtracted), o.relative,
                                                         o.seconds (of one thread), o.report (estimates)
     stage_close(&g)

   Errors here are those of a channel: MSE = mean over pixels of |x - truth|^2 / 3, the RMSE its root; relative MSE as
   in pktrt_error_measure, with the truth in the denominator.

   Contents: options, stages, references, shots, statistics, checks. */
#ifndef ERROR_H
#define ERROR_H

#include "../bench.h"
#include "../../pktrt.h"
#include "../../examples/scenes.h"
#include <sched.h>
#include <sys/stat.h>

enum { MAX_NAMES = 32, MAX_SEEDS = 64, DETAILS = 512, REFERENCE_SAMPLES = 4096, REFERENCE_PASS = 256 };
#define GOLDEN 0x9E3779B9u
enum { REFERENCE_SEED = 0x51ED0000, FIRST_SEED = 1 }; /* runs have seeds from FIRST_SEED on: see seeds_disjoint */

/* >>options -------------------------------------------------------------------------------------------------------- */

typedef struct options {
  const char *results, *references; /* directories; NULL: nothing is kept */
  const char *names[MAX_NAMES];
  unsigned name_count, threads; /* threads: for what is not timed */
  uint32_t seed;                /* the first of runs whose filter is judged by what a screen shows */
  bool check;
} options;

typedef struct bench {
  options given;
  results out; /* of this part */
  bool skip;   /* what the claim at hand measures cannot be measured here; as a control, too */
} bench;

/* Processor time is compared, and caches count: what is timed stays on the last of the cores that this process may use,
   for the first serves most interrupts. What is not timed may use all. */
static cpu_set_t all_cores, own_core;

EX_UNUSED static void find_cores(void) {
  if (sched_getaffinity(0, sizeof all_cores, &all_cores)) fatal("the cores of this process are unknown");
  size_t last = 0;
  for (size_t i = 0; i < CPU_SETSIZE; i++)
    if (CPU_ISSET(i, &all_cores)) last = i;
  CPU_ZERO(&own_core);
  CPU_SET(last, &own_core);
}
EX_UNUSED static void pin(bool on) { (void)sched_setaffinity(0, sizeof all_cores, on ? &own_core : &all_cores); }

/* Checks have two minutes: references of fewer samples do, since their noise is subtracted. */
EX_UNUSED static uint32_t reference_samples(const bench *b) { return b->given.check ? 1024 : REFERENCE_SAMPLES; }

/* >>stages: scenes to be rendered, and the truth about them -------------------------------------------------------- */

typedef struct stage {
  char name[32];
  pktrt_scene *world;
  pktrt_render_desc view; /* all but pixels, samples, sampler, seed, and what goes with passes */
  scene made;             /* if it is a built-in one */
  bool built_in;
  double *truth; /* width * height * 3 */
  double *doubt; /* squared error of the truth, summed over channels, one for each pixel; NULL: exact */
  /* Of a large picture one may take a part for the whole: columns x rows blocks of w x h pixels, in the middles of as
     many equal parts. 0: all of it. */
  uint32_t columns, rows, block_w, block_h;
  ex_threads threads; /* 1 unless changed: what is timed has one */
  float *pixels;      /* of the last shot */
  void *own;          /* freed with it */
} stage;

static size_t stage_pixels(const stage *g) { return (size_t)g->view.width * g->view.height; }

/* Block i, or with i = 0 the whole picture: x, y, width, height. */
static uint32_t stage_blocks(const stage *g) { return g->columns ? g->columns * g->rows : 1; }
static void stage_block(const stage *g, uint32_t i, uint32_t area[4]) {
  area[0] = area[1] = 0, area[2] = g->view.width, area[3] = g->view.height;
  if (!g->columns) return;
  area[0] = ((2 * (i % g->columns) + 1) * g->view.width / g->columns - g->block_w) / 2;
  area[1] = ((2 * (i / g->columns) + 1) * g->view.height / g->rows - g->block_h) / 2;
  area[2] = g->block_w, area[3] = g->block_h;
}

static void stage_world(stage *g) { /* empty, with threads as the stage says */
  pktrt_scene_desc desc;
  memset(&desc, 0, sizeof desc);
  g->threads = ex_threads_of(1);
  desc.parallel_for = ex_parallel_for, desc.user = &g->threads;
  g->world = pktrt_scene_create(&desc);
  if (!g->world) fatal("no scene could be created");
}

static void stage_room(stage *g, uint32_t width, uint32_t height) {
  g->view.width = width, g->view.height = height;
  g->pixels = (float *)calloc(stage_pixels(g) * 3, sizeof(float));
  g->truth = (double *)calloc(stage_pixels(g) * 3, sizeof(double));
  if (!g->pixels || !g->truth) fatal("not enough memory");
}

/* A built-in scene in the pose of time 0. *g must stay where it is. */
EX_UNUSED static void stage_open(stage *g, const char *name, pktrt_mode mode, uint32_t width, uint32_t height) {
  memset(g, 0, sizeof *g);
  snprintf(g->name, sizeof g->name, "%s", name);
  if (!scene_make(name, &g->made)) fatal("a scene cannot be made");
  g->built_in = true;
  stage_world(g);
  if (scene_add(g->world, &g->made) != PKTRT_OK || pktrt_commit(g->world) != PKTRT_OK)
    fatal(pktrt_last_error(g->world));
  stage_room(g, width, height);
  g->view.mode = mode, g->view.camera = g->made.camera;
  memcpy(g->view.background, g->made.background, sizeof g->view.background);
  memcpy(g->view.ambient, g->made.ambient, sizeof g->view.ambient);
  g->view.environment = g->made.environment;
}

/* A scene that `make` adds, for pictures by DRT, without its truth. *g must stay where it is. */
EX_UNUSED static void stage_open_made(
    stage *g, const char *name, void (*make)(stage *), uint32_t width, uint32_t height) {
  memset(g, 0, sizeof *g);
  snprintf(g->name, sizeof g->name, "%s", name);
  stage_world(g);
  stage_room(g, width, height);
  g->view.mode = PKTRT_MODE_DRT;
  make(g);
  if (pktrt_commit(g->world)) fatal(pktrt_last_error(g->world));
}

EX_UNUSED static void stage_close(stage *g) {
  pktrt_scene_destroy(g->world);
  ex_threads_stop(&g->threads);
  if (g->built_in) scene_free(&g->made);
  free(g->truth), free(g->doubt), free(g->pixels), free(g->own);
  memset(g, 0, sizeof *g);
}

/* >>shots ---------------------------------------------------------------------------------------------------------- */

typedef struct shot { /* how a stage is rendered */
  pktrt_sampler sampler;
  uint32_t samples, passes, seed; /* samples: of a pass */
  bool adaptive, estimate;        /* estimate: with the estimator, which adaptive passes and targets imply */
  double target;                  /* 0: none */
  pktrt_error_measure measure;
} shot;

typedef struct outcome {
  double mse, relative; /* true ones; the doubt of the truth is subtracted from both, so a single one may be < 0 */
  double seconds;       /* processor time, hence that of all threads */
  pktrt_report report;  /* zero without estimate */
} outcome;

EX_UNUSED static shot shot_of(pktrt_sampler sampler, uint32_t samples, uint32_t passes, uint32_t seed) {
  shot s;
  memset(&s, 0, sizeof s);
  s.sampler = sampler, s.samples = samples, s.passes = passes, s.seed = seed, s.estimate = passes > 1;
  return s;
}

/* N samples as render.c has them in passes, if the error is to be known: two of N / 2. */
EX_UNUSED static shot shot_estimated(pktrt_sampler sampler, uint32_t samples, uint32_t seed) {
  return shot_of(sampler, samples / 2, 2, seed);
}

static double square(double x) { return x * x; }

/* Of the pixels of an area: adds up |x - truth|^2 less what the truth is off by, and the truth; returns how many. */
static double sum_area(const stage *g, const uint32_t area[4], double *error, double mean[3]) {
  const uint32_t n = area[2] * area[3];
  for (uint32_t i = 0; i < n; i++) {
    const size_t at = (size_t)(area[1] + i / area[2]) * g->view.width + area[0] + i % area[2];
    if (g->doubt) *error -= g->doubt[at];
    for (size_t c = 0; c < 3; c++)
      *error += square((double)g->pixels[3 * at + c] - g->truth[3 * at + c]), mean[c] += g->truth[3 * at + c];
  }
  return n;
}

static double squared_length(const double v[3]) { return square(v[0]) + square(v[1]) + square(v[2]); }

/* The means over pixels of |x - truth|^2 / 3, and of |x - truth|^2 over the squared mean of the truth in their block of
   PKTRT_ERROR_BLOCK^2 and a hundredth of that of the picture. */
static void true_errors(const stage *g, double *mse, double *relative) {
  const uint32_t edge = PKTRT_ERROR_BLOCK;
  double mean[3] = {0, 0, 0}, n = 0, error = 0, weighted = 0;
  uint32_t area[4];
  for (uint32_t k = 0; k < stage_blocks(g); k++) {
    stage_block(g, k, area);
    n += sum_area(g, area, &error, mean);
  }
  const double least = 0.01 * squared_length(mean) / square(n);
  for (uint32_t k = 0; k < stage_blocks(g); k++) {
    stage_block(g, k, area);
    for (uint32_t y = area[1]; y < area[1] + area[3]; y += edge)
      for (uint32_t x = area[0]; x < area[0] + area[2]; x += edge) {
        const uint32_t w = area[0] + area[2] - x, h = area[1] + area[3] - y;
        const uint32_t part[4] = {x, y, w < edge ? w : edge, h < edge ? h : edge};
        double own[3] = {0, 0, 0}, off = 0;
        const double pixels = sum_area(g, part, &off, own), bright = squared_length(own) / square(pixels) + least;
        if (bright > 0) weighted += off / bright;
      }
  }
  *mse = error / (3 * n), *relative = weighted / n;
}

static void render_block(const stage *g, const pktrt_render_desc *d, uint32_t i) {
  uint32_t area[4];
  stage_block(g, i, area);
  if (pktrt_render_tile(g->world, d, area[0], area[1], area[2], area[3]) != PKTRT_OK) fatal("a block is refused");
}

EX_UNUSED static void take_shot(stage *g, const shot *s, outcome *o) {
  pktrt_render_desc d = g->view;
  memset(o, 0, sizeof *o);
  d.pixels = g->pixels;
  d.sampler = s->sampler, d.samples = s->samples, d.passes = s->passes, d.seed = s->seed;
  d.adaptive = s->adaptive, d.target_error = (float)s->target, d.measure = s->measure;
  if ((s->estimate && !g->columns) || s->adaptive || s->target > 0) d.report = &o->report; /* no estimate of blocks */
  const double start = cpu_seconds();
  if (!g->columns && pktrt_render(g->world, &d) != PKTRT_OK) fatal(pktrt_last_error(g->world));
  for (uint32_t i = 0; g->columns && i < stage_blocks(g); i++) render_block(g, &d, i);
  o->seconds = cpu_seconds() - start;
  true_errors(g, &o->mse, &o->relative);
}

/* >>truth ---------------------------------------------------------------------------------------------------------- */

EX_UNUSED static double screen_value(double v) {
  if (!(v > 0)) return 0;
  if (v >= 1) return 1;
  return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
}

/* Returns the mean squared error as shown of a channel of the last shot. What the truth itself is off by is subtracted:
   what it would show a standard deviation up or down. */
EX_UNUSED static double shown_error(const stage *g) {
  const size_t n = stage_pixels(g) * 3;
  double sum = 0;
  for (size_t i = 0; i < n; i++) {
    const double truth = g->truth[i], shown = screen_value(truth), doubt = g->doubt ? sqrt(g->doubt[i / 3] / 3) : 0;
    sum += square(screen_value((double)g->pixels[i]) - shown);
    sum -= 0.5 * (square(screen_value(truth + doubt) - shown) + square(screen_value(truth - doubt) - shown));
  }
  return sum / (double)n;
}

/* >>references ----------------------------------------------------------------------------------------------------- */

/* Passes of a seed have seeds seed + k * GOLDEN (see pktrt.h). Whether none of those of the references is among those
   of runs. */
EX_UNUSED static bool seeds_disjoint(void) {
  const uint32_t first = (uint32_t)REFERENCE_SEED;
  enum { SEEDS = 16384 };
  for (uint32_t k = 0; k < 65536; k++) /* passes between the two */
    if (first + k * GOLDEN - FIRST_SEED < SEEDS || first - k * GOLDEN - FIRST_SEED < SEEDS) return false;
  return true;
}

/* What a reference depends on, beside header and scenes: the Makefile removes all when these are newer. The first
   number is to change with the way references are made. */
static void reference_settings(const stage *g, uint32_t samples, char *text, size_t room) {
  const pktrt_render_desc *v = &g->view;
  const pktrt_camera *c = &v->camera;
  const int n = snprintf(text, room,
      "1 %s %ux%u of %ux%u blocks %ux%u mode %d samples %u depth %u attenuation %.9g lights %d branching %d glass %d "
      "mapping %d "
      "eye %.9g %.9g %.9g target %.9g %.9g %.9g fov %.9g time %.9g shutter %.9g aperture %.9g focus %.9g",
      g->name, (unsigned)v->width, (unsigned)v->height, (unsigned)g->columns, (unsigned)g->rows, (unsigned)g->block_w,
      (unsigned)g->block_h, (int)v->mode, (unsigned)samples, (unsigned)v->max_depth, (double)v->attenuation,
      (int)v->lights, (int)v->branching, (int)v->glass_shadows, (int)v->phong_mapping, (double)c->eye[0],
      (double)c->eye[1], (double)c->eye[2], (double)c->target[0], (double)c->target[1], (double)c->target[2],
      (double)c->fov_y, (double)c->time, (double)c->shutter, (double)c->aperture, (double)c->focus);
  if (n < 0 || (size_t)n >= room) fatal("the settings of a reference are too long");
}

static bool reference_path(const bench *b, const char *settings, char *path, size_t room) {
  uint32_t hash = 2166136261u; /* FNV-1a: names one file for each setting */
  for (const char *c = settings; *c; c++) hash = (hash ^ (uint8_t)*c) * 16777619u;
  if (!b->given.references) return false;
  const int n = snprintf(path, room, "%s/%08x.ref", b->given.references, (unsigned)hash);
  return n > 0 && (size_t)n < room;
}

/* A file: its settings in a line, then truth and doubt as they lie in memory. */
static bool read_reference(stage *g, const char *path, const char *settings) {
  char line[1024] = "";
  const size_t n = stage_pixels(g);
  FILE *file = fopen(path, "rb");
  if (!file) return false;
  const bool same = fgets(line, sizeof line, file) && strlen(line) == strlen(settings) + 1 &&
                    !strncmp(line, settings, strlen(settings));
  const bool ok = same && fread(g->truth, sizeof(double), n * 3, file) == n * 3 &&
                  fread(g->doubt, sizeof(double), n, file) == n && fgetc(file) == EOF;
  fclose(file);
  return ok;
}

static void write_reference(const stage *g, const char *path, const char *settings) {
  char unfinished[4200];
  const size_t n = stage_pixels(g);
  snprintf(unfinished, sizeof unfinished, "%s.new", path);
  FILE *file = fopen(unfinished, "wb");
  if (!file) fatal("a reference cannot be kept");
  const bool ok = fprintf(file, "%s\n", settings) > 0 && fwrite(g->truth, sizeof(double), n * 3, file) == n * 3 &&
                  fwrite(g->doubt, sizeof(double), n, file) == n;
  if (fclose(file) || !ok || rename(unfinished, path)) fatal("a reference cannot be kept");
}

typedef struct reference_job {
  const stage *g;
  const pktrt_render_desc *view;
} reference_job;
static void reference_block(void *arg, size_t i) {
  const reference_job *job = (const reference_job *)arg;
  render_block(job->g, job->view, (uint32_t)i);
}

/* In sets of REFERENCE_PASS samples, scrambled independently, whose scatter tells its own error; by all threads. */
static void make_reference(const bench *b, stage *g, uint32_t samples) {
  const size_t n = stage_pixels(g), sets = samples / REFERENCE_PASS;
  pktrt_render_desc d = g->view;
  reference_job job;
  job.g = g, job.view = &d;
  d.pixels = g->pixels, d.samples = REFERENCE_PASS, d.tile_size = 16;
  g->threads.count = b->given.threads;
  pin(false);
  for (uint32_t k = 0; k < sets; k++) {
    d.seed = (uint32_t)REFERENCE_SEED + k * GOLDEN;
    if (g->columns) ex_parallel_for(&g->threads, stage_blocks(g), reference_block, &job);
    else if (pktrt_render(g->world, &d) != PKTRT_OK) fatal(pktrt_last_error(g->world));
    for (size_t i = 0; i < n * 3; i++)
      g->truth[i] += (double)g->pixels[i], g->doubt[i / 3] += square((double)g->pixels[i]);
  }
  pin(true);
  g->threads.count = 1;
  for (size_t i = 0; i < n * 3; i++) g->truth[i] /= (double)sets, g->doubt[i / 3] -= (double)sets * square(g->truth[i]);
  for (size_t i = 0; i < n; i++) g->doubt[i] = fmax(0, g->doubt[i]) / ((double)sets * ((double)sets - 1));
}

/* The truth of a stage whose answer has no closed form: `samples` by sobol, a multiple of REFERENCE_PASS. */
EX_UNUSED static void stage_reference(const bench *b, stage *g, uint32_t samples) {
  char settings[960], path[4096];
  reference_settings(g, samples, settings, sizeof settings);
  g->doubt = (double *)calloc(stage_pixels(g), sizeof(double));
  if (!g->doubt) fatal("not enough memory");
  const bool kept = reference_path(b, settings, path, sizeof path);
  if (kept && read_reference(g, path, settings)) return;
  const double start = ex_seconds();
  make_reference(b, g, samples);
  if (kept) write_reference(g, path, settings);
  fprintf(stderr, "reference of %s, mode %d: %.0f s\n", g->name, (int)g->view.mode, ex_seconds() - start);
}

/* >>statistics ----------------------------------------------------------------------------------------------------- */

typedef struct interval {
  double value, low, high; /* low, high: of 95% confidence */
} interval;

static uint32_t next_random(uint32_t *state) { /* xorshift */
  *state ^= *state << 13, *state ^= *state >> 17, *state ^= *state << 5;
  return *state;
}

/* Least squares: the slope of y over x. */
static double slope_of(const double *x, const double *y, unsigned n) {
  double mx = 0, my = 0, xy = 0, xx = 0;
  for (unsigned i = 0; i < n; i++) mx += x[i] / n, my += y[i] / n;
  for (unsigned i = 0; i < n; i++) xy += (x[i] - mx) * (y[i] - my), xx += square(x[i] - mx);
  return xy / xx;
}

/* A figure of runs with many seeds, and its interval: bootstrap over seeds, percentiles of the figure of 1000 draws of as
   many seeds with replacement. `figure` takes seed `pick(r, k, seeds)` where it means seed k of `seeds`. */
typedef struct resample {
  uint32_t state;
  bool whole; /* all seeds as they are: the figure itself */
} resample;

static unsigned pick(resample *r, unsigned k, unsigned seeds) { return r->whole ? k : next_random(&r->state) % seeds; }

EX_UNUSED static interval bootstrap(double (*figure)(const void *of, resample *), const void *of) {
  enum { DRAWS = 1000 };
  double drawn[DRAWS];
  resample r = {0x2545F491u, true};
  interval result;
  result.value = figure(of, &r);
  r.whole = false;
  for (unsigned draw = 0; draw < DRAWS; draw++) drawn[draw] = figure(of, &r);
  qsort(drawn, DRAWS, sizeof *drawn, compare_doubles);
  result.low = drawn[DRAWS / 40], result.high = drawn[DRAWS - 1 - DRAWS / 40];
  return result;
}

typedef struct errors { /* mse[seed * points + i]: a seed's mean squared error at x[i] */
  const double *x, *mse;
  unsigned points, seeds;
} errors;

static double figure_slope(const void *of, resample *r) {
  enum { MOST = 16 };
  const errors *e = (const errors *)of;
  double log_x[MOST], log_y[MOST], sum[MOST] = {0};
  for (unsigned k = 0; k < e->seeds; k++) {
    const unsigned seed = pick(r, k, e->seeds);
    for (unsigned i = 0; i < e->points; i++) sum[i] += e->mse[seed * e->points + i];
  }
  for (unsigned i = 0; i < e->points; i++) log_x[i] = log(e->x[i]), log_y[i] = 0.5 * log(sum[i] / e->seeds);
  return slope_of(log_x, log_y, e->points);
}

/* Slope of log RMSE over log x. */
EX_UNUSED static interval log_slope(const double *x, const double *mse, unsigned points, unsigned seeds) {
  const errors e = {x, mse, points, seeds};
  return bootstrap(figure_slope, &e);
}

static double figure_rmse(const void *of, resample *r) {
  const errors *e = (const errors *)of;
  double sum = 0;
  for (unsigned k = 0; k < e->seeds; k++) sum += e->mse[pick(r, k, e->seeds)];
  return sqrt(sum < 0 ? 0 : sum / e->seeds); /* this way round, what is no number stays so */
}

/* The root of the mean of values that are each a mean squared error, by seeds. */
EX_UNUSED static interval rmse_of(const double *mse, unsigned seeds) {
  const errors e = {NULL, mse, 1, seeds};
  return bootstrap(figure_rmse, &e);
}

/* y at x on the curve through n points (x ascending), straight between them and beyond in logarithms. */
EX_UNUSED static double log_between(const double *xs, const double *ys, unsigned n, double x) {
  unsigned i = 0;
  while (i + 2 < n && xs[i + 1] < x) i++;
  const double t = log(x / xs[i]) / log(xs[i + 1] / xs[i]);
  return exp((1 - t) * log(ys[i]) + t * log(ys[i + 1]));
}

/* >>checks --------------------------------------------------------------------------------------------------------- */

/* A figure and its bar. As a control the same function measures something that must fail it. Where the bar has not been
   reached yet, or noise of the machine and rare samples may hide that it has, `guard` is what must hold meanwhile. */
typedef struct claim claim;
struct claim {
  const char *sentence;
  double bar;
  bool most; /* the figure is to be at most the bar, else at least */
  double (*figure)(bench *, const claim *, bool control, char details[DETAILS]);
  const char *on; /* what the function is to look at, if it serves several claims */
  unsigned number;
  double guard; /* 0: the bar */
};

/* Written this way round, what is not a number holds nothing; as a control, it does not count as failing. */
static bool check_claim(bench *b, const claim *c, bool control) {
  char details[DETAILS] = "";
  b->skip = false;
  const double start = cpu_seconds(), figure = c->figure(b, c, control, details);
  if (b->skip) {
    printf("%sskipped  %s: %s\n", control ? "control " : "", c->sentence, details);
    return false;
  }
  const double guard = c->guard != 0 ? c->guard : c->bar;
  const bool reached = c->most ? figure <= c->bar : figure >= c->bar;
  const bool held = c->most ? figure <= guard : figure >= guard;
  printf("%s%s  %s: %.3f, wanted at %s %g (%s; %.1f s)\n", control ? "control " : "",
      reached ? "ok"
      : held  ? "NOT REACHED"
              : "FAILED",
      c->sentence, figure, c->most ? "most" : "least", c->bar, details, cpu_seconds() - start);
  fflush(stdout);
  return !isnan(figure) && held != control;
}

/* Whether a part, or a claim by some words of its sentence, is among those named, or none is. */
EX_UNUSED static bool wanted(const options *o, const char *text) {
  bool found = o->name_count == 0;
  for (unsigned n = 0; n < o->name_count && !found; n++)
    found = o->check ? strstr(text, o->names[n]) != NULL : !strcmp(text, o->names[n]);
  return found;
}

/* Whether each word picks a claim: one that picks none, checks none. */
static bool words_pick(const options *o, const claim *claims, unsigned n) {
  for (unsigned k = 0; k < o->name_count; k++) {
    unsigned i = 0;
    while (i < n && !strstr(claims[i].sentence, o->names[k])) i++;
    if (i == n) return ex_fail("\"%s\" is in no claim", o->names[k]);
  }
  return true;
}

/* Whether all claims hold and then all controls fail. */
EX_UNUSED static bool check_claims(bench *b, const claim *claims, unsigned n) {
  unsigned good[2] = {0, 0}, count[2] = {0, 0}, skipped = 0;
  if (!words_pick(&b->given, claims, n)) return false;
  for (int control = 0; control < 2; control++) {
    if (control) printf("Controls: each is expected to say FAILED.\n\n");
    for (unsigned i = 0; i < n; i++) {
      if (!wanted(&b->given, claims[i].sentence)) continue;
      const bool well = check_claim(b, &claims[i], control != 0);
      if (b->skip) skipped++;
      else count[control]++, good[control] += well;
    }
    if (control) printf("%u controls failed as they must, %u did not\n", good[1], count[1] - good[1]);
    else printf("%u passed, %u failed\n\n", good[0], count[0] - good[0]);
  }
  if (skipped) printf("%u claims and controls were skipped\n", skipped);
  return good[0] == count[0] && good[1] == count[1] && count[0] + skipped > 0;
}

#endif /* ERROR_H */
