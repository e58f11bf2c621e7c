/* Chapter 4: a packet walks down the library's tree. Makes out/course/04_range.svg.
   Prints the number of tests.    cc -O2 examples/course/04_packet.c -o packet -lm && ./packet */
#define PKTRT_IMPLEMENTATION
#include "course.h"
#include "04_range.h"

enum { WIDTH = 256, HEIGHT = 192, SIDE = 8 /* pixels, of a packet's square */, RAYS = SIDE * SIDE };

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

/* Logs an event. */
static void report(packet *p, pktrt_event_kind kind, uint32_t index, uint32_t child, uint32_t ray, uint32_t depth) {
  pktrt_event e;
  memset(&e, 0, sizeof e);
  e.kind = kind;
  e.index = index;
  e.child = child;
  e.ray = ray;
  e.depth = depth;
  e.active = p->n - ray;
  course_log_event(p->log, &e);
}

/* Returns the first ray, from `first` on, that enters child k of a node; n if none enters. Logs the verdict. */
static uint32_t find_first(packet *p, uint32_t index, uint32_t k, uint32_t first, uint32_t depth) {
  const pktrt_node *node = &p->nodes[index];
  uint32_t ray = first;

  while (ray < p->n && !course_slabs_enter(&p->slabs[ray], node->lo[k], node->hi[k], NULL)) ray++;
  p->boxes += ray - first + (ray < p->n);

  pktrt_event_kind verdict = PKTRT_EVENT_FIRST_HIT;
  if (ray > first) verdict = ray < p->n ? PKTRT_EVENT_LATER_HIT : PKTRT_EVENT_ALL_MISS;
  report(p, verdict, index, k, ray < p->n ? ray : first, depth);
  return ray;
}

/* Tests all rays from `first` on against the triangles of a leaf, whether or not they enter the leaf's box. */
static void meet_leaf(packet *p, const pktrt_node *node, uint32_t k, uint32_t first, uint32_t depth) {
  report(p, PKTRT_EVENT_LEAF, node->child[k], 0, first, depth);
  for (uint32_t r = first; r < p->n; r++)
    for (uint32_t lane = 0; lane < 8; lane++) {
      if (node->triangle[k][lane] == PKTRT_NONE) continue;
      p->triangles++;
      if (course_slabs_meet(&p->slabs[r], p->scene, p->ray[r], node->triangle[k][lane], &p->hit[r]))
        report(p, PKTRT_EVENT_HIT, node->child[k], lane, r, depth);
    }
}

/* Walks the tree below a node. The rays before `first` are known to miss the node; the others may hit it. */
static void descend(packet *p, uint32_t index, uint32_t first, uint32_t depth) {
  report(p, PKTRT_EVENT_NODE, index, 0, first, depth);
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

/* Makes the packet of the camera's rays through a square of pixels, row by row; (x, y) is its upper left pixel. */
static void aim(packet *p, uint32_t x, uint32_t y, uint32_t side) {
  p->n = side * side;
  for (uint32_t i = 0; i < p->n; i++) {
    p->ray[i] = course_camera_ray((float)(x + i % side) + 0.5f, (float)(y + i / side) + 0.5f, WIDTH, HEIGHT);
    p->slabs[i] = course_slabs_make(&p->nodes[0], p->ray[i]);
    p->hit[i].t = INFINITY;
    p->hit[i].triangle = COURSE_NONE;
  }
  p->log->count = 0;
}

/* Prints the tests of packets of one ray: the same order of the children, and no ray tests for others. */
static void print_single_rays(packet *p) {
  const double rays = WIDTH * HEIGHT;

  p->boxes = 0;
  p->triangles = 0;
  for (uint32_t y = 0; y < HEIGHT; y++)
    for (uint32_t x = 0; x < WIDTH; x++) {
      aim(p, x, y, 1);
      descend(p, 0, 0, 0);
    }
  printf("  in packets of one ray, a ray is tested against %.1f boxes and %.1f triangles\n", (double)p->boxes / rays,
      (double)p->triangles / rays);
  course_figure("single.boxes", "%.1f", (double)p->boxes / rays);
  course_figure("single.triangles", "%.1f", (double)p->triangles / rays);
}

/* Draws the events of one packet, and prints the event at which the text's link opens the page. */
static void draw(const pktrt_scene *library, packet *p, course_log *theirs) {
  const uint32_t page_event = 142;

  aim(p, 96, 32, SIDE);
  descend(p, 0, 0, 0);
  course_library_tests(library, p->ray, p->n, 0, theirs);
  if (!range_draw("out/course/04_range.svg", p->log, theirs, RAYS)) exit(1);

  course_library_tests(library, p->ray, p->n, PKTRT_PAPER_STEP_NONE, theirs);
  if (page_event >= theirs->count) return;
  const pktrt_event *e = &theirs->event[page_event];
  course_figure("page.missed", "%u", (unsigned)e->ray - 1);
  course_figure("page.first", "%u", (unsigned)e->ray);
}

int main(void) {
  course_make_folder();
  course_scene scene = course_scene_make();
  pktrt_scene *library = course_library(&scene);
  uint32_t nodes, same = 0, packets = 0;
  double told[PKTRT_EVENT_HIT + 1] = {0}, vain = 0, ordered = 0, all = 0;
  course_log mine = {NULL, 0, 0}, theirs = {NULL, 0, 0};
  static packet p; /* zeroed */
  p.scene = &scene;
  p.nodes = course_library_nodes(library, &nodes);
  p.log = &mine;

  for (uint32_t y = 0; y < HEIGHT; y += SIDE)
    for (uint32_t x = 0; x < WIDTH; x += SIDE) {
      aim(&p, x, y, SIDE);
      descend(&p, 0, 0, 0);
      for (size_t i = 0; i < mine.count; i++) {
        told[mine.event[i].kind]++;
        if (mine.event[i].kind == PKTRT_EVENT_ALL_MISS) vain += mine.event[i].active;
      }
      ordered += (double)course_library_tests(library, p.ray, p.n, PKTRT_PAPER_STEP_ORDER, &theirs);
      all += (double)course_library_tests(library, p.ray, p.n, 0, &theirs);
      course_library_tests(library, p.ray, p.n, PKTRT_PAPER_STEP_NONE, &theirs);
      same += course_same_log(&mine, &theirs, packets, false);
      packets++;
    }

  const double n = packets, rays = n * RAYS, boxes = (double)p.boxes;
  printf("04_packet: %u packets of %u rays: %u tell the same events as the library's\n", (unsigned)packets, RAYS,
      (unsigned)same);
  printf(
      "  a packet opens %.1f nodes; the first active ray enters %.1f of their children, a later one %.1f, none %.1f\n",
      told[PKTRT_EVENT_NODE] / n, told[PKTRT_EVENT_FIRST_HIT] / n, told[PKTRT_EVENT_LATER_HIT] / n,
      told[PKTRT_EVENT_ALL_MISS] / n);
  printf("  a ray is tested against %.1f boxes and %.1f triangles; %.0f%% of the box tests are of children that no ray "
         "enters\n",
      boxes / rays, (double)p.triangles / rays, 100 * vain / boxes);
  printf("  the library tests %.1f boxes a ray from near to far, %.1f with all steps\n", ordered / rays, all / rays);
  course_figure("packets", "%u", (unsigned)packets);
  course_figure("rays", "%u", RAYS);
  course_figure("same", "%u", (unsigned)same);
  course_figure("nodes", "%.1f", told[PKTRT_EVENT_NODE] / n);
  course_figure("enters.first", "%.1f", told[PKTRT_EVENT_FIRST_HIT] / n);
  course_figure("enters.later", "%.1f", told[PKTRT_EVENT_LATER_HIT] / n);
  course_figure("enters.none", "%.1f", told[PKTRT_EVENT_ALL_MISS] / n);
  course_figure("boxes", "%.1f", boxes / rays);
  course_figure("triangles", "%.1f", (double)p.triangles / rays);
  course_figure("vain", "%.0f", 100 * vain / boxes);
  course_figure("library.ordered", "%.1f", ordered / rays);
  course_figure("library.all", "%.1f", all / rays);

  print_single_rays(&p);
  draw(library, &p, &theirs);
  pktrt_scene_destroy(library);
  return 0;
}
