/* Thin sheets, and surfaces that blend. What the renderer says stands beside closed forms, beside scenes without the sheet, and
   beside itself by other paths. */
#include "pictures.h"

enum { SIDE = 24, VALUES = SIDE * SIDE * 3 };

static pktrt_material thin_of(double albedo, double ior, double transmission) {
  pktrt_material m = material_of(albedo, PKTRT_SPECULAR_THIN, 0);
  m.ior[0] = (float)ior, m.transmission = (float)transmission;
  return m;
}

static pktrt_material blend_of(double emission, double transparency) {
  pktrt_material m = lamp_of(emission);
  m.blend = true, m.transparency = (float)transparency;
  return m;
}

/* Returns what both faces of a sheet reflect. */
static double plate_reflects(double cosine, double ior) {
  const double r = fresnel_exact(cosine, ior);
  return 2 * r / (1 + r);
}

/* Radiance from above, 2, 3, 4 by channel, and below the plane y = 0, 5, 7, 9. */
static const double above[3] = {2, 3, 4}, below[3] = {5, 7, 9};
static void two_skies(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (int a = 0; a < 3; a++)
    for (uint32_t i = 0; i < n; i++) radiance[a][i] = (float)(direction[1][i] > 0 ? above[a] : below[a]);
}

/* A description of one pixel that looks at the origin, at an angle in degrees to the y axis. */
static pktrt_render_desc look_at_origin(pktrt_mode mode, double angle, bool from_below, float pixel[3]) {
  const double turn = angle * PI / 180;
  const vec eye = vec_of(3 * sin(turn), from_below ? -3 * cos(turn) : 3 * cos(turn), 0.01);
  pktrt_render_desc d = stage_view(mode, 1, 1, pixel, eye, vec_of(0, 0, 0));
  d.environment = two_skies, d.camera.fov_y = 0.01f;
  return d;
}

static bool near_to(double got, double want) { return fabs(got - want) <= 2e-5 * fabs(want); }

/* --- thin sheets --- */

/* One sheet between two skies: what it reflects, lets through and scatters, for angles, indices, shares, tints, from both sides. */
static void sheets_in_closed_form(void) {
  static const double angles[] = {0, 30, 60, 80, 88}, iors[] = {1, 1.33, 1.5, 2.4, 0.7};
  static const double shares[] = {1, 0.6, 0.01}, tints[] = {0, 0.5};
  int compared = 0;
  for (size_t i = 0; i < COUNT(angles) * COUNT(iors) * COUNT(shares) * COUNT(tints) * 2; i++) {
    const double angle = angles[i % 5], ior = iors[i / 5 % 5], share = shares[i / 25 % 3], tint = tints[i / 75 % 2];
    const bool from_below = i / 150;
    float pixel[3];
    pktrt_scene *s = stage_open();
    const quad sheet = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 9), vec_of(9, 0, 0));
    pktrt_material m = thin_of(0.8, ior, share < 1 ? share : from_below);
    m.albedo[1] = 0.3f, m.reflectance[0] = m.reflectance[1] = m.reflectance[2] = (float)tint;
    stage_quad(s, &sheet, stage_material(s, &m));
    stage_commit(s);
    pktrt_render_desc d = look_at_origin(PKTRT_MODE_WRT, angle, from_below, pixel);
    for (int a = 0; a < 3; a++) d.ambient[a] = 0.25f;
    stage_render(s, &d);
    const vec eye = vec_from(d.camera.eye);
    const double reflects = plate_reflects(fabs(eye.y) / vec_length(eye), (double)m.ior[0]);
    for (int a = 0; a < 3; a++) {
      const double albedo = (double)m.albedo[a], passed = (1 - reflects) * albedo;
      const double mirrored = (tint > 0 ? tint : 1) * reflects * (from_below ? below : above)[a];
      const double straight = passed * share * (from_below ? above : below)[a];
      const double want = mirrored + straight + passed * (1 - share) * 0.25;
      CHECK(fabs((double)pixel[a] - want) < 2e-4 * want, "case %zu, channel %d: %g, not %g", i, a, (double)pixel[a],
          want);
      compared++;
    }
    pktrt_scene_destroy(s);
  }
  CHECK(compared == 900, "%d", compared);
}

/* Shines as its place tells. */
static void shines_by_place(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++)
    p->emission[0][i] = 3 + p->position[0][i], p->emission[1][i] = 3 + p->position[2][i];
}

/* A sheet does not bend rays, whatever its index: what is seen behind it stands where it stands. */
static void sheets_do_not_bend(void) {
  for (int i = 0; i < 12; i++) {
    const double angle = 15 * (i % 6);
    float pixel[3];
    pktrt_scene *s = stage_open();
    pktrt_material m = thin_of(1, 1.9, 0), ground = lamp_of(1);
    const quad sheet = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 1), vec_of(1, 0, 0)),
               floor = quad_of(vec_of(0, -0.5, 0), vec_of(0, 0, 4), vec_of(4, 0, 0));
    ground.texture = shines_by_place;
    stage_quad(s, &sheet, stage_material(s, &m));
    stage_quad(s, &floor, stage_material(s, &ground));
    stage_commit(s);
    pktrt_render_desc d = look_at_origin(PKTRT_MODE_WRT, angle, false, pixel);
    d.camera.eye[2] = i / 6 ? 1.5f : 0;
    stage_render(s, &d);
    const vec eye = vec_from(d.camera.eye), at = vec_mul(eye, -0.5 / eye.y);
    const double reflects = plate_reflects(eye.y / vec_length(eye), (double)m.ior[0]);
    const double want[2] = {3 + at.x, 3 + at.z};
    for (int a = 0; a < 2; a++) {
      const double seen = reflects * above[a] + (1 - reflects) * want[a];
      CHECK(fabs((double)pixel[a] - seen) < 1e-3, "case %d: %g, not %g", i, (double)pixel[a], seen);
    }
    pktrt_scene_destroy(s);
  }
}

/* Where one way is chosen at a sheet, and in DRT, means are the same. */
static void sheets_by_chance(void) {
  static const double shares[] = {1, 0.6};
  for (int i = 0; i < 12; i++) {
    const double share = shares[i % 2];
    pktrt_scene *s = stage_open();
    const quad sheet = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 9), vec_of(9, 0, 0));
    pktrt_material m = thin_of(0.8, 1.7, share);
    m.reflectance[0] = m.reflectance[1] = m.reflectance[2] = i / 2 % 2 ? 0.75f : 0;
    stage_quad(s, &sheet, stage_material(s, &m));
    stage_commit(s);
    pktrt_render_desc d = look_at_origin(PKTRT_MODE_DRT, 70, false, NULL);
    d.width = d.height = 4, d.samples = 64;
    d.branching = i / 4 == 0 ? PKTRT_BRANCHING_BY_MODE : i / 4 == 1 ? PKTRT_BRANCHING_CHOOSE : PKTRT_BRANCHING_FIRST;
    for (int a = 0; a < 3; a++) d.ambient[a] = 0.25f;
    const estimate e = stage_estimate(s, &d, 32);
    const vec eye = vec_from(d.camera.eye);
    const double reflects = plate_reflects(fabs(eye.y) / vec_length(eye), (double)m.ior[0]);
    const double passed = (1 - reflects) * (double)m.albedo[0];
    const double mirrored = reflects * above[0] * (i / 2 % 2 ? 0.75 : 1);
    const double want = mirrored + passed * share * below[0] + passed * (1 - share) * 0.25;
    CHECK(fabs(e.mean[0] - want) < 4 * e.error[0] + 1e-4 * want, "case %d: %g +- %g, not %g", i, e.mean[0], e.error[0],
        want);
    pktrt_scene_destroy(s);
  }
}

/* Sheets above each other: those that reflect nothing multiply their tints; two that do reflect to and fro. */
static void stacks_of_sheets(void) {
  for (int n = 1; n <= 40; n += 13) {
    float pixel[3];
    pktrt_scene *s = stage_open();
    pktrt_material m = thin_of(0.95, 1, 0);
    const uint32_t material = stage_material(s, &m);
    for (int i = 0; i < n; i++) {
      const quad sheet = quad_of(vec_of(0, -0.02 * i, 0), vec_of(0, 0, 9), vec_of(9, 0, 0));
      stage_quad(s, &sheet, material);
    }
    stage_commit(s);
    const pktrt_render_desc d = look_at_origin(PKTRT_MODE_WRT, 20, n % 2, pixel);
    stage_render(s, &d);
    const double want = pow((double)m.albedo[0], n) * (n % 2 ? above : below)[0];
    CHECK(near_to((double)pixel[0], want), "%d sheets: %g, not %g", n, (double)pixel[0], want);
    pktrt_scene_destroy(s);
  }

  float pixel[3];
  pktrt_scene *s = stage_open();
  pktrt_material m = thin_of(1, 1.5, 0);
  const quad upper = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 99), vec_of(99, 0, 0)),
             lower = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 99), vec_of(99, 0, 0));
  stage_quad(s, &upper, stage_material(s, &m));
  stage_quad(s, &lower, stage_material(s, &m));
  stage_commit(s);
  const pktrt_render_desc d = look_at_origin(PKTRT_MODE_WRT, 0.2, false, pixel);
  stage_render(s, &d);
  const double r = plate_reflects(1, 1.5), t = (1 - r) * (1 - r) / (1 - r * r),
               back = r + (1 - r) * (1 - r) * r / (1 - r * r);
  const double want = back * above[0] + t * below[0];
  CHECK(near_to((double)pixel[0], want), "two sheets: %g, not %g", (double)pixel[0], want);
  pktrt_scene_destroy(s);
}

/* A room: a floor, a ball, a lamp of a mesh. A sheet, or a box of sheets, stands between it and the camera, and hangs between
   it and the lamp. */
typedef struct room {
  const pktrt_material *sheet; /* NULL: there is none */
  const pktrt_material *ball;  /* NULL: matt */
  int light;                   /* its kind */
  pktrt_lobe lobe;             /* of the floor */
  bool body;
} room;

static pktrt_scene *room_open(const room *r) {
  pktrt_scene *s = stage_open();
  pktrt_material floor = material_of(0.4, PKTRT_SPECULAR_MIRROR, 0.4), shine = lamp_of(3);
  const pktrt_material matt = material_of(0.7, PKTRT_SPECULAR_NONE, 0);
  mesh ball = mesh_sphere(2, 0, 9), box = mesh_box();
  const quad ground = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 3), vec_of(3, 0, 0)),
             lamp = quad_of(vec_of(0.2, 2, 0), vec_of(0.4, 0, 0), vec_of(0, 0, 0.4)),
             pane = quad_of(vec_of(0, 0, 2.2), vec_of(3, 0, 0), vec_of(0, 3, 0)),
             roof = quad_of(vec_of(0, 1.4, 0), vec_of(0, 0, 3), vec_of(3, 0.2, 0));
  floor.lobe = r->lobe, floor.exponent = 40;
  mesh_scale(&ball, 0.8f);
  stage_quad(s, &ground, stage_material(s, &floor));
  const uint32_t lit = stage_quad(s, &lamp, r->light == PKTRT_LIGHT_MESH ? stage_material(s, &shine) : 0);
  stage_mesh(s, &ball, stage_material(s, r->ball ? r->ball : &matt));
  if (r->light != PKTRT_LIGHT_MESH) CHECK(pktrt_set_enabled(s, lit, false) == PKTRT_OK, "%s", pktrt_last_error(s));
  if (r->sheet) {
    const uint32_t sheet = stage_material(s, r->sheet);
    stage_quad(s, &pane, sheet);
    stage_quad(s, &roof, sheet);
    mesh_place(&box, (float[3]){1.1f, 0.99f, 1.1f}, (float[3]){0, 0.005f, 0});
    if (r->body) stage_mesh(s, &box, sheet);
  }
  pktrt_light l =
      light_of((pktrt_light_kind)r->light, r->light == PKTRT_LIGHT_MESH || r->light == PKTRT_LIGHT_ENVIRONMENT ? 1 : 4);
  l.position[0] = 0.4f, l.position[1] = 2, l.position[2] = 0.5f;
  l.direction[0] = -0.4f, l.direction[1] = -1;
  l.edge[0][0] = 0.8f, l.edge[1][2] = 0.9f, l.radius = 0.3f;
  l.mesh = lit, l.visible = true;
  stage_light(s, &l);
  stage_commit(s);
  mesh_free(&ball);
  mesh_free(&box);
  return s;
}

static pktrt_render_desc room_view(pktrt_mode mode, float *pixels) {
  pktrt_render_desc d = stage_view(mode, SIDE, SIDE, pixels, vec_of(0, 0.6, 4), vec_of(0, -0.2, 0));
  d.environment = two_skies, d.attenuation = 0;
  return d;
}

/* Adds up by how much two pictures differ, pixels at outlines left out, where a rounding decides what is seen: of 3 values in
   100 the largest. */
static int larger_first(const void *a, const void *b) {
  const double x = *(const double *)a, y = *(const double *)b;
  return x < y ? 1 : x > y ? -1 : 0;
}
static double farthest(const float *p, const float *q) {
  double differ[VALUES];
  for (int i = 0; i < VALUES; i++) differ[i] = fabs((double)p[i] - (double)q[i]) / (0.01 + fabs((double)q[i]));
  qsort(differ, VALUES, sizeof *differ, larger_first);
  return differ[VALUES / 300];
}

/* A white sheet of index 1 reflects nothing and takes nothing: the picture is that without it, but for the rounding of where rays
   go on. One that differs in any way is seen. */
static void sheets_that_are_not_there(void) {
  static float want[VALUES], got[VALUES];
  pktrt_material clear = thin_of(1, 1, 0), glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  size_t seen = 0, cases = 0;
  double worst = 0;
  glass.ior[0] = 1.4f, glass.absorption[1] = 0.6f;
  for (int i = 0; i < PKTRT_LIGHT_KIND_COUNT * 8; i++, cases++) {
    room r = {NULL, i / 8 % 2 ? &glass : NULL, i / 8, (pktrt_lobe)(i / 2 % 2), i / 4 % 2};
    pktrt_scene *without = room_open(&r);
    r.sheet = &clear;
    pktrt_scene *with = room_open(&r);
    pktrt_render_desc d = room_view(i % 2 ? PKTRT_MODE_DRT : PKTRT_MODE_WRT, want);
    if (d.mode == PKTRT_MODE_WRT) {
      stage_render(without, &d);
      d.pixels = got;
      stage_render(with, &d);
      worst = fmax(worst, farthest(got, want));
      CHECK(farthest(got, want) < 1e-4, "case %d: %g", i, farthest(got, want));
    } else {
      d.samples = 4;
      const estimate e = stage_estimate(without, &d, 10), f = stage_estimate(with, &d, 10);
      for (int a = 0; a < 3; a++) {
        const double error = sqrt(e.error[a] * e.error[a] + f.error[a] * f.error[a]);
        CHECK(
            fabs(e.mean[a] - f.mean[a]) < 4 * error + 1e-5, "case %d: %g and %g +- %g", i, e.mean[a], f.mean[a], error);
      }
    }
    pktrt_scene_destroy(with);
    clear.albedo[1] = 0.9f;
    with = room_open(&r);
    clear.albedo[1] = 1;
    d.pixels = got;
    stage_render(with, &d);
    d.pixels = want;
    stage_render(without, &d);
    seen += farthest(got, want) > 0.02;
    pktrt_scene_destroy(with), pktrt_scene_destroy(without);
  }
  CHECK(seen == cases, "the control: %zu of %zu", seen, cases);
  say("%zu pictures; in WRT values are off by %.1e at most, outlines apart", cases, worst);
}

/* A sheet in glass that absorbs: rays and shadow rays stay in the glass behind it. */
static void sheets_within_glass(void) {
  for (int inside = 0; inside < 2; inside++) {
    float pixel[3];
    pktrt_scene *s = stage_open();
    pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0), sheet = thin_of(0.7, 1.5, 0.5);
    const pktrt_material ground = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
    mesh slab = mesh_box();
    const quad middle = quad_of(vec_of(0, inside ? 1 : 2.5, 0), vec_of(0, 0, 2), vec_of(2, 0, 0)),
               floor = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 9), vec_of(9, 0, 0));
    mesh_place(&slab, (float[3]){3, 0.75f, 3}, (float[3]){0, 1, 0});
    glass.ior[0] = 1, glass.absorption[0] = 0.5f, glass.absorption[2] = 1;
    sheet.ior[0] = 1;
    stage_mesh(s, &slab, stage_material(s, &glass));
    stage_quad(s, &middle, stage_material(s, &sheet));
    stage_quad(s, &floor, stage_material(s, &ground));
    pktrt_light l = light_of(PKTRT_LIGHT_DIRECTIONAL, 3);
    vec_put(vec_of(0, -1, 0), l.direction);
    stage_light(s, &l);
    stage_commit(s);
    mesh_free(&slab);
    pktrt_render_desc d = look_at_origin(PKTRT_MODE_WRT, 0, false, pixel);
    d.camera.eye[1] = 9;
    stage_render(s, &d);
    for (int a = 0; a < 3; a++) {
      const double through = exp(-1.5 * (double)glass.absorption[a]) * 0.5 * 0.7;
      const double scattered = 0.5 * 0.7 * 3 / PI * exp(-(inside ? 2 * 0.75 : 0) * (double)glass.absorption[a]);
      const double want = 0.5 * 3 / PI * through * through + scattered;
      CHECK(fabs((double)pixel[a] - want) < 1e-3 * want, "inside %d, channel %d: %g, not %g", inside, a,
          (double)pixel[a], want);
    }
    pktrt_scene_destroy(s);
  }
}

/* A lamp in glass, above a sheet in there: the glass below the sheet dims its light. A camera in a closed body of sheets is in no
   glass, whatever else their material has. */
static void sheets_are_no_glass(void) {
  float pixel[3];
  for (int there = 0; there < 2; there++) {
    pktrt_scene *s = stage_open();
    pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0), sheet = thin_of(1, 1, 0);
    const pktrt_material ground = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
    mesh slab = mesh_box();
    const quad middle = quad_of(vec_of(0, 1, 0), vec_of(0, 0, 2), vec_of(2, 0, 0)),
               floor = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 9), vec_of(9, 0, 0));
    mesh_place(&slab, (float[3]){3, 2, 3}, (float[3]){0, 2, 0});
    glass.ior[0] = 1, glass.absorption[0] = 0.5f;
    stage_mesh(s, &slab, stage_material(s, &glass));
    if (there) stage_quad(s, &middle, stage_material(s, &sheet));
    stage_quad(s, &floor, stage_material(s, &ground));
    pktrt_light l = light_of(PKTRT_LIGHT_POINT, 10);
    vec_put(vec_of(0, 2, 0), l.position);
    stage_light(s, &l);
    stage_commit(s);
    mesh_free(&slab);
    pktrt_render_desc d = look_at_origin(PKTRT_MODE_WRT, 0, false, pixel);
    d.camera.eye[1] = -0.5f, d.camera.eye[2] = 0, d.camera.target[1] = -1;
    stage_render(s, &d);
    const double want = 0.5 / PI * 10 / 9 * exp(-2 * 0.5);
    CHECK(fabs((double)pixel[0] - want) < 1e-4 * want, "sheet %d: %g, not %g", there, (double)pixel[0], want);
    pktrt_scene_destroy(s);
  }

  pktrt_scene *s = stage_open();
  pktrt_material sheet = thin_of(1, 1, 0);
  mesh box = mesh_box();
  sheet.absorption[0] = sheet.absorption[1] = sheet.absorption[2] = 0.5f;
  stage_mesh(s, &box, stage_material(s, &sheet));
  stage_commit(s);
  mesh_free(&box);
  pktrt_render_desc d = look_at_origin(PKTRT_MODE_WRT, 20, false, pixel);
  for (int a = 0; a < 3; a++) d.camera.eye[a] *= 0.2f;
  stage_render(s, &d);
  for (int a = 0; a < 3; a++) CHECK(near_to((double)pixel[a], below[a]), "channel %d: %g", a, (double)pixel[a]);
  pktrt_scene_destroy(s);
}

/* A texture that tints by place. */
static void stained(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    const float x = p->position[0][i] + p->texcoord[0][i];
    p->albedo[0][i] = x > 0 ? 0.9f : 0.2f, p->albedo[1][i] = 0.5f,
    p->albedo[2][i] = p->direction[1][i] < 0 ? 0.3f : 0.8f;
  }
}

/* Light that falls through stained glass: the texture is asked where a shadow ray crosses. */
static void stained_glass(void) {
  for (int i = 0; i < 12; i++) {
    const bool left = i % 2, blocks = i / 2 % 2;
    const pktrt_mode mode = (pktrt_mode)(i / 4);
    float pixel[3];
    pktrt_scene *s = stage_open();
    pktrt_material sheet = thin_of(0.1, 1.6, 0.8);
    const pktrt_material ground = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
    const quad floor = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 9), vec_of(9, 0, 0)),
               window = quad_of(vec_of(0, 1, 0), vec_of(0, 0, 0.9), vec_of(0.9, 0, 0)),
               veil = quad_of(vec_of(0, 1.5, 0), vec_of(0, 0, 0.9), vec_of(0.9, 0, 0));
    const pktrt_material nothing =
        blend_of(9, 1); /* shadow rays are asked again for its sake, whatever they do at glass */
    sheet.texture = stained;
    stage_quad(s, &floor, stage_material(s, &ground));
    stage_quad(s, &veil, stage_material(s, &nothing));
    stage_quad(s, &window, stage_material(s, &sheet));
    pktrt_light l = light_of(PKTRT_LIGHT_POINT, 10);
    vec_put(vec_of(left ? -0.8 : 0.8, 2, 0), l.position);
    stage_light(s, &l);
    stage_commit(s);
    pktrt_render_desc d = stage_view(mode, 1, 1, pixel, vec_of(2, 0.5, 0), vec_of(0, 0, 0));
    d.camera.fov_y = 0.001f, d.glass_shadows = blocks ? PKTRT_GLASS_SHADOWS_BLOCK : PKTRT_GLASS_SHADOWS_PASS;
    stage_render(s, &d);
    const double r = sqrt(4 + 0.64), open = 0.5 / PI * 10 * (2 / r) / (r * r);
    const double tint[3] = {left ? 0.2 : 0.9, 0.5, 0.8}; /* shadow rays go up */
    for (int a = 0; a < 3; a++) {
      const double want =
          blocks || !mode ? 0 : open * (1 - plate_reflects(2 / r, (double)sheet.ior[0])) * 0.8 * tint[a];
      CHECK(fabs((double)pixel[a] - want) <= 1e-4 * want, "case %d, channel %d: %g, not %g", i, a, (double)pixel[a],
          want);
    }
    pktrt_scene_destroy(s);
  }
}

/* --- what blends --- */

/* Leaves as much as the texture coordinates say; `user`: the opacity that there was before, of all points. */
static void fades(void *user, const pktrt_points *p) {
  float *seen = (float *)user;
  for (uint32_t i = 0; i < p->n; i++) {
    if (p->opacity[i] != *seen) *seen = -1;
    p->opacity[i] = p->barycentric[0][i];
  }
}

/* Sheets that shine before a background: means are those of opacities, for stacks and closed bodies, with a texture too. */
static void blends_in_closed_form(void) {
  static const double clear[] = {0, 0.125, 0.5, 0.9, 1};
  for (int i = 0; i < 40; i++) {
    const double transparency = clear[i % 5];
    const int sheets = i / 5 % 2 ? 3 : 1;
    const bool body = i / 10 % 2;
    pktrt_scene *s = stage_open();
    const pktrt_material m = blend_of(1, transparency);
    const uint32_t material = stage_material(s, &m);
    mesh box = mesh_box();
    for (int k = 0; k < sheets; k++) {
      const quad sheet = quad_of(vec_of(0, -0.1 * k, 0), vec_of(0, 0, 2), vec_of(2, 0, 0));
      mesh_place(&box, (float[3]){1, 0.25f, 1}, (float[3]){0, k ? -0.75f : 0, 0});
      if (body) stage_mesh(s, &box, material);
      else stage_quad(s, &sheet, material);
    }
    stage_commit(s);
    mesh_free(&box);
    pktrt_render_desc d = look_at_origin(i / 20 ? PKTRT_MODE_DRT : PKTRT_MODE_WRT, 10, false, NULL);
    d.width = d.height = 8,
    d.samples = small_run ? 16 : 8; /* then an eighth; one alone would be the same for all seeds */
    const estimate e = stage_estimate(s, &d, 64);
    const double through = pow(transparency, sheets * (body ? 2 : 1)), want = 1 - through + through * below[0];
    CHECK(fabs(e.mean[0] - want) < 4 * e.error[0] + 1e-4, "case %d: %g +- %g, not %g", i, e.mean[0], e.error[0], want);
    CHECK(through < 1e-3 || through == 1 || e.error[0] > 1e-5, "case %d: there is chance", i);
    pktrt_scene_destroy(s);
  }

  for (int blends = 0; blends < 2; blends++) {
    pktrt_scene *s = stage_open();
    pktrt_material m = blend_of(1, 0.375);
    float seen = 0.625f;
    const quad sheet = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 2), vec_of(2, 0, 0));
    m.blend = blends, m.cutout = !blends, m.texture = fades, m.user = &seen;
    stage_quad(s, &sheet, stage_material(s, &m));
    stage_commit(s);
    pktrt_render_desc d = look_at_origin(PKTRT_MODE_DRT, 0, false, NULL);
    d.camera.eye[1] = 3, d.camera.eye[2] = 0, d.camera.projection = PKTRT_PROJECTION_ORTHOGRAPHIC;
    d.camera.width = 4, d.width = d.height = 16, d.samples = 16;
    const estimate e = stage_estimate(s, &d, 32);
    const double solid = blends ? 1.0 / 3 : 0.25; /* the mean of u over a triangle; where it is above a half */
    const double want = solid + (1 - solid) * below[0];
    CHECK(fabs(e.mean[0] - want) < 4 * e.error[0] + 1e-5, "texture, blend %d: %g +- %g, not %g", blends, e.mean[0],
        e.error[0], want);
    CHECK(seen == 0.625f, "opacity began with %g", (double)seen);
    pktrt_scene_destroy(s);
  }
}

/* What blends throws a shadow of its opacity, whatever shadow rays do at glass, and hides in mirrors as much as it does else. */
static void blends_in_the_light(void) {
  for (int i = 0; i < 24; i++) {
    const double transparency = i % 2 ? 0.75 : 0.25;
    const pktrt_mode mode = (pktrt_mode)(i / 2 % 3);
    const pktrt_light_kind kind = i / 6 % 2 ? PKTRT_LIGHT_SPHERE : PKTRT_LIGHT_POINT;
    estimate e[2];
    for (int there = 0; there < 2; there++) {
      pktrt_scene *s = stage_open();
      const pktrt_material m = blend_of(0, transparency), ground = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
      const quad floor = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 9), vec_of(9, 0, 0)),
                 shade = quad_of(vec_of(0, 1, 0), vec_of(0, 0, 0.9), vec_of(0.9, 0, 0));
      stage_quad(s, &floor, stage_material(s, &ground));
      if (there) stage_quad(s, &shade, stage_material(s, &m));
      pktrt_light l = light_of(kind, 10);
      l.radius = 0.3f;
      vec_put(vec_of(0.2, 2, 0), l.position);
      stage_light(s, &l);
      stage_commit(s);
      pktrt_render_desc d = stage_view(mode, 8, 8, NULL, vec_of(2, 0.5, 0), vec_of(0, 0, 0));
      d.camera.fov_y = 1, d.samples = 16;
      d.glass_shadows = i / 12 ? PKTRT_GLASS_SHADOWS_BLOCK : PKTRT_GLASS_SHADOWS_PASS;
      e[there] = stage_estimate(s, &d, 32);
      pktrt_scene_destroy(s);
    }
    const double error = 4 * (e[1].error[0] + transparency * e[0].error[0]), want = transparency * e[0].mean[0];
    CHECK(fabs(e[1].mean[0] - want) < error + 1e-5 && want > 0.02, "case %d: %g, not %g +- %g", i, e[1].mean[0], want,
        error);
  }
}

/* A thin sheet, a mirror, metal and a matt surface that blend: what is behind them and what they show add up. */
static void what_blends_may_be_anything(void) {
  static const pktrt_specular kinds[] = {
      PKTRT_SPECULAR_NONE, PKTRT_SPECULAR_MIRROR, PKTRT_SPECULAR_COAT, PKTRT_SPECULAR_CONDUCTOR, PKTRT_SPECULAR_THIN};
  for (size_t i = 0; i < COUNT(kinds) * 2; i++) {
    estimate e[3]; /* opaque, half, not there */
    for (int k = 0; k < 3; k++) {
      pktrt_scene *s = stage_open();
      pktrt_material m = material_of(0.4, kinds[i / 2], 0.5);
      mesh box = mesh_box();
      const quad sheet = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 2), vec_of(2, 0, 0));
      m.blend = true, m.transparency = 0.5f * (float)k;
      stage_quad(s, &sheet, stage_material(s, &m));
      stage_commit(s);
      mesh_free(&box);
      pktrt_render_desc d = look_at_origin(i % 2 ? PKTRT_MODE_DRT : PKTRT_MODE_WRT, 60, false, NULL);
      d.width = d.height = 8, d.samples = 16;
      for (int a = 0; a < 3; a++) d.ambient[a] = 0.5f;
      e[k] = stage_estimate(s, &d, 32);
      pktrt_scene_destroy(s);
    }
    const double want = (e[0].mean[0] + e[2].mean[0]) / 2, error = 4 * (e[0].error[0] + e[1].error[0] + e[2].error[0]);
    CHECK(fabs(e[1].mean[0] - want) < error + 1e-4, "case %zu: %g, not %g +- %g", i, e[1].mean[0], want, error);
    CHECK(fabs(e[0].mean[0] - e[2].mean[0]) > 0.1, "the control, case %zu: it is seen", i);
  }
}

/* --- both --- */

/* One scene with all of it: stained sheets, sheets that scatter, a film within glass, what blends by a texture and without, in an
   instance that moves. */
static void half_there(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) p->opacity[i] *= p->barycentric[1][i] > 0.4f ? 0.3f : 1.0f;
}
static pktrt_scene *all_open(pktrt_isa isa, int workers) {
  const pktrt_scene_desc desc = scene_desc_of(isa, workers);
  pktrt_scene *s = pktrt_scene_create(&desc);
  if (!CHECK(s != NULL, "%s", pktrt_last_error(NULL))) abort();
  pktrt_material window = thin_of(0.5, 1.5, 0.7), film = thin_of(0.8, 1.2, 0),
                 glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  pktrt_material veil = material_of(0.6, PKTRT_SPECULAR_NONE, 0), leaf = veil,
                 floor = material_of(0.4, PKTRT_SPECULAR_MIRROR, 0.4);
  mesh ball = mesh_sphere(2, 0, 9), small_ball = mesh_sphere(1, 0, 3);
  const quad ground = quad_of(vec_of(0, -1, 0), vec_of(0, 0, 3), vec_of(3, 0, 0)),
             pane = quad_of(vec_of(-0.5, 0, 2.2), vec_of(1, 0, 0), vec_of(0, 2, 0.3)),
             roof = quad_of(vec_of(0, 1.4, 0), vec_of(0, 0, 3), vec_of(3, 0.2, 0)),
             curtain = quad_of(vec_of(0.8, 0, 1.8), vec_of(0.7, 0, 0), vec_of(0, 1.5, 0));
  window.texture = stained, glass.absorption[1] = 0.4f;
  veil.blend = true, veil.transparency = 0.4f, leaf.blend = true, leaf.texture = half_there;
  floor.lobe = PKTRT_LOBE_PHONG, floor.exponent = 30;
  stage_quad(s, &ground, stage_material(s, &floor));
  stage_quad(s, &pane, stage_material(s, &window));
  stage_quad(s, &roof, stage_material(s, &veil));
  stage_quad(s, &curtain, stage_material(s, &leaf));
  mesh_scale(&ball, 0.8f), mesh_scale(&small_ball, 0.5f);
  stage_mesh(s, &ball, stage_material(s, &glass));
  stage_mesh(s, &small_ball, stage_material(s, &film));
  mesh_free(&ball), mesh_free(&small_ball);
  pktrt_light l = light_of(PKTRT_LIGHT_SPHERE, 4), point = light_of(PKTRT_LIGHT_POINT, 3);
  l.position[0] = 0.4f, l.position[1] = 2, l.radius = 0.3f, l.visible = true;
  point.position[0] = -1, point.position[1] = 1.9f, point.position[2] = 2;
  stage_light(s, &l), stage_light(s, &point);
  stage_commit(s);
  return s;
}

static void the_same_by_every_path(void) {
  static float want[VALUES], got[VALUES];
  const int each = small_run ? 3 : 8;
  size_t compared = 0;
  for (int mode = 0; mode < 3; mode++)
    for (int k = 0; k < isa_count * each; k++) {
      pktrt_scene *s = all_open(isas[k / each], k % 3 ? 2 : 0);
      pktrt_render_desc d = room_view((pktrt_mode)mode, k ? got : want);
      d.path = (pktrt_path)(k % 3), d.packet_size = 2u << k / 3 % 4, d.samples = 2, d.seed = 5;
      d.tile_size = k % 2 ? 7 : 0, d.assembly = (pktrt_assembly)(k % (PKTRT_ASSEMBLY_NONE + 1));
      d.shadows = (pktrt_shadow_packets)(k / 2 % 2);
      if (k % 8 == 2) d.passes = 1;
      stage_render(s, &d);
      if (k) compared++, CHECK(same_bits(want, got, sizeof want), "mode %d, case %d", mode, k);
      if (k == 0) {
        d.seed = 6, d.pixels = got;
        stage_render(s, &d);
        CHECK(!same_bits(want, got, sizeof want), "the control, mode %d: another seed", mode);
      }
      pktrt_scene_destroy(s);
    }
  say("%zu pictures", compared);
}

/* Passes of random choices at a sheet where primary rays end are split as at glass. */
static void sheets_in_adaptive_passes(void) {
  const pktrt_material sheet = thin_of(0.9, 2.4, 0.7);
  const room r = {&sheet, NULL, PKTRT_LIGHT_POINT, PKTRT_LOBE_IDEAL, true};
  estimate e[2];
  for (int adaptive = 0; adaptive < 2; adaptive++) {
    pktrt_scene *s = room_open(&r);
    pktrt_render_desc d = room_view(PKTRT_MODE_DRT, NULL);
    d.samples = small_run ? 16 : 4, d.passes = 8, d.adaptive = adaptive;
    e[adaptive] = stage_estimate(s, &d, 8);
    pktrt_scene_destroy(s);
  }
  for (int a = 0; a < 3; a++)
    CHECK(fabs(e[0].mean[a] - e[1].mean[a]) < 4 * (e[0].error[a] + e[1].error[a]) + 0.01 * e[0].mean[a],
        "channel %d: %g and %g", a, e[0].mean[a], e[1].mean[a]);
}

/* --- refusals and the log --- */

static void say_so(pktrt_scene *s, const pktrt_material *m, const char *words) {
  const int before = hooks.warnings;
  uint32_t index;
  hooks.last_log[0] = 0;
  const pktrt_status status = pktrt_add_material(s, m, &index);
  if (!words) {
    CHECK(status == PKTRT_OK && hooks.warnings == before, "%s %s", pktrt_last_error(s), hooks.last_log);
    return;
  }
  const char *said = status == PKTRT_OK ? hooks.last_log : pktrt_last_error(s);
  CHECK(strstr(said, words) != NULL, "'%s', not '%s'", said, words);
}
static void sentences(void) {
  static const float bad[] = {-0.5f, 1.5f, NAN, INFINITY};
  pktrt_scene *s = stage_open();
  for (size_t i = 0; i < COUNT(bad); i++) {
    pktrt_material m = thin_of(0.5, 1.5, (double)bad[i]);
    CHECK(pktrt_add_material(s, &m, NULL) == PKTRT_INVALID_ARGUMENT, "case %zu", i);
    say_so(s, &m, "transmission");
    m.transmission = 0, m.transparency = bad[i];
    CHECK(pktrt_add_material(s, &m, NULL) == PKTRT_INVALID_ARGUMENT, "case %zu", i);
    say_so(s, &m, "transparency");
  }
  pktrt_material m = thin_of(0, 1.5, 0.5);
  say_so(s, &m, "a thin sheet lets through albedo");
  m.texture = stained;
  say_so(s, &m, NULL);
  m = material_of(0.5, PKTRT_SPECULAR_NONE, 0), m.transparency = 0.5f;
  say_so(s, &m, "its transparency counts where `blend` is set");
  m.blend = true;
  say_so(s, &m, NULL);
  m.cutout = true;
  say_so(s, &m, NULL);
  m.blend = false;
  say_so(s, &m, "is a cutout, but has no texture");
  m = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0), m.blend = true;
  CHECK(pktrt_add_material(s, &m, NULL) == PKTRT_INVALID_ARGUMENT, "glass may blend");
  say_so(s, &m, "is glass and blends");
  pktrt_scene_destroy(s);
}

/* A room of sheets and no light is no mistake; one of blending matt surfaces is. */
static void darkness(void) {
  for (int matt = 0; matt < 2; matt++) {
    float pixel[3];
    pktrt_scene *s = stage_open();
    pktrt_material m = thin_of(0.5, 1.5, 0);
    const quad sheet = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 2), vec_of(2, 0, 0));
    if (matt) m = blend_of(0, 0.5), m.albedo[0] = 0.5f;
    stage_quad(s, &sheet, stage_material(s, &m));
    stage_commit(s);
    pktrt_render_desc d = look_at_origin(PKTRT_MODE_WRT, 0, false, pixel);
    d.camera.fov_y = 10;
    const int before = hooks.warnings;
    stage_render(s, &d);
    CHECK((hooks.warnings > before) == matt, "matt %d: %d, %s", matt, hooks.warnings - before, hooks.last_log);
    pktrt_scene_destroy(s);
  }
}

void suite_thin(void) {
  run("a thin sheet reflects, lets through and scatters as closed forms say, from both sides", sheets_in_closed_form);
  run("a thin sheet does not bend rays", sheets_do_not_bend);
  run("where one way is chosen at a thin sheet, means are the same", sheets_by_chance);
  run("stacks of thin sheets are as closed forms say", stacks_of_sheets);
  run("a white sheet of index 1 is as if it were not there, under every light", sheets_that_are_not_there);
  run("rays stay in the glass that they are in at a thin sheet", sheets_within_glass);
  run("thin sheets are no glass: what is behind one, or within a body of them, is not dimmed, nor less",
      sheets_are_no_glass);
  run("light falls through stained glass by the colour where it crosses", stained_glass);
  run("means of what blends are those of its opacities, in stacks, bodies and textures", blends_in_closed_form);
  run("what blends throws a shadow of its opacity", blends_in_the_light);
  run("any material but glass may blend", what_blends_may_be_anything);
  run("sheets and what blends have the same bits by every path, packet and instruction set", the_same_by_every_path);
  run("adaptive passes split at thin sheets without bias", sheets_in_adaptive_passes);
  run("what is wrong with sheets and what blends is refused or told by name", sentences);
  run("sheets need no light of their own, what blends does", darkness);
}
