/* race.h - part of peers.c: both libraries with a stage built, and their ways to trace rays, in turns.

   Contents: pairs, modes, measuring, hits, figures. */
#ifndef PEERS_RACE_H
#define PEERS_RACE_H

#include "rays.h"
#include "report.h"
#include "scenes.h"
#include "truth.h"
#include "../embree.h"

enum { MAX_ROUNDS = 64 };

typedef struct options {
  view_options view;
  const char *results;                /* a directory, NULL: none */
  unsigned size, moving_size, rounds; /* N x N primary rays: of what is at rest, and of what moves */
  unsigned kinds, settings;           /* bits; no setting: those of the headline set, or all */
  bool full, all_modes;
} options;

/* How many primary rays there are across. Embree takes five times as long where things move. */
static unsigned rays_across(const options *o, const setting *how) {
  return how->share > 0 && !how->refit ? o->moving_size : o->size;
}

/* >>pairs ---------------------------------------------------------------------------------------------------------- */

enum { MAX_PAIRS = 8 }; /* of each instruction set one, and, where instances race, one more */
typedef struct pair {   /* an instruction set of ours, and Embree's device for the same */
  pktrt_isa isa;
  bool instanced; /* see instances.h */
  pktrt_scene *ours;
  RTCDevice device; /* NULL: Embree has none so narrow */
  RTCScene theirs;
  int64_t their_bytes;                                 /* what Embree's commit keeps */
  double our_time[MAX_ROUNDS], their_time[MAX_ROUNDS]; /* of building */
} pair;

/* From wide to narrow: what counts, and with `full` the rest. */
static unsigned open_pairs(bool full, unsigned wanted, pair p[MAX_PAIRS]) {
  static const pktrt_isa order[] = {PKTRT_ISA_AVX512, PKTRT_ISA_AVX2, PKTRT_ISA_NEON, PKTRT_ISA_SSE2, PKTRT_ISA_SCALAR};
  unsigned n = 0;
  for (size_t i = 0; i < sizeof order / sizeof *order && n < MAX_PAIRS; i++) {
    if (!pktrt_isa_available(order[i]) || (wanted && !(wanted & BIT(order[i])))) continue;
    if (!wanted && i > 2 && n > 0 && !full) continue;
    memset(&p[n], 0, sizeof p[n]);
    p[n].isa = order[i];
    char config[64] = "threads=1";
    if (order[i] == PKTRT_ISA_AVX2 || order[i] == PKTRT_ISA_SSE2)
      snprintf(config, sizeof config, "threads=1,isa=%s", pktrt_isa_string(order[i]));
    if (order[i] != PKTRT_ISA_SCALAR || n == 0) {
      p[n].device = rtcNewDevice(config);
      if (!p[n].device) fatal("Embree cannot be started");
    }
    n++;
  }
  return n;
}

static bool count_bytes(void *user, ssize_t bytes, bool post) {
  (void)post;
  *(int64_t *)user += (int64_t)bytes;
  return true;
}

static double build_ours(pair *p, const stage *g, const setting *how) {
  pktrt_scene_destroy(p->ours);
  p->ours = stage_scene(g, p->isa, how->high);
  const double start = cpu_seconds();
  if (pktrt_commit(p->ours) != PKTRT_OK) fatal(pktrt_last_error(p->ours));
  return cpu_seconds() - start;
}

/* Embree refits geometries whose quality says so, in scenes of two levels. */
static double build_theirs(pair *p, const stage *g, const setting *how) {
  if (p->theirs) rtcReleaseScene(p->theirs);
  rtcSetDeviceMemoryMonitorFunction(p->device, count_bytes, &p->their_bytes);
  p->theirs = rtcNewScene(p->device);
  rtcSetSceneBuildQuality(p->theirs, how->refit  ? RTC_BUILD_QUALITY_LOW
                                     : how->high ? RTC_BUILD_QUALITY_HIGH
                                                 : RTC_BUILD_QUALITY_MEDIUM);
  rtcSetSceneFlags(p->theirs, how->refit    ? RTC_SCENE_FLAG_DYNAMIC
                              : how->robust ? RTC_SCENE_FLAG_ROBUST
                                            : RTC_SCENE_FLAG_NONE);
  for (size_t m = 0; m < g->s.mesh_count; m++) {
    embree_add(p->device, p->theirs, &g->s.meshes[m]);
    if (!how->refit) continue;
    const RTCGeometry geometry = rtcGetGeometry(p->theirs, (unsigned)m);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_REFIT);
    rtcCommitGeometry(geometry);
  }
  p->their_bytes = 0;
  const double start = cpu_seconds();
  rtcCommitScene(p->theirs);
  const double seconds = cpu_seconds() - start;
  if (rtcGetDeviceError(p->device) != RTC_ERROR_NONE) fatal("Embree reports an error after building");
  return seconds;
}

/* Several times in turns, as everything that is timed; the last ones stay. */
static void build_pairs(pair *pairs, unsigned count, const stage *g, const setting *how, unsigned rounds) {
  for (unsigned r = 0; r < rounds; r++)
    for (unsigned i = 0; i < count; i++) {
      pairs[i].our_time[r] = build_ours(&pairs[i], g, how);
      if (pairs[i].device) pairs[i].their_time[r] = build_theirs(&pairs[i], g, how);
    }
}

static void close_scenes(pair *pairs, unsigned count) {
  for (unsigned i = 0; i < count; i++) {
    pktrt_scene_destroy(pairs[i].ours);
    if (pairs[i].theirs) rtcReleaseScene(pairs[i].theirs);
    pairs[i].ours = NULL, pairs[i].theirs = NULL;
  }
}

/* Whose kernels pair a of ours is compared with: those of its own instruction set, and all narrower ones, which win at
   times; scalar kernels, of which Embree has none, with the narrowest. Instances are compared with instances. */
static bool rivals(const pair *a, const pair *b) {
  return b->device && a->instanced == b->instanced && b->isa <= (a->isa == PKTRT_ISA_SCALAR ? PKTRT_ISA_SSE2 : a->isa);
}

/* >>modes ---------------------------------------------------------------------------------------------------------- */

typedef enum runner { OURS_N, OURS_SOA, OURS_SINGLE, EMBREE } runner;
typedef struct mode {
  const char *name;
  runner run;
  embree_way way;
} mode;

#define PLAIN RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT
#define COHERENT RTC_INTERSECT_CONTEXT_FLAG_COHERENT
enum { SINGLE_OURS = 2, SINGLE_EMBREE = 3, FIRST_EMBREE = 3, MODES = 12 };
static const mode modes[MODES] = {{"_n", OURS_N, {0, false, PLAIN}},
                                  {"_soa", OURS_SOA, {0, false, PLAIN}},
                                  {"single", OURS_SINGLE, {0, false, PLAIN}},
                                  {"single", EMBREE, {1, false, PLAIN}},
                                  {"8", EMBREE, {8, false, PLAIN}},
                                  {"8 coherent", EMBREE, {8, false, COHERENT}},
                                  {"16", EMBREE, {16, false, PLAIN}},
                                  {"16 coherent", EMBREE, {16, false, COHERENT}},
                                  {"stream", EMBREE, {1, true, PLAIN}},
                                  {"stream coherent", EMBREE, {1, true, COHERENT}},
                                  {"arrays", EMBREE, {EMBREE_ARRAYS, true, PLAIN}},
                                  {"arrays coherent", EMBREE, {EMBREE_ARRAYS, true, COHERENT}}};

typedef struct job { /* one kind of rays and room for all answers */
  ray_set r;
  bool occlusion;
  pktrt_hit *hit;
  bool *occluded;
  pktrt_hits soa;
  embree_word *embree;
  float *answer[MAX_PAIRS][MODES]; /* of the first round */
} job;

static void job_room(job *j, size_t most, unsigned pairs) {
  memset(j, 0, sizeof *j);
  j->r = rays_room(most);
  j->hit = (pktrt_hit *)take(most, sizeof(pktrt_hit));
  j->occluded = (bool *)take(most, sizeof(bool));
  j->soa.t = (float *)take(most, sizeof(float));
  j->soa.u = (float *)take(most, sizeof(float));
  j->soa.v = (float *)take(most, sizeof(float));
  for (int a = 0; a < 3; a++) j->soa.normal[a] = (float *)take(most, sizeof(float));
  j->soa.mesh = (uint32_t *)take(most, sizeof(uint32_t));
  j->soa.triangle = (uint32_t *)take(most, sizeof(uint32_t));
  j->embree = (embree_word *)take(most + 16, EMBREE_RAY_HIT_WORDS * sizeof(embree_word));
  for (unsigned p = 0; p < pairs; p++)
    for (int m = 0; m < MODES; m++) j->answer[p][m] = (float *)take(most, sizeof(float));
}

static void job_free(job *j) {
  rays_free(&j->r);
  free(j->hit), free(j->occluded), free(j->embree);
  free(j->soa.t), free(j->soa.u), free(j->soa.v);
  for (int a = 0; a < 3; a++) free(j->soa.normal[a]);
  free(j->soa.mesh), free(j->soa.triangle);
  for (int p = 0; p < MAX_PAIRS; p++)
    for (int m = 0; m < MODES; m++) free(j->answer[p][m]);
}

static embree_rays theirs_of(const job *j) {
  embree_rays r;
  r.ray = j->r.ray, r.count = j->r.count, r.occlusion = j->occlusion, r.words = j->embree;
  return r;
}

static void run_ours(const pktrt_scene *s, runner run, const job *j) {
  const ray_set *r = &j->r;
  if (run == OURS_N && j->occlusion) {
    pktrt_occluded_n(s, r->ray, j->occluded, r->count);
  } else if (run == OURS_N) {
    pktrt_intersect_n(s, r->ray, j->hit, r->count);
  } else if (run == OURS_SOA) {
    pktrt_rays soa;
    for (int a = 0; a < 3; a++) soa.origin[a] = r->array[a], soa.direction[a] = r->array[3 + a];
    soa.tmin = r->array[6], soa.tmax = r->array[7], soa.time = r->array[8];
    if (j->occlusion) pktrt_occluded_soa(s, &soa, j->occluded, r->count);
    else pktrt_intersect_soa(s, &soa, &j->soa, r->count);
  } else {
    for (size_t i = 0; i < r->count; i++)
      if (j->occlusion) j->occluded[i] = pktrt_occluded(s, &r->ray[i]);
      else pktrt_intersect(s, &r->ray[i], &j->hit[i]);
  }
}

/* The answer for ray i as one number: its t, 0 if only occlusion was asked; infinity on a miss. */
static float answer_of(const job *j, const mode *m, size_t i) {
  if (m->run == EMBREE) {
    const embree_rays r = theirs_of(j);
    return embree_answer(&r, m->way.width, i);
  }
  if (j->occlusion) return j->occluded[i] ? 0.0f : INFINITY;
  if (m->run == OURS_SOA) return j->soa.mesh[i] == PKTRT_NONE ? INFINITY : j->soa.t[i];
  return j->hit[i].mesh == PKTRT_NONE ? INFINITY : j->hit[i].t;
}

/* >>measuring ------------------------------------------------------------------------------------------------------ */

typedef struct figure { /* of one mode */
  double seconds[MAX_ROUNDS], best, median;
  unsigned rounds;
  size_t disagree, band, theirs_wrong, ours_wrong, judged, caught;
} figure;
typedef figure figures[MAX_PAIRS][MODES];

static double run_timed(const pair *p, const mode *m, const job *j) {
  const embree_rays r = theirs_of(j);
  if (m->run == EMBREE) embree_fill(&r, m->way.width);
  const double start = cpu_seconds();
  if (m->run == EMBREE) embree_trace(p->theirs, &m->way, &r);
  else run_ours(p->ours, m->run, j);
  return cpu_seconds() - start;
}

/* Embree 3.13 with AVX-512 does not come back from coherent packets of 16 rays and streams that ask instances at rest
   for occlusion; where things move it does, and is not the fastest. */
static bool exists(const pair *p, int m, bool occlusion) {
  const embree_way *way = &modes[m].way;
  const bool narrow = p->isa != PKTRT_ISA_AVX512 || way->width == 8;
  const bool stuck = p->instanced && occlusion && way->flags == COHERENT && !narrow;
  return modes[m].run != EMBREE || (p->device && !stuck);
}

static void first_round(const pair *pairs, unsigned count, job *j, figures f) {
  for (unsigned p = 0; p < count; p++)
    for (int m = 0; m < MODES; m++) {
      memset(&f[p][m], 0, sizeof f[p][m]);
      f[p][m].best = HUGE_VAL;
      if (!exists(&pairs[p], m, j->occlusion)) continue;
      f[p][m].best = f[p][m].median = run_timed(&pairs[p], &modes[m], j);
      for (size_t i = 0; i < j->r.count; i++) j->answer[p][m][i] = answer_of(j, &modes[m], i);
    }
}

/* Embree's modes that fall behind those that they compete with are not run again: by the best times after the first
   round, which is not timed, those that took 1.4 times as long, then 1.2, then 1.1 times. Single calls compete with
   single calls, since these are compared apart. */
static bool behind(const pair *pairs, unsigned count, figures f, unsigned p, int m, unsigned round) {
  double best = HUGE_VAL;
  for (unsigned q = 0; q < count; q++)
    for (int k = FIRST_EMBREE; k < MODES && rivals(&pairs[p], &pairs[q]); k++)
      if (m != SINGLE_EMBREE || k == SINGLE_EMBREE) best = fmin(best, f[q][k].best);
  return m >= FIRST_EMBREE && f[p][m].best > best * (round == 0 ? 1.4 : round == 1 ? 1.2 : 1.1);
}

static void run_round(const pair *pairs, unsigned count, job *j, unsigned round, bool all_modes, figures f) {
  static bool out[MAX_PAIRS][MODES];
  for (unsigned p = 0; p < count; p++)
    for (int m = 0; m < MODES; m++) {
      if (round == 0) out[p][m] = !exists(&pairs[p], m, j->occlusion);
      out[p][m] = out[p][m] || (!all_modes && behind(pairs, count, f, p, m, round));
    }
  for (unsigned k = 0; k < count * MODES; k++) {
    const unsigned turn = (k + round * 5) % (count * MODES); /* so that nobody always runs after the same one */
    const unsigned p = turn / MODES, m = turn % MODES;
    figure *g = &f[p][m];
    if (out[p][m]) continue;
    g->seconds[g->rounds] = run_timed(&pairs[p], &modes[m], j);
    g->best = fmin(g->best, g->seconds[g->rounds++]);
  }
}

static void measure(const pair *pairs, unsigned count, job *j, const options *o, figures f) {
  first_round(pairs, count, j, f);
  for (unsigned r = 0; r < o->rounds; r++) run_round(pairs, count, j, r, o->all_modes, f);
  for (unsigned p = 0; p < count; p++)
    for (int m = 0; m < MODES; m++) {
      figure *g = &f[p][m];
      if (!g->rounds) continue;
      g->median = median_of(g->seconds, g->rounds);
      g->best = g->seconds[0]; /* sorted now */
    }
}

/* >>hits ----------------------------------------------------------------------------------------------------------- */

/* slack: what t may be off by where it is small. */
static bool agree(float a, float b, double slack) {
  return isinf(a) || isinf(b) ? isinf(a) && isinf(b) : fabs((double)a - (double)b) <= TOLERANCE * (double)b + slack;
}

static double largest_coordinate(const stage *g, const job *j) {
  double far = 0;
  for (size_t m = 0; m < g->s.mesh_count; m++)
    for (size_t i = 0; i < (size_t)g->s.meshes[m].vertex_count * g->s.meshes[m].key_count * 3; i++)
      far = fmax(far, fabs((double)g->s.meshes[m].positions[i]));
  for (size_t i = 0; i < j->r.count; i++)
    for (int a = 0; a < 3; a++) far = fmax(far, fabs((double)j->r.ray[i].origin[a]));
  return far;
}

/* An answer that is wrong unless the oracle says nothing: a hit a little off, or none where there is one, or one where
   there is none. */
static float false_answer(bool occlusion, float answer) {
  return isinf(answer) ? (occlusion ? 0.0f : 1.0f) : occlusion ? INFINITY : 1.01f * answer;
}

/* Counts, for each of Embree's modes, where it and pktrt disagree, and who is wrong; of the rays that none disagrees on
   a few are judged too. As a control, a false answer for each of these must be caught, where only one is possible. */
static void compare_hits(const stage *g, const pair *pairs, unsigned count, const job *j, figures f) {
  enum { OTHERS = 32 };
  const double far = largest_coordinate(g, j), slack = SLACK * g->diagonal;
  const size_t step = j->r.count / OTHERS + 1;
  const float *ours = j->answer[0][0];
  static truth t;
  for (size_t i = 0; i < j->r.count; i++) {
    bool judged = i % step == 0;
    for (unsigned p = 0; p < count; p++)
      for (int m = FIRST_EMBREE; m < MODES; m++)
        judged = judged || (exists(&pairs[p], m, j->occlusion) && !agree(j->answer[p][m][i], ours[i], slack));
    if (!judged) continue;
    find_truth(&g->s, pairs->instanced, far, &j->r.ray[i], &t);
    const bool we_can = possible(&t, j->occlusion, ours[i], 0, 0);
    const bool lie = possible(&t, j->occlusion, false_answer(j->occlusion, ours[i]), 0, 0);
    for (unsigned p = 0; p < count; p++)
      for (int m = FIRST_EMBREE; m < MODES; m++) {
        if (!exists(&pairs[p], m, j->occlusion)) continue;
        const float theirs = j->answer[p][m][i];
        const bool same = agree(theirs, ours[i], slack),
                   they_can = possible(&t, j->occlusion, theirs, TOLERANCE, slack);
        f[p][m].judged++, f[p][m].caught += !lie;
        f[p][m].disagree += !same, f[p][m].ours_wrong += !we_can;
        f[p][m].theirs_wrong += !they_can, f[p][m].band += !same && we_can && they_can;
      }
  }
}

/* Our answers must not differ by a bit, whatever the mode and the instruction set. Returns how many do. */
static size_t contradictions(unsigned count, const job *j) {
  size_t n = 0;
  for (unsigned p = 0; p < count; p++)
    for (int m = 0; m < FIRST_EMBREE; m++)
      for (size_t i = 0; i < j->r.count; i++) n += memcmp(&j->answer[p][m][i], &j->answer[0][0][i], sizeof(float)) != 0;
  return n;
}

/* >>figures -------------------------------------------------------------------------------------------------------- */

/* Embree's fastest of the modes first to last against pair p, by the median, of those that ran in all rounds, as ours
   did; *of: whose it is. */
static const figure *embree_best(figures f, const pair *pairs, unsigned p, unsigned count, int first, int last,
                                 unsigned *of) {
  const figure *best = NULL;
  for (unsigned q = 0; q < count; q++)
    for (int m = first; m <= last && rivals(&pairs[p], &pairs[q]); m++)
      if (f[q][m].rounds == f[p][0].rounds && (!best || f[q][m].median < best->median))
        best = &f[q][m], *of = q * MODES + (unsigned)m;
  return best;
}

static row *ratio_row(report *to, const stage *g, const setting *how, const pair *p, const char *what, const char *of,
                      double median, double best) {
  row *r = add_row(to, g, how->name, pktrt_isa_string(p->isa), what, "ratio", of, "");
  r->median = median, r->best = best;
  return r;
}

static void add_modes(report *to, const stage *g, const setting *how, const pair *p, const char *what, size_t rays_run,
                      figure f[MODES]) {
  for (int m = 0; m < MODES; m++) {
    if (isinf(f[m].best)) continue;
    row *r = add_row(to, g, how->name, pktrt_isa_string(p->isa), what, m < FIRST_EMBREE ? "pktrt" : "Embree",
                     modes[m].name, "Mrays/s");
    r->rays = rays_run, r->rounds = f[m].rounds;
    r->median = 1e-6 * (double)rays_run / f[m].median, r->best = 1e-6 * (double)rays_run / f[m].best;
    r->disagree = f[m].disagree, r->band = f[m].band;
    r->theirs_wrong = f[m].theirs_wrong, r->ours_wrong = f[m].ours_wrong;
  }
}

/* All of one kind and pair: rows, and a line for who is watching. */
static void add_figures(report *to, const stage *g, const setting *how, const pair *pairs, unsigned p, unsigned count,
                        kind k, size_t n, figures f) {
  unsigned at = 0, single_at = 0;
  const char *what = kind_names[k];
  add_modes(to, g, how, &pairs[p], what, n, f[p]);
  const figure *e = embree_best(f, pairs, p, count, FIRST_EMBREE, MODES - 1, &at);
  const figure *s = embree_best(f, pairs, p, count, SINGLE_EMBREE, SINGLE_EMBREE, &single_at);
  if (!e || !s) return;
  const figure *ours = f[p][0].median < f[p][1].median ? &f[p][0] : &f[p][1], *single = &f[p][SINGLE_OURS];
  ratio_row(to, g, how, &pairs[p], what, "many", e->median / ours->median, e->best / ours->best);
  ratio_row(to, g, how, &pairs[p], what, "single", s->median / single->median, s->best / single->best);
  ratio_row(to, g, how, &pairs[p], what, "_n/_soa", f[p][1].median / f[p][0].median, f[p][1].best / f[p][0].best);
  row *hits = ratio_row(to, g, how, &pairs[p], what, "hits", (double)e->disagree / (double)n, 0);
  hits->rays = n, hits->disagree = e->disagree, hits->band = e->band;
  hits->theirs_wrong = e->theirs_wrong, hits->ours_wrong = e->ours_wrong;
  hits->judged = e->judged, hits->caught = e->caught;
  const double mega = 1e-6 * (double)n;
  char name[40];
  snprintf(name, sizeof name, "%s %s", modes[at % MODES].name, pktrt_isa_string(pairs[at / MODES].isa));
  printf("  %-18s %-6s %7zu | %6.2f %-22s | _n %6.2f  _soa %6.2f  %5.2f (%5.2f) | single %5.2f %5.2f  %5.2f | %zu\n",
         what, pktrt_isa_string(pairs[p].isa), n, mega / e->median, name, mega / f[p][0].median, mega / f[p][1].median,
         e->median / ours->median, e->best / ours->best, mega / s->median, mega / single->median,
         s->median / single->median, e->disagree);
  fflush(stdout);
}

#endif /* PEERS_RACE_H */
