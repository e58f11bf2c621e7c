/* rays.h - part of peers.c: rays of all kinds. Both libraries get the same floats.

   All but camera rays leave what earlier ones hit by pktrt_spawn, in the order of the pixels, without gaps; a little farther,
   APART of the diagonal, where both libraries are to tell them from the surface that they leave.

   Contents: kinds, primary, secondary, sets. */
#ifndef PEERS_RAYS_H
#define PEERS_RAYS_H

#include "scenes.h"

/* >>kinds ---------------------------------------------------------------------------------------------------------- */

typedef enum kind { PRIMARY, SHADOW, FROM_LIGHT, MIRROR, MIRROR2, DIFFUSE, AO, KINDS } kind;
static const char *const kind_names[KINDS + 1] = {
    "primary", "shadow", "shadow-from-light", "mirror", "second-mirror", "diffuse", "ao", NULL};
static bool kind_occlusion(kind k) { return k == SHADOW || k == FROM_LIGHT || k == AO; }

typedef struct ray_set { /* of one kind: as structs, and as arrays for the _soa calls */
  pktrt_ray *ray;
  float *array[9]; /* origin, direction, tmin, tmax, time */
  size_t count;
} ray_set;

/* >>primary -------------------------------------------------------------------------------------------------------- */

/* Blocks of 16x16 pixels, in Z order inside: any 8, 16, 64 or 256 rays in a row are a compact piece of the picture.
   Times, where things move, are uniform and independent. */
static void make_primary(const stage *g, unsigned size, bool moving, pktrt_ray *out) {
  const pktrt_camera *c = &g->s.camera;
  const float y_up[3] = {0, 1, 0}, fov = c->fov_y > 0 ? c->fov_y : 45, half = tanf(fov * (float)(SC_PI / 360.0));
  float forward[3], right[3], up[3];
  for (int a = 0; a < 3; a++) forward[a] = c->target[a] - c->eye[a];
  normalize(forward);
  cross(forward, dot(c->up, c->up) > 0 ? c->up : y_up, right);
  normalize(right);
  cross(right, forward, up);
  for (size_t i = 0; i < (size_t)size * size; i++) {
    unsigned x = 0, y = 0, block = (unsigned)(i / 256), in_block = (unsigned)(i % 256);
    for (unsigned b = 0; b < 4; b++) x |= (in_block >> 2 * b & 1) << b, y |= (in_block >> (2 * b + 1) & 1) << b;
    x += block % (size / 16) * 16, y += block / (size / 16) * 16;
    const float sx = (2 * ((float)x + 0.5f) / (float)size - 1) * half,
                sy = (1 - 2 * ((float)y + 0.5f) / (float)size) * half;
    pktrt_ray *r = &out[i];
    memcpy(r->origin, c->eye, sizeof r->origin);
    for (int a = 0; a < 3; a++) r->direction[a] = forward[a] + sx * right[a] + sy * up[a];
    normalize(r->direction);
    r->tmin = 0, r->tmax = INFINITY, r->time = moving ? uniform(i, 0) : 0;
  }
}

#ifndef SPAWN /* makes the rays that leave hits */
#define SPAWN pktrt_spawn
#endif
#ifndef APART
#define APART 0
#endif

/* >>secondary ------------------------------------------------------------------------------------------------------ */

/* A direction of the hemisphere about n, with density cos / pi: a uniform point of the disc below it, lifted up. */
static void sample_cosine(const float n[3], float u0, float u1, float out[3]) {
  const float helper[3] = {fabsf(n[0]) < 0.6f ? 1.0f : 0.0f, fabsf(n[0]) < 0.6f ? 0.0f : 1.0f, 0.0f};
  const float r = sqrtf(u0), angle = u1 * (float)(2 * SC_PI), h = sqrtf(1 - u0);
  float s[3], t[3];
  cross(n, helper, s);
  normalize(s);
  cross(n, s, t);
  for (int a = 0; a < 3; a++) out[a] = r * cosf(angle) * s[a] + r * sinf(angle) * t[a] + h * n[a];
}

/* Between the surface and the light: t counts in their distance, and neither end is hit. */
static void aim(const float light[3], bool from_light, pktrt_ray *r) {
  for (int a = 0; a < 3; a++) {
    const float surface = r->origin[a];
    r->origin[a] = from_light ? light[a] : surface;
    r->direction[a] = from_light ? surface - light[a] : light[a] - surface;
  }
  r->tmax = 1;
}

/* The ray of kind k that leaves a hit, the i-th of its kind; false: there is none. */
static bool make_secondary(const stage *g, const pktrt_scene *world, kind k, size_t i, const pktrt_ray *from,
    const pktrt_hit *hit, pktrt_ray *out) {
  float n[3], d[3];
  if (hit->mesh == PKTRT_NONE) return false;
  memcpy(n, hit->normal, sizeof n);
  normalize(n);
  if (dot(n, from->direction) > 0)
    for (int a = 0; a < 3; a++) n[a] = -n[a];
  if (k == SHADOW || k == FROM_LIGHT) {
    for (int a = 0; a < 3; a++) d[a] = g->light[a] - (from->origin[a] + hit->t * from->direction[a]);
    if (!(dot(d, n) > 0)) return false; /* it faces away from the light */
  } else if (k == MIRROR || k == MIRROR2) {
    for (int a = 0; a < 3; a++) d[a] = from->direction[a] - 2 * dot(n, from->direction) * n[a];
  } else {
    const unsigned dimension = k == DIFFUSE ? 1 : 3;
    sample_cosine(n, uniform(i, dimension), uniform(i, dimension + 1), d);
  }
  SPAWN(world, from, hit, d, out);
  for (int a = 0; a < 3; a++) out->origin[a] += APART * (float)g->diagonal * n[a];
  if (k == SHADOW || k == FROM_LIGHT) aim(g->light, k == FROM_LIGHT, out);
  if (k == AO) out->tmax = 0.1f * (float)g->diagonal;
  return true;
}

/* >>sets ----------------------------------------------------------------------------------------------------------- */

static void make_arrays(ray_set *r) {
  for (size_t i = 0; i < r->count; i++) {
    const pktrt_ray *from = &r->ray[i];
    for (int a = 0; a < 3; a++) r->array[a][i] = from->origin[a], r->array[3 + a][i] = from->direction[a];
    r->array[6][i] = from->tmin, r->array[7][i] = from->tmax, r->array[8][i] = from->time;
  }
}

static ray_set rays_room(size_t most) {
  ray_set r;
  r.ray = (pktrt_ray *)take(most, sizeof(pktrt_ray));
  for (int a = 0; a < 9; a++) r.array[a] = (float *)take(most, sizeof(float));
  r.count = 0;
  return r;
}

static void rays_free(ray_set *r) {
  free(r->ray);
  for (int a = 0; a < 9; a++) free(r->array[a]);
}

typedef struct sources { /* what secondary rays come from: primary rays, and the first mirror's */
  ray_set primary, mirror;
  pktrt_hit *primary_hit, *mirror_hit;
} sources;

static void sources_room(sources *s, size_t most) {
  s->primary = rays_room(most), s->mirror = rays_room(most);
  s->primary_hit = (pktrt_hit *)take(most, sizeof(pktrt_hit));
  s->mirror_hit = (pktrt_hit *)take(most, sizeof(pktrt_hit));
}

static void sources_free(sources *s) {
  rays_free(&s->primary), rays_free(&s->mirror);
  free(s->primary_hit), free(s->mirror_hit);
}

/* Those of kind k that exist. */
static void make_kind(const stage *g, const pktrt_scene *world, kind k, const sources *s, ray_set *out) {
  const ray_set *from = k == MIRROR2 ? &s->mirror : &s->primary;
  const pktrt_hit *hit = k == MIRROR2 ? s->mirror_hit : s->primary_hit;
  out->count = 0;
  for (size_t i = 0; i < from->count; i++)
    if (k == PRIMARY) out->ray[out->count++] = from->ray[i];
    else out->count += make_secondary(g, world, k, i, &from->ray[i], &hit[i], &out->ray[out->count]);
  make_arrays(out);
}

static void make_sources(const stage *g, const pktrt_scene *world, unsigned size, bool moving, sources *s) {
  s->primary.count = (size_t)size * size;
  make_primary(g, size, moving, s->primary.ray);
  pktrt_intersect_n(world, s->primary.ray, s->primary_hit, s->primary.count);
  make_kind(g, world, MIRROR, s, &s->mirror);
  pktrt_intersect_n(world, s->mirror.ray, s->mirror_hit, s->mirror.count);
}

#endif /* PEERS_RAYS_H */
