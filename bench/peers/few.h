/* few.h - part of peers.c: single calls on 16 triangles, where most of the time is what a call costs in itself.

   Contents: rays, measuring, table. */
#ifndef PEERS_FEW_H
#define PEERS_FEW_H

#include "race.h"

/* >>rays ----------------------------------------------------------------------------------------------------------- */

/* A double pyramid over an octagon. */
static void open_few(stage *g) {
  memset(g, 0, sizeof *g);
  stage_room(&g->s, 1);
  scene_mesh *m = g->s.meshes;
  mesh_room(m, 10, 16);
  for (uint32_t i = 0; i < 8; i++) {
    const double angle = 45 * (double)i;
    const float corner[3] = {(float)sc_cos(angle), 0, (float)sc_sin(angle)};
    memcpy(m->positions + 3 * i, corner, sizeof corner);
  }
  const float tips[6] = {0, 1, 0, 0, -1, 0};
  memcpy(m->positions + 24, tips, sizeof tips);
  for (uint32_t i = 0; i < 16; i++) {
    const uint32_t triangle[3] = {i % 8, (i + 1) % 8, 8 + i / 8};
    memcpy(m->indices + 3 * i, triangle, sizeof triangle);
  }
  stage_finish(g, "few triangles", BUILT_IN);
}

/* Rays from one side, in no order, of which all or none hit. */
static void make_few(const pktrt_scene *world, bool hits, ray_set *out) {
  enum { COUNT = PART };
  out->count = 0;
  for (uint32_t i = 0; out->count < COUNT; i++) {
    pktrt_ray *r = &out->ray[out->count];
    pktrt_hit hit;
    memset(r, 0, sizeof *r);
    for (unsigned a = 0; a < 3; a++) {
      r->origin[a] = a == 2 ? -4 : 4 * uniform(i, a) - 2;
      r->direction[a] = 3 * uniform(i, 3 + a) - 1.5f - r->origin[a];
    }
    r->tmax = INFINITY;
    out->count += pktrt_intersect(world, r, &hit) == hits;
  }
}

/* >>measuring ------------------------------------------------------------------------------------------------------ */

enum { FEW_ROUNDS = MAX_ROUNDS };

/* Times one way of asking, by pair p and by its fastest rival: nanoseconds for a ray, and their quotient. */
static void add_few_figures(report *to, const stage *g, const pair *pairs, unsigned p, unsigned count, const char *what,
    const job *j, int ours, int theirs, double best[MAX_PAIRS][MODES]) {
  static const setting how = {FEW, 0, 0, false, false, false};
  const double nano = 1e9 / (double)j->r.count;
  double rival = HUGE_VAL;
  for (unsigned q = 0; q < count; q++)
    if (rivals(&pairs[p], &pairs[q])) rival = fmin(rival, best[q][theirs]);
  const char *isa = pktrt_isa_string(pairs[p].isa), *calls = modes[ours].name;
  row *r = add_row(to, g, how.name, isa, what, "pktrt", calls, "ns");
  r->median = r->best = nano * best[p][ours];
  r = add_row(to, g, how.name, isa, what, "Embree", calls, "ns");
  r->median = r->best = nano * rival;
  r = ratio_row(to, g, &how, &pairs[p], what, calls, best[p][ours] / rival, best[p][ours] / rival);
  r->rays = j->r.count, r->rounds = FEW_ROUNDS;
  printf("  few triangles, %s: a %s, %s: %.1f ns, Embree %.1f: %.2f\n", isa, what, calls, nano * best[p][ours],
      nano * rival, best[p][ours] / rival);
}

static void time_few(const pair *pairs, unsigned count, const job *j, const int *which, double best[MAX_PAIRS][MODES]) {
  for (unsigned p = 0; p < MAX_PAIRS; p++)
    for (int m = 0; m < MODES; m++) best[p][m] = HUGE_VAL;
  for (unsigned round = 0; round < FEW_ROUNDS; round++)
    for (unsigned p = 0; p < count; p++)
      for (int i = 0; i < 4; i++) {
        const int m = which[i];
        if (exists(&pairs[p], m, j->occlusion)) best[p][m] = fmin(best[p][m], run_timed(&pairs[p], m, j, NULL));
      }
}

/* The closest hits of rays that all hit, and that all miss; stored and fresh ones. */
static void add_few(report *to, const pair *from, unsigned count) {
  static const int which[4] = {SINGLE_OURS, FRESH_OURS, FIRST_EMBREE, FIRST_EMBREE + WAYS};
  static const setting rest = {FEW, 0, 0, false, false, false};
  pair pairs[MAX_PAIRS];
  double best[MAX_PAIRS][MODES];
  stage g;
  job j;
  open_few(&g);
  memcpy(pairs, from, sizeof pairs);
  for (unsigned p = 0; p < count; p++) {
    pairs[p].ours = NULL, pairs[p].theirs = pairs[p].robust = NULL;
    (void)build_ours(&pairs[p], &g, &rest);
    if (pairs[p].device) (void)build_theirs(&pairs[p], &g, &rest);
  }
  job_room(&j, PART, count);
  for (int hits = 0; hits < 2; hits++) {
    make_few(pairs[0].ours, hits, &j.r);
    time_few(pairs, count, &j, which, best);
    for (unsigned p = 0; p < count; p++)
      for (int i = 0; i < 2; i++)
        add_few_figures(to, &g, pairs, p, count, hits ? "hit" : "miss", &j, which[i], which[i + 2], best);
  }
  job_free(&j);
  close_scenes(pairs, count);
  close_stage(&g);
}

/* >>table ---------------------------------------------------------------------------------------------------------- */

static void say_few(const report *to) {
  bool headed = false;
  for (size_t i = 0; i < to->count; i++) {
    const row *x = &to->rows[i];
    if (strcmp(x->setting, FEW) || !opens_block(to, i)) continue;
    if (!headed)
      say(&to->out, "Single calls on 16 triangles, nanoseconds: pktrt / Embree: ratio.\n\n"
                    "| kernels | a miss, stored ray | fresh | a hit, stored ray | fresh |\n|---|--:|--:|--:|--:|\n");
    headed = true;
    say(&to->out, "| %s |", x->isa);
    for (int k = 0; k < 4; k++) {
      const char *what = k < 2 ? "miss" : "hit", *calls = k % 2 ? "fresh" : "single";
      const row *ours = find_row(to, x, what, "pktrt", calls), *theirs = find_row(to, x, what, "Embree", calls);
      if (ours && theirs)
        say(&to->out, " %.1f / %.1f: **%.2f** |", ours->best, theirs->best, ours->best / theirs->best);
      else say(&to->out, " |");
    }
    say(&to->out, "\n");
  }
  if (headed) say(&to->out, "\n");
}

#endif /* PEERS_FEW_H */
