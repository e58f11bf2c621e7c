/* Shading at its extremes: white furnaces, Fresnel, highlights of any exponent, mirrors without end, lights without
   size, lenses and shutters of none. Expectations are closed forms or quadrature in double. Every picture is rendered
   by every instruction set, and has to be the same. */
#include "pictures.h"
#include "stability.h"

static const char *const part = "shading";
static const double ulp = 0x1p-24; /* half of one: what rounding a float near 1 may change */
enum { SETS = 8 };

/* --- a scene for each instruction set, and what is counted of every picture --- */

typedef struct stages {
  pktrt_scene *scene[SETS];
} stages;

typedef struct tally {
  uint64_t rays, odd[SETS], differ[SETS]; /* rays: by each set */
  uint64_t aside, aside_of;               /* the control of differ: values that another picture has otherwise */
  pktrt_stats stats;                      /* of the last picture */
} tally;

static stages stages_open(void (*build)(pktrt_scene *, const void *), const void *what) {
  stages s;
  for (int i = 0; i < isa_count; i++) {
    pktrt_scene_desc d = scene_desc_of(isas[i], 0);
    s.scene[i] = pktrt_scene_create(&d);
    if (!CHECK(s.scene[i] != NULL, "%s", pktrt_last_error(NULL))) abort();
    build(s.scene[i], what);
    stage_commit(s.scene[i]);
  }
  return s;
}

static void stages_close(stages *s) {
  for (int i = 0; i < isa_count; i++) pktrt_scene_destroy(s->scene[i]);
}

static size_t values_of(const pktrt_render_desc *d) { return (size_t)d->width * d->height * 3; }

static uint64_t odd_values(const float *p, size_t n) {
  uint64_t odd = 0;
  for (size_t i = 0; i < n; i++) odd += !(p[i] >= 0 && p[i] <= FLT_MAX);
  return odd;
}

static uint64_t apart(const float *p, const float *q, size_t n) {
  uint64_t differ = 0;
  for (size_t i = 0; i < n; i++) differ += !same_bits(p + i, q + i, sizeof *p);
  return differ;
}

/* The picture goes to d->pixels; `other` is as large, for those of the other instruction sets. */
static void render_all(const stages *s, const pktrt_render_desc *d, float *other, tally *t) {
  const size_t n = values_of(d);
  memset(&t->stats, 0, sizeof t->stats);
  for (int i = 0; i < isa_count; i++) {
    pktrt_render_desc e = *d;
    if (i) e.pixels = other;
    else e.stats = &t->stats;
    stage_render(s->scene[i], &e);
    t->odd[i] += odd_values(e.pixels, n);
    if (i) t->differ[i] += apart(d->pixels, other, n);
  }
  for (int i = 0; i < PKTRT_RAY_TYPE_COUNT; i++) t->rays += t->stats.by_type[i].rays;
}

static void compare_aside(const float *p, const float *q, size_t n, tally *t) {
  t->aside += apart(p, q, n), t->aside_of += n;
}

static const char *const differing = "values that differ between instruction sets",
                         *const spoilt = "values that are negative or not finite";

static void report(const char *name, const tally *t, const char *control) {
  for (int i = 0; i < isa_count; i++) {
    count_figure(part, name, isas[i], t->rays, spoilt, t->odd[i]);
    count_figure(part, name, isas[i], t->rays, differing, t->differ[i]);
  }
  if (t->aside_of) control_figure(part, name, differing, control, t->aside_of, t->aside);
}

static uint32_t side_of(size_t rays) { return (uint32_t)ceil(sqrt((double)rays)); } /* of a picture of so many pixels */

static void add_floor(pktrt_scene *s, const pktrt_material *m, double half) {
  const quad q = quad_of(vec_of(0, 0, 0), vec_of(0, 0, half), vec_of(half, 0, 0));
  stage_quad(s, &q, stage_material(s, m));
}

/* --- the white furnace: a surface in a world that shines with radiance 1 from everywhere --- */

/* Lobes lose what would go below the surface: their albedo is the share of the lobe above it. Choosing one way at
   glass is random too. Whatever happens with a chance that makes fewer than ten such events likely is not judged by a
   standard error: it may not have happened at all. */
enum { SEEDS = 32, FURNACES = 64 };
static const double view_angles[] = {0, 50, 80, 89, 89.9};

typedef struct furnace {
  char name[64]; /* of a case, to which all with the same name belong */
  pktrt_material look;
  pktrt_branching branching;
  pktrt_phong_mapping mapping;
  bool inside;
} furnace;

static double lobe_share(const pktrt_material *m, double angle) {
  return m->lobe == PKTRT_LOBE_PHONG ? lobe_moment((double)m->exponent, angle, 0) : 1;
}

static double ior_of(const pktrt_material *m) { return m->ior[0] > 0 ? (double)m->ior[0] : 1.5; }

/* The directional albedo, and the chance of what happens seldom. */
static double furnace_albedo(const furnace *f, double cosine, double share, int channel, double *chance) {
  const pktrt_material *m = &f->look;
  const double base = (double)m->albedo[channel], tint = (double)m->reflectance[channel];
  const double r = fresnel_exact(cosine, f->inside ? 1 / ior_of(m) : ior_of(m)), factor = tint > 0 ? tint : 1;
  *chance = fabs(2 * share - floor(2 * share + 0.5)) / 2; /* also of what is not even: samples are stratified */
  switch (m->specular) {
  case PKTRT_SPECULAR_NONE: return base;
  case PKTRT_SPECULAR_MIRROR: return base + tint * share;
  case PKTRT_SPECULAR_COAT: return (1 - r) * base + factor * r * share;
  case PKTRT_SPECULAR_CONDUCTOR:
    return factor * share * conductor_exact(cosine, (double)m->ior[channel], (double)m->extinction[channel]);
  default:
    if (factor < 1 && f->branching == PKTRT_BRANCHING_CHOOSE) *chance = fmin(r, 1 - r);
    return factor * r + (1 - r);
  }
}

static void furnace_build(pktrt_scene *s, const void *what) {
  const furnace *f = what;
  const pktrt_light around = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
  add_floor(s, &f->look, 100);
  stage_light(s, &around);
}

typedef struct furnace_sums { /* over a case */
  size_t compared, seldom, beyond, control;
  double error, deviation; /* largest, the second in standard errors */
} furnace_sums;

static void judge(furnace_sums *sums, const furnace *f, double cosine, double share, size_t samples, const double *mean,
    const double *error) {
  for (int k = 0; k < (f->look.specular == PKTRT_SPECULAR_CONDUCTOR ? 3 : 1); k++) {
    double chance;
    const double want = furnace_albedo(f, cosine, share, k, &chance), off = fabs(mean[k] - want);
    if (chance > 1e-5 && chance * (double)samples < 10) {
      sums->seldom++;
      continue;
    }
    const double beyond = fmax(off - 1e-5, 0);
    sums->compared++;
    sums->beyond += !(off <= 4 * error[k] + 1e-5);
    sums->control += fabs(mean[k] - 0.99 * want) > 4 * error[k] + 1e-5;
    sums->error = fmax(sums->error, error[k]);
    if (beyond > 0) sums->deviation = fmax(sums->deviation, beyond / error[k]);
  }
}

/* One angle of view, SEEDS pictures of a spot, of so many samples each. Few pixels with many samples: these err the
   less the more of them are one set. */
static void furnace_at(const furnace *f, const stages *s, double degrees, size_t each, furnace_sums *sums, tally *t) {
  const double angle = degrees * PI / 180, side = f->inside ? -2 : 2;
  pktrt_render_desc d = stage_spot(vec_of(-2 * sin(angle), side * cos(angle), 0), vec_of(0, 0, 0));
  d.width = 2, d.height = 1, d.samples = (uint32_t)(each / 2) + 1;
  d.camera.fov_y = 1e-3f, d.branching = f->branching, d.phong_mapping = f->mapping;
  for (int k = 0; k < 3; k++) d.background[k] = 1;
  const size_t n = values_of(&d);
  float *last = stage_pixels(n), *other = stage_pixels(n);
  double mean[3] = {0, 0, 0}, squares[3] = {0, 0, 0}, error[3];
  d.pixels = stage_pixels(n);
  for (uint32_t seed = 0; seed < SEEDS; seed++) {
    d.seed = (uint32_t)mix64(seed + (run_seed << 32));
    render_all(s, &d, other, t);
    for (size_t k = 0; k < 3; k++) {
      double sum = 0;
      for (size_t i = k; i < n; i += 3) sum += (double)d.pixels[i] * 3 / (double)n;
      mean[k] += sum / SEEDS, squares[k] += sum * sum / SEEDS;
    }
    if (seed) compare_aside(d.pixels, last, n, t);
    memcpy(last, d.pixels, n * sizeof *last);
  }
  for (int k = 0; k < 3; k++) error[k] = sqrt(fmax(squares[k] - mean[k] * mean[k], 0) / (SEEDS - 1));
  const vec eye = vec_from(d.camera.eye);
  const double cosine = fabs(eye.y) / vec_length(eye), share = lobe_share(&f->look, acos(cosine));
  judge(sums, f, cosine, share, (size_t)SEEDS * d.width * d.height * d.samples, mean, error);
  free(d.pixels), free(last), free(other);
}

/* A case: the furnaces from the i-th name on. A sample is 1.6 rays at least, for not much is lost. */
static void furnace_job(void *arg, size_t i) {
  const furnace *f = arg;
  for (; i; f++) i -= strcmp(f[0].name, f[1].name) != 0;
  size_t n = 1;
  while (strcmp(f[0].name, f[n].name) == 0) n++;
  const size_t each = (size_t)((double)thorough(1000000) / 1.6) / (n * COUNT(view_angles) * SEEDS);
  furnace_sums sums = {0, 0, 0, 0, 0, 0};
  tally t;
  memset(&t, 0, sizeof t);
  for (size_t k = 0; k < n; k++) {
    stages s = stages_open(furnace_build, f + k);
    for (size_t a = 0; a < COUNT(view_angles); a++) furnace_at(f + k, &s, view_angles[a], each, &sums, &t);
    stages_close(&s);
  }
  CHECK(thoroughness < 1 || sums.seldom == 0, "%s: %zu cannot be judged", f->name, sums.seldom);
  report(f->name, &t, "another seed");
  count_figure(part, f->name, PKTRT_ISA_AUTO, sums.compared, "furnaces beyond 4 standard errors", sums.beyond);
  control_figure(part, f->name, "furnaces beyond 4 standard errors", "albedo less by 1%", sums.compared, sums.control);
  /* what has an edge errs as the number of stratified samples to the power of 3/4 */
  value_figure(part, f->name, PKTRT_ISA_AUTO, t.rays, "largest standard error", sums.error,
      1e-3 * pow(fmin(thoroughness, 1), -0.75));
  value_figure(part, f->name, PKTRT_ISA_AUTO, t.rays, "largest error in standard errors", sums.deviation, 4);
}

static const float gold_n[3] = {0.17f, 0.42f, 1.4f}, gold_k[3] = {3.1f, 2.35f, 1.9f};

static furnace furnace_of(const char *name, double albedo, pktrt_specular specular, double reflectance) {
  furnace f;
  memset(&f, 0, sizeof f);
  snprintf(f.name, sizeof f.name, "furnace: %s", name);
  f.look = material_of(albedo, specular, reflectance);
  if (specular == PKTRT_SPECULAR_CONDUCTOR) memcpy(f.look.ior, gold_n, 12), memcpy(f.look.extinction, gold_k, 12);
  return f;
}

static size_t smooth_furnaces(furnace *f) {
  static const float iors[4] = {1, 1.000001f, 1.5f, 1000};
  size_t n = 0;
  f[n++] = furnace_of("diffuse and mirror", 1, PKTRT_SPECULAR_NONE, 0);
  f[n++] = furnace_of("diffuse and mirror", 0, PKTRT_SPECULAR_MIRROR, 1);
  f[n++] = furnace_of("diffuse and mirror", 0.25, PKTRT_SPECULAR_MIRROR, 0.75);
  f[n++] = furnace_of("coat", 1, PKTRT_SPECULAR_COAT, 0);
  f[n++] = furnace_of("coat", 0.5, PKTRT_SPECULAR_COAT, 0);
  f[n++] = furnace_of("coat", 0.5, PKTRT_SPECULAR_COAT, 0.25);
  f[n++] = furnace_of("gold", 0, PKTRT_SPECULAR_CONDUCTOR, 0);
  for (size_t i = 0; i < 4 * 6; i++, n++) { /* choosing, both ways, choosing with a quarter reflected; both sides */
    char name[64];
    if (i < 12) snprintf(name, sizeof name, "glass 1 and 1.000001");
    else snprintf(name, sizeof name, "glass %.7g", (double)iors[i / 6]);
    f[n] = furnace_of(name, 0, PKTRT_SPECULAR_DIELECTRIC, i % 3 == 2 ? 0.25 : 0);
    f[n].look.ior[0] = iors[i / 6], f[n].inside = i / 3 % 2;
    f[n].branching = i % 3 == 1 ? PKTRT_BRANCHING_BOTH : PKTRT_BRANCHING_CHOOSE;
  }
  return n;
}

static size_t lobed_furnaces(furnace *f) {
  static const float exponents[5] = {0, 1, 10, 1e3f, 1e6f};
  static const char *const names[4] = {"lobe of a mirror", "lobe of a mirror, naive", "lobe of a coat", "lobe of gold"};
  static const pktrt_specular kinds[4] = {
      PKTRT_SPECULAR_MIRROR, PKTRT_SPECULAR_MIRROR, PKTRT_SPECULAR_COAT, PKTRT_SPECULAR_CONDUCTOR};
  for (size_t i = 0; i < 20; i++) {
    f[i] = furnace_of(names[i / 5], i / 5 == 2 ? 0.5 : 0, kinds[i / 5], i / 5 < 2);
    f[i].look.lobe = PKTRT_LOBE_PHONG, f[i].look.exponent = exponents[i % 5];
    f[i].mapping = i / 5 == 1 ? PKTRT_PHONG_NAIVE : PKTRT_PHONG_CAREFUL;
  }
  return 20;
}

/* The quadrature: straight on nothing is lost, at a right angle one half; a lobe of exponent 0 loses angle / pi, one of
   exponent 1 (1 - cos) / 2. */
static void check_quadrature(void) {
  for (int i = 0; i <= 9; i++) {
    const double angle = i * PI / 18;
    CHECK(fabs(lobe_moment(0, angle, 0) - (1 - angle / PI)) < 1e-6, "exponent 0, %d degrees", 10 * i);
    CHECK(fabs(lobe_moment(1, angle, 0) - (1 + cos(angle)) / 2) < 1e-6, "exponent 1, %d degrees", 10 * i);
    CHECK(fabs(lobe_moment(pow(10, i), 0, 0) - 1) < 1e-12, "exponent 1e%d, straight on", i);
    CHECK(fabs(lobe_moment(pow(10, i), PI / 2, 0) - 0.5) < 1e-6, "exponent 1e%d, grazing", i);
  }
}

static void furnaces(void) {
  furnace *f = calloc(FURNACES, sizeof *f);
  if (!f) abort();
  size_t n = smooth_furnaces(f);
  n += lobed_furnaces(f + n);
  if (!CHECK(n < FURNACES)) abort(); /* the last one has no name */
  size_t cases = 0;
  for (size_t i = 0; i < n; i++) cases += strcmp(f[i].name, f[i + 1].name) != 0;
  check_quadrature();
  jobs_for(cases, furnace_job, f);
  say("%zu materials in %zu cases, %zu angles", n, cases, COUNT(view_angles));
  free(f);
}

/* --- spheres in the furnace --- */

/* Facets of glass can trap a ray until the depth limit cuts it off. That is all that may be missing; choosing one
   way, each ray that is cut off is a sample. */
typedef struct ball {
  const char *name; /* of a case, to which two in a row belong */
  double albedo;
  pktrt_specular specular;
  double reflectance;
  pktrt_mode mode;
  uint32_t depth;
} ball;
static const ball balls[] = {{"sphere: diffuse and coated", 0.7, PKTRT_SPECULAR_NONE, 0, PKTRT_MODE_DRT, 50},
    {"sphere: diffuse and coated", 1, PKTRT_SPECULAR_COAT, 0, PKTRT_MODE_DRT, 50},
    {"sphere: mirror", 0, PKTRT_SPECULAR_MIRROR, 1, PKTRT_MODE_DRT, 50},
    {"sphere: mirror", 0, PKTRT_SPECULAR_MIRROR, 1, PKTRT_MODE_WRT, 50},
    {"sphere: glass, DRT", 0, PKTRT_SPECULAR_DIELECTRIC, 0, PKTRT_MODE_DRT, 50},
    {"sphere: glass, DRT", 0, PKTRT_SPECULAR_DIELECTRIC, 0, PKTRT_MODE_DRT, 3},
    {"sphere: glass, WRT", 0, PKTRT_SPECULAR_DIELECTRIC, 0, PKTRT_MODE_WRT, 50},
    {"sphere: glass, WRT", 0, PKTRT_SPECULAR_DIELECTRIC, 0, PKTRT_MODE_WRT, 3}};

static void ball_build(pktrt_scene *s, const void *what) {
  const ball *b = what;
  const pktrt_material m = material_of(b->albedo, b->specular, b->reflectance);
  const pktrt_light around = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
  mesh sphere = mesh_sphere(4, 0, 1);
  stage_mesh(s, &sphere, stage_material(s, &m));
  stage_light(s, &around);
  mesh_free(&sphere);
}

/* Which pixels are brighter than they may be, or darker where nothing is cut off; what is lost beyond what is cut
   off. */
static void check_ball(const ball *b, const pktrt_render_desc *d, const tally *t, double cut) {
  const double want = b->specular == PKTRT_SPECULAR_NONE ? (double)(float)b->albedo : 1;
  const bool glass = b->specular == PKTRT_SPECULAR_DIELECTRIC, cuts = glass && b->depth < 50;
  const size_t n = values_of(d);
  uint64_t wrong = 0, control = 0;
  double lost = 0;
  for (size_t i = 0; i < n; i += 3) {
    const double v = (double)d->pixels[i];
    wrong += !(v <= want + 1e-5) || (!glass && v < want - 1e-5);
    control += v > 0.99 * want + 1e-5;
    lost += (want - v) * d->samples;
  }
  count_figure(part, b->name, PKTRT_ISA_AUTO, t->rays, "pixels of spheres too bright or too dark", wrong);
  control_figure(part, b->name, "pixels of spheres too bright or too dark", "albedo less by 1%", n / 3, control);
  const double samples = (double)(n / 3) * d->samples;
  if (d->mode == PKTRT_MODE_DRT)
    CHECK(fabs(lost - cut) < 1e-7 * samples + 0.01, "%s: %.4f lost, %g cut off", b->name, lost, cut);
  CHECK(cuts || lost < 0.002 * samples, "%s: %.4f samples of %g lost", b->name, lost, samples);
  CHECK(!cuts || lost > 1e-3 * samples, "%s: the control: %.4f samples of %g lost", b->name, lost, samples);
}

static void ball_job(void *arg, size_t i) {
  const ball *b = (const ball *)arg + i;
  const bool drt = b->mode == PKTRT_MODE_DRT, glass = b->specular == PKTRT_SPECULAR_DIELECTRIC;
  stages s = stages_open(ball_build, b);
  /* rays of a sample: one more that it sends out; at glass some more, and two at each of 50 facets where it branches */
  const size_t rays = b->specular == PKTRT_SPECULAR_COAT ? 3 : !glass ? 2 : drt ? 3 : b->depth == 50 ? 90 : 7;
  const uint32_t side = side_of(thorough(500000) / rays / (drt ? 4 : 1) + 64);
  const size_t n = (size_t)side * side * 3;
  pktrt_render_desc d = stage_view(b->mode, side, side, stage_pixels(n), vec_of(0.1, 0.7, 3), vec_of(0, 0, 0));
  for (int k = 0; k < 3; k++) d.background[k] = 1;
  d.camera.fov_y = 22, d.max_depth = b->depth, d.samples = drt ? 4 : 1;
  float *other = stage_pixels(n);
  tally t;
  memset(&t, 0, sizeof t);
  render_all(&s, &d, other, &t);
  report(b->name, &t, "");
  check_ball(b, &d, &t, glass ? (double)t.stats.by_depth[b->depth].hits : 0);
  stages_close(&s);
  free(d.pixels), free(other);
}

static void spheres(void) { jobs_for(COUNT(balls), ball_job, (void *)(uintptr_t)balls); }

/* --- Fresnel --- */

/* A floor of glass between a sky that shines in red above and in green below, and in blue everywhere: rays end there,
   so red is what is reflected and green is what passes, or the other way from inside. Seen at all angles, and closely
   at those where something happens. The eye is so near the floor, and the floor so large, that rays with a cosine
   above 2e-5 hit.

   What rounding may change, in units of u = 2^-24. Directions are rounded (1), divided by their largest component
   (1), their length comes from squares that are as far off (2, and 1.5 for sums, and 1 for the root), they are
   divided by it (1): each component is off by less than 8 u of itself, and so is the cosine c, for the normal is an
   axis. k = eta^2 c'^2 = eta^2 - (1 - c^2) takes 16 u c^2 from c. For eta >= 1/2 it is c^2 + (eta - 1) (eta + 1): u c^2
   for the square, 3 u |eta^2 - 1| for the product, u |k| for the sum, and from below, where eta = 1 / ior is rounded, 2 u
   eta^2. For eta < 1/2 it is eta^2 - (1 - c) (1 + c): 3 u eta^2, 3 u (1 - c^2), u |k|. Amplitudes (c - eta c') / (c + eta
   c') are off by 8 u if c' and c are given and by half of what c' is, of itself, 4 u with the root, eta and the division:
   hence F by 20 u, and 8 u are left for the sum and the weights. So F must lie within 28 u of the values for c (1 +- 8 u)
   and k +- that error, and between: near the critical angle a small error of k is a large one of F, as in nature.

   Where eta is 1, nothing changes, and nothing may be seen. */
enum { FRESNEL_PLACES = 5 };
static const double least_cosine = 2e-5;

static void sky_of_channels(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  const float *bright = user;
  for (uint32_t i = 0; i < n; i++) {
    radiance[0][i] = direction[1][i] > 0 ? *bright : 0.f;
    radiance[1][i] = direction[1][i] > 0 ? 0.f : *bright;
    radiance[2][i] = *bright;
  }
}

static double fresnel_of(double c, double k, double eta) {
  if (!(k > 0)) return 1;
  const double t = sqrt(k) / eta, s = (c - eta * t) / (c + eta * t), p = (eta * c - t) / (eta * c + t);
  return (s * s + p * p) / 2;
}

typedef struct window { /* a value, and how far rounding may take it */
  double want, slack;
  bool total, not_total; /* certainly */
} window;

static window fresnel_window(double c, double eta, bool from_below) {
  const double c2 = c * c, e2 = eta * eta, s2 = (1 - c) * (1 + c), k = eta < 0.5 ? e2 - s2 : c2 + (eta - 1) * (eta + 1);
  const double e =
      ulp * (16 * c2 + fabs(k) + (eta < 0.5 ? 3 * e2 + 3 * s2 : c2 + 3 * fabs(e2 - 1) + (from_below ? 2 * e2 : 0)));
  window w = {fresnel_of(c, k, eta), 0, k + e<0, k - e> 0};
  for (int i = 0; i < 8; i++) { /* between the ends, amplitudes may be zero */
    const double turn = i < 6 ? e2 * e2 * c2 : c2, at = i < 2 ? k - e : i < 4 ? k + e : turn;
    if (fabs(at - k) > e * 1.000001) continue;
    const double near = fresnel_of(fmin(c * (i & 1 ? 1 + 8 * ulp : 1 - 8 * ulp), 1), at, eta);
    w.slack = fmax(w.slack, fabs(near - w.want));
  }
  w.slack += 28 * ulp;
  return w;
}

typedef struct fresnel_sums {
  uint64_t checked, beyond, beyond_control, total, partial, partial_control, seen;
  double worst, worst_part; /* error, and error as a part of what rounding may do, away from the critical angle */
} fresnel_sums;

static void check_reflectances(const pktrt_render_desc *d, double side, double ior, fresnel_sums *sums) {
  const double eta = side > 0 ? ior : 1 / ior;
  for (uint32_t i = 0; i < d->width * d->height; i++) {
    const vec v = stage_through(&d->camera, i % d->width + 0.5, i / d->width + 0.5, d->width, d->height);
    const double c = -v.y * side;
    if (c < least_cosine) continue;
    const window w = fresnel_window(c, eta, side < 0), other = fresnel_window(c, eta * 1.01, side < 0);
    const double f = (double)d->pixels[3 * i + (side > 0 ? 0 : 1)], t = (double)d->pixels[3 * i + (side > 0 ? 1 : 0)];
    const double off = fmax(fabs(f - w.want), fabs(t - (1 - w.want)));
    sums->checked++;
    sums->beyond += !(fabs(f - w.want) <= w.slack) || !(fabs(t - (1 - w.want)) <= w.slack) ||
                    !(fabs((double)d->pixels[3 * i + 2] - 1) <= 4 * ulp);
    sums->beyond_control += fabs(f - other.want) > other.slack;
    sums->total += w.total, sums->partial += w.total && (f != 1 || t != 0);
    sums->partial_control += side < 0 && w.not_total && (f != 1 || t != 0);
    sums->seen += f != 0 || t != 1 || d->pixels[3 * i + 2] != 1;
    if (w.slack < 1e-5) sums->worst = fmax(sums->worst, off);
    sums->worst_part = fmax(sums->worst_part, off / w.slack);
  }
}

/* Angles to look at, from above (eta = ior) and from below; how many. The last is so large that all of it lies below
   the horizon. */
static int fresnel_places(double eta, double degrees[FRESNEL_PLACES], double fov[FRESNEL_PLACES]) {
  int n = 0;
  degrees[n] = 45, fov[n++] = 90;
  degrees[n] = 0, fov[n++] = 0.2;
  degrees[n] = atan(eta) * 180 / PI, fov[n++] = 0.2;
  degrees[n] = 90 - 0.1, fov[n++] = 0.19;
  if (eta < 1) degrees[n] = asin(eta) * 180 / PI, fov[n++] = 0.2;
  return n;
}

static void glass_build(pktrt_scene *s, const void *what) {
  pktrt_material m = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  m.ior[0] = *(const float *)what;
  add_floor(s, &m, 1000);
}

/* From one side, at all places. A sky of NaN is the control of what counts odd values, a picture of other glass that of
   what compares pictures. */
static void fresnel_side(const stages *s, const stages *aside, float ior, double side, fresnel_sums *sums, tally *t) {
  double degrees[FRESNEL_PLACES], fov[FRESNEL_PLACES];
  const int places = fresnel_places(side > 0 ? (double)ior : 1 / (double)ior, degrees, fov);
  const uint32_t w = side_of((size_t)((double)thorough(1000000) / 2.6 / 2 / places) + 1); /* two or three rays each */
  const size_t n = (size_t)w * w * 3;
  float *first = stage_pixels(n), *other = stage_pixels(n), bright = 1;
  for (int i = 0; i < places; i++) {
    const double angle = degrees[i] * PI / 180;
    const vec eye = vec_of(0, 0.01 * side, 0), to = vec_of(sin(angle), -cos(angle) * side, 0);
    pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, w, w, first, eye, vec_add(eye, to));
    d.camera.fov_y = (float)fov[i], d.max_depth = 1, d.environment = sky_of_channels, d.user = &bright;
    render_all(s, &d, other, t);
    check_reflectances(&d, side, (double)ior, sums);
    d.pixels = other;
    stage_render(aside->scene[0], &d);
    compare_aside(first, other, n, t);
  }
  free(first), free(other);
}

static const float fresnel_iors[] = {1, 1.000001f, 1.0003f, 1.33f, 1.5f, 2.4f, 1000, 9.9e5f};

static void fresnel_job(void *arg, size_t i) {
  const float ior = ((const float *)arg)[i], more = ior * 1.01f;
  char name[64];
  stages s = stages_open(glass_build, &ior), aside = stages_open(glass_build, &more);
  fresnel_sums sums;
  tally t;
  memset(&sums, 0, sizeof sums), memset(&t, 0, sizeof t);
  for (int side = 1; side >= -1; side -= 2) fresnel_side(&s, &aside, ior, side, &sums, &t);
  snprintf(name, sizeof name, "Fresnel: ior %.7g", (double)ior);
  report(name, &t, "ior more by 1%");
  count_figure(part, name, PKTRT_ISA_AUTO, sums.checked, "reflectances beyond rounding", sums.beyond);
  control_figure(part, name, "reflectances beyond rounding", "ior more by 1%", sums.checked, sums.beyond_control);
  if (sums.total) {
    const char *what = "rays not totally reflected";
    count_figure(part, name, PKTRT_ISA_AUTO, sums.total, what, sums.partial);
    control_figure(part, name, what, "before the critical angle", sums.checked, sums.partial_control);
  }
  const char *what = "rays that see glass of ior 1";
  if (ior == 1) count_figure(part, name, PKTRT_ISA_AUTO, sums.checked, what, sums.seen);
  else if (ior < 1.00001f) control_figure(part, name, what, "ior 1.000001", sums.checked, sums.seen);
  value_figure(part, name, PKTRT_ISA_AUTO, sums.checked, "largest Fresnel error", sums.worst, 1e-5);
  value_figure(part, name, PKTRT_ISA_AUTO, sums.checked, "of what rounding may do", sums.worst_part, 1);
  stages_close(&s), stages_close(&aside);
}

static void fresnel(void) { jobs_for(COUNT(fresnel_iors), fresnel_job, (void *)(uintptr_t)fresnel_iors); }

/* The control of what counts spoilt values. */
static void odd_skies(void) {
  const float ior = 1.5f;
  stages s = stages_open(glass_build, &ior);
  const uint32_t w = side_of(thorough(1000000) / 100 + 1);
  float bright[2] = {NAN, -1}, *first = stage_pixels((size_t)w * w * 3), *other = stage_pixels((size_t)w * w * 3);
  tally t;
  memset(&t, 0, sizeof t);
  pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, w, w, first, vec_of(0, 1, 0), vec_of(1, 0, 0));
  for (int i = 0; i < 2; i++) {
    d.max_depth = 1, d.environment = sky_of_channels, d.user = &bright[i];
    render_all(&s, &d, other, &t);
    const size_t n = values_of(&d);
    control_figure(part, "Fresnel: skies", spoilt, i ? "a sky of -1" : "a sky of NaN", n, odd_values(first, n));
  }
  stages_close(&s);
  free(first), free(other);
}

/* --- highlights --- */

/* A directional light of irradiance 1 shows in a lobe by its value, (n + 1) / (2 pi) cos^n. Mirror directions are off
   by some roundings in any direction across, less than 16 u in all, so the angle a from the axis is off by as much,
   and the value by n tan(a) of it, and half the square; u is left for each of a dozen operations. */
static const float shine_exponents[] = {0, 1, 10, 1e3f, 1e6f};

static void shine_build(pktrt_scene *s, const void *what) {
  pktrt_material m = material_of(0, PKTRT_SPECULAR_MIRROR, 1);
  pktrt_light l = light_of(PKTRT_LIGHT_DIRECTIONAL, 1);
  m.lobe = PKTRT_LOBE_PHONG, m.exponent = *(const float *)what;
  l.direction[0] = -1, l.direction[1] = -1;
  add_floor(s, &m, 1000);
  stage_light(s, &l);
}

typedef struct shine_sums {
  uint64_t checked, beyond, control;
  double worst;
} shine_sums;

static void check_shine(const pktrt_render_desc *d, double n, shine_sums *sums) {
  const vec light = vec_unit(vec_of(1, 1, 0));
  for (uint32_t i = 0; i < d->width * d->height; i++) {
    vec r = stage_through(&d->camera, i % d->width + 0.5, i / d->width + 0.5, d->width, d->height);
    if (r.y > -1e-3) continue;
    r.y = -r.y;
    const double c = vec_dot(r, light), a = atan2(vec_length(vec_cross(r, light)), c), off = 16 * ulp;
    const double got = (double)d->pixels[3 * i], peak = (n + 1) / (2 * PI);
    const double want = c > 0 ? peak * exp(n * log1p(-pow(sin(a / 2), 2) * 2)) : 0;
    const double change = n * (fmin(tan(a), 1e3) * off + off * off) + 16 * ulp;
    sums->checked++;
    sums->beyond += !(fabs(got - want) <= want * expm1(change) + 1e-30);
    sums->control += fabs(got * 1.01 - want) > want * expm1(change) + 1e-30;
    if (want > 1e-3 * peak) sums->worst = fmax(sums->worst, fabs(got / want - 1));
  }
}

static void shine_job(void *arg, size_t i) {
  const float exponent = ((const float *)arg)[i];
  const uint32_t w = side_of(thorough(1000000) / 3 + 1); /* a ray, its reflection and one to the light */
  const size_t n = (size_t)w * w * 3;
  float *other = stage_pixels(n);
  char name[64];
  stages s = stages_open(shine_build, &exponent);
  shine_sums sums = {0, 0, 0, 0};
  tally t;
  memset(&t, 0, sizeof t);
  pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, w, w, stage_pixels(n), vec_of(-1, 1, 0), vec_of(0, 0, 0));
  d.camera.fov_y = (float)fmin(85, 400 / sqrt((double)exponent + 1)); /* some standard deviations of the lobe */
  render_all(&s, &d, other, &t);
  check_shine(&d, (double)exponent, &sums);
  snprintf(name, sizeof name, "highlight: lobe %.7g", (double)exponent);
  report(name, &t, "");
  count_figure(part, name, PKTRT_ISA_AUTO, sums.checked, "highlights beyond rounding", sums.beyond);
  control_figure(part, name, "highlights beyond rounding", "light more by 1%", sums.checked, sums.control);
  value_figure(part, name, PKTRT_ISA_AUTO, sums.checked, "largest relative error of highlights", sums.worst, INFINITY);
  stages_close(&s);
  free(d.pixels), free(other);
}

static void highlights(void) { jobs_for(COUNT(shine_exponents), shine_job, (void *)(uintptr_t)shine_exponents); }

/* --- a box of mirrors --- */

/* Closed, emitting e, seen from inside to depth 50: e (1 + r + ... + r^50). A float is rounded twice on each of 51
   levels.

   A ray that is spawned next to an edge may start beyond the other wall: >>spawn says how far it is moved. The way
   through the box is that through a lattice of boxes, unfolded; where it passes an edge too closely it is not judged.
   Each bounce moves a ray by 24 u, for the largest coordinate is 1, and by as much again by the errors of hits; it
   turns it by 4 u, for two roundings of each component as its direction is made a unit vector twice. After i bounces
   on ways of 2.7 at most, the diagonal, that is 48 i u + 4 * 2.7 i (i - 1) / 2 u. */
static const float box_reflectances[3] = {1, 0.9f, 0.5f};

static void box_build(pktrt_scene *s, const void *what) {
  (void)what;
  pktrt_material m = material_of(0, PKTRT_SPECULAR_MIRROR, 0);
  mesh box = mesh_box();
  memcpy(m.reflectance, box_reflectances, sizeof m.reflectance);
  for (int k = 0; k < 3; k++) m.emission[k] = 0.25f;
  mesh_place(&box, (float[3]){1, 0.75f, 0.5f}, (float[3]){0, 0, 0});
  stage_mesh(s, &box, stage_material(s, &m));
  mesh_free(&box);
}

/* Whether the way from o along d passes too close to an edge of any of the first n walls. */
static bool passes_edge(vec o, vec d, int n) {
  static const double half[3] = {1, 0.75, 0.5};
  const double from[3] = {o.x, o.y, o.z}, to[3] = {d.x, d.y, d.z};
  double next[3], step[3];
  for (int a = 0; a < 3; a++) {
    step[a] = 2 * half[a] / fabs(to[a]);
    next[a] = (half[a] - (to[a] > 0 ? from[a] : -from[a])) / fabs(to[a]);
  }
  for (int i = 0; i < n; i++) {
    const int a = next[0] < next[1] ? (next[0] < next[2] ? 0 : 2) : next[1] < next[2] ? 1 : 2;
    const double least = (48 * (i + 1) + 4 * 2.7 * i * (i + 1) / 2) * ulp;
    for (int b = 0; b < 3; b++) {
      const double x = from[b] / (2 * half[b]) + 0.5 + next[a] * to[b] / (2 * half[b]);
      if (b != a && fabs(x - floor(x + 0.5)) * 2 * half[b] < least) return true;
    }
    next[a] += step[a];
  }
  return false;
}

typedef struct box_sums {
  uint64_t checked, near, beyond, control;
} box_sums;

static void check_box(const pktrt_render_desc *d, box_sums *sums) {
  const vec eye = vec_from(d->camera.eye);
  for (uint32_t i = 0; i < d->width * d->height; i++) {
    const vec v = stage_through(&d->camera, i % d->width + 0.5, i / d->width + 0.5, d->width, d->height);
    if (passes_edge(eye, v, 51)) {
      sums->near++;
      continue;
    }
    bool beyond = false, control = false;
    for (int k = 0; k < 3; k++) {
      double want = 0, shorter = 0, got = (double)d->pixels[3 * i + (uint32_t)k];
      for (int j = 0; j <= 50; j++) shorter = want, want = 0.25 + want * (double)box_reflectances[k];
      beyond |= !(fabs(got - want) <= 102 * ulp * want);
      control |= fabs(got - shorter) > 102 * ulp * want;
    }
    sums->checked++, sums->beyond += beyond, sums->control += control;
  }
}

static void box_job(void *arg, size_t i) {
  const vec *to = (const vec *)arg + i;
  const uint32_t w = side_of(thorough(1000000) / 51 + 1);
  const size_t n = (size_t)w * w * 3;
  char name[64];
  float *other = stage_pixels(n);
  box_sums sums = {0, 0, 0, 0};
  tally t;
  stages s = stages_open(box_build, NULL);
  memset(&t, 0, sizeof t);
  pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, w, w, stage_pixels(n), vec_of(0.1, 0.2, 0.15), *to);
  d.camera.fov_y = 90;
  render_all(&s, &d, other, &t);
  check_box(&d, &sums);
  snprintf(name, sizeof name, "mirror box, view %zu", i + 1);
  report(name, &t, "");
  count_figure(part, name, PKTRT_ISA_AUTO, sums.checked, "mirror boxes off their geometric series", sums.beyond);
  control_figure(part, name, "mirror boxes off their geometric series", "depth 49", sums.checked, sums.control);
  CHECK(sums.near < sums.checked / 10, "%llu of %llu near edges", (unsigned long long)sums.near,
      (unsigned long long)sums.checked);
  stages_close(&s);
  free(d.pixels), free(other);
}

static void boxes(void) {
  vec to[2] = {{1, -0.3, -0.2}, {-0.2, 0.6, 0.5}};
  jobs_for(COUNT(to), box_job, to);
}

/* --- lights without size, and edge-on --- */

typedef enum dark_kind { LINE, SPOT_QUAD, SPHERE, MESH, FLAT_QUAD, LOW_POINT, LEVEL, DARK_KINDS } dark_kind;
typedef struct dark {
  dark_kind kind;
  bool lit; /* the control: with size, and above the plane */
} dark;

static void add_mesh_lamp(pktrt_scene *s, double half) {
  const pktrt_material m = lamp_of(100);
  const quad q = quad_of(vec_of(0, 1, 0), vec_of(1, 0, 0), vec_of(0, 0, half));
  pktrt_light l = light_of(PKTRT_LIGHT_MESH, 1);
  l.mesh = stage_quad(s, &q, stage_material(s, &m));
  stage_light(s, &l);
}

static void dark_build(pktrt_scene *s, const void *what) {
  const dark *d = what;
  const double size = d->lit ? 0.5 : 0, height = d->lit ? 1 : 0;
  const quad line = quad_of(vec_of(0, 1, 0), vec_of(0.5, 0, 0), vec_of(0, 0, size)),
             spot = quad_of(vec_of(0, 1, 0), vec_of(size, 0, 0), vec_of(0, 0, size)),
             flat = quad_of(vec_of(0, height, 0), vec_of(0.5, 0, 0), vec_of(0, 0, d->lit ? 0.5 : -0.5));
  pktrt_material m = material_of(0.6, PKTRT_SPECULAR_MIRROR, 0.4);
  m.lobe = PKTRT_LOBE_PHONG, m.exponent = 10;
  add_floor(s, &m, 4);
  if (d->kind == MESH) {
    add_mesh_lamp(s, size);
    return;
  }
  pktrt_light l = d->kind == LINE        ? quad_light(&line, 100)
                  : d->kind == SPOT_QUAD ? quad_light(&spot, 100)
                  : d->kind == FLAT_QUAD ? quad_light(&flat, 100)
                                         : light_of(PKTRT_LIGHT_SPHERE, 100);
  if (d->kind == LOW_POINT) l.kind = PKTRT_LIGHT_POINT;
  if (d->kind == LEVEL) l.kind = PKTRT_LIGHT_DIRECTIONAL;
  if (d->kind == SPHERE) l.position[1] = 1, l.radius = (float)size;
  if (d->kind == LOW_POINT) l.position[1] = (float)height;
  if (d->kind == LEVEL) l.direction[0] = 1, l.direction[1] = (float)-height;
  stage_light(s, &l);
}

static uint64_t bright_pixels(const float *p, size_t n) {
  uint64_t bright = 0;
  for (size_t i = 0; i < n; i += 3) bright += p[i] != 0 || p[i + 1] != 0 || p[i + 2] != 0;
  return bright;
}

/* All kinds but those in the plane of the floor have no size: two cases. */
static void dark_job(void *arg, size_t i) {
  const char *name = i ? "lights edge-on" : "lights without size";
  const dark_kind first_kind = i ? FLAT_QUAD : LINE, end_kind = i ? DARK_KINDS : FLAT_QUAD;
  const size_t kinds = (size_t)end_kind - (size_t)first_kind;
  /* a ray and, but for RCS, most of its reflections */
  const uint32_t w = side_of(thorough(1000000) * 2 / 9 / kinds + 1);
  const size_t n = (size_t)w * w * 3;
  float *first = stage_pixels(n), *other = stage_pixels(n);
  uint64_t bright = 0, control = 0;
  tally t;
  (void)arg;
  memset(&t, 0, sizeof t);
  for (size_t k = 0; k < kinds * 3; k++) {
    const dark none = {(dark_kind)((size_t)first_kind + k / 3), false}, some = {none.kind, true};
    stages s = stages_open(dark_build, &none), lit = stages_open(dark_build, &some);
    pktrt_render_desc d = stage_view((pktrt_mode)(k % 3), w, w, first, vec_of(0.2, 2, 0.5), vec_of(0, 0, 0));
    d.camera.fov_y = 60;
    render_all(&s, &d, other, &t);
    bright += bright_pixels(first, n);
    d.pixels = other;
    stage_render(lit.scene[0], &d);
    control += bright_pixels(other, n);
    compare_aside(first, other, n, &t);
    stages_close(&s), stages_close(&lit);
  }
  const uint64_t pixels = (uint64_t)w * w * 3 * kinds;
  report(name, &t, "a light with size");
  count_figure(part, name, PKTRT_ISA_AUTO, pixels, "pixels lit by lights without size", bright);
  control_figure(part, name, "pixels lit by lights without size", "size and height", pixels, control);
  free(first), free(other);
}

/* Small lights are points of intensity I: a sphere of radiance I / (pi r^2), seen in its middle or anywhere, and a
   quad of radiance I / r^2, which faces the floor. Where rays hit is off by 150 u: 8 u of a way of 6 by the
   direction, 24 u of the largest coordinate, 4, by the hit. Irradiance h / d^3 or h^2 / d^4 changes by less than 4 /
   d of that, and d >= h = 1; a point of a light r away from its middle changes it as well. */
typedef struct tiny {
  bool quad;
  double size;
} tiny;

static const double tiny_intensity = 2, tiny_albedo = 0.6;
static vec tiny_place(void) { return vec_of((double)0.3f, 1, (double)0.2f); }

static void tiny_build(pktrt_scene *s, const void *what) {
  const tiny *k = what;
  const pktrt_material m = material_of(tiny_albedo, PKTRT_SPECULAR_NONE, 0);
  const vec at = tiny_place();
  pktrt_light l = light_of(PKTRT_LIGHT_SPHERE, tiny_intensity / (k->quad ? k->size * k->size : PI * k->size * k->size));
  vec_put(at, l.position), l.radius = (float)k->size;
  if (k->quad) l.kind = PKTRT_LIGHT_QUAD, l.edge[0][0] = l.edge[1][2] = (float)k->size;
  add_floor(s, &m, 4);
  stage_light(s, &l);
}

static void check_tiny(const pktrt_render_desc *d, const tiny *k, uint64_t *beyond, uint64_t *control) {
  const vec eye = vec_from(d->camera.eye), at = tiny_place();
  for (uint32_t i = 0; i < d->width * d->height; i++) {
    const vec v = stage_through(&d->camera, i % d->width + 0.5, i / d->width + 0.5, d->width, d->height);
    const vec p = d->mode == PKTRT_MODE_DRT ? vec_of(0, 0, 0) : vec_add(eye, vec_mul(v, -eye.y / v.y));
    const vec to = vec_sub(at, p);
    const double distance = vec_length(to), cosine = to.y / distance, got = (double)d->pixels[3 * i];
    const double want = tiny_albedo * tiny_intensity / PI * cosine / (distance * distance) * (k->quad ? cosine : 1);
    const double slack = (4 * k->size + 4 * 150 * ulp + 16 * ulp) * want;
    *beyond += !(fabs(got - want) <= slack), *control += fabs(got * 1.01 - want) > slack;
  }
}

static void tiny_job(void *arg, size_t i) {
  static const double sizes[4] = {1e-3, 1e-6, 1e-12, 1e-18};
  const char *name = i ? "small quad lights" : "small sphere lights";
  const uint32_t w = side_of(thorough(1000000) / (COUNT(sizes) * 3 * 2) + 1);
  const size_t n = (size_t)w * w * 3;
  float *first = stage_pixels(n), *other = stage_pixels(n);
  uint64_t beyond = 0, control = 0;
  tally t;
  (void)arg;
  memset(&t, 0, sizeof t);
  for (size_t k = 0; k < COUNT(sizes) * 3; k++) {
    const tiny light = {i == 1, sizes[k / 3]};
    const pktrt_mode mode = (pktrt_mode)(k % 3);
    stages s = stages_open(tiny_build, &light);
    pktrt_render_desc d = stage_view(mode, w, w, first, vec_of(0.2, 2, 0.5), vec_of(0, 0, 0));
    d.camera.fov_y = mode == PKTRT_MODE_DRT ? 1e-6f : 60; /* places in a pixel are random in DRT: one place, then */
    render_all(&s, &d, other, &t);
    check_tiny(&d, &light, &beyond, &control);
    stages_close(&s);
  }
  const uint64_t pixels = (uint64_t)w * w * 3 * COUNT(sizes);
  report(name, &t, "");
  count_figure(part, name, PKTRT_ISA_AUTO, pixels, "pixels off the limit of small lights", beyond);
  control_figure(part, name, "pixels off the limit of small lights", "light more by 1%", pixels, control);
  free(first), free(other);
}

static void lights_at_limits(void) {
  jobs_for(2, dark_job, NULL);
  jobs_for(2, tiny_job, NULL);
}

/* --- no aperture, no shutter --- */

/* Something that moves, a mirror, glass, a point light: a picture in which a lens and a shutter matter; four rays a
   sample. `frozen` is the same, standing still at a time, with a vertex more that no triangle has, so that its
   largest coordinate is the same: rays leave surfaces by that. */
typedef struct still {
  double time;
  bool frozen;
} still;

static mesh frozen_mesh(const mesh *m, float time) {
  mesh f = mesh_of(m->nv + 1, m->nt);
  memcpy(f.i, m->i, (size_t)m->nt * 3 * sizeof *m->i);
  for (uint32_t v = 0; v < m->nv; v++) ref_vertex(m, v, time, f.p + 3 * v);
  for (size_t k = 0; k < (size_t)m->nv * m->keys * 3; k++) f.p[3 * m->nv] = fmaxf(f.p[3 * m->nv], fabsf(m->p[k]));
  return f;
}

static void still_build(pktrt_scene *s, const void *what) {
  const still *k = what;
  const pktrt_material mirror = material_of(0.2, PKTRT_SPECULAR_MIRROR, 0.7),
                       glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  const quad back = quad_of(vec_of(0, 1, -3), vec_of(4, 0, 0), vec_of(0, 3, 0));
  pktrt_light l = light_of(PKTRT_LIGHT_POINT, 40);
  mesh mover = mesh_sphere(4, 0.2f, 5), pane = mesh_sphere(3, 0, 1);
  mesh_move(&mover, 3, 0.8f, 0.02f, 6);
  mesh_place(&pane, (float[3]){0.7f, 0.7f, 0.7f}, (float[3]){1.6f, 0.2f, 1});
  l.position[0] = 2, l.position[1] = 5, l.position[2] = 3;
  if (k->frozen) {
    mesh f = frozen_mesh(&mover, (float)k->time);
    mesh_free(&mover), mover = f;
  }
  stage_mesh(s, &mover, 0);
  stage_mesh(s, &pane, stage_material(s, &glass));
  stage_quad(s, &back, stage_material(s, &mirror));
  stage_light(s, &l);
  mesh_free(&mover), mesh_free(&pane);
}

static void sky_of_directions(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (int k = 0; k < 3; k++)
    for (uint32_t i = 0; i < n; i++) radiance[k][i] = 0.5f + 0.5f * direction[k][i];
}

static pktrt_render_desc still_view(pktrt_mode mode, size_t samples, double time) {
  const uint32_t w = side_of(samples / 4 + 1);
  pktrt_render_desc d = stage_view(mode, w, w, stage_pixels((size_t)w * w * 3), vec_of(0.5, 1, 5), vec_of(0, 0, 0));
  d.environment = sky_of_directions, d.branching = PKTRT_BRANCHING_BOTH, d.max_depth = 6;
  d.samples = 4, d.camera.time = (float)time;
  return d;
}

/* A DRT picture against another one of the same size and a control. */
static void compare_stills(const char *name, const char *what, const char *control, const stages *s,
    const pktrt_render_desc *d, pktrt_scene *want_of, const pktrt_render_desc *want, const pktrt_render_desc *aside,
    tally *t) {
  const size_t n = values_of(d);
  render_all(s, d, aside->pixels, t);
  stage_render(want_of, want);
  stage_render(s->scene[0], aside);
  compare_aside(d->pixels, aside->pixels, n, t);
  count_figure(part, name, PKTRT_ISA_AUTO, n, what, apart(d->pixels, want->pixels, n));
  control_figure(part, name, what, control, n, apart(want->pixels, aside->pixels, n));
}

static void no_aperture(void) {
  const still k = {0.3, false};
  stages s = stages_open(still_build, &k);
  tally t;
  memset(&t, 0, sizeof t);
  pktrt_render_desc want = still_view(PKTRT_MODE_WRT, thorough(300000), k.time),
                    d = still_view(PKTRT_MODE_DRT, thorough(300000), k.time),
                    aside = still_view(PKTRT_MODE_DRT, thorough(300000), k.time);
  d.camera.focus = aside.camera.focus = 3, aside.camera.aperture = 1e-3f;
  const char *name = "no aperture", *what = "values that are not the pinhole's", *control = "aperture 1e-3";
  compare_stills(name, what, control, &s, &d, s.scene[0], &want, &aside, &t);
  report(name, &t, control);
  stages_close(&s);
  free(want.pixels), free(d.pixels), free(aside.pixels);
}

static void no_shutter(size_t i) {
  static const double times[4] = {0, 0.3, 0.5, 1};
  const still k = {times[i], false}, f = {times[i], true};
  const size_t samples = thorough(300000) / COUNT(times);
  const char *name = "no shutter", *what = "values that are not the frozen picture's", *control = "shutter 1e-3";
  stages s = stages_open(still_build, &k), frozen = stages_open(still_build, &f);
  tally t;
  memset(&t, 0, sizeof t);
  pktrt_render_desc want = still_view(PKTRT_MODE_WRT, samples, 0), d = still_view(PKTRT_MODE_DRT, samples, k.time),
                    aside = still_view(PKTRT_MODE_DRT, samples, k.time);
  aside.camera.shutter = 1e-3f;
  if (i + 1 == COUNT(times)) aside.camera.time -= 1e-3f;
  compare_stills(name, what, control, &s, &d, frozen.scene[0], &want, &aside, &t);
  report(name, &t, control);
  stages_close(&s), stages_close(&frozen);
  free(want.pixels), free(d.pixels), free(aside.pixels);
}

static void still_job(void *arg, size_t i) {
  (void)arg;
  if (i) no_shutter(i - 1);
  else no_aperture();
}

static void stills(void) { jobs_for(5, still_job, NULL); }

static void fresnel_and_skies(void) { fresnel(), odd_skies(); }

void suite_stability_shading(void) {
  run("stable: in a white furnace every material shows its own albedo", furnaces);
  run("stable: in a white furnace spheres lose what the depth limit cuts off, and nothing else", spheres);
  run("stable: glass reflects by Fresnel from both sides, at all angles, totally where it has to", fresnel_and_skies);
  run("stable: highlights have the value of their lobe, of exponents from 0 to 1e6", highlights);
  run("stable: a closed box of mirrors is a geometric series, to depth 50", boxes);
  run("stable: lights without size and edge-on give nothing, small ones what a point gives", lights_at_limits);
  run("stable: no aperture gives the pinhole's picture, no shutter the frozen one", stills);
}
