/* Calls that change a scene, in any order, good and bad. A model knows which of them are to be refused. */
#include "fuzz.h"

enum { MESHES = 6, OPERATIONS = 32, RAYS = 12 };

typedef struct model_mesh {
  uint32_t vertices, triangles, keys, floats; /* floats: from vertex to vertex */
  bool normals;
} model_mesh;

typedef struct snapshot { /* what is to stay as it was */
  pktrt_hit hit[RAYS];
  uint32_t meshes;
  uint64_t triangles, nodes;
} snapshot;

typedef struct model {
  pktrt_scene *s;
  fuzz_memory memory;
  model_mesh mesh[MESHES];
  uint32_t meshes, committed, lights, materials;
  bool broken;
} model;

static const char *take_snapshot(const model *m, snapshot *x) {
  pktrt_scene_info info;
  pktrt_get_scene_info(m->s, &info);
  memset(x, 0, sizeof *x);
  x->meshes = info.mesh_count, x->triangles = info.triangles, x->nodes = info.nodes;
  for (uint32_t i = 0; i < RAYS; i++) {
    const uint64_t z = mix64(i);
    pktrt_ray r = ray_of(0, 0, 0, 0, 0, 0);
    for (int a = 0; a < 3; a++) {
      r.origin[a] = (float)((int)(z >> 6 * a & 63) - 32) / 4;
      r.direction[a] = (float)((int)(z >> (20 + 4 * a) & 15) - 8) / 8 - r.origin[a];
    }
    r.time = (float)i / RAYS;
    const bool hit = pktrt_intersect(m->s, &r, &x->hit[i]);
    const char *wrong = fuzz_bad_hit(&r, &x->hit[i], hit);
    if (wrong) return wrong;
    if (pktrt_occluded(m->s, &r) != hit) return "pktrt_occluded and pktrt_intersect differ.";
    if (!hit) continue;
    if (x->hit[i].mesh >= m->committed) return "A ray hits a mesh that is not committed.";
    if (x->hit[i].triangle >= m->mesh[x->hit[i].mesh].triangles) return "A ray hits a triangle that is not there.";
  }
  return NULL;
}

static bool same_snapshot(const snapshot *a, const snapshot *b) {
  return a->meshes == b->meshes && a->triangles == b->triangles && a->nodes == b->nodes &&
         same_bits(a->hit, b->hit, sizeof a->hit);
}

/* --- add_mesh --- */

/* What the description itself may have wrong: it is refused before any array is looked at. */
static pktrt_status spoil(uint32_t how, pktrt_mesh_desc *d) {
  switch (how) {
  case 1: d->key_count = PKTRT_MAX_KEYS + 1; return PKTRT_LIMIT;
  case 2: d->key_count = 0xFFFFFFFFu; return PKTRT_LIMIT;
  case 3: d->position_stride = 8; return PKTRT_INVALID_ARGUMENT;
  case 4: d->position_stride = 0xFFFFFFFFu; return PKTRT_INVALID_ARGUMENT;
  case 5: d->positions = NULL; return d->vertex_count || d->triangle_count ? PKTRT_INVALID_ARGUMENT : PKTRT_OK;
  case 6: d->vertex_count = 0; return d->triangle_count ? PKTRT_INVALID_ARGUMENT : PKTRT_OK;
  case 7: d->triangle_count = 0xFFFFFFFFu; return d->vertex_count ? PKTRT_LIMIT : PKTRT_INVALID_ARGUMENT;
  case 8: d->indices = NULL, d->triangle_count = d->vertex_count / 3 + 1; return PKTRT_INVALID_ARGUMENT;
  case 9: d->vertex_count = 0xFFFFFFFFu, d->position_stride = 0xFFFFFFFCu, d->key_count = 1024; return PKTRT_LIMIT;
  default: return PKTRT_OK;
  }
}

static pktrt_status status_of_vectors(const float *p, uint32_t count, uint32_t floats, float limit) {
  for (uint32_t i = 0; i < count; i++)
    for (int a = 0; a < 3; a++) {
      const float x = p[(size_t)i * floats + (size_t)a];
      if (!isfinite(x)) return PKTRT_INVALID_ARGUMENT;
      if (fabsf(x) > limit) return PKTRT_LIMIT;
    }
  return PKTRT_OK;
}

/* Blocks without a float more than the header says it reads; whatever lies between vertices is NaN. */
static float *take_vectors(feed *b, const model_mesh *g, uint32_t keys, uint32_t floats, bool odd) {
  const size_t count = (size_t)g->vertices * keys, n = count ? (count - 1) * floats + 3 : 0;
  float *p = fuzz_block(n * sizeof *p);
  for (size_t i = 0; i < n; i++) p[i] = NAN;
  for (size_t i = 0; i < count; i++)
    for (size_t a = 0; a < 3; a++) p[i * floats + a] = odd ? take_float(b) : take_tame(b);
  return p;
}

static pktrt_status status_of_mesh(
    const model_mesh *g, const float *positions, const float *normals, const uint32_t *indices) {
  for (uint32_t i = 0; indices && i < 3 * g->triangles; i++)
    if (indices[i] >= g->vertices) return PKTRT_INVALID_ARGUMENT;
  for (uint32_t k = 0; k < g->keys; k++) {
    pktrt_status st =
        status_of_vectors(positions + (size_t)k * g->vertices * g->floats, g->vertices, g->floats, PKTRT_MAX_COORD);
    if (!st && normals) st = status_of_vectors(normals + (size_t)k * g->vertices * 3, g->vertices, 3, FLT_MAX);
    if (st) return st;
  }
  return PKTRT_OK;
}

static pktrt_status add_mesh(model *m, feed *b, pktrt_status *want) {
  model_mesh g;
  pktrt_mesh_desc d;
  memset(&d, 0, sizeof d);
  const uint32_t how = take_below(b, 24), flags = take_u8(b);
  g.vertices = take_below(b, 25), g.keys = 1 + take_below(b, 4), g.floats = 3 + (flags & 1) * 2,
  g.normals = flags >> 1 & 1;
  const bool soup = flags >> 2 & 1, odd = flags >> 3 & 1;
  g.triangles = soup ? g.vertices / 3 : g.vertices ? take_below(b, 25) : 0;
  float *positions = take_vectors(b, &g, g.keys, g.floats, odd);
  float *normals = g.normals ? take_vectors(b, &g, g.keys, 3, odd) : NULL;
  uint32_t *indices = soup ? NULL : fuzz_block((size_t)g.triangles * 3 * sizeof *indices);
  for (uint32_t i = 0; indices && i < 3 * g.triangles; i++)
    indices[i] = odd ? take_below(b, 25) : take_u8(b) % g.vertices;
  d.positions = positions, d.vertex_count = g.vertices, d.position_stride = flags & 1 ? 20 : flags & 16 ? 12 : 0;
  d.indices = indices, d.triangle_count = g.triangles, d.key_count = g.keys == 1 ? flags >> 5 & 1 : g.keys;
  d.normals = normals, d.material = flags >> 6;
  *want = spoil(how, &d);
  if (!*want) g.vertices = d.vertex_count; /* none, with no triangle either */
  if (!*want && g.vertices) *want = status_of_mesh(&g, positions, normals, indices);
  const bool null = how == 10;
  if (null) *want = PKTRT_INVALID_ARGUMENT;
  uint32_t index = 4242;
  const pktrt_status got = pktrt_add_mesh(m->s, null ? NULL : &d, &index);
  if (got == PKTRT_OK && index == m->meshes) m->mesh[m->meshes++] = g;
  else if (index != 4242) *want = PKTRT_CANCELLED; /* no status that could be right */
  free(positions), free(normals), free(indices);
  return got;
}

/* --- the other calls --- */

static pktrt_status set_vectors(model *m, feed *b, pktrt_status *want) {
  const uint32_t mesh = take_below(b, m->meshes + 1), key = take_below(b, 5), flags = take_u8(b);
  const bool normals = flags & 1, null = (flags & 30) == 30;
  static const model_mesh none;
  const model_mesh *g = mesh < m->meshes ? &m->mesh[mesh] : &none;
  const uint32_t floats = normals ? 3 : g->floats;
  float *p = take_vectors(b, g, 1, floats, flags >> 5 & 1);
  *want = status_of_vectors(p, g->vertices, floats, normals ? FLT_MAX : PKTRT_MAX_COORD);
  if (mesh >= m->meshes || key >= g->keys || (null && g->vertices) || (normals && !g->normals))
    *want = PKTRT_INVALID_ARGUMENT;
  const float *given = null ? NULL : p;
  const pktrt_status got =
      normals ? pktrt_set_normals(m->s, mesh, key, given) : pktrt_set_positions(m->s, mesh, key, given);
  free(p);
  return got;
}

static pktrt_status add_light(model *m, feed *b, pktrt_status *want) {
  bool good;
  uint32_t index = 4242;
  const pktrt_light l = fuzz_light(b, &good);
  *want = good ? PKTRT_OK : PKTRT_INVALID_ARGUMENT;
  const pktrt_status got = pktrt_add_light(m->s, &l, &index);
  if (index != (got ? 4242 : m->lights++)) *want = PKTRT_CANCELLED;
  return got;
}

static pktrt_status add_material(model *m, feed *b, pktrt_status *want) {
  bool good;
  uint32_t index = 4242;
  const pktrt_material material = fuzz_material(b, &good);
  *want = good ? PKTRT_OK : PKTRT_INVALID_ARGUMENT;
  const pktrt_status got = pktrt_add_material(m->s, &material, &index);
  if (index != (got ? 4242 : ++m->materials)) *want = PKTRT_CANCELLED;
  return got;
}

/* One call: what it returned, and what it should have. `moves`: it may change what queries see. */
static pktrt_status operate(model *m, feed *b, pktrt_status *want, bool *moves) {
  *want = PKTRT_OK;
  switch (take_below(b, 10)) {
  case 0:
  case 1:
  case 2:
    if (m->meshes < MESHES) return add_mesh(m, b, want);
    return PKTRT_OK;
  case 3:
  case 4: return set_vectors(m, b, want);
  case 5: return add_light(m, b, want);
  case 6: return add_material(m, b, want);
  case 7: *want = m->meshes > m->committed ? PKTRT_NOT_COMMITTED : PKTRT_OK, *moves = true; return pktrt_refit(m->s);
  case 8: m->memory.fail_at = take_below(b, 12); return pktrt_mark_changed(m->s);
  default: *moves = true; return pktrt_commit(m->s);
  }
}

static const char *step(model *m, feed *b, snapshot *before) {
  snapshot after;
  bool moves = false;
  pktrt_status want;
  const size_t failed = m->memory.failed;
  const uint32_t waiting = m->meshes;
  const pktrt_status got = operate(m, b, &want, &moves);
  if (got != want && !(got == PKTRT_OUT_OF_MEMORY && m->memory.failed > failed))
    return "The status is not the one to expect.";
  if (m->meshes > waiting + 1 || (got != PKTRT_OK && m->meshes != waiting))
    return "A mesh was added by a refused call.";
  const char *wrong = got == PKTRT_OK ? NULL : fuzz_no_sentence(m->s);
  if (moves && got == PKTRT_OK) m->committed = m->meshes;
  const size_t calls = m->memory.calls;
  if (!wrong) wrong = take_snapshot(m, &after);
  if (wrong) return wrong;
  if (m->broken) after.hit[0].t = -7; /* the control */
  if (m->memory.calls != calls) return "Queries allocate.";
  if (after.meshes != m->committed) return "The number of meshes is not that of those committed.";
  if (!(moves && got == PKTRT_OK) && !same_snapshot(before, &after))
    return "The scene changed without commit or refit.";
  *before = after;
  return NULL;
}

const char *fuzz_scene(const uint8_t *data, size_t size, bool broken) {
  feed b = {data, size};
  snapshot now;
  model m;
  memset(&m, 0, sizeof m);
  m.broken = broken;
  const uint32_t flags = take_u8(&b);
  pktrt_scene_desc d = fuzz_scene_desc(&m.memory, (pktrt_isa)take_below(&b, 8), flags & 1);
  d.quality = (pktrt_build_quality)(flags >> 1 & 3), d.rebuild = (pktrt_rebuild)(flags >> 3 & 3);
  if ((flags & 0xE0) == 0xE0) d.release = NULL;
  m.s = pktrt_scene_create(&d);
  const bool good =
      pktrt_isa_available(d.isa) && d.quality <= PKTRT_BUILD_HIGH && d.rebuild <= PKTRT_REBUILD_AUTOMATIC && d.release;
  if (good != (m.s != NULL)) return "A scene is created of a bad description, or not of a good one.";
  if (!m.s) return m.memory.blocks ? "A create that failed keeps memory." : fuzz_no_sentence(NULL);
  const char *wrong = take_snapshot(&m, &now);
  for (int i = 0; i < OPERATIONS && b.left && !wrong; i++) wrong = step(&m, &b, &now);
  pktrt_scene_destroy(m.s);
  return !wrong && m.memory.blocks ? "Memory is kept after destroy." : wrong;
}
