/* For .ci/flags, which compiles it under many flags. Prints a line for each instruction set that runs here: its name, then a
   checksum of hits and a picture, or the sentence of a scene that could not be created; and how many single calls differ from
   many-ray calls, which have the rays in other packets. What it makes itself is exact, whatever the flags. */
#define PKTRT_IMPLEMENTATION
#include PKTRT_HEADER /* in quotes, given on the command line */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
  EDGE = 40,
  VERTICES = (EDGE + 1) * (EDGE + 1),
  GROUND = 2 * EDGE * EDGE,
  RAYS = 20000,
  SINGLE = 4000,
  SIZE = 24
};

static float ground_xyz[VERTICES][3];
static uint32_t ground_index[GROUND][3];
static const float object_xyz[6][3] = {
    {1014, 1, 20}, {1026, 1, 20}, {1020, 1, 14}, {1020, 1, 26}, {1020, 9, 20}, {1020, -7, 20}};
static const uint32_t object_index[8][3] = {
    {4, 2, 0}, {4, 1, 2}, {4, 3, 1}, {4, 0, 3}, {5, 0, 2}, {5, 2, 1}, {5, 1, 3}, {5, 3, 0}};
static pktrt_ray rays[RAYS];
static pktrt_hit hits[RAYS];
static float pixels[SIZE * SIZE * 3];

static uint32_t random_bits(uint32_t *state) {
  uint32_t x = *state += 0x9E3779B9u;
  x = (x ^ (x >> 16)) * 0x85EBCA6Bu;
  x = (x ^ (x >> 13)) * 0xC2B2AE35u;
  return x ^ (x >> 16);
}
static float random_unit(uint32_t *state) { return (float)(random_bits(state) >> 16) * (1.0f / 65536); }

static void add_to(uint64_t *sum, const void *data, size_t bytes) { /* FNV-1a */
  const unsigned char *p = (const unsigned char *)data;
  for (size_t i = 0; i < bytes; i++) *sum = (*sum ^ p[i]) * 1099511628211u;
}

/* A rough ground far from the origin, and rays from above to its vertices: each passes an edge. Coordinates are multiples of
   2^-13, directions of 2^-11: sums are exact. */
static void make_ground(void) {
  uint32_t state = 1, n = 0;
  for (uint32_t i = 0; i < VERTICES; i++) {
    ground_xyz[i][0] = 1000 + (float)(i % (EDGE + 1)) + 0.5f * (float)(random_bits(&state) >> 20) / 4096;
    ground_xyz[i][1] = (float)(random_bits(&state) >> 20) / 4096;
    ground_xyz[i][2] = (float)(i / (EDGE + 1)) + 0.5f * (float)(random_bits(&state) >> 20) / 4096;
  }
  for (uint32_t i = 0; i < EDGE * EDGE; i++) {
    const uint32_t a = i / EDGE * (EDGE + 1) + i % EDGE, b = a + EDGE + 1;
    const uint32_t both[2][3] = {{a, b, b + 1}, {a, b + 1, a + 1}};
    memcpy(ground_index[n], both, sizeof both), n += 2;
  }
  for (int i = 0; i < RAYS; i++) {
    const float *aim = ground_xyz[random_bits(&state) % VERTICES];
    memset(&rays[i], 0, sizeof rays[i]);
    for (int a = 0; a < 3; a++) {
      rays[i].direction[a] = a == 1 ? -1.0f : (float)(random_bits(&state) >> 21) / 2048 - 0.5f;
      rays[i].origin[a] = aim[a] - 4 * rays[i].direction[a];
    }
    if (i % 3 == 0) rays[i].direction[i / 3 % 3] *= random_unit(&state) < 0.5f ? 0.0f : -0.0f;
    rays[i].tmax = i % 5 ? FLT_MAX : INFINITY;
  }
}

#ifdef PKTRT_NO_RENDER
static pktrt_status add_looks(pktrt_scene *s, pktrt_mesh_desc *ground, pktrt_mesh_desc *object) {
  return (void)s, (void)ground, (void)object, PKTRT_OK;
}
static pktrt_status render(pktrt_scene *s) { return (void)s, PKTRT_OK; }
#else
static pktrt_status add_looks(pktrt_scene *s, pktrt_mesh_desc *ground, pktrt_mesh_desc *object) {
  pktrt_material glass, gold;
  pktrt_light lamp;
  memset(&glass, 0, sizeof glass), memset(&gold, 0, sizeof gold), memset(&lamp, 0, sizeof lamp);
  glass.specular = PKTRT_SPECULAR_DIELECTRIC, glass.absorption[0] = 0.25f;
  gold.specular = PKTRT_SPECULAR_CONDUCTOR, gold.lobe = PKTRT_LOBE_PHONG, gold.exponent = 20;
  for (int a = 0; a < 3; a++) gold.ior[a] = 0.25f, gold.extinction[a] = 2.5f, lamp.intensity[a] = 8;
  lamp.kind = PKTRT_LIGHT_QUAD, lamp.position[0] = 1010, lamp.position[1] = 20, lamp.position[2] = 10;
  lamp.edge[0][0] = 4, lamp.edge[1][2] = 4;
  pktrt_status status = pktrt_add_material(s, &gold, &ground->material);
  if (!status) status = pktrt_add_material(s, &glass, &object->material);
  return status ? status : pktrt_add_light(s, &lamp, NULL);
}

static pktrt_status render(pktrt_scene *s) {
  pktrt_render_desc d;
  memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = d.height = SIZE, d.pixels = pixels, d.mode = PKTRT_MODE_DRT, d.samples = 2;
  d.camera.eye[0] = 1020, d.camera.eye[1] = 12, d.camera.eye[2] = -16;
  d.camera.target[0] = d.camera.eye[0], d.camera.target[2] = 20;
  d.camera.aperture = 0.5f, d.background[2] = 1, d.ambient[0] = 0.25f, d.ambient[1] = 0.125f;
  return pktrt_render(s, &d);
}
#endif

static pktrt_status fill(pktrt_scene *s) {
  pktrt_mesh_desc ground, object;
  memset(&ground, 0, sizeof ground), memset(&object, 0, sizeof object);
  ground.positions = ground_xyz[0], ground.vertex_count = VERTICES, ground.indices = ground_index[0];
  ground.triangle_count = GROUND;
  object.positions = object_xyz[0], object.vertex_count = 6, object.indices = object_index[0],
  object.triangle_count = 8;
  pktrt_status status = add_looks(s, &ground, &object);
  if (!status) status = pktrt_add_mesh(s, &ground, NULL);
  if (!status) status = pktrt_add_mesh(s, &object, NULL);
  return status ? status : pktrt_commit(s);
}

int main(void) {
  make_ground();
  for (int isa = PKTRT_ISA_SCALAR; isa < PKTRT_ISA_COUNT; isa++) {
    pktrt_scene_desc desc;
    memset(&desc, 0, sizeof desc);
    desc.isa = (pktrt_isa)isa;
    if (!pktrt_isa_available(desc.isa)) continue;
    pktrt_scene *s = pktrt_scene_create(&desc);
    if (!s) {
      printf("%s refused: %s\n", pktrt_isa_string(desc.isa), pktrt_last_error(NULL));
      continue;
    }
    if (fill(s) || render(s)) return printf("%s\n", pktrt_last_error(s)), 1;
    pktrt_intersect_n(s, rays, hits, RAYS);
    int differ = 0;
    for (int i = 0; i < SINGLE; i++) {
      pktrt_hit hit;
      pktrt_intersect(s, &rays[i], &hit);
      differ += memcmp(&hit, &hits[i], sizeof hit) != 0;
    }
    uint64_t sum = 14695981039346656037u;
    add_to(&sum, hits, sizeof hits), add_to(&sum, pixels, sizeof pixels);
    printf("%s %016llx, single calls: %d of %d differ\n", pktrt_isa_string(desc.isa), (unsigned long long)sum, differ,
        SINGLE);
    pktrt_scene_destroy(s);
  }
  return 0;
}
