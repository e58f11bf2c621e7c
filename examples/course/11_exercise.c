/* Exercise 11: the rays that leave mirror and glass. Fill in picture_scatter(), then
   make course-check N=11 FILE=mine_11.c

   Finds the ways on from a surface, writes them to way[0] and way[1], and returns how many there are.
   - direction: of the ray that has met the surface, of unit length. The ray goes towards the surface.
   - normal: of unit length, to the outside of the body, from whichever side the ray came.
   - A mirror (material->mirror > 0) has one way, PKTRT_RAY_REFLECTION; its share is material->mirror.
   - Glass (material->ior > 0) has two ways: PKTRT_RAY_REFLECTION, whose share is the exact reflectance F of the text,
     then PKTRT_RAY_REFRACTION, whose share is 1 - F. Total reflection: only the first, whose share is 1.
   - Any other material has no way on: return 0.
   - The directions of the ways have unit length. */
#include "11_picture.h"

uint32_t picture_scatter(const picture_material *material, vec direction, vec normal, picture_way way[2]) {
  (void)material, (void)direction, (void)normal, (void)way; /* write here */
  return 0;
}
