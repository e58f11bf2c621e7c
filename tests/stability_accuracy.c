/* Accuracy: how far t, u, v and the point of a hit are from where ray and triangle meet, as distributions; and
   special cases, whose answers must be those of the reference, bit for bit, and what else is promised of them. */
#include "stability.h"

static const char part[] = "accuracy";

/* --- errors ---
   The truth is the meeting of the ray's line, its floats taken as exact, with the plane of the triangle that was
   reported, its corners rounded to float at the ray's time as the manual defines them. In long double, of 64 bits or
   more: with M the largest |corner - origin|, c the cosine of incidence and h height over longest edge, Moeller and
   Trumbore's formulas are off by some 2^-61 M / (c h) there, and c h >= 10^-8 wherever errors are reported: by a
   thousandth of an ulp at most.

   One ulp is that of the largest coordinate in play: of origin, corners and point, by magnitude, in the scene's
   frame. All errors are distances over it: |t - t'| |d|, which is also the error of the point o + t d but for the
   rounding of its evaluation; |u - u'| |p1 - p0|; |v - v'| |p2 - p0|; and the length of point - point'. */

typedef struct truth {
  double u, v, point[3], ulp, length, edge[2]; /* length: of the direction */
  long double t;
  double cosine, height; /* of incidence; over the longest edge */
  double far;            /* distance of the origin over the longest edge */
} truth;

typedef enum quantity { ERROR_T, ERROR_U, ERROR_V, ERROR_POINT, ERROR_ALONG, ERROR_BLEND, QUANTITIES } quantity;
static const char *const quantity_name[QUANTITIES] = {
    "t",
    "u",
    "v",
    "point of u and v",
    "o + t d in float",
    "point of u and v in float",
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

static void errors_of(
    const truth *x, const pktrt_ray *r, float p[3][3], float t, float u, float v, float out[QUANTITIES]) {
  double blend[3], rounded[3], reached[3], e[QUANTITIES];
  for (int k = 0; k < 3; k++) {
    const double a = (double)p[0][k], b = (double)p[1][k], c = (double)p[2][k];
    blend[k] = (1 - (double)u - (double)v) * a + (double)u * b + (double)v * c;
    rounded[k] = (double)((1 - u - v) * p[0][k] + u * p[1][k] + v * p[2][k]);
    reached[k] = (double)(r->origin[k] + t * r->direction[k]);
  }
  e[ERROR_T] = fabs((double)((long double)t - x->t)) * x->length;
  e[ERROR_U] = fabs((double)u - x->u) * x->edge[0], e[ERROR_V] = fabs((double)v - x->v) * x->edge[1];
  e[ERROR_POINT] = apart(blend, x->point), e[ERROR_BLEND] = apart(rounded, x->point);
  e[ERROR_ALONG] = apart(reached, x->point);
  for (int q = 0; q < QUANTITIES; q++) { /* NaN counts as infinite */
    const double ulps = e[q] / x->ulp;
    out[q] = ulps <= (double)FLT_MAX ? (float)ulps : INFINITY;
  }
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

enum { CHUNK = 512, PART = 16, TESTS = 3, SETS = 8, KEYS = 5 }; /* textbook tests as controls see every PART-th chunk */

typedef enum what { UNLIKE, ZEROS, EMPTY, LENGTHS, AT_KEYS, AREA, LEAKS, SHADED, RADIANCE, WHATS } what;
static const char *const what_name[WHATS] = {
    "answers unlike the reference",
    "signs of zeros that matter",
    "hits in empty intervals",
    "lengths that change the answer",
    "keys unlike their static mesh",
    "hits without area",
    "light through a closed wall",
    "lit points in their own shadow",
    "pixels off the closed form",
};
typedef enum control {
  MT_UNLIKE,
  SLABS_LOSE,
  SLABS_ZEROS,
  CLOSED_EMPTY,
  EPSILON_LENGTHS,
  OTHER_FORMULA,
  MT_AREA,
  MT_LEAKS,
  NO_OFFSET,
  CONTROLS
} control;
static const struct control_text {
  what of;
  const char *name;
} control_text[CONTROLS] = {
    {UNLIKE, "Moeller-Trumbore"},
    {UNLIKE, "slabs of Smits 1998"},
    {ZEROS, "slabs of Smits 1998"},
    {EMPTY, "closed intervals"},
    {LENGTHS, "least determinant 1e-6"},
    {AT_KEYS, "corners P + b (Q - P)"},
    {AREA, "Moeller-Trumbore"},
    {LEAKS, "Moeller-Trumbore"},
    {SHADED, "origin o + t d"},
};

typedef struct tally {
  uint64_t count[SETS][WHATS], tries[SETS][WHATS], found[CONTROLS], of[CONTROLS];
} tally;

typedef struct stage stage;
typedef struct test_case {
  const char *name;
  world (*make)(void);
  void (*rays)(const stage *, uint64_t first, pktrt_ray *, size_t n); /* first is a multiple of 8 */
  bool (*member)(const truth *, const pktrt_hit *); /* whose errors are reported; NULL: no errors are */
  /* Besides being like the reference; isa -1: of the reference's answers, for controls. */
  void (*check)(const stage *, uint64_t first, int isa, const pktrt_ray *, const pktrt_hit *, size_t n, tally *);
  bool brief;   /* of errors, t and the point of u and v alone */
  double limit; /* of their 99.9% */
  bool stills;  /* of each key of mesh 0, which has KEYS, a static scene */
} test_case;

struct stage { /* a case on its way */
  const test_case *c;
  uint64_t number;
  size_t n;
  world w;
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
static bool same_triangle(const pktrt_hit *a, const pktrt_hit *b) {
  return a->mesh == b->mesh && a->triangle == b->triangle;
}

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
  const bool ask = chunk % 16 == 0;
  if (ask) pktrt_occluded_n(s->scene[isa], rays, occluded, n);
  for (size_t j = 0; j < n; j++)
    out->count[isa][UNLIKE] += !same_hit(&got[j], &want[j]) || (ask && occluded[j] != (want[j].mesh != PKTRT_NONE));
  out->tries[isa][UNLIKE] += n;
}

/* Boxes met as by Smits (Efficiency Issues for Ray Tracing, 1998), who divides by zero: -0 counts as positive; rounding
   is not allowed for. */
DIVIDES_BY_ZERO static bool smits_slabs(const pktrt_ray *r, float p[3][3]) {
  float from = r->tmin, to = r->tmax;
  for (int k = 0; k < 3; k++) {
    const float lo = fminf(p[0][k], fminf(p[1][k], p[2][k])), hi = fmaxf(p[0][k], fmaxf(p[1][k], p[2][k]));
    const bool up = r->direction[k] >= 0;
    const float near = ((up ? lo : hi) - r->origin[k]) / r->direction[k];
    const float away = ((up ? hi : lo) - r->origin[k]) / r->direction[k];
    if (near > from) from = near;
    if (away < to) to = away;
    if (from > to) return false;
  }
  return true;
}

static void controls_of(
    const stage *s, uint64_t chunk, const pktrt_ray *rays, const pktrt_hit *want, size_t n, tally *out) {
  for (size_t j = 0; j < n; j++) {
    float p[3][3];
    pktrt_hit h;
    if (want[j].mesh != PKTRT_NONE) {
      corners_of(&s->w, want[j].mesh, want[j].triangle, rays[j].time, p);
      out->found[SLABS_LOSE] += !smits_slabs(&rays[j], p);
    }
    if (chunk % PART) continue;
    ref_moller_trumbore(&s->w, &rays[j], &h);
    out->found[MT_UNLIKE] += !same_triangle(&h, &want[j]), out->of[MT_UNLIKE]++;
  }
  out->of[SLABS_LOSE] += n;
}

static void measure(const stage *s, size_t first, const pktrt_ray *rays, const pktrt_hit *hits, size_t n) {
  for (size_t j = 0; j < n; j++) {
    const pktrt_hit *h = &hits[j];
    float p[3][3], e[TESTS][QUANTITIES], t[TESTS] = {h->t, INFINITY, INFINITY}, u[TESTS] = {h->u}, v[TESTS] = {h->v};
    for (int q = 0; q < QUANTITIES; q++) e[0][q] = e[1][q] = e[2][q] = -1;
    if (h->mesh != PKTRT_NONE) {
      corners_of(&s->w, h->mesh, h->triangle, rays[j].time, p);
      const truth x = truth_of(&rays[j], p);
      if (s->c->member(&x, h)) {
        plain_moller_trumbore(&rays[j], p, &t[1], &u[1], &v[1]);
        plain_kensler_shirley(&rays[j], p, &t[2], &u[2], &v[2]);
        for (int i = 0; i < TESTS; i++) errors_of(&x, &rays[j], p, t[i], u[i], v[i], e[i]);
      }
    }
    for (int i = 0; i < TESTS; i++)
      for (int q = 0; q < QUANTITIES; q++) s->error[i][q][first + j] = e[i][q];
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
    if (s->c->check) s->c->check(s, first, i, rays, got, n, &mine);
    if (i == isa_count - 1 && s->c->member) measure(s, first, rays, got, n);
  }
  controls_of(s, chunk, rays, want, n, &mine);
  if (s->c->check) s->c->check(s, first, -1, rays, want, n, &mine);
  pthread_mutex_lock(&s->lock);
  for (int i = 0; i < SETS * WHATS; i++) {
    s->sum.count[i / WHATS][i % WHATS] += mine.count[i / WHATS][i % WHATS];
    s->sum.tries[i / WHATS][i % WHATS] += mine.tries[i / WHATS][i % WHATS];
  }
  for (int i = 0; i < CONTROLS; i++) s->sum.found[i] += mine.found[i], s->sum.of[i] += mine.of[i];
  pthread_mutex_unlock(&s->lock);
}

static void report_counts(const stage *s) {
  const char *name = s->c->name;
  const tally *t = &s->sum;
  for (int w = 0; w < WHATS; w++)
    for (int i = 0; i < isa_count; i++)
      if (t->tries[i][w]) count_figure(part, name, isas[i], t->tries[i][w], what_name[w], t->count[i][w]);
  for (int i = 0; i < CONTROLS; i++) {
    const struct control_text *c = &control_text[i];
    if (t->of[i]) control_figure(part, name, what_name[c->of], c->name, t->of[i], t->found[i]);
  }
}

static void report_errors(const stage *s) {
  static const char *const tests[TESTS] = {"", "Moeller-Trumbore ", "Kensler-Shirley "};
  size_t members = 0;
  for (size_t j = 0; j < s->n; j++) members += s->error[0][0][j] >= 0;
  if (!CHECK(members > 0, "%s: no ray is of this class", s->c->name)) return;
  for (int q = 0; q < QUANTITIES; q++) {
    if (s->c->brief && q != ERROR_T && q != ERROR_POINT) continue;
    /* Positions; of fewer hits 99.9% is chance: the largest of them. */
    const bool limited = q != ERROR_U && q != ERROR_V && members >= 5000;
    char name[64];
    snprintf(name, sizeof name, "%s, %s", s->c->name, quantity_name[q]);
    for (int i = 0; i < TESTS; i++) {
      for (int k = 0; k < 3; k++) {
        static const char *const rank[3] = {"median", "99.9%", "max"};
        const size_t at[3] = {members / 2, (size_t)((double)members * 0.999), members - 1};
        const double value = (double)smallest(s->error[i][q], s->n, at[k]);
        char text[48];
        snprintf(text, sizeof text, "%s%s", tests[i], rank[k]);
        const double limit = i == 0 && k == 1 && limited ? s->c->limit : (double)INFINITY;
        if (i == 0 && k == 1 && q == ERROR_T)
          say("%s: 99.9%% of %zu hits within %.3g ulps", s->c->name, members, value);
        value_figure(part, name, PKTRT_ISA_AUTO, members, text, value, limit);
      }
    }
  }
}

static void make_stills(stage *s) {
  for (uint32_t k = 0; k < KEYS; k++) {
    mesh still = s->w.m[0]; /* a part of it, freed with it */
    still.p += (size_t)k * still.nv * 3, still.keys = 1;
    const world w = world_of(still);
    for (int i = 0; i < isa_count; i++) s->still_scene[i][k] = world_scene(&w, isas[i], 0);
  }
}

static void run_case(const test_case *c, uint64_t number, size_t n) {
  stage s;
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
  if (c->stills) make_stills(&s);
  jobs_for((s.n + CHUNK - 1) / CHUNK, chunk_job, &s);
  report_counts(&s);
  if (c->member) report_errors(&s);
  for (int q = 0; q < TESTS * QUANTITIES; q++) free(s.error[q / QUANTITIES][q % QUANTITIES]);
  for (int i = 0; i < isa_count; i++) pktrt_scene_destroy(s.scene[i]);
  for (int i = 0; i < isa_count; i++)
    for (int k = 0; k < KEYS; k++) pktrt_scene_destroy(s.still_scene[i][k]);
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

static world soup_world(void) { return world_of(mesh_soup(24, 0.3f, 1)); }

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
    const double flat = scale / size_of(in), steep = scale * rise / size_of(normal);
    for (int k = 0; k < 3; k++) o[k] = (float)((double)to[k] - (flat * (double)in[k] + steep * (double)normal[k]));
    out[j] = ray_towards(o, to, 0);
  }
}

static bool grazing(const truth *x, const pktrt_hit *h) {
  return (void)h, x->cosine >= 1e-6 && x->cosine < 0.1 && x->height >= 0.01;
}

static world thin_world(void) { return world_of(mesh_thin(32, 3)); }
static bool thin(const truth *x, const pktrt_hit *h) {
  return (void)h, x->cosine >= 0.1 && x->height < 0.01 && x->height >= 1e-7;
}

static world far_world(void) {
  mesh m = mesh_soup(64, 1, 4);
  for (uint32_t t = 0; t < m.nt; t++) { /* sizes from 1e-5 to 1e-3 */
    rng r = rng_of(900 + t);
    const float size = powf(10, rng_range(&r, -5, -3)), c[3] = {rng_sign(&r), rng_sign(&r), rng_sign(&r)};
    for (uint32_t k = 0; k < 9; k++) m.p[9 * t + k] = c[k % 3] + size * rng_sign(&r);
  }
  return world_of(m);
}

static bool small(const truth *x, const pktrt_hit *h) { return well(x, h) && x->far >= 1000; }

/* --- a teapot in a stadium --- */

/* A body of revolution about y, closed, of 2 * around * rows triangles less those at its ends. */
static mesh mesh_teapot(uint32_t around, uint32_t rows) {
  mesh m = mesh_of(around * (rows - 1) + 2, 2 * around * (rows - 1));
  for (uint32_t i = 1; i < rows; i++) {
    const double y = (double)i / rows, width = 0.5 * sqrt(y * (1 - y)) * (1.3 + sin(7 * y));
    for (uint32_t j = 0; j < around; j++) {
      const double angle = 6.283185307179586 * j / around;
      float *p = m.p + 3 * ((i - 1) * around + j);
      p[0] = (float)(width * cos(angle)), p[1] = (float)y, p[2] = (float)(width * sin(angle));
    }
  }
  const uint32_t bottom = m.nv - 2, top = m.nv - 1;
  m.p[3 * top + 1] = 1;
  uint32_t *t = m.i;
  for (uint32_t j = 0; j < around; j++) {
    const uint32_t next = (j + 1) % around, last = (rows - 2) * around;
    *t++ = bottom, *t++ = j, *t++ = next;
    *t++ = top, *t++ = last + next, *t++ = last + j;
    for (uint32_t i = 0; i + 2 < rows; i++) {
      const uint32_t a = i * around + j, b = i * around + next;
      *t++ = a, *t++ = a + around, *t++ = b;
      *t++ = b, *t++ = a + around, *t++ = b + around;
    }
  }
  return m;
}

/* The stadium is 20,000 across; one teapot stands in its middle, the other where coordinates are coarse. */
static world stadium_world(void) {
  world w = world_of(mesh_box());
  w.m[w.n++] = mesh_teapot(20, 12), w.m[w.n++] = mesh_teapot(20, 12);
  mesh_place(&w.m[0], (float[3]){1e4f, 1e4f, 1e4f}, (float[3]){0, 1e4f, 0});
  mesh_shift(&w.m[2], 3e3f, 0, 2e3f);
  return w;
}

/* From 10 to 10,000 away. */
static void rays_to_teapots(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  for (size_t j = 0; j < n; j++) {
    rng r = rng_at(s, first + j);
    const uint32_t which = 1 + rng_below(&r, 2);
    float p[3][3], to[3], o[3], away = powf(10, rng_range(&r, 1, 4));
    corners_of(&s->w, which, rng_below(&r, s->w.m[which].nt), 0, p);
    inside(p, &r, to);
    for (int k = 0; k < 3; k++) {
      o[k] = to[k] + away * (k == 1 ? rng_unit(&r) : rng_sign(&r));
      o[k] = o[k] > 9.9e3f ? 9.9e3f : o[k] < -9.9e3f ? -9.9e3f : o[k];
    }
    out[j] = ray_towards(o, to, 0);
  }
}

static bool on_teapot(const truth *x, const pktrt_hit *h) { return h->mesh > 0 && well(x, h); }

/* --- zeros, and origins in planes and at vertices --- */

static void to_lattice(mesh *m) { /* multiples of 1/64 */
  for (size_t k = 0; k < (size_t)m->keys * m->nv * 3; k++) m->p[k] = floorf(m->p[k] * 64 + 0.5f) / 64;
}

static world lattice_world(void) {
  world w = world_of(mesh_box());
  w.m[w.n++] = mesh_grid(4, 0.75f);
  w.m[w.n++] = mesh_soup(16, 0.5f, 6);
  to_lattice(&w.m[2]);
  return w;
}

/* 26 directions, each ray twice in a row: all zeros of origin and direction have signs by chance. */
static void rays_of_zeros(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  for (size_t j = 0; j < n; j++) {
    rng r = rng_at(s, (first + j) / 2), signs = rng_at(s, UINT64_C(1) << 31 | (first + j));
    const uint32_t which = rng_below(&r, 26), digits = which < 13 ? which : which + 1;
    static const uint32_t place[3] = {1, 3, 9};
    float p[3];
    out[j] = ray_of(0, 0, 0, 0, 0, 0);
    for (int k = 0; k < 3; k++) {
      out[j].direction[k] = (float)(digits / place[k] % 3) - 1;
      const uint32_t kind = rng_below(&r, 4);
      pick_vertex(&s->w, &r, 0, p);
      const float anywhere = 3 * rng_sign(&r);
      out[j].origin[k] = kind < 2 ? p[k] : kind == 2 ? anywhere : 0;
      if (out[j].direction[k] == 0) out[j].direction[k] = rng_below(&signs, 2) ? -0.0f : 0.0f;
      if (out[j].origin[k] == 0) out[j].origin[k] = rng_below(&signs, 2) ? -0.0f : 0.0f;
    }
  }
}

static void check_zeros(
    const stage *s, uint64_t first, int isa, const pktrt_ray *rays, const pktrt_hit *hits, size_t n, tally *out) {
  (void)first;
  for (size_t j = 0; j + 1 < n; j += 2) {
    const pktrt_hit *a = &hits[j], *b = &hits[j + 1];
    if (isa >= 0) {
      out->count[isa][ZEROS] += !same_triangle(a, b) || a->t != b->t || a->u != b->u || a->v != b->v;
      out->tries[isa][ZEROS]++;
    } else {
      float p[3][3];
      out->of[SLABS_ZEROS]++;
      if (a->mesh == PKTRT_NONE) continue;
      corners_of(&s->w, a->mesh, a->triangle, 0, p);
      out->found[SLABS_ZEROS] += smits_slabs(&rays[j], p) != smits_slabs(&rays[j + 1], p);
    }
  }
}

/* In a plane of a triangle's box; in its plane, exactly, since coordinates are coarse; at one of its corners. Half
   of the directions stay in that plane, half of the intervals reach back. */
static void rays_from_planes(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  for (size_t j = 0; j < n; j++) {
    rng r = rng_at(s, first + j);
    float p[3][3], o[3], to[3];
    some_corners(&s->w, &r, 0, p);
    some_origin(&r, o);
    const uint32_t c = rng_below(&r, 3), axis = rng_below(&r, 3), kind = (uint32_t)(first + j) % 3;
    float a[2], b[2];
    for (int i = 0; i < 2; i++) a[i] = (float)rng_below(&r, 17) / 4 - 2, b[i] = (float)rng_below(&r, 17) / 4 - 2;
    pick_vertex(&s->w, &r, 0, to);
    const bool stays = rng_below(&r, 2) == 0;
    for (int k = 0; k < 3; k++) {
      const float e = p[1][k] - p[0][k], f = p[2][k] - p[0][k];
      if (kind > 0) o[k] = kind == 1 ? p[0][k] + (a[0] * e + b[0] * f) : p[c][k];
      if (kind > 0 && stays) to[k] = p[0][k] + (a[1] * e + b[1] * f);
    }
    if (kind == 0) o[axis] = p[c][axis];
    if (kind == 0 && stays) to[axis] = o[axis];
    out[j] = ray_towards(o, to, 0);
    if (rng_below(&r, 2)) out[j].tmin = -1;
  }
}

/* Into some triangle, at rest. */
static pktrt_ray ray_into_some(const stage *s, rng *r) {
  float p[3][3], o[3], to[3];
  some_corners(&s->w, r, 0, p);
  inside(p, r, to);
  some_origin(r, o);
  return ray_towards(o, to, 0);
}

/* --- lengths of directions --- */

/* Lengths from 1e-15 to 1e15; every second ray has the direction of the one before, times a power of two. */
static void rays_of_lengths(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  for (size_t j = 0; j < n; j++) {
    rng r = rng_at(s, (first + j) / 2);
    out[j] = ray_into_some(s, &r);
    const float length = powf(10, rng_range(&r, -7.5f, 7.5f));
    const int power = (int)rng_below(&r, 51) - 25;
    for (int k = 0; k < 3; k++) {
      out[j].direction[k] *= length;
      if ((first + j) % 2) out[j].direction[k] = ldexpf(out[j].direction[k], power);
    }
  }
}

static bool det_below(const pktrt_ray *r, float p[3][3], float least) { /* Moeller and Trumbore's determinant */
  float e[2][3], c[3];
  for (int k = 0; k < 3; k++) e[0][k] = p[1][k] - p[0][k], e[1][k] = p[2][k] - p[0][k];
  for (int k = 0; k < 3; k++) {
    const int a = (k + 1) % 3, b = (k + 2) % 3;
    c[k] = r->direction[a] * e[1][b] - r->direction[b] * e[1][a];
  }
  return fabsf(dot3(e[0], c)) < least;
}

static void check_lengths(
    const stage *s, uint64_t first, int isa, const pktrt_ray *rays, const pktrt_hit *hits, size_t n, tally *out) {
  (void)first;
  for (size_t j = 0; j + 1 < n; j += 2) {
    const pktrt_hit *a = &hits[j];
    int k = 0;
    for (int i = 1; i < 3; i++) k = rays[j].direction[i] != 0 ? i : k;
    if (isa >= 0) {
      pktrt_hit b = hits[j + 1];
      if (b.mesh != PKTRT_NONE) b.t *= rays[j + 1].direction[k] / rays[j].direction[k]; /* a power of two: exactly */
      out->count[isa][LENGTHS] += !same_hit(a, &b), out->tries[isa][LENGTHS]++;
    } else {
      float p[3][3];
      out->of[EPSILON_LENGTHS]++;
      if (a->mesh == PKTRT_NONE) continue;
      corners_of(&s->w, a->mesh, a->triangle, 0, p);
      out->found[EPSILON_LENGTHS] += det_below(&rays[j], p, 1e-6f) != det_below(&rays[j + 1], p, 1e-6f);
    }
  }
}

/* --- intervals --- */

/* Eight rays on one line, of which the first tells where the hit is. */
static void rays_of_intervals(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  float t = 1;
  for (size_t j = 0; j < n; j++) {
    rng r = rng_at(s, (first + j) / 8);
    pktrt_ray *x = &out[j];
    *x = ray_into_some(s, &r);
    if (j % 8 == 0) {
      pktrt_hit h;
      t = ref_intersect(&s->w, x, &h) ? h.t : 1;
    }
    const float before = nextafterf(t, 0), after = nextafterf(t, INFINITY);
    switch (j % 8) {
    case 1: x->tmin = x->tmax = t; break;
    case 2: x->tmin = after, x->tmax = before; break;
    case 3: x->tmin = t; break;
    case 4: x->tmax = t; break;
    case 5: x->tmin = before, x->tmax = after; break;
    case 6: x->tmax = FLT_MAX; break;
    case 7: x->tmin = -INFINITY; break;
    default: break;
    }
  }
}

static void check_intervals(
    const stage *s, uint64_t first, int isa, const pktrt_ray *rays, const pktrt_hit *hits, size_t n, tally *out) {
  (void)s, (void)first;
  for (size_t j = 0; j < n; j++) {
    if (rays[j].tmin < rays[j].tmax) continue;
    const pktrt_hit *whole = &hits[j - j % 8];
    if (isa >= 0) out->count[isa][EMPTY] += hits[j].mesh != PKTRT_NONE, out->tries[isa][EMPTY]++;
    else out->found[CLOSED_EMPTY] += whole->mesh != PKTRT_NONE && whole->t >= rays[j].tmin && whole->t <= rays[j].tmax;
    if (isa < 0) out->of[CLOSED_EMPTY]++;
  }
}

/* --- denormal numbers --- */

static const float tiny[4] = {1e-37f, 1e-39f, 1e-41f, 1e-43f};
static world denormal_world(void) {
  world w = world_none();
  for (uint32_t i = 0; i < 5; i++) {
    w.m[w.n++] = mesh_soup(5, 0.5f, 70 + i);
    if (i < 4) mesh_scale(&w.m[i], tiny[i]);
  }
  return w;
}

/* Denormal corners, origins and directions; or corners of ordinary size and a denormal direction or component of it. */
static void rays_of_denormals(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  for (size_t j = 0; j < n; j++) {
    rng r = rng_at(s, first + j);
    const uint32_t which = rng_below(&r, 5), axis = rng_below(&r, 3), kind = rng_below(&r, 3);
    float p[3][3], o[3], to[3];
    corners_of(&s->w, which, rng_below(&r, 5), 0, p);
    inside(p, &r, to);
    for (int k = 0; k < 3; k++) o[k] = 3 * (which < 4 ? tiny[which] : 1) * rng_sign(&r);
    out[j] = ray_towards(o, to, 0);
    const float longer = ldexpf(1, (int)rng_below(&r, 100)), shorter = powf(10, rng_range(&r, -44, -37));
    if (which == 4 && kind == 0) out[j].direction[axis] = shorter * rng_sign(&r), out[j].origin[axis] = to[axis];
    for (int k = 0; k < 3 && kind > 0; k++) out[j].direction[k] *= which < 4 ? longer : shorter;
  }
}

/* --- motion --- */

static world keyed_world(void) {
  world w = world_of(mesh_soup(24, 0.3f, 12));
  mesh_move(&w.m[0], KEYS, 0.2f, 0.1f, 13);
  return w;
}

static const float key_time[8] = {0, 0.25f, 0.5f, 0.75f, 1, -1, 2, NAN};
static const uint32_t key_at[8] = {0, 1, 2, 3, 4, 0, 4, 0};

static void rays_at_keys(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  rays_to_triangles(s, first, out, n);
  for (size_t j = 0; j < n; j++) {
    rng r = rng_at(s, first + j);
    float p[3][3], to[3];
    some_corners(&s->w, &r, key_time[(first + j) % 8], p);
    inside(p, &r, to);
    out[j] = ray_towards(out[j].origin, to, key_time[(first + j) % 8]);
  }
}

/* Not the library's formula: b is 1 at the last key, where it can miss Q by an ulp. */
static bool other_formula(const mesh *m, uint32_t triangle, float time, uint32_t key) {
  time = time > 0 ? time < 1 ? time : 1 : 0;
  const float f = time * (float)(m->keys - 1), at = fminf(floorf(f), (float)(m->keys - 2)), b = f - at;
  for (uint32_t i = 0; i < 9; i++) {
    const float *p = m->p + 3 * ((size_t)at * m->nv + m->i[3 * triangle + i / 3]) + i % 3, *q = p + 3 * (size_t)m->nv;
    const float still = m->p[3 * ((size_t)key * m->nv + m->i[3 * triangle + i / 3]) + i % 3];
    if (*p + b * (*q - *p) != still) return true;
  }
  return false;
}

static void check_keys(
    const stage *s, uint64_t first, int isa, const pktrt_ray *rays, const pktrt_hit *hits, size_t n, tally *out) {
  for (size_t j = 0; j < n; j++) {
    const uint32_t key = key_at[(first + j) % 8];
    pktrt_hit h;
    if (isa >= 0) {
      pktrt_intersect(s->still_scene[isa][key], &rays[j], &h);
      out->count[isa][AT_KEYS] += !same_hit(&h, &hits[j]), out->tries[isa][AT_KEYS]++;
    } else {
      out->of[OTHER_FORMULA]++;
      if (hits[j].mesh == PKTRT_NONE) continue;
      out->found[OTHER_FORMULA] += other_formula(&s->w.m[0], hits[j].triangle, rays[j].time, key);
    }
  }
}

static world moving_world(void) {
  static const uint32_t keys[4] = {2, 3, 5, 9};
  world w = world_none();
  for (uint32_t i = 0; i < 4; i++) {
    w.m[w.n++] = mesh_soup(6, 0.3f, 20 + i);
    mesh_move(&w.m[i], keys[i], 0.1f, 0.1f, 30 + i);
  }
  return w;
}

/* A quarter of them an ulp beside keys. */
static void rays_between_keys(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  rays_to_triangles(s, first, out, n);
  for (size_t j = 0; j < n; j++) {
    if ((first + j) % 4) continue;
    rng r = rng_at(s, UINT64_C(1) << 31 | (first + j));
    const float key = (float)rng_below(&r, 9) / 8;
    out[j].time = rng_below(&r, 2) ? nextafterf(key, 2) : nextafterf(key, -1);
  }
}

/* Three keys; at the second one, or halfway to it and from it, a triangle is a point or a line. All exact: no area
   is none. */
static world collapsing_world(void) {
  mesh m = mesh_soup(24, 0.3f, 40);
  mesh_move(&m, 3, 0, 0, 1);
  to_lattice(&m);
  for (uint32_t t = 0; t < m.nt; t++) {
    const float *p = m.p + 9 * t;
    float *q = m.p + 9 * (m.nt + t);
    for (int k = 0; k < 3; k++) {
      const float a = p[k], b = p[3 + k], c = p[6 + k];
      if (t % 4 == 0) q[3 + k] = q[6 + k] = a;         /* to a point */
      else if (t % 4 == 1) q[6 + k] = a + 3 * (b - a); /* to a line */
      else if (t % 4 == 2) q[6 + k] = a + b - c;       /* turns over about the middle of an edge */
      else q[3 + k] = c, q[6 + k] = b;                 /* turns over as two corners change places */
    }
  }
  return world_of(m);
}

/* At the moment, an ulp beside it, or at any other time. */
static void rays_at_collapse(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  for (size_t j = 0; j < n; j++) {
    rng r = rng_at(s, first + j);
    const uint32_t t = rng_below(&r, s->w.m[0].nt), kind = rng_below(&r, 4);
    float p[3][3], o[3], to[3], time = t % 4 < 2 ? 0.5f : rng_below(&r, 2) ? 0.25f : 0.75f;
    if (kind == 2) time = nextafterf(time, (float)rng_below(&r, 2));
    if (kind == 3) time = rng_unit(&r);
    corners_of(&s->w, 0, t, time, p);
    inside(p, &r, to);
    some_origin(&r, o);
    out[j] = ray_towards(o, to, time);
  }
}

static bool no_area(const world *w, const pktrt_hit *h, float time) {
  if (h->mesh == PKTRT_NONE) return false;
  float p[3][3];
  lvec e[2], normal;
  corners_of(w, h->mesh, h->triangle, time, p);
  minus(p[1], p[0], e[0]), minus(p[2], p[0], e[1]), across(e[0], e[1], normal);
  return normal[0] == 0 && normal[1] == 0 && normal[2] == 0;
}

static void check_area(
    const stage *s, uint64_t first, int isa, const pktrt_ray *rays, const pktrt_hit *hits, size_t n, tally *out) {
  for (size_t j = 0; j < n; j++) {
    if (isa >= 0) out->count[isa][AREA] += no_area(&s->w, &hits[j], rays[j].time), out->tries[isa][AREA]++;
    if (isa >= 0 || first / CHUNK % PART) continue;
    pktrt_hit h;
    ref_moller_trumbore(&s->w, &rays[j], &h);
    out->found[MT_AREA] += no_area(&s->w, &h, rays[j].time), out->of[MT_AREA]++;
  }
}

/* --- lights a million times the scene's size away, or across --- */

static void some_light(rng *r, float at[3]) { /* on a sphere of radius 1e6 */
  float d[3], u[2];
  u[0] = rng_unit(r), u[1] = rng_unit(r);
  pktrt_map_sphere(u, d);
  for (int k = 0; k < 3; k++) at[k] = 1e6f * d[k];
}

static world closed_world(void) { return world_of(mesh_sphere(3, 0.04f, 9)); }

/* Shadow rays from inside a closed wall through its edges and vertices. The wall e at radius 0.96 to 1.04 is left
   behind, along the light's direction at cosine c >= 1/2 or so, by 0.7 c to c: that is at a radius below 0.92, and
   inside. */
static void rays_to_light(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  for (size_t j = 0; j < n; j++) {
    rng r = rng_at(s, first + j);
    float light[3], e[3], o[3], c;
    do {
      some_light(&r, light);
      if (j % 2) pick_vertex(&s->w, &r, 0, e);
      else pick_edge(&s->w, &r, 0, e);
      c = 1e-6f * dot3(light, e);
    } while (c < 0.5f);
    const float back = c * rng_range(&r, 0.7f, 1);
    for (int k = 0; k < 3; k++) o[k] = e[k] - back * 1e-6f * light[k];
    out[j] = ray_towards(o, light, 0);
    out[j].tmax = 1;
  }
}

static void check_leaks(
    const stage *s, uint64_t first, int isa, const pktrt_ray *rays, const pktrt_hit *hits, size_t n, tally *out) {
  bool occluded[CHUNK];
  if (isa >= 0) pktrt_occluded_n(s->scene[isa], rays, occluded, n);
  for (size_t j = 0; j < n; j++) {
    if (isa >= 0) out->count[isa][LEAKS] += !occluded[j] || hits[j].mesh == PKTRT_NONE, out->tries[isa][LEAKS]++;
    if (isa >= 0 || first / CHUNK % PART) continue;
    pktrt_hit h;
    out->found[MT_LEAKS] += !ref_moller_trumbore(&s->w, &rays[j], &h), out->of[MT_LEAKS]++;
  }
}

static world box_world(void) { return world_of(mesh_box()); }

/* A shadow ray from a lit point of the box; not spawned: as textbooks start it. */
static pktrt_ray lit_ray(const stage *s, uint64_t ray, bool spawned) {
  rng r = rng_at(s, ray);
  float p[3][3], o[3], to[3], light[3];
  pktrt_hit h;
  some_corners(&s->w, &r, 0, p);
  inside(p, &r, to);
  do some_origin(&r, o);
  while (fmaxf(fabsf(o[0]), fmaxf(fabsf(o[1]), fabsf(o[2]))) < 1.1f);
  pktrt_ray x = ray_towards(o, to, 0), out = x;
  CHECK(ref_intersect(&s->w, &x, &h), "a ray to the box hits it");
  some_light(&r, light);
  for (int k = 0; k < 3; k++) /* above the face's horizon */
    if (h.normal[k] != 0) light[k] = copysignf(fabsf(light[k]) + 2e4f, h.normal[k]);
  for (int k = 0; k < 3; k++) out.origin[k] = o[k] + h.t * x.direction[k];
  pktrt_ray shadow = ray_towards(out.origin, light, 0);
  if (spawned) pktrt_spawn(s->scene[0], &x, &h, shadow.direction, &out), shadow = out;
  shadow.tmax = 1;
  return shadow;
}

static void rays_lit(const stage *s, uint64_t first, pktrt_ray *out, size_t n) {
  for (size_t j = 0; j < n; j++) out[j] = lit_ray(s, first + j, true);
}

static void check_lit(
    const stage *s, uint64_t first, int isa, const pktrt_ray *rays, const pktrt_hit *hits, size_t n, tally *out) {
  bool occluded[CHUNK];
  if (isa >= 0) pktrt_occluded_n(s->scene[isa], rays, occluded, n);
  for (size_t j = 0; j < n; j++) {
    if (isa >= 0) out->count[isa][SHADED] += occluded[j] || hits[j].mesh != PKTRT_NONE, out->tries[isa][SHADED]++;
    if (isa >= 0 || first / CHUNK % PART) continue;
    pktrt_hit h;
    const pktrt_ray x = lit_ray(s, first + j, false);
    out->found[NO_OFFSET] += ref_intersect(&s->w, &x, &h), out->of[NO_OFFSET]++;
  }
}

/* --- all of them --- */

static const test_case cases[] = {
    {"well-conditioned", soup_world, rays_to_triangles, well, NULL, false, 8, false},
    {"grazing", soup_world, rays_grazing, grazing, NULL, false, INFINITY, false},
    {"thin", thin_world, rays_to_triangles, thin, NULL, false, INFINITY, false},
    {"small far away", far_world, rays_to_triangles, small, NULL, false, INFINITY, false},
    {"teapot in a stadium", stadium_world, rays_to_teapots, on_teapot, NULL, true, 8, false},
    {"26 directions, 0 and -0", lattice_world, rays_of_zeros, NULL, check_zeros, false, 0, false},
    {"origins in planes and at vertices", lattice_world, rays_from_planes, NULL, NULL, false, 0, false},
    {"lengths 1e-15 to 1e15", soup_world, rays_of_lengths, well, check_lengths, true, 8, false},
    {"intervals without end, of a hit, empty", soup_world, rays_of_intervals, NULL, check_intervals, false, 0, false},
    {"denormals", denormal_world, rays_of_denormals, NULL, NULL, false, 0, false},
    {"times at keys", keyed_world, rays_at_keys, NULL, check_keys, false, 0, true},
    {"times between keys", moving_world, rays_between_keys, well, NULL, true, 8, false},
    {"keys that collapse or turn over", collapsing_world, rays_at_collapse, NULL, check_area, false, 0, false},
    {"light 1e6 away, behind a wall", closed_world, rays_to_light, NULL, check_leaks, false, 0, false},
    {"light 1e6 away, lit", box_world, rays_lit, NULL, check_lit, false, 0, false},
};

/* A floor [-1, 1]^2 seen from 2 above, lit by a point 1e6 away or by a sphere of radius 1e-6 at 1: whose middle RCS
   looks at, with the exact irradiance pi R^2 / r^2. A pixel is albedo E cos / pi, rounded to float three times and
   scaled once: 4 e, e = 2^-24. Besides, the point of the floor is off: by 2.4 e as the ray's direction is rounded,
   by 9 e M <= 18 e away from the ray as it is hit (>>exactness), 22 e at the cosines there are, and by 4 e as u and
   v are rounded: 29 e in all. With h the height of the light, radiance is as h / r^3, whose logarithm has a
   gradient of at most 3 / h: 87 e / h. On the diagonal, where both triangles meet, the point is kept another 24 e (|x| +
   |z|) off it, and 4% of that (>>spawn). */
typedef struct floor_light {
  const char *name;
  pktrt_light light;
  double factor; /* radiance is factor h / r^3 */
} floor_light;

static void floor_lights(floor_light out[2]) {
  const double albedo = (double)0.8f;
  memset(out, 0, 2 * sizeof *out);
  pktrt_light *far = &out[0].light, *small = &out[1].light;
  out[0].name = "light 1e6 away, radiance", out[1].name = "light 1e-6 across, radiance";
  far->kind = PKTRT_LIGHT_POINT, far->position[0] = 3e5f, far->position[1] = 1e6f, far->position[2] = -2e5f;
  small->kind = PKTRT_LIGHT_SPHERE, small->position[0] = 0.3f, small->position[1] = 1, small->position[2] = -0.2f;
  small->radius = 0.5e-6f;
  for (int k = 0; k < 3; k++) far->intensity[k] = 3e12f, small->intensity[k] = 1e12f;
  out[0].factor = albedo * (double)far->intensity[0] / 3.14159265358979323846;
  out[1].factor = albedo * (double)small->intensity[0] * (double)small->radius * (double)small->radius;
}

static double floor_radiance(const floor_light *f, double x, double z) {
  const float *at = f->light.position;
  const double dx = (double)at[0] - x, h = (double)at[1], dz = (double)at[2] - z, r2 = dx * dx + h * h + dz * dz;
  return f->factor * h / (r2 * sqrt(r2));
}

static void floor_picture(const floor_light *f, pktrt_isa isa, uint32_t side, float *pixels) {
  world w = world_of(mesh_grid(1, 1));
  pktrt_scene *s = world_scene(&w, isa, 0);
  pktrt_render_desc d;
  memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = d.height = side, d.pixels = pixels;
  d.camera.eye[1] = 2, d.camera.up[2] = 1;
  CHECK(pktrt_add_light(s, &f->light, NULL) == PKTRT_OK && pktrt_render(s, &d) == PKTRT_OK, "%s", pktrt_last_error(s));
  pktrt_scene_destroy(s);
  world_free(&w);
}

static void floor_job(void *arg, size_t job) {
  const uint32_t side = *(const uint32_t *)arg, which = (uint32_t)job % 2;
  const pktrt_isa isa = isas[job / 2];
  float *pixels = malloc(3 * sizeof *pixels * side * side);
  floor_light f[2];
  if (!pixels) abort();
  floor_lights(f);
  floor_picture(&f[which], isa, side, pixels);
  const double bound = 0x1p-24 * (4 + 87 / (double)f[which].light.position[1]), flat = floor_radiance(&f[which], 0, 0);
  uint64_t off = 0, off_flat = 0;
  const double half = 2 * (sqrt(2) - 1); /* of the picture: 2 tan 22.5 degrees; the camera's right is -x, up is z */
  for (uint32_t y = 0; y < side; y++) {
    for (uint32_t x = 0; x < side; x++) {
      const double at[2] = {half * (1 - (2 * x + 1.0) / side), half * (1 - (2 * y + 1.0) / side)};
      const double got = (double)pixels[3 * ((size_t)y * side + x)], want = floor_radiance(&f[which], at[0], at[1]);
      const bool diagonal = fabs(fabs(at[0]) - fabs(at[1])) < 1e-5;
      const double aside = diagonal ? 25 * 0x1p-24 * (fabs(at[0]) + fabs(at[1])) : 0;
      const double most = bound + 3 * aside / (double)f[which].light.position[1];
      off += !(fabs(got - want) <= most * want), off_flat += !(fabs(flat - want) <= bound * want);
    }
  }
  const uint64_t all = (uint64_t)side * side;
  count_figure(part, f[which].name, isa, all, what_name[RADIANCE], off);
  if (job < 2) control_figure(part, f[which].name, what_name[RADIANCE], "light as parallel", all, off_flat);
  free(pixels);
}

static void all_cases(void) {
  for (size_t i = 0; i < COUNT(cases); i++) run_case(&cases[i], i + 1, thorough(1000000));
  uint32_t side = (uint32_t)ceil(sqrt((double)thorough(1000000)));
  jobs_for(2 * (size_t)isa_count, floor_job, &side);
}

void suite_stability_accuracy(void) { run("stable: accuracy", all_cases); }
