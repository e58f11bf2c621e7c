/* How noisy estimates are. A choice that is made with other probabilities than were meant, or a coordinate of a sample that
   is used twice, leaves every mean as it is. So here the variance of pixels over many seeds is compared with what the
   definitions in the header give for it, in closed form or by quadrature, from below as well as from above. */
#include "pictures.h"

enum { ACROSS = 32, DOWN = 16, PIXELS = ACROSS * DOWN };

/* How far a variance may be off, and how far off at least it must be with the fault that it is to show. */
static const double TOLERANCE = 0.1, FAULT = 0.25;

/* Mean and variance of pixels over seeds; `doubt` is the standard error of the variance, as a part of it. */
typedef struct spread {
  double mean, variance, doubt;
  size_t values;
} spread;

/* Renders a view with a number of seeds, eight in small runs. Returns the spread of each pixel over these, in the mean of all
   pixels. */
static spread spread_of(pktrt_scene *s, const pktrt_render_desc *view, size_t seeds) {
  pktrt_render_desc d = *view;
  if (small_run) seeds = 8;

  const size_t n = seeds * PIXELS;
  double *value = malloc(n * sizeof *value);
  if (!value) abort();
  d.pixels = stage_pixels((size_t)PIXELS * 3);
  for (size_t i = 0; i < seeds; i++) {
    d.seed = (uint32_t)mix64(i + ((uint64_t)run_seed << 32));
    stage_render(s, &d);
    for (size_t k = 0; k < PIXELS; k++) value[i * PIXELS + k] = (double)d.pixels[3 * k];
  }
  free(d.pixels);

  double sum = 0;
  double squares = 0;
  double fourth = 0;
  for (size_t k = 0; k < PIXELS; k++) {
    double mean = 0;
    for (size_t i = 0; i < seeds; i++) mean += value[i * PIXELS + k] / (double)seeds;
    sum += mean;
    for (size_t i = 0; i < seeds; i++) {
      const double off = value[i * PIXELS + k] - mean;
      squares += off * off;
      fourth += off * off * off * off;
    }
  }
  free(value);

  const spread e = {sum / PIXELS, squares / (double)((seeds - 1) * PIXELS),
      sqrt(fmax(fourth / (squares * squares) - 1 / (double)n, 0)), n};
  return e;
}

/* CHECKs that mean and variance are what they should be, and that a fault, whose variance is `control`, would show. */
static void check_spread(const char *name, const spread *e, double mean, double variance, double control) {
  const double ratio = e->variance / variance;
  const double error = sqrt(variance / (double)e->values);
  const double most = TOLERANCE + (small_run ? 4 * e->doubt : 0);

  CHECK(fabs(e->mean - mean) <= 4.5 * error + 2e-4 * fabs(mean), "%s: mean %.6f +- %.6f, not %.6f", name, e->mean,
      error, mean);
  CHECK(
      fabs(ratio - 1) <= most, "%s: variance %.4g, %.3f +- %.3f of %.4g", name, e->variance, ratio, e->doubt, variance);
  CHECK(fabs(control / variance - 1) > FAULT, "the control: %s: a variance of %.4g with a fault, %.4g without", name,
      control, variance);
  if (!small_run) CHECK(e->doubt < TOLERANCE / 3, "%s: the variance is known to %.3f alone", name, e->doubt);
}

/* A view of a spot, one independent sample for each pixel. */
static pktrt_render_desc spot_view(vec eye, vec spot) {
  pktrt_render_desc view = stage_spot(eye, spot);
  view.width = ACROSS;
  view.height = DOWN;
  view.samples = 1;
  view.sampler = PKTRT_SAMPLER_RANDOM;
  return view;
}

static const quad ground = {{-50, 0, 50}, {{100, 0, 0}, {0, 0, -100}}};
static const double ALBEDO = 0.5;

/* Opens a scene with a matt floor. */
static pktrt_scene *floor_open(void) {
  pktrt_scene *s = stage_open();
  const pktrt_material matt = material_of(ALBEDO, PKTRT_SPECULAR_NONE, 0);
  stage_quad(s, &ground, stage_material(s, &matt));
  return s;
}

/* --- by solid angle or by area --- */

/* What the origin of the floor gets of a flat lamp of radiance 1: the mean, and the variances of both ways. */
typedef struct lamp_moments {
  double mean, by_area, by_angle;
} lamp_moments;

/* Integrates over a parallelogram, or the triangle of its corner and both edges. */
static lamp_moments lamp_moments_of(const quad *lamp, bool triangle) {
  enum { STEPS = 200 };
  const vec normal = vec_cross(lamp->edge[0], lamp->edge[1]);
  const double whole = vec_length(normal);
  double area = 0;
  double angle = 0;
  double once = 0;
  double area2 = 0;
  double angle2 = 0;
  for (int i = 0; i < STEPS; i++)
    for (int j = 0; j < STEPS; j++) {
      const double a = (i + 0.5) / STEPS;
      const double b = (j + 0.5) / STEPS * (triangle ? 1 - a : 1);
      const double part = whole / STEPS / STEPS * (triangle ? 1 - a : 1);
      const vec at = quad_at(lamp, a, b);
      const double r2 = vec_dot(at, at);
      const double cosine = at.y / sqrt(r2);
      const double seen = fabs(vec_dot(at, normal)) / whole / (r2 * sqrt(r2));
      area += part;
      angle += seen * part;
      once += cosine * seen * part;
      area2 += cosine * cosine * seen * seen * part;
      angle2 += cosine * cosine * seen * part;
    }
  const double factor = ALBEDO / PI;
  const lamp_moments m = {
      factor * once, factor * factor * (area * area2 - once * once), factor * factor * (angle * angle2 - once * once)};
  return m;
}

/* Adds a flat lamp of radiance 1: a quad, or a mesh of one triangle. */
static void add_flat_lamp(pktrt_scene *s, const quad *lamp, bool triangle) {
  if (!triangle) {
    const pktrt_light light = quad_light(lamp, 1);
    stage_light(s, &light);
    return;
  }
  mesh m = mesh_of(3, 1);
  const pktrt_material glow = lamp_of(1);
  pktrt_light light = light_of(PKTRT_LIGHT_MESH, 1);
  for (int k = 0; k < 3; k++) {
    m.i[k] = (uint32_t)k;
    vec_put(quad_at(lamp, k == 1, k == 2), m.p + 3 * k);
  }
  light.mesh = stage_mesh(s, &m, stage_material(s, &glow));
  stage_light(s, &light);
  mesh_free(&m);
}

/* Lamps whose middle is nearer, by its square, than half the sum of the squares of both edges, and farther. */
static void near_and_far(void) {
  static const struct {
    const char *name;
    vec edge[2];
    bool triangle;
  } lamps[] = {{"a rectangle", {{1, 0, 0}, {0, 0, 1.6}}, false},
      {"a skew parallelogram", {{1.2, 0.1, 0.2}, {0.5, 0, 1.1}}, false},
      {"a triangle", {{1.4, 0, 0.1}, {0.3, 0.1, 1.2}}, true}};
  static const double nearness[] = {0.75, 1.35};
  for (size_t i = 0; i < COUNT(lamps); i++)
    for (size_t k = 0; k < COUNT(nearness); k++)
      for (int one = 0; one < 2; one++) {
        const vec *edge = lamps[i].edge;
        const double middle = lamps[i].triangle ? 1 / 3.0 : 0.5;
        const double near2 = 0.5 * (vec_dot(edge[0], edge[0]) + vec_dot(edge[1], edge[1]));
        const vec at = vec_mul(vec_unit(vec_of(0.2, 1, 0.1)), sqrt(nearness[k] * near2));
        const quad lamp = {vec_sub(at, vec_mul(vec_add(edge[0], edge[1]), middle)), {edge[0], edge[1]}};
        const lamp_moments m = lamp_moments_of(&lamp, lamps[i].triangle);
        pktrt_scene *s = floor_open();
        add_flat_lamp(s, &lamp, lamps[i].triangle);
        stage_commit(s);

        pktrt_render_desc view = spot_view(vec_of(3, 0.4, 3), vec_of(0, 0, 0));
        view.lights = one ? PKTRT_LIGHTS_ONE : PKTRT_LIGHTS_ALL;
        const spread e = spread_of(s, &view, 24);
        const bool is_near = nearness[k] < 1;
        check_spread(lamps[i].name, &e, m.mean, is_near ? m.by_angle : m.by_area, is_near ? m.by_area : m.by_angle);
        pktrt_scene_destroy(s);
      }
}

/* A sphere is sampled within its cone: with C the cosine of that and a the angle of its axis to the normal, the cosine at the
   floor is cos a t + sin a sqrt(1 - t^2) cos f, t even in [C, 1] and f in a circle. The control samples what is seen of the
   sphere by area. */
static void spheres(void) {
  static const double distance[] = {1.3, 3};
  for (size_t i = 0; i < COUNT(distance); i++) {
    enum { STEPS = 2000 };
    const double tilt = 0.5;
    const double far_off = distance[i];
    const double least = sqrt(1 - 1 / (far_off * far_off));
    const double size = 2 * PI * (1 - least);
    double once = 0;
    double twice = 0;
    double by_area = 0;
    for (int k = 0; k < STEPS; k++) {
      const double t = least + (1 - least) * (k + 0.5) / STEPS;
      const double depth = far_off * t - sqrt(fmax(0, 1 - far_off * far_off * (1 - t * t)));
      const double facing = (far_off * t - depth);
      const double cosine2 = cos(tilt) * cos(tilt) * t * t + sin(tilt) * sin(tilt) * (1 - t * t) / 2;
      once += size * cos(tilt) * t / STEPS;
      twice += size * size * cosine2 / STEPS;
      by_area += size * cosine2 * facing / (depth * depth) * 2 * PI * (1 - 1 / far_off) / STEPS;
    }
    const double factor = ALBEDO / PI;
    pktrt_scene *s = floor_open();
    pktrt_light lamp = light_of(PKTRT_LIGHT_SPHERE, 1);
    lamp.radius = 1;
    vec_put(vec_mul(vec_of(sin(tilt), cos(tilt), 0), far_off), lamp.position);
    stage_light(s, &lamp);
    stage_commit(s);

    const pktrt_render_desc view = spot_view(vec_of(-3, 0.4, 3), vec_of(0, 0, 0));
    const spread e = spread_of(s, &view, 24);
    check_spread("a sphere", &e, factor * once, factor * factor * (twice - once * once),
        factor * factor * (by_area - once * once));
    pktrt_scene_destroy(s);
  }
}

/* --- one light for all --- */

/* What a floor gets of each light, and the weight with which it is chosen. */
typedef struct choice {
  double light, weight;
} choice;

/* Returns the mean of what is chosen. */
static double choice_mean(const choice *c, size_t n) {
  double sum = 0;
  for (size_t i = 0; i < n; i++) sum += c[i].light;
  return sum;
}

/* Returns its variance, with the weight of light `which` off by a factor, and all weights to a power. */
static double choice_variance(const choice *c, size_t n, size_t which, double factor, double power) {
  double all = 0;
  double squares = 0;
  for (size_t i = 0; i < n; i++) all += pow(c[i].weight * (i == which ? factor : 1), power);
  for (size_t i = 0; i < n; i++)
    squares += c[i].light * c[i].light * all / pow(c[i].weight * (i == which ? factor : 1), power);
  return squares - choice_mean(c, n) * choice_mean(c, n);
}

/* Lamps that are small for their distance, of 1 W/sr along their normals, as they stand around a spot of a floor. A lamp
   without a front counts as if it were a ball: a quarter of its area faces the spot; and all count 1/32 of it besides. What
   is low over the floor counts less, by its cosine, at least 1/32. */
typedef enum lamp_kind { LAMP_POINT, LAMP_SPHERE, LAMP_QUAD, LAMP_MESH } lamp_kind;
typedef struct small_lamp {
  lamp_kind kind;
  vec at, normal;
} small_lamp;

static choice add_small_lamp(pktrt_scene *s, const small_lamp *lamp) {
  const double size = 0.02;
  const double distance2 = vec_dot(lamp->at, lamp->at);
  const double cosine = lamp->at.y / sqrt(distance2);
  const double facing = -vec_dot(lamp->normal, lamp->at) / sqrt(distance2);
  const vec side = vec_unit(vec_cross(lamp->normal, vec_of(0.3, 0.5, 0.8)));
  const quad flat = quad_of(lamp->at, vec_mul(side, size / 2), vec_mul(vec_cross(lamp->normal, side), size / 2));
  const double up = fmax(cosine, 1 / 32.0);
  choice c = {ALBEDO / PI * cosine / distance2, 4 * (1 / 4.0 + 1 / 32.0) * up / distance2};
  pktrt_light light = light_of(PKTRT_LIGHT_POINT, 1);
  vec_put(lamp->at, light.position);
  if (lamp->kind == LAMP_SPHERE) {
    light.kind = PKTRT_LIGHT_SPHERE;
    light.radius = (float)size;
    for (int a = 0; a < 3; a++) light.intensity[a] = (float)(1 / (PI * size * size));
  }
  if (lamp->kind == LAMP_QUAD) light = quad_light(&flat, 1 / (size * size));
  if (lamp->kind == LAMP_MESH) {
    const pktrt_material glow = lamp_of(1 / (size * size));
    light = light_of(PKTRT_LIGHT_MESH, 1);
    light.mesh = stage_quad(s, &flat, stage_material(s, &glow));
  }
  if (lamp->kind == LAMP_QUAD) c.weight = (facing + 1 / 32.0) * up / distance2;
  if (lamp->kind == LAMP_MESH) c.weight /= 4;
  if (lamp->kind >= LAMP_QUAD) c.light *= facing;
  stage_light(s, &light);
  return c;
}

/* CHECKs mean and variance as check_spread does; or where weights are right, and the variance is only that of rounding,
   that the noise is a thousandth of that with a fault. */
static void check_choice(const char *name, const spread *e, double mean, double variance, double control) {
  if (variance > 1e-5 * mean * mean) {
    check_spread(name, e, mean, variance, control);
    return;
  }
  CHECK(fabs(e->mean - mean) <= 2e-4 * mean, "%s: mean %.6f, not %.6f", name, e->mean, mean);
  CHECK(e->variance < 1e-3 * control, "%s: variance %.4g, not 0; with a fault %.4g", name, e->variance, control);
}

static void weights_of_lights(void) {
  static const struct {
    const char *name;
    small_lamp lamp[2];
    double factor, power; /* of the fault that must show */
  } pairs[] = {
      {"two points, one farther", {{LAMP_POINT, {0, 2, 0}, {0, -1, 0}}, {LAMP_POINT, {3, 5, 0}, {0, -1, 0}}}, 1, 0},
      {"two points, one lower", {{LAMP_POINT, {0, 4, 0}, {0, -1, 0}}, {LAMP_POINT, {4, 0.5, 0}, {0, -1, 0}}}, 0.5, 1},
      {"a point and a sphere", {{LAMP_POINT, {1, 4, 0}, {0, -1, 0}}, {LAMP_SPHERE, {-1, 3, 0}, {0, -1, 0}}}, 2, 1},
      {"a point and a quad", {{LAMP_POINT, {1, 4, 0}, {0, -1, 0}}, {LAMP_QUAD, {-1, 3.5, 0}, {0, -1, 0}}}, 2, 1},
      {"a quad, and another that is turned away",
          {{LAMP_QUAD, {1, 4, 0}, {0, -1, 0}}, {LAMP_QUAD, {-1, 4, 0}, {-0.8, -0.6, 0}}}, 1, 2},
      {"a point and a mesh", {{LAMP_POINT, {1, 4, 0}, {0, -1, 0}}, {LAMP_MESH, {-2, 2, 0}, {0, -1, 0}}}, 2, 1}};
  for (size_t i = 0; i < COUNT(pairs); i++) {
    choice c[2];
    pktrt_scene *s = floor_open();
    for (int k = 0; k < 2; k++) c[k] = add_small_lamp(s, &pairs[i].lamp[k]);
    stage_commit(s);

    pktrt_render_desc view = spot_view(vec_of(3, 0.4, 3), vec_of(0, 0, 0));
    view.lights = PKTRT_LIGHTS_ONE;
    const spread e = spread_of(s, &view, 48);
    check_choice(pairs[i].name, &e, choice_mean(c, 2), choice_variance(c, 2, 0, 1, 1),
        choice_variance(c, 2, 0, pairs[i].factor, pairs[i].power));
    pktrt_scene_destroy(s);
  }
}

/* Two directional lights and five points: each of the former counts as much as all of the latter together. */
static void far_lights(void) {
  choice c[7];
  double near_by = 0;
  pktrt_scene *s = floor_open();
  for (int i = 0; i < 5; i++) {
    const small_lamp lamp = {LAMP_POINT, vec_of(0.5 * i, 4, i % 2), vec_of(0, -1, 0)};
    c[i] = add_small_lamp(s, &lamp);
    near_by += c[i].weight;
  }
  for (int i = 5; i < 7; i++) {
    pktrt_light light = light_of(PKTRT_LIGHT_DIRECTIONAL, i == 5 ? 0.4 : 0.2);
    light.direction[1] = -1;
    stage_light(s, &light);
    c[i].light = ALBEDO / PI * (i == 5 ? 0.4 : 0.2);
    c[i].weight = near_by;
  }
  stage_commit(s);

  pktrt_render_desc view = spot_view(vec_of(3, 0.4, 3), vec_of(0, 0, 0));
  view.lights = PKTRT_LIGHTS_ONE;
  const spread e = spread_of(s, &view, 48);
  check_spread(
      "points and directions", &e, choice_mean(c, 7), choice_variance(c, 7, 0, 1, 1), choice_variance(c, 7, 5, 0.5, 1));
  pktrt_scene_destroy(s);
}

/* Rows of equal points over a floor. The weights are right for each alone, so a row makes no noise; a long row is weighed
   by clusters first, and makes less than if all were chosen alike. */
static void rows_of_lamps(void) {
  enum { MOST = 400 };
  static const struct {
    int count;
    double spacing, height, at; /* `at`: of the first one, from the spot */
  } rows[] = {{16, 1, 1, -4.62}, {8, 1, 2, -2.62}, {MOST, 0.25, 1, -30.1}};
  for (size_t i = 0; i < COUNT(rows); i++) {
    choice c[MOST];
    pktrt_scene *s = floor_open();
    for (int k = 0; k < rows[i].count; k++) {
      const small_lamp lamp = {
          LAMP_POINT, vec_of(rows[i].at + rows[i].spacing * k, rows[i].height, 0), vec_of(0, -1, 0)};
      c[k] = add_small_lamp(s, &lamp);
    }
    stage_commit(s);

    pktrt_render_desc view = spot_view(vec_of(-0.3, 0.2, 0.3), vec_of(0, 0, 0));
    view.lights = PKTRT_LIGHTS_ONE;
    const spread e = spread_of(s, &view, 48);
    const size_t n = (size_t)rows[i].count;
    const double mean = choice_mean(c, n);
    const double blind = choice_variance(c, n, 0, 1, 0);
    if (rows[i].count < MOST) check_choice("a row of lamps", &e, mean, choice_variance(c, n, 0, 1, 1), blind);
    CHECK(fabs(e.mean - mean) <= 4.5 * sqrt(e.variance / (double)e.values) + 2e-4 * mean,
        "a long row: mean %.6f, not %.6f", e.mean, mean);
    CHECK(e.variance < 0.05 * blind, "a long row: variance %.4g, blindly %.4g", e.variance, blind);
    pktrt_scene_destroy(s);
  }
}

/* --- the table of an environment --- */

/* A sky of radiance 1, with a cap that is brighter. Over the angle `edge` beyond the cap its radiance falls to 1. */
typedef struct cap {
  vec axis;
  double angle, radiance, edge;
} cap;

/* Returns the radiance at an angle from the cap's axis. */
static double cap_radiance_at(const cap *c, double angle) {
  if (angle < c->angle) return c->radiance;
  if (angle >= c->angle + c->edge) return 1;
  return c->radiance + (1 - c->radiance) * (angle - c->angle) / c->edge;
}

static double cap_radiance(const cap *c, vec d) {
  return cap_radiance_at(c, acos(fmax(-1, fmin(vec_dot(d, c->axis), 1))));
}

static void cap_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  for (uint32_t i = 0; i < n; i++) {
    const vec d = vec_of((double)direction[0][i], (double)direction[1][i], (double)direction[2][i]);
    for (int a = 0; a < 3; a++) radiance[a][i] = (float)cap_radiance(user, d);
  }
}

/* The same turned by half a turn about the vertical. */
static void turned_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  for (uint32_t i = 0; i < n; i++) {
    const vec d = vec_of(-(double)direction[0][i], (double)direction[1][i], -(double)direction[2][i]);
    for (int a = 0; a < 3; a++) radiance[a][i] = (float)cap_radiance(user, d);
  }
}

static vec cell_direction(int rows, double row, double column) {
  const double angle = PI * row / rows;
  const double turn = PI * column / rows;
  return vec_of(sin(angle) * cos(turn), cos(angle), sin(angle) * sin(turn));
}

/* A table of a sky: refined, it holds what the sky has beyond twice its mean. `beyond` is the mean of that over all directions,
   `share` the part of all samples that the table draws, in eighths. */
typedef struct cap_table {
  double mean, beyond, share;
} cap_table;

/* Returns the mean over all directions of the radiance beyond `least`. */
static double mean_beyond(const cap *c, double least) {
  enum { STEPS = 1 << 14 };
  const double whole = c->angle + c->edge;
  double sum = fmax(0, 1 - least) * (1 + cos(whole)) / 2;
  sum += fmax(0, c->radiance - least) * (1 - cos(c->angle)) / 2;
  for (int i = 0; i < STEPS && c->edge > 0; i++) {
    const double angle = c->angle + c->edge * (i + 0.5) / STEPS;
    sum += fmax(0, cap_radiance_at(c, angle) - least) * sin(angle) / 2 * c->edge / STEPS;
  }
  return sum;
}

static cap_table table_of(const cap *c) {
  cap_table table;
  table.mean = mean_beyond(c, 0);
  table.beyond = mean_beyond(c, 2 * table.mean);
  const double rest = table.mean - table.beyond;
  table.share = floor(8 * fmin(0.9, table.beyond / (table.beyond + rest / 2)) + 0.5) / 8;
  return table;
}

/* Returns the density by solid angle of directions that the table draws. */
static double table_density(const cap_table *table, const cap *c, vec d) {
  return fmax(0, cap_radiance(c, d) - 2 * table->mean) / (4 * PI * table->beyond);
}

/* Returns the variance of what a floor gets of a sky by samples of a table, that of `drawn`, and by cosine. */
static double sky_variance(const cap *c, const cap *drawn) {
  enum { ROWS = 512 };
  const cap_table table = table_of(drawn);
  double once = 0;
  double twice = 0;
  for (int row = 0; row < ROWS / 2; row++)
    for (int k = 0; k < 2 * ROWS; k++) {
      const vec middle = cell_direction(ROWS, row + 0.5, k + 0.5);
      const bool mixed = fabs(acos(fmin(vec_dot(middle, c->axis), 1)) - c->angle) < 2 * PI / ROWS;
      const int steps = mixed ? 6 : 1;
      for (int i = 0; i < steps * steps; i++) {
        const double y = row + (i / steps + 0.5) / steps;
        const vec d = cell_direction(ROWS, y, k + (i % steps + 0.5) / steps);
        const double size = sin(PI * y / ROWS) * PI / ROWS * PI / ROWS / (steps * steps);
        const double light = ALBEDO / PI * cap_radiance(c, d) * d.y;
        const double density = table_density(&table, drawn, d);
        once += size * light;
        twice += size * light * light / (table.share * density + (1 - table.share) * d.y / PI);
      }
    }
  return twice - once * once;
}

static double sky_mean(const cap *c) {
  enum { STEPS = 1 << 14 };
  double cosines = (c->radiance - 1) * sin(c->angle) * sin(c->angle);
  for (int i = 0; i < STEPS && c->edge > 0; i++) {
    const double angle = c->angle + c->edge * (i + 0.5) / STEPS;
    cosines += (cap_radiance_at(c, angle) - 1) * 2 * sin(angle) * cos(angle) * c->edge / STEPS;
  }
  return ALBEDO * (1 + cosines * c->axis.y);
}

/* Renders a floor under a sky for which, if `prepare` is given, another one was prepared or itself. */
static void check_sky(const char *name, cap *c, cap *prepared, bool turned, double variance, double control) {
  const pktrt_light sky = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
  pktrt_scene *s = floor_open();
  stage_light(s, &sky);
  stage_commit(s);

  pktrt_render_desc view = spot_view(vec_of(3, 0.4, 3), vec_of(0, 0, 0));
  view.environment = turned ? turned_sky : cap_sky;
  view.user = prepared;
  if (prepared) CHECK(pktrt_prepare_environment(s, &view) == PKTRT_OK, "%s", pktrt_last_error(s));
  view.environment = cap_sky;
  view.user = c;
  const spread e = spread_of(s, &view, prepared == c ? 100 : 70);
  check_spread(name, &e, sky_mean(c), variance, control);
  pktrt_scene_destroy(s);
}

/* Caps with an edge: at a sharp one parts of the table that are half in the cap would make most of the noise, for table and cosine
   together leave little where their shares are the best. */
static void skies(void) {
  static const vec axes[] = {{0.1, 1, 0.2}, {1, 0.8, -0.4}, {-0.5, 0.3, 1}};
  for (size_t i = 0; i < COUNT(axes); i++) {
    cap c = {vec_unit(axes[i]), 0.3, 100, 0.1};
    cap other = c;
    other.axis = vec_unit(vec_of(-axes[i].x - 0.3, axes[i].y, -axes[i].z));
    check_sky("a sky with a cap", &c, NULL, false, sky_variance(&c, &c), sky_variance(&c, &other));
  }
}

/* A small sun takes cells that are refined. It is so bright that the best share of the table would be larger
   than the quarter that it gets: with the best, most of the variance would come from the rim, which is left out here. */
static void small_suns(void) {
  cap sun = {vec_unit(vec_of(0.2, 1, 0.3)), 0.008, 11700, 0};
  cap wide = sun;
  wide.angle *= 1.5;
  check_sky("a small sun", &sun, &sun, false, sky_variance(&sun, &sun), sky_variance(&sun, &wide));
}

static void other_skies(void) {
  cap c = {vec_unit(vec_of(0.6, 1, 0.3)), 0.3, 100, 0.1};
  cap other = c;
  other.axis = vec_unit(vec_of(-0.6, 1, -0.3));
  const double own = sky_variance(&c, &c);
  const double wrong = sky_variance(&c, &other);
  check_sky("a sky prepared with another user pointer", &c, &other, false, own, wrong);
  check_sky("a sky prepared with another function", &c, &c, true, own, wrong);
}

/* --- coordinates of samples --- */

enum { FOV = 2 };

static double pixel_size(void) { return 2 * tan(FOV * PI / 360) / DOWN; }

/* Radiance that rises by 1 for each pixel to the right, and by a half upwards, for a view along -z. */
static void sloping_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const double x = -(double)direction[0][i] / (double)direction[2][i];
    const double y = -(double)direction[1][i] / (double)direction[2][i];
    for (int a = 0; a < 3; a++) radiance[a][i] = (float)(100 + (x + 0.5 * y) / pixel_size());
  }
}

/* Returns the covariance of a place on the unit disk with a coordinate that takes it there. */
static double disk_covariance(void) {
  enum { STEPS = 64 };
  double sum = 0;
  for (int i = 0; i < STEPS * STEPS; i++) {
    const float u[2] = {(float)((i % STEPS + 0.5) / STEPS), (float)((i / STEPS + 0.5) / STEPS)};
    float disk[2];
    pktrt_map_disk(u, disk);
    sum += ((double)u[0] - 0.5) * (double)disk[0];
  }
  return sum / (STEPS * STEPS);
}

/* Place in the pixel, lens and time add their parts. Of n samples each coordinate is spread over n parts by Sobol' points, over
   sqrt(n) by jittered ones. */
static void camera_coordinates(void) {
  static const struct {
    const char *name;
    bool lens, shutter;
    pktrt_sampler sampler;
    uint32_t samples, parts;
  } cases[] = {{"pixel", false, false, PKTRT_SAMPLER_RANDOM, 1, 1},
      {"pixel and lens", true, false, PKTRT_SAMPLER_RANDOM, 1, 1},
      {"pixel and time", false, true, PKTRT_SAMPLER_RANDOM, 1, 1},
      {"pixel, lens and time", true, true, PKTRT_SAMPLER_RANDOM, 1, 1},
      {"pixel, 16 Sobol' points", false, false, PKTRT_SAMPLER_SOBOL, 16, 16},
      {"pixel and time, 16 Sobol' points", false, true, PKTRT_SAMPLER_SOBOL, 16, 16},
      {"pixel and time, 16 jittered", false, true, PKTRT_SAMPLER_JITTERED, 16, 4}};
  for (size_t i = 0; i < COUNT(cases); i++) {
    const double parts = cases[i].parts;
    const double pixel = 1.25 / 12;
    const double lens = cases[i].lens ? 1.25 / 4 : 0;
    const double time = cases[i].shutter ? 1.5 * 1.5 / 12 : 0;
    pktrt_scene *s = floor_open();
    stage_commit(s);

    pktrt_render_desc view = spot_view(vec_of(0, 5, 0), vec_of(0, 5, -10));
    view.camera.fov_y = FOV;
    view.environment = sloping_sky;
    view.sampler = cases[i].sampler;
    view.samples = cases[i].samples;
    if (cases[i].lens) view.camera.aperture = (float)(20 * pixel_size());
    if (cases[i].shutter) {
      view.camera.shutter = 1;
      view.camera.moving = true;
      memcpy(view.camera.eye_end, view.camera.eye, sizeof view.camera.eye);
      memcpy(view.camera.target_end, view.camera.target, sizeof view.camera.target);
      for (int a = 0; a < 2; a++) {
        view.camera.target[a] -= (float)(5 * pixel_size());
        view.camera.target_end[a] += (float)(5 * pixel_size());
      }
    }
    const spread e = spread_of(s, &view, 32);
    const double each = 1 / (parts * parts) / cases[i].samples;
    const double same = cases[i].lens ? pixel + lens - 1.5 * disk_covariance() : 0.25 / 12 + time / 4;
    check_spread(cases[i].name, &e, 100, (pixel + lens + time) * each, (same + (cases[i].lens ? time : 0)) * each);
    pktrt_scene_destroy(s);
  }
}

/* Equal lamps in one place: variances add up where their samples are independent, deviations where these are the same. Where
   one is chosen, every other is a quarter turn on, or halves of them would make a whole. */
static void equal_lamps(void) {
  const quad lamp = {{-0.8, 1.5, -0.7}, {{1, 0, 0}, {0, 0, 1.2}}};
  const quad turned = {quad_at(&lamp, 1, 0), {lamp.edge[1], vec_mul(lamp.edge[0], -1)}};
  const lamp_moments m = lamp_moments_of(&lamp, false);
  for (int n = 2; n <= 5; n++)
    for (int one = 0; one < 2; one++) {
      pktrt_scene *s = floor_open();
      for (int i = 0; i < n; i++) add_flat_lamp(s, one && i % 2 ? &turned : &lamp, false);
      stage_commit(s);

      pktrt_render_desc view = spot_view(vec_of(3, 0.4, 3), vec_of(0, 0, 0));
      view.lights = one ? PKTRT_LIGHTS_ONE : PKTRT_LIGHTS_ALL;
      const spread e = spread_of(s, &view, 24);
      check_spread(one ? "one of equal lamps" : "equal lamps", &e, n * m.mean, (one ? n * n : n) * m.by_area,
          one ? n * m.by_area : (n + 2) * m.by_area);
      pktrt_scene_destroy(s);
    }
}

/* A floor that is half a mirror shows a ceiling, which gets as much light of a sphere between them. */
static void events(void) {
  const quad ceiling = quad_of(vec_of(0, 4, 0), vec_of(50, 0, 0), vec_of(0, 0, 50));
  const pktrt_material half = material_of(ALBEDO, PKTRT_SPECULAR_MIRROR, 0.5);
  const pktrt_material matt = material_of(ALBEDO, PKTRT_SPECULAR_NONE, 0);
  const double least = sqrt(1 - 1 / 8.0);
  const double size = ALBEDO / PI * 2 * PI * (1 - least);
  const double mean = size * sqrt(0.5) * (1 + least) / 2;
  const double t2 = (1 + least + least * least) / 3;
  const double variance = size * size * (0.5 * t2 + 0.25 * (1 - t2)) - mean * mean;
  pktrt_scene *s = stage_open();
  stage_quad(s, &ground, stage_material(s, &half));
  stage_quad(s, &ceiling, stage_material(s, &matt));
  pktrt_light lamp = light_of(PKTRT_LIGHT_SPHERE, 1);
  lamp.radius = 1;
  lamp.position[1] = 2;
  stage_light(s, &lamp);
  stage_commit(s);

  const pktrt_render_desc view = spot_view(vec_of(-4, 2, 0), vec_of(-2, 0, 0));
  const spread e = spread_of(s, &view, 32);
  check_spread("a floor and what it mirrors", &e, 1.5 * mean, 1.25 * variance, 2.25 * variance);
  pktrt_scene_destroy(s);
}

/* --- lobes and glass --- */

/* Returns the variance of a lobe that shares a sphere straight above with the light's samples. With p and q their densities the
   light counts q / (f p + q) of what its sample finds, and f p / (f p + q) of what the lobe does; f should be 1. */
static double lobe_variance(double exponent, double least, double f, double *mean) {
  enum { STEPS = 4000 };
  const double q = 1 / (2 * PI * (1 - least));
  double light[2] = {0, 0};
  double lobe[2] = {0, 0};
  for (int i = 0; i < STEPS; i++) {
    const double t = least + (1 - least) * (i + 0.5) / STEPS;
    const double p = (exponent + 1) / (2 * PI) * pow(t, exponent);
    const double size = 2 * PI * (1 - least) / STEPS;
    const double of_light = 0.5 * p / (f * p + q);
    const double of_lobe = 0.5 * f * p / (f * p + q);
    light[0] += size * q * of_light;
    light[1] += size * q * of_light * of_light;
    lobe[0] += size * p * of_lobe;
    lobe[1] += size * p * of_lobe * of_lobe;
  }
  *mean = light[0] + lobe[0];
  return light[1] - light[0] * light[0] + lobe[1] - lobe[0] * lobe[0];
}

static void lobes_and_lamps(void) {
  static const double exponents[] = {8, 60, 300};
  for (size_t i = 0; i < COUNT(exponents); i++)
    for (int naive = 0; naive < 2; naive++) {
      pktrt_material gloss = material_of(0, PKTRT_SPECULAR_MIRROR, 0.5);
      pktrt_light lamp = light_of(PKTRT_LIGHT_SPHERE, 1);
      double mean = 0;
      double ignored = 0;
      gloss.lobe = PKTRT_LOBE_PHONG;
      gloss.exponent = (float)exponents[i];
      lamp.radius = 1;
      lamp.position[1] = 4;
      pktrt_scene *s = stage_open();
      stage_quad(s, &ground, stage_material(s, &gloss));
      stage_light(s, &lamp);
      stage_commit(s);

      pktrt_render_desc view = spot_view(vec_of(0, 2, 0), vec_of(0, 0, 0));
      view.phong_mapping = naive ? PKTRT_PHONG_NAIVE : PKTRT_PHONG_CAREFUL;
      const double least = sqrt(1 - 1 / 16.0);
      const double want = lobe_variance(exponents[i], least, 1, &mean);
      const spread e = spread_of(s, &view, 32);
      check_spread("gloss under a lamp", &e, mean, want, lobe_variance(exponents[i], least, 4, &ignored));
      pktrt_scene_destroy(s);
    }
}

static void two_skies(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) radiance[a][i] = direction[1][i] > 0 ? 9 : 1;
}

/* Of what a pane reflects and lets through one is chosen, by as much as that is. */
static void choice_at_glass(void) {
  static const double angles[] = {40, 70, 80};
  for (size_t i = 0; i < COUNT(angles); i++) {
    const double angle = angles[i] * PI / 180;
    const double f = fresnel_exact(cos(angle), 1.5);
    const double even = 2 * (81 * f * f + (1 - f) * (1 - f)) - (9 * f + 1 - f) * (9 * f + 1 - f);
    const pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
    pktrt_scene *s = stage_open();
    stage_quad(s, &ground, stage_material(s, &glass));
    stage_commit(s);

    pktrt_render_desc view = spot_view(vec_of(2 * sin(angle), 2 * cos(angle), 0), vec_of(0, 0, 0));
    view.environment = two_skies;
    const spread e = spread_of(s, &view, 64);
    check_spread("glass between two skies", &e, 9 * f + 1 - f, f * (1 - f) * 64, even);
    pktrt_scene_destroy(s);
  }
}

void suite_variance(void) {
  run("lamps next to a floor are as noisy as by solid angle, others as by area", near_and_far);
  run("spheres are as noisy as by the cone in which they are seen", spheres);
  run("one light of two is chosen by power, distance, facing and cosine, and as noisily", weights_of_lights);
  run("far lights are chosen as often as all near ones together, and as noisily", far_lights);
  run("rows of lamps make no noise where none is hidden, long ones little", rows_of_lamps);
  run("floors under a sky are as noisy as by cosine and a table of where it is bright", skies);
  run("a prepared table has rows enough for a small sun, and so little noise", small_suns);
  run("what was prepared for another sky makes a picture no noisier", other_skies);
  run("place in the pixel, lens and time are independent, and spread as samplers spread them", camera_coordinates);
  run("equal lamps have samples of their own, and so has the choice among them", equal_lamps);
  run("a floor and what it mirrors have samples of their own", events);
  run("gloss under a lamp is as noisy as by both ways to find it, by their densities", lobes_and_lamps);
  run("a choice at glass is as noisy as by what is reflected there", choice_at_glass);
}
