/* closest.h - pktrt_closest_point_n beside Embree's point query, on a mesh at rest.

   Embree finds the triangles whose boxes are near and calls a function of the user for each, who computes the distance and shortens
   the radius. The function here does in floats what Ericson's book describes (Real-Time Collision Detection, 5.1.5), by the region of
   the plane that the point lies in. Points are uniform in the mesh's box made 1.5 times as large, or lie near the surface: at random
   points of triangles, moved by up to a hundredth of the box's diagonal. Each library gets the same floats, in turn, and the
   least time of some rounds counts. */
#ifndef BENCH_PEERS_CLOSEST_H
#define BENCH_PEERS_CLOSEST_H

#include "../embree.h"

enum { CLOSEST_POINTS = 100000, CLOSEST_ROUNDS = 5 };

/* The mesh and what is nearest so far. */
typedef struct closest_user {
  const float *positions;
  const uint32_t *indices; /* NULL: 0, 1, 2, ... */
  unsigned prim;
} closest_user;

static float closest_dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Finds the point a + v ab + w ac of a triangle that is nearest to p, in floats. */
static void closest_weights(const float p[3], const float a[3], const float b[3], const float c[3], float *v,
                            float *w) {
  float ab[3], ac[3], ap[3], bp[3], cp[3];
  for (int i = 0; i < 3; i++) {
    ab[i] = b[i] - a[i], ac[i] = c[i] - a[i];
    ap[i] = p[i] - a[i], bp[i] = p[i] - b[i], cp[i] = p[i] - c[i];
  }
  const float d1 = closest_dot(ab, ap), d2 = closest_dot(ac, ap), d3 = closest_dot(ab, bp), d4 = closest_dot(ac, bp);
  const float d5 = closest_dot(ab, cp), d6 = closest_dot(ac, cp);
  *v = *w = 0;
  if (d1 <= 0 && d2 <= 0) return;
  *v = 1;
  if (d3 >= 0 && d4 <= d3) return;
  *v = 0, *w = 1;
  if (d6 >= 0 && d5 <= d6) return;
  const float to_c = d1 * d4 - d3 * d2, to_b = d5 * d2 - d1 * d6, to_a = d3 * d6 - d5 * d4;
  *w = 0, *v = d1 / (d1 - d3);
  if (to_c <= 0 && d1 >= 0 && d3 <= 0) return;
  *v = 0, *w = d2 / (d2 - d6);
  if (to_b <= 0 && d2 >= 0 && d6 <= 0) return;
  *w = (d4 - d3) / ((d4 - d3) + (d5 - d6)), *v = 1 - *w;
  if (to_a <= 0 && d4 >= d3 && d5 >= d6) return;
  *v = to_b / (to_a + to_b + to_c), *w = to_c / (to_a + to_b + to_c);
}

/* What Embree calls for a triangle; shortens the radius. */
static bool closest_triangle(struct RTCPointQueryFunctionArguments *args) {
  closest_user *user = (closest_user *)args->userPtr;
  const size_t at = 3 * (size_t)args->primID;
  const float p[3] = {args->query->x, args->query->y, args->query->z}, *corner[3];
  float v, w, square = 0;
  for (size_t c = 0; c < 3; c++) corner[c] = user->positions + 3 * (user->indices ? user->indices[at + c] : at + c);
  closest_weights(p, corner[0], corner[1], corner[2], &v, &w);
  for (int i = 0; i < 3; i++) {
    const float a = corner[0][i], way = p[i] - (a + v * (corner[1][i] - a) + w * (corner[2][i] - a));
    square += way * way;
  }
  const float distance = sqrtf(square);
  if (!(distance < args->query->radius)) return false;
  args->query->radius = distance, user->prim = args->primID;
  return true;
}

/* Where time goes: seconds of each library, and how often they differ by more than 2^-20 of the diagonal. */
typedef struct closest_times {
  double ours, theirs;
  size_t apart;
} closest_times;

static void closest_race(const pktrt_scene *ours, RTCScene theirs, closest_user *user, const pktrt_point_query *query,
                         float diagonal, pktrt_closest *found, closest_times *out) {
  out->ours = out->theirs = INFINITY, out->apart = 0;
  for (int round = 0; round <= CLOSEST_ROUNDS; round++) { /* the first is not timed */
    double start = cpu_seconds();
    pktrt_closest_point_n(ours, query, found, CLOSEST_POINTS);
    const double mine = cpu_seconds() - start;
    size_t apart = 0;
    start = cpu_seconds();
    for (size_t i = 0; i < CLOSEST_POINTS; i++) {
      struct RTCPointQuery q = {query[i].point[0], query[i].point[1], query[i].point[2], 0, INFINITY};
      struct RTCPointQueryContext context;
      rtcInitPointQueryContext(&context);
      rtcPointQuery(theirs, &q, &context, closest_triangle, user);
      apart += !(fabsf(q.radius - found[i].distance) <= diagonal * 9.5367431640625e-7f);
    }
    const double other = cpu_seconds() - start;
    out->apart += apart;
    if (!round) continue;
    out->ours = mine < out->ours ? mine : out->ours, out->theirs = other < out->theirs ? other : out->theirs;
  }
}

#endif
