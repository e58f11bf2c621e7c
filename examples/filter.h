/* filter.h - takes noise out of a picture of pktrt.h whose passes are at hand: a filter beside the renderer.

     filter_halves h;                                  in the hook `pass` of pktrt_render_desc, after each round:
     filter_begin(&h, width, height)                     filter_add_pass(&h, desc->pixels)
     ... pktrt_render, with an even number of passes ...
     filter_finish(&h, &picture);                      means of both halves of the passes, and variances
     picture.depth = ..., .normal = ..., .albedo = ... buffers of pktrt_render_desc
     filter_rectangle(&picture, 0, 0, width, height, out, error);    or filter_tile by a parallel_for
     filter_end(&h);

   A pixel becomes a mean over those around it that can share its mean, after Sakai et al. 2024, "A statistical approach
   to Monte Carlo denoising": squared differences of two means over the sum of their variances, as in Welch's t-test,
   averaged over 3 x 3 pixels, decide about membership; normals, depths and albedos are range weights beside it. (Colours
   are not divided by albedos: where gloss adds to a small albedo that made glints of other pixels.)

   Passes go to two halves by turns. Each half's means weigh the other half's, so a bright sample by chance is neither kept
   nor cast out for being bright, but spread. Variances are those of all passes: a half whose passes all miss a rare light
   takes its mean for certain and finds no pixel like it, and what the other half meets would stay. And so the error
   can be estimated. With weights that sum to 1, that of the pixel itself being w, |F - x|^2 - V (1 - 2 w) has the mean
   |F - m|^2, where x is a pixel's mean, V its squared error, F the filtered mean and m the truth; of the mean of
   two, |(F + G)/2 - m|^2 = (|F - m|^2 + |G - m|^2) / 2 - |F - G|^2 / 4. Summed over 11 x 11 pixels this tells what part
   of the way from the picture to the filtered one has the least error: that part is gone. Where filtering does harm, it
   is 0. So it is where the gain is below twice its own standard error, and it is less up to six times; pixels that are not
   known well enough to lose something do not count for that. WHY: with many samples a few pixels have most of the error,
   and the best part for them is told by chance.

   Convergence: as passes grow, variances shrink as one over their number, and the test tells apart any two pixels whose
   true means differ. What then still is averaged has the same mean.
   Bias: at a given number of passes true differences below the noise are blurred, by less than about three standard errors
   of a difference of two pixels, within 10 pixels. The estimated error contains it. Sums are not kept: pictures get darker
   where bright samples are rare, the pool hall by 4% at 8 samples and 0.6% at 64. The estimate misses part of that, for
   variances know nothing of lights that no sample has met.

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
} filter_picture;

/* Filters the pixels [x, x+w) x [y, y+h) into their place in `out`, a whole picture. `error`, if not NULL, gets the
   estimated squared error of each of them, summed over channels: some are below 0 by chance, means over many are not.
   False: no memory. */
FILTER_API bool filter_rectangle(
    const filter_picture *from, uint32_t x, uint32_t y, uint32_t w, uint32_t h, float *out, float *error);

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
} filter_halves;

FILTER_API bool filter_begin(filter_halves *halves, uint32_t width, uint32_t height); /* false: no memory */
FILTER_API void filter_add_pass(filter_halves *halves, const float *pixels); /* pixels: the mean of all passes so far */
FILTER_API bool filter_finish(filter_halves *halves, filter_picture *to);    /* false: fewer than two passes */
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
    ok = ok && halves->mean[k] && halves->spread[k] && halves->half[k];
  }
  if (!ok) filter_end(halves);
  return ok;
}

FILTER_API void filter_end(filter_halves *halves) {
  free(halves->total), free(halves->variance);
  for (int k = 0; k < 2; k++) free(halves->mean[k]), free(halves->spread[k]), free(halves->half[k]);
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
  }
  to->variance = halves->variance;
  return true;
}

/* >>rooms ---------------------------------------------------------------------------------------------------------- */

/* How far weights, comparisons, pooled variances and the choice between both pictures look. */
enum { FILTER_DENSE = 3 }; /* farther away every other pixel is enough */
enum { FILTER_REACH = 10, FILTER_PATCH = 1, FILTER_POOL = 3, FILTER_MIX = 5 };
enum { FILTER_BORDER = FILTER_REACH + FILTER_PATCH + FILTER_POOL + FILTER_MIX, FILTER_FEATURES = 7 };

/* A rectangle with its border. Pixels beyond the picture repeat its edge, for comparisons; they weigh nothing. */
typedef struct filter__room {
  const filter_picture *picture;
  int32_t x, y, width, height; /* where it lies in the picture, and its size */
  float *planes;               /* of all that follows */
  float *colour[2][3];         /* of the halves */
  float *variance, *pooled;    /* as they are, and pooled */
  float *feature[FILTER_FEATURES], *inside;
  float *share, *distance[2], *rows[2]; /* of one offset */
  float *sum[2][3], *weight[2];         /* of weights of one half, colours of the other */
  float *gain, *change, *risk; /* what filtering takes from the squared error; the squared change; see filter__judge */
} filter__room;

/* Gives all planes their places in one block of memory. */
static bool filter__open(filter__room *room) {
  enum { PLANES = 6 + 2 + FILTER_FEATURES + 1 + 5 + 8 + 3 };
  const size_t n = (size_t)room->width * (size_t)room->height;
  float **const last[] = {
      &room->variance, &room->pooled, &room->inside, &room->share, &room->gain, &room->change, &room->risk};
  float *next = (float *)calloc(n * PLANES, sizeof(float));
  room->planes = next;
  if (!next) return false;
  for (int k = 0; k < 2; k++) {
    for (int c = 0; c < 3; c++) {
      room->colour[k][c] = next, next += n;
      room->sum[k][c] = next, next += n;
    }
    room->distance[k] = next, next += n;
    room->rows[k] = next, next += n;
    room->weight[k] = next, next += n;
  }
  for (int f = 0; f < FILTER_FEATURES; f++) room->feature[f] = next, next += n;
  for (size_t i = 0; i < sizeof last / sizeof *last; i++) *last[i] = next, next += n;
  return true;
}

static int32_t filter__clamp(int32_t at, uint32_t size) {
  return at < 0 ? 0 : at >= (int32_t)size ? (int32_t)size - 1 : at;
}

/* Fills in one pixel: features are divided by how much they may differ, and depths compared in filter__share. */
static void filter__load_pixel(filter__room *room, size_t to, size_t from) {
  const filter_picture *p = room->picture;
  const float depth = p->depth[from], normals = 1.58113883f, albedos = 3.16227766f; /* 1/sqrt(0.4), 1/sqrt(0.1) */
  for (size_t c = 0; c < 3; c++) {
    for (int k = 0; k < 2; k++) room->colour[k][c][to] = p->half[k][3 * from + c];
    room->feature[1 + c][to] = p->normal[3 * from + c] * normals;
    room->feature[4 + c][to] = p->albedo[3 * from + c] * albedos;
  }
  room->feature[0][to] = depth < 1e15f ? depth : 0;
  room->variance[to] = p->variance[from];
}

/* Half of a pixel's own variance, which is coarse, and half of the mean of those around it. */
static void filter__pool(filter__room *room) {
  const int32_t w = room->width, h = room->height, reach = FILTER_POOL;
  for (int32_t y = reach; y < h - reach; y++)
    for (int32_t x = reach; x < w - reach; x++) {
      float sum = 0;
      for (int32_t dy = -reach; dy <= reach; dy++)
        for (int32_t dx = -reach; dx <= reach; dx++) sum += room->variance[(y + dy) * w + x + dx];
      room->pooled[y * w + x] =
          0.5f * room->variance[y * w + x] + 0.5f * sum / (float)((2 * reach + 1) * (2 * reach + 1));
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
  filter__pool(room);
}

/* >>weights -------------------------------------------------------------------------------------------------------- */

/* Computes what features let pixel q weigh at p: 1 if they agree, 0 from 8 squared units on. */
static float filter__share(const filter__room *room, int32_t p, int32_t q) {
  const float *depth = room->feature[0], zp = depth[p], zq = depth[q], nearer = zp < zq ? zp : zq;
  float apart = (zp - zq) * (zp - zq) / (0.04f * nearer * nearer + 1e-20f); /* a fifth of the depth is a unit */
  for (int f = 1; f < FILTER_FEATURES; f++) {
    const float d = room->feature[f][p] - room->feature[f][q];
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
  for (int32_t y = first; y < room->height - first; y++) {
    for (int32_t p = y * w + first; p < (y + 1) * w - first; p++) {
      room->share[p] = filter__share(room, p, p + offset);
      for (int k = 0; k < 2; k++) room->distance[k][p] = filter__distance(room, k, p, p + offset);
    }
    for (int k = 0; k < 2; k++)
      for (int32_t p = y * w + first + patch; p < (y + 1) * w - first - patch; p++)
        room->rows[k][p] = room->distance[k][p - 1] + room->distance[k][p] + room->distance[k][p + 1];
  }
}

/* Adds up what pixels at an offset weigh by each half's test, and the colours of the other half with these weights. */
static void filter__accumulate(filter__room *room, int32_t offset) {
  const int32_t w = room->width, first = FILTER_REACH + FILTER_POOL + FILTER_PATCH;
  for (int k = 0; k < 2; k++) {
    const float *rows = room->rows[k];
    for (int32_t y = first; y < room->height - first; y++)
      for (int32_t p = y * w + first; p < (y + 1) * w - first; p++) {
        const float rest = 1 - (rows[p - w] + rows[p] + rows[p + w]) * (1.0f / 54); /* 9 pixels, t^2 up to 6 */
        const float weight = rest > 0 ? rest * rest * room->share[p] : 0;
        room->weight[k][p] += weight;
        for (int c = 0; c < 3; c++) room->sum[k][c][p] += weight > 0 ? weight * room->colour[1 - k][c][p + offset] : 0;
      }
  }
}

static void filter__weigh(filter__room *room) {
  for (int32_t dy = -FILTER_REACH; dy <= FILTER_REACH; dy++)
    for (int32_t dx = -FILTER_REACH; dx <= FILTER_REACH; dx++) {
      const int32_t offset = dy * room->width + dx;
      if (!offset || (dx * dx + dy * dy > FILTER_DENSE * FILTER_DENSE && (dx + dy) % 2)) continue;
      filter__compare(room, offset);
      filter__accumulate(room, offset);
    }
}

/* >>choice --------------------------------------------------------------------------------------------------------- */

/* Finishes the filtered colours of pixel p, the pixel itself weighing 1, and estimates what they change and gain. A pixel
   whose mean is known, to a half of it or better, is put at risk: its gain must not be chance. A rare bright sample is as
   large as its own error. */
static void filter__judge(filter__room *room, int32_t p) {
  const float variance = 0.5f * room->variance[p];
  float squared = 0, apart = 0, change = 0, bright = 1e-20f;
  for (int k = 0; k < 2; k++) {
    const float weight = room->weight[k][p] + 1;
    squared -= variance * (1 - 2 / weight);
    for (int c = 0; c < 3; c++) {
      const float x = room->colour[1 - k][c][p];
      room->sum[k][c][p] = (room->sum[k][c][p] + room->colour[1 - k][c][p]) / weight;
      squared += 0.5f * (room->sum[k][c][p] - x) * (room->sum[k][c][p] - x);
    }
  }
  for (int c = 0; c < 3; c++) {
    const float d = room->sum[0][c][p] - room->sum[1][c][p];
    const float mean = 0.5f * (room->colour[0][c][p] + room->colour[1][c][p]);
    const float moved = 0.5f * (room->sum[0][c][p] + room->sum[1][c][p]) - mean;
    apart += d * d, change += moved * moved, bright += mean * mean;
  }
  const float known = 1 - 4 * variance / bright;
  room->change[p] = change * room->inside[p];
  room->gain[p] = (change + variance - (squared - 0.25f * apart)) * room->inside[p];
  room->risk[p] = known > 0 ? known * room->gain[p] * room->gain[p] : 0;
}

/* Goes from the picture to the filtered one by the part that has the least error around p. All of that part if
   the gain is six times its standard error by known pixels, nothing if it is twice. */
static void filter__choose(const filter__room *room, int32_t p, float *out, float *error) {
  float gain = 0, change = 0, risk = 0;
  for (int32_t dy = -FILTER_MIX; dy <= FILTER_MIX; dy++)
    for (int32_t dx = -FILTER_MIX; dx <= FILTER_MIX; dx++) {
      const int32_t q = p + dy * room->width + dx;
      gain += room->gain[q], change += room->change[q], risk += room->risk[q];
    }
  const float chance = sqrtf(risk), sure = 0.25f * gain / (chance + 1e-20f) - 0.5f; /* 0 to 1 */
  float part = room->pooled[p] > 0 && gain > 0 && change > 0 ? gain / (2 * change) : 0;
  part = (part < 1 ? part : 1) * (sure < 1 ? sure > 0 ? sure : 0 : 1);
  for (int c = 0; c < 3; c++) {
    const float mean = 0.5f * (room->colour[0][c][p] + room->colour[1][c][p]);
    const float filtered = 0.5f * (room->sum[0][c][p] + room->sum[1][c][p]);
    out[c] = part > 0 ? mean + part * (filtered - mean) : mean;
  }
  if (error) *error = 0.5f * room->variance[p] - part * room->gain[p] + part * part * room->change[p];
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
