/* report.h - part of peers.c: what was measured, as rows of a CSV file; what must be reached; tables.

   Contents: rows, classes, lines, verdicts, goals, tables, files. */
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
  bool robust;  /* Embree's robust modes race too */
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

/* >>classes -------------------------------------------------------------------------------------------------------- */

typedef enum goal_class { /* what is demanded depends on the machine */
  CLASS_Z,                /* AVX-512 kernels on AMD's Zen 5 and later */
  CLASS_I,                /* AVX-512 kernels on Intel's */
  CLASS_A,                /* AVX2 kernels against Embree's on AMD's; of that, less on Intel's */
  CLASSES
} goal_class;
#define ON_INTEL 0.8 /* of class A */

typedef struct judge { /* of an instruction set on this machine; a column of the table of goals */
  const char *isa;
  goal_class by; /* CLASSES: there are no goals but those of all machines */
  double share;  /* of the goals of the class */
} judge;

static judge judge_of(const char *isa, const processor *p) {
  const bool intel = !strcmp(p->vendor, "GenuineIntel"), amd = !strcmp(p->vendor, "AuthenticAMD");
  judge j;
  j.isa = isa, j.by = CLASSES, j.share = 1;
  if (!strcmp(isa, "avx512") && intel) j.by = CLASS_I;
  if (!strcmp(isa, "avx512") && amd && p->family >= 26) j.by = CLASS_Z;
  if (!strcmp(isa, "avx2") && (intel || amd)) j.by = CLASS_A, j.share = intel ? ON_INTEL : 1;
  return j;
}

static bool isa_measured(const report *of, const char *isa) {
  for (size_t i = 0; i < of->count; i++)
    if (!strcmp(of->rows[i].isa, isa)) return true;
  return false;
}

enum { MAX_JUDGES = 2 };
/* Of AVX-512 and AVX2, those that were measured; of neither, of the widest that was. Returns how many. */
static unsigned appoint(const report *of, const processor *p, judge out[MAX_JUDGES]) {
  static const char *const isas[] = {"avx512", "avx2", "neon", "sse2", "scalar"};
  unsigned n = 0;
  for (unsigned i = 0; i < sizeof isas / sizeof *isas; i++)
    if (isa_measured(of, isas[i]) && (i < 2 || n == 0)) out[n++] = judge_of(isas[i], p);
  return n;
}

/* >>lines ---------------------------------------------------------------------------------------------------------- */

typedef enum reduction {
  MEAN,  /* geometric, with the worst beside it */
  KIND,  /* the least of the geometric means of the kinds, with the worst beside it */
  TIME,  /* geometric, with the worst beside it; less is better */
  LEAST, /* of all that was measured */
  MOST,  /* the same; less is better */
  SHARE, /* rays that disagree, of all rays */
  FAULTS /* rays for which pktrt is wrong */
} reduction;

typedef struct goal {
  double required, aim; /* required 0: nothing is, but of faults; aim 0: none beyond what is required */
} goal;

typedef struct line {         /* something that is told, and may have to be reached */
  const char *name, *setting; /* setting NULL: any */
  unsigned kinds;             /* bits; 0: see what */
  const char *what, *mode;
  reduction how;
  goal of[CLASSES];
} line;

#define BIT(k) (1u << (k))
#define ALL_KINDS (BIT(KINDS) - 1)
#define CLOSEST (BIT(PRIMARY) | BIT(MIRROR) | BIT(MIRROR2) | BIT(DIFFUSE))
#define OCCLUSION (BIT(SHADOW) | BIT(FROM_LIGHT) | BIT(AO))
#define REST "at rest"
#define MOVES "moving 1%"
#define HIGH "at rest high"
#define FEW "few triangles"
#define ALIKE(required, aim) \
  { \
    {required, aim}, {required, aim}, { required, aim } \
  } /* of all classes */
#define FREE_OF_GOALS ALIKE(0, 0)
#define ROBUST \
  { \
    {1, 1.3}, {0.9, 1.2}, { 1.1, 1.4 } \
  }
/* clang-format off */
static const line lines[] = { /* required and aim of the classes Z, I, A */
  {"primary",                       REST,  BIT(PRIMARY),    NULL,  "many",       MEAN,  {{1, 1.25}, {0.8, 1.1}, {1.2, 1.5}}},
  {"shadow from surface",           REST,  BIT(SHADOW),     NULL,  "many",       MEAN,  {{1.15, 1.45}, {1, 1.3}, {1.2, 1.5}}},
  {"shadow from light",             REST,  BIT(FROM_LIGHT), NULL,  "many",       MEAN,  {{1.15, 1.45}, {1, 1.3}, {1.2, 1.5}}},
  {"mirror",                        REST,  BIT(MIRROR),     NULL,  "many",       MEAN,  {{1.1, 1.3}, {0.97, 1.2}, {1.3, 1.6}}},
  {"second mirror",                 REST,  BIT(MIRROR2),    NULL,  "many",       MEAN,  {{1.6, 2}, {1.2, 1.5}, {1.3, 1.6}}},
  {"diffuse",                       REST,  BIT(DIFFUSE),    NULL,  "many",       MEAN,  {{1.3, 1.6}, {1, 1.3}, {1.25, 1.6}}},
  {"ambient occlusion",             REST,  BIT(AO),         NULL,  "many",       MEAN,  {{0.95, 1.2}, {0.92, 1.15}, {1.1, 1.3}}},
  {"single calls, closest",         REST,  CLOSEST,         NULL,  "single",     MEAN,  {{0.82, 1}, {0.75, 0.95}, {0.85, 1}}},
  {"single calls, occlusion",       REST,  OCCLUSION,       NULL,  "single",     MEAN,  {{0.9, 1.05}, {0.83, 1}, {0.9, 1.05}}},
  {"single calls, stored rays",     REST,  ALL_KINDS,       NULL,  "single",     MEAN,  ALIKE(0.95, 1.05)},
  {"single calls, fresh rays",      REST,  ALL_KINDS,       NULL,  "fresh",      MEAN,  ALIKE(0.95, 1.05)},
  {"few triangles, a miss: stored ray (less is better)", FEW, 0, "miss", "single", TIME, ALIKE(1.4, 1.1)},
  {"few triangles, a miss: fresh ray (less is better)",  FEW, 0, "miss", "fresh",  TIME, ALIKE(1.4, 1.1)},
  {"few triangles, a hit: stored ray (less is better)",  FEW, 0, "hit",  "single", TIME, ALIKE(1.9, 1.4)},
  {"few triangles, a hit: fresh ray (less is better)",   FEW, 0, "hit",  "fresh",  TIME, ALIKE(1.9, 1.4)},
  {"moving: primary",               MOVES, BIT(PRIMARY),    NULL,  "many",       MEAN,  {{4.5, 6}, {3.3, 4.5}, {3.5, 4.5}}},
  {"moving: shadow from surface",   MOVES, BIT(SHADOW),     NULL,  "many",       MEAN,  {{1.9, 2.5}, {1.7, 2.1}, {1.8, 2.2}}},
  {"moving: shadow from light",     MOVES, BIT(FROM_LIGHT), NULL,  "many",       MEAN,  {{1.9, 2.5}, {1.7, 2.1}, {1.8, 2.2}}},
  {"moving: mirror",                MOVES, BIT(MIRROR),     NULL,  "many",       MEAN,  {{3.4, 4.5}, {2.6, 3.3}, {2.6, 3.3}}},
  {"moving: second mirror",         MOVES, BIT(MIRROR2),    NULL,  "many",       MEAN,  FREE_OF_GOALS},
  {"moving: diffuse",               MOVES, BIT(DIFFUSE),    NULL,  "many",       MEAN,  {{2.1, 2.5}, {1.8, 2.2}, {1.8, 2.2}}},
  {"moving: ambient occlusion",     MOVES, BIT(AO),         NULL,  "many",       MEAN,  {{1.6, 2}, {1.4, 1.7}, {1.5, 1.8}}},
  {"moving: single, closest",       MOVES, CLOSEST,         NULL,  "single",     MEAN,  FREE_OF_GOALS},
  {"moving: single, occlusion",     MOVES, OCCLUSION,       NULL,  "single",     MEAN,  FREE_OF_GOALS},
  {"robust: worst kind",            REST,  ALL_KINDS,       NULL,  "many robust",   KIND, ROBUST},
  {"robust: single, worst kind",    REST,  ALL_KINDS,       NULL,  "single robust", KIND, ROBUST},
  {"robust, moving: worst kind",    MOVES, ALL_KINDS,       NULL,  "many robust",   KIND, ROBUST},
  {"robust, moving: single, worst kind", MOVES, ALL_KINDS,  NULL,  "single robust", KIND, ROBUST},
  {"high trees: single, closest",   HIGH,  CLOSEST,         NULL,  "single",     MEAN,  {{0.85, 1}, {0.75, 0.9}, {0.85, 1}}},
  {"high trees: primary",           HIGH,  BIT(PRIMARY),    NULL,  "many",       MEAN,  FREE_OF_GOALS},
  {"worst scene and kind, at rest", REST,  ALL_KINDS,       NULL,  "many",       LEAST, FREE_OF_GOALS},
  {"worst scene and kind, moving",  MOVES, ALL_KINDS,       NULL,  "many",       LEAST, FREE_OF_GOALS},
  {"structures over arrays, worst", NULL,  ALL_KINDS,       NULL,  "_n/_soa",    LEAST, ALIKE(0.8, 0)},
  {"_n over single calls, worst",   NULL,  0,               NULL,  "_n/single",  LEAST, ALIKE(0.97, 0)},
  {"build time, indexed (less is better)", REST, 0,   "build",      "time",      TIME,  ALIKE(0.9, 0.7)},
  {"build time, soup (less is better)",    REST, 0,   "build soup", "time",      TIME,  ALIKE(1.1, 0.85)},
  {"refit time (less is better)",   NULL,  0,         "refit",      "time",      TIME,  {{0.85, 0.6}, {1.2, 0.8}, {0.85, 0.6}}},
  {"tree at rest, bytes/triangle",  REST,  0,         "tree",       "bytes",     MOST,  ALIKE(72, 0)},
  {"two workers, render",           NULL,  0,         "render",     "workers",   LEAST, ALIKE(1.9, 0)},
  {"two workers, build",            NULL,  0,         "build",      "workers",   LEAST, ALIKE(1.6, 0)},
  {"share of shading in a render",  NULL,  0,         "render",     "shading",   MOST,  ALIKE(0.28, 0)},
  {"closest point, near the surface", REST, 0,    "points near",  "points",    MEAN,  ALIKE(0.7, 0.9)},
  {"closest point, about the meshes", REST, 0,    "points about", "points",    MEAN,  ALIKE(0.7, 0.9)},
  {"share of rays that disagree",   NULL,  ALL_KINDS,       NULL,  "hits",       SHARE, ALIKE(1e-5, 0)},
  {"rays on which pktrt is wrong",  NULL,  ALL_KINDS,       NULL,  "hits",       FAULTS, FREE_OF_GOALS},
};
/* clang-format on */
enum { LINES = sizeof lines / sizeof *lines };

static bool less_is_better(const line *l) { return l->how == TIME || l->how >= MOST; }
static bool geometric(const line *l) { return l->how <= TIME; }

static bool alike(const goal of[CLASSES]) {
  for (int c = 1; c < CLASSES; c++)
    if (of[c].required != of[0].required || of[c].aim != of[0].aim) return false;
  return true;
}

/* What is demanded of all classes alike is demanded of all machines. A share of a ratio is that many times the ratio,
   of times their quotient. */
static goal goal_of(const line *l, const judge *by) {
  static const goal none = {0, 0};
  if (alike(l->of)) return l->of[0];
  if (by->by == CLASSES) return none;
  goal g = l->of[by->by];
  const double times = less_is_better(l) ? 1 / by->share : by->share;
  g.required *= times, g.aim *= times;
  return g;
}

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
  bool measured;
  int kind; /* of which the value is, where it is that of the worst kind */
  outcome is;
} verdict;

static verdict sum_line(const report *of, const line *l, const char *isa, group scenes) {
  double logs = 0, worst = less_is_better(l) ? 0 : INFINITY, all = 0, disagree = 0, faults = 0;
  size_t n = 0, caught = 0;
  verdict v;
  memset(&v, 0, sizeof v);
  for (size_t i = 0; i < of->count; i++) {
    const row *r = &of->rows[i];
    if (r->of != scenes || strcmp(r->isa, isa) || !row_of_line(r, l)) continue;
    n++, logs += log(larger(r->best, 1e-30)), all += (double)r->rays;
    disagree += (double)r->disagree, faults += (double)r->ours_wrong, caught += r->caught;
    worst = less_is_better(l) ? larger(worst, r->best) : smaller(worst, r->best);
  }
  if (n == 0) return v;
  v.measured = true, v.worst = worst;
  if (caught == 0) faults = NAN; /* a judge who catches no false answer finds no fault */
  v.value = geometric(l) ? exp(logs / (double)n) : l->how == SHARE ? disagree / all : l->how == FAULTS ? faults : worst;
  return v;
}

static line line_of_kind(const line *l, int k) {
  line one = *l;
  one.kinds = BIT(k), one.how = MEAN;
  return one;
}

static verdict worst_kind(const report *of, const line *l, const char *isa, group scenes) {
  verdict least;
  memset(&least, 0, sizeof least);
  for (int k = 0; k < KINDS; k++) {
    const line one = line_of_kind(l, k);
    const verdict v = sum_line(of, &one, isa, scenes);
    if (!v.measured) continue;
    const double worst = least.measured ? smaller(least.worst, v.worst) : v.worst;
    if (!least.measured || v.value < least.value || isnan(v.value)) least = v, least.kind = k;
    least.worst = worst;
  }
  return least;
}

/* Written this way round, what is not a number misses. */
static outcome outcome_of(const line *l, goal g, double value) {
  const double sign = less_is_better(l) ? -1 : 1;
  if (g.required == 0 && l->how != FAULTS) return FREE;
  if (!(sign * value >= sign * g.required)) return MISSED;
  return g.aim > 0 && sign * value >= sign * g.aim ? AIMED : REACHED;
}

static verdict judge_line(const report *of, const line *l, const judge *by, group scenes) {
  verdict v = l->how == KIND ? worst_kind(of, l, by->isa, scenes) : sum_line(of, l, by->isa, scenes);
  v.is = v.measured ? outcome_of(l, goal_of(l, by), v.value) : UNMEASURED;
  return v;
}

/* >>goals ---------------------------------------------------------------------------------------------------------- */

typedef struct bench { /* of judges, and what they came to */
  judge judges[MAX_JUDGES];
  unsigned count, outcomes[OUTCOMES];
} bench;

static void say_number(const report *to, const line *l, double value) {
  if (l->how == SHARE) say(&to->out, "%.1e", value);
  else if (l->how == FAULTS) say(&to->out, "%.0f", value);
  else say(&to->out, "%.2f", value);
}

static void say_goal(const report *to, const line *l, goal g) {
  say(&to->out, " ");
  if (g.required > 0 || l->how == FAULTS) say_number(to, l, g.required);
  if (g.aim > 0) say(&to->out, " / "), say_number(to, l, g.aim);
  say(&to->out, " |");
}

static void say_value(const report *to, const line *l, const verdict *v) {
  say(&to->out, " ");
  if (v->measured && l->how == KIND) say(&to->out, "%s ", kind_names[v->kind]);
  if (v->measured) say_number(to, l, v->value);
  if (v->measured && geometric(l)) say(&to->out, " (%.2f)", v->worst);
  say(&to->out, " |");
}

/* The mean of a line of ratios as a row, for plots. */
static void add_mean(report *to, const line *l, const judge *by, group scenes, const verdict *v) {
  if (!v->measured || l->kinds == 0 || l->how != MEAN) return;
  const char *what = l->kinds == CLOSEST ? "closest" : l->kinds == OCCLUSION ? "occlusion" : "all";
  for (int k = 0; k < KINDS; k++)
    if (l->kinds == BIT(k)) what = kind_names[k];
  const goal g = goal_of(l, by);
  row *r = add_row(to, NULL, l->setting, by->isa, what, "ratio", l->mode, "");
  r->of = scenes, r->median = r->best = v->value, r->required = g.required, r->aim = g.aim;
}

/* Nothing of what no judge has seen: false. */
static bool say_line(report *to, const line *l, group scenes, bench *b) {
  verdict v[MAX_JUDGES];
  bool seen = false;
  for (unsigned c = 0; c < b->count; c++) v[c] = judge_line(to, l, &b->judges[c], scenes), seen = seen || v[c].measured;
  if (!seen) return false;
  say(&to->out, "| %s | %s |", l->name, group_names[scenes]);
  for (unsigned c = 0; c < b->count; c++) {
    say_goal(to, l, goal_of(l, &b->judges[c]));
    say_value(to, l, &v[c]);
    say(&to->out, " %s |", outcome_names[v[c].is]);
    b->outcomes[v[c].is]++;
    add_mean(to, l, &b->judges[c], scenes, &v[c]);
  }
  say(&to->out, "\n");
  return true;
}

static bool group_measured(const report *of, group scenes) {
  for (size_t i = 0; i < of->count; i++)
    if (of->rows[i].of == scenes) return true;
  return false;
}

/* As a column is headed: "AVX2, class A x 0.8". */
static void say_judge(const report *to, const judge *j) {
  say(&to->out, "%s, ", !strcmp(j->isa, "avx512") ? "AVX-512" : !strcmp(j->isa, "avx2") ? "AVX2" : j->isa);
  if (j->by == CLASSES) say(&to->out, "of no class");
  else say(&to->out, "class %c", "ZIA"[j->by]);
  if (j->share < 1) say(&to->out, " x %.1f", j->share);
}

/* Against Embree's robust modes, by kinds: the means of which the table of goals has the worst. */
static void say_robust(report *to, const bench *b) {
  bool headed = false;
  for (int i = 0; i < LINES * GROUPS * MAX_JUDGES; i++) {
    const line *l = &lines[i / MAX_JUDGES % LINES];
    const group scenes = (group)(i / MAX_JUDGES / LINES);
    const unsigned c = (unsigned)(i % MAX_JUDGES);
    if (l->how != KIND || c >= b->count || !worst_kind(to, l, b->judges[c].isa, scenes).measured) continue;
    if (!headed) {
      say(&to->out,
          "Ratios to Embree's fastest robust mode: geometric means over the scenes, and the worst of these.\n\n"
          "| scenes | | kernels | calls | required / aim |");
      for (int k = 0; k < KINDS; k++) say(&to->out, " %s |", kind_names[k]);
      say(&to->out, "\n|---|---|---|---|--:|");
      for (int k = 0; k < KINDS; k++) say(&to->out, "--:|");
      say(&to->out, "\n");
      headed = true;
    }
    say(&to->out, "| %s | %s | %s | %s |", group_names[scenes], l->setting, b->judges[c].isa,
        strncmp(l->mode, "many", 4) ? "single" : "many");
    say_goal(to, l, goal_of(l, &b->judges[c]));
    for (int k = 0; k < KINDS; k++) {
      const line one = line_of_kind(l, k);
      const verdict v = sum_line(to, &one, b->judges[c].isa, scenes);
      say_value(to, &one, &v);
      add_mean(to, &one, &b->judges[c], scenes, &v);
    }
    say(&to->out, "\n");
  }
  if (headed) say(&to->out, "\n");
}

static void say_lines(report *to, const processor *p) {
  bench b;
  bool seen[LINES] = {false};
  memset(&b, 0, sizeof b);
  b.count = appoint(to, p, b.judges);
  say(&to->out, "This machine: %s, %s; kernels are judged as ", class_of(p), widest_vectors(p));
  for (unsigned c = 0; c < b.count; c++) say(&to->out, c ? "; " : ""), say_judge(to, &b.judges[c]);
  say(&to->out,
      ".\n\nRatios to Embree's fastest mode that is not robust, or, where it says so, to its fastest robust one: "
      "geometric means over the scenes, and the worst of these.\n\n| what | scenes |");
  for (unsigned c = 0; c < b.count; c++)
    say(&to->out, " "), say_judge(to, &b.judges[c]), say(&to->out, ": required / aim | measured | |");
  say(&to->out, "\n|---|---|");
  for (unsigned c = 0; c < b.count; c++) say(&to->out, "--:|--:|---|");
  say(&to->out, "\n");
  for (int g = 0; g < GROUPS; g++)
    for (int i = 0; i < LINES && g != GENERATED && group_measured(to, (group)g); i++)
      if (say_line(to, &lines[i], (group)g, &b)) seen[i] = true;
  const unsigned reached = b.outcomes[REACHED] + b.outcomes[AIMED], all = reached + b.outcomes[MISSED];
  say(&to->out, "\n%u of %u reached, %u of these at the aim; %u not reached.", reached, all, b.outcomes[AIMED],
      b.outcomes[MISSED]);
  const char *before = " Not measured in this run: ";
  for (int i = 0; i < LINES; i++)
    if (!seen[i]) say(&to->out, "%s%s", before, lines[i].name), before = "; ";
  say(&to->out, "%s\n\n", *before == ';' ? "." : "");
  say_robust(to, &b);
}

/* >>tables --------------------------------------------------------------------------------------------------------- */

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
static double our_speed(const report *in, const row *like, const char *what, const char *style) {
  const bool many = !strcmp(style, "many");
  const row *a = find_row(in, like, what, "pktrt", many ? "_n" : style);
  const row *b = many ? find_row(in, like, what, "pktrt", "_soa") : a;
  return a && b ? fmax(a->best, b->best) : 0;
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

/* For the calls of that style: "many", "single" or "fresh". With the ratio to Embree's robust modes beside it, where these were raced. */
static void say_speeds(const report *to, const char *style, const char *head) {
  char beside[32];
  snprintf(beside, sizeof beside, "%s robust", style);
  say_head(to, head, "| kernels |", "|---|---|---|");
  for (size_t i = 0; i < to->count; i++) {
    if (!has_line(to, i, style)) continue;
    const row *x = &to->rows[i];
    say(&to->out, "| %s | %s | %s |", x->scene, x->setting, x->isa);
    for (int k = 0; k < KINDS; k++) {
      const row *r = find_row(to, x, kind_names[k], "ratio", style),
                *robust = find_row(to, x, kind_names[k], "ratio", beside);
      if (r) say(&to->out, " %.1f: **%.2f**", our_speed(to, x, kind_names[k], style), r->best);
      if (robust) say(&to->out, ", %.2f", robust->best);
      say(&to->out, " |");
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

static void say_cell(
    const report *to, const row *like, const char *what, const char *library, const char *mode, const char *format) {
  const row *r = find_row(to, like, what, library, mode);
  say(&to->out, " ");
  if (r && !strcmp(format, "%.2f")) say(&to->out, "%.2f", r->best);
  else if (r) say(&to->out, "%.1f", r->best);
  say(&to->out, " |");
}

static void say_upkeep(const report *to) {
  static const char *const timed[3] = {"build", "build soup", "refit"};
  say(&to->out,
      "Milliseconds and bytes per triangle (pktrt's tree holds the triangles, with its meshes retained beside it).\n\n"
      "| scene | | kernels | build: pktrt | Embree | ratio | as a soup: pktrt | Embree | ratio | refit: pktrt | Embree "
      "| ratio | with copying: ratio "
      "| tree: pktrt | Embree | retained |\n|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  for (size_t i = 0; i < to->count; i++) {
    const row *x = &to->rows[i];
    if (!opens_block(to, i)) continue;
    bool some = false;
    for (int k = 0; k < 3; k++) some = some || find_row(to, x, timed[k], "ratio", "time");
    if (!some) continue;
    say(&to->out, "| %s | %s | %s |", x->scene, x->setting, x->isa);
    for (int k = 0; k < 3; k++) {
      say_cell(to, x, timed[k], "pktrt", "time", "%.1f"), say_cell(to, x, timed[k], "Embree", "time", "%.1f");
      say_cell(to, x, timed[k], "ratio", "time", "%.2f");
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

/* Of a scene, or if it is NULL, of all; nothing if there are none. mode: "hits", or "hits robust". */
static void say_hits_line(const report *to, const char *of, bool moving, const char *mode) {
  const bool robust = strcmp(mode, "hits") != 0;
  row sum;
  memset(&sum, 0, sizeof sum);
  for (size_t i = 0; i < to->count; i++) {
    const row *r = &to->rows[i];
    if (strcmp(r->library, "ratio") || strcmp(r->mode, mode) || (of && strcmp(r->scene, of))) continue;
    if (moving != (strncmp(r->setting, "moving", 6) == 0)) continue;
    sum.rays += r->rays, sum.disagree += r->disagree, sum.band += r->band, sum.judged += r->judged;
    sum.theirs_wrong += r->theirs_wrong, sum.ours_wrong += r->ours_wrong, sum.caught += r->caught;
  }
  if (robust && sum.rays == 0) return;
  say(&to->out, "| %s%s%s%s | %zu | %zu | %zu | %zu | %zu | %zu | %zu |\n", of ? of : "", of ? ", " : "",
      moving         ? "moving"
      : of || robust ? REST
                     : "at rest, refitted",
      robust ? ", robust modes" : "", sum.rays, sum.disagree, sum.band, sum.judged, sum.theirs_wrong, sum.ours_wrong,
      sum.caught);
}

static void say_hits(const report *to) {
  say_hits_head(to);
  for (int i = 0; i < 4; i++) say_hits_line(to, NULL, i % 2 != 0, i < 2 ? "hits" : "hits robust");
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
