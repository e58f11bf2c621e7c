/* 08_reflect.c - what becomes of a packet at a mirror, flat or curved.

   Prints how full packets and vectors are by bounce. Makes out/course/08_balls.png, the scene; 08_packets.svg, two packets
   from above, one at a mirror ball and one at a mirror wall; 08_bounces.svg, lanes in use and vector tests by bounce. */
#define PKTRT_IMPLEMENTATION
#include "08_reflect.h"
#include "../svg.h"

enum { EDGE = 8, BLOCKS = REFLECT_SIZE / EDGE, WALL = 3, BALL = 4 + 5 }; /* numbers of meshes: a wall, and ball 5 */
static const char *const colours[] = {"#999", "#27b", "#e80", "#c22"};

/* [lanes] */
static double tests(const pktrt_counts *c) { return (double)(c->box_tests + c->triangle_tests); }
static double vectors(const pktrt_counts *c) { return (double)(c->vector_box_tests + c->vector_triangle_tests); }

/* Of the eight lanes of a vector test, those that had a ray to test. */
static double lanes(const pktrt_counts *c) { return tests(c) / vectors(c); }
/* [end] */

static void render(pktrt_scene *s, const pktrt_render_desc *d) {
  if (pktrt_render(s, d)) ex_fail("%s", pktrt_last_error(s)), exit(1);
}
static pktrt_ray query_ray(const reflect_ray *r) { return pktrt_make_ray(r->origin, r->direction); }

static uint32_t block_of(const reflect_ray *r) { return r->y / EDGE * BLOCKS + r->x / EDGE; }

/* [block] */
/* Of the blocks of 8 x 8 pixels all of whose camera rays hit a mesh, the one from which most rays descend. */
static uint32_t block_that_hits(const pktrt_scene *s, const reflect_log *log, uint32_t mesh) {
  uint32_t hitting[BLOCKS * BLOCKS] = {0}, rays[BLOCKS * BLOCKS] = {0}, best = 0;
  for (uint32_t i = 0; i < log->n; i++) {
    const reflect_ray *r = &log->ray[i];
    const pktrt_ray ray = query_ray(r);
    pktrt_hit hit;
    rays[block_of(r)]++;
    if (r->depth == 0 && pktrt_intersect(s, &ray, &hit) && hit.mesh == mesh) hitting[block_of(r)]++;
  }
  for (uint32_t b = 0; b < BLOCKS * BLOCKS; b++) {
    if (hitting[b] < EDGE * EDGE) rays[b] = 0;
    if (rays[b] > rays[best]) best = b;
  }
  return best;
}
/* [end] */

/* Draws the rays that descend from a block of pixels, seen from above, and prints what their packets cost. */
static void draw_block(
    svg *g, const pktrt_scene *s, const reflect_log *log, uint32_t block, double left, const char *name) {
  const double scale = 30, x0 = left + 5.2 * scale, y0 = 30 + 5.2 * scale;
  svg_text(g, left + 6, 20, 13, SVG_LEFT, "%s", name);
  svg_line(g, x0 + 5 * scale, y0 - 5 * scale, x0 + 5 * scale, y0 + 7.6 * scale, "#444", 4); /* the mirror */
  svg_line(g, x0 - 5 * scale, y0 - 5 * scale, x0 + 5 * scale, y0 - 5 * scale, "#b74", 4);
  svg_line(g, x0 - 5 * scale, y0 - 5 * scale, x0 - 5 * scale, y0 + 7.6 * scale, "#583", 4);
  for (int i = 0; i < 9; i++) {
    float c[3];
    reflect_ball(i, c);
    const bool glass = i == 1 || i == 3 || i == 8;
    svg_dot(g, x0 + scale * (double)c[0], y0 + scale * (double)c[2], scale * 0.9, glass ? "#def" : "#ddd");
  }
  for (uint32_t depth = 4; depth-- > 0;)
    for (uint32_t i = 0; i < log->n; i++) {
      const reflect_ray *r = &log->ray[i];
      if (r->depth != depth || block_of(r) != block) continue;
      const pktrt_ray ray = query_ray(r);
      pktrt_hit hit;
      const float t = pktrt_intersect(s, &ray, &hit) ? hit.t : 1.5f; /* to the sky */
      const double x = x0 + scale * (double)r->origin[0], y = y0 + scale * (double)r->origin[2];
      svg_line(g, x, y, x + scale * (double)(t * r->direction[0]), y + scale * (double)(t * r->direction[2]),
          colours[depth], depth ? 0.8 : 0.4);
    }
}

/* [cost] */
/* Prints, bounce by bounce, the packets of rays that descend from a block, and what each of these rays costs. */
static void print_block(const pktrt_scene *s, const reflect_log *log, uint32_t block, const char *name) {
  static uint32_t order[1 << 16], end[1 << 16];
  static pktrt_hit hits[1 << 16];
  printf("\n%s, by bounce: rays, packets, vector tests per ray\n", name);
  for (uint32_t depth = 0; depth < 5; depth++) {
    uint32_t n = 0, packets = 0;
    for (uint32_t k = 0, begin = 0; k < log->packets; begin = log->end[k++]) {
      const reflect_ray *first = &log->ray[begin]; /* all of a packet descend from the same block */
      if (first->depth != depth || block_of(first) != block) continue;
      for (uint32_t i = begin; i < log->end[k]; i++) order[n++] = i;
      end[packets++] = n;
    }
    if (n == 0) return;
    const double tests = (double)reflect_trace(s, log->ray, order, end, packets, hits);
    printf("  %u: %4u %3u %6.1f\n", (unsigned)depth, (unsigned)n, (unsigned)packets, tests / n);
  }
}
/* [end] */

static void draw_bars(svg *g, double left, const char *what, pktrt_stats stats[2], bool of_lanes) {
  svg_text(g, left, 20, 13, SVG_LEFT, "%s", what);
  svg_line(g, left, 200, left + 330, 200, "#888", 1);
  if (of_lanes) svg_line(g, left, 40, left + 330, 40, "#888", 1), svg_text(g, left + 336, 44, 11, SVG_LEFT, "8");
  for (uint32_t depth = 0; depth <= REFLECT_DEPTH; depth++) {
    const double x = left + 6 + 36 * depth;
    svg_text(g, x + 14, 214, 11, SVG_MIDDLE, "%u", (unsigned)depth);
    for (int k = 0; k < 2; k++) {
      const pktrt_counts *c = &stats[k].by_depth[depth];
      const double v = of_lanes ? lanes(c) : vectors(c) / (double)c->rays, y = 200 - v * (of_lanes ? 20 : 2);
      svg_box(g, x + 14 * k, y, x + 14 * k + 13, 200, k ? "#e84" : "#47a", NULL);
      svg_text(g, x + 14 * k + 7, y - 3, 8, SVG_MIDDLE, of_lanes ? "%.1f" : "%.0f", v);
    }
  }
}

int main(void) {
  enum { LARGE = 320 };
  static float pixels[LARGE * LARGE * 3];
  static pktrt_stats stats[3];
  svg g;
  pktrt_scene *s = reflect_scene();
  reflect_log log = reflect_log_make();
  pktrt_render_desc d = reflect_view(pixels);
  d.packet = reflect_log_packet, d.user = &log, d.stats = &stats[0];
  render(s, &d);
  d.packet = NULL, d.stats = &stats[1], d.assembly = PKTRT_ASSEMBLY_RUNS;
  render(s, &d);
  d.stats = &stats[2], d.path = PKTRT_PATH_SINGLE;
  render(s, &d);
  printf("by bounce: rays; tests per ray, alone and in packets of ray types;\n"
         "           lanes in use, of 8, and vector tests per ray, of ray types and of runs\n");
  for (int depth = 0; depth <= REFLECT_DEPTH; depth++) {
    const pktrt_counts *t = &stats[0].by_depth[depth], *r = &stats[1].by_depth[depth], *o = &stats[2].by_depth[depth];
    printf("  %d: %6u  %6.1f %6.1f  %5.1f %5.1f  %6.1f %6.1f\n", depth, (unsigned)t->rays, tests(o) / (double)o->rays,
        tests(t) / (double)t->rays, lanes(t), lanes(r), vectors(t) / (double)t->rays, vectors(r) / (double)r->rays);
  }
  course_make_folder();
  const uint32_t wall = block_that_hits(s, &log, WALL), ball = block_that_hits(s, &log, BALL);
  print_block(s, &log, wall, "a packet at the mirror wall");
  print_block(s, &log, ball, "a packet at a mirror ball");
  if (!svg_begin(&g, "out/course/08_packets.svg", 640, 475)) return 1;
  draw_block(&g, s, &log, wall, 0, "at the mirror wall");
  draw_block(&g, s, &log, ball, 325, "at a mirror ball");
  svg_text(&g, 6, 468, 12, SVG_LEFT,
      "Camera rays grey, then blue, orange, red; those into the sky end in the air. Dark: the mirror.");
  if (!svg_end(&g) || !svg_begin(&g, "out/course/08_bounces.svg", 720, 225)) return 1;
  draw_bars(&g, 10, "Lanes in use: ray types (blue), runs (orange)", stats, true);
  draw_bars(&g, 380, "Vector tests per ray by bounce", stats, false);
  d = reflect_view(pixels);
  d.width = d.height = LARGE, d.samples = 4;
  render(s, &d);
  reflect_log_free(&log), pktrt_scene_destroy(s);
  return !svg_end(&g) || !ex_write_picture("out/course/08_balls.png", pixels, LARGE, LARGE);
}
