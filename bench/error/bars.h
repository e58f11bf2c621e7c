/* bars.h - how far reports can be believed from two passes on: eight small scenes and the three that are built in, by
   DRT, in pictures of 48 x 36.

     flagged   share of runs whose RMSE is called unreliable; of the others, share within 25% of the true RMSE
     held      share of runs of adaptive passes whose true RMSE lies in [rmse_low, rmse_high]
     bias      of the mean of adaptive pictures, and its standard error: the difference to uniform passes of other seeds
               would be noisier, hence the truth is what they are compared with
     spent     samples of runs with a target_error over those of an oracle, which knows the true error after each round
               and stops at the first that meets the target

   Contents: runs, uniform passes, adaptive passes, targets, report. */
#ifndef ERROR_BARS_H
#define ERROR_BARS_H

#include "error.h"
#include "small.h"

/* >>runs ----------------------------------------------------------------------------------------------------------- */

enum { BARS_WIDTH = 48, BARS_HEIGHT = 36, BARS_SEEDS = 30, BARS_SAMPLES = 4, BARS_TRUTH = 15360, BARS_LINES = 6 };
enum { BARS_BUDGET = 16, BARS_MOST = 96, BARS_AIMS = 6 }; /* of adaptive passes; passes and seeds with a target */
static const uint32_t bars_passes[BARS_LINES] = {2, 3, 4, 6, 8, 16};

typedef struct bars_run { /* what is known after each round */
  const stage *g;
  uint32_t rounds;
  double mse[BARS_MOST], passes[BARS_MOST];
  pktrt_report report[BARS_MOST];
} bars_run;

static bars_run bars_now; /* the user of all renders: tables of an environment are kept by user */

static bool bars_note(void *user, const pktrt_report *report) {
  bars_run *run = (bars_run *)user;
  double relative;
  if (run->rounds == BARS_MOST) return true;
  true_errors(run->g, &run->mse[run->rounds], &relative);
  run->passes[run->rounds] = report->samples_mean / BARS_SAMPLES;
  run->report[run->rounds++] = *report;
  return true;
}

static void bars_take(stage *g, uint32_t passes, uint32_t seed, bool adaptive, double target) {
  pktrt_render_desc d = g->view;
  bars_now.g = g;
  bars_now.rounds = 0;
  d.pixels = g->pixels;
  d.samples = BARS_SAMPLES;
  d.passes = passes;
  d.seed = seed;
  d.adaptive = adaptive;
  d.target_error = (float)target;
  d.pass = bars_note;
  d.user = &bars_now; /* no hook of an environment here reads it */
  if (pktrt_render(g->world, &d) != PKTRT_OK) fatal(pktrt_last_error(g->world));
}

/* >>uniform passes ------------------------------------------------------------------------------------------------- */

typedef struct bars_count { /* runs; those called unreliable; of the others those within 25% */
  double runs, flagged, right;
} bars_count;

static double bars_flagged(const bars_count *c) { return 100 * c->flagged / c->runs; }
static double bars_right(const bars_count *c) { return 100 * c->right / fmax(1, c->runs - c->flagged); }

static void bars_add(bars_count *to, const bars_count *from) {
  to->runs += from->runs;
  to->flagged += from->flagged;
  to->right += from->right;
}

/* Counts by number of passes; mse: means over seeds. */
static void bars_uniform(stage *g, unsigned seeds, bars_count *count, double *mse) {
  for (unsigned k = 0; k < seeds; k++) {
    bars_take(g, bars_passes[BARS_LINES - 1], FIRST_SEED + k, false, 0);
    for (unsigned i = 0; i < BARS_LINES; i++) {
      const uint32_t at = bars_passes[i] - 1;
      const double ratio = bars_now.report[at].rmse / sqrt(fmax(bars_now.mse[at], 1e-30));
      const bool flagged = bars_now.report[at].unreliable[PKTRT_ERROR_RMSE];
      count[i].runs++;
      count[i].flagged += flagged;
      count[i].right += !flagged && ratio >= 0.75 && ratio <= 1.25;
      mse[i] += bars_now.mse[at] / seeds;
    }
  }
}

/* >>adaptive passes ------------------------------------------------------------------------------------------------ */

typedef struct bars_adaptive {
  double held, bias, bias_error, mse; /* shares, and a mean over seeds */
} bars_adaptive;

static double bars_mean(const stage *g, bool truth) {
  double sum = 0;
  for (size_t i = 0; i < stage_pixels(g) * 3; i++) sum += truth ? g->truth[i] : (double)g->pixels[i];
  return sum;
}

static void bars_adapt(stage *g, unsigned seeds, bars_adaptive *to) {
  double sum = 0, squares = 0;
  memset(to, 0, sizeof *to);
  for (unsigned k = 0; k < seeds; k++) {
    bars_take(g, BARS_BUDGET, FIRST_SEED + 1000 + k, true, 0);
    const pktrt_report *r = &bars_now.report[bars_now.rounds - 1];
    const double truth = sqrt(fmax(bars_now.mse[bars_now.rounds - 1], 0)),
                 off = bars_mean(g, false) / bars_mean(g, true) - 1;
    to->held += (truth >= r->rmse_low && truth <= r->rmse_high) / (double)seeds;
    to->mse += bars_now.mse[bars_now.rounds - 1] / seeds;
    sum += off;
    squares += square(off);
  }
  to->bias = sum / seeds;
  to->bias_error = sqrt((squares / seeds - square(to->bias)) / (seeds - 1));
}

/* >>targets -------------------------------------------------------------------------------------------------------- */

typedef struct bars_spent { /* samples of runs, and those of the oracle; runs, and those within 1.3 times and a pass */
  double spent, oracle, runs, kept, met;
} bars_spent;

/* Runs whose oracle needs fewer than 16 passes do not count. */
static void bars_aim(stage *g, bool adaptive, double target, bars_spent *to) {
  for (unsigned k = 0; k < BARS_AIMS; k++) {
    double oracle = 0;
    bars_take(g, BARS_MOST, FIRST_SEED + 2000 + k, adaptive, target);
    const double spent = bars_now.passes[bars_now.rounds - 1];
    for (uint32_t i = 0; i < bars_now.rounds && oracle == 0; i++)
      if (bars_now.mse[i] <= square(target)) oracle = bars_now.passes[i];
    if (oracle == 0) oracle = spent; /* the run ended too early: the oracle would have spent more */
    if (oracle < 16) continue;
    to->runs++;
    to->spent += spent;
    to->oracle += oracle;
    to->kept += spent <= 1.3 * oracle + 1;
    to->met += bars_now.mse[bars_now.rounds - 1] <= square(1.15 * target);
  }
}

/* >>report --------------------------------------------------------------------------------------------------------- */

static void bars_say_spent(const bench *b, const bars_spent *s) {
  if (s->runs > 0)
    say(&b->out, " %.2f (%.0f%%, %.0f%%) |", s->spent / s->oracle, 100 * s->kept / s->runs, 100 * s->met / s->runs);
  else say(&b->out, " - |");
}

typedef struct bars_sums { /* over scenes */
  bars_count count[BARS_LINES];
  bars_spent spent[2]; /* uniform, adaptive */
  double held, least, worst;
} bars_sums;

static void bars_add_spent(bars_spent *to, const bars_spent *from) {
  to->spent += from->spent;
  to->oracle += from->oracle;
  to->runs += from->runs;
  to->kept += from->kept;
  to->met += from->met;
}

/* A line of the table. */
static void bars_scene(bench *b, stage *g, bars_sums *all) {
  bars_count count[BARS_LINES];
  bars_adaptive a;
  double mse[BARS_LINES] = {0};
  memset(count, 0, sizeof count);

  bars_uniform(g, BARS_SEEDS, count, mse);
  say(&b->out, "| %s |", g->name);
  for (unsigned i = 0; i < BARS_LINES; i++) {
    say(&b->out, " %.0f%% (%.0f%%) |", bars_flagged(&count[i]), bars_right(&count[i]));
    bars_add(&all->count[i], &count[i]);
  }

  bars_adapt(g, BARS_SEEDS, &a);
  say(&b->out, " %.0f%% | %.2f (%.2f) | %.2f |", 100 * a.held, 100 * a.bias, 100 * a.bias_error,
      a.mse / mse[BARS_LINES - 1]);
  all->held += a.held / SMALL_SCENES;
  all->least = fmin(all->least, a.held);
  all->worst = fmax(all->worst, fabs(a.bias));

  for (int adaptive = 0; adaptive < 2; adaptive++) {
    const double target = adaptive ? a.mse : mse[BARS_LINES - 1] * 16 / 20;
    bars_spent s = {0, 0, 0, 0, 0};
    bars_aim(g, adaptive != 0, sqrt(fmax(target, 0)), &s);
    bars_say_spent(b, &s);
    bars_add_spent(&all->spent[adaptive], &s);
  }
  say(&b->out, "\n");
  fflush(stdout);
}

static void bars_say_all(bench *b, const bars_sums *all) {
  bars_count few = {0, 0, 0}, every = {0, 0, 0};
  say(&b->out, "| all |");
  for (unsigned i = 0; i < BARS_LINES; i++) {
    say(&b->out, " %.0f%% (%.1f%%) |", bars_flagged(&all->count[i]), bars_right(&all->count[i]));
    if (bars_passes[i] < 8) bars_add(&few, &all->count[i]);
    bars_add(&every, &all->count[i]);
  }
  say(&b->out, " %.1f%%, least %.0f%% | largest %.2f | |", 100 * all->held, 100 * all->least, 100 * all->worst);
  for (int i = 0; i < 2; i++) bars_say_spent(b, &all->spent[i]);
  say(&b->out,
      "\n\nOf all runs with 2 to 6 passes %.1f%% are called unreliable, of the others %.1f%% are within 25%%; with 2 "
      "to "
      "16 passes %.1f%%, %.1f%%.\n\n",
      bars_flagged(&few), bars_right(&few), bars_flagged(&every), bars_right(&every));
}

static void part_bars(bench *b) {
  static stage g;
  bars_sums all;
  memset(&all, 0, sizeof all);
  all.least = 1;
  say(&b->out,
      "Runs called unreliable, and in brackets those within 25%% of the true RMSE among the others, after 2 to 16 "
      "passes of %d samples; pictures of %d x %d, %d seeds. Of %d adaptive passes: true RMSE in the interval; bias of "
      "the mean and its standard error in percent; MSE over that of uniform passes. Targets that uniform passes reach "
      "after 20 and adaptive ones after 16: samples over those of an oracle (runs within 1.3 times and a pass; runs "
      "within 1.15 of the target).\n\n| scene |",
      (int)BARS_SAMPLES, (int)BARS_WIDTH, (int)BARS_HEIGHT, (int)BARS_SEEDS, (int)BARS_BUDGET);
  for (unsigned i = 0; i < BARS_LINES; i++) say(&b->out, " %u |", (unsigned)bars_passes[i]);
  say(&b->out, " held | bias | MSE | uniform target | adaptive target |\n|---|");
  for (unsigned i = 0; i < BARS_LINES + 5; i++) say(&b->out, "--:|");
  say(&b->out, "\n");

  for (unsigned k = 0; k < SMALL_SCENES; k++) {
    small_open(&g, k, BARS_WIDTH, BARS_HEIGHT);
    stage_reference(b, &g, BARS_TRUTH);
    g.view.user = &bars_now;
    if (g.view.environment && pktrt_prepare_environment(g.world, &g.view) != PKTRT_OK) fatal("no table of the sky");
    bars_scene(b, &g, &all);
    stage_close(&g);
  }
  bars_say_all(b, &all);
}

#endif /* ERROR_BARS_H */
