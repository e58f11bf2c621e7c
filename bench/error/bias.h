/* bias.h - what ray-tree attenuation takes from pictures, an error that no number of samples lowers, and the time
   it saves.

   D is picture minus that without attenuation, of the same samples: scattered directions depend on sample and place in
   the ray tree alone, so D holds what was cut off and no other noise. Its mean is the mean bias. Its mean square would
   hold the noise of what was cut off; so the squared bias is estimated from n seeds by the mean over pixels of
   D_i D_j, i and j different, that is ((sum D)^2 - sum D^2) / (n (n - 1)), which has no bias itself and can come out
   below 0 (then 0 is told). Intervals: jackknife over seeds. */
#ifndef ERROR_BIAS_H
#define ERROR_BIAS_H

#include "error.h"
#include "scatter.h"

enum { BIAS_SEEDS = 4, BIAS_SAMPLES = 64, BIAS_WIDTH = 32, BIAS_HEIGHT = 24, BIAS_LEVELS = 5 };
/* The first is what the others are compared with. WHY not off in WRT: rays double at glass, and trees of 50 generations
   between panes have more rays than can be traced. From 1/16384 to 1/65536 pictures still get brighter by less than
   0.003%, a fiftieth at most of what is missing at 1/256. */
static const float bias_levels[2][BIAS_LEVELS] = {
    {1.0f / 65536, 1.0f / 1024, 1.0f / 256, 1.0f / 64, 1.0f / 16}, {-1, 1.0f / 1024, 1.0f / 256, 1.0f / 64, 1.0f / 16}};
static const char *const bias_names[2][BIAS_LEVELS] = {
    {"1/65536", "1/1024", "1/256", "1/64", "1/16"}, {"off", "1/1024", "1/256", "1/64", "1/16"}};

typedef struct bias {
  interval mean, rms;           /* of the difference from no attenuation */
  double noise;                 /* RMSE by chance of one picture without attenuation */
  double bright, rays, seconds; /* mean radiance; rays of a sample; of all seeds but the first */
} bias;

/* Without seed `left_out`: mean and squared bias. */
static void bias_of(const pile *p, const pile *off, unsigned left_out, double *mean, double *squared) {
  const double n = p->count - (left_out < p->count);
  double total = 0, products = 0;
  for (size_t v = 0; v < p->values; v++) {
    double sum = 0, squares = 0;
    for (unsigned i = 0; i < p->count; i++) {
      const double d = i == left_out ? 0 : (double)pile_at(p, i)[v] - (double)pile_at(off, i)[v];
      sum += d, squares += d * d;
    }
    total += sum / n, products += (sum * sum - squares) / (n * (n - 1));
  }
  *mean = total / (double)p->values, *squared = products / (double)p->values;
}

static double root_or_zero(double x) { return x > 0 ? sqrt(x) : 0; }

static void find_bias(const pile *p, const pile *off, bias *r) {
  double mean, squared, means[BIAS_SEEDS], squares[BIAS_SEEDS];
  for (unsigned i = 0; i < BIAS_SEEDS; i++) bias_of(p, off, i, &means[i], &squares[i]);
  bias_of(p, off, NOBODY, &mean, &squared);
  r->mean = jackknife(mean, means, BIAS_SEEDS);
  r->rms = jackknife(squared, squares, BIAS_SEEDS);
  r->rms.value = root_or_zero(r->rms.value), r->rms.low = root_or_zero(r->rms.low);
  r->rms.high = root_or_zero(r->rms.high);
}

static double rays_of(const pktrt_stats *s) {
  double rays = 0;
  for (int t = 0; t < PKTRT_RAY_TYPE_COUNT; t++) rays += (double)s->by_type[t].rays;
  return rays / (double)s->samples;
}

/* Levels take turns, so that none meets a quieter machine; the first seed counts rays and is not timed. */
static void measure_bias(stage *g, bias r[BIAS_LEVELS]) {
  pile p[BIAS_LEVELS];
  memset(r, 0, BIAS_LEVELS * sizeof *r);
  for (int l = 0; l < BIAS_LEVELS; l++) p[l] = pile_of(stage_pixels(g) * 3, BIAS_SEEDS);
  for (unsigned i = 0; i < BIAS_SEEDS; i++)
    for (int l = 0; l < BIAS_LEVELS; l++) {
      const shot s = shot_of(PKTRT_SAMPLER_SOBOL, BIAS_SAMPLES, 1, FIRST_SEED + i);
      pktrt_stats stats;
      memset(&stats, 0, sizeof stats);
      g->view.attenuation = bias_levels[g->view.mode == PKTRT_MODE_DRT][l];
      const double seconds = pile_render(g, &s, i ? NULL : &stats, &p[l], i);
      if (i) r[l].seconds += seconds;
      else r[l].rays = rays_of(&stats);
    }
  for (int l = 0; l < BIAS_LEVELS; l++) {
    find_bias(&p[l], &p[0], &r[l]);
    r[l].noise = sqrt(pile_variance(&p[0], NOBODY)), r[l].bright = pile_mean(&p[0]);
  }
  for (int l = 0; l < BIAS_LEVELS; l++) free(p[l].pixels);
}

static void say_bias(const bench *b, const char *name, bool drt, const bias r[BIAS_LEVELS]) {
  for (int l = 0; l < BIAS_LEVELS; l++) {
    const bias *x = &r[l];
    const double percent = 100 / x->bright;
    csv(&b->out, "%s,%s,%s,%d,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g,%.6g\n", name, drt ? "drt" : "wrt",
        bias_names[drt][l], (int)BIAS_SAMPLES, x->mean.value, x->mean.low, x->mean.high, x->rms.value, x->rms.low,
        x->rms.high, x->noise, x->bright, x->rays, x->seconds);
    if (!l) continue;
    say(&b->out, "| %s, %s | %s | %.3f (%.3f to %.3f) | %.3f (%.3f to %.3f) | %.1f | %.2f | %.0f%% | %.0f%% |\n", name,
        drt ? "DRT" : "WRT", bias_names[drt][l], percent * x->mean.value, percent * x->mean.low, percent * x->mean.high,
        percent * x->rms.value, percent * x->rms.low, percent * x->rms.high, percent * x->noise, x->rays,
        100 * (1 - x->rays / r[0].rays), 100 * (1 - x->seconds / r[0].seconds));
  }
}

static void part_bias(bench *b) {
  static stage g;
  csv(&b->out,
      "scene,mode,attenuation,samples,mean,low,high,rms,low,high,noise,mean_radiance,rays_of_sample,seconds\n");
  say(&b->out,
      "Difference from no attenuation (WRT: from 1/65536) in percent of the mean radiance, with intervals (95%%, "
      "%d seeds):\n\n",
      (int)BIAS_SEEDS);
  say(&b->out,
      "| scene | attenuation | mean | RMS | noise of %d samples | rays of a sample | rays saved | time saved |\n"
      "|---|---|--:|--:|--:|--:|--:|--:|\n",
      (int)BIAS_SAMPLES);
  for (int k = 0; k < 6; k++) {
    bias r[BIAS_LEVELS];
    const char *name = scene_names()[k / 2];
    stage_open(&g, name, k % 2 ? PKTRT_MODE_DRT : PKTRT_MODE_WRT, BIAS_WIDTH, BIAS_HEIGHT);
    measure_bias(&g, r);
    say_bias(b, name, k % 2 != 0, r);
    stage_close(&g);
  }
  say(&b->out, "\n");
}

#endif /* ERROR_BIAS_H */
