/* Exercise 4: a packet that keeps its children on a stack, and goes to near ones first. Fill in trace_packet(), then
   make course-check N=4 FILE=mine_04.c

   The chapter's packet calls itself, and takes children by their places. Write one that has a stack of its own and does
   what the library does with PKTRT_PAPER_STEP_ORDER, event by event:

     1. Ray 0 is the first active one at node 0. Opening a node is told, with the first active ray.
     2. Its children wait on the stack, each with the first active ray of the node. Their turn comes in the node's order
        for the octant of that ray: node->order[slabs[ray].octant] lists all eight places from near to far. Skip
        the empty ones (child is PKTRT_NONE): nothing is told of them, and the box test would let rays in.
     3. When a child's turn comes, and not before, rays are tested against its box from its first active one on, and
        one of FIRST_HIT, LATER_HIT, ALL_MISS is told. Hits that were found meanwhile have shortened the rays.
     4. A child that is entered is opened if it is a node. If it is a leaf, that is told, and all rays from the first
        active one on meet its triangles by course_slabs_meet(); a ray's hits are told as they are found.

   tell() says which index, child and ray belong to an event. */
#include "course.h"

/* The check calls it: n rays, 1 to 256, and as many hits, which are misses at first. */
void trace_packet(const course_scene *scene, const pktrt_node *nodes, const course_ray *rays, course_hit *hits,
    uint32_t n, course_log *log);

/* NODE: its index, 0, the first active ray. FIRST_HIT, LATER_HIT: the parent's index, the place, the ray that enters.
   ALL_MISS: the parent's index, the place, the first active ray. LEAF: its index, 0, the first active ray. HIT: the
   leaf's index, the lane of the triangle, the ray. */
static void tell(course_log *log, pktrt_event_kind kind, uint32_t index, uint32_t child, uint32_t ray) {
  pktrt_event e;
  memset(&e, 0, sizeof e);
  e.kind = kind, e.index = index, e.child = child, e.ray = ray;
  course_log_event(log, &e);
}

typedef struct waiting {
  const pktrt_node *parent;
  uint32_t index, place, first; /* index: of the parent */
} waiting;

void trace_packet(const course_scene *scene, const pktrt_node *nodes, const course_ray *rays, course_hit *hits,
    uint32_t n, course_log *log) {
  course_slabs slabs[256];
  waiting stack[38 * 7 + 8];
  uint32_t top = 0, open = 0, first = 0; /* the node to open, if any, and its first active ray */
  for (uint32_t r = 0; r < n; r++) slabs[r] = course_slabs_make(&nodes[0], rays[r]);
  for (;;) {
    if (open != PKTRT_NONE) {
      const pktrt_node *node = &nodes[open];
      const uint8_t *order = node->order[slabs[first].octant];
      tell(log, PKTRT_EVENT_NODE, open, 0, first);
      for (int i = 7; i >= 0; i--) { /* the nearest goes on top */
        const waiting w = {node, open, order[i], first};
        if (node->child[order[i]] != PKTRT_NONE) stack[top++] = w;
      }
    }
    if (!top) return;
    const waiting w = stack[--top];
    const uint32_t child = w.parent->child[w.place];
    open = PKTRT_NONE, first = w.first;
    while (first < n && !course_slabs_enter(&slabs[first], w.parent->lo[w.place], w.parent->hi[w.place], NULL)) first++;
    if (first == n) tell(log, PKTRT_EVENT_ALL_MISS, w.index, w.place, w.first);
    else tell(log, first == w.first ? PKTRT_EVENT_FIRST_HIT : PKTRT_EVENT_LATER_HIT, w.index, w.place, first);
    if (first < n && !w.parent->leaf[w.place]) open = child;
    if (first == n || open == child) continue;
    tell(log, PKTRT_EVENT_LEAF, child, 0, first);
    for (uint32_t r = first; r < n; r++)
      for (uint32_t lane = 0; lane < 8; lane++) {
        const uint32_t triangle = w.parent->triangle[w.place][lane];
        if (triangle != PKTRT_NONE && course_slabs_meet(&slabs[r], scene, rays[r], triangle, &hits[r]))
          tell(log, PKTRT_EVENT_HIT, child, lane, r);
      }
  }
}
