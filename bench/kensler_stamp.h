/* kensler_stamp.h - the triangle test of Kensler and Shirley (2006) beside pktrt's, on the same vectors. No
   include guard: pktrt.h includes it once for each instruction set (PK_ALSO_STAMP), where its vectors (>>ops),
   blocks and batches are at hand: nothing but the test differs.

   For a ray o + t d and a triangle with corners p0, p1, p2, let e0 = p1 - p0, e1 = p0 - p2, n = e0 x e1, r = p0 - o and
   i = r x d. Then, by Cramer's rule on t d - beta e0 + gamma e1 = r,

       D = n.d      beta = e1.i / D      gamma = e0.i / D      t = n.r / D

   with the point at p0 + beta (p1 - p0) + gamma (p2 - p0). Two crosses serve everything; what needs no ray comes first.
   It is hit if beta, gamma and 1 - beta - gamma are not negative: if the three numerators have one sign. So nothing is
   divided until a lane has passed, as in pktrt. Sums of products are fused where the machine can; pktrt must not. */
#if !defined KENSLER_COURSE && !defined KENSLER_ALONE /* the same for all stamps */
#define KENSLER_COURSE

typedef struct visit {              /* a ray of a batch (groups: the first of eight) meets a leaf */
  uint32_t ray, block, bits, order; /* bits: of a group, those that meet it; order: of visits of one ray or group */
} visit;

typedef struct depths { /* how far the rays of a batch look before they hit anything */
  float depth_hi[PK_ROW], sure_hi[PK_ROW];
} depths;

typedef struct course {
  pktrt_scene *tree; /* with one BVH */
  pk_bvh_segment seg;
  bool moving;
  size_t rays, batches;
  pk_batch *batch;
  depths *fresh;
  visit *visit[2];  /* of rays, of groups */
  size_t *start[2]; /* where the visits of a batch begin */
  size_t count[2], room;
  uint64_t tests; /* of a ray and a triangle, in one go over all visits; rays and groups make the same */
} course;

static pktrt_counts kensler_unread; /* the scalar set counts always */

typedef struct race_set {
  void (*run[2][2][2])(const course *, size_t batch); /* kensler, groups, moving */
  uint32_t (*setup)(const pktrt_scene *, pk_batch *, uint32_t i);
} race_set;
#endif

#define kensler_block PK_NAME(kensler_block)
#define kensler_corner PK_NAME(kensler_corner)
#define kensler_cross PK_NAME(kensler_cross)
#define kensler_dot PK_NAME(kensler_dot)
#define kensler_ours PK_NAME(kensler_ours)
#define kensler_race PK_NAME(kensler_race)
#define kensler_races PK_NAME(kensler_races)
#define kensler_rays PK_NAME(kensler_rays)
#define kensler_test PK_NAME(kensler_test)
#define kensler_theirs PK_NAME(kensler_theirs)

VOP float8 kensler_dot(const float8 *a, const float8 *b) {
  return vfma(a[0], b[0], vfma(a[1], b[1], vmul(a[2], b[2])));
}
VOP void kensler_cross(const float8 *a, const float8 *b, float8 *out) {
  out[0] = vfms(a[1], b[2], vmul(a[2], b[1]));
  out[1] = vfms(a[2], b[0], vmul(a[0], b[2]));
  out[2] = vfms(a[0], b[1], vmul(a[1], b[0]));
}

/* Eight rays and triangles; the bits of those that meet at t in (tmin, tmax). t is written only if there are any. */
VOP uint32_t kensler_test(const float8 *p0, const float8 *e0, const float8 *e1, const float8 *n, const float8 *o,
    const float8 *d, float8 tmin, float8 tmax, float8 *t) {
  const float8 r[3] = {vsub(p0[0], o[0]), vsub(p0[1], o[1]), vsub(p0[2], o[2])}, zero = vset(0);
  float8 i[3];
  kensler_cross(r, d, i);
  const float8 det = kensler_dot(n, d), beta = kensler_dot(e1, i), gamma = kensler_dot(e0, i);
  const float8 alpha = vsub(vsub(det, beta), gamma);
  const mask8 drop = mand(vlt(vmin(alpha, vmin(beta, gamma)), zero), vlt(zero, vmax(alpha, vmax(beta, gamma))));
  const uint32_t bits = 0xFFu & ~mbits(drop);
  if (!bits) return 0;
  *t = vdiv(kensler_dot(n, r), det); /* no number that counts where det is 0 */
  return bits & mbits(mand(vlt(tmin, *t), vlt(*t, tmax)));
}

/* Returns one coordinate of a corner of a block's eight triangles, at the ray's time. pk_tri_corner() returns those of
   a slice, which has only four triangles on SSE2. */
VOP float8 kensler_corner(const float *k0, const float *k1, float8 weight0, float8 weight1, const bool moving) {
  return moving ? vadd(vmul(weight0, vload(k0)), vmul(weight1, vload(k1))) : vload(k0);
}

/* One ray against a leaf block. */
VOP void kensler_block(const pk_bvh_segment *seg, pk_batch *b, uint32_t r, uint32_t index, const bool moving) {
  const pk_block *block = pk_segment_block(seg, index, moving);
  const float *k0 = pk_segment_vertices(seg, block, 0, moving), *k1 = pk_segment_vertices(seg, block, 1, moving);
  const uint32_t *id = block->id;
  const float8 weight1 = vset(b->weight1[r]), weight0 = vsub(vset(1), weight1);
  float8 p0[3], e0[3], e1[3], n[3], o[3], d[3], t;
  UNROLL for (uint32_t a = 0; a < 3; a++) {
    p0[a] = kensler_corner(k0 + 8 * a, k1 + 8 * a, weight0, weight1, moving);
    e0[a] = vsub(kensler_corner(k0 + 24 + 8 * a, k1 + 24 + 8 * a, weight0, weight1, moving), p0[a]);
    e1[a] = vsub(p0[a], kensler_corner(k0 + 48 + 8 * a, k1 + 48 + 8 * a, weight0, weight1, moving));
    o[a] = vset(b->o[a][r]), d[a] = vset(b->d[a][r]);
  }
  kensler_cross(e0, e1, n);
  uint32_t bits = kensler_test(p0, e0, e1, n, o, d, vset(b->tmin[r]), vset(b->t[r]), &t);
  if (!bits || !(bits &= pk_lanes_occupied(id))) return;
  PK_ALIGN64 float ts[8];
  vstore(ts, t);
  for (; bits; bits &= bits - 1) {
    const uint32_t lane = pk_lowest_bit(bits);
    if (ts[lane] < b->t[r]) b->t[r] = ts[lane], b->id[r] = id[lane], b->slot[r] = index * 8 + lane;
  }
}

/* One triangle, its corners at k0 and k1, against those of rays r to r + 7 that `bits` names. At rest, what needs no ray
   is the same for all. */
VOP void kensler_rays(pk_batch *b, const float *k0, const float *k1, uint32_t r, uint32_t bits, uint32_t id,
    uint32_t slot, const bool moving) {
  float8 p0[3], e0[3], e1[3], n[3], o[3], d[3], t;
  if (moving) {
    const float8 weight1 = vload(b->weight1 + r), weight0 = vsub(vset(1), weight1);
    float8 p[9];
    UNROLL for (uint32_t i = 0; i < 9; i++) p[i] = vadd(vmul(weight0, vset(k0[8 * i])), vmul(weight1, vset(k1[8 * i])));
    UNROLL for (uint32_t a = 0; a < 3; a++) p0[a] = p[a], e0[a] = vsub(p[3 + a], p[a]), e1[a] = vsub(p[a], p[6 + a]);
    kensler_cross(e0, e1, n);
  } else {
    float p[3], f[3], g[3];
    UNROLL for (uint32_t a = 0; a < 3; a++) p[a] = k0[8 * a], f[a] = k0[24 + 8 * a] - p[a],
                                            g[a] = p[a] - k0[48 + 8 * a];
    UNROLL for (uint32_t a = 0; a < 3; a++) {
      const uint32_t u = (a + 1) % 3, v = (a + 2) % 3;
      p0[a] = vset(p[a]), e0[a] = vset(f[a]), e1[a] = vset(g[a]), n[a] = vset(f[u] * g[v] - f[v] * g[u]);
    }
  }
  UNROLL for (uint32_t a = 0; a < 3; a++) o[a] = vload(b->o[a] + r), d[a] = vload(b->d[a] + r);
  const uint32_t hit = bits & kensler_test(p0, e0, e1, n, o, d, vload(b->tmin + r), vload(b->t + r), &t);
  if (!hit) return;
  const mask8 m = mfrom(hit);
  vstore_masked(b->t + r, m, t);
  vstore_masked_u32(b->id + r, m, id);
  vstore_masked_u32(b->slot + r, m, slot);
}

#ifndef KENSLER_ALONE /* who wants no race */
/* pktrt's way with the same rays and triangles: as in a leaf of the paper path. */
VOP void kensler_ours(const pk_bvh_segment *seg, pk_batch *b, const visit *v, const bool moving) {
  const pk_variant variant = pk_variant_of(false, moving, false, &kensler_unread);
  const pk_block *block = pk_segment_block(seg, v->block, moving);
  const float *k0 = pk_segment_vertices(seg, block, 0, moving), *k1 = pk_segment_vertices(seg, block, 1, moving);
  const uint32_t r = v->ray, bits = v->bits, *id = block->id;
  pk_paper_packet p;
  p.batch = b, p.seg = seg;
  bool same = true;
  for (uint32_t m = bits; m; m &= m - 1) same &= b->axis[r + pk_lowest_bit(m)] == b->axis[r + pk_lowest_bit(bits)];
  for (uint32_t m = same ? pk_lanes_occupied(id) : 0; m; m &= m - 1) {
    const uint32_t lane = pk_lowest_bit(m);
    pk_paper_test_triangle(&p, k0 + lane, k1 + lane, r, bits, id[lane], v->block * 8 + lane, variant);
  }
  for (uint32_t m = same ? 0 : bits; m; m &= m - 1)
    pk_tri_ray_block(seg, b, r + pk_lowest_bit(m), NULL, v->block, variant);
}

/* The same by Kensler and Shirley's test. */
VOP void kensler_theirs(const pk_bvh_segment *seg, pk_batch *b, const visit *v, const bool moving) {
  const pk_block *block = pk_segment_block(seg, v->block, moving);
  const float *k0 = pk_segment_vertices(seg, block, 0, moving), *k1 = pk_segment_vertices(seg, block, 1, moving);
  for (uint32_t m = pk_lanes_occupied(block->id); m; m &= m - 1) {
    const uint32_t lane = pk_lowest_bit(m);
    kensler_rays(b, k0 + lane, k1 + lane, v->ray, v->bits, block->id[lane], v->block * 8 + lane, moving);
  }
}

VOP void kensler_race(const course *c, size_t batch, const bool kensler, const bool groups, const bool moving) {
  const pk_bvh_segment *seg = &c->seg;
  pk_batch *b = &c->batch[batch];
  for (size_t i = c->start[groups][batch]; i < c->start[groups][batch + 1]; i++) {
    const visit *v = &c->visit[groups][i];
    if (groups && kensler) kensler_theirs(seg, b, v, moving);
    else if (groups) kensler_ours(seg, b, v, moving);
    else if (kensler) kensler_block(seg, b, v->ray, v->block, moving);
    else pk_tri_ray_block(seg, b, v->ray, NULL, v->block, pk_variant_of(false, moving, false, &kensler_unread));
  }
}

/* A function for each combination, so that none is decided in the loop. */
#define RACE(tag, kensler, groups, moving) \
  PK_NOINLINE void PK_NAME(kensler_race_##tag)(const course *c, size_t batch) { \
    kensler_race(c, batch, kensler, groups, moving); \
  }
RACE(000, false, false, false)
RACE(001, false, false, true)
RACE(010, false, true, false)
RACE(011, false, true, true)
RACE(100, true, false, false)
RACE(101, true, false, true)
RACE(110, true, true, false)
RACE(111, true, true, true)
#undef RACE
static const race_set kensler_races = {
    {{{PK_NAME(kensler_race_000), PK_NAME(kensler_race_001)}, {PK_NAME(kensler_race_010), PK_NAME(kensler_race_011)}},
        {{PK_NAME(kensler_race_100), PK_NAME(kensler_race_101)},
            {PK_NAME(kensler_race_110), PK_NAME(kensler_race_111)}}},
    pk_batch_setup};
#endif
