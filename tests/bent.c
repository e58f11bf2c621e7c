/* What textures bend: shading normals and the exponents of lobes. */
#include "pictures.h"

enum { SIDE = 16, PIXELS = 3 * SIDE * SIDE };

/* What the texture of a floor does. */
typedef struct bend {
  float corner[4][3];    /* of the floor: normals that are interpolated */
  float normal[3];       /* in their place, of all points, */
  bool interpolates;     /* unless this */
  bool writes, exponent; /* it writes normals, exponents */
  float to;              /* the exponent; 0: by place */
  int points, unlike;    /* points that began otherwise than they should */
  float began;           /* exponent of the material */
} bend;

static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};

static void bends(void *user, const pktrt_points *p) {
  bend *b = user;
  b->points += (int)p->n;
  for (uint32_t i = 0; i < p->n; i++) {
    for (int a = 0; a < 3; a++) {
      const float *n[3];
      b->unlike += p->normal_out[a][i] != p->normal[a][i];
      for (uint32_t c = 0; c < 3; c++) n[c] = &b->corner[corners[p->triangle[i] * 3 + c]][a];
      const float u = p->barycentric[0][i], v = p->barycentric[1][i];
      const float between = *n[0] + (u * (*n[1] - *n[0]) + v * (*n[2] - *n[0]));
      if (b->writes) p->normal_out[a][i] = b->interpolates ? between : b->normal[a];
    }
    b->unlike += p->exponent[i] != b->began;
    if (b->exponent) p->exponent[i] = b->to == 0 ? 10 + 300 * fabsf(p->position[0][i]) : b->to;
  }
}

/* A floor in z = 0, of two triangles, under lights, things and a sky; with vertex normals or a texture. */
typedef struct floor_of {
  pktrt_specular specular;
  float exponent; /* 0: no lobe */
  bool vertex_normals, textured, below, no_sky;
  pktrt_mode mode;
  pktrt_path path;
  uint32_t packets;
  pktrt_phong_mapping mapping;
  bool cutout;
} floor_of;

static void show(const floor_of *f, bend *b, float pixels[PIXELS], float normal[PIXELS]) {
  static const float square[12] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
  const bool mirror = f->specular == PKTRT_SPECULAR_MIRROR;
  const pktrt_material shine = lamp_of(2);
  pktrt_material m = material_of(0.4, f->specular, mirror ? 0.5 : 0);
  pktrt_mesh_desc d;
  pktrt_scene *s = stage_open();
  memset(&d, 0, sizeof d);
  if (f->exponent > 0) m.lobe = PKTRT_LOBE_PHONG, m.exponent = f->exponent;
  if (f->textured) m.texture = bends, m.user = b, m.cutout = f->cutout;
  b->began = m.exponent, b->points = b->unlike = 0;
  d.positions = square, d.vertex_count = 4, d.indices = corners, d.triangle_count = 2;
  if (f->vertex_normals) d.normals = &b->corner[0][0];
  d.material = stage_material(s, &m);
  CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  const float side = f->below ? -1 : 1;
  const quad glow = quad_of(vec_of(0, 1.2, (double)side), vec_of(1, 0, 0), vec_of(0, 0, 0.4));
  quad lamp = quad_of(vec_of(0.5, 0, 3 * (double)side), vec_of(0, 0.5, 0), vec_of(0.5, 0, 0));
  if (f->below) lamp = quad_flipped(lamp);
  pktrt_light point = light_of(PKTRT_LIGHT_POINT, 4), area = quad_light(&lamp, 2),
              sky = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
  point.position[0] = -0.6f, point.position[2] = 1.5f * side;
  stage_quad(s, &glow, stage_material(s, &shine));
  stage_light(s, &point), stage_light(s, &area);
  if (!f->below && !f->no_sky) stage_light(s, &sky);
  stage_commit(s);
  pktrt_render_desc r = stage_view(f->mode, SIDE, SIDE, pixels, vec_of(0.1, -1.2, 1.9), vec_of(0.1, 0.05, 0));
  r.samples = f->mode == PKTRT_MODE_DRT ? 4 : 1, r.path = f->path, r.packet_size = f->packets;
  r.phong_mapping = f->mapping, r.normal = normal, r.camera.fov_y = 30;
  for (int a = 0; a < 3 && !f->below; a++) r.background[a] = 0.3f;
  stage_render(s, &r);
  pktrt_scene_destroy(s);
}

static bend bend_of(float x, float y, float z) {
  bend b;
  memset(&b, 0, sizeof b);
  b.writes = true, b.normal[0] = x, b.normal[1] = y, b.normal[2] = z;
  for (int c = 0; c < 4; c++) b.corner[c][0] = x, b.corner[c][1] = y, b.corner[c][2] = z;
  return b;
}

/* The pictures of one floor: by vertex normals, and by a texture. All materials, modes, paths; normals of any length. */
static void bump_maps(void) {
  size_t differ = 0;
  for (int specular = 0; specular < PKTRT_SPECULAR_COUNT; specular++)
    for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++)
      for (int k = 0; k < 6; k++) {
        float flat[PIXELS], want[PIXELS], is[PIXELS], normal[2][PIXELS];
        bend b = bend_of(0.9f, -0.6f, 3);
        if (k == 4) b = bend_of(0, 3, 1); /* away from the viewer */
        floor_of f = {.specular = (pktrt_specular)specular, .mode = (pktrt_mode)mode, .path = (pktrt_path)(k / 2)};
        f.packets = k % 2 ? 4 : 8, f.exponent = k % 2 ? 60 : 0;
        f.no_sky = true; /* vertex normals stand for a curved surface: a sky behind the triangle lights it */
        if (k % 2) {     /* from corner to corner */
          b.interpolates = true;
          for (int c = 0; c < 4; c++) b.corner[c][c % 2] *= -1, b.corner[c][2] = 0.4f + 0.3f * (float)c;
        }
        show(&f, &b, flat, normal[0]);
        f.vertex_normals = true;
        show(&f, &b, want, normal[0]);
        f.vertex_normals = false, f.textured = true;
        show(&f, &b, is, normal[1]);
        CHECK(same_bits(is, want, sizeof is) && same_bits(normal[0], normal[1], sizeof *normal),
            "specular %d, mode %d, case %d", specular, mode, k);
        CHECK(b.points > SIDE && b.unlike == 0, "%d of %d points began otherwise", b.unlike, b.points);
        differ += !same_bits(flat, want, sizeof flat);
      }
  CHECK(differ > 80, "the control: only %zu pictures of 90 are not the flat floor's", differ);
}

/* A texture that writes what there is changes no bit; nor does one that writes no direction. */
static void no_direction(void) {
  static const float bad[][3] = {{0, 0, 0}, {NAN, 0, 1}, {0, NAN, 1}, {0, 1, NAN}, {INFINITY, 0, 1}, {0, 0, -INFINITY}};
  for (size_t i = 0; i <= COUNT(bad); i++)
    for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++) {
      float want[PIXELS], is[PIXELS], normal[2][PIXELS];
      bend b = bend_of(0.3f, 0.2f, 1), none = b;
      floor_of f = {
          .specular = PKTRT_SPECULAR_COAT, .mode = (pktrt_mode)mode, .vertex_normals = true, .textured = true};
      none.writes = false;
      show(&f, &none, want, normal[0]);
      if (i < COUNT(bad)) memcpy(b.normal, bad[i], sizeof b.normal);
      else b.writes = false, f.textured = false;
      show(&f, &b, is, normal[1]);
      CHECK(same_bits(is, want, sizeof is) && same_bits(normal[0], normal[1], sizeof *normal), "case %zu, mode %d", i,
          mode);
    }
  static const float far[][3] = {{0, 0, FLT_MAX}, {0, 0, 1e-45f}, {0, 0, 7}};
  for (size_t i = 0; i < COUNT(far); i++) {
    float want[PIXELS], is[PIXELS], normal[PIXELS];
    bend b = bend_of(far[i][0], far[i][1], far[i][2]), none = b;
    floor_of f = {.mode = PKTRT_MODE_RCS, .textured = true};
    none.writes = false;
    show(&f, &none, want, normal);
    show(&f, &b, is, normal);
    CHECK(same_bits(is, want, sizeof is), "a normal of length %g", (double)far[i][2]);
  }
}

/* Normals of any direction: those told are on the viewer's side of the triangle; lamps and mirrors beyond it show nothing. */
static void nothing_shines_through(void) {
  rng r = rng_of(1);
  size_t raised = 0, lit = 0;
  for (int k = 0; k < 120; k++) {
    float is[PIXELS], normal[PIXELS];
    bend b = bend_of(rng_sign(&r), rng_sign(&r), rng_sign(&r));
    if (k < 9) b.normal[0] = b.normal[1] = 0, b.normal[2] = -1; /* straight to behind */
    if (k % 10 == 9) b.normal[0] *= 0.01f, b.normal[1] *= 0.01f, b.normal[2] = -1;
    floor_of f = {.mode = (pktrt_mode)(k % 3), .textured = true, .below = k / 3 % 3 > 0};
    if (k / 3 % 3 == 2) f.specular = PKTRT_SPECULAR_MIRROR, f.exponent = k / 9 % 2 ? 30 : 0;
    if (k / 3 % 6 == 5) f.specular = PKTRT_SPECULAR_COAT;
    show(&f, &b, is, normal);
    for (int i = 0; i < SIDE * SIDE; i++) {
      const vec n = vec_from(normal + 3 * i);
      const bool whole = f.mode != PKTRT_MODE_DRT || vec_length(n) > 0.999; /* no mean over an edge */
      if (n.z == 0 || !whole) continue;
      CHECK(fabs(vec_length(n) - 1) < (f.mode == PKTRT_MODE_DRT ? 1e-3 : 1e-6), "case %d: length %g", k, vec_length(n));
      /* From behind it is a cosine of 1/64; straight from behind, where there is no other direction, the triangle's own. */
      const bool behind = b.normal[2] < 0 && (b.normal[0] != 0 || b.normal[1] != 0);
      CHECK(!behind || n.z < 0.0157, "case %d, pixel %d: a cosine of %g", k, i, n.z);
      raised += n.z<0.0157, lit += is[3 * i]> 0;
      CHECK(n.z > 0.0156 * 0.99 && n.z < 1.001, "case %d, pixel %d: normal (%g, %g, %g)", k, i, n.x, n.y, n.z);
      CHECK(!f.below || is[3 * i] == 0, "case %d, pixel %d: %g shines through", k, i, (double)is[3 * i]);
    }
  }
  CHECK(raised > 1000 && lit > 1000, "%zu raised, %zu lit", raised, lit);
}

/* The exponent that a texture sets is as the material's, bit for bit; what is none leaves the material's. */
static void exponents(void) {
  static const struct {
    float written, as;
  } cases[] = {
      {40, 40}, {0.5f, 0.5f}, {1e6f, 1e6f}, {NAN, 25}, {-1, 25}, {-INFINITY, 25}, {INFINITY, 1e9f}, {3e30f, 1e9f}};
  static const pktrt_specular lobed[3] = {PKTRT_SPECULAR_MIRROR, PKTRT_SPECULAR_COAT, PKTRT_SPECULAR_CONDUCTOR};
  size_t differ = 0;
  for (size_t i = 0; i < COUNT(cases); i++)
    for (int k = 0; k < 18; k++) {
      float own[PIXELS], want[PIXELS], is[PIXELS], normal[PIXELS];
      bend b = bend_of(0, 0, 1);
      floor_of f = {.mode = k / 9 ? PKTRT_MODE_DRT : PKTRT_MODE_WRT, .specular = lobed[k % 3], .textured = true};
      f.mapping = k % 2 ? PKTRT_PHONG_NAIVE : PKTRT_PHONG_CAREFUL, f.path = (pktrt_path)(k / 3 % 3);
      b.writes = false, f.exponent = 25;
      show(&f, &b, own, normal);
      b.exponent = true, b.to = cases[i].written;
      show(&f, &b, is, normal);
      b.exponent = false, f.exponent = cases[i].as;
      show(&f, &b, want, normal);
      CHECK(same_bits(is, want, sizeof is), "exponent %g, case %d", (double)cases[i].written, k);
      differ += !same_bits(is, own, sizeof is);
    }
  CHECK(differ > 4 * 18, "the control: %zu pictures", differ);
}

/* Normals and exponents by place: the same bits by all paths, sizes of packets, and as cutouts, which ask twice. */
static void bent_by_every_path(void) {
  float want[PIXELS], is[PIXELS], normal[PIXELS];
  for (int k = 0; k < 13; k++) {
    bend b = bend_of(0.2f, 0.3f, 1);
    floor_of f = {.mode = PKTRT_MODE_DRT, .specular = PKTRT_SPECULAR_COAT, .exponent = 25, .textured = true};
    f.path = (pktrt_path)(k / 4 % 3), f.packets = 2u << k % 4, f.cutout = k == 12;
    b.exponent = b.interpolates = true, b.corner[0][0] = -0.4f;
    show(&f, &b, k ? is : want, normal);
    CHECK(b.unlike == 0 && b.points > SIDE, "%d of %d points began otherwise", b.unlike, b.points);
    if (k) CHECK(same_bits(is, want, sizeof is), "case %d", k);
  }
}

/* A shader gets the bent normal. */
static void tell_normal(void *user, const pktrt_points *p, float *radiance[3]) {
  (void)user;
  for (int a = 0; a < 3; a++)
    for (uint32_t i = 0; i < p->n; i++)
      radiance[a][i] = p->normal[a][i], p->normal_out[a][i] = NAN, p->exponent[i] = NAN;
}
static void shaders_see_bent_normals(void) {
  float pixels[PIXELS];
  bend b = bend_of(0, 0.6f, 0.8f);
  pktrt_material m = material_of(0.5, PKTRT_SPECULAR_COAT, 0);
  pktrt_scene *s = stage_open();
  const quad ground = quad_of(vec_of(0, 0, 0), vec_of(9, 0, 0), vec_of(0, 9, 0));
  m.texture = bends, m.shader = tell_normal, m.user = &b, m.lobe = PKTRT_LOBE_PHONG, m.exponent = 9;
  stage_quad(s, &ground, stage_material(s, &m));
  stage_commit(s);
  const pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, SIDE, SIDE, pixels, vec_of(0, 0, 3), vec_of(0, 0, 0));
  stage_render(s, &d);
  for (int i = 0; i < PIXELS; i++)
    CHECK(fabsf(pixels[i] - b.normal[i % 3]) < 1e-6f, "value %d: %g", i, (double)pixels[i]);
  pktrt_scene_destroy(s);
}

/* A worker needs as much memory with a texture as without. */
static void bends_take_no_memory(void) {
  uint64_t worker[2];
  for (int textured = 0; textured < 2; textured++) {
    float pixels[PIXELS];
    pktrt_scene_report report;
    pktrt_material m = material_of(0.5, PKTRT_SPECULAR_COAT, 0);
    pktrt_scene *s = stage_open();
    const quad ground = quad_of(vec_of(0, 0, 0), vec_of(9, 0, 0), vec_of(0, 9, 0));
    m.lobe = PKTRT_LOBE_PHONG, m.exponent = 9, m.texture = textured ? bends : NULL;
    stage_quad(s, &ground, stage_material(s, &m));
    stage_commit(s);
    const pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, SIDE, SIDE, pixels, vec_of(0, 0, 3), vec_of(0, 0, 0));
    pktrt_get_scene_report(s, &d, &report);
    worker[textured] = report.worker;
    pktrt_scene_destroy(s);
  }
  CHECK(worker[0] == worker[1] && worker[0] > 0, "%llu and %llu bytes", (unsigned long long)worker[0],
      (unsigned long long)worker[1]);
}

void suite_bent(void) {
  run("a texture that bends normals gives the picture of such vertex normals, bit for bit", bump_maps);
  run("a bent normal that is none leaves the normal that there is, and any length counts", no_direction);
  run("nothing shines through a surface, however a texture bends its normals", nothing_shines_through);
  run("an exponent set by a texture is as the material's, bit for bit", exponents);
  run("bent normals and exponents have the same bits by every path and packet, and in cutouts", bent_by_every_path);
  run("a shader gets the normal that a texture bent", shaders_see_bent_normals);
  run("what textures may bend takes no memory", bends_take_no_memory);
}
