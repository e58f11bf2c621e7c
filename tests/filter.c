/* examples/filter.h: what it takes out of noise whose size is known, and what it must leave. */
#include "test.h"
#include "../examples/filter.h"

enum { WIDE = 75, HIGH = 50, PIXELS = WIDE * HIGH };

typedef struct noisy { /* a picture of two halves, on one plane */
  float half[2][PIXELS * 3], variance[PIXELS], depth[PIXELS], normal[PIXELS * 3], albedo[PIXELS * 3];
  float out[PIXELS * 3], error[PIXELS];
} noisy;

/* Sums twelve uniform numbers: nearly Gaussian, of variance 1. */
static float gaussian(rng *r) {
  float sum = -6;
  for (int i = 0; i < 12; i++) sum += rng_unit(r);
  return sum;
}

/* Makes a picture that is 1 on the left and 1 + step on the right; each half's channels have standard error sigma. */
static filter_picture make_noisy(noisy *n, float step, float sigma) {
  rng r = rng_of(31);
  filter_picture p;
  memset(n, 0, sizeof *n), memset(&p, 0, sizeof p);
  for (int i = 0; i < PIXELS; i++) {
    n->depth[i] = 3, n->normal[3 * i] = 1;
    for (int c = 0; c < 3; c++) n->albedo[3 * i + c] = 0.5f;
    n->variance[i] = 3 * sigma * sigma;
    for (int k = 0; k < 2; k++) {
      for (int c = 0; c < 3; c++)
        n->half[k][3 * i + c] = 1 + (i % WIDE >= WIDE / 2 ? step : 0) + (sigma > 0 ? sigma * gaussian(&r) : 0);
    }
  }
  p.width = WIDE, p.height = HIGH, p.depth = n->depth, p.normal = n->normal, p.albedo = n->albedo;
  p.half[0] = n->half[0], p.half[1] = n->half[1], p.variance = n->variance;
  return p;
}

/* The mean squared error of a channel against that truth, in the columns [from, to): of the mean of halves, filtered. */
static double error_in(const noisy *n, float step, int from, int to, bool filtered) {
  double sum = 0;
  for (int i = 0; i < PIXELS; i++)
    for (int c = 0; c < 3 && i % WIDE >= from && i % WIDE < to; c++) {
      const int at = 3 * i + c;
      const double x = filtered ? (double)n->out[at] : 0.5 * ((double)n->half[0][at] + (double)n->half[1][at]);
      const double d = x - 1 - (i % WIDE >= WIDE / 2 ? (double)step : 0);
      sum += d * d;
    }
  return sum / (3.0 * HIGH * (to - from));
}

static void constant_picture(void) {
  static noisy n;
  const filter_picture p = make_noisy(&n, 0, 0.2f);
  double estimate = 0;
  CHECK(filter_rectangle(&p, 0, 0, WIDE, HIGH, n.out, n.error));
  for (int i = 0; i < PIXELS; i++) estimate += (double)n.error[i] / (3.0 * PIXELS);
  const double before = error_in(&n, 0, 0, WIDE, false), after = error_in(&n, 0, 0, WIDE, true);
  say("squared error %.5f, filtered %.6f, estimated %.6f", before, after, estimate);
  CHECK(fabs(before - 0.02) < 0.001, "%g is not the noise that was meant", before);
  CHECK(after < before / 50 && after > before / 500, "%g of %g: not the mean of some 150 pixels", after, before);
  CHECK(fabs(estimate - after) < 0.02 * before, "estimated %g, is %g", estimate, after);
}

/* The control: where noise is told to be as large as the edge, it is not kept. */
static void edges(void) {
  static noisy n;
  const float sigma = 0.1f, step = 1; /* the standard error of the mean is 0.07: an edge of 14, of a half of 10 */
  const int middle = WIDE / 2;
  filter_picture p = make_noisy(&n, step, sigma);
  CHECK(filter_rectangle(&p, 0, 0, WIDE, HIGH, n.out, NULL));
  const double beside = error_in(&n, step, middle - 2, middle + 2, true);
  CHECK(beside < error_in(&n, step, middle - 2, middle + 2, false), "beside the edge %g", beside);
  for (int i = 0; i < PIXELS; i++) n.variance[i] = 3 * step * step;
  CHECK(filter_rectangle(&p, 0, 0, WIDE, HIGH, n.out, NULL));
  CHECK(error_in(&n, step, middle - 2, middle + 2, true) > 4 * beside, "an edge as small as the noise is kept");
}

static void features(void) {
  static noisy n;
  const filter_picture p = make_noisy(&n, 0, 0.2f);
  double sum[2];
  for (int bumpy = 0; bumpy < 2; bumpy++) { /* each pixel has a depth of its own */
    float depth = 1;
    for (int i = 0; i < PIXELS && bumpy; i++) n.depth[i] = depth, depth = depth < 1e9f ? 2 * depth : 1;
    CHECK(filter_rectangle(&p, 0, 0, WIDE, HIGH, n.out, NULL));
    sum[bumpy] = error_in(&n, 0, 0, WIDE, true);
  }
  CHECK(sum[1] > 5 * sum[0], "where depths differ %g, else %g", sum[1], sum[0]);
}

static void no_variance(void) {
  static noisy n;
  rng r = rng_of(7);
  const filter_picture p = make_noisy(&n, 0.25f, 0);
  for (int i = 0; i < PIXELS * 3; i++) n.half[0][i] = n.half[1][i] = rng_unit(&r);
  CHECK(filter_rectangle(&p, 0, 0, WIDE, HIGH, n.out, n.error));
  CHECK(same_bits(n.out, n.half[0], sizeof n.out), "what has no noise is changed");
  for (int i = 0; i < PIXELS; i++) n.variance[i] = 0.2f;
  for (int i = 0; i < PIXELS * 3; i++) n.half[1][i] = rng_unit(&r);
  CHECK(filter_rectangle(&p, 0, 0, WIDE, HIGH, n.out, n.error));
  bool same = true;
  for (int i = 0; i < PIXELS * 3; i++) same = same && n.out[i] == 0.5f * (n.half[0][i] + n.half[1][i]);
  CHECK(!same, "what has noise is not changed");
}

static void tiles(void) {
  static noisy n;
  static float whole[PIXELS * 3], errors[PIXELS];
  const filter_picture p = make_noisy(&n, 0.3f, 0.2f);
  CHECK(filter_rectangle(&p, 0, 0, WIDE, HIGH, whole, errors));
  for (uint32_t edge = 7; edge < 80; edge += 25) {
    memset(n.out, 0, sizeof n.out), memset(n.error, 0, sizeof n.error);
    for (uint32_t y = 0; y < HIGH; y += edge)
      for (uint32_t x = 0; x < WIDE; x += edge)
        CHECK(filter_rectangle(
            &p, x, y, WIDE - x < edge ? WIDE - x : edge, HIGH - y < edge ? HIGH - y : edge, n.out, n.error));
    CHECK(same_bits(whole, n.out, sizeof whole) && same_bits(errors, n.error, sizeof errors), "tiles of %u",
        (unsigned)edge);
  }
  n.half[0][3 * (WIDE + 1)] += 0.01f; /* the control: what a pixel is, others see */
  CHECK(filter_rectangle(&p, 3, 1, 1, 1, n.out, n.error));
  CHECK(!same_bits(whole + 3 * (WIDE + 3), n.out + 3 * (WIDE + 3), 12), "a pixel's neighbour does not count");
}

/* A pixel that is a hundred times as bright in one half. The control: it is in both. */
static void fireflies(void) {
  static noisy n;
  const filter_picture p = make_noisy(&n, 0, 0.05f);
  const int at = 20 * WIDE + 30;
  for (int both = 0; both < 2; both++) {
    for (int c = 0; c < 3; c++)
      for (int k = 0; k <= both; k++) n.half[k][3 * at + c] = 100;
    n.variance[at] = both ? 3 * 0.05f * 0.05f : 1.5f * 99 * 99;
    CHECK(filter_rectangle(&p, 0, 0, WIDE, HIGH, n.out, n.error));
    const float left = n.out[3 * at];
    if (both) CHECK(left > 90, "what both halves have has become %g", (double)left);
    else CHECK(fabsf(left - 1) < 0.1f, "a firefly has become %g", (double)left);
    CHECK(fabsf(n.out[3 * (at + 1)] - 1) < 0.1f, "its neighbour %g", (double)n.out[3 * (at + 1)]);
  }
}

/* Noise of all pixels, and the control: of one. */
static void belief(void) {
  static noisy n;
  const filter_picture p = make_noisy(&n, 0, 0.2f);
  CHECK(filter_rectangle(&p, 0, 0, WIDE, HIGH, n.out, n.error));
  for (int i = 0; i < PIXELS; i++) n.error[i] = 0.01f;
  CHECK(!filter_unreliable(&p, n.error), "what all pixels carry is called unreliable");
  n.variance[7] = 1e6f;
  CHECK(filter_unreliable(&p, n.error), "what one pixel carries is believed");
}

/* Features of passes go to halves by turns, too. */
static void half_features(void) {
  static const float depth[4] = {2, 4, 6, 8};
  filter_halves h;
  filter_picture p;
  float sum = 0;
  if (!CHECK(filter_begin(&h, 1, 1))) return;
  for (int k = 0; k < 4; k++) {
    const float black[3] = {0, 0, 0};
    sum += depth[k];
    const float mean = sum / (float)(k + 1), normal[3] = {0, mean, 0}, albedo[3] = {0, 0, 1};
    filter_add_pass(&h, black);
    if (k == 3) CHECK(filter_finish(&h, &p) && !p.features[0], "features of three passes are those of four");
    filter_add_features(&h, &mean, normal, albedo);
  }
  CHECK(filter_finish(&h, &p) && p.features[0] && p.features[1]);
  CHECK(fabsf(p.features[0][0] - 4) < 1e-5f && fabsf(p.features[1][0] - 6) < 1e-5f);
  CHECK(fabsf(p.features[0][2] - 4) < 1e-5f && fabsf(p.features[1][2] - 6) < 1e-5f);
  CHECK(fabsf(p.features[0][6] - 1) < 1e-6f && fabsf(p.features[1][6] - 1) < 1e-6f);
  filter_end(&h);
}

/* Sets what eight passes see of lights that one sample in seven meets before nothing: depths are means over the samples
   that met a light, as pktrt_render has them. */
static bool gather_rare_lights(filter_halves *h, noisy *n) {
  static uint32_t met[PIXELS];
  rng r = rng_of(11);
  if (!filter_begin(h, WIDE, HIGH)) return false;
  memset(n, 0, sizeof *n);
  memset(met, 0, sizeof met);
  for (int pass = 1; pass <= 8; pass++) {
    for (int i = 0; i < PIXELS; i++) {
      met[i] += rng_unit(&r) < 1.0f / 7;
      const float part = (float)met[i] / (float)pass;
      for (int c = 0; c < 3; c++) n->out[3 * i + c] = 7 * part;
      n->normal[3 * i] = part;
      n->depth[i] = met[i] ? 16 : INFINITY;
    }
    filter_add_pass(h, n->out);
    filter_add_features(h, n->depth, n->normal, n->albedo);
  }
  return true;
}

/* The truth is 1 everywhere. Where depths told each half what the other half met, three times as much error was left. */
static void rare_lights(void) {
  static noisy n;
  filter_halves h;
  filter_picture p;
  if (!CHECK(gather_rare_lights(&h, &n) && filter_finish(&h, &p))) return;
  p.depth = n.depth;
  p.normal = n.normal;
  p.albedo = n.albedo;
  CHECK(filter_rectangle(&p, 0, 0, WIDE, HIGH, n.out, n.error));
  const double after = error_in(&n, 0, 0, WIDE, true), before = 6.0 / 8; /* 49 (1 / 7) (6 / 7) a pass */
  say("squared error %.3f, filtered %.4f", before, after);
  CHECK(after < 0.06 * before, "%g of %g is left", after, before);
  filter_end(&h);
}

/* Passes of which each is known: halves are means of every other one. */
static void halves(void) {
  static const float colour[4] = {1, 4, 3, 8};
  filter_halves h;
  filter_picture p;
  float sum = 0;
  if (!CHECK(filter_begin(&h, 1, 1))) return;
  for (int k = 0; k < 4; k++) {
    sum += colour[k];
    const float mean[3] = {sum / (float)(k + 1), 0, 0};
    CHECK(filter_finish(&h, &p) == (k >= 2), "after %d passes", k);
    filter_add_pass(&h, mean);
  }
  CHECK(filter_finish(&h, &p));
  CHECK(fabsf(p.half[0][0] - 2) < 1e-6f && fabsf(p.half[1][0] - 6) < 1e-6f, "%g %g", (double)p.half[0][0],
      (double)p.half[1][0]);
  CHECK(fabsf(p.variance[0] - 13.0f / 3) < 1e-5f, "%g", (double)p.variance[0]); /* (9 + 0 + 1 + 16) / 3 / 2 */
  filter_end(&h);
}

void suite_filter(void) {
  run("a filtered picture of one colour has as little of its noise as the mean of so many pixels", constant_picture);
  run("a filter keeps an edge of ten standard errors, and no edge below one", edges);
  run("a filter leaves pixels apart whose features differ", features);
  run("a filter leaves what has no variance bit for bit", no_variance);
  run("a filtered picture has the same bits whatever the tiles", tiles);
  run("a firefly becomes what its neighbours say, and nothing that both halves have does", fireflies);
  run("a filter does not believe an estimate that few pixels carry", belief);
  run("the halves of a filter have features of their own", half_features);
  run("a filter takes out the noise of lights that few samples meet before nothing", rare_lights);
  run("the halves of a filter are every other pass, with their variances", halves);
}
