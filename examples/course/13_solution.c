/* A solution of exercise 13. */
#include "13_exercise.h"

/* All rays are between a plane `below` and a plane `above` on each of the two other axes, at depths W from 0 to far.
   A plane is at `at` + `slope` W. Depth 0 is the first origin's along the rays, and places are relative to `middle`. */
struct hull {
  int axis, other[2];
  float sign, begin, middle[2], pad;
  float far_;        /* the depth of the far positions */
  float first, last; /* the depths between which a ray can have a hit */
  float at[2][2], slope[2][2];
};

/* Returns the coordinate of a point along the rays. */
static float hull_along(const hull *h, const float point[3]) { return h->sign * point[h->axis]; }

/* Finds depth 0, the middle of the origins and how far from them origins are; sets the pad. */
static void hull_origins(hull *h, const hull_packet *packet) {
  course_box origins = course_box_empty();
  float apart = 0;
  for (uint32_t i = 0; i < packet->n; i++)
    origins = course_box_grow(origins, packet->rays[i].origin, packet->rays[i].origin);

  h->begin = h->sign > 0 ? origins.lo.at[h->axis] : -origins.hi.at[h->axis];
  apart = origins.hi.at[h->axis] - origins.lo.at[h->axis];

  for (int side = 0; side < 2; side++) {
    const float lo = origins.lo.at[h->other[side]], hi = origins.hi.at[h->other[side]];
    h->middle[side] = lo == hi ? lo : 0.5f * lo + 0.5f * hi;
    apart = fmaxf(apart, fmaxf(hi - h->middle[side], h->middle[side] - lo));
  }

  h->pad = packet->pad + apart * (16.0f / 16777216);
}

/* Finds the depths between which a ray can have a hit, and the depth of the far positions: the last end of a ray, or the
   end of the scene if a ray ends much farther away. */
static void hull_depths(hull *h, const hull_packet *packet) {
  const float slack = 4.0f / 16777216;
  h->first = INFINITY;
  h->last = 0;

  for (uint32_t i = 0; i < packet->n; i++) {
    const course_ray *ray = &packet->rays[i];
    const float start = hull_along(h, ray->origin.at) - h->begin;
    const float step = hull_along(h, ray->direction.at);
    h->first = fminf(h->first, start + ray->tmin * step * (1 - slack));
    h->last = fmaxf(h->last, start + ray->tmax * step * (1 + slack));
  }

  const float exit = hull_along(h, h->sign > 0 ? packet->scene.hi.at : packet->scene.lo.at) - h->begin;
  h->far_ = h->last < 8 * exit ? h->last : exit;
  h->far_ = fmaxf(h->far_ * (1 + 4 * slack) + h->pad, 1e-30f);
}

hull *hull_make(const hull_packet *packet) {
  hull *h = (hull *)course_memory(1, sizeof(hull));
  h->axis = packet->axis;
  h->sign = packet->sign;
  for (int side = 0; side < 2; side++) h->other[side] = (h->axis + 1 + side) % 3;
  hull_origins(h, packet);
  hull_depths(h, packet);

  for (int side = 0; side < 2; side++) {
    float near_[2] = {INFINITY, -INFINITY}, far_[2] = {INFINITY, -INFINITY}; /* the least and the largest positions */

    for (uint32_t i = 0; i < packet->n; i++) {
      const course_ray *ray = &packet->rays[i];
      const float depth = hull_along(h, ray->origin.at) - h->begin;
      const float slope = h->sign * (ray->direction.at[h->other[side]] / ray->direction.at[h->axis]);
      const float start = ray->origin.at[h->other[side]] - h->middle[side] - slope * depth;
      const float end = slope * h->far_ + start;
      near_[0] = fminf(near_[0], start);
      near_[1] = fmaxf(near_[1], start);
      far_[0] = fminf(far_[0], end);
      far_[1] = fmaxf(far_[1], end);
    }

    for (int plane = 0; plane < 2; plane++) {
      h->at[side][plane] = near_[plane];
      h->slope[side][plane] = (far_[plane] - near_[plane]) / h->far_;
    }
  }

  return h;
}

bool hull_misses(const hull *h, const float lo[3], const float hi[3]) {
  float near_ = hull_along(h, h->sign > 0 ? lo : hi) - h->begin - h->pad;
  float far_ = hull_along(h, h->sign > 0 ? hi : lo) - h->begin + h->pad;
  if (far_ < h->first || near_ > h->last) return true;

  near_ = fmaxf(near_, 0);
  far_ = fminf(far_, h->far_);

  for (int side = 0; side < 2; side++) {
    const float below = h->slope[side][0], above = h->slope[side][1];
    const float lower = h->at[side][0] + below * (below > 0 ? near_ : far_);
    const float upper = h->at[side][1] + above * (above > 0 ? far_ : near_);
    if (lo[h->other[side]] - h->middle[side] - h->pad > upper) return true;
    if (hi[h->other[side]] - h->middle[side] + h->pad < lower) return true;
  }

  return false;
}
