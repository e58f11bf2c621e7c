/* What exactness costs: pktrt beside copies of itself whose kernels have the triangle tests of Kensler and Shirley
   (2006) and of Moeller and Trumbore (1997) instead of its own, on the same rays, in turns and in one process:

     make exactness                        built-in scenes at rest and moving, in three minutes
     build/exactness [--size N] [--rounds N] [--results DIR] [SCENE | FILE.tri[@CAMERA] ...]

   A ratio is the time of pktrt_intersect_n or pktrt_occluded_n over that of the same call of the copy: 1.1 means that
   exactness costs a tenth. The copies find t, u, v and the normal of what they hit as pktrt does, in double, once for
   each ray. What exactness buys is counted: rays for which the copy has another triangle, or none. How many rays need more
   than floats, asked one by one, is told by a third copy.

   Contents: libraries, racing, report, main. */
#include "peers/rays.h"
#include "peers/scenes.h"
#include "plain.h"
#include <getopt.h>

/* >>libraries ------------------------------------------------------------------------------------------------------ */

enum { OURS, KENSLER, MOLLER, LIBRARIES, MAX_ROUNDS = 64, MAX_LINES = 64 };
static const library ours = {"pktrt", pktrt_scene_create, pktrt_add_mesh, pktrt_commit, pktrt_scene_destroy,
    pktrt_intersect_n, pktrt_occluded_n};
static const library *const libraries[LIBRARIES] = {&ours, &kensler, &moller};

static pktrt_scene *scene_in(const library *l, const stage *g, pktrt_isa isa) {
  pktrt_scene_desc desc;
  memset(&desc, 0, sizeof desc);
  desc.isa = isa;
  pktrt_scene *world = l->create(&desc);
  for (size_t i = 0; world && i < g->s.mesh_count; i++) {
    const scene_mesh *m = &g->s.meshes[i];
    pktrt_mesh_desc d;
    memset(&d, 0, sizeof d);
    d.positions = m->positions, d.vertex_count = m->vertex_count, d.key_count = m->key_count;
    d.indices = m->indices, d.triangle_count = m->triangle_count;
    if (l->add_mesh(world, &d, NULL) != PKTRT_OK) fatal("a mesh is refused");
  }
  if (!world || l->commit(world) != PKTRT_OK) fatal("a scene cannot be built");
  return world;
}

/* >>racing --------------------------------------------------------------------------------------------------------- */

typedef struct answers {
  pktrt_hit *hit;
  bool *occluded;
} answers;

typedef struct line { /* of the report: scene and instruction set */
  char scene[48];
  bool moving;
  pktrt_isa isa;
  double rays[KINDS], seconds[LIBRARIES][KINDS], other[LIBRARIES][KINDS], lost[LIBRARIES][KINDS];
  double reached[2][KINDS]; /* rays that come to doubles, and to expansions */
} line;

typedef struct options {
  view_options view;
  unsigned size, rounds;
  const char *results;
} options;

static void trace_all(const library *l, const pktrt_scene *world, bool occlusion, const ray_set *r, answers *a) {
  if (occlusion) l->occluded(world, r->ray, a->occluded, r->count);
  else l->intersect(world, r->ray, a->hit, r->count);
}

static void compare(
    const ray_set *r, bool occlusion, const answers *a, const answers *mine, double *other, double *lost) {
  size_t differ = 0, none = 0;
  for (size_t i = 0; i < r->count; i++) {
    const pktrt_hit *x = &a->hit[i], *y = &mine->hit[i];
    const bool gone = occlusion ? mine->occluded[i] && !a->occluded[i] : x->mesh == PKTRT_NONE && y->mesh != PKTRT_NONE;
    none += gone;
    differ += occlusion ? mine->occluded[i] != a->occluded[i] : x->mesh != y->mesh || x->triangle != y->triangle;
  }
  *other = (double)differ, *lost = (double)none;
}

static void count_stages(
    const pktrt_scene *world, bool occlusion, const ray_set *r, double *doubles, double *expansions) {
  size_t n[2] = {0, 0};
  for (size_t i = 0; i < r->count; i++) {
    pktrt_hit hit;
    bool occluded;
    stages_reached = 0;
    if (occlusion) stages.occluded(world, &r->ray[i], &occluded, 1);
    else stages.intersect(world, &r->ray[i], &hit, 1);
    n[0] += stages_reached & 1, n[1] += stages_reached >> 1;
  }
  *doubles = (double)n[0], *expansions = (double)n[1];
}

/* A first round is not timed but compared. */
static void race_kind(pktrt_scene *const *world, kind k, const ray_set *r, unsigned rounds, answers *a, line *to) {
  const bool occlusion = kind_occlusion(k);
  double seconds[LIBRARIES][MAX_ROUNDS];
  for (unsigned round = 0; round <= rounds; round++)
    for (unsigned turn = 0; turn < LIBRARIES; turn++) {
      const unsigned l = round ? (round + turn) % LIBRARIES : turn; /* ours first where others are compared with it */
      const double start = cpu_seconds();
      trace_all(libraries[l], world[l], occlusion, r, &a[l]);
      if (round) seconds[l][round - 1] = cpu_seconds() - start;
      else compare(r, occlusion, &a[l], &a[OURS], &to->other[l][k], &to->lost[l][k]);
    }
  to->rays[k] = (double)r->count;
  for (int l = 0; l < LIBRARIES; l++) to->seconds[l][k] = median_of(seconds[l], rounds);
}

static void race(const stage *g, bool moving, pktrt_isa isa, const options *o, line *to) {
  const size_t most = (size_t)o->size * o->size;
  pktrt_scene *world[LIBRARIES], *told = scene_in(&stages, g, isa);
  answers a[LIBRARIES];
  sources s;
  ray_set rays = rays_room(most);
  memset(to, 0, sizeof *to);
  snprintf(to->scene, sizeof to->scene, "%s", g->name);
  to->moving = moving, to->isa = isa;
  for (int l = 0; l < LIBRARIES; l++) {
    world[l] = scene_in(libraries[l], g, isa);
    a[l].hit = (pktrt_hit *)take(most, sizeof(pktrt_hit)), a[l].occluded = (bool *)take(most, sizeof(bool));
  }
  sources_room(&s, most);
  make_sources(g, world[OURS], o->size, moving, &s);
  for (int k = 0; k < KINDS; k++) {
    make_kind(g, world[OURS], (kind)k, &s, &rays);
    if (rays.count) race_kind(world, (kind)k, &rays, o->rounds, a, to);
    count_stages(told, kind_occlusion((kind)k), &rays, &to->reached[0][k], &to->reached[1][k]);
  }
  stages.destroy(told);
  for (int l = 0; l < LIBRARIES; l++) {
    libraries[l]->destroy(world[l]);
    free(a[l].hit), free(a[l].occluded);
  }
  sources_free(&s), rays_free(&rays);
}

/* >>report --------------------------------------------------------------------------------------------------------- */

static double ratio_of(const line *x, int l, int k) {
  return x->seconds[OURS][k] / x->seconds[l][k]; /* NaN: no rays of this kind */
}

/* Of all kinds together: of one line, or of all lines at rest or moving on an instruction set. */
static double mean_ratio(const line *lines, size_t n, bool moving, pktrt_isa isa, int l, int k) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < n; i++)
    for (int j = k < 0 ? 0 : k; j < (k < 0 ? KINDS : k + 1); j++)
      if (lines[i].moving == moving && lines[i].isa == isa && lines[i].rays[j] > 0)
        sum += log(ratio_of(&lines[i], l, j)), count++;
  return count > 0 ? exp(sum / count) : 0;
}

static void write_csv(FILE *to, const line *lines, size_t n) {
  fprintf(to, "scene,moving,isa,kind,rays,test,seconds,pktrt_seconds,ratio,other_triangle,lost\n");
  for (size_t i = 0; i < n; i++)
    for (int k = 0; k < KINDS; k++)
      for (int l = KENSLER; l < LIBRARIES; l++)
        fprintf(to, "%s,%d,%s,%s,%.0f,%s,%.6f,%.6f,%.4f,%.0f,%.0f\n", lines[i].scene, lines[i].moving,
            pktrt_isa_string(lines[i].isa), kind_names[k], lines[i].rays[k], libraries[l]->name, lines[i].seconds[l][k],
            lines[i].seconds[OURS][k], ratio_of(&lines[i], l, k), lines[i].other[l][k], lines[i].lost[l][k]);
}

static void write_table(FILE *to, const line *lines, size_t n) {
  fprintf(to,
      "Time of pktrt over that of its copies with the tests of Kensler and Shirley / Moeller and Trumbore; the last "
      "column: of a million rays, those for which the copy has another triangle or none; those for which it has "
      "none where there is one.\n\n");
  fprintf(to, "| scene | | kernels |");
  for (int k = 0; k < KINDS; k++) fprintf(to, " %s |", kind_names[k]);
  fprintf(to, " all | other, lost |\n|---|---|---|");
  for (int k = 0; k <= KINDS; k++) fprintf(to, "--:|");
  fprintf(to, "--:|\n");
  for (size_t i = 0; i < n; i++) {
    const line *x = &lines[i];
    double rays = 0, other[LIBRARIES] = {0, 0, 0}, lost[LIBRARIES] = {0, 0, 0};
    fprintf(to, "| %s | %s | %s |", x->scene, x->moving ? "moving" : "rest", pktrt_isa_string(x->isa));
    for (int k = 0; k < KINDS; k++) {
      fprintf(to, " %.2f / %.2f |", ratio_of(x, KENSLER, k), ratio_of(x, MOLLER, k));
      rays += x->rays[k] * 1e-6;
      for (int l = KENSLER; l < LIBRARIES; l++) other[l] += x->other[l][k], lost[l] += x->lost[l][k];
    }
    fprintf(to, " %.2f / %.2f |", mean_ratio(x, 1, x->moving, x->isa, KENSLER, -1),
        mean_ratio(x, 1, x->moving, x->isa, MOLLER, -1));
    fprintf(to, " %.1f, %.1f / %.1f, %.1f |\n", other[KENSLER] / rays, lost[KENSLER] / rays, other[MOLLER] / rays,
        lost[MOLLER] / rays);
  }
  for (int i = 0; i < 4; i++) {
    static const pktrt_isa sets[2] = {PKTRT_ISA_AVX512, PKTRT_ISA_AVX2};
    const bool moving = i / 2 != 0;
    const pktrt_isa isa = sets[i % 2];
    if (!(mean_ratio(lines, n, moving, isa, KENSLER, -1) > 0)) continue;
    fprintf(to, "| **geometric mean** | %s | %s |", moving ? "moving" : "rest", pktrt_isa_string(isa));
    for (int k = 0; k <= KINDS; k++)
      fprintf(to, " %.2f / %.2f |", mean_ratio(lines, n, moving, isa, KENSLER, k < KINDS ? k : -1),
          mean_ratio(lines, n, moving, isa, MOLLER, k < KINDS ? k : -1));
    fprintf(to, " |\n");
  }
}

static void write_stages_csv(FILE *to, const line *lines, size_t n) {
  fprintf(to, "scene,moving,isa,kind,rays,doubles,expansions\n");
  for (size_t i = 0; i < n; i++)
    for (int k = 0; k < KINDS; k++)
      fprintf(to, "%s,%d,%s,%s,%.0f,%.0f,%.0f\n", lines[i].scene, lines[i].moving, pktrt_isa_string(lines[i].isa),
          kind_names[k], lines[i].rays[k], lines[i].reached[0][k], lines[i].reached[1][k]);
}

static void write_stages(FILE *to, const line *lines, size_t n) {
  fprintf(to,
      "Of a hundred rays, asked one by one: those with a triangle that floats leave to doubles / that doubles leave "
      "to expansions.\n\n| scene | | kernels |");
  for (int k = 0; k < KINDS; k++) fprintf(to, " %s |", kind_names[k]);
  fprintf(to, "\n|---|---|---|");
  for (int k = 0; k < KINDS; k++) fprintf(to, "--:|");
  fprintf(to, "\n");
  for (size_t i = 0; i < n; i++) {
    const line *x = &lines[i];
    fprintf(to, "| %s | %s | %s |", x->scene, x->moving ? "moving" : "rest", pktrt_isa_string(x->isa));
    for (int k = 0; k < KINDS; k++)
      fprintf(to, " %.2f / %.4f |", 100 * x->reached[0][k] / fmax(x->rays[k], 1),
          100 * x->reached[1][k] / fmax(x->rays[k], 1));
    fprintf(to, "\n");
  }
}

static bool keep(
    const char *directory, const char *name, void (*write)(FILE *, const line *, size_t), const line *lines, size_t n) {
  char path[4096];
  snprintf(path, sizeof path, "%s/%s", directory, name);
  FILE *to = fopen(path, "w");
  if (!to) return ex_fail("%s: cannot be written: %s", path, strerror(errno));
  if (strstr(name, ".csv")) write_provenance(to, bench_command);
  write(to, lines, n);
  return fclose(to) == 0 || ex_fail("%s: cannot be written: %s", path, strerror(errno));
}

/* >>main ----------------------------------------------------------------------------------------------------------- */

static bool parse(int argc, char **argv, options *o) {
  static const struct option names[] = {
      {"size", 1, NULL, 's'}, {"rounds", 1, NULL, 'r'}, {"results", 1, NULL, 'o'}, {NULL, 0, NULL, 0}};
  int key;
  while ((key = getopt_long(argc, argv, "", names, NULL)) != -1) {
    if (key == 's' && (!ex_parse_uint("size", optarg, 16, 4096, &o->size) || o->size % 16))
      return ex_fail("--size: want a multiple of 16 up to 4096");
    if (key == 'r' && !ex_parse_uint("rounds", optarg, 1, MAX_ROUNDS, &o->rounds)) return false;
    if (key == 'o') o->results = optarg;
    if (key == '?') return false;
  }
  return true;
}

int main(int argc, char **argv) {
  static const pktrt_isa sets[2] = {PKTRT_ISA_AVX512, PKTRT_ISA_AVX2};
  static const char *const scenes[3] = {"conference", "rtrt", "poolhall"};
  static line lines[MAX_LINES];
  options o;
  size_t n = 0;
  bench_begin(argc, argv);
  memset(&o, 0, sizeof o);
  o.size = 768, o.rounds = 5, o.view.up[1] = 1;
  if (!parse(argc, argv, &o)) return 1;
  for (int i = 0; i < (argc > optind ? argc - optind : 3); i++) {
    stage g;
    if (!open_stage(argc > optind ? argv[optind + i] : scenes[i], &o.view, &g)) return 1;
    for (int turn = 0; turn < 4 && n < MAX_LINES; turn++) {
      if (turn % 2 == 0) set_motion(&g, turn / 2 ? 0.01 : 0, 0);
      if (!pktrt_isa_available(sets[turn % 2])) continue;
      race(&g, turn / 2 != 0, sets[turn % 2], &o, &lines[n++]);
      printf("%s, %s, %s: %.3f of Kensler and Shirley's time, %.3f of Moeller and Trumbore's\n", g.name,
          turn / 2 ? "moving" : "at rest", pktrt_isa_string(sets[turn % 2]),
          mean_ratio(&lines[n - 1], 1, turn / 2 != 0, sets[turn % 2], KENSLER, -1),
          mean_ratio(&lines[n - 1], 1, turn / 2 != 0, sets[turn % 2], MOLLER, -1));
    }
    close_stage(&g);
  }
  if (n == 0) return ex_fail("this machine has no kernels of these"), 1;
  write_table(stdout, lines, n), write_stages(stdout, lines, n);
  return o.results && (!keep(o.results, "exactness.csv", write_csv, lines, n) ||
                          !keep(o.results, "exactness.md", write_table, lines, n) ||
                          !keep(o.results, "exactness_stages.csv", write_stages_csv, lines, n) ||
                          !keep(o.results, "exactness_stages.md", write_stages, lines, n));
}
