/* bench.h - what the benchmarks share: how they give up, memory, what time they measure, how they sum it up. */
#ifndef BENCH_H
#define BENCH_H

#include "../examples/common.h"
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
