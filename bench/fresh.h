/* Rays that are written just before a call. Who compares versions includes another pktrt.h before. */
#ifndef FRESH_H
#define FRESH_H

#ifndef PKTRT_H
#include "../pktrt.h"
#endif

/* Writes a ray float by float, as programs that make rays do. Not inlined, lest the compiler join the stores. */
#ifdef __GNUC__
__attribute__((noinline))
#endif
static void
write_ray(const pktrt_ray *from, volatile pktrt_ray *to) {
  for (int a = 0; a < 3; a++) {
    to->origin[a] = from->origin[a];
    to->direction[a] = from->direction[a];
  }
  to->tmin = from->tmin;
  to->tmax = from->tmax;
  to->time = from->time;
}

#endif
