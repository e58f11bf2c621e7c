/* Glass in glass: which one absorbs where boxes are nested, touch or overlap, for what the camera sees and for what lights
   it. Indices of 1 leave rays straight, so that what is left of light is exp(-sum of absorption times length). */
#include "pictures.h"

enum { BOXES = 9 };

typedef struct slab { /* a box from z = lo to z = hi, wider than what is looked at; hi = lo: none */
  double lo, hi, absorption;
} slab;

typedef struct stack_case {
  const char *name;
  slab box[BOXES];
  double eye, plate; /* z of the camera and of what it sees */
  double depth;      /* absorption times length along the way */
} stack_case;

static const stack_case cases[] = {
    {"one box", {{-3, 3, 0.5}}, 6, -6, 3},
    {"the camera in one box", {{-3, 3, 0.5}}, 1, -6, 2},
    {"the camera and what it sees in one box", {{-3, 3, 0.5}}, 1, -2, 1.5},
    {"a clear box in one that absorbs", {{-3, 3, 0.5}, {-1, 1, 0}}, 6, -6, 2},
    {"a box in a box", {{-3, 3, 0.5}, {-1, 1, 0.25}}, 6, -6, 2.5},
    {"the camera in the inner box", {{-3, 3, 0.5}, {-1, 1, 0.25}}, 0.5, -6, 1.375},
    {"the camera in the outer box", {{-3, 3, 0.5}, {-1, 1, 0.25}}, 2, -6, 2},
    {"something in the inner box", {{-3, 3, 0.5}, {-1, 1, 0.25}}, 6, -0.5, 1.375},
    {"two boxes in a box", {{-4, 4, 0.25}, {1, 3, 0.5}, {-3, -1, 0}}, 6, -6, 2},
    {"six boxes in each other", {{-6, 6, 0.1}, {-5, 5, 0.2}, {-4, 4, 0.3}, {-3, 3, 0.05}, {-2, 2, 0.15}, {-1, 1, 0.25}},
        8, -8, 2.1},
    {"boxes that touch", {{0, 3, 0.5}, {-3, 0, 0.25}}, 6, -6, 2.25},
    {"the camera in the first of two that touch", {{0, 3, 0.5}, {-3, 0, 0.25}}, 1, -6, 1.25},
    {"the camera in the second of two that touch", {{0, 3, 0.5}, {-3, 0, 0.25}}, -1, -6, 0.5},
    {"something in the second of two that touch", {{0, 3, 0.5}, {-3, 0, 0.25}}, 6, -1, 1.75},
    {"three of one glass that touch", {{1, 3, 0.25}, {-1, 1, 0.25}, {-3, -1, 0.25}}, 6, -6, 1.5},
    {"a box in a box, with one face", {{-3, 3, 0.5}, {-3, 0, 0.25}}, 6, -6, 2.25},
    {"the same from the other side", {{-3, 3, 0.5}, {0, 3, 0.25}}, 6, -6, 2.25},
    {"eight boxes that touch, in one whose faces they share",
        {{-4, 4, 0.5}, {-4, -3, 0.25}, {-3, -2, 0.125}, {-2, -1, 0.25}, {-1, 0, 0.125}, {0, 1, 0.25}, {1, 2, 0.125},
            {2, 3, 0.25}, {3, 4, 0.125}},
        6, -6, 1.5},
    {"the camera in nine boxes, more than are looked for: what it sees is in the second",
        {{-9, 9, 0.5}, {-8, 8, 0.5}, {-7, 7, 0.5}, {-6, 6, 0.5}, {-5, 5, 0.5}, {-4, 4, 0.5}, {-3, 3, 0.5}, {-2, 2, 0.5},
            {-1, 1, 0.5}},
        0.5, -1.5, 1},
    {"boxes that overlap: the one entered last absorbs", {{-1, 3, 0.5}, {-3, 1, 0.25}}, 6, -6, 2},
    {"the same from the other side", {{-3, 1, 0.5}, {-1, 3, 0.25}}, 6, -6, 2.5},
};

/* From the scene's own place to one of four in space: boxes lie beside each other along z, along no axis, or along x. */
static vec turned(int place, double x, double y, double z) {
  static const double angle[4][2] = {{0, 0}, {0.7, 0.4}, {2.9, -1.2}, {PI / 2, 0}};
  double a = angle[place][0], b = angle[place][1], x1 = cos(a) * x + sin(a) * z, z1 = cos(a) * z - sin(a) * x;
  return vec_of(x1 + 3 * (place % 3), cos(b) * y - sin(b) * z1, sin(b) * y + cos(b) * z1 - place % 3);
}

static mesh slab_mesh(const slab *b, int place) {
  mesh m = mesh_box();
  for (uint32_t v = 0; v < m.nv; v++) {
    float *p = m.p + 3 * v;
    vec_put(turned(place, 8 * (double)p[0], 8 * (double)p[1], p[2] > 0 ? b->hi : b->lo), p);
  }
  return m;
}

typedef struct set_up {
  int place;
  bool backwards, one_glass, moves; /* the boxes are added in reverse; of one material where they absorb alike; move */
} set_up;

static uint32_t slab_material(pktrt_scene *s, double absorption) {
  pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
  glass.ior[0] = 1;
  for (int k = 0; k < 3; k++) glass.absorption[k] = (float)absorption * (float)(k + 1) / 2;
  return stage_material(s, &glass);
}

static void add_slabs(pktrt_scene *s, const stack_case *c, const set_up *u) {
  uint32_t material[BOXES];
  for (int i = 0; i < BOXES; i++) {
    if (c->box[i].hi <= c->box[i].lo) continue;
    const bool same = u->one_glass && i && fabs(c->box[i].absorption - c->box[i - 1].absorption) <= 0;
    material[i] = same ? material[i - 1] : slab_material(s, c->box[i].absorption);
  }
  for (int k = 0; k < BOXES; k++) {
    int i = u->backwards ? BOXES - 1 - k : k;
    if (c->box[i].hi <= c->box[i].lo) continue;
    mesh m = slab_mesh(&c->box[i], u->place);
    pktrt_mesh_desc d = mesh_desc(&m);
    float keys[2 * 8 * 3];
    d.material = material[i];
    for (int n = 0; n < 8 * 3; n++) keys[n] = m.p[n] - 0.5f, keys[24 + n] = m.p[n] + 0.5f; /* in place half-way */
    if (u->moves) d.positions = keys, d.key_count = 2;
    CHECK(m.nv == 8 && pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
    mesh_free(&m);
  }
}

static void add_plate(pktrt_scene *s, const set_up *u, double z, bool shines) {
  pktrt_material m = shines ? lamp_of(1) : material_of(1, PKTRT_SPECULAR_NONE, 0);
  vec o = turned(u->place, 0, 0, z);
  quad q = quad_of(o, vec_sub(turned(u->place, 7, 0, z), o), vec_sub(turned(u->place, 0, 7, z), o));
  stage_quad(s, &q, stage_material(s, &m));
}

static pktrt_render_desc straight(const set_up *u, pktrt_mode mode, float *pixel, double from, double to) {
  pktrt_render_desc d =
      stage_view(mode, 1, 1, pixel, turned(u->place, 0.13, 0.31, from), turned(u->place, 0.13, 0.31, to));
  d.camera.fov_y = 0.01f, d.camera.time = 0.5f;
  return d;
}

static int set_ups(set_up u[16]) {
  for (int i = 0; i < 16; i++) u[i] = (set_up){i % 4, i / 4 % 2 == 1, i / 8 == 1, i == 5 || i == 10};
  return 16;
}

/* What a light at the camera's place brings to a diffuse plate is dimmed on the way there and back; with `near`, the camera is
   at the plate, and only the light's way counts. */
static void glass_in_glass(void) {
  set_up u[16];
  double worst = 0, control = 0;
  for (size_t k = 0; k < COUNT(cases); k++) {
    const stack_case *c = &cases[k];
    for (int i = 0, n = set_ups(u); i < n; i++) {
      for (int mode = PKTRT_MODE_WRT; mode <= PKTRT_MODE_DRT; mode++) {
        float got[3];
        pktrt_scene *s = stage_open();
        add_slabs(s, c, &u[i]), add_plate(s, &u[i], c->plate, true);
        stage_commit(s);
        pktrt_render_desc d = straight(&u[i], (pktrt_mode)mode, got, c->eye, c->plate);
        stage_render(s, &d);
        for (int a = 0; a < 3; a++) {
          double want = exp(-c->depth * (a + 1) / 2), off = fabs((double)got[a] / want - 1);
          CHECK(off < 2e-4, "%s, set-up %d, channel %d: %g, not %g", c->name, i, a, (double)got[a], want);
          worst = fmax(worst, off), control = fmax(control, 1 - want);
        }
        pktrt_scene_destroy(s);
      }
    }
  }
  say("light through %zu stacks of glass off by at most %.2g; without absorption by %.2g", COUNT(cases), worst,
      control);
  CHECK(control > 0.9);
}

static void shadows_in_glass(void) {
  set_up u[16];
  double worst = 0;
  for (size_t k = 0; k < COUNT(cases); k++) {
    const stack_case *c = &cases[k];
    for (int i = 0, n = set_ups(u); i < n; i++) {
      for (int settings = 0; settings < 4; settings++) {
        float got[2][3], at = 1.0f / 64;
        for (int with = 0; with < 2; with++) {
          pktrt_scene *s = stage_open();
          pktrt_light l = light_of(PKTRT_LIGHT_POINT, 10);
          vec_put(turned(u[i].place, 0.13, 0.31, c->eye), l.position);
          if (with) add_slabs(s, c, &u[i]);
          add_plate(s, &u[i], c->plate, false), stage_light(s, &l);
          stage_commit(s);
          pktrt_render_desc d = straight(&u[i], PKTRT_MODE_WRT, got[with], c->plate + (double)at, c->plate);
          d.assembly = settings == 1   ? PKTRT_ASSEMBLY_BLIND
                       : settings == 2 ? PKTRT_ASSEMBLY_NONE
                                       : PKTRT_ASSEMBLY_RAY_TYPES;
          d.path = settings == 3 ? PKTRT_PATH_PAPER : PKTRT_PATH_FAST;
          stage_render(s, &d);
          pktrt_scene_destroy(s);
        }
        double near = 0; /* absorption around the plate, that is, at the end of the way */
        for (int b = 0; b < BOXES; b++)
          if (c->box[b].lo < c->plate && c->plate < c->box[b].hi) near = c->box[b].absorption;
        for (int a = 0; a < 3; a++) {
          /* From there glasses that overlap are entered the other way round. */
          double depth = (strstr(c->name, "overlap") ? 2.5 : k && strstr(cases[k - 1].name, "overlap") ? 2 : c->depth);
          double want = exp(-(depth + near * (double)at) * (a + 1) / 2), is = (double)got[1][a] / (double)got[0][a];
          CHECK(got[0][a] > 0 && fabs(is / want - 1) < 2e-4, "%s, set-up %d, settings %d, channel %d: %g, not %g",
              c->name, i, settings, a, is, want);
          worst = fmax(worst, fabs(is / want - 1));
        }
      }
    }
  }
  say("shadow rays through the same stacks off by at most %.2g", worst);
}

/* A mirror in glass sends back what stays in glass; light in glass that meets nothing on its way is dimmed, too. */
static void mirror_in_glass(void) {
  stack_case c = {"", {{-3, 3, 0.5}, {-2, 2, 0.25}}, 6, -1, 0};
  set_up u = {1, false, false, false};
  float got[3];
  pktrt_scene *s = stage_open();
  pktrt_material mirror = material_of(0, PKTRT_SPECULAR_MIRROR, 1);
  vec o = turned(u.place, 0, 0, -1);
  quad q = quad_of(o, vec_sub(turned(u.place, 7, 0, -1), o), vec_sub(turned(u.place, 0, 7, -1), o));
  add_slabs(s, &c, &u), stage_quad(s, &q, stage_material(s, &mirror));
  stage_commit(s);
  pktrt_render_desc d = straight(&u, PKTRT_MODE_WRT, got, 6, -1);
  d.background[0] = d.background[1] = d.background[2] = 1;
  stage_render(s, &d);
  for (int a = 0; a < 3; a++) {
    double want = exp(-2 * (0.5 * 1 + 0.25 * 3) * (a + 1) / 2);
    CHECK(fabs((double)got[a] / want - 1) < 2e-4, "there and back, channel %d: %g, not %g", a, (double)got[a], want);
  }
  pktrt_scene_destroy(s);
}

/* What is reflected within glass and meets no glass on its way is dimmed on all of it: from a mirror there, from the inside of
   its surface, from glass in it, from a sheet seen from its inside. The camera stands between what reflects and a lamp. */
static void reflected_in_glass(void) {
  static const struct {
    const char *name;
    double ior, inner_ior; /* 0: no box within */
    double eye, at, lamp;  /* z of the camera, of what reflects, of the lamp behind the camera */
  } seen[] = {{"a mirror", 1, 0, 1, -1, 2}, {"the surface from inside", 1.5, 0, 1, 3, -2},
      {"glass in glass", 1, 1.5, 2, 1, 2.5}, {"a sheet", 1.5, 0, -1, 0, -2}};
  static const slab outer = {-3, 3, 0.5}, inner = {-1, 1, 0.25};
  for (size_t k = 0; k < COUNT(seen); k++) {
    for (int place = 0; place < 3; place++) {
      float got[3];
      const set_up u = {place, false, false, false};
      pktrt_scene *s = stage_open();
      for (int i = 0; i < (seen[k].inner_ior > 0 ? 2 : 1); i++) {
        pktrt_material glass = material_of(0, PKTRT_SPECULAR_DIELECTRIC, 0);
        mesh m = k == 3 ? mesh_of(0, 0) : slab_mesh(i ? &inner : &outer, place);
        glass.ior[0] = (float)(i ? seen[k].inner_ior : seen[k].ior);
        for (int a = 0; a < 3; a++)
          glass.absorption[a] = (float)(i ? inner.absorption : outer.absorption) * (float)(a + 1) / 2;
        stage_mesh(s, &m, stage_material(s, &glass));
        mesh_free(&m);
      }
      const pktrt_material mirror = material_of(0, PKTRT_SPECULAR_MIRROR, 1);
      const vec o = turned(place, 0, 0, seen[k].at);
      const quad q =
          quad_of(o, vec_sub(turned(place, 7, 0, seen[k].at), o), vec_sub(turned(place, 0, 7, seen[k].at), o));
      if (k == 0) stage_quad(s, &q, stage_material(s, &mirror));
      if (k == 3) stage_quad(s, &q, 1);
      add_plate(s, &u, seen[k].lamp, true);
      stage_commit(s);
      pktrt_render_desc d = straight(&u, PKTRT_MODE_WRT, got, seen[k].eye, seen[k].at);
      d.max_depth = 1;
      stage_render(s, &d);
      const double way = fabs(seen[k].eye - seen[k].at) + fabs(seen[k].lamp - seen[k].at), part = k ? 0.04 : 1;
      for (int a = 0; a < 3; a++) {
        const double want = part * exp(-way * outer.absorption * (a + 1) / 2);
        CHECK(fabs((double)got[a] / want - 1) < 2e-4, "%s, place %d, channel %d: %g, not %g", seen[k].name, place, a,
            (double)got[a], want);
      }
      pktrt_scene_destroy(s);
    }
  }
}

/* An open sheet is no glass that a camera stands in, on either side. What its inside shows is taken to lie in it. */
static void open_sheets(void) {
  for (int behind = 0; behind < 2; behind++) {
    float got[3];
    pktrt_scene *s = stage_open();
    quad q = quad_of(vec_of(0, 0, 0), vec_of(7, 0, 0), vec_of(0, 7, 0));
    pktrt_material lamp = lamp_of(1);
    quad plate = quad_of(vec_of(0, 0, behind ? 1 : -4), vec_of(7, 0, 0), vec_of(0, 7, 0));
    stage_quad(s, &q, slab_material(s, 0.5)), stage_quad(s, &plate, stage_material(s, &lamp));
    stage_commit(s);
    set_up u = {0, false, false, false};
    pktrt_render_desc d = straight(&u, PKTRT_MODE_WRT, got, behind ? -2 : 2, 0);
    stage_render(s, &d);
    double want = exp(-0.25 * (behind ? 2 : 4)); /* on this side of its inside; or behind it */
    CHECK(fabs((double)got[0] / want - 1) < 2e-5, "behind %d: %g, not %g", behind, (double)got[0], want);
    pktrt_scene_destroy(s);
  }
}

/* What a camera in a ball of glass sees, with so many clear boxes ahead of it, where the line goes that looks for what it
   stands in: along (0.259, 0.933, 0.2495). One or the other has two keys, both the same, hence a tree of its own. */
static float seen_among(int others, bool ball_has_keys) {
  float got[3];
  set_up u = {0, false, false, false};
  pktrt_scene *s = stage_open();
  const uint32_t clear = slab_material(s, 0), dark = slab_material(s, 0.5);
  mesh ball = mesh_sphere(3, 0, 1);
  mesh_scale(&ball, 5);
  if (ball_has_keys) mesh_move(&ball, 2, 0, 0, 0);
  for (int i = 0; i < others; i++) {
    mesh m = mesh_box();
    const float away = 1 + 0.25f * (float)i; /* some within the ball */
    mesh_scale(&m, 0.05f);
    mesh_shift(&m, 0.13f + 0.259f * away, 0.31f + 0.933f * away, 1 + 0.2495f * away);
    if (!ball_has_keys) mesh_move(&m, 2, 0, 0, 0);
    stage_mesh(s, &m, clear);
    mesh_free(&m);
  }
  stage_mesh(s, &ball, dark);
  add_plate(s, &u, -3, true); /* within the ball: nothing else tells where the ray was */
  stage_commit(s);
  pktrt_render_desc d = straight(&u, PKTRT_MODE_WRT, got, 1, -3);
  stage_render(s, &d);
  pktrt_scene_destroy(s);
  mesh_free(&ball);
  return got[0];
}

/* It is found whichever of them the search meets first. */
static void among_others(void) {
  for (int keys = 0; keys < 2; keys++) {
    const float alone = seen_among(0, keys), among = seen_among(40, keys);
    CHECK(alone < 0.5f, "the control: the ball is seen: %g", (double)alone);
    CHECK(fabsf(among / alone - 1) < 2e-5f, "two keys of the ball, %d: %g, not %g", keys, (double)among, (double)alone);
  }
}

/* Glass above a liquid, by what parts them from each other and from the air: three sheets, through which a ray goes from both
   sides. In a box of another glass, whose last piece is dimmed by that one again. */
static void interfaces(void) {
  static const struct {
    double z, absorption;
    bool down;
  } sheet[] = {{3, 0.5, false}, {1, 0.25, false}, {-3, 0.25, true}};
  for (int k = 0; k < 4; k++) {
    const bool below = k & 1, boxed = k & 2;
    float got[3];
    set_up u = {1, false, false, false};
    stack_case around = {"", {{-4, 4, 0.125}}, 0, 0, 0};
    pktrt_scene *s = stage_open();
    for (size_t i = 0; i < COUNT(sheet); i++) {
      vec o = turned(u.place, 0, 0, sheet[i].z), x = vec_sub(turned(u.place, 7, 0, sheet[i].z), o);
      quad q = quad_of(o, x, vec_sub(turned(u.place, 0, 7, sheet[i].z), o));
      if (sheet[i].down) q = quad_flipped(q);
      stage_quad(s, &q, slab_material(s, sheet[i].absorption));
    }
    if (boxed) add_slabs(s, &around, &u);
    add_plate(s, &u, below ? 6 : -6, true);
    stage_commit(s);
    pktrt_render_desc d = straight(&u, PKTRT_MODE_WRT, got, below ? -6 : 6, 0);
    stage_render(s, &d);
    double want = exp(-(2 * 0.5 + 4 * 0.25 + (boxed ? 2 * 0.125 : 0)));
    CHECK(fabs((double)got[1] / want - 1) < 2e-4, "below %d, boxed %d: %g, not %g", below, boxed, (double)got[1], want);
    pktrt_scene_destroy(s);
  }
}

/* A sheet in a box, seen from its inside: what lies before it is taken to lie in it, what lies behind it in the box. */
static void sheet_in_a_box(void) {
  float got[3];
  set_up u = {1, false, false, false};
  const stack_case around = {"", {{-3, 3, 0.5}}, 0, 0, 0};
  pktrt_scene *s = stage_open();
  const vec o = turned(u.place, 0, 0, 0), x = vec_sub(turned(u.place, 7, 0, 0), o),
            y = vec_sub(turned(u.place, 0, 7, 0), o);
  quad q = quad_of(o, x, y);
  q = quad_flipped(q);
  stage_quad(s, &q, slab_material(s, 0.25));
  add_slabs(s, &around, &u);
  add_plate(s, &u, -2, true); /* within the box */
  stage_commit(s);
  pktrt_render_desc d = straight(&u, PKTRT_MODE_WRT, got, 6, 0);
  stage_render(s, &d);
  const double want = exp(-(3 * 0.25 + 2 * 0.5));
  CHECK(fabs((double)got[1] / want - 1) < 2e-4, "%g, not %g", (double)got[1], want);
  pktrt_scene_destroy(s);
}

/* Shadow rays pass up to 2 PKTRT_MAX_DEPTH + 1 surfaces of glass. No light comes through more; a floor has all of it beside them. */
static void shadows_of_many_sheets(void) {
  enum { WIDE = 16 };
  static float pixels[2][WIDE * WIDE * 3];
  static const int sheets[2] = {2 * PKTRT_MAX_DEPTH, 2 * PKTRT_MAX_DEPTH + 5};
  set_up u = {0, false, false, false};
  size_t dark[2] = {0, 0};
  for (int many = 0; many < 2; many++) {
    pktrt_scene *s = stage_open();
    pktrt_light l = light_of(PKTRT_LIGHT_DIRECTIONAL, 3);
    const uint32_t clear = slab_material(s, 0);
    vec_put(vec_of(-0.05, 0, -1), l.direction);
    for (int i = 0; i < sheets[many]; i++) { /* on the right, above the camera */
      quad q = quad_of(vec_of(3.5, 0, 10 + 0.1 * i), vec_of(3.5, 0, 0), vec_of(0, 7, 0));
      stage_quad(s, &q, clear);
    }
    add_plate(s, &u, -6, false);
    stage_light(s, &l);
    stage_commit(s);
    pktrt_render_desc d = stage_view(PKTRT_MODE_WRT, WIDE, WIDE, pixels[many], vec_of(0, 0, 6), vec_of(0, 0, -6));
    d.camera.fov_y = 20;
    stage_render(s, &d);
    for (int i = 0; i < WIDE * WIDE; i++) {
      const bool right = i % WIDE >= WIDE / 2 + 2, left = i % WIDE < WIDE / 2 - 4;
      dark[many] += pixels[many][3 * i] <= 0;
      CHECK(!left || pixels[many][3 * i] > 0.1f, "%d sheets: pixel %d is beside them", sheets[many], i);
      CHECK(!right || (pixels[many][3 * i] > 0.1f) == !many, "%d sheets: pixel %d is below them", sheets[many], i);
    }
    pktrt_scene_destroy(s);
  }
  CHECK(dark[0] == 0 && dark[1] > WIDE * WIDE / 4, "%zu and %zu pixels are dark", dark[0], dark[1]);
}

/* Shadow rays to a light infinitely far that start in a glass and leave it where it has no surface are not dimmed. */
static void far_light_beside_a_sheet(void) {
  float got[2][3];
  set_up u = {0, false, false, false};
  for (int sheet = 0; sheet < 2; sheet++) {
    pktrt_scene *s = stage_open();
    pktrt_light l = light_of(PKTRT_LIGHT_DIRECTIONAL, 3);
    quad q = quad_of(vec_of(0, 0, 0), vec_of(7, 0, 0), vec_of(0, 7, 0));
    vec_put(vec_of(-1, 0, -0.2), l.direction); /* below the sheet */
    if (sheet) stage_quad(s, &q, slab_material(s, 0.5));
    add_plate(s, &u, -6, false);
    stage_light(s, &l);
    stage_commit(s);
    pktrt_render_desc d = straight(&u, PKTRT_MODE_WRT, got[sheet], 6, 0);
    stage_render(s, &d);
    pktrt_scene_destroy(s);
  }
  const double left = (double)got[1][1] / (double)got[0][1], want = exp(-0.5 * 6);
  CHECK(got[0][1] > 0.01f && fabs(left / want - 1) < 2e-4, "%g of %g is left, not %g", left, (double)got[0][1], want);
}

/* Stacks are narrower where there are many materials. */
static void many_materials(void) {
  static const uint32_t counts[] = {5, 122, 126, 127, 130, 180, 250, 254, 300, 65530, 66000};
  for (size_t k = 0; k < COUNT(counts); k++) {
    float got[3];
    set_up u = {1, false, false, false};
    pktrt_scene *s = stage_open();
    pktrt_material plain = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
    for (uint32_t i = 0; i < counts[k]; i++) stage_material(s, &plain);
    const stack_case *c = &cases[4]; /* a box in a box */
    add_slabs(s, c, &u), add_plate(s, &u, c->plate, true);
    stage_commit(s);
    pktrt_render_desc d = straight(&u, PKTRT_MODE_WRT, got, c->eye, c->plate);
    stage_render(s, &d);
    CHECK(fabs((double)got[1] / exp(-c->depth) - 1) < 2e-5, "%u materials: %g", (unsigned)counts[k], (double)got[1]);
    pktrt_scene_destroy(s);
  }
}

/* The same bits however a picture of it is made: by a pinhole, and by a lens that lies partly in the inner glass. */
static void settings_in_glass(void) {
  enum { SIDE = 16, SETTINGS = 6 };
  static float want[SIDE * SIDE * 3], got[SIDE * SIDE * 3];
  set_up u = {2, false, false, false};
  size_t pictures = 0;
  for (int mode = PKTRT_MODE_WRT; mode <= PKTRT_MODE_DRT; mode++) {
    for (int i = 0; i < isa_count * SETTINGS; i += small_run ? 5 : 1) {
      const int k = i % SETTINGS;
      pktrt_scene_desc desc = scene_desc_of(isas[i / SETTINGS], 0);
      pktrt_scene *s = pktrt_scene_create(&desc);
      pktrt_light l = light_of(PKTRT_LIGHT_POINT, 30);
      vec_put(turned(u.place, 1, 2, 2.5), l.position);
      add_slabs(s, &cases[8], &u), add_plate(s, &u, -2, false), add_plate(s, &u, -7, true), stage_light(s, &l);
      stage_commit(s);
      pktrt_render_desc d = straight(&u, (pktrt_mode)mode, i ? got : want, 3.05, -6);
      d.width = d.height = SIDE, d.camera.fov_y = 90, d.camera.target[0] += 2;
      d.path = (pktrt_path)(k % 3), d.packet_size = k % 2 ? 4 : 8, d.assembly = (pktrt_assembly)k;
      if (mode == PKTRT_MODE_DRT) d.camera.aperture = 1.5f, d.samples = 4;
      stage_render(s, &d);
      CHECK(!i || same_bits(want, got, sizeof want), "mode %d, %s, setting %d", mode, pktrt_isa_string(desc.isa), k);
      pictures++;
      pktrt_scene_destroy(s);
    }
    float least = want[0], most = want[0];
    for (int i = 0; i < SIDE * SIDE; i++) least = fminf(least, want[3 * i]), most = fmaxf(most, want[3 * i]);
    CHECK(most > 1.5f * least + 0.01f, "there is something to see: %g to %g", (double)least, (double)most);
  }
  say("%zu pictures", pictures);
}

/* Glass lets through e^-(absorption times length), however small that is: what is too dense lets nothing through. */
static void glass_of_any_density(void) {
  static const double densities[] = {1, 30, 60, 100, 248, 249, 480, 500, 1000, 5000, 1e6, 1e12, 1e30};
  const set_up u = {1, false, false, false};
  size_t black = 0, wrong = 0;
  for (size_t k = 0; k < COUNT(densities); k++)
    for (int mode = PKTRT_MODE_WRT; mode <= PKTRT_MODE_DRT; mode++) {
      const stack_case c = {"", {{-3, 3, densities[k]}}, 0, -6, 0};
      float got[3];
      pktrt_scene *s = stage_open();
      add_slabs(s, &c, &u);
      stage_commit(s);
      pktrt_render_desc d = straight(&u, (pktrt_mode)mode, got, c.eye, c.plate);
      for (int a = 0; a < 3; a++) d.background[a] = 1;
      stage_render(s, &d);
      for (int a = 0; a < 3; a++) {
        const double want = exp(-3 * densities[k] * (a + 1) / 2);
        const bool right = fabs((double)got[a] - want) <= 4e-4 * want + 1e-37;
        CHECK(right, "density %g, mode %d, channel %d: %g, not %g", densities[k], mode, a, (double)got[a], want);
        wrong += !right;
        black += !(got[a] > 0);
      }
      pktrt_scene_destroy(s);
    }
  CHECK(black > 2 * COUNT(densities) && wrong == 0, "%zu are black", black);
  say("%zu densities: %zu of %zu values are 0, %zu wrong", COUNT(densities), black, 6 * COUNT(densities), wrong);
}

/* A camera leaves a cube of dense glass while the shutter is open, along each axis and back, or the cube leaves the camera: it sees
   black as long as it is within, and from then on a sign that goes ahead of it. */
static void a_camera_leaves_glass(void) {
  enum { SIDE = 8 };
  double worst = 0;
  for (int axis = 0; axis < 3; axis++)
    for (int way = 0; way < 8; way++) { /* to larger coordinates and to smaller, out and in, the camera or the glass */
      const bool glass_moves = way & 4;
      const double side = way & 1 ? -1 : 1, from = way & 2 ? 3 : 0.25, to = way & 2 ? 0.25 : 3;
      static float got[SIDE * SIDE * 3];
      const float eye[3] = {0.1f, 0.2f, 0.15f};
      mesh m = mesh_box();
      pktrt_scene *s = stage_open();
      pktrt_mesh_desc mesh_of_glass = mesh_desc(&m);
      mesh_of_glass.material = slab_material(s, 4000);
      float lo = INFINITY, hi = -INFINITY, keys[2 * 8 * 3];
      for (uint32_t i = 0; i < m.nv; i++) lo = fminf(lo, m.p[3 * i]), hi = fmaxf(hi, m.p[3 * i]);
      for (int i = 0; i < 24; i++) {
        const float shift = i % 3 == axis ? (float)(side * (from - to) * 0.5) * (hi - lo) : 0;
        keys[i] = m.p[i], keys[24 + i] = m.p[i] + shift;
      }
      if (glass_moves) mesh_of_glass.positions = keys, mesh_of_glass.key_count = 2;
      CHECK(m.nv == 8 && pktrt_add_mesh(s, &mesh_of_glass, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
      stage_commit(s);
      const double half = 0.5 * ((double)hi - (double)lo), middle = 0.5 * ((double)hi + (double)lo);
      pktrt_render_desc d = stage_view(PKTRT_MODE_DRT, SIDE, SIDE, got, vec_of(0, 0, 0), vec_of(0, 0, 1));
      d.camera.fov_y = 0.1f, d.camera.shutter = 1, d.camera.moving = !glass_moves, d.samples = 16;
      d.camera.up[0] = 0.3f, d.camera.up[1] = 0.5f, d.camera.up[2] = 0.8f;
      for (int a = 0; a < 3; a++) {
        const float ahead = a == axis ? (float)(100 * side) : 0;
        d.camera.eye[a] = d.camera.eye_end[a] = eye[a];
        if (a == axis) d.camera.eye[a] = (float)(middle + side * half * from);
        if (a == axis) d.camera.eye_end[a] = glass_moves ? d.camera.eye[a] : (float)(middle + side * half * to);
        d.camera.target[a] = d.camera.eye[a] + ahead, d.camera.target_end[a] = d.camera.eye_end[a] + ahead;
        d.camera.up_end[a] = d.camera.up[a];
      }
      float plate[2][4][3];
      for (int i = 0; i < 8; i++) { /* ahead of the camera and as fast */
        float *corner = plate[i / 4][i % 4];
        memcpy(corner, i / 4 && d.camera.moving ? d.camera.eye_end : d.camera.eye, 3 * sizeof *corner);
        corner[axis] += (float)(0.3 * side * half);
        corner[(axis + 1) % 3] += i & 1 ? 0.05f : -0.05f;
        corner[(axis + 2) % 3] += i & 2 ? 0.05f : -0.05f;
      }
      static const uint32_t corners[6] = {0, 1, 3, 0, 3, 2};
      const pktrt_material shining = lamp_of(1);
      pktrt_mesh_desc sign;
      memset(&sign, 0, sizeof sign);
      sign.positions = plate[0][0], sign.vertex_count = 4, sign.key_count = 2;
      sign.indices = corners, sign.triangle_count = 2;
      sign.material = stage_material(s, &shining);
      CHECK(pktrt_add_mesh(s, &sign, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
      stage_commit(s);
      stage_render(s, &d);
      const double outside = 2 / 2.75; /* of the time */
      double mean = 0;
      for (int i = 0; i < SIDE * SIDE * 3; i++) mean += (double)got[i] / (SIDE * SIDE * 3);
      CHECK(fabs(mean - outside) < 0.02, "axis %d, way %d: %g, not %g", axis, way, mean, outside);
      worst = fmax(worst, fabs(mean - outside));
      pktrt_scene_destroy(s);
      mesh_free(&m);
    }
  say("off by at most %.2g; a camera that is never within would be by %.2g", worst, 1 - 2 / 2.75);
}

/* A cube of dense glass around the camera, of loose triangles whose zeros have both signs, is closed: all is black. */
static void zeros_of_both_signs(void) {
  static const char *const name[] = {"zeros of one sign", "of both signs", "the control, a face missing"};
  float got[3];
  for (int k = 0; k < 3; k++) {
    mesh m = mesh_box();
    float soup[12 * 9];
    pktrt_scene *s = stage_open();
    for (uint32_t i = 0; i < 36; i++)
      for (uint32_t a = 0; a < 3; a++) {
        const bool high = m.p[3 * m.i[i] + a] > 0;
        soup[3 * i + a] = high ? 1.0f : k == 1 && i % 2 ? -0.0f : 0.0f;
      }
    pktrt_mesh_desc d;
    memset(&d, 0, sizeof d);
    d.positions = soup, d.vertex_count = 36, d.triangle_count = k == 2 ? 11 : 12;
    d.material = slab_material(s, 4000);
    const pktrt_material shining = lamp_of(1);
    const uint32_t lamp = stage_material(s, &shining);
    for (int a = 0; a < 3; a++) { /* signs in the glass, before its faces */
      vec o = vec_of(0.9, 0.9, 0.9), sides[2] = {vec_of(-0.8, 0, 0), vec_of(0, 0, -0.8)};
      if (a == 0) sides[0] = vec_of(0, -0.8, 0);
      if (a == 2) sides[1] = vec_of(0, -0.8, 0);
      const quad sign = quad_of(o, sides[0], sides[1]);
      stage_quad(s, &sign, lamp);
    }
    CHECK(m.nt == 12 && pktrt_add_mesh(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
    stage_commit(s);
    double seen = 0;
    for (int axis = 0; axis < 3; axis++) {
      pktrt_render_desc view = stage_view(PKTRT_MODE_WRT, 1, 1, got, vec_of(0.4, 0.45, 0.52),
          vec_of(axis == 0 ? 0.9 : 0.42, axis == 1 ? 0.9 : 0.47, axis == 2 ? 0.9 : 0.5));
      stage_render(s, &view);
      seen += (double)got[0];
    }
    CHECK(k == 2 ? seen > 0.5 : !(seen > 0), "%s: %g", name[k], seen);
    pktrt_scene_destroy(s);
    mesh_free(&m);
  }
}

/* Visible lamps in glass, behind it and about the camera are dimmed in each channel, as what shines behind the same glass is. */
static void lamps_in_glass(void) {
  set_up u[16];
  double worst = 0, apart = 0;
  for (size_t k = 0; k < COUNT(cases); k++) {
    const stack_case *c = &cases[k];
    for (int i = 0, n = set_ups(u); i < n; i++) {
      float got[2][3];
      for (int with = 0; with < 2; with++) {
        pktrt_scene *s = stage_open();
        const vec o = turned(u[i].place, -7, -7, c->plate);
        const quad q = quad_of(
            o, vec_sub(turned(u[i].place, 7, -7, c->plate), o), vec_sub(turned(u[i].place, -7, 7, c->plate), o));
        pktrt_light l = quad_light(&q, 4);
        l.visible = true;
        stage_light(s, &l);
        if (with) add_slabs(s, c, &u[i]);
        add_plate(s, &u[i], c->plate - 3, false); /* there is something to commit */
        stage_commit(s);
        const pktrt_render_desc d = straight(&u[i], PKTRT_MODE_DRT, got[with], c->eye, c->plate);
        stage_render(s, &d);
        pktrt_scene_destroy(s);
      }
      for (int a = 0; a < 3; a++) {
        const double want = exp(-c->depth * (a + 1) / 2), is = (double)got[1][a] / (double)got[0][a];
        CHECK(got[0][a] > 0 && fabs(is / want - 1) < 2e-4, "%s, set-up %d, channel %d: %g, not %g", c->name, i, a, is,
            want);
        worst = fmax(worst, fabs(is / want - 1));
        apart = fmax(apart, fabs(is / (double)(got[1][0] / got[0][0]) - 1));
      }
    }
  }
  CHECK(apart > 0.5, "channels differ");
  say("off by at most %.2g; channels are apart by %.2g", worst, apart);
}

void suite_media(void) {
  run("in glass within glass, beside glass and across glass, the one entered last absorbs", glass_in_glass);
  run("shadow rays lose the same there", shadows_in_glass);
  run("a mirror in glass in glass sends back what both absorb", mirror_in_glass);
  run("what is reflected in glass stays in it", reflected_in_glass);
  run("a sheet of glass is not taken for a body around the camera", open_sheets);
  run("a camera in glass is found to be there, however much other glass there is", among_others);
  run("bodies that share sheets as surfaces dim each on its own way", interfaces);
  run("a sheet in a box of glass leaves to the box what is behind it", sheet_in_a_box);
  run("no light comes through more glass than rays are followed for", shadows_of_many_sheets);
  run("light from infinitely far that passes beside a sheet is not dimmed by it", far_light_beside_a_sheet);
  run("glass in glass is found among 66,000 materials", many_materials);
  run("glass of any density lets through what it says, and dense glass nothing", glass_of_any_density);
  run("visible lamps in glass and behind it are dimmed in each channel", lamps_in_glass);
  run("glass whose corners have zeros of both signs is closed", zeros_of_both_signs);
  run("a camera that leaves or enters dense glass sees black while it is within", a_camera_leaves_glass);
  run("pictures of glass in glass are the same bits on all paths", settings_in_glass);
}
