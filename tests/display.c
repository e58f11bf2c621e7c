/* PKTRT_ERROR_DISPLAY: the curve of the screen, the jackknife over passes, estimates against the truth, sums made in
   several places, what is refused, and what it costs. */
#include "pictures.h"

enum { W = 40, H = 36, PIXELS = W * H, EDGE = PKTRT_ERROR_BLOCK, COLUMNS = 3, ROWS = 3, BLOCKS = COLUMNS * ROWS };

/* Returns the sRGB value in [0,1] that a screen shows, by pow. */
static double shown_by_pow(double v, double exposure, bool curve) {
  v *= exposure;
  if (curve && v > 0) v = v < 4 ? v * (1 + v / 16) / (1 + v) : 1;
  if (!(v > 0)) return 0;
  if (v >= 1) return 1;
  return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
}

/* All that pktrt_finish_passes writes of passes that were made up. */
typedef struct sheet {
  float pixels[PIXELS * 3], pixel_error[PIXELS], block_error[BLOCKS];
  pktrt_report report;
} sheet;

static pktrt_render_desc sheet_view(sheet *to, uint32_t passes) {
  memset(to, 0xC1, sizeof *to);
  pktrt_render_desc d = stage_view(PKTRT_MODE_RCS, W, H, to->pixels, vec_of(0, 0, 5), vec_of(0, 0, 0));
  d.pixel_error = to->pixel_error;
  d.block_error = to->block_error;
  d.report = &to->report;
  d.passes = passes;
  d.measure = PKTRT_ERROR_DISPLAY;
  return d;
}

/* Finishes passes whose means are values[pass * PIXELS + pixel], in all channels. */
static void finish_values(pktrt_scene *s, pktrt_render_desc *d, uint32_t passes, const double *values) {
  static pktrt_pixel_sums sums[PIXELS];
  static pktrt_display_sums display[PIXELS];
  memset(sums, 0, sizeof sums);
  memset(display, 0, sizeof display);
  for (size_t i = 0; i < (size_t)passes * PIXELS; i++) {
    const double mean[3] = {values[i], values[i], values[i]};
    pktrt_add_pass(mean, 1, &sums[i % PIXELS]);
    pktrt_add_display_pass(mean, 1, &display[i % PIXELS]);
  }
  d->display_sums = display;
  CHECK(pktrt_finish_passes(s, d, passes, sums) == PKTRT_OK, "%s", pktrt_last_error(s));
  d->display_sums = NULL;
}

/* The squared error of a channel by the jackknife that leaves out each pass in turn. */
static double jackknife(const double *values, uint32_t n, size_t pixel, double exposure, bool curve) {
  double sum = 0, error = 0;
  for (uint32_t k = 0; k < n; k++) sum += values[k * PIXELS + pixel];
  const double all = shown_by_pow(sum / n, exposure, curve);
  for (uint32_t k = 0; k < n; k++) {
    const double without = shown_by_pow((sum - values[k * PIXELS + pixel]) / (n - 1), exposure, curve) - all;
    error += without * without * (n - 1) / n;
  }
  return error;
}

/* A number in [0,1) for each i, by a multiplicative hash. */
static double scattered(size_t i) { return (double)((uint32_t)(i * 2654435761u + 12345u) * 1664525u >> 8) / 16777216; }

/* Two and three passes: the kinds of passes are the passes themselves, so errors are those of the jackknife. Values go
   from black to far above white. Without the curve, or with another exposure, they would be others. */
static void the_jackknife(void) {
  static double values[3 * PIXELS];
  static sheet got;
  pktrt_scene *s = stage_open();
  for (size_t i = 0; i < 3 * PIXELS; i++) {
    const double scale = pow(10, (double)(i % PIXELS) / PIXELS * 5 - 4); /* 1e-4 to 10 */
    values[i] = scale * scattered(i) * (i % 7 == 0 ? 5 : 1);
  }
  for (uint32_t n = 2; n <= 3; n++)
    for (int k = 0; k < 4; k++) {
      const bool curve = k % 2 != 0;
      const double exposure = k / 2 ? 2.5 : 1;
      pktrt_render_desc d = sheet_view(&got, n);
      double sum = 0, block = 0;
      size_t wrong = 0, other = 0;
      d.display_tone = curve ? PKTRT_TONE_CURVE : PKTRT_TONE_CLAMP;
      d.display_exposure = k / 2 ? 2.5f : 0;
      finish_values(s, &d, n, values);
      for (size_t i = 0; i < PIXELS; i++) {
        const double want = jackknife(values, n, i, exposure, curve);
        const double got_error = (double)got.pixel_error[i];
        wrong += !(fabs(got_error - sqrt(want)) <= 1e-4); /* twice the error of the curve */
        other += fabs(got_error - sqrt(jackknife(values, n, i, 1.25 * exposure, curve))) > 1e-4;
        sum += want;
        if (i / W < EDGE && i % W < EDGE) block += want;
      }
      CHECK(wrong == 0, "%u passes, case %d: %zu pixels are wrong", n, k, wrong);
      CHECK(other > PIXELS / 3, "the control: another exposure, %zu pixels", other);
      CHECK(fabs(got.report.display_error - sqrt(sum / PIXELS)) < 1e-4, "%g", got.report.display_error);
      CHECK(fabs((double)got.block_error[0] - sqrt(block / (EDGE * EDGE))) < 1e-4, "%g", (double)got.block_error[0]);
      CHECK(got.report.display_error_low < got.report.display_error, "the interval");
      CHECK(got.report.display_error_high > got.report.display_error, "the interval");
    }
  pktrt_scene_destroy(s);
}

/* More passes, most of them alike, one in four a hundred times brighter: the jackknife of all passes within 5%. */
static void many_passes(void) {
  enum { MOST = 32 };
  static double values[MOST * PIXELS];
  static sheet got;
  pktrt_scene *s = stage_open();
  for (size_t i = 0; i < MOST * PIXELS; i++)
    values[i] = 0.2 * scattered(i) * (scattered(i + 999983) < 1.0 / MOST ? 100 : 1);
  for (uint32_t n = 4; n <= MOST; n *= 2) {
    double sum = 0;
    pktrt_render_desc d = sheet_view(&got, n);
    finish_values(s, &d, n, values);
    for (size_t i = 0; i < PIXELS; i++) sum += jackknife(values, n, i, 1, false);
    const double ratio = got.report.display_error / sqrt(sum / PIXELS);
    CHECK(ratio > 0.95 && ratio < 1.05, "%u passes: %g of the jackknife", n, ratio);
  }
  pktrt_scene_destroy(s);
}

/* What is white on the screen, black, or the same in all passes has no error as shown. */
static void nothing_to_see(void) {
  static double values[4 * PIXELS];
  static sheet got;
  pktrt_scene *s = stage_open();
  for (int kind = 0; kind < 4; kind++) {
    pktrt_render_desc d = sheet_view(&got, 4);
    for (size_t i = 0; i < 4 * PIXELS; i++)
      values[i] = kind == 0   ? 2 + scattered(i)
                  : kind == 1 ? -scattered(i)
                  : kind == 2 ? scattered(i % PIXELS)
                              : 0.5 * scattered(i);
    finish_values(s, &d, 4, values);
    CHECK((got.report.display_error < 1e-7) == (kind < 3), "kind %d: %g", kind, got.report.display_error);
    CHECK((got.report.rmse > 0.01) == (kind != 2), "kind %d: the control: linear errors, %g", kind, got.report.rmse);
    if (kind == 3) continue;
    CHECK(got.report.display_error == 0 && got.pixel_error[0] == 0 && got.block_error[0] == 0, "kind %d", kind);
    CHECK(!got.report.unreliable[PKTRT_ERROR_DISPLAY], "kind %d", kind);
  }
  pktrt_scene_destroy(s);
}

/* Passes that are equal have no error, though sums of thirds are rounded. The control: one pixel of one pass differs. */
static void equal_thirds(void) {
  static double values[14 * PIXELS];
  static sheet got;
  pktrt_scene *s = stage_open();
  for (uint32_t passes = 7; passes <= 14; passes += 7)
    for (int differs = 0; differs < 2; differs++) {
      pktrt_render_desc d = sheet_view(&got, passes);
      for (size_t i = 0; i < passes * PIXELS; i++) values[i] = scattered(i % PIXELS) / 3;
      if (differs) values[PIXELS / 2] += 0.25;
      finish_values(s, &d, passes, values);
      CHECK((got.report.display_error == 0) == !differs, "%u passes: %g", passes, got.report.display_error);
      CHECK(got.report.unreliable[PKTRT_ERROR_DISPLAY] == differs, "%u passes, %d", passes, differs);
    }
  pktrt_scene_destroy(s);
}

/* Lamps six times as bright as white, some three pixels wide, on a wall with a fine pattern: at their edges a pixel is
   white if a sixth of it sees the lamp. A few specks are brighter still. */
static void glaring_light(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const uint32_t lamp = (uint32_t)((int)floorf(direction[0][i] * 17) * 31 + (int)floorf(direction[1][i] * 19) * 17);
    const uint32_t speck =
        (uint32_t)((int)floorf(direction[0][i] * 997) * 31 + (int)floorf(direction[1][i] * 991) * 17);
    const uint32_t hash = speck * 2654435761u >> 22; /* of 1024 */
    float value = 0.2f + 0.15f * (float)(hash & 3);
    if (lamp * 2654435761u >> 29 == 0) value = 6;
    if (hash == 1023) value = 20;
    for (int a = 0; a < 3; a++) radiance[a][i] = value;
  }
}

/* Of 30 seeds: the estimate over the true error. The linear estimate, divided by the same truth, is far off. */
static void estimates_and_truth(void) {
  enum { SEEDS = 30 };
  static sheet truth, got;
  pktrt_scene *s = stage_open();
  stage_commit(s);
  pktrt_render_desc d = sheet_view(&truth, 16);
  d.mode = PKTRT_MODE_DRT;
  d.environment = glaring_light;
  d.samples = 256;
  d.seed = 777777;
  stage_render(s, &d);

  for (uint32_t passes = 4; passes <= 8; passes *= 2)
    for (int curve = 0; curve < 2; curve++) {
      uint32_t within = 0, linear = 0;
      double least = INFINITY, most = 0;
      for (uint32_t seed = 0; seed < SEEDS; seed++) {
        double error = 0;
        pktrt_render_desc view = d;
        view.pixels = got.pixels;
        view.pixel_error = got.pixel_error;
        view.block_error = got.block_error;
        view.report = &got.report;
        view.samples = 4;
        view.passes = passes;
        view.seed = seed;
        view.display_tone = curve ? PKTRT_TONE_CURVE : PKTRT_TONE_CLAMP;
        stage_render(s, &view);
        for (size_t i = 0; i < PIXELS * 3; i++) {
          const double off =
              shown_by_pow((double)got.pixels[i], 1, curve) - shown_by_pow((double)truth.pixels[i], 1, curve);
          error += off * off / (PIXELS * 3);
        }
        const double ratio = got.report.display_error / sqrt(error);
        least = fmin(least, ratio);
        most = fmax(most, ratio);
        within += ratio > 0.75 && ratio < 1.25;
        linear += got.report.rmse > 0.75 * sqrt(error) && got.report.rmse < 1.25 * sqrt(error);
      }
      say("%u passes, curve %d: estimate over truth from %.3f to %.3f", passes, curve, least, most);
      CHECK(within >= SEEDS - 1, "%u passes: %u of %d seeds are within 25%%", passes, within, SEEDS);
      CHECK(linear <= 1, "the control: the RMSE of radiance is within 25%% for %u seeds", linear);
    }
  pktrt_scene_destroy(s);
}

/* Adaptive passes to a target, by number of threads; passes by hand; a seed more as the control. */
static void same_bits_everywhere(void) {
  static sheet want, got;
  static pktrt_pixel_sums sums[PIXELS];
  static pktrt_display_sums display[PIXELS];
  static double means[PIXELS * 3];

  for (int k = 0; k < isa_count * 2; k++) {
    const pktrt_scene_desc sd = scene_desc_of(isas[k / 2], k % 2 ? 3 : 0);
    pktrt_scene *s = pktrt_scene_create(&sd);
    stage_commit(s);
    pktrt_render_desc d = sheet_view(k ? &got : &want, 0);
    d.mode = PKTRT_MODE_DRT;
    d.environment = glaring_light;
    d.samples = 2;
    d.adaptive = true;
    d.target_error = 0.04f;
    d.tile_size = k ? 5 + (uint32_t)k : 0;
    stage_render(s, &d);
    CHECK(!k || same_bits(&got, &want, offsetof(sheet, report)), "%s, %d", pktrt_isa_string(isas[k / 2]), k);
    CHECK(!k || same_bits(&got.report.display_error, &want.report.display_error, 8), "the estimate, %d", k);
    CHECK(k || want.report.stop == PKTRT_STOP_ERROR, "stop %d", (int)want.report.stop);
    CHECK(k || (want.report.display_error <= 0.04 && want.report.samples_max > want.report.samples_min), "adaptive");
    pktrt_scene_destroy(s);
  }

  pktrt_scene *s = stage_open();
  stage_commit(s);
  for (int adaptive = 0; adaptive < 2; adaptive++) {
    pktrt_render_desc d = sheet_view(&want, 0);
    d.mode = PKTRT_MODE_DRT;
    d.environment = glaring_light;
    d.target_error = 0.04f;
    stage_render(s, &d);
    d = sheet_view(&got, 0);
    d.mode = PKTRT_MODE_DRT;
    d.environment = glaring_light;
    d.target_error = 0.04f;
    d.seed = (uint32_t)adaptive;
    d.display_sums = display;
    memset(sums, 0, sizeof sums);
    memset(display, 0, sizeof display);
    uint32_t passes = 0;
    do {
      CHECK(pktrt_render_pass(s, &d, passes++, 0, 0, W, H, means) == PKTRT_OK);
      pktrt_add_pass(means, PIXELS, sums);
      pktrt_add_display_pass(means, PIXELS, display);
      CHECK(pktrt_finish_passes(s, &d, passes, sums) == PKTRT_OK, "%s", pktrt_last_error(s));
    } while (got.report.stop == PKTRT_STOP_NOT_YET && passes < 1000);
    const bool same = same_bits(&got, &want, offsetof(sheet, report)) &&
                      same_bits(&got.report.display_error, &want.report.display_error, 8);
    CHECK(same == !adaptive && want.report.stop == PKTRT_STOP_ERROR, "seed %d: %u passes", adaptive, passes);
  }
  pktrt_scene_destroy(s);
}

/* Bytes for the sums of the display are taken if the measure and something that it gives are asked for. */
static void bytes_where_asked(void) {
  static sheet got;
  size_t peak[4];
  pktrt_scene *s = stage_open();
  stage_commit(s);
  for (int k = 0; k < 4; k++) {
    pktrt_scene_report report;
    pktrt_render_desc d = sheet_view(&got, 3);
    if (k == 0) d.measure = PKTRT_ERROR_RMSE;
    if (k == 1) d.measure = PKTRT_ERROR_RELATIVE;
    if (k == 2) {
      d.report = NULL;
      d.pixel_error = d.block_error = NULL;
    }
    pktrt_get_scene_report(s, &d, &report);
    hooks.peak_bytes = hooks.live_bytes;
    const size_t before = hooks.live_bytes;
    stage_render(s, &d);
    peak[k] = hooks.peak_bytes - before;
    CHECK(k == 2 || (got.report.display_error < INFINITY) == (k == 3), "case %d: %g", k, got.report.display_error);
    CHECK(k >= 2 || got.report.unreliable[PKTRT_ERROR_DISPLAY], "case %d", k);
    if (k == 3)
      CHECK(report.passes > 92 * PIXELS && report.passes < 93 * PIXELS, "%llu", (unsigned long long)report.passes);
  }
  CHECK(peak[1] == peak[0] && peak[2] == peak[0], "%zu, %zu and %zu bytes", peak[0], peak[1], peak[2]);
  CHECK(peak[3] == peak[0] + 48 * PIXELS, "the control: 48 bytes a pixel more: %zu, was %zu", peak[3], peak[0]);
  pktrt_scene_destroy(s);
}

static void refused_displays(void) {
  static sheet got, clean;
  static pktrt_pixel_sums sums[PIXELS];
  static const float exposures[] = {-1, NAN, INFINITY};
  pktrt_scene *s = stage_open();
  stage_commit(s);
  (void)sheet_view(&clean, 3);
  for (int k = 0; k < 6; k++) {
    pktrt_render_desc d = sheet_view(&got, 3);
    const char *const name = k < 3 ? "display_exposure" : k < 5 ? "pktrt_tone" : "display_sums";
    if (k < 3) d.display_exposure = exposures[k];
    else if (k < 5) d.display_tone = (pktrt_tone)(k == 3 ? -1 : 2);
    CHECK(pktrt_finish_passes(s, &d, 3, sums) == PKTRT_INVALID_ARGUMENT, "case %d", k);
    CHECK(strstr(pktrt_last_error(s), name) != NULL, "case %d: %s", k, pktrt_last_error(s));
    if (k < 5) CHECK(pktrt_render(s, &d) == PKTRT_INVALID_ARGUMENT, "case %d", k);
    CHECK(same_bits(&got, &clean, sizeof got), "case %d: refused calls write nothing", k);
    if (k < 5) continue;
    d.measure = PKTRT_ERROR_RMSE;
    CHECK(pktrt_finish_passes(s, &d, 3, sums) == PKTRT_OK, "the control: %s", pktrt_last_error(s));
  }
  pktrt_scene_destroy(s);
}

void suite_display(void) {
  run("errors as shown are those of the jackknife for two and three passes", the_jackknife);
  run("with more passes they are close to it", many_passes);
  run("what is white, black or constant has no error as shown", nothing_to_see);
  run("equal passes have no error as shown, whatever is rounded", equal_thirds);
  run("errors as shown are estimated to within 25% of the truth", estimates_and_truth);
  run("they have the same bits for all threads, tiles, instruction sets and places of passes", same_bits_everywhere);
  run("they take bytes only where they are asked for", bytes_where_asked);
  run("displays that make no sense are refused by name", refused_displays);
}
