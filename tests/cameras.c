/* Orthographic cameras, lens shift, and looking along the default up. */
#include "pictures.h"

enum { W = 24, H = 16 };

typedef struct told { /* what the log said */
  char text[256];
  int n;
} told;
static void hear(void *user, int level, const char *sentence) {
  told *t = user;
  CHECK(level == 0, "%s", sentence);
  snprintf(t->text, sizeof t->text, "%s", sentence), t->n++;
}
static pktrt_scene *open_to(told *t) {
  pktrt_scene_desc d;
  memset(&d, 0, sizeof d), memset(t, 0, sizeof *t);
  d.log = hear, d.user = t, d.isa = isas[isa_count - 1];
  pktrt_scene *s = pktrt_scene_create(&d);
  if (!CHECK(s != NULL, "%s", pktrt_last_error(NULL))) abort();
  return s;
}

static pktrt_camera camera_at(vec eye, vec target, float width) {
  pktrt_camera c;
  memset(&c, 0, sizeof c);
  vec_put(eye, c.eye), vec_put(target, c.target);
  if (width > 0) c.projection = PKTRT_PROJECTION_ORTHOGRAPHIC, c.width = width;
  return c;
}

/* Rays of one direction, a unit of the world from pixel to pixel, from the plane through the eye. */
static void parallel_rays(void) {
  const pktrt_camera c = camera_at(vec_of(0.5, 0.25, 8), vec_of(0.5, 0.25, 3), W);
  pktrt_scene *s = stage_open();
  const quad ground = quad_of(vec_of(0, 0, -1), vec_of(20, 0, 0), vec_of(0, 20, 0)),
             behind = quad_of(vec_of(0, 0, 8.5), vec_of(20, 0, 0), vec_of(0, 20, 0));
  stage_quad(s, &ground, 0), stage_quad(s, &behind, 0);
  stage_commit(s);
  for (int i = 0; i < W * H; i++) {
    const float want[3] = {(float)(i % W) + 0.5f - W / 2 + 0.5f, H / 2 - (float)(i / W) - 0.5f + 0.25f, 8},
                ahead[3] = {0, 0, -1};
    pktrt_ray r;
    pktrt_hit h;
    CHECK(pktrt_camera_ray(&c, W, H, i % W + 0.5, i / W + 0.5, NULL, 0, &r), "pixel %d", i);
    for (int a = 0; a < 3; a++)
      CHECK(r.origin[a] == want[a] && r.direction[a] == ahead[a], "pixel %d, axis %d: from %g, not %g, to %g", i, a,
          (double)r.origin[a], (double)want[a], (double)r.direction[a]);
    CHECK(pktrt_intersect(s, &r, &h) && h.mesh == 0 && h.t == 9, "pixel %d: mesh %u at %g", i, (unsigned)h.mesh,
        (double)h.t);
  }
  pktrt_scene_destroy(s);
}

/* One of the cameras that are compared: orthographic or with a shift or both; at rest or moving; with a lens or not. */
static pktrt_camera some_camera(int k) {
  pktrt_camera c = camera_at(vec_of(0.3, 2.7, 4.1), vec_of(0, 0.2, 0.1), k % 3 ? 5.5f : 0);
  c.fov_y = 37;
  if (k % 3 < 2) c.shift[0] = 0.25f, c.shift[1] = -0.1f;
  if (k / 3 % 2) c.aperture = 0.5f, c.focus = 3;
  if (k / 6 % 2) {
    c.moving = true, c.eye_end[0] = 1.3f, c.eye_end[1] = 2.2f, c.eye_end[2] = 4;
    c.time = 0.3f, c.shutter = 0.4f;
  }
  return c;
}

/* Depth and normal of each pixel are those of what pktrt_camera_ray meets, by every path and size of packets. */
static void rays_are_the_renderers(void) {
  for (int k = 0; k < 12 * isa_count; k++) {
    const pktrt_camera c = some_camera(k / isa_count);
    const bool lens = c.aperture > 0, drt = k / isa_count >= 3;
    const pktrt_sampling sampling = {PKTRT_SAMPLER_SOBOL, 1, 0};
    float want[W * H];
    size_t hits = 0;
    world w = world_static(2);
    pktrt_scene *s = world_scene(&w, isas[k % isa_count], 0);
    for (uint32_t i = 0; i < W * H; i++) {
      float u[5] = {0.5f, 0.5f, 0.5f, 0.5f, 0.5f}, time = 0;
      pktrt_ray r;
      pktrt_hit h;
      if (drt) pktrt_sample(&sampling, i % W, i / W, 0, 0, 5, u);
      if (c.moving) time = (float)((double)c.time + (double)(lens ? u[4] : u[2]) * (double)c.shutter);
      CHECK(pktrt_camera_ray(&c, W, H, i % W + (double)u[0], i / W + (double)u[1], lens ? u + 2 : NULL, time, &r));
      const bool hit = pktrt_intersect(s, &r, &h);
      want[i] = hit ? (float)((double)h.t * vec_length(vec_from(r.direction))) : INFINITY;
      hits += hit;
    }
    CHECK(hits > W && hits < W * H, "camera %d: %zu hit", k, hits);
    for (int path = PKTRT_PATH_FAST; path <= PKTRT_PATH_SINGLE; path++)
      for (uint32_t size = 2; size <= 16; size *= 2) {
        float pixels[3 * W * H], depth[W * H];
        pktrt_render_desc d =
            stage_view(drt ? PKTRT_MODE_DRT : PKTRT_MODE_RCS, W, H, pixels, vec_of(0, 0, 1), vec_of(0, 0, 0));
        size_t same = 0;
        d.camera = c, d.depth = depth, d.path = (pktrt_path)path, d.packet_size = size;
        stage_render(s, &d);
        for (int i = 0; i < W * H; i++) same += same_bits(&depth[i], &want[i], sizeof *want);
        CHECK(
            same == W * H, "camera %d, path %d, packets of %u: %zu of %d pixels", k, path, (unsigned)size, same, W * H);
      }
    pktrt_scene_destroy(s);
    world_free(&w);
  }
}

/* A shift of whole pixels shows what the camera has beside: the very rays, of sizes that are no powers of two as well. */
static void shifts_of_whole_pixels(void) {
  for (uint32_t width = 1; width <= 700; width += width < 60 ? 1 : 71)
    for (int k = -1; k <= 9; k += 2)
      for (int parallel = 0; parallel < 2; parallel++) {
        const pktrt_camera plain = camera_at(vec_of(0.3, 2.7, 4.1), vec_of(0, 0.2, 0.1), parallel ? 3.3f : 0);
        pktrt_camera shifted = plain;
        pktrt_ray r, q;
        shifted.shift[0] = (float)k / (float)width, shifted.shift[1] = (float)-k / 37;
        CHECK(pktrt_camera_ray(&shifted, width, 37, 0.5, 3.5, NULL, 0, &r), "it is a camera");
        CHECK(pktrt_camera_ray(&plain, width, 37, k + 0.5, k + 3.5, NULL, 0, &q), "it is a camera");
        CHECK(same_bits(&r, &q, sizeof r), "%u pixels, shift %d, projection %d", (unsigned)width, k, parallel);
        shifted.shift[0] += 0.125f / (float)width;
        CHECK(pktrt_camera_ray(&shifted, width, 37, 0.5, 3.5, NULL, 0, &r) && !same_bits(&r, &q, sizeof r),
            "the control: an eighth of a pixel more");
      }
}

/* Pictures side by side are the picture that both are parts of; a camera with a shift keeps its direction. */
static void shifts_of_pictures(void) {
  for (int parallel = 0; parallel < 2; parallel++) {
    float whole[3 * 2 * W * H], part[3 * W * H];
    size_t same = 0, hits = 0;
    world w = world_static(2);
    pktrt_scene *s = world_scene(&w, PKTRT_ISA_AUTO, 0);
    pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, 2 * W, H, whole, vec_of(0, 0, 1), vec_of(0, 0, 0));
    d.camera = camera_at(vec_of(0.3, 2.7, 4.1), vec_of(0, 0.2, 0.1), parallel ? 8 : 0);
    d.ambient[0] = 1, d.normal = NULL;
    stage_render(s, &d);
    for (int side = 0; side < 2; side++) {
      d.width = W, d.pixels = part, d.camera.width = parallel ? 4 : 0;
      d.camera.shift[0] = side ? 0.5f : -0.5f;
      stage_render(s, &d);
      for (int y = 0; y < H; y++)
        for (int x = 0; x < W; x++) {
          const float *a = part + 3 * (y * W + x), *b = whole + 3 * (y * 2 * W + side * W + x);
          same += fabsf(a[0] - b[0]) <= 1e-5f, hits += b[0] > 0;
        }
    }
    CHECK(same == 2 * W * H && hits > W, "projection %d: %zu of %d, %zu hit", parallel, same, 2 * W * H, hits);
    pktrt_scene_destroy(s);
    world_free(&w);
  }
}

/* Shifts of any size: defined, and nothing is seen that is not there. */
static void shifts_without_measure(void) {
  static const float shift[] = {1e6f, -1e9f, 1e20f, -1e30f, FLT_MAX, -FLT_MAX};
  for (size_t i = 0; i < COUNT(shift); i++)
    for (int k = 0; k < 12; k++) {
      float pixels[3 * W * H];
      pktrt_scene *s = stage_open();
      const quad ground = quad_of(vec_of(0, 0, 0), vec_of(1, 0, 0), vec_of(0, 1, 0));
      stage_quad(s, &ground, 0);
      stage_commit(s);
      pktrt_render_desc d =
          stage_view(k / 3 % 2 ? PKTRT_MODE_DRT : PKTRT_MODE_RCS, W, H, pixels, vec_of(0, 0, 1), vec_of(0, 0, 0));
      d.camera = some_camera(k), d.background[1] = 0.5f, d.ambient[0] = 1;
      d.camera.shift[k % 2] = shift[i];
      stage_render(s, &d);
      for (int p = 0; p < W * H; p++)
        CHECK(pixels[3 * p] == 0 && pixels[3 * p + 1] == 0.5f, "shift %g, camera %d, pixel %d: %g %g", (double)shift[i],
            k, p, (double)pixels[3 * p], (double)pixels[3 * p + 1]);
      pktrt_scene_destroy(s);
    }
}

/* With a lens the plane at `focus` is sharp: all rays of a place meet there. */
static void parallel_rays_through_a_lens(void) {
  pktrt_camera c = camera_at(vec_of(0, 0, 5), vec_of(0, 0, 0), 4);
  c.aperture = 1, c.focus = 3;
  double near_ = 0, far = 0;
  for (int i = 0; i < 64; i++) {
    const float u[2] = {((float)(i % 8) + 0.5f) / 8, ((float)(i / 8) + 0.5f) / 8}; /* NULL is the middle, below */
    pktrt_ray r, middle;
    CHECK(pktrt_camera_ray(&c, W, H, 2.5, 1.25, u, 0, &r) && pktrt_camera_ray(&c, W, H, 2.5, 1.25, NULL, 0, &middle));
    for (int a = 0; a < 3; a++) {
      const double off = (double)r.origin[a] - (double)middle.origin[a],
                   at = off + 3 * ((double)r.direction[a] - (double)middle.direction[a]);
      near_ = fmax(near_, fabs(at)), far = fmax(far, fabs(off));
    }
  }
  CHECK(near_ < 1e-6 && far > 0.4 && far <= 0.5, "%g apart where it is sharp, %g on the lens", near_, far);
}

/* Looking along y, the default up: x is to the right, as for a camera that tilts down from -z. Said once. */
static void along_the_default_up(void) {
  for (int parallel = 0; parallel < 2; parallel++)
    for (int sign = -1; sign <= 1; sign += 2)
      for (int moving = 0; moving < 3; moving++) {
        float pixels[3 * W * H];
        told t;
        pktrt_scene *s = open_to(&t);
        pktrt_ray left, right, high, low;
        pktrt_render_desc d = stage_view(PKTRT_MODE_RCS, W, H, pixels, vec_of(0, 0, 1), vec_of(0, 0, 0));
        pktrt_camera c = camera_at(vec_of(0.1, -3 * sign, 0.7), vec_of(0.1, 0, 0.7), parallel ? 1 : 0);
        if (moving) c.moving = true, memcpy(c.eye_end, c.eye, 12), memcpy(c.target_end, c.target, 12);
        if (moving == 1) c.eye[2] = -2; /* it is the end that looks along y */
        const quad ground = quad_of(vec_of(0, 0, 0), vec_of(9, 0, 0), vec_of(0, 0, 9));
        stage_quad(s, &ground, 0);
        stage_commit(s);
        d.camera = c, d.ambient[1] = 1;
        stage_render(s, &d);
        CHECK(t.n == 1 && strstr(t.text, "camera") && strstr(t.text, "up"), "%d sentences: %s", t.n, t.text);
        for (int i = 0; i < W * H; i++) CHECK(pixels[3 * i + 1] > 0.1f, "pixel %d: %g", i, (double)pixels[3 * i + 1]);
        CHECK(
            pktrt_camera_ray(&c, 2, 2, 0.5, 1, NULL, 1, &left) && pktrt_camera_ray(&c, 2, 2, 1.5, 1, NULL, 1, &right));
        CHECK(pktrt_camera_ray(&c, 2, 2, 1, 0.5, NULL, 1, &high) && pktrt_camera_ray(&c, 2, 2, 1, 1.5, NULL, 1, &low));
        const float across = right.origin[0] + right.direction[0] - left.origin[0] - left.direction[0],
                    up = high.origin[2] + high.direction[2] - low.origin[2] - low.direction[2];
        CHECK(across > 0.3f && up * (float)sign > 0.3f, "sign %d: x to %g, z to %g", sign, (double)across, (double)up);
        d.camera.up[2] = 1, t.n = 0;
        stage_render(s, &d);
        CHECK(t.n == 0, "with an up: %s", t.text);
        d.camera.up[1] = 2, d.camera.up[2] = 0, d.camera.moving = false;
        if (moving != 1)
          CHECK(pktrt_render(s, &d) == PKTRT_INVALID_ARGUMENT && strstr(pktrt_last_error(s), "up (0, 2, 0)"));
        pktrt_scene_destroy(s);
      }
}

/* What is not a number, not positive or not there is refused by name; what does not count is said. */
static void mistakes_with_cameras(void) {
  static const struct {
    const char *words;
    float width, shift[2];
    int projection;
  } bad[] = {{"width is 0", 0, {0, 0}, 1}, {"width is -2", -2, {0, 0}, 1}, {"width is nan", NAN, {0, 0}, 1},
      {"width is inf", INFINITY, {0, 0}, 1}, {"width is 2.5", 2.5e30f, {0, 0}, 1}, {"shift[0] is nan", 1, {NAN, 0}, 1},
      {"shift[1] is inf", 0, {0, INFINITY}, 0}, {"shift[1] is -inf", 1, {0, -INFINITY}, 1},
      {"2 is no pktrt_projection", 1, {0, 0}, 2}, {"-1 is no pktrt_projection", 1, {0, 0}, -1}};
  float pixels[3];
  told t;
  pktrt_scene *s = open_to(&t);
  const quad ground = quad_of(vec_of(0, 0, 0), vec_of(1, 0, 0), vec_of(0, 1, 0));
  pktrt_render_desc d = stage_view(PKTRT_MODE_RCS, 1, 1, pixels, vec_of(0, 0, 3), vec_of(0, 0, 0));
  stage_quad(s, &ground, 0);
  stage_commit(s);
  d.ambient[0] = 1;
  const pktrt_camera plain = d.camera;
  for (size_t i = 0; i < COUNT(bad); i++) {
    pktrt_ray r;
    d.camera = plain;
    d.camera.width = bad[i].width, d.camera.projection = (pktrt_projection)bad[i].projection;
    memcpy(d.camera.shift, bad[i].shift, sizeof d.camera.shift);
    CHECK(pktrt_render(s, &d) == PKTRT_INVALID_ARGUMENT && strstr(pktrt_last_error(s), bad[i].words), "\"%s\": %s",
        bad[i].words, pktrt_last_error(s));
    CHECK(!pktrt_camera_ray(&d.camera, 1, 1, 0.5, 0.5, NULL, 0, &r) && r.tmax == 0, "%s", bad[i].words);
  }
  CHECK(t.n == 0, "%s", t.text);
  d.camera = plain, d.camera.fov_y = 0, d.camera.width = 2;
  stage_render(s, &d);
  CHECK(t.n == 1 && strstr(t.text, "width") && strstr(t.text, "PKTRT_PROJECTION_ORTHOGRAPHIC"), "%s", t.text);
  d.camera.fov_y = 1.5f, d.camera.projection = PKTRT_PROJECTION_ORTHOGRAPHIC, t.n = 0;
  stage_render(s, &d);
  CHECK(t.n == 0, "fov_y does not count: %s", t.text);

  /* A lamp behind all of the scene, which rays of the camera see beside it though the eye does not. */
  const quad lamp = quad_of(vec_of(2, 0, 0.5), vec_of(1, 0, -0.5), vec_of(0, 1, 0));
  pktrt_light l = quad_light(&lamp, 1);
  l.visible = true;
  stage_light(s, &l);
  d.camera.eye[2] = 1;
  stage_render(s, &d);
  CHECK(t.n == 0, "a visible lamp: %s", t.text);
  d.camera.projection = PKTRT_PROJECTION_PERSPECTIVE, d.camera.width = d.camera.fov_y = 0;
  stage_render(s, &d);
  CHECK(t.n == 1 && strstr(t.text, "faces away"), "the control: %s", t.text);
  pktrt_scene_destroy(s);
}

/* Rays that start in glass know it, though the eye is outside: what they meet in there is dimmed. */
static void parallel_rays_from_glass(void) {
  float pixels[3 * 2];
  pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  const pktrt_material shine = lamp_of(1);
  const quad lamp = quad_of(vec_of(0, 0, -0.5), vec_of(9, 0, 0), vec_of(0, 9, 0));
  pktrt_scene *s = stage_open();
  mesh box = mesh_box();
  glass.ior[0] = 1, glass.absorption[0] = 1;
  for (uint32_t i = 0; i < box.nv; i++) box.p[3 * i] += 4;
  stage_mesh(s, &box, stage_material(s, &glass));
  stage_quad(s, &lamp, stage_material(s, &shine));
  stage_commit(s);
  pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, 2, 1, pixels, vec_of(0, 0, 0.25), vec_of(0, 0, 0));
  d.camera = camera_at(vec_of(0, 0, 0.25), vec_of(0, 0, -2), 16);
  stage_render(s, &d);
  CHECK(fabs((double)pixels[3] - exp(-0.75)) < 1e-5 && pixels[0] == 1, "%g, not %g; beside it %g", (double)pixels[3],
      exp(-0.75), (double)pixels[0]);
  d.camera.width = 1, d.camera.shift[0] = 4;
  stage_render(s, &d);
  CHECK(fabs((double)pixels[3] - exp(-0.75)) < 1e-5, "by a shift: %g", (double)pixels[3]);
  mesh_free(&box);
  pktrt_scene_destroy(s);
}

void suite_cameras(void) {
  run("rays of an orthographic camera are parallel, as far apart as its width says", parallel_rays);
  run("orthographic and shifted pictures have the rays of pktrt_camera_ray, bit for bit, by every path and packet",
      rays_are_the_renderers);
  run("a shift of whole pixels gives the rays that the camera has so far aside, bit for bit", shifts_of_whole_pixels);
  run("two pictures with shifts of half a width are the halves of one", shifts_of_pictures);
  run("shifts of any size are defined", shifts_without_measure);
  run("rays of an orthographic camera with a lens meet in the plane that is sharp", parallel_rays_through_a_lens);
  run("a camera that looks along the default up takes another, and says so once", along_the_default_up);
  run("mistakes with projection, width and shift are refused by name or told", mistakes_with_cameras);
  run("parallel rays that start in glass know it", parallel_rays_from_glass);
}
