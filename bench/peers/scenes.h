/* scenes.h - part of peers.c: what is traced. Built-in scenes, generated ones, mesh files; their cameras, their
   light, and how they move.

   Contents: stages, files, generated, views, motion. */
#ifndef PEERS_SCENES_H
#define PEERS_SCENES_H

#include "../bench.h"
#define PKTRT_IMPLEMENTATION
#define PK_ALSO_STAMP "bench/peers/limits_stamp.h"
#include "../../pktrt.h"
#include "../../examples/mesh_file.h"
#include "../../examples/scenes.h"
#include <dirent.h>

/* >>stages --------------------------------------------------------------------------------------------------------- */

typedef enum group { BUILT_IN, GENERATED, MESHES, GROUPS } group; /* over each of which means are taken */
static const char *const group_names[GROUPS] = {"built-in", "generated", "meshes"};

typedef struct stage { /* a scene with all that its rays need */
  char name[48];
  group of;
  scene s;         /* meshes at rest are key 0 of one or two */
  bool soup;       /* of triangles without indices: pktrt is given none, though s has some for all others */
  float light[3];  /* the point where shadow rays end or begin */
  double diagonal; /* of the box around it at rest */
} stage;

typedef struct view_options { /* of meshes that bring none of their own */
  float camera[9], light[3], up[3];
  unsigned camera_count; /* 0: not given; 6: eye and target; 9: and up */
  bool has_light;
} view_options;

static unsigned parse_floats(const char *text, float *values, unsigned most) { /* how many; 0: no list of numbers */
  for (unsigned n = 0; n < most;) {
    char *end;
    values[n] = strtof(text, &end);
    if (end == text || !(fabsf(values[n]) < 1e30f)) return 0;
    n++;
    if (*end == '\0') return n;
    if (*end != ',') return 0;
    text = end + 1;
  }
  return 0;
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

static void scene_bounds(const scene *s, double lo[3], double hi[3]) { /* at rest */
  for (int a = 0; a < 3; a++) lo[a] = HUGE_VAL, hi[a] = -HUGE_VAL;
  for (size_t m = 0; m < s->mesh_count; m++)
    for (size_t v = 0; v < s->meshes[m].vertex_count; v++)
      for (size_t a = 0; a < 3; a++) {
        const double x = (double)s->meshes[m].positions[3 * v + a];
        lo[a] = fmin(lo[a], x), hi[a] = fmax(hi[a], x);
      }
}

/* The scene in a pktrt_scene of its own, for those who make rays. */
static pktrt_scene *stage_scene(const stage *g, pktrt_isa isa, bool high) {
  pktrt_scene_desc desc;
  scene s = g->s;
  s.meshes = (scene_mesh *)calloc(s.mesh_count + 1, sizeof *s.meshes);
  if (!s.meshes) fatal("not enough memory");
  for (size_t m = 0; m < s.mesh_count; m++) {
    s.meshes[m] = g->s.meshes[m];
    if (g->soup) s.meshes[m].indices = NULL;
  }
  memset(&desc, 0, sizeof desc);
  desc.isa = isa, desc.quality = high ? PKTRT_BUILD_HIGH : PKTRT_BUILD_DEFAULT;
  pktrt_scene *world = pktrt_scene_create(&desc);
  if (!world || scene_add(world, &s) != PKTRT_OK) fatal(pktrt_last_error(world));
  free(s.meshes);
  return world;
}

/* Takes a finished scene: only its meshes, camera and first light are looked at from here on. */
static void stage_finish(stage *g, const char *name, group of) {
  double lo[3], hi[3], sum = 0;
  snprintf(g->name, sizeof g->name, "%s", name);
  for (char *c = g->name; *c; c++)
    if (*c == ',' || *c == '|' || *c == '"') *c = '_';
  g->of = of;
  scene_bounds(&g->s, lo, hi);
  for (int a = 0; a < 3; a++) sum += (hi[a] - lo[a]) * (hi[a] - lo[a]);
  g->diagonal = sqrt(sum);
  for (size_t m = 0; m < g->s.mesh_count; m++) {
    g->s.meshes[m].deforms = false; /* scene_add takes the keys as they are */
    free(g->s.meshes[m].normals);   /* nothing is shaded here */
    g->s.meshes[m].normals = NULL;
  }
}

/* The meshes of a scene of other people's, not yet filled. */
static void stage_room(scene *s, size_t meshes) {
  memset(s, 0, sizeof *s);
  s->meshes = (scene_mesh *)calloc(meshes ? meshes : 1, sizeof(scene_mesh));
  s->materials = (scene_material *)calloc(1, sizeof(scene_material));
  s->lights = (pktrt_light *)calloc(1, sizeof(pktrt_light));
  if (!s->meshes || !s->materials || !s->lights) fatal("not enough memory");
  s->mesh_count = meshes, s->material_count = 1;
}

static void mesh_room(scene_mesh *m, uint32_t vertices, uint32_t triangles) {
  m->vertex_count = vertices, m->triangle_count = triangles, m->key_count = 1;
  m->positions = (float *)malloc((size_t)vertices * 3 * sizeof(float));
  m->indices = (uint32_t *)malloc((size_t)triangles * 3 * sizeof(uint32_t));
  if (!m->positions || !m->indices) fatal("not enough memory");
}

/* >>files ---------------------------------------------------------------------------------------------------------- */

/* Whatever the examples read: the file's meshes go into a pktrt_scene, and are copied from there. *soup: none has indices;
   they get some, as Embree wants them. */
static bool load_meshes(const char *path, scene *s, bool *soup) {
  pktrt_scene *world = pktrt_scene_create(NULL);
  if (!world) fatal("not enough memory");
  const bool ok = mesh_file_load(world, path);
  stage_room(s, ok ? world->mesh_count : 0);
  *soup = true;
  for (size_t i = 0; i < s->mesh_count; i++) {
    const pk_mesh *from = &world->meshes[i];
    scene_mesh *m = &s->meshes[i];
    mesh_room(m, from->vertex_count, from->triangle_count);
    *soup = *soup && !from->indices;
    memcpy(m->positions, from->positions, (size_t)m->vertex_count * 3 * sizeof(float));
    for (uint32_t k = 0; k < m->triangle_count * 3; k++) m->indices[k] = from->indices ? from->indices[k] : k;
  }
  pktrt_scene_destroy(world);
  return ok;
}

/* >>generated ------------------------------------------------------------------------------------------------------ */

/* Uniform in [0,1): a mixed counter, so that ray i has the same random numbers whatever was made before. */
static float uniform(uint64_t index, unsigned dimension) {
  uint64_t z = (index * 8 + dimension + 1) * 0x9E3779B97F4A7C15u;
  z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
  z = (z ^ z >> 27) * 0x94D049BB133111EBu;
  return (float)((z ^ z >> 31) >> 40) * (1.0f / 16777216.0f);
}

/* Hills of a million triangles, all of them small and alike. */
static void make_hills(scene *s) {
  enum { SIDE = 724 };
  stage_room(s, 1);
  scene_mesh *m = &s->meshes[0];
  mesh_room(m, (SIDE + 1) * (SIDE + 1), SIDE * SIDE * 2);
  for (uint32_t v = 0; v < m->vertex_count; v++) {
    const double x = (double)(v % (SIDE + 1)) / SIDE, z = (double)(v / (SIDE + 1)) / SIDE;
    double y = 0;
    for (int k = 0; k < 7; k++) y += sc_sin(360 * x * (1 << k) + 41 * k) * sc_cos(300 * z * (1 << k)) / (10 << k);
    m->positions[3 * v] = (float)(4 * x - 2), m->positions[3 * v + 1] = (float)y;
    m->positions[3 * v + 2] = (float)(4 * z - 2);
  }
  uint32_t *to = m->indices;
  for (uint32_t z = 0; z < SIDE; z++)
    for (uint32_t x = 0; x < SIDE; x++) {
      const uint32_t a = z * (SIDE + 1) + x, b = a + 1, c = a + SIDE + 1, d = c + 1;
      const uint32_t two[6] = {a, c, b, b, c, d};
      memcpy(to, two, sizeof two), to += 6;
    }
  const float eye[3] = {0, 0.7f, 2.1f}, target[3] = {0, 0, 0}, light[3] = {1, 2, 0.5f};
  memcpy(s->camera.eye, eye, sizeof eye), memcpy(s->camera.target, target, sizeof target);
  memcpy(s->lights[0].position, light, sizeof light);
  s->light_count = 1;
}

/* Loose triangles of very different sizes in a cube: what trees like least. */
static void make_chaff(scene *s) {
  stage_room(s, 1);
  scene_mesh *m = &s->meshes[0];
  mesh_room(m, 3 * 200000, 200000);
  for (uint32_t v = 0; v < m->vertex_count; v++) {
    const float size = 0.004f / (0.02f + uniform(v / 3, 6));
    for (unsigned a = 0; a < 3; a++)
      m->positions[3 * v + a] = 2 * uniform(v / 3, a) - 1 + size * (uniform(v + 1000000, a) - 0.5f);
    m->indices[v] = v;
  }
  const float eye[3] = {0.9f, 0.8f, 2.2f}, light[3] = {1.5f, 2, 1};
  memcpy(s->camera.eye, eye, sizeof eye);
  memcpy(s->lights[0].position, light, sizeof light);
  s->light_count = 1;
}

/* >>views ---------------------------------------------------------------------------------------------------------- */

/* Shadow rays end at one point: the middle of a lamp, just below the box of one that is a mesh. */
static void set_light_point(stage *g) {
  const pktrt_light *l = &g->s.lights[0];
  memcpy(g->light, l->position, sizeof g->light);
  for (int a = 0; a < 3 && l->kind == PKTRT_LIGHT_QUAD; a++) g->light[a] += 0.5f * (l->edge[0][a] + l->edge[1][a]);
  if (l->kind != PKTRT_LIGHT_MESH) return;
  const scene_mesh *m = &g->s.meshes[l->mesh];
  for (uint32_t a = 0; a < 3; a++) {
    float lo = m->positions[a], hi = lo;
    for (uint32_t i = 1; i < m->vertex_count; i++) {
      lo = fminf(lo, m->positions[3 * i + a]);
      hi = fmaxf(hi, m->positions[3 * i + a]);
    }
    g->light[a] = a == 1 ? lo - 0.05f : 0.5f * (lo + hi);
  }
}

/* How far one can go from a point, at most `far`. */
static float free_way(const pktrt_scene *world, const float from[3], const float direction[3], float far) {
  pktrt_ray r;
  pktrt_hit hit;
  memset(&r, 0, sizeof r);
  memcpy(r.origin, from, sizeof r.origin);
  memcpy(r.direction, direction, sizeof r.direction);
  normalize(r.direction);
  r.tmax = far;
  return pktrt_intersect(world, &r, &hit) ? hit.t : far;
}

/* From the middle, to where one sees farthest along the floor. */
static void view_inside(
    const stage *g, const pktrt_scene *world, pktrt_camera *c, const double middle[3], int vertical) {
  float best = -1;
  for (int a = 0; a < 3; a++) c->eye[a] = (float)middle[a];
  for (int i = 0; i < 16; i++) {
    float way[3] = {0, 0, 0};
    way[(vertical + 1) % 3] = (float)sc_cos(22.5 * i), way[(vertical + 2) % 3] = (float)sc_sin(22.5 * i);
    const float t = free_way(world, c->eye, way, (float)g->diagonal);
    if (t <= best) continue;
    best = t;
    for (int a = 0; a < 3; a++) c->target[a] = c->eye[a] + (float)g->diagonal * way[a];
  }
}

static int largest_axis(const float v[3]) {
  int k = 0;
  for (int a = 1; a < 3; a++)
    if (fabsf(v[a]) > fabsf(v[k])) k = a;
  return k;
}

/* Camera and light of a mesh: as told, or framed from outside or inside; the light, unless told, hangs in the open near
   the eye. */
static bool set_view(stage *g, const char *camera, const view_options *o) {
  pktrt_camera *c = &g->s.camera;
  float told[9];
  unsigned n = camera ? parse_floats(camera, told, 9) : o->camera_count;
  const bool inside = camera && !strcmp(camera, "inside");
  if (camera && !n && !inside && strcmp(camera, "outside"))
    return ex_fail("@%s: want inside, outside, or 6 or 9 numbers", camera);
  if (!camera) memcpy(told, o->camera, sizeof told);
  if (n && n != 6 && n != 9) return ex_fail("%s: a camera is 6 or 9 numbers", g->name);
  memcpy(c->up, n == 9 ? told + 6 : o->up, sizeof c->up);
  double lo[3], hi[3], middle[3];
  scene_bounds(&g->s, lo, hi);
  const int vertical = largest_axis(c->up);
  for (int a = 0; a < 3; a++) {
    static const double from[3] = {0.3, 0.8, 0.35}; /* up, and two aside */
    middle[a] = 0.5 * (lo[a] + hi[a]);
    c->target[a] = (float)middle[a];
    c->eye[a] = (float)(middle[a] + from[(a - vertical + 3) % 3] * g->diagonal);
  }
  pktrt_scene *world = stage_scene(g, PKTRT_ISA_AUTO, false);
  if (pktrt_commit(world) != PKTRT_OK) fatal(pktrt_last_error(world));
  if (inside) view_inside(g, world, c, middle, vertical);
  if (n) memcpy(c->eye, told, sizeof c->eye), memcpy(c->target, told + 3, sizeof c->target);
  float aside[3], to[3], way[3];
  for (int a = 0; a < 3; a++) to[a] = c->target[a] - c->eye[a];
  cross(to, c->up, aside);
  normalize(aside);
  for (int a = 0; a < 3; a++) way[a] = c->up[a] + 0.5f * aside[a];
  normalize(way);
  const float distance = 0.5f * free_way(world, c->eye, way, 0.1f * (float)g->diagonal);
  for (int a = 0; a < 3; a++) g->light[a] = c->eye[a] + distance * way[a];
  if (o->has_light) memcpy(g->light, o->light, sizeof g->light);
  pktrt_scene_destroy(world);
  return true;
}

/* FILE[@CAMERA]: the path; returns the camera, or NULL. */
static const char *split_camera(const char *text, char *path, size_t size) {
  const char *at = access(text, F_OK) == 0 ? NULL : strrchr(text, '@');
  snprintf(path, size, "%.*s", at ? (int)(at - text) : (int)strlen(text), text);
  return at ? at + 1 : NULL;
}

/* A built-in or generated scene by its name, or FILE[@CAMERA]. */
static bool open_stage(const char *text, const view_options *o, stage *g) {
  memset(g, 0, sizeof *g);
  if (scene_make(text, &g->s)) {
    stage_finish(g, text, BUILT_IN);
    set_light_point(g);
    return true;
  }
  if (!strcmp(text, "hills") || !strcmp(text, "chaff")) {
    if (text[0] == 'h') make_hills(&g->s);
    else make_chaff(&g->s);
    stage_finish(g, text, GENERATED);
    set_light_point(g);
    return true;
  }
  char path[4096], name[64];
  const char *camera = split_camera(text, path, sizeof path);
  const char *slash = strrchr(path, '/');
  snprintf(name, sizeof name, "%.40s", slash ? slash + 1 : path);
  char *dot_at = strrchr(name, '.');
  if (dot_at) *dot_at = '\0';
  if (!load_meshes(path, &g->s, &g->soup)) return false;
  stage_finish(g, name, MESHES);
  return set_view(g, camera, o);
}

static void close_stage(stage *g) { scene_free(&g->s); }

/* >>motion --------------------------------------------------------------------------------------------------------- */

static uint64_t hash_point(const float p[3]) { /* equal points move alike, so that seams stay shut */
  uint32_t bits[3];
  memcpy(bits, p, sizeof bits);
  return ((uint64_t)bits[0] << 32 | bits[1]) ^ (uint64_t)bits[2] * 0x9E3779B97F4A7C15u;
}

/* The turn, in degrees, that moves the vertices by `way` on average: a vertex at distance r from the axis moves by
   2 r sin(angle / 2). */
static double turn_of(const scene *s, const double middle[3], int u, int v, double way) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < s->mesh_count; i++)
    for (size_t k = 0; k < s->meshes[i].vertex_count; k++) {
      const float *p = s->meshes[i].positions + 3 * k;
      sum += hypot((double)p[u] - middle[u], (double)p[v] - middle[v]), count++;
    }
  return sum > 0 ? 2 * asin(fmin(1, 0.5 * way * count / sum)) * 180 / SC_PI : 0;
}

/* Gives all meshes a second key: turned about the vertical axis through the middle, so that vertices move by `share` of
   the diagonal on average; and each vertex moves by itself, up to `loose` of that along each axis. share 0: one key. */
static void set_motion(stage *g, double share, double loose) {
  const int up = largest_axis(g->s.camera.up), axis = g->s.camera.up[up] != 0 ? up : 1, u = (axis + 1) % 3,
            v = (axis + 2) % 3;
  double lo[3], hi[3], middle[3];
  scene_bounds(&g->s, lo, hi);
  for (int a = 0; a < 3; a++) middle[a] = 0.5 * (lo[a] + hi[a]);
  const double way = share * g->diagonal, turn = turn_of(&g->s, middle, u, v, way), c = sc_cos(turn), n = sc_sin(turn);
  for (size_t i = 0; i < g->s.mesh_count; i++) {
    scene_mesh *m = &g->s.meshes[i];
    const size_t floats = (size_t)m->vertex_count * 3;
    m->key_count = share > 0 ? 2 : 1;
    if (!(share > 0)) continue;
    float *p = (float *)realloc(m->positions, 2 * floats * sizeof(float));
    if (!p) fatal("not enough memory");
    m->positions = p;
    for (size_t k = 0; k < floats; k += 3) {
      const double x = (double)p[k + (size_t)u] - middle[u], y = (double)p[k + (size_t)v] - middle[v];
      double to[3];
      to[axis] = (double)p[k + (size_t)axis], to[u] = middle[u] + c * x - n * y, to[v] = middle[v] + n * x + c * y;
      for (unsigned a = 0; a < 3; a++)
        p[floats + k + a] = (float)(to[a] + loose * way * (2 * (double)uniform(hash_point(p + k), a) - 1));
    }
  }
}

#endif /* PEERS_SCENES_H */
