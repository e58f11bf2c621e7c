/* 11_record.h - which rays chapter 11 traces: counts by type and depth, directions by blocks of pixels, the tree of one
   pixel and its drawing. */
#ifndef RECORD_H
#define RECORD_H

#include "11_picture.h"

enum { RECORD_DEPTH = 51, RECORD_TYPES = 4, RECORD_TREE = 256 };

typedef struct record_node { /* a ray of a tree */
  pktrt_ray_type type;
  uint32_t depth;
  float weight;
  vec from, to;
} record_node;

typedef struct record { /* zeroed: empty */
  uint64_t count[RECORD_TYPES][RECORD_DEPTH + 1];
  /* Of a block of pixels, by type and at most one surface from the camera: rays and the sum of their unit directions;
     the last row has all types. */
  double rays[RECORD_TYPES + 1], sum[RECORD_TYPES + 1][3];
  double angle[RECORD_TYPES + 1]; /* sum over blocks of the rays times the angle of their spread */
  double all_rays[RECORD_TYPES + 1];
  uint64_t inside, total; /* meetings of a ray in glass with the surface; total reflections among them */
  bool keep;              /* rays go to the tree */
  record_node node[RECORD_TREE];
  uint32_t nodes;
} record;

/* Counts a ray that ends at t. */
EX_UNUSED static void record_ray(
    record *r, pktrt_ray_type type, uint32_t depth, float weight, const course_ray *ray, float t) {
  const vec unit = vec_unit(ray->direction);
  r->count[type][depth < RECORD_DEPTH ? depth : RECORD_DEPTH]++;
  for (int k = 0; k < 2 && depth <= 1; k++) {
    const int row = k ? RECORD_TYPES : (int)type;
    r->rays[row]++;
    for (int a = 0; a < 3; a++) r->sum[row][a] += (double)unit.at[a];
  }
  if (!r->keep || r->nodes == RECORD_TREE) return;
  record_node *node = &r->node[r->nodes++];
  node->type = type;
  node->depth = depth;
  node->weight = weight;
  node->from = ray->origin;
  node->to = vec_add(ray->origin, vec_scale(ray->direction, isinf(t) ? 3 : t));
}

/* Ends a block of pixels. The spread of its directions is the angle whose cosine is the length of their mean. */
EX_UNUSED static void record_block(record *r) {
  for (int row = 0; row <= RECORD_TYPES; row++) {
    const double *s = r->sum[row];
    const double n = r->rays[row];
    if (n > 0) r->angle[row] += n * acos(fmin(1, sqrt(s[0] * s[0] + s[1] * s[1] + s[2] * s[2]) / n));
    r->all_rays[row] += n;
    memset(r->sum[row], 0, sizeof r->sum[row]);
    r->rays[row] = 0;
  }
}

/* Counts the ways on from a surface of glass. */
EX_UNUSED static void record_glass(record *r, bool inside, uint32_t ways) {
  r->inside += inside;
  r->total += inside && ways == 1;
}

/* Returns the number of rays of a type from one depth to another, both included. */
EX_UNUSED static uint64_t record_count(const record *r, int type, uint32_t from, uint32_t to) {
  uint64_t count = 0;
  for (uint32_t depth = from; depth <= to; depth++) count += r->count[type][depth];
  return count;
}

/* Prints how many rays of each type there are at a range of depths. */
EX_UNUSED static void record_print(const record *r, const char *name, uint32_t from, uint32_t to) {
  printf("  %-9s", name);
  for (int type = 0; type < RECORD_TYPES; type++) printf(" %10u", (unsigned)record_count(r, type, from, to));
  printf("\n");
}

/* >>drawing -------------------------------------------------------------------------------------------------------- */

/* Draws the rays of the tree from above, over the edges of all parts but the floor. */
static void record_draw_above(const record *r, const picture_scene *s, svg *to, const char *const *colour) {
  const double unit = 44;
  const double left = 190; /* where x is 0 */
  const double top = 205;  /* where z is 0 */

  fprintf(to->file, "<svg width=\"400\" height=\"420\">\n");
  for (uint32_t i = s->first[PICTURE_PANEL]; i < s->triangles.triangles; i++)
    for (int k = 0; k < 3; k++) {
      const float *p = s->triangles.position[s->triangles.corner[i][k]].at;
      const float *q = s->triangles.position[s->triangles.corner[i][(k + 1) % 3]].at;
      svg_line(to, left + unit * (double)p[0], top + unit * (double)p[2], left + unit * (double)q[0],
          top + unit * (double)q[2], "#bbb", 0.7);
    }
  for (uint32_t i = 0; i < r->nodes; i++) {
    const float *p = r->node[i].from.at;
    const float *q = r->node[i].to.at;
    svg_ray(to, left + unit * (double)p[0], top + unit * (double)p[2], left + unit * (double)q[0],
        top + unit * (double)q[2], colour[r->node[i].type], 1.5);
  }
  fprintf(to->file, "</svg>\n");
}

/* Draws the tree: a dot for each ray, the rays that it sends out below it, and its weight. */
static void record_draw_tree(const record *r, svg *to, const char *const *colour) {
  double x[RECORD_TREE], first[RECORD_TREE], last[RECORD_TREE];
  uint32_t parent[RECORD_TREE], open[RECORD_DEPTH + 2], leaves = 0;

  /* Rays come parents first, so the parent is the last one whose depth is smaller by 1. */
  for (uint32_t i = 0; i < r->nodes; i++) {
    const uint32_t depth = r->node[i].depth;
    parent[i] = depth > 0 ? open[depth - 1] : 0;
    if (r->node[i].type != PKTRT_RAY_SHADOW) open[depth] = i;
    first[i] = INFINITY;
    last[i] = -INFINITY;
  }
  for (uint32_t i = 0; i < r->nodes; i++) leaves += i + 1 == r->nodes || r->node[i + 1].depth <= r->node[i].depth;
  for (uint32_t i = r->nodes, leaf = leaves; i-- > 0;) {
    const bool ends = i + 1 == r->nodes || r->node[i + 1].depth <= r->node[i].depth;
    x[i] = ends ? 410 + 480.0 * (--leaf + 0.5) / leaves : (first[i] + last[i]) / 2;
    first[parent[i]] = fmin(first[parent[i]], x[i]);
    last[parent[i]] = fmax(last[parent[i]], x[i]);
  }

  for (uint32_t i = 0; i < r->nodes; i++) {
    const double y = 30 + 45 * (double)r->node[i].depth;
    if (i > 0) svg_line(to, x[parent[i]], y - 45, x[i], y, colour[r->node[i].type], 2);
  }
  for (uint32_t i = 0; i < r->nodes; i++) {
    const double y = 30 + 45 * (double)r->node[i].depth;
    svg_dot(to, x[i], y, 4, colour[r->node[i].type]);
    if (r->node[i].type != PKTRT_RAY_SHADOW)
      svg_text(to, x[i] + 6, y + 4, 11, SVG_LEFT, "%.3f", (double)r->node[i].weight);
  }
}

/* Draws the rays of one pixel, from above and as a tree. Returns false if the file cannot be written. */
EX_UNUSED static bool record_draw(const record *r, const picture_scene *s, const char *path) {
  static const char *const colour[RECORD_TYPES] = {"#444", "#e09000", "#0070c0", "#20a030"};
  static const char *const name[RECORD_TYPES] = {"primary", "shadow", "reflected", "refracted"};
  svg drawing;

  course_make_folder();
  if (!svg_begin(&drawing, path, 900, 460)) return false;
  record_draw_above(r, s, &drawing, colour);
  record_draw_tree(r, &drawing, colour);
  for (int type = 0; type < RECORD_TYPES; type++) {
    svg_line(&drawing, 20 + 110 * type, 440, 50 + 110 * type, 440, colour[type], 3);
    svg_text(&drawing, 56 + 110 * type, 445, 14, SVG_LEFT, "%s", name[type]);
  }
  return svg_end(&drawing);
}
#endif
