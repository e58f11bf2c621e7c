/* scene_lamps.h - "lamps": a market street at night under 1,000 small lamps, and "lamps-few": the same street, as bright,
   under ten. Included by scenes.h, after its builder.

   Lamps are points, spheres and quads in turn, in garlands across the street and on the stalls. Their powers differ by a
   factor of thirty, their sum is that of the scene. They are seen by what they light alone.

   Contents: kinds, lamps, street, make. */
#ifndef SCENE_LAMPS_H
#define SCENE_LAMPS_H

/* >>kinds ---------------------------------------------------------------------------------------------------------- */

enum { LAMPS_GROUND, LAMPS_WALL, LAMPS_STALL, LAMPS_CLOTH, LAMPS_BALL, LAMPS_KINDS };

static const sc_kind lamps_kinds[LAMPS_KINDS] = {{"ground", {0.45f, 0.43f, 0.40f}, 1},
    {"wall", {0.62f, 0.52f, 0.42f}, 1}, {"stall", {0.48f, 0.30f, 0.17f}, 0}, {"cloth", {0.70f, 0.16f, 0.12f}, 1},
    {"ball", {0.75f, 0.75f, 0.72f}, 0}};

/* >>lamps ---------------------------------------------------------------------------------------------------------- */

#define LAMPS_POWER 2500.0 /* of all lamps together, watts of radiant power, by channel, before their tints */

static void lamps_three(float *to, double x, double y, double z) {
  to[0] = (float)x, to[1] = (float)y, to[2] = (float)z;
}

/* Sets the shape of a lamp of unit power. Returns its intensity or radiance: power over 4 pi, over 4 pi^2 r^2, over pi
   times the area. */
static double lamps_shape(uint32_t *random, uint32_t number, pktrt_light *l) {
  const double size = 0.02 + 0.06 * sc_random(random), turn = 360.0 * sc_random(random);
  switch (number % 3) {
  case 0: l->kind = PKTRT_LIGHT_POINT; return 1.0 / (4.0 * SC_PI);
  case 1:
    l->kind = PKTRT_LIGHT_SPHERE;
    l->radius = (float)size;
    return 1.0 / (4.0 * SC_PI * SC_PI * size * size);
  default: /* it faces the ground */
    l->kind = PKTRT_LIGHT_QUAD;
    lamps_three(l->edge[0], 2.0 * size * sc_cos(turn), 0.0, 2.0 * size * sc_sin(turn));
    lamps_three(l->edge[1], -2.0 * size * sc_sin(turn), 0.0, 2.0 * size * sc_cos(turn));
    return 1.0 / (SC_PI * 4.0 * size * size);
  }
}

/* Places a lamp: three of four hang in garlands across the street, the others stand on the stalls. */
static void lamps_place(uint32_t *random, uint32_t number, pktrt_light *l) {
  const double along = -24.0 * sc_random(random), across = 2.0 * sc_random(random) - 1.0;
  if (number % 4 < 3)
    lamps_three(l->position, 4.6 * across, 3.2 + 1.1 * across * across, 2.0 * sc_floor(0.5 * along) + 0.6);
  else lamps_three(l->position, (across < 0.0 ? -1.0 : 1.0) * (2.9 + 1.1 * sc_random(random)), 1.12, along);
}

static void lamps_hang(scene *s, uint32_t count) {
  uint32_t random = 1910u, i, c;
  double sum = 0.0;
  for (i = 0; i < count; i++) {
    pktrt_light *l = &s->lights[s->light_count++];
    const double power = 1.0 / (0.035 + sc_random(&random)), warm = sc_random(&random);
    const double factor = lamps_shape(&random, i, l) * power;
    lamps_place(&random, i, l);
    lamps_three(l->intensity, factor, factor * (0.55 + 0.35 * warm), factor * (0.20 + 0.60 * warm));
    sum += power;
  }
  for (i = 0; i < count; i++)
    for (c = 0; c < 3; c++) s->lights[i].intensity[c] = (float)((double)s->lights[i].intensity[c] * LAMPS_POWER / sum);
}

/* >>street --------------------------------------------------------------------------------------------------------- */

static void lamps_stall(sc_build *b, double x, double z, double yaw) {
  const sc_frame keep = sc_place(b, x, 0.0, z, yaw);
  uint32_t i;
  sc_use(b, LAMPS_STALL);
  sc_box(b, -0.6, 0.0, -1.0, 0.6, 0.95, 1.0, 0.02);
  for (i = 0; i < 4; i++) {
    const double px = i & 1 ? 0.6 : -0.6, pz = i & 2 ? 1.0 : -1.0;
    sc_box(b, px - 0.04, 0.0, pz - 0.04, px + 0.04, 2.4, pz + 0.04, 0.01);
  }
  sc_use(b, LAMPS_CLOTH);
  sc_box(b, -0.9, 2.4, -1.2, 0.9, 2.45, 1.2, 0.0);
  sc_use(b, LAMPS_BALL);
  for (i = 0; i < 3; i++) {
    const sc_frame stall = sc_place(b, 0.1 * (double)i - 0.1, 1.1, 0.55 * (double)i - 0.55, 0.0);
    sc_sphere_band(b, 0.15, 0.0, 180.0, 12, 24);
    b->at = stall;
  }
  b->at = keep;
}

static void lamps_street(sc_build *b) {
  uint32_t i;
  sc_use(b, LAMPS_GROUND);
  sc_quad(b, sc_v(-5, 0, 4), sc_v(5, 0, 4), sc_v(5, 0, -26), sc_v(-5, 0, -26));
  sc_use(b, LAMPS_WALL);
  sc_quad(b, sc_v(-5, 0, 4), sc_v(-5, 0, -26), sc_v(-5, 7, -26), sc_v(-5, 7, 4));
  sc_quad(b, sc_v(5, 0, -26), sc_v(5, 0, 4), sc_v(5, 7, 4), sc_v(5, 7, -26));
  sc_quad(b, sc_v(-5, 0, -26), sc_v(5, 0, -26), sc_v(5, 7, -26), sc_v(-5, 7, -26));
  for (i = 0; i < 6; i++) {
    lamps_stall(b, -3.5, -1.5 - 4.0 * (double)i, 4.0 * (double)i);
    lamps_stall(b, 3.5, -3.0 - 4.0 * (double)i, 180.0 - 3.0 * (double)i);
  }
}

/* >>make ----------------------------------------------------------------------------------------------------------- */

/* A look to the left, to the right and back. */
static void lamps_camera(double time, pktrt_camera *c) {
  memset(c, 0, sizeof *c);
  lamps_three(c->eye, 0.4, 1.7, 3.5);
  lamps_three(c->target, 1.5 * sc_sin(360.0 * time), 1.3, -6.0);
  c->fov_y = 50.0f;
}

static void lamps_light(sc_build *b, uint32_t count) {
  lamps_street(b);
  if (b->failed) return;
  lamps_hang(b->out, count);
  lamps_three(b->out->background, 0.004, 0.005, 0.012);
}
static void lamps_make(sc_build *b) { lamps_light(b, SC_MAX_LIGHTS); }
static void lamps_make_few(sc_build *b) { lamps_light(b, 10); }

#endif /* SCENE_LAMPS_H */
