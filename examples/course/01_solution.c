/* A solution of exercise 1. */
#include "course.h"

/* Whether any triangle of the scene stands between a point of a surface and a light.

   point    where a ray met the surface, as nearly as floats have it
   normal   of unit length, to the side of the surface that the light is on
   light    where the light is

   The ray must not meet the surface that it leaves, so it begins 0.001 off the point, along the normal. It goes from
   where it begins, not from the point, to the light, and is there at t = 1: what stands behind the light casts no shadow.
   course_meet() in course.h is the test of a triangle from the chapter. Nothing needs to
   be the nearest here: the first triangle that is met settles the matter. */
bool in_shadow(const course_scene *scene, vec point, vec normal, vec light) {
  const vec start = vec_add(point, vec_scale(normal, 0.001f));
  const course_ray ray = {start, vec_sub(light, start), 0, 1}; /* at t = 1 it is at the light */
  course_hit hit = {ray.tmax, 0, 0, COURSE_NONE};
  for (uint32_t i = 0; i < scene->triangles; i++)
    if (course_meet(scene, &ray, i, &hit)) return true;
  return false;
}
