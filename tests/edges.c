/* Rays that leave points at edges and corners: they start inside, in front of the walls that stand there. */
#include "noslack.h"

/* The library, and the copy that leaves edges where they are: the control. */
typedef struct library {
  pktrt_scene *(*open)(const world *, pktrt_isa);
  pktrt_scene *(*place)(const placement *, pktrt_isa);
  void (*spawn)(const pktrt_scene *, const pktrt_ray *, const pktrt_hit *, const float direction[3], pktrt_ray *);
  void (*spawn_at)(const pktrt_scene *, uint32_t mesh, uint32_t triangle, float u, float v, float time,
      const float direction[3], pktrt_ray *);
  void (*intersect)(const pktrt_scene *, const pktrt_query_desc *, const pktrt_ray *, pktrt_hit *, size_t n);
  void (*close)(pktrt_scene *);
} library;

static pktrt_scene *open_whole(const world *w, pktrt_isa isa) { return world_scene(w, isa, 0); }
static pktrt_scene *place_whole(const placement *p, pktrt_isa isa) {
  const pktrt_scene_desc d = scene_desc_of(isa, 0);
  pktrt_scene *s = pktrt_scene_create(&d);
  CHECK(placement_fill(s, p), "%s", pktrt_last_error(s));
  return s;
}
static const library whole = {
    open_whole, place_whole, pktrt_spawn, pktrt_spawn_at, pktrt_intersect_ex, pktrt_scene_destroy};
static const library control = {
    noslack_scene, noslack_placed, noslack_spawn, noslack_spawn_at, noslack_intersect, noslack_destroy};

/* --- convex bodies --- */

enum { BODY_KINDS = 9, MOST_CORNERS = 8, MOST_FACES = 12 };
typedef struct body {
  uint32_t corners, faces;
  double p[MOST_CORNERS][3];
  uint32_t face[MOST_FACES][3]; /* counter-clockwise from outside */
} body;

static void add_face(body *b, uint32_t i, uint32_t k, uint32_t n) {
  const uint32_t face[3] = {i, k, n};

  memcpy(b->face[b->faces++], face, sizeof face);
}

/* Makes a prism over a polygon of four corners, one below the other; a wedge where their angle at corner 0 is small. */
static void make_prism(body *b, double section[4][2]) {
  b->corners = 8;
  for (uint32_t i = 0; i < 8; i++) {
    b->p[i][0] = section[i % 4][0];
    b->p[i][1] = section[i % 4][1];
    b->p[i][2] = i < 4 ? -0.5 : 0.5;
  }

  add_face(b, 0, 2, 1);
  add_face(b, 0, 3, 2);
  add_face(b, 4, 5, 6);
  add_face(b, 4, 6, 7);
  for (uint32_t i = 0; i < 4; i++) {
    const uint32_t next = (i + 1) % 4;

    add_face(b, i, next, next + 4);
    add_face(b, i, next + 4, i + 4);
  }
}

/* Makes a tetrahedron, a box, or a wedge of 10.2 to 170 degrees. */
static body make_body(rng *r, int kind) {
  static const double degrees[BODY_KINDS] = {0, 0, 10.2, 20, 45, 90, 120, 150, 170};
  static const double tetrahedron[4][3] = {{1, 1, 1}, {-1, -1, 1}, {-1, 1, -1}, {1, -1, -1}};
  body b;
  memset(&b, 0, sizeof b);

  if (kind == 0) {
    b.corners = 4;
    for (uint32_t i = 0; i < 4; i++)
      for (int a = 0; a < 3; a++) b.p[i][a] = tetrahedron[i][a] + 0.3 * (double)rng_sign(r);
    add_face(&b, 0, 2, 1);
    add_face(&b, 0, 1, 3);
    add_face(&b, 0, 3, 2);
    add_face(&b, 1, 2, 3);
  } else if (kind == 1) {
    const double wide = (double)rng_range(r, 0.3f, 1);
    double section[4][2] = {{0, 0}, {wide, 0}, {wide, 1}, {0, 1}};
    make_prism(&b, section);
  } else {
    const double w = degrees[kind] * 0.017453292519943295;
    double section[4][2] = {{0, 0}, {1, 0}, {1.5 * cos(w / 2), 1.5 * sin(w / 2)}, {cos(w), sin(w)}};
    make_prism(&b, section);
  }

  return b;
}

/* Computes the cross product of two edges of a face, outwards; returns its length. */
static double outwards_of(double p[MOST_CORNERS][3], const uint32_t face[3], double n[3]) {
  double e[2][3];
  for (int i = 0; i < 2; i++)
    for (int a = 0; a < 3; a++) e[i][a] = p[face[i + 1]][a] - p[face[0]][a];
  for (int a = 0; a < 3; a++) n[a] = e[0][(a + 1) % 3] * e[1][(a + 2) % 3] - e[0][(a + 2) % 3] * e[1][(a + 1) % 3];
  return sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
}

/* Returns true if no two faces that share a corner meet at less than 10 degrees. */
static bool is_blunt(const body *b, double p[MOST_CORNERS][3]) {
  for (uint32_t i = 0; i < b->faces; i++)
    for (uint32_t k = 0; k < i; k++) {
      double m[3], n[3];
      bool share = false;
      for (int c = 0; c < 9; c++) share = share || b->face[i][c / 3] == b->face[k][c % 3];
      const double length = outwards_of(p, b->face[i], m) * outwards_of(p, b->face[k], n);
      if (share && -(m[0] * n[0] + m[1] * n[1] + m[2] * n[2]) > 0.98480775 * length) return false;
    }
  return true;
}

static void random_turn(rng *r, double m[3][3]) {
  double q[4], n = 0;
  for (int i = 0; i < 4; i++) {
    q[i] = (double)(rng_sign(r) + rng_sign(r) + rng_sign(r));
    n += q[i] * q[i];
  }
  for (int i = 0; i < 4; i++) q[i] /= sqrt(n);
  for (int a = 0; a < 3; a++)
    for (int c = 0; c < 3; c++) {
      const int k = 3 - a - c; /* the third axis, where two differ */
      const double sign = (c - a + 3) % 3 == 1 ? -1 : 1;
      m[a][c] =
          a == c ? 1 - 2 * (1 - q[0] * q[0] - q[a + 1] * q[a + 1]) : 2 * (q[a + 1] * q[c + 1] + sign * q[0] * q[k + 1]);
    }
}

/* --- a body in a scene --- */

typedef enum setting { AT_REST, TWO_MESHES, MOVING, TURNED, UNEVEN, SETTINGS } setting;
static const char *const setting_names[SETTINGS] = {
    "a mesh", "two meshes", "moving", "an instance", "an uneven instance"};

typedef struct room {
  body b;
  world w;                    /* of one or two meshes; directly in the scene */
  placement placed;           /* or of one instance */
  bool instance;              /* which of both it is */
  uint32_t of[MOST_FACES][2]; /* mesh and triangle of each face */
  double p[MOST_CORNERS][3];  /* where corners are at `time` */
  float time;
} room;

static void round_corners(const body *b, double turn[3][3], double scale, const double shift[3], float *out) {
  for (uint32_t i = 0; i < b->corners; i++)
    for (int a = 0; a < 3; a++)
      out[3 * i + (uint32_t)a] =
          (float)(scale * (turn[a][0] * b->p[i][0] + turn[a][1] * b->p[i][1] + turn[a][2] * b->p[i][2]) + shift[a]);
}

/* Makes a body of 1e-3 to 1e6 in size, turned, up to 100 times its size away from the origin. False where its faces meet
   too sharply in the end. */
static bool make_room(rng *r, int kind, setting how, room *x) {
  memset(x, 0, sizeof *x);
  x->b = make_body(r, kind);
  x->instance = how >= TURNED;
  x->time = how == MOVING ? rng_unit(r) : 0;

  double turn[3][3], still[3][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, shift[3], none[3] = {0, 0, 0};
  const double scale = pow(10, (double)rng_range(r, -3, 6));
  const double away = rng_below(r, 3) ? scale * pow(10, (double)rng_range(r, -1, 2)) : 0;
  random_turn(r, turn);
  if (rng_below(r, 4) == 0) memcpy(turn, still, sizeof turn);
  for (int a = 0; a < 3; a++) shift[a] = away * (double)rng_sign(r);

  mesh whole_body = mesh_of(x->b.corners, x->b.faces);
  memcpy(whole_body.i, x->b.face, x->b.faces * sizeof x->b.face[0]);
  if (x->instance) round_corners(&x->b, turn, 1, none, whole_body.p);
  else round_corners(&x->b, turn, scale, shift, whole_body.p);
  for (uint32_t i = 0; i < x->b.faces; i++) x->of[i][1] = i;

  if (how == MOVING) mesh_move(&whole_body, 2, 0.3f, 0, rng_u32(r));
  for (uint32_t i = 0; i < x->b.corners; i++) {
    float at[3];
    ref_vertex(&whole_body, i, x->time, at);
    for (int a = 0; a < 3; a++) x->p[i][a] = (double)at[a];
  }

  if (x->instance) {
    x->placed.models = x->placed.n = 1;
    x->placed.model[0] = world_of(whole_body);
    x->placed.keys[0] = 1;
    random_turn(r, turn);
    for (int a = 0; a < 3; a++) {
      const double sign = rng_below(r, 4) ? 1 : -1,
                   uneven = how == UNEVEN ? pow(10, (double)rng_range(r, -0.5f, 0.5f)) : 1;
      for (int c = 0; c < 3; c++) x->placed.transform[0][4 * c + a] = (float)(sign * uneven * scale * turn[c][a]);
      x->placed.transform[0][4 * a + 3] = (float)shift[a];
    }
    for (uint32_t i = 0; i < x->b.corners; i++) {
      double q[3];
      memcpy(q, x->p[i], sizeof q);
      for (int a = 0; a < 3; a++) {
        const float *row = x->placed.transform[0] + 4 * a;
        x->p[i][a] = (double)row[0] * q[0] + (double)row[1] * q[1] + (double)row[2] * q[2] + (double)row[3];
      }
    }
  } else {
    x->w = world_of(whole_body);
  }

  if (how == TWO_MESHES) { /* every other face goes to the second */
    mesh *m = x->w.m;
    m[1] = mesh_of(x->b.corners, x->b.faces / 2);
    memcpy(m[1].p, m[0].p, x->b.corners * 12);
    for (uint32_t i = 0; i < x->b.faces; i++) {
      x->of[i][0] = i % 2;
      x->of[i][1] = i / 2;
      memmove(m[i % 2].i + 3 * (i / 2), x->b.face[i], 12);
    }
    m[0].nt = x->b.faces - m[1].nt;
    x->w.n = 2;
  }

  return is_blunt(&x->b, x->p);
}

static void free_room(room *x) {
  if (x->instance) world_free(&x->placed.model[0]);
  else world_free(&x->w);
}

/* Returns a direction that leads inside from a face. */
static void direction_inside(rng *r, room *x, uint32_t face, float d[3]) {
  double n[3], along, middle = 0, length;
  do {
    const float size = powf(10, rng_range(r, -3, 3));
    for (int a = 0; a < 3; a++) d[a] = size * rng_sign(r);
    length = outwards_of(x->p, x->b.face[face], n) * (double)size;
    along = (n[0] * (double)d[0] + n[1] * (double)d[1]) + n[2] * (double)d[2];
  } while (fabs(along) < 1e-3 * length);

  for (uint32_t i = 0; i < x->b.corners; i++) /* a mirror turns faces round */
    for (int a = 0; a < 3; a++) middle += n[a] * (x->p[i][a] - x->p[x->b.face[face][0]][a]);
  for (int a = 0; a < 3 && (along > 0) != (middle > 0); a++) d[a] = -d[a];
}

typedef struct escapes {
  size_t rays, out, touching; /* touching: rays from inside that met the point of an edge they were aimed at */
} escapes;

enum { EDGE_POINTS = 12 };
static const double edge_points[EDGE_POINTS][2] = {{0, 0}, {1, 0}, {0, 1}, {0.5, 0}, {0, 0.5}, {0.5, 0.5}, {1 / 3.0, 0},
    {0, 0.7}, {0.25, 0.75}, {0.1, 0.9}, {1 / 3.0, 2 / 3.0}, {0.3, 0.3}};

/* Counts rays that leave corners and edges of a room to its inside, and meet nothing. */
static void leave_points(const library *l, const pktrt_scene *s, rng *r, room *x, escapes *e) {
  const pktrt_query_desc single = {0};
  for (uint32_t i = 0; i < x->b.faces; i++)
    for (int k = 0; k < EDGE_POINTS; k++) {
      float d[3];
      pktrt_ray ray;
      pktrt_hit hit;
      direction_inside(r, x, i, d);
      l->spawn_at(s, x->of[i][0], x->of[i][1], (float)edge_points[k][0], (float)edge_points[k][1], x->time, d, &ray);
      l->intersect(s, &single, &ray, &hit, 1);
      e->rays++;
      e->out += hit.mesh == PKTRT_NONE;
    }
}

/* Counts rays that leave hits at corners and edges, found by rays from the middle, and meet nothing. */
static void leave_hits(const library *l, const pktrt_scene *s, rng *r, room *x, escapes *e) {
  const pktrt_query_desc single = {0};
  float middle[3];
  for (int a = 0; a < 3; a++) {
    double sum = 0;
    for (uint32_t i = 0; i < x->b.corners; i++) sum += x->p[i][a];
    middle[a] = (float)(sum / x->b.corners);
  }
  for (uint32_t i = 0; i < x->b.faces; i++)
    for (int k = 0; k < EDGE_POINTS; k++) {
      float to[3], d[3];
      pktrt_ray out;
      pktrt_hit hit;
      for (int a = 0; a < 3; a++) {
        const double p0 = x->p[x->b.face[i][0]][a];
        to[a] = (float)(p0 + edge_points[k][0] * (x->p[x->b.face[i][1]][a] - p0) +
                        edge_points[k][1] * (x->p[x->b.face[i][2]][a] - p0));
      }
      const pktrt_ray ray = ray_towards(middle, to, x->time);
      l->intersect(s, &single, &ray, &hit, 1);
      for (uint32_t face = 0; face < x->b.faces; face++) {
        if (hit.mesh != x->of[face][0] || hit.triangle != x->of[face][1]) continue;
        const float w = 1 - hit.u - hit.v;
        e->touching += fminf(hit.u, fminf(hit.v, w)) < 1e-5f;
        direction_inside(r, x, face, d);
        l->spawn(s, &ray, &hit, d, &out);
        l->intersect(s, &single, &out, &hit, 1);
        e->rays++;
        e->out += hit.mesh == PKTRT_NONE;
        break;
      }
    }
}

static void keep_inside(uint64_t seed, void (*leave)(const library *, const pktrt_scene *, rng *, room *, escapes *)) {
  for (int how = 0; how < SETTINGS; how++) {
    escapes kept = {0, 0, 0}, lost = {0, 0, 0};
    size_t rooms = 0;
    rng r = rng_of(seed + (uint64_t)how);
    for (size_t i = 0; i < scaled(400); i++) {
      room x;
      if (make_room(&r, (int)(i % BODY_KINDS), (setting)how, &x)) {
        pktrt_scene *s = x.instance ? whole.place(&x.placed, PKTRT_ISA_AUTO) : whole.open(&x.w, PKTRT_ISA_AUTO);
        leave(&whole, s, &r, &x, &kept);
        whole.close(s);
        rooms++;
      }
      if (i % 10 < 2) {
        slack_left = slack_whole;
        slack_left.edge = 0;
        pktrt_scene *s = x.instance ? control.place(&x.placed, PKTRT_ISA_AUTO) : control.open(&x.w, PKTRT_ISA_AUTO);
        leave(&control, s, &r, &x, &lost);
        control.close(s);
        slack_left = slack_none;
      }
      free_room(&x);
    }
    CHECK(kept.out == 0, "%s: %zu of %zu rays get out", setting_names[how], kept.out, kept.rays);
    CHECK(
        rooms > scaled(300) && kept.rays > 40 * rooms, "%s: %zu rooms, %zu rays", setting_names[how], rooms, kept.rays);
    CHECK(lost.out > lost.rays / (small_run ? 20 : 10), "%s: the control: %zu of %zu get out", setting_names[how],
        lost.out, lost.rays);
    CHECK(leave == leave_points || kept.touching > kept.rays / 2, "%s: %zu", setting_names[how], kept.touching);
    say("%-18s %zu rays of %zu rooms, %zu get out; without keeping off edges %.0f%%", setting_names[how], kept.rays,
        rooms, kept.out, 100 * (double)lost.out / (double)lost.rays);
  }
}

static void corners_and_edges(void) { keep_inside(41, leave_points); }
static void hits_at_edges(void) { keep_inside(42, leave_hits); }

/* --- a floor, and an instance of a wall on its edge --- */

/* The floor's edge runs from corner 0 to 1; the wall leans over it at 10 to 170 degrees. Rays that leave points of the edge
   go through the wall, from its front to its back, if they start in front of it. */
static void walls_that_are_instances(void) {
  size_t rays = 0, through = 0, lost = 0;
  rng r = rng_of(43);
  for (size_t i = 0; i < scaled(1500); i++) {
    const double w = (double)rng_range(&r, 10.2f, 170) * 0.017453292519943295;
    const double scale = pow(10, (double)rng_range(&r, -3, 6)), away = rng_below(&r, 3) ? 3 * scale : 0;
    double turn[3][3], shift[3];
    const double floor_of[4][3] = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
    const double lean[3] = {0, cos(w), sin(w)}, back[3] = {0, -sin(w), cos(w)};
    placement p;
    memset(&p, 0, sizeof p);
    random_turn(&r, turn);
    for (int a = 0; a < 3; a++) shift[a] = away * (double)rng_sign(&r);

    /* Both are models of unit squares; the floor's instance has the identity and corners in the scene. */
    p.models = p.n = 2;
    for (uint32_t k = 0; k < 2; k++) {
      mesh m = mesh_of(4, 2);
      const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
      memcpy(m.i, corners, sizeof corners);
      for (uint32_t c = 0; c < 4; c++)
        for (int a = 0; a < 3; a++)
          m.p[3 * c + (uint32_t)a] =
              k ? (float)floor_of[c][a]
                : (float)(scale * (turn[a][0] * floor_of[c][0] + turn[a][1] * floor_of[c][1]) + shift[a]);
      p.model[k] = world_of(m);
      p.of[k] = k;
      p.keys[k] = 1;
    }
    for (int a = 0; a < 3; a++) {
      p.transform[0][5 * a] = 1;
      p.transform[1][4 * a] = (float)(scale * turn[a][0]);
      p.transform[1][4 * a + 1] = (float)(scale * (turn[a][1] * lean[1] + turn[a][2] * lean[2]));
      p.transform[1][4 * a + 2] = (float)(scale * (turn[a][1] * back[1] + turn[a][2] * back[2]));
      p.transform[1][4 * a + 3] = (float)shift[a];
    }

    for (int k = 0; k < (i % 5 ? 1 : 2); k++) {
      const library *l = k ? &control : &whole;
      slack_left = slack_whole;
      slack_left.edge = 0;
      pktrt_scene *s = l->place(&p, PKTRT_ISA_AUTO);
      for (int n = 0; n < 10; n++) {
        const pktrt_query_desc single = {0};
        const double u = n < 2 ? 0.1 * n : (double)rng_range(&r, 0, 0.9f),
                     to[2] = {(double)rng_range(&r, 0.2f, 0.8f), (double)rng_range(&r, 0.2f, 0.8f)};
        float d[3];
        pktrt_ray ray;
        pktrt_hit hit;
        for (int a = 0; a < 3; a++) { /* to a point of the wall and, where it is in front, on to what lies behind */
          double sum = (to[0] - u) * turn[a][0];
          for (int c = 1; c < 3; c++) sum += turn[a][c] * (to[1] * lean[c] + 0.02 * back[c]);
          d[a] = (float)(scale * sum);
        }
        l->spawn_at(s, 0, 0, (float)u, 0, 0, d, &ray);
        l->intersect(s, &single, &ray, &hit, 1);
        if (k) lost += hit.mesh != 1;
        else rays++, through += hit.mesh == 1;
      }
      l->close(s);
      slack_left = slack_none;
    }
    world_free(&p.model[0]), world_free(&p.model[1]);
  }
  CHECK(through == rays, "%zu of %zu rays start behind the wall", rays - through, rays);
  CHECK(lost > rays / 5 / 10, "the control: %zu of %zu", lost, rays / 5);
  say("%zu rays, %zu start behind the wall; without keeping off edges %zu of %zu", rays, rays - through, lost,
      rays / 5);
}

/* --- pictures --- */

enum { VIEW = 51 };

/* Looks from the middle of a room at the edge where two walls meet, so that rays of a column of pixels end there. Lights
   stand outside on all sides. Returns how many pixels they light, and counts rays that end at an edge. */
static size_t lit_pixels(double degrees, double turn, double scale, double away, bool instance, pktrt_mode mode,
    pktrt_isa isa, size_t *at_edges) {
  static float pixels[3 * VIEW * VIEW];
  const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  const double w = degrees * 0.017453292519943295;
  double section[4][2] = {{0, 0}, {1, 0}, {1.5 * cos(w / 2), 1.5 * sin(w / 2)}, {cos(w), sin(w)}};
  const double shift[3] = {away, -0.7 * away, 0};
  double turned[3][3] = {{cos(turn), -sin(turn), 0}, {sin(turn), cos(turn), 0}, {0, 0, 1}};
  body b;
  memset(&b, 0, sizeof b);
  make_prism(&b, section);

  mesh m = mesh_of(b.corners, b.faces);
  memcpy(m.i, b.face, b.faces * sizeof b.face[0]);
  round_corners(&b, turned, scale, shift, m.p);

  const pktrt_scene_desc sd = scene_desc_of(isa, 0);
  pktrt_scene *s = pktrt_scene_create(&sd);
  const pktrt_mesh_desc d = mesh_desc(&m);
  const pktrt_instance_desc placed = {0, 1, identity, 0, PKTRT_INTERPOLATION_LINEAR};
  bool ok = s != NULL;
  if (instance) ok = ok && !pktrt_add_model(s, &d, 1, NULL) && !pktrt_add_instance(s, &placed, NULL);
  else ok = ok && !pktrt_add_mesh(s, &d, NULL);

  for (int i = 0; i < 6; i++) {
    pktrt_light light;
    memset(&light, 0, sizeof light);
    light.kind = PKTRT_LIGHT_POINT;
    for (int a = 0; a < 3; a++) {
      light.intensity[a] = (float)(100 * scale * scale);
      light.position[a] = (float)(shift[a] + (i / 2 == a ? i % 2 ? 5 * scale : -5 * scale : 0.3 * scale));
    }
    ok = ok && !pktrt_add_light(s, &light, NULL);
  }
  CHECK(ok && !pktrt_commit(s), "%s", pktrt_last_error(s));

  pktrt_render_desc view;
  memset(&view, 0, sizeof view);
  view.samples = 1;
  view.width = view.height = VIEW;
  view.pixels = pixels;
  view.mode = mode;
  view.samples = 1;
  view.camera.fov_y = 90;
  view.camera.up[2] = 1;
  for (int a = 0; a < 2; a++) {
    const double middle = turn + w / 2;
    view.camera.target[a] = m.p[a];
    view.camera.eye[a] = (float)(shift[a] + scale * 0.5 * (a ? sin(middle) : cos(middle)));
  }
  CHECK(!pktrt_render(s, &view), "%s", pktrt_last_error(s));

  size_t lit = 0;
  for (int i = 0; i < VIEW * VIEW; i++) {
    pktrt_ray ray;
    pktrt_hit hit;
    lit += pixels[3 * i] > 0;
    CHECK(pktrt_camera_ray(&view.camera, VIEW, VIEW, i % VIEW + 0.5, i / VIEW + 0.5, NULL, 0, &ray));
    CHECK(pktrt_intersect(s, &ray, &hit));
    *at_edges += i % VIEW == VIEW / 2 && fminf(hit.u, fminf(hit.v, 1 - hit.u - hit.v)) < 1e-5f;
  }
  pktrt_scene_destroy(s);
  mesh_free(&m);
  return lit;
}

static void pictures_of_closed_rooms(void) {
  static const double degrees[5] = {10.2, 30, 60, 90, 150};
  size_t lit = 0, at_edges = 0, pixels = 0;
  rng r = rng_of(44);
  for (int i = 0; i < 40; i++) {
    const double scale = pow(10, (double)rng_range(&r, -3, 5)), turn = i % 4 ? 3 * (double)rng_sign(&r) : 0;
    const double away = i % 3 ? scale * (double)rng_range(&r, 0.1f, 10) : 0;
    const pktrt_mode mode = i / 5 % 2 ? PKTRT_MODE_WRT : PKTRT_MODE_RCS;
    for (int k = 0; k < isa_count; k++) {
      lit += lit_pixels(degrees[i % 5], turn, scale, away, i / 10 % 2, mode, isas[k], &at_edges);
      pixels += VIEW * VIEW;
    }
  }
  CHECK(lit == 0, "%zu of %zu pixels are lit from outside", lit, pixels);
  CHECK(at_edges > pixels / VIEW / 2, "the control: only %zu rays end at edges", at_edges);
  say("%zu pixels, %zu of them at edges; %zu are lit from outside", pixels, at_edges, lit);
}

void suite_edges(void) {
  run("in pictures of closed rooms no light comes in at the edges", pictures_of_closed_rooms);
  run("from corners and edges of closed bodies no ray gets out", corners_and_edges);
  run("from hits at corners and edges of closed bodies no ray gets out", hits_at_edges);
  run("from the edge of a floor rays start in front of an instance of a wall", walls_that_are_instances);
}
