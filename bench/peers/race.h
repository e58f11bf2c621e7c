/* race.h - part of peers.c: both libraries with a stage built, and their ways to trace rays, in turns.

   Contents: pairs, modes, measuring, hits, figures. */
#ifndef PEERS_RACE_H
#define PEERS_RACE_H

#include "rays.h"
#include "report.h"
#include "scenes.h"
#include "truth.h"
#include "../embree.h"
#include "../fresh.h"

enum { MAX_ROUNDS = 64 };

typedef struct options {
  view_options view;
  const char *results;                /* a directory, NULL: none */
  unsigned size, moving_size, rounds; /* N x N primary rays: of what is at rest, and of what moves */
  unsigned kinds, settings;           /* bits; no setting: those of the headline set, or all */
  bool full, all_modes, plain_only;   /* plain_only: without Embree's robust modes */
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
  RTCDevice device;                                    /* NULL: Embree has none so narrow */
  RTCScene theirs, robust;                             /* robust NULL: is not raced */
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
static RTCScene open_theirs(RTCDevice device, const stage *g, const setting *how, enum RTCSceneFlags flags) {
  const RTCScene s = rtcNewScene(device);
  rtcSetSceneBuildQuality(s, how->refit  ? RTC_BUILD_QUALITY_LOW
                             : how->high ? RTC_BUILD_QUALITY_HIGH
                                         : RTC_BUILD_QUALITY_MEDIUM);
  rtcSetSceneFlags(s, how->refit ? RTC_SCENE_FLAG_DYNAMIC : flags);
  for (size_t m = 0; m < g->s.mesh_count; m++) {
    embree_add(device, s, &g->s.meshes[m]);
    if (!how->refit) continue;
    const RTCGeometry geometry = rtcGetGeometry(s, (unsigned)m);
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_REFIT);
    rtcCommitGeometry(geometry);
  }
  return s;
}

static double build_theirs(pair *p, const stage *g, const setting *how) {
  if (p->theirs) rtcReleaseScene(p->theirs);
  rtcSetDeviceMemoryMonitorFunction(p->device, count_bytes, &p->their_bytes);
  p->theirs = open_theirs(p->device, g, how, RTC_SCENE_FLAG_NONE);
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

/* Gives Embree's robust modes, which race beside the others, a scene of their own: built once, untimed, and after the
   bytes of the others have been read. */
static void build_robust(pair *pairs, unsigned count, const stage *g, const setting *how) {
  for (unsigned i = 0; i < count; i++) {
    if (!pairs[i].device) continue;
    pairs[i].robust = open_theirs(pairs[i].device, g, how, RTC_SCENE_FLAG_ROBUST);
    rtcCommitScene(pairs[i].robust);
    if (rtcGetDeviceError(pairs[i].device) != RTC_ERROR_NONE) fatal("Embree reports an error after a robust build");
  }
}

static void close_scenes(pair *pairs, unsigned count) {
  for (unsigned i = 0; i < count; i++) {
    pktrt_scene_destroy(pairs[i].ours);
    if (pairs[i].theirs) rtcReleaseScene(pairs[i].theirs);
    if (pairs[i].robust) rtcReleaseScene(pairs[i].robust);
    pairs[i].ours = NULL, pairs[i].theirs = pairs[i].robust = NULL;
  }
}

/* Whose kernels pair a of ours is compared with: those of its own instruction set, and all narrower ones, which win at
   times; scalar kernels, of which Embree has none, with the narrowest. Instances are compared with instances. */
static bool rivals(const pair *a, const pair *b) {
  return b->device && a->instanced == b->instanced && b->isa <= (a->isa == PKTRT_ISA_SCALAR ? PKTRT_ISA_SSE2 : a->isa);
}

/* >>modes ---------------------------------------------------------------------------------------------------------- */

typedef enum runner {
  OURS_N,
  OURS_SOA,
  OURS_SINGLE,
  OURS_FRESH,
  EMBREE,
  EMBREE_FRESH
} runner; /* FRESH: see write_ray */
typedef struct mode {
  const char *name;
  runner run;
  embree_way way;
} mode;

#define PLAIN RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT
#define COHERENT RTC_INTERSECT_CONTEXT_FLAG_COHERENT
/* Embree's modes stand twice: as they are, and robust in the same order. Of each the first and the one after the last are
   single calls, of rays that lie in memory and of fresh ones. */
enum {
  SINGLE_OURS = 2,
  FRESH_OURS = 3,
  FIRST_EMBREE = 4,
  FIRST_ROBUST = 14,
  MODES = 24,
  WAYS = FIRST_ROBUST - FIRST_EMBREE - 1 /* but for that of fresh rays */
};
#define EMBREE_MODES(robust) \
  {"single" robust, EMBREE, {1, false, PLAIN}}, {"8" robust, EMBREE, {8, false, PLAIN}}, \
      {"8 coherent" robust, EMBREE, {8, false, COHERENT}}, {"16" robust, EMBREE, {16, false, PLAIN}}, \
      {"16 coherent" robust, EMBREE, {16, false, COHERENT}}, {"stream" robust, EMBREE, {1, true, PLAIN}}, \
      {"stream coherent" robust, EMBREE, {1, true, COHERENT}}, \
      {"arrays" robust, EMBREE, {EMBREE_ARRAYS, true, PLAIN}}, \
      {"arrays coherent" robust, EMBREE, {EMBREE_ARRAYS, true, COHERENT}}, { \
    "fresh" robust, EMBREE_FRESH, { 1, false, PLAIN } \
  }
static const mode modes[MODES] = {{"_n", OURS_N, {0, false, PLAIN}}, {"_soa", OURS_SOA, {0, false, PLAIN}},
    {"single", OURS_SINGLE, {0, false, PLAIN}}, {"fresh", OURS_FRESH, {0, false, PLAIN}}, EMBREE_MODES(""),
    EMBREE_MODES(" robust")};

static bool is_robust(int m) { return m >= FIRST_ROBUST; }
static int first_like(int m) { return is_robust(m) ? FIRST_ROBUST : FIRST_EMBREE; } /* its single calls */
static bool is_single(int m) { return m == first_like(m) || m == first_like(m) + WAYS; }

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

static void run_fresh(const pktrt_scene *s, const job *j, size_t first, size_t end) {
  for (size_t i = first; i < end; i++) {
    pktrt_ray ray;
    write_ray(&j->r.ray[i], &ray);
    if (j->occlusion) j->occluded[i] = pktrt_occluded(s, &ray);
    else pktrt_intersect(s, &ray, &j->hit[i]);
  }
}

static void run_ours(const pktrt_scene *s, runner run, const job *j, size_t first, size_t end) {
  const ray_set *r = &j->r;
  if (run == OURS_N && j->occlusion) {
    pktrt_occluded_n(s, r->ray + first, j->occluded + first, end - first);
  } else if (run == OURS_N) {
    pktrt_intersect_n(s, r->ray + first, j->hit + first, end - first);
  } else if (run == OURS_SOA) {
    pktrt_rays soa;
    pktrt_hits hits = j->soa;
    for (int a = 0; a < 3; a++) {
      soa.origin[a] = r->array[a] + first, soa.direction[a] = r->array[3 + a] + first;
      hits.normal[a] += first;
    }
    soa.tmin = r->array[6] + first, soa.tmax = r->array[7] + first, soa.time = r->array[8] + first;
    hits.t += first, hits.u += first, hits.v += first, hits.mesh += first, hits.triangle += first;
    if (j->occlusion) pktrt_occluded_soa(s, &soa, j->occluded + first, end - first);
    else pktrt_intersect_soa(s, &soa, &hits, end - first);
  } else if (run == OURS_FRESH) {
    run_fresh(s, j, first, end);
  } else {
    for (size_t i = first; i < end; i++)
      if (j->occlusion) j->occluded[i] = pktrt_occluded(s, &r->ray[i]);
      else pktrt_intersect(s, &r->ray[i], &j->hit[i]);
  }
}

/* The answer for ray i as one number: its t, 0 if only occlusion was asked; infinity on a miss. */
static float answer_of(const job *j, const mode *m, size_t i) {
  if (m->run >= EMBREE) {
    const embree_rays r = theirs_of(j);
    return embree_answer(&r, m->way.width, i);
  }
  if (j->occlusion) return j->occluded[i] ? 0.0f : INFINITY;
  if (m->run == OURS_SOA) return j->soa.mesh[i] == PKTRT_NONE ? INFINITY : j->soa.t[i];
  return j->hit[i].mesh == PKTRT_NONE ? INFINITY : j->hit[i].t;
}

/* >>measuring ------------------------------------------------------------------------------------------------------ */

/* Rays are timed by parts. WHY: a machine that others share is slow for a while, and then a part's least time tells what the
   code takes, where a median of rounds tells how the machine was. */
enum { PART = 32 * EMBREE_STREAM, PARTS = 4096 * 4096 / PART };

typedef struct figure { /* of one mode */
  double seconds[MAX_ROUNDS], median;
  double least[PARTS], best; /* of each part, and their sum; before that the best of all rounds */
  unsigned rounds;
  size_t disagree, band, theirs_wrong, ours_wrong, judged, caught;
} figure;
typedef figure figures[MAX_PAIRS][MODES];

/* Returns the seconds of all parts, and lowers the least of each unless that is NULL. */
static double run_timed(const pair *p, int which, const job *j, double *least) {
  const embree_rays r = theirs_of(j);
  const mode *m = &modes[which];
  double sum = 0;
  if (m->run == EMBREE) embree_fill(&r, m->way.width);
  for (size_t i = 0; i < r.count; i += PART) {
    const size_t end = r.count - i < PART ? r.count : i + PART;
    const double start = cpu_seconds();
    if (m->run == EMBREE) embree_trace(is_robust(which) ? p->robust : p->theirs, &m->way, &r, i, end);
    else if (m->run == EMBREE_FRESH) embree_trace_fresh(is_robust(which) ? p->robust : p->theirs, &r, i, end);
    else run_ours(p->ours, m->run, j, i, end);
    const double seconds = cpu_seconds() - start;
    sum += seconds;
    if (least) least[i / PART] = fmin(least[i / PART], seconds);
  }
  return sum;
}

/* Embree 3.13 with AVX-512 does not come back from coherent packets of 16 rays and streams that ask instances at rest
   for occlusion; where things move it does, and is not the fastest. */
static bool exists(const pair *p, int m, bool occlusion) {
  const embree_way *way = &modes[m].way;
  const bool narrow = p->isa != PKTRT_ISA_AVX512 || way->width == 8;
  const bool stuck = p->instanced && occlusion && way->flags == COHERENT && !narrow;
  return modes[m].run < EMBREE || (p->device && !stuck && (!is_robust(m) || p->robust));
}

static bool has_run(const figure *f) { return !isinf(f->best); } /* in the first round */

/* Seconds that a mode of Embree's takes for runs of rays from all over the set, an eighth of them. */
static double time_some(const pair *p, int m, const job *j) {
  enum { RUN = 4096, STEP = 8 * RUN };
  job part = *j;
  double seconds = 0;
  for (size_t i = 0; i < j->r.count; i += STEP) {
    part.r.ray = j->r.ray + i, part.r.count = j->r.count - i < RUN ? j->r.count - i : RUN;
    seconds += run_timed(p, m, &part, NULL);
  }
  return seconds;
}

/* Whether mode m is among so many of the fastest of Embree's that are robust as it is; single calls always are, since
   they are compared apart. */
static bool among_fastest(const double seconds[MODES], int m, int most) {
  const int first = first_like(m);
  int faster = 0;
  for (int k = first; k < first + WAYS; k++) faster += seconds[k] < seconds[m];
  return is_single(m) || faster < most;
}

/* Tells which modes of a pair are worth all rays: all of ours, and the fastest of Embree's for some of them. */
static void look_ahead(const pair *p, const job *j, bool all_modes, bool worth[MODES]) {
  double seconds[MODES];
  for (int m = 0; m < MODES; m++) {
    worth[m] = exists(p, m, j->occlusion), seconds[m] = HUGE_VAL;
    if (worth[m] && m >= FIRST_EMBREE && !all_modes) seconds[m] = time_some(p, m, j);
  }
  for (int m = FIRST_EMBREE; m < MODES && !all_modes; m++)
    worth[m] = worth[m] && among_fastest(seconds, m, is_robust(m) ? 3 : 4);
}

static void first_round(const pair *pairs, unsigned count, job *j, bool all_modes, figures f) {
  for (unsigned p = 0; p < count; p++) {
    bool worth[MODES];
    look_ahead(&pairs[p], j, all_modes, worth);
    for (int m = 0; m < MODES; m++) {
      memset(&f[p][m], 0, sizeof f[p][m]);
      f[p][m].best = HUGE_VAL;
      for (int i = 0; i < PARTS; i++) f[p][m].least[i] = HUGE_VAL;
      if (!worth[m]) continue;
      f[p][m].best = f[p][m].median = run_timed(&pairs[p], m, j, NULL);
      for (size_t i = 0; i < j->r.count; i++) j->answer[p][m][i] = answer_of(j, &modes[m], i);
    }
  }
}

/* Embree's modes that fall behind those that they compete with are not run again: by the best times after the first
   round, which is not timed, those that took 1.4 times as long, then 1.2, then 1.1 times, and those of a pair that three
   others (robust ones: two) are faster than. Single calls compete with single calls, and robust modes with robust ones,
   since these are compared apart. */
static bool behind(const pair *pairs, unsigned count, figures f, unsigned p, int m, unsigned round) {
  double best = HUGE_VAL, own[MODES];
  if (m < FIRST_EMBREE) return false;
  for (int k = 0; k < MODES; k++) own[k] = f[p][k].best;
  for (unsigned q = 0; q < count; q++)
    for (int i = 0; i < WAYS && rivals(&pairs[p], &pairs[q]); i++)
      best = fmin(best, f[q][is_single(m) ? m : first_like(m) + i].best);
  return own[m] > best * (round == 0 ? 1.4 : round == 1 ? 1.2 : 1.1) || !among_fastest(own, m, is_robust(m) ? 2 : 3);
}

static void run_round(const pair *pairs, unsigned count, job *j, unsigned round, bool all_modes, figures f) {
  static bool out[MAX_PAIRS][MODES];
  for (unsigned p = 0; p < count; p++)
    for (int m = 0; m < MODES; m++) {
      if (round == 0) out[p][m] = !has_run(&f[p][m]);
      out[p][m] = out[p][m] || (!all_modes && behind(pairs, count, f, p, m, round));
    }
  for (unsigned k = 0; k < count * MODES; k++) {
    const unsigned turn = (k + round * 5) % (count * MODES); /* so that nobody always runs after the same one */
    const unsigned p = turn / MODES;
    const int m = (int)(turn % MODES);
    figure *g = &f[p][m];
    if (out[p][m]) continue;
    g->seconds[g->rounds] = run_timed(&pairs[p], m, j, g->least);
    g->best = fmin(g->best, g->seconds[g->rounds++]);
  }
}

static void measure(const pair *pairs, unsigned count, job *j, const options *o, figures f) {
  first_round(pairs, count, j, o->all_modes, f);
  for (unsigned r = 0; r < o->rounds; r++) run_round(pairs, count, j, r, o->all_modes, f);
  for (unsigned p = 0; p < count; p++)
    for (int m = 0; m < MODES; m++) {
      figure *g = &f[p][m];
      if (!g->rounds) continue;
      g->median = median_of(g->seconds, g->rounds);
      g->best = 0;
      for (size_t i = 0; i * PART < j->r.count; i++) g->best += g->least[i];
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
        judged = judged || (has_run(&f[p][m]) && !agree(j->answer[p][m][i], ours[i], slack));
    if (!judged) continue;
    find_truth(&g->s, pairs->instanced, far, &j->r.ray[i], &t);
    const bool we_can = possible(&t, j->occlusion, ours[i], 0, 0);
    const bool lie = possible(&t, j->occlusion, false_answer(j->occlusion, ours[i]), 0, 0);
    for (unsigned p = 0; p < count; p++)
      for (int m = FIRST_EMBREE; m < MODES; m++) {
        if (!has_run(&f[p][m])) continue;
        const float theirs = j->answer[p][m][i];
        const bool same = agree(theirs, ours[i], slack),
                   they_can = possible(&t, j->occlusion, theirs, TOLERANCE, slack);
        f[p][m].judged++, f[p][m].caught += !lie;
        f[p][m].disagree += !same, f[p][m].ours_wrong += !we_can;
        f[p][m].theirs_wrong += !they_can, f[p][m].band += !same && we_can && they_can;
      }
  }
}

/* Returns how many of our answers differ, by a bit or more, from those of the first mode of the first pair. */
static size_t differing_answers(unsigned count, const job *j) {
  size_t n = 0;
  for (unsigned p = 0; p < count; p++)
    for (int m = 0; m < FIRST_EMBREE; m++)
      for (size_t i = 0; i < j->r.count; i++) n += memcmp(&j->answer[p][m][i], &j->answer[0][0][i], sizeof(float)) != 0;
  return n;
}

/* Our answers must not differ by a bit, whatever the mode and the instruction set. Returns how many do. As a control, the
   last answer gets another bit, which must be noticed. */
static size_t contradictions(unsigned count, const job *j) {
  const size_t differ = differing_answers(count, j);
  float *last = &j->answer[count - 1][FIRST_EMBREE - 1][j->r.count - 1];
  const float kept = *last;

  const bool same = memcmp(last, &j->answer[0][0][j->r.count - 1], sizeof *last) == 0;
  uint32_t bits;
  memcpy(&bits, last, sizeof bits);
  bits ^= 1;
  memcpy(last, &bits, sizeof bits);
  const bool noticed = differing_answers(count, j) != differ;
  *last = kept;

  if (same && !noticed) {
    printf("peers: control: an answer with another bit is not noticed\n");
    exit(1);
  }
  return differ;
}

/* >>figures -------------------------------------------------------------------------------------------------------- */

/* Embree's fastest of some modes, from the first, against pair p, by their best, of those that ran in all rounds, as ours
   did; *of: whose it is. */
static const figure *embree_best(
    figures f, const pair *pairs, unsigned p, unsigned count, int first, int some, unsigned *of) {
  const figure *best = NULL;
  for (unsigned q = 0; q < count; q++)
    for (int m = first; m < first + some && rivals(&pairs[p], &pairs[q]); m++)
      if (f[q][m].rounds == f[p][0].rounds && (!best || f[q][m].best < best->best))
        best = &f[q][m], *of = q * MODES + (unsigned)m;
  return best;
}

static row *ratio_row(report *to, const stage *g, const setting *how, const pair *p, const char *what, const char *of,
    double median, double best) {
  row *r = add_row(to, g, how->name, pktrt_isa_string(p->isa), what, "ratio", of, "");
  r->median = median, r->best = best;
  return r;
}

static void add_modes(
    report *to, const stage *g, const setting *how, const pair *p, const char *what, size_t rays_run, figure f[MODES]) {
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

/* Rays that Embree's mode e disagrees on, of n. */
static void add_hits(report *to, const stage *g, const setting *how, const pair *p, const char *what, const char *of,
    const figure *e, size_t n) {
  row *hits = ratio_row(to, g, how, p, what, of, (double)e->disagree / (double)n, 0);
  hits->rays = n, hits->disagree = e->disagree, hits->band = e->band;
  hits->theirs_wrong = e->theirs_wrong, hits->ours_wrong = e->ours_wrong;
  hits->judged = e->judged, hits->caught = e->caught;
}

typedef struct
    rivalry { /* Embree's fastest modes against a pair: of all, whose it is, and of single calls, also of fresh rays; and ratios */
  const figure *many, *single, *fresh;
  unsigned at;
  double ratio, single_ratio, fresh_ratio; /* by the best */
} rivalry;

/* The rows of Embree's plain modes, or of its robust ones: false, and none, if these were not raced. */
static bool add_ratios(report *to, const stage *g, const setting *how, const pair *pairs, unsigned p, unsigned count,
    const char *what, size_t n, bool robust, figures f, rivalry *r) {
  const int first = robust ? FIRST_ROBUST : FIRST_EMBREE;
  unsigned at = 0;
  r->many = embree_best(f, pairs, p, count, first, WAYS, &r->at);
  r->single = embree_best(f, pairs, p, count, first, 1, &at);
  r->fresh = embree_best(f, pairs, p, count, first + WAYS, 1, &at);
  if (!r->many || !r->single || !r->fresh) return false;
  const figure *ours = f[p][0].best < f[p][1].best ? &f[p][0] : &f[p][1], *single = &f[p][SINGLE_OURS],
               *fresh = &f[p][FRESH_OURS];
  r->ratio = r->many->best / ours->best, r->single_ratio = r->single->best / single->best;
  r->fresh_ratio = r->fresh->best / fresh->best;
  ratio_row(to, g, how, &pairs[p], what, robust ? "many robust" : "many", r->many->median / ours->median, r->ratio);
  ratio_row(to, g, how, &pairs[p], what, robust ? "single robust" : "single", r->single->median / single->median,
      r->single_ratio);
  ratio_row(
      to, g, how, &pairs[p], what, robust ? "fresh robust" : "fresh", r->fresh->median / fresh->median, r->fresh_ratio);
  add_hits(to, g, how, &pairs[p], what, robust ? "hits robust" : "hits", r->many, n);
  return true;
}

/* All of one kind and pair: rows, and a line for who is watching. */
static void add_figures(report *to, const stage *g, const setting *how, const pair *pairs, unsigned p, unsigned count,
    kind k, size_t n, figures f) {
  const char *what = kind_names[k], *isa = pktrt_isa_string(pairs[p].isa);
  const double mega = 1e-6 * (double)n;
  rivalry plain, robust;
  char name[40];
  add_modes(to, g, how, &pairs[p], what, n, f[p]);
  if (!add_ratios(to, g, how, pairs, p, count, what, n, false, f, &plain)) return;
  ratio_row(to, g, how, &pairs[p], what, "_n/_soa", f[p][1].median / f[p][0].median, f[p][1].best / f[p][0].best);
  snprintf(name, sizeof name, "%s %s", modes[plain.at % MODES].name, pktrt_isa_string(pairs[plain.at / MODES].isa));
  printf(
      "  %-18s %-6s %7zu | %6.2f %-22s | _n %6.2f  _soa %6.2f  %5.2f | single %5.2f %5.2f  %5.2f, fresh %5.2f | %zu\n",
      what, isa, n, mega / plain.many->best, name, mega / f[p][0].best, mega / f[p][1].best, plain.ratio,
      mega / plain.single->best, mega / f[p][SINGLE_OURS].best, plain.single_ratio, plain.fresh_ratio,
      plain.many->disagree);
  if (add_ratios(to, g, how, pairs, p, count, what, n, true, f, &robust)) {
    snprintf(name, sizeof name, "%s %s", modes[robust.at % MODES].name, pktrt_isa_string(pairs[robust.at / MODES].isa));
    printf("  %-18s %-6s         | %6.2f %-29s                 %5.2f | single %5.2f        %5.2f, fresh %5.2f | %zu\n",
        what, isa, mega / robust.many->best, name, robust.ratio, mega / robust.single->best, robust.single_ratio,
        robust.fresh_ratio, robust.many->disagree);
  }
  fflush(stdout);
}

#endif /* PEERS_RACE_H */
