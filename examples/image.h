/* Pictures as textures and as environments: .hdr; .png, .jpg, .bmp and .tga by stb_image, if it is there (Debian's
   libstb-dev); or bytes that the program has.

   Where things are in a picture: u runs from its left edge, 0, to its right edge, 1, and v from its LOWER edge, 0, to
   its upper edge, 1, as in OBJ files and in what assimp makes of any file. Texel i of n, counted from the left or from
   below, has its centre at (i + 0.5) / n; there image_at returns it unmixed. Between centres the four nearest are
   mixed, in linear light.

   Files come from anywhere: their sizes are limited, and what is corrupt is refused. The same file gives the same bits
   everywhere. Include after common.h and pktrt.h.

   Contents: image, bytes, hdr, load, texture, environment. */
#ifndef EXAMPLES_IMAGE_H
#define EXAMPLES_IMAGE_H

#include <float.h>

/* Where stb_image is not, or IMAGE_NO_STB is defined, all but .hdr is refused by one line that says so. */
#if !defined(HAVE_STB_IMAGE) && !defined(IMAGE_NO_STB) && defined(__has_include)
#if __has_include(<stb/stb_image.h>)
#define HAVE_STB_IMAGE
#endif
#endif

#define IMAGE_MAX_SIZE 16384u       /* texels along an edge */
#define IMAGE_MAX_TEXELS (1u << 27) /* of a picture: 16384 x 8192, half a gigabyte, as floats three times that */
#define IMAGE_MAX_BYTES (1u << 30)  /* of a file */

#ifdef HAVE_STB_IMAGE
#ifdef __GNUC__ /* not static, for it declares functions that it leaves out; nor seen by libraries that have it, too */
#define STBIDEF extern __attribute__((visibility("hidden")))
#endif
#define STB_IMAGE_IMPLEMENTATION
#define STBI_NO_STDIO
#define STBI_NO_SIMD /* whose .jpg differ from machine to machine */
#define STBI_MAX_DIMENSIONS 16384
#define STBI_ONLY_JPEG
#define STBI_ONLY_PNG
#define STBI_ONLY_BMP
#define STBI_ONLY_TGA
#define STBI_NO_HDR /* which older ones read without end; see >>hdr */
#define STBI_NO_LINEAR
#include <stb/stb_image.h>
#endif

/* >>image ---------------------------------------------------------------------------------------------------------- */

typedef struct image { /* zeroed: none */
  uint32_t width, height;
  unsigned char *codes; /* RGBA, four bytes a texel, the upper row first; NULL: there are floats */
  float *floats;        /* linear RGB, three a texel, the upper row first; NULL: there are codes */
  float linear[256];    /* what a code of red, green or blue means, in [0,1]; alpha is code / 255 */
} image;

/* What is beyond the edges. */
typedef enum image_wrap { IMAGE_REPEAT = 0, IMAGE_CLAMP, IMAGE_MIRROR } image_wrap;

/* Frees what it has and makes it none. */
EX_UNUSED static void image_free(image *picture) {
  free(picture->codes);
  free(picture->floats);
  memset(picture, 0, sizeof *picture);
}

/* Two texels of a row or column that a place lies between, and how far it is from the first to the second. */
typedef struct image_between {
  size_t first, second;
  double part;
} image_between;

/* Returns the texel that counts for texel i, which may be one beyond either edge of n. */
static size_t image_wrapped(double i, double n, image_wrap wrap) {
  const bool repeats = wrap == IMAGE_REPEAT;
  if (i < 0) return (size_t)(repeats ? i + n : 0);
  if (i >= n) return (size_t)(repeats ? i - n : n - 1);
  return (size_t)i;
}

/* Finds the texels about a coordinate. One that is not finite counts as 0. */
static image_between image_find(float coordinate, uint32_t size, image_wrap wrap) {
  const double n = (double)size;
  double at = coordinate >= -FLT_MAX && coordinate <= FLT_MAX ? (double)coordinate : 0;
  image_between found;

  if (wrap == IMAGE_REPEAT) at -= floor(at);
  if (wrap == IMAGE_MIRROR) {
    at -= 2 * floor(0.5 * at);
    if (at > 1) at = 2 - at;
  }
  if (wrap == IMAGE_CLAMP) at = fmin(fmax(at, 0), 1);

  const double place = at * n - 0.5;
  const double below = floor(place);
  found.first = image_wrapped(below, n, wrap);
  found.second = image_wrapped(below + 1, n, wrap);
  found.part = place - below;
  return found;
}

/* Gets the linear values of a texel; row 0 is the upper one. */
static void image_texel(const image *picture, size_t column, size_t row, double rgba[4]) {
  const size_t at = row * picture->width + column;
  rgba[3] = 1;
  if (picture->floats) {
    for (size_t c = 0; c < 3; c++) rgba[c] = (double)picture->floats[3 * at + c];
    return;
  }
  const unsigned char *code = picture->codes + 4 * at;
  for (int c = 0; c < 3; c++) rgba[c] = (double)picture->linear[code[c]];
  rgba[3] = (double)code[3] / 255;
}

/* Gets the linear values at (u, v), mixed of the four nearest texels; alpha is 1 where the file has none. u and v that
   are not finite count as 0. No picture is white. */
EX_UNUSED static void image_at(
    const image *picture, float u, float v, image_wrap wrap_u, image_wrap wrap_v, float rgba[4]) {
  if (!picture->codes && !picture->floats) {
    for (int c = 0; c < 4; c++) rgba[c] = 1;
    return;
  }
  const image_between across = image_find(u, picture->width, wrap_u);
  const image_between up = image_find(v, picture->height, wrap_v);
  const size_t last = picture->height - 1u;
  double corner[4][4];
  image_texel(picture, across.first, last - up.first, corner[0]);
  image_texel(picture, across.second, last - up.first, corner[1]);
  image_texel(picture, across.first, last - up.second, corner[2]);
  image_texel(picture, across.second, last - up.second, corner[3]);
  for (int c = 0; c < 4; c++) {
    const double lower = corner[0][c] + (corner[1][c] - corner[0][c]) * across.part;
    const double upper = corner[2][c] + (corner[3][c] - corner[2][c]) * across.part;
    rgba[c] = (float)(lower + (upper - lower) * up.part);
  }
}

/* >>bytes ---------------------------------------------------------------------------------------------------------- */

/* Says what codes mean: sRGB, or for what is no colour, such as normals and roughness, plain fractions. */
static void image_set_codes(image *picture, bool srgb) {
  for (int i = 0; i < 256; i++) {
    const double code = (double)i / 255;
    picture->linear[i] = (float)(srgb ? ex_srgb_decode(code) : code);
  }
}

/* Copies width x height texels, four bytes each, the upper row first. False after saying why not; then it is none. */
EX_UNUSED static bool image_from_rgba8(
    image *picture, uint32_t width, uint32_t height, const unsigned char *rgba, bool srgb) {
  memset(picture, 0, sizeof *picture);
  if (!rgba || width == 0 || height == 0) return ex_fail("a picture of %u x %u: there is none", width, height);
  if (width > IMAGE_MAX_SIZE || height > IMAGE_MAX_SIZE || (uint64_t)width * height > IMAGE_MAX_TEXELS)
    return ex_fail("a picture of %u x %u: too large, %u along an edge and %u in all are the most", width, height,
        IMAGE_MAX_SIZE, IMAGE_MAX_TEXELS);
  const size_t bytes = (size_t)width * height * 4;
  picture->codes = (unsigned char *)malloc(bytes);
  if (!picture->codes) return ex_fail("a picture of %u x %u: not enough memory", width, height);
  memcpy(picture->codes, rgba, bytes);
  picture->width = width;
  picture->height = height;
  image_set_codes(picture, srgb);
  return true;
}

/* Says that a picture is larger than it may be, or takes more texels than its file can hold, a byte `packed` at most.
   */
static bool image_check_size(const char *name, uint32_t width, uint32_t height, size_t size, unsigned packed) {
  const uint64_t texels = (uint64_t)width * height;
  if (texels == 0 || width > IMAGE_MAX_SIZE || height > IMAGE_MAX_SIZE || texels > IMAGE_MAX_TEXELS)
    return ex_fail("%s: a picture of %u x %u, but %u along an edge and %u texels in all are the most", name, width,
        height, IMAGE_MAX_SIZE, IMAGE_MAX_TEXELS);
  return texels <= (uint64_t)size * packed || ex_fail("%s: announces a picture of %u x %u, which %lu bytes cannot hold",
                                                  name, width, height, (unsigned long)size);
}

/* >>hdr ------------------------------------------------------------------------------------------------------------ */

/* Radiance's .hdr: lines of text, an empty one, the size, then rows of texels of four bytes: three mantissas that share
   an exponent. Of a row come all red mantissas, then all green ones, and so on, with runs of equal bytes packed; or the
   texels one after the other, as they are. Its EXPOSURE is not looked at. */
typedef struct image_bytes {
  const unsigned char *at, *end;
} image_bytes;

/* Reads a line without its end; false where there is none, or it is too long. */
static bool image_hdr_line(image_bytes *from, char line[128]) {
  for (int n = 0; n < 127 && from->at < from->end; n++) {
    line[n] = (char)*from->at++;
    if (line[n] != '\n') continue;
    line[n] = 0;
    return true;
  }
  return false;
}

/* Tells by the first bytes whether a file is a .hdr. */
static bool image_is_hdr(const unsigned char *bytes, size_t size) {
  return (size > 10 && !memcmp(bytes, "#?RADIANCE", 10)) || (size > 6 && !memcmp(bytes, "#?RGBE", 6));
}

/* Reads the lines of text. */
static bool image_hdr_header(image_bytes *from, const char *name, uint32_t *width, uint32_t *height) {
  char line[128];
  bool known = false, good = true;
  unsigned across = 0, down = 0;
  while ((good = image_hdr_line(from, line)) && line[0])
    if (!strcmp(line, "FORMAT=32-bit_rle_rgbe")) known = true;
  if (!good || !image_hdr_line(from, line)) return ex_fail("%s: corrupt: no size", name);
  if (!known) return ex_fail("%s: not of FORMAT=32-bit_rle_rgbe", name);
  if (sscanf(line, "-Y %9u +X %9u", &down, &across) != 2)
    return ex_fail("%s: not a picture of rows from the top, each from the left (-Y ... +X ...)", name);
  *width = across;
  *height = down;
  return image_check_size(name, across, down, (size_t)(from->end - from->at), 16);
}

/* Unpacks n bytes. */
static bool image_hdr_unpack(image_bytes *from, unsigned char *to, size_t n) {
  while (n > 0) {
    if (from->end - from->at < 2) return false;
    size_t count = *from->at++;
    const bool run = count > 128;
    if (run) count -= 128;
    if (count == 0 || count > n || (size_t)(from->end - from->at) < (run ? 1 : count)) return false;
    if (run) memset(to, *from->at, count);
    else memcpy(to, from->at, count);
    from->at += run ? 1 : count;
    to += count;
    n -= count;
  }
  return true;
}

/* Reads a row: byte b of texel i becomes row[i + b width]. */
static bool image_hdr_row(image_bytes *from, unsigned char *row, size_t width) {
  const unsigned char *at = from->at;
  const size_t left = (size_t)(from->end - at);
  if (width >= 8 && left >= 4 && at[0] == 2 && at[1] == 2 && at[2] < 128) {
    from->at += 4;
    return (size_t)at[2] * 256 + at[3] == width && image_hdr_unpack(from, row, width) &&
           image_hdr_unpack(from, row + width, width) && image_hdr_unpack(from, row + 2 * width, width) &&
           image_hdr_unpack(from, row + 3 * width, width);
  }
  if (left < 4 * width) return false;
  for (size_t i = 0; i < 4 * width; i++) row[i / 4 + i % 4 * width] = at[i];
  from->at += 4 * width;
  return true;
}

/* Reads a picture of floats. False after saying why not. */
static bool image_load_hdr(image *picture, const char *name, const unsigned char *bytes, size_t size) {
  image_bytes from = {bytes, bytes + size};
  uint32_t width = 0, height = 0, y = 0;
  if (!image_hdr_header(&from, name, &width, &height)) return false;
  float *floats = (float *)malloc((size_t)width * height * 3 * sizeof *floats);
  unsigned char *row = (unsigned char *)malloc((size_t)width * 4);
  const bool memory = floats && row;
  for (; memory && y < height && image_hdr_row(&from, row, width); y++)
    for (size_t i = 0; i < width; i++) {
      const int exponent = row[i + (size_t)3 * width];
      const double unit = exponent ? ldexp(1, exponent - 136) : 0;
      float *texel = floats + 3 * ((size_t)y * width + i);
      for (size_t c = 0; c < 3; c++) texel[c] = (float)(row[i + c * width] * unit);
    }
  free(row);
  if (memory && y == height) {
    picture->floats = floats;
    picture->width = width;
    picture->height = height;
    return true;
  }
  free(floats);
  return memory ? ex_fail("%s: corrupt or cut off in row %u of %u", name, y + 1, height)
                : ex_fail("%s: not enough memory for a picture of %u x %u", name, width, height);
}

/* >>load ----------------------------------------------------------------------------------------------------------- */

#ifdef HAVE_STB_IMAGE

/* Returns how many texels a byte of a file may hold at most: of a PNG of one colour 8 x 1032, of a JPEG a block of 32 x
   32 in 18 bits, of others a run of 128 in two bytes. */
static unsigned image_texels_a_byte(const unsigned char *bytes, size_t size) {
  if (size < 2) return 0;
  if (bytes[0] == 0x89 && bytes[1] == 'P') return 8256;
  return bytes[0] == 0xff && bytes[1] == 0xd8 ? 512 : 64;
}

/* Reads a picture of codes; its size is looked at before anything is allocated. */
static bool image_load_codes(image *picture, const char *name, const unsigned char *bytes, size_t size) {
  int width = 0, height = 0, channels = 0;
  if (!stbi_info_from_memory(bytes, (int)size, &width, &height, &channels) || width < 1 || height < 1)
    return ex_fail(
        "%s: not a picture that can be read (.png, .jpg, .bmp, .tga, .hdr): %s", name, stbi_failure_reason());
  if (!image_check_size(name, (uint32_t)width, (uint32_t)height, size, image_texels_a_byte(bytes, size))) return false;
  picture->codes = stbi_load_from_memory(bytes, (int)size, &width, &height, &channels, 4);
  if (!picture->codes)
    return ex_fail("%s: corrupt, or of a kind that stb_image does not read: %s", name, stbi_failure_reason());
  picture->width = (uint32_t)width;
  picture->height = (uint32_t)height;
  return true;
}

#else

/* Refuses all pictures of codes. */
static bool image_load_codes(image *picture, const char *name, const unsigned char *bytes, size_t size) {
  (void)picture;
  (void)bytes;
  (void)size;
  return ex_fail("%s: this program was built without stb_image and reads .hdr alone (libstb-dev brings it)", name);
}

#endif

/* Reads a picture from the bytes of a file; `name` is for what is said. srgb: codes of 8 bits are colours; floats, as
   those of .hdr, are linear anyway. False after saying why not; then it is none. */
EX_UNUSED static bool image_load_memory(image *picture, const char *name, const void *bytes, size_t size, bool srgb) {
  const unsigned char *from = (const unsigned char *)bytes;
  memset(picture, 0, sizeof *picture);
  if (!bytes || size == 0) return ex_fail("%s: empty, there is no picture", name);
  if (size > IMAGE_MAX_BYTES) return ex_fail("%s: larger than a gigabyte", name);
  image_set_codes(picture, srgb);
  if (image_is_hdr(from, size) ? image_load_hdr(picture, name, from, size)
                               : image_load_codes(picture, name, from, size))
    return true;
  memset(picture, 0, sizeof *picture);
  return false;
}

/* Opens a file; *size receives how many bytes it has. NULL after saying why not. */
static FILE *image_open(const char *path, size_t *size) {
  struct stat info;
  FILE *file = NULL;
  if (stat(path, &info) != 0) ex_fail("%s: cannot be read: %s", path, strerror(errno));
  else if (!S_ISREG(info.st_mode)) ex_fail("%s: not a regular file", path);
  else if (info.st_size > (off_t)IMAGE_MAX_BYTES) ex_fail("%s: larger than a gigabyte", path);
  else {
    file = fopen(path, "rb");
    if (!file) ex_fail("%s: cannot be read: %s", path, strerror(errno));
    *size = (size_t)info.st_size;
  }
  return file;
}

/* Returns the bytes of a file, to be freed by the caller; *size receives how many. NULL after saying why not. */
static void *image_read_file(const char *path, size_t *size) {
  FILE *file = image_open(path, size);
  if (!file) return NULL;
  void *bytes = malloc(*size + 1);
  if (!bytes) {
    ex_fail("%s: not enough memory", path);
  } else if (fread(bytes, 1, *size, file) != *size) {
    ex_fail("%s: cannot be read to its end", path);
    free(bytes);
    bytes = NULL;
  }
  fclose(file);
  return bytes;
}

/* The same, from a file. */
EX_UNUSED static bool image_load(image *picture, const char *path, bool srgb) {
  size_t size = 0;
  memset(picture, 0, sizeof *picture);
  void *bytes = image_read_file(path, &size);
  const bool ok = bytes && image_load_memory(picture, path, bytes, size, srgb);
  free(bytes);
  return ok;
}

/* >>texture -------------------------------------------------------------------------------------------------------- */

/* The `user` of a material whose `texture` is image_texture. */
typedef struct image_texture_user {
  const image *picture;
  image_wrap wrap_u, wrap_v;
} image_texture_user;

/* A texture: albedo is the picture's colour, and opacity its alpha, which counts if the material is a cutout. */
EX_UNUSED static void image_texture(void *user, const pktrt_points *points) {
  const image_texture_user *use = (const image_texture_user *)user;
  for (uint32_t i = 0; i < points->n; i++) {
    float rgba[4];
    image_at(use->picture, points->texcoord[0][i], points->texcoord[1][i], use->wrap_u, use->wrap_v, rgba);
    for (int c = 0; c < 3; c++) points->albedo[c][i] = rgba[c] < 1 ? rgba[c] : 1; /* a .hdr may have more */
    points->opacity[i] = rgba[3];
  }
}

/* >>environment ---------------------------------------------------------------------------------------------------- */

/* The `user` of a render whose `environment` is image_environment: a picture of all directions, twice as wide as high,
   the zenith along its upper edge. Its middle is at -z, or where z is up, at +y, and what is right of it in the picture
   is towards +x. */
typedef struct image_environment_user {
  const image *picture;
  float turn; /* degrees about the upward axis, counter-clockwise seen from above: so far the picture's middle moves */
  float strength; /* factor on all values */
  bool up_z;      /* z is up; else y */
} image_environment_user;

/* Returns the arc tangent of x in [0,1], in radians: plain arithmetic, so the same bits everywhere. The angle is halved
   three times, to 0.099 at most; there the eighth term of the series is below 1e-16. */
static double image_arc_tangent(double x) {
  const double half = x / (1 + sqrt(1 + x * x));
  const double quarter = half / (1 + sqrt(1 + half * half));
  const double t = quarter / (1 + sqrt(1 + quarter * quarter));
  const double t2 = t * t;
  double sum = 0;
  for (int k = 7; k >= 0; k--) sum = 1.0 / (2 * k + 1) - t2 * sum;
  return 8 * t * sum;
}

/* Returns the angle of the point (x, y) from the x axis in turns, in [-0.5, 0.5]; 0 at the origin. */
static double image_angle(double x, double y) {
  const double along = fabs(x), aside = fabs(y);
  const double turns = 1 / 6.283185307179586;
  double angle = 0;
  if (along > 0 || aside > 0)
    angle = aside <= along ? image_arc_tangent(aside / along) * turns : 0.25 - image_arc_tangent(along / aside) * turns;
  if (x < 0) angle = 0.5 - angle;
  return y < 0 ? -angle : angle;
}

/* An environment: the radiance that the picture has in each direction. */
EX_UNUSED static void image_environment(
    void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  const image_environment_user *use = (const image_environment_user *)user;
  for (uint32_t i = 0; i < n; i++) {
    const double right = (double)direction[0][i];
    const double up = (double)direction[use->up_z ? 2 : 1][i];
    const double ahead = use->up_z ? (double)direction[1][i] : -(double)direction[2][i];
    const double u = 0.5 + image_angle(ahead, right) + (double)use->turn / 360;
    const double v = 0.5 + 2 * image_angle(sqrt(right * right + ahead * ahead), up);
    float rgba[4];
    image_at(use->picture, (float)u, (float)v, IMAGE_REPEAT, IMAGE_CLAMP, rgba);
    for (int c = 0; c < 3; c++) radiance[c][i] = use->strength * rgba[c];
  }
}

#endif /* EXAMPLES_IMAGE_H */
