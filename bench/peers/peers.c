/* Speed beside Embree 3, on the same rays, in one process and on one core:

     make peers                            the headline set: built-in scenes at rest and moving, in a quarter of an
                                           hour
     make peers MESHES="FILE.tri DIR"      of these files and directories besides
     make peers FULL=1                     everything: more motion, high trees of all, all instruction sets, refitted
                                           trees
     build/peers --help                    all options

   Each kind of ray is made once by pktrt and handed to both libraries, the same floats. Every round runs all modes of
   both, one after the other, so that a slow moment hurts all alike; a first round is not timed but compared. Time is
   processor time. Embree gets its rays in its own layouts and with fresh hit records, which is not timed, and runs
   with denormals flushed, as its manual advises; pktrt_ray and pktrt_hit arrays, and the arrays of the _soa calls, are
   used as they are. Embree's fastest mode counts, and apart from it the fastest of its robust ones, which run in the
   same rounds. A ratio is pktrt / Embree in rays per second: above 1, pktrt is the faster.

   Where the two disagree on a hit, truth.h says who is wrong. How near pktrt's kernels are to the time of their
   tests alone, limits.h. What a call costs where nearly nothing is traced: few.h. Instances of both libraries, with a
   file of results of their own: instances.h.

   Contents: options, settings, parts, main. */
#define APART (24.0f / 16777216) /* with less Embree hits the surface, and the two are not asked the same */
#include "closest.h"
#include "few.h"
#include "instances.h"
#include "limits.h"
#include "race.h"
#include "rays.h"
#include "report.h"
#include "scenes.h"
#include "upkeep.h"
#include <getopt.h>

/* >>options -------------------------------------------------------------------------------------------------------- */

static const char usage[] =
    "usage: peers [options] [FILE[@CAMERA] | DIR ...]    speed of pktrt beside Embree 3\n"
    "  FILE          a mesh; CAMERA: outside (default), inside, or EX,EY,EZ,TX,TY,TZ[,UX,UY,UZ]: eye, target, up\n"
    "  DIR           all its .tri files, framed from outside\n"
    "  --scenes LIST of built-in scenes: conference, rtrt, poolhall; generated: hills, chaff; instances; or none\n"
    "  --camera C    of files that come without: 6 or 9 numbers as above;  --up X,Y,Z  (0,1,0)  --light X,Y,Z\n"
    "  --settings LIST  rest, moving, refitted, moving-0.1, moving-5, moving-loose, high\n"
    "  --kinds LIST  primary, shadow, shadow-from-light, mirror, second-mirror, diffuse, ao\n"
    "  --isa LIST    avx512, avx2, sse2, scalar, neon\n"
    "  --size N      N x N primary rays, a multiple of 16 up to 4096 (1024, and 640 where things move)\n"
    "  --rounds N    timed, of which each part's least time counts, 1 to 64 (3)\n"
    "  --full        everything; --all-modes: every mode of Embree in every round, however slow\n"
    "  --no-robust   without Embree's robust modes, in two thirds of the time\n"
    "  --results DIR peers.csv: all that was measured; peers.md: tables for the README; peers_instances likewise\n";

enum { MAX_STAGES = 256 };
typedef struct programme { /* what is to be done */
  options o;
  char *stages[MAX_STAGES]; /* scenes by name, then files */
  unsigned stage_count, isas;
  bool instances;
  const char *scenes;
} programme;

/* The bits of the words in a list; 0 after saying what is wrong. */
static unsigned parse_list(const char *option, const char *text, const char *const *words) {
  char word[64];
  unsigned bits = 0;
  for (const char *from = text; *from;) {
    const size_t n = strcspn(from, ",");
    int value = 0;
    snprintf(word, sizeof word, "%.*s", (int)(n < 60 ? n : 60), from);
    if (!ex_parse_word(option, word, words, &value)) return 0;
    bits |= BIT(value);
    from += n + (from[n] == ',');
  }
  return bits;
}

static void add_stage(programme *p, const char *text) {
  if (p->stage_count == MAX_STAGES) fatal("too many scenes and meshes");
  p->stages[p->stage_count] = strdup(text);
  if (!p->stages[p->stage_count++]) fatal("not enough memory");
}

static int is_tri(const struct dirent *d) { return ex_has_suffix(d->d_name, ".tri"); }

/* A file, or all meshes of a directory in the order of their names. A file that is missing is told before any race. */
static bool add_files(programme *p, const char *text) {
  struct stat info;
  struct dirent **list = NULL;
  char path[4096];
  split_camera(text, path, sizeof path);
  if (stat(path, &info) != 0) return ex_fail("%s: cannot be read: %s", path, strerror(errno));
  if (!S_ISDIR(info.st_mode)) return add_stage(p, text), true;
  const int n = scandir(text, &list, is_tri, alphasort);
  if (n <= 0) return ex_fail("%s: no .tri files", text);
  for (int i = 0; i < n; i++) {
    snprintf(path, sizeof path, "%s/%s", text, list[i]->d_name);
    add_stage(p, path);
    free(list[i]);
  }
  free(list);
  return true;
}

static const char *const setting_words[] = {
    "rest", "moving", "refitted", "moving-0.1", "moving-5", "moving-loose", "high", NULL};
static const char *const isa_words[] = {"auto", "scalar", "sse2", "avx2", "avx512", "neon", NULL}; /* as pktrt_isa */

static bool parse_option(programme *p, int key) {
  options *o = &p->o;
  switch (key) {
  case 'c':
    o->view.camera_count = parse_floats(optarg, o->view.camera, 9);
    return o->view.camera_count == 6 || o->view.camera_count == 9 ||
           ex_fail("--camera %s: want 6 or 9 numbers", optarg);
  case 'u': return parse_floats(optarg, o->view.up, 3) == 3 || ex_fail("--up %s: want X,Y,Z", optarg);
  case 'l':
    o->view.has_light = true;
    return parse_floats(optarg, o->view.light, 3) == 3 || ex_fail("--light %s: want X,Y,Z", optarg);
  case 's':
    if (!ex_parse_uint("size", optarg, 16, 4096, &o->size)) return false;
    o->moving_size = o->size;
    return o->size % 16 == 0 || ex_fail("--size: %s is not a multiple of 16", optarg);
  case 'r': return ex_parse_uint("rounds", optarg, 1, MAX_ROUNDS, &o->rounds);
  case 'n': p->scenes = optarg; return true;
  case 't': return (o->settings = parse_list("settings", optarg, setting_words)) != 0;
  case 'k': return (o->kinds = parse_list("kinds", optarg, kind_names)) != 0;
  case 'i': return (p->isas = parse_list("isa", optarg, isa_words)) != 0;
  case 'f': return o->full = true;
  case 'a': return o->all_modes = true;
  case 'p': return o->plain_only = true;
  case 'o': o->results = optarg; return true;
  case 'h': fputs(usage, stdout); exit(0);
  default: return false; /* getopt has said what */
  }
}

static bool parse_options(int argc, char **argv, programme *p) {
  static const struct option known[] = {{"scenes", required_argument, NULL, 'n'},
      {"camera", required_argument, NULL, 'c'}, {"up", required_argument, NULL, 'u'},
      {"light", required_argument, NULL, 'l'}, {"settings", required_argument, NULL, 't'},
      {"kinds", required_argument, NULL, 'k'}, {"isa", required_argument, NULL, 'i'},
      {"size", required_argument, NULL, 's'}, {"rounds", required_argument, NULL, 'r'},
      {"full", no_argument, NULL, 'f'}, {"all-modes", no_argument, NULL, 'a'},
      {"results", required_argument, NULL, 'o'}, {"no-robust", no_argument, NULL, 'p'},
      {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};
  memset(p, 0, sizeof *p);
  p->o.size = 1024, p->o.moving_size = 640, p->o.rounds = 3, p->o.kinds = ALL_KINDS, p->o.view.up[1] = 1;
  for (int key; (key = getopt_long(argc, argv, "h", known, NULL)) != -1;)
    if (!parse_option(p, key)) return false;
  static const char *const names[] = {"conference", "rtrt", "poolhall", "hills", "chaff", "none", "instances", NULL};
  const unsigned all = BIT(6) | (p->o.full ? BIT(5) - 1 : BIT(3) - 1),
                 scenes = p->scenes ? parse_list("scenes", p->scenes, names) : all;
  if (!scenes) return false;
  for (unsigned i = 0; i < 5; i++)
    if (scenes & BIT(i)) add_stage(p, names[i]);
  p->instances = scenes & BIT(6);
  for (; optind < argc; optind++)
    if (!add_files(p, argv[optind])) return false;
  return true;
}

/* >>settings ------------------------------------------------------------------------------------------------------- */

enum { SETTINGS = 7, HEADLINE = 3 };
static const setting settings[SETTINGS] = {{REST, 0, 0, false, true, false}, {MOVES, 0.01, 0, false, true, false},
    {"refitted 1%", 0.01, 0, false, false, true}, /* no rays unless full */
    {"moving 0.1%", 0.001, 0, false, false, false}, {"moving 5%", 0.05, 0, false, false, false},
    {"moving 1% loosely", 0.01, 0.1, false, false, false}, {HIGH, 0, 0, true, false, false}};

/* Whether one sees it from within its box, as an apartment. */
static bool seen_from_inside(const stage *g) {
  double lo[3], hi[3];
  bool inside = true;
  scene_bounds(&g->s, lo, hi);
  for (int a = 0; a < 3; a++)
    inside = inside && (double)g->s.camera.eye[a] > lo[a] && (double)g->s.camera.eye[a] < hi[a];
  return inside;
}

/* The dearest trees are of the headline set for meshes that are like apartments. */
static bool setting_wanted(const options *o, const stage *g, unsigned i) {
  if (o->settings) return o->settings & BIT(i);
  return o->full || i < HEADLINE || (settings[i].high && o->kinds & CLOSEST && g->of == MESHES && seen_from_inside(g));
}

/* There, closest hits alone, and fewer rays. */
static options options_of(const options *o, const setting *how) {
  options these = *o;
  if (!how->high || o->full || o->settings) return these;
  these.kinds &= CLOSEST, these.size = o->moving_size;
  return these;
}

/* >>parts ---------------------------------------------------------------------------------------------------------- */

typedef struct room { /* for the largest set of rays */
  sources s;
  job j;
} room;

/* Those parts that race on no kind of rays: on the pool hall as it lies, and of two workers, in the full set, on all
   built-in scenes. Orders of rays: a quarter of them, in the full set all. A further part adds its rows here, and what
   it must reach as a line of report.h. */
static void run_extras(
    report *to, const options *o, const stage *g, const setting *how, const pair *pairs, unsigned count, room *r) {
  const bool hall = !strcmp(g->name, "poolhall");
  if (hall) add_shading(to, o, g, how, pairs, count);
  if (hall || o->full) add_workers(to, o, g, how, pairs, count);
  if (!hall) return;
  add_few(to, pairs, count);
  const unsigned across = o->full ? o->size : o->size / 2;
  make_sources(g, pairs[0].ours, across, false, &r->s);
  add_orders(to, o, g, how, pairs, count, &r->s, &r->j);
}

/* Kernels narrower than AVX2 run in the first two settings only. */
static unsigned pairs_of(const setting *how, const pair *pairs, unsigned count) {
  unsigned n = 0;
  for (unsigned i = 0; i < count; i++) n += pairs[i].isa > PKTRT_ISA_SSE2;
  return how <= &settings[1] || n == 0 ? count : n;
}

static size_t run_setting(
    report *to, const options *o, stage *g, const setting *how, pair *pairs, unsigned count, room *r) {
  const bool fits_only = how->refit && !o->full && !o->settings;
  size_t wrong = 0;
  const unsigned across = rays_across(o, how);
  printf("\n%s, %s: %llu triangles; %u x %u primary rays; Mrays/s, the best of %u rounds: Embree's fastest, pktrt, "
         "ratio, single calls of both, rays that disagree\n",
      g->name, how->name, (unsigned long long)scene_triangles(&g->s), across, across, o->rounds);
  set_motion(g, how->share, how->loose);
  for (size_t m = 0; m < g->s.mesh_count && how->refit; m++) g->s.meshes[m].key_count = 1;
  build_pairs(pairs, count, g, how, how->refit ? 1 : o->rounds);
  if (how->refit) add_refits(to, g, how, pairs, count, o->rounds);
  else add_trees(to, g, how, pairs, count, o->rounds, false);
  if (how->robust && !o->plain_only) build_robust(pairs, count, g, how);
  if (!fits_only) wrong = race(to, o, g, how, pairs, count, &r->s, &r->j);
  if (how == &settings[0] && g->of == BUILT_IN) run_extras(to, o, g, how, pairs, count, r);
  if (how == &settings[0]) wrong += add_closest(to, o, g, how, &pairs[0]);
  if (how == &settings[0] && !g->soup) add_soup(to, g, how, pairs, count, o->rounds);
  if (how->refit) swap_poses(g);
  close_scenes(pairs, count);
  return wrong;
}

static size_t run_all(report *to, const programme *p, pair *pairs, unsigned count) {
  const double start = ex_seconds();
  const size_t most = (size_t)p->o.size * p->o.size;
  size_t wrong = 0;
  room r;
  sources_room(&r.s, most);
  job_room(&r.j, most, count);
  for (unsigned i = 0; i < p->stage_count; i++) {
    stage g;
    if (!open_stage(p->stages[i], &p->o.view, &g)) exit(1);
    for (unsigned k = 0; k < SETTINGS; k++) {
      const options these = options_of(&p->o, &settings[k]);
      if (setting_wanted(&p->o, &g, k))
        wrong += run_setting(to, &these, &g, &settings[k], pairs, pairs_of(&settings[k], pairs, count), &r);
    }
    close_stage(&g);
    fprintf(stderr, "peers: %s: done, %.0f s\n", g.name, ex_seconds() - start);
  }
  sources_free(&r.s);
  job_free(&r.j);
  return wrong;
}

/* >>main ----------------------------------------------------------------------------------------------------------- */

static void print_tables(report *to, const options *o) {
  static processor here;
  read_processor(&here);
  results_open(&to->out, o->results, "peers");
  printf("\n");
  say(&to->out,
      "Embree %s, one core, %u x %u primary rays (%u x %u where things move), the least times of %u rounds.\n\n",
      RTC_VERSION_STRING, o->size, o->size, o->moving_size, o->moving_size, o->rounds);
  say_lines(to, &here);
  say_speeds(to, "many",
      "Many rays: Mrays/s of pktrt's faster call (`_n`, `_soa`), the ratio to Embree's fastest mode, and that to its "
      "fastest robust one:");
  say_speeds(to, "single", "Single calls: Mrays/s of pktrt, the ratio to Embree's, and that to Embree's robust ones:");
  say_speeds(to, "fresh", "Single calls of rays that are written just before each call:");
  say_few(to);
  say_limits(to);
  say_upkeep(to);
  say_hits(to);
  write_csv(to);
  results_close(&to->out);
}

int main(int argc, char **argv) {
  static programme p;
  static report to, of_instances;
  pair pairs[MAX_PAIRS];
  double load = 0;
  bench_begin(argc, argv);
  if (!parse_options(argc, argv, &p)) return 2;
  const unsigned count = open_pairs(p.o.full, p.isas, pairs);
  if (count == 0) return ex_fail("--isa: this machine has none of these"), 1;
  if (getloadavg(&load, 1) == 1 && load > 0.5)
    printf("note: load average %.1f, other work is running: figures are noisy\n", load);
  pin();
  size_t wrong = run_all(&to, &p, pairs, count);
  const unsigned wide = pairs_of(&settings[HEADLINE], pairs, count);
  if (p.instances) wrong += run_field(&of_instances, &p.o, pairs, wide);
  if (p.stage_count) print_tables(&to, &p.o);
  if (p.instances) print_field(&of_instances, &p.o, pairs, wide);
  for (unsigned i = 0; i < count; i++)
    if (pairs[i].device) rtcReleaseDevice(pairs[i].device);
  for (unsigned i = 0; i < p.stage_count; i++) free(p.stages[i]);
  free(to.rows), free(of_instances.rows);
  return wrong ? ex_fail("pktrt contradicts itself on %zu rays", wrong), 1 : 0;
}
