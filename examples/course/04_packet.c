/* Chapter 4: a packet walks down the library's tree, as plainly as can be. Makes out/course/04_range.svg.
   Prints what it cost.    cc -O2 examples/course/04_packet.c -o packet -lm && ./packet */
#define PKTRT_IMPLEMENTATION
#include "course.h"
#include "../svg.h"

enum { WIDTH = 256, HEIGHT = 192, SIDE = 8, RAYS = SIDE * SIDE };

/* [packet] */
typedef struct packet {
  const course_scene *scene;
  const pktrt_node *nodes;
  uint32_t n; /* rays */
  course_ray ray[RAYS];
  course_slabs slabs[RAYS];
  course_hit hit[RAYS];
  uint64_t boxes, triangles; /* tests */
  course_log *log;
} packet;

static void tell(packet *p, pktrt_event_kind kind, uint32_t index, uint32_t child, uint32_t ray, uint32_t depth) {
  pktrt_event e;
  memset(&e, 0, sizeof e);
  e.kind = kind, e.index = index, e.child = child, e.ray = ray, e.depth = depth, e.active = p->n - ray;
  course_log_event(p->log, &e);
}

/* Finds the first ray, from `first` on, that enters a child; n: none does. */
static uint32_t find_first(packet *p, uint32_t index, uint32_t k, uint32_t first, uint32_t depth) {
  const pktrt_node *node = &p->nodes[index];
  uint32_t ray = first;
  while (ray < p->n && !course_slabs_enter(&p->slabs[ray], node->lo[k], node->hi[k], NULL)) ray++;
  p->boxes += ray - first + (ray < p->n);
  pktrt_event_kind verdict = PKTRT_EVENT_FIRST_HIT;
  if (ray > first) verdict = ray < p->n ? PKTRT_EVENT_LATER_HIT : PKTRT_EVENT_ALL_MISS;
  tell(p, verdict, index, k, ray < p->n ? ray : first, depth);
  return ray;
}

/* All rays from `first` on meet a leaf's triangles, whether or not they enter its box. */
static void meet_leaf(packet *p, const pktrt_node *node, uint32_t k, uint32_t first, uint32_t depth) {
  tell(p, PKTRT_EVENT_LEAF, node->child[k], 0, first, depth);
  for (uint32_t r = first; r < p->n; r++)
    for (uint32_t lane = 0; lane < 8; lane++) {
      if (node->triangle[k][lane] == PKTRT_NONE) continue;
      p->triangles++;
      if (course_slabs_meet(&p->slabs[r], p->scene, p->ray[r], node->triangle[k][lane], &p->hit[r]))
        tell(p, PKTRT_EVENT_HIT, node->child[k], lane, r, depth);
    }
}

/* The rays before `first` are known to miss the node; those from it on may hit it. */
static void descend(packet *p, uint32_t index, uint32_t first, uint32_t depth) {
  tell(p, PKTRT_EVENT_NODE, index, 0, first, depth);
  const pktrt_node *node = &p->nodes[index];
  for (uint32_t k = 8; k-- > 0;) { /* from place 7 to 0, as the library does without PKTRT_PAPER_STEP_ORDER */
    if (node->child[k] == PKTRT_NONE) continue;
    const uint32_t ray = find_first(p, index, k, first, depth + 1);
    if (ray == p->n) continue;
    if (node->leaf[k]) meet_leaf(p, node, k, ray, depth + 1);
    else descend(p, node->child[k], ray, depth + 1);
  }
}
/* [end] */

/* The camera's rays through 8 x 8 pixels, row by row. */
static void aim(packet *p, uint32_t x, uint32_t y) {
  p->n = RAYS;
  for (uint32_t i = 0; i < RAYS; i++) {
    p->ray[i] = course_camera_ray((float)(x + i % SIDE) + 0.5f, (float)(y + i / SIDE) + 0.5f, WIDTH, HEIGHT);
    p->slabs[i] = course_slabs_make(&p->nodes[0], p->ray[i]);
    p->hit[i].t = INFINITY, p->hit[i].triangle = COURSE_NONE;
  }
  p->log->count = 0;
}

/* A row for each verdict: which child, and which rays go on from it or were dropped with it. */
static void draw_log(svg *s, double x, const char *title, const course_log *log) {
  static const char *const colour[] = {"", "#3a3", "#95d", "#9cf", "#e80", "#e55"};
  double y = 30;
  svg_text(s, x, 16, 11, SVG_LEFT, "%s", title);
  for (size_t i = 0; i < log->count; i++) {
    const pktrt_event *e = &log->event[i];
    if (e->kind < PKTRT_EVENT_FIRST_HIT || e->kind > PKTRT_EVENT_ALL_MISS) continue;
    const bool entered = e->kind == PKTRT_EVENT_FIRST_HIT || e->kind == PKTRT_EVENT_LATER_HIT;
    const char *to = !entered ? "" : e[1].kind == PKTRT_EVENT_NODE ? ": node" : ": leaf";
    svg_text(s, x + 10 * (double)e->depth - 10, y, 7, SVG_LEFT, "place %u%s", (unsigned)e->child, to);
    svg_range(s, x + 90, y - 6, 4 * RAYS, 6, e->ray, e->ray + e->active - 1, RAYS, colour[e->kind]);
    for (size_t j = i + 2; j < log->count && log->event[j].kind >= PKTRT_EVENT_HIT; j++)
      if (log->event[j].kind == PKTRT_EVENT_HIT) svg_dot(s, x + 92 + 4 * log->event[j].ray, y - 3, 1.5, "#000");
    y += 9;
  }
}

/* What the library tests for a packet, a ray against a box each, if it takes these steps. */
static uint64_t library_tests(const pktrt_scene *library, const packet *p, uint32_t steps, course_log *log) {
  uint64_t tests = 0;
  log->count = 0;
  course_library_packet(library, p->ray, p->n, steps, NULL, log);
  for (size_t i = 0; i < log->count; i++) tests += log->event[i].tested;
  return tests;
}

static void draw(const pktrt_scene *library, packet *p, course_log *theirs) {
  svg s;
  if (!svg_begin(&s, "out/course/04_range.svg", 740, 360)) exit(1);
  aim(p, 96, 32);
  descend(p, 0, 0, 0);
  draw_log(&s, 15, "first active ray alone, children from place 7 to 0", p->log);
  library_tests(library, p, 0, theirs);
  draw_log(&s, 385, "the library: all of its steps, children from near to far", theirs);
  if (!svg_end(&s)) exit(1);
}

int main(void) {
  course_make_folder();
  course_scene scene = course_scene_make();
  pktrt_scene *library = course_library(&scene);
  uint32_t nodes, same = 0, packets = 0;
  double told[PKTRT_EVENT_HIT + 1] = {0}, vain = 0, ordered = 0, all = 0;
  course_log mine = {NULL, 0, 0}, theirs = {NULL, 0, 0};
  static packet p; /* zeroed */
  p.scene = &scene, p.nodes = course_library_nodes(library, &nodes), p.log = &mine;
  for (uint32_t y = 0; y < HEIGHT; y += SIDE)
    for (uint32_t x = 0; x < WIDTH; x += SIDE, packets++) {
      aim(&p, x, y);
      descend(&p, 0, 0, 0);
      for (size_t i = 0; i < mine.count; i++) {
        told[mine.event[i].kind]++;
        if (mine.event[i].kind == PKTRT_EVENT_ALL_MISS) vain += mine.event[i].active;
      }
      ordered += (double)library_tests(library, &p, PKTRT_PAPER_STEP_ORDER, &theirs);
      all += (double)library_tests(library, &p, 0, &theirs);
      library_tests(library, &p, PKTRT_PAPER_STEP_NONE, &theirs);
      same += course_same_log(&mine, &theirs, packets, false);
    }
  const double n = packets, rays = n * RAYS;
  printf("04_packet: %u packets of %u rays: %u tell the same events as the library's\n", (unsigned)packets, RAYS,
      (unsigned)same);
  printf(
      "  a packet opens %.1f nodes; the first active ray enters %.1f of their children, a later one %.1f, none %.1f\n",
      told[PKTRT_EVENT_NODE] / n, told[PKTRT_EVENT_FIRST_HIT] / n, told[PKTRT_EVENT_LATER_HIT] / n,
      told[PKTRT_EVENT_ALL_MISS] / n);
  printf("  a ray meets %.1f boxes and %.1f triangles; %.0f%% of the box tests are of children that no ray enters\n",
      (double)p.boxes / rays, (double)p.triangles / rays, 100 * vain / (double)p.boxes);
  printf("  the library tests %.1f boxes a ray from near to far, %.1f with all steps\n", ordered / rays, all / rays);
  draw(library, &p, &theirs);
  pktrt_scene_destroy(library);
  return 0;
}
