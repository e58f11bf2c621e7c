/* plain_tests.h - textbook tests of triangles in pktrt's own kernels, in place of its exact ones: what does it cost
   that no ray leaks? Kensler and Shirley's (2006) as in kensler_stamp.h, or with PLAIN_MOLLER Moeller and Trumbore's
   (1997). No include guard: pktrt.h includes it once for each instruction set (PKTRT__OTHER_TESTS, in >>leaves), in
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

#define plain_block PKTRT__NAME(plain_block)
#define plain_cross PKTRT__NAME(plain_cross)
#define plain_cross_f PKTRT__NAME(plain_cross_f)
#define plain_dot PKTRT__NAME(plain_dot)
#define plain_dot_f PKTRT__NAME(plain_dot_f)
#define plain_origin PKTRT__NAME(plain_origin)
#define plain_rays PKTRT__NAME(plain_rays)
#define plain_signs PKTRT__NAME(plain_signs)
#define plain_take PKTRT__NAME(plain_take)
#define plain_triangle PKTRT__NAME(plain_triangle)

/* --- a ray and a leaf --- */

OP v8 plain_dot(const v8 *a, const v8 *b) { return vfma(a[0], b[0], vfma(a[1], b[1], vmul(a[2], b[2]))); }
OP void plain_cross(const v8 *a, const v8 *b, v8 *out) {
  out[0] = vfms(a[1], b[2], vmul(a[2], b[1]));
  out[1] = vfms(a[2], b[0], vmul(a[0], b[2]));
  out[2] = vfms(a[0], b[1], vmul(a[1], b[0]));
}

/* Three numbers of one sign make a hit, at t = *top / *det. */
#ifdef PLAIN_MOLLER
OP uint32_t plain_signs(v8 p[3][3], const v8 *o, const v8 *d, v8 *top, v8 *det) {
  v8 f[3], g[3], r[3], across[3], q[3];
  UNROLL for (int a = 0; a < 3; a++) f[a] = vsub(p[1][a], p[0][a]), g[a] = vsub(p[2][a], p[0][a]),
                                     r[a] = vsub(o[a], p[0][a]);
  plain_cross(d, g, across);
  plain_cross(r, f, q);
  *det = plain_dot(f, across);
  const v8 u = plain_dot(r, across), v = plain_dot(d, q), w = vsub(vsub(*det, u), v), zero = vset(0);
  *top = plain_dot(g, q);
  return 0xFFu & ~mbits(mand(vlt(vmin(w, vmin(u, v)), zero), vlt(zero, vmax(w, vmax(u, v)))));
}
#else
OP uint32_t plain_signs(v8 p[3][3], const v8 *o, const v8 *d, v8 *top, v8 *det) {
  v8 f[3], g[3], r[3], n[3], i[3];
  UNROLL for (int a = 0; a < 3; a++) f[a] = vsub(p[1][a], p[0][a]), g[a] = vsub(p[0][a], p[2][a]),
                                     r[a] = vsub(p[0][a], o[a]);
  plain_cross(f, g, n);
  plain_cross(r, d, i);
  *det = plain_dot(n, d);
  const v8 u = plain_dot(g, i), v = plain_dot(f, i), w = vsub(vsub(*det, u), v), zero = vset(0);
  *top = plain_dot(n, r);
  return 0xFFu & ~mbits(mand(vlt(vmin(w, vmin(u, v)), zero), vlt(zero, vmax(w, vmax(u, v)))));
}
#endif

/* The triangles of a block that a ray hits before what it has hit so far, and their depths. */
OP uint32_t plain_block(const pktrt__bvh_segment *seg, const pktrt__batch *b, uint32_t r, const pktrt__single *single,
                        const pktrt__block *block, const bool moving, v8 *w) {
  const float *k0 = pktrt__segment_vertices(seg, block, 0, moving),
              *k1 = pktrt__segment_vertices(seg, block, 1, moving);
  const v8 tb = vset(single ? single->tb : b->tb[r]), ta = vsub(vset(1), tb);
  v8 p[3][3], o[3], d[3], top, det;
  UNROLL for (int a = 0; a < 3; a++) {
    UNROLL for (int c = 0; c < 3; c++) p[c][a] =
        pktrt__tri_corner(k0 + 24 * c + 8 * a, k1 + 24 * c + 8 * a, ta, tb, moving);
    o[a] = vset(single ? single->ray->origin[a] : b->o[a][r]),
    d[a] = vset(single ? single->ray->direction[a] : b->d[a][r]);
  }
  const uint32_t bits = plain_signs(p, o, d, &top, &det) & pktrt__lanes_occupied(block->id);
  *w = vset(0);
  if (single && !bits) return 0; /* streams do better without the branch */
  *w = vmul(vdiv(top, det), vabs(vset(single ? single->dk : b->dk[r])));
  const v8 wn = vset(single ? single->wn : b->wn[r]), wf = vset(single ? single->wf : b->wf[r]);
  return bits & mbits(mand(vlt(wn, *w), vlt(*w, wf)));
}

/* Goes through the triangles that a ray hits, and records each that is nearer than what was hit before it; returns
   their lanes. */
OP uint32_t plain_take(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, pktrt__single *single,
                       const pktrt__block *block, uint32_t index, const float *depth, uint32_t bits) {
  uint32_t nearer = 0;
  for (; bits; bits &= bits - 1) {
    const uint32_t lane = pktrt__lowest_bit(bits), id = block->id[lane], slot = index * 8 + lane;
    if (!(depth[lane] < (single ? single->wf : b->wf[r]))) continue;
    if (single) pktrt__single_set_hit(seg, single, depth[lane], depth[lane], id, slot);
    else pktrt__batch_set_hit(seg, b, r, depth[lane], depth[lane], id, slot);
    nearer |= 1u << lane;
  }
  return nearer;
}

OP uint32_t pktrt__tri_block_template(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, pktrt__single *single,
                                      uint32_t index, const pktrt__variant is) {
  const pktrt__block *block = pktrt__segment_block(seg, index, is.moving);
  PKTRT__ALIGN64 float depth[8];
  v8 w;
  COUNT(triangle_tests, pktrt__popcount(pktrt__lanes_occupied(block->id)));
  const uint32_t bits = plain_block(seg, b, r, single, block, is.moving, &w);
  if (is.occlusion || !bits) return bits;
  vstore(depth, w);
  return plain_take(seg, b, r, single, block, index, depth, bits);
}

/* As pktrt's: noted of all rays before the first is looked at, depths in lo. */
OP uint64_t pktrt__stream_record(const pktrt__bvh_segment *seg, pktrt__batch *b, const uint8_t *list,
                                 pktrt__stream_notes *s, const bool moving) {
  const pktrt__block *block = pktrt__segment_block(seg, s->index, moving);
  uint64_t hit = 0;
  for (uint32_t j = 0; j < s->n; j++) {
    plain_take(seg, b, list[s->ray[j]], NULL, block, s->index, s->lo[j], s->maybe[j]);
    hit |= (uint64_t)1 << s->ray[j];
  }
  s->n = 0;
  return hit;
}

OP uint64_t pktrt__stream_closest_block(const pktrt__bvh_segment *seg, pktrt__batch *b, const uint8_t *list,
                                        uint64_t mask, uint32_t index, pktrt__stream_notes *s, const bool moving) {
  const pktrt__block *block = pktrt__segment_block(seg, index, moving);
  uint64_t hit = 0;
  for (s->index = index;;) {
    uint32_t n = 0;
    for (; mask && n < PKTRT__NOTES; mask &= mask - 1) {
      const uint32_t i = pktrt__lowest_bit(mask);
      v8 w;
      s->maybe[n] = (uint8_t)plain_block(seg, b, list[i], NULL, block, moving, &w);
      vstore(s->lo[n], w);
      s->ray[n] = (uint8_t)i;
      n += s->maybe[n] != 0;
    }
    s->n = n;
    if (!mask) return hit;
    hit |= pktrt__stream_record(seg, b, list, s, moving);
  }
}

OP uint64_t pktrt__stream_any_block(const pktrt__bvh_segment *seg, pktrt__batch *b, const uint8_t *list, uint64_t mask,
                                    uint32_t index, const bool moving) {
  const pktrt__block *block = pktrt__segment_block(seg, index, moving);
  uint64_t hit = 0;
  for (; mask; mask &= mask - 1) {
    const uint32_t i = pktrt__lowest_bit(mask);
    v8 w;
    hit |= (uint64_t)(plain_block(seg, b, list[i], NULL, block, moving, &w) != 0) << i;
  }
  return hit;
}

/* --- a packet and a triangle --- */

OP vf plain_dot_f(const vf *a, const vf *b) { return ffma(a[0], b[0], ffma(a[1], b[1], fmul(a[2], b[2]))); }
OP void plain_cross_f(const vf *a, const vf *b, vf *out) {
  out[0] = ffms(a[1], b[2], fmul(a[2], b[1]));
  out[1] = ffms(a[2], b[0], fmul(a[0], b[2]));
  out[2] = ffms(a[0], b[1], fmul(a[1], b[0]));
}

/* What a triangle needs for a packet: its first corner, edges f and g (Kensler and Shirley's goes from p2 to p0) and,
   for them, its normal. With one origin for all rays: s = p0 - o (Moeller and Trumbore: o - p0), q = s x f for them, and
   the numerator of t. */
typedef struct plain_triangle {
  vf p0[3], f[3], g[3], n[3], s[3], q[3], top;
} plain_triangle;

OP void plain_origin(plain_triangle *x, const vf *o) {
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
OP uint32_t plain_rays(const pktrt__bvh_segment *seg, pktrt__batch *b, uint32_t r, uint32_t bits,
                       const plain_triangle *x, pktrt__tri_common *tri) {
  vf d[3], i[3], u, v, det;
  UNROLL for (int a = 0; a < 3; a++) d[a] = fload(b->d[a] + r);
#ifdef PLAIN_MOLLER
  plain_cross_f(d, x->g, i);
  det = plain_dot_f(x->f, i), u = plain_dot_f(x->s, i), v = plain_dot_f(d, x->q);
#else
  plain_cross_f(x->s, d, i);
  det = plain_dot_f(x->n, d), u = plain_dot_f(x->g, i), v = plain_dot_f(x->f, i);
#endif
  const vf w = fsub(fsub(det, u), v), zero = fset(0);
  bits &= ~fbits(fmand(flt(fmin_(w, fmin_(u, v)), zero), flt(zero, fmax_(w, fmax_(u, v)))));
  if (!bits) return 0;
  const vf depth = fmul(fdiv(x->top, det), fabs_(fload(b->dk + r)));
  bits &= fbits(fmand(flt(fload(b->wn + r), depth), flt(depth, fload(b->wf + r))));
  if (bits) pktrt__frustum_set_hits(seg, b, r, bits, depth, depth, tri->id, tri->slot);
  return bits;
}

OP uint64_t pktrt__frustum_test_triangle(const pktrt__frustum *f, const pktrt__bvh_segment *seg, pktrt__batch *b,
                                         const float *k0, const pktrt__frustum_corners *corners, uint32_t lane,
                                         pktrt__tri_common *tri, uint64_t mask) {
  plain_triangle x;
  float e[2][3];
  vf o[3];
  uint64_t result = 0;
  (void)corners;
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
  for (uint32_t i = 0; i < 64; i += FW) {
    const uint32_t rays = (uint32_t)(mask >> i) & ((1u << FW) - 1), r = f->base + i;
    if (!rays) continue;
    UNROLL for (int a = 0; a < 3; a++) o[a] = fload(b->o[a] + r);
    if (!f->common) plain_origin(&x, o);
    result |= (uint64_t)plain_rays(seg, b, r, rays, &x, tri) << i;
  }
  return result;
}

/* --- a packet and a moving triangle --- */

OP uint32_t pktrt__frustum_test_moving(const pktrt__frustum *f, const pktrt__bvh_segment *seg, pktrt__batch *b,
                                       uint32_t r, uint32_t rays, const float *k0, const float *k1,
                                       pktrt__tri_common *tri) {
  const vf tb = fload(b->tb + r), ta = fsub(fset(1), tb);
  plain_triangle x;
  vf p[3][3], o[3];
  (void)f;
  UNROLL for (int c = 0; c < 9; c++) p[c / 3][c % 3] = ffma(ta, fset(k0[8 * c]), fmul(tb, fset(k1[8 * c])));
  UNROLL for (int a = 0; a < 3; a++) {
    x.p0[a] = p[0][a], x.f[a] = fsub(p[1][a], p[0][a]), o[a] = fload(b->o[a] + r);
    x.g[a] = fsub(p[PLAIN_TO][a], p[2 - PLAIN_TO][a]);
  }
  plain_cross_f(x.f, x.g, x.n);
  plain_origin(&x, o);
  return plain_rays(seg, b, r, rays, &x, tri);
}

/* No filter comes before these: they cost hardly more than that would. */
PKTRT__NOINLINE uint64_t pktrt__frustum_filter_resting(const pktrt__frustum *f, const pktrt__batch *b, const float *k0,
                                                       const pktrt__frustum_corners *corners, uint32_t lane) {
  (void)f, (void)b, (void)k0, (void)corners, (void)lane;
  return ~(uint64_t)0;
}
OP uint64_t pktrt__frustum_filter_moving(const pktrt__frustum *f, const pktrt__batch *b,
                                         const pktrt__frustum_motion *motion, uint32_t lane) {
  (void)f, (void)b, (void)motion, (void)lane;
  return ~(uint64_t)0;
}
