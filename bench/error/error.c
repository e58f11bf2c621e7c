/* Error against run time:

     make error                                everything, in ten minutes; results go to out/results
     make error-check                          what must hold, in small, in two minutes
     build/error [options] [PART...]           see --help

   Method, formulas and results stand in README.md; error.h says how to add parts and checks. */
#include "bars.h"
#include "bias.h"
#include "blue.h"
#include "bounds.h"
#include "cost.h"
#include "curves.h"
#include "display.h"
#include "error.h"
#include "estimates.h"
#include "filter.h"
#include "flicker.h"
#include "slopes.h"
#include "split.h"
#include "sun.h"
#include <getopt.h>

/* >>checks --------------------------------------------------------------------------------------------------------- */

static const claim claims[] = {
    {"slope on smooth integrands in 1 dimension, Sobol', N = 4 to 256", -1.2, true, check_slope, "smooth", 1, 0},
    {"slope on smooth integrands in 2 dimensions", -1.2, true, check_slope, "smooth", 2, 0},
    {"slope on smooth integrands in 4 dimensions", -1.2, true, check_slope, "smooth", 4, -1.12},
    {"slope on steps in 1 dimension", -0.9, true, check_slope, "step", 1, 0},
    {"slope on steps in 2 dimensions", -0.70, true, check_slope, "step", 2, 0},
    {"slope on steps in 4 dimensions", -0.56, true, check_slope, "step", 4, 0},
    {"slope on the closed-form scenes", -0.45, true, check_scene_slope, NULL, 0, 0},
    {"slope on the DRT scenes", -0.45, true, check_scene_slope, NULL, 1, 0},
    {"RMSE at equal time over random, 16 samples, closed-form scenes", 0.6, true, check_equal_time, "closed", 16, 0.70},
    {"RMSE at equal time over random, 64 samples, closed-form scenes", 0.6, true, check_equal_time, "closed", 64, 0},
    {"RMSE at equal time over random, 16 samples, DRT scenes", 0.75, true, check_equal_time, "DRT", 16, 0.95},
    {"RMSE at equal time over random, 64 samples, DRT scenes", 0.65, true, check_equal_time, "DRT", 64, 0.85},
    {"runs whose estimate is within 25% of the truth, closed-form scenes", 0.95, false, check_estimates, "closed", 0,
        0},
    {"runs whose estimate is within 25% of the truth, DRT scenes", 0.95, false, check_estimates, "DRT", 0, 0},
    {"runs that met their target, uniform, closed-form scenes", 0.95, false, check_targets, "closed", 0, 0},
    {"runs that met their target, adaptive, closed-form scenes", 0.95, false, check_targets, "closed", 1, 0},
    {"runs that met their target, uniform, DRT scenes", 0.95, false, check_targets, "DRT", 0, 0.8},
    {"runs that met their target, adaptive, DRT scenes", 0.95, false, check_targets, "DRT", 1, 0},
    {"time of adaptive passes over one uniform set for equal error, pool hall", 0.75, true, check_adaptive, NULL, 1, 0},
    {"the same, largest of the built-in scenes", 1.0, true, check_adaptive, NULL, 0, 1.3},
    {"runs whose estimate as shown is within 25% of the truth, of those not called unreliable", 0.95, false,
        check_shown, NULL, 0, 0},
    {"time of adaptive passes over one set for equal error as shown, mean of the DRT scenes", 0.8, true,
        check_shown_time, NULL, 0, 0},
    {"the same for errors as shown, the largest", 1.0, true, check_shown_time, NULL, 1, 1.15},
    {"RMSE of a sun over that of a far sphere with as many samples, as a light", 1.3, true, check_sun, NULL, SUN_LIGHT,
        0},
    {"the same, in the callback of the environment", 4, true, check_sun, NULL, SUN_CALLBACK, 0},
    {"flicker of still pixels with static sets, pool hall", 0, true, check_flicker, "poolhall", 0, 0},
    {"flicker of still pixels with static sets, conference", 0, true, check_flicker, "conference", 0, 0},
    {"flicker of still pixels with static sets, rtrt", 0, true, check_flicker, "rtrt", 0, 0},
    {"filtered over unfiltered RMSE, 8 samples, mean of the DRT scenes", 0.6, true, check_filter, NULL, 8, 0},
    {"filtered over unfiltered RMSE, 16 samples", 0.7, true, check_filter, NULL, 16, 0},
    {"filtered over unfiltered RMSE, 64 samples", 0.85, true, check_filter, NULL, 64, 0},
    {"filtered over unfiltered RMSE, the largest at 4 to 256 samples", 1.02, true, check_filter, NULL, 0, 0},
    {"filtered over unfiltered on a screen, the largest of all small and built-in scenes", 1.02, true, check_screen,
        NULL, 0, 0},
    {"filtered over unfiltered on a screen, mean of the smooth scenes", 0.6, true, check_screen, NULL, 1, 0},
    {"filtered: estimates not called unreliable within 0.7 to 1.3 times the truth", 1, false, check_screen, NULL, 2,
        0.94},
    {"filtered: estimates called unreliable", 0.3, true, check_screen, NULL, 3, 0},
    {"percent of instructions that knowing the error adds", 2, true, check_cost, NULL, 0, 0},
};
enum { CLAIMS = sizeof claims / sizeof *claims };

/* >>parts ---------------------------------------------------------------------------------------------------------- */

static const struct part {
  const char *name, *sentence; /* a part NAME keeps error_NAME.csv and .md; without a sentence it runs if named only */
  void (*run)(bench *);
} parts[] = {
    {"slopes", "slope of the error over samples on smooth integrands and steps, by sampler", part_slopes},
    {"bounds", "what Sobol' points err, and the least that points can err", part_bounds},
    {"closed", "error against run time of scenes with a closed form, by sampler", part_closed},
    {"scenes", "error against run time of the built-in scenes, WRT and DRT, by sampler", part_scenes},
    {"estimates", "estimated error against the truth", part_estimates},
    {"bars", "how far reports can be believed from two passes on", part_bars},
    {"targets", "true error where a render has stopped at a target", part_targets},
    {"adaptive", "time of adaptive passes for the error of one uniform set", part_adaptive},
    {"display", "the error as a screen shows it: estimates, and time of adaptive passes", part_display},
    {"flicker", "static sets against fresh ones in an animation", part_flicker},
    {"blue", "what is left of the error after a small blur, by sampler", part_blue},
    {"bias", "what ray-tree attenuation takes from pictures, and the time it saves", part_bias},
    {"split", "what N samples in several passes lose against one set", part_split},
    {"cost", "what passes and estimates cost in instructions", part_cost},
    {"filter", "what examples/filter.h leaves of the error", part_filter},
    {"shown", "the same as a screen shows it, in small scenes", part_filter_shown},
    {"sun", "a sun as a light and in the environment, against a far sphere", part_sun},
    {"placements", "suns in many places of the environment: how many are lost", part_placements},
    {"cost-run", NULL, part_cost_run}, /* of the part cost, under callgrind */
    {"cost-floor", NULL, part_cost_floor},
};
enum { PARTS = sizeof parts / sizeof *parts };

/* >>main ----------------------------------------------------------------------------------------------------------- */

static void print_help(void) {
  printf("usage: error [options] [PART...]   error against run time; on one core, but for references\n"
         "  --results DIR      error_PART.csv and .md of each part\n"
         "  --references DIR   where references are kept, and found again\n"
         "  --threads N        for what is not timed, 1 to %d (as many as there are cores)\n"
         "  --seed N           the first seed of filtered runs as a screen shows them (1): others than those by which "
         "the\n"
         "                     filter's constants were chosen, 501\n"
         "  --check            instead of parts: what must hold, and that controls fail; exit status 1 if not;\n"
         "                     of these, PART picks by words of their sentences\n"
         "  --help             this text\nPART, without one all:\n",
      (int)EX_MAX_THREADS);
  for (int i = 0; i < PARTS; i++)
    if (parts[i].sentence) printf("  %-13s %s\n", parts[i].name, parts[i].sentence);
}

static bool parse_option(options *o, int key) {
  switch (key) {
  case 'o': o->results = optarg; return true;
  case 'r': o->references = optarg; return true;
  case 't': return ex_parse_uint("threads", optarg, 1, EX_MAX_THREADS, &o->threads);
  case 's': return ex_parse_uint("seed", optarg, 1, 999, &o->seed);
  case 'k': return o->check = true;
  case 'h': print_help(); exit(0);
  default: return false; /* getopt has said what */
  }
}

static bool parse_options(int argc, char **argv, options *o) {
  static const struct option list[] = {{"results", required_argument, NULL, 'o'},
      {"references", required_argument, NULL, 'r'}, {"threads", required_argument, NULL, 't'},
      {"seed", required_argument, NULL, 's'}, {"check", no_argument, NULL, 'k'}, {"help", no_argument, NULL, 'h'},
      {NULL, 0, NULL, 0}};
  memset(o, 0, sizeof *o);
  o->threads = ex_processors();
  o->seed = FIRST_SEED;
  for (int key; (key = getopt_long(argc, argv, "h", list, NULL)) != -1;)
    if (!parse_option(o, key)) return false;
  for (; optind < argc; optind++) {
    if (o->name_count == MAX_NAMES) return ex_fail("%s: one name too many", argv[optind]);
    o->names[o->name_count++] = argv[optind];
  }
  return true;
}

static bool names_known(const options *o) {
  for (unsigned n = 0; n < o->name_count && !o->check; n++) {
    bool known = false;
    for (int i = 0; i < PARTS; i++) known = known || !strcmp(o->names[n], parts[i].name);
    if (!known) return ex_fail("%s: no such part; see --help", o->names[n]);
  }
  return true;
}

static void run_part(bench *b, const struct part *p) {
  char name[64];
  snprintf(name, sizeof name, "error_%s", p->name);
  results_open(&b->out, b->given.results, name);
  const double start = ex_seconds(), cpu = cpu_seconds();
  if (p->sentence) printf("### %s: %s\n\n", p->name, p->sentence);
  p->run(b);
  results_close(&b->out);
  fprintf(stderr, "%s: %.0f s, %.0f s of processors\n", name, ex_seconds() - start, cpu_seconds() - cpu);
  fflush(stdout);
}

int main(int argc, char **argv) {
  static bench b; /* static: zeroed */
  bool failed = false;
  bench_begin(argc, argv);
  if (!parse_options(argc, argv, &b.given) || !names_known(&b.given)) return 2;
  if (!seeds_disjoint()) fatal("seeds of references are among those of runs");
  if (b.given.references && mkdir(b.given.references, 0777) != 0 && errno != EEXIST)
    return ex_fail("%s: cannot be made: %s", b.given.references, strerror(errno)), 1;
  find_cores();
  pin(true);
  if (b.given.check) failed = !check_claims(&b, claims, CLAIMS);
  for (int i = 0; i < PARTS && !b.given.check; i++)
    if ((parts[i].sentence || b.given.name_count) && wanted(&b.given, parts[i].name)) run_part(&b, &parts[i]);
  if (fflush(stdout) != 0) return ex_fail("the tables could not be written: %s", strerror(errno)), 1;
  return failed;
}
