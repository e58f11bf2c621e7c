/* Exercise 14: a box over an interval of time, and the refit of a tree with two keys. Fill in both functions, then
   make course-check N=14 FILE=mine_14.c */
#include "14_exercise.h"

/* Returns a box that holds everything that moves in a node from time `begin` to time `end`, 0 <= begin <= end <= 1.

   key[0]  the node's box at time 0
   key[1]  the node's box at time 1

   Each corner of a triangle below the node lies in key[0] at time 0 and in key[1] at time 1. In between the corner is
   where motion_vertex() says, in floats. The box must hold the corner at each float time from `begin` to `end`, and may
   be larger than in real numbers by 2^-20 of the largest coordinate of the two keys, axis by axis. */
course_box motion_box(const course_box key[2], float begin, float end) {
  (void)begin; /* write here */
  (void)end;
  return key[0];
}

/* Makes the boxes of all nodes anew, at both keys, after the vertices have got new positions at both keys.

   order, first, count and child stay as they are. The boxes must be exact: no number is rounded here. Ask for the box
   of each triangle once at each key: motion_triangle_box(scene, triangle, key). */
void motion_refit(motion_tree *tree, const motion_scene *scene) {
  (void)tree; /* write here */
  (void)scene;
}
