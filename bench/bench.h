/* bench.h - what the benchmarks share: how they give up, what time they measure, how they sum it up. */
#ifndef BENCH_H
#define BENCH_H

#include "../examples/common.h"

EX_UNUSED static void fatal(const char *what) {
  ex_fail("%s", what);
  exit(1);
}

/* Processor time of this process: on a quiet machine that of a clock, on a busy one without the time of others. */
EX_UNUSED static double cpu_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static int compare_doubles(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return x < y ? -1 : x > y;
}

/* Of n > 0 values, which it sorts. */
EX_UNUSED static double median_of(double *v, unsigned n) {
  qsort(v, n, sizeof *v, compare_doubles);
  return 0.5 * (v[n / 2] + v[(n - 1) / 2]);
}

#endif /* BENCH_H */
