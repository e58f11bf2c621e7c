/* Hostile input: what the fuzz targets found worth keeping and what comes of it by mutation, rays of odd values, threads
   that query and render one scene. (Refusals by name are in refusals.c and render.c, failing allocations in memory.c.) */
#include "stability.h"
#include "fuzz/fuzz.h"
#include <dirent.h>

/* --- fuzz targets: the kept inputs, and mutations of them --- */

enum { LONGEST = 1024, CHUNK = 64 };

typedef struct input {
  uint8_t data[LONGEST];
  size_t size;
} input;

typedef struct target {
  const char *name;
  const char *(*run)(const uint8_t *data, size_t size, bool broken);
  size_t tries; /* at full length */
  input *kept;
  size_t count, capacity, n;
  uint64_t wrong, noticed; /* noticed: of kept inputs, with an answer spoilt */
  pthread_mutex_t lock;
} target;

static void keep_input(target *t, const char *path) {
  FILE *from = fopen(path, "rb");
  if (!from) return;
  if (t->count == t->capacity) {
    t->capacity = t->capacity ? 2 * t->capacity : 16;
    t->kept = realloc(t->kept, t->capacity * sizeof *t->kept);
    if (!t->kept) abort();
  }
  t->kept[t->count].size = fread(t->kept[t->count].data, 1, LONGEST, from);
  t->count += t->kept[t->count].size > 0;
  fclose(from);
}

static int by_bytes(const void *a, const void *b) { /* directories have no order */
  const input *x = a, *y = b;
  const int c = memcmp(x->data, y->data, x->size < y->size ? x->size : y->size);
  return c ? c : x->size < y->size ? -1 : x->size > y->size;
}

/* The corpus lies beside this file, which the compiler was given by its path from where it ran. */
static bool read_corpus(target *t) {
  char path[1024];
  const int folder = (int)(strrchr(__FILE__, '/') ? strrchr(__FILE__, '/') - __FILE__ : 0);
  snprintf(path, sizeof path, "%.*s/fuzz/corpus/%s", folder, folder ? __FILE__ : ".", t->name);
  DIR *d = opendir(path);
  if (!d) return CHECK(false, "%s is not there: run the test binary where it was made", path);
  for (const struct dirent *e; (e = readdir(d)) != NULL;) {
    char file[2048];
    snprintf(file, sizeof file, "%s/%s", path, e->d_name);
    if (e->d_name[0] != '.') keep_input(t, file);
  }
  closedir(d);
  if (t->count) qsort(t->kept, t->count, sizeof *t->kept, by_bytes);
  return CHECK(t->count > 0, "%s holds no input", path);
}

/* Up to eight changes: a byte, a bit, a piece of another input, an end cut off or a byte put in. */
static void mutate(const target *t, rng *r, input *x) {
  *x = t->kept[rng_below(r, (uint32_t)t->count)];
  for (uint32_t i = 1 + rng_below(r, 8); i > 0; i--) {
    const input *other = &t->kept[rng_below(r, (uint32_t)t->count)];
    const size_t at = rng_below(r, (uint32_t)x->size), from = rng_below(r, (uint32_t)other->size);
    size_t n = 1 + rng_below(r, 32);
    switch (rng_below(r, 5)) {
    case 0: x->data[at] = (uint8_t)rng_u32(r); break;
    case 1: x->data[at] ^= (uint8_t)(1u << rng_below(r, 8)); break;
    case 2:
      if (n > x->size - at) n = x->size - at;
      if (n > other->size - from) n = other->size - from;
      memmove(x->data + at, other->data + from, n);
      break;
    case 3: x->size = at ? at : 1; break;
    default:
      if (x->size == LONGEST) break;
      memmove(x->data + at + 1, x->data + at, x->size++ - at);
      x->data[at] = (uint8_t)rng_u32(r);
      break;
    }
  }
}

static void replay_chunk(void *arg, size_t chunk) {
  target *t = arg;
  uint64_t wrong = 0, noticed = 0;
  for (size_t i = chunk * CHUNK; i < (chunk + 1) * CHUNK && i < t->n; i++) {
    input x;
    rng r = rng_of(i);
    if (i < t->count) x = t->kept[i], noticed += t->run(x.data, x.size, true) != NULL;
    else mutate(t, &r, &x);
    const char *sentence = t->run(x.data, x.size, false);
    wrong += sentence != NULL;
    CHECK(!sentence, "%s, input %zu: %s", t->name, i, sentence);
  }
  pthread_mutex_lock(&t->lock);
  t->wrong += wrong, t->noticed += noticed;
  pthread_mutex_unlock(&t->lock);
}

static void replay(const char *name, const char *(*run_one)(const uint8_t *, size_t, bool), size_t tries) {
  static const char what[] = "fuzz inputs that break an invariant";
  target t = {name, run_one, tries, NULL, 0, 0, 0, 0, 0, PTHREAD_MUTEX_INITIALIZER};
  if (read_corpus(&t)) {
    t.n = t.count + thorough(t.tries);
    const size_t chunks = (t.n + CHUNK - 1) / CHUNK;
    if (run_one == fuzz_mesh_file) threads_for(1, chunks, replay_chunk, &t); /* it has one file */
    else jobs_for(chunks, replay_chunk, &t);
    say("%zu kept inputs, %zu mutated; with an answer spoilt %llu of the former fail", t.count, t.n - t.count,
        (unsigned long long)t.noticed);
    CHECK(t.noticed > 0, "no check sees an answer that is spoilt");
    count_figure("hostile", name, PKTRT_ISA_AUTO, t.n, what, t.wrong);
    control_figure("hostile", name, what, "an answer spoilt", t.count, t.noticed);
  }
  free(t.kept);
}

static void replay_scenes(void) { replay("scene", fuzz_scene, 40000); }
static void replay_queries(void) { replay("query", fuzz_query, 10000); }
static void replay_settings(void) { replay("settings", fuzz_settings, 4000); }
static void replay_mesh_files(void) { replay("mesh_file", fuzz_mesh_file, 20000); }

/* --- rays of odd values, among good ones --- */

enum { BATCH = 1024 };

typedef struct odd_case {
  const world *w;
  pktrt_scene *scene[8]; /* by instruction set */
  uint64_t invalid, hit_before, hit[8], unlike[8], shifted;
  size_t n;
  pthread_mutex_t lock;
} odd_case;

/* One to three fields of a good ray become what nobody expects. */
static void spoil_ray(rng *r, pktrt_ray *x) {
  static const float odd[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 0, -0.0f, 0x1p-149f, -0x1p-149f, FLT_MIN,
      1.3e30f, -1.3e30f, PKTRT_MAX_COORD, 1e-30f, 1e20f};
  float f[9];
  memcpy(f, x, sizeof f);
  for (uint32_t i = 1 + rng_below(r, 3); i > 0; i--) f[rng_below(r, 9)] = odd[rng_below(r, COUNT(odd))];
  if (rng_below(r, 16) == 0) f[4] = f[5] = f[6] = 0; /* a direction of no length */
  memcpy(x, f, sizeof f);
}

static uint64_t unlike(const pktrt_hit *a, const pktrt_hit *b, size_t n) {
  uint64_t differ = 0;
  for (size_t i = 0; i < n; i++) differ += !same_bits(&a[i], &b[i], sizeof *a);
  return differ;
}

/* Answers of one instruction set: alone or together, some on the paper path; or only whether there is one. */
static void ask(const pktrt_scene *s, size_t way, const pktrt_ray *rays, const pktrt_hit *want, size_t n, uint64_t *hit,
    uint64_t *differ) {
  static const uint32_t sizes[4] = {0, 1, 17, 256};
  pktrt_hit got[BATCH];
  bool occluded[BATCH];
  pktrt_query_desc d;
  memset(&d, 0, sizeof d);
  d.packet_size = sizes[way / 8 % 4];
  if (way % 8 == 1) d.path = PKTRT_PATH_PAPER;
  if (way % 8 < 4) pktrt_intersect_ex(s, &d, rays, got, n);
  for (size_t i = 0; i < n && way % 8 >= 4; i++) *hit += pktrt_intersect(s, &rays[i], &got[i]) && !ref_valid(&rays[i]);
  *differ += unlike(got, want, n);
  if (way % 4) return;
  pktrt_occluded_n(s, rays, occluded, n);
  for (size_t i = 0; i < n; i++) {
    *hit += occluded[i] && !ref_valid(&rays[i]);
    *differ += occluded[i] != (want[i].mesh != PKTRT_NONE);
  }
}

static void odd_batch(void *arg, size_t batch) {
  odd_case *c = arg;
  pktrt_ray rays[BATCH];
  pktrt_hit want[BATCH], before;
  uint64_t invalid = 0, hit_before = 0, shifted = 0, hit[8] = {0}, differ[8] = {0};
  const size_t n = c->n - batch * BATCH < BATCH ? c->n - batch * BATCH : BATCH;
  rng r = rng_of(77 + batch);
  make_rays(c->w, c->scene[0], (ray_kind)(batch % 4), 5, batch * BATCH, rays, n);
  for (size_t i = 0; i < n; i++) {
    const pktrt_ray good = rays[i];
    if (rng_below(&r, 4)) spoil_ray(&r, &rays[i]);
    if (!ref_valid(&rays[i])) invalid++, hit_before += pktrt_intersect(c->scene[0], &good, &before);
    ref_intersect(c->w, &rays[i], &want[i]);
  }
  shifted = n > 1 ? unlike(want, want + 1, n - 1) : 0;
  for (int k = 0; k < isa_count; k++) ask(c->scene[k], batch / 4, rays, want, n, &hit[k], &differ[k]);
  pthread_mutex_lock(&c->lock);
  c->invalid += invalid, c->hit_before += hit_before, c->shifted += shifted;
  for (int k = 0; k < isa_count; k++) c->hit[k] += hit[k], c->unlike[k] += differ[k];
  pthread_mutex_unlock(&c->lock);
}

static void odd_rays(const char *name, world w) {
  static const char hits[] = "hits of invalid rays", others[] = "odd rays answered unlike brute force";
  odd_case c = {&w, {NULL}, 0, 0, {0}, {0}, 0, thorough(1000000), PTHREAD_MUTEX_INITIALIZER};
  ref_plant(&w);
  for (int k = 0; k < isa_count; k++) c.scene[k] = world_scene(&w, isas[k], 0);
  jobs_for((c.n + BATCH - 1) / BATCH, odd_batch, &c);
  for (int k = 0; k < isa_count; k++) {
    count_figure("hostile", name, isas[k], c.invalid, hits, c.hit[k]);
    count_figure("hostile", name, isas[k], c.n, others, c.unlike[k]);
    pktrt_scene_destroy(c.scene[k]);
  }
  control_figure("hostile", name, hits, "before they were spoilt", c.invalid, c.hit_before);
  control_figure("hostile", name, others, "answers of the ray before", c.n, c.shifted);
  say("%zu rays, %llu of them invalid; before they were spoilt %llu of these hit", c.n, (unsigned long long)c.invalid,
      (unsigned long long)c.hit_before);
  world_free(&w);
}
static void odd_static(void) { odd_rays("odd rays, static", world_static(2)); }
static void odd_moving(void) { odd_rays("odd rays, moving", world_moving(2)); }

/* --- threads: under TSan, above all --- */

enum { EDGE = 48, PARTS = 16 };

typedef struct crowd {
  const pktrt_scene *s;
  pktrt_render_desc d; /* all parts paint into one picture */
  const pktrt_ray *rays;
  const pktrt_hit *want;
  size_t n;
  uint64_t wrong;
  pthread_mutex_t lock;
} crowd;

static void crowd_body(void *arg, size_t i) {
  crowd *c = arg;
  const uint32_t part = (uint32_t)i / 2, rows = EDGE / PARTS;
  uint64_t wrong = 0;
  if (i % 2) {
    wrong = pktrt_render_tile(c->s, &c->d, 0, part * rows, EDGE, rows) != PKTRT_OK;
  } else {
    pktrt_hit got[BATCH];
    pktrt_query_desc d;
    memset(&d, 0, sizeof d);
    d.path = (pktrt_path)(part % 3);
    pktrt_intersect_ex(c->s, &d, c->rays, got, c->n);
    wrong = unlike(got, c->want, c->n);
  }
  pthread_mutex_lock(&c->lock);
  c->wrong += wrong;
  pthread_mutex_unlock(&c->lock);
}

static void crowded(void) {
  static float want[EDGE * EDGE * 3], got[EDGE * EDGE * 3], other[EDGE * EDGE * 3];
  static pktrt_ray rays[BATCH];
  static pktrt_hit hits[BATCH];
  world w = world_moving(2);
  crowd c = {NULL, {0}, rays, hits, BATCH, 0, PTHREAD_MUTEX_INITIALIZER};
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 3);
  pktrt_light l;
  memset(&l, 0, sizeof l), memset(&c.d, 0, sizeof c.d);
  c.d.samples = 1;
  l.kind = PKTRT_LIGHT_SPHERE, l.position[1] = 4, l.radius = 1, l.intensity[0] = l.intensity[1] = l.intensity[2] = 5;
  CHECK(pktrt_add_light(s, &l, NULL) == PKTRT_OK);
  make_rays(&w, s, RAYS_EDGE, 3, 0, rays, BATCH);
  for (size_t i = 0; i < BATCH; i++) pktrt_intersect(s, &rays[i], &hits[i]);
  c.s = s, c.d.width = c.d.height = EDGE, c.d.mode = PKTRT_MODE_DRT, c.d.camera.eye[1] = 1, c.d.camera.eye[2] = 5;
  c.d.camera.shutter = 1, c.d.samples = 2, c.d.seed = 1, c.d.pixels = other;
  CHECK(pktrt_render(s, &c.d) == PKTRT_OK);
  c.d.seed = 0, c.d.pixels = want;
  CHECK(pktrt_render(s, &c.d) == PKTRT_OK, "%s", pktrt_last_error(s));
  c.d.pixels = got;
  threads_for(4, 2 * PARTS, crowd_body, &c);
  uint64_t control = 0;
  for (size_t i = 0; i < COUNT(want); i++)
    c.wrong += !same_bits(&want[i], &got[i], 4), control += !same_bits(&want[i], &other[i], 4);
  count_figure(
      "hostile", "threads", PKTRT_ISA_AUTO, COUNT(want) + PARTS * BATCH, "values that differ among threads", c.wrong);
  control_figure("hostile", "threads", "values that differ among threads", "another seed", COUNT(want), control);
  pktrt_scene_destroy(s);
  world_free(&w);
}

void suite_stability_hostile(void) {
  run("stable: fuzz inputs break nothing: scenes", replay_scenes);
  run("stable: fuzz inputs break nothing: queries", replay_queries);
  run("stable: fuzz inputs break nothing: render settings", replay_settings);
  run("stable: fuzz inputs break nothing: mesh files", replay_mesh_files);
  run("stable: invalid rays hit nothing, odd ones answer as brute force, static", odd_static);
  run("stable: invalid rays hit nothing, odd ones answer as brute force, moving", odd_moving);
  run("stable: several threads query and render one scene at once", crowded);
}
