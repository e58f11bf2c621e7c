/* 06_exercise.c - which steps of the paper path are worth most? Write ablate_fewest(). */
#include "06_ablate.h"

/* Returns the steps, as bits of pktrt_paper_step, of those at most `count` (0 to 6) with which the n rays take the fewest
   tests of the given kind, traced on the paper path in packets of packet_size. If several sets are as good, any of
   them.

   Trace the rays by pktrt_intersect_ex() with each set that comes into question, or with fewer of them if you can say
   why that will do. Counts are added to, never reset. In paper_steps 0 means all steps; none is PKTRT_PAPER_STEP_NONE, in what you
   pass and in what you return. packet_size is a number of rays, as in pktrt_query_desc; in pktrt_render_desc it is the
   edge of a packet. */
uint32_t ablate_fewest(
    const pktrt_scene *s, const pktrt_ray *rays, size_t n, uint32_t packet_size, int count, ablate_cost cost) {
  (void)s, (void)rays, (void)n, (void)packet_size, (void)count, (void)cost; /* remove this line */
  return 0;
}
