/* pktrt beside itself: the header as it was at another commit, and as it is, on the same rays, in turns and in one process:

     make before BEFORE=2bc8427            built-in scenes at rest and moving, hard rays, all instruction sets
     build/before/race [--size N] [--rounds N] [--isa LIST] [--kinds LIST] [--spawn now] [--results DIR] [SCENE | FILE.tri[@CAMERA] ...]

   A speed is the time of the version before over that of the version now: 0.97 means that rays take three percent longer. Of each
   8,192 rays the least time over the rounds counts, in which both versions take turns. Rays leave surfaces by pktrt_spawn of the version before, so that both are asked what both can answer,
   or, with --spawn now, of that now. A first round is not timed but compared: rays whose triangle differs are counted.

   Contents: asking, hard rays, racing, report, main. */
static void spawn_chosen(const void *, const void *ray, const void *hit, const float direction[3], void *out);
#define SPAWN spawn_chosen
#include "peers/rays.h"
#include "peers/scenes.h"
#include "before.h"
#include <getopt.h>

/* >>asking --------------------------------------------------------------------------------------------------------- */

enum { BEFORE, NOW, VERSIONS, MAX_ROUNDS = 64, MAX_LINES = 256 };
static const version *const versions[VERSIONS] = {&version_before, &version_now};
static const char *const way_names[WAYS] = {"many", "rows", "single", "fresh"};

static struct { /* who makes the rays that leave hits: its own scene: the caller's is another version's */
  const version *by;
  void *scene;
} spawner;
static void spawn_chosen(const void *theirs, const void *ray, const void *hit, const float direction[3], void *out) {
  (void)theirs;
  spawner.by->spawn(spawner.scene, (const pktrt_ray *)ray, (const pktrt_hit *)hit, direction, (pktrt_ray *)out);
}

static void *open_in(const version *v, const stage *g, pktrt_isa isa) {
  before_mesh *meshes = (before_mesh *)take(g->s.mesh_count, sizeof *meshes);
  for (size_t i = 0; i < g->s.mesh_count; i++) {
    const scene_mesh *m = &g->s.meshes[i];
    meshes[i].positions = m->positions, meshes[i].indices = m->indices;
    meshes[i].vertex_count = m->vertex_count, meshes[i].triangle_count = m->triangle_count;
    meshes[i].key_count = m->key_count;
  }
  void *built = v->open(meshes, g->s.mesh_count, (int)isa);
  free(meshes);
  if (!built) fatal("a scene cannot be built");
  return built;
}

typedef struct room { /* for the answers of one version */
  pktrt_hit *hit;
  bool *occluded;
  float *real[6];
  uint32_t *index[2];
} room;

static room room_for(size_t most) {
  room r;
  r.hit = (pktrt_hit *)take(most, sizeof(pktrt_hit)), r.occluded = (bool *)take(most, sizeof(bool));
  for (int i = 0; i < 6; i++) r.real[i] = (float *)take(most, sizeof(float));
  for (int i = 0; i < 2; i++) r.index[i] = (uint32_t *)take(most, sizeof(uint32_t));
  return r;
}

static void room_free(room *r) {
  free(r->hit), free(r->occluded);
  for (int i = 0; i < 6; i++) free(r->real[i]);
  for (int i = 0; i < 2; i++) free(r->index[i]);
}

static question question_of(const ray_set *rays, bool occlusion, const room *r) {
  question q;
  q.ray = rays->ray, q.row = rays->array, q.count = rays->count, q.occlusion = occlusion;
  q.hit = r->hit, q.occluded = r->occluded;
  memcpy(q.real, r->real, sizeof q.real), memcpy(q.index, r->index, sizeof q.index);
  return q;
}

/* >>hard -----------------------------------------------------------------------------------------------------------

   Rays that single precision alone does not decide: through vertices and edges of a grid of 131,072 triangles, exactly, and at
   triangles a millionth of their distance wide; others on the same grid beside them. */

typedef enum hard { VERTICES, EDGES, DIAGONALS, OBLIQUE, OTHERS, TINY, HARD_KINDS } hard;
static const char *const hard_names[HARD_KINDS] = {"through vertices, along z", "through edges, along z",
    "through diagonals, along z", "through vertices, oblique", "random, on the same grid", "triangles of a millionth"};
static const char *const hard_words[HARD_KINDS] = {"vertices", "edges", "diagonals", "oblique", "others", "tiny"};
enum { CELLS = 256 };

static int random_below(uint64_t i, unsigned dimension, int n) { return (int)(uniform(i, dimension) * (float)n); }

/* Integers are its vertices, which a ray can meet exactly; those of TINY are scaled down, at a distance of 1. */
static void hard_stage(hard h, stage *g) {
  memset(g, 0, sizeof *g);
  stage_room(&g->s, 1);
  scene_mesh *m = &g->s.meshes[0];
  mesh_room(m, (CELLS + 1) * (CELLS + 1), 2 * CELLS * CELLS);
  for (uint32_t i = 0; i < m->vertex_count; i++) {
    const float v[3] = {(float)(i % (CELLS + 1)), (float)(i / (CELLS + 1)), (float)random_below(i, 0, 3)};
    for (int a = 0; a < 3; a++) m->positions[3 * i + (uint32_t)a] = h == TINY ? (a == 2) + 1e-6f * v[a] : v[a];
  }
  for (uint32_t i = 0; i < CELLS * CELLS; i++) {
    const uint32_t v = i / CELLS * (CELLS + 1) + i % CELLS, w = v + CELLS + 1;
    const uint32_t corners[6] = {v, v + 1, w + 1, v, w + 1, w};
    memcpy(&m->indices[6 * i], corners, sizeof corners);
  }
  stage_finish(g, h == TINY ? "tiny grid" : "grid", GENERATED);
}

static void hard_ray(hard h, const scene_mesh *m, uint64_t i, pktrt_ray *r) {
  const bool in_turn = h == VERTICES || h == EDGES || h == DIAGONALS; /* as a picture's rays are; others go anywhere */
  const uint32_t x = 1 + (in_turn ? (uint32_t)(i % (CELLS - 1)) : (uint32_t)random_below(i, 1, CELLS - 1));
  const uint32_t y =
      1 + (in_turn ? (uint32_t)(i / (CELLS - 1) % (CELLS - 1)) : (uint32_t)random_below(i, 2, CELLS - 1));
  const float *v = &m->positions[3 * (y * (CELLS + 1) + x)];
  memset(r, 0, sizeof *r);
  r->tmax = HUGE_VALF;
  for (int a = 0; a < 3; a++) r->origin[a] = v[a];
  r->direction[2] = -1, r->origin[2] = 64;
  if (h == EDGES) r->origin[i % 2] += 0.5f;
  if (h == DIAGONALS) r->origin[0] += 0.5f, r->origin[1] += 0.5f;
  if (h == OTHERS) r->origin[0] += uniform(i, 3), r->origin[1] += uniform(i, 4);
  if (h == OBLIQUE || h == OTHERS) {
    r->direction[0] = (float)random_below(i, 5, 7) - 3, r->direction[1] = (float)random_below(i, 6, 7) - 3;
    r->direction[2] = (float)random_below(i, 7, 4) - 7;
    for (int a = 0; a < 3; a++)
      r->origin[a] = (h == OTHERS ? r->origin[a] : v[a]) - (h == OTHERS ? 0 : 8 * r->direction[a]);
  }
  if (h != TINY) return;
  for (int a = 0; a < 3; a++)
    r->origin[a] = 0, r->direction[a] = v[a] + (a < 2 ? 1e-6f * uniform(i, 3 + (unsigned)a) : 0);
}

static void make_hard(hard h, const stage *g, size_t count, ray_set *out) {
  for (size_t i = 0; i < count; i++) hard_ray(h, &g->s.meshes[0], i, &out->ray[i]);
  out->count = count;
  make_arrays(out);
}

/* >>racing --------------------------------------------------------------------------------------------------------- */

typedef struct line { /* of the report: scene, instruction set, kind of rays */
  char scene[48];
  bool moving;
  pktrt_isa isa;
  int k; /* a kind, or KINDS and a hard one more */
  double rays, other, seconds[VERSIONS][WAYS], speed[WAYS];
} line;

typedef struct options {
  view_options view;
  unsigned size, rounds, isas, kinds, ways;
  bool new_spawn;
  const char *results;
} options;

static double count_other(const question *a, const question *b) {
  double n = 0;
  for (size_t i = 0; i < a->count; i++)
    n += a->occlusion ? a->occluded[i] != b->occluded[i]
                      : a->hit[i].mesh != b->hit[i].mesh || a->hit[i].triangle != b->hit[i].triangle;
  return n;
}

enum { PART = 8192 }; /* rays */

/* Makes a question of some of another's rays; `rows` holds their rows. */
static question part_of(const question *q, size_t first, size_t count, float *rows[9]) {
  question part = *q;
  part.ray += first, part.hit += first, part.occluded += first;
  for (int i = 0; i < 6; i++) part.real[i] += first;
  for (int i = 0; i < 2; i++) part.index[i] += first;
  for (int i = 0; i < 9; i++) rows[i] = q->row[i] ? q->row[i] + first : NULL;
  part.row = rows, part.count = count;
  return part;
}

/* Asks each version for some of the rays, in turns, and keeps the least times so far. */
static void race_part(void *const built[VERSIONS], const question q[VERSIONS], way w, size_t first, unsigned round,
    double least[VERSIONS]) {
  for (unsigned turn = 0; turn < VERSIONS; turn++) {
    const unsigned v = (turn + round) % VERSIONS;
    float *rows[9];
    const question part = part_of(&q[v], first, q->count - first < PART ? q->count - first : PART, rows);
    const double start = cpu_seconds();
    versions[v]->ask(built[v], w, &part);
    const double seconds = cpu_seconds() - start;
    if (!round || seconds < least[v]) least[v] = seconds;
  }
}

/* WHY few rays at a time: other work on the machine comes and goes, and for each of them some round goes by without it. */
static void race_kind(void *const built[VERSIONS], const question q[VERSIONS], unsigned rounds, line *to) {
  const size_t parts = (q->count + PART - 1) / PART;
  double(*const least)[WAYS][VERSIONS] = (double(*)[WAYS][VERSIONS])take(parts, sizeof *least);
  for (int v = 0; v < VERSIONS; v++) versions[v]->ask(built[v], MANY, &q[v]);
  to->other = count_other(&q[BEFORE], &q[NOW]);
  for (unsigned round = 0; round < rounds; round++)
    for (size_t i = 0; i < parts; i++)
      for (int w = 0; w < WAYS; w++) race_part(built, q, (way)w, i * PART, round, least[i][w]);
  for (int w = 0; w < WAYS; w++) {
    double sum[VERSIONS] = {0, 0};
    for (size_t i = 0; i < parts; i++)
      for (int v = 0; v < VERSIONS; v++) sum[v] += least[i][w][v];
    to->speed[w] = sum[BEFORE] / sum[NOW];
    for (int v = 0; v < VERSIONS; v++) to->seconds[v][w] = sum[v];
  }
  free(least);
}

typedef struct race { /* a stage in both versions, with one instruction set */
  const stage *g;
  bool moving;
  pktrt_isa isa;
  void *built[VERSIONS];
  room answers[VERSIONS];
  ray_set rays;
} race;

static race race_open(const stage *g, bool moving, pktrt_isa isa, size_t most) {
  race r;
  r.g = g, r.moving = moving, r.isa = isa, r.rays = rays_room(most);
  for (int v = 0; v < VERSIONS; v++) r.built[v] = open_in(versions[v], g, isa), r.answers[v] = room_for(most);
  return r;
}

static void race_close(race *r) {
  for (int v = 0; v < VERSIONS; v++) versions[v]->close(r->built[v]), room_free(&r->answers[v]);
  rays_free(&r->rays);
}

static void race_run(race *r, int k, bool occlusion, unsigned rounds, line *to) {
  question q[VERSIONS];
  for (int v = 0; v < VERSIONS; v++) q[v] = question_of(&r->rays, occlusion, &r->answers[v]);
  memset(to, 0, sizeof *to);
  snprintf(to->scene, sizeof to->scene, "%s", r->g->name);
  to->moving = r->moving, to->isa = r->isa, to->k = k, to->rays = (double)r->rays.count;
  race_kind(r->built, q, rounds, to);
}

/* All kinds of rays of a stage, and a hard one; they return how many lines there are. */
static size_t race_stage(const stage *g, bool moving, pktrt_isa isa, const options *o, line *to) {
  const size_t most = (size_t)o->size * o->size;
  size_t n = 0;
  sources s;
  race r = race_open(g, moving, isa, most);
  pktrt_scene *world = stage_scene(g, isa, false);
  if (pktrt_commit(world) != PKTRT_OK) fatal(pktrt_last_error(world));
  spawner.by = versions[o->new_spawn ? NOW : BEFORE], spawner.scene = r.built[o->new_spawn ? NOW : BEFORE];
  sources_room(&s, most);
  make_sources(g, world, o->size, moving, &s);
  for (int k = 0; k < KINDS; k++) {
    if (!(o->kinds >> k & 1)) continue;
    make_kind(g, world, (kind)k, &s, &r.rays);
    if (r.rays.count) race_run(&r, k, kind_occlusion((kind)k), o->rounds, &to[n++]);
  }
  pktrt_scene_destroy(world);
  sources_free(&s), race_close(&r);
  return n;
}

static size_t race_hard(hard h, pktrt_isa isa, const options *o, line *to) {
  const size_t most = (size_t)o->size * o->size;
  stage g;
  hard_stage(h, &g);
  race r = race_open(&g, false, isa, most);
  make_hard(h, &g, most, &r.rays);
  race_run(&r, KINDS + (int)h, false, o->rounds, to);
  race_close(&r), close_stage(&g);
  return 1;
}

/* >>report --------------------------------------------------------------------------------------------------------- */

static const char *name_of(int k) { return k < KINDS ? kind_names[k] : hard_names[k - KINDS]; }

static void write_csv(const results *to, const line *lines, size_t n) {
  csv(to, "scene,moving,isa,kind,rays,other_triangle,way,seconds_before,seconds_now,speed\n");
  for (size_t i = 0; i < n; i++)
    for (int w = 0; w < WAYS; w++)
      csv(to, "%s,%d,%s,\"%s\",%.0f,%.0f,%s,%.6f,%.6f,%.4f\n", lines[i].scene, lines[i].moving,
          pktrt_isa_string(lines[i].isa), name_of(lines[i].k), lines[i].rays, lines[i].other, way_names[w],
          lines[i].seconds[BEFORE][w], lines[i].seconds[NOW][w], lines[i].speed[w]);
}

/* The geometric mean over scenes at rest and moving, and the worst of them. */
static void write_cell(const results *to, const line *lines, size_t n, pktrt_isa isa, int w, int k) {
  double sum = 0, count = 0, worst = HUGE_VAL;
  for (size_t i = 0; i < n; i++) {
    if (lines[i].isa != isa || lines[i].k >= KINDS || (k < KINDS && lines[i].k != k)) continue;
    sum += log(lines[i].speed[w]), count++;
    worst = fmin(worst, lines[i].speed[w]);
  }
  if (count > 0) say(to, " %.3f (%.3f) |", exp(sum / count), worst);
  else say(to, " |");
}

static bool raced(const line *lines, size_t n, int isa, bool hard_ones) {
  for (size_t i = 0; i < n; i++)
    if (lines[i].isa == (pktrt_isa)isa && (lines[i].k >= KINDS) == hard_ones) return true;
  return false;
}

static void write_kinds(const results *to, const line *lines, size_t n) {
  say(to, "| kernels | calls |");
  for (int k = 0; k < KINDS; k++) say(to, " %s |", kind_names[k]);
  say(to, " all |\n|---|---|");
  for (int k = 0; k <= KINDS; k++) say(to, "--:|");
  say(to, "\n");
  for (int isa = PKTRT_ISA_NEON; isa > PKTRT_ISA_AUTO; isa--)
    for (int w = 0; w < WAYS && raced(lines, n, isa, false); w++) {
      say(to, "| %s | %s |", pktrt_isa_string((pktrt_isa)isa), way_names[w]);
      for (int k = 0; k <= KINDS; k++) write_cell(to, lines, n, (pktrt_isa)isa, w, k);
      say(to, "\n");
    }
}

static void write_hard(const results *to, const line *lines, size_t n) {
  say(to, "\nHard rays: ns a ray before, ns now, and the speed.\n\n| rays | kernels | many | single "
          "|\n|---|---|--:|--:|\n");
  for (int k = KINDS; k < KINDS + HARD_KINDS; k++)
    for (size_t i = n; i-- > 0;) {
      if (lines[i].k != k) continue;
      say(to, "| %s | %s |", name_of(k), pktrt_isa_string(lines[i].isa));
      for (int w = MANY; w < WAYS; w += SINGLE - MANY)
        say(to, " %.0f, %.0f: %.2f |", 1e9 * lines[i].seconds[BEFORE][w] / lines[i].rays,
            1e9 * lines[i].seconds[NOW][w] / lines[i].rays, lines[i].speed[w]);
      say(to, "\n");
    }
}

static void write_table(const results *to, const line *lines, size_t n) {
  bool any = false, any_hard = false;
  for (size_t i = 0; i < n; i++) any = any || lines[i].k < KINDS, any_hard = any_hard || lines[i].k >= KINDS;
  if (any) say(to, "Speed, the geometric mean over scenes at rest and moving; in brackets the worst.\n\n");
  if (any) write_kinds(to, lines, n);
  if (any_hard) write_hard(to, lines, n);
}

/* >>main ----------------------------------------------------------------------------------------------------------- */

static bool parse_list(const char *option, char *text, const char *const *words, unsigned *bits) {
  *bits = 0;
  for (char *word = strtok(text, ","); word; word = strtok(NULL, ",")) {
    int value = 0;
    if (!ex_parse_word(option, word, words, &value)) return false;
    *bits |= 1u << value;
  }
  return true;
}

static bool parse(int argc, char **argv, options *o) {
  static const struct option names[] = {{"size", 1, NULL, 's'}, {"rounds", 1, NULL, 'r'}, {"isa", 1, NULL, 'i'},
      {"kinds", 1, NULL, 'k'}, {"spawn", 1, NULL, 'p'}, {"results", 1, NULL, 'o'}, {NULL, 0, NULL, 0}};
  static const char *const isas[] = {"auto", "scalar", "sse2", "avx2", "avx512", "neon", NULL}; /* as pktrt_isa */
  static const char *words[KINDS + HARD_KINDS + 2] = {NULL}; /* "hard" is all of the hard ones */
  static const char *const spawns[] = {"before", "now", NULL};
  int key, now = 0;
  for (int k = 0; k < KINDS; k++) words[k] = kind_names[k];
  memcpy(words + KINDS, hard_words, sizeof hard_words), words[KINDS + HARD_KINDS] = "hard";
  while ((key = getopt_long(argc, argv, "", names, NULL)) != -1) {
    if (key == 's' && (!ex_parse_uint("size", optarg, 16, 4096, &o->size) || o->size % 16))
      return ex_fail("--size: want a multiple of 16 up to 4096");
    if (key == 'r' && !ex_parse_uint("rounds", optarg, 1, MAX_ROUNDS, &o->rounds)) return false;
    if (key == 'i' && !parse_list("isa", optarg, isas, &o->isas)) return false;
    if (key == 'k' && !parse_list("kinds", optarg, words, &o->kinds)) return false;
    if (key == 'p' && !ex_parse_word("spawn", optarg, spawns, &now)) return false;
    if (key == 'o') o->results = optarg;
    if (key == '?') return false;
  }
  o->new_spawn = now != 0;
  if (o->kinds >> (KINDS + HARD_KINDS) & 1) o->kinds |= ~0u << KINDS;
  return true;
}

static bool chosen(const options *o, int isa) { return o->isas >> isa & 1 && pktrt_isa_available((pktrt_isa)isa); }

int main(int argc, char **argv) {
  static const char *const scenes[3] = {"conference", "rtrt", "poolhall"};
  static line lines[MAX_LINES];
  options o;
  size_t n = 0;
  bench_begin(argc, argv);
  memset(&o, 0, sizeof o);
  o.size = 192, o.rounds = 7, o.view.up[1] = 1, o.isas = ~0u, o.kinds = ~0u;
  if (!parse(argc, argv, &o)) return 1;
  for (int v = 0; v < VERSIONS; v++)
    if (versions[v]->ray_bytes != sizeof(pktrt_ray) || versions[v]->hit_bytes != sizeof(pktrt_hit))
      fatal("rays or hits of the two versions differ");
  const int scene_count = argc > optind ? argc - optind : 3;
  for (int i = 0; i < (o.kinds & ((1u << KINDS) - 1) ? scene_count : 0); i++) {
    stage g;
    if (!open_stage(argc > optind ? argv[optind + i] : scenes[i], &o.view, &g)) return 1;
    for (int moving = 0; moving < 2; moving++) {
      set_motion(&g, moving ? 0.01 : 0, 0);
      for (int isa = PKTRT_ISA_AUTO + 1; isa <= PKTRT_ISA_NEON; isa++) {
        if (!chosen(&o, isa) || n + KINDS > MAX_LINES) continue;
        n += race_stage(&g, moving != 0, (pktrt_isa)isa, &o, &lines[n]);
        printf("%s, %s, %s: done\n", g.name, moving ? "moving" : "at rest", pktrt_isa_string((pktrt_isa)isa));
        fflush(stdout);
      }
    }
    close_stage(&g);
  }
  for (int h = 0; h < HARD_KINDS; h++)
    for (int isa = PKTRT_ISA_AUTO + 1; isa <= PKTRT_ISA_NEON; isa++)
      if (chosen(&o, isa) && o.kinds >> (KINDS + h) & 1 && n < MAX_LINES)
        n += race_hard((hard)h, (pktrt_isa)isa, &o, &lines[n]);
  results to;
  results_open(&to, o.results, "before");
  write_csv(&to, lines, n), write_table(&to, lines, n);
  results_close(&to);
  return 0;
}
