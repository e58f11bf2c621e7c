/* split.h - what splitting costs: N samples in R passes of N / R, which is what estimates need, against one set
   of N. Errors are the scatter of seeds (samplers have no bias), ratios have a jackknife's interval over seeds.
   Pictures of scenes are taken as a screen shows them, clipped at 1: else a few glints decide, and intervals say
   nothing. */
#ifndef ERROR_SPLIT_H
#define ERROR_SPLIT_H

#include "error.h"
#include "scatter.h"

enum { SPLIT_SEEDS = 6, SPLIT_NS = 3, SPLIT_RS = 4, SPLIT_SIZE = 24 };
static const uint32_t split_n[SPLIT_NS] = {16, 64, 256}, split_r[SPLIT_RS] = {1, 2, 4, 8};

typedef struct split {
  double rmse; /* of one set */
  interval ratio[SPLIT_RS];
} split;

static void measure_split(const stage *g, pktrt_sampler sampler, uint32_t n, split *to) {
  const pile p = pile_of(stage_pixels(g) * 3, SPLIT_SEEDS);
  double one[SPLIT_SEEDS + 1], ratio[SPLIT_SEEDS + 1]; /* without each of the seeds, and of all */
  for (int k = 0; k < SPLIT_RS; k++) {
    for (unsigned i = 0; i < SPLIT_SEEDS; i++) {
      const shot s = shot_of(sampler, n / split_r[k], split_r[k], FIRST_SEED + 1000 * i);
      pile_render(g, &s, NULL, &p, i);
    }
    for (size_t v = 0; g->built_in && v < p.values * p.count; v++) p.pixels[v] = fminf(p.pixels[v], 1);
    for (unsigned i = 0; i <= SPLIT_SEEDS; i++) {
      const double rmse = sqrt(pile_variance(&p, i < SPLIT_SEEDS ? i : (unsigned)NOBODY));
      if (!k) one[i] = rmse;
      ratio[i] = rmse / one[i];
    }
    to->ratio[k] = jackknife(ratio[SPLIT_SEEDS], ratio, SPLIT_SEEDS);
  }
  to->rmse = one[SPLIT_SEEDS];
  free(p.pixels);
}

/* The ratios of 2, 4 and 8 passes. Returns half of the widest interval. */
static double say_split(const bench *b, const stage *g, pktrt_sampler sampler, uint32_t n) {
  double widest = 0;
  split r;
  measure_split(g, sampler, n, &r);
  for (int k = 1; k < SPLIT_RS; k++) {
    const interval *x = &r.ratio[k];
    csv(&b->out, "%s,%s,%u,%u,%.6g,%.4f,%.4f,%.4f\n", g->name, pktrt_sampler_string(sampler), (unsigned)n,
        (unsigned)split_r[k], r.rmse, x->value, x->low, x->high);
    say(&b->out, "%s%.2f%s", k > 1 ? ", " : " ", x->value, k + 1 < SPLIT_RS ? "" : " |");
    widest = fmax(widest, x->high - x->value);
  }
  return widest;
}

/* Lines of a stage. Time is short: scenes have no 256 samples, and only some samplers at 64. */
static void say_splits(const bench *b, const stage *g) {
  for (int n = 0; n < SPLIT_NS && !(g->built_in && split_n[n] > 64); n++) {
    double widest = 0;
    say(&b->out, "| %s | %u |", g->name, (unsigned)split_n[n]);
    for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++)
      if (g->built_in && split_n[n] > 16 && s > PKTRT_SAMPLER_RANDOM && s != PKTRT_SAMPLER_BLUE_NOISE)
        say(&b->out, " |");
      else widest = fmax(widest, say_split(b, g, (pktrt_sampler)s, split_n[n]));
    say(&b->out, " %.2f |\n", widest);
  }
}

static void part_split(bench *b) {
  static stage g;
  csv(&b->out, "scene,sampler,samples,passes,rmse_of_one_set,ratio,low,high\n");
  say(&b->out,
      "RMSE of N samples in 2, 4 and 8 passes over that of one set; the last column: half of the widest interval of "
      "a line (95%%, %d seeds):\n\n",
      (int)SPLIT_SEEDS);
  say(&b->out, "| | N |");
  for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) say(&b->out, " %s |", pktrt_sampler_string((pktrt_sampler)s));
  say(&b->out, " +- |\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  open_soft_shadow(&g, SPLIT_SIZE);
  say_splits(b, &g);
  stage_close(&g);
  for (int k = 0; k < 3; k++) {
    stage_open(&g, scene_names()[k], PKTRT_MODE_DRT, SPLIT_SIZE, SPLIT_SIZE);
    say_splits(b, &g);
    stage_close(&g);
  }
  say(&b->out, "\n");
}

#endif /* ERROR_SPLIT_H */
