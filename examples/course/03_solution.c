/* Exercise 3: the nearest hit of a ray, nearest child first. Fill in nearest_first(), then
   make course-check N=3 FILE=mine_03.c

   The chapter's walk takes the children in the order of their places, and opens every node that the ray enters when the
   node's parent is opened. Write a walk that opens fewer nodes:

     1. Test the children of a node by course_slabs_enter(), which also returns the depth at which the ray enters a box.
     2. Continue with the nearest child, be it a node or a leaf. The others wait on a stack, the nearest on top. (Leaves
        on the stack save triangle tests; the number of opened nodes does not depend on them.)
     3. Drop a child that is popped when its depth is beyond slabs.last: a hit has made the ray too short for the child.
        (Compare with slabs.last, not with hit.t: depths are not t.)

   Read nodes by open_node() only: the check counts its calls for nodes other than the root. */
#include "course.h"

/* The check has open_node(); you write nearest_first(). */
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
