/* bench.h - what the benchmarks share: how they give up, memory, what time they measure, how they sum it up and where
   they write it. */
#ifndef BENCH_H
#define BENCH_H

#include "../examples/common.h"
#include "provenance.h"
#include <sys/mman.h>

EX_UNUSED static void fatal(const char *what) {
  ex_fail("%s", what);
  exit(1);
}

/* Zeroed and in large pages where the system has them: page faults and TLB misses are not what is compared. */
EX_UNUSED static void *take(size_t count, size_t size) {
  const size_t page = (size_t)2 << 20, bytes = (count * size / page + 1) * page;
  void *memory = NULL;
  if (posix_memalign(&memory, page, bytes) != 0) fatal("not enough memory");
#ifdef MADV_HUGEPAGE
  madvise(memory, bytes, MADV_HUGEPAGE);
#endif
  memset(memory, 0, bytes);
  return memory;
}

/* Processor time of this process: on a quiet machine that of a clock, on a busy one without the time of others. */
EX_UNUSED static double cpu_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* The larger and the smaller of two; what is no number wins, where fmax and fmin would hide it. */
EX_UNUSED static double larger(double a, double b) { return isnan(a) || a > b ? a : b; }
EX_UNUSED static double smaller(double a, double b) { return isnan(a) || a < b ? a : b; }

static int compare_doubles(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return x < y ? -1 : x > y;
}

/* Of n > 0 values, which it sorts. */
EX_UNUSED static double median_of(double *v, unsigned n) {
  qsort(v, n, sizeof *v, compare_doubles);
  return 0.5 * (v[n / 2] + v[(n - 1) / 2]);
}

/* The command that measures, as the figures name it. A program tells it before it reads its options. */
static char bench_command[4096] = "unknown";
EX_UNUSED static void bench_begin(int argc, char **argv) {
  join_command(bench_command, sizeof bench_command, argc, argv);
}

/* Where figures go: what the README shows to the terminal and to DIRECTORY/NAME.md, all of them to NAME.csv, which says
   in its first line where they come from. */
typedef struct results {
  const char *directory, *name; /* directory NULL: to the terminal only */
  FILE *csv, *md;
} results;

EX_UNUSED EX_PRINTF(2, 3) static void say(const results *to, const char *format, ...) {
  va_list values;
  va_start(values, format);
  vprintf(format, values);
  va_end(values);
  va_start(values, format);
  if (to->md) vfprintf(to->md, format, values);
  va_end(values);
}

EX_UNUSED EX_PRINTF(2, 3) static void csv(const results *to, const char *format, ...) {
  va_list values;
  va_start(values, format);
  if (to->csv) vfprintf(to->csv, format, values);
  va_end(values);
}

static FILE *open_result(const results *to, const char *suffix) {
  char path[4096];
  if (!to->directory) return NULL;
  const int n = snprintf(path, sizeof path, "%s/%s.%s", to->directory, to->name, suffix);
  FILE *file = n > 0 && n < (int)sizeof path ? fopen(path, "w") : NULL;
  if (!file) {
    ex_fail("%s/%s.%s: cannot be written: %s", to->directory, to->name, suffix, strerror(errno));
    exit(1);
  }
  return file;
}

static void close_result(FILE **file) {
  if (*file && (ferror(*file) | fclose(*file))) fatal("results could not be written");
  *file = NULL;
}

EX_UNUSED static void results_open(results *to, const char *directory, const char *name) {
  to->directory = directory, to->name = name;
  to->csv = open_result(to, "csv"), to->md = open_result(to, "md");
  if (to->csv) write_provenance(to->csv, bench_command);
}

EX_UNUSED static void results_close(results *to) { close_result(&to->csv), close_result(&to->md); }

#endif /* BENCH_H */
