/* An editor's mouse among 500 moving things: what is under a pixel, what is behind it when it is hidden, and its end.

   The camera's ray through the pixel finds a mesh index; pktrt_get_mesh_source turns that into the instance, which the
   editor knows by number, and the part of its model. Hiding an instance fits the tree above instances, removing it builds
   that tree anew; what lies in the models is not touched. `pick [X Y]`: a pixel of out/pick-before.png, 960 x 540. */
#include "common.h"

#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

enum { THINGS = 500, ROW = 25, MODELS = 3, SIDES = 16, POINTS = 5, WIDTH = 960, HEIGHT = 540 };
enum { VERTICES = POINTS * (SIDES + 1), SQUARES = (POINTS - 1) * SIDES };

static const char *const models[MODELS] = {"tree", "person", "balloon"};
static const struct { /* radii and heights, turned about y */
  const char *name;
  float colour[3], profile[POINTS][2];
} parts[MODELS][2] = {
    {{"trunk", {0.35f, 0.22f, 0.13f}, {{0.14f, 0}, {0.1f, 0.2f}, {0.09f, 0.4f}, {0.09f, 0.6f}, {0, 0.8f}}},
        {"crown", {0.13f, 0.38f, 0.12f}, {{0, 0.5f}, {0.55f, 0.55f}, {0.3f, 1.1f}, {0.38f, 1.15f}, {0, 2}}}},
    {{"coat", {0.55f, 0.12f, 0.1f}, {{0.24f, 0}, {0.2f, 0.5f}, {0.16f, 0.8f}, {0.13f, 0.95f}, {0, 1}}},
        {"head", {0.8f, 0.6f, 0.45f}, {{0, 0.92f}, {0.12f, 0.98f}, {0.15f, 1.1f}, {0.11f, 1.22f}, {0, 1.28f}}}},
    {{"basket", {0.45f, 0.3f, 0.15f}, {{0, 0}, {0.15f, 0}, {0.2f, 0.25f}, {0.17f, 0.25f}, {0, 0.05f}}},
        {"envelope", {0.85f, 0.65f, 0.15f}, {{0.1f, 0.5f}, {0.55f, 1.1f}, {0.62f, 1.5f}, {0.4f, 1.95f}, {0, 2.1f}}}}};
static float pixels[HEIGHT][WIDTH][3];
static pktrt_camera camera;

/* Adds a model of two meshes with texture coordinates, which go around and from below to above. */
static bool add_model(pktrt_scene *scene, int model) {
  static float xyz[2][VERTICES][3], uv[VERTICES][2];
  static uint32_t faces[SQUARES][2][3];
  pktrt_mesh_desc meshes[2];
  memset(meshes, 0, sizeof meshes);
  for (uint32_t i = 0, n = 0; i < VERTICES; i++) {
    const uint32_t point = i / (SIDES + 1), around = i % (SIDES + 1), above = i + SIDES + 1;
    const uint32_t square[2][3] = {{i, above, i + 1}, {i + 1, above, above + 1}};
    uv[i][0] = (float)around / (float)SIDES, uv[i][1] = (float)point / (float)(POINTS - 1);
    for (int k = 0; k < 2; k++) {
      const float *p = parts[model][k].profile[point], angle = 6.2831853f * uv[i][0];
      xyz[k][i][0] = p[0] * cosf(angle), xyz[k][i][1] = p[1], xyz[k][i][2] = p[0] * sinf(angle);
    }
    if (point < POINTS - 1 && around < SIDES) memcpy(faces[n++], square, sizeof square);
  }
  for (int k = 0; k < 2; k++) {
    pktrt_material paint;
    memset(&paint, 0, sizeof paint);
    memcpy(paint.albedo, parts[model][k].colour, sizeof paint.albedo);
    meshes[k].positions = xyz[k][0], meshes[k].texcoords = uv[0], meshes[k].vertex_count = VERTICES;
    meshes[k].indices = faces[0][0], meshes[k].triangle_count = 2 * SQUARES;
    if (pktrt_add_material(scene, &paint, &meshes[k].material)) return false;
  }
  return pktrt_add_model(scene, meshes, 2, NULL) == PKTRT_OK;
}

/* Moves all things, for the next commit or refit: trees sway, people walk in circles, balloons drift. */
static bool move(pktrt_scene *scene, float time) {
  for (uint32_t i = 0; i < THINGS; i++) { /* thing i is an instance of model i % MODELS */
    const float phase = (float)(i * 2654435761u >> 8) / 16777216 * 6.2831853f, c = cosf(phase + time),
                s = sinf(phase + time);
    const float lean = i % MODELS == 0 ? 0.15f * s : 0,
                height = i % MODELS == 2 ? 3 + 1.5f * sinf(7 * phase) + 0.2f * s : 0;
    const float x = 1.3f * (float)(i % ROW) - 0.65f * (float)ROW + 0.5f * c, z = -1.3f * (float)(i / ROW) + 0.5f * s;
    const float matrix[12] = {c, lean, s, x, 0, 1, 0, height, -s, 0, c, z};
    if (pktrt_set_transform(scene, i, 0, matrix)) return false;
  }
  return true;
}

/* Fills the scene: models, instances, a meadow, the sun. */
static bool fill(pktrt_scene *scene) {
  static const float corners[4][3] = {{-500, 0, -500}, {-500, 0, 500}, {500, 0, 500}, {500, 0, -500}};
  static const uint32_t halves[2][3] = {{0, 1, 2}, {0, 2, 3}};
  static pktrt_mesh_desc meadow; /* static, hence zeroed */
  static pktrt_instance_desc thing;
  static pktrt_material grass;
  static pktrt_light sun;
  grass.albedo[0] = 0.3f, grass.albedo[1] = 0.4f, grass.albedo[2] = 0.15f;
  meadow.positions = corners[0], meadow.vertex_count = 4, meadow.indices = halves[0], meadow.triangle_count = 2;
  sun.kind = PKTRT_LIGHT_DIRECTIONAL, sun.direction[0] = -2, sun.direction[1] = -3, sun.direction[2] = -2;
  for (int c = 0; c < 3; c++) sun.intensity[c] = 2.4f - 0.25f * (float)c;
  bool ok = !pktrt_add_light(scene, &sun, NULL) && !pktrt_add_material(scene, &grass, &meadow.material) &&
            !pktrt_add_mesh(scene, &meadow, NULL);
  for (int i = 0; ok && i < MODELS; i++) ok = add_model(scene, i);
  for (uint32_t i = 0; ok && i < THINGS; i++) thing.model = i % MODELS, ok = !pktrt_add_instance(scene, &thing, NULL);
  return ok && move(scene, 0) && !pktrt_commit(scene);
}

/* Says what is under a pixel. Its mesh, or PKTRT_NONE. */
static uint32_t pick(const pktrt_scene *scene, unsigned x, unsigned y) {
  pktrt_ray ray;
  pktrt_hit hit;
  pktrt_surface_info at;
  uint32_t thing, part;
  pktrt_camera_ray(&camera, WIDTH, HEIGHT, x + 0.5, y + 0.5, NULL, 0, &ray);
  if (!pktrt_intersect(scene, &ray, &hit)) return puts("  sky"), PKTRT_NONE;
  if (!pktrt_get_mesh_source(scene, hit.mesh, &thing, &part)) printf("  meadow");
  else printf("  %s %u, its %s", models[thing % MODELS], (unsigned)thing, parts[thing % MODELS][part].name);
  pktrt_surface(scene, &ray, &hit, &at);
  printf(", at (%.2f, %.2f, %.2f), normal (%.2f, %.2f, %.2f), texture (%.2f, %.2f), material %u\n",
      (double)at.position[0], (double)at.position[1], (double)at.position[2], (double)at.normal[0],
      (double)at.normal[1], (double)at.normal[2], (double)at.texcoord[0], (double)at.texcoord[1],
      (unsigned)at.material);
  return hit.mesh;
}

/* Makes a picture in which one thing glows: a ray for each pixel tells where it is seen. */
static bool draw(pktrt_scene *scene, uint32_t thing, const char *path) {
  static pktrt_render_desc view;
  static pktrt_ray rays[WIDTH];
  static pktrt_hit hits[WIDTH];
  uint32_t seen;
  view.width = WIDTH, view.height = HEIGHT, view.pixels = pixels[0][0], view.camera = camera, view.samples = 4;
  for (int c = 0; c < 3; c++) view.ambient[c] = 0.25f + 0.03f * (float)c, view.background[c] = 0.45f + 0.2f * (float)c;
  if (pktrt_render(scene, &view)) return ex_fail("%s", pktrt_last_error(scene));
  for (int y = 0; y < HEIGHT; y++) {
    for (int x = 0; x < WIDTH; x++) pktrt_camera_ray(&camera, WIDTH, HEIGHT, x + 0.5, y + 0.5, NULL, 0, &rays[x]);
    pktrt_intersect_n(scene, rays, hits, WIDTH);
    for (int x = 0; x < WIDTH; x++)
      if (pktrt_get_mesh_source(scene, hits[x].mesh, &seen, NULL) && seen == thing)
        pixels[y][x][0] += 0.6f, pixels[y][x][1] += 0.3f;
  }
  return ex_write_picture(path, pixels[0][0], WIDTH, HEIGHT);
}

/* Says how long a change took that began at a time, and how many bytes the scene has. */
static void report(const pktrt_scene *scene, const char *change, double start) {
  const double seconds = ex_seconds() - start;
  pktrt_scene_report all;
  pktrt_get_scene_report(scene, NULL, &all);
  printf("%s in %.3f ms, %llu bytes\n", change, 1e3 * seconds, (unsigned long long)all.bytes);
}

/* Hides the thing under a pixel, looks at what is behind it, and removes it; then shows a plan. */
static bool edit(pktrt_scene *scene, unsigned x, unsigned y) {
  uint32_t thing = PKTRT_NONE, behind = PKTRT_NONE;
  double start = ex_seconds();
  if (!move(scene, 0.7f) || pktrt_refit(scene)) return ex_fail("%s", pktrt_last_error(scene));
  report(scene, "500 things moved", start);
  const uint32_t mesh = pick(scene, x, y);
  const bool found = pktrt_get_mesh_source(scene, mesh, &thing, NULL);
  if (!draw(scene, thing, "out/pick-before.png")) return false;
  if (!found) return true; /* sky and meadow stay */
  start = ex_seconds();
  if (pktrt_set_enabled(scene, mesh, false) || pktrt_refit(scene)) return ex_fail("%s", pktrt_last_error(scene));
  report(scene, "hidden", start);
  pktrt_get_mesh_source(scene, pick(scene, x, y), &behind, NULL);
  start = ex_seconds();
  if (pktrt_remove_instance(scene, thing) || pktrt_commit(scene)) return ex_fail("%s", pktrt_last_error(scene));
  report(scene, "removed", start);
  if (!draw(scene, behind, "out/pick-after.png")) return false;
  camera.projection = PKTRT_PROJECTION_ORTHOGRAPHIC, camera.width = 54; /* a plan, 54 wide, from straight above */
  camera.eye[1] = 20, camera.eye[2] = camera.target[2] = -13, camera.up[2] = -1;
  return draw(scene, behind, "out/pick-plan.png");
}

int main(int argc, char **argv) {
  unsigned x = 370, y = 250;
  if (argc != 1 && argc != 3) return ex_fail("usage: pick [X Y]"), 1;
  if (argc == 3 && !ex_parse_argument("X", argv[1], 0, WIDTH - 1, &x)) return 1;
  if (argc == 3 && !ex_parse_argument("Y", argv[2], 0, HEIGHT - 1, &y)) return 1;
  camera.eye[1] = 7, camera.eye[2] = 11, camera.target[1] = 1.5f, camera.target[2] = -5, camera.fov_y = 36;
  pktrt_scene *scene = pktrt_scene_create(NULL);
  const bool ok = scene && fill(scene) ? edit(scene, x, y) : ex_fail("%s", pktrt_last_error(scene));
  pktrt_scene_destroy(scene);
  return ok ? 0 : 1;
}
