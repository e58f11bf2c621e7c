/* 14_draw.h - the pictures of chapter 14: the scene in motion, charts with curves, a triangle that turns with its
   boxes. */
#ifndef COURSE_14_DRAW_H
#define COURSE_14_DRAW_H

#include "../svg.h"
#include "14_motion.h"

/* Where a chart stands in a drawing, and the largest values of its axes, which begin at 0. */
typedef struct chart_area {
  svg *to;
  double left, top, width, height, most_x, most_y;
} chart_area;

/* Return where a value stands in the drawing. */
static double chart_x(const chart_area *chart, double x) { return chart->left + chart->width * x / chart->most_x; }
static double chart_y(const chart_area *chart, double y) {
  return chart->top + chart->height * (1 - y / chart->most_y);
}

/* Draws the frame, a line for each step of either axis with its number, and the names of chart and axis. */
EX_UNUSED static void chart_frame(
    const chart_area *chart, double step_x, double step_y, const char *name, const char *axis) {
  const double right = chart->left + chart->width, bottom = chart->top + chart->height;

  for (double y = 0; y < chart->most_y * 1.001; y += step_y) {
    svg_line(chart->to, chart->left, chart_y(chart, y), right, chart_y(chart, y), "#ddd", 1);
    svg_text(chart->to, chart->left - 6, chart_y(chart, y) + 4, 12, SVG_RIGHT, "%g", y);
  }

  for (double x = 0; x < chart->most_x * 1.001; x += step_x) {
    svg_line(chart->to, chart_x(chart, x), chart->top, chart_x(chart, x), bottom, "#eee", 1);
    svg_text(chart->to, chart_x(chart, x), bottom + 16, 12, SVG_MIDDLE, "%g", x);
  }

  svg_text(chart->to, chart->left, chart->top - 10, 14, SVG_LEFT, "%s", name);
  svg_text(chart->to, right, bottom + 34, 12, SVG_RIGHT, "%s", axis);
}

/* Draws a curve through n values whose x are spread evenly over the axis, and its name beside its end, moved down by
   `shift`. */
EX_UNUSED static void chart_curve(
    const chart_area *chart, const double *value, int n, const char *colour, const char *name, double shift) {
  const double end = chart_x(chart, chart->most_x);

  for (int i = 0; i < n; i++) {
    const double x = chart_x(chart, chart->most_x * i / (n - 1));
    const double before = chart_x(chart, chart->most_x * (i - 1) / (n - 1));
    if (i) svg_line(chart->to, before, chart_y(chart, value[i - 1]), x, chart_y(chart, value[i]), colour, 2);
    svg_dot(chart->to, x, chart_y(chart, value[i]), 3, colour);
  }

  svg_text(chart->to, end + 8, chart_y(chart, value[n - 1]) + 4 + shift, 12, SVG_LEFT, "%s", name);
}

/* Draws a triangle of the plane, and the box from lo to hi. */
static void draw_triangle(svg *to, const double p[3][2], const char *colour, double width) {
  for (int i = 0; i < 3; i++) svg_line(to, p[i][0], p[i][1], p[(i + 1) % 3][0], p[(i + 1) % 3][1], colour, width);
}

/* Stores a triangle at a time while it flies to the right and turns: at a key by its angle, in between along lines. */
static void draw_pose(double time, double p[3][2]) {
  for (int i = 0; i < 3; i++) {
    const double from = COURSE_TURN * (i / 3.0 + 0.04), to = from + COURSE_TURN / 4;
    const double size = i ? 75 : 95;
    p[i][0] = (1 - time) * (110 + size * cos(from)) + time * (520 + size * cos(to));
    p[i][1] = (1 - time) * (205 + size * sin(from)) + time * (130 + size * sin(to));
  }
}

/* Stores the box of a triangle: the lower corner, then the upper one. */
static void draw_box(const double p[3][2], double box[4]) {
  for (int axis = 0; axis < 2; axis++) {
    box[axis] = fmin(p[0][axis], fmin(p[1][axis], p[2][axis]));
    box[2 + axis] = fmax(p[0][axis], fmax(p[1][axis], p[2][axis]));
  }
}

/* Draws a triangle at both keys and at time 1/2, the ways of its corners, and its boxes. */
EX_UNUSED static bool draw_boxes(const char *path) {
  svg drawing;
  double pose[3][3][2], box[3][4], between[4];
  if (!svg_begin(&drawing, path, 660, 300)) return false;

  for (int k = 0; k < 3; k++) {
    draw_pose(k / 2.0, pose[k]);
    draw_box((const double(*)[2])pose[k], box[k]);
  }

  for (int i = 0; i < 4; i++) between[i] = (box[0][i] + box[2][i]) / 2;

  svg_box(&drawing, fmin(box[0][0], box[2][0]), fmin(box[0][1], box[2][1]), fmax(box[0][2], box[2][2]),
      fmax(box[0][3], box[2][3]), "#fbecec", "#c33");
  svg_box(&drawing, between[0], between[1], between[2], between[3], "#dcebfa", "#06c");
  for (int k = 0; k < 3; k += 2) svg_box(&drawing, box[k][0], box[k][1], box[k][2], box[k][3], "#fff", "#06c");
  for (int i = 0; i < 3; i++) svg_line(&drawing, pose[0][i][0], pose[0][i][1], pose[2][i][0], pose[2][i][1], "#999", 1);
  svg_box(&drawing, box[1][0], box[1][1], box[1][2], box[1][3], NULL, "#393");
  for (int k = 0; k < 3; k++) draw_triangle(&drawing, (const double(*)[2])pose[k], "#000", 2);

  svg_text(&drawing, box[0][0], box[0][3] + 18, 13, SVG_LEFT, "key 0");
  svg_text(&drawing, box[2][2], box[2][1] - 7, 13, SVG_RIGHT, "key 1");
  svg_text(&drawing, (between[0] + between[2]) / 2, between[3] + 17, 13, SVG_MIDDLE, "blue: interpolated, at time 1/2");
  svg_text(&drawing, (between[0] + between[2]) / 2, between[1] - 8, 13, SVG_MIDDLE,
      "green: around the triangle, at time 1/2");
  svg_text(&drawing, box[2][2], box[0][3] + 18, 13, SVG_RIGHT, "red: the whole time");
  return svg_end(&drawing);
}

enum { PANEL_X = 220, PANEL_Y = 165, SAMPLES = 32 };

/* Returns a ray of the library through a place of a picture, at a time. */
static pktrt_ray draw_aim(float x, float y, uint32_t width, uint32_t height, float time) {
  pktrt_ray ray = course_library_ray(course_camera_ray(x, y, width, height));
  ray.time = time;
  return ray;
}

/* Returns the colour that a ray sees: mesh 0 moves, mesh 1 is the ground; a lamp far away throws shadows. */
static vec draw_look(const pktrt_scene *library, const pktrt_ray *ray) {
  static const vec colour[3] = {{{0.8f, 0.2f, 0.1f}}, {{0.9f, 0.6f, 0.1f}}, {{0.15f, 0.35f, 0.7f}}};
  const vec lamp = vec_unit(vec_make(-0.4f, 0.8f, 0.45f)), ground = {{0.55f, 0.53f, 0.5f}}, sky = {{0.7f, 0.8f, 0.9f}};
  pktrt_hit hit;
  pktrt_ray shadow;
  if (!pktrt_intersect(library, ray, &hit)) return sky;

  const vec normal = {{hit.normal[0], hit.normal[1], hit.normal[2]}};
  const int thing = hit.triangle < 2 * 96 * 8 ? 0 : hit.triangle < 2 * (96 * 8 + 28 * 14) ? 1 : 2;
  float light = fmaxf(0, vec_dot(normal, lamp));
  pktrt_spawn(library, ray, &hit, lamp.at, &shadow);
  if (light > 0 && pktrt_occluded(library, &shadow)) light = 0;
  return vec_scale(hit.mesh ? ground : colour[thing], 0.3f + 0.7f * light);
}

/* Makes the picture: at times 0, 1/2 and 1, and with the shutter open from 0 to 1. */
EX_UNUSED static void draw_picture(const char *path) {
  course_picture all = course_picture_make(2 * PANEL_X, 2 * PANEL_Y);
  const course_scene ground = course_scene_make();
  const pktrt_mesh_desc mesh = {.positions = ground.position[0].at,
      .vertex_count = ground.vertices,
      .indices = ground.corner[0],
      .triangle_count = COURSE_GROUND};
  const motion_scene things = motion_things(COURSE_TURN / 6);
  pktrt_scene *library = pktrt_scene_create(NULL);
  motion_add(library, &things);
  if (pktrt_add_mesh(library, &mesh, NULL) || pktrt_commit(library)) exit(1);

  for (uint32_t i = 0; i < all.width * all.height; i++) {
    const uint32_t x = i % all.width, y = i / all.width, panel = x / PANEL_X + y / PANEL_Y * 2;
    vec sum = {{0, 0, 0}};

    for (int k = 0; k < SAMPLES; k++) {
      const float time = panel < 3 ? 0.5f * (float)panel : ((float)k + 0.5f) / SAMPLES;
      const float dx = 0.125f + 0.25f * (float)(k % 4), dy = 0.125f + 0.25f * (float)(k / 4 % 4);
      const pktrt_ray ray = draw_aim((float)(x % PANEL_X) + dx, (float)(y % PANEL_Y) + dy, PANEL_X, PANEL_Y, time);
      sum = vec_add(sum, draw_look(library, &ray));
    }

    /* Forty shades of each colour make a small file. */
    for (int c = 0; c < 3; c++) {
      const float shade = floorf(40 * sqrtf(sum.at[c] / SAMPLES) + 0.5f) / 40;
      all.pixel[i].at[c] = shade * shade;
    }
  }

  printf("picture: %d rays for each pixel; the knot turns by %.0f degrees\n", SAMPLES, 360.0 / 6);
  course_picture_write(&all, path);
  pktrt_scene_destroy(library);
}

#endif /* COURSE_14_DRAW_H */
