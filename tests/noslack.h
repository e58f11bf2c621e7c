/* The library with parts of its slack taken away (noslack.c), for controls. Scenes of the one are no scenes of the
   other. */
#ifndef PKTRT_TEST_NOSLACK_H
#define PKTRT_TEST_NOSLACK_H

/* What the bounds of >>exactness are multiplied by: 1 leaves them as they are. Not to be changed while others ask. */
typedef struct slack_parts {
  float m, o, min, rho, depth, cross, shear, moving, least, estimate, tiny,
      det;          /* the constants PK_PAD_M, ... LEAST_DET */
  float sides, end; /* of frusta: what rounding does to the sides of triangles; what lies beyond the far end, */
  float apex;       /* and by what rays that end together miss each other */
  float accurate;   /* by how much bounds of depths that say that doubles suffice may differ */
  float edge;       /* how far rays start from edges */
  float parts;      /* how much boxes of parts of split triangles are widened, in steps of floats */

  /* Of frusta, by axis where there are two: what rounding does to slopes where rays end together, and to all; by what
     rays miss their far apex, and what rounds that. */
  float cone[2], slope[2], miss, far_apex;

  /* How far triangles reach that lie beyond all origins, behind the far end, and among origins; the farthest origin, at
     rest and where triangles move, and what is off of these. */
  float reach, leave, many, farthest[2], swept;

  /* Edge functions in doubles, of one and by eights; planes where rays begin or end, of one and by eights. */
  float doubles, eights, misses[2];

  /* Of the paper path: planes through the common origin, and intervals. */
  float paper, interval;

  /* Of instances: rays in their frames, their boxes, and rays that leave them. */
  float kappa, kappa_box, kappa_spawn;

  /* How far rays start from surfaces: rounding of the start, in the scene and in instances; and the plane. */
  float start[2], plane;

  /* Lamps that are seen, where surfaces coincide with them. */
  float shown;
} slack_parts;
extern slack_parts slack_left; /* slack_none at first */
extern const slack_parts slack_whole, slack_none;

#include "placed.h" /* whose pktrt.h is the one with this slack, in noslack.c */

pktrt_scene *noslack_scene(const world *, pktrt_isa);      /* committed; NULL on failure */
pktrt_scene *noslack_split(const world *, pktrt_isa);      /* of the high quality */
pktrt_scene *noslack_placed(const placement *, pktrt_isa); /* the same of models and instances */
/* Takes away the slack of instances alone, see >>frames: fits their boxes, and leaves nothing for rays in their frames. */
void noslack_unstretch(pktrt_scene *);
/* Makes a scene without hooks, whose malloc gives nothing after so many times. Returns whether that is told as it should be, if it is
   noticed: *refused. */
bool noslack_without_memory(const world *, int times, bool *refused);
pktrt_scene *noslack_create(const pktrt_scene_desc *); /* empty: the copy has the instruction sets of the default */
const char *noslack_error(void);                       /* of a create that failed */
void noslack_destroy(pktrt_scene *);
void noslack_intersect(const pktrt_scene *, const pktrt_query_desc *, const pktrt_ray *, pktrt_hit *, size_t n);
void noslack_occluded(const pktrt_scene *, const pktrt_query_desc *, const pktrt_ray *, bool *occluded, size_t n);
void noslack_spawn(const pktrt_scene *, const pktrt_ray *, const pktrt_hit *, const float direction[3], pktrt_ray *);
void noslack_spawn_at(const pktrt_scene *, uint32_t mesh, uint32_t triangle, float u, float v, float time,
    const float direction[3], pktrt_ray *);

#endif
