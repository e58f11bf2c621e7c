/* checks.h - what the measurements must show, in smaller ones. Where a claim of the paper does not hold here, the
   check says so by its name, UNLIKE THE PAPER, and bounds our figure from both sides. Each bound has a control, the same
   comparison of something with itself, the other way round or of something else, which has to fail. */
#ifndef PAPER_CHECKS_H
#define PAPER_CHECKS_H

#include "amortise.h"
#include "embree_rcs.h"
#include "kensler.h"
#include "paper.h"
#include "system.h"

enum { DETAILS = 256 };

/* What is measured: the claim's figure, or a control that has to be below its least or above its most. */
typedef enum control { NO_CONTROL, TOO_LOW, TOO_HIGH, CONTROLS } control;

typedef struct claim claim;
struct claim {
  const char *sentence;
  double least; /* the figure is to be as much; 0: it has no such bound */
  double most;  /* the figure is to be at most that; 0: it has no such bound */
  bool more;    /* the figure is to be more than least */
  bool counted; /* tests, which no noise changes */
  double (*figure)(bench *, const claim *, control, char details[DETAILS]);
  const char *scene;
  int number; /* what the figure is about: a feature, a mode */
};

static double against_single(bench *b, const setup *packets, control is, char details[DETAILS]) {
  setup ways[2];
  ways[0] = ways[1] = *packets;
  ways[0].assembly = is ? PKTRT_ASSEMBLY_RAY_TYPES : PKTRT_ASSEMBLY_NONE;
  const row *r = measure(b, ways, 2);
  snprintf(details, DETAILS, "%.2f to %.2f Mrays/s", mrays(&r[0]), mrays(&r[1]));
  return times_as_fast(b, &r[1], &r[0]);
}

static double table1_on_paper_path(bench *b, const claim *c, control is, char details[DETAILS]) {
  setup s = whitted(b, c->scene);
  column(0, &s);
  return against_single(b, &s, is, details);
}

/* On the widest instruction set, where packets have most to win. */
static double table1_on_fast_path(bench *b, const claim *c, control is, char details[DETAILS]) {
  setup s = whitted(b, c->scene);
  column(columns() - 1, &s);
  return against_single(b, &s, is, details);
}

static double table3_of_64(bench *b, const claim *c, control is, char details[DETAILS]) {
  setup s = one_frame(b, c->scene, PKTRT_MODE_DRT, 8);
  column(0, &s);
  return against_single(b, &s, is, details);
}

/* Runs, then ray types; the control has them the other way round. */
static const row *types_and_runs(bench *b, const claim *c, bool swapped) {
  setup ways[2];
  ways[0] = pruned(b, c->scene);
  column(0, &ways[0]);
  ways[1] = ways[0];
  ways[0].assembly = swapped ? PKTRT_ASSEMBLY_RAY_TYPES : PKTRT_ASSEMBLY_RUNS;
  ways[1].assembly = swapped ? PKTRT_ASSEMBLY_RUNS : PKTRT_ASSEMBLY_RAY_TYPES;
  return measure(b, ways, 2);
}

static double ahead_of_runs(bench *b, const claim *c, control is, char details[DETAILS]) {
  const row *r = types_and_runs(b, c, is == TOO_LOW);
  snprintf(details, DETAILS, "vectors of tests per ray %.1f against %.1f; rays tested per vector %.1f against %.1f",
      per_ray(vector_tests(&r[1].all), &r[1].all), per_ray(vector_tests(&r[0].all), &r[0].all), lanes_used(&r[1].all),
      lanes_used(&r[0].all));
  return times_as_fast(b, &r[1], &r[0]);
}

/* The least advantage at any depth from 2 on, of those with a hundredth of all rays. */
static double deep_tests(bench *b, const claim *c, control is, char details[DETAILS]) {
  const row *r = types_and_runs(b, c, is == TOO_LOW);
  double least = HUGE_VAL;
  int worst = 0;
  for (int d = 2; d < PKTRT_MAX_DEPTH + 2; d++) {
    const pktrt_counts *runs = &r[0].stats.by_depth[d], *types = &r[1].stats.by_depth[d];
    if (runs->rays * 100 < r->all.rays || !types->vector_box_tests) continue;
    const double ratio = (double)runs->vector_box_tests / (double)types->vector_box_tests;
    if (ratio < least) least = ratio, worst = d;
  }
  snprintf(details, DETAILS, "at %d bounces %.1f per ray against %.1f", worst,
      per_ray(r[1].stats.by_depth[worst].vector_box_tests, &r[1].stats.by_depth[worst]),
      per_ray(r[0].stats.by_depth[worst].vector_box_tests, &r[0].stats.by_depth[worst]));
  return worst ? least : 0;
}

/* The tests of all rays, those of packets by ray type over those of runs. In rays tested, as the counters have it: a
   vector of eight in which one ray is tested is one test. c->number: of triangles, else of boxes. */
static double tests_of_types(bench *b, const claim *c, control is, char details[DETAILS]) {
  setup ways[2];
  ways[0] = ways[1] = pruned(b, c->scene);
  for (int i = 0; i < 2; i++) column(0, &ways[i]);
  ways[0].assembly = is == TOO_LOW ? PKTRT_ASSEMBLY_RAY_TYPES : PKTRT_ASSEMBLY_RUNS;
  ways[1].assembly = is == TOO_LOW    ? PKTRT_ASSEMBLY_RUNS
                     : is == TOO_HIGH ? PKTRT_ASSEMBLY_BLIND
                                      : PKTRT_ASSEMBLY_RAY_TYPES;
  const row *r = measure(b, ways, 2);
  double tests[2];
  for (int i = 0; i < 2; i++) tests[i] = per_ray(c->number ? r[i].all.triangle_tests : r[i].all.box_tests, &r[i].all);
  snprintf(details, DETAILS, "%.2f per ray, runs %.2f", tests[1], tests[0]);
  return tests[1] / tests[0];
}

/* c->number: 0 of boxes, 1 of triangles, 2 of triangles with the paper's steps alone. Box tests, which do explode, are the control that is too high. */
static double tests_of_16x16(bench *b, const claim *c, control is, char details[DETAILS]) {
  setup ways[2];
  ways[0] = ways[1] = whitted(b, c->scene);
  ways[1].packet = is == TOO_LOW ? 8 : 16;
  if (c->number == 2) ways[0].steps = ways[1].steps = PKTRT_PAPER_STEPS_2007;
  for (int i = 0; i < 2; i++) column(0, &ways[i]);
  const row *r = measure(b, ways, 2);
  double tests[2];
  for (int i = 0; i < 2; i++)
    tests[i] = per_ray(c->number && is != TOO_HIGH ? r[i].all.triangle_tests : r[i].all.box_tests, &r[i].all);
  snprintf(details, DETAILS, "%.3f per ray, 8x8 %.3f", tests[1], tests[0]);
  return tests[1] / tests[0];
}

static double tests_per_ray(const row *r) { return per_ray(r->all.box_tests + r->all.triangle_tests, &r->all); }

/* How much more the tests with united boxes have grown, from the shut shutter to the widest open one. */
static double growth_with_shutter(bench *b, const claim *c, control is, char details[DETAILS]) {
  const row *r[2];
  for (int i = 0; i < 2; i++) {
    setup ways[2];
    ways[0] = one_frame(b, c->scene, PKTRT_MODE_DRT, 4);
    ways[0].shutter = i ? 1.0 / 30 : 0;
    column(0, &ways[0]);
    ways[1] = ways[0];
    ways[0].united = true;
    ways[1].united = is == TOO_LOW;
    r[i] = measure(b, ways, 2);
  }
  const double united = tests_per_ray(&r[1][0]) / tests_per_ray(&r[0][0]);
  const double moving = tests_per_ray(&r[1][1]) / tests_per_ray(&r[0][1]);
  snprintf(details, DETAILS, "from shut to a 30th of the loop boxes that move cost %.3fx the tests, united ones %.3fx",
      moving, united);
  return united / moving;
}

/* Features of figure 7 over their range (of gloss, from where it is dearest). */
static const struct {
  const char *name;
  double steps[3];
} ranges[] = {{"aperture", {0, 1, 2}}, {"light size", {0.01, 1, 2}}, {"exponent", {10, 100, 10000}}};
enum { RANGE_OF_APERTURE, RANGE_OF_LIGHTS, RANGE_OF_GLOSS };

static setup at_step(const bench *b, const char *name, int feature, double value) {
  setup s = one_frame(b, name, PKTRT_MODE_DRT, 4);
  if (feature == RANGE_OF_APERTURE) s.aperture = value;
  if (feature == RANGE_OF_LIGHTS) s.light_size = value;
  if (feature == RANGE_OF_GLOSS) s.exponent = value;
  column(0, &s);
  return s;
}

/* Tests of boxes and triangles, the most over the least. Too low: of the aperture, which changes little; too high: with
   packets of 16x16 at one end. */
static double change_with_feature(bench *b, const claim *c, control is, char details[DETAILS]) {
  const int feature = is == TOO_LOW ? RANGE_OF_APERTURE : c->number;
  double tests[3], most = 0, least = HUGE_VAL;
  for (int i = 0; i < 3; i++) {
    setup s = at_step(b, c->scene, feature, ranges[feature].steps[i]);
    if (is == TOO_HIGH && i == (feature == RANGE_OF_GLOSS ? 0 : 2)) s.packet = 16;
    tests[i] = tests_per_ray(measure(b, &s, 1));
    most = fmax(most, tests[i]), least = fmin(least, tests[i]);
  }
  snprintf(details, DETAILS, "%s %g, %g, %g: %.1f, %.1f, %.1f tests per ray", ranges[feature].name,
      ranges[feature].steps[0], ranges[feature].steps[1], ranges[feature].steps[2], tests[0], tests[1], tests[2]);
  return most / least;
}

static const row *frame_of(bench *b, const char *name, pktrt_mode mode) {
  setup s = frame_of_table2(b, name, mode);
  column(0, &s);
  return measure(b, &s, 1);
}

/* Rays per second of the mode c->number over those of the mode before it; of counts, tests per ray. The controls: other
   modes, farther apart, or one and the same. */
static double mode_ratio(bench *b, const claim *c, control is, char details[DETAILS]) {
  pktrt_mode over = (pktrt_mode)c->number, under = (pktrt_mode)(c->number - 1);
  if (is == TOO_LOW && c->counted) over = under;
  if (is == TOO_LOW && !c->counted) over = PKTRT_MODE_DRT, under = PKTRT_MODE_RCS;
  if (is == TOO_HIGH && c->counted) over = PKTRT_MODE_DRT, under = PKTRT_MODE_RCS;
  if (is == TOO_HIGH && !c->counted) over = PKTRT_MODE_RCS, under = PKTRT_MODE_WRT;
  const row *a = frame_of(b, c->scene, over), *z = frame_of(b, c->scene, under);
  const double x = c->counted ? tests_per_ray(a) : mrays(a), y = c->counted ? tests_per_ray(z) : mrays(z);
  snprintf(details, DETAILS, "%s %.2f, %s %.2f %s", mode_names[over], x, mode_names[under], y,
      c->counted ? "tests per ray" : "Mrays/s");
  return x / y;
}

/* Section 3.1: how many times as many tests rays make alone as in packets of 8x8. Too low: in packets of 16x16; too
   high: of camera rays only. */
static double fewer_tests(bench *b, const claim *c, control is, char details[DETAILS]) {
  setup ways[2];
  ways[0] = ways[1] = whitted(b, c->scene);
  for (int i = 0; i < 2; i++) column(0, &ways[i]), ways[i].frames = (b->given.frames + 1) / 2;
  ways[0].path = PKTRT_PATH_SINGLE; /* the tap makes of it what is meant */
  if (is == TOO_LOW) ways[1].packet = 16;
  open_setup(&b->now, &ways[0]);
  tap_open(b->now.tree, trace_alone);
  const row *r = measure(b, ways, 2);
  tap_close(b->now.tree);
  const pktrt_counts *alone = &r[0].all, *packets = &r[1].all;
  if (is == TOO_HIGH) alone = &r[0].stats.by_type[PKTRT_RAY_PRIMARY], packets = &r[1].stats.by_type[PKTRT_RAY_PRIMARY];
  snprintf(details, DETAILS, "%.1f tests per ray alone, %.1f in packets", tests_of(alone) / (double)alone->rays,
      tests_of(packets) / (double)packets->rays);
  return tests_of(alone) / tests_of(packets);
}

/* Section 3.1: packets of 8x8 against packets of 2x2, which are SIMD alone. The control has 8x8 on both sides. */
static double beyond_simd(bench *b, const claim *c, control is, char details[DETAILS]) {
  setup ways[2];
  ways[0] = whitted(b, c->scene);
  column(0, &ways[0]);
  ways[1] = ways[0];
  ways[0].packet = is ? 8 : 2;
  const row *r = measure(b, ways, 2);
  snprintf(details, DETAILS, "%.2f to %.2f Mrays/s", mrays(&r[0]), mrays(&r[1]));
  return times_as_fast(b, &r[1], &r[0]);
}

/* Counts anew, with changes taken back as in amortise.h: those two. */
static void recount_two(bench *b, const claim *c, int one, int two) {
  recount_scene(b, c->scene, (b->given.frames + 1) / 2, 1u << one | 1u << two);
}

/* Tests in packets of 8x8 as the walk makes them, over those of the library. Too low: in groups of four lanes; too high:
   over those of the library with all steps. */
static double tests_of_walk(bench *b, const claim *c, control is, char details[DETAILS]) {
  const int walked = is == TOO_LOW ? FOUR_LANES : CHECKED, made = is == TOO_HIGH ? AS_IT_IS : NO_TRIM;
  recount_two(b, c, walked, made);
  const double x = tests_of(&recount.of[walked][EIGHTS].counts), y = tests_of(&recount.of[made][EIGHTS].counts);
  snprintf(details, DETAILS, "%.0f and %.0f tests; of %llu answers %llu differ", x, y,
      (unsigned long long)recount.answers, (unsigned long long)recount.other_answers);
  return x / y;
}

/* How many times as many tests packets save after the change c->number as before it; the control: after it again. */
static double saved_by_change(bench *b, const claim *c, control is, char details[DETAILS]) {
  const int before = is ? c->number : c->number - 1;
  recount_two(b, c, before, c->number);
  const double x = fewer_tests_of(c->number), y = fewer_tests_of(before);
  snprintf(details, DETAILS, "%.2f times fewer tests than alone, before %.2f times", x, y);
  return x / y;
}

/* Triangle tests of packets of 8x8 over those of rays alone, in the paper's configuration. The control has boxes of
   leaves. */
static double triangles_along_for_the_ride(bench *b, const claim *c, control is, char details[DETAILS]) {
  const int w = is ? IN_ROWS : OF_2007;
  recount_two(b, c, w, w);
  const pktrt_counts *alone = &recount.of[w][ALONE].counts, *packed = &recount.of[w][EIGHTS].counts;
  snprintf(details, DETAILS, "%.1f per ray alone, %.1f in packets", per_ray(alone->triangle_tests, alone),
      per_ray(packed->triangle_tests, packed));
  return (double)packed->triangle_tests / (double)alone->triangle_tests;
}

/* How many times fewer tests packets of 8x8 make in the paper's configuration. Too low: of triangles; too high: vectors
   of four lanes. */
static double saved_in_2007(bench *b, const claim *c, control is, char details[DETAILS]) {
  recount_two(b, c, OF_2007, OF_2007);
  const pktrt_counts *alone = &recount.of[OF_2007][ALONE].counts, *packed = &recount.of[OF_2007][EIGHTS].counts;
  snprintf(details, DETAILS, "boxes %.1f alone, %.1f in packets; triangles %.1f, %.1f",
      per_ray(alone->box_tests, alone), per_ray(packed->box_tests, packed), per_ray(alone->triangle_tests, alone),
      per_ray(packed->triangle_tests, packed));
  if (is == TOO_LOW) return (double)alone->triangle_tests / (double)packed->triangle_tests;
  if (is == TOO_HIGH) return (double)vector_tests(alone) / (double)vector_tests(packed);
  return fewer_tests_of(OF_2007);
}

/* Section 4: how many times as many rays follow both ways at glass as one of them. */
static double rays_of_both(bench *b, const claim *c, control is, char details[DETAILS]) {
  const row *r[2];
  for (int i = 0; i < 2; i++) {
    setup s = one_frame(b, c->scene, PKTRT_MODE_DRT, 4);
    column(0, &s);
    s.branching = i && is == NO_CONTROL ? PKTRT_BRANCHING_BOTH : PKTRT_BRANCHING_CHOOSE;
    r[i] = measure(b, &s, 1);
  }
  snprintf(details, DETAILS, "%llu rays, one way %llu", (unsigned long long)r[1]->all.rays,
      (unsigned long long)r[0]->all.rays);
  return (double)r[1]->all.rays / (double)r[0]->all.rays;
}

static double against_embree(bench *b, const claim *c, control is, char details[DETAILS]) {
  (void)c;
  double least;
  const double mean = embree_rcs_check(b, is == TOO_LOW, &least);
  snprintf(details, DETAILS, "geometric mean of three scenes, the least %.3fx; %s", least,
      is ? "single rays, scalar" : "fast path");
  return mean;
}

/* Section 4: how many of a thousand primary rays hit another triangle by Kensler and Shirley's test. */
static double unlike_kensler(bench *b, const claim *c, control is, char details[DETAILS]) {
  (void)c;
  return most_differing(b, is == TOO_HIGH, details, DETAILS);
}

#define UNLIKE "UNLIKE THE PAPER, "
static const claim claims[] = {{"table 1, conference, 8x8: packets against single rays, paper path", 2.85, 0, false,
                                   false, table1_on_paper_path, "conference", 0},
    {"table 1, rtrt, 8x8: packets against single rays, paper path", 2.69, 0, false, false, table1_on_paper_path, "rtrt",
        0},
    {"table 1, pool hall, 8x8: packets against single rays, paper path", 2.97, 0, false, false, table1_on_paper_path,
        "poolhall", 0},
    {"table 1, conference, 8x8: packets against single rays, fast path", 2, 0, false, false, table1_on_fast_path,
        "conference", 0},
    {"table 1, rtrt, 8x8: packets against single rays, fast path", 2, 0, false, false, table1_on_fast_path, "rtrt", 0},
    {"table 1, pool hall, 8x8: packets against single rays, fast path", 2, 0, false, false, table1_on_fast_path,
        "poolhall", 0},
    {"table 2, rtrt: the rate of DRT is below that of WRT, as in the paper", 0.6, 0.9, false, false, mode_ratio, "rtrt",
        PKTRT_MODE_DRT},
    {UNLIKE "table 2, conference: the rate of DRT is three quarters of that of WRT, not half", 0.7, 0.95, false, false,
        mode_ratio, "conference", PKTRT_MODE_DRT},
    {UNLIKE "table 2, pool hall: the rate of DRT is below that of WRT, not 1.48 of it", 0.5, 1, false, false,
        mode_ratio, "poolhall", PKTRT_MODE_DRT},
    {"table 2, conference: a ray of WRT needs more tests than one of RCS", 1, 0, true, true, mode_ratio, "conference",
        PKTRT_MODE_WRT},
    {"table 2, rtrt: a ray of WRT needs more tests than one of RCS", 1, 0, true, true, mode_ratio, "rtrt",
        PKTRT_MODE_WRT},
    {"table 2, pool hall: a ray of WRT needs more tests than one of RCS", 1, 0, true, true, mode_ratio, "poolhall",
        PKTRT_MODE_WRT},
    {"table 2, conference: a ray of DRT needs more tests than one of WRT", 1, 0, true, true, mode_ratio, "conference",
        PKTRT_MODE_DRT},
    {"table 2, rtrt: a ray of DRT needs more tests than one of WRT", 1, 0, true, true, mode_ratio, "rtrt",
        PKTRT_MODE_DRT},
    {UNLIKE "table 2, pool hall: a ray of DRT needs more tests than one of WRT, too", 1, 1.3, true, true, mode_ratio,
        "poolhall", PKTRT_MODE_DRT},
    {"table 3, 64 samples: packets against single rays, paper path", 3.03, 0, false, false, table3_of_64, "conference",
        0},
    {"figure 6: box tests explode from 8x8 to 16x16", 1.3, 0, false, true, tests_of_16x16, "conference", 0},
    {UNLIKE "figure 6: triangle tests do not explode from 8x8 to 16x16, they hardly rise", 1, 1.03, true, true,
        tests_of_16x16, "conference", 1},
    {"figure 6: with the steps of 2007 alone triangle tests explode from 8x8 to 16x16", 2.5, 0, false, true,
        tests_of_16x16, "conference", 2},
    {"figure 7: the aperture hardly changes tests per ray", 0, 1.1, false, true, change_with_feature, "conference",
        RANGE_OF_APERTURE},
    {UNLIKE "figure 7: the size of lights changes tests per ray, and not a little", 1.15, 1.8, false, true,
        change_with_feature, "conference", RANGE_OF_LIGHTS},
    {UNLIKE "figure 7: gloss changes tests per ray, and not a little", 1.3, 2.2, false, true, change_with_feature,
        "conference", RANGE_OF_GLOSS},
    {"figure 7: tests grow more slowly with the shutter where boxes move", 1, 0, true, true, growth_with_shutter,
        "rtrt", 0},
    {"figure 8: ray types need fewer vectors of box tests, idle lanes included, than runs at depth", 1, 0, true, true,
        deep_tests, "conference", 0},
    {UNLIKE "figure 8: without idle lanes, in rays tested, ray types need more box tests than runs", 1.05, 1.6, false,
        true, tests_of_types, "conference", 0},
    {"figure 8: runs test slightly fewer triangles than ray types", 1, 1.05, true, true, tests_of_types, "conference",
        1},
    {UNLIKE "section 5.2, conference: rays in 8x8 make more tests than alone, none are amortised", 0.6, 0.85, false,
        true, fewer_tests, "conference", 0},
    {UNLIKE "section 5.2, rtrt: rays in 8x8 make as many tests as alone", 0.8, 1.1, false, true, fewer_tests, "rtrt",
        0},
    {UNLIKE "section 5.2, pool hall: rays in 8x8 make about as many tests as alone", 0.9, 1.3, false, true, fewer_tests,
        "poolhall", 0},
    {"section 3.1, conference: our walk of packets makes the library's tests", 0.99, 1.01, false, true, tests_of_walk,
        "conference", 0},
    {"section 3.1, conference: two children per node save packets more tests than eight", 1.05, 0, false, true,
        saved_by_change, "conference", TWO_CHILDREN},
    {"section 3.1, rtrt: two children per node save packets more tests than eight", 1.05, 0, false, true,
        saved_by_change, "rtrt", TWO_CHILDREN},
    {"section 3.1, pool hall: two children per node save packets more tests than eight", 1.05, 0, false, true,
        saved_by_change, "poolhall", TWO_CHILDREN},
    {"section 3.1, conference: without boxes of leaves packets test more triangles than rays alone", 2, 0, false, true,
        triangles_along_for_the_ride, "conference", 0},
    {"section 3.1, rtrt: without boxes of leaves packets test more triangles than rays alone", 2, 0, false, true,
        triangles_along_for_the_ride, "rtrt", 0},
    {"section 3.1, pool hall: without boxes of leaves packets test more triangles than rays alone", 2, 0, false, true,
        triangles_along_for_the_ride, "poolhall", 0},
    {"section 3.1, conference: packets save more tests where pixels are finer", 1.05, 0, false, true, saved_by_change,
        "conference", FINER},
    {"section 3.1, rtrt: packets save more tests where pixels are finer", 1.05, 0, false, true, saved_by_change, "rtrt",
        FINER},
    {"section 3.1, pool hall: packets save more tests where pixels are finer", 1.05, 0, false, true, saved_by_change,
        "poolhall", FINER},
    {UNLIKE "section 5.2, conference: in the paper's configuration, too, rays in 8x8 make about as many tests as alone",
        0.45, 1.3, false, true, saved_in_2007, "conference", 0},
    {UNLIKE "section 5.2, rtrt: in the paper's configuration, too, rays in 8x8 make about as many tests as alone", 0.45,
        1.3, false, true, saved_in_2007, "rtrt", 0},
    {UNLIKE "section 5.2, pool hall: in the paper's configuration, too, rays in 8x8 make about as many tests as alone",
        0.45, 1.3, false, true, saved_in_2007, "poolhall", 0},
    {"section 3.1, conference: packets of 8x8 against 2x2, paper path", 1.5, 0, false, false, beyond_simd, "conference",
        0},
    {"section 3.1, rtrt: packets of 8x8 against 2x2, paper path", 1.5, 0, false, false, beyond_simd, "rtrt", 0},
    {"section 3.1, pool hall: packets of 8x8 against 2x2, paper path", 1.5, 0, false, false, beyond_simd, "poolhall",
        0},
    {"section 4, rtrt: choosing one way at glass traces fewer rays than following both", 1.2, 0, false, true,
        rays_of_both, "rtrt", 0},
    {"section 4, pool hall: Kensler and Shirley's test and ours differ for at most one primary ray in a thousand", 0, 1,
        false, true, unlike_kensler, "poolhall", 0},
    {"section 5.4, conference: ray types against runs, speed", 1.10, 0, false, false, ahead_of_runs, "conference", 0},
    {"section 5.4, rtrt: ray types against runs, speed", 1.10, 0, false, false, ahead_of_runs, "rtrt", 0},
    {"section 5.4, pool hall: ray types against runs, speed", 1.10, 0, false, false, ahead_of_runs, "poolhall", 0},
    {"ray casting with shading against Embree's best coherent mode without", 0.5, 0, false, false, against_embree, NULL,
        0}};
enum { CLAIMS = sizeof claims / sizeof *claims };

/* Written this way round, what is not a number holds nothing. */
static bool enough(const claim *c, double figure) {
  return c->more ? figure > c->least : !(c->least > 0) || figure >= c->least;
}
static bool not_too_much(const claim *c, double figure) { return !(c->most > 0) || figure <= c->most; }

static const char *bounds_text(const claim *c, char text[64]) {
  char least[32] = "", most[32] = "";
  if (c->least > 0) snprintf(least, sizeof least, "%s %.2fx", c->more ? "more than" : "at least", c->least);
  if (c->most > 0) snprintf(most, sizeof most, "%sat most %.2fx", c->least > 0 ? ", " : "", c->most);
  snprintf(text, 64, "%s%s", least, most);
  return text;
}

typedef enum verdict { PASSED, FAILED, SKIPPED, VERDICTS } verdict;

static verdict check(bench *b, const claim *c, control is) {
  static const char *const words[CONTROLS] = {"", "control, too low: ", "control, too high: "};
  char details[DETAILS], bounds[64];
  b->row_count = 0;
  const double figure = c->figure(b, c, is, details);
  if (figure < 0) {
    printf("skipped  %s: built without Embree 3 (make deps-extra installs it)\n", c->sentence);
    return SKIPPED;
  }
  const bool held = is == TOO_LOW    ? enough(c, figure)
                    : is == TOO_HIGH ? not_too_much(c, figure)
                                     : enough(c, figure) && not_too_much(c, figure);
  printf("%s%s  %s: %.3fx, wanted %s (%s)\n", words[is], held ? "ok" : "FAILED", c->sentence, figure,
      bounds_text(c, bounds), details);
  fflush(stdout);
  if (isnan(figure)) return FAILED; /* as a control, too: it must fail by its figure */
  return held == (is == NO_CONTROL) ? PASSED : FAILED;
}

/* Returns whether all is as it must be: claims hold, or controls fail. */
static bool check_all(bench *b) {
  const options *o = &b->given;
  int count[VERDICTS] = {0, 0, 0};
  b->out.name = o->controls ? "controls" : "checks";
  if (o->controls) printf("Controls: each is expected to say FAILED.\n\n");
  for (int i = 0; i < CLAIMS; i++) {
    const claim *c = &claims[i];
    if (o->counts && !c->counted) continue;
    if (!o->controls) count[check(b, c, NO_CONTROL)]++;
    if (o->controls && c->least > 0) count[check(b, c, TOO_LOW)]++;
    if (o->controls && c->most > 0) count[check(b, c, TOO_HIGH)]++;
  }
  if (count[SKIPPED]) printf("%d skipped\n", count[SKIPPED]);
  if (o->controls) printf("%d controls failed as they must, %d did not\n", count[PASSED], count[FAILED]);
  else printf("%d passed, %d failed\n", count[PASSED], count[FAILED]);
  return count[FAILED] == 0;
}

#endif /* PAPER_CHECKS_H */
