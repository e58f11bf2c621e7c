/* Stability at the extremes: what the cases of stability_*.c share. They are tests like others; `make stability` runs them
   with --thorough 1, a hundred times as long as `make test`, and keeps their figures.

   A figure belongs to a part ("watertight"), a case of it ("bumpy 512, scale 1e-4") and says what it is ("leaks"). Counts are
   of what must not be: they are summed over cases and checked to be zero. Controls are the same count for something that
   is known to fail, over the same rays or some of them: a zero without a control that is not zero is no evidence. */
#ifndef PKTRT_STABILITY_H
#define PKTRT_STABILITY_H
#include "meshes.h"

/* isa: PKTRT_ISA_AUTO where it does not matter. All may be called from several threads; texts are copied. */
void count_figure(const char *part, const char *name, pktrt_isa isa, uint64_t rays, const char *what, uint64_t count);
void control_figure(
    const char *part, const char *name, const char *what, const char *control, uint64_t rays, uint64_t count);
/* A value that is reported, and must not exceed `limit` (INFINITY: none). Of several instruction sets the table shows the
   largest. */
void value_figure(
    const char *part, const char *name, pktrt_isa isa, uint64_t rays, const char *what, double value, double limit);

/* Jobs 0 to n - 1 over as many threads as there are processors. CHECK may be used in them, say() not. */
void jobs_for(size_t n, void (*job)(void *arg, size_t i), void *arg);

/* stability.csv and stability.md; false, and a sentence on standard error, where they cannot be written. */
bool keep_figures(const char *directory, int argc, char **argv);

/* --- the parts --- */
void suite_stability_watertight(void), suite_stability_accuracy(void), suite_stability_culling(void),
    suite_stability_secondary(void), suite_stability_shading(void), suite_stability_tree(void),
    suite_stability_hostile(void), suite_stability_exact(void), suite_stability_lamps(void);

#endif
