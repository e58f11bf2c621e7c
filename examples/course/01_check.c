/* Checks exercise 1: shadows of two lights, one above all and one amid things, are those of the library. Makes
   out/course/01_shadows.png.    make course-check N=1 FILE=mine_01.c */
#define PKTRT_IMPLEMENTATION
#include "course.h"

bool in_shadow(const course_scene *scene, vec point, vec normal, vec light); /* the exercise */

enum { WIDTH = 192, HEIGHT = 144 };

typedef struct lamp {
  vec at, colour;
} lamp;

/* What a surface gets of a light, as the answer has it; where that is not the library's, the tally knows. `pixel` is
   what sees it. */
static vec light_of(const course_scene *s, const pktrt_scene *library, const lamp *l, vec point, vec normal,
    uint32_t pixel, course_tally *tally) {
  const vec way = vec_sub(l->at, point);
  const float cosine = vec_dot(normal, way) / sqrtf(vec_dot(way, way));
  if (cosine < 0) normal = vec_scale(normal, -1);
  const vec start = vec_add(point, vec_scale(normal, 0.001f));
  const course_ray ray = {start, vec_sub(l->at, start), 0, 1};
  const bool mine = in_shadow(s, point, normal, l->at);
  if (!course_same_occlusion(s, ray, mine, course_library_occluded(library, ray), tally) && tally->different == 1)
    printf("  the point: (%.7g, %.7g, %.7g), in column %u and row %u of the picture\n", (double)point.at[0],
        (double)point.at[1], (double)point.at[2], (unsigned)pixel % WIDTH, (unsigned)pixel / WIDTH);
  return vec_scale(l->colour, mine ? 0 : fmaxf(cosine, 0) / vec_dot(way, way));
}

/* All that the camera sees, as one light shows it; whether shadows are where they are in the library. */
static bool try_lamp(const course_scene *s, const pktrt_scene *library, const lamp *l, vec *pixel) {
  course_tally tally = {0, 0, 0};
  for (uint32_t i = 0; i < WIDTH * HEIGHT; i++) {
    const course_ray ray = course_camera_ray((float)(i % WIDTH) + 0.5f, (float)(i / WIDTH) + 0.5f, WIDTH, HEIGHT);
    const course_hit hit = course_library_hit(library, ray);
    if (hit.triangle == COURSE_NONE) continue;
    const uint32_t *c = s->corner[hit.triangle];
    const vec p0 = s->position[c[0]],
              across = vec_cross(vec_sub(s->position[c[1]], p0), vec_sub(s->position[c[2]], p0));
    const vec normal = vec_scale(vec_unit(across), vec_dot(across, ray.direction) > 0 ? -1 : 1);
    const vec point = vec_add(ray.origin, vec_scale(ray.direction, hit.t));
    pixel[i] = vec_add(pixel[i], light_of(s, library, l, point, normal, i, &tally));
  }
  course_tally_print(&tally);
  return tally.different == 0;
}

int main(void) {
  static const lamp above = {{{3, 9, 2}}, {{60, 55, 45}}}, amid = {{{0.1f, 1.5f, 0.8f}}, {{0.6f, 0.9f, 1.6f}}};
  course_check_begins(1);
  const course_scene scene = course_scene_make();
  pktrt_scene *library = course_library(&scene);
  const course_picture picture = course_picture_make(WIDTH, HEIGHT);
  printf("a light above all:\n");
  bool good = try_lamp(&scene, library, &above, picture.pixel);
  printf("a light amid things:\n");
  good = try_lamp(&scene, library, &amid, picture.pixel) && good;
  course_picture_write(&picture, "out/course/01_shadows.png");
  pktrt_scene_destroy(library);
  return course_result(1, good ? NULL : "shadows are not those of the library");
}
