/* 13_rays.h - the rays of chapter 13's program and check, and what the library counts of them. */
#ifndef COURSE_13_RAYS_H
#define COURSE_13_RAYS_H

#include "course.h"

enum { RAYS_WIDTH = 256, RAYS_HEIGHT = 192, RAYS_PIXELS = RAYS_WIDTH * RAYS_HEIGHT, RAYS_CALL = 256 };
enum { RAYS_CAMERA, RAYS_SHADOW, RAYS_REFLECTED, RAYS_LENS, RAYS_SCATTERED, RAYS_SHUFFLED, RAYS_KINDS };
static const char *const rays_name[RAYS_KINDS] = {"camera", "shadow", "reflected", "lens", "scattered", "shuffled"};

/* Returns the number of a pixel, row by row, to which ray i belongs: 64 rays are 8 x 8 pixels. */
static uint32_t rays_pixel(uint32_t i) {
  const uint32_t tile = i / 64, across = RAYS_WIDTH / 8;
  return (tile / across * 8 + i / 8 % 8) * RAYS_WIDTH + tile % across * 8 + i % 8;
}

/* Makes ray i of a kind; 64 rays in a row belong to 8 x 8 pixels, unless they are shuffled. Returns false if there is none:
   if the camera's ray of this pixel hits nothing, no ray leaves a surface. */
EX_UNUSED static bool rays_aim(
    course_ray *ray, uint32_t i, int kind, const course_scene *scene, const pktrt_scene *library) {
  static const vec lamp = {{-3, 7, 5}};
  const uint32_t place = kind == RAYS_SHUFFLED ? i * 30011 % RAYS_PIXELS : i; /* each once */
  const uint32_t pixel = rays_pixel(place), x = pixel % RAYS_WIDTH, y = pixel / RAYS_WIDTH;
  uint32_t random = i;
  vec any;
  *ray = course_camera_ray((float)x + 0.5f, (float)y + 0.5f, RAYS_WIDTH, RAYS_HEIGHT);
  do
    for (int a = 0; a < 3; a++) any.at[a] = 2 * course_random(&random) - 1;
  while (vec_dot(any, any) > 1 || vec_dot(any, any) < 0.01f);

  if (kind == RAYS_LENS) { /* of radius 0.3; what is 7 units away is sharp */
    const vec at = {{0.3f * any.at[0], 0.3f * any.at[1], 0}};
    ray->origin = vec_add(ray->origin, at);
    ray->direction = vec_sub(ray->direction, vec_scale(at, 1 / 7.0f));
  }
  if (kind == RAYS_CAMERA || kind == RAYS_SHUFFLED || kind == RAYS_LENS) return true;

  const course_hit hit = course_library_hit(library, *ray);
  if (hit.triangle == COURSE_NONE) return false;
  const uint32_t *corner = scene->corner[hit.triangle];
  const vec p = scene->position[corner[0]];
  vec normal = vec_unit(vec_cross(vec_sub(scene->position[corner[1]], p), vec_sub(scene->position[corner[2]], p)));
  if (vec_dot(normal, ray->direction) > 0) normal = vec_scale(normal, -1);
  ray->origin = vec_add(vec_add(ray->origin, vec_scale(ray->direction, hit.t)), vec_scale(normal, 1e-4f));

  if (kind == RAYS_SHADOW) ray->tmax = 1;
  if (kind == RAYS_SHADOW) ray->direction = vec_sub(lamp, ray->origin);
  else if (kind == RAYS_SCATTERED) ray->direction = vec_add(normal, vec_scale(vec_unit(any), 0.999f));
  else ray->direction = vec_sub(ray->direction, vec_scale(normal, 2 * vec_dot(normal, ray->direction)));
  return true;
}

/* Traces rays by one of the library's paths, 256 in a call, and returns the counts. */
EX_UNUSED static pktrt_counts rays_library_counts(
    const pktrt_scene *library, const course_ray *rays, uint32_t n, bool any, pktrt_path path) {
  static pktrt_stats stats;
  pktrt_query_desc query;
  pktrt_ray ray[RAYS_CALL];
  pktrt_hit hit[RAYS_CALL];
  bool occluded[RAYS_CALL];
  memset(&stats, 0, sizeof stats);
  memset(&query, 0, sizeof query);
  query.path = path;
  query.stats = &stats;

  for (uint32_t i = 0, count; i < n; i += count) {
    count = n - i < RAYS_CALL ? n - i : RAYS_CALL;
    for (uint32_t k = 0; k < count; k++) ray[k] = course_library_ray(rays[i + k]);
    if (any) pktrt_occluded_ex(library, &query, ray, occluded, count);
    else pktrt_intersect_ex(library, &query, ray, hit, count);
  }
  return stats.by_type[PKTRT_RAY_PRIMARY];
}

/* Makes the rays of a tile of 8 x 8 pixels; returns how many. */
EX_UNUSED static uint32_t rays_aim_tile(
    course_ray rays[64], uint32_t tile, int kind, const course_scene *scene, const pktrt_scene *library) {
  uint32_t n = 0;
  for (uint32_t i = 0; i < 64; i++) n += rays_aim(&rays[n], 64 * tile + i, kind, scene, library);
  return n;
}

#endif /* COURSE_13_RAYS_H */
