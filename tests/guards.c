/* The ends of arrays: every public call that fills an array fills all of it and nothing beside it, and reads nothing behind the
   arrays that it is given, for counts around all widths of vectors and packets. */
#if !defined(_GNU_SOURCE)
#define _GNU_SOURCE /* MAP_ANONYMOUS */
#endif
#include "pictures.h"
#ifndef __EMSCRIPTEN__
#include <sys/mman.h>
#include <unistd.h>
#endif

static const size_t COUNTS[] = {0, 1, 2, 3, 7, 8, 9, 15, 16, 17, 31, 33, 63, 64, 65, 127, 129, 255, 256, 257};
enum { MOST = 257, LAYERS = 40 };

/* --- guarded arrays --- */

/* An array between two runs of guard bytes. It begins at an odd multiple of four bytes, since callers' arrays do. */
enum { GUARD_BYTES = 4 * 21, GUARD_VALUE = 0xC3 };
typedef struct guarded {
  unsigned char *memory;
  void *array;
  size_t size;
} guarded;

static size_t arrays_checked;

static guarded guarded_array(size_t count, size_t size) {
  guarded g = {NULL, NULL, count * size};
  g.memory = malloc(g.size + 2 * GUARD_BYTES + 16);
  if (!g.memory) abort();
  memset(g.memory, GUARD_VALUE, g.size + 2 * GUARD_BYTES + 16);
  g.array = g.memory + GUARD_BYTES + (size > 4 ? 4 : 0);
  return g;
}

/* Returns whether both guards have kept their values. */
static bool guards_hold(const guarded *g) {
  const unsigned char *array = g->array;
  bool hold = true;
  for (const unsigned char *p = g->memory; p < array; p++) hold &= *p == GUARD_VALUE;
  for (size_t i = 0; i < GUARD_BYTES; i++) hold &= array[g->size + i] == GUARD_VALUE;
  arrays_checked++;
  return hold;
}

/* Returns how many of the elements, of `size` bytes each, have been written at all. */
static size_t elements_written(const guarded *g, size_t size) {
  const unsigned char *array = g->array;
  size_t written = 0;
  for (size_t i = 0; i < g->size / size; i++) {
    bool touched = false;
    for (size_t k = 0; k < size; k++) touched |= array[i * size + k] != GUARD_VALUE;
    written += touched;
  }
  return written;
}

/* Checks that the call has written all elements and nothing beside them, and frees the array. */
static void check_filled(guarded *g, size_t size, const char *call, size_t n) {
  CHECK(guards_hold(g), "%s of %zu writes beside its array", call, n);
  const size_t written = elements_written(g, size);
  CHECK(written == g->size / size, "%s of %zu writes %zu of %zu elements", call, n, written, g->size / size);
  free(g->memory);
}

/* Checks the guards alone, and frees the array. */
static void check_guards(guarded *g, const char *call, size_t n) {
  CHECK(guards_hold(g), "%s of %zu writes beside its array", call, n);
  free(g->memory);
}

/* --- arrays that end where memory does --- */

#ifndef __EMSCRIPTEN__
/* A copy of an array that ends right before a page which nobody may touch: who reads behind it, crashes. */
static void *copy_before_a_hole(const void *from, size_t size, void **mapping, size_t *mapped) {
  const size_t page = (size_t)sysconf(_SC_PAGESIZE);
  const size_t pages = (size + page - 1) / page + 1;
  *mapped = pages * page;
  *mapping = mmap(NULL, *mapped, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (*mapping == MAP_FAILED || mprotect((char *)*mapping + *mapped - page, page, PROT_NONE)) abort();
  void *copy = (char *)*mapping + *mapped - page - size;
  if (size) memcpy(copy, from, size);
  return copy;
}
#endif

/* An input array of that kind, where the platform has pages; else a copy of its exact size, for sanitizers. */
typedef struct input {
  void *array, *mapping;
  size_t mapped;
} input;

static input input_of(const void *from, size_t size) {
  input in = {NULL, NULL, 0};
#ifndef __EMSCRIPTEN__
  in.array = copy_before_a_hole(from, size, &in.mapping, &in.mapped);
#else
  in.array = in.mapping = malloc(size ? size : 1);
  if (!in.array) abort();
  memcpy(in.array, from, size);
#endif
  return in;
}

static void input_free(input *in) {
#ifndef __EMSCRIPTEN__
  munmap(in->mapping, in->mapped);
#else
  free(in->mapping);
#endif
}

/* --- a scene with many crossings: sheets one above the other, a moving ball, an instance --- */

typedef struct stand {
  pktrt_scene *scene;
  uint32_t ball;
  pktrt_ray rays[MOST];
  pktrt_hit hits[MOST];
  float directions[3 * MOST], times[MOST], points[3 * MOST];
  pktrt_point_query queries[MOST];
} stand;

static void stand_open(stand *st, pktrt_isa isa) {
  const pktrt_scene_desc d = scene_desc_of(isa, 0);
  st->scene = pktrt_scene_create(&d);
  if (!CHECK(st->scene != NULL, "%s", pktrt_last_error(NULL))) abort();

  mesh sheets = mesh_of(3 * LAYERS, LAYERS);
  for (uint32_t i = 0; i < LAYERS; i++) {
    const float y = -(float)i * 0.125f;
    const float corners[9] = {-9, y, -9, -9, y, 18, 18, y, -9};
    memcpy(sheets.p + 9 * (size_t)i, corners, sizeof corners);
    for (uint32_t k = 0; k < 3; k++) sheets.i[3 * i + k] = 3 * i + k;
  }
  CHECK(mesh_add(st->scene, &sheets, NULL) == PKTRT_OK);
  mesh_free(&sheets);

  mesh ball = mesh_sphere(2, 0.1f, 5);
  mesh_shift(&ball, 0, 2, 0);
  mesh_move(&ball, 2, 0.3f, 0.01f, 6);
  CHECK(mesh_add(st->scene, &ball, &st->ball) == PKTRT_OK);

  mesh_shift(&ball, 0, -2, 0);
  const pktrt_mesh_desc model_mesh = mesh_desc(&ball);
  uint32_t model = 0;
  CHECK(pktrt_add_model(st->scene, &model_mesh, 1, &model) == PKTRT_OK);
  const float transform[12] = {1, 0, 0, 2.5f, 0, 1.5f, 0, 2, 0, 0.25f, 1, 0};
  pktrt_instance_desc instance;
  memset(&instance, 0, sizeof instance);
  instance.model = model;
  instance.transforms = transform;
  instance.key_count = 1;
  CHECK(pktrt_add_instance(st->scene, &instance, NULL) == PKTRT_OK);
  mesh_free(&ball);
  CHECK(pktrt_commit(st->scene) == PKTRT_OK, "%s", pktrt_last_error(st->scene));

  rng random = rng_of(77);
  for (uint32_t i = 0; i < MOST; i++) {
    const bool similar = i % 64 < 40;
    pktrt_ray ray = ray_of(0.1f, 6, 0.2f, rng_sign(&random) * (similar ? 0.1f : 1), -1, rng_sign(&random) * 0.2f);
    ray.time = rng_unit(&random);
    if (i % 29 == 3) ray.direction[1] = 1; /* into the sky */
    st->rays[i] = ray;
    st->times[i] = ray.time;
    for (int k = 0; k < 3; k++) st->directions[3 * i + (uint32_t)k] = rng_sign(&random);
    for (int k = 0; k < 3; k++) st->points[3 * i + (uint32_t)k] = rng_sign(&random) + (k == 1 ? 2 : 0);
    memcpy(st->queries[i].point, st->points + 3 * i, sizeof st->queries[i].point);
    st->queries[i].max_distance = 1, st->queries[i].time = ray.time, st->queries[i].mask = i % 5;
  }
  pktrt_intersect_n(st->scene, st->rays, st->hits, MOST);
}

/* --- queries --- */

typedef struct inputs {
  input rays, hits, directions, times, points, queries;
} inputs;

static inputs inputs_of(const stand *st, size_t n) {
  const inputs in = {input_of(st->rays, n * sizeof *st->rays), input_of(st->hits, n * sizeof *st->hits),
      input_of(st->directions, n * 12), input_of(st->times, n * 4), input_of(st->points, n * 12),
      input_of(st->queries, n * sizeof *st->queries)};
  return in;
}

static void inputs_free(inputs *in) {
  input_free(&in->rays);
  input_free(&in->hits);
  input_free(&in->directions);
  input_free(&in->times);
  input_free(&in->points);
  input_free(&in->queries);
}

/* Calls with arrays of structs. */
static void guard_arrays(const stand *st, size_t n) {
  const pktrt_scene *scene = st->scene;
  inputs in = inputs_of(st, n);
  guarded g = guarded_array(n, sizeof(pktrt_hit));
  pktrt_intersect_n(scene, in.rays.array, g.array, n);
  check_filled(&g, sizeof(pktrt_hit), "pktrt_intersect_n", n);

  g = guarded_array(n, sizeof(bool));
  pktrt_occluded_n(scene, in.rays.array, g.array, n);
  check_filled(&g, sizeof(bool), "pktrt_occluded_n", n);

  g = guarded_array(n, sizeof(pktrt_hit));
  pktrt_intersect_after_n(scene, in.rays.array, in.hits.array, g.array, n);
  check_filled(&g, sizeof(pktrt_hit), "pktrt_intersect_after_n", n);

  g = guarded_array(n, sizeof(int));
  pktrt_winding_n(scene, st->ball, in.points.array, in.times.array, g.array, n);
  check_filled(&g, sizeof(int), "pktrt_winding_n", n);

  g = guarded_array(n, sizeof(pktrt_closest));
  pktrt_closest_point_n(scene, in.queries.array, g.array, n);
  check_filled(&g, sizeof(pktrt_closest), "pktrt_closest_point_n", n);

  g = guarded_array(n, sizeof(pktrt_ray));
  pktrt_spawn_n(scene, in.rays.array, in.hits.array, in.directions.array, g.array, n);
  check_filled(&g, sizeof(pktrt_ray), "pktrt_spawn_n", n);

  g = guarded_array(n, sizeof(pktrt_surface_info));
  pktrt_surface_n(scene, in.rays.array, in.hits.array, g.array, n);
  check_filled(&g, sizeof(pktrt_surface_info), "pktrt_surface_n", n);

  g = guarded_array(n, sizeof(pktrt_ray));
  pktrt_spawn_at_n(scene, in.hits.array, in.times.array, in.directions.array, g.array, n);
  check_filled(&g, sizeof(pktrt_ray), "pktrt_spawn_at_n", n);

  static const pktrt_path paths[] = {PKTRT_PATH_FAST, PKTRT_PATH_PAPER, PKTRT_PATH_SINGLE};
  for (size_t k = 0; k < COUNT(paths); k++) {
    pktrt_query_desc query;
    memset(&query, 0, sizeof query);
    query.path = paths[k];
    query.packet_size = n % 2 ? 16 : 0;
    g = guarded_array(n, sizeof(pktrt_hit));
    pktrt_intersect_ex(scene, &query, in.rays.array, g.array, n);
    check_filled(&g, sizeof(pktrt_hit), "pktrt_intersect_ex", n);
    g = guarded_array(n, sizeof(bool));
    pktrt_occluded_ex(scene, &query, in.rays.array, g.array, n);
    check_filled(&g, sizeof(bool), "pktrt_occluded_ex", n);
  }
  inputs_free(&in);
}

/* Calls with an array for each coordinate. */
static void guard_coordinates(const stand *st, size_t n) {
  enum { ORIGIN, DIRECTION = 3, TMIN = 6, TMAX, TIME, ROWS };
  float values[ROWS][MOST];
  for (size_t i = 0; i < n; i++) {
    for (int k = 0; k < 3; k++) {
      values[ORIGIN + k][i] = st->rays[i].origin[k];
      values[DIRECTION + k][i] = st->rays[i].direction[k];
    }
    values[TMIN][i] = st->rays[i].tmin;
    values[TMAX][i] = st->rays[i].tmax;
    values[TIME][i] = st->rays[i].time;
  }
  input rows[ROWS];
  for (int row = 0; row < ROWS; row++) rows[row] = input_of(values[row], 4 * n);
  const pktrt_rays rays = {{rows[0].array, rows[1].array, rows[2].array}, {rows[3].array, rows[4].array, rows[5].array},
      rows[TMIN].array, rows[TMAX].array, rows[TIME].array};
  for (int path = 0; path < 4; path++) {
    pktrt_query_desc query;
    memset(&query, 0, sizeof query);
    query.path = path == 2 ? PKTRT_PATH_PAPER : path == 3 ? PKTRT_PATH_SINGLE : PKTRT_PATH_FAST;

    enum { OUTPUTS = 8 };
    guarded g[OUTPUTS];
    for (int k = 0; k < OUTPUTS; k++) g[k] = guarded_array(n, 4);
    pktrt_hits hits = {
        g[0].array, g[1].array, g[2].array, {g[3].array, g[4].array, g[5].array}, g[6].array, g[7].array};
    if (path == 0) pktrt_intersect_soa(st->scene, &rays, &hits, n);
    else pktrt_intersect_soa_ex(st->scene, &query, &rays, &hits, n);
    for (int k = 0; k < OUTPUTS; k++) check_filled(&g[k], 4, "pktrt_intersect_soa", n);

    guarded occluded = guarded_array(n, sizeof(bool));
    if (path == 0) pktrt_occluded_soa(st->scene, &rays, occluded.array, n);
    else pktrt_occluded_soa_ex(st->scene, &query, &rays, occluded.array, n);
    check_filled(&occluded, sizeof(bool), "pktrt_occluded_soa", n);
  }
  for (int row = 0; row < ROWS; row++) input_free(&rows[row]);
}

static void query_arrays(void) {
  static stand st;
  arrays_checked = 0;
  for (int k = 0; k < isa_count; k++) {
    stand_open(&st, isas[k]);
    for (size_t i = 0; i < COUNT(COUNTS); i++) {
      guard_arrays(&st, COUNTS[i]);
      guard_coordinates(&st, COUNTS[i]);
    }
    pktrt_scene_destroy(st.scene);
  }
  say("%zu arrays", arrays_checked);

  /* The controls: a value behind the array, and an element that is left out, are noticed. */
  guarded g = guarded_array(3, 4);
  CHECK(guards_hold(&g) && elements_written(&g, 4) == 0);
  memset((char *)g.array + g.size, 0, 4);
  CHECK(!guards_hold(&g));
  memset(g.array, 0, 8);
  CHECK(elements_written(&g, 4) == 2);
  free(g.memory);
}

/* All crossings, with room for none, some, all but one, all, and more. */
static void crossings_fill_their_room(void) {
  static stand st;
  for (int k = 0; k < isa_count; k++) {
    stand_open(&st, isas[k]);
    size_t least = SIZE_MAX;
    size_t most = 0;
    for (uint32_t i = 0; i < 40; i++) {
      pktrt_hit all[128];
      const size_t count = pktrt_intersect_all(st.scene, &st.rays[i], all, COUNT(all));
      if (!CHECK(count <= COUNT(all))) continue;
      if (count < least) least = count;
      if (count > most) most = count;
      for (size_t capacity = 0; capacity <= count + 2; capacity++) {
        const size_t kept = capacity < count ? capacity : count;
        guarded g = guarded_array(capacity, sizeof(pktrt_hit));
        const size_t told = pktrt_intersect_all(st.scene, &st.rays[i], g.array, capacity);
        CHECK(told == count && same_bits(g.array, all, kept * sizeof *all), "ray %u, room for %zu of %zu", i, capacity,
            count);
        check_guards(&g, "pktrt_intersect_all", capacity);
      }
    }
    CHECK(least == 0 && most > LAYERS, "rays with %zu to %zu crossings are not all kinds", least, most);

    for (size_t i = 0; i < COUNT(COUNTS); i++) {
      const size_t n = COUNTS[i];
      input rays = input_of(st.rays, n * sizeof *st.rays);
      for (size_t capacity = 0; capacity < 4; capacity += 3) {
        guarded g = guarded_array(n * capacity, sizeof(pktrt_hit));
        guarded counts = guarded_array(n, sizeof(size_t));
        pktrt_intersect_all_n(st.scene, rays.array, g.array, capacity, counts.array, n);
        check_guards(&g, "pktrt_intersect_all_n", n);
        check_filled(&counts, sizeof(size_t), "pktrt_intersect_all_n", n);
      }
      input_free(&rays);
    }
    pktrt_scene_destroy(st.scene);
  }
}

/* --- pictures --- */

typedef struct plate { /* a picture's arrays */
  guarded pixels, depth, normal, albedo, sample_count, cost, pixel_error, block_error, report;
} plate;

static void plate_open(plate *p, pktrt_render_desc *view) {
  const size_t n = (size_t)view->width * view->height;
  const uint32_t columns = (view->width + PKTRT_ERROR_BLOCK - 1) / PKTRT_ERROR_BLOCK;
  const uint32_t rows = (view->height + PKTRT_ERROR_BLOCK - 1) / PKTRT_ERROR_BLOCK;
  p->pixels = guarded_array((view->height - 1) * view->row_stride + 3 * (size_t)view->width, 4);
  p->depth = guarded_array(n, 4);
  p->normal = guarded_array(3 * n, 4);
  p->albedo = guarded_array(3 * n, 4);
  p->sample_count = guarded_array(n, 4);
  p->cost = guarded_array(n, 4);
  p->pixel_error = guarded_array(n, 4);
  p->block_error = guarded_array((size_t)columns * rows, 4);
  p->report = guarded_array(1, sizeof(pktrt_report));
  view->pixels = p->pixels.array;
  view->depth = p->depth.array;
  view->normal = p->normal.array;
  view->albedo = p->albedo.array;
  view->sample_count = p->sample_count.array;
  view->cost = p->cost.array;
  view->pixel_error = p->pixel_error.array;
  view->block_error = p->block_error.array;
}

/* Checks that the pixels of a rectangle are written and no others, nor what lies between rows. */
static void check_pixels(guarded *g, const pktrt_render_desc *view, const uint32_t at[4], const char *call) {
  const float *pixels = g->array;
  float untouched;
  memset(&untouched, GUARD_VALUE, sizeof untouched);
  size_t missing = 0;
  size_t beside = 0;
  for (size_t i = 0; i < g->size / 4; i++) {
    const size_t row = i / view->row_stride;
    const size_t column = i % view->row_stride / 3;
    const bool within = row >= at[1] && row < at[1] + at[3] && column >= at[0] && column < at[0] + at[2] &&
                        i % view->row_stride < 3 * (size_t)view->width;
    const bool kept = same_bits(&pixels[i], &untouched, 4);
    missing += within && kept;
    beside += !within && !kept;
  }
  CHECK(missing == 0 && beside == 0, "%s: %zu floats are not written, %zu beside", call, missing, beside);
  check_guards(g, call, 0);
}

static pktrt_scene *picture_scene(pktrt_isa isa) {
  const pktrt_scene_desc d = scene_desc_of(isa, 0);
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!CHECK(s != NULL)) abort();
  mesh ball = mesh_sphere(2, 0.1f, 5);
  CHECK(mesh_add(s, &ball, NULL) == PKTRT_OK);
  mesh_free(&ball);
  const pktrt_light sun = light_of(PKTRT_LIGHT_DIRECTIONAL, 2);
  pktrt_light down = sun;
  down.direction[1] = -1;
  stage_light(s, &down);
  CHECK(pktrt_commit(s) == PKTRT_OK);
  return s;
}

static void picture_arrays(void) {
  static const uint32_t sizes[][2] = {{1, 1}, {3, 2}, {16, 16}, {17, 33}, {37, 16}};
  for (int k = 0; k < isa_count; k++) {
    pktrt_scene *s = picture_scene(isas[k]);
    for (size_t i = 0; i < COUNT(sizes); i++) {
      pktrt_render_desc view =
          stage_view(PKTRT_MODE_DRT, sizes[i][0], sizes[i][1], NULL, vec_of(0, 1, 4), vec_of(0, 0, 0));
      const uint32_t whole[4] = {0, 0, view.width, view.height};
      const size_t n = (size_t)view.width * view.height;
      view.samples = 2;
      view.passes = 2;
      view.tile_size = 16;
      view.row_stride = 3 * (size_t)view.width + (i % 2 ? 5 : 0);
      view.path = i % 3 == 0 ? PKTRT_PATH_FAST : i % 3 == 1 ? PKTRT_PATH_PAPER : PKTRT_PATH_SINGLE;

      plate p;
      plate_open(&p, &view);
      view.report = p.report.array;
      stage_render(s, &view);
      check_pixels(&p.pixels, &view, whole, "pktrt_render");
      check_filled(&p.depth, 4, "depth", n);
      check_filled(&p.normal, 4, "normal", n);
      check_filled(&p.albedo, 4, "albedo", n);
      check_filled(&p.sample_count, 4, "sample_count", n);
      check_filled(&p.cost, 4, "cost", n);
      check_filled(&p.pixel_error, 4, "pixel_error", n);
      check_filled(&p.block_error, 4, "block_error", n);
      check_filled(&p.report, sizeof(pktrt_report), "report", 1);
    }
    pktrt_scene_destroy(s);
  }
}

/* Tiles in the middle and at the edge of a picture, and the calls that make a picture's passes one by one. */
static void tile_and_pass_arrays(void) {
  static const uint32_t tiles[][4] = {{0, 0, 19, 11}, {3, 2, 1, 1}, {5, 0, 14, 3}, {18, 10, 1, 1}, {2, 4, 9, 7}};
  for (int k = 0; k < isa_count; k++) {
    pktrt_scene *s = picture_scene(isas[k]);
    for (size_t i = 0; i < COUNT(tiles); i++) {
      pktrt_render_desc view = stage_view(PKTRT_MODE_DRT, 19, 11, NULL, vec_of(0, 1, 4), vec_of(0, 0, 0));
      view.row_stride = 3 * 19 + 2;
      const uint32_t *at = tiles[i];
      guarded pixels = guarded_array(10 * view.row_stride + 3 * 19, 4);
      view.pixels = pixels.array;
      CHECK(pktrt_render_tile(s, &view, at[0], at[1], at[2], at[3]) == PKTRT_OK);
      check_pixels(&pixels, &view, at, "pktrt_render_tile");

      view.pixels = NULL;
      guarded means = guarded_array(3 * (size_t)at[2] * at[3], sizeof(double));
      CHECK(pktrt_render_pass(s, &view, 0, at[0], at[1], at[2], at[3], means.array) == PKTRT_OK);
      check_filled(&means, sizeof(double), "pktrt_render_pass", i);
    }

    enum { WIDTH = 19, HEIGHT = 17, PIXELS = WIDTH * HEIGHT };
    static double means[3 * PIXELS];
    pktrt_render_desc view = stage_view(PKTRT_MODE_DRT, WIDTH, HEIGHT, NULL, vec_of(0, 1, 4), vec_of(0, 0, 0));
    view.row_stride = 3 * WIDTH;
    view.passes = 2;
    guarded sums = guarded_array(PIXELS, sizeof(pktrt_pixel_sums));
    memset(sums.array, 0, sums.size);
    guarded display = guarded_array(PIXELS, sizeof(pktrt_display_sums));
    memset(display.array, 0, display.size);
    for (uint32_t pass = 0; pass < 2; pass++) {
      CHECK(pktrt_render_pass(s, &view, pass, 0, 0, WIDTH, HEIGHT, means) == PKTRT_OK);
      input in = input_of(means, sizeof means);
      pktrt_add_pass(in.array, PIXELS, sums.array);
      pktrt_add_display_pass(in.array, PIXELS, display.array);
      input_free(&in);
    }
    plate p;
    plate_open(&p, &view);
    view.depth = view.normal = view.albedo = view.cost = NULL;
    view.sample_count = NULL;
    view.report = p.report.array;
    CHECK(pktrt_finish_passes(s, &view, 2, sums.array) == PKTRT_OK, "%s", pktrt_last_error(s));
    const float *tight = p.pixels.array;
    view.row_stride += 5; /* the same rows, farther apart */
    guarded apart = guarded_array((HEIGHT - 1) * view.row_stride + 3 * WIDTH, 4);
    view.pixels = apart.array;
    CHECK(pktrt_finish_passes(s, &view, 2, sums.array) == PKTRT_OK, "%s", pktrt_last_error(s));
    for (size_t y = 0; y < HEIGHT; y++)
      CHECK(same_bits(view.pixels + y * view.row_stride, tight + 3 * WIDTH * y, 12 * WIDTH), "row %zu", y);
    check_guards(&apart, "pktrt_finish_passes", 0);
    check_filled(&sums, sizeof(pktrt_pixel_sums), "pktrt_add_pass", PIXELS);
    check_guards(&display, "pktrt_add_display_pass", PIXELS);
    check_filled(&p.pixels, 4, "pktrt_finish_passes", PIXELS);
    check_filled(&p.pixel_error, 4, "pktrt_finish_passes", PIXELS);
    check_filled(&p.block_error, 4, "pktrt_finish_passes", PIXELS);
    check_filled(&p.report, sizeof(pktrt_report), "pktrt_finish_passes", 1);
    check_guards(&p.depth, "pktrt_finish_passes", 0);
    check_guards(&p.normal, "pktrt_finish_passes", 0);
    check_guards(&p.albedo, "pktrt_finish_passes", 0);
    check_guards(&p.sample_count, "pktrt_finish_passes", 0);
    check_guards(&p.cost, "pktrt_finish_passes", 0);
    pktrt_scene_destroy(s);
  }
}

/* --- everything else that is written through a pointer --- */

static void numbers_and_structs(void) {
  static stand st;
  stand_open(&st, PKTRT_ISA_AUTO);
  guarded g = guarded_array(1, sizeof(pktrt_scene_info));
  pktrt_get_scene_info(st.scene, g.array);
  check_filled(&g, sizeof(pktrt_scene_info), "pktrt_get_scene_info", 1);

  g = guarded_array(1, sizeof(pktrt_tree));
  CHECK(pktrt_get_tree(st.scene, 0, g.array));
  check_filled(&g, sizeof(pktrt_tree), "pktrt_get_tree", 1);
  g = guarded_array(1, sizeof(pktrt_node));
  CHECK(pktrt_get_node(st.scene, 0, 0, 0.5f, g.array));
  check_filled(&g, sizeof(pktrt_node), "pktrt_get_node", 1);

  guarded report = guarded_array(1, sizeof(pktrt_scene_report));
  pktrt_get_scene_report(st.scene, NULL, report.array);
  const size_t length = pktrt_scene_report_text(report.array, NULL, 0);
  char *whole = malloc(length + 1);
  if (!whole) abort();
  CHECK(pktrt_scene_report_text(report.array, whole, length + 1) == length && strlen(whole) == length);
  for (size_t room = 1; room < length + 3; room += room < 40 || room + 40 > length ? 1 : 37) {
    g = guarded_array(room, 1);
    const size_t told = pktrt_scene_report_text(report.array, g.array, room);
    const size_t kept = room - 1 < length ? room - 1 : length;
    const char *text = g.array;
    CHECK(told == length && text[kept] == 0 && memcmp(text, whole, kept) == 0, "room for %zu of %zu", room, length);
    check_guards(&g, "pktrt_scene_report_text", room);
  }
  free(whole);
  check_filled(&report, sizeof(pktrt_scene_report), "pktrt_get_scene_report", 1);

  for (uint32_t n = 0; n < 20; n++)
    for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
      const pktrt_sampling sampling = {(pktrt_sampler)sampler, 16, 3};
      g = guarded_array(n, 4);
      pktrt_sample(&sampling, 5, 6, 7, n % 5, n, g.array);
      check_filled(&g, 4, pktrt_sampler_string((pktrt_sampler)sampler), n);
    }

  const float u[2] = {0.25f, 0.75f};
  const float axis[3] = {0.6f, 0, 0.8f};
  g = guarded_array(2, 4);
  pktrt_map_disk(u, g.array);
  check_filled(&g, 4, "pktrt_map_disk", 2);
  for (int mapping = 0; mapping < 4; mapping++) {
    g = guarded_array(3, 4);
    if (mapping == 0) pktrt_map_sphere(u, g.array);
    else if (mapping == 1) pktrt_map_cosine(u, axis, g.array);
    else if (mapping == 2) pktrt_map_phong(u, axis, 9, g.array);
    else pktrt_map_phong_naive(u, axis, 9, g.array);
    check_filled(&g, 4, "a mapping", 3);
  }

  pktrt_camera camera;
  memset(&camera, 0, sizeof camera);
  camera.eye[2] = 3;
  g = guarded_array(1, sizeof(pktrt_ray));
  CHECK(pktrt_camera_ray(&camera, 8, 8, 1.5, 2.5, NULL, 0, g.array));
  check_filled(&g, sizeof(pktrt_ray), "pktrt_camera_ray", 1);

  /* Indices that calls hand out. */
  enum { MESH, MATERIAL, LIGHT, MODEL, INSTANCE, CALLS };
  const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  pktrt_mesh_desc triangle;
  memset(&triangle, 0, sizeof triangle);
  triangle.positions = corners;
  triangle.vertex_count = 3;
  triangle.triangle_count = 1;
  const pktrt_material plain = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
  const pktrt_light lamp = light_of(PKTRT_LIGHT_POINT, 1);
  for (int call = 0; call < CALLS; call++) {
    pktrt_status status = PKTRT_OK;
    g = guarded_array(1, 4);
    if (call == MESH) status = pktrt_add_mesh(st.scene, &triangle, g.array);
    if (call == MATERIAL) status = pktrt_add_material(st.scene, &plain, g.array);
    if (call == LIGHT) status = pktrt_add_light(st.scene, &lamp, g.array);
    if (call == MODEL) status = pktrt_add_model(st.scene, &triangle, 1, g.array);
    if (call == INSTANCE) {
      pktrt_instance_desc place;
      memset(&place, 0, sizeof place);
      status = pktrt_add_instance(st.scene, &place, g.array);
    }
    CHECK(status == PKTRT_OK, "%s", pktrt_last_error(st.scene));
    check_filled(&g, 4, "an add call", (size_t)call);
  }
  guarded instance = guarded_array(1, 4);
  guarded model_mesh = guarded_array(1, 4);
  CHECK(pktrt_get_mesh_source(st.scene, st.ball + 1, instance.array, model_mesh.array));
  check_filled(&instance, 4, "pktrt_get_mesh_source", 1);
  check_filled(&model_mesh, 4, "pktrt_get_mesh_source", 1);
  pktrt_scene_destroy(st.scene);
}

void suite_guards(void) {
  run("queries fill their arrays, write nothing beside them and read nothing behind their rays, for all counts of rays",
      query_arrays);
  run("all crossings fill the room that there is, and no more", crossings_fill_their_room);
  run("pictures fill their buffers and nothing between rows or beside them", picture_arrays);
  run("tiles and passes write their own pixels alone", tile_and_pass_arrays);
  run("numbers, structs and texts are written whole and nothing beside them", numbers_and_structs);
}
