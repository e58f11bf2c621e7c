/* scenes.h - procedural scenes for the examples, tests and benchmarks of pktrt.h. Include "pktrt.h" before it.

     scene hall;
     if (!scene_make("poolhall", &hall)) ...     unknown name or out of memory
     scene_add(s, &hall);                        materials, lights and meshes into a pktrt_scene, at rest
     scene_free(&hall);

   They move, too: time runs over [0,1] and everything is back at its end. A frame of an animation:

     scene_add_at(s, &hall, t, shutter);         once, then pktrt_commit
     scene_pose(s, &hall, t, shutter);           for each further frame, then pktrt_refit
     scene_camera(&hall, t, &camera);

   Without its lights it is also a model, for instances: scene_add_model.

   Units are metres, y points up. The same bits come out on every machine: sines are a polynomial of our own, all
   arithmetic is in double, and coordinates are snapped to a grid far coarser than any rounding (see sc_snap). Every
   mesh is one material.

   Contents: scene, maths, builder, sweeps, solids, textures, scenes (each in a file of its own), interface. */
#ifndef SCENES_H
#define SCENES_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#if defined(__GNUC__) || defined(__clang__)
#define SCENE_DEF static __attribute__((unused)) /* who includes this may not need everything */
#else
#define SCENE_DEF static
#endif

/* >>scene ---------------------------------------------------------------------------------------------------------- */

typedef struct scene_mesh {
  const char *name;
  float *positions;  /* key_count blocks of vertex_count * 3, at rest */
  float *normals;    /* the same, or NULL: flat */
  uint32_t *indices; /* triangle_count * 3, counter-clockwise from outside */
  uint32_t vertex_count, triangle_count, key_count;
  uint32_t material; /* index into scene.materials, and the kind that the mesh was made as */
  bool deforms;      /* it has poses other than the one at rest */
} scene_mesh;

typedef struct scene_material {
  const char *name;
  pktrt_material m;
} scene_material;

typedef struct scene {
  const char *name;
  scene_mesh *meshes;
  size_t mesh_count;
  scene_material *materials;
  size_t material_count;
  pktrt_light *lights;
  size_t light_count;
  pktrt_camera camera; /* that of time 0 */
  float background[3], ambient[3];
  /* Radiance from where rays meet nothing, as pktrt_render_desc wants it, in place of the background; or NULL. */
  void (*environment)(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]);
  /* The pose of a mesh that deforms: fills vertex_count * 3 of each. Time 0 and time 1 are at rest, bit for bit. */
  void (*deform)(const struct scene *, const scene_mesh *, double time, float *positions, float *normals);
  void (*camera_path)(double time, pktrt_camera *);
} scene;

SCENE_DEF bool scene_make(const char *name, scene *out); /* false: unknown name or out of memory, and *out is empty */
SCENE_DEF void scene_free(scene *);                      /* an empty one is fine */
SCENE_DEF const char *const *scene_names(void);          /* ends with NULL */
SCENE_DEF uint64_t scene_triangles(const scene *);
SCENE_DEF pktrt_status scene_add(pktrt_scene *, const scene *); /* at rest; must be the first thing added */
/* The same in the pose of `time`. shutter > 0: meshes that deform get two keys, at time and at time + shutter. */
SCENE_DEF pktrt_status scene_add_at(pktrt_scene *, const scene *, double time, double shutter);
/* The same as a model that instances show, without the lights: meshes of models are none. Its materials come before those
   that are added later, its meshes are those of each instance. */
SCENE_DEF pktrt_status scene_add_model(pktrt_scene *, const scene *, double time, double shutter, uint32_t *model);
/* Gives the meshes that deform another pose, after a scene_add_at with a shutter likewise open or shut. Then refit. */
SCENE_DEF pktrt_status scene_pose(pktrt_scene *, const scene *, double time, double shutter);
SCENE_DEF void scene_camera(const scene *, double time, pktrt_camera *);
/* Area lights of another width and the same power: their radiance falls with their area. Each lamp is a mesh with a
   material of its own, so the lamp that is seen stays the one that shines. Those without size stay as they are. */
SCENE_DEF void scene_resize_lights(scene *, double factor);

/* >>maths ---------------------------------------------------------------------------------------------------------- */

#define SC_PI 3.14159265358979323846

typedef struct sc_v3 {
  double x, y, z;
} sc_v3;

/* An affine map, p -> o + x p.x + y p.y + z p.z: a placement, or one station of a sweep. */
typedef struct sc_frame {
  sc_v3 o, x, y, z;
} sc_frame;

static sc_v3 sc_v(double x, double y, double z) {
  sc_v3 r;
  r.x = x;
  r.y = y;
  r.z = z;
  return r;
}
static sc_v3 sc_add(sc_v3 a, sc_v3 b) { return sc_v(a.x + b.x, a.y + b.y, a.z + b.z); }
static sc_v3 sc_sub(sc_v3 a, sc_v3 b) { return sc_v(a.x - b.x, a.y - b.y, a.z - b.z); }
static sc_v3 sc_mul(sc_v3 a, double s) { return sc_v(a.x * s, a.y * s, a.z * s); }
static double sc_dot(sc_v3 a, sc_v3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static sc_v3 sc_cross(sc_v3 a, sc_v3 b) {
  return sc_v(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static sc_v3 sc_unit(sc_v3 a) {
  double l = sqrt(sc_dot(a, a));
  return l > 0.0 ? sc_mul(a, 1.0 / l) : sc_v(0.0, 1.0, 0.0);
}

/* Sine of an angle in degrees: reduced to [-45,45] exactly, then the Taylor series of sine or cosine, good to 1e-15. */
static double sc_sin(double degrees) {
  double k = floor(degrees / 90.0 + 0.5), x = (degrees - k * 90.0) * (SC_PI / 180.0), x2 = x * x;
  int quadrant = (int)(k - 4.0 * floor(k / 4.0));
  double s = x * (1 + x2 * (-1 / 6.0 + x2 * (1 / 120.0 + x2 * (-1 / 5040.0 + x2 * (1 / 362880.0 - x2 / 39916800.0)))));
  double c =
      1 +
      x2 * (-0.5 + x2 * (1 / 24.0 + x2 * (-1 / 720.0 + x2 * (1 / 40320.0 + x2 * (-1 / 3628800.0 + x2 / 479001600.0)))));
  double r = quadrant & 1 ? c : s;
  return quadrant & 2 ? -r : r;
}
static double sc_cos(double degrees) { return sc_sin(degrees + 90.0); }

/* The next of a sequence of numbers spread evenly over [0,1). */
static double sc_random(uint32_t *state) {
  *state = *state * 1664525u + 1013904223u;
  return (double)(*state >> 8) / 16777216.0;
}

/* Below 2^31. WHY: floor() is a call, and textures have many. */
static inline int32_t sc_floor(double x) {
  int32_t whole = (int32_t)x;
  return whole - (x < whole);
}

/* Nearest multiple of 2^-18 m (4 micrometres), exact in a float up to 64 m. Compilers may fuse or not fuse a product
   and a sum, which moves a double by 1e-16: the grid hides it, the odd offset keeps round numbers away from ties. */
static float sc_snap(double v) { return (float)(sc_floor(v * 262144.0 + 0.5137) / 262144.0); }

/* >>builder -------------------------------------------------------------------------------------------------------- */

/* What a mesh is made of: its name, its albedo, whether it is flat (then it has no normals). */
typedef struct sc_kind {
  const char *name;
  float albedo[3];
  int flat;
} sc_kind;

typedef struct sc_build {
  scene *out;
  const sc_kind *kinds;                    /* one mesh for each */
  uint32_t *vertex_space, *triangle_space; /* room in each mesh */
  scene_mesh *mesh;                        /* the one that receives */
  sc_frame at;                             /* where things are put */
  double detail;                           /* things far from the camera: factor on the number of segments */
  uint32_t flutes;                         /* lathes: grooves around, */
  double flute_depth;                      /* and their depth relative to the radius */
  uint32_t random;
  bool failed; /* out of memory: everything is a no-op from then on */
} sc_build;

typedef struct sc_mark {
  uint32_t vertex, triangle;
} sc_mark;

static void sc_use(sc_build *b, uint32_t kind) {
  if (!b->failed) b->mesh = &b->out->meshes[kind];
}

/* Grows an array of `bytes` per element to hold one more; the memory of a failed growth stays owned by *array. */
static bool sc_reserve(sc_build *b, void **array, uint32_t *space, uint32_t used, size_t bytes) {
  uint32_t want = *space ? *space * 2 : 256;
  void *grown;
  if (used < *space) return true;
  grown = want > 0x10000000u ? NULL : realloc(*array, want * bytes);
  if (!grown) {
    b->failed = true;
    return false;
  }
  *array = grown;
  *space = want;
  return true;
}

static uint32_t sc_vertex(sc_build *b, sc_v3 p, sc_v3 n) {
  scene_mesh *m = b->mesh;
  uint32_t *space, i, had;
  void *positions, *normals;
  if (b->failed) return 0;
  space = &b->vertex_space[m - b->out->meshes];
  had = *space;
  i = m->vertex_count;
  positions = m->positions;
  normals = m->normals;
  if (!sc_reserve(b, &positions, space, i, 3 * sizeof(float))) return 0;
  m->positions = (float *)positions;
  if (!sc_reserve(b, &normals, &had, i, 3 * sizeof(float))) return 0;
  m->normals = (float *)normals;
  p = sc_add(b->at.o, sc_add(sc_mul(b->at.x, p.x), sc_add(sc_mul(b->at.y, p.y), sc_mul(b->at.z, p.z))));
  n = sc_unit(sc_add(sc_mul(b->at.x, n.x), sc_add(sc_mul(b->at.y, n.y), sc_mul(b->at.z, n.z))));
  m->positions[3 * i] = sc_snap(p.x), m->positions[3 * i + 1] = sc_snap(p.y), m->positions[3 * i + 2] = sc_snap(p.z);
  m->normals[3 * i] = sc_snap(n.x), m->normals[3 * i + 1] = sc_snap(n.y), m->normals[3 * i + 2] = sc_snap(n.z);
  return m->vertex_count++;
}

static bool sc_same(const scene_mesh *m, uint32_t i, uint32_t j) {
  return i == j || !memcmp(m->positions + 3 * i, m->positions + 3 * j, 3 * sizeof(float));
}

static void sc_triangle(sc_build *b, uint32_t i, uint32_t j, uint32_t k) {
  scene_mesh *m = b->mesh;
  void *indices;
  if (b->failed || sc_same(m, i, j) || sc_same(m, j, k) || sc_same(m, k, i)) return; /* poles, pointed ends */
  indices = m->indices;
  if (!sc_reserve(b, &indices, &b->triangle_space[m - b->out->meshes], m->triangle_count, 3 * sizeof(uint32_t))) return;
  m->indices = (uint32_t *)indices;
  m->indices[3 * m->triangle_count] = i;
  m->indices[3 * m->triangle_count + 1] = j;
  m->indices[3 * m->triangle_count + 2] = k;
  m->triangle_count++;
}

/* A number of segments at the present detail, a multiple of four. */
static uint32_t sc_segments(const sc_build *b, uint32_t n) {
  uint32_t quarters = (uint32_t)(n * b->detail / 4.0 + 0.5);
  return 4 * (quarters ? quarters : 1);
}

/* A flat quadrilateral, counter-clockwise from outside. */
static void sc_quad(sc_build *b, sc_v3 p0, sc_v3 p1, sc_v3 p2, sc_v3 p3) {
  sc_v3 n = sc_cross(sc_sub(p2, p0), sc_sub(p3, p1));
  uint32_t i = sc_vertex(b, p0, n), j = sc_vertex(b, p1, n), k = sc_vertex(b, p2, n), l = sc_vertex(b, p3, n);
  sc_triangle(b, i, j, k);
  sc_triangle(b, i, k, l);
}

static sc_mark sc_begin(const sc_build *b) {
  sc_mark r = {0, 0};
  if (!b->failed) r.vertex = b->mesh->vertex_count, r.triangle = b->mesh->triangle_count;
  return r;
}

static sc_v3 sc_get(const float *a, uint32_t i) { return sc_v(a[3 * i], a[3 * i + 1], a[3 * i + 2]); }

/* Gives the vertices since `from` normals: the sum of the cross products of their triangles, thus weighted by area. */
static void sc_smooth(sc_build *b, sc_mark from) {
  scene_mesh *m = b->mesh;
  uint32_t count, i, k;
  double *sum;
  if (b->failed || m->vertex_count == from.vertex) return;
  count = m->vertex_count - from.vertex;
  sum = (double *)calloc(count, 3 * sizeof(double));
  if (!sum) {
    b->failed = true;
    return;
  }
  for (i = from.triangle; i < m->triangle_count; i++) {
    const uint32_t *v = m->indices + 3 * i;
    sc_v3 p = sc_get(m->positions, v[0]);
    sc_v3 n = sc_cross(sc_sub(sc_get(m->positions, v[1]), p), sc_sub(sc_get(m->positions, v[2]), p));
    for (k = 0; k < 3; k++) {
      double *s = sum + 3 * (v[k] - from.vertex);
      s[0] += n.x, s[1] += n.y, s[2] += n.z;
    }
  }
  for (i = 0; i < count; i++) {
    sc_v3 n = sc_unit(sc_v(sum[3 * i], sum[3 * i + 1], sum[3 * i + 2]));
    float *to = m->normals + 3 * (from.vertex + i);
    to[0] = sc_snap(n.x), to[1] = sc_snap(n.y), to[2] = sc_snap(n.z);
  }
  free(sum);
}

/* Placements nest: `keep = sc_place(...)`, build, `b->at = keep`. */
static sc_frame sc_place(sc_build *b, double x, double y, double z, double yaw) {
  sc_frame keep = b->at, t = keep;
  double c = sc_cos(yaw), s = sc_sin(yaw);
  b->at.o = sc_add(t.o, sc_add(sc_mul(t.x, x), sc_add(sc_mul(t.y, y), sc_mul(t.z, z))));
  b->at.x = sc_sub(sc_mul(t.x, c), sc_mul(t.z, s));
  b->at.z = sc_add(sc_mul(t.x, s), sc_mul(t.z, c));
  return keep;
}
static void sc_turn_x(sc_build *b, double degrees) { /* y towards z */
  sc_frame t = b->at;
  double c = sc_cos(degrees), s = sc_sin(degrees);
  b->at.y = sc_add(sc_mul(t.y, c), sc_mul(t.z, s));
  b->at.z = sc_sub(sc_mul(t.z, c), sc_mul(t.y, s));
}
static void sc_turn_z(sc_build *b, double degrees) { /* x towards y */
  sc_frame t = b->at;
  double c = sc_cos(degrees), s = sc_sin(degrees);
  b->at.x = sc_add(sc_mul(t.x, c), sc_mul(t.y, s));
  b->at.y = sc_sub(sc_mul(t.y, c), sc_mul(t.x, s));
}

/* >>sweeps --------------------------------------------------------------------------------------------------------- */

/* A point of a profile or, seen from above, of a path. A profile is smooth but at corners. It runs from the outer
   foot up and over the top to the inner foot: then surfaces face outwards. Tables of profiles are in millimetres,
   see sc_round. */
typedef struct sc_pt {
  double x, y;
  int corner;
} sc_pt;
#define SC_COUNT(a) ((uint32_t)(sizeof(a) / sizeof((a)[0])))
#define SC_MAX_POINTS 192u

static double sc_spline(
    double a, double p, double q, double d, double t) { /* Catmull-Rom from p (t = 0) to q (t = 1) */
  return 0.5 * (2 * p + t * (q - a + t * (2 * a - 5 * p + 4 * q - d + t * (3 * p - a - 3 * q + d))));
}

/* Rounds a profile given in millimetres, {x, y} or {x, y, 1} for a corner: `sub` pieces for each stretch, one where
   both ends are corners. */
static uint32_t sc_round(const double (*p)[3], uint32_t n, uint32_t sub, sc_pt *out) {
  uint32_t i, k, count = 0;
  for (i = 0; i < n; i++) {
    bool corner = p[i][2] > 0.0, last = i + 1 == n, sharp = !last && p[i + 1][2] > 0.0;
    const double *a = p[corner || i == 0 ? i : i - 1], *q = p[last ? i : i + 1],
                 *d = p[last                  ? i
                        : sharp || i + 2 == n ? i + 1
                                              : i + 2];
    uint32_t pieces = last || (corner && sharp) ? 1 : sub;
    for (k = 0; k < pieces && count < SC_MAX_POINTS; k++) {
      double t = (double)k / pieces;
      out[count].x = 0.001 * sc_spline(a[0], p[i][0], q[0], d[0], t);
      out[count].y = 0.001 * sc_spline(a[1], p[i][1], q[1], d[1], t);
      out[count++].corner = k == 0 && corner;
    }
  }
  return count;
}

/* The surface that a profile draws on its way through the frames; it faces along `dprofile x dpath`. `ring`: the path
   closes; `loop`: the profile closes, without corners. Where the profile's x is 0, each `pole` frames in a row share
   a vertex. */
static void sc_sweep(sc_build *b, const sc_frame *f, uint32_t frames, bool ring, const sc_pt *p, uint32_t points,
    bool loop, uint32_t pole) {
  uint32_t begin = 0, end, i, j, last = ring ? frames : frames - 1;
  while (begin + 1 < points) {
    uint32_t row[SC_MAX_POINTS + 1];
    sc_mark mark = sc_begin(b);
    for (end = begin + 1; end + 1 < points && !p[end].corner; end++) continue;
    for (j = begin; j <= end; j++) {
      uint32_t step = p[j].x == 0.0 ? pole : 1;
      row[j] = sc_begin(b).vertex;
      for (i = 0; i < frames; i += step)
        sc_vertex(b, sc_add(f[i].o, sc_add(sc_mul(f[i].x, p[j].x), sc_mul(f[i].y, p[j].y))), f[i].y);
    }
    for (j = begin; j < end + (loop ? 1 : 0); j++) {
      uint32_t next = j < end ? j + 1 : 0, s = p[j].x == 0.0 ? pole : 1, t = p[next].x == 0.0 ? pole : 1;
      for (i = 0; i < last; i++) {
        uint32_t k = i + 1 < frames ? i + 1 : 0;
        sc_triangle(b, row[j] + i / s, row[next] + i / t, row[next] + k / t);
        sc_triangle(b, row[j] + i / s, row[next] + k / t, row[j] + k / s);
      }
    }
    sc_smooth(b, mark);
    begin = end;
  }
}

/* Turns a profile (radius, height) around y, or rather around a rectangle of half extents hx, hz: a rounded slab. */
static void sc_lathe_around(
    sc_build *b, double hx, double hz, uint32_t segments, const double (*p)[3], uint32_t n, uint32_t sub) {
  sc_frame f[160];
  sc_pt round[SC_MAX_POINTS];
  bool slab = hx > 0.0 || hz > 0.0;
  uint32_t count = sc_round(p, n, sub, round), frames, i;
  segments = b->flutes ? segments : sc_segments(b, segments);
  frames = slab ? segments + 4 : segments;
  for (i = 0; i < frames && i < SC_COUNT(f); i++) {
    uint32_t quarter = i / (segments / 4 + 1);
    double angle = 360.0 * (slab ? i - quarter : i) / segments, c = sc_cos(angle), s = sc_sin(angle);
    double r = b->flutes ? 1.0 - b->flute_depth * (0.5 + 0.5 * sc_cos(angle * b->flutes)) : 1.0;
    f[i].o = slab ? sc_v(quarter % 3 ? -hx : hx, 0.0, quarter < 2 ? hz : -hz) : sc_v(0.0, 0.0, 0.0);
    f[i].x = sc_v(c * r, 0.0, s * r);
    f[i].y = sc_v(0.0, 1.0, 0.0);
  }
  sc_sweep(b, f, frames, true, round, count, false, slab ? segments / 4 + 1 : frames);
  for (i = 0; slab && i < 2; i++) { /* flat below and above */
    double y = round[i ? count - 1 : 0].y, z = i ? -hz : hz;
    if (round[i ? count - 1 : 0].x == 0.0)
      sc_quad(b, sc_v(-hx, y, -z), sc_v(hx, y, -z), sc_v(hx, y, z), sc_v(-hx, y, z));
  }
}
#define SC_LATHE(b, segments, profile, sub) sc_lathe_around(b, 0.0, 0.0, segments, profile, SC_COUNT(profile), sub)

/* A round bar along a curve through the points, thinning from radius r0 to r1; closed like a ring, or with flat
   ends. */
static void sc_tube(
    sc_build *b, const sc_v3 *p, uint32_t n, uint32_t sub, bool closed, double r0, double r1, uint32_t sides) {
  sc_frame f[SC_MAX_POINTS];
  sc_pt circle[32];
  sc_v3 c[SC_MAX_POINTS], x = sc_v(0.0, 0.0, 0.0);
  uint32_t count = 0, i, k, stretches = closed ? n : n - 1;
  for (i = 0; i < stretches; i++)
    for (k = 0; k < sub && count + 1 < SC_MAX_POINTS; k++) {
      sc_v3 u = p[i], v = p[(i + 1) % n], s = p[closed ? (i + n - 1) % n : i ? i - 1 : 0];
      sc_v3 w = p[closed ? (i + 2) % n : i + 2 < n ? i + 2 : n - 1];
      double t = (double)k / sub;
      c[count++] =
          sc_v(sc_spline(s.x, u.x, v.x, w.x, t), sc_spline(s.y, u.y, v.y, w.y, t), sc_spline(s.z, u.z, v.z, w.z, t));
    }
  if (!closed) c[count++] = p[n - 1];
  for (i = 0; i < sides && i < SC_COUNT(circle); i++) {
    circle[i].x = sc_cos(360.0 * (i + 0.5) / sides), circle[i].y = sc_sin(360.0 * (i + 0.5) / sides),
    circle[i].corner = 0;
  }
  for (i = 0; i < count; i++) {
    sc_v3 before = c[i ? i - 1 : closed ? count - 1 : 0], after = c[i + 1 < count ? i + 1 : closed ? 0 : i];
    sc_v3 along = sc_unit(sc_sub(after, before));
    double r = r0 + (r1 - r0) * i / (count > 1 ? count - 1 : 1);
    if (i == 0) x = along.y * along.y < 0.81 ? sc_v(0.0, 1.0, 0.0) : sc_v(1.0, 0.0, 0.0);
    x = sc_unit(sc_sub(x, sc_mul(along, sc_dot(x, along)))); /* carried along with the least twist */
    f[i].o = c[i], f[i].x = sc_mul(x, r), f[i].y = sc_mul(sc_cross(along, x), r);
  }
  sc_sweep(b, f, count, closed, circle, sides, true, 1);
  for (k = 0; k < 2 && !closed; k++) {
    const sc_frame *e = &f[k ? count - 1 : 0];
    sc_v3 out = sc_mul(sc_cross(e->x, e->y), k ? 1.0 : -1.0);
    uint32_t first = 0, v = 0, before = 0;
    for (i = 0; i < sides; i++, before = v) {
      v = sc_vertex(b, sc_add(e->o, sc_add(sc_mul(e->x, circle[i].x), sc_mul(e->y, circle[i].y))), out);
      if (i == 0) first = v;
      if (i >= 2) sc_triangle(b, first, k ? before : v, k ? v : before);
    }
  }
}
static void sc_rod(sc_build *b, sc_v3 from, sc_v3 to, double radius, uint32_t sides) {
  sc_v3 p[2];
  p[0] = from, p[1] = to;
  sc_tube(b, p, 2, 1, false, radius, radius, sides);
}
static void sc_torus(
    sc_build *b, double y, double radius, double thick, uint32_t around, uint32_t sides) { /* flat on y */
  sc_v3 p[96];
  uint32_t i;
  around = sc_segments(b, around);
  for (i = 0; i < around && i < SC_COUNT(p); i++)
    p[i] = sc_v(radius * sc_cos(360.0 * i / around), y, -radius * sc_sin(360.0 * i / around));
  sc_tube(b, p, around, 1, true, thick, thick, sides);
}

/* A profile (distance to the left of the path, height) along straight stretches with mitred corners. The path lies
   in the plane y = 0, its points are (x, z); seen from above, clockwise puts the profile outside. */
static void sc_moulding(
    sc_build *b, const sc_pt *path, uint32_t n, bool closed, const double (*p)[3], uint32_t points, uint32_t sub) {
  sc_pt round[SC_MAX_POINTS];
  uint32_t count = sc_round(p, points, sub, round), i, k;
  for (i = 0; i + (closed ? 0 : 1) < n; i++) {
    sc_frame f[2];
    for (k = 0; k < 2; k++) {
      uint32_t at = (i + k) % n, before = (at + n - 1) % n, after = (at + 1) % n;
      sc_v3 in = sc_unit(sc_v(path[at].x - path[before].x, 0.0, path[at].y - path[before].y));
      sc_v3 on = sc_unit(sc_v(path[after].x - path[at].x, 0.0, path[after].y - path[at].y)), side;
      if (!closed && at == 0) in = on;
      if (!closed && at == n - 1) on = in;
      side = sc_cross(sc_v(0.0, 1.0, 0.0), sc_add(in, on));
      f[k].o = sc_v(path[at].x, 0.0, path[at].y);
      f[k].x = sc_mul(side, 2.0 / sc_dot(sc_add(in, on), sc_add(in, on)));
      f[k].y = sc_v(0.0, 1.0, 0.0);
    }
    sc_sweep(b, f, 2, false, round, count, false, 1);
  }
}

/* A moulding around a rectangle that stands in the plane z = 0, seen from +z; heights of the profile become z. */
static void sc_border(
    sc_build *b, double x0, double y0, double x1, double y1, const double (*p)[3], uint32_t points, uint32_t sub) {
  sc_pt path[4] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  sc_frame keep = b->at;
  path[0].x = path[3].x = x1, path[1].x = path[2].x = x0;
  path[0].y = path[1].y = -y0, path[2].y = path[3].y = -y1;
  sc_turn_x(b, 90.0);
  sc_moulding(b, path, 4, true, p, points, sub);
  b->at = keep;
}

/* >>solids --------------------------------------------------------------------------------------------------------- */

/* A box with its edges cut by `bevel`; corner normals are those of the faces, so that the cut looks round. */
static void sc_box(sc_build *b, double x0, double y0, double z0, double x1, double y1, double z1, double bevel) {
  static const int axis_of[3][2] = {{1, 2}, {2, 0}, {0, 1}};
  double lo[3], hi[3];
  uint32_t v[3][8], a, k;
  lo[0] = x0, lo[1] = y0, lo[2] = z0, hi[0] = x1, hi[1] = y1, hi[2] = z1;
  for (a = 0; a < 3; a++)
    for (k = 0; k < 8; k++) { /* corner k (bit i: high on axis i) of the face across axis a */
      double p[3], n[3] = {0, 0, 0};
      uint32_t i;
      for (i = 0; i < 3; i++) {
        double cut = i == a ? 0.0 : bevel;
        p[i] = k >> i & 1 ? hi[i] - cut : lo[i] + cut;
      }
      n[a] = k >> a & 1 ? 1.0 : -1.0;
      v[a][k] = sc_vertex(b, sc_v(p[0], p[1], p[2]), sc_v(n[0], n[1], n[2]));
    }
  for (a = 0; a < 3; a++) {
    uint32_t u = 1u << axis_of[a][0], w = 1u << axis_of[a][1], s = 1u << a;
    uint32_t up = (uint32_t)axis_of[a][0], wp = (uint32_t)axis_of[a][1];
    sc_triangle(b, v[a][s], v[a][s | u], v[a][s | u | w]);
    sc_triangle(b, v[a][s], v[a][s | u | w], v[a][s | w]);
    sc_triangle(b, v[a][0], v[a][w], v[a][u | w]);
    sc_triangle(b, v[a][0], v[a][u | w], v[a][u]);
    for (k = 0; k < 4 && bevel > 0.0; k++) { /* the four edges along axis a, between the faces across u and across w */
      uint32_t c = (k & 1 ? u : 0) | (k & 2 ? w : 0), flip = k == 1 || k == 2;
      uint32_t p = v[up][c], q = v[wp][c], r = v[wp][c | s], t = v[up][c | s];
      sc_triangle(b, p, flip ? t : q, r);
      sc_triangle(b, p, r, flip ? q : t);
    }
  }
  for (k = 0; k < 8 && bevel > 0.0; k++) {
    bool odd = (k ^ k >> 1 ^ k >> 2) & 1;
    sc_triangle(b, v[0][k], v[odd ? 1 : 2][k], v[odd ? 2 : 1][k]);
  }
}

/* Closes the end of a sweep: a fan over a star-shaped profile around (cx, cy), facing along x cross y of the frame
   or back. */
static void sc_cap(sc_build *b, const sc_frame *f, const sc_pt *p, uint32_t n, double cx, double cy, bool back) {
  sc_mark mark = sc_begin(b);
  uint32_t centre = sc_vertex(b, sc_add(f->o, sc_add(sc_mul(f->x, cx), sc_mul(f->y, cy))), f->y), v = 0, before = 0, i;
  for (i = 0; i < n; i++, before = v) {
    v = sc_vertex(b, sc_add(f->o, sc_add(sc_mul(f->x, p[i].x), sc_mul(f->y, p[i].y))), f->y);
    if (i) sc_triangle(b, centre, back ? v : before, back ? before : v);
  }
  sc_smooth(b, mark);
}

/* Straight bar of a star-shaped cross-section (out, up) from x0 to x1, along -x so that "out" is +z; ends are
   sheared by k0, k1 metres of x per metre outwards. */
static void sc_prism(sc_build *b, const double (*p)[3], uint32_t n, uint32_t sub, double x0, double k0, double x1,
    double k1, double cx, double cy) {
  sc_pt round[SC_MAX_POINTS];
  sc_frame f[2];
  uint32_t count = sc_round(p, n, sub, round);
  f[0].o = sc_v(x1, 0.0, 0.0), f[0].x = sc_v(k1, 0.0, 1.0), f[1].o = sc_v(x0, 0.0, 0.0), f[1].x = sc_v(k0, 0.0, 1.0);
  f[0].y = f[1].y = sc_v(0.0, 1.0, 0.0);
  sc_sweep(b, f, 2, false, round, count, false, 1);
  sc_cap(b, &f[0], round, count, cx, cy, true);
  sc_cap(b, &f[1], round, count, cx, cy, false);
}

/* The part of a sphere around the origin between two angles from its top, exact normals. */
static void sc_sphere_band(sc_build *b, double radius, double from, double to, uint32_t rows, uint32_t segments) {
  uint32_t i, j, before = 0, row = 0;
  for (j = 0; j <= rows; j++, before = row) {
    double angle = from + (to - from) * j / rows, s = sc_sin(angle), c = sc_cos(angle);
    uint32_t pole = s * s < 1e-12;
    row = sc_begin(b).vertex;
    for (i = 0; i < (pole ? 1 : segments); i++) {
      sc_v3 n = sc_v(s * sc_cos(360.0 * i / segments), c, s * sc_sin(360.0 * i / segments));
      sc_vertex(b, sc_mul(n, radius), n);
    }
    for (i = 0; i < segments && j; i++) {
      uint32_t k = (i + 1) % segments, up = j == 1 && from == 0.0, down = pole;
      sc_triangle(b, before + (up ? 0 : i), before + (up ? 0 : k), row + (down ? 0 : k));
      sc_triangle(b, before + (up ? 0 : i), row + (down ? 0 : k), row + (down ? 0 : i));
    }
  }
}

/* A surface z(x, y) over a rectangle, seen from +z. */
typedef double (*sc_height)(double x, double y, const void *context);
static void sc_heights(sc_build *b, double x0, double y0, double x1, double y1, uint32_t nx, uint32_t ny, sc_height z,
    const void *context) {
  sc_mark mark = sc_begin(b);
  uint32_t i, j;
  for (j = 0; j <= ny; j++)
    for (i = 0; i <= nx; i++) {
      double x = x0 + (x1 - x0) * i / nx, y = y0 + (y1 - y0) * j / ny;
      sc_vertex(b, sc_v(x, y, z(x, y, context)), sc_v(0.0, 0.0, 1.0));
    }
  for (j = 0; j < ny; j++)
    for (i = 0; i < nx; i++) {
      uint32_t v = mark.vertex + j * (nx + 1) + i;
      sc_triangle(b, v, v + 1, v + nx + 2);
      sc_triangle(b, v, v + nx + 2, v + nx + 1);
    }
  sc_smooth(b, mark);
}

/* Puts the origin at `from` and lets y point to `to`. */
static sc_frame sc_aim(sc_build *b, sc_v3 from, sc_v3 to) {
  sc_frame keep = sc_place(b, from.x, from.y, from.z, 0.0), t = b->at;
  sc_v3 y = sc_unit(sc_sub(to, from)), x = y.x * y.x < 0.5 ? sc_v(1.0, 0.0, 0.0) : sc_v(0.0, 0.0, 1.0), z;
  x = sc_unit(sc_sub(x, sc_mul(y, sc_dot(x, y))));
  z = sc_cross(x, y);
  b->at.x = sc_add(sc_mul(t.x, x.x), sc_add(sc_mul(t.y, x.y), sc_mul(t.z, x.z)));
  b->at.y = sc_add(sc_mul(t.x, y.x), sc_add(sc_mul(t.y, y.y), sc_mul(t.z, y.z)));
  b->at.z = sc_add(sc_mul(t.x, z.x), sc_add(sc_mul(t.y, z.y), sc_mul(t.z, z.z)));
  return keep;
}

/* >>textures ------------------------------------------------------------------------------------------------------- */

/* Random numbers in [0,1] for the points of a unit lattice. */
static const uint32_t sc_primes[3] = {0x9e3779b1u, 0x85ebca77u, 0xc2b2ae3du};

static inline double sc_number(uint32_t h) {
  h = (h ^ h >> 15) * 0x2c1b3c6du;
  h = (h ^ h >> 12) * 0x297a2d39u;
  return (double)(h ^ h >> 15) / 4294967296.0;
}

/* One for the whole cell that holds a point. */
static double sc_cell(double x, double y, double z) {
  return sc_number((uint32_t)sc_floor(x) * sc_primes[0] ^ (uint32_t)sc_floor(y) * sc_primes[1] ^
                   (uint32_t)sc_floor(z) * sc_primes[2]);
}

static inline double sc_between(double a, double b, double t) { return a + t * (b - a); }

/* A cell of the lattice, and the numbers at its corners; z counts first. */
typedef struct sc_corners {
  int32_t cell[3];
  double number[8];
} sc_corners;
static const sc_corners sc_nowhere = {{INT32_MIN, INT32_MIN, INT32_MIN}, {0, 0, 0, 0, 0, 0, 0, 0}};

/* Written out, as what follows is, for compilers leave loops of two as they are. */
static inline void sc_enter(sc_corners *c, const int32_t cell[3]) {
  uint32_t at[3][2], i;
  for (i = 0; i < 3; i++) {
    c->cell[i] = cell[i];
    at[i][0] = (uint32_t)cell[i] * sc_primes[i], at[i][1] = at[i][0] + sc_primes[i];
  }
  c->number[0] = sc_number(at[0][0] ^ at[1][0] ^ at[2][0]), c->number[1] = sc_number(at[0][0] ^ at[1][0] ^ at[2][1]);
  c->number[2] = sc_number(at[0][0] ^ at[1][1] ^ at[2][0]), c->number[3] = sc_number(at[0][0] ^ at[1][1] ^ at[2][1]);
  c->number[4] = sc_number(at[0][1] ^ at[1][0] ^ at[2][0]), c->number[5] = sc_number(at[0][1] ^ at[1][0] ^ at[2][1]);
  c->number[6] = sc_number(at[0][1] ^ at[1][1] ^ at[2][0]), c->number[7] = sc_number(at[0][1] ^ at[1][1] ^ at[2][1]);
}

/* The cell that x lies in, and how far it is there from its begin to its end, smoothed. */
static inline double sc_part(double x, int32_t *cell) {
  *cell = sc_floor(x);
  x -= *cell;
  return x * x * (3.0 - 2.0 * x);
}

/* Value noise: smooth between the points. Neighbouring points mostly lie in one cell of a coarse noise: its corners are
   kept from call to call. */
static inline double sc_noise_near(sc_corners *c, double x, double y, double z) {
  const double *n = c->number;
  int32_t cell[3];
  double fx = sc_part(x, &cell[0]), fy = sc_part(y, &cell[1]), fz = sc_part(z, &cell[2]);
  if ((cell[0] ^ c->cell[0]) | (cell[1] ^ c->cell[1]) | (cell[2] ^ c->cell[2])) sc_enter(c, cell);
  x = sc_between(sc_between(n[0], n[1], fz), sc_between(n[2], n[3], fz), fy);
  y = sc_between(sc_between(n[4], n[5], fz), sc_between(n[6], n[7], fz), fy);
  return sc_between(x, y, fx);
}
static double sc_noise(double x, double y, double z) {
  sc_corners c = sc_nowhere;
  return sc_noise_near(&c, x, y, z);
}

/* Brightness of wood relative to its mean: year rings, seen as lines that wander along the grain and end in a dark
   edge, and fibres. Metres along the grain and across it, both ways. `contrast`: 1 for 0.7 to 1.2. */
static double sc_wood(
    sc_corners near[2], double along, double across, double deep, double rings_per_metre, double contrast) {
  double wander = sc_noise_near(&near[0], along * 0.9, across * 4.0, deep * 4.0), ring, fibre;
  wander += 0.3 * sc_noise_near(&near[1], along * 3.0, across * 11.0, deep * 11.0);
  ring = across * rings_per_metre + 6.0 * wander;
  ring -= sc_floor(ring);
  ring = ring < 0.8 ? ring * 1.25 : (1.0 - ring) * 5.0;
  fibre = sc_noise(along * 7.0, across * 170.0, deep * 170.0);
  return 1.0 + contrast * (0.16 - 0.30 * ring * ring * ring - 0.14 * fibre);
}

/* Scales a colour of point i. The grid hides by what rounding compilers may differ, as that of sc_snap does. */
static void sc_tint(float *const colour[3], uint32_t i, double factor) {
  uint32_t c;
  for (c = 0; c < 3; c++) {
    double v = (double)colour[c][i] * factor * 65536.0 + 0.5137;
    v = v > 0.0 ? v : 0.0, v = v < 65536.0 ? v : 65536.0;
    colour[c][i] = (float)(int32_t)v / 65536.0f;
  }
}

/* >>scenes --------------------------------------------------------------------------------------------------------- */

/* Each offers an enumeration of its kinds and, with its name in front: _kinds[] (one for each), _make (everything, at
   rest), _camera (a closed path over time [0,1]) and, if a mesh deforms, _deform (its pose, likewise a loop). */
#define SC_MAX_LIGHTS 1000
#include "scene_conference.h"
#include "scene_lamps.h"
#include "scene_poolhall.h"
#include "scene_rtrt.h"
#include "scene_sky.h"

/* >>interface ------------------------------------------------------------------------------------------------------ */

typedef struct sc_recipe {
  const char *name;
  const sc_kind *kinds;
  uint32_t kind_count;
  void (*make)(sc_build *);
  void (*camera)(double, pktrt_camera *);
  void (*deform)(const scene *, const scene_mesh *, double, float *, float *);
} sc_recipe;

#define SC_RECIPE(name) \
  { #name, name##_kinds, SC_COUNT(name##_kinds), name##_make, name##_camera, name##_deform }
static const sc_recipe sc_recipes[] = {
    SC_RECIPE(poolhall),
    SC_RECIPE(conference),
    SC_RECIPE(rtrt),
    {"lamps", lamps_kinds, LAMPS_KINDS, lamps_make, lamps_camera, NULL},
    {"lamps-few", lamps_kinds, LAMPS_KINDS, lamps_make_few, lamps_camera, NULL},
    {"sky", sky_kinds, SKY_KINDS, sky_make, sky_camera, NULL},
};

SCENE_DEF const char *const *scene_names(void) { /* in the order of sc_recipes */
  static const char *const names[] = {"poolhall", "conference", "rtrt", "lamps", "lamps-few", "sky", NULL};
  return names;
}

SCENE_DEF void scene_free(scene *s) {
  size_t i;
  for (i = 0; s->meshes && i < s->mesh_count; i++) {
    free(s->meshes[i].positions);
    free(s->meshes[i].normals);
    free(s->meshes[i].indices);
  }
  free(s->meshes);
  free(s->materials);
  free(s->lights);
  memset(s, 0, sizeof *s);
}

/* Drops meshes that got no triangle, and the normals of flat ones. Lights name a kind until here, then a mesh. */
static void sc_finish(scene *s, const sc_kind *kinds) {
  size_t i, k, kept = 0;
  for (i = 0; i < s->mesh_count; i++) {
    scene_mesh m = s->meshes[i];
    for (k = 0; k < s->light_count && m.triangle_count; k++)
      if (s->lights[k].kind == PKTRT_LIGHT_MESH && s->lights[k].mesh == i) s->lights[k].mesh = (uint32_t)kept;
    if (kinds[i].flat || m.triangle_count == 0) {
      free(m.normals);
      m.normals = NULL;
    }
    if (m.triangle_count) s->meshes[kept++] = m;
    else free(m.positions), free(m.indices);
  }
  s->mesh_count = kept;
}

SCENE_DEF bool scene_make(const char *name, scene *out) {
  const sc_recipe *recipe = NULL;
  sc_build b;
  size_t i;
  memset(out, 0, sizeof *out);
  for (i = 0; i < SC_COUNT(sc_recipes); i++)
    if (!strcmp(name, sc_recipes[i].name)) recipe = &sc_recipes[i];
  if (!recipe) return false;
  memset(&b, 0, sizeof b);
  b.out = out;
  b.detail = 1.0;
  b.at.x.x = b.at.y.y = b.at.z.z = 1.0;
  b.vertex_space = (uint32_t *)calloc(recipe->kind_count, sizeof(uint32_t));
  b.triangle_space = (uint32_t *)calloc(recipe->kind_count, sizeof(uint32_t));
  out->name = recipe->name;
  out->deform = recipe->deform;
  out->camera_path = recipe->camera;
  out->meshes = (scene_mesh *)calloc(recipe->kind_count, sizeof(scene_mesh));
  out->materials = (scene_material *)calloc(recipe->kind_count, sizeof(scene_material));
  out->lights = (pktrt_light *)calloc(SC_MAX_LIGHTS, sizeof(pktrt_light));
  b.failed = !b.vertex_space || !b.triangle_space || !out->meshes || !out->materials || !out->lights;
  if (!b.failed) {
    out->mesh_count = out->material_count = recipe->kind_count;
    for (i = 0; i < recipe->kind_count; i++) {
      out->meshes[i].name = out->materials[i].name = recipe->kinds[i].name;
      out->meshes[i].material = (uint32_t)i;
      out->meshes[i].key_count = 1;
      memcpy(out->materials[i].m.albedo, recipe->kinds[i].albedo, sizeof recipe->kinds[i].albedo);
    }
    sc_use(&b, 0);
    recipe->make(&b);
    recipe->camera(0.0, &out->camera);
  }
  free(b.vertex_space);
  free(b.triangle_space);
  if (b.failed) scene_free(out);
  else sc_finish(out, recipe->kinds);
  return !b.failed;
}

SCENE_DEF uint64_t scene_triangles(const scene *s) {
  uint64_t sum = 0;
  size_t i;
  for (i = 0; i < s->mesh_count; i++) sum += s->meshes[i].triangle_count;
  return sum;
}

/* The vertices of a lamp, spread by a factor from the middle of their box. */
SCENE_DEF void sc_resize_mesh(scene_mesh *m, double factor) {
  const size_t vertices = (size_t)m->vertex_count * m->key_count;
  for (size_t a = 0; a < 3; a++) {
    float lo = INFINITY, hi = -INFINITY;
    for (size_t i = 0; i < vertices; i++) {
      lo = fminf(lo, m->positions[3 * i + a]);
      hi = fmaxf(hi, m->positions[3 * i + a]);
    }
    const double middle = 0.5 * ((double)lo + (double)hi);
    for (size_t i = 0; i < vertices; i++) {
      float *p = &m->positions[3 * i + a];
      *p = (float)(middle + factor * ((double)*p - middle));
    }
  }
}

SCENE_DEF void scene_resize_lights(scene *s, double factor) {
  for (size_t i = 0; i < s->light_count; i++) {
    pktrt_light *l = &s->lights[i];
    float *radiance = l->intensity;
    switch (l->kind) {
    case PKTRT_LIGHT_QUAD:
      for (int a = 0; a < 3; a++) {
        const double across = (double)l->edge[0][a] + (double)l->edge[1][a];
        l->position[a] = (float)((double)l->position[a] + 0.5 * (1 - factor) * across);
        for (int e = 0; e < 2; e++) l->edge[e][a] = (float)(factor * (double)l->edge[e][a]);
      }
      break;
    case PKTRT_LIGHT_SPHERE: l->radius = (float)(factor * (double)l->radius); break;
    case PKTRT_LIGHT_MESH:
      if (s->meshes[l->mesh].deforms) continue; /* its poses come from elsewhere */
      sc_resize_mesh(&s->meshes[l->mesh], factor);
      radiance = s->materials[s->meshes[l->mesh].material].m.emission;
      break;
    default: continue;
    }
    for (int c = 0; c < 3; c++) radiance[c] = (float)((double)radiance[c] / (factor * factor));
  }
}

/* Room for `keys` poses of a mesh, positions then normals of each; NULL where memory is lacking. Made with
   calloc, which looks after the product. */
static float *sc_poses(const scene *s, const scene_mesh *m, double time, double shutter, uint32_t keys) {
  size_t n = 3 * (size_t)m->vertex_count;
  float *room = (float *)calloc(n, 2 * keys * sizeof(float));
  uint32_t k;
  for (k = 0; k < keys && room; k++) {
    double at = time + (k ? shutter : 0.0);
    s->deform(s, m, at - floor(at), room + n * k, room + n * (keys + k));
  }
  return room;
}

/* What the library is told of a mesh; *room receives its poses, to be freed, if it deforms. */
static pktrt_status sc_describe(const scene *s, const scene_mesh *m, uint32_t material, double time, double shutter,
    pktrt_mesh_desc *d, float **room) {
  memset(d, 0, sizeof *d);
  d->positions = m->positions;
  d->normals = m->normals;
  d->indices = m->indices;
  d->vertex_count = m->vertex_count;
  d->triangle_count = m->triangle_count;
  d->key_count = m->key_count;
  d->material = material;
  *room = NULL;
  if (m->deforms) {
    d->key_count = shutter > 0.0 ? 2 : 1;
    *room = sc_poses(s, m, time, shutter, d->key_count);
    if (!*room) return PKTRT_OUT_OF_MEMORY;
    d->positions = *room;
    if (m->normals) d->normals = *room + 3 * (size_t)m->vertex_count * d->key_count;
  }
  return PKTRT_OK;
}

/* Adds the materials; their indices, to be freed, or NULL where memory is lacking. */
static uint32_t *sc_add_materials(pktrt_scene *to, const scene *s, pktrt_status *status) {
  uint32_t *material = (uint32_t *)malloc((s->material_count + 1) * sizeof(uint32_t));
  size_t i;
  *status = material ? PKTRT_OK : PKTRT_OUT_OF_MEMORY;
  for (i = 0; *status == PKTRT_OK && i < s->material_count; i++)
    *status = pktrt_add_material(to, &s->materials[i].m, &material[i]);
  return material;
}

SCENE_DEF pktrt_status scene_add_at(pktrt_scene *to, const scene *s, double time, double shutter) {
  pktrt_status status;
  uint32_t *material = sc_add_materials(to, s, &status);
  size_t i;
  for (i = 0; status == PKTRT_OK && i < s->mesh_count; i++) {
    const scene_mesh *m = &s->meshes[i];
    pktrt_mesh_desc d;
    float *room;
    status = sc_describe(s, m, material[m->material], time, shutter, &d, &room);
    if (status == PKTRT_OK) status = pktrt_add_mesh(to, &d, NULL);
    free(room);
  }
  for (i = 0; status == PKTRT_OK && i < s->light_count; i++) status = pktrt_add_light(to, &s->lights[i], NULL);
  free(material);
  return status;
}

SCENE_DEF pktrt_status scene_add_model(pktrt_scene *to, const scene *s, double time, double shutter, uint32_t *model) {
  pktrt_status status;
  uint32_t *material = sc_add_materials(to, s, &status);
  pktrt_mesh_desc *d = (pktrt_mesh_desc *)calloc(s->mesh_count + 1, sizeof *d);
  float **rooms = (float **)calloc(s->mesh_count + 1, sizeof *rooms);
  size_t i;
  if (!d || !rooms) status = PKTRT_OUT_OF_MEMORY;
  for (i = 0; status == PKTRT_OK && i < s->mesh_count; i++)
    status = sc_describe(s, &s->meshes[i], material[s->meshes[i].material], time, shutter, &d[i], &rooms[i]);
  if (status == PKTRT_OK) status = pktrt_add_model(to, d, (uint32_t)s->mesh_count, model);
  for (i = 0; rooms && i < s->mesh_count; i++) free(rooms[i]);
  free(rooms);
  free(d);
  free(material);
  return status;
}

SCENE_DEF pktrt_status scene_add(pktrt_scene *to, const scene *s) { return scene_add_at(to, s, 0.0, 0.0); }

SCENE_DEF pktrt_status scene_pose(pktrt_scene *to, const scene *s, double time, double shutter) {
  uint32_t keys = shutter > 0.0 ? 2 : 1, k;
  pktrt_status status = PKTRT_OK;
  size_t i;
  for (i = 0; status == PKTRT_OK && i < s->mesh_count; i++) {
    const scene_mesh *m = &s->meshes[i];
    size_t n = 3 * (size_t)m->vertex_count;
    float *room = m->deforms ? sc_poses(s, m, time, shutter, keys) : NULL;
    if (m->deforms && !room) return PKTRT_OUT_OF_MEMORY;
    for (k = 0; status == PKTRT_OK && k < keys && room; k++) {
      status = pktrt_set_positions(to, (uint32_t)i, k, room + n * k);
      if (status == PKTRT_OK && m->normals) status = pktrt_set_normals(to, (uint32_t)i, k, room + n * (keys + k));
    }
    free(room);
  }
  return status;
}

SCENE_DEF void scene_camera(const scene *s, double time, pktrt_camera *camera) {
  s->camera_path(time - floor(time), camera);
}

#endif /* SCENES_H */
