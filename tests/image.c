/* Pictures of the examples as textures and environments. The files are made here, by stb_image_write. Built plain, with
   AddressSanitizer, and without stb_image.
   usage: image, in a folder that it may write to */
#define _GNU_SOURCE
#include "../examples/common.h"

#include "../pktrt.h"

#include "../examples/image.h"

static int checks, failures;

static void check(bool good, const char *sentence, const char *figures) {
  checks++;
  failures += !good;
  printf("  %s %s (%s)\n", good ? "ok     " : "FAILED ", sentence, figures);
}

static uint32_t random_state = 1;

/* Returns a number in [0, 2^24). */
static uint32_t random_bits(void) {
  random_state = random_state * 1664525u + 1013904223u;
  return random_state >> 8;
}

static float random_between(double lo, double hi) { return (float)(lo + (hi - lo) * random_bits() / 16777216); }

/* Runs a loader with standard error kept; returns whether it refused by one line that names the file. */
static bool refuses(
    image *picture, const char *name, const void *bytes, size_t size, bool from_file, char *said, size_t room) {
  FILE *kept = tmpfile();
  const int before = dup(STDERR_FILENO);
  if (!kept || before < 0) exit(2);
  dup2(fileno(kept), STDERR_FILENO);
  const bool loaded = from_file ? image_load(picture, name, true) : image_load_memory(picture, name, bytes, size, true);
  fflush(stderr);
  dup2(before, STDERR_FILENO);
  close(before);
  rewind(kept);
  const size_t n = fread(said, 1, room - 1, kept);
  said[n] = 0;
  fclose(kept);
  const char *end = strchr(said, '\n');
  const bool one_line = strncmp(said, "error: ", 7) == 0 && strstr(said, name) && end && !end[1];
  if (end) said[end - said] = 0;
  return !loaded && one_line && !picture->codes && !picture->floats && picture->width == 0;
}

/* >>mixing --------------------------------------------------------------------------------------------------------- */

enum { WIDE = 5, HIGH = 3 };

static void random_codes(unsigned char *codes, size_t n) {
  for (size_t i = 0; i < n; i++) codes[i] = (unsigned char)(random_bits() >> 16);
}

/* Returns the place of texel i of n on the endless row that a wrap makes of it. */
static int plain_wrap(int i, int n, image_wrap wrap) {
  const int once = ((i % n) + n) % n;
  const int twice = ((i % (2 * n)) + 2 * n) % (2 * n);
  if (wrap == IMAGE_REPEAT) return once;
  if (wrap == IMAGE_MIRROR) return twice < n ? twice : 2 * n - 1 - twice;
  if (i < 0) return 0;
  return i >= n ? n - 1 : i;
}

/* Mixes the plain way: all texels of the endless picture about (u, v), each by its share, which is largest at its
   centre. */
static double plain_mix(const unsigned char *codes, double u, double v, image_wrap wrap, int channel) {
  const double x = u * WIDE, y = v * HIGH;
  double sum = 0;
  for (int i = (int)floor(x) - 2; i <= (int)floor(x) + 2; i++)
    for (int k = (int)floor(y) - 2; k <= (int)floor(y) + 2; k++) {
      const double across = 1 - fabs(x - (i + 0.5)), up = 1 - fabs(y - (k + 0.5));
      if (across <= 0 || up <= 0) continue;
      const int column = plain_wrap(i, WIDE, wrap);
      const int row = HIGH - 1 - plain_wrap(k, HIGH, wrap);
      sum += across * up * codes[4 * (row * WIDE + column) + channel] / 255;
    }
  return sum;
}

static void mixing(void) {
  static const char *const names[] = {"repeat", "clamp", "mirror"};
  unsigned char codes[4 * WIDE * HIGH];
  char text[200];
  image picture;
  random_codes(codes, sizeof codes);
  if (!image_from_rgba8(&picture, WIDE, HIGH, codes, false)) exit(2);
  for (int wrap = IMAGE_REPEAT; wrap <= IMAGE_MIRROR; wrap++) {
    double worst = 0;
    for (int i = 0; i < 20000; i++) {
      const float u = random_between(-4, 4), v = random_between(-4, 4);
      float rgba[4];
      image_at(&picture, u, v, (image_wrap)wrap, (image_wrap)wrap, rgba);
      for (int c = 0; c < 4; c++)
        worst = fmax(worst, fabs((double)rgba[c] - plain_mix(codes, (double)u, (double)v, (image_wrap)wrap, c)));
    }
    snprintf(text, sizeof text, "%s, %.3g off", names[wrap], worst);
    check(worst < 1e-6, "texels are mixed by the plain formula, also beyond the edges", text);
  }

  double worst = 0;
  for (int i = 0; i < WIDE * HIGH; i++) {
    float rgba[4];
    const double u = (i % WIDE + 0.5) / WIDE, from_below = (HIGH - 1 - i / WIDE + 0.5) / HIGH;
    image_at(&picture, (float)u, (float)from_below, IMAGE_REPEAT, IMAGE_REPEAT, rgba);
    for (int c = 0; c < 4; c++) worst = fmax(worst, fabs((double)rgba[c] - codes[4 * i + c] / 255.0));
  }
  snprintf(text, sizeof text, "%.3g off", worst);
  check(worst < 1e-6, "at its centre a texel is itself, and v grows upwards", text);

  static const float odd[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, -1e-30f, 1e30f};
  bool same = true, inside = true;
  float zero[4], rgba[4];
  for (int wrap = IMAGE_REPEAT; wrap <= IMAGE_MIRROR; wrap++) {
    image_at(&picture, 0, 0, (image_wrap)wrap, (image_wrap)wrap, zero);
    for (int i = 0; i < 7; i++) {
      image_at(&picture, odd[i], odd[6 - i], (image_wrap)wrap, (image_wrap)wrap, rgba);
      for (int c = 0; c < 4; c++) inside = inside && rgba[c] >= 0 && rgba[c] <= 1;
      if (i >= 3) continue;
      image_at(&picture, odd[i], odd[(i + 1) % 3], (image_wrap)wrap, (image_wrap)wrap, rgba);
      same = same && memcmp(rgba, zero, sizeof zero) == 0;
    }
  }
  check(same && inside, "coordinates that are not finite are as 0, and huge ones lie in the picture", "three wraps");
  image_free(&picture);

  image_at(&picture, 0.5f, 0.5f, IMAGE_REPEAT, IMAGE_REPEAT, rgba);
  check(rgba[0] >= 1 && rgba[3] >= 1 && !picture.codes, "no picture is white", "freed");
}

static void colours(void) {
  unsigned char codes[4 * 256], pair[8] = {0, 0, 0, 0, 255, 255, 255, 255};
  char text[200];
  image picture;
  double worst = 0, plain = 0;
  float rgba[4];
  for (int i = 0; i < 1024; i++) codes[i] = (unsigned char)(i / 4);
  if (!image_from_rgba8(&picture, 256, 1, codes, true)) exit(2);
  for (int i = 0; i < 256; i++) {
    const double code = i / 255.0;
    const double linear = code <= 0.04045 ? code / 12.92 : (double)powf((float)((code + 0.055) / 1.055), 2.4f);
    image_at(&picture, ((float)i + 0.5f) / 256, 0.5f, IMAGE_CLAMP, IMAGE_CLAMP, rgba);
    worst = fmax(worst, fabs((double)rgba[1] - linear));
    plain = fmax(plain, fabs((double)rgba[3] - code));
  }
  image_free(&picture);
  snprintf(text, sizeof text, "%.3g off, alpha %.3g", worst, plain);
  check(worst < 1e-6 && plain < 1e-6, "sRGB codes are decoded, alpha is not", text);

  if (!image_from_rgba8(&picture, 2, 1, pair, true)) exit(2);
  image_at(&picture, 0.5f, 0.5f, IMAGE_CLAMP, IMAGE_CLAMP, rgba);
  image_free(&picture);
  snprintf(text, sizeof text, "black and white: %.4g", (double)rgba[0]);
  check(fabs((double)rgba[0] - 0.5) < 1e-6, "light is mixed, not codes", text);

  if (!image_from_rgba8(&picture, 256, 1, codes, false)) exit(2);
  image_at(&picture, 128.5f / 256, 0.5f, IMAGE_CLAMP, IMAGE_CLAMP, rgba);
  image_free(&picture);
  snprintf(text, sizeof text, "code 128: %.4g", (double)rgba[0]);
  check(fabs((double)rgba[0] - 128 / 255.0) < 1e-6, "control: codes that are no colours are fractions", text);
}

/* >>files ---------------------------------------------------------------------------------------------------------- */

typedef struct bytes {
  unsigned char *at;
  size_t n;
} bytes;

static void append(void *to, void *data, int n) {
  bytes *b = (bytes *)to;
  b->at = (unsigned char *)realloc(b->at, b->n + (size_t)n + 1);
  if (!b->at) exit(2);
  memcpy(b->at + b->n, data, (size_t)n);
  b->n += (size_t)n;
}

#ifdef HAVE_STB_IMAGE

enum { KINDS = 5, SIDE = 40 };
static const char *const kind_names[KINDS] = {"png", "bmp", "tga", "jpg", "hdr"};

/* A file of a kind: codes, or of .hdr, floats up to 1,000. */
static bytes make_file(int kind, const unsigned char *codes, const float *floats) {
  bytes b = {NULL, 0};
  if (kind == 0) stbi_write_png_to_func(append, &b, SIDE, SIDE, 4, codes, SIDE * 4);
  if (kind == 1) stbi_write_bmp_to_func(append, &b, SIDE, SIDE, 4, codes);
  if (kind == 2) stbi_write_tga_to_func(append, &b, SIDE, SIDE, 4, codes);
  if (kind == 3) stbi_write_jpg_to_func(append, &b, SIDE, SIDE, 4, codes, 100);
  if (kind == 4) stbi_write_hdr_to_func(append, &b, SIDE, SIDE, 3, floats);
  return b;
}

/* Smooth, so that .jpg has little to leave out. */
static void make_texels(unsigned char *codes, float *floats) {
  for (int i = 0; i < SIDE * SIDE; i++) {
    const int x = i % SIDE, y = i / SIDE;
    codes[4 * i] = (unsigned char)(6 * x);
    codes[4 * i + 1] = (unsigned char)(6 * y);
    codes[4 * i + 2] = (unsigned char)(3 * (x + y));
    codes[4 * i + 3] = (unsigned char)(255 - x);
    for (int c = 0; c < 3; c++) floats[3 * i + c] = (float)((x + 1) * (y + 1)) * (c == 0 ? 0.6f : 0.1f);
  }
}

/* Returns the largest difference of codes of colour, or of floats as a part of the value. */
static double file_differs(const image *picture, int kind, const unsigned char *codes, const float *floats) {
  double worst = picture->width == SIDE && picture->height == SIDE ? 0 : 1e9;
  for (int i = 0; worst < 1e9 && i < SIDE * SIDE; i++)
    for (int c = 0; c < 3; c++) {
      if (kind == 4) {
        const float *texel = floats + 3 * i;
        const double largest = (double)fmaxf(texel[0], fmaxf(texel[1], texel[2]));
        worst = fmax(worst, fabs((double)picture->floats[3 * i + c] - (double)texel[c]) / largest);
      } else {
        worst = fmax(worst, fabs((double)picture->codes[4 * i + c] - (double)codes[4 * i + c]));
      }
    }
  return worst;
}

static void files(const unsigned char *codes, const float *floats) {
  static const double most[KINDS] = {0, 0, 0, 6, 1.0 / 128};
  char text[300];
  for (int kind = 0; kind < KINDS; kind++) {
    bytes b = make_file(kind, codes, floats);
    image picture;
    const bool ok = image_load_memory(&picture, kind_names[kind], b.at, b.n, true);
    const double off = ok ? file_differs(&picture, kind, codes, floats) : 1e9;
    snprintf(text, sizeof text, ".%s, %lu bytes, %.3g off", kind_names[kind], (unsigned long)b.n, off);
    check(off <= most[kind], "a file has the texels that were written", text);
    if (kind == 0) check(ok && picture.codes[3 + 4 * 7] == codes[3 + 4 * 7], "and alpha", text);
    if (kind == 4) {
      const double brightest = ok ? (double)picture.floats[3 * (SIDE * SIDE - 1)] : 0;
      snprintf(text, sizeof text, "%.4g", brightest);
      check(brightest > 900, "a .hdr has what is brighter than white, as it is, whatever is said of sRGB", text);
    }
    image_free(&picture);
    free(b.at);
  }
}

/* Parts of files, and files with bytes changed: they are read or refused, and if a part is refused, by one line. */
static void corrupt(const unsigned char *codes, const float *floats) {
  char said[600], text[800];
  for (int kind = 0; kind < KINDS; kind++) {
    bytes b = make_file(kind, codes, floats);
    image picture;
    const size_t head = b.n < 200 ? b.n : 200;
    unsigned read = 0, refused = 0;
    bool good = true;
    for (int i = 0; i < 400; i++) {
      unsigned char *copy = (unsigned char *)malloc(b.n); /* of its own size, for AddressSanitizer */
      size_t n = b.n;
      if (!copy) exit(2);
      memcpy(copy, b.at, b.n);
      if (i < 100) n = b.n * (size_t)i / 100;
      else
        for (int k = 0; k < 1 + i % 5; k++)
          copy[random_bits() % (i % 2 ? b.n : head)] = (unsigned char)(random_bits() >> 16);
      unsigned char *part = (unsigned char *)malloc(n + (n == 0));
      if (!part) exit(2);
      memcpy(part, copy, n);
      const bool no = refuses(&picture, "changed file", part, n, false, said, sizeof said);
      refused += no;
      read += !no && picture.width > 0;
      good = good && (no || picture.width > 0);
      image_free(&picture);
      free(part);
      free(copy);
    }
    snprintf(text, sizeof text, ".%s: %u read, %u refused", kind_names[kind], read, refused);
    check(good && refused > 0, "corrupt files are read as far as they go, or refused by one line", text);
    free(b.at);
  }
}

/* Puts a number of four bytes, the highest first, into a PNG, and the checksum of its header, which nobody looks at. */
static void put_size(bytes *png, uint32_t width, uint32_t height) {
  for (size_t i = 0; i < 4; i++) {
    png->at[16 + i] = (unsigned char)(width >> (24 - 8 * i));
    png->at[20 + i] = (unsigned char)(height >> (24 - 8 * i));
  }
}

static void absurd(const unsigned char *codes, const float *floats) {
  static const uint32_t sizes[4][2] = {{16385, 4}, {4, 16385}, {16384, 16384}, {4294967295u, 4294967295u}};
  char said[600], text[800];
  image picture;
  bytes b = make_file(0, codes, floats);
  for (int i = 0; i < 4; i++) {
    put_size(&b, sizes[i][0], sizes[i][1]);
    const bool no = refuses(&picture, "absurd.png", b.at, b.n, false, said, sizeof said);
    snprintf(text, sizeof text, "%s", said);
    check(no, "a size that is too large is refused", text);
  }
  put_size(&b, 8000, 8000);
  bool no = refuses(&picture, "hollow.png", b.at, b.n, false, said, sizeof said);
  check(no && strstr(said, "cannot hold"), "so is a size that so few bytes cannot hold, before memory is taken", said);
  free(b.at);

  static const char tall[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 20000 +X 4\nwords and words and words";
  no = refuses(&picture, "tall.hdr", tall, sizeof tall, false, said, sizeof said);
  check(no && strstr(said, "along an edge"), "a .hdr that is too large is refused", said);

  no = refuses(&picture, "empty.png", "", 0, false, said, sizeof said);
  check(no && strstr(said, "there is no picture"), "an empty file is refused as such", said);
  no = refuses(&picture, "words.png", "these are words", 15, false, said, sizeof said);
  check(no && strstr(said, "not a picture"), "so is one that is no picture", said);
  no = refuses(&picture, "absent.png", NULL, 0, true, said, sizeof said);
  check(no && strstr(said, "No such file"), "a file that is not there is named", said);
  no = refuses(&picture, "/dev/zero", NULL, 0, true, said, sizeof said);
  check(no && strstr(said, "regular"), "a device is refused", said);
}

static void disk(const unsigned char *codes, const float *floats) {
  bytes b = make_file(0, codes, floats);
  FILE *file = fopen("picture.png", "wb");
  image picture;
  if (!file || fwrite(b.at, 1, b.n, file) != b.n || fclose(file) != 0) exit(2);
  const bool ok = image_load(&picture, "picture.png", false);
  check(ok && file_differs(&picture, 0, codes, floats) <= 0, "control: a file on disk is read", "picture.png");
  image_free(&picture);
  free(b.at);
}

static void all_files(void) {
  static unsigned char codes[4 * SIDE * SIDE];
  static float floats[3 * SIDE * SIDE];
  make_texels(codes, floats);
  files(codes, floats);
  corrupt(codes, floats);
  absurd(codes, floats);
  disk(codes, floats);
}

#else

static void all_files(void) {
  char said[600];
  image picture;
  bytes b = {NULL, 0};
  const unsigned char one[4] = {1, 2, 3, 4};
  stbi_write_png_to_func(append, &b, 1, 1, 4, one, 4);
  bool no = refuses(&picture, "picture.png", b.at, b.n, false, said, sizeof said);
  check(no && strstr(said, "libstb-dev"), "without stb_image a picture is refused, with what to install", said);
  no = refuses(&picture, "picture.png", NULL, 0, true, said, sizeof said);
  check(no && strstr(said, "libstb-dev"), "so is a file", said);
  free(b.at);
}

#endif

/* >>pictures ------------------------------------------------------------------------------------------------------- */

enum { PIXELS = 16 };

/* Renders PIXELS x PIXELS pixels; ends the program where that fails. */
static void render(pktrt_scene *world, pktrt_render_desc *view, float *pixels) {
  view->width = view->height = PIXELS;
  view->pixels = pixels;
  view->mode = PKTRT_MODE_DRT;
  view->path = PKTRT_PATH_SINGLE;
  if (!view->samples) view->samples = 4;
  if (pktrt_commit(world) != PKTRT_OK || pktrt_render(world, view) != PKTRT_OK) {
    printf("%s\n", pktrt_last_error(world));
    exit(2);
  }
}

static const float square[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
static const float square_texcoords[8] = {0, 0, 1, 0, 1, 1, 0, 1};
static const uint32_t square_indices[6] = {0, 1, 2, 0, 2, 3};

/* A square that fills the picture of a parallel camera, of a material. */
static pktrt_scene *make_square(const pktrt_material *material, pktrt_render_desc *view) {
  pktrt_scene *world = pktrt_scene_create(NULL);
  pktrt_mesh_desc mesh;
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = square;
  mesh.vertex_count = 4;
  mesh.indices = square_indices;
  mesh.triangle_count = 2;
  mesh.texcoords = square_texcoords;
  if (!world || pktrt_add_material(world, material, &mesh.material) != PKTRT_OK ||
      pktrt_add_mesh(world, &mesh, NULL) != PKTRT_OK)
    exit(2);
  memset(view, 0, sizeof *view);
  view->camera.eye[2] = 2;
  view->camera.projection = PKTRT_PROJECTION_ORTHOGRAPHIC;
  view->camera.width = 2;
  return world;
}

static bool about(const float *pixel, double r, double g, double b, double most) {
  return fabs((double)pixel[0] - r) <= most && fabs((double)pixel[1] - g) <= most && fabs((double)pixel[2] - b) <= most;
}

static void texture(void) {
  /* Above: red, green; below: blue, white and transparent. */
  static const unsigned char codes[16] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 0};
  float pixels[3 * PIXELS * PIXELS];
  char text[200];
  image picture;
  pktrt_material material;
  pktrt_render_desc view;
  image_texture_user use = {&picture, IMAGE_CLAMP, IMAGE_CLAMP};
  if (!image_from_rgba8(&picture, 2, 2, codes, true)) exit(2);
  memset(&material, 0, sizeof material);
  material.texture = image_texture;
  material.user = &use;
  for (int pass = 0; pass < 2; pass++) {
    material.cutout = pass == 1;
    pktrt_scene *world = make_square(&material, &view);
    for (int c = 0; c < 3; c++) view.ambient[c] = 1;
    view.background[2] = 0.25f;
    render(world, &view, pixels);
    const float *left = pixels, *right = pixels + (size_t)3 * (PIXELS - 1);
    const float *low_left = pixels + (size_t)3 * PIXELS * (PIXELS - 1);
    const float *low_right = pixels + (size_t)3 * (PIXELS * PIXELS - 1);
    snprintf(text, sizeof text, "%.3g %.3g %.3g, below %.3g %.3g %.3g", (double)left[0], (double)right[1],
        (double)right[2], (double)low_left[2], (double)low_right[0], (double)low_right[2]);
    if (pass == 0)
      check(about(left, 1, 0, 0, 0.01) && about(right, 0, 1, 0, 0.01) && about(low_left, 0, 0, 1, 0.01) &&
                about(low_right, 1, 1, 1, 0.01),
          "a picture stands upright on a square, its colour as albedo", text);
    else check(about(left, 1, 0, 0, 0.01) && about(low_right, 0, 0, 0.25, 0.01), "a cutout is cut out by alpha", text);
    pktrt_scene_destroy(world);
  }
  image_free(&picture);
}

/* Returns what an environment has in a direction. */
static float look(image_environment_user *use, float x, float y, float z) {
  const double size = sqrt((double)x * (double)x + (double)y * (double)y + (double)z * (double)z);
  float d[3] = {(float)((double)x / size), (float)((double)y / size), (float)((double)z / size)}, rgb[3];
  const float *direction[3] = {&d[0], &d[1], &d[2]};
  float *radiance[3] = {&rgb[0], &rgb[1], &rgb[2]};
  image_environment(use, 1, direction, radiance);
  return rgb[0];
}

static void directions(void) {
  enum { COLUMNS = 64, ROWS = 32 };
  static unsigned char codes[4 * COLUMNS * ROWS];
  const double turns = 1 / 6.283185307179586;
  char text[200];
  image picture;
  image_environment_user use = {&picture, 0, 1, false};
  random_codes(codes, sizeof codes);
  if (!image_from_rgba8(&picture, COLUMNS, ROWS, codes, false)) exit(2);
  for (int up_z = 0; up_z < 2; up_z++) {
    double worst = 0;
    use.up_z = up_z == 1;
    use.turn = up_z ? 30 : 0;
    for (int i = 0; i < 20000; i++) {
      const float x = random_between(-1, 1), y = random_between(-1, 1), z = random_between(-1, 1);
      const double up = (double)(up_z ? z : y), ahead = (double)(up_z ? y : -z);
      const double u = 0.5 + atan2((double)x, ahead) * turns + (double)use.turn / 360;
      const double v = 0.5 + 2 * atan2(up, hypot((double)x, ahead)) * turns;
      float rgba[4];
      image_at(&picture, (float)u, (float)v, IMAGE_REPEAT, IMAGE_CLAMP, rgba);
      worst = fmax(worst, fabs((double)rgba[0] - (double)look(&use, x, y, z)));
    }
    snprintf(text, sizeof text, "%s is up, %.3g off", up_z ? "z" : "y", worst);
    check(worst < 1e-4, "directions are found in the picture as libm's angles say", text);
  }
  image_free(&picture);

  /* A bright texel to the right of the middle column and above the middle row, another at the left edge. */
  memset(codes, 0, sizeof codes);
  codes[4 * (16 * COLUMNS + 48)] = 255;
  codes[4 * (15 * COLUMNS + 48)] = 255;
  if (!image_from_rgba8(&picture, COLUMNS, ROWS, codes, false)) exit(2);
  use = (image_environment_user){&picture, 0, 2, false};
  const double there = (double)look(&use, 1, 0, 0.05f);
  use.turn = 90;
  const double turned = (double)look(&use, 0.05f, 0, -1);
  snprintf(text, sizeof text, "%.3g to the right, turned by 90 degrees %.3g ahead", there, turned);
  check(there > 1.9 && turned > 1.9, "+x is right of the picture's middle, and a turn moves it to the left", text);
  image_free(&picture);
}

/* What rays see in a picture, and a white square in an even light, which has its albedo. */
static void environment(void) {
  static unsigned char codes[4 * 8 * 4];
  float pixels[3 * PIXELS * PIXELS];
  char text[200];
  image picture;
  image_environment_user use = {&picture, 0, 1, false};
  pktrt_render_desc view;
  for (size_t i = 0; i < 32; i++) codes[4 * i + (i < 16 ? 2 : 0)] = 255; /* blue above, red below */
  if (!image_from_rgba8(&picture, 8, 4, codes, true)) exit(2);
  pktrt_scene *world = pktrt_scene_create(NULL);
  memset(&view, 0, sizeof view);
  view.camera.target[2] = -1;
  view.camera.fov_y = 100;
  view.environment = image_environment;
  view.user = &use;
  render(world, &view, pixels);
  const float *above = pixels + (size_t)3 * (PIXELS / 2), *below = above + (size_t)3 * PIXELS * (PIXELS - 1);
  snprintf(text, sizeof text, "above %.3g %.3g, below %.3g %.3g", (double)above[0], (double)above[2], (double)below[0],
      (double)below[2]);
  check(about(above, 0, 0, 1, 0.01) && about(below, 1, 0, 0, 0.01), "a camera sees the sky above and the ground below",
      text);
  pktrt_scene_destroy(world);
  image_free(&picture);

  memset(codes, 255, sizeof codes);
  if (!image_from_rgba8(&picture, 8, 4, codes, true)) exit(2);
  pktrt_material material;
  pktrt_light light;
  memset(&material, 0, sizeof material);
  memset(&light, 0, sizeof light);
  for (int c = 0; c < 3; c++) {
    material.albedo[c] = 0.5f;
    light.intensity[c] = 1;
  }
  light.kind = PKTRT_LIGHT_ENVIRONMENT;
  world = make_square(&material, &view);
  if (pktrt_add_light(world, &light, NULL) != PKTRT_OK) exit(2);
  view.environment = image_environment;
  view.user = &use;
  view.samples = 16;
  render(world, &view, pixels);
  double mean = 0;
  for (int i = 0; i < PIXELS * PIXELS; i++) mean += (double)pixels[3 * i] / (PIXELS * PIXELS);
  snprintf(text, sizeof text, "albedo 0.5: %.4g", mean);
  check(fabs(mean - 0.5) < 0.005, "an even light from all sides shows a surface's albedo", text);
  pktrt_scene_destroy(world);
  image_free(&picture);
}

int main(void) {
  mixing();
  colours();
  all_files();
  texture();
  directions();
  environment();
#ifndef HAVE_STB_IMAGE
  const char *built = "without stb_image";
#elif defined(__SANITIZE_ADDRESS__)
  const char *built = "with AddressSanitizer";
#else
  const char *built = "plain";
#endif
  printf("test-image: %d of %d checks passed, %s\n", checks - failures, checks, built);
  return failures != 0;
}
