/* Checks exercise 14: boxes over intervals of time hold what moves and are not much larger; refitted boxes are those of
   their triangles, number by number; rays through both find the library's hits. Each part has a control. */
#define PKTRT_IMPLEMENTATION
#include "14_exercise.h"

enum { CASES = 100000, TIMES = 8, PACKETS = 400, EACH = 16 };

static uint32_t state = 14;

/* Returns a random number between two. */
static float between(float low, float high) { return low + (high - low) * course_random(&state); }

/* >>boxes ---------------------------------------------------------------------------------------------------------- */

/* What was found wrong with boxes. */
typedef struct box_tally {
  uint64_t cases, lost, rounded, large; /* rounded: corners lost by no more than the tolerance */
} box_tally;

/* Returns boxes at two keys: at all scales, at rest or in motion, some through 0. */
static void make_keys(int number, course_box key[2]) {
  const float scale = ldexpf(1, number % 21 - 10);

  for (int axis = 0; axis < 3; axis++) {
    const float step = number % 5 ? between(-4, 4) : 0;
    const float place = number % 3 ? between(-9, 9) : -step / 2;
    const float size = between(0, 2), grown = number % 5 ? between(0, 2) : size;
    key[0].lo.at[axis] = scale * place;
    key[0].hi.at[axis] = scale * (place + size);
    key[1].lo.at[axis] = scale * (place + step);
    key[1].hi.at[axis] = scale * (place + step + grown);
  }
}

/* Prints a box that was judged along an axis. */
static void say_box(int number, int axis, const course_box key[2], float begin, float end, const course_box *box) {
  printf("case %d, %c: from %.9g to %.9g at key 0, from %.9g to %.9g at key 1; begin %.9g, end %.9g\n", number,
      "xyz"[axis], (double)key[0].lo.at[axis], (double)key[0].hi.at[axis], (double)key[1].lo.at[axis],
      (double)key[1].hi.at[axis], (double)begin, (double)end);
  printf("  got: from %.9g to %.9g\n", (double)box->lo.at[axis], (double)box->hi.at[axis]);
}

/* Judges one box along one axis, and counts. */
static void judge_axis(box_tally *tally, int number, int axis, const course_box key[2], const float time[TIMES],
    const course_box *box, bool aloud) {
  const float low[2] = {key[0].lo.at[axis], key[1].lo.at[axis]}, high[2] = {key[0].hi.at[axis], key[1].hi.at[axis]};
  const double begin = (double)time[0], end = (double)time[1];
  const double largest = (double)fmaxf(fmaxf(fabsf(low[0]), fabsf(low[1])), fmaxf(fabsf(high[0]), fabsf(high[1])));
  const double tolerance = ldexp(largest, -20);
  double least = INFINITY, most = -INFINITY;

  for (int i = 0; i < TIMES; i++) {
    const float lower = motion_mix(low[0], low[1], time[i]), upper = motion_mix(high[0], high[1], time[i]);
    if (box->lo.at[axis] <= lower && box->hi.at[axis] >= upper) continue;
    const double escape = fmax((double)box->lo.at[axis] - (double)lower, (double)upper - (double)box->hi.at[axis]);
    if (aloud && !tally->lost && !tally->rounded && !tally->large) {
      say_box(number, axis, key, time[0], time[1], box);
      printf("  expected: a box that holds corners at %.9g and %.9g, where they are at time %.9g\n", (double)lower,
          (double)upper, (double)time[i]);
    }
    if (escape <= tolerance) tally->rounded++;
    else tally->lost++;
    return;
  }

  for (int i = 0; i < 2; i++) {
    const double t = i ? end : begin;
    least = fmin(least, (1 - t) * (double)low[0] + t * (double)low[1]);
    most = fmax(most, (1 - t) * (double)high[0] + t * (double)high[1]);
  }

  if ((double)box->lo.at[axis] >= least - tolerance && (double)box->hi.at[axis] <= most + tolerance) return;
  if (tally->large++ || tally->lost || tally->rounded || !aloud) return;
  say_box(number, axis, key, time[0], time[1], box);
  printf("  expected: nothing below %.9g or above %.9g\n", least - tolerance, most + tolerance);
}

/* A number at both keys, an interval of time, and a time in between at which rounding takes the number out of the
   interval of its ends by much: by 3.97, 3.76, 3.56, 1.98 and 1.96 roundings of 2^-24. */
static const float hard[][5] = {{0x1.01b7fap-4f, 0x1.01b7fap-4f, 0x1.1a1052p-2f, 0x1.1b4f32p-2f, 0x1.1a6746p-2f},
    {0x1.101aaap-2f, 0x1.104172p-2f, 0x1.f40d4ap-2f, 0x1.f40d62p-2f, 0x1.f40d5ep-2f},
    {0x1.032beap-1f, 0x1.1f94c8p-1f, 0x1.ce3582p-2f, 0x1.ce3592p-2f, 0x1.ce3586p-2f},
    {0x1.bd70dp-1f, 0x1.01d204p+0f, 0x1.fff854p-1f, 0x1.fff8aap-1f, 0x1.fff89cp-1f},
    {0x1.0510a4p-1f, 0x1.2c4edcp-5f, 0x1.4cfdcap-6f, 0x1.4cfde4p-6f, 0x1.4cfdd4p-6f}};

enum { HARD = 10 }; /* each with either sign */

/* Returns flat boxes at a hard number. */
static void make_hard_keys(int number, course_box key[2], float time[TIMES]) {
  const float *given = hard[number / 2];

  for (int k = 0; k < 2; k++) {
    const float place = number % 2 ? -given[k] : given[k];
    key[k].lo = vec_make(place, place, place);
    key[k].hi = key[k].lo;
  }

  for (int i = 0; i < TIMES; i++) time[i] = given[i == 0 ? 2 : i == 1 ? 3 : 4];
}

/* Chooses an interval, and times in it. */
static void make_times(int number, float time[TIMES]) {
  time[0] = number % 7 ? course_random(&state) : 0;
  time[1] = number % 11 ? between(time[0], 1) : 1;
  if (number % 4 == 0) time[1] = time[0];
  if (number % 4 == 1) time[1] = fminf(time[1], time[0] + 0.01f);
  for (int i = 2; i < TIMES; i++) time[i] = fminf(fmaxf(between(time[0], time[1]), time[0]), time[1]);
}

/* Judges a rule of boxes; says what is wrong first, if aloud. */
static box_tally judge_boxes(motion_rule *rule, bool aloud) {
  box_tally tally = {0, 0, 0, 0};
  state = 14;

  for (int number = 0; number < CASES; number++) {
    course_box key[2];
    float time[TIMES];

    if (number < CASES - HARD) {
      make_keys(number, key);
      make_times(number, time);
    } else make_hard_keys(number - (CASES - HARD), key, time);

    const course_box box = rule(key, time[0], time[1]);
    for (int axis = 0; axis < 3; axis++) judge_axis(&tally, number, axis, key, time, &box, aloud);
    tally.cases++;
  }

  return tally;
}

/* A control: the boxes at both ends united, in floats and without a margin. */
static course_box careless_box(const course_box key[2], float begin, float end) {
  course_box box;

  for (int axis = 0; axis < 3; axis++) {
    const float lo0 = key[0].lo.at[axis], lo1 = key[1].lo.at[axis];
    const float hi0 = key[0].hi.at[axis], hi1 = key[1].hi.at[axis];
    box.lo.at[axis] = fminf(motion_mix(lo0, lo1, begin), motion_mix(lo0, lo1, end));
    box.hi.at[axis] = fmaxf(motion_mix(hi0, hi1, begin), motion_mix(hi0, hi1, end));
  }

  return box;
}

/* A control: the box over the whole time. */
static course_box whole_box(const course_box key[2], float begin, float end) {
  (void)begin;
  (void)end;
  return course_box_grow(key[0], key[1].lo, key[1].hi);
}

/* Returns what is wrong with the boxes of the answer, or NULL. */
static const char *check_boxes(void) {
  const box_tally careless = judge_boxes(careless_box, false);
  const box_tally whole = judge_boxes(whole_box, false);
  const box_tally mine = judge_boxes(motion_box, true);
  printf(
      "%u boxes, three axes each: %u lose corners, %u more lose corners by rounding, %u are larger than they may be\n",
      (unsigned)mine.cases, (unsigned)mine.lost, (unsigned)mine.rounded, (unsigned)mine.large);
  course_figure("boxes", "%u", (unsigned)mine.cases);
  printf("control: without a margin %u lose corners by rounding; boxes over the whole time: %u are too large\n",
      (unsigned)careless.rounded, (unsigned)whole.large);
  if (!careless.rounded || careless.lost || !whole.large) return "the control fails: the check of boxes sees nothing";
  if (mine.lost) return "a box does not hold what moves from begin to end";
  if (mine.rounded) return "a box loses corners by rounding: the margin is absent or too small";
  return mine.large ? "a box is larger than it may be: is it that of the interval, with a small margin?" : NULL;
}

/* >>refit ---------------------------------------------------------------------------------------------------------- */

static uint64_t asked[2]; /* calls of motion_triangle_box, by key */

course_box motion_triangle_box(const motion_scene *scene, uint32_t triangle, int key) {
  if (key < 0 || key > 1 || triangle >= scene->at[0].triangles) {
    printf("chapter 14: failed: motion_triangle_box is asked for triangle %u at key %d\n", (unsigned)triangle, key);
    exit(1);
  }

  asked[key]++;
  return course_box_of(&scene->at[key], triangle);
}

/* Returns true if two boxes have the same numbers. */
static bool same_box(const course_box *one, const course_box *other) {
  for (int axis = 0; axis < 3; axis++)
    if (!(one->lo.at[axis] == other->lo.at[axis] && one->hi.at[axis] == other->hi.at[axis])) return false;

  return true;
}

/* Returns true if one box holds another. */
static bool holds_box(const course_box *one, const course_box *other) {
  for (int axis = 0; axis < 3; axis++)
    if (!(one->lo.at[axis] <= other->lo.at[axis] && one->hi.at[axis] >= other->hi.at[axis])) return false;

  return true;
}

/* Returns a copy of a tree, with arrays of its own. */
static motion_tree copy_tree(const motion_tree *tree, uint32_t triangles) {
  motion_tree copy = *tree;
  copy.order = (uint32_t *)course_memory(triangles, sizeof *copy.order);
  copy.node = (motion_node *)course_memory(tree->nodes, sizeof *copy.node);
  memcpy(copy.order, tree->order, triangles * sizeof *copy.order);
  memcpy(copy.node, tree->node, tree->nodes * sizeof *copy.node);
  return copy;
}

/* Prints three numbers. */
static void say_vec(const char *before, const float v[3]) {
  printf("%s(%.9g, %.9g, %.9g)", before, (double)v[0], (double)v[1], (double)v[2]);
}

/* Returns what is wrong with a refitted tree, or NULL; says where, if aloud. `old` is the tree before. */
static const char *judge_tree(const motion_tree *tree, const motion_tree *old, const motion_scene *scene, bool aloud) {
  const uint32_t triangles = scene->at[0].triangles;
  if (tree->nodes != old->nodes || memcmp(tree->order, old->order, triangles * sizeof *tree->order))
    return "the refit has changed order or the number of nodes, which are the shape of the tree";

  for (uint32_t i = tree->nodes; i-- > 0;) {
    const motion_node *node = &tree->node[i];
    const motion_node *before = &old->node[i];
    if (node->first != before->first || node->count != before->count || node->child[0] != before->child[0] ||
        node->child[1] != before->child[1])
      return "the refit has changed first, count or child of a node, which are the shape of the tree";

    for (int key = 0; key < 2; key++) {
      const course_box right = motion_range_box(tree, scene, i, key);
      const course_box *got = &node->key[key];
      if (same_box(got, &right)) continue;

      if (aloud) {
        printf("node %u, %s of %u triangles, key %d", (unsigned)i, node->child[0] ? "an inner node" : "a leaf",
            (unsigned)node->count, key);
        say_vec("\n  expected: ", right.lo.at);
        say_vec(" to ", right.hi.at);
        say_vec("\n  got: ", got->lo.at);
        say_vec(" to ", got->hi.at);
        printf("\n");
      }

      if (same_box(got, &before->key[key]))
        return "a box is that of before the refit: are both keys fitted, and children before their parents?";
      if (holds_box(got, &right)) return "a box is larger than its triangles: with what does it begin to grow?";
      return "a box does not hold its triangles: are all of a leaf's triangles, both children, and both keys in use, "
             "and children fitted before their parents?";
    }
  }

  return NULL;
}

/* Moves the flakes of a scene to new places at both keys. */
static void blow_both(const motion_scene *rest, motion_scene *scene, double angle) {
  for (int key = 0; key < 2; key++) {
    scene->at[key] = rest->at[0];
    scene->at[key].position = (vec *)course_memory(rest->at[0].vertices, sizeof(vec));
    motion_blow(&rest->at[0], angle + 0.2 * key, key == 1, scene->at[key].position);
  }
}

/* Refits a tree by the answer to things that have moved; returns what is wrong, or NULL. */
static const char *check_refit(motion_tree *tree, const motion_scene *scene) {
  const uint32_t triangles = scene->at[0].triangles;
  const motion_tree old = copy_tree(tree, triangles);
  asked[0] = 0;
  asked[1] = 0;
  motion_refit(tree, scene);

  const uint64_t calls[2] = {asked[0], asked[1]};
  const char *wrong = judge_tree(tree, &old, scene, true);
  printf("refit of %u nodes over %u triangles: triangles' boxes asked for %u times at key 0, %u times at key 1\n",
      (unsigned)tree->nodes, (unsigned)triangles, (unsigned)calls[0], (unsigned)calls[1]);
  if (wrong) return wrong;
  if (calls[0] > triangles || calls[1] > triangles)
    return "the refit asks for a triangle's box more than once at a key: the box of an inner node follows from its "
           "children";

  motion_tree off = copy_tree(tree, triangles);
  course_box *box = &off.node[off.nodes / 2].key[1];
  box->hi.at[1] = nextafterf(box->hi.at[1], INFINITY);
  const bool seen = judge_tree(&off, &old, scene, false) && judge_tree(&old, &old, scene, false);
  return seen ? NULL : "the control fails: the check of refits sees nothing";
}

/* >>hits ----------------------------------------------------------------------------------------------------------- */

/* Makes a ray from the camera, or between two places. */
static course_ray make_ray(int packet) {
  if (packet % 2) return course_camera_ray(between(0, 256), between(0, 192), 256, 192);
  const vec from = vec_make(between(-4, 4), between(-1, 5), between(-4, 4));
  const vec to = vec_make(between(-3, 3), between(0, 3), between(-3, 3));
  const course_ray ray = {from, vec_sub(to, from), 0, INFINITY};
  return ray;
}

/* Stores the scene as it is at a time. */
static void pose(const motion_scene *scene, float time, course_scene *now) {
  for (uint32_t i = 0; i < now->vertices; i++) now->position[i] = motion_vertex(scene, i, time);
}

/* Sends packets through a tree and the library; boxes are those of the packet's interval of time. Returns how many
   rays differ. */
static course_tally compare_hits(
    const motion_scene *scene, const motion_tree *tree, const pktrt_scene *library, motion_rule *rule, bool aloud) {
  course_tally tally = {0, 0, aloud ? 0 : 1}; /* the first difference is printed */
  course_scene now = scene->at[0];
  now.position = (vec *)course_memory(now.vertices, sizeof *now.position);
  state = 41;

  for (int packet = 0; packet < PACKETS; packet++) {
    const float begin = course_random(&state), end = packet % 3 ? between(begin, 1) : begin;

    for (int i = 0; i < EACH; i++) {
      const course_ray ray = make_ray(packet);
      const float time = fminf(fmaxf(between(begin, end), begin), end);
      motion_walk walk = {scene, tree, rule, ray, time, begin, end, {ray.tmax, 0, 0, COURSE_NONE}, 0};
      pktrt_ray theirs = course_library_ray(ray);
      pktrt_hit hit;
      theirs.time = time;
      motion_walk_node(&walk, 0);
      pktrt_intersect(library, &theirs, &hit);

      const course_hit expected = {hit.t, hit.u, hit.v, hit.triangle};
      pose(scene, time, &now);
      const uint64_t before = tally.different;
      course_same_hit(&now, ray, &walk.hit, &expected, &tally);
      if (aloud && before == 0 && tally.different)
        printf("  the ray's time is %.9g, its packet's interval from %.9g to %.9g\n", (double)time, (double)begin,
            (double)end);
    }
  }

  if (!aloud) tally.different--;
  free(now.position);
  return tally;
}

/* Returns what is wrong with hits in the answer's tree, or NULL. `stale` is the tree before the refit. */
static const char *check_hits(
    const motion_scene *rest, const motion_scene *scene, const motion_tree *tree, const motion_tree *stale) {
  pktrt_scene *library = pktrt_scene_create(NULL);
  motion_add(library, rest);
  if (pktrt_commit(library)) return "the library has no tree";

  for (uint32_t key = 0; key < 2; key++) pktrt_set_positions(library, 0, key, scene->at[key].position[0].at);

  if (pktrt_refit(library)) return "the library does not refit";
  const course_tally control = compare_hits(scene, stale, library, careless_box, false);
  course_tally mine = compare_hits(scene, tree, library, motion_box, true);
  course_tally_print(&mine);
  course_figure("rays", "%u", (unsigned)mine.rays);
  printf("control: in the tree before the refit %u of %u rays find another hit\n", (unsigned)control.different,
      (unsigned)control.rays);
  pktrt_scene_destroy(library);
  if (!control.different) return "the control fails: the check of hits sees nothing";
  return mine.different ? "a ray finds another hit than in the library" : NULL;
}

/* Checks boxes, then refits, then hits; stops at the first that is wrong. */
int main(void) {
  course_check_begins(14);
  const char *boxes = check_boxes();
  if (boxes) return course_result(14, boxes);

  const motion_scene rest = motion_flakes();
  const motion_scene things = motion_things(COURSE_TURN / 6);
  const motion_scene turned = motion_things(COURSE_TURN / 3);
  motion_scene blown;
  motion_tree tree = motion_build(&things);
  motion_tree flakes = motion_build(&rest);
  const motion_tree stale = copy_tree(&flakes, rest.at[0].triangles);
  blow_both(&rest, &blown, 0.8);

  const char *refit = check_refit(&tree, &turned);
  if (!refit) refit = check_refit(&flakes, &blown);
  if (refit) return course_result(14, refit);
  return course_result(14, check_hits(&rest, &blown, &flakes, &stale));
}
