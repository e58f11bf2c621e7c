/* Exercise of chapter 9: boxes that move, and one ray in, one ray out.

     cp examples/course/09_exercise.c mine.c
     make course-check N=9 FILE=mine.c */
#include "09_exercise.h"

/* A box holds things that move along straight lines: `first` at time 0, `last` at time 1. Sets *now to a box that holds them
   at `time`, in [0,1]: no larger than it must be, but never smaller, though floats are rounded. Vertices move on
   (1 - time) p0 + time p1, as real numbers. (nextafterf(x, INFINITY) is the next float above x.) */
void box_at(const course_box *first, const course_box *last, float time, course_box *now) {
  (void)first, (void)time;
  *now = *last;
}

/* Returns an estimate of the radiance along a ray: where it meets glass, ONE of the two rays goes on, so glass_trace is called
   once for each ray, the last one included. The mean over many estimates must be what comes out if both are followed, weighted by
   reflectance and 1 - reflectance. course_random(random) is a number in [0,1). Mind GLASS_DEPTH, and that
   there is no refracted ray where reflectance is 1. */
float radiance_of_one(const pktrt_scene *scene, pktrt_ray ray, uint32_t *random) {
  (void)scene, (void)ray, (void)random;
  return 0;
}
