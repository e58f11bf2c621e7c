/* The truth, in plain loops over all triangles: the canonical test, an ideal double oracle with derived error intervals,
   and two textbook tests in float that serve as controls. Independent of the header's implementation. */
#include "meshes.h"

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
   A binary tree over the boxes of the triangles, at all keys together, cut at medians. What the functions below look at a
   triangle with, x = p_u - S_u p_k and y alike, is off by less than 10 e M from the ideal, e = 2^-24, M the largest |p|, and
   vertices between keys by 5/2 e (|o| + M): boxes passed at more than 2^-20 M, or 2^-20 M + 2^-21 |o|, are passed for sure. */
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

static bool normal_of(float v[3][3], double n[3]) {
  double a[3], b[3];
  for (int k = 0; k < 3; k++) a[k] = (double)v[1][k] - (double)v[0][k], b[k] = (double)v[2][k] - (double)v[0][k];
  for (int k = 0; k < 3; k++) {
    int i = (k + 1) % 3, j = (k + 2) % 3;
    double x = a[i] * b[j], y = a[j] * b[i];
    n[k] = x - y;
  }
  return n[0] != 0 || n[1] != 0 || n[2] != 0;
}

/* The shear of a ray: the axis of the largest direction component, slopes along the other two. */
typedef struct shear {
  int k, u, v;
  float su, sv;
} shear;

static shear shear_of(const float d[3]) {
  shear s;
  s.k = 0;
  if (fabsf(d[1]) > fabsf(d[s.k])) s.k = 1;
  if (fabsf(d[2]) > fabsf(d[s.k])) s.k = 2;
  s.u = (s.k + 1) % 3, s.v = (s.k + 2) % 3;
  s.su = d[s.u] / d[s.k], s.sv = d[s.v] / d[s.k];
  return s;
}

static bool canonical(const shear *s, const pktrt_ray *r, float v[3][3], float *t, float *bu, float *bv) {
  float x[3], y[3], z[3];
  for (int i = 0; i < 3; i++) {
    float pu = v[i][s->u] - r->origin[s->u], pv = v[i][s->v] - r->origin[s->v], pk = v[i][s->k] - r->origin[s->k];
    float xu = s->su * pk, yv = s->sv * pk;
    x[i] = pu - xu, y[i] = pv - yv, z[i] = pk;
  }
  double xa = (double)x[0], xb = (double)x[1], xc = (double)x[2], ya = (double)y[0], yb = (double)y[1],
         yc = (double)y[2];
  double u0 = xc * yb, u1 = yc * xb, v0 = xa * yc, v1 = ya * xc, w0 = xb * ya, w1 = yb * xa;
  double U = u0 - u1, V = v0 - v1, W = w0 - w1;
  if (!((U >= 0 && V >= 0 && W >= 0) || (U <= 0 && V <= 0 && W <= 0))) return false;
  double det = (U + V) + W;
  if (det == 0) return false;
  double ta = U * (double)z[0], tb = V * (double)z[1], tc = W * (double)z[2];
  double dk = (double)r->direction[s->k], inverse = 1 / (det * dk);
  *t = (float)(((ta + tb) + tc) * inverse);
  *bu = (float)(V * (dk * inverse));
  *bv = (float)(W * (dk * inverse));
  return true;
}

/* Ties go to the lower mesh, then the lower triangle. */
static bool nearer(const ref_walk *k, float t, const pktrt_hit *h) {
  if (t != h->t || h->mesh == PKTRT_NONE) return t < h->t;
  return k->mesh != h->mesh ? k->mesh < h->mesh : k->triangle < h->triangle;
}

bool ref_intersect(const world *w, const pktrt_ray *r, pktrt_hit *h) {
  miss(r, h);
  if (!ref_valid(r)) return false;
  shear s = shear_of(r->direction);
  for (ref_walk k = walk_of(w, r); walk_next(&k);) {
    float v[3][3], t, bu, bv;
    double n[3];
    corners(&w->m[k.mesh], k.triangle, r->time, v);
    if (!canonical(&s, r, v, &t, &bu, &bv) || !(t > r->tmin && t < r->tmax) || !nearer(&k, t, h) || !normal_of(v, n))
      continue;
    double size = fmax(fabs(n[0]), fmax(fabs(n[1]), fabs(n[2])));
    for (int a = 0; a < 3; a++) h->normal[a] = (float)(n[a] * (1 / size));
    h->t = t, h->u = bu, h->v = bv, h->mesh = k.mesh, h->triangle = k.triangle;
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

/* --- oracle ---
   In the ray's sheared frame (origin 0, direction along z) the ideal vertices are X = p_u - S_u p_k, Y likewise, Z = p_k with
   p = v - o. The canonical x differs from X by rounding alone: with e = 2^-24, M = max |p| and |S| <= 1 the errors are
   e M each of p_u, p_k, S and the product, and e 2M of the last difference: 6 e M and terms of e^2. So each vertex lies
   within D = sqrt(2) * 7 e M of its ideal place (plus 2^-146 for denormals).
   Inside or not: a point of the border moves by at most D, since it is a mean of corners. If the ideal border passes the
   origin at more than D, then shrinking the displacement to nothing never sweeps the border across the origin, and the
   winding number stays: ideal and canonical tests agree. Nearer than D: both answers are possible.
   Depth: an accepted canonical hit has z = sum l_i z_i with weights l_i >= 0 of sum 1 and sum l_i x_i = 0. The ideal plane
   over q = sum l_i X_i, |q| <= D, has the height sum l_i Z_i. Hence |z - Z(0)| <= |grad Z| D + e M, the ideal plane's
   gradient taken in the sheared frame; t = z / d_k is rounded to float once more. Edge-on triangles have gradients without
   bound and so intervals without end. */
typedef struct interval {
  double lo, hi;
  bool certain; /* hit for sure, at a t in [lo, hi]; else hit perhaps */
} interval;

static double segment_distance(const double a[2], const double b[2]) {
  double d[2] = {b[0] - a[0], b[1] - a[1]}, l = d[0] * d[0] + d[1] * d[1];
  double f = l > 0 ? -(a[0] * d[0] + a[1] * d[1]) / l : 0;
  f = f < 0 ? 0 : f > 1 ? 1 : f;
  return hypot(a[0] + f * d[0], a[1] + f * d[1]);
}

DIVIDES_BY_ZERO static bool ideal(const shear *s, const pktrt_ray *r, float v[3][3], interval *out) {
  double x[3][2], z[3], M = 0, n[3], dk = (double)r->direction[s->k];
  double su = (double)r->direction[s->u] / dk, sv = (double)r->direction[s->v] / dk;
  for (int i = 0; i < 3; i++) {
    double p[3];
    for (int k = 0; k < 3; k++) {
      p[k] = (double)v[i][k] - (double)r->origin[k];
      M = fmax(M, fabs(p[k]));
    }
    z[i] = p[s->k], x[i][0] = p[s->u] - su * z[i], x[i][1] = p[s->v] - sv * z[i];
  }
  if (!normal_of(v, n)) return false;
  const double e = 0x1p-24, D = 1.4143 * 7 * e * M + 0x1p-145;
  double near = fmin(segment_distance(x[0], x[1]), fmin(segment_distance(x[1], x[2]), segment_distance(x[2], x[0])));
  double area[3];
  for (int i = 0; i < 3; i++) {
    int a = (i + 1) % 3, b = (i + 2) % 3;
    area[i] = x[a][0] * x[b][1] - x[a][1] * x[b][0];
  }
  bool inside = (area[0] > 0 && area[1] > 0 && area[2] > 0) || (area[0] < 0 && area[1] < 0 && area[2] < 0);
  if (near > D && !inside) return false;
  double ax = x[1][0] - x[0][0], ay = x[1][1] - x[0][1], bx = x[2][0] - x[0][0], by = x[2][1] - x[0][1];
  double det = ax * by - ay * bx, za = z[1] - z[0], zb = z[2] - z[0];
  double gx = (za * by - zb * ay) / det, gy = (ax * zb - bx * za) / det; /* det 0: not finite, so no bound below */
  double z0 = z[0] - gx * x[0][0] - gy * x[0][1], slack = hypot(gx, gy) * D + 1.01 * e * M;
  double lo = (z0 - slack) / dk, hi = (z0 + slack) / dk;
  out->certain = near > D;
  out->lo = fmin(lo, hi), out->hi = fmax(lo, hi);
  if (!(out->hi - out->lo < INFINITY)) out->lo = -INFINITY, out->hi = INFINITY;
  /* 2^-24 for rounding to float; 1e-12 for the double of both sides */
  double more = fmax(fabs(out->lo), fabs(out->hi)) * (1.01 * e + 1e-12) + 0x1p-149;
  out->lo -= more, out->hi += more;
  return true;
}

verdict ref_oracle(const world *w, const pktrt_ray *r, const pktrt_hit *h, bool *ambiguous) {
  *ambiguous = false;
  if (!ref_valid(r)) return h->mesh == PKTRT_NONE ? VERDICT_RIGHT : VERDICT_WRONG;
  shear s = shear_of(r->direction);
  double first = INFINITY; /* the nearest certain hit is not beyond this */
  interval mine = {0, 0, false}, all[64];
  uint32_t found = 0, at[64][2];
  for (ref_walk k = walk_of(w, r); walk_next(&k);) {
    float v[3][3];
    interval x;
    corners(&w->m[k.mesh], k.triangle, r->time, v);
    if (!ideal(&s, r, v, &x) || x.hi <= (double)r->tmin || x.lo >= (double)r->tmax) continue;
    x.certain &= x.lo > (double)r->tmin && x.hi < (double)r->tmax;
    if (x.certain) first = fmin(first, x.hi);
    if (found < COUNT(all)) at[found][0] = k.mesh, at[found][1] = k.triangle, all[found++] = x;
    else *ambiguous = true;
  }
  uint32_t rivals = 0;
  bool possible = false;
  for (uint32_t c = 0; c < found; c++) {
    if (all[c].lo > first) continue;
    rivals++;
    if (!all[c].certain) *ambiguous = true;
    if (at[c][0] == h->mesh && at[c][1] == h->triangle) possible = true, mine = all[c];
  }
  *ambiguous |= rivals > 1;
  if (h->mesh == PKTRT_NONE) {
    if (first < INFINITY) return VERDICT_WRONG;
  } else if (found < COUNT(all) && !(possible && (double)h->t >= mine.lo && (double)h->t <= mine.hi)) {
    return VERDICT_WRONG;
  }
  return *ambiguous ? VERDICT_BAND : VERDICT_RIGHT;
}
