/* How much stack queries, renders and builds take, painted and looked at: a program of its own, since what compilers make of it
   depends on their options. Prints the most of each. Exit status 1: a query takes more than `stack LIMIT` allows (60 KiB,
   as the header promises), in code that is optimised. What is not optimised keeps every temporary in memory: it is told only. */
#if !defined(_POSIX_C_SOURCE)
#define _POSIX_C_SOURCE 200809L
#endif
#include "scenes.h"
#include <pthread.h>

enum { STACK = 1 << 20, QUERIES = 7, WAYS = 11, SCENES = 4 };
static const char *const way_name[WAYS] = {"single rays", "fast path", "fast path, counted", "paper path",
    "paper path, counted", "single path", "arrays of coordinates", "build", "render", "render, paper path",
    "render, single path"};

/* What queries look at: meshes alone; with instances, of a model at rest and a moving one, at rest and moving; in so many
   groups that a tree lies above them; instances and groups. Bit 0: instances, bit 1: groups. */
static const char *const scene_name[SCENES] = {"", ", instances", ", groups", ", instances and groups"};

static struct {
  pktrt_scene *s;
  const char *top; /* where the calls begin */
  int way;         /* WAYS: nothing */
  pktrt_ray ray[RAYS];
  pktrt_hit hit[RAYS];
  bool blocked[RAYS];
  float in[6][RAYS], out[RAYS], pixels[WIDTH * HEIGHT * 3];
  pktrt_stats stats;
  pktrt_query_desc q;
  pktrt_render_desc view;
} now;

static void ask_single(void) {
  for (int i = 0; i < RAYS; i++) {
    pktrt_intersect(now.s, &now.ray[i], &now.hit[i]);
    now.blocked[i] = pktrt_occluded(now.s, &now.ray[i]);
  }
}

static void ask_many(void) {
  memset(&now.q, 0, sizeof now.q);
  now.q.path = now.way < 3 ? PKTRT_PATH_FAST : now.way < 5 ? PKTRT_PATH_PAPER : PKTRT_PATH_SINGLE;
  now.q.packet_size = 256;
  if (now.way % 2 == 0) now.q.stats = &now.stats;
  pktrt_intersect_ex(now.s, &now.q, now.ray, now.hit, RAYS);
  pktrt_occluded_ex(now.s, &now.q, now.ray, now.blocked, RAYS);
}

static void ask_soa(void) {
  pktrt_rays in;
  pktrt_hits out;
  memset(&in, 0, sizeof in);
  memset(&out, 0, sizeof out);
  for (int i = 0; i < RAYS; i++) {
    for (int a = 0; a < 3; a++) now.in[a][i] = now.ray[i].origin[a], now.in[3 + a][i] = now.ray[i].direction[a];
  }
  for (int a = 0; a < 3; a++) in.origin[a] = now.in[a], in.direction[a] = now.in[3 + a];
  out.t = now.out;
  pktrt_intersect_soa(now.s, &in, &out, RAYS);
  pktrt_occluded_soa(now.s, &in, now.blocked, RAYS);
}

static void build(void) {
  expect(now.s, pktrt_mark_changed(now.s));
  expect(now.s, pktrt_commit(now.s));
}

static void render(void) {
  now.view.path = now.way == 8 ? PKTRT_PATH_FAST : now.way == 9 ? PKTRT_PATH_PAPER : PKTRT_PATH_SINGLE;
  expect(now.s, pktrt_render(now.s, &now.view));
}

static void nothing(void) {}

/* Called by way of a volatile pointer, so that none of it becomes a part of the thread's own frame. */
static void (*volatile call)(void);

static void *thread(void *arg) {
  const char here = 0;
  now.top = &here;
  call();
  return arg;
}

static size_t painted(int way, void (*what)(void)) {
  char *memory = NULL, *low;
  pthread_attr_t attributes;
  pthread_t t;
  now.way = way, call = what;
  if (posix_memalign((void **)&memory, 4096, STACK)) abort();
  memset(memory, 0xA5, STACK);
  if (pthread_attr_init(&attributes) || pthread_attr_setstack(&attributes, memory, STACK)) abort();
  if (pthread_create(&t, &attributes, thread, NULL)) abort();
  pthread_join(t, NULL);
  pthread_attr_destroy(&attributes);
  for (low = memory; low < now.top && *low == (char)0xA5;) low++;
  const size_t used = (size_t)(now.top - low);
  free(memory);
  return used;
}

/* Returns the description of a shape, whose arrays it has. */
static pktrt_mesh_desc described(const shape *m) {
  pktrt_mesh_desc d;
  memset(&d, 0, sizeof d);
  d.positions = m->position, d.vertex_count = m->vertex_count;
  d.indices = m->index, d.triangle_count = m->triangle_count;
  d.key_count = m->key_count;
  return d;
}

/* Adds what the scene has besides meshes. */
static void add_more(int scene) {
  static const float keys[24] = {
      1, 0, 0.5f, 1, 0.25f, 1, 0, 0, 0, 0, -1, 0, 1, 0, 0.5f, 2, 0.25f, 1, 0, 0, 0, 0, -1, 0};
  uint32_t model;

  for (uint32_t i = 0; i < 2 && (scene & 1); i++) {
    shape *ball = i ? moved(a_ball(), 2, 0, UNIT / 16, 2) : a_ball();
    const pktrt_mesh_desc mesh = described(ball);
    expect(now.s, pktrt_add_model(now.s, &mesh, 1, &model));
    for (uint32_t k = 1; k <= 2; k++) {
      const pktrt_instance_desc at = {model, k, keys, 0, PKTRT_INTERPOLATION_LINEAR};
      expect(now.s, pktrt_add_instance(now.s, &at, NULL));
    }
    free(ball);
  }

  for (uint32_t i = 0; i < 8 && (scene & 2); i++) {
    shape *box = a_box();
    pktrt_mesh_desc mesh = described(box);
    mesh.group = 1 + i;
    expect(now.s, pktrt_add_mesh(now.s, &mesh, NULL));
    free(box);
  }
  expect(now.s, pktrt_commit(now.s));
}

/* DRT with all that lies on the stack, as deep as can be. */
static void look_around(pktrt_isa isa) {
  now.s = room(isa, GLASS | MIRROR | LOBES | COAT | HOOKS | LAMPS | SMOOTH | MOVING);
  now.view = view_of(PKTRT_MODE_DRT, 4);
  now.view.pixels = now.pixels, now.view.environment = sky, now.view.stats = &now.stats;
  now.view.camera.shutter = 1, now.view.camera.aperture = 0.25f, now.view.max_depth = 0, now.view.attenuation = -1;
}

/* Returns what a way takes at most. */
static size_t look_at(int way, int scene, size_t none) {
  static void (*const what[WAYS])(void) = {
      ask_single, ask_many, ask_many, ask_many, ask_many, ask_many, ask_soa, build, render, render, render};
  const size_t used = painted(way, what[way]);
  printf("%s, %s%s: %lu bytes of stack\n", isa_now, way_name[way], scene_name[scene], (unsigned long)used);
  if (used <= none) complain("the probe sees nothing: ", way_name[way]);
  return used;
}

int main(int argc, char **argv) {
  const size_t limit = argc > 1 ? (size_t)atol(argv[1]) : 60 << 10;
  size_t most = 0;
  for (int isa = PKTRT_ISA_SCALAR; isa < PKTRT_ISA_COUNT; isa++) {
    if (!pktrt_isa_available((pktrt_isa)isa)) continue;
    isa_now = pktrt_isa_string((pktrt_isa)isa), part_now = "stack";
    const size_t none = painted(WAYS, nothing); /* the end of a thread takes some, too */
    for (int scene = 0; scene < SCENES; scene++) {
      now.s = world((pktrt_isa)isa, true);
      make_rays(now.ray, 1);
      add_more(scene);
      for (int way = 0; way < 8; way++) {
        const size_t used = look_at(way, scene, none);
        if (way < QUERIES && used > most) most = used;
      }
      pktrt_scene_destroy(now.s);
    }
    look_around((pktrt_isa)isa);
    for (int way = 8; way < WAYS; way++) (void)look_at(way, 0, none);
    pktrt_scene_destroy(now.s);
  }
  printf("queries: at most %lu bytes of stack\n", (unsigned long)most);
#ifdef __OPTIMIZE__
  if (most > limit) complain("more than is allowed", "");
#else
  (void)limit;
#endif
  return complaints != 0;
}
