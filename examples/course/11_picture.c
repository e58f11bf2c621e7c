/* Chapter 11: Whitted's ray tracer. A camera ray, shadow rays, mirrors and glass.

   Makes out/course/11_picture.png, out/course/11_tree.svg. Prints differences from the library, and rays by type and
   depth.    cc -O2 examples/course/11_picture.c -o picture -lm && ./picture */
#define PKTRT_IMPLEMENTATION
#include "11_picture.h"
#include "11_record.h"
#ifndef COURSE_CHECK /* a check includes this file, and has its own picture_scatter() and main */
#include "11_solution.c"
#endif

enum { WIDTH = 328, HEIGHT = 248 };

static record rays; /* of the picture */

/* Returns the nearest hit of a ray: every triangle is tested, as in chapter 1. */
static course_hit nearest(const course_scene *scene, const course_ray *ray) {
  course_hit hit = {ray->tmax, 0, 0, COURSE_NONE};
  for (uint32_t i = 0; i < scene->triangles; i++) course_meet(scene, ray, i, &hit);
  return hit;
}

/* Returns the unit normal of a triangle; it points to where the corners are seen counter-clockwise. */
static vec outward(const course_scene *scene, uint32_t triangle) {
  const uint32_t *corner = scene->corner[triangle];
  const vec p0 = scene->position[corner[0]];
  return vec_unit(vec_cross(vec_sub(scene->position[corner[1]], p0), vec_sub(scene->position[corner[2]], p0)));
}

/* [leave] */
/* Returns a ray from a point of a surface. It starts a step off the surface, on the side that it goes to. */
static course_ray leave(vec point, vec normal, vec direction) {
  const float step = vec_dot(normal, direction) > 0 ? 1e-4f : -1e-4f;
  const course_ray ray = {vec_add(point, vec_scale(normal, step)), direction, 0, INFINITY};
  return ray;
}
/* [end] */

/* Returns the light that a point scatters: of the surroundings and, unless a shadow ray meets something, of the lamp.
   The normal is on the side of the viewer. */
static vec matte(const picture_scene *scene, vec point, vec normal, vec albedo, float weight, uint32_t depth) {
  const vec to_lamp = vec_sub(scene->lamp, point);
  const float squared = vec_dot(to_lamp, to_lamp);
  const float cosine = vec_dot(normal, to_lamp) / sqrtf(squared);
  vec light = scene->ambient;

  if (albedo.at[0] > 0 && cosine > 0) {
    course_ray shadow = leave(point, normal, to_lamp);
    shadow.direction = vec_sub(scene->lamp, shadow.origin);
    shadow.tmax = 1;
    const course_hit hit = nearest(&scene->triangles, &shadow);
    record_ray(&rays, PKTRT_RAY_SHADOW, depth + 1, weight, &shadow, hit.t);
    if (hit.triangle == COURSE_NONE)
      light = vec_add(light, vec_scale(scene->intensity, cosine / (3.14159265f * squared)));
  }
  for (int c = 0; c < 3; c++) light.at[c] *= albedo.at[c];
  return light;
}

/* How far rays are followed. */
typedef struct limits {
  float cutoff;   /* a ray of less weight is not followed */
  uint32_t depth; /* a ray has gone on at no more surfaces than this */
} limits;

/* [trace] */
/* Returns the radiance that a ray brings. weight: the largest part of it that can reach the pixel; depth: the number of
   surfaces since the camera. */
static vec trace(
    const picture_scene *scene, limits most, pktrt_ray_type type, course_ray ray, float weight, uint32_t depth) {
  const course_hit hit = nearest(&scene->triangles, &ray);
  record_ray(&rays, type, depth, weight, &ray, hit.t);
  if (hit.triangle == COURSE_NONE) return picture_sky(vec_unit(ray.direction));

  const picture_material *material = &scene->material[picture_part(scene, hit.triangle)];
  const vec point = vec_add(ray.origin, vec_scale(ray.direction, hit.t));
  const vec normal = outward(&scene->triangles, hit.triangle);
  const vec facing = vec_scale(normal, vec_dot(normal, ray.direction) > 0 ? -1 : 1);

  vec radiance = matte(scene, point, facing, picture_albedo(material, point), weight, depth);
  if (depth == most.depth) return radiance;

  picture_way way[2];
  const uint32_t ways = picture_scatter(material, vec_unit(ray.direction), normal, way);
  if (material->ior > 0) record_glass(&rays, vec_dot(normal, ray.direction) > 0, ways);
  for (uint32_t k = 0; k < ways; k++) {
    const float share = way[k].share;
    if (weight * share < most.cutoff) continue;
    const course_ray next = leave(point, normal, way[k].direction);
    radiance = vec_add(radiance, vec_scale(trace(scene, most, way[k].type, next, weight * share, depth + 1), share));
  }
  return radiance;
}
/* [end] */

/* Makes the picture, one ray through the middle of each pixel, by blocks of 8 x 8 pixels. */
static course_picture make_picture(const picture_scene *scene, limits most) {
  course_picture picture = course_picture_make(WIDTH, HEIGHT);
  for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
    const uint32_t block = i / 64;
    const uint32_t x = block % (WIDTH / 8) * 8 + i % 8;
    const uint32_t y = block / (WIDTH / 8) * 8 + i / 8 % 8;
    const course_ray ray = course_camera_ray((float)x + 0.5f, (float)y + 0.5f, WIDTH, HEIGHT);
    if (i % 64 == 0) record_block(&rays);
    picture.pixel[y * WIDTH + x] = trace(scene, most, PKTRT_RAY_PRIMARY, ray, 1, 0);
  }
  record_block(&rays);
  return picture;
}

#ifndef COURSE_CHECK
/* Makes the pictures and prints the figures of the text. */
int main(void) {
  const limits usual = {1.0f / 256, 50};
  const limits other[4] = {{1.0f / 16, 50}, {1.0f / 64, 50}, {0, 4}, {0, 8}};
  picture_scene scene = picture_make();
  pktrt_scene *library = picture_library(&scene);
  course_picture theirs = course_picture_make(WIDTH, HEIGHT);
  pktrt_stats stats;

  memset(&stats, 0, sizeof stats);
  const course_picture mine = make_picture(&scene, usual);
  picture_render(&scene, library, &theirs, usual.cutoff, usual.depth, &stats);
  record_write_both(&mine, &theirs, "out/course/11_picture.png");
  printf("11_picture: %u pixels, %u triangles\n", WIDTH * HEIGHT, (unsigned)scene.triangles.triangles);
  course_figure("pixels", "%d", WIDTH * HEIGHT);
  course_figure("triangles", "%u", (unsigned)scene.triangles.triangles);
  course_figure("triangles.ball", "%u", (unsigned)(scene.first[PICTURE_BALL + 1] - scene.first[PICTURE_BALL]));
  record_compare(&mine, &theirs);
  record_print_all(&rays, &stats);

  picture_render(&scene, library, &theirs, 1.0f / 65536, 50, NULL);
  printf("compared with a cut-off of 1/65536:\n");
  record_print_limits(&rays, usual.cutoff, usual.depth, &mine, &theirs);
  for (int i = 0; i < 4; i++) {
    memset(&rays, 0, sizeof rays);
    const course_picture picture = make_picture(&scene, other[i]);
    record_print_limits(&rays, other[i].cutoff, other[i].depth, &picture, &theirs);
  }
  record_print_glass();

  /* The tree of one pixel, without its thinnest branches. */
  const limits drawn = {1.0f / 32, 50};
  memset(&rays, 0, sizeof rays);
  rays.keep = true;
  trace(&scene, drawn, PKTRT_RAY_PRIMARY, course_camera_ray(215, 184, WIDTH, HEIGHT), 1, 0);
  record_print_tree(&rays);
  pktrt_scene_destroy(library);
  return !record_draw(&rays, &scene, "out/course/11_tree.svg");
}
#endif
