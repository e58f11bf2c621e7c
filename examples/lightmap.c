/* A lightmap: how much of the sky a surface sees is baked into a picture by threads, which then is put on as a texture.

   Each face of the boxes has a rectangle in the picture, its chart. A texel whose middle lies in the chart of a triangle
   stands for a point of the triangle. pktrt_spawn_at makes rays that leave there, over the hemisphere by the cosine, so
   that the part of them that meets nothing is the light of an even sky. `lightmap [RAYS]` for each texel, 128 unless told. */
#include "common.h"

#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

enum { BOXES = 10, FACES = 5 * BOXES, ATLAS = 512, TEXELS = ATLAS * ATLAS, MOST = 1024, WIDTH = 800, HEIGHT = 500 };

/* From a corner to the opposite one, and colours: floor, walls, a table, things on it and beside it. */
static const float boxes[BOXES][9] = {{-4, -0.2f, -4, 4, 0, 4, 0.75f, 0.73f, 0.7f},
    {-3.5f, 0, -3.5f, -3.2f, 2.4f, 2.5f, 0.8f, 0.76f, 0.7f}, {-3.2f, 0, -3.5f, 2.2f, 2.4f, -3.2f, 0.8f, 0.76f, 0.7f},
    {-2.4f, 1.2f, -2.4f, 0.7f, 1.4f, 0.1f, 0.66f, 0.46f, 0.3f},
    {-2.2f, 0, -2.2f, -1.9f, 1.2f, -0.1f, 0.66f, 0.46f, 0.3f}, {0.2f, 0, -2.2f, 0.5f, 1.2f, -0.1f, 0.66f, 0.46f, 0.3f},
    {-1.6f, 1.4f, -1.9f, -0.8f, 2, -1.2f, 0.25f, 0.45f, 0.65f}, {1.7f, 0, -1.6f, 2.9f, 1, -0.4f, 0.75f, 0.3f, 0.22f},
    {1.9f, 1, -1.4f, 2.6f, 1.6f, -0.7f, 0.8f, 0.62f, 0.25f}, {0.6f, 0, 1.2f, 1.8f, 0.5f, 2, 0.35f, 0.55f, 0.35f}};
static const int axes[5] = {1, 0, 2, 0, 2},
                 signs[5] = {1, 1, 1, -1, -1};          /* of the faces' normals: there is no bottom */
static const float density = 24, gap = 4, side = ATLAS; /* texels of a unit of length, between charts, of the atlas */
static float positions[4 * FACES][3], texcoords[4 * FACES][2], atlas[TEXELS][3], pixels[WIDTH * HEIGHT * 3];
static uint32_t triangles[2 * FACES][3];
static pktrt_scene *scene;
static pktrt_sampling sampling;
static pktrt_hit points[TEXELS]; /* what texels stand for; mesh PKTRT_NONE: nothing */
static float light[TEXELS];      /* the part of the sky that they see; below 0: not known */

/* Makes the faces of all boxes, and puts their charts in rows, one after the other. */
static bool make_faces(void) {
  float x = gap, y = gap, row = 0; /* row: its height so far */
  for (uint32_t i = 0; i < FACES; i++) {
    const float *lo = boxes[i / 5], *hi = lo + 3;
    const int a = axes[i % 5], b = (a + 1) % 3, c = (a + 2) % 3;
    const bool wide = hi[b] - lo[b] > hi[c] - lo[c]; /* charts are wide, not high, so that rows are full */
    const int u = wide ? b : c, v = wide ? c : b;
    const float w = roundf(density * (hi[u] - lo[u])), h = roundf(density * (hi[v] - lo[v]));
    const uint32_t both[2][3] = {{4 * i, 4 * i + 1, 4 * i + 2}, {4 * i, 4 * i + 2, 4 * i + 3}};
    memcpy(triangles[2 * i], both, sizeof both);
    if (x + w + gap > side) x = gap, y += row + gap, row = 0;
    if (x + w + gap > side || y + h + gap > side) return ex_fail("%d texels are too few for all charts", TEXELS);
    for (uint32_t k = 4 * i; k < 4 * i + 4; k++) {
      const bool right = k % 4 == 1 || k % 4 == 2, up = k % 4 >= 2;
      positions[k][a] = signs[i % 5] > 0 ? hi[a] : lo[a], positions[k][u] = right ? hi[u] : lo[u],
      positions[k][v] = up ? hi[v] : lo[v];
      texcoords[k][0] = (right ? x + w : x) / side, texcoords[k][1] = (up ? y + h : y) / side;
    }
    x += w + gap, row = fmaxf(row, h);
  }
  return true;
}

/* Twice the area of a triangle; negative if its corners run the other way. */
static float area(const float a[2], const float b[2], const float c[2]) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/* Finds the texels in the chart of a triangle, and the point of the triangle that each of them stands for. */
static void find_points(uint32_t triangle) {
  const uint32_t *k = triangles[triangle];
  const float *a = texcoords[k[0]], *b = texcoords[k[1]], *c = texcoords[k[2]], all = area(a, b, c);
  for (int i = 0; i < TEXELS; i++) { /* with many triangles one would look within the bounds of each */
    const float p[2] = {((float)(i % ATLAS) + 0.5f) / side, ((float)(i / ATLAS) + 0.5f) / side};
    const float u = area(a, p, c) / all, v = area(a, b, p) / all;
    if (u >= 0 && v >= 0 && u + v <= 1)
      points[i].mesh = 0, points[i].triangle = triangle, points[i].u = u, points[i].v = v;
  }
}

/* Bakes row y, on any thread. */
static void bake(void *user, size_t y) {
  pktrt_ray rays[MOST];
  bool blocked[MOST];
  (void)user;
  for (uint32_t x = 0; x < ATLAS; x++) {
    const pktrt_hit *at = &points[y * ATLAS + x];
    const uint32_t face = at->triangle / 2 % 5;
    float u[2], direction[3], normal[3] = {0, 0, 0}, seen = 0;
    if (at->mesh == PKTRT_NONE) continue;
    normal[axes[face]] = (float)signs[face];
    for (uint32_t i = 0; i < sampling.samples; i++) {
      pktrt_sample(&sampling, x, (uint32_t)y, i, 0, 2, u);
      pktrt_map_cosine(u, normal, direction);
      pktrt_spawn_at(scene, at->mesh, at->triangle, at->u, at->v, 0, direction, &rays[i]);
    }
    pktrt_occluded_n(scene, rays, blocked, sampling.samples);
    for (uint32_t i = 0; i < sampling.samples; i++) seen += blocked[i] ? 0.0f : 1.0f;
    light[y * ATLAS + x] = seen / (float)sampling.samples;
  }
}

/* Gives unknown texels the mean of known neighbours: beside the edge of a chart a look-up reads them, too. */
static void dilate(void) {
  static float before[TEXELS];
  memcpy(before, light, sizeof light);
  for (int i = ATLAS + 1; i < TEXELS - ATLAS - 1; i++) {
    float sum = 0, known = 0;
    for (int k = 0; k < 9 && before[i] < 0; k++) {
      const float there = before[i + (k / 3 - 1) * ATLAS + k % 3 - 1];
      if (there >= 0) sum += there, known++;
    }
    if (known > 0) light[i] = sum / known;
  }
}

/* Gives points that are to be shaded the colour of their box, darkened by what lies between four texels of the lightmap. */
static void look_up(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    const float x = p->texcoord[0][i] * side - 0.5f, y = p->texcoord[1][i] * side - 0.5f;
    const float *t = &light[(int)y * ATLAS + (int)x], r = x - floorf(x), d = y - floorf(y);
    const float seen = (1 - d) * ((1 - r) * t[0] + r * t[1]) + d * ((1 - r) * t[ATLAS] + r * t[ATLAS + 1]);
    for (int c = 0; c < 3; c++) p->albedo[c][i] = seen * boxes[p->triangle[i] / 10][6 + c];
  }
}

/* Renders without a light: the sky is as bright as the background everywhere, and its shadows are in the texture. */
static bool render(void) {
  static pktrt_render_desc view;
  view.width = WIDTH, view.height = HEIGHT, view.pixels = pixels, view.samples = 16;
  view.camera.eye[0] = 5, view.camera.eye[1] = 4, view.camera.eye[2] = 6, view.camera.fov_y = 36;
  view.camera.target[1] = 0.4f;
  for (int c = 0; c < 3; c++) view.ambient[c] = view.background[c] = 0.8f + 0.08f * (float)c;
  return pktrt_render(scene, &view) == PKTRT_OK;
}

int main(int argc, char **argv) {
  static pktrt_material baked; /* static, hence zeroed */
  static pktrt_mesh_desc mesh;
  ex_threads threads = ex_threads_of(ex_processors());
  unsigned known = 0;
  sampling.sampler = PKTRT_SAMPLER_BLUE_NOISE, sampling.samples = ex_only_argument(argc, argv, "RAYS", 128, 1, MOST);
  if (!make_faces()) return 1;
  for (int i = 0; i < TEXELS; i++) points[i].mesh = PKTRT_NONE, light[i] = -1;
  for (uint32_t i = 0; i < 2 * FACES; i++) find_points(i);
  baked.texture = look_up, mesh.material = 1; /* the first that is added */
  mesh.positions = positions[0], mesh.texcoords = texcoords[0], mesh.vertex_count = 4 * FACES;
  mesh.indices = triangles[0], mesh.triangle_count = 2 * FACES;
  scene = pktrt_scene_create(NULL);
  bool ok = !pktrt_add_material(scene, &baked, NULL) && !pktrt_add_mesh(scene, &mesh, NULL) && !pktrt_commit(scene);
  const double start = ex_seconds();
  if (ok) ex_parallel_for(&threads, ATLAS, bake, NULL);
  ex_threads_stop(&threads);
  for (int i = 0; i < TEXELS; i++) known += light[i] >= 0;
  if (ok) printf("%u texels with %u rays each: %.2f s\n", known, sampling.samples, ex_seconds() - start);
  dilate(), dilate();
  for (int i = 0; i < 3 * TEXELS; i++) atlas[i / 3][i % 3] = light[i / 3];
  ok = ok && render();
  if (!ok) ex_fail("%s", pktrt_last_error(scene));
  pktrt_scene_destroy(scene);
  ok = ok && ex_write_picture("out/lightmap-atlas.png", atlas[0], ATLAS, ATLAS);
  return ok && ex_write_picture("out/lightmap.png", pixels, WIDTH, HEIGHT) ? 0 : 1;
}
