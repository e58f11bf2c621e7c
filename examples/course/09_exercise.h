/* 09_exercise.h - what the exercise of chapter 9 is given, and what it gives. */
#ifndef COURSE_09_EXERCISE_H
#define COURSE_09_EXERCISE_H
#include "course.h"

/* What a ray meets in a world of glass. */
typedef struct glass {
  bool sky;          /* nothing: it sees the sky, and ends */
  float radiance;    /* of the sky there */
  float reflectance; /* else: the part of the light that is reflected; the rest is refracted */
  pktrt_ray reflected,
      refracted; /* the two rays that go on; where reflectance is 1 there is no refracted one (direction 0) */
} glass;

/* A path goes on at 8 surfaces. Where it meets a ninth it ends and brings nothing, but if it then sees the sky it brings
   that: up to 9 calls of glass_trace. */
enum { GLASS_DEPTH = 8 };

/* Given by the check, which counts the calls. */
glass glass_trace(const pktrt_scene *scene, const pktrt_ray *ray);

/* Yours. */
void box_at(const course_box *first, const course_box *last, float time, course_box *now);
float radiance_of_one(const pktrt_scene *scene, pktrt_ray ray, uint32_t *random);
#endif
