/* 12_mapping.h - what program, exercise and check of chapter 12 share: mappings of the unit square that are not careful,
   and measures of what a mapping does to the samples of a packet. */
#ifndef MAPPING_H
#define MAPPING_H

#include "course.h"

/* The exercise. */
void disk_of(const float u[2], float out[2]);
float lobe_above(const float u[2], const float axis[3], const float normal[3], float exponent, float out[3]);

/* What maps a sample to a direction around a unit axis, above a surface with a unit normal. Sets `out` to the direction,
   of unit length, and returns the ray's weight; 0: the ray is lost. */
typedef float lobe_mapping(const float u[2], const float axis[3], const float normal[3], float exponent, float out[3]);

/* Prints the figure `name.kind.what`. */
EX_UNUSED static void mapping_figure(
    const char *name, const char *kind, const char *what, const char *format, double value) {
  char full_name[64];
  snprintf(full_name, sizeof full_name, "%s.%s.%s", name, kind, what);
  course_figure(full_name, format, value);
}

/* >>frame ---------------------------------------------------------------------------------------------------------- */

EX_UNUSED static double mapping_dot(const float a[3], const float b[3]) {
  return (double)a[0] * (double)b[0] + (double)a[1] * (double)b[1] + (double)a[2] * (double)b[2];
}

/* Sets `side` and `up` to unit vectors that are perpendicular to the unit axis and to each other. `side` lies in the
   surface with this normal. */
EX_UNUSED static void mapping_frame(const float axis[3], const float normal[3], float side[3], float up[3]) {
  const vec a = vec_make(axis[0], axis[1], axis[2]);
  vec across = vec_cross(vec_make(normal[0], normal[1], normal[2]), a);

  /* If the axis is the normal, any vector across the axis is in the surface. */
  if (vec_dot(across, across) < 1e-8f)
    across = vec_cross(fabsf(axis[0]) < 0.5f ? vec_make(1, 0, 0) : vec_make(0, 1, 0), a);

  const vec unit = vec_unit(across);
  const vec other = vec_cross(a, unit);
  memcpy(side, unit.at, sizeof unit.at);
  memcpy(up, other.at, sizeof other.at);
}

/* Sets a normal, and an axis that is so many degrees off the normal. */
EX_UNUSED static void mapping_slanted(float degrees, float axis[3], float normal[3]) {
  const double angle = (double)degrees * COURSE_TURN / 360;

  for (int k = 0; k < 3; k++) normal[k] = k == 1 ? 1.0f : 0.0f;
  axis[0] = (float)sin(angle);
  axis[1] = (float)cos(angle);
  axis[2] = 0;
}

/* Moves the origin of a ray to just above the surface that the ray hits. Sets the surface's normal, on the ray's side, and
   the axis of the lobe: the direction in which a mirror reflects the ray. */
EX_UNUSED static void mapping_reflect(
    const course_scene *s, course_ray *ray, const course_hit *hit, vec *normal, vec *axis) {
  const uint32_t *corner = s->corner[hit->triangle];
  const vec p0 = s->position[corner[0]];
  const vec edge = vec_sub(s->position[corner[1]], p0);
  const vec other = vec_sub(s->position[corner[2]], p0);
  const vec across = vec_unit(vec_cross(edge, other));
  const vec to = vec_unit(ray->direction);

  *normal = vec_dot(across, to) > 0 ? vec_scale(across, -1) : across;
  *axis = vec_unit(vec_sub(to, vec_scale(*normal, 2 * vec_dot(to, *normal))));
  ray->origin = vec_add(ray->origin, vec_add(vec_scale(ray->direction, hit->t), vec_scale(*normal, 1e-3f)));
}

/* >>mappings that are not careful ---------------------------------------------------------------------------------- */

/* Maps the square to the unit disk: u[0] gives the radius, u[1] the angle. */
EX_UNUSED static void disk_polar(const float u[2], float out[2]) {
  const double radius = sqrt((double)u[0]);
  const double angle = COURSE_TURN * (double)u[1];

  out[0] = (float)(radius * cos(angle));
  out[1] = (float)(radius * sin(angle));
}

/* Maps the square to a Phong lobe as in textbooks: the cosine of the angle to the axis is a power of u[0]. */
EX_UNUSED static float lobe_naive(
    const float u[2], const float axis[3], const float normal[3], float exponent, float out[3]) {
  /* [naive] */
  const double cosine = pow((double)u[0], 1 / ((double)exponent + 1));
  const double sine = sqrt(1 - cosine * cosine);
  const double angle = COURSE_TURN * (double)u[1];
  /* [end] */
  float side[3];
  float up[3];

  mapping_frame(axis, normal, side, up);
  for (int k = 0; k < 3; k++) {
    const double across = cos(angle) * (double)side[k] + sin(angle) * (double)up[k];
    out[k] = (float)(cosine * (double)axis[k] + sine * across);
  }

  return mapping_dot(out, normal) > 0 ? 1 : 0;
}

/* Returns weight 0 for directions below the surface, as the library does: these rays are lost. */
EX_UNUSED static float lobe_thrown_away(
    const float u[2], const float axis[3], const float normal[3], float exponent, float out[3]) {
  pktrt_map_phong(u, axis, exponent, out);
  return mapping_dot(out, normal) > 0 ? 1 : 0;
}

/* Takes another point of the square as long as the direction is below the surface. Returns weight 1; or 0 if 64 points
   are below. */
EX_UNUSED static float lobe_retried(
    const float u[2], const float axis[3], const float normal[3], float exponent, float out[3]) {
  float point[2] = {u[0], u[1]};

  for (int i = 0; i < 64; i++) {
    pktrt_map_phong(point, axis, exponent, out);
    if (mapping_dot(out, normal) > 0) return 1;
    for (int k = 0; k < 2; k++) {
      const float next = point[k] + (k == 0 ? 0.75487767f : 0.56984029f);
      point[k] = next - floorf(next);
    }
  }

  return 0;
}

/* Mirrors directions below the surface in the surface. Returns weight 1, which is wrong. */
EX_UNUSED static float lobe_folded(
    const float u[2], const float axis[3], const float normal[3], float exponent, float out[3]) {
  pktrt_map_phong(u, axis, exponent, out);
  const float height = (float)mapping_dot(out, normal);
  for (int k = 0; k < 3 && height < 0; k++) out[k] -= 2 * height * normal[k];
  return 1;
}

/* >>grids and packets ---------------------------------------------------------------------------------------------- */

/* The samples of the figures: the centres of 32 x 32 equal cells of the square. A packet has those of 8 x 8 cells. */
enum { GRID = 32, GRID_SAMPLES = GRID * GRID, BLOCK = 8, PACKET = BLOCK * BLOCK, PACKETS = GRID_SAMPLES / PACKET };

/* Sets u to the centre of the cell in a column and a row of a grid of size x size. */
EX_UNUSED static void mapping_centre(uint32_t column, uint32_t row, uint32_t size, float u[2]) {
  u[0] = ((float)column + 0.5f) / (float)size;
  u[1] = ((float)row + 0.5f) / (float)size;
}

/* Sets u to a sample of a packet. */
EX_UNUSED static void mapping_sample(uint32_t packet, uint32_t sample, float u[2]) {
  const uint32_t column = packet % (GRID / BLOCK) * BLOCK + sample % BLOCK;
  const uint32_t row = packet / (GRID / BLOCK) * BLOCK + sample / BLOCK;
  mapping_centre(column, row, GRID, u);
}

/* Returns the angle between two unit vectors in degrees, exactly also if the vectors are close. */
EX_UNUSED static double mapping_degrees(const float a[3], const float b[3]) {
  double apart = 0;
  for (int k = 0; k < 3; k++) apart += pow((double)a[k] - (double)b[k], 2);
  return 720 / COURSE_TURN * asin(fmin(1, sqrt(apart) / 2));
}

/* What a mapping to the disk does to the grid: the greatest distance within a packet, averaged over packets, and the most;
   and the most between neighbours of a packet. */
typedef struct disk_measure {
  double mean, most, step;
} disk_measure;

/* Returns the measure of a mapping to the disk. */
EX_UNUSED static disk_measure disk_measure_of(void (*mapping)(const float u[2], float out[2])) {
  disk_measure measure = {0, 0, 0};

  for (uint32_t packet = 0; packet < PACKETS; packet++) {
    double size = 0;

    for (uint32_t i = 0; i < PACKET * PACKET; i++) {
      const uint32_t first = i / PACKET;
      const uint32_t second = i % PACKET;
      float u[2];
      float p[2];
      float q[2];
      mapping_sample(packet, first, u);
      mapping(u, p);
      mapping_sample(packet, second, u);
      mapping(u, q);

      const double apart = hypot((double)p[0] - (double)q[0], (double)p[1] - (double)q[1]);
      const bool neighbours = second == first + BLOCK || (second == first + 1 && second % BLOCK != 0);
      size = fmax(size, apart);
      if (neighbours) measure.step = fmax(measure.step, apart);
    }

    measure.mean += size / PACKETS;
    measure.most = fmax(measure.most, size);
  }

  return measure;
}

/* Prints the measure of a mapping to the disk, with the figures `disk.name` and so on; returns the measure. */
EX_UNUSED static disk_measure disk_measure_print(void (*mapping)(const float u[2], float out[2]), const char *name) {
  const disk_measure m = disk_measure_of(mapping);
  printf("disk, %s: samples of a packet at most %.3f apart (mean), %.3f (the widest packet); neighbours %.3f\n", name,
      m.mean, m.most, m.step);
  mapping_figure("disk", name, "mean", "%.3f", m.mean);
  mapping_figure("disk", name, "most", "%.3f", m.most);
  mapping_figure("disk", name, "step", "%.3f", m.step);
  return m;
}

/* What a mapping does to a grid of samples, all of which leave one point of a surface. */
typedef struct lobe_measure {
  uint32_t active; /* rays that are not lost */
  uint32_t least;  /* of them in a packet, at least */
  double cone,
      widest;  /* degrees: greatest angle of a packet's active rays to their mean, averaged over packets; the most */
  double step; /* degrees: the most between neighbours of the grid that both are active */
} lobe_measure;

/* Returns the greatest angle, in degrees, of the active ones of n directions to the mean of these. */
EX_UNUSED static double mapping_cone(float direction[][3], const float *weight, uint32_t n) {
  vec mean = {{0, 0, 0}};
  double angle = 0;

  for (uint32_t i = 0; i < n; i++)
    for (int k = 0; k < 3 && weight[i] > 0; k++) mean.at[k] += direction[i][k];
  if (!(vec_dot(mean, mean) > 0)) return 0;

  const vec middle = vec_unit(mean);
  for (uint32_t i = 0; i < n; i++)
    if (weight[i] > 0) angle = fmax(angle, mapping_degrees(direction[i], middle.at));
  return angle;
}

/* Returns the measure of a mapping. */
EX_UNUSED static lobe_measure lobe_measure_of(
    lobe_mapping *mapping, const float axis[3], const float normal[3], float exponent) {
  lobe_measure measure = {0, PACKET, 0, 0, 0};
  float direction[PACKET][3];
  float weight[PACKET];

  for (uint32_t packet = 0; packet < PACKETS; packet++) {
    uint32_t active = 0;

    for (uint32_t i = 0; i < PACKET; i++) {
      float u[2];
      mapping_sample(packet, i, u);
      weight[i] = mapping(u, axis, normal, exponent, direction[i]);
      active += weight[i] > 0;
    }

    const double cone = mapping_cone(direction, weight, PACKET);
    measure.active += active;
    if (active < measure.least) measure.least = active;
    measure.cone += cone / PACKETS;
    measure.widest = fmax(measure.widest, cone);
  }

  for (uint32_t i = 0; i < GRID_SAMPLES; i++) {
    float u[2];
    float here[3];
    mapping_centre(i % GRID, i / GRID, GRID, u);
    if (!(mapping(u, axis, normal, exponent, here) > 0)) continue;

    for (int next = 0; next < 2; next++) {
      const uint32_t column = i % GRID + (next == 0);
      const uint32_t row = i / GRID + (next == 1);
      float there[3];
      if (column == GRID || row == GRID) continue;
      mapping_centre(column, row, GRID, u);
      if (mapping(u, axis, normal, exponent, there) > 0)
        measure.step = fmax(measure.step, mapping_degrees(here, there));
    }
  }

  return measure;
}

/* Prints the measure of a mapping for an axis that is so many degrees off the normal; returns the measure. */
EX_UNUSED static lobe_measure lobe_measure_print(lobe_mapping *mapping, float degrees, float exponent) {
  float axis[3];
  float normal[3];
  mapping_slanted(degrees, axis, normal);

  const lobe_measure m = lobe_measure_of(mapping, axis, normal, exponent);
  printf("%u of %d rays active, at least %u of a packet; cones %.1f degrees, the widest %.1f; neighbours %.1f\n",
      (unsigned)m.active, GRID_SAMPLES, (unsigned)m.least, m.cone, m.widest, m.step);
  return m;
}

/* The tests of a ray, on average. */
typedef struct mapping_tests {
  double boxes, triangles;
} mapping_tests;

/* Traces packets of 64 on the paper's path. Prints tests per ray, and returns them. */
EX_UNUSED static mapping_tests mapping_trace(const pktrt_scene *library, const course_ray *rays, uint32_t n) {
  pktrt_stats *stats = (pktrt_stats *)course_memory(1, sizeof *stats);
  const pktrt_query_desc query = {.path = PKTRT_PATH_PAPER, .packet_size = PACKET, .stats = stats};
  pktrt_ray *ray = (pktrt_ray *)course_memory(n, sizeof *ray);
  pktrt_hit *hit = (pktrt_hit *)course_memory(n, sizeof *hit);
  for (uint32_t i = 0; i < n; i++) ray[i] = course_library_ray(rays[i]);
  pktrt_intersect_ex(library, &query, ray, hit, n);

  const pktrt_counts *count = &stats->by_type[PKTRT_RAY_PRIMARY];
  const mapping_tests tests = {(double)count->box_tests / n, (double)count->triangle_tests / n};
  printf("%.2f boxes and %.2f triangles tested per ray\n", tests.boxes, tests.triangles);
  return tests;
}

#endif
