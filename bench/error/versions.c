/* Error of two versions of pktrt at equal time: that of commit BEFORE, 0.5.1 unless said, and that of today.

     make error-before                          all scenes; SCENES="sky lamps" of these; BENCH_ARGS=... passes options
     make error-before-check                    that it finds no difference where none is, and one where one is
     build/error-before/versions [options] [SCENE...]     see --help

   For N samples the version before takes the time T. Today's renders with m and 2 m samples, the powers of two between whose
   times T lies. Two rules tell its RMSE at T, and the figure is that over the one before; below 1 is better:

     line   on the straight line between the two in logarithms; scenes with a closed form are judged by it
     root   from the one of the two whose time is nearer to T, as if the RMSE fell with the root of the time; other scenes
            are judged by it, for rare bright samples make the line lean at random

   Each version is judged by a reference of its own, of another seed.

   Contents: options, bars, races, report, samples, checks, main. */
#include "../bench.h"
#include "version.h"
#include <getopt.h>

enum { BEFORE, NOW, VERSIONS, FEW = 2, MAX_SEEDS = 64, MAX_SCENES = 32 };
static const version *const versions[VERSIONS] = {&version_before, &version_now};
static const uint32_t counts[FEW] = {16, 64};

/* >>options -------------------------------------------------------------------------------------------------------- */

typedef struct options {
  unsigned width, height, seeds, reference, threads;
  int lights[VERSIONS];
  bool adaptive[VERSIONS];
  const char *results, *references;
  const char *scenes[MAX_SCENES];
  unsigned scene_count;
  bool check, samples, shown;
} options;

/* >>bars ----------------------------------------------------------------------------------------------------------- */

typedef struct bar {
  const char *scene;
  double most, aim;
  bool upper; /* the upper end of the interval is what counts */
} bar;

static const bar bars[] = {{"poolhall", 0.6, 0.4, false}, {"rtrt", 0.85, 0.6, false}, {"conference", 1.0, 0.7, true},
    {"lamps", 0.4, 0.25, false}, {"sky", 0.4, 0.25, false}, {"closed-edge", 1.03, 0, false},
    {"closed-motion", 1.03, 0, false}, {"closed-lens", 1.03, 0, false}, {"closed-quad", 1.03, 0, false},
    {"closed-penumbra", 1.03, 0, false}, {"closed-sphere", 1.03, 0, false}, {"closed-sky", 1.03, 0, false},
    {"closed-gloss", 1.03, 0, false}};
enum { BARS = sizeof bars / sizeof *bars };
static const double samples_bar = 1.5; /* time of a sample with 1,000 lamps over that with ten */

/* Returns NULL for scenes without a bar. */
static const bar *bar_of(const char *scene) {
  for (int i = 0; i < BARS; i++)
    if (!strcmp(bars[i].scene, scene)) return &bars[i];
  return NULL;
}

/* >>races ---------------------------------------------------------------------------------------------------------- */

typedef struct contest { /* who races; controls let a version race itself, with other seeds, or make it worse */
  const version *by[VERSIONS];
  uint32_t seed[VERSIONS];
  double error_factor, time_factor; /* of the second */
} contest;

typedef enum rule { LINE, ROOT, RULES } rule; /* how the RMSE at the time T is told */

static rule rule_of(const char *scene) { return strncmp(scene, "closed-", 7) ? ROOT : LINE; }

typedef struct race { /* one scene, N samples of the version before */
  char scene[48];
  uint32_t n, m; /* m: today's samples at the lower end; 2 m at the upper one */
  unsigned seeds;
  double mse[3][MAX_SEEDS], seconds[3]; /* with N before, m and 2 m now */
  double longer[3]; /* their times over that of m: medians over seeds, whose runs lie side by side */
  double apart;     /* of the two truths, over their mean */
  struct {
    double value, low, high; /* RMSE at equal time, now over before; 95% */
  } figure[RULES];
} race;

/* Student's t for 95%: the expansion in 1/df is within 2% from three on. */
static double student(unsigned df) {
  static const double small[2] = {12.71, 4.30};
  const double z = 1.959964, z3 = z * z * z, z5 = z3 * z * z, n = (double)df;
  if (df < 3) return df ? small[df - 1] : HUGE_VAL;
  return z + (z3 + z) / (4 * n) + (5 * z5 + 16 * z3 + 3 * z) / (96 * n * n);
}

/* The log of the figure without seed `left_out`, or with all if there is no such seed. */
static double log_figure(const race *r, rule by, unsigned left_out) {
  double sum[3] = {0, 0, 0}, count = 0, half[3];
  for (unsigned k = 0; k < r->seeds; k++) {
    if (k == left_out) continue;
    for (int i = 0; i < 3; i++) sum[i] += r->mse[i][k];
    count++;
  }
  for (int i = 0; i < 3; i++) half[i] = 0.5 * log(sum[i] / count);
  const double t = log(r->longer[0]) / log(r->longer[2]);
  const int nearer = t > 0.5 ? 2 : 1;
  if (by == ROOT) return half[nearer] - half[0] + 0.5 * log(r->longer[nearer] / r->longer[0]);
  return (1 - t) * half[1] + t * half[2] - half[0];
}

/* The interval is that of a jackknife over seeds, on the log of the figure: seeds go with both versions. Times are
   taken as known. */
static void judge(race *r, rule by) {
  const double all = log_figure(r, by, r->seeds);
  double mean = 0, spread = 0, part[MAX_SEEDS];
  for (unsigned k = 0; k < r->seeds && r->seeds > 1; k++) part[k] = log_figure(r, by, k), mean += part[k] / r->seeds;
  for (unsigned k = 0; k < r->seeds && r->seeds > 1; k++) spread += (part[k] - mean) * (part[k] - mean);
  const double n = (double)r->seeds;
  const double off = r->seeds > 1 ? student(r->seeds - 1) * sqrt((n - 1) / n * spread) : HUGE_VAL;
  r->figure[by].value = exp(all), r->figure[by].low = exp(all - off), r->figure[by].high = exp(all + off);
}

/* Spreads the seeds of runs over all that there are. WHY: in rtrt, seeds 1 to 8 erred 11% less than 1001 to 1008, of which
   the interval knew nothing; spread ones are within it. */
static uint32_t seed_of(uint32_t first, unsigned k) {
  const uint32_t golden = 0x9E3779B9u, x = (first + k) * golden;
  return (x ^ x >> 15) * golden;
}

static judged take_one(const contest *c, int v, void *scene, uint32_t samples, unsigned k) {
  judged j = c->by[v]->take(scene, samples, seed_of(c->seed[v], k));
  if (v == NOW) j.mse *= c->error_factor * c->error_factor, j.seconds *= c->time_factor;
  return j;
}

/* A power of two: so many samples of today take no longer than N before, or one. */
static uint32_t samples_in_time(const contest *c, void *const scene[VERSIONS], uint32_t n) {
  enum { MOST = 32768 };
  const double time = take_one(c, BEFORE, scene[BEFORE], n, 0).seconds;
  const double each = take_one(c, NOW, scene[NOW], n, 0).seconds / n;
  uint32_t m = 1;
  while (m < MOST && 2 * m * each <= time * 1.01) m *= 2;
  return m;
}

static void race_samples(const contest *c, void *const scene[VERSIONS], race *r) {
  double seconds[3][MAX_SEEDS];
  r->m = samples_in_time(c, scene, r->n);
  for (unsigned k = 0; k < r->seeds; k++)
    for (unsigned turn = 0; turn < 3; turn++) {
      const unsigned i = (turn + k) % 3;
      const uint32_t samples = i == 0 ? r->n : i * r->m;
      const judged j = take_one(c, i ? NOW : BEFORE, scene[i ? NOW : BEFORE], samples, k);
      r->mse[i][k] = j.mse, seconds[i][k] = j.seconds;
    }
  for (int i = 0; i < 3; i++) {
    double over[MAX_SEEDS];
    for (unsigned k = 0; k < r->seeds; k++) over[k] = seconds[i][k] / seconds[1][k];
    r->longer[i] = median_of(over, r->seeds);
  }
  for (int i = 0; i < 3; i++) r->seconds[i] = median_of(seconds[i], r->seeds);
  judge(r, LINE), judge(r, ROOT);
}

/* The root mean square of what lies between the two truths beyond their own errors, over their mean. */
static double truths_apart(const contest *c, void *const scene[VERSIONS], size_t pixels) {
  const double *doubt[VERSIONS], *truth[VERSIONS];
  double sum = 0, mean = 0;
  for (int v = 0; v < VERSIONS; v++) truth[v] = c->by[v]->truth(scene[v], &doubt[v]);
  for (size_t i = 0; i < pixels * 3; i++) {
    const double off = truth[NOW][i] - truth[BEFORE][i];
    sum += off * off, mean += 0.5 * (truth[NOW][i] + truth[BEFORE][i]);
  }
  for (size_t i = 0; i < pixels; i++)
    for (int v = 0; v < VERSIONS; v++) sum -= doubt[v] ? doubt[v][i] : 0;
  const double n = 3 * (double)pixels;
  return sqrt(fmax(0, sum) / n) / (mean / n);
}

static const char *directory_of(const options *o, const version *v, char *path, size_t room) {
  if (!o->references) return NULL;
  const int n = snprintf(path, room, "%s/%s", o->references, v->name);
  if (n < 0 || (size_t)n >= room) fatal("the name of a directory is too long");
  if ((mkdir(o->references, 0777) != 0 && errno != EEXIST) || (mkdir(path, 0777) != 0 && errno != EEXIST))
    fatal("references have no directory");
  return path;
}

static void *open_for(const options *o, const version *v, const char *scene, int of) {
  char path[4096];
  request q;
  q.scene = scene, q.width = o->width, q.height = o->height, q.reference_samples = o->reference;
  q.lights = o->lights[of], q.adaptive = o->adaptive[of], q.threads = o->threads;
  q.shown = o->shown;
  q.references = directory_of(o, v, path, sizeof path);
  return v->open(&q);
}

static void race_scene(const options *o, const contest *c, const char *scene, race out[FEW]) {
  void *open[VERSIONS];
  for (int v = 0; v < VERSIONS; v++) open[v] = open_for(o, c->by[v], scene, v);
  const double apart = truths_apart(c, open, (size_t)o->width * o->height);
  for (int i = 0; i < FEW; i++) {
    memset(&out[i], 0, sizeof out[i]);
    snprintf(out[i].scene, sizeof out[i].scene, "%s", scene);
    out[i].n = counts[i], out[i].seeds = o->seeds, out[i].apart = apart;
    race_samples(c, open, &out[i]);
  }
  for (int v = 0; v < VERSIONS; v++) c->by[v]->close(open[v]);
}

/* >>report --------------------------------------------------------------------------------------------------------- */

static const char *verdict(double figure, double most, double aim) {
  return !(figure <= most) ? "NOT REACHED" : aim > 0 && figure <= aim ? "aim reached" : "reached";
}

static void report_head(const results *to) {
  say(to, "RMSE at equal time, now over before, with its interval of 95%% over seeds. Scenes with a closed form are "
          "judged by "
          "the line, others by the root.\n\n"
          "| scene | samples before | s | samples now | s | RMSE before | now | line | root | wanted (aim) | | truths "
          "apart "
          "|\n|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|---|--:|\n");
  csv(to, "scene,n,m,seconds_before,seconds_m,seconds_2m,seed,mse_before,mse_m,mse_2m,line,line_low,line_high,root,"
          "root_low,"
          "root_high,apart\n");
}

static double mean_rmse(const race *r, int i) {
  double sum = 0;
  for (unsigned k = 0; k < r->seeds; k++) sum += r->mse[i][k];
  return sqrt(sum / r->seeds);
}

static void report_race(const results *to, const race *r) {
  const bar *b = bar_of(r->scene);
  const rule by = rule_of(r->scene);
  say(to, "| %s | %u | %.3f | %u, %u | %.3f, %.3f | %.4g | %.4g, %.4g |", r->scene, (unsigned)r->n, r->seconds[0],
      (unsigned)r->m, (unsigned)(2 * r->m), r->seconds[1], r->seconds[2], mean_rmse(r, 0), mean_rmse(r, 1),
      mean_rmse(r, 2));
  for (int i = 0; i < RULES; i++)
    say(to, " %.3f (%.3f to %.3f) |", r->figure[i].value, r->figure[i].low, r->figure[i].high);
  if (b) say(to, " %s%.2f", b->upper ? "upper end " : "", b->most);
  if (b && b->aim > 0) say(to, " (%.2f)", b->aim);
  say(to, " | %s | %.2f%% |\n", b ? verdict(b->upper ? r->figure[by].high : r->figure[by].value, b->most, b->aim) : "",
      100 * r->apart);
  for (unsigned k = 0; k < r->seeds; k++) {
    csv(to, "%s,%u,%u,%.6f,%.6f,%.6f,%u,%.9g,%.9g,%.9g", r->scene, (unsigned)r->n, (unsigned)r->m, r->seconds[0],
        r->seconds[1], r->seconds[2], k, r->mse[0][k], r->mse[1][k], r->mse[2][k]);
    for (int i = 0; i < RULES; i++) csv(to, ",%.5f,%.5f,%.5f", r->figure[i].value, r->figure[i].low, r->figure[i].high);
    csv(to, ",%.6f\n", r->apart);
  }
  fflush(stdout);
}

static const contest real_contest = {{&version_before, &version_now}, {1, 1}, 1, 1};

static void report_scenes(const options *o, const results *to) {
  report_head(to);
  for (unsigned i = 0; i < o->scene_count; i++) {
    race r[FEW];
    race_scene(o, &real_contest, o->scenes[i], r);
    for (int k = 0; k < FEW; k++) report_race(to, &r[k]);
  }
}

/* >>samples -------------------------------------------------------------------------------------------------------- */

/* Prints the time of a sample under 1,000 lamps over that under ten, of each version with its choice of lights. */
static void report_samples(const options *given, const results *to) {
  static const char *const scenes[2] = {"lamps", "lamps-few"};
  options o = *given;
  o.reference = 0, o.references = NULL;
  say(to, "\n| version | lights | ms a sample of the picture, 1,000 lamps | ten lamps | ratio | wanted | |\n"
          "|---|---|--:|--:|--:|--:|---|\n");
  for (int v = 0; v < VERSIONS; v++) {
    static const char *const names[LIGHTS] = {"all", "one deeper", "one"};
    double seconds[2][MAX_SEEDS], each[2];
    void *open[2];
    for (int i = 0; i < 2; i++) open[i] = open_for(&o, versions[v], scenes[i], v);
    for (unsigned k = 0; k < o.seeds; k++)
      for (int i = 0; i < 2; i++) seconds[i][k] = versions[v]->take(open[i], counts[0], 1 + k).seconds;
    for (int i = 0; i < 2; i++) each[i] = 1e3 * median_of(seconds[i], o.seeds) / counts[0], versions[v]->close(open[i]);
    say(to, "| %s | %s | %.3f | %.3f | %.2f |", versions[v]->name, names[o.lights[v]], each[0], each[1],
        each[0] / each[1]);
    if (v == NOW) say(to, " %.2f | %s |\n", samples_bar, verdict(each[0] / each[1], samples_bar, 0));
    else say(to, " | |\n");
  }
}

/* >>checks --------------------------------------------------------------------------------------------------------- */

/* The version before against itself, with other seeds: the interval, and 3% more for the clock, must hold 1. With twice the
   error, with four times the time, or both ways better it must not. */
static bool check_scene(const options *o, const char *scene) {
  enum { WAYS = 5 };
  static const double factor[WAYS][2] = {{1, 1}, {2, 1}, {1, 4}, {0.5, 1}, {1, 0.25}};
  static const char *const names[WAYS] = {
      "against itself", "twice the error", "four times the time", "half the error", "a quarter of the time"};
  bool good = true;
  for (int w = 0; w < WAYS; w++) {
    contest c = {{&version_before, &version_before}, {1, 1001}, factor[w][0], factor[w][1]};
    race r[FEW];
    race_scene(o, &c, scene, r);
    for (int i = 0; i < FEW; i++) {
      const rule by = rule_of(scene);
      const double value = r[i].figure[by].value, low = r[i].figure[by].low, high = r[i].figure[by].high;
      const bool holds_one = low <= 1.03 && high >= 1 / 1.03;
      const bool ok = holds_one == (w == 0) && (w == 0 || (value > 1) == (w < 3));
      printf("%s  %s, %u samples, 0.5.1 %s: %.3f, %.3f to %.3f; samples %u, %u\n", ok ? "ok" : "FAILED", scene,
          (unsigned)r[i].n, names[w], value, low, high, (unsigned)r[i].m, (unsigned)(2 * r[i].m));
      fflush(stdout);
      good = good && ok;
    }
  }
  return good;
}

static bool check(const options *o) {
  bool good = true;
  for (unsigned i = 0; i < o->scene_count; i++) good = check_scene(o, o->scenes[i]) && good;
  return good;
}

/* >>main ----------------------------------------------------------------------------------------------------------- */

static void print_help(void) {
  printf(
      "usage: versions [options] [SCENE...]   error at equal time, today's pktrt over the one before\n"
      "  --size N            width of pictures, a multiple of 4; height is 3 / 4 of it (default 192)\n"
      "  --seeds N           2 to %d (default 16)\n"
      "  --reference N       samples of references, a multiple of 256 from 512 on (default 1024)\n"
      "  --references DIR    where they are kept, for each version apart\n"
      "  --threads N         for references (default: as many as there are cores)\n"
      "  --lights-before W   all|one-deeper|one: of the version before (default all)\n"
      "  --lights-now W      all|one-deeper|one: of today's (default all); of pktrt_light_choice the first to third\n"
      "  --adaptive W        before|now|both: pictures in adaptive passes of a quarter of the samples (default: in "
      "one, uniform)\n"
      "  --shown             errors of pictures as a screen shows them, which today's adaptive passes lower\n"
      "  --samples           instead: the time of a sample under 1,000 lamps over that under ten\n"
      "  --results DIR       error_before.csv and .md\n"
      "  --check             instead: controls; exit status 1 if they do not come out as they must\n"
      "  --help              this text\n"
      "SCENE: a built-in one or closed-NAME (see closed.h); without one all that have a bar:\n",
      (int)MAX_SEEDS);
  for (int i = 0; i < BARS; i++) printf(" %s", bars[i].scene);
  printf("\n");
}

static bool parse_option(options *o, int key) {
  static const char *const whose[] = {"before", "now", "both", NULL};
  int way;
  static const char *const choices[LIGHTS + 1] = {"all", "one-deeper", "one", NULL};
  switch (key) {
  case 'w': return ex_parse_uint("size", optarg, 4, 4096, &o->width);
  case 's': return ex_parse_uint("seeds", optarg, 2, MAX_SEEDS, &o->seeds);
  case 'n': return ex_parse_uint("reference", optarg, 512, 65536, &o->reference);
  case 't': return ex_parse_uint("threads", optarg, 1, EX_MAX_THREADS, &o->threads);
  case 'b': return ex_parse_word("lights-before", optarg, choices, &o->lights[BEFORE]);
  case 'l': return ex_parse_word("lights-now", optarg, choices, &o->lights[NOW]);
  case 'a':
    if (!ex_parse_word("adaptive", optarg, whose, &way)) return false;
    return o->adaptive[BEFORE] = way != NOW, o->adaptive[NOW] = way != BEFORE, true;
  case 'r': o->references = optarg; return true;
  case 'o': o->results = optarg; return true;
  case 'm': return o->samples = true;
  case 'd': return o->shown = true;
  case 'k': return o->check = true;
  case 'h': print_help(); exit(0);
  default: return false; /* getopt has said what */
  }
}

static bool parse_scenes(int argc, char **argv, options *o) {
  static const char *const of_check[] = {"closed-quad", "closed-edge", "rtrt"};
  for (; optind < argc; optind++) {
    if (o->scene_count == MAX_SCENES) return ex_fail("%s: one scene too many", argv[optind]);
    o->scenes[o->scene_count++] = argv[optind];
  }
  if (o->scene_count) return true;
  o->scene_count = o->check ? 3 : BARS;
  for (unsigned i = 0; i < o->scene_count; i++) o->scenes[i] = o->check ? of_check[i] : bars[i].scene;
  return true;
}

static bool parse(int argc, char **argv, options *o) {
  static const struct option list[] = {{"size", required_argument, NULL, 'w'}, {"seeds", required_argument, NULL, 's'},
      {"reference", required_argument, NULL, 'n'}, {"references", required_argument, NULL, 'r'},
      {"threads", required_argument, NULL, 't'}, {"lights-before", required_argument, NULL, 'b'},
      {"lights-now", required_argument, NULL, 'l'}, {"adaptive", required_argument, NULL, 'a'},
      {"results", required_argument, NULL, 'o'}, {"samples", no_argument, NULL, 'm'}, {"shown", no_argument, NULL, 'd'},
      {"check", no_argument, NULL, 'k'}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};
  memset(o, 0, sizeof *o);
  o->width = 192, o->seeds = 16, o->reference = 1024, o->threads = ex_processors();
  for (int key; (key = getopt_long(argc, argv, "h", list, NULL)) != -1;)
    if (!parse_option(o, key)) return false;
  o->height = o->width / 4 * 3;
  if (o->width % 4) return ex_fail("--size: no multiple of 4");
  if (o->reference % 256) return ex_fail("--reference: no multiple of 256");
  return parse_scenes(argc, argv, o);
}

int main(int argc, char **argv) {
  options o;
  results out;
  bench_begin(argc, argv);
  if (!parse(argc, argv, &o)) return 2;
  for (int v = 0; v < VERSIONS; v++) versions[v]->begin();
  if (o.check) return !check(&o);
  results_open(&out, o.results, "error_before");
  if (o.samples) report_samples(&o, &out);
  else report_scenes(&o, &out);
  results_close(&out);
  return 0;
}
