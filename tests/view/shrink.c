/* Makes a small picture of a large one: shrink FROM TO.png WIDTH

   FROM is whatever stb_image reads. A pixel of the small picture is the mean of what it covers, taken in linear light. */
#include "../../examples/common.h"

#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_ONLY_PNM
#include <stb/stb_image.h>

typedef struct picture {
  unsigned char *codes; /* three a pixel */
  int width, height;
} picture;

/* How much of the pixel i lies between two places. */
static double share(int i, double from, double to) {
  const double first = from > i ? from : i;
  const double last = to < i + 1 ? to : i + 1;
  return last > first ? last - first : 0;
}

/* Finds the mean of a rectangle of the picture, in pixels. */
static void average(
    const picture *p, const double linear[256], const double low[2], const double high[2], float out[3]) {
  double sum[3] = {0, 0, 0};
  double all = 0;

  for (int y = (int)low[1]; y < p->height && y < high[1]; y++)
    for (int x = (int)low[0]; x < p->width && x < high[0]; x++) {
      const double weight = share(x, low[0], high[0]) * share(y, low[1], high[1]);
      const unsigned char *code = p->codes + 3 * ((size_t)y * (size_t)p->width + (size_t)x);
      for (int c = 0; c < 3; c++) sum[c] += weight * linear[code[c]];
      all += weight;
    }
  for (int c = 0; c < 3; c++) out[c] = (float)(sum[c] / all);
}

/* Returns linear values of the small picture, or NULL if there is no memory. */
static float *shrink(const picture *p, unsigned width, unsigned height) {
  float *shrunk = (float *)malloc(3 * sizeof(float) * width * height);
  const double step[2] = {(double)p->width / width, (double)p->height / height};
  double linear[256];

  for (int i = 0; i < 256; i++) linear[i] = i <= 10 ? i / 255.0 / 12.92 : pow((i / 255.0 + 0.055) / 1.055, 2.4);
  for (unsigned y = 0; shrunk && y < height; y++)
    for (unsigned x = 0; x < width; x++) {
      const double low[2] = {step[0] * x, step[1] * y};
      const double high[2] = {step[0] * (x + 1), step[1] * (y + 1)};
      average(p, linear, low, high, shrunk + 3 * ((size_t)y * width + x));
    }
  return shrunk;
}

int main(int argc, char **argv) {
  unsigned width = 0;
  picture p;

  stbi_write_png_compression_level = 64; /* small files are worth the time */
  if (argc != 4) return ex_fail("usage: shrink FROM TO.png WIDTH"), 2;
  if (!ex_parse_uint("WIDTH", argv[3], 1, EX_MAX_SIZE, &width)) return 2;
  p.codes = stbi_load(argv[1], &p.width, &p.height, NULL, 3);
  if (!p.codes) return ex_fail("%s: %s", argv[1], stbi_failure_reason()), 1;
  if ((int)width > p.width) return ex_fail("%s is only %d pixels wide", argv[1], p.width), 1;

  const unsigned height = (unsigned)((double)p.height * width / p.width + 0.5);
  float *shrunk = height ? shrink(&p, width, height) : NULL;
  const bool ok = shrunk ? ex_write_picture(argv[2], shrunk, width, height) : ex_fail("there is no memory");
  free(shrunk);
  stbi_image_free(p.codes);
  return ok ? 0 : 1;
}
