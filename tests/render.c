/* Pictures: the same bits whatever the settings, the values of closed forms, refusals, cancelling. */
#include "meshes.h"

enum { W = 72, H = 54 };

static void add_lights(pktrt_scene *s) {
  pktrt_light l[3];
  memset(l, 0, sizeof l);
  for (int k = 0; k < 3; k++)
    l[0].intensity[k] = 30, l[1].intensity[k] = 1.5f, l[2].intensity[k] = 4.f * (float)(k + 1);
  l[0].position[0] = 2, l[0].position[1] = 4, l[0].position[2] = 2;
  l[1].kind = PKTRT_LIGHT_DIRECTIONAL, l[1].direction[0] = 0.5f, l[1].direction[1] = -1, l[1].direction[2] = -0.3f;
  l[2].position[0] = -3, l[2].position[1] = 1.5f, l[2].position[2] = 1;
  for (int i = 0; i < 3; i++) CHECK(pktrt_add_light(s, &l[i], NULL) == PKTRT_OK);
}

/* A world with lights, three materials and smooth normals on the sphere. */
static pktrt_scene *lit_scene(const world *w, pktrt_isa isa, int workers) {
  pktrt_scene_desc d = scene_desc_of(isa, workers);
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!CHECK(s != NULL, "%s", pktrt_last_error(NULL))) abort();
  static const float colours[2][3] = {{0.9f, 0.2f, 0.1f}, {0.1f, 0.3f, 0.8f}};
  pktrt_material red, blue;
  memset(&red, 0, sizeof red), memset(&blue, 0, sizeof blue);
  memcpy(red.albedo, colours[0], 12), memcpy(blue.albedo, colours[1], 12);
  CHECK(pktrt_add_material(s, &red, NULL) == PKTRT_OK && pktrt_add_material(s, &blue, NULL) == PKTRT_OK);
  for (uint32_t i = 0; i < w->n; i++) {
    pktrt_mesh_desc m = mesh_desc(&w->m[i]);
    m.material = i % 3;
    if (i == 0) m.normals = w->m[i].p; /* a sphere about the origin: its vertices are its normals */
    CHECK(pktrt_add_mesh(s, &m, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  }
  add_lights(s);
  CHECK(pktrt_commit(s) == PKTRT_OK, "%s", pktrt_last_error(s));
  return s;
}

static pktrt_render_desc view(float *pixels) {
  pktrt_render_desc d;
  memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = W, d.height = H, d.pixels = pixels;
  d.camera.eye[0] = 1, d.camera.eye[1] = 1.5f, d.camera.eye[2] = 5;
  d.camera.target[1] = -0.2f;
  d.camera.time = 0.4f;
  d.background[0] = 0.1f, d.background[1] = 0.2f, d.background[2] = 0.3f;
  d.ambient[0] = d.ambient[1] = d.ambient[2] = 0.05f;
  return d;
}

static float *blank(size_t floats) {
  float *p = malloc(floats * sizeof *p);
  if (!p) abort();
  for (size_t i = 0; i < floats; i++) p[i] = -7;
  return p;
}

typedef struct { /* several workers may report at once */
  pthread_mutex_t lock;
  float most;
} reported;

static bool keep_going(void *user, float done) {
  reported *p = user;
  CHECK(done > 0 && done <= 1, "%g done", (double)done);
  pthread_mutex_lock(&p->lock);
  p->most = fmaxf(p->most, done);
  pthread_mutex_unlock(&p->lock);
  return true;
}

static void same_picture(bool moving) {
  world w = moving ? world_moving(4) : world_static(4);
  size_t floats = W * H * 3, pictures = 0, bad = 0;
  float *want = blank(floats), *got = blank(floats);
  reported done = {PTHREAD_MUTEX_INITIALIZER, 0};
  pktrt_scene *s = lit_scene(&w, PKTRT_ISA_AUTO, 0);
  pktrt_render_desc d = view(want);
  d.path = PKTRT_PATH_SINGLE;
  CHECK(pktrt_render(s, &d) == PKTRT_OK, "%s", pktrt_last_error(s));
  pktrt_scene_destroy(s);
  size_t dark = 0, lit = 0;
  for (size_t i = 0; i < floats; i += 3) dark += want[i]<0.051f, lit += want[i]> 0.3f;
  for (size_t i = 0; i < floats; i++) bad += !(want[i] >= 0 && want[i] < 1e4f);
  CHECK(bad == 0 && dark > 30 && lit > 100, "a picture with shadows: %zu dark, %zu lit", dark, lit);
  for (int k = 0; k < isa_count * 4; k++) {
    static const uint32_t packets[5] = {0, 2, 4, 8, 16}, tiles[6] = {0, 3, 7, 16, 33, 1024};
    static const int workers[4] = {0, 1, 2, 7};
    s = lit_scene(&w, isas[k / 4], workers[k % 4]);
    for (uint32_t i = (uint32_t)k % 4; i < 60; i += small_run ? 28 : 4) {
      d = view(got);
      d.path = (pktrt_path)(i % 3), d.packet_size = packets[(i / 3) % 5],
      d.tile_size = i == 12 + (uint32_t)k % 4 ? 1 : tiles[(i / 2) % 6];
      d.shadows = (pktrt_shadow_packets)((i / 4) % 2);
      d.row_stride = i % 4 == 3 ? W * 3 : 0;
      if (i % 5 == 0) d.progress = keep_going, d.user = &done, done.most = 0;
      for (size_t j = 0; j < floats; j++) got[j] = -7;
      if (i % 7 == 6) { /* by hand, tile by tile, in another order */
        for (uint32_t y = 0; y < H; y += 27) {
          for (uint32_t x = 54; x < W; x -= 18) CHECK(pktrt_render_tile(s, &d, x, y, 18, 27) == PKTRT_OK);
        }
      } else {
        CHECK(pktrt_render(s, &d) == PKTRT_OK, "%s", pktrt_last_error(s));
        CHECK(!d.progress || done.most == 1, "progress ends at 1");
      }
      pictures++;
      size_t differ = 0, first = floats;
      for (size_t j = floats; j-- > 0;) {
        if (!same_bits(&got[j], &want[j], 4)) differ++, first = j;
      }
      CHECK(differ == 0, "%s path %d packet %u tile %u shadows %d: %zu floats differ, first at pixel %zu,%zu",
          pktrt_isa_string(isas[k / 4]), (int)d.path, d.packet_size, d.tile_size, (int)d.shadows, differ, first / 3 % W,
          first / 3 / W);
    }
    pktrt_scene_destroy(s);
  }
  say("%zu pictures of %d x %d", pictures, W, H);
  free(want);
  free(got);
  world_free(&w);
}
static void same_static(void) { same_picture(false); }
static void same_moving(void) { same_picture(true); }

/* --- closed forms --- */

typedef struct vec {
  double x, y, z;
} vec;
static vec sub(vec a, vec b) { return (vec){a.x - b.x, a.y - b.y, a.z - b.z}; }
static double dot(vec a, vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static vec mul(vec a, double f) { return (vec){a.x * f, a.y * f, a.z * f}; }
static vec add(vec a, vec b) { return (vec){a.x + b.x, a.y + b.y, a.z + b.z}; }
static vec unit(vec a) { return mul(a, 1 / sqrt(dot(a, a))); }
static vec cross(vec a, vec b) { return (vec){a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }

/* The ray through the point (x, y) of the picture, in pixels from the upper left. */
static vec through(const pktrt_camera *c, double x, double y, double width, double height) {
  vec eye = {(double)c->eye[0], (double)c->eye[1], (double)c->eye[2]},
      up = {(double)c->up[0], (double)c->up[1], (double)c->up[2]};
  vec target = {(double)c->target[0], (double)c->target[1], (double)c->target[2]}, forward = unit(sub(target, eye));
  if (dot(up, up) == 0) up.y = 1;
  vec right = unit(cross(forward, up)), above = cross(right, forward);
  double h = tan((c->fov_y > 0 ? (double)c->fov_y : 45) * 3.14159265358979323846 / 360);
  return add(forward, add(mul(right, (2 * x / width - 1) * h * width / height), mul(above, (1 - 2 * y / height) * h)));
}

typedef struct closed_form { /* a floor y = 0 in [-4,4]^2, a box of half size b at (0, b, 0) above it, lights */
  pktrt_light light[2];
  int lights;
  double albedo, ambient, b;
} closed_form;

DIVIDES_BY_ZERO static bool box_shades(const closed_form *f, vec o, vec d, double tmax) {
  double t0 = 1e-6, t1 = tmax, lo[3] = {-f->b, 0, -f->b}, hi[3] = {f->b, 2 * f->b, f->b}, oo[3] = {o.x, o.y, o.z},
         dd[3] = {d.x, d.y, d.z};
  for (int k = 0; k < 3; k++) {
    double a = (lo[k] - oo[k]) / dd[k], b = (hi[k] - oo[k]) / dd[k];
    t0 = fmax(t0, fmin(a, b)), t1 = fmin(t1, fmax(a, b));
  }
  return t0 < t1;
}

/* Radiance towards the eye, or -1 for background, -2 for the box: not asked about. */
static double floor_radiance(const closed_form *f, vec o, vec d) {
  if (f->b > 0 && box_shades(f, o, d, 1e30)) return -2;
  double t = -o.y / d.y;
  vec p = add(o, mul(d, t)), n = {0, 1, 0};
  if (!(t > 0) || fabs(p.x) > 4 || fabs(p.z) > 4) return -1;
  double sum = 0;
  for (int i = 0; i < f->lights; i++) {
    const pktrt_light *l = &f->light[i];
    vec at = {(double)l->position[0], (double)l->position[1], (double)l->position[2]};
    vec way = {(double)l->direction[0], (double)l->direction[1], (double)l->direction[2]};
    vec to = l->kind == PKTRT_LIGHT_POINT ? sub(at, p) : mul(way, -1);
    double c = dot(unit(to), n), falloff = l->kind == PKTRT_LIGHT_POINT ? dot(to, to) : 1;
    if (c > 0 && !(f->b > 0 && box_shades(f, p, to, l->kind == PKTRT_LIGHT_POINT ? 1 : 1e30))) {
      sum += (double)l->intensity[0] * c / (3.14159265358979323846 * falloff);
    }
  }
  return f->albedo * (f->ambient + sum);
}

static void compare_floor(const closed_form *f, const pktrt_camera *camera, const char *name) {
  mesh floor = mesh_grid(1, 4), box = mesh_box();
  mesh_place(&box, (float[3]){(float)f->b, (float)f->b, (float)f->b}, (float[3]){0, (float)f->b, 0});
  pktrt_scene_desc sd = scene_desc_of(PKTRT_ISA_AUTO, 0);
  pktrt_scene *s = pktrt_scene_create(&sd);
  pktrt_material m;
  memset(&m, 0, sizeof m);
  m.albedo[0] = m.albedo[1] = m.albedo[2] = (float)f->albedo;
  pktrt_mesh_desc md = mesh_desc(&floor);
  md.material = 1;
  CHECK(pktrt_add_material(s, &m, NULL) == PKTRT_OK && pktrt_add_mesh(s, &md, NULL) == PKTRT_OK);
  if (f->b > 0) CHECK(mesh_add(s, &box, NULL) == PKTRT_OK);
  for (int i = 0; i < f->lights; i++) CHECK(pktrt_add_light(s, &f->light[i], NULL) == PKTRT_OK);
  CHECK(pktrt_commit(s) == PKTRT_OK);
  float *got = blank(W * H * 3);
  pktrt_render_desc d = view(got);
  d.camera = *camera;
  for (int k = 0; k < 3; k++) d.ambient[k] = (float)f->ambient;
  CHECK(pktrt_render(s, &d) == PKTRT_OK, "%s", pktrt_last_error(s));
  vec eye = {(double)camera->eye[0], (double)camera->eye[1], (double)camera->eye[2]};
  closed_form open = *f; /* the same without the box */
  open.b = 0;
  size_t seen = 0, background = 0, shadow = 0, off_centre = 0;
  for (uint32_t y = 0; y < H; y++) {
    for (uint32_t x = 0; x < W; x++) {
      double want = floor_radiance(f, eye, through(camera, x + 0.5, y + 0.5, W, H)), least = want, most = want;
      for (int corner = 0; corner < 4; corner++) { /* at the borders of things a rounded ray may choose either side */
        double e = 1e-3, v = floor_radiance(f, eye,
                             through(camera, x + 0.5 + (corner & 1 ? e : -e), y + 0.5 + (corner & 2 ? e : -e), W, H));
        least = fmin(least, v), most = fmax(most, v);
      }
      const float *p = got + 3 * ((size_t)y * W + x);
      if (most - least > 0.01 * fmax(most, 0.01) || want == -2) continue;
      if (want == -1) {
        background++;
        CHECK(p[0] == d.background[0] && p[1] == d.background[1] && p[2] == d.background[2],
            "%s: pixel %u,%u is no background", name, x, y);
        continue;
      }
      seen++;
      shadow += f->b > 0 && floor_radiance(&open, eye, through(camera, x + 0.5, y + 0.5, W, H)) > 1.01 * want;
      CHECK(fabs((double)p[0] - want) <= 2e-5 * (want + 1e-3) && p[0] == p[1] && p[1] == p[2],
          "%s: pixel %u,%u: %g, not %g", name, x, y, (double)p[0], want);
      double aside = floor_radiance(f, eye, through(camera, x + 0.9, y + 0.5, W, H));
      off_centre += fabs((double)p[0] - aside) > 2e-5 * (want + 1e-3);
    }
  }
  say("%s: %zu floor pixels, %zu of them in shadow, %zu background; 0.4 pixels aside %zu would fail", name, seen,
      shadow, background, off_centre);
  CHECK(seen > 400 && background > 20 && (f->b <= 0 || shadow > 20));
  free(got);
  pktrt_scene_destroy(s);
  mesh_free(&floor), mesh_free(&box);
}

static void closed_forms(void) {
  pktrt_camera camera;
  closed_form f;
  memset(&camera, 0, sizeof camera);
  memset(&f, 0, sizeof f);
  camera.eye[0] = 1.5f, camera.eye[1] = 3, camera.eye[2] = 7;
  f.albedo = 0.5, f.lights = 1;
  for (int k = 0; k < 3; k++) f.light[0].intensity[k] = 20, f.light[1].intensity[k] = 2;
  f.light[0].position[0] = 1, f.light[0].position[1] = 2.5f;
  f.light[1].kind = PKTRT_LIGHT_DIRECTIONAL, f.light[1].direction[0] = 3, f.light[1].direction[1] = -4;
  compare_floor(&f, &camera, "point light");
  f.lights = 2, f.ambient = 0.1, camera.fov_y = 60;
  compare_floor(&f, &camera, "point and directional light, ambient");
  f.b = 0.8, camera.up[0] = 0.3f, camera.up[1] = 2, camera.target[0] = 0.5f;
  compare_floor(&f, &camera, "with a box, camera tilted");
  f.lights = 1, f.light[0] = f.light[1], f.ambient = 0;
  compare_floor(&f, &camera, "directional light and a box");
}

/* Up is up, right is right: four marked quadrants. */
static void orientation(void) {
  mesh m = mesh_box();
  pktrt_scene_desc sd = scene_desc_of(PKTRT_ISA_AUTO, 0);
  pktrt_scene *s = pktrt_scene_create(&sd);
  mesh_place(&m, (float[3]){0.2f, 0.2f, 0.2f}, (float[3]){1, 1, 0}); /* one box, to the right and above */
  CHECK(mesh_add(s, &m, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
  float pixels[32 * 32 * 3];
  pktrt_render_desc d;
  memset(&d, 0, sizeof d);
  d.samples = 1;
  d.width = d.height = 32, d.pixels = pixels, d.camera.eye[2] = 5, d.ambient[0] = 1;
  CHECK(pktrt_render(s, &d) == PKTRT_OK);
  size_t count[4] = {0, 0, 0, 0};
  for (uint32_t i = 0; i < 1024; i++) count[(i % 32 >= 16) + 2 * (i / 32 >= 16)] += pixels[3 * i] > 0;
  CHECK(count[1] > 5 && count[0] + count[2] + count[3] == 0, "%zu %zu %zu %zu", count[0], count[1], count[2], count[3]);
  pktrt_scene_destroy(s);
  mesh_free(&m);
}

/* A coarse sphere: smooth normals shade as the true sphere, geometric ones in facets. */
static void smooth_and_geometric(void) {
  world w = world_none();
  w.m[0] = mesh_sphere(2, 0, 1), w.n = 1;
  pktrt_scene_desc sd = scene_desc_of(PKTRT_ISA_AUTO, 0);
  pktrt_scene *s = pktrt_scene_create(&sd);
  pktrt_mesh_desc m = mesh_desc(&w.m[0]);
  float *normals = blank(w.m[0].nv * 3); /* of any length, the same everywhere */
  for (uint32_t i = 0; i < w.m[0].nv * 3; i++) normals[i] = w.m[0].p[i] * 3;
  m.normals = normals;
  pktrt_light l;
  memset(&l, 0, sizeof l);
  l.kind = PKTRT_LIGHT_DIRECTIONAL, l.direction[1] = l.direction[2] = -1, l.intensity[0] = 3.14159265f;
  CHECK(pktrt_add_mesh(s, &m, NULL) == PKTRT_OK && pktrt_add_light(s, &l, NULL) == PKTRT_OK &&
        pktrt_commit(s) == PKTRT_OK);
  float *smooth = blank(W * H * 3), *flat = blank(W * H * 3);
  pktrt_render_desc d = view(smooth);
  memset(d.ambient, 0, sizeof d.ambient);
  CHECK(pktrt_render(s, &d) == PKTRT_OK);
  d.pixels = flat, d.normals = PKTRT_NORMALS_GEOMETRIC;
  CHECK(pktrt_render(s, &d) == PKTRT_OK);
  vec eye = {1, 1.5, 5}, sun = unit((vec){0, 1, 1});
  size_t seen = 0, flat_right = 0, flat_facets = 0, smooth_facets = 0;
  double worst = 0;
  for (uint32_t y = 0; y < H; y++) {
    for (uint32_t x = 0; x < W; x++) {
      vec v = through(&d.camera, x + 0.5, y + 0.5, W, H);
      pktrt_ray r = ray_of(1, 1.5f, 5, (float)v.x, (float)v.y, (float)v.z);
      pktrt_hit h;
      if (!ref_intersect(&w, &r, &h) || h.u < 0.02f || h.v < 0.02f || h.u + h.v > 0.98f) continue;
      vec p = unit(add(eye, mul(v, (double)h.t))),
          g = unit((vec){(double)h.normal[0], (double)h.normal[1], (double)h.normal[2]});
      if (dot(p, sun) < 0.2 || dot(g, sun) < 0.2) continue;
      seen++;
      double a = (double)smooth[3 * (y * W + x)], b = (double)flat[3 * (y * W + x)];
      flat_right += fabs(b - 0.8 * dot(g, sun)) < 1e-4;
      worst = fmax(worst, fabs(a - 0.8 * dot(p, sun)));
      flat_facets += fabs(b - 0.8 * dot(p, sun)) > 0.02;
      smooth_facets += fabs(a - 0.8 * dot(p, sun)) > 1e-3;
    }
  }
  say("%zu pixels: smooth shading off the true sphere's by at most %.2g; facets off in %zu pixels", seen, worst,
      flat_facets);
  CHECK(seen > 100 && flat_right == seen, "%zu of %zu facets right", flat_right, seen);
  CHECK(smooth_facets == 0 && flat_facets > seen / 10);
  free(smooth), free(flat), free(normals);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* New shading normals show after a refit, not before, and stay. */
static void normals_change(void) {
  world w = world_none();
  w.m[0] = mesh_sphere(3, 0, 1), w.n = 1;
  pktrt_scene *s = lit_scene(&w, PKTRT_ISA_AUTO, 0);
  float *before = blank(W * H * 3), *after = blank(W * H * 3);
  for (uint32_t i = 0; i < w.m[0].nv * 3; i += 3) w.m[0].p[i] += 0.5f;
  pktrt_render_desc d = view(before);
  CHECK(pktrt_render(s, &d) == PKTRT_OK);
  CHECK(pktrt_set_normals(s, 0, 0, w.m[0].p) == PKTRT_OK);
  d.pixels = after;
  CHECK(pktrt_render(s, &d) == PKTRT_OK && same_bits(before, after, W * H * 12), "not yet");
  CHECK(pktrt_refit(s) == PKTRT_OK && pktrt_render(s, &d) == PKTRT_OK && !same_bits(before, after, W * H * 12), "now");
  for (int i = 0; i < 3; i++) { /* and stay */
    CHECK((i ? pktrt_commit(s) : pktrt_refit(s)) == PKTRT_OK);
    d.pixels = before;
    CHECK(pktrt_render(s, &d) == PKTRT_OK && same_bits(before, after, W * H * 12), "and stay: %d", i);
  }
  free(before), free(after);
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* Shading normals of no length, and such that cancel between corners: refused, or a finite picture. */
static void vanishing_normals(void) {
  mesh m = mesh_box();
  for (int kind = 0; kind < 2; kind++) {
    pktrt_scene_desc sd = scene_desc_of(PKTRT_ISA_AUTO, 0);
    pktrt_scene *s = pktrt_scene_create(&sd);
    pktrt_mesh_desc d = mesh_desc(&m);
    float normals[24];
    for (int i = 0; i < 24; i++) normals[i] = kind == 0 ? 0.f : i % 3 ? 0.f : i / 3 % 2 ? 1e30f : -1e30f;
    d.normals = normals;
    add_lights(s);
    pktrt_status st = pktrt_add_mesh(s, &d, NULL);
    CHECK(st == PKTRT_OK || (kind == 0 && st == PKTRT_INVALID_ARGUMENT), "%s", pktrt_last_error(s));
    float *pixels = blank(W * H * 3);
    pktrt_render_desc r = view(pixels);
    CHECK(pktrt_commit(s) == PKTRT_OK && pktrt_render(s, &r) == PKTRT_OK);
    size_t bad = 0;
    for (size_t i = 0; i < W * H * 3; i++) bad += !(pixels[i] >= 0 && pixels[i] < 1e4f);
    CHECK(bad == 0, "%zu floats are not finite", bad);
    free(pixels);
    pktrt_scene_destroy(s);
  }
  mesh_free(&m);
}

/* --- refusals --- */

static void refusals(void) {
  world w = world_static(2);
  pktrt_scene *s = lit_scene(&w, PKTRT_ISA_AUTO, 2);
  float *pixels = blank(W * H * 3);
  for (int i = 0; i < 54; i++) {
    pktrt_render_desc d = view(pixels);
    const char *word = "";
    char number[16];
    pktrt_status want = PKTRT_INVALID_ARGUMENT;
    switch (i) {
    case 0: d.width = 0, word = "0"; break;
    case 1: d.height = 0, word = "0"; break;
    case 2: d.pixels = NULL, word = "pixels"; break;
    case 3: d.packet_size = 3, word = "3"; break;
    case 4: d.packet_size = 32, word = "32"; break;
    case 5: memcpy(d.camera.target, d.camera.eye, 12); break;
    case 6:
      for (int k = 0; k < 3; k++) d.camera.up[k] = 2 * (d.camera.target[k] - d.camera.eye[k]);
      break;
    case 7: d.camera.eye[1] = NAN; break;
    case 8: d.camera.target[2] = INFINITY; break;
    case 9: d.camera.fov_y = 180, word = "180"; break;
    case 10: d.camera.fov_y = -20, word = "-20"; break;
    case 11: d.camera.fov_y = NAN; break;
    case 12: d.row_stride = W * 3 - 1, word = "215"; break;
    case 13: d.tile_size = 2000, word = "2000"; break;
    case 14: d.mode = (pktrt_mode)9, word = "9"; break;
    case 15: d.path = (pktrt_path)8, word = "8"; break;
    case 16: d.normals = (pktrt_normals)7, word = "7"; break;
    case 17: d.shadows = (pktrt_shadow_packets)6, word = "6"; break;
    case 18: d.background[1] = NAN; break;
    case 19: d.ambient[2] = INFINITY; break;
    case 20: d.width = 65537, d.row_stride = 0, want = PKTRT_LIMIT, word = "65537"; break;
    case 21: d.height = 70000, want = PKTRT_LIMIT, word = "70000"; break;
    case 22: d.camera.up[0] = NAN; break;
    case 23: d.camera.time = NAN; break;
    case 24: d.camera.time = 1.5f, word = "1.5"; break;
    case 25: d.camera.time = -0.25f, word = "-0.25"; break;
    case 26: d.camera.shutter = -0.5f, word = "-0.5"; break;
    case 27: d.camera.shutter = NAN, word = "shutter"; break;
    case 28: d.camera.shutter = 0.625f, word = "0.625"; break; /* it opens at 0.4 */
    case 29: d.camera.aperture = -3, word = "-3"; break;
    case 30: d.camera.aperture = NAN, word = "aperture"; break;
    case 31: d.camera.aperture = INFINITY, word = "aperture"; break;
    case 32: d.camera.focus = -0.75f, word = "-0.75"; break;
    case 33: d.camera.focus = NAN, word = "focus"; break;
    case 34: d.camera.focus = INFINITY, word = "focus"; break;
    case 35: d.camera.moving = true, d.camera.eye_end[1] = NAN, word = "eye_end"; break;
    case 36:
      d.camera.moving = true, d.camera.eye_end[0] = 1, d.camera.target_end[2] = INFINITY, word = "target_end";
      break;
    case 37: d.camera.moving = true, word = "same point"; break;
    case 38: /* straight down in the end */
      d.camera.moving = true, d.camera.eye_end[1] = 3, d.camera.up_end[1] = 1, word = "up";
      break;
    case 39: d.mode = (pktrt_mode)3, word = "3"; break;
    case 40: d.samples = 65537, word = "65537"; break;
    case 41: d.samples = 0xFFFFFFFFu, word = "4294967295"; break;
    case 42:
      snprintf(number, sizeof number, "%d", PKTRT_SAMPLER_COUNT + 1);
      d.sampler = (pktrt_sampler)(PKTRT_SAMPLER_COUNT + 1), word = number;
      break;
    case 43: d.sampler = (pktrt_sampler)-1, word = "-1"; break;
    case 44: d.max_depth = 51, word = "51"; break;
    case 45: d.attenuation = 1.25f, word = "1.25"; break;
    case 46: d.attenuation = NAN, word = "attenuation"; break;
    case 47: d.attenuation = INFINITY, word = "attenuation"; break;
    case 48: d.assembly = (pktrt_assembly)6, word = "6"; break;
    case 49: d.branching = (pktrt_branching)4, word = "4"; break;
    case 50: d.glass_shadows = (pktrt_glass_shadows)2, word = "2"; break;
    case 51: d.phong_mapping = (pktrt_phong_mapping)2, word = "2"; break;
    case 52: d.lights = (pktrt_light_choice)(PKTRT_LIGHTS_ONE + 1), word = "3"; break;
    default: d.ambient[0] = NAN; break;
    }
    pktrt_status st = pktrt_render(s, &d);
    CHECK(st == want || (i > 19 && i < 22 && st == PKTRT_INVALID_ARGUMENT), "case %d: status %d", i, (int)st);
    CHECK(strlen(pktrt_last_error(s)) > 10 && strstr(pktrt_last_error(s), word), "case %d: \"%s\"", i,
        pktrt_last_error(s));
    CHECK(pktrt_render_tile(s, &d, 0, 0, 8, 8) == st, "case %d: a tile alike", i);
  }
  for (size_t i = 0; i < W * H * 3; i++)
    if (!CHECK(pixels[i] == -7, "refused calls paint nothing")) break;
  CHECK(pktrt_render(s, NULL) == PKTRT_INVALID_ARGUMENT);
  pktrt_render_desc d = view(pixels);
  CHECK(pktrt_render_tile(s, &d, 60, 0, 20, 10) == PKTRT_INVALID_ARGUMENT, "a tile beyond the right border");
  CHECK(pktrt_render_tile(s, &d, 0, 50, 10, 6) == PKTRT_INVALID_ARGUMENT, "a tile beyond the lower border");
  CHECK(pktrt_render_tile(s, &d, 4294967295u, 0, 2, 1) == PKTRT_INVALID_ARGUMENT, "a tile that wraps around");
  CHECK(pktrt_render_tile(s, &d, 0, 0, 0, 0) == PKTRT_OK, "an empty tile is fine");
  CHECK(pktrt_render(s, &d) == PKTRT_OK, "the control");
  pktrt_mesh_desc m = mesh_desc(&w.m[2]); /* a material that does not exist is refused when rendering, by name */
  m.material = 57;
  CHECK(pktrt_add_mesh(s, &m, NULL) == PKTRT_OK && pktrt_commit(s) == PKTRT_OK);
  CHECK(pktrt_render(s, &d) == PKTRT_INVALID_ARGUMENT);
  CHECK(strstr(pktrt_last_error(s), "57") && strstr(pktrt_last_error(s), "4"), "\"%s\"", pktrt_last_error(s));
  pktrt_scene_destroy(s);
  free(pixels);
  world_free(&w);
}

/* In an empty scene, before its first commit and behind it, every ray misses: the background. */
static void empty_scenes(void) {
  world w = world_static(2);
  pktrt_scene_desc sd = scene_desc_of(PKTRT_ISA_AUTO, 0);
  pktrt_scene *s = pktrt_scene_create(&sd);
  float *pixels = blank(W * H * 3);
  pktrt_render_desc d = view(pixels);
  for (int step = 0; step < 3; step++) {
    if (step == 2) CHECK(mesh_add(s, &w.m[0], NULL) == PKTRT_OK);
    if (step) CHECK(pktrt_commit(s) == PKTRT_OK);
    CHECK(pktrt_render(s, &d) == PKTRT_OK, "%s", pktrt_last_error(s));
    size_t other = 0;
    for (size_t i = 0; i < W * H * 3; i++) other += pixels[i] != d.background[i % 3];
    CHECK((other > 100) == (step == 2), "step %d: %zu other floats", step, other);
  }
  pktrt_scene_destroy(s);
  free(pixels);
  world_free(&w);
}

static bool stop_at_half(void *user, float done) {
  int *calls = user;
  (*calls)++;
  return done < 0.5f;
}

static void cancelling(void) {
  world w = world_static(2);
  pktrt_scene *s = lit_scene(&w, PKTRT_ISA_AUTO, 0);
  float *pixels = blank(W * H * 3);
  int calls = 0;
  pktrt_render_desc d = view(pixels);
  d.tile_size = 8, d.progress = stop_at_half, d.user = &calls;
  CHECK(pktrt_render(s, &d) == PKTRT_CANCELLED);
  size_t missing = 0;
  for (size_t i = 0; i < W * H * 3; i++) missing += pixels[i] == -7;
  CHECK(calls > 1 && missing > W * H && missing < 2 * W * H + W * 24, "%d calls, %zu floats missing", calls, missing);
  d.progress = NULL;
  CHECK(pktrt_render(s, &d) == PKTRT_OK);
  pktrt_scene_destroy(s);
  free(pixels);
  world_free(&w);
}

/* Says no from the n-th tile on. */
typedef struct no_from {
  float share;
  int calls;
  pthread_mutex_t lock;
} no_from;

static bool stop_from(void *user, float done) {
  no_from *n = user;
  pthread_mutex_lock(&n->lock);
  n->calls++;
  pthread_mutex_unlock(&n->lock);
  return done < n->share;
}

/* Nothing is missing, so nothing was cancelled. */
static void cancelling_too_late(void) {
  static const uint32_t sizes[3] = {8, 32, 1024};
  world w = world_static(2);
  float *want = blank(W * H * 3), *got = blank(W * H * 3);
  for (int workers = 0; workers <= 3; workers += 3) {
    pktrt_scene *s = lit_scene(&w, PKTRT_ISA_AUTO, workers);
    for (int i = 0; i < 3; i++) {
      uint32_t t = sizes[i], tiles = ((W + t - 1) / t) * ((H + t - 1) / t);
      no_from last = {1, 0, PTHREAD_MUTEX_INITIALIZER};
      pktrt_render_desc d = view(want);
      d.tile_size = t;
      CHECK(pktrt_render(s, &d) == PKTRT_OK);
      d.pixels = got, d.progress = stop_from, d.user = &last;
      for (size_t j = 0; j < W * H * 3; j++) got[j] = -7;
      CHECK(pktrt_render(s, &d) == PKTRT_OK, "%d workers, tiles of %u: no at the last tile", workers, t);
      CHECK((uint32_t)last.calls == tiles && same_bits(want, got, W * H * 12), "%d calls, %u tiles", last.calls, tiles);
      if (tiles == 1) continue;
      last.share = ((float)tiles - 1.5f) / (float)tiles;
      CHECK(pktrt_render(s, &d) == PKTRT_CANCELLED, "the control: no at the last but one");
    }
    pktrt_scene_destroy(s);
  }
  free(want), free(got);
  world_free(&w);
}

/* row_stride: what lies between rows is not touched. Sizes that are no multiple of anything. */
static void strides(void) {
  world w = world_static(2);
  pktrt_scene *s = lit_scene(&w, PKTRT_ISA_AUTO, 2);
  for (uint32_t n = 1; n < 40; n += 3) {
    float *a = blank(n * (n + 1) * 3), *b = blank((n * 3 + 5) * (n + 1));
    pktrt_render_desc d = view(a);
    pktrt_stats stats;
    memset(&stats, 0, sizeof stats);
    d.width = n, d.height = n + 1, d.tile_size = 5, d.stats = &stats;
    CHECK(pktrt_render(s, &d) == PKTRT_OK);
    CHECK(stats.by_type[PKTRT_RAY_PRIMARY].rays == n * (n + 1), "%llu primary rays",
        (unsigned long long)stats.by_type[0].rays);
    CHECK(stats.by_type[PKTRT_RAY_SHADOW].rays <= 3 * stats.by_type[PKTRT_RAY_PRIMARY].hits);
    CHECK(n < 10 || stats.by_type[PKTRT_RAY_SHADOW].rays > 0);
    d.pixels = b, d.row_stride = n * 3 + 5, d.stats = NULL;
    CHECK(pktrt_render(s, &d) == PKTRT_OK);
    for (uint32_t y = 0; y <= n; y++) {
      CHECK(same_bits(a + y * n * 3, b + y * (n * 3 + 5), n * 12));
      for (uint32_t i = 0; i < 5; i++) CHECK(b[y * (n * 3 + 5) + n * 3 + i] == -7, "the gap is painted");
    }
    free(a), free(b);
  }
  pktrt_scene_destroy(s);
  world_free(&w);
}

void suite_render(void) {
  run("pictures of a floor have the values of closed forms", closed_forms);
  run("right is right and up is up", orientation);
  run("smooth normals shade round, geometric ones in facets", smooth_and_geometric);
  run("new shading normals show after a refit", normals_change);
  run("vanishing normals do not spoil a picture", vanishing_normals);
  run("bad render settings are refused by name", refusals);
  run("an empty scene shows the background, committed or not", empty_scenes);
  run("progress can cancel a picture", cancelling);
  run("a no after the last tile cancels nothing", cancelling_too_late);
  run("rows may be apart, sizes may be odd", strides);
  run("a static scene's picture has the same bits for all settings", same_static);
  run("a moving scene's picture has the same bits for all settings", same_moving);
}
