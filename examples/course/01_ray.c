/* Chapter 1: a camera, a triangle, all triangles, and a picture of the depths.

   Prints the number of tests; compares hits with the library.

     cc -O2 examples/course/01_ray.c -o ray -lm && ./ray */
#define PKTRT_IMPLEMENTATION
#include "course.h"

enum { WIDTH = 256, HEIGHT = 192 };

/* [camera] */
typedef struct camera {
  vec eye, forward, right, up; /* unit vectors, perpendicular to each other */
  float half;                  /* tangent of half the vertical angle of view */
} camera;

/* Returns a camera at `eye` that looks at `target`. */
static camera look(vec eye, vec target, float half) {
  camera c;
  c.eye = eye;
  c.half = half;
  c.forward = vec_unit(vec_sub(target, eye));
  c.right = vec_unit(vec_cross(c.forward, vec_make(0, 1, 0)));
  c.up = vec_cross(c.right, c.forward);
  return c;
}

/* Returns the ray through the point (x, y) of the picture, in pixels from the upper left corner. */
static course_ray camera_ray(const camera *c, float x, float y) {
  const float dx = c->half * (2 * x - WIDTH) / HEIGHT, dy = c->half * (HEIGHT - 2 * y) / HEIGHT;
  const vec aside = vec_add(vec_scale(c->right, dx), vec_scale(c->up, dy));
  const course_ray ray = {c->eye, vec_add(c->forward, aside), 0, INFINITY};
  return ray;
}
/* [end] */

/* [triangle] */
/* If the ray hits the triangle p0 p1 p2 nearer than *hit, stores the hit in *hit and returns true. */
static bool meet_triangle(const course_ray *ray, vec p0, vec p1, vec p2, course_hit *hit) {
  const vec e = vec_sub(p1, p0), f = vec_sub(p2, p0), s = vec_sub(ray->origin, p0);
  const vec p = vec_cross(ray->direction, f), q = vec_cross(s, e);
  const float det = vec_dot(e, p); /* 0: the ray runs along the plane, or the triangle has no area */
  if (det == 0) return false;
  const float u = vec_dot(s, p) / det, v = vec_dot(ray->direction, q) / det, t = vec_dot(f, q) / det;
  if (!(u >= 0 && v >= 0 && u + v <= 1 && ray->tmin < t && t < hit->t)) return false;
  hit->t = t;
  hit->u = u;
  hit->v = v;
  return true;
}
/* [end] */

/* [nearest] */
/* Returns the nearest hit of a ray; its triangle is COURSE_NONE if the ray hits nothing. */
static course_hit nearest(const course_scene *s, const course_ray *ray) {
  course_hit hit = {ray->tmax, 0, 0, COURSE_NONE};
  for (uint32_t i = 0; i < s->triangles; i++) {
    const uint32_t *c = s->corner[i];
    if (meet_triangle(ray, s->position[c[0]], s->position[c[1]], s->position[c[2]], &hit)) hit.triangle = i;
  }
  return hit;
}
/* [end] */

int main(void) {
  course_scene scene = course_scene_make();
  pktrt_scene *library = course_library(&scene);
  const camera eye = look(vec_make(2.7f, 4.1f, 7.3f), vec_make(0.1f, 1.2f, -0.1f), 0.36f);
  course_picture picture = course_picture_make(WIDTH, HEIGHT);
  course_tally tally = {0, 0, 0};
  const float near = 4.5f, far = 13; /* depths that are drawn white and black */
  uint32_t hits = 0;
  for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
    const course_ray ray = camera_ray(&eye, (float)(i % WIDTH) + 0.5f, (float)(i / WIDTH) + 0.5f);
    const course_hit hit = nearest(&scene, &ray), theirs = course_library_hit(library, ray);
    course_same_hit(&scene, ray, &hit, &theirs, &tally);
    if (hit.triangle == COURSE_NONE) continue; /* the picture is black there */
    const float grey = fmaxf(0, (far - hit.t) / (far - near));
    picture.pixel[i] = vec_make(grey, grey, grey);
    hits++;
  }
  course_picture_write_double(&picture, "out/course/01_depth.png");

  printf("01_ray: %u rays, %u triangles: %.0f million tests; %u rays hit something\n", WIDTH * HEIGHT,
      (unsigned)scene.triangles, (double)tally.rays * scene.triangles / 1e6, (unsigned)hits);
  course_tally_print(&tally);
  course_figure("rays", "%u", WIDTH * HEIGHT);
  course_figure("triangles", "%u", (unsigned)scene.triangles);
  course_figure("tests", "%.0f", (double)tally.rays * scene.triangles / 1e6);
  course_figure("excused", "%u", (unsigned)tally.excused);
  pktrt_scene_destroy(library);
  return tally.different != 0;
}
