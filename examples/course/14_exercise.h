/* 14_exercise.h - what the exercise of chapter 14 is given, and what it gives. */
#ifndef COURSE_14_EXERCISE_H
#define COURSE_14_EXERCISE_H

#include "14_motion.h"

/* Returns the box of a triangle at key 0 or 1. Given by the check, which counts the calls. */
course_box motion_triangle_box(const motion_scene *scene, uint32_t triangle, int key);

/* Yours. */
course_box motion_box(const course_box key[2], float begin, float end);
void motion_refit(motion_tree *tree, const motion_scene *scene);

#endif /* COURSE_14_EXERCISE_H */
