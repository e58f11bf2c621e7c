/* slopes.h - how fast the samplers' errors fall with their number of samples, on integrands over the unit cube
   whose integrals are known.

   Every pixel of every seed has a draw of its own of each family, the same for all samplers and numbers of samples, so
   that no orientation is a matter of luck. A seed's error is the root mean square over its pixels; the slope is that of
   least squares through log RMSE over log N.

   Smooth families (after Genz 1984): exp(a.x), cos(2 pi w + a.x), prod exp(-a_i^2 (x_i - w_i)^2), with a_i in [1/2, 2].
   Steps: 1 inside, 0 outside of an interval, half-plane, disc or triangle, half-space or ball; boxes with a corner in
   the origin stand apart, for their faces lie as the samplers' strata do.

   Contents: families, measuring, report, checks. */
#ifndef ERROR_SLOPES_H
#define ERROR_SLOPES_H

#include "error.h"

/* >>families ------------------------------------------------------------------------------------------------------- */

typedef struct integrand { /* a draw of a family */
  double a[4], w[4], c;    /* factors or normal, place, offset or radius */
  double exact;
} integrand;

typedef struct family {
  const char *name;
  enum { SMOOTH, STEP, BOX } kind;
  unsigned dimensions;
  void (*draw)(integrand *, unsigned dimensions, uint32_t *state);
  double (*value)(const integrand *, unsigned dimensions, const float *x);
} family;

static double uniform(uint32_t *state, double low, double high) {
  return low + (high - low) * ((double)next_random(state) + 0.5) / 4294967296.0;
}
static double dot_product(const double *a, const float *x, unsigned n) {
  double sum = 0;
  for (unsigned i = 0; i < n; i++) sum += a[i] * (double)x[i];
  return sum;
}

static void draw_factors(integrand *f, unsigned n, uint32_t *state) {
  for (unsigned i = 0; i < n; i++) f->a[i] = uniform(state, 0.5, 2), f->w[i] = uniform(state, 0, 1);
}

static void draw_exponential(integrand *f, unsigned n, uint32_t *state) {
  draw_factors(f, n, state);
  f->exact = 1;
  for (unsigned i = 0; i < n; i++) f->exact *= (exp(f->a[i]) - 1) / f->a[i];
}
static double exponential(const integrand *f, unsigned n, const float *x) { return exp(dot_product(f->a, x, n)); }

/* The integral of exp(i a.x) is the product of exp(i a_k / 2) sin(a_k / 2) / (a_k / 2). */
static void draw_oscillation(integrand *f, unsigned n, uint32_t *state) {
  double phase, size = 1;
  draw_factors(f, n, state);
  phase = f->c = 2 * SC_PI * f->w[0];
  for (unsigned i = 0; i < n; i++) phase += 0.5 * f->a[i], size *= sin(0.5 * f->a[i]) / (0.5 * f->a[i]);
  f->exact = size * cos(phase);
}
static double oscillation(const integrand *f, unsigned n, const float *x) {
  return cos(f->c + dot_product(f->a, x, n));
}

static void draw_bump(integrand *f, unsigned n, uint32_t *state) {
  draw_factors(f, n, state);
  f->exact = 1;
  for (unsigned i = 0; i < n; i++)
    f->exact *= 0.5 * sqrt(SC_PI) / f->a[i] * (erf(f->a[i] * (1 - f->w[i])) + erf(f->a[i] * f->w[i]));
}
static double bump(const integrand *f, unsigned n, const float *x) {
  double sum = 0;
  for (unsigned i = 0; i < n; i++) sum += square(f->a[i] * ((double)x[i] - f->w[i]));
  return exp(-sum);
}

static void draw_box(integrand *f, unsigned n, uint32_t *state) { /* an interval, for n = 1 */
  f->exact = 1;
  for (unsigned i = 0; i < n; i++) f->a[i] = uniform(state, 0, 1), f->exact *= f->a[i];
}
static double box(const integrand *f, unsigned n, const float *x) {
  bool inside = true;
  for (unsigned i = 0; i < n; i++) inside &= (double)x[i] < f->a[i];
  return inside;
}

/* The volume of {x in [0,1]^n: a.x < c}, a > 0: inclusion and exclusion over the corners of the cube, each of which
   cuts off a simplex, of (c - a.v)^n / (n! prod a_i). A negative a_i is mirrored: x_i -> 1 - x_i. */
static double half_space_volume(const double *a, double c, unsigned n) {
  double volume = 0, scale = 1;
  for (unsigned i = 0; i < n; i++) {
    scale *= fabs(a[i]) * (i + 1);
    if (a[i] < 0) c -= a[i];
  }
  for (unsigned corner = 0; corner < 1u << n; corner++) {
    double left = c, sign = 1, power = 1;
    for (unsigned i = 0; i < n; i++)
      if (corner >> i & 1) left -= fabs(a[i]), sign = -sign;
    for (unsigned i = 0; i < n; i++) power *= left;
    if (left > 0) volume += sign * power;
  }
  return volume / scale;
}

/* Uniform orientation, through a uniform point. Components below 1/50 of the largest would cost the formula its digits,
   and are drawn anew. */
static void draw_half_space(integrand *f, unsigned n, uint32_t *state) {
  double least, length;
  do {
    length = 0, least = 1;
    for (unsigned i = 0; i < n; i++) f->a[i] = uniform(state, -1, 1), length += square(f->a[i]);
    for (unsigned i = 0; i < n; i++) least = fmin(least, fabs(f->a[i]));
  } while (length > 1 || least < 0.02);
  f->c = 0;
  for (unsigned i = 0; i < n; i++) f->c += f->a[i] * uniform(state, 0, 1);
  f->exact = half_space_volume(f->a, f->c, n);
}
static double half_space(const integrand *f, unsigned n, const float *x) { return dot_product(f->a, x, n) < f->c; }

static void draw_ball(integrand *f, unsigned n, uint32_t *state) { /* within the cube */
  f->c = uniform(state, 0.2, 0.5);
  for (unsigned i = 0; i < n; i++) f->w[i] = uniform(state, f->c, 1 - f->c);
  f->exact = n == 2 ? SC_PI * square(f->c) : 0.5 * square(SC_PI * f->c * f->c); /* n = 4 */
}
static double ball(const integrand *f, unsigned n, const float *x) {
  double sum = 0;
  for (unsigned i = 0; i < n; i++) sum += square((double)x[i] - f->w[i]);
  return sum < square(f->c);
}

/* Corner w[0], w[1]; the barycentrics of x are a linear in x - w, rows of the inverse of the edges. */
static void draw_triangle(integrand *f, unsigned n, uint32_t *state) {
  double p[3][2], area;
  (void)n;
  do {
    for (int i = 0; i < 6; i++) p[i / 2][i % 2] = uniform(state, 0, 1);
    area = (p[1][0] - p[0][0]) * (p[2][1] - p[0][1]) - (p[1][1] - p[0][1]) * (p[2][0] - p[0][0]);
  } while (fabs(area) < 0.1);
  f->w[0] = p[0][0], f->w[1] = p[0][1];
  f->a[0] = (p[2][1] - p[0][1]) / area, f->a[1] = -(p[2][0] - p[0][0]) / area;
  f->a[2] = -(p[1][1] - p[0][1]) / area, f->a[3] = (p[1][0] - p[0][0]) / area;
  f->exact = 0.5 * fabs(area);
}
static double triangle(const integrand *f, unsigned n, const float *x) {
  const double dx = (double)x[0] - f->w[0], dy = (double)x[1] - f->w[1];
  const double u = f->a[0] * dx + f->a[1] * dy, v = f->a[2] * dx + f->a[3] * dy;
  (void)n;
  return u >= 0 && v >= 0 && u + v <= 1;
}

static const family families[] = {{"exponential", SMOOTH, 1, draw_exponential, exponential},
    {"oscillation", SMOOTH, 1, draw_oscillation, oscillation}, {"bump", SMOOTH, 1, draw_bump, bump},
    {"exponential", SMOOTH, 2, draw_exponential, exponential},
    {"oscillation", SMOOTH, 2, draw_oscillation, oscillation}, {"bump", SMOOTH, 2, draw_bump, bump},
    {"exponential", SMOOTH, 4, draw_exponential, exponential},
    {"oscillation", SMOOTH, 4, draw_oscillation, oscillation}, {"bump", SMOOTH, 4, draw_bump, bump},
    {"interval", STEP, 1, draw_box, box}, {"half-plane", STEP, 2, draw_half_space, half_space},
    {"disc", STEP, 2, draw_ball, ball}, {"triangle", STEP, 2, draw_triangle, triangle},
    {"half-space", STEP, 4, draw_half_space, half_space}, {"ball", STEP, 4, draw_ball, ball},
    {"box", BOX, 2, draw_box, box}, {"box", BOX, 4, draw_box, box}};
enum { FAMILIES = sizeof families / sizeof *families };
static const char *const kind_names[] = {"smooth", "step", "box"};

/* >>measuring ------------------------------------------------------------------------------------------------------ */

enum { SLOPE_SEEDS = 32, SLOPE_EDGE = 8, SLOPE_POINTS = 7 }; /* 8 x 8 pixels; N = 4, 8, ... 256 */

typedef struct slopes {
  double n[SLOPE_POINTS];
  double mse[FAMILIES][SLOPE_SEEDS * SLOPE_POINTS];
} slopes;

/* Means over the samples of a pixel, of all families. */
static void integrate(const pktrt_sampling *s, uint32_t x, uint32_t y, const integrand *f, double *mean) {
  float u[4];
  for (int k = 0; k < FAMILIES; k++) mean[k] = 0;
  for (uint32_t i = 0; i < s->samples; i++) {
    pktrt_sample(s, x, y, i, 0, 4, u);
    for (int k = 0; k < FAMILIES; k++) mean[k] += families[k].value(&f[k], families[k].dimensions, u) / s->samples;
  }
}

static void measure_slopes(pktrt_sampler sampler, slopes *to) {
  memset(to, 0, sizeof *to);
  for (unsigned seed = 0; seed < SLOPE_SEEDS; seed++)
    for (unsigned pixel = 0; pixel < SLOPE_EDGE * SLOPE_EDGE; pixel++) {
      uint32_t state = (seed * SLOPE_EDGE * SLOPE_EDGE + pixel + 1) * 0x9E3779B9u;
      integrand f[FAMILIES];
      for (int k = 0; k < FAMILIES; k++) families[k].draw(&f[k], families[k].dimensions, &state);
      for (unsigned i = 0; i < SLOPE_POINTS; i++) {
        pktrt_sampling s;
        double mean[FAMILIES];
        s.sampler = sampler, s.samples = 4u << i, s.seed = FIRST_SEED + seed;
        to->n[i] = s.samples;
        integrate(&s, pixel % SLOPE_EDGE, pixel / SLOPE_EDGE, f, mean);
        for (int k = 0; k < FAMILIES; k++)
          to->mse[k][seed * SLOPE_POINTS + i] += square(mean[k] - f[k].exact) / (SLOPE_EDGE * SLOPE_EDGE);
      }
    }
}

static interval family_slope(const slopes *s, int k) { return log_slope(s->n, s->mse[k], SLOPE_POINTS, SLOPE_SEEDS); }

static double family_rmse(const slopes *s, int k, unsigned i) {
  double sum = 0;
  for (unsigned seed = 0; seed < SLOPE_SEEDS; seed++) sum += s->mse[k][seed * SLOPE_POINTS + i] / SLOPE_SEEDS;
  return sqrt(sum);
}

/* >>report --------------------------------------------------------------------------------------------------------- */

static void part_slopes(bench *b) {
  static slopes measured[PKTRT_SAMPLER_COUNT];
  csv(&b->out, "sampler,integrand,kind,dimensions,samples,rmse,slope,low,high\n");
  say(&b->out,
      "Slopes of log RMSE over log N, N = 4 to 256, %d seeds of %d pixels; in brackets how far the ends of the "
      "95%% interval are off.\n\n| integrand | dimensions |",
      (int)SLOPE_SEEDS, (int)(SLOPE_EDGE * SLOPE_EDGE));
  for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) {
    measure_slopes((pktrt_sampler)s, &measured[s]);
    say(&b->out, " %s |", pktrt_sampler_string((pktrt_sampler)s));
  }
  say(&b->out, "\n|---|--:|");
  for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) say(&b->out, "--:|");
  say(&b->out, "\n");
  for (int k = 0; k < FAMILIES; k++) {
    say(&b->out, "| %s, %s | %u |", kind_names[families[k].kind], families[k].name, families[k].dimensions);
    for (int s = 0; s < PKTRT_SAMPLER_COUNT; s++) {
      const interval r = family_slope(&measured[s], k);
      say(&b->out, " %.2f (%.2f) |", r.value, 0.5 * (r.high - r.low));
      for (unsigned i = 0; i < SLOPE_POINTS; i++)
        csv(&b->out, "%s,%s,%s,%u,%.0f,%.6g,%.4f,%.4f,%.4f\n", pktrt_sampler_string((pktrt_sampler)s), families[k].name,
            kind_names[families[k].kind], families[k].dimensions, measured[s].n[i], family_rmse(&measured[s], k, i),
            r.value, r.low, r.high);
    }
    say(&b->out, "\n");
  }
  say(&b->out, "\n");
}

/* >>checks --------------------------------------------------------------------------------------------------------- */

/* The shallowest slope of a kind, in so many dimensions (0: any), of Sobol' points; as a control of random ones. */
static double check_slope(bench *b, const claim *c, bool control, char details[DETAILS]) {
  static slopes measured[PKTRT_SAMPLER_COUNT];
  const pktrt_sampler sampler = control ? PKTRT_SAMPLER_RANDOM : PKTRT_SAMPLER_SOBOL;
  double worst = -INFINITY;
  size_t at = 0;
  (void)b;
  if (!(measured[sampler].n[0] > 0)) measure_slopes(sampler, &measured[sampler]);
  for (int k = 0; k < FAMILIES; k++) {
    if (strcmp(kind_names[families[k].kind], c->on) || (c->number && families[k].dimensions != c->number)) continue;
    const interval r = family_slope(&measured[sampler], k);
    worst = larger(worst, r.value);
    const int n = snprintf(details + at, DETAILS - at, "%s%s %u: %.2f [%.2f, %.2f]", at ? ", " : "", families[k].name,
        families[k].dimensions, r.value, r.low, r.high);
    if (n > 0 && at + (size_t)n < DETAILS) at += (size_t)n;
  }
  return worst;
}

#endif /* ERROR_SLOPES_H */
