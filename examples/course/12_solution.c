/* Exercise 12: a concentric disk, and a Phong lobe above a surface that loses no ray. Fill in disk_of() and
   lobe_above(), then
   make course-check N=12 FILE=mine_12.c */
#include "12_mapping.h"

/* Maps the square to the unit disk concentrically: the square with corners (0, 0) and (1, 1) becomes, by x = 2 u[0] - 1 and
   y = 2 u[1] - 1, one around the middle; each smaller square around the middle becomes a circle, whose radius is half the
   square's side. Points of one side of a square are spread evenly, by angle, over a quarter of the circle. The right side
   becomes the quarter around (1, 0), the upper side the quarter around (0, 1). The middle becomes the middle. */
void disk_of(const float u[2], float out[2]) {
  const double x = 2 * (double)u[0] - 1;
  const double y = 2 * (double)u[1] - 1;
  const bool wide = fabs(x) > fabs(y);
  const double radius = wide ? x : y;
  const double ratio = wide ? y / x : x / y;

  if (radius == 0) {
    out[0] = 0;
    out[1] = 0;
    return;
  }

  const double along = radius * cos(COURSE_TURN / 8 * ratio);
  const double across = radius * sin(COURSE_TURN / 8 * ratio);
  out[0] = (float)(wide ? along : across);
  out[1] = (float)(wide ? across : along);
}

/* Sets `out` to a direction of unit length for a sample u of the square, and returns the weight of the ray, at most 1. The
   unit axis is less than 90 degrees off the unit normal of the surface; the exponent n is 1 to 1,000,000.

   No direction may be below the surface, so dot(out, normal) >= 0, and no weight may be 0. For any function f of
   directions, the mean of weight f(out) over the square must be the mean of f over the Phong lobe, whose density is
   (n + 1) / (2 pi) cos^n of the angle to the axis, where f counts as 0 below the surface. Neighbours in the square must
   stay neighbours, and u = (0, 0) must go to a direction within the lobe. Compute in double: if n is large, a float has
   too few digits for the cosine. mapping_frame() has vectors across the axis. */
float lobe_above(const float u[2], const float axis[3], const float normal[3], float exponent, float out[3]) {
  const double n = (double)exponent;
  const double fall = expm1(log1p(-(double)u[0]) / (n + 1)); /* the cosine, less 1 */
  const double sine = sqrt(-fall * (2 + fall));
  const double angle = COURSE_TURN * (double)u[1];
  float side[3];
  float up[3];
  double direction[3];
  double height = 0;
  double cosine = 0;

  mapping_frame(axis, normal, side, up);
  for (int k = 0; k < 3; k++) {
    const double across = cos(angle) * (double)side[k] + sin(angle) * (double)up[k];
    direction[k] = (1 + fall) * (double)axis[k] + sine * across;
    height += direction[k] * (double)normal[k];
  }

  /* A direction below the surface becomes the mirror image of it above. */
  for (int k = 0; k < 3; k++) {
    if (height < 0) direction[k] -= 2 * height * (double)normal[k];
    cosine += direction[k] * (double)axis[k];
    out[k] = (float)direction[k];
  }

  /* Two points of the square come here: that of the direction and that of the mirror image, if the image is in the lobe. */
  const double image = cosine - 2 * fabs(height) * mapping_dot(axis, normal);
  const double ratio = image > 0 ? pow(image / cosine, n) : 0;
  return (float)(1 / (1 + ratio));
}
