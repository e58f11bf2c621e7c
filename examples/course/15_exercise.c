/* Exercise 15: the account of a packet's walk, and a prediction of the speed-up. Fill in both functions, then
   make course-check N=15 FILE=mine_15.c */
#include "15_exercise.h"

/* Returns what a packet took, from its events on the paper path with all steps. The numbers must be the library's.

   rays    in the packet, 1 to 256: at first all of them are active
   shadow  the packet looks for any hit: a ray with a HIT is no longer active

   `tested` of the events is 0 here; their other fields are as pktrt.h describes them. Groups are rays 0 to 7, 8 to 15, and
   so on. A vector test is the test of one group against one box; its lanes are the active rays of the group. Groups
   without an active ray are not tested. These tests are made:

     - FIRST_HIT, LATER_HIT, INTERVAL_CULL, FRUSTUM_CULL, ALL_MISS: the group of the first active ray of the parent's range,
       from this ray on. The parent's range is told by its event NODE: it begins with `ray` and has `active` rays, some of
       which may no longer be active. The parent's depth is one less than the child's.
     - ALL_MISS: besides, the other groups of the parent's range.
     - LATER_HIT, if the ray is in another group than the first active ray: besides, the groups in between, and the group of
       the ray. Then the end of the range is looked for: the groups from the end of the parent's range backwards, up to
       the one that has a ray that enters, but not the group of the ray again. `active` of this event counts the rays from
       `ray` to the new end of the range, which is the end of a group or of the packet.
     - LEAF_TEST: the group of its ray, from a range that begins with the ray of LEAF. But the group of the ray of LEAF has
       been tested before, and is not tested again.
     - NONE_LEFT, TRIM, LEAF, HIT, NODE: no test. */
account account_of(const pktrt_event *event, size_t events, uint32_t rays, bool shadow) {
  const account nothing = {0, 0, 0, 0}; /* write here */
  (void)event;
  (void)events;
  (void)rays;
  (void)shadow;
  return nothing;
}

/* Returns how many times as fast packets are as their rays alone, and the factors of this number.

   alone      alone[k] is the sum of the accounts of all rays of packet k, traced one by one
   packet     packet[k] is the account of packet k
   node_cost  what a node costs to open; a vector test of boxes costs 1, and nothing else costs */
account_split account_predict(const account *alone, const account *packet, size_t packets, double node_cost) {
  const account_split nothing = {0, 0, 0, 0}; /* write here */
  (void)alone;
  (void)packet;
  (void)packets;
  (void)node_cost;
  return nothing;
}
