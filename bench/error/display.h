/* display.h - the error of pictures as a screen shows them: whether its estimates are the truth, and what adaptive
   passes save that lower it.

   Uniform pictures are compared in two ways: as passes, which know their error, and as one set of samples, which does
   not, and has less of it. The sRGB curve of the truth is the one by pow (see error.h), not the library's.

   Contents: estimates, time, report, checks. */
#ifndef ERROR_DISPLAY_H
#define ERROR_DISPLAY_H

#include "estimates.h"

/* >>estimates ------------------------------------------------------------------------------------------------------ */

typedef struct shown_sayings { /* estimated over true error; of those runs that call theirs reliable; by the RMSE */
  ratios all, reliable, linear;
} shown_sayings;

static void run_shown(stage *g, uint32_t samples, uint32_t passes, unsigned seeds, shown_sayings *to) {
  for (unsigned k = 0; k < seeds; k++) {
    shot s = shot_of(PKTRT_SAMPLER_SOBOL, samples, passes, FIRST_SEED + k);
    outcome o;
    s.measure = PKTRT_ERROR_DISPLAY;
    take_shot(g, &s, &o);
    const double truth = sqrt(fmax(shown_error(g), 1e-30));
    add_ratio(&to->all, o.report.display_error / truth);
    add_ratio(&to->linear, o.report.rmse / truth);
    if (!o.report.unreliable[PKTRT_ERROR_DISPLAY]) add_ratio(&to->reliable, o.report.display_error / truth);
  }
}

/* >>time ----------------------------------------------------------------------------------------------------------- */

/* Sets of 16 to 256 samples; adaptive passes of 16 samples, whose budgets are sets 2 and 3; passes of as many. */
enum { SHOWN_SETS = 5, SHOWN_FIRST = 2, SHOWN_BUDGETS = 2, SHOWN_SAMPLES = 16 };

typedef struct shown_effort { /* seconds and mean squared errors as shown, means over seeds */
  double set_seconds[SHOWN_SETS], set_error[SHOWN_SETS];
  double seconds[2][SHOWN_BUDGETS], error[2][SHOWN_BUDGETS]; /* adaptive; uniform passes */
} shown_effort;

static void add_effort(stage *g, const shot *s, unsigned seeds, double *seconds, double *error) {
  outcome o;
  take_shot(g, s, &o);
  *seconds += o.seconds / seeds;
  *error += shown_error(g) / seeds;
}

/* `measure`: what adaptive passes lower. */
static void measure_shown(stage *g, unsigned seeds, pktrt_error_measure measure, shown_effort *to) {
  memset(to, 0, sizeof *to);
  for (unsigned k = 0; k < seeds; k++) {
    for (unsigned i = 0; i < SHOWN_SETS; i++) {
      const shot s = shot_of(PKTRT_SAMPLER_SOBOL, 16u << i, 1, FIRST_SEED + k);
      add_effort(g, &s, seeds, &to->set_seconds[i], &to->set_error[i]);
    }
    for (unsigned i = 0; i < SHOWN_BUDGETS; i++)
      for (int uniform = 0; uniform < 2; uniform++) {
        shot s =
            shot_of(PKTRT_SAMPLER_SOBOL, SHOWN_SAMPLES, (16u << (SHOWN_FIRST + i)) / SHOWN_SAMPLES, FIRST_SEED + k);
        s.adaptive = !uniform;
        s.measure = measure;
        add_effort(g, &s, seeds, &to->seconds[uniform][i], &to->error[uniform][i]);
      }
  }
}

/* Returns the time of adaptive passes over that of one set with the same error. */
static double over_sets(const shown_effort *e, unsigned budget) {
  double squares[SHOWN_SETS], seconds[SHOWN_SETS];
  for (unsigned i = 0; i < SHOWN_SETS; i++) { /* log_between wants them ascending */
    squares[i] = e->set_error[SHOWN_SETS - 1 - i];
    seconds[i] = e->set_seconds[SHOWN_SETS - 1 - i];
  }
  return e->seconds[0][budget] / log_between(squares, seconds, SHOWN_SETS, e->error[0][budget]);
}

/* The same over uniform passes, whose squared error is that of one over their number. */
static double over_passes(const shown_effort *e, unsigned budget) {
  return e->seconds[0][budget] * e->error[0][budget] / (e->seconds[1][budget] * e->error[1][budget]);
}

/* >>report --------------------------------------------------------------------------------------------------------- */

static void part_display(bench *b) {
  enum { TRUTH_SEEDS = 30 };
  static stage g;
  static shown_effort efforts[CHECKED_STAGES];
  double product[SHOWN_BUDGETS] = {1, 1};

  csv(&b->out, "scene,passes,median,low,high,within,unreliable,reliable_within\n");
  say(&b->out,
      "Estimated over true error as shown: median (in brackets the middle nine tenths), the part of runs within 25%%, "
      "the "
      "part called unreliable, the part within 25%% of the others. Passes of 8 samples; pictures of 64 x 48, %d "
      "seeds.\n\n| scene | passes | estimate | within | unreliable | within, others |\n|---|--:|--:|--:|--:|--:|\n",
      TRUTH_SEEDS);
  for (unsigned k = CLOSED_SCENES; k < CHECKED_STAGES; k++) {
    open_whole(b, &g, k, MIDDLE);
    for (uint32_t passes = 2; passes <= 16; passes *= 2) {
      static shown_sayings said;
      said.all.n = said.reliable.n = said.linear.n = 0;
      run_shown(&g, 8, passes, TRUTH_SEEDS, &said);
      const double unreliable = 1 - (double)said.reliable.n / said.all.n;
      const double within = share_within(&said.all, 0.75, 1.25), others = share_within(&said.reliable, 0.75, 1.25);
      say(&b->out, "| %s | %u | %.2f (%.2f, %.2f) | %.0f%% | %.0f%% |", g.name, (unsigned)passes,
          part_of(&said.all, 0.5), part_of(&said.all, 0.05), part_of(&said.all, 0.95), 100 * within, 100 * unreliable);
      say_share(b, others);
      say(&b->out, "\n");
      csv(&b->out, "%s,%u,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f\n", g.name, (unsigned)passes, part_of(&said.all, 0.5),
          part_of(&said.all, 0.05), part_of(&said.all, 0.95), within, unreliable, others);
    }
    measure_shown(&g, 8, PKTRT_ERROR_DISPLAY, &efforts[k]);
    stage_close(&g);
  }

  say(&b->out,
      "\nTime of adaptive passes of %d samples for the same error as shown, over that of one set of samples and over "
      "that "
      "of uniform passes, with budgets of 64 and 128 samples; 8 seeds.\n\n"
      "| scene | one set: 64 | 128 | passes: 64 | 128 |\n|---|--:|--:|--:|--:|\n",
      (int)SHOWN_SAMPLES);
  for (unsigned k = CLOSED_SCENES; k < CHECKED_STAGES; k++) {
    const shown_effort *e = &efforts[k];
    for (unsigned i = 0; i < SHOWN_BUDGETS; i++) product[i] *= over_sets(e, i);
    say(&b->out, "| %s | %.2f | %.2f | %.2f | %.2f |\n", checked_name(k), over_sets(e, 0), over_sets(e, 1),
        over_passes(e, 0), over_passes(e, 1));
  }
  say(&b->out, "\nGeometric means over one set: %.2f and %.2f.\n\n", cbrt(product[0]), cbrt(product[1]));
}

/* >>checks --------------------------------------------------------------------------------------------------------- */

/* Of runs that are not called unreliable, the part whose estimate as shown is within 25% of the truth. The control:
   what the RMSE of radiance says of it. */
static double check_shown(bench *b, const claim *c, bool control, char details[DETAILS]) {
  static shown_sayings said;
  (void)c;
  said.all.n = said.reliable.n = said.linear.n = 0;
  for (unsigned k = CLOSED_SCENES; k < CHECKED_STAGES; k++)
    for (uint32_t passes = 4; passes <= 8; passes *= 2) run_shown(checked_stage(b, k, MIDDLE), 8, passes, 6, &said);
  snprintf(details, DETAILS, "%u of %u runs are called unreliable", said.all.n - said.reliable.n, said.all.n);
  return share_within(control ? &said.linear : &said.reliable, 0.75, 1.25);
}

/* Time of adaptive passes over that of one set for equal error as shown, 128 samples: the geometric mean of the DRT
   scenes, or with c->number the largest. The control: passes that lower the relative MSE. */
static double check_shown_time(bench *b, const claim *c, bool control, char details[DETAILS]) {
  static shown_effort efforts[2][CHECKED_STAGES];
  double product = 1, most = 0;
  for (unsigned k = CLOSED_SCENES; k < CHECKED_STAGES; k++) {
    shown_effort *e = &efforts[control][k];
    if (!(e->seconds[0][0] > 0))
      measure_shown(checked_stage(b, k, MIDDLE), 6, control ? PKTRT_ERROR_RELATIVE : PKTRT_ERROR_DISPLAY, e);
    const double ratio = over_sets(e, 1);
    const size_t at = strlen(details);
    snprintf(details + at, DETAILS - at, "%s%s %.2f", at ? ", " : "", checked_name(k), ratio);
    product *= ratio;
    most = larger(most, ratio);
  }
  return c->number ? most : cbrt(product);
}

#endif /* ERROR_DISPLAY_H */
