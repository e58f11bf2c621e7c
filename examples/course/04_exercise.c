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

void trace_packet(const course_scene *scene, const pktrt_node *nodes, const course_ray *rays, course_hit *hits,
    uint32_t n, course_log *log) {
  course_slabs slabs[256];
  for (uint32_t r = 0; r < n; r++) slabs[r] = course_slabs_make(&nodes[0], rays[r]);
  tell(log, PKTRT_EVENT_NODE, 0, 0, 0);
  (void)scene, (void)hits, (void)slabs; /* write here */
}
