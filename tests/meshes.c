#include "meshes.h"

mesh mesh_of(uint32_t nv, uint32_t nt) {
  mesh m = {calloc((size_t)nv * 3 + 1, sizeof(float)), calloc((size_t)nt * 3 + 1, sizeof(uint32_t)), nv, nt, 1};
  if (!m.p || !m.i) abort();
  return m;
}

void mesh_free(mesh *m) {
  free(m->p);
  free(m->i);
  memset(m, 0, sizeof *m);
}

static void set3(float *p, float x, float y, float z) { p[0] = x, p[1] = y, p[2] = z; }
static void tri(mesh *m, uint32_t t, uint32_t a, uint32_t b, uint32_t c) {
  m->i[t * 3] = a, m->i[t * 3 + 1] = b, m->i[t * 3 + 2] = c;
}

/* Octahedron, each face cut into 4^level; vertices on a lattice |x|+|y|+|z| = n find each other through a table. */
mesh mesh_sphere(int level, float bump, uint64_t seed) {
  int n = 1 << level;
  size_t side = (size_t)n * 2 + 1;
  uint32_t *table = calloc(side * side * 2, sizeof *table), vertices = 0, t = 0;
  mesh m = mesh_of((uint32_t)(4 * n * n + 2), (uint32_t)(8 * n * n));
  if (!table) abort();
  for (int octant = 0; octant < 8; octant++) {
    int sx = octant & 1 ? -1 : 1, sy = octant & 2 ? -1 : 1, sz = octant & 4 ? -1 : 1;
    for (int i = 0; i < n; i++) {
      for (int j = 0; j < n - i; j++) {
        for (int half = 0; half < 2; half++) {
          if (half && j == n - i - 1) continue;
          const int corner[2][3][2] = {{{0, 0}, {1, 0}, {0, 1}}, {{1, 0}, {1, 1}, {0, 1}}};
          uint32_t id[3];
          for (int c = 0; c < 3; c++) {
            int a = i + corner[half][c][0], b = j + corner[half][c][1];
            int x = sx * a, y = sy * b, z = sz * (n - a - b);
            uint32_t *slot = &table[((size_t)(x + n) * side + (size_t)(y + n)) * 2 + (z < 0)];
            if (!*slot) {
              double l = sqrt((double)x * x + (double)y * y + (double)z * z);
              rng r = rng_of(seed * 1000003 + vertices);
              double s = (1 + bump * (double)rng_sign(&r)) / l;
              set3(m.p + 3 * (size_t)vertices, (float)(x * s), (float)(y * s), (float)(z * s));
              *slot = ++vertices;
            }
            id[c] = *slot - 1;
          }
          bool flip = (sx * sy * sz) < 0;
          tri(&m, t++, id[0], id[flip ? 2 : 1], id[flip ? 1 : 2]);
        }
      }
    }
  }
  free(table);
  if (vertices != m.nv || t != m.nt) abort();
  return m;
}

mesh mesh_grid(uint32_t n, float half) {
  mesh m = mesh_of((n + 1) * (n + 1), 2 * n * n);
  for (uint32_t z = 0; z <= n; z++) {
    for (uint32_t x = 0; x <= n; x++) {
      set3(m.p + 3 * (z * (n + 1) + x), half * (2 * (float)x / (float)n - 1), 0, half * (2 * (float)z / (float)n - 1));
    }
  }
  for (uint32_t z = 0, t = 0; z < n; z++) {
    for (uint32_t x = 0; x < n; x++, t += 2) {
      uint32_t a = z * (n + 1) + x, b = a + n + 1;
      tri(&m, t, a, b, a + 1);
      tri(&m, t + 1, a + 1, b, b + 1);
    }
  }
  return m;
}

mesh mesh_box(void) {
  mesh m = mesh_of(8, 12);
  for (uint32_t v = 0; v < 8; v++) set3(m.p + 3 * v, v & 1 ? 1.f : -1.f, v & 2 ? 1.f : -1.f, v & 4 ? 1.f : -1.f);
  static const uint32_t face[6][4] = {
      {0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
  for (uint32_t f = 0; f < 6; f++) {
    tri(&m, f * 2, face[f][0], face[f][1], face[f][2]);
    tri(&m, f * 2 + 1, face[f][0], face[f][2], face[f][3]);
  }
  return m;
}

mesh mesh_soup(uint32_t nt, float size, uint64_t seed) {
  mesh m = mesh_of(nt * 3, nt);
  rng r = rng_of(seed);
  for (uint32_t t = 0; t < nt; t++) {
    float c[3] = {rng_sign(&r), rng_sign(&r), rng_sign(&r)};
    for (uint32_t k = 0; k < 9; k++) m.p[t * 9 + k] = c[k % 3] + size * rng_sign(&r);
    tri(&m, t, t * 3, t * 3 + 1, t * 3 + 2);
  }
  return m;
}

mesh mesh_thin(uint32_t nt, uint64_t seed) {
  mesh m = mesh_soup(nt, 1.0f, seed);
  rng r = rng_of(seed + 1);
  for (uint32_t t = 0; t < nt; t++) {
    float *a = m.p + t * 9, f = rng_unit(&r), w = powf(10, rng_range(&r, -7, -1));
    for (uint32_t k = 0; k < 3; k++) { /* the third corner near the line through the others */
      float on = t & 1 ? a[k] + f * (a[3 + k] - a[k]) : a[k];
      a[6 + k] = on + w * rng_sign(&r);
    }
  }
  return m;
}

mesh mesh_copies(const mesh *s, uint32_t copies) {
  mesh m = mesh_of(s->nv, s->nt * copies);
  memcpy(m.p, s->p, sizeof(float) * 3 * s->nv);
  for (uint32_t t = 0; t < m.nt; t++) { /* each copy with its corners turned round, the odd ones facing the other way */
    uint32_t c = t / s->nt, *q = s->i + t % s->nt * 3;
    if (c & 1) tri(&m, t, q[(c + 2) % 3], q[(c + 1) % 3], q[c % 3]);
    else tri(&m, t, q[c % 3], q[(c + 1) % 3], q[(c + 2) % 3]);
  }
  return m;
}

mesh mesh_fan(uint32_t blades, uint64_t seed) {
  mesh m = mesh_of(blades + 1, blades);
  rng r = rng_of(seed);
  set3(m.p, rng_sign(&r), rng_sign(&r), 1 + rng_unit(&r));
  for (uint32_t b = 0; b < blades; b++) {
    float angle = 6.2831853f * ((float)b + 0.8f * rng_unit(&r)) / (float)blades, l = rng_range(&r, 0.1f, 2);
    set3(m.p + 3 * (b + 1), m.p[0] + l * cosf(angle), m.p[1] + l * sinf(angle), m.p[2] + 0.2f * l * rng_sign(&r));
    tri(&m, b, 0, b + 1, (b + 1) % blades + 1);
  }
  return m;
}

void mesh_place(mesh *m, const float scale[3], const float offset[3]) {
  for (size_t k = 0; k < (size_t)m->keys * m->nv * 3; k++) m->p[k] = m->p[k] * scale[k % 3] + offset[k % 3];
}

void mesh_move(mesh *m, uint32_t keys, float turn, float jitter, uint64_t seed) {
  size_t block = (size_t)m->nv * 3;
  float *p = calloc(block * keys + 1, sizeof *p);
  if (!p) abort();
  rng r = rng_of(seed);
  for (uint32_t k = 0; k < keys; k++) {
    float c = cosf(turn * (float)k), s = sinf(turn * (float)k);
    for (size_t v = 0; v < block; v += 3) {
      const float *q = m->p + v;
      set3(p + k * block + v, c * q[0] + s * q[2], q[1], c * q[2] - s * q[0]);
      for (int a = 0; a < 3 && k; a++) p[k * block + v + (size_t)a] += jitter * rng_sign(&r);
    }
  }
  free(m->p);
  m->p = p;
  m->keys = keys;
}

pktrt_mesh_desc mesh_desc(const mesh *m) {
  pktrt_mesh_desc d;
  memset(&d, 0, sizeof d);
  d.positions = m->p;
  d.vertex_count = m->nv;
  d.indices = m->i;
  d.triangle_count = m->nt;
  d.key_count = m->keys;
  return d;
}

pktrt_status mesh_add(pktrt_scene *s, const mesh *m, uint32_t *index) {
  pktrt_mesh_desc d = mesh_desc(m);
  return pktrt_add_mesh(s, &d, index);
}

world world_none(void) {
  world w;
  memset(&w, 0, sizeof w);
  return w;
}

world world_of(mesh m) {
  world w = world_none();
  w.m[0] = m, w.n = 1;
  return w;
}

void world_free(world *w) {
  for (uint32_t i = 0; i < w->n; i++) mesh_free(&w->m[i]);
  free(w->tree);
  w->tree = NULL;
  w->n = 0;
}

void world_place(world *w, float s, float x, float y, float z) {
  for (uint32_t i = 0; i < w->n; i++) mesh_place(&w->m[i], (float[3]){s, s, s}, (float[3]){x, y, z});
}

pktrt_scene *world_scene(const world *w, pktrt_isa isa, int workers) {
  pktrt_scene_desc d = scene_desc_of(isa, workers);
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!CHECK(s != NULL, "create: %s", pktrt_last_error(NULL))) return NULL;
  for (uint32_t i = 0; i < w->n; i++) {
    uint32_t index = 99;
    CHECK(mesh_add(s, &w->m[i], &index) == PKTRT_OK && index == i, "mesh %u: %s", i, pktrt_last_error(s));
  }
  CHECK(pktrt_commit(s) == PKTRT_OK, "commit: %s", pktrt_last_error(s));
  return s;
}

static world world_base(int level) {
  world w = world_none();
  w.n = 4;
  w.m[0] = mesh_sphere(level, 0.04f, 1);
  w.m[1] = mesh_grid(24, 4);
  w.m[2] = mesh_box();
  w.m[3] = mesh_soup(1800, 0.08f, 2);
  mesh_shift(&w.m[1], 0, -1.25f, 0);
  mesh_place(&w.m[2], (float[3]){0.4f, 0.7f, 0.5f}, (float[3]){1.9f, -0.5f, 0.3f});
  mesh_place(&w.m[3], (float[3]){2, 1, 2}, (float[3]){-0.5f, 0.5f, 0});
  return w;
}

world world_static(int level) { return world_base(level); }

world world_moving(int level) {
  world w = world_base(level);
  mesh_move(&w.m[0], 2, 0.15f, 0.01f, 3);
  mesh_move(&w.m[2], 5, 0.1f, 0.05f, 4);
  mesh_move(&w.m[3], 3, 0.05f, 0.1f, 5);
  return w;
}

/* --- rays --- */

const char *ray_kind_name[RAYS_KINDS] = {
    "camera", "bundles", "random", "edge-aimed", "vertex-aimed", "axis-parallel", "spawned", "mixed with invalid"};

pktrt_ray ray_towards(const float o[3], const float p[3], float time) {
  pktrt_ray r = ray_of(o[0], o[1], o[2], p[0] - o[0], p[1] - o[1], p[2] - o[2]);
  r.time = time;
  return r;
}

static const mesh *pick_mesh(const world *w, rng *r) {
  const mesh *m = &w->m[rng_below(r, w->n)];
  return m->nt ? m : &w->m[0];
}

void pick_vertex(const world *w, rng *r, float time, float out[3]) {
  const mesh *m = pick_mesh(w, r);
  ref_vertex(m, m->i[rng_below(r, m->nt * 3)], time, out);
}

void pick_edge(const world *w, rng *r, float time, float out[3]) {
  const mesh *m = pick_mesh(w, r);
  uint32_t t = rng_below(r, m->nt), e = rng_below(r, 3);
  float a[3], b[3], f = rng_unit(r);
  ref_vertex(m, m->i[t * 3 + e], time, a);
  ref_vertex(m, m->i[t * 3 + (e + 1) % 3], time, b);
  for (int k = 0; k < 3; k++) out[k] = a[k] + f * (b[k] - a[k]);
}

void random_point(const world *w, rng *r, float spread, float out[3]) {
  const float *a = w->m[0].p, *b = a + 3 * (size_t)rng_below(r, w->m[0].nv);
  float size = fabsf(a[0] - b[0]) + fabsf(a[1] - b[1]) + fabsf(a[2] - b[2]);
  for (int k = 0; k < 3; k++) out[k] = b[k] + spread * size * rng_sign(r);
}

static float some_time(rng *r) {
  static const float special[8] = {0, 1, 0.25f, 0.5f, 0.75f, -1, 2, 0.99999994f};
  uint32_t k = rng_below(r, 40);
  return k < 8 ? special[k] : rng_unit(r);
}

pktrt_ray invalid_ray(rng *r, pktrt_ray x) {
  static const float odd[5] = {NAN, INFINITY, -INFINITY, 2e30f, -3e38f};
  switch (rng_below(r, 12)) {
  case 0: x.origin[rng_below(r, 3)] = odd[rng_below(r, 5)]; break;
  case 1: x.direction[rng_below(r, 3)] = odd[rng_below(r, 3)]; break;
  case 2: x.direction[0] = x.direction[1] = 0, x.direction[2] = -0.0f; break;
  case 3: x.tmax = x.tmin; break;
  case 4: x.tmin = NAN; break;
  case 5: x.tmax = NAN; break;
  case 6: x.tmin = INFINITY; break;
  case 7: x.tmax = -1; break;
  default: memset(&x, 0, sizeof x);
  }
  return x;
}

void make_rays(
    const world *w, const pktrt_scene *s, ray_kind kind, uint64_t seed, size_t first, pktrt_ray *out, size_t n) {
  static const float axis[4] = {0.0f, -0.0f, 1.0f, -1.0f};
  for (size_t j = 0; j < n; j++) {
    uint64_t i = first + j;
    rng r = rng_of(seed * 31 + (uint64_t)kind + i * 977);
    float o[3], p[3], time = some_time(&r);
    pktrt_ray x = ray_of(0, 0, 0, 0, 0, 0);
    random_point(w, &r, 1.5f, o);
    switch (kind) {
    case RAYS_CAMERA: { /* 8 x 8 pixels after one another, a new eye every 4096 rays */
      rng v = rng_of(seed + i / 4096);
      uint32_t px = (uint32_t)(i % 8 + i / 64 % 8 * 8), py = (uint32_t)(i / 8 % 8 + i / 512 % 8 * 8);
      float eye[3] = {rng_range(&v, -3, 3), rng_range(&v, -1, 3), rng_range(&v, -4, 4)};
      x = ray_of(
          eye[0], eye[1], eye[2], -eye[0] + ((float)px - 31.5f) / 30, -eye[1] + ((float)py - 31.5f) / 30, -eye[2]);
      break;
    }
    case RAYS_BUNDLES: { /* 64 rays in two bundles, as two mirrors send them, and some strays; some look back a little */
      rng v = rng_of(seed + i / 64 * 2 + rng_below(&r, 2));
      for (int k = 0; k < 3; k++) o[k] = rng_range(&v, -2, 2), p[k] = -o[k] + rng_range(&v, -1, 1);
      x = ray_of(o[0] + rng_range(&r, -0.1f, 0.1f), o[1] + rng_range(&r, -0.1f, 0.1f),
          o[2] + rng_range(&r, -0.1f, 0.1f), p[0] + rng_range(&r, -0.1f, 0.1f), p[1] + rng_range(&r, -0.1f, 0.1f),
          p[2] + rng_range(&r, -0.1f, 0.1f));
      if (rng_below(&r, 10) == 0) random_point(w, &r, 1.0f, p), x = ray_towards(o, p, time);
      if (i / 64 % 4 == 0 && rng_below(&r, 8) == 0) x.tmin = -0.5f;
      break;
    }
    case RAYS_RANDOM:
      random_point(w, &r, 1.0f, p);
      x = ray_towards(o, p, time);
      if (rng_below(&r, 4) == 0) x.tmin = rng_range(&r, -2, 1), x.tmax = rng_range(&r, 0, 2);
      break;
    case RAYS_EDGE:
    case RAYS_VERTEX:
      if (i / 64 % 3 == 0) { /* a common origin for 64 rays */
        rng v = rng_of(seed + i / 64);
        random_point(w, &v, 1.5f, o);
      }
      if (kind == RAYS_VERTEX) pick_vertex(w, &r, time, p);
      else pick_edge(w, &r, time, p);
      x = ray_towards(o, p, time);
      break;
    case RAYS_AXIS: /* 56 directions of 0, -0, 1, -1; origins on vertex coordinates as often as not */
      do {
        for (int k = 0; k < 3; k++) x.direction[k] = axis[rng_below(&r, 4)];
      } while (x.direction[0] == 0 && x.direction[1] == 0 && x.direction[2] == 0);
      for (int k = 0; k < 3; k++) {
        pick_vertex(w, &r, time, p);
        x.origin[k] = rng_below(&r, 2) ? p[k] : o[k];
      }
      break;
    case RAYS_SPAWNED: {
      pktrt_hit h;
      random_point(w, &r, 0.3f, p);
      x = ray_towards(o, p, time);
      if (pktrt_intersect(s, &x, &h)) {
        for (int k = 0; k < 3; k++) x.origin[k] += h.t * x.direction[k];
        for (int k = 0; k < 3; k++) x.direction[k] = rng_sign(&r);
        if (rng_below(&r, 2)) { /* half of them with the library's offset */
          pktrt_ray from = ray_towards(o, p, time);
          float d[3] = {x.direction[0], x.direction[1], x.direction[2]};
          pktrt_spawn(s, &from, &h, d, &x);
        }
      }
      break;
    }
    case RAYS_INVALID: /* packets of all sorts with holes, often right at the start */
      make_rays(w, s, i / 64 % 2 ? RAYS_CAMERA : RAYS_EDGE, seed, (size_t)i, &x, 1);
      if (i % 64 < i / 128 % 4 || rng_below(&r, 3) == 0) x = invalid_ray(&r, x);
      break;
    default: break;
    }
    if (kind != RAYS_INVALID) x.time = time;
    out[j] = x;
  }
}
