/* plain.c - pktrt once more, for exactness.c: with a textbook test of triangles in its kernels (plain_tests.h), or with its own,
   which tell what they come to. */
#define PKTRT_STATIC
#define PKTRT_IMPLEMENTATION
#ifdef PLAIN_STAGES
#define PK_REACHED(stage) (stages_reached |= 1u << (stage))
unsigned stages_reached = 0;
#else
#define PK_OTHER_TESTS "bench/plain_tests.h"
#endif
#ifdef __GNUC__ /* the exact tests are there, and nobody calls them */
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include "../pktrt.h"
#include "plain.h"

#ifdef PLAIN_STAGES
#define PLAIN stages
#define PLAIN_NAME "stages"
#elif defined(PLAIN_MOLLER)
#define PLAIN moller
#define PLAIN_NAME "Moeller-Trumbore"
#else
#define PLAIN kensler
#define PLAIN_NAME "Kensler-Shirley"
#endif
const library PLAIN = {PLAIN_NAME, pktrt_scene_create, pktrt_add_mesh, pktrt_commit, pktrt_scene_destroy,
    pktrt_intersect_n, pktrt_occluded_n};
