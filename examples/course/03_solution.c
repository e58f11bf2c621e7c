/* Exercise 3: the nearest hit of a ray, nearest child first. Fill in nearest_first(), then
   make course-check N=3 FILE=mine_03.c

   The chapter's walk takes children as they stand as they come, and opens all that the ray enters at the time. Write
   one that opens fewer:

     1. Test the children of a node by course_slabs_enter(), which also tells at which depth the ray enters their boxes.
     2. Go on with the nearest child, be it a node or a leaf; the others wait, the farther the longer. (That
        leaves take part in this saves triangles; the number of nodes does not depend on it.)
     3. Drop a child whose turn comes when the ray has become too short for it: its depth is beyond slabs.last. (Not
        beyond hit.t: depths are not t.)

   Nodes are had from open_node() alone: the check counts how often you ask for one that is not the root. */
#include "course.h"

/* The check has these two: the first is called, the second is yours. */
const pktrt_node *open_node(uint32_t index);
course_hit nearest_first(const course_scene *scene, course_ray ray);

/* A child that waits for its turn, and the depth at which the ray enters its box. */
typedef struct waiting {
  const pktrt_node *parent;
  int place;
  float depth;
} waiting;

course_hit nearest_first(const course_scene *scene, course_ray ray) {
  course_hit hit = {ray.tmax, 0, 0, COURSE_NONE};
  course_slabs slabs = course_slabs_make(open_node(0), ray);
  waiting stack[38 * 7 + 8];
  const pktrt_node *node = open_node(0);
  for (uint32_t top = 0;;) {
    const uint32_t bottom = top;
    for (int k = 0; node && k < 8; k++) { /* the nearest child goes on top */
      waiting w = {node, k, 0};
      if (node->child[k] == PKTRT_NONE || !course_slabs_enter(&slabs, node->lo[k], node->hi[k], &w.depth)) continue;
      uint32_t at = top++;
      for (; at > bottom && stack[at - 1].depth < w.depth; at--) stack[at] = stack[at - 1];
      stack[at] = w;
    }
    if (!top) return hit;
    const waiting next = stack[--top];
    node = NULL;
    if (next.depth > slabs.last) continue;
    if (!next.parent->leaf[next.place]) node = open_node(next.parent->child[next.place]);
    else
      for (int i = 0; i < 8; i++) {
        const uint32_t triangle = next.parent->triangle[next.place][i];
        if (triangle != PKTRT_NONE) course_slabs_meet(&slabs, scene, ray, triangle, &hit);
      }
  }
}
