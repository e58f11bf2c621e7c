/* Lights against closed forms: form factors, spheres, meshes, environments; shadows; glossy highlights; each emitter
   once. */
#include "pictures.h"

static const vec up = {0, 1, 0};
static const double albedo = 0.6;

/* A patch at the origin that faces up, of the given material (0: diffuse), on a small floor. */
static pktrt_scene *patch_open(const pktrt_material *m) {
  pktrt_scene *s = stage_open();
  pktrt_material diffuse = material_of(albedo, PKTRT_SPECULAR_NONE, 0);
  quad floor = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 1), vec_of(1, 0, 0));
  stage_quad(s, &floor, stage_material(s, m ? m : &diffuse));
  return s;
}

static pktrt_render_desc patch_spot(void) { return stage_spot(vec_of(-1.5, 2, 0.5), vec_of(0, 0, 0)); }

static double patch_value(pktrt_scene *s, pktrt_mode mode) { /* one ray through the middle */
  float got[3];
  pktrt_render_desc d = patch_spot();
  d.mode = mode, d.width = d.height = 1, d.samples = 1, d.pixels = got;
  stage_render(s, &d);
  return (double)got[0];
}

static pktrt_light sphere_light(vec middle, double radius, double radiance) {
  pktrt_light l = light_of(PKTRT_LIGHT_SPHERE, radiance);
  vec_put(middle, l.position);
  l.radius = (float)radius;
  return l;
}

/* --- area lights --- */

/* Corner formula for a parallel rectangle a x b at distance c, one corner above the patch. */
static double corner_form_factor(double a, double b, double c) {
  double x = a / c, y = b / c, p = sqrt(1 + x * x), q = sqrt(1 + y * y);
  return (x / p * atan(y / p) + y / q * atan(x / q)) / (2 * PI);
}

typedef struct quad_case {
  const char *name;
  quad q;         /* faces the patch; wholly above the horizon */
  double control; /* this part of it lit would not do */
} quad_case;

static int quad_cases(quad_case c[3]) {
  quad above = quad_of(vec_of(0, 2, 0), vec_of(1, 0, 0), vec_of(0, 0, 0.8)),
       corner = quad_of(vec_of(1.5, 2, 1), vec_of(1.5, 0, 0), vec_of(0, 0, 1));
  quad tilted = quad_of(vec_of(1, 1.5, -0.5), vec_of(0.6, -0.5, 0), vec_of(0.2, 0.1, 0.9));
  c[0] = (quad_case){"above", above, 0.97}, c[1] = (quad_case){"at the corner", corner, 0.96},
  c[2] = (quad_case){"tilted", tilted, 0.97};
  return 3;
}

static void quad_lights(void) {
  quad_case c[3];
  CHECK(fabs(corner_form_factor(3, 2, 1) -
             quad_form_factor(vec_of(0, 0, 0), up, &(quad){{0, 1, 0}, {{3, 0, 0}, {0, 0, 2}}})) < 1e-12,
      "two closed forms agree");
  for (int i = 0, n = quad_cases(c); i < n; i++) {
    double want = albedo * 1.5 * quad_form_factor(vec_of(0, 0, 0), up, &c[i].q), worst = 0;
    for (int flipped = 0; flipped < 2; flipped++) {
      quad q = flipped ? quad_flipped(c[i].q) : c[i].q;
      pktrt_scene *s = patch_open(NULL);
      pktrt_light l = quad_light(&q, 1.5);
      stage_light(s, &l);
      stage_commit(s);
      if (flipped)
        CHECK(patch_value(s, PKTRT_MODE_DRT) == 0 && patch_value(s, PKTRT_MODE_WRT) == 0, "it shines to one side only");
      for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT && !flipped; sampler++) {
        char name[64];
        pktrt_render_desc d = patch_spot();
        d.sampler = (pktrt_sampler)sampler;
        snprintf(name, sizeof name, "quad %s, %s", c[i].name, pktrt_sampler_string(d.sampler));
        estimate e = stage_estimate(s, &d, 16);
        check_estimate(name, &e, want, want * c[i].control, 0.01);
        worst = fmax(worst, fabs(e.mean[0] - want) / e.error[0]);
      }
      pktrt_scene_destroy(s);
    }
    say("%s: %.5f; every sampler within %.1f standard errors", c[i].name, want, worst);
  }
}

static void sphere_lights(void) {
  static const double radius[3] = {0.001, 0.5, 1.2};
  for (int i = 0; i < 3; i++) {
    vec middle = vec_of(0.9 + 0.4 * i, 1.6, -0.5);
    double d2 = vec_dot(middle, middle), cosine = middle.y / sqrt(d2),
           want = albedo * radius[i] * radius[i] / d2 * cosine;
    for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler += i == 1 ? 1 : 3) {
      char name[64];
      pktrt_scene *s = patch_open(NULL);
      pktrt_light l = sphere_light(middle, radius[i], i == 0 ? 1e6 : 1);
      stage_light(s, &l);
      stage_commit(s);
      pktrt_render_desc d = patch_spot();
      d.sampler = (pktrt_sampler)sampler;
      snprintf(name, sizeof name, "sphere of radius %g, %s", radius[i], pktrt_sampler_string(d.sampler));
      estimate e = stage_estimate(s, &d, 16);
      double scaled_want = i == 0 ? want * 1e6 : want;
      check_estimate(name, &e, scaled_want, scaled_want * 0.97, 0.01);
      CHECK(fabs(patch_value(s, PKTRT_MODE_WRT) - scaled_want) < 1e-4 * scaled_want,
          "%s: WRT takes its middle: the same closed form", name);
      pktrt_scene_destroy(s);
    }
  }
}

/* Next to a light, and far from it: samples by solid angle have bounded variance. `skew`: of a parallelogram. */
static void near_light(const char *name, int kind, double distance) {
  const double skew = kind == 1 ? 0.4 : 0, radiance = fmax(1, distance * distance);
  quad q = quad_of(vec_of(-0.4, distance, -0.3), vec_of(1, 0, skew), vec_of(0, 0, 1));
  pktrt_scene *s = patch_open(NULL);
  pktrt_material lamp = lamp_of(radiance);
  pktrt_light l = kind < 2 ? quad_light(&q, radiance) : light_of(PKTRT_LIGHT_MESH, 1);
  double want = radiance * albedo * quad_form_factor(vec_of(0, 0, 0), up, &q);
  if (kind == 2) l.mesh = stage_quad(s, &q, stage_material(s, &lamp));
  if (kind == 3) {
    l = sphere_light(vec_of(0, distance + 0.5, 0), 0.5, radiance);
    want = radiance * albedo * 0.25 / ((distance + 0.5) * (distance + 0.5));
  }
  stage_light(s, &l);
  stage_commit(s);
  pktrt_render_desc d = stage_spot(vec_of(-0.3 * distance, 0.2 * distance, 0.1 * distance), vec_of(0, 0, 0));
  d.camera.fov_y = 0.01f;
  estimate e = stage_estimate(s, &d, 16);
  check_estimate(name, &e, want, want * 0.9, small_run ? 0.1 : 0.03);
  pktrt_scene_destroy(s);
}
static void near_lights(void) {
  static const char *const names[4] = {"a rectangle", "a parallelogram", "a mesh", "a sphere"};
  for (int kind = 0; kind < 4; kind++)
    for (int e = -4; e <= 2; e++) near_light(names[kind], kind, pow(10, e));
}

/* In a sphere that is a light, everything is lit from all sides; lit of itself it is not. */
static void within_a_sphere(void) {
  pktrt_scene *s = patch_open(NULL);
  pktrt_light l = sphere_light(vec_of(0.2, 0.5, 0), 9, 2);
  stage_light(s, &l);
  stage_commit(s);
  pktrt_render_desc d = patch_spot();
  estimate e = stage_estimate(s, &d, 16);
  check_estimate("within a sphere", &e, albedo * 2, albedo, 0.02);
  CHECK(patch_value(s, PKTRT_MODE_WRT) == 0, "WRT has no direction to take");
  pktrt_scene_destroy(s);
}

/* RCS and WRT take a quad in its middle: `L A cos cos / (pi d^2)`. */
static void middles(void) {
  quad_case c[3];
  for (int i = 0, n = quad_cases(c); i < n; i++) {
    pktrt_scene *s = patch_open(NULL);
    pktrt_light l = quad_light(&c[i].q, 1.5);
    stage_light(s, &l);
    stage_commit(s);
    vec middle = quad_at(&c[i].q, 0.5, 0.5), area = vec_cross(c[i].q.edge[0], c[i].q.edge[1]);
    double d2 = vec_dot(middle, middle), want = albedo * 1.5 * -vec_dot(area, middle) * middle.y / (PI * d2 * d2);
    for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_WRT; mode++) {
      double got = patch_value(s, (pktrt_mode)mode);
      CHECK(fabs(got - want) < 1e-5 * want + 1e-6, "%s, mode %d: %g, not %g", c[i].name, mode, got, want);
    }
    double true_value = albedo * 1.5 * quad_form_factor(vec_of(0, 0, 0), up, &c[i].q);
    CHECK(
        fabs(want - true_value) > 0.01 * true_value, "the control: the closed form of the whole light is another one");
    pktrt_scene_destroy(s);
  }
}

/* A grid of unequal cells over a quad. */
static mesh uneven_lamp(const quad *q) {
  static const double cut[4] = {0, 0.1, 0.7, 1};
  mesh m = mesh_of(16, 18);
  for (uint32_t i = 0; i < 16; i++) vec_put(quad_at(q, cut[i % 4], cut[i / 4]), m.p + 3 * i);
  for (uint32_t i = 0; i < 9; i++) {
    uint32_t a = i / 3 * 4 + i % 3, corner[6] = {a, a + 1, a + 5, a, a + 5, a + 4};
    memcpy(m.i + 6 * i, corner, sizeof corner);
  }
  return m;
}

/* The emission of a mesh, its light's factor and the way its triangles turn; it stands for a quad light of the same
   shape. */
static void mesh_lights(void) {
  quad_case c[3];
  for (int i = 0, n = quad_cases(c); i < n; i++) {
    double want = albedo * 1.5 * quad_form_factor(vec_of(0, 0, 0), up, &c[i].q);
    for (int turned = 0; turned < 2; turned++) {
      pktrt_scene *s = patch_open(NULL);
      pktrt_material lamp = lamp_of(3);
      quad q = turned ? quad_flipped(c[i].q) : c[i].q;
      mesh m = uneven_lamp(&q);
      pktrt_light l = light_of(PKTRT_LIGHT_MESH, 0.5);
      l.mesh = stage_mesh(s, &m, stage_material(s, &lamp));
      stage_light(s, &l);
      stage_commit(s);
      pktrt_render_desc d = patch_spot();
      for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler += turned ? PKTRT_SAMPLER_COUNT : 1) {
        d.sampler = (pktrt_sampler)sampler;
        estimate e = stage_estimate(s, &d, small_run ? 16 : 64);
        check_estimate(c[i].name, &e, want, want * c[i].control, 0.01);
      }
      d.camera = stage_view(PKTRT_MODE_DRT, 1, 1, NULL, vec_of(0, 0.01, 0), quad_at(&c[i].q, 0.3, 0.45)).camera;
      estimate e = stage_estimate(s, &d, 2);
      CHECK(e.mean[0] > 0.5, "and the camera sees it: %g", e.mean[0]);
      d.camera.fov_y = 0.02f;
      e = stage_estimate(s, &d, 2);
      CHECK(fabs(e.mean[0] - 3) < 1e-5, "with its own emission: %g", e.mean[0]);
      pktrt_scene_destroy(s);
      mesh_free(&m);
    }
  }
}

/* RCS and WRT take one point of a mesh light: far away it is as good as the light itself, be it large or small. */
static void far_mesh_light_of(double size) {
  quad q = quad_of(vec_of(30, 60, -10), vec_of(size, 0, 0), vec_of(0, 0, 1.5 * size));
  pktrt_scene *s = patch_open(NULL);
  pktrt_material lamp = lamp_of(300 / (size * size));
  mesh m = uneven_lamp(&q);
  pktrt_light l = light_of(PKTRT_LIGHT_MESH, 2);
  l.mesh = stage_mesh(s, &m, stage_material(s, &lamp));
  stage_light(s, &l);
  stage_commit(s);
  double whole = albedo * 600 / (size * size) * quad_form_factor(vec_of(0, 0, 0), up, &q);
  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_WRT; mode++) {
    double got = patch_value(s, (pktrt_mode)mode);
    say("a far mesh light of size %g in mode %d: %.5f of the closed form", size, mode, got / whole);
    CHECK(fabs(got / whole - 1) < 0.01, "mode %d: it gives light: %g, not %g", mode, got, whole);
  }
  pktrt_scene_destroy(s);
  mesh_free(&m);
}

static void far_mesh_light(void) { far_mesh_light_of(1), far_mesh_light_of(0.125); }

/* A tilted lamp at the origin must not shadow itself, however far away the patch is: shadow rays that start at large
   coordinates end near small ones. Emission grows with the distance, so that every patch is about as bright. */
static void lamps_at_distances(void) {
  static const double distance[5] = {1, 30, 100, 1000, 10000};
  vec a = vec_unit(vec_of(1, -1, 0)), b = vec_unit(vec_of(1, 1, -2)), n = vec_cross(b, a);
  quad q = quad_flipped(quad_of(vec_of(0, 0, 0), vec_mul(a, 0.5), vec_mul(b, 0.5))),
       screen = quad_of(vec_mul(n, 0.1), vec_mul(a, 0.6), vec_mul(b, 0.6));
  for (int i = 0; i < 5; i++) {
    double d = distance[i], want = 0;
    vec p = vec_mul(vec_unit(vec_of(-0.71, -1, -0.53)), d);
    quad floor = quad_of(p, vec_of(0, 0, d / 20), vec_of(d / 20, 0, 0));
    for (int kind = 0; kind < 3; kind++) { /* a quad light, a mesh, a mesh behind a screen */
      pktrt_scene *s = stage_open();
      pktrt_material diffuse = material_of(albedo, PKTRT_SPECULAR_NONE, 0), lamp = lamp_of(2 * d * d);
      pktrt_light l = kind ? light_of(PKTRT_LIGHT_MESH, 1) : quad_light(&q, 2 * d * d);
      stage_quad(s, &floor, stage_material(s, &diffuse));
      if (kind) l.mesh = stage_quad(s, &q, stage_material(s, &lamp));
      if (kind == 2) stage_quad(s, &screen, 0);
      stage_light(s, &l);
      stage_commit(s);
      want = albedo * 2 * d * d * quad_form_factor(p, up, &q);
      pktrt_render_desc view = stage_spot(vec_add(p, vec_mul(vec_of(0.3, 0.2, -0.4), d / 10)), p);
      estimate e = stage_estimate(s, &view, 64);
      if (kind < 2) check_estimate(kind ? "a mesh far away" : "a quad far away", &e, want, want * 0.997, 0.002);
      else CHECK(e.mean[0] == 0, "the control, distance %g: %g behind a screen", d, e.mean[0]);
      if (kind == 1) say("at %g: %.5f of the closed form, +- %.5f", d, e.mean[0] / want, e.error[0] / want);
      pktrt_scene_destroy(s);
    }
  }
}

/* A lamp that rises and grows while the shutter is open: the mean of its form factors. */
static void moving_lamp(void) {
  static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
  quad low = quad_of(vec_of(0, 1, 0), vec_of(1, 0, 0), vec_of(0, 0, 1)),
       high = quad_of(vec_of(0, 3, 0), vec_of(1, 0, 0), vec_of(0, 0, 4));
  float p[24];
  for (int k = 0; k < 8; k++) vec_put(quad_at(k < 4 ? &low : &high, k % 4 == 1 || k % 4 == 2, k % 4 >= 2), p + 3 * k);
  pktrt_scene *s = patch_open(NULL);
  pktrt_material lamp = lamp_of(1);
  pktrt_light l = light_of(PKTRT_LIGHT_MESH, 1);
  pktrt_mesh_desc m;
  memset(&m, 0, sizeof m);
  m.positions = p, m.vertex_count = 4, m.indices = corners, m.triangle_count = 2, m.key_count = 2;
  m.material = stage_material(s, &lamp);
  CHECK(pktrt_add_mesh(s, &m, &l.mesh) == PKTRT_OK);
  stage_light(s, &l);
  stage_commit(s);
  double want = 0, frozen = 0;
  for (int i = 0; i < 1000; i++) {
    double h = 1.5 + (i + 0.5) / 1000; /* times 0.25 to 0.75 */
    quad q = quad_of(vec_of(0, h, 0), vec_of(1, 0, 0), vec_of(0, 0, 1 + 3 * (h - 1) / 2));
    want += albedo * quad_form_factor(vec_of(0, 0, 0), up, &q) / 1000;
    if (i == 0) frozen = albedo * quad_form_factor(vec_of(0, 0, 0), up, &q);
  }
  pktrt_render_desc d = stage_spot(vec_of(-1.9, 0.9, 0), vec_of(0, 0, 0)); /* below the lamp at all times */
  d.camera.time = 0.25f, d.camera.shutter = 0.5f;
  estimate e = stage_estimate(s, &d, 16);
  check_estimate("a lamp that rises and grows", &e, want, frozen, 0.01);
  pktrt_scene_destroy(s);
}

/* A globe of triangles, wound outwards, inwards, or some of them so and some so. From outside it hides its far half
   itself: shadow rays that go there are noise. By area, samples would have a standard deviation of sqrt(5 / 3) times
   their mean: that of max(0, cos) over a sphere. */
static void globes(void) {
  static const char *const winding[3] = {"outwards", "inwards", "mixed"};
  for (int i = 0; i < 6; i++) {
    bool inside = i >= 3, mixed = i % 3 == 2;
    double radius = inside ? 6 : 0.5, distance = inside ? 0 : 3;
    mesh globe = mesh_sphere(4, 0, 1);
    for (uint32_t t = 0; t < globe.nt; t++) {
      uint32_t *v = globe.i + 3 * t, keep = v[1];
      if (i % 3 == 1 || (mixed && t % 2)) v[1] = v[2], v[2] = keep;
    }
    mesh_scale(&globe, (float)radius), mesh_shift(&globe, 0, (float)distance, 0);
    pktrt_scene *s = patch_open(NULL);
    pktrt_material lamp = lamp_of(2);
    pktrt_light l = light_of(PKTRT_LIGHT_MESH, 1);
    l.mesh = stage_mesh(s, &globe, stage_material(s, &lamp));
    stage_light(s, &l);
    stage_commit(s);
    pktrt_render_desc d = patch_spot();
    d.sampler = PKTRT_SAMPLER_RANDOM;
    int seeds = 64;
    estimate e = stage_estimate(s, &d, seeds);
    double want = albedo * 2 * (inside ? 1 : radius * radius / (distance * distance));
    double samples = (double)(d.width * d.height * (small_run ? (d.samples + 7) / 8 : d.samples)) * seeds;
    double noise = e.error[0] * sqrt(samples) / e.mean[0];
    say("%s, seen from %s: %.4f of the closed form, noise of a sample %.2f", winding[i % 3],
        inside ? "inside" : "outside", e.mean[0] / want, noise);
    CHECK(
        fabs(e.mean[0] / want - 1) < 4 * e.error[0] / want + 0.005, "%s: %g, not %g", winding[i % 3], e.mean[0], want);
    if (!inside) CHECK((noise < 0.95) == !mixed && (noise > 1.2) == mixed, "%s: noise %g", winding[i % 3], noise);
    pktrt_scene_destroy(s);
    mesh_free(&globe);
  }
}

/* A flat tetrahedron whose triangles come in pairs, by their places, of which one hides behind the other: a large one that
   looks away from the patch, and a small one that faces it and is a third of what is seen. */
static void pairs_that_look_away(void) {
  static const float corner[4][3] = {{-10, -2, 7}, {-3, -1, -2}, {-10, -2, -11}, {7, 2, -1}};
  static const uint32_t face[4][3] = {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {2, 0, 3}};
  mesh m = mesh_of(4, 4);
  memcpy(m.i, face, sizeof face), memcpy(m.p, corner, sizeof corner);
  mesh_scale(&m, 1.0f / 16), mesh_shift(&m, 0, 8, 0);
  double part[4], all = 0, least = INFINITY;
  for (uint32_t t = 0; t < 4; t++) {
    vec p[3];
    for (uint32_t c = 0; c < 3; c++) p[c] = vec_from(m.p + 3 * m.i[3 * t + c]);
    const vec normal = vec_cross(vec_sub(p[1], p[0]), vec_sub(p[2], p[0]));
    part[t] = vec_dot(normal, p[0]) < 0 ? fabs(form_factor(vec_of(0, 0, 0), up, p, 3)) : 0;
    all += part[t], least = part[t] > 0 ? fmin(least, part[t]) : least;
  }
  pktrt_scene *s = patch_open(NULL);
  pktrt_material lamp = lamp_of(100);
  pktrt_light l = light_of(PKTRT_LIGHT_MESH, 1);
  l.mesh = stage_mesh(s, &m, stage_material(s, &lamp));
  stage_light(s, &l);
  stage_commit(s);
  pktrt_render_desc d = patch_spot();
  d.samples = 64;
  estimate e = stage_estimate(s, &d, 32);
  check_estimate("a tetrahedron", &e, albedo * 100 * all, albedo * 100 * (all - least), 0.02);
  say("%.4f +- %.4f, not %.4f; the triangle seen least gives %.3f of it", e.mean[0], e.error[0], albedo * 100 * all,
      least / all);
  pktrt_scene_destroy(s);
  mesh_free(&m);
}

/* --- environment --- */

static void environments(void) {
  for (int kind = 0; kind < 3; kind++) { /* open; half closed by a black wall; none */
    pktrt_scene *s = patch_open(NULL);
    pktrt_light l = light_of(PKTRT_LIGHT_ENVIRONMENT, 0.5);
    l.intensity[1] = 0.25f, l.intensity[2] = 2;
    pktrt_material black = material_of(0, PKTRT_SPECULAR_NONE, 0);
    quad wall = quad_of(vec_of(1, 500.4, 0), vec_of(0, 500, 0), vec_of(0, 0, 1000));
    if (kind < 2) stage_light(s, &l);
    if (kind == 1) stage_quad(s, &wall, stage_material(s, &black));
    stage_commit(s);
    double closed = kind == 1   ? quad_form_factor(vec_of(0, 0, 0), up, &wall)
                    : kind == 2 ? 1
                                : 0,
           want = albedo * 1.25 * (1 - closed);
    CHECK(kind != 1 || fabs(closed - 0.464) < 0.002, "nearly half the sky: %g", closed);
    for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
      pktrt_render_desc d = patch_spot();
      d.sampler = (pktrt_sampler)sampler;
      for (int k = 0; k < 3; k++) d.background[k] = k == 2 ? 1.25f : 2.5f;
      estimate e = stage_estimate(s, &d, 16);
      if (kind == 1) check_estimate("nearly half the sky", &e, want, want * 0.95, 0.015);
      else
        CHECK(fabs(e.mean[0] - want) < 1e-5 && e.error[0] < 1e-6, "%g +- %g: no noise where nothing is in the way",
            e.mean[0], e.error[0]);
      CHECK(fabs(e.mean[1] - e.mean[0] / 2) < 1e-5 && fabs(e.mean[2] - e.mean[0] * 2) < 1e-5,
          "the light has its colour, %g %g %g", e.mean[0], e.mean[1], e.mean[2]);
    }
    pktrt_scene_destroy(s);
  }
}

/* Irradiance from a sky whose radiance is the height, 3 cos: albedo / pi * integral of 3 cos^2 = 2 albedo. */
static void sky_height(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (int k = 0; k < 3; k++) {
    for (uint32_t i = 0; i < n; i++) radiance[k][i] = direction[1][i] > 0 ? 3 * direction[1][i] : 0;
  }
}

static void sky_even(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user, (void)direction;
  for (uint32_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) radiance[a][i] = 1;
}
static void environment_callbacks(void) {
  pktrt_scene *s = patch_open(NULL);
  pktrt_light l = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
  stage_light(s, &l);
  stage_commit(s);
  pktrt_render_desc d = patch_spot();
  d.environment = sky_height, d.background[0] = 77;
  estimate e = stage_estimate(s, &d, 16);
  check_estimate("a sky that is brighter above", &e, albedo * 2, albedo * 1.95, 0.01);
  d.environment = sky_even;
  e = stage_estimate(s, &d, 16);
  CHECK(fabs(e.mean[0] - albedo) < 1e-5, "a sky that is the same everywhere: %g", e.mean[0]);
  pktrt_scene_destroy(s);
}

/* A sun in a black sky, of 0.03 sr and of 7e-5: sampled by where the environment is bright. Its middle is 45 degrees high. */
static double sun_cosine = 0;
static void sun(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++)
      radiance[a][i] = ((double)direction[0][i] + (double)direction[1][i]) * sqrt(0.5) > sun_cosine ? 1000 : 0;
}
static void suns(void) {
  for (int small = 0; small < 2; small++)
    for (int prepared = 0; prepared < 2; prepared++) {
      const double angle = small ? 0.0047 : 0.1;
      pktrt_scene *s = patch_open(NULL);
      pktrt_light l = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
      stage_light(s, &l);
      stage_commit(s);
      pktrt_render_desc d = patch_spot();
      sun_cosine = cos(angle), d.environment = sun, d.samples = small && !prepared ? 4096 : 64;
      if (prepared) CHECK(pktrt_prepare_environment(s, &d) == PKTRT_OK);
      estimate e = stage_estimate(s, &d, 16);
      const double want = albedo * 1000 * sin(angle) * sin(angle) * sqrt(0.5);
      check_estimate(small ? "a small sun" : "a large sun", &e, want, want * 0.9, 0.03);
      pktrt_scene_destroy(s);
    }
}

/* --- directional lights with an angle --- */

static const float sun_angles[] = {0.0001f, 0.01f, 0.265f, 5, 60};

static pktrt_light sun_light(vec to, float angle) {
  pktrt_light l = light_of(PKTRT_LIGHT_DIRECTIONAL, 2);
  vec_put(vec_mul(to, -3), l.direction);
  l.angle = angle;
  return l;
}

/* A plane gets the irradiance of a sun that faces it, times the cosine, whatever the angle. RCS and WRT take the middle. */
static void sun_lights(void) {
  const vec to = vec_unit(vec_of(0.3, 1, -0.2));
  const double want = albedo * 2 * to.y / PI;
  for (size_t i = 0; i < COUNT(sun_angles); i++) {
    pktrt_light l = sun_light(to, sun_angles[i]), middle = sun_light(to, 0);
    pktrt_scene *s = patch_open(NULL), *plain = patch_open(NULL);
    stage_light(s, &l), stage_light(plain, &middle);
    stage_commit(s), stage_commit(plain);
    pktrt_render_desc d = patch_spot();
    estimate e = stage_estimate(s, &d, 16);
    check_estimate("a sun", &e, want, want * (i < 4 ? 0.995 : 0.97), 0.01);
    for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_WRT; mode++)
      CHECK(patch_value(s, (pktrt_mode)mode) == patch_value(plain, (pktrt_mode)mode), "mode %d, angle %g", mode,
          (double)sun_angles[i]);
    pktrt_scene_destroy(s), pktrt_scene_destroy(plain);
  }
}

/* Camera and mirrors see a sun that is visible, as bright as it lights, and nothing beside it or behind a lid. */
static void visible_suns(void) {
  const vec to = vec_unit(vec_of(0.3, 1, -0.2)), aside = vec_unit(vec_of(0.3, 0, 1.5));
  const pktrt_material mirror = material_of(0, PKTRT_SPECULAR_MIRROR, 1);
  const quad lid = quad_of(vec_of(-9, 5, -9), vec_of(18, 0, 0), vec_of(0, 0, 18));
  for (int kind = 0; kind < 4; kind++) /* bits: visible; a lid before it */
    for (size_t i = 1; i < COUNT(sun_angles); i++) {
      pktrt_light l = sun_light(to, sun_angles[i]);
      const double half = (double)l.angle * PI / 180;
      const double radiance = 2 / (PI * sin(half) * sin(half));
      pktrt_scene *s = patch_open(&mirror);
      l.visible = (kind & 1) != 0;
      stage_light(s, &l);
      if (kind & 2) stage_quad(s, &lid, 0);
      stage_commit(s);
      for (int k = 0; k < 12; k++) { /* modes; beside the sun; in the mirror */
        const double off = k / 3 % 2 ? 1.2 * half : 0.8 * half;
        const vec way = vec_add(vec_mul(to, cos(off)), vec_mul(aside, sin(off)));
        const vec eye = k < 6 ? vec_of(0, 1, 0) : vec_of(way.x, way.y, way.z);
        const vec at = k < 6 ? vec_add(eye, way) : vec_of(2 * way.x, 0, 2 * way.z);
        float got[3];
        if (k >= 6 && k % 3 == 0) continue; /* RCS has no mirrors */
        const vec target = k < 6 ? at : vec_of(0, 0, 0), from = k < 6 ? eye : vec_of(-way.x, way.y, -way.z);
        pktrt_render_desc d = stage_view((pktrt_mode)(k % 3), 1, 1, got, from, target);
        d.camera.fov_y = 1e-6f, d.camera.up[0] = 1, d.camera.up[1] = 0, d.samples = 1;
        stage_render(s, &d);
        const double want = kind == 1 && k / 3 % 2 == 0 ? radiance : 0;
        const double more = kind & 2 ? 1 : 0; /* the lid may be lit */
        if (want > 0 || more <= 0)
          CHECK(fabs((double)got[0] - want) <= 1e-4 * want, "kind %d, case %d, angle %g: %g, not %g", kind, k,
              (double)l.angle, (double)got[0], want);
        else CHECK(got[0] < 1, "kind %d, case %d, angle %g: %g behind a lid", kind, k, (double)l.angle, (double)got[0]);
      }
      pktrt_scene_destroy(s);
    }
}

/* Angles that mean nothing are refused by name; lights that have none don't read them. */
static void angles_of_suns(void) {
  static const float wrong[] = {-1e-6f, 90.01f, INFINITY, -INFINITY, NAN};
  for (size_t i = 0; i < COUNT(wrong); i++)
    for (int kind = 0; kind < 2; kind++) {
      pktrt_scene *s = stage_open();
      pktrt_light l = kind ? light_of(PKTRT_LIGHT_POINT, 1) : sun_light(vec_of(0, 1, 0), 0);
      l.angle = wrong[i];
      const bool refused = pktrt_add_light(s, &l, NULL) != PKTRT_OK;
      CHECK(refused == !kind, "angle %g, kind %d", (double)wrong[i], kind);
      CHECK(kind || strstr(pktrt_last_error(s), "angle"), "%s", pktrt_last_error(s));
      pktrt_scene_destroy(s);
    }
}

/* A sun of a half-angle in degrees in a black sky, of irradiance 1. */
typedef struct small_sun_of {
  vec to;
  double half;
} small_sun_of;
static void small_sun_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  const small_sun_of *of = user;
  const double chord = 2 * sin(of->half * PI / 360), bright = 1 / (PI * pow(sin(of->half * PI / 180), 2));
  for (uint32_t i = 0; i < n; i++) {
    const vec d = vec_of((double)direction[0][i], (double)direction[1][i], (double)direction[2][i]);
    const vec off = vec_sub(d, of->to);
    for (int a = 0; a < 3; a++) radiance[a][i] = vec_dot(off, off) < chord * chord ? (float)bright : 0.01f;
  }
}

/* No sun as wide as that of the Earth is lost, unprepared; a smaller one is not if a look is taken at each pixel. */
static void placed_suns(void) {
  rng r = rng_of(58);
  double worst = 1;
  int lost = 0;
  for (int i = 0; i < 14; i++) {
    const bool small = i >= 12, zenith = i == 0;
    small_sun_of sun = {
        vec_unit(vec_of((double)rng_sign(&r), zenith ? 1000 : 0.3, (double)rng_sign(&r))), small ? 0.05 : 0.265};
    pktrt_scene *s = patch_open(NULL);
    const pktrt_light l = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
    stage_light(s, &l);
    stage_commit(s);
    pktrt_render_desc d = patch_spot();
    d.environment = small_sun_sky, d.user = &sun, d.samples = 64;
    if (small) d.environment_width = 4800, d.environment_height = 2400;
    const double want = albedo / PI * (sun.to.y + 0.01 * PI);
    estimate e = stage_estimate(s, &d, 2);
    lost += e.mean[0] < 0.5 * want;
    worst = fmin(worst, 1 - fabs(e.mean[0] / want - 1));
    pktrt_scene_destroy(s);
  }
  say("within %.1f%% of their light at worst", 100 * (1 - worst));
  CHECK(lost == 0 && worst > 0.9, "%d lost, to %g of the light", lost, worst);
}

/* --- several lights, shadows --- */

static void light_sums(void) {
  quad_case c[3];
  quad_cases(c);
  pktrt_light l[5];
  l[0] = light_of(PKTRT_LIGHT_POINT, 2), l[0].position[0] = 1, l[0].position[1] = 2;
  l[1] = light_of(PKTRT_LIGHT_DIRECTIONAL, 0.5), l[1].direction[0] = 3, l[1].direction[1] = -4;
  l[2] = quad_light(&c[0].q, 1), l[3] = sphere_light(vec_of(-1, 2, 0), 0.4, 3),
  l[4] = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
  double part[5] = {2 * 2 / sqrt(5) / 5 / PI, 0.5 * 0.8 / PI, quad_form_factor(vec_of(0, 0, 0), up, &c[0].q),
      3 * 0.16 / 5 * 2 / sqrt(5), 0.3};
  double want = 0;
  pktrt_scene *s = patch_open(NULL);
  stage_commit(s);
  for (int i = 0; i < 5; i++) {
    stage_light(s, &l[i]); /* counts from the next render on */
    want += albedo * part[i];
    pktrt_render_desc d = patch_spot();
    d.background[0] = 0.3f, d.ambient[1] = 0.25f;
    estimate e = stage_estimate(s, &d, 16);
    check_estimate("lights add up", &e, want, want - 0.5 * albedo * part[i], 0.01);
    CHECK(fabs(e.mean[1] - e.mean[0] - albedo * 0.25 + (i == 4 ? 0.3 * albedo : 0)) < 1e-4,
        "and so does the ambient: %g", e.mean[1] - e.mean[0]);
  }
  pktrt_scene_destroy(s);
}

/* A screen halfway before half of a quad light. */
static void penumbra(void) {
  quad lamp = quad_of(vec_of(0, 2, 0), vec_of(1, 0, 0), vec_of(0, 0, 1)),
       half = quad_of(vec_of(0.5, 2, 0), vec_of(0.5, 0, 0), vec_of(0, 0, 1));
  quad screen = quad_of(vec_of(-1, 1, 0), vec_of(1, 0, 0), vec_of(0, 0, 2));
  pktrt_scene *s = patch_open(NULL);
  pktrt_light l = quad_light(&lamp, 1);
  stage_light(s, &l);
  stage_quad(s, &screen, 0);
  stage_commit(s);
  pktrt_render_desc d = stage_spot(vec_of(1.5, 2, 0.5), vec_of(0, 0, 0));
  for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
    d.sampler = (pktrt_sampler)sampler;
    estimate e = stage_estimate(s, &d, 16);
    double want = albedo * quad_form_factor(vec_of(0, 0, 0), up, &half);
    check_estimate("half a light", &e, want, want * 1.06, 0.02);
  }
  pktrt_scene_destroy(s);
}

/* Glass between a light and the patch, straight on: (1 - F)^2 exp(-a thickness), or nothing. */
static void glass_shadows(void) {
  mesh box = mesh_box();
  mesh_place(&box, (float[3]){2, 0.25f, 2}, (float[3]){0, 1, 0});
  pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  glass.absorption[0] = 0.7f;
  pktrt_light l = light_of(PKTRT_LIGHT_POINT, 3);
  l.position[1] = 2;
  for (int with = 0; with < 2; with++) {
    pktrt_scene *s = patch_open(NULL);
    stage_light(s, &l);
    if (with) stage_mesh(s, &box, stage_material(s, &glass));
    stage_commit(s);
    for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++) {
      for (int block = 0; block < 2; block++) {
        float got[3];
        pktrt_render_desc d = stage_view((pktrt_mode)mode, 1, 1, got, vec_of(-0.5, 0.2, 0), vec_of(0, 0, 0));
        d.glass_shadows = block ? PKTRT_GLASS_SHADOWS_BLOCK : PKTRT_GLASS_SHADOWS_PASS, d.camera.fov_y = 0.01f;
        stage_render(s, &d);
        double want = albedo * 3 / (4 * PI), f = fresnel_exact(1, 1.5), pass = (1 - f) * (1 - f);
        for (int k = 0; k < 2; k++) {
          double left = !with ? 1 : block || mode == PKTRT_MODE_RCS ? 0 : k == 0 ? pass * exp(-0.7 * 0.5) : pass;
          CHECK(fabs((double)got[k] - want * left) < 2e-4 * want, "mode %d, block %d, channel %d: %g, not %g", mode,
              block, k, (double)got[k], want * left);
        }
      }
    }
    pktrt_scene_destroy(s);
  }
  mesh_free(&box);
}

/* The length of a direction means nothing, tiny or huge; along an axis not even for the last bit. */
static void direction_lengths(void) {
  enum { N = 24 };
  static const float length[] = {1, 1e-45f, 1e-42f, 1e-38f, 1e-20f, 1e20f, 1e30f};
  quad screen = quad_of(vec_of(0.5, 0.3, 0), vec_of(0.5, 0, 0), vec_of(0, 0, 1));
  pktrt_material m = material_of(albedo, PKTRT_SPECULAR_MIRROR, 0.3);
  m.lobe = PKTRT_LOBE_PHONG, m.exponent = 15;
  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++) {
    float want[N * N * 3], got[N * N * 3];
    for (size_t i = 0; i <= COUNT(length); i++) {
      bool control = i == COUNT(length); /* another direction */
      pktrt_light l = light_of(PKTRT_LIGHT_DIRECTIONAL, 2);
      l.direction[1] = control ? -1e-42f : -length[i], l.direction[0] = control ? 1e-42f : 0;
      pktrt_scene *s = patch_open(&m);
      stage_quad(s, &screen, 0);
      stage_light(s, &l);
      stage_commit(s);
      pktrt_render_desc d = stage_view((pktrt_mode)mode, N, N, i ? got : want, vec_of(-1.5, 2, 0.5), vec_of(0, 0, 0));
      d.camera.fov_y = 20, d.max_depth = 2;
      stage_render(s, &d);
      size_t lit = 0, dark = 0;
      for (int k = 0; k < N * N; k++) lit += d.pixels[3 * k] > 0.3f, dark += d.pixels[3 * k] == 0;
      if (i == 0) CHECK(lit > N * N / 4 && dark > N * N / 8, "half of it in shadow: %zu lit, %zu dark", lit, dark);
      else
        CHECK(same_bits(want, got, sizeof got) != control, "mode %d, length %g: %zu lit, %zu dark", mode,
            control ? 0 : (double)length[i], lit, dark);
      pktrt_scene_destroy(s);
    }
  }
}

/* Light through a pane to a patch, with or without an opaque wall behind the pane, all k times as large. Intensities
   are as for k = 1: those of a point grow by k^2. */
static double scaled_pane(pktrt_light_kind kind, pktrt_mode mode, double k, bool pane, bool wall) {
  pktrt_scene *s = stage_open();
  pktrt_material diffuse = material_of(albedo, PKTRT_SPECULAR_NONE, 0),
                 glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  quad q = quad_of(vec_of(0, 0, 0), vec_of(0, 0, k), vec_of(k, 0, 0)),
       lamp = quad_of(vec_of(0.1 * k, k, 0), vec_of(0.3 * k, 0, 0), vec_of(0, 0, 0.2 * k));
  stage_quad(s, &q, stage_material(s, &diffuse));
  q.corner.y = k / 2;
  if (pane) stage_quad(s, &q, stage_material(s, &glass));
  q.corner.y = 0.75 * k;
  if (wall) stage_quad(s, &q, 0);
  pktrt_light l = kind == PKTRT_LIGHT_QUAD ? quad_light(&lamp, 4) : light_of(kind, 4);
  if (kind == PKTRT_LIGHT_POINT) l = light_of(kind, 4 * k * k);
  if (kind != PKTRT_LIGHT_QUAD) vec_put(vec_of(0.1 * k, k, 0), l.position);
  l.direction[1] = -1, l.radius = (float)(0.2 * k);
  stage_light(s, &l);
  stage_commit(s);
  pktrt_render_desc d = stage_spot(vec_of(-0.3 * k, 0.2 * k, 0.1 * k), vec_of(0, 0, 0));
  d.mode = mode, d.pixels = stage_pixels((size_t)d.width * d.height * 3);
  stage_render(s, &d);
  double mean = 0;
  for (uint32_t i = 0; i < d.width * d.height; i++) mean += (double)d.pixels[3 * i] / (d.width * d.height);
  free(d.pixels);
  pktrt_scene_destroy(s);
  return mean;
}

/* Two small lights of each kind, from afar: the middles of WRT and the samples of DRT, of all lights or one, agree. */
static void each_kind_from_afar(void) {
  const quad lamp = quad_of(vec_of(0.1, 4, 0), vec_of(0.05, 0, 0), vec_of(0, 0, 0.05));
  const pktrt_material shine = lamp_of(4);
  for (int kind = 0; kind < PKTRT_LIGHT_KIND_COUNT; kind++) {
    pktrt_scene *s = patch_open(NULL);
    pktrt_light l = quad_light(&lamp, kind == PKTRT_LIGHT_MESH || kind == PKTRT_LIGHT_ENVIRONMENT ? 1 : 4);
    l.kind = (pktrt_light_kind)kind, l.direction[1] = -1, l.radius = 0.03f;
    l.mesh = stage_quad(s, &lamp, stage_material(s, &shine));
    if (kind != PKTRT_LIGHT_MESH) CHECK(pktrt_set_enabled(s, l.mesh, false) == PKTRT_OK);
    stage_light(s, &l);
    l.position[0] += 1;
    for (int k = 0; k < 3; k++) l.intensity[k] *= 0.5f;
    stage_light(s, &l);
    stage_commit(s);
    pktrt_render_desc d = patch_spot();
    d.background[0] = 0.5f, d.mode = PKTRT_MODE_WRT;
    const estimate want = stage_estimate(s, &d, 2);
    CHECK(want.mean[0] > 0, "the control: light %d gives light in WRT", kind);
    d.mode = PKTRT_MODE_DRT;
    for (int choice = PKTRT_LIGHTS_ALL; choice <= PKTRT_LIGHTS_ONE; choice++) {
      d.lights = (pktrt_light_choice)choice;
      const estimate is = stage_estimate(s, &d, 16);
      CHECK(fabs(is.mean[0] - want.mean[0]) < 4 * is.error[0] + 0.005 * want.mean[0],
          "light %d, choice %d: %g +- %g in DRT, %g in WRT; has it the right traits?", kind, choice, is.mean[0],
          is.error[0], want.mean[0]);
    }
    pktrt_scene_destroy(s);
  }
}

/* Squares of tiny and of huge lengths leave the range of floats: nothing may depend on them. */
static void scales(void) {
  static const double scale[] = {1e-24, 1e-20, 1e-10, 1e10, 1e15};
  static const pktrt_light_kind kinds[4] = {
      PKTRT_LIGHT_POINT, PKTRT_LIGHT_DIRECTIONAL, PKTRT_LIGHT_QUAD, PKTRT_LIGHT_SPHERE};
  double worst = 0;
  for (int j = 0; j < 4; j++) {
    for (int mode = PKTRT_MODE_WRT; mode <= PKTRT_MODE_DRT; mode++) {
      for (int pane = 0; pane < 2; pane++) {
        double want = scaled_pane(kinds[j], (pktrt_mode)mode, 1, pane, false);
        CHECK(want > 0.05, "the control: light %d does arrive, mode %d, %d panes: %g", j, mode, pane, want);
        for (size_t i = 0; i < COUNT(scale); i++) {
          double k = scale[i], got = scaled_pane(kinds[j], (pktrt_mode)mode, k, pane, false),
                 behind = scaled_pane(kinds[j], (pktrt_mode)mode, k, pane, true);
          CHECK(behind == 0, "light %d, mode %d, %d panes, scale %g: %g passes a wall", j, mode, pane, k, behind);
          if (kinds[j] == PKTRT_LIGHT_POINT && k < 1e-22) continue; /* its intensity is none but 0 as a float */
          CHECK(fabs(got - want) <= 1e-3 * want, "light %d, mode %d, %d panes, scale %g: %g, not %g", j, mode, pane, k,
              got, want);
          worst = fmax(worst, fabs(got / want - 1));
        }
      }
    }
  }
  say("scaled by 1e-24 to 1e15, brightness changes by at most %.2g", worst);
}

/* Several panes, and one that is opaque behind them. */
static void panes(void) {
  pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  pktrt_light l = light_of(PKTRT_LIGHT_DIRECTIONAL, PI);
  l.direction[1] = -1;
  double f = fresnel_exact(1, 1.5);
  for (int n = 0; n <= 6; n++) {
    pktrt_scene *s = patch_open(NULL);
    uint32_t material = stage_material(s, &glass);
    mesh box = mesh_box();
    mesh_place(&box, (float[3]){2, 0.05f, 2}, (float[3]){0, 0.5f, 0});
    for (int i = 0; i < n; i++) {
      stage_mesh(s, &box, material);
      mesh_shift(&box, 0, 0.25f, 0);
    }
    if (n == 6) stage_mesh(s, &box, 0);
    stage_light(s, &l);
    stage_commit(s);
    float got[3];
    pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, 1, 1, got, vec_of(-0.5, 0.2, 0), vec_of(0, 0, 0));
    stage_render(s, &d);
    double want = n == 6 ? 0 : albedo * pow(1 - f, 2 * n);
    CHECK(fabs((double)got[0] - want) < 2e-4, "%d panes: %g, not %g", n, (double)got[0], want);
    pktrt_scene_destroy(s);
    mesh_free(&box);
  }
}

/* Shadow rays that pass a pane next to its edge, or just miss it, far from the origin, where coordinates are coarse: whatever
   rounding makes of them, they arrive. */
static void edges_of_panes(void) {
  const float ulp = 0x1p-14f; /* of numbers from 512 to 1024 */
  size_t passed = 0, missed = 0;
  for (uint32_t i = 0; i < 512 * (uint32_t)isa_count; i++) {
    rng r = rng_of(i / (uint32_t)isa_count);
    const uint32_t a = rng_below(&r, 2) ? 2 : 0; /* x or z */
    const float place = 520 + (float)rng_below(&r, 0x700000) * ulp, aside = (float)rng_below(&r, 24) * ulp;
    const float half = rng_below(&r, 2) ? 1.5f : -1.5f, off = ((float)rng_below(&r, 3) - 1) * ulp;
    const float edge = place + (float)(0.5 * (double)aside) + off;
    const pktrt_scene_desc desc = scene_desc_of(isas[i % (uint32_t)isa_count], 0);
    pktrt_scene *s = pktrt_scene_create(&desc);
    pktrt_material diffuse = material_of(albedo, PKTRT_SPECULAR_NONE, 0),
                   glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
    pktrt_light l = light_of(PKTRT_LIGHT_POINT, 4 * PI);
    float floor[12] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1};
    float pane[12] = {-1.5f, 1, -1.5f, -1.5f, 1, 1.5f, 1.5f, 1, 1.5f, 1.5f, 1, -1.5f};
    mesh m = mesh_of(4, 2);
    memcpy(m.i, (uint32_t[6]){0, 1, 2, 0, 2, 3}, 24), memcpy(m.p, floor, sizeof floor);
    for (uint32_t v = 0; v < 4; v++) m.p[3 * v + a] += place, pane[3 * v + a] += edge + half;
    stage_mesh(s, &m, stage_material(s, &diffuse));
    memcpy(m.p, pane, sizeof pane);
    for (uint32_t v = 0; v < 4; v++) /* one side of it, to the last bit */
      if ((half > 0) == (pane[3 * v + a] < edge + half)) m.p[3 * v + a] = edge;
    stage_mesh(s, &m, stage_material(s, &glass));
    l.position[a] = place + aside, l.position[1] = 2;
    stage_light(s, &l);
    stage_commit(s);
    float got[2][3];
    vec eye = a ? vec_of(0, 0.5, (double)place) : vec_of((double)place, 0.5, 0);
    pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, 1, 1, got[0], eye, vec_sub(eye, vec_of(0, 0.5, 0)));
    d.camera.fov_y = 0.001f;
    stage_render(s, &d);
    d.pixels = got[1], d.glass_shadows = PKTRT_GLASS_SHADOWS_BLOCK;
    stage_render(s, &d);
    const bool hidden = got[1][0] <= 0;
    const double want = albedo * (hidden ? 0.96 : 1);
    passed += hidden, missed += !hidden;
    CHECK(fabs((double)got[0][0] / want - 1) < 2e-3, "%s, case %u: %g, not %g", pktrt_isa_string(desc.isa), i,
        (double)got[0][0], want);
    pktrt_scene_destroy(s);
    mesh_free(&m);
  }
  say("%zu rays pass a pane within two bits of its edge, %zu miss it", passed, missed);
  CHECK(passed > 50 && missed > 50, "the control: some do, some do not");
}

/* In Whitted's pictures shadow rays to a mesh end at the sphere around it, through its farthest corner, whichever comes first: what
   lies within shadows nothing, what lies before it does. */
static void shadows_end_at_the_sphere(void) {
  static const float corners[4][3] = {{0.7f, 3, 0}, {-0.7f, 3, 0}, {0, 3, 0.8f}, {0, 3, -0.8f}};
  static const uint32_t triangles[2][6] = {{0, 1, 2, 0, 3, 1}, {2, 0, 1, 3, 1, 0}};
  for (int order = 0; order < 2; order++) {
    double value[3];
    for (int wall = 0; wall < 3; wall++) { /* none, within the sphere, before it */
      pktrt_material lamp = lamp_of(5);
      pktrt_scene *s = patch_open(NULL);
      pktrt_mesh_desc d;
      pktrt_light l = light_of(PKTRT_LIGHT_MESH, 1);
      memset(&d, 0, sizeof d);
      d.positions = &corners[0][0], d.vertex_count = 4, d.indices = triangles[order], d.triangle_count = 2;
      d.material = stage_material(s, &lamp);
      CHECK(pktrt_add_mesh(s, &d, &l.mesh) == PKTRT_OK, "%s", pktrt_last_error(s));
      stage_light(s, &l);
      quad stop = quad_of(vec_of(0, wall == 1 ? 2.25 : 2.15, 0), vec_of(0.1, 0, 0), vec_of(0, 0, 0.1));
      if (wall) stage_quad(s, &stop, 0);
      stage_commit(s);
      value[wall] = patch_value(s, PKTRT_MODE_WRT);
      pktrt_scene_destroy(s);
    }
    CHECK(value[0] > 0.01 && value[1] == value[0] && value[2] == 0, "order %d: %g, %g within the sphere, %g before it",
        order, value[0], value[1], value[2]);
  }
}

/* Seen in a mirror, one light at random for all: the same mean, fewer rays, more noise. Where primary rays end, all. */
static void light_choice(void) {
  quad wall = quad_of(vec_of(3, 0, 0), vec_of(0, 0, 9), vec_of(0, 9, 0)); /* faces the mirror */
  pktrt_light l[3] = {
      light_of(PKTRT_LIGHT_POINT, 9), light_of(PKTRT_LIGHT_ENVIRONMENT, 1), sphere_light(vec_of(0, 3, 2), 0.5, 4)};
  vec_put(vec_of(-1, 3, 0), l[0].position);
  for (int mirrored = 0; mirrored < 2; mirrored++) {
    pktrt_material m = material_of(0.1, PKTRT_SPECULAR_MIRROR, mirrored ? 0.8 : 0);
    pktrt_scene *s = patch_open(&m);
    stage_quad(s, &wall, 0);
    for (int i = 0; i < 3; i++) stage_light(s, &l[i]);
    stage_commit(s);
    for (int mode = PKTRT_MODE_WRT; mode <= PKTRT_MODE_DRT; mode++) {
      estimate e[2];
      uint64_t deep[2], first[2];
      for (int one = 0; one < 2; one++) {
        pktrt_stats stats;
        memset(&stats, 0, sizeof stats);
        pktrt_render_desc d = patch_spot();
        d.mode = (pktrt_mode)mode, d.background[0] = 0.7f, d.stats = &stats, d.sampler = PKTRT_SAMPLER_RANDOM;
        d.lights = one ? PKTRT_LIGHTS_ONE_DEEPER : PKTRT_LIGHTS_ALL;
        e[one] = stage_estimate(s, &d, 16);
        deep[one] = stats.by_depth[2].rays, first[one] = stats.by_depth[1].rays;
      }
      bool chosen = mirrored && mode == PKTRT_MODE_DRT;
      CHECK(first[0] == first[1] && chosen == (deep[1] < deep[0]) && (chosen || deep[0] == deep[1]),
          "%d, mode %d: fewer rays only deeper", mirrored, mode);
      double error = sqrt(e[0].error[0] * e[0].error[0] + e[1].error[0] * e[1].error[0]),
             off = fabs(e[0].mean[0] - e[1].mean[0]);
      CHECK(chosen ? off <= 4 * error : off == 0, "%d, mode %d: %.5f, %.5f +- %.5f", mirrored, mode, e[0].mean[0],
          e[1].mean[0], error);
      if (chosen)
        CHECK(e[1].error[0] > e[0].error[0] && error < 0.02 * e[0].mean[0], "noisier, yet precise: %g, %g",
            e[0].error[0], e[1].error[0]);
    }
    pktrt_scene_destroy(s);
  }
}

/* CHECKs that one light for all has the mean of all lights, to 1%. */
static void check_one_as_all(const char *name, pktrt_scene *s, pktrt_render_desc d) {
  estimate e[2];
  for (int one = 0; one < 2; one++) {
    d.samples = small_run ? (one ? 64 : 16) : one ? 192 : 32;
    d.lights = one ? PKTRT_LIGHTS_ONE : PKTRT_LIGHTS_ALL;
    e[one] = stage_estimate(s, &d, 16);
  }
  const double error = sqrt(e[0].error[0] * e[0].error[0] + e[1].error[0] * e[1].error[0]);
  const double off = fabs(e[1].mean[0] - e[0].mean[0]);
  say("%s: all %.5f +- %.5f, one %.5f +- %.5f", name, e[0].mean[0], e[0].error[0], e[1].mean[0], e[1].error[0]);
  CHECK(off <= 4.5 * error + 1e-5, "%s: one %.6f, all %.6f, +- %.6f", name, e[1].mean[0], e[0].mean[0], error);
  if (!small_run) CHECK(error < 0.01 * e[0].mean[0], "%s: known to %.6f of %.6f only", name, error, e[0].mean[0]);
}

/* One for all everywhere: the mean of all, of lamps of all kinds, for a matt floor and lobes of an exponent. */
static void one_of_many_on(double gloss_exponent, int lamps, bool behind_glass) {
  rng r = rng_of(26);
  char name[80];
  pktrt_material m = material_of(albedo, PKTRT_SPECULAR_MIRROR, 0.3), lamp = lamp_of(3);
  quad shining = quad_of(vec_of(1, 1.6, -0.8), vec_of(0.9, 0, 0), vec_of(0, 0, 0.7));
  m.lobe = PKTRT_LOBE_PHONG, m.exponent = (float)gloss_exponent;
  pktrt_scene *s = patch_open(gloss_exponent > 0 ? &m : NULL);
  for (int i = 0; i < lamps; i++) {
    const vec at = vec_of(3 * (double)rng_sign(&r), 1.5 + (double)rng_sign(&r), 3 * (double)rng_sign(&r));
    quad q = quad_of(at, vec_of(0.2, 0, 0), vec_of(0, 0, 0.3));
    pktrt_light l = i % 3 == 0   ? light_of(PKTRT_LIGHT_POINT, 0.1 + 0.01 * (i % 60))
                    : i % 3 == 1 ? quad_light(&q, 2)
                                 : sphere_light(at, 0.1, 1);
    if (i % 3 == 0) vec_put(at, l.position);
    if (i == 9) l = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
    if (i == 30) l = light_of(PKTRT_LIGHT_MESH, 1), l.mesh = stage_quad(s, &shining, stage_material(s, &lamp));
    /* Two lamps in the same directions: lobes meet both. */
    if (i == 31) l = sphere_light(vec_of(1.5, 2, -0.5), 0.5, 2);
    if (i == 32) l = sphere_light(vec_of(3, 4, -1), 0.8, 2);
    stage_light(s, &l);
  }
  if (behind_glass) {
    const pktrt_material clear = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
    const uint32_t glass = stage_material(s, &clear);
    quad top = quad_of(vec_of(0, 0.45, 0), vec_of(0, 0, 3), vec_of(3, 0, 0));
    quad bottom = quad_of(vec_of(0, 0.4, 0), vec_of(3, 0, 0), vec_of(0, 0, 3));
    stage_quad(s, &top, glass), stage_quad(s, &bottom, glass);
  }
  stage_commit(s);
  pktrt_render_desc d = patch_spot();
  d.background[0] = 0.5f;
  snprintf(name, sizeof name, "one of %d, exponent %g%s", lamps, gloss_exponent, behind_glass ? ", behind glass" : "");
  check_one_as_all(name, s, d);
  pktrt_scene_destroy(s);
}

static void one_of_many(void) {
  one_of_many_on(0, 60, false);
  one_of_many_on(30, 60, false);
  one_of_many_on(1000, 60, false);
  one_of_many_on(100, 400, false);
  one_of_many_on(30, 20, false);
  one_of_many_on(100, 60, true);
}

/* Which of the lights without size is asked goes by the sample, not by who else is asked at the same time. */
static void one_of_points_anywhere(void) {
  enum { W = 48, H = 32 };
  static float pixels[4][W * H * 3];
  pktrt_material m = material_of(0.5, PKTRT_SPECULAR_MIRROR, 0.4);
  mesh ball = mesh_sphere(3, 0, 1);
  pktrt_scene *s = stage_open();
  stage_mesh(s, &ball, stage_material(s, &m));
  for (int i = 0; i < 3; i++) {
    pktrt_light l = light_of(PKTRT_LIGHT_POINT, 3 + 2 * i);
    vec_put(vec_of(2 - 2 * i, 2, 2), l.position);
    stage_light(s, &l);
  }
  stage_commit(s);
  for (int i = 0; i < 4; i++) {
    pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, W, H, pixels[i], vec_of(0.5, 1, 5), vec_of(0, 0, 0));
    d.samples = 2, d.lights = i == 3 ? PKTRT_LIGHTS_ALL : PKTRT_LIGHTS_ONE;
    d.tile_size = i == 1 ? 8 : 0, d.path = i == 2 ? PKTRT_PATH_SINGLE : PKTRT_PATH_FAST;
    stage_render(s, &d);
    if (i) CHECK(same_bits(pixels[i], pixels[0], sizeof pixels[0]) == (i < 3), "picture %d", i);
  }
  pktrt_scene_destroy(s);
  mesh_free(&ball);
}

/* Which light is asked does not go by the place on the lens: of a floor out of focus whose halves differ, under two lights of which
   one is hidden, the mean is that of both. */
static void one_of_points_behind_a_lens(void) {
  for (int turned = 0; turned < 4; turned++) {
    pktrt_scene *s = stage_open();
    const double along_x = turned % 2 ? 0 : 1; /* the halves lie along x, or along z */
    const double along_z = 1 - along_x;
    for (int side = -1; side < 2; side += 2) {
      const pktrt_material m = material_of(side < 0 ? 0.1 : 0.9, PKTRT_SPECULAR_NONE, 0);
      const vec middle = vec_of(2 * side * along_x, 0, 2 * side * along_z);
      quad half = quad_of(middle, vec_of(2 + 2 * along_z, 0, 0), vec_of(0, 0, 2 + 2 * along_x));
      stage_quad(s, &half, stage_material(s, &m));
      const vec at = vec_of(3 * side, 3, 0.5);
      pktrt_light l = light_of(PKTRT_LIGHT_POINT, 5);
      vec_put(at, l.position);
      stage_light(s, &l);
    }
    const double hidden = turned < 2 ? -1 : 1;
    quad wall = quad_of(vec_of(2.5 * hidden, 2.5, 0), vec_of(0, 1.5, 0), vec_of(0, 0, 2));
    stage_quad(s, &wall, 0);
    stage_commit(s);
    estimate e[2];
    for (int one = 0; one < 2; one++) {
      pktrt_render_desc d = patch_spot();
      vec_put(vec_of(0, 4, 0), d.camera.eye), vec_put(vec_of(0, 0, 0), d.camera.target);
      vec_put(vec_of(0, 0, 1), d.camera.up);
      d.camera.aperture = 1, d.camera.focus = 1.5f;
      d.samples = 256, d.lights = one ? PKTRT_LIGHTS_ONE : PKTRT_LIGHTS_ALL;
      e[one] = stage_estimate(s, &d, 16);
    }
    check_estimate("one of two behind a lens", &e[1], e[0].mean[0], e[0].mean[0] * 0.95, 0.02);
    CHECK(e[0].mean[0] > 0.01, "there is light: %g", e[0].mean[0]);
    pktrt_scene_destroy(s);
  }
}

/* One light for all, where lights have no size and nothing else is random: the mean is that of all lights. */
static void one_of_points(void) {
  for (int far_away = 0; far_away < 2; far_away++) {
    pktrt_scene *s = patch_open(NULL);
    for (int i = 0; i < 3; i++) {
      pktrt_light l = light_of(far_away ? PKTRT_LIGHT_DIRECTIONAL : PKTRT_LIGHT_POINT, 1 + 2 * i);
      if (far_away) vec_put(vec_of(0.3 * i, -1, 0.2), l.direction);
      else vec_put(vec_of(1 - i, 1.5 + 0.5 * i, 0.7), l.position);
      stage_light(s, &l);
    }
    stage_commit(s);
    estimate e[2];
    for (int one = 0; one < 2; one++) {
      pktrt_render_desc d = patch_spot();
      d.samples = one ? 1024 : 16;
      d.lights = one ? PKTRT_LIGHTS_ONE : PKTRT_LIGHTS_ALL;
      e[one] = stage_estimate(s, &d, 16);
    }
    check_estimate(
        far_away ? "one of three far away" : "one of three points", &e[1], e[0].mean[0], e[0].mean[0] * 0.95, 0.02);
    pktrt_scene_destroy(s);
  }
}

/* --- highlights, and each emitter counted once --- */

/* Integral of the lobe around `axis` over what a quad covers, seen from the origin; weighted by `power` of its own
   cosine. */
static double lobe_over_quad(const quad *q, vec axis, double exponent) {
  const int n = 600;
  vec area = vec_cross(q->edge[0], q->edge[1]);
  double sum = 0;
  for (int i = 0; i < n * n; i++) {
    vec p = quad_at(q, (i % n + 0.5) / n, (i / n + 0.5) / n);
    double d2 = vec_dot(p, p), c = vec_dot(p, axis) / sqrt(d2);
    if (c > 0 && p.y > 0) sum += pow(c, exponent) * fabs(vec_dot(area, p)) / (d2 * sqrt(d2));
  }
  return sum / (n * n) * (exponent + 1) / (2 * PI);
}

static const double gloss = 0.3, exponent = 15;

static pktrt_scene *glossy_open(double lobe) {
  pktrt_material m = material_of(albedo, PKTRT_SPECULAR_MIRROR, gloss);
  m.lobe = PKTRT_LOBE_PHONG, m.exponent = (float)lobe;
  return patch_open(&m);
}

static vec mirror_axis(void) { return vec_unit(vec_of(1.5, 2, -0.5)); }

/* A mesh that emits, one that is a light besides, a quad light alone: who sees what. */
static void counted_once(void) {
  quad lamp = quad_of(vec_of(1.2, 2, -0.6), vec_of(0.9, 0, 0), vec_of(0, 0, 0.7));
  double diffuse = albedo * quad_form_factor(vec_of(0, 0, 0), up, &lamp),
         specular = gloss * lobe_over_quad(&lamp, mirror_axis(), exponent);
  say("diffuse %.4f, specular %.4f; both twice would be %.4f", diffuse, specular, 2 * (diffuse + specular));
  for (int kind = 0; kind < 3; kind++) {
    pktrt_scene *s = glossy_open(exponent);
    pktrt_material m = lamp_of(2);
    pktrt_light l = kind == 2 ? quad_light(&lamp, 2) : light_of(PKTRT_LIGHT_MESH, 1);
    if (kind < 2) l.mesh = stage_quad(s, &lamp, stage_material(s, &m));
    if (kind > 0) stage_light(s, &l);
    stage_commit(s);
    for (int sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
      pktrt_render_desc d = patch_spot();
      d.sampler = (pktrt_sampler)sampler, d.samples = 64;
      estimate e = stage_estimate(s, &d, 16);
      double want = 2 * (kind == 0 ? specular : diffuse + specular);
      check_estimate(kind == 0   ? "emitting only"
                     : kind == 1 ? "emitting and a light"
                                 : "a light only",
          &e, want, kind == 0 ? want + 2 * diffuse : want + 2 * specular, 0.02);
      CHECK(small_run || (!agrees(&e, 0, want * 1.08) && !agrees(&e, 0, want * 0.92)), "the control: not by a twelfth");
    }
    pktrt_scene_destroy(s);
  }
}

/* Wide lobes and narrow ones get what they see of a light, however that is found; visible or not. */
static void both_ways(void) {
  static const double exponents[3] = {1, 60, 3000};
  quad lamp = quad_of(vec_of(1.2, 2, -0.8), vec_of(0.9, 0, 0), vec_of(0, 0, 0.7));
  for (int e = 0; e < 3; e++)
    for (int kind = 0; kind < 3; kind++) { /* a mesh, a quad, one that is visible */
      const double want = 2 * (albedo * quad_form_factor(vec_of(0, 0, 0), up, &lamp) +
                                  gloss * lobe_over_quad(&lamp, mirror_axis(), exponents[e]));
      pktrt_scene *s = glossy_open(exponents[e]);
      pktrt_material m = lamp_of(2);
      pktrt_light l = kind ? quad_light(&lamp, 2) : light_of(PKTRT_LIGHT_MESH, 1);
      if (kind == 0) l.mesh = stage_quad(s, &lamp, stage_material(s, &m));
      l.visible = kind == 2;
      stage_light(s, &l);
      stage_commit(s);
      pktrt_render_desc d = patch_spot();
      estimate got = stage_estimate(s, &d, 16);
      check_estimate("both ways", &got, want, want * 0.93, 0.02);
      pktrt_scene_destroy(s);
    }
}

/* What lobes see of a sun, by brute force. */
static void suns_in_lobes(void) {
  static const double exponents[] = {3, 300, 30000};
  const vec axis = mirror_axis();
  const vec to = vec_unit(vec_add(axis, vec_of(0.01, 0, -0.02)));
  const vec across = vec_unit(vec_cross(to, vec_of(0, 0, 1))), other = vec_cross(to, across);
  for (size_t e = 0; e < COUNT(exponents); e++)
    for (int seen = 0; seen < 2; seen++) {
      enum { STEPS = 400 };
      pktrt_light l = sun_light(to, 4);
      const double half = 4 * PI / 180, rise = 1 - cos(half);
      double lobe = 0;
      for (int i = 0; i < STEPS * STEPS; i++) {
        const double turn = 2 * PI * (i % STEPS + 0.5) / STEPS, cosine = 1 - rise * (i / STEPS + 0.5) / STEPS;
        const double sine = sqrt(1 - cosine * cosine);
        const vec aside = vec_add(vec_mul(across, sine * cos(turn)), vec_mul(other, sine * sin(turn)));
        const double along = fmax(0, vec_dot(vec_add(vec_mul(to, cosine), aside), axis));
        lobe += pow(along, exponents[e]) / (STEPS * STEPS);
      }
      const double radiance = 2 / (PI * sin(half) * sin(half));
      const double want = albedo * 2 * to.y / PI + gloss * radiance * rise * (exponents[e] + 1) * lobe;
      pktrt_scene *s = glossy_open(exponents[e]);
      l.visible = seen;
      stage_light(s, &l);
      stage_commit(s);
      for (int choice = 0; choice < 2; choice++) {
        pktrt_render_desc d = patch_spot();
        d.lights = choice ? PKTRT_LIGHTS_ONE : PKTRT_LIGHTS_ALL;
        estimate got = stage_estimate(s, &d, 16);
        check_estimate("a sun in a lobe", &got, want, want * 0.95, 0.02);
      }
      pktrt_scene_destroy(s);
    }
}

/* A quad and a sphere that are visible: from before, not from behind; in a mirror; not behind what hides them. */
static void visible_lights(void) {
  quad lamp = quad_of(vec_of(-1, 3, -1), vec_of(2, 0, 0), vec_of(0, 0, 2)),
       lid = quad_of(vec_of(-2, 2.5, -2), vec_of(4, 0, 0), vec_of(0, 0, 4));
  for (int kind = 0; kind < 8; kind++) { /* bits: a sphere; visible; a lid before it */
    pktrt_scene *s = patch_open(NULL);
    pktrt_light l = kind & 1 ? sphere_light(vec_of(0, 4, 0), 1, 2) : quad_light(&lamp, 2);
    l.visible = (kind & 2) != 0;
    stage_light(s, &l);
    if (kind & 4) stage_quad(s, &lid, 0);
    stage_commit(s);
    for (int mode = 0; mode < 3; mode++) {
      float below[3], above[3];
      pktrt_render_desc d = stage_view((pktrt_mode)mode, 1, 1, below, vec_of(0.2, 1, 0.1), vec_of(0.2, 3, 0.1));
      d.camera.up[2] = 1, d.camera.fov_y = 1, d.samples = 1;
      stage_render(s, &d);
      const bool seen = (kind & 2) && !(kind & 4);
      CHECK((below[0] == 2) == seen, "kind %d, mode %d: from below %g", kind, mode, (double)below[0]);
      d = stage_view((pktrt_mode)mode, 1, 1, above, vec_of(0.2, 9, 0.1), vec_of(0.2, 3, 0.1));
      d.camera.up[2] = 1, d.camera.fov_y = 1, d.samples = 1;
      stage_render(s, &d);
      CHECK((above[0] == 2) == (kind % 4 == 3), "kind %d, mode %d: from above %g", kind, mode, (double)above[0]);
    }
    pktrt_scene_destroy(s);
  }
}

/* The environment as a light and seen by the lobe. */
static void environment_once(void) {
  pktrt_scene *s = glossy_open(2);
  pktrt_light l = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
  stage_light(s, &l);
  stage_commit(s);
  pktrt_render_desc d = patch_spot();
  d.background[0] = 1;
  estimate e = stage_estimate(s, &d, 16);
  double above = lobe_moment(2, acos(mirror_axis().y), 0);
  double want = albedo + gloss * above;
  check_estimate("environment", &e, want, want + gloss, 0.01);
  pktrt_scene_destroy(s);
}

/* Lights without geometry show in lobes by value; points and directions the same in WRT. */
static void highlights(void) {
  vec axis = mirror_axis();
  double density = (exponent + 1) / (2 * PI);
  for (int kind = 0; kind < 3; kind++) {
    vec to = vec_of(1.2, 2, -0.6), way = vec_unit(to);
    double lobe = density * pow(vec_dot(way, axis), exponent), d2 = vec_dot(to, to), diffuse, specular;
    pktrt_light l = light_of((pktrt_light_kind)kind, 2);
    if (kind == PKTRT_LIGHT_POINT)
      vec_put(to, l.position), diffuse = albedo * 2 * way.y / (PI * d2), specular = gloss * lobe * 2 / d2;
    else if (kind == PKTRT_LIGHT_DIRECTIONAL)
      vec_put(vec_mul(to, -3), l.direction), diffuse = albedo * 2 * way.y / PI, specular = gloss * lobe * 2;
    else l = sphere_light(to, 0.001, 1e6), diffuse = albedo / d2 * way.y, specular = gloss * lobe * PI / d2;
    pktrt_scene *s = glossy_open(exponent);
    stage_light(s, &l);
    stage_commit(s);
    double want = diffuse + specular;
    for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_WRT; mode++) {
      double got = patch_value(s, (pktrt_mode)mode), right = mode == PKTRT_MODE_RCS ? diffuse : want;
      CHECK(fabs(got - right) < 1e-4 * right, "light %d, mode %d: %g, not %g", kind, mode, got, right);
    }
    pktrt_render_desc d = patch_spot();
    estimate e = stage_estimate(s, &d, 16);
    check_estimate("highlight", &e, want, diffuse, 0.01);
    CHECK(
        e.error[0] < 2e-3 * want && fabs(e.mean[0] - want) < 3e-3 * want, "kind %d: %g, not %g", kind, e.mean[0], want);
    pktrt_scene_destroy(s);
  }
}

/* Ideal mirrors and the camera do not see lights without geometry. */
static void unseen(void) {
  quad lamp = quad_of(vec_of(1.5, 2, -0.5), vec_of(0.9, 0, 0), vec_of(0, 0, 0.7));
  for (int kind = 0; kind < 2; kind++) {
    pktrt_material m = material_of(0, PKTRT_SPECULAR_MIRROR, 1), emitting = lamp_of(2);
    pktrt_scene *s = patch_open(&m);
    pktrt_light l = kind ? quad_light(&lamp, 2) : light_of(PKTRT_LIGHT_MESH, 1);
    if (!kind) l.mesh = stage_quad(s, &lamp, stage_material(s, &emitting));
    stage_light(s, &l);
    stage_commit(s);
    for (int mode = PKTRT_MODE_WRT; mode <= PKTRT_MODE_DRT; mode++) {
      float got[3];
      double in_mirror = patch_value(s, (pktrt_mode)mode);
      pktrt_render_desc d = stage_view((pktrt_mode)mode, 1, 1, got, vec_of(0, 0.5, 0), vec_of(1.5, 2, -0.5));
      d.camera.fov_y = 1;
      stage_render(s, &d);
      CHECK(in_mirror == (kind ? 0 : 2) && got[0] == (kind ? 0.f : 2.f), "kind %d, mode %d: %g, %g", kind, mode,
          in_mirror, (double)got[0]);
    }
    pktrt_scene_destroy(s);
  }
}

/* A triangle that is flat at both keys, with area between: the same motion with a third key half-way gives the same light. */
static void lamps_between_keys(void) {
  static const float keys[3][9] = {
      {0, 2, 0, 0, 2, 0, 0, 2, 2}, {0, 2, 0, 1, 2, 0, 0, 2, 1}, {0, 2, 0, 2, 2, 0, 0, 2, 0}};
  estimate e[3];
  for (int k = 0; k < 3; k++) { /* 2: the control, flat throughout */
    float p[27];
    memcpy(p, keys, sizeof p);
    if (k != 1) memcpy(p + 9, keys[k ? 0 : 2], sizeof keys[0]);
    pktrt_scene *s = patch_open(NULL);
    pktrt_material lamp = lamp_of(20);
    pktrt_mesh_desc d;
    pktrt_light l = light_of(PKTRT_LIGHT_MESH, 1);
    memset(&d, 0, sizeof d);
    d.positions = p, d.vertex_count = 3, d.triangle_count = 1, d.key_count = k == 1 ? 3 : 2,
    d.material = stage_material(s, &lamp);
    CHECK(pktrt_add_mesh(s, &d, &l.mesh) == PKTRT_OK, "%s", pktrt_last_error(s));
    stage_light(s, &l);
    stage_commit(s);
    pktrt_render_desc view = patch_spot();
    view.camera.shutter = 1;
    e[k] = stage_estimate(s, &view, 16);
    pktrt_scene_destroy(s);
  }
  say("%.4f with two keys, %.4f with three, %.4f of nothing", e[0].mean[0], e[1].mean[0], e[2].mean[0]);
  CHECK(fabs(e[0].mean[0] - e[1].mean[0]) < 4 * (e[0].error[0] + e[1].error[0]), "%g, not %g", e[0].mean[0],
      e[1].mean[0]);
  CHECK(e[0].mean[0] > 0.05 && e[2].mean[0] <= 0, "the controls");
}

/* A lamp that has no area at its first key is chosen among others all the same. */
static void lamps_without_area_at_first(void) {
  static const float positions[18] = {0, 2, 0, 0, 2, 0, 0, 2, 2, 0, 2, 0, 1, 2, 0, 0, 2, 2};
  estimate e[3];
  for (int k = 0; k < 3; k++) { /* all lights, one chosen, and the control: the other light alone */
    pktrt_scene *s = patch_open(NULL);
    pktrt_material lamp = lamp_of(20);
    pktrt_mesh_desc d;
    pktrt_light shape = light_of(PKTRT_LIGHT_MESH, 1), other = light_of(PKTRT_LIGHT_SPHERE, 1);
    memset(&d, 0, sizeof d);
    d.positions = positions;
    d.vertex_count = 3;
    d.triangle_count = 1;
    d.key_count = 2;
    d.material = stage_material(s, &lamp);
    other.position[1] = 3;
    other.radius = 0.5f;
    CHECK(pktrt_add_mesh(s, &d, &shape.mesh) == PKTRT_OK, "%s", pktrt_last_error(s));
    if (k < 2) stage_light(s, &shape);
    stage_light(s, &other);
    stage_commit(s);
    pktrt_render_desc view = patch_spot();
    view.camera.shutter = 1;
    view.lights = k == 1 ? PKTRT_LIGHTS_ONE : PKTRT_LIGHTS_ALL;
    e[k] = stage_estimate(s, &view, 16);
    pktrt_scene_destroy(s);
  }
  say("%.4f of both, %.4f of one chosen, %.4f of the other alone", e[0].mean[0], e[1].mean[0], e[2].mean[0]);
  CHECK(fabs(e[0].mean[0] - e[1].mean[0]) < 4 * (e[0].error[0] + e[1].error[0]), "%g, not %g", e[1].mean[0],
      e[0].mean[0]);
  CHECK(e[0].mean[0] - e[2].mean[0] > 8 * (e[0].error[0] + e[1].error[0]), "the control");
}

/* In RCS and WRT a mesh light reaches as far as a sphere around it; in DRT its triangles are sorted in a box around it. */
static void lamps_with_strays(void) {
  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++) {
    double value[2];
    for (int with = 0; with < 2; with++) {
      const float p[15] = {0, 2, 0, 1, 2, 0, 1, 2, 1, 0, 2, 1, 900, 800, 100};
      const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
      pktrt_scene *s = patch_open(NULL);
      pktrt_material lamp = lamp_of(5);
      pktrt_light l = light_of(PKTRT_LIGHT_MESH, 1);
      pktrt_mesh_desc d;
      quad roof = quad_of(vec_of(0, 1, 0), vec_of(0, 0, 1), vec_of(1, 0, 0)); /* between: all is in its shadow */
      memset(&d, 0, sizeof d);
      d.positions = p, d.vertex_count = 4 + (uint32_t)with, d.indices = corners, d.triangle_count = 2;
      d.material = stage_material(s, &lamp);
      CHECK(pktrt_add_mesh(s, &d, &l.mesh) == PKTRT_OK, "%s", pktrt_last_error(s));
      stage_quad(s, &roof, 0), stage_light(s, &l);
      stage_commit(s);
      float got[3];
      pktrt_render_desc view = stage_view((pktrt_mode)mode, 1, 1, got, vec_of(-0.5, 0.4, 0), vec_of(0, 0, 0));
      stage_render(s, &view);
      value[with] = (double)got[0];
      pktrt_scene_destroy(s);
    }
    CHECK(value[0] <= 0 && value[1] <= 0, "mode %d: light through a roof: %g, with a stray vertex %g", mode, value[0],
        value[1]);
  }
}

void suite_lights(void) {
  run("a quad light gives its form factor, by every sampler", quad_lights);
  run("a sphere light gives pi L (R / d)^2 cos", sphere_lights);
  run("a light next to a surface gives what it gives, to a distance of 1/10000 of its size", near_lights);
  run("within a sphere that is a light all is lit", within_a_sphere);
  run("RCS and WRT take a quad light in its middle", middles);
  run("an emissive mesh is a light like the quad of the same shape, and is seen", mesh_lights);
  run("a moving mesh shines that has area between its keys only", lamps_between_keys);
  run("a lamp without area at its first key is chosen among others", lamps_without_area_at_first);
  run("a vertex that no triangle uses changes nothing of a mesh light", lamps_with_strays);
  run("RCS and WRT get light from a mesh", far_mesh_light);
  run("a tilted mesh light does not shadow itself at any distance", lamps_at_distances);
  run("a lamp that moves while the shutter is open gives the mean of its form factors", moving_lamp);
  run("a globe of triangles hides half of itself, and few shadow rays go there", globes);
  run("triangles of a lamp that hide among others which look away are asked, too", pairs_that_look_away);
  run("an environment lights what it sees, without noise where nothing is in the way", environments);
  run("an environment callback lights by direction", environment_callbacks);
  run("a sun in a callback is found, however small", suns);
  run("a directional light with an angle gives its irradiance times the cosine; RCS and WRT take its middle",
      sun_lights);
  run("angles of directional lights that mean nothing are refused by name", angles_of_suns);
  run("a sun as wide as that of the Earth is found wherever it is, a smaller one among pixels", placed_suns);
  run("lights add up", light_sums);
  run("one light chosen for all everywhere has the mean of all, of many kinds", one_of_many);
  run("one light chosen of those without size has the mean of all", one_of_points);
  run("which light is chosen does not go by the place on the lens", one_of_points_behind_a_lens);
  run("one light chosen of those without size is the same in all tiles and paths", one_of_points_anywhere);
  run("shadow rays to a mesh end at the sphere through its farthest corner", shadows_end_at_the_sphere);
  run("one light chosen for all has the mean of all, deeper in the ray tree", light_choice);
  run("a screen takes its part of an area light", penumbra);
  run("shadow rays pass glass with Fresnel and Beer's law, or not at all", glass_shadows);
  run("shadow rays pass several panes", panes);
  run("shadow rays pass panes next to their edges", edges_of_panes);
  run("the length of a light's direction means nothing, bit for bit", direction_lengths);
  run("a small light of any kind gives from afar the same in all modes", each_kind_from_afar);
  run("no scale lets light through a wall or changes its brightness", scales);
  run("an emitter that is a light is counted once", counted_once);
  run("lobes wide and narrow get what they see of a light, found in both ways", both_ways);
  run("quads and spheres are seen if they are visible", visible_lights);
  run("lobes get what they see of a sun", suns_in_lobes);
  run("camera and mirrors see a sun if it is visible", visible_suns);
  run("the environment is counted once", environment_once);
  run("lights show in Phong lobes by the value of the lobe", highlights);
  run("the camera and ideal mirrors see emitting meshes, not lights", unseen);
}
