/* Chapter 3: one ray walks down the library's tree. Makes out/course/03_section.svg and 03_heat.png.

   Prints what it cost.    cc -O2 examples/course/03_walk.c -o walk -lm && ./walk */
#define PKTRT_IMPLEMENTATION
#include "course.h"
#include "section.h"

enum { WIDTH = 256, HEIGHT = 192, BRIGHTEST = 16 /* nodes */ };

typedef struct tally { /* the work of walks */
  uint64_t opened, boxes, triangles;
  section *draw; /* NULL: nothing is drawn */
} tally;

/* Draws the box of a child in the section: blue for a node that is opened, orange for a leaf, grey for a miss. */
static void draw_box(tally *work, const pktrt_node *node, int k, bool entered) {
  if (!work->draw) return;
  if (!entered) section_box(work->draw, node->lo[k], node->hi[k], NULL, "#bbb");
  else if (node->leaf[k]) section_box(work->draw, node->lo[k], node->hi[k], "#fb88", "#d60");
  else section_box(work->draw, node->lo[k], node->hi[k], "#48f1", "#26c");
}

/* [walk] */
/* Finds the nearest hit of a ray. Leaves are tested at once; nodes wait on the stack, and the last child is opened
   first: the order does not depend on the ray. */
static course_hit walk(const course_scene *scene, const pktrt_node *nodes, course_ray ray, tally *work) {
  course_slabs slabs = course_slabs_make(&nodes[0], ray);
  course_hit hit = {ray.tmax, 0, 0, COURSE_NONE};
  uint32_t stack[38 * 7 + 1], top = 0;
  stack[top++] = 0;
  while (top) {
    const pktrt_node *node = &nodes[stack[--top]];
    work->opened++;
    for (int k = 0; k < 8; k++) {
      if (node->child[k] == PKTRT_NONE) continue;
      const bool entered = course_slabs_enter(&slabs, node->lo[k], node->hi[k], NULL);
      work->boxes++;
      draw_box(work, node, k, entered);
      if (!entered) continue;
      if (!node->leaf[k]) {
        stack[top++] = node->child[k];
        continue;
      }
      for (int i = 0; i < 8; i++) {
        if (node->triangle[k][i] == PKTRT_NONE) continue;
        work->triangles++;
        course_slabs_meet(&slabs, scene, ray, node->triangle[k][i], &hit);
      }
    }
  }
  return hit;
}
/* [end] */

/* Draws a ray in the plane of the section, and prints its work. */
static void draw_section(const course_scene *scene, const pktrt_node *nodes) {
  const course_ray ray = {vec_make(1.25f, 3.0f, 5.6f), vec_make(0, -0.55f, -2), 0, INFINITY};
  svg drawing;

  course_make_folder();
  if (!svg_begin(&drawing, "out/course/03_section.svg", 860, 350)) exit(1);
  section s = section_begin(&drawing, 1, 6.2, -0.7, 80, 0, 0, 860, 350);
  tally work = {0, 0, 0, &s};
  const course_hit hit = walk(scene, nodes, ray, &work);
  section_scene(&s, scene, ray.origin.at[0]);
  section_ray(&s, ray, hit.t, "#c00", 2);
  section_end(&s);
  if (!svg_end(&drawing)) exit(1);

  printf("  the ray of the section hits triangle %u at t = %.3f; it opens %u nodes, tests %u boxes and %u triangles\n",
      (unsigned)hit.triangle, (double)hit.t, (unsigned)work.opened, (unsigned)work.boxes, (unsigned)work.triangles);
  course_figure("section.x", "%.2f", (double)ray.origin.at[0]);
  course_figure("section.triangle", "%u", (unsigned)hit.triangle);
  course_figure("section.t", "%.3f", (double)hit.t);
  course_figure("section.opened", "%u", (unsigned)work.opened);
  course_figure("section.boxes", "%u", (unsigned)work.boxes);
  course_figure("section.triangles", "%u", (unsigned)work.triangles);
}

/* Draws how many nodes are opened for each pixel: left by the walk above, right by the library. Prints the means. */
static void draw_heat(const course_scene *scene, const pktrt_node *nodes, const pktrt_scene *library) {
  course_picture picture = course_picture_make(2 * WIDTH, HEIGHT);
  tally work = {0, 0, 0, NULL};
  course_tally same = {0, 0, 0};
  uint64_t most = 0, theirs = 0;

  for (uint32_t y = 0; y < HEIGHT; y++)
    for (uint32_t x = 0; x < WIDTH; x++) {
      const course_ray ray = course_camera_ray((float)x + 0.5f, (float)y + 0.5f, WIDTH, HEIGHT);
      const uint64_t before = work.opened, library_opens = course_library_opens(library, ray);
      const course_hit hit = walk(scene, nodes, ray, &work), expected = course_library_hit(library, ray);
      const uint64_t opened = work.opened - before;
      vec *row = picture.pixel + y * picture.width;
      row[x] = course_heat((float)opened / BRIGHTEST);
      row[WIDTH + x] = course_heat((float)library_opens / BRIGHTEST);
      most = opened > most ? opened : most;
      theirs += library_opens;
      course_same_hit(scene, ray, &hit, &expected, &same);
    }
  course_picture_write_double(&picture, "out/course/03_heat.png");

  const double rays = (double)same.rays;
  printf("  %u rays of the camera: %u hits differ from the library's, %u of them at edges\n", (unsigned)same.rays,
      (unsigned)(same.different + same.excused), (unsigned)same.excused);
  printf("  in the order of their places a ray opens %.2f nodes, at most %u, tests %.1f boxes and %.1f triangles\n",
      (double)work.opened / rays, (unsigned)most, (double)work.boxes / rays, (double)work.triangles / rays);
  printf("  the library opens %.2f nodes for a ray traced alone\n", (double)theirs / rays);
  course_figure("rays", "%u", (unsigned)same.rays);
  course_figure("differ", "%u", (unsigned)(same.different + same.excused));
  course_figure("opened", "%.2f", (double)work.opened / rays);
  course_figure("opened.most", "%u", (unsigned)most);
  course_figure("opened.white", "%u", BRIGHTEST);
  course_figure("boxes", "%.1f", (double)work.boxes / rays);
  course_figure("triangles", "%.1f", (double)work.triangles / rays);
  course_figure("library.opened", "%.2f", (double)theirs / rays);
}

/* Prints how many nodes are opened nearest first by the ray that the text shows on the page. */
static void print_page(const pktrt_scene *library) {
  const course_ray ray = course_camera_ray(120.5f, 110.5f, WIDTH, HEIGHT);
  course_log log = {NULL, 0, 0};
  uint32_t opened = 0;

  course_library_packet(library, &ray, 1, PKTRT_PAPER_STEP_ORDER, NULL, &log);
  for (size_t i = 0; i < log.count; i++) opened += log.event[i].kind == PKTRT_EVENT_NODE;
  course_figure("page.opened", "%u", (unsigned)opened);
}

int main(void) {
  course_scene scene = course_scene_make();
  pktrt_scene *library = course_library(&scene);
  uint32_t count, leaves = 0, children = 0;
  pktrt_node *nodes = course_library_nodes(library, &count);

  for (uint32_t i = 0; i < count; i++)
    for (int k = 0; k < 8; k++) {
      if (nodes[i].child[k] == PKTRT_NONE) continue;
      children++;
      leaves += nodes[i].leaf[k];
    }
  printf("03_walk: %u triangles in a tree of %u nodes and %u leaves; a node has %.2f children\n",
      (unsigned)scene.triangles, (unsigned)count, (unsigned)leaves, (double)children / count);
  course_figure("tree.triangles", "%u", (unsigned)scene.triangles);
  course_figure("tree.nodes", "%u", (unsigned)count);
  course_figure("tree.leaves", "%u", (unsigned)leaves);
  course_figure("tree.children", "%.2f", (double)children / count);

  draw_section(&scene, nodes);
  draw_heat(&scene, nodes, library);
  print_page(library);
  pktrt_scene_destroy(library);
  return 0;
}
