/* Check of chapter 10: the student's samples are stratified, in other orders everywhere; errors fall faster than those of
   random samples; and a picture is nearly as good as by Sobol' points. */
#define PKTRT_IMPLEMENTATION
#include "course.h"

enum { WIDTH = 48, HEIGHT = 36, PIXELS = WIDTH * HEIGHT, DIMENSIONS = 10, SIDE = 16, MOST = 256 };

float own_sample(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed);

/* What must not pass. */
static float random_sample(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  const pktrt_sampling sampling = {.sampler = PKTRT_SAMPLER_RANDOM, .samples = *(const uint32_t *)user, .seed = seed};
  float u;
  pktrt_sample(&sampling, x, y, sample, dimension, 1, &u);
  return u;
}

/* Whether each of n intervals holds one sample of each pixel and dimension. */
static bool is_stratified(pktrt_custom_sampler *sampler, uint32_t n, bool aloud) {
  for (uint32_t i = 0; i < 64 * DIMENSIONS; i++) {
    const uint32_t x = i % 8, y = i / 8 % 8, dimension = i / 64;
    int held[MOST];
    for (uint32_t k = 0; k < n; k++) held[k] = -1;
    for (uint32_t k = 0; k < n; k++) {
      const float u = sampler(&n, x, y, k, dimension, 3);
      const uint32_t interval = u >= 0 && u < 1 ? (uint32_t)(u * (float)n) : n;
      if (interval < n && held[interval] < 0) {
        held[interval] = (int)k;
        continue;
      }
      if (aloud)
        printf(
            "%u samples, pixel (%u, %u), dimension %u: ", (unsigned)n, (unsigned)x, (unsigned)y, (unsigned)dimension);
      if (aloud && interval == n) printf("sample %u is %.9g\n  expected: a number in [0,1)\n", (unsigned)k, (double)u);
      else if (aloud)
        printf("samples %d and %u lie in [%u/%u, %u/%u)\n  expected: one in each interval\n  got: %.9g and %.9g\n",
            held[interval], (unsigned)k, (unsigned)interval, (unsigned)n, (unsigned)interval + 1, (unsigned)n,
            (double)sampler(&n, x, y, (uint32_t)held[interval], dimension, 3), (double)u);
      return false;
    }
  }
  return true;
}

/* The RMSE over pixels of the mean of exp(u), or if another dimension is given of exp(u + v). */
static double smooth_error(pktrt_custom_sampler *sampler, uint32_t n, uint32_t first, uint32_t second) {
  const double truth = first == second ? exp(1) - 1 : pow(exp(1) - 1, 2);
  double squares = 0;
  for (uint32_t i = 0; i < SIDE * SIDE; i++) {
    double sum = 0;
    for (uint32_t k = 0; k < n; k++) {
      const float u = sampler(&n, i % SIDE, i / SIDE, k, first, 5);
      sum += exp((double)u + (first == second ? 0 : (double)sampler(&n, i % SIDE, i / SIDE, k, second, 5)));
    }
    squares += pow(sum / n - truth, 2);
  }
  return sqrt(squares) / SIDE;
}

/* The slope of the line through the logarithms of errors, over those of 4 to 256 samples. */
static double smooth_slope(pktrt_custom_sampler *sampler) {
  double sum = 0, weight = 0;
  for (int k = 2; k <= 8; k++) {
    sum += (k - 5) * log2(smooth_error(sampler, 1u << k, 0, 0));
    weight += (k - 5) * (k - 5);
  }
  return sum / weight;
}

/* Whether pairs of dimensions fill the square: an error far below that of random samples in each of them. Says which of the
   pairs is worst. */
static bool fills_squares(void) {
  const double most = 0.6; /* of the error of random samples */
  double worst = 0, worst_random = 1;
  int pair = 0;
  static const uint32_t pairs[][2] = {{0, 1}, {2, 3}, {0, 2}, {1, 2}, {3, 4}, {0, 7}};
  for (int i = 0; i < 6; i++) {
    const double mine = smooth_error(own_sample, 64, pairs[i][0], pairs[i][1]);
    const double random = smooth_error(random_sample, 64, pairs[i][0], pairs[i][1]);
    if (mine / random > worst / worst_random) worst = mine, worst_random = random, pair = i;
  }
  const bool good = worst <= most * worst_random;
  printf("dimensions %u and %u together, the worst pair, 64 samples: RMSE %.4f\n", (unsigned)pairs[pair][0],
      (unsigned)pairs[pair][1], worst);
  printf("  %s: at most %.4f (%.1f times %.4f of random samples)\n", good ? "wanted" : "expected", most * worst_random,
      most, worst_random);
  return good;
}

/* The student's, but for pixels and seeds, which it does not look at: must not pass for different. */
static float same_sample(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  (void)x, (void)y, (void)seed;
  return own_sample(user, 3, 3, sample, dimension, 3);
}

/* Whether a sample lies in another interval in the pixel to the right, in that below, and by another seed, and at another
   place in it; by chance it may be the same now and then. */
static bool is_different(pktrt_custom_sampler *sampler, bool aloud) {
  static const char *const whom[] = {"the pixel to the right", "the pixel below", "another seed"};
  uint32_t n = 64;
  for (uint32_t other = 0; other < 3; other++)
    for (uint32_t dimension = 0; dimension < DIMENSIONS; dimension++) {
      uint32_t intervals = 0, places = 0;
      for (uint32_t i = 0; i < 16 * n; i++) {
        const uint32_t x = i / n % 4, y = i / n / 4;
        const double a = (double)sampler(&n, x, y, i % n, dimension, 5) * n;
        const double b =
            (double)sampler(&n, x + (other == 0), y + (other == 1), i % n, dimension, 5 + (other == 2)) * n;
        intervals += floor(a) == floor(b), places += fabs(a - floor(a) - (b - floor(b))) < 1e-3;
      }
      if (intervals < 2 * n && places < 2 * n) continue; /* of 16 n; by chance some 16 and 2 */
      if (aloud)
        printf(
            "%u samples, dimension %u: %u of %u lie in the same interval and %u at the same place of theirs as in %s\n"
            "  expected: fewer than %u\n",
            (unsigned)n, (unsigned)dimension, (unsigned)intervals, 16 * (unsigned)n, (unsigned)places, whom[other],
            2 * (unsigned)n);
      return false;
    }
  return true;
}

static void render(pktrt_scene *scene, int sampler, uint32_t samples, uint32_t passes, uint32_t seed, vec *pixels) {
  const pktrt_camera camera = {.eye = {2.7f, 4.1f, 7.3f}, .target = {0.1f, 1.2f, -0.1f}, .fov_y = 39.6f};
  pktrt_render_desc view = {.width = WIDTH, .height = HEIGHT, .pixels = pixels[0].at, .mode = PKTRT_MODE_DRT};
  view.camera = camera, view.background[0] = 0.3f, view.ambient[0] = 0.05f;
  view.samples = samples, view.passes = passes, view.seed = seed;
  view.sampler = (pktrt_sampler)sampler, view.custom_sampler = own_sample, view.user = &samples;
  if (pktrt_render(scene, &view)) ex_fail("%s", pktrt_last_error(scene)), exit(1);
}

/* The RMSE of a picture's first channel with 16 samples, over some seeds. */
static double picture_error(pktrt_scene *scene, int sampler, const vec *truth) {
  enum { SEEDS = 4 };
  static vec pixels[PIXELS];
  double squares = 0;
  for (uint32_t seed = 0; seed < SEEDS; seed++) {
    render(scene, sampler, 16, 1, seed, pixels);
    for (int i = 0; i < PIXELS; i++) squares += pow((double)pixels[i].at[0] - (double)truth[i].at[0], 2);
  }
  return sqrt(squares / SEEDS / PIXELS);
}

static const char *check(pktrt_scene *scene) {
  static vec truth[PIXELS];
  if (is_stratified(random_sample, 16, false)) return "the control passes: random samples are stratified here";
  for (uint32_t n = 1; n <= MOST; n *= 4)
    if (!is_stratified(own_sample, n, true)) return "samples are not stratified";
  printf("each of n intervals holds one sample, n = 1 to %d, in all of %d dimensions\n", MOST, DIMENSIONS);
  const double slope = smooth_slope(own_sample), slope_random = smooth_slope(random_sample);
  printf("slope of errors on a smooth function: yours %.2f, random %.2f, wanted %.2f or less\n", slope, slope_random,
      -0.9);
  course_figure("slope.random", "%.2f", slope_random);
  if (slope_random <= -0.9) return "the control passes: random samples are as good here";
  if (!(slope <= -0.9)) return "errors fall too slowly";
  if (!fills_squares()) return "dimensions are not independent of each other";
  if (is_different(same_sample, false)) return "the control passes: the same samples everywhere are different here";
  if (!is_different(own_sample, true)) return "pixels or seeds share their samples";
  printf("samples lie in other intervals, and elsewhere in them, in neighbouring pixels and by another seed\n");
  render(scene, PKTRT_SAMPLER_SOBOL, 256, 8, 99, truth);
  const double mine = picture_error(scene, PKTRT_SAMPLER_CUSTOM, truth);
  const double sobol = picture_error(scene, PKTRT_SAMPLER_SOBOL, truth),
               random = picture_error(scene, PKTRT_SAMPLER_RANDOM, truth);
  printf(
      "RMSE of a picture: yours %.5f, Sobol' points %.5f, random %.5f: %.2f and %.2f of Sobol's, wanted 1.3 or less\n",
      mine, sobol, random, mine / sobol, random / sobol);
  course_figure("random-over-sobol", "%.2f", random / sobol);
  if (random <= 1.3 * sobol) return "the control passes: random samples are as good in this picture";
  return mine <= 1.3 * sobol ? NULL : "the picture is too noisy";
}

int main(void) {
  const pktrt_light lamp = {
      .kind = PKTRT_LIGHT_QUAD, .position = {-5, 7, 0}, .edge = {{4, 0, 0}, {0, 0, 4}}, .intensity = {6, 6, 6}};
  course_scene s = course_scene_make();
  pktrt_scene *scene = course_library(&s);
  if (pktrt_add_light(scene, &lamp, NULL)) ex_fail("%s", pktrt_last_error(scene)), exit(1);
  const char *why = check(scene);
  pktrt_scene_destroy(scene);
  return course_result(10, why);
}
