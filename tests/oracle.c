/* The oracle of oracle.h, and the tests that it has to pass itself. */
#include "oracle.h"

/* --- exact numbers ---
   A big is sign * sum word[i] 2^(32 (low + i)), without words of 0 at either end; 0 has no words. Sums, differences and products
   are exact or end the program. How many bits can be asked for: floats are multiples of 2^-149 below 2^128 in size, differences
   of two (the edges, vertices relative to the origin) below 2^129. Hence, as multiples of and below:
     cross products of two differences      2^-298    2^259       (2 products of 2^258)
     det(d, b, c), N and D                  2^-447    2^390       (3 products of 2^259 and 2^129)
     t D, u D, N / ulp's unit               2^-596    2^520       (t, u: floats; 7 D ulp and 10 |N - t D| are less)
     N D' - N' D                            2^-894    2^781
     (n . n')^2, |n|^2 |n'|^2 (2^45 - 1)^2  2^-894    2^870       (n: a float normal; (3 2^128 2^259)^2, and 90 bits more)
   The last are 1764 bits. Ends in the middle of words take up to 62 more, and before it is trimmed a result may have two words
   that it does not need: 60 words of 32 bits. */
enum { BIG_WORDS = 64 };
typedef struct big {
  int sign, low, size;
  uint32_t word[BIG_WORDS];
} big;

static const big nothing = {0, 0, 0, {0}};

static big trimmed(big a) {
  int zeros = 0;
  while (a.size > 0 && a.word[a.size - 1] == 0) a.size--;
  while (zeros < a.size && a.word[zeros] == 0) zeros++;
  if (a.size == 0) return nothing;
  for (int i = zeros; i < a.size && zeros > 0; i++) a.word[i - zeros] = a.word[i];
  a.low += zeros, a.size -= zeros;
  return a;
}

/* Makes m 2^exponent. */
static big scaled_integer(uint32_t m, int exponent) {
  const int shift = (exponent % 32 + 32) % 32;
  const uint64_t bits = (uint64_t)m << shift;
  big a;
  a.sign = 1, a.low = (exponent - shift) / 32, a.size = 2;
  a.word[0] = (uint32_t)bits, a.word[1] = (uint32_t)(bits >> 32);
  return trimmed(a);
}

static big integer(uint32_t m) { return scaled_integer(m, 0); }

static big number(float x) {
  int exponent = 0;
  const float part = frexpf(fabsf(x), &exponent);
  big a = scaled_integer((uint32_t)(part * 0x1p24f), exponent - 24);
  if (x < 0) a.sign = -1;
  return a;
}

static big minus(big a) {
  a.sign = -a.sign;
  return a;
}

static uint32_t word_at(const big *a, int position) {
  const int i = position - a->low;
  return i >= 0 && i < a->size ? a->word[i] : 0;
}

static big sum(big a, big b) {
  if (!a.sign) return b;
  if (!b.sign) return a;
  const int end_a = a.low + a.size, end_b = b.low + b.size;
  const bool same = a.sign == b.sign;
  big c;
  c.sign = a.sign, c.low = a.low < b.low ? a.low : b.low, c.size = (end_a > end_b ? end_a : end_b) - c.low + 1;
  if (c.size > BIG_WORDS) abort();
  uint64_t carry = 0; /* of a sum 0 or 1, of a difference 0 or all ones: -1 */
  for (int i = 0; i < c.size; i++) {
    const uint64_t x = word_at(&a, c.low + i), y = word_at(&b, c.low + i), s = (same ? x + y : x - y) + carry;
    c.word[i] = (uint32_t)s;
    carry = same ? s >> 32 : s >> 32 ? UINT64_MAX : 0;
  }
  if (carry) { /* |b| > |a|: the words are those of |a| - |b| + 2^(32 size) */
    c.sign = -c.sign, carry = 1;
    for (int i = 0; i < c.size; i++) {
      carry += (uint32_t)~c.word[i];
      c.word[i] = (uint32_t)carry, carry >>= 32;
    }
  }
  return trimmed(c);
}

static big difference(big a, big b) { return sum(a, minus(b)); }

static big product(big a, big b) {
  big c;
  c.sign = a.sign * b.sign, c.low = a.low + b.low, c.size = a.size + b.size;
  if (!c.sign) return nothing;
  if (c.size > BIG_WORDS) abort();
  for (int i = 0; i < c.size; i++) c.word[i] = 0;
  for (int i = 0; i < a.size; i++) {
    uint64_t carry = 0;
    for (int j = 0; j < b.size; j++) { /* (2^32 - 1)^2 + 2 (2^32 - 1) = 2^64 - 1 */
      carry += (uint64_t)a.word[i] * b.word[j] + c.word[i + j];
      c.word[i + j] = (uint32_t)carry, carry >>= 32;
    }
    c.word[i + b.size] = (uint32_t)carry;
  }
  return trimmed(c);
}

static big times_power(big a, int exponent) { return product(a, scaled_integer(1, exponent)); }
static bool at_most(big a, big b) { return difference(a, b).sign <= 0; }
static big size_of(big a) {
  a.sign = a.sign != 0;
  return a;
}

/* Finds the e of 2^(e - 1) <= |a| < 2^e. */
static int length(const big *a) {
  int bits = 32 * (a->low + a->size - 1);
  for (uint32_t top = a->word[a->size - 1]; top; top >>= 1) bits++;
  return bits;
}

/* Rounds |a|, with an error below 2^-52 of it: two words below the top one hold more than 64 bits of it. */
static double nearly(const big *a) {
  double x = 0;
  for (int i = 1; i <= 3 && i <= a->size; i++) x += ldexp((double)a->word[a->size - i], 32 * (a->low + a->size - i));
  return x;
}

/* --- vectors of them --- */

static void differences(const float a[3], const float b[3], big out[3]) {
  for (int k = 0; k < 3; k++) out[k] = difference(number(a[k]), number(b[k]));
}

static void cross_product(big a[3], big b[3], big out[3]) {
  for (int k = 0; k < 3; k++) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    out[k] = difference(product(a[i], b[j]), product(a[j], b[i]));
  }
}

static big dot_product(big a[3], big b[3]) {
  return sum(sum(product(a[0], b[0]), product(a[1], b[1])), product(a[2], b[2]));
}

static big determinant(big a[3], big b[3], big c[3]) {
  big n[3];
  cross_product(b, c, n);
  return dot_product(a, n);
}

static void exact_normal(float p[3][3], big n[3]) {
  big a[3], b[3];
  differences(p[1], p[0], a), differences(p[2], p[0], b);
  cross_product(a, b, n);
}

static void numbers(const float a[3], big out[3]) {
  for (int k = 0; k < 3; k++) out[k] = number(a[k]);
}

/* --- crossings ---
   With corners relative to the origin, det(d, b, c) = d . (b x c) is the sign of the side of the edge from b to c on which the
   line passes. The three of a triangle sum up to d . n (the products of b x c + c x a + a x b), hence all are > 0 where the line
   leaves through the triangle and all < 0 where it enters. The origin displaced by s makes corners b - s and c - s:
     d . ((b - s) x (c - s)) = d . (b x c) - d . (s x (c - b)) = d . (b x c) - s . ((c - b) x d).
   So with s = e along u and e^2 along v the sign is that of det(d, b, c); where this is 0, of -((c - b) x d)_u; where this is 0,
   of -((c - b) x d)_v. Where all are 0, c - b is along d: of a vector across d, u and v tell whether it is 0, as d_k is not.
   Exchanging b and c changes the sign of each. The sum stays d . n whatever s, so a triangle with d . n = 0 is never crossed. */
int oracle_main_axis(const float d[3]) {
  int k = 0;
  for (int a = 1; a < 3; a++) k = fabsf(d[a]) > fabsf(d[k]) ? a : k;
  return k;
}

static int edge_sign(const pktrt_ray *r, const float p[3], const float q[3]) {
  const int k = oracle_main_axis(r->direction);
  big d[3], b[3], c[3], turn[3];
  numbers(r->direction, d), differences(p, r->origin, b), differences(q, r->origin, c);
  const int plain = determinant(d, b, c).sign;
  if (plain) return plain;
  differences(q, p, b);
  cross_product(b, d, turn);
  const int first = -turn[(k + 1) % 3].sign, second = -turn[(k + 2) % 3].sign;
  return first ? first : second;
}

/* Tells the sign of det(d, b, c) where doubles do, else 0. Differences of floats have a relative error of 2^-53 and are 0 or at
   least 2^-149, products of three of them at least 2^-447 and sums below 2^390: nothing leaves the range of double. Each of six
   products goes through 2 differences, 2 multiplications, and 3 additions, so the value is off by less than 7.01 2^-53 of the sum
   of the products' sizes; that sum itself, rounded as often, is off by as little of itself. 2^-49 is 16 2^-53. */
static int quick_sign(const double d[3], const double b[3], const double c[3], double *value) {
  double x = 0, size = 0;
  for (int k = 0; k < 3; k++) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double y = b[i] * c[j], z = b[j] * c[i];
    x += d[k] * (y - z), size += fabs(d[k]) * (fabs(y) + fabs(z));
  }
  *value = x;
  return x > 0x1p-49 * size ? 1 : -x > 0x1p-49 * size ? -1 : 0;
}

static void relative(const pktrt_ray *r, float p[3][3], double d[3], double b[3][3]) {
  for (int k = 0; k < 3; k++) d[k] = (double)r->direction[k];
  for (int c = 0; c < 3; c++)
    for (int k = 0; k < 3; k++) b[c][k] = (double)p[c][k] - (double)r->origin[k];
}

static int same_sign(const int s[3]) { return s[0] == s[1] && s[1] == s[2] ? s[0] : 0; }

int oracle_crosses(const pktrt_ray *r, float p[3][3]) {
  double d[3], b[3][3], value;
  int s[3];
  relative(r, p, d, b);
  for (int c = 0; c < 3; c++) {
    s[c] = quick_sign(d, b[(c + 1) % 3], b[(c + 2) % 3], &value);
    for (int before = 0; before < c; before++)
      if (s[c] * s[before] < 0) return 0;
  }
  for (int c = 0; c < 3; c++)
    if (!s[c]) s[c] = edge_sign(r, p[(c + 1) % 3], p[(c + 2) % 3]);
  return same_sign(s);
}

/* --- depth --- */

typedef struct depth {
  big N, D; /* t = N / D, D > 0; D = 0: none */
} depth;

static depth exact_depth(const pktrt_ray *r, float p[3][3]) {
  depth x;
  big n[3], d[3], b[3];
  exact_normal(p, n), numbers(r->direction, d), differences(p[0], r->origin, b);
  x.N = dot_product(n, b), x.D = dot_product(n, d);
  if (x.D.sign < 0) x.N = minus(x.N), x.D = minus(x.D);
  return x;
}

/* Finds the exponent of t's ulp, and the e of 2^e <= |t| < 2^(e + 1), or -126 if that is more. By their lengths N / D is within
   2^(e - 1) and 2^(e + 1). */
static int ulp_exponent(const depth *x) {
  int e = -126;
  if (x->N.sign) {
    const int about = length(&x->N) - length(&x->D);
    e = at_most(times_power(x->D, about), size_of(x->N)) ? about : about - 1;
  }
  return (e < -126 ? -126 : e) - 23;
}

bool oracle_t_is_right(const pktrt_ray *r, float p[3][3], float t) {
  const depth x = exact_depth(r, p);
  if (!x.D.sign || !isfinite(t)) return false;
  const big off = size_of(difference(x.N, product(number(t), x.D)));
  return at_most(product(off, integer(10)), product(times_power(x.D, ulp_exponent(&x)), integer(7)));
}

static float float_of(double x) { return x < 0x1p128 ? (float)x : INFINITY; }

/* Of |t| = (q + f) ulps, with f = rest / unit and 0 <= f < 1, tells which floats are within 0.7 ulps: q for f <= 0.7, q + 1 for
   f >= 0.3, and q - 1/2 for f <= 0.2, if q is a power of two that has nearer floats below it. Others are not: q + 1 at most is the
   next power of two, and both q - 1 and q + 2 are an ulp or more away. */
bool oracle_t_range(const pktrt_ray *r, float p[3][3], float *least, float *most) {
  const depth x = exact_depth(r, p);
  if (!x.D.sign) return false;
  const int exponent = ulp_exponent(&x);
  const big size = size_of(x.N), unit = times_power(x.D, exponent);
  uint32_t q = (uint32_t)(nearly(&size) / nearly(&unit)); /* below 2^24 and some; may be wrong by one */
  big rest = difference(size, product(unit, integer(q)));
  for (; rest.sign < 0; q--) rest = sum(rest, unit);
  for (; at_most(unit, rest); q++) rest = difference(rest, unit);
  const big tenths = product(rest, integer(10));
  double lo = q, hi = q;
  if (at_most(product(unit, integer(3)), tenths)) hi++;
  if (!at_most(tenths, product(unit, integer(7)))) lo++;
  if (q == 1u << 23 && exponent > -149 && at_most(tenths, product(unit, integer(2)))) lo -= 0.5;
  const float near = float_of(ldexp(lo, exponent)), far = float_of(ldexp(hi, exponent));
  *least = x.N.sign < 0 ? -far : near, *most = x.N.sign < 0 ? -near : far;
  return true;
}

int oracle_t_sign(const pktrt_ray *r, float p[3][3]) { return exact_depth(r, p).N.sign; }

int oracle_compare(const pktrt_ray *r, float p[3][3], float q[3][3]) {
  const depth x = exact_depth(r, p), y = exact_depth(r, q);
  return difference(product(x.N, y.D), product(y.N, x.D)).sign;
}

/* --- the rest of a hit --- */

/* Finds the weight of corner c (1 or 2) as weight / D: the share of det(d, p2, p0), det(d, p0, p1) in their sum, d . n. */
static void exact_weight(const pktrt_ray *r, float p[3][3], int c, big *weight, big *D) {
  big d[3], n[3], a[3], b[3];
  numbers(r->direction, d), exact_normal(p, n);
  differences(p[(c + 1) % 3], r->origin, a), differences(p[(c + 2) % 3], r->origin, b);
  *weight = determinant(d, a, b), *D = dot_product(n, d);
}

bool oracle_uv_is_right(const pktrt_ray *r, float p[3][3], float u, float v) {
  const float given[3] = {0, u, v};
  for (int c = 1; c < 3; c++) {
    big weight, D;
    exact_weight(r, p, c, &weight, &D);
    if (!D.sign || !isfinite(given[c])) return false;
    const big off = size_of(difference(product(number(given[c]), D), weight));
    if (!at_most(times_power(off, 23), size_of(D))) return false;
  }
  return true;
}

/* An exact quotient, rounded twice in each part and once more. */
static double quotient(const big *a, const big *b) { return a->sign ? a->sign * b->sign * (nearly(a) / nearly(b)) : 0; }

void oracle_solve(const pktrt_ray *r, float p[3][3], double tuv[3]) {
  const depth x = exact_depth(r, p);
  tuv[0] = quotient(&x.N, &x.D);
  for (int c = 1; c < 3; c++) {
    big weight, D;
    exact_weight(r, p, c, &weight, &D);
    tuv[c] = quotient(&weight, &D);
  }
}

void oracle_normal(float p[3][3], double normal[3]) {
  big n[3];
  exact_normal(p, n);
  for (int k = 0; k < 3; k++) normal[k] = n[k].sign ? n[k].sign * nearly(&n[k]) : 0;
}

/* Of unit vectors a and b, |a - b|^2 = 2 - 2 a . b is at most 2^-44 where a . b >= 1 - 2^-45: where x . n > 0 and
   2^90 (x . n)^2 >= (2^45 - 1)^2 |x|^2 |n|^2. */
bool oracle_normal_is_right(float p[3][3], const float normal[3]) {
  big n[3], x[3];
  for (int k = 0; k < 3; k++)
    if (!isfinite(normal[k])) return false;
  exact_normal(p, n), numbers(normal, x);
  const big along = dot_product(x, n);
  if (along.sign <= 0) return false;
  const big cosine = difference(scaled_integer(1, 45), integer(1));
  const big least = product(product(cosine, cosine), product(dot_product(x, x), dot_product(n, n)));
  return at_most(least, times_power(product(along, along), 90));
}

/* --- many triangles --- */

oracle_soup oracle_soup_of(const world *w, float time) {
  oracle_soup s = {NULL, NULL, 0, NULL};
  for (uint32_t m = 0; m < w->n; m++) s.n += w->m[m].nt;
  s.p = calloc(s.n + 1, sizeof *s.p), s.name = calloc(s.n + 1, sizeof *s.name);
  if (!s.p || !s.name) abort();
  oracle_soup_move(&s, w, time);
  return s;
}

void oracle_soup_move(oracle_soup *s, const world *w, float time) {
  size_t at = 0;
  for (uint32_t m = 0; m < w->n; m++)
    for (uint32_t t = 0; t < w->m[m].nt; t++, at++) {
      for (uint32_t c = 0; c < 3; c++) ref_vertex(&w->m[m], w->m[m].i[3 * t + c], time, s->p[at][c]);
      s->name[at][0] = m, s->name[at][1] = t;
    }
  free(s->tree);
  s->tree = NULL;
}

void oracle_soup_free(oracle_soup *s) {
  free(s->p), free(s->name), free(s->tree);
  memset(s, 0, sizeof *s);
}

/* A binary tree of boxes, cut where half of the triangles' middles lie on either side. */
typedef struct tree_node {
  float lo[3], hi[3];
  uint32_t left, first, count; /* children left, left + 1; a leaf where count > 0 */
} tree_node;

struct oracle_tree {
  tree_node *node;
  uint32_t *order, nodes;
};

typedef struct tree_leaf {
  float middle;
  uint32_t triangle;
} tree_leaf;

static int by_middle(const void *a, const void *b) {
  const tree_leaf *x = a, *y = b;
  return x->middle < y->middle ? -1 : x->middle > y->middle;
}

static void grow(tree_node *n, float p[3][3]) {
  for (int c = 0; c < 3; c++)
    for (int k = 0; k < 3; k++) n->lo[k] = fminf(n->lo[k], p[c][k]), n->hi[k] = fmaxf(n->hi[k], p[c][k]);
}

static void plant(const oracle_soup *s, struct oracle_tree *tree, tree_leaf *leaf, uint32_t at) {
  tree_node *n = &tree->node[at];
  for (int k = 0; k < 3; k++) n->lo[k] = INFINITY, n->hi[k] = -INFINITY;
  for (uint32_t i = n->first; i < n->first + n->count; i++) grow(n, s->p[leaf[i].triangle]);
  if (n->count <= 4) return;
  int axis = 0;
  for (int k = 1; k < 3; k++) axis = n->hi[k] - n->lo[k] > n->hi[axis] - n->lo[axis] ? k : axis;
  for (uint32_t i = n->first; i < n->first + n->count; i++) {
    float(*p)[3] = s->p[leaf[i].triangle];
    leaf[i].middle = p[0][axis] / 3 + p[1][axis] / 3 + p[2][axis] / 3;
  }
  qsort(leaf + n->first, n->count, sizeof *leaf, by_middle);
  tree_node *child = &tree->node[n->left = tree->nodes];
  tree->nodes += 2;
  child[0].first = n->first, child[0].count = n->count / 2;
  child[1].first = n->first + n->count / 2, child[1].count = n->count - n->count / 2;
  n->count = 0;
  plant(s, tree, leaf, n->left);
  plant(s, tree, leaf, n->left + 1);
}

void oracle_plant(oracle_soup *s) {
  free(s->tree);
  s->tree = NULL;
  if (!s->n) return;
  struct oracle_tree *tree = malloc(sizeof *tree + 2 * s->n * sizeof *tree->node + s->n * sizeof *tree->order);
  tree_leaf *leaf = malloc(s->n * sizeof *leaf);
  if (!tree || !leaf) abort();
  tree->node = (tree_node *)(tree + 1), tree->order = (uint32_t *)(tree->node + 2 * s->n), tree->nodes = 1;
  for (uint32_t i = 0; i < s->n; i++) leaf[i].triangle = i;
  tree->node[0].first = 0, tree->node[0].count = (uint32_t)s->n;
  plant(s, tree, leaf, 0);
  for (uint32_t i = 0; i < s->n; i++) tree->order[i] = leaf[i].triangle;
  free(leaf);
  s->tree = tree;
}

/* Tells whether the line may meet a closed box; a line that does not is a finite way off, displaced or not. Each quotient by d,
   of a difference and a reciprocal that are rounded and the product of these, is off by less than 4 2^-53 of itself, hence the
   2^-50; between 2^-277 and 2^278 nothing leaves the range of double. */
static bool line_may_meet(const tree_node *n, const pktrt_ray *r, const double inverse[3]) {
  double from = -INFINITY, to = INFINITY;
  for (int k = 0; k < 3; k++) {
    const double o = (double)r->origin[k], lo = (double)n->lo[k] - o, hi = (double)n->hi[k] - o;
    if (r->direction[k] == 0) {
      if (lo > 0 || hi < 0) return false;
      continue;
    }
    const double x = lo * inverse[k], y = hi * inverse[k], least = x < y ? x : y, most = x < y ? y : x;
    const double early = least - 0x1p-50 * fabs(least), late = most + 0x1p-50 * fabs(most);
    from = early > from ? early : from, to = late < to ? late : to;
  }
  return from <= to;
}

static void add_if_crossed(const oracle_soup *s, const pktrt_ray *r, uint32_t i, oracle_list *out) {
  oracle_crossing c;
  c.triangle = i, c.sign = oracle_crosses(r, s->p[i]), c.near = false;
  if (!c.sign) return;
  oracle_t_range(r, s->p[i], &c.least, &c.most);
  c.ahead = oracle_t_sign(r, s->p[i]);
  if (out->n == out->room) {
    out->room = 2 * out->room + 8;
    out->at = realloc(out->at, out->room * sizeof *out->at);
    if (!out->at) abort();
  }
  out->at[out->n++] = c;
}

static bool has_a_line(const pktrt_ray *r) {
  bool some = false;
  for (int k = 0; k < 3; k++) {
    if (!(fabsf(r->origin[k]) <= 0x1p100f) || !isfinite(r->direction[k])) return false;
    some |= r->direction[k] != 0;
  }
  return some;
}

/* Where all right floats of one are below those of the other, so is its t: the float nearest to t, which never falls as t rises,
   is among the right ones. */
static bool comes_before(const oracle_soup *s, const pktrt_ray *r, const oracle_crossing *a, const oracle_crossing *b) {
  if (a->most < b->least) return true;
  if (b->most < a->least) return false;
  const int order = oracle_compare(r, s->p[a->triangle], s->p[b->triangle]);
  return order ? order < 0 : a->triangle < b->triangle;
}

static void sort(const oracle_soup *s, const pktrt_ray *r, oracle_list *list) {
  for (size_t i = 1; i < list->n; i++) {
    const oracle_crossing c = list->at[i];
    size_t j = i;
    for (; j > 0 && comes_before(s, r, &c, &list->at[j - 1]); j--) list->at[j] = list->at[j - 1];
    list->at[j] = c;
  }
  float least = INFINITY; /* of those behind */
  for (size_t i = list->n; i-- > 0;) {
    list->at[i].near = i + 1 < list->n && list->at[i].most >= least;
    least = fminf(least, list->at[i].least);
  }
}

size_t oracle_crossings(const oracle_soup *s, const pktrt_ray *r, oracle_list *out) {
  out->n = 0;
  if (!has_a_line(r)) return 0;
  if (!s->tree) {
    for (uint32_t i = 0; i < s->n; i++) add_if_crossed(s, r, i, out);
  } else {
    double inverse[3];
    uint32_t stack[64] = {0}, height = 1; /* halves of 2^32 triangles: 32 levels */
    for (int k = 0; k < 3; k++) inverse[k] = r->direction[k] != 0 ? 1 / (double)r->direction[k] : 0;
    while (height) {
      const tree_node *n = &s->tree->node[stack[--height]];
      if (!line_may_meet(n, r, inverse)) continue;
      for (uint32_t i = 0; i < n->count; i++) add_if_crossed(s, r, s->tree->order[n->first + i], out);
      if (!n->count) stack[height++] = n->left + 1, stack[height++] = n->left;
    }
  }
  sort(s, r, out);
  return out->n;
}

void oracle_list_free(oracle_list *list) {
  free(list->at);
  memset(list, 0, sizeof *list);
}

/* --- answers --- */

int oracle_winding(const oracle_list *list) {
  int winding = 0;
  for (size_t i = 0; i < list->n; i++) winding += list->at[i].ahead > 0 ? list->at[i].sign : 0;
  return winding;
}

/* Tells whether a crossing must be a hit, or can be one, whichever right float it has. Those within (tmin, tmax) are compared as
   floats, and with infinity, which no tmax is above. */
static bool must_hit(const pktrt_ray *r, const oracle_crossing *c) { return c->least > r->tmin && c->most < r->tmax; }

static bool can_hit(const pktrt_ray *r, const oracle_crossing *c) {
  const float next = nextafterf(r->tmin, INFINITY);
  const float t = c->least > next ? c->least : next; /* the least t that is right and above tmin */
  return r->tmin < r->tmax && t <= c->most && t < r->tmax;
}

void oracle_count(const pktrt_ray *r, const oracle_list *list, size_t *least, size_t *most) {
  *least = *most = 0;
  for (size_t i = 0; i < list->n && r->tmin < r->tmax; i++)
    *least += must_hit(r, &list->at[i]), *most += can_hit(r, &list->at[i]);
}

static const oracle_crossing *find(const oracle_soup *s, const oracle_list *list, const pktrt_hit *h) {
  for (size_t i = 0; i < list->n; i++) {
    const uint32_t *name = s->name[list->at[i].triangle];
    if (name[0] == h->mesh && name[1] == h->triangle) return &list->at[i];
  }
  return NULL;
}

/* Orders by t, mesh and triangle. */
static bool hit_before(const pktrt_hit *a, const pktrt_hit *b) {
  if (a->t != b->t) return a->t < b->t;
  return a->mesh != b->mesh ? a->mesh < b->mesh : a->triangle < b->triangle;
}

static const char *objection_to(const oracle_soup *s, const pktrt_ray *r, const oracle_list *list, const pktrt_hit *h) {
  const oracle_crossing *c = find(s, list, h);
  if (!(h->t > r->tmin && h->t < r->tmax)) return "t is not within tmin and tmax";
  if (!c) return "the triangle is not crossed";
  if (!(h->t >= c->least && h->t <= c->most)) return "t is off by more than 0.7 ulp";
  if (!oracle_uv_is_right(r, s->p[c->triangle], h->u, h->v)) return "u or v is off by more than 2^-23";
  if (!oracle_normal_is_right(s->p[c->triangle], h->normal)) return "the normal is off by more than 4 * 2^-24";
  return NULL;
}

const char *oracle_objection(const oracle_soup *s, const pktrt_ray *r, const oracle_list *list, const pktrt_hit *hits,
    size_t n, size_t capacity) {
  if (n > capacity) return "there are more hits than asked for";
  for (size_t i = 0; i < n; i++) {
    const char *what = objection_to(s, r, list, &hits[i]);
    if (what) return what;
    if (i && !hit_before(&hits[i - 1], &hits[i])) return "hits are not in order";
    for (size_t j = 0; j < i; j++)
      if (hits[i].mesh == hits[j].mesh && hits[i].triangle == hits[j].triangle) return "a triangle is hit twice";
  }
  if (!(r->tmin < r->tmax) || capacity == 0) return NULL;
  for (size_t i = 0; i < list->n; i++) { /* those left out: beyond tmin or tmax, or after the last */
    const oracle_crossing *c = &list->at[i];
    bool listed = false;
    for (size_t j = 0; j < n && !listed; j++) listed = find(s, list, &hits[j]) == c;
    if (listed || !must_hit(r, c)) continue;
    pktrt_hit latest;
    latest.t = c->most, latest.mesh = s->name[c->triangle][0], latest.triangle = s->name[c->triangle][1];
    if (n < capacity) return "a crossing is missing";
    if (!hit_before(&hits[n - 1], &latest)) return "a nearer crossing is left out";
  }
  return NULL;
}

bool oracle_accepts(const oracle_soup *s, const pktrt_ray *r, const oracle_list *list, const pktrt_hit *hits, size_t n,
    size_t capacity) {
  return oracle_objection(s, r, list, hits, n, capacity) == NULL;
}
