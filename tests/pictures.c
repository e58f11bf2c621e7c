/* Pictures: lens, shutter, structure of the ray tree, hooks, buffers; the same bits whatever the settings; memory. */
#include "pictures.h"
#include "stability.h"

/* --- stages --- */

quad quad_of(vec middle, vec half0, vec half1) {
  quad q = {vec_sub(vec_sub(middle, half0), half1), {vec_mul(half0, 2), vec_mul(half1, 2)}};
  return q;
}

quad quad_flipped(quad q) {
  quad f = {q.corner, {q.edge[1], q.edge[0]}};
  return f;
}

vec quad_at(const quad *q, double a, double b) {
  return vec_add(q->corner, vec_add(vec_mul(q->edge[0], a), vec_mul(q->edge[1], b)));
}

pktrt_scene *stage_open(void) {
  pktrt_scene_desc d = scene_desc_of(PKTRT_ISA_AUTO, 0);
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!CHECK(s != NULL, "%s", pktrt_last_error(NULL))) abort();
  return s;
}

void stage_commit(pktrt_scene *s) { CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s)); }

uint32_t stage_material(pktrt_scene *s, const pktrt_material *m) {
  uint32_t index = 0;
  CHECK(pktrt_add_material(s, m, &index) == PKTRT_OK && index > 0, "%s", pktrt_last_error(s));
  return index;
}

uint32_t stage_mesh(pktrt_scene *s, const mesh *m, uint32_t material) {
  pktrt_mesh_desc d = mesh_desc(m);
  uint32_t index = PKTRT_NONE;
  d.material = material;
  CHECK(pktrt_add_mesh(s, &d, &index) == PKTRT_OK, "%s", pktrt_last_error(s));
  return index;
}

uint32_t stage_quad(pktrt_scene *s, const quad *q, uint32_t material) {
  static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
  mesh m = mesh_of(4, 2);
  for (int k = 0; k < 4; k++) vec_put(quad_at(q, k == 1 || k == 2, k >= 2), m.p + 3 * k);
  memcpy(m.i, corners, sizeof corners);
  uint32_t index = stage_mesh(s, &m, material);
  mesh_free(&m);
  return index;
}

void stage_light(pktrt_scene *s, const pktrt_light *l) {
  CHECK(pktrt_add_light(s, l, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
}

pktrt_material material_of(double albedo, pktrt_specular specular, double reflectance) {
  pktrt_material m;
  memset(&m, 0, sizeof m);
  m.specular = specular;
  for (int k = 0; k < 3; k++) m.albedo[k] = (float)albedo, m.reflectance[k] = (float)reflectance;
  return m;
}

pktrt_material lamp_of(double emission) {
  pktrt_material m = material_of(0, PKTRT_SPECULAR_NONE, 0);
  for (int k = 0; k < 3; k++) m.emission[k] = (float)emission;
  return m;
}

pktrt_light light_of(pktrt_light_kind kind, double intensity) {
  pktrt_light l;
  memset(&l, 0, sizeof l);
  l.kind = kind;
  for (int k = 0; k < 3; k++) l.intensity[k] = (float)intensity;
  return l;
}

pktrt_light quad_light(const quad *q, double intensity) {
  pktrt_light l = light_of(PKTRT_LIGHT_QUAD, intensity);
  vec_put(q->corner, l.position), vec_put(q->edge[0], l.edge[0]), vec_put(q->edge[1], l.edge[1]);
  return l;
}

pktrt_render_desc stage_view(pktrt_mode mode, uint32_t w, uint32_t h, float *pixels, vec eye, vec target) {
  pktrt_render_desc d;
  memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = w, d.height = h, d.pixels = pixels, d.mode = mode;
  vec_put(eye, d.camera.eye), vec_put(target, d.camera.target);
  vec view = vec_unit(vec_sub(target, eye));
  if (fabs(view.y) > 0.9) d.camera.up[2] = -1;
  d.attenuation = -1;
  return d;
}

void stage_render(pktrt_scene *s, const pktrt_render_desc *d) {
  CHECK(pktrt_render(s, d) == PKTRT_OK, "%s", pktrt_last_error(s));
}

float *stage_pixels(size_t floats) {
  float *p = malloc(floats * sizeof *p);
  if (!p) abort();
  for (size_t i = 0; i < floats; i++) p[i] = -7;
  return p;
}

vec stage_through(const pktrt_camera *c, double x, double y, double width, double height) {
  vec forward = vec_unit(vec_sub(vec_from(c->target), vec_from(c->eye))), up = vec_from(c->up);
  if (vec_dot(up, up) == 0) up.y = 1;
  vec right = vec_unit(vec_cross(forward, up)), above = vec_cross(right, forward);
  double h = tan((c->fov_y > 0 ? (double)c->fov_y : 45) * PI / 360);
  vec off = vec_add(vec_mul(right, (2 * x / width - 1) * h * width / height), vec_mul(above, (1 - 2 * y / height) * h));
  return vec_unit(vec_add(forward, off));
}

/* --- estimates --- */

enum { SPOT = 8 };

pktrt_render_desc stage_spot(vec eye, vec target) {
  pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, SPOT, SPOT, NULL, eye, target);
  d.camera.fov_y = 0.02f;
  d.samples = 16;
  return d;
}

estimate stage_estimate(pktrt_scene *s, const pktrt_render_desc *view, int seeds) {
  estimate e;
  double sum[3] = {0, 0, 0}, squares[3] = {0, 0, 0};
  size_t n = (size_t)view->width * view->height;
  pktrt_render_desc d = *view;
  d.pixels = stage_pixels(n * 3);
  if (small_run) d.samples = (d.samples + 7) / 8;
  for (int i = 0; i < seeds; i++) {
    d.seed = (uint32_t)mix64((uint64_t)i + (run_seed << 32));
    stage_render(s, &d);
    for (int k = 0; k < 3; k++) {
      double mean = 0;
      for (size_t j = 0; j < n; j++) mean += (double)d.pixels[3 * j + (size_t)k] / (double)n;
      sum[k] += mean, squares[k] += mean * mean;
    }
  }
  for (int k = 0; k < 3; k++) {
    e.mean[k] = sum[k] / seeds;
    e.error[k] = sqrt(fmax(squares[k] / seeds - e.mean[k] * e.mean[k], 0) / (seeds - 1));
  }
  free(d.pixels);
  return e;
}

bool agrees(const estimate *e, int channel, double want) {
  return fabs(e->mean[channel] - want) <= 4 * e->error[channel] + 1e-5;
}

void check_estimate(const char *name, const estimate *e, double want, double control, double precision) {
  CHECK(agrees(e, 0, want), "%s: %.6f +- %.6f, not %.6f", name, e->mean[0], e->error[0], want);
  if (small_run) return; /* too few samples for the rest */
  CHECK(!agrees(e, 0, control), "%s: %.6f +- %.6f could as well be %.6f", name, e->mean[0], e->error[0], control);
  CHECK(e->error[0] <= precision * fabs(want) + 1e-6, "%s: %.6f +- %.6f is not precise", name, e->mean[0], e->error[0]);
}

/* --- closed forms --- */

double fresnel_exact(double c, double eta) {
  double sine2 = (1 - c * c) / (eta * eta);
  if (sine2 >= 1) return 1;
  double t = sqrt(1 - sine2), s = (c - eta * t) / (c + eta * t), p = (eta * c - t) / (eta * c + t);
  return (s * s + p * p) / 2;
}

/* |a + ib|^2 / |c + id|^2 */
static double ratio2(double a, double b, double c, double d) { return (a * a + b * b) / (c * c + d * d); }

/* The same amplitudes with the complex index m = eta + ik: t = sqrt(1 - sin^2 / m^2), s = (c - m t) / (c + m t),
   p = (m c - t) / (m c + t). */
double conductor_exact(double c, double eta, double k) {
  double re = eta * eta - k * k, im = 2 * eta * k, norm = re * re + im * im, sine2 = 1 - c * c;
  double a = 1 - sine2 * re / norm, b = sine2 * im / norm, r = sqrt(a * a + b * b);
  double tr = sqrt(fmax(r + a, 0) / 2), ti = sqrt(fmax(r - a, 0) / 2);
  double mr = eta * tr - k * ti, mi = eta * ti + k * tr; /* m t */
  double s = ratio2(c - mr, -mi, c + mr, mi), p = ratio2(eta * c - tr, k * c - ti, eta * c + tr, k * c + ti);
  return (s + p) / 2;
}

vec reflected(vec d, vec n) { return vec_sub(d, vec_mul(n, 2 * vec_dot(d, n))); }

bool refracted(vec d, vec n, double eta, vec *out) {
  double c = -vec_dot(d, n), sine2 = (1 - c * c) / (eta * eta);
  if (sine2 >= 1) return false;
  *out = vec_add(vec_mul(d, 1 / eta), vec_mul(n, c / eta - sqrt(1 - sine2)));
  return true;
}

double form_factor(vec p, vec n, const vec *corner, int count) {
  double sum = 0;
  for (int i = 0; i < count; i++) {
    vec a = vec_unit(vec_sub(corner[i], p)), b = vec_unit(vec_sub(corner[(i + 1) % count], p)), c = vec_cross(a, b);
    double sine = vec_length(c);
    if (sine > 0) sum += atan2(sine, vec_dot(a, b)) * vec_dot(n, c) / sine;
  }
  return fabs(sum) / (2 * PI);
}

double quad_form_factor(vec p, vec n, const quad *q) {
  vec corner[4] = {quad_at(q, 0, 0), quad_at(q, 1, 0), quad_at(q, 1, 1), quad_at(q, 0, 1)};
  return form_factor(p, n, corner, 4);
}

/* Mean of cos(alpha)^power over the part of the lobe above the surface, times its share; axis at an angle to the
   normal. For each alpha, the part of the circle above the surface has cos(angle) cos(alpha) + sin(angle) sin(alpha)
   cos(phi) > 0. */
double lobe_moment(double exponent, double angle, int power) {
  const int steps = 50000;
  double sum = 0;
  for (int i = 0; i < steps; i++) { /* u = cos^(exponent + 1) is uniform */
    double c = pow((i + 0.5) / steps, 1 / (exponent + 1)), s = sqrt(1 - c * c);
    double x = cos(angle) * c, y = sin(angle) * s;
    double share = x >= y ? 1 : acos(-x / y) / PI;
    sum += share * (power ? c : 1);
  }
  return sum / steps;
}

/* --- the lens --- */

enum { LENS = 40 };

/* A bright square of half a side at a distance on the axis of a camera at the origin that looks along -z. */
static pktrt_scene *dot_open(double distance, double half) {
  pktrt_scene *s = stage_open();
  pktrt_material lamp = lamp_of(1);
  quad q = quad_of(vec_of(0, 0, -distance), vec_of(half, 0, 0), vec_of(0, half, 0));
  stage_quad(s, &q, stage_material(s, &lamp));
  stage_commit(s);
  return s;
}

/* A picture whose sides are `across` long at a distance. */
static pktrt_render_desc lens_view(pktrt_mode mode, float *pixels, double across, double distance) {
  pktrt_render_desc d = stage_view(mode, LENS, LENS, pixels, vec_of(0, 0, 0), vec_of(0, 0, -1));
  d.camera.fov_y = (float)(atan(across / 2 / distance) * 360 / PI);
  d.samples = mode == PKTRT_MODE_DRT ? 64 : 1;
  return d;
}

/* Every ray through a pixel meets the others in the plane of focus f; at distance z they fill a disk of diameter
   aperture |z - f| / f. So a small square shows as a disk of that diameter, in the plane of the square: its second
   moment is that of a uniform disk, r^2 / 4, of a square, side^2 / 12, and of a pixel, and nothing shines beyond. */
static void blur_disk(double z, double focus, double aperture) {
  const double across = 0.44, half = 0.02, pixel = across / LENS, r = aperture * fabs(z - focus) / focus / 2;
  float *got = stage_pixels(LENS * LENS * 3);
  pktrt_scene *s = dot_open(z, half);
  pktrt_render_desc d = lens_view(PKTRT_MODE_DRT, got, across, z);
  d.camera.aperture = (float)aperture, d.camera.focus = (float)focus, d.samples = 1024;
  stage_render(s, &d);
  double sum = 0, xx = 0, yy = 0, xy = 0, x1 = 0, y1 = 0, inner = 0, farthest = 0;
  for (int i = 0; i < LENS * LENS; i++) {
    double v = (double)got[3 * i], x = (i % LENS + 0.5 - LENS / 2.) * pixel, y = (LENS / 2. - i / LENS - 0.5) * pixel;
    sum += v, xx += v * x * x, yy += v * y * y, xy += v * x * y, x1 += v * x, y1 += v * y;
    if (x * x + y * y < r * r / 2) inner += v;
    if (v > 0) farthest = fmax(farthest, sqrt(x * x + y * y));
  }
  double want = r * r / 4 + half * half / 3 + pixel * pixel / 12;
  say("square at %g, focus at %g: radius %.4f, by moments %.4f and %.4f, the farthest light at %.4f", z, focus, r,
      2 * sqrt(xx / sum - want + r * r / 4), 2 * sqrt(yy / sum - want + r * r / 4), farthest);
  CHECK(fabs(xx / sum / want - 1) < 0.03 && fabs(yy / sum / want - 1) < 0.03, "moments %g, %g, not %g", xx / sum,
      yy / sum, want);
  CHECK(fabs(xx / sum / (want * 1.21) - 1) > 0.1, "the control: a tenth more would fail");
  CHECK(fabs(xy / sum) < 0.03 * want && fabs(x1 / sum) < 0.02 * r && fabs(y1 / sum) < 0.02 * r,
      "round and in the middle");
  CHECK(fabs(inner / sum - 0.5) < 0.05, "uniform: half the light within half the area: %g", inner / sum);
  CHECK(farthest < r + 1.5 * half + pixel && farthest > 0.93 * r, "light as far as %g", farthest);
  CHECK(fabs(sum * pixel * pixel / (4 * half * half) - 1) < 0.03, "as much light as without a lens: %g",
      sum * pixel * pixel / (4 * half * half));
  pktrt_scene_destroy(s);
  free(got);
}

static void lens_blur(void) {
  blur_disk(6, 4, 0.6);
  if (small_run) return;
  blur_disk(6, 9, 0.6);
  blur_disk(6, 4, 0.35);
}

/* In focus a lens makes no difference but for rounding; out of focus it does. */
static void lens_focus(void) {
  float *pinhole = stage_pixels(LENS * LENS * 3), *lens = stage_pixels(LENS * LENS * 3);
  pktrt_scene *s = dot_open(6, 0.11);
  size_t differ[2] = {0, 0};
  for (int out = 0; out < 2; out++) {
    pktrt_render_desc d = lens_view(PKTRT_MODE_DRT, pinhole, 0.5, 6);
    stage_render(s, &d);
    d.pixels = lens, d.camera.aperture = 0.3f, d.camera.focus = out ? 5.f : 6.f;
    stage_render(s, &d);
    for (int i = 0; i < LENS * LENS; i++) differ[out] += fabsf(lens[3 * i] - pinhole[3 * i]) > 1.5f / 64;
  }
  CHECK(differ[0] == 0 && differ[1] > 100, "%zu pixels differ in focus, %zu out of focus", differ[0], differ[1]);
  pktrt_scene_destroy(s);
  free(pinhole), free(lens);
}

static bool same_render(pktrt_scene *s, pktrt_render_desc a, pktrt_render_desc b) {
  size_t n = (size_t)a.width * a.height * 3;
  a.pixels = stage_pixels(n), b.pixels = stage_pixels(n);
  stage_render(s, &a), stage_render(s, &b);
  bool same = same_bits(a.pixels, b.pixels, n * sizeof(float));
  free(a.pixels), free(b.pixels);
  return same;
}

/* No aperture: a pinhole, whatever the focus; focus 0: that of the target; RCS and WRT use the middle of the lens. */
static void lens_bits(void) {
  pktrt_scene *s = dot_open(6, 0.11);
  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++) {
    pktrt_render_desc a = lens_view((pktrt_mode)mode, NULL, 0.5, 6), b = a, c;
    a.samples = b.samples = 4;
    b.camera.focus = 3;
    CHECK(same_render(s, a, b), "mode %d: no aperture, so no focus", mode);
    b.camera.aperture = 0.5f;
    CHECK(same_render(s, a, b) == (mode != PKTRT_MODE_DRT), "mode %d: only DRT has a lens", mode);
    b.camera.target[2] = -4, b.camera.focus = 0;
    c = b, c.camera.focus = 4;
    CHECK(same_render(s, b, c), "mode %d: focus 0 is that of the target", mode);
    c.camera.focus = 4.5f;
    CHECK(same_render(s, b, c) == (mode != PKTRT_MODE_DRT), "mode %d: the control", mode);
  }
  pktrt_scene_destroy(s);
}

/* --- the shutter --- */

/* A bright half plane, x < edge, in the plane z = -5; the edge moves from a to b over time [0,1] by so many keys. */
static pktrt_scene *edge_open(double a, double b, uint32_t keys) {
  static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
  float p[4 * 3 * 3];
  for (uint32_t k = 0; k < keys; k++) {
    double x = keys > 1 ? a + (b - a) * k / (keys - 1) : a;
    quad q = {{-50, -50, -5}, {{x + 50, 0, 0}, {0, 100, 0}}};
    for (uint32_t c = 0; c < 4; c++) vec_put(quad_at(&q, c == 1 || c == 2, c >= 2), p + 12 * k + 3 * c);
  }
  pktrt_scene *s = stage_open();
  pktrt_material lamp = lamp_of(1);
  pktrt_mesh_desc m;
  memset(&m, 0, sizeof m);
  m.positions = p, m.vertex_count = 4, m.indices = corners, m.triangle_count = 2, m.key_count = keys;
  m.material = stage_material(s, &lamp);
  CHECK(pktrt_add_mesh(s, &m, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  stage_commit(s);
  return s;
}

enum { RAMP = 48, ROWS = 12 };

/* 2 units across at z = -5 */
static pktrt_render_desc edge_view(pktrt_mode mode, float *pixels) {
  pktrt_render_desc d = stage_view(mode, RAMP, ROWS, pixels, vec_of(0, 0, 0), vec_of(0, 0, -5));
  d.camera.fov_y = (float)(atan(1. * ROWS / RAMP / 5) * 360 / PI);
  d.camera.time = 0.2f, d.camera.shutter = 0.6f;
  d.samples = mode == PKTRT_MODE_DRT ? 64 : 1;
  return d;
}

/* The edge is seen at x = from + (to - from) t while t goes from open to close: the share of time and of the pixel
   that is lit. */
static double ramp(double from, double to, double open, double close, int column) {
  double sum = 0;
  for (int i = 0; i < 200; i++) {
    double x = -1 + 2 * (column + (i + 0.5) / 200) / RAMP, t = (x - from) / (to - from);
    double share = fmin(fmax((close - t) / (close - open), 0), 1);
    sum += to > from ? share : 1 - share;
  }
  return sum / 200;
}

static void check_ramp(const char *name, pktrt_scene *s, const pktrt_render_desc *view, double from, double to) {
  float *got = stage_pixels(RAMP * ROWS * 3);
  pktrt_render_desc d = *view;
  double worst = 0, other = 0;
  size_t between = 0;
  d.pixels = got;
  stage_render(s, &d);
  for (int x = 0; x < RAMP; x++) {
    double mean = 0, want = ramp(from, to, 0.2, 0.8, x);
    for (int y = 0; y < ROWS; y++) mean += (double)got[3 * (y * RAMP + x)] / ROWS;
    between += want > 0.02 && want < 0.98;
    worst = fmax(worst, fabs(mean - want)), other = fmax(other, fabs(mean - ramp(from, to, 0.25, 0.75, x)));
  }
  say("%s: ramp of %zu columns, off by at most %.4f; with a shorter shutter %.4f", name, between, worst, other);
  CHECK(worst < 0.02 && other > 0.03 && between > 10, "%s: off by %g", name, worst);
  free(got);
}

static void motion_ramp(void) {
  for (uint32_t keys = 2; keys <= 3; keys++) {
    pktrt_scene *s = edge_open(-1, 1, keys), *back = edge_open(1, -1, keys);
    pktrt_render_desc d = edge_view(PKTRT_MODE_DRT, NULL);
    check_ramp("edge", s, &d, -1, 1);
    check_ramp("edge going back", back, &d, 1, -1);
    pktrt_scene_destroy(s), pktrt_scene_destroy(back);
  }
}

static void camera_ramp(void) {
  pktrt_scene *s = edge_open(0.5, 0.5, 1);
  pktrt_render_desc d = edge_view(PKTRT_MODE_DRT, NULL);
  d.camera.moving = true;
  memcpy(d.camera.eye_end, d.camera.eye, 12), memcpy(d.camera.target_end, d.camera.target, 12);
  d.camera.eye_end[0] = d.camera.target_end[0] = 1;
  check_ramp("camera", s, &d, 0.5, -0.5);
  d.camera.eye_end[0] = d.camera.target_end[0] = 0;
  pktrt_render_desc still = d;
  still.camera.moving = false;
  CHECK(same_render(s, d, still), "a camera that moves nowhere");
  pktrt_scene_destroy(s);
  s = edge_open(-1, 1, 2); /* edge and camera together: it looks frozen */
  d.camera.eye[0] = d.camera.target[0] = -1, d.camera.eye_end[0] = d.camera.target_end[0] = 1;
  d.pixels = stage_pixels(RAMP * ROWS * 3);
  stage_render(s, &d);
  size_t between = 0;
  for (int i = 0; i < RAMP * ROWS; i++) between += d.pixels[3 * i] > 0.02f && d.pixels[3 * i] < 0.98f;
  CHECK(between <= 2 * ROWS, "a camera that goes along sees no blur: %zu pixels", between);
  free(d.pixels);
  pktrt_scene_destroy(s);
}

typedef struct unit_sky { /* an environment that counts directions not of unit length */
  size_t asked, wrong;
} unit_sky;

static void check_unit(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  unit_sky *u = user;
  u->asked += n;
  for (uint32_t i = 0; i < n; i++) {
    vec d = vec_of((double)direction[0][i], (double)direction[1][i], (double)direction[2][i]);
    u->wrong += !(fabs(vec_length(d) - 1) <= 1e-5);
    for (int k = 0; k < 3; k++) radiance[k][i] = 1 + (k < 1 ? 0.5f : 0.25f) * direction[k][i];
  }
}

/* Eye and target change places: halfway there is no view. */
static void camera_meets_target(void) {
  enum { N = 12 };
  static const float nowhere[3] = {0, 0, 0};
  float got[N * N * 3], out[3];
  const float *const direction[3] = {&nowhere[0], &nowhere[1], &nowhere[2]};
  float *const radiance[3] = {&out[0], &out[1], &out[2]};
  unit_sky u = {0, 0};
  pktrt_scene *s = stage_open();
  pktrt_material m = material_of(0.5, PKTRT_SPECULAR_MIRROR, 0.5);
  pktrt_light l = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
  mesh ball = mesh_sphere(2, 0, 1);
  mesh_place(&ball, (float[3]){0.4f, 0.4f, 0.4f}, (float[3]){0, 0, -3});
  stage_mesh(s, &ball, stage_material(s, &m));
  stage_light(s, &l);
  stage_commit(s);
  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++) {
    for (int frozen = 0; frozen < 2; frozen++) { /* at the very time, or open all the time */
      pktrt_render_desc d = stage_view((pktrt_mode)mode, N, N, got, vec_of(0, 0, 1), vec_of(0, 0, -1));
      d.camera.moving = true;
      vec_put(vec_of(0, 0, -1), d.camera.eye_end), vec_put(vec_of(0, 0, 1), d.camera.target_end);
      d.camera.time = frozen ? 0.5f : 0, d.camera.shutter = frozen ? 0 : 1;
      d.samples = 64, d.environment = check_unit, d.user = &u;
      u.asked = 0;
      stage_render(s, &d);
      size_t bad = 0, differ = 0;
      for (int i = 0; i < N * N * 3; i++) bad += !(got[i] >= 0 && got[i] < 10), differ += got[i] != got[i % 3];
      CHECK(bad == 0, "mode %d, shutter %g: %zu floats are no radiance", mode, (double)d.camera.shutter, bad);
      CHECK(u.wrong == 0, "mode %d, shutter %g: %zu of %zu directions not of unit length", mode,
          (double)d.camera.shutter, u.wrong, u.asked);
      CHECK(mode != PKTRT_MODE_DRT || frozen || (u.asked > N * N && differ > N), "the control: it sees something");
    }
  }
  check_unit(&u, 1, direction, radiance);
  CHECK(u.wrong == 1, "the control: a direction of no length counts");
  pktrt_scene_destroy(s);
  mesh_free(&ball);
}

/* A shutter of 0 freezes; RCS and WRT take the middle of its time. */
static void shutter_bits(void) {
  pktrt_scene *s = edge_open(-1, 1, 3);
  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++) {
    pktrt_render_desc a = edge_view((pktrt_mode)mode, NULL), b;
    a.samples = 4, a.camera.time = 0.25f, a.camera.shutter = 0.5f;
    b = a, b.camera.time = 0.5f, b.camera.shutter = 0;
    CHECK(same_render(s, a, b) == (mode != PKTRT_MODE_DRT), "mode %d: the middle of the shutter's time", mode);
    b.camera.time = 0.55f;
    CHECK(!same_render(s, a, b), "mode %d: the control", mode);
    for (int i = 0; i <= 8; i++) { /* the edge is at time 2 - 1 */
      pktrt_scene *frozen = edge_open(i / 4. - 1, 0, 1);
      float *p = stage_pixels(RAMP * ROWS * 3), *q = stage_pixels(RAMP * ROWS * 3);
      a.camera.time = (float)i / 8, a.camera.shutter = 0, b = a;
      a.pixels = p, b.pixels = q, b.camera.time = 0.3f;
      stage_render(s, &a), stage_render(frozen, &b);
      CHECK(same_bits(p, q, RAMP * ROWS * 12), "mode %d, time %g: as the picture of what stands still", mode, i / 8.);
      a.camera.time += i < 8 ? 0.03f : -0.03f, stage_render(s, &a);
      CHECK(!same_bits(p, q, RAMP * ROWS * 12), "the control: a little aside");
      free(p), free(q);
      pktrt_scene_destroy(frozen);
    }
  }
  pktrt_scene_destroy(s);
}

/* Open until 1 in decimals: 1 - time may round to less than the shutter, which is no reason to refuse. */
static void shutter_to_one(void) {
  pktrt_scene *s = edge_open(-1, 1, 2);
  float got[3 * 4];
  for (int i = 0; i <= 100; i++) {
    pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, 2, 2, got, vec_of(0, 0, 0), vec_of(0, 0, -5));
    d.camera.time = (float)i / 100, d.camera.shutter = (float)(100 - i) / 100;
    CHECK(pktrt_render(s, &d) == PKTRT_OK, "time %g: %s", (double)d.camera.time, pktrt_last_error(s));
    d.camera.shutter += 0.01f;
    CHECK(pktrt_render(s, &d) == PKTRT_INVALID_ARGUMENT, "time %g: the control", (double)d.camera.time);
  }
  pktrt_scene_destroy(s);
}

/* --- places in the pixel --- */

/* An edge through the fourth of five pixels, at a share of it: one sample (save in DRT) sees its middle only, several
   the share. */
static void antialiasing(void) {
  for (int i = 1; i < 10; i++) {
    double share = i / 10. + 0.02;
    pktrt_scene *s = edge_open(0.5 + share, 0.5 + share, 1);
    float got[15];
    for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++) {
      for (uint32_t sampler = 0; sampler < PKTRT_SAMPLER_COUNT; sampler++) {
        pktrt_render_desc d = stage_view((pktrt_mode)mode, 5, 1, got, vec_of(0, 0, 0), vec_of(0, 0, -5));
        d.camera.fov_y = (float)(atan(0.1) * 360 / PI); /* a pixel is 1 wide */
        d.sampler = (pktrt_sampler)sampler, d.samples = sampler == PKTRT_SAMPLER_RANDOM ? 1024 : 256;
        stage_render(s, &d);
        CHECK(got[6] == 1 && got[12] == 0, "mode %d, sampler %u: neighbours", mode, sampler);
        double off = fabs((double)got[9] - share), most = sampler == PKTRT_SAMPLER_RANDOM ? 0.065 : 0.02;
        CHECK(off < most, "mode %d, %s: %g, not %g", mode, pktrt_sampler_string(d.sampler), (double)got[9], share);
        d.samples = 1;
        stage_render(s, &d);
        CHECK(mode == PKTRT_MODE_DRT ? got[9] == 0 || got[9] == 1 : (got[9] == 1) == (share > 0.5),
            "mode %d, one sample: %g for %g", mode, (double)got[9], share);
      }
    }
    pktrt_scene_destroy(s);
  }
}

/* --- output buffers --- */

enum { BUF = 40 };

/* A tilted floor, diffuse, and a pane of glass and a metal plate before it; the plate is seen from behind. */
static void buffers(void) {
  vec n = vec_unit(vec_of(0.2, 1, 0.3)), side = vec_unit(vec_cross(n, vec_of(0, 0, 1))), along = vec_cross(side, n),
      eye = vec_of(0, 2, 5);
  quad q[3] = {quad_of(vec_of(0, 0, 0), vec_mul(along, 3), vec_mul(side, 3)),
      quad_of(vec_of(-1, 1, 1), vec_of(0.5, 0, 0), vec_of(0, 0.5, 0)),
      quad_of(vec_of(1, 1, 1), vec_of(0, 0.5, 0.1), vec_of(0.5, 0, 0))};
  double grey[3] = {0.6, 0, 0};
  vec normal[3] = {n, vec_of(0, 0, 1), vec_unit(vec_of(0, -0.1, 0.5))};
  pktrt_scene *s = stage_open();
  pktrt_material m[3] = {material_of(0.6, PKTRT_SPECULAR_NONE, 0), material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0),
      material_of(0, PKTRT_SPECULAR_CONDUCTOR, 0)};
  for (int i = 0; i < 3; i++) stage_quad(s, &q[i], stage_material(s, &m[i]));
  stage_commit(s);
  float *p[4];
  uint32_t count[BUF * BUF];
  for (int i = 0; i < 4; i++) p[i] = stage_pixels(BUF * BUF * 3);
  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++) {
    size_t seen[4] = {0, 0, 0, 0};
    pktrt_render_desc d = stage_view((pktrt_mode)mode, BUF, BUF, p[0], eye, vec_of(0, 0.5, 0)), bare;
    d.samples = mode == PKTRT_MODE_DRT ? 9 : 1, d.background[0] = d.ambient[0] = 0.5f;
    bare = d;
    d.depth = p[1], d.normal = p[2], d.albedo = p[3], d.sample_count = count;
    CHECK(same_render(s, d, bare), "mode %d: buffers change no pixel", mode);
    stage_render(s, &d);
    for (uint32_t i = 0; i < BUF * BUF; i++) {
      int what = 3, edge = 0;
      double t = INFINITY;
      for (int corner = 0; corner < 5; corner++) { /* the last is the middle; leave out pixels that show two things */
        vec v = stage_through(&d.camera, i % BUF + (corner == 4 ? 0.5 : corner % 2),
            i / BUF + (corner == 4 ? 0.5 : corner / 2), BUF, BUF);
        int now = 3;
        t = INFINITY;
        for (int k = 0; k < 3; k++) {
          vec e0 = q[k].edge[0], e1 = q[k].edge[1], to;
          double tk = vec_dot(vec_sub(q[k].corner, eye), normal[k]) / vec_dot(v, normal[k]);
          to = vec_sub(vec_add(eye, vec_mul(v, tk)), q[k].corner);
          double a = vec_dot(to, e0) / vec_dot(e0, e0), b = vec_dot(to, e1) / vec_dot(e1, e1);
          if (tk > 0 && tk < t && a > 0 && a < 1 && b > 0 && b < 1) t = tk, now = k;
        }
        edge += corner > 0 && now != what, what = now;
      }
      CHECK(count[i] == d.samples, "pixel %u: %u samples", i, count[i]);
      if (edge) continue;
      seen[what]++;
      vec got = vec_from(p[2] + 3 * i), want = what < 3 ? normal[what] : vec_of(0, 0, 0);
      double tolerance = mode == PKTRT_MODE_DRT ? 0.02 : 1e-6;
      CHECK(what == 3 ? p[1][i] == INFINITY : fabs((double)p[1][i] - t) < tolerance * t,
          "pixel %u of %d: depth %g, not %g", i, what, (double)p[1][i], t);
      CHECK(vec_length(vec_sub(got, want)) < 1e-6, "pixel %u of %d: normal %g %g %g", i, what, got.x, got.y, got.z);
      for (uint32_t k = 0; k < 3; k++) {
        CHECK(fabs((double)p[3][3 * i + k] - (what < 3 ? grey[what] : 0)) < 1e-6, "pixel %u of %d: albedo %g", i, what,
            (double)p[3][3 * i + k]);
      }
    }
    CHECK(seen[0] > 200 && seen[1] > 20 && seen[2] > 20 && seen[3] > 50, "%zu %zu %zu %zu", seen[0], seen[1], seen[2],
        seen[3]);
  }
  for (int i = 0; i < 4; i++) free(p[i]);
  pktrt_scene_destroy(s);
}

/* At an edge: depth of the samples that met something; normal and albedo by their share. */
static void buffers_at_edges(void) {
  pktrt_scene *s = edge_open(0, 0, 1);
  pktrt_material m = material_of(0.6, PKTRT_SPECULAR_NONE, 0);
  quad q = quad_of(vec_of(-25, 0, -4), vec_of(25, 0, 0), vec_of(0, 50, 0)); /* x < 0, before the lamp */
  stage_quad(s, &q, stage_material(s, &m));
  stage_commit(s);
  float pixel[9], depth[3], normal[9], albedo[9];
  pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, 3, 1, pixel, vec_of(0, 0, 0), vec_of(0, 0, -4));
  d.camera.fov_y = 0.1f, d.samples = 64, d.ambient[0] = 1;
  d.depth = depth, d.normal = normal, d.albedo = albedo;
  stage_render(s, &d);
  double share = (double)albedo[3] / 0.6;
  CHECK(depth[0] < 4.001f && depth[0] > 3.999f && fabsf(depth[1] - depth[0]) < 1e-3f && depth[2] == INFINITY,
      "%g %g %g", (double)depth[0], (double)depth[1], (double)depth[2]);
  CHECK(share > 0.4 && share < 0.6 && fabs((double)normal[5] - share) < 1e-6 &&
            fabs((double)pixel[3] - 0.6 * share) < 1e-6,
      "%g of the pixel, normal %g", share, (double)normal[5]);
  CHECK(normal[2] == 1 && normal[8] == 0 && albedo[0] > 0.59f && albedo[6] == 0);
  pktrt_scene_destroy(s);
}

/* --- the same bits whatever the settings --- */

enum { RICH_W = 20, RICH_H = 14, RICH = RICH_W * RICH_H };

static void rich_texture(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    bool odd = fmodf(fabsf(floorf(p->position[0][i]) + floorf(p->position[2][i])), 2) == 1;
    for (int k = 0; k < 3; k++) p->albedo[k][i] *= odd ? 1.f : 0.3f + 0.05f * p->position[k][i];
    p->reflectance[0][i] *= odd ? 0.5f : 1.f, p->emission[1][i] += odd ? 0.01f : 0.f;
  }
}

static void rich_shader(void *user, const pktrt_points *p, float *radiance[3]) {
  (void)user;
  for (int k = 0; k < 3; k++) {
    for (uint32_t i = 0; i < p->n; i++)
      radiance[k][i] = 0.5f + 0.4f * p->normal[k][i] * p->direction[k][i] + 0.1f * p->time[i] * p->barycentric[0][i];
  }
}

static void rich_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (int k = 0; k < 3; k++) {
    for (uint32_t i = 0; i < n; i++) radiance[k][i] = 0.4f + 0.3f * direction[k][i] * direction[1][i];
  }
}

static uint32_t rich_mesh(pktrt_scene *s, mesh m, const pktrt_material *material, bool smooth) {
  pktrt_mesh_desc d = mesh_desc(&m);
  uint32_t index = PKTRT_NONE;
  d.material = stage_material(s, material);
  if (smooth) d.normals = m.p; /* spheres about the origin */
  CHECK(pktrt_add_mesh(s, &d, &index) == PKTRT_OK, "%s", pktrt_last_error(s));
  mesh_free(&m);
  return index;
}

/* Moving meshes, glass, gloss, coat, metal, textures, a shader, all kinds of lights. `nudge` moves one vertex. */
static pktrt_scene *rich_open(pktrt_isa isa, int workers, float nudge) {
  pktrt_scene_desc sd = scene_desc_of(isa, workers);
  pktrt_scene *s = pktrt_scene_create(&sd);
  if (!CHECK(s != NULL)) abort();
  pktrt_material floor = material_of(0.7, PKTRT_SPECULAR_MIRROR, 0.25),
                 glossy = material_of(0.4, PKTRT_SPECULAR_MIRROR, 0.5);
  pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0),
                 metal = material_of(0.5, PKTRT_SPECULAR_CONDUCTOR, 0.9);
  pktrt_material coat = material_of(0.6, PKTRT_SPECULAR_COAT, 0), lamp = lamp_of(4),
                 odd = material_of(0, PKTRT_SPECULAR_NONE, 0);
  floor.texture = rich_texture, odd.shader = rich_shader;
  glossy.lobe = metal.lobe = PKTRT_LOBE_PHONG, glossy.exponent = 20, metal.exponent = 200;
  for (int k = 0; k < 3; k++)
    metal.ior[k] = 0.2f + 0.5f * (float)k, metal.extinction[k] = 3, glass.absorption[k] = 0.2f * (float)k;
  mesh ground = mesh_grid(3, 5), ball = mesh_sphere(3, 0, 1), pane = mesh_sphere(3, 0, 1), box = mesh_box(),
       soup = mesh_soup(60, 0.5f, 4);
  mesh tile = mesh_grid(1, 0.5f), blob = mesh_sphere(2, 0.1f, 3);
  mesh_shift(&ground, 0, -1, 0);
  ground.p[3 * 5 + 1] += nudge;
  mesh_move(&ball, 3, 0.5f, 0.02f, 7);
  mesh_place(&pane, (float[3]){0.8f, 0.8f, 0.8f}, (float[3]){-1.6f, 0, 1.2f});
  mesh_place(&box, (float[3]){0.5f, 0.7f, 0.4f}, (float[3]){1.8f, -0.2f, 0.6f});
  mesh_move(&box, 2, 0.4f, 0, 1);
  mesh_place(&soup, (float[3]){0.7f, 0.7f, 0.7f}, (float[3]){0.4f, 1.6f, -1});
  mesh_shift(&tile, 0, 3, 0.5f);
  mesh_place(&blob, (float[3]){0.4f, 0.4f, 0.4f}, (float[3]){0.3f, -0.6f, 2});
  rich_mesh(s, ground, &floor, false), rich_mesh(s, ball, &glossy, true), rich_mesh(s, pane, &glass, false),
      rich_mesh(s, box, &metal, false);
  rich_mesh(s, soup, &coat, false), rich_mesh(s, blob, &odd, false);
  quad q = quad_of(vec_of(-2, 3, 0), vec_of(0.5, 0, 0), vec_of(0, 0, 0.5));
  pktrt_light l[6] = {light_of(PKTRT_LIGHT_POINT, 5), light_of(PKTRT_LIGHT_DIRECTIONAL, 0.6), quad_light(&q, 3),
      light_of(PKTRT_LIGHT_SPHERE, 4), light_of(PKTRT_LIGHT_MESH, 1), light_of(PKTRT_LIGHT_ENVIRONMENT, 0.7)};
  vec_put(vec_of(2, 3, 2), l[0].position), vec_put(vec_of(0.3, -1, -0.4), l[1].direction);
  vec_put(vec_of(3, 2, 1), l[3].position), l[3].radius = 0.4f, l[4].mesh = rich_mesh(s, tile, &lamp, false);
  for (int i = 0; i < 6; i++) stage_light(s, &l[i]);
  stage_commit(s);
  return s;
}

typedef struct rich_picture {
  float pixel[RICH * 3], depth[RICH], normal[RICH * 3], albedo[RICH * 3];
  uint32_t count[RICH];
} rich_picture;

/* Scenario 0: WRT; 1 and 2: DRT, choosing and branching. */
static pktrt_render_desc rich_view(rich_picture *p, int scenario) {
  pktrt_render_desc d = stage_view(
      scenario ? PKTRT_MODE_DRT : PKTRT_MODE_WRT, RICH_W, RICH_H, p->pixel, vec_of(0.4, 1.2, 5), vec_of(0, 0.2, 0));
  d.camera.aperture = 0.1f, d.camera.shutter = 0.5f, d.camera.time = 0.1f, d.camera.moving = true;
  vec_put(vec_of(0.6, 1.2, 5), d.camera.eye_end);
  d.samples = scenario == 2 ? 3 : 4, d.max_depth = 5, d.attenuation = 0, d.seed = 5;
  d.environment = rich_sky;
  d.sampler = scenario == 2 ? PKTRT_SAMPLER_BLUE_NOISE : PKTRT_SAMPLER_SOBOL;
  if (scenario == 2) d.branching = PKTRT_BRANCHING_BOTH, d.lights = PKTRT_LIGHTS_ONE_DEEPER;
  for (int k = 0; k < 3; k++) d.ambient[k] = 0.02f;
  d.depth = p->depth, d.normal = p->normal, d.albedo = p->albedo, d.sample_count = p->count;
  return d;
}

/* By hand, tile by tile, the last first. */
static void rich_tiles(pktrt_scene *s, const pktrt_render_desc *d) {
  for (uint32_t y = 0; y < RICH_H; y += 7) {
    for (uint32_t x = RICH_W; x > 0; x -= 5) CHECK(pktrt_render_tile(s, d, x - 5, y, 5, 7) == PKTRT_OK);
  }
}

static size_t rich_compare(int scenario, const rich_picture *want) {
  static const uint32_t packets[5] = {0, 2, 4, 8, 16}, tiles[5] = {0, 1, 5, 16, 33};
  static const int workers[3] = {0, 1, 3};
  size_t pictures = 0;
  rich_picture *got = malloc(sizeof *got);
  pktrt_stats *stats = malloc(sizeof *stats);
  if (!got || !stats) abort();
  memset(stats, 0, sizeof *stats);
  for (int k = 0; k < isa_count; k++) {
    for (int w = 0; w < 3; w++) {
      pktrt_scene *s = rich_open(isas[k], workers[w], 0);
      for (int i = w + (small_run ? 3 * (k % 6) : 0); i < 18;
           i += small_run ? 18 : 3) { /* all assemblies on all paths */
        uint32_t r = (uint32_t)mix64((uint64_t)(i + 18 * (k + 8 * scenario)));
        memset(got, 0x55, sizeof *got);
        pktrt_render_desc d = rich_view(got, scenario);
        d.assembly = (pktrt_assembly)(i % 6), d.path = (pktrt_path)(i / 6);
        d.packet_size = packets[r % 5], d.tile_size = tiles[r / 5 % 5];
        d.shadows = r / 25 % 2 ? PKTRT_SHADOWS_TOGETHER : PKTRT_SHADOWS_PER_LIGHT;
        if (r / 50 % 2) d.stats = stats;
        if (r / 100 % 4 == 0 && !d.stats) rich_tiles(s, &d);
        else stage_render(s, &d);
        bool same = same_bits(got->pixel, want->pixel, sizeof got->pixel),
             aside = same_bits(got->depth, want->depth, sizeof got->depth);
        aside = aside && same_bits(got->normal, want->normal, sizeof got->normal) &&
                same_bits(got->albedo, want->albedo, sizeof got->albedo);
        aside = aside && same_bits(got->count, want->count, sizeof got->count);
        size_t differ = 0, first = 0;
        for (size_t j = RICH * 3; j-- > 0;)
          if (!same_bits(&got->pixel[j], &want->pixel[j], 4)) differ++, first = j;
        const char *isa = pktrt_isa_string(isas[k]);
        CHECK(same,
            "scenario %d, %s, %d workers, assembly %d, path %d, packets %u, tiles %u: %zu floats differ, first at %zu",
            scenario, isa, workers[w], (int)d.assembly, (int)d.path, d.packet_size, d.tile_size, differ, first);
        CHECK(aside, "scenario %d, %s, %d workers, assembly %d, path %d, packets %u, tiles %u: buffers differ",
            scenario, isa, workers[w], (int)d.assembly, (int)d.path, d.packet_size, d.tile_size);
        pictures++;
      }
      pktrt_scene_destroy(s);
    }
  }
  free(got), free(stats);
  return pictures;
}

static void rich_same(int scenario) {
  rich_picture *want = malloc(sizeof *want), *other = malloc(sizeof *other);
  if (!want || !other) abort();
  memset(want, 0, sizeof *want);
  pktrt_scene *s = rich_open(isas[0], 0, 0), *nudged = rich_open(isas[0], 0, 0.05f);
  pktrt_render_desc d = rich_view(want, scenario);
  d.path = PKTRT_PATH_SINGLE, d.assembly = PKTRT_ASSEMBLY_NONE;
  stage_render(s, &d);
  size_t bad = 0, differ[2] = {0, 0};
  for (int i = 0; i < RICH * 3; i++) bad += !(want->pixel[i] >= 0 && want->pixel[i] < 1e3f);
  CHECK(bad == 0, "%zu floats are no radiance", bad);
  for (int control = 0; control < 2; control++) { /* another seed, another vertex */
    d = rich_view(other, scenario);
    if (control == 0) d.seed++;
    stage_render(control ? nudged : s, &d);
    for (int i = 0; i < RICH * 3; i++) differ[control] += want->pixel[i] != other->pixel[i];
  }
  CHECK(differ[0] > RICH && differ[1] > 100, "the controls: %zu, %zu floats differ", differ[0], differ[1]);
  pktrt_scene_destroy(s), pktrt_scene_destroy(nudged);
  say("%zu pictures of %d x %d; another seed changes %zu floats, another vertex %zu", rich_compare(scenario, want),
      RICH_W, RICH_H, differ[0], differ[1]);
  free(want), free(other);
}

static void same_wrt(void) { rich_same(0); }
static void same_drt(void) { rich_same(1); }
static void same_drt_branching(void) { rich_same(2); }

/* --- stack --- */

enum { DEEP = 12, DEEP_STACK = 128 << 10, DEEP_PAINTED = 1 << 20 };
typedef struct deep_render {
  pktrt_scene *s;
  const pktrt_render_desc *d; /* NULL: nothing */
  pktrt_status status;
} deep_render;

static void *deep_thread(void *arg) {
  deep_render *r = arg;
  if (r->d) r->status = pktrt_render(r->s, r->d);
  return NULL;
}

/* Paints a larger stack and sees how deep the paint is gone; so too much fails and does not crash. */
static size_t deep_painted(deep_render *r) {
  char *memory = NULL, *low;
  if (posix_memalign((void **)&memory, 4096, DEEP_PAINTED)) abort();
  memset(memory, 0xA5, DEEP_PAINTED);
  run_on_stack(memory, DEEP_PAINTED, deep_thread, r);
  for (low = memory; low < memory + DEEP_PAINTED && *low == (char)0xA5; low++) {}
  size_t used = (size_t)(memory + DEEP_PAINTED - low); /* with what the thread itself keeps there */
  free(memory);
  return used;
}

/* Between two mirrors, or in a box of glass, where rays near its diagonals are reflected totally. Everything that lies
   on the stack is used: lights of all kinds, a pane for shadow rays, a texture, a sky. */
static pktrt_scene *deep_open(pktrt_isa isa, bool glass) {
  pktrt_scene_desc sd = scene_desc_of(isa, 0);
  pktrt_scene *s = pktrt_scene_create(&sd);
  if (!CHECK(s != NULL)) abort();
  pktrt_material mirror = material_of(0.05, PKTRT_SPECULAR_MIRROR, 0.95),
                 clear = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0), lamp = lamp_of(1);
  mirror.texture = rich_texture;
  quad left = quad_of(vec_of(-1, 0, 0), vec_of(0, 99, 0), vec_of(0, 0, 99)),
       right = quad_of(vec_of(1, 0, 0), vec_of(0, 0, 99), vec_of(0, 99, 0)),
       tile = quad_of(vec_of(0, 0, -9), vec_of(0.5, 0, 0), vec_of(0, 0.5, 0));
  quad pane = quad_of(vec_of(0, -9, 0), vec_of(0.9, 0, 0), vec_of(0, 0, 9));
  mesh box = mesh_box();
  uint32_t reflecting = stage_material(s, &mirror), of_glass = stage_material(s, &clear);
  if (glass) stage_mesh(s, &box, of_glass);
  else stage_quad(s, &left, reflecting), stage_quad(s, &right, reflecting), stage_quad(s, &pane, of_glass);
  mesh_free(&box);
  pktrt_light l[4] = {light_of(PKTRT_LIGHT_POINT, 5), light_of(PKTRT_LIGHT_MESH, 1), quad_light(&tile, 1),
      light_of(PKTRT_LIGHT_ENVIRONMENT, 1)};
  l[0].position[1] = -20, l[1].mesh = stage_quad(s, &tile, stage_material(s, &lamp));
  for (int i = 0; i < 4; i++) stage_light(s, &l[i]);
  stage_commit(s);
  return s;
}

static void deep_stack(void) {
#ifndef __OPTIMIZE__
  say("skipped: unoptimised code keeps every temporary in memory");
#else
  if (SANITIZED) {
    say("skipped: sanitizers change the stack");
    return;
  }
  size_t most = 0;
  for (int k = 0; k < isa_count * 4; k++) {
    float want[DEEP * DEEP * 3], got[DEEP * DEEP * 3];
    bool glass = k % 2;
    pktrt_mode mode = k % 4 < 2 ? PKTRT_MODE_WRT : PKTRT_MODE_DRT;
    pktrt_stats *stats = calloc(1, sizeof *stats);
    if (!stats) abort();
    pktrt_scene *s = deep_open(isas[k / 4], glass);
    pktrt_render_desc d =
        stage_view(mode, DEEP, DEEP, want, vec_of(0, 0, 0), glass ? vec_of(1, 0.9, 0.8) : vec_of(1, 0.1, 0));
    d.environment = rich_sky, d.camera.fov_y = 20, d.stats = stats;
    deep_render r = {s, NULL, PKTRT_OK};
    size_t nothing = deep_painted(&r);
    r.d = &d;
    size_t used = deep_painted(&r);
    const char *isa = pktrt_isa_string(isas[k / 4]), *where = glass ? "in glass" : "between mirrors";
    CHECK(r.status == PKTRT_OK && stats->by_depth[PKTRT_MAX_DEPTH].rays > 0, "%s, %s: as deep as can be", isa, where);
    CHECK(used > nothing + 4096, "the control: the probe sees a render");
    if (used > most) most = used;
    if (CHECK(used <= DEEP_STACK, "%s, mode %d, %s: %zu bytes of stack", isa, (int)mode, where, used)) {
      d.pixels = got;
      run_on_stack(NULL, DEEP_STACK, deep_thread, &r);
      CHECK(r.status == PKTRT_OK && same_bits(want, got, sizeof got), "%s, %s: the same on a small stack", isa, where);
    }
    pktrt_scene_destroy(s);
    free(stats);
  }
  say("at most %zu bytes, with what a thread itself takes", most);
#endif
}

/* --- memory --- */

/* Allocation 1, 2, 3, ... of a render failing, alone or with all that follow. */
static size_t fail_each(pktrt_scene *s, const pktrt_render_desc *d) {
  size_t live = hooks.live_blocks;
  for (size_t n = 1; n < 20000; n++) {
    hooks.fail_at = n, hooks.failed = 0, hooks.fail_after = n % 2 == 0;
    pktrt_status status = pktrt_render(s, d);
    hooks.fail_at = 0, hooks.fail_after = false;
    CHECK(hooks.live_blocks == live, "allocation %zu: %zu blocks left over", n, hooks.live_blocks - live);
    if (status == PKTRT_OK) {
      CHECK(hooks.failed == 0, "allocation %zu failed and nobody noticed", n);
      return n - 1;
    }
    CHECK(status == PKTRT_OUT_OF_MEMORY && strstr(pktrt_last_error(s), "memory"), "allocation %zu: status %d: %s", n,
        (int)status, pktrt_last_error(s));
  }
  CHECK(false, "it never passes");
  return 0;
}

static void failing_renders(void) {
  rich_picture *want = malloc(sizeof *want), *got = malloc(sizeof *got);
  pktrt_stats *stats = calloc(1, sizeof *stats);
  if (!want || !got || !stats) abort();
  for (int workers = 0; workers <= 3; workers += 3) {
    pktrt_scene *s = rich_open(PKTRT_ISA_AUTO, workers, 0);
    size_t failed = 0;
    for (int scenario = 0; scenario < 3; scenario++) {
      pktrt_render_desc d = rich_view(want, scenario);
      d.tile_size = 16;
      stage_render(s, &d);
      d = rich_view(got, scenario);
      d.tile_size = 16, d.stats = stats, d.assembly = (pktrt_assembly)(2 * scenario);
      failed += fail_each(s, &d);
      CHECK(same_bits(got->pixel, want->pixel, sizeof got->pixel), "afterwards it renders as before");
    }
    say("%d workers: %zu allocations failed in turn", workers, failed);
    CHECK(failed > 0, "the control: renders do allocate");
    const size_t blocks = hooks.live_blocks;
    const char *const name = workers ? "rich renders, 3 workers" : "rich renders, no workers";
    const char *const leaks = "blocks left after failed allocations";
    pktrt_scene_destroy(s);
    count_figure("tree", name, PKTRT_ISA_AUTO, failed, leaks, hooks.live_blocks);
    control_figure("tree", name, leaks, "before the scene is destroyed", blocks, blocks);
  }
  free(want), free(got), free(stats);
}

void suite_pictures(void) {
  run("a lens blurs to disks of the closed form's diameter", lens_blur);
  run("a lens is sharp in its plane of focus", lens_focus);
  run("without aperture a lens is a pinhole, bit for bit", lens_bits);
  run("what moves while the shutter is open is a linear ramp", motion_ramp);
  run("a camera that moves while the shutter is open sees a linear ramp", camera_ramp);
  run("a camera whose eye meets its target halfway gives finite pixels", camera_meets_target);
  run("a shutter of no time freezes, bit for bit", shutter_bits);
  run("a shutter may stay open until time 1, and no longer", shutter_to_one);
  run("several samples in a pixel see each part of it by its share", antialiasing);
  run("depth, normal, albedo and sample count are those of closed forms", buffers);
  run("at edges, buffers hold the share of each sample", buffers_at_edges);
  run("a WRT picture has the same bits for all settings", same_wrt);
  run("a DRT picture has the same bits for all settings", same_drt);
  run("a branching DRT picture has the same bits for all settings", same_drt_branching);
  run("stable: each allocation of a render failing in turn is reported and leaks nothing", failing_renders);
  run("rays of depth 50 fit into 128 KiB of stack, between mirrors and in glass", deep_stack);
}
