/* Lab: why rays leak. Rays from inside a closed ball aim at its edges and vertices; each must hit something. Three tests
   of triangles and the library are asked, the ball at rest and growing.

   Prints leaks and draws where they are.    cc -O2 examples/course/lab_leaks.c -o leaks -lm && ./leaks */
#define PKTRT_IMPLEMENTATION
#include "course.h"
#include "../svg.h"

/* All tests answer whether a ray meets the triangle p[0] p[1] p[2] at t > 0. */
typedef bool test(const vec *p, const course_ray *ray);

/* [moller] */
static bool moller_trumbore(const vec *p, const course_ray *ray) {
  const vec e = vec_sub(p[1], p[0]), f = vec_sub(p[2], p[0]), s = vec_sub(ray->origin, p[0]);
  const vec a = vec_cross(ray->direction, f), b = vec_cross(s, e);
  const float det = vec_dot(e, a), u = vec_dot(s, a) / det, v = vec_dot(ray->direction, b) / det;
  return u >= 0 && v >= 0 && u + v <= 1 && vec_dot(f, b) / det > 0; /* NaN, where det is 0, is no hit */
}
/* [end] */

/* [kensler] */
static bool kensler_shirley(const vec *p, const course_ray *ray) {
  const vec e = vec_sub(p[1], p[0]), f = vec_sub(p[0], p[2]), s = vec_sub(p[0], ray->origin);
  const vec n = vec_cross(e, f), i = vec_cross(s, ray->direction);
  const float det = vec_dot(n, ray->direction), v = vec_dot(f, i), w = vec_dot(e, i), u = det - v - w;
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false; /* nothing is divided until here */
  return vec_dot(n, s) / det > 0;
}
/* [end] */

/* [sheared] */
static bool sheared(const vec *p, const course_ray *ray) {
  const float *d = ray->direction.at;
  int k = fabsf(d[1]) > fabsf(d[0]) ? 1 : 0;
  if (fabsf(d[2]) > fabsf(d[k])) k = 2;
  const int i = (k + 1) % 3, j = (k + 2) % 3;
  double x[3], y[3], z[3], e[3];
  for (int c = 0; c < 3; c++) { /* of this vertex and the ray alone: the same in all triangles that share it */
    const vec q = vec_sub(p[c], ray->origin);
    x[c] = (double)(q.at[i] - d[i] / d[k] * q.at[k]);
    y[c] = (double)(q.at[j] - d[j] / d[k] * q.at[k]);
    z[c] = (double)(q.at[k] / d[k]);
  }
  for (int c = 0; c < 3; c++) { /* products of floats are exact in double, and so is the sign of their difference */
    const int a = (c + 1) % 3, b = (c + 2) % 3;
    e[c] = x[a] * y[b] - x[b] * y[a];
  }
  if ((e[0] < 0 || e[1] < 0 || e[2] < 0) && (e[0] > 0 || e[1] > 0 || e[2] > 0)) return false;
  return (e[0] * z[0] + e[1] * z[1] + e[2] * z[2]) / (e[0] + e[1] + e[2]) > 0;
}
/* [end] */

typedef struct ball {
  course_scene scene; /* has twice as many positions: those of time 0, then those of time 1 */
  bool moves;
} ball;

/* [motion] */
/* Where a vertex is at a time: the same floats whichever triangle asks. */
static vec vertex(const ball *b, uint32_t index, float time) {
  const vec *p = b->scene.position + index;
  return b->moves ? vec_add(vec_scale(p[0], 1 - time), vec_scale(p[b->scene.vertices], time)) : *p;
}
/* [end] */

static pktrt_scene *add_to_library(const ball *b) {
  pktrt_scene *library = pktrt_scene_create(NULL);
  pktrt_mesh_desc mesh;
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = b->scene.position[0].at, mesh.vertex_count = b->scene.vertices, mesh.key_count = b->moves ? 2 : 1;
  mesh.indices = b->scene.corner[0], mesh.triangle_count = b->scene.triangles;
  if (pktrt_add_mesh(library, &mesh, NULL) || pktrt_commit(library)) ex_fail("%s", pktrt_last_error(library)), exit(1);
  return library;
}

static bool is_hit(const ball *b, test *meets, const course_ray *ray, float time) {
  vec p[3];
  for (uint32_t i = 0; i < b->scene.triangles; i++) {
    for (int c = 0; c < 3; c++) p[c] = vertex(b, b->scene.corner[i][c], time);
    if (meets(p, ray)) return true;
  }
  return false;
}

/* Where a direction is in one of the square panels of the drawing; false where it is farther than `reach` from its middle. */
static bool project(vec way, int panel, double reach, double *x, double *y) {
  const double depth = -(double)way.at[2], across = (double)way.at[0] / depth, up = (double)way.at[1] / depth;
  *x = 155 + 310 * (panel % 2) + 140 * across, *y = 180 + 330 * (panel / 2) - 140 * up;
  return depth > 0 && fabs(across) < reach && fabs(up) < reach;
}

static void draw_edges(const ball *b, vec eye, svg *s, int panel, const char *title) {
  const int left = 15 + 310 * (panel % 2), top = 40 + 330 * (panel / 2);
  svg_text(s, left + 140, top - 15, 14, SVG_MIDDLE, "%s%s", title, panel < 2 ? "" : ", moving");
  fprintf(s->file, "<svg x=\"%d\" y=\"%d\" width=\"280\" height=\"280\" viewBox=\"%d %d 280 280\">\n", left, top, left,
      top);
  for (uint32_t i = 0; i < 3 * b->scene.triangles; i++) {
    const uint32_t v0 = b->scene.corner[i / 3][i % 3], v1 = b->scene.corner[i / 3][(i + 1) % 3];
    double x0, y0, x1, y1;
    const bool in0 = project(vec_sub(vertex(b, v0, 0), eye), panel, 1.25, &x0, &y0);
    const bool in1 = project(vec_sub(vertex(b, v1, 0), eye), panel, 1.25, &x1, &y1);
    if (v0 < v1 && (in0 || in1)) svg_line(s, x0, y0, x1, y1, "#aaa", 1);
  }
  fprintf(s->file, "</svg>\n");
}

int main(void) {
  enum { RAYS = 40000 };
  static test *const tests[3] = {moller_trumbore, kensler_shirley, sheared};
  static const char *const titles[2] = {"Moeller-Trumbore", "Kensler-Shirley"};
  const vec eye = {{1.23f, 1.04f, 1.57f}};
  ball b = {course_scene_empty(), false};
  bool wrong = false;
  double rays_per_leak[2] = {0, 0}; /* by the first two tests, at rest */
  svg s;
  course_add(&b.scene, course_ball, 24, 14);
  for (uint32_t i = 0; i < b.scene.vertices; i++) /* it grows by a third: seen from the eye, edges stay */
    b.scene.position[b.scene.vertices + i] = vec_add(eye, vec_scale(vec_sub(b.scene.position[i], eye), 4 / 3.0f));
  course_make_folder();
  if (!svg_begin(&s, "out/course/lab_leaks.svg", 620, 670)) return 1;
  printf("lab_leaks: of %d rays from inside a closed ball of %u triangles to its edges and vertices\n", RAYS,
      (unsigned)b.scene.triangles);
  for (int moving = 0; moving < 2; moving++) {
    b.moves = moving;
    pktrt_scene *library = add_to_library(&b);
    uint32_t leaks[4] = {0, 0, 0, 0}, at_vertex[3] = {0, 0, 0}, state = 1;
    for (int k = 0; k < 2; k++) draw_edges(&b, eye, &s, 2 * moving + k, titles[k]);
    for (uint32_t i = 0; i < RAYS; i++) {
      const uint32_t *c = b.scene.corner[i % b.scene.triangles], from = i / b.scene.triangles % 3;
      const float time = moving ? course_random(&state) : 0, w = course_random(&state);
      const vec p = vertex(&b, c[from], time), q = vertex(&b, c[(from + 1) % 3], time);
      const vec target = i % 7 ? vec_add(p, vec_scale(vec_sub(q, p), w)) : p;
      const course_ray ray = {eye, vec_sub(target, eye), 0, INFINITY};
      double x, y;
      for (int k = 0; k < 3; k++) {
        if (is_hit(&b, tests[k], &ray, time)) continue;
        leaks[k]++, at_vertex[k] += i % 7 == 0;
        if (k < 2 && project(ray.direction, 2 * moving + k, 1, &x, &y)) svg_dot(&s, x, y, 1.7, "#d00");
      }
      pktrt_ray r = course_library_ray(ray);
      r.time = time;
      leaks[3] += !pktrt_occluded(library, &r);
    }
    wrong |= leaks[2] || leaks[3];
    pktrt_scene_destroy(library);
    printf("  leak, %s: Moeller-Trumbore %u (%u at a vertex), Kensler-Shirley %u (%u), sheared %u, the library %u\n",
        moving ? "moving" : "at rest", (unsigned)leaks[0], (unsigned)at_vertex[0], (unsigned)leaks[1],
        (unsigned)at_vertex[1], (unsigned)leaks[2], (unsigned)leaks[3]);
    for (int k = 0; k < 2 && !moving; k++) rays_per_leak[k] = (double)RAYS / leaks[k];
  }

  course_figure("rays", "%d", RAYS);
  course_figure("rays.mt", "%.0f", rays_per_leak[0]);
  course_figure("rays.ks", "%.0f", rays_per_leak[1]);

  return !svg_end(&s) || wrong;
}
