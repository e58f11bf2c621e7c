/* Geometry for tests: a mesh with motion keys, a world of several meshes, and generators of both. */
#ifndef PKTRT_TEST_MESHES_H
#define PKTRT_TEST_MESHES_H
#include "test.h"

typedef struct mesh {
  float *p;    /* keys * nv * 3 */
  uint32_t *i; /* nt * 3 */
  uint32_t nv, nt, keys;
} mesh;

enum { WORLD_MESHES = 8 };
typedef struct world {
  mesh m[WORLD_MESHES];
  uint32_t n;
  struct ref_tree *tree; /* of ref_plant(); NULL: references look at every triangle */
} world;

mesh mesh_of(uint32_t nv, uint32_t nt); /* zeroed, one key */
void mesh_free(mesh *);
mesh mesh_sphere(int level, float bump, uint64_t seed); /* closed, 8 * 4^level triangles, radius 1 (+- bump) */
mesh mesh_grid(uint32_t n, float half);                 /* y = 0, `2 n n` triangles facing +y */
mesh mesh_box(void);                                    /* [-1,1]^3, 12 triangles facing out */
mesh mesh_soup(uint32_t nt, float size, uint64_t seed); /* random triangles, centres in [-1,1]^3 */
mesh mesh_thin(uint32_t nt, uint64_t seed);             /* needles and slivers */
mesh mesh_copies(const mesh *, uint32_t copies);        /* the same triangles several times: ties */
void mesh_place(mesh *, const float scale[3], const float offset[3]); /* all keys */
void mesh_move(
    mesh *, uint32_t keys, float turn, float jitter, uint64_t seed); /* adds keys: turned about y, jittered */
mesh mesh_fan(uint32_t blades, uint64_t seed);                       /* around a hub, vertex 0, nearly facing z */

static inline void mesh_scale(mesh *m, float s) { mesh_place(m, (float[3]){s, s, s}, (float[3]){0, 0, 0}); }
static inline void mesh_shift(mesh *m, float x, float y, float z) {
  mesh_place(m, (float[3]){1, 1, 1}, (float[3]){x, y, z});
}
pktrt_mesh_desc mesh_desc(const mesh *);
pktrt_status mesh_add(pktrt_scene *, const mesh *, uint32_t *index);

world world_none(void);
world world_of(mesh); /* of one mesh, which it takes */
void world_free(world *);
void world_place(world *, float scale, float x, float y, float z);
pktrt_scene *world_scene(const world *, pktrt_isa, int workers); /* committed, checked */
world world_static(int level); /* bumpy sphere, floor, box, soup: 8 * 4^level triangles and 3000 more */
world world_moving(int level); /* the same with 2, 1, 5, 3 keys */

/* --- rays --- */
typedef enum ray_kind {
  RAYS_CAMERA,
  RAYS_BUNDLES,
  RAYS_RANDOM,
  RAYS_EDGE,
  RAYS_VERTEX,
  RAYS_AXIS,
  RAYS_SPAWNED,
  RAYS_INVALID,
  RAYS_KINDS
} ray_kind;
extern const char *ray_kind_name[RAYS_KINDS];
/* Rays number first .. first + n - 1 of a kind. The scene is for RAYS_SPAWNED: they start on its surface. */
void make_rays(const world *, const pktrt_scene *, ray_kind, uint64_t seed, size_t first, pktrt_ray *, size_t n);
/* The ray, or another one, with something that makes it invalid. */
pktrt_ray invalid_ray(rng *, pktrt_ray);
/* A ray from a point to a point: direction = target - origin, in float. */
pktrt_ray ray_towards(const float origin[3], const float target[3], float time);
/* A target on the world's surface at a time: a random vertex, or a random point of a random edge. */
void pick_vertex(const world *, rng *, float time, float out[3]);
void pick_edge(const world *, rng *, float time, float out[3]);
void random_point(const world *, rng *, float spread, float out[3]); /* around the world's bounds */

/* --- the truth (reference.c) --- */
/* Gives the world a tree, so that the functions below need not look at every triangle; to be called again when vertices have
   changed. It drops what a ray passes at more than rounding could ever move, so answers stay what they are. */
void ref_plant(world *);
/* Vertex at a time by the canonical formula. */
void ref_vertex(const mesh *, uint32_t vertex, float time, float out[3]);
bool ref_valid(const pktrt_ray *);
/* The nearest hit by exact arithmetic, over all triangles: what the library must answer, bit for bit. */
bool ref_intersect(const world *, const pktrt_ray *, pktrt_hit *);
/* Plain float tests, for controls: Moeller and Trumbore 1997; Kensler and Shirley 2006. */
bool ref_moller_trumbore(const world *, const pktrt_ray *, pktrt_hit *);
bool ref_kensler_shirley(const world *, const pktrt_ray *, pktrt_hit *);
/* Of one triangle: t, u, v, written even where it is refused for u or v, and whether it is taken. */
bool plain_moller_trumbore(const pktrt_ray *, float corner[3][3], float *t, float *u, float *v);
bool plain_kensler_shirley(const pktrt_ray *, float corner[3][3], float *t, float *u, float *v);

#endif
