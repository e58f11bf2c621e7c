/* Checks exercise 5: the test never drops a box that a ray of the packet hits, and drops most of the
   others. As a control it is run with bounds that are too narrow, and must then be caught. */
#define PKTRT_IMPLEMENTATION
#include "course.h"

bool intervals_miss(const course_bounds *p, const float lo[3], const float hi[3]);

enum { RAYS = 8, BOXES = 50, PACKETS = 20000 };

static uint32_t state = 5;
static float between(float a, float b) { return a + (b - a) * course_random(&state); }

/* Rays from one point or from near each other, in more or less one direction; some of them along an axis. */
static void make_packet(course_ray *rays, uint32_t kind) {
  vec from, to;
  const float apart = kind & 1 ? 0.5f : 0, spread = kind & 2 ? 0.1f : 0.8f;
  for (int a = 0; a < 3; a++) {
    from.at[a] = between(-5, 5), to.at[a] = between(-1, 1);
    if (kind & 4 && (int)(kind / 8 % 3) != a) to.at[a] = 0;
  }
  for (uint32_t r = 0; r < RAYS; r++) {
    for (int a = 0; a < 3; a++) {
      rays[r].origin.at[a] = from.at[a] + between(0, apart);
      rays[r].direction.at[a] = to.at[a] == 0 && r % 2 ? 0 : to.at[a] + between(-spread, spread) / 2;
    }
    rays[r].tmin = 0, rays[r].tmax = kind & 32 ? between(1, 20) : INFINITY;
  }
}

/* A box anywhere; or one around a point of a ray, which then is in a corner, an edge or a face as likely as not. */
static void make_box(const course_ray *rays, uint32_t kind, float lo[3], float hi[3]) {
  const course_ray *ray = &rays[kind / 2 % RAYS];
  const float t = between(0, fminf(ray->tmax, 8)), size = between(0, 2);
  for (int a = 0; a < 3; a++) {
    const float p = kind & 1 ? ray->origin.at[a] + t * ray->direction.at[a] : between(-8, 8);
    const uint32_t side = (uint32_t)between(0, 4);
    lo[a] = side & 1 ? p : p - between(0, size), hi[a] = side & 2 ? p : p + between(0, size);
  }
}

/* Whether a ray hits a box, in double, where the rounding of floats does not matter. */
static bool hits(const course_ray *ray, const float lo[3], const float hi[3]) {
  double enter = (double)ray->tmin, leave = (double)ray->tmax;
  for (int a = 0; a < 3; a++) {
    const double o = (double)ray->origin.at[a], d = (double)ray->direction.at[a];
    const double l = (double)lo[a] - o, h = (double)hi[a] - o;
    if (d == 0 && (l > 0 || h < 0)) return false;
    if (d == 0) continue;
    enter = fmax(enter, fmin(l / d, h / d)), leave = fmin(leave, fmax(l / d, h / d));
  }
  return enter <= leave;
}

/* Bounds that forget rays: intervals of origins and directions are narrowed by a fifth on either side. */
static course_bounds shrink(course_bounds b) {
  for (int a = 0; a < 3; a++) {
    const float o = (b.o_hi[a] - b.o_lo[a]) / 5, r = (b.r_hi[a] - b.r_lo[a]) / 5;
    b.o_lo[a] += o, b.o_hi[a] -= o, b.r_lo[a] += r, b.r_hi[a] -= r;
  }
  return b;
}

static void say(const char *what, const float lo[3], const float hi[3]) {
  printf("  %s (%.9g, %.9g, %.9g) to (%.9g, %.9g, %.9g)\n", what, (double)lo[0], (double)lo[1], (double)lo[2],
      (double)hi[0], (double)hi[1], (double)hi[2]);
}

/* All digits, so that the ray can be had from them. */
static void say_ray(uint32_t number, const course_ray *ray) {
  const float *o = ray->origin.at, *d = ray->direction.at;
  printf("ray %u from (%.9g, %.9g, %.9g) along (%.9g, %.9g, %.9g), t from %.9g to %.9g\n", (unsigned)number,
      (double)o[0], (double)o[1], (double)o[2], (double)d[0], (double)d[1], (double)d[2], (double)ray->tmin,
      (double)ray->tmax);
}

int main(void) {
  const float share = 0.52f; /* the test of the text finds half a percent more */
  pktrt_node world;          /* all that course_slabs_make asks for: how far away things can be */
  uint64_t boxes = 0, missed = 0, dropped = 0, wrong = 0, caught = 0;
  memset(&world, 0, sizeof world);
  for (int k = 1; k < 8; k++) world.child[k] = PKTRT_NONE;
  for (int a = 0; a < 3; a++) world.lo[0][a] = -32, world.hi[0][a] = 32;
  for (uint32_t i = 0; i < PACKETS; i++) {
    course_ray rays[RAYS];
    course_slabs slabs[RAYS];
    make_packet(rays, i);
    for (uint32_t r = 0; r < RAYS; r++) slabs[r] = course_slabs_make(&world, rays[r]);
    const course_bounds all = course_bounds_make(rays, slabs, RAYS), narrow = shrink(all);
    for (uint32_t j = 0; j < BOXES; j++, boxes++) {
      float lo[3], hi[3];
      uint32_t r = 0;
      make_box(rays, j, lo, hi);
      while (r < RAYS && !hits(&rays[r], lo, hi)) r++;
      const bool drop = intervals_miss(&all, lo, hi);
      missed += r == RAYS, dropped += r == RAYS && drop;
      caught += r < RAYS && intervals_miss(&narrow, lo, hi);
      if (r == RAYS || !drop || wrong++) continue;
      printf("packet %u, ray %u hits a box that is dropped\n", (unsigned)i, (unsigned)r);
      say_ray(r, &rays[r]);
      say("box", lo, hi), say("origins", all.o_lo, all.o_hi), say("reciprocal directions", all.r_lo, all.r_hi);
      printf("  first %.9g, last %.9g, pad %.9g\n", (double)all.first, (double)all.last, (double)all.pad);
    }
  }

  const double found = (double)dropped / (double)missed;
  printf("%u boxes and packets: %u boxes are dropped that a ray hits\n", (unsigned)boxes, (unsigned)wrong);
  printf("of %u boxes that all rays miss %.1f%% are dropped; at least %.1f%% should be\n", (unsigned)missed,
      100 * found, 100 * (double)share);
  printf("control: with bounds that are too narrow %u boxes are dropped that a ray hits\n", (unsigned)caught);
  course_figure("pairs", "%u", (unsigned)boxes);
  course_figure("share.found", "%.1f", 100 * found);
  course_figure("share.least", "%.0f", 100 * (double)share);
  return course_result(5, wrong                   ? "boxes are dropped that a ray hits"
                          : found < (double)share ? "too few boxes are dropped: are first, last and all axes used?"
                          : !caught               ? "the test takes no notice of its bounds"
                                                  : NULL);
}
