/* Instances beside the same triangles added directly: time per ray, memory, and what it costs to move one.

     make instances                        in two minutes
     build/instances-bench [--size N] [--rounds N] [--results DIR]

   Ten by ten by ten spheres of 1,024 triangles that do not overlap, each turned and of its own size: as instances of one
   model, at rest and moving between two keys, and as meshes whose vertices are where those of the instances are, with as many
   keys. A ratio is the time of the meshes over that of the instances, or of instances at rest over that of moving ones, in
   one process, on the same rays, in turns: 0.5 means that instances take twice as long. Rays whose mesh differs are counted:
   vertices of the meshes are rounded, those of instances are not.

   Contents: field, rays, racing, moving one, main. */
#include "bench.h"
#include "field.h"

#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

#include <getopt.h>

/* >>field ---------------------------------------------------------------------------------------------------------- */

static field_sphere sphere;

typedef enum way { INSTANCES, MOVING, MESHES, MOVING_MESHES, WAYS } way;

static void expect(pktrt_scene *s, pktrt_status status) {
  if (status != PKTRT_OK) fatal(s ? pktrt_last_error(s) : "no scene");
}

static pktrt_mesh_desc sphere_desc(void) {
  pktrt_mesh_desc d;
  memset(&d, 0, sizeof d);
  d.positions = sphere.positions[0], d.vertex_count = FIELD_VERTICES;
  d.indices = sphere.indices[0], d.triangle_count = FIELD_TRIANGLES, d.key_count = 1;
  return d;
}

static void add_instance(pktrt_scene *s, uint32_t model, uint32_t keys, const float *transforms) {
  pktrt_instance_desc at;
  memset(&at, 0, sizeof at);
  at.model = model, at.key_count = keys, at.transforms = transforms;
  expect(s, pktrt_add_instance(s, &at, NULL));
}

static pktrt_scene *field_of(way w, double *build) {
  static float placed[2][FIELD_VERTICES][3];
  const uint32_t keys = w == MOVING || w == MOVING_MESHES ? 2 : 1;
  pktrt_mesh_desc d = sphere_desc();
  pktrt_scene *s = pktrt_scene_create(NULL);
  uint32_t model = 0;
  if (w <= MOVING) expect(s, pktrt_add_model(s, &d, 1, &model));
  d.positions = placed[0][0], d.key_count = keys;
  for (uint32_t i = 0; i < FIELD_COUNT; i++) {
    float m[2][12];
    field_transforms(i, m);
    if (w <= MOVING) add_instance(s, model, keys, m[0]);
    for (uint32_t k = 0; k < keys && w > MOVING; k++) field_place(&sphere, m[k], placed[k]);
    if (w > MOVING) expect(s, pktrt_add_mesh(s, &d, NULL));
  }
  const double start = ex_seconds();
  expect(s, pktrt_commit(s));
  *build = ex_seconds() - start;
  return s;
}

/* >>rays ----------------------------------------------------------------------------------------------------------- */

typedef enum kind { PRIMARY, MIRROR, DIFFUSE, AO, KINDS } kind;
static const char *const kind_names[KINDS] = {"primary", "mirror", "diffuse", "ao"};

static void make_primary(unsigned size, pktrt_ray *ray) {
  for (unsigned i = 0; i < size * size; i++) {
    const unsigned tile = i / 64, x = tile % (size / 8) * 8 + i % 8, y = tile / (size / 8) * 8 + i / 8 % 8;
    const float origin[3] = {0.5f * (int)FIELD_SIDE - 0.5f, 0.5f * (int)FIELD_SIDE - 0.5f, -0.8f * (int)FIELD_SIDE};
    const float d[3] = {((float)x + 0.5f) / (float)size - 0.5f, ((float)y + 0.5f) / (float)size - 0.5f, 1};
    uint32_t state = i;
    ray[i] = pktrt_make_ray(origin, d);
    ray[i].time = field_random(&state);
  }
}

/* Rays that leave what camera rays hit, a little farther than pktrt_spawn asks for; returns how many. */
static size_t make_secondary(
    const pktrt_scene *s, kind k, size_t n, const pktrt_ray *from, const pktrt_hit *hit, pktrt_ray *out) {
  size_t count = 0;
  for (size_t i = 0; i < n; i++) {
    float unit[3], d[3], q[3], length = 0, facing = 0, around;
    if (hit[i].mesh == PKTRT_NONE) continue;
    for (int a = 0; a < 3; a++) length += hit[i].normal[a] * hit[i].normal[a];
    for (int a = 0; a < 3; a++) unit[a] = hit[i].normal[a] / sqrtf(length), facing += unit[a] * from[i].direction[a];
    for (int a = 0; a < 3 && facing > 0; a++) unit[a] = -unit[a];
    uint32_t state = (uint32_t)i;
    do {
      around = 0;
      for (int a = 0; a < 3; a++) q[a] = 2 * field_random(&state) - 1, around += q[a] * q[a];
    } while (around > 1 || around < 1e-6f);
    for (int a = 0; a < 3; a++)
      d[a] = k == MIRROR ? from[i].direction[a] + 2 * fabsf(facing) * unit[a] : unit[a] + q[a] / sqrtf(around);
    pktrt_spawn(s, &from[i], &hit[i], d, &out[count]);
    for (int a = 0; a < 3; a++) out[count].origin[a] += 1e-4f * unit[a];
    if (k == AO) out[count].tmax = 3;
    count++;
  }
  return count;
}

/* >>racing --------------------------------------------------------------------------------------------------------- */

typedef struct options {
  unsigned size, rounds;
  const char *results;
} options;
enum { MAX_ROUNDS = 64, SINGLES = 16384 };

static void ask(
    const pktrt_scene *s, kind k, bool many, const pktrt_ray *rays, size_t n, pktrt_hit *hit, bool *occluded) {
  if (k == AO && many) pktrt_occluded_n(s, rays, occluded, n);
  else if (many) pktrt_intersect_n(s, rays, hit, n);
  for (size_t i = 0; i < n && !many; i++)
    if (k == AO) occluded[i] = pktrt_occluded(s, &rays[i]);
    else pktrt_intersect(s, &rays[i], &hit[i]);
}

/* Times all ways to have the field, in turns; ns a ray. */
static void race(pktrt_scene *const s[WAYS], const options *o, kind k, bool many, const pktrt_ray *rays, size_t n,
    pktrt_hit *hit, bool *occluded, double ns[WAYS]) {
  static double seconds[WAYS][MAX_ROUNDS];
  for (unsigned r = 0; r < o->rounds; r++)
    for (int w = 0; w < WAYS; w++) {
      const double start = cpu_seconds();
      ask(s[w], k, many, rays, n, hit, occluded);
      seconds[w][r] = cpu_seconds() - start;
    }
  for (int w = 0; w < WAYS; w++) ns[w] = 1e9 * median_of(seconds[w], o->rounds) / (double)n;
}

static size_t differ(pktrt_scene *const s[WAYS], way a, way b, const pktrt_ray *rays, size_t n) {
  size_t other = 0;
  for (size_t i = 0; i < n; i++) {
    pktrt_hit x, y;
    pktrt_intersect(s[a], &rays[i], &x), pktrt_intersect(s[b], &rays[i], &y);
    other += x.mesh != y.mesh;
  }
  return other;
}

static void race_all(pktrt_scene *const s[WAYS], const options *o, results *to) {
  const size_t most = (size_t)o->size * o->size;
  pktrt_ray *primary = (pktrt_ray *)take(most, sizeof *primary), *rays = (pktrt_ray *)take(most, sizeof *rays);
  pktrt_hit *first = (pktrt_hit *)take(most, sizeof *first), *hit = (pktrt_hit *)take(most, sizeof *hit);
  bool *occluded = (bool *)take(most, sizeof *occluded);
  double logs[2][3] = {{0, 0, 0}, {0, 0, 0}};
  make_primary(o->size, primary);
  pktrt_intersect_n(s[MESHES], primary, first, most);
  say(to, "| rays | calls | instances, ns | over meshes | moving instances, ns | over rest | over moving vertices | "
          "other mesh |\n"
          "|---|---|--:|--:|--:|--:|--:|--:|\n");
  csv(to, "rays,calls,instances_ns,moving_ns,meshes_ns,moving_meshes_ns,differ,of\n");
  for (int k = 0; k < KINDS; k++) {
    const size_t n = k == PRIMARY ? most : make_secondary(s[MESHES], (kind)k, most, primary, first, rays);
    if (k == PRIMARY) memcpy(rays, primary, most * sizeof *rays);
    for (int many = 1; many >= 0; many--) {
      double ns[WAYS];
      const size_t count = many || n < SINGLES ? n : (size_t)SINGLES, other = differ(s, INSTANCES, MESHES, rays, count);
      race(s, o, (kind)k, many != 0, rays, count, hit, occluded, ns);
      const double ratio[3] = {ns[MESHES] / ns[INSTANCES], ns[INSTANCES] / ns[MOVING], ns[MOVING_MESHES] / ns[MOVING]};
      for (int i = 0; i < 3; i++) logs[many][i] += log(ratio[i]) / (int)KINDS;
      say(to, "| %s | %s | %.0f | %.2f | %.0f | %.2f | %.2f | %zu of %zu |\n", kind_names[k], many ? "many" : "single",
          ns[INSTANCES], ratio[0], ns[MOVING], ratio[1], ratio[2], other, count);
      csv(to, "%s,%s,%.2f,%.2f,%.2f,%.2f,%zu,%zu\n", kind_names[k], many ? "many" : "single", ns[INSTANCES], ns[MOVING],
          ns[MESHES], ns[MOVING_MESHES], other, count);
    }
  }
  for (int many = 1; many >= 0; many--)
    say(to, "| all | %s | | %.2f | | %.2f | %.2f | |\n", many ? "many" : "single", exp(logs[many][0]),
        exp(logs[many][1]), exp(logs[many][2]));
  free(primary), free(rays), free(first), free(hit), free(occluded);
}

/* >>moving one ----------------------------------------------------------------------------------------------------- */

/* Times moving one of 500 instances beside a static mesh of three million triangles. */
static void move_one(const options *o, results *to) {
  enum { EDGE = 1225 };
  static double seconds[2][MAX_ROUNDS];
  float(*p)[3] = (float(*)[3])take((EDGE + 1) * (EDGE + 1), sizeof *p);
  uint32_t(*quad)[6] = (uint32_t(*)[6])take(EDGE * EDGE, sizeof *quad);
  for (uint32_t i = 0; i < (EDGE + 1) * (EDGE + 1); i++)
    p[i][0] = (float)(i % (EDGE + 1)), p[i][1] = 0.1f * (float)(i % 7), p[i][2] = (float)(i / (EDGE + 1));
  for (uint32_t i = 0; i < EDGE * EDGE; i++) {
    const uint32_t a = i / EDGE * (EDGE + 1) + i % EDGE, b = a + EDGE + 1, both[6] = {a, a + 1, b, a + 1, b + 1, b};
    memcpy(quad[i], both, sizeof both);
  }
  pktrt_mesh_desc ground;
  memset(&ground, 0, sizeof ground);
  ground.positions = p[0], ground.vertex_count = (EDGE + 1) * (EDGE + 1);
  ground.indices = quad[0], ground.triangle_count = 2 * EDGE * EDGE;
  const pktrt_mesh_desc ball = sphere_desc();
  pktrt_scene *s = pktrt_scene_create(NULL);
  uint32_t model;
  float keys[2][12];
  expect(s, pktrt_add_mesh(s, &ground, NULL)), expect(s, pktrt_add_model(s, &ball, 1, &model));
  for (uint32_t i = 0; i < 500; i++) {
    field_transforms(i, keys);
    add_instance(s, model, 1, keys[0]);
  }
  expect(s, pktrt_commit(s));
  for (unsigned r = 0; r < o->rounds; r++)
    for (int refit = 0; refit < 2; refit++) {
      const double start = ex_seconds();
      field_transforms(600 + r, keys);
      expect(s, pktrt_set_transform(s, 7 * r % 500, 0, keys[0]));
      expect(s, refit ? pktrt_refit(s) : pktrt_commit(s));
      seconds[refit][r] = ex_seconds() - start;
    }
  say(to, "\nOne of 500 instances moved beside %u static triangles: %.3f ms with a commit, %.3f ms with a refit.\n",
      2 * EDGE * EDGE, 1e3 * median_of(seconds[0], o->rounds), 1e3 * median_of(seconds[1], o->rounds));
  pktrt_scene_destroy(s);
  free(p), free(quad);
}

/* >>main ----------------------------------------------------------------------------------------------------------- */

static bool parse(int argc, char **argv, options *o) {
  static const struct option names[] = {
      {"size", 1, NULL, 's'}, {"rounds", 1, NULL, 'r'}, {"results", 1, NULL, 'o'}, {NULL, 0, NULL, 0}};
  int key;
  while ((key = getopt_long(argc, argv, "", names, NULL)) != -1) {
    if (key == 's' && (!ex_parse_uint("size", optarg, 8, 4096, &o->size) || o->size % 8))
      return ex_fail("--size: want a multiple of 8 up to 4096");
    if (key == 'r' && !ex_parse_uint("rounds", optarg, 1, MAX_ROUNDS, &o->rounds)) return false;
    if (key == 'o') o->results = optarg;
    if (key == '?') return false;
  }
  return optind == argc || ex_fail("%s: an argument without an option", argv[optind]);
}

int main(int argc, char **argv) {
  options o = {256, 9, NULL};
  pktrt_scene *s[WAYS];
  pktrt_scene_info info[WAYS];
  double build[WAYS];
  results to = {NULL, NULL, NULL, NULL};
  bench_begin(argc, argv);
  if (!parse(argc, argv, &o)) return 2;
  field_make_sphere(&sphere);
  for (int w = 0; w < WAYS; w++) s[w] = field_of((way)w, &build[w]), pktrt_get_scene_info(s[w], &info[w]);
  results_open(&to, o.results, "instances");
  say(&to,
      "%d spheres of %d triangles, %u x %u camera rays, medians of %u rounds. At rest: instances %.2f MB of trees and "
      "meshes,"
      " committed in %.2f ms, meshes %.1f MB, %.0f ms.\n\n",
      FIELD_COUNT, FIELD_TRIANGLES, o.size, o.size, o.rounds, (double)(info[0].tree_bytes + info[0].mesh_bytes) / 1e6,
      1e3 * build[0], (double)(info[2].tree_bytes + info[2].mesh_bytes) / 1e6, 1e3 * build[2]);
  race_all(s, &o, &to);
  move_one(&o, &to);
  results_close(&to);
  for (int w = 0; w < WAYS; w++) pktrt_scene_destroy(s[w]);
  return 0;
}
