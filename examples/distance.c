/* Signed distance: how far each point of a plane is from a knot, negative inside, as out/distance.png. pktrt_closest_point_n finds
   the distances, pktrt_winding_n tells what is inside. Light bands are a tenth of a unit wide, the dark line is the knot. Pipes,
   offset surfaces and collisions begin with such a field. */
#include "common.h"

#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

enum { ALONG = 400, AROUND = 24, CORNERS = ALONG * AROUND, WIDTH = 480, HEIGHT = 480 };

static const float turn = 6.2831853f;
static const float extent = 4;     /* of the picture, from its middle to a side */
static const float radius = 0.45f; /* of the knot's tube */
static const float band = 0.1f;

static float corners[CORNERS][3];
static uint32_t triangles[2 * CORNERS][3];
static pktrt_point_query queries[WIDTH];
static pktrt_closest closest[WIDTH];
static float points[WIDTH][3];
static int inside[WIDTH];
static float pixels[HEIGHT][WIDTH][3];

/* Finds a point of a trefoil knot, from 0 to 1. */
static void knot(float at, float out[3]) {
  const float angle = turn * at;

  out[0] = sinf(angle) + 2 * sinf(2 * angle);
  out[1] = cosf(angle) - 2 * cosf(2 * angle);
  out[2] = -sinf(3 * angle);
}

static void scale_to_one(float v[3]) {
  const float size = sqrtf(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);

  for (int a = 0; a < 3; a++) v[a] /= size;
}

static void cross(const float x[3], const float y[3], float out[3]) {
  for (int a = 0; a < 3; a++) out[a] = x[(a + 1) % 3] * y[(a + 2) % 3] - x[(a + 2) % 3] * y[(a + 1) % 3];
}

/* Makes a closed tube around the knot: rings of corners, each square between two rings as two triangles. */
static void make_tube(void) {
  for (uint32_t i = 0; i < ALONG; i++) {
    const float at = (float)i / (float)ALONG;
    float middle[3], ahead[3], side[3], up[3];

    knot(at, middle);
    knot(at + 0.001f, ahead);
    for (int a = 0; a < 3; a++) ahead[a] -= middle[a];
    scale_to_one(ahead);
    cross(ahead, middle, side);
    scale_to_one(side);
    cross(side, ahead, up);

    for (uint32_t k = 0; k < AROUND; k++) {
      const float angle = turn * (float)k / (float)AROUND;
      const uint32_t next_ring = (i + 1) % ALONG;
      const uint32_t next = (k + 1) % AROUND;
      const uint32_t square[4] = {i * AROUND + k, i * AROUND + next, next_ring * AROUND + next, next_ring * AROUND + k};
      const uint32_t both[2][3] = {{square[0], square[1], square[2]}, {square[0], square[2], square[3]}};

      for (int a = 0; a < 3; a++)
        corners[square[0]][a] = middle[a] + radius * (cosf(angle) * up[a] - sinf(angle) * side[a]);
      memcpy(triangles[2 * square[0]], both, sizeof both);
    }
  }
}

/* Colours a pixel by its signed distance: warm inside, cool outside, paler far away; bands, and a line at 0. */
static void colour(float distance, float out[3]) {
  static const float warm[3] = {0.95f, 0.45f, 0.12f};
  static const float cool[3] = {0.1f, 0.4f, 0.8f};
  const float *near = distance < 0 ? warm : cool;
  const float size = fabsf(distance);
  const float pale = size / (size + 0.6f);
  const float bands = floorf(size / band);
  const float light = fmodf(bands, 2) < 1 ? 1 : 0.85f;
  const float line = fminf(size * (float)WIDTH / (3 * extent), 1); /* three pixels wide */

  for (int c = 0; c < 3; c++) out[c] = line * light * (near[c] + pale * (0.95f - near[c]));
}

/* Finds the distances of a row of points, and colours it. */
static void draw_row(const pktrt_scene *scene, uint32_t y) {
  for (uint32_t x = 0; x < WIDTH; x++) {
    points[x][0] = extent * (2 * ((float)x + 0.5f) / (float)WIDTH - 1);
    points[x][1] = extent * (1 - 2 * ((float)y + 0.5f) / (float)HEIGHT);
    points[x][2] = 0.4f;
    memcpy(queries[x].point, points[x], sizeof points[x]);
    queries[x].max_distance = INFINITY;
  }
  pktrt_closest_point_n(scene, queries, closest, WIDTH);
  pktrt_winding_n(scene, 0, points[0], NULL, inside, WIDTH);
  for (uint32_t x = 0; x < WIDTH; x++) colour(inside[x] ? -closest[x].distance : closest[x].distance, pixels[y][x]);
}

int main(void) {
  static pktrt_mesh_desc tube;
  pktrt_scene *scene = pktrt_scene_create(NULL);

  if (!scene) return ex_fail("%s", pktrt_last_error(NULL)), 1;
  make_tube();
  tube.positions = corners[0];
  tube.vertex_count = CORNERS;
  tube.indices = triangles[0];
  tube.triangle_count = 2 * CORNERS;
  if (pktrt_add_mesh(scene, &tube, NULL) || pktrt_commit(scene)) return ex_fail("%s", pktrt_last_error(scene)), 1;

  const float middle[3] = {0, 0, 0};
  pktrt_mesh_info info;

  if (pktrt_get_mesh_info(scene, 0, &info) || !info.closed) return ex_fail("the knot has open edges"), 1;
  printf("the knot is closed, of %u triangles, in %u bytes\n", (unsigned)info.triangles, (unsigned)info.bytes);
  (void)pktrt_closest_point(scene, middle, INFINITY, &closest[0]);
  printf("the origin is %.3f away from the knot: at %.3f, %.3f, %.3f, of triangle %u\n", (double)closest[0].distance,
      (double)closest[0].point[0], (double)closest[0].point[1], (double)closest[0].point[2],
      (unsigned)closest[0].triangle);
  for (uint32_t y = 0; y < HEIGHT; y++) draw_row(scene, y);
  pktrt_scene_destroy(scene);
  return ex_write_picture("out/distance.png", pixels[0][0], WIDTH, HEIGHT) ? 0 : 1;
}
