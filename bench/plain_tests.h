/* plain_tests.h - textbook tests of triangles in pktrt's own kernels, in place of its exact ones: what does it cost
   that no ray leaks? Kensler and Shirley's (2006) as in kensler_stamp.h, or with PLAIN_MOLLER Moeller and Trumbore's
   (1997). No include guard: pktrt.h includes it once for each instruction set (PK_OTHER_TESTS, in >>leaves), in
   place of its tests of a ray and a leaf, of a packet and a triangle, of a packet and a moving triangle.

   Both tests are given what makes them fast: sums of products are fused where the machine can, nothing is divided until
   a lane has passed, and what needs no ray is computed once for a packet. Trees, boxes, orders, culling of triangles by
   the packet, and resolving are the same. Depths are w = t |d_k|, as pktrt keeps them.

   Moeller and Trumbore: with f = p1 - p0, g = p2 - p0, r = o - p0, p = d x g, q = r x f,

       D = f.p      u = r.p / D      v = d.q / D      t = g.q / D */

#ifndef PLAIN_TO /* where edge g goes: to p2, or from there to p0 */
#ifdef PLAIN_MOLLER
#define PLAIN_TO 2
#else
#define PLAIN_TO 0
#endif
#endif

#define plain_block PK_NAME(plain_block)
#define plain_corner PK_NAME(plain_corner)
#define plain_cross PK_NAME(plain_cross)
#define plain_cross_f PK_NAME(plain_cross_f)
#define plain_dot PK_NAME(plain_dot)
#define plain_dot_f PK_NAME(plain_dot_f)
#define plain_origin PK_NAME(plain_origin)
#define plain_rays PK_NAME(plain_rays)
#define plain_test_moving PK_NAME(plain_test_moving)
#define plain_test_resting PK_NAME(plain_test_resting)
#define plain_signs PK_NAME(plain_signs)
#define plain_take PK_NAME(plain_take)
#define plain_triangle PK_NAME(plain_triangle)

/* --- a ray and a leaf --- */

VOP float8 plain_dot(const float8 *a, const float8 *b) { return vfma(a[0], b[0], vfma(a[1], b[1], vmul(a[2], b[2]))); }
VOP void plain_cross(const float8 *a, const float8 *b, float8 *out) {
  out[0] = vfms(a[1], b[2], vmul(a[2], b[1]));
  out[1] = vfms(a[2], b[0], vmul(a[0], b[2]));
  out[2] = vfms(a[0], b[1], vmul(a[1], b[0]));
}

/* Three numbers of one sign make a hit, at t = *top / *det. */
#ifdef PLAIN_MOLLER
VOP uint32_t plain_signs(float8 p[3][3], const float8 *o, const float8 *d, float8 *top, float8 *det) {
  float8 f[3], g[3], r[3], across[3], q[3];
  UNROLL for (int a = 0; a < 3; a++) f[a] = vsub(p[1][a], p[0][a]), g[a] = vsub(p[2][a], p[0][a]),
                                     r[a] = vsub(o[a], p[0][a]);
  plain_cross(d, g, across);
  plain_cross(r, f, q);
  *det = plain_dot(f, across);
  const float8 u = plain_dot(r, across), v = plain_dot(d, q), w = vsub(vsub(*det, u), v), zero = vset(0);
  *top = plain_dot(g, q);
  return 0xFFu & ~mbits(mand(vlt(vmin(w, vmin(u, v)), zero), vlt(zero, vmax(w, vmax(u, v)))));
}
#else
VOP uint32_t plain_signs(float8 p[3][3], const float8 *o, const float8 *d, float8 *top, float8 *det) {
  float8 f[3], g[3], r[3], n[3], i[3];
  UNROLL for (int a = 0; a < 3; a++) f[a] = vsub(p[1][a], p[0][a]), g[a] = vsub(p[0][a], p[2][a]),
                                     r[a] = vsub(p[0][a], o[a]);
  plain_cross(f, g, n);
  plain_cross(r, d, i);
  *det = plain_dot(n, d);
  const float8 u = plain_dot(g, i), v = plain_dot(f, i), w = vsub(vsub(*det, u), v), zero = vset(0);
  *top = plain_dot(n, r);
  return 0xFFu & ~mbits(mand(vlt(vmin(w, vmin(u, v)), zero), vlt(zero, vmax(w, vmax(u, v)))));
}
#endif

/* Returns one coordinate of a corner of a block's eight triangles, at the ray's time. pk_tri_corner() returns those of
   a slice, which has only four triangles on SSE2. */
VOP float8 plain_corner(const float *k0, const float *k1, float8 weight0, float8 weight1, const bool moving) {
  return moving ? vadd(vmul(weight0, vload(k0)), vmul(weight1, vload(k1))) : vload(k0);
}

/* The triangles of a block that a ray hits before what it has hit so far, and their depths. */
VOP uint32_t plain_block(const pk_bvh_segment *seg, const pk_batch *b, uint32_t r, const pk_single *single,
    const pk_block *block, const bool moving, float8 *w) {
  const float *k0 = pk_segment_vertices(seg, block, 0, moving), *k1 = pk_segment_vertices(seg, block, 1, moving);
  const float8 weight1 = vset(single ? single->weight1 : b->weight1[r]), weight0 = vsub(vset(1), weight1);
  float8 p[3][3], o[3], d[3], top, det;
  UNROLL for (int a = 0; a < 3; a++) {
    UNROLL for (int c = 0; c < 3; c++) p[c][a] =
        plain_corner(k0 + 24 * c + 8 * a, k1 + 24 * c + 8 * a, weight0, weight1, moving);
    o[a] = vset(single ? single->ray->origin[a] : b->o[a][r]),
    d[a] = vset(single ? single->ray->direction[a] : b->d[a][r]);
  }
  const uint32_t bits = plain_signs(p, o, d, &top, &det) & pk_lanes_occupied(block->id);
  *w = vset(0);
  if (single && !bits) return 0; /* streams do better without the branch */
  *w = vmul(vdiv(top, det), vabs(vset(single ? single->d_major : b->d_major[r])));
  const float8 depth_lo = vset(single ? single->depth_lo : b->depth_lo[r]),
               depth_hi = vset(single ? single->depth_hi : b->depth_hi[r]);
  return bits & mbits(mand(vlt(depth_lo, *w), vlt(*w, depth_hi)));
}

/* Goes through the triangles that a ray hits, and records each that is nearer than what was hit before it; returns
   their lanes. */
VOP uint32_t plain_take(const pk_bvh_segment *seg, pk_batch *b, uint32_t r, pk_single *single, const pk_block *block,
    uint32_t index, const float *depth, uint32_t bits) {
  uint32_t nearer = 0;
  for (; bits; bits &= bits - 1) {
    const uint32_t lane = pk_lowest_bit(bits), id = block->id[lane], slot = index * 8 + lane;
    if (!(depth[lane] < (single ? single->depth_hi : b->depth_hi[r]))) continue;
    pk_batch_set_hit(seg, b, r, single, depth[lane], depth[lane], id, slot);
    nearer |= 1u << lane;
  }
  return nearer;
}

VOP uint32_t pk_tri_block_template(
    const pk_bvh_segment *seg, pk_batch *b, uint32_t r, pk_single *single, uint32_t index, const pk_variant variant) {
  const pk_block *block = pk_segment_block(seg, index, variant.moving);
  PK_ALIGN64 float depth[8];
  float8 w;
  COUNT(triangle_tests, pk_popcount(pk_lanes_occupied(block->id)));
  const uint32_t bits = plain_block(seg, b, r, single, block, variant.moving, &w);
  if (variant.occlusion || !bits) return bits;
  vstore(depth, w);
  return plain_take(seg, b, r, single, block, index, depth, bits);
}

/* As pktrt's: all rays are filtered before the first is recorded, depths in lo. */
VOP uint64_t pk_stream_record(
    const pk_bvh_segment *seg, pk_batch *b, const uint8_t *list, pk_stream_pending *s, const bool moving) {
  const pk_block *block = pk_segment_block(seg, s->block, moving);
  uint64_t hit = 0;
  for (uint32_t j = 0; j < s->count; j++) {
    plain_take(seg, b, list[s->bit[j]], NULL, block, s->block, s->lo[j], s->maybe[j]);
    hit |= (uint64_t)1 << s->bit[j];
  }
  s->count = 0;
  return hit;
}

VOP uint64_t pk_stream_closest_block(const pk_bvh_segment *seg, pk_batch *b, const uint8_t *list, uint64_t mask,
    uint32_t index, pk_stream_pending *s, const bool moving) {
  const pk_block *block = pk_segment_block(seg, index, moving);
  uint64_t hit = 0;
  for (s->block = index;;) {
    uint32_t n = 0;
    for (; mask && n < PK_PENDING; mask &= mask - 1) {
      const uint32_t i = pk_lowest_bit(mask);
      float8 w;
      s->maybe[n] = (uint8_t)plain_block(seg, b, list[i], NULL, block, moving, &w);
      vstore(s->lo[n], w);
      s->bit[n] = (uint8_t)i;
      n += s->maybe[n] != 0;
    }
    s->count = n;
    if (!mask) return hit;
    hit |= pk_stream_record(seg, b, list, s, moving);
  }
}

VOP uint64_t pk_stream_any_block(
    const pk_bvh_segment *seg, pk_batch *b, const uint8_t *list, uint64_t mask, uint32_t index, const bool moving) {
  const pk_block *block = pk_segment_block(seg, index, moving);
  uint64_t hit = 0;
  for (; mask; mask &= mask - 1) {
    const uint32_t i = pk_lowest_bit(mask);
    float8 w;
    hit |= (uint64_t)(plain_block(seg, b, list[i], NULL, block, moving, &w) != 0) << i;
  }
  return hit;
}

/* --- a packet and a triangle --- */

VOP floatw plain_dot_f(const floatw *a, const floatw *b) {
  return ffma(a[0], b[0], ffma(a[1], b[1], fmul(a[2], b[2])));
}
VOP void plain_cross_f(const floatw *a, const floatw *b, floatw *out) {
  out[0] = ffms(a[1], b[2], fmul(a[2], b[1]));
  out[1] = ffms(a[2], b[0], fmul(a[0], b[2]));
  out[2] = ffms(a[0], b[1], fmul(a[1], b[0]));
}

/* What a triangle needs for a packet: its first corner, edges f and g (Kensler and Shirley's goes from p2 to p0) and,
   for them, its normal. With one origin for all rays: s = p0 - o (Moeller and Trumbore: o - p0), q = s x f for them, and
   the numerator of t. */
typedef struct plain_triangle {
  floatw p0[3], f[3], g[3], n[3], s[3], q[3], top;
} plain_triangle;

VOP void plain_origin(plain_triangle *x, const floatw *o) {
#ifdef PLAIN_MOLLER
  UNROLL for (int a = 0; a < 3; a++) x->s[a] = fsub(o[a], x->p0[a]);
  plain_cross_f(x->s, x->f, x->q);
  x->top = plain_dot_f(x->g, x->q);
#else
  UNROLL for (int a = 0; a < 3; a++) x->s[a] = fsub(x->p0[a], o[a]);
  x->top = plain_dot_f(x->n, x->s);
#endif
}

/* A vector of rays against one triangle. */
VOP uint32_t plain_rays(
    const pk_bvh_segment *seg, pk_batch *b, uint32_t r, uint32_t bits, const plain_triangle *x, pk_tri_common *tri) {
  floatw d[3], i[3], u, v, det;
  UNROLL for (int a = 0; a < 3; a++) d[a] = fload(b->d[a] + r);
#ifdef PLAIN_MOLLER
  plain_cross_f(d, x->g, i);
  det = plain_dot_f(x->f, i), u = plain_dot_f(x->s, i), v = plain_dot_f(d, x->q);
#else
  plain_cross_f(x->s, d, i);
  det = plain_dot_f(x->n, d), u = plain_dot_f(x->g, i), v = plain_dot_f(x->f, i);
#endif
  const floatw w = fsub(fsub(det, u), v), zero = fset(0);
  bits &= ~fbits(fmand(flt(fmin_(w, fmin_(u, v)), zero), flt(zero, fmax_(w, fmax_(u, v)))));
  if (!bits) return 0;
  const floatw depth = fmul(fdiv(x->top, det), fabs_(fload(b->d_major + r)));
  bits &= fbits(fmand(flt(fload(b->depth_lo + r), depth), flt(depth, fload(b->depth_hi + r))));
  if (bits) pk_frustum_set_hits(seg, b, r, bits, depth, depth, tri->id, tri->slot);
  return bits;
}

VOP uint64_t plain_test_resting(const pk_frustum *f, const pk_bvh_segment *seg, pk_batch *b,
    const pk_frustum_corners *corners, uint32_t lane, pk_tri_common *tri, uint64_t mask) {
  const float *k0 = corners->key0;
  plain_triangle x;
  float e[2][3];
  floatw o[3];
  uint64_t result = 0;
  for (uint32_t a = 0; a < 3; a++) {
    const float c0 = k0[8 * a + lane];
    e[0][a] = k0[24 + 8 * a + lane] - c0,
    e[1][a] = k0[24 * PLAIN_TO + 8 * a + lane] - k0[48 - 24 * PLAIN_TO + 8 * a + lane];
    x.p0[a] = fset(c0), x.f[a] = fset(e[0][a]), x.g[a] = fset(e[1][a]), o[a] = fset(b->o[a][f->first]);
  }
  for (uint32_t a = 0; a < 3; a++) {
    const uint32_t u = (a + 1) % 3, v = (a + 2) % 3;
    x.n[a] = fset(e[0][u] * e[1][v] - e[0][v] * e[1][u]);
  }
  plain_origin(&x, o); /* if all have it, once for all */
  for (uint32_t i = 0; i < 64; i += FRUSTUM_WIDTH) {
    const uint32_t rays = (uint32_t)(mask >> i) & ((1u << FRUSTUM_WIDTH) - 1), r = f->base + i;
    if (!rays) continue;
    UNROLL for (int a = 0; a < 3; a++) o[a] = fload(b->o[a] + r);
    if (!f->common) plain_origin(&x, o);
    result |= (uint64_t)plain_rays(seg, b, r, rays, &x, tri) << i;
  }
  return result;
}

/* --- a packet and a moving triangle --- */

VOP uint32_t plain_test_moving(const pk_bvh_segment *seg, pk_batch *b, uint32_t r, uint32_t rays, const float *k0,
    const float *k1, pk_tri_common *tri) {
  const floatw weight1 = fload(b->weight1 + r), weight0 = fsub(fset(1), weight1);
  plain_triangle x;
  floatw p[3][3], o[3];
  UNROLL for (int c = 0; c < 9; c++) p[c / 3][c % 3] = ffma(weight0, fset(k0[8 * c]), fmul(weight1, fset(k1[8 * c])));
  UNROLL for (int a = 0; a < 3; a++) {
    x.p0[a] = p[0][a], x.f[a] = fsub(p[1][a], p[0][a]), o[a] = fload(b->o[a] + r);
    x.g[a] = fsub(p[PLAIN_TO][a], p[2 - PLAIN_TO][a]);
  }
  plain_cross_f(x.f, x.g, x.n);
  plain_origin(&x, o);
  return plain_rays(seg, b, r, rays, &x, tri);
}

VOP uint64_t pk_frustum_test_triangle(const pk_frustum *f, const pk_bvh_segment *seg, pk_batch *b,
    const pk_frustum_corners *corners, uint32_t lane, pk_tri_common *tri, uint64_t mask, const bool moving) {
  uint64_t result = 0;
  if (!moving) return plain_test_resting(f, seg, b, corners, lane, tri, mask);
  for (uint32_t i = 0; i < 64; i += FRUSTUM_WIDTH) {
    const uint32_t rays = PK_FRUSTUM_RAYS(mask, i);
    if (rays)
      result |= (uint64_t)plain_test_moving(seg, b, f->base + i, rays, corners->key0 + lane, corners->key1 + lane, tri)
                << i;
  }
  return result;
}

/* No filter comes before these: they cost hardly more than that would. */
VOP uint64_t pk_frustum_filter(
    const pk_frustum *f, const pk_batch *b, const pk_frustum_corners *corners, uint32_t lane, const bool moving) {
  (void)f, (void)b, (void)corners, (void)lane, (void)moving;
  return ~(uint64_t)0;
}
VOP uint64_t pk_frustum_filter_resting(
    const pk_frustum *f, const pk_batch *b, const pk_frustum_corners *corners, uint32_t lane) {
  return pk_frustum_filter(f, b, corners, lane, false);
}
