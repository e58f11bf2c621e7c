/* One checksum of what the library answers and of the pictures it makes, to compare processors, compilers and systems:
   `make platforms`. Each part is asked for with every instruction set that runs here, in every way there is, and all must
   agree. Numbers are hashed, not their bytes, whose order differs. Prints a line for each part, one for all of them, and
   the instruction sets. Exit status 1: something disagreed or failed.

   tests/checksum.txt keeps what must come out, and is the only place that does. Where a change of bits is meant,
   `make checksum` writes it anew; `git diff` then shows which parts have changed. */
#include "scenes.h"

/* --- sums --- */

typedef struct sum {
  uint64_t state;
} sum;

static void add_word(sum *s, uint32_t word) {
  s->state = (s->state ^ word) * UINT64_C(0x100000001B3);
  s->state ^= s->state >> 29;
}

static void add_floats(sum *s, const float *x, size_t n) {
  for (size_t i = 0; i < n; i++) {
    uint32_t word;
    memcpy(&word, &x[i], sizeof word);
    add_word(s, word);
  }
}

static void add_hits(sum *s, const pktrt_hit *hit, size_t n) {
  for (size_t i = 0; i < n; i++) {
    add_floats(s, &hit[i].t, 1);
    add_floats(s, &hit[i].u, 1);
    add_floats(s, &hit[i].v, 1);
    add_floats(s, hit[i].normal, 3);
    add_word(s, hit[i].mesh);
    add_word(s, hit[i].triangle);
  }
}

/* --- rays --- */

static struct {
  pktrt_ray ray[RAYS];
  pktrt_hit want[RAYS], got[RAYS];
  bool blocked[RAYS], blocked_too[RAYS];
  float in[9][RAYS], out[6][RAYS];
  uint32_t id[2][RAYS];
} all;

static void ask_soa(const pktrt_scene *s, const pktrt_query_desc *q) {
  pktrt_rays in;
  pktrt_hits out;
  for (int i = 0; i < RAYS; i++) {
    for (int a = 0; a < 3; a++) all.in[a][i] = all.ray[i].origin[a], all.in[3 + a][i] = all.ray[i].direction[a];
    all.in[6][i] = all.ray[i].tmin, all.in[7][i] = all.ray[i].tmax, all.in[8][i] = all.ray[i].time;
  }
  for (int a = 0; a < 3; a++) in.origin[a] = all.in[a], in.direction[a] = all.in[3 + a], out.normal[a] = all.out[3 + a];
  in.tmin = all.in[6], in.tmax = all.in[7], in.time = all.in[8];
  out.t = all.out[0], out.u = all.out[1], out.v = all.out[2], out.mesh = all.id[0], out.triangle = all.id[1];
  pktrt_intersect_soa_ex(s, q, &in, &out, RAYS);
  pktrt_occluded_soa_ex(s, q, &in, all.blocked_too, RAYS);
  for (int i = 0; i < RAYS; i++) {
    all.got[i].t = all.out[0][i], all.got[i].u = all.out[1][i], all.got[i].v = all.out[2][i];
    for (int a = 0; a < 3; a++) all.got[i].normal[a] = all.out[3 + a][i];
    all.got[i].mesh = all.id[0][i], all.got[i].triangle = all.id[1][i];
  }
}

static void ask_single(const pktrt_scene *s) {
  int hits = 0;
  for (int i = 0; i < RAYS; i++) {
    const bool hit = pktrt_intersect(s, &all.ray[i], &all.want[i]);
    all.blocked[i] = pktrt_occluded(s, &all.ray[i]);
    if (hit != all.blocked[i] || hit != (all.want[i].mesh != PKTRT_NONE)) complain("hit and occlusion differ", "");
    hits += hit;
  }
  if (hits < RAYS / 32) complain("hardly any ray hits", "");
}

static uint64_t sum_of_answers(const pktrt_hit *hit, const bool *blocked) {
  sum s = {0};
  add_hits(&s, hit, RAYS);
  for (int i = 0; i < RAYS; i++) add_word(&s, blocked[i]);
  return s.state;
}

/* The answers to all rays, which must be the same in all ways. */
static uint64_t ask(const pktrt_scene *s) {
  static const char *const name[] = {
      "_n", "fast path", "paper path", "paper path, packets of 5", "single path", "_soa", "_soa, paper path"};
  ask_single(s);
  const uint64_t want = sum_of_answers(all.want, all.blocked);
  for (int way = 0; way < 7; way++) {
    pktrt_query_desc q;
    memset(&q, 0, sizeof q);
    memset(all.got, 0x77, sizeof all.got);
    q.path = way == 4 ? PKTRT_PATH_SINGLE : way == 2 || way == 3 || way == 6 ? PKTRT_PATH_PAPER : PKTRT_PATH_FAST;
    q.packet_size = way == 3 ? 5 : 0;
    if (way >= 5) {
      ask_soa(s, &q);
    } else if (way == 0) {
      pktrt_intersect_n(s, all.ray, all.got, RAYS);
      pktrt_occluded_n(s, all.ray, all.blocked_too, RAYS);
    } else {
      pktrt_intersect_ex(s, &q, all.ray, all.got, RAYS);
      pktrt_occluded_ex(s, &q, all.ray, all.blocked_too, RAYS);
    }
    if (sum_of_answers(all.got, all.blocked_too) != want) complain("other answers by ", name[way]);
  }
  return want;
}

static uint64_t part_rest(pktrt_isa isa) {
  pktrt_scene *s = world(isa, false);
  make_rays(all.ray, 10);
  const uint64_t state = ask(s);
  pktrt_scene_destroy(s);
  return state;
}

static uint64_t part_motion(pktrt_isa isa) {
  pktrt_scene *s = world(isa, true);
  make_rays(all.ray, 11);
  const uint64_t state = ask(s);
  pktrt_scene_destroy(s);
  return state;
}

/* Meshes deform, and trees are refitted, then built anew: the same answers. */
static uint64_t part_deformation(pktrt_isa isa) {
  pktrt_scene *s = world(isa, true);
  shape *hill = hills(20, 6 * UNIT / 20 * 20, 0, UNIT / 2, 5), *ball = moved(a_ball(), 2, -UNIT, UNIT / 4, 6);
  make_rays(all.ray, 12);
  ask_single(s);
  const uint64_t before = sum_of_answers(all.want, all.blocked);
  expect(s, pktrt_set_positions(s, 0, 0, hill->position));
  for (uint32_t key = 0; key < 2; key++)
    expect(s, pktrt_set_positions(s, 1, key, ball->position + key * ball->vertex_count * 3));
  expect(s, pktrt_refit(s));
  const uint64_t after = ask(s);
  if (after == before) complain("nothing has changed", "");
  expect(s, pktrt_mark_changed(s));
  expect(s, pktrt_commit(s));
  ask_single(s);
  if (sum_of_answers(all.want, all.blocked) != after) complain("other answers after a rebuild", "");
  free(hill);
  free(ball);
  pktrt_scene_destroy(s);
  return after;
}

/* Rays that leave what was hit. */
static uint64_t part_leaving(pktrt_isa isa) {
  pktrt_scene *s = world(isa, true);
  sum state = {0};
  numbers n = numbers_of(20);
  make_rays(all.ray, 13);
  for (int generation = 0; generation < 2; generation++) {
    ask_single(s);
    for (int i = 0; i < RAYS; i++) {
      pktrt_ray next;
      float direction[3];
      for (int a = 0; a < 3; a++) direction[a] = fixed(pick(&n, -UNIT, UNIT));
      pktrt_spawn(s, &all.ray[i], &all.want[i], direction, &next);
      add_floats(&state, next.origin, 3);
      add_floats(&state, &next.tmin, 1);
      if (all.want[i].mesh != PKTRT_NONE) all.ray[i] = next;
    }
  }
  const uint64_t last = ask(s);
  add_word(&state, (uint32_t)last);
  add_word(&state, (uint32_t)(last >> 32));
  pktrt_scene_destroy(s);
  return state.state;
}

static uint64_t part_samples(pktrt_isa isa) {
  sum state = {0};
  (void)isa;
  for (uint32_t k = 0; k < PKTRT_SAMPLER_COUNT; k++) {
    for (uint32_t i = 0; i < 64; i++) {
      const pktrt_sampling sampling = {(pktrt_sampler)k, 16 + i % 3, SCENES_SEED};
      float u[12], out[3], normal[3] = {0.75f, -0.5f, 0.25f}, axis[3] = {0, 0, -1};
      pktrt_sample(&sampling, i % 5, i / 5, i % 16, i % 7, 12, u);
      add_floats(&state, u, 12);
      pktrt_map_disk(u, out);
      add_floats(&state, out, 2);
      pktrt_map_sphere(u + 2, out);
      add_floats(&state, out, 3);
      pktrt_map_cosine(u + 4, normal, out);
      add_floats(&state, out, 3);
      pktrt_map_phong(u + 6, axis, 10, out);
      add_floats(&state, out, 3);
      pktrt_map_phong_naive(u + 8, axis, 10, out);
      add_floats(&state, out, 3);
      out[0] = pktrt_fresnel_dielectric(u[10], 1.5f), out[1] = pktrt_fresnel_conductor(u[11], 0.25f, 3);
      add_floats(&state, out, 2);
    }
  }
  return state.state;
}

/* --- pictures --- */

enum { PIXELS = WIDTH * HEIGHT, BLOCKS = 2 * 2 };
typedef struct picture {
  float color[PIXELS * 3], depth[PIXELS], normal[PIXELS * 3], albedo[PIXELS * 3], error[PIXELS], block_error[BLOCKS];
  uint32_t count[PIXELS];
} picture;

/* The sum of a picture, which must be the same however it is made. */
static uint64_t see(pktrt_scene *s, pktrt_render_desc d) {
  static const char *const name[] = {"fast path", "paper path", "single path"};
  static picture p;
  uint64_t want = 0;
  for (int way = 0; way < 3; way++) {
    sum state = {0};
    memset(&p, 0, sizeof p);
    d.pixels = p.color, d.depth = p.depth, d.normal = p.normal, d.albedo = p.albedo, d.sample_count = p.count;
    if (d.passes > 1) d.pixel_error = p.error, d.block_error = p.block_error;
    d.path = way == 0 ? PKTRT_PATH_FAST : way == 1 ? PKTRT_PATH_PAPER : PKTRT_PATH_SINGLE;
    d.packet_size = way == 1 ? 16 : 0, d.tile_size = way == 2 ? 17 : 0;
    d.assembly = way == 1 ? PKTRT_ASSEMBLY_RUNS : PKTRT_ASSEMBLY_RAY_TYPES;
    expect(s, pktrt_render(s, &d));
    add_floats(&state, p.color, PIXELS * 3);
    add_floats(&state, p.depth, PIXELS);
    add_floats(&state, p.normal, PIXELS * 3);
    add_floats(&state, p.albedo, PIXELS * 3);
    add_floats(&state, p.error, PIXELS);
    add_floats(&state, p.block_error, BLOCKS);
    for (int i = 0; i < PIXELS; i++) add_word(&state, p.count[i]);
    int seen = 0;
    for (int i = 0; i < PIXELS; i++) seen += p.depth[i] > 0 && p.depth[i] < INFINITY;
    if (seen < (int)(d.width * d.height / 2)) complain("there is hardly anything to be seen", "");
    if (way == 0) want = state.state;
    else if (state.state != want) complain("another picture by the ", name[way]);
  }
  pktrt_scene_destroy(s);
  return want;
}

static uint64_t part_rcs(pktrt_isa isa) { return see(room(isa, HOOKS | SMOOTH), view_of(PKTRT_MODE_RCS, 1)); }
static uint64_t part_wrt(pktrt_isa isa) { return see(room(isa, MIRROR | COAT | SMOOTH), view_of(PKTRT_MODE_WRT, 2)); }
static uint64_t part_wrt_glass(pktrt_isa isa) { return see(room(isa, METAL | GLASS), view_of(PKTRT_MODE_WRT, 1)); }

static uint64_t part_drt(pktrt_isa isa) { /* lens, shutter, lobes, and a camera that moves */
  pktrt_render_desc d = view_of(PKTRT_MODE_DRT, 4);
  d.camera.aperture = 0.25f, d.camera.shutter = 0.5f, d.camera.time = 0.25f;
  d.camera.moving = true;
  d.camera.eye_end[0] = 1.25f, d.camera.eye_end[1] = 4.25f, d.camera.eye_end[2] = 8.25f, d.camera.target_end[1] = 1.5f;
  return see(room(isa, METAL | LOBES | COAT | HOOKS | MOVING), d);
}

static uint64_t part_drt_lights(pktrt_isa isa) {
  pktrt_render_desc d = view_of(PKTRT_MODE_DRT, 2);
  d.environment = sky, d.lights = PKTRT_LIGHTS_ONE_DEEPER;
  return see(room(isa, MIRROR | LAMPS | LOBES), d);
}

static uint64_t part_drt_glass(pktrt_isa isa) {
  pktrt_render_desc d = view_of(PKTRT_MODE_DRT, 2);
  d.camera.aperture = 0.125f;
  return see(room(isa, METAL | GLASS | LAMPS | SMOOTH), d);
}

static uint64_t part_samplers(pktrt_isa isa) {
  sum state = {0};
  for (uint32_t k = 0; k < PKTRT_SAMPLER_COUNT; k++) {
    pktrt_render_desc d = view_of(PKTRT_MODE_DRT, 3 + k % 2);
    d.width = 14, d.height = 12, d.sampler = (pktrt_sampler)k, d.camera.aperture = 0.25f;
    d.phong_mapping = (pktrt_phong_mapping)(k % 2);
    const uint64_t one = see(room(isa, MIRROR | LOBES), d);
    add_word(&state, (uint32_t)one);
    add_word(&state, (uint32_t)(one >> 32));
  }
  return state.state;
}

static uint64_t part_passes(pktrt_isa isa) {
  pktrt_render_desc d = view_of(PKTRT_MODE_DRT, 1);
  d.passes = 3, d.adaptive = true, d.environment = sky;
  return see(room(isa, LAMPS), d);
}

/* --- all parts --- */

static const struct {
  const char *name;
  uint64_t (*of)(pktrt_isa);
  /* clang-format off */
} parts[] = {
    {"queries", part_rest}, {"motion", part_motion}, {"deformation", part_deformation}, {"leaving", part_leaving},
    {"samples", part_samples}, {"rcs", part_rcs}, {"wrt", part_wrt}, {"wrt, glass", part_wrt_glass}, {"drt", part_drt},
    {"drt, lights", part_drt_lights}, {"drt, glass", part_drt_glass}, {"drt, samplers", part_samplers},
    {"drt, passes", part_passes}};
/* clang-format on */

static void print_sum(const char *name, uint64_t state) {
  printf("%-14s %08lx%08lx\n", name, (unsigned long)(state >> 32), (unsigned long)(state & 0xFFFFFFFFu));
  fflush(stdout);
}

int main(void) {
  sum whole = {0};
  for (size_t i = 0; i < sizeof parts / sizeof parts[0]; i++) {
    uint64_t want = 0;
    part_now = parts[i].name;
    for (int isa = PKTRT_ISA_SCALAR, first = 0; isa < PKTRT_ISA_COUNT; isa++) {
      if (!pktrt_isa_available((pktrt_isa)isa)) continue;
      isa_now = pktrt_isa_string((pktrt_isa)isa);
      const uint64_t state = parts[i].of((pktrt_isa)isa);
      if (!first++) want = state;
      else if (state != want) complain("another sum than that of the instruction set before", "");
    }
    print_sum(part_now, want);
    add_word(&whole, (uint32_t)want);
    add_word(&whole, (uint32_t)(want >> 32));
  }
  print_sum("all", whole.state);
  printf("by");
  for (int isa = PKTRT_ISA_SCALAR; isa < PKTRT_ISA_COUNT; isa++) {
    if (pktrt_isa_available((pktrt_isa)isa)) printf(" %s", pktrt_isa_string((pktrt_isa)isa));
  }
  printf("\n");
  return complaints != 0;
}
