/* plain.h - the calls of a copy of pktrt. */
#ifndef PLAIN_H
#define PLAIN_H

#include "../pktrt.h"

typedef struct library {
  const char *name;
  pktrt_scene *(*create)(const pktrt_scene_desc *);
  pktrt_status (*add_mesh)(pktrt_scene *, const pktrt_mesh_desc *, uint32_t *);
  pktrt_status (*commit)(pktrt_scene *);
  void (*destroy)(pktrt_scene *);
  void (*intersect)(const pktrt_scene *, const pktrt_ray *, pktrt_hit *, size_t);
  void (*occluded)(const pktrt_scene *, const pktrt_ray *, bool *, size_t);
} library;

extern const library kensler, moller;

/* pktrt itself, which sets bits of stages_reached: 0 when a triangle is tested in doubles, 1 when expansions decide. */
extern const library stages;
extern unsigned stages_reached;

#endif /* PLAIN_H */
