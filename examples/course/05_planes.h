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

/* Makes the planes of a packet. Returns false if the rays have no such planes. */
EX_UNUSED static bool planes_make(planes *p, const course_ray *rays, uint32_t n, float pad) {
  p->origin = rays[0].origin.at;
  p->pad = pad;

  for (uint32_t i = 0; i < n; i++) {
    const float *d = rays[i].direction.at;
    int main_axis = 0;
    if (fabsf(d[1]) > fabsf(d[main_axis])) main_axis = 1;
    if (fabsf(d[2]) > fabsf(d[main_axis])) main_axis = 2;
    const float sign = d[main_axis] < 0 ? -1.0f : 1.0f;

    if (i == 0) {
      p->main = main_axis;
      p->sign = sign;
      p->other[0] = (main_axis + 1) % 3;
      p->other[1] = (main_axis + 2) % 3;
    }
    if (main_axis != p->main || sign != p->sign || memcmp(p->origin, rays[i].origin.at, sizeof(vec))) return false;

    for (int a = 0; a < 2; a++) {
      const float slope = sign * (d[p->other[a]] / d[main_axis]);
      p->slope_lo[a] = i ? fminf(p->slope_lo[a], slope) : slope;
      p->slope_hi[a] = i ? fmaxf(p->slope_hi[a], slope) : slope;
    }
  }
  return true;
}

/* Returns true if a box lies outside one of the planes, or behind the origin: then all rays miss the box. */
EX_UNUSED static bool planes_miss(const planes *p, const float lo[3], const float hi[3]) {
  const int main_axis = p->main;
  const float o = p->origin[main_axis];
  const float nearest = p->sign > 0 ? lo[main_axis] - o : o - hi[main_axis];
  const float farthest = p->sign > 0 ? hi[main_axis] - o : o - lo[main_axis];
  const float w0 = fmaxf(nearest - p->pad, 0), w1 = farthest + p->pad; /* the depths of the box */

  for (int a = 0; a < 2; a++) {
    const int axis = p->other[a];
    const float below = lo[axis] - p->origin[axis] - p->pad;
    const float above = hi[axis] - p->origin[axis] + p->pad;
    if (below > fmaxf(p->slope_hi[a] * w0, p->slope_hi[a] * w1)) return true;
    if (above < fminf(p->slope_lo[a] * w0, p->slope_lo[a] * w1)) return true;
  }
  return w1 < 0;
}
/* [end] */

#endif
