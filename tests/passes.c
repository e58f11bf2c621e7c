/* Passes, seen from outside: what a picture is after several, what is said of its error, which rule stops, where adaptive
   passes go; the same bits whatever the settings; what is refused. */
#include "pictures.h"

enum { W = 40, H = 36, PIXELS = W * H, EDGE = PKTRT_ERROR_BLOCK, COLUMNS = 3, ROWS = 3, BLOCKS = COLUMNS * ROWS };
/* A square of CELL x CELL pixels has two cells, the fields of a chessboard, whose pixels get passes together. */
enum { SINGLES = 6, ROUNDS = 64, CELL = 4 };
#define PASS_SEED 0x9E3779B9u /* from pass to pass */

/* --- films and hooks --- */

typedef struct film { /* all that a render writes */
  float pixels[PIXELS * 3], depth[PIXELS], normal[PIXELS * 3], albedo[PIXELS * 3];
  float pixel_error[PIXELS], block_error[BLOCKS];
  uint32_t count[PIXELS];
  pktrt_report report;
} film;

/* A view of W x H pixels, DRT, one sample for each pass: its radiance is in the picture as it is. */
static pktrt_render_desc film_view(film *f) {
  memset(f, 0xC1, sizeof *f); /* as floats: -24.2 */
  pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, W, H, f->pixels, vec_of(0.5, 2, 6), vec_of(0, 0.6, 0));
  d.depth = f->depth, d.normal = f->normal, d.albedo = f->albedo, d.sample_count = f->count;
  d.pixel_error = f->pixel_error, d.block_error = f->block_error, d.report = &f->report;
  d.samples = 1, d.max_depth = 3;
  d.background[0] = 0.1f, d.background[1] = 0.2f, d.background[2] = 0.3f;
  for (int a = 0; a < 3; a++) d.ambient[a] = 0.05f;
  return d;
}

static bool same_report(const pktrt_report *a, const pktrt_report *b) { /* but for the time it took */
  return a->rounds == b->rounds && a->samples_min == b->samples_min && a->samples_max == b->samples_max &&
         same_bits(&a->samples_mean, &b->samples_mean, 8) && same_bits(&a->rmse, &b->rmse, 8) &&
         same_bits(&a->relative_mse, &b->relative_mse, 8) &&
         same_bits(a->effective_pixels, b->effective_pixels, sizeof a->effective_pixels) &&
         same_bits(&a->rmse_low, &b->rmse_low, 8) && same_bits(&a->rmse_high, &b->rmse_high, 8) &&
         same_bits(&a->relative_mse_high, &b->relative_mse_high, 8) && a->unreliable[0] == b->unreliable[0] &&
         a->unreliable[1] == b->unreliable[1] && a->unknown == b->unknown && a->stop == b->stop;
}

static bool same_film(const film *a, const film *b) {
  return same_bits(a, b, offsetof(film, report)) && same_report(&a->report, &b->report);
}

/* A floor under a lamp with soft shadows, and on it a ball with a glossy coat. */
static pktrt_scene *room(pktrt_isa isa, int workers) {
  const pktrt_scene_desc sd = scene_desc_of(isa, workers);
  pktrt_scene *s = pktrt_scene_create(&sd);
  if (!CHECK(s != NULL, "%s", pktrt_last_error(NULL))) abort();
  const quad ground = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 3), vec_of(3, 0, 0));
  const quad lamp = quad_of(vec_of(1, 4, 1), vec_of(1, 0, 0), vec_of(0, 0, 1));
  pktrt_material gloss = material_of(0.3, PKTRT_SPECULAR_MIRROR, 0.6), matt = material_of(0.7, PKTRT_SPECULAR_NONE, 0),
                 glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  const pktrt_light light = quad_light(&lamp, 8);
  gloss.lobe = PKTRT_LOBE_PHONG, gloss.exponent = 30;
  mesh ball = mesh_sphere(2, 0, 1);
  mesh_shift(&ball, 0, 1, 0);
  stage_quad(s, &ground, stage_material(s, &matt));
  stage_mesh(s, &ball, stage_material(s, &gloss));
  mesh_shift(&ball, 1.6f, -0.2f, 0.8f);
  stage_mesh(s, &ball, stage_material(s, &glass));
  stage_light(s, &light);
  stage_commit(s);
  mesh_free(&ball);
  return s;
}

typedef struct watch {                 /* the user of all hooks */
  uint32_t stop_after, rounds;         /* stop_after: the hook `pass` says no then; 0: never */
  pktrt_report report[ROUNDS];         /* after each round */
  float *picture, (*kept)[PIXELS * 3]; /* where the picture is, and copies of it after each round, or NULL */
  double now, step;                    /* a clock that goes on by a step whenever it is looked at */
  float said, no_from;                 /* what progress said last; it cancels from there on, if above 0 */
  size_t calls, backwards;             /* of progress */
} watch;

static bool watch_pass(void *user, const pktrt_report *r) {
  watch *w = user;
  CHECK(r->rounds == w->rounds + 1 && r->rounds <= ROUNDS, "round %u after %u", r->rounds, w->rounds);
  if (w->rounds < ROUNDS) {
    if (w->kept) memcpy(w->kept[w->rounds], w->picture, sizeof *w->kept);
    w->report[w->rounds++] = *r;
  }
  return r->rounds != w->stop_after;
}

static double watch_clock(void *user) {
  watch *w = user;
  return w->now += w->step;
}

static bool watch_progress(void *user, float done) {
  watch *w = user;
  CHECK(done > 0 && done <= 1, "%g done", (double)done);
  w->calls++, w->backwards += done < w->said;
  w->said = done;
  return !(w->no_from > 0) || done < w->no_from;
}

/* The pictures that n passes of d are made of, each rendered alone. */
static void render_singles(pktrt_scene *s, const pktrt_render_desc *view, film *single, uint32_t n) {
  for (uint32_t k = 0; k < n; k++) {
    pktrt_render_desc d = film_view(&single[k]);
    d.samples = view->samples, d.sampler = view->sampler, d.environment = view->environment, d.user = view->user;
    d.seed = view->seed + k * PASS_SEED;
    stage_render(s, &d);
  }
}

/* --- what a picture is after several passes --- */

/* Floats of the picture that are not, bit for bit, the mean of those of n single pictures. */
static size_t not_the_mean(const float *pixels, const film *single, uint32_t n) {
  size_t wrong = 0;
  for (size_t i = 0; i < PIXELS * 3; i++) {
    double sum = 0;
    for (uint32_t k = 0; k < n; k++) sum += (double)single[k].pixels[i];
    wrong += pixels[i] != (float)(sum / n);
  }
  return wrong;
}

/* Buffers of what primary rays met are means over all samples: the depth over those that met something. */
static size_t wrong_notes(const film *f, const film *single, uint32_t n) {
  size_t wrong = 0;
  for (size_t i = 0; i < PIXELS * 3; i++) {
    double normal = 0, albedo = 0;
    for (uint32_t k = 0; k < n; k++) normal += (double)single[k].normal[i], albedo += (double)single[k].albedo[i];
    wrong += !(fabs((double)f->normal[i] - normal / n) < 1e-6 && fabs((double)f->albedo[i] - albedo / n) < 1e-6);
  }
  for (size_t i = 0; i < PIXELS; i++) {
    double depth = 0, met = 0;
    for (uint32_t k = 0; k < n; k++)
      if (single[k].depth[i] < INFINITY) depth += (double)single[k].depth[i], met++;
    wrong += met > 0 ? !(fabs((double)f->depth[i] - depth / met) < 1e-5) : f->depth[i] < INFINITY;
    wrong += f->count[i] != n;
  }
  return wrong;
}

static void mean_of_singles(void) {
  enum { N = 5 };
  static film single[N], passes, unsplit;
  static float kept[N][PIXELS * 3];
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
    const char *name = pktrt_sampler_string((pktrt_sampler)sampler);
    watch w;
    memset(&w, 0, sizeof w);
    pktrt_render_desc d = film_view(&passes);
    w.picture = passes.pixels, w.kept = kept;
    d.sampler = (pktrt_sampler)sampler, d.seed = 12345, d.passes = N, d.pass = watch_pass, d.user = &w;
    stage_render(s, &d);
    d.user = NULL;
    render_singles(s, &d, single, N);
    for (uint32_t k = 1; k <= N; k++) {
      const size_t wrong = not_the_mean(kept[k - 1], single, k);
      CHECK(wrong == 0, "%s: %zu floats are not the mean of %u pictures", name, wrong, k);
    }
    CHECK(w.rounds == N && not_the_mean(passes.pixels, single, N) == 0, "%s: %u rounds", name, w.rounds);
    CHECK(wrong_notes(&passes, single, N) == 0, "%s: %zu notes are wrong", name, wrong_notes(&passes, single, N));
    CHECK(not_the_mean(passes.pixels, single, N - 1) > PIXELS / 2 && wrong_notes(&passes, single, N - 1) > PIXELS / 2,
        "%s: the control: a mean of four is another", name);
    d = film_view(&unsplit);
    d.sampler = (pktrt_sampler)sampler, d.seed = 12345, d.samples = N;
    stage_render(s, &d);
    CHECK(not_the_mean(unsplit.pixels, single, N) > PIXELS / 2, "%s: the control: one set of five is another", name);
  }
  pktrt_scene_destroy(s);
}

/* With several samples for each pass a single picture has been rounded once more. */
static void mean_of_larger_singles(void) {
  enum { N = 3, SAMPLES = 4 };
  static film single[N], passes;
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  size_t wrong = 0;
  pktrt_render_desc d = film_view(&passes);
  d.samples = SAMPLES, d.passes = N;
  stage_render(s, &d);
  render_singles(s, &d, single, N);
  for (size_t i = 0; i < PIXELS * 3; i++) {
    const double mean = ((double)single[0].pixels[i] + (double)single[1].pixels[i] + (double)single[2].pixels[i]) / N;
    wrong += !(fabs((double)passes.pixels[i] - mean) <= mean * 0x1p-23);
  }
  CHECK(wrong == 0 && passes.count[0] == N * SAMPLES, "%zu floats are off", wrong);
  pktrt_scene_destroy(s);
}

/* Passes of one sample each have their places in the pixel, in Whitted's pictures and ray casting as well: edges are smooth. */
static void passes_smooth_edges(void) {
  enum { N = 16 };
  static film alone, many, set;
  for (int mode = 0; mode < 2; mode++) {
    pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
    size_t differ = 0, off = 0, edges = 0;
    film *const films[3] = {&alone, &many, &set};
    for (int i = 0; i < 3; i++) {
      pktrt_render_desc d = film_view(films[i]);
      d.mode = mode ? PKTRT_MODE_WRT : PKTRT_MODE_RCS;
      d.passes = i == 1 ? N : 1, d.samples = i == 2 ? N : 1;
      if (!i) d.pixel_error = d.block_error = NULL;
      stage_render(s, &d);
    }
    for (size_t i = 0; i < PIXELS * 3; i++) {
      const float a = alone.pixels[i], b = many.pixels[i], c = set.pixels[i];
      differ += fabsf(b - a) > 0.05f, off += fabsf(b - c) > 0.2f, edges += fabsf(c - a) > 0.05f;
    }
    CHECK(edges > 20 && differ > edges / 2 && off <= edges / 4, "mode %d: %zu floats of edges, %zu smooth, %zu off",
        mode, edges, differ, off);
    pktrt_scene_destroy(s);
  }
}

/* The report, errors of pixels and errors of blocks are the same alone as all together. */
static void errors_alone(void) {
  static film all, one;
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  for (int which = 0; which < 4; which++) {
    film *f = which ? &one : &all;
    pktrt_render_desc d = film_view(f);
    d.passes = 8;
    if (which && which != 1) d.report = NULL;
    if (which && which != 2) d.pixel_error = NULL;
    if (which && which != 3) d.block_error = NULL;
    stage_render(s, &d);
    if (which == 1) CHECK(same_report(&all.report, &one.report), "the report alone");
    if (which == 2)
      CHECK(same_bits(all.pixel_error, one.pixel_error, sizeof all.pixel_error), "errors of pixels alone");
    if (which == 3)
      CHECK(same_bits(all.block_error, one.block_error, sizeof all.block_error), "errors of blocks alone");
  }
  CHECK(all.report.rmse > 0 && all.block_error[0] > 0 && all.block_error[0] < INFINITY, "there is something to tell");
  pktrt_scene_destroy(s);
}

/* One pass is the picture as it was before there were passes, says nothing of its error, and takes no more memory. */
static void one_pass(void) {
  static film plain, one, two;
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  size_t peak[3], calls[3];
  for (int i = 0; i < 3; i++) {
    pktrt_render_desc d = film_view(i == 0 ? &plain : i == 1 ? &one : &two);
    if (i == 0) d.report = NULL, d.pixel_error = d.block_error = NULL;
    d.passes = (uint32_t)i;
    hooks.peak_bytes = hooks.live_bytes;
    const size_t before = hooks.live_bytes, calls_before = hooks.calls;
    stage_render(s, &d);
    peak[i] = hooks.peak_bytes - before, calls[i] = hooks.calls - calls_before;
  }
  CHECK(same_bits(plain.pixels, one.pixels, sizeof plain.pixels), "the same picture");
  CHECK(!same_bits(plain.pixels, two.pixels, sizeof plain.pixels), "the control: two passes make another");
  const pktrt_report *r = &one.report;
  CHECK(r->rounds == 1 && r->samples_min == 1 && r->samples_max == 1 && r->samples_mean == 1 && !r->unknown);
  CHECK(r->unreliable[0] && r->unreliable[1] && isinf(r->rmse_high), "of one pass nothing is known");
  CHECK(isinf(r->rmse) && isinf(r->relative_mse) && r->stop == PKTRT_STOP_PASSES && r->seconds >= 0);
  for (size_t i = 0; i < PIXELS; i++)
    if (!CHECK(one.pixel_error[i] > FLT_MAX && two.pixel_error[i] <= FLT_MAX, "pixel %zu", i)) break;
  for (size_t i = 0; i < BLOCKS; i++) CHECK(one.block_error[i] > FLT_MAX && two.block_error[i] <= FLT_MAX);
  CHECK(peak[1] == peak[0] && calls[1] == calls[0], "%zu bytes, was %zu", peak[1], peak[0]);
  const size_t notes = 64 * PIXELS; /* sums of what primary rays met: this picture wants all of that */
  CHECK(peak[2] >= peak[0] + 44 * PIXELS + notes && peak[2] < peak[0] + 45 * PIXELS + notes,
      "the control: two passes take 44 bytes per pixel: %zu, was %zu", peak[2], peak[0]);
  say("bytes while rendering %d pixels: one pass %zu, two %zu, of which %zu for the optional buffers", PIXELS, peak[1],
      peak[2], notes);
  pktrt_scene_destroy(s);
}

/* --- what is said of the error --- */

typedef struct formula { /* from single pictures, in double */
  double pixel[PIXELS], block[BLOCKS], rmse, relative, effective[2], low, high, relative_high;
  uint64_t unknown;
} formula;

static bool finite_pixel(const film *single, uint32_t n, size_t at) {
  for (uint32_t k = 0; k < n; k++)
    for (size_t a = 0; a < 3; a++)
      if (!isfinite(single[k].pixels[3 * at + a])) return false;
  return true;
}

/* V = sum |x_i - x|^2 / (n (n - 1)) of a pixel; x: its mean. */
static double squared_error(const film *single, uint32_t n, size_t at, double x[3]) {
  double v = 0;
  for (size_t a = 0; a < 3; a++) {
    x[a] = 0;
    for (uint32_t k = 0; k < n; k++) x[a] += (double)single[k].pixels[3 * at + a] / n;
    for (uint32_t k = 0; k < n; k++) {
      const double off = (double)single[k].pixels[3 * at + a] - x[a];
      v += off * off / ((double)n * (n - 1));
    }
  }
  return v;
}

static void expect(const film *single, uint32_t n, formula *f) {
  double sum = 0, weighted = 0, known = 0, m[4] = {0, 0, 0, 0}, x[3], block[BLOCKS], pixels[BLOCKS], mean[BLOCKS][3];
  double squares[2] = {0, 0}, own[BLOCKS], factor[2];
  memset(f, 0, sizeof *f), memset(block, 0, sizeof block), memset(pixels, 0, sizeof pixels);
  memset(mean, 0, sizeof mean), memset(own, 0, sizeof own);
  for (size_t i = 0; i < PIXELS; i++) {
    const double v = squared_error(single, n, i, x);
    const size_t b = i / W / EDGE * COLUMNS + i % W / EDGE;
    f->pixel[i] = sqrt(v / 3);
    if (!finite_pixel(single, n, i)) {
      f->unknown++;
      continue;
    }
    sum += v, known++, block[b] += v, pixels[b]++, own[b] += v * v;
    for (int a = 0; a < 3; a++) m[a] += x[a], mean[b][a] += x[a];
  }
  for (int a = 0; a < 3; a++) m[a] /= known, m[3] += m[a] * m[a];
  for (size_t b = 0; b < BLOCKS; b++) {
    double b2 = 0;
    f->block[b] = INFINITY;
    if (pixels[b] == 0) continue;
    for (int a = 0; a < 3; a++) b2 += mean[b][a] * mean[b][a] / (pixels[b] * pixels[b]);
    b2 += m[3] / 100;
    f->block[b] = sqrt(block[b] / pixels[b] / 3), weighted += block[b] / b2;
    squares[0] += own[b], squares[1] += own[b] / (b2 * b2);
  }
  for (int k = 0; k < 2; k++) {
    const double all = k ? weighted : sum, off = sqrt(2 * squares[k]) / all;
    f->effective[k] = all * all / squares[k], factor[k] = off + sqrt(1 + off * off);
  }
  f->rmse = sqrt(sum / known / 3), f->relative = weighted / known;
  f->low = f->rmse / factor[0], f->high = f->rmse * factor[0], f->relative_high = f->relative * factor[1] * factor[1];
}

static bool near(double a, double b, double off) {
  return isfinite(b) ? fabs(a - b) <= off * fabs(b) + 1e-9 : !isfinite(a);
}

static size_t errors_off(const film *f, const formula *want) {
  size_t wrong = 0;
  for (size_t i = 0; i < PIXELS; i++) wrong += !near((double)f->pixel_error[i], want->pixel[i], 1e-6);
  for (size_t b = 0; b < BLOCKS; b++) wrong += !near((double)f->block_error[b], want->block[b], 1e-6);
  wrong += !near(f->report.rmse, want->rmse, 1e-9);
  wrong += !near(f->report.relative_mse, want->relative, 1e-9);
  for (int k = 0; k < 2; k++) wrong += !near(f->report.effective_pixels[k], want->effective[k], 1e-9);
  wrong += !near(f->report.rmse_low, want->low, 1e-9);
  wrong += !near(f->report.rmse_high, want->high, 1e-9);
  wrong += !near(f->report.relative_mse_high, want->relative_high, 1e-9);
  return wrong + (f->report.unknown != want->unknown);
}

static void formulas(void) {
  static film single[SINGLES], passes;
  static formula want, other;
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  for (uint32_t n = 2; n <= SINGLES; n++) {
    pktrt_render_desc d = film_view(&passes);
    d.seed = n, d.passes = n;
    stage_render(s, &d);
    render_singles(s, &d, single, n);
    expect(single, n, &want);
    const size_t wrong = errors_off(&passes, &want);
    CHECK(wrong == 0, "%u passes: %zu figures differ; RMSE %g, formula %g; relative MSE %g, formula %g", n, wrong,
        passes.report.rmse, want.rmse, passes.report.relative_mse, want.relative);
    CHECK(want.rmse > 0.01, "the control: there is an error");
    if (n == 2) continue;
    expect(single, n - 1, &other);
    CHECK(errors_off(&passes, &other) > PIXELS / 2, "the control: that of a pass less is another");
  }
  pktrt_scene_destroy(s);
}

/* Smooth over a pixel; counts what it is asked for. */
typedef struct smooth_sky {
  double sum, squares, n;
} smooth_sky;

static void smooth_light(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  smooth_sky *sky = user;
  for (uint32_t i = 0; i < n; i++) {
    const double v = 1 + (double)direction[0][i] + 2 * (double)direction[1][i] * (double)direction[1][i];
    sky->sum += v, sky->squares += v * v, sky->n++;
    for (int a = 0; a < 3; a++) radiance[a][i] = (float)v;
  }
}

/* Samples of a Sobol' set keep away from each other, so their scatter says nothing of the error of their mean; that of
   independent sets does. One pixel, many seeds, the truth from many more samples. */
static void scatter_within_a_set(void) {
  enum { SAMPLES = 64, PARTS = 4 };
  const uint32_t seeds = (uint32_t)scaled(1600);
  pktrt_scene *s = stage_open();
  stage_commit(s);
  float pixel[3];
  smooth_sky sky;
  pktrt_report report;
  pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, 1, 1, pixel, vec_of(0, 0, 0), vec_of(0, 0, -1));
  d.environment = smooth_light, d.user = &sky;
  d.samples = 65536, d.seed = 99999;
  memset(&sky, 0, sizeof sky);
  stage_render(s, &d);
  const double truth = sky.sum / sky.n;
  double naive = 0, whole = 0, passes = 0, split = 0; /* mean squared errors: said and true, of one set and of parts */
  d.report = &report;
  for (d.seed = 0; d.seed < seeds; d.seed++) {
    memset(&sky, 0, sizeof sky);
    d.samples = SAMPLES, d.passes = 1;
    stage_render(s, &d);
    const double mean = sky.sum / sky.n;
    naive += (sky.squares / sky.n - mean * mean) / (sky.n - 1), whole += (mean - truth) * (mean - truth);
    memset(&sky, 0, sizeof sky);
    d.samples = SAMPLES / PARTS, d.passes = PARTS;
    stage_render(s, &d);
    const double off = sky.sum / sky.n - truth;
    passes += report.rmse * report.rmse, split += off * off;
  }
  naive = sqrt(naive / whole), passes = sqrt(passes / split);
  say("said of the true error, over %u seeds: %.3f by %d passes, %.1f by the variance within one set of %d", seeds,
      passes, PARTS, naive, SAMPLES);
  CHECK(fabs(passes - 1) < (small_run ? 0.4 : 0.1), "%g of the true error", passes);
  CHECK(naive > 5, "the control: the naive estimate is %g of the true error", naive);
  pktrt_scene_destroy(s);
}

/* --- the same bits --- */

enum { KINDS = 3 }; /* uniform, adaptive by count, adaptive to a target */

static void choose_kind(pktrt_render_desc *d, int kind, float target) {
  d->adaptive = kind > 0;
  d->passes = kind == 0 ? 3 : kind == 1 ? 5 : 0;
  if (kind == 2) d->target_error = target, d->measure = PKTRT_ERROR_RELATIVE;
}

static void same_whatever(void) {
  static const uint32_t tiles[] = {0, 5, 16, 24, 33, 1, 1024}, packets[] = {0, 2, 4, 8, 16};
  static const int workers[] = {0, 1, 3, 7};
  static film want[KINDS], got;
  static watch wanted[KINDS], w;
  size_t pictures = 0;
  float target = 0;
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  memset(wanted, 0, sizeof wanted);
  for (int kind = 0; kind < KINDS; kind++) {
    pktrt_render_desc d = film_view(&want[kind]);
    d.path = PKTRT_PATH_SINGLE, d.pass = watch_pass, d.user = &wanted[kind];
    choose_kind(&d, kind, target);
    stage_render(s, &d);
    target = (float)want[kind].report.relative_mse * 0.8f;
  }
  CHECK(want[2].report.stop == PKTRT_STOP_ERROR && wanted[2].rounds > 2 && want[1].report.samples_max > 5,
      "%u rounds, up to %u samples", wanted[2].rounds, want[1].report.samples_max);
  target = (float)want[1].report.relative_mse * 0.8f;
  pktrt_scene_destroy(s);
  for (uint32_t k = 0; k < (uint32_t)isa_count * 2; k++) {
    const int threads = workers[(k + k / 4) % 4];
    s = room(isas[k / 2], threads);
    for (uint32_t i = k; i < k + (small_run ? 1u : 2u) * KINDS; i++) {
      const int kind = (int)(i % KINDS);
      pktrt_render_desc d = film_view(&got);
      memset(&w, 0, sizeof w);
      d.path = (pktrt_path)(i / 3 % 3);
      d.tile_size = tiles[(i + k) % COUNT(tiles)], d.packet_size = packets[i % COUNT(packets)];
      d.assembly = (pktrt_assembly)((i + k / 2) % 6), d.pass = watch_pass, d.user = &w;
      choose_kind(&d, kind, target);
      stage_render(s, &d);
      pictures++;
      CHECK(same_film(&got, &want[kind]), "kind %d, %s, %d workers, path %d, tiles %u, packets %u, assembly %d", kind,
          pktrt_isa_string(isas[k / 2]), threads, (int)d.path, d.tile_size, d.packet_size, (int)d.assembly);
      bool alike = w.rounds == wanted[kind].rounds;
      for (uint32_t r = 0; r < w.rounds && alike; r++) alike = same_report(&w.report[r], &wanted[kind].report[r]);
      CHECK(alike, "kind %d: other reports", kind);
      if (k + 1 < (uint32_t)isa_count * 2) continue;
      d.seed++;
      memset(&w, 0, sizeof w);
      stage_render(s, &d);
      CHECK(!same_film(&got, &want[kind]), "the control: another seed, another film");
    }
    pktrt_scene_destroy(s);
  }
  say("%zu films of %d x %d: pictures, buffers, errors and the reports of all rounds", pictures, W, H);
}

/* --- rules --- */

static void stop_rules(void) {
  enum { N = 8 };
  static float kept[N][PIXELS * 3];
  static film f;
  static watch all, w;
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  pktrt_render_desc d = film_view(&f), first;
  memset(&all, 0, sizeof all);
  all.picture = f.pixels, all.kept = kept;
  d.samples = 2, d.passes = N, d.pass = watch_pass, d.user = &all, d.seconds = watch_clock;
  stage_render(s, &d);
  CHECK(f.report.stop == PKTRT_STOP_PASSES && f.report.rounds == N && same_report(&f.report, &all.report[N - 1]));
  for (uint32_t k = 0; k < N; k++) {
    const pktrt_report *r = &all.report[k];
    CHECK(r->samples_min == 2 * k + 2 && r->samples_max == 2 * k + 2 && r->samples_mean == 2 * k + 2, "round %u", k);
    CHECK(isinf(r->rmse) == (k == 0) && r->stop == (k + 1 < N ? PKTRT_STOP_NOT_YET : PKTRT_STOP_PASSES), "round %u", k);
  }
  first = d, first.user = &w, first.passes = 0;
  static const struct {
    uint32_t passes, error, clock, asked; /* rounds after which a rule says stop; 0: there is none */
    pktrt_stop stop;
  } rules[] = {{3, 0, 0, 0, PKTRT_STOP_PASSES}, {0, 5, 0, 0, PKTRT_STOP_ERROR}, {0, 0, 4, 0, PKTRT_STOP_TIME},
      {0, 0, 0, 3, PKTRT_STOP_ASKED}, {0, 0, 1, 0, PKTRT_STOP_TIME}, {0, 0, 0, 1, PKTRT_STOP_ASKED},
      {6, 5, 7, 7, PKTRT_STOP_ERROR}, {5, 6, 7, 7, PKTRT_STOP_PASSES}, {7, 6, 5, 7, PKTRT_STOP_TIME},
      {7, 7, 6, 5, PKTRT_STOP_ASKED}, {5, 5, 5, 5, PKTRT_STOP_ERROR}, {5, 0, 5, 5, PKTRT_STOP_PASSES},
      {0, 0, 5, 5, PKTRT_STOP_TIME}};
  for (size_t i = 0; i < COUNT(rules); i++) {
    uint32_t rounds = N;
    const uint32_t ends[4] = {rules[i].passes, rules[i].error, rules[i].clock, rules[i].asked};
    for (int k = 0; k < 4; k++) rounds = ends[k] && ends[k] < rounds ? ends[k] : rounds;
    memset(&w, 0, sizeof w);
    d = first, d.trust_estimates = true, d.passes = rules[i].passes, w.stop_after = rules[i].asked, w.step = 1;
    if (rules[i].error) { /* between the errors of two rounds; they fall from one to the next */
      const uint32_t k = rules[i].error - 1;
      CHECK(all.report[k].rmse < all.report[k - 1].rmse, "the error falls in round %u", k);
      d.target_error = (float)(0.5 * (all.report[k].rmse + all.report[k - 1].rmse));
    }
    if (rules[i].clock) d.time_budget = rules[i].clock + 0.5; /* a round takes a second */
    stage_render(s, &d);
    CHECK(f.report.stop == rules[i].stop && f.report.rounds == rounds && w.rounds == rounds,
        "rules %zu: %u rounds, want %u; stop %d, want %d", i, f.report.rounds, rounds, (int)f.report.stop,
        (int)rules[i].stop);
    CHECK(same_bits(f.pixels, kept[rounds - 1], sizeof *kept), "rules %zu: the picture of that many passes", i);
    CHECK(f.report.seconds == rounds && f.count[0] == 2 * rounds, "rules %zu: %g s", i, f.report.seconds);
  }
  pktrt_scene_destroy(s);
}

/* Cancelled in a later pass, a picture lacks nothing: each pixel is that of two passes or of three. */
static void cancelled_later(void) {
  static film f, two, three;
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  pktrt_render_desc d = film_view(&two);
  d.passes = 2;
  stage_render(s, &d);
  d = film_view(&three), d.passes = 3;
  stage_render(s, &d);
  for (int adaptive = 0; adaptive < 2; adaptive++) {
    watch w;
    memset(&w, 0, sizeof w);
    w.no_from = 2.4f / 8;
    d = film_view(&f), d.passes = 8, d.tile_size = 8, d.adaptive = adaptive != 0;
    d.progress = watch_progress, d.user = &w;
    CHECK(pktrt_render(s, &d) == PKTRT_CANCELLED && strstr(pktrt_last_error(s), "progress"), "%s", pktrt_last_error(s));
    CHECK(f.report.stop == PKTRT_STOP_CANCELLED && f.report.rounds == (adaptive ? 1u : 2u) && f.report.samples_min == 2,
        "%u rounds", f.report.rounds);
    CHECK(w.calls > 0 && !w.backwards && w.said >= w.no_from && w.said < 0.6f, "%g done", (double)w.said);
    size_t of_two = 0, of_three = 0, other = 0;
    for (size_t i = 0; i < PIXELS; i++) {
      const bool is_two = same_bits(&f.pixels[3 * i], &two.pixels[3 * i], 12);
      const bool is_three = same_bits(&f.pixels[3 * i], &three.pixels[3 * i], 12);
      of_two += is_two, of_three += is_three && f.count[i] == 3, other += !is_two && !is_three;
    }
    CHECK(of_two > 0 && (adaptive ? of_two + other > 0 : of_three > PIXELS / 4 && other == 0),
        "%zu pixels of two passes, %zu of three, %zu of neither", of_two, of_three, other);
  }
  pktrt_scene_destroy(s);
}

/* Done grows, and to 1. */
static void progress_grows(void) {
  static film f;
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  for (int i = 0; i < 6; i++) {
    watch w;
    memset(&w, 0, sizeof w);
    pktrt_render_desc d = film_view(&f);
    d.progress = watch_progress, d.seconds = watch_clock, d.user = &w, d.tile_size = 16, w.step = 1;
    d.adaptive = i % 2 != 0, d.passes = i < 2 ? 6 : 0;
    if (i / 2 == 1) d.target_error = 0.02f;
    if (i / 2 == 2) d.time_budget = 7.25;
    stage_render(s, &d);
    say("%s, %s: %u rounds, the last progress %.3f", d.adaptive ? "adaptive" : "uniform",
        i / 2 == 0   ? "passes"
        : i / 2 == 1 ? "target"
                     : "time",
        f.report.rounds, (double)w.said);
    CHECK(w.backwards == 0 && w.calls >= 9 * f.report.rounds, "%zu calls, %zu backwards", w.calls, w.backwards);
    CHECK(w.said > (i < 2 ? 0.9999f : 0.75f), "the last is %g", (double)w.said);
  }
  pktrt_scene_destroy(s);
}

/* --- adaptive passes --- */

/* Still but for the upper left corner, within the first block, where it is a fine chequered pattern. */
static void corner_light(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const float x = direction[0][i], y = direction[1][i];
    const int cell = (int)floorf(x * 401) + (int)floorf(y * 397);
    const float v = x < -0.15f && y > 0.1f ? (cell & 1 ? 1.5f : 0.1f) : 0.4f;
    for (int a = 0; a < 3; a++) radiance[a][i] = v;
  }
}

static pktrt_render_desc corner_view(film *f) {
  pktrt_render_desc d = film_view(f);
  vec_put(vec_of(0, 0, 0), d.camera.eye), vec_put(vec_of(0, 0, -1), d.camera.target);
  d.environment = corner_light, d.samples = 2;
  return d;
}

/* A clock that goes by the samples that were looked at: a thousand a second. */
typedef struct workload {
  double samples;
} workload;

static void counted_light(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  corner_light(NULL, n, direction, radiance);
  ((workload *)user)->samples += n;
}

static double workload_clock(void *user) { return 50 + ((workload *)user)->samples / 1000; }

/* A budget is used but for what the next round would take at least, and not exceeded but by the rounding to whole passes
   of blocks. The first round is done whatever it takes. */
static void budgets_kept(void) {
  static film f;
  const double pass = PIXELS * 2 / 1000., block = EDGE * EDGE * 2 / 1000.;
  pktrt_scene *s = stage_open();
  stage_commit(s);
  for (int adaptive = 0; adaptive < 2; adaptive++) {
    double most = 0, least = INFINITY;
    for (double budget = 1; budget < 200; budget *= 1.4) {
      workload work = {0};
      pktrt_render_desc d = corner_view(&f);
      d.environment = counted_light, d.seconds = workload_clock, d.user = &work;
      d.adaptive = adaptive != 0, d.time_budget = budget;
      stage_render(s, &d);
      const double took = f.report.seconds, first = adaptive ? 2 * pass : pass;
      CHECK(f.report.stop == PKTRT_STOP_TIME && near(took, work.samples / 1000, 1e-9), "%g s, %g by the clock", took,
          work.samples / 1000);
      if (budget < first) {
        CHECK(near(took, first, 1e-9) && f.report.rounds == 1, "budget %g: %g s", budget, took);
        continue;
      }
      CHECK(took <= budget + (adaptive ? block : 1e-9), "%s, budget %g: %g s", adaptive ? "adaptive" : "uniform",
          budget, took);
      CHECK(adaptive ? 1.1 * took > budget - 1e-9 : took + pass > budget - 1e-9, "%s, budget %g: %g s",
          adaptive ? "adaptive" : "uniform", budget, took);
      most = fmax(most, took / budget), least = fmin(least, took / budget);
    }
    say("%s: %.4f to %.4f of the budget", adaptive ? "adaptive" : "uniform", least, most);
  }
  pktrt_scene_destroy(s);
}

/* What a clock shows, look by look; the last value stays. */
typedef struct hand {
  watch w; /* first: the hooks' user is both */
  const double *shown;
  size_t look, looks;
} hand;

static double hand_clock(void *user) {
  hand *h = user;
  return h->shown[h->look + 1 < h->looks ? h->look++ : h->look];
}

/* Time is what the clock goes forward, round by round; set back, it counts as none, and says nothing of the rounds after. */
static void clock_set_back(void) {
  static const double shown[] = {1000, 1001, 1002, 2, 3.5, 3.5, -1e6, -1e6 + 4},
                      after[] = {1, 2, 2, 3.5, 3.5, 3.5, 7.5};
  static film f;
  static hand h;
  pktrt_scene *s = stage_open();
  stage_commit(s);
  for (int rule = 0; rule < 3; rule++) { /* passes; a budget that ends it after the clock was set back; one far off */
    memset(&h, 0, sizeof h);
    h.shown = shown, h.looks = COUNT(shown);
    pktrt_render_desc d = corner_view(&f);
    d.pass = watch_pass, d.seconds = hand_clock, d.user = &h.w, d.passes = 7;
    if (rule) d.time_budget = rule == 1 ? 4.3 : 100;
    stage_render(s, &d);
    const uint32_t rounds = rule == 1 ? 4 : 7;
    CHECK(h.w.rounds == rounds && f.report.stop == (rule == 1 ? PKTRT_STOP_TIME : PKTRT_STOP_PASSES),
        "rule %d: %u rounds", rule, h.w.rounds);
    for (uint32_t i = 0; i < h.w.rounds; i++)
      CHECK(near(h.w.report[i].seconds, after[i], 1e-9), "rule %d: %g s after round %u, not %g", rule,
          h.w.report[i].seconds, i + 1, after[i]);
  }
  pktrt_scene_destroy(s);
}

/* Noisy all over: many pixels carry the error. */
static void even_light(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const int cell = (int)floorf(direction[0][i] * 401) + (int)floorf(direction[1][i] * 397);
    for (int a = 0; a < 3; a++) radiance[a][i] = cell & 1 ? 1.5f : 0.1f;
  }
}

/* Noisy in some four pixels, which carry the error. */
static void few_light(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  even_light(user, n, direction, radiance);
  for (uint32_t i = 0; i < n; i++) {
    const float x = direction[0][i], y = direction[1][i];
    if (x > -0.2f && x < -0.15f && y > 0.1f && y < 0.15f) continue;
    for (int a = 0; a < 3; a++) radiance[a][i] = 0.4f;
  }
}

/* Two passes do not end at a target that their estimate meets where few pixels carry the error, unless the estimate is
   trusted. Where a corner or all pixels carry it two passes do. */
static void unreliable_estimates(void) {
  static const char *const names[] = {"few pixels", "a corner", "all over"};
  static film f;
  pktrt_scene *s = stage_open();
  stage_commit(s);
  for (int light = 0; light < 3; light++)
    for (int adaptive = 0; adaptive < 2; adaptive++)
      for (int measure = 0; measure < 2; measure++) {
        uint32_t rounds[2];
        double mean[2];
        const bool even = light > 0;
        pktrt_render_desc d = corner_view(&f);
        d.environment = light == 0 ? few_light : light == 1 ? corner_light : even_light;
        d.passes = 2;
        stage_render(s, &d);
        CHECK(f.report.unreliable[0] == !even && f.report.unreliable[1] == !even, "%s: %g effective pixels",
            names[light], f.report.effective_pixels[0]);
        CHECK((f.report.effective_pixels[0] > 10) == even, "%g pixels", f.report.effective_pixels[0]);
        CHECK(f.report.rmse_low < f.report.rmse && f.report.rmse < f.report.rmse_high, "within its interval");
        d.measure = (pktrt_error_measure)measure;
        d.adaptive = adaptive != 0;
        d.passes = 0;
        d.target_error = (float)(1.01 * (measure ? f.report.relative_mse : f.report.rmse));
        for (int trust = 0; trust < 2; trust++) {
          d.trust_estimates = trust != 0;
          stage_render(s, &d);
          rounds[trust] = f.report.rounds;
          mean[trust] = f.report.samples_mean / d.samples;
          CHECK(f.report.stop == PKTRT_STOP_ERROR, "stop %d", (int)f.report.stop);
        }
        CHECK(mean[1] == 2, "trusted: %g passes", mean[1]);
        CHECK(even ? mean[0] == 2 : mean[0] >= 8 && mean[0] < 14, "careful: %g passes", mean[0]);
        say("%s, %s: %g passes in %u rounds, %g if trusted", names[light], adaptive ? "adaptive" : "uniform", mean[0],
            rounds[0], mean[1]);
      }
  pktrt_scene_destroy(s);
}

/* From 16 passes on an unreliable estimate meets a target that it is below by 15% of its square. The interval, which
   reaches further, would ask for more. */
static void doubt_is_capped(void) {
  static film f;
  pktrt_scene *s = stage_open();
  stage_commit(s);
  for (int measure = 0; measure < 2; measure++) {
    pktrt_render_desc d = corner_view(&f);
    d.environment = few_light;
    d.passes = 24;
    stage_render(s, &d);
    d.passes = 0;
    d.measure = (pktrt_error_measure)measure;
    d.target_error = (float)(measure ? f.report.relative_mse : f.report.rmse);
    stage_render(s, &d);
    const double passes = f.report.samples_mean / d.samples;
    const double ratio =
        measure ? f.report.relative_mse / (double)d.target_error : pow(f.report.rmse / (double)d.target_error, 2);
    CHECK(f.report.stop == PKTRT_STOP_ERROR && f.report.unreliable[measure], "%g passes", passes);
    CHECK(
        ratio <= 1 / 1.15 && ratio > 0.75 && passes > 24 && passes < 34, "%g passes, %g of the target", passes, ratio);
    CHECK((measure ? f.report.relative_mse_high : f.report.rmse_high) > 1.2 * (double)d.target_error,
        "the control: the upper bound misses the target");
    say("measure %d: %g passes, squared error %.3f of the target", measure, passes, ratio);
  }
  pktrt_scene_destroy(s);
}

static double distance2(const float *a, const float *b) {
  double sum = 0;
  for (size_t i = 0; i < PIXELS * 3; i++) sum += ((double)a[i] - (double)b[i]) * ((double)a[i] - (double)b[i]);
  return sum;
}

static void check_counts(const film *f) {
  uint32_t least = UINT32_MAX, most = 0;
  double sum = 0;
  for (size_t i = 0; i < PIXELS; i++) {
    size_t block = i / W / CELL * CELL * W + i % W / CELL * CELL; /* the first pixel of its square, then of its cell */
    block += (i % W + i / W) % 2;
    const uint32_t n = f->count[i];
    least = n < least ? n : least, most = n > most ? n : most, sum += n;
    if (!CHECK(n == f->count[block] && n % 2 == 0, "pixel %zu has %u samples", i, n)) break;
  }
  CHECK(f->report.samples_min == least && f->report.samples_max == most, "%u to %u samples", least, most);
  CHECK(near(f->report.samples_mean, sum / PIXELS, 1e-12), "mean %g, counted %g", f->report.samples_mean, sum / PIXELS);
}

static void passes_go_where_noise_is(void) {
  enum { PASSES = 12 };
  static film truth, uniform, adaptive;
  pktrt_scene *s = stage_open();
  stage_commit(s);
  double error[2] = {0, 0}, most_mean = 0;
  pktrt_render_desc d = corner_view(&truth);
  d.samples = 1024, d.seed = 777777;
  stage_render(s, &d);
  for (uint32_t seed = 0; seed < 8; seed++) {
    d = corner_view(&uniform), d.seed = seed, d.passes = PASSES;
    stage_render(s, &d);
    d = corner_view(&adaptive), d.seed = seed, d.passes = PASSES, d.adaptive = true;
    stage_render(s, &d);
    check_counts(&uniform), check_counts(&adaptive);
    CHECK(uniform.report.samples_min == 2 * PASSES && uniform.report.samples_max == 2 * PASSES, "uniform is uniform");
    const uint32_t noisy = adaptive.count[0], still = adaptive.count[PIXELS - 1];
    CHECK(noisy > 6 * still && noisy + 16 > adaptive.report.samples_max, "%u samples in the corner, %u afar", noisy,
        still);
    CHECK(still <= adaptive.report.samples_min + 2, "%u samples where it is still, least %u", still,
        adaptive.report.samples_min);
    const double mean = adaptive.report.samples_mean / 2;
    most_mean = fmax(most_mean, mean);
    CHECK(mean > PASSES - 0.2 && mean < PASSES + 0.2, "%g passes on average", mean);
    error[0] += distance2(uniform.pixels, truth.pixels), error[1] += distance2(adaptive.pixels, truth.pixels);
  }
  const double ratio = sqrt(error[1] / error[0]);
  say("%d passes on average, at most %.3f: %u samples in the corner, %u afar, %.3f of the error of uniform passes",
      PASSES, most_mean, adaptive.count[0], adaptive.count[PIXELS - 1], ratio);
  CHECK(ratio < 0.75, "%g of the error", ratio);
  pktrt_scene_destroy(s);
}

/* Bright in one cell of 37: seldom met by a pass of two samples. */
static void rare_light(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const int cell = (int)floorf(direction[0][i] * 1401) + 6 * (int)floorf(direction[1][i] * 1397);
    for (int a = 0; a < 3; a++) radiance[a][i] = cell % 37 == 0 ? 40.0f : 0.1f;
  }
}

static double sum_of(const float *pixels) {
  double sum = 0;
  for (size_t i = 0; i < PIXELS * 3; i++) sum += (double)pixels[i];
  return sum;
}

/* The mean of adaptive pictures is that of the truth where light is rare, since no cell judges itself. The control: a
   pixel that has two passes, and six more if these differ, is too dark on average: if it has met light it has it in two
   of eight passes, if it has missed light it has only two passes. */
static void mean_is_right(void) {
  enum { SEEDS = 24, PASSES = 8 };
  static film truth, adaptive, single;
  static double few[PIXELS * 3], all[PIXELS * 3];
  pktrt_scene *s = stage_open();
  double off = 0, squares = 0, control = 0;
  stage_commit(s);
  pktrt_render_desc d = corner_view(&truth);
  d.environment = rare_light;
  d.samples = 2048;
  stage_render(s, &d);
  const double wanted = sum_of(truth.pixels);

  for (uint32_t seed = 1; seed <= SEEDS; seed++) {
    d = corner_view(&adaptive);
    d.environment = rare_light;
    d.seed = seed;
    d.passes = PASSES;
    d.adaptive = true;
    stage_render(s, &d);
    const double own = sum_of(adaptive.pixels) / wanted - 1;
    off += own / SEEDS;
    squares += own * own / SEEDS;

    memset(all, 0, sizeof all);
    for (uint32_t pass = 0; pass < PASSES; pass++) {
      d = corner_view(&single);
      d.environment = rare_light;
      d.seed = 1000 * seed + pass;
      stage_render(s, &d);
      for (size_t i = 0; i < PIXELS * 3; i++) all[i] += (double)single.pixels[i];
      if (pass == 1) memcpy(few, all, sizeof all);
    }
    for (size_t i = 0; i < PIXELS * 3; i++) control += (few[i] > 0.3 ? all[i] / PASSES : few[i] / 2) / (wanted * SEEDS);
  }

  const double doubt = sqrt((squares - off * off) / (SEEDS - 1));
  CHECK(fabs(off) < 4 * doubt + 0.002 && doubt < 0.01, "off by %.2f%%, doubt %.2f%%", 100 * off, 100 * doubt);
  CHECK(control < 0.8, "the control: pixels that judge themselves are too dark: %g", control);
  say("off by %.2f%% (standard error %.2f%%); the control by %.1f%%", 100 * off, 100 * doubt, 100 * (control - 1));
  pktrt_scene_destroy(s);
}

/* Blocks get whole passes, of which a small picture may want a part only: rounds end nevertheless. */
static void every_size_ends(void) {
  static film f;
  static watch guard;
  pktrt_scene *s = stage_open();
  stage_commit(s);
  size_t renders = 0, longest = 0;
  for (uint32_t w = 1; w <= W; w += small_run ? 13 : 4) {
    for (uint32_t h = 1; h <= H; h += 5) {
      for (int i = 0; i < 5; i++) {
        pktrt_render_desc d = corner_view(&f);
        memset(&guard, 0, sizeof guard);
        guard.stop_after = ROUNDS; /* or it would not end */
        d.width = w, d.height = h, d.adaptive = true, d.pass = watch_pass, d.user = &guard;
        if (i < 3) d.passes = 2 + 3 * (uint32_t)i;
        else d.target_error = 0.02f * (float)(i - 2), d.measure = (pktrt_error_measure)(i - 3);
        stage_render(s, &d);
        renders++, longest = f.report.rounds > longest ? f.report.rounds : longest;
        CHECK(f.report.stop == (i < 3 ? PKTRT_STOP_PASSES : PKTRT_STOP_ERROR), "%u x %u, case %d: %u rounds, mean %g",
            w, h, i, f.report.rounds, f.report.samples_mean / 2);
        const double off = fabs(f.report.samples_mean / 2 - d.passes) * w * h;
        CHECK(i >= 3 || off <= fmax(0.1 * w * h, EDGE * EDGE), "%u x %u, case %d: %g of %u", w, h, i,
            f.report.samples_mean / 2, d.passes);
      }
    }
  }
  pktrt_render_desc d = corner_view(&f);
  memset(&guard, 0, sizeof guard);
  guard.stop_after = 5, d.pass = watch_pass, d.user = &guard, d.adaptive = true, d.target_error = 1e-30f;
  stage_render(s, &d);
  CHECK(f.report.stop == PKTRT_STOP_ASKED && f.report.rounds == 5, "the control: a target out of reach, and the guard");
  say("%zu renders of up to %d x %d, at most %zu rounds", renders, W, H, longest);
  pktrt_scene_destroy(s);
}

/* No error anywhere: every rule still ends, and the estimate is 0, not what rounding leaves. */
static void still_pictures(void) {
  static film f;
  pktrt_scene *s = stage_open();
  stage_commit(s);
  for (int i = 0; i < 6; i++) {
    watch w;
    memset(&w, 0, sizeof w);
    pktrt_render_desc d = film_view(&f);
    d.samples = 3, d.adaptive = i % 2 != 0, d.seconds = watch_clock, d.user = &w, w.step = 1;
    if (i / 2 == 0) d.passes = 7;
    if (i / 2 == 1) d.target_error = 1e-30f;
    if (i / 2 == 2) d.time_budget = 9.5;
    stage_render(s, &d);
    CHECK(f.report.stop == (i / 2 == 0      ? PKTRT_STOP_PASSES
                               : i / 2 == 1 ? PKTRT_STOP_ERROR
                                            : PKTRT_STOP_TIME),
        "case %d", i);
    CHECK(!f.report.unreliable[0] && f.report.effective_pixels[0] == 0 && f.report.rmse_high == 0, "case %d", i);
    CHECK(f.report.rmse == 0 && f.report.relative_mse == 0 && f.report.unknown == 0, "case %d: %g", i, f.report.rmse);
    CHECK(i / 2 != 0 || near(f.report.samples_mean, 21, 0.02), "case %d: %g samples", i, f.report.samples_mean);
    CHECK(i / 2 != 1 || f.report.samples_max == 6, "case %d: %u samples", i, f.report.samples_max);
    for (size_t k = 0; k < PIXELS * 3; k++)
      if (!CHECK(f.pixels[k] == d.background[k % 3] && f.pixel_error[k / 3] == 0, "case %d, float %zu", i, k)) break;
  }
  pktrt_render_desc d = corner_view(&f);
  d.passes = 7;
  stage_render(s, &d);
  CHECK(f.report.rmse > 0 && f.pixel_error[0] > 0 && f.pixel_error[PIXELS - 1] == 0,
      "the control: a corner is not still");
  pktrt_scene_destroy(s);
}

/* --- radiance that is no number --- */

static void broken_light(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  corner_light(user, n, direction, radiance);
  for (uint32_t i = 0; i < n; i++) {
    radiance[2][i] += 0.3f * sinf(300 * direction[0][i]); /* noise in all blocks */
    if (direction[0][i] > 0.3f) radiance[1][i] = NAN;
    if (direction[1][i] < -0.3f) radiance[2][i] = INFINITY;
    if (direction[0][i] > 0.2f && direction[1][i] > 0.25f) radiance[0][i] = -INFINITY;
  }
}

static void unknown_pixels(void) {
  enum { N = 4 };
  static film single[N], f;
  static formula want;
  pktrt_scene *s = stage_open();
  stage_commit(s);
  for (int i = 0; i < 5; i++) {
    watch w;
    memset(&w, 0, sizeof w);
    pktrt_render_desc d = corner_view(&f);
    d.environment = broken_light, d.samples = 1, d.seconds = watch_clock, d.user = &w, w.step = 1;
    d.adaptive = i % 2 != 0, d.pass = watch_pass, w.stop_after = ROUNDS;
    if (i < 2) d.passes = i == 0 ? N : 12;
    if (i == 2 || i == 3) d.target_error = 0.05f;
    if (i == 4) d.time_budget = 5;
    stage_render(s, &d);
    CHECK(f.report.stop == (i < 4 ? PKTRT_STOP_PASSES : PKTRT_STOP_TIME), "case %d", i); /* no target is met so */
    CHECK(f.report.rmse > 0 && f.report.rmse < 1 && f.report.relative_mse > 0 && f.report.relative_mse < 10, "case %d",
        i);
    CHECK(f.report.unknown > PIXELS / 6 && f.report.unknown < PIXELS / 2, "case %d: %llu", i,
        (unsigned long long)f.report.unknown);
  }
  pktrt_render_desc d = film_view(&f);
  vec_put(vec_of(0, 0, 0), d.camera.eye), vec_put(vec_of(0, 0, -1), d.camera.target);
  d.environment = broken_light, d.passes = N;
  stage_render(s, &d);
  for (uint32_t k = 0; k < N; k++) {
    pktrt_render_desc one = film_view(&single[k]);
    one.camera = d.camera, one.environment = broken_light, one.seed = k * PASS_SEED;
    stage_render(s, &one);
  }
  expect(single, N, &want);
  CHECK(want.unknown > 0 && errors_off(&f, &want) == 0, "%zu figures differ; %llu unknown, counted %llu",
      errors_off(&f, &want), (unsigned long long)f.report.unknown, (unsigned long long)want.unknown);
  CHECK(f.block_error[0] < 1 && f.block_error[BLOCKS - 1] > FLT_MAX, "of the last block nothing is known");
  pktrt_scene_destroy(s);
}

/* --- refusals --- */

static pktrt_render_desc plain_view(film *f) { /* what a tile takes, too */
  pktrt_render_desc d = film_view(f);
  d.report = NULL, d.pixel_error = d.block_error = NULL;
  return d;
}

/* Radiance 1 or -1: one-sample passes of a pixel may have a mean of 0, and so may the picture. */
static void signed_light(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) radiance[a][i] = direction[0][i] > 0 ? 1.0f : -1.0f;
}
static void no_number(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user, (void)direction;
  for (uint32_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) radiance[a][i] = NAN;
}

static void odd_pictures(void) {
  float pixels[3];
  unsigned balanced = 0;
  pktrt_report report;
  pktrt_scene *s = stage_open();
  stage_commit(s);
  pktrt_render_desc d;
  memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = d.height = 1, d.pixels = pixels, d.mode = PKTRT_MODE_DRT, d.camera.target[2] = -1, d.report = &report;
  d.environment = signed_light, d.measure = PKTRT_ERROR_RELATIVE, d.passes = 4;
  for (d.seed = 0; d.seed < 40; d.seed++) {
    d.adaptive = d.seed % 2 != 0;
    stage_render(s, &d);
    CHECK(report.samples_max <= 5 && report.relative_mse < INFINITY, "seed %u: %g", d.seed, report.relative_mse);
    balanced += pixels[0] == 0;
  }
  CHECK(balanced > 2, "means of zero do occur: %u", balanced);
  d.environment = no_number, d.adaptive = false, d.passes = 0, d.target_error = 0.1f;
  stage_render(s, &d);
  CHECK(report.unknown == 1 && report.samples_max == 2 && report.stop == PKTRT_STOP_PASSES, "nothing can be known");
  pktrt_scene_destroy(s);
  static const float triangles[2][9] = {{1, 1, -3, 0, 0.5f, -3, 0, 0, -3}, {0, 0, -3, 0, 0, -3, 0, 0, -3}};
  for (int i = 0; i < 2; i++) { /* from high to low; without area */
    pktrt_material lamp = lamp_of(1);
    pktrt_mesh_desc m;
    pktrt_light l = light_of(PKTRT_LIGHT_MESH, 1);
    memset(&m, 0, sizeof m);
    s = stage_open();
    m.positions = triangles[i], m.vertex_count = 3, m.triangle_count = 1;
    CHECK(pktrt_add_material(s, &lamp, &m.material) == PKTRT_OK && pktrt_add_mesh(s, &m, &l.mesh) == PKTRT_OK);
    stage_light(s, &l);
    stage_commit(s);
    d.environment = NULL, d.target_error = 0, d.passes = 1;
    stage_render(s, &d);
    pktrt_scene_destroy(s);
  }
}

/* Progress may reach 1 before the last round: it is a guess. */
static bool refuse_at(void *user, float done) { return done < *(const float *)user; }
static void late_no(void) {
  static film f;
  pktrt_scene *s = stage_open();
  stage_commit(s);
  for (int last = 0; last < 2; last++) {
    float from = last ? 1.0f : 0.2f;
    pktrt_render_desc d = corner_view(&f);
    d.passes = 4, d.samples = 1, d.tile_size = 1024, d.progress = refuse_at, d.user = &from;
    const pktrt_status status = pktrt_render(s, &d);
    CHECK(status == (last ? PKTRT_OK : PKTRT_CANCELLED), "no from %g on: %d", (double)from, (int)status);
    CHECK(f.report.stop == (last ? PKTRT_STOP_PASSES : PKTRT_STOP_CANCELLED) && f.report.rounds == (last ? 4 : 1),
        "%u rounds", (unsigned)f.report.rounds);
  }
  pktrt_scene_destroy(s);
}

static void refused_rules(void) {
  static film f, clean;
  static const struct {
    const char *words;
    uint32_t passes, samples;
    double target, time;
    bool adaptive;
  } bad[] = {{"65537|passes", 65537, 1, 0, 0, false}, {"4294967295|passes", 0xFFFFFFFFu, 1, 0, 0, false},
      {"65536|65536|2^32", 65536, 65536, 0, 0, false}, {"2^32", 65536, 65536, 0, 0, true},
      {"target_error|-0.25", 0, 1, -0.25, 0, false}, {"target_error|nan", 0, 1, (double)NAN, 0, false},
      {"target_error|nan", 4, 1, (double)NAN, 0, true}, {"time_budget|-2", 0, 1, 0, -2, false},
      {"time_budget|nan", 0, 1, 0, (double)NAN, false}, {"target_error|one pass", 1, 64, 0.1, 0, false},
      {"adaptive|rule", 0, 64, 0, 0, true}, {"adaptive|two passes", 1, 64, 0, 0, true},
      {"adaptive|two passes", 1, 64, 0, 3, true}};
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  pktrt_render_desc d = film_view(&clean);
  for (size_t i = 0; i < COUNT(bad); i++) {
    d = plain_view(&f);
    d.passes = bad[i].passes, d.samples = bad[i].samples, d.adaptive = bad[i].adaptive;
    d.target_error = (float)bad[i].target, d.time_budget = bad[i].time;
    CHECK(pktrt_render_tile(s, &d, 0, 0, 4, 4) == PKTRT_INVALID_ARGUMENT, "%s: a tile", bad[i].words);
    CHECK(pktrt_render(s, &d) == PKTRT_INVALID_ARGUMENT, "%s", bad[i].words);
    char words[64];
    snprintf(words, sizeof words, "%s", bad[i].words);
    for (char *at = words; at;) {
      char *const end = strchr(at, '|');
      if (end) *end = 0;
      CHECK(strstr(pktrt_last_error(s), at) != NULL, "\"%s\" names no %s", pktrt_last_error(s), at);
      at = end ? end + 1 : NULL;
    }
  }
  for (int value = -1; value <= 3; value += 4) {
    d = film_view(&f), d.measure = (pktrt_error_measure)value, d.passes = 2;
    CHECK(pktrt_render(s, &d) == PKTRT_INVALID_ARGUMENT && strstr(pktrt_last_error(s), "pktrt_error_measure"), "%d",
        value);
  }
  CHECK(same_bits(&f, &clean, sizeof f), "refused calls write nothing");
  d = film_view(&f), d.trust_estimates = true, d.passes = 65536, d.samples = 65535,
  d.target_error = FLT_MAX; /* just within the limits */
  d.width = d.height = 1;
  CHECK(pktrt_render(s, &d) == PKTRT_OK && f.report.rounds == 2 && f.count[0] == 2 * 65535, "%s", pktrt_last_error(s));
  pktrt_scene_destroy(s);
}

/* A tile knows no error of a picture. */
static void refused_tiles(void) {
  static film f;
  static watch w;
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  for (int i = 0; i < 10; i++) {
    pktrt_render_desc d = plain_view(&f);
    d.passes = 3, d.user = &w;
    switch (i) {
    case 0: d.adaptive = true; break;
    case 1: d.pass = watch_pass; break;
    case 2: d.report = &f.report; break;
    case 3: d.pixel_error = f.pixel_error; break;
    case 4: d.block_error = f.block_error; break;
    case 5: d.target_error = 0.1f; break;
    case 6: d.time_budget = 1; break;
    case 7: d.passes = 0, d.target_error = 0.1f; break;
    case 8: d.passes = 0, d.time_budget = 1; break;
    default: break; /* the control */
    }
    CHECK(pktrt_render_tile(s, &d, 4, 4, 4, 4) == (i < 9 ? PKTRT_INVALID_ARGUMENT : PKTRT_OK), "case %d", i);
    CHECK((f.count[4 * W + 4] == 3) == (i == 9), "case %d", i);
  }
  pktrt_scene_destroy(s);
}

/* Tiles by hand, of sizes that are no multiple of a block, backwards. */
static void tiles_by_hand(void) {
  static film want, got;
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  for (uint32_t samples = 1; samples < 4; samples += 2) {
    pktrt_render_desc d = plain_view(&want);
    d.passes = 3, d.samples = samples;
    stage_render(s, &d);
    d = plain_view(&got), d.passes = 3, d.samples = samples;
    for (uint32_t y = H; y > 0; y -= 12)
      for (uint32_t x = W; x > 0; x -= 8) CHECK(pktrt_render_tile(s, &d, x - 8, y - 12, 8, 12) == PKTRT_OK);
    CHECK(same_bits(&got, &want, offsetof(film, pixel_error)) && same_bits(got.count, want.count, sizeof got.count));
    CHECK(got.count[0] == 3 * samples, "%u samples", got.count[0]);
    d.passes = 2;
    CHECK(pktrt_render_tile(s, &d, 0, 18, W, 1) == PKTRT_OK, "%u samples", samples);
    CHECK(!same_bits(&got.pixels[18 * W * 3], &want.pixels[18 * W * 3], W * 12), "the control: two passes are others");
  }
  pktrt_scene_destroy(s);
}

/* One pass of a view by tiles of 8 x 12 pixels, backwards, from two scenes in turns, onto the sums. */
static void add_pass_by_hand(
    pktrt_scene *const s[2], const pktrt_render_desc *d, uint32_t pass, pktrt_pixel_sums *sums) {
  double means[8 * 12 * 3];
  for (uint32_t y = H; y > 0; y -= 12)
    for (uint32_t x = W; x > 0; x -= 8) {
      CHECK(pktrt_render_pass(s[(x / 8 + y / 12) % 2], d, pass, x - 8, y - 12, 8, 12, means) == PKTRT_OK);
      for (uint32_t row = 0; row < 12; row++)
        pktrt_add_pass(means + (size_t)row * 8 * 3, 8, &sums[(y - 12 + row) * W + x - 8]);
    }
}

/* Passes from several places, scalar and with vectors, and what an empty scene makes of them, are the picture's. */
static void passes_by_hand(void) {
  static film want, got;
  static pktrt_pixel_sums sums[PIXELS], other[PIXELS];
  pktrt_scene *const s[2] = {room(PKTRT_ISA_AUTO, 0), room(isas[0], 0)}, *empty = stage_open();
  for (uint32_t i = 0; i < 6; i++) { /* one pass, several, and those that a rule asks for */
    pktrt_render_desc d[2];
    for (int k = 0; k < 2; k++) {
      d[k] = film_view(k ? &got : &want);
      d[k].depth = d[k].normal = d[k].albedo = NULL, d[k].sample_count = NULL;
      d[k].samples = 1 + i % 2 * 2, d[k].passes = i < 2 ? 1 : i < 4 ? 3 : 0;
      d[k].target_error = i < 4 ? 0 : 0.03f;
      d[k].measure = i == 5 ? PKTRT_ERROR_RELATIVE : PKTRT_ERROR_RMSE;
    }
    stage_render(s[0], &d[0]);
    memset(sums, 0, sizeof sums);
    uint32_t passes = 0;
    do {
      float *const pixels = d[1].pixels;
      d[1].pixels = NULL;
      add_pass_by_hand(s, &d[1], passes++, sums);
      d[1].pixels = pixels;
      CHECK(pktrt_finish_passes(empty, &d[1], passes, sums) == PKTRT_OK, "%s", pktrt_last_error(empty));
    } while (got.report.stop == PKTRT_STOP_NOT_YET && passes < ROUNDS);
    CHECK(same_bits(&got, &want, offsetof(film, report)) && same_report(&got.report, &want.report),
        "case %u: %u passes, %u", i, got.report.rounds, want.report.rounds);
    CHECK((i < 4) == (passes <= 3) && passes < ROUNDS, "the control: the rule asks for %u passes", passes);
    memset(other, 0, sizeof other);
    for (uint32_t k = passes; k > 0; k--) add_pass_by_hand(s, &d[1], k - 1, other);
    CHECK(same_bits(sums, other, sizeof sums) == (passes == 1), "the control: in another order sums are others");
  }
  pktrt_scene_destroy(empty), pktrt_scene_destroy(s[0]), pktrt_scene_destroy(s[1]);
}

/* Neither of the calls can do what needs all passes in one place; nothing is written then. */
static void refused_passes(void) {
  static film f;
  static pktrt_pixel_sums sums[PIXELS];
  double means[3] = {-7, -7, -7};
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  for (int i = 0; i < 9; i++) {
    pktrt_render_desc d = plain_view(&f);
    const pktrt_status status = i < 8 ? PKTRT_INVALID_ARGUMENT : PKTRT_OK;
    d.depth = d.normal = d.albedo = NULL, d.sample_count = NULL, d.passes = 3;
    switch (i) {
    case 0: d.adaptive = true; break;
    case 1: d.time_budget = 1; break;
    case 2: d.depth = f.depth; break;
    case 3: d.normal = f.normal; break;
    case 4: d.albedo = f.albedo; break;
    case 5: d.sample_count = f.count; break;
    case 6: d.cost = f.depth; break;
    case 7: d.samples = 65537; break;
    default: break; /* the control */
    }
    CHECK(pktrt_render_pass(s, &d, 2, 4, 4, 1, 1, means) == status && (means[0] < 0) == (i < 8), "case %d", i);
    CHECK(pktrt_finish_passes(s, &d, 3, sums) == status && (f.pixels[0] < 0) == (i < 8), "case %d", i);
    CHECK(i == 8 || strlen(pktrt_last_error(s)) > 10, "case %d: \"%s\"", i, pktrt_last_error(s));
    if (i < 8) continue;
    CHECK(pktrt_render_pass(s, &d, 3, 4, 4, 1, 1, means) == PKTRT_INVALID_ARGUMENT, "beyond the last pass");
    CHECK(pktrt_render_pass(s, &d, 0, W, 4, 1, 1, means) == PKTRT_INVALID_ARGUMENT, "beyond the right border");
    CHECK(pktrt_render_pass(s, &d, 0, 4, 4, 1, 1, NULL) == PKTRT_INVALID_ARGUMENT, "nowhere to write to");
    CHECK(pktrt_render_pass(s, NULL, 0, 4, 4, 1, 1, means) == PKTRT_INVALID_ARGUMENT, "no description");
    CHECK(pktrt_render_pass(s, &d, 0, 4, 4, 0, 1, means) == PKTRT_OK, "an empty tile is fine");
    CHECK(pktrt_finish_passes(s, &d, 4, sums) == PKTRT_INVALID_ARGUMENT && strstr(pktrt_last_error(s), "4 of 1 to 3"));
    CHECK(pktrt_finish_passes(s, &d, 0, sums) == PKTRT_INVALID_ARGUMENT, "no pass");
    CHECK(pktrt_finish_passes(s, &d, 3, NULL) == PKTRT_INVALID_ARGUMENT && strstr(pktrt_last_error(s), "no sums"));
    CHECK(pktrt_finish_passes(s, NULL, 3, sums) == PKTRT_INVALID_ARGUMENT);
    CHECK(pktrt_finish_passes(NULL, &d, 3, sums) == PKTRT_INVALID_ARGUMENT);
  }
  pktrt_scene_destroy(s);
}

/* --- memory --- */

enum { SMALL = 20 };

static pktrt_render_desc small_view(film *f, pktrt_stats *stats) {
  pktrt_render_desc d = film_view(f);
  d.width = d.height = SMALL, d.tile_size = 16, d.passes = 4, d.adaptive = true, d.stats = stats, d.max_depth = 2;
  memset(stats, 0, sizeof *stats);
  return d;
}

/* Each allocation failing in turn, in all rounds of adaptive passes: a status, whole pixels, no leak. */
static void failing_allocations(void) {
  static film f, want;
  static pktrt_stats stats;
  size_t n = 1, later = 0;
  pktrt_scene *s = room(PKTRT_ISA_AUTO, 0);
  pktrt_render_desc d = small_view(&want, &stats);
  stage_render(s, &d);
  CHECK(stats.samples == (uint64_t)(want.report.samples_mean * SMALL * SMALL + 0.5), "the statistics count all passes");
  for (pktrt_status status = PKTRT_OUT_OF_MEMORY; status != PKTRT_OK && n < 10000; n++) {
    const size_t blocks = hooks.live_blocks;
    d = small_view(&f, &stats);
    hooks.fail_at = n, hooks.fail_after = n % 2 == 0, hooks.failed = 0;
    status = pktrt_render(s, &d);
    hooks.fail_at = 0, hooks.fail_after = false;
    CHECK(hooks.live_blocks == blocks, "allocation %zu: %zu blocks are left", n, hooks.live_blocks - blocks);
    if (status == PKTRT_OK) break;
    CHECK(status == PKTRT_OUT_OF_MEMORY && strstr(pktrt_last_error(s), "memory"), "%zu: %s", n, pktrt_last_error(s));
    if (!f.report.rounds) continue;
    later++;
    bool whole = f.report.stop == PKTRT_STOP_CANCELLED;
    for (size_t i = 0; i < SMALL * SMALL * 3; i++) whole &= f.pixels[i] >= 0 && f.count[i / 3] >= 2;
    CHECK(whole, "allocation %zu: the picture has holes", n);
  }
  CHECK(hooks.failed == 0 && same_bits(f.pixels, want.pixels, SMALL * SMALL * 12), "the picture in the end");
  say("%zu allocations failed in turn, %zu of them in later rounds", n - 1, later);
  CHECK(n > 10 && later > 3, "the control: rounds allocate");
  pktrt_scene_destroy(s);
}

void suite_passes(void) {
  run("a picture after n passes is the mean of n pictures of their seeds, bit for bit", mean_of_singles);
  run("so it is, but for rounding, with several samples for each pass", mean_of_larger_singles);
  run("errors that are asked for alone are those that are asked for together", errors_alone);
  run("passes of one sample smooth edges without distribution as well", passes_smooth_edges);
  run("one pass is the picture without passes, and takes no more memory", one_pass);
  run("errors are those of the formulas", formulas);
  run("passes know the error where the scatter within a set does not", scatter_within_a_set);
  run("passes, errors and reports have the same bits for all settings, workers and threads", same_whatever);
  run("each rule stops after the right round, and of several the first", stop_rules);
  run("a target error does not end passes whose estimate is unreliable, unless it is trusted", unreliable_estimates);
  run("from 16 passes on the doubt of an unreliable estimate is capped", doubt_is_capped);
  run("time budgets are used, and kept", budgets_kept);
  run("a clock that is set back counts as no time", clock_set_back);
  run("a picture cancelled in a later pass is whole", cancelled_later);
  run("progress grows over passes", progress_grows);
  run("adaptive passes go where the noise is, and lower the error", passes_go_where_noise_is);
  run("the mean of adaptive pictures is right where light is rare", mean_is_right);
  run("adaptive rounds end for every size of picture", every_size_ends);
  run("where there is no error all rules end", still_pictures);
  run("pixels that are not finite are counted and left out of the error", unknown_pixels);
  run("means of zero, pictures without any number and lights of one triangle end like others", odd_pictures);
  run("a no after the last tile cancels what another round would follow", late_no);
  run("contradictory rules are refused by name", refused_rules);
  run("tiles refuse what needs the whole picture", refused_tiles);
  run("tiles make the passes of the picture", tiles_by_hand);
  run("passes made in several places are those of one picture, and so are errors and rules", passes_by_hand);
  run("they refuse what needs all passes in one place", refused_passes);
  run("each allocation of several rounds failing in turn leaks nothing", failing_allocations);
}
