/* plain.c - pktrt once more, with a textbook test of triangles in its kernels (plain_tests.h), for exactness.c. */
#define PKTRT_STATIC
#define PKTRT_IMPLEMENTATION
#define PKTRT__OTHER_TESTS "bench/plain_tests.h"
#ifdef __GNUC__ /* the exact tests are there, and nobody calls them */
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include "../pktrt.h"
#include "plain.h"

#ifdef PLAIN_MOLLER
#define PLAIN moller
#define PLAIN_NAME "Moeller-Trumbore"
#else
#define PLAIN kensler
#define PLAIN_NAME "Kensler-Shirley"
#endif
const library PLAIN = {PLAIN_NAME,          pktrt_scene_create, pktrt_add_mesh,  pktrt_commit,
                       pktrt_scene_destroy, pktrt_intersect_n,  pktrt_occluded_n};
