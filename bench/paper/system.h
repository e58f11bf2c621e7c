/* system.h - parts of paper.c that look at the system as a whole: sections 3.1 and 6, frame rates.

   Contents: tap, section 3.1, shading, cores, deformation, section 6, frames. */
#ifndef PAPER_SYSTEM_H
#define PAPER_SYSTEM_H

#include "paper.h"
#include <sched.h>

static const char *const scenes[3] = {"conference", "rtrt", "poolhall"};

/* >>tap ------------------------------------------------------------------------------------------------------------ */

typedef struct ray_list {
  pktrt_ray *ray;
  float *answer; /* t, or 0 if only occlusion was asked; infinity on a miss */
  size_t *chunk; /* where each batch begins */
  size_t count, chunks, room;
} ray_list;

/* Between the renderer and the kernels of a scene: every batch of rays passes through a function of ours. There is no
   public way to do that: it goes behind the API. The table of kernels hands on no pointer of ours, hence the one
   variable; while a tap is open, one thread renders. */
static struct tap {
  const pk_kernel_table *behind;
  pk_kernel_table front;
  double seconds; /* spent behind */
  uint64_t batches;
  ray_list *list[2]; /* of rays to be intersected, of rays asked for occlusion */
} tap;

static void tap_open(pktrt_scene *tree, void (*trace)(const pk_query *, pk_batch *, uint32_t, uint32_t)) {
  tap.behind = tree->kernels, tap.front = *tree->kernels;
  tap.front.trace = trace;
  tap.seconds = 0, tap.batches = 0;
  tree->kernels = &tap.front;
}
static void tap_close(pktrt_scene *tree) { tree->kernels = tap.behind; }

/* Rays of path SINGLE go the paper path, as packets of one. */
static void trace_alone(const pk_query *call, pk_batch *b, uint32_t begin, uint32_t end) {
  pk_query c = *call;
  pktrt_query_desc alone = *call->desc;
  if (alone.path == PKTRT_PATH_SINGLE) alone.path = PKTRT_PATH_PAPER, alone.packet_size = 1;
  c.desc = &alone;
  tap.behind->trace(&c, b, begin, end);
}

static void trace_clocked(const pk_query *call, pk_batch *b, uint32_t begin, uint32_t end) {
  const double start = ex_seconds();
  tap.behind->trace(call, b, begin, end);
  tap.seconds += ex_seconds() - start;
  tap.batches++;
}

/* Keeps the rays that count, and what became of them. */
EX_UNUSED static void trace_recorded(const pk_query *call, pk_batch *b, uint32_t begin, uint32_t end) {
  ray_list *to = tap.list[call->occlusion];
  tap.behind->trace(call, b, begin, end);
  if (!to) return;
  if (to->room - to->count < end - begin) fatal("more rays than there is room for");
  to->chunk[to->chunks++] = to->count;
  for (uint32_t i = begin; i < end; i++) {
    pktrt_ray *r = &to->ray[to->count];
    if (!(b->valid[i / 64] >> i % 64 & 1)) continue;
    for (int a = 0; a < 3; a++) r->origin[a] = b->o[a][i], r->direction[a] = b->d[a][i];
    r->tmin = b->tmin[i], r->tmax = b->tmax[i], r->time = b->time[i];
    to->answer[to->count++] = b->slot[i] == PKTRT_NONE ? INFINITY : call->occlusion ? 0 : b->t[i];
  }
}

EX_UNUSED static ray_list make_list(size_t room) {
  ray_list l;
  memset(&l, 0, sizeof l);
  l.ray = (pktrt_ray *)take(room, sizeof *l.ray);
  l.answer = (float *)take(room, sizeof *l.answer);
  l.chunk = (size_t *)take(room, sizeof *l.chunk);
  l.room = room;
  return l;
}
EX_UNUSED static void free_list(ray_list *l) {
  free(l->ray);
  free(l->answer);
  free(l->chunk);
}

/* >>section 3.1 ---------------------------------------------------------------------------------------------------- */

/* What vectors are used for: V vector tests of eight lanes make T tests of a ray and a box or triangle. Against rays
   that are traced alone (V1 = T1: one lane of each vector)

       V1 / V  =  T / V  *  T1 / T       fewer vectors = lanes in use * fewer tests: SIMD * amortisation */
typedef struct use {
  double vectors, lanes, fewer; /* V per ray, T / V, T1 / T */
} use;

static double tests_of(const pktrt_counts *c) { return (double)c->box_tests + (double)c->triangle_tests; }

static use use_of(const pktrt_counts *c, const pktrt_counts *alone) {
  use u;
  memset(&u, 0, sizeof u);
  if (!c->rays || !vector_tests(c)) return u;
  u.vectors = per_ray(vector_tests(c), c);
  u.lanes = tests_of(c) / (double)vector_tests(c);
  u.fewer = tests_of(alone) / tests_of(c);
  return u;
}

static pktrt_counts sum_of(const row *r) {
  pktrt_counts all;
  memset(&all, 0, sizeof all);
  for (int t = 0; t < TYPES; t++) pk_packet_add_counts(&all, &r->stats.by_type[t], sizeof all);
  return all;
}

/* Five rows: rays alone, packets by size. */
static void report_use(bench *b, const row *r) {
  const pktrt_counts alone = sum_of(r);
  for (int k = 0; k < 5; k++) {
    const pktrt_counts all = sum_of(&r[k]);
    const use u = use_of(&all, &alone);
    char packets[16];
    snprintf(packets, sizeof packets, "%ux%u", r[k].s.packet, r[k].s.packet);
    say(&b->out, "| %s | %s | %.2f | %.2fx | %.2fx | %.1f | %.2fx | %.2f | %.2fx |\n", r->s.scene,
        k ? packets : "alone", mrays(&r[k]), times_as_fast(b, &r[k], r), times_as_fast(b, &r[k], &r[1]), u.vectors,
        u.lanes * u.fewer, u.lanes, u.fewer);
    for (int t = -1; t < TYPES; t++) {
      const pktrt_counts *c = t < 0 ? &all : &r[k].stats.by_type[t], *one = t < 0 ? &alone : &r->stats.by_type[t];
      const use v = use_of(c, one);
      if (!c->rays) continue;
      csv(&b->out, "%s,%s,%s,%llu,%.4f,%.4f,%.4f,%.4f,%.4f", r->s.scene, k ? packets : "alone",
          t < 0 ? "all" : type_names[t], (unsigned long long)c->rays, v.vectors, tests_of(c) / (double)c->rays, v.lanes,
          v.fewer, v.lanes * v.fewer);
      if (t < 0) csv(&b->out, ",%.4f,%.6f,%.4f\n", mrays(&r[k]), r[k].seconds, times_as_fast(b, &r[k], &r[1]));
      else csv(&b->out, ",,,\n");
    }
  }
}

/* Of four lanes for each vector test of 2x2 packets, those whose rays would have made the test alone: nothing is
   amortised there but over the four. The paper's "SIMD utilization between 25% and 100%". Packets that have become thin
   leave lanes empty. */
static void report_quads(bench *b, const row *r) {
  const pktrt_counts alone = sum_of(r), quads = sum_of(&r[1]);
  say(&b->out, "| %s | %.0f %% |", r->s.scene, 100 * tests_of(&alone) / (4 * (double)vector_tests(&quads)));
  for (int t = 0; t < PKTRT_RAY_OTHER; t++) {
    const pktrt_counts *c = &r[1].stats.by_type[t];
    if (c->rays) say(&b->out, " %.0f %% |", 100 * tests_of(&r->stats.by_type[t]) / (4 * (double)vector_tests(c)));
    else say(&b->out, " - |");
  }
  say(&b->out, "\n");
}

static void section31(bench *b) {
  const row *r[3];
  csv(&b->out,
      "scene,packets,of,rays,vector_tests_per_ray,tests_per_ray,lanes_in_use,fewer_tests,fewer_vector_tests,mrays,"
      "seconds,over_2x2\n");
  say_machines(b);
  say(&b->out,
      "Paper path, %s, vectors of eight lanes. Alone: every ray, primary ones too. The paper: 1.8x to 2.0x in speed "
      "through SIMD alone (2x2), a further ~1.5x in speed through algorithmic amortisation (the column over 2x2). "
      "Vector tests become fewer by lanes in use times fewer tests.\n\n"
      "| scene | packets | Mrays/s | speed-up | over 2x2 | vector tests/ray | fewer | lanes in use | fewer tests |\n"
      "|---|---|--:|--:|--:|--:|--:|--:|--:|\n",
      pktrt_isa_string(four_lanes()));
  for (int k = 0; k < 3; k++) {
    setup ways[5];
    for (int e = 0; e < 5; e++) {
      ways[e] = whitted(b, scenes[k]);
      column(0, &ways[e]);
      ways[e].frames = (b->given.frames + 1) / 2; /* rays alone take their time */
      if (e) ways[e].packet = edges[e - 1];
      else ways[e].path = PKTRT_PATH_SINGLE; /* the tap makes of it what is meant */
    }
    open_setup(&b->now, &ways[0]);
    tap_open(b->now.tree, trace_alone);
    r[k] = measure(b, ways, 5);
    tap_close(b->now.tree);
    report_use(b, r[k]);
  }
  say(&b->out,
      "\nLanes of 2x2 packets whose rays would have made the test alone (the paper: 25 %% to 100 %%), by type of ray:"
      "\n\n| scene | all |");
  for (int t = 0; t < PKTRT_RAY_OTHER; t++) say(&b->out, " %s |", type_names[t]);
  say(&b->out, "\n|---|--:|--:|--:|--:|--:|\n");
  for (int k = 0; k < 3; k++) report_quads(b, r[k]);
  say(&b->out, "\n");
  b->row_count = 0; /* written already */
}

/* >>shading -------------------------------------------------------------------------------------------------------- */

/* What a reading of the clock takes, found out once: little beside a batch of rays, unless few are left in it. */
static double clock_cost(void) {
  enum { READINGS = 100000 };
  static double cost;
  if (cost > 0) return cost;
  const double start = ex_seconds();
  for (int i = 0; i < READINGS; i++) (void)ex_seconds();
  cost = (ex_seconds() - start) / READINGS;
  return cost;
}

typedef struct share { /* of all time, medians */
  double shading, clock;
} share;

/* Everything but the kernels that trace: camera, assembly of packets, surfaces, materials, light. Of the two readings
   for each batch, about one falls into either part. */
static share measure_share(bench *b, const setup *s) {
  double shading[MAX_ROUNDS], clocked[MAX_ROUNDS];
  pktrt_render_desc d;
  share result;
  open_setup(&b->now, s);
  describe(b, s, 0, NULL, &d);
  for (unsigned k = 0; k < b->given.rounds; k++) {
    tap_open(b->now.tree, trace_clocked);
    const double start = ex_seconds();
    make_picture(b, s, 0, &d);
    const double all = ex_seconds() - start, readings = (double)tap.batches * clock_cost();
    tap_close(b->now.tree);
    shading[k] = 1 - (tap.seconds - readings) / (all - 2 * readings), clocked[k] = 2 * readings / all;
  }
  result.shading = median_of(shading, b->given.rounds), result.clock = median_of(clocked, b->given.rounds);
  return result;
}

static void report_shading(bench *b) {
  say(&b->out,
      "Shading in per cent of a frame's time: all that is not tracing rays. The paper: \"shading is now 1/3 of the "
      "total\".\n\n| scene | path | isa | RCS | WRT | DRT 16 |\n|---|---|---|--:|--:|--:|\n");
  for (int k = 0; k < 3; k++)
    for (int fast = 0; fast < 2; fast++) { /* the paper path as in the paper, the fast one as it is used */
      setup s;
      for (int m = 0; m < 3; m++) {
        s = one_frame(b, scenes[k], (pktrt_mode)m, m == PKTRT_MODE_DRT ? 4 : 1);
        column(fast ? columns() - 1 : 0, &s);
        const share part = measure_share(b, &s);
        if (!m) say(&b->out, "| %s | %s | %s |", scenes[k], path_names[s.path], pktrt_isa_string(s.isa));
        say(&b->out, " %.0f %% |", 100 * part.shading);
        csv(&b->out, "shading,%s,%s,%s,%s,%u,share_of_time,%.4f\n", scenes[k], mode_names[m], path_names[s.path],
            pktrt_isa_string(s.isa), s.samples, part.shading);
        csv(&b->out, "shading,%s,%s,%s,%s,%u,clock_share_of_time,%.4f\n", scenes[k], mode_names[m], path_names[s.path],
            pktrt_isa_string(s.isa), s.samples, part.clock);
      }
      say(&b->out, "\n");
      fprintf(stderr, "%s: %s, %s path: shading done\n", b->out.name, scenes[k], path_names[s.path]);
    }
  say(&b->out, "\n");
}

/* >>cores ---------------------------------------------------------------------------------------------------------- */

/* Lets this thread, and those it starts, run everywhere, though the program be tied to one core; returns how many cores
   there are. */
static unsigned untie(cpu_set_t *tied) {
  cpu_set_t all;
  memset(&all, 0xFF, sizeof all);
  if (sched_getaffinity(0, sizeof *tied, tied) != 0) fatal("the cores of this program cannot be asked for");
  sched_setaffinity(0, sizeof all, &all); /* if it may not, the tie stays */
  if (sched_getaffinity(0, sizeof all, &all) != 0) fatal("the cores of this program cannot be asked for");
  const int n = CPU_COUNT(&all);
  return n < 1 ? 1 : n > EX_MAX_THREADS ? (unsigned)EX_MAX_THREADS : (unsigned)n;
}
static void tie(const cpu_set_t *tied) { sched_setaffinity(0, sizeof *tied, tied); }

/* Has a scene work on several threads from now on. The API takes them when a scene is created; worlds are shared with
   parts that want one thread. */
static void set_threads(pktrt_scene *tree, ex_threads *threads) {
  tree->desc.parallel_for = threads ? ex_parallel_for : NULL;
  tree->desc.user = threads;
}

/* Wall-clock seconds of whole frames, each on its number of threads; the median of rounds in which they take turns. */
static void measure_threads(bench *b, const setup *s, const unsigned *count, size_t n, double *seconds) {
  enum { MOST = 16 };
  double took[MOST][MAX_ROUNDS];
  pktrt_render_desc d;
  ex_threads threads = ex_threads_of(1);
  if (n > MOST) fatal("more numbers of threads than there is room for");
  open_setup(&b->now, s);
  describe(b, s, 0, NULL, &d);
  set_threads(b->now.tree, &threads);
  for (unsigned k = 0; k < b->given.rounds; k++)
    for (size_t i = 0; i < n; i++) {
      threads.count = count[i];
      const double start = ex_seconds();
      if (pktrt_render(b->now.tree, &d) != PKTRT_OK) fatal(pktrt_last_error(b->now.tree));
      took[i][k] = ex_seconds() - start;
    }
  set_threads(b->now.tree, NULL);
  ex_threads_stop(&threads);
  for (size_t i = 0; i < n; i++) seconds[i] = median_of(took[i], b->given.rounds);
}

static void report_cores(bench *b) {
  enum { MOST = 10 };
  cpu_set_t tied;
  const unsigned cores = untie(&tied);
  unsigned count[MOST] = {1}, n = 1;
  while (n < MOST && count[n - 1] < cores) count[n] = 2 * count[n - 1] < cores ? 2 * count[n - 1] : cores, n++;
  say(&b->out,
      "Whole frames of %u x %u pixels, fast path, %s: milliseconds on one thread (wall-clock), and speed-up on "
      "more%s.\n\n| scene | mode | 1 thread |",
      b->given.size, b->given.size, pktrt_isa_string(widest()), cores < 2 ? "; there is one core only" : "");
  for (unsigned i = 1; i < n; i++) say(&b->out, " %u threads |", count[i]);
  say(&b->out, "\n|---|---|--:|");
  for (unsigned i = 1; i < n; i++) say(&b->out, "--:|");
  say(&b->out, "\n");
  for (int k = 0; k < 3; k++)
    for (int m = 0; m < 3; m++) {
      double seconds[MOST];
      setup s = one_frame(b, scenes[k], (pktrt_mode)m, 1);
      s.path = PKTRT_PATH_FAST, s.isa = widest();
      measure_threads(b, &s, count, n, seconds);
      say(&b->out, "| %s | %s | %.1f ms |", scenes[k], mode_names[m], 1e3 * seconds[0]);
      for (unsigned i = 0; i < n; i++) {
        if (i) say(&b->out, " %.2fx |", seconds[0] / seconds[i]);
        csv(&b->out, "cores,%s,%s,fast,%s,1,seconds_on_%u_threads,%.6f\n", scenes[k], mode_names[m],
            pktrt_isa_string(s.isa), count[i], seconds[i]);
      }
      say(&b->out, "\n");
    }
  say(&b->out, "\n");
  tie(&tied);
}

/* >>deformation ---------------------------------------------------------------------------------------------------- */

enum { POSES = 6 };

typedef struct upkeep { /* of one pose: seconds; how much worse the refitted tree is than at its build, by its cost */
  double refit, rebuild, refitted_frame, rebuilt_frame, wear;
} upkeep;

/* Both trees hold the new pose: one is refitted, the other built anew; then each makes the frame. */
static upkeep keep_up(bench *b, pktrt_scene *worn, pktrt_scene *fresh, pktrt_render_desc *d) {
  upkeep u;
  pktrt_scene_info info;
  double at[5];
  at[0] = cpu_seconds();
  if (pktrt_refit(worn) != PKTRT_OK) fatal(pktrt_last_error(worn));
  at[1] = cpu_seconds();
  if (pktrt_commit(fresh) != PKTRT_OK) fatal(pktrt_last_error(fresh));
  at[2] = cpu_seconds();
  if (pktrt_render(worn, d) != PKTRT_OK) fatal(pktrt_last_error(worn));
  at[3] = cpu_seconds();
  const uint64_t sum = add_checksum(0, b->pixels, (size_t)b->given.size * b->given.size * 3);
  at[4] = cpu_seconds();
  if (pktrt_render(fresh, d) != PKTRT_OK) fatal(pktrt_last_error(fresh));
  u.rebuilt_frame = cpu_seconds() - at[4];
  if (sum != add_checksum(0, b->pixels, (size_t)b->given.size * b->given.size * 3))
    fatal("the refitted tree made another picture than the rebuilt one");
  u.refit = at[1] - at[0], u.rebuild = at[2] - at[1], u.refitted_frame = at[3] - at[2];
  pktrt_get_scene_info(worn, &info);
  u.wear = info.sah_now / info.sah_at_build;
  return u;
}

static void report_upkeep(bench *b, const char *name, const pktrt_scene *tree, const upkeep u[POSES]) {
  double v[5][POSES], m[5];
  pktrt_scene_info info;
  pktrt_get_scene_info(tree, &info);
  for (int i = 0; i < POSES; i++)
    v[0][i] = u[i].refit, v[1][i] = u[i].rebuild, v[2][i] = u[i].refitted_frame, v[3][i] = u[i].rebuilt_frame,
    v[4][i] = u[i].wear;
  for (int i = 0; i < 5; i++) m[i] = median_of(v[i], POSES);
  say(&b->out, "| %s | %llu | %.2f | %.1f | %.1f | %.1f | %.2f |\n", name, (unsigned long long)info.triangles,
      1e3 * m[0], 1e3 * m[1], 1e3 * m[2], 1e3 * m[3], m[4]);
  static const char *const names[5] = {
      "refit_seconds", "rebuild_seconds", "refitted_frame_seconds", "rebuilt_frame_seconds", "sah_over_sah_at_build"};
  for (int i = 0; i < 5; i++)
    csv(&b->out, "deformation,%s of %llu,WRT,fast,%s,1,%s,%.6f\n", name, (unsigned long long)info.triangles,
        pktrt_isa_string(info.isa), names[i], m[i]);
}

/* The deforming things of a scene at poses of its animation; the camera stays. */
static void deform_scene(bench *b, const char *name) {
  setup s = one_frame(b, name, PKTRT_MODE_WRT, 1);
  pktrt_scene *tree[2];
  pktrt_render_desc d;
  upkeep u[POSES];
  s.path = PKTRT_PATH_FAST, s.isa = widest(), s.look = AS_MADE;
  open_setup(&b->now, &s);
  describe(b, &s, 0, NULL, &d);
  for (int i = 0; i < 2; i++) {
    tree[i] = pktrt_scene_create(NULL);
    if (!tree[i] || scene_add(tree[i], &b->now.made) != PKTRT_OK || pktrt_commit(tree[i]) != PKTRT_OK)
      fatal(pktrt_last_error(tree[i]));
  }
  for (int p = 0; p < POSES; p++) {
    for (int i = 0; i < 2; i++)
      if (scene_pose(tree[i], &b->now.made, (p + 0.5) / POSES, 0) != PKTRT_OK) fatal(pktrt_last_error(tree[i]));
    u[p] = keep_up(b, tree[0], tree[1], &d);
  }
  report_upkeep(b, name, tree[0], u);
  for (int i = 0; i < 2; i++) pktrt_scene_destroy(tree[i]);
}

/* A sheet of edge x edge squares; waves run over it. */
static void sheet_pose(float *at, uint32_t edge, double phase) {
  for (uint32_t j = 0; j <= edge; j++)
    for (uint32_t i = 0; i <= edge; i++) {
      const double x = 2.0 * i / edge - 1, z = 2.0 * j / edge - 1;
      float *v = at + 3 * ((size_t)j * (edge + 1) + i);
      v[0] = (float)x, v[1] = (float)(0.15 * sc_sin(360 * (phase + x * x + z * z))), v[2] = (float)z;
    }
}

static pktrt_scene *sheet_tree(uint32_t edge, float *at, uint32_t *indices) {
  pktrt_mesh_desc m;
  pktrt_light sun;
  uint32_t *to = indices;
  for (uint32_t j = 0; j < edge; j++)
    for (uint32_t i = 0; i < edge; i++) {
      const uint32_t v = j * (edge + 1) + i, w = v + edge + 1;
      *to++ = v, *to++ = w, *to++ = v + 1, *to++ = v + 1, *to++ = w, *to++ = w + 1;
    }
  memset(&m, 0, sizeof m);
  m.positions = at, m.vertex_count = (edge + 1) * (edge + 1), m.indices = indices, m.triangle_count = 2 * edge * edge;
  memset(&sun, 0, sizeof sun);
  sun.kind = PKTRT_LIGHT_DIRECTIONAL;
  sun.direction[0] = 1, sun.direction[1] = -2, sun.direction[2] = 1;
  sun.intensity[0] = sun.intensity[1] = sun.intensity[2] = 3;
  pktrt_scene *tree = pktrt_scene_create(NULL);
  if (!tree || pktrt_add_mesh(tree, &m, NULL) != PKTRT_OK || pktrt_add_light(tree, &sun, NULL) != PKTRT_OK ||
      pktrt_commit(tree) != PKTRT_OK)
    fatal(pktrt_last_error(tree));
  return tree;
}

static void deform_sheet(bench *b, uint32_t edge) {
  const size_t vertices = (size_t)(edge + 1) * (edge + 1);
  float *at = (float *)malloc(vertices * 3 * sizeof(float));
  uint32_t *indices = (uint32_t *)malloc((size_t)edge * edge * 6 * sizeof(uint32_t));
  pktrt_scene *tree[2];
  pktrt_render_desc d;
  upkeep u[POSES];
  if (!at || !indices) fatal("not enough memory");
  sheet_pose(at, edge, 0);
  for (int i = 0; i < 2; i++) tree[i] = sheet_tree(edge, at, indices);
  memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = d.height = b->given.size, d.pixels = b->pixels, d.mode = PKTRT_MODE_WRT;
  d.camera.eye[0] = 1, d.camera.eye[1] = 1.5f, d.camera.eye[2] = 2.5f;
  for (int p = 0; p < POSES; p++) {
    sheet_pose(at, edge, (p + 0.5) / POSES);
    for (int i = 0; i < 2; i++)
      if (pktrt_set_positions(tree[i], 0, 0, at) != PKTRT_OK) fatal(pktrt_last_error(tree[i]));
    u[p] = keep_up(b, tree[0], tree[1], &d);
  }
  report_upkeep(b, "sheet", tree[0], u);
  for (int i = 0; i < 2; i++) pktrt_scene_destroy(tree[i]);
  free(at);
  free(indices);
}

static void report_deformation(bench *b) {
  static const uint32_t sheets[] = {32, 64, 128, 256, 512};
  say(&b->out,
      "Deforming meshes, median of %d poses, one thread, fast path, Whitted's mode, %u x %u pixels; milliseconds. "
      "SAH: the cost of the refitted tree over that of the tree as it was built, at rest.\n\n"
      "| scene | triangles | refit | rebuild | frame, refitted | frame, rebuilt | SAH |\n"
      "|---|--:|--:|--:|--:|--:|--:|\n",
      POSES, b->given.size, b->given.size);
  deform_scene(b, "rtrt");
  for (size_t i = 0; i < sizeof sheets / sizeof *sheets; i++) deform_sheet(b, sheets[i]);
  say(&b->out, "\n");
}

/* >>section 6 ------------------------------------------------------------------------------------------------------ */

static void section6(bench *b) {
  csv(&b->out, "what,scene,mode,path,isa,samples,quantity,value\n");
  report_shading(b);
  report_cores(b);
  report_deformation(b);
}

/* >>frames --------------------------------------------------------------------------------------------------------- */

typedef struct sheaf { /* tiles of a frame, to be made by any thread */
  const pktrt_scene *tree;
  const pktrt_render_desc *d;
  uint32_t edge; /* of a tile, pixels */
} sheaf;

static void make_tile(void *arg, size_t i) {
  const sheaf *t = (const sheaf *)arg;
  const uint32_t across = t->d->width / t->edge;
  const double k = 0.5 + (double)i, u = k * 0.7548776662466927, v = k * 0.5698402909980532; /* as in make_picture */
  const uint32_t x = (uint32_t)((u - floor(u)) * across), y = (uint32_t)((v - floor(v)) * across);
  if (pktrt_render_tile(t->tree, t->d, t->edge * x, t->edge * y, t->edge, t->edge) != PKTRT_OK)
    fatal("a tile could not be rendered");
}

/* Seconds that a frame takes by the clock on the wall. Where it has more tiles of 64 x 64 primary rays than 1024 over
   `every`, so many of them are made and stand for the whole. */
static double frame_seconds(bench *b, const setup *s, float *pixels, unsigned size, ex_threads *threads) {
  double took[MAX_ROUNDS];
  pktrt_render_desc d;
  describe(b, s, 0, NULL, &d);
  d.width = d.height = size, d.pixels = pixels;
  sheaf t;
  t.tree = b->now.tree, t.d = &d, t.edge = 64 / s->root;
  const unsigned all = (size / t.edge) * (size / t.edge), most = 1024 / b->given.every ? 1024 / b->given.every : 1;
  set_threads(b->now.tree, threads);
  for (unsigned k = 0; k < b->given.rounds; k++) {
    const double start = ex_seconds();
    if (all > most) ex_parallel_for(threads, most, make_tile, &t);
    else if (pktrt_render(b->now.tree, &d) != PKTRT_OK) fatal(pktrt_last_error(b->now.tree));
    took[k] = (ex_seconds() - start) * (all > most ? (double)all / most : 1);
  }
  set_threads(b->now.tree, NULL);
  return median_of(took, b->given.rounds);
}

/* What is interactive: at least ten frames a second. The paper gives no number; it says that WRT "is interactive now on
   high-end desktop systems", and DRT with 64 samples "factors of hundreds or thousands" away from it. */
#define INTERACTIVE 10.0

static void report_frames(bench *b, float *pixels, unsigned size, unsigned cores) {
  static const unsigned roots[3] = {1, 2, 4};
  const unsigned counts[2] = {cores, 1};
  const int n = cores > 1 ? 2 : 1;
  for (int k = 0; k < 3; k++)
    for (int m = 0; m < 3; m++) {
      say(&b->out, "| %ux%u | %s | %s |", size, size, scenes[k], mode_names[m]);
      for (int i = 0; i < n; i++)
        for (int r = 0; r < 3; r++) {
          setup s = one_frame(b, scenes[k], (pktrt_mode)m, roots[r]);
          ex_threads threads = ex_threads_of(counts[i]);
          s.path = PKTRT_PATH_FAST, s.isa = widest();
          open_setup(&b->now, &s);
          const double seconds = frame_seconds(b, &s, pixels, size, &threads);
          ex_threads_stop(&threads);
          const bool fast = seconds * INTERACTIVE <= 1;
          say(&b->out, fast ? " **%.1f** |" : " %.2f |", 1 / seconds);
          csv(&b->out, "%s,%s,%u,%u,%u,%s,%.6f,%.4f,%d\n", scenes[k], mode_names[m], size, s.samples, counts[i],
              pktrt_isa_string(s.isa), seconds, 1 / seconds, fast);
        }
      say(&b->out, "\n");
      fprintf(stderr, "%s: %u x %u, %s %s: done\n", b->out.name, size, size, scenes[k], mode_names[m]);
    }
}

static void frames(bench *b) {
  cpu_set_t tied;
  const unsigned cores = untie(&tied), size = b->given.size;
  float *pixels = (float *)take((size_t)size * size * 12, sizeof(float));
  csv(&b->out, "scene,mode,size,samples,threads,isa,seconds,frames_per_second,interactive\n");
  say(&b->out,
      "Frames per second, fast path, %s, by samples per pixel; bold: interactive, %g or more.\n\n| pixels | scene | "
      "mode |",
      pktrt_isa_string(widest()), INTERACTIVE);
  for (unsigned i = 0; i < (cores > 1 ? 2u : 1u); i++)
    for (unsigned k = 1; k <= 16; k *= 4)
      say(&b->out, " %u thread%s: %u |", i ? 1 : cores, i || cores < 2 ? "" : "s", k);
  say(&b->out, "\n|---|---|---|--:|--:|--:|");
  if (cores > 1) say(&b->out, "--:|--:|--:|");
  say(&b->out, "\n");
  report_frames(b, pixels, size, cores);
  report_frames(b, pixels, 2 * size, cores);
  say(&b->out, "\n");
  tie(&tied);
  free(pixels);
}

#endif /* PAPER_SYSTEM_H */
