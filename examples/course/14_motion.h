/* 14_motion.h - what program, exercise and check of chapter 14 share: triangles that move, a binary tree with a box at
   each of two keys, the walk of a ray.

   A key is a time at which positions are given: key 0 is time 0, key 1 is time 1. */
#ifndef COURSE_14_MOTION_H
#define COURSE_14_MOTION_H

#include "course.h"

/* [scene] */
/* Triangles that move. Both scenes have the same corners; their positions are those at time 0 and at time 1. */
typedef struct motion_scene {
  course_scene at[2];
} motion_scene;

/* Returns a number that moves evenly from `first` at time 0 to `last` at time 1. */
EX_UNUSED static float motion_mix(float first, float last, float time) { return (1 - time) * first + time * last; }
/* [end] */

/* Returns where a vertex is at a time. */
EX_UNUSED static vec motion_vertex(const motion_scene *scene, uint32_t vertex, float time) {
  const float *first = scene->at[0].position[vertex].at;
  const float *last = scene->at[1].position[vertex].at;
  vec now;
  for (int axis = 0; axis < 3; axis++) now.at[axis] = motion_mix(first[axis], last[axis], time);

  return now;
}

/* [meet] */
/* Returns true if a ray hits a triangle nearer than *hit, and records it there. */
EX_UNUSED static bool motion_meet(
    const motion_scene *scene, const course_ray *ray, float time, uint32_t triangle, course_hit *hit) {
  const uint32_t *corner = scene->at[0].corner[triangle];
  vec position[3];
  uint32_t corners[1][3] = {{0, 1, 2}};

  for (int i = 0; i < 3; i++) position[i] = motion_vertex(scene, corner[i], time);

  const course_scene now = {position, corners, 3, 1};
  if (!course_meet(&now, ray, 0, hit)) return false;
  hit->triangle = triangle;
  return true;
}
/* [end] */

/* [tree] */
typedef struct motion_node {
  course_box key[2];     /* around all triangles below: at time 0, and at time 1 */
  uint32_t first, count; /* the triangles below: order[first] and so on */
  uint32_t child[2];     /* both greater than the node's own number; 0, 0: the node is a leaf */
} motion_node;
/* [end] */

typedef struct motion_tree {
  uint32_t *order;   /* the triangles, leaf by leaf */
  motion_node *node; /* node 0 is the root */
  uint32_t nodes;
  uint64_t growths; /* how often the build has made a box hold another box */
} motion_tree;

/* Returns the box of a node at a key, from each of its triangles. */
EX_UNUSED static course_box motion_range_box(
    const motion_tree *tree, const motion_scene *scene, uint32_t node, int key) {
  const motion_node *n = &tree->node[node];
  course_box all = course_box_empty();

  for (uint32_t i = n->first; i < n->first + n->count; i++) {
    const course_box one = course_box_of(&scene->at[key], tree->order[i]);
    all = course_box_grow(all, one.lo, one.hi);
  }

  return all;
}

/* Makes the boxes of all nodes anew, at both keys, each box from all of its triangles. Returns how many boxes a refit
   from the leaves to the root would have made another box hold, at one key: each triangle once, each child once. */
EX_UNUSED static uint32_t motion_fit(motion_tree *tree, const motion_scene *scene) {
  uint32_t growths = 0;

  for (uint32_t i = 0; i < tree->nodes; i++) {
    motion_node *node = &tree->node[i];
    growths += node->child[0] ? 2 : node->count;
    for (int key = 0; key < 2; key++) node->key[key] = motion_range_box(tree, scene, i, key);
  }

  return growths;
}

/* >>build ---------------------------------------------------------------------------------------------------------- */

enum { MOTION_LEAF = 4, MOTION_BINS = 16 };

/* Where the bins of a node lie: `scale` bins per unit of length along an axis. */
typedef struct motion_bins {
  float begin, scale;
  int axis;
} motion_bins;

/* Returns the bin of a box, by its centre. */
static uint32_t motion_bin(const motion_bins *bins, const course_box *box) {
  const float centre = (box->lo.at[bins->axis] + box->hi.at[bins->axis]) / 2;
  const float bin = (centre - bins->begin) * bins->scale;
  return bin < MOTION_BINS - 1 ? (uint32_t)bin : MOTION_BINS - 1;
}

/* Returns the last bin of the left child, where the surface area heuristic costs least. */
static uint32_t motion_best_bin(const course_box *box, const uint32_t *count) {
  float right[MOTION_BINS];
  uint32_t best = 0, number = 0;
  float least = INFINITY;
  course_box grown = course_box_empty();

  for (uint32_t i = MOTION_BINS - 1; i > 0; i--) {
    grown = course_box_grow(grown, box[i].lo, box[i].hi);
    number += count[i];
    right[i] = number ? course_box_area(grown) * (float)number : 0;
  }

  grown = course_box_empty();
  number = 0;
  for (uint32_t i = 0; i + 1 < MOTION_BINS; i++) {
    grown = course_box_grow(grown, box[i].lo, box[i].hi);
    number += count[i];
    const float cost = (number ? course_box_area(grown) * (float)number : 0) + right[i + 1];
    if (cost >= least) continue;
    least = cost;
    best = i;
  }

  return best;
}

/* Arranges triangles in those of the left child and those of the right child; returns how many go left. Sixteen bins
   along the longest side of the box of all centres, as in Wald 2007. */
static uint32_t motion_divide(motion_tree *tree, const course_box *box, uint32_t *order, uint32_t count) {
  course_box centres = course_box_empty();
  course_box grown[MOTION_BINS];
  uint32_t number[MOTION_BINS] = {0};
  uint32_t left = 0;
  motion_bins bins = {0, 0, 0};

  for (uint32_t i = 0; i < count; i++) {
    const vec centre = vec_scale(vec_add(box[order[i]].lo, box[order[i]].hi), 0.5f);
    centres = course_box_grow(centres, centre, centre);
  }

  const vec size = vec_sub(centres.hi, centres.lo);
  for (int axis = 1; axis < 3; axis++)
    if (size.at[axis] > size.at[bins.axis]) bins.axis = axis;
  if (!(size.at[bins.axis] > 0)) return count / 2;

  bins.begin = centres.lo.at[bins.axis];
  bins.scale = MOTION_BINS / size.at[bins.axis];
  for (int i = 0; i < MOTION_BINS; i++) grown[i] = course_box_empty();

  for (uint32_t i = 0; i < count; i++) {
    const uint32_t bin = motion_bin(&bins, &box[order[i]]);
    grown[bin] = course_box_grow(grown[bin], box[order[i]].lo, box[order[i]].hi);
    number[bin]++;
  }

  tree->growths += count + 2 * (MOTION_BINS - 1);
  const uint32_t best = motion_best_bin(grown, number);

  for (uint32_t i = 0; i < count; i++) {
    const uint32_t triangle = order[i];
    if (motion_bin(&bins, &box[triangle]) > best) continue;
    order[i] = order[left];
    order[left++] = triangle;
  }

  return left;
}

/* Makes a node over triangles of the tree's order, and all nodes below it; returns its number. */
static uint32_t motion_build_node(
    motion_tree *tree, const motion_scene *scene, const course_box *box, uint32_t first, uint32_t count) {
  const uint32_t me = tree->nodes++;
  motion_node *node = &tree->node[me];
  node->first = first;
  node->count = count;
  node->child[0] = 0;
  node->child[1] = 0;

  for (int key = 0; key < 2; key++) node->key[key] = motion_range_box(tree, scene, me, key);

  tree->growths += count > MOTION_LEAF ? 2 : count;
  if (count <= MOTION_LEAF) return me;
  const uint32_t left = motion_divide(tree, box, tree->order + first, count);
  node->child[0] = motion_build_node(tree, scene, box, first, left);
  node->child[1] = motion_build_node(tree, scene, box, first + left, count - left);
  return me;
}

/* Returns a tree. The triangles' boxes that decide about its shape are those at time 1/2, between their keys. */
EX_UNUSED static motion_tree motion_build(const motion_scene *scene) {
  const uint32_t count = scene->at[0].triangles;
  course_box *box = (course_box *)course_memory(count, sizeof *box);
  motion_tree tree = {(uint32_t *)course_memory(count, sizeof *tree.order),
      (motion_node *)course_memory(2 * count, sizeof *tree.node), 0, 0};

  for (uint32_t i = 0; i < count; i++) {
    const course_box first = course_box_of(&scene->at[0], i);
    const course_box last = course_box_of(&scene->at[1], i);
    tree.order[i] = i;
    box[i].lo = vec_scale(vec_add(first.lo, last.lo), 0.5f);
    box[i].hi = vec_scale(vec_add(first.hi, last.hi), 0.5f);
  }

  motion_build_node(&tree, scene, box, 0, count);
  free(box);
  return tree;
}

/* >>walk ----------------------------------------------------------------------------------------------------------- */

/* Returns a box for the times from `begin` to `end`, from the boxes at two keys. */
typedef course_box motion_rule(const course_box key[2], float begin, float end);

/* [walk] */
/* A ray on its way. Boxes are those of the times from `begin` to `end`, triangles those of the ray's time. */
typedef struct motion_walk {
  const motion_scene *scene;
  const motion_tree *tree;
  motion_rule *rule;
  course_ray ray;
  float time, begin, end;
  course_hit hit; /* begins as {ray.tmax, 0, 0, COURSE_NONE} */
  uint64_t boxes; /* box tests */
} motion_walk;

/* Returns true if the ray enters a box. The factor makes up for the roundings of both sides. */
static bool motion_enter(const motion_walk *walk, const course_box *box) {
  float enter = walk->ray.tmin;
  float leave = walk->hit.t;

  for (int axis = 0; axis < 3; axis++) {
    const float inverse = 1 / walk->ray.direction.at[axis];
    const float lower = (box->lo.at[axis] - walk->ray.origin.at[axis]) * inverse;
    const float upper = (box->hi.at[axis] - walk->ray.origin.at[axis]) * inverse;
    enter = fmaxf(enter, signbit(inverse) ? upper : lower);
    leave = fminf(leave, (signbit(inverse) ? lower : upper) * 1.0000005f);
  }

  return enter <= leave;
}

/* Walks through a node and all below it. */
EX_UNUSED static void motion_walk_node(motion_walk *walk, uint32_t index) {
  const motion_node *node = &walk->tree->node[index];
  const course_box box = walk->rule(node->key, walk->begin, walk->end);
  walk->boxes++;
  if (!motion_enter(walk, &box)) return;

  if (node->child[0]) {
    motion_walk_node(walk, node->child[0]);
    motion_walk_node(walk, node->child[1]);
    return;
  }

  for (uint32_t i = node->first; i < node->first + node->count; i++)
    motion_meet(walk->scene, &walk->ray, walk->time, walk->tree->order[i], &walk->hit);
}
/* [end] */

/* Returns the box at key 0: a rule for things at rest. */
EX_UNUSED static course_box motion_first_key(const course_box key[2], float begin, float end) {
  (void)begin;
  (void)end;
  return key[0];
}

/* >>things --------------------------------------------------------------------------------------------------------- */

/* Returns a point turned around an upright axis through the origin, snapped to 2^-16: the same bits everywhere. */
EX_UNUSED static vec motion_turn(vec p, double angle) {
  const double x = (double)p.at[0], z = (double)p.at[2];
  const double turned[3] = {cos(angle) * x + sin(angle) * z, (double)p.at[1], cos(angle) * z - sin(angle) * x};
  vec q;
  for (int axis = 0; axis < 3; axis++) q.at[axis] = (float)(floor(turned[axis] * 65536 + 0.5137) / 65536);

  return q;
}

enum { MOTION_KNOT = 17 * 17, MOTION_RING = MOTION_KNOT + 97 * 9, MOTION_BALL = MOTION_RING + 29 * 15 };

/* Returns knot, ring and ball of the course's scene, without the ground. From time 0 to time 1 the knot turns around
   its middle by `turn` radians, the ring flies along a line, the ball stands still. */
EX_UNUSED static motion_scene motion_things(double turn) {
  const vec middle = {{-1.2f, 1.8f, -0.2f}};
  const vec flight = {{-1.25f, 0.75f, 1.5f}};
  motion_scene scene;
  course_scene *first = &scene.at[0];
  course_scene *last = &scene.at[1];
  *first = course_scene_make();
  first->corner += COURSE_GROUND;
  first->triangles -= COURSE_GROUND;
  *last = *first;
  last->position = (vec *)course_memory(first->vertices, sizeof *last->position);

  for (uint32_t i = 0; i < first->vertices; i++) {
    vec p = first->position[i];
    if (i >= MOTION_KNOT && i < MOTION_RING) p = vec_add(motion_turn(vec_sub(p, middle), turn), middle);
    if (i >= MOTION_RING && i < MOTION_BALL) p = vec_add(p, flight);
    last->position[i] = p;
  }

  return scene;
}

/* Returns the triangles of these things as flakes in the wind: each has three vertices of its own. Both keys are the
   same. */
EX_UNUSED static motion_scene motion_flakes(void) {
  const motion_scene things = motion_things(0);
  const course_scene *rest = &things.at[0];
  course_scene flakes = {NULL, NULL, 3 * rest->triangles, rest->triangles};
  flakes.position = (vec *)course_memory(flakes.vertices, sizeof *flakes.position);
  flakes.corner = (uint32_t(*)[3])course_memory(flakes.triangles, sizeof *flakes.corner);

  for (uint32_t i = 0; i < flakes.vertices; i++) {
    flakes.position[i] = rest->position[rest->corner[i / 3][i % 3]];
    flakes.corner[i / 3][i % 3] = i;
  }

  const motion_scene both = {{flakes, flakes}};
  return both;
}

/* Blows flakes around the upright axis, each without turning it; stores the new positions. The way of a flake is
   `angle` radians times its height at rest; at random: times a number from -1/2 to 1/2. */
EX_UNUSED static void motion_blow(const course_scene *rest, double angle, bool at_random, vec *position) {
  uint32_t state = 14;

  for (uint32_t i = 0; i < rest->vertices; i += 3) {
    const vec *p = &rest->position[i];
    const vec middle = vec_scale(vec_add(vec_add(p[0], p[1]), p[2]), 1.0f / 3);
    const double random = (double)course_random(&state) - 0.5;
    const vec way = vec_sub(motion_turn(middle, angle * (at_random ? random : (double)middle.at[1])), middle);
    for (uint32_t k = 0; k < 3; k++) position[i + k] = vec_add(p[k], way);
  }
}

/* Adds the triangles to a scene of the library, as one mesh with two keys. */
EX_UNUSED static void motion_add(pktrt_scene *library, const motion_scene *scene) {
  const uint32_t vertices = scene->at[0].vertices;
  vec *positions = (vec *)course_memory(2 * vertices, sizeof *positions);
  pktrt_mesh_desc mesh;
  memset(&mesh, 0, sizeof mesh);

  memcpy(positions, scene->at[0].position, vertices * sizeof *positions);
  memcpy(positions + vertices, scene->at[1].position, vertices * sizeof *positions);
  mesh.positions = positions[0].at;
  mesh.vertex_count = vertices;
  mesh.indices = scene->at[0].corner[0];
  mesh.triangle_count = scene->at[0].triangles;
  mesh.key_count = 2;

  if (!library || pktrt_add_mesh(library, &mesh, NULL)) {
    ex_fail("%s", pktrt_last_error(library));
    exit(1);
  }

  free(positions);
}

#endif /* COURSE_14_MOTION_H */
