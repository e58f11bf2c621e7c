/* Exercise 5: one test in interval arithmetic for a whole packet. Fill in intervals_miss(), then
   make course-check N=5 FILE=mine_05.c

   course_bounds holds bounds for all rays: on each axis every origin lies in [o_lo, o_hi] and every reciprocal
   direction in [r_lo, r_hi], and every ray looks at depths from `first` to `last`. Return true only if no ray of such
   a packet can enter the box: if the least depth at which a ray can be inside all three slabs is greater than the
   largest.

   Leave out an axis whose r_lo and r_hi have different signs: the text explains why its bounds exclude no box. Widen
   the box by pad, as course_slabs_enter() does for one ray. */
#include "course.h"

/* The check calls this function. */
bool intervals_miss(const course_bounds *p, const float lo[3], const float hi[3]);

bool intervals_miss(const course_bounds *p, const float lo[3], const float hi[3]) {
  float enter = p->first, leave = p->last;
  for (int a = 0; a < 3; a++) {
    const bool up = p->r_lo[a] > 0;
    if (!up && p->r_hi[a] >= 0) continue;
    const float below = lo[a] - p->o_hi[a] - p->pad, above = hi[a] - p->o_lo[a] + p->pad;
    const float near_ = up ? below : above, far_ = up ? above : below;
    enter = fmaxf(enter, fminf(near_ * p->r_lo[a], near_ * p->r_hi[a]));
    leave = fminf(leave, fmaxf(far_ * p->r_lo[a], far_ * p->r_hi[a]));
  }
  return enter > leave;
}
