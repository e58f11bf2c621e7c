/* Compares a part of a screen with a picture: screenshot SCREEN X Y PICTURE.png [PART.png]

   SCREEN is what `Xvfb -fbdir` keeps of its screen, a file in the format of xwd. The part at X, Y of the picture's size
   must equal the picture in every pixel, and have more colours than a window without a picture would. PART.png receives
   it, to be looked at. Exit status 0: equal; 1: not; 2: could not be compared. */
#include "../../examples/common.h"

#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#include <stb/stb_image.h>

enum { LEAST_COLOURS = 500 };

/* Places in the header, 32 bits each. */
/* clang-format off */
enum {
  XWD_SIZE = 0, XWD_FORMAT = 2, XWD_WIDTH = 4, XWD_HEIGHT = 5, XWD_ORDER = 7, XWD_BITS = 11, XWD_LINE = 12,
  XWD_RED = 14, XWD_GREEN = 15, XWD_BLUE = 16, XWD_COLOURS = 19, XWD_WORDS = 25
};
/* clang-format on */

typedef struct screen {
  uint32_t word[XWD_WORDS]; /* the header */
  unsigned char *bytes;     /* of the pixels: blue, green, red, nothing */
} screen;

/* The header is big-endian, whatever the machine. */
static bool read_header(screen *s, FILE *file) {
  unsigned char bytes[4 * XWD_WORDS];
  if (fread(bytes, 1, sizeof bytes, file) != sizeof bytes) return false;
  for (int i = 0; i < XWD_WORDS; i++)
    s->word[i] = (uint32_t)bytes[4 * i] << 24 | (uint32_t)bytes[4 * i + 1] << 16 | (uint32_t)bytes[4 * i + 2] << 8 |
                 (uint32_t)bytes[4 * i + 3];
  const uint32_t *w = s->word;
  return w[XWD_FORMAT] == 2 && w[XWD_ORDER] == 0 && w[XWD_BITS] == 32 && w[XWD_RED] == 0xFF0000 &&
         w[XWD_GREEN] == 0xFF00 && w[XWD_BLUE] == 0xFF && w[XWD_WIDTH] <= EX_MAX_SIZE && w[XWD_HEIGHT] <= EX_MAX_SIZE &&
         w[XWD_LINE] <= 65536 && w[XWD_LINE] >= 4 * w[XWD_WIDTH] && w[XWD_SIZE] <= 65536 && w[XWD_COLOURS] <= 65536;
}

static bool read_screen(screen *s, const char *path) {
  FILE *file = fopen(path, "rb");
  if (!file) return ex_fail("%s: %s", path, strerror(errno));
  bool ok = read_header(s, file) && fseek(file, (long)(s->word[XWD_SIZE] + 12 * s->word[XWD_COLOURS]), SEEK_SET) == 0;
  const size_t n = ok ? (size_t)s->word[XWD_LINE] * s->word[XWD_HEIGHT] : 0;
  s->bytes = (unsigned char *)malloc(n + 1);
  ok = ok && s->bytes && fread(s->bytes, 1, n, file) == n;
  fclose(file);
  return ok || ex_fail("%s: not a screen of 24 bits, little-endian", path);
}

static unsigned char *cut(const screen *s, unsigned x, unsigned y, unsigned width, unsigned height) {
  if (x + width > s->word[XWD_WIDTH] || y + height > s->word[XWD_HEIGHT]) return NULL;
  unsigned char *part = (unsigned char *)malloc((size_t)width * height * 3 + 1);
  for (unsigned row = 0; part && row < height; row++)
    for (unsigned column = 0; column < width; column++)
      for (unsigned c = 0; c < 3; c++)
        part[((size_t)row * width + column) * 3 + c] =
            s->bytes[(size_t)(y + row) * s->word[XWD_LINE] + (x + column) * 4 + 2 - c];
  return part;
}

static int by_value(const void *a, const void *b) {
  const uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
  return x < y ? -1 : x > y;
}

static size_t count_colours(const unsigned char *rgb, size_t pixels) {
  uint32_t *colours = (uint32_t *)malloc(pixels * sizeof(uint32_t) + 1);
  size_t n = 0;
  if (!colours) return 0;
  for (size_t i = 0; i < pixels; i++)
    colours[i] = (uint32_t)rgb[3 * i] << 16 | (uint32_t)rgb[3 * i + 1] << 8 | (uint32_t)rgb[3 * i + 2];
  qsort(colours, pixels, sizeof(uint32_t), by_value);
  for (size_t i = 0; i < pixels; i++) n += i == 0 || colours[i] != colours[i - 1];
  free(colours);
  return n;
}

static size_t count_differences(const unsigned char *a, const unsigned char *b, size_t pixels) {
  size_t n = 0;
  for (size_t i = 0; i < pixels; i++) n += memcmp(a + 3 * i, b + 3 * i, 3) != 0;
  return n;
}

static int compare(const screen *s, unsigned x, unsigned y, const char *path, const char *part_path) {
  int width = 0, height = 0, result = 2;
  unsigned char *picture = stbi_load(path, &width, &height, NULL, 3);
  if (!picture) return ex_fail("%s: %s", path, stbi_failure_reason()), 2;
  const size_t pixels = (size_t)width * (size_t)height;
  unsigned char *part = cut(s, x, y, (unsigned)width, (unsigned)height);
  if (part) {
    const size_t colours = count_colours(part, pixels), different = count_differences(part, picture, pixels);
    printf(
        "%d x %d at %u, %u: %zu colours, %zu pixels differ from %s\n", width, height, x, y, colours, different, path);
    result = different == 0 && colours >= LEAST_COLOURS ? 0 : 1;
    if (part_path && !stbi_write_png(part_path, width, height, 3, part, 3 * width)) result = 2;
  } else {
    ex_fail("%s: %d x %d at %u, %u is not within the screen", path, width, height, x, y);
  }
  stbi_image_free(picture);
  free(part);
  return result;
}

int main(int argc, char **argv) {
  screen s;
  unsigned x = 0, y = 0;
  memset(&s, 0, sizeof s);
  if (argc < 5 || argc > 6) return ex_fail("usage: screenshot SCREEN X Y PICTURE.png [PART.png]"), 2;
  const int result =
      ex_parse_uint("x", argv[2], 0, 16384, &x) && ex_parse_uint("y", argv[3], 0, 16384, &y) && read_screen(&s, argv[1])
          ? compare(&s, x, y, argv[4], argc == 6 ? argv[5] : NULL)
          : 2;
  free(s.bytes);
  return result;
}
