/* Chapter 14: triangles, boxes and trees that move. Makes out/course/14_motion.png, 14_boxes.svg, 14_tests.svg and
   14_refit.svg; prints tests by kind of box, and the cost of refitted and rebuilt trees.

   cc -O2 examples/course/14_motion.c -o motion -lm && ./motion */
#define PKTRT_IMPLEMENTATION
#include "14_draw.h"
#include "14_measure.h"

/* Counts tests by kind of box, for shutters from 0 to all of the time. */
static void kinds(void) {
  enum { KINDS = 4, SHUTTERS = 5, WIDTH = 80, HEIGHT = 60, RAYS = 2 * WIDTH * HEIGHT };
  static const char *const name[KINDS] = {"ray's time", "1/16 of shutter", "open shutter", "whole time"};
  static const double shift[KINDS] = {9, -7, 10, -6};
  static const char *const colour[KINDS] = {"#06c", "#393", "#e80", "#c33"};
  const motion_scene things = motion_things(COURSE_TURN / 6);
  double tests[KINDS][SHUTTERS] = {{0}}, leaves[KINDS][SHUTTERS] = {{0}};
  pktrt_scene *library = pktrt_scene_create(NULL);
  svg drawing;
  motion_add(library, &things);
  if (pktrt_commit(library) || !svg_begin(&drawing, "out/course/14_tests.svg", 640, 360)) exit(1);

  for (int s = 0; s < SHUTTERS; s++) {
    const float shutter = (float)s / (SHUTTERS - 1);
    uint32_t random = 3;

    for (int i = 0; i < RAYS; i++) {
      const int x = i / 2 % WIDTH, y = i / 2 / WIDTH;
      const float at = course_random(&random), part = floorf(16 * at) / 16;
      pktrt_ray ray = draw_aim((float)x + 0.5f, (float)y + 0.5f, WIDTH, HEIGHT, at * shutter);
      const float begin[KINDS] = {ray.time, part * shutter, 0, 0};
      const float end[KINDS] = {ray.time, (part + 0.0625f) * shutter, shutter, 1};
      pktrt_hit hit;
      pktrt_intersect(library, &ray, &hit);
      ray.tmax = hit.t;
      for (int k = 0; k < KINDS; k++)
        tests[k][s] += count_tests(library, &ray, begin[k], end[k], &leaves[k][s]) / (double)RAYS;
    }
  }

  const chart_area chart = {&drawing, 50, 40, 460, 260, 1, 40};
  chart_frame(&chart, 0.25, 10, "box tests per ray", "length of the shutter");

  for (int k = 0; k < KINDS; k++) {
    printf("boxes of the %s: box tests per ray", name[k]);
    for (int s = 0; s < SHUTTERS; s++) printf(" %.1f", tests[k][s]);
    printf("; leaves %.2f\n", leaves[k][SHUTTERS - 1] / RAYS);
    chart_curve(&chart, tests[k], SHUTTERS, colour[k], name[k], shift[k]);
  }

  if (!svg_end(&drawing)) exit(1);
  pktrt_scene_destroy(library);
}

enum { FRAMES = 13, POLICIES = 3, NEVER = 0, ADVISED, ALWAYS };

/* What becomes of one policy, frame by frame. */
typedef struct policy {
  motion_tree tree;
  double cost[FRAMES], tests[FRAMES];
  double at_build, growths, mean; /* SAH cost when the tree was built; per frame: growths of boxes, tests of a ray */
  int builds;
} policy;

/* Refits a policy's tree to a frame, and rebuilds the tree if the policy says so. */
static void follow(policy *now, int which, const motion_scene *flakes, int frame) {
  if (frame > 0 && which != ALWAYS) {
    now->growths += (double)motion_fit(&now->tree, flakes) / (FRAMES - 1);
    now->cost[frame] = sah_cost(&now->tree);
    if (which == NEVER || now->cost[frame] <= 1.5 * now->at_build) return;
  }

  now->tree = motion_build(flakes);
  now->at_build = now->cost[frame] = sah_cost(&now->tree);
  if (frame == 0) return;
  now->growths += (double)now->tree.growths / (FRAMES - 1);
  now->builds++;
}

/* Blows flakes away, by height or at random, by three policies; prints and draws costs and tests. */
static void refits(svg *drawing, int wind) {
  static const char *const name[POLICIES] = {"never rebuilt", "rebuilt at 1.5", "always rebuilt"};
  static const double shift[POLICIES] = {0, -6, 8};
  static const char *const colour[POLICIES] = {"#c33", "#e80", "#06c"};
  static float end[STILL_RAYS];
  policy all[POLICIES] = {0};
  motion_scene flakes = motion_flakes();
  const course_scene rest = flakes.at[0];
  flakes.at[0].position = flakes.at[1].position = (vec *)course_memory(rest.vertices, sizeof(vec));

  for (int frame = 0; frame < FRAMES; frame++) {
    motion_blow(&rest, 2.0 * frame / (FRAMES - 1), wind == 1, flakes.at[0].position);

    for (int which = ALWAYS; which >= 0; which--) {
      policy *now = &all[which];
      follow(now, which, &flakes, frame);
      if (which == ALWAYS) still_tests(&flakes, &now->tree, end, false);
      now->tests[frame] = still_tests(&flakes, &now->tree, end, true);
      if (frame > 0) now->mean += now->tests[frame] / (FRAMES - 1);
    }
  }

  const chart_area cost = {drawing, 50 + 450 * wind, 40, 260, 230, 2, 350},
                   tests = {drawing, 50 + 450 * wind, 370, 260, 230, 2, 150};
  chart_frame(&cost, 0.5, 50, wind ? "SAH cost, wind at random" : "SAH cost, wind by height", "angle in radians");
  chart_frame(&tests, 0.5, 25, wind ? "box tests per ray, wind at random" : "box tests per ray, wind by height",
      "angle in radians");
  printf("%u flakes, wind %s: at rest SAH cost %.1f, box tests per ray %.1f\n", rest.triangles,
      wind ? "at random" : "by height", all[0].cost[0], all[0].tests[0]);

  for (int which = 0; which < POLICIES; which++) {
    const policy *now = &all[which];
    const policy *before = which ? now - 1 : now;
    chart_curve(&cost, now->cost, FRAMES, colour[which], name[which], shift[which]);
    chart_curve(&tests, now->tests, FRAMES, colour[which], name[which], shift[which]);
    printf("  %s: %d builds in %d frames; last frame: cost %.1f, tests %.1f; per frame: tests %.1f, growths %.0f",
        name[which], now->builds, FRAMES - 1, now->cost[FRAMES - 1], now->tests[FRAMES - 1], now->mean, now->growths);
    if (which)
      printf("; pays over the line above from %.0f rays on",
          (now->growths - before->growths) / (before->mean - now->mean));
    printf("\n");
  }
}

/* Makes all pictures and prints all figures. */
int main(void) {
  svg drawing;
  course_make_folder();
  draw_picture("out/course/14_motion.png");
  if (!draw_boxes("out/course/14_boxes.svg") || !svg_begin(&drawing, "out/course/14_refit.svg", 900, 660)) return 1;
  measure_vertices();
  measure_areas();
  kinds();
  for (int wind = 0; wind < 2; wind++) refits(&drawing, wind);
  return svg_end(&drawing) ? 0 : 1;
}
