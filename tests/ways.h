/* The ways to ask: single calls, the fast path, the paper's path with packets of several sizes, ray by ray, and the same
   with counts. Two scenes are compared on rays of all kinds, bit for bit. */
#ifndef PKTRT_TEST_WAYS_H
#define PKTRT_TEST_WAYS_H
#include "meshes.h"

enum { MANY = 1536, WAYS = 7 };
typedef struct answers {
  pktrt_hit hit[MANY];
  bool occluded[MANY];
} answers;

/* Asks about up to MANY rays in one of WAYS ways; the mask is that of a query, 0: all bits. */
void ask_masked(const pktrt_scene *, int way, uint32_t mask, const pktrt_ray *, size_t n, answers *);
void ask(const pktrt_scene *, int way, const pktrt_ray *, size_t n, answers *);
size_t differ(const answers *, const answers *, size_t n);
size_t hits_of(const answers *, size_t n);

/* What a scene is compared with: another one, whose mesh i is mesh map[i] (NULL: i) of the first. With a mask it has but
   what queries of that mask see. */
typedef struct expected_scene {
  const pktrt_scene *s;
  const uint32_t *map;
  uint32_t mask, meshes;
} expected_scene;
/* Compares in all ways, on n rays of each kind of a world; without a mask, all crossings and winding numbers too. Adds
   to *wrong; returns the hits. */
size_t compare_with(const expected_scene *, const pktrt_scene *, const world *, size_t n, size_t *wrong);
/* The same where meshes have the indices that they have in the world. */
size_t compare(const pktrt_scene *want, const pktrt_scene *got, const world *, size_t n, size_t *wrong);

/* CHECKs that a call was refused, in a sentence with these words. */
bool says(pktrt_scene *, pktrt_status, pktrt_status want, const char *words);

#endif
