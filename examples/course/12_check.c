/* Checks exercise 12: the disk is the library's; the lobe, weighted, is the library's above the surface, and no ray is
   lost. As a control, mappings with a known fault must be refused, each for its fault. */
#define PKTRT_IMPLEMENTATION
#include "12_mapping.h"

enum { CELLS = 8, CELLS2 = CELLS * CELLS, SIDE = 128, LIBRARY_SIDE = 512, ANGLES = 5, EXPONENTS = 5 };

/* What is wrong with a mapping. */
typedef enum fault {
  FAULT_NONE,
  FAULT_ORIGIN,
  FAULT_LENGTH,
  FAULT_BELOW,
  FAULT_LOST,
  FAULT_APART,
  FAULT_MEAN,
  FAULT_SHARES
} fault;

static const char *const fault_sentence[] = {NULL,
    "the origin of the square goes to a direction at the edge of the lobe", "directions do not have unit length",
    "directions are below the surface", "weights are not above 0 and at most 1: is a ray lost?",
    "neighbours of the square are too far apart in the lobe",
    "the mean weight is not the part of the lobe that is above the surface",
    "the weighted directions are not distributed as the lobe is above the surface"};

/* One case: an axis, a normal and an exponent. */
typedef struct lobe_case {
  float axis[3], normal[3], exponent, degrees;
} lobe_case;

/* Returns a case: angles from 0 to 89 degrees off the normal, exponents from 1 to a million, turned differently. */
static lobe_case make_case(int angle, int exponent) {
  static const float degrees[ANGLES] = {0, 30, 60, 80, 89};
  static const float exponents[EXPONENTS] = {1, 10, 100, 1000, 1000000};
  static const vec normals[3] = {{{0, 1, 0}}, {{0, 0, -1}}, {{0.48f, -0.6f, 0.64f}}};
  const vec n = normals[(angle + exponent) % 3];
  const vec across = vec_unit(vec_cross(n, vec_make(0.6f, 0.3f, 0.2f)));
  const float radians = degrees[angle] * 0.0174532925f;
  const vec axis = vec_unit(vec_add(vec_scale(n, cosf(radians)), vec_scale(across, sinf(radians))));
  lobe_case c;

  memcpy(c.axis, angle == 0 ? n.at : axis.at, sizeof c.axis);
  memcpy(c.normal, n.at, sizeof c.normal);
  c.exponent = exponents[exponent];
  c.degrees = degrees[angle];
  return c;
}

/* Prints a sample of a case and the direction. */
static void say(const lobe_case *c, const float u[2], const float out[3], float weight) {
  printf("axis (%.7g, %.7g, %.7g), %g degrees off the normal (%g, %g, %g), exponent %g, u = (%.7g, %.7g)\n",
      (double)c->axis[0], (double)c->axis[1], (double)c->axis[2], (double)c->degrees, (double)c->normal[0],
      (double)c->normal[1], (double)c->normal[2], (double)c->exponent, (double)u[0], (double)u[1]);
  printf("  got: direction (%.7g, %.7g, %.7g), weight %.7g, dot(direction, normal) = %.7g\n", (double)out[0],
      (double)out[1], (double)out[2], (double)weight, mapping_dot(out, c->normal));
}

/* Returns the angle, in degrees, around the axis that holds 63 of 64 samples of the lobe. */
static double lobe_width(float exponent) { return 360 / COURSE_TURN * acos(pow(1.0 / 64, 1 / ((double)exponent + 1))); }

/* Returns the fault of the origin, of single samples, and of neighbours. */
static fault judge_samples(lobe_mapping *mapping, const lobe_case *c, bool aloud) {
  const double width = lobe_width(c->exponent);
  const float origin[2] = {0, 0};
  float out[3];
  float weight = mapping(origin, c->axis, c->normal, c->exponent, out);

  if (!(mapping_degrees(out, c->axis) <= width)) {
    if (aloud) say(c, origin, out, weight);
    if (aloud) printf("  %.3g degrees off the axis\n  expected: at most %.3g\n", mapping_degrees(out, c->axis), width);
    return FAULT_ORIGIN;
  }

  for (uint32_t i = 0; i < SIDE * SIDE; i++) {
    float u[2];
    fault found = FAULT_NONE;
    mapping_centre(i % SIDE, i / SIDE, SIDE, u);
    weight = mapping(u, c->axis, c->normal, c->exponent, out);

    if (!(fabs(mapping_dot(out, out) - 1) <= 1e-4)) found = FAULT_LENGTH;
    else if (!(weight > 0 && weight <= 1.00001f)) found = FAULT_LOST;
    else if (!(mapping_dot(out, c->normal) >= -1e-6)) found = FAULT_BELOW;
    if (found == FAULT_NONE) continue;
    if (aloud) say(c, u, out, weight);
    return found;
  }

  const lobe_measure measure = lobe_measure_of(mapping, c->axis, c->normal, c->exponent);
  if (measure.step <= width / 4) return FAULT_NONE;
  if (aloud)
    printf(
        "axis %g degrees off the normal, exponent %g: neighbours of a grid of %d x %d samples are up to %.3g degrees "
        "apart\n  expected: at most %.3g, a quarter of the angle that holds 63 of 64 samples\n",
        (double)c->degrees, (double)c->exponent, GRID, GRID, measure.step, width / 4);
  return FAULT_APART;
}

/* Adds the weights of a grid of samples by cells of directions, as shares of all samples: rings around the axis, which
   the lobe without a surface fills evenly, and sectors of these. Also sums the weighted cosines to axis and normal. */
static void add_shares(
    lobe_mapping *mapping, const lobe_case *c, uint32_t side, double share[CELLS2], double moment[2]) {
  float across[3];
  float up[3];

  mapping_frame(c->axis, c->normal, across, up);
  memset(share, 0, CELLS2 * sizeof *share);
  moment[0] = 0;
  moment[1] = 0;

  for (uint32_t i = 0; i < side * side; i++) {
    float u[2];
    float out[3];
    mapping_centre(i % side, i / side, side, u);
    const double weight = (double)mapping(u, c->axis, c->normal, c->exponent, out) / side / side;

    /* The sine tells more than the cosine where the lobe is narrow. */
    const double x = mapping_dot(out, across);
    const double y = mapping_dot(out, up);
    const double cosine = fabs(mapping_dot(out, c->axis));
    const double power = pow(cosine * cosine / (cosine * cosine + x * x + y * y), ((double)c->exponent + 1) / 2);
    const int ring = (int)fmin(CELLS - 1, CELLS * (1 - power));
    const int sector = (int)fmin(CELLS - 1, CELLS * (atan2(y, x) / COURSE_TURN + 0.5));

    share[ring * CELLS + sector] += weight;
    moment[0] += weight * mapping_dot(out, c->axis);
    moment[1] += weight * mapping_dot(out, c->normal);
  }
}

/* Returns a fault if the mean weight, the shares of cells, or the mean cosines differ from the library's lobe above the
   surface. Raises *worst, a chi-squared. */
static fault judge_shares(lobe_mapping *mapping, const lobe_case *c, bool aloud, double *worst) {
  const double most = 20, slack = 0.004;
  double mine[CELLS2], theirs[CELLS2], moment[2], their_moment[2];
  double squares = 0, all = 0, their_all = 0;

  add_shares(mapping, c, SIDE, mine, moment);
  add_shares(lobe_thrown_away, c, LIBRARY_SIDE, theirs, their_moment);
  for (int i = 0; i < CELLS2; i++) {
    squares += SIDE * SIDE * pow(mine[i] - theirs[i], 2) / (theirs[i] + 1.0 / 1024);
    all += mine[i];
    their_all += theirs[i];
  }

  *worst = fmax(*worst, squares);
  const bool mean = fabs(all - their_all) < slack;
  const bool cosines = fabs(moment[0] - their_moment[0]) < slack && fabs(moment[1] - their_moment[1]) < slack;
  if (mean && cosines && squares <= most) return FAULT_NONE;

  if (aloud) {
    printf("axis %g degrees off the normal, exponent %g, compared with the library's lobe above the surface:\n",
        (double)c->degrees, (double)c->exponent);
    printf("  mean weight: expected %.4f, got %.4f\n", their_all, all);
    printf("  mean of weight times cosine to the axis: expected %.4f, got %.4f\n", their_moment[0], moment[0]);
    printf("  mean of weight times cosine to the normal: expected %.4f, got %.4f; all within %g\n", their_moment[1],
        moment[1], slack);
    printf("  chi-squared of %d cells: expected at most %.0f, got %.1f (random directions of the lobe: some %d)\n",
        CELLS2, most, squares, CELLS2);
    if (c->exponent > 1e5f) printf("  of narrow lobes alone: is the sine computed from a rounded cosine?\n");
  }
  return mean ? FAULT_SHARES : FAULT_MEAN;
}

/* Returns the first fault of a mapping in all cases. */
static fault judge(lobe_mapping *mapping, bool aloud) {
  double worst = 0;

  for (int i = 0; i < ANGLES * EXPONENTS; i++) {
    const lobe_case c = make_case(i % ANGLES, i / ANGLES);
    const fault found = judge_samples(mapping, &c, aloud);
    if (found != FAULT_NONE) return found;
  }
  for (int i = 0; i < ANGLES * EXPONENTS; i++) {
    const lobe_case c = make_case(i % ANGLES, i / ANGLES);
    const fault found = judge_shares(mapping, &c, aloud, &worst);
    if (found != FAULT_NONE) return found;
  }

  if (aloud) printf("lobe: %d cases, the greatest chi-squared %.2f\n", ANGLES * EXPONENTS, worst);
  return FAULT_NONE;
}

/* Returns true if a mapping to the disk is the library's. */
static bool judge_disk(void (*mapping)(const float u[2], float out[2]), bool aloud) {
  enum { STEPS = 64 };

  for (uint32_t i = 0; i < STEPS * STEPS; i++) {
    const float u[2] = {(float)(i % STEPS) / STEPS, (float)(i / STEPS) / STEPS};
    float mine[2], theirs[2];
    mapping(u, mine);
    pktrt_map_disk(u, theirs);
    if (fabsf(mine[0] - theirs[0]) <= 1e-5f && fabsf(mine[1] - theirs[1]) <= 1e-5f) continue;
    if (aloud)
      printf("disk, u = (%g, %g)\n  expected: (%.7g, %.7g)\n  got: (%.7g, %.7g)\n", (double)u[0], (double)u[1],
          (double)theirs[0], (double)theirs[1], (double)mine[0], (double)mine[1]);
    return false;
  }

  if (aloud) {
    printf("disk: %d points are the library's\n", STEPS * STEPS);
    course_figure("disk.points", "%d", STEPS * STEPS);
  }
  return true;
}

/* A lobe that is too wide, and folded. */
static float lobe_wide(const float u[2], const float axis[3], const float normal[3], float exponent, float out[3]) {
  return lobe_folded(u, axis, normal, 0.8f * exponent, out);
}

/* Returns a sentence if a mapping with a known fault is not refused for this fault. */
static const char *control(void) {
  if (judge_disk(disk_polar, false)) return "the control passes: a polar disk is taken for a concentric one";
  if (judge(lobe_naive, false) != FAULT_ORIGIN) return "the control passes: the naive lobe's origin is not noticed";
  if (judge(lobe_thrown_away, false) != FAULT_LOST) return "the control passes: lost rays are not noticed";
  if (judge(lobe_retried, false) != FAULT_APART) return "the control passes: neighbours far apart are not noticed";
  if (judge(lobe_folded, false) != FAULT_MEAN) return "the control passes: weights that are too large are not noticed";
  if (judge(lobe_wide, false) != FAULT_SHARES) return "the control passes: a lobe that is too wide is not noticed";
  printf("control: six mappings with a known fault are refused\n");
  return NULL;
}

/* Returns what is wrong, or NULL. */
static const char *check(void) {
  const char *why = control();
  if (why) return why;
  if (!judge_disk(disk_of, true)) return "the disk is not concentric, or turned";

  const fault found = judge(lobe_above, true);
  if (found != FAULT_NONE) return fault_sentence[found];

  printf("axis 80 degrees off the normal, exponent 10: ");
  lobe_measure_print(lobe_above, 80, 10);
  return NULL;
}

int main(void) {
  course_check_begins(12);
  return course_result(12, check());
}
