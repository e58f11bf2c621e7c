/* What distribution ray tracing adds, one effect after the other: a lens, a shutter, an area light, gloss.

   Four small pictures of the same scene, out/effects-*.png. Each has one effect more than the one before; what is
   not yet switched on is ideal: a pinhole, an instant, a point, a perfect mirror. All of them are done by the same
   64 rays per pixel, which then only start, aim and bounce elsewhere: look at the numbers of rays.    make effects */
#include "common.h"

#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

enum { WIDTH = 512, HEIGHT = 342, SAMPLES = 64, AROUND = 96, DOWN = 48 };
typedef enum effect { LENS, SHUTTER, AREA_LIGHT, GLOSS, EFFECTS } effect;
static const char *const names[EFFECTS] = {"lens", "shutter", "light", "gloss"};

typedef struct ball {
  float x, z, radius;
  uint32_t material; /* number of the material, see make_materials */
  float step;        /* how far it moves to the right while the shutter is open */
} ball;
enum { FLOOR = 1, RED, GOLD, GLASS, BLUE, CREAM, LAMP };

static const ball balls[] = {{-0.3f, 0.0f, 1.0f, GOLD, 0}, {-2.2f, 1.2f, 0.62f, GLASS, 0},
    {2.3f, 0.1f, 0.75f, RED, 0.55f}, {0.95f, 2.6f, 0.42f, BLUE, 0}, {-3.9f, -3.6f, 1.0f, RED, 0},
    {0.7f, -5.5f, 0.9f, CREAM, 0}, {4.6f, -4.6f, 0.95f, BLUE, 0}, {-5.6f, -9.5f, 1.4f, CREAM, 0},
    {2.4f, -11.0f, 1.2f, RED, 0}};
static const float lamp[4][3] = {{-5.6f, 4.6f, -2.6f}, {-3.2f, 7.0f, -2.6f}, {-3.2f, 7.0f, 2.6f}, {-5.6f, 4.6f, 2.6f}};

/* The floor: tiles of two shades, laid a little askew; where there is gloss the dark ones are duller. A texture knows the
   points of many rays at once. */
static void tiles(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    const int x = (int)floorf(p->position[0][i]), z = (int)floorf(p->position[2][i]), odd = (x + z) & 1;
    for (int c = 0; c < 3; c++) p->albedo[c][i] *= odd ? 0.35f : 1.0f;
    p->normal_out[0][i] += 0.004f * (float)(((5 * x + 3 * z) & 7) - 4);
    p->exponent[i] *= odd ? 0.3f : 1.0f;
  }
}

/* Where rays meet nothing: a pale horizon, darker above. */
static void sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  static const float low[3] = {0.85f, 0.72f, 0.6f}, high[3] = {0.07f, 0.12f, 0.26f};
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const float up = direction[1][i] > 0 ? direction[1][i] : 0, t = up * (2 - up);
    for (int c = 0; c < 3; c++) radiance[c][i] = low[c] + t * (high[c] - low[c]);
  }
}

static bool make_materials(pktrt_scene *scene, bool gloss) {
  static const float albedo[][3] = {
      {0.5f, 0.47f, 0.43f}, {0.62f, 0.06f, 0.04f}, {0}, {0}, {0.05f, 0.14f, 0.42f}, {0.75f, 0.68f, 0.52f}, {0}};
  for (uint32_t i = FLOOR; i <= LAMP; i++) {
    pktrt_material m;
    memset(&m, 0, sizeof m);
    memcpy(m.albedo, albedo[i - FLOOR], sizeof m.albedo);
    m.specular = i == GLASS ? PKTRT_SPECULAR_DIELECTRIC : i == GOLD ? PKTRT_SPECULAR_CONDUCTOR : PKTRT_SPECULAR_COAT;
    if (i == FLOOR) m.texture = tiles, m.ior[0] = 1.9f;
    if (i == GOLD) { /* gold at red, green and blue */
      m.ior[0] = 0.18f, m.ior[1] = 0.42f, m.ior[2] = 1.37f;
      m.extinction[0] = 3.42f, m.extinction[1] = 2.35f, m.extinction[2] = 1.77f;
    }
    if (i == LAMP) m.specular = PKTRT_SPECULAR_NONE, m.emission[0] = 6, m.emission[1] = 5.5f, m.emission[2] = 5;
    if (gloss && (i == FLOOR || i == GOLD)) m.lobe = PKTRT_LOBE_PHONG, m.exponent = i == GOLD ? 90.0f : 400.0f;
    if (pktrt_add_material(scene, &m, NULL) != PKTRT_OK) return false;
  }
  return true;
}

/* A ball on the floor; one that moves has two keys, and the ball of a moment lies on the straight line between them. */
static bool add_ball(pktrt_scene *scene, const ball *b) {
  static float positions[2 * AROUND * (DOWN + 1)][3], normals[2 * AROUND * (DOWN + 1)][3];
  static uint32_t indices[2 * AROUND * DOWN][3];
  const uint32_t vertices = AROUND * (DOWN + 1), keys = b->step != 0 ? 2 : 1;
  for (uint32_t i = 0; i < keys * vertices; i++) {
    const uint32_t row = i % vertices / AROUND, key = i / vertices;
    const float turn = 6.2831853f * (float)(i % AROUND) / (float)AROUND, polar = 3.1415927f * (float)row / (float)DOWN;
    const float n[3] = {sinf(polar) * cosf(turn), cosf(polar), -sinf(polar) * sinf(turn)};
    const float middle[3] = {b->x + b->step * ((float)key - 0.5f), b->radius, b->z};
    for (int a = 0; a < 3; a++) normals[i][a] = n[a], positions[i][a] = middle[a] + b->radius * n[a];
  }
  for (uint32_t i = 0; i < AROUND * DOWN; i++) { /* two triangles of each square; those at the poles have no area */
    const uint32_t next = i % AROUND == AROUND - 1 ? i + 1 - AROUND : i + 1;
    const uint32_t square[2][3] = {{i, i + AROUND, next + AROUND}, {i, next + AROUND, next}};
    memcpy(indices[2 * i], square, sizeof square);
  }
  pktrt_mesh_desc mesh;
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = positions[0], mesh.normals = normals[0], mesh.vertex_count = vertices, mesh.key_count = keys;
  mesh.indices = indices[0], mesh.triangle_count = 2 * AROUND * DOWN, mesh.material = b->material;
  return pktrt_add_mesh(scene, &mesh, NULL) == PKTRT_OK;
}

static bool make_scene(pktrt_scene *scene, effect last) {
  static const float ground[4][3] = {{-60, 0, 40}, {60, 0, 40}, {60, 0, -80}, {-60, 0, -80}};
  static const uint32_t square[2][3] = {{0, 1, 2}, {0, 2, 3}};
  pktrt_mesh_desc floor_mesh, lamp_mesh;
  pktrt_light light;
  memset(&light, 0, sizeof light), memset(&floor_mesh, 0, sizeof floor_mesh);
  floor_mesh.positions = ground[0], floor_mesh.vertex_count = 4;
  floor_mesh.indices = square[0], floor_mesh.triangle_count = 2, floor_mesh.material = FLOOR;
  lamp_mesh = floor_mesh, lamp_mesh.positions = lamp[0], lamp_mesh.material = LAMP;
  bool ok = make_materials(scene, last >= GLOSS) && !pktrt_add_mesh(scene, &floor_mesh, NULL) &&
            !pktrt_add_mesh(scene, &lamp_mesh, &light.mesh);
  for (size_t i = 0; ok && i < sizeof balls / sizeof *balls; i++) ok = add_ball(scene, &balls[i]);
  light.kind = last >= AREA_LIGHT ? PKTRT_LIGHT_MESH : PKTRT_LIGHT_POINT;
  for (int a = 0; a < 3; a++) { /* the point shines as the lamp does from far: radiance times area, which is 17.65 */
    light.position[a] = 0.5f * (lamp[0][a] + lamp[2][a]) - (a == 1 ? 0.01f : 0.0f);
    light.intensity[a] = last >= AREA_LIGHT ? 1.0f : 17.65f * (6 - 0.5f * (float)a);
  }
  return ok && !pktrt_add_light(scene, &light, NULL) && !pktrt_commit(scene);
}

/* Renders with the effects up to `last`. */
static bool picture(effect last, float *pixels, ex_threads *threads) {
  char path[64];
  pktrt_scene_desc desc;
  pktrt_render_desc view;
  pktrt_stats stats;
  memset(&desc, 0, sizeof desc), memset(&view, 0, sizeof view), memset(&stats, 0, sizeof stats);
  desc.parallel_for = ex_parallel_for, desc.user = threads, desc.log = ex_log;
  view.width = WIDTH, view.height = HEIGHT, view.pixels = pixels;
  view.mode = PKTRT_MODE_DRT, view.samples = SAMPLES;
  view.camera.eye[1] = 2.5f, view.camera.eye[2] = 8.3f, view.camera.target[1] = 0.6f, view.camera.fov_y = 32;
  view.camera.focus = 7.6f;
  view.camera.aperture = last >= LENS ? 0.35f : 0.0f;
  view.camera.time = last >= SHUTTER ? 0.0f : 0.5f; /* the middle of what the open shutter sees */
  view.camera.shutter = last >= SHUTTER ? 1.0f : 0.0f;
  view.environment = sky;
  view.ambient[0] = view.ambient[1] = 0.15f, view.ambient[2] = 0.18f;
  view.stats = &stats;
  pktrt_scene *scene = pktrt_scene_create(&desc);
  const double start = ex_seconds();
  bool ok = scene && make_scene(scene, last) && pktrt_render(scene, &view) == PKTRT_OK;
  if (!ok) ex_fail("%s", pktrt_last_error(scene));
  printf("%-8s %6.2f s, million rays:", names[last], ex_seconds() - start);
  static const char *const types[] = {"primary", "shadow", "reflection", "refraction"};
  for (int t = 0; t < 4; t++) printf(" %s %.2f", types[t], 1e-6 * (double)stats.by_type[t].rays);
  printf("\n");
  pktrt_scene_destroy(scene);
  snprintf(path, sizeof path, "out/effects-%s.png", names[last]);
  return ok && ex_write_picture(path, pixels, WIDTH, HEIGHT);
}

int main(void) {
  static float pixels[HEIGHT * WIDTH * 3];
  ex_threads threads = ex_threads_of(ex_processors());
  bool ok = true;
  ex_tone = PKTRT_TONE_CURVE, ex_exposure = 1.4f;
  for (int last = LENS; ok && last < EFFECTS; last++) ok = picture((effect)last, pixels, &threads);
  ex_threads_stop(&threads);
  return ok ? 0 : 1;
}
