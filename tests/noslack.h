/* The library without slack (noslack.c), for controls. Scenes of the one are no scenes of the other. */
#ifndef PKTRT_TEST_NOSLACK_H
#define PKTRT_TEST_NOSLACK_H
#include "meshes.h"

pktrt_scene *noslack_scene(const world *, pktrt_isa); /* committed; NULL on failure */
void noslack_destroy(pktrt_scene *);
void noslack_intersect(const pktrt_scene *, const pktrt_query_desc *, const pktrt_ray *, pktrt_hit *, size_t n);
void noslack_occluded(const pktrt_scene *, const pktrt_query_desc *, const pktrt_ray *, bool *occluded, size_t n);

#endif
