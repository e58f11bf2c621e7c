/* Lights at the limits. Lights that lie in the plane of a surface, or touch one: the surface takes nothing of their
   light, and visible lamps are seen there; each picture is compared with that of the same room without the surface.
   Lights of any size and strength. What is no light is refused. */
#include "pictures.h"

/* A room has a floor, a wall and a ceiling, at the height of the lights, whose corners are multiples of 1/8 of local
   axes. Rows of whole numbers, orthogonal and as long as each other, place it: all corners are exact. */
typedef struct room_frame {
  const char *name;
  vec axis[3];
} room_frame;

static const room_frame frames[] = {{"under a ceiling", {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}},
    {"on a floor", {{1, 0, 0}, {0, -1, 0}, {0, 0, -1}}}, {"at a wall towards x", {{0, 1, 0}, {1, 0, 0}, {0, 0, -1}}},
    {"at a wall towards -x", {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}}},
    {"at a wall towards z", {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}}},
    {"at a wall towards -z", {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}}}, {"under a slope", {{4, -3, 0}, {3, 4, 0}, {0, 0, 5}}},
    {"under a steep slope", {{12, -5, 0}, {0, 0, 13}, {-5, -12, 0}}},
    {"at a tilted wall", {{1, 2, 2}, {2, 1, -2}, {-2, 2, -1}}},
    {"at another tilted wall", {{2, 3, 6}, {3, -6, 2}, {6, 2, -3}}}};

typedef enum lamp_kind { LAMP_POINT, LAMP_QUAD, LAMP_SPHERE, LAMP_MESH, LAMP_FIRST_MESH, LAMP_KINDS } lamp_kind;

typedef struct room {
  const room_frame *frame;
  vec offset;
  double scale;
  lamp_kind lamp;
  double behind; /* how far the lamp lies behind the ceiling */
  bool ceiling, visible, many;
  bool pane; /* of glass, below the ceiling */
  pktrt_material floor;
} room;

static bool room_is_tilted(const room *r) {
  return r->frame->axis[0].x * r->frame->axis[0].y < 0 || r->frame->axis[0].x * r->frame->axis[0].y > 0;
}

static vec room_point(const room *r, double x, double y, double z) {
  vec at = r->offset;
  const double local[3] = {x, y, z};

  for (int a = 0; a < 3; a++) at = vec_add(at, vec_mul(r->frame->axis[a], local[a]));
  return vec_mul(at, r->scale);
}

/* A rectangle of the room, in front of which lies what its edges turn counter-clockwise. */
static quad room_quad(const room *r, const double from[3], const double first[3], const double second[3]) {
  quad q;
  const vec corner = room_point(r, from[0], from[1], from[2]);

  q.corner = corner;
  q.edge[0] = vec_sub(room_point(r, from[0] + first[0], from[1] + first[1], from[2] + first[2]), corner);
  q.edge[1] = vec_sub(room_point(r, from[0] + second[0], from[1] + second[1], from[2] + second[2]), corner);
  return q;
}

static void room_add(pktrt_scene *s, const room *r, const double from[3], const double first[3], const double second[3],
    uint32_t material) {
  const quad q = room_quad(r, from, first, second);

  stage_quad(s, &q, material);
}

/* Adds the lamp: 1 x 1 in the plane of the ceiling, or a ball that touches it. */
static void room_add_lamp(pktrt_scene *s, const room *r, double shift, uint32_t shining) {
  const double y = 3 + r->behind, length = vec_length(r->frame->axis[0]), size = r->scale * length;
  const quad q = room_quad(r, (double[3]){1.5 + shift, y, 1}, (double[3]){1, 0, 0}, (double[3]){0, 0, 1});
  pktrt_light l = quad_light(&q, 4);

  if (r->lamp == LAMP_POINT) {
    l = light_of(PKTRT_LIGHT_POINT, 4 * size * size);
    vec_put(room_point(r, 2 + shift, y, 1.5), l.position);
  }
  if (r->lamp == LAMP_SPHERE) {
    l = light_of(PKTRT_LIGHT_SPHERE, 4);
    l.radius = (float)(0.5 * size);
    vec_put(room_point(r, 2 + shift, r->behind > 0 ? y + 0.5 : 2.5, 1.5), l.position);
  }
  if (r->lamp >= LAMP_MESH) {
    l = light_of(PKTRT_LIGHT_MESH, 1);
    l.mesh = shining;
  }
  l.visible = r->visible && r->lamp != LAMP_POINT && r->lamp < LAMP_MESH;
  stage_light(s, &l);
}

static void room_add_lamp_mesh(pktrt_scene *s, const room *r, uint32_t *index) {
  const quad q = room_quad(r, (double[3]){1.5, 3 + r->behind, 1}, (double[3]){1, 0, 0}, (double[3]){0, 0, 1});
  const pktrt_material lamp = lamp_of(4);

  *index = stage_quad(s, &q, stage_material(s, &lamp));
}

static pktrt_scene *room_open(const room *r) {
  const pktrt_material grey = material_of(0.5, PKTRT_SPECULAR_NONE, 0), black = material_of(0, PKTRT_SPECULAR_NONE, 0),
                       glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  uint32_t shining = 0;
  pktrt_scene *s = stage_open();

  if (r->lamp == LAMP_FIRST_MESH) room_add_lamp_mesh(s, r, &shining);
  room_add(s, r, (double[3]){0, 0, 0}, (double[3]){0, 0, 4}, (double[3]){4, 0, 0}, stage_material(s, &r->floor));
  room_add(s, r, (double[3]){0, 0, 0}, (double[3]){4, 0, 0}, (double[3]){0, 3, 0}, stage_material(s, &grey));
  /* Without a ceiling, its far edge is left: how far rays start from surfaces depends on the scene's extent. */
  room_add(s, r, (double[3]){0, 3, r->ceiling ? 0 : 3.9375}, (double[3]){4, 0, 0},
      (double[3]){0, 0, r->ceiling ? 4 : 0.0625}, stage_material(s, &black));
  if (r->lamp == LAMP_MESH) room_add_lamp_mesh(s, r, &shining);

  if (r->pane) { /* of its two sides each is a mesh of its own */
    const uint32_t pane = stage_material(s, &glass);
    room_add(s, r, (double[3]){0, 2.875, 0}, (double[3]){4, 0, 0}, (double[3]){0, 0, 4}, pane);
    room_add(s, r, (double[3]){0, 2.9375, 0}, (double[3]){0, 0, 4}, (double[3]){4, 0, 0}, pane);
  }

  for (int i = 0; i < (r->many ? 3 : 1); i++) room_add_lamp(s, r, 0.25 * i, shining);
  stage_commit(s);
  return s;
}

enum { ROOM_SIDE = 24, ROOM_FLOATS = 3 * ROOM_SIDE * ROOM_SIDE };

/* Renders the room from a place and towards one, in its own coordinates. */
static void room_render(
    const room *r, const pktrt_render_desc *how, const double eye[3], const double target[3], float *pixels) {
  pktrt_render_desc d = *how;
  pktrt_scene *s = room_open(r);

  d.width = d.height = ROOM_SIDE;
  d.pixels = pixels;
  vec_put(room_point(r, eye[0], eye[1], eye[2]), d.camera.eye);
  vec_put(room_point(r, target[0], target[1], target[2]), d.camera.target);
  vec_put(r->frame->axis[fabs(target[1] - eye[1]) > fabs(target[2] - eye[2]) ? 2 : 1], d.camera.up);
  stage_render(s, &d);
  pktrt_scene_destroy(s);
}

/* Counts the pixels of two pictures that differ, and those of the second that are not black. */
typedef struct room_count {
  size_t pixels, lit, wrong;
  double light, lost;
} room_count;

static void room_compare(const float *got, const float *want, room_count *n) {
  for (size_t i = 0; i < ROOM_FLOATS; i += 3) {
    n->pixels++;
    n->lit += want[i] > 0;
    n->wrong += got[i] < want[i] || got[i] > want[i];
    n->light += (double)want[i];
    n->lost += (double)want[i] - (double)got[i];
  }
}

/* Draws a room: where it lies, its scale, its lamp and what a picture of it may vary in. */
static room room_drawn(rng *random, pktrt_render_desc *how) {
  static const double scale[] = {0x1p-10, 1e-3, 0x1p-5, 1e5, 1, 1e3, 0x1p17}; /* those of two are exact when tilted */
  const double away = rng_below(random, 2) ? 0 : 1000;
  uint32_t drawn;
  room r;

  memset(&r, 0, sizeof r);
  memset(how, 0, sizeof *how);
  r.frame = &frames[rng_below(random, COUNT(frames))];
  r.offset = vec_of(away, -2 * away, 3 * away);
  drawn = rng_below(random, COUNT(scale));
  r.scale = scale[room_is_tilted(&r) ? drawn / 2 * 2 : drawn];
  r.lamp = (lamp_kind)rng_below(random, LAMP_KINDS);
  r.many = rng_below(random, 2) > 0;
  r.pane = rng_below(random, 4) == 0;
  r.floor = material_of(0.75, PKTRT_SPECULAR_NONE, 0);
  how->mode = (pktrt_mode)rng_below(random, 3);
  how->lights = (pktrt_light_choice)rng_below(random, PKTRT_LIGHTS_ONE + 1);
  how->shadows = (pktrt_shadow_packets)rng_below(random, PKTRT_SHADOWS_TOGETHER + 1);
  how->assembly = (pktrt_assembly)rng_below(random, PKTRT_ASSEMBLY_NONE + 1);
  how->path = (pktrt_path)rng_below(random, PKTRT_PATH_SINGLE + 1);
  how->glass_shadows = r.pane ? PKTRT_GLASS_SHADOWS_PASS : (pktrt_glass_shadows)rng_below(random, 2);
  how->packet_size = 2u << rng_below(random, 4);
  how->seed = rng_u32(random);
  how->camera.fov_y = r.pane ? 44 : 46; /* the pane is not seen */
  return r;
}

/* A ceiling takes nothing of a light that lies in its plane or touches it; and all of one that lies behind it by more
   than 2^-20 of the way. But the end of a ray to a point may be off by 2^-24 of its length, which is more than 2^-22 of
   the way where the ray meets a tilted plane at less than 14 degrees: few pixels there may lack the light of a point. */
static void flush_lights(void) {
  room_count sum[LAMP_KINDS], control = {0, 0, 0, 0, 0};
  float got[ROOM_FLOATS], want[ROOM_FLOATS], behind[ROOM_FLOATS];
  size_t in_frame[COUNT(frames)], grazing = 0;

  memset(sum, 0, sizeof sum);
  memset(in_frame, 0, sizeof in_frame);
  for (uint32_t i = 0; i < scaled(800) + thorough(20000); i++) {
    static const double eye[3] = {2, 1.375, 3.75}, target[3] = {2, 1.375, 0};
    rng random = rng_of(i);
    pktrt_render_desc how;
    room r = room_drawn(&random, &how);
    room_count *const n = &sum[r.lamp];
    const size_t before = n->wrong;

    room_render(&r, &how, eye, target, want);
    r.ceiling = true;
    room_render(&r, &how, eye, target, got);
    room_compare(got, want, n);
    in_frame[r.frame - frames]++;
    if (room_is_tilted(&r) && r.lamp == LAMP_POINT) grazing += n->wrong - before, n->wrong = before;
    CHECK(n->wrong == before, "case %u, lamp %d %s, scale %g, away %g, mode %d, lights %d, pane %d: %zu pixels", i,
        (int)r.lamp, r.frame->name, r.scale, r.offset.x, (int)how.mode, (int)how.lights, r.pane, n->wrong - before);

    r.behind = 3 * 0x1p-20 + 0x1p-22 * r.offset.z;
    room_render(&r, &how, eye, target, behind);
    if (r.lamp == LAMP_SPHERE || (r.lamp >= LAMP_MESH && how.mode != PKTRT_MODE_DRT)) continue; /* meant to be lit */
    for (size_t k = 0; k < ROOM_FLOATS; k += 3) control.lit += behind[k] > 0;
    control.pixels += ROOM_FLOATS / 3;
  }

  for (int k = 0; k < LAMP_KINDS; k++) {
    say("lamp %d: of %zu pixels %zu lit, %zu differ, light lost %.3f%%", k, sum[k].pixels, sum[k].lit, sum[k].wrong,
        100 * sum[k].lost / sum[k].light);
    CHECK(sum[k].lit * 4 > sum[k].pixels * 3, "the control: lamp %d lights %zu of %zu", k, sum[k].lit, sum[k].pixels);
  }
  for (size_t k = 0; k < COUNT(frames); k++) CHECK(in_frame[k] > 0, "no room %s", frames[k].name);
  say("%zu pixels lack light of points in tilted planes", grazing);
  CHECK(grazing * 1000 < sum[LAMP_POINT].pixels, "%zu pixels lack light of points", grazing);
  say("behind the ceiling: %zu of %zu pixels lit", control.lit, control.pixels);
  CHECK(control.pixels > 0 && control.lit == 0, "the control: %zu pixels are lit from behind the ceiling", control.lit);
}

/* A visible lamp in the plane of a ceiling is seen by the camera, in a mirror and by lobes, and one behind it is not. */
static void flush_lamps_are_seen(void) {
  static const struct {
    const char *name;
    double eye[3], target[3];
    pktrt_specular floor;
    float exponent;
  } views[] = {{"by the camera", {2, 0.5, 1.75}, {2, 3, 1.5}, PKTRT_SPECULAR_NONE, 0},
      {"in a mirror", {2, 1, 3}, {2, 0, 2.5}, PKTRT_SPECULAR_MIRROR, 0},
      {"in a coat", {2, 1, 3}, {2, 0, 2.5}, PKTRT_SPECULAR_COAT, 0},
      {"by lobes", {2, 1, 3}, {2, 0, 2.5}, PKTRT_SPECULAR_MIRROR, 40}};
  float got[ROOM_FLOATS], want[ROOM_FLOATS], behind[ROOM_FLOATS];

  for (size_t v = 0; v < COUNT(views); v++) {
    room_count sum = {0, 0, 0, 0, 0};
    size_t from_behind = 0;

    for (uint32_t i = 0; i < scaled(200) + thorough(5000); i++) {
      rng random = rng_of(i);
      pktrt_render_desc how;
      room r = room_drawn(&random, &how);

      r.lamp = LAMP_QUAD;
      r.visible = true;
      r.pane = false;
      r.floor = material_of(0, views[v].floor, views[v].floor == PKTRT_SPECULAR_NONE ? 0 : 0.75);
      r.floor.exponent = views[v].exponent;
      how.camera.fov_y = 40;
      if (views[v].floor != PKTRT_SPECULAR_NONE && how.mode == PKTRT_MODE_RCS) how.mode = PKTRT_MODE_DRT;
      if (views[v].exponent > 0) how.mode = PKTRT_MODE_DRT;

      room_render(&r, &how, views[v].eye, views[v].target, want);
      r.ceiling = true;
      room_render(&r, &how, views[v].eye, views[v].target, got);
      room_compare(got, want, &sum);

      r.behind = 3 * 0x1p-20 + 0x1p-22 * r.offset.z;
      room_render(&r, &how, views[v].eye, views[v].target, behind);
      for (size_t k = 0; k < ROOM_FLOATS; k += 3) from_behind += behind[k] > 0;
    }

    say("%s: %zu of %zu pixels lit, %zu differ, %zu from behind", views[v].name, sum.lit, sum.pixels, sum.wrong,
        from_behind);
    CHECK(sum.wrong == 0, "%s: %zu pixels of %zu differ", views[v].name, sum.wrong, sum.lit);
    CHECK(
        sum.lit * 20 > sum.pixels && from_behind == 0, "the controls: %zu lit, %zu from behind", sum.lit, from_behind);
  }
}

/* A visible lamp that lies behind a ceiling by less than 2^-22 of the way is seen, and one that lies farther behind is not:
   0.4 and 3.2 times as much, for the camera; 0.33 and 2.7 in a mirror. */
static void lamps_just_behind(void) {
  static const double behind[3] = {0, 0x1p-22, 0x1p-19};

  for (int in_mirror = 0; in_mirror < 2; in_mirror++) {
    float pixels[ROOM_FLOATS];
    size_t lit[3] = {0, 0, 0};
    room r = {&frames[0], {0, 0, 0}, 1, LAMP_QUAD, 0, true, true, false, false, material_of(0, PKTRT_SPECULAR_NONE, 0)};
    pktrt_render_desc how = stage_view(PKTRT_MODE_WRT, ROOM_SIDE, ROOM_SIDE, pixels, vec_of(0, 0, 0), vec_of(0, 0, 1));

    how.camera.fov_y = 40;
    if (in_mirror) r.floor = material_of(0, PKTRT_SPECULAR_MIRROR, 0.75);
    for (int i = 0; i < 3; i++) {
      r.behind = behind[i];
      if (in_mirror) room_render(&r, &how, (double[3]){2, 1, 3}, (double[3]){2, 0, 2.5}, pixels);
      else room_render(&r, &how, (double[3]){2, 0.5, 1.75}, (double[3]){2, 3, 1.5}, pixels);
      for (size_t k = 0; k < ROOM_FLOATS; k += 3) lit[i] += pixels[k] > 0;
    }
    say("%s: %zu pixels lit in the plane, %zu just behind, %zu behind", in_mirror ? "in a mirror" : "by the camera",
        lit[0], lit[1], lit[2]);
    CHECK(lit[0] > 20 && lit[1] == lit[0], "of %zu pixels of a lamp %zu are lit just behind", lit[0], lit[1]);
    CHECK(lit[2] == 0, "the control: %zu pixels are lit from behind", lit[2]);
  }
}

/* --- any size and strength --- */

static void bright_spot(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  const float strength = *(const float *)user;

  for (uint32_t i = 0; i < n; i++)
    for (int a = 0; a < 3; a++) {
      const float along = 0.6f * direction[0][i] + 0.8f * direction[1][i];
      radiance[a][i] = strength * (along > 0.999f ? 1 : 0x1p-20f);
    }
}

/* A floor that faces up. */
static pktrt_scene *floor_open(const pktrt_material *m) {
  const quad q = quad_of(vec_of(0, 0, 0), vec_of(0, 0, 1), vec_of(1, 0, 0));
  pktrt_scene *s = stage_open();

  stage_quad(s, &q, stage_material(s, m));
  return s;
}

/* Environments 2^n times as bright give pictures 2^n times as bright, bit for bit. */
static void strengths(void) {
  static const int powers[] = {-100, -60, 60, 97, 100, 110, 120, 124, 127};
  const pktrt_material grey = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
  const pktrt_light sky = light_of(PKTRT_LIGHT_ENVIRONMENT, 1);
  float plain[ROOM_FLOATS], got[ROOM_FLOATS], strength = 1;
  pktrt_scene *s = floor_open(&grey);
  pktrt_render_desc d = stage_spot(vec_of(0, 2, 1), vec_of(0, 0, 0));
  double mean = 0;

  stage_light(s, &sky);
  stage_commit(s);
  d.width = d.height = ROOM_SIDE;
  d.environment = bright_spot;
  d.user = &strength;
  d.pixels = plain;
  stage_render(s, &d);
  for (size_t i = 0; i < ROOM_FLOATS; i++) mean += (double)plain[i] / ROOM_FLOATS;
  CHECK(fabs(mean - 0.0008) < 0.00002, "the control: %g", mean);

  for (size_t p = 0; p < COUNT(powers); p++) {
    size_t wrong = 0;
    strength = ldexpf(1, powers[p]);
    d.pixels = got;
    stage_render(s, &d);
    for (size_t i = 0; i < ROOM_FLOATS; i++) wrong += fabsf(got[i] - plain[i] * strength) > 0;
    CHECK(wrong == 0, "2^%d times as bright: %zu of %d values differ", powers[p], wrong, (int)ROOM_FLOATS);
  }
  pktrt_scene_destroy(s);
}

typedef enum wide_kind { WIDE_QUAD, WIDE_SKEW, WIDE_MESH, WIDE_CORNER, WIDE_SPHERE, WIDE_KINDS } wide_kind;

/* The radiance of a spot below a light of the given size, which is one unit above it, or what floats allow. */
static estimate below_wide(wide_kind kind, double size, const pktrt_material *m, bool visible) {
  const double half = size / 2, middle = kind == WIDE_CORNER ? half : 0;
  const quad q =
      quad_of(vec_of(middle, 1, -middle), vec_of(half, 0, kind == WIDE_SKEW ? half / 4 : 0), vec_of(0, 0, half));
  pktrt_scene *s = floor_open(m);
  pktrt_light l = quad_light(&q, 1);
  pktrt_render_desc d = stage_spot(vec_of(0, 0.5, 0.3), vec_of(0, 0, 0));
  estimate e;

  if (kind == WIDE_MESH) {
    const pktrt_material lamp = lamp_of(1);
    l = light_of(PKTRT_LIGHT_MESH, 1);
    l.mesh = stage_quad(s, &q, stage_material(s, &lamp));
  }
  if (kind == WIDE_SPHERE) {
    l = light_of(PKTRT_LIGHT_SPHERE, 1);
    l.position[1] = (float)size;
    l.radius = fminf((float)(size - 1), nextafterf((float)size, 0));
  }
  l.visible = visible && kind != WIDE_MESH;
  stage_light(s, &l);
  stage_commit(s);
  e = stage_estimate(s, &d, 24);
  pktrt_scene_destroy(s);
  return e;
}

/* Lights as wide as the sky light as much as the sky does, those with a corner above the spot a quarter of it. */
static void wide_lights(void) {
  static const char *const names[WIDE_KINDS] = {"quad", "parallelogram", "mesh", "quad to one side", "sphere"};
  static const double sizes[] = {1e6, 1e8, 1e9, 1e11, 1e13};
  const pktrt_material grey = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
  pktrt_material glossy = material_of(0, PKTRT_SPECULAR_MIRROR, 0.5);

  glossy.exponent = 6;
  for (wide_kind kind = WIDE_QUAD; kind < WIDE_KINDS; kind = (wide_kind)(kind + 1)) {
    const estimate lobe = below_wide(kind, 1e4, &glossy, true);
    for (size_t i = 0; i < COUNT(sizes); i++) {
      const double want = kind == WIDE_CORNER ? 0.125 : 0.5;
      const estimate e = below_wide(kind, sizes[i], &grey, false), shiny = below_wide(kind, sizes[i], &glossy, true);
      const double error = sqrt(lobe.error[0] * lobe.error[0] + shiny.error[0] * shiny.error[0]);
      char name[64];

      snprintf(name, sizeof name, "%s of %g", names[kind], sizes[i]);
      check_estimate(name, &e, want, 0.95 * want, 0.01);
      CHECK(fabs(lobe.mean[0] - shiny.mean[0]) < 4 * error + 1e-3 && error < 0.02 && shiny.mean[0] > 0.02,
          "%s in a lobe: %g, not %g", name, shiny.mean[0], lobe.mean[0]);
    }
  }
}

/* Background and ambient light are finite and not negative, or refused by name. */
static void refused_light(void) {
  static const float refused[] = {-1, -FLT_MIN, INFINITY, -INFINITY, NAN};
  static const float taken[] = {0, -0.0f, FLT_MIN, FLT_MAX};
  const pktrt_material grey = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
  pktrt_scene *s = floor_open(&grey);

  stage_commit(s);
  for (int field = 0; field < 6; field++) {
    char name[32];
    snprintf(name, sizeof name, "%s[%d]", field < 3 ? "background" : "ambient", field % 3);

    for (size_t i = 0; i < COUNT(refused) + COUNT(taken); i++) {
      float pixel[3];
      const bool ok = i >= COUNT(refused);
      const float value = ok ? taken[i - COUNT(refused)] : refused[i];
      pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, 1, 1, pixel, vec_of(0, 2, 1), vec_of(0, 0, 0));

      (field < 3 ? d.background : d.ambient)[field % 3] = value;
      const pktrt_status status = pktrt_render(s, &d);
      CHECK((status == PKTRT_OK) == ok, "%s of %g: %d", name, (double)value, (int)status);
      CHECK(ok || strstr(pktrt_last_error(s), name), "%s: \"%s\"", name, pktrt_last_error(s));
    }
  }
  pktrt_scene_destroy(s);
}

void suite_flush(void) {
  run("environments of any strength are sampled alike, bit for bit", strengths);
  run("lights of any size light as much as they fill of the sky", wide_lights);
  run("a background or ambient light that is negative or not finite is refused by name", refused_light);
  run("a visible lamp in the plane of a surface is seen, by all rays", flush_lamps_are_seen);
  run("a visible lamp is seen less than 2^-22 of the way behind a surface, not farther", lamps_just_behind);
  run("a surface in the plane of a light, or that touches it, takes nothing of its light", flush_lights);
}
