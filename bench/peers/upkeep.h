/* upkeep.h - part of peers.c: what is timed besides rays against rays. Trees built and refitted, and their bytes;
   many rays in all orders against single calls; two workers; the share of shading.

   Contents: trees, refits, orders, workers, shading. */
#ifndef PEERS_UPKEEP_H
#define PEERS_UPKEEP_H

#include "race.h"
#include "rays.h"
#include "report.h"
#include "scenes.h"
#include <sched.h>

/* >>trees ---------------------------------------------------------------------------------------------------------- */

/* Times of both libraries in seconds, and their ratio. */
static void add_times(report *to, const stage *g, const setting *how, const pair *p, const char *what, double *ours,
    double *theirs, unsigned rounds) {
  const char *isa = pktrt_isa_string(p->isa);
  row *r = add_values(add_row(to, g, how->name, isa, what, "pktrt", "time", "ms"), ours, rounds);
  const double median = r->median, best = r->best;
  r->median *= 1e3, r->best *= 1e3;
  if (!p->device) return;
  r = add_values(add_row(to, g, how->name, isa, what, "Embree", "time", "ms"), theirs, rounds);
  const double their_median = r->median, their_best = r->best;
  r->median *= 1e3, r->best *= 1e3;
  ratio_row(to, g, how, p, what, "time", median / their_median, best / their_best);
}

static void add_bytes(report *to, const stage *g, const setting *how, const pair *p) {
  const char *isa = pktrt_isa_string(p->isa);
  const double triangles = (double)scene_triangles(&g->s);
  pktrt_scene_info info;
  pktrt_get_scene_info(p->ours, &info);
  row *r = add_row(to, g, how->name, isa, "tree", "pktrt", "bytes", "bytes/triangle");
  r->median = r->best = (double)info.tree_bytes / triangles;
  r = add_row(to, g, how->name, isa, "meshes", "pktrt", "bytes", "bytes/triangle");
  r->median = r->best = (double)info.mesh_bytes / triangles;
  if (!p->device) return;
  r = add_row(to, g, how->name, isa, "tree", "Embree", "bytes", "bytes/triangle");
  r->median = r->best = (double)p->their_bytes / triangles;
}

/* again: it has been built otherwise, and its bytes are known. */
static void add_trees(
    report *to, const stage *g, const setting *how, pair *pairs, unsigned count, unsigned rounds, bool again) {
  for (unsigned i = 0; i < count; i++) {
    pair *p = &pairs[i];
    add_times(to, g, how, p, g->soup ? "build soup" : "build", p->our_time, p->their_time, rounds);
    if (!again) add_bytes(to, g, how, p);
    printf("  build%s %s: pktrt %.1f ms", g->soup ? " soup" : "", pktrt_isa_string(p->isa),
        1e3 * median_of(p->our_time, rounds));
    if (p->device) printf(", Embree %.1f ms", 1e3 * median_of(p->their_time, rounds));
    printf("\n");
  }
}

/* The same triangles without shared vertices, as they lie at rest. */
static void open_soup(const stage *from, stage *to) {
  *to = *from, to->soup = true;
  stage_room(&to->s, from->s.mesh_count);
  for (size_t i = 0; i < from->s.mesh_count; i++) {
    const scene_mesh *m = &from->s.meshes[i];
    scene_mesh *out = &to->s.meshes[i];
    mesh_room(out, 3 * m->triangle_count, m->triangle_count);
    for (uint32_t k = 0; k < 3 * m->triangle_count; k++) {
      memcpy(out->positions + (size_t)k * 3, m->positions + (size_t)m->indices[k] * 3, 3 * sizeof(float));
      out->indices[k] = k;
    }
  }
}

/* The triangles of a stage that shares vertices, built without indices. Leaves the pairs with that. */
static void add_soup(report *to, const stage *g, const setting *how, pair *pairs, unsigned count, unsigned rounds) {
  stage soup;
  open_soup(g, &soup);
  build_pairs(pairs, count, &soup, how, rounds);
  add_trees(to, &soup, how, pairs, count, rounds, true);
  close_stage(&soup);
}

/* >>refits --------------------------------------------------------------------------------------------------------- */

/* The second pose becomes the one at rest, and the other way round. */
static void swap_poses(stage *g) {
  for (size_t i = 0; i < g->s.mesh_count; i++) {
    float *p = g->s.meshes[i].positions;
    const size_t n = (size_t)g->s.meshes[i].vertex_count * 3;
    for (size_t k = 0; k < n; k++) {
      const float swapped = p[k];
      p[k] = p[n + k], p[n + k] = swapped;
    }
  }
}

/* New positions of all meshes, copied; then boxes fitted to them. Both times. */
static void refit_ours(const pair *p, const stage *g, double *copy, double *refit) {
  const double start = cpu_seconds();
  for (size_t m = 0; m < g->s.mesh_count; m++)
    if (pktrt_set_positions(p->ours, (uint32_t)m, 0, g->s.meshes[m].positions) != PKTRT_OK)
      fatal(pktrt_last_error(p->ours));
  const double copied = cpu_seconds();
  if (pktrt_refit(p->ours) != PKTRT_OK) fatal(pktrt_last_error(p->ours));
  *refit = cpu_seconds() - copied, *copy = copied - start;
}

static void refit_theirs(const pair *p, const stage *g, double *copy, double *refit) {
  const double start = cpu_seconds();
  for (unsigned m = 0; m < g->s.mesh_count; m++) {
    void *at = rtcGetGeometryBufferData(rtcGetGeometry(p->theirs, m), RTC_BUFFER_TYPE_VERTEX, 0);
    memcpy(at, g->s.meshes[m].positions, (size_t)g->s.meshes[m].vertex_count * 3 * sizeof(float));
  }
  const double copied = cpu_seconds();
  for (unsigned m = 0; m < g->s.mesh_count; m++) {
    const RTCGeometry geometry = rtcGetGeometry(p->theirs, m);
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
    rtcCommitGeometry(geometry);
  }
  rtcCommitScene(p->theirs);
  *refit = cpu_seconds() - copied, *copy = copied - start;
}

/* Trees built at rest follow the meshes to their second pose, and back, and there again: an odd number of times. The
   stage is left in that pose. */
static void add_refits(report *to, stage *g, const setting *how, pair *pairs, unsigned count, unsigned rounds) {
  static double ours[MAX_PAIRS][MAX_ROUNDS], theirs[MAX_PAIRS][MAX_ROUNDS];
  static double ours_all[MAX_PAIRS][MAX_ROUNDS], theirs_all[MAX_PAIRS][MAX_ROUNDS];
  rounds -= rounds % 2 == 0;
  for (unsigned r = 0; r < rounds + 2; r++) { /* first there and back untimed: it makes room for further positions */
    const unsigned at = r < 2 ? 0 : r - 2;
    swap_poses(g);
    for (unsigned i = 0; i < count; i++) {
      double copy;
      refit_ours(&pairs[i], g, &copy, &ours[i][at]);
      ours_all[i][at] = copy + ours[i][at];
      if (!pairs[i].device) continue;
      refit_theirs(&pairs[i], g, &copy, &theirs[i][at]);
      theirs_all[i][at] = copy + theirs[i][at];
    }
  }
  for (unsigned i = 0; i < count; i++) {
    add_times(to, g, how, &pairs[i], "refit", ours[i], theirs[i], rounds);
    add_times(to, g, how, &pairs[i], "copy and refit", ours_all[i], theirs_all[i], rounds);
    printf("  refit %s: pktrt %.2f ms", pktrt_isa_string(pairs[i].isa), 1e3 * median_of(ours[i], rounds));
    if (pairs[i].device) printf(", Embree %.2f ms", 1e3 * median_of(theirs[i], rounds));
    printf("\n");
  }
}

/* >>orders --------------------------------------------------------------------------------------------------------- */

typedef enum order { COHERENTLY, SHUFFLED, ALTERNATING, MIXED, ORDERS } order;
static const char *const order_names[ORDERS] = {"coherent", "shuffled", "alternating", "mixed"};

static void shuffle(pktrt_ray *r, size_t n) {
  for (size_t i = n; i > 1; i--) {
    const size_t k = (size_t)((double)uniform(i, 7) * (double)i);
    const pktrt_ray swapped = r[i - 1];
    r[i - 1] = r[k], r[k] = swapped;
  }
}

static unsigned octant_of(const pktrt_ray *r) {
  return (unsigned)(r->direction[0] < 0) | (unsigned)(r->direction[1] < 0) << 1 | (unsigned)(r->direction[2] < 0) << 2;
}

/* No two neighbours of one octant, as long as there are others. */
static void alternate(pktrt_ray *r, size_t n) {
  size_t at[8], end = 0;
  pktrt_ray *all = (pktrt_ray *)take(n, sizeof *all);
  memcpy(all, r, n * sizeof *r);
  for (unsigned o = 0; o < 8; o++)
    for (at[o] = 0; at[o] < n && octant_of(&all[at[o]]) != o;) at[o]++;
  while (end < n)
    for (unsigned o = 0; o < 8; o++) {
      if (at[o] == n) continue;
      r[end++] = all[at[o]];
      do at[o]++;
      while (at[o] < n && octant_of(&all[at[o]]) != o);
    }
  free(all);
}

/* Mirror rays in the order of the pixels; diffuse rays shuffled; by turns of octants; or of lengths from a ten
   thousandth of the diagonal to all of it, as they come. */
static void make_order(const stage *g, const pktrt_scene *world, order how, const sources *s, ray_set *out) {
  make_kind(g, world, how == COHERENTLY ? MIRROR : DIFFUSE, s, out);
  if (how == SHUFFLED) shuffle(out->ray, out->count);
  if (how == ALTERNATING) alternate(out->ray, out->count);
  for (size_t i = 0; how == MIXED && i < out->count; i++)
    out->ray[i].tmax = (float)(g->diagonal * pow(10, -4 * (double)uniform(i, 6)));
}

/* Returns the seconds of all rays, by calls for n (0: single calls), and lowers the least of each part. */
static double run_in_calls(const pktrt_scene *s, const job *j, size_t n, double *least) {
  const size_t part = n > PART ? n : PART;
  double sum = 0;
  for (size_t first = 0; first < j->r.count; first += part, least++) {
    const size_t end = j->r.count - first < part ? j->r.count : first + part;
    const double start = cpu_seconds();
    if (n == 0) run_ours(s, OURS_SINGLE, j, first, end);
    for (size_t i = first; n && i < end; i += n) run_ours(s, OURS_N, j, i, end - i < n ? end : i + n);
    const double seconds = cpu_seconds() - start;
    sum += seconds, *least = fmin(*least, seconds);
  }
  return sum;
}
static double sum_of_least(const double *least) {
  double sum = 0;
  for (int i = 0; i < PARTS && least[i] < HUGE_VAL; i++) sum += least[i];
  return sum;
}

static void add_order(
    report *to, const options *o, const stage *g, const setting *how, const pair *p, order in, job *j) {
  static const size_t calls[] = {0, 1, 2, 7, 16, 64, 1000, 1000000};
  enum { CALLS = sizeof calls / sizeof *calls };
  const unsigned rounds = o->rounds + 2 <= MAX_ROUNDS ? o->rounds + 2 : o->rounds; /* the worst of all counts */
  static double seconds[CALLS][MAX_ROUNDS], least[CALLS][PARTS];
  for (int i = 0; i < CALLS * PARTS; i++) least[i / PARTS][i % PARTS] = HUGE_VAL;
  for (unsigned r = 0; r < rounds; r++)
    for (int c = 0; c < CALLS; c++) seconds[c][r] = run_in_calls(p->ours, j, calls[c], least[c]);
  const double single = median_of(seconds[0], rounds), single_best = sum_of_least(least[0]);
  printf("  %-11s %-6s %-9s single %5.2f, _n:", order_names[in], pktrt_isa_string(p->isa),
      j->occlusion ? "occlusion" : "closest", 1e-6 * (double)j->r.count / single);
  for (int c = 1; c < CALLS; c++) {
    char what[32];
    snprintf(what, sizeof what, "%s %s %zu", order_names[in], j->occlusion ? "any" : "closest",
        calls[c] < j->r.count ? calls[c] : j->r.count);
    const double many = median_of(seconds[c], rounds), ratio = single_best / sum_of_least(least[c]);
    row *r = ratio_row(to, g, how, p, what, "_n/single", single / many, ratio);
    r->rays = j->r.count, r->rounds = rounds;
    printf(" %.2f", ratio);
  }
  printf("\n");
  fflush(stdout);
}

/* On a scene that stands built: calls for n rays at a time, over single calls. */
static void add_orders(report *to, const options *o, const stage *g, const setting *how, const pair *pairs,
    unsigned count, const sources *s, job *j) {
  for (int in = 0; in < ORDERS; in++) {
    make_order(g, pairs[0].ours, (order)in, s, &j->r);
    for (unsigned p = 0; p < count; p++)
      for (int k = 0; k < 2 && pairs[p].isa != PKTRT_ISA_SCALAR; k++) {
        j->occlusion = k;
        add_order(to, o, g, how, &pairs[p], (order)in, j);
      }
  }
}

/* >>workers -------------------------------------------------------------------------------------------------------- */

#ifdef __linux__
static cpu_set_t cores; /* that the process may use */

/* To the last one of these: the first serves most interrupts. */
static void pin(void) {
  cpu_set_t one;
  if (sched_getaffinity(0, sizeof cores, &cores) != 0) return;
  size_t last = CPU_SETSIZE;
  for (size_t i = 0; i < CPU_SETSIZE; i++)
    if (CPU_ISSET(i, &cores)) last = i;
  CPU_ZERO(&one);
  if (last < CPU_SETSIZE) CPU_SET(last, &one), sched_setaffinity(0, sizeof one, &one);
}
static unsigned unpin(void) {
  return sched_setaffinity(0, sizeof cores, &cores) == 0 ? (unsigned)CPU_COUNT(&cores) : 1;
}
#else
static void pin(void) {}
static unsigned unpin(void) { return 1; }
#endif

static pktrt_scene *open_world(const stage *g, pktrt_isa isa, ex_threads *threads) {
  pktrt_scene_desc desc;
  memset(&desc, 0, sizeof desc);
  desc.isa = isa, desc.user = threads, desc.parallel_for = threads->count > 1 ? ex_parallel_for : NULL;
  pktrt_scene *world = pktrt_scene_create(&desc);
  if (!world || scene_add(world, &g->s) != PKTRT_OK) fatal(pktrt_last_error(world));
  return world;
}

/* Seconds by the clock of building the trees. */
static double time_build(pktrt_scene *world) {
  const double start = ex_seconds();
  if (pktrt_commit(world) != PKTRT_OK) fatal(pktrt_last_error(world));
  return ex_seconds() - start;
}

/* The same of a picture by Whitted's mode. */
static double time_picture(pktrt_scene *world, const stage *g, float *pixels, unsigned size) {
  pktrt_render_desc d;
  memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = d.height = size, d.pixels = pixels, d.mode = PKTRT_MODE_WRT, d.camera = g->s.camera;
  const double start = ex_seconds();
  if (pktrt_render(world, &d) != PKTRT_OK) fatal(pktrt_last_error(world));
  return ex_seconds() - start;
}

static void work(
    const stage *g, pktrt_isa isa, unsigned workers, float *pixels, unsigned size, double *build, double *render) {
  ex_threads threads = ex_threads_of(workers);
  pktrt_scene *world = open_world(g, isa, &threads);
  *build = time_build(world), *render = time_picture(world, g, pixels, size);
  pktrt_scene_destroy(world);
  ex_threads_stop(&threads);
}

static void add_workers(
    report *to, const options *o, const stage *g, const setting *how, const pair *pairs, unsigned count) {
  double build[2][MAX_ROUNDS], render[2][MAX_ROUNDS];
  const unsigned size = o->size;
  float *pixels = (float *)take((size_t)size * size * 3, sizeof(float));
  if (unpin() < 2) {
    printf("  two workers: not measured, this process may use one core only\n");
  } else {
    for (unsigned p = 0; p < count && pairs[p].isa != PKTRT_ISA_SCALAR; p++) {
      for (unsigned r = 0; r < o->rounds; r++)
        for (unsigned w = 0; w < 2; w++) work(g, pairs[p].isa, w + 1, pixels, size, &build[w][r], &render[w][r]);
      const double b = median_of(build[0], o->rounds) / median_of(build[1], o->rounds),
                   f = median_of(render[0], o->rounds) / median_of(render[1], o->rounds);
      ratio_row(to, g, how, &pairs[p], "build", "workers", b, build[0][0] / build[1][0])->rounds = o->rounds;
      ratio_row(to, g, how, &pairs[p], "render", "workers", f, render[0][0] / render[1][0])->rounds = o->rounds;
      printf("  two workers, %s: build %.2fx, render %.2fx\n", pktrt_isa_string(pairs[p].isa), b, f);
    }
  }
  pin();
  free(pixels);
}

/* >>shading -------------------------------------------------------------------------------------------------------- */

/* Clock reads around the kernel that sets up, traces and resolves rays, of a scene whose kernels are replaced so. The
   rest of a render is shading, and half of what reading the clock takes. */
static struct {
  void (*trace)(const pk_query *, pk_batch *, uint32_t, uint32_t);
  double seconds;
} traced;

static void trace_by_clock(const pk_query *call, pk_batch *b, uint32_t begin, uint32_t end) {
  const double start = ex_seconds();
  traced.trace(call, b, begin, end);
  traced.seconds += ex_seconds() - start;
}

/* Of the time of a picture by Whitted's mode, with one worker. */
static void add_shading(
    report *to, const options *o, const stage *g, const setting *how, const pair *pairs, unsigned count) {
  const unsigned size = o->size;
  float *pixels = (float *)take((size_t)size * size * 3, sizeof(float));
  ex_threads alone = ex_threads_of(1);
  for (unsigned p = 0; p < count && pairs[p].isa != PKTRT_ISA_SCALAR; p++) {
    pktrt_scene *world = open_world(g, pairs[p].isa, &alone);
    double share[MAX_ROUNDS], rest[MAX_ROUNDS];
    (void)time_build(world);
    pk_kernel_table kernels = *world->kernels;
    traced.trace = kernels.trace, kernels.trace = trace_by_clock, world->kernels = &kernels;
    for (unsigned r = 0; r < o->rounds; r++) {
      traced.seconds = 0;
      const double all = time_picture(world, g, pixels, size);
      rest[r] = all - traced.seconds, share[r] = rest[r] / all;
    }
    pktrt_scene_destroy(world);
    const double median = median_of(share, o->rounds);
    ratio_row(to, g, how, &pairs[p], "render", "shading", median, median)->rounds = o->rounds;
    printf("  shading, %s: %.1f%% of a render, %.0f ns per sample\n", pktrt_isa_string(pairs[p].isa), 1e2 * median,
        1e9 * median_of(rest, o->rounds) / ((double)size * size));
  }
  free(pixels);
}

#endif /* PEERS_UPKEEP_H */
