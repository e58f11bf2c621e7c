/* Features that meet: what each does alone is tested elsewhere; here two of them come together, or a state is used a second time,
   and the answer is known in closed form, from a plainer scene, or from many pictures at rest. */
#include "pictures.h"

/* --- weights of light, to 0.3% --- */

/* Checks that an estimate is `want`, and precise enough to tell it from what is 1% more or less. */
static void check_weight(const char *name, const estimate *e, double want) {
  check_estimate(name, e, want, 1.01 * want, 0.00075);
  if (!small_run)
    CHECK(!agrees(e, 0, 0.99 * want), "%s: %.6f +- %.6f could as well be 1%% less", name, e->mean[0], e->error[0]);
}

/* A sky of radiance 1, and 40 within a cap. */
typedef struct cap {
  vec axis;
  double cosine; /* of the cap's half-angle */
} cap;
enum { CAP_RADIANCE = 40 };

static void cap_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  const cap *c = user;
  for (uint32_t i = 0; i < n; i++) {
    const vec d = vec_of((double)direction[0][i], (double)direction[1][i], (double)direction[2][i]);
    const float value = vec_dot(d, c->axis) > c->cosine ? CAP_RADIANCE : 1;
    for (int k = 0; k < 3; k++) radiance[k][i] = value;
  }
}

static const quad ground = {{-50, 0, 50}, {{100, 0, 0}, {0, 0, -100}}};

/* Opens a scene of a floor under a sky with a cap, and the view of a spot of it. */
static pktrt_scene *cap_stage(
    const pktrt_material *floor_material, cap *c, vec eye, uint32_t samples, pktrt_render_desc *view) {
  pktrt_scene *s = stage_open();
  const pktrt_light sky = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
  stage_quad(s, &ground, stage_material(s, floor_material));
  stage_light(s, &sky);
  stage_commit(s);

  *view = stage_spot(eye, vec_of(0, 0, 0));
  view->environment = cap_sky;
  view->user = c;
  view->samples = samples;
  return s;
}

static void sky_weights(void) {
  const double angles[] = {10, 30};
  for (size_t i = 0; i < COUNT(angles); i++) {
    const double angle = angles[i] * PI / 180;
    cap c = {vec_unit(vec_of(0.3, 1, 0.2)), cos(angle)};
    const pktrt_material matt = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
    pktrt_render_desc view;
    pktrt_scene *s = cap_stage(&matt, &c, vec_of(0, 5, 3), 256, &view);
    const estimate e = stage_estimate(s, &view, 10);
    /* The irradiance is pi of the sky and that of the cap, which lies wholly above the horizon: pi sin^2(angle) cos(axis). */
    const double want = 0.5 * (1 + (CAP_RADIANCE - 1) * sin(angle) * sin(angle) * c.axis.y);
    check_weight("matt under a sky with a cap", &e, want);
    pktrt_scene_destroy(s);
  }
}

/* A lobe around the normal of what is seen from above gets 1 - cos^(n + 1) of its density from a cap around the normal. */
static void sky_weights_on_gloss(void) {
  const double exponents[] = {5, 200};
  for (size_t i = 0; i < COUNT(exponents); i++) {
    const double n = exponents[i];
    const double angle = 10 * PI / 180;
    cap c = {vec_of(0, 1, 0), cos(angle)};
    pktrt_material gloss = material_of(0, PKTRT_SPECULAR_MIRROR, 0.5);
    gloss.lobe = PKTRT_LOBE_PHONG;
    gloss.exponent = (float)n;
    pktrt_render_desc view;
    pktrt_scene *s = cap_stage(&gloss, &c, vec_of(0, 5, 0), 128, &view);
    const double within = 1 - pow(c.cosine, n + 1);
    for (int assembly = 0; assembly < 2; assembly++) {
      view.path = assembly ? PKTRT_PATH_PAPER : PKTRT_PATH_FAST;
      view.assembly = assembly ? PKTRT_ASSEMBLY_OCTANTS : PKTRT_ASSEMBLY_RAY_TYPES;
      const estimate e = stage_estimate(s, &view, 6);
      check_weight("gloss under a sky with a cap", &e, 0.5 * (1 + (CAP_RADIANCE - 1) * within));
    }
    pktrt_scene_destroy(s);
  }
}

/* The part of a parallelogram with coordinates a0 to a1, b0 to b1 along its edges. */
static quad part_of(const quad *q, double a0, double a1, double b0, double b1) {
  const quad part = {quad_at(q, a0, b0), {vec_mul(q->edge[0], a1 - a0), vec_mul(q->edge[1], b1 - b0)}};
  return part;
}

/* What lies between a point and a parallelogram, half-way, and hides it. */
static quad screen_before(quad q, vec from) {
  const quad screen = {vec_mul(vec_add(q.corner, from), 0.5), {vec_mul(q.edge[0], 0.5), vec_mul(q.edge[1], 0.5)}};
  return screen;
}

/* A skew light of which a screen leaves a quarter at one of the edges: each strip gives its own form factor. */
static void edges_of_lights(void) {
  const vec spot = vec_of(0, 0, 0);
  const quad lights[] = {
      {{-0.7, 2, 0.6}, {{1.6, 0.3, 0.2}, {0.5, 0.2, -1.5}}}, {{-2, 0.8, 2.4}, {{4.5, 0.1, -0.6}, {-0.8, 0.4, -4}}}};
  for (size_t i = 0; i < COUNT(lights); i++)
    for (int edge = 0; edge < 4; edge++)
      for (int as_mesh = 0; as_mesh < 2; as_mesh++) {
        const quad light = quad_flipped(lights[i]);
        const quad strip =
            part_of(&light, edge == 0 ? 0.75 : 0, edge == 1 ? 0.25 : 1, edge == 2 ? 0.75 : 0, edge == 3 ? 0.25 : 1);
        const quad hidden = part_of(
            &light, edge == 1 ? 0.25 : -0.5, edge == 0 ? 0.75 : 1.5, edge == 3 ? 0.25 : -0.5, edge == 2 ? 0.75 : 1.5);
        const quad screen = screen_before(hidden, spot);
        pktrt_scene *s = stage_open();
        const pktrt_material matt = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
        const pktrt_material black = material_of(0, PKTRT_SPECULAR_NONE, 0);
        stage_quad(s, &ground, stage_material(s, &matt));
        stage_quad(s, &screen, stage_material(s, &black));
        if (as_mesh) {
          const pktrt_material glow = lamp_of(10);
          pktrt_light lamp = light_of(PKTRT_LIGHT_MESH, 1);
          lamp.mesh = stage_quad(s, &light, stage_material(s, &glow));
          stage_light(s, &lamp);
        } else {
          const pktrt_light lamp = quad_light(&light, 10);
          stage_light(s, &lamp);
        }
        stage_commit(s);
        pktrt_render_desc view = stage_spot(vec_of(3, 0.4, 3), spot);
        view.camera.fov_y = 0.005f;
        view.samples = 256;
        const estimate e = stage_estimate(s, &view, 12);
        const double want = 0.5 * 10 * quad_form_factor(spot, vec_of(0, 1, 0), &strip);
        check_estimate(as_mesh ? "a strip of a mesh light" : "a strip of a quad light", &e, want, 1.02 * want, 0.0045);
        pktrt_scene_destroy(s);
      }
}

/* An ideal mirror shows a glossy wall under a lamp. Where max_depth ends rays at the wall, or its lobe is too weak to be followed,
   light's samples stand for the lobe, too: the highlight stays. */
static pktrt_scene *highlight_stage(pktrt_light_kind kind, double reflectance, bool with_mirror) {
  const quad wall = quad_of(vec_of(0, 1, -3), vec_of(5, 0, 0), vec_of(0, 5, 0));
  const quad lamp = quad_of(vec_of(0.3, 3, 1), vec_of(0.5, 0, 0), vec_of(0, 0, 0.5)); /* faces down */
  pktrt_scene *s = stage_open();
  const pktrt_material mirror = material_of(0, PKTRT_SPECULAR_MIRROR, 1);
  pktrt_material gloss = material_of(0, PKTRT_SPECULAR_MIRROR, reflectance);
  gloss.lobe = PKTRT_LOBE_PHONG;
  gloss.exponent = 12;
  if (with_mirror) stage_quad(s, &ground, stage_material(s, &mirror));
  stage_quad(s, &wall, stage_material(s, &gloss));
  pktrt_light light = quad_light(&lamp, 100 / reflectance);
  if (kind == PKTRT_LIGHT_SPHERE) {
    light = light_of(PKTRT_LIGHT_SPHERE, 100 / reflectance);
    light.position[1] = 3;
    light.position[2] = 1;
    light.radius = 0.5f;
  }
  light.visible = true;
  stage_light(s, &light);
  stage_commit(s);
  return s;
}

static void highlights_where_rays_end(void) {
  const pktrt_light_kind kinds[] = {PKTRT_LIGHT_QUAD, PKTRT_LIGHT_SPHERE};
  for (size_t i = 0; i < COUNT(kinds); i++) {
    pktrt_scene *s = highlight_stage(kinds[i], 0.5, true);
    pktrt_render_desc view = stage_spot(vec_of(0, 1, 0), vec_of(0, 0, -1));
    view.samples = 256;
    view.max_depth = 2;
    const estimate followed = stage_estimate(s, &view, 16);
    view.max_depth = 1;
    const estimate ended = stage_estimate(s, &view, 16);
    check_weight("a highlight at max_depth", &ended, followed.mean[0]);
    CHECK(followed.error[0] < 0.00075 * followed.mean[0], "%.6f +- %.6f", followed.mean[0], followed.error[0]);
    pktrt_scene_destroy(s);

    s = highlight_stage(kinds[i], 0.003, false);
    view = stage_spot(vec_of(0, 1, 0), vec_of(0, 0, -3));
    view.samples = 256;
    const estimate with_lobes = stage_estimate(s, &view, 16);
    view.attenuation = 0; /* 1/256: lobes of 0.003 are not followed */
    const estimate without = stage_estimate(s, &view, 16);
    check_weight("a highlight of a lobe too weak to be followed", &without, with_lobes.mean[0]);
    pktrt_scene_destroy(s);
  }
}

/* --- what moves beside what does not --- */

/* Shadow rays from one point look past balls that move, which are visited first, at a wall far behind: rays at the balls end before
   these, or before them within their box, the others beyond the wall. All are asked together, and each alone. */
static void short_and_long_shadow_rays(void) {
  enum { SIDE = 64, KEYS = 3 };
  static pktrt_ray rays[SIDE * SIDE];
  static bool together[SIDE * SIDE];
  size_t wrong = 0, hidden = 0, free_ones = 0;
  for (int i = 0; i < 3 * isa_count; i++) {
    static const float short_lengths[] = {3.5f, 5.1f, 5.4f};
    const float short_length = short_lengths[i % 3];
    pktrt_scene_desc desc = scene_desc_of(isas[i / 3], 0);
    pktrt_scene *s = pktrt_scene_create(&desc);
    mesh ball = mesh_sphere(1, 0, 1), wall = mesh_grid(8, 200);
    mesh_move(&ball, KEYS, 0.3f, 0, 5);
    for (uint32_t v = 0; v < ball.nv * KEYS; v++) ball.p[3 * v + 2] -= 6;
    for (uint32_t v = 0; v < wall.nv; v++) wall.p[3 * v + 1] = wall.p[3 * v + 2], wall.p[3 * v + 2] = -100;
    pktrt_mesh_desc d = mesh_desc(&ball);
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
    d = mesh_desc(&wall);
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));

    for (uint32_t k = 0; k < SIDE * SIDE; k++) { /* blocks of eight by eight rays are neighbours */
      const uint32_t block = k / 64, x = block % 8 * 8 + k % 8, y = block / 8 * 8 + k / 8 % 8;
      const float u = ((float)x - SIDE / 2) / SIDE, v = ((float)y - SIDE / 2) / SIDE;
      rays[k] = ray_of(0, 0, 0, u, v, -1);
      rays[k].time = (float)(k % 7) / 6;
      rays[k].tmax = u * u + v * v < 0.06f ? short_length : 150;
    }
    pktrt_occluded_n(s, rays, together, SIDE * SIDE);
    for (uint32_t k = 0; k < SIDE * SIDE; k++) {
      const bool alone = pktrt_occluded(s, &rays[k]);
      wrong += alone != together[k];
      hidden += alone;
      free_ones += !alone;
    }
    pktrt_scene_destroy(s);
    mesh_free(&ball), mesh_free(&wall);
  }
  CHECK(wrong == 0 && hidden > 500 && free_ones > 500, "%zu are wrong, %zu hidden, %zu free", wrong, hidden, free_ones);
  say("%zu are hidden and %zu free, as alone but for %zu", hidden, free_ones, wrong);
}

/* --- lamps, glass and cutouts that meet --- */

/* Opens a scene of a glossy floor under a lamp that is a mesh; its material is filled in. */
static pktrt_scene *mesh_lamp_on_gloss(float exponent, const pktrt_material *glow, pktrt_mesh_desc *lamp) {
  pktrt_scene *s = stage_open();
  pktrt_material gloss = material_of(0, PKTRT_SPECULAR_MIRROR, 0.5);
  gloss.lobe = PKTRT_LOBE_PHONG;
  gloss.exponent = exponent;
  stage_quad(s, &ground, stage_material(s, &gloss));

  pktrt_light light = light_of(PKTRT_LIGHT_MESH, 1);
  lamp->material = stage_material(s, glow);
  CHECK(pktrt_add_mesh(s, lamp, &light.mesh) == PKTRT_OK, "%s", pktrt_last_error(s));
  stage_light(s, &light);
  stage_commit(s);
  return s;
}

/* A lamp that is a mesh passes over a glossy floor while the shutter is open: the mean of pictures at rest. */
static void moving_lamp_on_gloss(void) {
  static const float corners[2][12] = {
      {-2, 2, -3, -1, 2, -3, -1, 3, -3, -2, 3, -3}, {1, 2, -3, 2, 2, -3, 2, 3, -3, 1, 3, -3}};
  static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
  const pktrt_material glow = lamp_of(20);
  pktrt_mesh_desc d;
  memset(&d, 0, sizeof d);
  d.positions = corners[0];
  d.vertex_count = 4;
  d.indices = indices;
  d.triangle_count = 2;
  d.key_count = 2;
  pktrt_scene *s = mesh_lamp_on_gloss(30, &glow, &d);

  pktrt_render_desc view = stage_spot(vec_of(0, 2, 2), vec_of(0, 0, -0.5));
  view.samples = 64;
  enum { TIMES = 24 };
  double want = 0;
  double error = 0;
  for (int i = 0; i < TIMES; i++) {
    view.camera.time = ((float)i + 0.5f) / TIMES;
    const estimate e = stage_estimate(s, &view, 4);
    want += e.mean[0] / TIMES;
    error += e.error[0] / TIMES;
  }
  view.camera.time = 0;
  view.camera.shutter = 1;
  view.samples = 256;
  const estimate e = stage_estimate(s, &view, 16);
  CHECK(fabs(e.mean[0] - want) < 4 * e.error[0] + error + 0.002 * want, "%.5f +- %.5f, not %.5f", e.mean[0], e.error[0],
      want);
  CHECK(small_run || e.error[0] < 0.005 * want, "%.5f +- %.5f is not precise", e.mean[0], e.error[0]);
  view.camera.shutter = 0;
  const estimate still = stage_estimate(s, &view, 4);
  CHECK(!agrees(&still, 0, want), "the control: without a shutter the lamp stands elsewhere");
  pktrt_scene_destroy(s);
}

/* A lamp of many triangles, some near a glossy floor and some far, gives the light that it gives with one key when it has two that
   are alike: the ways to find it, by its own samples and by rays of the lobe, are weighted against each other in both. */
static void lamp_of_two_keys_on_gloss(void) {
  enum { STEPS = 8 };
  static float keys[2][6 * STEPS + 6];
  static uint32_t indices[6 * STEPS];
  estimate e[2];
  for (uint32_t i = 0; i <= STEPS; i++) { /* a strip that rises from the floor */
    const double angle = 1.4 * (double)i / STEPS;
    float *p = keys[0] + 6 * i;
    vec_put(vec_of(-0.8, 0.05 + 3 * (1 - cos(angle)), -1 - 3 * sin(angle)), p);
    vec_put(vec_of(0.8, 0.05 + 3 * (1 - cos(angle)), -1 - 3 * sin(angle)), p + 3);
    const uint32_t two[6] = {2 * i, 2 * i + 1, 2 * i + 3, 2 * i, 2 * i + 3, 2 * i + 2};
    if (i < STEPS) memcpy(indices + 6 * i, two, sizeof two);
  }
  memcpy(keys[1], keys[0], sizeof keys[0]);
  const pktrt_material glow = lamp_of(20);
  for (uint32_t k = 0; k < 2; k++) {
    pktrt_mesh_desc d;
    memset(&d, 0, sizeof d);
    d.positions = keys[0], d.vertex_count = 2 * STEPS + 2;
    d.indices = indices, d.triangle_count = 2 * STEPS;
    d.key_count = 1 + k;
    pktrt_scene *s = mesh_lamp_on_gloss(6, &glow, &d);

    pktrt_render_desc view = stage_spot(vec_of(0, 2, 2), vec_of(0, 0, -0.5));
    view.samples = small_run ? 64 : 256;
    e[k] = stage_estimate(s, &view, 16);
    pktrt_scene_destroy(s);
  }
  const double apart = fabs(e[0].mean[0] - e[1].mean[0]), error = hypot(e[0].error[0], e[1].error[0]);
  CHECK(apart < 4 * error && error < (small_run ? 0.02 : 0.005) * e[0].mean[0],
      "%.5f +- %.5f, with two keys %.5f +- %.5f", e[0].mean[0], e[0].error[0], e[1].mean[0], e[1].error[0]);
  say("%.5f +- %.5f, with two keys %.5f +- %.5f", e[0].mean[0], e[0].error[0], e[1].mean[0], e[1].error[0]);
}

/* Lamps and a sky shine on a glossy floor that is seen by itself, in a mirror, and in a glossy wall: whichever lights are asked
   where, the mean is the same. */
static void choices_of_lights_on_gloss(void) {
  static const char *const name[] = {
      "the floor", "the floor in a mirror", "the floor in a glossy wall", "the floor under a sky"};
  for (int k = 0; k < 4; k++) { /* the last under the sky alone */
    cap c = {vec_unit(vec_of(0.3, 1, 0.2)), cos(0.5)};
    pktrt_material gloss = material_of(0.1, PKTRT_SPECULAR_MIRROR, 0.5);
    gloss.lobe = PKTRT_LOBE_PHONG, gloss.exponent = 12;
    pktrt_render_desc view;
    pktrt_scene *s = cap_stage(&gloss, &c, vec_of(0, 1.5, 3), 256, &view);
    pktrt_material wall = material_of(0, PKTRT_SPECULAR_MIRROR, 0.8);
    if (k == 2) wall.lobe = PKTRT_LOBE_PHONG, wall.exponent = 400;
    const quad mirror = {{-3, -0.1, -2}, {{6, 0, 0}, {0, 4, 0}}};
    stage_quad(s, &mirror, stage_material(s, &wall));
    const quad lamp = quad_of(vec_of(0.5, 2.2, 0.4), vec_of(0.5, 0, 0), vec_of(0, 0, 0.5));
    pktrt_light light = quad_light(&lamp, 60);
    light.visible = true;
    if (k < 3) stage_light(s, &light);
    light = light_of(PKTRT_LIGHT_SPHERE, 60);
    light.position[0] = -1.2f, light.position[1] = 1.8f, light.position[2] = 0.2f, light.radius = 0.3f;
    light.visible = true;
    if (k < 3) stage_light(s, &light);
    stage_commit(s);

    view = stage_spot(vec_of(0, 1.5, 3), k % 3 ? vec_of(0, 0.6, -2) : vec_of(0, 0, 0.5));
    view.environment = cap_sky, view.user = &c;
    view.samples = small_run ? 32 : 64;
    estimate e[3];
    for (int choice = PKTRT_LIGHTS_ALL; choice <= PKTRT_LIGHTS_ONE; choice++) {
      view.lights = (pktrt_light_choice)choice;
      e[choice] = stage_estimate(s, &view, 16);
      const double apart = fabs(e[choice].mean[0] - e[0].mean[0]), error = hypot(e[choice].error[0], e[0].error[0]);
      CHECK(apart <= 4 * error && error < (small_run ? 0.1 : 0.02) * e[0].mean[0],
          "%s, choice %d: %.5f +- %.5f, by all lights %.5f +- %.5f", name[k], choice, e[choice].mean[0],
          e[choice].error[0], e[0].mean[0], e[0].error[0]);
    }
    say("%s: %.4f +- %.4f, %.4f +- %.4f, %.4f +- %.4f", name[k], e[0].mean[0], e[0].error[0], e[1].mean[0],
        e[1].error[0], e[2].mean[0], e[2].error[0]);
    pktrt_scene_destroy(s);
  }
}

/* Lets a quarter of the emission of what it is on remain. */
static void quarter_of_emission(void *user, const pktrt_points *points) {
  (void)user;
  for (uint32_t i = 0; i < points->n; i++)
    for (int a = 0; a < 3; a++) points->emission[a][i] *= 0.25f;
}

/* A lamp whose texture leaves a quarter of its emission shows in gloss with a quarter. */
static void textured_lamp_on_gloss(void) {
  static const float corners[12] = {-1, 0.5f, -2, 1, 0.5f, -2, 1, 2, -2, -1, 2, -2};
  static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
  estimate e[2];
  for (int textured = 0; textured < 2; textured++) {
    pktrt_material glow = lamp_of(8);
    if (textured) glow.texture = quarter_of_emission;
    pktrt_mesh_desc d;
    memset(&d, 0, sizeof d);
    d.positions = corners, d.vertex_count = 4, d.indices = indices, d.triangle_count = 2;
    pktrt_scene *s = mesh_lamp_on_gloss(20, &glow, &d);

    pktrt_render_desc view = stage_spot(vec_of(0, 2, 3), vec_of(0, 0, 0));
    view.samples = 256;
    e[textured] = stage_estimate(s, &view, 16);
    pktrt_scene_destroy(s);
  }
  check_estimate("a lamp with a quarter of its emission", &e[1], 0.25 * e[0].mean[0], 0.3 * e[0].mean[0], 0.02);
  CHECK(agrees(&e[1], 0, 0.25 * e[0].mean[0]) && !agrees(&e[1], 0, 0.3 * e[0].mean[0]), "%.5f +- %.5f, not %.5f",
      e[1].mean[0], e[1].error[0], 0.25 * e[0].mean[0]);
}

/* A box of absorbing glass that does not refract moves along x, from around the camera to 4 away; the camera looks along z. */
static void camera_in_moving_glass(void) {
  for (int placed = 0; placed < 2; placed++) {
    pktrt_scene *s = stage_open();
    pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
    glass.ior[0] = 1;
    for (int k = 0; k < 3; k++) glass.absorption[k] = 0.7f;
    mesh box = mesh_box();
    const uint32_t material = stage_material(s, &glass);
    if (placed) {
      pktrt_mesh_desc d = mesh_desc(&box);
      d.material = material;
      static const float keys[24] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, 4, 0, 1, 0, 0, 0, 0, 1, 0};
      pktrt_instance_desc place;
      memset(&place, 0, sizeof place);
      place.transforms = keys;
      place.key_count = 2;
      CHECK(pktrt_add_model(s, &d, 1, &place.model) == PKTRT_OK);
      CHECK(pktrt_add_instance(s, &place, NULL) == PKTRT_OK);
    } else {
      mesh moving = mesh_of(box.nv, box.nt);
      moving.keys = 2;
      moving.p = realloc(moving.p, 2 * 12 * (size_t)box.nv);
      if (!moving.p) abort();
      memcpy(moving.i, box.i, 12 * (size_t)box.nt);
      for (uint32_t i = 0; i < 6 * box.nv; i++)
        moving.p[i] = box.p[i % (3 * box.nv)] + (i >= 3 * box.nv && i % 3 == 0 ? 4.0f : 0.0f);
      stage_mesh(s, &moving, material);
      mesh_free(&moving);
    }
    mesh_free(&box);
    stage_commit(s);
    pktrt_render_desc view = stage_spot(vec_of(0, 0.1, 0), vec_of(0, 0.1, 5));
    for (int k = 0; k < 3; k++) view.background[k] = 1;
    view.camera.shutter = 1;
    view.samples = 256;
    const estimate e = stage_estimate(s, &view, 8);
    const double want = 0.25 * exp(-0.7) + 0.75;
    check_estimate(placed ? "in a moving instance of glass" : "in moving glass", &e, want, 1, 0.002);
    view.camera.time = 0.125f;
    view.camera.shutter = 0;
    const estimate within = stage_estimate(s, &view, 2);
    CHECK(fabs(within.mean[0] - exp(-0.7)) < 1e-4, "%.6f", within.mean[0]);
    pktrt_scene_destroy(s);
  }
}

/* A visible sphere in the middle of a box of absorbing glass, which its light leaves straight. */
static void lamp_in_absorbing_glass(void) {
  for (int mode = PKTRT_MODE_WRT; mode <= PKTRT_MODE_DRT; mode++) {
    pktrt_scene *s = stage_open();
    pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
    glass.ior[0] = 1.5f;
    for (int k = 0; k < 3; k++) glass.absorption[k] = 0.8f;
    mesh box = mesh_box();
    stage_mesh(s, &box, stage_material(s, &glass));
    mesh_free(&box);
    pktrt_light lamp = light_of(PKTRT_LIGHT_SPHERE, 5);
    lamp.radius = 0.25f;
    lamp.visible = true;
    stage_light(s, &lamp);
    stage_commit(s);
    pktrt_render_desc view = stage_spot(vec_of(0, 0, 4), vec_of(0, 0, 0));
    view.mode = (pktrt_mode)mode;
    const estimate e = stage_estimate(s, &view, 8);
    const double want = 5 * (1 - fresnel_exact(1, 1.5)) * exp(-0.8 * 0.75);
    check_estimate("a lamp in absorbing glass", &e, want, want * exp(0.8 * 0.25), 0.002);
    pktrt_scene_destroy(s);
  }
}

/* The camera stands in n boxes of glass, one in the other, that do not refract: all of them absorb, however many a ray remembers. */
static void many_glasses_around_a_camera(void) {
  for (int n = 1; n <= 14; n++) {
    pktrt_scene *s = stage_open();
    double depth = 0;
    for (int i = 0; i < n; i++) {
      pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
      glass.ior[0] = 1;
      for (int k = 0; k < 3; k++) glass.absorption[k] = 0.01f * (float)(1 + i * i % 7);
      depth += 0.01 * (1 + i * i % 7);
      mesh box = mesh_box();
      mesh_scale(&box, (float)(i + 1));
      stage_mesh(s, &box, stage_material(s, &glass));
      mesh_free(&box);
    }
    stage_commit(s);
    float pixel[3];
    pktrt_render_desc view = stage_view(PKTRT_MODE_WRT, 1, 1, pixel, vec_of(0, 0, 0), vec_of(0, 0, 5));
    view.camera.fov_y = 0.01f;
    for (int k = 0; k < 3; k++) view.background[k] = 1;
    stage_render(s, &view);
    CHECK(
        fabs((double)pixel[0] - exp(-depth)) < 1e-5, "in %d glasses: %.6f, not %.6f", n, (double)pixel[0], exp(-depth));
    pktrt_scene_destroy(s);
  }
}

/* Sets opacity by texture coordinates: the half with u below 1/2 is not there; all of it where `user` points to true. */
static void half_cut(void *user, const pktrt_points *p) {
  const bool *all = user;
  for (uint32_t i = 0; i < p->n; i++)
    if (*all || p->texcoord[0][i] < 0.5f) p->opacity[i] = 0;
}

/* A cutout stands before an instance and behind one; where it is transparent the picture is, bit for bit, that without it. */
static void cutout_before_an_instance(void) {
  enum { W = 24, H = 16, FLOATS = 3 * W * H };
  static float with[FLOATS], without[FLOATS];
  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++)
    for (int path = 0; path < 3; path++) {
      bool all = true;
      for (int there = 0; there < 2; there++) {
        pktrt_scene *s = stage_open();
        const pktrt_material matt = material_of(0.7, PKTRT_SPECULAR_NONE, 0);
        mesh ball = mesh_sphere(2, 0.1f, 3);
        pktrt_mesh_desc d = mesh_desc(&ball);
        d.material = stage_material(s, &matt);
        uint32_t model = 0;
        CHECK(pktrt_add_model(s, &d, 1, &model) == PKTRT_OK);
        mesh_free(&ball);
        for (int i = 0; i < 2; i++) {
          const float keys[12] = {1, 0, 0, (float)i - 0.5f, 0, 1, 0, 0, 0, 0, 1, i ? -3.0f : 0};
          pktrt_instance_desc place;
          memset(&place, 0, sizeof place);
          place.model = model;
          place.transforms = keys;
          CHECK(pktrt_add_instance(s, &place, NULL) == PKTRT_OK);
        }
        stage_quad(s, &(quad){{-9, -2, 9}, {{18, 0, 0}, {0, 0, -18}}}, 0);
        pktrt_material cut = material_of(0.2, PKTRT_SPECULAR_NONE, 0);
        cut.texture = half_cut;
        cut.cutout = true;
        cut.user = &all;
        const uint32_t material = stage_material(s, &cut);
        static const float corners[12] = {-4, -2, 1.5f, 4, -2, 1.5f, 4, 3, 1.5f, -4, 3, 1.5f};
        static const float coordinates[8] = {0, 0, 1, 0, 1, 1, 0, 1};
        static const uint32_t indices[6] = {0, 1, 2, 0, 2, 3};
        pktrt_mesh_desc curtain;
        memset(&curtain, 0, sizeof curtain);
        curtain.positions = corners;
        curtain.texcoords = coordinates;
        curtain.vertex_count = 4;
        curtain.indices = indices;
        curtain.triangle_count = 2;
        curtain.material = material;
        if (there) CHECK(pktrt_add_mesh(s, &curtain, NULL) == PKTRT_OK);
        pktrt_light lamp = light_of(PKTRT_LIGHT_POINT, 60);
        lamp.position[1] = 4;
        lamp.position[2] = 4;
        stage_light(s, &lamp);
        stage_commit(s);
        pktrt_render_desc view =
            stage_view((pktrt_mode)mode, W, H, there ? with : without, vec_of(0, 1, 7), vec_of(0, 0, 0));
        view.path = (pktrt_path)path;
        stage_render(s, &view);
        if (there) { /* The control: half of it is seen, and nothing of the other half. */
          size_t left = 0;
          size_t right = 0;
          CHECK(same_bits(with, without, sizeof with), "mode %d, path %d: a cutout that is not there is seen", mode,
              path);
          all = false;
          stage_render(s, &view);
          for (int i = 0; i < W * H; i++) {
            const bool same = same_bits(with + 3 * i, without + 3 * i, 12);
            if (i % W < W / 2 - 1) left += !same;
            else right += !same;
          }
          CHECK(right > W * H / 6 && left < right / 2, "mode %d, path %d: %zu and %zu pixels differ", mode, path, left,
              right);
        }
        pktrt_scene_destroy(s);
      }
    }
}

/* --- surfaces --- */

/* Loose triangles, without indices: the coordinates of each are its own. */
static void coordinates_of_loose_triangles(void) {
  enum { TRIANGLES = 9 };
  float positions[9 * TRIANGLES];
  float coordinates[6 * TRIANGLES];
  for (uint32_t i = 0; i < TRIANGLES; i++) {
    const float x = 2 * (float)i;
    const float corners[9] = {x, 0, 0, x, 0, 1, x + 1, 0, 0};
    memcpy(positions + 9 * i, corners, sizeof corners);
    for (uint32_t k = 0; k < 6; k++) coordinates[6 * i + k] = (float)(10 * i + k);
  }
  pktrt_scene *s = stage_open();
  pktrt_mesh_desc d;
  memset(&d, 0, sizeof d);
  d.positions = positions;
  d.texcoords = coordinates;
  d.vertex_count = 3 * TRIANGLES;
  d.triangle_count = TRIANGLES;
  CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
  stage_commit(s);
  for (uint32_t i = 0; i < TRIANGLES; i++) {
    const pktrt_ray ray = ray_of(2 * (float)i + 0.25f, 1, 0.5f, 0, -1, 0);
    pktrt_hit hit;
    pktrt_surface_info info;
    if (!CHECK(pktrt_intersect(s, &ray, &hit) && hit.triangle == i)) continue;
    pktrt_surface(s, &ray, &hit, &info);
    for (uint32_t k = 0; k < 2; k++) { /* a quarter of corner 0, a half of 1, a quarter of 2 */
      const float *c = coordinates + 6 * i + k;
      const float want = 0.25f * c[0] + 0.5f * c[2] + 0.25f * c[4];
      CHECK(fabsf(info.texcoord[k] - want) < 1e-4f, "triangle %u: %g, not %g", (unsigned)i, (double)info.texcoord[k],
          (double)want);
    }
  }
  pktrt_scene_destroy(s);
}

/* A camera whose up turns to z while it moves: its rays at time 1 are those of one at rest there. */
static void up_end_along_each_axis(void) {
  for (int axis = 0; axis < 3; axis++)
    for (int sign = -1; sign <= 1; sign += 2) {
      pktrt_camera moving;
      memset(&moving, 0, sizeof moving);
      moving.moving = true;
      vec_put(vec_of(1, 2, 3), moving.eye);
      vec_put(vec_of(0.5, 1, -1), moving.target);
      vec_put(vec_of(4, 3, -2), moving.eye_end);
      vec_put(vec_of(0, 0.5, 0.25), moving.target_end);
      moving.up[1] = 1;
      moving.up_end[axis] = (float)sign;
      pktrt_camera still;
      memset(&still, 0, sizeof still);
      memcpy(still.eye, moving.eye_end, sizeof still.eye);
      memcpy(still.target, moving.target_end, sizeof still.target);
      memcpy(still.up, moving.up_end, sizeof still.up);
      pktrt_ray got;
      pktrt_ray want;
      CHECK(pktrt_camera_ray(&moving, 32, 20, 3.5, 4.5, NULL, 1, &got));
      CHECK(pktrt_camera_ray(&still, 32, 20, 3.5, 4.5, NULL, 1, &want));
      for (int k = 0; k < 3; k++)
        CHECK(fabsf(got.direction[k] - want.direction[k]) < 1e-5f && fabsf(got.origin[k] - want.origin[k]) < 1e-5f,
            "axis %d, sign %d, component %d: %g, not %g", axis, sign, k, (double)got.direction[k],
            (double)want.direction[k]);
    }
}

/* Whatever is not diffuse alone sends a ray to the bright background; without lights the diffuse part is black. */
static void rays_of_each_material(void) {
  for (int mode = PKTRT_MODE_WRT; mode <= PKTRT_MODE_DRT; mode++)
    for (int specular = 0; specular < PKTRT_SPECULAR_COUNT; specular++) {
      pktrt_scene *s = stage_open();
      pktrt_material m = material_of(0.25, (pktrt_specular)specular, 0.5);
      quad pane = quad_of(vec_of(0, 0, 0), vec_of(4, 0, 0), vec_of(0, 4, 0));
      float pixel[3];
      m.extinction[0] = m.extinction[1] = m.extinction[2] = 3;
      stage_quad(s, &pane, stage_material(s, &m));
      stage_commit(s);
      pktrt_render_desc d = stage_view((pktrt_mode)mode, 1, 1, pixel, vec_of(0.1, 0.2, 2), vec_of(0, 0, 0));
      d.camera.fov_y = 1, d.background[0] = d.background[1] = d.background[2] = 1;
      stage_render(s, &d);
      CHECK((pixel[0] > 0.01f) == (specular != PKTRT_SPECULAR_NONE), "mode %d, material %d: %g; has it weights?", mode,
          specular, (double)pixel[0]);
      pktrt_scene_destroy(s);
    }
}

/* The buffer of albedo: nothing for glass and metal where they are such, their albedo in RCS; a mirror's own. */
static void albedo_of_each_material(void) {
  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++)
    for (int specular = 0; specular < PKTRT_SPECULAR_COUNT; specular++) {
      pktrt_scene *s = stage_open();
      pktrt_material m = material_of(0.25, (pktrt_specular)specular, 0.5);
      for (int k = 0; k < 3; k++) {
        m.ior[k] = 1.5f;
        m.extinction[k] = specular == PKTRT_SPECULAR_CONDUCTOR ? 3.0f : 0.0f;
      }
      stage_quad(s, &ground, stage_material(s, &m));
      stage_commit(s);
      float pixel[3];
      float albedo[3];
      pktrt_render_desc view = stage_view((pktrt_mode)mode, 1, 1, pixel, vec_of(0, 5, 3), vec_of(0, 0, 0));
      view.albedo = albedo;
      stage_render(s, &view);
      const bool none =
          mode != PKTRT_MODE_RCS && (specular == PKTRT_SPECULAR_DIELECTRIC || specular == PKTRT_SPECULAR_CONDUCTOR);
      for (int k = 0; k < 3; k++)
        CHECK(fabsf(albedo[k] - (none ? 0 : 0.25f)) < 1e-6f, "mode %d, material %d: albedo %g", mode, specular,
            (double)albedo[k]);
      pktrt_scene_destroy(s);
    }
}

/* --- the second use of a state --- */

/* Keys are deformed one after the other, with a refit each; after each the answers are those of a scene made so at once. */
static void keys_deformed_one_by_one(void) {
  enum { RAYS = 200 };
  world w = world_moving(1);
  pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
  rng r = rng_of(99);
  for (int round = 0; round < 12; round++) {
    const uint32_t m = (uint32_t)round % w.n;
    mesh *x = &w.m[m];
    const uint32_t key = rng_below(&r, x->keys);
    for (uint32_t i = 0; i < 3 * x->nv; i++) x->p[3 * (size_t)x->nv * key + i] += 0.1f * rng_sign(&r);
    CHECK(pktrt_set_positions(s, m, key, x->p + 3 * (size_t)x->nv * key) == PKTRT_OK, "%s", pktrt_last_error(s));
    CHECK(pktrt_refit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
    pktrt_scene *fresh = world_scene(&w, PKTRT_ISA_AUTO, 0);
    pktrt_ray rays[RAYS];
    pktrt_hit got[RAYS];
    pktrt_hit want[RAYS];
    make_rays(&w, fresh, RAYS_RANDOM, (uint64_t)round, 0, rays, RAYS);
    pktrt_intersect_n(s, rays, got, RAYS);
    pktrt_intersect_n(fresh, rays, want, RAYS);
    CHECK(same_bits(got, want, sizeof got), "round %d, mesh %u, key %u", round, (unsigned)m, (unsigned)key);
    pktrt_scene_info info[2];
    pktrt_get_scene_info(s, &info[0]);
    pktrt_get_scene_info(fresh, &info[1]);
    CHECK(same_bits(info[0].bounds_lo, info[1].bounds_lo, 12) && same_bits(info[0].bounds_hi, info[1].bounds_hi, 12));
    pktrt_scene_destroy(fresh);
  }
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* A transform that is flat at one key, whichever, is refused; so is one that is set. */
static void transforms_flat_at_one_key(void) {
  pktrt_scene *s = stage_open();
  mesh box = mesh_box();
  const pktrt_mesh_desc d = mesh_desc(&box);
  pktrt_instance_desc place;
  memset(&place, 0, sizeof place);
  CHECK(pktrt_add_model(s, &d, 1, &place.model) == PKTRT_OK);
  mesh_free(&box);
  for (uint32_t keys = 1; keys <= 4; keys++) {
    float matrices[48];
    for (uint32_t k = 0; k < keys; k++)
      for (uint32_t i = 0; i < 12; i++) matrices[12 * k + i] = i % 5 == 0 && i < 11 ? 1.0f + (float)k : 0;
    place.key_count = keys;
    place.transforms = matrices;
    uint32_t instance = 0;
    CHECK(pktrt_add_instance(s, &place, &instance) == PKTRT_OK, "%s", pktrt_last_error(s));
    for (uint32_t flat = 0; flat < keys; flat++) {
      const float kept = matrices[12 * flat + 5];
      matrices[12 * flat + 5] = 0;
      CHECK(pktrt_add_instance(s, &place, NULL) == PKTRT_INVALID_ARGUMENT, "%u keys, flat at %u", (unsigned)keys,
          (unsigned)flat);
      CHECK(pktrt_set_transform(s, instance, flat, matrices + 12 * flat) == PKTRT_INVALID_ARGUMENT, "%u keys, %u",
          (unsigned)keys, (unsigned)flat);
      matrices[12 * flat + 5] = kept;
      CHECK(pktrt_set_transform(s, instance, flat, matrices + 12 * flat) == PKTRT_OK, "%s", pktrt_last_error(s));
    }
  }
  stage_commit(s);
  pktrt_scene_destroy(s);
}

/* A sky was prepared for one callback; a picture of another one is as if nothing had been prepared. */
static void prepared_for_another_sky(void) {
  enum { W = 12, H = 8, FLOATS = 3 * W * H };
  static float want[FLOATS], got[FLOATS];
  cap first = {{0, 1, 0}, 0.999};
  cap second = {vec_unit(vec_of(1, 1, 0)), 0.999};
  pktrt_scene *s = stage_open();
  stage_quad(s, &ground, 0);
  const pktrt_light sky = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
  stage_light(s, &sky);
  stage_commit(s);
  pktrt_render_desc view = stage_view(PKTRT_MODE_DRT, W, H, want, vec_of(0, 2, 5), vec_of(0, 0, 0));
  view.environment = cap_sky;
  view.user = &second;
  view.samples = 4;
  stage_render(s, &view);
  view.user = &first;
  CHECK(pktrt_prepare_environment(s, &view) == PKTRT_OK);
  view.user = &second;
  view.pixels = got;
  stage_render(s, &view);
  CHECK(same_bits(want, got, sizeof want), "the table of another sky is used");
  CHECK(pktrt_prepare_environment(s, &view) == PKTRT_OK);
  stage_render(s, &view);
  second.axis = first.axis; /* behind the back of its table */
  stage_render(s, &view);
  view.pixels = want;
  view.user = &first;
  stage_render(s, &view);
  CHECK(!same_bits(want, got, sizeof want), "the control: the table of what has changed since is not used");
  pktrt_scene_destroy(s);
}

void suite_pairs(void) {
  run("a matt floor under a sky with a bright cap gets its light to 0.3%", sky_weights);
  run("a glossy floor under a sky with a bright cap gets its light to 0.3%, by octants too", sky_weights_on_gloss);
  run("strips at the edges of lights, quads and meshes, give their form factors", edges_of_lights);
  run("highlights stay where rays end: at max_depth, and where lobes are too weak to be followed",
      highlights_where_rays_end);
  run("shadow rays that end before what moves, and those that go far beside it, are hidden together as alone",
      short_and_long_shadow_rays);
  run("a lamp that moves over gloss gives the mean of pictures at rest", moving_lamp_on_gloss);
  run("whichever lights are asked where, gloss that is seen in gloss has the same mean", choices_of_lights_on_gloss);
  run("a lamp whose texture changes its emission shows so in gloss", textured_lamp_on_gloss);
  run("a lamp of many triangles that has two keys shines on gloss as one that has one", lamp_of_two_keys_on_gloss);
  run("a camera in moving glass with an open shutter is in it for its time", camera_in_moving_glass);
  run("a visible lamp in absorbing glass is dimmed by the way to it", lamp_in_absorbing_glass);
  run("all of fourteen glasses around a camera absorb", many_glasses_around_a_camera);
  run("a cutout before instances hides what is there of it, and nothing else", cutout_before_an_instance);
  run("loose triangles have texture coordinates of their own", coordinates_of_loose_triangles);
  run("a moving camera ends with its up_end, along each axis", up_end_along_each_axis);
  run("each kind of material but a diffuse one sends rays", rays_of_each_material);
  run("the buffer of albedo has each material's, none for glass and metal", albedo_of_each_material);
  run("keys that are deformed one by one, with a refit each, are those of a new scene", keys_deformed_one_by_one);
  run("transforms that are flat at any one key are refused", transforms_flat_at_one_key);
  run("what was prepared for one sky is not used for another", prepared_for_another_sky);
}
