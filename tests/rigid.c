/* Instances that turn as a whole between their keys (PKTRT_INTERPOLATION_RIGID). How one lies at a time is measured by rays, as six
   points of two triangles, and compared with poses that are found here by axis and angle. */
#include "placed.h"
#include "ways.h"

enum { STEPS = 32 }; /* from key to key, as the library has it */
static const double half_turn = 3.14159265358979323846;
static const double chord = 1.21e-3; /* 1 - cos(180/64 degrees), and rounding */

/* --- poses --- */

typedef struct matrix {
  double m[3][3];
} matrix;

static matrix times(const matrix *a, const matrix *b) {
  matrix out;
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 3; j++) {
      out.m[i][j] = 0;
      for (int k = 0; k < 3; k++) out.m[i][j] += a->m[i][k] * b->m[k][j];
    }
  return out;
}
/* A rotation about an axis of any length, counter-clockwise as seen from its end. */
static matrix rotation_of(const double axis[3], double angle) {
  const double size = sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]), c = cos(angle), s = sin(angle);
  matrix out;
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double a = axis[i] / size, b = axis[j] / size, d = axis[k] / size;
    out.m[i][i] = c + (1 - c) * a * a;
    out.m[i][j] = (1 - c) * a * b - s * d;
    out.m[i][k] = (1 - c) * a * d + s * b;
  }
  return out;
}
static double signed_unit(rng *r) { return (double)rng_sign(r); }
static void random_axis(rng *r, double axis[3]) {
  double square = 0;
  while (square < 0.01 || square > 1) {
    square = 0;
    for (int a = 0; a < 3; a++) axis[a] = signed_unit(r), square += axis[a] * axis[a];
  }
}
/* Scale and shear: symmetric, its eigenvalues from `least` to 1. */
static matrix random_shape(rng *r, double least) {
  matrix scale, turn, back;
  double axis[3];
  random_axis(r, axis);
  turn = rotation_of(axis, 3 * signed_unit(r));
  memset(&scale, 0, sizeof scale);
  for (int a = 0; a < 3; a++) {
    scale.m[a][a] = least + (1 - least) * (double)rng_unit(r);
    for (int b = 0; b < 3; b++) back.m[a][b] = turn.m[b][a];
  }
  scale = times(&turn, &scale);
  return times(&scale, &back);
}

/* A motion between two keys: from a rotation on by an angle about an axis, the shape and the shift evenly. */
typedef struct motion {
  matrix start, shape[2];
  double axis[3], angle, shift[2][3];
} motion;
static motion random_motion(rng *r, double angle, double least) {
  motion p;
  double axis[3];
  random_axis(r, axis);
  random_axis(r, p.axis);
  p.start = rotation_of(axis, 3 * signed_unit(r)), p.angle = angle;
  for (int end = 0; end < 2; end++) {
    p.shape[end] = random_shape(r, least);
    for (int a = 0; a < 3; a++) p.shift[end][a] = 3 * signed_unit(r);
  }
  return p;
}
static void pose_at(const motion *p, double time, float out[12]) {
  const matrix by = rotation_of(p->axis, p->angle * time), turned = times(&by, &p->start);
  matrix shape;
  for (int a = 0; a < 9; a++)
    shape.m[a / 3][a % 3] = (1 - time) * p->shape[0].m[a / 3][a % 3] + time * p->shape[1].m[a / 3][a % 3];
  shape = times(&turned, &shape);
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) out[4 * i + j] = (float)shape.m[i][j];
    out[4 * i + 3] = (float)((1 - time) * p->shift[0][i] + time * p->shift[1][i]);
  }
}
static void keys_of(const motion *p, float keys[24]) { pose_at(p, 0, keys), pose_at(p, 1, keys + 12); }

/* --- scenes --- */

static const float corners[6][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0}, {0, 0, 1}};

static pktrt_scene *open_scene(pktrt_isa isa) {
  const pktrt_scene_desc d = scene_desc_of(isa, 0);
  return pktrt_scene_create(&d);
}
static uint32_t add_corner(pktrt_scene *s) {
  pktrt_mesh_desc d;
  uint32_t model = PKTRT_NONE;
  memset(&d, 0, sizeof d);
  d.positions = corners[0], d.vertex_count = 6, d.triangle_count = 2;
  CHECK(pktrt_add_model(s, &d, 1, &model) == PKTRT_OK, "%s", pktrt_last_error(s));
  return model;
}
static pktrt_status show(
    pktrt_scene *s, uint32_t model, uint32_t keys, const float *transforms, pktrt_interpolation interpolation) {
  const pktrt_instance_desc d = {model, keys, transforms, 0, interpolation};
  return pktrt_add_instance(s, &d, NULL);
}
static pktrt_scene *scene_of(pktrt_isa isa, uint32_t keys, const float *transforms, pktrt_interpolation interpolation) {
  pktrt_scene *s = open_scene(isa);
  CHECK(show(s, add_corner(s), keys, transforms, interpolation) == PKTRT_OK, "%s", pktrt_last_error(s));
  CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  return s;
}

/* Measures how the corner lies at a time, given about how: along normals, rays meet its triangles at three points each, and u and v
   tell where its vertices are. */
static bool measure(const pktrt_scene *s, float time, const float about[12], double got[12]) {
  static const double at[3][2] = {{0.25, 0.25}, {0.5, 0.25}, {0.25, 0.5}};
  for (int triangle = 0; triangle < 2; triangle++) {
    double vertex[3][3], normal[3], point[3][3], uv[3][2], size = 0;
    for (int k = 0; k < 3; k++)
      for (int a = 0; a < 3; a++) {
        const float *c = corners[3 * triangle + k], *m = about + 4 * a;
        vertex[k][a] =
            (double)m[0] * (double)c[0] + (double)m[1] * (double)c[1] + (double)m[2] * (double)c[2] + (double)m[3];
      }
    for (int a = 0; a < 3; a++) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      normal[a] = (vertex[1][b] - vertex[0][b]) * (vertex[2][c] - vertex[0][c]) -
                  (vertex[1][c] - vertex[0][c]) * (vertex[2][b] - vertex[0][b]);
      size += normal[a] * normal[a];
    }
    for (int k = 0; k < 3; k++) {
      pktrt_ray ray = ray_of(0, 0, 0, 0, 0, 0);
      pktrt_hit hits[4];
      size_t i = 0;
      ray.time = time;
      for (int a = 0; a < 3; a++) {
        const double unit = normal[a] / sqrt(size);
        const double to =
            vertex[0][a] + at[k][0] * (vertex[1][a] - vertex[0][a]) + at[k][1] * (vertex[2][a] - vertex[0][a]);
        ray.direction[a] = (float)unit, ray.origin[a] = (float)(to - 0.5 * unit);
      }
      const size_t n = pktrt_intersect_all(s, &ray, hits, 4);
      while (i < n && hits[i].triangle != (uint32_t)triangle) i++;
      if (i >= n || i > 3) return false;
      uv[k][0] = (double)hits[i].u, uv[k][1] = (double)hits[i].v;
      for (int a = 0; a < 3; a++) point[k][a] = (double)ray.origin[a] + (double)hits[i].t * (double)ray.direction[a];
    }

    /* Two equations for both edges, by Cramer's rule, and then the vertex where they meet. */
    const double u1 = uv[1][0] - uv[0][0], v1 = uv[1][1] - uv[0][1], u2 = uv[2][0] - uv[0][0], v2 = uv[2][1] - uv[0][1];
    const double det = u1 * v2 - u2 * v1;
    for (int a = 0; a < 3; a++) {
      const double d1 = point[1][a] - point[0][a], d2 = point[2][a] - point[0][a];
      const double along_u = (d1 * v2 - d2 * v1) / det, along_v = (u1 * d2 - u2 * d1) / det;
      if (!triangle) {
        got[4 * a] = along_u, got[4 * a + 1] = along_v;
        got[4 * a + 3] = point[0][a] - uv[0][0] * along_u - uv[0][1] * along_v;
      } else {
        got[4 * a + 2] = along_v;
      }
    }
  }
  return true;
}
/* The most that elements differ, without or with the shift. */
static double apart(const double got[12], const float want[12], bool shift) {
  double most = 0;
  for (int k = 0; k < 12; k++) {
    const double by = fabs(got[k] - (double)want[k]);
    if ((k % 4 < 3 || shift) && !(by <= most)) most = by; /* NaN, too */
  }
  return most;
}

/* --- tests --- */

/* What a turn makes of a body whose sides are 1: the most that lengths change, that right angles do, and that directions differ. */
typedef struct change {
  double size, angle, direction;
} change;
static void find_change(const double got[12], const float want[12], change *most) {
  for (int j = 0; j < 3; j++) {
    double square = 0, across = 0, along = 0;
    for (int a = 0; a < 3; a++) {
      square += got[4 * a + j] * got[4 * a + j], across += got[4 * a + j] * got[4 * a + (j + 1) % 3];
      along += got[4 * a + j] * (double)want[4 * a + j];
    }
    most->size = fmax(most->size, fabs(1 - sqrt(square)));
    most->angle = fmax(most->angle, fabs(across) / square);
    most->direction = fmax(most->direction, acos(fmin(along / sqrt(square), 1)));
  }
}

static void shapes_are_kept(void) {
  static const double angles[] = {1e-3, 10, 90, -90, 120, 179, 179.9, -179.9, 180};
  double beside = 0, got[12];
  change rigid = {0, 0, 0}, linear = {0, 0, 0};
  rng r = rng_of(1);
  for (size_t i = 0; i < COUNT(angles); i++)
    for (int way = 0; way < (small_run ? 4 : 12); way++) {
      motion p = random_motion(&r, angles[i] * half_turn / 180, 1);
      float keys[24], want[12];
      if (way < 3) memset(p.axis, 0, sizeof p.axis), p.axis[way] = 1;
      if (p.angle == half_turn && way > 2) p.axis[0] = fabs(p.axis[0]) + 0.01; /* that way round, see below */
      keys_of(&p, keys);
      pktrt_scene *s = scene_of(PKTRT_ISA_AUTO, 2, keys, PKTRT_INTERPOLATION_RIGID);
      for (int k = 0; k <= 96; k++) {
        const float time = k % 3 ? rng_unit(&r) : (float)k / 96;
        pose_at(&p, (double)time, want);
        if (!CHECK(measure(s, time, want, got), "%g degrees, time %g: not there", angles[i], (double)time)) continue;
        find_change(got, want, &rigid);
        if (k % 3 == 0) beside = fmax(beside, apart(got, want, true)); /* at the library's own places, and the keys */
      }
      pktrt_scene_destroy(s);
      if (fabs(angles[i]) > 90) continue;
      s = scene_of(PKTRT_ISA_AUTO, 2, keys, PKTRT_INTERPOLATION_LINEAR);
      for (int k = 0; k < 12; k++) want[k] = 0.5f * (keys[k] + keys[12 + k]);
      if (CHECK(measure(s, 0.5f, want, got))) find_change(got, want, &linear);
      pktrt_scene_destroy(s);
    }
  CHECK(rigid.size < chord && rigid.size > 1.1e-3, "lengths change by %g", rigid.size);
  CHECK(rigid.angle < 2 * chord, "right angles by %g", rigid.angle);
  CHECK(rigid.direction < 1e-3 && beside < 1e-5, "from the even turn %g apart, at places %g", rigid.direction, beside);
  CHECK(linear.size > 0.29 && linear.size < 0.3, "the control, linear by 90 degrees, shrinks by %g", linear.size);
  say("lengths change by %.3g at most, directions by %.3g; at the places between keys all by %.3g; control, linear: "
      "lengths by %.3g",
      rigid.size, rigid.direction, beside, linear.size);
}

/* Returns how many rays meet the corner at a time of a key, which must be as if it rested there, bit for bit. */
static size_t meets(const pktrt_scene *s, float time, const float key[12], rng *r) {
  pktrt_scene *rests = scene_of(PKTRT_ISA_AUTO, 1, key, PKTRT_INTERPOLATION_LINEAR);
  size_t hits = 0;
  for (int i = 0; i < 40; i++) {
    pktrt_ray ray = ray_of(0, 0, 0, 0, 0, 0);
    pktrt_hit a, b;
    for (int c = 0; c < 3; c++) {
      const float *m = key + 4 * c, to = m[3] + rng_unit(r) * m[0] + rng_unit(r) * m[i % 2 + 1];
      ray.origin[c] = 5 * rng_sign(r), ray.direction[c] = to - ray.origin[c];
    }
    ray.time = time;
    hits += pktrt_intersect(s, &ray, &a);
    pktrt_intersect(rests, &ray, &b);
    CHECK(same_bits(&a, &b, sizeof a), "time %g, ray %d", (double)time, i);
  }
  pktrt_scene_destroy(rests);
  return hits;
}
/* Mirrors the model, before all else. */
static void mirror_shapes(motion *p) {
  for (int end = 0; end < 2; end++)
    for (int row = 0; row < 3; row++)
      for (int a = 0; a < 3; a++) p->shape[end].m[row][a] = -p->shape[end].m[row][a];
}
static void shapes_mix(void) {
  size_t met = 0;
  double worst = 0;
  rng r = rng_of(2);
  for (size_t i = 0; i < scaled(400) + 20; i++) {
    motion p = random_motion(&r, 3.1 * signed_unit(&r), 0.2);
    float keys[24], want[12];
    if (i % 2) mirror_shapes(&p);
    keys_of(&p, keys);
    pktrt_scene *s = scene_of(PKTRT_ISA_AUTO, 2, keys, PKTRT_INTERPOLATION_RIGID);
    met += meets(s, 0, keys, &r) + meets(s, 1, keys + 12, &r);
    for (int k = 0; k <= 40; k++) {
      const float time = k == 20 ? 0.5f : k == 40 ? 1 : k ? rng_unit(&r) : 0;
      double got[12];
      pose_at(&p, (double)time, want);
      if (!CHECK(measure(s, time, want, got), "%zu, time %g: not there", i, (double)time)) continue;
      const double by = apart(got, want, true);
      if (by > worst) worst = by;
      CHECK(k % 20 || by < 2e-5, "%zu, time %g: %g apart", i, (double)time, by);
    }
    pktrt_scene_destroy(s);
  }
  CHECK(worst < 2 * chord && worst > chord / 4, "%g apart", worst);
  CHECK(met > 100, "%zu hits at keys", met);
  say("half of them mirrored: poses are %.3g apart at most", worst);
}

/* Half a turn is defined, whatever the rounding: counter-clockwise about the axis whose first part that is not 0 is positive. */
static void half_turns_are_defined(void) {
  static const double axes[][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {1, -1, 0}, {1, 1, -2}, {0, 1, -1}, {0.5, -3, 7}};
  rng r = rng_of(3);
  for (size_t i = 0; i < COUNT(axes); i++)
    for (int way = 0; way < 12; way++) {
      motion p = random_motion(&r, half_turn, 1);
      double beyond = way ? 1e-7 * signed_unit(&r) : 0, got[12];
      float keys[36], want[12];
      memcpy(p.axis, axes[i], sizeof p.axis);
      for (int a = 0; a < 9 && way % 3 == 0; a++) p.start.m[a / 3][a % 3] = a % 4 == 0;
      pose_at(&p, 0, keys), pose_at(&p, 1 + beyond, keys + 12), pose_at(&p, 2, keys + 24);
      for (uint32_t n = 2; n < 4; n++) { /* three keys: it goes on the same way */
        pktrt_scene *s = scene_of(PKTRT_ISA_AUTO, n, keys, PKTRT_INTERPOLATION_RIGID);
        for (int k = 0; k <= 8; k++) {
          pose_at(&p, (double)(n - 1) * k / 8, want);
          CHECK(measure(s, (float)k / 8, want, got) && apart(got, want, n == 2 && !way) < 3e-6,
              "axis %zu, %d, key %d: %g apart", i, way, k, apart(got, want, false));
        }
        pktrt_scene_destroy(s);
      }
    }
}

/* Rays meet it where they meet a linear one that has the library's places as keys, as they are found here. */
static void hits_are_those_of_its_places(void) {
  const size_t n = small_run ? 256 : MANY;
  static pktrt_ray rays[MANY];
  static answers rigid, linear, first;
  size_t hits = 0, differs = 0, wrong = 0, control = 0;
  double worst = 0;
  rng r = rng_of(4);
  world w = world_of(mesh_sphere(2, 0.1f, 3));
  for (int turn = 0; turn < 4; turn++) {
    const motion p = random_motion(&r, 1.5 * signed_unit(&r), 0.5);
    float keys[24], places[12 * (STEPS + 1)];
    keys_of(&p, keys);
    for (int k = 0; k <= STEPS; k++) pose_at(&p, (double)k / STEPS, places + 12 * (size_t)k);
    for (size_t i = 0; i < n; i++) {
      float to[3];
      for (int a = 0; a < 3; a++) {
        rays[i].origin[a] = 9 * rng_sign(&r);
        to[a] = (float)(p.shift[0][a] + p.shift[1][a]) / 2 + rng_sign(&r);
        rays[i].direction[a] = to[a] - rays[i].origin[a];
      }
      rays[i].tmin = 0, rays[i].tmax = INFINITY, rays[i].time = rng_unit(&r);
    }
    for (int k = 0; k < isa_count; k++) {
      pktrt_scene *s[3];
      for (int i = 0; i < 3; i++) {
        const pktrt_mesh_desc d = mesh_desc(&w.m[0]);
        uint32_t model;
        s[i] = open_scene(isas[k]);
        CHECK(pktrt_add_model(s[i], &d, 1, &model) == PKTRT_OK);
        CHECK(show(s[i], model, i == 1 ? STEPS + 1 : 2, i == 1 ? places : keys,
                  i ? PKTRT_INTERPOLATION_LINEAR : PKTRT_INTERPOLATION_RIGID) == PKTRT_OK,
            "%s", pktrt_last_error(s[i]));
        CHECK(pktrt_commit(s[i]) == PKTRT_OK);
      }
      for (int way = 0; way < WAYS; way++) {
        ask(s[0], way, rays, n, &rigid), ask(s[1], way, rays, n, &linear);
        if (k == 0 && way == 0) first = rigid, hits += hits_of(&rigid, n);
        wrong += differ(&first, &rigid, n);
        for (size_t i = 0; i < n; i++) {
          const pktrt_hit *a = &rigid.hit[i], *b = &linear.hit[i];
          if (a->mesh != b->mesh || a->triangle != b->triangle) differs++;
          else if (a->mesh != PKTRT_NONE) worst = fmax(worst, fabs((double)a->t - (double)b->t));
        }
      }
      ask(s[2], 0, rays, n, &linear);
      control += differ(&first, &linear, n);
      for (int i = 0; i < 3; i++) pktrt_scene_destroy(s[i]);
    }
  }
  CHECK(hits > n / 4 && wrong == 0, "%zu hits, %zu differ between ways and instruction sets", hits, wrong);
  CHECK(differs < hits / 40 * (size_t)isa_count && worst < 1e-4 && control > hits / 2,
      "%zu hits, %zu triangles differ, t by %g, control %zu", hits, differs, worst, control);
  say("%zu hits, the same bits in %d ways; against places found by sines: %zu triangles differ, t by %.3g; control, "
      "linear: %zu",
      hits, WAYS, differs, worst, control);
  world_free(&w);
}

/* One key, and keys that are alike, are as they are where elements move along lines. */
static void without_turns_it_is_linear(void) {
  static const float still[12] = {2, 0, 0, 1, 0, 1, 0.5f, 0, 0, 0, 1, -1};
  static const float scaled_up[24] = {1, 0, 0, -1, 0, 1, 0, 0, 0, 0, 1, 0, 3, 0, 0, 1, 0, 2, 0, 0, 0, 0, 1, 0};
  static pktrt_ray rays[MANY];
  static answers a, b;
  size_t hits = 0, wrong = 0;
  double worst = 0;
  rng r = rng_of(5);
  for (size_t i = 0; i < MANY; i++) {
    for (int k = 0; k < 3; k++)
      rays[i].origin[k] = 4 * rng_sign(&r), rays[i].direction[k] = rng_unit(&r) - rays[i].origin[k];
    rays[i].tmin = 0, rays[i].tmax = INFINITY, rays[i].time = rng_unit(&r);
  }
  size_t live[2];
  for (int moves = 0; moves < 2; moves++) {
    pktrt_scene *s[2];
    for (int i = 0; i < 2; i++) {
      const size_t before = hooks.live_bytes;
      s[i] = scene_of(PKTRT_ISA_AUTO, moves ? 2 : 1, moves ? scaled_up : still,
          i ? PKTRT_INTERPOLATION_RIGID : PKTRT_INTERPOLATION_LINEAR);
      live[i] = hooks.live_bytes - before;
    }
    CHECK(moves ? live[1] > live[0] + STEPS * 48 - 48 : live[1] == live[0], "%zu bytes, rigid %zu", live[0], live[1]);
    ask(s[0], 0, rays, MANY, &a), ask(s[1], 0, rays, MANY, &b);
    hits += hits_of(&a, MANY);
    if (!moves) wrong += differ(&a, &b, MANY);
    for (size_t i = 0; i < MANY && moves; i++) {
      wrong += a.occluded[i] != b.occluded[i];
      if (a.occluded[i] && b.occluded[i]) worst = fmax(worst, fabs((double)a.hit[i].t - (double)b.hit[i].t));
    }
    pktrt_scene_destroy(s[0]), pktrt_scene_destroy(s[1]);
  }
  CHECK(hits > 100 && wrong < 5 && worst < 1e-5, "%zu hits, %zu differ, by %g", hits, wrong, worst);
}

/* Tells whether two scenes have the same hits, at all times. */
static bool same_hits(const pktrt_scene *a, const pktrt_scene *b, rng *r) {
  size_t hits = 0;
  bool same = true;
  for (int i = 0; i < 3000; i++) {
    pktrt_ray ray = ray_of(0, 0, 0, 0, 0, 0);
    pktrt_hit x, y;
    for (int c = 0; c < 3; c++) ray.origin[c] = 6 * rng_sign(r), ray.direction[c] = rng_sign(r) - ray.origin[c];
    ray.time = rng_unit(r);
    hits += pktrt_intersect(a, &ray, &x);
    pktrt_intersect(b, &ray, &y);
    same = same && same_bits(&x, &y, sizeof x);
  }
  CHECK(hits > 50, "%zu hits", hits);
  return same;
}
/* Keys that are set are those that would have been given; what fails changes nothing, before and after a refit. */
static void keys_are_set(void) {
  enum { KEYS = 4 };
  static const float flat[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0};
  float now[12 * KEYS], next[12 * KEYS], mirror[12];
  rng r = rng_of(6);
  for (int turn = 0; turn < (small_run ? 6 : 20); turn++) {
    for (int k = 0; k < KEYS; k++) {
      motion p = random_motion(&r, 3, 0.5), q = random_motion(&r, 3, 0.5);
      for (int a = 0; a < 3; a++) p.shift[0][a] /= 6, q.shift[0][a] /= 6;
      pose_at(&p, 0, now + 12 * k), pose_at(&q, 0, next + 12 * k);
    }
    pktrt_scene *s = scene_of(PKTRT_ISA_AUTO, KEYS, now, PKTRT_INTERPOLATION_RIGID);
    pktrt_scene *was = scene_of(PKTRT_ISA_AUTO, KEYS, now, PKTRT_INTERPOLATION_RIGID);
    const uint32_t key = rng_below(&r, KEYS);
    memcpy(mirror, now + 12 * key, sizeof mirror);
    for (int a = 0; a < 3; a++) mirror[4 * a] *= -1;
    for (int set = 0; set < 3; set++) { /* nothing, one key, all */
      if (set == 1) {
        CHECK(pktrt_set_transform(s, 0, key, next + 12 * key) == PKTRT_OK, "%s", pktrt_last_error(s));
        memcpy(now + 12 * key, next + 12 * key, 12 * sizeof *now);
      } else if (set == 2) {
        CHECK(pktrt_set_transforms(s, 0, next) == PKTRT_OK, "%s", pktrt_last_error(s));
        memcpy(now, next, sizeof now);
      }
      CHECK(same_hits(s, was, &r), "set before the refit, %d", set);
      for (int dirty = 1; dirty >= 0; dirty--) { /* what is refused, over what waits, and over nothing */
        float wrong[12 * KEYS];
        says(s, pktrt_set_transform(s, 0, key, flat), PKTRT_INVALID_ARGUMENT, "instance 0: its transform flattens it");
        says(s, pktrt_set_transform(s, 0, key, mirror), PKTRT_INVALID_ARGUMENT, "is mirrored; mirror both or none");
        memcpy(wrong, next, sizeof wrong), wrong[12 * 2 + 5] = NAN;
        says(s, pktrt_set_transforms(s, 0, wrong), PKTRT_INVALID_ARGUMENT, "instance 0, key 2: element 5");
        memcpy(wrong, now, sizeof wrong);
        for (int k = 0; k < KEYS; k++) wrong[12 * k + 3] += 1;
        memcpy(wrong + 12 * key, mirror, sizeof mirror);
        says(s, pktrt_set_transforms(s, 0, wrong), PKTRT_INVALID_ARGUMENT, "is mirrored; mirror both or none");
        CHECK(pktrt_refit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
        pktrt_scene *want = scene_of(PKTRT_ISA_AUTO, KEYS, now, PKTRT_INTERPOLATION_RIGID);
        CHECK(same_hits(s, want, &r), "turn %d, set %d, waiting %d", turn, set, dirty);
        pktrt_scene_destroy(was);
        was = want;
      }
    }
    CHECK(pktrt_commit(s) == PKTRT_OK && same_hits(s, was, &r), "committed");
    pktrt_scene_destroy(s), pktrt_scene_destroy(was);
  }
}
/* All keys may be turned, and mirrored, at once. */
static void all_keys_are_mirrored(void) {
  float keys[24];
  rng r = rng_of(7);
  motion p = random_motion(&r, 3, 0.5);
  for (int a = 0; a < 6; a++) p.shift[a / 3][a % 3] /= 6;
  keys_of(&p, keys);
  pktrt_scene *s = scene_of(PKTRT_ISA_AUTO, 2, keys, PKTRT_INTERPOLATION_RIGID);
  for (int k = 0; k < 24; k++)
    if (k % 4 == 0) keys[k] *= -1;
  CHECK(pktrt_set_transforms(s, 0, keys) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  pktrt_scene *want = scene_of(PKTRT_ISA_AUTO, 2, keys, PKTRT_INTERPOLATION_RIGID);
  CHECK(same_hits(s, want, &r));
  pktrt_scene_destroy(s), pktrt_scene_destroy(want);
}

static void wrong_keys_are_named(void) {
  static const float plain[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  float keys[33 * 12];
  for (int k = 0; k < 33; k++) memcpy(keys + 12 * k, plain, sizeof plain);
  pktrt_scene *s = open_scene(PKTRT_ISA_AUTO);
  const uint32_t model = add_corner(s);
  const pktrt_interpolation rigid = PKTRT_INTERPOLATION_RIGID, linear = PKTRT_INTERPOLATION_LINEAR;
  says(s, show(s, model, 2, keys, (pktrt_interpolation)2), PKTRT_INVALID_ARGUMENT,
      "instance 0: 2 is no pktrt_interpolation");
  says(s, show(s, model, 33, keys, rigid), PKTRT_LIMIT,
      "instance 0: key_count 33 is above 32 of PKTRT_INTERPOLATION_RIGID");
  says(s, show(s, model, 1025, keys, linear), PKTRT_LIMIT, "instance 0: key_count 1025 is above 1024");

  /* One of three keys is mirrored; turned by 180 degrees none is, and only linear ones need more. */
  keys[12 * 2] = -1;
  says(s, show(s, model, 3, keys, rigid), PKTRT_INVALID_ARGUMENT,
      "instance 0: one of keys 1 and 2 is mirrored; mirror both or none");
  keys[12 * 2 + 5] = -1;
  says(s, show(s, model, 3, keys, linear), PKTRT_INVALID_ARGUMENT,
      "instance 0: between keys 1 and 2 its transform may flatten it; give it more keys or PKTRT_INTERPOLATION_RIGID");
  says(s, show(s, model, 3, keys, linear), PKTRT_INVALID_ARGUMENT, "pktrt_set_transforms");
  CHECK(show(s, model, 3, keys, rigid) == PKTRT_OK, "%s", pktrt_last_error(s));
  for (int i = 0; i < 11; i += 5) keys[12 * 1 + i] *= 1e9f;
  says(s, show(s, model, 3, keys, rigid), PKTRT_INVALID_ARGUMENT,
      "its transform may flatten it; give it more keys between");
  for (int i = 0; i < 11; i += 5) keys[12 * 1 + i] *= 1e-9f;
  keys[12 * 1 + 10] = 0;
  says(s, show(s, model, 3, keys, rigid), PKTRT_INVALID_ARGUMENT, "instance 1: its transform flattens it");
  keys[12 * 1 + 10] = INFINITY;
  says(s, show(s, model, 3, keys, rigid), PKTRT_INVALID_ARGUMENT,
      "instance 1, key 1: element 10 of its transform is inf");
  keys[12 * 1 + 10] = 1e5f; /* from 1 to that within one interval of 32 */
  says(s, show(s, model, 2, keys, rigid), PKTRT_OK, "");
  for (int a = 0; a < 3; a++) keys[5 * a] = 1e9f, keys[12 + 5 * a] = 1; /* too much within the last of these */
  says(s, show(s, model, 2, keys, rigid), PKTRT_INVALID_ARGUMENT, "between keys 0 and 1 its transform may flatten it");

  /* The user's keys are those that calls know. */
  says(s, pktrt_set_transform(s, 0, 3, plain), PKTRT_INVALID_ARGUMENT,
      "set_transform: instance 0, key 3: there is no such key");
  says(s, pktrt_set_transforms(s, 0, NULL), PKTRT_INVALID_ARGUMENT, "the array of 3 keys is NULL");
  CHECK(pktrt_set_transform(s, 0, 2, plain) == PKTRT_OK, "%s", pktrt_last_error(s));
  CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  pktrt_scene_destroy(s);
}

/* Whatever allocation fails, an instance is as it was, and the call can be made again. */
static void failures_of_memory(void) {
  float keys[24], next[24];
  size_t failures = 0;
  rng r = rng_of(8);
  const motion p = random_motion(&r, 2, 0.5), q = random_motion(&r, -3, 0.5);
  keys_of(&p, keys), keys_of(&q, next);
  for (int call = 0; call < 3; call++) {
    for (size_t n = 1; n < 20; n++) {
      pktrt_scene *s = scene_of(PKTRT_ISA_AUTO, 2, keys, PKTRT_INTERPOLATION_RIGID);
      hooks.fail_at = n, hooks.failed = 0;
      const pktrt_status st = call == 0   ? show(s, 0, 2, next, PKTRT_INTERPOLATION_RIGID)
                              : call == 1 ? pktrt_set_transform(s, 0, 1, next + 12)
                                          : pktrt_set_transforms(s, 0, next);
      hooks.fail_at = 0;
      const bool failed = hooks.failed > 0;
      CHECK(failed ? st == PKTRT_OUT_OF_MEMORY && strstr(pktrt_last_error(s), "no memory") : st == PKTRT_OK,
          "call %d, %zu: %s", call, n, pktrt_last_error(s));
      if (failed) {
        failures++;
        CHECK(pktrt_refit(s) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
        pktrt_scene *want = scene_of(PKTRT_ISA_AUTO, 2, keys, PKTRT_INTERPOLATION_RIGID);
        double got[12], as[12];
        CHECK(measure(s, 0, keys, got) && measure(want, 0, keys, as) && same_bits(got, as, sizeof got));
        CHECK(measure(s, 1, keys + 12, got) && measure(want, 1, keys + 12, as) && same_bits(got, as, sizeof got));
        pktrt_scene_destroy(want);
      }
      pktrt_scene_destroy(s);
      if (!failed) break;
    }
  }
  CHECK(failures > 4, "%zu failures", failures);
}

/* Keys of any size, some of them nearly flat or scaled by axes that differ a lot, are taken apart. */
static void sizes_do_not_matter(void) {
  size_t flat = 0, wrong = 0, places = 0;
  rng r = rng_of(9);
  for (int i = 0; i < (small_run ? 60 : 600); i++) {
    motion p = random_motion(&r, 3 * signed_unit(&r), 0.3);
    const double size = pow(10, (i % 2 ? 3 : 17) * signed_unit(&r)), thin = pow(10, -3 * (double)rng_unit(&r));
    float keys[24], want[12];
    double got[12];
    for (int end = 0; end < 2; end++)
      for (int a = 0; a < 9; a++) {
        p.shape[end].m[a / 3][a % 3] = a / 3 == a % 3 ? a / 3 == i % 3 ? thin : 1 + end : 0;
        if (a < 3) p.shift[end][a] *= size;
      }
    for (int end = 0; end < 2; end++)
      for (int a = 0; a < 9; a++) p.shape[end].m[a / 3][a % 3] *= size;
    keys_of(&p, keys);
    pktrt_scene *s = open_scene(PKTRT_ISA_AUTO);
    const pktrt_status st = show(s, add_corner(s), 2, keys, PKTRT_INTERPOLATION_RIGID);
    flat += st != PKTRT_OK;
    CHECK(pktrt_commit(s) == PKTRT_OK);
    for (int k = 0; k <= STEPS && st == PKTRT_OK && size < 1e3 && size > 1e-3; k += 4) {
      pose_at(&p, (double)k / STEPS, want);
      wrong += !measure(s, (float)k / STEPS, want, got) || apart(got, want, true) > 1e-5 * fmax(1, size);
      places++;
    }
    pktrt_scene_destroy(s);
  }
  CHECK(flat == 0 && wrong == 0 && places > 100, "%zu are refused, %zu of %zu places wrong", flat, wrong, places);
}

void suite_rigid(void) {
  run("rigid: between keys a body keeps its shape and turns evenly, the shorter way, whatever the angle and the axis",
      shapes_are_kept);
  run("rigid: scale and shear mix evenly, mirrored or not, and keys are met", shapes_mix);
  run("rigid: half a turn goes a way that is defined, and on from there", half_turns_are_defined);
  run("rigid: hits are those of places between the keys, with the same bits in all ways", hits_are_those_of_its_places);
  run("rigid: one key costs nothing, and without turns it moves as a linear one", without_turns_it_is_linear);
  run("rigid: keys that are set are as keys that were given, and what is refused changes nothing", keys_are_set);
  run("rigid: all keys are mirrored at once", all_keys_are_mirrored);
  run("rigid: what is wrong with keys is named, with the user's numbers", wrong_keys_are_named);
  run("rigid: failures of memory change nothing", failures_of_memory);
  run("rigid: keys of any size are taken apart", sizes_do_not_matter);
}
