/* Check of chapter 9: boxes hold what moves, and spare tests; estimates that choose have the mean of following both. */
#define PKTRT_IMPLEMENTATION
#include "09_exercise.h"

enum { GROUPS = 64, EACH = 8, RAYS = 4000, TRIALS = 20000, PLACES = 8, WALKS = 4000 };

/* >>boxes ---------------------------------------------------------------------------------------------------------- */

typedef struct mover { /* a triangle that moves, and its boxes at both ends */
  vec corner[2][3];
  course_box key[2];
} mover;

static float between(float lo, float hi, uint32_t *random) { return lo + (hi - lo) * course_random(random); }

static void grow(course_box *b, const course_box *other) {
  for (int a = 0; a < 3; a++) {
    b->lo.at[a] = fminf(b->lo.at[a], other->lo.at[a]);
    b->hi.at[a] = fmaxf(b->hi.at[a], other->hi.at[a]);
  }
}

static mover make_mover(vec center, vec step, float size, uint32_t *random) {
  mover m;
  for (int key = 0; key < 2; key++)
    for (int c = 0; c < 3; c++) {
      for (int a = 0; a < 3; a++)
        m.corner[key][c].at[a] = center.at[a] + (key ? step.at[a] : 0) + between(-size, size, random);
      const course_box corner = {m.corner[key][c], m.corner[key][c]};
      if (c == 0) m.key[key] = corner;
      else grow(&m.key[key], &corner);
    }
  return m;
}

/* What the exercise is about, forgotten: interpolation in floats, rounded as it comes. */
static void careless_box(const course_box *first, const course_box *last, float time, course_box *now) {
  now->lo = vec_add(vec_scale(first->lo, 1 - time), vec_scale(last->lo, time));
  now->hi = vec_add(vec_scale(first->hi, 1 - time), vec_scale(last->hi, time));
}

/* The other way: all that passes. */
static void united_box(const course_box *first, const course_box *last, float time, course_box *now) {
  (void)time;
  *now = *first;
  grow(now, last);
}

typedef void box_rule(const course_box *first, const course_box *last, float time, course_box *now);

/* Counts corners that leave their box by more than double's own rounding; says where the first one does. */
static unsigned count_escapes(box_rule *boxes, bool aloud) {
  uint32_t random = 9;
  unsigned escapes = 0;
  for (int i = 0; i < TRIALS; i++) {
    const float scale = ldexpf(1, i % 21 - 10), time = i % 16 == 0 ? 0 : i % 16 == 1 ? 1 : course_random(&random);
    vec center, step;
    for (int a = 0; a < 3; a++)
      center.at[a] = scale * between(-9, 9, &random), step.at[a] = scale * between(-5, 5, &random);
    const mover m = make_mover(center, i % 7 ? step : vec_make(0, 0, 0), scale, &random);
    course_box now;
    boxes(&m.key[0], &m.key[1], time, &now);
    for (int j = 0; j < 9; j++) {
      const int a = j % 3;
      const double p0 = (double)m.corner[0][j / 3].at[a], p1 = (double)m.corner[1][j / 3].at[a];
      const double p = (1 - (double)time) * p0 + (double)time * p1, slack = 1e-15 * fmax(fabs(p0), fabs(p1));
      if (p >= (double)now.lo.at[a] - slack && p <= (double)now.hi.at[a] + slack) continue;
      if (escapes++ == 0 && aloud)
        printf(
            "motion %d at time %.9g: a corner has %c = %.12g\n  expected: a box that holds it\n  got: %.12g to %.12g\n",
            i, (double)time, "xyz"[a], p, (double)now.lo.at[a], (double)now.hi.at[a]);
    }
  }
  return escapes;
}

static bool meets(const pktrt_ray *ray, const course_box *b) {
  float in = 0, out = INFINITY;
  for (int a = 0; a < 3; a++) {
    const float t0 = (b->lo.at[a] - ray->origin[a]) / ray->direction[a],
                t1 = (b->hi.at[a] - ray->origin[a]) / ray->direction[a];
    in = fmaxf(in, fminf(t0, t1)), out = fminf(out, fmaxf(t0, t1));
  }
  return in <= out;
}

/* A tree of two levels: groups of triangles that move together. Counts the tests that follow where a ray meets the box of
   a group. */
static unsigned count_tests(box_rule *boxes) {
  static mover movers[GROUPS][EACH];
  course_box group[GROUPS][2];
  uint32_t random = 99;
  unsigned tests = 0;
  for (int g = 0; g < GROUPS; g++) {
    vec center, step;
    for (int a = 0; a < 3; a++) center.at[a] = between(-4, 4, &random), step.at[a] = between(-2, 2, &random);
    for (int i = 0; i < EACH; i++) {
      vec at = center;
      for (int a = 0; a < 3; a++) at.at[a] += between(-0.4f, 0.4f, &random);
      movers[g][i] = make_mover(at, step, 0.1f, &random);
      for (int key = 0; key < 2; key++)
        if (i == 0) group[g][key] = movers[g][i].key[key];
        else grow(&group[g][key], &movers[g][i].key[key]);
    }
  }
  for (int r = 0; r < RAYS; r++) {
    pktrt_ray ray = {{0, 0, 0}, 0, {0, 0, 0}, INFINITY, 0};
    for (int a = 0; a < 3; a++) ray.origin[a] = between(-5, 5, &random), ray.direction[a] = between(-1, 1, &random);
    ray.time = course_random(&random);
    for (int g = 0; g < GROUPS; g++) {
      course_box now;
      boxes(&group[g][0], &group[g][1], ray.time, &now);
      if (!meets(&ray, &now)) continue;
      for (int i = 0; i < EACH; i++) {
        boxes(&movers[g][i].key[0], &movers[g][i].key[1], ray.time, &now);
        tests += meets(&ray, &now) ? 2 : 1; /* the box, and the triangle in it */
      }
    }
  }
  return tests;
}

static const char *check_boxes(void) {
  const unsigned careless = count_escapes(careless_box, false);
  printf("boxes that forget rounding lose %u of %d coordinates, 9 of each of %d triangles: the check sees it\n",
      careless, 9 * TRIALS, TRIALS);
  course_figure("triangles", "%d", TRIALS);
  course_figure("careless.boxes", "%u", careless);
  course_figure("coordinates", "%d", 9 * TRIALS);
  if (careless == 0) return "the control passes: careless boxes lose nothing here";
  const unsigned escapes = count_escapes(box_at, true);
  if (escapes) return "a box does not hold what moves";
  const unsigned mine = count_tests(box_at), least = count_tests(careless_box), united = count_tests(united_box);
  printf(
      "tests of boxes and triangles of a group, where a ray meets the group's box: yours %u, united boxes %u, without "
      "any margin %u\n",
      mine, united, least);
  if ((double)mine > 0.25 * (double)united)
    return "the boxes spare less than three quarters of the tests of united ones";
  if ((double)mine > 1.02 * (double)least) return "the boxes are larger than they must be";
  return NULL;
}

/* >>glass ---------------------------------------------------------------------------------------------------------- */

static unsigned calls;  /* of glass_trace */
static unsigned tunnel; /* if not 0: after so many surfaces there is the sky, whichever way one goes */

glass glass_trace(const pktrt_scene *scene, const pktrt_ray *ray) {
  glass g = {0};
  pktrt_hit hit;
  pktrt_surface_info at;
  calls++;
  if (tunnel > 0) {
    g.sky = calls > tunnel, g.radiance = 1, g.reflectance = 0.5f, g.reflected = g.refracted = *ray;
    return g;
  }
  g.sky = !pktrt_intersect(scene, ray, &hit);
  vec d = vec_make(ray->direction[0], ray->direction[1], ray->direction[2]);
  d = vec_unit(d);
  g.radiance = 1 + sinf(5 * d.at[0]) * cosf(7 * d.at[1]);
  if (g.sky) return g;
  pktrt_surface(scene, ray, &hit, &at);
  const vec n = vec_make(at.normal[0], at.normal[1], at.normal[2]);
  const float cosine = fminf(1, -vec_dot(d, n)), eta = at.inside ? 1 / 1.5f : 1.5f;
  const vec reflected = vec_add(d, vec_scale(n, 2 * cosine));
  g.reflectance = pktrt_fresnel_dielectric(cosine, eta);
  pktrt_spawn(scene, ray, &hit, reflected.at, &g.reflected);
  const float under = 1 - (1 - cosine * cosine) / (eta * eta); /* squared cosine of the refracted ray */
  if (under <= 0) return g;
  const vec refracted = vec_add(vec_scale(d, 1 / eta), vec_scale(n, cosine / eta - sqrtf(under)));
  pktrt_spawn(scene, ray, &hit, refracted.at, &g.refracted);
  return g;
}

/* Follows both ways. */
static double both(const pktrt_scene *scene, const pktrt_ray *ray, int depth) {
  const glass g = glass_trace(scene, ray);
  if (g.sky || depth == GLASS_DEPTH) return g.sky ? (double)g.radiance : 0;
  const double f = (double)g.reflectance;
  return (f > 0 ? f * both(scene, &g.reflected, depth + 1) : 0) +
         (f < 1 ? (1 - f) * both(scene, &g.refracted, depth + 1) : 0);
}

/* What must not pass: chooses evenly, and does not weight. */
static float careless_radiance(const pktrt_scene *scene, pktrt_ray ray, uint32_t *random) {
  for (int depth = 0;; depth++) {
    const glass g = glass_trace(scene, &ray);
    if (g.sky || depth == GLASS_DEPTH) return g.sky ? g.radiance : 0;
    ray = g.reflectance >= 1 || course_random(random) < 0.5f ? g.reflected : g.refracted;
  }
}

typedef float estimator(const pktrt_scene *scene, pktrt_ray ray, uint32_t *random);

/* Compares means at some places. Returns how many are off by more than 4 standard errors; counts those where an estimate
   follows more than one ray. */
static int count_wrong(const pktrt_scene *scene, estimator *estimate, bool aloud, int *branching) {
  int wrong = 0;
  for (int i = 0; i < PLACES; i++) {
    const pktrt_ray ray =
        course_library_ray(course_camera_ray(130 + 9 * (float)(i % 4), 100 + 30 * (float)(i / 4), 256, 192));
    const double expected = both(scene, &ray, 0);
    double sum = 0, squares = 0;
    uint32_t random = 1000 * (uint32_t)i;
    unsigned most = 0, all = 0;
    for (int k = 0; k < WALKS; k++) {
      calls = 0;
      const double x = (double)estimate(scene, ray, &random);
      most = calls > most ? calls : most, all += calls;
      sum += x, squares += x * x;
    }
    const double mean = sum / WALKS, error = sqrt(fmax(0, squares / WALKS - mean * mean) / (WALKS - 1));
    const bool good = fabs(mean - expected) <= 4 * error + 1e-5 * expected, many = most > GLASS_DEPTH + 1;
    if (aloud)
      printf("ray %d: both ways %.4f, yours %.4f, standard error %.4f, %.1f rays each\n", i, expected, mean, error,
          (double)all / WALKS);
    if (aloud && !good) printf("  expected: within 4 standard errors of both ways\n");
    if (aloud && many) printf("  expected: at most %d rays, got: up to %u\n", GLASS_DEPTH + 1, most);
    wrong += !good, *branching += many;
  }
  return wrong;
}

/* The sky behind as many surfaces as a path may meet, and behind one more. */
static bool check_depth(const pktrt_scene *scene) {
  const pktrt_ray ray = course_library_ray(course_camera_ray(128, 96, 256, 192));
  uint32_t random = 1;
  bool good = true;
  for (tunnel = GLASS_DEPTH; tunnel <= GLASS_DEPTH + 1; tunnel++) {
    const bool sees = tunnel == GLASS_DEPTH;
    calls = 0;
    const float got = radiance_of_one(scene, ray, &random);
    if ((got > 0) == sees && calls == GLASS_DEPTH + 1) continue;
    printf("a sky of radiance 1 behind %u surfaces\n  expected: %s by %d rays\n  got: %g by %u rays\n", tunnel,
        sees ? "1" : "0", GLASS_DEPTH + 1, (double)got, calls);
    good = false;
  }
  tunnel = 0;
  return good;
}

static const char *check_glass(void) {
  course_scene s = course_scene_make();
  pktrt_scene *scene = course_library(&s);
  int others = 0, branching = 0;
  const int careless = count_wrong(scene, careless_radiance, false, &others);
  const int mine = count_wrong(scene, radiance_of_one, true, &branching);
  const bool deep = check_depth(scene);
  printf("choosing evenly is wrong for %d of %d rays: the check sees it\n", careless, PLACES);
  course_figure("careless.places", "%d", careless);
  course_figure("places", "%d", PLACES);
  course_figure("estimates", "%d", WALKS);
  pktrt_scene_destroy(scene);
  if (careless == 0) return "the control passes: choosing evenly is right here";
  if (branching) return "an estimate traces more rays than one for each surface";
  if (mine) return "an estimate has another mean than both ways together";
  return deep ? NULL : "a path ends too early or too late";
}

int main(void) {
  const char *boxes = check_boxes(), *rays = check_glass();
  return course_result(9, boxes ? boxes : rays);
}
