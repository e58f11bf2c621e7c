/* Lights behind glass: each counted once. What pktrt_render says of a spot of floor, by kind of light, what lies between,
   surface and shadows of glass, stands beside a path tracer in double precision that looks at every triangle. It follows
   the rule of examples/manual.md, "Lights", and shares nothing with the renderer but the closed forms of Fresnel. */
#include "pictures.h"
#include "stability.h"

enum { FACES = 400, BATCHES = 64, DEPTH = 50 };
typedef enum look { FLOOR, GLASS, MIRROR, PLATE, LAMP, SHEET, LOOKS } look;
typedef enum between {
  NOTHING,
  PANE,
  TWO_PANES,
  BALL,
  CUTOUT,
  CUTOUT_AND_PANE,
  MIRROR_BEHIND_PANE,
  PANE_BEHIND_LAMP,
  THIN_SHEET,
  SHEET_IN_PANE,
  BETWEENS
} between;
typedef enum surface { LOBE, IDEAL, COAT, METAL, SURFACES } surface;

static const char *const part = "lamps";
static const char *const between_name[BETWEENS] = {"nothing", "a pane", "two panes", "a ball", "a cutout",
    "a cutout and a pane", "a mirror behind a pane", "a pane that reflects", "a thin sheet", "a thin sheet in a pane"};
static const char *const surface_name[SURFACES] = {"lobe", "mirror", "coat", "metal"};
static const struct {
  const char *name;
  pktrt_light_kind kind;
  bool visible;
  float angle; /* of a sun */
} lamps[] = {{"point", PKTRT_LIGHT_POINT, false, 0}, {"directional", PKTRT_LIGHT_DIRECTIONAL, false, 0},
    {"quad", PKTRT_LIGHT_QUAD, false, 0}, {"visible quad", PKTRT_LIGHT_QUAD, true, 0},
    {"sphere", PKTRT_LIGHT_SPHERE, false, 0}, {"visible sphere", PKTRT_LIGHT_SPHERE, true, 0},
    {"mesh", PKTRT_LIGHT_MESH, false, 0}, {"environment", PKTRT_LIGHT_ENVIRONMENT, false, 0},
    {"sun", PKTRT_LIGHT_DIRECTIONAL, false, 5}, {"visible sun", PKTRT_LIGHT_DIRECTIONAL, true, 5}};

static const double glass_ior = 1.5;
static const double absorption[3] = {0.3, 0.8, 1.6};
static const double sheet_ior = 1.8, sheet_transmission = 0.75;
static const double sheet_tint[3] = {0.9, 0.6, 0.3};
static const double lamp_color[3] = {4, 3, 2};
static const double lamp_radius = 0.2;
static const double sun_distance = 1e6;

/* --- what is there --- */

typedef struct face {
  vec corner[3];
  look look;
} face;

/* A scene for both. */
typedef struct place {
  face face[FACES];
  int faces, first_of_lamp;
  pktrt_material material[LOOKS];
  pktrt_light light;
  quad lamp;
  vec middle; /* of the lamp */
  bool passes, sky;
} place;

static vec eye_place(void) { return vec_of(-0.3, 0.8, 0.1); }
static vec mirror_way(void) { return vec_unit(vec_of(0.3, 0.8, -0.1)); }

/* Returns the radiance of the environment from a direction. */
static double sky_at(vec d, int channel) {
  const double c = fmax(0, vec_dot(d, mirror_way()));
  return (0.2 + 3 * pow(c, 8)) * lamp_color[channel] / 4;
}

static void sky_hook(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const vec d = vec_of((double)direction[0][i], (double)direction[1][i], (double)direction[2][i]);
    for (int k = 0; k < 3; k++) radiance[k][i] = (float)sky_at(d, k);
  }
}

/* Tells whether the plate has a hole at a point: it is a checkerboard. */
static bool plate_is_clear(double x, double z) { return ((int)floor(4 * x + 0.37) + (int)floor(4 * z + 1.1)) % 2 == 0; }

static void plate_hook(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++)
    if (plate_is_clear((double)p->position[0][i], (double)p->position[2][i])) p->opacity[i] = 0;
}

/* Adds a mesh to the scene and to the faces of the place. Returns its index. */
static uint32_t place_mesh(place *x, pktrt_scene *s, mesh m, look l, uint32_t material) {
  const uint32_t index = stage_mesh(s, &m, material);
  for (uint32_t i = 0; i < m.nt && CHECK(x->faces < FACES, "too many faces"); i++) {
    face *f = &x->face[x->faces++];
    f->look = l;
    for (uint32_t c = 0; c < 3; c++) f->corner[c] = vec_from(m.p + 3 * m.i[3 * i + c]);
  }
  mesh_free(&m);
  return index;
}

static mesh sheet(double y, double half) {
  mesh m = mesh_grid(1, (float)half);
  mesh_shift(&m, 0, (float)y, 0);
  return m;
}

static mesh slab(double lo, double hi) {
  mesh m = mesh_box();
  mesh_place(&m, (float[3]){3, (float)(hi - lo) / 2, 3}, (float[3]){0, (float)(hi + lo) / 2, 0});
  return m;
}

static mesh lamp_mesh(const quad *q) {
  mesh m = mesh_of(4, 2);
  memcpy(m.i, (uint32_t[6]){0, 1, 2, 0, 2, 3}, 24);
  vec_put(quad_at(q, 0, 0), m.p), vec_put(quad_at(q, 1, 0), m.p + 3);
  vec_put(quad_at(q, 1, 1), m.p + 6), vec_put(quad_at(q, 0, 1), m.p + 9);
  return m;
}

static pktrt_material floor_of(surface kind) {
  static const float gold_n[3] = {0.17f, 0.42f, 1.4f}, gold_k[3] = {3.1f, 2.35f, 1.9f};
  pktrt_material m = material_of(0.2, PKTRT_SPECULAR_MIRROR, 0.5);
  if (kind == COAT) m = material_of(0.05, PKTRT_SPECULAR_COAT, 0);
  if (kind == METAL) m = material_of(0, PKTRT_SPECULAR_CONDUCTOR, 0.6);
  if (kind == COAT) m.ior[0] = 2.5f;
  if (kind == METAL) memcpy(m.ior, gold_n, sizeof gold_n), memcpy(m.extinction, gold_k, sizeof gold_k);
  if (kind != IDEAL) m.lobe = PKTRT_LOBE_PHONG, m.exponent = 60;
  return m;
}

/* Puts the light where the mirror direction of the spot leads: by way of a mirror, or of a pane's reflection, if there is
   one, and then the light shines up. */
static void place_light(place *x, size_t lamp, between b) {
  const double along = b == PANE_BEHIND_LAMP ? 1.625 : b == MIRROR_BEHIND_PANE ? 3.625 : 2.5;
  const bool up = b == PANE_BEHIND_LAMP || b == MIRROR_BEHIND_PANE;
  const double height = b == PANE_BEHIND_LAMP ? 0.7 : b == MIRROR_BEHIND_PANE ? 1.5 : 2;
  x->middle = vec_of(0.3 * along, height, -0.1 * along);
  x->lamp = quad_of(x->middle, vec_of(0.25, 0, 0), vec_of(0, 0, 0.2));
  if (up) x->lamp = quad_flipped(x->lamp);

  x->light = lamps[lamp].kind == PKTRT_LIGHT_QUAD ? quad_light(&x->lamp, 1) : light_of(lamps[lamp].kind, 1);
  for (int k = 0; k < 3; k++) x->light.intensity[k] = (float)lamp_color[k];
  if (lamps[lamp].kind >= PKTRT_LIGHT_MESH)
    for (int k = 0; k < 3; k++) x->light.intensity[k] = 1;
  if (lamps[lamp].kind != PKTRT_LIGHT_QUAD) vec_put(x->middle, x->light.position);
  vec_put(vec_mul(mirror_way(), -1), x->light.direction);
  x->light.radius = (float)lamp_radius;
  x->light.visible = lamps[lamp].visible;
  x->light.angle = lamps[lamp].angle;
  if (lamps[lamp].angle > 0) { /* irradiance for the radiance of the lamp */
    const double sine = sin((double)lamps[lamp].angle * PI / 180);
    for (int k = 0; k < 3; k++) x->light.intensity[k] = (float)(PI * sine * sine * lamp_color[k]);
  }
  x->sky = lamps[lamp].kind == PKTRT_LIGHT_ENVIRONMENT;
}

/* Builds the place and its scene. */
static pktrt_scene *place_open(place *x, size_t lamp, between b, surface kind, bool passes) {
  pktrt_scene *s = stage_open();
  uint32_t material[LOOKS];
  memset(x, 0, sizeof *x);
  x->passes = passes;
  x->material[FLOOR] = floor_of(kind);
  x->material[GLASS] = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  x->material[GLASS].ior[0] = (float)glass_ior;
  for (int k = 0; k < 3; k++) x->material[GLASS].absorption[k] = (float)absorption[k];
  x->material[MIRROR] = material_of(0, PKTRT_SPECULAR_MIRROR, 0.9);
  x->material[PLATE] = material_of(0.3, PKTRT_SPECULAR_NONE, 0);
  x->material[PLATE].cutout = true, x->material[PLATE].texture = plate_hook;
  x->material[LAMP] = lamp_of(1);
  for (int k = 0; k < 3; k++) x->material[LAMP].emission[k] = (float)lamp_color[k];
  x->material[SHEET] = material_of(0, PKTRT_SPECULAR_THIN, 0);
  x->material[SHEET].ior[0] = (float)sheet_ior, x->material[SHEET].transmission = (float)sheet_transmission;
  for (int k = 0; k < 3; k++) x->material[SHEET].albedo[k] = (float)sheet_tint[k];
  for (int k = 0; k < LOOKS; k++) material[k] = stage_material(s, &x->material[k]);

  place_light(x, lamp, b);
  place_mesh(x, s, sheet(0, 4), FLOOR, material[FLOOR]);
  if (b == PANE || b == TWO_PANES || (b >= CUTOUT_AND_PANE && b != THIN_SHEET))
    place_mesh(x, s, slab(1, 1.2), GLASS, material[GLASS]);
  if (b == TWO_PANES) place_mesh(x, s, slab(1.4, 1.5), GLASS, material[GLASS]);
  if (b == CUTOUT || b == CUTOUT_AND_PANE) place_mesh(x, s, sheet(1.6, 3), PLATE, material[PLATE]);
  if (b == MIRROR_BEHIND_PANE) place_mesh(x, s, sheet(2.2, 3), MIRROR, material[MIRROR]);
  if (b >= THIN_SHEET) place_mesh(x, s, sheet(1.1, 3), SHEET, material[SHEET]);
  if (b == BALL) {
    mesh ball = mesh_sphere(1, 0, 1);
    mesh_place(&ball, (float[3]){0.35f, 0.35f, 0.35f}, (float[3]){0.375f, 1, -0.125f});
    place_mesh(x, s, ball, GLASS, material[GLASS]);
  }
  x->first_of_lamp = x->faces;
  if (lamps[lamp].kind == PKTRT_LIGHT_MESH) x->light.mesh = place_mesh(x, s, lamp_mesh(&x->lamp), LAMP, material[LAMP]);
  stage_light(s, &x->light);
  stage_commit(s);
  return s;
}

/* --- the path tracer --- */

typedef struct walk {
  const place *x;
  rng r;
  double sum[3];
  double twice[3], never[3]; /* the same where lights are seen always, or never, for which a lobe has asked */
} walk;

static double unit_of(walk *w) { return ((double)rng_u32(&w->r) + 0.5) * 0x1p-32; }

typedef struct found {
  double t;
  int face;   /* -1: none */
  vec normal; /* by the corners */
} found;

/* Finds the nearest face before a distance, of the plate what is not clear. */
static found nearest(const place *x, vec o, vec d, double far_, int without) {
  found hit = {far_, -1, {0, 0, 0}};
  for (int i = 0; i < x->faces; i++) {
    const face *f = &x->face[i];
    const vec a = vec_sub(f->corner[1], f->corner[0]), b = vec_sub(f->corner[2], f->corner[0]);
    const vec p = vec_cross(d, b);
    const double det = vec_dot(a, p);
    if (i == without || fabs(det) < 1e-14) continue;
    const vec from = vec_sub(o, f->corner[0]), q = vec_cross(from, a);
    const double u = vec_dot(from, p) / det, v = vec_dot(d, q) / det, t = vec_dot(b, q) / det;
    if (u < 0 || v < 0 || u + v > 1 || t < 1e-9 || t >= hit.t) continue;
    if (f->look == PLATE && plate_is_clear(o.x + t * d.x, o.z + t * d.z)) continue;
    hit.t = t, hit.face = i, hit.normal = vec_cross(a, b);
  }
  if (hit.face >= 0) hit.normal = vec_unit(hit.normal);
  return hit;
}

/* Multiplies by what a length of glass leaves. */
static void dim(double value[3], double length) {
  for (int k = 0; k < 3; k++) value[k] *= exp(-absorption[k] * length);
}

/* Returns what both faces of a thin sheet reflect, by adding up what goes back and forth between them. */
static double sheet_reflects(double cosine) {
  const double r = fresnel_exact(cosine, sheet_ior);
  double sum = r, inside = (1 - r) * r;

  for (int i = 0; i < 200; i++, inside *= r * r) sum += inside * (1 - r);
  return sum;
}

/* Multiplies by what arrives along a straight way of unit direction; it starts within glass or not. */
static void pass(const place *x, vec o, vec d, double far_, int without, bool within, double value[3]) {
  for (;;) {
    const found hit = nearest(x, o, d, far_, without);
    if (within) dim(value, hit.face < 0 ? far_ : hit.t);
    if (hit.face < 0) return;
    const look looks = x->face[hit.face].look;
    const double cosine = fabs(vec_dot(d, hit.normal));
    if (!x->passes || (looks != GLASS && looks != SHEET)) {
      memset(value, 0, 3 * sizeof *value);
      return;
    }
    for (int k = 0; k < 3; k++) {
      if (looks == SHEET) value[k] *= (1 - sheet_reflects(cosine)) * sheet_transmission * sheet_tint[k];
      else value[k] *= 1 - fresnel_exact(cosine, glass_ior);
    }
    if (looks == GLASS) within = vec_dot(d, hit.normal) < 0;
    o = vec_add(o, vec_mul(d, hit.t)), far_ -= hit.t, without = hit.face;
  }
}

/* Returns how far away the quad, the sphere or the sun is, or INFINITY. */
static double lamp_ahead(const place *x, vec o, vec d) {
  if (x->light.angle > 0)
    return vec_dot(d, mirror_way()) > cos((double)x->light.angle * PI / 180) ? sun_distance : INFINITY;
  if (x->light.kind == PKTRT_LIGHT_QUAD) {
    const vec n = vec_cross(x->lamp.edge[0], x->lamp.edge[1]);
    const double facing = vec_dot(n, d);
    if (facing >= 0) return INFINITY;
    const double t = vec_dot(n, vec_sub(x->lamp.corner, o)) / facing;
    const vec at = vec_sub(vec_add(o, vec_mul(d, t)), x->lamp.corner);
    const double u = vec_dot(at, x->lamp.edge[0]) / vec_dot(x->lamp.edge[0], x->lamp.edge[0]);
    const double v = vec_dot(at, x->lamp.edge[1]) / vec_dot(x->lamp.edge[1], x->lamp.edge[1]);
    return t > 0 && u >= 0 && u <= 1 && v >= 0 && v <= 1 ? t : INFINITY;
  }
  if (x->light.kind != PKTRT_LIGHT_SPHERE) return INFINITY;
  const vec to = vec_sub(x->middle, o);
  const double along = vec_dot(to, d), rest = lamp_radius * lamp_radius - vec_dot(to, to) + along * along;
  return along > 0 && rest > 0 ? along - sqrt(rest) : INFINITY; /* no way starts within */
}

static vec around(vec axis, double cosine, double turn) {
  const vec side = vec_unit(vec_cross(axis, fabs(axis.x) > 0.5 ? vec_of(0, 1, 0) : vec_of(1, 0, 0)));
  const double sine = sqrt(fmax(0, 1 - cosine * cosine));
  const vec p = vec_mul(side, sine * cos(turn)), q = vec_mul(vec_cross(axis, side), sine * sin(turn));
  return vec_add(vec_add(p, q), vec_mul(axis, cosine));
}

typedef struct spot {
  vec p, normal, axis;
  int face;
  double albedo[3], lobe[3]; /* lobe: weight; 0 without */
  double exponent;
  bool within; /* glass */
} spot;

/* Adds to all sums. */
static void gain(walk *w, const double weight[3], const double value[3]) {
  for (int k = 0; k < 3; k++) {
    const double more = weight[k] * value[k];
    w->sum[k] += more, w->twice[k] += more, w->never[k] += more;
  }
}

/* Draws a point of the light, or a direction of the environment, for the diffuse part; a point or direction for the lobe
   too. Adds what it brings. */
static void ask_light(walk *w, const spot *s, const double weight[3]) {
  const place *x = w->x;
  const pktrt_light_kind kind = x->light.kind;
  double value[3], far_ = INFINITY, share = 1; /* share: radiance times solid angle per its density */
  vec to = mirror_way();
  memcpy(value, lamp_color, sizeof value);
  if (kind == PKTRT_LIGHT_ENVIRONMENT) {
    to = around(s->normal, sqrt(unit_of(w)), 2 * PI * unit_of(w)), share = PI / vec_dot(to, s->normal);
    for (int k = 0; k < 3; k++) value[k] = sky_at(to, k);
  } else if (x->light.angle > 0) {
    const double rise = 1 - cos((double)x->light.angle * PI / 180);
    to = around(mirror_way(), 1 - rise * unit_of(w), 2 * PI * unit_of(w)), share = 2 * PI * rise;
  } else if (kind != PKTRT_LIGHT_DIRECTIONAL) {
    const double u = unit_of(w), v = unit_of(w);
    const vec out = around(vec_of(0, 1, 0), 2 * u - 1, 2 * PI * v), n = vec_cross(x->lamp.edge[0], x->lamp.edge[1]);
    const vec at = kind == PKTRT_LIGHT_POINT    ? x->middle
                   : kind == PKTRT_LIGHT_SPHERE ? vec_add(x->middle, vec_mul(out, lamp_radius))
                                                : quad_at(&x->lamp, u, v);
    to = vec_sub(at, s->p), far_ = vec_length(to), to = vec_unit(to), share = 1 / (far_ * far_);
    if (kind == PKTRT_LIGHT_SPHERE) share *= fmax(0, -vec_dot(out, to)) * 4 * PI * lamp_radius * lamp_radius;
    if (kind == PKTRT_LIGHT_QUAD) share *= fmax(0, -vec_dot(n, to));
    if (kind == PKTRT_LIGHT_MESH) share *= fabs(vec_dot(n, to));
  }
  const double cosine = vec_dot(to, s->normal), axial = vec_dot(to, s->axis);
  const bool point = kind == PKTRT_LIGHT_POINT || (kind == PKTRT_LIGHT_DIRECTIONAL && x->light.angle <= 0);
  const double lobe = point && axial > 0 ? (s->exponent + 1) / (2 * PI) * pow(axial, s->exponent) : 0;
  if (cosine <= 0 || share <= 0) return;
  pass(x, s->p, to, far_ * (1 - 1e-6), s->face, s->within, value); /* less: corners of a mesh are floats */
  for (int k = 0; k < 3; k++) value[k] *= share * (s->albedo[k] / PI * cosine + s->lobe[k] * lobe);
  gain(w, weight, value);
}

/* Finds reflectances of a surface that is not glass. Returns whether it reflects at all. */
static bool spot_read(const pktrt_material *m, double cosine, spot *s) {
  double most = 0;
  for (int k = 0; k < 3; k++) {
    const double f = fresnel_exact(cosine, (double)m->ior[0] > 0 ? (double)m->ior[0] : 1.5);
    s->albedo[k] = (double)m->albedo[k], s->lobe[k] = 0;
    if (m->specular == PKTRT_SPECULAR_THIN) s->albedo[k] = 1; /* the rest has been counted */
    if (m->specular == PKTRT_SPECULAR_MIRROR) s->lobe[k] = (double)m->reflectance[k];
    if (m->specular == PKTRT_SPECULAR_COAT) s->lobe[k] = f, s->albedo[k] *= 1 - f;
    if (m->specular == PKTRT_SPECULAR_CONDUCTOR)
      s->lobe[k] = (double)m->reflectance[k] * conductor_exact(cosine, (double)m->ior[k], (double)m->extinction[k]);
    most = fmax(most, s->lobe[k]);
  }
  s->exponent = (double)m->exponent;
  return most > 0;
}

/* Adds a light that a ray meets at the end of its way. asked: a lobe has asked for it; bent: by glass since then. */
static void meet_lamp(walk *w, const double weight[3], bool asked, bool bent) {
  const bool sees = !asked || (bent && !w->x->passes);
  for (int k = 0; k < 3; k++) {
    const double more = weight[k] * lamp_color[k];
    w->sum[k] += sees ? more : 0;
    w->twice[k] += !asked || bent ? more : 0;
    w->never[k] += !asked ? more : 0;
  }
}

/* Follows one path from the eye. */
static void follow(walk *w) {
  const place *x = w->x;
  double weight[3] = {1, 1, 1};
  vec o = eye_place(), d = vec_unit(vec_mul(o, -1));
  bool asked = false, bent = false, within = false;
  int without = -1;
  for (int depth = 0; depth <= DEPTH && fmax(weight[0], fmax(weight[1], weight[2])) > 1e-7; depth++) {
    const double lamp = x->light.visible ? lamp_ahead(x, o, d) : INFINITY;
    const found hit = nearest(x, o, d, INFINITY, without);
    if (within) dim(weight, fmin(hit.t, lamp));
    if (lamp < hit.t) {
      meet_lamp(w, weight, asked, bent);
      return;
    }
    if (hit.face < 0) {
      const double sky[3] = {sky_at(d, 0), sky_at(d, 1), sky_at(d, 2)};
      if (x->sky) gain(w, weight, sky);
      return;
    }

    const look looks = x->face[hit.face].look;
    const bool inside = vec_dot(d, hit.normal) > 0;
    const vec normal = inside ? vec_mul(hit.normal, -1) : hit.normal;
    const double cosine = -vec_dot(d, normal);
    o = vec_add(o, vec_mul(d, hit.t)), without = hit.face;
    if (looks == LAMP) {
      gain(w, weight, lamp_color);
      return;
    }
    if (looks == GLASS) {
      const double eta = inside ? 1 / glass_ior : glass_ior;
      vec behind = d;
      const bool reflects = unit_of(w) < fresnel_exact(cosine, eta) || !refracted(d, normal, eta, &behind);
      if (reflects) asked = false, d = reflected(d, normal);
      else bent = true, d = vec_unit(behind);
      within = reflects ? inside : !inside;
      continue;
    }
    if (looks == SHEET) {
      const bool reflects = unit_of(w) < sheet_reflects(cosine);
      const bool straight = unit_of(w) < sheet_transmission;
      if (reflects) asked = false, d = reflected(d, normal);
      else
        for (int k = 0; k < 3; k++) weight[k] *= sheet_tint[k];
      if (reflects) continue;
      bent = true; /* a shadow ray stands for it as behind glass */
      if (straight) continue;
    }

    spot s = {o, normal, vec_unit(reflected(d, normal)), hit.face, {0, 0, 0}, {0, 0, 0}, 0, within};
    const bool reflects = spot_read(&x->material[looks], cosine, &s);
    const bool lobed = reflects && x->material[looks].lobe == PKTRT_LOBE_PHONG;
    spot plain = s;
    if (!lobed) memset(plain.lobe, 0, sizeof plain.lobe);
    ask_light(w, &plain, weight);
    if (!reflects) return;
    d = s.axis;
    if (lobed) d = around(s.axis, pow(unit_of(w), 1 / (s.exponent + 1)), 2 * PI * unit_of(w));
    if (vec_dot(d, normal) <= 0) return;
    for (int k = 0; k < 3; k++) weight[k] *= s.lobe[k];
    const double straight = lamp_ahead(x, o, d);
    if (lobed && straight < INFINITY) {
      double value[3];
      memcpy(value, lamp_color, sizeof value);
      pass(x, o, d, straight, without, within, value);
      gain(w, weight, value);
    }
    asked = lobed, bent = false;
  }
}

typedef struct expected {
  estimate right, twice, never;
} expected;

static void estimate_add(estimate *e, const double sum[3], size_t n) {
  for (int k = 0; k < 3; k++) e->mean[k] += sum[k] / (double)n, e->error[k] += sum[k] * sum[k] / (double)(n * n);
}
static void estimate_end(estimate *e) {
  for (int k = 0; k < 3; k++) {
    e->mean[k] /= BATCHES;
    e->error[k] = sqrt(fmax(e->error[k] / BATCHES - e->mean[k] * e->mean[k], 0) / (BATCHES - 1));
  }
}

static expected expect(const place *x, size_t paths, uint64_t seed) {
  expected e;
  memset(&e, 0, sizeof e);
  for (uint64_t b = 0; b < BATCHES; b++) {
    walk w;
    memset(&w, 0, sizeof w);
    w.x = x, w.r = rng_of(seed * BATCHES + b);
    for (size_t i = 0; i < paths; i++) follow(&w);
    estimate_add(&e.right, w.sum, paths), estimate_add(&e.twice, w.twice, paths),
        estimate_add(&e.never, w.never, paths);
  }
  estimate_end(&e.right), estimate_end(&e.twice), estimate_end(&e.never);
  return e;
}

/* --- the table --- */

static bool differ(const estimate *a, const estimate *b) {
  bool apart = false;
  for (int k = 0; k < 3; k++) {
    const double error = sqrt(a->error[k] * a->error[k] + b->error[k] * b->error[k]);
    apart = apart || !(fabs(a->mean[k] - b->mean[k]) <= 4 * error + 1e-4 * b->mean[k] + 1e-5); /* NaN is apart */
  }
  return apart;
}

typedef struct lamp_sums {
  size_t compared, beyond, twice, never;
} lamp_sums;

/* Renders one entry of the table by each choice of lights, in a short run by one of them, and compares it. */
static void compare(size_t lamp, between b, surface kind, bool passes, size_t paths, lamp_sums *sums) {
  static const char *const choices[3] = {"all", "one deeper", "one"};
  place *x = malloc(sizeof *x);
  if (!x) abort();
  pktrt_scene *s = place_open(x, lamp, b, kind, passes);
  const expected want = expect(x, paths, ((lamp * BETWEENS + b) * SURFACES + kind) * 2 + passes);
  for (int choice = 0; choice < 3; choice++) {
    if (thoroughness < 1 && choice != ((int)kind + (int)b) % 3) continue;
    pktrt_render_desc d = stage_spot(eye_place(), vec_of(0, 0, 0));
    d.camera.fov_y = 1e-3f, d.width = d.height = 1, d.samples = (uint32_t)paths, d.branching = PKTRT_BRANCHING_CHOOSE;
    d.lights = choice == 0 ? PKTRT_LIGHTS_ALL : choice == 1 ? PKTRT_LIGHTS_ONE_DEEPER : PKTRT_LIGHTS_ONE;
    d.glass_shadows = passes ? PKTRT_GLASS_SHADOWS_PASS : PKTRT_GLASS_SHADOWS_BLOCK;
    if (x->sky) d.environment = sky_hook;
    const estimate got = stage_estimate(s, &d, BATCHES);
    const bool beyond = differ(&got, &want.right);
    CHECK(!beyond, "%s, %s between, %s, shadows %s, %s: %.5f +- %.5f, not %.5f +- %.5f", lamps[lamp].name,
        between_name[b], surface_name[kind], passes ? "pass" : "block", choices[choice], got.mean[0], got.error[0],
        want.right.mean[0], want.right.error[0]);
    sums->compared++, sums->beyond += beyond;
    sums->twice += differ(&got, &want.twice), sums->never += differ(&got, &want.never);
  }
  pktrt_scene_destroy(s);
  free(x);
}

/* All entries of one kind of light; in a short run some of them. */
static void lamp_job(void *arg, size_t lamp) {
  static const char *const wrong = "means beyond 4 standard errors";
  const size_t paths = 16 + thorough(1500);
  lamp_sums sums = {0, 0, 0, 0};
  (void)arg;
  for (size_t i = 0; i < (size_t)BETWEENS * SURFACES * 2; i++) {
    const between b = (between)(i / (SURFACES * 2));
    const surface kind = (surface)(i / 2 % SURFACES);
    if (thoroughness < 1 && (i + lamp) % ((lamps[lamp].visible ? 5u : 13u) * (small_run ? 3u : 1u))) continue;
    compare(lamp, b, kind, i % 2, paths, &sums);
  }
  count_figure(part, lamps[lamp].name, PKTRT_ISA_AUTO, sums.compared, wrong, sums.beyond);
  if (!lamps[lamp].visible) return;
  control_figure(part, lamps[lamp].name, wrong, "lobes meet asked lights", sums.compared, sums.twice);
  control_figure(part, lamps[lamp].name, wrong, "lobes meet no lights", sums.compared, sums.never);
}

static void lights_behind_glass(void) { jobs_for(COUNT(lamps), lamp_job, NULL); }

enum { SIDE = 48, VALUES = SIDE * SIDE * 3 };

/* Renders a floor with a lobe below a pane and a quad in WRT; with_mirror: a sheet on the floor is an ideal mirror. */
static void render_below_pane(bool visible, bool passes, bool with_mirror, pktrt_assembly assembly, float *pixels) {
  place *x = malloc(sizeof *x);
  if (!x) abort();
  pktrt_scene *s = place_open(x, visible ? 3 : 2, PANE, LOBE, passes);
  if (with_mirror) {
    place_mesh(x, s, sheet(0.01, 0.05), MIRROR, stage_material(s, &x->material[MIRROR]));
    stage_commit(s);
  }
  pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, SIDE, SIDE, pixels, eye_place(), vec_of(0, 0, 0));
  d.max_depth = 3, d.assembly = assembly; /* no ray leaves the pane that was reflected in it */
  d.glass_shadows = passes ? PKTRT_GLASS_SHADOWS_PASS : PKTRT_GLASS_SHADOWS_BLOCK;
  stage_render(s, &d);
  pktrt_scene_destroy(s);
  free(x);
}

static uint64_t values_apart(const float *p, const float *q) {
  uint64_t n = 0;
  for (int i = 0; i < VALUES; i++) n += !same_bits(p + i, q + i, sizeof *p);
  return n;
}

/* Behind a pane that shadow rays pass, a lamp that is visible adds nothing to a floor with a lobe; behind one that stops
   them it does. With a mirror on the floor some rays of a wave see lamps and others do not: whatever order they are
   traced in, the picture has the same bits. */
static void lamps_without_chance(void) {
  float hidden[VALUES], seen[VALUES], other[VALUES];
  for (int passes = 0; passes < 2; passes++) {
    render_below_pane(false, passes, false, PKTRT_ASSEMBLY_RAY_TYPES, hidden);
    render_below_pane(true, passes, false, PKTRT_ASSEMBLY_RAY_TYPES, seen);
    const uint64_t more = values_apart(hidden, seen);
    say("shadows %s: %llu values differ", passes ? "pass" : "block", (unsigned long long)more);
    CHECK(passes ? more == 0 : more > 0, "shadows %s: %llu values differ", passes ? "pass" : "block",
        (unsigned long long)more);

    render_below_pane(false, passes, true, PKTRT_ASSEMBLY_RAY_TYPES, hidden);
    render_below_pane(true, passes, true, PKTRT_ASSEMBLY_RAY_TYPES, seen);
    CHECK(values_apart(hidden, seen) > 0, "the control: the mirror shows the lamp");
    for (int assembly = 0; assembly <= PKTRT_ASSEMBLY_NONE; assembly++) {
      render_below_pane(true, passes, true, (pktrt_assembly)assembly, other);
      CHECK(values_apart(seen, other) == 0, "shadows %s, assembly %d: %llu values differ", passes ? "pass" : "block",
          assembly, (unsigned long long)values_apart(seen, other));
    }
  }
}

void suite_stability_lamps(void) {
  run("a lamp that shadow rays reach through a pane is not seen again by the lobe, in any order of rays",
      lamps_without_chance);
  run("stable: a light is counted once, whatever glass lies between it and a lobe", lights_behind_glass);
}
