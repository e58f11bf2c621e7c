/* Speed beside Embree 3, on the same rays, in one process and on one core:

     make bench-peers                                          builds and runs it; ARGS="..." passes options
     taskset -c 1 build/peers --csv out/peers.csv              on a core of its own, for figures to keep

   Each kind of ray is made once by pktrt and handed to both libraries, the same floats. Every round runs all modes of
   both, one after the other, so that a slow moment hurts all alike; a first round is not timed but compared. Time is
   processor time. Embree gets its rays in its own layout and with fresh hit records, which is not timed, and runs with
   denormals flushed, as its manual advises; pktrt_ray and pktrt_hit arrays, and the arrays of the _soa calls, are used
   as they are. Embree's best mode counts. "ratio" is pktrt / Embree: above 1, pktrt is the faster.

   Contents: options, scenes, libraries, rays, modes, measuring, report. */
#include "bench.h"
#include <getopt.h>
#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"
#include "../examples/mesh_file.h"
#include "../examples/scenes.h"
#include "embree.h"

#define MAX_ROUNDS 64u
#define BUILDS 3 /* of each tree; the best time counts */

/* >>options -------------------------------------------------------------------------------------------------------- */

typedef struct options {
  const char *mesh, *csv, *only, *isa;
  float camera[9], light[3];
  unsigned camera_count; /* 0: not given; 6: eye and target; 9: and up */
  bool has_light, robust;
  unsigned size, rounds;
  float moving; /* degrees; 0: at rest */
} options;

static const char usage[] =
    "usage: peers [options]        speed of pktrt beside Embree 3; run it by `taskset -c 1` on a quiet machine\n"
    "  --mesh FILE.tri             instead of the built-in pool hall\n"
    "  --camera EX,EY,EZ,TX,TY,TZ[,UX,UY,UZ]   eye, target, up\n"
    "  --light X,Y,Z               where shadow rays end\n"
    "  --size N                    N x N primary rays, a multiple of 16 up to 4096 (1024)\n"
    "  --rounds N                  timed rounds, 1 to 64 (5)\n"
    "  --only KIND                 primary, shadow, mirror, diffuse or ao\n"
    "  --isa auto|avx2             one instruction set only; else both, where they differ\n"
    "  --moving DEGREES            two motion keys, turned about y, and every ray at a time of its own\n"
    "  --robust                    Embree's robust mode\n"
    "  --csv FILE                  all figures, one line for each mode\n";

static unsigned parse_floats(const char *text, float *values, unsigned most) {
  unsigned n = 0;
  for (;;) {
    char *end;
    if (n == most) return 0;
    values[n] = strtof(text, &end);
    if (end == text || !(fabsf(values[n]) < 1e30f)) return 0;
    n++;
    if (*end == '\0') return n;
    if (*end != ',') return 0;
    text = end + 1;
  }
}

static unsigned parse_number(const char *text, unsigned least, unsigned most) { /* 0: not a number in [least, most] */
  char *end;
  const long v = strtol(text, &end, 10);
  return end != text && *end == '\0' && v >= (long)least && v <= (long)most ? (unsigned)v : 0;
}

static bool parse_one(options *o, int key) {
  switch (key) {
  case 'm': o->mesh = optarg; return true;
  case 'c':
    o->camera_count = parse_floats(optarg, o->camera, 9);
    return o->camera_count == 6 || o->camera_count == 9 || ex_fail("--camera %s: want 6 or 9 numbers", optarg);
  case 'l':
    o->has_light = true;
    return parse_floats(optarg, o->light, 3) == 3 || ex_fail("--light %s: want X,Y,Z", optarg);
  case 's':
    o->size = parse_number(optarg, 16, 4096);
    return (o->size && o->size % 16 == 0) || ex_fail("--size %s: want a multiple of 16 up to 4096", optarg);
  case 'r':
    o->rounds = parse_number(optarg, 1, MAX_ROUNDS);
    return o->rounds || ex_fail("--rounds %s: want 1 to 64", optarg);
  case 'o': o->only = optarg; return true;
  case 'i':
    o->isa = optarg;
    return !strcmp(optarg, "auto") || !strcmp(optarg, "avx2") || ex_fail("--isa %s: want auto or avx2", optarg);
  case 'd': return parse_floats(optarg, &o->moving, 1) == 1 || ex_fail("--moving %s: want degrees", optarg);
  case 'b': o->robust = true; return true;
  case 'v': o->csv = optarg; return true;
  case 'h': fputs(usage, stdout); exit(0);
  default: return false; /* getopt has said what */
  }
}

static bool parse_options(int argc, char **argv, options *o) {
  static const struct option known[] = {
      {"mesh", required_argument, NULL, 'm'},   {"camera", required_argument, NULL, 'c'},
      {"light", required_argument, NULL, 'l'},  {"size", required_argument, NULL, 's'},
      {"rounds", required_argument, NULL, 'r'}, {"only", required_argument, NULL, 'o'},
      {"isa", required_argument, NULL, 'i'},    {"moving", required_argument, NULL, 'd'},
      {"robust", no_argument, NULL, 'b'},       {"csv", required_argument, NULL, 'v'},
      {"help", no_argument, NULL, 'h'},         {NULL, 0, NULL, 0}};
  int key;
  memset(o, 0, sizeof *o);
  o->size = 1024;
  o->rounds = 5;
  while ((key = getopt_long(argc, argv, "", known, NULL)) != -1)
    if (!parse_one(o, key)) return false;
  return optind == argc || ex_fail("%s: what is it for? (--help)", argv[optind]);
}

/* >>scenes --------------------------------------------------------------------------------------------------------- */

/* A triangle soup as a scene of one mesh; camera and light are guesses that --camera and --light overrule. */
static bool load_soup(const char *path, scene *s) {
  struct stat info;
  uint32_t count = 0;
  memset(s, 0, sizeof *s);
  if (!ex_has_suffix(path, ".tri")) return ex_fail("%s: only .tri files are read here", path);
  if (stat(path, &info) != 0) return ex_fail("%s: cannot be read: %s", path, strerror(errno));
  float *positions = mesh_file_read_tri(path, info.st_size, &count);
  if (!positions) return false;
  s->name = strrchr(path, '/') ? strrchr(path, '/') + 1 : path;
  s->meshes = (scene_mesh *)calloc(1, sizeof(scene_mesh));
  s->lights = (pktrt_light *)calloc(1, sizeof(pktrt_light));
  uint32_t *indices = (uint32_t *)malloc((size_t)count * 3 * sizeof(uint32_t));
  if (!s->meshes || !s->lights || !indices) fatal("not enough memory");
  for (uint32_t i = 0; i < count * 3; i++) indices[i] = i;
  s->mesh_count = 1;
  s->meshes[0].positions = positions;
  s->meshes[0].indices = indices;
  s->meshes[0].vertex_count = count * 3;
  s->meshes[0].triangle_count = count;
  s->meshes[0].key_count = 1;
  return true;
}

static void scene_bounds(const scene *s, double lo[3], double hi[3]) {
  for (int a = 0; a < 3; a++) lo[a] = HUGE_VAL, hi[a] = -HUGE_VAL;
  for (size_t m = 0; m < s->mesh_count; m++)
    for (size_t v = 0; v < (size_t)s->meshes[m].vertex_count * s->meshes[m].key_count; v++)
      for (int a = 0; a < 3; a++) {
        const double x = (double)s->meshes[m].positions[3 * v + (size_t)a];
        if (x < lo[a]) lo[a] = x;
        if (x > hi[a]) hi[a] = x;
      }
}

/* Gives every mesh a second key, turned about the vertical axis through the middle of the scene. */
static void set_moving(scene *s, double degrees) {
  const double c = cos(degrees * SC_PI / 180.0), n = sin(degrees * SC_PI / 180.0);
  double lo[3], hi[3];
  scene_bounds(s, lo, hi);
  const double mx = 0.5 * (lo[0] + hi[0]), mz = 0.5 * (lo[2] + hi[2]);
  for (size_t i = 0; i < s->mesh_count; i++) {
    scene_mesh *m = &s->meshes[i];
    const size_t floats = (size_t)m->vertex_count * 3;
    float *p = (float *)realloc(m->positions, 2 * floats * sizeof(float));
    if (!p) fatal("not enough memory");
    for (size_t v = 0; v < floats; v += 3) {
      const double x = (double)p[v] - mx, z = (double)p[v + 2] - mz;
      p[floats + v] = (float)(mx + c * x + n * z);
      p[floats + v + 1] = p[v + 1];
      p[floats + v + 2] = (float)(mz - n * x + c * z);
    }
    m->positions = p;
    m->key_count = 2;
    m->deforms = false; /* scene_add takes the keys as they are */
    free(m->normals); /* of one key, and nothing is shaded here */
    m->normals = NULL;
  }
}

/* Shadow rays end at one point: of a lamp that is a mesh, just below the middle of its box. */
static void set_light_point(scene *s) {
  if (s->lights[0].kind != PKTRT_LIGHT_MESH) return;
  const scene_mesh *m = &s->meshes[s->lights[0].mesh];
  for (uint32_t a = 0; a < 3; a++) {
    float lo = m->positions[a], hi = lo;
    for (uint32_t i = 1; i < m->vertex_count; i++) {
      lo = fminf(lo, m->positions[3 * i + a]);
      hi = fmaxf(hi, m->positions[3 * i + a]);
    }
    s->lights[0].position[a] = a == 1 ? lo - 0.05f : 0.5f * (lo + hi);
  }
}

static void set_view(scene *s, const options *o) {
  double lo[3], hi[3], size = 0;
  scene_bounds(s, lo, hi);
  for (int a = 0; a < 3; a++) size += (hi[a] - lo[a]) * (hi[a] - lo[a]);
  size = sqrt(size);
  pktrt_camera *c = &s->camera;
  for (int a = 0; o->mesh && a < 3; a++) {
    static const double from[3] = {0.35, 0.3, 0.8};
    c->target[a] = (float)(0.5 * (lo[a] + hi[a]));
    c->eye[a] = (float)(0.5 * (lo[a] + hi[a]) + from[a] * size);
  }
  if (o->camera_count) memcpy(c->eye, o->camera, sizeof c->eye), memcpy(c->target, o->camera + 3, sizeof c->target);
  if (o->camera_count == 9) memcpy(c->up, o->camera + 6, sizeof c->up);
  if (!(c->fov_y > 0)) c->fov_y = 45;
  if (c->up[0] == 0 && c->up[1] == 0 && c->up[2] == 0) c->up[1] = 1;
  for (int a = 0; o->mesh && a < 3; a++)
    s->lights[0].position[a] = c->eye[a] + 0.05f * (float)size * (c->up[a] + (a == 0));
  set_light_point(s);
  if (o->has_light) memcpy(s->lights[0].position, o->light, sizeof o->light);
}

static void make_scene(const options *o, scene *s) {
  if (o->mesh ? !load_soup(o->mesh, s) : !scene_make("poolhall", s) && !ex_fail("not enough memory")) exit(1);
  if (o->moving > 0 || o->moving < 0) set_moving(s, (double)o->moving);
  set_view(s, o);
}

/* >>libraries ------------------------------------------------------------------------------------------------------ */

/* Both libraries with the scene built, at one instruction set. */
typedef struct pair {
  const char *isa;
  pktrt_scene *ours;
  RTCDevice device;
  RTCScene theirs;
  double our_build, their_build; /* seconds */
  int64_t their_bytes;           /* what Embree's commit keeps */
} pair;

static void build_ours(pair *p, const scene *s) {
  p->our_build = HUGE_VAL;
  for (int i = 0; i < BUILDS; i++) {
    pktrt_scene_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.isa = strcmp(p->isa, "avx2") ? PKTRT_ISA_AUTO : PKTRT_ISA_AVX2;
    pktrt_scene_destroy(p->ours);
    p->ours = pktrt_scene_create(&desc);
    if (!p->ours || scene_add(p->ours, s) != PKTRT_OK) fatal(pktrt_last_error(p->ours));
    const double start = cpu_seconds();
    if (pktrt_commit(p->ours) != PKTRT_OK) fatal(pktrt_last_error(p->ours));
    const double seconds = cpu_seconds() - start;
    if (seconds < p->our_build) p->our_build = seconds;
  }
}

static bool count_bytes(void *user, ssize_t bytes, bool post) {
  (void)post;
  *(int64_t *)user += (int64_t)bytes;
  return true;
}

static void build_theirs(pair *p, const scene *s, bool robust) {
  p->device = rtcNewDevice(strcmp(p->isa, "avx2") ? "threads=1" : "threads=1,isa=avx2");
  if (!p->device) fatal("Embree cannot be started");
  rtcSetDeviceMemoryMonitorFunction(p->device, count_bytes, &p->their_bytes);
  p->their_build = HUGE_VAL;
  for (int i = 0; i < BUILDS; i++) {
    if (p->theirs) rtcReleaseScene(p->theirs);
    p->theirs = rtcNewScene(p->device);
    rtcSetSceneBuildQuality(p->theirs, RTC_BUILD_QUALITY_MEDIUM);
    rtcSetSceneFlags(p->theirs, robust ? RTC_SCENE_FLAG_ROBUST : RTC_SCENE_FLAG_NONE);
    for (size_t m = 0; m < s->mesh_count; m++) embree_add(p->device, p->theirs, &s->meshes[m]);
    p->their_bytes = 0;
    const double start = cpu_seconds();
    rtcCommitScene(p->theirs);
    const double seconds = cpu_seconds() - start;
    if (seconds < p->their_build) p->their_build = seconds;
  }
  if (rtcGetDeviceError(p->device) != RTC_ERROR_NONE) fatal("Embree reports an error after building");
}

/* >>rays ----------------------------------------------------------------------------------------------------------- */

typedef enum kind { PRIMARY, SHADOW, MIRROR, DIFFUSE, AO, KINDS } kind;
static const char *const kind_names[KINDS] = {"primary", "shadow", "mirror", "diffuse", "ao"};
static bool kind_occlusion(kind k) { return k == SHADOW || k == AO; }

typedef struct rays { /* of one kind: as structs, and as arrays for the _soa calls */
  pktrt_ray *ray;
  float *array[9]; /* origin, direction, tmin, tmax, time */
  size_t count;
} rays;

/* Uniform in [0,1): a mixed counter, so that ray i has the same random numbers whatever was made before. */
static float uniform(size_t ray, unsigned dimension) {
  uint64_t z = ((uint64_t)ray * 8 + dimension + 1) * 0x9E3779B97F4A7C15u;
  z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
  z = (z ^ z >> 27) * 0x94D049BB133111EBu;
  return (float)((z ^ z >> 31) >> 40) * (1.0f / 16777216.0f);
}

static float dot(const float *a, const float *b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static void cross(const float *a, const float *b, float *out) {
  for (int k = 0; k < 3; k++) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    out[k] = a[i] * b[j] - a[j] * b[i];
  }
}
static void normalize(float *a) {
  const float scale = 1.0f / sqrtf(dot(a, a));
  for (int k = 0; k < 3; k++) a[k] *= scale;
}

/* Blocks of 16x16 pixels, in Z order inside: any 8, 16, 64 or 256 rays in a row are a compact piece of the picture. */
static void make_primary(const scene *s, unsigned size, bool moving, pktrt_ray *out) {
  float forward[3], right[3], up[3];
  const float half = tanf(s->camera.fov_y * (float)(SC_PI / 360.0));
  for (int a = 0; a < 3; a++) forward[a] = s->camera.target[a] - s->camera.eye[a];
  normalize(forward);
  cross(forward, s->camera.up, right);
  normalize(right);
  cross(right, forward, up);
  for (size_t i = 0; i < (size_t)size * size; i++) {
    unsigned x = 0, y = 0, block = (unsigned)(i / 256), in_block = (unsigned)(i % 256);
    for (unsigned b = 0; b < 4; b++) x |= (in_block >> 2 * b & 1) << b, y |= (in_block >> (2 * b + 1) & 1) << b;
    x += block % (size / 16) * 16, y += block / (size / 16) * 16;
    const float sx = (2 * ((float)x + 0.5f) / (float)size - 1) * half,
                sy = (1 - 2 * ((float)y + 0.5f) / (float)size) * half;
    pktrt_ray *r = &out[i];
    memcpy(r->origin, s->camera.eye, sizeof r->origin);
    for (int a = 0; a < 3; a++) r->direction[a] = forward[a] + sx * right[a] + sy * up[a];
    normalize(r->direction);
    r->tmin = 0;
    r->tmax = INFINITY;
    r->time = moving ? uniform(i, 0) : 0;
  }
}

/* A direction of the hemisphere about n, with density cos / pi: a uniform point of the disc below it, lifted up. */
static void sample_cosine(const float n[3], float u0, float u1, float out[3]) {
  const float helper[3] = {fabsf(n[0]) < 0.6f ? 1.0f : 0.0f, fabsf(n[0]) < 0.6f ? 0.0f : 1.0f, 0.0f};
  const float r = sqrtf(u0), angle = u1 * (float)(2 * SC_PI), h = sqrtf(1 - u0);
  float s[3], t[3];
  cross(n, helper, s);
  normalize(s);
  cross(n, s, t);
  for (int a = 0; a < 3; a++) out[a] = r * cosf(angle) * s[a] + r * sinf(angle) * t[a] + h * n[a];
}

/* The ray of kind k that continues primary ray i; false: there is none. */
static bool make_secondary(const pktrt_scene *world, const float *light, float ao_length, kind k, size_t i,
                           const pktrt_ray *from, const pktrt_hit *hit, pktrt_ray *out) {
  float n[3], d[3];
  if (hit->mesh == PKTRT_NONE) return false;
  memcpy(n, hit->normal, sizeof n);
  normalize(n);
  if (dot(n, from->direction) > 0)
    for (int a = 0; a < 3; a++) n[a] = -n[a];
  if (k == SHADOW) {
    for (int a = 0; a < 3; a++) d[a] = light[a] - (from->origin[a] + hit->t * from->direction[a]);
    if (!(dot(d, n) > 0)) return false; /* it faces away from the light */
  } else if (k == MIRROR) {
    for (int a = 0; a < 3; a++) d[a] = from->direction[a] - 2 * dot(n, from->direction) * n[a];
  } else {
    const unsigned dimension = k == DIFFUSE ? 1 : 3;
    sample_cosine(n, uniform(i, dimension), uniform(i, dimension + 1), d);
  }
  pktrt_spawn(world, from, hit, d, out);
  if (k == SHADOW) {
    for (int a = 0; a < 3; a++) out->direction[a] = light[a] - out->origin[a];
    out->tmax = 1; /* the light itself */
  }
  if (k == AO) out->tmax = ao_length;
  return true;
}

static void make_arrays(rays *r) {
  for (size_t i = 0; i < r->count; i++) {
    const pktrt_ray *from = &r->ray[i];
    for (int a = 0; a < 3; a++) r->array[a][i] = from->origin[a], r->array[3 + a][i] = from->direction[a];
    r->array[6][i] = from->tmin, r->array[7][i] = from->tmax, r->array[8][i] = from->time;
  }
}

/* >>modes ---------------------------------------------------------------------------------------------------------- */

typedef enum runner { OURS_N, OURS_SOA, OURS_SINGLE, EMBREE } runner;
typedef struct mode {
  const char *name;
  runner run;
  embree_way way;
} mode;

enum { SINGLE_OURS = 2, FIRST_EMBREE = 3, SINGLE_EMBREE = 3, MODES = 10 };
static const mode modes[MODES] = {{"_n", OURS_N, {0, false, RTC_INTERSECT_CONTEXT_FLAG_NONE}},
                                  {"_soa", OURS_SOA, {0, false, RTC_INTERSECT_CONTEXT_FLAG_NONE}},
                                  {"single", OURS_SINGLE, {0, false, RTC_INTERSECT_CONTEXT_FLAG_NONE}},
                                  {"single", EMBREE, {1, false, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT}},
                                  {"8", EMBREE, {8, false, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT}},
                                  {"8 coherent", EMBREE, {8, false, RTC_INTERSECT_CONTEXT_FLAG_COHERENT}},
                                  {"16", EMBREE, {16, false, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT}},
                                  {"16 coherent", EMBREE, {16, false, RTC_INTERSECT_CONTEXT_FLAG_COHERENT}},
                                  {"stream", EMBREE, {1, true, RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT}},
                                  {"stream coherent", EMBREE, {1, true, RTC_INTERSECT_CONTEXT_FLAG_COHERENT}}};

typedef struct job { /* one kind of rays and room for all answers */
  rays r;
  bool occlusion;
  pktrt_hit *hit;
  bool *occluded;
  pktrt_hits soa;
  embree_word *embree;
} job;

static embree_rays theirs_of(const job *j) {
  embree_rays r;
  r.ray = j->r.ray, r.count = j->r.count, r.occlusion = j->occlusion, r.words = j->embree;
  return r;
}

static void run_ours(const pair *p, const mode *m, const job *j) {
  const rays *r = &j->r;
  if (m->run == OURS_N && j->occlusion) {
    pktrt_occluded_n(p->ours, r->ray, j->occluded, r->count);
  } else if (m->run == OURS_N) {
    pktrt_intersect_n(p->ours, r->ray, j->hit, r->count);
  } else if (m->run == OURS_SOA) {
    pktrt_rays soa;
    for (int a = 0; a < 3; a++) soa.origin[a] = r->array[a], soa.direction[a] = r->array[3 + a];
    soa.tmin = r->array[6], soa.tmax = r->array[7], soa.time = r->array[8];
    if (j->occlusion) pktrt_occluded_soa(p->ours, &soa, j->occluded, r->count);
    else pktrt_intersect_soa(p->ours, &soa, &j->soa, r->count);
  } else {
    for (size_t i = 0; i < r->count; i++)
      if (j->occlusion) j->occluded[i] = pktrt_occluded(p->ours, &r->ray[i]);
      else pktrt_intersect(p->ours, &r->ray[i], &j->hit[i]);
  }
}

/* The answer for ray i as one number: its t, 0 if only occlusion was asked; infinity on a miss. */
static float answer(const job *j, const mode *m, size_t i) {
  if (m->run == EMBREE) {
    const embree_rays r = theirs_of(j);
    return embree_answer(&r, m->way.width, i);
  }
  if (j->occlusion) return j->occluded[i] ? 0.0f : INFINITY;
  if (m->run == OURS_SOA) return j->soa.mesh[i] == PKTRT_NONE ? INFINITY : j->soa.t[i];
  return j->hit[i].mesh == PKTRT_NONE ? INFINITY : j->hit[i].t;
}

/* >>measuring ------------------------------------------------------------------------------------------------------ */

#define PAIRS 2
typedef struct figure { /* of one mode */
  double seconds[MAX_ROUNDS], best, median;
  size_t disagree; /* rays whose answer differs from the reference */
} figure;
typedef figure figures[PAIRS][MODES];

static double run_timed(const pair *p, const mode *m, const job *j) {
  const embree_rays r = theirs_of(j);
  if (m->run == EMBREE) embree_fill(&r, m->way.width);
  const double start = cpu_seconds();
  if (m->run == EMBREE) embree_trace(p->theirs, &m->way, &r);
  else run_ours(p, m, j);
  return cpu_seconds() - start;
}

/* Embree's answers may differ a little, ours not by a bit. */
static size_t count_disagreements(const job *j, const mode *m, const float *reference) {
  size_t n = 0;
  for (size_t i = 0; i < j->r.count; i++) {
    const float a = answer(j, m, i), b = reference[i];
    const bool same =
        m->run != EMBREE || isinf(a) || isinf(b) ? memcmp(&a, &b, sizeof a) == 0 : fabsf(a - b) <= 1e-3f * b;
    n += !same;
  }
  return n;
}

static void measure(const pair *pairs, size_t pair_count, const job *j, unsigned rounds, float *reference, figures f) {
  const size_t all = pair_count * MODES;
  for (size_t k = 0; k < all; k++) {
    run_timed(&pairs[k / MODES], &modes[k % MODES], j);
    for (size_t i = 0; k == 0 && i < j->r.count; i++) reference[i] = answer(j, &modes[0], i);
    f[k / MODES][k % MODES].disagree = count_disagreements(j, &modes[k % MODES], reference);
  }
  for (unsigned r = 0; r < rounds; r++)
    for (size_t k = 0; k < all; k++) {
      const size_t turn = (k + r * 3) % all; /* so that nobody always runs after the same one */
      f[turn / MODES][turn % MODES].seconds[r] = run_timed(&pairs[turn / MODES], &modes[turn % MODES], j);
    }
  for (size_t k = 0; k < all; k++) {
    figure *g = &f[k / MODES][k % MODES];
    g->median = median_of(g->seconds, rounds);
    g->best = g->seconds[0]; /* sorted now */
  }
}

/* >>report --------------------------------------------------------------------------------------------------------- */

static void print_builds(const pair *pairs, size_t pair_count) {
  printf("build on one thread, best of %d; memory of the tree with its triangles\n", BUILDS);
  for (size_t p = 0; p < pair_count; p++) {
    pktrt_scene_info info;
    pktrt_get_scene_info(pairs[p].ours, &info);
    printf("  %-5s pktrt %7.1f ms %7.1f MB   Embree %7.1f ms %7.1f MB   (pktrt uses %s)\n", pairs[p].isa,
           1e3 * pairs[p].our_build, 1e-6 * (double)info.tree_bytes, 1e3 * pairs[p].their_build,
           1e-6 * (double)pairs[p].their_bytes, pktrt_isa_string(info.isa));
  }
}

static void print_head(unsigned rounds) {
  printf("\nMrays/s: best of %u rounds (median); ratio = pktrt / Embree, by the best of each (by the medians)\n",
         rounds);
  printf("%-5s %-8s %8s | %-20s %-15s | %-15s %-13s | %-15s %-13s | %-20s | %s\n", "isa", "rays", "count",
         "Embree's best", "", "pktrt _n", "ratio", "pktrt _soa", "ratio", "single: both, ratio", "differ");
}

/* Embree's fastest mode. Beside our widest instruction set its AVX2 kernels compete too: they win single calls. */
static const figure *embree_best(figures f, size_t p, size_t pair_count, size_t first, size_t last, bool median,
                                 size_t *index) {
  const figure *best = NULL;
  for (size_t q = p; q < (p == 0 ? pair_count : p + 1); q++)
    for (size_t m = first; m <= last; m++) {
      const figure *g = &f[q][m];
      if (!best || (median ? g->median < best->median : g->best < best->best)) best = g, *index = q * MODES + m;
    }
  return best;
}

static void print_row(figures f, const pair *pairs, size_t p, size_t pair_count, kind k, size_t n) {
  const double mega = 1e-6 * (double)n;
  size_t i = 0, ignored = 0;
  char name[32];
  const double median = embree_best(f, p, pair_count, FIRST_EMBREE, MODES - 1, true, &ignored)->median;
  const double single = embree_best(f, p, pair_count, SINGLE_EMBREE, SINGLE_EMBREE, false, &ignored)->best;
  const figure *e = embree_best(f, p, pair_count, FIRST_EMBREE, MODES - 1, false, &i);
  snprintf(name, sizeof name, "%s%s", modes[i % MODES].name, i / MODES != p ? " avx2" : "");
  printf("%-5s %-8s %8zu | %-20s %6.1f (%6.1f) |", pairs[p].isa, kind_names[k], n, name, mega / e->best, mega / median);
  for (size_t m = 0; m < 2; m++)
    printf(" %6.1f (%6.1f) %5.2f (%5.2f) |", mega / f[p][m].best, mega / f[p][m].median, e->best / f[p][m].best,
           median / f[p][m].median);
  printf(" %5.1f %5.1f %8.2f | %zu\n", mega / f[p][SINGLE_OURS].best, mega / single, single / f[p][SINGLE_OURS].best,
         e->disagree);
  fflush(stdout);
}

static FILE *csv_open(const char *path) {
  FILE *file = path ? fopen(path, "w") : NULL;
  if (path && !file) {
    ex_fail("%s: cannot be written: %s", path, strerror(errno));
    exit(1);
  }
  if (file)
    fputs("scene,triangles,moving_degrees,embree_robust,isa,kind,rays,library,mode,best_mrays,median_mrays,disagree\n",
          file);
  return file;
}

static void csv_rows(FILE *file, const options *o, const scene *s, const pair *p, figure f[MODES], kind k, size_t n) {
  for (size_t m = 0; file && m < MODES; m++)
    fprintf(file, "%s,%llu,%g,%d,%s,%s,%zu,%s,%s,%.3f,%.3f,%zu\n", s->name, (unsigned long long)scene_triangles(s),
            (double)o->moving, o->robust, p->isa, kind_names[k], n,
            m < FIRST_EMBREE ? "pktrt" : "Embree " RTC_VERSION_STRING, modes[m].name, 1e-6 * (double)n / f[m].best,
            1e-6 * (double)n / f[m].median, f[m].disagree);
}

/* >>main ----------------------------------------------------------------------------------------------------------- */

static void make_job(job *j, size_t most) {
  memset(j, 0, sizeof *j);
  j->r.ray = (pktrt_ray *)take(most, sizeof(pktrt_ray));
  for (int a = 0; a < 9; a++) j->r.array[a] = (float *)take(most, sizeof(float));
  j->hit = (pktrt_hit *)take(most, sizeof(pktrt_hit));
  j->occluded = (bool *)take(most, sizeof(bool));
  j->soa.t = (float *)take(most, sizeof(float));
  j->soa.u = (float *)take(most, sizeof(float));
  j->soa.v = (float *)take(most, sizeof(float));
  for (int a = 0; a < 3; a++) j->soa.normal[a] = (float *)take(most, sizeof(float));
  j->soa.mesh = (uint32_t *)take(most, sizeof(uint32_t));
  j->soa.triangle = (uint32_t *)take(most, sizeof(uint32_t));
  j->embree = (embree_word *)take(most, EMBREE_RAY_HIT_WORDS * sizeof(embree_word));
}

/* Fills j with the rays of kind k; those that do not exist are left out. */
static void make_rays(job *j, const scene *s, const pair *p, kind k, const pktrt_ray *primary, const pktrt_hit *first,
                      size_t n) {
  double lo[3], hi[3], diagonal = 0;
  scene_bounds(s, lo, hi);
  for (int a = 0; a < 3; a++) diagonal += (hi[a] - lo[a]) * (hi[a] - lo[a]);
  j->occlusion = kind_occlusion(k);
  j->r.count = 0;
  for (size_t i = 0; i < n; i++) {
    pktrt_ray *to = &j->r.ray[j->r.count];
    if (k == PRIMARY) *to = primary[i], j->r.count++;
    else
      j->r.count += make_secondary(p->ours, s->lights[0].position, (float)(0.1 * sqrt(diagonal)), k, i, &primary[i],
                                   &first[i], to);
  }
  make_arrays(&j->r);
}

/* All kinds, all modes; returns the number of rays for which pktrt contradicts itself, which must be none. */
static size_t run_all(const options *o, const scene *s, const pair *pairs, size_t pair_count, FILE *csv) {
  static figures f;
  const size_t n = (size_t)o->size * o->size;
  pktrt_ray *primary = (pktrt_ray *)take(n, sizeof(pktrt_ray));
  pktrt_hit *first = (pktrt_hit *)take(n, sizeof(pktrt_hit));
  float *reference = (float *)take(n, sizeof(float));
  size_t contradictions = 0;
  job j;
  make_job(&j, n);
  make_primary(s, o->size, s->meshes[0].key_count > 1, primary);
  pktrt_intersect_n(pairs[0].ours, primary, first, n);
  print_head(o->rounds);
  for (int i = 0; i < KINDS; i++) {
    const kind k = (kind)i;
    if (o->only && strcmp(o->only, kind_names[k])) continue;
    make_rays(&j, s, &pairs[0], k, primary, first, n);
    if (j.r.count == 0) {
      printf("%-5s %-8s %8d |\n", "", kind_names[k], 0);
      continue;
    }
    measure(pairs, pair_count, &j, o->rounds, reference, f);
    for (size_t p = 0; p < pair_count; p++) {
      print_row(f, pairs, p, pair_count, k, j.r.count);
      csv_rows(csv, o, s, &pairs[p], f[p], k, j.r.count);
      for (int m = 0; m < FIRST_EMBREE; m++) contradictions += f[p][m].disagree;
    }
  }
  return contradictions; /* memory goes back with the process */
}

/* The pairs to run: auto, and AVX2 where that is another. */
static size_t make_pairs(const options *o, const scene *s, pair pairs[PAIRS]) {
  static const char *const isas[PAIRS] = {"auto", "avx2"};
  size_t n = 0;
  for (int i = 0; i < PAIRS; i++) {
    if (o->isa && strcmp(o->isa, isas[i])) continue;
    if (i == 1 && !pktrt_isa_available(PKTRT_ISA_AVX2)) continue;
    if (i == 1 && n && !pktrt_isa_available(PKTRT_ISA_AVX512)) continue; /* auto is AVX2 */
    memset(&pairs[n], 0, sizeof pairs[n]);
    pairs[n].isa = isas[i];
    build_theirs(&pairs[n], s, o->robust);
    build_ours(&pairs[n], s);
    n++;
  }
  return n;
}

int main(int argc, char **argv) {
  options o;
  scene s;
  pair pairs[PAIRS];
  double load = 0;
  if (!parse_options(argc, argv, &o)) return 2;
  bool known = !o.only;
  for (int k = 0; o.only && k < KINDS; k++) known = known || !strcmp(o.only, kind_names[k]);
  if (!known) return ex_fail("--only %s: want primary, shadow, mirror, diffuse or ao", o.only), 2;
  FILE *csv = csv_open(o.csv);
  make_scene(&o, &s);
  if (getloadavg(&load, 1) == 1 && load > 0.5)
    printf("note: load average %.1f, other work is running: figures are noisy\n", load);
  printf("%s: %llu triangles%s; %u x %u primary rays; Embree %s%s\n", s.name, (unsigned long long)scene_triangles(&s),
         s.meshes[0].key_count > 1 ? ", moving" : "", o.size, o.size, RTC_VERSION_STRING, o.robust ? ", robust" : "");
  const size_t pair_count = make_pairs(&o, &s, pairs);
  if (pair_count == 0) return ex_fail("--isa %s: this machine does not have it", o.isa), 1;
  print_builds(pairs, pair_count);
  const size_t contradictions = run_all(&o, &s, pairs, pair_count, csv);
  printf("differ: rays where Embree's best mode and pktrt disagree on hit or miss, or on t by more than 0.001 t\n");
  if (csv && (ferror(csv) | fclose(csv))) return ex_fail("%s: could not be written", o.csv), 1;
  for (size_t p = 0; p < pair_count; p++) {
    pktrt_scene_destroy(pairs[p].ours);
    rtcReleaseScene(pairs[p].theirs);
    rtcReleaseDevice(pairs[p].device);
  }
  scene_free(&s);
  return contradictions ? ex_fail("pktrt contradicts itself on %zu rays", contradictions), 1 : 0;
}
