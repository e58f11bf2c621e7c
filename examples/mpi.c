/* Renders pictures and animations on many machines, by MPI: `mpirun -n 8 build/mpi --help`.

   Rank 0 hands out units of work, a pass over a tile of a frame each, to whoever is free, and adds up what comes back;
   every rank loads the scene and builds the trees for itself. Pictures have the bits of build/render: a pixel's passes
   are added in their order, whoever made them and whenever they arrive (pktrt_render_pass and its neighbours). What has
   been added is kept in a folder of tiles until all pictures are written, so that a run that fails can be resumed. */
#include "common.h"

#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"

/* Options, scenes, the table and the writer of files are those of the command line. */
#define main render_main
#include "render.c"
#undef main

#include <mpi.h>

/* >>options -------------------------------------------------------------------------------------------------------- */

typedef struct mpi_options {
  options of;
  uint32_t first, last; /* frames */
  const char *resume;   /* a folder, or NULL */
  bool help;
} mpi_options;

enum { OPT_RESUME = 1000 };

/* For tests: words of an environment variable that are no use otherwise. */
static bool tested(const char *word) {
  const char *words = getenv("PKTRT_MPI_TEST");
  return words && strstr(words, word);
}

static void print_mpi_help(void) {
  printf("usage: mpirun -n RANKS build/mpi [--scene NAME | --mesh FILE] [options] [-o FILE]\n\n"
         "Options mean what they do to render, see render --help; these are others:\n"
         "  --frame A-B      renders the frames A to B of the animation, each to its file: out/x.png becomes\n"
         "                   out/x-007.png. --frame A: that one, as render does\n"
         "  --resume FOLDER  takes up the tiles that a run of the same settings has left there, and keeps new ones\n"
         "                   there (default: -o FILE with -tiles behind; none is taken up)\n"
         "  --threads N      threads of each rank (default 1)\n"
         "  --isa ISA        of a rank: mpirun -n 1 build/mpi --isa avx2 ... : -n 1 build/mpi --isa sse2 ...\n"
         "  --tile N         what is handed out; ranks should be fewer than tiles\n"
         "There are no --adaptive, --filter, --time, --heat, --error-map, --buffers, --explain here.\n"
         "Tiles are removed when all pictures are written. Exit status: 0, else 1 or what mpirun makes of it.\n");
}

/* A frame as render takes it, or two with a dash between. */
static bool parse_frames(mpi_options *m, const char *text) {
  const char *dash = strchr(text, '-');
  char first[16];
  snprintf(first, sizeof first, "%.*s", dash ? (int)(dash - text) : 15, text);
  m->of.has_frame = true;
  if (!ex_parse_uint("frame", first, 0, MAX_FRAMES - 1, &m->first)) return false;
  m->last = m->first;
  return !dash || ex_parse_uint("frame", dash + 1, m->first, MAX_FRAMES - 1, &m->last);
}

static bool refuse_option(int option) {
  static const int lacking[] = {OPT_ADAPTIVE, OPT_FILTER, OPT_TIME, OPT_HEAT, OPT_ERROR_MAP, OPT_BUFFERS, OPT_EXPLAIN};
  for (size_t i = 0; i < sizeof lacking / sizeof *lacking; i++)
    for (const struct option *o = option_list; option == lacking[i] && o->name; o++)
      if (o->val == option) return ex_fail("--%s: render has it, mpi does not", o->name);
  return true;
}

static bool complete_mpi_options(mpi_options *m) {
  options *o = &m->of;
  bool is_stdout;
  o->frame = m->first;
  o->count = false; /* counts of ranks are not gathered */
  if (!complete_options(o)) return false;
  if (m->last >= o->frames) return ex_fail("--frame: %u is beyond the last of %u frames", m->last, o->frames);
  return m->first == m->last || !o->output || !output_is_direct(o->output, &is_stdout) ||
         ex_fail("-o: several frames need files, %s is none", o->output);
}

static bool parse_mpi_options(mpi_options *m, int argc, char **argv) {
  enum { KNOWN = sizeof option_list / sizeof *option_list };
  static const struct option resume = {"resume", required_argument, NULL, OPT_RESUME};
  struct option list[KNOWN + 1];
  memcpy(list + 1, option_list, sizeof option_list); /* its last one is the end */
  list[0] = resume;
  memset(m, 0, sizeof *m);
  default_options(&m->of);
  m->of.threads = 1;
  opterr = 0, optind = 0; /* from the start: it may be called again */
  for (;;) {
    const int at = optind ? optind : 1, option = getopt_long(argc, argv, "o:h", list, NULL);
    if (option == -1) break;
    if (option == '?')
      return ex_fail("%s: unknown, ambiguous, or its value is missing or too much; see --help", argv[at]);
    if (option == 'h') return m->help = true;
    if (!refuse_option(option)) return false;
    if (option == OPT_RESUME) m->resume = optarg;
    else if (!(option == OPT_FRAME ? parse_frames(m, optarg) : parse_option(&m->of, option, optarg))) return false;
  }
  if (optind < argc) return ex_fail("%s: an argument without an option; see --help", argv[optind]);
  return complete_mpi_options(m);
}

/* >>tiles ---------------------------------------------------------------------------------------------------------- */

typedef struct unit { /* of work; frame END: there is none left */
  uint32_t frame, tile, pass;
} unit;
enum { END = UINT32_MAX >> 1, NOWHERE = END - 1 };

static uint32_t tile_columns(const options *o) { return (o->width + o->tile - 1) / o->tile; }
static uint32_t tile_count(const options *o) { return tile_columns(o) * ((o->height + o->tile - 1) / o->tile); }

/* x, y, width and height. */
static void tile_area(const options *o, uint32_t tile, uint32_t area[4]) {
  area[0] = tile % tile_columns(o) * o->tile, area[1] = tile / tile_columns(o) * o->tile;
  area[2] = o->width - area[0] < o->tile ? o->width - area[0] : o->tile;
  area[3] = o->height - area[1] < o->tile ? o->height - area[1] : o->tile;
}

/* FNV-1a by 64 bits. No multiplication loses a difference, so a damaged word always shows. */
static uint64_t hash_words(const uint64_t *words, size_t n) {
  uint64_t sum = 14695981039346656037u;
  for (size_t i = 0; i < n; i++) sum = (sum ^ words[i]) * 1099511628211u;
  return sum;
}

static bool hash_file(const char *path, uint64_t *sum) {
  unsigned char bytes[65536];
  FILE *file = fopen(path, "rb");
  if (!file) return ex_fail("%s: cannot be read: %s", path, strerror(errno));
  for (size_t n; (n = fread(bytes, 1, sizeof bytes, file)) > 0;)
    for (size_t i = 0; i < n; i++) *sum = (*sum ^ bytes[i]) * 1099511628211u;
  fclose(file);
  return true;
}

/* A number for all that the sums of a tile depend on but frame, tile and pass. False: the mesh file cannot be read. */
static bool settings_key(const mpi_options *m, uint64_t *key) {
  const options *o = &m->of;
  char text[1024];
  uint64_t mesh = 14695981039346656037u, sky = mesh;
  if (o->mesh && !hash_file(o->mesh, &mesh)) return false;
  if (o->environment && !hash_file(o->environment, &sky)) return false;
  int n =
      snprintf(text, sizeof text, "%d %s %llx %u %u %u %u %d %u %u %u %d %u %d %d %d %d %d %g %g %g %g %g %u %u %g %d",
          PKTRT_VERSION, o->scene ? o->scene : "", (unsigned long long)mesh, o->up_z, o->instances, o->width, o->height,
          o->mode, o->tile, o->samples, o->passes, o->sampler, o->seed, o->branching, o->lights, o->glass_shadows,
          o->normals, o->phong, o->attenuation, o->aperture, o->focus, o->shutter, o->light_size, o->depth, o->frames,
          o->target_error, o->measure);
  if (o->measure == PKTRT_ERROR_DISPLAY)
    n += snprintf(text + n, sizeof text - (size_t)n, " %g %d", o->exposure, o->tone);
  for (int i = 0; i < 6; i++)
    n += snprintf(text + n, sizeof text - (size_t)n, " %d %a", o->has_camera, (double)o->camera[i]);
  n += snprintf(text + n, sizeof text - (size_t)n, " %d %llx", o->has_frame, (unsigned long long)sky);
  *key = 14695981039346656037u;
  for (int i = 0; i < n; i++) *key = (*key ^ (unsigned char)text[i]) * 1099511628211u;
  return true;
}

/* >>work: what every rank does ------------------------------------------------------------------------------------- */

/* What a unit comes back as: doubles, these first, then the means of pixels. */
enum { MESSAGE_FRAME, MESSAGE_TILE, MESSAGE_PASS, MESSAGE_HEAD };

typedef struct worker {
  job of;
  ex_threads threads;
  uint32_t frame;                    /* of the scene that is loaded, or NOWHERE */
  double *message, seconds, slowest; /* of units */
  unsigned units;
} worker;

/* Looks at the environment once, not for each tile anew, unless a picture has so few samples that pktrt_render looks at
   fewer directions. */
static bool prepare_environment(job *j) {
  const pktrt_render_desc *v = &j->view;
  const uint64_t samples = (uint64_t)v->width * v->height * v->samples * (v->passes ? v->passes : 1);
  if (!v->environment || samples < 16384) return true;
  return pktrt_prepare_environment(j->world, v) == PKTRT_OK || ex_fail("%s", pktrt_last_error(j->world));
}

static bool worker_load(worker *w, uint32_t frame) {
  job *j = &w->of;
  pktrt_scene_desc desc;
  memset(&desc, 0, sizeof desc);
  desc.isa = j->given.isa, desc.parallel_for = ex_parallel_for, desc.user = &w->threads;
  pktrt_scene_destroy(j->world);
  scene_free(&j->built_in);
  mesh_file_close(&j->file);
  w->frame = NOWHERE, j->given.frame = frame;
  j->world = pktrt_scene_create(&desc);
  if (!j->world) return ex_fail("%s", pktrt_last_error(NULL));
  const double before = j->load_seconds;
  if (!load(j)) return false;
  j->load_seconds += before;
  describe(j);
  j->view.report = NULL;
  w->frame = frame;
  return prepare_environment(j);
}

typedef struct bands { /* of a tile, one for each thread */
  const worker *of;
  uint32_t pass, area[4], rows;
  bool failed[EX_MAX_THREADS];
} bands;

static void render_band(void *arg, size_t i) {
  bands *b = (bands *)arg;
  const uint32_t from = (uint32_t)i * b->rows, left = b->area[3] - from, rows = left < b->rows ? left : b->rows;
  double *means = b->of->message + MESSAGE_HEAD + (size_t)from * b->area[2] * 3;
  b->failed[i] = pktrt_render_pass(b->of->of.world, &b->of->of.view, b->pass, b->area[0], b->area[1] + from, b->area[2],
                     rows, means) != PKTRT_OK;
}

/* Renders into the worker's message. */
static bool worker_render(worker *w, const unit *u) {
  if (w->frame != u->frame && !worker_load(w, u->frame)) return false;
  const double start = ex_seconds();
  bands b;
  memset(&b, 0, sizeof b);
  b.of = w, b.pass = tested("backwards") ? w->of.given.passes - 1 - u->pass : u->pass;
  tile_area(&w->of.given, u->tile, b.area);
  b.rows = (b.area[3] + w->threads.count - 1) / w->threads.count;
  const uint32_t n = (b.area[3] + b.rows - 1) / b.rows;
  ex_parallel_for(&w->threads, n, render_band, &b);
  for (uint32_t i = 0; i < n; i++)
    if (b.failed[i]) return ex_fail("not enough memory for a tile");
  w->message[MESSAGE_FRAME] = u->frame, w->message[MESSAGE_TILE] = u->tile, w->message[MESSAGE_PASS] = u->pass;
  const double took = ex_seconds() - start;
  w->seconds += took, w->slowest = fmax(w->slowest, took);
  w->units++;
  return true;
}

static size_t message_room(const options *o) { return MESSAGE_HEAD + (size_t)o->tile * o->tile * 3; }
static size_t message_length(const options *o, uint32_t tile) {
  uint32_t area[4];
  tile_area(o, tile, area);
  return MESSAGE_HEAD + (size_t)area[2] * area[3] * 3;
}

/* For a test: the rank that is named is killed when it gets a tile from a number on, and others let it get some. */
static void die_if_told(int rank, const unit *u) {
  const char *words = getenv("PKTRT_MPI_TEST"), *at = words ? strstr(words, "die=") : NULL;
  const struct timespec a_little = {0, 30000000};
  int who = -1;
  unsigned from = 0;
  if (!at || sscanf(at, "die=%d:%u", &who, &from) != 2) return;
  if (who == rank && u->tile >= from) raise(SIGKILL);
  if (who != rank) nanosleep(&a_little, NULL);
}

static void pause_for(double *seconds) { /* longer and longer: a rank that waits must not take the time of others */
  const struct timespec t = {0, (long)(1e9 * *seconds)};
  nanosleep(&t, NULL);
  *seconds = fmin(2 * *seconds, 5e-4);
}
#define PAUSE 2e-5 /* at first */

static void wait_for_message(int from) {
  double pause = PAUSE;
  for (int there = 0;;) {
    MPI_Iprobe(from, 0, MPI_COMM_WORLD, &there, MPI_STATUS_IGNORE);
    if (there) return;
    pause_for(&pause);
  }
}

/* What ranks other than 0 do until there is no work. */
static bool work(worker *w, int rank) {
  for (unit u;;) {
    wait_for_message(0);
    MPI_Recv(&u, 3, MPI_UINT32_T, 0, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    if (u.frame == END) return true;
    die_if_told(rank, &u);
    if (!worker_render(w, &u)) return false;
    MPI_Send(w->message, (int)message_length(&w->of.given, u.tile), MPI_DOUBLE, 0, 0, MPI_COMM_WORLD);
  }
}

/* >>own: rank 0 renders, too, in a thread beside the one that hands out -------------------------------------------- */

enum { OWN_RANKS = 16 }; /* with so many ranks it has enough to do */

typedef enum own_state { OWN_IDLE, OWN_GIVEN, OWN_DONE, OWN_FAILED, OWN_END } own_state;

typedef struct own_work {
  worker *of;
  pthread_t thread;
  pthread_mutex_t lock;
  pthread_cond_t changed;
  own_state state;
  unit given;
  bool there;
} own_work;

static void *own_run(void *user) {
  own_work *own = (own_work *)user;
  pthread_mutex_lock(&own->lock);
  while (own->state != OWN_END) {
    if (own->state != OWN_GIVEN) {
      pthread_cond_wait(&own->changed, &own->lock);
      continue;
    }
    pthread_mutex_unlock(&own->lock);
    die_if_told(0, &own->given);
    const bool ok = worker_render(own->of, &own->given);
    pthread_mutex_lock(&own->lock);
    if (own->state == OWN_GIVEN) own->state = ok ? OWN_DONE : OWN_FAILED;
  }
  pthread_mutex_unlock(&own->lock);
  return NULL;
}

static void own_start(own_work *own, worker *of, bool wanted) {
  own->of = of, own->state = OWN_IDLE;
  pthread_mutex_init(&own->lock, NULL);
  pthread_cond_init(&own->changed, NULL);
  own->there = wanted && pthread_create(&own->thread, NULL, own_run, own) == 0;
}

static void own_set(own_work *own, own_state state) {
  pthread_mutex_lock(&own->lock);
  own->state = state;
  pthread_cond_signal(&own->changed);
  pthread_mutex_unlock(&own->lock);
}
static own_state own_get(own_work *own) {
  pthread_mutex_lock(&own->lock);
  const own_state state = own->state;
  pthread_mutex_unlock(&own->lock);
  return state;
}

/* >>desk: what rank 0 knows ---------------------------------------------------------------------------------------- */

enum {
  OPEN_BYTES = 1 << 30, /* of sums of frames that are being made, in the memory of rank 0 */
  WINDOW = 8            /* passes of a tile that are on their way or wait for one before them */
};

typedef struct tile_state {
  uint32_t done, given;  /* passes that have been added, and handed out */
  double kept;           /* when it was written to disk last */
  double *early[WINDOW]; /* means of passes that wait for one before them, by pass % WINDOW */
} tile_state;

typedef struct frame_state {
  uint32_t frame;                        /* NOWHERE: none is here */
  uint32_t round;                        /* passes that are sure to be needed */
  uint32_t level, cursor, ranks, behind; /* pass and tile to be handed out next; tiles with fewer than `round` passes */
  tile_state *tiles;
  pktrt_pixel_sums *sums;
  pktrt_display_sums *display; /* for PKTRT_ERROR_DISPLAY, or else NULL */
} frame_state;

typedef struct place { /* where a rank runs */
  long pid;
  char host[64];
} place;

typedef struct rank_state {
  bool idle;
  uint32_t frame; /* that its scene is of */
} rank_state;

typedef struct desk {
  const mpi_options *given;
  job shown; /* picture, report and files of the frame that is finished */
  pktrt_scene *empty;
  int count, idle, frames_open; /* ranks, those that have nothing to do, and frames at a time */
  rank_state *ranks;
  const place *places;
  own_work own;
  frame_state *open;
  uint32_t next, finished; /* frame to be opened next; frames that are done */
  uint64_t key;
  char folder[OUTPUT_PATH]; /* "": no tiles are kept */
  uint64_t *words;          /* of a tile's file */
  unsigned units, taken, damaged, foreign;
  double begun, told;                               /* seconds; told: when progress was last said */
  double adding, keeping, judging, writing, in_all; /* the same, of the processor */
} desk;

/* Processor time of this thread: what handing out takes where others want the processor, too. */
static double busy_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* >>keep: tiles on disk -------------------------------------------------------------------------------------------- */

/* A file is words of 64 bits: the head, four doubles for each pixel, or ten where errors are as shown, and the hash of
   all of these. It gets its name
   when it is written, so a process that is killed leaves none half-written. It is not synced: after a power failure it
   may be damaged, which the hash tells. */
enum { KEPT_MAGIC, KEPT_KEY, KEPT_FRAME, KEPT_TILE, KEPT_PASSES, KEPT_HEAD };
static const uint64_t kept_magic = 0x31656c697472746b; /* of other byte order: others' */

static bool kept_name(const desk *d, uint32_t frame, uint32_t tile, const char *end, char path[OUTPUT_PATH]) {
  const int n = snprintf(path, OUTPUT_PATH, "%.4000s/%06u-%06u.%s", d->folder, frame, tile, end);
  return n > 0 && n < OUTPUT_PATH;
}

static size_t pixel_words(const options *o) { return o->measure == PKTRT_ERROR_DISPLAY ? 10 : 4; }

static size_t kept_words(const options *o, uint32_t tile) {
  uint32_t area[4];
  tile_area(o, tile, area);
  return KEPT_HEAD + (size_t)area[2] * area[3] * pixel_words(o) + 1;
}

/* Copies a tile's sums from or to the words of its file. */
static void kept_copy(const options *o, frame_state *f, uint32_t tile, uint64_t *words, bool from) {
  uint32_t area[4];
  tile_area(o, tile, area);
  for (uint32_t y = 0; y < area[3]; y++) {
    const size_t at = (size_t)(area[1] + y) * o->width + area[0];
    pktrt_pixel_sums *sums = &f->sums[at];
    uint64_t *row = words + KEPT_HEAD + (size_t)y * area[2] * pixel_words(o);
    if (from) memcpy(sums, row, area[2] * sizeof *sums);
    else memcpy(row, sums, area[2] * sizeof *sums);
    if (!f->display) continue;
    row += 4 * (size_t)area[2];
    if (from) memcpy(&f->display[at], row, area[2] * sizeof *f->display);
    else memcpy(row, &f->display[at], area[2] * sizeof *f->display);
  }
}

/* Writes a tile that is done, or else at most once in a second. Where it cannot be kept, rendering goes on without. */
static void keep_tile(desk *d, frame_state *f, uint32_t tile) {
  const double now = ex_seconds(), start = busy_seconds();
  if (!d->folder[0] || (f->tiles[tile].done != d->given->of.passes && now < f->tiles[tile].kept + 1)) return;
  f->tiles[tile].kept = now;
  const size_t n = kept_words(&d->given->of, tile);
  char path[OUTPUT_PATH], temporary[OUTPUT_PATH];
  d->words[KEPT_MAGIC] = kept_magic, d->words[KEPT_KEY] = d->key;
  d->words[KEPT_FRAME] = f->frame, d->words[KEPT_TILE] = tile, d->words[KEPT_PASSES] = f->tiles[tile].done;
  kept_copy(&d->given->of, f, tile, d->words, false);
  d->words[n - 1] = hash_words(d->words, n - 1);
  bool ok = kept_name(d, f->frame, tile, "tile", path) && kept_name(d, f->frame, tile, "tmp", temporary);
  FILE *file = ok ? fopen(temporary, "wb") : NULL;
  ok = file && fwrite(d->words, sizeof *d->words, n, file) == n;
  if (file && fclose(file) != 0) ok = false;
  if (!ok || rename(temporary, path) != 0) {
    ex_fail("%.900s: no tiles can be kept there from now on: %s", d->folder, strerror(errno));
    d->folder[0] = 0;
  }
  d->keeping += busy_seconds() - start;
}

/* Tells whether a tile's file can have so many passes: a tile is kept from its first pass on, and has no more than the
   picture. The hash does not tell, since whoever writes a file can compute it. */
static bool kept_passes_possible(const desk *d, uint64_t passes) { return passes > 0 && passes <= d->given->of.passes; }

/* Takes a tile up that an earlier run has left, unless it is damaged or of another picture. */
static void take_up_tile(desk *d, frame_state *f, uint32_t tile) {
  const size_t n = kept_words(&d->given->of, tile);
  char path[OUTPUT_PATH];
  FILE *file = kept_name(d, f->frame, tile, "tile", path) ? fopen(path, "rb") : NULL;
  if (!file) return;
  const size_t read = fread(d->words, sizeof *d->words, n, file);
  const bool ends = fgetc(file) == EOF, trusted = tested("trust");
  fclose(file);
  const uint64_t *w = d->words;
  if (read > KEPT_KEY && w[KEPT_KEY] != d->key && w[KEPT_MAGIC] == kept_magic && !trusted) d->foreign++;
  else if (read != n || !ends || w[KEPT_MAGIC] != kept_magic || w[KEPT_FRAME] != f->frame || w[KEPT_TILE] != tile ||
           !kept_passes_possible(d, w[KEPT_PASSES]) || (w[n - 1] != hash_words(w, n - 1) && !trusted))
    d->damaged++;
  else {
    kept_copy(&d->given->of, f, tile, d->words, true);
    f->tiles[tile].done = f->tiles[tile].given = (uint32_t)w[KEPT_PASSES];
    d->taken++;
  }
}

static bool keep_begin(desk *d) {
  const mpi_options *m = d->given;
  const char *name = m->resume ? m->resume : m->of.output;
  bool is_stdout;
  if (!name || (!m->resume && output_is_direct(name, &is_stdout))) return true;
  snprintf(d->folder, sizeof d->folder, "%.4000s%s", name, m->resume ? "" : "-tiles");
  if (mkdir(d->folder, 0777) != 0 && errno != EEXIST)
    return ex_fail("%s: no folder of tiles can be made: %s", d->folder, strerror(errno));
  d->words = (uint64_t *)malloc(kept_words(&m->of, 0) * sizeof *d->words); /* no tile is larger than the first */
  return d->words || ex_fail("not enough memory for a tile");
}

static void keep_end(const desk *d) {
  char path[OUTPUT_PATH];
  if (!d->folder[0] || tested("keep")) return;
  for (uint32_t frame = d->given->first; frame <= d->given->last; frame++)
    for (uint32_t tile = 0; tile < tile_count(&d->given->of); tile++)
      if (kept_name(d, frame, tile, "tile", path)) unlink(path);
  rmdir(d->folder); /* others' files keep it */
}

/* >>frames --------------------------------------------------------------------------------------------------------- */

static void close_frame(desk *d, frame_state *f) {
  for (uint32_t i = 0; f->tiles && i < tile_count(&d->given->of); i++)
    for (int k = 0; k < WINDOW; k++) free(f->tiles[i].early[k]);
  free(f->tiles);
  free(f->sums);
  free(f->display);
  memset(f, 0, sizeof *f);
  f->frame = NOWHERE;
}

/* The file of a frame; of several, each has its number before the suffix. */
static bool name_frame(desk *d, uint32_t frame) {
  const char *name = d->given->of.output, *dot = name ? strrchr(name, '.') : NULL;
  output_file *file = &d->shown.outputs[OUTPUT_PICTURE];
  memset(file, 0, sizeof *file);
  if (!name) return true;
  if (d->given->first == d->given->last) return name_output(file, "%s", name, "") && output_check(file);
  char number[16];
  snprintf(number, sizeof number, "-%03u", frame);
  const int n = snprintf(file->name, sizeof file->name, "%.*s%s%s", (int)(dot - name), name, number, dot);
  return (n > 0 && (size_t)n < sizeof file->name && output_check(file)) || ex_fail("%s: cannot be written", file->name);
}

static bool write_frame(desk *d, uint32_t frame) {
  job *j = &d->shown;
  const double start = busy_seconds();
  j->given.frame = frame;
  if (!name_frame(d, frame) || !put_pictures(j)) return false;
  d->writing += busy_seconds() - start;
  if (d->given->first == d->given->last) return true;
  printf("frame    %u: checksum %016llx, %u to %u samples per pixel", frame, (unsigned long long)j->checksum,
      (unsigned)j->report.samples_min, (unsigned)j->report.samples_max);
  if (j->report.rmse < INFINITY) printf(", RMSE %.4g", j->report.rmse);
  printf("%s%s\n", j->given.output ? ", " : "", j->outputs[OUTPUT_PICTURE].name);
  fflush(stdout);
  return true;
}

/* Decides, when all tiles have had the passes of this round, whether there is another; if not, the frame is done. */
static bool end_round(desk *d, frame_state *f) {
  job *j = &d->shown;
  const uint32_t tiles = tile_count(&d->given->of);
  const double start = busy_seconds();
  j->view.display_sums = f->display;
  if (pktrt_finish_passes(d->empty, &j->view, f->round, f->sums) != PKTRT_OK)
    return ex_fail("%s", pktrt_last_error(d->empty));
  d->judging += busy_seconds() - start;
  if (j->report.stop == PKTRT_STOP_NOT_YET) {
    f->round++;
    for (uint32_t i = 0; i < tiles; i++) f->behind += f->tiles[i].done < f->round;
    return true;
  }
  const uint32_t frame = f->frame;
  close_frame(d, f);
  d->finished++;
  return write_frame(d, frame);
}

static bool end_rounds(desk *d, frame_state *f) {
  while (f->frame != NOWHERE && f->behind == 0)
    if (!end_round(d, f)) return false;
  return true;
}

/* Opens the next frame, which may be done already by what an earlier run has left. A tile that has had a pass of a
   round tells that the rounds before did not end the picture. */
static bool open_frame(desk *d, frame_state *f) {
  const options *o = &d->given->of;
  const uint32_t tiles = tile_count(o);
  memset(f, 0, sizeof *f);
  f->frame = d->next++;
  for (int i = 0; i < d->count; i++) f->ranks += d->ranks[i].frame == f->frame;
  f->tiles = (tile_state *)calloc(tiles, sizeof *f->tiles);
  f->sums = (pktrt_pixel_sums *)calloc((size_t)o->width * o->height, sizeof *f->sums);
  const bool shown = o->measure == PKTRT_ERROR_DISPLAY;
  if (shown) f->display = (pktrt_display_sums *)calloc((size_t)o->width * o->height, sizeof *f->display);
  if (!f->tiles || !f->sums || (shown && !f->display))
    return ex_fail("not enough memory for the sums of %u x %u pixels", o->width, o->height);
  f->round = o->target_error > 0 ? 1 : o->passes;
  for (uint32_t i = 0; i < tiles; i++) {
    if (d->given->resume && d->folder[0]) take_up_tile(d, f, i);
    if (f->tiles[i].done > f->round) f->round = f->tiles[i].done;
  }
  for (uint32_t i = 0; i < tiles; i++) f->behind += f->tiles[i].done < f->round;
  return end_rounds(d, f);
}

/* Whether a frame has a unit to hand out, the one of its pass and tile `level` and `cursor`. */
static bool has_unit(const desk *d, frame_state *f) {
  for (; f->frame != NOWHERE && f->level < f->round; f->level++, f->cursor = 0)
    for (; f->cursor < tile_count(&d->given->of); f->cursor++) {
      const tile_state *t = &f->tiles[f->cursor];
      if (t->given == f->level) return t->given - t->done < WINDOW; /* else an earlier run has made it */
    }
  return false;
}

static frame_state *find_frame(desk *d, uint32_t frame) {
  for (int i = 0; i < d->frames_open; i++)
    if (d->open[i].frame == frame) return &d->open[i];
  return NULL;
}

/* A unit for a rank: of the frame that its tree is of, else of one that nobody has begun, else where fewest ranks are.
   u->frame END: there is none at present, for no rank. */
static bool choose_unit(desk *d, uint32_t at, unit *u) {
  frame_state *f = at != NOWHERE ? find_frame(d, at) : NULL;
  u->frame = END;
  if (f && !has_unit(d, f)) f = NULL;
  for (frame_state *free_one; !f && d->next <= d->given->last && (free_one = find_frame(d, NOWHERE));) {
    if (!open_frame(d, free_one)) return false;
    if (has_unit(d, free_one)) f = free_one;
  }
  for (int i = 0, own = f != NULL; !own && i < d->frames_open; i++)
    if (has_unit(d, &d->open[i]) && (!f || d->open[i].ranks < f->ranks)) f = &d->open[i];
  if (f) u->frame = f->frame, u->tile = f->cursor, u->pass = f->tiles[f->cursor++].given++;
  return true;
}

/* >>handing out ---------------------------------------------------------------------------------------------------- */

static void move_rank(desk *d, rank_state *r, uint32_t frame) {
  frame_state *from = r->frame != NOWHERE ? find_frame(d, r->frame) : NULL, *to = find_frame(d, frame);
  if (from) from->ranks--;
  if (to) to->ranks++;
  r->frame = frame;
}

/* Gives a rank that is idle something to do. *none: there is nothing. */
static bool feed(desk *d, int rank, bool *none) {
  rank_state *r = &d->ranks[rank];
  unit u;
  if (!choose_unit(d, r->frame, &u)) return false;
  *none = u.frame == END;
  if (*none) return true;
  move_rank(d, r, u.frame);
  r->idle = false, d->idle--;
  if (rank == 0) d->own.given = u, own_set(&d->own, OWN_GIVEN);
  else MPI_Send(&u, 3, MPI_UINT32_T, rank, 0, MPI_COMM_WORLD);
  return true;
}

static bool feed_all(desk *d) {
  bool ok = true, none = false;
  for (int rank = 0; ok && !none && d->idle > 0 && rank < d->count; rank++)
    if (d->ranks[rank].idle) ok = feed(d, rank, &none);
  return ok;
}

static void add_to_sums(const options *o, frame_state *f, uint32_t tile, const double *means) {
  uint32_t area[4];
  tile_area(o, tile, area);
  for (uint32_t y = 0; y < area[3]; y++) {
    const size_t at = (size_t)(area[1] + y) * o->width + area[0];
    pktrt_add_pass(means + (size_t)y * area[2] * 3, area[2], &f->sums[at]);
    if (f->display) pktrt_add_display_pass(means + (size_t)y * area[2] * 3, area[2], &f->display[at]);
  }
}

/* Adds a unit to its tile's sums, or lays it aside until the passes before it are there. */
static bool take(desk *d, int rank, const double *message) {
  const options *o = &d->given->of;
  const uint32_t tile = (uint32_t)message[MESSAGE_TILE], pass = (uint32_t)message[MESSAGE_PASS];
  const size_t n = message_length(o, tile) - MESSAGE_HEAD;
  const double start = busy_seconds();
  frame_state *f = find_frame(d, (uint32_t)message[MESSAGE_FRAME]);
  d->ranks[rank].idle = true, d->idle++;
  d->units++;
  tile_state *t = &f->tiles[tile];
  if (pass > t->done) {
    double *copy = (double *)malloc(n * sizeof *copy);
    if (!copy) return ex_fail("not enough memory for a tile");
    memcpy(copy, message + MESSAGE_HEAD, n * sizeof *copy);
    t->early[pass % WINDOW] = copy;
    return true;
  }
  add_to_sums(o, f, tile, message + MESSAGE_HEAD);
  for (double **early; *(early = &t->early[++t->done % WINDOW]) != NULL; *early = NULL) {
    add_to_sums(o, f, tile, *early);
    free(*early);
  }
  d->adding += busy_seconds() - start;
  keep_tile(d, f, tile);
  f->behind -= t->done == f->round;
  return end_rounds(d, f);
}

/* A line at times: standard error of a rank is no terminal. */
static void tell_progress(desk *d) {
  const double now = ex_seconds();
  if (!d->given->of.progress || now < d->told + 2) return;
  fprintf(stderr, "mpi: %u units of work and %u of %u pictures done in %.0f s\n", d->units, d->finished,
      d->given->last - d->given->first + 1, now - d->begun);
  d->told = now;
}

/* Takes one unit that has arrived, if there is. */
static bool serve(desk *d, double *message, size_t room, bool *served) {
  MPI_Status status;
  int there = 0, rank = -1;
  const own_state own = d->own.there ? own_get(&d->own) : OWN_IDLE;
  *served = false;
  if (own == OWN_FAILED) return false;
  if (own == OWN_DONE) {
    own_set(&d->own, OWN_IDLE);
    rank = 0;
    if (!take(d, 0, d->own.of->message)) return false;
  } else {
    MPI_Iprobe(MPI_ANY_SOURCE, 0, MPI_COMM_WORLD, &there, &status);
    if (!there) return true;
    rank = status.MPI_SOURCE;
    MPI_Recv(message, (int)room, MPI_DOUBLE, rank, 0, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    if (!take(d, rank, message)) return false;
  }
  *served = true;
  bool none;
  return feed(d, rank, &none) && (none || feed_all(d)); /* perhaps others can go on, too */
}

/* Hands out all there is to do. False: why not has been said, or a signal came. */
static bool hand_out(desk *d) {
  const size_t room = message_room(&d->given->of);
  double *message = (double *)malloc(room * sizeof *message), pause = PAUSE;
  for (int i = d->own.there ? 0 : 1; i < d->count; i++) d->ranks[i].idle = true, d->idle++;
  bool ok = message ? feed_all(d) : ex_fail("not enough memory for a tile"), served;
  while (ok && !interrupt_number && d->finished < d->given->last - d->given->first + 1) {
    ok = serve(d, message, room, &served);
    if (served) pause = PAUSE;
    else pause_for(&pause);
    tell_progress(d);
  }
  free(message);
  return ok && !interrupt_number;
}

/* >>ends: of ranks that die, and of runs --------------------------------------------------------------------------- */

/* When a rank dies, mpirun ends the others by SIGTERM. They wait a little, so that rank 0, or rank 1 if it is rank 0
   that died, can tell which process is missing. */
static char last_words[OUTPUT_PATH + 128];
static const place *all_places;
static int own_rank;

static void worker_signal(int number) {
  const struct timespec while_others_look = {0, 500000000};
  (void)number;
  if (own_rank == 1 && !strcmp(all_places[0].host, all_places[1].host) && kill((pid_t)all_places[0].pid, 0) != 0) {
    const ssize_t written = write(STDERR_FILENO, last_words, strlen(last_words));
    (void)written;
  }
  nanosleep(&while_others_look, NULL);
  _exit(1);
}
static void desk_signal(int number) { interrupt_number = number; }

static void take_signals(const desk *d, int rank, const place *places) {
  static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
  own_rank = rank, all_places = places;
  snprintf(last_words, sizeof last_words, "error: rank 0 has died; %s%s%s\n",
      d->folder[0] ? "run again with --resume " : "no tiles were kept: run again with -o or --resume", d->folder,
      d->folder[0] ? ", where its tiles are" : "");
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
    struct sigaction now;
    memset(&now, 0, sizeof now);
    now.sa_handler = rank ? worker_signal : desk_signal;
    sigaction(numbers[i], &now, NULL);
  }
}

/* The rank on this machine whose process is missing, or 0. */
static int missing_rank(const desk *d) {
  for (int k = 0; k < 20; k++) {
    for (int i = 1; i < d->count; i++)
      if (!strcmp(d->places[i].host, d->places[0].host) && kill((pid_t)d->places[i].pid, 0) != 0) return i;
    usleep(5000);
  }
  return 0;
}

/* The one sentence about a run that was ended. */
static void tell_end(const desk *d) {
  const int rank = missing_rank(d);
  char who[64] = "the run was ended, by a signal or by a rank on another machine";
  if (rank) snprintf(who, sizeof who, "rank %d of %d has died", rank, d->count);
  if (d->folder[0]) ex_fail("%s; run again with --resume %s, where its tiles are", who, d->folder);
  else ex_fail("%s; no tiles were kept: run again with -o or --resume", who);
}

/* >>ranks together ------------------------------------------------------------------------------------------------- */

/* Does the same on all ranks; what goes wrong is said once, by the lowest rank for which it does. */
static bool together(bool (*act)(void *), void *user) {
  int rank, count, worst;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &count);
  const int said = rank ? dup(STDERR_FILENO) : -1, nowhere = rank ? open("/dev/null", O_WRONLY) : -1;
  if (rank) dup2(nowhere, STDERR_FILENO);
  int good = act(user) ? count : rank;
  if (rank) dup2(said, STDERR_FILENO), close(said), close(nowhere);
  MPI_Allreduce(&good, &worst, 1, MPI_INT, MPI_MIN, MPI_COMM_WORLD);
  if (worst == rank && rank) act(user); /* again, aloud */
  return worst == count;
}

typedef struct run {
  int argc, rank, count;
  char **argv;
  mpi_options given;
  worker own;
  desk at; /* of rank 0 */
  uint64_t key, first_key;
} run;

static bool parse_run(void *user) {
  run *r = (run *)user;
  return parse_mpi_options(&r->given, r->argc, r->argv);
}

static bool load_run(void *user) {
  run *r = (run *)user;
  r->own.of.given = r->given.of;
  r->own.threads.count = r->given.of.threads;
  if (!r->own.message) r->own.message = (double *)malloc(message_room(&r->given.of) * sizeof(double));
  if (!r->own.message) return ex_fail("not enough memory for a tile");
  if (!settings_key(&r->given, &r->key) || !worker_load(&r->own, r->given.first)) return false;
  const options *chosen = &r->own.of.given; /* by what a mesh file has */
  r->given.of.mode = chosen->mode;
  r->given.of.samples = chosen->samples;
  r->given.of.passes = chosen->passes;
  r->given.of.measure = chosen->measure;
  return true;
}

static bool compare_run(void *user) {
  const run *r = (const run *)user;
  return r->key == r->first_key ||
         ex_fail("rank %d has another version, mesh file or settings than rank 0, which make other pictures", r->rank);
}

/* Rank 0 makes ready to hand out. */
static bool open_desk(void *user) {
  run *r = (run *)user;
  desk *d = &r->at;
  const size_t pixels = (size_t)r->given.of.width * r->given.of.height;
  pktrt_scene_desc desc;
  d->given = &r->given, d->key = r->key, d->count = r->count, d->next = r->given.first;
  if (r->rank) return true;
  const double frames = (double)(int)OPEN_BYTES / ((double)pixels * (double)pixel_words(&r->given.of) * sizeof(double));
  d->open = (frame_state *)calloc((size_t)r->count, sizeof *d->open);
  d->frames_open = !d->open ? 0 : frames < 1 ? 1 : frames < r->count ? (int)frames : r->count;
  for (int i = 0; i < d->frames_open; i++) d->open[i].frame = NOWHERE;
  memset(&desc, 0, sizeof desc);
  d->empty = pktrt_scene_create(&desc);
  d->ranks = (rank_state *)calloc((size_t)r->count, sizeof *d->ranks);
  d->shown.given = r->given.of, d->shown.view = r->own.of.view, d->shown.own_light = r->own.of.own_light;
  d->shown.view.pixels = (float *)calloc(pixels * 3, sizeof(float));
  d->shown.view.report = &d->shown.report;
  if (!d->open || !d->empty || !d->ranks || !d->shown.view.pixels)
    return ex_fail("not enough memory for a picture of %u x %u", r->given.of.width, r->given.of.height);
  for (int i = 0; i < r->count; i++) d->ranks[i].frame = r->given.first;
  return name_frame(d, r->given.first) && keep_begin(d);
}

/* >>table ---------------------------------------------------------------------------------------------------------- */

enum { SUMMED_UNITS, SUMMED_RENDER, SUMMED_SLOWEST, SUMMED_BUILD, SUMMED_LOAD, SUMMED_ISA, SUMMED };

static void print_ranks(const run *r, const double *all, const place *places) {
  enum { SHOWN = 16 };
  double least = INFINITY, most = 0;
  printf("\n  %-5s %-8s %7s %9s %9s %9s %9s  %s\n", "rank", "isa", "units", "render s", "slowest s", "build s",
      "scene s", "machine");
  for (int i = 0; i < r->count; i++) {
    const double *a = all + i * SUMMED;
    least = fmin(least, a[SUMMED_UNITS]), most = fmax(most, a[SUMMED_UNITS]);
    if (i < SHOWN)
      printf("  %-5d %-8s %7.0f %9.3f %9.3f %9.3f %9.3f  %s\n", i, pktrt_isa_string((pktrt_isa)(int)a[SUMMED_ISA]),
          a[SUMMED_UNITS], a[SUMMED_RENDER], a[SUMMED_SLOWEST], a[SUMMED_BUILD], a[SUMMED_LOAD], places[i].host);
  }
  if (r->count > SHOWN) printf("  ... of %d ranks; %.0f to %.0f units each\n", r->count, least, most);
}

static void print_desk(const desk *d) {
  const options *o = &d->given->of;
  printf("units    %u made, of %zu bytes; tiles %u\n", d->units, message_length(o, 0) * sizeof(double), tile_count(o));
  if (d->given->resume)
    printf("resume   %u tiles taken up, %u damaged and made again, %u of other settings\n", d->taken, d->damaged,
        d->foreign);
  printf("desk     processor %.3f s: adding %.3f, tiles on disk %.3f, errors %.3f, pictures %.3f, messages the rest\n",
      d->in_all, d->adding, d->keeping, d->judging, d->writing);
}

/* Gathers what the ranks have done, and tells all. */
static bool close_run(run *r, const place *places) {
  pktrt_scene_info info;
  const job *j = &r->own.of;
  double *all = r->rank ? NULL : (double *)malloc((size_t)r->count * SUMMED * sizeof *all);
  pktrt_get_scene_info(j->world, &info);
  const double own[SUMMED] = {
      (double)r->own.units, r->own.seconds, r->own.slowest, j->build_seconds, j->load_seconds, (double)info.isa};
  MPI_Gather(own, SUMMED, MPI_DOUBLE, all, SUMMED, MPI_DOUBLE, 0, MPI_COMM_WORLD);
  if (r->rank) return true;
  job *shown = &r->at.shown;
  shown->world = j->world, shown->load_seconds = j->load_seconds, shown->build_seconds = j->build_seconds;
  shown->render_seconds = ex_seconds() - r->at.begun;
  if (r->given.first == r->given.last) print_table(shown);
  else print_settings(shown), printf("seconds  %.3f\n", shown->render_seconds);
  print_desk(&r->at);
  if (all) print_ranks(r, all, places);
  free(all);
  keep_end(&r->at);
  return fflush(stdout) == 0 || ex_fail("the table could not be written: %s", strerror(errno));
}

/* What rank 0 does until all pictures are written. */
static bool lead(run *r) {
  desk *d = &r->at;
  const unit end = {END, 0, 0};
  const double busy = busy_seconds();
  d->begun = d->told = ex_seconds();
  own_start(&d->own, &r->own, r->count < OWN_RANKS);
  if (r->count == 1 && !d->own.there) return ex_fail("no thread can be started");
  if (!hand_out(d)) {
    if (interrupt_number) tell_end(d);
    return false;
  }
  d->in_all = busy_seconds() - busy;
  if (d->own.there) own_set(&d->own, OWN_END), pthread_join(d->own.thread, NULL);
  for (int i = 1; i < r->count; i++) MPI_Send(&end, 3, MPI_UINT32_T, i, 0, MPI_COMM_WORLD);
  return true;
}

/* A process on another machine may be lost without a signal here. */
static void lost(MPI_Comm *comm, int *code, ...) {
  (void)comm;
  if (own_rank == 0 && last_words[0])
    ex_fail("another rank is lost (MPI error %d); %s", *code, strchr(last_words, ';') + 2);
  _exit(1);
}

static void free_run(run *r) {
  for (int i = 0; i < r->at.frames_open; i++) close_frame(&r->at, &r->at.open[i]);
  free(r->at.open);
  pktrt_scene_destroy(r->at.empty);
  pktrt_scene_destroy(r->own.of.world);
  scene_free(&r->own.of.built_in);
  mesh_file_close(&r->own.of.file);
  free(r->at.shown.view.pixels);
  free(r->at.ranks);
  free(r->at.words);
  free(r->own.message);
  ex_threads_stop(&r->own.threads);
}

static bool run_all(run *r, place *places) {
  if (!together(parse_run, r)) return false;
  if (r->given.help) {
    if (!r->rank) print_mpi_help();
    return true;
  }
  if (!together(load_run, r)) return false;
  r->first_key = r->key;
  MPI_Bcast(&r->first_key, 1, MPI_UINT64_T, 0, MPI_COMM_WORLD);
  if (!together(compare_run, r) || !together(open_desk, r)) return false;
  MPI_Bcast(r->at.folder, sizeof r->at.folder, MPI_BYTE, 0, MPI_COMM_WORLD);
  r->at.places = places;
  take_signals(&r->at, r->rank, places);
  if (!(r->rank ? work(&r->own, r->rank) : lead(r))) {
    if (interrupt_number) _exit(1);
    MPI_Abort(MPI_COMM_WORLD, 1); /* the others do not know */
  }
  return close_run(r, places);
}

int main(int argc, char **argv) {
  static run r; /* static: zeroed */
  int level;
  MPI_Errhandler handler;
  place own;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_FUNNELED, &level);
  MPI_Comm_create_errhandler(lost, &handler);
  MPI_Comm_set_errhandler(MPI_COMM_WORLD, handler);
  MPI_Comm_rank(MPI_COMM_WORLD, &r.rank);
  MPI_Comm_size(MPI_COMM_WORLD, &r.count);
  r.argc = argc, r.argv = argv, own_rank = r.rank;
  memset(&own, 0, sizeof own);
  own.pid = (long)getpid();
  gethostname(own.host, sizeof own.host - 1);
  place *places = (place *)calloc((size_t)r.count, sizeof *places);
  if (!places) MPI_Abort(MPI_COMM_WORLD, 1);
  MPI_Allgather(&own, sizeof own, MPI_BYTE, places, sizeof own, MPI_BYTE, MPI_COMM_WORLD);
  const bool ok = run_all(&r, places);
  free_run(&r);
  free(places);
  MPI_Errhandler_free(&handler);
  MPI_Finalize();
  return ok ? 0 : 1;
}
