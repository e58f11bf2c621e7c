/* Every part of the slack of >>exactness is needed, or stays far from being used up. Rays are sought, from a seed, that
   come near a bound: the library must answer each as the reference does, and a copy of it with less of that one part
   must not. */
#include "noslack.h"
#include <stddef.h>

/* --- one triangle, and rays that graze it or its box --- */

enum { RAYS = 64 };
typedef struct graze {
  world w;
  float corner[18]; /* three, at one key or two */
  uint32_t index[3];
  pktrt_ray ray[RAYS];
  pktrt_hit want[RAYS];
  uint32_t axis[3]; /* k, u, v */
} graze;
typedef void make_graze(rng *, graze *);

static float either(rng *r, float x) { return rng_below(r, 2) ? x : -x; }
static float jog(rng *r, float x, uint32_t most) { /* a few floats up or down */
  const float to = either(r, INFINITY);
  for (uint32_t i = rng_below(r, most + 1); i; i--) x = nextafterf(x, to);
  return x;
}

static void start(rng *r, graze *g, uint32_t keys) {
  memset(g, 0, sizeof *g);
  g->w = world_none();
  g->w.n = 1;
  g->w.m[0].p = g->corner, g->w.m[0].i = g->index;
  g->w.m[0].nv = 3, g->w.m[0].nt = 1, g->w.m[0].keys = keys;
  g->axis[0] = rng_below(r, 3), g->axis[1] = (g->axis[0] + 1) % 3, g->axis[2] = (g->axis[0] + 2) % 3;
  for (uint32_t c = 0; c < 3; c++) g->index[c] = c;
  for (uint32_t i = 0; i < RAYS; i++) g->ray[i] = ray_of(0, 0, 0, 0, 0, 0);
}
static void set(const graze *g, float p[3], float u, float v, float k) {
  p[g->axis[1]] = u, p[g->axis[2]] = v, p[g->axis[0]] = k;
}

/* Boxes. A side of the triangle is an edge of its box, which rays pass as they pass the side: there the slabs of two
   axes are short by what is rounded. Origins are small: what they add to the slack would hide that of M. */
static void graze_box(rng *r, graze *g, uint32_t keys, float scale) {
  start(r, g, keys);
  const float su = either(r, 1), sv = either(r, 1), sk = either(r, 1);
  for (uint32_t key = 0; key < keys; key++) {
    const float a = rng_range(r, 1, 1.1f), b = rng_range(r, 1, 1.1f), k = rng_range(r, 1.1f, 1.3f);
    float *p = g->corner + 9 * key;
    set(g, p, su * scale * a, sv * scale * b, sk * scale * k);
    set(g, p + 3, su * scale * a, sv * scale * b, sk * scale * rng_range(r, 1.1f, k));
    set(g, p + 6, su * scale * (a - rng_unit(r)), sv * scale * (b + rng_unit(r)), sk * scale * k);
  }
  for (uint32_t i = 0; i < RAYS; i++) {
    pktrt_ray *x = &g->ray[i];
    float p[3][3], length = rng_range(r, 1, 2), part = rng_unit(r);
    x->time = rng_unit(r);
    for (uint32_t c = 0; c < 2; c++) ref_vertex(&g->w.m[0], c, x->time, p[c]);
    for (int a = 0; a < 3; a++) {
      x->origin[a] = scale * 0.03f * rng_sign(r);
      x->direction[a] = (p[0][a] + part * (p[1][a] - p[0][a]) - x->origin[a]) / scale;
    }
    length /= fabsf(x->direction[g->axis[0]]);
    for (int a = 0; a < 3; a++) x->direction[a] = jog(r, length * x->direction[a], 4);
  }
}
static void graze_box_moving(rng *r, graze *g) { graze_box(r, g, 2, 1); }
static void graze_box_tiny(rng *r, graze *g) { graze_box(r, g, 1, 0x1p-133f); }

/* A ray at that edge, near a corner of it. */
typedef struct climber {
  float corner[3], o[3], d[3]; /* by u, v, k */
  bool fused;                  /* as single rays are culled with AVX2; not: as on the paper path */
} climber;

/* How much earlier it leaves the slab of u than it enters that of v, each widened by the slack of o alone, if it hits the
   triangle's side, which ends at LOWER of the corner's depth. */
#define LOWER 0.8f
static float shortage(const climber *x) {
  const float dk = x->d[2], ends[2] = {x->corner[2], LOWER * x->corner[2]};
  const float pad = 0x1p-24f * (8 * fmaxf(fabsf(x->o[0]), fmaxf(fabsf(x->o[1]), fabsf(x->o[2]))));
  float at[2];
  double seen[2][2];
  for (int a = 0; a < 2; a++) {
    const float back = fabsf(dk) / x->d[a], c = x->o[a] * back, wide = pad * back;
    const float plane = x->corner[a] * back, begin = a ? c + wide : c - wide;
    for (int end = 0; end < 2; end++)
      seen[end][a] = ((double)x->corner[a] - (double)x->o[a]) * (double)dk -
                     (double)x->d[a] * ((double)ends[end] - (double)x->o[2]);
    at[a] = x->fused ? fmaf(x->corner[a], back, -begin) : plane - begin;
  }
  const double side = seen[0][0] * seen[1][1] - seen[0][1] * seen[1][0];
  return side < 0 ? 1000 * (float)side - 0.001f : at[1] - at[0];
}

static void aim(climber *x, float length) { /* a little before the corner */
  for (int a = 0; a < 3; a++) x->d[a] = length * (a < 2 ? x->corner[a] - x->o[a] : 0.98f * x->corner[2] - x->o[2]);
}

/* Moves a corner, and the ray at it, or the ray alone by little; not so far that M becomes another. */
static bool nudge(rng *r, climber *x) {
  float *value[3] = {x->corner, x->o, x->d}, *one = value[rng_below(r, 3)] + rng_below(r, 3);
  switch (rng_below(r, 3)) {
  case 0: *one = jog(r, *one, 2); break;
  case 1: *one *= 1 + 1e-6f * rng_sign(r); break;
  default:
    if (rng_below(r, 2)) x->corner[rng_below(r, 3)] *= 1 + 0.01f * rng_sign(r);
    aim(x, x->d[2] / x->corner[2] * (1 + 0.01f * rng_sign(r)));
  }
  for (int a = 0; a < 3; a++)
    if (!(fabsf(x->o[a]) < 0.02f)) return false;
  return x->corner[0] >= 1 && x->corner[0] < 1.1f && x->corner[1] >= 1 && x->corner[1] < 1.1f && x->corner[2] > 1.18f &&
         x->corner[2] < 1.3f;
}

static climber climb(rng *r) {
  climber best = {
      {rng_range(r, 1, 1.1f), rng_range(r, 1, 1.1f), rng_range(r, 1.18f, 1.3f)}, {0, 0, 0}, {0, 0, 0}, rng_below(r, 2)};
  for (int a = 0; a < 3; a++) best.o[a] = 0.02f * rng_sign(r);
  aim(&best, rng_range(r, 1, 2));
  float most = shortage(&best);
  for (int step = 0; step < 5000; step++) {
    climber x = best;
    bool ok = true;
    for (uint32_t times = 1 + rng_below(r, 3); times; times--) ok = ok && nudge(r, &x);
    const float need = shortage(&x);
    if (ok && need >= most) most = need, best = x;
  }
  return best;
}

/* The same at rest, with a corner and a ray that were moved about until more slack is needed. The others are like
   it. */
static void graze_box_closely(rng *r, graze *g) {
  const float su = either(r, 1), sv = either(r, 1), sk = either(r, 1);
  const climber x = climb(r);
  const float u = su * x.corner[0], v = sv * x.corner[1], k = sk * x.corner[2];
  start(r, g, 1);
  set(g, g->corner, u, v, k);
  set(g, g->corner + 3, u, v, LOWER * k);
  set(g, g->corner + 6, 0.7f * u, 1.05f * v, 0.9f * k);
  for (uint32_t i = 0; i < RAYS; i++) {
    set(g, g->ray[i].origin, su * x.o[0], sv * x.o[1], sk * x.o[2]);
    set(g, g->ray[i].direction, su * x.d[0], sv * x.d[1], sk * x.d[2]);
    if (i) g->ray[i].origin[i % 3] = jog(r, g->ray[i].origin[i % 3], 3);
  }
}

/* Depths. Each ray looks again with room for nothing but the hit, or with none for it. */
static void look_again(graze *g) {
  for (uint32_t i = 0; i < RAYS; i += 4) {
    pktrt_hit h;
    for (uint32_t j = 1; j < 4; j++) g->ray[i + j] = g->ray[i];
    ref_intersect(&g->w, &g->ray[i], &h);
    g->ray[i].tmax = h.t;
    g->ray[i + 1].tmax = nextafterf(h.t, INFINITY);
    g->ray[i + 2].tmin = h.t;
    g->ray[i + 3].tmin = nextafterf(h.t, -INFINITY);
  }
}

/* Corners p + (x, y, z) as rays from the origin with these slopes see them. */
static void set_seen(graze *g, uint32_t c, float x, float y, float z, const float slope[2]) {
  set(g, g->corner + 3 * c, x + slope[0] * z, y + slope[1] * z, z);
}

/* By how much the depth that single precision estimates is wrong, in units of eps X Y R / |D|; 0 if the ray misses. */
static float misjudged(const graze *g, const pktrt_ray *ray) {
  const float *d = ray->direction, *o = ray->origin, dk = d[g->axis[0]];
  float x[3], y[3], z[3], e[3], sum = 0, det = 0;
  double exact[3], depth = 0, all = 0;
  for (int c = 0; c < 3; c++) {
    const float *p = g->corner + 3 * c;
    z[c] = p[g->axis[0]] - o[g->axis[0]];
    const float su = d[g->axis[1]] / dk * z[c], sv = d[g->axis[2]] / dk * z[c];
    x[c] = (p[g->axis[1]] - o[g->axis[1]]) - su, y[c] = (p[g->axis[2]] - o[g->axis[2]]) - sv;
  }
  for (int c = 0; c < 3; c++) {
    const int i = (c + 2) % 3, j = (c + 1) % 3;
    const float one = x[i] * y[j], other = y[i] * x[j];
    e[c] = one - other, exact[c] = (double)x[i] * (double)y[j] - (double)y[i] * (double)x[j];
    det += e[c], all += exact[c], depth += exact[c] * (double)z[c];
  }
  for (int c = 0; c < 3; c++)
    if (exact[c] * all < 0) return 0;
  for (int c = 0; c < 3; c++) sum = fmaf(e[c] / det, z[c], sum);
  const float xs = fmaxf(fabsf(x[0]), fmaxf(fabsf(x[1]), fabsf(x[2])));
  const float ys = fmaxf(fabsf(y[0]), fmaxf(fabsf(y[1]), fabsf(y[2])));
  const float range = fmaxf(z[0], fmaxf(z[1], z[2])) - fminf(z[0], fminf(z[1], z[2]));
  return (float)fabs((double)sum - depth / all) * fabsf(det) / (0x1p-24f * xs * ys * range);
}

/* Seen nearly edge-on: large in x, y and z, with little area. Of 60 rays each time that which is misjudged most. */
static void edge_on(rng *r, graze *g) {
  start(r, g, 1);
  const float thin = powf(10, rng_range(r, -4, -1)), slope[2] = {rng_sign(r), rng_sign(r)};
  const float turn = (float)rng_below(r, 2) * 1.5707964f + rng_range(r, 0.6f, 1);
  float x[3], y[3], l[3], sum = 0, mx = 0, my = 0;
  for (int c = 0; c < 3; c++) {
    const float along = c == 2 ? rng_sign(r)
                        : c    ? -rng_range(r, 0.7f, 1)
                               : rng_range(r, 0.7f, 1),
                across = thin * rng_sign(r);
    x[c] = cosf(turn) * along - sinf(turn) * across, y[c] = sinf(turn) * along + cosf(turn) * across;
    sum += l[c] = 0.05f + rng_unit(r);
  }
  for (int c = 0; c < 3; c++) mx += x[c] * l[c] / sum, my += y[c] * l[c] / sum;
  for (uint32_t c = 0; c < 3; c++) set_seen(g, c, x[c] - mx, y[c] - my, rng_range(r, 1, 3), slope);
  for (uint32_t i = 0; i < RAYS; i += 4) {
    float most = -1;
    for (int n = 0; n < 60; n++) {
      pktrt_ray ray = g->ray[i];
      set(g, ray.direction, jog(r, slope[0], 9), jog(r, slope[1], 9), 1);
      for (int a = 0; a < 3; a++) ray.origin[a] = thin * 0.01f * rng_sign(r);
      const float wrong = misjudged(g, &ray);
      if (wrong > most) most = wrong, g->ray[i] = ray;
    }
  }
  look_again(g);
}

/* The t of a triangle by the doubles of >>exactness, whether they suffice or not. */
static float t_by_doubles(const graze *g, const pktrt_ray *ray) {
  const float *d = ray->direction, *o = ray->origin;
  const double dk = (double)d[g->axis[0]], du = (double)d[g->axis[1]], dv = (double)d[g->axis[2]];
  double x[3], y[3], z[3];
  for (int c = 0; c < 3; c++) {
    const float *p = g->corner + 3 * c;
    z[c] = (double)p[g->axis[0]] - (double)o[g->axis[0]];
    x[c] = ((double)p[g->axis[1]] - (double)o[g->axis[1]]) * dk - du * z[c];
    y[c] = ((double)p[g->axis[2]] - (double)o[g->axis[2]]) * dk - dv * z[c];
  }
  const double u = x[2] * y[1] - y[2] * x[1], v = x[0] * y[2] - y[0] * x[2], w = x[1] * y[0] - y[1] * x[0];
  return (float)(((u * z[0] + v * z[1]) + w * z[2]) * (1 / (((u + v) + w) * dk)));
}

/* Seen end-on: a needle along rays, as thin as what is rounded, which they hit nearer than their depth is certain. Of some
   rays each time one whose t doubles get wrong. */
static void end_on(rng *r, graze *g) {
  start(r, g, 1);
  const float slope[2] = {rng_sign(r), rng_sign(r)}, thin = powf(10, rng_range(r, -5.3f, -4.5f));
  const float turn = 7 * rng_unit(r), ends[3] = {rng_range(r, -1, -0.2f), rng_range(r, -1, 1), rng_range(r, 0.2f, 1)};
  float x[3], y[3];
  for (uint32_t c = 0; c < 3; c++) {
    const float angle = turn + 2.0943951f * (float)c + 0.5f * rng_sign(r);
    x[c] = thin * cosf(angle), y[c] = thin * sinf(angle);
    set_seen(g, c, x[c], y[c], ends[c], slope);
  }
  const float uncertain = (ends[2] - ends[0]) * 0x1p-24f * 6.4f / thin;
  for (uint32_t i = 0; i < RAYS; i++) {
    pktrt_ray *ray = &g->ray[i];
    pktrt_hit hit;
    set(g, ray->direction, slope[0], slope[1], 1);
    for (int n = 0; n < 100; n++) { /* from about 0: differences of floats that are alike are exact in doubles */
      const float p = rng_unit(r), deep = rng_range(r, 0.01f, 0.3f) * uncertain;
      const float q = ((1 - p) * ends[2] + p * ends[0] - deep) / (ends[2] - ends[1]), s = 1 - p - q;
      set(g, ray->origin, p * x[0] + q * x[1] + s * x[2], p * y[0] + q * y[1] + s * y[2], thin * rng_sign(r));
      if (ref_intersect(&g->w, ray, &hit) && (hit.t < t_by_doubles(g, ray) || hit.t > t_by_doubles(g, ray))) break;
    }
  }
}

/* Rays at a side of a triangle of so large x, y and z, in their frame. */
static void at_an_edge(rng *r, graze *g, float across, float deep, float unit) {
  start(r, g, 1);
  for (uint32_t c = 0; c < 3; c++)
    set(g, g->corner + 3 * c, unit * across * rng_sign(r), unit * across * rng_sign(r),
        unit * deep * 0.1f * rng_sign(r));
  for (uint32_t i = 0; i < RAYS; i++) {
    const float *p = g->corner, *q = p + 3, part = rng_unit(r), k = either(r, 1);
    pktrt_ray *ray = &g->ray[i];
    set(g, ray->direction, k * rng_sign(r), k * rng_sign(r), k);
    for (int a = 0; a < 3; a++)
      ray->origin[a] = jog(r, p[a] + part * (q[a] - p[a]) - unit * deep * ray->direction[a], 3);
  }
}
static void at_a_wide_edge(rng *r, graze *g) { at_an_edge(r, g, 1, 1e-3f, 1); }
static void at_a_far_edge(rng *r, graze *g) { at_an_edge(r, g, 1e-3f, 1, 1); }
static void at_a_tiny_edge(rng *r, graze *g) { at_an_edge(r, g, 1, 1e-3f, ldexpf(1, -64 - (int)rng_below(r, 4))); }

/* So near that depths, or what becomes of them along a long direction, are denormal. */
static void denormal_depth(rng *r, graze *g) {
  start(r, g, 1);
  const bool deep = rng_below(r, 2);
  const float slope[2] = {0, 0}, unit = deep ? ldexpf(1, -84) : ldexpf(1, -144);
  for (uint32_t c = 0; c < 3; c++)
    set_seen(g, c, c == 1 ? 2 : -1 + 0.3f * rng_unit(r), c == 2 ? 2 : -1 + 0.3f * rng_unit(r),
        unit * rng_range(r, 1, 9), slope);
  for (uint32_t i = 0; i < RAYS; i += 4) {
    const float length = rng_range(r, 1, 2) * (deep ? ldexpf(1, 60) : 1);
    set(g, g->ray[i].direction, rng_sign(r) * length, rng_sign(r) * length, length);
  }
  look_again(g);
}

/* Sides. Rays of one origin all about an axis. The first leans more to one side of the triangle than all others, so
   that it alone can hit it. */
static void at_a_side(rng *r, graze *g) {
  start(r, g, 1);
  const float lean = powf(10, rng_range(r, -4, -2)), angle = 7 * rng_unit(r), x = cosf(angle), y = sinf(angle);
  const float slope[2] = {y < 0 ? lean : -lean, x > 0 ? lean : -lean}, s = rng_range(r, 0.2f, 1),
              t = rng_range(r, 0.2f, 1);
  const float k = either(r, 1);
  float o[3];
  for (int a = 0; a < 3; a++) o[a] = rng_sign(r);
  set_seen(g, 0, s * x, s * y, k * rng_range(r, 0.6f, 1), slope);
  set_seen(g, 1, -t * x, -t * y, k * rng_range(r, 0.6f, 1), slope);
  set_seen(g, 2, -y * s, x * s, k * rng_range(r, 0.6f, 1), slope);
  for (int c = 0; c < 9; c++) g->corner[c] += o[c % 3];
  for (uint32_t i = 0; i < RAYS; i++) {
    const float part = i ? rng_range(r, -1, 0.99f) : 1, other = i ? rng_range(r, -1, 0.99f) : 1;
    memcpy(g->ray[i].origin, o, sizeof o);
    set(g, g->ray[i].direction, k * part * slope[0], k * other * slope[1], k);
  }
}

/* Sides near where rays end together, or nearly, as those to a light do; the first alone can hit the triangle. */
static void in_a_cone(rng *r, graze *g) {
  start(r, g, 1);
  const float lean = powf(10, rng_range(r, -3, -1)), angle = 7 * rng_unit(r), x = cosf(angle), y = sinf(angle);
  const float least[2] = {either(r, 0.3f), either(r, 0.3f)}, s = rng_range(r, 0.02f, 0.1f), k = either(r, 1);
  const float swing[2] = {y < 0 ? -lean : lean, x > 0 ? -lean : lean};
  const float slope[2] = {k * (least[0] + swing[0]), k * (least[1] + swing[1])};
  float to[3], aside[3] = {0, 0, 0};
  for (int a = 0; a < 3; a++) to[a] = rng_sign(r);
  set_seen(g, 0, s * x, s * y, -k * rng_range(r, 0.02f, 0.1f), slope);
  set_seen(g, 1, -s * x, -s * y, -k * rng_range(r, 0.02f, 0.1f), slope);
  set_seen(g, 2, -y * s, x * s, -k * rng_range(r, 0.02f, 0.1f), slope);
  for (int c = 0; c < 9; c++) g->corner[c] += to[c % 3];
  for (uint32_t i = 0; i < RAYS; i++) {
    const float part = i ? rng_range(r, -1, 0.99f) : 1, other = i ? rng_range(r, -1, 0.99f) : 1;
    const float miss = i % 2 ? lean * 1e-3f * rng_unit(r) : 0;
    pktrt_ray *ray = &g->ray[i];
    set(g, ray->direction, least[0] + part * swing[0], least[1] + other * swing[1], k);
    set(g, aside, miss * y, -miss * x, 0);
    for (int a = 0; a < 3; a++) ray->origin[a] = to[a] + aside[a] - ray->direction[a];
    ray->tmax = 1;
  }
}

/* Planes. Parallel rays of many origins, the first of which is the outermost one all the way: it grazes a side of the
   triangle, which lies beyond all others, at their common time. */
static void at_a_plane(rng *r, graze *g, uint32_t keys) {
  start(r, g, keys);
  const float spread = powf(10, rng_range(r, -2, 0.5f)), outwards = either(r, 1), k = either(r, 1), time = rng_unit(r);
  const float depth = rng_below(r, 2) ? rng_range(r, 1, 1.3f) : powf(10, rng_range(r, -2, 0));
  const float slope = rng_range(r, 0.5f, 1);
  float p[3], to[3];
  for (uint32_t key = 0; key < keys; key++) {
    for (int a = 0; a < 3; a++) p[a] = rng_below(r, 2) ? 0.05f * rng_sign(r) : rng_sign(r);
    for (uint32_t c = 0; c < 3; c++) {
      float *corner = g->corner + 9 * key + 3 * c;
      set(g, corner, c == 2 ? outwards : 0, (float)c - 0.5f, 0);
      for (int a = 0; a < 3; a++) corner[a] += p[a];
    }
  }
  ref_vertex(&g->w.m[0], 0, time, p);
  p[g->axis[2]] += 0.5f; /* the middle of the side */
  set(g, to, either(r, slope) * depth, 0.1f * rng_sign(r) * depth, k * depth);
  for (int a = 0; a < 3; a++) g->ray[0].origin[a] = p[a] - to[a], g->ray[0].direction[a] = jog(r, to[a], 3);
  g->ray[0].time = time;
  for (uint32_t i = 1; i < RAYS; i++) {
    const float along = rng_below(r, 2) ? rng_range(r, -1, 1) : 0;
    float aside[3];
    g->ray[i] = g->ray[0];
    set(g, aside, -outwards * spread * rng_unit(r), spread * rng_sign(r), 0);
    for (int a = 0; a < 3; a++) g->ray[i].origin[a] += aside[a] + along * to[a];
  }
}

/* Edges that doubles are too coarse for. All rays of a packet go through one point of an edge, exactly: its ends are that
   point and as much on either side, in steps so fine that their differences from origins fill doubles. */
static void through_an_edge(rng *r, graze *g) {
  start(r, g, 1);
  const float su = either(r, 1), sv = either(r, 1), k = either(r, 1);
  float middle[3];

  for (int a = 0; a < 3; a++) {
    const float half = 0x1p-36f * (float)(1 + rng_below(r, 1 << 20));

    middle[a] = either(r, 0x1p-24f) * (float)rng_below(r, 1 << 10);
    g->corner[a] = middle[a] - half;
    g->corner[3 + a] = middle[a] + half;
    g->corner[6 + a] = either(r, 0x1p-36f) * (float)(1 + rng_below(r, 1 << 20));
  }

  for (uint32_t i = 0; i < RAYS; i++) {
    pktrt_ray *ray = &g->ray[i];

    set(g, ray->direction, su * rng_range(r, 0.25f, 0.3f), sv * rng_range(r, 0.25f, 0.3f),
        k * rng_range(r, 0.5f, 0.7f));
    for (int a = 0; a < 3; a++) {
      ray->direction[a] = roundf(ray->direction[a] * 0x1p24f) * 0x1p-24f;
      ray->origin[a] = middle[a] - ray->direction[a];
    }
  }
}

/* Planes of departure. Rays begin next to a point that lies in the plane of the triangle, exactly, by less than doubles
   tell at such a plane: half of them before it. */
static void at_departure(rng *r, graze *g) {
  start(r, g, 1);
  const uint32_t fine = rng_below(r, 3); /* the axis along which the point is at 0 */
  const float su = either(r, 1), sv = either(r, 1), k = either(r, 1);
  float middle[3], way[2][3];

  for (int a = 0; a < 3; a++) {
    middle[a] = a == (int)fine ? 0 : 0x1p-24f * (float)rng_below(r, 1 << 10);
    for (int i = 0; i < 2; i++) way[i][a] = either(r, 0x1p-36f) * (float)(1 + rng_below(r, 1 << 19));
    g->corner[a] = middle[a] + way[0][a];
    g->corner[3 + a] = middle[a] + way[1][a];
    g->corner[6 + a] = middle[a] - (way[0][a] + way[1][a]);
  }

  for (uint32_t i = 0; i < RAYS; i++) {
    pktrt_ray *ray = &g->ray[i];

    memcpy(ray->origin, middle, sizeof middle);
    ray->origin[fine] = ldexpf(i % 2 ? 1 : -1, -60 - (int)rng_below(r, 12));
    set(g, ray->direction, su * rng_range(r, 0.3f, 0.5f), sv * rng_range(r, 0.3f, 0.5f), k);
  }
}

/* The paper path's planes and intervals. Rays of one origin at a side of a triangle that is the far edge of its box. The
   last of them alone comes so far to this side. */
static void at_a_far_side(rng *r, graze *g) {
  start(r, g, 1);
  const bool swap = rng_below(r, 2);
  const float su = either(r, 1), sk = either(r, 1), near_ = rng_range(r, 1, 2), far_ = near_ + rng_range(r, 0.1f, 1);
  const float at = rng_range(r, 0.3f, 0.9f) * far_;
  float o[3];

  for (int a = 0; a < 3; a++) o[a] = 0.03f * rng_sign(r);
  for (uint32_t c = 0; c < 3; c++) {
    const float u = su * (c == 2 ? at + 1 : at);
    const float v = c == 2 ? 0.1f : 0.8f * (float)c;

    set(g, g->corner + 3 * c, swap ? v : u, swap ? u : v, sk * (c == 2 ? near_ : far_));
  }
  for (uint32_t i = 0; i < RAYS; i++) {
    const bool last = i == RAYS - 1;
    const float u = su * (last ? at : at * rng_unit(r));
    const float v = rng_range(r, 0.1f, 0.7f);
    pktrt_ray *ray = &g->ray[i];

    memcpy(ray->origin, o, sizeof o);
    set(g, ray->direction, swap ? v : u, swap ? u : v, sk * far_);
    for (int a = 0; a < 3; a++) ray->direction[a] = jog(r, ray->direction[a] - o[a], last ? 1 : 0);
  }
}

/* Origins. Rays of a packet begin at many depths before the sides of a triangle, and one corner is behind all of them. */
static void among_origins(rng *r, graze *g, uint32_t keys) {
  start(r, g, keys);
  const float across = powf(10, rng_range(r, -4, 0)), deep = powf(10, rng_range(r, -3, 0)), k = either(r, 1);
  const float lean[2] = {either(r, 0.5f), either(r, 0.5f)}, time = rng_unit(r), wide = powf(10, rng_range(r, -3, -1));

  for (uint32_t c = 0; c < 3 * keys; c++) {
    const float z = deep * (c % 3 ? rng_unit(r) : -rng_range(r, 2, 3));

    set(g, g->corner + 3 * c, across * rng_sign(r) + lean[0] * z, across * rng_sign(r) + lean[1] * z, k * z);
  }
  for (uint32_t i = 0; i < RAYS; i++) {
    const float part = 0.4f * rng_unit(r), far_ = 0.4f * deep * rng_unit(r);
    pktrt_ray *ray = &g->ray[i];
    float p[3], q[3];

    ref_vertex(&g->w.m[0], 1 + i % 2, time, p);
    ref_vertex(&g->w.m[0], i % 4 < 2 ? 0 : 2 - i % 2, time, q);
    set(g, ray->direction, lean[0] + wide * rng_sign(r), lean[1] + wide * rng_sign(r), k);
    for (int a = 0; a < 3; a++) ray->origin[a] = jog(r, p[a] + part * (q[a] - p[a]) - far_ * ray->direction[a], 3);
    ray->time = time;
  }
}
static void among_origins_at_rest(rng *r, graze *g) { among_origins(r, g, 1); }
static void among_origins_moving(rng *r, graze *g) { among_origins(r, g, 2); }

/* Beyond all origins, a triangle hardly larger than what is rounded, and rays that hardly spread. */
static void tiny_beyond(rng *r, graze *g, uint32_t keys) {
  start(r, g, keys);
  const float across = powf(10, rng_range(r, -8, -5)), far_ = rng_range(r, 1, 2), k = either(r, 1);
  const float lean[2] = {either(r, 0.5f), either(r, 0.5f)}, time = rng_unit(r);
  const float wide = rng_below(r, 2) ? 0 : powf(10, rng_range(r, -9, -5));

  for (uint32_t c = 0; c < 3 * keys; c++)
    set(g, g->corner + 3 * c, across * rng_sign(r), across * rng_sign(r), 0.1f * across * rng_sign(r));
  for (uint32_t i = 0; i < RAYS; i++) {
    const float part = rng_unit(r);
    pktrt_ray *ray = &g->ray[i];
    float p[3], q[3];

    ref_vertex(&g->w.m[0], i % 3, time, p);
    ref_vertex(&g->w.m[0], (i + 1) % 3, time, q);
    set(g, ray->direction, lean[0] + wide * rng_sign(r), lean[1] + wide * rng_sign(r), k);
    for (int a = 0; a < 3; a++) ray->origin[a] = jog(r, p[a] + part * (q[a] - p[a]) - far_ * ray->direction[a], 3);
    ray->time = time;
  }
}
static void tiny_beyond_at_rest(rng *r, graze *g) { tiny_beyond(r, g, 1); }
static void tiny_beyond_moving(rng *r, graze *g) { tiny_beyond(r, g, 2); }

/* Rays that end soon after they met a side of a triangle, which goes on far behind. */
static void ends_before(rng *r, graze *g) {
  start(r, g, 1);
  const float across = powf(10, rng_range(r, -4, 0)), wide = powf(10, rng_range(r, -3, -0.5f)), k = either(r, 1);
  const float lean[2] = {either(r, 0.3f), either(r, 0.3f)};

  for (uint32_t c = 0; c < 3; c++) {
    const float z = c ? 5 * rng_unit(r) : -0.1f * rng_unit(r);

    set(g, g->corner + 3 * c, across * rng_sign(r) + lean[0] * z, across * rng_sign(r) + lean[1] * z, k * z);
  }
  for (uint32_t i = 0; i < RAYS; i++) {
    const float *p = g->corner, *q = p + 3 * (1 + i % 2), part = 0.1f * rng_unit(r);
    pktrt_ray *ray = &g->ray[i];

    set(g, ray->direction, lean[0] + wide * rng_sign(r), lean[1] + wide * rng_sign(r), k);
    for (int a = 0; a < 3; a++) ray->origin[a] = jog(r, p[a] + part * (q[a] - p[a]) - ray->direction[a], 3);
    ray->tmax = 1.1f;
  }
}

/* --- what the library and the copy answer --- */

typedef enum asked { SINGLE, FAST, PAPER, ASKED } asked;
static const pktrt_path paths[ASKED] = {PKTRT_PATH_SINGLE, PKTRT_PATH_FAST, PKTRT_PATH_PAPER};

/* The rays that one path answers otherwise than the reference. */
static uint64_t lost_by(const graze *g, const pktrt_scene *s, bool copy, asked how) {
  pktrt_hit got[RAYS];
  bool hidden[RAYS];
  pktrt_query_desc q;
  uint64_t lost = 0;
  memset(&q, 0, sizeof q);
  q.path = paths[how];
  (copy ? noslack_intersect : pktrt_intersect_ex)(s, &q, g->ray, got, RAYS);
  (copy ? noslack_occluded : pktrt_occluded_ex)(s, &q, g->ray, hidden, RAYS);
  for (uint32_t i = 0; i < RAYS; i++)
    if (!same_bits(&got[i], &g->want[i], sizeof got[i]) || hidden[i] != (g->want[i].mesh != PKTRT_NONE))
      lost |= (uint64_t)1 << i;
  return lost;
}

static void ask_reference(graze *g) {
  for (uint32_t i = 0; i < RAYS; i++) ref_intersect(&g->w, &g->ray[i], &g->want[i]);
}

/* The library loses none, on an instruction set that the seed chooses. */
static void library_is_right(const char *name, const graze *g, uint64_t seed) {
  pktrt_scene *s = world_scene(&g->w, isas[seed % (uint64_t)isa_count], 0);
  for (int how = 0; how < ASKED; how++) {
    const uint64_t lost = lost_by(g, s, false, (asked)how);
    CHECK(!lost, "%s, triangle %llu: path %d answers rays %llx otherwise than the reference", name,
        (unsigned long long)seed, how, (unsigned long long)lost);
  }
  pktrt_scene_destroy(s);
}

/* --- parts that are needed --- */

typedef struct part {
  const char *name;
  size_t at;      /* in slack_parts */
  float of, left; /* what the constant is a multiple of, and what is left of it */
  make_graze *make;
  uint32_t triangles, fields; /* how many parts in a row */
} part;
#define PART(field) #field, offsetof(slack_parts, field)
static const part parts[] = {
    {PART(m), 16, 0, graze_box_closely, 200, 1},
    {PART(m), 16, 0, graze_box_moving, 200, 1},
    {PART(min), 1, 0, graze_box_tiny, 40, 1},
    {PART(cross), 20.25f, 0, at_a_wide_edge, 200, 1},
    {PART(shear), 8.25f, 0, at_a_far_edge, 200, 1},
    {PART(least), 1, 0, at_a_tiny_edge, 400, 1},
    {"depth", offsetof(slack_parts, cross), 20.25f, 0, edge_on, 400, 5}, /* cross to estimate */
    {PART(tiny), 2, 0, denormal_depth, 40, 1},
    {PART(accurate), 5, 0, end_on, 60, 1},
    {PART(sides), 32, 0, at_a_side, 600, 1},
    {PART(apex), 8, 0, in_a_cone, 600, 1},
    {PART(miss), 8, 0, in_a_cone, 100, 1},
    {PART(many), 2, 0, among_origins_at_rest, 30, 1},
    {PART(many), 2, 0, among_origins_moving, 30, 1},
    {PART(swept), 4, 0, tiny_beyond_moving, 60, 1},
    {PART(doubles), 16, 0, through_an_edge, 600, 1},
    {PART(eights), 16, 0, through_an_edge, 600, 1},
    {PART(misses[0]), 64, 0, at_departure, 60, 1},
    {PART(misses[1]), 64, 0, at_departure, 60, 1},
    {PART(paper), 1, 0, at_a_far_side, 600, 1},
    {PART(interval), 1, 0, at_a_far_side, 600, 1},
};

/* Whether the copy loses a hit with so much of a part. */
static bool copy_loses(const part *p, const graze *g, float left) {
  uint64_t lost = 0;
  slack_left = slack_whole;
  left /= p->of;
  for (uint32_t i = 0; i < p->fields; i++) memcpy((char *)&slack_left + p->at + i * sizeof left, &left, sizeof left);
  pktrt_scene *s = noslack_scene(&g->w, PKTRT_ISA_AUTO);
  if (!CHECK(s != NULL)) return false;
  for (int how = 0; how < ASKED; how++) lost |= lost_by(g, s, true, (asked)how);
  noslack_destroy(s);
  slack_left = slack_none;
  return lost != 0;
}

/* Tells whether the copy finds planes of triangles by eights: AVX2 does. */
static bool has_eight_doubles(void) {
  for (int i = 0; i < isa_count; i++)
    if (isas[i] == PKTRT_ISA_AVX2) return true;
  return false;
}

/* Makes a triangle and rays for the i-th part of a list, asks the reference, and checks that the library answers as it does. */
static void make_for(const part *p, size_t i, uint32_t seed, graze *g) {
  rng r = rng_of(seed + 1000 * i);
  p->make(&r, g);
  ask_reference(g);
  library_is_right(p->name, g, seed);
}

/* Tells whether a part is of frusta, or of what vectors settle by eights: scalar kernels by themselves do without. */
static bool is_of_packets(const part *p) {
  static const size_t at[] = {offsetof(slack_parts, accurate), offsetof(slack_parts, sides),
      offsetof(slack_parts, apex), offsetof(slack_parts, miss), offsetof(slack_parts, many),
      offsetof(slack_parts, swept), offsetof(slack_parts, eights)};
  for (size_t i = 0; i < COUNT(at); i++)
    if (p->at == at[i]) return true;
  return false;
}

static void parts_are_needed(void) {
  for (size_t i = 0; i < COUNT(parts); i++) {
    const part *p = &parts[i];
    uint32_t lose = 0;
    float most = p->left; /* with which a hit was lost */
    if (p->at == offsetof(slack_parts, misses[1]) && !has_eight_doubles()) continue;
    if (is_of_packets(p) && !has_frusta(PKTRT_ISA_AUTO)) continue;
    for (uint32_t seed = 0; seed < p->triangles && !(small_run && lose > 2); seed++) {
      graze g;
      make_for(p, i, seed, &g);
      if (!copy_loses(p, &g, p->left)) continue;
      lose++;
      while (most < p->of && copy_loses(p, &g, most + p->of / 64)) most += p->of / 64;
    }
    CHECK(lose > 0, "%s: without it nothing is lost", p->name);
    say("%-8s of %5.4g, %g are left: %3u of %3u triangles lose hits; the last one with %.2g", p->name, (double)p->of,
        (double)p->left, lose, p->triangles, (double)most);
  }
}

/* --- parts that may be less than nothing, all of them of frusta --- */

/* Where others stand in for a part so well that without it no hit was found that is lost: it takes more than that, a
   correction of the other sign, to lose one. The header says at each why. */
static const part less[] = {
    {PART(far_apex), 16, -64, in_a_cone, 200, 1},
    {PART(cone[0]), 4, -64, in_a_cone, 120, 1},
    {PART(cone[1]), 4, -64, in_a_cone, 120, 1},
    {PART(slope[0]), 4, -4096, in_a_cone, 60, 1},
    {PART(slope[1]), 4, -4096, in_a_cone, 60, 1},
    {PART(reach), 4, -1, tiny_beyond_at_rest, 30, 1},
    {PART(reach), 4, -1, tiny_beyond_moving, 30, 1},
    {PART(leave), 1, -1, ends_before, 30, 1},
    {PART(farthest[0]), 1, -1, among_origins_at_rest, 300, 1},
    {PART(farthest[1]), 1, -1, among_origins_moving, 300, 1},
};

static void parts_below_nothing(void) {
  if (!has_frusta(PKTRT_ISA_AUTO)) return;
  for (size_t i = 0; i < COUNT(less); i++) {
    const part *p = &less[i];
    uint32_t lose = 0, without = 0;

    for (uint32_t seed = 0; seed < p->triangles && !(small_run && lose > 2); seed++) {
      graze g;
      make_for(p, i, seed, &g);
      without += copy_loses(p, &g, 0);
      lose += copy_loses(p, &g, p->left * p->of);
    }
    CHECK(lose > 0, "%s: with %g times as much nothing is lost", p->name, (double)p->left);
    CHECK(without == 0, "%s: without it %u triangles lose hits: it is needed", p->name, without);
    say("%-11s of %2g, times %5g: %3u of %3u triangles lose hits; times 0: %u", p->name, (double)p->of, (double)p->left,
        lose, p->triangles, without);
  }
}

/* --- instances --- */

/* One triangle of a model, FAR away from the model's origin, and an instance that flattens it along all but one direction,
   to FLAT, and brings it near the scene's origin. Rays from so far DISTANT come to the corner that reaches farthest along
   an axis, and beside it by what is rounded. */
typedef struct lean {
  placement p;
  float corner[9];
  uint32_t index[3];
  pktrt_ray ray[RAYS];
  pktrt_hit want[RAYS];
} lean;

static void lean_place(rng *r, lean *x, float flat, float far_) {
  float *m = x->p.transform[0];
  float out[3], in[3];

  memset(x, 0, sizeof *x);
  x->p.models = x->p.n = x->p.keys[0] = 1;
  x->p.model[0] = world_none();
  x->p.model[0].n = 1;
  x->p.model[0].m[0].p = x->corner;
  x->p.model[0].m[0].i = x->index;
  x->p.model[0].m[0].nv = 3;
  x->p.model[0].m[0].nt = x->p.model[0].m[0].keys = 1;

  for (uint32_t c = 0; c < 3; c++) x->index[c] = c;
  for (int i = 0; i < 9; i++) x->corner[i] = rng_sign(r) + (i % 3 ? 0 : far_);
  for (int i = 0; i < 3; i++) {
    out[i] = rng_sign(r);
    in[i] = rng_sign(r);
  }
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) m[4 * i + j] = out[i] * in[j] + (i == j ? flat : 0);
    m[4 * i + 3] = -(m[4 * i] * far_);
  }
}

static void lean_aim(rng *r, lean *x, float flat, float far_, float distant) {
  const float *m = x->p.transform[0];
  double seen[3][3];

  for (int c = 0; c < 3; c++)
    for (int i = 0; i < 3; i++) {
      seen[c][i] = (double)m[4 * i + 3];
      for (int j = 0; j < 3; j++) seen[c][i] += (double)m[4 * i + j] * (double)x->corner[3 * c + j];
    }

  for (int i = 0; i < RAYS; i++) {
    const int axis = (int)rng_below(r, 3);
    const double up = rng_below(r, 2) ? 1 : -1, unit = 0x1p-24 / (double)flat * (double)(1 + far_ + distant);
    const double inwards = unit * pow(10, -2 * (double)rng_unit(r));
    const double aside = unit * pow(10, -2 * (double)rng_unit(r)) * (double)either(r, 1);
    int c = 0;

    for (int k = 1; k < 3; k++)
      if (up * seen[k][axis] > up * seen[c][axis]) c = k;

    pktrt_ray *ray = &x->ray[i];

    *ray = ray_of(0, 0, 0, 0, 0, 0);
    for (int k = 0; k < 3; k++) {
      const double middle = (seen[0][k] + seen[1][k] + seen[2][k]) / 3;
      const double to = seen[c][k] + inwards * (middle - seen[c][k]) + aside * (double)(m[4 * k] / m[0]);

      ray->origin[k] = k == axis ? (float)to : distant * rng_sign(r);
      ray->direction[k] = (float)(to - (double)ray->origin[k]);
    }

    const pktrt_ray within = ray_within(m, 1, ray);

    ref_intersect(&x->p.model[0], &within, &x->want[i]);
  }
}

/* Returns how many rays a scene answers otherwise than the ray in the frame of the instance says, by all paths. */
static uint32_t lean_lost(const lean *x, const pktrt_scene *s, bool copy) {
  uint32_t lost = 0;

  for (int how = 0; how < ASKED; how++) {
    pktrt_hit got[RAYS];
    pktrt_query_desc q;

    memset(&q, 0, sizeof q);
    q.path = paths[how];
    (copy ? noslack_intersect : pktrt_intersect_ex)(s, &q, x->ray, got, RAYS);
    for (int i = 0; i < RAYS; i++)
      lost += got[i].mesh != x->want[i].mesh || !same_bits(&got[i].t, &x->want[i].t, 3 * sizeof(float));
  }
  return lost;
}

static pktrt_scene *lean_scene(const lean *x) {
  const pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
  pktrt_scene *s = pktrt_scene_create(&d);

  CHECK(placement_fill(s, &x->p), "%s", pktrt_last_error(s));
  return s;
}

static void instances_need_their_slack(void) {
  static const struct {
    const char *name;
    size_t at;
    float flat, far_, distant;
  } rows[] = {{PART(kappa), 1e-3f, 0, 3000}, {PART(kappa_box), 1, 1000, 3}};

  for (size_t i = 0; i < COUNT(rows); i++) {
    uint32_t lost = 0, wrong = 0, hits = 0;

    for (uint32_t seed = 0; seed < 500 && !(small_run && lost > 2); seed++) {
      static lean x;
      rng r = rng_of(seed);
      const float none = 0;

      lean_place(&r, &x, rows[i].flat, rows[i].far_);
      lean_aim(&r, &x, rows[i].flat, rows[i].far_, rows[i].distant);
      for (int k = 0; k < RAYS; k++) hits += x.want[k].mesh != PKTRT_NONE;

      pktrt_scene *s = lean_scene(&x);

      wrong += lean_lost(&x, s, false);
      pktrt_scene_destroy(s);
      slack_left = slack_whole;
      memcpy((char *)&slack_left + rows[i].at, &none, sizeof none);
      s = noslack_placed(&x.p, PKTRT_ISA_AUTO);
      if (CHECK(s != NULL)) lost += lean_lost(&x, s, true);
      noslack_destroy(s);
      slack_left = slack_none;
    }
    CHECK(wrong == 0 && lost > 0, "%s: %u answers are wrong, %u without it", rows[i].name, wrong, lost);
    say("%-9s: %u hits, three ways each; %u answers wrong; without it %u", rows[i].name, hits, wrong, lost);
  }
}

/* --- rays that leave surfaces --- */

static void departures_need_their_slack(void) {
  static const struct {
    const char *name;
    size_t at;
    float left, flat, far_;
  } rows[] = {{PART(start[0]), 0, 1, 1000}, {PART(start[1]), 0, 1e-3f, 0}, {PART(plane), -131072, 1, 0},
      {PART(kappa_spawn), -1, 1e-3f, 1000}};

  for (size_t i = 0; i < COUNT(rows); i++) {
    uint32_t met[3] = {0, 0, 0}, rays = 0; /* with all slack, without the part, with what is left */

    for (uint32_t seed = 0; seed < 100; seed++) {
      static lean x;
      rng r = rng_of(seed);

      lean_place(&r, &x, rows[i].flat, rows[i].far_);
      slack_left = slack_whole;
      pktrt_scene *s = noslack_placed(&x.p, PKTRT_ISA_AUTO);

      for (int k = 0; k < 20 && CHECK(s != NULL); k++) {
        const float u = 0.4f * rng_unit(&r) + 0.1f, v = 0.4f * rng_unit(&r) + 0.05f;
        const float d[3] = {rng_sign(&r), rng_sign(&r), rng_sign(&r)}, left[3] = {1, 0, rows[i].left};

        rays++;
        for (int w = 0; w < 3; w++) {
          pktrt_ray out;
          pktrt_hit hit;

          memcpy((char *)&slack_left + rows[i].at, &left[w], sizeof left[w]);
          noslack_spawn_at(s, 0, 0, u, v, 0, d, &out);
          slack_left = slack_whole;
          noslack_intersect(s, NULL, &out, &hit, 1);
          met[w] += hit.mesh != PKTRT_NONE;
        }
      }
      noslack_destroy(s);
      slack_left = slack_none;
    }
    CHECK(met[0] == 0 && met[2] > 0, "%s: %u rays meet what they left, %u without it", rows[i].name, met[0], met[2]);
    CHECK(rows[i].left < 0 ? met[1] == 0 : met[1] == met[2], "%s: without it %u", rows[i].name, met[1]);
    say("%-11s: of %u rays %u meet the triangle that they left; without it %u; with %2g times as much %u", rows[i].name,
        rays, met[0], met[1], (double)rows[i].left, met[2]);
  }
}

/* --- parts that others stand in for ---

   Of frusta. Let a ray hit at the depth W from the reference point, and begin at ow. Then ow <= W <= M, for the ray
   whose origin has the point's depth sees the same scene; across, no corner is nearer to both ends of the origins than
   to their middle. So where it counts, rho <= M. Errors, in units of eps M, without fused operations: 1 of the slope; 5
   of C; 3 of its value at the far end; 4 of the plane there; 1, and |o|, of the box: at rest 14 and |o|, which max D
   covers by itself. Beyond the far end a hit lies by rounding, by 2 at most, and planes lean by 1 at most; there C errs
   by 5 eps rho only, and rho has slack of its own. Motion adds 7 1/2 and 4 |o|, so it is left to search: packets are
   moved about until more slack is needed, with nothing of that part and as little of the others as loses a hit. */

typedef struct spare_part {
  const char *name;
  bool rho, end; /* taken away */
  uint32_t keys;
} spare_part;

/* Whether frusta lose a hit that their rays have alone, with so much of the others. */
static bool frustum_loses(const spare_part *p, const graze *g, float others) {
  slack_left = slack_whole;
  slack_left.m = slack_left.o = slack_left.rho = slack_left.end = others;
  if (p->rho) slack_left.rho = 0;
  if (p->end) slack_left.end = 0;
  pktrt_scene *s = noslack_scene(&g->w, PKTRT_ISA_AUTO);
  if (!CHECK(s != NULL)) return false;
  const uint64_t lost = lost_by(g, s, true, FAST);
  const bool loses = lost && (lost & ~lost_by(g, s, true, SINGLE));
  noslack_destroy(s);
  slack_left = slack_none;
  return loses;
}

/* Moves the triangle, the ray that grazes it, all rays, or everything by little. */
static void shake(rng *r, graze *g) {
  const uint32_t a = rng_below(r, 3);
  const float by = 0.01f * rng_sign(r);
  float to = g->ray[0].direction[a];
  switch (rng_below(r, 4)) {
  case 0: /* at the first key */
    to = jog(r, g->corner[a], 2);
    if (a == g->axis[1]) g->corner[a] = g->corner[3 + a] = to; /* the side */
    if (a == g->axis[0]) g->corner[a] = g->corner[3 + a] = g->corner[6 + a] = to;
    break;
  case 1: g->ray[0].origin[a] = jog(r, g->ray[0].origin[a], 4); break;
  case 2:
    to = jog(r, to, 4);
    for (int i = 0; i < RAYS; i++) g->ray[i].direction[a] = to;
    break;
  default:
    for (uint32_t c = 0; c < 3; c++) g->corner[3 * c + a] += by;
    for (int i = 0; i < RAYS; i++) g->ray[i].origin[a] += by;
  }
}

static void copy_graze(graze *to, const graze *from) {
  *to = *from;
  to->w.m[0].p = to->corner, to->w.m[0].i = to->index;
}

/* The most of the others with which a hit is lost, of the packet of a seed and what it becomes. */
static float spared(const spare_part *p, uint64_t seed, uint32_t steps, float most) {
  rng r = rng_of(seed);
  graze g;
  at_a_plane(&r, &g, p->keys);
  ask_reference(&g);
  library_is_right(p->name, &g, seed);
  if (!frustum_loses(p, &g, 0.003f)) return most;
  float mine = 0.003f;
  for (uint32_t step = 0; step < steps; step++) {
    graze other;
    copy_graze(&other, &g);
    for (uint32_t times = 1 + rng_below(&r, 3); times; times--) shake(&r, &other);
    ask_reference(&other);
    if (!frustum_loses(p, &other, mine)) continue;
    while (mine < 1 && frustum_loses(p, &other, mine * 1.1f)) mine *= 1.1f;
    copy_graze(&g, &other);
  }
  library_is_right(p->name, &g, seed);
  return fmaxf(mine, most);
}

static void parts_to_spare(void) {
  static const spare_part spare[4] = {
      {"rho", true, false, 1}, {"rho", true, false, 2}, {"end", false, true, 1}, {"end", false, true, 2}};
  if (!has_frusta(PKTRT_ISA_AUTO)) return;
  for (size_t i = 0; i < COUNT(spare); i++) {
    const spare_part *p = &spare[i];
    float most = 0;
    for (uint64_t seed = 0; seed < 150; seed++) most = spared(p, seed, 300, most);
    CHECK(most > 0.003f && most < 0.3f, "without %s a hit is lost with %g of the rest", p->name, (double)most);
    say("without %s, %s, the first hit is lost when %.3f of the rest of the slack are left", p->name,
        p->keys > 1 ? "moving" : "at rest", (double)most);
  }
}

void suite_slack(void) {
  run("with less of one part of the slack, hits are lost that the library has", parts_are_needed);
  run("with less than nothing of one part of the slack of packets, hits are lost", parts_below_nothing);
  run("without the slack of instances, hits in them are lost", instances_need_their_slack);
  run("without the slack of what leaves surfaces, rays meet what they left", departures_need_their_slack);
  run("frusta need neither the slack of rho nor that of the far end, by far", parts_to_spare);
}
