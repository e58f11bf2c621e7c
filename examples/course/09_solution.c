/* A solution of the exercise of chapter 9. */
#include "09_exercise.h"

/* Interpolates in double, whose error is far below a float's last place, and rounds outwards where it was rounded inwards.
   What double itself rounds off is at most 2^-51 of the larger corner: the margin holds it. */
void box_at(const course_box *first, const course_box *last, float time, course_box *now) {
  for (int a = 0; a < 3; a++) {
    const double t = (double)time;
    const double lo0 = (double)first->lo.at[a], lo1 = (double)last->lo.at[a], lo = (1 - t) * lo0 + t * lo1;
    const double hi0 = (double)first->hi.at[a], hi1 = (double)last->hi.at[a], hi = (1 - t) * hi0 + t * hi1;
    const double lo_margin = 1e-15 * fmax(fabs(lo0), fabs(lo1)), hi_margin = 1e-15 * fmax(fabs(hi0), fabs(hi1));
    now->lo.at[a] = (float)(lo - lo_margin), now->hi.at[a] = (float)(hi + hi_margin);
    if ((double)now->lo.at[a] > lo - lo_margin) now->lo.at[a] = nextafterf(now->lo.at[a], -INFINITY);
    if ((double)now->hi.at[a] < hi + hi_margin) now->hi.at[a] = nextafterf(now->hi.at[a], INFINITY);
  }
}

/* A way that is chosen with the probability that is its weight has the weight 1 in the estimate. */
float radiance_of_one(const pktrt_scene *scene, pktrt_ray ray, uint32_t *random) {
  for (int depth = 0;; depth++) {
    const glass met = glass_trace(scene, &ray);
    if (met.sky) return met.radiance;
    if (depth == GLASS_DEPTH) return 0;
    ray = course_random(random) < met.reflectance ? met.reflected : met.refracted;
  }
}
