/* A packet walks down a small tree, and says what it does. Read it beside sections 3.1 to 3.3 of Boulos et al. 2007.

   64 rays, an 8 x 8 block of a camera's pixels, meet 36 boxes on a floor. The library's tree has up to eight children per node
   and up to eight triangles per leaf block. The children of an opened node wait on a stack, and when the packet comes to one it
   does the cheapest thing that decides:

     1. The first active ray, the first not yet known to miss, is tested, together with its SIMD group, the rays that the
        machine tests at the same price. If one hits, the packet enters: no other ray is asked.
     2. If not, interval arithmetic on the origins and directions of all rays may prove that all miss: drop the child.
     3. Or the box lies outside one of the four planes around the rays: drop it.
     4. Otherwise the other rays are tested, group by group, until one hits. The rays before it cannot hit anything below, so it
        becomes the first active ray of that child: the active range shrinks on the way down. If none hits: drop the child.

   So a child is entered with a range of rays, from the first active one to the last group not known to miss. Some of them may
   miss: at a leaf they are tested against its box, and those that hit it against its triangles.

   The output is this conversation, indented by depth.    cc -O2 examples/packets.c -o packets -lm && ./packets */
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
  static const uint32_t box[12][3] = {{0, 1, 5}, {0, 5, 4}, {2, 7, 3}, {2, 6, 7}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7},
      {1, 7, 5}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
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

/* The library tells one event at a time; this remembers what the next one needs. */
typedef struct walk {
  int hits;     /* in the leaf at hand; -1: not in a leaf */
  int children; /* that something was said about */
} walk;

static void end_leaf(walk *w) {
  if (w->hits >= 0) printf(": %d nearer hit%s\n", w->hits, w->hits == 1 ? "" : "s");
  w->hits = -1;
}

static void tell(void *user, const pktrt_event *e) {
  static const char *const verdict[] = {"", "entered: the first active ray, %u, hits it",
      "dropped by interval arithmetic", "dropped: outside a plane around the rays",
      "entered: ray %u hits it and becomes the first active one", "dropped: every active ray was tested and misses"};
  walk *w = (walk *)user;
  const unsigned index = (unsigned)e->index, ray = (unsigned)e->ray, last = ray + (unsigned)e->active - 1;
  const int depth = 2 * (int)e->depth;
  if (e->kind == PKTRT_EVENT_LEAF_TEST) return; /* of each group of eight rays: too much to print */
  if (e->kind == PKTRT_EVENT_HIT) {
    w->hits++;
    return;
  }
  end_leaf(w);
  switch (e->kind) {
  case PKTRT_EVENT_NODE: /* the child just entered, or the root */
    printf("%*snode %u is opened for rays %u to %u\n", depth, "", index, ray, last);
    break;
  case PKTRT_EVENT_LEAF:
    printf("%*sleaf %u is met by those of rays %u to %u that hit its box", depth, "", index, ray, last);
    w->hits = 0;
    break;
  case PKTRT_EVENT_TRIM: printf("%*srays behind %u miss the child that comes next\n", depth, "", last); break;
  default: /* about a child of the node `index` */
    w->children++;
    printf("%*schild %u of node %u ", depth, "", (unsigned)e->child, index);
    printf(verdict[e->kind], ray);
    printf("\n");
  }
}

/* What became of the children, and what the walk cost. Slots of nodes that are empty are no children. */
static void sum_up(const pktrt_counts *c, int children) {
  const double rays = (double)c->rays;
  printf("\n%u rays in %u packet, %u of them with a hit. %u nodes were opened; of their %d children\n",
      (unsigned)c->rays, (unsigned)c->packets, (unsigned)c->hits, (unsigned)c->node_visits, children);
  printf("  %3u were entered: the first active ray hits them,\n", (unsigned)c->first_hits);
  printf("  %3u were entered: a later ray hits them,\n", (unsigned)c->later_hits);
  printf("  %3u were dropped by interval arithmetic,\n", (unsigned)c->interval_culls);
  printf("  %3u were dropped: outside a plane,\n", (unsigned)c->frustum_culls);
  printf("  %3u were dropped: every active ray was tested and misses.\n", (unsigned)c->ray_culls);
  printf("That took %.1f box tests and %.1f triangle tests per ray.\n", (double)c->box_tests / rays,
      (double)c->triangle_tests / rays);
}

int main(void) {
  static pktrt_ray rays[SIDE * SIDE];
  static pktrt_hit hits[SIDE * SIDE];
  static pktrt_stats stats;
  static walk w; /* static: zeroed */
  pktrt_scene *scene = pktrt_scene_create(NULL);
  make_boxes();
  w.hits = -1;
  static pktrt_mesh_desc mesh;
  mesh.positions = &positions[0][0], mesh.vertex_count = BOXES * BOXES * 8 + 4;
  mesh.indices = &indices[0][0], mesh.triangle_count = BOXES * BOXES * 12 + 2;
  if (pktrt_add_mesh(scene, &mesh, NULL) || pktrt_commit(scene)) {
    fprintf(stderr, "error: %s\n", pktrt_last_error(scene));
    return 1;
  }
  for (int i = 0; i < SIDE * SIDE; i++) { /* a narrow bundle that looks down across the boxes */
    const float x = 0.02f * (float)(i % SIDE) - 0.07f, y = -0.5f - 0.02f * (float)(i / SIDE);
    const pktrt_ray ray = {{0.3f, 4, 6}, 0, {x, y, -1}, INFINITY, 0};
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
  sum_up(&stats.by_type[PKTRT_RAY_PRIMARY], w.children);
  pktrt_scene_destroy(scene);
  return 0;
}
