/* Chapter 2: a binary tree of boxes over the triangles, split at the median.
   Makes out/course/02_heat.png and 02_tree.svg, and prints tests per ray.

     cc -O2 examples/course/02_bvh.c -o bvh -lm && ./bvh */
#define PKTRT_IMPLEMENTATION
#include "course.h"
#include "../svg.h"

/* [tree] */
enum { LEAF = 4 }; /* triangles of a leaf, at most */

typedef struct node {
  course_box box;        /* around all triangles of the subtree */
  uint32_t first, count; /* the triangles of the subtree: order[first] and so on */
  uint32_t child[2];     /* 0, 0: the node is a leaf */
} node;

typedef uint32_t split(const course_box *box, uint32_t *order, uint32_t count);

typedef struct tree {
  const course_scene *scene;
  course_box *box; /* of each triangle */
  uint32_t *order; /* the triangles, leaf by leaf */
  node *node;      /* 0 is the root */
  uint32_t nodes;
} tree;
/* [end] */

/* [build] */
/* Builds the subtree over `count` triangles of the order, and returns the index of its root. `divide` sorts the
   triangles and returns how many of them go to the left child. */
static uint32_t build(tree *t, split *divide, uint32_t first, uint32_t count) {
  const uint32_t me = t->nodes++;
  node n = {course_box_empty(), first, count, {0, 0}};
  for (uint32_t i = first; i < first + count; i++)
    n.box = course_box_grow(n.box, t->box[t->order[i]].lo, t->box[t->order[i]].hi);
  if (count > LEAF) {
    const uint32_t left = divide(t->box, t->order + first, count);
    n.child[0] = build(t, divide, first, left);
    n.child[1] = build(t, divide, first + left, count - left);
  }
  t->node[me] = n;
  return me;
}
/* [end] */

/* Returns a tree over all triangles of the scene. */
static tree tree_make(const course_scene *scene, split *divide) {
  const uint32_t n = scene->triangles;
  tree t = {scene, (course_box *)course_memory(n, sizeof *t.box), (uint32_t *)course_memory(n, sizeof *t.order),
      (node *)course_memory(2 * n, sizeof *t.node), 0};
  for (uint32_t i = 0; i < n; i++) {
    t.order[i] = i;
    t.box[i] = course_box_of(scene, i);
  }
  build(&t, divide, 0, n);
  return t;
}

/* [walk] */
typedef struct work {
  uint64_t boxes, triangles; /* tests */
} work;

/* Returns true if the ray meets the box before t = far. On each axis the ray is between the two planes from one t to
   another; the sign of the direction tells which plane the ray crosses first. */
static bool meet_box(const course_box *b, const course_ray *ray, float far) {
  float near = ray->tmin;
  for (int a = 0; a < 3; a++) {
    const float inverse = 1 / ray->direction.at[a], o = ray->origin.at[a];
    const float lo = (b->lo.at[a] - o) * inverse, hi = (b->hi.at[a] - o) * inverse;
    near = fmaxf(near, signbit(inverse) ? hi : lo);
    far = fminf(far, (signbit(inverse) ? lo : hi) * 1.0000005f); /* for six roundings */
  }
  return near <= far;
}

/* Finds the nearest hit of a ray in a subtree, if the hit is nearer than *hit. */
static void walk(const tree *t, uint32_t index, const course_ray *ray, course_hit *hit, work *w) {
  const node *n = &t->node[index];
  w->boxes++;
  if (!meet_box(&n->box, ray, hit->t)) return;
  for (int i = 0; i < 2 && n->child[0]; i++) walk(t, n->child[i], ray, hit, w);
  if (n->child[0]) return;
  w->triangles += n->count;
  for (uint32_t i = n->first; i < n->first + n->count; i++) course_meet(t->scene, ray, t->order[i], hit);
}
/* [end] */

/* [median] */
/* Sorts the triangles by their boxes' centres along the axis on which the centres are spread the most. Returns half of
   their number. */
static uint32_t split_median(const course_box *box, uint32_t *order, uint32_t count) {
  course_box centres = course_box_empty();
  int axis = 0;
  for (uint32_t i = 0; i < count; i++) {
    const vec centre = vec_scale(vec_add(box[order[i]].lo, box[order[i]].hi), 0.5f);
    centres = course_box_grow(centres, centre, centre);
  }
  const vec size = vec_sub(centres.hi, centres.lo);
  for (int a = 1; a < 3; a++)
    if (size.at[a] > size.at[axis]) axis = a;
  course_sort(box, axis, order, count);
  return count / 2;
}
/* [end] */

/* Draws a subtree. Above: the width of a node is its number of triangles, and a node is the redder the larger the ratio
   of its box's area to its parent's. Below: the boxes of every second level from above. */
static void draw(const tree *t, svg *s, uint32_t index, uint32_t parent, int level) {
  const node *n = &t->node[index];
  const double wide = 860.0 / t->scene->triangles, left = 20 + wide * n->first, top = 8 + 22 * level;
  const double x = 120 + 110 * (level - 1), z = 310, scale = 11.2; /* of a panel: its middle, and pixels per unit */
  const int pale = (int)(255 * (1 - (double)(course_box_area(n->box) / course_box_area(t->node[parent].box))));
  char colour[8];
  snprintf(colour, sizeof colour, "#ff%02x%02x", (unsigned)pale, (unsigned)pale);
  svg_box(s, left, top, left + wide * n->count, top + 18, colour, "#444");
  if (level % 2)
    svg_box(s, x + scale * (double)n->box.lo.at[0], z + scale * (double)n->box.lo.at[2],
        x + scale * (double)n->box.hi.at[0], z + scale * (double)n->box.hi.at[2], NULL, "#05a");
  for (int i = 0; i < 2 && n->child[0] && level < 7; i++) draw(t, s, n->child[i], index, level + 1);
}

/* Draws the tree. Returns false if the file cannot be written. */
static bool draw_tree(const tree *t, const char *path) {
  svg s;
  if (!svg_begin(&s, path, 900, 450)) return false;
  draw(t, &s, 0, 0, 0);
  for (int i = 0; i < 4; i++) svg_text(&s, 120 + 220 * i, 440, 15, SVG_MIDDLE, "level %d, from above", 2 * i + 1);
  return svg_end(&s);
}

#ifndef COURSE_CHECK /* a check includes this file and has its own main */
int main(void) {
  enum { WIDTH = 256, HEIGHT = 192, RAYS = WIDTH * HEIGHT, WHITE = 210 /* box tests */ };
  course_scene scene = course_scene_make();
  pktrt_scene *library = course_library(&scene);
  tree t = tree_make(&scene, split_median);
  course_picture picture = course_picture_make(WIDTH, HEIGHT);
  course_tally tally = {0, 0, 0};
  work all = {0, 0};
  static uint32_t boxes[RAYS], triangle[RAYS]; /* tests of each ray, and what it hits */
  for (uint32_t i = 0; i < RAYS; i++) {
    const course_ray ray = course_camera_ray((float)(i % WIDTH) + 0.5f, (float)(i / WIDTH) + 0.5f, WIDTH, HEIGHT);
    course_hit hit = {ray.tmax, 0, 0, COURSE_NONE}, theirs = course_library_hit(library, ray);
    work one = {0, 0};
    walk(&t, 0, &ray, &hit, &one);
    boxes[i] = (uint32_t)one.boxes;
    triangle[i] = hit.triangle;
    all.boxes += one.boxes;
    all.triangles += one.triangles;
    course_same_hit(&scene, ray, &hit, &theirs, &tally);
    picture.pixel[i] = course_heat((float)one.boxes / WHITE);
  }
  course_picture_write_double(&picture, "out/course/02_heat.png");
  if (!draw_tree(&t, "out/course/02_tree.svg")) return 1;
  printf("02_bvh: %u triangles, %u nodes; a ray is tested against %.1f boxes and %.1f triangles\n",
      (unsigned)scene.triangles, (unsigned)t.nodes, (double)all.boxes / RAYS, (double)all.triangles / RAYS);
  course_tally_print(&tally);
  course_print_by_hit(boxes, triangle, RAYS);
  course_figure("triangles", "%u", (unsigned)scene.triangles);
  course_figure("tests", "%.1f", (double)(all.boxes + all.triangles) / RAYS);
  course_figure("heat.blue", "%u", WHITE / 3);
  course_figure("heat.orange", "%u", 2 * WHITE / 3);
  course_figure("heat.white", "%u", WHITE);
  pktrt_scene_destroy(library);
  return tally.different != 0;
}
#endif
