/* The ray tree and its packets: the paper's figure 3, no ray lost by any assembly, N rays in and N rays out, depth and
   attenuation. */
#include "pictures.h"

/* --- the packets of a render --- */

enum { PACKETS = 64 };
typedef struct packet_log { /* of depth 1 */
  uint32_t packets, rays;
  char text[PACKETS][80];                        /* "shadow 1 2 3 4": numbers from 1 on, sorted */
  uint64_t by[PKTRT_RAY_TYPE_COUNT][8], largest; /* rays by type and depth; largest: packet at any depth */
} packet_log;

static int by_number(const void *a, const void *b) {
  uint32_t x = *(const uint32_t *)a, y = *(const uint32_t *)b;
  return x < y ? -1 : x > y;
}

static void log_packet(void *user, const pktrt_packet *packet) {
  static const char *const name[PKTRT_RAY_TYPE_COUNT] = {"primary", "shadow", "reflection", "refraction", "other"};
  packet_log *l = user;
  const pktrt_ray_type type = packet->type;
  const uint32_t depth = packet->depth, n = packet->n;
  CHECK(n > 0 && type < PKTRT_RAY_TYPE_COUNT, "%u rays of type %d", n, (int)type);
  if (depth < 8) l->by[type][depth] += n;
  if (n > l->largest) l->largest = n;
  if (depth != 1 || !CHECK(n <= 256)) return;
  uint32_t sorted[256], at = 0;
  memcpy(sorted, packet->rays, n * sizeof *sorted);
  qsort(sorted, n, sizeof *sorted, by_number);
  l->rays += n;
  if (l->packets == PACKETS) return;
  char *t = l->text[l->packets++];
  at += (uint32_t)snprintf(t, 80, "%s", name[type]);
  for (uint32_t i = 0; i < n && at < 76; i++) at += (uint32_t)snprintf(t + at, 80 - at, " %u", sorted[i] + 1);
}

static int by_text(const void *a, const void *b) { return strcmp(a, b); }

/* One line, sorted. */
static void log_line(packet_log *l, char *line, size_t size) {
  size_t at = 0;
  qsort(l->text, l->packets, sizeof l->text[0], by_text);
  line[0] = 0;
  for (uint32_t i = 0; i < l->packets && at < size; i++)
    at += (size_t)snprintf(line + at, size - at, "%s%s", i ? "; " : "", l->text[i]);
}

/* --- figure 3 --- */

/* Sixteen quads fill a picture of 4 x 4 pixels; letters say what ray 1 to 16 meets: d diffuse, f floor (diffuse and
   mirror), m metal, g glass, . nothing. order[i] is the pixel of ray i + 1. */
static pktrt_scene *sixteen(const char *letters, const uint32_t order[16]) {
  pktrt_scene *s = stage_open();
  pktrt_material m[4] = {material_of(0.8, PKTRT_SPECULAR_NONE, 0), material_of(0.5, PKTRT_SPECULAR_MIRROR, 0.4),
      material_of(0, PKTRT_SPECULAR_CONDUCTOR, 0), material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0)};
  uint32_t index[4];
  for (int k = 0; k < 3; k++) m[2].ior[k] = 1.4f, m[2].extinction[k] = 3;
  for (int i = 0; i < 4; i++) index[i] = stage_material(s, &m[i]);
  for (uint32_t i = 0; i < 16; i++) {
    const char *kind = strchr("dfmg", letters[i]);
    quad q = quad_of(vec_of(order[i] % 4 - 1.5, 1.5 - order[i] / 4, 0), vec_of(0.45, 0, 0), vec_of(0, 0.45, 0));
    if (kind) stage_quad(s, &q, index[kind - "dfmg"]);
  }
  pktrt_light l = light_of(PKTRT_LIGHT_POINT, 100);
  l.position[2] = 10;
  stage_light(s, &l);
  stage_commit(s);
  return s;
}

static void trace_sixteen(pktrt_scene *s, pktrt_path path, pktrt_assembly assembly, packet_log *log) {
  float got[48];
  pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, 4, 4, got, vec_of(0, 0, 5), vec_of(0, 0, 0));
  d.camera.fov_y = (float)(atan(0.4) * 360 / PI);
  d.path = path, d.assembly = assembly, d.packet_size = 4, d.packet = log_packet, d.user = log;
  memset(log, 0, sizeof *log);
  stage_render(s, &d);
  CHECK(log->by[PKTRT_RAY_PRIMARY][0] == 16 && log->largest >= 16, "sixteen primary rays in one packet");
}

/* Which pixel has which number: a mirror in each pixel by itself tells. */
static void find_order(pktrt_path path, uint32_t order[16]) {
  static const uint32_t rows[16] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  for (uint32_t pixel = 0; pixel < 16; pixel++) {
    char letters[17] = "................";
    uint32_t number = 0;
    packet_log log;
    letters[pixel] = 'm';
    pktrt_scene *s = sixteen(letters, rows);
    trace_sixteen(s, path, PKTRT_ASSEMBLY_RAY_TYPES, &log);
    bool ok = log.packets == 1 && sscanf(log.text[0], "reflection %u", &number) == 1 && number >= 1 && number <= 16;
    if (CHECK(ok, "pixel %u: %u packets, \"%s\"", pixel, log.packets, log.text[0])) order[number - 1] = pixel;
    pktrt_scene_destroy(s);
  }
}

static const char figure[] = "ddddffmmggmmgggg";

static const struct {
  pktrt_assembly assembly;
  const char *packets; /* as section 3.2.1 lists them */
} listed[] = {
    {PKTRT_ASSEMBLY_RUNS, "reflection 11 12; reflection 13 14 15 16; reflection 5 6; reflection 7 8; reflection 9 10; "
                          "refraction 13 14 15 16; refraction 9 10; shadow 1 2 3 4; shadow 5 6"},
    {PKTRT_ASSEMBLY_MATERIALS,
        "reflection 5 6; reflection 7 8 11 12; reflection 9 10 13 14 15 16; refraction 9 10 13 14 15 16; "
        "shadow 1 2 3 4; shadow 5 6"},
    {PKTRT_ASSEMBLY_RAY_TYPES,
        "reflection 5 6 7 8 9 10 11 12 13 14 15 16; refraction 9 10 13 14 15 16; shadow 1 2 3 4 5 6"},
};

static void figure_3(void) {
  char line[4096];
  packet_log log;
  for (int path = PKTRT_PATH_FAST; path <= PKTRT_PATH_PAPER; path++) {
    uint32_t order[16] = {0};
    find_order((pktrt_path)path, order);
    pktrt_scene *s = sixteen(figure, order), *other = sixteen("ddddfmfmggmmgggg", order);
    for (size_t i = 0; i < COUNT(listed); i++) {
      trace_sixteen(s, (pktrt_path)path, listed[i].assembly, &log);
      log_line(&log, line, sizeof line);
      CHECK(strcmp(line, listed[i].packets) == 0, "path %d, assembly %d:\n      %s, not\n      %s", path,
          (int)listed[i].assembly, line, listed[i].packets);
      CHECK(log.rays == 24, "6 shadow, 12 reflection and 6 refraction rays: %u", log.rays);
      trace_sixteen(other, (pktrt_path)path, listed[i].assembly, &log);
      log_line(&log, line, sizeof line);
      bool same = strcmp(line, listed[i].packets) == 0;
      CHECK(!same, "assembly %d: the control: rays 6 and 7 exchanged give other packets", (int)listed[i].assembly);
    }
    trace_sixteen(s, (pktrt_path)path, PKTRT_ASSEMBLY_NONE, &log);
    log_line(&log, line, sizeof line);
    CHECK(log.packets == 24 && log.rays == 24 && strncmp(line, "reflection 10; reflection 11; ", 30) == 0,
        "path %d, none: %u packets: %s", path, log.packets, line);
    trace_sixteen(s, (pktrt_path)path, PKTRT_ASSEMBLY_BLIND, &log);
    log_line(&log, line, sizeof line);
    const char *numbers = strchr(line, ' ');
    CHECK(log.packets == 1 && log.rays == 24 && numbers, "path %d, blind: %u packets: %s", path, log.packets, line);
    CHECK(numbers && strcmp(numbers, " 1 2 3 4 5 5 6 6 7 8 9 9 10 10 11 12 13 13 14 14 15 15 16 16") == 0,
        "path %d, blind:%s", path, numbers);
    pktrt_scene_destroy(s), pktrt_scene_destroy(other);
  }
}

/* Octants: here those of the pixels' quarters, for each type of ray. */
static void figure_3_octants(void) {
  for (int path = PKTRT_PATH_FAST; path <= PKTRT_PATH_PAPER; path++) {
    uint32_t order[16] = {0};
    packet_log log, want;
    char got[4096], line[4096];
    find_order((pktrt_path)path, order);
    memset(&want, 0, sizeof want);
    for (int type = PKTRT_RAY_SHADOW; type <= PKTRT_RAY_REFRACTION; type++) {
      static const char *const makes[] = {"", "df", "fmg", "g"};
      for (uint32_t quarter = 0; quarter < 4; quarter++) {
        uint32_t rays[16], n = 0;
        for (uint32_t i = 0; i < 16; i++) {
          bool here = (order[i] % 4 >= 2) == (quarter % 2 == 1) && (order[i] / 4 >= 2) == (quarter >= 2);
          if (here && strchr(makes[type], figure[i])) rays[n++] = i;
        }
        if (!n) continue;
        pktrt_packet made;
        memset(&made, 0, sizeof made);
        made.type = (pktrt_ray_type)type, made.depth = 1, made.n = n, made.rays = rays;
        log_packet(&want, &made);
      }
    }
    pktrt_scene *s = sixteen(figure, order);
    trace_sixteen(s, (pktrt_path)path, PKTRT_ASSEMBLY_OCTANTS, &log);
    log_line(&log, got, sizeof got), log_line(&want, line, sizeof line);
    CHECK(strcmp(got, line) == 0 && want.packets > 6, "path %d, octants:\n      %s, not\n      %s", path, got, line);
    pktrt_scene_destroy(s);
  }
}

/* A mirror in each pixel, that sends its ray into one of the eight octants. */
static void all_octants(void) {
  packet_log log;
  char line[4096];
  float got[48];
  pktrt_scene *s = stage_open();
  pktrt_material m = material_of(0, PKTRT_SPECULAR_MIRROR, 0.5);
  const uint32_t material = stage_material(s, &m);
  for (int i = 0; i < 16; i++) { /* normals lean by 25 or 65 degrees: a ray along -z goes on upwards or downwards */
    const double x = i & 1 ? -1 : 1, y = i & 2 ? -1 : 1, lean = (i & 4 ? 65 : 25) * PI / 180;
    const vec normal = vec_of(x * sin(lean) * sqrt(0.5), y * sin(lean) * sqrt(0.5), cos(lean));
    const vec side = vec_unit(vec_cross(vec_of(0, 0, 1), normal)), up = vec_cross(normal, side);
    quad q = quad_of(vec_of(i % 4 - 1.5, 1.5 - i / 4, 0), vec_mul(side, 0.2), vec_mul(up, 0.2));
    stage_quad(s, &q, material);
  }
  stage_commit(s);
  for (int path = PKTRT_PATH_FAST; path <= PKTRT_PATH_PAPER; path++) {
    for (int octants = 0; octants < 2; octants++) {
      pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, 4, 4, got, vec_of(0, 0, 400), vec_of(0, 0, 0));
      d.camera.fov_y = (float)(2 * atan(2 / 400.) * 180 / PI), d.max_depth = 1;
      d.path = (pktrt_path)path, d.packet_size = 4, d.packet = log_packet, d.user = &log;
      d.assembly = octants ? PKTRT_ASSEMBLY_OCTANTS : PKTRT_ASSEMBLY_RAY_TYPES;
      memset(&log, 0, sizeof log);
      stage_render(s, &d);
      log_line(&log, line, sizeof line);
      CHECK(log.rays == 16 && log.packets == (octants ? 8 : 1), "path %d: %u rays in %u packets: %s", path, log.rays,
          log.packets, line);
    }
  }
  pktrt_scene_destroy(s);
}

/* Three lights: the sixteen rays to each are a packet, or all of them together. */
static void shadows_together(void) {
  packet_log log;
  char line[4096];
  float got[48];
  pktrt_scene *s = stage_open();
  pktrt_material m = material_of(0.8, PKTRT_SPECULAR_NONE, 0);
  quad q = quad_of(vec_of(0, 0, 0), vec_of(9, 0, 0), vec_of(0, 9, 0));
  stage_quad(s, &q, stage_material(s, &m));
  for (int i = 0; i < 3; i++) {
    pktrt_light l = light_of(PKTRT_LIGHT_POINT, 100);
    l.position[0] = (float)i, l.position[2] = 10;
    stage_light(s, &l);
  }
  stage_commit(s);
  for (int path = PKTRT_PATH_FAST; path <= PKTRT_PATH_PAPER; path++) {
    for (int together = 0; together < 2; together++) {
      pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, 4, 4, got, vec_of(0, 0, 5), vec_of(0, 0, 0));
      d.path = (pktrt_path)path, d.packet_size = 4, d.packet = log_packet, d.user = &log;
      d.shadows = together ? PKTRT_SHADOWS_TOGETHER : PKTRT_SHADOWS_PER_LIGHT;
      memset(&log, 0, sizeof log);
      stage_render(s, &d);
      log_line(&log, line, sizeof line);
      CHECK(log.rays == 48 && log.packets == (together ? 1 : 3) && log.largest == (together ? 48 : 16),
          "path %d: %u rays in %u packets: %s", path, log.rays, log.packets, line);
    }
  }
  pktrt_scene_destroy(s);
}

/* On the paper path a packet sends out its rays alone; on the fast path several do so together. */
static void waves_of_packets(void) {
  enum { N = 32 };
  float *got = stage_pixels(N * N * 3);
  pktrt_scene *s = stage_open();
  pktrt_material m = material_of(0, PKTRT_SPECULAR_MIRROR, 0.5);
  quad wall = quad_of(vec_of(0, 0, 0), vec_of(99, 0, 0), vec_of(0, 99, 0));
  stage_quad(s, &wall, stage_material(s, &m));
  stage_commit(s);
  for (uint32_t edge = 2; edge <= 16; edge *= 2) {
    for (int path = PKTRT_PATH_FAST; path <= PKTRT_PATH_PAPER; path++) {
      packet_log log;
      pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, N, N, got, vec_of(0, 0, 5), vec_of(0, 0, 0));
      memset(&log, 0, sizeof log);
      d.path = (pktrt_path)path, d.packet_size = edge, d.packet = log_packet, d.user = &log;
      stage_render(s, &d);
      const uint32_t want = path == PKTRT_PATH_PAPER ? edge * edge : 256;
      CHECK(log.rays == N * N && log.largest == want, "path %d, packets of %u x %u: %u rays, up to %llu together", path,
          edge, edge, log.rays, (unsigned long long)log.largest);
    }
  }
  pktrt_scene_destroy(s);
  free(got);
}

/* --- a scene with everything that sends rays out --- */

static pktrt_scene *busy(int workers) {
  pktrt_scene_desc sd = scene_desc_of(PKTRT_ISA_AUTO, workers);
  pktrt_scene *s = pktrt_scene_create(&sd);
  if (!CHECK(s != NULL)) abort();
  pktrt_material m[4] = {material_of(0.5, PKTRT_SPECULAR_MIRROR, 0.3), material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0),
      material_of(0.5, PKTRT_SPECULAR_COAT, 0), material_of(0.6, PKTRT_SPECULAR_NONE, 0)};
  mesh ball = mesh_sphere(3, 0, 1), box = mesh_box(), soup = mesh_soup(60, 0.4f, 5);
  quad floor = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 6), vec_of(6, 0, 0));
  mesh_shift(&ball, 1.2f, 0, 0), mesh_place(&box, (float[3]){0.5f, 0.5f, 0.5f}, (float[3]){-1.2f, -0.4f, 0.5f});
  stage_quad(s, &floor, stage_material(s, &m[0]));
  stage_mesh(s, &ball, stage_material(s, &m[1]));
  stage_mesh(s, &box, stage_material(s, &m[2]));
  stage_mesh(s, &soup, stage_material(s, &m[3]));
  pktrt_light l = light_of(PKTRT_LIGHT_POINT, 40), sun = light_of(PKTRT_LIGHT_DIRECTIONAL, 1);
  l.position[0] = -2, l.position[1] = 4, l.position[2] = 3, sun.direction[0] = -1, sun.direction[1] = -2;
  stage_light(s, &l), stage_light(s, &sun);
  stage_commit(s);
  mesh_free(&ball), mesh_free(&box), mesh_free(&soup);
  return s;
}

static pktrt_render_desc busy_view(pktrt_mode mode, float *pixels, uint32_t size) {
  pktrt_render_desc d = stage_view(mode, size, size, pixels, vec_of(0.5, 1.5, 5), vec_of(0, -0.2, 0));
  d.background[0] = 0.5f, d.background[1] = 0.7f, d.background[2] = 0.9f;
  d.max_depth = 6;
  return d;
}

/* Every assembly sends the same rays, and statistics count what the packets hold. (A shadow ray that passes glass
   goes on as more rays than left the surface: here it is stopped.) */
static void no_ray_lost(void) {
  enum { N = 24 };
  float *got = stage_pixels(N * N * 3);
  pktrt_scene *s = busy(0);
  uint64_t want[PKTRT_RAY_TYPE_COUNT][8], tree_depth = 0;
  for (int path = PKTRT_PATH_FAST; path <= PKTRT_PATH_PAPER; path++) {
    for (int i = 0; i <= PKTRT_ASSEMBLY_NONE; i++) {
      packet_log log;
      pktrt_stats stats;
      memset(&log, 0, sizeof log), memset(&stats, 0, sizeof stats);
      pktrt_render_desc d = busy_view(PKTRT_MODE_WRT, got, N);
      d.path = (pktrt_path)path, d.assembly = (pktrt_assembly)i, d.packet = log_packet, d.user = &log, d.stats = &stats;
      d.glass_shadows = PKTRT_GLASS_SHADOWS_BLOCK;
      stage_render(s, &d);
      if (path == PKTRT_PATH_FAST && i == 0) memcpy(want, log.by, sizeof want), tree_depth = stats.tree_depth;
      uint64_t all = 0, counted = 0;
      for (int t = 0; t < PKTRT_RAY_TYPE_COUNT; t++) {
        uint64_t of_type = 0;
        for (int k = 0; k < 8; k++) {
          all += log.by[t][k], of_type += log.by[t][k];
          CHECK(i == PKTRT_ASSEMBLY_BLIND || log.by[t][k] == want[t][k],
              "path %d, assembly %d, type %d, depth %d: %llu rays, not %llu", path, i, t, k,
              (unsigned long long)log.by[t][k], (unsigned long long)want[t][k]);
        }
        counted += stats.by_type[t].rays;
        CHECK(i == PKTRT_ASSEMBLY_BLIND || of_type == stats.by_type[t].rays,
            "path %d, assembly %d, type %d: %llu in packets, %llu counted", path, i, t, (unsigned long long)of_type,
            (unsigned long long)stats.by_type[t].rays);
      }
      for (int k = 0; k < 8; k++) {
        uint64_t packets = 0, wanted = 0;
        for (int t = 0; t < PKTRT_RAY_TYPE_COUNT; t++) packets += log.by[t][k], wanted += want[t][k];
        CHECK(packets == wanted && packets == stats.by_depth[k].rays,
            "path %d, assembly %d, depth %d: %llu rays, %llu counted", path, i, k, (unsigned long long)packets,
            (unsigned long long)stats.by_depth[k].rays);
      }
      CHECK(all == counted && all > 3 * N * N && stats.samples == N * N &&
            stats.by_type[PKTRT_RAY_PRIMARY].rays == N * N);
      CHECK(stats.tree_depth == tree_depth && tree_depth > N * N / 2 && tree_depth < 6 * N * N, "%llu",
          (unsigned long long)stats.tree_depth);
      CHECK((log.largest == 1) == (i == PKTRT_ASSEMBLY_NONE) || log.largest >= 16,
          "path %d, assembly %d: packets of up to %llu", path, i, (unsigned long long)log.largest);
      if (path == 1 && i == 0)
        say("%llu rays for %d samples, mean depth of the tree %.2f", (unsigned long long)all, N * N,
            (double)tree_depth / (N * N));
    }
  }
  pktrt_scene_destroy(s);
  free(got);
}

/* 256 pixels full of mirror, one wave: rays up to its last lane go on in packets that begin anywhere. What is read
   beyond a row, `make sanitize` sees. */
static void full_waves(void) {
  enum { N = 16 };
  float *want = stage_pixels(N * N * 3), *got = stage_pixels(N * N * 3);
  pktrt_scene *s = pktrt_scene_create(NULL);
  pktrt_material m = material_of(0, PKTRT_SPECULAR_MIRROR, 0.5);
  quad wall = quad_of(vec_of(0, 0, 0), vec_of(99, 0, 0), vec_of(0, 99, 0));
  quad back = quad_of(vec_of(0, 0, 7), vec_of(99, 0, 0), vec_of(0, 99, 0));
  stage_quad(s, &wall, stage_material(s, &m)), stage_quad(s, &back, stage_material(s, &m));
  stage_commit(s);
  for (int i = 0; i <= PKTRT_ASSEMBLY_NONE; i++) {
    pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, N, N, i ? got : want, vec_of(0.1, 0.2, 5), vec_of(0, 0, 0));
    pktrt_stats stats;
    memset(&stats, 0, sizeof stats);
    d.ambient[0] = d.ambient[1] = d.ambient[2] = 1, d.max_depth = 3, d.packet_size = 16;
    d.assembly = (pktrt_assembly)i, d.stats = &stats, d.attenuation = -1;
    stage_render(s, &d);
    CHECK(stats.by_depth[1].rays == N * N && stats.by_depth[3].rays == N * N, "assembly %d: %llu, %llu rays", i,
        (unsigned long long)stats.by_depth[1].rays, (unsigned long long)stats.by_depth[3].rays);
    CHECK(!i || memcmp(got, want, N * N * 3 * sizeof *got) == 0, "assembly %d", i);
  }
  pktrt_scene_destroy(s);
  free(want), free(got);
}

/* Rays, hits, samples and depths are the same however many threads count them, and however the picture is cut. */
static void counts_of_threads(void) {
  enum { N = 24 };
  float *got = stage_pixels(N * N * 3);
  pktrt_stats want;
  memset(&want, 0, sizeof want);
  for (int i = 0; i < 6; i++) {
    static const uint32_t tiles[6] = {64, 5, 8, 24, 16, 3};
    pktrt_scene *s = busy(i % 3 ? 3 : 0);
    pktrt_stats stats;
    pktrt_render_desc d = busy_view(i < 3 ? PKTRT_MODE_WRT : PKTRT_MODE_DRT, got, N);
    memset(&stats, 0, sizeof stats);
    d.stats = &stats, d.tile_size = tiles[i], d.samples = 2;
    stage_render(s, &d);
    if (i % 3 == 0) want = stats;
    for (int k = 0; k < PKTRT_RAY_TYPE_COUNT; k++) {
      CHECK(stats.by_type[k].rays == want.by_type[k].rays && stats.by_type[k].hits == want.by_type[k].hits,
          "case %d, type %d", i, k);
    }
    for (int k = 0; k < PKTRT_MAX_DEPTH + 2; k++) {
      CHECK(stats.by_depth[k].rays == want.by_depth[k].rays && stats.by_depth[k].hits == want.by_depth[k].hits,
          "case %d, depth %d", i, k);
    }
    CHECK(
        stats.samples == 2 * N * N && stats.tree_depth == want.tree_depth && want.by_depth[2].rays > 100, "case %d", i);
    stage_render(s, &d); /* added to, never reset */
    CHECK(stats.samples == 4 * N * N && stats.by_depth[2].rays == 2 * want.by_depth[2].rays &&
          stats.tree_depth == 2 * want.tree_depth);
    pktrt_scene_destroy(s);
  }
  free(got);
}

/* --- branching --- */

enum { BOTH, CHOOSE, FIRST, WAYS };
static const pktrt_branching ways[WAYS] = {PKTRT_BRANCHING_BOTH, PKTRT_BRANCHING_CHOOSE, PKTRT_BRANCHING_FIRST};

/* Glass everywhere: by choosing, each hit sends out one ray. */
static void n_in_n_out(void) {
  enum { N = 16, DEPTH = 8 };
  float *got = stage_pixels(N * N * 3);
  pktrt_scene *s = stage_open();
  pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  uint32_t material = stage_material(s, &glass);
  mesh ball = mesh_sphere(3, 0, 1);
  for (int i = 0; i < 5; i++) {
    stage_mesh(s, &ball, material);
    mesh_shift(&ball, i % 2 ? 1.5f : -1, i % 3 ? 0.5f : -1.f, -1.5f);
  }
  stage_commit(s);
  for (int mode = PKTRT_MODE_WRT; mode <= PKTRT_MODE_DRT; mode++) {
    for (int way = 0; way < WAYS; way++) {
      pktrt_stats stats;
      memset(&stats, 0, sizeof stats);
      pktrt_render_desc d = stage_view((pktrt_mode)mode, N, N, got, vec_of(0, 0, 4), vec_of(0, 0, 0));
      d.branching = ways[way];
      if (way == (mode == PKTRT_MODE_DRT ? CHOOSE : BOTH)) d.branching = PKTRT_BRANCHING_BY_MODE; /* that of the mode */
      d.max_depth = DEPTH, d.samples = 4, d.stats = &stats, d.background[0] = 1;
      stage_render(s, &d);
      CHECK(stats.samples == 4 * N * N && stats.by_depth[0].rays == stats.samples);
      size_t more = 0;
      for (int k = 0; k < DEPTH; k++) {
        uint64_t in = stats.by_depth[k].hits, out = stats.by_depth[k + 1].rays;
        bool one = way == CHOOSE || (way == FIRST && k > 0);
        CHECK(one ? in == out : in <= out && out <= 2 * in, "mode %d, way %d, depth %d: %llu rays hit, %llu go on",
            mode, way, k, (unsigned long long)in, (unsigned long long)out);
        more += out > in;
      }
      CHECK(way == CHOOSE ? more == 0 : way == FIRST ? more == 1 : more >= 3, "the control: branching sends more");
      CHECK(stats.by_depth[DEPTH + 1].rays == 0 && stats.by_depth[2].rays > 0);
    }
  }
  pktrt_scene_destroy(s);
  mesh_free(&ball);
  free(got);
}

/* All ways of branching have the same mean, in parts of the picture. */
static void branching_mean(void) {
  pktrt_scene *s = busy(0);
  for (int part = 0; part < 3; part++) {
    pktrt_render_desc d = busy_view(PKTRT_MODE_DRT, NULL, 12);
    d.samples = 4;
    d.camera.fov_y = part == 0 ? 45 : 12;
    if (part == 1) d.camera.target[0] = 1.2f;
    if (part == 2) d.camera.target[0] = 1.8f, d.camera.target[1] = -1;
    estimate e[WAYS];
    for (int way = 0; way < WAYS; way++) {
      d.branching = ways[way];
      e[way] = stage_estimate(s, &d, small_run ? 5 : 16);
    }
    for (int k = 0; k < 3 * (WAYS - 1); k++) {
      const estimate *one = &e[1 + k / 3];
      double error = sqrt(e->error[k % 3] * e->error[k % 3] + one->error[k % 3] * one->error[k % 3]);
      CHECK(fabs(e->mean[k % 3] - one->mean[k % 3]) <= 4 * error + 1e-5, "part %d: both %.5f, way %d %.5f, +- %.5f",
          part, e->mean[k % 3], 1 + k / 3, one->mean[k % 3], error);
      CHECK(error < 0.02 * e->mean[k % 3], "part %d: precise: %.5f +- %.5f", part, e->mean[k % 3], error);
    }
  }
  pktrt_scene_destroy(s);
}

/* A pane that reflects a bright sky before a black floor: F. Following both there is no noise, choosing there is. */
static void branching_noise(void) {
  pktrt_scene *s = stage_open();
  pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0), black = material_of(0, PKTRT_SPECULAR_NONE, 0);
  quad pane = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 2), vec_of(2, 0, 0));
  quad floor = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 20), vec_of(20, 0, 0));
  stage_quad(s, &pane, stage_material(s, &glass)), stage_quad(s, &floor, stage_material(s, &black));
  stage_commit(s);
  for (int way = 0; way < WAYS; way++) {
    pktrt_render_desc d = stage_spot(vec_of(2 * sin(PI * 70 / 180), 2 * cos(PI * 70 / 180), 0), vec_of(0, 0, 0));
    d.background[0] = 1, d.sampler = PKTRT_SAMPLER_RANDOM;
    d.branching = ways[way];
    estimate e = stage_estimate(s, &d, 16);
    double want = fresnel_exact(cos(PI * 70 / 180), 1.5);
    CHECK(agrees(&e, 0, want), "way %d: %.6f +- %.6f, not %.6f", way, e.mean[0], e.error[0], want);
    CHECK(way == CHOOSE ? e.error[0] > 1e-3 : e.error[0] < 1e-6, "way %d: +- %g", way, e.error[0]);
  }
  pktrt_scene_destroy(s);
}

/* Before a black floor the pane's two rays differ, and adaptive passes follow both; where all is alike, only those do
   that all cells get. */
static void adaptive_splitting(void) {
  enum { N = 16, PASSES = 10, SAMPLES = 2 };
  float got[N * N * 3];
  for (int alike = 0; alike < 2; alike++) {
    pktrt_scene *s = stage_open();
    pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0), black = material_of(0, PKTRT_SPECULAR_NONE, 0);
    quad pane = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 20), vec_of(20, 0, 0));
    quad floor = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 90), vec_of(90, 0, 0));
    stage_quad(s, &pane, stage_material(s, &glass));
    if (!alike) stage_quad(s, &floor, stage_material(s, &black));
    stage_commit(s);
    for (int way = 0; way < 2; way++) {
      pktrt_stats stats;
      memset(&stats, 0, sizeof stats);
      pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, N, N, got, vec_of(0, 2, 1), vec_of(0, 0, 0));
      d.background[0] = 1, d.samples = SAMPLES, d.passes = PASSES, d.adaptive = true, d.stats = &stats;
      d.branching = way ? PKTRT_BRANCHING_CHOOSE : PKTRT_BRANCHING_BY_MODE;
      stage_render(s, &d);
      const uint64_t pilots = 2 * SAMPLES * N * N, in = stats.by_depth[0].hits, out = stats.by_depth[1].rays;
      say("%s, %s: %llu rays from %llu", alike ? "alike" : "different", way ? "choosing" : "as passes find",
          (unsigned long long)out, (unsigned long long)in);
      CHECK(in == stats.samples && out == (way        ? in
                                              : alike ? in + pilots
                                                      : 2 * in),
          "%llu rays from %llu", (unsigned long long)out, (unsigned long long)in);
    }
    pktrt_scene_destroy(s);
  }
}

/* --- depth and attenuation: between two mirrors --- */

static pktrt_scene *between_mirrors(double reflectance) {
  pktrt_scene *s = stage_open();
  pktrt_material m = material_of(0.25, PKTRT_SPECULAR_MIRROR, reflectance);
  quad far = quad_of(vec_of(0, 0, -1), vec_of(50, 0, 0), vec_of(0, 50, 0)),
       near = quad_of(vec_of(0, 0, 1), vec_of(0, 50, 0), vec_of(50, 0, 0));
  uint32_t material = stage_material(s, &m);
  stage_quad(s, &far, material), stage_quad(s, &near, material);
  stage_commit(s);
  return s;
}

/* Radiance 0.25 sum of r^k up to the depth; the depth of the tree is that. */
static double bounces(pktrt_scene *s, pktrt_mode mode, uint32_t max_depth, float attenuation, uint64_t *depth) {
  float got[3];
  pktrt_stats stats;
  memset(&stats, 0, sizeof stats);
  pktrt_render_desc d = stage_view(mode, 1, 1, got, vec_of(0, 0, 0), vec_of(0.05, 0, -1));
  d.ambient[0] = 1, d.camera.fov_y = 0.01f;
  d.max_depth = max_depth, d.attenuation = attenuation, d.stats = &stats;
  stage_render(s, &d);
  *depth = stats.tree_depth;
  for (uint64_t k = 0; k <= PKTRT_MAX_DEPTH + 1; k++)
    CHECK(stats.by_depth[k].rays == (k <= stats.tree_depth), "depth %llu", (unsigned long long)k);
  return (double)got[0];
}

static double series(double r, uint64_t depth) { return 0.25 * (1 - pow(r, (double)depth + 1)) / (1 - r); }

static void depth_limit(void) {
  pktrt_scene *s = between_mirrors(0.75);
  for (int mode = PKTRT_MODE_WRT; mode <= PKTRT_MODE_DRT; mode++) {
    for (uint32_t max_depth = 0; max_depth <= 50; max_depth += max_depth < 4 ? 1 : 23) {
      uint64_t depth, want = max_depth ? max_depth : 50;
      double got = bounces(s, (pktrt_mode)mode, max_depth, -1, &depth);
      CHECK(depth == want, "max_depth %u: %llu bounces", max_depth, (unsigned long long)depth);
      CHECK(fabs(got - series((double)0.75f, want)) < 2e-6, "max_depth %u: %.8f, not %.8f", max_depth, got,
          series(0.75, want));
      CHECK(want > 4 || fabs(got - series(0.75, want + 1)) > 1e-3, "the control: one more would show");
    }
  }
  pktrt_scene_destroy(s);
}

static void attenuation(void) {
  static const struct {
    float setting;
    uint64_t depth; /* the largest k with 0.6^k >= setting */
  } c[] = {{0.01f, 9}, {0, 10}, {1 / 256.f, 10}, {0.5f, 1}, {0.7f, 0}, {1, 0}, {1e-6f, 27}, {-1, 50}};
  pktrt_scene *s = between_mirrors(0.6);
  uint64_t depth;
  double full = bounces(s, PKTRT_MODE_WRT, 50, -1, &depth);
  for (size_t i = 0; i < COUNT(c); i++) {
    for (int mode = PKTRT_MODE_WRT; mode <= PKTRT_MODE_DRT; mode++) {
      double got = bounces(s, (pktrt_mode)mode, 50, c[i].setting, &depth), unseen = 0.25 / (1 - 0.6);
      double threshold = c[i].setting == 0 ? 1 / 256. : (double)c[i].setting;
      CHECK(depth == c[i].depth, "attenuation %g: %llu bounces, not %llu", (double)c[i].setting,
          (unsigned long long)depth, (unsigned long long)c[i].depth);
      CHECK(fabs(got - series((double)0.6f, c[i].depth)) < 2e-6, "attenuation %g: %.8f", (double)c[i].setting, got);
      if (threshold > 0)
        CHECK(got < full && full - got < threshold * unseen, "attenuation %g: darker by %g", (double)c[i].setting,
            full - got);
      else CHECK(got == full);
    }
  }
  pktrt_scene_destroy(s);
}

void suite_assembly(void) {
  run("the sixteen rays of the paper's figure 3 give the packets that section 3.2.1 lists", figure_3);
  run("octants part the rays of figure 3 by direction", figure_3_octants);
  run("octants part rays by the signs of all three components", all_octants);
  run("shadow rays of all lights are one packet, or one for each light", shadows_together);
  run("on the paper path a packet sends out its rays alone", waves_of_packets);
  run("every assembly sends the same rays, all of them counted", no_ray_lost);
  run("waves that are full to their last lane go on in packets of any assembly", full_waves);
  run("counts do not depend on threads and tiles", counts_of_threads);
  run("choosing at glass, N rays in are N rays out", n_in_n_out);
  run("choosing at glass has the mean of following both", branching_mean);
  run("choosing at glass is noise that following both does not have", branching_noise);
  run("adaptive passes follow both rays at the first glass where choosing would be noise", adaptive_splitting);
  run("max_depth is the depth of the ray tree", depth_limit);
  run("attenuation cuts off what could add less, and no more", attenuation);
}
