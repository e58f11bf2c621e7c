/* field.h - ten by ten by ten spheres of 1,024 triangles, none of which overlap, each turned and of its own size, for
   those who place them as instances of one model or as meshes. */
#ifndef BENCH_FIELD_H
#define BENCH_FIELD_H

#include "bench.h"

enum { FIELD_SIDE = 10, FIELD_COUNT = FIELD_SIDE * FIELD_SIDE * FIELD_SIDE };
enum { FIELD_RINGS = 16, FIELD_SLICES = 32, FIELD_TRIANGLES = FIELD_RINGS * FIELD_SLICES * 2 };
enum { FIELD_VERTICES = (FIELD_RINGS + 1) * (FIELD_SLICES + 1) };

typedef struct field_sphere { /* of radius 1 about the origin */
  float positions[FIELD_VERTICES][3];
  uint32_t indices[FIELD_TRIANGLES][3];
} field_sphere;

EX_UNUSED static float field_random(uint32_t *state) { /* of [0, 1) */
  uint32_t x = *state += 0x9E3779B9u;
  x = (x ^ (x >> 16)) * 0x85EBCA6Bu, x = (x ^ (x >> 13)) * 0xC2B2AE35u;
  return (float)((x ^ (x >> 16)) >> 8) / 16777216;
}

EX_UNUSED static void field_make_sphere(field_sphere *s) {
  const float pi = 3.14159265f;
  uint32_t n = 0;
  for (uint32_t i = 0; i <= FIELD_RINGS; i++)
    for (uint32_t j = 0; j <= FIELD_SLICES; j++) {
      const float down = pi * (float)i / (int)FIELD_RINGS,
                  around = 2 * pi * (float)(j % FIELD_SLICES) / (int)FIELD_SLICES;
      float *v = s->positions[i * (FIELD_SLICES + 1) + j];
      v[0] = sinf(down) * cosf(around), v[1] = cosf(down), v[2] = sinf(down) * sinf(around);
    }
  for (uint32_t i = 0; i < FIELD_RINGS; i++)
    for (uint32_t j = 0; j < FIELD_SLICES; j++) {
      const uint32_t a = i * (FIELD_SLICES + 1) + j, b = a + FIELD_SLICES + 1,
                     both[2][3] = {{a, a + 1, b}, {a + 1, b + 1, b}};
      memcpy(s->indices[n], both, sizeof both), n += 2;
    }
}

/* The matrices of sphere i, 3 x 4 by rows: turned about two axes; it moves and turns a little until the second key. */
EX_UNUSED static void field_transforms(uint32_t i, float keys[2][12]) {
  uint32_t state = 977 * i + 1;
  const float size = 0.3f + 0.15f * field_random(&state), a = 6.2831853f * field_random(&state),
              b = 6.2831853f * field_random(&state);
  float step[3];
  for (int k = 0; k < 3; k++) step[k] = 0.3f * (field_random(&state) - 0.5f);
  for (int k = 0; k < 2; k++) {
    const float c = cosf(a + 0.3f * (float)k), s = sinf(a + 0.3f * (float)k), d = cosf(b), e = sinf(b);
    const float m[12] = {size * c, -size * s, 0, (float)(i % FIELD_SIDE) + (float)k * step[0], size * s * d,
        size * c * d, -size * e, (float)(i / FIELD_SIDE % FIELD_SIDE) + (float)k * step[1], size * s * e, size * c * e,
        size * d, (float)(i / (FIELD_SIDE * FIELD_SIDE)) + (float)k * step[2]};
    memcpy(keys[k], m, sizeof m);
  }
}

/* The vertices where a matrix takes them. */
EX_UNUSED static void field_place(const field_sphere *s, const float m[12], float (*out)[3]) {
  for (uint32_t i = 0; i < FIELD_VERTICES; i++)
    for (int a = 0; a < 3; a++) {
      const float *v = s->positions[i], *by = m + 4 * a;
      out[i][a] = by[0] * v[0] + by[1] * v[1] + by[2] * v[2] + by[3];
    }
}

#endif /* BENCH_FIELD_H */
