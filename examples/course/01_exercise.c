/* Exercise 1: shadows. Fill in in_shadow(), then    make course-check N=1 FILE=mine_01.c */
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
  (void)scene, (void)point, (void)normal, (void)light;
  return false;
}
