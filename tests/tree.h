/* What only tree.c can see, for it holds the implementation. */
#ifndef PKTRT_TEST_TREE_H
#define PKTRT_TEST_TREE_H
#include "meshes.h"

/* NULL, or what is wrong with a tree of the scene: a bound that is not exact, a triangle that is not there once, ... */
const char *tree_fault(const pktrt_scene *);
/* How many of the points where edges of triangles cross sides of their leaves' boxes, so much smaller, lie in none of these; exact
   for vertices on grids of few bits, at rest. Adds to *points what was looked at. */
uint64_t tree_uncovered(const pktrt_scene *, float shrink, uint64_t *points);
/* How many triangles of blocks, models' included, are in another block, too. */
uint64_t tree_split(const pktrt_scene *);
/* How many bounds, of all children and keys and of the scene, are not those of the vertices that the world has now. The
   trees must be without fault, or have been so before the world's vertices changed. Adds to *compared what was looked
   at. */
uint64_t tree_bounds_off(const pktrt_scene *, const world *, uint64_t *compared);
/* The deepest leaf; the root's children have depth 1. */
uint32_t tree_depth(const pktrt_scene *);
/* Whether a lane of a leaf block of a group holds a triangle, and which, of which mesh. */
bool tree_lane(const pktrt_scene *, uint32_t group, uint32_t block, uint32_t lane, uint32_t *of, uint32_t *triangle);
uint32_t tree_groups(const pktrt_scene *);
/* Which of the eight slots of a node hold a child, as bits; 0: there is no such node. */
uint32_t tree_children(const pktrt_scene *, uint32_t group, uint32_t node);
/* What a ray that hits nothing has to look at, by itself: nodes, their children, triangles of leaves. `unsure` where it passes
   a box so near that rounding may decide. */
typedef struct tree_work {
  uint64_t nodes, boxes, triangles;
  bool unsure;
} tree_work;
tree_work tree_work_of(
    const pktrt_scene *, const pktrt_ray *, bool ask_groups); /* ask: whether it meets what moves, at all */
/* The same trees, asked by the kernels of another instruction set: large ones need not be built for each. */
void tree_asked_by(pktrt_scene *, pktrt_isa);

#endif
