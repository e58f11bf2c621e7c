/* report.h - part of peers.c: what was measured, as rows of a CSV file; what must be reached; tables.

   Contents: rows, lines, verdicts, tables, files. */
#ifndef PEERS_REPORT_H
#define PEERS_REPORT_H

#include "rays.h"
#include "scenes.h"

/* >>rows ----------------------------------------------------------------------------------------------------------- */

typedef struct setting { /* how a stage is built, and whether it moves */
  const char *name;
  double share; /* of the diagonal, that vertices move by */
  double loose; /* of that share, how far each moves by itself besides */
  bool high;    /* the dearest trees of both libraries */
  bool robust;  /* Embree's robust mode */
  bool refit;   /* trees built before the motion, fitted to what is after it */
} setting;

/* One figure. Ratios are rows too, of the library "ratio": they are always pktrt over Embree (or what the mode says),
   where speeds are meant above 1 if pktrt is the faster, where times or bytes are meant below. */
typedef struct row {
  char scene[48];
  group of;
  unsigned long long triangles;
  const char *setting, *isa, *library, *mode, *unit;
  char what[32];       /* a kind of rays, or what else was measured */
  size_t rays;         /* of which disagree is a part */
  double median, best; /* of so many rounds; best: the highest speed, the shortest time */
  unsigned rounds;
  size_t disagree;       /* rays whose answers differ between the libraries */
  size_t theirs_wrong;   /* of all rays that were judged: Embree's answer is none of those that are possible */
  size_t ours_wrong;     /* of all rays that were judged: ours is none */
  size_t band;           /* of those that disagree: both answers are possible */
  size_t judged, caught; /* rays; of these, a false answer was seen to be one */
  double required, aim;  /* 0: nothing is */
} row;

typedef struct report {
  row *rows;
  size_t count, room;
  results out;
} report;

static row *add_row(report *to, const stage *g, const char *set, const char *isa, const char *what, const char *library,
                    const char *mode, const char *unit) {
  if (to->count == to->room) {
    to->room = to->room ? 2 * to->room : 1024;
    to->rows = (row *)realloc(to->rows, to->room * sizeof(row));
    if (!to->rows) fatal("not enough memory");
  }
  row *r = &to->rows[to->count++];
  memset(r, 0, sizeof *r);
  snprintf(r->scene, sizeof r->scene, "%s", g ? g->name : "mean");
  snprintf(r->what, sizeof r->what, "%s", what);
  if (g) r->of = g->of, r->triangles = (unsigned long long)scene_triangles(&g->s);
  r->setting = set, r->isa = isa, r->library = library, r->mode = mode, r->unit = unit;
  return r;
}

/* With the median and the least of n values, which it sorts. */
static row *add_values(row *r, double *values, unsigned n) {
  r->median = median_of(values, n), r->best = values[0], r->rounds = n;
  return r;
}

/* >>lines ---------------------------------------------------------------------------------------------------------- */

typedef enum reduction {
  MEAN,  /* geometric, with the worst beside it */
  TIME,  /* the same; less is better */
  LEAST, /* of all that was measured */
  MOST,  /* the same; less is better */
  SHARE, /* rays that disagree, of all rays */
  FAULTS /* rays for which pktrt is wrong */
} reduction;

typedef struct line {         /* something that must be reached, on AVX-512 and on AVX2 */
  const char *name, *setting; /* setting NULL: any */
  unsigned kinds;             /* bits; 0: see what */
  const char *what, *mode;
  reduction how;
  double required[2], aim[2]; /* aim 0: none beyond what is required; of a mean, required 0: nothing is */
} line;

#define BIT(k) (1u << (k))
#define ALL_KINDS (BIT(KINDS) - 1)
#define CLOSEST (BIT(PRIMARY) | BIT(MIRROR) | BIT(MIRROR2) | BIT(DIFFUSE))
#define OCCLUSION (BIT(SHADOW) | BIT(FROM_LIGHT) | BIT(AO))
#define REST "at rest"
#define MOVES "moving 1%"
/* clang-format off */
static const line lines[] = {
  {"primary",                       REST,  BIT(PRIMARY),    NULL,     "many",      MEAN,   {1.25, 1.15}, {1.6, 1.5}},
  {"shadow from surface",           REST,  BIT(SHADOW),     NULL,     "many",      MEAN,   {1.25, 1.15}, {1.6, 1.5}},
  {"shadow from light",             REST,  BIT(FROM_LIGHT), NULL,     "many",      MEAN,   {1.25, 1.15}, {1.6, 1.5}},
  {"mirror",                        REST,  BIT(MIRROR),     NULL,     "many",      MEAN,   {1.15, 1.1},  {1.5, 1.4}},
  {"second mirror",                 REST,  BIT(MIRROR2),    NULL,     "many",      MEAN,   {1.2, 1.15},  {1.5, 1.4}},
  {"diffuse",                       REST,  BIT(DIFFUSE),    NULL,     "many",      MEAN,   {1.4, 1.3},   {1.8, 1.7}},
  {"ambient occlusion",             REST,  BIT(AO),         NULL,     "many",      MEAN,   {1.0, 1.0},   {1.3, 1.2}},
  {"moving: primary",               MOVES, BIT(PRIMARY),    NULL,     "many",      MEAN,   {4.5, 4.0},   {6.0, 5.0}},
  {"moving: shadow from surface",   MOVES, BIT(SHADOW),     NULL,     "many",      MEAN,   {1.7, 1.5},   {2.3, 2.0}},
  {"moving: shadow from light",     MOVES, BIT(FROM_LIGHT), NULL,     "many",      MEAN,   {1.7, 1.5},   {2.3, 2.0}},
  {"moving: mirror",                MOVES, BIT(MIRROR),     NULL,     "many",      MEAN,   {3.0, 2.5},   {4.5, 4.0}},
  {"moving: second mirror",         MOVES, BIT(MIRROR2),    NULL,     "many",      MEAN,   {0, 0},       {0, 0}},
  {"moving: diffuse",               MOVES, BIT(DIFFUSE),    NULL,     "many",      MEAN,   {1.9, 1.7},   {2.5, 2.2}},
  {"moving: ambient occlusion",     MOVES, BIT(AO),         NULL,     "many",      MEAN,   {1.2, 1.1},   {1.6, 1.4}},
  {"worst scene and kind, at rest", REST,  ALL_KINDS,       NULL,     "many",      LEAST,  {0.95, 0.9},  {0, 0}},
  {"worst scene and kind, moving",  MOVES, ALL_KINDS,       NULL,     "many",      LEAST,  {0.95, 0.9},  {0, 0}},
  {"single calls, closest",         REST,  CLOSEST,         NULL,     "single",    MEAN,   {0.9, 0.9},   {1.1, 1.1}},
  {"single calls, occlusion",       REST,  OCCLUSION,       NULL,     "single",    MEAN,   {0.9, 0.9},   {1.1, 1.1}},
  {"moving: single, closest",       MOVES, CLOSEST,         NULL,     "single",    MEAN,   {1.1, 1.1},   {1.5, 1.5}},
  {"moving: single, occlusion",     MOVES, OCCLUSION,       NULL,     "single",    MEAN,   {1.1, 1.1},   {1.5, 1.5}},
  {"structures over arrays, worst", NULL,  ALL_KINDS,       NULL,     "_n/_soa",   LEAST,  {0.8, 0.8},   {0, 0}},
  {"_n over single calls, worst",   NULL,  0,               NULL,     "_n/single", LEAST,  {0.97, 0.97}, {0, 0}},
  {"build time (less is better)",   REST,  0,               "build",  "time",      TIME,   {1.0, 1.0},   {0.75, 0.75}},
  {"refit time (less is better)",   NULL,  0,               "refit",  "time",      TIME,   {0.8, 0.8},   {0.6, 0.6}},
  {"tree at rest, bytes/triangle",  REST,  0,               "tree",   "bytes",     MOST,   {72, 72},     {0, 0}},
  {"two workers, render",           NULL,  0,               "render", "workers",   LEAST,  {1.9, 1.9},   {0, 0}},
  {"two workers, build",            NULL,  0,               "build",  "workers",   LEAST,  {1.7, 1.7},   {0, 0}},
  {"share of shading in a render",  NULL,  0,               "render", "shading",  MOST,   {0.2, 0.2},   {0, 0}},
  {"share of rays that disagree",   NULL,  ALL_KINDS,       NULL,     "hits",      SHARE,  {1e-5, 1e-5}, {0, 0}},
  {"rays on which pktrt is wrong",  NULL,  ALL_KINDS,       NULL,     "hits",      FAULTS, {0, 0},       {0, 0}},
};
/* clang-format on */
enum { LINES = sizeof lines / sizeof *lines };

static bool less_is_better(const line *l) { return l->how == TIME || l->how >= MOST; }
static bool geometric(const line *l) { return l->how == MEAN || l->how == TIME; }

static bool row_of_line(const row *r, const line *l) {
  const char *library = strcmp(l->mode, "bytes") ? "ratio" : "pktrt";
  if (strcmp(r->library, library) || strcmp(r->mode, l->mode) || !strcmp(r->scene, "mean")) return false;
  if (l->setting && strcmp(r->setting, l->setting)) return false;
  if (l->what) return !strcmp(r->what, l->what);
  bool of_kind = !l->kinds;
  for (int k = 0; k < KINDS; k++) of_kind = of_kind || (l->kinds & BIT(k) && !strcmp(r->what, kind_names[k]));
  return of_kind;
}

/* >>verdicts ------------------------------------------------------------------------------------------------------- */

typedef enum outcome { UNMEASURED, FREE, MISSED, REACHED, AIMED, OUTCOMES } outcome; /* FREE: nothing is required */
static const char *const outcome_names[OUTCOMES] = {"", "", "no", "reached", "aim"};

typedef struct verdict {
  double value, worst;
  outcome is;
} verdict;

static verdict judge_line(const report *of, const line *l, const char *isa, int column, group scenes) {
  double logs = 0, worst = less_is_better(l) ? 0 : INFINITY, all = 0, disagree = 0, faults = 0;
  size_t n = 0;
  verdict v;
  memset(&v, 0, sizeof v);
  for (size_t i = 0; i < of->count; i++) {
    const row *r = &of->rows[i];
    if (r->of != scenes || strcmp(r->isa, isa) || !row_of_line(r, l)) continue;
    n++, logs += log(fmax(r->median, 1e-30)), all += (double)r->rays;
    disagree += (double)r->disagree, faults += (double)r->ours_wrong;
    worst = less_is_better(l) ? fmax(worst, r->median) : fmin(worst, r->median);
  }
  if (n == 0) return v;
  v.worst = worst;
  v.value = geometric(l) ? exp(logs / (double)n) : l->how == SHARE ? disagree / all : l->how == FAULTS ? faults : worst;
  const double sign = less_is_better(l) ? -1 : 1, aim = l->aim[column];
  if (geometric(l) && l->required[column] == 0) v.is = FREE;
  else
    v.is = sign * v.value < sign * l->required[column] ? MISSED
           : aim > 0 && sign * v.value >= sign * aim   ? AIMED
                                                       : REACHED;
  return v;
}

/* >>tables --------------------------------------------------------------------------------------------------------- */

static const char *const columns[2] = {"avx512", "avx2"};

static void say_number(const report *to, const line *l, double value) {
  if (l->how == SHARE) say(&to->out, "%.1e", value);
  else if (l->how == FAULTS) say(&to->out, "%.0f", value);
  else say(&to->out, "%.2f", value);
}

static void say_line(report *to, const line *l, group scenes, unsigned counts[OUTCOMES]) {
  say(&to->out, "| %s | %s |", l->name, group_names[scenes]);
  for (int c = 0; c < 2; c++) {
    const verdict v = judge_line(to, l, columns[c], c, scenes);
    say(&to->out, " ");
    if (!geometric(l) || l->required[c] > 0) say_number(to, l, l->required[c]);
    if (l->aim[c] > 0) say(&to->out, " / "), say_number(to, l, l->aim[c]);
    say(&to->out, " | ");
    if (v.is != UNMEASURED) say_number(to, l, v.value);
    if (v.is != UNMEASURED && geometric(l)) say(&to->out, " (%.2f)", v.worst);
    say(&to->out, " | %s |", outcome_names[v.is]);
    counts[v.is]++;
    if (v.is == UNMEASURED || l->kinds == 0 || l->how != MEAN) continue;
    const char *what = l->kinds == CLOSEST ? "closest" : l->kinds == OCCLUSION ? "occlusion" : NULL;
    for (int k = 0; k < KINDS; k++)
      if (l->kinds == BIT(k)) what = kind_names[k];
    row *r = add_row(to, NULL, l->setting, columns[c], what, "ratio", l->mode, "");
    r->of = scenes, r->median = r->best = v.value, r->required = l->required[c], r->aim = l->aim[c];
  }
  say(&to->out, "\n");
}

static bool group_measured(const report *of, group scenes) {
  for (size_t i = 0; i < of->count; i++)
    if (of->rows[i].of == scenes) return true;
  return false;
}

static void say_lines(report *to) {
  unsigned counts[OUTCOMES] = {0, 0, 0, 0, 0};
  say(&to->out,
      "Ratios to Embree's fastest mode that is not robust: geometric means over the scenes, and the worst of these.\n\n"
      "| what | scenes | AVX-512: required / aim | measured | | AVX2: required / aim | measured | |\n"
      "|---|---|--:|--:|---|--:|--:|---|\n");
  for (int g = 0; g < GROUPS; g++)
    for (int i = 0; i < LINES && g != GENERATED && group_measured(to, (group)g); i++)
      say_line(to, &lines[i], (group)g, counts);
  const unsigned reached = counts[REACHED] + counts[AIMED], all = reached + counts[MISSED];
  say(&to->out, "\n%u of %u reached, %u of these at the aim; %u not reached; %u not measured in this run.\n\n", reached,
      all, counts[AIMED], counts[MISSED], counts[UNMEASURED]);
}

static const row *find_row(const report *in, const row *like, const char *what, const char *library, const char *mode) {
  for (size_t i = 0; i < in->count; i++) {
    const row *r = &in->rows[i];
    if (strcmp(r->scene, like->scene) || strcmp(r->setting, like->setting) || strcmp(r->isa, like->isa)) continue;
    if (!strcmp(r->what, what) && !strcmp(r->library, library) && !strcmp(r->mode, mode)) return r;
  }
  return NULL;
}

/* Whether row i is the first of its scene, setting and instruction set. */
static bool opens_block(const report *in, size_t i) {
  const row *r = &in->rows[i];
  for (size_t k = 0; k < i; k++) {
    const row *x = &in->rows[k];
    if (!strcmp(r->scene, x->scene) && !strcmp(r->setting, x->setting) && !strcmp(r->isa, x->isa)) return false;
  }
  return strcmp(r->scene, "mean") != 0;
}

/* Of its two ways to trace many rays, the faster. */
static double our_speed(const report *in, const row *like, const char *what, bool many) {
  const row *a = find_row(in, like, what, "pktrt", many ? "_n" : "single");
  const row *b = many ? find_row(in, like, what, "pktrt", "_soa") : a;
  return a && b ? fmax(a->median, b->median) : 0;
}

/* The head of a table of kinds, and which rows have a line in it: those that open a block with such a ratio. */
static void say_head(const report *to, const char *text, const char *heads, const char *rules) {
  say(&to->out, "%s\n\n| scene | %s", text, heads);
  for (int k = 0; k < KINDS; k++) say(&to->out, " %s |", kind_names[k]);
  say(&to->out, "\n%s", rules);
  for (int k = 0; k < KINDS; k++) say(&to->out, "--:|");
  say(&to->out, "\n");
}
static bool has_line(const report *to, size_t i, const char *style) {
  bool some = false;
  for (int k = 0; k < KINDS && opens_block(to, i); k++)
    some = some || find_row(to, &to->rows[i], kind_names[k], "ratio", style);
  return some;
}

static void say_speeds(const report *to, const char *style, const char *head) {
  say_head(to, head, "| kernels |", "|---|---|---|");
  for (size_t i = 0; i < to->count; i++) {
    if (!has_line(to, i, style)) continue;
    const row *x = &to->rows[i];
    say(&to->out, "| %s | %s | %s |", x->scene, x->setting, x->isa);
    for (int k = 0; k < KINDS; k++) {
      const row *r = find_row(to, x, kind_names[k], "ratio", style);
      if (r) say(&to->out, " %.1f: **%.2f** |", our_speed(to, x, kind_names[k], !strcmp(style, "many")), r->median);
      else say(&to->out, " |");
    }
    say(&to->out, "\n");
  }
  say(&to->out, "\n");
}

static void say_limits(const report *to) {
  say_head(to,
           "Limits, in per cent of the time of pktrt's `_n`: tests, by what they cost in the first cache / settling in "
           "double, at most / what tests of triangles that lose no ray cost more than Kensler and Shirley's, fused.",
           "kernels |", "|---|---|");
  for (size_t i = 0; i < to->count; i++) {
    if (!has_line(to, i, "tests")) continue;
    const row *x = &to->rows[i];
    say(&to->out, "| %s | %s |", x->scene, x->isa);
    for (int k = 0; k < KINDS; k++) {
      const row *tests = find_row(to, x, kind_names[k], "ratio", "tests"),
                *settling = find_row(to, x, kind_names[k], "ratio", "settling"),
                *watertight = find_row(to, x, kind_names[k], "ratio", "watertight");
      if (tests && settling && watertight)
        say(&to->out, " %.0f / %.1f / %.0f |", 1e2 * tests->median, 1e2 * settling->median, 1e2 * watertight->median);
      else say(&to->out, " |");
    }
    say(&to->out, "\n");
  }
  say(&to->out, "\n");
}

static void say_cell(const report *to, const row *like, const char *what, const char *library, const char *mode,
                     const char *format) {
  const row *r = find_row(to, like, what, library, mode);
  say(&to->out, " ");
  if (r && !strcmp(format, "%.2f")) say(&to->out, "%.2f", r->median);
  else if (r) say(&to->out, "%.1f", r->median);
  say(&to->out, " |");
}

static void say_upkeep(const report *to) {
  say(&to->out,
      "Milliseconds and bytes per triangle (pktrt's tree holds the triangles, with its meshes retained beside it).\n\n"
      "| scene | | kernels | build: pktrt | Embree | ratio | refit: pktrt | Embree | ratio | with copying: ratio "
      "| tree: pktrt | Embree | retained |\n|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  for (size_t i = 0; i < to->count; i++) {
    const row *x = &to->rows[i];
    if (!opens_block(to, i)) continue;
    if (!find_row(to, x, "build", "ratio", "time") && !find_row(to, x, "refit", "ratio", "time")) continue;
    say(&to->out, "| %s | %s | %s |", x->scene, x->setting, x->isa);
    for (int k = 0; k < 2; k++) {
      const char *what = k ? "refit" : "build";
      say_cell(to, x, what, "pktrt", "time", "%.1f"), say_cell(to, x, what, "Embree", "time", "%.1f");
      say_cell(to, x, what, "ratio", "time", "%.2f");
    }
    say_cell(to, x, "copy and refit", "ratio", "time", "%.2f");
    say_cell(to, x, "tree", "pktrt", "bytes", "%.1f"), say_cell(to, x, "tree", "Embree", "bytes", "%.1f");
    say_cell(to, x, "meshes", "pktrt", "bytes", "%.1f");
    say(&to->out, "\n");
  }
  say(&to->out, "\n");
}

static void say_hits_head(const report *to) {
  say(&to->out,
      "Hits, against Embree's fastest mode of each kind of rays. Every ray that is disagreed on, and some others of "
      "each kind, are judged by an ideal test in double over all triangles; so is a false answer for each, as a "
      "control.\n\n"
      "| scenes | rays | disagree | of these both possible | judged | Embree wrong | pktrt wrong | control wrong |\n"
      "|---|--:|--:|--:|--:|--:|--:|--:|\n");
}

/* Of a scene, or if it is NULL, of all. */
static void say_hits_line(const report *to, const char *of, bool moving) {
  row sum;
  memset(&sum, 0, sizeof sum);
  for (size_t i = 0; i < to->count; i++) {
    const row *r = &to->rows[i];
    if (strcmp(r->library, "ratio") || strcmp(r->mode, "hits") || (of && strcmp(r->scene, of))) continue;
    if (moving != (strncmp(r->setting, "moving", 6) == 0)) continue;
    sum.rays += r->rays, sum.disagree += r->disagree, sum.band += r->band, sum.judged += r->judged;
    sum.theirs_wrong += r->theirs_wrong, sum.ours_wrong += r->ours_wrong, sum.caught += r->caught;
  }
  say(&to->out, "| %s%s%s | %zu | %zu | %zu | %zu | %zu | %zu | %zu |\n", of ? of : "", of ? ", " : "",
      moving ? "moving"
      : of   ? REST
             : "at rest, refitted",
      sum.rays, sum.disagree, sum.band, sum.judged, sum.theirs_wrong, sum.ours_wrong, sum.caught);
}

static void say_hits(const report *to) {
  say_hits_head(to);
  say_hits_line(to, NULL, false), say_hits_line(to, NULL, true);
  say(&to->out, "\n");
}

/* >>files ---------------------------------------------------------------------------------------------------------- */

static void write_csv(const report *of) {
  csv(&of->out, "scene,scenes,triangles,setting,isa,what,rays,library,mode,unit,median,best,rounds,disagree,"
                "both_possible,theirs_wrong,ours_wrong,judged,control_wrong,required,aim\n");
  for (size_t i = 0; i < of->count; i++) {
    const row *r = &of->rows[i];
    csv(&of->out, "%s,%s,%llu,%s,%s,%s,%zu,%s,%s,%s,%.6g,%.6g,%u,%zu,%zu,%zu,%zu,%zu,%zu,%g,%g\n", r->scene,
        group_names[r->of], r->triangles, r->setting, r->isa, r->what, r->rays, r->library, r->mode, r->unit, r->median,
        r->best, r->rounds, r->disagree, r->band, r->theirs_wrong, r->ours_wrong, r->judged, r->caught, r->required,
        r->aim);
  }
}

#endif /* PEERS_REPORT_H */
