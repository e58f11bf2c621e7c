/* What C gets from pktrt.h of the arrays in the current directory, for tests/python/test.py, which asks the same from
   Python. Reads positions0, triangles0, positions1 (two keys), triangles1 and rays; writes an array for each call. */
#include "../../pktrt.h"
#include <string.h>

#include "arrays.h"

enum { WIDTH = 48, HEIGHT = 32 };

static void add(pktrt_scene *s, const char *positions, const char *triangles, uint32_t keys, uint32_t material) {
  pktrt_mesh_desc mesh;
  size_t vertices, count;
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = (const float *)load(positions, 12, &vertices);
  mesh.indices = (const uint32_t *)load(triangles, 12, &count);
  mesh.vertex_count = (uint32_t)vertices / keys, mesh.triangle_count = (uint32_t)count;
  mesh.key_count = keys, mesh.material = material;
  if (pktrt_add_mesh(s, &mesh, NULL)) fail("pktrt_add_mesh", pktrt_last_error(s));
  free((void *)mesh.positions);
  free((void *)mesh.indices);
}

static void add_look(pktrt_scene *s) {
  pktrt_material mirror;
  pktrt_light light;
  memset(&mirror, 0, sizeof mirror);
  memset(&light, 0, sizeof light);
  mirror.specular = PKTRT_SPECULAR_MIRROR;
  mirror.albedo[0] = 0.5f, mirror.reflectance[1] = 0.75f, mirror.reflectance[2] = 0.25f;
  light.kind = PKTRT_LIGHT_POINT;
  light.position[1] = 4, light.position[2] = 2;
  light.intensity[0] = 40, light.intensity[1] = 30, light.intensity[2] = 20;
  if (pktrt_add_material(s, &mirror, NULL) || pktrt_add_light(s, &light, NULL))
    fail("pktrt_add_light", pktrt_last_error(s));
}

static void save_picture(pktrt_scene *s) {
  static float pixels[WIDTH * HEIGHT * 3], normal[WIDTH * HEIGHT * 3];
  static pktrt_render_desc view;
  view.width = WIDTH, view.height = HEIGHT, view.pixels = pixels, view.normal = normal;
  view.mode = PKTRT_MODE_DRT, view.samples = 2, view.seed = 7;
  view.camera.eye[1] = 2, view.camera.eye[2] = 5, view.camera.fov_y = 50, view.camera.shutter = 1;
  view.background[2] = 0.5f;
  if (pktrt_render(s, &view)) fail("pktrt_render", pktrt_last_error(s));
  save("pixels", pixels, sizeof pixels);
  save("normal", normal, sizeof normal);
}

static void save_sentences(pktrt_scene *s) {
  static const float corner[9] = {0};
  static const uint32_t triangle[3] = {0, 1, 5};
  FILE *file = fopen("sentences", "w");
  pktrt_mesh_desc mesh;
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = corner, mesh.vertex_count = 3, mesh.indices = triangle, mesh.triangle_count = 1;
  if (!file || !pktrt_add_mesh(s, &mesh, NULL)) fail("sentences", "a bad mesh is not refused");
  fprintf(file, "%s\n", pktrt_last_error(s));
  if (!pktrt_set_enabled(s, 7, false)) fail("sentences", "a mesh that is not there is not refused");
  fprintf(file, "%s\n", pktrt_last_error(s));
  if (fclose(file)) fail("sentences", "cannot be written");
}

#define OFFSET(type, field) fprintf(file, #type " " #field " %lu\n", (unsigned long)offsetof(type, field))
#define SIZE(type) fprintf(file, #type " %lu\n", (unsigned long)sizeof(type))
static void save_layout(void) {
  FILE *file = fopen("layout", "w");
  if (!file) fail("layout", "cannot be written");
  OFFSET(pktrt_ray, origin), OFFSET(pktrt_ray, tmin), OFFSET(pktrt_ray, direction), OFFSET(pktrt_ray, tmax);
  OFFSET(pktrt_ray, time), OFFSET(pktrt_hit, t), OFFSET(pktrt_hit, u), OFFSET(pktrt_hit, v);
  OFFSET(pktrt_hit, normal), OFFSET(pktrt_hit, mesh), OFFSET(pktrt_hit, triangle);
  OFFSET(pktrt_surface_info, position), OFFSET(pktrt_surface_info, normal), OFFSET(pktrt_surface_info, shading_normal);
  OFFSET(pktrt_surface_info, texcoord), OFFSET(pktrt_surface_info, material), OFFSET(pktrt_surface_info, instance);
  OFFSET(pktrt_surface_info, inside), OFFSET(pktrt_mesh_desc, texcoords), OFFSET(pktrt_render_desc, seconds);
  OFFSET(pktrt_material, cutout), OFFSET(pktrt_light, visible), OFFSET(pktrt_scene_desc, log);
  SIZE(pktrt_ray), SIZE(pktrt_hit), SIZE(pktrt_surface_info), SIZE(pktrt_mesh_desc), SIZE(pktrt_render_desc);
  SIZE(pktrt_camera), SIZE(pktrt_material), SIZE(pktrt_light), SIZE(pktrt_scene_desc), SIZE(pktrt_scene_info);
  if (fclose(file)) fail("layout", "cannot be written");
}

/* The trees, and the root of each at half of the time. */
static void save_trees(const pktrt_scene *s) {
  static pktrt_tree tree[99];
  static pktrt_node root[99];
  uint32_t n = 0;
  while (n < 99 && pktrt_get_tree(s, n, &tree[n])) {
    pktrt_get_node(s, n, 0, 0.5f, &root[n]);
    n++;
  }
  save("trees", tree, n * sizeof *tree);
  save("roots", root, n * sizeof *root);
}

int main(void) {
  size_t n;
  const pktrt_ray *ray = (const pktrt_ray *)load("rays", sizeof *ray, &n);
  pktrt_hit *many = (pktrt_hit *)calloc(n, sizeof *many), *single = (pktrt_hit *)calloc(n, sizeof *single);
  bool *blocked = (bool *)calloc(n, sizeof *blocked), *blocked_single = (bool *)calloc(n, sizeof *blocked);
  pktrt_surface_info *surface = (pktrt_surface_info *)calloc(n, sizeof *surface);
  pktrt_ray *next = (pktrt_ray *)calloc(n, sizeof *next);
  pktrt_scene *s = pktrt_scene_create(NULL);
  if (!many || !single || !blocked || !blocked_single || !surface || !next || !s) fail("memory", "there is none");
  add_look(s);
  add(s, "positions0", "triangles0", 1, 0);
  add(s, "positions1", "triangles1", 2, 1);
  if (pktrt_commit(s)) fail("pktrt_commit", pktrt_last_error(s));
  pktrt_intersect_n(s, ray, many, n);
  pktrt_occluded_n(s, ray, blocked, n);
  pktrt_surface_n(s, ray, many, surface, n);
  for (size_t i = 0; i < n; i++) {
    pktrt_intersect(s, &ray[i], &single[i]);
    blocked_single[i] = pktrt_occluded(s, &ray[i]);
    pktrt_spawn(s, &ray[i], &many[i], ray[i].direction, &next[i]);
  }
  save("many", many, n * sizeof *many);
  save("single", single, n * sizeof *single);
  save("blocked", blocked, n);
  save("blocked_single", blocked_single, n);
  save("surface", surface, n * sizeof *surface);
  save("next", next, n * sizeof *next);
  pktrt_intersect_after_n(s, ray, many, single, n);
  save("after", single, n * sizeof *single);
  save_picture(s);
  save_sentences(s);
  save_trees(s);
  save_layout();
  pktrt_scene_destroy(s);
  return 0;
}
