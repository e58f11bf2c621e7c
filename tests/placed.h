/* Models placed by instances: scenes of these, and the ray that >>frames of pktrt.h defines in the frame of an instance. */
#ifndef PKTRT_TEST_PLACED_H
#define PKTRT_TEST_PLACED_H
#include "meshes.h"

enum { PLACED_MODELS = 4, PLACED = 21, PLACED_KEYS = 3 };
typedef struct placement {
  world model[PLACED_MODELS]; /* of one mesh each, so that instance i is mesh i of the scene */
  uint32_t models, n, of[PLACED], keys[PLACED];
  float transform[PLACED][12 * PLACED_KEYS];
} placement;

/* Adds the models and instances to an empty scene, and commits. */
static inline bool placement_fill(pktrt_scene *s, const placement *p) {
  bool ok = s != NULL;
  for (uint32_t i = 0; i < p->models && ok; i++) {
    const pktrt_mesh_desc m = mesh_desc(&p->model[i].m[0]);
    ok = pktrt_add_model(s, &m, 1, NULL) == PKTRT_OK;
  }
  for (uint32_t i = 0; i < p->n && ok; i++) {
    const pktrt_instance_desc d = {p->of[i], p->keys[i], p->transform[i], 0, PKTRT_INTERPOLATION_LINEAR};
    ok = pktrt_add_instance(s, &d, NULL) == PKTRT_OK;
  }
  return ok && pktrt_commit(s) == PKTRT_OK;
}

/* Computes the matrix of an instance at a time, 3 x 4 by rows; tells whether it is diagonal at all keys. */
static inline bool placed_at(const float *keys, uint32_t key_count, float time, double m[12]) {
  const float *next = keys;
  float b = 0;
  bool diagonal = true;
  for (uint32_t k = 0; k < 12 * key_count; k++)
    if (k % 4 < 3 && k % 4 != k % 12 / 4) diagonal = diagonal && keys[k] == 0;
  if (key_count > 1) {
    const float at = (time > 0 ? time < 1 ? time : 1 : 0) * (float)(key_count - 1);
    uint32_t segment = (uint32_t)at;
    if (segment > key_count - 2) segment = key_count - 2;
    b = at - (float)segment, keys += 12 * (size_t)segment, next = keys + 12;
  }
  for (int k = 0; k < 12; k++) m[k] = (double)(1 - b) * (double)keys[k] + (double)b * (double)next[k];
  return diagonal;
}

/* Computes the ray in the frame of an instance; one without a direction, which misses, where it is too short or long. */
static inline pktrt_ray ray_within(const float *keys, uint32_t key_count, const pktrt_ray *ray) {
  double m[12], adjugate[3][3], x[3], d[3], most = 0;
  const bool diagonal = placed_at(keys, key_count, ray->time, m);
  for (int p = 0; p < 3; p++)
    for (int q = 0; q < 3; q++) {
      const double *u = m + (p + 1) % 3 * 4, *v = m + (p + 2) % 3 * 4;
      adjugate[q][p] = u[(q + 1) % 3] * v[(q + 2) % 3] - u[(q + 2) % 3] * v[(q + 1) % 3];
    }
  const double inverse = 1 / ((m[0] * adjugate[0][0] + m[1] * adjugate[1][0]) + m[2] * adjugate[2][0]);
  for (int a = 0; a < 3; a++) x[a] = (double)ray->origin[a] - m[4 * a + 3], d[a] = (double)ray->direction[a];
  pktrt_ray out = *ray;
  for (int a = 0; a < 3; a++) {
    double r[3];
    for (int k = 0; k < 3; k++) r[k] = adjugate[a][k] * inverse;
    const double o = diagonal ? r[a] * x[a] : (r[0] * x[0] + r[1] * x[1]) + r[2] * x[2];
    const double way = diagonal ? r[a] * d[a] : (r[0] * d[0] + r[1] * d[1]) + r[2] * d[2];
    out.origin[a] = (float)o, out.direction[a] = (float)way;
    most = fmax(most, fabs(way));
  }
  for (int a = 0; a < 3 && !(most >= 0x1p-100 && most <= 0x1p100); a++) out.direction[a] = 0;
  return out;
}

#endif
