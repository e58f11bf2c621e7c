/* section.h - the scene from the side or from above, as chapters 3 and 5 draw it: z runs to the left. Boxes, rays and
   the cut of a plane of constant x. */
#ifndef SECTION_H
#define SECTION_H

#include "../svg.h"
#include "course.h"

typedef struct section {
  svg *to;
  int up;                /* the axis that points up: 1 from the side, 0 from above */
  double z, low, bottom; /* z at the left border; what the lower border is in the world, and in pixels */
  double unit;           /* pixels per unit of the world */
} section;

/* Begins a panel of a drawing, with its upper left corner at (x, y): what reaches out of it is cut off. */
EX_UNUSED static section section_begin(
    svg *to, int up, double z, double low, double unit, double x, double y, double width, double height) {
  const section s = {to, up, z, low, height, unit};
  fprintf(to->file, "<svg x=\"%g\" y=\"%g\" width=\"%g\" height=\"%g\">\n", x, y, width, height);
  return s;
}
EX_UNUSED static void section_end(const section *s) { fprintf(s->to->file, "</svg>\n"); }

static double section_u(const section *s, const float p[3]) { return (s->z - (double)p[2]) * s->unit; }
static double section_v(const section *s, const float p[3]) {
  return s->bottom - ((double)p[s->up] - s->low) * s->unit;
}

EX_UNUSED static void section_box(
    const section *s, const float lo[3], const float hi[3], const char *fill, const char *line) {
  svg_box(s->to, section_u(s, lo), section_v(s, lo), section_u(s, hi), section_v(s, hi), fill, line);
}

/* A ray as far as t. */
EX_UNUSED static void section_ray(const section *s, course_ray ray, float t, const char *colour, double width) {
  const vec end = vec_add(ray.origin, vec_scale(ray.direction, t));
  svg_ray(s->to, section_u(s, ray.origin.at), section_v(s, ray.origin.at), section_u(s, end.at), section_v(s, end.at),
      colour, width);
}

/* The lines in which the plane of this x cuts the scene. */
EX_UNUSED static void section_scene(const section *s, const course_scene *scene, float x) {
  for (uint32_t i = 0; i < scene->triangles; i++) {
    vec cut[3];
    int n = 0;
    for (int c = 0; c < 3; c++) {
      const vec p = scene->position[scene->corner[i][c]], q = scene->position[scene->corner[i][(c + 1) % 3]];
      if ((p.at[0] < x) == (q.at[0] < x)) continue;
      cut[n++] = vec_add(p, vec_scale(vec_sub(q, p), (x - p.at[0]) / (q.at[0] - p.at[0])));
    }
    if (n == 2)
      svg_line(s->to, section_u(s, cut[0].at), section_v(s, cut[0].at), section_u(s, cut[1].at),
          section_v(s, cut[1].at), "#000", 1.2);
  }
}

#endif /* SECTION_H */
