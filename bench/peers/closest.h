/* closest.h - part of peers.c: pktrt_closest_point_n beside Embree's point query, on meshes at rest.

   Embree finds the triangles whose boxes are near, and calls a function of its user for each, which computes the distance and shortens
   the radius. That function is here as Ericson has it (Real-Time Collision Detection, 5.1.5), by the region of the plane that the
   point lies in, in floats. Points about the meshes are uniform in their box made 1.5 times as large; points near are beside random
   points of random triangles, up to a hundredth of the box's diagonal along each axis. Both libraries get the same floats, in turn; of
   several rounds the least time counts. */
#ifndef PEERS_CLOSEST_H
#define PEERS_CLOSEST_H

#include "race.h"
#include "report.h"
#include "scenes.h"
#include "../embree.h"

enum { CLOSEST_POINTS = 20000 };

/* Finds the point a + v ab + w ac of a triangle that is nearest to p, in floats. */
static void closest_weights(
    const float p[3], const float a[3], const float b[3], const float c[3], float *v, float *w) {
  float ab[3], ac[3], ap[3], bp[3], cp[3];
  for (int i = 0; i < 3; i++) {
    ab[i] = b[i] - a[i], ac[i] = c[i] - a[i];
    ap[i] = p[i] - a[i], bp[i] = p[i] - b[i], cp[i] = p[i] - c[i];
  }
  const float d1 = dot(ab, ap), d2 = dot(ac, ap), d3 = dot(ab, bp), d4 = dot(ac, bp);
  const float d5 = dot(ab, cp), d6 = dot(ac, cp);
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

/* What Embree calls for a triangle: tells whether it shortens the radius. */
static bool closest_triangle(struct RTCPointQueryFunctionArguments *args) {
  const scene_mesh *m = &((const scene_mesh *)args->userPtr)[args->geomID];
  const uint32_t *index = m->indices + 3 * (size_t)args->primID;
  const float p[3] = {args->query->x, args->query->y, args->query->z}, *corner[3];
  float v, w, square = 0;
  for (size_t c = 0; c < 3; c++) corner[c] = m->positions + 3 * (size_t)index[c];
  closest_weights(p, corner[0], corner[1], corner[2], &v, &w);
  for (int i = 0; i < 3; i++) {
    const float a = corner[0][i], way = p[i] - (a + v * (corner[1][i] - a) + w * (corner[2][i] - a));
    square += way * way;
  }
  const float distance = sqrtf(square);
  if (!(distance < args->query->radius)) return false;
  args->query->radius = distance;
  return true;
}

/* Makes points near the surface, or about the meshes. Returns the diagonal of their box. */
static float make_closest_points(const stage *g, bool near, pktrt_point_query *out) {
  double lo[3], hi[3], diagonal = 0;
  scene_bounds(&g->s, lo, hi);
  for (int a = 0; a < 3; a++) diagonal += (hi[a] - lo[a]) * (hi[a] - lo[a]);
  diagonal = sqrt(diagonal);
  for (uint64_t i = 0; i < CLOSEST_POINTS; i++) {
    const scene_mesh *m = &g->s.meshes[(size_t)((double)uniform(i, 0) * (double)g->s.mesh_count)];
    const uint32_t *index = m->indices + 3 * (size_t)((double)uniform(i, 1) * (double)m->triangle_count);
    const bool beyond = uniform(i, 2) + uniform(i, 3) > 1;
    const float v = beyond ? 1 - uniform(i, 2) : uniform(i, 2), w = beyond ? 1 - uniform(i, 3) : uniform(i, 3);
    memset(&out[i], 0, sizeof out[i]);
    out[i].max_distance = INFINITY;
    for (unsigned a = 0; a < 3; a++) {
      const float at = uniform(i, 4 + a), *p = m->positions + a;
      const float on =
          (1 - v - w) * p[3 * (size_t)index[0]] + v * p[3 * (size_t)index[1]] + w * p[3 * (size_t)index[2]];
      const double about = (lo[a] + hi[a]) / 2 + 1.5 * ((double)at - 0.5) * (hi[a] - lo[a]);
      out[i].point[a] = near ? on + (2 * at - 1) * 0.01f * (float)diagonal : (float)about;
    }
  }
  return (float)diagonal;
}

/* Returns the square of a point's distance to a triangle, in doubles: the least of its edges' and, where the point lies above it, its
   plane's. */
static double closest_square(const float p[3], const float *const corner[3]) {
  double edge[3][3], way[3][3], normal[3], least = INFINITY, high = 0, size = 0;
  bool above = true;
  for (int c = 0; c < 3; c++)
    for (int a = 0; a < 3; a++) {
      edge[c][a] = (double)corner[(c + 1) % 3][a] - (double)corner[c][a];
      way[c][a] = (double)p[a] - (double)corner[c][a];
    }
  for (int a = 0; a < 3; a++) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    normal[a] = edge[0][b] * edge[1][c] - edge[0][c] * edge[1][b];
    high += way[0][a] * normal[a], size += normal[a] * normal[a];
  }
  for (int c = 0; c < 3; c++) {
    double along = 0, square = 0, side = 0, sum = 0;
    for (int a = 0; a < 3; a++) {
      along += edge[c][a] * way[c][a], square += edge[c][a] * edge[c][a];
      side += normal[a] * (edge[c][(a + 1) % 3] * way[c][(a + 2) % 3] - edge[c][(a + 2) % 3] * way[c][(a + 1) % 3]);
    }
    const double t = square > 0 ? fmin(fmax(along / square, 0), 1) : 0;
    for (int a = 0; a < 3; a++) sum += (way[c][a] - t * edge[c][a]) * (way[c][a] - t * edge[c][a]);
    least = fmin(least, sum), above = above && side > 0;
  }
  return size > 0 ? above ? fmin(least, high * high / size) : least : INFINITY;
}

/* Returns the distance of a point to the nearest of all triangles. */
static double closest_truth(const stage *g, const float p[3]) {
  double least = INFINITY;
  for (size_t k = 0; k < g->s.mesh_count; k++) {
    const scene_mesh *m = &g->s.meshes[k];
    for (size_t i = 0; i < (size_t)m->triangle_count * 3; i += 3) {
      const float *corner[3];
      for (size_t c = 0; c < 3; c++) corner[c] = m->positions + 3 * (size_t)m->indices[i + c];
      least = fmin(least, closest_square(p, corner));
    }
  }
  return sqrt(least);
}

/* Asks both libraries, one after the other; returns how many distances differ by more than 2^-20 of the diagonal. In a first round
   `wrong` counts those of ours that are so far from the truth, of these. */
static size_t ask_closest(const pair *p, const stage *g, const pktrt_point_query *query, float diagonal, double *ours,
    double *theirs, size_t *wrong) {
  static pktrt_closest found[CLOSEST_POINTS];
  static float radius[CLOSEST_POINTS];
  size_t apart = 0;
  double start = cpu_seconds();
  pktrt_closest_point_n(p->ours, query, found, CLOSEST_POINTS);
  *ours = cpu_seconds() - start;
  start = cpu_seconds();
  for (size_t i = 0; i < CLOSEST_POINTS; i++) {
    struct RTCPointQuery q;
    struct RTCPointQueryContext context;
    q.x = query[i].point[0], q.y = query[i].point[1], q.z = query[i].point[2], q.time = 0, q.radius = INFINITY;
    rtcInitPointQueryContext(&context);
    rtcPointQuery(p->theirs, &q, &context, closest_triangle, g->s.meshes);
    radius[i] = q.radius;
  }
  *theirs = cpu_seconds() - start;
  for (size_t i = 0; i < CLOSEST_POINTS; i++)
    if (!(fabsf(radius[i] - found[i].distance) <= diagonal * 9.5367431640625e-7f)) {
      apart++;
      if (wrong)
        *wrong += !(fabs((double)found[i].distance - closest_truth(g, query[i].point)) <= 1e-6 * (double)diagonal);
    }
  return apart;
}

/* With the widest kernels, which both libraries have; ours are the same for all. Returns how many of our distances are wrong. */
static size_t add_closest(report *to, const options *o, const stage *g, const setting *how, const pair *p) {
  static const char *const names[2] = {"points about", "points near"};
  static pktrt_point_query query[CLOSEST_POINTS];
  size_t wrong = 0;
  for (int near = 0; near < 2 && p->device; near++) {
    double ours[MAX_ROUNDS], theirs[MAX_ROUNDS], unused;
    const float diagonal = make_closest_points(g, near, query);
    const size_t before = wrong, differ = ask_closest(p, g, query, diagonal, &unused, &unused, &wrong);
    for (unsigned i = 0; i < o->rounds; i++) (void)ask_closest(p, g, query, diagonal, &ours[i], &theirs[i], NULL);
    row *r = add_values(
        add_row(to, g, how->name, pktrt_isa_string(p->isa), names[near], "pktrt", "points", "us"), ours, o->rounds);
    const double mine = r->best, mine_median = r->median;
    r->best *= 1e6 / CLOSEST_POINTS, r->median *= 1e6 / CLOSEST_POINTS;
    r = add_values(
        add_row(to, g, how->name, pktrt_isa_string(p->isa), names[near], "Embree", "points", "us"), theirs, o->rounds);
    const double other = r->best, other_median = r->median;
    r->best *= 1e6 / CLOSEST_POINTS, r->median *= 1e6 / CLOSEST_POINTS;
    ratio_row(to, g, how, p, names[near], "points", other_median / mine_median, other / mine);
    printf("  closest point, %s: pktrt %.2f us, Embree %.2f us, ratio %.2f; %zu of %d distances differ, ours is wrong "
           "in %zu\n",
        names[near], 1e6 * mine / CLOSEST_POINTS, 1e6 * other / CLOSEST_POINTS, other / mine, differ, CLOSEST_POINTS,
        wrong - before);
  }
  return wrong;
}

#endif
