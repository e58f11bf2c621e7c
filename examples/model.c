/* Writes a still life as one glTF file whose pictures are within it: a table of tiles with relief, a vase, leaves that
   are cut out by alpha, a copper bowl with one orange several times, a glass, stained panes in the sun, and a lantern.
   It shows what files can bring; `make model` draws it.
   usage: model FILE.glb

   Lengths are in metres, y is up, the table's top is at 0. Contents: bytes, parts, shapes, paint, file, materials,
   things. */
#include "common.h"

/* For common.h, which writes pictures by it. */
#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

/* >>bytes ---------------------------------------------------------------------------------------------------------- */

typedef struct bytes {
  unsigned char *at;
  size_t count, room;
} bytes;

/* Appends n bytes; where memory is lacking, the program ends. */
static void append(bytes *to, const void *from, size_t n) {
  if (to->count + n > to->room) {
    to->room = 2 * (to->count + n);
    to->at = (unsigned char *)realloc(to->at, to->room);
    if (!to->at) {
      ex_fail("not enough memory for the model");
      exit(1);
    }
  }
  memcpy(to->at + to->count, from, n);
  to->count += n;
}

/* Appends text. */
EX_PRINTF(2, 3) static void say(bytes *to, const char *format, ...) {
  char text[2048];
  va_list args;
  va_start(args, format);
  const int n = vsnprintf(text, sizeof text, format, args);
  va_end(args);
  append(to, text, n > 0 && (size_t)n < sizeof text ? (size_t)n : 0);
}

/* The members of a JSON array. */
typedef struct list {
  bytes text;
  unsigned count;
} list;

/* Begins a member; returns its index. */
static unsigned next(list *to) {
  if (to->count > 0) say(&to->text, ",\n");
  return to->count++;
}

/* >>parts ---------------------------------------------------------------------------------------------------------- */

/* A mesh in the making: eight floats a vertex, position, normal and texture coordinates, v from the upper edge down. */
typedef struct part {
  bytes vertices, indices;
  uint32_t vertex_count;
} part;

/* Adds a vertex; returns its index. The normal may have any length. */
static uint32_t vertex(part *to, const double p[3], const double normal[3], double u, double v) {
  double size = sqrt(normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2]);
  if (!(size > 0)) size = 1;
  const float all[8] = {(float)p[0], (float)p[1], (float)p[2], (float)(normal[0] / size), (float)(normal[1] / size),
      (float)(normal[2] / size), (float)u, (float)v};
  append(&to->vertices, all, sizeof all);
  return to->vertex_count++;
}

/* Adds a triangle of three vertices, counter-clockwise seen from its front. */
static void triangle(part *to, uint32_t a, uint32_t b, uint32_t c) {
  const uint32_t corners[3] = {a, b, c};
  append(&to->indices, corners, sizeof corners);
}

/* >>shapes --------------------------------------------------------------------------------------------------------- */

#define PI 3.14159265358979323846

/* A parallelogram from a corner, its texture `repeat` times along each side; counter-clockwise from x to y is its
   front. */
static void sheet(
    part *to, const double corner[3], const double x[3], const double y[3], double repeat_x, double repeat_y) {
  const double normal[3] = {x[1] * y[2] - x[2] * y[1], x[2] * y[0] - x[0] * y[2], x[0] * y[1] - x[1] * y[0]};
  uint32_t at[4];
  for (int i = 0; i < 4; i++) {
    const double u = i == 1 || i == 2 ? 1 : 0;
    const double v = i >= 2 ? 1 : 0;
    double p[3];
    for (int a = 0; a < 3; a++) p[a] = corner[a] + u * x[a] + v * y[a];
    at[i] = vertex(to, p, normal, u * repeat_x, (1 - v) * repeat_y);
  }
  triangle(to, at[0], at[1], at[2]);
  triangle(to, at[0], at[2], at[3]);
}

/* A box about a middle, of three half edges that are perpendicular and right-handed. */
static void box(part *to, const double middle[3], const double half[3][3]) {
  for (int face = 0; face < 6; face++) {
    const double sign = face < 3 ? 1 : -1;
    const double *out = half[face % 3], *across = half[(face + 1) % 3], *up = half[(face + 2) % 3];
    double corner[3], x[3], y[3];
    for (int a = 0; a < 3; a++) {
      x[a] = 2 * sign * across[a];
      y[a] = 2 * up[a];
      corner[a] = middle[a] + sign * out[a] - 0.5 * x[a] - 0.5 * y[a];
    }
    sheet(to, corner, x, y, 1, 1);
  }
}

/* A square bar between two points of the plane z = 0. */
static void bar(part *to, double x0, double y0, double x1, double y1, double width) {
  const double middle[3] = {0.5 * (x0 + x1), 0.5 * (y0 + y1), 0};
  const double size = sqrt((x1 - x0) * (x1 - x0) + (y1 - y0) * (y1 - y0));
  const double x = (x1 - x0) / size, y = (y1 - y0) / size, thick = 0.5 * width;
  const double half[3][3] = {
      {0.5 * (x1 - x0) + thick * x, 0.5 * (y1 - y0) + thick * y, 0}, {-thick * y, thick * x, 0}, {0, 0, thick}};
  box(to, middle, half);
}

typedef struct profile {
  double point[256][2]; /* radius and height */
  int count;
} profile;

/* Appends points of a smooth curve through n points, `steps` from each to the next. */
static void curve(profile *to, const double (*through)[2], int n, int steps) {
  for (int i = 0; i + 1 < n; i++)
    for (int k = i == 0 ? 0 : 1; k <= steps && to->count < 256; k++) {
      const double *p0 = through[i > 0 ? i - 1 : 0], *p1 = through[i];
      const double *p2 = through[i + 1], *p3 = through[i + 2 < n ? i + 2 : n - 1];
      const double t = (double)k / steps, t2 = t * t, t3 = t2 * t;
      double *point = to->point[to->count++];
      for (int a = 0; a < 2; a++)
        point[a] = 0.5 * (2 * p1[a] + (p2[a] - p0[a]) * t + (2 * p0[a] - 5 * p1[a] + 4 * p2[a] - p3[a]) * t2 +
                             (3 * p1[a] - p0[a] - 3 * p2[a] + p3[a]) * t3);
      if (point[0] < 0) point[0] = 0;
    }
}

/* Appends one point. */
static void corner(profile *to, double radius, double height) {
  to->point[to->count][0] = radius;
  to->point[to->count++][1] = height;
}

/* The normal of the piece of a profile from point i to the next, of unit length. */
static void piece_normal(const profile *p, int i, double normal[2]) {
  const double along = p->point[i + 1][0] - p->point[i][0], up = p->point[i + 1][1] - p->point[i][1];
  const double size = sqrt(along * along + up * up);
  normal[0] = size > 0 ? up / size : 1;
  normal[1] = size > 0 ? -along / size : 0;
}

/* Turns a profile about the y axis; what is to its right as one goes along it is outside. Pieces that meet in less than
   45 degrees are smooth there. */
static void lathe(part *to, const profile *p, int around, double repeat) {
  for (int i = 0; i + 1 < p->count; i++) {
    double own[2];
    uint32_t first = 0;
    piece_normal(p, i, own);
    for (int end = 0; end < 2; end++) {
      const int neighbour = end ? i + 1 : i - 1;
      double other[2] = {0, 0};
      if (neighbour >= 0 && neighbour + 1 < p->count) piece_normal(p, neighbour, other);
      const bool smooth = own[0] * other[0] + own[1] * other[1] > 0.7;
      const double out = own[0] + (smooth ? other[0] : 0), up = own[1] + (smooth ? other[1] : 0);
      for (int k = 0; k <= around; k++) {
        const double angle = 2 * PI * (k % around) / around;
        const double at[3] = {
            p->point[i + end][0] * sin(angle), p->point[i + end][1], p->point[i + end][0] * cos(angle)};
        const double normal[3] = {out * sin(angle), up, out * cos(angle)};
        const uint32_t index = vertex(to, at, normal, repeat * k / around, 1 - (double)(i + end) / (p->count - 1));
        if (k == 0 && end == 0) first = index;
      }
    }
    const uint32_t ring = (uint32_t)around + 1;
    for (uint32_t k = 0; k + 1 < ring; k++) {
      if (p->point[i][0] > 0) triangle(to, first + k, first + k + 1, first + ring + k + 1);
      if (p->point[i + 1][0] > 0) triangle(to, first + k, first + ring + k + 1, first + ring + k);
    }
  }
}

/* A ball, or what remains of it between two angles from its lower pole. */
static void ball(part *to, double radius, double height, int rows) {
  profile p = {{{0}}, 0};
  for (int i = 0; i <= rows; i++) {
    const double angle = PI * i / rows;
    corner(&p, i == 0 || i == rows ? 0 : radius * sin(angle), height - radius * cos(angle));
  }
  lathe(to, &p, 2 * rows, 2);
}

/* A leaf along x from the origin, bent down; its texture says where it is. */
static void leaf(part *to) {
  const int steps = 8;
  uint32_t before[2] = {0, 0};
  for (int i = 0; i <= steps; i++) {
    const double t = (double)i / steps, height = 0.028 * t - 0.045 * t * t;
    const double normal[3] = {-(0.028 - 0.09 * t), 0.1, 0};
    uint32_t at[2];
    for (int side = 0; side < 2; side++) {
      const double p[3] = {0.1 * t, height, side ? -0.022 : 0.022};
      at[side] = vertex(to, p, normal, t, side ? 0 : 1);
    }
    if (i > 0) {
      triangle(to, before[0], at[0], at[1]);
      triangle(to, before[0], at[1], before[1]);
    }
    memcpy(before, at, sizeof at);
  }
}

/* >>paint ---------------------------------------------------------------------------------------------------------- */

/* Paints the point (u, v) of a texture, v down from its upper edge: four values from 0 to 1, sRGB. */
typedef void (*paint)(double u, double v, double rgba[4]);
/* Returns a height, in widths of the texture. */
typedef double (*relief)(double u, double v);

/* Grows from 0 to 1 as x goes from lo to hi. */
static double step(double lo, double hi, double x) {
  const double t = (x - lo) / (hi - lo);
  if (t < 0) return 0;
  return t > 1 ? 1 : t * t * (3 - 2 * t);
}

/* Returns what is a part t of the way from a to b. */
static double mix(double a, double b, double t) { return a + (b - a) * t; }

/* Covers a part of a point by a colour. */
static void cover(double rgba[4], double r, double g, double b, double part_of) {
  rgba[0] = mix(rgba[0], r, part_of);
  rgba[1] = mix(rgba[1], g, part_of);
  rgba[2] = mix(rgba[2], b, part_of);
}

/* A number in [0,1) that a place of a grid always has. */
static double hashed(int x, int y) {
  uint32_t h = (uint32_t)x * 374761393u + (uint32_t)y * 668265263u;
  h = (h ^ h >> 13) * 1274126177u;
  return (double)((h ^ h >> 16) & 0xffffff) / 16777216;
}

/* Smooth noise in [0,1), which repeats after `period` in both directions. */
static double noise(double x, double y, int period) {
  const double left = floor(x), top = floor(y);
  const int i = (int)left, k = (int)top;
  const double across = step(0, 1, x - left), down = step(0, 1, y - top);
  double corners[2][2];
  for (int a = 0; a < 2; a++)
    for (int b = 0; b < 2; b++) corners[a][b] = hashed((k + a) % period, (i + b) % period);
  return mix(mix(corners[0][0], corners[0][1], across), mix(corners[1][0], corners[1][1], across), down);
}

/* Noise of four sizes, the largest `period` times in the texture. */
static double octaves(double u, double v, int period) {
  double sum = 0, weight = 0.5;
  for (int i = 0; i < 4; i++) {
    sum += weight * noise(u * period, v * period, period);
    period *= 2;
    weight *= 0.5;
  }
  return sum;
}

/* One tile: x and y from -1 to 1, how far it is from its edge, and which one it is. */
static double tile_at(double u, double v, double *x, double *y) {
  *x = 2 * (2 * u - floor(2 * u)) - 1;
  *y = 2 * (2 * v - floor(2 * v)) - 1;
  return fmax(fabs(*x), fabs(*y));
}

/* Blue flowers on white tiles, two by two, with joints between. */
static void paint_tiles(double u, double v, double rgba[4]) {
  double x, y;
  const double edge = tile_at(u, v, &x, &y);
  const double r = sqrt(x * x + y * y), angle = atan2(y, x);
  const double petal = 0.46 + 0.17 * cos(8 * angle);
  const double aside = fabs(x) > fabs(y) ? 1 - fabs(x) : 1 - fabs(y);
  const double to_corner = sqrt((1 - fabs(x)) * (1 - fabs(x)) + (1 - fabs(y)) * (1 - fabs(y)));
  cover(rgba, 0.93, 0.90, 0.83, 1);
  cover(rgba, 0.16, 0.30, 0.56, step(petal + 0.02, petal - 0.02, r));
  cover(rgba, 0.93, 0.90, 0.83, step(petal - 0.10, petal - 0.14, r));
  cover(rgba, 0.80, 0.52, 0.20, step(0.20, 0.16, r));
  cover(rgba, 0.16, 0.30, 0.56, step(0.04, 0.02, fabs(r - 0.74)) * step(0.1, 0.14, aside));
  cover(rgba, 0.16, 0.30, 0.56, step(0.50, 0.46, to_corner));
  cover(rgba, 0.80, 0.52, 0.20, step(0.36, 0.32, to_corner));
  const double tint = 0.94 + 0.08 * octaves(u, v, 8);
  for (int c = 0; c < 3; c++) rgba[c] *= tint;
  cover(rgba, 0.55, 0.50, 0.44, step(0.93, 0.95, edge));
}

/* Tiles are round at their edges. */
static double tile_relief(double u, double v) {
  double x, y;
  const double edge = tile_at(u, v, &x, &y);
  return 0.012 * step(0.97, 0.84, edge) + 0.0012 * octaves(u, v, 4);
}

/* Ochre with spots. */
static void paint_plaster(double u, double v, double rgba[4]) {
  const double spots = octaves(u, v, 4);
  cover(rgba, mix(0.80, 0.90, spots), mix(0.66, 0.77, spots), mix(0.50, 0.62, spots), 1);
}

/* Waves of a trowel. */
static double plaster_relief(double u, double v) { return 0.006 * octaves(u, v, 8); }

/* Two waves, a row of lozenges, bands at foot and mouth. */
static void paint_vase(double u, double v, double rgba[4]) {
  const double wave = 0.30 + 0.03 * sin(2 * PI * 9 * u);
  const double x = fabs(14 * u - floor(14 * u) - 0.5), y = fabs(v - 0.56) * 5;
  cover(rgba, 0.92, 0.88, 0.78, 1);
  cover(rgba, 0.10, 0.34, 0.42, step(0.020, 0.014, fabs(v - wave)));
  cover(rgba, 0.10, 0.34, 0.42, step(0.011, 0.006, fabs(v - wave - 0.045)));
  cover(rgba, 0.10, 0.34, 0.42, step(0.50, 0.46, x + y));
  cover(rgba, 0.92, 0.88, 0.78, step(0.40, 0.36, x + y));
  cover(rgba, 0.72, 0.30, 0.16, step(0.28, 0.24, x + y));
  cover(rgba, 0.72, 0.30, 0.16, fmax(step(0.010, 0.006, fabs(v - 0.69)), step(0.010, 0.006, fabs(v - 0.43))));
  cover(rgba, 0.10, 0.34, 0.42, fmax(step(0.13, 0.12, v), step(0.84, 0.85, v)));
}

/* Small pits. */
static double peel_relief(double u, double v) {
  const double pits = noise(u * 48, v * 48, 48);
  return -0.006 * step(0.45, 0.95, pits) + 0.012 * noise(u * 4, v * 4, 4);
}

/* Blows of a hammer: the nearest of many middles. */
static double hammer_relief(double u, double v) {
  const int blows = 10;
  double nearest = 1;
  for (int i = -1; i <= 1; i++)
    for (int k = -1; k <= 1; k++) {
      const int column = (int)floor(u * blows) + i, row = (int)floor(v * blows) + k;
      const int at = (column + blows) % blows, down = (row + blows) % blows;
      const double x = u * blows - column - hashed(at, down), y = v * blows - row - hashed(at + 50, down);
      nearest = fmin(nearest, x * x + y * y);
    }
  return 0.02 * nearest;
}

/* Brass with holes: stars in rows that are shifted. */
static void paint_lattice(double u, double v, double rgba[4]) {
  const double row = floor(4 * v), across = 10 * u + 0.5 * (row - 2 * floor(row / 2));
  const double x = 2 * (across - floor(across)) - 1, y = 2 * (4 * v - row) - 1;
  const double r = sqrt(x * x + y * y), angle = atan2(y, x);
  const double star = 0.62 + 0.18 * cos(6 * angle);
  const double left = 2 * fabs(fabs(x) - 1), up = 2 * fabs(fabs(y) - 1);
  const double small_hole = sqrt(left * left + up * up);
  cover(rgba, 0.87, 0.68, 0.36, 1);
  rgba[3] = fmin(step(star - 0.06, star + 0.06, r), step(0.28, 0.40, small_hole));
  if (v < 0.03 || v > 0.97) rgba[3] = 1;
}

/* A leaf along u, transparent around it. */
static void paint_leaf(double u, double v, double rgba[4]) {
  const double aside = fabs(v - 0.5);
  const double half = u > 0.12 ? 0.46 * sqrt(sin(PI * pow((u - 0.12) / 0.88, 0.8))) : 0.03;
  const double along = 9 * (u + 1.2 * aside);
  const double vein = fmax(step(0.03, 0.015, aside), 0.5 * step(0.12, 0.04, fabs(along - floor(along) - 0.5)));
  cover(rgba, mix(0.22, 0.52, vein), mix(0.40, 0.60, vein), mix(0.14, 0.28, vein), 1);
  const double shade = 0.85 + 0.3 * octaves(u, v, 4);
  for (int c = 0; c < 3; c++) rgba[c] *= shade;
  rgba[3] = step(half + 0.02, half - 0.02, aside);
}

/* >>file ----------------------------------------------------------------------------------------------------------- */

typedef struct model {
  bytes data; /* the binary part */
  list views, accessors, meshes, nodes, materials, images, textures;
} model;

/* What data are, by glTF's numbers. */
enum { PICTURE = 0, VERTICES = 34962, INDICES = 34963 };

/* Appends data that the JSON refers to; returns the index of the view. Vertices are of eight floats. */
static unsigned add_view(model *m, const void *from, size_t n, int target) {
  static const char none[4] = {0, 0, 0, 0};
  const unsigned index = next(&m->views);
  say(&m->views.text, "{\"buffer\":0,\"byteOffset\":%lu,\"byteLength\":%lu", (unsigned long)m->data.count,
      (unsigned long)n);
  if (target == VERTICES) say(&m->views.text, ",\"byteStride\":32");
  if (target != PICTURE) say(&m->views.text, ",\"target\":%d", target);
  say(&m->views.text, "}");
  append(&m->data, from, n);
  append(&m->data, none, (4 - n % 4) % 4);
  return index;
}

/* For stb_image_write. */
static void append_png(void *to, void *data, int n) { append((bytes *)to, data, (size_t)n); }

/* Keeps a picture of RGB or RGBA; returns the index of its texture. */
static unsigned add_picture(model *m, int size, int channels, const unsigned char *codes) {
  bytes png = {NULL, 0, 0};
  if (!stbi_write_png_to_func(append_png, &png, size, size, channels, codes, size * channels)) exit(1);
  const unsigned view = add_view(m, png.at, png.count, PICTURE);
  const unsigned picture = next(&m->images);
  say(&m->images.text, "{\"bufferView\":%u,\"mimeType\":\"image/png\"}", view);
  const unsigned index = next(&m->textures);
  say(&m->textures.text, "{\"source\":%u,\"sampler\":0}", picture);
  free(png.at);
  return index;
}

/* Returns the code of a value in [0,1]. */
static unsigned char code_of(double value) { return (unsigned char)(fmin(fmax(value, 0), 1) * 255 + 0.5); }

enum { MOST_TEXELS = 512 * 512 };
static unsigned char texels[4 * MOST_TEXELS];

/* Paints a texture; returns its index. */
static unsigned add_painting(model *m, int size, int channels, paint how) {
  for (int i = 0; i < size * size; i++) {
    double rgba[4] = {0, 0, 0, 1};
    how((i % size + 0.5) / size, (i / size + 0.5) / size, rgba);
    for (int c = 0; c < channels; c++) texels[channels * i + c] = code_of(rgba[c]);
  }
  return add_picture(m, size, channels, texels);
}

/* A normal map: x to the right, y up, of a relief that repeats. */
static unsigned add_relief(model *m, int size, relief how) {
  const double off = 0.5 / size;
  for (int i = 0; i < size * size; i++) {
    const double u = (i % size + 0.5) / size, v = (i / size + 0.5) / size;
    const double x = -(how(u + off, v) - how(u - off, v)) / (2 * off);
    const double y = (how(u, v + off) - how(u, v - off)) / (2 * off);
    const double size_of = sqrt(x * x + y * y + 1);
    texels[3 * i] = code_of(0.5 + 0.5 * x / size_of);
    texels[3 * i + 1] = code_of(0.5 + 0.5 * y / size_of);
    texels[3 * i + 2] = code_of(0.5 + 0.5 / size_of);
  }
  return add_picture(m, size, 3, texels);
}

/* Writes what a vertex has: `count` floats from `offset` on. */
static unsigned add_accessor(model *m, unsigned view, const part *p, unsigned offset, unsigned count) {
  const unsigned index = next(&m->accessors);
  say(&m->accessors.text, "{\"bufferView\":%u,\"byteOffset\":%u,\"componentType\":5126,\"count\":%u,\"type\":\"VEC%u\"",
      view, 4 * offset, p->vertex_count, count);
  if (offset == 0) {
    const float *at = (const float *)(const void *)p->vertices.at;
    float lo[3], hi[3];
    memcpy(lo, at, sizeof lo);
    memcpy(hi, at, sizeof hi);
    for (size_t i = 0; i < p->vertex_count; i++)
      for (size_t a = 0; a < 3; a++) {
        lo[a] = fminf(lo[a], at[8 * i + a]);
        hi[a] = fmaxf(hi[a], at[8 * i + a]);
      }
    say(&m->accessors.text, ",\"min\":[%.9g,%.9g,%.9g],\"max\":[%.9g,%.9g,%.9g]", (double)lo[0], (double)lo[1],
        (double)lo[2], (double)hi[0], (double)hi[1], (double)hi[2]);
  }
  say(&m->accessors.text, "}");
  return index;
}

/* Makes a mesh of a part, which is empty then; returns its index. */
static unsigned add_mesh(model *m, const char *name, part *p, unsigned material) {
  const unsigned vertices = add_view(m, p->vertices.at, p->vertices.count, VERTICES);
  const unsigned indices = add_view(m, p->indices.at, p->indices.count, INDICES);
  const unsigned position = add_accessor(m, vertices, p, 0, 3);
  const unsigned normal = add_accessor(m, vertices, p, 3, 3);
  const unsigned texcoord = add_accessor(m, vertices, p, 6, 2);
  const unsigned corners = next(&m->accessors);
  say(&m->accessors.text, "{\"bufferView\":%u,\"componentType\":5125,\"count\":%lu,\"type\":\"SCALAR\"}", indices,
      (unsigned long)(p->indices.count / 4));
  const unsigned index = next(&m->meshes);
  say(&m->meshes.text,
      "{\"name\":\"%s\",\"primitives\":[{\"attributes\":{\"POSITION\":%u,\"NORMAL\":%u,\"TEXCOORD_0\":%u},"
      "\"indices\":%u,\"material\":%u}]}",
      name, position, normal, texcoord, corners, material);
  free(p->vertices.at);
  free(p->indices.at);
  memset(p, 0, sizeof *p);
  return index;
}

/* Where a node is: scaled along its own axes, turned about z (roll), then about x (pitch), then about y (turn), in
   degrees. */
typedef struct place {
  double x, y, z, turn, pitch, roll, wide, high;
} place;

/* A place with one scale. */
static place place_at(double x, double y, double z, double turn, double pitch, double roll, double scale) {
  const place at = {x, y, z, turn, pitch, roll, scale, scale};
  return at;
}

/* Begins a node. */
static void begin_node(model *m, place at) {
  const double turn = at.turn * PI / 360, pitch = at.pitch * PI / 360, roll = at.roll * PI / 360;
  const double cy = cos(turn), sy = sin(turn), cx = cos(pitch), sx = sin(pitch), cz = cos(roll), sz = sin(roll);
  next(&m->nodes);
  say(&m->nodes.text, "{\"translation\":[%.6g,%.6g,%.6g],\"rotation\":[%.9g,%.9g,%.9g,%.9g],\"scale\":[%.6g,%.6g,%.6g]",
      at.x, at.y, at.z, cy * sx * cz + sy * cx * sz, sy * cx * cz - cy * sx * sz, cy * cx * sz - sy * sx * cz,
      cy * cx * cz + sy * sx * sz, at.wide, at.high, at.wide);
}

/* Puts a mesh in a place. */
static void put(model *m, unsigned mesh, place at) {
  begin_node(m, at);
  say(&m->nodes.text, ",\"mesh\":%u}", mesh);
}

/* Appends a member of the JSON that is an array. */
static void append_list(bytes *to, const char *name, const list *from) {
  say(to, ",\n\"%s\":[", name);
  append(to, from->text.at, from->text.count);
  say(to, "]");
}

/* Appends four bytes, the lowest first. */
static void append_word(bytes *to, uint32_t word) {
  const unsigned char four[4] = {
      (unsigned char)word, (unsigned char)(word >> 8), (unsigned char)(word >> 16), (unsigned char)(word >> 24)};
  append(to, four, 4);
}

/* Writes the file: a head, the JSON, and the data. */
static bool write_model(const model *m, const char *path) {
  bytes json = {NULL, 0, 0}, head = {NULL, 0, 0};
  say(&json, "{\"asset\":{\"version\":\"2.0\",\"generator\":\"pktrt examples/model.c\"},\n\"extensionsUsed\":["
             "\"KHR_lights_punctual\",\"KHR_materials_transmission\",\"KHR_materials_volume\",\"KHR_materials_ior\","
             "\"KHR_materials_emissive_strength\"],\n"
             "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"name\":\"sun\",\"type\":\"directional\","
             "\"color\":[1,0.93,0.82],\"intensity\":2.5}]}},\n"
             "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.58,\"znear\":0.01}}],\n"
             "\"samplers\":[{\"wrapS\":10497,\"wrapT\":10497}],\n");
  say(&json, "\"buffers\":[{\"byteLength\":%lu}],\n\"scene\":0,\"scenes\":[{\"nodes\":[", (unsigned long)m->data.count);
  for (unsigned i = 0; i < m->nodes.count; i++) say(&json, "%s%u", i ? "," : "", i);
  say(&json, "]}]");
  append_list(&json, "nodes", &m->nodes);
  append_list(&json, "meshes", &m->meshes);
  append_list(&json, "materials", &m->materials);
  append_list(&json, "textures", &m->textures);
  append_list(&json, "images", &m->images);
  append_list(&json, "accessors", &m->accessors);
  append_list(&json, "bufferViews", &m->views);
  say(&json, "}");
  while (json.count % 4) say(&json, " ");

  append(&head, "glTF", 4);
  append_word(&head, 2);
  append_word(&head, (uint32_t)(28 + json.count + m->data.count));
  append_word(&head, (uint32_t)json.count);
  append(&head, "JSON", 4);
  append(&head, json.at, json.count);
  append_word(&head, (uint32_t)m->data.count);
  append(&head, "BIN\0", 4);
  append(&head, m->data.at, m->data.count);
  FILE *file = fopen(path, "wb");
  bool ok = file && fwrite(head.at, 1, head.count, file) == head.count;
  if (file) ok = fclose(file) == 0 && ok;
  free(json.at);
  free(head.at);
  return ok || ex_fail("%s: cannot be written: %s", path, strerror(errno));
}

/* >>materials ------------------------------------------------------------------------------------------------------ */

/* Begins a material of a colour (linear), metallic and rough so far; what else it has follows, and then end_material.
   */
static unsigned begin_material(model *m, const char *name, const double colour[3], double metallic, double roughness,
    const char *more_of_surface) {
  const unsigned index = next(&m->materials);
  say(&m->materials.text,
      "{\"name\":\"%s\",\"pbrMetallicRoughness\":{\"baseColorFactor\":[%.4g,%.4g,%.4g,1],\"metallicFactor\":%.4g,"
      "\"roughnessFactor\":%.4g%s}",
      name, colour[0], colour[1], colour[2], metallic, roughness, more_of_surface);
  return index;
}

/* Ends the material that was begun. */
static void end_material(model *m) { say(&m->materials.text, "}"); }

static const double white[3] = {1, 1, 1};

/* A material with a texture of colours. */
static unsigned begin_painted(model *m, const char *name, unsigned texture, double metallic, double roughness) {
  char surface[64];
  snprintf(surface, sizeof surface, ",\"baseColorTexture\":{\"index\":%u}", texture);
  return begin_material(m, name, white, metallic, roughness, surface);
}

/* A material of one colour; returns its index. */
static unsigned plain_material(
    model *m, const char *name, double r, double g, double b, double metallic, double roughness) {
  const double colour[3] = {r, g, b};
  const unsigned index = begin_material(m, name, colour, metallic, roughness, "");
  end_material(m);
  return index;
}

/* Gives the material that was begun a normal map. */
static void say_relief(model *m, unsigned texture) {
  say(&m->materials.text, ",\"normalTexture\":{\"index\":%u}", texture);
}

/* A body of glass: it has a volume, whose colour is that after 2 cm. */
static unsigned glass_material(model *m) {
  const unsigned index = begin_material(m, "glass", white, 0, 0, "");
  say(&m->materials.text,
      ",\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":1},\"KHR_materials_ior\":{\"ior\":1.5},"
      "\"KHR_materials_volume\":{\"thicknessFactor\":0.01,\"attenuationDistance\":0.02,"
      "\"attenuationColor\":[0.62,0.86,0.80]}}");
  end_material(m);
  return index;
}

/* A pane: without a volume it is thin. */
static unsigned pane_material(model *m, const char *name, const double colour[3]) {
  const unsigned index = begin_material(m, name, colour, 0, 0, "");
  say(&m->materials.text, ",\"extensions\":{\"KHR_materials_transmission\":{\"transmissionFactor\":1}}");
  end_material(m);
  return index;
}

/* >>things --------------------------------------------------------------------------------------------------------- */

/* The table and the wall behind it. */
static void add_room(model *m) {
  part p = {{NULL, 0, 0}, {NULL, 0, 0}, 0};
  const double front_left[3] = {-0.8, 0, 0.75}, along[3] = {1.6, 0, 0}, back[3] = {0, 0, -1.2};
  const double low_left[3] = {-1.4, -0.4, -0.45}, wide[3] = {2.8, 0, 0}, high[3] = {0, 1.8, 0};
  sheet(&p, front_left, along, back, 8, 6); /* two tiles of 10 cm a texture */
  const unsigned tiles = begin_painted(m, "tiles", add_painting(m, 256, 3, paint_tiles), 0, 0.22);
  say_relief(m, add_relief(m, 256, tile_relief));
  end_material(m);
  put(m, add_mesh(m, "table", &p, tiles), place_at(0, 0, 0, 0, 0, 0, 1));

  sheet(&p, low_left, wide, high, 3, 2);
  const unsigned plaster = begin_painted(m, "plaster", add_painting(m, 256, 3, paint_plaster), 0, 1);
  say_relief(m, add_relief(m, 256, plaster_relief));
  end_material(m);
  put(m, add_mesh(m, "wall", &p, plaster), place_at(0, 0, 0, 0, 0, 0, 1));
}

/* Open above: its profile goes up outside and a little down inside. */
static void add_vase(model *m) {
  static const double outside[9][2] = {{0.040, 0.000}, {0.046, 0.010}, {0.074, 0.070}, {0.088, 0.130}, {0.074, 0.195},
      {0.040, 0.245}, {0.031, 0.275}, {0.040, 0.305}, {0.048, 0.316}};
  static const double inside[4][2] = {{0.044, 0.317}, {0.034, 0.303}, {0.026, 0.275}, {0.030, 0.22}};
  part p = {{NULL, 0, 0}, {NULL, 0, 0}, 0};
  profile turned = {{{0}}, 0};
  corner(&turned, 0, 0);
  curve(&turned, outside, 9, 8);
  curve(&turned, inside, 4, 4);
  corner(&turned, 0, 0.2);
  lathe(&p, &turned, 96, 1);
  const unsigned glazed = begin_painted(m, "glaze", add_painting(m, 512, 3, paint_vase), 0, 0.12);
  end_material(m);
  put(m, add_mesh(m, "vase", &p, glazed), place_at(-0.02, 0, -0.24, 10, 0, 0, 1));
}

/* One leaf many times: on twigs in the vase, and beside the oranges. */
static void add_leaves(model *m) {
  static const double twigs[3][2] = {
      {-38, 0.26}, {8, 0.34}, {47, 0.24}}; /* how far it leans to the right, and length */
  part p = {{NULL, 0, 0}, {NULL, 0, 0}, 0};
  leaf(&p);
  const unsigned green = begin_painted(m, "leaf", add_painting(m, 128, 4, paint_leaf), 0, 0.5);
  say(&m->materials.text, ",\"alphaMode\":\"MASK\",\"alphaCutoff\":0.5,\"doubleSided\":true");
  end_material(m);
  const unsigned one = add_mesh(m, "leaf", &p, green);
  bar(&p, 0, 0, 0, 1, 0.01);
  const unsigned twig = add_mesh(m, "twig", &p, plain_material(m, "wood", 0.20, 0.12, 0.06, 0, 0.9));

  for (int i = 0; i < 3; i++) {
    const double lean = twigs[i][0] * PI / 180, size = twigs[i][1];
    place stands = place_at(-0.02, 0.24, -0.24, 0, 0, -twigs[i][0], 0.5);
    stands.high = size;
    put(m, twig, stands);
    for (int k = 0; k < 7; k++) {
      const double t = 0.35 + 0.65 * k / 6;
      const double turn = k == 6 ? 90 - twigs[i][0] : 137.5 * (k + 3 * i);
      put(m, one,
          place_at(-0.02 + size * t * sin(lean), 0.24 + size * t * cos(lean), -0.24, turn, 0, 28 + 10 * hashed(i, k),
              0.95 - 0.05 * k));
    }
  }
  put(m, one, place_at(0.20, 0.004, 0.27, 150, 0, 8, 0.9));
  put(m, one, place_at(0.01, 0.115, 0.10, 30, 0, 30, 0.8));
  put(m, one, place_at(0.00, 0.115, 0.10, 160, 0, 24, 0.7));
}

/* The bowl and six oranges, which are one mesh. */
static void add_bowl(model *m) {
  static const double outside[5][2] = {{0.050, 0.012}, {0.090, 0.022}, {0.128, 0.052}, {0.146, 0.088}, {0.150, 0.100}};
  static const double inside[5][2] = {{0.146, 0.100}, {0.142, 0.088}, {0.124, 0.055}, {0.088, 0.026}, {0.040, 0.017}};
  static const place oranges[6] = {{-0.060, 0.062, 0.115, 0, 20, 0, 1, 1}, {0.052, 0.060, 0.125, 80, 0, 30, 1, 1},
      {-0.005, 0.058, 0.040, 200, 40, 0, 1, 1}, {-0.003, 0.108, 0.098, 130, 60, 20, 1, 1},
      {0.185, 0.0385, 0.215, 60, 100, 0, 1, 1}, {-0.205, 0.036, 0.265, 10, 70, 45, 0.93, 0.93}};
  part p = {{NULL, 0, 0}, {NULL, 0, 0}, 0};
  profile turned = {{{0}}, 0};
  corner(&turned, 0, 0);
  corner(&turned, 0.055, 0);
  corner(&turned, 0.050, 0.012);
  turned.count--;
  curve(&turned, outside, 5, 8);
  curve(&turned, inside, 5, 8);
  corner(&turned, 0, 0.016);
  lathe(&p, &turned, 96, 5);
  const double copper[3] = {0.90, 0.47, 0.30};
  const unsigned metal = begin_material(m, "copper", copper, 1, 0.3, "");
  say_relief(m, add_relief(m, 256, hammer_relief));
  end_material(m);
  put(m, add_mesh(m, "bowl", &p, metal), place_at(0, 0, 0.09, 0, 0, 0, 1));

  const double peel[3] = {0.92, 0.34, 0.03};
  ball(&p, 0.0385, 0, 24);
  const unsigned skin = begin_material(m, "peel", peel, 0, 0.4, "");
  say_relief(m, add_relief(m, 256, peel_relief));
  end_material(m);
  const unsigned orange = add_mesh(m, "orange", &p, skin);
  for (int i = 0; i < 6; i++) put(m, orange, oranges[i]);
}

/* Its profile goes up outside and down inside, so that it is closed. */
static void add_goblet(model *m) {
  static const double outside[10][2] = {{0.038, 0.004}, {0.020, 0.010}, {0.006, 0.022}, {0.005, 0.050}, {0.007, 0.078},
      {0.028, 0.096}, {0.041, 0.122}, {0.043, 0.150}, {0.038, 0.184}, {0.036, 0.196}};
  static const double inside[6][2] = {
      {0.034, 0.196}, {0.036, 0.184}, {0.0405, 0.150}, {0.038, 0.124}, {0.024, 0.100}, {0.004, 0.093}};
  part p = {{NULL, 0, 0}, {NULL, 0, 0}, 0};
  profile turned = {{{0}}, 0};
  corner(&turned, 0, 0);
  corner(&turned, 0.039, 0);
  curve(&turned, outside, 10, 8);
  curve(&turned, inside, 6, 6);
  corner(&turned, 0, 0.0925);
  lathe(&p, &turned, 96, 1);
  put(m, add_mesh(m, "goblet", &p, glass_material(m)), place_at(0.285, 0, 0.10, 0, 0, 0, 1));
}

/* Brass below and above, the lattice between, and a candle within, whose flame is a light. */
static void add_lantern(model *m) {
  static const double dome[5][2] = {{0.082, 0.222}, {0.076, 0.240}, {0.048, 0.268}, {0.018, 0.284}, {0.012, 0.300}};
  const place here = place_at(-0.33, 0, -0.12, 12, 0, 0, 1);
  const unsigned brass = plain_material(m, "brass", 0.87, 0.64, 0.30, 1, 0.22);
  part p = {{NULL, 0, 0}, {NULL, 0, 0}, 0};
  profile turned = {{{0}}, 0};
  corner(&turned, 0, 0);
  corner(&turned, 0.084, 0);
  corner(&turned, 0.084, 0.012);
  corner(&turned, 0.074, 0.026);
  corner(&turned, 0.020, 0.028);
  corner(&turned, 0, 0.028);
  lathe(&p, &turned, 72, 1);
  memset(&turned, 0, sizeof turned);
  corner(&turned, 0, 0.216);
  corner(&turned, 0.084, 0.216);
  corner(&turned, 0.084, 0.222);
  curve(&turned, dome, 5, 8);
  corner(&turned, 0, 0.304);
  lathe(&p, &turned, 72, 1);
  put(m, add_mesh(m, "lantern", &p, brass), here);

  memset(&turned, 0, sizeof turned);
  corner(&turned, 0.074, 0.026);
  corner(&turned, 0.074, 0.218);
  lathe(&p, &turned, 72, 1);
  const unsigned lattice = begin_painted(m, "lattice", add_painting(m, 512, 4, paint_lattice), 1, 0.3);
  say(&m->materials.text, ",\"alphaMode\":\"MASK\",\"alphaCutoff\":0.5,\"doubleSided\":true");
  end_material(m);
  put(m, add_mesh(m, "lattice", &p, lattice), here);

  memset(&turned, 0, sizeof turned);
  corner(&turned, 0, 0.028);
  corner(&turned, 0.022, 0.028);
  corner(&turned, 0.022, 0.085);
  corner(&turned, 0, 0.082);
  lathe(&p, &turned, 32, 1);
  put(m, add_mesh(m, "candle", &p, plain_material(m, "wax", 0.85, 0.78, 0.62, 0, 0.6)), here);

  ball(&p, 0.013, 0.110, 12);
  const unsigned flame = begin_material(m, "flame", white, 0, 1, "");
  say(&m->materials.text, ",\"emissiveFactor\":[1,0.62,0.28],"
                          "\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":300}}");
  end_material(m);
  put(m, add_mesh(m, "flame", &p, flame), here);
}

/* Three by four fields, each cut by its diagonals, so that leads hold 48 triangles of five colours. */
static void add_window(model *m) {
  enum { COLOURS = 5 };
  const int across = 3, up = 4;
  static const double tints[COLOURS][3] = {
      {0.85, 0.10, 0.09}, {0.95, 0.62, 0.12}, {0.10, 0.22, 0.80}, {0.10, 0.58, 0.26}, {0.86, 0.90, 0.88}};
  static const char *const names[COLOURS] = {"ruby pane", "amber pane", "cobalt pane", "emerald pane", "clear pane"};
  static const int which[2][4] = {{2, 1, 0, 1}, {3, 4, 2, 4}};
  const place here = place_at(0.44, 0.014, -0.06, -50, 0, 0, 1);
  const double field = 0.12, left = -0.18;
  part panes[COLOURS], leads = {{NULL, 0, 0}, {NULL, 0, 0}, 0}, frame = {{NULL, 0, 0}, {NULL, 0, 0}, 0};
  const double normal[3] = {0, 0, 1};
  memset(panes, 0, sizeof panes);
  for (int k = 0; k < across * up; k++) {
    const double x = left + field * (k % across), y = field * (k / across);
    const double at[5][3] = {{x, y, 0}, {x + field, y, 0}, {x + field, y + field, 0}, {x, y + field, 0},
        {x + 0.5 * field, y + 0.5 * field, 0}};
    for (int side = 0; side < 4; side++) {
      part *to = &panes[which[(k % across + k / across) % 2][side]];
      const uint32_t a = vertex(to, at[side], normal, 0, 0), b = vertex(to, at[(side + 1) % 4], normal, 1, 0);
      triangle(to, a, b, vertex(to, at[4], normal, 0.5, 0.5));
    }
    bar(&leads, x, y, x + field, y + field, 0.005);
    bar(&leads, x + field, y, x, y + field, 0.005);
  }
  for (int i = 1; i < across; i++) bar(&leads, left + field * i, 0, left + field * i, field * up, 0.006);
  for (int i = 1; i < up; i++) bar(&leads, left, field * i, -left, field * i, 0.006);
  bar(&frame, left, 0, -left, 0, 0.028);
  bar(&frame, left, field * up, -left, field * up, 0.028);
  bar(&frame, left, 0, left, field * up, 0.027);
  bar(&frame, -left, 0, -left, field * up, 0.027);
  for (int i = 0; i < COLOURS; i++)
    put(m, add_mesh(m, names[i], &panes[i], pane_material(m, names[i], tints[i])), here);
  put(m, add_mesh(m, "leads", &leads, plain_material(m, "lead", 0.25, 0.25, 0.27, 0, 0.6)), here);
  put(m, add_mesh(m, "frame", &frame, plain_material(m, "oak", 0.28, 0.16, 0.08, 0, 0.5)), here);
}

/* Both look along their own -z. */
static void add_view_and_sun(model *m) {
  begin_node(m, place_at(0.045, 0.42, 1.44, 0, -11.5, 0, 1));
  say(&m->nodes.text, ",\"camera\":0}");
  begin_node(m, place_at(1, 1, 0, 83, -36, 0, 1));
  say(&m->nodes.text, ",\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}");
}

int main(int argc, char **argv) {
  static model m; /* static: zeroed */
  if (argc != 2) return ex_fail("usage: model FILE.glb") ? 0 : 1;
  add_room(&m);
  add_vase(&m);
  add_leaves(&m);
  add_bowl(&m);
  add_goblet(&m);
  add_lantern(&m);
  add_window(&m);
  add_view_and_sun(&m);
  return write_model(&m, argv[1]) ? 0 : 1;
}
