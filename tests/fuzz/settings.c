/* Materials, lights and all settings of a render, good and bad: refused where the header says so, and nothing is painted; else
   every pixel is painted, is finite if what shines is, and has the bits of the scalar single-ray picture. */
#include "fuzz.h"

enum { W = 8, H = 8, SAMPLES = 3, DEPTH = 4, PAINTED = 64, PASSES = 4, ROUNDS = 5 }; /* PAINTED: samples of a pass */

typedef struct picture {
  float pixels[H * (W * 3 + 5)], depth[W * H], normal[W * H * 3], albedo[W * H * 3];
  uint32_t count[W * H];
  float pixel_error[W * H], block_error; /* of one block */
} picture;

typedef struct setting { /* all that is taken from the feed */
  pktrt_material material[3];
  pktrt_light light[3];
  pktrt_render_desc d;
  uint32_t materials, lights, mesh_material[3], fail_at;
  bool tame;                                    /* nothing shines so brightly that sums could overflow */
  uint32_t watched;                             /* 1: cost is asked for; 2: hooks look at packets */
  bool cancel, buffers, parallel, hook, errors; /* hook: the hook `pass`; errors: they are wanted */
  float vertex[2][8 * 3];
} setting;

/* --- the scene: a floor, a box and a triangle that moves --- */

static pktrt_status add_meshes(pktrt_scene *s, const setting *x) {
  static const float square[12] = {-4, 0, -4, -4, 0, 4, 4, 0, 4, 4, 0, -4};
  static const uint32_t two[6] = {0, 1, 2, 0, 2, 3};
  static const uint32_t box[36] = {
      0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
  pktrt_mesh_desc m[3];
  memset(m, 0, sizeof m);
  m[0].positions = square, m[0].vertex_count = 4, m[0].indices = two, m[0].triangle_count = 2;
  m[1].positions = m[1].normals = x->vertex[0], m[1].vertex_count = 8, m[1].indices = box, m[1].triangle_count = 12;
  m[2].positions = x->vertex[1], m[2].vertex_count = 3, m[2].triangle_count = 1, m[2].key_count = 2;
  pktrt_status st = PKTRT_OK;
  for (int i = 0; i < 3 && !st; i++) {
    m[i].material = x->mesh_material[i];
    st = pktrt_add_mesh(s, &m[i], NULL);
  }
  return st;
}

static pktrt_scene *build(const setting *x, fuzz_memory *memory, pktrt_isa isa) {
  const pktrt_scene_desc d = fuzz_scene_desc(memory, isa, x->parallel);
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!s || add_meshes(s, x)) return NULL;
  for (uint32_t i = 0; i < x->materials; i++)
    if (pktrt_add_material(s, &x->material[i], NULL)) return NULL;
  for (uint32_t i = 0; i < x->lights; i++)
    if (pktrt_add_light(s, &x->light[i], NULL)) return NULL;
  return pktrt_commit(s) == PKTRT_OK ? s : NULL;
}

static bool moderate(const float *x, int n) { /* also: not NaN */
  for (int i = 0; i < n; i++)
    if (!(fabsf(x[i]) <= 1e6f)) return false;
  return true;
}

static void take_scene(feed *b, setting *x) {
  bool good;
  for (int i = 0; i < 8 * 3; i++) x->vertex[0][i] = (float)(i / 3 >> (2 - i % 3) & 1) * 2 - 1 + take_tame(b) / 16;
  for (int i = 1; i < 8 * 3; i += 3) x->vertex[0][i] += 1.5f;
  take_tames(b, x->vertex[1], 18);
  for (uint32_t i = 0, n = take_below(b, 4); i < n; i++) {
    x->material[x->materials] = fuzz_material(b, &good);
    if (good) x->tame &= moderate(x->material[x->materials++].emission, 3);
  }
  for (uint32_t i = 0, n = take_below(b, 4); i < n; i++) {
    x->light[x->lights] = fuzz_light(b, &good);
    const pktrt_light *l = &x->light[x->lights];
    if (good) x->tame &= moderate(l->intensity, 3), x->lights++;
  }
  for (int i = 0; i < 3; i++) x->mesh_material[i] = take_below(b, 16) ? take_u8(b) % (x->materials + 1) : take_u8(b);
}

/* --- settings --- */

static int take_word(feed *b, int count) { /* an enumerator, seldom none */
  const int x = (int)take_u8(b);
  return x == 255 ? -1 : x == 254 ? count : x == 253 ? INT32_MAX : x % count;
}
static uint32_t take_number(feed *b, uint32_t usual, uint32_t limit) {
  const uint32_t x = take_u8(b);
  return x < 240 ? x % usual : x < 245 ? limit : x < 250 ? limit + 1 : take_u32(b);
}
static float take_or(feed *b, float usual) { return take_below(b, 8) ? usual : take_float(b); }

static void take_camera(feed *b, pktrt_camera *c) {
  take_tames(b, c->eye, 3), take_tames(b, c->target, 3), take_tames(b, c->up, 3);
  c->moving = take_below(b, 3) == 0;
  if (c->moving) take_tames(b, c->eye_end, 3), take_tames(b, c->target_end, 3), take_tames(b, c->up_end, 3);
  c->fov_y = take_or(b, (float)take_below(b, 180));
  c->time = take_or(b, (float)take_below(b, 17) / 16);
  c->shutter = take_or(b, (1 - c->time) * (float)take_below(b, 2));
  c->aperture = take_or(b, (float)take_below(b, 4) / 8), c->focus = take_or(b, (float)take_below(b, 16));
  float *const fields[] = {c->eye, c->target, c->up, c->eye_end, c->target_end, c->up_end};
  const uint32_t odd = take_u8(b);
  if (odd > 200) fields[odd % 6][odd / 6 % 3] = take_float(b);
}

static void take_render(feed *b, setting *x) {
  pktrt_render_desc *d = &x->d;
  const uint32_t flags = take_u8(b), sizes = take_u8(b);
  take_camera(b, &d->camera);
  d->width = sizes > 240 ? take_number(b, 9, 65536) : 1 + sizes % W,
  d->height = sizes > 240 ? take_number(b, 9, 65536) : 1 + sizes / W % H;
  d->row_stride = flags & 1 ? 0 : (size_t)d->width * 3 + take_below(b, 7) - 1;
  d->mode = (pktrt_mode)take_word(b, 3), d->path = (pktrt_path)take_word(b, 3),
  d->normals = (pktrt_normals)take_word(b, 2);
  d->shadows = (pktrt_shadow_packets)take_word(b, 2), d->sampler = (pktrt_sampler)take_word(b, PKTRT_SAMPLER_COUNT);
  d->assembly = (pktrt_assembly)take_word(b, 6), d->branching = (pktrt_branching)take_word(b, 4);
  d->lights = (pktrt_light_choice)take_word(b, 3), d->glass_shadows = (pktrt_glass_shadows)take_word(b, 2);
  d->phong_mapping = (pktrt_phong_mapping)take_word(b, 2);
  d->packet_size = take_below(b, 16) ? (uint32_t) "\0\2\4\10\20"[take_below(b, 5)] : take_u8(b);
  d->tile_size = take_number(b, 9, 1024), d->samples = take_number(b, 4, 65536), d->max_depth = take_number(b, 6, 50);
  d->seed = take_u32(b), d->attenuation = take_or(b, (float)take_below(b, 5) / 4 - 0.25f);
  for (int a = 0; a < 3; a++) d->background[a] = take_or(b, 0.5f), d->ambient[a] = take_or(b, 0.1f);
  x->tame &= moderate(d->background, 3) && moderate(d->ambient, 3);
  x->cancel = (flags & 6) == 6, x->buffers = flags >> 3 & 1, x->parallel = flags >> 4 & 1;
  x->fail_at = flags >> 5 == 7 ? 1 + take_below(b, 12) : 0;
}

/* A sampler of its own, which now and then leaves [0,1). */
static float odd_numbers(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  const uint32_t n = (x * 7 + y * 13 + sample * 31 + dimension * 61 + seed) * 2654435761u;
  (void)user;
  return n >> 28 == 0 ? NAN : n >> 28 == 1 ? -INFINITY : n >> 28 == 2 ? 1.0f : (float)(n >> 8) / 16777216;
}

/* After all else: inputs from before there were passes mean what they meant. */
static void take_rules(feed *b, setting *x) {
  pktrt_render_desc *d = &x->d;
  const uint32_t flags = take_u8(b), odd = take_u8(b);
  d->passes = take_number(b, PASSES + 1, 65536);
  if (flags & 1) d->target_error = take_or(b, (float)take_below(b, 16) / 64);
  if (flags & 2) d->time_budget = (double)take_or(b, (float)take_below(b, 8) + 0.5f);
  d->adaptive = (flags & 12) == 12;
  if (odd > 128) d->measure = (pktrt_error_measure)take_word(b, 2);
  x->hook = (flags & 48) == 48, x->errors = flags >> 6 & 1;
  const uint32_t watched = take_u8(b); /* inputs from before pictures could be watched have none */
  x->watched = watched & 3;
  if (watched & 4) d->custom_sampler = odd_numbers;
  d->paper_steps = take_u8(b), d->cost_of = (pktrt_cost)(watched & 8 ? take_word(b, 3) : 0);
  for (int i = 0; watched & 16 && i < 4; i++) d->trace_area[i] = take_number(b, 8, 65536);
  if (!(watched & 32)) return;
  d->camera.projection = (pktrt_projection)take_word(b, 2);
  d->camera.width = take_or(b, (float)take_below(b, 9) / 2);
  for (int i = 0; i < 2; i++) d->camera.shift[i] = take_or(b, (float)take_below(b, 9) / 8 - 0.5f);
}

/* --- which settings are good: what the header's comments say --- */

static bool in(float x, float lo, float hi) { return x >= lo && x <= hi; } /* false for NaN */
static bool word(int x, int count) { return x >= 0 && x < count; }

/* 1: there is a view; 0: there is none; -1: up is so nearly parallel to it that either will do. */
static int view(const float eye[3], const float target[3], const float up[3]) {
  double f[3], u[3], lf = 0, lu = 0, r2 = 0;
  const bool plain = up[0] == 0 && up[1] == 0 && up[2] == 0;
  for (int a = 0; a < 3; a++) {
    f[a] = (double)target[a] - (double)eye[a], u[a] = (double)up[a];
    lf = fmax(lf, fabs(f[a])), lu = fmax(lu, fabs(u[a]));
  }
  if (lf == 0 || plain) return lf != 0; /* another up is taken */
  for (int a = 0; a < 3; a++) f[a] /= lf, u[a] /= lu;
  const double n = (f[0] * f[0] + f[1] * f[1] + f[2] * f[2]) * (u[0] * u[0] + u[1] * u[1] + u[2] * u[2]);
  for (int a = 0; a < 3; a++) {
    const int p = (a + 1) % 3, q = (a + 2) % 3;
    const double c = f[p] * u[q] - f[q] * u[p];
    r2 += c * c / n;
  }
  return r2 > 2e-12 ? 1 : r2 < 0.5e-12 ? 0 : -1;
}

static int good_camera(const pktrt_camera *c) {
  const float *const vectors[] = {c->eye, c->target, c->up, c->eye_end, c->target_end, c->up_end};
  for (int i = 0; i < (c->moving ? 18 : 9); i++)
    if (!in(vectors[i / 3][i % 3], -PKTRT_MAX_COORD, PKTRT_MAX_COORD)) return 0;
  if (!(c->fov_y >= 0 && c->fov_y < 180) || !in(c->time, 0, 1) || !(c->shutter >= 0)) return 0;
  if (!in(c->aperture, 0, PKTRT_MAX_COORD) || !in(c->focus, 0, PKTRT_MAX_COORD)) return 0;
  if (!word((int)c->projection, 2) || !fuzz_all_finite(c->shift, 2)) return 0;
  if (c->projection == PKTRT_PROJECTION_ORTHOGRAPHIC && !(c->width > 0 && c->width <= PKTRT_MAX_COORD)) return 0;
  const double end = (double)c->time + (double)c->shutter; /* may be beyond 1 by rounding */
  if (!(end <= 1 + 2e-6)) return 0;
  const bool same = c->up_end[0] == 0 && c->up_end[1] == 0 && c->up_end[2] == 0;
  const int first = view(c->eye, c->target, c->up);
  const int last = c->moving ? view(c->eye_end, c->target_end, same ? c->up : c->up_end) : 1;
  return first == 0 || last == 0 ? 0 : first < 0 || last < 0 || end > 1 ? -1 : 1;
}

static bool good_rules(const setting *x) {
  const pktrt_render_desc *d = &x->d;
  const bool target = d->target_error > 0, time = d->time_budget > 0;
  if (!(d->target_error >= 0 && d->time_budget >= 0) || !word((int)d->measure, 3)) return false;
  if (d->passes > 65536 || (uint64_t)d->passes * d->samples > UINT32_MAX) return false;
  if (d->passes == 1 && (target || d->adaptive)) return false;
  return !d->adaptive || d->passes || target || time || x->hook;
}

static int good_settings(const setting *x) {
  const pktrt_render_desc *d = &x->d;
  const uint32_t p = d->packet_size;
  bool ok = d->width >= 1 && d->width <= 65536 && d->height >= 1 && d->height <= 65536 && d->pixels != NULL;
  ok &= d->row_stride == 0 || d->row_stride >= (size_t)d->width * 3;
  ok &= p == 0 || p == 2 || p == 4 || p == 8 || p == 16;
  ok &= d->tile_size <= 1024 && d->samples <= 65536 && d->max_depth <= PKTRT_MAX_DEPTH && d->attenuation <= 1;
  ok &= word((int)d->mode, 3) && word((int)d->path, 3) && word((int)d->normals, 2) && word((int)d->shadows, 2) &&
        word((int)d->sampler, PKTRT_SAMPLER_COUNT + (d->custom_sampler != NULL)) && word((int)d->assembly, 6) &&
        word((int)d->branching, 4) && word((int)d->lights, 3) && word((int)d->glass_shadows, 2) &&
        word((int)d->phong_mapping, 2) && word((int)d->cost_of, 3);
  ok &= fuzz_all_finite(d->background, 3) && fuzz_all_finite(d->ambient, 3);
  for (int a = 0; a < 3; a++) ok &= d->background[a] >= 0 && d->ambient[a] >= 0;
  ok &= good_rules(x);
  for (int i = 0; i < 3; i++) ok &= x->mesh_material[i] <= x->materials;
  for (uint32_t i = 0; i < x->lights; i++) ok &= x->light[i].kind != PKTRT_LIGHT_MESH || x->light[i].mesh < 3;
  return ok ? good_camera(&d->camera) : 0;
}

/* --- pictures --- */

static void blank(picture *p) {
  float *const f = p->pixels;
  for (size_t i = 0; i < COUNT(p->pixels); i++) f[i] = -7;
  for (size_t i = 0; i < COUNT(p->depth); i++) p->depth[i] = -7, p->count[i] = 7;
  for (size_t i = 0; i < COUNT(p->normal); i++) p->normal[i] = p->albedo[i] = -7;
  for (size_t i = 0; i < COUNT(p->pixel_error); i++) p->pixel_error[i] = -7;
  p->block_error = -7;
}

/* The user of all hooks: a clock of whole seconds, and an end to what may go on for long. */
typedef struct pacer {
  double now;
  uint32_t rounds, seen;
} pacer;
static double pace(void *user) { return ((pacer *)user)->now++; }
static bool few_rounds(void *user, const pktrt_report *r) {
  ((pacer *)user)->rounds = r->rounds;
  return r->rounds < ROUNDS;
}

/* Rules as they were asked for. Where they may go on for long the hook ends it, which is a rule of its own. */
static void rule(const setting *x, pktrt_render_desc *d, pacer *p, pktrt_report *report, picture *to) {
  memset(p, 0, sizeof *p);
  d->seconds = pace, d->user = p, d->report = report;
  if (x->hook || d->passes > PASSES || d->target_error > 0 || d->time_budget > 0) d->pass = few_rounds;
  if (x->errors) d->pixel_error = to->pixel_error, d->block_error = &to->block_error;
}

static void point_at(pktrt_render_desc *d, picture *p, bool buffers) {
  blank(p);
  d->pixels = p->pixels;
  if (buffers) d->depth = p->depth, d->normal = p->normal, d->albedo = p->albedo, d->sample_count = p->count;
}

static const char *bad_pixels(const pktrt_render_desc *d, const picture *p, bool tame) {
  const size_t w = (size_t)d->width * 3, stride = d->row_stride ? d->row_stride : w;
  for (size_t i = 0; i < COUNT(p->pixels); i++) {
    const bool inside = i / stride < d->height && i % stride < w;
    const bool unpainted = p->pixels[i] == -7 && d->background[i % stride % 3] >= 0 && d->ambient[i % stride % 3] >= 0;
    if (!inside && p->pixels[i] != -7) return "A float outside the picture is painted.";
    if (inside && unpainted) return "A pixel is not painted.";
    if (inside && tame && !isfinite(p->pixels[i])) return "A pixel is not finite.";
  }
  return NULL;
}

static bool say_no(void *user, float done) {
  (void)user;
  return done > 2; /* never */
}

/* Bad settings: refused by both calls, and nothing is painted. */
static const char *refuse(pktrt_scene *s, const pktrt_render_desc *d, const picture *p, bool broken) {
  pktrt_status st = pktrt_render(s, d);
  if (broken) st = PKTRT_OK; /* the control */
  const bool limit = st == PKTRT_LIMIT && d->tile_size && d->width / d->tile_size > 30000;
  if (st != PKTRT_INVALID_ARGUMENT && !limit) return "Bad settings are not refused.";
  for (size_t i = 0; i < COUNT(p->pixels); i++)
    if (p->pixels[i] != -7) return "A render that is refused paints.";
  if (pktrt_render_tile(s, d, 0, 0, 1, 1) != st) return "A tile of bad settings is not refused.";
  return fuzz_no_sentence(s);
}

/* Returns the samples per pixel and pass. */
static uint32_t samples_of(const pktrt_render_desc *d) {
  if (d->samples) return d->samples;
  if (d->passes || d->target_error > 0 || d->time_budget > 0 || d->adaptive) return 1;
  return d->mode == PKTRT_MODE_DRT ? 16 : 4;
}

/* A picture's settings, of a size that takes no time. */
static void shrink(pktrt_render_desc *d) {
  const size_t gap = d->row_stride ? d->row_stride - (size_t)d->width * 3 : 0;
  d->width = d->width < W ? d->width : W, d->height = d->height < H ? d->height : H;
  if (d->row_stride) d->row_stride = (size_t)d->width * 3 + (gap < 5 ? gap : 5);
  if (d->samples > SAMPLES) d->samples = SAMPLES;
  if (d->adaptive && d->passes > PASSES) d->passes = PASSES; /* rounds grow */
  while (d->height > 1 && d->width * d->height * samples_of(d) > PAINTED) d->height--;
  while (d->width > 1 && d->width * d->height * samples_of(d) > PAINTED) d->width--;
  if (!d->max_depth || d->max_depth > DEPTH) d->max_depth = DEPTH;
}

static const char *bad_report(const pktrt_render_desc *d, const pktrt_report *r, uint64_t samples) {
  const double pixels = (double)d->width * d->height, each = samples_of(d);
  if (fabs((double)samples - r->samples_mean * pixels) > 0.25) return "Samples are counted wrongly.";
  if (r->samples_min > r->samples_mean || r->samples_mean > r->samples_max || r->samples_min < each)
    return "The samples of the report are none.";
  if (!r->rounds || r->stop == PKTRT_STOP_NOT_YET || r->stop > PKTRT_STOP_ASKED)
    return "A render ends without a reason.";
  const double known = pixels - (double)r->unknown;
  if (known < 0 || !(r->rmse >= 0) || !(r->relative_mse >= 0)) return "The error of a picture is none.";
  if ((r->rmse < INFINITY) != (r->samples_min > each && known > 0)) return "What is known of the error is not so.";
  return NULL;
}

static void see_packet(void *user, const pktrt_packet *p) {
  pacer *q = user;
  for (uint32_t i = 0; i < p->n; i++)
    q->seen += p->x[i] + p->y[i] + p->sample[i] + (p->origin[0][i] > p->direction[0][i]);
}
static void see_event(void *user, const pktrt_event *e) { ((pacer *)user)->seen += (uint32_t)e->kind + e->tested; }

static const char *paint(pktrt_scene *s, fuzz_memory *memory, setting *x, const picture *want, bool broken) {
  picture got;
  pktrt_render_desc d = x->d;
  pktrt_stats stats;
  pktrt_report report;
  pacer p;
  memset(&stats, 0, sizeof stats), memset(&got, 0, sizeof got), memset(&report, 0, sizeof report);
  point_at(&d, &got, x->buffers);
  rule(x, &d, &p, &report, &got);
  d.stats = &stats;
  float cost[W * H];
  if (x->watched & 1) d.cost = cost;
  if (x->watched & 2) d.packet = see_packet, d.trace = see_event;
  if (x->cancel) d.progress = say_no;
  memory->fail_at = x->fail_at;
  const pktrt_status st = pktrt_render(s, &d);
  memory->fail_at = 0;
  if (st == PKTRT_OUT_OF_MEMORY && memory->failed) return fuzz_no_sentence(s);
  if (st == PKTRT_CANCELLED && x->cancel) return fuzz_no_sentence(s);
  if (st != PKTRT_OK) return "Good settings are refused.";
  if (broken) got.pixels[0] += 1, got.count[0] = 1000; /* the control */
  const char *wrong = bad_report(&d, &report, stats.samples);
  if (wrong) return wrong;
  return same_bits(&got, want, sizeof got) ? NULL
                                           : "The picture has other bits than that of the first set, by single rays.";
}

static const char *paint_alike(setting *x, bool broken) {
  picture want;
  const char *wrong = NULL;
  pktrt_render_desc single = x->d;
  memset(&want, 0, sizeof want);
  bool first = true;
  for (int isa = PKTRT_ISA_SCALAR; isa < PKTRT_ISA_COUNT && !wrong; isa++) {
    fuzz_memory memory;
    if (!pktrt_isa_available((pktrt_isa)isa)) continue;
    pktrt_scene *s = build(x, &memory, (pktrt_isa)isa);
    if (!s) return "A good scene is refused.";
    if (first) {
      first = false;
      pktrt_report report;
      pacer p;
      point_at(&single, &want, x->buffers);
      rule(x, &single, &p, &report, &want);
      single.path = PKTRT_PATH_SINGLE, single.tile_size = 0, single.packet_size = 0;
      if (pktrt_render(s, &single) != PKTRT_OK) wrong = "Good settings are refused.";
      else wrong = bad_pixels(&single, &want, x->tame);
    }
    if (!wrong) wrong = paint(s, &memory, x, &want, broken);
    pktrt_scene_destroy(s);
    if (!wrong && memory.blocks) wrong = "Memory is kept after destroy.";
  }
  return wrong;
}

const char *fuzz_settings(const uint8_t *data, size_t size, bool broken) {
  feed b = {data, size};
  setting x;
  picture painted;
  memset(&x, 0, sizeof x);
  x.tame = true;
  take_render(&b, &x); /* first: bytes that are missing are zeros */
  take_scene(&b, &x);
  point_at(&x.d, &painted, false);
  if (take_below(&b, 64) == 63) x.d.pixels = NULL;
  take_rules(&b, &x);
  const int good = good_settings(&x);
  if (good < 0) return NULL;
  if (good) {
    shrink(&x.d);
    return paint_alike(&x, broken);
  }
  fuzz_memory memory;
  pktrt_scene *s = build(&x, &memory, PKTRT_ISA_AUTO);
  if (!s) return "A good scene is refused.";
  const char *wrong = refuse(s, &x.d, &painted, broken);
  pktrt_scene_destroy(s);
  return wrong;
}
