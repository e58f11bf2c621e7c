/* filter.h - what examples/filter.h leaves of the error: true errors of pictures before and after, by samples; whether
   its own estimate is the truth; and its time beside that of the render. */
#ifndef ERROR_FILTER_H
#define ERROR_FILTER_H

#include "../../examples/filter.h"
#include "error.h"

enum { FILTER_SEEDS = 3, FILTER_LEVELS = 5, FILTER_WIDTH = 128, FILTER_HEIGHT = 96, FILTER_TRUTH = 1024 };
static const uint32_t filter_samples[FILTER_LEVELS] = {4, 8, 16, 32, 64};

typedef struct filtering {
  filter_halves halves;
  float *depth, *normal, *albedo, *error;
  const float *pixels;
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
  taken.depth = f->depth, taken.normal = f->normal, taken.albedo = f->albedo;
  if (!filter_rectangle(&taken, 0, 0, d.width, d.height, g->pixels, f->error)) fatal("not enough memory");
  to->seconds[0] += rendered - start, to->seconds[1] += cpu_seconds() - again;
  for (size_t i = 0; i < stage_pixels(g); i++) sum += (double)f->error[i];
  true_errors(g, &mse, &relative);
  to->mse[1] += mse, to->estimate += sum / (3 * (double)stage_pixels(g));
  filter_end(&f->halves);
}

/* Returns a line's left: RMSE filtered over unfiltered, for each number of samples. */
static void say_filtered(const bench *b, stage *g, double left[FILTER_LEVELS]) {
  const size_t n = stage_pixels(g);
  filtering f;
  memset(&f, 0, sizeof f);
  f.depth = (float *)calloc(n * 8, sizeof(float));
  if (!f.depth) fatal("not enough memory");
  f.normal = f.depth + n, f.albedo = f.depth + 4 * n, f.error = f.depth + 7 * n;
  for (int l = 0; l < FILTER_LEVELS; l++) {
    filtered r;
    memset(&r, 0, sizeof r);
    for (uint32_t k = 0; k < FILTER_SEEDS; k++)
      take_filtered(g, &f, filter_samples[l], (uint32_t)FIRST_SEED + 1000 * k, &r);
    left[l] = sqrt(fmax(r.mse[1], 0) / r.mse[0]);
    const double honest = sqrt(fmax(r.estimate, 0) / fmax(r.mse[1], 1e-30)), time = r.seconds[1] / r.seconds[0];
    const double before = sqrt(fmax(r.mse[0], 0) / (double)FILTER_SEEDS);
    const double after = sqrt(fmax(r.mse[1], 0) / (double)FILTER_SEEDS);
    say(&b->out, "| %s | %u | %.4f | %.4f | %.2f | %.2f | %.0f%% |\n", g->name, (unsigned)filter_samples[l], before,
        after, left[l], honest, 100 * time);
    csv(&b->out, "%s,%u,%.6g,%.6g,%.4f,%.4f,%.4f\n", g->name, (unsigned)filter_samples[l], before, after, left[l],
        honest, time);
  }
  free(f.depth);
}

static void part_filter(bench *b) {
  static stage g;
  double left[3][FILTER_LEVELS];
  csv(&b->out, "scene,samples,rmse,filtered_rmse,ratio,estimate_over_truth,time_over_render\n");
  say(&b->out,
      "DRT, %d x %d pixels, %d seeds; references of %d samples, their own error subtracted.\n\n"
      "| scene | samples | RMSE | filtered | ratio | estimate / truth | time / render |\n"
      "|---|--:|--:|--:|--:|--:|--:|\n",
      (int)FILTER_WIDTH, (int)FILTER_HEIGHT, (int)FILTER_SEEDS, (int)FILTER_TRUTH);
  for (int k = 0; k < 3; k++) {
    stage_open(&g, scene_names()[k], PKTRT_MODE_DRT, FILTER_WIDTH, FILTER_HEIGHT);
    stage_reference(b, &g, FILTER_TRUTH);
    say_filtered(b, &g, left[k]);
    stage_close(&g);
  }
  say(&b->out, "\nGeometric means of the left:");
  for (int l = 0; l < FILTER_LEVELS; l++)
    say(&b->out, "%s %u samples %.2f", l ? "," : "", (unsigned)filter_samples[l],
        pow(left[0][l] * left[1][l] * left[2][l], 1.0 / 3));
  say(&b->out, ".\n\n");
}

#endif /* ERROR_FILTER_H */
