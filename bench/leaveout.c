/* What a scene pays for features that it does not have. One small static diffuse scene with a point light, and one
   call, whose instructions callgrind counts: those inside the function `measured` alone.

     make leaveout                          all figures, in ten minutes; bench/leaveout.sh puts them together
     make leaveout-check                    what must hold, and that controls fail
     leaveout FEATURE with|without render|intersect|occluded [mirror|moving|textured|lights|placed]
                                            one call; prints the bytes that the library reports
     leaveout race aside|across ROUNDS      time of rays past a moving mesh, against the same mesh at rest
     leaveout past aside|across static|moving coherent|incoherent intersect|occluded
                                            one call of these

   The library is linked to it: built in full, or with a PKTRT_NO_... switch. A word behind the call puts a mirror, a
   moving sphere, textures, seven more lights or a moving instance into the scene, with the feature and without.
     MATERIALS (of triangles), POOL (of vertices that no triangle names), RIGID, BENT (normals of textures) and PARALLEL
   (cameras) are no features that a switch leaves out: they are counted against the header of a commit before them.

   Contents: shapes, scene, call, race, main. */
#include "bench.h"
#include "../pktrt.h"

/* >>shapes --------------------------------------------------------------------------------------------------------- */

enum {
  SPHERES = 3,
  SPHERE_U = 60,
  SPHERE_V = 32,
  FLOOR_EDGE = 64,
  MANY_LIGHTS = 8,
  KEYS = 2,
  SIZE = 128,
  RAYS = SIZE * SIZE
};

typedef struct shape {
  float *positions, *normals; /* KEYS blocks each; who stands still takes the first */
  float *texcoords;
  uint32_t *indices, vertices, triangles;
} shape;

static shape grid(uint32_t columns, uint32_t rows) {
  shape s;
  s.vertices = (columns + 1) * (rows + 1), s.triangles = 2 * columns * rows;
  s.positions = (float *)take((size_t)s.vertices * 3 * KEYS, sizeof(float));
  s.normals = (float *)take((size_t)s.vertices * 3 * KEYS, sizeof(float));
  s.texcoords = (float *)take((size_t)s.vertices * 2, sizeof(float));
  s.indices = (uint32_t *)take((size_t)s.triangles * 3, sizeof(uint32_t));
  for (uint32_t i = 0; i < s.vertices; i++) {
    s.texcoords[2 * i] = (float)(i % (columns + 1)) / (float)columns;
    s.texcoords[2 * i + 1] = (float)(i / (columns + 1)) / (float)rows;
  }
  uint32_t *next = s.indices;
  for (uint32_t y = 0; y < rows; y++)
    for (uint32_t x = 0; x < columns; x++) {
      const uint32_t a = y * (columns + 1) + x, c = a + columns + 1, corner[6] = {a, a + 1, c, c, a + 1, c + 1};
      for (int i = 0; i < 6; i++) *next++ = corner[i];
    }
  return s;
}

static void free_shape(shape *s) { free(s->positions), free(s->normals), free(s->texcoords), free(s->indices); }

/* At the last key it stands where `by` leads it. */
static void set_vertex(shape *s, uint32_t i, const double p[3], const double n[3], const double by[3]) {
  for (uint32_t key = 0; key < KEYS; key++)
    for (uint32_t a = 0; a < 3; a++) {
      const size_t at = ((size_t)key * s->vertices + i) * 3 + a;
      s->positions[at] = (float)(p[a] + (key ? by[a] : 0)), s->normals[at] = (float)n[a];
    }
}

static shape sphere(const double middle[3], double radius, const double by[3]) {
  shape s = grid(SPHERE_U, SPHERE_V);
  for (uint32_t i = 0; i < s.vertices; i++) {
    const double pi = 3.14159265358979323846, u = 2 * pi / (int)SPHERE_U * (i % (SPHERE_U + 1));
    const double v = pi / (int)SPHERE_V * (i / (SPHERE_U + 1)); /* from the north pole */
    const double n[3] = {sin(v) * sin(u), cos(v), sin(v) * cos(u)};
    const double p[3] = {middle[0] + radius * n[0], middle[1] + radius * n[1], middle[2] + radius * n[2]};
    set_vertex(&s, i, p, n, by);
  }
  return s;
}

static shape hills(void) {
  static const double still[3] = {0, 0, 0};
  shape s = grid(FLOOR_EDGE, FLOOR_EDGE);
  for (uint32_t i = 0; i < s.vertices; i++) {
    const double step = 12.0 / (int)FLOOR_EDGE, x = step * (i % (FLOOR_EDGE + 1)) - 6;
    const double z = 6 - step * (i / (FLOOR_EDGE + 1));
    const double p[3] = {x, 0.2 * sin(2 * x) * sin(2 * z), z};
    const double n[3] = {-0.4 * cos(2 * x) * sin(2 * z), 1, -0.4 * sin(2 * x) * cos(2 * z)};
    const double length = sqrt(n[0] * n[0] + 1 + n[2] * n[2]), unit[3] = {n[0] / length, 1 / length, n[2] / length};
    set_vertex(&s, i, p, unit, still);
  }
  return s;
}

/* >>scene ---------------------------------------------------------------------------------------------------------- */

/* What no switch leaves out, behind the bits of features; headers before 0.19.0 have none of it. */
enum {
  EVERYDAY_MATERIALS = 1 << 24,
  EVERYDAY_POOL = 1 << 25,
  EVERYDAY_RIGID = 1 << 26,
  EVERYDAY_BENT = 1 << 27,
  EVERYDAY_PARALLEL = 1 << 28
};
#define EVERYDAY (PKTRT_VERSION >= 1900)

static void must(pktrt_scene *world, pktrt_status status) {
  if (status != PKTRT_OK) fatal(pktrt_last_error(world));
}

/* Where features ask for it: as an instance, which stands where the shape is; in a group and with a mask of its own;
   hidden. */
static void add_desc(pktrt_scene *world, pktrt_mesh_desc *d, uint32_t features, uint32_t nth) {
  uint32_t mesh = 0;
  if (features & PKTRT_FEATURE_GROUPS) d->group = nth + 1, d->mask = 1u << nth;
#ifndef PKTRT_NO_INSTANCES
  if (features & PKTRT_FEATURE_INSTANCES) {
    static const float turned[12 * KEYS] = {
        1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.8f, 0, 0.6f, 0, 0, 1, 0, 0, -0.6f, 0, 0.8f, 0};
    pktrt_instance_desc at;
    memset(&at, 0, sizeof at);
    must(world, pktrt_add_model(world, d, 1, &at.model));
    if (features & PKTRT_FEATURE_MOTION) at.key_count = KEYS, at.transforms = turned;
#if EVERYDAY
    if (features & EVERYDAY_RIGID) at.interpolation = PKTRT_INTERPOLATION_RIGID;
#endif
    must(world, pktrt_add_instance(world, &at, NULL));
    return;
  }
#endif
  must(world, pktrt_add_mesh(world, d, &mesh));
#ifndef PKTRT_NO_REMOVAL
  if (features & PKTRT_FEATURE_REMOVAL) must(world, pktrt_set_enabled(world, mesh, false));
#endif
}

static void add_shape(pktrt_scene *world, const shape *s, uint32_t features, uint32_t nth, const pktrt_material *m) {
  pktrt_mesh_desc d;
  memset(&d, 0, sizeof d);
  d.positions = s->positions, d.vertex_count = s->vertices, d.indices = s->indices, d.triangle_count = s->triangles;
  d.normals = features & PKTRT_FEATURE_NORMALS ? s->normals : NULL;
  d.texcoords = features & PKTRT_FEATURE_SURFACES ? s->texcoords : NULL;
  /* An instance moves by itself. */
  d.key_count = features & PKTRT_FEATURE_MOTION && !(features & PKTRT_FEATURE_INSTANCES) ? KEYS : 1;
  if (features & EVERYDAY_POOL) d.triangle_count /= 2;
  must(world, pktrt_add_material(world, m, &d.material));
#if EVERYDAY
  uint32_t *const of_triangle = (uint32_t *)take(s->triangles, sizeof *of_triangle);
  for (uint32_t i = 0; i < s->triangles; i++) of_triangle[i] = i % 2 ? d.material : 0;
  if (features & EVERYDAY_MATERIALS) d.triangle_materials = of_triangle;
  add_desc(world, &d, features, nth);
  free(of_triangle);
#else
  add_desc(world, &d, features, nth);
#endif
}

static void checker(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++)
    for (int a = 0; a < 3; a++) p->albedo[a][i] *= (p->triangle[i] & 2) ? 1.0f : 0.5f;
}

#if EVERYDAY
static void bumps(void *user, const pktrt_points *p) {
  checker(user, p);
  for (uint32_t i = 0; i < p->n; i++) p->normal_out[0][i] += (p->triangle[i] & 2) ? 0.1f : -0.1f;
}
#endif

static void holes(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) p->opacity[i] = fmodf(8 * p->texcoord[0][i], 1) < 0.5f ? 0.0f : 1.0f;
}

/* As far as the scene has them: the first sphere is glass or a mirror, the second metal, the third and the floor have a
   texture, which makes holes into the third where there are cutouts. */
static pktrt_material look(uint32_t i, uint32_t features) {
  pktrt_material m;
  memset(&m, 0, sizeof m);
  const bool gloss = features & PKTRT_FEATURE_GLOSS, glass = features & PKTRT_FEATURE_DIELECTRIC;
  for (int a = 0; a < 3; a++) m.albedo[a] = 0.4f, m.reflectance[a] = 0.6f, m.ior[a] = 1.5f;
  if (i == 0 && glass) m.specular = PKTRT_SPECULAR_DIELECTRIC;
  else if (i == 0 && (features & PKTRT_FEATURE_MIRROR)) m.specular = PKTRT_SPECULAR_MIRROR;
  if (i == 1 && (features & PKTRT_FEATURE_CONDUCTOR)) {
    m.specular = PKTRT_SPECULAR_CONDUCTOR;
    for (int a = 0; a < 3; a++) m.extinction[a] = 3;
  }
  const bool reflects = m.specular == PKTRT_SPECULAR_MIRROR || m.specular == PKTRT_SPECULAR_CONDUCTOR;
  if (gloss && reflects) m.lobe = PKTRT_LOBE_PHONG, m.exponent = 50;
  if (i >= 2 && (features & PKTRT_FEATURE_TEXTURES)) m.texture = checker;
#if EVERYDAY
  if (m.texture && (features & EVERYDAY_BENT)) m.texture = bumps;
#endif
  if (i == 2 && (features & PKTRT_FEATURE_SURFACES)) m.texture = holes, m.cutout = true;
  return m;
}

/* Adds lights of equal power; the first has the same place however many there are. */
static void add_lights(pktrt_scene *world, bool area, uint32_t count) {
  for (uint32_t i = 0; i < count; i++) {
    pktrt_light l;
    memset(&l, 0, sizeof l);
    l.kind = area ? PKTRT_LIGHT_QUAD : PKTRT_LIGHT_POINT;
    l.position[0] = -3 + 0.75f * (float)i, l.position[1] = 7, l.position[2] = 4 - 0.5f * (float)i;
    l.edge[0][0] = 1, l.edge[1][2] = 1; /* shines downwards */
    for (int a = 0; a < 3; a++) l.intensity[a] = 100 / (float)count;
    must(world, pktrt_add_light(world, &l, NULL));
  }
}

static pktrt_scene *make_scene(uint32_t features, uint32_t lights) {
  static const double by[3] = {0, 0.5, 0};
  pktrt_scene *world = pktrt_scene_create(NULL);
  if (!world) fatal(pktrt_last_error(NULL));
  /* The third sphere alone moves, is an instance; what is hidden is one more. */
  const uint32_t third = PKTRT_FEATURE_MOTION | PKTRT_FEATURE_INSTANCES, more = PKTRT_FEATURE_REMOVAL;
  pktrt_material m = look(SPHERES, features);
  shape s = hills();
  add_shape(world, &s, features & ~(third | more), SPHERES, &m);
  free_shape(&s);
  for (uint32_t i = 0; i < SPHERES; i++) {
    const double middle[3] = {2.4 * i - 2.4, 1.2, 0};
    m = look(i, features), s = sphere(middle, 1.1, by);
    add_shape(world, &s, features & ~(i == 2 ? more : third | more), i, &m);
    if (i == 1 && (features & more)) add_shape(world, &s, features & ~third, i, &m);
    free_shape(&s);
  }
  add_lights(world, features & PKTRT_FEATURE_AREA_LIGHTS, lights);
  must(world, pktrt_commit(world));
  return world;
}

/* >>call ----------------------------------------------------------------------------------------------------------- */

static const float eye[3] = {0, 2.5f, 7}, target[3] = {0, 0.8f, 0};

typedef enum call { RENDER, INTERSECT, OCCLUDED, CALLS } call;
static const char *const call_words[] = {"render", "intersect", "occluded", NULL};

typedef struct plan {
  const char *name;
  uint32_t feature;
  pktrt_mode mode; /* in which it shows */
} plan;
static const uint32_t all_of_them = PKTRT_FEATURE_MOTION | PKTRT_FEATURE_STATS | PKTRT_FEATURE_PAPER |
                                    PKTRT_FEATURE_LENS | PKTRT_FEATURE_SHUTTER | PKTRT_FEATURE_AREA_LIGHTS |
                                    PKTRT_FEATURE_GLOSS | PKTRT_FEATURE_DIELECTRIC | PKTRT_FEATURE_CONDUCTOR |
                                    PKTRT_FEATURE_NORMALS | PKTRT_FEATURE_TEXTURES | PKTRT_FEATURE_INSTANCES |
                                    PKTRT_FEATURE_GROUPS | PKTRT_FEATURE_REMOVAL | PKTRT_FEATURE_SURFACES;
static const uint32_t of_queries =
    PKTRT_FEATURE_MOTION | PKTRT_FEATURE_INSTANCES | PKTRT_FEATURE_GROUPS | PKTRT_FEATURE_REMOVAL;
static const plan plans[] = {{"MOTION", PKTRT_FEATURE_MOTION, PKTRT_MODE_WRT},
    {"STATS", PKTRT_FEATURE_STATS, PKTRT_MODE_WRT}, {"PAPER", PKTRT_FEATURE_PAPER, PKTRT_MODE_WRT},
    {"LENS", PKTRT_FEATURE_LENS, PKTRT_MODE_DRT}, {"SHUTTER", PKTRT_FEATURE_SHUTTER, PKTRT_MODE_DRT},
    {"AREA_LIGHTS", PKTRT_FEATURE_AREA_LIGHTS, PKTRT_MODE_DRT}, {"GLOSS", PKTRT_FEATURE_GLOSS, PKTRT_MODE_DRT},
    {"DIELECTRIC", PKTRT_FEATURE_DIELECTRIC, PKTRT_MODE_WRT}, {"CONDUCTOR", PKTRT_FEATURE_CONDUCTOR, PKTRT_MODE_WRT},
    {"NORMALS", PKTRT_FEATURE_NORMALS, PKTRT_MODE_WRT}, {"TEXTURES", PKTRT_FEATURE_TEXTURES, PKTRT_MODE_WRT},
    {"INSTANCES", PKTRT_FEATURE_INSTANCES, PKTRT_MODE_WRT}, {"GROUPS", PKTRT_FEATURE_GROUPS, PKTRT_MODE_WRT},
    {"REMOVAL", PKTRT_FEATURE_REMOVAL, PKTRT_MODE_WRT}, {"SURFACES", PKTRT_FEATURE_SURFACES, PKTRT_MODE_WRT},
    {"EVERYTHING", all_of_them, PKTRT_MODE_DRT}, {"MATERIALS", EVERYDAY_MATERIALS, PKTRT_MODE_WRT},
    {"POOL", EVERYDAY_POOL, PKTRT_MODE_WRT}, {"RIGID", EVERYDAY_RIGID, PKTRT_MODE_WRT},
    {"BENT", EVERYDAY_BENT, PKTRT_MODE_WRT}, {"PARALLEL", EVERYDAY_PARALLEL, PKTRT_MODE_WRT}};
enum { PLANS = sizeof plans / sizeof *plans };

typedef struct work {
  pktrt_scene *world;
  call which;
  pktrt_render_desc view;
  pktrt_query_desc query;
  pktrt_ray *rays;
  pktrt_hit *hits;
  bool *occluded;
  size_t count;
} work;

/* Not inlined, not cloned: callgrind knows it by its name. */
#if defined(__GNUC__)
#define NAMED __attribute__((noinline, used))
#else
#define NAMED
#endif
NAMED static pktrt_status measured(const work *w) {
  const bool plain = !w->query.stats && w->query.path == PKTRT_PATH_FAST;
  if (w->which == RENDER) return pktrt_render(w->world, &w->view);
  if (w->which == INTERSECT && plain) pktrt_intersect_n(w->world, w->rays, w->hits, w->count);
  else if (w->which == INTERSECT) pktrt_intersect_ex(w->world, &w->query, w->rays, w->hits, w->count);
  else if (plain) pktrt_occluded_n(w->world, w->rays, w->occluded, w->count);
  else pktrt_occluded_ex(w->world, &w->query, w->rays, w->occluded, w->count);
  return PKTRT_OK;
}

static void open_rays(work *w, size_t count) {
  w->count = count;
  w->rays = (pktrt_ray *)take(count, sizeof *w->rays), w->hits = (pktrt_hit *)take(count, sizeof *w->hits);
  w->occluded = (bool *)take(count, sizeof *w->occluded);
}

static void close_rays(work *w) { free(w->rays), free(w->hits), free(w->occluded); }

/* Row by row, each ray at a time of its own. */
static void camera_rays(pktrt_ray *rays, uint32_t size, const float from[3], const float to[3]) {
  const double d[3] = {
      (double)to[0] - (double)from[0], (double)to[1] - (double)from[1], (double)to[2] - (double)from[2]};
  const double right[3] = {-d[2], 0, d[0]}; /* as long as the view is far, but for its tilt: 53 degrees */
  memset(rays, 0, (size_t)size * size * sizeof *rays);
  for (uint32_t i = 0; i < size * size; i++) {
    const double x = (i % size + 0.5) / size - 0.5, y = 0.5 - (i / size + 0.5) / size;
    const double far = sqrt(d[0] * d[0] + d[2] * d[2]);
    for (int a = 0; a < 3; a++) {
      rays[i].origin[a] = from[a];
      rays[i].direction[a] = (float)(d[a] + right[a] * x + (a == 1 ? far * y : 0));
    }
    rays[i].tmax = INFINITY, rays[i].time = (float)fmod(i * 0.61803398875, 1);
  }
}

static void describe(work *w, uint32_t features, pktrt_mode mode, pktrt_stats *stats) {
  pktrt_render_desc *d = &w->view;
  memset(d, 0, sizeof *d), memset(&w->query, 0, sizeof w->query);
  d->width = d->height = SIZE, d->mode = mode, d->samples = mode == PKTRT_MODE_DRT ? 4 : 1;
  d->pixels = (float *)take((size_t)RAYS * 3, sizeof(float));
  memcpy(d->camera.eye, eye, sizeof eye), memcpy(d->camera.target, target, sizeof target);
  for (int a = 0; a < 3; a++) d->background[a] = 0.5f, d->ambient[a] = 0.1f;
#if EVERYDAY
  if (features & EVERYDAY_PARALLEL) d->camera.projection = PKTRT_PROJECTION_ORTHOGRAPHIC, d->camera.width = 7;
#endif
  if (features & PKTRT_FEATURE_LENS) d->camera.aperture = 0.3f;
  if (features & PKTRT_FEATURE_SHUTTER) d->camera.shutter = 0.5f;
  if (features & PKTRT_FEATURE_PAPER) d->path = w->query.path = PKTRT_PATH_PAPER;
  if (features & PKTRT_FEATURE_STATS) d->stats = w->query.stats = stats;
}

static const plan *plan_of(const char *name) {
  for (int i = 0; i < PLANS; i++)
    if (!strcmp(plans[i].name, name)) return &plans[i];
  ex_fail("\"%s\" is no feature", name);
  exit(1);
}

/* Else what is counted would not be what the table says. */
static void must_be_used(const plan *p, const work *w, bool with, const pktrt_scene_report *r) {
  const uint32_t looked_at = p->feature & (w->which == RENDER ? all_of_them : of_queries);
  if ((r->used & looked_at) != (with ? looked_at : 0)) fatal("the report does not say what this call uses");
}

static uint32_t features_in(const plan *p, bool with, const char *base) {
  uint32_t features = with ? p->feature : 0;
  if (features & PKTRT_FEATURE_SHUTTER) features |= PKTRT_FEATURE_MOTION; /* else nobody sees it */
  if (features & PKTRT_FEATURE_GLOSS) features |= PKTRT_FEATURE_MIRROR;
  if (features & PKTRT_FEATURE_SURFACES) features |= PKTRT_FEATURE_TEXTURES; /* which make the holes */
  if (!strcmp(base, "mirror")) features |= PKTRT_FEATURE_MIRROR;
  if (!strcmp(base, "textured")) features |= PKTRT_FEATURE_TEXTURES;
  if (!strcmp(base, "moving")) features |= PKTRT_FEATURE_MOTION;
  if (!strcmp(base, "placed")) features |= PKTRT_FEATURE_MOTION | PKTRT_FEATURE_INSTANCES;
  return features;
}

static void print_report(const pktrt_scene_report *r) {
  printf("%llu %.3f %llu %s\n", (unsigned long long)r->bytes, (double)r->bytes / (double)r->info.triangles,
      (unsigned long long)r->worker, pktrt_isa_string(r->info.isa));
}

static int run_call(const char *name, bool with, const char *word, const char *base) {
  static work w;
  static pktrt_stats stats;
  const plan *p = plan_of(name);
  const uint32_t features = features_in(p, with, base);
  pktrt_scene_report report;
  int which = 0;
  if (!ex_parse_word("call", word, call_words, &which)) return 1;
  w.which = (call)which, w.world = make_scene(features, !strcmp(base, "lights") ? MANY_LIGHTS : 1);
  describe(&w, features, p->mode, &stats);
  open_rays(&w, RAYS);
  camera_rays(w.rays, SIZE, eye, target);
  pktrt_get_scene_report(w.world, w.which == RENDER ? &w.view : NULL, &report);
  must_be_used(p, &w, with, &report);
  must(w.world, measured(&w));
  print_report(&report);
  pktrt_scene_destroy(w.world);
  free(w.view.pixels), close_rays(&w);
  return 0;
}

/* >>race ----------------------------------------------------------------------------------------------------------- */

enum { RACE_SIZE = 256, RACE_RAYS = RACE_SIZE * RACE_SIZE, MAX_ROUNDS = 1001 };

/* Static hills and spheres, and one more sphere: aside, or across the rays' way. It moves, or stands where it was. */
static pktrt_scene *race_scene(bool aside, bool moves, float lo[3], float hi[3]) {
  static const double by[3] = {0, 0, 1.5};
  const double middle[3] = {aside ? 20.0 : 2.0, 1, -1};
  pktrt_scene *world = make_scene(0, 1);
  const pktrt_material m = look(SPHERES, 0);
  shape s = sphere(middle, 2, by);
  add_shape(world, &s, moves ? PKTRT_FEATURE_MOTION : 0, 0, &m);
  must(world, pktrt_commit(world));
  for (int a = 0; a < 3; a++) lo[a] = INFINITY, hi[a] = -INFINITY;
  for (uint32_t i = 0; i < 3 * KEYS * s.vertices; i++) {
    lo[i % 3] = fminf(lo[i % 3], s.positions[i]), hi[i % 3] = fmaxf(hi[i % 3], s.positions[i]);
  }
  free_shape(&s);
  return world;
}

/* Lines through two points of the static part, towards smaller x. */
static void incoherent_rays(pktrt_ray *rays) {
  uint32_t state = 1;
  camera_rays(rays, RACE_SIZE, eye, target);
  for (uint32_t i = 0; i < RACE_RAYS; i++) {
    float p[2][3];
    for (int k = 0; k < 6; k++) {
      state = state * 1664525u + 1013904223u;
      const float u = (float)(state >> 8) / 16777216.0f;
      p[k / 3][k % 3] = k % 3 == 1 ? 2.5f * u : 12 * u - 6;
    }
    const int first = p[0][0] > p[1][0] ? 0 : 1;
    for (int a = 0; a < 3; a++) rays[i].origin[a] = p[first][a], rays[i].direction[a] = p[!first][a] - p[first][a];
  }
}

static bool meets(const pktrt_ray *r, const float lo[3], const float hi[3]) {
  double in = (double)r->tmin, out = (double)r->tmax;
  for (int a = 0; a < 3; a++) {
    const double o = (double)r->origin[a], d = (double)r->direction[a];
    const double x = ((double)lo[a] - o) / d, y = ((double)hi[a] - o) / d;
    in = fmax(in, fmin(x, y)), out = fmin(out, fmax(x, y));
  }
  return in <= out;
}

static double race_seconds(work *w, pktrt_scene *world, call which) {
  const double start = cpu_seconds();
  w->world = world, w->which = which;
  measured(w);
  return cpu_seconds() - start;
}

/* Of the moving scene's time over the static one's, round by round, who is first in turns. */
static double race(pktrt_scene *const world[2], call which, work *w, unsigned rounds) {
  static double ratio[MAX_ROUNDS];
  double seconds[2];
  for (int i = 0; i < 2; i++) race_seconds(w, world[i], which);
  for (unsigned n = 0; n < rounds; n++) {
    for (unsigned i = 0; i < 2; i++) seconds[(i + n) % 2] = race_seconds(w, world[(i + n) % 2], which);
    ratio[n] = seconds[1] / seconds[0];
  }
  return median_of(ratio, rounds);
}

/* How many of them there are that meet the bounds, as a part. */
static double race_rays(work *w, bool incoherent, bool aside, const float lo[3], const float hi[3]) {
  static const float from[3] = {7, 2.5f, 0}, to[3] = {0, 0.8f, 0};
  uint32_t met = 0;
  if (incoherent) incoherent_rays(w->rays);
  else camera_rays(w->rays, RACE_SIZE, from, to);
  for (uint32_t i = 0; i < RACE_RAYS; i++) met += meets(&w->rays[i], lo, hi);
  if (aside && met) fatal("rays meet the bounds that they should miss");
  return (double)met / (int)RACE_RAYS;
}

static int run_races(bool aside, unsigned rounds) {
  static work w;
  float lo[3], hi[3];
  pktrt_scene *world[2] = {race_scene(aside, false, lo, hi), race_scene(aside, true, lo, hi)};
  open_rays(&w, RACE_RAYS);
  for (int incoherent = 0; incoherent < 2; incoherent++) {
    const double met = race_rays(&w, incoherent, aside, lo, hi);
    for (int which = INTERSECT; which <= OCCLUDED; which++)
      printf("%s_%s %.4f %.4f\n", incoherent ? "incoherent" : "coherent", call_words[which],
          race(world, (call)which, &w, rounds), met);
  }
  for (int i = 0; i < 2; i++) pktrt_scene_destroy(world[i]);
  close_rays(&w);
  return 0;
}

/* One call of them, to be counted. */
static int run_past(bool aside, bool moves, bool incoherent, const char *word) {
  static work w;
  float lo[3], hi[3];
  int which = 0;
  pktrt_scene_report report;
  if (!ex_parse_word("call", word, call_words, &which)) return 1;
  w.world = race_scene(aside, moves, lo, hi), w.which = which == OCCLUDED ? OCCLUDED : INTERSECT;
  open_rays(&w, RACE_RAYS);
  race_rays(&w, incoherent, aside, lo, hi);
  measured(&w);
  pktrt_get_scene_report(w.world, NULL, &report);
  print_report(&report);
  pktrt_scene_destroy(w.world);
  close_rays(&w);
  return 0;
}

/* >>main ----------------------------------------------------------------------------------------------------------- */

int main(int argc, char **argv) {
  unsigned rounds = 0;
  if (argc == 4 && !strcmp(argv[1], "race") && ex_parse_uint("rounds", argv[3], 1, MAX_ROUNDS, &rounds))
    return run_races(!strcmp(argv[2], "aside"), rounds);
  if (argc == 6 && !strcmp(argv[1], "past"))
    return run_past(!strcmp(argv[2], "aside"), !strcmp(argv[3], "moving"), !strcmp(argv[4], "incoherent"), argv[5]);
  if (argc >= 4 && strcmp(argv[1], "race") && strcmp(argv[1], "past"))
    return run_call(argv[1], !strcmp(argv[2], "with"), argv[3], argc > 4 ? argv[4] : "");
  fprintf(stderr,
      "usage: %s FEATURE with|without render|intersect|occluded [mirror|moving|textured|lights]\n"
      "       %s race aside|across ROUNDS\n"
      "       %s past aside|across static|moving coherent|incoherent intersect|occluded\n",
      argv[0], argv[0], argv[0]);
  return 1;
}
