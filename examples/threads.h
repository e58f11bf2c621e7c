/* Threads for pktrt_scene_desc's parallel_for, by pthreads or by Win32. They start with the first call that needs them
   and wait between calls, until ex_threads_stop:

       ex_threads threads = ex_threads_of(ex_processors());
       desc.parallel_for = ex_parallel_for, desc.user = &threads;
       ...
       ex_threads_stop(&threads);

   What an index took is remembered, and the next call with the same body and as many indices, the next pass or frame,
   hands out the dearest first: so the last to be finished is a cheap one, and nobody waits long for it. No result
   depends on it. A call from within a call, or while another thread makes one, is run by its caller alone; the
   first of all must not have such company. All static; C99 and C++11. */
#ifndef EXAMPLES_THREADS_H
#define EXAMPLES_THREADS_H

#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifndef EX_UNUSED
#ifdef __GNUC__
#define EX_UNUSED __attribute__((unused))
#else
#define EX_UNUSED
#endif
#endif

enum { EX_MAX_THREADS = 256 };

/* What the two systems call it, and seconds from a clock that does not jump. */
#ifdef _WIN32
#include <windows.h>
typedef HANDLE ex_thread;
typedef CRITICAL_SECTION ex_mutex;
typedef CONDITION_VARIABLE ex_signal;
#define EX_THREAD_RETURNS DWORD WINAPI
static bool ex_thread_start(ex_thread *t, DWORD(WINAPI *run)(void *), void *user) {
  *t = CreateThread(NULL, 0, run, user, 0, NULL);
  return *t != NULL;
}
static void ex_thread_join(ex_thread t) {
  WaitForSingleObject(t, INFINITE);
  CloseHandle(t);
}
static void ex_mutex_make(ex_mutex *m) { InitializeCriticalSection(m); }
static void ex_mutex_free(ex_mutex *m) { DeleteCriticalSection(m); }
static void ex_mutex_lock(ex_mutex *m) { EnterCriticalSection(m); }
static void ex_mutex_unlock(ex_mutex *m) { LeaveCriticalSection(m); }
static void ex_signal_make(ex_signal *s) { InitializeConditionVariable(s); }
static void ex_signal_free(ex_signal *s) { (void)s; }
static void ex_signal_wait(ex_signal *s, ex_mutex *m) { SleepConditionVariableCS(s, m, INFINITE); }
static void ex_signal_all(ex_signal *s) { WakeAllConditionVariable(s); }
static double ex_thread_clock(void) {
  LARGE_INTEGER ticks, each;
  QueryPerformanceCounter(&ticks);
  QueryPerformanceFrequency(&each);
  return (double)ticks.QuadPart / (double)each.QuadPart;
}
EX_UNUSED static unsigned ex_processors(void) {
  SYSTEM_INFO info;
  GetSystemInfo(&info);
  const unsigned n = (unsigned)info.dwNumberOfProcessors;
  return n < 1 ? 1u : n > EX_MAX_THREADS ? (unsigned)EX_MAX_THREADS : n;
}
#else
#include <pthread.h>
#include <time.h>
#include <unistd.h>
typedef pthread_t ex_thread;
typedef pthread_mutex_t ex_mutex;
typedef pthread_cond_t ex_signal;
#define EX_THREAD_RETURNS void *
static bool ex_thread_start(ex_thread *t, void *(*run)(void *), void *user) {
  return pthread_create(t, NULL, run, user) == 0;
}
static void ex_thread_join(ex_thread t) { pthread_join(t, NULL); }
static void ex_mutex_make(ex_mutex *m) { pthread_mutex_init(m, NULL); }
static void ex_mutex_free(ex_mutex *m) { pthread_mutex_destroy(m); }
static void ex_mutex_lock(ex_mutex *m) { pthread_mutex_lock(m); }
static void ex_mutex_unlock(ex_mutex *m) { pthread_mutex_unlock(m); }
static void ex_signal_make(ex_signal *s) { pthread_cond_init(s, NULL); }
static void ex_signal_free(ex_signal *s) { pthread_cond_destroy(s); }
static void ex_signal_wait(ex_signal *s, ex_mutex *m) { pthread_cond_wait(s, m); }
static void ex_signal_all(ex_signal *s) { pthread_cond_broadcast(s); }
static double ex_thread_clock(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}
EX_UNUSED static unsigned ex_processors(void) {
  const long n = sysconf(_SC_NPROCESSORS_ONLN);
  return n < 1 ? 1u : n > EX_MAX_THREADS ? (unsigned)EX_MAX_THREADS : (unsigned)n;
}
#endif

typedef void ex_body(void *arg, size_t i);

typedef struct ex_cost { /* of an index, when it was last run */
  float seconds;
  uint32_t index;
} ex_cost;

enum { EX_COSTS = 4, EX_MOST_COSTS = 1 << 16 }; /* calls that are remembered; above: indices are cheap, and in order */

typedef struct ex_costs {
  ex_body *body;
  size_t n;
  ex_cost *of; /* in the order in which indices are handed out */
} ex_costs;

typedef struct ex_pool {
  ex_mutex lock; /* of all that follows */
  ex_signal begin, end;
  ex_thread helpers[EX_MAX_THREADS];
  unsigned asked, started, working; /* threads that were asked for; helpers there are; those still in the call */
  uint64_t calls;
  bool busy, quit; /* busy: during a call; the callers of others work alone */
  ex_body *body;
  void *arg;
  size_t n, next, share; /* next: the first that nobody has taken; share: how many are taken at a time */
  ex_costs costs[EX_COSTS], *now;
  unsigned oldest;
} ex_pool;

typedef struct ex_threads { /* the `user` of ex_parallel_for */
  unsigned count;           /* threads that work on a call, the calling one included; 0 and 1: no further thread */
  ex_pool *pool;            /* NULL before the first call that needs it */
} ex_threads;

EX_UNUSED static ex_threads ex_threads_of(unsigned count) {
  ex_threads t;
  t.count = count, t.pool = NULL;
  return t;
}

/* Takes indices, a share at a time, until none is left. Is called with the lock held, as it returns. */
static void ex_pool_work(ex_pool *p) {
  while (p->next < p->n) {
    const size_t from = p->next, to = p->n - from < p->share ? p->n : from + p->share;
    ex_cost *cost = p->now ? p->now->of : NULL;
    p->next = to;
    ex_mutex_unlock(&p->lock);
    for (size_t i = from; i < to; i++) {
      const double begin = cost ? ex_thread_clock() : 0;
      p->body(p->arg, cost ? cost[i].index : i);
      if (cost) cost[i].seconds = (float)(ex_thread_clock() - begin);
    }
    ex_mutex_lock(&p->lock);
  }
}

static EX_THREAD_RETURNS ex_pool_help(void *user) {
  ex_pool *p = (ex_pool *)user;
  uint64_t seen = 0;
  ex_mutex_lock(&p->lock);
  for (;;) {
    while (!p->quit && p->calls == seen) ex_signal_wait(&p->begin, &p->lock);
    if (p->quit) break;
    seen = p->calls;
    ex_pool_work(p);
    if (--p->working == 0) ex_signal_all(&p->end);
  }
  ex_mutex_unlock(&p->lock);
  return 0;
}

/* Makes a pool and starts its threads, of which those that cannot be had are done without. NULL: no memory. */
static ex_pool *ex_pool_start(unsigned count) {
  ex_pool *p = (ex_pool *)calloc(1, sizeof *p);
  if (!p) return NULL;
  ex_mutex_make(&p->lock);
  ex_signal_make(&p->begin);
  ex_signal_make(&p->end);
  p->asked = count;
  while (p->started < EX_MAX_THREADS && p->started + 1 < count &&
         ex_thread_start(&p->helpers[p->started], ex_pool_help, p))
    p->started++;
  return p;
}

static int ex_cost_compare(const void *a, const void *b) { /* the dearest first; equal ones by index */
  const ex_cost *x = (const ex_cost *)a, *y = (const ex_cost *)b;
  if (x->seconds != y->seconds) return x->seconds > y->seconds ? -1 : 1;
  return x->index < y->index ? -1 : x->index > y->index;
}

/* Finds what the indices of a call took the last time, and sorts them by it. NULL: it is not remembered. */
static ex_costs *ex_pool_recall(ex_pool *p, ex_body *body, size_t n) {
  if (n > EX_MOST_COSTS) return NULL;
  for (unsigned i = 0; i < EX_COSTS; i++) {
    if (p->costs[i].body != body || p->costs[i].n != n) continue;
    qsort(p->costs[i].of, n, sizeof *p->costs[i].of, ex_cost_compare);
    return &p->costs[i];
  }
  ex_costs *c = &p->costs[p->oldest++ % EX_COSTS];
  free(c->of);
  c->of = (ex_cost *)calloc(n, sizeof *c->of);
  c->body = c->of ? body : NULL, c->n = n;
  for (size_t i = 0; c->of && i < n; i++) c->of[i].index = (uint32_t)i;
  return c->of ? c : NULL;
}

/* Takes a pool for a call; false: another call has it, or it has no threads. */
static bool ex_pool_take(ex_pool *p) {
  ex_mutex_lock(&p->lock);
  const bool taken = !p->busy && p->started;
  p->busy |= taken;
  ex_mutex_unlock(&p->lock);
  return taken;
}

/* Ends the threads; a later call would start new ones. */
EX_UNUSED static void ex_threads_stop(ex_threads *threads) {
  ex_pool *p = threads->pool;
  if (!p) return;
  ex_mutex_lock(&p->lock);
  p->quit = true;
  ex_signal_all(&p->begin);
  ex_mutex_unlock(&p->lock);
  while (p->started) ex_thread_join(p->helpers[--p->started]);
  for (unsigned i = 0; i < EX_COSTS; i++) free(p->costs[i].of);
  ex_signal_free(&p->begin);
  ex_signal_free(&p->end);
  ex_mutex_free(&p->lock);
  free(p);
  threads->pool = NULL;
}

/* A parallel_for for pktrt_scene_desc: runs body(arg, i) for i in [0,n), in any order, and returns when all are done. */
EX_UNUSED static void ex_parallel_for(void *user, size_t n, ex_body *body, void *arg) {
  ex_threads *threads = (ex_threads *)user;
  const bool shared = threads->count > 1 && n > 1;
  if (shared && threads->pool && threads->pool->asked != threads->count) ex_threads_stop(threads); /* no call is on */
  if (shared && !threads->pool) threads->pool = ex_pool_start(threads->count);
  ex_pool *p = shared ? threads->pool : NULL;
  if (!p || !ex_pool_take(p)) {
    for (size_t i = 0; i < n; i++) body(arg, i);
    return;
  }
  ex_mutex_lock(&p->lock);
  p->body = body, p->arg = arg, p->n = n, p->next = 0;
  p->now = ex_pool_recall(p, body, n);
  p->share = p->now ? 1 : n / (64 * (size_t)(p->started + 1)) + 1;
  p->working = p->started, p->calls++;
  ex_signal_all(&p->begin);
  ex_pool_work(p);
  while (p->working) ex_signal_wait(&p->end, &p->lock);
  p->busy = false;
  ex_mutex_unlock(&p->lock);
}

#endif
