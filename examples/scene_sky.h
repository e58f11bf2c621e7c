/* scene_sky.h - "sky": hills with balls and blocks under an environment, a smooth sky with a sun of 0.27 degrees radius.
   Included by scenes.h, after its builder.

   No other light is there: of the light of the ground, the sun gives some two thirds from eleven millionths of the sky.

   Contents: kinds, sky, land, make. */
#ifndef SCENE_SKY_H
#define SCENE_SKY_H

/* >>kinds ---------------------------------------------------------------------------------------------------------- */

enum { SKY_LAND, SKY_BALL, SKY_BLOCK, SKY_KINDS };

static const sc_kind sky_kinds[SKY_KINDS] = {
    {"land", {0.35f, 0.42f, 0.22f}, 0}, {"ball", {0.75f, 0.72f, 0.68f}, 0}, {"block", {0.70f, 0.42f, 0.30f}, 1}};

/* >>sky ------------------------------------------------------------------------------------------------------------ */

/* Two thirds of the light: its irradiance, 6, over pi sin(0.27 degrees)^2. */
#define SKY_SUN_RADIANCE 86000.0f
#define SKY_SUN_CHORD2 2.2207e-5 /* (2 sin(0.135 degrees))^2: how far directions to its rim lie from its middle */

static const double sky_sun[3] = {0.6, 0.64, 0.48}; /* to the right, behind the camera; of length 1 */

/* Snaps like textures do, so that the same bits come out everywhere. */
static void sky_environment(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  static const double zenith[3] = {0.16, 0.30, 0.62}, horizon[3] = {0.62, 0.70, 0.78}, glow[3] = {0.90, 0.75, 0.50};
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    double far = 0.0, up = (double)direction[1][i], low, near;
    int c;
    for (c = 0; c < 3; c++) {
      const double off = (double)direction[c][i] - sky_sun[c];
      far += off * off;
    }
    up = up > 0.0 ? up : 0.0;
    low = (1.0 - up) * (1.0 - up);
    near = 0.02 / (0.02 + far);
    for (c = 0; c < 3; c++)
      radiance[c][i] = far < SKY_SUN_CHORD2
                           ? SKY_SUN_RADIANCE
                           : sc_snap(zenith[c] + (horizon[c] - zenith[c]) * low + glow[c] * near * near);
  }
}

/* >>land ----------------------------------------------------------------------------------------------------------- */

static double sky_hill(double x, double y, const void *context) {
  (void)context;
  return 0.35 * sc_sin(40.0 * x + 20.0) * sc_sin(33.0 * y) + 0.08 * sc_sin(130.0 * x) * sc_cos(110.0 * y);
}

static void sky_land(sc_build *b) {
  uint32_t i;
  sc_frame keep = b->at;
  sc_use(b, SKY_LAND);
  sc_turn_x(b, -90.0); /* heights point up */
  sc_heights(b, -20.0, -20.0, 20.0, 20.0, 160, 160, sky_hill, NULL);
  b->at = keep;
  b->random = 149u;
  for (i = 0; i < 24; i++) {
    const double x = 9.0 * sc_random(&b->random) - 4.5, z = 2.0 - 9.0 * sc_random(&b->random);
    const double size = 0.2 + 0.4 * sc_random(&b->random);
    keep = sc_place(b, x, sky_hill(x, -z, NULL) + 0.6 * size, z, 360.0 * sc_random(&b->random));
    sc_use(b, i & 1 ? SKY_BALL : SKY_BLOCK);
    if (i & 1) sc_sphere_band(b, size, 0.0, 180.0, 16, 32);
    else sc_box(b, -0.5 * size, -size, -0.5 * size, 0.5 * size, 2.0 * size, 0.5 * size, 0.0);
    b->at = keep;
  }
}

/* >>make ----------------------------------------------------------------------------------------------------------- */

/* A look to the left, to the right and back. */
static void sky_camera(double time, pktrt_camera *c) {
  memset(c, 0, sizeof *c);
  c->eye[1] = 2.0f, c->eye[2] = 6.5f;
  c->target[0] = (float)sc_sin(360.0 * time), c->target[1] = 0.3f, c->target[2] = -1.0f;
  c->fov_y = 45.0f;
}

static void sky_make(sc_build *b) {
  scene *s = b->out;
  int c;
  sky_land(b);
  if (b->failed) return;
  s->environment = sky_environment;
  s->lights[0].kind = PKTRT_LIGHT_ENVIRONMENT;
  for (c = 0; c < 3; c++) s->lights[0].intensity[c] = 1.0f;
  s->light_count = 1;
}

#endif /* SCENE_SKY_H */
