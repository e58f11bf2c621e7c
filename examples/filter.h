/* filter.h - takes noise out of a picture of pktrt.h whose passes are at hand: a filter beside the renderer.

     filter_halves h;                                  in the hook `pass` of pktrt_render_desc, after each round:
     filter_begin(&h, width, height)                     filter_add_pass(&h, desc->pixels)
                                                         filter_add_features(&h, desc->depth, desc->normal, desc->albedo)
     ... pktrt_render, with an even number of passes ...
     filter_finish(&h, &picture);                      means of both halves of the passes, and variances
     picture.depth = ..., .normal = ..., .albedo = ... buffers of pktrt_render_desc
     filter_rectangle(&picture, 0, 0, width, height, out, error);    or filter_tile by a parallel_for
     filter_end(&h);

   A pixel takes its value on a plane that is fitted to the pixels around it that can share its mean, after Sakai et al.
   2024, "A statistical approach to Monte Carlo denoising": squared differences of two means over the sum of their
   variances, as in Welch's t-test, averaged over 3 x 3 pixels, decide about membership; normals, depths and albedos are
   range weights beside it, and a pixel 2.4 pixels away weighs half. The pixel itself first goes towards its neighbours on
   the line along which colours change least, for pixels of an edge share their mean with few others. (Colours are not
   divided by albedos: where gloss adds to a small albedo that made glints of other pixels.)

   Fireflies: a pixel over eight times as bright in one half as in the other, and as every pixel around, becomes as bright
   as the brightest of these (see filter__calm). That light is lost.

   Passes go to two halves by turns. Each half's means and features weigh the other half's colours, so a bright sample by
   chance is neither kept nor cast out for being bright. Variances are those of all passes: a half whose passes all miss a
   rare light takes its mean for certain and finds no pixel like it, and the light that the other half meets would stay.

   Hence the error can be estimated. With weights that sum to 1, that of the pixel itself being w, |F - x|^2 - V (1 - 2 w)
   has the mean |F - m|^2, where x is a pixel's mean, V its squared error, F the filtered mean and m the truth; of the
   mean of two, |(F + G)/2 - m|^2 = (|F - m|^2 + |G - m|^2) / 2 - |F - G|^2 / 4. Summed over 13 x 13 pixels without the
   3 x 3 in the middle this tells which part of the way from the picture to the filtered one has the least error: the
   picture goes that part (see filter__choose). Where filtering does harm, the part is 0. It is 0 as well where the gain is below half its own standard error (of the colours
   as they are: twice that), and smaller up to twice (five times) that.

   All of this is done twice: for colours as a screen shows them, cut off at white (1), and as they are. The first decides
   below white, the second above; where a pixel goes from above to below, the brighter of both; and the second alone where
   its gain is eight times its standard error. WHY: one glint of a hundred times white in an edge of a mirror is more
   squared error than all pixels around. To spread it over them lowers the error of the colours, and ruins what a screen
   shows.

   Convergence: as passes grow, variances shrink as one over their number, and the test tells apart any two pixels whose
   true means differ. Then the pixels that still share a mean have the same.
   Bias: at a given number of passes true differences below the noise are blurred, by less than about three standard errors
   of a difference of two pixels, within 10 pixels. The estimated error contains it. Sums are not kept: pictures get darker
   where bright samples are rare. The estimate misses part of that, for variances know nothing of lights that no sample has
   met; filter_unreliable tells where few pixels carry it.

   Same bits for any division into rectangles: arithmetic is that of floats, sums have a fixed order, and the only
   function is the square root. Pixels that are not finite stay as they are. */
#ifndef FILTER_H
#define FILTER_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if defined(__GNUC__)
#define FILTER_API static __attribute__((unused))
#else
#define FILTER_API static
#endif

/* >>interface ------------------------------------------------------------------------------------------------------ */

typedef struct filter_picture { /* all tight, row 0 at the top */
  uint32_t width, height;
  const float *half[2];                 /* mean colours of two halves of the passes */
  const float *variance;                /* squared error of either mean by all passes, summed over channels */
  const float *depth, *normal, *albedo; /* as pktrt_render_desc has them */
  /* These buffers by halves, FILTER_FEATURES floats a pixel; NULL: not known. Then the features of all passes serve
     both halves, and where edges are noisy, the estimated error is low: features know the noise that they share. */
  const float *features[2];
} filter_picture;

enum { FILTER_FEATURES = 7 }; /* depth, normal, albedo */

/* Filters the pixels [x, x+w) x [y, y+h) into their place in `out`, a whole picture. `error`, if not NULL, gets the
   estimated squared error of each of them, summed over channels: some are below 0 by chance, means over many are not.
   False: no memory. */
FILTER_API bool filter_rectangle(
    const filter_picture *from, uint32_t x, uint32_t y, uint32_t w, uint32_t h, float *out, float *error);

/* Whether the sum of these estimates, of the whole picture, is not to be believed: fewer than two pixels carry the
   variance, or fewer than FILTER_CARRIED the estimate. */
FILTER_API bool filter_unreliable(const filter_picture *from, const float *error);

/* The picture in tiles, each by a call of filter_tile, from any thread. */
enum { FILTER_TILE = 128 };
typedef struct filter_job {
  const filter_picture *picture;
  float *out, *error; /* as above */
  bool *failed;       /* one for each tile: there was no memory */
} filter_job;
FILTER_API size_t filter_tiles(const filter_picture *from);
FILTER_API void filter_tile(void *job, size_t i);

typedef struct filter_halves { /* gathers passes */
  uint32_t width, height, passes;
  double *total;               /* of all passes so far */
  double *mean[2], *spread[2]; /* of each half: means, and sums of squared differences from them over channels */
  float *half[2], *variance;
  uint32_t described;  /* passes whose features are known, too */
  double *features[2]; /* sums of the features of each half, FILTER_FEATURES a pixel */
  float *half_features[2];
} filter_halves;

FILTER_API bool filter_begin(filter_halves *halves, uint32_t width, uint32_t height); /* false: no memory */
FILTER_API void filter_add_pass(filter_halves *halves, const float *pixels); /* pixels: the mean of all passes so far */
/* Optional, after each filter_add_pass: the buffers of pktrt_render_desc, means of all passes so far. */
FILTER_API void filter_add_features(
    filter_halves *halves, const float *depth, const float *normal, const float *albedo);
FILTER_API bool filter_finish(filter_halves *halves, filter_picture *to); /* false: fewer than two passes */
FILTER_API void filter_end(filter_halves *halves);

/* >>passes --------------------------------------------------------------------------------------------------------- */

FILTER_API bool filter_begin(filter_halves *halves, uint32_t width, uint32_t height) {
  const size_t n = (size_t)width * height;
  memset(halves, 0, sizeof *halves);
  halves->width = width, halves->height = height;
  halves->total = (double *)calloc(n * 3, sizeof(double));
  halves->variance = (float *)calloc(n, sizeof(float));
  bool ok = halves->total && halves->variance;
  for (int k = 0; k < 2; k++) {
    halves->mean[k] = (double *)calloc(n * 3, sizeof(double));
    halves->spread[k] = (double *)calloc(n, sizeof(double));
    halves->half[k] = (float *)calloc(n * 3, sizeof(float));
    halves->features[k] = (double *)calloc(n * FILTER_FEATURES, sizeof(double));
    halves->half_features[k] = (float *)calloc(n * FILTER_FEATURES, sizeof(float));
    ok = ok && halves->mean[k] && halves->spread[k] && halves->half[k];
    ok = ok && halves->features[k] && halves->half_features[k];
  }
  if (!ok) filter_end(halves);
  return ok;
}

FILTER_API void filter_end(filter_halves *halves) {
  free(halves->total), free(halves->variance);
  for (int k = 0; k < 2; k++) {
    free(halves->mean[k]), free(halves->spread[k]), free(halves->half[k]);
    free(halves->features[k]), free(halves->half_features[k]);
  }
  memset(halves, 0, sizeof *halves);
}

FILTER_API void filter_add_pass(filter_halves *halves, const float *pixels) {
  const size_t n = (size_t)halves->width * halves->height;
  const uint32_t side = halves->passes & 1, count = halves->passes / 2 + 1;
  double *mean = halves->mean[side], *spread = halves->spread[side];
  halves->passes++;
  for (size_t i = 0; i < n * 3; i++) {
    const double total = (double)pixels[i] * halves->passes, colour = total - halves->total[i];
    const double before = colour - mean[i];
    halves->total[i] = total;
    mean[i] += before / count;
    spread[i / 3] += before * (colour - mean[i]);
  }
}

/* Adds what the last pass added to a mean over `count` passes to the sum over its half: the sum over all passes less the
   sums of both halves is new. Where nothing was met, the depth is infinite and counts as 0. */
static void filter__add_feature(double *const sums[2], uint32_t side, uint32_t count, size_t at, float mean) {
  const double value = mean < 1e15f ? (double)mean : 0;
  sums[side][at] += value * count - sums[0][at] - sums[1][at];
}

FILTER_API void filter_add_features(
    filter_halves *halves, const float *depth, const float *normal, const float *albedo) {
  const size_t n = (size_t)halves->width * halves->height;
  const uint32_t side = halves->described & 1;
  const uint32_t count = ++halves->described;

  for (size_t i = 0; i < n; i++) {
    const size_t at = FILTER_FEATURES * i;
    filter__add_feature(halves->features, side, count, at, depth[i]);
    for (size_t c = 0; c < 3; c++) {
      filter__add_feature(halves->features, side, count, at + 1 + c, normal[3 * i + c]);
      filter__add_feature(halves->features, side, count, at + 4 + c, albedo[3 * i + c]);
    }
  }
}

/* Takes the variance from all passes, for that of a half is coarse: where its passes all miss a rare light it is nearly 0,
   and where some meet it too small for what the other half tells. */
FILTER_API bool filter_finish(filter_halves *halves, filter_picture *to) {
  const size_t n = (size_t)halves->width * halves->height;
  memset(to, 0, sizeof *to);
  if (halves->passes < 2) return false;
  to->width = halves->width, to->height = halves->height;
  const double passes = halves->passes, first = (halves->passes + 1) / 2, second = halves->passes / 2;
  const double between = first * second / passes, scale = 0.5 * (1 / first + 1 / second) / (passes - 1);
  for (size_t i = 0; i < n; i++) {
    double squared = halves->spread[0][i] + halves->spread[1][i];
    for (size_t c = 0; c < 3; c++) {
      const double apart = halves->mean[0][3 * i + c] - halves->mean[1][3 * i + c];
      squared += between * apart * apart;
    }
    halves->variance[i] = (float)(squared * scale);
  }
  for (int k = 0; k < 2; k++) {
    for (size_t i = 0; i < n * 3; i++) halves->half[k][i] = (float)halves->mean[k][i];
    to->half[k] = halves->half[k];
    if (halves->described != halves->passes) continue;
    const double count = k ? second : first;
    for (size_t i = 0; i < n * FILTER_FEATURES; i++)
      halves->half_features[k][i] = (float)(halves->features[k][i] / count);
    to->features[k] = halves->half_features[k];
  }
  to->variance = halves->variance;
  return true;
}

/* >>rooms ---------------------------------------------------------------------------------------------------------- */

/* How far weights, comparisons, pooled variances, the choice between both pictures, and the search for fireflies look. */
enum { FILTER_DENSE = 3 }; /* farther away every other pixel is enough */
enum { FILTER_REACH = 10, FILTER_PATCH = 1, FILTER_POOL = 2, FILTER_MIX = 6, FILTER_CALM = 2 };
#define FILTER_FALL 18.0f /* a pixel at the end of the reach weighs 1 / (1 + this) */
#define FILTER_LINE 0.3f  /* the most that a pixel goes to its neighbours on a line */
#define FILTER_MET 0.5f   /* squared length of a mean normal from which on a depth is known */
enum { FILTER_BORDER = FILTER_REACH + FILTER_PATCH + FILTER_POOL + FILTER_MIX + FILTER_CALM };

/* Sums of one half's weights over the pixels of the other half, one plane each. Offsets u, v are in units of the reach. */
enum {
  FILTER_W, /* weights */
  FILTER_U, /* weights times u, and so on */
  FILTER_V,
  FILTER_UU,
  FILTER_UV,
  FILTER_VV,
  FILTER_C,                 /* weights times colours: three planes */
  FILTER_CU = FILTER_C + 3, /* weights times u times colours */
  FILTER_CV = FILTER_CU + 3,
  FILTER_SUMS = FILTER_CV + 3
};

/* A rectangle with its border. Pixels beyond the picture repeat its edge, for comparisons; they weigh nothing. */
typedef struct filter__room {
  const filter_picture *picture;
  int32_t x, y, width, height; /* where it lies in the picture, and its size */
  float *planes;               /* of all that follows */
  float *colour[2][3];         /* of the halves */
  float *bright[2];            /* of the halves: sums over channels, before fireflies are taken out */
  float *feature[2][FILTER_FEATURES];
  float *variance, *pooled, *inside;             /* pooled: with the variances around */
  float *share[2], *distance[2], *rows[2];       /* of one offset */
  float *sum[2][FILTER_SUMS], *filtered[2][3];   /* of each half's weights with the other half's colours */
  float *shown_gain, *shown_change, *shown_risk; /* see filter__judge */
  float *gain, *change, *risk, *square;          /* square: of the gain */
} filter__room;

/* Gives all planes their places in one block of memory. */
static bool filter__open(filter__room *room) {
  enum { EACH = 3 + 1 + FILTER_FEATURES + 3 + FILTER_SUMS + 3, PLANES = 2 * EACH + 10 };
  const size_t n = (size_t)room->width * (size_t)room->height;
  float **const last[] = {&room->variance, &room->pooled, &room->inside, &room->shown_gain, &room->shown_change,
      &room->shown_risk, &room->gain, &room->change, &room->risk, &room->square};
  float *next = (float *)calloc(n * PLANES, sizeof(float));
  room->planes = next;
  if (!next) return false;

  for (int k = 0; k < 2; k++) {
    float **const own[] = {&room->bright[k], &room->share[k], &room->distance[k], &room->rows[k]};
    for (size_t i = 0; i < sizeof own / sizeof *own; i++) *own[i] = next, next += n;
    for (int c = 0; c < 3; c++) room->colour[k][c] = next, next += n;
    for (int c = 0; c < 3; c++) room->filtered[k][c] = next, next += n;
    for (int f = 0; f < FILTER_FEATURES; f++) room->feature[k][f] = next, next += n;
    for (int i = 0; i < FILTER_SUMS; i++) room->sum[k][i] = next, next += n;
  }
  for (size_t i = 0; i < sizeof last / sizeof *last; i++) *last[i] = next, next += n;
  return true;
}

static int32_t filter__clamp(int32_t at, uint32_t size) {
  return at < 0 ? 0 : at >= (int32_t)size ? (int32_t)size - 1 : at;
}

/* Returns a feature of a half, or of all passes if those of the halves are not known. */
static float filter__feature(const filter_picture *p, int k, size_t from, size_t f) {
  if (p->features[k]) return p->features[k][FILTER_FEATURES * from + f];
  if (f >= 4) return p->albedo[3 * from + f - 4];
  if (f >= 1) return p->normal[3 * from + f - 1];
  return p->depth[from] < 1e15f ? p->depth[from] : 0;
}

/* Returns whether the depth of a half is known: most samples of the half met something, as its normal tells. WHY: a
   depth is a mean over the samples that met something, and how many did is not known. Where some samples met nothing,
   the difference of two such means is not the depth of one pass, and each half's depth tells of what the other half met:
   lights out of focus before nothing would be taken for known, and the estimated error be half of the truth. */
static bool filter__depth_known(const float normal[3]) {
  return normal[0] * normal[0] + normal[1] * normal[1] + normal[2] * normal[2] >= FILTER_MET;
}

/* Fills in one pixel: features are divided by how much they may differ, and depths compared in filter__share. A depth
   that is not known is 0. */
static void filter__load_pixel(filter__room *room, size_t to, size_t from) {
  const filter_picture *p = room->picture;
  const float normals = 1.58113883f, albedos = 3.16227766f; /* 1/sqrt(0.4), 1/sqrt(0.1) */
  for (int k = 0; k < 2; k++) {
    float feature[FILTER_FEATURES];
    for (size_t c = 0; c < 3; c++) room->colour[k][c][to] = p->half[k][3 * from + c];
    room->bright[k][to] = room->colour[k][0][to] + room->colour[k][1][to] + room->colour[k][2][to];
    for (size_t f = 0; f < FILTER_FEATURES; f++) feature[f] = filter__feature(p, k, from, f);
    if (!filter__depth_known(feature + 1)) feature[0] = 0;
    for (size_t f = 0; f < FILTER_FEATURES; f++)
      room->feature[k][f][to] = feature[f] * (f >= 4 ? albedos : f >= 1 ? normals : 1);
  }
  room->variance[to] = p->variance[from];
}

/* Returns what part of pixel p's colour in half k is left: all of it, unless the pixel is a firefly there. That is one
   which is over eight times as bright as the other half says and as any pixel around in either half, and whose variance
   is at least half of what such a difference between the halves makes. A firefly becomes as bright as the brightest of
   these. */
static float filter__calm(const filter__room *room, int k, int32_t p) {
  const float own = room->bright[k][p];
  float most = room->bright[1 - k][p];

  for (int32_t dy = -FILTER_CALM; dy <= FILTER_CALM; dy++)
    for (int32_t dx = -FILTER_CALM; dx <= FILTER_CALM; dx++) {
      const int32_t q = p + dy * room->width + dx;
      if (q == p || room->inside[q] == 0) continue;
      for (int j = 0; j < 2; j++) most = room->bright[j][q] > most ? room->bright[j][q] : most;
    }

  const float beyond = own - most;
  const bool firefly = own > 8 * most && room->variance[p] * 12 > beyond * beyond;
  return firefly && most >= 0 ? most / own : 1;
}

/* Takes out fireflies, and from the variances what these had. */
static void filter__calm_all(filter__room *room) {
  for (int32_t y = FILTER_CALM; y < room->height - FILTER_CALM; y++)
    for (int32_t x = FILTER_CALM; x < room->width - FILTER_CALM; x++) {
      const int32_t p = y * room->width + x;
      for (int k = 0; k < 2; k++) {
        const float left = filter__calm(room, k, p);
        if (left == 1) continue;
        room->variance[p] *= left * left;
        for (int c = 0; c < 3; c++) room->colour[k][c][p] *= left;
      }
    }
}

/* Sets `pooled` to the mean of two means of variances around a pixel, of the four next to it and of all in 5 x 5. The
   pixel's own variance is left out. WHY: it knows of both halves. What one half weighs by it would depend on the other
   half, and the estimated error would be too low, with two passes by a quarter. */
static void filter__pool(filter__room *room) {
  const int32_t w = room->width, h = room->height, reach = FILTER_POOL;
  const float around = (float)((2 * reach + 1) * (2 * reach + 1) - 1);

  for (int32_t y = reach; y < h - reach; y++)
    for (int32_t x = reach; x < w - reach; x++) {
      const float *v = room->variance + y * w + x;
      float sum = 0;
      for (int32_t dy = -reach; dy <= reach; dy++)
        for (int32_t dx = -reach; dx <= reach; dx++) sum += dx || dy ? v[dy * w + dx] : 0;
      room->pooled[y * w + x] = 0.125f * (v[-w] + v[-1] + v[1] + v[w]) + 0.5f * sum / around;
    }
}

static void filter__load(filter__room *room) {
  const filter_picture *p = room->picture;
  for (int32_t y = 0; y < room->height; y++)
    for (int32_t x = 0; x < room->width; x++) {
      const int32_t px = filter__clamp(room->x + x, p->width), py = filter__clamp(room->y + y, p->height);
      const size_t to = (size_t)y * (size_t)room->width + (size_t)x;
      filter__load_pixel(room, to, (size_t)py * p->width + (size_t)px);
      room->inside[to] = px == room->x + x && py == room->y + y ? 1.0f : 0.0f;
    }
  filter__calm_all(room);
  filter__pool(room);
}

/* >>weights -------------------------------------------------------------------------------------------------------- */

/* Computes what features of half k let pixel q weigh at p: 1 if they agree, 0 from 8 squared units on. Depths are compared
   where both are known. */
static float filter__share(const filter__room *room, int k, int32_t p, int32_t q) {
  const float *depth = room->feature[k][0], zp = depth[p], zq = depth[q], nearer = zp < zq ? zp : zq;
  float apart = 0;
  /* A fifth of the depth is a unit. */
  if (nearer > 0) apart = (zp - zq) * (zp - zq) / (0.04f * nearer * nearer + 1e-20f);
  for (int f = 1; f < FILTER_FEATURES; f++) {
    const float d = room->feature[k][f][p] - room->feature[k][f][q];
    apart += d * d;
  }
  const float rest = 1 - 0.125f * apart;
  return rest > 0 ? rest * rest * room->inside[q] : 0;
}

/* Computes t^2 of p and q in a half; bounded, so that one pixel is not all of a patch's mean. */
static float filter__distance(const filter__room *room, int k, int32_t p, int32_t q) {
  float squared = 0;
  for (int c = 0; c < 3; c++) {
    const float d = room->colour[k][c][p] - room->colour[k][c][q];
    squared += d * d;
  }
  const float ratio = squared / (room->pooled[p] + room->pooled[q] + 1e-20f);
  return ratio < 1e6f ? ratio : 1e6f;
}

/* Compares all pixels with those at an offset. */
static void filter__compare(filter__room *room, int32_t offset) {
  const int32_t w = room->width, first = FILTER_REACH + FILTER_POOL, patch = FILTER_PATCH;
  for (int k = 0; k < 2; k++)
    for (int32_t y = first; y < room->height - first; y++) {
      for (int32_t p = y * w + first; p < (y + 1) * w - first; p++) {
        room->share[k][p] = filter__share(room, k, p, p + offset);
        room->distance[k][p] = filter__distance(room, k, p, p + offset);
      }
      for (int32_t p = y * w + first + patch; p < (y + 1) * w - first - patch; p++)
        room->rows[k][p] = room->distance[k][p - 1] + room->distance[k][p] + room->distance[k][p + 1];
    }
}

/* Adds to the sums of half k at pixel p: q weighs so much at the offset (u, v). */
static void filter__add(filter__room *room, int k, int32_t p, int32_t q, float weight, float u, float v) {
  float *const *sum = room->sum[k];
  sum[FILTER_W][p] += weight;
  sum[FILTER_U][p] += weight * u;
  sum[FILTER_V][p] += weight * v;
  sum[FILTER_UU][p] += weight * u * u;
  sum[FILTER_UV][p] += weight * u * v;
  sum[FILTER_VV][p] += weight * v * v;
  for (int c = 0; c < 3; c++) {
    const float part = weight * room->colour[1 - k][c][q];
    sum[FILTER_C + c][p] += part;
    sum[FILTER_CU + c][p] += part * u;
    sum[FILTER_CV + c][p] += part * v;
  }
}

/* Adds up what pixels at an offset weigh by each half's test, and the colours of the other half with these weights. */
static void filter__accumulate(filter__room *room, int32_t dx, int32_t dy) {
  const int32_t w = room->width, first = FILTER_REACH + FILTER_POOL + FILTER_PATCH, offset = dy * w + dx;
  const float u = (float)dx / (float)FILTER_REACH, v = (float)dy / (float)FILTER_REACH;
  const float near = 1 / (1 + FILTER_FALL * (u * u + v * v));

  for (int k = 0; k < 2; k++) {
    const float *rows = room->rows[k];
    for (int32_t y = first; y < room->height - first; y++)
      for (int32_t p = y * w + first; p < (y + 1) * w - first; p++) {
        const float rest = 1 - (rows[p - w] + rows[p] + rows[p + w]) * (1.0f / 45); /* 9 pixels, t^2 up to 5 */
        const float weight = rest > 0 ? near * rest * rest * room->share[k][p] : 0;
        if (weight > 0) filter__add(room, k, p, p + offset, weight, u, v);
      }
  }
}

static void filter__weigh(filter__room *room) {
  for (int32_t dy = -FILTER_REACH; dy <= FILTER_REACH; dy++)
    for (int32_t dx = -FILTER_REACH; dx <= FILTER_REACH; dx++) {
      const bool sparse = dx * dx + dy * dy > FILTER_DENSE * FILTER_DENSE && (dx + dy) % 2;
      if ((!dx && !dy) || sparse) continue;
      filter__compare(room, dy * room->width + dx);
      filter__accumulate(room, dx, dy);
    }
}

/* >>choice --------------------------------------------------------------------------------------------------------- */

/* What a screen shows of a value. */
static float filter__shown(float x) { return x < 0 ? 0 : x < 1 ? x : 1; }

/* Returns the squared difference, in half k, of pixel p and the mean of its two neighbours at p - step and p + step. */
static float filter__bend(const filter__room *room, int k, int32_t p, int32_t step) {
  float squared = 0;
  for (int c = 0; c < 3; c++) {
    const float *x = room->colour[k][c];
    const float d = x[p] - 0.5f * (x[p - step] + x[p + step]);
    squared += d * d;
  }
  return squared;
}

/* Finds the line through pixel p, of eight directions, along which colours of half k change least: *step leads from one
   of its pixels to the next. Returns the part by which the pixel should go to the mean of its neighbours on the line: its
   variance over its squared difference from that mean, which contains its variance, and no more than FILTER_LINE. The
   difference is taken at three pixels, and the smallest of eight is small by chance, too: hence that part of it. The
   variance is the least of those of the neighbours and of the pixels around, because that of the pixel knows of both
   halves, and a glint beside it is no noise of its own. */
static float filter__line(const filter__room *room, int k, int32_t p, int32_t *step) {
  static const int8_t lines[8][2] = {{1, 0}, {0, 1}, {1, 1}, {1, -1}, {2, 1}, {1, 2}, {2, -1}, {1, -2}};
  float least = 1e30f, noise = 0;
  *step = 0;

  for (int i = 0; i < 8; i++) {
    const int32_t next = lines[i][1] * room->width + lines[i][0];
    if (room->inside[p - next] == 0 || room->inside[p + next] == 0) continue;
    const float beside = filter__bend(room, k, p - next, next) + filter__bend(room, k, p + next, next);
    const float bend = 0.5f * filter__bend(room, k, p, next) + 0.25f * beside;
    if (!(bend < least)) continue;
    least = bend;
    noise = room->variance[p - next] < room->variance[p + next] ? room->variance[p - next] : room->variance[p + next];
    noise = noise < room->pooled[p] ? noise : room->pooled[p];
    *step = next;
  }

  const float part = FILTER_LINE * noise / (least + 1e-20f);
  return part < FILTER_LINE ? part : FILTER_LINE;
}

/* Fits a plane to the colours around pixel p, the pixel itself weighing 1, and keeps its value at p. Returns what the
   pixel itself weighs in that. First the pixel goes to the mean of its neighbours on a line by a part (see filter__line):
   the pixels of an edge differ from all around, and most of the noise that is left is theirs. A hundredth is added to the
   variances of offsets, so that few pixels or such in a line tilt no plane. */
static float filter__fit(filter__room *room, int k, int32_t p) {
  float *const *sum = room->sum[k];
  const float weight = sum[FILTER_W][p] + 1;
  const float u = sum[FILTER_U][p] / weight, v = sum[FILTER_V][p] / weight; /* means */
  const float uu = sum[FILTER_UU][p] / weight - u * u + 0.01f;
  const float vv = sum[FILTER_VV][p] / weight - v * v + 0.01f;
  const float uv = sum[FILTER_UV][p] / weight - u * v;
  const float determinant = uu * vv - uv * uv;
  const float across = (vv * u - uv * v) / determinant, along = (uu * v - uv * u) / determinant;

  int32_t step;
  const float part = filter__line(room, k, p, &step);

  for (int c = 0; c < 3; c++) {
    const float *colour = room->colour[1 - k][c];
    const float self = colour[p] + part * (0.5f * (colour[p - step] + colour[p + step]) - colour[p]);
    const float mean = (sum[FILTER_C + c][p] + self) / weight;
    const float cu = sum[FILTER_CU + c][p] / weight - u * mean, cv = sum[FILTER_CV + c][p] / weight - v * mean;
    const float fitted = mean - across * cu - along * cv;
    room->filtered[k][c][p] = fitted < 0 ? 0 : fitted;
  }
  return (1 - part) * (1 + across * u + along * v) / weight;
}

/* Returns what part of a pixel's variance a screen shows: by how much the halves differ there, and no more than
   the share of channels that are below white. */
static float filter__visible(const filter__room *room, int32_t p) {
  float apart = 0, shown = 0, below = 0;
  for (int c = 0; c < 3; c++) {
    const float x = room->colour[0][c][p], y = room->colour[1][c][p];
    const float d = filter__shown(x) - filter__shown(y);
    apart += (x - y) * (x - y);
    shown += d * d;
    below += x + y < 2 ? 1.0f / 3 : 0;
  }
  return apart * below > shown ? shown / apart : below;
}

/* Estimates what the filter changes and gains at pixel p: as the colours are, and as a screen shows them. Gains on a
   screen must not be chance, so their squares are kept as well; where something is brighter than white these count four
   times, for that is where a screen shows noise and means at once. */
static void filter__judge(filter__room *room, int32_t p) {
  const float variance = 0.5f * room->variance[p], visible = variance * filter__visible(room, p);
  float left = 0, apart = 0, change = 0, bright = 1e-20f; /* left: the squared error of one filtered half */
  float shown_left = 0, shown_apart = 0, shown_change = 0;
  bool white = false;

  for (int k = 0; k < 2; k++) {
    const float own = filter__fit(room, k, p);
    left -= variance * (1 - 2 * own);
    shown_left -= visible * (1 - 2 * own);
    for (int c = 0; c < 3; c++) {
      const float x = room->colour[1 - k][c][p], filtered = room->filtered[k][c][p];
      const float shown = filter__shown(filtered) - filter__shown(x);
      left += 0.5f * (filtered - x) * (filtered - x);
      shown_left += 0.5f * shown * shown;
    }
  }

  for (int c = 0; c < 3; c++) {
    const float one = room->filtered[0][c][p], two = room->filtered[1][c][p], filtered = 0.5f * (one + two);
    const float mean = 0.5f * (room->colour[0][c][p] + room->colour[1][c][p]);
    const float shown_d = filter__shown(one) - filter__shown(two);
    const float shown_moved = filter__shown(filtered) - filter__shown(mean);
    apart += (one - two) * (one - two);
    change += (filtered - mean) * (filtered - mean);
    bright += mean * mean;
    shown_apart += shown_d * shown_d;
    shown_change += shown_moved * shown_moved;
    white = white || filtered > 1 || mean > 1;
  }

  const float shown_gain = (shown_change + visible - (shown_left - 0.25f * shown_apart)) * room->inside[p];
  const float known = 1 - 4 * variance / bright;
  room->gain[p] = (change + variance - (left - 0.25f * apart)) * room->inside[p];
  room->change[p] = change * room->inside[p];
  room->square[p] = room->gain[p] * room->gain[p];
  room->risk[p] = known > 0 ? known * room->gain[p] * room->gain[p] : 0;
  room->shown_gain[p] = shown_gain;
  room->shown_change[p] = shown_change * room->inside[p];
  room->shown_risk[p] = shown_gain * shown_gain * (white ? 4 : 1);
}

/* Returns the part of the way to the filtered picture that has the least error around a pixel: all of it if the gain is
   `most` times its standard error, 0 if it is `least` times that. */
static float filter__part(float gain, float change, float risk, float least, float most) {
  const float part = gain > 0 && change > 0 ? gain / (2 * change) : 0;
  const float sure = (gain / (sqrtf(risk) + 1e-20f) - least) / (most - least);
  return (part < 1 ? part : 1) * (sure < 1 ? sure > 0 ? sure : 0 : 1);
}

/* Goes from the picture to the filtered one by the part that has the least error around p: that on a screen below white,
   that of the colours as they are above; and below as well, where so many pixels gain alike that no glint decides. Pixel p
   and those next to it do not take part in the choice. WHY: what seems to gain by chance would be chosen, and counted as
   gained: the estimated error would be too low, where little error is left by an eighth. */
static void filter__choose(const filter__room *room, int32_t p, float *out, float *error) {
  float gain = 0, change = 0, risk = 0, square = 0;
  float shown_gain = 0, shown_change = 0, shown_risk = 0;
  for (int32_t dy = -FILTER_MIX; dy <= FILTER_MIX; dy++)
    for (int32_t dx = -FILTER_MIX; dx <= FILTER_MIX; dx++) {
      if (dx >= -1 && dx <= 1 && dy >= -1 && dy <= 1) continue;
      const int32_t q = p + dy * room->width + dx;
      gain += room->gain[q];
      change += room->change[q];
      risk += room->risk[q];
      square += room->square[q];
      shown_gain += room->shown_gain[q];
      shown_change += room->shown_change[q];
      shown_risk += room->shown_risk[q];
    }

  const bool noisy = room->pooled[p] > 0;
  const float whole = noisy ? filter__part(gain, change, risk, 2, 5) : 0;
  const float shown = noisy ? filter__part(shown_gain, shown_change, shown_risk, 0.5f, 2) : 0;
  const float broad = noisy ? filter__part(gain, change, square, 5, 8) : 0;
  const float screen = shown > broad ? shown : broad;
  float along = 0, moved = 0; /* the change, times that to the filtered picture, and squared */
  for (int c = 0; c < 3; c++) {
    const float mean = 0.5f * (room->colour[0][c][p] + room->colour[1][c][p]);
    const float filtered = 0.5f * (room->filtered[0][c][p] + room->filtered[1][c][p]);
    const float dim = mean < 1 ? mean : 1, dim_filtered = filtered < 1 ? filtered : 1;
    const float below = screen > 0 ? dim + screen * (dim_filtered - dim) : dim;
    const float above = whole > 0 ? mean + whole * (filtered - mean) : mean;
    if (mean > 1 && filtered < 1) out[c] = above > below ? above : below; /* a glint might be real */
    else if (below < 1) out[c] = below;
    else out[c] = above > 1 ? above : mean < 1 || mean > 1 ? 1 : mean;
    along += (out[c] - mean) * (filtered - mean);
    moved += (out[c] - mean) * (out[c] - mean);
  }
  if (error) *error = 0.5f * room->variance[p] + moved;
  if (error && room->change[p] > 0) *error -= room->gain[p] * along / room->change[p];
}

FILTER_API bool filter_rectangle(
    const filter_picture *from, uint32_t x, uint32_t y, uint32_t w, uint32_t h, float *out, float *error) {
  const int32_t border = FILTER_BORDER, mix = FILTER_MIX, near = border - mix;
  filter__room room;
  memset(&room, 0, sizeof room);
  room.picture = from;
  room.x = (int32_t)x - border, room.y = (int32_t)y - border;
  room.width = (int32_t)w + 2 * border, room.height = (int32_t)h + 2 * border;
  if (!filter__open(&room)) return false;
  filter__load(&room);
  filter__weigh(&room);
  for (int32_t row = near; row < room.height - near; row++)
    for (int32_t p = row * room.width + near; p < (row + 1) * room.width - near; p++) filter__judge(&room, p);
  for (uint32_t j = 0; j < h; j++)
    for (uint32_t i = 0; i < w; i++) {
      const size_t at = (size_t)(y + j) * from->width + x + i;
      const int32_t p = ((int32_t)j + border) * room.width + (int32_t)i + border;
      filter__choose(&room, p, out + 3 * at, error ? error + at : NULL);
    }
  free(room.planes);
  return true;
}

/* Pixels that must carry an estimate: the more, the more estimates are right of those that are believed, and the fewer
   are believed. By the scenes and plans of bench/error, 16 seeds each from 501 and 751: 3 pixels 91% and 87%, 5 pixels 95%
   and 75%, 5.5 pixels 96% and 72%, 6 pixels 96% and 69%. */
#define FILTER_CARRIED 5.5

FILTER_API bool filter_unreliable(const filter_picture *from, const float *error) {
  const size_t n = (size_t)from->width * from->height;
  double noise = 0, noise_squares = 0, left = 0, left_squares = 0;
  for (size_t i = 0; i < n; i++) {
    const double v = (double)from->variance[i], e = (double)error[i];
    if (!(v < 1e30) || !(e < 1e30)) continue; /* not finite */
    noise += v;
    noise_squares += v * v;
    left += e;
    left_squares += e * e;
  }
  if (noise_squares == 0) return false; /* nothing is noisy */
  return noise * noise < 2 * noise_squares || left < 0 || left * left < FILTER_CARRIED * left_squares;
}

FILTER_API size_t filter_tiles(const filter_picture *from) {
  const size_t edge = FILTER_TILE;
  return (from->width + edge - 1) / edge * ((from->height + edge - 1) / edge);
}

FILTER_API void filter_tile(void *job, size_t i) {
  const filter_job *j = (const filter_job *)job;
  const filter_picture *p = j->picture;
  const uint32_t edge = FILTER_TILE, columns = (p->width + edge - 1) / edge;
  const uint32_t x = (uint32_t)i % columns * edge, y = (uint32_t)i / columns * edge;
  const uint32_t w = p->width - x < edge ? p->width - x : edge, h = p->height - y < edge ? p->height - y : edge;
  j->failed[i] = !filter_rectangle(p, x, y, w, h, j->out, j->error);
}

#endif /* FILTER_H */
