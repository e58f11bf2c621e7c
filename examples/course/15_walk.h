/* 15_walk.h - a packet's walk in counts, down a tree with two or eight children to a node and with vectors of four or
   eight lanes: from the paper's way to the library's, change by change. */
#ifndef COURSE_15_WALK_H
#define COURSE_15_WALK_H

#include "15_table.h"

/* >>tree ----------------------------------------------------------------------------------------------------------- */

typedef struct walk_leaf { /* triangles first to first + count - 1 of the tree */
  uint32_t first, count;
} walk_leaf;

typedef struct walk_triangle {
  vec corner[3];
} walk_triangle;

typedef struct walk_node {
  uint32_t children;
  uint32_t child[8]; /* numbers of nodes or leaves */
  bool leaf[8];
  float lo[8][3], hi[8][3];
  uint8_t order[8][8]; /* for each octant of directions: children from near to far */
} walk_node;

typedef struct walk_tree {
  pktrt_node root; /* the library's, for course_slabs_make() */
  walk_node *node; /* node 0 is the root */
  walk_leaf *leaf;
  walk_triangle *triangle;
  uint32_t nodes, leaves, triangles;
} walk_tree;

/* Appends a leaf, with the triangles of child k of a node of the library. */
static uint32_t walk_add_leaf(walk_tree *tree, const scene *made, const pktrt_node *node, uint32_t k) {
  walk_leaf *leaf = &tree->leaf[tree->leaves];
  leaf->first = tree->triangles;

  for (uint32_t lane = 0; lane < 8; lane++) {
    if (node->triangle[k][lane] == PKTRT_NONE) continue;
    const scene_mesh *mesh = &made->meshes[node->mesh[k][lane]];
    const uint32_t *index = mesh->indices + 3 * (size_t)node->triangle[k][lane];
    for (int c = 0; c < 3; c++)
      memcpy(tree->triangle[tree->triangles].corner[c].at, mesh->positions + 3 * (size_t)index[c], sizeof(vec));
    tree->triangles++;
  }
  leaf->count = tree->triangles - leaf->first;
  return tree->leaves++;
}

/* Copies the library's tree, with its eight children to a node. */
EX_UNUSED static walk_tree walk_wide(const table_world *world) {
  walk_tree tree;
  uint32_t count;
  pktrt_node *theirs = course_library_nodes(world->library, &count);
  tree.root = theirs[0];
  tree.node = (walk_node *)course_memory(count, sizeof *tree.node);
  tree.leaf = (walk_leaf *)course_memory(8 * (size_t)count, sizeof *tree.leaf);
  tree.triangle = (walk_triangle *)course_memory(64 * (size_t)count, sizeof *tree.triangle);
  tree.nodes = count;
  tree.leaves = 0;
  tree.triangles = 0;

  for (uint32_t i = 0; i < count; i++) {
    uint32_t place[8]; /* of the library's children among ours, which has no gaps */
    walk_node *node = &tree.node[i];
    for (uint32_t k = 0; k < 8; k++) {
      if (theirs[i].child[k] == PKTRT_NONE) continue;
      const uint32_t to = place[k] = node->children++;
      memcpy(node->lo[to], theirs[i].lo[k], sizeof node->lo[to]);
      memcpy(node->hi[to], theirs[i].hi[k], sizeof node->hi[to]);
      node->leaf[to] = theirs[i].leaf[k];
      node->child[to] = node->leaf[to] ? walk_add_leaf(&tree, &world->made, &theirs[i], k) : theirs[i].child[k];
    }

    for (uint32_t octant = 0; octant < 8; octant++)
      for (uint32_t k = 0, n = 0; k < 8; k++) {
        const uint32_t next = theirs[i].order[octant][k];
        if (theirs[i].child[next] != PKTRT_NONE) node->order[octant][n++] = (uint8_t)place[next];
      }
  }
  free(theirs);
  return tree;
}

static course_box walk_child_box(const walk_node *node, uint32_t k) {
  course_box box;
  memcpy(box.lo.at, node->lo[k], sizeof box.lo.at);
  memcpy(box.hi.at, node->hi[k], sizeof box.hi.at);
  return box;
}

/* Returns the box around n children of a wide node. */
static course_box walk_around(const walk_node *wide, const uint32_t *list, uint32_t n) {
  course_box all = course_box_empty();
  for (uint32_t i = 0; i < n; i++) {
    const course_box box = walk_child_box(wide, list[i]);
    all = course_box_grow(all, box.lo, box.hi);
  }
  return all;
}

/* Divides n children of a wide node in two by the surface area heuristic of chapter 2: sorts the list along the best axis,
   which it returns, and stores how many come first. */
static int walk_divide(const walk_node *wide, uint32_t *list, uint32_t n, uint32_t *first) {
  course_box box[8];
  uint32_t best_list[8];
  double best = INFINITY;
  int best_axis = 0;

  for (uint32_t k = 0; k < wide->children; k++) box[k] = walk_child_box(wide, k);
  for (int axis = 0; axis < 3; axis++) {
    course_sort(box, axis, list, n);
    for (uint32_t k = 1; k < n; k++) {
      const course_box left = walk_around(wide, list, k), right = walk_around(wide, list + k, n - k);
      const double cost = (double)course_box_area(left) * k + (double)course_box_area(right) * (n - k);
      if (!(cost < best)) continue;
      best = cost;
      best_axis = axis;
      *first = k;
      memcpy(best_list, list, n * sizeof *list);
    }
  }
  memcpy(list, best_list, n * sizeof *list);
  return best_axis;
}

static void walk_pair(walk_tree *tree, uint32_t index, const walk_node *wide, uint32_t *list, uint32_t n);

/* Divides a leaf until each leaf has one triangle. Returns what becomes of it, and stores whether that is a leaf. */
static uint32_t walk_divide_leaf(walk_tree *tree, uint32_t number, bool *is_leaf) {
  const walk_leaf leaf = tree->leaf[number];
  uint32_t list[8] = {0, 1, 2, 3, 4, 5, 6, 7};
  walk_node all;
  *is_leaf = leaf.count == 1;
  if (*is_leaf) return number;

  memset(&all, 0, sizeof all);
  all.children = leaf.count;
  for (uint32_t k = 0; k < leaf.count; k++) {
    const walk_leaf one = {leaf.first + k, 1};
    const vec *corner = tree->triangle[one.first].corner;
    course_box box = course_box_grow(course_box_empty(), corner[0], corner[1]);
    box = course_box_grow(box, corner[2], corner[2]);
    memcpy(all.lo[k], box.lo.at, sizeof all.lo[k]);
    memcpy(all.hi[k], box.hi.at, sizeof all.hi[k]);
    all.leaf[k] = true;
    all.child[k] = tree->leaves;
    tree->leaf[tree->leaves++] = one;
  }
  const uint32_t root = tree->nodes++;
  walk_pair(tree, root, &all, list, leaf.count);
  return root;
}

/* Makes node `index` of a tree with two children to a node, above n children of a wide node. */
static void walk_pair(walk_tree *tree, uint32_t index, const walk_node *wide, uint32_t *list, uint32_t n) {
  uint32_t first = n;
  const int axis = n > 1 ? walk_divide(wide, list, n, &first) : 0;
  walk_node *node = &tree->node[index];
  node->children = n > 1 ? 2 : 1;

  for (uint32_t k = 0; k < node->children; k++) {
    uint32_t *part = k ? list + first : list;
    const uint32_t size = k ? n - first : first;
    const course_box box = walk_around(wide, part, size);
    memcpy(node->lo[k], box.lo.at, sizeof node->lo[k]);
    memcpy(node->hi[k], box.hi.at, sizeof node->hi[k]);
    node->child[k] = size > 1 ? tree->nodes++ : wide->child[part[0]];
    if (size > 1) walk_pair(tree, node->child[k], wide, part, size);
    else if (wide->leaf[part[0]]) node->child[k] = walk_divide_leaf(tree, node->child[k], &node->leaf[k]);
  }

  for (uint32_t octant = 0; octant < 8; octant++) {
    const uint8_t backwards = (uint8_t)(octant >> axis & 1);
    node->order[octant][0] = n > 1 ? backwards : 0;
    node->order[octant][1] = (uint8_t)!backwards;
  }
}

/* Returns a tree as the paper may have had it: with two children to a node, and one triangle to a leaf. Each wide node
   becomes up to seven nodes, of which the first keeps its number. */
EX_UNUSED static walk_tree walk_binary(const walk_tree *wide) {
  walk_tree tree = *wide;
  const size_t room = 8 * (size_t)wide->nodes + 2 * (size_t)wide->triangles;
  tree.node = (walk_node *)course_memory(room, sizeof *tree.node);
  tree.leaf = (walk_leaf *)course_memory((size_t)wide->leaves + wide->triangles, sizeof *tree.leaf);
  memcpy(tree.leaf, wide->leaf, wide->leaves * sizeof *tree.leaf);

  for (uint32_t i = 0; i < wide->nodes; i++) {
    uint32_t list[8] = {0, 1, 2, 3, 4, 5, 6, 7};
    walk_pair(&tree, i, &wide->node[i], list, wide->node[i].children);
  }
  return tree;
}

EX_UNUSED static void walk_free(walk_tree *wide, walk_tree *binary) {
  free(binary->node);
  free(binary->leaf);
  free(wide->node);
  free(wide->leaf);
  free(wide->triangle);
}

/* >>rays ----------------------------------------------------------------------------------------------------------- */

typedef struct walk_rays { /* the rays of packets, as a render had them */
  course_ray *ray;
  uint32_t *x, *y; /* pixels */
  uint32_t *end;   /* of packets */
  bool *shadow;    /* packets that look for any hit */
  uint32_t rays, packets, room;
} walk_rays;

EX_UNUSED static void walk_record(void *user, const pktrt_packet *packet) {
  walk_rays *to = (walk_rays *)user;
  if (to->rays + packet->n > to->room) {
    to->room = 2 * to->room + 65536;
    to->ray = (course_ray *)realloc(to->ray, to->room * sizeof *to->ray);
    to->x = (uint32_t *)realloc(to->x, to->room * sizeof *to->x);
    to->y = (uint32_t *)realloc(to->y, to->room * sizeof *to->y);
    to->end = (uint32_t *)realloc(to->end, to->room * sizeof *to->end);
    to->shadow = (bool *)realloc(to->shadow, to->room * sizeof *to->shadow);
    if (!to->ray || !to->x || !to->y || !to->end || !to->shadow) {
      ex_fail("out of memory");
      exit(1);
    }
  }

  for (uint32_t i = 0; i < packet->n; i++, to->rays++) {
    course_ray *ray = &to->ray[to->rays];
    for (int axis = 0; axis < 3; axis++) {
      ray->origin.at[axis] = packet->origin[axis][i];
      ray->direction.at[axis] = packet->direction[axis][i];
    }
    /* A shadow ray ends just before its lamp, at t = 1; the direction to a sun has unit length. */
    const float length = sqrtf(vec_dot(ray->direction, ray->direction));
    ray->tmin = 0;
    ray->tmax = packet->type == PKTRT_RAY_SHADOW && fabsf(length - 1) > 1e-4f ? 1 - 1.0f / (1 << 22) : INFINITY;
    to->x[to->rays] = packet->x[i];
    to->y[to->rays] = packet->y[i];
  }
  to->shadow[to->packets] = packet->type == PKTRT_RAY_SHADOW;
  to->end[to->packets++] = to->rays;
}

EX_UNUSED static void walk_rays_free(walk_rays *rays) {
  free(rays->ray);
  free(rays->x);
  free(rays->y);
  free(rays->end);
  free(rays->shadow);
}

/* >>walk ----------------------------------------------------------------------------------------------------------- */

/* [way] */
/* A way to trace packets: in these five things the paper's and ours differ in counts. */
typedef struct walk_way {
  const char *name;
  uint32_t lanes;  /* of a vector: 4 or 8 */
  bool morton;     /* rays of a packet in Morton's order; else row by row */
  bool trim;       /* looks for the end of the active range */
  bool leaf_boxes; /* tests rays against the box of a leaf before its triangles */
  bool eight;      /* children to a node; else two */
} walk_way;
/* [end] */

typedef struct walk {
  const walk_tree *tree;
  const walk_way *way;
  uint32_t n, last; /* rays; the end of the active range */
  course_ray ray[256];
  course_slabs slabs[256];
  bool active[256]; /* not occluded yet */
  bool shadow;
  course_bounds bounds;
  table_counts *counts;
} walk;

/* Returns the first active ray from `ray` on, or `end` if there is none before. */
static uint32_t walk_next(const walk *w, uint32_t ray, uint32_t end) {
  while (ray < end && !w->active[ray]) ray++;
  return ray;
}

/* Tests the group of `ray` against a box, from `from` on. Returns the first ray that enters, or w->n; stores which ray
   enters. */
static uint32_t walk_group(
    walk *w, uint32_t ray, uint32_t from, const float lo[3], const float hi[3], bool entering[8]) {
  const uint32_t lanes = w->way->lanes, begin = ray / lanes * lanes;
  uint32_t first = w->n;
  w->counts->box_vectors++;

  for (uint32_t i = 0; i < lanes; i++) {
    const uint32_t r = begin + i;
    entering[i] = false;
    if (r >= w->n || r < from || !w->active[r]) continue;
    w->counts->boxes++;
    entering[i] = course_slabs_enter(&w->slabs[r], lo, hi, NULL);
    if (entering[i] && first == w->n) first = r;
  }
  return first;
}

/* Returns true if a group has an active ray. */
static bool walk_busy(const walk *w, uint32_t begin) {
  const uint32_t end = begin + w->way->lanes < w->n ? begin + w->way->lanes : w->n;
  return walk_next(w, begin, end) < end;
}

/* Returns true if interval arithmetic shows that all rays miss a box, as in chapter 5. */
static bool walk_misses(const course_bounds *b, const float lo[3], const float hi[3]) {
  float entry = b->first, leave = b->last;

  for (int axis = 0; axis < 3; axis++) {
    const bool forward = b->r_lo[axis] > 0;
    if (!forward && !(b->r_hi[axis] < 0)) continue;
    const float lower = lo[axis] - b->o_hi[axis] - b->pad, upper = hi[axis] - b->o_lo[axis] + b->pad;
    const float to_near = forward ? lower : upper, to_far = forward ? upper : lower;
    entry = fmaxf(entry, fminf(to_near * b->r_lo[axis], to_near * b->r_hi[axis]));
    leave = fminf(leave, fmaxf(to_far * b->r_lo[axis], to_far * b->r_hi[axis]));
  }
  return entry > leave;
}

/* Ends the active range behind the last group with a ray that enters, but not before the group of `ray`. */
static void walk_trim(walk *w, uint32_t ray, const float lo[3], const float hi[3]) {
  const uint32_t lanes = w->way->lanes;
  bool entering[8];
  for (uint32_t group = (w->last - 1) / lanes * lanes; group > ray; w->last = group, group -= lanes)
    if (walk_busy(w, group) && walk_group(w, group, 0, lo, hi, entering) < w->n) return;
}

/* Returns the first ray from `first` on that enters a box, or w->n. Stores which rays of its group enter. */
static uint32_t walk_find_first(walk *w, uint32_t first, const float lo[3], const float hi[3], bool entering[8]) {
  const uint32_t lanes = w->way->lanes;
  uint32_t ray = walk_group(w, first, first, lo, hi, entering);
  if (ray < w->n || walk_misses(&w->bounds, lo, hi)) return ray;

  for (uint32_t group = first / lanes * lanes + lanes; group < w->last && ray == w->n; group += lanes)
    if (walk_busy(w, group)) ray = walk_group(w, group, 0, lo, hi, entering);
  if (ray < w->n && w->way->trim) walk_trim(w, ray, lo, hi);
  return ray;
}

/* Tests a ray against a triangle. A hit shortens the ray; a shadow ray that has one is no longer active. */
static void walk_meet(walk *w, uint32_t r, const vec corner[3]) {
  const course_ray *ray = &w->ray[r];
  course_slabs *slabs = &w->slabs[r];
  const vec e = vec_sub(corner[1], corner[0]), f = vec_sub(corner[2], corner[0]), s = vec_sub(ray->origin, corner[0]);
  const vec p = vec_cross(ray->direction, f), q = vec_cross(s, e);
  const float det = vec_dot(e, p);
  if (det == 0) return;
  const float u = vec_dot(s, p) / det, v = vec_dot(ray->direction, q) / det, t = vec_dot(f, q) / det;
  if (!(u >= 0 && v >= 0 && u + v <= 1 && t > ray->tmin && t * slabs->scale < slabs->last && t < ray->tmax)) return;
  slabs->last = t * slabs->scale;
  if (w->shadow) w->active[r] = false;
}

/* Returns the axis along which a ray's direction is longest. */
static int walk_axis(const course_slabs *slabs) {
  int axis = 0;
  for (int a = 1; a < 3; a++)
    if (fabsf(slabs->r[a]) < fabsf(slabs->r[axis])) axis = a;
  return axis;
}

/* Tests a group of rays against the triangles of a leaf: a triangle at a time, or where the group's main axes differ a ray
   at a time. */
static void walk_triangles(walk *w, const walk_leaf *leaf, uint32_t begin, const bool among[8]) {
  const uint32_t lanes = w->way->lanes;
  uint32_t rays = 0;
  int axis = -1;
  bool agree = true;

  for (uint32_t i = 0; i < lanes && begin + i < w->n; i++) {
    const int mine = walk_axis(&w->slabs[begin + i]);
    agree = agree && (axis < 0 || axis == mine);
    axis = mine;
    if (among[i]) rays++;
  }
  if (!agree) {
    w->counts->triangle_vectors += rays * ((leaf->count + lanes - 1) / lanes);
    w->counts->triangles += rays * leaf->count;
  }

  for (uint32_t k = 0; k < leaf->count; k++) {
    uint32_t tested = 0;
    for (uint32_t i = 0; i < lanes; i++) {
      const uint32_t r = begin + i;
      if (!among[i] || !w->active[r]) continue;
      tested++;
      walk_meet(w, r, w->tree->triangle[leaf->first + k].corner);
    }
    if (!agree || !tested) continue;
    w->counts->triangle_vectors++;
    w->counts->triangles += tested;
  }
}

/* Tests the active range, from `first` on, in a leaf. `entering`: which rays of the first group enter its box. */
static void walk_into_leaf(
    walk *w, const walk_leaf *leaf, uint32_t first, const float lo[3], const float hi[3], const bool entering[8]) {
  const uint32_t lanes = w->way->lanes, begin = first / lanes * lanes;

  for (uint32_t group = begin; group < w->last; group += lanes) {
    bool among[8] = {false};
    if (!walk_busy(w, group)) continue;
    if (!w->way->leaf_boxes)
      for (uint32_t i = 0; i < lanes; i++) among[i] = group + i >= first && group + i < w->n && w->active[group + i];
    else if (group == begin) memcpy(among, entering, sizeof among);
    else (void)walk_group(w, group, 0, lo, hi, among);
    walk_triangles(w, leaf, group, among);
  }

  w->bounds.last = -INFINITY;
  for (uint32_t r = 0; r < w->n; r++)
    if (w->active[r]) w->bounds.last = fmaxf(w->bounds.last, w->slabs[r].last);
}

/* Opens a node whose first active ray is `first`, and enters its children from near to far. */
static void walk_open(walk *w, uint32_t index, uint32_t first) {
  const walk_node *node = &w->tree->node[index];
  const uint8_t *order = node->order[w->slabs[first].octant];
  const uint32_t last = w->last;
  w->counts->nodes++;

  for (uint32_t i = 0; i < node->children; i++) {
    const uint32_t k = order[i];
    bool entering[8] = {false};
    w->last = last;
    const uint32_t from = walk_next(w, first, last);
    if (from >= last) return;
    const uint32_t ray = walk_find_first(w, from, node->lo[k], node->hi[k], entering);
    if (ray == w->n) continue;
    if (node->leaf[k]) walk_into_leaf(w, &w->tree->leaf[node->child[k]], ray, node->lo[k], node->hi[k], entering);
    else walk_open(w, node->child[k], ray);
  }
}

/* Where a ray comes in a packet row by row. */
static int walk_compare(const void *a, const void *b) {
  const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
  return x < y ? -1 : x > y;
}

/* Traces rays [begin, end) of a list as one packet, and adds to the counts. */
static void walk_packet(walk *w, const walk_rays *rays, uint32_t begin, uint32_t end) {
  uint64_t key[256];
  w->n = w->last = end - begin;

  for (uint32_t i = 0; i < w->n; i++) {
    const uint64_t row = rays->y[begin + i], column = rays->x[begin + i];
    key[i] = (w->way->morton ? 0 : row << 36 | column << 16) | i;
  }
  qsort(key, w->n, sizeof *key, walk_compare);

  for (uint32_t i = 0; i < w->n; i++) {
    w->ray[i] = rays->ray[begin + (uint32_t)(key[i] & 0xFFFF)];
    w->slabs[i] = course_slabs_make(&w->tree->root, w->ray[i]);
    w->active[i] = true;
  }
  w->bounds = course_bounds_make(w->ray, w->slabs, w->n);
  w->counts->rays += w->n;
  w->counts->packets++;
  walk_open(w, 0, 0);
}

/* Traces all packets of a list in a way, or (alone) each ray by itself, and returns the counts. */
EX_UNUSED static table_counts walk_all(const walk_tree *tree, const walk_way *way, const walk_rays *rays, bool alone) {
  static walk w;
  table_counts counts;
  memset(&counts, 0, sizeof counts);
  w.tree = tree;
  w.way = way;
  w.counts = &counts;

  for (uint32_t k = 0, begin = 0; k < rays->packets; begin = rays->end[k++]) {
    w.shadow = rays->shadow[k];
    if (!alone) walk_packet(&w, rays, begin, rays->end[k]);
    for (uint32_t i = begin; alone && i < rays->end[k]; i++) walk_packet(&w, rays, i, i + 1);
  }
  return counts;
}

#endif /* COURSE_15_WALK_H */
