/* The results of Boulos et al. 2007, measured again on this machine, the paper's figures beside ours:

     make bench                                          builds it and measures all parts there are
     make bench NAME="table1 figure6" BENCH_ARGS="..."   some of them, with options
     make bench-check                                    what must hold, in small, and that its controls fail
     taskset -c 1 build/paper --results out table1       without make

   Everything runs on one thread; time is processor time. "Single ray" is meant as in the paper (section 5.2): primary
   rays travel in packets, all others one by one. What is compared is measured side by side: a first run of each
   counts the tests and is not timed, then every round runs each once, counting nothing, and medians are compared. (The
   paper path counts always, on both sides.) What is compared also makes the same picture, or the program fails, unless
   it is about another picture.

   How it is done stands in paper.h, what must hold in checks.h; the other headers hold further parts.

   Contents: parts, main. */
#include "amortise.h"
#include "checks.h"
#include "embree_rcs.h"
#include "kensler.h"
#include "paper.h"
#include "system.h"
#include <getopt.h>

/* >>parts ---------------------------------------------------------------------------------------------------------- */

/* Single rays and packets: Mrays/s of both, and how many times as fast. */
static void say_pair(const bench *b, const row *r) {
  say(&b->out, " %.2f | %.2f | %.2fx |", mrays(&r[0]), mrays(&r[1]), r[1].speedup);
}

/* The fast path's packets against the same waves of rays, made, set up and shaded together, of which each is traced by
   itself: what packets give to tracing alone. */
static void say_traversal(bench *b) {
  say(&b->out,
      "\nFast path, %s, 8x8, against waves whose rays, primary ones too, are traced one by one but set up and shaded "
      "together:",
      pktrt_isa_string(widest()));
  for (int k = 0; k < 3; k++) {
    setup ways[2];
    ways[0] = whitted(b, scenes[k]);
    column(columns() - 1, &ways[0]);
    ways[1] = ways[0];
    ways[0].path = PKTRT_PATH_SINGLE;
    const row *r = measure(b, ways, 2);
    say(&b->out, "%s %s %.2f to %.2f Mrays/s: %.2fx", k ? ";" : "", scenes[k], mrays(&r[0]), mrays(&r[1]),
        times_as_fast(b, &r[1], &r[0]));
  }
  say(&b->out, ".\n\n");
}

static void table1(bench *b) {
  static const struct {
    const char *scene;
    double single[4], types[4], speedup[4];
  } paper[3] = {{"conference", {0.37, 0.43, 0.44, 0.40}, {0.76, 1.14, 1.25, 1.00}, {2.02, 2.65, 2.85, 2.53}},
      {"rtrt", {1.09, 1.20, 1.22, 1.14}, {1.98, 2.85, 3.30, 3.02}, {1.82, 2.37, 2.69, 2.65}},
      {"poolhall", {0.64, 0.71, 0.73, 0.71}, {1.21, 1.85, 2.18, 2.10}, {1.89, 2.60, 2.97, 2.96}}};
  const row *r[3][COLUMNS][4];
  for (int k = 0; k < 3; k++)
    for (int c = 0; c < columns(); c++)
      for (int e = 0; e < 4; e++) {
        setup s = whitted(b, paper[k].scene);
        column(c, &s);
        s.packet = edges[e];
        r[k][c][e] = measure_pair(b, &s, paper[k].single[e], paper[k].types[e], paper[k].speedup[e]);
      }
  setup smooth = whitted(b, "conference");
  column(0, &smooth);
  smooth.normals = PKTRT_NORMALS_SMOOTH;
  smooth.varied = "interpolated normals", smooth.value = 1;
  const row *s = measure_pair(b, &smooth, 0, 0, 0);
  print_speeds(b);
  print_tests(b);
  say_machines(b);
  say(&b->out, "Mrays/s of single rays and of packets by ray type:\n\n| scene | packets | the paper: single | packets "
               "| speed-up |");
  say_columns(b, "|---|---|--:|--:|--:|");
  for (int k = 0; k < 3; k++)
    for (int e = 0; e < 4; e++) {
      say(&b->out, "| %s | %ux%u | %.2f | %.2f | %.2fx |", paper[k].scene, edges[e], edges[e], paper[k].single[e],
          paper[k].types[e], paper[k].speedup[e]);
      for (int c = 0; c < columns(); c++) say_pair(b, r[k][c][e]);
      say(&b->out, "\n");
    }
  say(&b->out, "\nConference reflects as its triangles lie. With interpolated normals, paper path, 8x8: ");
  say(&b->out, "%.2f to %.2f Mrays/s: %.2fx.\n", mrays(&s[0]), mrays(&s[1]), s[1].speedup);
  say_traversal(b);
}

static void table2(bench *b) {
  static const struct {
    const char *scene;
    double speed[3]; /* by mode */
  } paper[3] = {{"conference", {3.25, 1.79, 0.88}}, {"rtrt", {3.30, 2.00, 1.53}}, {"poolhall", {2.83, 0.83, 1.23}}};
  const row *r[3][COLUMNS][3];
  for (int k = 0; k < 3; k++)
    for (int c = 0; c < columns(); c++)
      for (int m = 0; m < 3; m++) {
        setup s = frame_of_table2(b, paper[k].scene, (pktrt_mode)m);
        column(c, &s);
        r[k][c][m] = measure_pair(b, &s, 0, paper[k].speed[m], 0);
      }
  print_speeds(b);
  print_tests(b);
  say_machines(b);
  say(&b->out,
      "Mrays/s of single rays and of packets of 8x8 by ray type; the paper has packets only:\n\n| scene | mode "
      "| the paper: packets |");
  say_columns(b, "|---|---|--:|");
  for (int k = 0; k < 3; k++)
    for (int m = 0; m < 3; m++) {
      say(&b->out, "| %s | %s | %.2f |", paper[k].scene, mode_names[m], paper[k].speed[m]);
      for (int c = 0; c < columns(); c++) say_pair(b, r[k][c][m]);
      say(&b->out, "\n");
    }
  say(&b->out, "\n");
}

static void table3(bench *b) {
  static const double single[3] = {0.42, 0.44, 0.29}, types[3] = {0.73, 0.88, 0.88}, speedup[3] = {1.86, 2.00, 3.03};
  const row *r[COLUMNS][3];
  for (int c = 0; c < columns(); c++)
    for (int e = 0; e < 3; e++) {
      setup s = one_frame(b, "conference", PKTRT_MODE_DRT, edges[e]);
      s.packet = edges[e]; /* as many rays as a pixel has samples */
      column(c, &s);
      r[c][e] = measure_pair(b, &s, single[e], types[e], speedup[e]);
    }
  print_speeds(b);
  print_tests(b);
  say_machines(b);
  say(&b->out, "Mrays/s of single rays and of packets by ray type:\n\n| samples | the paper: single | packets "
               "| speed-up |");
  say_columns(b, "|--:|--:|--:|--:|");
  for (int e = 0; e < 3; e++) {
    say(&b->out, "| %u | %.2f | %.2f | %.2fx |", edges[e] * edges[e], single[e], types[e], speedup[e]);
    for (int c = 0; c < columns(); c++) say_pair(b, r[c][e]);
    say(&b->out, "\n");
  }
  say(&b->out, "\n");
}

/* Both paths, the fast one on all lanes there are. */
static void path(int i, setup *s) { column(i ? columns() - 1 : 0, s); }

static void say_paths(const bench *b, const char *what) {
  for (int p = 0; p < 2; p++) {
    setup s = as_the_scene_is("conference");
    path(p, &s);
    say(&b->out, " %s path, %s: %s |", path_names[s.path], pktrt_isa_string(s.isa), what);
  }
}

static void say_work(const bench *b, const row *r) {
  say(&b->out, " %.1f / %.2f | %.2f |", per_ray(r->all.box_tests, &r->all), per_ray(r->all.triangle_tests, &r->all),
      mrays(r));
}

static void figure6(bench *b) {
  const row *r[3]; /* the last: the paper path with the paper's steps alone */
  for (int p = 0; p < 3; p++) {
    setup ways[4];
    for (int e = 0; e < 4; e++) {
      ways[e] = whitted(b, "conference");
      path(p % 2, &ways[e]);
      ways[e].packet = edges[e];
      if (p == 2) ways[e].steps = PKTRT_PAPER_STEPS_2007, ways[e].varied = "steps", ways[e].value = 2007;
    }
    r[p] = measure(b, ways, 4);
  }
  print_speeds(b);
  print_tests(b);
  say_machines(b);
  say(&b->out, "Tests per ray:\n\n| packets |");
  say_paths(b, "boxes / triangles | Mrays/s");
  say(&b->out, " paper path, steps of 2007: boxes / triangles | Mrays/s |\n|---|--:|--:|--:|--:|--:|--:|\n");
  for (int e = 0; e < 4; e++) {
    say(&b->out, "| %ux%u |", edges[e], edges[e]);
    for (int p = 0; p < 3; p++) say_work(b, &r[p][e]);
    say(&b->out, "\n");
  }
  say(&b->out, "\nBoxes are not comparable with the paper's: eight children share a node here, two do there.\n\n");
}

/* What figure 7 varies. The paper names the aperture's steps only, by their ends: nothing, and twice what is
   reasonable. */
enum { STEPS = 8 };
typedef enum feature { APERTURE, LIGHT_SIZE, GLOSS, OPEN_SHUTTER } feature;
static const struct {
  const char *name, *unit;
  int n;
  double steps[STEPS];
} features[] = {{"aperture", "of the lens as the scene has it", 5, {0, 0.5, 1, 1.5, 2}},
    {"light size", "of the lamps as the scene has them", 5, {0.01, 0.5, 1, 1.5, 2}},
    {"gloss", "exponent of the lobes", 5, {1, 10, 100, 1000, 10000}},
    {"shutter", "of the animation's loop", 8,
        {0, 1.0 / 480, 1.0 / 240, 1.0 / 120, 1.0 / 60, 1.0 / 30, 1.0 / 15, 1.0 / 8}}};

static setup featuring(const bench *b, const char *name, feature f, double value) {
  setup s = one_frame(b, name, PKTRT_MODE_DRT, 4);
  if (f == APERTURE) s.aperture = value;
  if (f == LIGHT_SIZE) s.light_size = value;
  if (f == GLOSS) s.exponent = value;
  if (f == OPEN_SHUTTER) s.shutter = value;
  s.varied = features[f].name, s.value = value;
  return s;
}

static void say_steps(const bench *b, const char *name, int f, const row *r[2][STEPS]) {
  const bool both = f == OPEN_SHUTTER;
  say(&b->out, "%s, %s, %s; tests per ray, %s:\n\n| %s |", features[f].name, features[f].unit, name,
      both ? "boxes that move / boxes united over time" : "boxes / triangles", features[f].name);
  say_paths(b, both ? "boxes | triangles | Mrays/s" : "boxes / triangles | Mrays/s");
  say(&b->out, "\n|--:|--:|--:|--:|--:|%s\n", both ? "--:|--:|" : "");
  for (int i = 0; i < features[f].n; i++) {
    if (both && i) say(&b->out, "| 1/%.0f |", 1 / features[f].steps[i]);
    else say(&b->out, "| %g |", features[f].steps[i]);
    for (int p = 0; p < 2; p++) {
      const row *x = r[p][i], *y = x + 1;
      if (!both) say_work(b, x);
      else
        say(&b->out, " %.1f / %.1f | %.2f / %.2f | %.2f / %.2f |", per_ray(x->all.box_tests, &x->all),
            per_ray(y->all.box_tests, &y->all), per_ray(x->all.triangle_tests, &x->all),
            per_ray(y->all.triangle_tests, &y->all), mrays(x), mrays(y));
    }
    say(&b->out, "\n");
  }
  say(&b->out, "\n");
}

/* One scene, one feature, both paths; the shutter with boxes that move and with such as do not. */
static void vary(bench *b, const char *name, feature f) {
  const row *r[2][STEPS];
  for (int p = 0; p < 2; p++)
    for (int i = 0; i < features[f].n; i++) {
      setup ways[2];
      ways[0] = featuring(b, name, f, features[f].steps[i]);
      path(p, &ways[0]);
      ways[1] = ways[0];
      ways[1].united = true;
      ways[1].varied = "shutter united";
      r[p][i] = measure(b, ways, f == OPEN_SHUTTER ? 2 : 1);
    }
  say_steps(b, name, (int)f, r);
}

static void figure7(bench *b) {
  say_machines(b);
  vary(b, "conference", APERTURE);
  vary(b, "conference", LIGHT_SIZE);
  vary(b, "conference", GLOSS);
  vary(b, "conference", OPEN_SHUTTER);
  vary(b, "rtrt", OPEN_SHUTTER); /* where half of all that is seen moves */
  print_speeds(b);
}

static void say_depth(const bench *b, const char *label, const pktrt_counts *p, const pktrt_counts *q) {
  if (p->rays)
    say(&b->out, "| %s | %llu | %.1f / %.1f | %.1f / %.1f | %.2f / %.2f |\n", label, (unsigned long long)p->rays,
        per_ray(p->vector_box_tests, p), per_ray(q->vector_box_tests, q), per_ray(p->box_tests, p),
        per_ray(q->box_tests, q), per_ray(p->triangle_tests, p), per_ray(q->triangle_tests, q));
}

/* Two assemblies, bounce by bounce; shadow rays count as one deeper than the surface that they leave. */
static void say_depths(const bench *b, const row *x, const row *y) {
  enum { SHOWN = 10 };
  pktrt_counts deeper[2];
  memset(deeper, 0, sizeof deeper);
  say(&b->out,
      "Paper path, %s, by bounces from the camera; %s / %s:\n\n"
      "| bounces | rays | vectors of box tests per ray | box tests per ray | triangle tests per ray |\n"
      "|--:|--:|--:|--:|--:|\n",
      x->s.scene, assembly_names[x->s.assembly], assembly_names[y->s.assembly]);
  for (int d = 0; d < PKTRT_MAX_DEPTH + 2; d++) {
    char label[32];
    snprintf(label, sizeof label, "%d", d);
    if (d <= SHOWN) say_depth(b, label, &x->stats.by_depth[d], &y->stats.by_depth[d]);
    else add_counts(&deeper[0], &x->stats.by_depth[d]), add_counts(&deeper[1], &y->stats.by_depth[d]);
  }
  say_depth(b, "deeper", &deeper[0], &deeper[1]);
  say_depth(b, "all", &x->all, &y->all);
  say(&b->out, "\n");
}

static void figure8(bench *b) {
  static const pktrt_assembly order[6] = {PKTRT_ASSEMBLY_RAY_TYPES, PKTRT_ASSEMBLY_RUNS, PKTRT_ASSEMBLY_MATERIALS,
      PKTRT_ASSEMBLY_OCTANTS, PKTRT_ASSEMBLY_BLIND, PKTRT_ASSEMBLY_NONE};
  static const char *const names[3] = {"conference", "rtrt", "poolhall"};
  const row *r[3][2];
  for (int k = 0; k < 3; k++)
    for (int p = 0; p < 2; p++) {
      setup ways[6];
      for (int a = 0; a < 6; a++) {
        ways[a] = pruned(b, names[k]);
        path(p, &ways[a]);
        ways[a].assembly = order[a];
      }
      r[k][p] = measure(b, ways, 6);
    }
  print_speeds(b);
  print_tests(b);
  say_machines(b);
  say(&b->out, "Tests per ray; speed, and that of ray types in times of it:\n\n| scene | assembly |");
  say_paths(b, "boxes / triangles | Mrays/s | ray types");
  say(&b->out, "\n|---|---|--:|--:|--:|--:|--:|--:|\n");
  for (int k = 0; k < 3; k++)
    for (int a = 0; a < 6; a++) {
      say(&b->out, "| %s | %s |", names[k], assembly_names[order[a]]);
      for (int p = 0; p < 2; p++) {
        say_work(b, &r[k][p][a]);
        say(&b->out, " %.2fx |", times_as_fast(b, &r[k][p][0], &r[k][p][a]));
      }
      say(&b->out, "\n");
    }
  say(&b->out, "\n");
  say_depths(b, &r[0][0][0], &r[0][0][1]);
}

/* Section 4 compares ways that make different pictures; each is told by a word, and compared with the first. */
static void say_ways(const bench *b, const char *what, const row *r, int n, const char *const *words) {
  say(&b->out, "| %s, %s path, %s %s | rays | boxes / triangles | Mrays/s | time |\n|---|--:|--:|--:|--:|\n", what,
      path_names[r->s.path], r->s.scene, mode_names[r->s.mode]);
  for (int i = 0; i < n; i++)
    say(&b->out, "| %s | %llu | %.1f / %.2f | %.2f | %.2fx |\n", words[i], (unsigned long long)r[i].all.rays,
        per_ray(r[i].all.box_tests, &r[i].all), per_ray(r[i].all.triangle_tests, &r[i].all), mrays(&r[i]),
        times_as_long(b, &r[i], r));
  say(&b->out, "\n");
}

/* "Instead of tracing N reflection and N refraction rays, we would trace only N rays total." */
static void branch(bench *b, const char *name) {
  static const char *const words[2] = {"chooses one way", "follows both"};
  for (int p = 0; p < 2; p++) {
    setup ways[2];
    ways[0] = one_frame(b, name, PKTRT_MODE_DRT, 4);
    path(p, &ways[0]);
    ways[0].varied = "branching";
    ways[1] = ways[0];
    ways[0].branching = PKTRT_BRANCHING_CHOOSE, ways[0].value = PKTRT_BRANCHING_CHOOSE;
    ways[1].branching = PKTRT_BRANCHING_BOTH, ways[1].value = PKTRT_BRANCHING_BOTH;
    ways[1].differs = true;
    say_ways(b, "glass", measure(b, ways, 2), 2, words);
  }
}

/* "Rendering performance is not highly dependent on the sample set used", and interleaving "does not negatively impact
   performance". */
static void sample(bench *b) {
  static const pktrt_sampler order[PKTRT_SAMPLER_COUNT] = {PKTRT_SAMPLER_JITTERED, PKTRT_SAMPLER_INTERLEAVED,
      PKTRT_SAMPLER_RANDOM, PKTRT_SAMPLER_HALTON, PKTRT_SAMPLER_HAMMERSLEY, PKTRT_SAMPLER_SOBOL,
      PKTRT_SAMPLER_BLUE_NOISE};
  const char *words[PKTRT_SAMPLER_COUNT];
  for (int p = 0; p < 2; p++) {
    setup ways[PKTRT_SAMPLER_COUNT];
    for (int i = 0; i < PKTRT_SAMPLER_COUNT; i++) {
      ways[i] = one_frame(b, "conference", PKTRT_MODE_DRT, 4);
      path(p, &ways[i]);
      ways[i].sampler = order[i], ways[i].differs = true;
      ways[i].varied = "sampler", ways[i].value = order[i];
      words[i] = pktrt_sampler_string(order[i]);
    }
    say_ways(b, "sampler", measure(b, ways, PKTRT_SAMPLER_COUNT), PKTRT_SAMPLER_COUNT, words);
  }
}

static void map_lobes(bench *b) {
  static const char *const words[4] = {"careful, Sobol", "naive, Sobol", "careful, Hammersley", "naive, Hammersley"};
  for (int p = 0; p < 2; p++) {
    setup ways[4];
    for (int i = 0; i < 4; i++) {
      ways[i] = one_frame(b, "conference", PKTRT_MODE_DRT, 4);
      path(p, &ways[i]);
      ways[i].mapping = i % 2 ? PKTRT_PHONG_NAIVE : PKTRT_PHONG_CAREFUL;
      ways[i].sampler = i < 2 ? PKTRT_SAMPLER_SOBOL : PKTRT_SAMPLER_HAMMERSLEY;
      ways[i].differs = true, ways[i].varied = "mapping and sampler", ways[i].value = i;
    }
    say_ways(b, "lobe", measure(b, ways, 4), 4, words);
  }
}

/* The false positives themselves: boxes that a ray enters without finding a hit beneath. The library tells of every
   box that a packet of the paper path enters, here a packet of one ray, in the order of their depth. */
typedef struct watch {
  uint32_t *parent; /* of each node; the root's is itself */
  uint64_t *round;  /* of each node: the ray that found a hit beneath it, counted from 1 */
  uint64_t ray, entered, true_hits;
  uint32_t from, leaf_parent;
  bool leaf_hit;
} watch;

static void watch_box(void *user, const pktrt_event *e) {
  watch *w = (watch *)user;
  switch (e->kind) {
  case PKTRT_EVENT_FIRST_HIT: w->entered++, w->from = e->index; break;
  case PKTRT_EVENT_NODE: w->parent[e->index] = e->index ? w->from : 0; break;
  case PKTRT_EVENT_LEAF: w->leaf_parent = w->from, w->leaf_hit = false; break;
  case PKTRT_EVENT_HIT:
    if (!w->leaf_hit) w->true_hits++;
    w->leaf_hit = true;
    for (uint32_t n = w->leaf_parent; n && w->round[n] != w->ray; n = w->parent[n]) {
      w->round[n] = w->ray;
      w->true_hits++;
    }
    break;
  default: break;
  }
}

typedef struct lobe_count {
  uint64_t rays, entered, false_hits;
} lobe_count;

static void watch_ray(const pktrt_scene *tree, watch *w, const pktrt_ray *ray, lobe_count *c) {
  pktrt_query_desc d;
  pktrt_hit hit;
  memset(&d, 0, sizeof d);
  d.path = PKTRT_PATH_PAPER, d.packet_size = 1, d.trace = watch_box, d.user = w;
  w->ray++, w->entered = w->true_hits = 0;
  pktrt_intersect_ex(tree, &d, ray, &hit, 1);
  c->rays++, c->entered += w->entered, c->false_hits += w->entered - w->true_hits;
}

/* The 16 points of Hammersley's set, none moved at random, the origin among them, into a lobe around the normal of a
   hit, which is where a mirror reflects what looks straight at it. The naive origin is then tangent to the surface. */
static void reflect_set(
    const pktrt_scene *tree, watch *w, const pktrt_ray *ray, const pktrt_hit *hit, lobe_count counts[2][2]) {
  static const unsigned char reversed[16] = {0, 8, 4, 12, 2, 10, 6, 14, 1, 9, 5, 13, 3, 11, 7, 15};
  float axis[3], along = 0, length = 0, out[3];
  for (int a = 0; a < 3; a++) {
    along += ray->direction[a] * hit->normal[a];
    length += hit->normal[a] * hit->normal[a];
  }
  for (int a = 0; a < 3; a++) axis[a] = (along < 0 ? 1 : -1) * hit->normal[a] / sqrtf(length);
  for (int i = 0; i < 32; i++) {
    const bool naive = i >= 16;
    const float u[2] = {(float)(i % 16) / 16, (float)reversed[i % 16] / 16};
    pktrt_ray leaving;
    (naive ? pktrt_map_phong_naive : pktrt_map_phong)(u, axis, EXPONENT, out);
    pktrt_spawn(tree, ray, hit, out, &leaving);
    watch_ray(tree, w, &leaving, &counts[naive][i % 16 == 0]);
  }
}

static void say_lobes(const bench *b, lobe_count counts[2][2]) {
  static const char *const names[2][2] = {{"careful, others", "careful, origin"}, {"naive, others", "naive, origin"}};
  say(&b->out,
      "Single rays off what a view of conference shows, into lobes of exponent %g around its normals, 16 each:\n\n"
      "| mapping, points | rays | boxes entered per ray | of them false |\n"
      "|---|--:|--:|--:|\n",
      (double)EXPONENT);
  for (int n = 0; n < 2; n++)
    for (int o = 0; o < 2; o++) {
      const lobe_count *c = &counts[n][o];
      const double rays = c->rays ? (double)c->rays : 1;
      say(&b->out, "| %s | %llu | %.1f | %.1f |\n", names[n][o], (unsigned long long)c->rays, (double)c->entered / rays,
          (double)c->false_hits / rays);
    }
  say(&b->out, "\n");
}

static void count_false_hits(bench *b) {
  enum { SIDE = 64 };
  setup s = whitted(b, "conference"); /* in this mode nothing moves, so there is one tree alone */
  lobe_count counts[2][2];
  pktrt_scene_info info;
  watch w;
  memset(counts, 0, sizeof counts);
  memset(&w, 0, sizeof w);
  open_setup(&b->now, &s);
  pktrt_get_scene_info(b->now.tree, &info);
  w.parent = (uint32_t *)calloc((size_t)info.nodes, sizeof *w.parent);
  w.round = (uint64_t *)calloc((size_t)info.nodes, sizeof *w.round);
  if (!w.parent || !w.round) fatal("not enough memory");
  for (int i = 0; i < SIDE * SIDE; i++) {
    pktrt_ray ray;
    pktrt_hit hit;
    look_through(&b->now.made.camera, ((double)(i % SIDE) + 0.5) / SIDE, ((double)(i / SIDE) + 0.5) / SIDE, &ray);
    if (pktrt_intersect(b->now.tree, &ray, &hit)) reflect_set(b->now.tree, &w, &ray, &hit, counts);
  }
  say_lobes(b, counts);
  free(w.parent);
  free(w.round);
}

static void section4(bench *b) {
  branch(b, "rtrt");
  branch(b, "poolhall");
  count_false_hits(b);
  map_lobes(b);
  sample(b);
  print_speeds(b);
  print_tests(b);
}

/* "Going from 4 samples per pixel to 16 samples per pixel can result in less than a 4x increase in rendering time":
   the same pixels with more samples, a pixel to a packet, and in packets of 8 x 8 whatever the samples. */
static void section5(bench *b) {
  static const char *const names[3] = {"conference", "rtrt", "poolhall"};
  say(&b->out, "| scene | path | packets | 4 samples, s | 16 | 64 | 16 over 4 | 64 over 16 |\n"
               "|---|---|---|--:|--:|--:|--:|--:|\n");
  for (int k = 0; k < 3; k++)
    for (int i = 0; i < 4; i++) {
      setup ways[3];
      for (int e = 0; e < 3; e++) {
        ways[e] = one_frame(b, names[k], PKTRT_MODE_DRT, 4); /* tiles of 16 x 16 pixels for all */
        path(i / 2, &ways[e]);
        ways[e].samples = edges[e] * edges[e];
        ways[e].packet = i % 2 ? 8 : edges[e];
        ways[e].differs = true;
      }
      const row *r = measure(b, ways, 3);
      say(&b->out, "| %s | %s | %s | %.3f | %.3f | %.3f | %.2fx | %.2fx |\n", names[k], path_names[r->s.path],
          i % 2 ? "8x8" : "a pixel", r[0].seconds, r[1].seconds, r[2].seconds, times_as_long(b, &r[1], &r[0]),
          times_as_long(b, &r[2], &r[1]));
    }
  say(&b->out, "\n");
  print_speeds(b);
}

static const struct part {
  const char *name, *sentence;
  void (*run)(bench *);
} parts[] = {
    {"table1", "Whitted's mode over the camera paths: single rays against packets by ray type, by packet size", table1},
    {"table2", "rays per second of one frame: ray casting, Whitted's, distribution ray tracing", table2},
    {"table3", "distribution ray tracing of conference, a pixel to a packet: single rays against packets", table3},
    {"figure6", "tests per ray of Whitted's mode against packet size, on conference", figure6},
    {"figure7", "distribution ray tracing as aperture, light size, gloss and shutter vary", figure7},
    {"figure8", "ray types, runs and other assemblies: tests per ray, by bounces from the camera, speed", figure8},
    {"section4", "branching, mapping to lobes, samplers: what they cost", section4},
    {"section5", "time of more samples of a pixel", section5},
    {"section31", "what SIMD alone and what amortisation gives, lanes in use", section31},
    {"amortisation", "which of our changes removes what packets of the paper save, in counts", amortisation},
    {"section6", "share of shading, scaling over cores, upkeep of deforming meshes", section6},
    {"frames", "frames per second by mode, size and samples", frames},
    {"kensler", "the triangle test of Kensler and Shirley beside ours, static and moving", kensler},
    {"embree_rcs", "ray casting with shading against Embree, which only traces the same rays", embree_rcs}};
enum { PARTS = sizeof parts / sizeof *parts };

/* >>main ----------------------------------------------------------------------------------------------------------- */

static void print_help(void) {
  printf("usage: paper [options] [NAME...]   the paper's results; run it by `taskset -c 1` on a quiet machine\n"
         "  --small       128 x 128 pixels, whole, one frame, one round\n"
         "  --size N      N x N pixels, a multiple of 64 from 64 to 4096 (512)\n"
         "  --frames N    of each camera path, 1 to %d (8)\n"
         "  --rounds N    timed, whose median counts, 1 to %d (5)\n"
         "  --every N     of N tiles of each frame of a path one is made, 1 to %d (64); of single frames eight\n"
         "  --results DIR NAME.csv and NAME.md of each part: all that was measured, and tables for the README\n"
         "  --check       instead of parts: what must hold, exit status 1 if anything does not\n"
         "  --check-counts, --check-controls   of these, what noise cannot change; whether controls fail\n"
         "  --help        this text\nNAME, without one all:\n",
      MAX_FRAMES, MAX_ROUNDS, MAX_EVERY);
  for (int i = 0; i < PARTS; i++) printf("  %-13s %s\n", parts[i].name, parts[i].sentence);
}

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
  case 'k': return o->check = true;
  case 'n': return o->check = o->counts = true;
  case 'x': return o->check = o->controls = true;
  case 'h': print_help(); exit(0);
  default: return false; /* getopt has said what */
  }
}

static bool parse_options(int argc, char **argv, options *o) {
  static const struct option list[] = {{"small", no_argument, NULL, 'm'}, {"size", required_argument, NULL, 's'},
      {"frames", required_argument, NULL, 'f'}, {"rounds", required_argument, NULL, 'r'},
      {"every", required_argument, NULL, 'e'}, {"results", required_argument, NULL, 'o'},
      {"check", no_argument, NULL, 'k'}, {"check-counts", no_argument, NULL, 'n'},
      {"check-controls", no_argument, NULL, 'x'}, {"help", no_argument, NULL, 'h'}, {NULL, 0, NULL, 0}};
  memset(o, 0, sizeof *o);
  for (int key; (key = getopt_long(argc, argv, "h", list, NULL)) != -1;)
    if (!parse_option(o, key)) return false;
  for (; optind < argc; optind++) {
    if (o->name_count == MAX_NAMES) return ex_fail("%s: one name too many", argv[optind]);
    o->names[o->name_count++] = argv[optind];
  }
  if (!o->size) o->size = 512;
  if (!o->frames) o->frames = o->check ? 6 : 8;
  if (!o->rounds) o->rounds = o->controls ? 1 : 5;
  if (!o->every) o->every = 64;
  if (o->counts) o->rounds = 0;
  return true;
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
  bool failed = false;
  bench_begin(argc, argv);
  if (!parse_options(argc, argv, &b.given) || !names_known(&b.given)) return 2;
  b.pixels = (float *)calloc((size_t)b.given.size * b.given.size * 3, sizeof(float));
  if (!b.pixels) return ex_fail("not enough memory for a picture of %u x %u", b.given.size, b.given.size), 1;
  if (getloadavg(&load, 1) == 1 && load > 0.5)
    printf("note: load average %.1f, other work is running: figures are noisy\n\n", load);
  printf("%u x %u pixels, one tile of %u; camera paths in %u frames; median of %u rounds; one thread\n\n", b.given.size,
      b.given.size, b.given.every, b.given.frames, b.given.rounds);
  if (b.given.check) failed = !check_all(&b);
  for (int i = 0; i < PARTS && !b.given.check; i++) {
    if (!wanted(&b.given, parts[i].name)) continue;
    results_open(&b.out, b.given.results, parts[i].name);
    b.row_count = 0;
    const double start = ex_seconds();
    printf("### %s: %s\n\n", parts[i].name, parts[i].sentence);
    parts[i].run(&b);
    if (b.row_count) csv_rows(&b);
    results_close(&b.out);
    fprintf(stderr, "%s: %.0f s\n", b.out.name, ex_seconds() - start);
    fflush(stdout);
  }
  close_world(&b.now);
  free(b.pixels);
  if (fflush(stdout) != 0) return ex_fail("the tables could not be written: %s", strerror(errno)), 1;
  return failed;
}
