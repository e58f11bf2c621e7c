/* The report of a scene: what is found, what of it runs, where the bytes are, and the same as text. */
#include "pictures.h"

enum { W = 40, H = 30, NAMES = 17 };

/* --- a scene with one thing in it --- */

typedef struct request {
  uint32_t keys, group, mask; /* of the ball */
  bool normals, texcoords, lit, placed, hidden;
  bool removed; /* another mesh, which was there */
  pktrt_material look;
  pktrt_light light;
  pktrt_render_desc view;
  pktrt_stats stats;
  float pixels[W * H * 3];
} request;

static void defaults(request *r, pktrt_mode mode) {
  memset(r, 0, sizeof *r);
  r->keys = 1, r->lit = true;
  r->look = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
  r->light = light_of(PKTRT_LIGHT_POINT, 60);
  r->light.position[0] = 2, r->light.position[1] = 4, r->light.position[2] = 2;
  r->view = stage_view(mode, W, H, r->pixels, vec_of(1, 1.5, 4), vec_of(0, 0, 0));
  r->view.samples = 2;
  r->view.camera.time = r->view.camera.shutter = 0;
}

/* A floor, and a ball to which all that happens happens. */
static pktrt_scene *make(const request *r) {
  pktrt_scene *s = stage_open();
  mesh floor = mesh_grid(8, 4), ball = mesh_sphere(3, 0.05f, 1);
  mesh_shift(&floor, 0, -1.2f, 0);
  if (r->keys > 1) mesh_move(&ball, r->keys, 0.4f, 0.05f, 2);
  pktrt_mesh_desc d = mesh_desc(&ball);
  d.material = stage_material(s, &r->look);
  if (r->normals) d.normals = ball.p;
  if (r->texcoords) d.texcoords = ball.p; /* the first two of three */
  d.group = r->group, d.mask = r->placed ? 0 : r->mask;
  stage_mesh(s, &floor, 0);
  const pktrt_instance_desc at = {0, 1, NULL, r->mask, PKTRT_INTERPOLATION_LINEAR};
  CHECK((r->placed ? pktrt_add_model(s, &d, 1, NULL) || pktrt_add_instance(s, &at, NULL)
                   : pktrt_add_mesh(s, &d, NULL)) == 0,
      "%s", pktrt_last_error(s));
  if (r->lit) stage_light(s, &r->light);
  if (r->hidden) CHECK(pktrt_set_enabled(s, 1, false) == PKTRT_OK);
  const uint32_t other = r->removed ? stage_mesh(s, &floor, 0) : 0;
  stage_commit(s);
  if (r->removed) CHECK(pktrt_remove_mesh(s, other) == PKTRT_OK), stage_commit(s);
  mesh_free(&floor), mesh_free(&ball);
  return s;
}

/* The report of it; its picture, too, in its pixels. */
static pktrt_scene_report report_of(request *r) {
  pktrt_scene *s = make(r);
  pktrt_scene_report x;
  r->view.pixels = NULL;
  pktrt_get_scene_report(s, &r->view, &x);
  r->view.pixels = r->pixels;
  stage_render(s, &r->view);
  pktrt_scene_destroy(s);
  return x;
}

static const pktrt_mode modes[3] = {PKTRT_MODE_RCS, PKTRT_MODE_WRT, PKTRT_MODE_DRT};
static const char *const mode_names[3] = {"RCS", "WRT", "DRT"};

/* --- features --- */

static void flat_colour(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) p->albedo[0][i] = 0;
}
static void time_colour(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) p->albedo[0][i] = 0.5f + 0.5f * p->time[i];
}
static void texcoord_colour(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) p->albedo[0][i] = 0.5f + 0.25f * p->texcoord[0][i];
}
static void cut(void *user, const pktrt_points *p) {
  flat_colour(user, p);
  for (uint32_t i = 0; i < p->n; i++) p->opacity[i] = p->position[1][i] > 0 ? 1.0f : 0.0f;
}
static void white(void *user, const pktrt_points *p, float *radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) radiance[0][i] = radiance[1][i] = radiance[2][i] = 1;
}

static void add_motion(request *r) { r->keys = 3, r->view.camera.time = 0.5f; }
static void add_camera_motion(request *r) {
  r->view.camera.moving = true, r->view.camera.time = 0.5f;
  memcpy(r->view.camera.eye_end, r->view.camera.eye, sizeof r->view.camera.eye);
  memcpy(r->view.camera.target_end, r->view.camera.target, sizeof r->view.camera.target);
  r->view.camera.eye_end[0] += 1;
}
static void add_normals(request *r) { r->normals = true; }
static void add_unseen_normals(request *r) { r->normals = true, r->view.normals = PKTRT_NORMALS_GEOMETRIC; }
static void add_mirror(request *r) { r->look = material_of(0.5, PKTRT_SPECULAR_MIRROR, 0.5); }
static void add_coat(request *r) { r->look = material_of(0.5, PKTRT_SPECULAR_COAT, 0); }
static void add_glass(request *r) { r->look = material_of(0.5, PKTRT_SPECULAR_DIELECTRIC, 0); }
static void add_metal(request *r) {
  r->look = material_of(0.5, PKTRT_SPECULAR_CONDUCTOR, 0);
  for (int a = 0; a < 3; a++) r->look.ior[a] = 0.3f, r->look.extinction[a] = 3;
}
static void add_gloss(request *r) { add_mirror(r), r->look.lobe = PKTRT_LOBE_PHONG, r->look.exponent = 20; }
static void add_texture(request *r) { r->look.texture = flat_colour; }
static void add_shader(request *r) { r->look.shader = white; }
static void add_quad(request *r) {
  r->light.kind = PKTRT_LIGHT_QUAD; /* that faces down */
  r->light.edge[0][0] = r->light.edge[1][2] = 1, r->light.edge[1][1] = 0.25f;
}
static void add_sphere(request *r) { r->light.kind = PKTRT_LIGHT_SPHERE, r->light.radius = 0.5f; }
static void add_lens(request *r) { r->view.camera.aperture = 0.3f, r->view.camera.focus = 2; }
/* About the time that pictures are of without it: where it does not run, its middle is taken. */
static void add_shutter(request *r) { r->view.camera.time = 0, r->view.camera.shutter = 1; }
static void add_texture_in_time(request *r) { r->look.texture = time_colour, r->view.camera.time = 0.5f; }
static void open_shutter_on_texture(request *r) { add_texture_in_time(r), add_shutter(r); }
static void open_shutter_on_motion(request *r) { add_motion(r), add_shutter(r); }
static void add_instance(request *r) { r->placed = true; }
static void add_group(request *r) { r->group = 3; }
static void add_mask(request *r) { r->mask = 3; }
static void add_masked_instance(request *r) { add_instance(r), add_mask(r); }
static void remove_other(request *r) { r->removed = true; }
static void hide_ball(request *r) { r->hidden = true; }
static void add_texcoords(request *r) { r->texcoords = true; }
static void look_at_texcoords(request *r) { r->look.texture = texcoord_colour; }
static void add_drawn_texcoords(request *r) { look_at_texcoords(r), add_texcoords(r); }
static void add_cutout(request *r) { r->look.texture = cut, r->look.cutout = true; }
static void add_paper(request *r) { r->view.path = PKTRT_PATH_PAPER; }
static void add_stats(request *r) { r->view.stats = &r->stats; }

enum { RCS = 1, WRT = 2, DRT = 4, ALL = 7, NONE = 0 };
enum { MOTION = PKTRT_FEATURE_MOTION, TEXTURES = PKTRT_FEATURE_TEXTURES, MIRROR = PKTRT_FEATURE_MIRROR };
static const struct feature_case {
  const char *name;
  void (*before)(request *); /* what it is compared with; NULL: the plain scene */
  void (*add)(request *);
  uint32_t bit, also; /* what is added, and what is there beside it */
  int runs, shows;    /* the modes in which it runs, and whose pictures become other ones */
} cases[] = {
    {"a moving mesh", NULL, add_motion, MOTION, 0, ALL, ALL},
    {"a moving camera", NULL, add_camera_motion, MOTION, 0, ALL, ALL},
    {"normals", NULL, add_normals, PKTRT_FEATURE_NORMALS, 0, ALL, ALL},
    {"normals, not looked at", NULL, add_unseen_normals, PKTRT_FEATURE_NORMALS, 0, NONE, NONE},
    {"a mirror", NULL, add_mirror, MIRROR, 0, WRT | DRT, WRT | DRT},
    {"varnish", NULL, add_coat, MIRROR, 0, WRT | DRT, WRT | DRT},
    {"glass", NULL, add_glass, PKTRT_FEATURE_DIELECTRIC, 0, WRT | DRT, WRT | DRT},
    {"metal", NULL, add_metal, PKTRT_FEATURE_CONDUCTOR, 0, WRT | DRT, WRT | DRT},
    {"gloss", add_mirror, add_gloss, PKTRT_FEATURE_GLOSS, MIRROR, WRT | DRT, WRT | DRT},
    {"a texture", NULL, add_texture, TEXTURES, 0, ALL, ALL},
    {"a shader", NULL, add_shader, TEXTURES, 0, ALL, ALL},
    {"a quad light", NULL, add_quad, PKTRT_FEATURE_AREA_LIGHTS, 0, ALL, ALL},
    {"a sphere light", NULL, add_sphere, PKTRT_FEATURE_AREA_LIGHTS, 0, ALL, ALL},
    {"a lens", NULL, add_lens, PKTRT_FEATURE_LENS, 0, DRT, DRT},
    {"a shutter where nothing moves", NULL, add_shutter, PKTRT_FEATURE_SHUTTER, 0, NONE, NONE},
    {"a shutter where a texture looks at times", add_texture_in_time, open_shutter_on_texture, PKTRT_FEATURE_SHUTTER,
        TEXTURES, DRT, DRT},
    {"a shutter where a mesh moves", add_motion, open_shutter_on_motion, PKTRT_FEATURE_SHUTTER, MOTION, DRT, DRT},
    {"an instance", NULL, add_instance, PKTRT_FEATURE_INSTANCES, 0, ALL, NONE},
    {"a group", NULL, add_group, PKTRT_FEATURE_GROUPS, 0, ALL, NONE},
    {"a mask", NULL, add_mask, PKTRT_FEATURE_GROUPS, 0, ALL, NONE},
    {"a mask of an instance", add_instance, add_masked_instance, PKTRT_FEATURE_GROUPS, PKTRT_FEATURE_INSTANCES, ALL,
        NONE},
    {"a removed mesh", NULL, remove_other, PKTRT_FEATURE_REMOVAL, 0, ALL, NONE},
    {"a hidden mesh", NULL, hide_ball, PKTRT_FEATURE_REMOVAL, 0, ALL, ALL},
    {"texture coordinates", NULL, add_texcoords, PKTRT_FEATURE_SURFACES, 0, ALL, NONE},
    {"texture coordinates that a texture looks at", look_at_texcoords, add_drawn_texcoords, PKTRT_FEATURE_SURFACES,
        TEXTURES, ALL, ALL},
    {"a cutout", add_texture, add_cutout, PKTRT_FEATURE_SURFACES, TEXTURES, ALL, ALL},
    {"the paper's path", NULL, add_paper, PKTRT_FEATURE_PAPER, 0, ALL, NONE},
    {"counting", NULL, add_stats, PKTRT_FEATURE_STATS, 0, ALL, NONE},
};

static void plain_scenes(void) {
  for (int m = 0; m < 3; m++) {
    request r;
    defaults(&r, modes[m]);
    const pktrt_scene_report x = report_of(&r);
    CHECK(x.built == (1u << NAMES) - 1, "%x is built", (unsigned)x.built);
    CHECK(x.found == PKTRT_FEATURE_RENDER && x.used == PKTRT_FEATURE_RENDER, "%s: found %x, used %x", mode_names[m],
        (unsigned)x.found, (unsigned)x.used);
    CHECK(x.motion == 0 && x.normals == 0 && x.passes == 0 && x.info.moving_meshes == 0);
    CHECK(x.info.mesh_count == 2 && x.info.triangles == 128 + 512, "%llu triangles",
        (unsigned long long)x.info.triangles);
  }
  request r; /* the control: a feature among them is told */
  defaults(&r, PKTRT_MODE_RCS);
  add_motion(&r);
  const pktrt_scene_report x = report_of(&r);
  CHECK(x.found != PKTRT_FEATURE_RENDER && x.motion > 0 && x.info.moving_meshes == 1);
}

/* One case in one mode; true if the picture is another one than without it. */
static bool try_case(const struct feature_case *c, int m) {
  static request without, with;
  defaults(&without, modes[m]), defaults(&with, modes[m]);
  if (c->before) c->before(&without);
  c->add(&with);
  const pktrt_scene_report a = report_of(&without), b = report_of(&with);
  const bool runs = c->runs >> m & 1, differs = !same_bits(without.pixels, with.pixels, sizeof with.pixels);
  const uint32_t base = PKTRT_FEATURE_RENDER | c->also;
  CHECK(a.found == base && b.found == (base | c->bit), "%s, %s: found %x, without %x", c->name, mode_names[m],
      (unsigned)b.found, (unsigned)a.found);
  CHECK((b.used & c->bit) == (runs ? c->bit : 0), "%s, %s: %x is used", c->name, mode_names[m], (unsigned)b.used);
  CHECK(!(b.used & ~b.found) && !(a.used & ~a.found), "%s, %s: more is used than found", c->name, mode_names[m]);
  CHECK(differs == (c->shows >> m & 1), "%s, %s: the picture is %s", c->name, mode_names[m],
      differs ? "another one" : "the same");
  CHECK(runs || !differs, "%s, %s: idle, and yet one sees it", c->name, mode_names[m]);
  return differs;
}

static void features(void) {
  uint32_t tried = 0;
  int seen = 0;
  for (size_t i = 0; i < COUNT(cases); i++)
    for (int m = 0; m < 3; m++) seen += try_case(&cases[i], m), tried |= cases[i].bit;
  CHECK((tried | PKTRT_FEATURE_RENDER) == (1u << NAMES) - 1, "%x is tried", (unsigned)tried);
  say("%zu cases in three modes; %d pictures are other ones than without", COUNT(cases), seen);
}

static void queries_only(void) {
  pktrt_scene_report x;
  request r;
  defaults(&r, PKTRT_MODE_DRT);
  add_motion(&r), add_gloss(&r), add_lens(&r);
  pktrt_scene *s = make(&r);
  pktrt_get_scene_report(s, NULL, &x);
  CHECK(x.found == (MOTION | MIRROR | PKTRT_FEATURE_GLOSS), "found %x", (unsigned)x.found);
  CHECK(x.used == MOTION && x.worker == 0 && x.passes == 0, "used %x", (unsigned)x.used);
  pktrt_scene_destroy(s);
}

/* --- bytes --- */

static uint64_t sum_of(const pktrt_scene_report *x) {
  return x->nodes + x->blocks + x->motion + x->positions + x->normals + x->texcoords + x->indices + x->ids +
         x->materials + x->instances;
}

/* Beside the scene's info, and what the hook has handed out: a little more, for the scene itself and room to grow. */
static void agree_with_scene(const char *when, const pktrt_scene *s, pktrt_scene_report *x) {
  enum { OTHER = 16384 };
  pktrt_scene_info info;
  pktrt_get_scene_info(s, &info);
  pktrt_get_scene_report(s, NULL, x);
  CHECK(x->bytes == sum_of(x), "%s: %llu bytes in all", when, (unsigned long long)x->bytes);
  CHECK(x->bytes - x->ids - x->materials - x->instances == info.tree_bytes + info.mesh_bytes,
      "%s: %llu and %llu bytes of info", when, (unsigned long long)info.tree_bytes,
      (unsigned long long)info.mesh_bytes);
  CHECK(same_bits(&x->info, &info, sizeof info), "%s: the info within it", when);
  CHECK(x->bytes <= hooks.live_bytes && hooks.live_bytes < x->bytes + x->bytes / 8 + OTHER,
      "%s: %llu bytes, %zu handed out", when, (unsigned long long)x->bytes, hooks.live_bytes);
}

static void bytes(void) {
  const char *const whens[5] = {"static", "moving", "with normals", "waiting for a refit", "with texture coordinates"};
  pktrt_scene_report x[5];
  for (int i = 0; i < 5; i++) {
    mesh ball = mesh_sphere(small_run ? 4 : 6, 0.05f, 1);
    if (i > 0) mesh_move(&ball, 3, 0.4f, 0.05f, 2);
    const uint64_t positions = (uint64_t)ball.nv * 12;
    pktrt_scene *s = stage_open();
    pktrt_mesh_desc d = mesh_desc(&ball);
    if (i > 1) d.normals = ball.p;
    if (i > 3) d.texcoords = ball.p;
    CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
    stage_commit(s);
    if (i > 2) CHECK(pktrt_set_positions(s, 0, 1, ball.p) == PKTRT_OK);
    agree_with_scene(whens[i], s, &x[i]);
    CHECK(x[i].positions == positions * (i > 2 ? 2 : 1) && x[i].normals == (i > 1 ? positions : 0), "%s", whens[i]);
    CHECK(x[i].indices == (uint64_t)ball.nt * 12, "%s", whens[i]);
    CHECK(x[i].texcoords == (i > 3 ? (uint64_t)ball.nv * 8 : 0), "%s", whens[i]);
    say("%-24s %5.1f bytes per triangle, %4.1f of them for further keys", whens[i],
        (double)x[i].bytes / (double)x[i].info.triangles, (double)x[i].motion / (double)x[i].info.triangles);
    pktrt_scene_destroy(s);
    mesh_free(&ball);
  }
  CHECK(x[0].motion == 0 && x[1].motion > x[1].positions, "further keys take bytes");
  CHECK(x[1].positions == x[0].positions && x[1].indices == x[0].indices, "of first keys only");
  CHECK(x[3].motion - x[2].motion == 2 * x[2].positions, "what waits has further keys, too");
  CHECK(x[4].bytes - x[3].bytes == x[4].texcoords, "texture coordinates have none, and are part of the sum");
}

/* States that a scene passes through: after each the report agrees with the scene's info and the hooks, and says what waits. */
static void bytes_in_rare_states(void) {
  pktrt_scene_report x;
  mesh ball = mesh_sphere(small_run ? 3 : 5, 0.05f, 1);
  const uint64_t one = (uint64_t)ball.nv * 12;
  pktrt_scene *s = stage_open();
  pktrt_mesh_desc d = mesh_desc(&ball);
  d.normals = ball.p;
  for (int i = 0; i < 2; i++) CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
  stage_commit(s);
  agree_with_scene("two meshes", s, &x);
  CHECK(x.positions == 2 * one && x.normals == 2 * one, "%llu and %llu bytes", (unsigned long long)x.positions,
      (unsigned long long)x.normals);

  CHECK(pktrt_set_normals(s, 1, 0, ball.p) == PKTRT_OK);
  agree_with_scene("normals that wait", s, &x);
  CHECK(x.positions == 2 * one && x.normals == 3 * one, "%llu bytes of normals", (unsigned long long)x.normals);
  CHECK(pktrt_set_positions(s, 0, 0, ball.p) == PKTRT_OK);
  agree_with_scene("normals of one and positions of another mesh that wait", s, &x);
  CHECK(x.positions == 3 * one && x.normals == 3 * one, "%llu bytes of positions", (unsigned long long)x.positions);
  CHECK(pktrt_refit(s) == PKTRT_OK);
  agree_with_scene("after their refit", s, &x);
  CHECK(x.positions <= 3 * one && x.normals <= 3 * one);

  CHECK(pktrt_remove_mesh(s, 0) == PKTRT_OK);
  agree_with_scene("a mesh that is to be removed", s, &x);
  stage_commit(s);
  agree_with_scene("a mesh that was removed", s, &x);
  CHECK(x.indices == (uint64_t)ball.nt * 12 && x.info.triangles == ball.nt, "one mesh is left");
  CHECK(x.found & PKTRT_FEATURE_REMOVAL, "an index waits for another mesh");

  pktrt_instance_desc place;
  memset(&place, 0, sizeof place);
  CHECK(pktrt_add_model(s, &d, 1, &place.model) == PKTRT_OK);
  uint32_t instance[3];
  for (int i = 0; i < 3; i++) CHECK(pktrt_add_instance(s, &place, &instance[i]) == PKTRT_OK);
  agree_with_scene("instances that wait", s, &x);
  CHECK(x.info.instance_count == 0);
  stage_commit(s);
  agree_with_scene("instances", s, &x);
  const uint64_t of_three = x.instances;
  CHECK(x.info.instance_count == 3 && (x.found & PKTRT_FEATURE_INSTANCES));
  CHECK(pktrt_remove_instance(s, instance[1]) == PKTRT_OK);
  agree_with_scene("an instance that is to be removed", s, &x);
  CHECK(x.info.instance_count == 3, "until the commit it is there");
  stage_commit(s);
  agree_with_scene("an instance that was removed", s, &x);
  CHECK(x.info.instance_count == 2 && x.instances <= of_three, "%u instances", (unsigned)x.info.instance_count);
  for (int i = 0; i < 3; i += 2) CHECK(pktrt_remove_instance(s, instance[i]) == PKTRT_OK);
  stage_commit(s);
  agree_with_scene("no instance left", s, &x);
  CHECK(x.info.instance_count == 0 && x.instances < of_three && !(x.found & PKTRT_FEATURE_INSTANCES), "%llu bytes",
      (unsigned long long)x.instances);
  pktrt_scene_destroy(s);
  mesh_free(&ball);
}

/* Groups have trees of their own, and many of them a tree above these: all its bytes are told. */
static void bytes_of_groups(void) {
  static const uint32_t counts[] = {1, 3, 5, 20};
  pktrt_scene_report x;
  mesh ball = mesh_sphere(1, 0.05f, 1);
  for (size_t i = 0; i < COUNT(counts); i++) {
    char when[32];
    pktrt_scene *s = stage_open();
    pktrt_mesh_desc d = mesh_desc(&ball);
    for (d.group = 0; d.group < counts[i]; d.group++) CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
    stage_commit(s);
    (void)snprintf(when, sizeof when, "%u groups", (unsigned)counts[i]);
    agree_with_scene(when, s, &x);
    pktrt_scene_destroy(s);
  }
  mesh_free(&ball);
}

/* Hits that a render counts are those that its pixels show, in scenes with instances and without, however many rays are asked for
   at once. */
static void hits_of_renders(void) {
  enum { WIDE = 64, HIGH = 48 };
  static float pixels[WIDE * HIGH * 3], depth[WIDE * HIGH];
  mesh ball = mesh_sphere(3, 0.05f, 1);
  for (int placed = 0; placed < 2; placed++)
    for (int path = 0; path < 3; path++) {
      static pktrt_stats stats;
      uint64_t seen = 0;
      pktrt_scene *s = stage_open();
      pktrt_mesh_desc d = mesh_desc(&ball);
      pktrt_instance_desc in;
      memset(&in, 0, sizeof in);
      if (placed)
        CHECK(pktrt_add_model(s, &d, 1, &in.model) == PKTRT_OK && pktrt_add_instance(s, &in, NULL) == PKTRT_OK);
      else CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
      stage_commit(s);
      pktrt_render_desc view = stage_view(PKTRT_MODE_RCS, WIDE, HIGH, pixels, vec_of(0.2, 0.1, 3), vec_of(0, 0, 0));
      memset(&stats, 0, sizeof stats);
      view.stats = &stats, view.depth = depth, view.path = (pktrt_path)path;
      stage_render(s, &view);
      for (int i = 0; i < WIDE * HIGH; i++) seen += depth[i] < INFINITY;
      const pktrt_counts *c = &stats.by_type[PKTRT_RAY_PRIMARY];
      CHECK(c->rays == WIDE * HIGH && c->hits == seen && seen > WIDE,
          "placed %d, path %d: %llu rays, %llu hits, not %llu", placed, path, (unsigned long long)c->rays,
          (unsigned long long)c->hits, (unsigned long long)seen);
      pktrt_scene_destroy(s);
    }
  mesh_free(&ball);
}

static bool never_enough(void *user, const pktrt_report *r) {
  (void)user;
  return r->rounds < 3;
}

/* A hook that decides about further passes is a rule: without a number of passes the render keeps sums for it, and the report says so. */
static void passes_of_a_hook(void) {
  static float pixels[3 * 16 * 16];
  pktrt_scene *s = stage_open();
  mesh ball = mesh_sphere(2, 0, 1);
  stage_mesh(s, &ball, 0);
  mesh_free(&ball);
  stage_commit(s);
  pktrt_render_desc view = stage_view(PKTRT_MODE_DRT, 16, 16, pixels, vec_of(0, 0, 4), vec_of(0, 0, 0));
  pktrt_scene_report none, one, numbered, hooked;
  pktrt_report report;
  view.report = &report;
  pktrt_get_scene_report(s, &view, &none);
  view.pass = never_enough;
  pktrt_get_scene_report(s, &view, &hooked);
  stage_render(s, &view);
  CHECK(report.rounds == 3 && report.stop == PKTRT_STOP_ASKED, "%u rounds", (unsigned)report.rounds);
  view.passes = 1;
  pktrt_get_scene_report(s, &view, &one);
  stage_render(s, &view);
  CHECK(report.rounds == 1, "%u rounds", (unsigned)report.rounds);
  view.pass = NULL;
  view.passes = 3;
  pktrt_get_scene_report(s, &view, &numbered);
  CHECK(none.passes == 0 && one.passes == 0, "one pass keeps nothing");
  CHECK(numbered.passes > 0 && hooked.passes == numbered.passes, "%llu and %llu bytes",
      (unsigned long long)hooked.passes, (unsigned long long)numbered.passes);
  pktrt_scene_destroy(s);
}

/* Each material and each light adds to the looks what it takes in an array: a material no more than its description. */
static void looks(void) {
  pktrt_scene *s = stage_open();
  pktrt_scene_report none, some;
  const pktrt_material plain = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
  pktrt_light point = light_of(PKTRT_LIGHT_POINT, 1);
  pktrt_get_scene_report(s, NULL, &none);
  stage_material(s, &plain);
  pktrt_get_scene_report(s, NULL, &some);
  const uint64_t each = some.materials - none.materials;
  CHECK(each > 80 && each <= sizeof plain, "one material: %llu bytes", (unsigned long long)each);

  for (int i = 0; i < 2; i++) stage_material(s, &plain);
  pktrt_get_scene_report(s, NULL, &some);
  CHECK(some.materials == none.materials + 3 * each, "three materials: %llu bytes", (unsigned long long)some.materials);

  for (int i = 0; i < 5; i++) stage_light(s, &point);
  pktrt_get_scene_report(s, NULL, &some);
  CHECK(some.materials == none.materials + 3 * each + 5 * sizeof point, "and five lights: %llu bytes",
      (unsigned long long)some.materials);
  CHECK(some.bytes - none.bytes == some.materials - none.materials, "they are part of the sum");
  pktrt_scene_destroy(s);
}

/* What a render allocates while it runs, and no more than that. */
static size_t peak_of(pktrt_scene *s, const pktrt_render_desc *d) {
  const size_t before = hooks.live_bytes;
  hooks.peak_bytes = before;
  stage_render(s, d);
  CHECK(hooks.live_bytes == before, "a render keeps memory");
  return hooks.peak_bytes - before;
}

/* A ball of that look: what a worker has in a mode. */
static uint64_t worker_of(pktrt_scene *s, pktrt_render_desc *view, pktrt_mode mode) {
  pktrt_scene_report x;
  view->mode = mode;
  pktrt_get_scene_report(s, view, &x);
  return x.worker;
}

static void workers(void) {
  static request r;
  static void (*const looks[3])(request *) = {NULL, add_mirror, add_glass};
  uint64_t cast[3], followed[3];
  for (int i = 0; i < 3; i++) {
    defaults(&r, PKTRT_MODE_WRT);
    r.view.max_depth = 1;
    if (looks[i]) looks[i](&r);
    pktrt_scene *s = make(&r);
    cast[i] = worker_of(s, &r.view, PKTRT_MODE_RCS), followed[i] = worker_of(s, &r.view, PKTRT_MODE_WRT);
    const size_t peak = peak_of(s, &r.view);
    /* Reflected and refracted rays may share their memory. */
    CHECK(followed[i] > 0 && peak >= followed[i] - followed[i] / 8 && peak < followed[i] + followed[i] / 8,
        "%d: a worker of %llu bytes, %zu handed out", i, (unsigned long long)followed[i], peak);
    say("a worker has %llu bytes, one generation deep; %zu are handed out for the picture",
        (unsigned long long)followed[i], peak);
    pktrt_scene_destroy(s);
  }
  CHECK(cast[0] == followed[0] && cast[1] == cast[0] && cast[2] == cast[0], "ray casting has no secondary rays");
  CHECK(followed[0] < followed[1] && followed[1] < followed[2], "specular surfaces take memory");
}

static void passes(void) {
  static request r;
  pktrt_scene_report one, four;
  defaults(&r, PKTRT_MODE_RCS);
  pktrt_scene *s = make(&r);
  const size_t alone = peak_of(s, &r.view);
  pktrt_get_scene_report(s, &r.view, &one);
  r.view.passes = 4;
  const size_t several = peak_of(s, &r.view);
  pktrt_get_scene_report(s, &r.view, &four);
  CHECK(one.passes == 0 && four.passes >= 32ull * W * H, "%llu bytes of passes", (unsigned long long)four.passes);
  CHECK(several - alone >= four.passes && several - alone < four.passes + four.passes / 4, "%zu more are handed out",
      several - alone);
  CHECK(four.bytes == one.bytes && four.worker == one.worker);
  pktrt_scene_destroy(s);
}

/* --- text --- */

/* Whether a line of the text begins with `label` and names `what`. */
static bool line_names(const char *text, const char *label, const char *what) {
  const char *line = text, *at;
  while (strncmp(line, label, strlen(label)) != 0)
    if (!(line = strchr(line, '\n')) || !*++line) return false;
  at = strstr(line, what);
  return at && at < strchr(line, '\n');
}

static void check_names(const char *text, const pktrt_scene_report *x) {
  for (int i = 0; i < NAMES; i++) {
    const uint32_t bit = 1u << i;
    const char *name = pktrt_feature_string((pktrt_feature)bit);
    CHECK(strlen(name) > 3 && strcmp(name, "unknown") != 0);
    CHECK(line_names(text, "found ", name) == !!(x->found & bit), "found: %s", name);
    CHECK(line_names(text, "runs ", name) == !!(x->used & bit), "runs: %s", name);
    CHECK(line_names(text, "idle ", name) == !!(x->built & ~x->used & bit), "idle: %s", name);
    CHECK(line_names(text, "not built ", name) == !(x->built & bit), "not built: %s", name);
  }
  CHECK(line_names(text, "found ", " nothing") == !x->found, "found: nothing");
  CHECK(line_names(text, "runs ", " nothing") == !x->used, "runs: nothing");
  CHECK(line_names(text, "not built ", " nothing") == !(~x->built & ((1u << NAMES) - 1)), "not built: nothing");
  CHECK(strstr(text, pktrt_isa_string(x->info.isa)) != NULL);
}

/* At any room: what fits of it, a zero, and nothing beyond; the length is that of all. */
static void cut_off(const pktrt_scene_report *x, const char *whole, size_t length) {
  static char part[4096];
  CHECK(pktrt_scene_report_text(x, NULL, 0) == length, "without room");
  for (size_t room = 0; room <= length + 2; room++) {
    const size_t kept = room > length ? length : room ? room - 1 : 0;
    memset(part, 'x', sizeof part);
    const size_t n = pktrt_scene_report_text(x, part, room);
    CHECK(n == length && (!room || (memcmp(part, whole, kept) == 0 && !part[kept])), "room for %zu", room);
    const size_t written = room ? kept + 1 : 0;
    bool intact = true;
    for (size_t i = written; i < length + 16; i++) intact &= part[i] == 'x';
    CHECK(intact, "room for %zu: written beyond", room);
  }
}

static void texts(void) {
  static char text[4096];
  for (size_t i = 0; i < COUNT(cases); i++) {
    static request r;
    defaults(&r, PKTRT_MODE_WRT);
    cases[i].add(&r);
    const pktrt_scene_report x = report_of(&r);
    const size_t n = pktrt_scene_report_text(&x, text, sizeof text);
    CHECK(n > 100 && n < 1024 && n == strlen(text) && text[n - 1] == '\n', "%s: %zu characters", cases[i].name, n);
    check_names(text, &x);
    if (i == 0) cut_off(&x, text, n);
  }
  pktrt_scene_report x; /* of a build without most, and without a scene */
  pktrt_get_scene_report(NULL, NULL, &x);
  x.built = PKTRT_FEATURE_MOTION;
  pktrt_scene_report_text(&x, text, sizeof text);
  check_names(text, &x);
  CHECK(line_names(text, "not built ", "lens") && !line_names(text, "not built ", "motion"), "the control");
  CHECK(strcmp(pktrt_feature_string((pktrt_feature)3), "unknown") == 0, "two bits are no feature");
}

/* Each number of the text's line of bytes, added up. */
static void text_adds_up(void) {
  static char text[4096];
  static request r;
  defaults(&r, PKTRT_MODE_RCS);
  add_motion(&r), add_normals(&r), add_texcoords(&r), add_instance(&r);
  const pktrt_scene_report x = report_of(&r);
  pktrt_scene_report_text(&x, text, sizeof text);
  const char *at = strstr(text, "\nbytes ");
  if (!CHECK(at != NULL)) return;
  uint64_t sum = 0, parts = 0;
  const char *end = strchr(at + 1, '\n'), *colon = strchr(at, ':');
  if (!CHECK(colon && colon < end, "parts follow a colon: %s", at)) return;
  for (const char *p = colon; p < end; p++)
    if (*p >= '0' && *p <= '9') {
      char *after;
      sum += strtoull(p, &after, 10), parts++, p = after;
    }
  CHECK(strtoull(at + 7, NULL, 10) == x.bytes && sum == x.bytes && parts == 10, "%llu parts, %llu bytes: %s",
      (unsigned long long)parts, (unsigned long long)sum, at);
  pktrt_scene_report other = x;
  other.worker = 123450, other.passes = 678901;
  pktrt_scene_report_text(&other, text, sizeof text);
  CHECK(strstr(text, "\na worker   123450 bytes\n") && strstr(text, "\npasses     678901 bytes\n"), "%s", text);
}

static void odd_scenes(void) {
  static char text[4096];
  pktrt_scene_report x;
  memset(&x, 0xA5, sizeof x);
  pktrt_get_scene_report(NULL, NULL, &x);
  CHECK(x.built == (1u << NAMES) - 1 && !x.found && !x.used && !x.info.mesh_count && !x.info.triangles && !x.bytes &&
        !x.worker);
  CHECK(pktrt_scene_report_text(&x, text, sizeof text) == strlen(text));
  pktrt_scene *s = stage_open();
  pktrt_get_scene_report(s, NULL, &x);
  CHECK(x.info.isa != PKTRT_ISA_AUTO && !x.found && !x.bytes && !x.info.triangles);
  mesh ball = mesh_sphere(2, 0, 1);
  mesh_move(&ball, 2, 0.4f, 0, 2);
  CHECK(mesh_add(s, &ball, NULL) == PKTRT_OK);
  pktrt_get_scene_report(s, NULL, &x); /* its bytes are there, the rest waits for the commit */
  CHECK(!x.found && !x.info.mesh_count && !x.info.triangles && !x.nodes && x.positions == (uint64_t)ball.nv * 12 &&
        x.bytes > 0);
  pktrt_scene_report_text(&x, text, sizeof text);
  CHECK(strstr(text, ": positions") != NULL, "%s", text);
  stage_commit(s);
  pktrt_get_scene_report(s, NULL, &x);
  CHECK(x.found == MOTION && x.info.mesh_count == 1 && x.info.triangles == ball.nt && x.nodes + x.blocks > 0);
  mesh_free(&ball);
  pktrt_scene_destroy(s);
}

void suite_report(void) {
  run("the report of a static diffuse scene under a point light finds nothing", plain_scenes);
  run("each feature is reported where it is, and runs in the modes that show it", features);
  run("for queries, what only pictures show does not run", queries_only);
  run("the report's bytes add up, and are those of the scene's info and of the hooks", bytes);
  run("the report's bytes agree in states that are rarely met: what waits, what was removed", bytes_in_rare_states);
  run("the report's bytes agree in scenes of groups, few and many", bytes_of_groups);
  run("renders count the hits that their pixels show", hits_of_renders);
  run("a hook that asks for passes, without a number of them, is reported like a number", passes_of_a_hook);
  run("materials and lights are counted among the looks", looks);
  run("a worker's bytes are what a picture takes, more where rays go on", workers);
  run("the bytes of passes are those that they take", passes);
  run("the report's text names what there is, and is cut off at any room", texts);
  run("the bytes in the report's text add up", text_adds_up);
  run("reports of no scene, of an empty one, and of one that was not committed", odd_scenes);
}
