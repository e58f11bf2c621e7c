/* Exercise of chapter 10: a sampler of your own.

     cp examples/course/10_exercise.c mine.c
     make course-check N=10 FILE=mine.c */
#include "course.h"

/* Returns a coordinate in [0,1) of a sample: a function of the arguments alone. *(const uint32_t *)user is n, the number of
   samples per pixel, a power of two; `sample` goes from 0 to n - 1. Of each pixel and dimension, each of the n intervals
   [i / n, (i + 1) / n) must hold one sample. But samples must lie elsewhere in them, and come in another order, for
   each pixel, dimension and seed: dimensions that walk in step leave most of the square empty.

   Two ways: intervals in a shuffled order, and a random place in each (jittered strata; in floats k + r may be rounded up to
   k + 1, which is the next interval); or Sobol' points, pair by pair: the bits of `sample` reversed in the first dimension,
   multiplied by Pascal's triangle modulo 2 in the second, both scrambled; and each pair of dimensions with the samples in a
   random order of its own. */
float own_sample(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed);
float own_sample(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  const uint32_t n = *(const uint32_t *)user;
  (void)x, (void)y, (void)dimension, (void)seed;
  return ((float)sample + 0.5f) / (float)n;
}
