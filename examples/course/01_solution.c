/* A solution of exercise 1. */
#include "course.h"

/* Returns true if a triangle of the scene lies between a point of a surface and a lamp.

   point    where a ray hit the surface, rounded to floats
   normal   the unit normal on the side of the surface that faces the lamp
   light    the position of the lamp

   The ray must not hit the surface that it leaves, so the ray begins 0.001 off the point, along the normal. The ray
   goes from there (not from the point) to the light and reaches the light at t = 1: a triangle behind the light casts
   no shadow. course_meet() in course.h is the chapter's test of a triangle. The first triangle that the ray hits
   decides: the hit need not be the nearest. */
bool in_shadow(const course_scene *scene, vec point, vec normal, vec light) {
  const vec start = vec_add(point, vec_scale(normal, 0.001f));
  const course_ray ray = {start, vec_sub(light, start), 0, 1}; /* at t = 1 it is at the light */
  course_hit hit = {ray.tmax, 0, 0, COURSE_NONE};
  for (uint32_t i = 0; i < scene->triangles; i++)
    if (course_meet(scene, &ray, i, &hit)) return true;
  return false;
}
