/* The answer of a ray depends on the ray alone: one reference, and every other way to ask for it. */
#include "meshes.h"

enum { BATCH = 4096, VARIANTS = 12 };

typedef struct job { /* one batch of one kind of rays */
  const world *w;
  pktrt_scene *const *scene; /* by instruction set */
  ray_kind kind;
  uint64_t seed;
  size_t first, n, number;
} job;

typedef struct shared {
  job *jobs;
  pthread_mutex_t lock;
  size_t rays, answers, hits, occlusions, wrong, differ_float;
} shared;

typedef struct buffers {
  pktrt_ray ray[BATCH], shuffled[BATCH];
  pktrt_hit want[BATCH], got[BATCH], back[BATCH];
  bool occluded[BATCH], unshuffled[BATCH];
  uint32_t order[BATCH];
  float in[9][BATCH], out[6][BATCH];
  uint32_t ids[2][BATCH];
} buffers;

static void shuffle(buffers *b, const pktrt_ray *rays, size_t n, rng *r) {
  for (size_t i = 0; i < n; i++) b->order[i] = (uint32_t)i;
  for (size_t i = n - 1; i > 0; i--) {
    uint32_t j = rng_below(r, (uint32_t)i + 1), x = b->order[i];
    b->order[i] = b->order[j];
    b->order[j] = x;
  }
  for (size_t i = 0; i < n; i++) b->shuffled[i] = rays[b->order[i]];
}

static void soa(
    const pktrt_scene *s, const pktrt_query_desc *q, buffers *b, const pktrt_ray *rays, size_t n, bool part) {
  for (size_t i = 0; i < n; i++) {
    for (int k = 0; k < 3; k++) b->in[k][i] = rays[i].origin[k], b->in[3 + k][i] = rays[i].direction[k];
    b->in[6][i] = rays[i].tmin, b->in[7][i] = rays[i].tmax, b->in[8][i] = rays[i].time;
  }
  pktrt_rays in;
  pktrt_hits out;
  memset(&out, 0, sizeof out);
  for (int k = 0; k < 3; k++) in.origin[k] = b->in[k], in.direction[k] = b->in[3 + k];
  in.tmin = b->in[6], in.tmax = b->in[7], in.time = b->in[8];
  /* in parts: what is not wanted is not written, and the rest does not depend on it */
  for (int pass = 0; pass < (part ? 3 : 1); pass++) {
    memset(&out, 0, sizeof out);
    if (!part || pass == 0) out.t = b->out[0], out.mesh = b->ids[0];
    if (!part || pass == 1) out.u = b->out[1], out.triangle = b->ids[1];
    if (!part || pass == 2)
      out.v = b->out[2], out.normal[0] = b->out[3], out.normal[1] = b->out[4], out.normal[2] = b->out[5];
    if (q) pktrt_intersect_soa_ex(s, q, &in, &out, n);
    else pktrt_intersect_soa(s, &in, &out, n);
  }
  if (q) pktrt_occluded_soa_ex(s, q, &in, b->occluded, n);
  else pktrt_occluded_soa(s, &in, b->occluded, n);
  for (size_t i = 0; i < n; i++) {
    pktrt_hit *h = &b->got[i];
    h->t = b->out[0][i], h->u = b->out[1][i], h->v = b->out[2][i];
    for (int k = 0; k < 3; k++) h->normal[k] = b->out[3 + k][i];
    h->mesh = b->ids[0][i], h->triangle = b->ids[1][i];
  }
}

static const uint32_t packet[VARIANTS] = {0, 0, 0, 0, 1, 7, 64, 256, 0, 64, 0, 0}; /* of the paper path; 0: others */

/* Fills got and occluded in the order of the rays. */
static void ask(const pktrt_scene *s, int variant, buffers *b, const pktrt_ray *rays, size_t n, rng *r) {
  static const bool mixed[VARIANTS] = {0, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 1};
  pktrt_stats stats;
  pktrt_query_desc q;
  memset(&q, 0, sizeof q);
  memset(&stats, 0, sizeof stats);
  memset(b->got, 0x77, sizeof b->got);
  memset(b->occluded, 0, sizeof b->occluded);
  q.packet_size = packet[variant];
  q.path = packet[variant] ? PKTRT_PATH_PAPER : variant == 8 ? PKTRT_PATH_SINGLE : PKTRT_PATH_FAST;
  if (variant == 10 || variant == 6) q.stats = &stats, q.type = PKTRT_RAY_SHADOW;
  if (mixed[variant]) shuffle(b, rays, n, r), rays = b->shuffled;
  switch (variant) {
  case 0:
    for (size_t i = 0; i < n; i++) {
      pktrt_intersect(s, &rays[i], &b->got[i]);
      b->occluded[i] = pktrt_occluded(s, &rays[i]);
    }
    break;
  case 1:
    pktrt_intersect_n(s, rays, b->got, n);
    pktrt_occluded_n(s, rays, b->occluded, n);
    break;
  case 2: /* any grouping */
    for (size_t i = 0; i < n;) {
      size_t m = 1 + rng_below(r, rng_below(r, 2) ? 9 : 300);
      if (m > n - i) m = n - i;
      pktrt_intersect_n(s, rays + i, b->got + i, m);
      pktrt_occluded_n(s, rays + i, b->occluded + i, m);
      i += m;
    }
    break;
  case 3: soa(s, NULL, b, rays, n, false); break;
  case 9: soa(s, &q, b, rays, n, true); break;
  case 11: soa(s, &q, b, rays, n, true); break;
  default: pktrt_intersect_ex(s, &q, rays, b->got, n); pktrt_occluded_ex(s, &q, rays, b->occluded, n);
  }
  if (!mixed[variant]) return;
  memcpy(b->back, b->got, sizeof b->back);
  memcpy(b->unshuffled, b->occluded, sizeof b->unshuffled);
  for (size_t i = 0; i < n; i++) b->got[b->order[i]] = b->back[i], b->occluded[b->order[i]] = b->unshuffled[i];
}

static bool plain_float_t(const job *j, const pktrt_ray *r, const pktrt_hit *want) {
  const mesh *m = &j->w->m[want->mesh];
  mesh one = mesh_of(3, 1);
  for (uint32_t c = 0; c < 3; c++) ref_vertex(m, m->i[want->triangle * 3 + c], r->time, one.p + 3 * c), one.i[c] = c;
  world w = world_none();
  w.m[0] = one, w.n = 1;
  pktrt_hit h;
  bool hit = ref_moller_trumbore(&w, r, &h);
  mesh_free(&one);
  return hit && h.t == want->t && h.u == want->u && h.v == want->v;
}

static void run_job(void *arg, size_t index) {
  shared *all = arg;
  const job *j = &all->jobs[index];
  size_t answers = 0, hits = 0, wrong = 0, differ = 0;
  buffers *b = calloc(1, sizeof *b);
  if (!b) abort();
  rng r = rng_of(index + 12345);
  make_rays(j->w, j->scene[isa_count - 1], j->kind, j->seed, j->first, b->ray, j->n);
  for (size_t i = 0; i < j->n; i++) hits += pktrt_intersect(j->scene[isa_count - 1], &b->ray[i], &b->want[i]);
  for (int k = 0; k < isa_count; k++) {
    int variant = (int)((j->number + (size_t)k * 5) % VARIANTS);
    /* The slow ways see a part of each batch: the paper path, above all on incoherent rays, and scalar code. */
    size_t n = j->n / (packet[variant] ? j->kind == RAYS_CAMERA ? 4 : 16 : 1) / (isas[k] == PKTRT_ISA_SCALAR ? 4 : 1);
    size_t from = (j->n - n) / 64 * (size_t)rng_below(&r, 64);
    ask(j->scene[k], variant, b, b->ray + from, n, &r);
    answers += 2 * n;
    for (size_t i = 0; i < n; i++) {
      const pktrt_hit *want = &b->want[from + i];
      bool same = same_bits(&b->got[i], want, sizeof *want);
      bool shadow = b->occluded[i] == (want->mesh != PKTRT_NONE);
      if (same && shadow) continue;
      wrong++;
      const pktrt_ray *x = &b->ray[from + i];
      CHECK(false, "%s%s, %s, variant %d: %s", j->w->m[0].keys > 1 ? "moving " : "", ray_kind_name[j->kind],
          pktrt_isa_string(isas[k]), variant, same ? "occlusion differs" : "hit differs");
      CHECK(false, "  o %a %a %a  time %a (ray %zu)", (double)x->origin[0], (double)x->origin[1], (double)x->origin[2],
          (double)x->time, j->first + from + i);
      CHECK(false, "  want %u %u t %a, got %u %u t %a", want->mesh, want->triangle, (double)want->t, b->got[i].mesh,
          b->got[i].triangle, (double)b->got[i].t);
      break;
    }
  }
  for (size_t i = 0; i < j->n; i += 64) { /* the control: another formula's bits do differ */
    differ += b->want[i].mesh != PKTRT_NONE && !plain_float_t(j, &b->ray[i], &b->want[i]);
  }
  pthread_mutex_lock(&all->lock);
  all->rays += j->n, all->answers += answers, all->hits += hits, all->wrong += wrong, all->differ_float += differ;
  pthread_mutex_unlock(&all->lock);
  free(b);
}

static void identity(world w, ray_kind from, ray_kind to) {
  pktrt_scene *scene[8] = {NULL};
  size_t n = scaled(480000), count = 0;
  shared all = {NULL, PTHREAD_MUTEX_INITIALIZER, 0, 0, 0, 0, 0, 0};
  all.jobs = calloc((n / BATCH + 1) * RAYS_KINDS, sizeof *all.jobs);
  if (!all.jobs) abort();
  for (int k = 0; k < isa_count; k++) scene[k] = world_scene(&w, isas[k], 0);
  for (int kind = (int)from; kind <= (int)to; kind++) {
    for (size_t first = 0; first < n; first += BATCH) {
      job j = {&w, scene, (ray_kind)kind, 17, first, n - first < BATCH ? n - first : BATCH, count};
      all.jobs[count++] = j;
    }
  }
  threads_for(2, count, run_job, &all);
  say("%zu rays, %zu answers, %zu hits; %zu differ; control in another formula: %zu differ", all.rays, all.answers,
      all.hits, all.wrong, all.differ_float);
  CHECK(all.wrong == 0);
  CHECK(all.hits > all.rays / 8 && all.hits < all.rays);
  CHECK(all.differ_float > 0);
  for (int k = 0; k < isa_count; k++) pktrt_scene_destroy(scene[k]);
  free(all.jobs);
  world_free(&w);
}

static void static_coherent(void) { identity(world_static(5), RAYS_CAMERA, RAYS_CAMERA); }
static void static_bundles(void) { identity(world_static(5), RAYS_BUNDLES, RAYS_BUNDLES); }
static void static_random(void) { identity(world_static(5), RAYS_RANDOM, RAYS_RANDOM); }
static void static_aimed(void) { identity(world_static(5), RAYS_EDGE, RAYS_AXIS); }
static void static_others(void) { identity(world_static(5), RAYS_SPAWNED, RAYS_INVALID); }
static void moving_coherent(void) { identity(world_moving(5), RAYS_CAMERA, RAYS_CAMERA); }
static void moving_bundles(void) { identity(world_moving(5), RAYS_BUNDLES, RAYS_BUNDLES); }
static void moving_random(void) { identity(world_moving(5), RAYS_RANDOM, RAYS_RANDOM); }
static void moving_aimed(void) { identity(world_moving(5), RAYS_EDGE, RAYS_AXIS); }
static void moving_others(void) { identity(world_moving(5), RAYS_SPAWNED, RAYS_INVALID); }

void suite_identity(void) {
  run("the same bits every way: static scene, coherent rays", static_coherent);
  run("the same bits every way: static scene, rays in bundles", static_bundles);
  run("the same bits every way: static scene, random rays", static_random);
  run("the same bits every way: static scene, rays at edges, vertices and along axes", static_aimed);
  run("the same bits every way: static scene, spawned rays, invalid rays between", static_others);
  run("the same bits every way: moving scene, coherent rays", moving_coherent);
  run("the same bits every way: moving scene, rays in bundles", moving_bundles);
  run("the same bits every way: moving scene, random rays", moving_random);
  run("the same bits every way: moving scene, rays at edges, vertices and along axes", moving_aimed);
  run("the same bits every way: moving scene, spawned rays, invalid rays between", moving_others);
}
