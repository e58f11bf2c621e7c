/* The Cornell box by queries alone: soft shadows of its lamp, and colours that walls throw on what is beside them. */
#include "common.h"
#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

enum { SIZE = 320, N = 64, LAMP = 3 }; /* N samples of a pixel; room, boxes and lamp are cubes without bottom */
static const float places[][12] = {{1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1},
    {.28f, 0, .09f, .15f, 0, .6f, 0, 0, -.09f, 0, .28f, .28f},
    {.28f, 0, -.09f, .56f, 0, .3f, 0, 0, .09f, 0, .28f, .51f}, {.24f, 0, 0, .38f, 0, -.002f, 0, 1, 0, 0, .2f, .4f}};
static const float tints[][3] = {{.7f, .7f, .7f}, {.6f, .05f, .05f}, {.14f, .45f, .1f}, {.44f, .34f, .22f}};
static const pktrt_sampling sampling = {PKTRT_SAMPLER_SOBOL, N, 0}; /* the last tint is the lamp's light / N */
static float pixels[SIZE * SIZE][3], cube[90], eye[] = {.5f, .5f, 2.44f};
static float dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
static const float *tint(const pktrt_hit *h) { return tints[h->mesh || h->triangle < 6 ? 0 : h->triangle / 2 - 2]; }

static void shade(void *user, size_t p) { /* pixel p: light of the lamp, and of what it lights */
  const pktrt_scene *scene = (const pktrt_scene *)user;
  pktrt_ray rays[3][N], shadow[N]; /* from the eye, from what it sees, and from what lights that */
  pktrt_hit hits[2][N];
  pktrt_surface_info at[N];
  float u[N][12], way[N][3], light[2][N];
  bool blocked[2][N];
  for (uint32_t i = 0; i < N; i++) {
    pktrt_sample(&sampling, (uint32_t)p, 0, i, 0, 12, u[i]);
    const float to[3] = {(float)(p % SIZE) + u[i][0] - SIZE / 2, SIZE / 2 - (float)(p / SIZE) - u[i][1], -SIZE * 7 / 5};
    rays[0][i] = pktrt_make_ray(eye, to);
  }
  for (int b = 0; b < 2; b++) {
    pktrt_intersect_n(scene, rays[b], hits[b], N), pktrt_surface_n(scene, rays[b], hits[b], at, N);
    for (int i = 0; i < N; i++) {
      const float *v = u[i] + 4 + 4 * b, *from = at[i].position;
      const float to[3] = {.38f + .24f * v[0] - from[0], .998f - from[1], .4f + .2f * v[1] - from[2]};
      light[b][i] = .0153f * fmaxf(dot(to, at[i].normal), 0) * fmaxf(to[1], 0) / (dot(to, to) * dot(to, to));
      pktrt_spawn(scene, &rays[b][i], &hits[b][i], to, &shadow[i]), shadow[i].tmax = 0.999f;
      pktrt_map_cosine(v + 2, at[i].normal, way[i]);
    }
    pktrt_occluded_n(scene, shadow, blocked[b], N), pktrt_spawn_n(scene, rays[b], hits[b], way[0], rays[b + 1], N);
  }
  for (int i = 0; i < N; i++)
    for (int c = 0; c < 3; c++) {
      const float lit = blocked[0][i] ? 0 : light[0][i], by = blocked[1][i] ? 0 : light[1][i] * tint(&hits[1][i])[c];
      pixels[p][c] += tints[LAMP][c] * (hits[0][i].mesh == LAMP ? 1 : tint(&hits[0][i])[c] * (lit + by));
    }
}

int main(void) {
  static pktrt_mesh_desc mesh;
  static pktrt_instance_desc thing;
  ex_threads threads = ex_threads_of(ex_processors());
  for (int i = 0; i < 90; i++) cube[i] = (float)("273267023031457476046062137175"[i / 3] >> i % 3 & 1);
  mesh.positions = cube, mesh.vertex_count = 30, mesh.triangle_count = 10;
  pktrt_scene *scene = pktrt_scene_create(NULL);
  bool ok = scene && !pktrt_add_model(scene, &mesh, 1, NULL);
  for (int i = 0; ok && i <= LAMP; i++) thing.transforms = places[i], ok = !pktrt_add_instance(scene, &thing, NULL);
  if (!ok || pktrt_commit(scene)) return ex_fail("%s", pktrt_last_error(scene)), 1;
  ex_parallel_for(&threads, SIZE * SIZE, shade, scene), ex_threads_stop(&threads);
  return pktrt_scene_destroy(scene), ex_write_picture("out/cornell.png", pixels[0], SIZE, SIZE) ? 0 : 1;
}
