/* paper.h - how the results of the paper are measured and written down. What is measured stands in paper.c and
   system.h.

   Contents: options, worlds, measuring, report, setups. */
#ifndef PAPER_H
#define PAPER_H

#include "../bench.h"
#define PKTRT_IMPLEMENTATION
#define PK_FULL_SSE2 /* vectors of four are raced, as in the paper */
#define PK_ALSO_STAMP "bench/kensler_stamp.h"
#include "../../pktrt.h"
#include "../../examples/scenes.h"

enum { MAX_ROUNDS = 64, MAX_FRAMES = 64, MAX_EVERY = 4096, MAX_ROWS = 512, MAX_NAMES = 32 };
enum { TYPES = PKTRT_RAY_TYPE_COUNT };

/* >>options -------------------------------------------------------------------------------------------------------- */

typedef struct options {
  const char *results; /* a directory, NULL: none */
  const char *names[MAX_NAMES];
  unsigned name_count, size, frames, rounds, every;
  bool check, counts, controls;
} options;

/* >>worlds --------------------------------------------------------------------------------------------------------- */

typedef enum finish { AS_MADE, REFLECTIVE } finish;

/* The paper's conference room: "all surfaces are reflective" (5.2), "with a fairly glossy exponent" (5.3). Ours is made
   so, but for its lamps and the city before its windows, which the finish REFLECTIVE gives these: */
#define REFLECTANCE 0.4f
#define EXPONENT 100.0f

#define SHUTTER (1.0 / 240) /* of the animation's loop: open for a whole frame of 240 */
#define SHUTTER_SHUT 1e-9   /* moving meshes keep two keys, which are the same: only their motion is missing */

typedef struct setup { /* how pictures are made: as whitted() and one_frame() fill it in, then changed */
  const char *scene;
  finish look;
  pktrt_mode mode;
  pktrt_path path;
  pktrt_isa isa;
  pktrt_assembly assembly;
  unsigned packet, samples, depth, frames; /* samples: per pixel */
  unsigned root;                           /* tiles of 64 / root pixels a side */
  unsigned every;                          /* of so many tiles one is made */
  float attenuation;
  double aperture, light_size; /* in those of the scene */
  double exponent;             /* of all that reflects but glass; 0: as the scene has it */
  double shutter;              /* DRT: a part of the animation's loop; 0: shut */
  bool united;                 /* DRT: boxes do not move, but hold all that passes while the shutter is open */
  pktrt_sampler sampler;
  pktrt_branching branching;
  pktrt_phong_mapping mapping;
  pktrt_normals normals;
  uint32_t steps;     /* of the paper path, see pktrt_paper_step; 0: all */
  bool differs;       /* makes another picture than the way it is measured beside */
  const char *varied; /* what the CSV file says of this way: NULL, or a word and its value */
  double value;
} setup;

typedef struct varnish { /* the `user` of a texture under a mirror */
  float albedo[3];
  void (*texture)(void *user, const pktrt_points *);
  void *user;
} varnish;

typedef struct world {
  setup of; /* scene NULL: none yet */
  scene made;
  varnish *under;             /* one for each material */
  pktrt_scene *tree, *united; /* the second only once it is asked for */
} world;

/* A texture sees the albedo that its material had before it became a mirror, and the mirror takes its share of what
   the texture made of it, so that no point reflects more than it gets. */
static void varnished(void *user, const pktrt_points *p) {
  const varnish *v = (const varnish *)user;
  for (int c = 0; c < 3; c++)
    for (uint32_t i = 0; i < p->n; i++) p->albedo[c][i] = v->albedo[c];
  v->texture(v->user, p);
  for (int c = 0; c < 3; c++)
    for (uint32_t i = 0; i < p->n; i++) p->albedo[c][i] *= 1 - REFLECTANCE;
}

/* What was only diffuse becomes a glossy mirror in part. (In Whitted's mode lobes reflect as mirrors do.) */
static void make_reflective(pktrt_material *m, varnish *v) {
  if (m->specular != PKTRT_SPECULAR_NONE) return;
  memcpy(v->albedo, m->albedo, sizeof v->albedo);
  v->texture = m->texture, v->user = m->user;
  if (m->texture) m->texture = varnished, m->user = v;
  m->specular = PKTRT_SPECULAR_MIRROR;
  m->lobe = PKTRT_LOBE_PHONG;
  m->exponent = EXPONENT;
  for (int c = 0; c < 3; c++) m->reflectance[c] = REFLECTANCE, m->albedo[c] *= 1 - REFLECTANCE;
}

static void finish_materials(world *w, const setup *s) {
  for (size_t i = 0; i < w->made.material_count; i++) {
    pktrt_material *m = &w->made.materials[i].m;
    if (s->look == REFLECTIVE) make_reflective(m, &w->under[i]);
    if (!(s->exponent > 0) || m->specular == PKTRT_SPECULAR_NONE || m->specular == PKTRT_SPECULAR_DIELECTRIC) continue;
    m->lobe = PKTRT_LOBE_PHONG;
    m->exponent = (float)s->exponent;
  }
}

static bool moves(const setup *s) { return s->mode == PKTRT_MODE_DRT; }

/* Moving meshes have two keys, where they are when the shutter opens and when it closes. */
static pktrt_scene *plant(const world *w) {
  const double shutter = w->of.shutter > 0 ? w->of.shutter : SHUTTER_SHUT;
  pktrt_scene_desc desc;
  memset(&desc, 0, sizeof desc);
  desc.isa = w->of.isa;
  pktrt_scene *tree = pktrt_scene_create(&desc);
  if (!tree) fatal(pktrt_last_error(NULL));
  if (scene_add_at(tree, &w->made, 0, moves(&w->of) ? shutter : 0) != PKTRT_OK || pktrt_commit(tree) != PKTRT_OK)
    fatal(pktrt_last_error(tree));
  return tree;
}

/* The boxes of a tree that knows nothing of time: both keys of each become their union. The library makes no such tree
   and offers no way to change one, hence this look at its nodes. Boxes only grow, so the same hits are found. */
static void unite_bounds(pktrt_scene *tree) {
  for (uint32_t k = 0; k < tree->bvh_count; k++) {
    const pk_bvh *bvh = &tree->bvhs[k];
    for (uint32_t n = 0; bvh->key_count == 2 && n < bvh->node_count; n++) {
      pk_node *node = pk_bvh_node(bvh, n);
      float *p = pk_node_planes(node, 0), *q = pk_node_planes(node, 1);
      for (int i = 0; i < 48; i++) p[i] = q[i] = i / 8 % 2 ? fmaxf(p[i], q[i]) : fminf(p[i], q[i]); /* lo, hi, lo... */
    }
  }
}

static void close_world(world *w) {
  pktrt_scene_destroy(w->tree);
  pktrt_scene_destroy(w->united);
  scene_free(&w->made);
  free(w->under);
  memset(w, 0, sizeof *w);
}

static bool same_world(const setup *a, const setup *b) {
  return a->scene && !strcmp(a->scene, b->scene) && a->look == b->look && a->isa == b->isa && moves(a) == moves(b) &&
         !(a->light_size < b->light_size || a->light_size > b->light_size || a->exponent < b->exponent ||
             a->exponent > b->exponent || (moves(a) && (a->shutter < b->shutter || a->shutter > b->shutter)));
}

/* Scenes are made one at a time: what is next measured on the same one finds it built. */
static void open_setup(world *w, const setup *s) {
  if (!same_world(&w->of, s)) {
    close_world(w);
    w->of = *s;
    if (!scene_make(s->scene, &w->made)) fatal("no such scene, or not enough memory for it");
    if (s->light_size < 1 || s->light_size > 1) scene_resize_lights(&w->made, s->light_size);
    w->under = (varnish *)calloc(w->made.material_count, sizeof *w->under);
    if (!w->under) fatal("not enough memory");
    finish_materials(w, s);
    w->tree = plant(w);
  }
  if (s->united && !w->united) unite_bounds(w->united = plant(w));
}

/* >>measuring ------------------------------------------------------------------------------------------------------ */

static const char *const mode_names[] = {"RCS", "WRT", "DRT"};
static const char *const path_names[] = {"fast", "paper", "single"};
static const char *const assembly_names[] = {"ray types", "runs", "materials", "octants", "blind", "single"};
static const char *const type_names[TYPES] = {"primary", "shadow", "reflection", "refraction", "other"};

typedef struct row {
  setup s;
  pktrt_stats stats;
  pktrt_counts all;                   /* over all types */
  double rounds[MAX_ROUNDS], seconds; /* each, and their median */
  uint64_t checksum;
  double paper, speedup, paper_speedup; /* Mrays/s of the paper; against single rays: ours, the paper's. 0: none */
} row;

typedef struct bench {
  options given;
  results out; /* of this part */
  world now;
  float *pixels;
  row rows[MAX_ROWS];
  size_t row_count;
} bench;

static void describe(bench *b, const setup *s, unsigned frame, pktrt_stats *stats, pktrt_render_desc *d) {
  memset(d, 0, sizeof *d);
  d->width = d->height = b->given.size;
  d->pixels = b->pixels;
  d->mode = s->mode, d->path = s->path, d->packet_size = s->packet, d->assembly = s->assembly;
  d->paper_steps = s->steps;
  d->samples = s->samples, d->max_depth = s->depth, d->attenuation = s->attenuation;
  d->sampler = s->sampler, d->branching = s->branching, d->phong_mapping = s->mapping, d->normals = s->normals;
  d->stats = stats;
  d->camera = b->now.made.camera;
  scene_camera(&b->now.made, (double)frame / s->frames, &d->camera);
  d->camera.time = 0, d->camera.shutter = moves(s) && s->shutter > 0 ? 1 : 0; /* between the keys */
  d->camera.aperture = (float)(s->aperture * (double)d->camera.aperture);
  memcpy(d->background, b->now.made.background, sizeof d->background);
  memcpy(d->ambient, b->now.made.ambient, sizeof d->ambient);
}

/* With `every` 1 a picture of one sample per pixel is whole. Of others some tiles are made, as many of them whatever
   the samples, and where pixels have n x n samples tiles have a side n times smaller, unless a part wants them alike.
   That keeps the size of pixels, and with it the coherence of rays, which a smaller picture would not. The fractions
   are those of the R2 sequence (Roberts 2018), which spreads tiles evenly over the picture and, counted on, over the
   frames. */
static void make_picture(bench *b, const setup *s, unsigned frame, const pktrt_render_desc *d) {
  pktrt_scene *tree = s->united ? b->now.united : b->now.tree;
  const uint32_t edge = 64 / s->root, across = b->given.size / edge, units = b->given.size / 64;
  const uint32_t n = (units * units + s->every - 1) / s->every;
  if (s->every == 1 && s->samples == 1) {
    if (pktrt_render(tree, d) != PKTRT_OK) fatal(pktrt_last_error(tree));
    return;
  }
  for (uint32_t i = 0; i < n; i++) {
    const double k = 0.5 + (double)frame * n + i, u = k * 0.7548776662466927, v = k * 0.5698402909980532;
    const uint32_t x = (uint32_t)((u - floor(u)) * across), y = (uint32_t)((v - floor(v)) * across);
    if (pktrt_render_tile(tree, d, edge * x, edge * y, edge, edge) != PKTRT_OK) fatal("a tile could not be rendered");
  }
}

/* FNV-1a by words: equal sums for equal pictures. */
static uint64_t add_checksum(uint64_t sum, const float *pixels, size_t n) {
  for (size_t i = 0; i < n; i++) {
    uint32_t bits;
    memcpy(&bits, &pixels[i], 4);
    sum = (sum ^ bits) * 1099511628211u;
  }
  return sum;
}

/* All frames of a setup; returns the seconds. */
static double run_once(bench *b, const setup *s, pktrt_stats *stats, uint64_t *checksum) {
  const size_t n = (size_t)b->given.size * b->given.size * 3;
  double seconds = 0;
  *checksum = 14695981039346656037u;
  for (unsigned f = 0; f < s->frames; f++) {
    pktrt_render_desc d;
    describe(b, s, f, stats, &d);
    memset(b->pixels, 0, n * sizeof(float));
    const double start = cpu_seconds();
    make_picture(b, s, f, &d);
    seconds += cpu_seconds() - start;
    *checksum = add_checksum(*checksum, b->pixels, n);
  }
  return seconds;
}

static void add_counts(pktrt_counts *to, const pktrt_counts *c) {
  to->rays += c->rays, to->hits += c->hits;
  to->box_tests += c->box_tests, to->triangle_tests += c->triangle_tests;
  to->node_visits += c->node_visits;
  to->vector_box_tests += c->vector_box_tests, to->vector_triangle_tests += c->vector_triangle_tests;
}

static void count_once(bench *b, row *r, const row *first) {
  run_once(b, &r->s, &r->stats, &r->checksum);
  for (int t = 0; t < TYPES; t++) add_counts(&r->all, &r->stats.by_type[t]);
  if (r->checksum != first->checksum && !r->s.differs) fatal("two ways to trace the same rays made different pictures");
}

/* Measures n ways to make the same picture, on one world, and appends their rows; returns the first. A way whose
   picture differs says so. */
static row *measure(bench *b, const setup *ways, size_t n) {
  row *r = &b->rows[b->row_count];
  if (b->row_count + n > MAX_ROWS) fatal("more rows than there is room for");
  b->row_count += n;
  for (size_t i = 0; i < n; i++) {
    memset(&r[i], 0, sizeof r[i]);
    r[i].s = ways[i];
    open_setup(&b->now, &ways[i]);
    count_once(b, &r[i], r);
  }
  for (unsigned k = 0; k < b->given.rounds; k++)
    for (size_t i = 0; i < n; i++) {
      const size_t turn = (i + k) % n; /* so that nobody always runs after the same one */
      uint64_t checksum;
      r[turn].rounds[k] = run_once(b, &ways[turn], NULL, &checksum);
      if (checksum != r[turn].checksum) fatal("the same rays made another picture the second time");
    }
  for (size_t i = 0; i < n; i++) {
    double seconds[MAX_ROUNDS];
    memcpy(seconds, r[i].rounds, sizeof seconds);
    r[i].seconds = b->given.rounds ? median_of(seconds, b->given.rounds) : 0;
  }
  if (!b->given.check)
    fprintf(stderr, "%s: %s %s, %s path, %s, packets of %u x %u%s: done\n", b->out.name, ways[0].scene,
        mode_names[ways[0].mode], path_names[ways[0].path], pktrt_isa_string(ways[0].isa), ways[0].packet,
        ways[0].packet, ways[0].packet != ways[n - 1].packet ? " and more" : "");
  return r;
}

static double per_ray(uint64_t tests, const pktrt_counts *c) { return c->rays ? (double)tests / (double)c->rays : 0; }

static uint64_t vector_tests(const pktrt_counts *c) { return c->vector_box_tests + c->vector_triangle_tests; }

/* Of the lanes of the paper path's vectors of tests, those with a ray to test: lane utilisation, 1 to 8. */
static double lanes_used(const pktrt_counts *c) {
  return vector_tests(c) ? (double)(c->box_tests + c->triangle_tests) / (double)vector_tests(c) : 0;
}

static double mrays(const row *r) { return r->seconds > 0 ? 1e-6 * (double)r->all.rays / r->seconds : 0; }

/* The median over rounds, in which both had their turns. */
static double times_as_long(const bench *b, const row *r, const row *other) {
  double ratios[MAX_ROUNDS];
  for (unsigned k = 0; k < b->given.rounds; k++) ratios[k] = r->rounds[k] / other->rounds[k];
  return b->given.rounds ? median_of(ratios, b->given.rounds) : 0;
}

/* In rays per second. */
static double times_as_fast(const bench *b, const row *r, const row *other) {
  return times_as_long(b, other, r) * (double)r->all.rays / (double)other->all.rays;
}

/* Single rays and packets by ray type, side by side, and what the paper has for both; 0: nothing. */
static const row *measure_pair(
    bench *b, const setup *s, double paper_single, double paper_types, double paper_speedup) {
  setup ways[2];
  ways[0] = ways[1] = *s;
  ways[0].assembly = PKTRT_ASSEMBLY_NONE;
  ways[1].assembly = PKTRT_ASSEMBLY_RAY_TYPES;
  row *r = measure(b, ways, 2);
  r[0].paper = paper_single;
  r[1].paper = paper_types;
  r[1].speedup = times_as_fast(b, &r[1], &r[0]);
  r[1].paper_speedup = paper_speedup;
  return r;
}

/* >>report --------------------------------------------------------------------------------------------------------- */

/* A figure, or what stands for none. */
static const char *figure_text(char text[32], double value, int digits, const char *unit, const char *none) {
  if (value > 0) snprintf(text, 32, "%.*f%s", digits, value, unit);
  else snprintf(text, 32, "%s", none);
  return text;
}

static void print_way(const row *r) {
  const bool smooth = r->s.look == REFLECTIVE && r->s.normals == PKTRT_NORMALS_SMOOTH;
  printf("| %s%s | %s", r->s.scene, smooth ? ", smooth" : "", mode_names[r->s.mode]);
  if (r->s.samples > 1) printf(" %u", r->s.samples);
  printf(" | %s | %s | %ux%u | %s |", path_names[r->s.path], pktrt_isa_string(r->s.isa), r->s.packet, r->s.packet,
      assembly_names[r->s.assembly]);
}

static void print_speeds(const bench *b) {
  printf("| scene | mode | path | isa | packets | assembly | rays | Mrays/s | paper | speed-up | paper "
         "| boxes/ray | triangles/ray | seconds |\n"
         "|---|---|---|---|---|---|--:|--:|--:|--:|--:|--:|--:|--:|\n");
  for (size_t i = 0; i < b->row_count; i++) {
    const row *r = &b->rows[i];
    char t[3][32];
    print_way(r);
    printf(" %llu | %.2f | %s | %s | %s | %.2f | %.2f | %.3f |\n", (unsigned long long)r->all.rays, mrays(r),
        figure_text(t[0], r->paper, 2, "", "-"), figure_text(t[1], r->speedup, 2, "x", "-"),
        figure_text(t[2], r->paper_speedup, 2, "x", "-"), per_ray(r->all.box_tests, &r->all),
        per_ray(r->all.triangle_tests, &r->all), r->seconds);
  }
  printf("\n");
}

static void print_tests(const bench *b) {
  printf("Tests per ray, boxes / triangles, by type of ray:\n\n| scene | mode | path | isa | packets | assembly |");
  for (int t = 0; t < PKTRT_RAY_OTHER; t++) printf(" %s |", type_names[t]);
  printf("\n|---|---|---|---|---|---|--:|--:|--:|--:|\n");
  for (size_t i = 0; i < b->row_count; i++) {
    const row *r = &b->rows[i];
    print_way(r);
    for (int t = 0; t < PKTRT_RAY_OTHER; t++) {
      const pktrt_counts *c = &r->stats.by_type[t];
      if (c->rays) printf(" %.1f / %.1f |", per_ray(c->box_tests, c), per_ray(c->triangle_tests, c));
      else printf(" - |");
    }
    printf("\n");
  }
  printf("\n");
}

/* Rays of one sort. Sorts take turns, packet by packet, so only all together have a speed. */
static void csv_line(const bench *b, const row *r, const char *of, const pktrt_counts *c) {
  char t[3][32];
  if (!c->rays) return;
  if (r->s.varied) csv(&b->out, "%s,%g,", r->s.varied, r->s.value);
  else csv(&b->out, ",,");
  csv(&b->out, "%s,%s,%u,%s,%s,%u,%s,%u,%u,%s,%llu,%.4f,%.4f,%.4f,", r->s.scene, mode_names[r->s.mode], r->s.samples,
      path_names[r->s.path], pktrt_isa_string(r->s.isa), r->s.packet, assembly_names[r->s.assembly], b->given.size,
      r->s.frames, of, (unsigned long long)c->rays, per_ray(c->box_tests, c), per_ray(c->triangle_tests, c),
      per_ray(c->vector_box_tests, c));
  if (c == &r->all)
    csv(&b->out, "%.4f,%.6f,%s,%s,%s", mrays(r), r->seconds, figure_text(t[0], r->paper, 2, "", ""),
        figure_text(t[1], r->speedup, 4, "", ""), figure_text(t[2], r->paper_speedup, 2, "", ""));
  else csv(&b->out, ",,,,");
  csv(&b->out, ",%.4f\n", per_ray(c->vector_triangle_tests, c));
}

/* All pictures of a part: all their rays, by type, and by bounces. */
static void csv_rows(const bench *b) {
  csv(&b->out, "varied,value,scene,mode,samples,path,isa,packet,assembly,size,frames,of,rays,box_tests_per_ray,"
               "triangle_tests_per_ray,vector_box_tests_per_ray,mrays,seconds,paper_mrays,speedup,paper_speedup,"
               "vector_triangle_tests_per_ray\n");
  for (size_t i = 0; i < b->row_count; i++) {
    const row *r = &b->rows[i];
    csv_line(b, r, "all", &r->all);
    for (int t = 0; t < TYPES; t++) csv_line(b, r, type_names[t], &r->stats.by_type[t]);
    for (int d = 0; d < PKTRT_MAX_DEPTH + 2; d++) {
      char of[32];
      snprintf(of, sizeof of, "depth %d", d);
      csv_line(b, r, of, &r->stats.by_depth[d]);
    }
  }
}

/* >>setups --------------------------------------------------------------------------------------------------------- */

/* The instruction set nearest to the paper's four lanes; where there is none, what there is. */
static pktrt_isa four_lanes(void) {
  return pktrt_isa_available(PKTRT_ISA_SSE2)   ? PKTRT_ISA_SSE2
         : pktrt_isa_available(PKTRT_ISA_NEON) ? PKTRT_ISA_NEON
                                               : PKTRT_ISA_SCALAR;
}

/* What AUTO means here, by its name. */
static pktrt_isa widest(void) {
  static const pktrt_isa from_wide[] = {PKTRT_ISA_AVX512, PKTRT_ISA_AVX2, PKTRT_ISA_NEON, PKTRT_ISA_SSE2};
  for (size_t i = 0; i < sizeof from_wide / sizeof *from_wide; i++)
    if (pktrt_isa_available(from_wide[i])) return from_wide[i];
  return PKTRT_ISA_SCALAR;
}

/* The paper path, then the fast one, on the paper's lanes; last the fast one on all there are. */
enum { COLUMNS = 3 };
static int columns(void) { return widest() == four_lanes() ? 2 : 3; }
static bool column(int i, setup *s) { /* false: there is no such one */
  s->path = i == 0 ? PKTRT_PATH_PAPER : PKTRT_PATH_FAST;
  s->isa = i == 2 ? widest() : four_lanes();
  return i < columns();
}

/* The columns' names, three to each, and the line below the head of a table that begins with `rule`. */
static void say_columns(const bench *b, const char *rule) {
  for (int c = 0; c < columns(); c++)
    say(&b->out, " %s, %s: single | packets | speed-up |", c ? "fast path" : "paper path",
        pktrt_isa_string(c == 2 ? widest() : four_lanes()));
  say(&b->out, "\n%s", rule);
  for (int c = 0; c < columns(); c++) say(&b->out, "--:|--:|--:|");
  say(&b->out, "\n");
}

/* How many lanes a register has. */
static int lanes_of(pktrt_isa isa) {
  return isa == PKTRT_ISA_AVX512 ? 16 : isa == PKTRT_ISA_AVX2 ? 8 : isa == PKTRT_ISA_SCALAR ? 1 : 4;
}

/* Names the machine in full, as in "AMD EPYC, family 26 model 2 = Zen 5". */
static const char *full_name(const processor *p, char text[512]) {
  const char *known = class_of(p);
  if (name_tells(p)) snprintf(text, 512, "%s", known == p->name || !p->name[0] ? known : p->name);
  else if (known == p->name) snprintf(text, 512, "%s, family %d model %d", p->name, p->family, p->model);
  else snprintf(text, 512, "%s, family %d model %d = %s", p->name, p->family, p->model, known);
  return text;
}

/* The line above tables with times: both machines and trees. */
static void say_machines(const bench *b) {
  static processor p;
  char name[512];
  read_processor(&p);
  say(&b->out,
      "Compare ratios, not times. The paper: one core of an Opteron 880, 2.4 GHz, 4 lanes of SSE, a binary tree. Here: "
      "one core of %s; eight children to a node; vectors of eight lanes on the paper path, in registers of %d (%s), "
      "and "
      "up to %d lanes on the fast path (%s).\n\n",
      full_name(&p, name), lanes_of(four_lanes()), pktrt_isa_string(four_lanes()),
      lanes_of(widest()) > 8 ? lanes_of(widest()) : 8, pktrt_isa_string(widest()));
}

static const unsigned edges[4] = {2, 4, 8, 16};

static setup as_the_scene_is(const char *name) {
  setup s;
  memset(&s, 0, sizeof s);
  s.scene = name;
  s.isa = four_lanes();
  s.packet = 8, s.samples = s.root = 1, s.depth = PKTRT_MAX_DEPTH;
  s.aperture = s.light_size = 1, s.shutter = SHUTTER;
  return s;
}

EX_UNUSED static void open_world(world *w, const char *name, finish look, pktrt_isa isa, bool moving) {
  setup s = as_the_scene_is(name);
  s.look = look, s.isa = isa, s.mode = moving ? PKTRT_MODE_DRT : PKTRT_MODE_WRT;
  open_setup(w, &s);
}

/* All surfaces reflect, and do so as their triangles lie, as those of a model without normals: what interpolated
   normals change is measured with Table 1. */
static void make_conference(setup *s) { s->look = REFLECTIVE, s->normals = PKTRT_NORMALS_GEOMETRIC; }

/* Whitted's mode over the camera path. Conference: every surface reflective, depth 5, no attenuation (table 1). */
static setup whitted(const bench *b, const char *name) {
  const bool conference = !strcmp(name, "conference");
  setup s = as_the_scene_is(name);
  s.mode = PKTRT_MODE_WRT;
  if (conference) make_conference(&s), s.depth = 5, s.attenuation = -1; /* elsewhere on, as the library has it */
  s.frames = b->given.frames, s.every = b->given.every;
  return s;
}

/* Whitted's mode as section 5.4 has it: ray trees are pruned by attenuation. */
static setup pruned(const bench *b, const char *name) {
  setup s = whitted(b, name);
  s.depth = PKTRT_MAX_DEPTH, s.attenuation = 0;
  return s;
}

/* One frame, every mode with what the scene offers: conference reflective and glossy, attenuation on. As there is but
   one, eight times as much of it is made as of the frames of a path. */
static setup one_frame(const bench *b, const char *name, pktrt_mode mode, unsigned root) {
  setup s = as_the_scene_is(name);
  s.mode = mode;
  if (!strcmp(name, "conference")) make_conference(&s);
  s.samples = root * root, s.root = root, s.frames = 1;
  s.every = (b->given.every + 7) / 8;
  return s;
}

/* A frame of table 2, which compares modes. Distribution ray tracing has smaller tiles, which show less of the frame: with
   the eight tiles of other single frames the ratio of two modes would depend on where these lie. Thus four times as many. */
static setup frame_of_table2(const bench *b, const char *name, pktrt_mode mode) {
  setup s = one_frame(b, name, mode, mode == PKTRT_MODE_DRT ? 4 : 1);
  s.every = (s.every + 3) / 4;
  return s;
}

/* The ray of a pinhole through a place of the picture, (0,0) its upper left corner; up is y. */
static void look_through(const pktrt_camera *c, double x, double y, pktrt_ray *ray) {
  double to[3], right[3], up[3], length = 0, across = 0;
  const double half = tan(0.5 * (double)(c->fov_y > 0 ? c->fov_y : 45) * SC_PI / 180);
  for (int a = 0; a < 3; a++) to[a] = (double)c->target[a] - (double)c->eye[a], length += to[a] * to[a];
  for (int a = 0; a < 3; a++) to[a] /= sqrt(length);
  across = sqrt(to[0] * to[0] + to[2] * to[2]);
  right[0] = -to[2] / across, right[1] = 0, right[2] = to[0] / across;
  up[0] = right[1] * to[2] - right[2] * to[1];
  up[1] = right[2] * to[0] - right[0] * to[2];
  up[2] = right[0] * to[1] - right[1] * to[0];
  memset(ray, 0, sizeof *ray);
  for (int a = 0; a < 3; a++) {
    ray->origin[a] = c->eye[a];
    ray->direction[a] = (float)(to[a] + half * ((2 * x - 1) * right[a] + (1 - 2 * y) * up[a]));
  }
  ray->tmax = INFINITY;
}

#endif /* PAPER_H */
