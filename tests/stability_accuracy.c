/* Accuracy: how far t, u, v and the point of a hit are from where ray and triangle meet, as distributions; and special cases,
   whose answers must be those of the reference, bit for bit, and what else is promised of them. */
#include "stability.h"

static const char part[] = "accuracy";

/* --- errors ---
   The truth is the meeting of the ray's line, its floats taken as exact, with the plane of the triangle that was reported, its
   corners rounded to float at the ray's time as the manual defines them. In long double, of 64 bits or more: with M the largest
   |corner - origin|, c the cosine of incidence and h height over longest edge, Moeller and Trumbore's formulas are off by
   some 2^-61 M / (c h) there, and c h >= 10^-8 wherever errors are reported: by a thousandth of an ulp at most.

   One ulp is that of the largest coordinate in play: of origin, corners and point, by magnitude, in the scene's frame. All
   errors are distances over it: |t - t'| |d|, which is also the error of the point o + t d but for the rounding of its
   evaluation; |u - u'| |p1 - p0|; |v - v'| |p2 - p0|; and the length of point - point'. */

typedef struct truth {
  double u, v, point[3], ulp, length, edge[2]; /* length: of the direction */
  long double t;
  double cosine, height;                       /* of incidence; over the longest edge */
  double far;                                  /* distance of the origin over the longest edge */
} truth;

typedef enum quantity { ERROR_T, ERROR_U, ERROR_V, ERROR_POINT, ERROR_ALONG, ERROR_BLEND, QUANTITIES } quantity;
static const char *const quantity_name[QUANTITIES] = {
  "t", "u", "v", "point of u and v", "o + t d in float", "point of u and v in float",
};

typedef long double lvec[3];
static void minus(const float a[3], const float b[3], lvec out) {
  for (int k = 0; k < 3; k++) out[k] = (long double)a[k] - (long double)b[k];
}
static void across(const lvec a, const lvec b, lvec out) {
  for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}
static long double along(const lvec a, const lvec b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static double size_of(const lvec a) { return sqrt((double)along(a, a)); }

static double ulp_at(double x) {
  int e;
  frexp(x, &e);
  return fmax(ldexp(1, e - 24), 0x1p-149);
}

static truth truth_of(const pktrt_ray *r, float p[3][3]) {
  truth out;
  const float zero[3] = {0, 0, 0};
  double largest = 0;
  lvec e[2], d, s, n, q, pe;
  minus(p[1], p[0], e[0]), minus(p[2], p[0], e[1]), minus(r->direction, zero, d), minus(r->origin, p[0], s);
  across(d, e[1], pe), across(s, e[0], q), across(e[0], e[1], n);
  const long double inverse = 1 / along(e[0], pe), u = along(s, pe) * inverse, v = along(d, q) * inverse;
  out.t = along(e[1], q) * inverse, out.u = (double)u, out.v = (double)v;
  for (int k = 0; k < 3; k++) {
    const long double point = (long double)p[0][k] + u * e[0][k] + v * e[1][k];
    out.point[k] = (double)point;
    largest = fmax(largest, fmax(fabs(out.point[k]), fabs((double)r->origin[k])));
    for (int c = 0; c < 3; c++) largest = fmax(largest, fabs((double)p[c][k]));
    q[k] = e[1][k] - e[0][k];
  }
  out.ulp = ulp_at(largest), out.length = size_of(d), out.edge[0] = size_of(e[0]), out.edge[1] = size_of(e[1]);
  const double longest = fmax(fmax(out.edge[0], out.edge[1]), size_of(q)), area = size_of(n);
  out.cosine = fabs((double)along(n, d)) / (area * out.length);
  out.height = area / (longest * longest);
  out.far = size_of(s) / longest;
  return out;
}

static double apart(const double a[3], const double b[3]) {
  return sqrt((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]) + (a[2] - b[2]) * (a[2] - b[2]));
}

static void errors_of(const truth *x, const pktrt_ray *r, float p[3][3], float t, float u, float v, float out[QUANTITIES]) {
  double blend[3], rounded[3], reached[3], e[QUANTITIES];
  for (int k = 0; k < 3; k++) {
    blend[k] = (1 - (double)u - (double)v) * (double)p[0][k] + (double)u * (double)p[1][k] + (double)v * (double)p[2][k];
    rounded[k] = (double)((1 - u - v) * p[0][k] + u * p[1][k] + v * p[2][k]);
    reached[k] = (double)(r->origin[k] + t * r->direction[k]);
  }
  e[ERROR_T] = fabs((double)((long double)t - x->t)) * x->length;
  e[ERROR_U] = fabs((double)u - x->u) * x->edge[0], e[ERROR_V] = fabs((double)v - x->v) * x->edge[1];
  e[ERROR_POINT] = apart(blend, x->point), e[ERROR_ALONG] = apart(reached, x->point), e[ERROR_BLEND] = apart(rounded, x->point);
  for (int q = 0; q < QUANTITIES; q++) out[q] = e[q] <= FLT_MAX ? (float)fmin(e[q] / x->ulp, (double)FLT_MAX) : INFINITY;
}

/* The k-th smallest of those that are not negative, exactly: floats >= 0 are ordered as their bits are. */
static float smallest(const float *x, size_t n, size_t k) {
  static size_t seen[1 << 16];
  uint32_t found = 0;
  for (int half = 0; half < 2; half++) {
    memset(seen, 0, sizeof seen);
    for (size_t j = 0; j < n; j++) {
      uint32_t bits;
      memcpy(&bits, &x[j], 4);
      if (bits >> 31 || (half && bits >> 16 != found)) continue;
      seen[half ? bits & 0xFFFF : bits >> 16]++;
    }
    uint32_t at = 0;
    while (at < 0xFFFF && k >= seen[at]) k -= seen[at++];
    found = found << 16 | at;
  }
  float out;
  memcpy(&out, &found, 4);
  return out;
}

/* --- cases --- */

enum { CHUNK = 512, PART = 8, TESTS = 3, SETS = 8, KEYS = 5 }; /* textbook tests as controls see every PART-th chunk */

typedef enum what { UNLIKE, ZEROS, EMPTY, LENGTHS, AT_KEYS, AREA, LEAKS, SHADED, WHATS } what;
static const char *const what_name[WHATS] = {
  "answers unlike the reference", "signs of zeros that matter", "hits in empty intervals", "lengths that change the answer",
  "keys unlike their static mesh", "hits without area", "light through a closed wall", "lit points in their own shadow",
};
typedef enum control { MT_UNLIKE, KS_UNLIKE, SLABS_LOSE, SLABS_ZEROS, CLOSED_EMPTY, EPSILON_LENGTHS, OTHER_FORMULA, MT_AREA, MT_LEAKS,
                       NO_OFFSET, CONTROLS } control;
static const struct control_text {
  what of;
  const char *name;
} control_text[CONTROLS] = {
  {UNLIKE, "Moeller-Trumbore"}, {UNLIKE, "Kensler-Shirley"}, {UNLIKE, "textbook slabs"}, {ZEROS, "textbook slabs"},
  {EMPTY, "closed intervals"}, {LENGTHS, "least determinant 1e-6"}, {AT_KEYS, "corners P + b (Q - P)"}, {AREA, "Moeller-Trumbore"},
  {LEAKS, "Moeller-Trumbore"}, {SHADED, "origin o + t d"},
};

typedef struct tally {
  uint64_t count[SETS][WHATS], tries[SETS][WHATS], found[CONTROLS], of[CONTROLS];
} tally;

typedef struct stage stage;
typedef struct test_case {
  const char *name;
  world (*make)(void);
  void (*rays)(const stage *, uint64_t first, pktrt_ray *, size_t n); /* first and, but for the last call, n are multiples of 8 */
  bool (*member)(const truth *, const pktrt_hit *); /* whose errors are reported; NULL: no errors are */
  /* Besides being like the reference; isa -1: of the reference's answers, for controls. */
  void (*check)(const stage *, int isa, const pktrt_ray *, const pktrt_hit *, size_t n, tally *);
  bool brief;                                       /* of errors, t and the point of u and v alone */
  double limit;                                     /* of their 99.9% */
} test_case;

struct stage { /* a case on its way */
  const test_case *c;
  uint64_t number;
  size_t n;
  world w, still[KEYS];
  pktrt_scene *scene[SETS], *still_scene[SETS][KEYS];
  float *error[TESTS][QUANTITIES]; /* of each ray; -1: not in the class */
  pthread_mutex_t lock;
  tally sum;
};

static rng rng_at(const stage *s, uint64_t ray) { return rng_of(s->number << 32 ^ ray); }

static void corners_of(const world *w, uint32_t which, uint32_t triangle, float time, float p[3][3]) {
  const mesh *m = &w->m[which];
  for (uint32_t c = 0; c < 3; c++) ref_vertex(m, m->i[3 * triangle + c], time, p[c]);
}

static bool same_hit(const pktrt_hit *a, const pktrt_hit *b) { return same_bits(a, b, sizeof *a); }
static bool same_triangle(const pktrt_hit *a, const pktrt_hit *b) { return a->mesh == b->mesh && a->triangle == b->triangle; }

/* --- a case, chunk by chunk --- */

static void trace(const pktrt_scene *scene, uint64_t chunk, const pktrt_ray *rays, pktrt_hit *hits, size_t n) {
  pktrt_query_desc q;
  memset(&q, 0, sizeof q);
  q.path = chunk % 4 == 3 ? PKTRT_PATH_SINGLE : chunk % 16 == 2 ? PKTRT_PATH_PAPER : PKTRT_PATH_FAST;
  memset(hits, 0x77, n * sizeof *hits);
  pktrt_intersect_ex(scene, &q, rays, hits, n);
}

static void against_reference(const stage *s, uint64_t chunk, int isa, const pktrt_ray *rays, const pktrt_hit *want,
                              const pktrt_hit *got, size_t n, tally *out) {
  bool occluded[CHUNK];
  const bool ask = chunk % 4 == 0;
  if (ask) pktrt_occluded_n(s->scene[isa], rays, occluded, n);
  for (size_t j = 0; j < n; j++)
    out->count[isa][UNLIKE] += !same_hit(&got[j], &want[j]) || (ask && occluded[j] != (want[j].mesh != PKTRT_NONE));
  out->tries[isa][UNLIKE] += n;
}

/* Boxes met as textbooks say: the inner minimum and maximum, no care for 0 times infinity, no slack. */
static bool textbook_slabs(const pktrt_ray *r, float p[3][3]) {
  float from = r->tmin, to = r->tmax;
  for (int k = 0; k < 3; k++) {
    const float lo = fminf(p[0][k], fminf(p[1][k], p[2][k])), hi = fmaxf(p[0][k], fmaxf(p[1][k], p[2][k]));
    const float inverse = 1 / r->direction[k], a = (lo - r->origin[k]) * inverse, b = (hi - r->origin[k]) * inverse;
    const float near = a < b ? a : b, away = a > b ? a : b;
    from = from > near ? from : near, to = to < away ? to : away;
  }
  return from <= to;
}

static void controls_of(const stage *s, uint64_t chunk, const pktrt_ray *rays, const pktrt_hit *want, size_t n, tally *out) {
  for (size_t j = 0; j < n; j++) {
    float p[3][3];
    pktrt_hit h;
    if (want[j].mesh != PKTRT_NONE) {
      corners_of(&s->w, want[j].mesh, want[j].triangle, rays[j].time, p);
      out->found[SLABS_LOSE] += !textbook_slabs(&rays[j], p);
    }
    if (chunk % PART) continue;
    ref_moller_trumbore(&s->w, &rays[j], &h);
    out->found[MT_UNLIKE] += !same_triangle(&h, &want[j]), out->of[MT_UNLIKE]++;
    ref_kensler_shirley(&s->w, &rays[j], &h);
    out->found[KS_UNLIKE] += !same_triangle(&h, &want[j]), out->of[KS_UNLIKE]++;
  }
  out->of[SLABS_LOSE] += n;
}

static void measure(const stage *s, size_t first, const pktrt_ray *rays, const pktrt_hit *hits, size_t n) {
  for (size_t j = 0; j < n; j++) {
    const pktrt_hit *h = &hits[j];
    float p[3][3], e[TESTS][QUANTITIES], t[TESTS] = {h->t, INFINITY, INFINITY}, u[TESTS] = {h->u}, v[TESTS] = {h->v};
    for (int q = 0; q < TESTS * QUANTITIES; q++) e[q / QUANTITIES][q % QUANTITIES] = -1;
    if (h->mesh != PKTRT_NONE) {
      corners_of(&s->w, h->mesh, h->triangle, rays[j].time, p);
      const truth x = truth_of(&rays[j], p);
      if (s->c->member(&x, h)) {
        plain_moller_trumbore(&rays[j], p, &t[1], &u[1], &v[1]), plain_kensler_shirley(&rays[j], p, &t[2], &u[2], &v[2]);
        for (int i = 0; i < TESTS; i++) errors_of(&x, &rays[j], p, t[i], u[i], v[i], e[i]);
      }
    }
    for (int q = 0; q < TESTS * QUANTITIES; q++) s->error[q / QUANTITIES][q % QUANTITIES][first + j] = e[q / QUANTITIES][q % QUANTITIES];
  }
}

static void chunk_job(void *arg, size_t chunk) {
  stage *s = arg;
  pktrt_ray rays[CHUNK];
  pktrt_hit want[CHUNK], got[CHUNK];
  tally mine;
  memset(&mine, 0, sizeof mine);
  const size_t first = chunk * CHUNK, n = s->n - first < CHUNK ? s->n - first : CHUNK;
  s->c->rays(s, first, rays, n);
  for (size_t j = 0; j < n; j++) ref_intersect(&s->w, &rays[j], &want[j]);
  for (int i = 0; i < isa_count; i++) {
    trace(s->scene[i], chunk, rays, got, n);
    against_reference(s, chunk, i, rays, want, got, n, &mine);
    if (s->c->check) s->c->check(s, i, rays, got, n, &mine);
    if (i == isa_count - 1 && s->c->member) measure(s, first, rays, got, n);
  }
  controls_of(s, chunk, rays, want, n, &mine);
  if (s->c->check) s->c->check(s, -1, rays, want, n, &mine);
  pthread_mutex_lock(&s->lock);
  for (int i = 0; i < SETS * WHATS; i++) {
    s->sum.count[i / WHATS][i % WHATS] += mine.count[i / WHATS][i % WHATS];
    s->sum.tries[i / WHATS][i % WHATS] += mine.tries[i / WHATS][i % WHATS];
  }
  for (int i = 0; i < CONTROLS; i++) s->sum.found[i] += mine.found[i], s->sum.of[i] += mine.of[i];
  pthread_mutex_unlock(&s->lock);
}

static void report_counts(const stage *s) {
  for (int w = 0; w < WHATS; w++)
    for (int i = 0; i < isa_count; i++)
      if (s->sum.tries[i][w]) count_figure(part, s->c->name, isas[i], s->sum.tries[i][w], what_name[w], s->sum.count[i][w]);
  for (int i = 0; i < CONTROLS; i++)
    if (s->sum.of[i])
      control_figure(part, s->c->name, what_name[control_text[i].of], control_text[i].name, s->sum.of[i], s->sum.found[i]);
}

static void report_errors(const stage *s) {
  static const char *const tests[TESTS] = {"", "Moeller-Trumbore ", "Kensler-Shirley "};
  size_t members = 0;
  for (size_t j = 0; j < s->n; j++) members += s->error[0][0][j] >= 0;
  if (!CHECK(members > 0, "%s: no ray is of this class", s->c->name)) return;
  for (int q = 0; q < QUANTITIES; q++) {
    if (s->c->brief && q != ERROR_T && q != ERROR_POINT) continue;
    const bool limited = q == ERROR_T || q == ERROR_POINT || q == ERROR_ALONG || q == ERROR_BLEND;
    char name[64];
    snprintf(name, sizeof name, "%s, %s", s->c->name, quantity_name[q]);
    for (int i = 0; i < TESTS; i++) {
      const size_t at[3] = {members / 2, (size_t)((double)members * 0.999), members - 1};
      for (int k = 0; k < 3; k++) {
        static const char *const rank[3] = {"median", "99.9%", "max"};
        char text[48];
        snprintf(text, sizeof text, "%s%s", tests[i], rank[k]);
        const double value = (double)smallest(s->error[i][q], s->n, at[k]);
        value_figure(part, name, PKTRT_ISA_AUTO, members, text, value, i == 0 && k == 1 && limited ? s->c->limit : (double)INFINITY);
      }
    }
  }
}

static void run_case(const test_case *c, uint64_t number, size_t n) {
  static stage s; /* static: CHECK of a failed thread leaves nothing half done */
  memset(&s, 0, sizeof s);
  pthread_mutex_init(&s.lock, NULL);
  s.c = c, s.number = number, s.n = n, s.w = c->make();
  ref_plant(&s.w);
  for (int i = 0; i < isa_count; i++) s.scene[i] = world_scene(&s.w, isas[i], 0);
  for (int q = 0; q < TESTS * QUANTITIES && c->member; q++) {
    float *x = malloc(s.n * sizeof *x);
    if (!x) abort();
    s.error[q / QUANTITIES][q % QUANTITIES] = x;
  }
  jobs_for((s.n + CHUNK - 1) / CHUNK, chunk_job, &s);
  report_counts(&s);
  if (c->member) report_errors(&s);
  for (int q = 0; q < TESTS * QUANTITIES; q++) free(s.error[q / QUANTITIES][q % QUANTITIES]);
  for (int i = 0; i < isa_count; i++) pktrt_scene_destroy(s.scene[i]);
  world_free(&s.w);
  pthread_mutex_destroy(&s.lock);
}

/* --- classes of well and badly conditioned hits --- */

static void inside(float p[3][3], rng *r, float out[3]) { /* a random point of a triangle */
  float u = rng_unit(r), v = rng_unit(r);
  if (u + v > 1) u = 1 - u, v = 1 - v;
  for (int k = 0; k < 3; k++) out[k] = p[0][k] + (u * (p[1][k] - p[0][k]) + v * (p[2][k] - p[0][k]));
}

static void some_corners(const world *w, rng *r, float time, float p[3][3]) {
  const uint32_t which = rng_below(r, w->n);
  corners_of(w, which, rng_below(r, w->m[which].nt), time, p);
}

static void some_origin(rng *r, float out[3]) {
  for (int k = 0; k < 3; k++) out[k] = 3 * rng_sign(r);
}

static world soup_world(void) { return world_of(mesh_soup(48, 0.3f, 1)); }

/* From the cube [-3, 3]^3 to random points of random triangles. */
static void rays_to_triangles(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  for (size_t j = 0; j < n; j++) {
    rng r = rng_at(s, first + j);
    float p[3][3], o[3], to[3], time = rng_unit(&r);
    some_corners(&s->w, &r, time, p);
    inside(p, &r, to);
    some_origin(&r, o);
    out[j] = ray_towards(o, to, time);
  }
}

static bool well(const truth *x, const pktrt_hit *h) { return (void)h, x->cosine >= 0.1 && x->height >= 0.01; }

/* Cosines from 1e-6 to 0.1, of evenly distributed logarithm. */
static void rays_grazing(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  for (size_t j = 0; j < n; j++) {
    rng r = rng_at(s, first + j);
    float p[3][3], o[3], to[3];
    lvec e[2], normal, in;
    some_corners(&s->w, &r, 0, p);
    inside(p, &r, to);
    minus(p[1], p[0], e[0]), minus(p[2], p[0], e[1]), across(e[0], e[1], normal);
    const double x = (double)rng_sign(&r), y = (double)rng_sign(&r), rise = pow(10, (double)rng_range(&r, -6, -1));
    for (int k = 0; k < 3; k++) in[k] = x * e[0][k] + y * e[1][k];
    const double scale = (double)rng_range(&r, 0.3f, 3);
    for (int k = 0; k < 3; k++)
      o[k] = (float)((double)to[k] - scale * ((double)in[k] / size_of(in) + rise * (double)normal[k] / size_of(normal)));
    out[j] = ray_towards(o, to, 0);
  }
}

static bool grazing(const truth *x, const pktrt_hit *h) {
  return (void)h, x->cosine >= 1e-6 && x->cosine < 0.1 && x->height >= 0.01;
}

static world thin_world(void) { return world_of(mesh_thin(64, 3)); }
static bool thin(const truth *x, const pktrt_hit *h) {
  return (void)h, x->cosine >= 0.1 && x->height < 0.01 && x->height >= 1e-7;
}

static world far_world(void) {
  mesh m = mesh_soup(256, 1, 4);
  for (uint32_t t = 0; t < m.nt; t++) { /* sizes from 1e-5 to 1e-3 */
    rng r = rng_of(900 + t);
    const float size = powf(10, rng_range(&r, -5, -3)), c[3] = {rng_sign(&r), rng_sign(&r), rng_sign(&r)};
    for (uint32_t k = 0; k < 9; k++) m.p[9 * t + k] = c[k % 3] + size * rng_sign(&r);
  }
  return world_of(m);
}

static bool small(const truth *x, const pktrt_hit *h) { return well(x, h) && x->far >= 1000; }

static const test_case cases[] = {
  {"well-conditioned", soup_world, rays_to_triangles, well, NULL, false, 8},
  {"grazing", soup_world, rays_grazing, grazing, NULL, false, INFINITY},
  {"thin", thin_world, rays_to_triangles, thin, NULL, false, INFINITY},
  {"small far away", far_world, rays_to_triangles, small, NULL, false, INFINITY},
};

static void all_cases(void) {
  for (size_t i = 0; i < COUNT(cases); i++) run_case(&cases[i], i + 1, thorough(1000000));
}

void suite_stability_accuracy(void) { run("stable: accuracy", all_cases); }
