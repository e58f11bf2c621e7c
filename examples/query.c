/* Rays without a renderer: measuring a body with the query calls of pktrt.h.

   The body is a torus about the y axis, ring radius 2, tube radius 0.5, as a mesh of 4,608 triangles. Each part below shows one
   call, and where geometry knows the answer it is printed beside the measured one.    cc -O2 examples/query.c -o query -lm */
#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"
#include <math.h>
#include <stdio.h>

#define RING 96u /* vertices along the ring, around the tube */
#define TUBE 24u
#define GRID 256 /* rays along an edge of the grid for the volume */
#define SKY 512  /* directions over a hemisphere */
#define MAP_W 64
#define MAP_H 26

static const float pi = 3.14159265f, ring_radius = 2.0f, tube_radius = 0.5f;
static float positions[RING * TUBE][3];
static uint32_t indices[RING * TUBE * 2][3];

static void make_torus(void) {
  for (uint32_t i = 0; i < RING; i++)
    for (uint32_t j = 0; j < TUBE; j++) {
      const float a = 2 * pi * (float)i / RING, b = 2 * pi * (float)j / TUBE, r = ring_radius + tube_radius * cosf(b);
      float *p = positions[i * TUBE + j];
      p[0] = r * cosf(a), p[1] = tube_radius * sinf(b), p[2] = -r * sinf(a);
      const uint32_t i1 = (i + 1) % RING, j1 = (j + 1) % TUBE;
      uint32_t(*t)[3] = &indices[2 * (i * TUBE + j)]; /* two triangles, counter-clockwise from outside */
      t[0][0] = i * TUBE + j, t[0][1] = i1 * TUBE + j, t[0][2] = i1 * TUBE + j1;
      t[1][0] = i * TUBE + j, t[1][1] = i1 * TUBE + j1, t[1][2] = i * TUBE + j1;
    }
}

static pktrt_ray make_ray(float x, float y, float z, float dx, float dy, float dz) {
  const pktrt_ray ray = {{x, y, z}, 0.0f, {dx, dy, dz}, INFINITY, 0.0f};
  return ray;
}

/* pktrt_intersect finds the nearest triangle; pktrt_spawn leaves it without meeting it again, here into the tube. */
static void wall_thickness(const pktrt_scene *scene) {
  pktrt_ray down = make_ray(ring_radius, 9, 0, 0, -1, 0), inside;
  pktrt_hit entry, leave;
  if (!pktrt_intersect(scene, &down, &entry)) return;
  pktrt_spawn(scene, &down, &entry, down.direction, &inside);
  if (!pktrt_intersect(scene, &inside, &leave)) return;
  printf("pktrt_intersect    down on the tube: triangle %u at t = %.4f, u = %.3f, v = %.3f\n", (unsigned)entry.triangle,
      (double)entry.t, (double)entry.u, (double)entry.v);
  printf("pktrt_spawn        on through it: %.4f thick (a round tube: %.4f)\n", (double)leave.t,
      2.0 * (double)tube_radius);
}

/* pktrt_occluded asks only whether anything is in the way, between tmin and tmax. */
static void line_of_sight(const pktrt_scene *scene) {
  static const float origin[3] = {-4, 0.1f, 0}, goals[2][3] = {{0, 1.2f, 0}, {4, 0.1f, 0}};
  for (int i = 0; i < 2; i++) {
    const float *g = goals[i];
    pktrt_ray ray = make_ray(origin[0], origin[1], origin[2], g[0] - origin[0], g[1] - origin[1], g[2] - origin[2]);
    ray.tmax = 1; /* t is in units of the direction's length: 1 is the goal */
    printf("pktrt_occluded     from (-4, 0.1, 0) to (%g, %g, 0): %s\n", (double)g[0], (double)g[1],
        pktrt_occluded(scene, &ray) ? "blocked" : "free");
  }
}

/* pktrt_intersect_n: many rays at once. Parallel rays up and down over a grid give the volume by thickness. */
static void volume(const pktrt_scene *scene) {
  static pktrt_ray rays[2 * GRID];
  static pktrt_hit hits[2 * GRID];
  const float size = 2 * (ring_radius + tube_radius), cell = size / GRID;
  double sum = 0;
  for (int row = 0; row < GRID; row++) {
    for (int i = 0; i < GRID; i++) {
      const float x = cell * ((float)i + 0.5f) - size / 2, z = cell * ((float)row + 0.5f) - size / 2;
      rays[i] = make_ray(x, 9, z, 0, -1, 0);        /* first surface from above */
      rays[GRID + i] = make_ray(x, -9, z, 0, 1, 0); /* and from below */
    }
    pktrt_intersect_n(scene, rays, hits, 2 * GRID);
    for (int i = 0; i < GRID; i++)
      if (hits[i].mesh != PKTRT_NONE) sum += 18.0 - (double)hits[i].t - (double)hits[GRID + i].t;
  }
  printf("pktrt_intersect_n  volume by %d rays: %.3f (a round torus: %.3f)\n", 2 * GRID * GRID,
      sum * (double)cell * (double)cell, 2.0 * (double)(pi * pi * ring_radius * tube_radius * tube_radius));
}

/* pktrt_occluded_n: how much of its hemisphere a point of the surface sees. Directions follow a spiral around the normal of the
   hit; pktrt_spawn makes the rays that leave the surface, so no distance has to be guessed to step off it. */
static void sky_view(const pktrt_scene *scene) {
  static const char *const names[] = {"outermost", "topmost", "innermost"};
  static const float from[][2] = {{1, 0}, {0, 1}, {-1, 0}}; /* of the tube's centre, in x and y */
  static pktrt_ray rays[SKY];
  static bool blocked[SKY];
  for (int k = 0; k < 3; k++) {
    const pktrt_ray probe = make_ray(ring_radius + from[k][0], from[k][1], 0, -from[k][0], -from[k][1], 0);
    pktrt_hit hit;
    int seen = 0;
    if (!pktrt_intersect(scene, &probe, &hit)) return;
    const float nx = hit.normal[0], ny = hit.normal[1]; /* it has almost no z */
    for (int i = 0; i < SKY; i++) {
      const float h = ((float)i + 0.5f) / SKY, r = sqrtf(1 - h * h), a = 2.39996f * (float)i; /* the golden angle */
      const float s = r * cosf(a), direction[3] = {h * nx - s * ny, h * ny + s * nx, r * sinf(a)};
      pktrt_spawn(scene, &probe, &hit, direction, &rays[i]);
    }
    pktrt_occluded_n(scene, rays, blocked, SKY);
    for (int i = 0; i < SKY; i++) seen += !blocked[i];
    printf("pktrt_occluded_n   the %s point sees %.0f%% of its hemisphere\n", names[k], 100.0 * seen / SKY);
  }
}

/* pktrt_intersect_soa: arrays of coordinates instead of rays; what is left NULL is a default or not wanted. */
static void depth_map(const pktrt_scene *scene) {
  static float origin[3][MAP_W], direction[3][MAP_W], t[MAP_W], ny[MAP_W], unused[2][MAP_W];
  static pktrt_rays rays; /* static: zeroed */
  static pktrt_hits hits;
  for (int a = 0; a < 3; a++) rays.origin[a] = origin[a], rays.direction[a] = direction[a];
  hits.t = t;
  hits.normal[0] = unused[0], hits.normal[1] = ny, hits.normal[2] = unused[1];
  printf("pktrt_intersect_soa  the torus from above, darker where it is steeper:\n");
  for (int row = 0; row < MAP_H; row++) {
    for (int i = 0; i < MAP_W; i++) {
      origin[0][i] = 5.4f * (((float)i + 0.5f) / MAP_W - 0.5f);
      origin[1][i] = 9, direction[1][i] = -1;
      origin[2][i] = 5.4f * (((float)row + 0.5f) / MAP_H - 0.5f);
    }
    pktrt_intersect_soa(scene, &rays, &hits, MAP_W);
    for (int i = 0; i < MAP_W; i++) putchar(t[i] == INFINITY ? ' ' : ny[i] > 0.71f ? '.' : ny[i] > 0.45f ? 'o' : '#');
    putchar('\n');
  }
}

int main(void) {
  pktrt_scene *scene = pktrt_scene_create(NULL);
  static pktrt_mesh_desc torus;
  make_torus();
  torus.positions = &positions[0][0];
  torus.vertex_count = RING * TUBE;
  torus.indices = &indices[0][0];
  torus.triangle_count = RING * TUBE * 2;
  if (pktrt_add_mesh(scene, &torus, NULL) || pktrt_commit(scene)) {
    fprintf(stderr, "error: %s\n", pktrt_last_error(scene));
    return 1;
  }
  wall_thickness(scene);
  line_of_sight(scene);
  volume(scene);
  sky_view(scene);
  depth_map(scene);
  pktrt_scene_destroy(scene);
  return 0;
}
