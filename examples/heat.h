/* Heat maps: numbers of pixels as colours, from black over red to white, with a legend. Include after common.h. */
#ifndef EXAMPLES_HEAT_H
#define EXAMPLES_HEAT_H

#include "common.h"

static const char *const heat_words[] = {"boxes", "triangles", "vectors", NULL}; /* as pktrt_cost numbers them */

/* Gets the linear colour of a number in [0,1]; what lies outside is taken as the end that is nearer. */
static void heat_colour(double x, float rgb[3]) {
  enum { STEPS = 6 };
  static const unsigned char stops[STEPS + 1][3] = {
      {0, 0, 0}, {35, 15, 95}, {110, 25, 120}, {205, 50, 70}, {245, 125, 25}, {250, 205, 70}, {255, 255, 255}};
  const double at = x > 0 ? fmin(x, 1) * (int)STEPS : 0;
  const int below = at < (int)STEPS ? (int)at : STEPS - 1;
  for (int c = 0; c < 3; c++) {
    const double code = stops[below][c] + (at - below) * (stops[below + 1][c] - stops[below][c]);
    rgb[c] = (float)ex_srgb_decode(code / 255);
  }
}

static int heat_by_size(const void *a, const void *b) {
  const float x = *(const float *)a, y = *(const float *)b;
  return x < y ? -1 : x > y;
}

/* Returns what is white: 1, 2 or 5 times a power of ten, which one pixel of 200 exceeds at most. Negative: out of memory. */
EX_UNUSED static double heat_scale(const float *values, size_t n) {
  static const double steps[] = {1, 2, 5, 10};
  float *sorted = (float *)malloc((n + 1) * sizeof *sorted);
  if (!sorted) return -1;
  memcpy(sorted, values, n * sizeof *sorted);
  qsort(sorted, n, sizeof *sorted, heat_by_size);
  const double most = n ? fmax((double)sorted[n - 1 - n / 200], 1) : 1;
  free(sorted);
  const double ten = pow(10, floor(log10(most)));
  int i = 0;
  while (steps[i] * ten < most && i < 3) i++;
  return steps[i] * ten;
}

typedef struct heat_picture { /* linear RGB */
  float *pixels;
  unsigned width, height;
} heat_picture;

static void heat_fill(const heat_picture *p, unsigned x, unsigned y, unsigned w, unsigned h, const float rgb[3]) {
  for (unsigned j = y; j < y + h && j < p->height; j++)
    for (unsigned i = x; i < x + w && i < p->width; i++)
      memcpy(p->pixels + 3 * ((size_t)j * p->width + i), rgb, 3 * sizeof *rgb);
}

/* Writes a word of digits in cells of 3 x 5 dots, a dot being `dot` pixels wide. */
static void heat_write(const heat_picture *p, unsigned x, unsigned y, unsigned dot, const char *word) {
  static const unsigned short rows[10] = {
      075557, 026227, 071747, 071717, 055711, 074717, 074757, 071111, 075757, 075717};
  static const float white[3] = {1, 1, 1};
  for (; *word; word++, x += 4 * dot)
    for (unsigned bit = 0; bit < 15 && *word >= '0' && *word <= '9'; bit++)
      if (rows[*word - '0'] >> (14 - bit) & 1) heat_fill(p, x + bit % 3 * dot, y + bit / 3 * dot, dot, dot, white);
}

/* Paints values, from 0 to `scale`, and in the lower left corner what the colours mean, if the picture has room for it. */
EX_UNUSED static void heat_paint(const float *values, double scale, const heat_picture *p) {
  static const float black[3] = {0, 0, 0};
  for (size_t i = 0; i < (size_t)p->width * p->height; i++) heat_colour((double)values[i] / scale, p->pixels + 3 * i);
  const unsigned dot = 1 + p->width / 512, bar = p->width / 3, y = p->height - 12 * dot;
  char word[32];
  if (p->width < 96 || p->height < 48) return;
  const unsigned digits = (unsigned)snprintf(word, sizeof word, "%.0f", scale);
  heat_fill(p, 0, y - 2 * dot, bar + (9 + 4 * digits) * dot, 14 * dot, black);
  heat_write(p, 2 * dot, y + 2 * dot, dot, "0");
  for (unsigned i = 0; i < bar; i++) {
    float rgb[3];
    heat_colour((double)i / bar, rgb);
    heat_fill(p, 7 * dot + i, y, 1, 9 * dot, rgb);
  }
  heat_write(p, 8 * dot + bar, y + 2 * dot, dot, word);
}

#endif /* EXAMPLES_HEAT_H */
