/* Exercise 4: a packet that visits near children first. Write trace_packet(), then
   make course-check N=4 FILE=mine_04.c

   trace_packet() finds the nearest hit of each ray of a packet, and logs the same events in the same order as the
   library with PKTRT_PAPER_STEP_ORDER. These events are the specification:

     - Ray 0 is the first active ray of node 0, the root.
     - The children of a node are visited from near to far, as seen by the first active ray of the node: with the
       octant of that ray, slabs.octant, node->order[octant] lists all eight places from near to far.
     - A packet enters a child as in the chapter, and passes to the child the number of the ray that entered first.
     - Empty places (child is PKTRT_NONE) are skipped without an event. Do not test the box of an empty place.
     - The verdict on a child takes into account all hits that were found before the child's turn comes.
     - All rays of a leaf, from its first active ray on, are tested against all of its triangles by course_slabs_meet().

   How you get there is your design: whether the function calls itself or keeps a stack, and what it keeps for a child
   that waits. The library's trees have at most 38 levels. */
#include "course.h"

/* The check calls trace_packet() with n rays, 1 to 256, and n hits, which are misses at first. */
void trace_packet(const course_scene *scene, const pktrt_node *nodes, const course_ray *rays, course_hit *hits,
    uint32_t n, course_log *log);

/* Logs an event. Its arguments index, child and ray are

     NODE        the node's index, 0, the node's first active ray
     FIRST_HIT   the parent's index, the child's place, the ray that enters, which is the parent's first active ray
     LATER_HIT   the parent's index, the child's place, the ray that enters, which is a later one
     ALL_MISS    the parent's index, the child's place, the parent's first active ray
     LEAF        the leaf's index, 0, the leaf's first active ray
     HIT         the leaf's index, the triangle's lane, the ray. */
static void report(course_log *log, pktrt_event_kind kind, uint32_t index, uint32_t child, uint32_t ray) {
  pktrt_event e;
  memset(&e, 0, sizeof e);
  e.kind = kind;
  e.index = index;
  e.child = child;
  e.ray = ray;
  course_log_event(log, &e);
}

void trace_packet(const course_scene *scene, const pktrt_node *nodes, const course_ray *rays, course_hit *hits,
    uint32_t n, course_log *log) {
  course_slabs slabs[256];
  for (uint32_t r = 0; r < n; r++) slabs[r] = course_slabs_make(&nodes[0], rays[r]);
  report(log, PKTRT_EVENT_NODE, 0, 0, 0);
  (void)scene, (void)hits, (void)slabs; /* write here */
}
