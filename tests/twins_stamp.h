/* twins_stamp.h - functions of pktrt.h that have a scalar and a vector form, compared bit by bit. No include guard: tree.c
   includes this file once for each instruction set. PK_STAMP is defined then, and short names of kernels mean the functions of
   the set. Each function here compares one or several pairs, over random and extreme arguments, and returns how many values it
   compared. */
#define double8 PK_NAME(pk_double8)
#define float8 PK_NAME(pk_float8)
#define mask8 PK_NAME(pk_mask8)
#define dadd PK_NAME(pk_dadd)
#define dfrom PK_NAME(pk_dfrom)
#define dload PK_NAME(pk_dload)
#define dmul PK_NAME(pk_dmul)
#define dset PK_NAME(pk_dset)
#define dstore PK_NAME(pk_dstore)
#define vadd PK_NAME(pk_vadd)
#define vload PK_NAME(pk_vload)
#define vmax PK_NAME(pk_vmax)
#define vmul PK_NAME(pk_vmul)
#define vset PK_NAME(pk_vset)
#define vstore PK_NAME(pk_vstore)
#define twins_all PK_NAME(twins_all)
#define twin_edges PK_NAME(twin_edges)
#define twin_grids PK_NAME(twin_grids)
#define twin_hits PK_NAME(twin_hits)
#define twin_maps PK_NAME(twin_maps)
#define twin_normals PK_NAME(twin_normals)
#define twin_places PK_NAME(twin_places)
#define twin_planes PK_NAME(twin_planes)
#define twin_setups PK_NAME(twin_setups)
#define twin_sums PK_NAME(twin_sums)
#define twin_turns PK_NAME(twin_turns)

/* PK_MIX, PK_DEPTH_TINY and pk_vec_dmax_abs3. */
static uint64_t twin_sums(void) {
  uint64_t compared = 0;
  rng r = rng_of(201);

  for (int round = 0; round < TWIN_ROUNDS; round++) {
    float x[3][8], rest[8], mixed[8], tiny[8];
    double largest[8];

    for (int i = 0; i < 24; i++) x[i / 8][i % 8] = twin_number(&r);
    for (int k = 0; k < 8; k++) rest[k] = 1 - x[0][k];
    vstore(mixed, PK_MIX(v, vload(rest), vload(x[1]), vload(x[0]), vload(x[2])));
    vstore(tiny, PK_DEPTH_TINY(vload(x[0])));
    dstore(largest, pk_vec_dmax_abs3(dfrom(vload(x[0])), dfrom(vload(x[1])), dfrom(vload(x[2]))));

    for (int k = 0; k < 8; k++, compared += 3) {
      const float mix = pk_mix(x[0][k], x[1][k], x[2][k]), least = pk_depth_tiny(x[0][k]);
      const double most = pk_max_abs3((double)x[0][k], (double)x[1][k], (double)x[2][k]);
      CHECK(same_bits(&mix, &mixed[k], sizeof mix), "mix: %.9g and %.9g", (double)mix, (double)mixed[k]);
      CHECK(same_bits(&least, &tiny[k], sizeof least), "least depth: %.9g and %.9g", (double)least, (double)tiny[k]);
      CHECK(same_bits(&most, &largest[k], sizeof most), "largest: %.17g and %.17g", most, largest[k]);
    }
  }

  return compared;
}

/* pk_exact_edge_functions8 and pk_exact_accurate8. */
static uint64_t twin_edges(void) {
  uint64_t compared = 0, calm = 0;
  rng r = rng_of(202);

  for (int round = 0; round < TWIN_ROUNDS; round++) {
    twin_eight e;
    double8 x[3], y[3], z[3], error;
    float8 o[3], d[3];
    double u[8], v[8], w[8], det[8], depth[8], errors[8];

    twin_eight_of(&r, round, &e);
    for (int i = 0; i < 3; i++) {
      o[i] = vload(e.o[i]);
      d[i] = vload(e.d[i]);
    }
    for (int i = 0; i < 3; i++) {
      const float8 p[3] = {vload(e.p[i][0]), vload(e.p[i][1]), vload(e.p[i][2])};
      pk_exact_shear8(p, o, d, &x[i], &y[i], &z[i]);
    }
    const pk_exact_edges8 edges = pk_exact_edge_functions8(x, y, z);
    const uint32_t suffice = pk_exact_accurate8(&edges, x, y, z, dfrom(d[0]), &error);
    dstore(u, edges.u), dstore(v, edges.v), dstore(w, edges.w);
    dstore(det, edges.det), dstore(depth, edges.depth), dstore(errors, error);

    for (int k = 0; k < 8; k++, compared += 7) {
      const pk_exact_view view = twin_view_of(&e, k);
      const pk_exact_edges one = pk_exact_edge_functions(&view);
      CHECK(same_bits(&one.u, &u[k], sizeof *u) && same_bits(&one.v, &v[k], sizeof *v) &&
                same_bits(&one.w, &w[k], sizeof *w),
          "edge functions: %.17g and %.17g", one.u, u[k]);
      CHECK(same_bits(&one.det, &det[k], sizeof *det) && same_bits(&one.depth, &depth[k], sizeof *depth),
          "sums: %.17g and %.17g", one.depth, depth[k]);
      CHECK(same_bits(&one.error, &errors[k], sizeof *errors), "error: %.17g and %.17g", one.error, errors[k]);
      CHECK(pk_exact_is_accurate(&one) == (suffice >> k & 1), "calm: %d", (int)(suffice >> k & 1));
      calm += suffice >> k & 1;
    }
  }

  CHECK(calm > compared / 70 && calm < compared / 7, "%u calm of %u", (unsigned)calm, (unsigned)compared / 7);
  return compared;
}

/* pk_tri_decide_slice: wherever it decides, it decides as pk_exact_cross does. */
static uint64_t twin_grids(void) {
  const uint32_t lanes = 8 / TWIN_TURNS;
  uint64_t compared = 0, ties = 0;
  rng r = rng_of(203);

  for (int round = 0; round < TWIN_ROUNDS; round++) {
    const uint32_t across = 2 + rng_below(&r, 6);
    float8 p[3][3], o[3], d[3];
    uint32_t crossed = 0;
    twin_eight e;

    /* Small whole numbers: rays often pass corners and edges. */
    for (int k = 0; k < 8; k++)
      for (int i = 0; i < 3; i++) {
        for (int corner = 0; corner < 3; corner++) e.p[corner][i][k] = (float)rng_below(&r, across);
        e.o[i][k] = (float)rng_below(&r, across) - (i ? 0 : 8);
        e.d[i][k] = i ? (float)rng_below(&r, 5) - 2 : rng_below(&r, 2) ? 4.0f : -4.0f;
      }
    for (int i = 0; i < 9; i++) p[i / 3][i % 3] = vload(e.p[i / 3][i % 3]);
    for (int i = 0; i < 3; i++) {
      o[i] = vload(e.o[i]);
      d[i] = vload(e.d[i]);
    }
    const uint32_t open = pk_tri_directions_on_grid(d) & ((1u << lanes) - 1);
    const uint32_t missed = pk_tri_decide_slice(p, o, d, open, &crossed);

    for (uint32_t k = 0; k < lanes; k++) {
      const pk_exact_view view = twin_view_of(&e, (int)k);
      pk_exact_crossing crossing = {0, 0, false, false};
      if (!((missed | crossed) >> k & 1)) continue;
      const pk_exact_edges one = pk_exact_edge_functions(&view);
      const bool crosses = pk_exact_cross(&view, &crossing);
      CHECK(crosses == (crossed >> k & 1) && crosses != (missed >> k & 1), "crossing on a grid: %d", crosses);
      ties += one.u == 0 || one.v == 0 || one.w == 0;
      compared++;
    }
  }

  CHECK(ties > 100, "%u rays meet edges", (unsigned)ties);
  return compared;
}

/* pk_batch_setup, beside pk_single_setup of the same set; and boxes of trees, as a packet and one ray ask for them. */
static uint64_t twin_setups(const pktrt_scene *scene) {
  static pk_batch b;
  static pktrt_scene even;
  const pktrt_scene *const s = &even;
  uint64_t compared = 0, valid_rays = 0, met = 0;
  rng r = rng_of(204);

  /* The padding has the same bits only where instances do not stretch them. */
  even = *scene;
  even.stretch = 1;

  for (int round = 0; round < TWIN_ROUNDS; round++) {
    pktrt_ray rays[64];
    pk_bvh box = s->bvhs[0];
    uint64_t valid = 0;

    for (uint32_t i = 0; i < 64; i++) rays[i] = twin_ray(&r, i);
    for (int axis = 0; axis < 3; axis++) {
      const float x = twin_number(&r), y = twin_number(&r);
      box.lo[axis] = fminf(x, y);
      box.hi[axis] = fmaxf(x, y);
    }
    pk_batch_load_rest(&b, rays, NULL, 0, 64);
    for (uint32_t i = 0; i < 64; i += TWIN_WIDTH) valid |= (uint64_t)pk_batch_setup(s, &b, i) << i;
    const uint64_t may = pk_box_test_packet(&b, 0, valid, box.lo, box.hi);

    for (uint32_t i = 0; i < 64; i++) {
      pk_single single;
      memset(&single, 0, sizeof single);
      const bool can = pk_single_setup(s, &rays[i], &single);
      CHECK(can == (valid >> i & 1), "a ray along (%g, %g, %g) can hit: %d", (double)rays[i].direction[0],
          (double)rays[i].direction[1], (double)rays[i].direction[2], can);
      if (!can || !(valid >> i & 1)) continue;

      CHECK(single.axis == pk_axes[b.axis[i]] && single.octant == b.octant[i], "axis %d", (int)b.axis[i]);
      CHECK(single.d_major == b.d_major[i] && single.slope[0] == b.slope[0][i] && single.slope[1] == b.slope[1][i],
          "slopes");
      CHECK(single.pad == b.pad[i], "padding: %g and %g", (double)b.pad[i], (double)single.pad);
      CHECK(single.depth_lo == b.depth_lo[i] && single.sure_lo == b.sure_lo[i] && single.sure_hi == b.sure_hi[i],
          "depths from %g, surely to %g and %g", (double)b.depth_lo[i], (double)b.sure_hi[i], (double)single.sure_hi);
      /* Without an end a batch looks as far as infinity, a single ray as far as any t of a hit. */
      CHECK(single.depth_hi == b.depth_hi[i] || (rays[i].tmax > FLT_MAX && single.depth_hi > b.sure_hi[i]),
          "depths to %g and %g", (double)b.depth_hi[i], (double)single.depth_hi);
      for (int axis = 0; axis < 3; axis++)
        CHECK(single.inverse_d[axis] == b.inverse_d[axis][i] &&
                  single.near_offset[axis] == b.as.slab.near_offset[axis][i] &&
                  single.far_offset[axis] == b.as.slab.far_offset[axis][i],
            "planes: %.9g and %.9g", (double)b.inverse_d[axis][i], (double)single.inverse_d[axis]);
      const bool meets = pk_drive_may_meet(&box, &b.inverse_d[0][i], &b.as.slab.near_offset[0][i],
          &b.as.slab.far_offset[0][i], PK_ROW, b.depth_lo[i], b.depth_hi[i]);
      CHECK(meets == (may >> i & 1), "a box is met: %d", meets);
      met += meets;
      valid_rays++;
      compared += 14;
    }
  }

  CHECK(valid_rays > 1000 && met > valid_rays / 50 && met < valid_rays, "%u of %u meet boxes", (unsigned)met,
      (unsigned)valid_rays);
  return compared;
}

#if PK_WITH_V8_REGISTERS
/* pk_frustum_plane_of and pk_frustum_misses_plane8: the same normal. What lies apart is never hit, and both tests find nearly
   the same rays apart, as their bounds of errors differ in the last bits. */
static uint64_t twin_planes(void) {
  uint64_t compared = 0, apart = 0, differ = 0;
  rng r = rng_of(205);

  for (int round = 0; round < TWIN_ROUNDS; round++) {
    twin_eight e;
    pk_frustum_view8 view;
    pk_frustum_plane8 plane;
    double n[3][8];
    float tmin[8], tmax[8];

    twin_eight_of(&r, round, &e);
    for (int k = 0; k < 8; k++) {
      tmin[k] = k % 3 ? 0 : -1;
      tmax[k] = k % 2 ? INFINITY : fabsf(twin_number(&r));
    }
    for (int i = 0; i < 9; i++) view.p[i / 3][i % 3] = vload(e.p[i / 3][i % 3]);
    for (int i = 0; i < 3; i++) {
      view.o[i] = vload(e.o[i]);
      view.d[i] = vload(e.d[i]);
    }
    pk_frustum_plane_of(&view, &plane);
    for (int i = 0; i < 3; i++) dstore(n[i], plane.n[i]);
    const uint32_t misses = pk_frustum_misses_plane8(&plane, &view, vload(tmin), vload(tmax));

    for (int k = 0; k < 8; k++, compared += 4) {
      pk_exact_view one = twin_view_of(&e, k);
      pk_exact_crossing crossing = {0, 0, false, false};
      double normal[3];
      (void)pk_tri_normal_size(one.p, normal);
      for (int i = 0; i < 3; i++)
        CHECK(same_bits(&normal[i], &n[i][k], sizeof *normal), "normal: %.17g and %.17g", normal[i], n[i][k]);
      const bool is_apart = pk_exact_misses_plane(&one, e.d[0][k], tmin[k] >= 0, tmax[k]);
      const bool crosses = pk_exact_cross(&one, &crossing);
      const float t = crosses ? pk_exact_t(&one, &crossing) : 0;
      const bool is_hit = crosses && tmin[k] < t && t < tmax[k];
      CHECK(!(is_hit && is_apart) && !(is_hit && (misses >> k & 1)), "t = %g is apart", (double)t);
      differ += is_apart != (misses >> k & 1);
      apart += is_apart;
    }
  }

  CHECK(apart > compared / 100 && differ <= apart / 100, "%u of %u are apart, %u differ", (unsigned)apart,
      (unsigned)compared / 4, (unsigned)differ);
  return compared;
}

/* pk_frame_mix8, pk_frame_invert8, pk_frame_rays8 with pk_frame_ray8, and pk_instance_ray. */
static uint64_t twin_places(void) {
  static pk_batch eights, ones;
  uint64_t compared = 0, none = 0;
  rng r = rng_of(206);

  for (int round = 0; round < TWIN_ROUNDS; round++) {
    float keys[24], time[8];
    pk_instance in;
    pk_frame place;
    double8 matrix[3][3], inverse[3][3], shift[3];
    double at[8];
    pktrt_ray rays[16];

    memset(&in, 0, sizeof in);
    in.keys = keys;
    in.key_count = 1 + (uint32_t)round % 2;
    twin_keys(&r, round % 3 == 0, keys);
    pk_frame_mix(keys, keys, 0, pk_frame_is_diagonal(keys, 2), &in.rest);
    pk_frame_invert(&in.rest);
    for (uint32_t i = 0; i < 16; i++) {
      rays[i] = twin_ray(&r, 1 + i); /* finite ones */
      for (int axis = 0; axis < 3; axis++) {
        if (!(fabsf(rays[i].origin[axis]) < 1e18f)) rays[i].origin[axis] = 1;
        if (!(fabsf(rays[i].direction[axis]) < 1e18f)) rays[i].direction[axis] = 1;
      }
    }
    for (int k = 0; k < 8; k++) time[k] = rays[k].time;

    pk_frame_mix8(keys, keys + 12, vload(time), matrix, shift);
    for (int k = 0; k < 8; k++, compared += 12) {
      float weight1;
      (void)pk_time_segment(time[k], 2, &weight1);
      pk_frame_mix(keys, keys + 12, weight1, false, &place);
      for (int i = 0; i < 9; i++) {
        dstore(at, matrix[i / 3][i % 3]);
        CHECK(same_bits(&at[k], &place.a[i / 3][i % 3], sizeof *at), "matrix: %.17g and %.17g", at[k],
            place.a[i / 3][i % 3]);
      }
      for (int i = 0; i < 3; i++) {
        dstore(at, shift[i]);
        CHECK(same_bits(&at[k], &place.shift[i], sizeof *at), "shift: %.17g and %.17g", at[k], place.shift[i]);
      }
    }

    pk_frame_invert8(keys, keys + 12, vload(time), inverse, shift);
    for (int k = 0; k < 8; k++, compared += 9) {
      float weight1;
      (void)pk_time_segment(time[k], 2, &weight1);
      pk_frame_mix(keys, keys + 12, weight1, false, &place);
      pk_frame_invert(&place);
      for (int i = 0; i < 9; i++) {
        dstore(at, inverse[i / 3][i % 3]);
        CHECK(same_bits(&at[k], &place.inverse[i % 3][i / 3], sizeof *at), "inverse: %.17g and %.17g", at[k],
            place.inverse[i % 3][i / 3]);
      }
    }

    pk_batch_load_rest(&eights, rays, NULL, 0, 16);
    pk_batch_load_rest(&ones, rays, NULL, 0, 16);
    pk_frame_rays8(&in, &eights, 0, 16);
    pk_frame_rays(&in, &ones, 0, 16);
    for (uint32_t i = 0; i < 16; i++) {
      pktrt_ray within;
      const bool has_direction = pk_instance_ray(&in, &rays[i], 0.25f, 4, &within);
      const float *const d[3] = {ones.d[0] + i, ones.d[1] + i, ones.d[2] + i};
      CHECK(has_direction == !(*d[0] == 0 && *d[1] == 0 && *d[2] == 0), "direction: %d", has_direction);
      none += !has_direction;
      for (int axis = 0; axis < 3; axis++, compared += 4) {
        CHECK(same_bits(&ones.o[axis][i], &eights.o[axis][i], sizeof(float)), "origin: %.9g and %.9g",
            (double)ones.o[axis][i], (double)eights.o[axis][i]);
        CHECK(same_bits(&ones.d[axis][i], &eights.d[axis][i], sizeof(float)), "direction: %.9g and %.9g",
            (double)ones.d[axis][i], (double)eights.d[axis][i]);
        if (!has_direction) continue;
        CHECK(same_bits(&ones.o[axis][i], &within.origin[axis], sizeof(float)), "origin: %.9g and %.9g of one ray",
            (double)ones.o[axis][i], (double)within.origin[axis]);
        CHECK(same_bits(d[axis], &within.direction[axis], sizeof(float)), "direction: %.9g and %.9g of one ray",
            (double)*d[axis], (double)within.direction[axis]);
      }
      CHECK(within.tmin == 0.25f && within.tmax == 4 && same_bits(&within.time, &rays[i].time, sizeof(float)));
    }
  }

  CHECK(none > 100, "%u rays have no direction", (unsigned)none);
  return compared;
}
#endif

#if PK_WITH_VECTORS
/* pk_frame_edges8. */
static uint64_t twin_turns(void) {
  uint64_t compared = 0;
  rng r = rng_of(207);

  for (int round = 0; round < TWIN_ROUNDS; round++) {
    pk_frame place[8];
    pk_frame_matrix8 turn;
    double m[3][3][8], in[2][3][8], out[2][3][8];
    double8 e[2][3];

    turn.diagonal = round % 3 == 0;
    for (int k = 0; k < 8; k++) {
      place[k].diagonal = turn.diagonal;
      for (int i = 0; i < 9; i++) m[i / 3][i % 3][k] = place[k].a[i / 3][i % 3] = (double)twin_number(&r);
      for (int i = 0; i < 6; i++) in[i / 3][i % 3][k] = (double)twin_number(&r);
    }
    for (int i = 0; i < 9; i++) turn.m[i / 3][i % 3] = dload(m[i / 3][i % 3]);
    for (int i = 0; i < 6; i++) e[i / 3][i % 3] = dload(in[i / 3][i % 3]);
    pk_frame_edges8(&turn, e);
    for (int i = 0; i < 6; i++) dstore(out[i / 3][i % 3], e[i / 3][i % 3]);

    for (int k = 0; k < 8; k++)
      for (int c = 0; c < 2; c++) {
        const double edge[3] = {in[c][0][k], in[c][1][k], in[c][2][k]};
        double turned[3];
        pk_frame_to_scene(&place[k], edge, turned);
        for (int i = 0; i < 3; i++, compared++)
          CHECK(same_bits(&turned[i], &out[c][i][k], sizeof *turned), "edge: %.17g and %.17g", turned[i], out[c][i][k]);
      }
  }

  return compared;
}
#endif

/* pk_resolve_hits and pk_instance_resolve8, for hits of a scene of twin_scene(): lanes hit the trees, the moving instance, or
   instances at rest of one form. */
static uint64_t twin_hits(const pktrt_scene *s, int scale) {
  static pk_batch eights, ones;
  uint64_t compared = 0, instances = 0;
  rng r = rng_of(208);

  for (int round = 0; round < TWIN_ROUNDS / 4; round++) {
    pktrt_ray rays[8];
    pktrt_hit hits[8];
    uint32_t where[8][3], n = 0;

    for (int tries = 0; tries < 400 && n < 8; tries++) {
      const uint32_t target = (uint32_t)round % (TWIN_PLACES + 1);
      rays[n] = twin_ray_at(&r, target, scale);
      if (!s->kernels->intersect(s, &rays[n], PKTRT_NONE, &hits[n], where[n])) continue;
      const uint32_t in = where[n][2], other = n ? where[0][2] : in;
      const bool moves = in && s->instances[in - 1].key_count > 1,
                 other_moves = other && s->instances[other - 1].key_count > 1;
      const bool alike = in && other && !moves && !other_moves &&
                         s->instances[in - 1].rest.diagonal == s->instances[other - 1].rest.diagonal;
      n += in == other || alike;
    }
    if (!n) continue;

    memset(&eights, 0, sizeof eights);
    eights.first_spare_lane = 64;
    pk_batch_load_rest(&eights, rays, NULL, 0, n);
    for (uint32_t k = 0; k < 8; k++) {
      /* The bounds of depth tell nothing, or tell that doubles suffice. */
      const bool close = round % 2 == 0;
      eights.depth_hi[k] = close ? 1 : 1e30f;
      eights.sure_hi[k] = close ? 1 : -1e30f;
      eights.slot[k] = k < n ? where[k][0] : PKTRT_NONE;
      eights.bvh[k] = k < n ? where[k][1] : 0;
      eights.instance[k] = k < n ? where[k][2] : 0;
    }
    ones = eights;
    const uint32_t lanes = (1u << n) - 1;
    const bool placed = where[0][2] != 0;
#if PK_WITH_V8_REGISTERS
    if (placed) pk_instance_resolve8(s, &eights, 0, lanes);
#else
    if (placed) continue;
#endif
    if (!placed) (void)pk_resolve_hits(s, &eights, 0, lanes, NULL);
    pk_single_resolve_hits(s, &ones, 0, lanes, placed);

    for (uint32_t k = 0; k < n; k++, compared += 6) {
      CHECK(same_bits(&ones.t[k], &eights.t[k], sizeof(float)), "t: %.9g and %.9g", (double)ones.t[k],
          (double)eights.t[k]);
      CHECK(same_bits(&ones.as.hit.u[k], &eights.as.hit.u[k], sizeof(float)) &&
                same_bits(&ones.as.hit.v[k], &eights.as.hit.v[k], sizeof(float)),
          "u: %.9g and %.9g, v: %.9g and %.9g", (double)ones.as.hit.u[k], (double)eights.as.hit.u[k],
          (double)ones.as.hit.v[k], (double)eights.as.hit.v[k]);
      for (int axis = 0; axis < 3; axis++)
        CHECK(same_bits(&ones.as.hit.normal[axis][k], &eights.as.hit.normal[axis][k], sizeof(float)),
            "normal: %.9g and %.9g", (double)ones.as.hit.normal[axis][k], (double)eights.as.hit.normal[axis][k]);
      instances += placed;
    }
  }

  CHECK(!PK_WITH_V8_REGISTERS || instances > 500, "%u hits in instances", (unsigned)instances);
  return compared;
}

#if TWIN_WITH_SHADE
/* pk_vec_normalise. */
static uint64_t twin_normals(void) {
  uint64_t compared = 0, refused = 0;
  rng r = rng_of(209);

  for (int round = 0; round < TWIN_ROUNDS; round++) {
    float x[3][8], out[3][8];
    float8 a[3];
    const float8 instead[3] = {vset(7), vset(8), vset(9)};

    for (int i = 0; i < 24; i++) {
      const uint32_t pick = rng_below(&r, 64);
      x[i / 8][i % 8] = i % 8 == 0  ? 0
                        : pick == 0 ? INFINITY
                        : pick == 1 ? NAN
                        : pick == 2 ? FLT_MAX
                        : pick == 3 ? 1e-45f
                        : round % 2 ? twin_number(&r)
                                    : rng_sign(&r);
    }
    for (int i = 0; i < 3; i++) a[i] = vload(x[i]);
    pk_vec_normalise(a, instead);
    for (int i = 0; i < 3; i++) vstore(out[i], a[i]);

    for (int k = 0; k < 8; k++) {
      float v[3] = {x[0][k], x[1][k], x[2][k]};
      const bool good = pk_surface_normalise(v);
      for (int i = 0; i < 3; i++, compared++) {
        const float want = good ? v[i] : (float)(7 + i);
        CHECK(same_bits(&want, &out[i][k], sizeof want), "of (%g, %g, %g): %.9g and %.9g", (double)x[0][k],
            (double)x[1][k], (double)x[2][k], (double)want, (double)out[i][k]);
      }
      refused += !good;
    }
  }

  CHECK(refused > 100, "%u have no direction", (unsigned)refused);
  return compared;
}
#endif

#if TWIN_WITH_FIT
/* pk_vec_sincos, pk_vec_disk and pk_vec_along. */
static uint64_t twin_maps(void) {
  uint64_t compared = 0;
  rng r = rng_of(210);

  for (int round = 0; round < TWIN_ROUNDS; round++) {
    double x[8], p[3][8], n[3][8], a[3][8];
    float u[2][8];
    double8 turn[2], disk[2], axis[3], vector[3];

    for (int k = 0; k < 8; k++) {
      double unit[3] = {(double)twin_number(&r), (double)twin_number(&r), (double)twin_number(&r)};
      if (k == 0) unit[0] = unit[1] = 0; /* along z */
      if (!pk_normalise(unit)) unit[2] = k % 2 ? 1 : -1, unit[0] = unit[1] = 0;
      for (int i = 0; i < 3; i++) {
        n[i][k] = unit[i];
        p[i][k] = (double)rng_sign(&r) * (k % 3 ? 1 : 1e-300);
      }
      x[k] = k == 1   ? PK_PI / 4
             : k == 2 ? -0.0
                      : PK_PI / 4 * (double)(k % 2 ? rng_sign(&r) : twin_number(&r) * 0x1p-32f);
      u[0][k] = twin_unit(&r);
      u[1][k] = k == 3 ? u[0][k] : k == 4 ? 1e-40f : twin_unit(&r); /* on diagonals, and near corners */
    }
    turn[0] = turn[1] = dload(x);
    for (int i = 0; i < 2; i++) disk[i] = dfrom(vload(u[i]));
    for (int i = 0; i < 3; i++) {
      axis[i] = dload(n[i]);
      vector[i] = dload(p[i]);
    }
    pk_vec_sincos(turn);
    pk_vec_disk(disk);
    pk_vec_along(axis, vector);

    for (int i = 0; i < 2; i++) dstore(a[i], turn[i]);
    for (int k = 0; k < 8; k++, compared += 2) {
      double sine, cosine;
      pk_math_sincos(x[k], &sine, &cosine);
      CHECK(same_bits(&sine, &a[0][k], sizeof sine) && same_bits(&cosine, &a[1][k], sizeof cosine),
          "sine: %.17g and %.17g", sine, a[0][k]);
    }

    for (int i = 0; i < 2; i++) dstore(a[i], disk[i]);
    for (int k = 0; k < 8; k++, compared += 2) {
      const float square[2] = {u[0][k], u[1][k]};
      double one[2];
      pk_map_to_disk(square, one);
      CHECK(same_bits(&one[0], &a[0][k], sizeof *one) && same_bits(&one[1], &a[1][k], sizeof *one),
          "disk: %.17g and %.17g", one[0], a[0][k]);
    }

    for (int i = 0; i < 3; i++) dstore(a[i], vector[i]);
    for (int k = 0; k < 8; k++, compared += 3) {
      const double unit[3] = {n[0][k], n[1][k], n[2][k]};
      double one[3];
      pk_map_along(unit, p[0][k], p[1][k], p[2][k], one);
      for (int i = 0; i < 3; i++)
        CHECK(same_bits(&one[i], &a[i][k], sizeof *one), "turned: %.17g and %.17g", one[i], a[i][k]);
    }
  }

  return compared;
}
#endif

/* What this set compares, for the report of tree.c. */
static void twins_all(void) {
  uint64_t compared = twin_sums() + twin_edges() + twin_grids();
#if PK_WITH_V8_REGISTERS
  compared += twin_planes() + twin_places();
#endif
#if PK_WITH_VECTORS
  compared += twin_turns();
#endif
#if TWIN_WITH_SHADE
  compared += twin_normals();
#endif
#if TWIN_WITH_FIT
  compared += twin_maps();
#endif
  for (int kind = 0; kind < 3; kind++) {
    const int scale = kind == 0 ? 0 : kind == 1 ? -20 : 20;
    pktrt_scene *s = twin_scene(TWIN_ISA, scale);
    if (!kind) compared += twin_setups(s);
    compared += twin_hits(s, scale);
    pktrt_scene_destroy(s);
  }
  say("%s: %llu values", pktrt_isa_string(TWIN_ISA), (unsigned long long)compared);
  CHECK(compared > 100000, "only %u", (unsigned)compared);
}

#undef double8
#undef float8
#undef mask8
#undef dadd
#undef dfrom
#undef dload
#undef dmul
#undef dset
#undef dstore
#undef vadd
#undef vload
#undef vmax
#undef vmul
#undef vset
#undef vstore
#undef twins_all
#undef twin_edges
#undef twin_grids
#undef twin_hits
#undef twin_maps
#undef twin_normals
#undef twin_places
#undef twin_planes
#undef twin_setups
#undef twin_sums
#undef twin_turns
#undef TWIN_ISA
#undef TWIN_TURNS
#undef TWIN_WIDTH
#undef TWIN_WITH_FIT
#undef TWIN_WITH_SHADE
