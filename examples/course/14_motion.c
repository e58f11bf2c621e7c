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
  static const char *const key[KINDS] = {"ray", "sixteenth", "open", "whole"};
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
    measure_figure("kind", key[k], "leaves", "%.2f", leaves[k][SHUTTERS - 1] / RAYS);

    for (int s = 0; s < SHUTTERS; s++) {
      char what[32];
      snprintf(what, sizeof what, "%g", (double)s / (SHUTTERS - 1));
      measure_figure("kind", key[k], what, "%.1f", tests[k][s]);
    }

    chart_curve(&chart, tests[k], SHUTTERS, colour[k], name[k], shift[k]);
  }

  if (!svg_end(&drawing)) exit(1);
  pktrt_scene_destroy(library);
}

enum { FRAMES = 13, DRAWN = 3, POLICIES = 5, NEVER = 0, ADVISED, ALWAYS, EARLY, LATE };

/* A tree is rebuilt when its cost is more than this many times its cost when it was built. Three policies are drawn. */
static const double rebuilt_at[POLICIES] = {INFINITY, 1.5, 0, 1.1, 3};

/* What becomes of one policy, frame by frame. */
typedef struct policy {
  motion_tree tree;
  double cost[FRAMES], tests[FRAMES];
  double at_build, growths, mean; /* SAH cost when the tree was built; per frame: growths of boxes, tests of a ray */
  int builds;
} policy;

/* Refits a policy's tree to a frame, and rebuilds the tree if the policy says so. */
static void follow(policy *now, int which, const motion_scene *flakes, int frame) {
  const double most = rebuilt_at[which] * now->at_build;

  if (frame > 0 && which != ALWAYS) {
    now->growths += (double)motion_fit(&now->tree, flakes) / (FRAMES - 1);
    now->cost[frame] = sah_cost(&now->tree);
    if (now->cost[frame] <= most) return;
  }

  now->tree = motion_build(flakes);
  now->at_build = now->cost[frame] = sah_cost(&now->tree);
  if (frame == 0) return;
  now->growths += (double)now->tree.growths / (FRAMES - 1);
  now->builds++;
}

/* Prints what has become of a policy, and from how many rays on it pays compared with another, unless that is NULL. */
static void print_policy(const policy *now, const policy *before, const char *name, const char *wind, const char *key) {
  const double cost = now->cost[FRAMES - 1], tests = now->tests[FRAMES - 1];
  printf("  %s: %d builds in %d frames; last frame: cost %.1f, tests %.1f; per frame: tests %.1f, growths %.0f", name,
      now->builds, FRAMES - 1, cost, tests, now->mean, now->growths);
  const double rays = before ? (now->growths - before->growths) / (before->mean - now->mean) : 0;
  if (before) printf("; pays from %.0f rays on", rays);
  printf("\n");

  measure_figure(wind, key, "builds", "%.0f", now->builds);
  measure_figure(wind, key, "cost", "%.1f", cost);
  measure_figure(wind, key, "tests", "%.1f", tests);
  measure_figure(wind, key, "mean", "%.1f", now->mean);
  measure_figure(wind, key, "growths", "%.0f", now->growths);
  if (before) measure_figure(wind, key, "pays", "%.0f", rays);
}

/* Blows flakes away, by height or at random, by all policies; prints costs and tests, and draws three policies. */
static void refits(svg *drawing, int wind) {
  static const char *const name[POLICIES] = {
      "never rebuilt", "rebuilt at 1.5", "always rebuilt", "rebuilt at 1.1", "rebuilt at 3"};
  static const char *const key[POLICIES] = {"never", "advised", "always", "early", "late"};
  static const int order[POLICIES] = {ALWAYS, NEVER, ADVISED, EARLY, LATE}; /* the first finds where rays end */
  static const int compared[POLICIES] = {NEVER, NEVER, ADVISED, NEVER, NEVER};
  static const double shift[DRAWN] = {0, -6, 8};
  static const char *const colour[DRAWN] = {"#c33", "#e80", "#06c"};
  static float end[STILL_RAYS];
  policy all[POLICIES] = {0};
  motion_scene flakes = motion_flakes();
  const course_scene rest = flakes.at[0];
  flakes.at[0].position = flakes.at[1].position = (vec *)course_memory(rest.vertices, sizeof(vec));

  for (int frame = 0; frame < FRAMES; frame++) {
    motion_blow(&rest, 2.0 * frame / (FRAMES - 1), wind == 1, flakes.at[0].position);

    for (int i = 0; i < POLICIES; i++) {
      const int which = order[i];
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

  course_figure("flakes", "%u", rest.triangles);
  course_figure("flakes.cost", "%.1f", all[0].cost[0]);
  course_figure("flakes.tests", "%.1f", all[0].tests[0]);

  for (int which = 0; which < POLICIES; which++) {
    const policy *before = which == NEVER ? NULL : &all[compared[which]];
    print_policy(&all[which], before, name[which], wind ? "random" : "height", key[which]);
    if (which >= DRAWN) continue;
    chart_curve(&cost, all[which].cost, FRAMES, colour[which], name[which], shift[which]);
    chart_curve(&tests, all[which].tests, FRAMES, colour[which], name[which], shift[which]);
  }
}

/* Makes all pictures and prints all figures. */
int main(void) {
  svg drawing;
  course_make_folder();
  draw_picture("out/course/14_motion.png");
  if (!draw_boxes("out/course/14_boxes.svg") || !svg_begin(&drawing, "out/course/14_refit.svg", 900, 660)) return 1;
  measure_vertices();
  measure_shrinking(COURSE_TURN / 6, "sixth");
  measure_shrinking(COURSE_TURN / 3, "third");
  measure_areas(COURSE_TURN / 6, "sixth");
  measure_areas(COURSE_TURN / 3, "third");
  kinds();
  for (int wind = 0; wind < 2; wind++) refits(&drawing, wind);
  return svg_end(&drawing) ? 0 : 1;
}
