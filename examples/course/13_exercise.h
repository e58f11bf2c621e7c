/* 13_exercise.h - what the exercise of chapter 13 is given, and what it gives. */
#ifndef COURSE_13_EXERCISE_H
#define COURSE_13_EXERCISE_H

#include "course.h"

/* A packet. All rays have the same main axis, on which all directions have the same sign. They need not have a common
   origin, and on the two other axes their directions may have different signs. */
typedef struct hull_packet {
  const course_ray *rays; /* each from tmin >= 0 to tmax, which may be INFINITY */
  uint32_t n;             /* how many, 1 to 64 */
  int axis;               /* the main axis: the largest component of each direction in size */
  float sign;             /* of the directions on the main axis: 1 or -1 */
  course_box scene;       /* no box reaches out of it; rays may start or end outside */
  float pad; /* of chapter 3, the largest of the rays: boxes are widened by it, in floats by 16 e rho more */
} hull_packet;

/* Yours: the file of the answer defines `struct hull`. */
typedef struct hull hull;

hull *hull_make(const hull_packet *packet);
bool hull_misses(const hull *h, const float lo[3], const float hi[3]);

#endif /* COURSE_13_EXERCISE_H */
