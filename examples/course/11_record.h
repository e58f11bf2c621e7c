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

/* Prints the figure `name.what`. */
EX_UNUSED static void record_figure(const char *name, const char *what, const char *format, double value) {
  char full_name[64];
  snprintf(full_name, sizeof full_name, "%s.%s", name, what);
  course_figure(full_name, format, value);
}

/* Counts a ray that ends at t. */
EX_UNUSED static void record_ray(
    record *log, pktrt_ray_type type, uint32_t depth, float weight, const course_ray *ray, float t) {
  const vec unit = vec_unit(ray->direction);
  log->count[type][depth < RECORD_DEPTH ? depth : RECORD_DEPTH]++;
  for (int k = 0; k < 2 && depth <= 1; k++) {
    const int row = k ? RECORD_TYPES : (int)type;
    log->rays[row]++;
    for (int a = 0; a < 3; a++) log->sum[row][a] += (double)unit.at[a];
  }

  if (!log->keep || log->nodes == RECORD_TREE) return;
  record_node *node = &log->node[log->nodes++];
  node->type = type;
  node->depth = depth;
  node->weight = weight;
  node->from = ray->origin;
  node->to = vec_add(ray->origin, vec_scale(ray->direction, isinf(t) ? 3 : t));
}

/* Ends a block of pixels. The spread of its directions is the angle whose cosine is the length of their mean. */
EX_UNUSED static void record_block(record *log) {
  for (int row = 0; row <= RECORD_TYPES; row++) {
    const double *sum = log->sum[row];
    const double n = log->rays[row];
    if (n > 0) log->angle[row] += n * acos(fmin(1, sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]) / n));
    log->all_rays[row] += n;
    memset(log->sum[row], 0, sizeof log->sum[row]);
    log->rays[row] = 0;
  }
}

/* Counts the ways on from a surface of glass. */
EX_UNUSED static void record_glass(record *log, bool inside, uint32_t ways) {
  log->inside += inside;
  log->total += inside && ways == 1;
}

/* Returns the number of rays of a type from one depth to another, both included. */
EX_UNUSED static uint64_t record_count(const record *log, int type, uint32_t from, uint32_t last) {
  uint64_t count = 0;

  for (uint32_t depth = from; depth <= last; depth++) count += log->count[type][depth];
  return count;
}

/* Returns the largest difference of two pixels in a channel. */
EX_UNUSED static float record_difference(vec mine, vec theirs) {
  const vec apart = vec_sub(mine, theirs);
  return fmaxf(fabsf(apart.at[0]), fmaxf(fabsf(apart.at[1]), fabsf(apart.at[2])));
}

/* Returns how many pixels of two pictures differ by more than `most`, or are not numbers. */
EX_UNUSED static uint32_t record_count_apart(const course_picture *mine, const course_picture *theirs, float most) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < mine->width * mine->height; i++)
    count += !(record_difference(mine->pixel[i], theirs->pixel[i]) <= most);
  return count;
}

/* Prints the largest difference of two pictures, and that of the pixels that differ by at most 1/1000. */
EX_UNUSED static void record_compare(const course_picture *mine, const course_picture *theirs) {
  float largest = 0;
  for (uint32_t i = 0; i < mine->width * mine->height; i++)
    largest = fmaxf(largest, record_difference(mine->pixel[i], theirs->pixel[i]));
  const uint32_t thousandth = record_count_apart(mine, theirs, 0.001f);
  const uint32_t less = record_count_apart(mine, theirs, 0.0001f);
  printf("  largest difference from the library's picture: %.3f\n", (double)largest);
  printf(
      "  pixels that differ by more than 0.001: %u; by more than 0.0001: %u\n", (unsigned)thousandth, (unsigned)less);
  course_figure("apart.largest", "%.3f", (double)largest);
  course_figure("apart.0.001", "%u", (unsigned)thousandth);
  course_figure("apart.0.0001", "%u", (unsigned)less);
}

/* Writes two pictures of one size side by side. */
EX_UNUSED static void record_write_both(const course_picture *left, const course_picture *right, const char *path) {
  const uint32_t width = left->width;
  course_picture both = course_picture_make(2 * width, left->height);

  for (uint32_t y = 0; y < left->height; y++) {
    memcpy(&both.pixel[2 * width * y], &left->pixel[width * y], width * sizeof(vec));
    memcpy(&both.pixel[2 * width * y + width], &right->pixel[width * y], width * sizeof(vec));
  }
  course_picture_write(&both, path);
}

/* Prints how many rays of each type there are at a range of depths. */
EX_UNUSED static void record_print(const record *log, const char *name, uint32_t from, uint32_t last) {
  printf("  %-9s", name);
  for (int type = 0; type < RECORD_TYPES; type++) printf(" %10u", (unsigned)record_count(log, type, from, last));
  printf("\n");
}

/* Prints rays by type, the library's beside them, rays by depth, spreads and total reflections. */
EX_UNUSED static void record_print_all(const record *log, const pktrt_stats *library) {
  printf("rays:          primary     shadow  reflected  refracted\n");
  record_print(log, "mine", 0, RECORD_DEPTH);
  printf("  %-9s", "library");
  for (int type = 0; type < RECORD_TYPES; type++) printf(" %10u", (unsigned)library->by_type[type].rays);
  printf("\nby depth:\n");
  for (uint32_t depth = 0; depth < 6; depth++) {
    const char name[2] = {(char)('0' + depth), 0};
    record_print(log, name, depth, depth);
  }
  record_print(log, "6 to 10", 6, 10);
  record_print(log, "above 10", 11, RECORD_DEPTH);

  course_figure("inside", "%u", (unsigned)log->inside);
  course_figure("inside.total", "%u", (unsigned)log->total);

  static const char *const name[RECORD_TYPES + 1] = {"primary", "shadow", "reflected", "refracted", "all"};
  printf("spread in degrees:\n  %-9s", "");
  for (int row = 0; row < RECORD_TYPES; row++) printf(" %10.1f", log->angle[row] / log->all_rays[row] * 57.29578);
  printf("; all together %.1f\n", log->angle[RECORD_TYPES] / log->all_rays[RECORD_TYPES] * 57.29578);
  for (int row = 0; row <= RECORD_TYPES; row++)
    record_figure("spread", name[row], "%.1f", log->angle[row] / log->all_rays[row] * 57.29578);
  printf("rays in glass meet the surface %u times, %u of these are total reflections\n", (unsigned)log->inside,
      (unsigned)log->total);
}

/* Prints what limits make of the number of rays and of the picture. The figures are `limits.256` and so on by cut-off,
   `limits.depth4` and so on without a cut-off. */
EX_UNUSED static void record_print_limits(
    const record *log, float cutoff, uint32_t depth, const course_picture *picture, const course_picture *exact) {
  const uint32_t hundredth = record_count_apart(picture, exact, 0.01f);
  const uint32_t tenth = record_count_apart(picture, exact, 0.1f);
  uint32_t deepest = 0;
  uint64_t count = 0;

  for (int type = 0; type < RECORD_TYPES; type++) count += record_count(log, type, 0, RECORD_DEPTH);
  for (uint32_t i = 0; i <= RECORD_DEPTH; i++)
    if (log->count[PKTRT_RAY_REFLECTION][i] + log->count[PKTRT_RAY_REFRACTION][i] > 0) deepest = i;

  printf("  cut-off ");
  if (cutoff > 0) printf("1/%-3g", 1 / (double)cutoff);
  else printf("none ");
  printf(" depth %2u: %7u rays, the deepest at %2u; %5u pixels differ by more than 0.01, %5u by more than 0.1\n",
      (unsigned)depth, (unsigned)count, (unsigned)deepest, (unsigned)hundredth, (unsigned)tenth);

  char name[32];
  if (cutoff > 0) snprintf(name, sizeof name, "limits.%g", 1 / (double)cutoff);
  else snprintf(name, sizeof name, "limits.depth%u", (unsigned)depth);
  record_figure(name, "rays", "%.0f", (double)count);
  record_figure(name, "deepest", "%.0f", deepest);
  record_figure(name, "0.01", "%.0f", hundredth);
  record_figure(name, "0.1", "%.0f", tenth);
}

/* Prints reflectances of glass of index 1.5, and by how much Schlick's formula differs from them. */
EX_UNUSED static void record_print_glass(void) {
  const float eta[2] = {1.5f, 1 / 1.5f};
  const double head_on = 0.04; /* the reflectance along the normal */
  double largest[2] = {0, 0};
  for (int side = 0; side < 2; side++)
    for (int i = 0; i <= 1000; i++) {
      const double schlick = head_on + (1 - head_on) * pow(1 - i / 1000.0, 5);
      const double exact = (double)pktrt_fresnel_dielectric((float)i / 1000, eta[side]);
      if (exact < 1) largest[side] = fmax(largest[side], fabs(schlick - exact));
    }

  const double normal = (double)pktrt_fresnel_dielectric(1, 1.5f);
  const double slanted = (double)pktrt_fresnel_dielectric(0.70710678f, 1.5f);
  const double critical = asin(1 / 1.5);
  printf("glass of index 1.5: reflectance %.3f along the normal, %.3f at 45 degrees; critical angle %.1f degrees\n",
      normal, slanted, critical * 57.29578);
  printf("Schlick's formula differs from the exact reflectance by up to %.3f from outside, %.3f from inside\n",
      largest[0], largest[1]);
  course_figure("glass.normal", "%.3f", normal);
  course_figure("glass.slanted", "%.3f", slanted);
  course_figure("glass.critical", "%.1f", critical * 57.29578);
  course_figure("glass.critical.cosine", "%.3f", cos(critical));
  course_figure("glass.critical.sine", "%.3f", sin(critical));
  course_figure("schlick.outside", "%.3f", largest[0]);
  course_figure("schlick.inside", "%.3f", largest[1]);
}

/* Prints the tree, a line for each ray: types and weights, indented by depth. The figure `tree.3` is the weight of the
   fourth line. */
EX_UNUSED static void record_print_tree(const record *log) {
  static const char *const name[RECORD_TYPES] = {"primary", "shadow", "reflected", "refracted"};

  printf("the tree that is drawn:\n");
  for (uint32_t i = 0; i < log->nodes; i++)
    printf("%*s%s %.3f\n", 2 + 2 * (int)log->node[i].depth, "", name[log->node[i].type], (double)log->node[i].weight);

  for (uint32_t i = 0; i < log->nodes; i++) {
    char line[16];
    snprintf(line, sizeof line, "%u", (unsigned)i);
    record_figure("tree", line, "%.3f", (double)log->node[i].weight);
  }
}

/* >>drawing -------------------------------------------------------------------------------------------------------- */

/* Draws the rays of the tree from above, over the edges of all parts but the floor. */
static void record_draw_above(const record *log, const picture_scene *scene, svg *drawing, const char *const *colour) {
  const double unit = 44;
  const double left = 190; /* where x is 0 */
  const double top = 205;  /* where z is 0 */

  fprintf(drawing->file, "<svg width=\"400\" height=\"420\">\n");
  for (uint32_t i = scene->first[PICTURE_PANEL]; i < scene->triangles.triangles; i++)
    for (int k = 0; k < 3; k++) {
      const float *p0 = scene->triangles.position[scene->triangles.corner[i][k]].at;
      const float *p1 = scene->triangles.position[scene->triangles.corner[i][(k + 1) % 3]].at;
      svg_line(drawing, left + unit * (double)p0[0], top + unit * (double)p0[2], left + unit * (double)p1[0],
          top + unit * (double)p1[2], "#bbb", 0.7);
    }
  for (uint32_t i = 0; i < log->nodes; i++) {
    const float *p0 = log->node[i].from.at;
    const float *p1 = log->node[i].to.at;
    svg_ray(drawing, left + unit * (double)p0[0], top + unit * (double)p0[2], left + unit * (double)p1[0],
        top + unit * (double)p1[2], colour[log->node[i].type], 1.5);
  }
  fprintf(drawing->file, "</svg>\n");
}

/* Draws the tree: a dot for each ray, the rays that it sends out below it, and its weight. */
static void record_draw_tree(const record *log, svg *drawing, const char *const *colour) {
  double x[RECORD_TREE], first[RECORD_TREE], last[RECORD_TREE];
  uint32_t parent[RECORD_TREE], open[RECORD_DEPTH + 2], leaves = 0;

  /* Rays come parents first, so the parent is the last one whose depth is smaller by 1. */
  for (uint32_t i = 0; i < log->nodes; i++) {
    const uint32_t depth = log->node[i].depth;
    parent[i] = depth > 0 ? open[depth - 1] : 0;
    if (log->node[i].type != PKTRT_RAY_SHADOW) open[depth] = i;
    first[i] = INFINITY;
    last[i] = -INFINITY;
  }
  for (uint32_t i = 0; i < log->nodes; i++)
    leaves += i + 1 == log->nodes || log->node[i + 1].depth <= log->node[i].depth;
  for (uint32_t i = log->nodes, leaf = leaves; i-- > 0;) {
    const bool ends = i + 1 == log->nodes || log->node[i + 1].depth <= log->node[i].depth;
    x[i] = ends ? 410 + 480.0 * (--leaf + 0.5) / leaves : (first[i] + last[i]) / 2;
    first[parent[i]] = fmin(first[parent[i]], x[i]);
    last[parent[i]] = fmax(last[parent[i]], x[i]);
  }

  for (uint32_t i = 0; i < log->nodes; i++) {
    const double y = 30 + 45 * (double)log->node[i].depth;
    if (i > 0) svg_line(drawing, x[parent[i]], y - 45, x[i], y, colour[log->node[i].type], 2);
  }
  for (uint32_t i = 0; i < log->nodes; i++) {
    const double y = 30 + 45 * (double)log->node[i].depth;
    svg_dot(drawing, x[i], y, 4, colour[log->node[i].type]);
    if (log->node[i].type != PKTRT_RAY_SHADOW)
      svg_text(drawing, x[i] + 6, y + 4, 11, SVG_LEFT, "%.3f", (double)log->node[i].weight);
  }
}

/* Draws the rays of one pixel, from above and as a tree. Returns false if the file cannot be written. */
EX_UNUSED static bool record_draw(const record *log, const picture_scene *scene, const char *path) {
  static const char *const colour[RECORD_TYPES] = {"#444", "#e09000", "#0070c0", "#20a030"};
  static const char *const name[RECORD_TYPES] = {"primary", "shadow", "reflected", "refracted"};
  svg drawing;

  course_make_folder();
  if (!svg_begin(&drawing, path, 900, 460)) return false;
  record_draw_above(log, scene, &drawing, colour);
  record_draw_tree(log, &drawing, colour);
  for (int type = 0; type < RECORD_TYPES; type++) {
    svg_line(&drawing, 20 + 110 * type, 440, 50 + 110 * type, 440, colour[type], 3);
    svg_text(&drawing, 56 + 110 * type, 445, 14, SVG_LEFT, "%s", name[type]);
  }
  return svg_end(&drawing);
}
#endif
