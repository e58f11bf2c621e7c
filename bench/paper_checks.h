/* paper_checks.h - what the measurements must show, in smaller ones; each claim has a control, the same comparison of
   something with itself or the other way round, which has to fail. */
#ifndef PAPER_CHECKS_H
#define PAPER_CHECKS_H

#include "paper_embree.h"

enum { DETAILS = 256 };

typedef struct claim claim;
struct claim {
  const char *sentence;
  double least;       /* the figure is to be as much */
  bool more;          /* the figure is to be more than that */
  bool counted;       /* tests, which no noise changes */
  double (*figure)(bench *, const claim *, bool control, char details[DETAILS]);
  const char *scene;
};

static double against_single(bench *b, const setup *packets, bool control, char details[DETAILS]) {
  setup ways[2];
  ways[0] = ways[1] = *packets;
  ways[0].assembly = control ? PKTRT_ASSEMBLY_RAY_TYPES : PKTRT_ASSEMBLY_NONE;
  const row *r = measure(b, ways, 2);
  snprintf(details, DETAILS, "%.2f to %.2f Mrays/s", mrays(&r[0]), mrays(&r[1]));
  return times_as_fast(b, &r[1], &r[0]);
}

static double table1_on_paper_path(bench *b, const claim *c, bool control, char details[DETAILS]) {
  setup s = whitted(b, c->scene);
  column(0, &s);
  return against_single(b, &s, control, details);
}

/* On the widest instruction set, where packets have most to win. */
static double table1_on_fast_path(bench *b, const claim *c, bool control, char details[DETAILS]) {
  setup s = whitted(b, c->scene);
  column(columns() - 1, &s);
  return against_single(b, &s, control, details);
}

static double table3_of_64(bench *b, const claim *c, bool control, char details[DETAILS]) {
  setup s = one_frame(b, c->scene, PKTRT_MODE_DRT, 8);
  column(0, &s);
  return against_single(b, &s, control, details);
}

/* Runs, then ray types; the control has them the other way round. */
static const row *types_and_runs(bench *b, const claim *c, bool control) {
  setup ways[2];
  ways[0] = pruned(b, c->scene);
  column(0, &ways[0]);
  ways[1] = ways[0];
  ways[0].assembly = control ? PKTRT_ASSEMBLY_RAY_TYPES : PKTRT_ASSEMBLY_RUNS;
  ways[1].assembly = control ? PKTRT_ASSEMBLY_RUNS : PKTRT_ASSEMBLY_RAY_TYPES;
  return measure(b, ways, 2);
}

static double ahead_of_runs(bench *b, const claim *c, bool control, char details[DETAILS]) {
  const row *r = types_and_runs(b, c, control);
  snprintf(details, DETAILS, "vectors of tests per ray %.1f against %.1f; rays tested per vector %.1f against %.1f",
           per_ray(vector_tests(&r[1].all), &r[1].all), per_ray(vector_tests(&r[0].all), &r[0].all),
           lanes_used(&r[1].all), lanes_used(&r[0].all));
  return times_as_fast(b, &r[1], &r[0]);
}

/* The least advantage at any depth from 2 on, of those with a hundredth of all rays. */
static double deep_tests(bench *b, const claim *c, bool control, char details[DETAILS]) {
  const row *r = types_and_runs(b, c, control);
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

static double triangles_of_16x16(bench *b, const claim *c, bool control, char details[DETAILS]) {
  setup ways[2];
  ways[0] = ways[1] = whitted(b, c->scene);
  ways[1].packet = control ? 8 : 16;
  for (int i = 0; i < 2; i++) column(0, &ways[i]);
  const row *r = measure(b, ways, 2);
  const double small = per_ray(r[0].all.triangle_tests, &r[0].all), large = per_ray(r[1].all.triangle_tests, &r[1].all);
  snprintf(details, DETAILS, "%.3f per ray, 8x8 %.3f", large, small);
  return large / small;
}

static double tests_per_ray(const row *r) { return per_ray(r->all.box_tests + r->all.triangle_tests, &r->all); }

/* How much more the tests with united boxes have grown, from the shut shutter to the widest open one. */
static double growth_with_shutter(bench *b, const claim *c, bool control, char details[DETAILS]) {
  const row *r[2];
  for (int i = 0; i < 2; i++) {
    setup ways[2];
    ways[0] = one_frame(b, c->scene, PKTRT_MODE_DRT, 4);
    ways[0].shutter = i ? 1.0 / 30 : 0;
    column(0, &ways[0]);
    ways[1] = ways[0];
    ways[0].united = true;
    ways[1].united = control;
    r[i] = measure(b, ways, 2);
  }
  const double united = tests_per_ray(&r[1][0]) / tests_per_ray(&r[0][0]);
  const double moving = tests_per_ray(&r[1][1]) / tests_per_ray(&r[0][1]);
  snprintf(details, DETAILS, "from shut to a 30th of the loop boxes that move cost %.3fx the tests, united ones %.3fx",
           moving, united);
  return united / moving;
}

static double against_embree(bench *b, const claim *c, bool control, char details[DETAILS]) {
  (void)c;
  double least;
  const double mean = embree_rcs_check(b, control, &least);
  snprintf(details, DETAILS, "geometric mean of three scenes, the least %.3fx; %s", least,
           control ? "single rays, scalar" : "fast path");
  return mean;
}

static const claim claims[] = {
    {"table 1, conference, 8x8: packets against single rays, paper path", 2.85, false, false, table1_on_paper_path,
     "conference"},
    {"table 1, rtrt, 8x8: packets against single rays, paper path", 2.69, false, false, table1_on_paper_path,
     "rtrt"},
    {"table 1, pool hall, 8x8: packets against single rays, paper path", 2.97, false, false, table1_on_paper_path,
     "poolhall"},
    {"table 1, conference, 8x8: packets against single rays, fast path", 2, false, false, table1_on_fast_path,
     "conference"},
    {"table 1, rtrt, 8x8: packets against single rays, fast path", 2, false, false, table1_on_fast_path, "rtrt"},
    {"table 1, pool hall, 8x8: packets against single rays, fast path", 2, false, false, table1_on_fast_path,
     "poolhall"},
    {"table 3, 64 samples: packets against single rays, paper path", 3.03, false, false, table3_of_64, "conference"},
    {"figure 6: 16x16 costs more triangle tests than 8x8", 1, true, true, triangles_of_16x16, "conference"},
    {"figure 7: tests grow more slowly with the shutter where boxes move", 1, true, true, growth_with_shutter,
     "rtrt"},
    {"figure 8: ray types need fewer vectors of box tests than runs at depth", 1, true, true, deep_tests, "conference"},
    {"section 5.4, conference: ray types against runs, speed", 1.10, false, false, ahead_of_runs, "conference"},
    {"section 5.4, rtrt: ray types against runs, speed", 1.10, false, false, ahead_of_runs, "rtrt"},
    {"section 5.4, pool hall: ray types against runs, speed", 1.10, false, false, ahead_of_runs, "poolhall"},
    {"ray casting with shading against Embree's best coherent mode without", 0.5, false, false, against_embree,
     NULL}};
enum { CLAIMS = sizeof claims / sizeof *claims };

/* Written this way round, what is not a number holds nothing. */
static bool holds(const claim *c, double figure) {
  return c->more ? figure > c->least : figure >= c->least;
}

typedef enum verdict { PASSED, FAILED, SKIPPED, VERDICTS } verdict;

static verdict check(bench *b, const claim *c, bool control) {
  char details[DETAILS];
  b->row_count = 0;
  const double figure = c->figure(b, c, control, details);
  const bool held = holds(c, figure);
  if (figure < 0) {
    printf("skipped  %s: built without Embree 3 (make deps-extra installs it)\n", c->sentence);
    return SKIPPED;
  }
  printf("%s%s  %s: %.3fx, wanted %s %.2fx (%s)\n", control ? "control " : "", held ? "ok" : "FAILED", c->sentence,
         figure, c->more ? "more than" : "at least", c->least, details);
  fflush(stdout);
  if (isnan(figure)) return FAILED; /* as a control, too: it must fail by its figure */
  return held != control ? PASSED : FAILED;
}

/* Returns whether all is as it must be: claims hold, or controls fail. */
static bool check_all(bench *b) {
  const options *o = &b->given;
  int count[VERDICTS] = {0, 0, 0};
  b->out.name = o->controls ? "controls" : "checks";
  if (o->controls) printf("Controls: each is expected to say FAILED.\n\n");
  for (int i = 0; i < CLAIMS; i++)
    if (!o->counts || claims[i].counted) count[check(b, &claims[i], o->controls)]++;
  if (count[SKIPPED]) printf("%d skipped\n", count[SKIPPED]);
  if (o->controls) printf("%d controls failed as they must, %d did not\n", count[PASSED], count[FAILED]);
  else printf("%d passed, %d failed\n", count[PASSED], count[FAILED]);
  return count[FAILED] == 0;
}

#endif /* PAPER_CHECKS_H */
