/* Chapter 12: samples of neighbouring pixels, and mappings of the unit square to a lens and to a lobe.

   Prints counts; makes out/course/12_interleaved.png and 12_points.svg. */
#define PKTRT_IMPLEMENTATION
#include "course.h"
#include "12_mapping.h"
#include "12_drawing.h"

enum { WIDTH = 192, STRIP = 32, ENLARGED = 3, SAME = PKTRT_SAMPLER_COUNT };

/* Returns a coordinate of a sample of a pixel. SAME: a Sobol' point, the same for all pixels. */
static float draw(int sampler, uint32_t samples, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension) {
  const pktrt_sampling sampling = {(pktrt_sampler)(sampler == SAME ? PKTRT_SAMPLER_SOBOL : sampler), samples, 1};
  float u;
  pktrt_sample(&sampling, sampler == SAME ? 0 : x, sampler == SAME ? 0 : y, sample, dimension, 1, &u);
  return u;
}

/* Renders the edge of a shadow with four samples per pixel: a sample is lit if its coordinate is less than the part of
   the lamp that its column sees. Prints the error of pixels, and of means over 4 x 4 pixels; returns the latter. */
static double edge_of_shadow(course_picture *picture, uint32_t strip, int sampler, const char *name, const char *key) {
  double block[STRIP / 4][WIDTH / 4] = {{0}};
  double squares = 0;
  double block_squares = 0;

  for (uint32_t i = 0; i < WIDTH * STRIP; i++) {
    const uint32_t x = i % WIDTH, y = i / WIDTH;
    const double truth = (x + 0.5) / WIDTH;
    double value = 0;
    for (uint32_t k = 0; k < 4; k++) value += (double)draw(sampler, 4, x, y, k, 0) < truth ? 0.25 : 0;
    squares += pow(value - truth, 2);
    block[y / 4][x / 4] += (value - truth) / 16;

    for (uint32_t e = 0; e < ENLARGED * ENLARGED; e++) {
      const uint32_t row = (strip * STRIP + y) * ENLARGED + e / ENLARGED, column = x * ENLARGED + e % ENLARGED;
      for (int c = 0; c < 3; c++) picture->pixel[row * picture->width + column].at[c] = (float)value;
    }
  }

  for (uint32_t i = 0; i < WIDTH * STRIP / 16; i++) block_squares += pow(block[i * 4 / WIDTH][i % (WIDTH / 4)], 2);
  const double error = sqrt(squares / WIDTH / STRIP);
  const double block_error = sqrt(16 * block_squares / WIDTH / STRIP);
  printf("edge of a shadow, %s: RMSE %.4f of pixels, %.4f of means over 4 x 4 pixels\n", name, error, block_error);
  mapping_figure("edge", key, "pixels", "%.4f", error);
  mapping_figure("edge", key, "means", "%.4f", block_error);
  return block_error;
}

/* Traces one ray through the lens for each pixel of 256 x 192, in packets of 8 x 8 pixels: of neighbours (apart = 1), or
   of every fourth pixel of a row and column (apart = 4). Prints how many origins a packet has, and tests per ray;
   returns the box tests. */
static double lens(const pktrt_scene *library, int sampler, uint32_t apart, const char *name, const char *key) {
  enum { ACROSS = 256, DOWN = 192, RAYS = ACROSS * DOWN };
  static course_ray rays[RAYS];
  const float radius = 0.3f, focus = 7.2f;
  const vec corner = course_camera_ray(0, 0, ACROSS, DOWN).direction;
  const vec right = vec_unit(vec_sub(course_camera_ray(ACROSS, 0, ACROSS, DOWN).direction, corner));
  const vec below = vec_unit(vec_sub(course_camera_ray(0, DOWN, ACROSS, DOWN).direction, corner));
  double origins = 0;

  for (uint32_t i = 0; i < RAYS; i++) {
    const uint32_t packet = i / PACKET, k = i % PACKET, side = 8 * apart;
    const uint32_t block = packet / apart / apart, part = packet % (apart * apart);
    const uint32_t x = block % (ACROSS / side) * side + part % apart + k % 8 * apart;
    const uint32_t y = block / (ACROSS / side) * side + part / apart + k / 8 * apart;
    const float u[2] = {draw(sampler, 1, x, y, 0, 2), draw(sampler, 1, x, y, 0, 3)};
    float point[2];
    pktrt_map_disk(u, point);

    const vec at = vec_add(vec_scale(right, radius * point[0]), vec_scale(below, radius * point[1]));
    rays[i] = course_camera_ray((float)x + 0.5f, (float)y + 0.5f, ACROSS, DOWN);
    rays[i].origin = vec_add(rays[i].origin, at);
    rays[i].direction = vec_sub(rays[i].direction, vec_scale(at, 1 / focus));
    uint32_t before = i - k;
    while (before < i && memcmp(&rays[before].origin, &rays[i].origin, sizeof(vec)) != 0) before++;
    origins += before == i;
  }

  printf("lens, %s, origins per packet: %.0f, ", name, origins * PACKET / RAYS);
  const mapping_tests tests = mapping_trace(library, rays, RAYS);
  mapping_figure("lens", key, "origins", "%.0f", origins * PACKET / RAYS);
  mapping_figure("lens", key, "boxes", "%.2f", tests.boxes);
  return tests.boxes;
}

/* Sends a ray off each surface that the camera sees, all by the origin of the square. Prints tests per ray, and
   returns them. */
static mapping_tests off_surfaces(const course_scene *s, lobe_mapping *mapping, const char *name, const char *key) {
  enum { ACROSS = 128, DOWN = 96 };
  static course_ray rays[ACROSS * DOWN];
  static const float origin[2] = {0, 0};
  pktrt_scene *library = course_library(s);
  double cosine = 0;
  uint32_t n = 0;

  for (uint32_t i = 0; i < ACROSS * DOWN; i++) {
    const uint32_t packet = i / PACKET, k = i % PACKET;
    const uint32_t x = packet % (ACROSS / 8) * 8 + k % 8, y = packet / (ACROSS / 8) * 8 + k / 8;
    course_ray ray = course_camera_ray((float)x + 0.5f, (float)y + 0.5f, ACROSS, DOWN);
    const course_hit hit = course_library_hit(library, ray);
    if (hit.triangle == COURSE_NONE) continue;
    vec normal, axis;
    mapping_reflect(s, &ray, &hit, &normal, &axis);
    mapping(origin, axis.at, normal.at, 100, ray.direction.at);
    cosine += fabs(mapping_dot(ray.direction.at, normal.at));
    rays[n++] = ray;
  }

  printf("origin of the square, %s: mean cosine to the normal %.3f, ", name, cosine / n);
  const mapping_tests tests = mapping_trace(library, rays, n);
  mapping_figure("origin", key, "cosine", "%.3f", cosine / n);
  mapping_figure("origin", key, "boxes", "%.2f", tests.boxes);
  mapping_figure("origin", key, "triangles", "%.2f", tests.triangles);
  pktrt_scene_destroy(library);
  return tests;
}

/* Prints what becomes of the samples of a lobe whose axis is off the normal. */
static void lobes(float degrees, float exponent) {
  static lobe_mapping *const mapping[] = {lobe_thrown_away, lobe_retried, lobe_folded};
  static const char *const name[] = {"thrown away", "retried", "folded"};
  static const char *const key[] = {"thrown-away", "retried", "folded"};
  for (int i = 0; i < 3; i++) {
    printf("axis %g degrees off the normal, exponent %g, %s: ", (double)degrees, (double)exponent, name[i]);
    const lobe_measure m = lobe_measure_print(mapping[i], degrees, exponent);

    char kind[32];
    snprintf(kind, sizeof kind, "%g.%s", (double)exponent, key[i]);
    mapping_figure("lobe", kind, "active", "%.0f", m.active);
    mapping_figure("lobe", kind, "least", "%.0f", m.least);
    mapping_figure("lobe", kind, "cone", "%.1f", m.cone);
    mapping_figure("lobe", kind, "widest", "%.1f", m.widest);
    mapping_figure("lobe", kind, "step", "%.1f", m.step);
  }
}

/* Prints all figures and makes the pictures. */
int main(void) {
  course_scene scene = course_scene_make();
  course_scene ground = course_scene_empty();
  pktrt_scene *library = course_library(&scene);
  course_add(&ground, course_ground, 40, 40);

  course_picture strips = course_picture_make(WIDTH * ENLARGED, 4 * STRIP * ENLARGED);
  edge_of_shadow(&strips, 0, SAME, "one set for all", "one");
  edge_of_shadow(&strips, 1, PKTRT_SAMPLER_RANDOM, "random", "random");
  const double each = edge_of_shadow(&strips, 2, PKTRT_SAMPLER_SOBOL, "a set for each", "each");
  const double tiled = edge_of_shadow(&strips, 3, PKTRT_SAMPLER_INTERLEAVED, "interleaved", "interleaved");
  course_figure("edge.means.ratio", "%.2f", tiled / each);
  course_picture_write(&strips, "out/course/12_interleaved.png");

  lens(library, PKTRT_SAMPLER_SOBOL, 1, "a set for each, neighbours", "each");
  const double apart = lens(library, PKTRT_SAMPLER_SOBOL, 4, "a set for each, every fourth pixel", "each.fourth");
  lens(library, PKTRT_SAMPLER_INTERLEAVED, 1, "interleaved, neighbours", "interleaved");
  const double common =
      lens(library, PKTRT_SAMPLER_INTERLEAVED, 4, "interleaved, every fourth pixel", "interleaved.fourth");
  lens(library, SAME, 1, "one set for all, neighbours", "one");
  course_figure("lens.fourth.saved", "%.0f", 100 * (1 - common / apart));

  const disk_measure polar = disk_measure_print(disk_polar, "polar");
  const disk_measure concentric = disk_measure_print(pktrt_map_disk, "concentric");
  course_figure("disk.ratio.mean", "%.2f", concentric.mean / polar.mean);
  course_figure("disk.ratio.step", "%.2f", concentric.step / polar.step);

  mapping_tests naive = off_surfaces(&ground, lobe_naive, "naive, ground alone", "naive.ground");
  mapping_tests careful = off_surfaces(&ground, lobe_thrown_away, "careful, ground alone", "careful.ground");
  course_figure("origin.ground.boxes.ratio", "%.1f", naive.boxes / careful.boxes);
  course_figure("origin.ground.triangles.ratio", "%.1f", naive.triangles / careful.triangles);
  naive = off_surfaces(&scene, lobe_naive, "naive, the course's scene", "naive.scene");
  careful = off_surfaces(&scene, lobe_thrown_away, "careful, the course's scene", "careful.scene");
  course_figure("origin.scene.boxes.ratio", "%.2f", naive.boxes / careful.boxes);
  course_figure("origin.scene.triangles.ratio", "%.2f", naive.triangles / careful.triangles);

  lobes(80, 10);
  lobes(80, 100);
  lobes(80, 1000);
  drawing_make("out/course/12_points.svg");
  pktrt_scene_destroy(library);
  return 0;
}
