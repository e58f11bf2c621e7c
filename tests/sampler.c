/* Samplers and mappings. Statistical bounds are five standard errors or more: they hold for any --seed. */
#include "test.h"

#define PI 3.14159265358979323846

static pktrt_sampling sampling(int sampler, uint32_t samples, uint32_t seed) {
  pktrt_sampling s = {(pktrt_sampler)sampler, samples, seed};
  return s;
}
static const char *name_of(int sampler) { return pktrt_sampler_string((pktrt_sampler)sampler); }

/* Chi-square of counts that should be equal. A bound of eight standard deviations is passed by chance once in 10^8. */
static double chi_square(const uint32_t *count, uint32_t bins) {
  double total = 0, sum = 0;
  for (uint32_t i = 0; i < bins; i++) total += count[i];
  for (uint32_t i = 0; i < bins; i++) sum += (count[i] - total / bins) * (count[i] - total / bins) * bins / total;
  return sum;
}
static double chi_bound(uint32_t bins) { return bins - 1 + 8 * sqrt(2.0 * (bins - 1)); }

static uint32_t random_count(rng *r) {
  static const uint32_t counts[10] = {1, 2, 3, 7, 16, 61, 64, 100, 1000, 65536};
  return counts[rng_below(r, 10)];
}

/* Mean and standard error, as values come. */
typedef struct tally {
  double n, sum, squares;
} tally;
static void tally_add(tally *t, double x) { t->n++, t->sum += x, t->squares += x * x; }
static double tally_mean(const tally *t) { return t->sum / t->n; }
static double tally_error(const tally *t) {
  return sqrt(fmax(t->squares / t->n - tally_mean(t) * tally_mean(t), 0) / t->n);
}
static bool tally_is(const tally *t, double mean) { return fabs(tally_mean(t) - mean) <= 5 * tally_error(t) + 1e-7; }

/* --- values --- */

static void uniform(void) {
  size_t values = 0;
  for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
    for (uint32_t dimension = 0; dimension <= 40; dimension++) {
      uint32_t count[32] = {0}, squared[32] = {0}, bad = 0;
      rng r = rng_of((uint64_t)sampler * 100 + dimension);
      for (size_t i = 0; i < 400 + scaled(8000); i++, values++) {
        pktrt_sampling s = sampling(sampler, random_count(&r), rng_u32(&r));
        float u;
        pktrt_sample(&s, rng_below(&r, 65536), rng_below(&r, 65536), rng_below(&r, s.samples), dimension, 1, &u);
        if (!(u >= 0 && u < 1) || u * 0x1p24f != floorf(u * 0x1p24f)) bad++;
        else count[(int)(u * 32)]++, squared[(int)(u * u * 32)]++;
      }
      CHECK(bad == 0, "%s, dimension %u: %u values outside of [0,1)", name_of(sampler), dimension, bad);
      CHECK(chi_square(count, 32) < chi_bound(32), "%s, dimension %u: chi-square is %g", name_of(sampler), dimension,
          chi_square(count, 32));
      CHECK(chi_square(squared, 32) > chi_bound(32), "the control: squares pass as uniform");
    }
  }
  say("%zu values", values);
}

static void counter_based(void) {
  size_t calls = 0, differ = 0;
  for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
    rng r = rng_of(77 + (uint64_t)sampler);
    for (size_t i = 0; i < scaled(4000); i++, calls++) {
      const pktrt_sampling s = sampling(sampler, random_count(&r), rng_u32(&r));
      const uint32_t x = rng_below(&r, 65536), y = rng_below(&r, 65536), sample = rng_below(&r, s.samples);
      const uint32_t dimension = rng_below(&r, 300), n = 1 + rng_below(&r, 12);
      float all[12], one, other;
      pktrt_sample(&s, x, y, sample, dimension, n, all);
      for (uint32_t k = n; k-- > 0;) { /* backwards, one by one */
        pktrt_sample(&s, x, y, sample, dimension + k, 1, &one);
        CHECK(same_bits(&one, &all[k], sizeof one), "%s: dimension %u of %u is %g or %g", name_of(sampler), k, n,
            (double)one, (double)all[k]);
        pktrt_sample(&s, x, y, sample, dimension + k + 1, 1, &other);
        differ += !same_bits(&other, &one, sizeof one);
      }
    }
  }
  say("%zu calls", calls);
  CHECK(differ > calls, "the control: other dimensions have other values");
}

/* Whether two values have anything to do with each other: counts in 8 x 8 bins. */
typedef struct relation {
  uint32_t count[64];
} relation;
static void relate(relation *r, float a, float b) { r->count[(int)(a * 8) * 8 + (int)(b * 8)]++; }
static float one_value(int sampler, uint32_t n, uint32_t seed, uint32_t x, uint32_t y, uint32_t i, uint32_t dimension) {
  const pktrt_sampling s = sampling(sampler, n, seed);
  float u;
  pktrt_sample(&s, x, y, i, dimension, 1, &u);
  return u;
}

static void unrelated(void) {
  static const char *const what[7] = {"seeds", "pixels in a row", "pixels in a column", "the control", "groups",
      "neighbours in a group", "next seed and next group"};
  for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
    relation with[7];
    memset(with, 0, sizeof with);
    rng r = rng_of(311 + (uint64_t)sampler);
    const uint32_t first = rng_u32(&r);
    for (uint32_t i = 0; i < 700 + scaled(8000); i++) {
      const uint32_t seed = first + i, n = 16 + i % 7, sample = i % 16, x = i % 512, y = i / 512, d = i % 5;
      const float u = one_value(sampler, n, seed, x, y, sample, d);
      const float next = one_value(sampler, n, seed + 1, x, y, sample, d);
      const float far = one_value(sampler, n, seed, x, y, sample, d + 4);
      relate(&with[0], u, next);
      relate(&with[1], u, one_value(sampler, n, seed + 1000000, x + 1, y, sample, d));
      relate(&with[2], one_value(sampler, n, 5, i, 7, sample, d), one_value(sampler, n, 5, i, 300, sample, d));
      relate(&with[3], u, u);
      relate(&with[4], u, far);
      relate(&with[5], u, one_value(sampler, n, seed, x, y, sample, d + 1));
      relate(&with[6], far, next);
    }
    for (int k = 0; k < 7; k++) {
      if (k == 2 && sampler == PKTRT_SAMPLER_INTERLEAVED) continue; /* these come again every four pixels */
      const double chi = chi_square(with[k].count, 64);
      CHECK((chi < chi_bound(64)) == (k != 3), "%s: %s: chi-square is %g", name_of(sampler), what[k], chi);
    }
  }
}

/* The sky shows where rays go. */
static void show_direction(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (int a = 0; a < 3; a++) memcpy(radiance[a], direction[a], n * sizeof(float));
}

/* Pixels of a camera that looks along -z with half a picture at slope 1, as pktrt_sample says. */
static void in_renders(void) {
  enum { EDGE = 16 };
  static const uint32_t counts[7] = {2, 4, 7, 16, 17, 64, 1000};
  static float pixels[EDGE * EDGE * 3];
  pktrt_scene *world = pktrt_scene_create(NULL);
  double largest = 0, aside = 0;
  if (!CHECK(world && pktrt_commit(world) == PKTRT_OK)) return;
  for (uint32_t k = 0; k < PKTRT_SAMPLER_COUNT * 7; k++) {
    pktrt_render_desc d;
    const pktrt_sampling s = sampling((int)(k / 7), counts[k % 7], (uint32_t)run_seed + k), other = sampling(0, 4, 1);
    memset(&d, 0, sizeof d);
    d.samples = 1;
    d.width = d.height = EDGE, d.pixels = pixels, d.mode = PKTRT_MODE_DRT;
    d.samples = s.samples, d.sampler = s.sampler, d.seed = s.seed;
    d.camera.target[2] = -1, d.camera.fov_y = 90, d.environment = show_direction;
    if (!CHECK(pktrt_render(world, &d) == PKTRT_OK, "%s", pktrt_last_error(world))) break;
    for (uint32_t pixel = 0; pixel < EDGE * EDGE; pixel += small_run ? 37 : 1) {
      double sum = 0, off = 0;
      for (uint32_t i = 0; i < s.samples; i++)
        for (int wrong = 0; wrong < 2; wrong++) {
          float u[2];
          pktrt_sample(wrong ? &other : &s, pixel % EDGE, pixel / EDGE, i, 0, 2, u);
          const double x = 2 * ((double)(pixel % EDGE) + (double)u[0]) / EDGE - 1;
          const double y = 1 - 2 * ((double)(pixel / EDGE) + (double)u[1]) / EDGE;
          *(wrong ? &off : &sum) += x / sqrt(x * x + y * y + 1) / s.samples;
        }
      largest = fmax(largest, fabs(sum - (double)pixels[3 * pixel]));
      aside = fmax(aside, fabs(off - (double)pixels[3 * pixel]));
    }
  }
  CHECK(largest < 1e-6, "%g", largest);
  CHECK(aside > 1e-2, "the control: other samples, %g", aside);
  say("largest difference of a pixel %.2g; of other samples %.2g", largest, aside);
  pktrt_scene_destroy(world);
}

static void out_of_range(void) {
  for (int sampler = -1; sampler <= PKTRT_SAMPLER_COUNT; sampler++) {
    static const uint32_t odd[6] = {0, 1, 5, 65536, 65537, 0xFFFFFFFFu};
    CHECK(pktrt_sampler_string((pktrt_sampler)sampler) && pktrt_sampler_string((pktrt_sampler)sampler)[0]);
    for (int other = 0; other < sampler; other++)
      CHECK(strcmp(name_of(sampler), name_of(other)) != 0, "two samplers are called %s", name_of(other));
    for (int i = 0; i < 6 * 6 * 6; i++) {
      const pktrt_sampling s = sampling(sampler, odd[i % 6], odd[i / 36]);
      float u[9] = {-1, -1, -1, -1, -1, -1, -1, -1, -1};
      pktrt_sample(&s, odd[i / 6 % 6], odd[i / 36], odd[i / 6 % 6], odd[i / 36] / 2, 8, u);
      for (int k = 0; k < 8; k++) CHECK(u[k] >= 0 && u[k] < 1, "sampler %d: %g", sampler, (double)u[k]);
      CHECK(u[8] == -1, "the ninth of eight is untouched");
    }
  }
}

/* 0 samples are 1, more than 65536 are 65536, and numbers beyond the last begin again. */
static void clamped(void) {
  static const uint32_t given[3][2] = {{0, 1}, {65537, 65536}, {0xFFFFFFFFu, 65536}};
  for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
    int differ = 0;
    for (int i = 0; i < 3; i++) {
      for (uint32_t k = 0; k < 64; k++) {
        const pktrt_sampling odd = sampling(sampler, given[i][0], 3), even = sampling(sampler, given[i][1], 3);
        const pktrt_sampling other = sampling(sampler, 65535, 3);
        float a[8], b[8], c[8];
        pktrt_sample(&odd, 7, 5, 65530 + k, 0, 8, a);
        pktrt_sample(&even, 7, 5, (65530 + k) % given[i][1], 0, 8, b);
        pktrt_sample(&other, 7, 5, 65530 + k, 0, 8, c);
        CHECK(same_bits(a, b, sizeof a), "%s: %u samples", name_of(sampler), given[i][0]);
        differ += !same_bits(a, c, sizeof a);
      }
    }
    CHECK(differ > 64, "the control, %s: another number of samples changes %d of 192", name_of(sampler), differ);
  }
}

/* --- how points lie --- */

enum { MOST_POINTS = 4096 }; /* 2^12 */
typedef struct points {
  uint32_t n, at[MOST_POINTS][2]; /* in 2^-24 */
} points;

static void add_points(points *p, const pktrt_sampling *s, uint32_t x, uint32_t y, uint32_t d0, uint32_t d1) {
  for (uint32_t i = 0; i < s->samples; i++, p->n++) {
    float u, v;
    pktrt_sample(s, x, y, i, d0, 1, &u);
    pktrt_sample(s, x, y, i, d1, 1, &v);
    p->at[p->n][0] = (uint32_t)(u * 0x1p24f), p->at[p->n][1] = (uint32_t)(v * 0x1p24f);
  }
}

/* Most points in a cell of a x b. */
static uint32_t crowd(const points *p, uint32_t a, uint32_t b) {
  uint16_t count[MOST_POINTS] = {0};
  uint32_t most = 0;
  for (uint32_t i = 0; i < p->n; i++) {
    const uint32_t cell = (uint32_t)((uint64_t)p->at[i][0] * a >> 24) * b + (uint32_t)((uint64_t)p->at[i][1] * b >> 24);
    if (++count[cell] > most) most = count[cell];
  }
  return most;
}

/* One of 2^m points in every elementary interval of area 2^-m. */
static bool is_net(const points *p) {
  bool net = true;
  for (uint32_t a = 1; a <= p->n; a *= 2) net = net && crowd(p, a, p->n / a) == 1;
  return net;
}

static void nets(void) {
  static const int samplers[3] = {PKTRT_SAMPLER_SOBOL, PKTRT_SAMPLER_INTERLEAVED, PKTRT_SAMPLER_BLUE_NOISE};
  points *p = malloc(sizeof *p);
  size_t sets = 0, across = 0;
  if (!CHECK(p != NULL)) return;
  for (int k = 0; k < 3; k++) {
    rng r = rng_of(1234 + (uint64_t)k);
    for (uint32_t n = 1; n <= (small_run ? 256 : MOST_POINTS); n *= 2) {
      for (uint32_t pair = 0; pair < 10; pair += 2, sets++) {
        const pktrt_sampling s = sampling(samplers[k], n, rng_u32(&r));
        const uint32_t x = rng_below(&r, 65536), y = rng_below(&r, 65536);
        p->n = 0, add_points(p, &s, x, y, pair, pair + 1);
        CHECK(is_net(p), "%s: %u points of dimensions %u and %u", name_of(samplers[k]), n, pair, pair + 1);
        p->n = 0, add_points(p, &s, x, y, pair + 1, pair + 2);
        across += !is_net(p);
      }
    }
  }
  say("%zu sets of points; of dimensions that are no pair, %zu are no net", sets, across);
  CHECK(across > sets / 2, "the control");
  free(p);
}

/* Whether 2^m points are spread evenly over boxes of 2^-(m - t) in all of so many dimensions: 2^t in each, for all sides. */
static bool is_even(float (*u)[4], uint32_t m, uint32_t t, uint32_t dimensions) {
  const uint32_t digits = m > t ? m - t : 0;
  bool even = true;
  for (uint32_t shape = 0; shape < 1u << 4 * dimensions && even; shape++) {
    uint16_t count[256] = {0};
    uint32_t sum = 0;
    for (uint32_t d = 0; d < dimensions; d++) sum += shape >> 4 * d & 15;
    if (sum != digits) continue;
    for (uint32_t i = 0; i < 1u << m; i++) {
      uint32_t box = 0;
      for (uint32_t d = 0; d < dimensions; d++)
        box = box << (shape >> 4 * d & 15) | (uint32_t)(u[i][d] * (float)(1u << (shape >> 4 * d & 15)));
      even = even && ++count[box] <= 1u << (m - digits);
    }
  }
  return even;
}

static void nets_of_four(void) {
  static const int samplers[3] = {PKTRT_SAMPLER_SOBOL, PKTRT_SAMPLER_INTERLEAVED, PKTRT_SAMPLER_HAMMERSLEY};
  uint32_t uneven[3] = {0, 0, 0}, sets = 0;
  for (int k = 0; k < 3; k++) {
    rng r = rng_of(4321 + (uint64_t)k);
    for (uint32_t m = 0; m <= (small_run ? 5 : 8); m++, sets++) {
      const pktrt_sampling s = sampling(samplers[k], 1u << m, rng_u32(&r));
      const uint32_t group = rng_below(&r, 50) * 4, x = rng_below(&r, 1024);
      float u[256][4];
      for (uint32_t i = 0; i < s.samples; i++) pktrt_sample(&s, x, 5, i, group, 4, u[i]);
      uneven[k] += !is_even(u, m, 0, 3) || !is_even(u, m, 1, 4);
    }
  }
  CHECK(uneven[0] == 0, "%u of %u sets of Sobol' points", uneven[0], sets / 3);
  CHECK(uneven[1] > 0 && uneven[2] > 0, "the control: interleaved and Hammersley");
  say("uneven, of %u sets: sobol %u, interleaved %u, hammersley %u", sets / 3, uneven[0], uneven[1], uneven[2]);
}

/* Together, the points of 4^k pixels are a net of 4^k times as many. */
static void nets_of_pixels(void) {
  points *p = malloc(sizeof *p);
  size_t failed[PKTRT_SAMPLER_COUNT] = {0}, sets = 0;
  if (!CHECK(p != NULL)) return;
  for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
    rng r = rng_of(99 + (uint64_t)sampler);
    for (uint32_t n = 1; n <= 16; n *= 2) {
      for (uint32_t edge = 2; edge <= 16 && edge * edge * n <= (small_run ? 256 : MOST_POINTS); edge *= 2, sets++) {
        if (sampler == PKTRT_SAMPLER_INTERLEAVED && edge > 4) continue;
        const pktrt_sampling s = sampling(sampler, n, rng_u32(&r));
        const uint32_t x = rng_below(&r, 1024) * edge, y = rng_below(&r, 1024) * edge, pair = rng_below(&r, 20) * 2;
        p->n = 0;
        for (uint32_t i = 0; i < edge * edge; i++) add_points(p, &s, x + i % edge, y + i / edge, pair, pair + 1);
        failed[sampler] += !is_net(p);
      }
    }
  }
  CHECK(failed[PKTRT_SAMPLER_INTERLEAVED] == 0, "interleaved: %zu", failed[PKTRT_SAMPLER_INTERLEAVED]);
  CHECK(failed[PKTRT_SAMPLER_BLUE_NOISE] == 0, "blue noise: %zu", failed[PKTRT_SAMPLER_BLUE_NOISE]);
  CHECK(failed[PKTRT_SAMPLER_SOBOL] > 0 && failed[PKTRT_SAMPLER_RANDOM] > 0,
      "the control: pixels that know nothing of another");
  free(p);
}

/* Samples, columns, rows. Powers of two, for truncation to 24 bits takes a point across other borders now and then. */
static void cells(void) {
  static const uint32_t grids[9][3] = {
      {1, 1, 1}, {2, 2, 1}, {3, 2, 2}, {8, 4, 2}, {13, 4, 4}, {61, 8, 8}, {64, 8, 8}, {128, 16, 8}, {1021, 32, 32}};
  points *p = malloc(sizeof *p);
  uint32_t shared = 0;
  if (!CHECK(p != NULL)) return;
  for (uint32_t i = 0; i < 9 * 12; i++) {
    const uint32_t *g = grids[i % 9], pair = i / 9 * 2;
    const pktrt_sampling s = sampling(PKTRT_SAMPLER_JITTERED, g[0], (uint32_t)run_seed + i);
    const pktrt_sampling wild = sampling(PKTRT_SAMPLER_RANDOM, g[0], i);
    p->n = 0, add_points(p, &s, i, 3, pair, pair + 1);
    CHECK(crowd(p, g[1], g[2]) == 1, "%u samples, dimensions %u and %u: %u in a cell", g[0], pair, pair + 1,
        crowd(p, g[1], g[2]));
    p->n = 0, add_points(p, &wild, i, 3, pair, pair + 1);
    shared += crowd(p, g[1], g[2]) > 1;
  }
  CHECK(shared > 50, "the control: random samples share cells, %u times", shared);
  free(p);
}

static int by_place(const void *a, const void *b) {
  const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
  return x < y ? -1 : x > y;
}

/* One of n samples in each n-th part of [0,1), all values within 2^-24 of a part being in it. */
static bool has_strata(int sampler, uint32_t n, uint32_t dimension) {
  static uint32_t at[MOST_POINTS];
  const uint32_t seed = (uint32_t)run_seed;
  bool each = true;
  for (uint32_t i = 0; i < n; i++) at[i] = (uint32_t)(one_value(sampler, n, seed, 5, n, i, dimension) * 0x1p24f);
  qsort(at, n, sizeof at[0], by_place);
  for (uint64_t i = 0; i < n; i++)
    each = each && (at[i] + UINT64_C(1)) * n > i << 24 && (uint64_t)at[i] * n < (i + 1) << 24;
  return each;
}

static void strata(void) {
  static const uint8_t primes[6] = {2, 3, 5, 7, 11, 13};
  uint32_t sets = 0, kept = 0;
  for (uint32_t k = 0; k < 6; k++) {
    for (uint32_t n = primes[k]; n < MOST_POINTS; n *= primes[k], sets++) {
      CHECK(has_strata(PKTRT_SAMPLER_HALTON, n, k), "Halton: dimension %u, %u samples", k, n);
      CHECK(has_strata(PKTRT_SAMPLER_HALTON, n, k + 32), "Halton: dimension %u, %u samples", k + 32, n);
      CHECK(has_strata(PKTRT_SAMPLER_HAMMERSLEY, n, k + 1), "Hammersley: dimension %u, %u samples", k + 1, n);
      CHECK(has_strata(PKTRT_SAMPLER_HAMMERSLEY, n, 0) && has_strata(PKTRT_SAMPLER_HAMMERSLEY, n + 1, 32),
          "Hammersley: i / n of %u samples", n);
      kept += has_strata(PKTRT_SAMPLER_RANDOM, n, k) || has_strata(PKTRT_SAMPLER_HALTON, n, k + 1);
    }
  }
  CHECK(kept < sets / 2, "the control: random samples and those of another base have them %u of %u times", kept, sets);
}

static void repeated(void) {
  uint32_t again[PKTRT_SAMPLER_COUNT] = {0}, tries = 0;
  for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
    rng r = rng_of(4);
    for (uint32_t i = 0; i < 200; i++, tries += sampler == 0) {
      const uint32_t n = random_count(&r), seed = rng_u32(&r), x = rng_below(&r, 60000), y = rng_below(&r, 60000);
      const uint32_t at = rng_below(&r, n), d = rng_below(&r, 50), dx = rng_below(&r, 50), dy = 1 + rng_below(&r, 50);
      const float u = one_value(sampler, n, seed, x, y, at, d);
      again[sampler] += u == one_value(sampler, n, seed, x + 4 * dx, y + 4 * dy, at, d);
      again[sampler] += u == one_value(sampler, n, seed, x + 1 + dx % 3, y, at, d);
    }
  }
  for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++)
    CHECK(again[sampler] == (sampler == PKTRT_SAMPLER_INTERLEAVED ? tries : 0), "%s: %u of %u", name_of(sampler),
        again[sampler], tries);
}

/* --- errors of integrals --- */

enum { SMOOTH_1, SMOOTH_2, SMOOTH_4, STEP_1, STEP_2, STEP_4, INTEGRANDS };
static const char *const integrand_names[INTEGRANDS] = {
    "smooth, 1", "smooth, 2", "smooth, 4", "step, 1", "step, 2", "step, 4"};

/* Products of a exp(a u) / (exp(a) - 1), and half-spaces: the integral of each is known. */
typedef struct integrands {
  double rate[4], scale[4], slope[4], edge;
} integrands;

static integrands integrands_of(rng *r) {
  integrands f;
  for (int k = 0; k < 4; k++) {
    f.rate[k] = (double)rng_range(r, 0.4f, 1.2f) * (rng_u32(r) & 1 ? 1 : -1);
    f.scale[k] = f.rate[k] / (exp(f.rate[k]) - 1);
    f.slope[k] = (double)rng_sign(r);
  }
  f.edge = (double)rng_range(r, 0.1f, 0.9f);
  return f;
}

static void integrate(const integrands *f, const float u[4], double sum[INTEGRANDS]) {
  double smooth = 1, plane = 0;
  for (int k = 0; k < 4; k++) {
    smooth *= f->scale[k] * exp(f->rate[k] * (double)u[k]);
    plane += f->slope[k] * ((double)u[k] - 0.5);
    if (k == 0) sum[SMOOTH_1] += smooth;
    if (k == 1) sum[SMOOTH_2] += smooth, sum[STEP_2] += plane < 0; /* half of the square, by symmetry */
  }
  sum[SMOOTH_4] += smooth, sum[STEP_4] += plane < 0, sum[STEP_1] += (double)u[0] < f->edge;
}

/* Slopes of log RMSE over log samples, for 4 to 256 samples, by least squares. */
static void slopes_of(int sampler, uint32_t dimension, uint32_t replicates, double slope[INTEGRANDS]) {
  double sxx = 0, sxy[INTEGRANDS] = {0};
  for (int j = 0; j < 7; j++) {
    const uint32_t n = 4u << j;
    double squares[INTEGRANDS] = {0};
    rng r = rng_of(5000 + (uint64_t)j);
    for (uint32_t q = 0; q < replicates; q++) {
      const integrands f = integrands_of(&r);
      const pktrt_sampling s = sampling(sampler, n, rng_u32(&r));
      double sum[INTEGRANDS] = {0};
      for (uint32_t i = 0; i < n; i++) {
        float u[4];
        pktrt_sample(&s, q, 17, i, dimension, 4, u);
        integrate(&f, u, sum);
      }
      const double exact[INTEGRANDS] = {1, 1, 1, f.edge, 0.5, 0.5};
      for (int k = 0; k < INTEGRANDS; k++) squares[k] += (sum[k] / n - exact[k]) * (sum[k] / n - exact[k]);
    }
    const double x = (j - 3) * log(2);
    sxx += x * x;
    for (int k = 0; k < INTEGRANDS; k++) sxy[k] += x * 0.5 * log(squares[k] / replicates);
  }
  for (int k = 0; k < INTEGRANDS; k++) slope[k] = sxy[k] / sxx;
}

/* Bounds leave room for the scatter of a run. For a step across it, a grid of sqrt(n) columns has -3/4, not -1. */
static void convergence(void) {
  static const double least[][INTEGRANDS] = {{-1.40, -1.30, -1.10, -0.90, -0.70, -0.53},
      {-0.40, -0.40, -0.40, -0.40, -0.40, -0.40}, {-0.90, -0.90, -0.60, -0.70, -0.65, -0.48},
      {-1.40, -1.30, -1.10, -0.90, -0.70, -0.53}, {-1.40, -0.95, -0.90, -0.90, -0.66, -0.53},
      {-1.40, -1.00, -0.90, -0.90, -0.70, -0.53}, {-1.40, -1.30, -1.10, -0.90, -0.70, -0.53}};
  const double slack = small_run ? 0.2 : 0.03;
  CHECK(sizeof least / sizeof *least == PKTRT_SAMPLER_COUNT, "a row for each sampler");
  if (sizeof least / sizeof *least != PKTRT_SAMPLER_COUNT) return;
  for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
    double slope[INTEGRANDS];
    slopes_of(sampler, 0, small_run ? 40 : sampler == 0 ? 1000 : 400, slope);
    say("%-11s smooth %.2f %.2f %.2f, step %.2f %.2f %.2f in 1, 2 and 4 dimensions", name_of(sampler), slope[SMOOTH_1],
        slope[SMOOTH_2], slope[SMOOTH_4], slope[STEP_1], slope[STEP_2], slope[STEP_4]);
    for (int k = 0; k < INTEGRANDS; k++) {
      CHECK(slope[k] < least[sampler][k] + slack, "%s, %s: %g", name_of(sampler), integrand_names[k], slope[k]);
      if (sampler == PKTRT_SAMPLER_RANDOM) CHECK(slope[k] > -0.6 - slack, "the control: %g", slope[k]);
    }
  }
}

static void unbiased(void) {
  static const uint32_t counts[5] = {1, 3, 7, 16, 61};
  for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
    for (int c = 0; c < 5; c++) {
      const uint32_t n = counts[c];
      tally mean[INTEGRANDS], square, unshifted;
      memset(mean, 0, sizeof mean), memset(&square, 0, sizeof square), memset(&unshifted, 0, sizeof unshifted);
      rng r = rng_of(800 + (uint64_t)c);
      integrands f = integrands_of(&r);
      f.edge = 0.4142; /* close to no multiple of 1 / n: there the error hides in few of the replicates */
      const uint32_t first = rng_u32(&r);
      for (uint32_t seed = 0; seed < 100 + scaled(1600); seed++) {
        const pktrt_sampling s = sampling(sampler, n, first + seed);
        double sum[INTEGRANDS] = {0}, squares = 0, plain = 0;
        for (uint32_t i = 0; i < n; i++) {
          float u[4];
          pktrt_sample(&s, 100, 200, i, 0, 4, u);
          integrate(&f, u, sum);
          squares += (double)u[3] * (double)u[3];
          plain += (double)(i * i) / (n * n);
        }
        for (int k = 0; k < INTEGRANDS; k++) tally_add(&mean[k], sum[k] / n);
        tally_add(&square, squares / n), tally_add(&unshifted, plain / n);
      }
      for (int k = 0; k < INTEGRANDS; k++)
        CHECK(tally_is(&mean[k], k == STEP_1  ? f.edge
                                 : k < STEP_1 ? 1
                                              : 0.5),
            "%s, %u samples, %s: mean %g +- %g", name_of(sampler), n, integrand_names[k], tally_mean(&mean[k]),
            tally_error(&mean[k]));
      CHECK(tally_is(&square, 1.0 / 3), "%s, %u samples: mean square %g +- %g", name_of(sampler), n,
          tally_mean(&square), tally_error(&square));
      CHECK(!tally_is(&unshifted, 1.0 / 3), "the control: i / n without a shift is biased");
    }
  }
}

/* RMSE of the mean of (u - 1/2) (v - 1/2), times 12 sqrt(n): 1 for random samples, less for well spread pairs. */
static double product_error(int sampler, uint32_t n, uint32_t d0, uint32_t d1, uint32_t replicates) {
  double squares = 0;
  for (uint32_t q = 0; q < replicates; q++) {
    double sum = 0;
    for (uint32_t i = 0; i < n; i++)
      sum += ((double)one_value(sampler, n, (uint32_t)run_seed + q, q, 9, i, d0) - 0.5) *
             ((double)one_value(sampler, n, (uint32_t)run_seed + q, q, 9, i, d1) - 0.5);
    squares += sum * sum;
  }
  return 12 * sqrt(squares / replicates / n);
}

static void groups(void) {
  static const uint32_t pairs[6][2] = {{0, 4}, {1, 6}, {2, 34}, {0, 32}, {33, 65}, {3, 12}};
  const uint32_t replicates = small_run ? 60 : 300;
  for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
    for (int k = 0; k < 6; k++) {
      const double error = product_error(sampler, 50, pairs[k][0], pairs[k][1], replicates);
      CHECK(error < (small_run ? 1.6 : 1.3), "%s, dimensions %u and %u: %g of the error of random samples",
          name_of(sampler), pairs[k][0], pairs[k][1], error);
    }
    CHECK(product_error(sampler, 50, 4, 4, replicates) > 3, "the control: a dimension with itself");
  }
}

/* RMSE of a picture, of its means over 4 x 4 pixels anywhere, and the correlation of neighbours. */
typedef struct grain {
  double single, blurred, neighbours;
} grain;

static grain grain_of(int sampler, uint32_t n, uint32_t seed, uint32_t size) {
  grain g = {0, 0, 0};
  double *error = calloc((size_t)size * size, sizeof *error);
  const pktrt_sampling s = sampling(sampler, n, seed);
  if (!CHECK(error != NULL)) return g;
  for (uint32_t at = 0; at < size * size; at++) {
    for (uint32_t i = 0; i < n; i++) {
      float u[2];
      pktrt_sample(&s, at % size, at / size, i, 2, 2, u);
      error[at] += exp((double)u[0]) * (double)u[1] - (exp(1) - 1) / 2;
    }
    g.single += error[at] * error[at];
  }
  for (uint32_t y = 0; y + 4 <= size; y++) {
    for (uint32_t x = 0; x + 4 <= size; x++) {
      double sum = 0;
      for (uint32_t k = 0; k < 16; k++) sum += error[(y + k / 4) * size + x + k % 4] / 16;
      g.blurred += sum * sum;
      g.neighbours += error[y * size + x] * (error[y * size + x + 1] + error[(y + 1) * size + x]) / 2;
    }
  }
  const double windows = (double)(size - 3) * (size - 3), pixels = (double)size * size;
  g.neighbours *= pixels / windows / g.single;
  g.single = sqrt(g.single / pixels) / n, g.blurred = sqrt(g.blurred / windows) / n;
  free(error);
  return g;
}

static void blue(void) {
  const uint32_t size = small_run ? 64 : 128;
  for (uint32_t n = 1; n <= 16; n *= 4) {
    const uint32_t seed = n + (uint32_t)run_seed;
    const grain sobol = grain_of(PKTRT_SAMPLER_SOBOL, n, seed, size);
    const grain g = grain_of(PKTRT_SAMPLER_BLUE_NOISE, n, seed, size);
    say("%2u samples: error of a pixel %.4f (Sobol' %.4f), of 4 x 4 %.4f (%.4f), correlation %.2f (%.2f)", n, g.single,
        sobol.single, g.blurred, sobol.blurred, g.neighbours, sobol.neighbours);
    CHECK(g.blurred / g.single < 0.7 * sobol.blurred / sobol.single);
    CHECK(g.single < 2 * sobol.single, "pixels by themselves are as good, but share one scramble");
    CHECK(g.neighbours < -0.08);
    CHECK(fabs(sobol.neighbours) < 0.06, "the control: independent pixels have %g", sobol.neighbours);
    CHECK(fabs(sobol.blurred / sobol.single - 0.25) < 0.05, "the control: and blur like independent ones");
  }
}

/* --- mappings --- */

static double dot_d(const double a[3], const double b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Cosine and sine of the angle between an axis and a direction, the sine exact for small angles. */
static void angle(const float axis[3], const float d[3], double *cosine, double *sine) {
  double a[3], b[3], c[3];
  for (int k = 0; k < 3; k++) a[k] = (double)axis[k], b[k] = (double)d[k];
  for (int k = 0; k < 3; k++) c[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
  const double length = sqrt(dot_d(a, a) * dot_d(b, b));
  *cosine = dot_d(a, b) / length, *sine = sqrt(dot_d(c, c)) / length;
}

static void axis_of(uint32_t i, rng *r, float axis[3]) {
  static const float special[6][3] = {
      {0, 0, 1}, {0, 0, -1}, {1, 0, 0}, {0, -1, 0}, {1e-4f, 0, -1}, {-1e-9f, 1e-9f, -1}};
  float length = 0;
  while (!(length > 0.1f && length <= 1)) {
    for (int k = 0; k < 3; k++) axis[k] = rng_sign(r);
    length = sqrtf(dot3(axis, axis));
  }
  for (int k = 0; k < 3; k++) axis[k] = i < 6 ? special[i][k] : axis[k] / length;
}

static void check_unit(const float d[3], const char *what) {
  const double length = sqrt((double)d[0] * (double)d[0] + (double)d[1] * (double)d[1] + (double)d[2] * (double)d[2]);
  CHECK(fabs(length - 1) < 1e-6, "%s: length %.9g", what, length);
}

static void disk(void) {
  static const float middle[2] = {0.5f, 0.5f};
  tally x, y, squares, inner, square_r2;
  memset(&x, 0, sizeof x), memset(&y, 0, sizeof y), memset(&squares, 0, sizeof squares);
  memset(&inner, 0, sizeof inner), memset(&square_r2, 0, sizeof square_r2);
  rng r = rng_of(31);
  float p[2], q[2];
  for (size_t i = 0; i < scaled(200000); i++) {
    const float u[2] = {rng_unit(&r), rng_unit(&r)}, v[2] = {u[0] * 0.999f, u[1] * 0.999f};
    pktrt_map_disk(u, p);
    const double r2 = (double)p[0] * (double)p[0] + (double)p[1] * (double)p[1];
    CHECK(r2 <= 1 + 1e-6, "radius^2 %g", r2);
    tally_add(&x, (double)p[0]), tally_add(&y, (double)p[0] * (double)p[1]), tally_add(&squares, r2);
    tally_add(&inner, r2 < 0.25), tally_add(&square_r2, (double)(u[0] * u[0] + u[1] * u[1]));
    pktrt_map_disk(v, q);
    CHECK(hypotf(p[0] - q[0], p[1] - q[1]) < 3 * hypotf(u[0] - v[0], u[1] - v[1]) + 1e-5f, "neighbours are parted");
  }
  CHECK(tally_is(&x, 0) && tally_is(&y, 0), "%g, %g", tally_mean(&x), tally_mean(&y));
  CHECK(tally_is(&squares, 0.5) && tally_is(&inner, 0.25), "%g, %g", tally_mean(&squares), tally_mean(&inner));
  CHECK(!tally_is(&square_r2, 0.5), "the control: the square itself");
  pktrt_map_disk(middle, p);
  CHECK(p[0] == 0 && p[1] == 0, "the middle goes to the centre");
}

static void sphere_and_cosine(void) {
  tally sphere[6], cosine[4];
  memset(sphere, 0, sizeof sphere), memset(cosine, 0, sizeof cosine);
  rng r = rng_of(32);
  for (size_t i = 0; i < scaled(200000); i++) {
    const float u[2] = {rng_unit(&r), rng_unit(&r)};
    float d[3], axis[3];
    double c, s;
    pktrt_map_sphere(u, d);
    check_unit(d, "sphere");
    for (int k = 0; k < 3; k++) {
      tally_add(&sphere[k], (double)d[k]);
      tally_add(&sphere[k + 3], (double)d[k] * (double)d[k]);
    }
    axis_of((uint32_t)i, &r, axis);
    pktrt_map_cosine(u, axis, d);
    check_unit(d, "cosine");
    angle(axis, d, &c, &s);
    CHECK(c > -1e-6, "below the surface: %g", c);
    tally_add(&cosine[0], c), tally_add(&cosine[1], c * c), tally_add(&cosine[2], c > sqrt(0.5));
    tally_add(&cosine[3], fabs((double)d[2]));
  }
  for (int k = 0; k < 3; k++) CHECK(tally_is(&sphere[k], 0) && tally_is(&sphere[k + 3], 1.0 / 3), "sphere, axis %d", k);
  CHECK(tally_is(&cosine[0], 2.0 / 3) && tally_is(&cosine[1], 0.5) && tally_is(&cosine[2], 0.5), "cosine: %g, %g, %g",
      tally_mean(&cosine[0]), tally_mean(&cosine[1]), tally_mean(&cosine[2]));
  CHECK(!tally_is(&cosine[3], 2.0 / 3), "the control: another axis");
}

typedef void mapping(const float u[2], const float axis[3], float exponent, float out[3]);

/* Density (n + 1) / (2 pi) cos^n: the cosine has mean (n + 1) / (n + 2) and median 2^(-1 / (n + 1)), and the directions
   are even around the axis. 1 - cos = sin^2 / (1 + cos), for narrow lobes. */
static void lobe_moments(mapping *map, bool narrow, const char *what) {
  static const float exponents[6] = {0, 1, 10, 333.3f, 1e3f, 1e6f};
  for (int e = 0; e < (narrow ? 6 : 5); e++) {
    const double n = (double)exponents[e];
    tally below, half, side, wrong;
    memset(&below, 0, sizeof below), memset(&half, 0, sizeof half), memset(&side, 0, sizeof side);
    memset(&wrong, 0, sizeof wrong);
    rng r = rng_of(33 + (uint64_t)e);
    for (size_t i = 0; i < scaled(60000); i++) {
      const float u[2] = {rng_unit(&r), rng_unit(&r)};
      float axis[3], d[3];
      double c, s;
      axis_of((uint32_t)i, &r, axis);
      map(u, axis, exponents[e], d);
      check_unit(d, what);
      angle(axis, d, &c, &s);
      const double missing = c > 0 ? s * s / (1 + c) : 1 - c; /* 1 - cos */
      tally_add(&below, missing * (n + 2));
      tally_add(&half, log1p(-fmin(missing, 1 - 1e-9)) * (n + 1) > -log(2));
      tally_add(&wrong, missing * (n + 2) * 1.1);
      if (i < 6) continue;
      const float other[3] = {axis[1], axis[2], axis[0]}; /* a direction across, the same for all turns */
      const double along = (double)dot3(other, axis);
      tally_add(&side, ((double)dot3(other, d) - c * along) * sqrt(n + 2));
    }
    CHECK(tally_is(&below, 1), "%s, exponent %g: (n + 2) (1 - cos) is %g +- %g", what, n, tally_mean(&below),
        tally_error(&below));
    CHECK(tally_is(&half, 0.5), "%s, exponent %g: %g +- %g within the median", what, n, tally_mean(&half),
        tally_error(&half));
    CHECK(fabs(tally_mean(&side)) < 5 * tally_error(&side) + 2e-4, "%s, exponent %g: %g to one side", what, n,
        tally_mean(&side));
    CHECK(small_run || !tally_is(&wrong, 1), "the control: ten per cent wider");
  }
}

static void phong(void) {
  lobe_moments(pktrt_map_phong, true, "careful");
  lobe_moments(pktrt_map_phong_naive, false, "naive");
}

/* Of the direction for (u, 0) and the z axis, both components are known, and float must hold them to its last bit but
   one. The naive mapping takes the sine of a narrow lobe from its cosine. */
static void elementary(void) {
  static const float up[3] = {0, 0, 1};
  double worst = 0, naive = 0;
  rng r = rng_of(35);
  for (size_t i = 0; i < scaled(100000); i++) {
    const double bits = (double)rng_range(&r, -24, 0), power = (double)rng_range(&r, 0, 6);
    const float u[2] = {i % 2 ? rng_unit(&r) : (float)exp2(bits), 0}, exponent = i % 16 ? (float)pow(10, power) : 0;
    const float v[2] = {1 - u[0], 0};
    float d[3];
    if (!(u[0] > 0 && u[0] < 1)) continue;
    const double x = log1p(-(double)u[0]) / ((double)exponent + 1);
    pktrt_map_phong(u, up, exponent, d);
    worst = fmax(worst, fabs((double)d[2] / exp(x) - 1));
    worst = fmax(worst, fabs(hypot((double)d[0], (double)d[1]) / sqrt(-expm1(2 * x)) - 1));
    if (v[0] != 1) {
      const double y = log((double)v[0]) / ((double)exponent + 1), sine = sqrt(-expm1(2 * y));
      pktrt_map_phong_naive(v, up, exponent, d);
      CHECK(fabs((double)d[2] / exp(y) - 1) < 6.1e-8, "naive cosine");
      naive = fmax(naive, fabs(hypot((double)d[0], (double)d[1]) / sine - 1));
    }
  }
  say("largest error, of cosine and sine: %.2g of 5.96e-08", worst);
  CHECK(worst < 6.1e-8, "%g", worst);
  CHECK(small_run || naive > 1e-7, "the control: the naive sine errs by %g", naive);
}

static void turns(void) {
  static const float up[3] = {0, 0, 1};
  double worst = 0, radians = 0;
  rng r = rng_of(36);
  for (size_t i = 0; i < scaled(100000); i++) {
    const float u[2] = {0.5f, i < 9 ? (float)i / 8 * 0.99999994f : rng_unit(&r)};
    float d[3];
    pktrt_map_sphere(u, d); /* on the equator */
    const double s = sin(2 * PI * (double)u[1]), c = cos(2 * PI * (double)u[1]);
    worst = fmax(worst, fmax(fabs((double)d[0] - c), fabs((double)d[1] - s)));
    radians = fmax(radians, fabs((double)d[1] - (double)sinf(6.2831853f * u[1])));
    CHECK(d[2] == 0);
  }
  CHECK(worst < 3.1e-8, "%g", worst);
  CHECK(small_run || radians > 1e-7, "the control: radians in float, %g", radians);
  const float quarter[2] = {0.5f, 0.25f};
  float d[3];
  pktrt_map_cosine(quarter, up, d);
  CHECK(d[0] == 0 && d[1] > 0, "a quarter turn is exact");
}

static void origin(void) {
  static const float corner[2] = {0, 0}, exponents[5] = {0, 1, 10, 1e3f, 1e6f}, up[3] = {0, 0, 1};
  float axis[3], d[3];
  double c, s;
  rng r = rng_of(37);
  for (uint32_t i = 0; i < 200; i++) {
    axis_of(i, &r, axis);
    pktrt_map_cosine(corner, axis, d), angle(axis, d, &c, &s);
    CHECK(c > 0.999999 && s < 1e-3, "cosine: %g from the axis", s);
    for (int e = 0; e < 5; e++) {
      pktrt_map_phong(corner, axis, exponents[e], d), angle(axis, d, &c, &s);
      CHECK(c > 0.999999 && s < 1e-6, "exponent %g: %g from the axis", (double)exponents[e], s);
      pktrt_map_phong_naive(corner, axis, exponents[e], d), angle(axis, d, &c, &s);
      CHECK(fabs(c) < 1e-6, "the control: naive, exponent %g: perpendicular, not %g", (double)exponents[e], c);
    }
  }
  for (uint32_t i = 0; i < 1000; i++) { /* and nothing else of the square is perpendicular or below */
    const float u[2] = {i % 2 ? 1 - (float)i * 0x1p-24f : rng_unit(&r), rng_unit(&r)};
    pktrt_map_cosine(u, up, d);
    CHECK(d[2] > 0);
    for (int e = 0; e < 5; e++) {
      pktrt_map_phong(u, up, exponents[e], d);
      CHECK(d[2] > 0, "exponent %g, u %.9g", (double)exponents[e], (double)u[0]);
    }
  }
}

/* Neighbours: a step of 1/256 in the square moves a direction by no more than the square root of its area allows. The
   control is a map that tears: the same, half a turn on for the right half of the square. */
static void neighbours(void) {
  static const float up[3] = {0, 0, 1};
  float widest[4] = {0, 0, 0, 0}, torn = 0;
  for (int i = 0; i < 255 * 256; i++) {
    const float u[2] = {(float)(i / 256) / 256, (float)(i % 256) / 256};
    for (int step = 0; step < 2; step++) {
      const float v[2] = {u[0] + (step == 0) / 256.0f, fmodf(u[1] + (step == 1) / 256.0f, 1)}; /* round the turn too */
      for (int map = 0; map < 4; map++) {
        float a[3], b[3], apart[3];
        if (map == 0) pktrt_map_sphere(u, a), pktrt_map_sphere(v, b);
        else if (map == 1) pktrt_map_cosine(u, up, a), pktrt_map_cosine(v, up, b);
        else pktrt_map_phong(u, up, map == 2 ? 0 : 100, a), pktrt_map_phong(v, up, map == 2 ? 0 : 100, b);
        for (int k = 0; k < 3; k++) apart[k] = b[k] - a[k];
        widest[map] = fmaxf(widest[map], sqrtf(dot3(apart, apart)));
        if (map == 1 && (u[0] < 0.5f) != (v[0] < 0.5f)) {
          for (int k = 0; k < 2; k++) apart[k] = -b[k] - a[k];
          torn = fmaxf(torn, sqrtf(dot3(apart, apart)));
        }
      }
    }
  }
  for (int map = 0; map < 4; map++) CHECK(widest[map] < 0.15f, "mapping %d: %g", map, (double)widest[map]);
  CHECK(torn > 0.15f, "the control: %g", (double)torn);
}

static void odd_arguments(void) {
  static const float odd[6] = {0, 1, NAN, -1e30f, 0.99999994f, 1e-40f}, exponents[5] = {-1, NAN, INFINITY, 3e38f, 0};
  static const float axis[3] = {0.6f, 0, -0.8f};
  for (int i = 0; i < 36 * 5; i++) {
    const float u[2] = {odd[i % 6], odd[i / 6 % 6]}, exponent = exponents[i / 36];
    float d[3];
    pktrt_map_disk(u, d);
    CHECK(hypotf(d[0], d[1]) <= 1.000001f);
    pktrt_map_sphere(u, d), check_unit(d, "sphere");
    pktrt_map_cosine(u, axis, d), check_unit(d, "cosine");
    pktrt_map_phong(u, axis, exponent, d), check_unit(d, "careful");
    pktrt_map_phong_naive(u, axis, exponent, d), check_unit(d, "naive");
  }
}

/* --- the same bits everywhere --- */

static uint64_t fold(uint64_t hash, const float *x, int n) {
  for (int i = 0; i < n; i++) {
    uint32_t bits;
    memcpy(&bits, &x[i], sizeof bits);
    hash = mix64(hash ^ bits);
  }
  return hash;
}

/* One random number to a statement: the order of arguments is the compiler's. */
static uint64_t samples_hash(uint32_t seed) {
  uint64_t hash = 0;
  rng r = {1};
  for (int i = 0; i < 4000; i++) {
    const pktrt_sampling s = sampling(i % PKTRT_SAMPLER_COUNT, random_count(&r), seed);
    const uint32_t x = rng_below(&r, 65536);
    const uint32_t y = rng_below(&r, 65536);
    float u[9];
    pktrt_sample(&s, x, y, x * y % s.samples, y % 100, 9, u);
    hash = fold(hash, u, 9);
  }
  return hash;
}

static uint64_t mappings_hash(float scale) {
  uint64_t hash = 0;
  rng r = {2};
  for (int i = 0; i < 4000; i++) {
    static const float exponents[5] = {0, 1, 10, 1e3f, 1e6f};
    float u[2], axis[3], d[14];
    for (int k = 0; k < 2; k++) u[k] = rng_unit(&r) * scale, axis[k] = rng_sign(&r);
    axis[2] = 1;
    pktrt_map_disk(u, d), pktrt_map_sphere(u, d + 2), pktrt_map_cosine(u, axis, d + 5);
    pktrt_map_phong(u, axis, exponents[i % 5], d + 8), pktrt_map_phong_naive(u, axis, exponents[i % 5], d + 11);
    hash = fold(hash, d, 14);
  }
  return hash;
}

static void golden(void) {
  CHECK(samples_hash(7) == UINT64_C(0x58D186828C13B233), "samples: %016llx", (unsigned long long)samples_hash(7));
  CHECK(mappings_hash(1) == UINT64_C(0x6E50777F91CAAB35), "mappings: %016llx", (unsigned long long)mappings_hash(1));
  CHECK(samples_hash(7) != samples_hash(8) && mappings_hash(1) != mappings_hash(0.99999994f), "the control");
}

void suite_sampler(void) {
  run("samples lie in [0,1) and are uniform, for every sampler and dimension", uniform);
  run("samples are counter-based: one by one or together, in any order", counter_based);
  run("other seeds, pixels and dimensions give samples that are not related", unrelated);
  run("odd sampler settings give samples in range", out_of_range);
  run("numbers of samples out of range are the nearest within", clamped);
  run("Sobol' samples are nets in each pair of dimensions: one in every elementary interval", nets);
  run("a render takes the samples that pktrt_sample tells", in_renders);
  run("Sobol' points are nets in three dimensions, and in four with two points in a box", nets_of_four);
  run("samples of 4, 16, 64 pixels are one net, interleaved and as blue noise", nets_of_pixels);
  run("jittered samples have cells of their own", cells);
  run("Halton's and Hammersley's samples have strata of their own", strata);
  run("interleaved samples come again every four pixels, others do not", repeated);
  run("errors fall with the number of samples as they should", convergence);
  run("every sampler is unbiased over seeds", unbiased);
  run("groups of dimensions meet at random within a pixel", groups);
  run("blue noise: errors of neighbouring pixels cancel", blue);
  run("the disk is covered evenly, neighbours together", disk);
  run("sphere and cosine lobe have the moments of their densities", sphere_and_cosine);
  run("Phong lobes have the moments of their density, up to exponent 10^6", phong);
  run("exponentials and logarithms of a lobe agree with libm to the last bit of float", elementary);
  run("turns agree with libm to the last bit of float", turns);
  run("the origin maps to the axis; naively it is perpendicular", origin);
  run("directions of neighbours are neighbours", neighbours);
  run("odd arguments of mappings give unit directions", odd_arguments);
  run("samples and mappings have the same bits everywhere", golden);
}
