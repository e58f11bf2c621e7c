/* Chapter 11: Whitted's ray tracer. A camera ray, shadow rays, mirrors and glass.

   Makes out/course/11_picture.png, out/course/11_tree.svg. Prints the difference from the library's picture, and rays by
   type and depth.    cc -O2 examples/course/11_picture.c -o picture -lm && ./picture */
#define PKTRT_IMPLEMENTATION
#include "11_picture.h"
#include "11_record.h"
#ifndef COURSE_CHECK        /* a check includes this file, and has its own picture_scatter() and main */
#include "11_solution.c"
#endif

enum { WIDTH = 336, HEIGHT = 256 };

static record rays; /* of the picture */

/* [nearest] */
/* Returns the nearest hit of a ray: every triangle is tested, as in chapter 1. */
static course_hit nearest(const course_scene *s, const course_ray *ray) {
  course_hit hit = {ray->tmax, 0, 0, COURSE_NONE};
  for (uint32_t i = 0; i < s->triangles; i++) course_meet(s, ray, i, &hit);
  return hit;
}

/* Returns the unit normal of a triangle; it points to where the corners are seen counter-clockwise. */
static vec outward(const course_scene *s, uint32_t triangle) {
  const uint32_t *corner = s->corner[triangle];
  const vec p0 = s->position[corner[0]];
  return vec_unit(vec_cross(vec_sub(s->position[corner[1]], p0), vec_sub(s->position[corner[2]], p0)));
}

/* Returns a ray from a point of a surface. It starts a step off the surface, on the side that it goes to. */
static course_ray leave(vec point, vec normal, vec direction) {
  const float step = vec_dot(normal, direction) > 0 ? 1e-4f : -1e-4f;
  const course_ray ray = {vec_add(point, vec_scale(normal, step)), direction, 0, INFINITY};
  return ray;
}
/* [end] */

/* [matte] */
/* Returns the light that a point scatters: of the surroundings and, unless a shadow ray meets something, of the lamp.
   The normal is on the side of the viewer. */
static vec matte(const picture_scene *s, vec point, vec normal, vec albedo, float weight, uint32_t depth) {
  const vec to_lamp = vec_sub(s->lamp, point);
  const float squared = vec_dot(to_lamp, to_lamp);
  const float cosine = vec_dot(normal, to_lamp) / sqrtf(squared);
  vec light = s->ambient;

  if (albedo.at[0] > 0 && cosine > 0) {
    course_ray shadow = leave(point, normal, to_lamp);
    shadow.direction = vec_sub(s->lamp, shadow.origin);
    shadow.tmax = 1;
    const course_hit hit = nearest(&s->triangles, &shadow);
    record_ray(&rays, PKTRT_RAY_SHADOW, depth + 1, weight, &shadow, hit.t);
    if (hit.triangle == COURSE_NONE)
      light = vec_add(light, vec_scale(s->intensity, cosine / (3.14159265f * squared)));
  }
  for (int c = 0; c < 3; c++) light.at[c] *= albedo.at[c];
  return light;
}
/* [end] */

/* [trace] */
typedef struct limits {
  float cutoff;   /* a ray of less weight is not followed */
  uint32_t depth; /* a ray has gone on at no more surfaces than this */
} limits;

/* Returns the radiance that a ray brings. weight: the largest part of it that can reach the pixel; depth: the number of
   surfaces since the camera. */
static vec trace(const picture_scene *s, limits most, pktrt_ray_type type, course_ray ray, float weight, uint32_t depth) {
  const course_hit hit = nearest(&s->triangles, &ray);
  record_ray(&rays, type, depth, weight, &ray, hit.t);
  if (hit.triangle == COURSE_NONE) return picture_sky(vec_unit(ray.direction));

  const picture_material *material = &s->material[picture_part(s, hit.triangle)];
  const vec point = vec_add(ray.origin, vec_scale(ray.direction, hit.t));
  const vec normal = outward(&s->triangles, hit.triangle);
  const vec facing = vec_scale(normal, vec_dot(normal, ray.direction) > 0 ? -1 : 1);
  vec radiance = matte(s, point, facing, picture_albedo(material, point), weight, depth);
  if (depth == most.depth) return radiance;

  picture_way way[2];
  const uint32_t ways = picture_scatter(material, vec_unit(ray.direction), normal, way);
  if (material->ior > 0) record_glass(&rays, vec_dot(normal, ray.direction) > 0, ways);
  for (uint32_t k = 0; k < ways; k++) {
    const float share = way[k].share;
    if (weight * share < most.cutoff) continue;
    const course_ray next = leave(point, normal, way[k].direction);
    radiance = vec_add(radiance, vec_scale(trace(s, most, way[k].type, next, weight * share, depth + 1), share));
  }
  return radiance;
}
/* [end] */

/* Makes the picture, one ray through the middle of each pixel, by blocks of 8 x 8 pixels. */
static course_picture make_picture(const picture_scene *s, limits most) {
  course_picture picture = course_picture_make(WIDTH, HEIGHT);
  for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
    const uint32_t block = i / 64;
    const uint32_t x = block % (WIDTH / 8) * 8 + i % 8;
    const uint32_t y = block / (WIDTH / 8) * 8 + i / 8 % 8;
    const course_ray ray = course_camera_ray((float)x + 0.5f, (float)y + 0.5f, WIDTH, HEIGHT);
    if (i % 64 == 0) record_block(&rays);
    picture.pixel[y * WIDTH + x] = trace(s, most, PKTRT_RAY_PRIMARY, ray, 1, 0);
  }
  record_block(&rays);
  return picture;
}

#ifndef COURSE_CHECK
/* Returns the largest difference of two pixels in a channel. */
static float difference(vec a, vec b) {
  const vec apart = vec_sub(a, b);
  return fmaxf(fabsf(apart.at[0]), fmaxf(fabsf(apart.at[1]), fabsf(apart.at[2])));
}

/* Prints how a picture differs from another one: the largest difference, pixels beyond 1/1000, the largest elsewhere. */
static void compare(const course_picture *a, const course_picture *b) {
  float largest = 0, elsewhere = 0;
  uint32_t far_off = 0;
  for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
    const float apart = difference(a->pixel[i], b->pixel[i]);
    largest = fmaxf(largest, apart);
    if (apart > 0.001f) far_off++;
    else elsewhere = fmaxf(elsewhere, apart);
  }
  printf("  largest difference %.3f; %u pixels differ by more than 0.001, the others by at most %.6f\n", (double)largest,
      (unsigned)far_off, (double)elsewhere);
}

/* Writes two pictures side by side. */
static void write_both(const course_picture *left, const course_picture *right, const char *path) {
  course_picture both = course_picture_make(2 * WIDTH, HEIGHT);
  for (uint32_t y = 0; y < HEIGHT; y++) {
    memcpy(&both.pixel[2 * WIDTH * y], &left->pixel[WIDTH * y], WIDTH * sizeof(vec));
    memcpy(&both.pixel[2 * WIDTH * y + WIDTH], &right->pixel[WIDTH * y], WIDTH * sizeof(vec));
  }
  course_picture_write(&both, path);
}

int main(void) {
  picture_scene scene = picture_make();
  pktrt_scene *library = picture_library(&scene);
  limits most = {1.0f / 256, 50};
  course_picture theirs = course_picture_make(WIDTH, HEIGHT);
  pktrt_stats stats;
  memset(&stats, 0, sizeof stats);

  const course_picture mine = make_picture(&scene, most);
  picture_render(&scene, library, &theirs, most.cutoff, most.depth, &stats);
  write_both(&mine, &theirs, "out/course/11_picture.png");
  printf("11_picture: %u pixels, %u triangles\n", WIDTH * HEIGHT, (unsigned)scene.triangles.triangles);
  compare(&mine, &theirs);

  printf("rays:           primary     shadow  reflected  refracted\n");
  record_print(&rays, "mine", 0, RECORD_DEPTH);
  printf("  library  ");
  for (int type = 0; type < RECORD_TYPES; type++) printf(" %10u", (unsigned)stats.by_type[type].rays);
  printf("\nby depth:\n");
  for (uint32_t depth = 0; depth < 6; depth++) {
    const char name[2] = {(char)('0' + depth), 0};
    record_print(&rays, name, depth, depth);
  }
  record_print(&rays, "6 to 10", 6, 10);
  record_print(&rays, "11 to 50", 11, RECORD_DEPTH);
  printf("spread in degrees:");
  for (int row = 0; row <= RECORD_TYPES; row++) printf(" %.2f", rays.angle[row] / rays.all_rays[row] * 57.29578);
  printf(" (the last: all types together)\nin glass %u meetings with the surface, %u of them total reflections\n",
      (unsigned)rays.inside, (unsigned)rays.total);

  for (int cut = 0; cut < 6; cut++) {
    const limits other = {cut < 2 ? 0 : cut < 3 ? 1.0f / 4096 : cut < 4 ? 1.0f/256: cut < 5 ? 1.0f / 64 : 1.0f / 16, cut < 1 ? 12 : cut < 2 ? 16 : 50};
    memset(&rays, 0, sizeof rays);
    const course_picture p = make_picture(&scene, other);
    uint64_t sum=0; uint32_t deepest = 0;
    for (int t = 0; t < 4; t++) sum += record_count(&rays, t, 0, RECORD_DEPTH);
    for (uint32_t d = 0; d <= RECORD_DEPTH; d++) if (rays.count[2][d] + rays.count[3][d]) deepest = d;
    printf("cut %g depth %u: %u rays deepest %u\n", (double)other.cutoff, other.depth, (unsigned)sum, deepest);
    picture_render(&scene, library, &theirs, -1, 16, &stats);
    compare(&p, &theirs);
  }

  memset(&rays, 0, sizeof rays);
  rays.keep = true;
  most.cutoff = 1.0f / 32;
  int px = getenv("PX") ? atoi(getenv("PX")) : 220, py = getenv("PY") ? atoi(getenv("PY")) : 190;
  trace(&scene, most, PKTRT_RAY_PRIMARY, course_camera_ray((float)px + 0.5f, (float)py + 0.5f, WIDTH, HEIGHT), 1, 0);
  printf("tree %u\n", rays.nodes);
  if (!record_draw(&rays, &scene, "out/course/11_tree.svg")) return 1;
  pktrt_scene_destroy(library);
  return 0;
}
#endif
