/* section.h - the scene cut by a plane of constant x, as chapters 3 and 5 draw it: z runs to the left, y up. */
#ifndef SECTION_H
#define SECTION_H

#include "../svg.h"
#include "course.h"

typedef struct section {
  svg to;
  float x;           /* of the plane */
  double z, y, unit; /* world coordinates of the lower left corner, pixels per unit */
  double height;
} section;

static double section_u(const section *s, double z) { return (s->z - z) * s->unit; }
static double section_v(const section *s, double y) { return s->height - (y - s->y) * s->unit; }

/* Begins a drawing; the program ends if it cannot be written. */
EX_UNUSED static section section_begin(const char *path, float x, double z0, double z1, double y0, double y1,
                                       double unit) {
  section s;
  course_make_folder();
  s.x = x, s.z = z0, s.y = y0, s.unit = unit, s.height = (y1 - y0) * unit;
  if (!svg_begin(&s.to, path, (z0 - z1) * unit, s.height)) exit(1);
  return s;
}
EX_UNUSED static void section_end(section *s) {
  if (!svg_end(&s->to)) exit(1);
}

EX_UNUSED static void section_box(section *s, const float lo[3], const float hi[3], const char *fill,
                                  const char *line) {
  svg_box(&s->to, section_u(s, (double)lo[2]), section_v(s, (double)lo[1]), section_u(s, (double)hi[2]),
          section_v(s, (double)hi[1]), fill, line);
}

/* The segments in which the plane cuts the triangles. */
EX_UNUSED static void section_scene(section *s, const course_scene *scene) {
  for (uint32_t i = 0; i < scene->triangles; i++) {
    double u[3], v[3];
    int n = 0;
    for (int c = 0; c < 3; c++) {
      const float *p = scene->position[scene->corner[i][c]].at, *q = scene->position[scene->corner[i][(c + 1) % 3]].at;
      if ((p[0] < s->x) == (q[0] < s->x)) continue;
      const double k = (double)((s->x - p[0]) / (q[0] - p[0]));
      u[n] = section_u(s, (double)p[2] + k * (double)(q[2] - p[2]));
      v[n++] = section_v(s, (double)p[1] + k * (double)(q[1] - p[1]));
    }
    if (n == 2) svg_line(&s->to, u[0], v[0], u[1], v[1], "#000", 1.2);
  }
}

/* A ray as far as t. */
EX_UNUSED static void section_ray(section *s, course_ray ray, float t, const char *colour, double width) {
  const vec end = vec_add(ray.origin, vec_scale(ray.direction, t));
  svg_ray(&s->to, section_u(s, (double)ray.origin.at[2]), section_v(s, (double)ray.origin.at[1]),
          section_u(s, (double)end.at[2]), section_v(s, (double)end.at[1]), colour, width);
}

#endif /* SECTION_H */
