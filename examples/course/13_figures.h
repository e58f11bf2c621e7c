/* 13_figures.h - the drawings of 13_fast.c: a hull and the boxes that it drops, and the rays of a packet by nodes. */
#ifndef COURSE_13_FIGURES_H
#define COURSE_13_FIGURES_H

#include "13_fast.h"
#include "13_rays.h"
#include "../svg.h"
#include "05_solution.c"

/* Prints the figure `row.what`. */
EX_UNUSED static void fast_figure(const char *row, const char *what, const char *format, double value) {
  char name[64];
  snprintf(name, sizeof name, "%.40s.%.20s", row, what);
  course_figure(name, format, value);
}

/* >>verdicts ------------------------------------------------------------------------------------------------------- */

/* Children that frusta ask about, by what drops them: bit 0: the planes; bit 1: the intervals of chapter 5. */
typedef struct verdicts {
  uint64_t frusta;
  uint64_t missed[4]; /* no ray enters */
  uint64_t entered;
  /* What is to be drawn, or NULL. */
  svg *drawing;
  int side, group;
  double x, y, unit;
} verdicts;

static const verdicts verdicts_none = {0, {0, 0, 0, 0}, 0, NULL, 0, 0, 0, 0, 0};

static const char *const verdict_fill[5] = {"#e804", "#29d4", "#d334", "#98c3", "#3a32"};
static const char *const verdict_line[5] = {"#e80", "#07b", "#d33", "#98c", "#3a3"};

/* Returns the verdict on a child, as in verdicts; 4: a ray enters. */
static int verdict_of(
    const fast_rays *f, const fast_packet *p, const pktrt_node *node, uint32_t k, uint64_t mask, bool dropped) {
  for (; mask; mask &= mask - 1)
    if (course_slabs_enter(&f->slabs[p->list[fast_lowest(mask)]], node->lo[k], node->hi[k], NULL)) return 4;
  return (int)dropped + (intervals_miss(&p->bounds, node->lo[k], node->hi[k]) ? 2 : 0);
}

/* Counts a verdict: a function for fast_rays.asked. */
EX_UNUSED static void verdicts_count(void *user, const fast_rays *f, const fast_packet *p, const pktrt_node *node,
    uint32_t k, uint64_t mask, bool dropped) {
  verdicts *v = (verdicts *)user;
  const int verdict = verdict_of(f, p, node, k, mask, dropped);
  if (node == f->nodes && k == 0) v->frusta++;
  if (verdict < 4) v->missed[verdict]++;
  else v->entered++;
}

/* Prints what frusta drop and what intervals would drop, and how many rays began in which walk. */
EX_UNUSED static void verdicts_print(const verdicts *v, const char *kind, const uint8_t *walk, uint32_t n) {
  const double neither = (double)v->missed[0], planes = (double)v->missed[1], intervals = (double)v->missed[2];
  const double both = (double)v->missed[3], all = neither + planes + intervals + both;
  double by[FAST_WALKS] = {0, 0, 0};
  for (uint32_t i = 0; i < n; i++) by[walk[i]]++;
  printf("  of the rays %.1f%% in frusta, %.1f%% in streams, %.1f%% one by one; %u frusta\n",
      100 * by[FAST_FRUSTUM] / n, 100 * by[FAST_STREAM] / n, 100 * by[FAST_SINGLE] / n, (unsigned)v->frusta);
  fast_figure(kind, "rays", "%.0f", n);
  fast_figure(kind, "in.frusta", "%.1f", 100 * by[FAST_FRUSTUM] / n);
  fast_figure(kind, "in.streams", "%.1f", 100 * by[FAST_STREAM] / n);
  fast_figure(kind, "alone", "%.1f", 100 * by[FAST_SINGLE] / n);
  if (all == 0) return;

  printf("  of %.0f children that no ray enters, planes drop %.0f, intervals %.0f; %.0f only planes, %.0f only "
         "intervals\n",
      all, planes + both, intervals + both, planes, intervals);
  fast_figure(kind, "missed", "%.0f", all);
  fast_figure(kind, "planes", "%.0f", planes + both);
  fast_figure(kind, "intervals", "%.0f", intervals + both);
  fast_figure(kind, "planes.only", "%.0f", planes);
  fast_figure(kind, "intervals.only", "%.0f", intervals);
}

/* Colours the pixels of a column of pictures by who traces their rays first: blue, orange, white; black: no ray. */
EX_UNUSED static void choice_draw(
    course_picture *picture, uint32_t left, uint32_t width, const uint32_t *pixel, const uint8_t *walk, uint32_t n) {
  static const vec colour[FAST_WALKS] = {{{1, 1, 1}}, {{0.9f, 0.4f, 0.02f}}, {{0.02f, 0.15f, 0.6f}}};
  for (uint32_t i = 0; i < n; i++)
    picture->pixel[pixel[i] / width * picture->width + left + pixel[i] % width] = colour[walk[i]];
}

/* >>calls ---------------------------------------------------------------------------------------------------------- */

enum { CALLS = 4 };
static const uint32_t calls_rays[CALLS] = {8, 16, 64, 256};

/* Finds who traces the rays of calls with 8, 16, 64 and 256 of the rays. */
EX_UNUSED static void calls_count(uint32_t by[CALLS][FAST_WALKS], const course_scene *scene, const pktrt_node *nodes,
    const course_ray *rays, bool any) {
  for (int call = 0; call < CALLS; call++) {
    fast_rays f = fast_rays_make(scene, nodes, rays, calls_rays[call], any);
    fast_trace(&f, FAST_FRUSTUM);
    for (uint32_t i = 0; i < f.n; i++) by[call][f.walk[i]]++;
    fast_rays_free(&f);
  }
}

/* Prints who traces the rays of these calls: a table of the text. */
EX_UNUSED static void calls_print(uint32_t by[][CALLS][FAST_WALKS], const char *const *name, int kinds) {
  printf("rays of a call that are traced one by one, in streams, in frusta\n%-9s", "");
  for (int call = 0; call < CALLS; call++) printf("      %3u rays", (unsigned)calls_rays[call]);
  printf("\n");
  for (int kind = 0; kind < kinds; kind++) {
    printf("%-9s", name[kind]);
    for (int call = 0; call < CALLS; call++)
      printf("   %3u %3u %3u", (unsigned)by[kind][call][FAST_SINGLE], (unsigned)by[kind][call][FAST_STREAM],
          (unsigned)by[kind][call][FAST_FRUSTUM]);
    printf("\n");
  }
  printf("\n");
}

/* >>drawing of a hull ---------------------------------------------------------------------------------------------- */

/* Where a place on one side of a hull is in the drawing. */
static double hull_x(const verdicts *v, double depth) { return v->x + v->unit * depth; }
static double hull_y(const verdicts *v, double place) { return v->y - v->unit * place; }

/* Draws a child by its verdict if its turn is now: large boxes, which lie below, come first. */
static void verdicts_draw(void *user, const fast_rays *f, const fast_packet *p, const pktrt_node *node, uint32_t k,
    uint64_t mask, bool dropped) {
  const verdicts *v = (const verdicts *)user;
  const hull *h = p->hull;
  const int verdict = verdict_of(f, p, node, k, mask, dropped), axis = h->other[v->side];
  const float *front = h->sign > 0 ? node->lo[k] : node->hi[k], *back = h->sign > 0 ? node->hi[k] : node->lo[k];
  if (verdict != v->group) return;
  svg_box(v->drawing, hull_x(v, (double)(hull_along(h, front) - h->begin)),
      hull_y(v, (double)(node->lo[k][axis] - h->middle[v->side])), hull_x(v, (double)(hull_along(h, back) - h->begin)),
      hull_y(v, (double)(node->hi[k][axis] - h->middle[v->side])), verdict_fill[verdict], verdict_line[verdict]);
}

/* Draws one side of a packet of up to 64 rays: boxes, rays, the four extreme positions and the planes. Prints verdicts as
   figures of `key`, unless that is NULL. */
static void hull_draw_side(verdicts *v, const course_scene *scene, const pktrt_node *nodes, const course_ray *rays,
    uint32_t n, bool any, const char *key) {
  static const int order[5] = {3, 4, 0, 2, 1};
  uint32_t list[FAST_BLOCK];
  const uint64_t all = n < FAST_BLOCK ? ((uint64_t)1 << n) - 1 : ~(uint64_t)0;
  for (uint32_t i = 0; i < FAST_BLOCK; i++) list[i] = i;

  fast_rays f = fast_rays_make(scene, nodes, rays, n, any);
  fast_packet p = fast_packet_make(&f, list, all);
  const hull *h = p.hull;
  const int axis = h->other[v->side];
  f.asked = verdicts_count;
  f.user = v;
  fast_frustum(&f, list, all);
  if (key) {
    fast_figure(key, "drawn.planes.only", "%.0f", (double)v->missed[1]);
    fast_figure(key, "drawn.both", "%.0f", (double)v->missed[3]);
    fast_figure(key, "drawn.neither", "%.0f", (double)v->missed[0]);
  }

  /* The part of the hull that is shown lies in the middle. */
  const double shown = fmin((double)h->far_, 400 / v->unit);
  double middle = 0;
  for (int plane = 0; plane < 2; plane++)
    middle += (double)h->at[v->side][plane] / 2 + (double)h->slope[v->side][plane] * shown / 4;
  v->y = 170 + v->unit * middle;

  fprintf(v->drawing->file, "<g stroke-width=\"0.9\">\n");
  for (int i = 0; i < 5; i++) {
    fast_rays again = fast_rays_make(scene, nodes, rays, n, any);
    v->group = order[i];
    again.asked = verdicts_draw;
    again.user = v;
    fast_frustum(&again, list, all);
    fast_rays_free(&again);
  }
  fprintf(v->drawing->file, "</g>\n");

  for (uint32_t i = 0; i < n; i++) {
    const float *o = rays[i].origin.at, *d = rays[i].direction.at;
    const float exit = (h->far_ + h->begin - hull_along(h, o)) / hull_along(h, d);
    const float t = fminf(any ? rays[i].tmax : f.hit[i].t, exit);
    svg_line(v->drawing, hull_x(v, (double)(hull_along(h, o) - h->begin)),
        hull_y(v, (double)(o[axis] - h->middle[v->side])),
        hull_x(v, (double)(hull_along(h, o) + t * hull_along(h, d) - h->begin)),
        hull_y(v, (double)(o[axis] + t * d[axis] - h->middle[v->side])), "#444", 0.6);
  }

  for (int plane = 0; plane < 2; plane++) {
    const double at = (double)h->at[v->side][plane], end = at + (double)(h->slope[v->side][plane] * h->far_);
    svg_line(v->drawing, hull_x(v, 0), hull_y(v, at), hull_x(v, (double)h->far_), hull_y(v, end), "#00c", 2.5);
    svg_dot(v->drawing, hull_x(v, 0), hull_y(v, at), 4, "#00c");
    svg_dot(v->drawing, hull_x(v, (double)h->far_), hull_y(v, end), 4, "#00c");
  }

  free(p.hull);
  fast_rays_free(&f);
}

/* Draws a packet from both sides, one above the other, in a column of the drawing. Prints verdicts as figures. */
EX_UNUSED static void hull_draw(svg *drawing, double x, const char *name, const char *key, const course_scene *scene,
    const pktrt_node *nodes, const course_ray *rays, uint32_t n, bool any, double unit) {
  for (int side = 0; side < 2; side++) {
    verdicts v = verdicts_none;
    v.drawing = drawing;
    v.side = side;
    v.unit = unit;
    v.x = 50;
    fprintf(drawing->file, "<svg x=\"%g\" y=\"%d\" width=\"470\" height=\"340\">\n", x, 350 * side);
    hull_draw_side(&v, scene, nodes, rays, n, any, side == 0 ? key : NULL);
    svg_box(drawing, 0.5, 0.5, 469.5, 339.5, NULL, "#888");
    svg_text(drawing, 460, 332, 16, SVG_RIGHT, "%s, %s side", name, side ? "second" : "first");
    svg_text(drawing, v.x, 332, 14, SVG_MIDDLE, "W = 0");
    fprintf(drawing->file, "</svg>\n");
  }
}

/* >>drawing of masks ----------------------------------------------------------------------------------------------- */

/* The nodes that a packet opens, as columns, and its rays as rows. */
enum { MASK_CELL = 4, MASK_NODES = 512 };

/* Draws the rays of a mask in a column: a box for each run of neighbours. */
static void masks_draw_column(svg *drawing, double x, double y, double cell, uint64_t rays, const char *colour) {
  for (uint32_t first = 0, end; first < FAST_BLOCK; first = end) {
    end = first + 1;
    if (!(rays >> first & 1)) continue;
    while (end < FAST_BLOCK && rays >> end & 1) end++;
    svg_box(drawing, x, y + MASK_CELL * first, x + cell, y + MASK_CELL * end, colour, NULL);
  }
}

/* Draws a stream of up to 64 rays: for each node that it opens, the rays of the mask. Returns how many nodes; sets how
   many rays enter them. */
EX_UNUSED static uint32_t masks_draw_stream(svg *drawing, double x, double y, double cell, const course_scene *scene,
    const pktrt_node *nodes, const course_ray *rays, uint32_t n, uint64_t *enter) {
  fast_step step[MASK_NODES];
  uint32_t list[FAST_BLOCK];
  fast_rays f = fast_rays_make(scene, nodes, rays, n, false);
  const fast_entry root = {NULL, 0, n < FAST_BLOCK ? ((uint64_t)1 << n) - 1 : ~(uint64_t)0, 0, false};
  for (uint32_t i = 0; i < FAST_BLOCK; i++) list[i] = i;
  f.step = step;
  fast_stream(&f, list, root);

  for (uint32_t s = 0; s < f.steps; s++) masks_draw_column(drawing, x + cell * s, y, cell, step[s].rays, "#06c");
  svg_box(drawing, x, y, x + cell * f.steps, y + MASK_CELL * n, NULL, "#888");

  *enter = f.counts.vectors; /* one for each ray and node */
  const uint32_t steps = f.steps;
  fast_rays_free(&f);
  return steps;
}

/* Finds the box of a node. Returns false for the root. */
static bool masks_box_of(const pktrt_node *nodes, uint32_t count, uint32_t index, const float **lo, const float **hi) {
  for (uint32_t i = 0; i < count; i++)
    for (int k = 0; k < 8; k++)
      if (nodes[i].child[k] == index && !nodes[i].leaf[k]) {
        *lo = nodes[i].lo[k];
        *hi = nodes[i].hi[k];
        return true;
      }
  return false;
}

/* Draws a packet of the paper's path: for each node that it opens the active range, and in it the rays that enter the
   node's box. Returns how many nodes; sets how many rays of all ranges enter. */
EX_UNUSED static uint32_t masks_draw_paper(svg *drawing, double x, double y, double cell, const pktrt_scene *library,
    const pktrt_node *nodes, uint32_t count, const course_ray *rays, uint32_t n, uint64_t *along, uint64_t *enter) {
  course_log log = {NULL, 0, 0};
  uint32_t steps = 0;
  course_slabs slabs[FAST_BLOCK];
  for (uint32_t i = 0; i < n; i++) slabs[i] = course_slabs_make(nodes, rays[i]);
  course_library_packet(library, rays, n, 0, NULL, &log);
  *along = *enter = 0;

  for (size_t e = 0; e < log.count; e++) {
    const pktrt_event *event = &log.event[e];
    const float *lo = NULL, *hi = NULL;
    if (event->kind == PKTRT_EVENT_HIT) { /* a ray that has a hit no longer enters boxes behind it */
      const course_hit hit = course_library_hit(library, rays[event->ray]);
      slabs[event->ray].last = fmaxf(hit.t * slabs[event->ray].scale, 0) * (1 + 1e-6f);
    }
    if (event->kind != PKTRT_EVENT_NODE) continue;
    const bool root = !masks_box_of(nodes, count, event->index, &lo, &hi);
    uint64_t entering = 0;
    for (uint32_t i = event->ray; i < event->ray + event->active; i++)
      if (root || course_slabs_enter(&slabs[i], lo, hi, NULL)) entering |= (uint64_t)1 << i;
    *along += event->active;
    *enter += fast_count(entering);
    svg_box(drawing, x + cell * steps, y + MASK_CELL * event->ray, x + cell * (steps + 1),
        y + MASK_CELL * (event->ray + event->active), "#fc8", NULL);
    masks_draw_column(drawing, x + cell * steps, y, cell, entering, "#06c");
    steps++;
  }
  svg_box(drawing, x, y, x + cell * steps, y + MASK_CELL * n, NULL, "#888");
  free(log.event);
  return steps;
}

/* Draws a stream of rays, and beside it the paper's packet of the same rays. Prints figures `masks.kind.`... */
EX_UNUSED static void masks_draw(svg *drawing, double y, const char *kind, const course_scene *scene,
    const pktrt_scene *library, const pktrt_node *nodes, uint32_t count, const course_ray *rays, uint32_t n,
    double cell) {
  uint64_t in_stream, along, enter;
  char row[40];
  snprintf(row, sizeof row, "masks.%.20s", kind);
  svg_text(drawing, 10, y + 16, 16, SVG_LEFT, "%s rays, a stream", kind);
  svg_text(drawing, 490, y + 16, 16, SVG_LEFT, "the same rays, the paper's packet");
  const uint32_t stream = masks_draw_stream(drawing, 10, y + 26, cell, scene, nodes, rays, n, &in_stream);
  const uint32_t paper = masks_draw_paper(drawing, 490, y + 26, cell, library, nodes, count, rays, n, &along, &enter);
  printf("%s rays: a stream opens %u nodes, %u rays enter; the paper's packet %u nodes, %u rays come along, %u enter\n",
      kind, (unsigned)stream, (unsigned)in_stream, (unsigned)paper, (unsigned)along, (unsigned)enter);
  fast_figure(row, "stream.nodes", "%.0f", stream);
  fast_figure(row, "stream.enter", "%.0f", (double)in_stream);
  fast_figure(row, "paper.nodes", "%.0f", paper);
  fast_figure(row, "paper.along", "%.0f", (double)along);
  fast_figure(row, "paper.enter", "%.0f", (double)enter);
  fast_figure(row, "paper.vain", "%.0f", 100 * (double)(along - enter) / (double)along);
}

/* Draws a packet of shadow rays and a packet of reflected rays. */
EX_UNUSED static void draw_hulls(const course_scene *scene, const pktrt_node *nodes, const pktrt_scene *library) {
  course_ray rays[64];
  svg drawing;
  if (!svg_begin(&drawing, "out/course/13_hull.svg", 960, 690)) exit(1);
  uint32_t n = rays_aim_tile(rays, 503, RAYS_SHADOW, scene, library);
  hull_draw(&drawing, 5, "shadow rays", "shadow", scene, nodes, rays, n, true, 42);
  n = rays_aim_tile(rays, 686, RAYS_REFLECTED, scene, library);
  hull_draw(&drawing, 485, "reflected rays", "reflected", scene, nodes, rays, n, false, 36);
  if (!svg_end(&drawing)) exit(1);
}

/* Draws the rays by nodes, of a packet of reflected rays and of 64 scattered rays of one octant. */
EX_UNUSED static void draw_masks(
    const course_scene *scene, const pktrt_node *nodes, uint32_t count, const pktrt_scene *library) {
  course_ray rays[64];
  svg drawing;
  if (!svg_begin(&drawing, "out/course/13_masks.svg", 960, 640)) exit(1);
  uint32_t n = rays_aim_tile(rays, 686, RAYS_REFLECTED, scene, library);
  masks_draw(&drawing, 10, "reflected", scene, library, nodes, count, rays, n, 22);

  n = 0;
  for (uint32_t i = 300 * 64; n < 64; i++)
    n += rays_aim(&rays[n], i, RAYS_SCATTERED, scene, library) && course_slabs_make(nodes, rays[n]).octant == 2;
  masks_draw(&drawing, 330, "scattered", scene, library, nodes, count, rays, n, 10);
  if (!svg_end(&drawing)) exit(1);
}

#endif /* COURSE_13_FIGURES_H */
