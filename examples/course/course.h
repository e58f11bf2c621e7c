/* course.h - what the chapters share: vectors, rays, pictures, a scene, and the library's answers to compare with.

     course_scene scene = course_scene_make();               some three thousand triangles, as positions and corners
     course_ray ray = course_camera_ray(x, y, 256, 192);     the camera of chapter 1, for the chapters after it
     pktrt_scene *library = course_library(&scene);          the same triangles in the library
     course_hit theirs = course_library_hit(library, ray);
     course_same_hit(&scene, ray, &mine, &theirs, &tally);   says what differs, but for edges and ties

   Programs and checks define PKTRT_IMPLEMENTATION before they include this file; exercises do not. So a file can be
   compiled by hand:

     cc -O2 examples/course/01_ray.c -o ray -lm
     cc -O2 -Iexamples/course examples/course/01_check.c mine_01.c -o check -lm

   Contents: vectors, rays and boxes; random, scene, chapter 1, sorting, pictures, library, comparing, nodes and events,
   boxes. */
#ifndef COURSE_H
#define COURSE_H

#include "../common.h"
#include "../../pktrt.h"
#include <float.h>
#include <signal.h>

#define COURSE_NONE PKTRT_NONE /* no triangle */
#define COURSE_EDGE 1e-4       /* nearer to an edge than this, in barycentric coordinates, answers may differ */

/* >>vectors -------------------------------------------------------------------------------------------------------- */

typedef struct vec { /* a point or a direction; an array, since boxes are walked axis by axis */
  float at[3];
} vec;

EX_UNUSED static vec vec_make(float x, float y, float z) {
  vec v = {{x, y, z}};
  return v;
}
EX_UNUSED static vec vec_add(vec a, vec b) { return vec_make(a.at[0] + b.at[0], a.at[1] + b.at[1], a.at[2] + b.at[2]); }
EX_UNUSED static vec vec_sub(vec a, vec b) { return vec_make(a.at[0] - b.at[0], a.at[1] - b.at[1], a.at[2] - b.at[2]); }
EX_UNUSED static vec vec_scale(vec a, float s) { return vec_make(a.at[0] * s, a.at[1] * s, a.at[2] * s); }
EX_UNUSED static float vec_dot(vec a, vec b) { return a.at[0] * b.at[0] + a.at[1] * b.at[1] + a.at[2] * b.at[2]; }
EX_UNUSED static vec vec_cross(vec a, vec b) {
  return vec_make(a.at[1] * b.at[2] - a.at[2] * b.at[1], a.at[2] * b.at[0] - a.at[0] * b.at[2],
      a.at[0] * b.at[1] - a.at[1] * b.at[0]);
}
EX_UNUSED static vec vec_unit(vec a) { return vec_scale(a, 1 / sqrtf(vec_dot(a, a))); }

typedef struct course_ray { /* the points origin + t direction with tmin < t < tmax */
  vec origin, direction;    /* direction need not have unit length */
  float tmin, tmax;
} course_ray;

typedef struct course_hit {
  float t, u, v;     /* the point is (1-u-v) p0 + u p1 + v p2; of a miss, t is the ray's tmax */
  uint32_t triangle; /* COURSE_NONE: a miss */
} course_hit;

typedef struct course_box { /* the points between two corners; lo > hi: none */
  vec lo, hi;
} course_box;

/* Around a box and two points more, in any order. Starting from course_box_empty(), boxes grow around whatever comes. */
EX_UNUSED static course_box course_box_grow(course_box b, vec p, vec q) {
  for (int a = 0; a < 3; a++) {
    b.lo.at[a] = fminf(b.lo.at[a], fminf(p.at[a], q.at[a]));
    b.hi.at[a] = fmaxf(b.hi.at[a], fmaxf(p.at[a], q.at[a]));
  }
  return b;
}
EX_UNUSED static float course_box_area(course_box b) { /* half of its surface; of no empty box */
  const vec d = vec_sub(b.hi, b.lo);
  return d.at[0] * d.at[1] + d.at[1] * d.at[2] + d.at[2] * d.at[0];
}
EX_UNUSED static course_box course_box_empty(void) {
  const course_box b = {{{INFINITY, INFINITY, INFINITY}}, {{-INFINITY, -INFINITY, -INFINITY}}};
  return b;
}

/* >>random --------------------------------------------------------------------------------------------------------- */

/* The next of a sequence of numbers spread evenly over [0,1): the same on every machine. A counter is multiplied and
   folded until each of its bits has touched all below and above. */
EX_UNUSED static float course_random(uint32_t *state) {
  uint32_t x = (*state += 0x9E3779B9u);
  x = (x ^ x >> 16) * 0x21F0AAADu;
  x = (x ^ x >> 15) * 0x735A2D97u;
  return (float)((x ^ x >> 15) >> 8) / 16777216.0f;
}

/* >>scene ---------------------------------------------------------------------------------------------------------- */

typedef struct course_scene {
  vec *position;         /* of each vertex */
  uint32_t (*corner)[3]; /* of each triangle: three vertices, counter-clockwise from outside */
  uint32_t vertices, triangles;
} course_scene;

/* Zeroed memory, or the end of the program. Little of it is freed: programs of the course are short. */
EX_UNUSED static void *course_memory(size_t count, size_t size) {
  void *p = calloc(count ? count : 1, size);
  if (!p) ex_fail("out of memory"), exit(1);
  return p;
}

EX_UNUSED static course_box course_box_of(const course_scene *s, uint32_t triangle) {
  const uint32_t *c = s->corner[triangle];
  const course_box b = course_box_grow(course_box_empty(), s->position[c[0]], s->position[c[1]]);
  return course_box_grow(b, s->position[c[2]], s->position[c[2]]);
}

#define COURSE_TURN 6.28318530717958648 /* radians of a full turn */

/* Surfaces over the unit square. All are curved or turned, so that no triangle lies in a face of its box and no two
   rays meet things at the same t: what chapters compare should not hang on ties. */
static void course_ground(double u, double v, double p[3]) {
  const double x = 14 * u - 7, z = 14 * v - 7;
  p[0] = 0.9 * x - 0.4 * z, p[2] = 0.4 * x + 0.9 * z;
  p[1] = 0.12 * sin(0.9 * p[0] + 0.4) * cos(0.7 * p[2]) + 0.02 * x;
}
static void course_ball(double u, double v, double p[3]) {
  const double a = COURSE_TURN * u, b = COURSE_TURN / 2 * v, r = 0.85 + 0.07 * sin(5 * b) * sin(4 * a + 1);
  p[0] = 1.2 + r * sin(b) * sin(a), p[1] = 1.0 + r * cos(b) + 0.2 * r * sin(b) * sin(a),
  p[2] = 1.6 + r * sin(b) * cos(a);
}
static void course_ring(double u, double v, double p[3]) {
  const double a = COURSE_TURN * u, b = COURSE_TURN * v, r = 1.1 + 0.32 * cos(b), y = 0.32 * sin(b);
  p[0] = 1.5 + r * cos(a) * 0.8 + y * 0.6, p[1] = 1.4 - r * cos(a) * 0.6 + y * 0.8, p[2] = -1.3 + r * sin(a);
}
/* A tube along a trefoil knot c(a), whose tangent d is never upright: so d x up is a frame that closes. */
static void course_knot(double u, double v, double p[3]) {
  const double a = COURSE_TURN * u, b = -COURSE_TURN * v, r = 0.22;
  const double c[3] = {sin(a) + 2 * sin(2 * a), -sin(3 * a), cos(a) - 2 * cos(2 * a)};
  const double d[3] = {cos(a) + 4 * cos(2 * a), -3 * cos(3 * a), -sin(a) + 4 * sin(2 * a)};
  const double side = sqrt(d[0] * d[0] + d[2] * d[2]), all = sqrt(side * side + d[1] * d[1]);
  const double n[3] = {-d[2] / side, 0, d[0] / side};
  const double m[3] = {-d[1] * d[0] / (side * all), side / all, -d[1] * d[2] / (side * all)};
  double q[3];
  for (int k = 0; k < 3; k++) q[k] = 0.62 * c[k] + r * (cos(b) * n[k] + sin(b) * m[k]);
  p[0] = -1.2 + q[0], p[1] = 1.8 + 0.6 * q[1] + 0.8 * q[2], p[2] = -0.2 + 0.6 * q[2] - 0.8 * q[1];
}

/* Adds a surface as a grid of nu by nv squares, two triangles each. Positions are snapped to 2^-16, far coarser than
   libraries' sines differ, so the scene has the same bits everywhere; triangles whose corners meet, at poles, are left
   out. */
static void course_add(course_scene *s, void (*surface)(double, double, double *), uint32_t nu, uint32_t nv) {
  const uint32_t first = s->vertices, row = nu + 1;
  for (uint32_t i = 0; i < row * (nv + 1); i++) {
    double p[3];
    surface((double)(i % row) / nu, (double)(i / row) / nv, p);
    for (int k = 0; k < 3; k++) s->position[s->vertices].at[k] = (float)(floor(p[k] * 65536 + 0.5137) / 65536);
    s->vertices++;
  }
  for (uint32_t i = 0; i < 2 * nu * nv; i++) {
    const uint32_t a = first + i / 2 / nu * row + i / 2 % nu, b = a + row,
                   corner[2][3] = {{a, b, b + 1}, {a, b + 1, a + 1}};
    const vec *p[3];
    for (int k = 0; k < 3; k++) s->corner[s->triangles][k] = corner[i % 2][k], p[k] = s->position + corner[i % 2][k];
    if (memcmp(p[0], p[1], sizeof *p[0]) && memcmp(p[1], p[2], sizeof *p[0]) && memcmp(p[2], p[0], sizeof *p[0]))
      s->triangles++;
  }
}

EX_UNUSED static course_scene course_scene_empty(void) {
  enum { ROOM = 4096 };
  course_scene s = {NULL, NULL, 0, 0};
  s.position = (vec *)course_memory(ROOM, sizeof *s.position);
  s.corner = (uint32_t(*)[3])course_memory(ROOM, sizeof *s.corner);
  return s;
}

enum { COURSE_GROUND = 2 * 16 * 16 }; /* the first triangles are the ground's */

/* A knot, a ring and a ball above uneven ground. */
EX_UNUSED static course_scene course_scene_make(void) {
  course_scene s = course_scene_empty();
  course_add(&s, course_ground, 16, 16);
  course_add(&s, course_knot, 96, 8);
  course_add(&s, course_ring, 28, 14);
  course_add(&s, course_ball, 24, 14);
  return s;
}

/* >>chapter 1 ------------------------------------------------------------------------------------------------------ */

/* What chapter 1 makes, for the chapters after it. */

/* The ray through a place of the picture, in pixels from its upper left corner. */
EX_UNUSED static course_ray course_camera_ray(float x, float y, uint32_t width, uint32_t height) {
  const vec eye = {{2.7f, 4.1f, 7.3f}}, target = {{0.1f, 1.2f, -0.1f}}, up = {{0, 1, 0}};
  const vec forward = vec_unit(vec_sub(target, eye)), right = vec_unit(vec_cross(forward, up)),
            above = vec_cross(right, forward);
  const float half = 0.36f, h = (float)height; /* the tangent of half the angle of view */
  const float dx = half * (2 * x - (float)width) / h, dy = half * (h - 2 * y) / h;
  course_ray ray = {eye, vec_add(forward, vec_add(vec_scale(right, dx), vec_scale(above, dy))), 0, INFINITY};
  return ray;
}

/* Whether the ray meets a triangle nearer than *hit, which it then becomes. */
EX_UNUSED static bool course_meet(
    const course_scene *scene, const course_ray *ray, uint32_t triangle, course_hit *hit) {
  const uint32_t *c = scene->corner[triangle];
  const vec p0 = scene->position[c[0]], e = vec_sub(scene->position[c[1]], p0), f = vec_sub(scene->position[c[2]], p0);
  const vec s = vec_sub(ray->origin, p0), p = vec_cross(ray->direction, f), q = vec_cross(s, e);
  const float det = vec_dot(e, p);
  if (det == 0) return false;
  const float u = vec_dot(s, p) / det, v = vec_dot(ray->direction, q) / det, t = vec_dot(f, q) / det;
  if (!(u >= 0 && v >= 0 && u + v <= 1 && ray->tmin < t && t < hit->t)) return false;
  hit->t = t, hit->u = u, hit->v = v, hit->triangle = triangle;
  return true;
}

/* >>sorting -------------------------------------------------------------------------------------------------------- */

typedef struct course_item {
  float centre;
  uint32_t index;
} course_item;

static int course_compare(const void *a, const void *b) {
  const course_item *x = (const course_item *)a, *y = (const course_item *)b;
  if (x->centre != y->centre) return x->centre < y->centre ? -1 : 1;
  return x->index < y->index ? -1 : 1; /* qsort need not be stable, and shall do the same everywhere */
}

/* Sorts numbers of boxes by where the boxes' centres are along an axis. */
EX_UNUSED static void course_sort(const course_box *box, int axis, uint32_t *order, uint32_t count) {
  course_item *item = (course_item *)course_memory(count, sizeof *item);
  for (uint32_t i = 0; i < count; i++) {
    item[i].centre = (box[order[i]].lo.at[axis] + box[order[i]].hi.at[axis]) / 2;
    item[i].index = order[i];
  }
  qsort(item, count, sizeof *item, course_compare);
  for (uint32_t i = 0; i < count; i++) order[i] = item[i].index;
  free(item);
}

/* >>pictures ------------------------------------------------------------------------------------------------------- */

typedef struct course_picture {
  uint32_t width, height;
  vec *pixel; /* linear RGB, row 0 at the top */
} course_picture;

EX_UNUSED static course_picture course_picture_make(uint32_t width, uint32_t height) {
  course_picture p = {width, height, NULL};
  p.pixel = (vec *)course_memory((size_t)width * height, sizeof *p.pixel);
  return p;
}

/* Prints a figure that the text names in a comment behind it, as in 22353<!-- dropped -->; see figures.awk. `name` has no
   blank, and neither has what the format makes. */
EX_UNUSED static void course_figure(const char *name, const char *format, ...) {
  va_list values;
  va_start(values, format);
  printf("= %s ", name);
  vprintf(format, values);
  printf("\n");
  va_end(values);
}

/* The folder for pictures, made if need be. */
EX_UNUSED static void course_make_folder(void) {
  ex_make_folder("out");
  ex_make_folder("out/course");
}

/* Writes the picture as a PNG; the program ends if it cannot be written. */
EX_UNUSED static void course_picture_write(const course_picture *p, const char *path) {
  course_make_folder();
  if (!ex_write_picture(path, p->pixel[0].at, p->width, p->height)) exit(1);
}

/* Writes the picture twice as wide and high: each pixel becomes four equal ones. */
EX_UNUSED static void course_picture_write_double(const course_picture *p, const char *path) {
  course_picture large = course_picture_make(2 * p->width, 2 * p->height);

  for (uint32_t y = 0; y < large.height; y++)
    for (uint32_t x = 0; x < large.width; x++)
      large.pixel[(size_t)y * large.width + x] = p->pixel[(size_t)(y / 2) * p->width + x / 2];
  course_picture_write(&large, path);
  free(large.pixel);
}

/* The colour of a value in [0,1]: black, blue, orange, white. For heat maps. */
EX_UNUSED static vec course_heat(float x) {
  static const vec stop[4] = {{{0, 0, 0.02f}}, {{0.02f, 0.12f, 0.5f}}, {{1, 0.35f, 0.02f}}, {{1, 1, 0.85f}}};
  const float at = x < 0 ? 0 : x > 1 ? 3 : 3 * x;
  const int i = at < 1 ? 0 : at < 2 ? 1 : 2;
  return vec_add(vec_scale(stop[i], (float)(i + 1) - at), vec_scale(stop[i + 1], at - (float)i));
}

/* Prints the mean of what rays cost, pixel by pixel, by the triangles that they hit; and of those that pass a knot, a
   ring or a ball: one of three pixels to the left or right hits one. */
EX_UNUSED static void course_print_by_hit(const uint32_t *cost, const uint32_t *triangle, uint32_t pixels) {
  double sum[4] = {0}, count[4] = {0};
  uint32_t most = 0;
  for (uint32_t i = 0; i < pixels; i++) {
    const int what = triangle[i] == COURSE_NONE ? 0 : triangle[i] < COURSE_GROUND ? 1 : 2;
    bool near = false;
    for (uint32_t j = i < 3 ? 0 : i - 3; j <= i + 3 && j < pixels; j++)
      near |= triangle[j] != COURSE_NONE && triangle[j] >= COURSE_GROUND;
    sum[what] += cost[i], count[what]++;
    if (what < 2 && near) sum[3] += cost[i], count[3]++;
    if (cost[i] > most) most = cost[i];
  }
  printf(
      "  where nothing is hit %.1f, the ground %.1f, a thing above it %.1f; within 3 pixels of one %.1f; at most %u\n",
      sum[0] / count[0], sum[1] / count[1], sum[2] / count[2], sum[3] / count[3], (unsigned)most);
  course_figure("by_hit.nothing", "%.1f", sum[0] / count[0]);
  course_figure("by_hit.ground", "%.1f", sum[1] / count[1]);
  course_figure("by_hit.thing", "%.1f", sum[2] / count[2]);
  course_figure("by_hit.near", "%.1f", sum[3] / count[3]);
  course_figure("by_hit.most", "%u", (unsigned)most);
}

/* >>library -------------------------------------------------------------------------------------------------------- */

/* The scene in the library, as one mesh: its triangles have the same numbers. The caller destroys it. */
EX_UNUSED static pktrt_scene *course_library(const course_scene *s) {
  pktrt_scene *library = pktrt_scene_create(NULL);
  pktrt_mesh_desc mesh;
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = s->position[0].at, mesh.vertex_count = s->vertices;
  mesh.indices = s->corner[0], mesh.triangle_count = s->triangles;
  if (!library || pktrt_add_mesh(library, &mesh, NULL) || pktrt_commit(library))
    ex_fail("%s", pktrt_last_error(library)), exit(1);
  return library;
}

EX_UNUSED static pktrt_ray course_library_ray(course_ray ray) {
  pktrt_ray r = pktrt_make_ray(ray.origin.at, ray.direction.at);
  r.tmin = ray.tmin, r.tmax = ray.tmax;
  return r;
}

EX_UNUSED static course_hit course_library_hit(const pktrt_scene *library, course_ray ray) {
  const pktrt_ray r = course_library_ray(ray);
  pktrt_hit hit;
  pktrt_intersect(library, &r, &hit);
  course_hit h = {hit.t, hit.u, hit.v, hit.triangle};
  return h;
}

EX_UNUSED static bool course_library_occluded(const pktrt_scene *library, course_ray ray) {
  const pktrt_ray r = course_library_ray(ray);
  return pktrt_occluded(library, &r);
}

/* Returns how many nodes the library opens for a ray that is traced alone, the root included. */
EX_UNUSED static uint64_t course_library_opens(const pktrt_scene *library, course_ray ray) {
  static pktrt_stats stats;
  const pktrt_ray r = course_library_ray(ray);
  pktrt_query_desc query;
  pktrt_hit hit;

  memset(&stats, 0, sizeof stats);
  memset(&query, 0, sizeof query);
  query.path = PKTRT_PATH_SINGLE;
  query.stats = &stats;
  pktrt_intersect_ex(library, &query, &r, &hit, 1);
  return stats.by_type[PKTRT_RAY_PRIMARY].node_visits;
}

/* >>comparing ------------------------------------------------------------------------------------------------------ */

/* What became of the rays that were compared. */
typedef struct course_tally {
  uint64_t rays, excused, different; /* excused: at an edge or in a tie, where roundings decide */
} course_tally;

/* Where a ray meets the plane of a triangle, in double; how deep inside the triangle: its least barycentric coordinate,
   negative outside. */
EX_UNUSED static double course_inside(const course_scene *s, course_ray ray, uint32_t triangle, double *t) {
  double p[3][3], e[3], f[3], r[3], q[3], n[3], det = 0, u = 0, v = 0, depth = 0;
  for (int c = 0; c < 3; c++)
    for (int k = 0; k < 3; k++) p[c][k] = (double)s->position[s->corner[triangle][c]].at[k] - (double)ray.origin.at[k];
  for (int k = 0; k < 3; k++) e[k] = p[1][k] - p[0][k], f[k] = p[2][k] - p[0][k], r[k] = (double)ray.direction.at[k];
  for (int k = 0; k < 3; k++) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    n[k] = e[i] * f[j] - e[j] * f[i], q[k] = r[i] * p[0][j] - r[j] * p[0][i];
  }
  for (int k = 0; k < 3; k++) det += n[k] * r[k], depth += n[k] * p[0][k], u -= f[k] * q[k], v += e[k] * q[k];
  *t = depth / det, u /= det, v /= det;
  return fmin(fmin(u, v), 1 - u - v);
}

static void course_say_hit(const char *who, const course_hit *hit) {
  if (hit->triangle == COURSE_NONE) printf("  %s: nothing, with t = %.7g\n", who, (double)hit->t);
  else printf("  %s: triangle %u at t = %.7g\n", who, (unsigned)hit->triangle, (double)hit->t);
}

static void course_say_ray(uint64_t number, course_ray ray) {
  const float *o = ray.origin.at, *d = ray.direction.at;
  printf("ray %u from (%.7g, %.7g, %.7g) along (%.7g, %.7g, %.7g), t from %g to %g\n", (unsigned)number, (double)o[0],
      (double)o[1], (double)o[2], (double)d[0], (double)d[1], (double)d[2], (double)ray.tmin, (double)ray.tmax);
}

/* Compares a hit with the library's, and counts. They are the same if the triangles are, and t within 1e-4 of it. A
   difference is excused where the nearer of the two is hit within COURSE_EDGE of an edge, or both at nearly the same
   t. The first one that is not excused is printed, as ray `number` of a
   packet, or of those that are traced alone (packet: PKTRT_NONE). */
EX_UNUSED static bool course_same_hit_of(const course_scene *s, course_ray ray, const course_hit *mine,
    const course_hit *theirs, course_tally *tally, uint32_t packet, uint64_t number) {
  const bool far_apart = !(fabsf(mine->t - theirs->t) <= 1e-4f * fabsf(theirs->t)) && mine->t != theirs->t;
  tally->rays++;
  if (mine->triangle == theirs->triangle && !far_apart) return true;
  const course_hit *nearer = mine->t < theirs->t ? mine : theirs;
  double t;
  if (mine->triangle != theirs->triangle && (mine->triangle < s->triangles || mine->triangle == COURSE_NONE) &&
      nearer->triangle < s->triangles &&
      (!far_apart || fabs(course_inside(s, ray, nearer->triangle, &t)) < COURSE_EDGE)) {
    tally->excused++;
    return true;
  }
  if (!tally->different++) {
    if (packet != PKTRT_NONE) printf("packet %u, ", (unsigned)packet);
    course_say_ray(number, ray);
    course_say_hit("expected", theirs);
    course_say_hit("got", mine);
  }
  return false;
}

/* The same of rays that are traced alone: they are numbered as they come. */
EX_UNUSED static bool course_same_hit(
    const course_scene *s, course_ray ray, const course_hit *mine, const course_hit *theirs, course_tally *tally) {
  return course_same_hit_of(s, ray, mine, theirs, tally, PKTRT_NONE, tally->rays);
}

/* Compares whether anything is hit: shadows. A difference is excused where all that decides is a triangle that is hit within
   COURSE_EDGE of an edge, or at an end of the ray. */
EX_UNUSED static bool course_same_occlusion(
    const course_scene *s, course_ray ray, bool mine, bool theirs, course_tally *tally) {
  tally->rays++;
  if (mine == theirs) return true;
  bool surely = false, perhaps = false;
  for (uint32_t i = 0; i < s->triangles; i++) {
    double t, slack = COURSE_EDGE, inside = course_inside(s, ray, i, &t);
    const double lo = (double)ray.tmin, hi = (double)ray.tmax;
    perhaps |= inside > -slack && t > lo - slack && t < hi + slack;
    surely |= inside > slack && t > lo + slack && t < hi - slack;
  }
  if (perhaps && !surely) {
    tally->excused++;
    return true;
  }
  if (!tally->different++) {
    printf("the check's ");
    course_say_ray(tally->rays - 1, ray);
    printf("  expected: %s\n  got: %s\n", theirs ? "in shadow" : "not in shadow", mine ? "in shadow" : "not in shadow");
  }
  return false;
}

EX_UNUSED static void course_tally_print(const course_tally *t) {
  printf("  %u of %u rays differ from the library, %u more at edges or in ties\n", (unsigned)t->different,
      (unsigned)t->rays, (unsigned)t->excused);
}

static int course_checked; /* the chapter */

/* What standard C forbids in a handler: but the program is at its end, and what it has printed should be seen. */
static void course_crashed(int signal_number) {
  (void)signal_number;
  printf("chapter %d: failed: it reads or writes where nothing is, as with a number of no node or triangle\n",
      course_checked);
  fflush(stdout);
  _Exit(1);
}

/* Lets a check end with a sentence where an answer crashes; address sanitizers say more and are left alone. */
EX_UNUSED static void course_check_begins(int chapter) {
  course_checked = chapter;
#ifndef __SANITIZE_ADDRESS__
  signal(SIGSEGV, course_crashed);
#endif
}

/* The last line of a check, and its exit status. why: NULL if all is well. */
EX_UNUSED static int course_result(int chapter, const char *why) {
  if (why) printf("chapter %d: failed: %s\n", chapter, why);
  else printf("chapter %d: passed\n", chapter);
  return why != NULL;
}

/* >>nodes and events ----------------------------------------------------------------------------------------------- */

/* All nodes of the scene's only tree, at rest; node 0 is the root. */
EX_UNUSED static pktrt_node *course_library_nodes(const pktrt_scene *library, uint32_t *count) {
  pktrt_tree tree;
  if (!pktrt_get_tree(library, 0, &tree)) ex_fail("the scene has no tree"), exit(1);
  pktrt_node *node = (pktrt_node *)course_memory(tree.nodes, sizeof *node);
  for (uint32_t i = 0; i < tree.nodes; i++)
    if (!pktrt_get_node(library, 0, i, 0, &node[i])) ex_fail("node %u cannot be read", (unsigned)i), exit(1);
  *count = tree.nodes;
  return node;
}

typedef struct course_log { /* events in the order in which they were told; zeroed: empty */
  pktrt_event *event;
  size_t count, room;
} course_log;

EX_UNUSED static void course_log_event(void *user, const pktrt_event *event) {
  course_log *log = (course_log *)user;
  if (log->count == log->room) {
    pktrt_event *more = (pktrt_event *)course_memory(log->room = 2 * log->room + 256, sizeof *more);
    if (log->count) memcpy(more, log->event, log->count * sizeof *more);
    log->event = more;
  }
  log->event[log->count++] = *event;
}

/* Traces up to 256 rays as one packet on the paper's path, of which `steps` are taken (see pktrt_paper_step), and logs
   its events. hits may be NULL. */
EX_UNUSED static void course_library_packet(
    const pktrt_scene *library, const course_ray *rays, uint32_t n, uint32_t steps, course_hit *hits, course_log *log) {
  pktrt_ray ray[256];
  pktrt_hit hit[256];
  pktrt_query_desc query;
  memset(&query, 0, sizeof query);
  query.path = PKTRT_PATH_PAPER, query.packet_size = n, query.paper_steps = steps;
  query.trace = course_log_event, query.user = log;
  for (uint32_t i = 0; i < n; i++) ray[i] = course_library_ray(rays[i]);
  pktrt_intersect_ex(library, &query, ray, hit, n);
  for (uint32_t i = 0; hits && i < n; i++) {
    const course_hit h = {hit[i].t, hit[i].u, hit[i].v, hit[i].triangle};
    hits[i] = h;
  }
}

/* Traces a packet like course_library_packet(), into an emptied log. Returns how many tests of a ray against a box the
   library makes. */
EX_UNUSED static uint64_t course_library_tests(
    const pktrt_scene *library, const course_ray *rays, uint32_t n, uint32_t steps, course_log *log) {
  uint64_t tests = 0;

  log->count = 0;
  course_library_packet(library, rays, n, steps, NULL, log);
  for (size_t i = 0; i < log->count; i++) tests += log->event[i].tested;
  return tests;
}

/* Leaves in a log what does not hang on the order of tests in a leaf: what is told of nodes, of their children and of
   leaves; and of the hits in a leaf the last one of each ray, by rays. */
static void course_log_tidy(course_log *log) {
  size_t n = 0;
  for (size_t i = 0; i < log->count; i++) {
    const pktrt_event e = log->event[i];
    if (e.kind == PKTRT_EVENT_LEAF_TEST || e.kind == PKTRT_EVENT_TRIM) continue;
    size_t at = n;
    if (e.kind == PKTRT_EVENT_HIT) {
      while (at > 0 && log->event[at - 1].kind == PKTRT_EVENT_HIT && log->event[at - 1].ray >= e.ray) at--;
      if (at < n && log->event[at].ray == e.ray) {
        log->event[at] = e;
        continue;
      }
    }
    memmove(log->event + at + 1, log->event + at, (n - at) * sizeof e);
    log->event[at] = e, n++;
  }
  log->count = n;
}

static void course_say_event(const char *who, const course_log *log, size_t i) {
  static const char *const kind[] = {
      "NODE", "FIRST_HIT", "INTERVAL_CULL", "FRUSTUM_CULL", "LATER_HIT", "ALL_MISS", "LEAF", "HIT", "NONE_LEFT"};
  if (i >= log->count) {
    printf("  %s: nothing more\n", who);
    return;
  }
  const pktrt_event *e = &log->event[i];
  printf("  %s: %s, index %u, child %u, ray %u\n", who,
      e->kind <= PKTRT_EVENT_NONE_LEFT ? kind[e->kind] : "what is unknown", (unsigned)e->index, (unsigned)e->child,
      (unsigned)e->ray);
}

/* Tidies two logs of a packet and compares them, event by event: kind, index, child and ray. Says what differs first,
   unless quiet. */
EX_UNUSED static bool course_same_log(course_log *mine, course_log *theirs, uint32_t packet, bool quiet) {
  course_log_tidy(mine), course_log_tidy(theirs);
  for (size_t i = 0; i < mine->count || i < theirs->count; i++) {
    if (i < mine->count && i < theirs->count) {
      const pktrt_event *x = &mine->event[i], *y = &theirs->event[i];
      if (x->kind == y->kind && x->index == y->index && x->child == y->child && x->ray == y->ray) continue;
    }
    if (!quiet) {
      printf("packet %u: of its %u events number %u is the first that differs; events count from 1, packets from 0\n",
          (unsigned)packet, (unsigned)theirs->count, (unsigned)i + 1);
      course_say_event("expected", theirs, i), course_say_event("got", mine, i);
    }
    return false;
  }
  return true;
}

/* >>boxes ---------------------------------------------------------------------------------------------------------- */

/* [slabs] */
/* The numbers that the box test needs of a ray. Depths are distances along the ray's main axis, the axis of the largest
   component of the direction: the point of parameter t has depth t * scale, and a step of 1 in depth is a step of
   1 / r[a] along axis a. */
typedef struct course_slabs {
  float r[3], near_[3], far_[3]; /* the ray crosses a plane at a depth from plane * r - near_ to plane * r - far_ */
  float first, last;             /* the depths at which the ray can have a hit; a hit lowers last */
  float scale, tiny, pad;        /* pad: the test widens boxes by pad, which is more than the rounding errors */
  uint32_t octant;               /* bit a: component a of the direction is negative */
} course_slabs;
/* [end] */

/* Derives them as the library does, bit for bit, but for directions shorter than 2^-60. Its section >>exactness shows
   why pad is enough: 16 + 8 roundings of the largest numbers in the scene, seen from the ray's origin. */
EX_UNUSED static course_slabs course_slabs_make(const pktrt_node *root, course_ray ray) {
  const float eps = 1.0f / 16777216; /* 2^-24: a float's rounding */
  course_slabs s;
  float reach = 0, origin = 0;
  s.octant = 0, s.scale = 0;
  for (uint32_t a = 0; a < 3; a++) {
    const float o = ray.origin.at[a], d = ray.direction.at[a];
    for (int k = 0; k < 8; k++)
      if (root->child[k] != PKTRT_NONE) reach = fmaxf(reach, fmaxf(root->hi[k][a] - o, o - root->lo[k][a]));
    origin = fmaxf(origin, fabsf(o)), s.scale = fmaxf(s.scale, fabsf(d));
    s.octant |= (signbit(d) ? 1u : 0u) << a;
  }
  s.pad = reach * (16 * eps) + origin * (8 * eps) + FLT_MIN;
  for (int a = 0; a < 3; a++) {
    const float o = ray.origin.at[a], d = ray.direction.at[a];
    s.r[a] = s.scale / copysignf(fmaxf(fabsf(d), s.scale * (eps / 4)), d); /* never infinite */
    s.near_[a] = o * s.r[a] + s.pad * fabsf(s.r[a]), s.far_[a] = o * s.r[a] - s.pad * fabsf(s.r[a]);
  }
  s.tiny = fmaxf(s.scale, 1) * (2 * FLT_MIN);
  s.first = ray.tmin * s.scale, s.last = ray.tmax * s.scale;
  s.first -= fabsf(s.first) * (4 * eps) + s.tiny, s.last += fabsf(s.last) * (4 * eps) + s.tiny;
  return s;
}

/* [enter] */
/* Returns true if the ray enters a box, and stores the depth of entry. A ray that misses the box by less than the
   rounding error enters too, which costs time; a ray that hits a triangle inside the box always enters. */
EX_UNUSED static bool course_slabs_enter(const course_slabs *s, const float lo[3], const float hi[3], float *depth) {
  float enter = s->first, leave = s->last;
  for (int a = 0; a < 3; a++) {
    const float l = lo[a] * s->r[a], h = hi[a] * s->r[a];
    enter = fmaxf((l < h ? l : h) - s->near_[a], enter);
    leave = fminf((l > h ? l : h) - s->far_[a], leave);
  }
  if (depth) *depth = enter;
  return enter <= leave;
}
/* [end] */

/* Makes a triangle the ray's hit, and the ray shorter, if it is nearer than the hit so far; tells whether it is. A hit
   begins as {tmax, 0, 0, COURSE_NONE}; u and v stay as they are. */
EX_UNUSED static bool course_slabs_meet(
    course_slabs *s, const course_scene *scene, course_ray ray, uint32_t triangle, course_hit *hit) {
  double t;
  if (!(course_inside(scene, ray, triangle, &t) > 0 && t > (double)ray.tmin && (float)t < hit->t)) return false;
  hit->t = (float)t, hit->triangle = triangle;
  s->last = hit->t * s->scale;
  s->last += fabsf(s->last) * (4.0f / 16777216) + s->tiny;
  return true;
}

/* [bounds] */
/* Bounds that hold for all rays of a packet: intervals of the origins, reciprocal directions and depths. */
typedef struct course_bounds {
  float o_lo[3], o_hi[3], r_lo[3], r_hi[3]; /* r as in course_slabs */
  float first, last, pad;                   /* the least first; the largest last, the largest pad */
} course_bounds;
/* [end] */

EX_UNUSED static course_bounds course_bounds_make(const course_ray *rays, const course_slabs *s, uint32_t n) {
  course_bounds b;
  for (uint32_t i = 0; i < n; i++) {
    for (int a = 0; a < 3; a++) {
      const float o = rays[i].origin.at[a], r = s[i].r[a];
      b.o_lo[a] = i ? fminf(b.o_lo[a], o) : o, b.o_hi[a] = i ? fmaxf(b.o_hi[a], o) : o;
      b.r_lo[a] = i ? fminf(b.r_lo[a], r) : r, b.r_hi[a] = i ? fmaxf(b.r_hi[a], r) : r;
    }
    b.first = i ? fminf(b.first, s[i].first) : s[i].first;
    b.last = i ? fmaxf(b.last, s[i].last) : s[i].last, b.pad = i ? fmaxf(b.pad, s[i].pad) : s[i].pad;
  }
  return b;
}

#endif /* COURSE_H */
