/* 08_solution.c - an assembly of one's own: rays that start near each other and go to the same octant share a packet. */
#include "08_reflect.h"

enum { CELLS = 16, PACKET = 16 }; /* of space along an axis; rays */

typedef struct keyed {
  uint32_t key, ray;
} keyed;

static int by_key(const void *a, const void *b) {
  const keyed *x = (const keyed *)a, *y = (const keyed *)b;
  return x->key != y->key ? (x->key < y->key ? -1 : 1) : x->ray < y->ray ? -1 : 1;
}

/* The octant first, then the cell of space that the ray starts in, in Morton's order. */
static uint32_t key_of(const reflect_ray *r) {
  uint32_t key = 0;
  for (int a = 0; a < 3; a++) {
    const float at = (r->origin[a] + 5) * (CELLS / 14.0f); /* from wall to wall, and from -5 to 9 */
    const uint32_t cell = at < 0 ? 0 : at >= CELLS ? CELLS - 1 : (uint32_t)at;
    for (int bit = 0; bit < 4; bit++) key |= (cell >> bit & 1) << (3 * bit + a);
    key |= (r->direction[a] < 0 ? 1u : 0u) << (12 + a);
  }
  return key;
}

uint32_t reflect_assemble(const reflect_ray *rays, uint32_t n, uint32_t *order, uint32_t *end) {
  keyed *k = (keyed *)course_memory(n, sizeof *k);
  uint32_t packets = 0;
  for (uint32_t i = 0; i < n; i++) k[i].key = key_of(&rays[i]), k[i].ray = i;
  qsort(k, n, sizeof *k, by_key);
  for (uint32_t i = 0; i < n; i++) {
    order[i] = k[i].ray;
    if (i % PACKET == PACKET - 1 || i == n - 1) end[packets++] = i + 1;
  }
  free(k);
  return packets;
}
