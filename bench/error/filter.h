/* filter.h - what examples/filter.h leaves of the error: true errors of pictures before and after, by samples; whether
   its own estimate is the truth; and its time beside that of the render. */
#ifndef ERROR_FILTER_H
#define ERROR_FILTER_H

#include "error.h"
#include "../../examples/filter.h"

enum { FILTER_WIDTH = 128, FILTER_HEIGHT = 96, FILTER_TRUTH = 1024 };
enum { FILTER_FEW = 5, FILTER_LEVELS = 11, FILTER_SCENES = 3 }; /* few: levels of the larger picture */
enum { FILTER_SMALL_WIDTH = 48, FILTER_SMALL_HEIGHT = 36, FILTER_LONG_TRUTH = 16384 };

/* With few samples the seeds decide which glints are met, hence many of them. */
typedef struct filter_level {
  uint32_t samples, seeds;
} filter_level;
static const filter_level filter_levels[FILTER_LEVELS] = {
    {4, 16}, {8, 16}, {16, 8}, {32, 8}, {64, 4}, {128, 8}, {256, 8}, {512, 4}, {1024, 2}, {2048, 2}, {4096, 1}};

typedef struct filtering {
  filter_halves halves;
  float *depth, *normal, *albedo, *error;
  const float *pixels;
  float scale; /* of the variances that the filter gets: 1, save in controls */
} filtering;

typedef struct filtered {  /* sums over seeds */
  double mse[2], estimate; /* before and after */
  double seconds[2];       /* of render and filter */
} filtered;

static bool gather_filtering(void *user, const pktrt_report *report) {
  filtering *f = (filtering *)user;
  (void)report;
  filter_add_pass(&f->halves, f->pixels);
  return true;
}

/* Renders in as many passes as render.c makes for the filter, filters, and adds up what that brings. */
static void take_filtered(stage *g, filtering *f, uint32_t samples, uint32_t seed, filtered *to) {
  pktrt_render_desc d = g->view;
  filter_picture taken;
  double mse, relative, sum = 0;
  if (!filter_begin(&f->halves, d.width, d.height)) fatal("not enough memory");
  f->pixels = d.pixels = g->pixels;
  d.depth = f->depth, d.normal = f->normal, d.albedo = f->albedo;
  d.passes = samples >= 16 ? 8 : samples >= 8 ? 4 : 2, d.samples = samples / d.passes, d.seed = seed;
  d.pass = gather_filtering, d.user = f;
  const double start = cpu_seconds();
  if (pktrt_render(g->world, &d) != PKTRT_OK) fatal(pktrt_last_error(g->world));
  const double rendered = cpu_seconds();
  true_errors(g, &mse, &relative);
  to->mse[0] += mse;
  const double again = cpu_seconds();
  filter_finish(&f->halves, &taken);
  for (size_t i = 0; i < stage_pixels(g) && f->scale != 1; i++) f->halves.variance[i] *= f->scale;
  taken.depth = f->depth, taken.normal = f->normal, taken.albedo = f->albedo;
  if (!filter_rectangle(&taken, 0, 0, d.width, d.height, g->pixels, f->error)) fatal("not enough memory");
  to->seconds[0] += rendered - start, to->seconds[1] += cpu_seconds() - again;
  for (size_t i = 0; i < stage_pixels(g); i++) sum += (double)f->error[i];
  true_errors(g, &mse, &relative);
  to->mse[1] += mse, to->estimate += sum / (3 * (double)stage_pixels(g));
  filter_end(&f->halves);
}

static void open_filtering(filtering *f, const stage *g) {
  const size_t n = stage_pixels(g);
  memset(f, 0, sizeof *f);
  f->depth = (float *)calloc(n * 8, sizeof(float));
  if (!f->depth) fatal("not enough memory");
  f->normal = f->depth + n, f->albedo = f->depth + 4 * n, f->error = f->depth + 7 * n, f->scale = 1;
}

static filtered measure_filtered(stage *g, filtering *f, filter_level l) {
  filtered r;
  memset(&r, 0, sizeof r);
  for (uint32_t k = 0; k < l.seeds; k++) take_filtered(g, f, l.samples, (uint32_t)FIRST_SEED + 1000 * k, &r);
  return r;
}

/* RMSE filtered over unfiltered. */
static double filtered_ratio(const filtered *r) { return sqrt(fmax(r->mse[1], 0) / r->mse[0]); }

/* Says the levels [from, to) of a scene, and keeps their ratios. */
static void say_filtered(const bench *b, stage *g, int from, int to, double left[FILTER_LEVELS]) {
  filtering f;
  open_filtering(&f, g);
  for (int l = from; l < to; l++) {
    const filter_level level = filter_levels[l];
    const filtered r = measure_filtered(g, &f, level);
    left[l] = filtered_ratio(&r);
    const double honest = sqrt(fmax(r.estimate, 0) / fmax(r.mse[1], 1e-30)), time = r.seconds[1] / r.seconds[0];
    const double before = sqrt(fmax(r.mse[0], 0) / level.seeds), after = sqrt(fmax(r.mse[1], 0) / level.seeds);
    say(&b->out, "| %s | %u | %u | %.4f | %.4f | %.2f | %.2f | %.0f%% |\n", g->name, (unsigned)level.samples,
        (unsigned)level.seeds, before, after, left[l], honest, 100 * time);
    csv(&b->out, "%s,%u,%u,%u,%u,%.6g,%.6g,%.4f,%.4f,%.4f\n", g->name, (unsigned)g->view.width,
        (unsigned)g->view.height, (unsigned)level.samples, (unsigned)level.seeds, before, after, left[l], honest, time);
  }
  free(f.depth);
}

static void say_filtered_scenes(bench *b, int from, int to, double left[FILTER_SCENES][FILTER_LEVELS]) {
  static stage g;
  const bool few = to <= FILTER_FEW;
  const int w = few ? FILTER_WIDTH : FILTER_SMALL_WIDTH, h = few ? FILTER_HEIGHT : FILTER_SMALL_HEIGHT;
  const int truth = few ? FILTER_TRUTH : FILTER_LONG_TRUTH;
  say(&b->out,
      "DRT, %d x %d pixels; references of %d samples, their own error subtracted.\n\n"
      "| scene | samples | seeds | RMSE | filtered | ratio | estimate / truth | time / render |\n"
      "|---|--:|--:|--:|--:|--:|--:|--:|\n",
      w, h, truth);
  for (int k = 0; k < FILTER_SCENES; k++) {
    stage_open(&g, scene_names()[k], PKTRT_MODE_DRT, (uint32_t)w, (uint32_t)h);
    stage_reference(b, &g, (uint32_t)truth);
    say_filtered(b, &g, from, to, left[k]);
    stage_close(&g);
  }
  say(&b->out, "\n");
}

static void part_filter(bench *b) {
  double left[FILTER_SCENES][FILTER_LEVELS];
  int worst = 0, level = 0;
  csv(&b->out, "scene,width,height,samples,seeds,rmse,filtered_rmse,ratio,estimate_over_truth,time_over_render\n");
  say_filtered_scenes(b, 0, FILTER_FEW, left);
  say_filtered_scenes(b, FILTER_FEW, FILTER_LEVELS, left);
  say(&b->out, "Geometric means of the ratios:");
  for (int l = 0; l < FILTER_LEVELS; l++) {
    say(&b->out, "%s %u samples %.2f", l ? "," : "", (unsigned)filter_levels[l].samples,
        pow(left[0][l] * left[1][l] * left[2][l], 1.0 / FILTER_SCENES));
    for (int k = 0; k < FILTER_SCENES; k++)
      if (left[k][l] > left[worst][level]) worst = k, level = l;
  }
  say(&b->out, ". The largest ratio: %.3f, %s at %u samples.\n\n", left[worst][level], scene_names()[worst],
      (unsigned)filter_levels[level].samples);
}

/* >>check ---------------------------------------------------------------------------------------------------------- */

enum { FILTER_CHECKED = 7 };
static const filter_level filter_checked[FILTER_CHECKED] = {
    {4, 2}, {8, 16}, {16, 16}, {32, 2}, {64, 8}, {128, 1}, {256, 2}};

/* Ratios of all levels by scene, measured once for all claims. */
static double (*checked_ratios(const bench *b))[FILTER_CHECKED] {
  static double found[FILTER_SCENES][FILTER_CHECKED];
  static stage g;
  filtering f;
  if (found[0][0] > 0) return found;
  for (int k = 0; k < FILTER_SCENES; k++) {
    stage_open(&g, scene_names()[k], PKTRT_MODE_DRT, FILTER_SMALL_WIDTH, FILTER_SMALL_HEIGHT);
    stage_reference(b, &g, reference_samples(b));
    open_filtering(&f, &g);
    for (int l = 0; l < FILTER_CHECKED; l++) {
      const filtered r = measure_filtered(&g, &f, filter_checked[l]);
      found[k][l] = filtered_ratio(&r);
    }
    free(f.depth);
    stage_close(&g);
  }
  return found;
}

/* The ratio in one scene, one seed, of a filter that is told wrong variances: none, so that it must do nothing, or far too
   large ones, so that it blurs. */
static double misled_ratio(const bench *b, uint32_t samples, float scale) {
  static stage g;
  filtering f;
  stage_open(&g, "rtrt", PKTRT_MODE_DRT, FILTER_SMALL_WIDTH, FILTER_SMALL_HEIGHT);
  stage_reference(b, &g, reference_samples(b));
  open_filtering(&f, &g);
  f.scale = scale;
  const filtered r = measure_filtered(&g, &f, (filter_level){samples, 1});
  free(f.depth);
  stage_close(&g);
  return filtered_ratio(&r);
}

/* The geometric mean over scenes at c->number samples, or the largest ratio of all if that is 0. */
static double check_filter(bench *b, const claim *c, bool control, char details[DETAILS]) {
  if (control) return misled_ratio(b, c->number ? c->number : 64, c->number ? 0.0f : 100.0f);
  double(*const found)[FILTER_CHECKED] = checked_ratios(b);
  double most = 0;
  for (int l = 0; l < FILTER_CHECKED; l++) {
    double product = 1;
    for (int k = 0; k < FILTER_SCENES; k++) {
      product *= found[k][l];
      if (c->number || found[k][l] <= most) continue;
      most = found[k][l];
      snprintf(details, DETAILS, "%s, %u samples", scene_names()[k], (unsigned)filter_checked[l].samples);
    }
    if (filter_checked[l].samples != c->number) continue;
    snprintf(details, DETAILS, "%.2f, %.2f, %.2f", found[0][l], found[1][l], found[2][l]);
    return pow(product, 1.0 / FILTER_SCENES);
  }
  return c->number ? NAN : most;
}

#endif /* ERROR_FILTER_H */
