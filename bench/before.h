/* before.h - one version of pktrt behind calls that all versions share. It includes none of them. */
#ifndef BEFORE_H
#define BEFORE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct pktrt_ray;
struct pktrt_hit;

/* Of asking: the calls _n, _soa, and those for one ray; these once more with a ray written just before each call. */
typedef enum way { MANY, ROWS, SINGLE, FRESH, WAYS } way;

typedef struct before_mesh { /* as in pktrt_mesh_desc */
  const float *positions;
  const uint32_t *indices;
  uint32_t vertex_count, triangle_count, key_count;
} before_mesh;

typedef struct question { /* rays, as structs and as rows, and room for answers of both forms */
  const struct pktrt_ray *ray;
  float *const *row; /* origin, direction, tmin, tmax, time */
  size_t count;
  bool occlusion;
  struct pktrt_hit *hit;
  bool *occluded;
  float *real[6]; /* t, u, v, normal */
  uint32_t *index[2];
} question;

typedef struct version {
  const char *name;
  size_t ray_bytes, hit_bytes;
  void *(*open)(const before_mesh *, size_t count, int isa); /* a scene that is committed, NULL: that cannot be */
  void (*close)(void *scene);
  void (*ask)(const void *scene, way, const question *);
  void (*spawn)(const void *scene, const struct pktrt_ray *, const struct pktrt_hit *, const float direction[3],
      struct pktrt_ray *out);
} version;

extern const version version_before, version_now;

#endif /* BEFORE_H */
