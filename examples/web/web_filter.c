/* web_filter.c - takes noise out of the page's previews, by the filter of ../filter.h.

   A preview for the filter is two passes of one sample, which are its two halves. Workers render bands of both, and the page
   puts these together. Then workers filter bands of the whole preview, each with web_filter_margin rows more above and below:
   no result depends on pixels farther away, so the bits are those of a filter of the whole preview, and bands have no seams.

     web_filter_room(width * rows), web_render_halves(y, rows)               halves and their features, in the room
     web_filter_room(width * rows), web_filter_rows(width, rows, y, count)   the filtered pixels, in the room as well */
#include "web.h"

#include "../filter.h"

/* Floats a pixel: colours and features of both halves, which come and go; then the variance, and the filtered colours. */
enum { WEB_HALVES = 2 * (3 + FILTER_FEATURES), WEB_ROOM = WEB_HALVES + 1 + 3 };

static struct {
  float *room; /* planes of a band, one after the other in this order */
  size_t pixels, most;
  float *buffers; /* depths, normals and albedos of a whole preview */
  size_t buffered;
} filtering;

/* Makes room for a band of so many pixels. NULL: there is not enough memory. */
WEB_EXPORT float *web_filter_room(unsigned pixels) {
  filtering.pixels = pixels;
  if (pixels <= filtering.most) return filtering.room;

  free(filtering.room);
  filtering.room = (float *)malloc(sizeof(float) * WEB_ROOM * pixels);
  filtering.most = filtering.room ? pixels : 0;
  return filtering.room;
}

/* Rows around a band that decide about its pixels. */
WEB_EXPORT unsigned web_filter_margin(void) { return FILTER_BORDER; }

static float *colours(int half) { return filtering.room + (size_t)half * 3 * filtering.pixels; }

static float *features(int half) { return filtering.room + (6 + (size_t)half * FILTER_FEATURES) * filtering.pixels; }

/* Copies a rendered pass from pixel `first` on to the planes of its half. Where nothing is met the depth counts as 0. */
static void keep_half(int half, size_t first, const float *depth, const float *normal, const float *albedo) {
  float *feature = features(half);
  memcpy(colours(half), web_pixels() + 3 * first, 3 * sizeof(float) * filtering.pixels);
  for (size_t i = first; i < first + filtering.pixels; i++, feature += FILTER_FEATURES) {
    feature[0] = depth[i] < 1e15f ? depth[i] : 0;
    memcpy(feature + 1, normal + 3 * i, 3 * sizeof(float));
    memcpy(feature + 4, albedo + 3 * i, 3 * sizeof(float));
  }
}

/* Renders rows of both halves into the room, which has been made for them. */
WEB_EXPORT int web_render_halves(unsigned y, unsigned rows) {
  const size_t width = web_view()->width, n = width * web_view()->height;
  if (n > filtering.buffered) {
    free(filtering.buffers);
    filtering.buffers = (float *)malloc(sizeof(float) * FILTER_FEATURES * n);
    filtering.buffered = filtering.buffers ? n : 0;
  }
  if (!filtering.room || !filtering.buffers || filtering.pixels != width * rows)
    return web_fail("there is not enough memory for the filter");

  float *const depth = filtering.buffers, *const normal = depth + n, *const albedo = normal + 3 * n;
  int failed = 0;
  web_features(depth, normal, albedo);
  for (int half = 0; half < 2 && !failed; half++) {
    failed = web_render_band(y, rows, 1, (unsigned)half);
    if (!failed) keep_half(half, width * y, depth, normal, albedo);
  }
  web_features(NULL, NULL, NULL);
  return failed;
}

/* Filters `count` rows from `y` on of the rows in the room. Their places among the filtered colours are filled. */
WEB_EXPORT int web_filter_rows(unsigned width, unsigned rows, unsigned y, unsigned count) {
  if (!filtering.room || filtering.pixels != (size_t)width * rows)
    return web_fail("there is not enough memory for the filter");

  /* The squared error of a mean of two: a quarter of their squared difference, twice for a half, as in filter_finish. */
  float *const variance = filtering.room + WEB_HALVES * filtering.pixels, *const out = variance + filtering.pixels;
  for (size_t i = 0; i < filtering.pixels; i++) {
    float squared = 0;
    for (size_t c = 0; c < 3; c++) {
      const float apart = colours(0)[3 * i + c] - colours(1)[3 * i + c];
      squared += apart * apart;
    }
    variance[i] = 0.5f * squared;
  }

  filter_picture picture;
  memset(&picture, 0, sizeof picture);
  picture.width = width;
  picture.height = rows;
  picture.variance = variance;
  for (int half = 0; half < 2; half++) {
    picture.half[half] = colours(half);
    picture.features[half] = features(half);
  }
  for (unsigned x = 0; x < width; x += FILTER_TILE) {
    const unsigned columns = width - x < FILTER_TILE ? width - x : FILTER_TILE;
    if (!filter_rectangle(&picture, x, y, columns, count, out, NULL))
      return web_fail("there is not enough memory for the filter");
  }
  return 0;
}
