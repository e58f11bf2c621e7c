/* The results of Boulos et al. 2007, measured again on this machine, the paper's figures beside ours:

     make bench                                          builds it and measures all parts there are
     make bench NAME="table1 figure6" BENCH_ARGS="..."   some of them, with options
     taskset -c 1 build/paper --csv out/paper.csv        on a core of its own, for figures to keep

   Everything runs on one thread; time is processor time. "Single ray" is meant as in the paper (section 5.2): primary
   rays travel in packets, all others one by one. What is compared is measured side by side: a first run of each
   counts the tests and is not timed, then every round runs each once, counting nothing, and medians are compared. (The
   paper path counts always, on both sides.) What is compared also makes the same picture, or the program fails.

   Contents: options, worlds, measuring, report, parts, main. */
#include "bench.h"
#include <getopt.h>
#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"
#include "../examples/scenes.h"

enum { MAX_ROUNDS = 64, MAX_FRAMES = 64, MAX_EVERY = 4096, MAX_ROWS = 128, MAX_NAMES = 32 };
enum { TYPES = PKTRT_RAY_TYPE_COUNT };

/* >>options -------------------------------------------------------------------------------------------------------- */

typedef struct options {
  const char *csv;
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
  case 'c': o->csv = optarg; return true;
  case 'h': print_help(); exit(0);
  default: return false; /* getopt has said what */
  }
}

static bool parse_options(int argc, char **argv, options *o) {
  static const struct option list[] = {
      {"small", no_argument, NULL, 'm'},        {"size", required_argument, NULL, 's'},
      {"frames", required_argument, NULL, 'f'}, {"rounds", required_argument, NULL, 'r'},
      {"every", required_argument, NULL, 'e'},  {"csv", required_argument, NULL, 'c'},
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
  FILE *csv;
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

/* Measures n ways to make the same pictures, on one world, and appends their rows; returns the first. */
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
    if (r[i].checksum != r[0].checksum) fatal("two ways to trace the same rays made different pictures");
  }
  for (unsigned k = 0; k < b->given.rounds; k++)
    for (size_t i = 0; i < n; i++) {
      const size_t turn = (i + k) % n; /* so that nobody always runs after the same one */
      uint64_t checksum;
      seconds[turn][k] = run_once(b, &ways[turn], NULL, &checksum);
      if (checksum != r[0].checksum) fatal("the same rays made another picture the second time");
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

static FILE *csv_open(const char *path) {
  FILE *file = path ? fopen(path, "w") : NULL;
  if (path && !file) {
    ex_fail("%s: cannot be written: %s", path, strerror(errno));
    exit(1);
  }
  if (file)
    fputs("part,scene,mode,samples,path,isa,packet,assembly,size,frames,of,rays,box_tests_per_ray,"
          "triangle_tests_per_ray,mrays,seconds,paper_mrays,speedup,paper_speedup\n",
          file);
  return file;
}

/* Rays of one sort. Sorts take turns, packet by packet, so only all together have a speed. */
static void csv_line(const bench *b, const row *r, const char *of, const pktrt_counts *c) {
  char t[3][32];
  if (!c->rays) return;
  fprintf(b->csv, "%s,%s,%s,%u,%s,%s,%u,%s,%u,%u,%s,%llu,%.4f,%.4f,", b->part, r->s.scene, mode_names[r->s.mode],
          r->s.samples, path_names[r->s.path], pktrt_isa_string(r->s.isa), r->s.packet, assembly_names[r->s.assembly],
          b->given.size, r->s.frames, of, (unsigned long long)c->rays, per_ray(c->box_tests, c),
          per_ray(c->triangle_tests, c));
  if (c == &r->all)
    fprintf(b->csv, "%.4f,%.6f,%s,%s,%s\n", mrays(r), r->seconds, figure_text(t[0], r->paper, 2, "", ""),
            figure_text(t[1], r->speedup, 4, "", ""), figure_text(t[2], r->paper_speedup, 2, "", ""));
  else fprintf(b->csv, ",,,,\n");
}

static void csv_rows(const bench *b) {
  for (size_t i = 0; b->csv && i < b->row_count; i++) {
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

/* >>parts ---------------------------------------------------------------------------------------------------------- */

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

static void table1(bench *b) {
  static const struct {
    const char *scene;
    double single[4], types[4], speedup[4];
  } paper[3] = {
      {"conference", {0.37, 0.43, 0.44, 0.40}, {0.76, 1.14, 1.25, 1.00}, {2.02, 2.65, 2.85, 2.53}},
      {"rtrt", {1.09, 1.20, 1.22, 1.14}, {1.98, 2.85, 3.30, 3.02}, {1.82, 2.37, 2.69, 2.65}},
      {"poolhall", {0.64, 0.71, 0.73, 0.71}, {1.21, 1.85, 2.18, 2.10}, {1.89, 2.60, 2.97, 2.96}}};
  for (int k = 0; k < 3; k++)
    for (int c = 0; c < COLUMNS; c++)
      for (int e = 0; e < 4; e++) {
        setup s = whitted(b, paper[k].scene);
        if (!column(c, &s)) continue;
        s.packet = edges[e];
        measure_pair(b, &s, paper[k].single[e], paper[k].types[e], paper[k].speedup[e]);
      }
  print_speeds(b);
  print_tests(b);
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

static void table2(bench *b) {
  static const struct {
    const char *scene;
    double speed[3]; /* by mode */
  } paper[3] = {
      {"conference", {3.25, 1.79, 0.88}}, {"rtrt", {3.30, 2.00, 1.53}}, {"poolhall", {2.83, 0.83, 1.23}}};
  for (int k = 0; k < 3; k++)
    for (int c = 0; c < COLUMNS; c++)
      for (int m = 0; m < 3; m++) {
        const pktrt_mode mode = (pktrt_mode)m;
        setup s = one_frame(b, paper[k].scene, mode, mode == PKTRT_MODE_DRT ? 4 : 1);
        if (column(c, &s)) measure(b, &s, 1)->paper = paper[k].speed[m];
      }
  print_speeds(b);
  printf("The paper's tables 1 and 2 differ: over the camera paths WRT has 1.25, 3.30 and 2.18 Mrays/s at 8x8 on "
         "conference, rtrt and pool hall, in one frame 1.79, 2.00 and 0.83.\n\n");
  print_tests(b);
}

static void table3(bench *b) {
  static const double single[3] = {0.42, 0.44, 0.29}, types[3] = {0.73, 0.88, 0.88}, speedup[3] = {1.86, 2.00, 3.03};
  for (int c = 0; c < COLUMNS; c++)
    for (int e = 0; e < 3; e++) {
      setup s = one_frame(b, "conference", PKTRT_MODE_DRT, edges[e]);
      s.packet = edges[e]; /* as many rays as a pixel has samples */
      if (column(c, &s)) measure_pair(b, &s, single[e], types[e], speedup[e]);
    }
  print_speeds(b);
  print_tests(b);
}

static void figure6(bench *b) {
  setup ways[4];
  for (int e = 0; e < 4; e++) {
    ways[e] = whitted(b, "conference");
    column(0, &ways[e]);
    ways[e].packet = edges[e];
  }
  measure(b, ways, 4);
  print_speeds(b);
  print_tests(b);
}

static void figure8(bench *b) {
  setup ways[2];
  ways[0] = whitted(b, "conference");
  ways[0].depth = PKTRT_MAX_DEPTH, ways[0].attenuation = 0; /* the paper's ray trees are pruned here */
  column(0, &ways[0]);
  ways[1] = ways[0];
  ways[1].assembly = PKTRT_ASSEMBLY_RUNS;
  const row *r = measure(b, ways, 2);
  print_speeds(b);
  print_depths(&r[0], &r[1]);
}

static const struct part {
  const char *name, *sentence;
  void (*run)(bench *);
} parts[] = {
    {"table1", "Whitted's mode over the camera paths: single rays against packets by ray type, by packet size", table1},
    {"table2", "rays per second of one frame: ray casting, Whitted's, distribution ray tracing", table2},
    {"table3", "distribution ray tracing of conference, a pixel to a packet: single rays against packets", table3},
    {"figure6", "tests per ray of Whitted's mode against packet size, on conference", figure6},
    {"figure8", "tests per ray by bounces from the camera, packets by ray type against runs, on conference", figure8}};
enum { PARTS = sizeof parts / sizeof *parts };

/* >>main ----------------------------------------------------------------------------------------------------------- */

static void print_help(void) {
  printf("usage: paper [options] [NAME...]   the paper's results; run it by `taskset -c 1` on a quiet machine\n"
         "  --small       128 x 128 pixels, whole, one frame, one round\n"
         "  --size N      N x N pixels, a multiple of 64 from 64 to 4096 (512)\n"
         "  --frames N    of each camera path, 1 to %d (3)\n"
         "  --rounds N    timed, whose median counts, 1 to %d (3)\n"
         "  --every N     of N tiles of each frame of a path one is made, 1 to %d (16); of single frames four\n"
         "  --csv FILE    all rows, also by type of ray and by bounces\n"
         "  --help        this text\nNAME, without one all:\n",
         MAX_FRAMES, MAX_ROUNDS, MAX_EVERY);
  for (int i = 0; i < PARTS; i++) printf("  %-13s %s\n", parts[i].name, parts[i].sentence);
}

static bool names_known(const options *o) {
  for (unsigned n = 0; n < o->name_count; n++) {
    bool known = false;
    for (int i = 0; i < PARTS; i++) known = known || !strcmp(o->names[n], parts[i].name);
    if (!known) return ex_fail("%s: no such part; see --help", o->names[n]);
  }
  return true;
}

static bool wanted(const options *o, const char *name) {
  bool found = o->name_count == 0;
  for (unsigned n = 0; n < o->name_count; n++) found = found || !strcmp(o->names[n], name);
  return found;
}

int main(int argc, char **argv) {
  static bench b; /* static: zeroed */
  double load = 0;
  if (!parse_options(argc, argv, &b.given) || !names_known(&b.given)) return 2;
  b.csv = csv_open(b.given.csv);
  b.pixels = (float *)calloc((size_t)b.given.size * b.given.size * 3, sizeof(float));
  if (!b.pixels) return ex_fail("not enough memory for a picture of %u x %u", b.given.size, b.given.size), 1;
  if (getloadavg(&load, 1) == 1 && load > 0.5)
    printf("note: load average %.1f, other work is running: figures are noisy\n\n", load);
  printf("%u x %u pixels, one tile of %u; camera paths in %u frames; median of %u rounds; one thread\n\n", b.given.size,
         b.given.size, b.given.every, b.given.frames, b.given.rounds);
  for (int i = 0; i < PARTS; i++) {
    if (!wanted(&b.given, parts[i].name)) continue;
    b.part = parts[i].name, b.row_count = 0;
    printf("### %s: %s\n\n", parts[i].name, parts[i].sentence);
    parts[i].run(&b);
    csv_rows(&b);
    fflush(stdout);
  }
  close_world(&b.now);
  free(b.pixels);
  if (b.csv && (ferror(b.csv) | fclose(b.csv))) return ex_fail("%s: could not be written", b.given.csv), 1;
  if (fflush(stdout) != 0) return ex_fail("the tables could not be written: %s", strerror(errno)), 1;
  return 0;
}
