/* A packet walks down a small tree, and says what it does. Read it beside sections 3.1 to 3.3 of Boulos et al. 2007.

   64 rays, an 8 x 8 block of a camera's pixels, meet 36 boxes on a floor. The library's tree has up to eight children per node
   and up to eight triangles per leaf block. For each child of an opened node the packet does the cheapest thing that decides:

     1. The first active ray, the first that is known to hit the node, is tested. If it hits, so does the packet: descend.
     2. If not, interval arithmetic on all 64 origins and directions at once may prove that all miss: drop the child.
     3. Or the box lies wholly outside one of the four planes around the rays: drop it.
     4. Otherwise the rays are tested one after the other until one hits. The rays before it cannot hit anything below, so it
        becomes the first active ray of that child: the active range shrinks on the way down. If none hits: drop the child.

   The output is this conversation, indented by depth.    cc -O2 examples/packets.c -o packets -lm */
#define PKTRT_IMPLEMENTATION
#include "../pktrt.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

#define BOXES 6 /* along an edge of the square of boxes */
#define SIDE 8  /* rays along an edge of the packet */

static float positions[BOXES * BOXES * 8 + 4][3];
static uint32_t indices[BOXES * BOXES * 12 + 2][3];

/* Boxes of different heights on a floor: the corners of a box are numbered by the bits x, y, z. */
static void make_boxes(void) {
  static const uint32_t box[12][3] = {{0, 1, 5}, {0, 5, 4}, {2, 7, 3}, {2, 6, 7}, {0, 4, 6}, {0, 6, 2},
                                      {1, 3, 7}, {1, 7, 5}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  static const uint32_t ground[2][3] = {{0, 1, 2}, {0, 2, 3}};
  float(*p)[3] = positions;
  uint32_t(*t)[3] = indices;
  for (int i = 0; i < BOXES * BOXES; i++, p += 8, t += 12) {
    const float x = (float)(i % BOXES) - BOXES / 2, z = (float)(i / BOXES) - BOXES / 2;
    for (int c = 0; c < 8; c++) {
      p[c][0] = x + 0.2f + (c & 1 ? 0.6f : 0.0f);
      p[c][1] = c & 2 ? 0.3f + 0.25f * (float)(i * 7 % 5) : 0.0f;
      p[c][2] = z + 0.2f + (c & 4 ? 0.6f : 0.0f);
    }
    for (int k = 0; k < 36; k++) t[k / 3][k % 3] = (uint32_t)(8 * i) + box[k / 3][k % 3];
  }
  for (int c = 0; c < 4; c++) p[c][0] = c < 2 ? -4.0f : 4.0f, p[c][1] = 0, p[c][2] = c == 0 || c == 3 ? -4.0f : 4.0f;
  for (int k = 0; k < 6; k++) t[k / 3][k % 3] = (uint32_t)(BOXES * BOXES * 8) + ground[k / 3][k % 3];
}

/* The library tells one event at a time. Entered children wait on a stack until the packet comes to them, nearest first; this is
   that stack's shadow, which knows the depth of each. */
typedef struct walk {
  int waiting[512], top; /* depths of the entered children */
  int depth;             /* of the node or leaf at hand */
  int hits;              /* at the leaf at hand */
} walk;

static void say_child(const walk *w, const pktrt_event *e, const char *text) {
  printf("%*schild %u: %s\n", 2 * w->depth + 2, "", (unsigned)e->child, text);
}

static void end_leaf(walk *w) {
  if (w->hits >= 0) printf(", %d nearer hits\n", w->hits);
  w->hits = -1;
}

static void arrive(walk *w) {
  end_leaf(w);
  w->depth = w->top > 0 ? w->waiting[--w->top] : 0;
}

static void enter(walk *w) {
  if (w->top < 512) w->waiting[w->top++] = w->depth + 1;
}

static void tell(void *user, const pktrt_event *e) {
  walk *w = (walk *)user;
  switch (e->kind) {
  case PKTRT_EVENT_NODE:
    arrive(w);
    printf("%*snode %u: %u rays active, the first is ray %u\n", 2 * w->depth, "", (unsigned)e->index,
           (unsigned)e->active, (unsigned)e->ray);
    break;
  case PKTRT_EVENT_FIRST_HIT:
    enter(w);
    say_child(w, e, "entered, the first active ray hits it");
    break;
  case PKTRT_EVENT_LATER_HIT:
    enter(w);
    say_child(w, e, "entered, a later ray hits it and becomes the first active one");
    break;
  case PKTRT_EVENT_INTERVAL_CULL: say_child(w, e, "dropped by interval arithmetic"); break;
  case PKTRT_EVENT_FRUSTUM_CULL: say_child(w, e, "dropped, outside a plane around the rays"); break;
  case PKTRT_EVENT_ALL_MISS: say_child(w, e, "dropped, every active ray was tested and misses"); break;
  case PKTRT_EVENT_LEAF:
    arrive(w);
    w->hits = 0;
    printf("%*sleaf %u: %u rays active", 2 * w->depth, "", (unsigned)e->index, (unsigned)e->active);
    break;
  case PKTRT_EVENT_HIT: w->hits++; break;
  }
}

/* What the walk cost, beside what 64 single rays would pay at the same nodes. */
static void sum_up(const pktrt_counts *c) {
  printf("\n%llu rays in %llu packet, %llu hits. Of the children of %llu opened nodes\n", (unsigned long long)c->rays,
         (unsigned long long)c->packets, (unsigned long long)c->hits, (unsigned long long)c->node_visits);
  printf("  %4llu were entered on the word of the first active ray,\n", (unsigned long long)c->first_hits);
  printf("  %4llu were dropped by interval arithmetic and %llu by a frustum plane, at the price of one ray,\n",
         (unsigned long long)c->interval_culls, (unsigned long long)c->frustum_culls);
  printf("  %4llu were dropped after testing every active ray.\n", (unsigned long long)c->ray_culls);
  printf(
      "That took %.1f box tests and %.1f triangle tests per ray; %llu triangles were dropped by planes for all rays.\n",
      (double)c->box_tests / (double)c->rays, (double)c->triangle_tests / (double)c->rays,
      (unsigned long long)c->triangle_culls);
}

int main(void) {
  static pktrt_ray rays[SIDE * SIDE];
  static pktrt_hit hits[SIDE * SIDE];
  static pktrt_stats stats;
  walk w = {{0}, 0, 0, -1};
  pktrt_scene *scene = pktrt_scene_create(NULL);
  make_boxes();
  const pktrt_mesh_desc mesh = {
      &positions[0][0], BOXES * BOXES * 8 + 4, 0, &indices[0][0], BOXES * BOXES * 12 + 2, 0, NULL, 0};
  if (pktrt_add_mesh(scene, &mesh, NULL) || pktrt_commit(scene)) {
    fprintf(stderr, "error: %s\n", pktrt_last_error(scene));
    return 1;
  }
  for (int i = 0; i < SIDE * SIDE; i++) { /* a narrow bundle that looks down across the boxes */
    const pktrt_ray ray = {
        {1, 4, 6}, 0, {-0.3f + 0.02f * (float)(i % SIDE), -0.6f - 0.02f * (float)(i / SIDE), -1}, INFINITY, 0};
    rays[i] = ray;
  }
  pktrt_query_desc query;
  memset(&query, 0, sizeof query);
  query.path = PKTRT_PATH_PAPER;
  query.packet_size = SIDE * SIDE;
  query.stats = &stats;
  query.trace = tell;
  query.user = &w;
  pktrt_intersect_ex(scene, &query, rays, hits, SIDE * SIDE);
  end_leaf(&w);
  sum_up(&stats.by_type[PKTRT_RAY_PRIMARY]);
  pktrt_scene_destroy(scene);
  return 0;
}
