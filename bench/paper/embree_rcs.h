/* embree_rcs.h - part of paper.c: pictures by ray casting, with all their shading, against Embree 3, which only
   traces the same rays.

   The rays are those that pktrt_render makes, the same floats: recorded behind its API on their way to the kernels.
   They are put in Z order by pixel, batch by batch (16 x 16 pixels; shadow rays of each light apart), so that any 8 or
   16 rays in a row are a compact piece of the picture, as Embree's packets like them. Laying them out for Embree is not
   timed; for pktrt all that makes the picture is.

   Contents: rays, rivals, duel, part, check. */
#ifndef PAPER_EMBREE_RCS_H
#define PAPER_EMBREE_RCS_H

#include "paper.h"
#include "system.h"

#ifndef HAVE_EMBREE

static void embree_rcs(bench *b) {
  csv(&b->out, "scene,library,mode,of,rays,mrays,seconds,differ\n");
  say(&b->out, "Built without Embree 3 (make deps-extra installs it): nothing to compare with.\n\n");
}

/* Less than 0: it cannot be told. */
EX_UNUSED static double embree_rcs_check(bench *b, bool control, double *least) {
  (void)b, (void)control;
  *least = -1;
  return -1;
}

#else
#include "../embree.h"

/* >>rays ----------------------------------------------------------------------------------------------------------- */

typedef struct placed { /* a ray by its place in the picture */
  uint32_t place;
  pktrt_ray ray;
  float answer;
} placed;

static int by_place(const void *x, const void *y) {
  const uint32_t a = ((const placed *)x)->place, b = ((const placed *)y)->place;
  return a < b ? -1 : a > b;
}

static double along(const float v[3], const double w[3]) {
  return (double)v[0] * w[0] + (double)v[1] * w[1] + (double)v[2] * w[2];
}

/* Where a direction from the eye meets the picture, its bits interleaved. right and up: of length 1 at its edges. */
static uint32_t place_of(
    const float v[3], const double to[3], const double right[3], const double up[3], unsigned size) {
  const double depth = along(v, to), x = along(v, right) / depth, y = along(v, up) / depth;
  const uint32_t px = (uint32_t)fmin(fmax((x + 1) * 0.5 * size, 0), size - 1);
  const uint32_t py = (uint32_t)fmin(fmax((y + 1) * 0.5 * size, 0), size - 1);
  uint32_t place = 0;
  for (unsigned i = 0; i < 16; i++) place |= (px >> i & 1) << 2 * i | (py >> i & 1) << (2 * i + 1);
  return place;
}

static void order_rays(ray_list *l, const pktrt_camera *c, unsigned size, bool shadow) {
  const double half = tan(0.5 * (double)(c->fov_y > 0 ? c->fov_y : 45) * SC_PI / 180);
  const sc_v3 to = sc_unit(sc_sub(sc_get(c->target, 0), sc_get(c->eye, 0)));
  const sc_v3 aside = sc_unit(sc_cross(to, sc_v(0, 1, 0))), over = sc_cross(aside, to);
  const double t[3] = {to.x, to.y, to.z}, r[3] = {aside.x / half, aside.y / half, aside.z / half},
               u[3] = {over.x / half, over.y / half, over.z / half};
  placed p[PK_BATCH];
  for (size_t k = 0; k < l->chunks; k++) {
    const size_t from = l->chunk[k], n = (k + 1 < l->chunks ? l->chunk[k + 1] : l->count) - from;
    for (size_t i = 0; i < n; i++) {
      const pktrt_ray *ray = &l->ray[from + i];
      float v[3];
      for (int a = 0; a < 3; a++) v[a] = shadow ? ray->origin[a] - c->eye[a] : ray->direction[a];
      p[i].place = place_of(v, t, r, u, size), p[i].ray = *ray, p[i].answer = l->answer[from + i];
    }
    qsort(p, n, sizeof *p, by_place);
    for (size_t i = 0; i < n; i++) l->ray[from + i] = p[i].ray, l->answer[from + i] = p[i].answer;
  }
}

/* >>rivals --------------------------------------------------------------------------------------------------------- */

enum { RIVALS = 8, WAYS = 4 };
static const struct {
  const char *name;
  embree_way way;
} ways_of_embree[WAYS] = {{"single", {1, false, RTC_INTERSECT_CONTEXT_FLAG_COHERENT}},
    {"8 coherent", {8, false, RTC_INTERSECT_CONTEXT_FLAG_COHERENT}},
    {"16 coherent", {16, false, RTC_INTERSECT_CONTEXT_FLAG_COHERENT}},
    {"stream coherent", {1, true, RTC_INTERSECT_CONTEXT_FLAG_COHERENT}}};

typedef struct rival { /* Embree on one instruction set, in one way */
  const char *isa;
  int way;
  RTCScene scene;
  double rounds[2][MAX_ROUNDS], seconds[2]; /* of primary and of shadow rays; their medians */
  size_t differ[2];                         /* rays for which pktrt has another answer */
} rival;

typedef struct embassy {
  RTCDevice device[2];
  RTCScene scene[2];
  rival rival[RIVALS];
  size_t count;
} embassy;

/* All it has, and AVX2 alone, which sometimes is the faster. */
static void open_embassy(embassy *e, const scene *made) {
  static const char *const isas[2] = {"auto", "avx2"};
  memset(e, 0, sizeof *e);
  for (int i = 0; i < 2; i++) {
    if (i && !pktrt_isa_available(PKTRT_ISA_AVX512)) break; /* auto is AVX2 */
    e->device[i] = rtcNewDevice(i ? "threads=1,isa=avx2" : "threads=1");
    if (!e->device[i]) fatal("Embree cannot be started");
    e->scene[i] = rtcNewScene(e->device[i]);
    rtcSetSceneBuildQuality(e->scene[i], RTC_BUILD_QUALITY_MEDIUM);
    for (size_t m = 0; m < made->mesh_count; m++) embree_add(e->device[i], e->scene[i], &made->meshes[m]);
    rtcCommitScene(e->scene[i]);
    if (rtcGetDeviceError(e->device[i]) != RTC_ERROR_NONE) fatal("Embree reports an error after building");
    for (int w = 0; w < WAYS; w++) {
      rival *r = &e->rival[e->count++];
      r->isa = isas[i], r->way = w, r->scene = e->scene[i];
    }
  }
}

static void close_embassy(embassy *e) {
  for (int i = 0; i < 2 && e->device[i]; i++) {
    rtcReleaseScene(e->scene[i]);
    rtcReleaseDevice(e->device[i]);
  }
}

static double run_rival(const rival *r, const embree_rays *rays) {
  const embree_way *way = &ways_of_embree[r->way].way;
  embree_fill(rays, way->width);
  const double start = cpu_seconds();
  embree_trace(r->scene, way, rays, 0, rays->count);
  return cpu_seconds() - start;
}

static size_t count_differing(const rival *r, const embree_rays *rays, const float *answer) {
  size_t n = 0;
  for (size_t i = 0; i < rays->count; i++) {
    const float x = embree_answer(rays, ways_of_embree[r->way].way.width, i), y = answer[i];
    n += !(isinf(x) || isinf(y) ? isinf(x) && isinf(y) : fabsf(x - y) <= 1e-3f * y);
  }
  return n;
}

/* >>duel ----------------------------------------------------------------------------------------------------------- */

typedef struct duel {
  double seconds, ratio; /* of the picture; Embree's best for all rays over it */
  size_t rays[2];
  const rival *best[2]; /* of primary and of shadow rays */
} duel;

static void record_picture(bench *b, const pktrt_render_desc *d, ray_list list[2]) {
  const size_t pixels = (size_t)d->width * d->height;
  pktrt_render_desc counting = *d;
  pktrt_stats stats;
  memset(&stats, 0, sizeof stats);
  counting.stats = &stats;
  list[0] = make_list(pixels), list[1] = make_list(pixels * b->now.made.light_count);
  tap_open(b->now.tree, trace_recorded);
  tap.list[0] = &list[0], tap.list[1] = &list[1];
  if (pktrt_render(b->now.tree, &counting) != PKTRT_OK) fatal(pktrt_last_error(b->now.tree));
  tap.list[0] = tap.list[1] = NULL;
  tap_close(b->now.tree);
  for (int k = 0; k < 2; k++) {
    if (list[k].count != stats.by_type[k ? PKTRT_RAY_SHADOW : PKTRT_RAY_PRIMARY].rays)
      fatal("the rays recorded are not those that were traced");
    order_rays(&list[k], &d->camera, d->width, k);
  }
}

/* A picture of the setup, and Embree's ways to trace its rays, in turns. */
static duel fight(bench *b, const setup *s, embassy *e) {
  double seconds[MAX_ROUNDS];
  ray_list list[2];
  embree_rays rays[2];
  pktrt_render_desc d;
  duel result;
  memset(&result, 0, sizeof result);
  open_setup(&b->now, s);
  open_embassy(e, &b->now.made);
  describe(b, s, 0, NULL, &d);
  record_picture(b, &d, list);
  embree_word *words = (embree_word *)take(list[0].count + list[1].count + 32, EMBREE_RAY_HIT_WORDS * sizeof *words);
  for (int k = 0; k < 2; k++) {
    rays[k].ray = list[k].ray, rays[k].count = result.rays[k] = list[k].count;
    rays[k].occlusion = k, rays[k].words = words;
    for (size_t i = 0; i < e->count; i++) { /* not timed */
      run_rival(&e->rival[i], &rays[k]);
      e->rival[i].differ[k] = count_differing(&e->rival[i], &rays[k], list[k].answer);
    }
  }
  for (unsigned round = 0; round < b->given.rounds; round++) {
    const double start = cpu_seconds();
    if (pktrt_render(b->now.tree, &d) != PKTRT_OK) fatal(pktrt_last_error(b->now.tree));
    seconds[round] = cpu_seconds() - start;
    for (size_t i = 0; i < e->count; i++)
      for (int k = 0; k < 2; k++) {
        rival *r = &e->rival[(i + round) % e->count];
        r->rounds[k][round] = run_rival(r, &rays[k]);
      }
  }
  result.seconds = median_of(seconds, b->given.rounds);
  for (int k = 0; k < 2; k++)
    for (size_t i = 0; i < e->count; i++) {
      rival *r = &e->rival[i];
      r->seconds[k] = median_of(r->rounds[k], b->given.rounds);
      if (!result.best[k] || r->seconds[k] < result.best[k]->seconds[k]) result.best[k] = r;
    }
  result.ratio = (result.best[0]->seconds[0] + result.best[1]->seconds[1]) / result.seconds;
  free(words);
  for (int k = 0; k < 2; k++) free_list(&list[k]);
  return result;
}

static setup ray_casting(const bench *b, const char *name) {
  setup s = one_frame(b, name, PKTRT_MODE_RCS, 1);
  s.path = PKTRT_PATH_FAST, s.isa = widest();
  return s;
}

/* >>part ----------------------------------------------------------------------------------------------------------- */

static void csv_duel(const bench *b, const setup *s, const embassy *e, const duel *f) {
  static const char *const of[2] = {"primary", "shadow"};
  const size_t all = f->rays[0] + f->rays[1];
  csv(&b->out, "%s,pktrt,%s %s,all and shading,%zu,%.4f,%.6f,\n", s->scene, path_names[s->path],
      pktrt_isa_string(s->isa), all, 1e-6 * (double)all / f->seconds, f->seconds);
  for (size_t i = 0; i < e->count; i++)
    for (int k = 0; k < 2; k++)
      csv(&b->out, "%s,Embree %s,%s %s,%s,%zu,%.4f,%.6f,%zu\n", s->scene, RTC_VERSION_STRING,
          ways_of_embree[e->rival[i].way].name, e->rival[i].isa, of[k], f->rays[k],
          1e-6 * (double)f->rays[k] / e->rival[i].seconds[k], e->rival[i].seconds[k], e->rival[i].differ[k]);
}

static void embree_rcs(bench *b) {
  csv(&b->out, "scene,library,mode,of,rays,mrays,seconds,differ\n");
  say(&b->out,
      "Ray casting of %u x %u pixels with all shading, fast path, %s, one thread, against Embree %s tracing the same "
      "rays without any; Mrays/s, of Embree's coherent ways and single calls the fastest. Wanted: a ratio of 0.5.\n\n"
      "| scene | rays | pktrt, shaded | Embree: primary | shadow | all | ratio | differ |\n"
      "|---|--:|--:|--:|--:|--:|--:|--:|\n",
      b->given.size, b->given.size, pktrt_isa_string(widest()), RTC_VERSION_STRING);
  for (int i = 0; i < 3; i++) {
    const setup s = ray_casting(b, scenes[i]);
    embassy e;
    const duel f = fight(b, &s, &e);
    const double mega = 1e-6 * (double)(f.rays[0] + f.rays[1]);
    say(&b->out, "| %s | %zu | %.2f |", s.scene, f.rays[0] + f.rays[1], mega / f.seconds);
    for (int k = 0; k < 2; k++)
      say(&b->out, " %.2f (%s, %s) |", 1e-6 * (double)f.rays[k] / f.best[k]->seconds[k],
          ways_of_embree[f.best[k]->way].name, f.best[k]->isa);
    say(&b->out, " %.2f | %.2f | %zu |\n", mega / (f.seconds * f.ratio), f.ratio,
        f.best[0]->differ[0] + f.best[1]->differ[1]);
    csv_duel(b, &s, &e, &f);
    close_embassy(&e);
    fprintf(stderr, "%s: %s: done\n", b->out.name, s.scene);
  }
  say(&b->out, "\n");
}

/* >>check ---------------------------------------------------------------------------------------------------------- */

/* The geometric mean of the scenes' ratios, and the least of them. The control casts single rays with scalar kernels,
   which must not reach what is asked of packets. */
EX_UNUSED static double embree_rcs_check(bench *b, bool control, double *least) {
  const int n = control ? 1 : 3;
  double product = 1;
  *least = INFINITY;
  for (int i = 0; i < n; i++) {
    setup s = ray_casting(b, scenes[i]);
    embassy e;
    if (control) s.path = PKTRT_PATH_SINGLE, s.isa = PKTRT_ISA_SCALAR;
    const double ratio = fight(b, &s, &e).ratio;
    *least = fmin(*least, ratio), product *= ratio;
    close_embassy(&e);
  }
  return pow(product, 1.0 / n);
}

#endif /* HAVE_EMBREE */
#endif /* PAPER_EMBREE_RCS_H */
