/* The truth, in plain loops over all triangles: what the oracle says is hit, with t, u, v and normal as the header's opening
   section on exactness has them, and two textbook tests in float that serve as controls. Independent of the header's
   implementation. */
#include "oracle.h"

void ref_vertex(const mesh *m, uint32_t vertex, float time, float out[3]) {
  const float *p = m->p + 3 * (size_t)vertex;
  if (m->keys < 2) {
    memcpy(out, p, 3 * sizeof *out);
    return;
  }
  time = time > 0 ? time < 1 ? time : 1 : 0; /* NaN: 0 */
  float f = time * (float)(m->keys - 1), s = floorf(f);
  if (s > (float)(m->keys - 2)) s = (float)(m->keys - 2);
  float b = f - s, a = 1 - b;
  p += (size_t)s * m->nv * 3;
  const float *q = p + (size_t)m->nv * 3;
  for (int k = 0; k < 3; k++) {
    float x = a * p[k], y = b * q[k];
    out[k] = x + y;
  }
}

bool ref_valid(const pktrt_ray *r) {
  bool some = false;
  for (int k = 0; k < 3; k++) {
    if (!(fabsf(r->origin[k]) <= PKTRT_MAX_COORD) || !isfinite(r->direction[k])) return false;
    some |= r->direction[k] != 0;
  }
  return some && r->tmin < r->tmax;
}

/* --- which triangles a ray can meet at all ---
   A binary tree over the boxes of the triangles, at all keys together, cut at medians. Controls look at a triangle in
   floats, off by less than 10 e M, e = 2^-24, M the largest |p|, and vertices between keys are off by 5/2 e (|o| + M): boxes
   passed at more than 2^-20 M, or 2^-20 M + 2^-21 |o|, are passed for sure. */
typedef struct ref_node {
  float lo[3], hi[3];
  uint32_t left, first, count; /* children left, left + 1; a leaf where count > 0 */
} ref_node;

struct ref_tree {
  ref_node *node;
  uint32_t (*order)[2]; /* mesh, triangle */
  uint32_t nodes;
  bool moves;
};

static void box_of_triangle(const mesh *m, uint32_t t, float lo[3], float hi[3]) {
  for (int k = 0; k < 3; k++) lo[k] = INFINITY, hi[k] = -INFINITY;
  for (uint32_t c = 0; c < 3 * m->keys; c++) {
    const float *p = m->p + 3 * ((size_t)(c / 3) * m->nv + m->i[3 * t + c % 3]);
    for (int k = 0; k < 3; k++) lo[k] = fminf(lo[k], p[k]), hi[k] = fmaxf(hi[k], p[k]);
  }
}

typedef struct ref_leaf {
  float middle;
  uint32_t at[2];
} ref_leaf;

static int by_middle(const void *a, const void *b) {
  const float x = ((const ref_leaf *)a)->middle, y = ((const ref_leaf *)b)->middle;
  return x < y ? -1 : x > y;
}

static void plant(const world *w, struct ref_tree *tree, ref_leaf *leaf, uint32_t at, uint32_t first, uint32_t count) {
  ref_node *n = &tree->node[at];
  float least[3] = {INFINITY, INFINITY, INFINITY}, most[3] = {-INFINITY, -INFINITY, -INFINITY};
  for (int k = 0; k < 3; k++) n->lo[k] = INFINITY, n->hi[k] = -INFINITY;
  for (uint32_t i = first; i < first + count; i++) {
    float lo[3], hi[3];
    box_of_triangle(&w->m[leaf[i].at[0]], leaf[i].at[1], lo, hi);
    for (int k = 0; k < 3; k++) {
      n->lo[k] = fminf(n->lo[k], lo[k]), n->hi[k] = fmaxf(n->hi[k], hi[k]);
      least[k] = fminf(least[k], lo[k] / 2 + hi[k] / 2), most[k] = fmaxf(most[k], lo[k] / 2 + hi[k] / 2);
    }
  }
  n->first = first, n->count = count;
  if (count <= 4) return;
  int axis = 0;
  for (int k = 1; k < 3; k++) axis = most[k] - least[k] > most[axis] - least[axis] ? k : axis;
  for (uint32_t i = first; i < first + count; i++) {
    float lo[3], hi[3];
    box_of_triangle(&w->m[leaf[i].at[0]], leaf[i].at[1], lo, hi);
    leaf[i].middle = lo[axis] / 2 + hi[axis] / 2;
  }
  qsort(leaf + first, count, sizeof *leaf, by_middle);
  const uint32_t left = tree->nodes, half = count / 2;
  tree->nodes += 2;
  n->left = left, n->count = 0;
  plant(w, tree, leaf, left, first, half);
  plant(w, tree, leaf, left + 1, first + half, count - half);
}

void ref_plant(world *w) {
  size_t all = 0, n = 0;
  bool moves = false;
  for (uint32_t i = 0; i < w->n; i++) all += w->m[i].nt, moves |= w->m[i].keys > 1;
  free(w->tree);
  w->tree = NULL;
  if (!all) return;
  struct ref_tree *tree = malloc(sizeof *tree + (2 * all + 1) * sizeof(ref_node) + (all + 1) * sizeof *tree->order);
  ref_leaf *leaf = malloc((all + 1) * sizeof *leaf);
  if (!tree || !leaf) abort();
  for (uint32_t i = 0; i < w->n; i++)
    for (uint32_t j = 0; j < w->m[i].nt; j++) leaf[n].at[0] = i, leaf[n++].at[1] = j;
  tree->node = (ref_node *)(tree + 1), tree->order = (uint32_t(*)[2])(tree->node + 2 * all + 1);
  tree->nodes = 1, tree->moves = moves;
  plant(w, tree, leaf, 0, 0, (uint32_t)n);
  for (size_t i = 0; i < n; i++) memcpy(tree->order[i], leaf[i].at, sizeof leaf[i].at);
  free(leaf);
  w->tree = tree;
}

/* for (ref_walk k = walk_of(w, r); walk_next(&k);) looks at triangle k.triangle of mesh k.mesh. */
typedef struct ref_walk {
  const world *w;
  const pktrt_ray *r;
  uint32_t mesh, triangle, next, end, sp, stack[64];
  double o[3], inverse[3], pad; /* pad: as far as it is known before the node is */
} ref_walk;

static double most_of(double a, double b) { return a > b ? a : b; }
static double least_of(double a, double b) { return a < b ? a : b; }

static ref_walk walk_of(const world *w, const pktrt_ray *r) {
  ref_walk k;
  double O = 0;
  k.w = w, k.r = r, k.mesh = 0, k.triangle = UINT32_MAX, k.next = k.end = 0, k.sp = 1, k.stack[0] = 0;
  for (int a = 0; a < 3; a++) {
    const double d = (double)r->direction[a];
    k.o[a] = (double)r->origin[a], k.inverse[a] = d != 0 ? 1 / d : 0, O = most_of(O, fabs(k.o[a]));
  }
  k.pad = (w->tree && w->tree->moves ? 0x1p-21 * O : 0) + 0x1p-140;
  return k;
}

/* The line of the ray, and a box made wider. */
static bool line_meets(const ref_node *n, const ref_walk *k) {
  double lo[3], hi[3], M = 0, from = -INFINITY, to = INFINITY;
  for (int a = 0; a < 3; a++) {
    lo[a] = (double)n->lo[a] - k->o[a], hi[a] = (double)n->hi[a] - k->o[a];
    M = most_of(M, most_of(fabs(lo[a]), fabs(hi[a])));
  }
  const double pad = 0x1p-20 * M + k->pad;
  for (int a = 0; a < 3; a++) {
    const double l = lo[a] - pad, h = hi[a] + pad;
    if (k->r->direction[a] == 0) {
      if (l > 0 || h < 0) return false;
      continue;
    }
    const double x = l * k->inverse[a], y = h * k->inverse[a];
    from = most_of(from, least_of(x, y)), to = least_of(to, most_of(x, y));
  }
  return from <= to;
}

static bool walk_next(ref_walk *k) {
  const struct ref_tree *tree = k->w->tree;
  if (!tree) {
    for (k->triangle++; k->mesh < k->w->n; k->mesh++, k->triangle = 0)
      if (k->triangle < k->w->m[k->mesh].nt) return true;
    return false;
  }
  while (k->next == k->end) {
    if (!k->sp) return false;
    const ref_node *n = &tree->node[k->stack[--k->sp]];
    if (!line_meets(n, k)) continue;
    if (n->count) k->next = n->first, k->end = n->first + n->count;
    else k->stack[k->sp++] = n->left + 1, k->stack[k->sp++] = n->left;
  }
  k->mesh = tree->order[k->next][0], k->triangle = tree->order[k->next++][1];
  return true;
}

/* Not a hit until something is found. */
static void miss(const pktrt_ray *r, pktrt_hit *h) {
  memset(h, 0, sizeof *h);
  h->t = r->tmax;
  h->mesh = h->triangle = PKTRT_NONE;
}

static void corners(const mesh *m, uint32_t t, float time, float v[3][3]) {
  for (int c = 0; c < 3; c++) ref_vertex(m, m->i[t * 3 + (uint32_t)c], time, v[c]);
}

/* What a hit says, by the formula of >>exactness in pktrt.h: in doubles where their derived error is small enough, else
   the exact values, rounded. Which triangles are hit is the oracle's. */
typedef struct seen {
  double x, y, z;
} seen;

static double most_of3(double a, double b, double c) { return fmax(fabs(a), fmax(fabs(b), fabs(c))); }

DIVIDES_BY_ZERO static void solve(const pktrt_ray *r, float v[3][3], pktrt_hit *h) {
  const int k = oracle_main_axis(r->direction), u = (k + 1) % 3, w = (k + 2) % 3;
  const double dk = (double)r->direction[k], du = (double)r->direction[u], dw = (double)r->direction[w];
  seen s[3];
  for (int c = 0; c < 3; c++) {
    const double pu = (double)v[c][u] - (double)r->origin[u], pw = (double)v[c][w] - (double)r->origin[w];
    const double pk = (double)v[c][k] - (double)r->origin[k];
    const double pudk = pu * dk, pkdu = du * pk, pwdk = pw * dk, pkdw = dw * pk;
    s[c].x = pudk - pkdu, s[c].y = pwdk - pkdw, s[c].z = pk;
  }
  double edge[3], depth = 0;
  for (int c = 0; c < 3; c++) {
    const seen *a = &s[(c + 2) % 3], *b = &s[(c + 1) % 3];
    const double one = a->x * b->y, other = a->y * b->x;
    edge[c] = one - other;
  }
  for (int c = 0; c < 3; c++) {
    const double part = edge[c] * s[c].z;
    depth = c ? depth + part : part;
  }
  const double det = (edge[0] + edge[1]) + edge[2];
  const double X = most_of3(s[0].x, s[1].x, s[2].x), Y = most_of3(s[0].y, s[1].y, s[2].y);
  const double lo = fmin(s[0].z, fmin(s[1].z, s[2].z)), hi = fmax(s[0].z, fmax(s[1].z, s[2].z));
  const double Z = fmax(hi, -lo) * fabs(dk);
  const double e = 0x1p-53, xy = (16 * e * X) * Y, sum = X + Y, far_ = 32 * e * Z, zs = (8 * e * Z) * (sum + far_);
  const double error = xy + zs;
  const bool calm = error < fabs(det) * 0x1p-6 && error * (hi - lo) < fabs(depth) * 0x1p-29;
  const bool fine = error < fabs(det) * 0x1p-25;
  double exact[3] = {0, 0, 0};
  if (!calm || !fine) oracle_solve(r, v, exact);
  const double detdk = det * dk, inverse = 1 / detdk, unit = dk * inverse;
  const double t = calm ? depth * inverse : exact[0];
  h->t = fabs(t) < 0x1.ffffffp127 ? (float)t : INFINITY;
  h->u = (float)(fine ? edge[1] * unit : exact[1]), h->v = (float)(fine ? edge[2] * unit : exact[2]);
  if (h->u < 0) h->u = 0;
  if (h->v < 0) h->v = 0;
  if ((1 - h->u) - h->v >= 0) return;
  /* The larger of the two becomes the largest float that will do. */
  float *const down = h->u < h->v ? &h->v : &h->u;
  const float other = h->u < h->v ? h->u : h->v;
  *down = 1 - other;
  if ((1 - h->u) - h->v < 0) *down = (1 - other) - 0x1p-24f;
}

static void give_normal(float v[3][3], float normal[3]) {
  double a[3], b[3], n[3];
  for (int k = 0; k < 3; k++) a[k] = (double)v[1][k] - (double)v[0][k], b[k] = (double)v[2][k] - (double)v[0][k];
  for (int k = 0; k < 3; k++) {
    const double x = a[(k + 1) % 3] * b[(k + 2) % 3], y = a[(k + 2) % 3] * b[(k + 1) % 3];
    n[k] = x - y;
  }
  const double sizes = most_of3(a[0], a[1], a[2]) * most_of3(b[0], b[1], b[2]);
  const bool calm = sizes * 0x1p-27 < most_of3(n[0], n[1], n[2]);
  if (!calm) oracle_normal(v, n);
  const double largest = most_of3(n[0], n[1], n[2]);
  for (int k = 0; k < 3 && !calm; k++) n[k] /= largest;
  const double unit = 1 / sqrt((n[0] * n[0] + n[1] * n[1]) + n[2] * n[2]);
  for (int k = 0; k < 3; k++) normal[k] = (float)(n[k] * unit);
}

/* Ties go to the lower mesh, then the lower triangle. */
static bool nearer(const ref_walk *k, float t, const pktrt_hit *h) {
  if (t != h->t || h->mesh == PKTRT_NONE) return t < h->t;
  return k->mesh != h->mesh ? k->mesh < h->mesh : k->triangle < h->triangle;
}

bool ref_intersect(const world *w, const pktrt_ray *r, pktrt_hit *h) {
  miss(r, h);
  if (!ref_valid(r)) return false;
  for (ref_walk k = walk_of(w, r); walk_next(&k);) {
    float v[3][3];
    pktrt_hit at;
    corners(&w->m[k.mesh], k.triangle, r->time, v);
    if (!oracle_crosses(r, v)) continue;
    solve(r, v, &at);
    if (!(at.t > r->tmin && at.t < r->tmax) || !nearer(&k, at.t, h)) continue;
    give_normal(v, h->normal);
    h->t = at.t, h->u = at.u, h->v = at.v, h->mesh = k.mesh, h->triangle = k.triangle;
  }
  return h->mesh != PKTRT_NONE;
}

/* --- controls --- */

static void sub(const float a[3], const float b[3], float out[3]) {
  for (int k = 0; k < 3; k++) out[k] = a[k] - b[k];
}
static void cross(const float a[3], const float b[3], float out[3]) {
  for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

bool plain_moller_trumbore(const pktrt_ray *r, float v[3][3], float *t, float *u, float *w) {
  float e1[3], e2[3], p[3], q[3], s[3];
  sub(v[1], v[0], e1), sub(v[2], v[0], e2), sub(r->origin, v[0], s);
  cross(r->direction, e2, p);
  float det = dot3(e1, p);
  if (det == 0) return false;
  float inverse = 1 / det;
  *u = dot3(s, p) * inverse;
  cross(s, e1, q);
  *w = dot3(r->direction, q) * inverse;
  *t = dot3(e2, q) * inverse;
  return *u >= 0 && *w >= 0 && *u + *w <= 1;
}

DIVIDES_BY_ZERO bool plain_kensler_shirley(const pktrt_ray *r, float v[3][3], float *t, float *u, float *w) {
  float e0[3], e1[3], n[3], c[3], i[3];
  sub(v[1], v[0], e0), sub(v[0], v[2], e1), sub(v[0], r->origin, c);
  cross(e1, e0, n);
  float inverse = 1 / dot3(n, r->direction);
  cross(r->direction, c, i);
  *u = dot3(i, e1) * inverse;
  *w = dot3(i, e0) * inverse;
  *t = dot3(c, n) * inverse;
  return *u >= 0 && *w >= 0 && *u + *w <= 1;
}

typedef bool plain_test(const pktrt_ray *, float v[3][3], float *, float *, float *);

static bool plain(const world *w, const pktrt_ray *r, pktrt_hit *h, plain_test *test) {
  miss(r, h);
  if (!ref_valid(r)) return false;
  for (ref_walk k = walk_of(w, r); walk_next(&k);) {
    float v[3][3], t, bu, bv;
    corners(&w->m[k.mesh], k.triangle, r->time, v);
    if (!test(r, v, &t, &bu, &bv) || !(t > r->tmin && t < r->tmax) || !nearer(&k, t, h)) continue;
    h->t = t, h->u = bu, h->v = bv, h->mesh = k.mesh, h->triangle = k.triangle;
  }
  return h->mesh != PKTRT_NONE;
}

bool ref_moller_trumbore(const world *w, const pktrt_ray *r, pktrt_hit *h) {
  return plain(w, r, h, plain_moller_trumbore);
}
bool ref_kensler_shirley(const world *w, const pktrt_ray *r, pktrt_hit *h) {
  return plain(w, r, h, plain_kensler_shirley);
}
