/* 14_measure.h - what chapter 14 measures: vertices between their keys, areas of boxes, the cost of a tree. */
#ifndef COURSE_14_MEASURE_H
#define COURSE_14_MEASURE_H

#include "14_motion.h"

/* Prints the figure `name.kind.what`. */
EX_UNUSED static void measure_figure(
    const char *name, const char *kind, const char *what, const char *format, double value) {
  char full_name[64];
  snprintf(full_name, sizeof full_name, "%s.%s.%s", name, kind, what);
  course_figure(full_name, format, value);
}

/* Prints how far the knot shrinks on its straight ways if it turns by so many radians. */
EX_UNUSED static void measure_shrinking(double turn, const char *key) {
  const motion_scene things = motion_things(turn);
  double before = 0, halfway = 0;

  for (uint32_t i = MOTION_KNOT; i < MOTION_RING; i++) {
    const vec p = things.at[0].position[i], half = motion_vertex(&things, i, 0.5f);
    before += hypot((double)p.at[0] + 1.2, (double)p.at[2] + 0.2);
    halfway += hypot((double)half.at[0] + 1.2, (double)half.at[2] + 0.2);
  }

  printf("the knot turns by %.0f degrees: distance from its axis at time 1/2: %.3f of that at time 0\n",
      360 * turn / COURSE_TURN, halfway / before);
  measure_figure("turn", key, "distance", "%.3f", halfway / before);
}

/* Counts coordinates at rest that are rounded to another float, and coordinates that another formula rounds to another
   float. */
EX_UNUSED static void measure_vertices(void) {
  const motion_scene things = motion_things(COURSE_TURN / 6);
  uint32_t differ = 0, count = 0, off = 0, still = 0;

  for (uint32_t i = MOTION_KNOT; i < MOTION_RING; i++) {
    const vec p = things.at[0].position[i], q = things.at[1].position[i], now = motion_vertex(&things, i, 0.3f);
    const vec other = vec_add(p, vec_scale(vec_sub(q, p), 0.3f));
    for (int axis = 0; axis < 3; axis++) differ += now.at[axis] != other.at[axis];
    count += 3;
  }

  for (uint32_t i = MOTION_BALL; i < things.at[0].vertices; i++)
    for (int axis = 0; axis < 3; axis++) {
      const float rest = things.at[0].position[i].at[axis], now = motion_vertex(&things, i, 0.1f).at[axis];
      still++;
      if (now == rest || off++) continue;
      printf("a coordinate at rest: %.9g at both keys, %.9g at time 0.1\n", (double)rest, (double)now);
      course_figure("rest.keys", "%.9g", (double)rest);
      course_figure("rest.between", "%.9g", (double)now);
    }

  printf(
      "vertices of the ball, at rest: of %u coordinates %u are other floats at time 0.1 than at time 0\n", still, off);
  printf("vertices of the knot: of %u coordinates at time 0.3 the two formulas round %u to different floats\n", count,
      differ);
  course_figure("rest.coordinates", "%u", still);
  course_figure("rest.differ", "%u", off);
  course_figure("knot.coordinates", "%u", count);
  course_figure("knot.differ", "%u", differ);
}

/* Prints the areas of boxes at time 1/2, relative to boxes around the triangles as they are then. The knot turns by so
   many radians. */
EX_UNUSED static void measure_areas(double turn, const char *key) {
  const motion_scene things = motion_things(turn);
  const motion_tree tree = motion_build(&things);
  motion_scene half = things;
  double tight = 0, between = 0, whole = 0;
  half.at[0].position = (vec *)course_memory(half.at[0].vertices, sizeof(vec));
  for (uint32_t i = 0; i < half.at[0].vertices; i++) half.at[0].position[i] = motion_vertex(&things, i, 0.5f);

  for (uint32_t i = 0; i < tree.nodes; i++) {
    const course_box *box = tree.node[i].key;
    const course_box middle = {
        vec_scale(vec_add(box[0].lo, box[1].lo), 0.5f), vec_scale(vec_add(box[0].hi, box[1].hi), 0.5f)};
    tight += (double)course_box_area(motion_range_box(&tree, &half, i, 0));
    between += (double)course_box_area(middle);
    whole += (double)course_box_area(course_box_grow(box[0], box[1].lo, box[1].hi));
  }

  printf("the knot turns by %.0f degrees: areas of %u boxes at time 1/2, by those of boxes around the triangles at "
         "that time: interpolated %.2f, whole "
         "time %.2f\n",
      360 * turn / COURSE_TURN, tree.nodes, between / tight, whole / tight);
  measure_figure("turn", key, "boxes", "%.0f", tree.nodes);
  measure_figure("turn", key, "interpolated", "%.2f", between / tight);
  measure_figure("turn", key, "whole", "%.2f", whole / tight);
}

/* [over] */
/* Stores a node of the library's tree; its boxes hold what moves through them from time `begin` to time `end`. */
EX_UNUSED static void node_over(const pktrt_scene *library, uint32_t index, float begin, float end, pktrt_node *node) {
  pktrt_node other;
  pktrt_get_node(library, 0, index, begin, node);
  if (begin == end) return;
  pktrt_get_node(library, 0, index, end, &other);

  for (int i = 0; i < 24; i++) {
    node->lo[i / 3][i % 3] = fminf(node->lo[i / 3][i % 3], other.lo[i / 3][i % 3]);
    node->hi[i / 3][i % 3] = fmaxf(node->hi[i / 3][i % 3], other.hi[i / 3][i % 3]);
  }
}
/* [end] */

/* Returns true if a ray meets a box; the factor makes up for roundings. */
EX_UNUSED static bool meets_box(const pktrt_ray *ray, const float lo[3], const float hi[3]) {
  float enter = ray->tmin, leave = ray->tmax * 1.000001f;

  for (int axis = 0; axis < 3; axis++) {
    const float lower = (lo[axis] - ray->origin[axis]) / ray->direction[axis];
    const float upper = (hi[axis] - ray->origin[axis]) / ray->direction[axis];
    enter = fmaxf(enter, fminf(lower, upper));
    leave = fminf(leave, fmaxf(lower, upper) * 1.000001f);
  }

  return enter <= leave;
}

/* [count] */
/* Counts the boxes that a ray is tested against, if the ray knows from the beginning where it ends; adds the leaves
   that the ray enters. */
EX_UNUSED static uint32_t count_tests(
    const pktrt_scene *library, const pktrt_ray *ray, float begin, float end, double *leaves) {
  uint32_t stack[256] = {0}, waiting = 1, tests = 0;

  while (waiting > 0) {
    pktrt_node node;
    node_over(library, stack[--waiting], begin, end, &node);

    for (int k = 0; k < 8; k++) {
      if (node.child[k] == PKTRT_NONE) continue;
      tests++;
      if (!meets_box(ray, node.lo[k], node.hi[k])) continue;
      if (node.leaf[k]) *leaves += 1;
      else stack[waiting++] = node.child[k];
    }
  }

  return tests;
}
/* [end] */

/* [cost] */
/* Returns the cost of a tree by the surface area heuristic, at key 0: of a line through the root's box, the expected
   number of tests, two boxes for each inner node and all triangles of each leaf. */
EX_UNUSED static double sah_cost(const motion_tree *tree) {
  double sum = 0;

  for (uint32_t i = 0; i < tree->nodes; i++) {
    const motion_node *node = &tree->node[i];
    const double tests = node->child[0] ? 2 : node->count;
    sum += tests * (double)course_box_area(node->key[0]);
  }

  return sum / (double)course_box_area(tree->node[0].key[0]);
}
/* [end] */

enum { STILL_X = 80, STILL_Y = 60, STILL_RAYS = STILL_X * STILL_Y };

/* Returns the box tests per ray in a tree at rest. Rays know their ends if `known`; else their ends are stored. */
EX_UNUSED static double still_tests(const motion_scene *scene, const motion_tree *tree, float *end, bool known) {
  uint64_t boxes = 0;

  for (int i = 0; i < STILL_RAYS; i++) {
    const course_ray ray =
        course_camera_ray((float)(i % STILL_X) + 0.5f, (float)(i / STILL_X) + 0.5f, STILL_X, STILL_Y);
    motion_walk walk = {scene, tree, motion_first_key, ray, 0, 0, 0, {known ? end[i] : INFINITY, 0, 0, COURSE_NONE}, 0};
    motion_walk_node(&walk, 0);
    if (!known) end[i] = walk.hit.t * 1.000001f;
    boxes += walk.boxes;
  }

  return (double)boxes / (STILL_RAYS);
}

#endif /* COURSE_14_MEASURE_H */
