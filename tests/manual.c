/* The worked examples of examples/manual.md: their numbers are computed from the library's constants and its exact
   arithmetic, printed, and looked for in the manual, line by line. */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#undef PKTRT_SCALAR
#undef PKTRT_NO_SCALAR
#undef PKTRT_AVX512
#define PKTRT_STATIC
#define PKTRT_NO_SIMD
#define PKTRT_NO_RENDER
#define PKTRT_NO_PAPER
#define PKTRT_NO_STATS
#define PKTRT_NO_CLOSEST
#define PK_NO_SETTINGS /* see settings.c */
#define PKTRT_IMPLEMENTATION
#include "test.h"
#include <stdarg.h>

static char *manual; /* the whole text; NULL: it is not there */

static void read_manual(void) {
  FILE *file = fopen("examples/manual.md", "rb");
  long size = 0;

  free(manual);
  manual = NULL;
  if (!file) return;

  if (fseek(file, 0, SEEK_END) == 0) size = ftell(file);
  manual = (char *)calloc((size_t)size + 1, 1);
  if (manual && fseek(file, 0, SEEK_SET) == 0 && fread(manual, 1, (size_t)size, file) != (size_t)size) manual[0] = 0;
  fclose(file);
}

/* Prints a line of an example; the manual must have the same line. */
#if defined(__GNUC__)
__attribute__((format(printf, 1, 2)))
#endif
static void
example(const char *format, ...) {
  char line[160], whole[170];
  va_list list;

  va_start(list, format);
  vsnprintf(line, sizeof line, format, list);
  va_end(list);
  say("%s", line);
  if (!manual) return;

  snprintf(whole, sizeof whole, "\n%s\n", line);
  CHECK(strstr(manual, whole) != NULL, "examples/manual.md has no line \"%s\"", line);
}

/* The ray and the triangle of most examples. The ray's main axis is z, so k, u, v are z, x, y. */
static const float origin[3] = {0.1f, 0.2f, 0.3f}, direction[3] = {0.3f, -0.2f, 1};
static const float corner[3][3] = {{1, -1.5f, 3}, {1.7f, 1.3f, 3.5f}, {-0.6f, 0.4f, 2.9f}};
static const uint32_t axes[3] = {2, 0, 1};

static pk_exact_view view_of(const float o[3], const float d[3], const float p[3][3]) {
  pk_exact_view v;

  pk_exact_view_of(&v, axes, o, d, 1, p[0], 1);
  return v;
}

/* d . (p x q), rounded once: the edge function over d_k, of the corners p and q seen from the origin. */
static double edge_over_dk(const pk_exact_view *v, int p, int q) {
  const pk_exact_vec d = pk_exact_vec_of(v->d);
  const pk_exact_vec a = pk_exact_difference(v->p[p], v->o);
  const pk_exact_vec b = pk_exact_difference(v->p[q], v->o);

  return pk_exact_volume(&d, &a, &b);
}

static float largest(const float x[3]) { return fmaxf(fabsf(x[0]), fmaxf(fabsf(x[1]), fabsf(x[2]))); }

/* The ray and the triangle as the filter sees them: corners sheared in floats, edge functions, and the bound B. */
typedef struct filtered {
  float x[3], y[3], z[3];
  float big_x, big_y, big_z;
  float edge[3], bound;
} filtered;

static filtered filter(void) {
  const float slope_u = direction[0] / direction[2], slope_v = direction[1] / direction[2];
  filtered f;

  for (int c = 0; c < 3; c++) {
    f.z[c] = corner[c][2] - origin[2];
    f.x[c] = (corner[c][0] - origin[0]) - slope_u * f.z[c];
    f.y[c] = (corner[c][1] - origin[1]) - slope_v * f.z[c];
  }
  f.big_x = largest(f.x);
  f.big_y = largest(f.y);
  f.big_z = largest(f.z);

  f.edge[0] = f.x[2] * f.y[1] - f.y[2] * f.x[1];
  f.edge[1] = f.x[0] * f.y[2] - f.y[0] * f.x[2];
  f.edge[2] = f.x[1] * f.y[0] - f.y[1] * f.x[0];
  f.bound = (f.big_z * PK_PAD_SHEAR) * ((f.big_x + f.big_y) + f.big_z * PK_PAD_SHEAR2) +
            ((f.big_x * f.big_y) * PK_PAD_CROSS + PK_PAD_LEAST);
  return f;
}

/* Two triangles share a diagonal, through which the ray passes. */
static void a_shared_edge(void) {
  static const float square[4][3] = {{-1, -1, 2}, {1, -1, 2}, {1, 1, 2}, {-1, 1, 2}};
  static const int index[2][3] = {{0, 1, 2}, {0, 2, 3}};
  static const float o[3] = {0, 0, 0}, d[3] = {0, 0, 1};
  int hits = 0;

  for (int t = 0; t < 2; t++) {
    float p[3][3];
    double tie = 0;

    for (int c = 0; c < 3; c++) memcpy(p[c], square[index[t][c]], sizeof p[c]);
    const pk_exact_view v = view_of(o, d, (const float(*)[3])p);
    const pk_exact_edges e = pk_exact_edge_functions(&v);

    /* U is that of the edge from corner 2 to corner 1, V of 0 to 2, W of 1 to 0. */
    if (e.u == 0) tie = pk_exact_tie_sign(v.d, v.p[2], v.p[1], 1);
    if (e.v == 0) tie = pk_exact_tie_sign(v.d, v.p[0], v.p[2], 1);
    if (e.w == 0) tie = pk_exact_tie_sign(v.d, v.p[1], v.p[0], 1);

    const bool hit = pk_exact_decide(&v, &e, fmin(e.u, fmin(e.v, e.w)) < -e.error, fmax(e.u, fmax(e.v, e.w)) > e.error);
    example("triangle %d: U = %g, V = %g, W = %g; the 0 counts as %+g; %s", t, e.u + 0, e.v + 0, e.w + 0, tie,
        hit ? "a hit" : "no hit");
    hits += hit;
  }
  CHECK(hits == 1, "%d hits", hits);
}

/* The edge function W of the filter, and of doubles, beside the exact one. */
static void the_filter_and_doubles(void) {
  const pk_exact_view v = view_of(origin, direction, corner);
  const pk_exact_edges e = pk_exact_edge_functions(&v);
  const filtered f = filter();
  const double volume = edge_over_dk(&v, 1, 0), dk = (double)direction[2];
  const double error = fabs((double)f.edge[2] - volume / dk);

  example("X = %.4f, Y = %.4f, Z = %.4f", (double)f.big_x, (double)f.big_y, (double)f.big_z);
  example("20.25 eps X Y = %.1e, 8.25 eps Z (X + Y) = %.1e", (double)(PK_PAD_CROSS * f.big_x * f.big_y),
      (double)(PK_PAD_SHEAR * f.big_z * (f.big_x + f.big_y)));
  example("W in floats: %.9f, exactly: %.9f", (double)f.edge[2], volume / dk);
  example("error: %.1e, B: %.1e", error, (double)f.bound);
  CHECK(error < (double)f.bound);

  example("16 h X Y = %.1e, 8 h Z (X + Y) = %.1e", 16 * PK_EPS2 * (double)(f.big_x * f.big_y),
      8 * PK_EPS2 * (double)(f.big_z * (f.big_x + f.big_y)));
  example("B of doubles: %.1e, D: %.4f", e.error, e.det);
  example("B / |D| = %.1e; for u and v it must be below %.1e", e.error / fabs(e.det), PK_ACCURATE_UV);
  CHECK(fabs(e.w - volume * dk) <= e.error && e.error < PK_ACCURATE_UV * fabs(e.det));
}

/* Differences and products as sums of two doubles. */
static void exact_sums(void) {
  const double big = 1, tiny = 0x1p-60;
  const double difference = big - tiny, tail = pk_tail_of_difference(big, tiny, difference);
  const double product = (double)0.1f * (double)0.1f, low = pk_tail_of_product((double)0.1f, (double)0.1f, product);
  const double third = 1.0 / 3, square = third * third, lost = pk_tail_of_product(third, third, square);

  example("1 - 2^-60 = %g + (%.4g)", difference, tail);
  example("fl(0.1)^2, of floats: %.17g + (%g)", product, low + 0);
  example("fl(1/3)^2, of doubles: %.17g + (%.4g)", square, lost);
  CHECK(difference == 1 && tail == -tiny && low == 0 && lost != 0);
}

/* The estimated depth of a hit and its bound, beside the exact depth. */
static void the_depth(void) {
  const pk_exact_view v = view_of(origin, direction, corner);
  const filtered f = filter();
  const float det = (f.edge[0] + f.edge[1]) + f.edge[2], r = 1 / det;
  const float depth = (f.edge[0] * r) * f.z[0] + ((f.edge[1] * r) * f.z[1] + (f.edge[2] * r) * f.z[2]);
  const float range = fmaxf(f.z[0], fmaxf(f.z[1], f.z[2])) - fminf(f.z[0], fminf(f.z[1], f.z[2]));
  const float by_edges = f.bound * range / fabsf(det), by_roundings = PK_PAD_ESTIMATE * f.big_z;
  const float bound = by_edges + (by_roundings + pk_depth_tiny(fabsf(direction[2])));
  float t[3];

  pk_exact_solve(&v, t);
  example("estimate: %.7f, exact depth as a float: %.7f", (double)depth, (double)t[0]);
  example("B R / |D|: %.1e, 16 eps Z: %.1e, bound: %.1e", (double)by_edges, (double)by_roundings, (double)bound);
  CHECK(fabsf(depth - t[0]) <= bound && PK_LEAST_DET * f.bound < fabsf(det));
}

/* The slack of slabs, planes of frusta and moving triangles: a room of ten metres, seen from (4, 1.7, 3). */
static void the_slack(void) {
  const float m = 7, o = 4, rho = 0.5f;
  const float d = m * PK_PAD_M + o * PK_PAD_O + PK_PAD_MIN;
  const float size = 2 * m, moving = 4 * d * (size + size + 2 * d) + PK_PAD_MOVING * size * size + PK_PAD_LEAST;

  example("16 eps M = %.2e, 8 eps |o| = %.2e", (double)(m * PK_PAD_M), (double)(o * PK_PAD_O));
  example("M = %g, |o| = %g: D = %.2e", (double)m, (double)o, (double)d);
  example("rho = %g: planes move by %.2e", (double)rho, (double)(d + PK_PAD_RHO * rho));
  example("X = Y = %g: B of moving triangles = %.2e", (double)size, (double)moving);
  example("t |d_k| = 10: depth_hi = 10 + %.2e", (double)(10 * PK_PAD_DEPTH + pk_depth_tiny(1)));

  /* A slab as kernels evaluate it, beside the exact plane: entry of the ray at x = 10. */
  const float at = 10, start = 4, slope = 0.7f, inverse = 1 / slope, shift = start * inverse + d * fabsf(inverse);
  const double want = ((double)at - (double)start) / (double)slope, without = (double)(at * inverse - start * inverse);

  example("entry without D: %.7f, with D: %.7f, exactly: %.7f", without, (double)(at * inverse - shift), want);
  CHECK((double)(at * inverse - shift) <= want);
}

/* The interval in which a packet of the paper's path enters the plane x = 10 of the same room, and its two extreme rays. */
static void the_intervals(void) {
  const float m = 7, o = 4.1f, plane = 10;
  const float d = m * PK_PAD_M + o * PK_PAD_O + PK_PAD_MIN;
  const float origins[2] = {3.9f, 4.1f}, slopes[2] = {0.6f, 0.7f};
  const float first = (plane - origins[1] - d) * (1 / slopes[1]), last = (plane - origins[0] + d) * (1 / slopes[0]);
  const double rays[2] = {((double)plane - (double)origins[1]) / (double)slopes[1],
      ((double)plane - (double)origins[0]) / (double)slopes[0]};

  example("interval: %.6f to %.6f", (double)first, (double)last);
  example("extreme rays: %.6f and %.6f", rays[0], rays[1]);
  CHECK((double)first <= rays[0] && rays[1] <= (double)last);
}

/* A ray that leaves the corner of a room. */
static void a_corner(void) {
  float p[3][3] = {{2, 2, 1.5f}, {2, -2, 1.5f}, {2, 2, -1.5f}}; /* half of the wall x = 2 */
  const double sides = 4 + 3 + 5, radius = 4 * 3 / sides;       /* of this right triangle */
  const pktrt_ray ray = ray_of(0, 0, 0, 1, 0, 0);
  const double weights[2] = {0, 0};
  pk_spawn_point x;
  pktrt_hit hit;
  double at[3], seen[3][3], uv[2] = {0, 0};

  memset(&hit, 0, sizeof hit);
  pk_spawn_find(p, &ray, &hit, weights, &x);
  memcpy(at, x.at, sizeof at);

  const double size = pk_spawn_corners(p, NULL, at, &x, seen);
  const double wanted = PK_EDGE_OFFSET * x.offset + PK_EDGE_SIZE * size + PK_EDGE_LEAST * sides;

  example("eps |n_x q_x| = %.4g, B = %.2g, h = %.4g", (double)PK_EPS * at[0], PK_ERROR_LEAST * size, x.offset);
  example("S = %g, D = 10 h + 24 eps S + 2^-40 C = %.3g", size, wanted);
  example("R = %g: q moves by D / R = %.3g of the way to the middle", radius, wanted / radius);

  /* The library moves the corner by the same part: to the weights of the middle, times that. */
  CHECK(pk_spawn_near_edge(seen, 1, size, &x, uv), "the corner does not move");
  CHECK(fabs(uv[0] * sides / 3 - wanted / radius) < 1e-3 * wanted, "u moves by %g", uv[0]);
  CHECK(fabs(uv[1] * sides / 4 - wanted / radius) < 1e-3 * wanted, "v moves by %g", uv[1]);
}

void suite_manual(void) {
  read_manual();
  if (!manual) say("there is no examples/manual.md in this folder: its numbers are not compared");
  run("a shared edge: one of two triangles is hit, as the manual says", a_shared_edge);
  run("edge functions err as in the manual's examples of filter and doubles", the_filter_and_doubles);
  run("sums without rounding are those of the manual's example", exact_sums);
  run("depths are bounded as in the manual's example", the_depth);
  run("boxes, frusta, moving triangles: the slack of the manual's example", the_slack);
  run("intervals hold their rays as in the manual's example", the_intervals);
  run("a ray leaves a corner as in the manual's example", a_corner);
  free(manual);
  manual = NULL;
}
