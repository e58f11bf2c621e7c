/* filter.h - what examples/filter.h leaves of the error: true errors of pictures before and after, by samples; whether
   its own estimate is the truth; and its time beside that of the render. */
#ifndef ERROR_FILTER_H
#define ERROR_FILTER_H

#include "error.h"
#include "hard.h"
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
  double shown[2];         /* the same as mse of the pictures cut off to [0,1], as a screen shows them */
  unsigned doubted, close; /* runs whose estimate is unreliable; of the others, within 0.7 to 1.3 times the truth */
  double seconds[2];       /* of render and filter */
} filtered;

static bool gather_filtering(void *user, const pktrt_report *report) {
  filtering *f = (filtering *)user;
  (void)report;
  filter_add_pass(&f->halves, f->pixels);
  filter_add_features(&f->halves, f->depth, f->normal, f->albedo);
  return true;
}

static double on_screen(double x) { return x < 0 ? 0 : x < 1 ? x : 1; }

/* The mean squared error of a channel as a screen shows it. The truth's own noise is left in: it is known for sums over
   channels that are not cut off. */
static double screen_error(const stage *g) {
  const size_t n = 3 * stage_pixels(g);
  double sum = 0;
  for (size_t i = 0; i < n; i++) sum += square(on_screen((double)g->pixels[i]) - on_screen(g->truth[i]));
  return sum / (double)n;
}

/* Adds up whether the estimate of a run is near the truth, or unreliable. */
static void judge_estimate(const filter_picture *taken, const filtering *f, double estimate, double mse, filtered *to) {
  const double ratio = sqrt(fmax(estimate, 0) / fmax(mse, 1e-30));
  if (filter_unreliable(taken, f->error)) to->doubted++;
  else to->close += ratio >= 0.7 && ratio <= 1.3;
}

/* Renders in passes, filters, and adds up what that brings. */
static void take_filtered_passes(
    stage *g, filtering *f, uint32_t passes, uint32_t samples, uint32_t seed, filtered *to) {
  pktrt_render_desc d = g->view;
  filter_picture taken;
  double mse, relative, sum = 0;
  if (!filter_begin(&f->halves, d.width, d.height)) fatal("not enough memory");
  f->pixels = d.pixels = g->pixels;
  d.depth = f->depth, d.normal = f->normal, d.albedo = f->albedo;
  d.passes = passes, d.samples = samples, d.seed = seed;
  d.pass = gather_filtering, d.user = f;

  const double start = cpu_seconds();
  if (pktrt_render(g->world, &d) != PKTRT_OK) fatal(pktrt_last_error(g->world));
  to->seconds[0] += cpu_seconds() - start;
  true_errors(g, &mse, &relative);
  to->mse[0] += mse;
  to->shown[0] += screen_error(g);

  const double again = cpu_seconds();
  filter_finish(&f->halves, &taken);
  for (size_t i = 0; i < stage_pixels(g) && f->scale != 1; i++) f->halves.variance[i] *= f->scale;
  taken.depth = f->depth, taken.normal = f->normal, taken.albedo = f->albedo;
  if (!filter_rectangle(&taken, 0, 0, d.width, d.height, g->pixels, f->error)) fatal("not enough memory");
  to->seconds[1] += cpu_seconds() - again;

  for (size_t i = 0; i < stage_pixels(g); i++) sum += (double)f->error[i];
  true_errors(g, &mse, &relative);
  to->mse[1] += mse;
  to->shown[1] += screen_error(g);
  to->estimate += sum / (3 * (double)stage_pixels(g));
  judge_estimate(&taken, f, sum / (3 * (double)stage_pixels(g)), mse, to);
  filter_end(&f->halves);
}

/* The same in as many passes as render.c makes for the filter. */
static void take_filtered(stage *g, filtering *f, uint32_t samples, uint32_t seed, filtered *to) {
  const uint32_t passes = samples >= 16 ? 8 : samples >= 8 ? 4 : 2;
  take_filtered_passes(g, f, passes, samples / passes, seed, to);
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
static double filtered_ratio(const filtered *r) { return sqrt(larger(r->mse[1], 0) / r->mse[0]); }

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

/* Passes by samples. */
enum { SHOWN_PLANS = 4, SHOWN_SCENES = HARD_SCENES + FILTER_SCENES, SHOWN_WIDTH = 64, SHOWN_HEIGHT = 48 };
static const struct shown_plan {
  uint32_t passes, samples;
} shown_plans[SHOWN_PLANS] = {{2, 2}, {2, 4}, {8, 2}, {8, 8}};

/* The small scenes, then the built-in ones, with their references. */
static void open_shown(const bench *b, stage *g, unsigned k) {
  if (k < HARD_SCENES) hard_open(g, k, SHOWN_WIDTH, SHOWN_HEIGHT);
  else stage_open(g, scene_names()[k - HARD_SCENES], PKTRT_MODE_DRT, SHOWN_WIDTH, SHOWN_HEIGHT);
  stage_reference(b, g, REFERENCE_SAMPLES);
}

static filtered measure_screen(const bench *b, stage *g, filtering *f, unsigned plan, unsigned seeds) {
  filtered r;
  memset(&r, 0, sizeof r);
  for (uint32_t k = 0; k < seeds; k++)
    take_filtered_passes(g, f, shown_plans[plan].passes, shown_plans[plan].samples, b->given.seed + 1000 * k, &r);
  return r;
}

/* RMSE on a screen, filtered over unfiltered, all seeds together. */
static double shown_ratio(const filtered *r) { return sqrt(r->shown[1] / r->shown[0]); }

/* The RMSE on a screen of one set of samples that takes as long as one run of render and filter, all seeds. A set of the
   same number of samples tells the time of a sample. */
static double one_set(const bench *b, stage *g, unsigned plan, unsigned seeds, const filtered *r) {
  const uint32_t samples = shown_plans[plan].passes * shown_plans[plan].samples;
  const double budget = (r->seconds[0] + r->seconds[1]) / seeds;
  double seconds = 0, sum = 0;
  outcome o;
  for (unsigned k = 0; k < seeds && k < 3; k++) {
    const shot s = shot_of(PKTRT_SAMPLER_SOBOL, samples, 1, b->given.seed + 1000 * k);
    take_shot(g, &s, &o);
    seconds += o.seconds / (seeds < 3 ? seeds : 3);
  }
  const uint32_t fitting = (uint32_t)fmax(1, floor(samples * budget / seconds + 0.5));
  for (unsigned k = 0; k < seeds; k++) {
    const shot s = shot_of(PKTRT_SAMPLER_SOBOL, fitting, 1, b->given.seed + 1000 * k);
    take_shot(g, &s, &o);
    sum += screen_error(g);
  }
  return sqrt(sum);
}

/* What a screen shows of small scenes, each hard in a way of its own: passes of the same samples, and one set in the same
   time. */
static void part_filter_shown(bench *b) {
  enum { SEEDS_SHOWN = 30 };
  static stage g;
  filtering f;
  double smooth = 0, largest = 0;
  unsigned smooth_cells = 0, doubted = 0, close = 0, runs = 0;
  csv(&b->out, "scene,passes,samples,seeds,ratio,ratio_to_one_set,estimate_over_truth,unreliable,within,time\n");
  say(&b->out,
      "RMSE on a screen (cut off to [0,1]) of the filtered picture over that of the unfiltered one, %d x %d pixels, %d "
      "seeds together; in brackets over that of one set of samples in the time of render and filter.\n\n| scene |",
      (int)SHOWN_WIDTH, (int)SHOWN_HEIGHT, (int)SEEDS_SHOWN);
  for (int p = 0; p < SHOWN_PLANS; p++)
    say(&b->out, " %u x %u |", (unsigned)shown_plans[p].passes, (unsigned)shown_plans[p].samples);
  say(&b->out, "\n|---|--:|--:|--:|--:|\n");

  for (unsigned k = 0; k < SHOWN_SCENES; k++) {
    open_shown(b, &g, k);
    open_filtering(&f, &g);
    say(&b->out, "| %s |", g.name);
    for (unsigned p = 0; p < SHOWN_PLANS; p++) {
      const filtered r = measure_screen(b, &g, &f, p, SEEDS_SHOWN);
      const double ratio = shown_ratio(&r), equal = sqrt(r.shown[1]) / one_set(b, &g, p, SEEDS_SHOWN, &r);
      say(&b->out, " %.2f (%.2f) |", ratio, equal);
      csv(&b->out, "%s,%u,%u,%d,%.4f,%.4f,%.4f,%u,%u,%.4f\n", g.name, (unsigned)shown_plans[p].passes,
          (unsigned)shown_plans[p].samples, (int)SEEDS_SHOWN, ratio, equal,
          sqrt(fmax(r.estimate, 0) / fmax(r.mse[1], 1e-30)), r.doubted, r.close, r.seconds[1] / r.seconds[0]);
      largest = larger(largest, ratio);
      if (k < HARD_SCENES && hard_scenes[k].smooth) smooth += ratio, smooth_cells++;
      doubted += r.doubted, close += r.close, runs += SEEDS_SHOWN;
    }
    say(&b->out, "\n");
    free(f.depth);
    stage_close(&g);
  }
  say(&b->out,
      "\nThe largest ratio: %.3f; the mean of shadows, sky, lamps and motion: %.3f. Estimates: %.1f%% are called "
      "unreliable; of the others %.1f%% are within 0.7 to 1.3 times the truth.\n\n",
      largest, smooth / smooth_cells, 100.0 * doubted / runs, 100.0 * close / (runs - doubted));
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
      if (c->number || isnan(most) || found[k][l] <= most) continue;
      most = found[k][l];
      snprintf(details, DETAILS, "%s, %u samples", scene_names()[k], (unsigned)filter_checked[l].samples);
    }
    if (filter_checked[l].samples != c->number) continue;
    snprintf(details, DETAILS, "%.2f, %.2f, %.2f", found[0][l], found[1][l], found[2][l]);
    return pow(product, 1.0 / FILTER_SCENES);
  }
  return c->number ? NAN : most;
}

/* Of all small and built-in scenes on a screen, measured once for the claims below. */
typedef struct shown_all {
  double largest, smooth, within, doubted; /* ratios; shares of runs */
  char worst[64];
} shown_all;

static const shown_all *checked_shown(const bench *b) {
  enum { SEEDS_CHECKED = 8 };
  static shown_all found;
  static stage g;
  filtering f;
  unsigned cells = 0, runs = 0, doubted = 0, close = 0;
  if (found.largest > 0) return &found;
  for (unsigned k = 0; k < SHOWN_SCENES; k++) {
    open_shown(b, &g, k);
    open_filtering(&f, &g);
    for (unsigned p = 0; p < SHOWN_PLANS; p++) {
      const filtered r = measure_screen(b, &g, &f, p, SEEDS_CHECKED);
      const double ratio = shown_ratio(&r);
      if (k < HARD_SCENES && hard_scenes[k].smooth) found.smooth += ratio, cells++;
      runs += SEEDS_CHECKED, doubted += r.doubted, close += r.close;
      if (isnan(found.largest) || ratio <= found.largest) continue;
      found.largest = ratio;
      snprintf(found.worst, sizeof found.worst, "%s, %u x %u", g.name, (unsigned)shown_plans[p].passes,
          (unsigned)shown_plans[p].samples);
    }
    free(f.depth);
    stage_close(&g);
  }
  found.smooth /= cells;
  found.doubted = (double)doubted / runs;
  found.within = (double)close / (runs - doubted);
  return &found;
}

/* A picture of the mirrors by a filter that is told wrong variances: far too large ones, so that it blurs, or none, so
   that it does nothing and takes its error for none. */
static filtered misled_shown(const bench *b, float scale) {
  static stage g;
  filtering f;
  unsigned which = 0;
  while (strcmp(hard_scenes[which].name, "mirrors")) which++;
  open_shown(b, &g, which);
  open_filtering(&f, &g);
  f.scale = scale;
  const filtered r = measure_screen(b, &g, &f, SHOWN_PLANS - 1, 2);
  free(f.depth);
  stage_close(&g);
  return r;
}

/* On a screen: the largest ratio of all scenes (c->number 0) or the mean of the smooth ones (1); the part of runs whose
   estimate, not called unreliable, is within 0.7 to 1.3 times the truth (2), and that of those called unreliable (3). The
   controls: a filter that blurs; that does nothing; that takes pictures for exact; and a picture with all noise in one
   pixel. */
static double check_screen(bench *b, const claim *c, bool control, char details[DETAILS]) {
  if (control && c->number == 3) {
    float variance[16] = {0}, error[16] = {0};
    filter_picture one;
    filtering f;
    filtered judged;
    memset(&one, 0, sizeof one);
    memset(&f, 0, sizeof f);
    memset(&judged, 0, sizeof judged);
    one.width = one.height = 4, one.variance = variance;
    variance[5] = error[5] = 1;
    f.error = error;
    judge_estimate(&one, &f, 0, 0, &judged);
    return judged.doubted;
  }
  if (control) {
    const filtered r = misled_shown(b, c->number == 0 ? 1000.0f : 0.0f);
    return c->number == 2 ? (double)r.close / (2 - r.doubted) : shown_ratio(&r);
  }
  const shown_all *all = checked_shown(b);
  snprintf(details, DETAILS, "the largest: %s", all->worst);
  return c->number == 0 ? all->largest : c->number == 1 ? all->smooth : c->number == 2 ? all->within : all->doubted;
}

#endif /* ERROR_FILTER_H */
