/* truth.h - part of peers.c: who is right where the two libraries disagree. An ideal test in double over all
   triangles, with intervals for what the rounding of floats may change, as that of the tests (tests/reference.c); here
   over a whole scene, for a few rays.

   In the frame of a ray, sheared so that it goes along z from the origin, a corner is X = p_u - S_u p_k, Y likewise,
   Z = p_k with p = v - o. pktrt takes these in float: with e = 2^-24 and M = max |p|, each of X and Y is off by at most
   7 e M, so corners lie within D = sqrt(2) 7 e M of their ideal places. Corners that move are interpolated in float
   first, a p + b q, which is off by at most 4 e C where |p|, |q| <= C, and that, by the shear, twice: 8 e C more in X
   and Y. If the ideal border passes the origin at more than D, inside or outside is certain; nearer, both are possible.
   The depth of a hit is then within |gradient of the ideal plane| D of the ideal one, plus what Z and t round to.

   With |p| <= 2 C all of that is below 60 e C. Vertices of instances are off by less than what is allowed to those that
   move: rounded where they are placed here, and the ray in the frame of the instance.

   These bounds are pktrt's. Embree's plain test promises less, so an answer of Embree's counts as wrong only if its t
   is off by more besides.

   Contents: candidates, judgement. */
#ifndef PEERS_TRUTH_H
#define PEERS_TRUTH_H

#include "scenes.h"

/* What Embree's t may be off by: a part of t, and of the diagonal, since a ray that meets something at once has a t
   that is mostly rounding. (Directions of rays that ask for t are of length 1.) */
#define TOLERANCE 1e-3
#define SLACK (1.0 / 2097152)

/* >>candidates ----------------------------------------------------------------------------------------------------- */

typedef struct interval { /* of t */
  double lo, hi;
  bool certain; /* a hit for sure; else perhaps */
} interval;

enum { MAX_CANDIDATES = 256 };
typedef struct truth {
  interval candidate[MAX_CANDIDATES];
  unsigned count;
  bool complete; /* there was room for all candidates */
  double first;  /* the nearest certain hit is not beyond this */
} truth;

typedef struct shear {
  int k, u, v;
  double su, sv, dk;
} shear;

static shear shear_of(const float d[3]) {
  shear s;
  s.k = largest_axis(d);
  s.u = (s.k + 1) % 3, s.v = (s.k + 2) % 3;
  s.dk = (double)d[s.k], s.su = (double)d[s.u] / s.dk, s.sv = (double)d[s.v] / s.dk;
  return s;
}

typedef struct corners {
  double x[3][2], z[3];
  double d, z_off; /* what X and Y, and Z, may be off by */
} corners;

/* Whether a triangle lies aside of the ray by more than `slack`, which is that of the whole scene: most do. */
static bool aside(
    const scene_mesh *m, const uint32_t *index, const pktrt_ray *r, double time, const shear *s, double slack) {
  const size_t key = m->key_count > 1 ? (size_t)m->vertex_count * 3 : 0;
  double x[3], y[3];
  for (int i = 0; i < 3; i++) {
    const float *at = m->positions + 3 * (size_t)index[i];
    double p[3];
    for (int a = 0; a < 3; a++)
      p[a] = (1 - time) * (double)at[a] + time * (double)at[key + (size_t)a] - (double)r->origin[a];
    x[i] = p[s->u] - s->su * p[s->k], y[i] = p[s->v] - s->sv * p[s->k];
  }
  return (x[0] > slack && x[1] > slack && x[2] > slack) || (x[0] < -slack && x[1] < -slack && x[2] < -slack) ||
         (y[0] > slack && y[1] > slack && y[2] > slack) || (y[0] < -slack && y[1] < -slack && y[2] < -slack);
}

/* false: it lies aside by far. placed: of an instance. */
static bool sheared(
    const scene_mesh *m, const uint32_t *index, bool placed, const pktrt_ray *r, const shear *s, corners *out) {
  const double e = 1.0 / 16777216, time = fmin(fmax((double)r->time, 0), 1);
  const size_t key = (size_t)m->vertex_count * 3;
  double largest = 0, coordinate = 0;
  for (int i = 0; i < 3; i++) {
    const float *at = m->positions + 3 * (size_t)index[i];
    double p[3];
    for (int a = 0; a < 3; a++) {
      const double v =
          m->key_count > 1 ? (1 - time) * (double)at[a] + time * (double)at[key + (size_t)a] : (double)at[a];
      if (m->key_count > 1 || placed) coordinate = fmax(coordinate, fabs((double)at[a]));
      if (m->key_count > 1) coordinate = fmax(coordinate, fabs((double)at[key + (size_t)a]));
      p[a] = v - (double)r->origin[a];
      largest = fmax(largest, fabs(p[a]));
    }
    out->z[i] = p[s->k], out->x[i][0] = p[s->u] - s->su * p[s->k], out->x[i][1] = p[s->v] - s->sv * p[s->k];
  }
  out->d = 1.4143 * e * (7 * (largest + 4 * e * coordinate) + 8 * coordinate) + 1e-43;
  out->z_off = 1.01 * e * (largest + 4 * coordinate);
  for (int a = 0; a < 2; a++) {
    const double lo = fmin(out->x[0][a], fmin(out->x[1][a], out->x[2][a]));
    const double hi = fmax(out->x[0][a], fmax(out->x[1][a], out->x[2][a]));
    if (lo > out->d || hi < -out->d) return false;
  }
  return true;
}

static double segment_distance(const double a[2], const double b[2]) { /* from the origin */
  const double d[2] = {b[0] - a[0], b[1] - a[1]}, l = d[0] * d[0] + d[1] * d[1];
  const double f = l > 0 ? fmin(fmax(-(a[0] * d[0] + a[1] * d[1]) / l, 0), 1) : 0;
  return hypot(a[0] + f * d[0], a[1] + f * d[1]);
}

static bool hit_of(const corners *c, double dk, interval *out) {
  double near = HUGE_VAL, area[3];
  for (int i = 0; i < 3; i++) {
    const double *a = c->x[(i + 1) % 3], *b = c->x[(i + 2) % 3];
    near = fmin(near, segment_distance(a, b));
    area[i] = a[0] * b[1] - a[1] * b[0];
  }
  const bool inside = (area[0] > 0 && area[1] > 0 && area[2] > 0) || (area[0] < 0 && area[1] < 0 && area[2] < 0);
  if (near > c->d && !inside) return false;
  const double ax = c->x[1][0] - c->x[0][0], ay = c->x[1][1] - c->x[0][1], bx = c->x[2][0] - c->x[0][0],
               by = c->x[2][1] - c->x[0][1], za = c->z[1] - c->z[0], zb = c->z[2] - c->z[0], det = ax * by - ay * bx;
  if (det == 0 && za == 0 && zb == 0) return false; /* a point */
  const double gx = (za * by - zb * ay) / det,
               gy = (ax * zb - bx * za) / det; /* det 0: not finite, so no bound below */
  const double z = c->z[0] - gx * c->x[0][0] - gy * c->x[0][1], slack = hypot(gx, gy) * c->d + c->z_off;
  out->certain = near > c->d;
  out->lo = fmin((z - slack) / dk, (z + slack) / dk), out->hi = fmax((z - slack) / dk, (z + slack) / dk);
  if (!(out->hi - out->lo < HUGE_VAL)) out->lo = -HUGE_VAL, out->hi = HUGE_VAL;
  const double more = fmax(fabs(out->lo), fabs(out->hi)) * (1.01 / 16777216 + 1e-12) + 1e-44; /* to float; of double */
  out->lo -= more, out->hi += more;
  return true;
}

/* far: no coordinate of the scene or of a ray's origin is larger. */
static void find_truth(const scene *s, bool placed, double far, const pktrt_ray *r, truth *out) {
  const shear frame = shear_of(r->direction);
  const double time = fmin(fmax((double)r->time, 0), 1), slack = 60 * far / 16777216 + 1e-43;
  out->count = 0, out->complete = true, out->first = HUGE_VAL;
  for (size_t i = 0; i < s->mesh_count; i++)
    for (size_t k = 0; k < s->meshes[i].triangle_count; k++) {
      const scene_mesh *m = &s->meshes[i];
      corners c;
      interval x;
      if (aside(m, m->indices + 3 * k, r, time, &frame, slack)) continue;
      if (!sheared(m, m->indices + 3 * k, placed, r, &frame, &c) || !hit_of(&c, frame.dk, &x)) continue;
      if (x.hi <= (double)r->tmin || x.lo >= (double)r->tmax) continue;
      x.certain = x.certain && x.lo > (double)r->tmin && x.hi < (double)r->tmax;
      if (x.certain) out->first = fmin(out->first, x.hi);
      if (out->count < MAX_CANDIDATES) out->candidate[out->count++] = x;
      else out->complete = false;
    }
}

/* >>judgement ------------------------------------------------------------------------------------------------------ */

/* An answer is t, infinity for a miss; if only occlusion was asked, 0 for a hit. */
static bool possible(const truth *t, bool occlusion, float answer, double tolerance, double slack) {
  if (isinf(answer)) return isinf(t->first);
  if (occlusion) return t->count > 0;
  for (unsigned i = 0; i < t->count; i++) {
    const interval *x = &t->candidate[i];
    const double off = tolerance * fabs((double)answer) + slack;
    if (x->lo <= t->first && (double)answer >= x->lo - off && (double)answer <= x->hi + off) return true;
  }
  return !t->complete;
}

#endif /* PEERS_TRUTH_H */
