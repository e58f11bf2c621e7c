/* An oracle: which triangles a ray crosses and where, in exact arithmetic on the floats it is given, and whether what a ray
   tracer answers is right by the definition below. It takes the types of rays and hits from pktrt.h and no code.

   Crossings. Rays and vertices are taken as real numbers. k is the axis of the direction's largest component, the lowest such
   axis; u and v are the two that follow it in cyclic order. The ray's origin is displaced by e along u and by e^2 along v, for
   an infinitely small e > 0; the displaced line meets no edge, whatever the input, save edges along the ray. A triangle is
   crossed where the displaced line passes through it. So each crossing of a closed surface belongs to one triangle, and a
   triangle that the ray sees without area has none.

   Depth. t is N / D with N = n . (p0 - o), D = n . d, n = (p1 - p0) x (p2 - p0), and nothing is displaced. A float is right for
   it within 0.7 ulp, the ulp being that of the exact value x = N / D: 2^(e - 23) where 2^e <= |x| < 2^(e + 1), and 2^-149 where
   |x| < 2^-126. A power of two thus belongs to the binade above it. Exponents go on beyond those of float: the floats from
   2^128 on stand for infinity, which is no hit. There are one to three right floats to an x, in an unbroken row.

   Answers. Each triangle that a ray crosses has one float t, any of the right ones. Hits are those with tmin < t < tmax, in order
   of t, mesh and triangle. As floats of different triangles do not depend on each other, an answer is right if each triangle, by
   itself, can have a float that fits. */
#ifndef PKTRT_TEST_ORACLE_H
#define PKTRT_TEST_ORACLE_H
#include "meshes.h"

/* --- one triangle: three finite vertices --- */

/* +1 where the ray's line leaves through the triangle (normal . direction > 0), -1 where it enters, 0 where it does not cross. */
int oracle_crosses(const pktrt_ray *, float p[3][3]);
/* The least and the greatest right float for t. Answers false where the ray is in the triangle's plane or parallel to it. */
bool oracle_t_range(const pktrt_ray *, float p[3][3], float *least, float *most);
/* The sign of the exact t, and that of the difference of two triangles' exact t. Both must be crossed. */
int oracle_t_sign(const pktrt_ray *, float p[3][3]);
int oracle_compare(const pktrt_ray *, float p[3][3], float q[3][3]);

/* The axis of the largest component, the lowest such axis. */
int oracle_main_axis(const float direction[3]);
/* t, u and v of a triangle that is crossed, and a normal of any length, each wrong by less than 2^-50 of itself. */
void oracle_solve(const pktrt_ray *, float p[3][3], double tuv[3]);
void oracle_normal(float p[3][3], double normal[3]);

bool oracle_t_is_right(const pktrt_ray *, float p[3][3], float t);
/* u and v within 2^-23 of the exact weights of p1 and p2. */
bool oracle_uv_is_right(const pktrt_ray *, float p[3][3], float u, float v);
/* The direction of a normal of any length within 4 * 2^-24 of that of n: |normal / |normal| - n / |n|| <= 2^-22. */
bool oracle_normal_is_right(float p[3][3], const float normal[3]);

/* --- many --- */

typedef struct oracle_soup {
  float (*p)[3][3];
  uint32_t (*name)[2]; /* mesh and triangle, in rising order */
  size_t n;
  struct oracle_tree *tree; /* of oracle_plant(); NULL: every triangle is looked at */
} oracle_soup;

oracle_soup oracle_soup_of(const world *, float time);           /* all meshes, vertices as ref_vertex() says */
void oracle_soup_move(oracle_soup *, const world *, float time); /* the same at another time; drops the tree */
void oracle_soup_free(oracle_soup *);
void oracle_plant(oracle_soup *); /* makes rays fast. It leaves out what a ray misses for certain, so nothing changes */

typedef struct oracle_crossing {
  uint32_t triangle; /* of the soup */
  int sign;          /* as of oracle_crosses() */
  int ahead;         /* sign of the exact t */
  float least, most; /* right floats for t; infinity is no hit */
  bool near;         /* a later crossing can have the same float or a lesser one */
} oracle_crossing;
typedef struct oracle_list { /* zeroed: empty; may be used again and again */
  oracle_crossing *at;
  size_t n, room;
} oracle_list;

/* All crossings of the ray's line, in order of the exact t, then of the triangle; tmin and tmax are not looked at. The number
   of them. A ray with an origin beyond 2^100, no direction or something that is no number has none. */
size_t oracle_crossings(const oracle_soup *, const pktrt_ray *, oracle_list *);
void oracle_list_free(oracle_list *);
/* The sum of the signs of those ahead: the winding number of closed meshes about the origin, unless that is on them. */
int oracle_winding(const oracle_list *);
/* The least and the greatest number of hits that a right answer can have. */
void oracle_count(const pktrt_ray *, const oracle_list *, size_t *least, size_t *most);

/* Says what is wrong with an answer, or NULL. The answer is n hits in order; where n is less than the capacity that was asked
   for, they are all there are, else the first. The nearest hit: capacity 1, and n 0 for a miss. */
const char *oracle_objection(
    const oracle_soup *, const pktrt_ray *, const oracle_list *, const pktrt_hit *, size_t n, size_t capacity);
bool oracle_accepts(
    const oracle_soup *, const pktrt_ray *, const oracle_list *, const pktrt_hit *, size_t n, size_t capacity);

#endif
