/* Chapter 9: a lens, a shutter, a lamp with a size and a lobe: their pictures, and their costs.

   Prints rays and tests by effect, and the tests of boxes that move and of united boxes. Makes out/course/09_effects.png
   and out/course/09_cost.png. */
#define PKTRT_IMPLEMENTATION
#include "09_scene.h"

/* Renders with one effect after the other, and prints and draws the results. */
static void effects(pktrt_path path) {
  static const char *const types[4] = {"primary", "shadow", "reflected", "refracted"};
  const char *how = path == PKTRT_PATH_PAPER ? "packets" : "alone";
  pktrt_stats stats[EFFECTS];
  course_picture strip = course_picture_make(EFFECTS * WIDTH, HEIGHT);
  printf("%s: rays per sample, and tests of boxes per primary, shadow, reflected and refracted ray\n",
      path == PKTRT_PATH_PAPER ? "packets of a pixel's rays" : "rays alone");

  for (int with = IDEAL; with < EFFECTS; with++) {
    const pktrt_stats *s = &stats[with];
    stats[with] = count((effect)with, ALL_REFLECT, path, strip.pixel[with * WIDTH].at, 3 * EFFECTS * WIDTH);
    double rays = 0;
    for (int t = 0; t < 4; t++) rays += (double)s->by_type[t].rays;
    printf("  %-8s %.2f  %5.1f %5.1f %5.1f %5.1f\n", names[with], rays / (double)s->samples,
        boxes(s, PKTRT_RAY_PRIMARY), boxes(s, PKTRT_RAY_SHADOW), boxes(s, PKTRT_RAY_REFLECTION),
        boxes(s, PKTRT_RAY_REFRACTION));
    figure(names[with], how, "rays", "%.2f", rays / (double)s->samples);
    for (int t = 0; t < 4; t++) figure(names[with], how, types[t], "%.1f", boxes(s, (pktrt_ray_type)t));
    if (path != PKTRT_PATH_PAPER || with > LENS) continue;

    const pktrt_counts *primary = &s->by_type[PKTRT_RAY_PRIMARY];
    const double by_intervals = (double)primary->interval_culls / (double)primary->packets;
    const double by_rays = (double)primary->ray_culls / (double)primary->packets;
    printf("    children that a primary packet drops: %.1f by intervals, %.1f ray by ray\n", by_intervals, by_rays);
    figure(names[with], "dropped", "intervals", "%.1f", by_intervals);
    figure(names[with], "dropped", "rays", "%.1f", by_rays);
  }
  write_enlarged(&strip, 2, 18, "out/course/09_effects.png"); /* the same bits from both paths */
  free(strip.pixel);
}

/* [branching] */
/* Counts the reflected and refracted rays if both ways are followed at glass, and if one is chosen. */
static void branching(void) {
  static vec pixels[WIDTH * HEIGHT];
  pktrt_scene *scene = make_scene(IDEAL, ALL_REFLECT);
  for (int b = PKTRT_BRANCHING_BOTH; b <= PKTRT_BRANCHING_CHOOSE; b++) {
    pktrt_stats stats = {0};
    pktrt_render_desc view = {.pixels = pixels[0].at, .samples = 4, .stats = &stats, .branching = (pktrt_branching)b};
    render(scene, &view, IDEAL);
    const uint64_t rays = stats.by_type[PKTRT_RAY_REFLECTION].rays + stats.by_type[PKTRT_RAY_REFRACTION].rays;
    const double per_sample = (double)rays / (double)stats.samples;
    printf("%s: reflected and refracted rays per sample %.2f\n", b == PKTRT_BRANCHING_BOTH ? "both ways" : "one way",
        per_sample);
    course_figure(b == PKTRT_BRANCHING_BOTH ? "both-ways" : "one-way", "%.2f", per_sample);
  }
  pktrt_scene_destroy(scene);
}
/* [end] */

/* [united] */
/* Makes each box hold its contents at all times while the shutter is open, as the paper's boxes do. */
static void unite(pktrt_node *node, const pktrt_node *end) {
  for (int k = 0; k < 8; k++)
    for (int a = 0; a < 3; a++) {
      node->lo[k][a] = fminf(node->lo[k][a], end->lo[k][a]);
      node->hi[k][a] = fmaxf(node->hi[k][a], end->hi[k][a]);
    }
}
/* [end] */

/* [walk] */
/* Counts the boxes that a ray is tested against in a tree, if the end of the ray is known from the beginning. */
static uint32_t walk(const pktrt_scene *scene, uint32_t tree, const pktrt_ray *ray, bool united) {
  uint32_t stack[256], n = 1, tests = 0;
  stack[0] = 0;
  while (n > 0) {
    pktrt_node node, end;
    const uint32_t index = stack[--n];
    pktrt_get_node(scene, tree, index, united ? 0 : ray->time, &node);
    if (united) pktrt_get_node(scene, tree, index, 1, &end), unite(&node, &end);
    for (int k = 0; k < 8; k++) {
      if (node.child[k] == PKTRT_NONE) continue;
      tests++;
      if (meets_box(ray, node.lo[k], node.hi[k]) && !node.leaf[k]) stack[n++] = node.child[k];
    }
  }
  return tests;
}
/* [end] */

/* Makes maps of the boxes that camera rays are tested against while the shutter is open: all boxes, as the library counts
   them; the boxes of the tree that moves, as they move; the united boxes of this tree. */
static void cost(void) {
  enum { RAYS = 4 };
  static float boxes[3][WIDTH * HEIGHT];
  double mean[3] = {0};
  course_picture map = course_picture_make(3 * WIDTH, HEIGHT);
  pktrt_scene *scene = make_scene(EFFECTS, ALL_REFLECT); /* without a lamp: no shadow rays */
  const pktrt_camera camera = make_camera(SHUTTER);
  const pktrt_sampling sampling = {.samples = RAYS};
  pktrt_render_desc view = {.pixels = map.pixel[0].at,
      .row_stride = 9 * WIDTH,
      .samples = RAYS,
      .attenuation = 1,
      .branching = PKTRT_BRANCHING_BOTH,
      .path = PKTRT_PATH_SINGLE,
      .packet_size = 2,
      .cost = boxes[0],
      .cost_of = PKTRT_COST_BOXES};
  pktrt_tree tree;
  uint32_t moving = 0;
  render(scene, &view, SHUTTER);
  while (pktrt_get_tree(scene, moving, &tree) && tree.keys == 1) moving++;
  for (uint32_t i = 0; i < WIDTH * HEIGHT * RAYS; i++) {
    const uint32_t x = i / RAYS % WIDTH, y = i / RAYS / WIDTH;
    float u[3];
    pktrt_ray ray;
    pktrt_hit hit;
    pktrt_sample(&sampling, x, y, i % RAYS, 0, 3, u);
    pktrt_camera_ray(&camera, WIDTH, HEIGHT, (double)x + (double)u[0], (double)y + (double)u[1], NULL, u[2], &ray);
    if (pktrt_intersect(scene, &ray, &hit)) ray.tmax = hit.t;
    for (int k = 0; k < 2; k++) boxes[1 + k][i / RAYS] += (float)walk(scene, moving, &ray, k == 1) / RAYS;
  }
  for (int i = 0; i < 3 * WIDTH * HEIGHT; i++) {
    const int k = i / WIDTH % 3;
    const float value = boxes[k][i / (3 * WIDTH) * WIDTH + i % WIDTH];
    map.pixel[i] = course_heat(value / 100);
    mean[k] += (double)value / WIDTH / HEIGHT;
  }
  printf("boxes per camera ray: all %.1f; of the knot, if it knew its end: moving %.1f, united %.1f\n", mean[0],
      mean[1], mean[2]);
  course_figure("cost.all", "%.1f", mean[0]);
  course_figure("cost.moving", "%.1f", mean[1]);
  course_figure("cost.united", "%.1f", mean[2]);
  pktrt_scene_destroy(scene);
  write_enlarged(&map, 3, 0, "out/course/09_cost.png");
}

int main(void) {
  effects(PKTRT_PATH_SINGLE);
  effects(PKTRT_PATH_PAPER);
  reflections();
  branching();
  cost();
  return 0;
}
