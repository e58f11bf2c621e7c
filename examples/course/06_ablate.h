/* 06_ablate.h - what the exercise of chapter 6 shares with its check: the question, and rays in the conference room. */
#ifndef ABLATE_H
#define ABLATE_H

#include "course.h"
#include "../scenes.h"

typedef enum ablate_cost { ABLATE_BOX_TESTS, ABLATE_TRIANGLE_TESTS, ABLATE_VECTOR_TESTS } ablate_cost;

/* The exercise: which at most `count` of the six steps, alone, make the paper path trace these rays in packets of
   `packet_size` with the fewest tests of that kind? Vector tests are those of boxes and of triangles together. */
uint32_t ablate_fewest(
    const pktrt_scene *, const pktrt_ray *rays, size_t n, uint32_t packet_size, int count, ablate_cost cost);

/* The bits of i at even places, pushed together. With them pixels are numbered in Morton's order, where 4, 16, 64 or 256
   rays in a row, from a multiple of that on, are a square of pixels. */
EX_UNUSED static uint32_t ablate_even_bits(uint32_t i) {
  uint32_t out = 0;
  for (uint32_t k = 0; k < 16; k++) out |= (i >> 2 * k & 1) << k;
  return out;
}

/* Makes size x size rays through the pixels of a picture. */
EX_UNUSED static void ablate_camera_rays(const pktrt_camera *camera, uint32_t size, pktrt_ray *rays) {
  for (uint32_t i = 0; i < size * size; i++) {
    const double x = ablate_even_bits(i) + 0.5, y = ablate_even_bits(i >> 1) + 0.5;
    pktrt_camera_ray(camera, size, size, x, y, NULL, 0, &rays[i]);
  }
}

/* Replaces each ray by the one that a mirror would send out where it ends, or by one that hits nothing. */
EX_UNUSED static void ablate_reflect(const pktrt_scene *s, pktrt_ray *rays, size_t n) {
  for (size_t i = 0; i < n; i++) {
    pktrt_hit hit;
    pktrt_surface_info at;
    float d[3];
    pktrt_intersect(s, &rays[i], &hit);
    pktrt_surface(s, &rays[i], &hit, &at);
    const float *in = rays[i].direction, *m = at.shading_normal;
    const float along = in[0] * m[0] + in[1] * m[1] + in[2] * m[2];
    for (int a = 0; a < 3; a++) d[a] = in[a] - 2 * along * m[a];
    pktrt_spawn(s, &rays[i], &hit, d, &rays[i]);
  }
}

#endif
