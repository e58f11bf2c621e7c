/* curves.h - true error against run time, by sampler: of the scenes with a closed form, and of parts of 512 x 384
   pictures of the built-in scenes.

   Contents: curves, stages, report, checks. */
#ifndef ERROR_CURVES_H
#define ERROR_CURVES_H

#include "closed.h"
#include "error.h"

/* >>curves --------------------------------------------------------------------------------------------------------- */

enum { MAX_POINTS = 9, FIRST_SLOPE = 4, LAST_SLOPE = 256 };

typedef struct curve { /* of one sampler */
  pktrt_sampler sampler;
  bool split; /* N samples are two passes of N / 2, so that the error can be estimated; else one of N */
  unsigned points, seeds;
  double n[MAX_POINTS], seconds[MAX_POINTS];                            /* seconds: median over seeds */
  double mse[MAX_SEEDS * MAX_POINTS], relative[MAX_SEEDS * MAX_POINTS]; /* [seed * points + point] */
} curve;

/* N from `first` to `last`, powers of two. */
static void start_curve(pktrt_sampler sampler, bool split, unsigned first, unsigned last, unsigned seeds, curve *c) {
  memset(c, 0, sizeof *c);
  c->sampler = sampler, c->split = split, c->seeds = seeds;
  for (unsigned n = first; n <= last; n *= 2) c->n[c->points++] = n;
}

static void measure_point(stage *g, curve *c, unsigned i, unsigned seed, double *seconds) {
  const uint32_t n = (uint32_t)c->n[i];
  const shot s =
      c->split ? shot_estimated(c->sampler, n, FIRST_SEED + seed) : shot_of(c->sampler, n, 1, FIRST_SEED + seed);
  outcome o;
  take_shot(g, &s, &o);
  *seconds = o.seconds, c->mse[seed * c->points + i] = o.mse, c->relative[seed * c->points + i] = o.relative;
}

/* Curves that have been started, with the same N. They take turns, so that what slows the machine slows all. */
static void measure_curves(stage *g, curve *curves, unsigned count) {
  double seconds[PKTRT_SAMPLER_COUNT][MAX_SEEDS];
  for (unsigned i = 0; i < curves[0].points; i++) {
    for (unsigned k = 0; k < MAX_SEEDS; k++)
      for (unsigned c = 0; c < count; c++)
        if (k < curves[c].seeds) measure_point(g, &curves[c], i, k, &seconds[c][k]);
    for (unsigned c = 0; c < count; c++) curves[c].seconds[i] = median_of(seconds[c], curves[c].seeds);
  }
}

static interval curve_rmse(const curve *c, unsigned i) {
  double mse[MAX_SEEDS];
  for (unsigned k = 0; k < c->seeds; k++) mse[k] = c->mse[k * c->points + i];
  return rmse_of(mse, c->seeds);
}

static unsigned point_of(const curve *c, double n) {
  unsigned i = 0;
  while (i + 1 < c->points && c->n[i] < n) i++;
  return i;
}

/* Of log RMSE over log N, N = 4 to 256. */
static interval curve_slope(const curve *c) {
  double mse[MAX_SEEDS * MAX_POINTS];
  const unsigned from = point_of(c, FIRST_SLOPE), points = point_of(c, LAST_SLOPE) + 1 - from;
  for (unsigned k = 0; k < c->seeds; k++)
    for (unsigned i = 0; i < points; i++) mse[k * points + i] = c->mse[k * c->points + from + i];
  return log_slope(c->n + from, mse, points, c->seeds);
}

typedef struct pair_at { /* curves to be compared at N samples of the first */
  const curve *a, *b;
  double n;
} pair_at;

static double figure_equal_time(const void *of, resample *r) {
  const pair_at *p = (const pair_at *)of;
  const curve *a = p->a, *b = p->b;
  const unsigned at = point_of(a, p->n);
  double rmse[MAX_POINTS] = {0}, own = 0;
  for (unsigned k = 0; k < a->seeds; k++) own += a->mse[pick(r, k, a->seeds) * a->points + at];
  for (unsigned k = 0; k < b->seeds; k++) {
    const unsigned seed = pick(r, k, b->seeds);
    for (unsigned i = 0; i < b->points; i++) rmse[i] += b->mse[seed * b->points + i];
  }
  for (unsigned i = 0; i < b->points; i++) rmse[i] = sqrt(rmse[i] / b->seeds);
  return sqrt(own / a->seeds) / log_between(b->seconds, rmse, b->points, a->seconds[at]);
}

/* RMSE of `a` with its N samples over that of `b` in the same time. */
static interval equal_time(const curve *a, const curve *b, double n) {
  const pair_at p = {a, b, n};
  return bootstrap(figure_equal_time, &p);
}

/* >>stages --------------------------------------------------------------------------------------------------------- */

enum { CLOSED_WIDTH = 16, CLOSED_HEIGHT = 12 };
enum { LARGE_WIDTH = 512, LARGE_HEIGHT = 384, BLOCK_COLUMNS = 6, BLOCK_ROWS = 4, BLOCK_WIDTH = 8, BLOCK_HEIGHT = 8 };
static const char *const built_in[3] = {"poolhall", "conference", "rtrt"};

/* Blocks of a large picture of a built-in scene, and their reference. */
static void open_blocks(const bench *b, stage *g, const char *name, pktrt_mode mode, uint32_t w, uint32_t h) {
  stage_open(g, name, mode, LARGE_WIDTH, LARGE_HEIGHT);
  g->columns = BLOCK_COLUMNS, g->rows = BLOCK_ROWS, g->block_w = w, g->block_h = h;
  stage_reference(b, g, reference_samples(b));
}

/* >>report --------------------------------------------------------------------------------------------------------- */

static const char *const mode_names[3] = {"RCS", "WRT", "DRT"};

/* At 16 and 64 samples also the RMSE over that of `random` in the same time. */
static void curve_csv(const bench *b, const stage *g, const curve *c, const curve *random) {
  const interval slope = c->n[0] <= FIRST_SLOPE ? curve_slope(c) : (interval){NAN, NAN, NAN};
  for (unsigned i = 0; i < c->points; i++) {
    const interval r = curve_rmse(c, i);
    double relative = 0;
    for (unsigned k = 0; k < c->seeds; k++) relative += c->relative[k * c->points + i] / c->seeds;
    csv(&b->out, "%s,%s,%s,%d,%.0f,%u,%.6f,%.6g,%.6g,%.6g,%.6g,%.4f,%.4f,%.4f,", g->name, mode_names[g->view.mode],
        pktrt_sampler_string(c->sampler), c->split ? 2 : 1, c->n[i], c->seeds, c->seconds[i], r.value, r.low, r.high,
        relative, slope.value, slope.low, slope.high);
    if (c->n[i] == 16 || c->n[i] == 64) csv(&b->out, "%.4f", equal_time(c, random, c->n[i]).value);
    csv(&b->out, "\n");
  }
}

static void curve_header(const bench *b) {
  csv(&b->out, "scene,mode,sampler,passes,samples,seeds,seconds,rmse,low,high,relative_mse,slope,slope_low,slope_high,"
               "over_random\n");
}

/* Three lines of a table, a column for each sampler: slopes, errors at equal time unsplit, and with the estimator. */
static void curve_lines(const bench *b, const stage *g, const curve *whole, const curve *split) {
  for (int line = 0; line < 5; line++) {
    static const char *const names[5] = {"slope", "16, one set", "64, one set", "16, two sets", "64, two sets"};
    say(&b->out, "| %s, %s | %s |", g->name, mode_names[g->view.mode], names[line]);
    for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) {
      const curve *c = line > 2 ? split : whole;
      const interval r =
          line ? equal_time(&c[s], &whole[PKTRT_SAMPLER_RANDOM], line % 2 ? 16 : 64) : curve_slope(&c[s]);
      say(&b->out, " %.2f (%.2f) |", r.value, 0.5 * (r.high - r.low));
    }
    say(&b->out, "\n");
  }
}

static void curve_table_head(const bench *b) {
  say(&b->out, "| scene | |");
  for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) say(&b->out, " %s |", pktrt_sampler_string((pktrt_sampler)s));
  say(&b->out, "\n|---|---|");
  for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) say(&b->out, "--:|");
  say(&b->out, "\n");
}

static void stage_curves(const bench *b, stage *g, unsigned seeds, unsigned sobol_seeds) {
  static curve whole[PKTRT_SAMPLER_COUNT], split[PKTRT_SAMPLER_COUNT];
  for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) {
    start_curve((pktrt_sampler)s, false, 1, 256, s == PKTRT_SAMPLER_SOBOL ? sobol_seeds : seeds, &whole[s]);
    start_curve((pktrt_sampler)s, true, 8, 128, seeds < 8 ? seeds : 8, &split[s]);
  }
  measure_curves(g, whole, PKTRT_SAMPLER_COUNT), measure_curves(g, split, PKTRT_SAMPLER_COUNT);
  for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) {
    curve_csv(b, g, &whole[s], &whole[PKTRT_SAMPLER_RANDOM]);
    curve_csv(b, g, &split[s], &whole[PKTRT_SAMPLER_RANDOM]);
  }
  curve_lines(b, g, whole, split);
}

static void part_closed(bench *b) {
  static stage g;
  double worst = 0;
  curve_header(b);
  say(&b->out,
      "Slopes of log RMSE over log N (N = 4 to 256, 32 seeds, one set); below, RMSE with 16 and 64 samples over that "
      "of random samples in one set in the same time: as one set, and as two sets, whose scatter estimates the error. "
      "In "
      "brackets half of the 95%% interval.\n\n");
  curve_table_head(b);
  for (unsigned k = 0; k < CLOSED_SCENES; k++) {
    worst = larger(worst, closed_open(&g, k, CLOSED_WIDTH, CLOSED_HEIGHT));
    stage_curves(b, &g, 32, 32);
    stage_close(&g);
  }
  say(&b->out, "\nThe quadratures behind the exact pixels change by %.1e at most if refined.\n\n", worst);
}

static void part_scenes(bench *b) {
  static stage g;
  curve_header(b);
  say(&b->out,
      "%d blocks of %d x %d pixels in the middles of %d x %d parts of a picture of %d x %d. Sobol' points: 32 seeds "
      "(WRT: 8); the others: 3. Lines as above.\n\n",
      BLOCK_COLUMNS * BLOCK_ROWS, BLOCK_WIDTH, BLOCK_HEIGHT, BLOCK_COLUMNS, BLOCK_ROWS, LARGE_WIDTH, LARGE_HEIGHT);
  curve_table_head(b);
  for (int mode = PKTRT_MODE_DRT; mode >= PKTRT_MODE_WRT; mode--)
    for (int k = 0; k < 3; k++) {
      open_blocks(b, &g, built_in[k], (pktrt_mode)mode, BLOCK_WIDTH, BLOCK_HEIGHT);
      stage_curves(b, &g, 3, mode == PKTRT_MODE_DRT ? 32 : 8);
      stage_close(&g);
    }
  say(&b->out, "\n");
}

/* >>checks --------------------------------------------------------------------------------------------------------- */

enum { CHECKED_STAGES = CLOSED_SCENES + 3 }; /* closed ones, then the DRT scenes */
static const char *checked_name(unsigned k) {
  return k < CLOSED_SCENES ? closed_scenes[k].name : built_in[k - CLOSED_SCENES];
}
static void note(char details[DETAILS], const char *name, interval r) {
  const size_t at = strlen(details);
  snprintf(details + at, DETAILS - at, "%s%s %.2f [%.2f, %.2f]", at ? ", " : "", name, r.value, r.low, r.high);
}

/* With 32 seeds. DRT scenes in smaller blocks. */
static const curve *slope_curve(const bench *b, unsigned k) {
  static curve curves[CHECKED_STAGES];
  static stage g;
  if (curves[k].points) return &curves[k];
  if (k < CLOSED_SCENES) closed_open(&g, k, CLOSED_WIDTH, CLOSED_HEIGHT);
  else open_blocks(b, &g, checked_name(k), PKTRT_MODE_DRT, 2, 2);
  start_curve(PKTRT_SAMPLER_SOBOL, false, FIRST_SLOPE, LAST_SLOPE, 32, &curves[k]);
  measure_curves(&g, &curves[k], 1);
  stage_close(&g);
  return &curves[k];
}

/* The shallowest slope of the scenes: c->number 0: closed ones, 1: DRT. The control gives all N the error of the least,
   as if samples were the same again and again. */
static double check_scene_slope(bench *b, const claim *c, bool control, char details[DETAILS]) {
  double worst = -INFINITY;
  for (unsigned k = c->number ? CLOSED_SCENES : 0; k < (c->number ? CHECKED_STAGES : CLOSED_SCENES); k++) {
    curve x = *slope_curve(b, k);
    for (unsigned i = 0; control && i < x.points * x.seeds; i++) x.mse[i] = x.mse[i / x.points * x.points];
    const interval r = curve_slope(&x);
    worst = larger(worst, r.value);
    note(details, checked_name(k), r);
  }
  return worst;
}

static const curve *time_curve(const bench *b, unsigned k, pktrt_sampler sampler) {
  static curve curves[CHECKED_STAGES][2];
  static stage g;
  curve *two = curves[k];
  if (!two->points) {
    if (k < CLOSED_SCENES) closed_open(&g, k, 2 * CLOSED_WIDTH, 2 * CLOSED_HEIGHT);
    else open_blocks(b, &g, checked_name(k), PKTRT_MODE_DRT, BLOCK_WIDTH, BLOCK_HEIGHT);
    start_curve(PKTRT_SAMPLER_SOBOL, true, 8, 128, k < CLOSED_SCENES ? 12 : 3, &two[0]);
    start_curve(PKTRT_SAMPLER_RANDOM, false, 8, 128, k < CLOSED_SCENES ? 12 : 3, &two[1]);
    measure_curves(&g, two, 2);
    stage_close(&g);
  }
  return &two[sampler == PKTRT_SAMPLER_SOBOL ? 0 : 1];
}

/* RMSE at the time of c->number samples, Sobol' points in two passes over random ones in one set: the worst of the
   closed scenes, or the geometric mean of the DRT scenes. The control: random over Sobol'. */
static double check_equal_time(bench *b, const claim *c, bool control, char details[DETAILS]) {
  const bool closed_ones = !strcmp(c->on, "closed");
  double worst = 0, product = 1;
  for (unsigned k = closed_ones ? 0 : CLOSED_SCENES; k < (closed_ones ? CLOSED_SCENES : CHECKED_STAGES); k++) {
    const curve *x = time_curve(b, k, PKTRT_SAMPLER_SOBOL), *y = time_curve(b, k, PKTRT_SAMPLER_RANDOM);
    const interval r = control ? equal_time(y, x, c->number) : equal_time(x, y, c->number);
    worst = larger(worst, r.value), product *= r.value;
    note(details, checked_name(k), r);
  }
  return closed_ones ? worst : cbrt(product);
}

#endif /* ERROR_CURVES_H */
