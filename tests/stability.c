/* The figures of stability.h: where they are kept, summed up and written. */
#include "stability.h"
#include "../bench/provenance.h"
#include <unistd.h>

typedef enum figure_kind { FIGURE_COUNT, FIGURE_CONTROL, FIGURE_VALUE } figure_kind;
static const char *const kind_names[3] = {"count", "control", "value"};

typedef struct figure {
  figure_kind kind;
  char part[24], name[64], what[48], control[32];
  pktrt_isa isa;
  uint64_t rays;
  double value, limit;
  size_t number; /* in the order of arrival */
} figure;

static pthread_mutex_t figures_lock = PTHREAD_MUTEX_INITIALIZER;
static figure *figures;
static size_t figure_count, figure_room;

static void keep(figure_kind kind, const char *part, const char *name, pktrt_isa isa, uint64_t rays, const char *what,
    const char *control, double value, double limit) {
  pthread_mutex_lock(&figures_lock);
  if (figure_count == figure_room) {
    figure_room = figure_room ? 2 * figure_room : 256;
    figures = realloc(figures, figure_room * sizeof *figures);
    if (!figures) abort();
  }
  figure *f = &figures[figure_count++];
  memset(f, 0, sizeof *f);
  f->kind = kind, f->isa = isa, f->rays = rays, f->value = value, f->limit = limit, f->number = figure_count;
  snprintf(f->part, sizeof f->part, "%s", part);
  snprintf(f->name, sizeof f->name, "%s", name);
  snprintf(f->what, sizeof f->what, "%s", what);
  snprintf(f->control, sizeof f->control, "%s", control);
  pthread_mutex_unlock(&figures_lock);
}

void count_figure(const char *part, const char *name, pktrt_isa isa, uint64_t rays, const char *what, uint64_t count) {
  CHECK(count == 0, "%s, %s, %s: %llu %s of %llu", part, name, pktrt_isa_string(isa), (unsigned long long)count, what,
      (unsigned long long)rays);
  keep(FIGURE_COUNT, part, name, isa, rays, what, "", (double)count, 0);
}

void control_figure(
    const char *part, const char *name, const char *what, const char *control, uint64_t rays, uint64_t count) {
  keep(FIGURE_CONTROL, part, name, PKTRT_ISA_AUTO, rays, what, control, (double)count, INFINITY);
}

void value_figure(
    const char *part, const char *name, pktrt_isa isa, uint64_t rays, const char *what, double value, double limit) {
  CHECK(value <= limit, "%s, %s, %s: %s is %g, at most %g is wanted", part, name, pktrt_isa_string(isa), what, value,
      limit);
  keep(FIGURE_VALUE, part, name, isa, rays, what, "", value, limit);
}

void jobs_for(size_t n, void (*job)(void *arg, size_t i), void *arg) {
  const long processors = sysconf(_SC_NPROCESSORS_ONLN);
  threads_for(processors > 1 ? (int)processors : 1, n, job, arg);
}

/* --- tables --- */

static bool alike(const char *a, const char *b) { return strcmp(a, b) == 0; }

/* Is figure i the first of its kind and part (and whatever of it is asked for)? */
static bool first_of(size_t i, bool by_what, bool by_name, bool by_control) {
  const figure *f = &figures[i];
  for (size_t j = 0; j < i; j++) {
    const figure *g = &figures[j];
    if (g->kind == f->kind && alike(g->part, f->part) && (!by_what || alike(g->what, f->what)) &&
        (!by_name || alike(g->name, f->name)) && (!by_control || alike(g->control, f->control)))
      return false;
  }
  return true;
}

typedef struct sum {
  size_t cases;
  double rays, found;
} sum;

/* Of all figures of a kind that say the same of the same part as f; with the same control, if it is one. */
static sum sum_of(const figure *f) {
  sum s = {0, 0, 0};
  for (size_t i = 0; i < figure_count; i++) {
    const figure *g = &figures[i];
    if (g->kind != f->kind || !alike(g->part, f->part) || !alike(g->what, f->what) || !alike(g->control, f->control))
      continue;
    s.cases += first_of(i, true, true, true);
    s.rays += (double)g->rays, s.found += g->value;
  }
  return s;
}

static void write_counts(FILE *to) {
  fprintf(to, "| part | what must not be | cases | rays or tries | found | controls: found, of tries |\n"
              "|---|---|--:|--:|--:|---|\n");
  for (size_t i = 0; i < figure_count; i++) {
    if (figures[i].kind != FIGURE_COUNT || !first_of(i, true, false, false)) continue;
    const sum s = sum_of(&figures[i]);
    fprintf(to, "| %s | %s | %zu | %.0f | %.0f |", figures[i].part, figures[i].what, s.cases, s.rays, s.found);
    const char *comma = " ";
    for (size_t j = 0; j < figure_count; j++) {
      const figure *c = &figures[j];
      if (c->kind != FIGURE_CONTROL || !alike(c->part, figures[i].part) || !alike(c->what, figures[i].what) ||
          !first_of(j, true, false, true))
        continue;
      const sum t = sum_of(c);
      fprintf(to, "%s%s %.0f of %.0f", comma, c->control, t.found, t.rays);
      comma = "; ";
    }
    fprintf(to, " |\n");
  }
}

static bool value_of(size_t i, const char *part) {
  return figures[i].kind == FIGURE_VALUE && alike(figures[i].part, part);
}

/* The largest value of a case and column, or nothing. */
static void write_cell(FILE *to, const figure *row, const figure *column) {
  double most = -INFINITY;
  for (size_t i = 0; i < figure_count; i++)
    if (value_of(i, row->part) && alike(figures[i].name, row->name) && alike(figures[i].what, column->what))
      most = fmax(most, figures[i].value);
  if (most == -INFINITY) fprintf(to, " |");
  else fprintf(to, " %.3g |", most);
}

/* A table for each part that has values: a row for each case, a column for each value. */
static void write_values(FILE *to) {
  for (size_t i = 0; i < figure_count; i++) {
    const char *part = figures[i].part;
    if (figures[i].kind != FIGURE_VALUE || !first_of(i, false, false, false)) continue;
    fprintf(to, "\n| %s |", part);
    for (size_t j = i; j < figure_count; j++)
      if (value_of(j, part) && first_of(j, true, false, false)) fprintf(to, " %s |", figures[j].what);
    fprintf(to, "\n|---|");
    for (size_t j = i; j < figure_count; j++)
      if (value_of(j, part) && first_of(j, true, false, false)) fprintf(to, "--:|");
    fprintf(to, "\n");
    for (size_t j = i; j < figure_count; j++) {
      if (!value_of(j, part) || !first_of(j, false, true, false)) continue;
      fprintf(to, "| %s |", figures[j].name);
      for (size_t k = i; k < figure_count; k++)
        if (value_of(k, part) && first_of(k, true, false, false)) write_cell(to, &figures[j], &figures[k]);
      fprintf(to, "\n");
    }
  }
}

/* Cases of a part arrive in any order; what one of them says, in its own. */
static int by_case(const void *x, const void *y) {
  const figure *a = x, *b = y;
  const int part = strcmp(a->part, b->part), name = strcmp(a->name, b->name);
  if (part || name) return part ? part : name;
  if (a->isa != b->isa) return a->isa < b->isa ? -1 : 1;
  return a->number < b->number ? -1 : a->number > b->number;
}

static FILE *create(const char *directory, const char *name) {
  char path[1024];
  snprintf(path, sizeof path, "%s/%s", directory, name);
  FILE *to = fopen(path, "w");
  if (!to) fprintf(stderr, "test: cannot write %s\n", path);
  return to;
}

bool keep_figures(const char *directory, int argc, char **argv) {
  static char command[4096];
  FILE *csv = create(directory, "stability.csv"), *md = csv ? create(directory, "stability.md") : NULL;
  if (figure_count) qsort(figures, figure_count, sizeof *figures, by_case);
  if (md) {
    join_command(command, sizeof command, argc, argv);
    write_provenance(csv, command);
    fprintf(csv, "kind,part,case,isa,what,control,rays,value,limit\n");
    for (size_t i = 0; i < figure_count; i++) {
      const figure *f = &figures[i];
      fprintf(csv, "%s,%s,\"%s\",%s,%s,%s,%llu,%.9g,%.9g\n", kind_names[f->kind], f->part, f->name,
          pktrt_isa_string(f->isa), f->what, f->control, (unsigned long long)f->rays, f->value, f->limit);
    }
    write_counts(md);
    write_values(md);
  }
  const bool ok = md && !ferror(csv) && !ferror(md);
  if (csv) fclose(csv);
  if (md) fclose(md);
  free(figures);
  figures = NULL, figure_count = figure_room = 0;
  return ok;
}

/* A zero of nothing is no zero. Over all cases together: a single case may be one that textbook tests get right. */
static void zeros_have_controls(void) {
  double all = 0;
  for (size_t i = 0; i < figure_count; i++) {
    if (figures[i].kind != FIGURE_COUNT) continue;
    all += (double)figures[i].rays;
    if (!first_of(i, true, false, false)) continue;
    size_t controls = 0;
    for (size_t j = 0; j < figure_count; j++) {
      const figure *c = &figures[j];
      if (c->kind != FIGURE_CONTROL || !alike(c->part, figures[i].part) || !alike(c->what, figures[i].what)) continue;
      controls++;
      CHECK(thoroughness < 0.01 || sum_of(c).found > 0, "%s, %s: the control \"%s\" is zero as well", c->part, c->what,
          c->control);
    }
    CHECK(thoroughness < 0.01 || sum_of(&figures[i]).rays > 0, "%s, %s: nothing was tried", figures[i].part,
        figures[i].what);
    CHECK(controls > 0, "%s, %s: no control", figures[i].part, figures[i].what);
  }
  say("%.0f rays or tries in all", all);
}

void suite_stability(void) {
  suite_stability_exact();
  suite_stability_watertight();
  suite_stability_accuracy();
  suite_stability_culling();
  suite_stability_secondary();
  suite_stability_shading();
  suite_stability_lamps();
  suite_stability_tree();
  suite_stability_hostile();
  run("stable: every zero stands beside a control that is not zero", zeros_have_controls);
}
