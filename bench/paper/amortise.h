/* amortise.h - part of paper.c: what the packets of the paper save, and which of our changes takes that away. Changes
   that are steps of the paper path are left out by the library itself. Others (eight lanes, eight children, large leaves,
   the order of pixels) are taken back in a packet traversal of our own here, in scalar C, which only counts. The library
   answers all rays; the answers of both must agree.

   Contents: trees, rays, walk, changes, counting, tables. */
#ifndef PAPER_AMORTISE_H
#define PAPER_AMORTISE_H

#include "system.h"

/* >>trees ---------------------------------------------------------------------------------------------------------- */

enum { MOST_CHILDREN = 8, OCTANTS = 8 };

typedef struct walk_child {
  float lo[3], hi[3];
  bool leaf;
  uint32_t first, count; /* a leaf's triangles; of an inner child `first` is the node */
  uint32_t beneath;      /* how many triangles are beneath it */
} walk_child;

typedef struct walk_node {
  walk_child child[MOST_CHILDREN];
  uint32_t children;
  uint8_t order[OCTANTS][MOST_CHILDREN]; /* for each octant of directions: the children from far to near */
} walk_node;

typedef struct walk_triangle {
  float corner[3][3];
} walk_triangle;

typedef struct walk_tree {
  walk_node *node; /* node 0 is the root */
  walk_triangle *triangle;
  uint32_t nodes, triangles, node_room, triangle_room;
} walk_tree;

static walk_tree make_tree(uint32_t node_room, uint32_t triangle_room) {
  walk_tree t;
  memset(&t, 0, sizeof t);
  t.node_room = node_room, t.triangle_room = triangle_room;
  t.node = (walk_node *)take(node_room, sizeof *t.node);
  t.triangle = (walk_triangle *)take(triangle_room, sizeof *t.triangle);
  return t;
}

static void free_tree(walk_tree *t) {
  free(t->node);
  free(t->triangle);
}

static uint32_t add_node(walk_tree *t) {
  if (t->nodes == t->node_room) fatal("more nodes than there is room for");
  return t->nodes++;
}

static void add_triangle(walk_tree *t, const walk_triangle *triangle) {
  if (t->triangles == t->triangle_room) fatal("more triangles than there is room for");
  t->triangle[t->triangles++] = *triangle;
}

/* Appends the triangles of a block, and makes `c` their leaf. */
static void copy_block(walk_tree *t, const pk_block *block, walk_child *c) {
  c->leaf = true;
  c->first = t->triangles;
  for (int lane = 0; lane < 8; lane++) {
    walk_triangle triangle;
    if (block->id[lane] == PKTRT_NONE) continue;
    for (int corner = 0; corner < 3; corner++)
      for (int a = 0; a < 3; a++) triangle.corner[corner][a] = block->vertex[corner][a][lane];
    add_triangle(t, &triangle);
  }
  c->count = c->beneath = t->triangles - c->first;
}

/* Copies a node of the library, whose children have been copied before. */
static void copy_node(walk_tree *t, const pk_bvh *bvh, uint32_t index) {
  const pk_node *from = pk_bvh_node(bvh, index);
  walk_node *to = &t->node[index];
  uint8_t place[8] = {0};

  for (uint32_t k = 0; k < 8; k++) {
    if (from->child[k] == PK_EMPTY) continue;
    walk_child *c = &to->child[to->children];
    for (int a = 0; a < 3; a++) c->lo[a] = from->plane[2 * a][k], c->hi[a] = from->plane[2 * a + 1][k];
    place[k] = (uint8_t)to->children++;
    if (from->child[k] & PK_LEAF) copy_block(t, pk_bvh_block(bvh, from->child[k] & ~PK_LEAF), c);
    else {
      const walk_node *below = &t->node[from->child[k]];
      c->first = from->child[k];
      for (uint32_t i = 0; i < below->children; i++) c->beneath += below->child[i].beneath;
    }
  }

  for (int octant = 0; octant < OCTANTS; octant++)
    for (uint32_t i = 0, at = 0; i < 8; i++) {
      const uint32_t k = from->order[octant] >> 3 * i & 7;
      if (from->child[k] != PK_EMPTY) to->order[octant][at++] = place[k];
    }
}

/* Returns the tree of a scene as the library has it: up to eight children, up to eight triangles in a leaf. */
static walk_tree copy_tree(const pktrt_scene *of) {
  const pk_bvh *bvh = &of->bvhs[0];
  if (of->direct_count != 1 || pk_has_instances(of) || bvh->key_count != 1)
    fatal("amortisation is counted in scenes of one tree at rest");
  walk_tree t = make_tree(bvh->node_count, bvh->block_count * 8);
  t.nodes = bvh->node_count;
  for (uint32_t n = bvh->node_count; n-- > 0;) copy_node(&t, bvh, n); /* children come after their parents */
  return t;
}

static walk_child empty_box(void) {
  walk_child c;
  memset(&c, 0, sizeof c);
  for (int a = 0; a < 3; a++) c.lo[a] = INFINITY, c.hi[a] = -INFINITY;
  return c;
}

static void grow_box(walk_child *box, const walk_child *by) {
  for (int a = 0; a < 3; a++) {
    box->lo[a] = fminf(box->lo[a], by->lo[a]);
    box->hi[a] = fmaxf(box->hi[a], by->hi[a]);
  }
  box->beneath += by->beneath;
}

/* Half the surface area. */
static double area_of(const walk_child *c) {
  double edge[3];
  for (int a = 0; a < 3; a++) edge[a] = (double)c->hi[a] - (double)c->lo[a];
  return edge[0] * edge[1] + edge[1] * edge[2] + edge[2] * edge[0];
}

static float middle_of(const walk_child *c, int axis) { return 0.5f * c->lo[axis] + 0.5f * c->hi[axis]; }

/* Sorts items by the middles of their boxes along an axis. */
static void sort_items(walk_child *item, uint32_t n, int axis) {
  for (uint32_t i = 1; i < n; i++)
    for (uint32_t k = i; k > 0 && middle_of(&item[k], axis) < middle_of(&item[k - 1], axis); k--) {
      const walk_child swap = item[k];
      item[k] = item[k - 1], item[k - 1] = swap;
    }
}

/* Splits 2 to 8 items in two parts where the surface area heuristic finds it cheapest, and sorts them so. Returns the
   size of the first part; *cost becomes the sum of the parts' areas times their triangles. */
static uint32_t split_items(walk_child *item, uint32_t n, double *cost) {
  walk_child best[MOST_CHILDREN];
  uint32_t size = 1;
  *cost = HUGE_VAL;
  for (int axis = 0; axis < 3; axis++) {
    sort_items(item, n, axis);
    for (uint32_t k = 1; k < n; k++) {
      walk_child part[2];
      part[0] = part[1] = empty_box();
      for (uint32_t i = 0; i < n; i++) grow_box(&part[i >= k], &item[i]);
      const double here = area_of(&part[0]) * part[0].beneath + area_of(&part[1]) * part[1].beneath;
      if (here < *cost || (axis == 0 && k == 1)) *cost = here, size = k, memcpy(best, item, n * sizeof *item);
    }
  }
  memcpy(item, best, n * sizeof *item);
  return size;
}

/* Fills in node `index`, which has two children, and returns what its parent holds of it. The nearer child is the one
   that rays meet first along the axis on which the children lie farthest apart (Wald et al. 2007). */
static walk_child set_pair(walk_tree *t, uint32_t index, const walk_child *one, const walk_child *two) {
  walk_node *node = &t->node[index];
  walk_child whole = empty_box();
  int axis = 0;
  float apart[3];
  for (int a = 0; a < 3; a++) apart[a] = middle_of(two, a) - middle_of(one, a);
  for (int a = 1; a < 3; a++)
    if (fabsf(apart[a]) > fabsf(apart[axis])) axis = a;

  node->children = 2;
  node->child[0] = *one, node->child[1] = *two;
  for (int octant = 0; octant < OCTANTS; octant++) {
    const bool negative = octant >> axis & 1;
    const bool one_is_near = (apart[axis] > 0) != negative;
    node->order[octant][0] = one_is_near; /* the farther one */
    node->order[octant][1] = !one_is_near;
  }
  grow_box(&whole, one);
  grow_box(&whole, two);
  whole.first = index;
  return whole;
}

/* Makes a leaf of the n triangles that `item` has in `from`, or splits them as long as that costs less, where testing a
   box costs as much as testing a triangle. */
static walk_child split_triangles(walk_tree *t, const walk_tree *from, walk_child *item, uint32_t n) {
  walk_child leaf = empty_box();
  for (uint32_t i = 0; i < n; i++) grow_box(&leaf, &item[i]);
  if (n > 1) {
    const double area = area_of(&leaf);
    double cost;
    const uint32_t size = split_items(item, n, &cost);
    if (2 * area + cost < area * n) {
      const uint32_t index = add_node(t);
      const walk_child one = split_triangles(t, from, item, size);
      const walk_child two = split_triangles(t, from, item + size, n - size);
      return set_pair(t, index, &one, &two);
    }
  }
  leaf.leaf = true;
  leaf.first = t->triangles, leaf.count = n;
  for (uint32_t i = 0; i < n; i++) add_triangle(t, &from->triangle[item[i].first]);
  return leaf;
}

/* Splits a leaf into small ones. Of a triangle's box counts the part within the leaf's box. */
static walk_child split_leaf(walk_tree *t, const walk_tree *from, const walk_child *leaf) {
  walk_child item[MOST_CHILDREN];
  for (uint32_t i = 0; i < leaf->count; i++) {
    const walk_triangle *triangle = &from->triangle[leaf->first + i];
    item[i] = empty_box();
    item[i].first = leaf->first + i, item[i].beneath = 1;
    for (int a = 0; a < 3; a++) {
      for (int corner = 0; corner < 3; corner++) {
        item[i].lo[a] = fminf(item[i].lo[a], triangle->corner[corner][a]);
        item[i].hi[a] = fmaxf(item[i].hi[a], triangle->corner[corner][a]);
      }
      item[i].lo[a] = fmaxf(item[i].lo[a], leaf->lo[a]);
      item[i].hi[a] = fminf(item[i].hi[a], leaf->hi[a]);
    }
  }
  return split_triangles(t, from, item, leaf->count);
}

/* Copies n children of a node of `from`, and all beneath them, with two children to a node; `small`: with small leaves. */
static walk_child pair_up(walk_tree *t, const walk_tree *from, const walk_child *child, uint32_t n, bool small) {
  walk_child item[MOST_CHILDREN];
  double cost;
  memcpy(item, child, n * sizeof *item);
  if (n > 1) {
    const uint32_t index = add_node(t), size = split_items(item, n, &cost);
    const walk_child one = pair_up(t, from, item, size, small);
    const walk_child two = pair_up(t, from, item + size, n - size, small);
    return set_pair(t, index, &one, &two);
  }
  if (!item->leaf) return pair_up(t, from, from->node[item->first].child, from->node[item->first].children, small);
  if (small && item->count) return split_leaf(t, from, item);

  walk_child leaf = *item;
  leaf.first = t->triangles;
  for (uint32_t i = 0; i < leaf.count; i++) add_triangle(t, &from->triangle[item->first + i]);
  return leaf;
}

/* Returns a tree with two children to a node, over the same leaves or over small ones. */
static walk_tree make_pairs(const walk_tree *from, bool small) {
  walk_tree t = make_tree(from->triangles + from->nodes * MOST_CHILDREN, from->triangles);
  pair_up(&t, from, from->node->child, from->node->children, small);
  return t;
}

/* >>rays ----------------------------------------------------------------------------------------------------------- */

/* A ray as the library sets it up: depths are distances along its main axis. */
typedef struct walk_ray {
  double origin[3], direction[3], inverse[3]; /* inverse: of the direction over its largest component */
  double major, near, far;                    /* that component; the depths between which hits are searched */
  double pad;                                 /* by which boxes are widened */
  int octant;
  bool valid;
  bool active; /* valid and, asked for occlusion, not occluded yet */
  bool meets;  /* the box that it was last tested against */
  bool hit;
} walk_ray;

/* Inlined, unlike fmin and fmax, which care for what is not a number. */
static double least(double a, double b) { return a < b ? a : b; }
static double most(double a, double b) { return a > b ? a : b; }

static void read_ray(const pk_batch *b, uint32_t i, walk_ray *r) {
  memset(r, 0, sizeof *r);
  for (int a = 0; a < 3; a++) {
    r->origin[a] = (double)b->o[a][i], r->direction[a] = (double)b->d[a][i];
    r->major = most(r->major, fabs(r->direction[a]));
  }
  for (int a = 0; a < 3; a++)
    r->inverse[a] = r->major / copysign(most(fabs(r->direction[a]), r->major * 1e-8), r->direction[a]);
  r->near = (double)b->tmin[i] * r->major, r->far = (double)b->tmax[i] * r->major;
  r->pad = (double)b->pad[i];
  r->octant = b->octant[i] & 7;
  r->valid = r->active = b->valid[i / 64] >> i % 64 & 1;
}

static bool ray_meets_box(const walk_ray *r, const walk_child *c) {
  double enter = r->near, leave = r->far;
  for (int a = 0; a < 3; a++) {
    const double slack = r->pad * fabs(r->inverse[a]);
    const double to_lo = ((double)c->lo[a] - r->origin[a]) * r->inverse[a];
    const double to_hi = ((double)c->hi[a] - r->origin[a]) * r->inverse[a];
    enter = most(enter, least(to_lo, to_hi) - slack);
    leave = least(leave, most(to_lo, to_hi) + slack);
  }
  return enter <= leave;
}

/* If the ray hits the triangle within its depths, ends it there and returns true (Moeller and Trumbore 1997). */
static bool ray_hits_triangle(walk_ray *r, const walk_triangle *triangle) {
  double e1[3], e2[3], s[3], p[3], q[3];
  for (int a = 0; a < 3; a++) {
    const double corner = (double)triangle->corner[0][a];
    e1[a] = (double)triangle->corner[1][a] - corner;
    e2[a] = (double)triangle->corner[2][a] - corner;
    s[a] = r->origin[a] - corner;
  }
  for (int a = 0; a < 3; a++) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    p[a] = r->direction[b] * e2[c] - r->direction[c] * e2[b];
    q[a] = s[b] * e1[c] - s[c] * e1[b];
  }
  const double det = e1[0] * p[0] + e1[1] * p[1] + e1[2] * p[2];
  const double u = (s[0] * p[0] + s[1] * p[1] + s[2] * p[2]) / det;
  const double v = (r->direction[0] * q[0] + r->direction[1] * q[1] + r->direction[2] * q[2]) / det;
  const double depth = (e2[0] * q[0] + e2[1] * q[1] + e2[2] * q[2]) / det * r->major;
  if (!(u >= 0 && v >= 0 && u + v <= 1 && depth > r->near && depth < r->far)) return false;
  r->far = depth;
  return r->hit = true;
}

/* >>walk ----------------------------------------------------------------------------------------------------------- */

/* A packet on its way through a tree, as the paper has it: the first active ray (and the rest of its group of lanes),
   interval arithmetic, the other rays; all rays from the first active one on are tested against the triangles of a
   leaf. */
typedef struct walk_packet {
  const walk_tree *tree;
  walk_ray *ray;
  uint32_t n, lanes;
  bool occlusion, leaf_boxes;
  double origin[3][2], inverse[3][2], near, far, pad; /* over the active rays: least and greatest */
  pktrt_counts *counts;
  uint64_t *interval_tests;
} walk_packet;

static uint32_t next_active(const walk_packet *p, uint32_t ray) {
  while (ray < p->n && !p->ray[ray].active) ray++;
  return ray;
}

/* The end of the group that a ray belongs to. */
static uint32_t group_end(const walk_packet *p, uint32_t ray) {
  const uint32_t end = (ray / p->lanes + 1) * p->lanes;
  return end < p->n ? end : p->n;
}

static void find_intervals(walk_packet *p) {
  p->near = INFINITY, p->far = -INFINITY, p->pad = 0;
  for (int a = 0; a < 3; a++) {
    p->origin[a][0] = p->inverse[a][0] = INFINITY;
    p->origin[a][1] = p->inverse[a][1] = -INFINITY;
  }
  for (uint32_t i = next_active(p, 0); i < p->n; i = next_active(p, i + 1)) {
    const walk_ray *r = &p->ray[i];
    for (int a = 0; a < 3; a++) {
      p->origin[a][0] = least(p->origin[a][0], r->origin[a]), p->origin[a][1] = most(p->origin[a][1], r->origin[a]);
      p->inverse[a][0] = least(p->inverse[a][0], r->inverse[a]),
      p->inverse[a][1] = most(p->inverse[a][1], r->inverse[a]);
    }
    p->near = least(p->near, r->near), p->far = most(p->far, r->far), p->pad = most(p->pad, r->pad);
  }
}

/* Hits have ended rays: the farthest of the active ones. */
static void find_farthest(walk_packet *p) {
  p->far = -INFINITY;
  for (uint32_t i = next_active(p, 0); i < p->n; i = next_active(p, i + 1)) p->far = most(p->far, p->ray[i].far);
}

/* Whether interval arithmetic shows that all rays miss a box. */
static bool intervals_miss(const walk_packet *p, const walk_child *c) {
  double enter = p->near, leave = p->far;
  ++*p->interval_tests;
  for (int a = 0; a < 3; a++) {
    const double *inverse = p->inverse[a];
    if (inverse[0] < 0 && inverse[1] > 0) continue; /* directions of both signs bound nothing */
    const bool forward = inverse[0] > 0;
    const double to_lo = (double)c->lo[a] - p->origin[a][1] - p->pad,
                 to_hi = (double)c->hi[a] - p->origin[a][0] + p->pad;
    const double to_near = forward ? to_lo : to_hi, to_far = forward ? to_hi : to_lo;
    enter = most(enter, least(to_near * inverse[0], to_near * inverse[1]));
    leave = least(leave, most(to_far * inverse[0], to_far * inverse[1]));
  }
  return enter > leave;
}

/* Tests the active rays [begin, end) of one group against a box, as one vector; returns the first that meets it, or n. */
static uint32_t test_rays(walk_packet *p, const walk_child *c, uint32_t begin, uint32_t end) {
  uint32_t found = p->n, tested = 0;
  for (uint32_t i = begin; i < end; i++) {
    walk_ray *r = &p->ray[i];
    if (!r->active) continue;
    tested++;
    r->meets = ray_meets_box(r, c);
    if (found == p->n && r->meets) found = i;
  }
  p->counts->box_tests += tested;
  p->counts->vector_box_tests += tested > 0;
  return found;
}

/* Returns the first active ray from `first` on that meets a child, or n. */
static uint32_t find_first(walk_packet *p, const walk_child *c, uint32_t first) {
  uint32_t end = group_end(p, first);
  uint32_t found = test_rays(p, c, first, end);
  if (found < p->n || end == p->n || intervals_miss(p, c)) return found;
  for (; found == p->n && end < p->n; end = group_end(p, end)) found = test_rays(p, c, end, group_end(p, end));
  return found;
}

static void walk_leaf(walk_packet *p, const walk_child *c, uint32_t first) {
  bool any = false;
  for (uint32_t begin = first; begin < p->n; begin = group_end(p, begin)) {
    const uint32_t end = group_end(p, begin);
    if (p->leaf_boxes && begin != first) test_rays(p, c, begin, end); /* the first group has just been tested */
    for (uint32_t k = c->first; k < c->first + c->count; k++) {
      uint32_t tested = 0;
      for (uint32_t i = begin; i < end; i++) {
        if (!p->ray[i].active || (p->leaf_boxes && !p->ray[i].meets)) continue;
        tested++;
        if (!ray_hits_triangle(&p->ray[i], &p->tree->triangle[k])) continue;
        any = true;
        if (p->occlusion) p->ray[i].active = false;
      }
      p->counts->triangle_tests += tested;
      p->counts->vector_triangle_tests += tested > 0;
    }
  }
  if (any) find_farthest(p);
}

static void trace_walk(walk_packet *p) {
  enum { ROOM = 1024 };
  struct {
    const walk_child *child;
    uint32_t first;
  } stack[ROOM];
  uint32_t top = 0, node = 0, first = next_active(p, 0);
  if (first == p->n) return;
  find_intervals(p);

  for (;;) {
    const walk_node *opened = &p->tree->node[node];
    if (top + opened->children > ROOM) fatal("a tree is deeper than there is room for");
    for (uint32_t i = 0; i < opened->children; i++, top++) {
      stack[top].child = &opened->child[opened->order[p->ray[first].octant][i]];
      stack[top].first = first;
    }

    /* Children are tested when their turn comes: rays may have become shorter. */
    for (bool entered = false; !entered;) {
      if (!top) return;
      const walk_child *c = stack[--top].child;
      first = next_active(p, stack[top].first);
      if (first < p->n) first = find_first(p, c, first);
      if (first == p->n) continue;
      if (c->leaf) walk_leaf(p, c, first);
      else node = c->first, entered = true;
    }
  }
}

/* >>changes --------------------------------------------------------------------------------------------------------- */

/* What is changed back, one thing after the other, until the paper's configuration is reached. The library counts the
   first three, the walk all others. CHECKED is not shown: there the walk counts what the library does at NO_TRIM. */
enum { WIDE, PAIRS, SMALL_LEAVES, TREES };
enum { AS_IT_IS, NO_FRUSTUM, NO_TRIM, CHECKED, FOUR_LANES, TWO_CHILDREN, SMALLER, IN_ROWS, OF_2007, FINER, CHANGES };
static const struct change {
  const char *what;
  uint32_t steps; /* of the library; 0: walked here */
  int tree;
  uint32_t lanes;
  bool leaf_boxes; /* rays are tested against the box of a leaf before its triangles */
  bool in_rows;    /* pixels of a packet */
  bool finer;      /* of half the width */
} changes[CHANGES] = {{"nothing: eight children, eight lanes, all steps", UINT32_MAX, WIDE, 8, true, false, false},
    {"no frustum", ~(uint32_t)PKTRT_PAPER_STEP_FRUSTUM, WIDE, 8, true, false, false},
    {"no end of the active range", ~(uint32_t)(PKTRT_PAPER_STEP_FRUSTUM | PKTRT_PAPER_STEP_TRIM), WIDE, 8, true, false,
        false},
    {"the same, walked", 0, WIDE, 8, true, false, false}, {"four lanes", 0, WIDE, 4, true, false, false},
    {"two children per node", 0, PAIRS, 4, true, false, false},
    {"leaves of fewer triangles", 0, SMALL_LEAVES, 4, true, false, false},
    {"pixels in rows", 0, SMALL_LEAVES, 4, true, true, false},
    {"no boxes of leaves: the paper's", 0, SMALL_LEAVES, 4, false, true, false},
    {"the same, of 4 times as many pixels", 0, SMALL_LEAVES, 4, false, true, true}};

/* >>counting ------------------------------------------------------------------------------------------------------- */

typedef enum packing { ALONE, QUADS, EIGHTS, PACKINGS } packing; /* rays alone, in packets of 2x2, of 8x8 */

typedef struct tally {
  pktrt_counts counts;
  uint64_t interval_tests;
} tally;

/* What is counted while a tap is open, and how rays are packed now. */
static struct recount {
  walk_tree tree[TREES];
  tally of[CHANGES][PACKINGS];
  uint32_t wanted; /* a bit for each change */
  packing packed;
  bool in_rows, finer;
  uint64_t answers, other_answers; /* of the walk: all, and those that are not the library's */
} recount;

/* In packets of 2x2 pixels, rows are Morton's order. */
static bool counts_now(int w) {
  return (recount.wanted >> w & 1) && changes[w].finer == recount.finer &&
         (recount.packed == QUADS || changes[w].in_rows == recount.in_rows);
}

/* Counts again how the library traces a batch, which stays as it is. */
static void count_in_library(const pk_query *call, const pk_batch *b, uint32_t begin, uint32_t end, int w, packing as) {
  static pk_batch copy;
  pktrt_query_desc desc = *call->desc;
  pk_query again = *call;
  copy = *b;
  desc.path = PKTRT_PATH_PAPER;
  desc.paper_steps = changes[w].steps;
  if (as == ALONE) desc.packet_size = 1;
  again.desc = &desc;
  again.counts = &recount.of[w][as].counts;
  tap.behind->trace(&again, &copy, begin, end);
}

/* Whether the library has another answer for ray i than the walk. */
static bool answers_differ(const pk_batch *b, uint32_t i, const walk_ray *r, bool occlusion) {
  const bool hit = b->slot[i] != PKTRT_NONE;
  const double theirs = (double)b->t[i], ours = r->far / r->major;
  if (hit != r->hit) return true;
  return hit && !occlusion && !(fabs(ours - theirs) <= 1e-4 * theirs);
}

/* Walks rays that the library has answered. */
static void count_in_walk(const pk_query *call, const pk_batch *b, uint32_t begin, uint32_t end, int w, packing as) {
  static walk_ray ray[PK_BATCH];
  const uint32_t n = end - begin, size = as == ALONE ? 1 : call->desc->packet_size;
  walk_packet p;
  memset(&p, 0, sizeof p);
  p.tree = &recount.tree[changes[w].tree];
  p.lanes = changes[w].lanes, p.leaf_boxes = changes[w].leaf_boxes;
  p.occlusion = call->occlusion;
  p.counts = &recount.of[w][as].counts;
  p.interval_tests = &recount.of[w][as].interval_tests;

  for (uint32_t i = 0; i < n; i++) read_ray(b, begin + i, &ray[i]);
  for (uint32_t i = 0; i < n; i += size) {
    p.ray = &ray[i];
    p.n = n - i < size ? n - i : size;
    for (uint32_t k = 0; k < p.n; k++) p.counts->rays += p.ray[k].active;
    trace_walk(&p);
  }

  for (uint32_t i = 0; i < n; i++) {
    if (!ray[i].valid) continue;
    recount.answers++;
    recount.other_answers += answers_differ(b, begin + i, &ray[i], call->occlusion);
  }
}

static void trace_recounted(const pk_query *call, pk_batch *b, uint32_t begin, uint32_t end) {
  for (int w = 0; w < CHANGES; w++) {
    if (!changes[w].steps || !counts_now(w)) continue;
    count_in_library(call, b, begin, end, w, recount.packed);
    if (recount.packed == EIGHTS) count_in_library(call, b, begin, end, w, ALONE);
  }
  tap.behind->trace(call, b, begin, end);
  for (int w = 0; w < CHANGES; w++) {
    if (changes[w].steps || !counts_now(w)) continue;
    count_in_walk(call, b, begin, end, w, recount.packed);
    if (recount.packed == EIGHTS) count_in_walk(call, b, begin, end, w, ALONE);
  }
}

/* Makes camera rays of 8x8 pixels row by row, where the library has Morton's order. Pixels of a packet get each other's
   colours, which no count depends on. */
static void camera_rays_in_rows(
    const pk_camera_plane *plane, const double *x, const double *y, pk_wave *wave, uint32_t first) {
  enum { EDGE = 8 };
  double across[8], down[8];
  for (uint32_t k = 0; k < 8; k++) {
    const uint32_t i = (first + k) % (EDGE * EDGE);
    uint32_t u = 0, v = 0; /* Morton's order: bits of both alternate */
    for (uint32_t bit = 0; bit < 3; bit++) u |= (i >> 2 * bit & 1) << bit, v |= (i >> (2 * bit + 1) & 1) << bit;
    across[k] = x[k] - u + i % EDGE;
    down[k] = y[k] - v + i / EDGE;
  }
  tap.behind->camera_rays(plane, across, down, wave, first);
}

static void recount_pictures(bench *b, const setup *as, packing packed, bool in_rows) {
  setup s = *as;
  uint64_t checksum;
  s.packet = packed == QUADS ? 2 : 8;
  recount.packed = packed, recount.in_rows = in_rows;
  tap_open(b->now.tree, trace_recounted);
  if (in_rows) tap.front.camera_rays = camera_rays_in_rows;
  run_once(b, &s, NULL, &checksum);
  tap_close(b->now.tree);
}

/* The pictures again with twice as many pixels a side, and as many tiles. */
static void recount_finer(bench *b, const setup *as) {
  float *const pixels = b->pixels;
  const unsigned size = b->given.size;
  setup s = *as;
  s.every *= 4;
  b->given.size = 2 * size;
  b->pixels = (float *)take((size_t)4 * size * size * 3, sizeof(float));
  recount.finer = true;
  recount_pictures(b, &s, QUADS, false);
  recount_pictures(b, &s, EIGHTS, true);
  free(b->pixels);
  b->pixels = pixels, b->given.size = size;
}

/* Fills in recount.of for a scene, of the changes in `wanted`, from as many frames of its camera path. */
static void recount_scene(bench *b, const char *name, unsigned frames, uint32_t wanted) {
  setup s = whitted(b, name);
  column(0, &s);
  s.frames = frames;
  memset(&recount, 0, sizeof recount);
  recount.wanted = wanted;
  open_setup(&b->now, &s);
  recount.tree[WIDE] = copy_tree(b->now.tree);
  recount.tree[PAIRS] = make_pairs(&recount.tree[WIDE], false);
  recount.tree[SMALL_LEAVES] = make_pairs(&recount.tree[WIDE], true);
  recount_pictures(b, &s, QUADS, false);
  recount_pictures(b, &s, EIGHTS, false);
  if (wanted >> IN_ROWS) recount_pictures(b, &s, EIGHTS, true);
  if (wanted >> FINER) recount_finer(b, &s);
  for (int i = 0; i < TREES; i++) free_tree(&recount.tree[i]);
  if (recount.other_answers * 1000 > recount.answers) fatal("the walk finds other hits than the library");
}

/* How many times as many tests of a ray and a box or triangle rays make alone as in packets of 8x8. */
static double fewer_tests_of(int w) {
  return tests_of(&recount.of[w][ALONE].counts) / tests_of(&recount.of[w][EIGHTS].counts);
}

static double vectors_per_ray(int w, packing as) {
  const pktrt_counts *c = &recount.of[w][as].counts;
  return per_ray(vector_tests(c), c);
}

/* >>tables --------------------------------------------------------------------------------------------------------- */

static void say_alone_and_packed(bench *b, uint64_t alone, uint64_t packed, double rays) {
  say(&b->out, " %.1f | %.1f | %.2fx |", (double)alone / rays, (double)packed / rays, (double)alone / (double)packed);
}

static void say_amortisation(bench *b, const char *name, int w) {
  const pktrt_counts *alone = &recount.of[w][ALONE].counts, *packed = &recount.of[w][EIGHTS].counts;
  const double quads = vectors_per_ray(w, QUADS), eights = vectors_per_ray(w, EIGHTS), rays = (double)alone->rays;
  say(&b->out, "| %s | %s |", name, changes[w].what);
  say_alone_and_packed(b, alone->box_tests, packed->box_tests, rays);
  say_alone_and_packed(b, alone->triangle_tests, packed->triangle_tests, rays);
  say(&b->out, " %.2fx | %.1f | %.1f | %.1f | %.2fx | %.2fx |\n", fewer_tests_of(w), vectors_per_ray(w, ALONE), quads,
      eights, vectors_per_ray(w, ALONE) / eights, quads / eights);
}

static void csv_amortisation(const bench *b, const char *name, int w) {
  static const char *const packings[PACKINGS] = {"alone", "2x2", "8x8"};
  for (int as = 0; as < PACKINGS; as++) {
    const pktrt_counts *c = &recount.of[w][as].counts;
    csv(&b->out, "%s,\"%s\",%s,%llu,%.4f,%.4f,%.4f,%.4f,", name, changes[w].what, packings[as],
        (unsigned long long)c->rays, per_ray(c->box_tests, c), per_ray(c->triangle_tests, c),
        per_ray(c->vector_box_tests, c), per_ray(c->vector_triangle_tests, c));
    if (changes[w].steps) csv(&b->out, "\n"); /* the library counts no tests by intervals */
    else csv(&b->out, "%.4f\n", per_ray(recount.of[w][as].interval_tests, c));
  }
}

static void amortisation(bench *b) {
  csv(&b->out, "scene,changed_back,packets,rays,box_tests_per_ray,triangle_tests_per_ray,vector_box_tests_per_ray,"
               "vector_triangle_tests_per_ray,interval_tests_per_ray\n");
  say(&b->out,
      "What is changed back, one after the other; tests per ray, every ray alone and in packets of 8x8, and how many "
      "times fewer these are:\n\n"
      "| scene | changed back | boxes: alone | 8x8 | fewer | triangles: alone | 8x8 | fewer | both: fewer "
      "| vector tests: alone | 2x2 | 8x8 | alone over 8x8 | 2x2 over 8x8 |\n"
      "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  for (int k = 0; k < 3; k++) {
    recount_scene(b, scenes[k], (b->given.frames + 1) / 2, ~0u); /* as many as section 3.1 has */
    for (int w = 0; w < CHANGES; w++) {
      csv_amortisation(b, scenes[k], w);
      if (w != CHECKED) say_amortisation(b, scenes[k], w);
    }
    fprintf(stderr, "%s: %s: %llu of %llu answers of the walk differ from the library's\n", b->out.name, scenes[k],
        (unsigned long long)recount.other_answers, (unsigned long long)recount.answers);
  }
  say(&b->out, "\n");
}

#endif /* PAPER_AMORTISE_H */
