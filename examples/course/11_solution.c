/* A solution of exercise 11: the rays that leave mirror and glass. The program of the chapter includes this file. */
#include "11_picture.h"

/* Returns the unpolarised reflectance of glass, from the cosines of both rays; eta is the index behind the surface over
   the index before it. */
static float reflectance_of(float cosine, float cosine_behind, float eta) {
  const float perpendicular = (cosine - eta * cosine_behind) / (cosine + eta * cosine_behind);
  const float parallel = (eta * cosine - cosine_behind) / (eta * cosine + cosine_behind);
  return (perpendicular * perpendicular + parallel * parallel) / 2;
}

/* Finds the ways on from a surface and returns how many there are: see 11_picture.h. */
uint32_t picture_scatter(const picture_material *material, vec direction, vec normal, picture_way way[2]) {
  const bool inside = vec_dot(direction, normal) > 0;
  const vec facing = inside ? vec_scale(normal, -1) : normal;
  const float cosine = fminf(1, -vec_dot(direction, facing));

  if (material->mirror <= 0 && material->ior <= 0) return 0;
  way[0].type = PKTRT_RAY_REFLECTION;
  way[0].direction = vec_unit(vec_add(direction, vec_scale(facing, 2 * cosine)));
  way[0].share = material->mirror;
  if (material->ior <= 0) return 1;

  const float eta = inside ? 1 / material->ior : material->ior;
  const float square = 1 - (1 - cosine * cosine) / (eta * eta); /* of the cosine behind the surface */
  way[0].share = 1;
  if (square <= 0) return 1;

  const float behind = sqrtf(square);
  const vec along = vec_scale(direction, 1 / eta);
  way[0].share = reflectance_of(cosine, behind, eta);
  way[1].type = PKTRT_RAY_REFRACTION;
  way[1].direction = vec_unit(vec_add(along, vec_scale(facing, cosine / eta - behind)));
  way[1].share = 1 - way[0].share;
  return 2;
}
