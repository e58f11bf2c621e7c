/* Checks exercise 13: the hull never drops a box that a ray of its packet enters, and drops nearly all boxes that the
   library's frustum drops. As a control the hull is made of half of the rays, and must then be caught. */
#define PKTRT_COUNT_FAST
#define PKTRT_IMPLEMENTATION
#include "course.h"
#include "13_exercise.h"
#include "13_rays.h"

/* The library's planes, to say which of them is missed: the solution, under other names. */
#define hull check_hull
#define hull_make check_hull_make
#define hull_misses check_hull_misses
typedef struct hull hull;
hull *hull_make(const hull_packet *packet);
bool hull_misses(const hull *h, const float lo[3], const float hi[3]);
#include "13_solution.c"
#undef hull
#undef hull_make
#undef hull_misses

enum { RAYS = 8, BOXES = 50, PACKETS = 20000, MOST = 64 };

static uint32_t state = 13;
static float between(float a, float b) { return a + (b - a) * course_random(&state); }

#define SHARE 0.95 /* of the boxes that the library drops, at least this part is to be dropped */

/* Verdicts on boxes. */
typedef struct count {
  uint64_t asked;
  uint64_t missed;            /* no ray enters */
  uint64_t dropped, expected; /* of these, by the answer, and by the library's planes */
  uint64_t wrong, caught;     /* dropped though a ray enters, by the answer, and by the control */
  bool kept;                  /* a box is kept that the library's planes drop; the first one is: */
  uint32_t number;
  hull_packet packet;
  course_ray rays[MOST];
  course_box box;
} count;

/* >>words ---------------------------------------------------------------------------------------------------------- */

static void say_ray(const char *what, uint32_t number, const course_ray *ray) {
  const float *o = ray->origin.at, *d = ray->direction.at;
  printf("  %s %u from (%.9g, %.9g, %.9g) along (%.9g, %.9g, %.9g), t from %.9g to %.9g\n", what, (unsigned)number,
      (double)o[0], (double)o[1], (double)o[2], (double)d[0], (double)d[1], (double)d[2], (double)ray->tmin,
      (double)ray->tmax);
}

static void say_box(const hull_packet *packet, const float lo[3], const float hi[3]) {
  printf("  box (%.9g, %.9g, %.9g) to (%.9g, %.9g, %.9g); main axis %d, sign %g, pad %.3g\n", (double)lo[0],
      (double)lo[1], (double)lo[2], (double)hi[0], (double)hi[1], (double)hi[2], packet->axis, (double)packet->sign,
      (double)packet->pad);
}

/* >>answers -------------------------------------------------------------------------------------------------------- */

/* Returns true if a ray enters a box, computed in double, where the rounding of floats does not matter. */
static bool enters(const course_ray *ray, const float lo[3], const float hi[3]) {
  double first = (double)ray->tmin, last = (double)ray->tmax;
  for (int a = 0; a < 3; a++) {
    const double o = (double)ray->origin.at[a], d = (double)ray->direction.at[a];
    const double l = (double)lo[a] - o, h = (double)hi[a] - o;
    if (d == 0 && (l > 0 || h < 0)) return false;
    if (d == 0) continue;
    first = fmax(first, fmin(l / d, h / d));
    last = fmin(last, fmax(l / d, h / d));
  }
  return first <= last;
}

/* Makes the hull of a packet from a copy of the rays, which is spoilt afterwards, and stays, for whoever reads it. */
static hull *make_hull(hull_packet packet) {
  course_ray *rays = (course_ray *)course_memory(packet.n, sizeof *rays);
  memcpy(rays, packet.rays, packet.n * sizeof *rays);
  packet.rays = rays;
  hull *made = hull_make(&packet);
  memset(rays, 0xFF, packet.n * sizeof *rays);
  if (!made) {
    printf("chapter 13: failed: hull_make() returns NULL\n");
    exit(1);
  }
  return made;
}

/* Compares the verdict on one box with all rays and with the library's planes. Says which ray is lost first; returns true
   if no ray enters the box. */
static bool judge(count *c, const char *kind, uint32_t number, const hull_packet *packet, bool drop, bool expected,
    const float lo[3], const float hi[3]) {
  uint32_t ray = 0;
  while (ray < packet->n && !enters(&packet->rays[ray], lo, hi)) ray++;
  const bool missed = ray == packet->n;

  c->asked++;
  c->missed += missed;
  c->dropped += missed && drop;
  c->expected += missed && expected;

  if (!missed && drop && !c->wrong++) {
    printf("%s packet %u: of its %u rays, ray %u enters a box\n", kind, (unsigned)number, (unsigned)packet->n,
        (unsigned)ray);
    say_ray("ray", ray, &packet->rays[ray]);
    say_box(packet, lo, hi);
    printf("  expected: the box is kept\n  got: the box is dropped\n");
  }

  if (missed && expected && !drop && !c->kept) {
    c->kept = true;
    c->number = number;
    c->packet = *packet;
    memcpy(c->rays, packet->rays, packet->n * sizeof *packet->rays);
    c->packet.rays = c->rays;
    memcpy(c->box.lo.at, lo, sizeof c->box.lo);
    memcpy(c->box.hi.at, hi, sizeof c->box.hi);
  }
  return missed;
}

/* Says which box is the first that is kept without need. */
static void say_kept(const count *c, const char *kind) {
  const uint32_t n = c->packet.n;
  printf("%s packet %u: none of its %u rays enters a box\n", kind, (unsigned)c->number, (unsigned)n);
  for (uint32_t i = 0; i < n; i += n < 3 ? 1 : (n - 1) / 2) say_ray("ray", i, &c->rays[i]);
  say_box(&c->packet, c->box.lo.at, c->box.hi.at);
  printf("  expected: the box is dropped, as by the library\n  got: the box is kept\n");
}

/* >>random packets ------------------------------------------------------------------------------------------------- */

/* Makes rays of one main axis: by bits of `kind`, from one point or not, near each other or not, far apart along the
   axis, to one point, of a few lengths. */
static void make_packet(hull_packet *packet, course_ray *rays, uint32_t kind) {
  const float apart = kind & 1 ? 0 : kind & 2 ? 0.3f : 4, spread = kind & 4 ? 0.05f : 0.5f, aim = kind & 64 ? 0 : 0.4f;
  const bool meet = (kind & 24) == 24;
  vec from, target, along;
  packet->rays = rays;
  packet->n = 1 + kind % RAYS;
  packet->axis = (int)(kind / 128 % 3);
  packet->sign = kind & 32 ? -1.0f : 1.0f;

  for (int a = 0; a < 3; a++) {
    const float range = a == packet->axis ? 1 : aim;
    along.at[a] = a == packet->axis ? packet->sign : between(-range, range);
    from.at[a] = between(-9, 9) - (a == packet->axis ? packet->sign * 3 : 0);
    target.at[a] = from.at[a] + between(5, 12) * along.at[a];
  }

  for (uint32_t r = 0; r < packet->n; r++) {
    course_ray *ray = &rays[r];
    const float length = kind % 5 ? between(0.2f, 3) : 1;
    for (int a = 0; a < 3; a++) {
      ray->origin.at[a] = from.at[a] + between(-apart, apart) / 2;
      ray->direction.at[a] = length * (along.at[a] + (a == packet->axis ? 0 : between(-spread, spread)));
      if (meet) ray->direction.at[a] = target.at[a] - ray->origin.at[a];
    }
    ray->tmin = kind % 7 == 0 ? between(0, 2) : 0;
    ray->tmax = meet ? 1 : kind % 3 ? INFINITY : ray->tmin + between(0.5f, 9);
  }
}

/* Returns true if all rays have the main axis and sign of the packet. */
static bool is_packet(const hull_packet *packet) {
  for (uint32_t r = 0; r < packet->n; r++) {
    const float *d = packet->rays[r].direction.at;
    for (int a = 0; a < 3; a++)
      if (a != packet->axis && !(fabsf(d[a]) < packet->sign * d[packet->axis])) return false;
  }
  return true;
}

/* Makes a box in the scene: anywhere, or around a point of a ray, often so that the point is in a corner, an edge or a
   face. Returns false if the point is outside of the scene. */
static bool make_box(const hull_packet *packet, uint32_t kind, float lo[3], float hi[3]) {
  const course_ray *ray = &packet->rays[kind / 2 % packet->n];
  const float reach = 24 / fabsf(ray->direction.at[packet->axis]), size = kind % 3 ? between(0, 2) : 0;
  const float t = kind & 32 ? ray->tmin : between(ray->tmin, fminf(ray->tmax, reach));

  for (int a = 0; a < 3; a++) {
    const float p = kind & 1 ? ray->origin.at[a] + t * ray->direction.at[a] : between(-8, 8);
    const uint32_t side = (uint32_t)between(0, 4);
    if (!(p >= -8 && p <= 8)) return false;
    lo[a] = fmaxf(side & 1 ? p : p - between(0, size), -8);
    hi[a] = fminf(side & 2 ? p : p + between(0, size), 8);
  }
  return true;
}

/* Asks about random boxes around random packets. */
static void check_random(count *c) {
  pktrt_node world;
  memset(&world, 0, sizeof world);
  for (int k = 1; k < 8; k++) world.child[k] = PKTRT_NONE;
  for (int a = 0; a < 3; a++) {
    world.lo[0][a] = -8;
    world.hi[0][a] = 8;
  }

  for (uint32_t i = 0; i < PACKETS; i++) {
    course_ray rays[RAYS];
    hull_packet packet = {rays, 0, 0, 1, {{{-8, -8, -8}}, {{8, 8, 8}}}, 0};
    do make_packet(&packet, rays, i);
    while (!is_packet(&packet));
    for (uint32_t r = 0; r < packet.n; r++) packet.pad = fmaxf(packet.pad, course_slabs_make(&world, rays[r]).pad);

    hull_packet half = packet;
    half.n = (packet.n + 1) / 2;
    hull *made = make_hull(packet), *narrow = make_hull(half);
    check_hull *theirs = check_hull_make(&packet);

    for (uint32_t j = 0; j < BOXES; j++) {
      float lo[3], hi[3];
      if (!make_box(&packet, j, lo, hi)) continue;
      const bool drop = hull_misses(made, lo, hi), expected = check_hull_misses(theirs, lo, hi);
      const bool missed = judge(c, "random", i, &packet, drop, expected, lo, hi);
      c->caught += !missed && hull_misses(narrow, lo, hi);
    }
    free(made);
    free(narrow);
    free(theirs);
  }
}

/* >>packets of the scene ------------------------------------------------------------------------------------------- */

enum {
  KINDS = 3,
  TILES = RAYS_PIXELS / MOST,
  LEAST = 40, /* rays of a packet that is asked */
  FEW = 32    /* as few rays of a frustum go on as a stream in the library: 8 times 4, for any hit and many origins */
};
static const int kind_of[KINDS] = {RAYS_SHADOW, RAYS_REFLECTED, RAYS_LENS};

/* Cuts a ray so that it hits nothing. Returns false if nothing is left: a shadow ray must reach the lamp. */
static bool cut(const pktrt_scene *library, int kind, course_ray *ray) {
  const course_hit hit = course_library_hit(library, *ray);
  if (hit.triangle == COURSE_NONE) return true;
  ray->tmax = 0.999f * hit.t;
  return kind != RAYS_SHADOW;
}

/* Makes the packet of a tile. Returns false if it has too few rays, or rays of several octants or main axes. */
static bool make_tile(hull_packet *packet, course_ray *rays, const course_scene *scene, const pktrt_scene *library,
    const pktrt_node *nodes, int kind, uint32_t tile) {
  packet->rays = rays;
  packet->n = 0;
  packet->pad = 0;
  for (uint32_t i = 0; i < MOST; i++) {
    course_ray *ray = &rays[packet->n];
    packet->n += rays_aim(ray, tile * MOST + i, kind, scene, library) && cut(library, kind, ray);
  }
  if (packet->n < LEAST) return false;

  const float *d = rays[0].direction.at;
  packet->axis = fabsf(d[1]) > fabsf(d[0]) ? 1 : 0;
  if (fabsf(d[2]) > fabsf(d[packet->axis])) packet->axis = 2;
  packet->sign = d[packet->axis] < 0 ? -1.0f : 1.0f;
  for (uint32_t i = 0; i < packet->n; i++) {
    const course_slabs slabs = course_slabs_make(nodes, rays[i]);
    if (slabs.octant != course_slabs_make(nodes, rays[0]).octant) return false;
    packet->pad = fmaxf(packet->pad, slabs.pad);
  }
  return is_packet(packet);
}

/* Returns how many children the library's frustum drops, and 0 if it makes no single frustum. */
static uint64_t library_culls(const pktrt_scene *library, const hull_packet *packet) {
  static pktrt_stats stats;
  pktrt_query_desc query;
  pktrt_ray rays[MOST];
  bool occluded[MOST];
  memset(&query, 0, sizeof query);
  memset(&stats, 0, sizeof stats);
  query.stats = &stats;
  for (uint32_t i = 0; i < packet->n; i++) rays[i] = course_library_ray(packet->rays[i]);
  pktrt_occluded_ex(library, &query, rays, occluded, packet->n);
  return stats.by_type[PKTRT_RAY_PRIMARY].packets == 1 ? stats.by_type[PKTRT_RAY_PRIMARY].frustum_culls : 0;
}

/* A packet on its way through the tree. */
typedef struct walk {
  count *counts;
  const pktrt_node *nodes;
  int kind;
  uint32_t tile;
  const hull_packet *packet;
  const hull *mine;
  const check_hull *theirs;
  course_slabs slabs[MOST];
} walk;

/* Asks about the children of a node that the rays of the mask enter, and opens those that more than FEW rays enter. */
static void open_node(const walk *w, uint32_t index, uint64_t mask) {
  const pktrt_node *node = &w->nodes[index];
  for (int k = 0; k < 8; k++) {
    uint64_t enter = 0;
    uint32_t many = 0;
    if (node->child[k] == PKTRT_NONE) continue;
    judge(w->counts, rays_name[w->kind], w->tile, w->packet, hull_misses(w->mine, node->lo[k], node->hi[k]),
        check_hull_misses(w->theirs, node->lo[k], node->hi[k]), node->lo[k], node->hi[k]);

    for (uint32_t i = 0; i < w->packet->n; i++) {
      if (!(mask >> i & 1) || !course_slabs_enter(&w->slabs[i], node->lo[k], node->hi[k], NULL)) continue;
      enter |= (uint64_t)1 << i;
      many++;
    }
    if (many > FEW && !node->leaf[k]) open_node(w, node->child[k], enter);
  }
}

/* Asks about the boxes that packets of one kind meet in the scene; returns how many of them the library drops. */
static uint64_t check_scene(
    count *c, const course_scene *scene, const pktrt_scene *library, const pktrt_node *nodes, int kind) {
  uint64_t culls = 0, packets = 0;
  course_box around = course_box_empty();
  for (uint32_t i = 0; i < scene->vertices; i++)
    around = course_box_grow(around, scene->position[i], scene->position[i]);

  for (uint32_t tile = 0; tile < TILES; tile++) {
    course_ray rays[MOST];
    hull_packet packet = {rays, 0, 0, 1, around, 0};
    if (!make_tile(&packet, rays, scene, library, nodes, kind, tile)) continue;
    const uint64_t library_drops = library_culls(library, &packet);
    hull *mine = make_hull(packet);
    check_hull *theirs = check_hull_make(&packet);
    walk w = {c, nodes, kind, tile, &packet, mine, theirs, {{{0}, {0}, {0}, 0, 0, 0, 0, 0, 0}}};
    for (uint32_t i = 0; i < packet.n; i++) w.slabs[i] = course_slabs_make(nodes, rays[i]);
    open_node(&w, 0, packet.n < 64 ? ((uint64_t)1 << packet.n) - 1 : ~(uint64_t)0);
    culls += library_drops;
    packets++;
    free(mine);
    free(theirs);
  }

  printf(
      "%s rays: %u packets, %u boxes, %u of them missed by all rays; dropped %u, by the library %u, by its planes %u\n",
      rays_name[kind], (unsigned)packets, (unsigned)c->asked, (unsigned)c->missed, (unsigned)c->dropped,
      (unsigned)culls, (unsigned)c->expected);
  return culls;
}

/* Prints the figure `kind.what`. */
static void kind_figure(const char *kind, const char *what, uint64_t value) {
  char name[64];
  snprintf(name, sizeof name, "%s.%s", kind, what);
  course_figure(name, "%u", (unsigned)value);
}

int main(void) {
  static count random, packets[KINDS];
  static char few[128];
  const course_scene scene = course_scene_make();
  const char *why = NULL;
  uint64_t caught, culls = 0, expected = 0;
  uint32_t nodes_count;

  course_check_begins(13);
  check_random(&random);
  caught = random.caught;
  printf("%u random packets, %u boxes: %u are dropped that a ray enters\n", PACKETS, (unsigned)random.asked,
      (unsigned)random.wrong);
  printf("  of %u that all rays miss %u are dropped, by the library's planes %u\n", (unsigned)random.missed,
      (unsigned)random.dropped, (unsigned)random.expected);
  course_figure("random.packets", "%u", PACKETS);
  course_figure("share.least", "%.0f", 100 * SHARE);
  kind_figure("random", "boxes", random.asked);
  kind_figure("random", "missed", random.missed);
  kind_figure("random", "dropped", random.dropped);
  if (random.wrong) why = "boxes are dropped that a ray enters";
  else if ((double)random.dropped < SHARE * (double)random.expected) {
    say_kept(&random, "random");
    snprintf(few, sizeof few, "random packets: of each 100 boxes that the library's planes drop %.1f are dropped",
        100 * (double)random.dropped / (double)random.expected);
    why = few;
  }

  pktrt_scene *library = course_library(&scene);
  const pktrt_node *nodes = course_library_nodes(library, &nodes_count);
  for (int i = 0; i < KINDS && !why; i++) {
    const int kind = kind_of[i];
    count *c = &packets[i];
    const uint64_t drops = check_scene(c, &scene, library, nodes, kind), most = drops ? drops : c->expected;
    culls += most;
    expected += c->expected;
    caught += c->caught;
    kind_figure(rays_name[kind], "boxes", c->asked);
    kind_figure(rays_name[kind], "missed", c->missed);
    kind_figure(rays_name[kind], "dropped", c->dropped);
    if (c->wrong) why = "boxes of the scene are dropped that a ray enters";
    else if ((double)c->dropped < SHARE * (double)most) {
      if (c->kept) say_kept(c, rays_name[kind]);
      snprintf(few, sizeof few, "%s rays: of each 100 boxes that the library drops %.1f are dropped", rays_name[kind],
          100 * (double)c->dropped / (double)most);
      why = few;
    }
  }
  pktrt_scene_destroy(library);

  printf("control: by hulls of half of the rays %u boxes are dropped that a ray enters\n", (unsigned)caught);
  if (!why && (double)expected < SHARE * (double)culls) why = "the check's planes are no longer those of the library";
  if (!why && !caught) why = "a hull of half of the rays loses no ray: does it use the rays?";
  return course_result(13, why);
}
