/* estimates.h - whether estimates are the truth, whether targets are met, and what adaptive passes save
   against one uniform set of samples.

   Whole pictures: of the scenes with a closed form, and of the built-in scenes by DRT, against references.

   Contents: stages, estimates, targets, adaptive passes, report, checks. */
#ifndef ERROR_ESTIMATES_H
#define ERROR_ESTIMATES_H

#include "closed.h"
#include "curves.h"
#include "error.h"

/* >>stages --------------------------------------------------------------------------------------------------------- */

/* What is estimated is a mean over pixels. In the DRT scenes a few of them, where light is rare and bright, are most of
   it: in a small picture it is a matter of luck, whoever measures it. */
typedef enum picture { SMALL, MIDDLE, LARGE } picture;
static const uint32_t widths[] = {32, 64, 128}, heights[] = {32, 48, 96};

static void open_whole(const bench *b, stage *g, unsigned k, picture size) {
  const uint32_t samples = reference_samples(b);
  if (k < CLOSED_SCENES) {
    closed_open(g, k, widths[size], heights[size]);
    return;
  }
  stage_open(g, checked_name(k), PKTRT_MODE_DRT, widths[size], heights[size]);
  stage_reference(b, g, b->given.check && size == LARGE ? samples / 2 : samples);
}

/* >>estimates ------------------------------------------------------------------------------------------------------ */

static const struct plan { uint32_t samples, passes; } plans[] = {{4, 2}, {8, 2}, {8, 4}, {8, 8}, {32, 2}};
enum { PLANS = sizeof plans / sizeof *plans, CHECKED_PLANS = PLANS - 1, MAX_RUNS = 4096 };

typedef struct ratios { /* of what was estimated, or aimed at, and what was true */
  unsigned n;
  double value[MAX_RUNS];
} ratios;

static void add_ratio(ratios *to, double value) {
  if (to->n == MAX_RUNS) fatal("too many runs");
  to->value[to->n++] = value;
}

static double share_within(const ratios *r, double low, double high) {
  unsigned within = 0;
  for (unsigned i = 0; i < r->n; i++) within += r->value[i] >= low && r->value[i] <= high;
  return r->n ? (double)within / r->n : NAN;
}

static double part_of(ratios *r, double share) { /* a quantile; sorts */
  qsort(r->value, r->n, sizeof *r->value, compare_doubles);
  return r->n ? r->value[(unsigned)(share * (r->n - 1) + 0.5)] : NAN;
}

typedef struct sayings { /* estimated over true RMSE and relative MSE; of those runs that call theirs reliable */
  ratios rmse, relative, reliable, relative_reliable;
  ratios held; /* whether the true RMSE is in the interval, 1 or 0 */
} sayings;

static void clear_sayings(sayings *to) {
  to->rmse.n = to->relative.n = to->reliable.n = to->relative_reliable.n = to->held.n = 0;
}

static void add_ratios(ratios *to, const ratios *more) {
  for (unsigned i = 0; i < more->n; i++) add_ratio(to, more->value[i]);
}

static void add_sayings(sayings *to, const sayings *more) {
  add_ratios(&to->rmse, &more->rmse), add_ratios(&to->relative, &more->relative);
  add_ratios(&to->reliable, &more->reliable), add_ratios(&to->relative_reliable, &more->relative_reliable);
  add_ratios(&to->held, &more->held);
}

/* Adds estimated over true RMSE, and relative MSE. `naive`: what the variance within a set would say instead, if its samples
   were taken as independent: the estimate that as many independent samples have. */
static void run_estimates(stage *g, pktrt_sampler sampler, unsigned p, unsigned seeds, bool naive, sayings *to) {
  for (unsigned k = 0; k < seeds; k++) {
    const shot s = shot_of(sampler, plans[p].samples, plans[p].passes, FIRST_SEED + k);
    shot other = s;
    outcome o, said;
    other.sampler = PKTRT_SAMPLER_RANDOM;
    take_shot(g, &s, &o);
    said = o;
    if (naive) take_shot(g, &other, &said);
    const double truth = sqrt(fmax(o.mse, 1e-30)), ratio = said.report.rmse / truth,
                 relative = said.report.relative_mse / fmax(o.relative, 1e-30);
    add_ratio(&to->rmse, ratio), add_ratio(&to->relative, relative);
    if (!said.report.unreliable[PKTRT_ERROR_RMSE]) add_ratio(&to->reliable, ratio);
    if (!said.report.unreliable[PKTRT_ERROR_RELATIVE]) add_ratio(&to->relative_reliable, relative);
    add_ratio(&to->held, truth >= said.report.rmse_low && truth <= said.report.rmse_high ? 1 : 0);
  }
}

/* >>targets -------------------------------------------------------------------------------------------------------- */

enum { TARGET_SAMPLES = 8, TARGET_PASSES = 256 };
static const double target_parts[] = {0.75, 0.5, 0.3}; /* of the error of two passes; squared for the relative MSE */
enum { TARGETS = sizeof target_parts / sizeof *target_parts };

typedef struct aims { /* true error over target; times and samples */
  ratios met;
  double samples, unmet; /* mean over runs; runs that ended by another rule */
  double doubted;        /* runs that ended with an estimate called unreliable */
} aims;

/* `lax`: the renderer makes two passes whatever the target. (Told twice the target, or eight times, it met the target in
   nine adaptive DRT runs of nine: no run ends before its estimate is reliable, and by then these errors are below.) */
static void run_targets(stage *g, bool adaptive, pktrt_error_measure measure, unsigned seeds, bool lax, aims *to) {
  const shot two = shot_of(PKTRT_SAMPLER_SOBOL, TARGET_SAMPLES, 2, FIRST_SEED + 1000);
  const bool relative = measure == PKTRT_ERROR_RELATIVE;
  outcome first, o;
  take_shot(g, &two, &first);
  for (unsigned t = 0; t < TARGETS; t++)
    for (unsigned k = 0; k < seeds; k++) {
      shot s = shot_of(PKTRT_SAMPLER_SOBOL, TARGET_SAMPLES, TARGET_PASSES, FIRST_SEED + k);
      const double target =
          relative ? first.report.relative_mse * square(target_parts[t]) : first.report.rmse * target_parts[t];
      s.adaptive = adaptive, s.measure = measure, s.target = lax ? 0 : target;
      if (lax) s.passes = 2;
      take_shot(g, &s, &o);
      to->samples += o.report.samples_mean, to->unmet += o.report.stop != PKTRT_STOP_ERROR;
      to->doubted += o.report.unreliable[measure];
      add_ratio(&to->met, (relative ? o.relative : sqrt(larger(o.mse, 0))) / target);
    }
}

/* >>adaptive passes ------------------------------------------------------------------------------------------------ */

enum { ADAPTIVE_SAMPLES = 8, ADAPTIVE_POINTS = 4, PAID = 2 }; /* passes: 2, 4, 8, 16; by 8, pilot passes are paid for */
static uint32_t passes_at(unsigned point) { return 2u << point; }

typedef struct effort { /* by passes; errors: means over seeds, of MSE and relative MSE; mse: each seed's */
  double seconds[ADAPTIVE_POINTS], error[2][ADAPTIVE_POINTS], mse[ADAPTIVE_POINTS][MAX_SEEDS];
  unsigned seeds;
} effort;

/* Efforts of some shots that differ in how passes are given, at points `first` to `last`: they take turns. */
static void measure_efforts(
    stage *g, const shot *ways, unsigned count, unsigned first, unsigned last, unsigned seeds, effort *to) {
  double seconds[3][MAX_SEEDS];
  for (unsigned w = 0; w < count; w++) to[w].seeds = seeds;
  for (unsigned i = first; i <= last; i++) {
    for (unsigned k = 0; k < seeds; k++)
      for (unsigned w = 0; w < count; w++) {
        shot s = ways[w];
        outcome o;
        s.seed = FIRST_SEED + k;
        s.passes = s.adaptive ? passes_at(i) : 1;
        s.samples = s.adaptive ? ADAPTIVE_SAMPLES : ADAPTIVE_SAMPLES * passes_at(i);
        take_shot(g, &s, &o);
        to[w].error[PKTRT_ERROR_RMSE][i] += o.mse / seeds, to[w].error[PKTRT_ERROR_RELATIVE][i] += o.relative / seeds;
        to[w].mse[i][k] = o.mse, seconds[w][k] = o.seconds;
      }
    for (unsigned w = 0; w < count; w++) to[w].seconds[i] = median_of(seconds[w], seeds);
  }
}

/* Uniform, all samples in one set and without estimates, which is the best that a render without passes can do; adaptive,
   lowering the RMSE; adaptive, lowering the relative MSE. */
static void three_ways(shot ways[3]) {
  for (int w = 0; w < 3; w++) {
    ways[w] = shot_of(PKTRT_SAMPLER_SOBOL, ADAPTIVE_SAMPLES, passes_at(0), FIRST_SEED);
    ways[w].adaptive = ways[w].estimate = w > 0, ways[w].measure = w == 2 ? PKTRT_ERROR_RELATIVE : PKTRT_ERROR_RMSE;
  }
}

/* The power of time by which the squared errors of uniform sets fall: least squares through the logarithms of all
   points. At least 1, which independent samples have, and at most 2: few points where rare light decides could say
   anything. */
static double falling(const double *seconds, const double *squared, unsigned points) {
  double x[ADAPTIVE_POINTS], y[ADAPTIVE_POINTS];
  unsigned n = 0;
  for (unsigned k = 0; k < points; k++) {
    if (!(seconds[k] > 0 && squared[k] > 0)) continue;
    x[n] = log(seconds[k]);
    y[n++] = log(squared[k]);
  }
  return n < 2 ? 1 : fmin(fmax(-slope_of(x, y, n), 1), 2);
}

/* Time of `a` at point i over the time in which uniform sets reach the same error, from the set of as many samples. */
static double time_ratio(const effort *a, const effort *uniform, pktrt_error_measure m, unsigned i) {
  const double power = falling(uniform->seconds, uniform->error[m], ADAPTIVE_POINTS);
  return a->seconds[i] / uniform->seconds[i] * pow(a->error[m][i] / uniform->error[m][i], 1 / power);
}

/* >>report --------------------------------------------------------------------------------------------------------- */

enum { SEEDS = 12 };

/* Two passes of 8 samples of the scenes with a closed form: a line for each sampler. */
static void estimates_by_sampler(const bench *b) {
  enum { PLAN = 1 };
  static sayings said[PKTRT_SAMPLER_COUNT];
  static stage g;
  for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) clear_sayings(&said[s]);
  for (unsigned k = 0; k < CLOSED_SCENES; k++) {
    closed_open(&g, k, widths[MIDDLE], heights[MIDDLE]);
    for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) run_estimates(&g, (pktrt_sampler)s, PLAN, SEEDS, false, &said[s]);
    stage_close(&g);
  }
  say(&b->out,
      "By sampler, all scenes with a closed form, two passes of 8 samples:\n\n| sampler | RMSE | within 25%% | "
      "relative MSE | within 25%% |\n|---|--:|--:|--:|--:|\n");
  for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) {
    ratios *rmse = &said[s].rmse, *relative = &said[s].relative;
    say(&b->out, "| %s | %.2f (%.2f, %.2f) | %.0f%% |", pktrt_sampler_string((pktrt_sampler)s), part_of(rmse, 0.5),
        part_of(rmse, 0.05), part_of(rmse, 0.95), 100 * share_within(rmse, 0.75, 1.25));
    say(&b->out, " %.2f | %.0f%% |\n", part_of(relative, 0.5), 100 * share_within(relative, 0.75, 1.25));
  }
  say(&b->out, "\n");
}

/* A share in percent, or a dash if there is none. */
static void say_share(const bench *b, double share) {
  if (share >= 0) say(&b->out, " %.0f%% |", 100 * share);
  else say(&b->out, " - |");
}

/* One line of the table, and of the CSV file. */
static void say_estimates(const bench *b, const stage *g, const struct plan *plan, sayings *said) {
  const double runs = said->rmse.n, within = share_within(&said->rmse, 0.75, 1.25),
               unreliable = 1 - said->reliable.n / runs, among = share_within(&said->reliable, 0.75, 1.25),
               held = share_within(&said->held, 1, 1);
  say(&b->out, "| %s, %u x %u | %u x %u | %.2f (%.2f, %.2f) | %.0f%% | %.0f%% |", g->name, (unsigned)g->view.width,
      (unsigned)g->view.height, (unsigned)plan->passes, (unsigned)plan->samples, part_of(&said->rmse, 0.5),
      part_of(&said->rmse, 0.05), part_of(&said->rmse, 0.95), 100 * within, 100 * unreliable);
  say_share(b, among), say_share(b, held);
  say(&b->out, " %.2f | %.0f%% | %.0f%% |", part_of(&said->relative, 0.5),
      100 * share_within(&said->relative, 0.75, 1.25), 100 * (1 - said->relative_reliable.n / runs));
  say_share(b, share_within(&said->relative_reliable, 0.75, 1.25));
  say(&b->out, "\n");
  csv(&b->out, "%s,%u,%u,%u,%u,%u,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f,", g->name, (unsigned)g->view.width,
      (unsigned)g->view.height, (unsigned)plan->samples, (unsigned)plan->passes, said->rmse.n,
      part_of(&said->rmse, 0.5), part_of(&said->rmse, 0.05), part_of(&said->rmse, 0.95), within, unreliable, among,
      held);
  csv(&b->out, "%.4f,%.4f,%.4f,%.4f\n", part_of(&said->relative, 0.5), share_within(&said->relative, 0.75, 1.25),
      1 - said->relative_reliable.n / runs, share_within(&said->relative_reliable, 0.75, 1.25));
}

/* All plans of a picture: lines, and what they add to the sums over scenes. */
static void estimate_picture(bench *b, unsigned k, unsigned seeds, sayings *all, sayings *long_runs) {
  static sayings said;
  static stage g;
  open_whole(b, &g, k, MIDDLE);
  for (unsigned p = 0; p < PLANS; p++) {
    clear_sayings(&said);
    run_estimates(&g, PKTRT_SAMPLER_SOBOL, p, seeds, false, &said);
    add_sayings(all, &said);
    if (plans[p].samples * plans[p].passes == 64) add_sayings(long_runs, &said);
    say_estimates(b, &g, &plans[p], &said);
  }
  stage_close(&g);
}

static void say_sayings(const bench *b, const char *what, const sayings *of) {
  say(&b->out,
      "Of %s, %u runs, %.1f%% are within 25%% of the true RMSE; %.1f%% are called unreliable, of the others %.1f%% "
      "are; "
      "intervals hold the truth in %.1f%%. Relative MSE: %.1f%%; %.1f%% called unreliable, of the others %.1f%%.\n\n",
      what, of->rmse.n, 100 * share_within(&of->rmse, 0.75, 1.25), 100 * (1 - (double)of->reliable.n / of->rmse.n),
      100 * share_within(&of->reliable, 0.75, 1.25), 100 * share_within(&of->held, 1, 1),
      100 * share_within(&of->relative, 0.75, 1.25), 100 * (1 - (double)of->relative_reliable.n / of->relative.n),
      100 * share_within(&of->relative_reliable, 0.75, 1.25));
}

static void part_estimates(bench *b) {
  static sayings all, long_runs;
  csv(&b->out, "scene,width,height,samples,passes,runs,rmse_median,rmse_low,rmse_high,rmse_within,unreliable,"
               "reliable_within,interval_held,relative_median,relative_within,relative_unreliable,"
               "relative_reliable_within\n");
  say(&b->out,
      "Estimated over true error: median over runs (in brackets the middle nine tenths of RMSE), the part of runs "
      "within 25%%, the part called unreliable, the part within 25%% of the others, and how often the true RMSE is in "
      "the interval. Sobol' points, passes x samples; pictures of 64 x 48, %d seeds.\n\n"
      "| scene | passes | RMSE | within | unreliable | within, others | interval | relative MSE | within | unreliable "
      "| "
      "within, others |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n",
      SEEDS);
  clear_sayings(&all), clear_sayings(&long_runs);
  for (unsigned k = 0; k < CHECKED_STAGES; k++) estimate_picture(b, k, SEEDS, &all, &long_runs);
  say(&b->out, "\n");
  say_sayings(b, "all", &all), say_sayings(b, "those of 64 samples", &long_runs);
  estimates_by_sampler(b);
}

static void part_targets(bench *b) {
  static ratios all[2];
  static aims a;
  static stage g;
  all[0].n = all[1].n = 0;
  csv(&b->out,
      "scene,adaptive,measure,runs,met,true_over_target_median,high,samples_mean,ended_otherwise,unreliable\n");
  say(&b->out,
      "Targets of %.2f, %.2f and %.2f times the error of the first two passes (squared for the relative MSE): the part "
      "of runs whose true error is at most 1.15 times the target, the median of true error over target, samples used. "
      "Unreliable: runs that the upper bound has ended, or the 256th pass. Pictures of 64 x 48.\n\n"
      "| scene | measure | passes | met | median | samples | unreliable |\n|---|---|---|--:|--:|--:|--:|\n",
      target_parts[0], target_parts[1], target_parts[2]);
  for (unsigned k = 0; k < CHECKED_STAGES; k++) {
    const bool drt = k >= CLOSED_SCENES;
    open_whole(b, &g, k, MIDDLE);
    for (int i = 0; i < 4; i++) {
      const bool adaptive = i % 2 != 0, relative = i / 2 != 0;
      memset(&a, 0, sizeof a);
      run_targets(&g, adaptive, relative ? PKTRT_ERROR_RELATIVE : PKTRT_ERROR_RMSE, drt ? 2u : 4u, false, &a);
      const double met = share_within(&a.met, 0, 1.15);
      const char *const words[2] = {relative ? "relative MSE" : "RMSE", adaptive ? "adaptive" : "uniform"};
      say(&b->out, "| %s | %s | %s | %.0f%% | %.2f | %.0f | %.0f%% |\n", g.name, words[0], words[1], 100 * met,
          part_of(&a.met, 0.5), a.samples / a.met.n, 100 * a.doubted / a.met.n);
      csv(&b->out, "%s,%d,%s,%u,%.4f,%.4f,%.4f,%.2f,%.0f,%.0f\n", g.name, adaptive, words[0], a.met.n, met,
          part_of(&a.met, 0.5), part_of(&a.met, 0.95), a.samples / a.met.n, a.unmet, a.doubted);
      for (unsigned run = 0; run < a.met.n; run++) add_ratio(&all[relative], a.met.value[run]);
    }
    stage_close(&g);
  }
  say(&b->out, "\nOf all runs %.1f%% meet their target on the RMSE, %.1f%% on the relative MSE.\n\n",
      100 * share_within(&all[0], 0, 1.15), 100 * share_within(&all[1], 0, 1.15));
}

/* Of adaptive passes that lower the error m, the time for it over that of uniform sets, too. */
static void effort_csv(
    const bench *b, const stage *g, const char *way, const effort *e, const effort *uniform, pktrt_error_measure m) {
  for (unsigned i = 0; i < ADAPTIVE_POINTS; i++) {
    csv(&b->out, "%s,%s,%u,%.6f,%.6g,%.6g,", g->name, way, (unsigned)(ADAPTIVE_SAMPLES * passes_at(i)), e->seconds[i],
        sqrt(fmax(0, e->error[PKTRT_ERROR_RMSE][i])), sqrt(fmax(0, e->error[PKTRT_ERROR_RELATIVE][i])));
    if (e != uniform && i >= PAID) csv(&b->out, "%.4f", time_ratio(e, uniform, m, i));
    csv(&b->out, "\n");
  }
}

static void part_adaptive(bench *b) {
  static stage g;
  csv(&b->out, "scene,way,samples,seconds,rmse,root_relative_mse,time_over_uniform\n");
  say(&b->out,
      "Time of adaptive passes over that of one uniform set for the same true error, pilot passes and estimates "
      "included, at "
      "budgets of 8 and 16 passes of %d samples; pictures of 64 x 48. Adaptive passes lower the "
      "measure that is compared.\n\n| scene | RMSE: 8 | 16 | relative MSE: 8 | 16 |\n|---|--:|--:|--:|--:|\n",
      ADAPTIVE_SAMPLES);
  for (unsigned k = 0; k < CHECKED_STAGES; k++) {
    const unsigned seeds = k < CLOSED_SCENES ? 4 : 12;
    effort e[3];
    shot ways[3];
    memset(e, 0, sizeof e);
    open_whole(b, &g, k, MIDDLE);
    three_ways(ways);
    measure_efforts(&g, ways, 3, 0, ADAPTIVE_POINTS - 1, seeds, e);
    effort_csv(b, &g, "uniform", &e[0], &e[0], PKTRT_ERROR_RMSE);
    effort_csv(b, &g, "adaptive rmse", &e[1], &e[0], PKTRT_ERROR_RMSE);
    effort_csv(b, &g, "adaptive relative", &e[2], &e[0], PKTRT_ERROR_RELATIVE);
    say(&b->out, "| %s |", g.name);
    for (int m = 0; m < 2; m++)
      for (unsigned i = PAID; i < ADAPTIVE_POINTS; i++)
        say(&b->out, " %.2f |", time_ratio(&e[1 + m], &e[0], (pktrt_error_measure)m, i));
    say(&b->out, "\n");
    stage_close(&g);
  }
  say(&b->out, "\n");
}

/* >>checks --------------------------------------------------------------------------------------------------------- */

/* Of those that c->on names: scenes with a closed form, or DRT. */
static unsigned first_stage(const claim *c) { return strcmp(c->on, "closed") ? CLOSED_SCENES : 0; }
static unsigned end_stage(const claim *c) { return strcmp(c->on, "closed") ? CHECKED_STAGES : CLOSED_SCENES; }

/* Stages stay open from check to check: to find the truth of those with a closed form takes as long as their pictures. */
static stage *checked_stage(const bench *b, unsigned k, picture size) {
  static stage kept[CHECKED_STAGES];
  stage *g = &kept[k];
  if (g->world && g->view.width != widths[size]) stage_close(g);
  if (!g->world) open_whole(b, g, k, size);
  return g;
}

/* The part of runs whose estimated RMSE is within 25% of the true one. */
static double check_estimates(bench *b, const claim *c, bool control, char details[DETAILS]) {
  static sayings said;
  const ratios *rmse = &said.rmse;
  clear_sayings(&said);
  for (unsigned k = first_stage(c); k < end_stage(c); k++) {
    const unsigned from = rmse->n;
    stage *g = checked_stage(b, k, k < CLOSED_SCENES ? SMALL : LARGE);
    for (unsigned p = 0; p < (control ? 2 : CHECKED_PLANS); p++)
      run_estimates(g, PKTRT_SAMPLER_SOBOL, p, 2, control, &said);
    unsigned within = 0;
    for (unsigned i = from; i < rmse->n; i++) within += rmse->value[i] >= 0.75 && rmse->value[i] <= 1.25;
    const size_t at = strlen(details);
    snprintf(
        details + at, DETAILS - at, "%s%s %.2f", at ? ", " : "", checked_name(k), (double)within / (rmse->n - from));
  }
  return share_within(rmse, 0.75, 1.25);
}

/* The part of runs that met their target: true RMSE at most 1.15 of it. c->number: adaptive passes. */
static double check_targets(bench *b, const claim *c, bool control, char details[DETAILS]) {
  static aims a;
  memset(&a, 0, sizeof a);
  for (unsigned k = first_stage(c); k < end_stage(c); k++) {
    const unsigned from = a.met.n;
    stage *g = checked_stage(b, k, k < CLOSED_SCENES ? SMALL : LARGE);
    run_targets(g, c->number != 0, PKTRT_ERROR_RMSE, 1, control, &a);
    unsigned met = 0;
    for (unsigned i = from; i < a.met.n; i++) met += a.met.value[i] <= 1.15;
    const size_t at = strlen(details);
    snprintf(details + at, DETAILS - at, "%s%s %.2f", at ? ", " : "", checked_name(k), (double)met / (a.met.n - from));
  }
  return share_within(&a.met, 0, 1.15);
}

/* Time of adaptive passes, the second of two efforts, for equal error over that of uniform sets, at point PAID. The sets
   have been measured at the points beside it as well. */
static double figure_contest(const void *of, resample *r) {
  const effort *e = (const effort *)of;
  double sum[2][ADAPTIVE_POINTS] = {{0}};
  for (unsigned w = 0; w < 2; w++)
    for (unsigned k = 0; k < e->seeds; k++) {
      const unsigned seed = pick(r, k, e->seeds);
      for (unsigned i = 0; i < ADAPTIVE_POINTS; i++) sum[w][i] += e[w].mse[i][seed];
    }
  const double power = falling(e[0].seconds, sum[0], ADAPTIVE_POINTS);
  return e[1].seconds[PAID] / e[0].seconds[PAID] * pow(sum[1][PAID] / sum[0][PAID], 1 / power);
}

/* Time for equal error, adaptive over uniform: of the pool hall (c->number 1), or the largest of the built-in scenes. Those with
   a closed form are smooth: one set of Sobol' points beats passes there. The control: uniform over adaptive. */
static double check_adaptive(bench *b, const claim *c, bool control, char details[DETAILS]) {
  static effort efforts[CHECKED_STAGES][2]; /* uniform, adaptive */
  double worst = 0;
  for (unsigned k = CLOSED_SCENES; k < (c->number ? CLOSED_SCENES + 1 : CHECKED_STAGES); k++) {
    effort *e = efforts[k];
    if (!e->seeds) {
      shot ways[3];
      three_ways(ways);
      measure_efforts(checked_stage(b, k, MIDDLE), ways, 1, PAID - 1, PAID - 1, 16, e);
      measure_efforts(checked_stage(b, k, MIDDLE), ways, 2, PAID, PAID, 16, e);
    }
    const interval r = bootstrap(figure_contest, e), over = {1 / r.value, 1 / r.high, 1 / r.low};
    note(details, checked_name(k), control ? over : r);
    worst = larger(worst, control ? over.value : r.value);
  }
  return worst;
}

#endif /* ERROR_ESTIMATES_H */
