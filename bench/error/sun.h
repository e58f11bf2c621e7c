/* sun.h - one sun in three forms: a sphere far away, a directional light with `angle`, and a disk in the callback of the
   environment. How much more the second and third err than the first with as many samples, and how long they take.

   Below it stand balls and a box on the ground, against the truth of the sphere. The disk of the callback is compared by the
   distance of unit vectors, since cosines of floats do not know so small a disk. */
#ifndef ERROR_SUN_H
#define ERROR_SUN_H

#include "curves.h"
#include "hard.h"
#include "scatter.h"

enum { SUN_WIDTH = 64, SUN_HEIGHT = 48, SUN_SAMPLES = 64, SUN_SEEDS = 12, SUN_ANGLES = 3, SUN_SKY = 4800 };
typedef enum sun_form { SUN_SPHERE, SUN_LIGHT, SUN_CALLBACK, SUN_STALE, SUN_FORMS } sun_form;
static const char *const sun_names[SUN_FORMS] = {
    "sphere", "light", "callback", "callback whose table is of another sun"};
static const double sun_angles[SUN_ANGLES] = {0.265, 0.1, 0.05}; /* half-angles, degrees: that of the Earth first */

typedef struct sun {
  double to[3], radius2, radiance; /* radius2: squared distance of unit vectors from the middle to the rim */
} sun;

static const double sun_way[3] = {0.48, 0.64, 0.6};

static void sun_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  const sun *s = (const sun *)user;
  for (uint32_t i = 0; i < n; i++) {
    double away = 0;
    for (int axis = 0; axis < 3; axis++) away += square((double)direction[axis][i] - s->to[axis]);
    for (int c = 0; c < 3; c++) radiance[c][i] = away < s->radius2 ? (float)s->radiance : 0.0f;
  }
}

/* So small a sun is found if the pixels of the sky are known. */
static bool sun_has_pixels(double angle) { return angle < 0.08; }

/* Opens the scene with a sun of that half-angle. *g must stay where it is. */
static void sun_open(stage *g, sun_form form, double angle) {
  const double sine = sc_sin(angle), far_away = 1e5, irradiance = 3;
  pktrt_light l;
  memset(g, 0, sizeof *g);
  snprintf(g->name, sizeof g->name, "sun %s %g", form == SUN_STALE ? "stale" : sun_names[form], angle);
  stage_world(g);
  stage_room(g, SUN_WIDTH, SUN_HEIGHT);
  g->view.mode = PKTRT_MODE_DRT;
  add_bodies(g);
  look(g, 0, 2, 5.5, 0.7);

  sun *s = (sun *)malloc(sizeof *s);
  if (!s) fatal("not enough memory");
  g->own = s;
  memcpy(s->to, sun_way, sizeof s->to);
  s->radius2 = square(2 * sc_sin(0.5 * angle));
  s->radiance = irradiance / (SC_PI * sine * sine);

  memset(&l, 0, sizeof l);
  if (form == SUN_SPHERE) {
    l.kind = PKTRT_LIGHT_SPHERE;
    l.radius = (float)(far_away * sine);
    set3(l.position, far_away * sun_way[0], far_away * sun_way[1], far_away * sun_way[2]);
    set3(l.intensity, s->radiance, s->radiance, s->radiance);
  } else if (form == SUN_LIGHT) {
    l.kind = PKTRT_LIGHT_DIRECTIONAL;
    l.angle = (float)angle;
    set3(l.direction, -sun_way[0], -sun_way[1], -sun_way[2]);
    set3(l.intensity, irradiance, irradiance, irradiance);
  } else {
    l.kind = PKTRT_LIGHT_ENVIRONMENT;
    set3(l.intensity, 1, 1, 1);
    g->view.environment = sun_sky;
    g->view.user = s;
    if (sun_has_pixels(angle)) {
      g->view.environment_width = SUN_SKY;
      g->view.environment_height = SUN_SKY / 2;
    }
  }
  add_hard_light(g, &l);
  if (pktrt_commit(g->world)) fatal(pktrt_last_error(g->world));

  if (form == SUN_CALLBACK && angle < 0.2 && pktrt_prepare_environment(g->world, &g->view))
    fatal(pktrt_last_error(g->world));
  if (form == SUN_STALE) { /* the sun stood elsewhere when the sky was looked at */
    s->to[0] = -sun_way[0];
    if (pktrt_prepare_environment(g->world, &g->view)) fatal(pktrt_last_error(g->world));
    s->to[0] = sun_way[0];
  }
}

typedef struct sun_errors {
  double mse[SUN_SEEDS], seconds;
} sun_errors;

static double sun_rmse(const sun_errors *e, unsigned left_out) {
  double sum = 0;
  for (unsigned i = 0; i < SUN_SEEDS; i++) sum += i == left_out ? 0 : e->mse[i];
  return sqrt(sum / (SUN_SEEDS - (left_out < SUN_SEEDS)));
}

/* Measures one form against the truth of the sphere, which `truth` holds. */
static void measure_sun(const stage *truth, sun_form form, double angle, sun_errors *e) {
  static stage g;
  sun_open(&g, form, angle);
  g.doubt = (double *)calloc(stage_pixels(&g), sizeof(double));
  if (!g.doubt) fatal("not enough memory");
  memcpy(g.truth, truth->truth, stage_pixels(&g) * 3 * sizeof *g.truth);
  memcpy(g.doubt, truth->doubt, stage_pixels(&g) * sizeof *g.doubt);

  memset(e, 0, sizeof *e);
  for (unsigned i = 0; i < SUN_SEEDS; i++) {
    const shot s = shot_of(PKTRT_SAMPLER_SOBOL, SUN_SAMPLES, 1, FIRST_SEED + i);
    outcome o;
    take_shot(&g, &s, &o);
    e->mse[i] = o.mse;
    e->seconds += o.seconds / SUN_SEEDS;
  }
  stage_close(&g);
}

/* RMSE of one over that of the other. */
static interval sun_ratio(const sun_errors *over, const sun_errors *under) {
  double without[SUN_SEEDS];
  for (unsigned i = 0; i < SUN_SEEDS; i++) without[i] = sun_rmse(over, i) / sun_rmse(under, i);
  return jackknife(sun_rmse(over, SUN_SEEDS) / sun_rmse(under, SUN_SEEDS), without, SUN_SEEDS);
}

static void part_sun(bench *b) {
  static stage truth;
  csv(&b->out, "half_angle,form,samples,rmse,ratio,low,high,seconds\n");
  say(&b->out,
      "%d x %d pixels, %d samples, %d seeds, one thread; times have that of making the table, but for suns below "
      "0.2 degrees, whose sky was prepared before:\n\n"
      "| half-angle | form | RMSE | over the sphere's | time over the sphere's |\n|--:|---|--:|--:|--:|\n",
      (int)SUN_WIDTH, (int)SUN_HEIGHT, (int)SUN_SAMPLES, (int)SUN_SEEDS);

  for (int k = 0; k < SUN_ANGLES; k++) {
    sun_errors e[SUN_STALE];
    sun_open(&truth, SUN_SPHERE, sun_angles[k]);
    stage_reference(b, &truth, reference_samples(b));
    for (int form = 0; form < SUN_STALE; form++) {
      measure_sun(&truth, (sun_form)form, sun_angles[k], &e[form]);
      const interval r = sun_ratio(&e[form], &e[SUN_SPHERE]);
      const double rmse = sun_rmse(&e[form], SUN_SEEDS);
      csv(&b->out, "%g,%s,%d,%.6g,%.6g,%.6g,%.6g,%.6g\n", sun_angles[k], sun_names[form], (int)SUN_SAMPLES, rmse,
          r.value, r.low, r.high, e[form].seconds);
      say(&b->out, "| %g | %s | %.5f | %.2f (%.2f to %.2f) | %.2f |\n", sun_angles[k], sun_names[form], rmse, r.value,
          r.low, r.high, e[form].seconds / e[SUN_SPHERE].seconds);
    }
    stage_close(&truth);
  }
  say(&b->out, "\n");
}

/* Counts how many of suns in random places of a callback are lost, and gets how far the light of one is off at most. */
static unsigned lost_suns(double angle, unsigned placements, double *worst) {
  static stage g;
  unsigned lost = 0;
  uint32_t state = FIRST_SEED;
  sun_open(&g, SUN_CALLBACK, angle);
  g.view.environment = NULL; /* what sun_open prepared is of another sun */
  if (pktrt_prepare_environment(g.world, &g.view)) fatal(pktrt_last_error(g.world));
  g.view.environment = sun_sky;

  sun *s = (sun *)g.own;
  g.view.width = g.view.height = 4;
  g.view.samples = SUN_SAMPLES;
  g.view.pixels = g.pixels;
  set3(g.view.camera.eye, 0, 1, 3);
  set3(g.view.camera.target, 0, 0, 2.9); /* the ground before the balls */
  *worst = 0;

  for (unsigned i = 0; i < placements; i++) {
    const double up = 0.02 + 0.98 * sc_random(&state);
    const double turn = 180 * sc_random(&state); /* nothing is in its way there */
    const double aside = sqrt(1 - up * up);
    double mean = 0;
    s->to[0] = aside * sc_cos(turn);
    s->to[1] = up;
    s->to[2] = aside * sc_sin(turn);
    g.view.seed = FIRST_SEED + i;
    if (pktrt_render(g.world, &g.view)) fatal(pktrt_last_error(g.world));
    for (unsigned k = 0; k < 16; k++) mean += (double)g.pixels[3 * k] / 16;
    const double part = mean / (3 * 0.7 / SC_PI * up);
    lost += !(part >= 0.5);
    *worst = larger(*worst, fabs(part - 1));
  }
  stage_close(&g);
  return lost;
}

static void part_placements(bench *b) {
  enum { PLACEMENTS = 1000 };
  csv(&b->out, "half_angle,placements,lost,worst\n");
  for (int k = 0; k < SUN_ANGLES; k += 2) { /* that between is found if the sky was prepared */
    double worst;
    const unsigned lost = lost_suns(sun_angles[k], PLACEMENTS, &worst);
    csv(&b->out, "%g,%d,%u,%.6g\n", sun_angles[k], (int)PLACEMENTS, lost, worst);
    say(&b->out, "Half-angle %g degrees, not prepared%s, %d placements: %u lost; light is off by %.1f%% at most.\n\n",
        sun_angles[k], sun_has_pixels(sun_angles[k]) ? ", of a sky whose pixels are told" : "", (int)PLACEMENTS, lost,
        100 * worst);
  }
}

/* RMSE of a sun like that of the Earth as form c->number over the sphere's. The controls: a light ten
   times as wide; a callback whose table is that of another sun. */
static double check_sun(bench *b, const claim *c, bool control, char details[DETAILS]) {
  static stage truth;
  sun_errors sphere, form;
  sun_open(&truth, SUN_SPHERE, sun_angles[0]);
  stage_reference(b, &truth, reference_samples(b));
  measure_sun(&truth, SUN_SPHERE, sun_angles[0], &sphere);
  const bool wide = control && c->number == SUN_LIGHT;
  const sun_form which = control && !wide ? SUN_STALE : (sun_form)c->number;
  measure_sun(&truth, which, wide ? 10 * sun_angles[0] : sun_angles[0], &form);
  stage_close(&truth);
  const interval r = sun_ratio(&form, &sphere);
  note(details, sun_names[which], r);
  return r.value;
}

#endif /* ERROR_SUN_H */
