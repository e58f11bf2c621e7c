/* Threads that round, flush or trap as they like: each public call gives the same bits and leaves the thread as it was. */
#include "noslack.h"
#include <fenv.h>
#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

/* --- a thread's settings --- */

typedef struct settings {
  uint64_t control, flags; /* flags: of exceptions */
} settings;
typedef struct named_settings {
  const char *name;
  settings set;
  bool traps; /* exceptions would end the program; bits are as usual */
} named_settings;

#if defined(__SSE2__)
static void write_settings(settings s) { _mm_setcsr((unsigned)(s.control | s.flags)); }
static settings read_settings(void) {
  const unsigned all = _mm_getcsr();
  return (settings){all & ~0x3Fu, all & 0x3F};
}
static const settings usual = {0x1F80, 0};
static const named_settings odd[] = {
    {"FTZ", {0x9F80, 0x01}, false},
    {"DAZ", {0x1FC0, 0x02}, false},
    {"FTZ and DAZ", {0x9FC0, 0}, false},
    {"rounding up", {0x5F80, 0x20}, false},
    {"rounding down", {0x3F80, 0}, false},
    {"rounding to zero", {0x7F80, 0x3F}, false},
    {"all traps", {0x0000, 0}, true},
    {"all traps, FTZ, DAZ, rounding up", {0xC040, 0}, false},
};
#elif defined(__aarch64__)
static void write_settings(settings s) {
  __asm__ volatile("msr fpcr, %0\n\tmsr fpsr, %1" : : "r"(s.control), "r"(s.flags) : "memory");
}
static settings read_settings(void) {
  settings s;
  __asm__ volatile("mrs %0, fpcr\n\tmrs %1, fpsr" : "=r"(s.control), "=r"(s.flags) : : "memory");
  s.flags &= 0x9F;
  return s;
}
static const settings usual = {0, 0};
static const named_settings odd[] = {
    {"FZ", {1u << 24, 0x01}, false},
    {"rounding up", {1u << 22, 0x10}, false},
    {"rounding down", {2u << 22, 0}, false},
    {"rounding to zero", {3u << 22, 0x1F}, false},
    {"traps", {0x9F00, 0}, true},
    {"FZ, default NaN, rounding up", {1u << 24 | 1u << 25 | 1u << 22, 0}, false},
};
#else
static void write_settings(settings s) { (void)fesetround((int)s.control); }
static settings read_settings(void) { return (settings){(uint64_t)fegetround(), 0}; }
static const settings usual = {FE_TONEAREST, 0};
static const named_settings odd[] = {
#if defined(FE_UPWARD) && defined(FE_DOWNWARD) && !defined(__wasm__)
    {"rounding up", {FE_UPWARD, 0}, false},
    {"rounding down", {FE_DOWNWARD, 0}, false},
#else
    {"the usual ones", {FE_TONEAREST, 0}, false},
#endif
};
#endif

/* Whether this thread computes as the library does. Nothing here can be known to compilers. */
static bool computes_as_usual(void) {
  volatile float one = 1, little = 0x1.8p-25f, least = 0x1p-126f, half = 0.5f;
  volatile float below = least * half, kept = below * 0x1p40f; /* as result, and as operand */
  return one + little == 1 && one + 0x1.8p-24f == 1 + 0x1p-23f && -one - little == -1 && kept == 0x1p-87f;
}

/* --- what the calls gave, under one sort of settings --- */

enum { MOST_CALLS = 80, HOOKS = 14 };
enum {
  ALLOCATES,
  RELEASES,
  PARALLEL,
  LOGS,
  TEXTURES,
  SHADES,
  ENVIRONMENT,
  PROGRESS,
  PACKET,
  TRACES,
  SAMPLES,
  PASSED,
  CLOCK,
  BODIES
};
static const char *const hook_name[HOOKS] = {"allocate", "release", "parallel_for", "log", "texture", "shader",
    "environment", "progress", "packet", "trace", "custom_sampler", "pass", "seconds", "body"};
typedef struct record {
  const char *name;
  uint64_t hash;
} record;
typedef struct session {
  const named_settings *now; /* NULL: the usual ones */
  settings set;              /* of these, what the machine has: some ARMs cannot trap */
  record call[MOST_CALLS];
  int calls;
  int hook[HOOKS];      /* how often each was called */
  int hook_unlike;      /* of these, under other settings than the library's */
  int body_unlike;      /* bodies of parallel_for that left other settings than they found */
  const char *unlike;   /* a call that did */
  pthread_mutex_t lock; /* of the hooks */
  pktrt_scene_desc desc;
} session;
static session *current;

static void enter(void) {
  if (current->now) write_settings(current->set);
}
/* Whether the thread has the settings it had. Flags of exceptions only count where settings are not the usual ones. */
static bool as_before(settings found) {
  return found.control == current->set.control && (found.flags == current->set.flags || found.control == usual.control);
}
/* Notes a call whose settings are not what they were, and goes back to the usual ones. */
static void leave(const char *name) {
  const settings found = read_settings();
  write_settings(usual);
  if (!current->now) return;
  if (!as_before(found)) current->unlike = name;
}
static record *record_of(const char *name) {
  for (int i = 0; i < current->calls; i++)
    if (!strcmp(current->call[i].name, name)) return &current->call[i];
  if (!CHECK(current->calls < MOST_CALLS, "too many calls")) abort();
  current->call[current->calls] = (record){name, 14695981039346656037u};
  return &current->call[current->calls++];
}
static void add(const char *name, const void *data, size_t size) {
  record *r = record_of(name);
  for (size_t i = 0; i < size; i++) r->hash = (r->hash ^ ((const unsigned char *)data)[i]) * 1099511628211u;
}
/* Calls it under the settings at hand. What it gave, KEEP adds to its record. */
#define CALL(name, statement) \
  do { \
    enter(); \
    statement; \
    leave(#name); \
    (void)record_of(#name); \
  } while (0)
#define KEEP(name, data) add(#name, &(data), sizeof(data))

/* --- hooks, which count themselves --- */

static void count_hook(int which) {
  const bool alike = computes_as_usual() && read_settings().control == usual.control;
  pthread_mutex_lock(&current->lock);
  current->hook[which]++;
  if (!alike) current->hook_unlike++;
  pthread_mutex_unlock(&current->lock);
}
static void *counting_allocate(void *user, size_t size, size_t align) {
  count_hook(ALLOCATES);
  return current->desc.allocate(user, size, align);
}
static void counting_release(void *user, void *p, size_t size) {
  count_hook(RELEASES);
  current->desc.release(user, p, size);
}
static void counting_log(void *user, int level, const char *sentence) {
  count_hook(LOGS);
  current->desc.log(user, level, sentence);
}
typedef struct task {
  void (*body)(void *, size_t);
  void *arg;
} task;
/* A worker whose thread has settings of its own. */
static void run_task(void *arg, size_t i) {
  const task *t = arg;
  const settings before = read_settings();
  if (current->now) write_settings(current->set);
  t->body(t->arg, i);
  const settings after = read_settings();
  write_settings(before);
  pthread_mutex_lock(&current->lock);
  current->hook[BODIES]++;
  if (current->now && !as_before(after)) current->body_unlike++;
  pthread_mutex_unlock(&current->lock);
}
static void counting_parallel_for(void *user, size_t n, void (*body)(void *, size_t), void *arg) {
  task t = {body, arg};
  (void)user;
  count_hook(PARALLEL);
  threads_for(2, n, run_task, &t);
}
static void counting_texture(void *user, const pktrt_points *p) {
  (void)user;
  count_hook(TEXTURES);
  for (uint32_t i = 0; i < p->n; i++) p->albedo[0][i] = 0.3f + 0.1f * p->barycentric[0][i];
}
static void counting_shader(void *user, const pktrt_points *p, float *radiance[3]) {
  (void)user;
  count_hook(SHADES);
  for (uint32_t i = 0; i < p->n; i++)
    for (int a = 0; a < 3; a++) radiance[a][i] = 0.3f * fabsf(p->normal[a][i]) / 3;
}
static void counting_environment(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  count_hook(ENVIRONMENT);
  for (uint32_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) radiance[a][i] = 0.1f + direction[a][i] * direction[a][i] / 7;
}
static bool counting_progress(void *user, float done) {
  (void)user;
  count_hook(PROGRESS);
  return done >= 0;
}
static void counting_packet(void *user, const pktrt_packet *p) {
  (void)user, (void)p;
  count_hook(PACKET);
}
static void counting_trace(void *user, const pktrt_event *e) {
  (void)user, (void)e;
  count_hook(TRACES);
}
static float counting_sampler(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  (void)user;
  count_hook(SAMPLES);
  return (float)(mix64(x + y * 977 + sample * 7919 + dimension * 104729 + (uint64_t)seed * 1299709) >> 40) * 0x1p-24f;
}
static bool counting_pass(void *user, const pktrt_report *r) {
  (void)user;
  count_hook(PASSED);
  return r->rounds < 100;
}
static double counting_clock(void *user) {
  (void)user;
  count_hook(CLOCK);
  return 0;
}

/* --- every call --- */

enum { RAYS = 90, WIDTH = 12, HEIGHT = 8, CAPACITY = 6 };

/* Makes the scene: bumpy bodies at rest and moving, one tiny enough for denormal numbers, a model and instances. */
static pktrt_scene *make_scene(pktrt_isa isa) {
  pktrt_scene *s = NULL;
  pktrt_scene_desc d = current->desc = scene_desc_of(isa, 2);
  d.allocate = counting_allocate, d.release = counting_release, d.parallel_for = counting_parallel_for,
  d.log = counting_log;
  CALL(pktrt_scene_create, s = pktrt_scene_create(&d));
  enter();
  const char *sentence = pktrt_last_error(NULL);
  leave("pktrt_last_error");
  add("pktrt_last_error", sentence, strlen(sentence));
  if (!CHECK(s != NULL, "%s: %s", current->now ? current->now->name : "usual", sentence)) return NULL;

  world w = world_moving(1);
  pktrt_status status[2] = {PKTRT_OK, PKTRT_OK};
  for (uint32_t i = 0; i < w.n; i++) {
    pktrt_mesh_desc m = mesh_desc(&w.m[i]);
    m.material = i + 1;
    CALL(pktrt_add_mesh, status[0] = pktrt_add_mesh(s, &m, NULL));
    CHECK(status[0] == PKTRT_OK);
  }
  mesh tiny = mesh_sphere(1, 0.1f, 3), body = mesh_sphere(1, 0.2f, 4);
  mesh_scale(&tiny, 0x1p-124f);
  pktrt_mesh_desc m = mesh_desc(&tiny), model = mesh_desc(&body);
  m.normals = tiny.p, m.texcoords = tiny.p;
  CALL(pktrt_add_mesh, status[0] = pktrt_add_mesh(s, &m, NULL));
  CALL(pktrt_add_model, status[1] = pktrt_add_model(s, &model, 1, NULL));
  CHECK(status[0] == PKTRT_OK && status[1] == PKTRT_OK, "%s", pktrt_last_error(s));
  float place[24] = {
      0.3f, 0.1f, 0, 3, 0, 0.4f, 0.2f, 1, 0.1f, 0, 0.7f, -1, 0.3f, 0.1f, 0, 3.3f, 0, 0.4f, 0.1f, 1, 0.1f, 0, 0.6f, -1};
  pktrt_instance_desc in = {0, 2, place, 0, PKTRT_INTERPOLATION_LINEAR};
  uint32_t index[2] = {9, 9};
  CALL(pktrt_add_instance, status[0] = pktrt_add_instance(s, &in, &index[0]));
  in.interpolation = PKTRT_INTERPOLATION_RIGID;
  CALL(pktrt_add_instance, status[1] = pktrt_add_instance(s, &in, &index[1]));
  CHECK(status[0] == PKTRT_OK && status[1] == PKTRT_OK, "%s", pktrt_last_error(s));
  CALL(pktrt_commit, status[0] = pktrt_commit(s));
  CHECK(status[0] == PKTRT_OK, "%s", pktrt_last_error(s));

  /* All of it moves a little: the first mesh, the tiny one's normals, an instance. */
  for (uint32_t i = 0; i < 3 * w.m[0].nv; i++) w.m[0].p[i] *= 1.1f;
  place[3] = 2.9f;
  CALL(pktrt_set_positions, status[0] = pktrt_set_positions(s, 0, 0, w.m[0].p));
  CALL(pktrt_set_normals, status[1] = pktrt_set_normals(s, w.n, 0, tiny.p));
  CHECK(status[0] == PKTRT_OK && status[1] == PKTRT_OK, "%s", pktrt_last_error(s));
  CALL(pktrt_set_transform, status[0] = pktrt_set_transform(s, index[1], 0, place));
  CALL(pktrt_set_transforms, status[1] = pktrt_set_transforms(s, index[0], place));
  CHECK(status[1] == PKTRT_OK, "%s", pktrt_last_error(s));
  CALL(pktrt_refit, status[1] = pktrt_refit(s));
  CHECK(status[0] == PKTRT_OK && status[1] == PKTRT_OK, "%s", pktrt_last_error(s));
  mesh_free(&tiny), mesh_free(&body), world_free(&w);
  return s;
}

/* Rays at all of the scene, the last third of them at the tiny body, whose differences are denormal. */
static void make_all_rays(pktrt_ray *rays) {
  rng r = rng_of(77);
  for (int i = 0; i < RAYS; i++) {
    const float scale = i < RAYS * 2 / 3 ? 1 : 0x1p-124f;
    float from[3], to[3];
    for (int a = 0; a < 3; a++) from[a] = 5 * rng_sign(&r) * scale, to[a] = 0.6f * rng_sign(&r) * scale;
    rays[i] = ray_towards(from, to, rng_unit(&r));
    for (int a = 0; a < 3 && i % 2 && scale < 1; a++) rays[i].direction[a] *= 0x1p127f; /* so is t */
  }
}

static void make_queries(const pktrt_scene *s) {
  pktrt_ray rays[RAYS], out[RAYS], one;
  pktrt_hit hits[RAYS], hit, few[CAPACITY], all[CAPACITY * RAYS];
  float directions[3 * RAYS], points[3 * RAYS], times[RAYS], row[7][RAYS], found[3][RAYS], none[3] = {0, 0, 0};
  uint32_t mesh_row[RAYS];
  bool is, occluded[RAYS];
  size_t counts[RAYS], count;
  int winding[RAYS], wind;
  pktrt_point_query queries[RAYS];
  pktrt_closest nearest[RAYS];
  pktrt_surface_info surface[RAYS], at;
  rng r = rng_of(78);
  make_all_rays(rays);
  for (int i = 0; i < RAYS; i++) {
    for (int a = 0; a < 3; a++) {
      directions[3 * i + a] = rng_sign(&r), points[3 * i + a] = 0.4f * rng_sign(&r) * (i % 3 ? 1 : 0x1p-124f);
      row[a][i] = rays[i].origin[a], row[3 + a][i] = rays[i].direction[a];
    }
    row[6][i] = times[i] = rays[i].time;
    memcpy(queries[i].point, points + 3 * i, sizeof queries[i].point);
    queries[i].max_distance = INFINITY, queries[i].time = times[i], queries[i].mask = 0;
  }
  const pktrt_rays soa = {{row[0], row[1], row[2]}, {row[3], row[4], row[5]}, NULL, NULL, row[6]};
  const pktrt_hits to = {found[0], found[1], found[2], {NULL, NULL, NULL}, mesh_row, NULL};
  memset(few, 0, sizeof few);
  for (int i = 0; i < RAYS; i++) {
    CALL(pktrt_intersect, is = pktrt_intersect(s, &rays[i], &hits[i]));
    KEEP(pktrt_intersect, is), KEEP(pktrt_intersect, hits[i]);
    CALL(pktrt_occluded, is = pktrt_occluded(s, &rays[i]));
    KEEP(pktrt_occluded, is);
    CALL(pktrt_intersect_after, is = pktrt_intersect_after(s, &rays[i], &hits[i], &hit));
    KEEP(pktrt_intersect_after, is), KEEP(pktrt_intersect_after, hit);
    CALL(pktrt_intersect_all, count = pktrt_intersect_all(s, &rays[i], few, CAPACITY));
    KEEP(pktrt_intersect_all, count), KEEP(pktrt_intersect_all, few);
    CALL(pktrt_winding, wind = pktrt_winding(s, i % 5 ? 2 : 4, points + 3 * i, times[i]));
    KEEP(pktrt_winding, wind);
    CALL(pktrt_closest_point, is = pktrt_closest_point(s, points + 3 * i, i % 3 ? INFINITY : 0.2f, &nearest[i]));
    KEEP(pktrt_closest_point, is), KEEP(pktrt_closest_point, nearest[i]);
    CALL(pktrt_spawn, pktrt_spawn(s, &rays[i], &hits[i], directions + 3 * i, &one));
    KEEP(pktrt_spawn, one);
    CALL(pktrt_surface, pktrt_surface(s, &rays[i], &hits[i], &at));
    KEEP(pktrt_surface, at);
    CALL(pktrt_spawn_at,
        pktrt_spawn_at(s, hits[i].mesh, hits[i].triangle, 0.3f, 0.1f, times[i], directions + 3 * i, &one));
    KEEP(pktrt_spawn_at, one);
  }
  pktrt_query_desc paper;
  pktrt_stats stats;
  memset(&paper, 0, sizeof paper), memset(&stats, 0, sizeof stats);
  paper.path = PKTRT_PATH_PAPER, paper.trace = counting_trace, paper.stats = &stats;
  CALL(pktrt_intersect_n, pktrt_intersect_n(s, rays, hits, RAYS));
  KEEP(pktrt_intersect_n, hits);
  CALL(pktrt_occluded_n, pktrt_occluded_n(s, rays, occluded, RAYS));
  KEEP(pktrt_occluded_n, occluded);
  CALL(pktrt_intersect_ex, pktrt_intersect_ex(s, &paper, rays, hits, RAYS));
  KEEP(pktrt_intersect_ex, hits), KEEP(pktrt_intersect_ex, stats);
  CALL(pktrt_occluded_ex, pktrt_occluded_ex(s, &paper, rays, occluded, RAYS));
  KEEP(pktrt_occluded_ex, occluded);
  CALL(pktrt_intersect_soa, pktrt_intersect_soa(s, &soa, &to, RAYS));
  KEEP(pktrt_intersect_soa, found), KEEP(pktrt_intersect_soa, mesh_row);
  CALL(pktrt_occluded_soa, pktrt_occluded_soa(s, &soa, occluded, RAYS));
  KEEP(pktrt_occluded_soa, occluded);
  CALL(pktrt_intersect_soa_ex, pktrt_intersect_soa_ex(s, &paper, &soa, &to, RAYS));
  KEEP(pktrt_intersect_soa_ex, found), KEEP(pktrt_intersect_soa_ex, mesh_row);
  CALL(pktrt_occluded_soa_ex, pktrt_occluded_soa_ex(s, &paper, &soa, occluded, RAYS));
  KEEP(pktrt_occluded_soa_ex, occluded);
  CALL(pktrt_spawn_n, pktrt_spawn_n(s, rays, hits, directions, out, RAYS));
  KEEP(pktrt_spawn_n, out);
  CALL(pktrt_surface_n, pktrt_surface_n(s, rays, hits, surface, RAYS));
  KEEP(pktrt_surface_n, surface);
  CALL(pktrt_spawn_at_n, pktrt_spawn_at_n(s, hits, times, directions, out, RAYS));
  KEEP(pktrt_spawn_at_n, out);
  CALL(pktrt_winding_n, pktrt_winding_n(s, 2, points, times, winding, RAYS));
  KEEP(pktrt_winding_n, winding);
  CALL(pktrt_closest_point_n, pktrt_closest_point_n(s, queries, nearest, RAYS));
  KEEP(pktrt_closest_point_n, nearest);
  memset(all, 0, sizeof all);
  CALL(pktrt_intersect_all_n, pktrt_intersect_all_n(s, rays, all, CAPACITY, counts, RAYS));
  KEEP(pktrt_intersect_all_n, counts), KEEP(pktrt_intersect_all_n, all);
  CALL(pktrt_intersect_after_n, pktrt_intersect_after_n(s, rays, hits, all, RAYS));
  add("pktrt_intersect_after_n", all, RAYS * sizeof all[0]);
  CALL(pktrt_make_ray, one = pktrt_make_ray(points, none));
  KEEP(pktrt_make_ray, one);
}

static void make_reports(pktrt_scene *s, const pktrt_render_desc *d) {
  pktrt_scene_info info;
  pktrt_scene_report report;
  pktrt_tree tree;
  pktrt_node node;
  char text[2000];
  size_t length;
  bool is;
  memset(&info, 0, sizeof info), memset(&report, 0, sizeof report), memset(text, 0, sizeof text);
  CALL(pktrt_get_scene_info, pktrt_get_scene_info(s, &info));
  KEEP(pktrt_get_scene_info, info);
  CALL(pktrt_get_scene_report, pktrt_get_scene_report(s, d, &report));
  KEEP(pktrt_get_scene_report, report);
  CALL(pktrt_scene_report_text, length = pktrt_scene_report_text(&report, text, sizeof text));
  KEEP(pktrt_scene_report_text, length), KEEP(pktrt_scene_report_text, text);
  for (uint32_t i = 0; i < 8; i++) {
    CALL(pktrt_get_tree, is = pktrt_get_tree(s, i, &tree));
    KEEP(pktrt_get_tree, is), KEEP(pktrt_get_tree, tree);
    for (uint32_t k = 0; k < 4; k++) {
      CALL(pktrt_get_node, is = pktrt_get_node(s, i, k, 0.3f, &node));
      KEEP(pktrt_get_node, is), KEEP(pktrt_get_node, node);
    }
  }
}

static void make_samples(void) {
  const pktrt_sampling sampling = {PKTRT_SAMPLER_HALTON, 16, 5};
  float u[12], axis[3] = {0.6f, 0, 0.8f}, out[3], lens[2] = {0.3f, 0.9f}, f;
  CALL(pktrt_sample, pktrt_sample(&sampling, 3, 5, 7, 1, 12, u));
  KEEP(pktrt_sample, u);
  pktrt_camera camera;
  pktrt_ray ray;
  bool is;
  memset(&camera, 0, sizeof camera);
  camera.eye[2] = 7, camera.aperture = 0.1f, camera.up[1] = 1;
  pktrt_camera parallel = camera;
  parallel.projection = PKTRT_PROJECTION_ORTHOGRAPHIC, parallel.width = 3.3f, parallel.shift[0] = 0.37f;
  for (int i = 0; i < 10; i++) {
    out[2] = 0;
    CALL(pktrt_map_disk, pktrt_map_disk(u + i, out));
    KEEP(pktrt_map_disk, out);
    CALL(pktrt_map_sphere, pktrt_map_sphere(u + i, out));
    KEEP(pktrt_map_sphere, out);
    CALL(pktrt_map_cosine, pktrt_map_cosine(u + i, axis, out));
    KEEP(pktrt_map_cosine, out);
    CALL(pktrt_map_phong, pktrt_map_phong(u + i, axis, 17.5f, out));
    KEEP(pktrt_map_phong, out);
    CALL(pktrt_map_phong_naive, pktrt_map_phong_naive(u + i, axis, 17.5f, out));
    KEEP(pktrt_map_phong_naive, out);
    CALL(pktrt_fresnel_dielectric, f = pktrt_fresnel_dielectric(u[i], 1.5f));
    KEEP(pktrt_fresnel_dielectric, f);
    CALL(pktrt_fresnel_conductor, f = pktrt_fresnel_conductor(u[i], 0.2f, 3.1f));
    KEEP(pktrt_fresnel_conductor, f);
    CALL(pktrt_camera_ray, is = pktrt_camera_ray(&camera, 64, 48, 40 * (double)u[i], 20.5, lens, 0.5f, &ray));
    KEEP(pktrt_camera_ray, is), KEEP(pktrt_camera_ray, ray);
    CALL(pktrt_camera_ray, is = pktrt_camera_ray(&parallel, 64, 48, 40 * (double)u[i], 20.5, lens, 0.5f, &ray));
    KEEP(pktrt_camera_ray, is), KEEP(pktrt_camera_ray, ray);
  }
}

static void make_pictures(pktrt_scene *s) {
  pktrt_material glass, lobe, shaded, coat;
  pktrt_light sky, quad, point;
  pktrt_status status = PKTRT_OK;
  memset(&glass, 0, sizeof glass), memset(&lobe, 0, sizeof lobe);
  memset(&shaded, 0, sizeof shaded), memset(&coat, 0, sizeof coat);
  memset(&sky, 0, sizeof sky), memset(&quad, 0, sizeof quad), memset(&point, 0, sizeof point);
  glass.specular = PKTRT_SPECULAR_DIELECTRIC, glass.absorption[1] = 0.3f;
  lobe.specular = PKTRT_SPECULAR_CONDUCTOR, lobe.ior[0] = 0.2f, lobe.extinction[0] = 3, lobe.lobe = PKTRT_LOBE_PHONG;
  lobe.exponent = 50, lobe.ior[1] = lobe.ior[2] = 1.1f;
  shaded.shader = counting_shader, coat.specular = PKTRT_SPECULAR_COAT, coat.albedo[1] = 0.4f,
  coat.texture = counting_texture;
  const pktrt_material *materials[4] = {&glass, &lobe, &coat, &shaded};
  for (int i = 0; i < 4; i++) {
    CALL(pktrt_add_material, status = pktrt_add_material(s, materials[i], NULL));
    CHECK(status == PKTRT_OK, "%s", pktrt_last_error(s));
  }
  sky.kind = PKTRT_LIGHT_ENVIRONMENT, quad.kind = PKTRT_LIGHT_QUAD, point.position[1] = 5;
  quad.position[1] = 4, quad.edge[0][0] = 1, quad.edge[1][2] = 1, quad.visible = true;
  pktrt_light *lights[3] = {&sky, &quad, &point};
  for (int i = 0; i < 3; i++) {
    for (int a = 0; a < 3; a++) lights[i]->intensity[a] = 0.7f + (float)i;
    CALL(pktrt_add_light, status = pktrt_add_light(s, lights[i], NULL));
    CHECK(status == PKTRT_OK, "%s", pktrt_last_error(s));
  }
  point.position[1] = 5.5f, shaded.albedo[0] = 0.3f;
  CALL(pktrt_set_light, status = pktrt_set_light(s, 2, &point));
  CHECK(status == PKTRT_OK, "%s", pktrt_last_error(s));
  CALL(pktrt_set_material, status = pktrt_set_material(s, 4, &shaded));
  CHECK(status == PKTRT_OK, "%s", pktrt_last_error(s));
  float pixels[3 * WIDTH * HEIGHT], error[WIDTH * HEIGHT];
  unsigned char codes[3 * WIDTH * HEIGHT];
  double means[3 * WIDTH * HEIGHT];
  pktrt_pixel_sums sums[WIDTH * HEIGHT];
  static pktrt_display_sums display[WIDTH * HEIGHT];
  pktrt_report report;
  pktrt_render_desc d;
  memset(&d, 0, sizeof d), memset(sums, 0, sizeof sums), memset(&report, 0, sizeof report);
  memset(display, 0, sizeof display);
  d.samples = 1;
  d.width = WIDTH, d.height = HEIGHT, d.pixels = pixels, d.mode = PKTRT_MODE_DRT, d.tile_size = 4, d.samples = 2;
  d.camera.eye[1] = 2, d.camera.eye[2] = 6, d.camera.aperture = 0.05f, d.camera.shutter = 1, d.max_depth = 5;
  d.environment = counting_environment, d.progress = counting_progress, d.seconds = counting_clock;
  CALL(pktrt_prepare_environment, status = pktrt_prepare_environment(s, &d));
  CHECK(status == PKTRT_OK, "%s", pktrt_last_error(s));
  make_reports(s, &d);
  for (int i = 0; i < 4; i++) { /* by both paths; by all samples of a kind, or those of a hook; in adaptive passes */
    pktrt_render_desc x = d;
    if (i == 1) x.path = PKTRT_PATH_PAPER, x.trace = counting_trace, x.packet = counting_packet;
    if (i == 2) x.sampler = PKTRT_SAMPLER_CUSTOM, x.custom_sampler = counting_sampler, x.mode = PKTRT_MODE_WRT;
    if (i == 3) x.passes = 4, x.adaptive = true, x.pass = counting_pass, x.report = &report, x.pixel_error = error;
    memset(pixels, 0, sizeof pixels), memset(error, 0, sizeof error);
    CALL(pktrt_render, status = pktrt_render(s, &x));
    CHECK(status == PKTRT_OK, "%s", pktrt_last_error(s));
    KEEP(pktrt_render, pixels), KEEP(pktrt_render, error), KEEP(pktrt_render, report.rmse);
    CALL(pktrt_to_srgb8, pktrt_to_srgb8(pixels, WIDTH * HEIGHT, 1.3f, PKTRT_TONE_CURVE, codes));
    KEEP(pktrt_to_srgb8, codes);
  }
  CALL(pktrt_render_tile, status = pktrt_render_tile(s, &d, 1, 1, WIDTH - 2, HEIGHT - 2));
  CHECK(status == PKTRT_OK);
  KEEP(pktrt_render_tile, pixels);
  d.passes = 2, d.report = &report;
  for (uint32_t pass = 0; pass < 2; pass++) {
    CALL(pktrt_render_pass, status = pktrt_render_pass(s, &d, pass, 0, 0, WIDTH, HEIGHT, means));
    CHECK(status == PKTRT_OK);
    KEEP(pktrt_render_pass, means);
    CALL(pktrt_add_pass, pktrt_add_pass(means, WIDTH * HEIGHT, sums));
    KEEP(pktrt_add_pass, sums);
    CALL(pktrt_add_display_pass, pktrt_add_display_pass(means, WIDTH * HEIGHT, display));
    KEEP(pktrt_add_display_pass, display);
  }
  CALL(pktrt_finish_passes, status = pktrt_finish_passes(s, &d, 2, sums));
  CHECK(status == PKTRT_OK, "%s", pktrt_last_error(s));
  KEEP(pktrt_finish_passes, pixels), KEEP(pktrt_finish_passes, report.rmse);
}

/* Calls what has no numbers, and ends the scene. */
static void make_the_rest(pktrt_scene *s) {
  const char *text[5] = {"", "", "", "", ""};
  uint32_t number = 0;
  bool is = false;
  pktrt_status status = PKTRT_OK;
  CALL(pktrt_version, number = pktrt_version());
  KEEP(pktrt_version, number);
  CALL(pktrt_status_string, text[0] = pktrt_status_string(PKTRT_LIMIT));
  CALL(pktrt_isa_string, text[1] = pktrt_isa_string(PKTRT_ISA_SCALAR));
  CALL(pktrt_feature_string, text[2] = pktrt_feature_string(PKTRT_FEATURE_MOTION));
  CALL(pktrt_sampler_string, text[3] = pktrt_sampler_string(PKTRT_SAMPLER_HALTON));
  for (int i = 0; i < 4; i++) CHECK(text[i][0] != 0);
  CALL(pktrt_isa_available, is = pktrt_isa_available(PKTRT_ISA_AUTO));
  pktrt_mesh_info info;
  CALL(pktrt_get_mesh_info, status = pktrt_get_mesh_info(s, 0, &info));
  CHECK(status == PKTRT_OK);
  KEEP(pktrt_get_mesh_info, info.open_edges), KEEP(pktrt_get_mesh_info, info.lo);
  CALL(pktrt_get_mesh_source, is = is && !pktrt_get_mesh_source(s, 0, &number, NULL));
  CALL(pktrt_set_enabled, status = pktrt_set_enabled(s, 1, false));
  CHECK(is && status == PKTRT_OK);
  CALL(pktrt_remove_mesh, status = pktrt_remove_mesh(s, 2));
  CHECK(status == PKTRT_OK);
  CALL(pktrt_remove_light, status = pktrt_remove_light(s, 1));
  CHECK(status == PKTRT_OK);
  CALL(pktrt_remove_instance, status = pktrt_remove_instance(s, 0));
  CHECK(status == PKTRT_OK);
  CALL(pktrt_remove_instance, status = pktrt_remove_instance(s, 1));
  CHECK(status == PKTRT_OK);
  CALL(pktrt_mark_changed, status = pktrt_mark_changed(s));
  CHECK(status == PKTRT_OK);
  CALL(pktrt_commit, status = pktrt_commit(s));
  CHECK(status == PKTRT_OK);
  CALL(pktrt_remove_model, status = pktrt_remove_model(s, 0));
  CHECK(status == PKTRT_OK, "%s", pktrt_last_error(s));
  float columns[16] = {1, 2, 3, 0, 5, 6, 7, 0, 9, 10, 11, 0, 13, 14, 15, 1}, rows[12];
  CALL(pktrt_transform_from_4x4, pktrt_transform_from_4x4(columns, rows));
  KEEP(pktrt_transform_from_4x4, rows);
  CALL(pktrt_scene_destroy, pktrt_scene_destroy(s));
}

static void use_everything(session *as, pktrt_isa isa, const named_settings *now) {
  memset(as, 0, sizeof *as);
  pthread_mutex_init(&as->lock, NULL);
  as->now = now, current = as;
  if (now) write_settings(now->set), as->set = read_settings();
  write_settings(usual);
  pktrt_scene *s = make_scene(isa);
  if (s) {
    make_queries(s);
    make_samples();
    make_pictures(s);
    make_the_rest(s);
  }
  pthread_mutex_destroy(&as->lock);
}

static void same_bits_everywhere(void) {
  static session first, other;
  int calls = 0, sorts = 0;
  for (int i = 0; i < isa_count; i++) {
    use_everything(&first, isas[i], NULL);
    for (size_t k = 0; k < COUNT(odd); k++, sorts++) {
      const char *name = odd[k].name;
      use_everything(&other, isas[i], &odd[k]);
      CHECK(other.calls == first.calls, "%s: %d calls instead of %d", name, other.calls, first.calls);
      for (int n = 0; n < first.calls; n++)
        CHECK(other.call[n].hash == first.call[n].hash, "%s: %s has other bits by %s", name, first.call[n].name,
            pktrt_isa_string(isas[i]));
      CHECK(!other.unlike, "%s: %s leaves other settings or flags", name, other.unlike ? other.unlike : "");
      CHECK(!other.hook_unlike, "%s: %d calls of hooks under other settings", name, other.hook_unlike);
      CHECK(!other.body_unlike, "%s: %d tasks of parallel_for leave other settings or flags", name, other.body_unlike);
      for (int h = 0; h < HOOKS; h++) CHECK(other.hook[h] > 0, "%s is never called", hook_name[h]);
      for (int n = 0; n < other.calls; n++) calls++;
    }
  }
  say("%d kinds of calls under %d sorts of settings, %d instruction sets", first.calls, (int)COUNT(odd), isa_count);
  CHECK(calls == first.calls * sorts && sorts > 0);
}

/* Each function that the header declares is among those that were called. */
static void every_call(void) {
  static session s;
  FILE *header = fopen("pktrt.h", "r");
  if (!header) {
    say("skipped: there is no pktrt.h in this folder");
    return;
  }
  use_everything(&s, PKTRT_ISA_AUTO, NULL);
  int declared = 0;
  for (char line[400]; fgets(line, sizeof line, header) && strncmp(line, "#endif /* PKTRT_H */", 20) != 0;) {
    char name[80];
    const char *at = strncmp(line, "PKTRT_DEF ", 10) == 0 ? strstr(line, "pktrt_") : NULL;
    while (at && at[strspn(at, "abcdefghijklmnopqrstuvwxyz_0123456789")] != '(') at = strstr(at + 1, "pktrt_");
    if (!at) continue;
    snprintf(name, sizeof name, "%.*s", (int)strcspn(at, "("), at);
    bool called = false;
    for (int i = 0; i < s.calls; i++) called = called || !strcmp(s.call[i].name, name);
    CHECK(called, "%s is not called by this test", name);
    declared++;
  }
  fclose(header);
  CHECK(declared == s.calls, "%d declared, %d called", declared, s.calls);
  say("%d functions", declared);
}

/* The control: where nothing sets the library's settings, bits differ, or exceptions are raised that would trap. */
static void without_settings(void) {
#if defined(__wasm__)
  say("skipped: WebAssembly has no other settings");
  return;
#endif
  pktrt_ray rays[RAYS];
  pktrt_hit hits[RAYS], unlike[RAYS];
  const slack_parts before = slack_left;
  world w = world_of(mesh_sphere(1, 0.1f, 3));
  w.n = 2, w.m[1] = mesh_sphere(1, 0.1f, 3);
  mesh_scale(&w.m[0], 0x1p-124f);
  slack_left = slack_whole;
  pktrt_scene *s = noslack_scene(&w, PKTRT_ISA_AUTO);
  make_all_rays(rays);
  noslack_intersect(s, NULL, rays, hits, RAYS);
  for (size_t k = 0; k < COUNT(odd); k++) {
    if (odd[k].traps) {
      write_settings(usual);
      noslack_intersect(s, NULL, rays, unlike, RAYS);
      CHECK(read_settings().flags != 0, "nothing would have trapped");
      write_settings(usual);
      continue;
    }
    settings set = odd[k].set;
#if defined(__SSE2__)
    set.control |= 0x1F80; /* no traps */
#endif
    write_settings(set);
    noslack_intersect(s, NULL, rays, unlike, RAYS);
    write_settings(usual);
    CHECK(!same_bits(hits, unlike, sizeof hits), "%s changes nothing", odd[k].name);
  }
  noslack_destroy(s);
  slack_left = before;
  world_free(&w);
}

void suite_settings(void) {
  run("settings of a thread change no bit of any call, and are its own afterwards", same_bits_everywhere);
  run("the test of settings calls every public function", every_call);
  run("the control: without settings of the library's own, bits differ", without_settings);
}
