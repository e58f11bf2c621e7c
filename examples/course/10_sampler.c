/* Chapter 10: samplers, one of one's own among them, and how the error of a picture falls with samples.

   Prints errors, slopes, times, and a render's own estimate beside the truth; makes out/course/10_noise.png, 10_error.svg. */
#define PKTRT_IMPLEMENTATION
#include "course.h"
#include "../svg.h"

enum { SAMPLERS = PKTRT_SAMPLER_COUNT + 1, STEPS = 5 }; /* those of the library and ours; 1, 4, ... 256 samples */
enum { WIDTH = 48, HEIGHT = 36, PIXELS = WIDTH * HEIGHT, NOISE_WIDTH = 72, NOISE_HEIGHT = 54 };

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

static const char *name_of(int sampler) {
  return sampler < PKTRT_SAMPLER_COUNT ? pktrt_sampler_string((pktrt_sampler)sampler) : "additive";
}

/* The course's scene under a lamp of some size: a pixel is an integral over four dimensions. */
static pktrt_scene *make_scene(void) {
  const pktrt_light lamp = {
      .kind = PKTRT_LIGHT_QUAD, .position = {-5, 7, 0}, .edge = {{4, 0, 0}, {0, 0, 4}}, .intensity = {6, 6, 6}};
  course_scene s = course_scene_make();
  pktrt_scene *scene = course_library(&s);
  if (pktrt_add_light(scene, &lamp, NULL)) ex_fail("%s", pktrt_last_error(scene)), exit(1);
  return scene;
}

static void render(pktrt_scene *scene, pktrt_render_desc *view, int sampler) {
  const pktrt_camera camera = {.eye = {2.7f, 4.1f, 7.3f}, .target = {0.1f, 1.2f, -0.1f}, .fov_y = 39.6f};
  view->camera = camera, view->mode = PKTRT_MODE_DRT;
  view->sampler = (pktrt_sampler)sampler, view->custom_sampler = additive;
  for (int c = 0; c < 3; c++) view->background[c] = 0.3f, view->ambient[c] = 0.05f;
  if (pktrt_render(scene, view)) ex_fail("%s", pktrt_last_error(scene)), exit(1);
}

/* Pictures of four samples per pixel side by side, twice as large: the samplers as the eye sees them. */
static void noise(pktrt_scene *scene) {
  static vec pixels[NOISE_WIDTH * NOISE_HEIGHT];
  course_picture all = course_picture_make(8 * NOISE_WIDTH, SAMPLERS / 4 * 2 * NOISE_HEIGHT);
  for (int s = 0; s < SAMPLERS; s++) {
    pktrt_render_desc view = {.width = NOISE_WIDTH, .height = NOISE_HEIGHT, .pixels = pixels[0].at, .samples = 4};
    render(scene, &view, s);
    for (int y = 0; y < 2 * NOISE_HEIGHT; y++)
      for (int x = 0; x < 2 * NOISE_WIDTH; x++)
        all.pixel[((s / 4 * 2 * NOISE_HEIGHT) + y) * 8 * NOISE_WIDTH + s % 4 * 2 * NOISE_WIDTH + x] =
            pixels[y / 2 * NOISE_WIDTH + x / 2];
  }
  course_picture_write(&all, "out/course/10_noise.png");
}

/* Renders a small picture with some seeds; returns its RMSE against the truth, of one channel, since all is grey. */
static double error_of(pktrt_scene *scene, int sampler, pktrt_render_desc view, uint32_t seeds, const vec *truth) {
  static vec pixels[PIXELS];
  double sum = 0;
  view.width = WIDTH, view.height = HEIGHT, view.pixels = pixels[0].at;
  for (view.seed = 0; view.seed < seeds; view.seed++) {
    render(scene, &view, sampler);
    for (int i = 0; i < PIXELS; i++) sum += pow((double)pixels[i].at[0] - (double)truth[i].at[0], 2);
  }
  return sqrt(sum / PIXELS / seeds);
}

/* The slope of the line through the logarithms of errors over those of samples: least squares, in steps of log 4. */
static double slope_of(const double error[STEPS]) {
  double sum = 0, weight = 0;
  for (int k = 1; k < STEPS; k++) { /* one sample lies at random for all: it is left out */
    const double at = k - 0.5 * STEPS;
    sum += at * log(error[k]), weight += at * at;
  }
  return sum / weight / log(4);
}

/* Plots errors over what they took, by factors of four from `least` on. passes NULL: there are none. */
static void plot(const char *path, const char *title, double least, double x[SAMPLERS][STEPS],
    double error[SAMPLERS][STEPS], const double *passes, const double *estimate) {
  static const char *const colors[SAMPLERS] = {"#d33", "#888", "#d90", "#393", "#27c", "#0aa", "#93c", "#000"};
  svg s;
  if (!svg_begin(&s, path, 580, 380)) exit(1);
#define PLOT_X(x) (60 + 80 * log2((x) / least) / 2)
#define PLOT_Y(e) (30.0 - 70.0 * log2((e) / 0.25) / 2)
  for (int k = 0; k < STEPS; k++) {
    const double at = 60 + 80 * k, y = 30 + 70 * k;
    svg_line(&s, at, 20, at, 350, "#ddd", 1), svg_line(&s, 60, y, 430, y, "#ddd", 1);
    svg_text(&s, at, 368, 12, SVG_MIDDLE, "%.3g", least * pow(4, k));
    svg_text(&s, 54, y + 4, 12, SVG_RIGHT, "%.4f", pow(0.25, k + 1));
  }
  for (int i = 0; i < SAMPLERS; i++) {
    for (int k = 1; k < STEPS; k++)
      svg_line(&s, PLOT_X(x[i][k - 1]), PLOT_Y(error[i][k - 1]), PLOT_X(x[i][k]), PLOT_Y(error[i][k]), colors[i], 1.5);
    svg_line(&s, 440, 40 + 18 * i, 460, 40 + 18 * i, colors[i], 1.5),
        svg_text(&s, 466, 44 + 18 * i, 12, SVG_LEFT, "%s", name_of(i));
  }
  for (int k = 1; passes && k < STEPS; k++) {
    svg_dot(&s, PLOT_X(x[0][k]), PLOT_Y(estimate[k]), 4, "#730");
    if (k > 1) svg_line(&s, PLOT_X(x[0][k - 1]), PLOT_Y(passes[k - 1]), PLOT_X(x[0][k]), PLOT_Y(passes[k]), "#730", 1);
  }
  svg_text(&s, 240, 14, 12, SVG_MIDDLE, "%s", title);
  if (!svg_end(&s)) exit(1);
}

int main(void) {
  static vec truth[PIXELS];
  double error[SAMPLERS][STEPS], passes[STEPS] = {0}, estimate[STEPS] = {0}, least = INFINITY;
  double samples[SAMPLERS][STEPS], ms[SAMPLERS][STEPS];
  pktrt_scene *scene = make_scene();
  pktrt_render_desc view = {
      .width = WIDTH, .height = HEIGHT, .pixels = truth[0].at, .samples = 256, .passes = 16, .seed = 99};
  noise(scene), render(scene, &view, PKTRT_SAMPLER_SOBOL);
  printf("RMSE with 1, 4, 16, 64, 256 samples; slope; seconds for 256\n");
  for (int s = 0; s < SAMPLERS; s++) {
    printf("  %-12s", name_of(s));
    for (int k = 0; k < STEPS; k++) {
      const double start = ex_seconds();
      error[s][k] = error_of(scene, s, (pktrt_render_desc){.samples = 1u << 2 * k}, 4, truth);
      samples[s][k] = pow(4, k), ms[s][k] = 1000 * (ex_seconds() - start) / 4, least = fmin(least, ms[s][k]);
      printf(" %.5f", error[s][k]);
    }
    printf(" %6.2f %6.2f s\n", slope_of(error[s]), ms[s][STEPS - 1] / 1000);
  }
  printf("Sobol' points in four passes: true RMSE, and the render's own estimate with its interval\n");
  for (int k = 1; k < STEPS; k++) {
    pktrt_report report;
    const pktrt_render_desc of = {.samples = 1u << 2 * (k - 1), .passes = 4, .report = &report};
    passes[k] = error_of(scene, PKTRT_SAMPLER_SOBOL, of, 1, truth), estimate[k] = report.rmse;
    printf("  %3d samples: %.5f, estimated %.5f, %.5f to %.5f\n", 1 << 2 * k, passes[k], report.rmse, report.rmse_low,
        report.rmse_high);
  }
  plot("out/course/10_error.svg", "RMSE over samples; brown: four passes", 1, samples, error, passes, estimate);
  plot("out/course/10_time.svg", "RMSE over milliseconds of a picture", least, ms, error, NULL, NULL);
  pktrt_scene_destroy(scene);
  return 0;
}
