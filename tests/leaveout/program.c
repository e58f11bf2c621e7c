/* For tests/leaveout.sh, which compiles it once with each switch: tries all that a scene can have. Prints a line for each
   case: the switch that leaves it out (-: none does), the case's name, and what became of it, separated by tabs:
   checksums of hits and of pictures, the sentence that refused it, or "left out". */
#define PKTRT_IMPLEMENTATION
#include "../../pktrt.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { EDGE = 12, GROUND_VERTICES = (EDGE + 1) * (EDGE + 1), GROUND = 2 * EDGE * EDGE, RAYS = 600 };
enum { OBJECT_VERTICES = 6, OBJECT = 8, WIDTH = 30, HEIGHT = 22 };

static float ground_xyz[GROUND_VERTICES][3], object_xyz[2][OBJECT_VERTICES][3], normals[2][OBJECT_VERTICES][3];
static const float texcoords[OBJECT_VERTICES][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {0.5f, 0.25f}, {0.25f, 0.5f}};
static uint32_t ground_index[GROUND][3];
static const uint32_t object_index[OBJECT][3] = {
    {4, 0, 2}, {4, 2, 1}, {4, 1, 3}, {4, 3, 0}, {5, 2, 0}, {5, 1, 2}, {5, 3, 1}, {5, 0, 3}};

typedef struct request { /* what a case asks for */
  pktrt_mesh_desc object;
  uint32_t mask;        /* of the instance */
  bool placed;          /* as an instance */
  bool hidden, removed; /* the ground, when all is committed */
#ifndef PKTRT_NO_RENDER
  pktrt_material look;
  pktrt_light light;
  pktrt_render_desc view;
#endif
} request;

#ifndef PKTRT_NO_RENDER
static float pixels[WIDTH * HEIGHT * 3];
static pktrt_stats stats;
#endif

/* --- geometry and checksums: the same bits everywhere --- */

static uint32_t random_bits(uint32_t *state) {
  uint32_t x = *state += 0x9E3779B9u;
  x = (x ^ (x >> 16)) * 0x85EBCA6Bu;
  x = (x ^ (x >> 13)) * 0xC2B2AE35u;
  return x ^ (x >> 16);
}
static float random_sign(uint32_t *state) { return (float)(random_bits(state) >> 8) * (2.0f / 16777216) - 1; }

static void add_to(uint64_t *sum, const void *data, size_t bytes) { /* FNV-1a */
  const unsigned char *p = (const unsigned char *)data;
  for (size_t i = 0; i < bytes; i++) *sum = (*sum ^ p[i]) * 1099511628211u;
}

static void make_ground(void) {
  uint32_t state = 1, n = 0;
  for (uint32_t i = 0; i < GROUND_VERTICES; i++) {
    ground_xyz[i][0] = (float)(i % (EDGE + 1)) - EDGE / 2;
    ground_xyz[i][1] = 0.25f * random_sign(&state) - 1;
    ground_xyz[i][2] = (float)(i / (EDGE + 1)) - EDGE / 2;
  }
  for (uint32_t i = 0; i < EDGE * EDGE; i++) {
    const uint32_t a = i / EDGE * (EDGE + 1) + i % EDGE, b = a + EDGE + 1;
    const uint32_t both[2][3] = {{a, b, b + 1}, {a, b + 1, a + 1}};
    memcpy(ground_index[n], both, sizeof both), n += 2;
  }
}

static void make_object(void) { /* an octahedron, which moves to the right in its second key */
  for (uint32_t key = 0; key < 2; key++)
    for (uint32_t i = 0; i < OBJECT_VERTICES; i++) {
      const uint32_t axis = i / 2 == 0 ? 0 : i / 2 == 1 ? 2 : 1; /* the top is vertex 4 */
      normals[key][i][axis] = i % 2 ? -1.0f : 1.0f;
      object_xyz[key][i][axis] = i % 2 ? -1.0f : 1.0f;
      object_xyz[key][i][0] += 0.75f * (float)key;
    }
}

/* --- what is asked of a scene --- */

static pktrt_ray ray_of(uint32_t *state) { /* from a sphere of radius 6 or so to the middle */
  pktrt_ray r;
  memset(&r, 0, sizeof r);
  for (int a = 0; a < 3; a++) r.origin[a] = a == 1 ? 4 : 4 * random_sign(state);
  for (int a = 0; a < 3; a++) r.direction[a] = 1.5f * random_sign(state) - r.origin[a];
  r.tmax = 100, r.time = 0.5f + 0.5f * random_sign(state);
  return r;
}

/* All ways to ask, which must agree. */
static uint64_t checksum_of_hits(const pktrt_scene *s) {
  static pktrt_ray rays[RAYS];
  static pktrt_hit hits[RAYS], same[RAYS];
  static bool occluded[RAYS];
  uint32_t state = 7;
  uint64_t sum = 14695981039346656037u;
  for (int i = 0; i < RAYS; i++) rays[i] = ray_of(&state), pktrt_intersect(s, &rays[i], &hits[i]);
  for (int path = PKTRT_PATH_FAST; path <= PKTRT_PATH_SINGLE; path++) {
    pktrt_query_desc q;
    memset(&q, 0, sizeof q);
    q.path = (pktrt_path)path;
    pktrt_intersect_ex(s, &q, rays, same, RAYS);
    if (memcmp(hits, same, sizeof hits) != 0) sum++;
    pktrt_occluded_ex(s, &q, rays, occluded, RAYS);
    for (int i = 0; i < RAYS; i++)
      if (occluded[i] != (hits[i].mesh != PKTRT_NONE) || occluded[i] != pktrt_occluded(s, &rays[i])) sum++;
  }
  add_to(&sum, hits, sizeof hits);
  return sum;
}

#ifndef PKTRT_NO_RENDER
static pktrt_status render_all_modes(pktrt_scene *s, pktrt_render_desc *view, uint64_t *sum) {
  pktrt_status status = PKTRT_OK;
  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT && status == PKTRT_OK; mode++) {
    view->mode = (pktrt_mode)mode;
    status = pktrt_render(s, view);
    add_to(sum, pixels, sizeof pixels);
  }
  return status;
}

static void add_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) radiance[a][i] = 0.5f + 0.25f * direction[a][i];
}

static void default_looks(request *r) {
  for (int a = 0; a < 3; a++) {
    r->look.albedo[a] = 0.5f, r->light.intensity[a] = 40;
    r->view.background[a] = 0.25f, r->view.ambient[a] = 0.125f;
  }
  r->light.position[0] = 2, r->light.position[1] = 3, r->light.position[2] = 2;
  r->view.width = WIDTH, r->view.height = HEIGHT, r->view.pixels = pixels, r->view.samples = 2;
  r->view.camera.eye[0] = 1, r->view.camera.eye[1] = 1.5f, r->view.camera.eye[2] = 4;
}
#endif

static void defaults(request *r) {
  memset(r, 0, sizeof *r);
  r->object.positions = &object_xyz[0][0][0], r->object.vertex_count = OBJECT_VERTICES;
  r->object.indices = &object_index[0][0], r->object.triangle_count = OBJECT;
#ifndef PKTRT_NO_RENDER
  default_looks(r);
#endif
}

#ifndef PKTRT_NO_RENDER
static pktrt_status add_looks(pktrt_scene *s, const request *r) {
  pktrt_light second;
  memset(&second, 0, sizeof second);
  second.position[0] = -4, second.position[1] = 2, second.position[2] = 1;
  second.intensity[2] = 30;
  pktrt_status status = pktrt_add_material(s, &r->look, NULL);
  if (status == PKTRT_OK) status = pktrt_add_light(s, &r->light, NULL);
  return status == PKTRT_OK ? pktrt_add_light(s, &second, NULL) : status;
}
#endif

static pktrt_status fill(pktrt_scene *s, const request *r) {
  pktrt_mesh_desc ground;
  memset(&ground, 0, sizeof ground);
  ground.positions = &ground_xyz[0][0], ground.vertex_count = GROUND_VERTICES;
  ground.indices = &ground_index[0][0], ground.triangle_count = GROUND;
  pktrt_status status = PKTRT_OK;
#ifndef PKTRT_NO_RENDER
  status = add_looks(s, r);
#endif
  if (status == PKTRT_OK) status = pktrt_add_mesh(s, &ground, NULL);
#ifndef PKTRT_NO_INSTANCES
  static const float aside[12] = {0.75f, 0.25f, 0, 0.5f, 0, 1, 0, 0, 0, 0, -1, 0.25f};
  const pktrt_instance_desc place = {0, 1, aside, r->mask, PKTRT_INTERPOLATION_LINEAR};
  if (status == PKTRT_OK && r->placed) status = pktrt_add_model(s, &r->object, 1, NULL);
  if (status == PKTRT_OK && r->placed) status = pktrt_add_instance(s, &place, NULL);
#endif
  if (status == PKTRT_OK && !r->placed) status = pktrt_add_mesh(s, &r->object, NULL);
  if (status == PKTRT_OK) status = pktrt_commit(s);
#ifndef PKTRT_NO_REMOVAL
  if (status == PKTRT_OK && r->hidden) status = pktrt_set_enabled(s, 0, false);
  if (status == PKTRT_OK && r->removed) status = pktrt_remove_mesh(s, 0);
  if (status == PKTRT_OK && (r->hidden || r->removed)) status = pktrt_commit(s);
#endif
  return status;
}

static pktrt_scene *make_scene(pktrt_isa isa) {
  pktrt_scene_desc d;
  memset(&d, 0, sizeof d);
  d.isa = isa;
  return pktrt_scene_create(&d);
}

/* The case with the ground and the object in it: hits, pictures in all modes. */
static void try_case(const char *left_out_by, const char *name, void (*change)(request *)) {
  uint64_t hits = 0, picture = 14695981039346656037u;
  request r;
  defaults(&r);
  if (change) change(&r);
  pktrt_scene *s = make_scene(PKTRT_ISA_AUTO);
  pktrt_status status = s ? fill(s, &r) : PKTRT_OUT_OF_MEMORY;
  if (status == PKTRT_OK) hits = checksum_of_hits(s);
#ifndef PKTRT_NO_RENDER
  if (status == PKTRT_OK) status = render_all_modes(s, &r.view, &picture);
#endif
  printf("%s\t%s\t", left_out_by, name);
  if (status != PKTRT_OK) printf("refused: %s\n", pktrt_last_error(s));
  else printf("%016llx %016llx\n", (unsigned long long)hits, (unsigned long long)picture);
  pktrt_scene_destroy(s);
}

/* --- the cases --- */

#ifndef PKTRT_NO_INSTANCES
static void placed(request *r) { r->placed = true; }
static void placed_with_mask(request *r) { placed(r), r->mask = 4; }
#endif
#ifndef PKTRT_NO_REMOVAL
static void hidden(request *r) { r->hidden = true; }
static void removed(request *r) { r->removed = true; }
#endif
static void grouped(request *r) { r->object.group = 1; }
static void masked(request *r) { r->object.mask = 2; }
static void with_texcoords(request *r) { r->object.texcoords = &texcoords[0][0]; }
static void with_materials(request *r) {
  static const uint32_t material[OBJECT] = {0, 1, 1, 0, 0, 0, 1, 1};
  r->object.triangle_materials = material;
}
static void moving_mesh(request *r) {
  r->object.key_count = 2;
#ifndef PKTRT_NO_RENDER
  r->view.camera.time = 0.5f;
#endif
}

#ifndef PKTRT_NO_RENDER
static void smooth(request *r) { r->object.normals = &normals[0][0][0], r->object.material = 1; }
static void flat(request *r) { smooth(r), r->view.normals = PKTRT_NORMALS_GEOMETRIC; }
static void mirror(request *r) {
  r->object.material = 1, r->look.specular = PKTRT_SPECULAR_MIRROR;
  for (int a = 0; a < 3; a++) r->look.reflectance[a] = 0.5f;
}
static void glass(request *r) { r->object.material = 1, r->look.specular = PKTRT_SPECULAR_DIELECTRIC; }
static void metal(request *r) {
  r->object.material = 1, r->look.specular = PKTRT_SPECULAR_CONDUCTOR;
  for (int a = 0; a < 3; a++) r->look.ior[a] = 0.25f * (float)(a + 1), r->look.extinction[a] = 3;
}
static void gloss(request *r) { mirror(r), r->look.lobe = PKTRT_LOBE_PHONG, r->look.exponent = 20; }
static void striped(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) p->albedo[1][i] = p->barycentric[0][i] > 0.5f ? 1.0f : 0.0f;
}
static void drawn(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) p->albedo[1][i] = p->texcoord[0][i];
}
static void cut(void *user, const pktrt_points *p) {
  striped(user, p);
  for (uint32_t i = 0; i < p->n; i++) p->opacity[i] = p->barycentric[1][i] > 0.25f ? 0.0f : 1.0f;
}
static void shader(void *user, const pktrt_points *p, float *radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++)
    for (int a = 0; a < 3; a++) radiance[a][i] = p->normal[a][i];
}
static void textured(request *r) { r->object.material = 1, r->look.texture = striped; }
static void drawn_by_texcoords(request *r) { textured(r), with_texcoords(r), r->look.texture = drawn; }
static void cut_out(request *r) { textured(r), r->look.texture = cut, r->look.cutout = true; }
static void thin(request *r) { glass(r), r->look.specular = PKTRT_SPECULAR_THIN; }
static void stained(request *r) { thin(r), r->look.texture = striped; }
static void blended(request *r) { r->object.material = 1, r->look.blend = true, r->look.transparency = 0.5f; }
static void shaded(request *r) { r->object.material = 1, r->look.shader = shader; }
static void quad_light(request *r) {
  r->light.kind = PKTRT_LIGHT_QUAD; /* that faces down */
  r->light.edge[0][0] = r->light.edge[1][2] = 1, r->light.edge[1][1] = 0.25f;
}
static void sphere_light(request *r) { r->light.kind = PKTRT_LIGHT_SPHERE, r->light.radius = 0.5f; }
static void mesh_light(request *r) {
  r->object.material = 1, r->light.kind = PKTRT_LIGHT_MESH, r->light.mesh = 1;
  for (int a = 0; a < 3; a++) r->look.emission[a] = 2, r->light.intensity[a] = 1;
}
static void sky_light(request *r) {
  r->light.kind = PKTRT_LIGHT_ENVIRONMENT, r->view.environment = add_sky;
  for (int a = 0; a < 3; a++) r->light.intensity[a] = 1;
}
static void sun(request *r) { r->light.kind = PKTRT_LIGHT_DIRECTIONAL, r->light.direction[1] = -1; }
static void moving_camera(request *r) {
  r->view.camera.moving = true, r->view.camera.time = 0.5f;
  memcpy(r->view.camera.eye_end, r->view.camera.eye, sizeof r->view.camera.eye);
  r->view.camera.eye_end[0] = 2;
}
static void lens(request *r) { r->view.camera.aperture = 0.25f, r->view.camera.focus = 2; }
/* What a shutter does is seen where something moves: here a texture's colours, so that this case needs no motion. */
static void flashing(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) p->albedo[0][i] = p->time[i];
}
static void shutter(request *r) { r->view.camera.shutter = 1; }
static void flash(request *r) { textured(r), shutter(r), r->look.texture = flashing; }
static void paper(request *r) { r->view.path = PKTRT_PATH_PAPER; }
static void counting(request *r) { r->view.stats = &stats; }
static void one_light(request *r) { mirror(r), r->view.lights = PKTRT_LIGHTS_ONE_DEEPER; }
static void packets_of_16(request *r) { mirror(r), r->view.packet_size = 16, r->view.assembly = PKTRT_ASSEMBLY_RUNS; }

static void try_pictures(void) {
  try_case("-", "mirror", mirror);
  try_case("-", "directional light", sun);
  try_case("-", "one light deeper", one_light);
  try_case("-", "runs of packets", packets_of_16);
  try_case("-", "normals not looked at", flat);
  try_case("PKTRT_NO_NORMALS", "normals", smooth);
  try_case("PKTRT_NO_MOTION", "moving camera", moving_camera);
  try_case("PKTRT_NO_DIELECTRIC", "glass", glass);
  try_case("PKTRT_NO_CONDUCTOR", "metal", metal);
  try_case("PKTRT_NO_GLOSS", "gloss", gloss);
  try_case("PKTRT_NO_TEXTURES", "texture", textured);
  try_case("PKTRT_NO_TEXTURES", "shader", shaded);
  try_case("PKTRT_NO_SURFACES PKTRT_NO_TEXTURES", "texture by texcoords", drawn_by_texcoords);
  try_case("PKTRT_NO_SURFACES PKTRT_NO_TEXTURES", "cutout", cut_out);
  try_case("PKTRT_NO_DIELECTRIC", "thin sheet", thin);
  try_case("PKTRT_NO_DIELECTRIC PKTRT_NO_SURFACES PKTRT_NO_TEXTURES", "stained glass", stained);
  try_case("PKTRT_NO_SURFACES", "blend", blended);
  try_case("PKTRT_NO_AREA_LIGHTS", "quad light", quad_light);
  try_case("PKTRT_NO_AREA_LIGHTS", "sphere light", sphere_light);
  try_case("PKTRT_NO_AREA_LIGHTS", "mesh light", mesh_light);
  try_case("PKTRT_NO_AREA_LIGHTS", "sky light", sky_light);
  try_case("PKTRT_NO_LENS", "lens", lens);
  try_case("PKTRT_NO_SHUTTER", "shutter", shutter);
  try_case("PKTRT_NO_SHUTTER PKTRT_NO_TEXTURES", "flash", flash);
  try_case("PKTRT_NO_PAPER", "paper path", paper);
  try_case("PKTRT_NO_STATS", "counting", counting);
  printf("PKTRT_NO_STATS\trays of pictures\t");
  if (stats.samples) printf("%llu\n", (unsigned long long)stats.by_type[PKTRT_RAY_SHADOW].rays);
  else printf("left out\n");
}
#endif

static void count_event(void *user, const pktrt_event *e) {
  (void)e;
  ++*(unsigned *)user;
}

/* Queries never fail: what is left out they do not do. */
static void try_query(void) {
  pktrt_scene *s = make_scene(PKTRT_ISA_AUTO);
  pktrt_query_desc q;
  pktrt_stats counts;
  pktrt_hit hit;
  uint32_t state = 7;
  unsigned events = 0;
  request r;
  defaults(&r);
  memset(&counts, 0, sizeof counts), memset(&q, 0, sizeof q);
  if (!s || fill(s, &r) != PKTRT_OK) return;
  const pktrt_ray ray = ray_of(&state);
  q.stats = &counts;
  pktrt_intersect_ex(s, &q, &ray, &hit, 1);
  q.path = PKTRT_PATH_PAPER, q.stats = NULL, q.trace = count_event, q.user = &events;
  pktrt_intersect_ex(s, &q, &ray, &hit, 1);
  printf("PKTRT_NO_STATS\trays of queries\t%s\n", counts.by_type[0].rays ? "counted" : "left out");
  printf("PKTRT_NO_STATS PKTRT_NO_PAPER\tevents of the paper path\t%s\n", events ? "told" : "left out");
  pktrt_scene_destroy(s);
}

/* What a mask leaves of the rays' hits. */
static void try_masks(void) {
  static pktrt_ray rays[RAYS];
  static pktrt_hit hits[RAYS];
  pktrt_scene *s = make_scene(PKTRT_ISA_AUTO);
  pktrt_query_desc q;
  uint32_t state = 7, seen = 0;
  request r;
  defaults(&r), masked(&r);
  memset(&q, 0, sizeof q);
  printf("PKTRT_NO_GROUPS\tmasks of queries\t");
  if (!s || fill(s, &r) != PKTRT_OK) {
    printf("refused: %s\n", pktrt_last_error(s)), pktrt_scene_destroy(s);
    return;
  }
  q.mask = 1; /* sees the ground alone */
  for (int i = 0; i < RAYS; i++) rays[i] = ray_of(&state);
  pktrt_intersect_ex(s, &q, rays, hits, RAYS);
  for (int i = 0; i < RAYS; i++) seen += hits[i].mesh == 1;
  uint64_t sum = 14695981039346656037u;
  add_to(&sum, hits, sizeof hits);
  printf("%016llx%s\n", (unsigned long long)sum, seen ? ", and yet the object is seen" : "");
  pktrt_scene_destroy(s);
}

/* Surfaces of hits, and rays from them. */
static void try_surfaces(const char *left_out_by, const char *name, bool with_normals) {
#ifndef PKTRT_NO_SURFACES
  uint32_t state = 7;
  uint64_t sum = 14695981039346656037u;
  pktrt_scene *s = make_scene(PKTRT_ISA_AUTO);
  request r;
  defaults(&r), with_texcoords(&r);
  if (with_normals) r.object.normals = &normals[0][0][0];
  for (int i = 0; i < RAYS && (i || (s && fill(s, &r) == PKTRT_OK)); i++) {
    const pktrt_ray ray = ray_of(&state);
    pktrt_surface_info surface;
    pktrt_hit hit;
    pktrt_ray out;
    pktrt_intersect(s, &ray, &hit), pktrt_surface(s, &ray, &hit, &surface);
    pktrt_spawn_at(s, hit.mesh, hit.triangle, hit.u, hit.v, ray.time, ray.direction, &out);
    add_to(&sum, surface.position, 11 * sizeof(float)), add_to(&sum, &out, sizeof out);
  }
  printf("%s\t%s\t%016llx\n", left_out_by, name, (unsigned long long)sum);
  pktrt_scene_destroy(s);
#else
  (void)with_normals;
  printf("%s\t%s\tleft out\n", left_out_by, name);
#endif
}

/* Closest points of meshes, at other times too. */
static void try_closest(void) {
  const char *name = "closest points";
#ifndef PKTRT_NO_CLOSEST
  uint32_t state = 9;
  uint64_t sum = 14695981039346656037u;
  pktrt_scene *s = make_scene(PKTRT_ISA_AUTO);
  request r;
  defaults(&r);
  for (int i = 0; i < RAYS && (i || (s && fill(s, &r) == PKTRT_OK)); i++) {
    const pktrt_ray ray = ray_of(&state);
    pktrt_closest at;
    pktrt_closest_point(s, ray.origin, 5, &at);
    add_to(&sum, &at, sizeof at);
  }
  printf("PKTRT_NO_CLOSEST\t%s\t%016llx\n", name, (unsigned long long)sum);
  pktrt_scene_destroy(s);
#else
  printf("PKTRT_NO_CLOSEST\t%s\tleft out\n", name);
#endif
}

static const char *set_switch(pktrt_isa isa) {
  return isa == PKTRT_ISA_AVX512 ? "PKTRT_NO_SIMD PKTRT_NO_AVX512"
         : isa == PKTRT_ISA_AVX2 ? "PKTRT_NO_SIMD PKTRT_NO_AVX2"
         : isa == PKTRT_ISA_SSE2 ? "PKTRT_NO_SIMD PKTRT_NO_SSE2"
         : isa == PKTRT_ISA_NEON ? "PKTRT_NO_SIMD"
                                 : "PKTRT_NO_SCALAR";
}

static void try_sets(void) {
  for (int i = PKTRT_ISA_SCALAR; i < PKTRT_ISA_COUNT; i++) {
    const pktrt_isa isa = (pktrt_isa)i;
    pktrt_scene *s = make_scene(isa);
    request r;
    defaults(&r);
    printf("%s\t%s\t", set_switch(isa), pktrt_isa_string(isa));
    if (s && fill(s, &r) == PKTRT_OK) printf("%016llx\n", (unsigned long long)checksum_of_hits(s));
    else printf("left out%s\n", pktrt_isa_available(isa) ? ", and yet available" : "");
    pktrt_scene_destroy(s);
  }
}

/* What the report says that this build has not. */
static void print_built(void) {
  pktrt_scene *s = make_scene(PKTRT_ISA_AUTO);
  pktrt_scene_report r;
  pktrt_get_scene_report(s, NULL, &r);
  printf("not built");
  for (uint32_t bit = 1; bit <= PKTRT_FEATURE_SURFACES; bit *= 2)
    if (!(r.built & bit)) printf(", %s", pktrt_feature_string((pktrt_feature)bit));
  printf("\n");
  pktrt_scene_destroy(s);
}

int main(void) {
  make_ground(), make_object();
  print_built();
  try_sets();
  try_query();
  try_case("-", "static, diffuse", NULL);
  try_case("PKTRT_NO_MOTION", "moving mesh", moving_mesh);
#ifndef PKTRT_NO_INSTANCES
  try_case("PKTRT_NO_INSTANCES", "instance", placed);
  try_case("PKTRT_NO_GROUPS PKTRT_NO_INSTANCES", "mask of an instance", placed_with_mask);
#else
  printf("PKTRT_NO_INSTANCES\tinstance\tleft out\n");
  printf("PKTRT_NO_GROUPS PKTRT_NO_INSTANCES\tmask of an instance\tleft out\n");
#endif
  try_case("PKTRT_NO_GROUPS", "group", grouped);
  try_case("PKTRT_NO_GROUPS", "mask", masked);
  try_masks();
#ifndef PKTRT_NO_REMOVAL
  try_case("PKTRT_NO_REMOVAL", "hidden mesh", hidden);
  try_case("PKTRT_NO_REMOVAL", "removed mesh", removed);
#else
  printf("PKTRT_NO_REMOVAL\thidden mesh\tleft out\nPKTRT_NO_REMOVAL\tremoved mesh\tleft out\n");
#endif
  try_case("PKTRT_NO_POOLS", "materials of triangles", with_materials);
  try_case("PKTRT_NO_SURFACES", "texcoords", with_texcoords);
  try_surfaces("PKTRT_NO_SURFACES", "surfaces", false);
  try_surfaces("PKTRT_NO_NORMALS PKTRT_NO_SURFACES", "surfaces with normals", true);
  try_closest();
#ifndef PKTRT_NO_RENDER
  try_pictures();
#endif
  return fflush(stdout) == 0 ? 0 : 1;
}
