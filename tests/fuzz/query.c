/* Any rays against any triangles: every path on every instruction set answers as brute force does, bit for bit. */
#include "fuzz.h"
#include "../meshes.h"

enum { MESHES = 3, VERTICES = 20, TRIANGLES = 24, KEYS = 3, RAYS = 140 };

typedef struct geometry {
  world w;
  float p[MESHES][KEYS * VERTICES * 3];
  uint32_t i[MESHES][TRIANGLES * 3];
} geometry;

static void take_geometry(feed *b, geometry *g) {
  memset(g, 0, sizeof *g);
  g->w.n = take_below(b, MESHES + 1);
  for (uint32_t m = 0; m < g->w.n; m++) {
    const uint32_t flags = take_u8(b);
    mesh *to = &g->w.m[m];
    to->p = g->p[m], to->i = g->i[m];
    to->nv = 1 + take_below(b, VERTICES), to->nt = take_below(b, TRIANGLES + 1);
    to->keys = flags & 3 ? 1 : 1 + (flags >> 2 & 3) % KEYS;
    const float scale = flags & 16 ? ldexpf(1, (int)take_below(b, 220) - 130) : 1;
    for (uint32_t j = 0; j < 3 * to->nv * to->keys; j++) {
      const float x = (flags & 32 ? take_float(b) : take_tame(b)) * scale;
      to->p[j] = fabsf(x) <= PKTRT_MAX_COORD ? x : 0; /* what is to be refused is not the matter here */
    }
    for (uint32_t j = 0; j < 3 * to->nt; j++) to->i[j] = take_u8(b) % to->nv;
  }
}

static pktrt_scene *build(const geometry *g, fuzz_memory *memory, pktrt_isa isa) {
  const pktrt_scene_desc d = fuzz_scene_desc(memory, isa, false);
  pktrt_scene *s = pktrt_scene_create(&d);
  for (uint32_t m = 0; s && m < g->w.n; m++) {
    const mesh *from = &g->w.m[m];
    pktrt_mesh_desc md;
    memset(&md, 0, sizeof md);
    md.positions = from->p, md.vertex_count = from->nv, md.indices = from->i, md.triangle_count = from->nt;
    md.key_count = from->keys;
    if (pktrt_add_mesh(s, &md, NULL)) return NULL; /* memory is kept, but the run ends */
  }
  return s && pktrt_commit(s) == PKTRT_OK ? s : NULL;
}

/* Of any floats; from anywhere towards a vertex, the middle of an edge, or a place between; along an axis. */
static pktrt_ray take_ray(feed *b, const geometry *g) {
  pktrt_ray r;
  const uint32_t kind = take_u8(b);
  take_floats(b, r.origin, 3);
  r.tmin = kind & 8 ? take_float(b) : 0, r.tmax = kind & 16 ? take_float(b) : INFINITY, r.time = take_float(b);
  const mesh *m = g->w.n ? &g->w.m[kind / 32 % g->w.n] : NULL;
  if (kind % 4 && m && m->nt) {
    const uint32_t *corner = m->i + 3 * (take_u8(b) % m->nt);
    const float *p = m->p + 3 * corner[0], *q = m->p + 3 * corner[1];
    const float f = kind % 4 == 1 ? 0 : kind % 4 == 2 ? 0.5f : take_tame(b) / 16 + 0.5f;
    for (int a = 0; a < 3; a++) r.direction[a] = (1 - f) * p[a] + f * q[a] - r.origin[a];
  } else {
    take_floats(b, r.direction, 3);
  }
  return r;
}

/* As many rays as there are bytes for, each with some that differ little, so that there are packets. */
static uint32_t take_rays(feed *b, const geometry *g, pktrt_ray *rays) {
  uint32_t n = 0;
  while (b->left && n < RAYS) {
    const pktrt_ray first = take_ray(b, g);
    const uint32_t copies = 1 + take_below(b, 80), axis = take_below(b, 6);
    const float by = take_tame(b) / 64;
    for (uint32_t i = 0; i < copies && n < RAYS; i++) {
      rays[n] = first;
      (axis < 3 ? rays[n].origin : rays[n].direction)[axis % 3] += (float)i * by;
      n++;
    }
  }
  return n;
}

static bool same_hits(const pktrt_hit *a, const pktrt_hit *b, uint32_t n) { return same_bits(a, b, n * sizeof *a); }

static const char *compare_arrays(const pktrt_scene *s, const pktrt_ray *rays, const pktrt_hit *want, uint32_t n) {
  float in[9][RAYS], t[RAYS], normal[RAYS];
  uint32_t triangle[RAYS];
  bool occluded[RAYS];
  pktrt_rays from;
  pktrt_hits to;
  memset(&to, 0, sizeof to);
  for (uint32_t i = 0; i < n; i++) {
    for (int a = 0; a < 3; a++) in[a][i] = rays[i].origin[a], in[3 + a][i] = rays[i].direction[a];
    in[6][i] = rays[i].tmin, in[7][i] = rays[i].tmax, in[8][i] = rays[i].time;
  }
  for (int a = 0; a < 3; a++) from.origin[a] = in[a], from.direction[a] = in[3 + a], to.normal[a] = normal;
  from.tmin = in[6], from.tmax = in[7], from.time = in[8], to.t = t, to.triangle = triangle;
  to.normal[0] = to.normal[1] = to.normal[2] = NULL;
  pktrt_intersect_soa(s, &from, &to, n);
  pktrt_occluded_soa(s, &from, occluded, n);
  for (uint32_t i = 0; i < n; i++)
    if (!same_bits(&t[i], &want[i].t, sizeof t[i]) || triangle[i] != want[i].triangle ||
        occluded[i] != (want[i].mesh != PKTRT_NONE))
      return "Structures of arrays are answered otherwise.";
  return NULL;
}

static const char *compare_paths(
    const pktrt_scene *s, feed odd, const pktrt_ray *rays, const pktrt_hit *want, uint32_t n, bool broken) {
  pktrt_hit hit[RAYS];
  bool occluded[RAYS];
  pktrt_stats stats;
  uint64_t valid = 0, hits = 0;
  for (uint32_t i = 0; i < n; i++) valid += ref_valid(&rays[i]), hits += want[i].mesh != PKTRT_NONE;
  pktrt_intersect_n(s, rays, hit, n);
  if (broken && n) hit[n / 2].t += 1, hit[n / 2].u = 2; /* the control */
  if (!same_hits(hit, want, n)) return "pktrt_intersect_n and single calls differ.";
  for (uint32_t path = 0; path < 4; path++) {
    pktrt_query_desc d;
    memset(&d, 0, sizeof d), memset(&stats, 0, sizeof stats);
    d.path = (pktrt_path)(path < 3 ? (int)path : (int)take_u32(&odd)),
    d.packet_size = path < 3 ? take_u8(&odd) : take_u32(&odd);
    d.type = (pktrt_ray_type)take_u8(&odd);
    if (path != 1) d.stats = &stats;
    memset(hit, 0xA5, sizeof hit), memset(occluded, 1, sizeof occluded);
    pktrt_intersect_ex(s, &d, rays, hit, n);
    if (!same_hits(hit, want, n)) return "A path differs from single calls.";
    if (d.stats) {
      uint64_t counted = 0;
      for (int type = 0; type < PKTRT_RAY_TYPE_COUNT; type++) counted += stats.by_type[type].rays;
      if (counted < hits || counted > valid) return "Rays that hit are not counted, or rays that are not valid are.";
    }
    pktrt_occluded_ex(s, &d, rays, occluded, n);
    for (uint32_t i = 0; i < n; i++)
      if (occluded[i] != (want[i].mesh != PKTRT_NONE)) return "Occlusion on a path differs from hits.";
  }
  return compare_arrays(s, rays, want, n);
}

static const char *compare_spawned(
    const pktrt_scene *s, feed odd, const pktrt_ray *rays, const pktrt_hit *hit, uint32_t n) {
  for (uint32_t i = 0; i < n; i += 7) {
    float direction[3];
    pktrt_ray out;
    pktrt_hit next;
    take_floats(&odd, direction, 3);
    pktrt_spawn(s, &rays[i], &hit[i], direction, &out);
    const bool hits = pktrt_intersect(s, &out, &next);
    if (hit[i].mesh == PKTRT_NONE && hits) return "What a miss spawns hits something.";
    if (hit[i].mesh != PKTRT_NONE && !fuzz_all_finite(out.origin, 3)) return "A ray leaves a hit from nowhere.";
    const char *wrong = fuzz_bad_hit(&out, &next, hits);
    if (wrong) return wrong;
  }
  return NULL;
}

/* Chains end: each hit comes after the last, and no triangle comes twice. Calls that look for the end themselves are made where
   chains have one. */
static const char *follow_chains(const pktrt_scene *s, const geometry *g, const pktrt_ray *rays, uint32_t n) {
  pktrt_hit all[4];
  size_t triangles = 0;
  for (uint32_t m = 0; m < g->w.n; m++) triangles += g->w.m[m].nt;
  for (uint32_t i = 0; i < n; i += 3) {
    static const float ahead[3] = {1, 0, 0}; /* as pktrt_winding looks */
    pktrt_ray along[2] = {rays[i], pktrt_make_ray(rays[i].origin, ahead)};
    along[1].time = rays[i].time;
    for (int which = 0; which < 2; which++) {
      pktrt_hit last, next;
      size_t steps = 0;
      bool hit = pktrt_intersect_after(s, &along[which], NULL, &next);
      for (; hit; steps++) {
        const char *wrong = fuzz_bad_hit(&along[which], &next, true);
        if (wrong) return wrong;
        if (steps &&
            !(next.t > last.t || (next.t == last.t && (next.mesh > last.mesh ||
                                                          (next.mesh == last.mesh && next.triangle > last.triangle)))))
          return "A chain of hits goes back, or stays.";
        if (steps == triangles) return "A chain of hits does not end.";
        last = next;
        hit = pktrt_intersect_after(s, &along[which], &last, &next);
      }
      if (!which && pktrt_intersect_all(s, &along[0], all, COUNT(all)) != steps) return "A chain is of another length.";
    }
    for (uint32_t m = 0; m <= g->w.n; m++) (void)pktrt_winding(s, m, rays[i].origin, rays[i].time);
    const pktrt_point_query query = {
        {rays[i].origin[0], rays[i].origin[1], rays[i].origin[2]}, rays[i].tmax, rays[i].time, i % 3};
    pktrt_closest nearest;
    pktrt_closest_point_n(s, &query, &nearest, 1);
    if ((nearest.mesh == PKTRT_NONE) != (nearest.distance == INFINITY)) return "A distance leads to nothing.";
    if (nearest.mesh != PKTRT_NONE && !(nearest.distance <= rays[i].tmax)) return "A closest point is too far.";
  }
  return NULL;
}

/* Functions of numbers alone. */
static const char *try_numbers(feed b) {
  pktrt_sampling sampling;
  float out[24], x[6];
  sampling.sampler = (pktrt_sampler)((int)take_below(&b, 10) - 1), sampling.samples = take_u32(&b),
  sampling.seed = take_u32(&b);
  pktrt_sample(&sampling, take_u32(&b), take_u32(&b), take_u32(&b), take_u32(&b), COUNT(out), out);
  for (uint32_t i = 0; i < COUNT(out); i++)
    if (!(out[i] >= 0 && out[i] < 1)) return "A sample lies outside [0,1).";
  take_floats(&b, x, 6);
  pktrt_map_disk(x, out), pktrt_map_sphere(x, out), pktrt_map_cosine(x, x + 2, out);
  pktrt_map_phong(x, x + 2, x[5], out), pktrt_map_phong_naive(x, x + 2, x[5], out);
  const float eta = fabsf(x[0]), k = fabsf(x[1]), f = pktrt_fresnel_dielectric(x[2], eta),
              g = pktrt_fresnel_conductor(x[2], eta, k);
  if (!(f >= 0 && f <= 1.000001f)) return "Fresnel reflectance of a dielectric lies outside [0,1].";
  if (eta <= 1e6f && k <= 1e6f && !(g >= 0 && g <= 1.000001f))
    return "Fresnel reflectance of a conductor lies outside [0,1].";
  return pktrt_sampler_string(sampling.sampler) ? NULL : "A sampler has no string.";
}

static const char *answer_alone(
    const pktrt_scene *s, const geometry *g, const pktrt_ray *rays, pktrt_hit *hit, uint32_t n) {
  for (uint32_t i = 0; i < n; i++) {
    pktrt_hit truth;
    const bool found = pktrt_intersect(s, &rays[i], &hit[i]);
    const char *wrong = fuzz_bad_hit(&rays[i], &hit[i], found);
    if (wrong) return wrong;
    ref_intersect(&g->w, &rays[i], &truth);
    if (!same_bits(&truth, &hit[i], sizeof truth)) return "A single call answers otherwise than brute force.";
  }
  return NULL;
}

const char *fuzz_query(const uint8_t *data, size_t size, bool broken) {
  feed b = {data, size};
  geometry g;
  pktrt_ray rays[RAYS];
  pktrt_hit want[RAYS], hit[RAYS];
  take_geometry(&b, &g);
  const feed odd = b;
  const uint32_t n = take_rays(&b, &g, rays);
  const char *wrong = try_numbers(odd);
  bool first = true;
  for (int isa = PKTRT_ISA_SCALAR; isa < PKTRT_ISA_COUNT && !wrong; isa++) {
    fuzz_memory memory;
    if (!pktrt_isa_available((pktrt_isa)isa)) continue;
    pktrt_scene *s = build(&g, &memory, (pktrt_isa)isa);
    if (!s) return "A good scene is refused.";
    const size_t calls = memory.calls;
    wrong = answer_alone(s, &g, rays, first ? want : hit, n);
    first = false;
    if (!wrong) wrong = compare_paths(s, odd, rays, want, n, broken);
    if (!wrong) wrong = compare_spawned(s, odd, rays, want, n);
    if (!wrong) wrong = follow_chains(s, &g, rays, n);
    if (!wrong && memory.calls != calls) wrong = "Queries allocate.";
    pktrt_scene_destroy(s);
    if (!wrong && memory.blocks) wrong = "Memory is kept after destroy.";
  }
  return wrong;
}
