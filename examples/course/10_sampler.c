/* Chapter 10: samplers, one of one's own among them, and how the error of a picture falls with samples.

   Prints errors, slopes, times, and a render's own estimate beside the truth; makes out/course/10_noise.png, 10_error.svg. */
#define PKTRT_IMPLEMENTATION
#include "10_figures.h"

/* [hash] */
/* Folds another number into a hash; its bits depend on all bits of both. */
static uint32_t hash(uint32_t h, uint32_t value) {
  h = (h ^ value) * 0x9E3779B1u;
  h = (h ^ h >> 15) * 0x85EBCA77u;
  return h ^ h >> 13;
}
/* [end] */

/* [custom] */
/* An additive recurrence: each sample is an irrational step beyond the one before, round a circle, from a start of its own for
   each pixel and dimension. Steps: 2^32 times the fractional parts of the square roots of the first eight primes. */
static float additive(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  static const uint32_t steps[8] = {
      0x6A09E667u, 0xBB67AE85u, 0x3C6EF372u, 0xA54FF53Au, 0x510E527Fu, 0x9B05688Cu, 0x1F83D9ABu, 0x5BE0CD19u};
  (void)user;
  const uint32_t start = hash(hash(hash(seed, x), y), dimension);
  return (float)((start + sample * steps[dimension % 8]) >> 8) / 16777216.0f;
}
/* [end] */

/* Another sampler for comparison: the n intervals of each dimension hold one sample each, in an order that is shuffled for
   each pixel and dimension. */
static float shuffled(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  const uint32_t n = *(const uint32_t *)user;
  uint32_t order[256];
  uint32_t state = hash(hash(hash(seed, x), y), dimension);
  for (uint32_t i = 0; i < n; i++) order[i] = i;
  for (uint32_t i = n - 1; i > 0; i--) {
    state = hash(state, i);
    const uint32_t other = (uint32_t)((uint64_t)state * (i + 1) >> 32);
    const uint32_t swapped = order[i];
    order[i] = order[other];
    order[other] = swapped;
  }
  const float inside = (float)(hash(state, sample) >> 8) / 16777216.0f;
  return fminf(((float)order[sample] + inside) / (float)n, 1 - 1 / 16777216.0f);
}

/* Makes the course's scene under a large lamp: a pixel is an integral over four dimensions. */
static pktrt_scene *make_scene(void) {
  const pktrt_light lamp = {
      .kind = PKTRT_LIGHT_QUAD, .position = {-5, 7, 0}, .edge = {{4, 0, 0}, {0, 0, 4}}, .intensity = {6, 6, 6}};
  course_scene s = course_scene_make();
  pktrt_scene *scene = course_library(&s);
  if (pktrt_add_light(scene, &lamp, NULL)) {
    ex_fail("%s", pktrt_last_error(scene));
    exit(1);
  }
  return scene;
}

/* Renders a picture of the scene by one of the samplers. */
static void render(pktrt_scene *scene, pktrt_render_desc *view, int sampler) {
  const pktrt_camera camera = {.eye = {2.7f, 4.1f, 7.3f}, .target = {0.1f, 1.2f, -0.1f}, .fov_y = 39.6f};
  view->camera = camera;
  view->mode = PKTRT_MODE_DRT;
  view->sampler = (pktrt_sampler)sampler;
  if (!view->custom_sampler) view->custom_sampler = additive;
  for (int c = 0; c < 3; c++) {
    view->background[c] = 0.3f;
    view->ambient[c] = 0.05f;
  }
  if (pktrt_render(scene, view)) {
    ex_fail("%s", pktrt_last_error(scene));
    exit(1);
  }
}

/* Makes a picture of four samples per pixel by each sampler, in two rows, with each pixel as SCALE x SCALE pixels. */
static void noise(pktrt_scene *scene) {
  enum { SCALE = 3, COLUMNS = 4, TILE_WIDTH = SCALE * NOISE_WIDTH, TILE_HEIGHT = SCALE * NOISE_HEIGHT };
  static vec pixels[NOISE_WIDTH * NOISE_HEIGHT];
  course_picture all = course_picture_make(COLUMNS * TILE_WIDTH, SAMPLERS / COLUMNS * TILE_HEIGHT);
  for (int s = 0; s < SAMPLERS; s++) {
    pktrt_render_desc view = {.width = NOISE_WIDTH, .height = NOISE_HEIGHT, .pixels = pixels[0].at, .samples = 4};
    render(scene, &view, s);
    vec *tile = &all.pixel[s / COLUMNS * TILE_HEIGHT * COLUMNS * TILE_WIDTH + s % COLUMNS * TILE_WIDTH];
    for (int y = 0; y < TILE_HEIGHT; y++)
      for (int x = 0; x < TILE_WIDTH; x++)
        tile[y * COLUMNS * TILE_WIDTH + x] = pixels[y / SCALE * NOISE_WIDTH + x / SCALE];
  }
  course_picture_write(&all, "out/course/10_noise.png");
}

/* Renders a small picture with some seeds; returns its RMSE against the truth, of one channel, since all is grey. */
static double error_of(pktrt_scene *scene, int sampler, pktrt_render_desc view, uint32_t seeds, const vec *truth) {
  static vec pixels[PIXELS];
  double sum = 0;
  view.width = WIDTH;
  view.height = HEIGHT;
  view.pixels = pixels[0].at;
  for (view.seed = 0; view.seed < seeds; view.seed++) {
    render(scene, &view, sampler);
    for (int i = 0; i < PIXELS; i++) sum += pow((double)pixels[i].at[0] - (double)truth[i].at[0], 2);
  }
  return sqrt(sum / PIXELS / seeds);
}

/* Prints figures of the errors of all samplers and of the ratios in the text. */
static void print_figures(pktrt_scene *scene, double error[SAMPLERS][STEPS], const vec *truth) {
  for (int s = 0; s < SAMPLERS; s++) {
    char name[64];
    for (int k = 0; k < STEPS; k++) figure(name_of(s), 1u << 2 * k, "", "%.5f", error[s][k]);
    snprintf(name, sizeof name, "%s.slope", name_of(s));
    course_figure(name, "%.2f", slope_of(error[s]));
  }
  for (uint32_t samples = 4; samples <= 256; samples *= 4) {
    const pktrt_render_desc view = {.samples = samples, .custom_sampler = shuffled, .user = &samples};
    figure("shuffled", samples, "", "%.4f", error_of(scene, PKTRT_SAMPLER_CUSTOM, view, 4, truth));
  }
  for (int k = 1; k < STEPS; k++) /* in percent */
    figure("ours-over-jittered", 1u << 2 * k, "", "%.0f",
        100 * (error[PKTRT_SAMPLER_COUNT][k] / error[PKTRT_SAMPLER_JITTERED][k] - 1));
}

int main(void) {
  static vec truth[PIXELS];
  double error[SAMPLERS][STEPS], passes[STEPS] = {0}, estimate[STEPS] = {0}, least = INFINITY;
  double samples[SAMPLERS][STEPS], ms[SAMPLERS][STEPS];
  int held = 0; /* intervals that hold the true error */
  pktrt_scene *scene = make_scene();
  pktrt_render_desc view = {
      .width = WIDTH, .height = HEIGHT, .pixels = truth[0].at, .samples = 256, .passes = 16, .seed = 99};
  noise(scene);
  render(scene, &view, PKTRT_SAMPLER_SOBOL);
  printf("RMSE with 1, 4, 16, 64, 256 samples; slope; seconds for 256\n");
  for (int s = 0; s < SAMPLERS; s++) {
    printf("  %-12s", name_of(s));
    for (int k = 0; k < STEPS; k++) {
      const double start = ex_seconds();
      error[s][k] = error_of(scene, s, (pktrt_render_desc){.samples = 1u << 2 * k}, 4, truth);
      samples[s][k] = pow(4, k);
      ms[s][k] = 1000 * (ex_seconds() - start) / 4;
      least = fmin(least, ms[s][k]);
      printf(" %.5f", error[s][k]);
    }
    printf(" %6.2f %6.2f s\n", slope_of(error[s]), ms[s][STEPS - 1] / 1000);
  }
  print_figures(scene, error, truth);
  printf("Sobol' points in four passes: true RMSE, and the render's own estimate with its interval\n");
  for (int k = 1; k < STEPS; k++) {
    pktrt_report report;
    const pktrt_render_desc of = {.samples = 1u << 2 * (k - 1), .passes = 4, .report = &report};
    passes[k] = error_of(scene, PKTRT_SAMPLER_SOBOL, of, 1, truth);
    estimate[k] = report.rmse;
    const bool inside = report.rmse_low <= passes[k] && passes[k] <= report.rmse_high;
    held += inside ? 1 : 0;
    printf("  %3d samples: %.5f, estimated %.5f, %.5f to %.5f\n", 1 << 2 * k, passes[k], report.rmse, report.rmse_low,
        report.rmse_high);
    figure("passes", 1u << 2 * k, "true", "%.5f", passes[k]);
    figure("passes", 1u << 2 * k, "estimate", "%.5f", estimate[k]);
    figure("passes", 1u << 2 * k, "loss", "%.2f", passes[k] / error[PKTRT_SAMPLER_SOBOL][k]);
    figure("passes", 1u << 2 * k, "low", "%.5f", report.rmse_low);
    figure("passes", 1u << 2 * k, "high", "%.5f", report.rmse_high);
  }
  course_figure("passes.held", "%d", held);
  plot("out/course/10_error.svg", "RMSE over samples; brown: four passes", 1, samples, error, passes, estimate);
  plot("out/course/10_time.svg", "RMSE over milliseconds of a picture", least, ms, error, NULL, NULL);
  pktrt_scene_destroy(scene);
  return 0;
}
