/* Materials against closed forms: Fresnel, Snell, Beer, the Phong lobe, energy, depth, textures and shaders. */
#include "pictures.h"

/* --- skies --- */

typedef struct sky { /* radiance of the upper and the lower half space; or by direction */
  double up[3], down[3];
  vec axis; /* of sky_cosine and sky_beam */
} sky;

static void sky_halves(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  const sky *s = user;
  for (int k = 0; k < 3; k++) {
    for (uint32_t i = 0; i < n; i++) radiance[k][i] = (float)(direction[1][i] > 0 ? s->up[k] : s->down[k]);
  }
}

/* Each direction has a colour of its own. */
static void sky_code(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (int k = 0; k < 3; k++) {
    for (uint32_t i = 0; i < n; i++) radiance[k][i] = 0.5f + 0.5f * direction[k][i];
  }
}

/* The same below, black above. */
static void sky_code_below(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  sky_code(user, n, direction, radiance);
  for (int k = 0; k < 3; k++) {
    for (uint32_t i = 0; i < n; i++) radiance[k][i] *= direction[1][i] < 0;
  }
}

static void sky_cosine(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  const sky *s = user;
  for (uint32_t i = 0; i < n; i++) {
    vec d = vec_of((double)direction[0][i], (double)direction[1][i], (double)direction[2][i]);
    for (int k = 0; k < 3; k++) radiance[k][i] = (float)fmax(vec_dot(d, s->axis), 0);
  }
}

static void sky_beam(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  sky_cosine(user, n, direction, radiance);
  for (int k = 0; k < 3; k++) {
    for (uint32_t i = 0; i < n; i++) radiance[k][i] = radiance[k][i] > 0.9f;
  }
}

/* --- Fresnel --- */

/* What rounding of the arguments may change, and the last bits of the result. */
static double slack(double (*f)(double, double, double), double c, double eta, double k) {
  double most = 0, middle = f(c, eta, k);
  for (int i = 0; i < 4; i++) {
    double e = i & 1 ? 1 + 0x1p-21 : 1 - 0x1p-21, g = i & 2 ? 1 + 0x1p-22 : 1 - 0x1p-22;
    most = fmax(most, fabs(f(fmin(c * e, 1), eta * g, k) - middle));
  }
  return most + 2e-6 * middle + 1e-12;
}

static double dielectric(double c, double eta, double k) { return (void)k, fresnel_exact(c, eta); }

static double schlick(double c, double eta, double k) {
  double r = ((eta - 1) * (eta - 1) + k * k) / ((eta + 1) * (eta + 1) + k * k);
  return r + (1 - r) * pow(1 - c, 5);
}

static void fresnel_dielectrics(void) {
  static const float etas[] = {
      1.000001f, 1.0003f, 1.33f, 1.5f, 2.4f, 30, 1000, 0.999999f, 0.75f, 1 / 1.5f, 1 / 2.4f, 0.001f};
  size_t checked = 0, off = 0;
  for (size_t j = 0; j < COUNT(etas); j++) {
    double eta = (double)etas[j];
    for (int i = 0; i <= 1000; i++) {
      float c = i < 500 ? (float)i / 500 : powf(0.95f, (float)(i - 500));
      double got = (double)pktrt_fresnel_dielectric(c, etas[j]), want = fresnel_exact((double)c, eta);
      CHECK(fabs(got - want) <= slack(dielectric, (double)c, eta, 0), "cosine %.9g, eta %.9g: %.9g, not %.9g",
          (double)c, eta, got, want);
      checked++;
      off += fabs(schlick((double)c, eta, 0) - want) > slack(dielectric, (double)c, eta, 0);
    }
    double normal = (eta - 1) / (eta + 1), got = (double)pktrt_fresnel_dielectric(1, etas[j]);
    CHECK(fabs(got - normal * normal) <= 1e-6 * normal * normal + 1e-13, "eta %g, straight on: %g", eta, got);
    CHECK(pktrt_fresnel_dielectric(0, etas[j]) == 1, "eta %g: all is reflected at grazing angles", eta);
    double grazing = (double)pktrt_fresnel_dielectric(1e-9f, etas[j]);
    CHECK(j == 0 || grazing > 0.999, "eta %g: nearly all is reflected at nearly grazing angles: %g", eta, grazing);
    double brewster = 1 / sqrt(1 + eta * eta), s = (1 - eta * eta) / (1 + eta * eta);
    got = (double)pktrt_fresnel_dielectric((float)brewster, etas[j]);
    CHECK(fabs(got - s * s / 2) <= slack(dielectric, brewster, eta, 0), "eta %g, Brewster's angle: %g, not %g", eta,
        got, s * s / 2);
    if (eta >= 1) continue;
    double critical = sqrt(1 - eta * eta);
    for (int i = 0; i <= 100; i++) {
      float c = (float)(critical * (1 - 1e-6) * i / 100);
      CHECK(pktrt_fresnel_dielectric(c, etas[j]) == 1, "eta %g, cosine %g: total reflection", eta, (double)c);
    }
    if (eta > 0.1 && eta < 0.9)
      CHECK(pktrt_fresnel_dielectric((float)(critical * 1.01), etas[j]) < 0.9f, "eta %g: and no further", eta);
  }
  for (int i = 1; i <= 100; i++)
    CHECK(pktrt_fresnel_dielectric((float)i / 100, 1) < 1e-12f, "nothing is reflected where nothing changes");
  say("%zu values; Schlick's approximation would fail for %zu of them", checked, off);
  CHECK(off > checked / 2);
}

static void fresnel_conductors(void) {
  static const float metals[][2] = {
      {0.17f, 3.1f}, {0.42f, 2.35f}, {1.4f, 1.9f}, {0.15f, 4.0f}, {1.1f, 6.8f}, {3.2f, 3.3f}, {1, 0.01f}, {4, 0.5f}};
  size_t checked = 0, off = 0;
  for (size_t j = 0; j < COUNT(metals); j++) {
    double n = (double)metals[j][0], k = (double)metals[j][1];
    for (int i = 0; i <= 1000; i++) {
      float c = (float)i / 1000;
      double got = (double)pktrt_fresnel_conductor(c, metals[j][0], metals[j][1]),
             want = conductor_exact((double)c, n, k);
      double most = slack(conductor_exact, (double)c, n, k) + 1e-6;
      CHECK(fabs(got - want) <= most, "cosine %g, %g + %gi: %.9g, not %.9g", (double)c, n, k, got, want);
      checked++;
      off += fabs(schlick((double)c, n, k) - want) > most;
    }
    double want = ((n - 1) * (n - 1) + k * k) / ((n + 1) * (n + 1) + k * k),
           got = (double)pktrt_fresnel_conductor(1, metals[j][0], metals[j][1]);
    CHECK(fabs(got - want) <= 1e-6, "%g + %gi, straight on: %g, not %g", n, k, got, want);
  }
  for (int i = 1; i <= 100; i++) { /* without extinction a metal is a dielectric */
    double got = (double)pktrt_fresnel_conductor((float)i / 100, 1.5f, 0);
    CHECK(fabs(got - fresnel_exact((double)((float)i / 100), 1.5)) <= 1e-5, "cosine %g: %g", i / 100., got);
  }
  say("%zu values; Schlick's approximation would fail for %zu of them", checked, off);
  CHECK(off > checked / 2);
}

/* The same equations as they stand in books, which divide 0 by 0 at some limits. */
DIVIDES_BY_ZERO static double conductor_plain(double c, double eta, double k) {
  double c2 = c * c, s2 = 1 - c2, m = eta * eta - k * k - s2, ab = sqrt(m * m + 4 * eta * eta * k * k);
  double a = sqrt(fmax(0, (ab + m) / 2)), s = (ab + c2 - 2 * a * c) / (ab + c2 + 2 * a * c);
  return s * (1 + (c2 * ab + s2 * s2 - 2 * a * c * s2) / (c2 * ab + s2 * s2 + 2 * a * c * s2)) / 2;
}

static void fresnel_limits(void) {
  static const float cosines[4] = {0, 1e-30f, 0.5f, 1}, indices[4] = {0, 1e-6f, 1, 1e6f};
  size_t off = 0;
  for (int i = 0; i < 64; i++) {
    float c = cosines[i % 4], eta = indices[i / 4 % 4], k = indices[i / 16];
    float got = pktrt_fresnel_conductor(c, eta, k);
    CHECK(got >= 0 && got <= 1, "cosine %g, %g + %gi: %.9g", (double)c, (double)eta, (double)k, (double)got);
    CHECK(c > 0 || got == 1, "cosine 0, %g + %gi: all is reflected, not %.9g", (double)eta, (double)k, (double)got);
    CHECK(pktrt_fresnel_dielectric(c, INFINITY) == 1 && pktrt_fresnel_dielectric(c, 0) == 1, "cosine %g, glass",
        (double)c);
    double plain = conductor_plain((double)c, (double)eta, (double)k);
    off += !(plain >= 0 && plain <= 1);
  }
  say("64 limits; the equations as they stand would fail for %zu of them", off);
  CHECK(off > 0, "the control");
}

/* --- Fresnel in pictures: a floor under a bright and a dark half of the sky --- */

enum { SIDE = 48 };
typedef enum surface { COAT, COAT_FACTOR, METAL, METAL_TINTED, GLASS, GLASS_FACTOR, GLASS_INSIDE, SURFACES } surface;
static const float gold_n[3] = {0.17f, 0.42f, 1.4f}, gold_k[3] = {3.1f, 2.35f, 1.9f}, tint[3] = {0.25f, 1, 0.5f};

static double surface_radiance(surface kind, double c, const sky *s, int channel) {
  double f = fresnel_exact(c, 1.5), up = s->up[channel], down = s->down[channel];
  switch (kind) {
  case COAT: return f * up + (1 - f) * 0.4 * 0.5;
  case COAT_FACTOR: return 0.25 * f * up + (1 - f) * 0.4 * 0.5;
  case METAL: return conductor_exact(c, (double)gold_n[channel], (double)gold_k[channel]) * up;
  case METAL_TINTED: return (double)tint[channel] * surface_radiance(METAL, c, s, channel);
  case GLASS: return f * up + (1 - f) * down;
  case GLASS_FACTOR: return 0.25 * f * up + (1 - f) * down;
  default: f = fresnel_exact(c, 1 / 1.5); return f * down + (1 - f) * up;
  }
}

static pktrt_material surface_material(surface kind) {
  pktrt_material m = material_of(0.4, PKTRT_SPECULAR_DIELECTRIC, 0);
  if (kind == COAT || kind == COAT_FACTOR) m.specular = PKTRT_SPECULAR_COAT, m.ior[0] = 1.5f;
  if (kind == METAL || kind == METAL_TINTED)
    m.specular = PKTRT_SPECULAR_CONDUCTOR, memcpy(m.ior, gold_n, 12), memcpy(m.extinction, gold_k, 12);
  if (kind == METAL_TINTED) memcpy(m.reflectance, tint, 12);
  if (kind == COAT_FACTOR || kind == GLASS_FACTOR) m.reflectance[0] = m.reflectance[1] = m.reflectance[2] = 0.25f;
  return m; /* glass: an index of 0 is 1.5 */
}

static void fresnel_pictures(void) {
  static const char *const name[SURFACES] = {
      "coat", "coat, a quarter", "metal", "metal, tinted", "glass", "glass, a quarter", "glass from inside"};
  sky s = {{0.9, 1.7, 0.6}, {0.1, 0.05, 0.3}, {0, 0, 0}};
  quad floor = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 1000), vec_of(1000, 0, 0));
  float *got = stage_pixels(SIDE * SIDE * 3);
  for (int kind = 0; kind < SURFACES; kind++) {
    bool inside = kind == GLASS_INSIDE;
    double side = inside ? -1 : 1, worst = 0;
    pktrt_scene *scene = stage_open();
    pktrt_material m = surface_material((surface)kind);
    stage_quad(scene, &floor, stage_material(scene, &m));
    stage_commit(scene);
    pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, SIDE, SIDE, got, vec_of(0, side, 0), vec_of(0, 0.4 * side, -1));
    d.camera.fov_y = 90, d.environment = sky_halves, d.user = &s;
    d.ambient[0] = d.ambient[1] = d.ambient[2] = 0.5f;
    stage_render(scene, &d);
    size_t seen = 0, total = 0, control = 0;
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
      vec v = stage_through(&d.camera, i % SIDE + 0.5, i / SIDE + 0.5, SIDE, SIDE);
      double c = -v.y * side;
      if (c < 0.003) continue;
      seen++, total += inside && fresnel_exact(c, 1 / 1.5) == 1;
      for (int k = 0; k < 3; k++) {
        double want = surface_radiance((surface)kind, c, &s, k), a = surface_radiance((surface)kind, c + 2e-6, &s, k);
        double b = surface_radiance((surface)kind, c - 2e-6, &s, k),
               off = fabs((double)got[3 * i + (uint32_t)k] - want);
        CHECK(off <= fabs(a - b) + 2e-5, "%s, cosine %g: %g, not %g", name[kind], c, (double)got[3 * i + (uint32_t)k],
            want);
        worst = fmax(worst, off);
      }
      double aside = surface_radiance((surface)kind, fmin(c + 0.02, 1), &s, 1);
      control += fabs((double)got[3 * i + 1] - aside) > 1e-4;
    }
    say("%s: %zu pixels, off by at most %.2g; %zu in total reflection; one degree aside %zu would fail", name[kind],
        seen, worst, total, control);
    CHECK(seen > SIDE * SIDE / 2 && control > 100 && (total > 100) == inside);
    pktrt_scene_destroy(scene);
  }
  free(got);
}

/* DRT chooses between reflection and refraction: the same in the mean. */
static void fresnel_chosen(void) {
  sky s = {{1, 1, 1}, {0.2, 0.2, 0.2}, {0, 0, 0}};
  quad floor = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 10), vec_of(10, 0, 0));
  for (int kind = 0; kind < SURFACES; kind++) {
    bool inside = kind == GLASS_INSIDE;
    double angle = inside ? 38 : 65, c = cos(angle * PI / 180);
    pktrt_scene *scene = stage_open();
    pktrt_material m = surface_material((surface)kind);
    stage_quad(scene, &floor, stage_material(scene, &m));
    stage_commit(scene);
    pktrt_render_desc d = stage_spot(vec_of(2 * sin(angle * PI / 180), (inside ? -2 : 2) * c, 0), vec_of(0, 0, 0));
    d.environment = sky_halves, d.user = &s;
    d.ambient[0] = d.ambient[1] = d.ambient[2] = 0.5f;
    estimate e = stage_estimate(scene, &d, 16);
    for (int k = 1; k < 3; k++) {
      const double other_channel = surface_radiance((surface)kind, c, &s, k);
      CHECK(agrees(&e, k, other_channel), "channel %d: %g, not %g", k, e.mean[k], other_channel);
    }
    double want = surface_radiance((surface)kind, c, &s, 0), other = surface_radiance((surface)kind, c * 0.9, &s, 0);
    check_estimate("Fresnel", &e, want, other, 0.02);
    pktrt_scene_destroy(scene);
  }
}

static void mirrors(void) {
  double angle = 0.4;
  vec n = vec_of(sin(angle), cos(angle), 0), half = vec_of(30 * cos(angle), -30 * sin(angle), 0);
  quad q = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 30), half);
  float *got = stage_pixels(SIDE * SIDE * 3);
  pktrt_scene *scene = stage_open();
  pktrt_material m = material_of(0.25, PKTRT_SPECULAR_MIRROR, 0);
  m.reflectance[0] = 0.75f, m.reflectance[1] = 0.5f, m.reflectance[2] = 0.25f;
  stage_quad(scene, &q, stage_material(scene, &m));
  stage_commit(scene);
  pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, SIDE, SIDE, got, vec_of(1, 3, 4), vec_of(0, 0, 0));
  d.environment = sky_code;
  for (int k = 0; k < 3; k++) d.ambient[k] = 0.4f;
  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_WRT; mode++) {
    d.mode = (pktrt_mode)mode;
    stage_render(scene, &d);
    for (uint32_t i = 0; i < SIDE * SIDE; i++) {
      vec r = reflected(stage_through(&d.camera, i % SIDE + 0.5, i / SIDE + 0.5, SIDE, SIDE), n);
      double by[3] = {r.x, r.y, r.z};
      for (int k = 0; k < 3; k++) {
        double want = 0.1 + (mode == PKTRT_MODE_WRT ? (double)m.reflectance[k] * (0.5 + 0.5 * by[k]) : 0),
               v = (double)got[3 * i + (uint32_t)k];
        CHECK(fabs(v - want) <= 1e-5, "mode %d, pixel %u: %g, not %g", mode, i, v, want);
      }
    }
  }
  pktrt_scene_destroy(scene);
  free(got);
}

/* A floor whose normals lean away from the viewer: what the mirror direction about them takes below the floor goes about its
   own normal, and where they face away altogether they count for nothing. Every direction has its colour. A coat reflects by
   the angle to the normal that counts. */
static void leaning_normals(void) {
  const double lean = 0.2;
  const vec up = vec_of(0, 1, 0), n = vec_of(sin(lean), cos(lean), 0);
  float *got = stage_pixels(SIDE * SIDE * 3), normals[12];
  static const float floor[12] = {-90, 0, -90, -90, 0, 90, 90, 0, 90, 90, 0, -90};
  static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
  for (int v = 0; v < 4; v++) vec_put(n, normals + 3 * v);
  for (int i = 0; i < 2 * isa_count; i++) {
    const pktrt_scene_desc desc = scene_desc_of(isas[i / 2], 0);
    pktrt_scene *scene = pktrt_scene_create(&desc);
    const bool coat = i % 2;
    const pktrt_material m = material_of(0, coat ? PKTRT_SPECULAR_COAT : PKTRT_SPECULAR_MIRROR, 1);
    pktrt_mesh_desc d;
    memset(&d, 0, sizeof d);
    d.positions = floor, d.normals = normals, d.vertex_count = 4, d.indices = corners, d.triangle_count = 2;
    d.material = stage_material(scene, &m);
    CHECK(pktrt_add_mesh(scene, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(scene));
    stage_commit(scene);
    pktrt_render_desc view = stage_view(PKTRT_MODE_WRT, SIDE, SIDE, got, vec_of(-4, 1, 0), vec_of(0, 0, 0));
    view.camera.fov_y = 30, view.environment = sky_code;
    stage_render(scene, &view);
    size_t bent = 0, mended = 0, away = 0;
    for (uint32_t k = 0; k < SIDE * SIDE; k++) {
      const vec v = stage_through(&view.camera, k % SIDE + 0.5, k / SIDE + 0.5, SIDE, SIDE);
      vec r = reflected(v, n);
      if (v.y > -0.01 || fabs(r.y) < 1e-5 || fabs(vec_dot(v, n)) < 1e-5) continue; /* rounding decides */
      if (vec_dot(v, n) > 0) r = reflected(v, up), away++;
      else if (r.y < 0) r = reflected(v, up), mended++;
      else bent++;
      const double cosine = -vec_dot(v, vec_dot(v, n) > 0 ? up : n), part = coat ? fresnel_exact(cosine, 1.5) : 1;
      const double want[3] = {part * (0.5 + 0.5 * r.x), part * (0.5 + 0.5 * r.y), part * (0.5 + 0.5 * r.z)};
      for (uint32_t a = 0; a < 3; a++)
        CHECK(fabs((double)got[3 * k + a] - want[a]) <= 1e-5, "%s, %s, pixel %u, channel %u: %g, not %g",
            pktrt_isa_string(desc.isa), coat ? "coat" : "mirror", k, a, (double)got[3 * k + a], want[a]);
    }
    CHECK(bent > 100 && mended > 100 && away > 100, "%zu bent, %zu mended, %zu that face away", bent, mended, away);
    if (i == 0) say("%zu pixels about the normals, %zu mended, %zu that face away", bent, mended, away);
    pktrt_scene_destroy(scene);
  }
  free(got);
}

/* --- Snell --- */

static void mesh_turn(mesh *m, double angle) { /* about z */
  for (uint32_t i = 0; i < m->nv; i++) {
    double x = (double)m->p[3 * i], y = (double)m->p[3 * i + 1];
    m->p[3 * i] = (float)(x * cos(angle) - y * sin(angle)), m->p[3 * i + 1] = (float)(x * sin(angle) + y * cos(angle));
  }
}

/* A closed box [-20,20] x [-thickness/2, thickness/2] x [-20,20] of glass, turned by an angle. */
static void add_slab(pktrt_scene *scene, double thickness, double angle, double index, const float absorption[3]) {
  mesh box = mesh_box();
  pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  glass.ior[0] = (float)index;
  memcpy(glass.absorption, absorption, 12);
  mesh_place(&box, (float[3]){20, (float)thickness / 2, 20}, (float[3]){0, 0, 0});
  mesh_turn(&box, angle);
  stage_mesh(scene, &box, stage_material(scene, &glass));
  mesh_free(&box);
}

/* A shader that shows where a point is. */
static void show_position(void *user, const pktrt_points *p, float *radiance[3]) {
  (void)user;
  for (int k = 0; k < 3; k++) {
    for (uint32_t i = 0; i < p->n; i++) radiance[k][i] = p->position[k][i] + 50;
  }
}

typedef struct slab_path { /* of a camera ray through the slab, in double */
  double weight, inside;   /* what both Fresnel transmissions leave; way inside */
  vec out;                 /* where it leaves */
  double displacement;     /* thickness sin(i - r) / cos(r) */
} slab_path;

static slab_path through_slab(vec o, vec d, vec n, double thickness, double index) {
  slab_path p;
  vec t = d;
  double c = -vec_dot(d, n), f = fresnel_exact(c, index);
  vec in = vec_add(o, vec_mul(d, (vec_dot(o, n) - thickness / 2) / c));
  refracted(d, n, index, &t);
  double ct = -vec_dot(t, n);
  p.inside = thickness / ct;
  p.weight = (1 - f) * (1 - f);
  p.out = vec_add(in, vec_mul(t, p.inside));
  p.displacement = thickness * sin(acos(c) - acos(ct)) / ct;
  return p;
}

static double line_distance(vec p, vec o, vec d) { return vec_length(vec_cross(vec_sub(p, o), d)); }

/* A tilted slab: max_depth 2 leaves the ray that goes through, and the reflection at the top, which sees nothing. */
static void slabs(void) {
  static const float clear[3] = {0, 0, 0}, blue[3] = {0.9f, 0.3f, 0.1f};
  const double thickness = 1.5, index = 1.6, angle = 0.5;
  vec n = vec_of(-sin(angle), cos(angle), 0), eye = vec_of(0.5, 12, 0.3);
  quad floor = quad_of(vec_of(0, -15, 0), vec_of(0, 0, 30), vec_of(30, 0, 0));
  float *sky_seen = stage_pixels(SIDE * SIDE * 3), *place = stage_pixels(SIDE * SIDE * 3),
        *tinted = stage_pixels(SIDE * SIDE * 3);
  pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, SIDE, SIDE, sky_seen, eye, vec_of(0, 0, 0));
  d.camera.fov_y = 25, d.max_depth = 2;
  for (int i = 0; i < 3; i++) {
    pktrt_scene *scene = stage_open();
    pktrt_material where = material_of(0, PKTRT_SPECULAR_NONE, 0);
    where.shader = show_position;
    add_slab(scene, thickness, angle, index, i == 2 ? blue : clear);
    if (i > 0) stage_quad(scene, &floor, stage_material(scene, &where));
    stage_commit(scene);
    d.environment = i == 0 ? sky_code_below : NULL, d.pixels = i == 0 ? sky_seen : i == 1 ? place : tinted;
    stage_render(scene, &d);
    pktrt_scene_destroy(scene);
  }
  double parallel = 0, displaced = 0, beer = 0, formula = 0, least = 1e9;
  for (uint32_t i = 0; i < SIDE * SIDE; i++) {
    vec v = stage_through(&d.camera, i % SIDE + 0.5, i / SIDE + 0.5, SIDE, SIDE);
    slab_path p = through_slab(eye, v, n, thickness, index);
    vec hit = vec_add(p.out, vec_mul(v, (-15 - p.out.y) / v.y));
    double to[3] = {v.x, v.y, v.z}, at[3] = {hit.x, hit.y, hit.z}, q[3];
    for (uint32_t k = 0; k < 3; k++) {
      parallel = fmax(parallel, fabs((double)sky_seen[3 * i + k] / p.weight - (0.5 + 0.5 * to[k])));
      q[k] = (double)place[3 * i + k] / p.weight - 50;
      displaced = fmax(displaced, fabs(q[k] - at[k]));
      beer = fmax(beer, fabs((double)tinted[3 * i + k] / (double)place[3 * i + k] - exp(-(double)blue[k] * p.inside)));
    }
    formula = fmax(formula, fabs(line_distance(vec_of(q[0], q[1], q[2]), eye, v) - fabs(p.displacement)));
    least = fmin(least, fabs(p.displacement));
  }
  say("direction off by at most %.2g, place by %.2g, displacement by %.2g (at least %.2g), Beer's law by %.2g",
      parallel, displaced, formula, least, beer);
  CHECK(parallel <= 2e-5, "leaves parallel to how it came");
  CHECK(displaced <= 2e-3 && formula <= 2e-3, "leaves where Snell says");
  CHECK(least > 0.1, "the control: an undisplaced ray would fail");
  CHECK(beer <= 2e-5, "Beer's law");
  free(sky_seen), free(place), free(tinted);
}

/* Something diffuse within glass: the ray that sees it and the one that lights it both lose (1 - F) exp(-a d); a camera
   within glass knows of it. */
static void within_glass(void) {
  mesh box = mesh_box();
  mesh_place(&box, (float[3]){3, 0.5f, 3}, (float[3]){0, 0.4f, 0}); /* 0.9 above the quad */
  pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  glass.absorption[0] = 0.7f;
  quad floor = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 1), vec_of(1, 0, 0));
  pktrt_light l = light_of(PKTRT_LIGHT_DIRECTIONAL, PI);
  l.direction[1] = -1;
  double one = 1 - fresnel_exact(1, 1.5), dim = exp(-0.7 * 0.9);
  for (int inside = 0; inside < 2; inside++) {
    float got[3];
    pktrt_scene *scene = stage_open();
    stage_mesh(scene, &box, stage_material(scene, &glass));
    stage_quad(scene, &floor, 0);
    stage_light(scene, &l);
    stage_commit(scene);
    pktrt_render_desc d =
        stage_view(PKTRT_MODE_WRT, 1, 1, got, vec_of(0.1, inside ? 0.5 : 3, 0.1), vec_of(0.1, 0, 0.1));
    stage_render(scene, &d);
    double clear = 0.8 * one * (inside ? 1 : one), dimmed = clear * dim * (inside ? exp(-0.7 * 0.5) : dim);
    CHECK(fabs((double)got[1] - clear) < 1e-4, "inside %d, clear: %g, not %g", inside, (double)got[1], clear);
    CHECK(fabs((double)got[0] - dimmed) < 1e-4, "inside %d, dimmed: %g, not %g", inside, (double)got[0], dimmed);
    pktrt_scene_destroy(scene);
  }
  mesh_free(&box);
}

/* A prism with corners (0,0), (1,0), (0,1), seen straight on through its lower side; light comes from where a ray
   leaves that its hypotenuse has reflected. Total reflection for 1.5, partial for 1.3. */
static void prisms(void) {
  static const float corner[3][2] = {{0, 0}, {1, 0}, {0, 1}};
  static const uint32_t faces[8][3] = {
      {0, 2, 1}, {3, 4, 5}, {0, 1, 4}, {0, 4, 3}, {1, 2, 5}, {1, 5, 4}, {2, 0, 3}, {2, 3, 5}};
  for (int i = 0; i < 2; i++) {
    double index = i == 0 ? 1.5 : 1.3, f = fresnel_exact(1, index), hypotenuse = fresnel_exact(sqrt(0.5), 1 / index);
    sky s = {{0, 0, 0}, {0, 0, 0}, {-1, 0, 0}};
    mesh m = mesh_of(6, 8);
    for (uint32_t v = 0; v < 6; v++) {
      m.p[3 * v] = corner[v % 3][0], m.p[3 * v + 1] = corner[v % 3][1], m.p[3 * v + 2] = v < 3 ? -1.f : 1.f;
    }
    memcpy(m.i, faces, sizeof faces);
    pktrt_scene *scene = stage_open();
    pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
    glass.ior[0] = (float)index;
    stage_mesh(scene, &m, stage_material(scene, &glass));
    stage_commit(scene);
    float got[3];
    pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, 1, 1, got, vec_of(0.3, -2, 0.1), vec_of(0.3, 0, 0.1));
    d.environment = sky_beam, d.user = &s;
    for (uint32_t depth = 1; depth <= 3; depth++) {
      d.max_depth = depth;
      stage_render(scene, &d);
      double want = depth < 3 ? 0 : (1 - f) * (1 - f) * hypotenuse;
      CHECK(fabs((double)got[0] - want) <= 2e-5, "index %g, depth %u: %g, not %g", index, depth, (double)got[0], want);
    }
    if (i == 1) CHECK(hypotenuse < 0.5, "the control: not total for 1.3");
    d.max_depth = 0; /* reflected back at the way out, there and back again: a geometric series */
    stage_render(scene, &d);
    double want = (1 - f) * (1 - f) * hypotenuse / (1 - f * f * pow(hypotenuse, 2));
    CHECK(i == 1 || fabs((double)got[0] - want) <= 2e-5, "index %g: %g, not %g", index, (double)got[0], want);
    pktrt_scene_destroy(scene);
    mesh_free(&m);
  }
}

/* --- the Phong lobe --- */

/* What has no lobe, a diffuse surface and glass, is the same whatever its lobe says, and no gloss is reported of it. */
static void lobes_of_what_has_none(void) {
  static const pktrt_specular kinds[2] = {PKTRT_SPECULAR_NONE, PKTRT_SPECULAR_DIELECTRIC};
  enum { EDGE = 24 };
  static float pixels[2][EDGE * EDGE * 3];
  mesh ball = mesh_sphere(3, 0, 1);
  for (int k = 0; k < 2; k++) {
    for (int lobe = 0; lobe < 2; lobe++) {
      pktrt_material m = material_of(k ? 0 : 0.5, kinds[k], 0);
      pktrt_light around = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
      pktrt_scene_report report;
      if (k) m.ior[0] = 1.5f;
      if (lobe) m.lobe = PKTRT_LOBE_PHONG, m.exponent = 20;
      pktrt_scene *s = stage_open();
      stage_mesh(s, &ball, stage_material(s, &m));
      stage_light(s, &around);
      stage_commit(s);
      pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, EDGE, EDGE, pixels[lobe], vec_of(0.5, 1, 4), vec_of(0, 0, 0));
      d.samples = 4, d.background[0] = 0.75f;
      stage_render(s, &d);
      pktrt_get_scene_report(s, &d, &report);
      CHECK(!(report.found & PKTRT_FEATURE_GLOSS), "kind %d, lobe %d: gloss is found", k, lobe);
      pktrt_scene_destroy(s);
    }
    CHECK(same_bits(pixels[0], pixels[1], sizeof pixels[0]), "kind %d", k);
  }
  mesh_free(&ball);
}

static void lobes(void) {
  static const float exponents[] = {0, 1, 10, 100, 3000};
  quad floor = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 10), vec_of(10, 0, 0));
  for (size_t i = 0; i < COUNT(exponents); i++) {
    double n = (double)exponents[i];
    pktrt_scene *scene = stage_open();
    pktrt_material m = material_of(0, PKTRT_SPECULAR_MIRROR, 1);
    m.lobe = PKTRT_LOBE_PHONG, m.exponent = exponents[i];
    stage_quad(scene, &floor, stage_material(scene, &m));
    stage_commit(scene);
    for (int tilted = 0; tilted < 2; tilted++) {
      double angle = tilted ? 80 * PI / 180 : 0;
      pktrt_render_desc d = stage_spot(vec_of(-2 * sin(angle), 2 * cos(angle), 0), vec_of(0, 0, 0));
      sky s = {{0, 0, 0}, {0, 0, 0}, {sin(angle), cos(angle), 0}};
      double share = lobe_moment(n, angle, 0), cosine = lobe_moment(n, angle, 1);
      CHECK(tilted || (fabs(share - 1) < 1e-9 && fabs(cosine - (n + 1) / (n + 2)) < 1e-5), "closed forms, straight on");
      for (int mapping = 0; mapping < 2; mapping++) {
        d.phong_mapping = mapping ? PKTRT_PHONG_NAIVE : PKTRT_PHONG_CAREFUL;
        d.environment = NULL, d.background[0] = 1, d.user = NULL;
        estimate e = stage_estimate(scene, &d, 16);
        check_estimate("share of the lobe", &e, share, share * 0.97, 0.006);
        d.environment = sky_cosine, d.user = &s;
        e = stage_estimate(scene, &d, 16);
        check_estimate("mean cosine", &e, cosine, cosine * 0.97, 0.006);
      }
      float got[3];
      pktrt_render_desc w =
          stage_view(PKTRT_MODE_WRT, 1, 1, got, vec_of(-2 * sin(angle), 2 * cos(angle), 0), vec_of(0, 0, 0));
      w.environment = sky_cosine, w.user = &s;
      stage_render(scene, &w);
      CHECK(fabsf(got[0] - 1) < 1e-5f, "WRT follows the mirror direction: %g", (double)got[0]);
    }
    pktrt_scene_destroy(scene);
  }
}

/* The mappings send the same samples elsewhere: a picture with one is not that with the other. */
static void mappings_differ(void) {
  float got[3][48];
  quad floor = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 10), vec_of(10, 0, 0));
  pktrt_scene *scene = stage_open();
  pktrt_material m = material_of(0, PKTRT_SPECULAR_MIRROR, 1);
  m.lobe = PKTRT_LOBE_PHONG, m.exponent = 10;
  stage_quad(scene, &floor, stage_material(scene, &m));
  stage_commit(scene);
  for (int i = 0; i < 3; i++) {
    sky s = {{0, 0, 0}, {0, 0, 0}, {0, 1, 0}};
    pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, 4, 4, got[i], vec_of(0, 2, 0.1), vec_of(0, 0, 0));
    d.environment = sky_cosine, d.user = &s, d.phong_mapping = i == 1 ? PKTRT_PHONG_NAIVE : PKTRT_PHONG_CAREFUL;
    stage_render(scene, &d);
  }
  CHECK(memcmp(got[0], got[2], sizeof got[0]) == 0, "the control: the careful one twice");
  CHECK(memcmp(got[0], got[1], sizeof got[0]) != 0, "the naive mapping makes no difference");
  pktrt_scene_destroy(scene);
}

/* --- energy; furnaces are in stability_shading.c --- */

/* A slab in the furnace: what max_depth D leaves out is (1 - F) F^(D-1). */
static void residual(void) {
  static const float clear[3] = {0, 0, 0};
  double angle = 78 * PI / 180, f = fresnel_exact(cos(angle), 1.5);
  pktrt_scene *scene = stage_open();
  add_slab(scene, 0.1, 0, 1.5, clear);
  stage_commit(scene);
  float got[3];
  pktrt_render_desc d =
      stage_view(PKTRT_MODE_WRT, 1, 1, got, vec_of(5 * sin(angle), 5 * cos(angle) + 0.05, 0), vec_of(0, 0.05, 0));
  d.background[0] = 1;
  for (uint32_t depth = 1; depth <= 8; depth++) {
    d.max_depth = depth;
    stage_render(scene, &d);
    double want = 1 - (1 - f) * pow(f, depth - 1.0);
    CHECK(fabs((double)got[0] - want) <= 1e-4, "depth %u: %g, not %g", depth, (double)got[0], want);
  }
  d.max_depth = 0;
  stage_render(scene, &d);
  CHECK(fabs((double)got[0] - 1) <= 1e-5, "depth 50: %.7f", (double)got[0]);
  pktrt_scene_destroy(scene);
}

/* --- hooks --- */

typedef struct hook_report {
  uint32_t mesh;
  size_t calls, points, wrong;
} hook_report;

/* Points lie on the quad [-2,2]^2 in the plane z = 0, triangles (0,1,2) and (0,2,3) of its corners. */
static void check_points(hook_report *r, const pktrt_points *p) {
  r->calls++, r->points += p->n;
  for (uint32_t i = 0; i < p->n; i++) {
    double u = (double)p->barycentric[0][i], v = (double)p->barycentric[1][i], w = 1 - u - v;
    bool second = p->triangle[i] == 1;
    double x = -2 * w + (second ? 2 : 2) * u + (second ? -2 : 2) * v, y = -2 * w + (second ? 2 : -2) * u + 2 * v;
    vec d = vec_of((double)p->direction[0][i], (double)p->direction[1][i], (double)p->direction[2][i]);
    bool ok = p->mesh[i] == r->mesh && p->triangle[i] < 2 && fabs(vec_length(d) - 1) < 1e-6 && d.z < 0;
    ok = ok && p->normal[0][i] == 0 && p->normal[1][i] == 0 && fabsf(p->normal[2][i] - 1) < 1e-6f;
    ok = ok && fabs(x - (double)p->position[0][i]) < 1e-5 && fabs(y - (double)p->position[1][i]) < 1e-5;
    ok = ok && fabsf(p->position[2][i]) < 1e-5f && fabsf(p->time[i] - 0.25f) < 1e-6f;
    r->wrong += !ok;
  }
}

static void marble(void *user, const pktrt_points *p) {
  check_points(user, p);
  for (uint32_t i = 0; i < p->n; i++) {
    ((hook_report *)user)->wrong +=
        p->albedo[0][i] != 0.25f || p->reflectance[1][i] != 0.5f || p->emission[2][i] != 0.125f;
    p->albedo[0][i] = 0.5f + 0.1f * p->position[0][i], p->albedo[1][i] = 0.5f + 0.1f * p->position[1][i];
    p->reflectance[1][i] = 0.25f, p->emission[2][i] *= 2;
  }
}

static void plain(void *user, const pktrt_points *p, float *radiance[3]) {
  check_points(user, p);
  for (uint32_t i = 0; i < p->n; i++) {
    for (int k = 0; k < 3; k++) radiance[k][i] = 2 + p->position[k == 1 ? 1 : 0][i] * (k == 2 ? 0.5f : 1.f);
  }
}

static void check_hooks(bool shader, pktrt_mode mode) {
  quad q = quad_of(vec_of(0, 0, 0), vec_of(2, 0, 0), vec_of(0, 2, 0)),
       behind = quad_of(vec_of(0, 0, -3), vec_of(20, 0, 0), vec_of(0, 20, 0));
  hook_report report = {1, 0, 0, 0};
  float *got = stage_pixels(SIDE * SIDE * 3);
  pktrt_scene *scene = stage_open();
  pktrt_material m = material_of(0.25, PKTRT_SPECULAR_MIRROR, 0.5);
  m.emission[0] = m.emission[1] = m.emission[2] = 0.125f;
  m.user = &report;
  if (shader) m.shader = plain;
  else m.texture = marble;
  stage_quad(scene, &behind, 0);
  stage_quad(scene, &q, stage_material(scene, &m));
  stage_commit(scene);
  pktrt_render_desc d = stage_view(mode, SIDE, SIDE, got, vec_of(0.5, 0.2, 6), vec_of(0, 0, 0));
  d.camera.time = 0.25f;
  for (int k = 0; k < 3; k++) d.ambient[k] = 0.8f, d.background[k] = 0.4f;
  stage_render(scene, &d);
  size_t seen = 0, others = 0;
  for (uint32_t i = 0; i < SIDE * SIDE; i++) {
    vec v = stage_through(&d.camera, i % SIDE + 0.5, i / SIDE + 0.5, SIDE, SIDE), eye = vec_from(d.camera.eye);
    vec p = vec_add(eye, vec_mul(v, -eye.z / v.z));
    double edge = fmax(fabs(p.x), fabs(p.y)), r = mode == PKTRT_MODE_RCS ? 0 : 0.4, want[3];
    want[0] = (0.5 + 0.1 * p.x) * 0.8 + 0.5 * r + 0.125, want[1] = (0.5 + 0.1 * p.y) * 0.8 + 0.25 * r + 0.125,
    want[2] = 0.25 * 0.8 + 0.5 * r + 0.25;
    if (shader) want[0] = 2 + p.x, want[1] = 2 + p.y, want[2] = 2 + 0.5 * p.x;
    if (edge > 2) want[0] = want[1] = want[2] = 0.8 * 0.8;
    if (fabs(edge - 2) < 1e-4) continue;
    seen += edge<2, others += edge> 2;
    for (uint32_t k = 0; k < 3; k++) {
      CHECK(fabs((double)got[3 * i + k] - want[k]) < 1e-5, "mode %d, pixel %u channel %u: %g, not %g", (int)mode, i, k,
          (double)got[3 * i + k], want[k]);
    }
  }
  CHECK(report.wrong == 0, "%zu of %zu points told wrong", report.wrong, report.points);
  CHECK(report.points >= seen && report.points <= seen + SIDE + 64 && seen > 500 && others > 100,
      "%zu points, %zu pixels", report.points, seen);
  CHECK(report.calls < report.points, "in batches: %zu calls, %zu points", report.calls, report.points);
  pktrt_scene_destroy(scene);
  free(got);
}

static void textures(void) { check_hooks(false, PKTRT_MODE_RCS), check_hooks(false, PKTRT_MODE_WRT); }
static void shaders(void) { check_hooks(true, PKTRT_MODE_RCS), check_hooks(true, PKTRT_MODE_WRT); }

/* A shader's radiance comes back through a mirror and through glass, weighted. */
static void shader_in_mirror(void) {
  quad mirror = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 9), vec_of(9, 0, 0)),
       wall = quad_of(vec_of(5, 0, 0), vec_of(0, 20, 0), vec_of(0, 0, 20));
  pktrt_scene *scene = stage_open();
  pktrt_material m = material_of(0, PKTRT_SPECULAR_MIRROR, 0.5), w = material_of(0, PKTRT_SPECULAR_NONE, 0);
  w.shader = show_position;
  stage_quad(scene, &mirror, stage_material(scene, &m));
  stage_quad(scene, &wall, stage_material(scene, &w));
  stage_commit(scene);
  for (int mode = PKTRT_MODE_WRT; mode <= PKTRT_MODE_DRT; mode++) {
    float got[3];
    pktrt_render_desc d = stage_view((pktrt_mode)mode, 1, 1, got, vec_of(-2, 1.5, 0), vec_of(0, 0, 0));
    d.camera.fov_y = 0.01f;
    stage_render(scene, &d);
    CHECK(fabs((double)got[1] - 0.5 * (50 + 3.75)) < 5e-3 && fabs((double)got[0] - 0.5 * 55) < 5e-3, "%g %g",
        (double)got[0], (double)got[1]);
  }
  pktrt_scene_destroy(scene);
}

/* --- normals that move --- */

/* A quad that stays while its normals turn: at each time they are what lies between the keys, by corner and by time. */
static void normals_in_time(void) {
  enum { N = 16 };
  static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
  static const float positions[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  static const float normals[24] = {
      0, 0, 1, 0.6f, 0, 0.8f, 0, 0.6f, 0.8f, 0, 0, 1, 0.6f, 0, 0.8f, 0, 0, 1, 0, 0, 1, 0, -0.6f, 0.8f};
  float twice[24], got[N * N * 3], normal[N * N * 3];
  memcpy(twice, positions, sizeof positions), memcpy(twice + 12, positions, sizeof positions);
  pktrt_scene *scene = stage_open();
  pktrt_mesh_desc m;
  memset(&m, 0, sizeof m);
  m.positions = twice, m.vertex_count = 4, m.indices = corners, m.triangle_count = 2, m.key_count = 2,
  m.normals = normals;
  pktrt_light sun = light_of(PKTRT_LIGHT_DIRECTIONAL, PI);
  sun.direction[0] = -0.5f, sun.direction[2] = -1;
  vec to_sun = vec_unit(vec_of(0.5, 0, 1));
  CHECK(pktrt_add_mesh(scene, &m, NULL) == PKTRT_OK, "%s", pktrt_last_error(scene));
  stage_light(scene, &sun);
  stage_commit(scene);
  size_t control = 0, seen = 0;
  for (int i = 0; i <= 4; i++) {
    double t = i / 4.;
    pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, N, N, got, vec_of(0, 0, 4), vec_of(0, 0, 0));
    d.camera.fov_y = 27, d.camera.time = (float)t, d.normal = normal;
    stage_render(scene, &d);
    for (uint32_t j = 0; j < N * N; j++) {
      vec v = stage_through(&d.camera, j % N + 0.5, j / N + 0.5, N, N), p = vec_mul(v, -4 / v.z), want[2];
      double x = (p.x + 1) / 2, y = (p.y + 1) / 2, weight[4] = {1 - x, x - y, y, 0}; /* triangle 0: x > y */
      if (y > x) weight[0] = 1 - y, weight[1] = 0, weight[2] = x, weight[3] = y - x;
      for (int frozen = 0; frozen < 2; frozen++) {
        vec sum = {0, 0, 0};
        for (uint32_t c = 0; c < 4; c++) {
          vec a = vec_from(normals + 3 * c), b = vec_from(normals + 12 + 3 * c);
          sum = vec_add(sum, vec_mul(vec_add(vec_mul(a, frozen ? 1 : 1 - t), vec_mul(b, frozen ? 0 : t)), weight[c]));
        }
        want[frozen] = vec_unit(sum);
      }
      vec off = vec_sub(vec_from(normal + 3 * j), want[0]);
      CHECK(vec_length(off) < 2e-5, "time %g, pixel %u: normal off by %g", t, j, vec_length(off));
      CHECK(fabs((double)got[3 * j] - 0.8 * vec_dot(want[0], to_sun)) < 2e-5, "time %g, pixel %u: %g", t, j,
          (double)got[3 * j]);
      seen++, control += fabs((double)got[3 * j] - 0.8 * vec_dot(want[1], to_sun)) > 1e-3;
    }
  }
  CHECK(control > seen / 2, "the control: those of the first key would fail");
  pktrt_scene_destroy(scene);
}

/* --- the edge of the shadow on smooth bodies --- */

/* A ball of so many columns and half as many rows, with its own normals; its `size` is that of a model, which an
   instance shows at size 1. */
enum { BALL_VERTICES = 33 * 17 };
typedef struct smooth_ball {
  float positions[3 * BALL_VERTICES], normals[3 * BALL_VERTICES];
  uint32_t indices[6 * BALL_VERTICES];
} smooth_ball;
static void smooth_ball_make(smooth_ball *ball, uint32_t columns, float size, pktrt_mesh_desc *desc) {
  uint32_t rows = columns / 2, vertex = 0;

  memset(desc, 0, sizeof *desc);
  desc->positions = ball->positions;
  desc->normals = ball->normals;
  desc->indices = ball->indices;

  for (uint32_t j = 0; j <= rows; j++) {
    for (uint32_t i = 0; i <= columns; i++, vertex++) {
      double down = PI * j / rows, around = 2 * PI * i / columns;
      const uint32_t corner[6] = {
          vertex, vertex + 1, vertex + columns + 1, vertex + 1, vertex + columns + 2, vertex + columns + 1};
      vec_put(vec_of(sin(down) * cos(around), cos(down), sin(down) * sin(around)), ball->normals + 3 * vertex);
      for (uint32_t k = 0; k < 3; k++) ball->positions[3 * vertex + k] = size * ball->normals[3 * vertex + k];
      if (i == columns || j == rows) continue;
      memcpy(ball->indices + 3 * desc->triangle_count, corner, sizeof corner);
      desc->triangle_count += 2;
    }
  }

  desc->vertex_count = vertex;
}

/* A scene of such a ball, as an instance of half its size if `placed`, under a sun; and a wall across it, if its
   distance from the centre, in direction `up`, is not 0. */
static pktrt_scene *terminator_scene(uint32_t columns, bool placed, vec to_sun, vec up, double wall) {
  static smooth_ball ball;
  static const float twice[12] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0};
  pktrt_scene *scene = stage_open();
  pktrt_material white = material_of(1, PKTRT_SPECULAR_NONE, 0);
  pktrt_light sun = light_of(PKTRT_LIGHT_DIRECTIONAL, PI);
  pktrt_instance_desc instance;
  pktrt_mesh_desc desc;
  vec side = vec_unit(vec_cross(up, to_sun));
  quad across = quad_of(vec_mul(up, wall), vec_mul(side, 50), vec_mul(vec_cross(side, up), 50));

  smooth_ball_make(&ball, columns, placed ? 0.5f : 1, &desc);
  desc.material = stage_material(scene, &white);
  memset(&instance, 0, sizeof instance);
  instance.transforms = twice;
  pktrt_status added = placed ? pktrt_add_model(scene, &desc, 1, &instance.model) : pktrt_add_mesh(scene, &desc, NULL);
  if (placed && added == PKTRT_OK) added = pktrt_add_instance(scene, &instance, NULL);
  CHECK(added == PKTRT_OK, "%s", pktrt_last_error(scene));
  if (wall != 0) stage_quad(scene, &across, desc.material);
  vec_put(vec_mul(to_sun, -1), sun.direction);
  stage_light(scene, &sun);
  stage_commit(scene);

  return scene;
}

/* Of pixels that show the ball: */
typedef struct terminator {
  int lit;    /* the shading normal lights them by more than 2% */
  int black;  /* of these, */
  int away;   /* those whose triangle faces away from the sun */
  int behind; /* behind the wall */
  int leaks;  /* of these, those that are not black */
} terminator;
static terminator terminator_count(pktrt_scene *scene, pktrt_mode mode, vec to_sun, vec up, double wall, vec eye) {
  enum { EDGE = 96 };
  static float got[3 * EDGE * EDGE];
  terminator found = {0, 0, 0, 0, 0};
  pktrt_render_desc d = stage_view(mode, EDGE, EDGE, got, eye, vec_of(0, 0, 0));

  d.camera.fov_y = 28;
  stage_render(scene, &d);

  for (uint32_t i = 0; i < EDGE * EDGE; i++) {
    pktrt_ray ray;
    pktrt_hit hit;
    pktrt_surface_info at;
    if (!pktrt_camera_ray(&d.camera, EDGE, EDGE, i % EDGE + 0.5, i / EDGE + 0.5, NULL, 0, &ray)) continue;
    if (!pktrt_intersect(scene, &ray, &hit) || hit.mesh != 0) continue;
    pktrt_surface(scene, &ray, &hit, &at);
    bool lit = vec_dot(vec_from(at.shading_normal), to_sun) > 0.02, black = !(got[3 * i] > 0);
    bool behind = wall != 0 && vec_dot(vec_from(at.position), up) < wall - 1e-4;
    found.behind += behind;
    found.leaks += behind && !black;
    if (!lit || wall != 0) continue;
    found.lit++;
    found.black += black;
    found.away += vec_dot(vec_from(at.normal), to_sun) <= 0;
  }

  return found;
}

static void terminators(void) {
  int away = 0, behind = 0;

  for (uint32_t columns = 16; columns <= 32; columns += 16) {
    for (int i = 0; i < 6; i++) {
      vec to_sun = vec_unit(vec_of(1, 0.3 * i - 0.8, 0.7 - 0.25 * i));
      vec across = vec_unit(vec_cross(to_sun, vec_of(0.3, 1, -0.2)));
      vec up = vec_unit(vec_add(across, vec_mul(to_sun, 0.1)));
      double wall = i < 3 ? 0 : 0.95 + 0.01 * (i - 3);
      vec beside = vec_unit(vec_cross(up, vec_of(1, i, 0.5)));
      vec eye = i < 3 ? vec_of(i - 1, 1, 4) : vec_add(vec_mul(up, 0.9), vec_mul(beside, 4));
      pktrt_scene *scene = terminator_scene(columns, i % 3 == 1, to_sun, up, wall);
      terminator found = terminator_count(scene, i % 2 ? PKTRT_MODE_WRT : PKTRT_MODE_RCS, to_sun, up, wall, eye);
      CHECK(!found.black, "%u columns, sun %d: %d of %d lit pixels are black", columns, i, found.black, found.lit);
      CHECK(!found.leaks, "%u columns, sun %d: %d of %d pixels behind the wall are lit", columns, i, found.leaks,
          found.behind);
      away += found.away;
      behind += found.behind;
      pktrt_scene_destroy(scene);
    }
  }

  CHECK(away > 100, "the control: only %d lit pixels are of triangles that face away", away);
  CHECK(behind > 100, "the control: only %d pixels are behind a wall", behind);
  say("%d lit pixels of triangles that face away, none black; %d behind a wall, none lit", away, behind);
}

void suite_shading(void) {
  run("Fresnel reflectance of dielectrics is that of the exact formula", fresnel_dielectrics);
  run("Fresnel reflectance of conductors is that of the exact formula", fresnel_conductors);
  run("Fresnel reflectance of conductors is in [0,1] at all limits", fresnel_limits);
  run("coats, metals and glass reflect by Fresnel at every angle, from both sides", fresnel_pictures);
  run("DRT reflects and refracts by Fresnel in the mean", fresnel_chosen);
  run("mirrors reflect by the law of reflection, in RCS not at all", mirrors);
  run("what mirrors would send below the surface by smooth normals goes about the flat one", leaning_normals);
  run("a glass slab displaces a ray by the closed form, lets it go on parallel, and dims it by Beer's law", slabs);
  run("what lies within glass is dimmed on both ways", within_glass);
  run("a prism reflects totally beyond the critical angle only", prisms);
  run("the Phong lobe has the mean and the norm of its closed form", lobes);
  run("what has no lobe is the same whatever its lobe says", lobes_of_what_has_none);
  run("the naive mapping of the Phong lobe sends samples elsewhere than the careful one", mappings_differ);
  run("what the depth limit leaves out of a slab is a geometric series", residual);
  run("a texture changes albedo, reflectance and emission by position", textures);
  run("a shader replaces everything else", shaders);
  run("mirrors show what shaders say", shader_in_mirror);
  run("smooth normals are those of the ray's time", normals_in_time);
  run("smooth bodies are lit up to where their normals say, and nothing leaks through a wall", terminators);
}
