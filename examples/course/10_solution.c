/* A solution of the exercise of chapter 10: pairs of dimensions are points of Sobol' in two dimensions, scrambled after Owen. */
#include "course.h"

float own_sample(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed);

static uint32_t hash(uint32_t h, uint32_t value) {
  h = (h ^ value) * 0x9E3779B1u;
  h = (h ^ h >> 15) * 0x85EBCA77u;
  return h ^ h >> 13;
}

/* Flips each of `count` bits, from the highest on, or does not, as a hash of the bits above it says. This maps intervals of
   length 2^-k to such: what is stratified stays stratified. */
static uint32_t scramble(uint32_t bits, int count, uint32_t seed) {
  uint32_t above = 1; /* the bits so far, as they were, behind a leading one that tells how many there are */
  for (int i = 31; i > 31 - count; i--) {
    const uint32_t bit = bits >> i & 1;
    bits ^= (hash(seed, above) >> 16 & 1) << i;
    above = above << 1 | bit;
  }
  return bits;
}

static uint32_t reverse(uint32_t bits) {
  uint32_t reversed = 0;
  for (int i = 0; i < 32; i++) reversed |= (bits >> i & 1) << (31 - i);
  return reversed;
}

/* The second dimension: bit i of the index adds row i of Pascal's triangle modulo 2, as direction numbers. */
static uint32_t second(uint32_t index) {
  uint32_t bits = 0;
  for (uint32_t direction = 1u << 31; index; index >>= 1, direction ^= direction >> 1)
    if (index & 1) bits ^= direction;
  return bits;
}

/* The index is shuffled for each pair, so that pairs are independent of each other. By scrambling, too: n aligned indices stay n
   aligned ones, in another order. */
float own_sample(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  (void)user;
  const uint32_t pixel = hash(hash(hash(seed, 7), x), y);
  const uint32_t index = scramble(sample, 32, hash(pixel, dimension / 2));
  const uint32_t bits = dimension % 2 ? second(index) : reverse(index);
  return (float)(scramble(bits, 24, hash(pixel, 1000 + dimension)) >> 8) / 16777216.0f;
}
