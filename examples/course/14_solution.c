/* A solution of exercise 14. */
#include "14_exercise.h"

/* Returns a box that holds everything that moves in a node from time `begin` to time `end`. Planes move along straight
   lines, so they are extreme at the ends. The margin is for six roundings, three of a corner and three of a plane. */
course_box motion_box(const course_box key[2], float begin, float end) {
  course_box box;

  for (int axis = 0; axis < 3; axis++) {
    const float lo0 = key[0].lo.at[axis], lo1 = key[1].lo.at[axis];
    const float hi0 = key[0].hi.at[axis], hi1 = key[1].hi.at[axis];
    const float margin = 8.0f / 16777216;
    const float lo_margin = margin * fmaxf(fabsf(lo0), fabsf(lo1));
    const float hi_margin = margin * fmaxf(fabsf(hi0), fabsf(hi1));
    box.lo.at[axis] = fminf(motion_mix(lo0, lo1, begin), motion_mix(lo0, lo1, end)) - lo_margin;
    box.hi.at[axis] = fmaxf(motion_mix(hi0, hi1, begin), motion_mix(hi0, hi1, end)) + hi_margin;
  }

  return box;
}

/* Makes the boxes of all nodes anew, at both keys. Children have greater numbers than their
   parents and so come first. */
void motion_refit(motion_tree *tree, const motion_scene *scene) {
  for (uint32_t i = tree->nodes; i-- > 0;) {
    motion_node *node = &tree->node[i];

    for (int key = 0; key < 2; key++) {
      course_box all = course_box_empty();

      for (uint32_t k = 0; k < 2 && node->child[0]; k++) {
        const course_box *child = &tree->node[node->child[k]].key[key];
        all = course_box_grow(all, child->lo, child->hi);
      }

      for (uint32_t k = node->first; k < node->first + node->count && !node->child[0]; k++) {
        const course_box one = motion_triangle_box(scene, tree->order[k], key);
        all = course_box_grow(all, one.lo, one.hi);
      }

      node->key[key] = all;
    }
  }
}
