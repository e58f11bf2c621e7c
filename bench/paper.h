/* paper.h - how the results of the paper are measured and written down. What is measured stands in paper.c and
   paper_system.h.

   Contents: options, worlds, measuring, report, setups. */
#ifndef PAPER_H
#define PAPER_H

#include "bench.h"
#include <getopt.h>
#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"
#include "../examples/scenes.h"

enum { MAX_ROUNDS = 64, MAX_FRAMES = 64, MAX_EVERY = 4096, MAX_ROWS = 512, MAX_NAMES = 32 };
enum { TYPES = PKTRT_RAY_TYPE_COUNT };

/* >>options -------------------------------------------------------------------------------------------------------- */

typedef struct options {
  const char *results; /* a directory, NULL: none */
  const char *names[MAX_NAMES];
  unsigned name_count, size, frames, rounds, every;
} options;

static void print_help(void);

static bool parse_option(options *o, int key) {
  switch (key) {
  case 'm': o->size = 128, o->frames = o->rounds = o->every = 1; return true;
  case 's':
    return ex_parse_uint("size", optarg, 64, 4096, &o->size) &&
           (o->size % 64 == 0 || ex_fail("--size: %s is not a multiple of 64", optarg));
  case 'f': return ex_parse_uint("frames", optarg, 1, MAX_FRAMES, &o->frames);
  case 'r': return ex_parse_uint("rounds", optarg, 1, MAX_ROUNDS, &o->rounds);
  case 'e': return ex_parse_uint("every", optarg, 1, MAX_EVERY, &o->every);
  case 'o': o->results = optarg; return true;
  case 'h': print_help(); exit(0);
  default: return false; /* getopt has said what */
  }
}

static bool parse_options(int argc, char **argv, options *o) {
  static const struct option list[] = {
      {"small", no_argument, NULL, 'm'},        {"size", required_argument, NULL, 's'},
      {"frames", required_argument, NULL, 'f'}, {"rounds", required_argument, NULL, 'r'},
      {"every", required_argument, NULL, 'e'},  {"results", required_argument, NULL, 'o'},
      {"help", no_argument, NULL, 'h'},         {NULL, 0, NULL, 0}};
  memset(o, 0, sizeof *o);
  o->size = 512, o->frames = o->rounds = 3, o->every = 16;
  for (int key; (key = getopt_long(argc, argv, "h", list, NULL)) != -1;)
    if (!parse_option(o, key)) return false;
  for (; optind < argc; optind++) {
    if (o->name_count == MAX_NAMES) return ex_fail("%s: one name too many", argv[optind]);
    o->names[o->name_count++] = argv[optind];
  }
  return true;
}

/* >>worlds --------------------------------------------------------------------------------------------------------- */

typedef enum finish { AS_MADE, MIRRORS, GLOSSY } finish;

/* The paper's conference room: "all surfaces are reflective" in Whitted's mode (5.2), "with a fairly glossy exponent"
   in the distributed one (5.3). How much they reflect it does not say; nor how glossy they are. */
#define REFLECTANCE 0.4f
#define EXPONENT 100.0f

#define SHUTTER (1.0 / 240) /* of the animation's loop: open for a whole frame of 240 */

typedef struct varnish { /* the `user` of a texture under a mirror */
  float albedo[3];
  void (*texture)(void *user, const pktrt_points *);
  void *user;
} varnish;

typedef struct world {
  const char *name; /* NULL: none yet */
  finish look;
  pktrt_isa isa;
  bool moving; /* two keys, the shutter's opening and its closing */
  scene made;
  varnish *under; /* one for each material */
  pktrt_scene *tree;
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

/* What was only diffuse becomes a mirror in part; the rest reflects by itself already. */
static void make_reflective(pktrt_material *m, varnish *v, finish look) {
  if (m->specular != PKTRT_SPECULAR_NONE) return;
  memcpy(v->albedo, m->albedo, sizeof v->albedo);
  v->texture = m->texture, v->user = m->user;
  if (m->texture) m->texture = varnished, m->user = v;
  m->specular = PKTRT_SPECULAR_MIRROR;
  m->lobe = look == GLOSSY ? PKTRT_LOBE_PHONG : PKTRT_LOBE_IDEAL;
  m->exponent = EXPONENT;
  for (int c = 0; c < 3; c++) m->reflectance[c] = REFLECTANCE, m->albedo[c] *= 1 - REFLECTANCE;
}

static void close_world(world *w) {
  pktrt_scene_destroy(w->tree);
  scene_free(&w->made);
  free(w->under);
  memset(w, 0, sizeof *w);
}

/* Scenes are made one at a time: what is next measured on the same one finds it built. */
static void open_world(world *w, const char *name, finish look, pktrt_isa isa, bool moving) {
  pktrt_scene_desc desc;
  if (w->name && !strcmp(w->name, name) && w->look == look && w->isa == isa && w->moving == moving) return;
  close_world(w);
  if (!scene_make(name, &w->made)) fatal("no such scene, or not enough memory for it");
  w->under = (varnish *)calloc(w->made.material_count, sizeof *w->under);
  if (!w->under) fatal("not enough memory");
  for (size_t i = 0; look != AS_MADE && i < w->made.material_count; i++)
    make_reflective(&w->made.materials[i].m, &w->under[i], look);
  memset(&desc, 0, sizeof desc);
  desc.isa = isa;
  w->tree = pktrt_scene_create(&desc);
  if (!w->tree) fatal(pktrt_last_error(NULL));
  if (scene_add_at(w->tree, &w->made, 0, moving ? SHUTTER : 0) != PKTRT_OK || pktrt_commit(w->tree) != PKTRT_OK)
    fatal(pktrt_last_error(w->tree));
  w->name = name, w->look = look, w->isa = isa, w->moving = moving;
}

/* >>measuring ------------------------------------------------------------------------------------------------------ */

static const char *const mode_names[] = {"RCS", "WRT", "DRT"};
static const char *const path_names[] = {"fast", "paper", "single"};
static const char *const assembly_names[] = {"ray types", "runs", "materials", "octants", "blind", "single"};
static const char *const type_names[TYPES] = {"primary", "shadow", "reflection", "refraction", "other"};

typedef struct setup { /* zeroed and filled in: how pictures are made */
  const char *scene;
  finish look;
  pktrt_mode mode;
  pktrt_path path;
  pktrt_isa isa;
  pktrt_assembly assembly;
  unsigned packet, samples, root, depth, frames; /* samples: per pixel, root times root */
  unsigned every;                                /* of so many tiles one is made */
  float attenuation;
  bool differs;       /* makes another picture than the way it is measured beside */
  const char *varied; /* what the CSV file says of this way: NULL, or a word and its value */
  double value;
} setup;

typedef struct row {
  setup s;
  pktrt_stats stats;
  pktrt_counts all; /* over all types */
  double seconds;
  uint64_t checksum;
  double paper, speedup, paper_speedup; /* Mrays/s of the paper; against single rays: ours, the paper's. 0: none */
} row;

typedef struct bench {
  options given;
  FILE *csv, *md; /* of this part; NULL: not wanted */
  world now;
  float *pixels;
  const char *part;
  row rows[MAX_ROWS];
  size_t row_count;
} bench;

static void describe(bench *b, const setup *s, unsigned frame, pktrt_stats *stats, pktrt_render_desc *d) {
  memset(d, 0, sizeof *d);
  d->width = d->height = b->given.size;
  d->pixels = b->pixels;
  d->mode = s->mode, d->path = s->path, d->packet_size = s->packet, d->assembly = s->assembly;
  d->samples = s->samples, d->max_depth = s->depth, d->attenuation = s->attenuation;
  d->stats = stats;
  d->camera = b->now.made.camera;
  scene_camera(&b->now.made, (double)frame / s->frames, &d->camera);
  d->camera.time = 0, d->camera.shutter = b->now.moving ? 1 : 0; /* between the keys */
  memcpy(d->background, b->now.made.background, sizeof d->background);
  memcpy(d->ambient, b->now.made.ambient, sizeof d->ambient);
}

/* With `every` 1 a picture of one sample per pixel is whole. Of others some tiles are made, each of 64 x 64 primary
   rays, and as many of them whatever the samples: that keeps the size of pixels, and with it the coherence of rays,
   which a smaller picture would not. The fractions are those of the R2 sequence (Roberts 2018), which spreads tiles
   evenly over the picture and, counted on, over the frames. */
static void make_picture(bench *b, const setup *s, unsigned frame, const pktrt_render_desc *d) {
  const uint32_t edge = 64 / s->root, across = b->given.size / edge, units = b->given.size / 64;
  const uint32_t n = (units * units + s->every - 1) / s->every;
  if (s->every == 1 && s->samples == 1) {
    if (pktrt_render(b->now.tree, d) != PKTRT_OK) fatal(pktrt_last_error(b->now.tree));
    return;
  }
  for (uint32_t i = 0; i < n; i++) {
    const double k = 0.5 + (double)frame * n + i, u = k * 0.7548776662466927, v = k * 0.5698402909980532;
    const uint32_t x = (uint32_t)((u - floor(u)) * across), y = (uint32_t)((v - floor(v)) * across);
    if (pktrt_render_tile(b->now.tree, d, edge * x, edge * y, edge, edge) != PKTRT_OK)
      fatal("a tile could not be rendered");
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
}

/* Measures n ways to make the same picture, on one world, and appends their rows; returns the first. A way whose
   picture differs says so. */
static row *measure(bench *b, const setup *ways, size_t n) {
  enum { MOST = 8 };
  double seconds[MOST][MAX_ROUNDS];
  row *r = &b->rows[b->row_count];
  if (n > MOST || b->row_count + n > MAX_ROWS) fatal("more rows than there is room for");
  b->row_count += n;
  open_world(&b->now, ways[0].scene, ways[0].look, ways[0].isa, ways[0].mode == PKTRT_MODE_DRT);
  for (size_t i = 0; i < n; i++) {
    memset(&r[i], 0, sizeof r[i]);
    r[i].s = ways[i];
    run_once(b, &ways[i], &r[i].stats, &r[i].checksum);
    for (int t = 0; t < TYPES; t++) add_counts(&r[i].all, &r[i].stats.by_type[t]);
    if (r[i].checksum != r[0].checksum && !ways[i].differs)
      fatal("two ways to trace the same rays made different pictures");
  }
  for (unsigned k = 0; k < b->given.rounds; k++)
    for (size_t i = 0; i < n; i++) {
      const size_t turn = (i + k) % n; /* so that nobody always runs after the same one */
      uint64_t checksum;
      seconds[turn][k] = run_once(b, &ways[turn], NULL, &checksum);
      if (checksum != r[turn].checksum) fatal("the same rays made another picture the second time");
    }
  for (size_t i = 0; i < n; i++) r[i].seconds = median_of(seconds[i], b->given.rounds);
  fprintf(stderr, "%s: %s %s, %s path, %s, packets of %u x %u%s: done\n", b->part, ways[0].scene,
          mode_names[ways[0].mode], path_names[ways[0].path], pktrt_isa_string(ways[0].isa), ways[0].packet,
          ways[0].packet, ways[0].packet != ways[n - 1].packet ? " and more" : "");
  return r;
}

static double per_ray(uint64_t tests, const pktrt_counts *c) { return c->rays ? (double)tests / (double)c->rays : 0; }

static double mrays(const row *r) { return r->seconds > 0 ? 1e-6 * (double)r->all.rays / r->seconds : 0; }

/* Single rays and packets by ray type, side by side, and what the paper has for both; 0: nothing. */
static void measure_pair(bench *b, const setup *s, double paper_single, double paper_types, double paper_speedup) {
  setup ways[2];
  ways[0] = ways[1] = *s;
  ways[0].assembly = PKTRT_ASSEMBLY_NONE;
  ways[1].assembly = PKTRT_ASSEMBLY_RAY_TYPES;
  row *r = measure(b, ways, 2);
  r[0].paper = paper_single;
  r[1].paper = paper_types;
  r[1].speedup = mrays(&r[0]) > 0 ? mrays(&r[1]) / mrays(&r[0]) : 0;
  r[1].paper_speedup = paper_speedup;
}

/* >>report --------------------------------------------------------------------------------------------------------- */

/* A figure, or what stands for none. */
static const char *figure_text(char text[32], double value, int digits, const char *unit, const char *none) {
  if (value > 0) snprintf(text, 32, "%.*f%s", digits, value, unit);
  else snprintf(text, 32, "%s", none);
  return text;
}

static void print_way(const row *r) {
  printf("| %s | %s", r->s.scene, mode_names[r->s.mode]);
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

static void print_depth(const char *label, const pktrt_counts *x, const pktrt_counts *y) {
  if (x->rays)
    printf("| %s | %llu | %.2f | %.2f | %.2f | %.2f |\n", label, (unsigned long long)x->rays, per_ray(x->box_tests, x),
           per_ray(y->box_tests, y), per_ray(x->triangle_tests, x), per_ray(y->triangle_tests, y));
}

/* Two assemblies, depth by depth; shadow rays count as one deeper than the surface that they leave. */
static void print_depths(const row *a, const row *c) {
  enum { SHOWN = 10 };
  pktrt_counts deeper[2];
  memset(deeper, 0, sizeof deeper);
  printf("| bounces | rays | boxes/ray: %s | %s | triangles/ray: %s | %s |\n|--:|--:|--:|--:|--:|--:|\n",
         assembly_names[a->s.assembly], assembly_names[c->s.assembly], assembly_names[a->s.assembly],
         assembly_names[c->s.assembly]);
  for (int d = 0; d < PKTRT_MAX_DEPTH + 2; d++) {
    char label[32];
    if (d > SHOWN) {
      add_counts(&deeper[0], &a->stats.by_depth[d]), add_counts(&deeper[1], &c->stats.by_depth[d]);
      continue;
    }
    snprintf(label, sizeof label, "%d", d);
    print_depth(label, &a->stats.by_depth[d], &c->stats.by_depth[d]);
  }
  print_depth("deeper", &deeper[0], &deeper[1]);
  print_depth("all", &a->all, &c->all);
  printf("\n");
}

/* A table for the README: to the terminal, and to the part's own file. */
EX_UNUSED EX_PRINTF(2, 3) static void say(const bench *b, const char *format, ...) {
  va_list values;
  va_start(values, format);
  vprintf(format, values);
  va_end(values);
  va_start(values, format);
  if (b->md) vfprintf(b->md, format, values);
  va_end(values);
}

/* What is kept in full. */
EX_PRINTF(2, 3) static void csv(const bench *b, const char *format, ...) {
  va_list values;
  va_start(values, format);
  if (b->csv) vfprintf(b->csv, format, values);
  va_end(values);
}

static FILE *open_result(const bench *b, const char *suffix) {
  enum { LONGEST = 4096 };
  char path[LONGEST];
  if (!b->given.results) return NULL;
  const int n = snprintf(path, sizeof path, "%s/%s.%s", b->given.results, b->part, suffix);
  FILE *file = n > 0 && n < LONGEST ? fopen(path, "w") : NULL;
  if (!file) {
    ex_fail("%s/%s.%s: cannot be written: %s", b->given.results, b->part, suffix, strerror(errno));
    exit(1);
  }
  return file;
}

static void close_result(FILE *file) {
  if (file && (ferror(file) | fclose(file))) fatal("results could not be written");
}

/* Rays of one sort. Sorts take turns, packet by packet, so only all together have a speed. */
static void csv_line(const bench *b, const row *r, const char *of, const pktrt_counts *c) {
  char t[3][32];
  if (!c->rays) return;
  if (r->s.varied) csv(b, "%s,%g,", r->s.varied, r->s.value);
  else csv(b, ",,");
  csv(b, "%s,%s,%u,%s,%s,%u,%s,%u,%u,%s,%llu,%.4f,%.4f,", r->s.scene, mode_names[r->s.mode], r->s.samples,
      path_names[r->s.path], pktrt_isa_string(r->s.isa), r->s.packet, assembly_names[r->s.assembly], b->given.size,
      r->s.frames, of, (unsigned long long)c->rays, per_ray(c->box_tests, c), per_ray(c->triangle_tests, c));
  if (c == &r->all)
    csv(b, "%.4f,%.6f,%s,%s,%s\n", mrays(r), r->seconds, figure_text(t[0], r->paper, 2, "", ""),
        figure_text(t[1], r->speedup, 4, "", ""), figure_text(t[2], r->paper_speedup, 2, "", ""));
  else csv(b, ",,,,\n");
}

/* All pictures of a part: all their rays, by type, and by bounces. */
static void csv_rows(const bench *b) {
  csv(b, "varied,value,scene,mode,samples,path,isa,packet,assembly,size,frames,of,rays,box_tests_per_ray,"
         "triangle_tests_per_ray,mrays,seconds,paper_mrays,speedup,paper_speedup\n");
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
static bool column(int i, setup *s) {
  s->path = i == 0 ? PKTRT_PATH_PAPER : PKTRT_PATH_FAST;
  s->isa = i == 2 ? widest() : four_lanes();
  return i < 2 || widest() != four_lanes();
}

static const unsigned edges[4] = {2, 4, 8, 16};

/* Whitted's mode over the camera path. Conference: every surface reflective, depth 5, no attenuation (table 1). */
static setup whitted(const bench *b, const char *name) {
  const bool conference = !strcmp(name, "conference");
  setup s;
  memset(&s, 0, sizeof s);
  s.scene = name;
  s.look = conference ? MIRRORS : AS_MADE;
  s.mode = PKTRT_MODE_WRT;
  s.depth = conference ? 5 : PKTRT_MAX_DEPTH;
  s.attenuation = conference ? -1.0f : 0.0f; /* 0: on, as the library has it */
  s.packet = 8, s.samples = s.root = 1, s.frames = b->given.frames, s.every = b->given.every;
  return s;
}

/* One frame, every mode with what the scene offers: conference reflective and glossy, attenuation on. As there is but
   one, four times as much of it is made as of the frames of a path. */
static setup one_frame(const bench *b, const char *name, pktrt_mode mode, unsigned root) {
  setup s;
  memset(&s, 0, sizeof s);
  s.scene = name, s.mode = mode;
  s.look = strcmp(name, "conference") ? AS_MADE : GLOSSY;
  s.packet = 8, s.depth = PKTRT_MAX_DEPTH, s.samples = root * root, s.root = root, s.frames = 1;
  s.every = (b->given.every + 3) / 4;
  return s;
}

#endif /* PAPER_H */
