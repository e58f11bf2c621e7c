/* 05_planes.h - chapter 5's second test for a whole packet: four planes through the point at which all rays start. */
#ifndef PLANES_H
#define PLANES_H

#include "course.h"

/* [planes] */
/* Four planes around the rays of a packet that start at one point and share a main axis and its sign. At depth w, the
   distance along the main axis, all rays are between slope_lo[a] * w and slope_hi[a] * w along the two other axes. */
typedef struct planes {
  const float *origin;
  int main, other[2];
  float sign, slope_lo[2], slope_hi[2], pad;
} planes;

/* Returns false if the rays have no such planes. */
EX_UNUSED static bool planes_make(planes *p, const course_ray *rays, uint32_t n, float pad) {
  p->origin = rays[0].origin.at, p->pad = pad;
  for (uint32_t i = 0; i < n; i++) {
    const float *d = rays[i].direction.at;
    const int k = fabsf(d[1]) <= fabsf(d[0]) && fabsf(d[2]) <= fabsf(d[0]) ? 0 : fabsf(d[2]) <= fabsf(d[1]) ? 1 : 2;
    const float sign = d[k] < 0 ? -1.0f : 1.0f;
    if (!i) p->main = k, p->sign = sign, p->other[0] = (k + 1) % 3, p->other[1] = (k + 2) % 3;
    if (k != p->main || sign != p->sign || memcmp(p->origin, rays[i].origin.at, sizeof(vec))) return false;
    for (int a = 0; a < 2; a++) {
      const float slope = sign * (d[p->other[a]] / d[k]);
      p->slope_lo[a] = i ? fminf(p->slope_lo[a], slope) : slope;
      p->slope_hi[a] = i ? fmaxf(p->slope_hi[a], slope) : slope;
    }
  }
  return true;
}

/* Tells whether a box lies outside one of the planes, or behind the origin: then all rays miss it. */
EX_UNUSED static bool planes_miss(const planes *p, const float lo[3], const float hi[3]) {
  const int k = p->main;
  const float o = p->origin[k], nearest = p->sign > 0 ? lo[k] - o : o - hi[k],
              farthest = p->sign > 0 ? hi[k] - o : o - lo[k];
  const float w0 = fmaxf(nearest - p->pad, 0), w1 = farthest + p->pad; /* the depths of the box */
  for (int a = 0; a < 2; a++) {
    const float l = lo[p->other[a]] - p->origin[p->other[a]] - p->pad;
    const float h = hi[p->other[a]] - p->origin[p->other[a]] + p->pad;
    if (l > fmaxf(p->slope_hi[a] * w0, p->slope_hi[a] * w1)) return true;
    if (h < fminf(p->slope_lo[a] * w0, p->slope_lo[a] * w1)) return true;
  }
  return w1 < 0;
}
/* [end] */

#endif
