/* Culling is conservative: what packets answer is what each of their rays is answered alone. Every case sees all
   places, sizes of packets, holes in them and intervals, at random. */
#include "noslack.h"
#include "stability.h"

enum { CALL = 1024, BUNDLE = 256, PLACES = 8, STYLES = 8, SILHOUETTES = 6, CASES = 2 * STYLES };

/* --- where: the same meshes at several scales and distances from the origin --- */

typedef struct stage {
  world w;         /* what rays aim at, and what they are asked of, unless there are instances */
  placement place; /* instances, or none */
  float scale, centre[3];
  pktrt_scene *scene[8], *noslack;
} stage;

static const float places[PLACES][2] = {
    {1, 0}, {1, 3}, {1, 100}, {1, 1e4f}, {1e-6f, 0}, {1e8f, 1e7f}, {1e-4f, 10}, {1e20f, -1e22f}}; /* scale, offset */
/* What asks for slack of instances: the shear of one, which is flat at 1, and how far a model is from its origin. */
static const float extremes[PLACES][2] = {
    {0.3f, 1e3f}, {0.9997f, 0}, {0.3f, 0}, {0.9f, 0}, {0.3f, 1e4f}, {0.99997f, 0}, {0.9f, 0}, {0.3f, 0}};

/* Returns a ray that is given in the stage's own frame, where things have sizes of about 1. */
static pktrt_ray placed(const stage *g, const float o[3], const float d[3], float length) {
  pktrt_ray x = ray_of(0, 0, 0, 0, 0, 0);
  for (int k = 0; k < 3; k++) x.origin[k] = g->scale * o[k] + g->centre[k], x.direction[k] = g->scale * length * d[k];
  return x;
}

/* Returns the meshes of a stage, those that instances do not place where they should be. */
static world stage_meshes(bool moves, bool instances) {
  world w = world_of(mesh_sphere(3, 0.1f, 3));
  w.m[1] = mesh_soup(60, 0.3f, 4), w.m[2] = mesh_box(), w.m[3] = mesh_thin(40, 5), w.n = 4;
  if (!instances) mesh_place(&w.m[2], (float[3]){0.4f, 0.7f, 0.5f}, (float[3]){1.5f, -0.5f, 0.3f});
  if (moves) {
    if (!instances) mesh_move(&w.m[0], 2, 0.1f, 0.02f, 6);
    mesh_move(&w.m[1], 3, 0.2f, 0.1f, 7);
    mesh_move(&w.m[2], 2, 0.3f, 0, 8);
  }
  return w;
}

/* --- the meshes as models, placed by instances --- */

enum { LAYS = 7, FAR_MODEL = 2 /* the box, whose edges are those of its bounds */ };
static const struct lay {
  uint32_t model, keys; /* keys: where instances move */
  float at[12];
} lays[LAYS] = {{0, 2, {0.36f, 0.48f, -0.8f, 0, -0.8f, 0.6f, 0, 0, 0.48f, 0.64f, 0.6f, 0}}, /* turned */
    {1, 1, {1, 0.3f, 0, 0, 0, 1, -0.2f, 0, 0.1f, 0, 1, 0}},                                 /* sheared */
    {2, 3, {0.4f, 0, 0, 1.5f, 0, -0.7f, 0, -0.5f, 0, 0, 0.5f, 0.3f}},                       /* mirrored */
    {3, 3, {0.72f, -0.4f, 0, 0.1f, 0.96f, 0.3f, 0, -0.2f, 0, 0, 0.8f, 0.1f}},               /* uneven */
    {0, 3, {0, 0.4f, 0, -1.2f, 0.4f, 0, 0, 0.9f, 0, 0, 0.4f, 0.6f}},                        /* axes swapped */
    {1, 2, {0.3f, 0.1f, -0.2f, 0.9f, 0, 0.6f, 0.1f, 0.8f, 0.2f, -0.1f, -0.4f, -0.7f}},      /* all of it */
    {2, 1, {0.01f, 0, 0, -0.3f, 0, 0.01f, 0, -1.3f, 0, 0, 0.01f, -0.4f}}};                  /* as `extremes` says */

/* Finds the transforms of an instance: as its lay says, and others of the same lay beside it, half as large. */
static void place_model(const stage *g, uint32_t i, const float extreme[2], placement *p) {
  const struct lay *lay = &lays[i % LAYS];
  rng r = rng_of(900 + i);
  float at[12], *key = p->transform[i];
  memcpy(at, lay->at, sizeof at);
  if (i % LAYS == LAYS - 1) at[1] = at[4] = extreme[0] * at[0];
  for (int k = 0; k < 12 && i >= LAYS; k++) at[k] = k % 4 == 3 ? 1.4f * rng_sign(&r) : at[k] / 2;
  for (uint32_t n = 0; n < p->keys[i]; n++, key += 12) {
    for (int k = 0; k < 12; k++) key[k] = g->scale * at[k];
    for (int k = 3; k < 12; k += 4) {
      const float away = lay->model == FAR_MODEL ? extreme[1] * (at[k - 3] + at[k - 2] + at[k - 1]) : 0;
      key[k] = g->scale * (at[k] - away) + g->centre[k / 4];
    }
    for (int k = 0; k < 12; k++) /* zeros stay: what is diagonal is so at all keys */
      at[k] += (k % 4 == 3 ? 0.2f : at[k] != 0 ? 0.04f : 0) * rng_sign(&r);
  }
}

/* Lays out the instances of a stage. Two are in the same place, so that all their hits tie. */
static void place_models(const stage *g, bool moves, const float extreme[2], placement *p) {
  enum { TWIN = 5 };
  for (uint32_t i = 0; i < PLACED; i++) {
    p->of[i] = lays[i % LAYS].model, p->keys[i] = moves ? lays[i % LAYS].keys : 1;
    place_model(g, i, extreme, p);
  }
  memcpy(p->transform[TWIN + LAYS], p->transform[TWIN], sizeof p->transform[TWIN]);
  p->n = PLACED;
}

/* Writes where rays aim at the vertices of an instance at a time; returns what is behind. That is where these are, or where
   rays hit them whose origins are rounded in its frame. */
static float *aim_at_vertices(const stage *g, uint32_t i, float time, float *to) {
  const placement *p = &g->place;
  const mesh *m = &p->model[p->of[i]].m[0];
  rng r = rng_of(30 + i);
  double a[12];
  placed_at(p->transform[i], p->keys[i], time, a);
  for (uint32_t v = 0; v < m->nv; v++) {
    const float eye[3] = {3 * rng_sign(&r), 3 * rng_sign(&r), 3 * rng_sign(&r)};
    const pktrt_ray ray = placed(g, eye, eye, 1), within = ray_within(p->transform[i], p->keys[i], &ray);
    float at[3];
    ref_vertex(m, v, time, at);
    for (int k = 0; k < 3 && i >= LAYS; k++) at[k] += 0x1p-24f * rng_sign(&r) * within.origin[k];
    for (int c = 0; c < 12; c += 4)
      *to++ = (float)(a[c] * (double)at[0] + a[c + 1] * (double)at[1] + a[c + 2] * (double)at[2] + a[c + 3]);
  }
  return to;
}

/* Returns one mesh of all instances of a lay, for rays to aim at. Where they and their model move, vertices go along curves:
   there are so many keys that lines between them are as good. */
static mesh placed_mesh(const stage *g, uint32_t lay) {
  const placement *p = &g->place;
  const mesh *m = &p->model[p->of[lay]].m[0];
  const uint32_t copies = PLACED / LAYS, keys = p->keys[lay];
  mesh out = mesh_of(m->nv * copies, m->nt * copies);
  mesh_move(&out, m->keys == 1 ? keys : keys == 1 ? m->keys : 241, 0, 0, 0); /* makes room for keys */
  for (uint32_t j = 0; j < 3 * out.nt; j++) out.i[j] = m->i[j % (3 * m->nt)] + m->nv * (j / (3 * m->nt));
  float *to = out.p;
  for (uint32_t k = 0; k < out.keys; k++)
    for (uint32_t i = lay; i < PLACED; i += LAYS)
      to = aim_at_vertices(g, i, out.keys > 1 ? (float)k / (float)(out.keys - 1) : 0, to);
  return out;
}

/* Makes models of the meshes of a stage, and instances of these. */
static void raise_instances(stage *g, bool moves, const float extreme[2]) {
  placement *p = &g->place;
  mesh_shift(&g->w.m[FAR_MODEL], extreme[1], extreme[1], extreme[1]);
  for (p->models = 0; p->models < g->w.n; p->models++) {
    p->model[p->models] = world_of(g->w.m[p->models]);
    ref_plant(&p->model[p->models]);
  }
  place_models(g, moves, extreme, p);
  for (g->w.n = 0; g->w.n < LAYS; g->w.n++) g->w.m[g->w.n] = placed_mesh(g, g->w.n);
}

static pktrt_scene *instanced_scene(const placement *p, pktrt_isa isa) {
  const pktrt_scene_desc d = scene_desc_of(isa, 0);
  pktrt_scene *s = pktrt_scene_create(&d);
  CHECK(placement_fill(s, p), "%s", pktrt_last_error(s));
  return s;
}

/* Finds the nearest hit of the documented rays in all instances, each by the reference. The normal stays that of a mesh. */
static void placed_intersect(const placement *p, const pktrt_ray *ray, pktrt_hit *best) {
  memset(best, 0, sizeof *best);
  best->t = ray->tmax, best->mesh = best->triangle = PKTRT_NONE;
  for (uint32_t i = 0; i < p->n && ref_valid(ray); i++) {
    const pktrt_ray within = ray_within(p->transform[i], p->keys[i], ray);
    pktrt_hit hit;
    if (!ref_intersect(&p->model[p->of[i]], &within, &hit)) continue;
    if (best->mesh == PKTRT_NONE || hit.t < best->t) *best = hit, best->mesh = i;
  }
}

/* --- stages --- */

static void raise_stage(stage *g, bool instances, bool moves, int place) {
  const float offset = places[place][1];
  g->scale = places[place][0];
  g->centre[0] = offset, g->centre[1] = 0.3f * offset, g->centre[2] = -offset;
  g->w = stage_meshes(moves, instances);
  if (instances) {
    raise_instances(g, moves, extremes[place]);
  } else {
    world_place(&g->w, g->scale, g->centre[0], g->centre[1], g->centre[2]);
    ref_plant(&g->w);
  }
  for (int i = 0; i < isa_count; i++)
    g->scene[i] = instances ? instanced_scene(&g->place, isas[i]) : world_scene(&g->w, isas[i], 0);
  g->noslack = instances ? noslack_placed(&g->place, PKTRT_ISA_AUTO) : noslack_scene(&g->w, PKTRT_ISA_AUTO);
  CHECK(g->noslack != NULL);
}

static void strike_stage(stage *g) {
  for (int i = 0; i < isa_count; i++) pktrt_scene_destroy(g->scene[i]);
  noslack_destroy(g->noslack);
  world_free(&g->w);
  for (uint32_t i = 0; i < g->place.models; i++) world_free(&g->place.model[i]);
}

/* --- bundles of rays. In the stage's own frame, where things have sizes of about 1 --- */

typedef struct view { /* from an eye to a square of points */
  float eye[3], forward[3], right[3], up[3], spread;
} view;

static float power_of_ten(rng *r, float lo, float hi) { return powf(10, rng_range(r, lo, hi)); }

static void random_in_box(rng *r, float half, float out[3]) {
  for (int k = 0; k < 3; k++) out[k] = half * rng_sign(r);
}

static void cross3(const float a[3], const float b[3], float out[3]) {
  for (int k = 0; k < 3; k++) out[k] = a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3];
}

static void normalise(float v[3]) {
  const float length = sqrtf(dot3(v, v));
  for (int k = 0; k < 3; k++) v[k] = length > 0 ? v[k] / length : k == 0;
}

static view view_along(const float eye[3], const float forward[3], float spread) {
  view v = {{0, 0, 0}, {0, 0, 0}, {0, 0, 0}, {0, 0, 0}, spread};
  const float side[3] = {0.3f, -0.5f, 0.8f};
  memcpy(v.eye, eye, sizeof v.eye);
  memcpy(v.forward, forward, sizeof v.forward);
  normalise(v.forward);
  cross3(v.forward, side, v.right);
  normalise(v.right);
  cross3(v.right, v.forward, v.up);
  return v;
}

static view view_of(rng *r) {
  float eye[3], at[3];
  random_in_box(r, rng_below(r, 4) ? 4 : 0.3f, eye);
  random_in_box(r, 0.8f, at);
  for (int k = 0; k < 3; k++) at[k] -= eye[k];
  return view_along(eye, at, power_of_ten(r, -4, 0.3f));
}

/* Of n rays the j-th goes through a pixel of 8 x 8 or, of more, 16 x 16. */
static void pixel(const view *v, size_t j, size_t n, float d[3]) {
  const size_t side = n > 64 ? 16 : 8;
  const float x = v->spread * ((float)(j % side) / (float)side - 0.47f);
  const float y = v->spread * ((float)(j / side) / (float)side - 0.47f);
  for (int k = 0; k < 3; k++) d[k] = v->forward[k] + x * v->right[k] + y * v->up[k];
}

typedef void make_bundle(const stage *, rng *, const float *times, pktrt_ray *, size_t n);

static void pinhole(const stage *g, rng *r, const float *times, pktrt_ray *out, size_t n) {
  const view v = view_of(r);
  const float length = power_of_ten(r, -2, 2);
  (void)times;
  for (size_t j = 0; j < n; j++) {
    float d[3];
    pixel(&v, j, n, d);
    out[j] = placed(g, v.eye, d, length);
  }
}

static void lens(const stage *g, rng *r, const float *times, pktrt_ray *out, size_t n) {
  const view v = view_of(r);
  const float aperture = power_of_ten(r, -4, 0), focus = rng_range(r, 0.5f, 6);
  (void)times;
  for (size_t j = 0; j < n; j++) {
    float d[3], o[3], x = aperture * rng_sign(r), y = aperture * rng_sign(r);
    pixel(&v, j, n, d);
    for (int k = 0; k < 3; k++) {
      o[k] = v.eye[k] + x * v.right[k] + y * v.up[k];
      d[k] = v.eye[k] + focus * d[k] - o[k];
    }
    out[j] = placed(g, o, d, 1);
  }
}

/* A view in a mirror that is curved a little. */
static void mirror(const stage *g, rng *r, const float *times, pktrt_ray *out, size_t n) {
  const view v = view_of(r);
  const float away = rng_range(r, 0.2f, 5), curve = rng_below(r, 2) ? power_of_ten(r, -3, 0.5f) : 0;
  float normal[3];
  (void)times;
  random_in_box(r, 0.6f, normal);
  for (int k = 0; k < 3; k++) normal[k] -= v.forward[k];
  normalise(normal);
  for (size_t j = 0; j < n; j++) {
    float d[3], o[3], m[3];
    pixel(&v, j, n, d);
    const float depth = away * dot3(v.forward, normal) / dot3(d, normal);
    for (int k = 0; k < 3; k++) {
      o[k] = v.eye[k] + depth * d[k];
      m[k] = normal[k] + curve * (o[k] - v.eye[k] - away * v.forward[k]);
    }
    normalise(m);
    const float along = 2 * dot3(d, m);
    for (int k = 0; k < 3; k++) d[k] -= along * m[k];
    out[j] = placed(g, o, d, 1);
  }
}

/* About an axis or diagonal, where components of directions change their signs; some are zero. */
static void octants(const stage *g, rng *r, const float *times, pktrt_ray *out, size_t n) {
  float at[3], eye[3], d[3] = {0, 0, 0};
  (void)times;
  while (d[0] == 0 && d[1] == 0 && d[2] == 0)
    for (int k = 0; k < 3; k++) d[k] = (float)rng_below(r, 3) - 1;
  random_in_box(r, 0.8f, at);
  for (int k = 0; k < 3; k++) eye[k] = at[k] - rng_range(r, 1, 4) * d[k];
  const view v = view_along(eye, d, power_of_ten(r, -6, 0.5f));
  for (size_t j = 0; j < n; j++) {
    pixel(&v, j, n, d);
    for (int k = 0; k < 3; k++)
      if (fabsf(v.forward[k]) < 0.5f && rng_below(r, 8) == 0) d[k] = rng_below(r, 2) ? 0.0f : -0.0f;
    out[j] = placed(g, eye, d, 1);
  }
}

/* From neighbouring triangles to a point, as shadow rays go. */
static void shadows(const stage *g, rng *r, const float *times, pktrt_ray *out, size_t n) {
  const mesh *m = &g->w.m[rng_below(r, g->w.n)];
  const uint32_t first = rng_below(r, m->nt), many = 1 + rng_below(r, 8);
  float lamp[3];
  random_in_box(r, 4, lamp);
  for (int k = 0; k < 3; k++) lamp[k] = g->scale * lamp[k] + g->centre[k];
  for (size_t j = 0; j < n; j++) {
    const uint32_t t = (first + rng_below(r, many)) % m->nt;
    float p[3][3], o[3], x = rng_unit(r), y = rng_unit(r) * (1 - x);
    for (uint32_t c = 0; c < 3; c++) ref_vertex(m, m->i[3 * t + c], times[j], p[c]);
    for (int k = 0; k < 3; k++) o[k] = p[0][k] + x * (p[1][k] - p[0][k]) + y * (p[2][k] - p[0][k]);
    out[j] = ray_towards(o, lamp, 0);
    out[j].tmax = 1;
  }
}

/* In planes of boxes: along one or two axes all rays stand at a vertex and do not move, or hardly. */
static void planes(const stage *g, rng *r, const float *times, pktrt_ray *out, size_t n) {
  float p[3];
  const uint32_t a = rng_below(r, 3), two = rng_below(r, 3);
  pick_vertex(&g->w, r, times[0], p);
  pinhole(g, r, times, out, n);
  for (size_t j = 0; j < n; j++) {
    if (rng_below(r, 8) == 0) pick_vertex(&g->w, r, times[j], p);
    for (uint32_t k = a; k <= a + (two == 0); k++) {
      out[j].origin[k % 3] = p[k % 3];
      out[j].direction[k % 3] *= rng_below(r, 4) ? 0.0f : 1e-7f;
    }
  }
}

/* At vertices and edges. */
static void silhouettes(const stage *g, rng *r, const float *times, pktrt_ray *out, size_t n) {
  const float apart = rng_below(r, 3) ? 0 : power_of_ten(r, -4, 0);
  const bool ends = rng_below(r, 2) == 0, same = rng_below(r, 4) == 0;
  float eye[3], o[3], p[3];
  random_in_box(r, rng_below(r, 3) ? 3 : 0.2f, eye);
  pick_vertex(&g->w, r, times[0], p);
  for (size_t j = 0; j < n; j++) {
    for (int k = 0; k < 3; k++) o[k] = g->scale * (eye[k] + apart * rng_sign(r)) + g->centre[k];
    if (!same && ends) pick_vertex(&g->w, r, times[j], p);
    if (!same && !ends) pick_edge(&g->w, r, times[j], p);
    out[j] = ray_towards(o, p, 0);
  }
}

static void chaos(const stage *g, rng *r, const float *times, pktrt_ray *out, size_t n) {
  (void)times;
  for (size_t j = 0; j < n; j++) {
    float o[3], d[3];
    random_in_box(r, rng_below(r, 2) ? 3 : 0.5f, o);
    random_in_box(r, 1, d);
    for (int k = 0; k < 3 && j % 2; k++) d[k] -= o[k];
    out[j] = placed(g, o, d, power_of_ten(r, -2, 2));
  }
}

static void spread(const stage *g, rng *r, const float *times, pktrt_ray *out, size_t n) {
  if (rng_below(r, 2)) lens(g, r, times, out, n);
  else mirror(g, r, times, out, n);
}

/* Two bundles, shuffled, and some strays. */
static void mixture(const stage *g, rng *r, const float *times, pktrt_ray *out, size_t n) {
  static make_bundle *const kinds[5] = {pinhole, lens, mirror, octants, shadows};
  pktrt_ray other[BUNDLE];
  kinds[rng_below(r, 5)](g, r, times, out, n);
  kinds[rng_below(r, 5)](g, r, times, other, n);
  for (size_t j = 0; j < n; j++) {
    if (rng_below(r, 2)) out[j] = other[j];
    if (rng_below(r, 16) == 0) chaos(g, r, times + j, out + j, 1);
  }
}

static const struct style {
  const char *name;
  make_bundle *make;
  unsigned paper; /* one in so many calls goes the paper path, which is slow where rays diverge */
} styles[STYLES] = {{"pinhole", pinhole, 1}, {"spread bundles", spread, 2}, {"octants", octants, 2},
    {"shadow rays", shadows, 2}, {"two bundles", mixture, 4}, {"planes of boxes", planes, 2},
    {"silhouettes", silhouettes, 4}, {"chaos", chaos, 4}};

/* A packet has one time, a short shutter, or all times. */
static void times_of(rng *r, float *times, size_t n) {
  const float first = rng_range(r, -0.1f, 1.1f), shutter = rng_below(r, 2) ? 0 : power_of_ten(r, -4, 0);
  const bool odd = rng_below(r, 8) == 0;
  for (size_t j = 0; j < n; j++) {
    times[j] = first + shutter * rng_unit(r);
    if (odd && rng_below(r, 8) == 0) times[j] = rng_below(r, 2) ? NAN : (float)rng_below(r, 3) / 2;
  }
}

/* Some packets have holes: at the start, here and there, or nearly everywhere. */
static void holes(rng *r, pktrt_ray *rays, size_t n) {
  const uint32_t kind = rng_below(r, 8), start = rng_below(r, (uint32_t)n);
  const float share = kind == 1 ? 0.02f : kind == 2 ? 0.5f : 0.95f;
  for (size_t j = 0; j < n && kind < 4; j++)
    if (kind == 0 ? j < start : rng_unit(r) < share) rays[j] = invalid_ray(r, rays[j]);
}

/* Some look back, or not at everything before them. */
static void intervals(rng *r, pktrt_ray *rays, size_t n) {
  const uint32_t kind = rng_below(r, 16);
  for (size_t j = 0; j < n && kind < 3; j++) {
    if (kind == 0) rays[j].tmin = -rng_unit(r);
    else if (kind == 1) rays[j].tmax = 3 * rng_unit(r);
    else rays[j].tmin = rng_sign(r), rays[j].tmax = rays[j].tmin + rng_unit(r);
  }
}

static size_t make_packet(const stage *g, const struct style *style, rng *r, pktrt_ray *out, size_t room) {
  const uint32_t kind = rng_below(r, 8);
  size_t n = kind < 4 ? 64 : kind == 4 ? BUNDLE : kind == 5 ? 1 + rng_below(r, 40) : 1 + rng_below(r, BUNDLE);
  float times[BUNDLE] = {0};
  if (n > room) n = room;
  times_of(r, times, n);
  style->make(g, r, times, out, n);
  for (size_t j = 0; j < n; j++) out[j].time = times[j];
  intervals(r, out, n);
  holes(r, out, n);
  return n;
}

/* --- one call after the other --- */

enum { FAST, PAPER, FAST_OCCLUSION, PAPER_OCCLUSION, REFERENCE, WHATS };
static const char *const whats[WHATS] = {"hits lost on the fast path", "hits lost on the paper path",
    "occlusion lost on the fast path", "occlusion lost on the paper path", "single rays unlike the reference"};

typedef struct tally {
  uint64_t rays[WHATS], lost[WHATS], control_rays[WHATS], control[WHATS];
} tally;

typedef struct buffers {
  pktrt_ray ray[CALL];
  pktrt_hit want[CALL], got[CALL];
  bool occluded[CALL];
  size_t end[CALL], packets, n;
  size_t last; /* of the rays that were answered otherwise */
} buffers;

typedef struct culling_run {
  bool instances;
  stage stages[2][PLACES];
  tally (*tallies)[8]; /* by case and instruction set */
  pthread_mutex_t lock;
  uint64_t said;
} culling_run;

/* The answers that packets must give: of each ray alone. Some look again, with room for nothing but the hit itself. */
static void answers(const pktrt_scene *s, bool tight, buffers *b) {
  pktrt_query_desc q;
  memset(&q, 0, sizeof q);
  q.path = PKTRT_PATH_SINGLE;
  pktrt_intersect_ex(s, &q, b->ray, b->want, b->n);
  if (!tight) return;
  for (size_t j = 0; j < b->n; j++) {
    const pktrt_hit *h = &b->want[j];
    if (h->mesh == PKTRT_NONE) continue;
    b->ray[j].tmin = nextafterf(h->t, -INFINITY), b->ray[j].tmax = nextafterf(h->t, INFINITY);
  }
  pktrt_intersect_ex(s, &q, b->ray, b->want, b->n);
}

static size_t hits_unlike(buffers *b) {
  size_t unlike = 0;
  for (size_t j = 0; j < b->n; j++)
    if (!same_bits(&b->got[j], &b->want[j], sizeof b->got[j])) unlike++, b->last = j;
  return unlike;
}

static size_t occlusion_unlike(buffers *b) {
  size_t unlike = 0;
  for (size_t j = 0; j < b->n; j++)
    if (b->occluded[j] != (b->want[j].mesh != PKTRT_NONE)) unlike++, b->last = j;
  return unlike;
}

typedef void ask_hits(const pktrt_scene *, const pktrt_query_desc *, const pktrt_ray *, pktrt_hit *, size_t);
typedef void ask_occlusion(const pktrt_scene *, const pktrt_query_desc *, const pktrt_ray *, bool *, size_t);

/* All packets in one call, or each in one of its own. */
static size_t hits_lost(ask_hits *ask, const pktrt_scene *s, const pktrt_query_desc *q, bool apart, buffers *b) {
  memset(b->got, 0x77, b->n * sizeof b->got[0]);
  for (size_t i = 0, at = 0; i < b->packets && apart; at = b->end[i++])
    ask(s, q, b->ray + at, b->got + at, b->end[i] - at);
  if (!apart) ask(s, q, b->ray, b->got, b->n);
  return hits_unlike(b);
}

static size_t occlusion_lost(
    ask_occlusion *ask, const pktrt_scene *s, const pktrt_query_desc *q, bool apart, buffers *b) {
  for (size_t i = 0, at = 0; i < b->packets && apart; at = b->end[i++])
    ask(s, q, b->ray + at, b->occluded + at, b->end[i] - at);
  if (!apart) ask(s, q, b->ray, b->occluded, b->n);
  return occlusion_unlike(b);
}

static void count(tally *t, int what, const buffers *b, size_t lost) {
  const pktrt_ray *x = &b->ray[lost ? b->last : 0];
  const float *o = x->origin, *d = x->direction;
  t->rays[what] += b->n, t->lost[what] += lost;
  if (!lost) return;
  CHECK(false, "%zu %s, the last of them ray %zu of %zu in %zu packets:", lost, whats[what], b->last, b->n, b->packets);
  CHECK(false, "  o %a %a %a  d %a %a %a", (double)o[0], (double)o[1], (double)o[2], (double)d[0], (double)d[1],
      (double)d[2]);
  CHECK(false, "  [%a, %a]  time %a", (double)x->tmin, (double)x->tmax, (double)x->time);
}

static void count_control(tally *t, int what, const buffers *b, size_t lost) {
  t->control_rays[what] += b->n, t->control[what] += lost;
}

static void against_reference(const stage *g, buffers *b, tally *t) {
  pktrt_query_desc q;
  memset(&q, 0, sizeof q);
  q.path = PKTRT_PATH_SINGLE;
  for (size_t j = 0; j < b->n; j++) {
    if (!g->place.n) ref_intersect(&g->w, &b->ray[j], &b->got[j]);
    else placed_intersect(&g->place, &b->ray[j], &b->got[j]);
    if (g->place.n) memcpy(b->got[j].normal, b->want[j].normal, sizeof b->got[j].normal); /* see tests/instances.c */
  }
  count(t, REFERENCE, b, hits_unlike(b));
  count_control(t, REFERENCE, b, hits_lost(noslack_intersect, g->noslack, &q, false, b));
}

/* A call of one path: hits, or occlusion. */
static void by_path(const stage *g, const pktrt_scene *s, const pktrt_query_desc *q, bool occlusion, bool control,
    bool apart, buffers *b, tally *t) {
  const int what = (q->path == PKTRT_PATH_PAPER ? PAPER : FAST) + (occlusion ? FAST_OCCLUSION : 0);
  if (occlusion) count(t, what, b, occlusion_lost(pktrt_occluded_ex, s, q, apart, b));
  else count(t, what, b, hits_lost(pktrt_intersect_ex, s, q, apart, b));
  if (control && occlusion) count_control(t, what, b, occlusion_lost(noslack_occluded, g->noslack, q, apart, b));
  if (control && !occlusion) count_control(t, what, b, hits_lost(noslack_intersect, g->noslack, q, apart, b));
}

static void one_call(const stage *g, int isa, const struct style *style, uint64_t turn, rng *r, buffers *b, tally *t) {
  pktrt_query_desc q;
  memset(&q, 0, sizeof q);
  const bool apart = rng_below(r, 2), tight = rng_below(r, 8) == 0;
  const unsigned spared = isas[isa] == PKTRT_ISA_SCALAR ? 8 : 1; /* it is fifteen times as slow as others */
  q.packet_size = 1 + rng_below(r, 256);
  if (rng_below(r, 2)) q.packet_size = 0;
  for (b->n = b->packets = 0; b->n < CALL;) {
    b->n += make_packet(g, style, r, b->ray + b->n, CALL - b->n);
    b->end[b->packets++] = b->n;
  }
  answers(g->scene[turn % 32 ? isa_count - 1 : isa], tight, b); /* the same of all sets, says the test of identity */
  by_path(g, g->scene[isa], &q, false, turn % 32 == 0, apart, b, t);
  if (turn % (4 * spared) == 0) by_path(g, g->scene[isa], &q, true, turn % 32 == 0, apart, b, t);
  if (turn % (g->place.n ? 64 : 256) == 0) against_reference(g, b, t); /* boxes that are too small show here alone */
  if (turn % (spared * style->paper)) return;
  q.path = PKTRT_PATH_PAPER;
  by_path(g, g->scene[isa], &q, false, turn % 32 == 0, apart, b, t);
  if (turn % (4 * spared) == 0) by_path(g, g->scene[isa], &q, true, turn % 32 == 0, apart, b, t);
}

/* --- jobs: so many calls of a case on an instruction set --- */

enum { CALLS = 32 }; /* of a job */
/* 10^8 rays in all, of each case and instruction set 10^6: the widest takes the rest. */
static size_t calls_of(int isa) {
  const size_t least = (thorough(1000000) + CALL - 1) / CALL, all = thorough(100000000) / CASES / CALL + 1;
  const size_t rest = (size_t)(isa_count - 1) * least;
  return isa < isa_count - 1 ? least : all > rest + least ? all - rest : least;
}
static size_t jobs_of(int isa) { return (calls_of(isa) + CALLS - 1) / CALLS; }

static void culling_job(void *arg, size_t i) {
  culling_run *run_ = arg;
  int isa = 0;
  for (; i >= CASES * jobs_of(isa); isa++) i -= CASES * jobs_of(isa);
  const size_t which = i % CASES, first = i / CASES * CALLS, all = calls_of(isa);
  const size_t end = all < first + CALLS ? all : first + CALLS;
  buffers *b = malloc(sizeof *b);
  tally t;
  if (!b) abort();
  memset(&t, 0, sizeof t);
  for (size_t call = first; call < end; call++) {
    rng r = rng_of(mix64((which + (run_->instances ? CASES : 0)) * 8 + (uint64_t)isa) + call);
    one_call(&run_->stages[which % 2][rng_below(&r, PLACES)], isa, &styles[which / 2], call, &r, b, &t);
  }
  free(b);
  pthread_mutex_lock(&run_->lock);
  tally *sum = &run_->tallies[which][isa];
  for (int w = 0; w < WHATS; w++) {
    sum->rays[w] += t.rays[w], sum->lost[w] += t.lost[w];
    sum->control_rays[w] += t.control_rays[w], sum->control[w] += t.control[w];
  }
  pthread_mutex_unlock(&run_->lock);
}

/* --- the control of the slack that is for instances alone --- */

/* Makes packets at the instances that need that slack, and asks a scene without it, which has all other slack. */
static void unstretched_call(const stage *aims, const pktrt_scene *unstretched, rng *r, buffers *b, tally *t) {
  pktrt_query_desc q;
  memset(&q, 0, sizeof q);
  for (b->n = b->packets = 0; b->n < CALL;) {
    b->n += make_packet(aims, &styles[SILHOUETTES], r, b->ray + b->n, CALL - b->n);
    b->end[b->packets++] = b->n;
  }
  answers(aims->scene[isa_count - 1], false, b);
  count_control(t, FAST, b, hits_lost(noslack_intersect, unstretched, &q, true, b));
  count_control(t, FAST_OCCLUSION, b, occlusion_lost(noslack_occluded, unstretched, &q, true, b));
  q.path = PKTRT_PATH_PAPER;
  count_control(t, PAPER, b, hits_lost(noslack_intersect, unstretched, &q, true, b));
  count_control(t, PAPER_OCCLUSION, b, occlusion_lost(noslack_occluded, unstretched, &q, true, b));
  q.path = PKTRT_PATH_SINGLE;
  count_control(t, REFERENCE, b, hits_lost(noslack_intersect, unstretched, &q, false, b));
}

static void unstretched_control(const char *part, const char *name, const stage *stages) {
  buffers *b = malloc(sizeof *b);
  tally t;
  if (!b) abort();
  memset(&t, 0, sizeof t);
  slack_left = slack_whole;
  for (uint32_t p = 0; p < PLACES; p++) {
    if (extremes[p][0] < 0.99f && extremes[p][1] == 0) continue;
    stage aims = stages[p];
    pktrt_scene *unstretched = noslack_placed(&aims.place, PKTRT_ISA_AUTO);
    aims.w.m[0] = aims.w.m[FAR_MODEL], aims.w.m[1] = aims.w.m[LAYS - 1], aims.w.n = 2;
    noslack_unstretch(unstretched);
    for (size_t i = 0; i < 8 + thorough(200); i++) {
      rng r = rng_of(mix64(p) + i);
      unstretched_call(&aims, unstretched, &r, b, &t);
    }
    noslack_destroy(unstretched);
  }
  slack_left = slack_none;
  for (int w = 0; w < WHATS; w++)
    control_figure(part, name, whats[w], "none for instances", t.control_rays[w], t.control[w]);
  free(b);
}

/* What is lost without slack is what grazes: else it would be lost for another reason. */
static void control_is_fair(const culling_run *run_) {
  uint64_t rays = 0, lost = 0;
  for (int c = 0; c < 2; c++)
    for (int i = 0; i < isa_count; i++) {
      rays += run_->tallies[c][i].control_rays[FAST];
      lost += run_->tallies[c][i].control[FAST];
    }
  CHECK(lost < rays / 10, "without slack %llu of %llu rays of pinholes are lost", (unsigned long long)lost,
      (unsigned long long)rays);
}

static void culling_figures(const culling_run *run_) {
  const char *part = run_->instances ? "culling of instances" : "culling";
  for (int c = 0; c < CASES; c++) {
    char name[64];
    snprintf(name, sizeof name, "%s, %s", styles[c / 2].name, c % 2 ? "moving" : "static");
    for (int w = 0; w < WHATS; w++) {
      uint64_t rays = 0, found = 0;
      for (int i = 0; i < isa_count; i++) {
        const tally *t = &run_->tallies[c][i];
        if (t->rays[w]) count_figure(part, name, isas[i], t->rays[w], whats[w], t->lost[w]);
        rays += t->control_rays[w], found += t->control[w];
      }
      if (rays) control_figure(part, name, whats[w], "no slack", rays, found);
    }
  }
}

static void cull(bool instances) {
  culling_run *run_ = calloc(1, sizeof *run_);
  if (!run_ || !(run_->tallies = calloc(CASES, sizeof *run_->tallies))) abort();
  run_->instances = instances;
  pthread_mutex_init(&run_->lock, NULL);
  for (int p = 0; p < 2 * PLACES; p++)
    raise_stage(&run_->stages[p / PLACES][p % PLACES], instances, p / PLACES, p % PLACES);
  size_t jobs = 0;
  for (int i = 0; i < isa_count; i++) jobs += CASES * jobs_of(i);
  jobs_for(jobs, culling_job, run_);
  culling_figures(run_);
  for (int m = 0; m < 2 && instances; m++)
    unstretched_control("culling of instances", m ? "silhouettes, moving" : "silhouettes, static", run_->stages[m]);
  control_is_fair(run_);
  for (int p = 0; p < 2 * PLACES; p++) strike_stage(&run_->stages[p / PLACES][p % PLACES]);
  pthread_mutex_destroy(&run_->lock);
  free(run_->tallies);
  free(run_);
}

static void culling(void) { cull(false); }
static void culling_of_instances(void) { cull(true); }

void suite_stability_culling(void) {
  run("stable: packets lose no hit that their rays have alone", culling);
  run("stable: packets lose no hit in instances that their rays have alone", culling_of_instances);
}
