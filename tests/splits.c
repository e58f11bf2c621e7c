/* Split triangles, of trees of the high quality: the same bits as whole ones, boxes that cover them, so many prims and no
   more, whatever the number of workers. */
#include "noslack.h"
#include "tree.h"
#include "ways.h"

/* Long thin triangles criss-cross among small ones and large walls that lie askew; some twice, so that there are ties. All on a
   grid with so many lines in a unit: with few, corners lie in planes that triangles are split by. */
static mesh crossed(uint32_t beams, uint64_t seed, float lines) {
  mesh m = mesh_soup(8 * beams, 0.05f, seed);
  for (uint32_t t = 0; t < 2 * beams; t++) {
    rng r = rng_of(seed + (t < beams ? t : t - beams % 7)); /* beams % 7 of the first come again */
    float *p = m.p + 9 * (size_t)t;
    for (uint32_t c = 0; c < 9; c++) p[c] = rng_sign(&r);
    for (uint32_t a = 0; a < 3 && t % 64; a++) p[6 + a] = p[3 + a] + 0.02f * rng_sign(&r);
  }
  for (size_t i = 0; i < (size_t)m.nv * 3; i++) m.p[i] = roundf(m.p[i] * lines) / lines;
  return m;
}
static world crossed_world_on(float lines) {
  world w = world_of(crossed(small_run ? 100 : 400, 5, lines));
  w.m[w.n++] = mesh_grid(8, 1.5f);
  return w;
}

static world crossed_world(void) { return crossed_world_on(1024); }

static pktrt_scene *high_scene(const world *w, pktrt_isa isa, int workers) {
  pktrt_scene_desc d = scene_desc_of(isa, workers);
  d.quality = PKTRT_BUILD_HIGH, d.rebuild = PKTRT_REBUILD_NEVER;
  pktrt_scene *s = pktrt_scene_create(&d);
  for (uint32_t i = 0; i < w->n; i++) CHECK(mesh_add(s, &w->m[i], NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  return s;
}
static void sound(const pktrt_scene *s) {
  const char *fault = tree_fault(s);
  CHECK(!fault, "%s", fault);
}

static void same_bits_as_whole(void) {
  const size_t n = small_run ? 256 : MANY;
  size_t wrong = 0, hits = 0;
  uint64_t split = 0;
  world w = crossed_world();
  for (int k = 0; k < isa_count; k++) {
    pktrt_scene *whole = world_scene(&w, isas[k], 0), *s = high_scene(&w, isas[k], 0);
    CHECK(tree_split(whole) == 0), split = tree_split(s);
    sound(s);
    hits += compare(whole, s, &w, n, &wrong);
    pktrt_scene_destroy(whole), pktrt_scene_destroy(s);
  }
  world_free(&w);
  CHECK(split > 50, "%u prims more", (unsigned)split);
  CHECK(wrong == 0, "%zu answers differ", wrong);
  say("%u prims more than triangles; %zu hits, seven ways each, and all crossings: %zu differ", (unsigned)split, hits,
      wrong);
}

/* Parts of a triangle with a corner in the plane that splits it have this corner, both of them. */
static void same_bits_with_corners_in_planes(void) {
  static const float lines[] = {8, 16};
  const size_t n = small_run ? 256 : MANY;
  for (size_t i = 0; i < COUNT(lines); i++) {
    size_t wrong = 0;
    world w = crossed_world_on(lines[i]);
    pktrt_scene *whole = world_scene(&w, PKTRT_ISA_AUTO, 0), *s = high_scene(&w, PKTRT_ISA_AUTO, 0);
    const uint64_t more = tree_split(s);
    sound(s);
    const size_t hits = compare(whole, s, &w, n, &wrong);
    CHECK(more > 50 && hits > n && wrong == 0, "%g lines: %u prims more, %zu answers differ of %zu hits",
        (double)lines[i], (unsigned)more, wrong, hits);
    say("%2g lines in a unit: %3u prims more, %zu hits: %zu differ", (double)lines[i], (unsigned)more, hits, wrong);
    pktrt_scene_destroy(whole), pktrt_scene_destroy(s);
    world_free(&w);
  }
}

/* Worlds of any size, tiny and huge by powers of two, which round nothing. */
static void same_bits_at_any_size(void) {
  static const int sizes[] = {-60, -3, 40};
  const size_t n = small_run ? 64 : 128;
  size_t wrong = 0, hits = 0;
  uint64_t split = 0, times = 0;
  for (size_t i = 0; i < COUNT(sizes); i++) {
    world w = crossed_world();
    for (uint32_t k = 0; k < w.n; k++)
      for (size_t v = 0; v < (size_t)w.m[k].nv * 3; v++) w.m[k].p[v] = ldexpf(w.m[k].p[v], sizes[i]);
    pktrt_scene *whole = world_scene(&w, PKTRT_ISA_AUTO, 0), *s = high_scene(&w, PKTRT_ISA_AUTO, 0);
    const uint64_t more = tree_split(s);
    sound(s);
    hits += compare(whole, s, &w, n, &wrong);
    CHECK(i == 0 || more == split, "%llu prims more, %llu at other sizes", (unsigned long long)more,
        (unsigned long long)split);
    split = more, times += more > 50;
    pktrt_scene_destroy(whole), pktrt_scene_destroy(s);
    world_free(&w);
  }
  CHECK(times == COUNT(sizes) && wrong == 0 && hits > n, "%zu answers differ of %zu hits", wrong, hits);
  say("%zu sizes, %zu hits: %zu differ", COUNT(sizes), hits, wrong);
}

static void deform(world *w, pktrt_scene *s) {
  mesh_place(&w->m[0], (float[3]){1, 0.5f, 1.25f}, (float[3]){0, 0.5f, 0});
  CHECK(pktrt_set_positions(s, 0, 0, w->m[0].p) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
}
static void deformed_and_hidden(void) {
  const size_t n = small_run ? 256 : MANY / 2;
  size_t wrong = 0, hits = 0;
  for (int k = 0; k < isa_count; k++) {
    world w = crossed_world();
    pktrt_scene *s = high_scene(&w, isas[k], 0);
    const uint64_t split = tree_split(s);
    deform(&w, s);
    sound(s);
    CHECK(tree_split(s) == split && split > 0, "a refit leaves prims as they are");
    pktrt_scene *whole = world_scene(&w, isas[k], 0);
    hits += compare(whole, s, &w, n, &wrong);
    for (int shown = 0; shown < 2; shown++) {
      CHECK(pktrt_set_enabled(s, 0, shown) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK);
      CHECK(pktrt_set_enabled(whole, 0, shown) == PKTRT_OK && pktrt_refit(whole) == PKTRT_OK);
      hits += compare(whole, s, &w, n, &wrong);
    }
    CHECK(pktrt_mark_changed(s) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
    CHECK(tree_split(s) == 0, "what deforms is not split again");
    hits += compare(whole, s, &w, n, &wrong);
    pktrt_scene_destroy(whole), pktrt_scene_destroy(s);
    world_free(&w);
  }
  CHECK(wrong == 0, "%zu answers differ", wrong);
  say("%zu hits: %zu differ", hits, wrong);
}

/* A model in two places, and many, whose boxes have a tree of the high quality. */
static pktrt_scene *placed(const world *w, pktrt_isa isa, pktrt_build_quality quality) {
  static const float straight[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0},
                     turned[12] = {0, 1, 0, 0.5f, -1, 0, 0, 0, 0, 0, 2, 1};
  pktrt_scene_desc d = scene_desc_of(isa, 0);
  const pktrt_mesh_desc beams = mesh_desc(&w->m[0]), floor = mesh_desc(&w->m[1]);
  uint32_t model = 0, small = 0;
  d.quality = quality;
  pktrt_scene *s = pktrt_scene_create(&d);
  bool ok = pktrt_add_model(s, &beams, 1, &model) == PKTRT_OK && pktrt_add_model(s, &floor, 1, &small) == PKTRT_OK;
  for (uint32_t i = 0; i < 300 && ok; i++) {
    const float along[12] = {4, 0, 0, 0.02f * (float)i, 0.25f, 1, 0.25f, -3, 0, 0, 4, -0.04f * (float)i};
    const pktrt_instance_desc in = {i < 2 ? model : small, 1,
        i > 1 ? along
        : i   ? turned
              : straight,
        0, PKTRT_INTERPOLATION_LINEAR};
    ok = pktrt_add_instance(s, &in, NULL) == PKTRT_OK;
  }
  CHECK(ok && pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  return s;
}
static void placed_has_the_bits(void) {
  const size_t n = small_run ? 64 : 256;
  size_t wrong = 0, hits = 0;
  world w = crossed_world();
  for (int k = 0; k < isa_count; k++) {
    pktrt_scene *whole = placed(&w, isas[k], PKTRT_BUILD_DEFAULT), *s = placed(&w, isas[k], PKTRT_BUILD_HIGH);
    CHECK(tree_split(s) > 0 && tree_split(whole) == 0);
    hits += compare(whole, s, &w, n, &wrong);
    pktrt_scene_destroy(whole), pktrt_scene_destroy(s);
  }
  world_free(&w);
  CHECK(wrong == 0, "%zu answers differ", wrong);
  say("%zu hits: %zu differ", hits, wrong);
}

/* Rays through points of the long triangles; those that meet nothing there. */
static size_t missed(const world *w, const pktrt_scene *s, bool copy) {
  static pktrt_ray ray[MANY];
  static pktrt_hit hit[MANY];
  static bool hidden[MANY];
  pktrt_query_desc q;
  size_t lost = 0;
  memset(&q, 0, sizeof q);
  for (uint32_t i = 0; i < MANY; i++) {
    rng r = rng_of(i);
    const mesh *m = &w->m[0];
    const uint32_t *c = m->i + 3 * (size_t)rng_below(&r, m->nt / 4);
    const float u = rng_unit(&r), v = rng_unit(&r) * (1 - u);
    float p[3], d[3];
    for (uint32_t a = 0; a < 3; a++) {
      p[a] = (1 - u - v) * m->p[3 * c[0] + a] + u * m->p[3 * c[1] + a] + v * m->p[3 * c[2] + a];
      d[a] = rng_sign(&r);
    }
    ray[i] = ray_of(p[0] - d[0], p[1] - d[1], p[2] - d[2], d[0], d[1], d[2]);
    ray[i].tmin = 1 - 0x1p-10f, ray[i].tmax = 1 + 0x1p-10f;
  }
  for (int path = PKTRT_PATH_FAST; path <= PKTRT_PATH_SINGLE; path++) {
    q.path = (pktrt_path)path;
    (copy ? noslack_intersect : pktrt_intersect_ex)(s, &q, ray, hit, MANY);
    (copy ? noslack_occluded : pktrt_occluded_ex)(s, &q, ray, hidden, MANY);
    for (uint32_t i = 0; i < MANY; i++) {
      pktrt_hit want;
      const bool there = ref_intersect(w, &ray[i], &want);
      lost += there && (!same_bits(&hit[i], &want, sizeof want) || !hidden[i]);
    }
  }
  return lost;
}
static void covered(void) {
  uint64_t points = 0, ignored = 0;
  world w = crossed_world();
  pktrt_scene *s = high_scene(&w, PKTRT_ISA_AUTO, 0);
  const uint64_t lost = tree_uncovered(s, 0, &points), control = tree_uncovered(s, 0x1p-20f, &ignored);
  CHECK(lost == 0 && points > 1000, "%u of %u points", (unsigned)lost, (unsigned)points);
  CHECK(control > 100, "the control, boxes smaller by a millionth, leaves %u out", (unsigned)control);
  const size_t rays = missed(&w, s, false);
  pktrt_scene_destroy(s);
  slack_left = slack_whole;
  size_t missed_by[2];
  for (int i = 0; i < 2; i++) {
    slack_left.parts = i ? -0x1p18f : 1;
    pktrt_scene *copy = noslack_split(&w, PKTRT_ISA_AUTO);
    if (!CHECK(copy != NULL)) break;
    missed_by[i] = missed(&w, copy, true);
    noslack_destroy(copy);
  }
  slack_left = slack_none;
  CHECK(rays == 0 && missed_by[0] == 0, "%zu, and by the copy %zu", rays, missed_by[0]);
  CHECK(missed_by[1] > 20, "the control, parts with smaller boxes, misses %zu", missed_by[1]);
  say("%u points of edges, %u outside all boxes, control, smaller boxes: %u; rays to triangles: %zu miss, control, "
      "boxes of parts smaller by 2^-5: %zu",
      (unsigned)points, (unsigned)lost, (unsigned)control, rays, missed_by[1]);
  world_free(&w);
}

static void bounded(void) {
  world w = world_of(crossed(400, 7, 1024));
  const uint32_t n = w.m[0].nt;
  pktrt_scene_info info, whole_info;
  for (uint32_t i = 0; i < n / 16; i++) /* long ones everywhere: more would be split than may be */
    for (uint32_t a = 0; a < 9; a++) w.m[0].p[9 * (n - 1 - i) + a] = w.m[0].p[9 * i + a];
  memset(w.m[0].p, 0, 9 * sizeof *w.m[0].p); /* one has no area */
  pktrt_scene *s = high_scene(&w, PKTRT_ISA_AUTO, 0), *whole = world_scene(&w, PKTRT_ISA_AUTO, 0);
  const uint64_t split = tree_split(s);
  CHECK(split > n / 24 && split <= n / 6, "%u of %u are split", (unsigned)split, (unsigned)n);
  for (int flat = 0; flat < 2; flat++) {
    pktrt_get_scene_info(s, &info), pktrt_get_scene_info(whole, &whole_info);
    CHECK(info.triangles == n && info.degenerate == whole_info.degenerate, "%u without area, not %u",
        (unsigned)info.degenerate, (unsigned)whole_info.degenerate);
    for (int a = 0; a < 3; a++)
      CHECK(info.bounds_lo[a] == whole_info.bounds_lo[a] && info.bounds_hi[a] == whole_info.bounds_hi[a],
          "bounds differ");
    for (size_t i = 0; i < (size_t)n * 9; i++) w.m[0].p[i] = i % 3 ? 0 : w.m[0].p[i]; /* now none has */
    CHECK(pktrt_set_positions(s, 0, 0, w.m[0].p) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK);
    CHECK(pktrt_set_positions(whole, 0, 0, w.m[0].p) == PKTRT_OK && pktrt_refit(whole) == PKTRT_OK);
  }
  say("%u prims more than %u triangles", (unsigned)split, (unsigned)n);
  pktrt_scene_destroy(s), pktrt_scene_destroy(whole);
  world_free(&w);
}

/* The memory at most, of the high quality and of the default one, per triangle. */
static void memory_is_stated(void) {
  world w = world_of(crossed(small_run ? 1000 : 8000, 3, 1024));
  double peak[2], bytes[2];
  for (int high = 0; high < 2; high++) {
    const size_t before = hooks.peak_bytes = hooks.live_bytes;
    pktrt_scene *s = high ? high_scene(&w, PKTRT_ISA_AUTO, 0) : world_scene(&w, PKTRT_ISA_AUTO, 0);
    peak[high] = (double)(hooks.peak_bytes - before) / w.m[0].nt;
    bytes[high] = (double)(hooks.live_bytes - before) / w.m[0].nt;
    pktrt_scene_destroy(s);
  }
  CHECK(bytes[1] < 1.35 * bytes[0], "%g bytes per triangle, not %g", bytes[1], bytes[0]);
  CHECK(peak[1] < peak[0] + 35, "%g bytes per triangle while built, default %g", peak[1], peak[0]);
  say("bytes per triangle %.1f, while built %.1f; default %.1f, %.1f", bytes[1], peak[1], bytes[0], peak[0]);
  world_free(&w);
}

static bool same_tree(const pktrt_scene *a, const pktrt_scene *b) {
  pktrt_node x, y;
  uint32_t i = 0;
  for (; pktrt_get_node(a, 0, i, 0, &x); i++)
    if (!pktrt_get_node(b, 0, i, 0, &y) || !same_bits(&x, &y, sizeof x)) return false;
  return i > 1 && !pktrt_get_node(b, 0, i, 0, &y);
}
static void workers(void) {
  static const int count[4] = {0, 1, 2, 7};
  world w = world_of(crossed(small_run ? 1200 : 4000, 1, 1024));
  pktrt_scene *s[4];
  for (int i = 0; i < 4; i++) s[i] = high_scene(&w, PKTRT_ISA_AUTO, count[i]);
  for (int i = 1; i < 4; i++) CHECK(same_tree(s[0], s[i]), "%d workers build another tree", count[i]);
  CHECK(tree_split(s[0]) > 100);
  sound(s[3]);
  for (int i = 0; i < 4; i++) pktrt_scene_destroy(s[i]);
  world_free(&w);
}

/* Many small boxes beside each other on two triangles, which are flat along an axis. */
static world floor_world(void) {
  const uint32_t side = 64;
  mesh m = mesh_soup(2 + 4 * side * side, 0.01f, 9);
  for (uint32_t t = 0; t < m.nt; t++)
    for (uint32_t c = 0; c < 3; c++) {
      float *p = m.p + 9 * (size_t)t + 3 * (size_t)c;
      const uint32_t cell = t < 2 ? 0 : (t - 2) / 4;
      if (t < 2) p[0] = (c > 0) == (t == 0) ? 1 : -1, p[1] = 0, p[2] = c == 1 ? 1 : -1;
      else if (c == 0) p[0] = (float)(cell % side) / 32 - 1, p[1] = 0.01f, p[2] = (float)(cell / side) / 32 - 1;
      else p[0] = p[-3 * (int)c] + 0.01f * (float)(t % 3), p[1] = 0.01f * (float)c, p[2] = p[2 - 3 * (int)c] + 0.01f;
    }
  return world_of(m);
}

/* Split or not: the cheaper tree, which beams across each other make that of split triangles. */
static void cheaper_is_taken(void) {
  pktrt_scene_info info[2];
  for (int beams = 0; beams < 2; beams++) {
    world w = beams ? world_of(crossed(400, 5, 1024)) : floor_world();
    pktrt_scene *whole = world_scene(&w, PKTRT_ISA_AUTO, 0), *s = high_scene(&w, PKTRT_ISA_AUTO, 0);
    pktrt_get_scene_info(whole, &info[0]), pktrt_get_scene_info(s, &info[1]);
    const double share = (info[1].sah_at_build - 1) / (info[0].sah_at_build - 1);
    if (beams) CHECK(tree_split(s) > 0 && share < 0.9, "%g of the default tree's cost", share);
    else CHECK(tree_split(s) == 0 && same_tree(s, whole), "%g of the default tree's cost", share);
    say("%s: the tree of the high quality costs %.3f of the default one", beams ? "beams" : "a floor", share);
    pktrt_scene_destroy(whole), pktrt_scene_destroy(s);
    world_free(&w);
  }
}

void suite_splits(void) {
  run("split triangles have the bits of whole ones, every way", same_bits_as_whole);
  run("split triangles have the bits of whole ones where corners lie in the planes that split",
      same_bits_with_corners_in_planes);
  run("split triangles have the bits of whole ones in tiny scenes and huge ones", same_bits_at_any_size);
  run("split triangles that are deformed or hidden have the bits of whole ones", deformed_and_hidden);
  run("instances of split models have the bits of whole ones", placed_has_the_bits);
  run("boxes cover split triangles, and smaller ones would not", covered);
  run("at most a sixth more prims than triangles are made, and triangles are counted once", bounded);
  run("split triangles take the memory that is stated", memory_is_stated);
  run("any number of workers splits the same triangles", workers);
  run("triangles are split where that makes a tree cheaper, and otherwise it is the default one", cheaper_is_taken);
}
