/* The results of Boulos et al. 2007, measured again on this machine, the paper's figures beside ours:

     make bench                                          builds it and measures all parts there are
     make bench NAME="table1 figure6" BENCH_ARGS="..."   some of them, with options
     taskset -c 1 build/paper --results bench/results    on a core of its own, for figures to keep

   Everything runs on one thread; time is processor time. "Single ray" is meant as in the paper (section 5.2): primary
   rays travel in packets, all others one by one. What is compared is measured side by side: a first run of each
   counts the tests and is not timed, then every round runs each once, counting nothing, and medians are compared. (The
   paper path counts always, on both sides.) What is compared also makes the same picture, or the program fails.

   How it is done stands in paper.h; parts that are no matter of pictures stand in paper_system.h.

   Contents: parts, main. */
#include "paper.h"
#include "paper_system.h"

/* >>parts ---------------------------------------------------------------------------------------------------------- */

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
         "  --results DIR NAME.csv and NAME.md of each part: all that was measured, and tables for the README\n"
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
  b.pixels = (float *)calloc((size_t)b.given.size * b.given.size * 3, sizeof(float));
  if (!b.pixels) return ex_fail("not enough memory for a picture of %u x %u", b.given.size, b.given.size), 1;
  if (getloadavg(&load, 1) == 1 && load > 0.5)
    printf("note: load average %.1f, other work is running: figures are noisy\n\n", load);
  printf("%u x %u pixels, one tile of %u; camera paths in %u frames; median of %u rounds; one thread\n\n", b.given.size,
         b.given.size, b.given.every, b.given.frames, b.given.rounds);
  for (int i = 0; i < PARTS; i++) {
    if (!wanted(&b.given, parts[i].name)) continue;
    b.part = parts[i].name, b.row_count = 0;
    b.csv = open_result(&b, "csv"), b.md = open_result(&b, "md");
    printf("### %s: %s\n\n", parts[i].name, parts[i].sentence);
    parts[i].run(&b);
    if (b.row_count) csv_rows(&b);
    close_result(b.csv), close_result(b.md);
    fflush(stdout);
  }
  close_world(&b.now);
  free(b.pixels);
  if (fflush(stdout) != 0) return ex_fail("the tables could not be written: %s", strerror(errno)), 1;
  return 0;
}
