/* 13_fast.h - the library's fast path in plain C: single rays, streams and frusta, and the choice among them. Counts
   tests, and compares with the library's counts. */
#ifndef COURSE_13_FAST_H
#define COURSE_13_FAST_H

#include "course.h"
#include "13_solution.c"

enum { FAST_STACK = 38 * 7 + 9 }; /* see chapter 3; all children of the last node are pushed at once */

/* [choice] */
enum {
  FAST_BLOCK = 64,          /* rays among which a frustum is sought; the most rays of a stream */
  FAST_BATCH = 256,         /* rays among which streams are formed */
  FAST_FEW_RAYS = 16,       /* fewer rays of a call are traced one by one ... */
  FAST_FEW_SHADOW_RAYS = 32 /* ... and so are fewer rays that look for any hit */
};
enum {
  FAST_FEW_OF_ONE_WAY = 16, /* of 64 rays: only if more are there, the library asks whether all go along one axis */
  FAST_FEW_OF_PACKET = 24,  /* rays of similar directions: only more make a frustum */
  FAST_FEW_OF_STREAM = 4,   /* rays of an octant: fewer are traced one by one */
  FAST_FEW_AT_NODE = 8      /* times 2, 3 or 4: as few rays of a frustum go on as a stream */
};
#define FAST_ASPECT 0.7f /* a ray goes along an axis if no other component, times this, reaches the main component */
#define FAST_SLOPES 0.3f /* directions are similar if they share octant and main axis and slopes differ by less */
/* [end] */

typedef enum fast_walk { FAST_SINGLE, FAST_STREAM, FAST_FRUSTUM, FAST_WALKS } fast_walk;

typedef struct fast_counts {
  uint64_t packets; /* single rays, streams and frusta that were formed */
  uint64_t nodes;   /* opened */
  uint64_t boxes;   /* tests of a ray against a box */
  uint64_t culls;   /* children dropped by the planes, all rays at once */
  uint64_t vectors; /* tests of eight lanes at once: rays against boxes, or planes against boxes */
  uint64_t thin;    /* nodes below which the rays of a frustum go on as a stream */
  uint64_t whole;   /* children that rays of a frustum enter without a test, as all of them do */
  uint64_t tested;  /* children that rays of a frustum are tested against */
} fast_counts;

/* Adds counts to others. */
EX_UNUSED static void fast_counts_add(fast_counts *to, const fast_counts *c) {
  to->packets += c->packets;
  to->nodes += c->nodes;
  to->boxes += c->boxes;
  to->culls += c->culls;
  to->vectors += c->vectors;
  to->thin += c->thin;
  to->whole += c->whole;
  to->tested += c->tested;
}

typedef struct fast_step { /* a node that a stream opens, and the rays that enter it */
  uint32_t node;
  uint64_t rays;
} fast_step;

typedef struct fast_rays fast_rays;

/* The rays of a frustum. */
typedef struct fast_packet {
  hull *hull;
  const uint32_t *list; /* the ray of bit i is list[i] */
  uint64_t all;         /* as it was formed */
  uint32_t octant;
  bool common;          /* one origin */
  course_bounds bounds; /* the intervals of chapter 5, for comparison */
  float last;           /* the farthest depth at which one of the rays can still find its answer */
} fast_packet;

struct fast_rays {
  const course_scene *scene;
  const pktrt_node *nodes;
  bool any; /* any hit will do: shadow rays */
  uint32_t n;
  course_ray *ray;
  course_slabs *slabs;
  course_hit *hit;
  uint8_t *walk; /* fast_walk by which each ray began */
  fast_counts counts;
  fast_step *step; /* NULL, or where steps of streams are to be stored */
  uint32_t steps;
  /* NULL, or a function that is told of each child that a frustum asks about; `mask` are the rays that ask. */
  void (*asked)(void *user, const fast_rays *f, const fast_packet *p, const pktrt_node *node, uint32_t k, uint64_t mask,
      bool dropped);
  void *user;
};

/* A child that waits, and the rays that may enter it. */
typedef struct fast_entry {
  const pktrt_node *parent; /* NULL: the root waits */
  uint32_t k;               /* its slot in the parent */
  uint64_t mask;            /* bit i stands for ray list[i] */
  float depth;              /* of entry; of a stream: if only one ray enters */
  bool whole;               /* frusta: all rays of the mask enter the box, if it is not behind their hits */
} fast_entry;

typedef struct fast_stack {
  fast_entry entry[FAST_STACK];
  uint32_t n;
} fast_stack;

static uint32_t fast_lowest(uint64_t mask) {
  uint32_t i = 0;
  while (!(mask >> i & 1)) i++;
  return i;
}
static uint32_t fast_count(uint64_t mask) {
  uint32_t n = 0;
  for (; mask; mask &= mask - 1) n++;
  return n;
}

/* Makes rays ready to be traced, with nothing counted. */
EX_UNUSED static fast_rays fast_rays_make(
    const course_scene *scene, const pktrt_node *nodes, const course_ray *rays, uint32_t n, bool any) {
  fast_rays f;
  memset(&f, 0, sizeof f);
  f.scene = scene;
  f.nodes = nodes;
  f.any = any;
  f.n = n;
  f.ray = (course_ray *)course_memory(n, sizeof *f.ray);
  f.slabs = (course_slabs *)course_memory(n, sizeof *f.slabs);
  f.hit = (course_hit *)course_memory(n, sizeof *f.hit);
  f.walk = (uint8_t *)course_memory(n, sizeof *f.walk);

  for (uint32_t i = 0; i < n; i++) {
    const course_hit none = {rays[i].tmax, 0, 0, COURSE_NONE};
    f.ray[i] = rays[i];
    f.slabs[i] = course_slabs_make(nodes, rays[i]);
    f.hit[i] = none;
  }
  return f;
}
EX_UNUSED static void fast_rays_free(fast_rays *f) {
  free(f->ray);
  free(f->slabs);
  free(f->hit);
  free(f->walk);
}

/* Tests a ray against the triangles of a leaf. Returns true if it hits one, for nearest hits nearer than before. */
static bool fast_meet_leaf(fast_rays *f, uint32_t ray, const uint32_t triangles[8]) {
  bool met = false;
  for (int i = 0; i < 8 && !(f->any && met); i++)
    if (triangles[i] != PKTRT_NONE)
      met |= course_slabs_meet(&f->slabs[ray], f->scene, f->ray[ray], triangles[i], &f->hit[ray]);
  return met;
}

/* >>single rays ---------------------------------------------------------------------------------------------------- */

/* Traces a ray through the child that waits: the walk of chapter 3, nearest child first. For any hit, the last child of
   a node is first. Returns true if the ray hits, or hits nearer than before. */
static bool fast_single(fast_rays *f, uint32_t ray, fast_entry next) {
  fast_stack stack;
  const course_slabs *slabs = &f->slabs[ray];
  bool met = false;
  stack.n = 0;

  for (;;) {
    const pktrt_node *parent = next.parent;
    if (parent && parent->leaf[next.k]) {
      met |= fast_meet_leaf(f, ray, parent->triangle[next.k]);
      if (met && f->any) return true;
    } else {
      const pktrt_node *node = &f->nodes[parent ? parent->child[next.k] : 0];
      const uint32_t bottom = stack.n;
      f->counts.nodes++;
      f->counts.vectors++;

      for (uint32_t k = 0; k < 8; k++) {
        fast_entry child = {node, k, 1, 0, false};
        if (node->child[k] == PKTRT_NONE) continue;
        f->counts.boxes++;
        if (!course_slabs_enter(slabs, node->lo[k], node->hi[k], &child.depth)) continue;
        stack.entry[stack.n++] = child;
        fast_entry *top = &stack.entry[stack.n - 1];
        if (f->any || stack.n - bottom < 2 || top[0].depth < top[-1].depth) continue;
        top[0] = top[-1]; /* the nearest so far stays on top */
        top[-1] = child;
      }
    }

    do {
      if (!stack.n) return met;
      next = stack.entry[--stack.n];
    } while (!f->any && next.depth > slabs->last);
  }
}

/* >>streams -------------------------------------------------------------------------------------------------------- */

/* [stream] */
/* Pushes the children that rays of the mask enter, each with the mask of these rays. list[i] is the ray of bit i. */
static void fast_stream_open(
    fast_rays *f, const pktrt_node *node, const uint32_t *list, uint64_t mask, fast_stack *stack) {
  const uint32_t octant = f->slabs[list[fast_lowest(mask)]].octant; /* all rays have the same */
  uint64_t enters[8] = {0};
  float depth[8] = {0};

  for (uint64_t rest = mask; rest; rest &= rest - 1) {
    const uint32_t i = fast_lowest(rest);
    f->counts.vectors++; /* one ray, eight boxes */
    for (uint32_t k = 0; k < 8; k++) {
      if (node->child[k] == PKTRT_NONE) continue;
      f->counts.boxes++;
      if (course_slabs_enter(&f->slabs[list[i]], node->lo[k], node->hi[k], &depth[k])) enters[k] |= (uint64_t)1 << i;
    }
  }

  for (uint32_t i = 8; i-- > 0;) { /* the nearest is pushed last; for any hit, the order does not matter */
    const uint32_t k = f->any ? 7 - i : node->order[octant][i];
    const fast_entry child = {node, k, enters[k], depth[k], false};
    if (enters[k]) stack->entry[stack->n++] = child;
  }
}
/* [end] */

/* Traces the rays of next.mask, all of one octant, through the child that waits. Returns the rays that hit, or hit
   nearer than before. */
static uint64_t fast_stream(fast_rays *f, const uint32_t *list, fast_entry next) {
  fast_stack stack;
  uint64_t hit = 0;
  stack.n = 0;

  if (fast_count(next.mask) == 1) return fast_single(f, list[fast_lowest(next.mask)], next) ? next.mask : 0;

  for (;;) {
    const pktrt_node *parent = next.parent;
    if (parent && parent->leaf[next.k]) {
      for (uint64_t rest = next.mask; rest; rest &= rest - 1)
        if (fast_meet_leaf(f, list[fast_lowest(rest)], parent->triangle[next.k])) hit |= rest & (~rest + 1);
    } else {
      const fast_step step = {parent ? parent->child[next.k] : 0, next.mask};
      f->counts.nodes++;
      if (f->step) f->step[f->steps++] = step;
      fast_stream_open(f, &f->nodes[step.node], list, next.mask, &stack);
    }

    do { /* of a stream with many rays, it is not asked again which are too short to reach the box */
      if (!stack.n) return hit;
      next = stack.entry[--stack.n];
      if (f->any) next.mask &= ~hit;
      else if (fast_count(next.mask) == 1 && next.depth > f->slabs[list[fast_lowest(next.mask)]].last) next.mask = 0;
    } while (!next.mask);
  }
}

/* >>frusta --------------------------------------------------------------------------------------------------------- */

static int fast_axis(const course_ray *ray) {
  const float *d = ray->direction.at;
  int axis = 0;
  if (fabsf(d[1]) > fabsf(d[axis])) axis = 1;
  if (fabsf(d[2]) > fabsf(d[axis])) axis = 2;
  return axis;
}

/* Returns the box around the scene. */
EX_UNUSED static course_box fast_scene_box(const pktrt_node *root) {
  course_box box = course_box_empty();
  for (int k = 0; k < 8; k++) {
    vec lo, hi;
    if (root->child[k] == PKTRT_NONE) continue;
    memcpy(lo.at, root->lo[k], sizeof lo);
    memcpy(hi.at, root->hi[k], sizeof hi);
    box = course_box_grow(box, lo, hi);
  }
  return box;
}

/* Makes a frustum of the rays of a mask, all of one octant and main axis. The caller frees the hull. */
EX_UNUSED static fast_packet fast_packet_make(const fast_rays *f, const uint32_t *list, uint64_t mask) {
  course_ray rays[FAST_BLOCK];
  course_slabs slabs[FAST_BLOCK];
  const uint32_t first = list[fast_lowest(mask)];
  const course_ray *ray = &f->ray[first];
  hull_packet packet = {rays, 0, fast_axis(ray), 1, fast_scene_box(f->nodes), 0};
  fast_packet p;

  p.list = list;
  p.all = mask;
  p.octant = f->slabs[first].octant;
  p.common = true;
  if (ray->direction.at[packet.axis] < 0) packet.sign = -1;

  for (; mask; mask &= mask - 1) {
    const uint32_t i = list[fast_lowest(mask)];
    p.common &= !memcmp(&f->ray[i].origin, &ray->origin, sizeof(vec));
    packet.pad = fmaxf(packet.pad, f->slabs[i].pad);
    slabs[packet.n] = f->slabs[i];
    rays[packet.n++] = f->ray[i];
  }

  p.hull = hull_make(&packet);
  p.bounds = course_bounds_make(rays, slabs, packet.n);
  p.last = 0;
  return p;
}

/* Returns true if all rays enter a box whose front lies at this depth, provided that the box is not behind their hits:
   if the hull is inside the box's front. */
static bool fast_all_enter(const hull *h, float front, const float lo[3], const float hi[3]) {
  const float depth = fmaxf(front, 0);
  for (int side = 0; side < 2; side++) {
    const int axis = h->other[side];
    if (h->at[side][1] + h->slope[side][1] * depth > hi[axis] - h->middle[side] + h->pad) return false;
    if (h->at[side][0] + h->slope[side][0] * depth < lo[axis] - h->middle[side] - h->pad) return false;
  }
  return true;
}

/* Finds anew how far the rays of the mask, which still look for their answers, reach. */
static void fast_set_last(const fast_rays *f, fast_packet *p, uint64_t mask) {
  p->last = p->bounds.last = -INFINITY;
  for (; mask; mask &= mask - 1) {
    const uint32_t ray = p->list[fast_lowest(mask)];
    const float start = hull_along(p->hull, f->ray[ray].origin.at) - p->hull->begin;
    p->last = fmaxf(p->last, start + f->slabs[ray].last);
    p->bounds.last = fmaxf(p->bounds.last, f->slabs[ray].last);
  }
}

/* [frustum] */
/* Pushes the children that reach into the hull. Their rays are tested when they are popped. */
static void fast_frustum_open(
    fast_rays *f, const fast_packet *p, const pktrt_node *node, uint64_t mask, fast_stack *stack) {
  const hull *h = p->hull;
  f->counts.nodes++;
  f->counts.vectors++; /* the planes, eight boxes */

  for (uint32_t i = 8; i-- > 0;) {
    const uint32_t k = f->any ? 7 - i : node->order[p->octant][i];
    if (node->child[k] == PKTRT_NONE) continue;
    const float front = hull_along(h, h->sign > 0 ? node->lo[k] : node->hi[k]) - h->begin - h->pad;
    const bool dropped = front > p->last || hull_misses(h, node->lo[k], node->hi[k]);
    if (f->asked) f->asked(f->user, f, p, node, k, mask, dropped);
    f->counts.culls += dropped;

    const fast_entry child = {node, k, mask, front, fast_all_enter(h, front, node->lo[k], node->hi[k])};
    if (!dropped) stack->entry[stack->n++] = child;
  }
}

/* Returns the rays of the mask that enter child k of a node. */
static uint64_t fast_frustum_enter(
    fast_rays *f, const uint32_t *list, const pktrt_node *node, uint32_t k, uint64_t mask) {
  uint64_t enters = 0;

  f->counts.tested++;
  f->counts.boxes += fast_count(mask);
  f->counts.vectors += FAST_BLOCK / 8; /* eight rays, one box */
  for (uint64_t rest = mask; rest; rest &= rest - 1) {
    const uint32_t i = fast_lowest(rest);
    if (course_slabs_enter(&f->slabs[list[i]], node->lo[k], node->hi[k], NULL)) enters |= (uint64_t)1 << i;
  }
  return enters;
}
/* [end] */

/* Traces the rays of a mask, all of one octant and main axis, as a frustum. */
static void fast_frustum(fast_rays *f, const uint32_t *list, uint64_t mask) {
  fast_packet p = fast_packet_make(f, list, mask);
  fast_stack stack;
  fast_entry next = {NULL, 0, mask, 0, false};
  const uint32_t few = FAST_FEW_AT_NODE * (2u + f->any + !p.common);
  uint64_t alive = mask;
  fast_set_last(f, &p, alive);
  stack.n = 0;

  while (next.mask) {
    const pktrt_node *parent = next.parent;
    uint64_t hit = 0;

    if (parent && parent->leaf[next.k]) {
      for (uint64_t rest = next.mask; rest; rest &= rest - 1)
        if (fast_meet_leaf(f, list[fast_lowest(rest)], parent->triangle[next.k])) hit |= rest & (~rest + 1);
    } else if (fast_count(next.mask) <= few) {
      f->counts.thin++;
      hit = fast_stream(f, list, next);
    } else {
      fast_frustum_open(f, &p, &f->nodes[parent ? parent->child[next.k] : 0], next.mask, &stack);
    }

    if (f->any) alive &= ~hit;
    if (hit) fast_set_last(f, &p, alive);

    next.mask = 0;
    while (!next.mask && stack.n && alive) {
      next = stack.entry[--stack.n];
      next.mask = next.depth > p.last ? 0 : next.mask & alive;
      if (next.mask && next.whole) f->counts.whole++;
      if (next.mask && !next.whole) next.mask = fast_frustum_enter(f, list, next.parent, next.k, next.mask);
    }
  }

  free(p.hull);
}

/* >>choice --------------------------------------------------------------------------------------------------------- */

/* Returns true if the rays of a block are many and all go along one axis. */
static bool fast_one_way(const fast_rays *f, uint32_t base, uint64_t mask) {
  if (fast_count(mask) <= FAST_FEW_OF_ONE_WAY) return false;
  const course_ray *first = &f->ray[base + fast_lowest(mask)];
  const int axis = fast_axis(first);

  for (; mask; mask &= mask - 1) {
    const float *d = f->ray[base + fast_lowest(mask)].direction.at;
    const float side = fmaxf(fabsf(d[(axis + 1) % 3]), fabsf(d[(axis + 2) % 3]));
    if (!(side * FAST_ASPECT < (first->direction.at[axis] < 0 ? -d[axis] : d[axis]))) return false;
  }
  return true;
}

/* Returns the rays of a mask with the octant and the main axis of ray `first` of the block; if `slopes`, only those whose
   slopes are near those of the first. */
static uint64_t fast_alike(const fast_rays *f, uint32_t base, uint64_t mask, uint32_t first, bool slopes) {
  const float *d = f->ray[base + first].direction.at;
  const int k = fast_axis(&f->ray[base + first]), u = (k + 1) % 3, v = (k + 2) % 3;
  uint64_t alike = 0;

  for (uint64_t rest = mask; rest; rest &= rest - 1) {
    const uint32_t ray = base + fast_lowest(rest);
    const float *e = f->ray[ray].direction.at;
    if (f->slabs[ray].octant != f->slabs[base + first].octant || fast_axis(&f->ray[ray]) != k) continue;
    if (slopes && !(fabsf(e[u] / e[k] - d[u] / d[k]) < FAST_SLOPES && fabsf(e[v] / e[k] - d[v] / d[k]) < FAST_SLOPES))
      continue;
    alike |= rest & (~rest + 1);
  }
  return alike;
}

/* Removes from *rest, and returns, rays of a block for a frustum; 0: there are none. */
static uint64_t fast_next_frustum(const fast_rays *f, uint32_t base, uint64_t *rest, bool one_way, uint32_t tries) {
  uint64_t packet = 0, among = *rest;
  if (one_way && among) packet = fast_alike(f, base, among, fast_lowest(among), false);

  for (uint32_t i = 0; !one_way && i < tries && fast_count(among) > FAST_FEW_OF_PACKET && !packet; i++) {
    const uint32_t first = fast_lowest(among);
    const uint64_t alike = fast_alike(f, base, among, first, true);
    if (fast_count(alike) > FAST_FEW_OF_PACKET) packet = alike;
    among &= ~alike;
  }

  *rest &= ~packet;
  return packet;
}

/* Traces the rays of a batch that are in left[], by octants, in streams of up to 64; few are traced one by one. */
static void fast_octants(fast_rays *f, uint32_t begin, const uint64_t left[FAST_BATCH / FAST_BLOCK], fast_walk most) {
  for (uint32_t octant = 0; octant < 8; octant++) {
    uint32_t list[FAST_BATCH], count = 0;
    for (uint32_t i = 0; i < FAST_BATCH; i++)
      if (left[i / 64] >> i % 64 & 1 && f->slabs[begin + i].octant == octant) list[count++] = begin + i;

    for (uint32_t i = 0, n; i < count; i += n) {
      n = count - i < FAST_BLOCK ? count - i : FAST_BLOCK;
      const bool alone = n < FAST_FEW_OF_STREAM || most == FAST_SINGLE;
      const fast_entry root = {NULL, 0, ~(uint64_t)0 >> (64 - n), 0, false}, one = {NULL, 0, 1, 0, false};
      f->counts.packets += alone ? n : 1;
      for (uint32_t k = i; k < i + n; k++) f->walk[list[k]] = alone ? FAST_SINGLE : FAST_STREAM;
      if (!alone) fast_stream(f, list + i, root);
      for (uint32_t k = i; alone && k < i + n; k++) fast_single(f, list[k], one);
    }
  }
}

/* Traces all rays as a call of the library does. `most` is the last walk that may be taken: FAST_FRUSTUM for all three. */
EX_UNUSED static void fast_trace(fast_rays *f, fast_walk most) {
  bool coherent = true;

  for (uint32_t begin = 0, n; begin < f->n; begin += n) {
    const uint32_t size = coherent ? FAST_BLOCK : FAST_BATCH; /* coherent rays need no larger batch */
    uint64_t left[FAST_BATCH / FAST_BLOCK] = {0};
    uint32_t list[FAST_BLOCK], rays_left = 0, tries = 3;
    n = f->n - begin < size ? f->n - begin : size;
    const fast_walk may = n < (uint32_t)(f->any ? FAST_FEW_SHADOW_RAYS : FAST_FEW_RAYS) ? FAST_SINGLE : most;

    for (uint32_t block = 0; block * FAST_BLOCK < n; block++) {
      const uint32_t base = begin + block * FAST_BLOCK, rays = n - block * FAST_BLOCK;
      const uint64_t all = rays < FAST_BLOCK ? ((uint64_t)1 << rays) - 1 : ~(uint64_t)0;
      const bool one_way = fast_one_way(f, base, all);
      uint64_t packet;
      left[block] = all;

      for (uint32_t i = 0; i < FAST_BLOCK; i++) list[i] = base + i;
      while (may == FAST_FRUSTUM && (packet = fast_next_frustum(f, base, &left[block], one_way, tries)) != 0) {
        f->counts.packets++;
        for (uint64_t rest = packet; rest; rest &= rest - 1) f->walk[base + fast_lowest(rest)] = FAST_FRUSTUM;
        fast_frustum(f, list, packet);
      }
      tries = left[block] == all ? 1 : 3;
      rays_left += fast_count(left[block]);
    }

    coherent = rays_left <= n / 4;
    fast_octants(f, begin, left, may);
  }
}

#endif /* COURSE_13_FAST_H */
