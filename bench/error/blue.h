/* blue.h - how much of the error is left after a small blur, as by an eye at a distance: where neighbouring
   pixels err in opposite ways (blue noise), less than of errors that know nothing of each other.

   The error picture, picture minus truth, is blurred by a Gaussian, cut off at three sigmas; its root mean square is
   taken over the pixels whose blur lies within the picture, the same for all sigmas. Where there is no truth the mean
   of all n seeds' pictures stands for it, and squares are multiplied by n / (n - 1): samplers have no bias, so the
   scatter of seeds is the error. Ratios are of seeds in pairs. */
#ifndef ERROR_BLUE_H
#define ERROR_BLUE_H

#include "error.h"
#include "flicker.h"
#include "scatter.h"

enum { BLUE_SEEDS = 8, BLUE_SIGMAS = 3, BLUE_REACH = 6, BLUE_WAYS = 5, BLUE_SIZE = 96, BLUE_SCENE_SIZE = 64 };
static const struct { uint32_t samples, passes; } blue_ways[BLUE_WAYS] = {{1, 1}, {4, 1}, {16, 1}, {1, 4}, {4, 4}};

typedef struct blue {
  double mse[BLUE_WAYS][PKTRT_SAMPLER_COUNT][BLUE_SIGMAS][BLUE_SEEDS];
} blue;

/* Weights of pixels -6 ... 6 in one dimension; sigma 0: of the middle alone. */
static void gaussian(double sigma, double weight[2 * BLUE_REACH + 1]) {
  double sum = 0;
  for (int i = -BLUE_REACH; i <= BLUE_REACH; i++) {
    const double x = i, w = sigma > 0 ? (fabs(x) <= 3 * sigma ? exp(-x * x / (2 * sigma * sigma)) : 0) : i == 0;
    weight[i + BLUE_REACH] = w, sum += w;
  }
  for (int i = 0; i <= 2 * BLUE_REACH; i++) weight[i] /= sum;
}

/* Both ways, one channel of `step`; what is too near the edge is not written. */
static void blur(const double *from, double *to, size_t w, size_t h, size_t step, const double *weight, double *rows) {
  const size_t r = BLUE_REACH;
  for (size_t y = 0; y < h; y++)
    for (size_t x = r; x + r < w; x++) {
      double sum = 0;
      for (size_t i = 0; i <= 2 * r; i++) sum += weight[i] * from[(y * w + x + i - r) * step];
      rows[y * w + x] = sum;
    }
  for (size_t y = r; y + r < h; y++)
    for (size_t x = r; x + r < w; x++) {
      double sum = 0;
      for (size_t i = 0; i <= 2 * r; i++) sum += weight[i] * rows[(y + i - r) * w + x];
      to[y * w + x] = sum;
    }
}

/* Mean over the inner pixels of squares. */
static double inner_mean(const double *values, size_t w, size_t h) {
  const size_t r = BLUE_REACH;
  double sum = 0;
  for (size_t y = r; y + r < h; y++)
    for (size_t x = r; x + r < w; x++) sum += square(values[y * w + x]);
  return sum / (double)((w - 2 * r) * (h - 2 * r));
}

/* The mean squared error of a picture after each blur. */
static void blurred_errors(const stage *g, const float *pixels, const double *truth, int how, double mse[BLUE_SIGMAS]) {
  const size_t w = g->view.width, h = g->view.height, n = w * h;
  double *off = (double *)calloc(n * 5, sizeof(double)), *out = off + n * 3, *rows = off + n * 4;
  if (!off) fatal("not enough memory");
  for (size_t v = 0; v < n * 3; v++) off[v] = shown(pixels[v], how) - truth[v];
  for (int s = 0; s < BLUE_SIGMAS; s++) {
    double weight[2 * BLUE_REACH + 1];
    gaussian(s, weight);
    mse[s] = 0;
    for (size_t c = 0; c < 3; c++) {
      blur(off + c, out, w, h, 3, weight, rows);
      mse[s] += inner_mean(out, w, h) / 3;
    }
  }
  free(off);
}

static void mean_picture(const pile *p, int how, double *mean) {
  for (size_t v = 0; v < p->values; v++) {
    mean[v] = 0;
    for (unsigned i = 0; i < p->count; i++) mean[v] += shown(pile_at(p, i)[v], how) / p->count;
  }
}

/* `known`: the stage has a truth (of radiance; on a screen there is none). */
static void measure_blue(stage *g, bool known, blue r[SHOWN]) {
  const pile p = pile_of(stage_pixels(g) * 3, BLUE_SEEDS);
  double *mean = (double *)calloc(p.values, sizeof(double));
  if (!mean) fatal("not enough memory");
  for (int way = 0; way < BLUE_WAYS; way++)
    for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
      for (unsigned i = 0; i < BLUE_SEEDS; i++) {
        const uint32_t n = blue_ways[way].samples, passes = blue_ways[way].passes;
        const shot s = shot_of((pktrt_sampler)sampler, n, passes, FIRST_SEED + 1000 * i);
        pile_render(g, &s, NULL, &p, i);
      }
      for (int how = 0; how < SHOWN; how++) {
        const bool truth = known && how == RADIANCE;
        const double share = truth ? 1 : (double)BLUE_SEEDS / (BLUE_SEEDS - 1);
        if (!truth) mean_picture(&p, how, mean);
        for (unsigned i = 0; i < BLUE_SEEDS; i++) {
          double mse[BLUE_SIGMAS];
          blurred_errors(g, pile_at(&p, i), truth ? g->truth : mean, how, mse);
          for (int k = 0; k < BLUE_SIGMAS; k++) r[how].mse[way][sampler][k][i] = share * mse[k];
        }
      }
    }
  free(mean), free(p.pixels);
}

/* Root of the ratio of the mean squared errors of two samplers, or blurs. */
static interval root_ratio(const double *a, const double *b, unsigned seeds) {
  double all = 0, without[MAX_SEEDS];
  for (unsigned left_out = 0; left_out <= seeds; left_out++) {
    double above = 0, below = 0;
    for (unsigned i = 0; i < seeds; i++)
      if (i != left_out) above += a[i], below += b[i];
    const double ratio = sqrt(fmax(above, 0) / below);
    if (left_out < seeds) without[left_out] = ratio;
    else all = ratio;
  }
  return jackknife(all, without, seeds);
}

static void csv_blue(const bench *b, const char *name, int how, const blue *r) {
  for (int way = 0; way < BLUE_WAYS; way++)
    for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++)
      for (int k = 0; k < BLUE_SIGMAS; k++) {
        const double *mse = r->mse[way][s][k];
        const interval root = rmse_of(mse, BLUE_SEEDS);
        const interval random = root_ratio(mse, r->mse[way][PKTRT_SAMPLER_RANDOM][k], BLUE_SEEDS);
        const interval sobol = root_ratio(mse, r->mse[way][PKTRT_SAMPLER_SOBOL][k], BLUE_SEEDS);
        csv(&b->out, "%s,%s,%s,%u,%u,%d,%.6g,%.6g,%.6g,%.4f,%.4f,%.4f,%.4f,%.4f,%.4f\n", name,
            how == SCREEN ? "screen" : "radiance", pktrt_sampler_string((pktrt_sampler)s),
            (unsigned)blue_ways[way].samples, (unsigned)blue_ways[way].passes, k, root.value, root.low, root.high,
            random.value, random.low, random.high, sobol.value, sobol.low, sobol.high);
      }
}

/* Lines of one stage: RMSE over that of random at sigmas 0, 1 and 2. */
static void say_blue(const bench *b, const char *name, const blue *r) {
  double widest = 0;
  say(&b->out, "%s:\n\n", name);
  say_samplers(b, "| samples |");
  say(&b->out, "|---|--:|--:|--:|--:|--:|--:|--:|\n");
  for (int way = 0; way < BLUE_WAYS; way++) {
    const unsigned n = blue_ways[way].samples, passes = blue_ways[way].passes;
    if (passes > 1) say(&b->out, "| %u in %u passes |", n * passes, passes);
    else say(&b->out, "| %u |", n);
    for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++)
      for (int k = 0; k < BLUE_SIGMAS; k++) {
        const interval x = root_ratio(r->mse[way][s][k], r->mse[way][PKTRT_SAMPLER_RANDOM][k], BLUE_SEEDS);
        widest = fmax(widest, x.high - x.value);
        say(&b->out, "%s%.2f%s", k ? ", " : " ", x.value, k + 1 < BLUE_SIGMAS ? "" : " |");
      }
    say(&b->out, "\n");
  }
  say(&b->out,
      "\nNo interval (95%%, %d seeds) is wider than +- %.2f. Blue noise over sobol, at sigma 2:", (int)BLUE_SEEDS,
      widest);
  for (int way = 0; way < BLUE_WAYS; way++) {
    const double *blue_mse = r->mse[way][PKTRT_SAMPLER_BLUE_NOISE][2], *sobol_mse = r->mse[way][PKTRT_SAMPLER_SOBOL][2];
    const interval x = root_ratio(blue_mse, sobol_mse, BLUE_SEEDS);
    const unsigned passes = blue_ways[way].passes;
    say(&b->out, "%s %.2f (%.2f to %.2f) with %u", way ? "," : "", x.value, x.low, x.high,
        blue_ways[way].samples * passes);
    if (passes > 1) say(&b->out, " in %u passes", passes);
  }
  say(&b->out, ".\n\n");
}

static void part_blue(bench *b) {
  static blue r[SHOWN];
  static stage g;
  say(&b->out, "RMSE over that of independent random samples, unblurred, and after blurs of sigma 1 and 2 pixels. ");
  csv(&b->out,
      "scene,shown,sampler,samples_of_pass,passes,sigma,rmse,low,high,over_random,low,high,over_sobol,low,high\n");
  open_soft_shadow(&g, BLUE_SIZE);
  measure_blue(&g, true, r);
  csv_blue(b, g.name, RADIANCE, &r[RADIANCE]), say_blue(b, "Soft shadow (the truth in closed form)", &r[RADIANCE]);
  printf("The truth's quadrature is off by %.1g, the least RMSE is %.2g.\n\n", soft_quadrature(&g),
      rmse_of(r[RADIANCE].mse[2][PKTRT_SAMPLER_BLUE_NOISE][2], BLUE_SEEDS).value);
  stage_close(&g);
  stage_open(&g, "rtrt", PKTRT_MODE_DRT, BLUE_SCENE_SIZE, BLUE_SCENE_SIZE);
  measure_blue(&g, false, r);
  for (int how = 0; how < SHOWN; how++) {
    csv_blue(b, g.name, how, &r[how]);
    say_blue(
        b, how == SCREEN ? "The same on a screen, where what is brighter than 1 is white" : "Scene rtrt, DRT", &r[how]);
  }
  stage_close(&g);
}

#endif /* ERROR_BLUE_H */
