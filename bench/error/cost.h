/* cost.h - what passes and their estimates cost in instructions, counted by valgrind's callgrind.

   This program is run once more under callgrind, as its part `cost-run`, which renders one case after another by
   cost_render: instructions are collected inside it alone, and written down where cost_mark is called. Counts do not
   depend on what else the machine does. (Valgrind knows no AVX-512: kernels are those of AVX2.) */
#ifndef ERROR_COST_H
#define ERROR_COST_H

#include "error.h"
#include "scatter.h"

typedef enum cost_way {
  COST_ONE_SET, /* one render of as many samples, all in one set: no sums, no estimates */
  COST_PASSES,  /* passes in one render, without estimates */
  COST_REPORT,  /* passes and estimates at the end */
  COST_WATCHED, /* passes and estimates after each */
  COST_TWICE,   /* as COST_PASSES, twice as many: does the count count? */
  COST_WAYS
} cost_way;

/* One sample a pass is compared with no set: a pass of one sample alone has it in the middle of the pixel, outside DRT,
   which saves it the sampler. */
enum { COST_PASS_COUNT = 4, COST_CASES = 5, COST_CHECKED = 2, COST_WIDTH = 64, COST_HEIGHT = 48 };
static const struct {
  const char *name, *on; /* NULL: the soft shadow's floor */
  pktrt_mode mode;
  uint32_t samples;
} cost_cases[COST_CASES] = {{"floor, RCS, 1 sample", NULL, PKTRT_MODE_RCS, 1},
    {"floor, DRT, 4 samples", NULL, PKTRT_MODE_DRT, 4}, {"rtrt, RCS, 1 sample", "rtrt", PKTRT_MODE_RCS, 1},
    {"rtrt, WRT, 1 sample", "rtrt", PKTRT_MODE_WRT, 1}, {"rtrt, DRT, 4 samples", "rtrt", PKTRT_MODE_DRT, 4}};

static bool go_on(void *user, const pktrt_report *r) {
  (void)user, (void)r;
  return true;
}

/* Not inlined, not cloned: callgrind knows them by their names. */
#if defined(__GNUC__)
#define COST_NAMED __attribute__((noinline, used))
#else
#define COST_NAMED
#endif
static volatile int cost_marks;
COST_NAMED static void cost_mark(void) { cost_marks = cost_marks + 1; }

COST_NAMED static void cost_render(const stage *g, uint32_t samples, int way) {
  pktrt_render_desc d = g->view;
  pktrt_report report;
  d.pixels = g->pixels, d.seed = FIRST_SEED;
  d.samples = way == COST_ONE_SET ? COST_PASS_COUNT * samples : samples;
  d.passes = way == COST_ONE_SET ? 1 : way == COST_TWICE ? 2 * COST_PASS_COUNT : COST_PASS_COUNT;
  if (way == COST_REPORT || way == COST_WATCHED) d.report = &report;
  if (way == COST_WATCHED) d.pass = go_on;
  if (pktrt_render(g->world, &d) != PKTRT_OK) fatal(pktrt_last_error(g->world));
}

/* Under callgrind: the given cases, all ways of each. */
static void cost_run(int first, int cases) {
  static stage g;
  for (int i = first; i < first + cases; i++) {
    const char *on = cost_cases[i].on, *before = i > first ? cost_cases[i - 1].on : NULL;
    if (!on) open_soft_shadow(&g, COST_HEIGHT);
    else if (!before) stage_open(&g, on, cost_cases[i].mode, COST_WIDTH, COST_HEIGHT);
    g.view.mode = cost_cases[i].mode;
    for (int way = 0; way < COST_WAYS; way++) cost_render(&g, cost_cases[i].samples, way), cost_mark();
    if (i + 1 == first + cases || !on) stage_close(&g);
  }
}

static void part_cost_floor(bench *b) { (void)b, cost_run(0, COST_CHECKED); }
static void part_cost_run(bench *b) { (void)b, cost_run(0, COST_CASES); }

/* The instructions in a file of callgrind's. */
static double callgrind_total(const char *path) {
  char line[512];
  double total = NAN;
  FILE *file = fopen(path, "r");
  while (file && fgets(line, sizeof line, file))
    if (sscanf(line, "totals: %lf", &total) == 1 || sscanf(line, "summary: %lf", &total) == 1) break;
  if (file) fclose(file);
  remove(path);
  return total;
}

/* Counts of a run; false where there is no valgrind. */
static bool count_costs(const char *part, int cases, double counts[][COST_WAYS]) {
  char self[1024], folder[] = "/tmp/pktrt-cost-XXXXXX", command[2048], path[128];
  const ssize_t length = readlink("/proc/self/exe", self, sizeof self - 1);
  if (system("command -v valgrind >/dev/null 2>&1") != 0 || length <= 0 || !mkdtemp(folder)) return false;
  self[length] = 0;
  snprintf(command, sizeof command,
      "valgrind --tool=callgrind --collect-atstart=no --toggle-collect=cost_render --dump-before=cost_mark "
      "--callgrind-out-file=%s/out '%s' %s >%s/log 2>&1",
      folder, self, part, folder);
  const bool ran = system(command) == 0;
  for (int i = 0; i < cases * COST_WAYS; i++) {
    snprintf(path, sizeof path, "%s/out.%d", folder, i + 1);
    counts[i / COST_WAYS][i % COST_WAYS] = callgrind_total(path);
  }
  for (int i = 0; i < 2; i++) snprintf(path, sizeof path, "%s/%s", folder, i ? "out" : "log"), remove(path);
  rmdir(folder);
  return ran;
}

static void part_cost(bench *b) {
  double counts[COST_CASES][COST_WAYS];
  if (!count_costs("cost-run", COST_CASES, counts)) {
    say(&b->out, "valgrind is not installed (make deps-extra), or failed: instructions are not counted.\n");
    return;
  }
  csv(&b->out, "case,one_set,passes,estimates_at_the_end,estimates_after_each,twice_the_passes\n");
  say(&b->out, "%d passes, AVX2 kernels:\n\n", (int)COST_PASS_COUNT);
  say(&b->out,
      "| | instructions of a pixel and pass | estimates at the end | after each pass | passes with estimates after "
      "each, against one set of as many samples |\n|---|--:|--:|--:|--:|\n");
  for (int i = 0; i < COST_CASES; i++) {
    const double *n = counts[i], width = cost_cases[i].on ? COST_WIDTH : COST_HEIGHT;
    const double pixels = width * (double)COST_HEIGHT * COST_PASS_COUNT;
    csv(&b->out, "\"%s\",%.0f,%.0f,%.0f,%.0f,%.0f\n", cost_cases[i].name, n[COST_ONE_SET], n[COST_PASSES],
        n[COST_REPORT], n[COST_WATCHED], n[COST_TWICE]);
    say(&b->out, "| %s | %.0f | %+.2f%% | %+.2f%% |", cost_cases[i].name, n[COST_PASSES] / pixels,
        100 * (n[COST_REPORT] / n[COST_PASSES] - 1), 100 * (n[COST_WATCHED] / n[COST_PASSES] - 1));
    if (cost_cases[i].samples > 1) say(&b->out, " %+.2f%% |\n", 100 * (n[COST_WATCHED] / n[COST_ONE_SET] - 1));
    else say(&b->out, " |\n");
  }
  say(&b->out, "\n");
}

/* Percent that estimates add where there are next to no triangles: at the end of passes of a primary ray and a shadow
   ray, and after each pass of four DRT samples, the larger. The control: what twice the passes add. */
static double check_cost(bench *b, const claim *c, bool control, char details[DETAILS]) {
  double counts[COST_CHECKED][COST_WAYS];
  (void)c;
  if (!count_costs("cost-floor", COST_CHECKED, counts)) {
    snprintf(details, DETAILS, "valgrind is not installed (make deps-extra), or failed");
    b->skip = true;
    return NAN;
  }
  const double *end = counts[0], *each = counts[1];
  const double added[2] = {
      100 * (end[COST_REPORT] / end[COST_PASSES] - 1), 100 * (each[COST_WATCHED] / each[COST_PASSES] - 1)};
  snprintf(details, DETAILS, "%s, at the end: %.2f; %s, after each: %.2f; twice the passes: %.3f times as many",
      cost_cases[0].name, added[0], cost_cases[1].name, added[1], end[COST_TWICE] / end[COST_PASSES]);
  return control ? 100 * (end[COST_TWICE] / end[COST_PASSES] - 1) : larger(added[0], added[1]);
}

#endif /* ERROR_COST_H */
