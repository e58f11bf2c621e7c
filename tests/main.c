/* The test binary: test [--small] [--first] [--list] [--seed N] [filter...] runs the tests whose sentence contains one of the filters.
   --thorough X makes the cases of stability.h longer or shorter (1: as long as they get), --results DIR keeps their figures.
   --first ends with the first test that fails. --jobs N runs tests in N processes, which take one after the other.
   PKTRT_TEST_ALL=1 in the environment prints every failure, not the first six of a test. */
#define _DEFAULT_SOURCE /* MAP_ANONYMOUS */
#include "stability.h"
#include <stdarg.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <time.h>
#include <unistd.h>

bool small_run;
double thoroughness;
uint64_t run_seed;
test_hooks hooks = {PTHREAD_MUTEX_INITIALIZER, 0, 0, 0, 0, 0, false, 0, 0, 0, 0, "", 0};
pktrt_isa isas[8];
int isa_count;

/* What the processes of a run share: how many tests were taken, passed and failed. */
typedef struct tally {
  int taken, passed, failed;
} tally;
static tally alone, *all = &alone;
static int met;          /* what this process could have taken so far, whoever did */
static bool whole_suite; /* this process has taken all tests of a suite */

static char **filters;
static int filter_count;
static bool list_only, first_only;
static int failures; /* of the running test */
static char remarks[4096];
static pthread_mutex_t report_lock = PTHREAD_MUTEX_INITIALIZER;

size_t scaled(size_t count) {
  size_t few = count / 40;
  return !small_run ? count : few ? few : 1;
}

size_t thorough(size_t count) {
  const double part = (double)count * thoroughness;
  return part < 1 ? 1 : (size_t)part;
}

bool check_at(bool ok, const char *file, int line, const char *what, ...) {
  if (ok) return true;
  pthread_mutex_lock(&report_lock);
  if (failures++ < (getenv("PKTRT_TEST_ALL") ? 1000 : 6)) {
    va_list args;
    va_start(args, what);
    printf("    %s:%d: ", file, line);
    vprintf(what, args);
    printf("\n");
    va_end(args);
  }
  pthread_mutex_unlock(&report_lock);
  return false;
}

void say(const char *format, ...) {
  size_t used = strlen(remarks);
  if (used + 8 > sizeof remarks) return;
  va_list args;
  va_start(args, format);
  int n = snprintf(remarks + used, sizeof remarks - used, "           ");
  vsnprintf(remarks + used + n, sizeof remarks - used - (size_t)n - 1, format, args);
  va_end(args);
  strcat(remarks, "\n");
}

static double seconds(void) {
  struct timespec t;
  clock_gettime(CLOCK_MONOTONIC, &t);
  return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Words pick tests; words after a + leave out some of these. */
static bool wanted(const char *sentence) {
  bool in = filter_count == 0 || filters[0][0] == '+', out = false;
  for (int i = 0; i < filter_count; i++) {
    const bool leaves_out = filters[i][0] == '+';
    if (strstr(sentence, filters[i] + leaves_out)) *(leaves_out ? &out : &in) = true;
  }
  return in && !out;
}

/* Takes the next test or suite for this process, unless another has. */
static bool take(void) {
  const int number = met++;
  return __sync_bool_compare_and_swap(&all->taken, number, number + 1);
}

void run(const char *sentence, void (*test)(void)) {
  if (!wanted(sentence)) return;
  if (list_only) {
    printf("%s\n", sentence);
    return;
  }
  if (!whole_suite && !take()) return;
  failures = 0;
  remarks[0] = 0;
  hooks.fail_at = hooks.limit = 0;
  double start = seconds();
  test();
  CHECK(hooks.live_blocks == 0, "%zu blocks, %zu bytes leaked", hooks.live_blocks, hooks.live_bytes);
  hooks.live_blocks = hooks.live_bytes = 0;
  if (failures > 6) printf("    ... %d failures in all\n", failures);
  printf("%s %6.2f s  %s\n%s", failures ? "FAILED" : "passed", seconds() - start, sentence, remarks);
  fflush(stdout);
  __sync_fetch_and_add(failures ? &all->failed : &all->passed, 1);
  if (failures && first_only) exit(1);
}

/* --- hooks --- */

/* Every block is guarded at both ends and remembers its size. */
enum { GUARD = 64 };

static void *count_allocate(void *user, size_t size, size_t align) {
  test_hooks *h = user;
  pthread_mutex_lock(&h->lock);
  h->calls++;
  bool fail = (h->limit && size > h->limit) || (h->fail_after && h->fail_at == 1);
  if (h->fail_at > 1) h->fail_at--;
  else if (h->fail_at == 1) {
    fail = true;
    if (!h->fail_after) h->fail_at = 0;
  }
  h->failed += fail;
  pthread_mutex_unlock(&h->lock);
  if (!CHECK(align && !(align & (align - 1)) && align <= GUARD, "alignment %zu asked for", align)) return NULL;
  unsigned char *raw = NULL;
  if (fail || size > SIZE_MAX - 2 * GUARD) return NULL;
  if (posix_memalign((void **)&raw, GUARD, size + 2 * GUARD)) return NULL;
  memset(raw, 0xA5, size + 2 * GUARD); /* also: whoever reads memory before writing it sees rubbish */
  memcpy(raw, &size, sizeof size);
  pthread_mutex_lock(&h->lock);
  h->live_blocks++;
  h->live_bytes += size;
  if (h->live_bytes > h->peak_bytes) h->peak_bytes = h->live_bytes;
  pthread_mutex_unlock(&h->lock);
  return raw + GUARD;
}

static void count_release(void *user, void *p, size_t size) {
  test_hooks *h = user;
  if (!CHECK(p != NULL, "NULL released")) return;
  unsigned char *raw = (unsigned char *)p - GUARD;
  size_t was;
  memcpy(&was, raw, sizeof was);
  bool intact = was == size;
  for (size_t i = sizeof was; i < GUARD; i++) intact &= raw[i] == 0xA5;
  for (size_t i = 0; i < GUARD && was == size; i++) intact &= raw[GUARD + size + i] == 0xA5;
  CHECK(intact, "block of %zu bytes released as %zu bytes, or overrun", was, size);
  pthread_mutex_lock(&h->lock);
  h->live_blocks--;
  h->live_bytes -= was;
  pthread_mutex_unlock(&h->lock);
  memset(p, 0x5A, was);
  free(raw);
}

typedef struct pool {
  pthread_mutex_t lock;
  size_t next, n;
  void (*body)(void *, size_t);
  void *arg;
} pool;

static void *pool_worker(void *p) {
  pool *w = p;
  for (;;) {
    pthread_mutex_lock(&w->lock);
    size_t i = w->next++;
    pthread_mutex_unlock(&w->lock);
    if (i >= w->n) return NULL;
    w->body(w->arg, i);
  }
}

void threads_for(int workers, size_t n, void (*body)(void *arg, size_t i), void *arg) {
  pool w = {PTHREAD_MUTEX_INITIALIZER, 0, n, body, arg};
  pthread_t thread[16];
  int started = 0;
  while (started < workers - 1 && started < 15 && pthread_create(&thread[started], NULL, pool_worker, &w) == 0)
    started++;
  pool_worker(&w);
  while (started > 0) pthread_join(thread[--started], NULL);
}

#ifdef __EMSCRIPTEN__ /* there are no threads without workers, but a stack is memory like any other */
void *stackSave(void);
void stackRestore(void *top);
void run_on_stack(void *memory, size_t size, void *(*body)(void *arg), void *arg) {
  void *const before = stackSave(), *mine = NULL;
  if (!memory && posix_memalign(&mine, 4096, size)) abort();
  stackRestore((char *)(memory ? memory : mine) + size);
  body(arg);
  stackRestore(before);
  free(mine);
}
#else
void run_on_stack(void *memory, size_t size, void *(*body)(void *arg), void *arg) {
  pthread_attr_t attr;
  pthread_t t;
  pthread_attr_init(&attr);
  CHECK((memory ? pthread_attr_setstack(&attr, memory, size) : pthread_attr_setstacksize(&attr, size)) == 0);
  if (CHECK(pthread_create(&t, &attr, body, arg) == 0)) pthread_join(t, NULL);
  pthread_attr_destroy(&attr);
}
#endif

static void hook_parallel(void *user, size_t n, void (*body)(void *arg, size_t i), void *arg) {
  threads_for(((test_hooks *)user)->workers, n, body, arg);
}

static void hook_log(void *user, int level, const char *sentence) {
  test_hooks *h = user;
  CHECK(sentence && sentence[0] && !strchr(sentence, '\n'), "a log sentence is one line");
  pthread_mutex_lock(&h->lock);
  if (level == 0) h->warnings++;
  else h->notes++;
  snprintf(h->last_log, sizeof h->last_log, "%s", sentence);
  pthread_mutex_unlock(&h->lock);
}

pktrt_scene_desc scene_desc_of(pktrt_isa isa, int workers) {
  pktrt_scene_desc d;
  memset(&d, 0, sizeof d);
  d.allocate = count_allocate;
  d.release = count_release;
  d.log = hook_log;
  d.user = &hooks;
  d.isa = isa;
  if (workers) d.parallel_for = hook_parallel;
  if (workers) hooks.workers = workers;
  return d;
}

static void run_all(void) {
  whole_suite = take();
  if (whole_suite) suite_tree(), suite_stability(); /* the last test looks at the figures of all these */
  whole_suite = false;
  suite_arithmetic();
  suite_settings();
  suite_refusals();
  suite_scene();
  suite_events();
  suite_teaching();
  suite_counts();
  suite_memory();
  suite_truth();
  suite_extremes();
  suite_watertight();
  suite_slack();
  suite_splits();
  suite_work();
  suite_examples();
  suite_filter();
  suite_spawn();
  suite_edges();
  suite_sampler();
  suite_render();
  suite_shading();
  suite_lights();
  suite_flush();
  suite_media();
  suite_assembly();
  suite_pictures();
  suite_passes();
  suite_display();
  suite_mistakes();
  suite_report();
  suite_instances();
  suite_mirrored();
  suite_everyday();
  suite_cameras();
  suite_bent();
  suite_rigid();
  suite_pool();
  suite_closest();
  suite_thin();
  suite_manual();
  suite_groups();
  suite_changes();
  suite_surfaces();
  suite_guards();
  suite_pairs();
  suite_variance();
  suite_cover();
  suite_identity();
}

/* Runs all tests in so many processes. What a test says is written when it ends. */
static void run_side_by_side(int jobs) {
  void *shared = mmap(NULL, sizeof *all, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (shared == MAP_FAILED) abort();
  all = shared;
  fflush(stdout);
  setvbuf(stdout, NULL, _IOFBF, 1 << 16);
  for (int i = 1; i < jobs; i++) {
    if (fork() != 0) continue;
    run_all();
    exit(0);
  }
  run_all();
  for (int status; wait(&status) > 0;) {
    if (status == 0) continue;
    printf("FAILED  a process ended with status %d, and with it a test\n", status);
    all->failed++;
  }
}

int main(int argc, char **argv) {
  filters = calloc((size_t)argc + 1, sizeof *filters);
  const char *results = NULL;
  int jobs = 1;
  if (!filters) return 2;
  small_run = getenv("PKTRT_TEST_SMALL") != NULL;
  for (int i = 1; i < argc; i++) {
    if (strcmp(argv[i], "--small") == 0) small_run = true;
    else if (strcmp(argv[i], "--list") == 0) list_only = true;
    else if (strcmp(argv[i], "--first") == 0) first_only = true;
    else if (strcmp(argv[i], "--jobs") == 0 && i + 1 < argc) jobs = atoi(argv[++i]);
    else if (strcmp(argv[i], "--seed") == 0 && i + 1 < argc) run_seed = strtoull(argv[++i], NULL, 10);
    else if (strcmp(argv[i], "--thorough") == 0 && i + 1 < argc) thoroughness = atof(argv[++i]);
    else if (strcmp(argv[i], "--results") == 0 && i + 1 < argc) results = argv[++i];
    else if (argv[i][0] == '-') {
      fprintf(stderr, "usage: test [--small] [--first] [--jobs N] [--thorough X] [--results DIR] [--list] [--seed N] "
                      "[words of a test's sentence, or +words not of it ...]\n");
      return 2;
    } else filters[filter_count++] = argv[i];
  }
  if (results || list_only) jobs = 1; /* figures are kept by one process */
  if (!(thoroughness > 0)) thoroughness = small_run ? 0.001 : 0.01;
  for (int i = PKTRT_ISA_SCALAR; i < PKTRT_ISA_COUNT; i++) {
    if (pktrt_isa_available((pktrt_isa)i)) isas[isa_count++] = (pktrt_isa)i;
  }
  if (!list_only) {
    printf("instruction sets:");
    for (int i = 0; i < isa_count; i++) printf(" %s", pktrt_isa_string(isas[i]));
    printf("%s\n", small_run ? " (small run)" : "");
  }
  if (jobs > 1) run_side_by_side(jobs);
  else run_all();
  free(filters);
  if (list_only) return 0;
  if (results && !keep_figures(results, argc, argv)) all->failed++;
  printf("%d passed, %d failed\n", all->passed, all->failed);
  return all->failed || all->passed == 0;
}
