/* Models and instances: the same bits as of meshes that are added directly, where these exist; the documented ray, asked of
   the model alone, elsewhere. Changes, refusals, failures of memory, pictures. */
#include "placed.h"
#include "ways.h"

static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

static uint32_t add_model(pktrt_scene *s, const world *w) {
  pktrt_mesh_desc d[WORLD_MESHES];
  uint32_t model = PKTRT_NONE;
  for (uint32_t i = 0; i < w->n; i++) d[i] = mesh_desc(&w->m[i]);
  CHECK(pktrt_add_model(s, d, w->n, &model) == PKTRT_OK, "%s", pktrt_last_error(s));
  return model;
}
static uint32_t add_instance(pktrt_scene *s, uint32_t model, uint32_t keys, const float *transforms) {
  const pktrt_instance_desc d = {model, keys, transforms, 0, PKTRT_INTERPOLATION_LINEAR};
  uint32_t instance = PKTRT_NONE;
  CHECK(pktrt_add_instance(s, &d, &instance) == PKTRT_OK, "%s", pktrt_last_error(s));
  return instance;
}
static void commit(pktrt_scene *s) { CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s)); }
static pktrt_scene *open_scene(pktrt_isa isa) {
  const pktrt_scene_desc d = scene_desc_of(isa, 0);
  return pktrt_scene_create(&d);
}
/* A world as an instance at rest, alone in a scene. */
static pktrt_scene *placed(const world *w, pktrt_isa isa, const float *transform) {
  pktrt_scene *s = open_scene(isa);
  add_instance(s, add_model(s, w), 1, transform);
  commit(s);
  return s;
}

static void identity_has_the_bits(void) {
  const size_t n = small_run ? 256 : MANY;
  size_t wrong = 0, hits = 0, control = 0, rays = 0;
  for (int moving = 0; moving < 2; moving++) {
    world w = moving ? world_moving(3) : world_static(3);
    for (int k = 0; k < isa_count; k++) {
      pktrt_scene *flat = world_scene(&w, isas[k], 0), *s = placed(&w, isas[k], NULL);
      static const float beside[12] = {1, 0, 0, 0.001f, 0, 1, 0, 0, 0, 0, 1, 0};
      pktrt_scene *other = placed(&w, isas[k], beside);
      hits += compare(flat, s, &w, n, &wrong), rays += n * RAYS_KINDS;
      if (k == 0) (void)compare(flat, other, &w, 64, &control);
      pktrt_scene_destroy(flat), pktrt_scene_destroy(s), pktrt_scene_destroy(other);
    }
    world_free(&w);
  }
  CHECK(wrong == 0, "%zu answers differ", wrong);
  CHECK(control > 100, "the control, a thousandth beside, differs");
  say("%zu rays, %zu hits, seven ways each: %zu differ; control, a thousandth beside: %zu differ", rays, hits, wrong,
      control);
}

/* On a grid of 2^-10 scales by powers of two and integer shifts are exact, for vertices and for rays. */
static void to_grid(float *p, size_t n) {
  for (size_t i = 0; i < n; i++) p[i] = roundf(p[i] * 1024) / 1024;
}
static void powers_of_two_are_predicted(void) {
  const float transform[12] = {4, 0, 0, -3, 0, 4, 0, 8, 0, 0, 4, 5};
  const size_t n = small_run ? 256 : MANY;
  static pktrt_ray rays[MANY];
  static answers want, got;
  size_t wrong = 0, hits = 0;
  world w = world_static(3), scaled_up = world_static(3);
  for (uint32_t m = 0; m < w.n; m++) {
    to_grid(w.m[m].p, (size_t)w.m[m].nv * 3);
    for (size_t i = 0; i < (size_t)w.m[m].nv * 3; i++) scaled_up.m[m].p[i] = 4 * w.m[m].p[i] + transform[i % 3 * 4 + 3];
  }
  for (int k = 0; k < isa_count; k++) {
    pktrt_scene *flat = world_scene(&scaled_up, isas[k], 0), *s = placed(&w, isas[k], transform);
    for (int kind = 0; kind < RAYS_KINDS; kind++) {
      if (kind == RAYS_INVALID) continue;
      make_rays(&scaled_up, flat, (ray_kind)kind, 3, 0, rays, n);
      for (size_t i = 0; i < n; i++) to_grid(rays[i].origin, 3);
      ask(flat, 0, rays, n, &want);
      hits += hits_of(&want, n);
      for (int way = 0; way < WAYS; way++) ask(s, way, rays, n, &got), wrong += differ(&want, &got, n);
    }
    pktrt_scene_destroy(flat), pktrt_scene_destroy(s);
  }
  CHECK(wrong == 0 && hits > n, "%zu of %zu hits differ", wrong, hits);
  say("four times as large, shifted by integers: %zu hits, %zu answers differ", hits, wrong);
  world_free(&w), world_free(&scaled_up);
}

/* --- anything else: the ray that >>frames defines, asked of the model alone --- */

enum { FIELD = 48, KEYS = 3 };
typedef struct field {
  world w[2];
  pktrt_scene *model[2], *s[8];
  uint32_t first[FIELD], of[FIELD], keys[FIELD]; /* first mesh, model, motion keys */
  float transform[FIELD][KEYS * 12];
} field;

/* Turned, scaled unevenly, sheared, half of them mirrored; later keys a little aside. */
static void random_transform(rng *r, float *m, const float *before) {
  const int turn = (int)rng_below(r, 3);
  for (int i = 0; i < 3; i++)
    for (int j = 0; j < 4; j++) {
      const float aside = (j < 3 ? 0.02f : 0.1f) * rng_sign(r), diagonal = i == (j + turn) % 3 ? 0.5f : 0;
      m[4 * i + j] = before ? before[4 * i + j] + aside : j == 3 ? 5 * rng_sign(r) : 0.12f * rng_sign(r) + diagonal;
    }
  for (int i = 0; i < 3 && !before && turn; i++) m[4 * i] = -0.3f * m[4 * i];
}
static void keep_diagonal(float *m) {
  for (int k = 0; k < 12; k++)
    if (k % 4 < 3) m[k] = k % 4 == k / 4 ? 0.5f : 0;
}
static void field_open(field *f, uint64_t seed) {
  rng r = rng_of(seed);
  memset(f, 0, sizeof *f);
  f->w[0] = world_of(mesh_sphere(2, 0.1f, 3)), f->w[1] = world_moving(1);
  for (uint32_t i = 0; i < 2; i++) f->model[i] = world_scene(&f->w[i], PKTRT_ISA_AUTO, 0);
  for (int k = 0; k < isa_count; k++) {
    f->s[k] = open_scene(isas[k]);
    const uint32_t model[2] = {add_model(f->s[k], &f->w[0]), add_model(f->s[k], &f->w[1])};
    uint32_t meshes = 0;
    for (uint32_t i = 0; i < FIELD; i++) {
      f->of[i] = i % 5 == 4, f->keys[i] = 1 + i % KEYS;
      for (uint32_t key = 0; k == 0 && key < f->keys[i]; key++) {
        random_transform(&r, f->transform[i] + 12 * key, key ? f->transform[i] + 12 * (key - 1) : NULL);
        if (i % 7 == 2 && key < 2)
          keep_diagonal(f->transform[i] + 12 * key); /* not the third: is diagonal at some keys */
      }
      CHECK(add_instance(f->s[k], model[f->of[i]], f->keys[i], f->transform[i]) == i);
      f->first[i] = meshes, meshes += f->w[f->of[i]].n;
    }
    commit(f->s[k]);
  }
}
static void field_close(field *f) {
  for (int i = 0; i < 2; i++) pktrt_scene_destroy(f->model[i]), world_free(&f->w[i]);
  for (int k = 0; k < isa_count; k++) pktrt_scene_destroy(f->s[k]);
}

/* The documented ray in the frame of an instance; `rough`: an ulp beside it, for the control. */
static pktrt_ray ray_in(const field *f, uint32_t i, const pktrt_ray *ray, bool rough) {
  pktrt_ray out = ray_within(f->transform[i], f->keys[i], ray);
  for (int a = 0; a < 3 && rough; a++) out.origin[a] = nextafterf(out.origin[a], INFINITY);
  return out;
}

/* The least (t, mesh, triangle) over all instances; the normal is that of another test. */
static pktrt_hit expected(const field *f, const pktrt_ray *ray, bool rough) {
  pktrt_hit best;
  memset(&best, 0, sizeof best);
  best.t = ray->tmax, best.mesh = best.triangle = PKTRT_NONE;
  for (uint32_t i = 0; i < FIELD; i++) {
    const pktrt_ray within = ray_in(f, i, ray, rough);
    pktrt_hit hit;
    if (pktrt_intersect(f->model[f->of[i]], &within, &hit) && (best.mesh == PKTRT_NONE || hit.t < best.t))
      best = hit, best.mesh += f->first[i];
  }
  return best;
}

static pktrt_ray field_ray(const field *f, rng *r) {
  const uint32_t i = rng_below(r, FIELD);
  const world *w = &f->w[f->of[i]];
  float target[3], at[3], origin[3];
  const float time = rng_unit(r);
  if (rng_u32(r) & 1) pick_vertex(w, r, time, target); /* rays that touch silhouettes are the hard ones for boxes */
  else pick_edge(w, r, time, target);
  const float *m = f->transform[i];
  for (int a = 0; a < 3; a++) {
    at[a] = m[4 * a] * target[0] + m[4 * a + 1] * target[1] + m[4 * a + 2] * target[2] + m[4 * a + 3];
    origin[a] = 8 * rng_sign(r);
  }
  return ray_towards(origin, at, time);
}

static void hits_are_those_of_the_documented_ray(void) {
  const size_t n = scaled(40000) / MANY * MANY + (small_run ? 512 : 0), step = small_run ? 512 : MANY;
  static field f;
  static pktrt_ray rays[MANY];
  static answers got;
  size_t wrong = 0, control = 0, hits = 0;
  rng r = rng_of(11);
  field_open(&f, 5);
  for (size_t done = 0; done < n; done += step) {
    static pktrt_hit want[MANY];
    for (size_t i = 0; i < step; i++) {
      rays[i] = field_ray(&f, &r);
      want[i] = expected(&f, &rays[i], false);
      hits += want[i].mesh != PKTRT_NONE;
      const pktrt_hit other = expected(&f, &rays[i], true);
      control += !same_bits(&other.t, &want[i].t, 3 * sizeof(float)) || other.triangle != want[i].triangle;
    }
    for (int k = 0; k < isa_count; k++)
      for (int way = 0; way < WAYS; way++) {
        ask(f.s[k], way, rays, step, &got);
        for (size_t i = 0; i < step; i++) {
          const pktrt_hit *h = &got.hit[i];
          wrong += !same_bits(&h->t, &want[i].t, 3 * sizeof(float)) || h->mesh != want[i].mesh ||
                   h->triangle != want[i].triangle || got.occluded[i] != (want[i].mesh != PKTRT_NONE);
        }
      }
  }
  CHECK(wrong == 0, "%zu answers are wrong", wrong);
  CHECK(hits > n / 2 && control > n / 50, "%zu hits, control %zu", hits, control);
  say("%zu rays at vertices and edges of %d instances, %d ways on each instruction set: %zu hits, %zu wrong; control "
      "an ulp beside: %zu",
      n, FIELD, WAYS, hits, wrong, control);
  field_close(&f);
}

/* All crossings: each instance's, in order of (t, mesh, triangle). */
static void crossings_come_one_by_one(void) {
  static field f;
  size_t wrong = 0, crossings = 0;
  rng r = rng_of(12);
  field_open(&f, 6);
  for (size_t i = 0; i < scaled(2000); i++) {
    const pktrt_ray ray = field_ray(&f, &r);
    pktrt_hit list[64], one[64];
    size_t want = 0;
    for (uint32_t k = 0; k < FIELD; k++) {
      const pktrt_ray within = ray_in(&f, k, &ray, false);
      want += pktrt_intersect_all(f.model[f.of[k]], &within, one, 64);
    }
    const size_t n = pktrt_intersect_all(f.s[0], &ray, list, 64);
    wrong += n != want;
    for (size_t k = 1; k < n && k < 64; k++)
      wrong += list[k].t < list[k - 1].t || (list[k].t == list[k - 1].t && list[k].mesh < list[k - 1].mesh);
    crossings += n;
  }
  CHECK(wrong == 0 && crossings > scaled(2000), "%zu wrong of %zu", wrong, crossings);
  say("%zu crossings, %zu lists wrong", crossings, wrong);
  field_close(&f);
}

/* Triangles that coincide are crossed one after the other, the first of an instance as all others, in instances that coincide as
   well. */
static void crossings_of_coincident_triangles(void) {
  static const float corners[3][9] = {
      {-1, -1, 0, 1, -1, 0, 0, 1, 0}, {-1, -1, 0, 1, -1, 0, 0, 1, 0}, {-1, -1, 0, 1, -1, 0, 0, 1, 0}};
  for (uint32_t places = 1; places < 4; places++) {
    pktrt_hit list[16], next;
    pktrt_instance_desc in;
    pktrt_mesh_desc d;
    memset(&d, 0, sizeof d), memset(&in, 0, sizeof in);
    d.positions = corners[0], d.vertex_count = 9, d.triangle_count = 3;
    const pktrt_scene_desc of = scene_desc_of(PKTRT_ISA_AUTO, 0);
    pktrt_scene *s = pktrt_scene_create(&of);
    CHECK(pktrt_add_model(s, &d, 1, &in.model) == PKTRT_OK);
    for (uint32_t i = 0; i < places; i++) CHECK(pktrt_add_instance(s, &in, NULL) == PKTRT_OK);
    CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
    const pktrt_ray ray = ray_of(0.1f, 0.1f, 4, 0, 0, -1);
    const size_t n = pktrt_intersect_all(s, &ray, list, 16);
    CHECK(n == 3 * (size_t)places, "%zu crossings", n);
    size_t one_by_one = 0;
    for (bool more = pktrt_intersect(s, &ray, &next); more && one_by_one < 16; one_by_one++) {
      const uint32_t k = (uint32_t)one_by_one;
      CHECK(next.mesh == k / 3 && next.triangle == k % 3, "%u: mesh %u, triangle %u", (unsigned)k, (unsigned)next.mesh,
          (unsigned)next.triangle);
      CHECK(one_by_one < n && same_bits(&next, &list[k], sizeof next));
      more = pktrt_intersect_after(s, &ray, &next, &next);
    }
    CHECK(one_by_one == n, "%zu one by one", one_by_one);
    pktrt_scene_destroy(s);
  }
}

/* Normals are crosses of transformed edges. */
static void normals_are_crosses_of_transformed_edges(void) {
  static field f;
  double worst = 0;
  size_t turned = 0, hits = 0;
  rng r = rng_of(13);
  field_open(&f, 7);
  for (size_t i = 0; i < scaled(20000); i++) {
    pktrt_ray ray = field_ray(&f, &r);
    pktrt_hit hit;
    uint32_t instance, of;
    ray.time = 0;
    if (!pktrt_intersect(f.s[0], &ray, &hit) || !CHECK(pktrt_get_mesh_source(f.s[0], hit.mesh, &instance, &of)))
      continue;
    const mesh *m = &f.w[f.of[instance]].m[of];
    const float *t = f.transform[instance];
    double p[3][3], n[3], dot = 0, nn = 0, hh = 0;
    for (int c = 0; c < 3; c++) {
      const float *v = m->p + 3 * (size_t)m->i[3 * (size_t)hit.triangle + (size_t)c];
      for (int a = 0; a < 3; a++)
        p[c][a] =
            (double)t[4 * a] * (double)v[0] + (double)t[4 * a + 1] * (double)v[1] + (double)t[4 * a + 2] * (double)v[2];
    }
    for (int a = 0; a < 3; a++) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      n[a] = (p[1][b] - p[0][b]) * (p[2][c] - p[0][c]) - (p[1][c] - p[0][c]) * (p[2][b] - p[0][b]);
      dot += n[a] * (double)hit.normal[a], nn += n[a] * n[a], hh += (double)hit.normal[a] * (double)hit.normal[a];
    }
    hits++;
    worst = fmax(worst, sqrt(fmax(0, 1 - dot * dot / (nn * hh))));
    turned += dot < 0;
  }
  CHECK(hits > 100 && turned == 0 && worst < 1e-6, "%zu hits, %zu turned, worst %g", hits, turned, worst);
  field_close(&f);
}

/* Fills in the n-th of the 48 transforms that exchange axes and turn them round; none of them rounds anything. */
static void exchange_axes(uint32_t n, float *transform) {
  static const uint8_t order[6][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}, {0, 2, 1}, {2, 1, 0}, {1, 0, 2}};
  memset(transform, 0, 12 * sizeof *transform);
  for (int a = 0; a < 3; a++) transform[4 * a + order[n / 8][a]] = n >> a & 1 ? -1.0f : 1.0f;
}

/* Fills in a triangle whose third corner lies a few floats beside the middle of the edge opposite, where floats are small. */
static void make_needle(rng *r, float corner[3][3]) {
  memset(corner, 0, 9 * sizeof(float));
  corner[1][0] = rng_range(r, 0.5f, 1), corner[1][1] = rng_range(r, 0.5f, 1), corner[1][2] = rng_unit(r) / 256;
  for (int a = 0; a < 3; a++) corner[2][a] = corner[1][a] / 2;
  for (uint32_t i = 1 + rng_below(r, 3); i; i--) corner[2][2] = nextafterf(corner[2][2], 1);
}

/* Needles whose edges no double cross tells from lines, in instances that exchange axes, have the bits that they have where their
   corners are exchanged. */
static void needles_in_instances_have_their_normals(void) {
  const size_t needles = scaled(400);
  size_t hits = 0, wrong = 0, thin = 0, reversed = 0;
  rng r = rng_of(17);
  for (size_t i = 0; i < needles; i++) {
    float transform[12], model[3][3], placed[3][3];
    double most = 0;
    make_needle(&r, model);
    exchange_axes((uint32_t)(i % 48), transform);
    for (int c = 0; c < 3; c++)
      for (int a = 0; a < 3; a++) {
        const float *row = transform + 4 * a;
        placed[c][a] = row[0] * model[c][0] + row[1] * model[c][1] + row[2] * model[c][2];
      }
    for (int a = 0; a < 3; a++) {
      const int b = (a + 1) % 3, c = (a + 2) % 3;
      most =
          fmax(most, fabs((double)placed[1][b] * (double)placed[2][c] - (double)placed[1][c] * (double)placed[2][b]));
    }
    thin += most < 0x1p-28;

    pktrt_mesh_desc d;
    memset(&d, 0, sizeof d);
    d.positions = model[0], d.vertex_count = 3, d.triangle_count = 1;
    pktrt_scene *s[2];
    uint32_t of = 0;
    for (int k = 0; k < 2; k++) s[k] = pktrt_scene_create(NULL);
    const pktrt_instance_desc at = {0, 1, transform, 0, PKTRT_INTERPOLATION_LINEAR};
    CHECK(pktrt_add_model(s[0], &d, 1, &of) == PKTRT_OK && pktrt_add_instance(s[0], &at, NULL) == PKTRT_OK);
    d.positions = placed[0];
    CHECK(pktrt_add_mesh(s[1], &d, NULL) == PKTRT_OK);
    for (int k = 0; k < 2; k++) commit(s[k]);

    for (int k = 0; k < 40; k++) {
      const float part = rng_range(&r, 0.3f, 0.9f), side = k & 1 ? 1.0f : -1.0f;
      const float point[3] = {
          part * model[1][0], part * model[1][1], nextafterf(part * model[1][2], k & 2 ? 1.0f : 0.0f)};
      const float way[3] = {side * rng_range(&r, 0.5f, 1), -side * rng_range(&r, 0.5f, 1), 0};
      float origin[3], direction[3];
      pktrt_hit hit[2];
      for (int a = 0; a < 3; a++) {
        const float *row = transform + 4 * a;
        direction[a] = row[0] * way[0] + row[1] * way[1] + row[2] * way[2];
        origin[a] = row[0] * point[0] + row[1] * point[1] + row[2] * point[2] - direction[a];
      }
      const pktrt_ray ray = ray_of(origin[0], origin[1], origin[2], direction[0], direction[1], direction[2]);
      const bool there = pktrt_intersect(s[1], &ray, &hit[1]);
      const bool here = pktrt_intersect(s[0], &ray, &hit[0]);
      wrong += here != there;
      if (!here || !there) continue;
      hits++;
      wrong += hit[0].t != hit[1].t || hit[0].u != hit[1].u || hit[0].v != hit[1].v;
      wrong += !same_bits(hit[0].normal, hit[1].normal, sizeof hit[0].normal);
      float turned[3];
      for (int a = 0; a < 3; a++) turned[a] = -hit[1].normal[a];
      reversed += !same_bits(hit[0].normal, turned, sizeof turned);
    }
    for (int k = 0; k < 2; k++) pktrt_scene_destroy(s[k]);
  }
  CHECK(wrong == 0 && hits > needles && thin > needles / 2 && reversed == hits, "%zu of %zu hits wrong, %zu thin",
      wrong, hits, thin);
  say("%zu needles, %zu of them thinner than 2^-28: %zu hits, %zu have other normals; control, turned round: %zu",
      needles, thin, hits, wrong, reversed);
}

/* Rays that leave a surface of an instance do not meet the triangle that they left, though they nearly do. */
static void rays_leave_instances(void) {
  static field f;
  size_t met = 0, control = 0, rays = 0;
  rng r = rng_of(14);
  field_open(&f, 8);
  for (size_t i = 0; i < scaled(20000); i++) {
    const pktrt_ray ray = field_ray(&f, &r);
    pktrt_hit hit, again;
    if (!pktrt_intersect(f.s[0], &ray, &hit)) continue;
    for (int side = 0; side < 4; side++) {
      float d[3];
      pktrt_ray out, plain = ray;
      for (int a = 0; a < 3; a++) d[a] = rng_sign(&r);
      pktrt_spawn(f.s[0], &ray, &hit, d, &out);
      for (int a = 0; a < 3; a++) plain.origin[a] = ray.origin[a] + hit.t * ray.direction[a], plain.direction[a] = d[a];
      met += pktrt_intersect(f.s[0], &out, &again) && again.mesh == hit.mesh && again.triangle == hit.triangle;
      control += pktrt_intersect(f.s[0], &plain, &again) && again.mesh == hit.mesh && again.triangle == hit.triangle;
      rays++;
    }
  }
  CHECK(rays > 100 && met == 0 && control > rays / 20, "%zu rays, %zu meet what they left, control %zu", rays, met,
      control);
  say("%zu rays: %zu meet the triangle that they left; control without pktrt_spawn: %zu", rays, met, control);
  field_close(&f);
}

/* --- changes --- */

static void transforms_change_at_commit_and_refit(void) {
  world w = world_static(2);
  static pktrt_ray rays[MANY];
  static answers before, now, want;
  float turn[12] = {0, 0, 1, 0.5f, 0, 1, 0, 0, -1, 0, 0, 0};
  pktrt_scene *s = placed(&w, PKTRT_ISA_AUTO, NULL), *fresh = placed(&w, PKTRT_ISA_AUTO, turn);
  make_rays(&w, s, RAYS_RANDOM, 1, 0, rays, MANY);
  ask(s, 1, rays, MANY, &before), ask(fresh, 1, rays, MANY, &want);
  for (int refit = 0; refit < 2; refit++) {
    CHECK(pktrt_set_transform(s, 0, 0, turn) == PKTRT_OK, "%s", pktrt_last_error(s));
    ask(s, 1, rays, MANY, &now);
    CHECK(differ(&now, &before, MANY) == 0, "what is set waits");
    CHECK((refit ? pktrt_refit(s) : pktrt_commit(s)) == PKTRT_OK, "%s", pktrt_last_error(s));
    ask(s, 1, rays, MANY, &now);
    CHECK(differ(&now, &want, MANY) == 0, "%zu answers differ from those of a new scene", differ(&now, &want, MANY));
    CHECK(pktrt_set_transform(s, 0, 0, identity) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK);
    ask(s, 1, rays, MANY, &now);
    CHECK(differ(&now, &before, MANY) == 0, "and back");
  }
  CHECK(differ(&before, &want, MANY) > 100, "the control: turned, other things are hit");
  pktrt_scene_destroy(s), pktrt_scene_destroy(fresh);
  world_free(&w);
}

static void mistakes_are_refused_by_name(void) {
  const pktrt_status no = PKTRT_INVALID_ARGUMENT;
  world w = world_static(1);
  pktrt_scene *s = placed(&w, PKTRT_ISA_AUTO, NULL);
  pktrt_mesh_desc bad = mesh_desc(&w.m[0]);
  float flat[12] = {1, 0, 0, 0, 0, 1, 0, 0, 1, 1, 0, 0}, through[24], far[12], nan[12];
  memcpy(through, identity, sizeof identity), memcpy(through + 12, identity, sizeof identity), through[12] = -1;
  memcpy(far, identity, sizeof identity), far[0] = far[3] = 1e30f;
  memcpy(nan, identity, sizeof identity), nan[7] = NAN;
  pktrt_instance_desc d = {1, 1, NULL, 0, PKTRT_INTERPOLATION_LINEAR};
  says(s, pktrt_add_model(s, NULL, 1, NULL), no, "model 1: it has no meshes");
  bad.vertex_count = 1;
  says(s, pktrt_add_model(s, &bad, 1, NULL), no, "model 1: mesh 0");
  says(s, pktrt_add_instance(s, NULL, NULL), no, "instance 1: the description is NULL");
  says(s, pktrt_add_instance(s, &d, NULL), no, "instance 1: there is no model 1 among 1");
  d.model = 0, d.key_count = 5000;
  says(s, pktrt_add_instance(s, &d, NULL), PKTRT_LIMIT, "instance 1: key_count 5000");
  d.key_count = 1, d.transforms = flat;
  says(s, pktrt_add_instance(s, &d, NULL), no, "instance 1: its transform flattens it");
  d.transforms = nan;
  says(s, pktrt_add_instance(s, &d, NULL), no, "instance 1, key 0: element 7");
  d.transforms = far;
  says(s, pktrt_add_instance(s, &d, NULL), PKTRT_LIMIT, "instance 1, key 0: it reaches beyond");
  d.key_count = 2, d.transforms = through;
  says(s, pktrt_add_instance(s, &d, NULL), no, "give it more keys");
  says(s, pktrt_set_transform(s, 7, 0, identity), no, "there is no instance 7 among 1");
  says(s, pktrt_set_transform(s, 0, 3, identity), no, "there is no such key");
  says(s, pktrt_set_transform(s, 0, 0, NULL), no, "the array is NULL");
  says(s, pktrt_set_transform(s, 0, 0, flat), no, "flattens");
  says(s, pktrt_set_positions(s, 0, 0, w.m[0].p), no, "mesh 0 belongs to instance 0");
  bad = mesh_desc(&w.m[0]), bad.triangle_count = 0, d.model = 1, d.key_count = 1, d.transforms = NULL;
  pktrt_scene *empty = placed(&w, PKTRT_ISA_AUTO, NULL);
  CHECK(!pktrt_add_model(empty, &bad, 1, NULL) && !pktrt_add_instance(empty, &d, NULL) && !pktrt_commit(empty),
      "a model without triangles is fine: %s", pktrt_last_error(empty));
  pktrt_scene_destroy(empty);
  d.model = 0;
  d.key_count = 1, d.transforms = NULL;
  CHECK(pktrt_add_instance(s, &d, NULL) == PKTRT_OK && pktrt_set_transform(s, 0, 0, identity) == PKTRT_OK);
  says(s, pktrt_refit(s), PKTRT_NOT_COMMITTED, "instance 1 was added");
  commit(s);
  pktrt_scene_info info;
  pktrt_get_scene_info(s, &info);
  CHECK(info.instance_count == 2 && info.mesh_count == 2 * w.n);
  uint32_t instance = 9, of = 9;
  CHECK(pktrt_get_mesh_source(s, w.n + 1, &instance, &of) && instance == 1 && of == 1);
  CHECK(!pktrt_get_mesh_source(s, 2 * w.n, NULL, NULL) && !pktrt_get_mesh_source(NULL, 0, NULL, NULL));
  CHECK(pktrt_add_instance(NULL, &d, NULL) == no && pktrt_add_model(NULL, &bad, 1, NULL) == no);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* A model and an instance more, then a move: whatever allocation fails, the scene answers as before, or as after. */
static void allocations_that_fail_lose_nothing(void) {
  world w = world_moving(1);
  static pktrt_ray rays[MANY];
  static answers before, now;
  size_t failed = 0;
  float aside[12];
  memcpy(aside, identity, sizeof aside), aside[3] = 3;
  for (size_t n = 1;; n++) {
    pktrt_scene *s = placed(&w, PKTRT_ISA_AUTO, NULL);
    pktrt_mesh_desc d = mesh_desc(&w.m[0]);
    make_rays(&w, s, RAYS_RANDOM, 2, 0, rays, 256);
    ask(s, 1, rays, 256, &before);
    hooks.fail_at = n, hooks.failed = 0;
    const pktrt_instance_desc more = {1, 1, aside, 0, PKTRT_INTERPOLATION_LINEAR};
    const bool all = !pktrt_add_model(s, &d, 1, NULL) && !pktrt_add_instance(s, &more, NULL) &&
                     !pktrt_set_transform(s, 0, 0, aside) && !pktrt_commit(s);
    hooks.fail_at = 0;
    ask(s, 1, rays, 256, &now);
    if (!all) CHECK(differ(&before, &now, 256) == 0, "allocation %zu failed, and other things are hit", n);
    if (!all) CHECK(strstr(pktrt_last_error(s), "memory"), "%s", pktrt_last_error(s));
    failed += !all;
    if (!all) CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
    pktrt_scene_destroy(s);
    if (all) break;
  }
  CHECK(failed > 10, "%zu", failed);
  world_free(&w);
}

/* Translated rigidly, an instance is where the same mesh is whose vertices have keys. */
static void moving_instances_are_where_moving_vertices_are(void) {
  world w = world_of(mesh_sphere(3, 0.05f, 2));
  float keys[24];
  memcpy(keys, identity, sizeof identity), memcpy(keys + 12, identity, sizeof identity), keys[15] = 2, keys[19] = 0.5f;
  pktrt_scene *s = open_scene(PKTRT_ISA_AUTO);
  add_instance(s, add_model(s, &w), 2, keys);
  commit(s);
  mesh *m = &w.m[0];
  float *p = malloc((size_t)m->nv * 6 * sizeof *p);
  if (!p) abort();
  for (size_t i = 0; i < (size_t)m->nv * 3; i++)
    p[i] = m->p[i], p[(size_t)m->nv * 3 + i] = m->p[i] + keys[12 + i % 3 * 4 + 3];
  free(m->p);
  m->p = p, m->keys = 2;
  pktrt_scene *flat = world_scene(&w, PKTRT_ISA_AUTO, 0);
  size_t hits = 0, other = 0;
  double worst = 0;
  static pktrt_ray rays[MANY];
  make_rays(&w, flat, RAYS_CAMERA, 1, 0, rays, MANY);
  for (size_t i = 0; i < MANY; i++) {
    pktrt_hit a, b;
    const bool one = pktrt_intersect(flat, &rays[i], &a), two = pktrt_intersect(s, &rays[i], &b);
    hits += one;
    if (one != two || a.triangle != b.triangle) other++;
    else if (one) worst = fmax(worst, fabs((double)a.t - (double)b.t) / fabs((double)a.t));
  }
  CHECK(hits > 50 && other <= 2 && worst < 1e-5, "%zu hits, %zu others, t within %g", hits, other, worst);
  pktrt_scene_destroy(s), pktrt_scene_destroy(flat);
  world_free(&w);
}

/* WHY apart from the others: a stream that comes to an instance is driven through its model amid the scene's own trees. */
static void moving_meshes_beside_instances(void) {
  size_t wrong = 0, hits = 0, control = 0;
  for (int k = 0; k < isa_count; k++)
    for (int moving = 0; moving < 2; moving++) {
      world beside = world_moving(2), model = moving ? world_moving(1) : world_static(1);
      pktrt_scene *s[2] = {
          open_scene(isas[k]), open_scene(isas[k])}; /* the second for the control: nothing is beside */
      for (int i = 0; i < 2; i++) {
        for (uint32_t m = 0; m < beside.n && i == 0; m++) CHECK(mesh_add(s[i], &beside.m[m], NULL) == PKTRT_OK);
        const uint32_t of = add_model(s[i], &model);
        rng r = {mix64(9)}; /* whatever the seed: others may flatten */
        for (int n = 0; n < 12; n++) {
          float transform[12];
          random_transform(&r, transform, NULL);
          for (int a = 0; a < 3; a++) transform[4 * a + 3] *= 0.5f;
          add_instance(s[i], of, 1, transform);
        }
        commit(s[i]);
      }
      hits += compare(s[0], s[0], &beside, small_run ? 64 : 256, &wrong);
      if (k == 0) (void)compare(s[0], s[1], &beside, 64, &control);
      pktrt_scene_destroy(s[0]), pktrt_scene_destroy(s[1]);
      world_free(&beside), world_free(&model);
    }
  CHECK(wrong == 0 && hits > 250 * (size_t)isa_count && control > 100, "%zu of %zu differ, control %zu", wrong, hits,
      control);
  say("%zu hits, %zu differ from those of each ray alone; control, nothing beside: %zu differ", hits, wrong, control);
}

static void thousands_take_little_memory(void) {
  enum { N = 2000 };
  world w = world_of(mesh_sphere(3, 0.05f, 2));
  size_t bytes[2];
  for (int flat = 0; flat < 2; flat++) {
    const size_t none = hooks.live_bytes;
    pktrt_scene *s = open_scene(PKTRT_ISA_AUTO);
    const uint32_t model = flat ? 0 : add_model(s, &w);
    const pktrt_mesh_desc d = mesh_desc(&w.m[0]);
    for (uint32_t i = 0; i < (flat ? N / 20 : N); i++) {
      const float at[12] = {1, 0, 0, (float)(i % 50) * 3, 0, 1, 0, (float)(i / 50) * 3, 0, 0, 1, 0};
      if (flat) CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
      else add_instance(s, model, 1, at);
    }
    commit(s);
    bytes[flat] = (hooks.live_bytes - none) * (flat ? 20 : 1);
    pktrt_scene_destroy(s);
  }
  CHECK(bytes[0] < bytes[1] / 50, "%zu bytes, flat %zu", bytes[0], bytes[1]);
  say("%d instances of %u triangles: %.2f MB, flat about %.0f MB", N, (unsigned)w.m[0].nt, (double)bytes[0] / 1e6,
      (double)bytes[1] / 1e6);
  world_free(&w);
}

/* A crowd of instances, far more than one run of a build has; what its told are told. */
enum { CROWD = 20000, CROWD_MOVES = 300 };
typedef struct crowd_hooks {
  uint32_t handed_out; /* pieces of work for threads */
  uint32_t sentences;
  char last[256];
} crowd_hooks;
static void crowd_parallel_for(void *user, size_t n, void (*body)(void *, size_t), void *arg) {
  crowd_hooks *told = user;
  told->handed_out += (uint32_t)n;
  for (size_t i = 0; i < n; i++) body(arg, i);
}
static void crowd_log(void *user, int level, const char *sentence) {
  crowd_hooks *told = user;
  if (level != 1) return;
  told->sentences++;
  snprintf(told->last, sizeof told->last, "%s", sentence);
}
static pktrt_scene *crowd_open(crowd_hooks *told) {
  pktrt_scene_desc d;
  memset(&d, 0, sizeof d);
  memset(told, 0, sizeof *told);
  d.parallel_for = crowd_parallel_for, d.log = crowd_log, d.user = told;
  d.isa = isas[isa_count - 1]; /* of AUTO there may be more to tell */
  return pktrt_scene_create(&d);
}
static const float crowd_triangle[9] = {0, 0, 0, 1, 0, 0.25f, 0.25f, 1, 0};
static pktrt_mesh_desc crowd_mesh(void) {
  pktrt_mesh_desc d;
  memset(&d, 0, sizeof d);
  d.positions = crowd_triangle, d.vertex_count = 3, d.triangle_count = 1;
  return d;
}
/* Where an instance of the crowd lies after so many moves of it. */
static void crowd_place(uint32_t i, uint32_t moves, float transform[12]) {
  memcpy(transform, identity, sizeof identity);
  transform[3] = (float)(i % 200) * 1.5f + (float)moves * 0.375f;
  transform[7] = (float)(i / 200) * 1.5f - (float)moves * 0.25f;
  transform[11] = (float)(mix64(i) % 64) / 16 + (float)moves;
  if (i % 3 == 1) transform[0] = 2;
}
static void crowd_fill(pktrt_scene *s, uint32_t count) {
  const pktrt_mesh_desc d = crowd_mesh();
  float transform[12];
  uint32_t model = PKTRT_NONE;
  CHECK(pktrt_add_model(s, &d, 1, &model) == PKTRT_OK);
  for (uint32_t i = 0; i < count; i++) {
    crowd_place(i, 0, transform);
    add_instance(s, model, 1, transform);
  }
}
/* Tells in how many rays two crowds differ, in hits or in how many boxes these took. */
static size_t crowd_differences(const pktrt_scene *a, const pktrt_scene *b, size_t *hits) {
  size_t differ = 0;
  rng r = {7};
  for (int i = 0; i < 3000; i++) {
    const float x = 300 * rng_unit(&r), y = 150 * rng_unit(&r), x2 = 300 * rng_unit(&r), y2 = 150 * rng_unit(&r);
    const pktrt_ray ray = ray_of(x, y, 8, x2 - x, y2 - y, -9);
    static pktrt_stats stats[2];
    pktrt_query_desc query;
    pktrt_hit hit[2];
    memset(stats, 0, sizeof stats);
    memset(&query, 0, sizeof query);
    query.path = PKTRT_PATH_SINGLE;
    query.stats = &stats[0];
    pktrt_intersect_ex(a, &query, &ray, &hit[0], 1);
    query.stats = &stats[1];
    pktrt_intersect_ex(b, &query, &ray, &hit[1], 1);
    differ += memcmp(&hit[0], &hit[1], sizeof *hit) != 0 || memcmp(&stats[0], &stats[1], sizeof *stats) != 0;
    *hits += hit[0].mesh != PKTRT_NONE;
  }
  return differ;
}
/* How many sentences the log hook hears when 2,000 triangles of a mesh change places and its tree is built anew. */
static uint32_t sentences_of_shuffled_mesh(void) {
  enum { TRIANGLES = 2000 };
  static float p[2][9 * TRIANGLES];
  crowd_hooks told;
  pktrt_scene_desc of;
  pktrt_mesh_desc d = crowd_mesh();
  memset(&of, 0, sizeof of), memset(&told, 0, sizeof told);
  of.rebuild = PKTRT_REBUILD_AUTOMATIC, of.log = crowd_log, of.user = &told;
  pktrt_scene *s = pktrt_scene_create(&of);
  for (uint32_t i = 0; i < 2 * TRIANGLES; i++) {
    float transform[12];
    crowd_place(i < TRIANGLES ? i : (uint32_t)(mix64(i) % TRIANGLES), 0, transform);
    for (int c = 0; c < 9; c++)
      p[i / TRIANGLES][9 * (i % TRIANGLES) + (uint32_t)c] = crowd_triangle[c] + transform[4 * (c % 3) + 3];
  }
  d.positions = p[0], d.vertex_count = 3 * TRIANGLES, d.triangle_count = TRIANGLES;
  CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
  commit(s);
  const uint32_t before = told.sentences;
  CHECK(pktrt_set_positions(s, 0, 0, p[1]) == PKTRT_OK && pktrt_refit(s) == PKTRT_OK);
  pktrt_scene_destroy(s);
  return told.sentences - before;
}

/* The log hook hears of trees that the program made, and not of the tree of boxes above instances, which is built anew when these
   change places. */
static void boxes_are_silent(void) {
  enum { SHUFFLED = 2000 };
  crowd_hooks told;
  pktrt_scene *s = crowd_open(&told);
  float transform[12];
  crowd_fill(s, SHUFFLED);
  commit(s);
  const uint32_t before = told.sentences;
  for (uint32_t i = 0; i < SHUFFLED; i++) {
    crowd_place((uint32_t)(mix64(i) % SHUFFLED), 0, transform);
    CHECK(pktrt_set_transform(s, i, 0, transform) == PKTRT_OK);
  }
  CHECK(pktrt_refit(s) == PKTRT_OK);
  CHECK(told.sentences == before, "the log is told: %s", told.last);
  CHECK(sentences_of_shuffled_mesh() == 1, "the control: of a mesh's tree it is");
  pktrt_scene_destroy(s);
}

/* Instances that are hidden when they are committed are there from the refit on that shows them, one after the other. */
static void hidden_ones_are_shown(void) {
  crowd_hooks one_hooks, all_hooks;
  pktrt_scene *one = crowd_open(&one_hooks), *all = crowd_open(&all_hooks);
  size_t hits = 0, before = 0;
  crowd_fill(one, CROWD), crowd_fill(all, CROWD);
  for (uint32_t i = 0; i < CROWD; i += 3) CHECK(pktrt_set_enabled(one, i, false) == PKTRT_OK);
  commit(one), commit(all);
  const size_t control = crowd_differences(one, all, &before);
  for (uint32_t i = 0; i < CROWD; i += 3) {
    CHECK(pktrt_set_enabled(one, i, true) == PKTRT_OK);
    if (i < 60 || i % 600 == 0) CHECK(pktrt_refit(one) == PKTRT_OK);
  }
  CHECK(pktrt_refit(one) == PKTRT_OK);
  const size_t differ = crowd_differences(one, all, &hits);
  CHECK(differ == 0 && control > 20 && hits > 500, "%zu rays differ, while a third was hidden %zu, of %zu hits", differ,
      control, hits);
  pktrt_scene_destroy(one), pktrt_scene_destroy(all);
}

static void moving_one_looks_at_no_other(void) {
  crowd_hooks one_hooks, all_hooks;
  pktrt_scene *one = crowd_open(&one_hooks), *all = crowd_open(&all_hooks);
  static uint8_t moves[CROWD];
  float transform[12];
  size_t hits = 0, before = 0, differ, control;
  crowd_fill(one, CROWD), crowd_fill(all, CROWD);
  commit(one), commit(all);

  memset(moves, 0, sizeof moves);
  CHECK(crowd_differences(one, all, &before) == 0);
  one_hooks.handed_out = 0;
  for (uint32_t k = 0; k < CROWD_MOVES; k++) {
    const uint32_t i = (uint32_t)(mix64(k) % CROWD);
    crowd_place(i, ++moves[i], transform);
    CHECK(pktrt_set_transform(one, i, 0, transform) == PKTRT_OK);
    if (k % 7 == 0) CHECK(pktrt_set_enabled(one, (i + 1) % CROWD, false) == PKTRT_OK);
    CHECK(pktrt_refit(one) == PKTRT_OK);
    if (k % 7 == 0) CHECK(pktrt_set_enabled(one, (i + 1) % CROWD, true) == PKTRT_OK);
  }
  CHECK(pktrt_refit(one) == PKTRT_OK);
  CHECK(one_hooks.handed_out == 0, "%u pieces of work", (unsigned)one_hooks.handed_out);

  control = crowd_differences(one, all, &hits);
  all_hooks.handed_out = 0;
  for (uint32_t i = 0; i < CROWD; i++) {
    crowd_place(i, moves[i], transform);
    CHECK(pktrt_set_transform(all, i, 0, transform) == PKTRT_OK);
  }
  CHECK(pktrt_refit(all) == PKTRT_OK);
  hits = 0;
  differ = crowd_differences(one, all, &hits);
  CHECK(differ == 0, "%zu rays differ", differ);
  CHECK(control > 20 && hits > 500 && all_hooks.handed_out > 1, "control: %zu rays, %zu hits, %u pieces of work",
      control, hits, (unsigned)all_hooks.handed_out);
  say("%d refits after one of %d moved: %u pieces of work, all at once: %u; %zu rays differ of 3000, before: %zu",
      CROWD_MOVES, CROWD, (unsigned)one_hooks.handed_out, (unsigned)all_hooks.handed_out, differ, control);
  pktrt_scene_destroy(one), pktrt_scene_destroy(all);
}

/* Adds and commits one at a time: groups, instances, or meshes of one tree. Returns how many sentences tell of it. */
static uint32_t dear_commits(int kind, uint32_t first, uint32_t more, uint32_t at_a_time) {
  crowd_hooks told;
  pktrt_scene *s = crowd_open(&told);
  pktrt_mesh_desc d = crowd_mesh();
  if (kind == 1) crowd_fill(s, first);
  for (uint32_t i = 0; kind != 1 && i < first; i++) {
    d.group = kind == 0 ? i : 0;
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
  }
  commit(s);
  for (uint32_t i = 0; i < more; i++) {
    for (uint32_t k = 0; k < at_a_time; k++) {
      d.group = kind == 0 ? first + i * at_a_time + k : 0;
      if (kind == 1) add_instance(s, 0, 1, NULL);
      else CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
    }
    commit(s);
  }
  pktrt_scene_destroy(s);
  return strstr(told.last, "commits in a row did much for little") ? told.sentences : 0;
}
static void dear_commits_are_told(void) {
  for (int kind = 0; kind < 3; kind++) {
    const uint32_t told = dear_commits(kind, 400, 100, 1), few = dear_commits(kind, 400, 31, 1);
    const uint32_t small = dear_commits(kind, 40, 60, 1), many = dear_commits(kind, 400, 36, 400);
    CHECK(told == 1, "kind %d: told %u times", kind, (unsigned)told);
    CHECK(few == 0 && small == 0 && many == 0, "kind %d: 31 commits %u, small ones %u, of many meshes %u", kind,
        (unsigned)few, (unsigned)small, (unsigned)many);
  }
  say("groups, instances, meshes: 100 commits of one more than 400 are told once; 31, of 40, and of 400 at a time are "
      "not");
}

void suite_instances(void) {
  run("an instance under the identity has the bits of its meshes added directly", identity_has_the_bits);
  run("scaled by a power of two and shifted by integers, instances have the bits that are predicted",
      powers_of_two_are_predicted);
  run("hits in instances are those of the documented ray in the model alone, whatever the transform",
      hits_are_those_of_the_documented_ray);
  run("all crossings of instances come one by one, in order", crossings_come_one_by_one);
  run("triangles that coincide are crossed one after the other in instances", crossings_of_coincident_triangles);
  run("normals of instances are crosses of transformed edges, mirrored or not",
      normals_are_crosses_of_transformed_edges);
  run("needles in instances that exchange axes have the normals of needles whose corners are exchanged",
      needles_in_instances_have_their_normals);
  run("rays leave instances without meeting the triangle that they left", rays_leave_instances);
  run("transforms that are set wait for a commit or refit, which makes them what a new scene has",
      transforms_change_at_commit_and_refit);
  run("mistakes with models and instances are refused by name", mistakes_are_refused_by_name);
  run("each allocation of models and instances failing, the scene answers as before",
      allocations_that_fail_lose_nothing);
  run("a moving instance is where the same mesh is with moving vertices",
      moving_instances_are_where_moving_vertices_are);
  run("meshes that move beside instances have the same bits every way", moving_meshes_beside_instances);
  run("moving one of many instances hands out no work, and leaves the boxes that moving all of them leaves",
      moving_one_looks_at_no_other);
  run("instances that are hidden at their commit are there from the refit on that shows them", hidden_ones_are_shown);
  run("the log hook is not told of the trees above instances", boxes_are_silent);
  run("commits that do much for little are told to the log hook, once in a row", dear_commits_are_told);
  run("thousands of instances take a fiftieth of the memory of their triangles", thousands_take_little_memory);
}
