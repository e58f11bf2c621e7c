/* Looks after examples/threads.h, by pthreads and by Win32: each check says what holds, and has a control that fails. */
#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#define PKTRT_IMPLEMENTATION
#include "pktrt.h"

#include "../../examples/threads.h"
#include <stdio.h>

enum { MOST = 70000, SEEN = 64 };

static int passed, failed;

static void check(bool good, const char *sentence) {
  printf("%s  %s\n", good ? "passed" : "FAILED", sentence);
  if (good) passed++;
  else failed++;
}

typedef struct job {
  ex_mutex lock;
  ex_threads *threads; /* of calls from within a call */
  unsigned char runs[MOST];
  uintptr_t seen[SEEN]; /* threads */
  size_t first, others, dear;
  unsigned seen_count, order;
} job;

static job the;

static uintptr_t this_thread(void) {
#ifdef _WIN32
  return (uintptr_t)GetCurrentThreadId();
#else
  uintptr_t number = 0;
  const pthread_t self = pthread_self();
  memcpy(&number, &self, sizeof self < sizeof number ? sizeof self : sizeof number);
  return number;
#endif
}

static void spin(double seconds) {
  const double end = ex_thread_clock() + seconds;
  while (ex_thread_clock() < end) continue;
}

/* Counts how often index i is run, in a byte of its own. */
static void count_run(void *arg, size_t i) {
  job *j = (job *)arg;
  j->runs[i]++;
}

static bool all_once(const job *j, size_t n) {
  for (size_t i = 0; i < MOST; i++)
    if (j->runs[i] != (i < n)) return false;
  return true;
}

static void runs_each_index_once(void) {
  static const size_t sizes[] = {0, 1, 2, 3, 100, 1000, MOST};
  bool good = true, control = false;
  for (unsigned count = 1; count <= 9; count += 4) {
    ex_threads threads = ex_threads_of(count);
    for (size_t k = 0; k < sizeof sizes / sizeof *sizes; k++)
      for (int again = 0; again < 3; again++) {
        memset(the.runs, 0, sizeof the.runs);
        ex_parallel_for(&threads, sizes[k], count_run, &the);
        good = good && all_once(&the, sizes[k]);
        control = control || (sizes[k] < MOST && all_once(&the, sizes[k] + 1));
      }
    ex_threads_stop(&threads);
  }
  check(good, "each index is run once, by 1, 5 and 9 threads, of 0 to 70,000 indices");
  check(!control, "and one that is not run would be seen");
}

static void note_thread(void *arg, size_t i) {
  job *j = (job *)arg;
  unsigned k = 0;
  const uintptr_t self = this_thread();
  (void)i;
  spin(2e-4);
  ex_mutex_lock(&j->lock);
  while (k < j->seen_count && j->seen[k] != self) k++;
  if (k == j->seen_count && k < SEEN) j->seen[j->seen_count++] = self;
  ex_mutex_unlock(&j->lock);
}

/* WHY threads are held when others start: a system may give the number of one that has ended to the next. */
static void keeps_its_threads(void) {
  ex_threads threads = ex_threads_of(3), more[8];
  the.seen_count = 0;
  for (int call = 0; call < 50; call++) ex_parallel_for(&threads, 30, note_thread, &the);
  check(
      the.seen_count > 1 && the.seen_count <= 3, "50 calls are made by the same three threads at most, and not by one");
  for (int k = 0; k < 8; k++) more[k] = ex_threads_of(3), ex_parallel_for(&more[k], 30, note_thread, &the);
  check(the.seen_count > 3, "and eight more sets of threads are seen as others");
  for (int k = 0; k < 8; k++) ex_threads_stop(&more[k]);
  ex_threads_stop(&threads);
}

static void call_again(void *arg, size_t i) {
  job *j = (job *)arg;
  ex_mutex_lock(&j->lock); /* of the runs, which others count, too */
  ex_parallel_for(j->threads, i % 2 ? 1 : 10, count_run, j);
  ex_mutex_unlock(&j->lock);
}

static void bears_calls_within_calls(void) {
  ex_threads threads = ex_threads_of(4);
  memset(the.runs, 0, sizeof the.runs);
  the.threads = &threads;
  ex_parallel_for(&threads, 1, call_again, &the);
  const bool once = all_once(&the, 10);
  ex_parallel_for(&threads, 1, call_again, &the);
  check(once && the.runs[9] == 2, "a call from within a call is run, as is the next");
  memset(the.runs, 0, sizeof the.runs);
  for (int k = 0; k < 20; k++) {
    ex_parallel_for(&threads, 16, note_thread, &the);
    ex_parallel_for(&threads, 2, call_again, &the);
  }
  check(the.runs[9] == 20, "and of calls from several threads at once none is lost, and none waits for ever");
  ex_threads_stop(&threads);
}

/* Index `dear` of 16 costs far more than the others, even where these have to wait. */
static void cost(void *arg, size_t i) {
  job *j = (job *)arg;
  ex_mutex_lock(&j->lock);
  if (i == j->dear) j->first = j->order;
  j->order++;
  ex_mutex_unlock(&j->lock);
  spin(i == j->dear ? 0.1 : 5e-4);
}

/* WHY three calls of eight: on a busy machine a thread may be stopped between being handed an index and running it. */
static void hands_out_the_dearest_first(void) {
  enum { CALLS = 9 };
  ex_threads threads = ex_threads_of(2);
  size_t first_call = 0;
  unsigned soon = 0;
  the.dear = 13;
  for (int call = 0; call < CALLS; call++) {
    the.order = 0;
    ex_parallel_for(&threads, 16, cost, &the);
    if (call) soon += the.first < 2;
    else first_call = the.first;
  }
  check(3 * soon >= CALLS, "what took longest the last time is handed out first");
  check(first_call > 2, "and in the first call it was not");
  ex_threads_stop(&threads);
}

enum { EDGE = 200, CORNERS = (EDGE + 1) * (EDGE + 1), TRIANGLES = 2 * EDGE * EDGE, WIDE = 96, HIGH = 64 };

static void make_hills(float (*corner)[3], uint32_t (*triangle)[3]) {
  for (uint32_t i = 0; i < CORNERS; i++) {
    const uint32_t x = i % (EDGE + 1), y = i / (EDGE + 1);
    corner[i][0] = (float)x / (float)(int)EDGE, corner[i][1] = (float)(x * y * 7919 % 97) / 900,
    corner[i][2] = (float)y / (float)(int)EDGE;
  }
  for (uint32_t i = 0; i < EDGE * EDGE; i++) {
    const uint32_t a = i / EDGE * (EDGE + 1) + i % EDGE, b = a + EDGE + 1;
    const uint32_t two[2][3] = {{a, b, a + 1}, {a + 1, b, b + 1}};
    memcpy(triangle[2 * i], two, sizeof two);
  }
}

static bool paint(ex_threads *threads, float *pixels) {
  static float corner[CORNERS][3];
  static uint32_t triangle[TRIANGLES][3];
  pktrt_scene_desc desc;
  pktrt_mesh_desc mesh;
  pktrt_render_desc view;
  memset(&desc, 0, sizeof desc), memset(&mesh, 0, sizeof mesh), memset(&view, 0, sizeof view);
  view.samples = 1;
  make_hills(corner, triangle);
  if (threads) desc.parallel_for = ex_parallel_for, desc.user = threads;
  mesh.positions = corner[0], mesh.vertex_count = CORNERS, mesh.indices = triangle[0], mesh.triangle_count = TRIANGLES;
  view.width = WIDE, view.height = HIGH, view.pixels = pixels, view.tile_size = 16;
  view.camera.eye[0] = 0.5f, view.camera.eye[1] = 0.6f, view.camera.eye[2] = 1.8f;
  view.camera.target[0] = 0.5f, view.camera.target[2] = 0.4f;
  view.ambient[0] = view.ambient[1] = view.ambient[2] = 1;
  pktrt_scene *scene = pktrt_scene_create(&desc);
  const bool good = scene && !pktrt_add_mesh(scene, &mesh, NULL) && !pktrt_commit(scene) && !pktrt_render(scene, &view);
  pktrt_scene_destroy(scene);
  return good;
}

static void makes_the_same_picture(void) {
  static float one[WIDE * HIGH * 3], many[WIDE * HIGH * 3];
  ex_threads threads = ex_threads_of(4);
  bool same = paint(NULL, one), plain = true;
  for (int k = 0; k < 3; k++) same = same && paint(&threads, many) && !memcmp(one, many, sizeof one);
  for (int i = 3; i < WIDE * HIGH * 3; i++) plain = plain && one[i] == one[i - 3];
  check(same, "a picture by four threads, from its tree on, has the bits of one by none");
  check(!plain, "and is not of one colour");
  ex_threads_stop(&threads);
}

int main(void) {
  ex_mutex_make(&the.lock);
  runs_each_index_once();
  keeps_its_threads();
  bears_calls_within_calls();
  hands_out_the_dearest_first();
  makes_the_same_picture();
  printf("%d passed, %d failed, %u processors\n", passed, failed, ex_processors());
  return failed != 0;
}
