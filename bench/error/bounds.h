/* bounds.h - how little N points that are scrambled in Owen's way can err at all, and what Sobol' points leave.

   Two points whose coordinates share b binary digits, and no more, have products f(x) f(x') of a known mean R(b) over all
   scrambles: with E(k) the mean square of f's means over intervals of length 2^-k, R(b) = 2 E(b) - E(b + 1), and R is E
   of all digits for the point itself. In several dimensions, of a product of such functions, R is the product. So

     N variance = R(itself) + sum over b of a(b) R(b) - N mean^2,

   where a(b) >= 0 is how many other points share so many digits with a point, on average. Whatever the points are,
   sum a = N - 1, and for each k the mean over pairs of the product of v(k_j, b_j) is not negative, for v is a sum of
   products of wavelets: v(0, b) = 1, v(k, b) = 1 for b >= k, -1 for b = k - 1, else 0. The least value of the sum under
   these conditions is a linear program (Delsarte's bound for codes, in the metric of digits), which glpsol solves; a(b)
   is taken for all b with the same digits in another order, since the integrands are symmetric.

   Contents: integrands, points, linear programs, report. */
#ifndef ERROR_BOUNDS_H
#define ERROR_BOUNDS_H

#include "error.h"
#include "slopes.h"

/* >>integrands ----------------------------------------------------------------------------------------------------- */

enum { DIGITS = 24 };
typedef struct model { /* a factor of a product, at random as those of slopes.h */
  const char *name;
  double pairs[DIGITS + 1], itself, mean2; /* R(b), R of the point itself, squared mean */
} model;

static void set_pairs(model *f, const double *squares) {
  for (int b = 0; b <= DIGITS; b++) f->pairs[b] = 2 * squares[b] - squares[b + 1];
  f->mean2 = squares[0];
}

/* exp(a x), a uniform in [0.5, 2], by the midpoint rule over a. */
static model exponential_model(void) {
  enum { STEPS = 1000 };
  double squares[DIGITS + 2] = {0};
  model f = {"exponential", {0}, 0, 0};
  for (int i = 0; i < STEPS; i++) {
    const double a = 0.5 + 1.5 * (i + 0.5) / STEPS;
    for (int k = 0; k < DIGITS + 2; k++) {
      const double h = ldexp(1, -k), mean = expm1(a * h) / (a * h);
      squares[k] += mean * mean * h * expm1(2 * a) / expm1(2 * a * h) / STEPS;
    }
    f.itself += expm1(2 * a) / (2 * a) / STEPS;
  }
  set_pairs(&f, squares);
  return f;
}

/* 1 for x < a, a uniform in [0, 1]: one interval holds the step, by a part that is uniform. */
static model box_model(void) {
  double squares[DIGITS + 2];
  model f = {"box", {0}, 0.5, 0};
  for (int k = 0; k < DIGITS + 2; k++) squares[k] = 0.5 - ldexp(1, -k) / 6;
  set_pairs(&f, squares);
  return f;
}

/* >>points --------------------------------------------------------------------------------------------------------- */

static int shared_digits(float a, float b) {
  const uint32_t off = (uint32_t)(a * 0x1p24f) ^ (uint32_t)(b * 0x1p24f);
  int n = 0;
  while (n < DIGITS && !(off >> (DIGITS - 1 - n) & 1)) n++;
  return n;
}

/* The variance over all scrambles of the mean of a product over the samples of a pixel, from the digits that one of
   them shows. */
static double variance_of_points(const pktrt_sampling *s, const model *f, unsigned dimensions) {
  float(*u)[4] = (float(*)[4])malloc(s->samples * sizeof *u);
  double sum = 0;
  if (!u) fatal("not enough memory");
  for (uint32_t i = 0; i < s->samples; i++) pktrt_sample(s, 0, 0, i, 0, 4, u[i]);
  for (uint32_t i = 0; i < s->samples; i++)
    for (uint32_t j = 0; j < s->samples; j++) {
      double product = 1;
      for (unsigned d = 0; d < dimensions; d++)
        product *= i == j ? f->itself : f->pairs[shared_digits(u[i][d], u[j][d])];
      sum += product - pow(f->mean2, dimensions);
    }
  free(u);
  return sum / square(s->samples);
}

/* >>linear programs ------------------------------------------------------------------------------------------------ */

static double wavelets(int k, int b) { return !k || b >= k ? 1 : b == k - 1 ? -1 : 0; }

static void swap(int *a, int *b) {
  const int t = *a;
  *a = *b, *b = t;
}
/* The next order of n numbers (lexicographical); false after the last. */
static bool next_order(int *order, int n) {
  int i = n - 2, j = n - 1;
  while (i >= 0 && order[i] >= order[i + 1]) i--;
  if (i < 0) return false;
  while (order[j] <= order[i]) j--;
  swap(&order[i], &order[j]);
  for (int low = i + 1, high = n - 1; low < high; low++, high--) swap(&order[low], &order[high]);
  return true;
}

/* Mean over all orders of b of the product of v(k_j, b_j). */
static double kernel(const int *k, const int *b, int dimensions) {
  int order[4] = {0, 1, 2, 3};
  double sum = 0, orders = 0;
  do {
    double product = 1;
    for (int d = 0; d < dimensions; d++) product *= wavelets(k[d], b[order[d]]);
    sum += product, orders++;
  } while (next_order(order, dimensions));
  return sum / orders;
}

/* All b_0 >= b_1 >= ... with `most` digits at most, of 2 or 4 dimensions; returns how many. */
static int list_shapes(int most, unsigned dimensions, int (*shapes)[4]) {
  int n = 0, b[4];
  for (b[0] = 0; b[0] <= most; b[0]++)
    for (b[1] = 0; b[1] <= b[0]; b[1]++)
      for (b[2] = 0; b[2] <= (dimensions > 2 ? b[1] : 0); b[2]++)
        for (b[3] = 0; b[3] <= (dimensions > 2 ? b[2] : 0); b[3]++) memcpy(shapes[n++], b, sizeof b);
  return n;
}

enum { MAX_SHAPES = 512 }; /* 8 digits: 495 */

static void write_program(FILE *file, const model *f, unsigned dimensions, int most, double n) {
  static int shapes[MAX_SHAPES][4];
  const int count = list_shapes(most, dimensions, shapes);
  fprintf(file, "Minimize\n sum:");
  for (int i = 0; i < count; i++) {
    double product = 1;
    for (unsigned d = 0; d < dimensions; d++) product *= f->pairs[shapes[i][d]];
    fprintf(file, "\n %+.15g a%d", product - pow(f->mean2, dimensions), i);
  }
  fprintf(file, "\nSubject To\n");
  for (int k = 0; k < count; k++) {
    fprintf(file, " k%d:", k);
    for (int i = 0; i < count; i++) {
      const double v = kernel(shapes[k], shapes[i], (int)dimensions);
      if (v < 0 || v > 0) fprintf(file, "\n %+.15g a%d", v, i);
    }
    if (k) fprintf(file, "\n >= -1\n");
    else fprintf(file, "\n = %.0f\n", n - 1);
  }
  fprintf(file, "End\n");
}

/* The least variance of n = 2^most points; NAN if glpsol is not there or fails. Digits beyond the first `most` are left
   to the point itself, which can only lower it. */
static double least_variance(const bench *b, const model *f, unsigned dimensions, int most) {
  const char *folder = b->given.results ? b->given.results : ".";
  char path[4096], answer[4096], command[8300], line[256];
  const double n = ldexp(1, most);
  double least = NAN;
  bool solved = false;
  snprintf(path, sizeof path, "%s/error_bounds.lp", folder);
  snprintf(answer, sizeof answer, "%s/error_bounds.txt", folder);
  /* To a file of its own: glpsol removes what it is told to write, and would remove /dev/stdout, too. */
  snprintf(command, sizeof command, "glpsol --lp '%.4000s' -o '%.4000s' >/dev/null 2>&1", path, answer);
  FILE *file = fopen(path, "w");
  if (!file) fatal("a linear program cannot be written");
  write_program(file, f, dimensions, most, n);
  if (fclose(file)) fatal("a linear program cannot be written");
  FILE *answer_file = system(command) == 0 ? fopen(answer, "r") : NULL;
  while (answer_file && fgets(line, sizeof line, answer_file)) {
    solved = solved || !strncmp(line, "Status:     OPTIMAL", 19);
    if (!strncmp(line, "Objective:", 10) && strchr(line, '=')) least = strtod(strchr(line, '=') + 1, NULL);
  }
  if (answer_file) fclose(answer_file);
  if (!solved) least = NAN;
  remove(path);
  remove(answer);
  return (least + pow(f->itself, dimensions) - pow(f->mean2, dimensions)) / n;
}

/* >>report --------------------------------------------------------------------------------------------------------- */

static void bound_line(const bench *b, const model *f, unsigned dimensions) {
  double n[SLOPE_POINTS], ours[SLOPE_POINTS], least[SLOPE_POINTS], worst = 0;
  say(&b->out, "| %s, %u |", f->name, dimensions);
  for (unsigned i = 0; i < SLOPE_POINTS; i++) {
    pktrt_sampling s = {PKTRT_SAMPLER_SOBOL, 4u << i, FIRST_SEED};
    n[i] = s.samples, ours[i] = variance_of_points(&s, f, dimensions);
    least[i] = least_variance(b, f, dimensions, (int)i + 2);
    const double random = (pow(f->itself, dimensions) - pow(f->mean2, dimensions)) / n[i];
    worst = larger(worst, sqrt(ours[i] / least[i]));
    say(&b->out, " %.4f, %.4f |", sqrt(ours[i] / random), sqrt(least[i] / random));
    csv(&b->out, "%s,%u,%.0f,%.6g,%.6g,%.6g\n", f->name, dimensions, n[i], sqrt(ours[i]), sqrt(least[i]), sqrt(random));
  }
  say(&b->out, " %.3f | %.2f, %.2f |\n", worst, log_slope(n, ours, SLOPE_POINTS, 1).value,
      log_slope(n, least, SLOPE_POINTS, 1).value);
}

static void part_bounds(bench *b) {
  const model models[2] = {exponential_model(), box_model()};
  if (system("glpsol --version >/dev/null 2>&1")) {
    say(&b->out, "Not done: there is no glpsol (make deps-extra installs it).\n\n");
    return;
  }
  csv(&b->out, "integrand,dimensions,samples,sobol,least,random\n");
  say(&b->out,
      "RMSE over that of random points: of Sobol' points, exactly, and the least of any points scrambled alike; the "
      "largest ratio of the two; slopes of both over N = 4 to 256.\n\n| integrand, dimensions |");
  for (unsigned i = 0; i < SLOPE_POINTS; i++) say(&b->out, " %u |", 4u << i);
  say(&b->out, " over the least | slopes |\n|---|");
  for (unsigned i = 0; i < SLOPE_POINTS; i++) say(&b->out, "--:|");
  say(&b->out, "--:|--:|\n");
  for (int k = 0; k < 2; k++)
    for (unsigned dimensions = 2; dimensions <= 4; dimensions += 2) bound_line(b, &models[k], dimensions);
  say(&b->out, "\n");
}

#endif /* ERROR_BOUNDS_H */
