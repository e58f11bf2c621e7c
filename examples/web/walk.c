/* walk.c - what the page's second tab shows: a packet's walk through a tree, event by event, and figure 3 of the paper.

   Built with the page's other files into one WebAssembly module, or by walk_events.c into a program. Each export returns
   32-bit words that stay until its next call: how many things follow, then these, each of as many words as its struct
   has. walk.js reads them.

   What is culled may differ by a rounding from one instruction set to another. The scenes ask for the scalar kernels if
   the build has them, and WebAssembly's vectors round as these do: so a link to an event leads to that event on every
   machine, and a program here tells what a browser shows. */
#include "../course/course.h"
#include "../course/07_figure3.h"
#include "web.h"

#ifdef __EMSCRIPTEN__
#include <emscripten.h>
#define WALK_EXPORT EMSCRIPTEN_KEEPALIVE
#else
#define WALK_EXPORT
#endif

enum { WALK_WIDTH = 256, WALK_HEIGHT = 192, WALK_SIDE = 16, WALK_RAYS = WALK_SIDE * WALK_SIDE };

typedef struct walk_box {                 /* a child of a node */
  uint32_t node, child, index, triangles; /* triangles: how many, of a leaf; 0: it is a node */
  float lo[3], hi[3];
} walk_box;

typedef struct walk_ray {
  float origin[3], direction[3], tmax;
  float t;       /* where it ends; INFINITY: nowhere. Of a shadow ray: 0 if something is in its way, else 1 */
  uint32_t x, y; /* pixel that the ray of the camera went through, which it is or comes from */
  uint32_t hits; /* whether it hits anything */
} walk_ray;

typedef struct walk_event { /* a pktrt_event, and what had been done when it was told */
  uint32_t kind, index, child, ray, active, tested, tree, packet, depth; /* kind WALK_END: the walk is over */
  uint32_t nodes, boxes, box_vectors, triangles, triangle_vectors;       /* opened; tests, and tests of eight at once */
  uint32_t triangle;                                                     /* of a hit: which one; else PKTRT_NONE */
  float t; /* of a hit: where, to within rounding; else 0 */
} walk_event;
enum { WALK_END = PKTRT_EVENT_LEAF_TEST + 1 };

typedef struct walk_member {  /* a ray of a packet of figure 3 */
  uint32_t packet, type, ray; /* counted from 0 on; type as in pktrt_ray_type; the primary ray that sent it out */
} walk_member;

typedef struct walk_leaf_triangle {
  uint32_t lane;
  float corner[3][3];
} walk_leaf_triangle;

typedef struct walk_point { /* a pixel of the picture to choose from */
  uint32_t shade;           /* how much a surface faces the eye, 1 to 255, or 0 for nothing */
  float t, direction[3];    /* of its ray from the eye */
} walk_point;

/* >>lists ---------------------------------------------------------------------------------------------------------- */

typedef struct walk_list {
  uint32_t *word; /* the first tells how many things follow */
  size_t words, room;
} walk_list;

static void walk_list_clear(walk_list *l) { l->words = 0; }

/* Appends a thing of so many bytes, a multiple of four. */
static void walk_list_add(walk_list *l, const void *thing, size_t bytes) {
  const size_t at = l->words ? l->words : 1, words = bytes / 4;
  if (at + words > l->room) {
    uint32_t *more = (uint32_t *)realloc(l->word, (l->room = 2 * l->room + words + 256) * sizeof *more);
    if (!more) {
      ex_fail("out of memory");
      exit(1);
    }
    l->word = more;
  }
  if (bytes) memcpy(l->word + at, thing, bytes);
  l->word[0] = l->words ? l->word[0] + (bytes > 0) : bytes > 0;
  l->words = at + words;
}

/* >>scenes --------------------------------------------------------------------------------------------------------- */

typedef struct walk_lane {
  uint32_t mesh, triangle;
} walk_lane;

/* A scene to walk in. Nodes and leaves are numbered through all of its trees, one tree after the other. */
typedef struct walk_world {
  course_scene scene; /* of the one that web.c holds: empty */
  const pktrt_scene *library;
  uint32_t width, height;            /* of the picture, pixels */
  uint32_t trees, nodes;             /* how many */
  uint32_t *first_node, *first_leaf; /* of each tree */
  walk_lane (*lane)[8];              /* triangles of each leaf */
} walk_world;

enum { WALK_SHOWN = 2 }; /* the number of the scene that web.c holds */

/* Makes the boxes of examples/packets.c: 6 x 6 of them on a floor. Corners of a box are numbered by the bits x, y, z. */
static course_scene walk_boxes_make(void) {
  enum { EDGE = 6, BOXES = EDGE * EDGE };
  static const uint32_t box[12][3] = {{0, 1, 5}, {0, 5, 4}, {2, 7, 3}, {2, 6, 7}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7},
      {1, 7, 5}, {0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}};
  static const uint32_t ground[2][3] = {{0, 1, 2}, {0, 2, 3}};
  course_scene s = course_scene_empty();
  for (uint32_t i = 0; i < BOXES; i++) {
    const float x = (float)(i % EDGE) - EDGE / 2, z = (float)(i / EDGE) - EDGE / 2;
    for (uint32_t k = 0; k < 36; k++) s.corner[s.triangles + k / 3][k % 3] = s.vertices + box[k / 3][k % 3];
    for (int c = 0; c < 8; c++)
      s.position[s.vertices++] = vec_make(x + 0.2f + (c & 1 ? 0.6f : 0.0f), //
          c & 2 ? 0.3f + 0.25f * (float)(i * 7 % 5) : 0.0f, z + 0.2f + (c & 4 ? 0.6f : 0.0f));
    s.triangles += 12;
  }
  for (uint32_t k = 0; k < 6; k++) s.corner[s.triangles + k / 3][k % 3] = s.vertices + ground[k / 3][k % 3];
  for (int c = 0; c < 4; c++)
    s.position[s.vertices++] = vec_make(c < 2 ? -4.0f : 4.0f, 0, c == 0 || c == 3 ? -4.0f : 4.0f);
  s.triangles += 2;
  return s;
}

/* Numbers the nodes and leaves of a world's library. Returns false if memory is lacking. */
static bool walk_number(walk_world *w) {
  pktrt_tree tree;
  pktrt_node node;
  uint32_t leaves = 0;
  w->trees = w->nodes = 0;
  while (pktrt_get_tree(w->library, w->trees, &tree)) w->trees++;
  free(w->first_node), free(w->first_leaf), free(w->lane);
  w->first_node = (uint32_t *)calloc(w->trees + 1, sizeof *w->first_node);
  w->first_leaf = (uint32_t *)calloc(w->trees + 1, sizeof *w->first_leaf);
  w->lane = NULL;
  if (!w->first_node || !w->first_leaf) return false;

  for (uint32_t t = 0; pktrt_get_tree(w->library, t, &tree); t++) {
    w->first_node[t] = w->nodes;
    w->first_leaf[t] = leaves;
    w->nodes += tree.nodes;
    leaves += tree.leaves;
  }
  w->lane = (walk_lane(*)[8])calloc(leaves + 1, sizeof *w->lane);
  if (!w->lane) return false;

  for (uint32_t t = 0; t < w->trees; t++)
    for (uint32_t i = 0; pktrt_get_node(w->library, t, i, 0, &node); i++)
      for (int k = 0; k < 8; k++)
        for (int lane = 0; node.child[k] != PKTRT_NONE && node.leaf[k] && lane < 8; lane++) {
          walk_lane *l = &w->lane[w->first_leaf[t] + node.child[k]][lane];
          l->mesh = node.mesh[k][lane];
          l->triangle = node.triangle[k][lane];
        }
  return true;
}

static walk_world walk_shown;

/* Takes the scene that web.c holds as it stands, for a picture of so many pixels. Returns 0 unless memory is lacking. To be
   called again whenever that scene has changed. */
WALK_EXPORT int walk_show(uint32_t width, uint32_t height) {
  walk_shown.library = web_scene();
  walk_shown.width = width;
  walk_shown.height = height;
  if (walk_shown.library && walk_number(&walk_shown)) return 0;
  walk_shown.library = NULL;
  return 1;
}

/* Returns a scene, 0: the course's, 1: boxes, which are made when they are first asked for; WALK_SHOWN: see walk_show. */
static walk_world *walk_world_of(uint32_t scene) {
  static walk_world made[2];
  if (scene == WALK_SHOWN && walk_shown.library) return &walk_shown;
  walk_world *w = &made[scene == 1];
  pktrt_scene_desc desc;
  pktrt_mesh_desc mesh;
  if (w->library) return w;
  w->scene = scene == 1 ? walk_boxes_make() : course_scene_make();
  w->width = WALK_WIDTH;
  w->height = WALK_HEIGHT;
  memset(&desc, 0, sizeof desc), memset(&mesh, 0, sizeof mesh);
  if (pktrt_isa_available(PKTRT_ISA_SCALAR)) desc.isa = PKTRT_ISA_SCALAR;
  mesh.positions = w->scene.position[0].at, mesh.vertex_count = w->scene.vertices;
  mesh.indices = w->scene.corner[0], mesh.triangle_count = w->scene.triangles;
  pktrt_scene *const library = pktrt_scene_create(&desc);
  if (!library || pktrt_add_mesh(library, &mesh, NULL) || pktrt_commit(library)) {
    ex_fail("%s", pktrt_last_error(library));
    exit(1);
  }
  w->library = library;
  if (!walk_number(w)) {
    ex_fail("out of memory");
    exit(1);
  }
  return w;
}

/* Tells where the corners of a triangle are, to within rounding. */
static void walk_corners(const walk_world *w, walk_lane of, float corner[3][3]) {
  static const float up[3] = {0, 1, 0};
  for (int c = 0; c < 3; c++)
    if (w == &walk_shown) { /* a ray that starts at the corner knows */
      pktrt_ray ray;
      pktrt_spawn_at(w->library, of.mesh, of.triangle, c == 1, c == 2, 0, up, &ray);
      memcpy(corner[c], ray.origin, sizeof corner[c]);
    } else memcpy(corner[c], w->scene.position[w->scene.corner[of.triangle][c]].at, sizeof corner[c]);
}

/* Returns the ray through a place of a scene's picture, in pixels from its upper left corner. */
static pktrt_ray walk_camera_ray(uint32_t scene, float x, float y) {
  if (walk_world_of(scene) == &walk_shown) {
    pktrt_ray ray;
    pktrt_camera_ray(&web_view()->camera, walk_shown.width, walk_shown.height, (double)x, (double)y, NULL, 0, &ray);
    return ray;
  }
  if (scene == 0) return course_library_ray(course_camera_ray(x, y, WALK_WIDTH, WALK_HEIGHT));
  const course_ray ray = {
      {{0.3f, 4, 6}}, {{(x - WALK_WIDTH / 2) * 0.005f, (WALK_HEIGHT / 2 - y) * 0.005f - 0.65f, -1}}, 0, INFINITY};
  return course_library_ray(ray);
}

/* Gives all children of all nodes: walk_box. */
WALK_EXPORT const uint32_t *walk_boxes(uint32_t scene) {
  static walk_list list;
  const walk_world *w = walk_world_of(scene);
  pktrt_node n;
  walk_list_clear(&list), walk_list_add(&list, NULL, 0);
  for (uint32_t t = 0; t < w->trees; t++)
    for (uint32_t i = 0; pktrt_get_node(w->library, t, i, 0, &n); i++)
      for (uint32_t k = 0; k < 8; k++) {
        if (n.child[k] == PKTRT_NONE) continue;
        walk_box b = {w->first_node[t] + i, k, n.child[k] + (n.leaf[k] ? w->first_leaf : w->first_node)[t], 0,
            {0, 0, 0}, {0, 0, 0}};
        for (int lane = 0; n.leaf[k] && lane < 8; lane++) b.triangles += n.triangle[k][lane] != PKTRT_NONE;
        memcpy(b.lo, n.lo[k], sizeof b.lo), memcpy(b.hi, n.hi[k], sizeof b.hi);
        walk_list_add(&list, &b, sizeof b);
      }
  return list.word;
}

/* Gives the triangles of a leaf: walk_leaf_triangle. */
WALK_EXPORT const uint32_t *walk_leaf(uint32_t scene, uint32_t leaf) {
  static walk_list list;
  const walk_world *w = walk_world_of(scene);
  walk_list_clear(&list), walk_list_add(&list, NULL, 0);
  for (uint32_t lane = 0; lane < 8; lane++) {
    walk_leaf_triangle t = {lane, {{0}}};
    if (w->lane[leaf][lane].triangle == PKTRT_NONE) continue;
    walk_corners(w, w->lane[leaf][lane], t.corner);
    walk_list_add(&list, &t, sizeof t);
  }
  return list.word;
}

/* Gives all triangles of a scene that is not WALK_SHOWN: nine floats each, corner by corner. */
WALK_EXPORT const uint32_t *walk_triangles(uint32_t scene) {
  static walk_list list;
  const course_scene *s = &walk_world_of(scene)->scene;
  walk_list_clear(&list);
  for (uint32_t i = 0; i < s->triangles; i++) {
    vec corner[3];
    for (int c = 0; c < 3; c++) corner[c] = s->position[s->corner[i][c]];
    walk_list_add(&list, corner, sizeof corner);
  }
  return list.word;
}

/* Gives a picture of every `step`th pixel of a scene's picture, row by row: walk_point. */
WALK_EXPORT const uint32_t *walk_picture(uint32_t scene, uint32_t step) {
  static walk_list list;
  const walk_world *w = walk_world_of(scene);
  const float half = (float)step / 2;
  walk_list_clear(&list), walk_list_add(&list, NULL, 0);
  for (uint32_t y = 0; y + step <= w->height; y += step)
    for (uint32_t x = 0; x + step <= w->width; x += step) {
      const pktrt_ray ray = walk_camera_ray(scene, (float)x + half, (float)y + half);
      walk_point p = {0, INFINITY, {ray.direction[0], ray.direction[1], ray.direction[2]}};
      pktrt_hit hit;
      if (pktrt_intersect(w->library, &ray, &hit)) {
        const vec n = vec_make(hit.normal[0], hit.normal[1], hit.normal[2]);
        const vec d = vec_make(ray.direction[0], ray.direction[1], ray.direction[2]);
        p.shade = 1 + (uint32_t)(254 * fminf(fabsf(vec_dot(vec_unit(n), vec_unit(d))), 1));
        p.t = hit.t;
      }
      walk_list_add(&list, &p, sizeof p);
    }
  return list.word;
}

/* >>packet --------------------------------------------------------------------------------------------------------- */

static struct {
  const walk_world *w;
  bool shadow;
  uint32_t n;
  pktrt_ray ray[WALK_RAYS];
  walk_list events;
  pktrt_stats stats;
} walk;

static uint32_t walk_within(uint32_t x, uint32_t lo, uint32_t hi) { return x < lo ? lo : x > hi ? hi : x; }

/* Makes of a ray of the camera the shadow ray of what it hits, or its reflection; false: there is none. */
static bool walk_send_out(pktrt_ray *ray) {
  float light[3] = {-3, 7, 5};
  if (walk.w == &walk_shown) web_light(light);
  pktrt_hit hit;
  pktrt_surface_info at;
  float to[3], along = 0;
  if (!pktrt_intersect(walk.w->library, ray, &hit)) return false;
  pktrt_surface(walk.w->library, ray, &hit, &at);
  for (int a = 0; a < 3; a++) along += ray->direction[a] * at.normal[a];
  for (int a = 0; a < 3; a++)
    to[a] = walk.shadow ? light[a] - at.position[a] : ray->direction[a] - 2 * along * at.normal[a];
  pktrt_spawn(walk.w->library, ray, &hit, to, ray);
  if (walk.shadow) ray->tmax = 1;
  return true;
}

/* Makes the packet to be traced and gives its rays: walk_ray. Those of a camera go through side x side places, spacing
   pixels apart, of which the first is around (x, y), row by row or in Morton's order; the others (kind 1: shadow rays,
   2: reflections) start where these end. */
WALK_EXPORT const uint32_t *walk_packet(
    uint32_t scene, uint32_t kind, uint32_t side, uint32_t x, uint32_t y, uint32_t spacing, uint32_t morton) {
  static walk_list list;
  walk.w = walk_world_of(scene), walk.shadow = kind == 1, walk.n = 0;
  side = walk_within(side, 1, WALK_SIDE), spacing = walk_within(spacing, 1, WALK_HEIGHT / WALK_SIDE);
  x = walk_within(x, 0, walk.w->width - side * spacing), y = walk_within(y, 0, walk.w->height - side * spacing);
  walk_list_clear(&list), walk_list_add(&list, NULL, 0);
  for (uint32_t i = 0; i < WALK_RAYS;
       i++) { /* in Morton's order all of the largest packet, but for what lies outside */
    uint32_t column = i % side, row = i / side;
    if (morton) {
      column = row = 0;
      for (uint32_t k = 0; k < 4; k++) column |= (i >> 2 * k & 1) << k, row |= (i >> (2 * k + 1) & 1) << k;
    }
    if (column >= side || row >= side) continue;
    walk_ray r;
    pktrt_hit hit;
    memset(&r, 0, sizeof r);
    r.x = x + column * spacing + spacing / 2, r.y = y + row * spacing + spacing / 2;
    const float half = spacing % 2 ? 0.5f : 0.0f;
    pktrt_ray ray = walk_camera_ray(scene, (float)r.x + half, (float)r.y + half);
    if (kind && !walk_send_out(&ray)) continue;
    r.hits = pktrt_intersect(walk.w->library, &ray, &hit), r.t = hit.t, r.tmax = ray.tmax;
    memcpy(r.origin, ray.origin, sizeof r.origin), memcpy(r.direction, ray.direction, sizeof r.direction);
    walk_list_add(&list, &r, sizeof r);
    walk.ray[walk.n++] = ray;
  }
  return list.word;
}

/* >>trace ---------------------------------------------------------------------------------------------------------- */

/* Returns where a ray meets the plane of a triangle, in double. */
static double walk_depth(const pktrt_ray *ray, float corner[3][3]) {
  double p[3][3], e[3], f[3], det = 0, depth = 0;
  for (int c = 0; c < 3; c++)
    for (int k = 0; k < 3; k++) p[c][k] = (double)corner[c][k] - (double)ray->origin[k];
  for (int k = 0; k < 3; k++) e[k] = p[1][k] - p[0][k], f[k] = p[2][k] - p[0][k];
  for (int k = 0; k < 3; k++) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    const double n = e[i] * f[j] - e[j] * f[i];
    det += n * (double)ray->direction[k];
    depth += n * p[0][k];
  }
  return depth / det;
}

/* Notes an event, with what had been done by then. */
static void walk_note(void *user, const pktrt_event *e) {
  const pktrt_counts *c = &walk.stats.by_type[PKTRT_RAY_PRIMARY];
  const bool of_leaf = e->kind == PKTRT_EVENT_LEAF || e->kind == PKTRT_EVENT_HIT || e->kind == PKTRT_EVENT_LEAF_TEST;
  const uint32_t index = e->index + (of_leaf ? walk.w->first_leaf : walk.w->first_node)[e->tree];
  walk_event w = {(uint32_t)e->kind, index, e->child, e->ray, e->active, e->tested, e->tree, e->packet, e->depth, //
      (uint32_t)c->node_visits, (uint32_t)c->box_tests, (uint32_t)c->vector_box_tests, (uint32_t)c->triangle_tests,
      (uint32_t)c->vector_triangle_tests, PKTRT_NONE, 0};
  (void)user;
  if (e->kind == PKTRT_EVENT_HIT) {
    const walk_lane hit = walk.w->lane[index][e->child];
    float corner[3][3];
    walk_corners(walk.w, hit, corner);
    w.triangle = hit.triangle;
    w.t = (float)walk_depth(&walk.ray[e->ray], corner);
  }
  walk_list_add(&walk.events, &w, sizeof w);
}

/* Traces the packet on the paper's path, of which `steps` are taken (see pktrt_paper_step), and gives its events, with
   one more at the end: walk_event. Shadow rays are content with any hit. */
WALK_EXPORT const uint32_t *walk_trace(uint32_t steps) {
  static pktrt_hit hit[WALK_RAYS];
  static bool occluded[WALK_RAYS];
  pktrt_query_desc query;
  pktrt_event end;
  if (!walk.w) walk_packet(0, 0, 8, 0, 0, 1, 0);
  memset(&query, 0, sizeof query), memset(&end, 0, sizeof end), memset(&walk.stats, 0, sizeof walk.stats);
  query.path = PKTRT_PATH_PAPER, query.packet_size = walk.n, query.paper_steps = steps;
  query.stats = &walk.stats, query.trace = walk_note;
  walk_list_clear(&walk.events);
  if (walk.shadow) pktrt_occluded_ex(walk.w->library, &query, walk.ray, occluded, walk.n);
  else pktrt_intersect_ex(walk.w->library, &query, walk.ray, hit, walk.n);
  walk_note(NULL, (end.kind = (pktrt_event_kind)WALK_END, &end));
  return walk.events.word;
}

/* >>figure 3 ------------------------------------------------------------------------------------------------------- */

/* Assembles what sixteen rays send out (see pktrt_assembly) and gives the rays of all packets: walk_member. What ray i
   meets are the three bits from 3 i on of the first word, from ray 8 on of the second: 0 diffuse, 1 the floor, 2 metal,
   3 glass, else nothing. */
WALK_EXPORT const uint32_t *walk_figure(uint32_t assembly, uint32_t met, uint32_t met_from_8) {
  static uint32_t place[FIGURE_RAYS];
  static walk_list list;
  static figure_log log;
  static bool known;
  char letters[FIGURE_RAYS + 1] = "";
  if (!known) figure_places(place), known = true;
  for (uint32_t i = 0; i < FIGURE_RAYS; i++) letters[i] = "dfmg...."[(i < 8 ? met : met_from_8) >> 3 * (i % 8) & 7];
  figure_trace(letters, place, (pktrt_assembly)walk_within(assembly, 0, PKTRT_ASSEMBLY_NONE), &log);
  walk_list_clear(&list), walk_list_add(&list, NULL, 0);
  for (uint32_t i = 0; i < log.count; i++)
    for (uint32_t k = 0; k < log.packet[i].n; k++) {
      const walk_member m = {i, (uint32_t)log.packet[i].type, log.packet[i].ray[k]};
      walk_list_add(&list, &m, sizeof m);
    }
  return list.word;
}
