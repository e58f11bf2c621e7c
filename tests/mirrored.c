/* Mirrored instances: inside and outside are those of the model. Each is compared, bit for bit, with its counterpart: the
   model with x turned to -x and the corners of its triangles in the other order, placed by the same transform without
   the mirror. The control is that model with its corners as they were, which is inside out. */
#include "pictures.h"
#include "placed.h"

/* The three scenes of a comparison. */
enum { MIRRORED, COUNTERPART, INSIDE_OUT, SIDES };

/* --- counterparts --- */

/* Turns x to -x in all vectors of a mesh. */
static void reflect(mesh *m) {
  for (size_t i = 0; i < (size_t)m->keys * m->nv; i++) m->p[3 * i] = -m->p[3 * i];
}
/* Turns all triangles round, by their second and third corners. */
static void turn_round(mesh *m) {
  for (size_t t = 0; t < m->nt; t++) {
    const uint32_t second = m->i[3 * t + 1];
    m->i[3 * t + 1] = m->i[3 * t + 2];
    m->i[3 * t + 2] = second;
  }
}
static void make_counterpart(mesh *m, int side) {
  if (side == MIRRORED) return;
  reflect(m);
  if (side == COUNTERPART) turn_round(m);
}
/* Takes the mirror out of matrices: the column that x is multiplied by. */
static void take_mirror_out(float *keys, uint32_t key_count, int side) {
  for (uint32_t k = 0; side != MIRRORED && k < 12 * key_count; k += 4) keys[k] = -keys[k];
}
static double determinant(const float *m) {
  const vec x = vec_of((double)m[0], (double)m[4], (double)m[8]), y = vec_of((double)m[1], (double)m[5], (double)m[9]);
  return vec_dot(vec_cross(x, y), vec_of((double)m[2], (double)m[6], (double)m[10]));
}

/* --- queries --- */

/* Fills in models: a ball, a box that moves, slivers, a ball that moves. */
static void make_models(placement *p, int side) {
  p->models = 4;
  p->model[0] = world_of(mesh_sphere(2, 0.1f, 3));
  p->model[1] = world_of(mesh_box());
  p->model[2] = world_of(mesh_thin(60, 4));
  p->model[3] = world_of(mesh_sphere(1, 0.1f, 5));
  mesh_move(&p->model[1].m[0], 2, 0.2f, 0, 6), mesh_move(&p->model[3].m[0], 3, 0.2f, 0.02f, 7);
  for (uint32_t i = 0; i < p->models; i++) make_counterpart(&p->model[i].m[0], side);
}
/* Fills in instances, all of them mirrored: by x to -x and a shift, by diagonals, and turned, sheared and scaled. */
static void make_places(placement *p, int side) {
  rng r = {mix64(21)}; /* whatever the seed: others may flatten */
  p->n = 20;
  for (uint32_t i = 0; i < p->n; i++) {
    p->of[i] = i % 4, p->keys[i] = 1 + i % 3;
    for (uint32_t k = 0; k < p->keys[i]; k++) {
      float *m = p->transform[i] + 12 * k;
      for (int e = 0; e < 12; e++) {
        const bool diagonal = e % 5 == 0, shift = e % 4 == 3;
        if (shift) m[e] = 4 * rng_sign(&r);
        else if (diagonal) m[e] = i % 5 == 0 ? 1 : 0.6f + 0.2f * rng_sign(&r);
        else m[e] = i % 5 < 2 ? 0 : 0.2f * rng_sign(&r);
        if (k && shift) m[e] = m[e - 12] + 0.2f * rng_sign(&r);
        else if (k && m[e] != 0) m[e] = m[e - 12] + (i % 5 == 0 ? 0 : 0.02f * rng_sign(&r));
      }
      if (k == 0)
        for (int e = 0; e < 12; e += 4) m[e] = -m[e];
      CHECK(determinant(m) < 0, "instance %u is mirrored at key %u", (unsigned)i, (unsigned)k);
    }
    take_mirror_out(p->transform[i], p->keys[i], side);
  }
}

/* A ray to a random point of a random instance as the first scene has it, at a random time. */
static pktrt_ray ray_at_instance(const placement *p, rng *r) {
  const uint32_t i = rng_below(r, p->n);
  const mesh *m = &p->model[p->of[i]].m[0];
  const uint32_t *corner = m->i + 3 * (size_t)rng_below(r, m->nt);
  const float time = rng_unit(r), u = rng_unit(r), v = (1 - u) * rng_unit(r);
  float p0[3], p1[3], p2[3], origin[3], target[3];
  double to[12];
  ref_vertex(m, corner[0], time, p0), ref_vertex(m, corner[1], time, p1), ref_vertex(m, corner[2], time, p2);
  (void)placed_at(p->transform[i], p->keys[i], time, to);
  for (int a = 0; a < 3; a++) {
    double sum = to[4 * a + 3];
    for (int b = 0; b < 3; b++) sum += to[4 * a + b] * (double)((1 - u - v) * p0[b] + u * p1[b] + v * p2[b]);
    target[a] = (float)sum;
    origin[a] = rng_below(r, 3) ? 7 * rng_sign(r) : target[a] + 0.3f * rng_sign(r);
  }
  return ray_towards(origin, target, time);
}

typedef struct differences {
  size_t hits, inside, depths, normals, surfaces, spawned, spawned_at, control;
} differences;

/* Compares all that is told of a hit and of rays that leave it, in two scenes. */
static void compare_hit(pktrt_scene *const *s, const pktrt_ray *ray, const pktrt_hit *hit, rng *r, differences *d) {
  pktrt_surface_info info[SIDES];
  for (int side = 0; side < SIDES; side++) pktrt_surface(s[side], ray, &hit[side], &info[side]);
  d->hits++;
  d->inside += info[0].inside;
  d->control += info[0].inside != info[INSIDE_OUT].inside;
  d->depths += hit[0].t != hit[1].t || hit[0].u != hit[1].v || hit[0].v != hit[1].u;
  for (int a = 0; a < 3; a++) d->normals += hit[0].normal[a] != -hit[1].normal[a];
  d->surfaces += info[0].inside != info[1].inside;
  for (int a = 0; a < 3; a++) {
    d->surfaces += info[0].position[a] != info[1].position[a] || info[0].normal[a] != info[1].normal[a];
    d->surfaces += info[0].shading_normal[a] != info[1].shading_normal[a];
  }

  for (int way = 0; way < 3; way++) {
    float direction[3];
    for (int a = 0; a < 3; a++) {
      const float along = hit[0].normal[(a + 1) % 3] - hit[0].normal[(a + 2) % 3]; /* nearly in the plane */
      direction[a] = way == 0 ? ray->direction[a] : way == 1 ? rng_sign(r) : along;
    }
    pktrt_ray out[2], at[2];
    memset(out, 0, sizeof out), memset(at, 0, sizeof at);
    for (int side = 0; side < 2; side++) {
      const pktrt_hit *h = &hit[side];
      pktrt_spawn(s[side], ray, h, direction, &out[side]);
      pktrt_spawn_at(s[side], h->mesh, h->triangle, h->u, h->v, ray->time, direction, &at[side]);
    }
    for (int a = 0; a < 3; a++) {
      d->spawned += out[0].origin[a] != out[1].origin[a];
      d->spawned_at += at[0].origin[a] != at[1].origin[a];
    }
  }
}

static void sides_of_hits(void) {
  static placement p[SIDES];
  differences d;
  size_t apart = 0;
  memset(&d, 0, sizeof d);
  for (int side = 0; side < SIDES; side++) make_models(&p[side], side), make_places(&p[side], side);
  for (int k = 0; k < isa_count; k++) {
    const pktrt_scene_desc desc = scene_desc_of(isas[k], 0);
    pktrt_scene *s[SIDES];
    rng r = rng_of(22);
    for (int side = 0; side < SIDES; side++) {
      s[side] = pktrt_scene_create(&desc);
      CHECK(placement_fill(s[side], &p[side]), "%s", pktrt_last_error(s[side]));
    }
    for (size_t i = 0; i < scaled(8000); i++) {
      const pktrt_ray ray = ray_at_instance(&p[MIRRORED], &r);
      pktrt_hit hit[SIDES];
      for (int side = 0; side < SIDES; side++) (void)pktrt_intersect(s[side], &ray, &hit[side]);
      apart += hit[0].mesh != hit[1].mesh || hit[0].triangle != hit[1].triangle;
      apart += hit[0].mesh != hit[2].mesh || hit[0].triangle != hit[2].triangle;
      if (hit[0].mesh != PKTRT_NONE) compare_hit(s, &ray, hit, &r, &d);
    }
    for (int side = 0; side < SIDES; side++) pktrt_scene_destroy(s[side]);
  }
  CHECK(apart == 0, "%zu rays hit something else", apart);
  CHECK(d.depths == 0 && d.normals == 0, "%zu t, u or v differ, %zu normals are not those of the corners", d.depths,
      d.normals);
  CHECK(d.surfaces == 0, "%zu surfaces differ", d.surfaces);
  CHECK(d.spawned == 0 && d.spawned_at == 0, "%zu and %zu rays start elsewhere", d.spawned, d.spawned_at);
  CHECK(d.hits > scaled(8000) / 2 && d.inside > d.hits / 20 && d.control == d.hits,
      "%zu hits, %zu from the inside, %zu noticed inside out", d.hits, d.inside, d.control);
  say("%zu hits, %zu from the inside, as in the counterpart; control, inside out: %zu differ", d.hits, d.inside,
      d.control);
  for (int side = 0; side < SIDES; side++)
    for (uint32_t i = 0; i < p[side].models; i++) world_free(&p[side].model[i]);
}

/* Points around all instances: the closed ones wind as their models do. */
static void windings(void) {
  static placement p[SIDES];
  size_t differ = 0, within = 0, control = 0, points = 0, wrong = 0;
  pktrt_scene *s[SIDES];
  rng r = rng_of(23);
  const pktrt_scene_desc desc = scene_desc_of(PKTRT_ISA_AUTO, 0);
  for (int side = 0; side < SIDES; side++) {
    make_models(&p[side], side), make_places(&p[side], side);
    s[side] = pktrt_scene_create(&desc);
    CHECK(placement_fill(s[side], &p[side]), "%s", pktrt_last_error(s[side]));
  }
  for (size_t i = 0; i < scaled(4000); i++) {
    const uint32_t body = rng_below(&r, p[0].n);
    const float time = rng_unit(&r);
    double m[12];
    float point[3];
    (void)placed_at(p[0].transform[body], p[0].keys[body], time, m);
    for (int a = 0; a < 3; a++) point[a] = (float)m[4 * a + 3] + rng_sign(&r);
    int winding[SIDES];
    for (int side = 0; side < SIDES; side++) winding[side] = pktrt_winding(s[side], body, point, time);
    const bool closed = p[0].of[body] != 2;
    points++;
    differ += winding[MIRRORED] != winding[COUNTERPART];
    wrong += closed && winding[MIRRORED] != 0 && winding[MIRRORED] != 1;
    within += closed && winding[MIRRORED] == 1;
    control += closed && winding[MIRRORED] == 1 && winding[INSIDE_OUT] == -1;
  }
  CHECK(differ == 0 && wrong == 0, "%zu of %zu points differ, around %zu something winds neither 0 nor 1 times", differ,
      points, wrong);
  CHECK(within > points / (small_run ? 20 : 10) && control == within,
      "%zu points inside, %zu of them noticed inside out", within, control);
  say("%zu points, %zu inside a mirrored body, as in the counterpart; control: %zu differ", points, within, control);
  for (int side = 0; side < SIDES; side++) {
    pktrt_scene_destroy(s[side]);
    for (uint32_t i = 0; i < p[side].models; i++) world_free(&p[side].model[i]);
  }
}

/* --- pictures --- */

enum { PIXELS = 24, GLASS = 0, WATER, MATT, GLOWS, SHEET, LOOKS };

/* What a picture is taken of and how. */
typedef struct look {
  const char *name;
  pktrt_mode mode;
  bool moves, smooth, blocks, within; /* within: the camera stands in the glass */
  pktrt_branching branching;
} look;

static pktrt_material look_of(int which) {
  pktrt_material m =
      material_of(which == MATT ? 0.7 : 0, which < MATT || which == SHEET ? PKTRT_SPECULAR_DIELECTRIC : 0, 0);
  m.ior[0] = which == WATER ? 0.9f : 1.5f;
  for (int a = 0; a < 3; a++) {
    m.absorption[a] = which == GLASS ? 0.2f + 0.3f * (float)a : which == WATER ? 0.9f - 0.4f * (float)a : 0;
    m.emission[a] = which == GLOWS ? 0.5f : 0;
  }
  return m;
}

/* Adds a model of a ball of glass with a ball of water in it, something matt in that, a sheet of glass and a tile that
   glows; then two instances of it. */
static void add_bodies(pktrt_scene *s, const look *l, int side, const uint32_t *material) {
  mesh m[LOOKS] = {mesh_sphere(2, 0, 1), mesh_sphere(1, 0.1f, 2), mesh_box(), mesh_grid(1, 0.3f), mesh_grid(1, 0.8f)};
  static const float where[LOOKS][4] = {
      {1, 0, 0, 0}, {0.5f, 0.2f, 0, 0.1f}, {0.1f, 0.3f, 0, 0}, {1, 0.4f, -0.9f, 1}, {1, 0.3f, 1.2f, 0}};
  static const float at[2][24] = {
      {-1, 0, 0, -1.5f, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, -1.25f, 0, 1, 0, 0.25f, 0, 0, 1, 0},
      {0.75f, 0.25f, 0, 1.25f, 0.125f, -0.75f, 0.25f, 0, 0, 0, 0.875f, 0.25f, 0.75f, 0.375f, 0, 1, 0.125f, -0.875f,
          0.25f, 0, 0, 0, 0.875f, 0.25f}};
  pktrt_mesh_desc desc[LOOKS];
  mesh normals = mesh_sphere(2, 0, 1);
  uint32_t model;
  for (int i = 0; i < LOOKS; i++) {
    mesh_scale(&m[i], where[i][0]), mesh_shift(&m[i], where[i][1], where[i][2], where[i][3]);
    make_counterpart(&m[i], side);
    desc[i] = mesh_desc(&m[i]), desc[i].material = material[i];
  }
  make_counterpart(&normals, side);
  if (l->smooth) desc[GLASS].normals = normals.p;
  CHECK(pktrt_add_model(s, desc, LOOKS, &model) == PKTRT_OK, "%s", pktrt_last_error(s));
  for (int i = 0; i < 2; i++) {
    float keys[24];
    memcpy(keys, at[i], sizeof keys);
    CHECK(determinant(keys) < 0 && determinant(keys + 12) < 0, "instance %d is mirrored", i);
    take_mirror_out(keys, 2, side);
    const pktrt_instance_desc d = {model, l->moves ? 2 : 1, keys, 0, PKTRT_INTERPOLATION_LINEAR};
    CHECK(pktrt_add_instance(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  }
  for (int i = 0; i < LOOKS; i++) mesh_free(&m[i]);
  mesh_free(&normals);
}

static pktrt_scene *open_look(const look *l, int side, pktrt_isa isa) {
  const pktrt_scene_desc desc = scene_desc_of(isa, 0);
  pktrt_scene *s = pktrt_scene_create(&desc);
  const pktrt_material ground = material_of(0.6, PKTRT_SPECULAR_NONE, 0);
  const quad floor = quad_of(vec_of(0, -1.5, 0), vec_of(0, 0, 6), vec_of(6, 0, 0)),
             lamp = quad_of(vec_of(1, 4, 1), vec_of(0.5, 0, 0), vec_of(0, 0, 0.5));
  uint32_t material[LOOKS];
  pktrt_light light = light_of(PKTRT_LIGHT_POINT, 20);
  const pktrt_light area = quad_light(&lamp, 5);
  for (int i = 0; i < LOOKS; i++) {
    const pktrt_material m = look_of(i);
    material[i] = stage_material(s, &m);
  }
  add_bodies(s, l, side, material);
  stage_quad(s, &floor, stage_material(s, &ground));
  light.position[0] = -2, light.position[1] = 5, light.position[2] = 2;
  stage_light(s, &light), stage_light(s, &area);
  stage_commit(s);
  return s;
}
static void take_picture(pktrt_scene *s, const look *l, float *pixels) {
  const vec eye = l->within ? vec_of(-1.5, 0.5, 0.5) : vec_of(-0.5, 1.5, 5);
  pktrt_render_desc d = stage_view(l->mode, PIXELS, PIXELS, pixels, eye, vec_of(-0.5, -0.2, 0));
  d.camera.fov_y = l->within ? 90 : 50;
  d.branching = l->branching, d.max_depth = 7, d.attenuation = 0.05f;
  if (l->blocks) d.glass_shadows = PKTRT_GLASS_SHADOWS_BLOCK;
  if (l->mode == PKTRT_MODE_DRT) d.samples = 4;
  if (l->moves) d.camera.shutter = 1;
  for (int a = 0; a < 3; a++) d.background[a] = 0.3f, d.ambient[a] = 0.1f;
  stage_render(s, &d);
}

static void pictures_of_mirrored_glass(void) {
  static const look looks[] = {
      {"WRT", PKTRT_MODE_WRT, .smooth = true},
      {"WRT, flat", PKTRT_MODE_WRT, .smooth = false},
      {"WRT, opaque to shadows", PKTRT_MODE_WRT, .blocks = true},
      {"WRT, from within", PKTRT_MODE_WRT, .smooth = true, .within = true},
      {"DRT", PKTRT_MODE_DRT, .smooth = true},
      {"DRT, moving", PKTRT_MODE_DRT, .smooth = true, .moves = true},
      {"DRT, moving, from within, both ways", PKTRT_MODE_DRT, .moves = true, .within = true,
          .branching = PKTRT_BRANCHING_BOTH},
  };
  static float picture[SIDES][3 * PIXELS * PIXELS];
  size_t pictures = 0, least_control = SIZE_MAX;
  for (size_t i = 0; i < sizeof looks / sizeof *looks; i++)
    for (int k = 0; k < isa_count; k++) {
      size_t differ[SIDES] = {0, 0, 0};
      for (int side = 0; side < SIDES; side++) {
        pktrt_scene *s = open_look(&looks[i], side, isas[k]);
        take_picture(s, &looks[i], picture[side]);
        pktrt_scene_destroy(s);
        for (size_t p = 0; p < 3 * PIXELS * PIXELS; p += 3)
          differ[side] += !same_bits(picture[0] + p, picture[side] + p, 3 * sizeof(float));
      }
      CHECK(differ[COUNTERPART] == 0, "%s, %s: %zu of %d pixels differ", looks[i].name, pktrt_isa_string(isas[k]),
          differ[COUNTERPART], PIXELS * PIXELS);
      CHECK(differ[INSIDE_OUT] > PIXELS * PIXELS / 8, "%s: control, inside out, only %zu pixels differ", looks[i].name,
          differ[INSIDE_OUT]);
      least_control = differ[INSIDE_OUT] < least_control ? differ[INSIDE_OUT] : least_control;
      pictures++;
    }
  say("%zu pictures of mirrored glass have the bits of their counterparts; control, inside out: at least %zu of %d "
      "pixels "
      "differ",
      pictures, least_control, PIXELS * PIXELS);
}

/* Returns the largest difference of a channel of two pictures. */
static double farthest_apart(const float *one, const float *other) {
  double most = 0;
  for (int i = 0; i < 3 * PIXELS * PIXELS; i++) {
    const double apart = fabs((double)one[i] - (double)other[i]);
    if (apart > most) most = apart;
  }
  return most;
}

/* A ball of absorbing glass that is its own mirror image, added directly, and placed by x to -x: one picture. Triangles lie
   elsewhere in their meshes, so that rounding may differ. */
static void ball_is_the_ball(void) {
  static float picture[2][3 * PIXELS * PIXELS], plain[3 * PIXELS * PIXELS];
  static const float mirror[12] = {-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  for (int smooth = 0; smooth < 2; smooth++) {
    for (int placed = 0; placed < 3; placed++) {
      pktrt_scene *s = stage_open();
      const pktrt_material glass = look_of(GLASS), ground = material_of(0.6, PKTRT_SPECULAR_NONE, 0);
      const pktrt_light light = light_of(PKTRT_LIGHT_DIRECTIONAL, 3);
      const quad floor = quad_of(vec_of(0, -1.5, 0), vec_of(0, 0, 6), vec_of(6, 0, 0));
      mesh ball = mesh_sphere(3, 0, 1);
      uint32_t model;
      pktrt_mesh_desc d = mesh_desc(&ball);
      d.material = stage_material(s, &glass), d.normals = smooth ? ball.p : NULL;
      const pktrt_instance_desc at = {0, 1, mirror, 0, PKTRT_INTERPOLATION_LINEAR};
      if (placed == 2) turn_round(&ball); /* inside out, which is what the control sees */
      if (placed == 1) {
        CHECK(pktrt_add_model(s, &d, 1, &model) == PKTRT_OK && pktrt_add_instance(s, &at, NULL) == PKTRT_OK);
      } else {
        CHECK(pktrt_add_mesh(s, &d, NULL) == PKTRT_OK);
      }
      stage_quad(s, &floor, stage_material(s, &ground));
      pktrt_light down = light;
      down.direction[0] = 0.25f, down.direction[1] = -1;
      stage_light(s, &down);
      stage_commit(s);
      look l = {"", PKTRT_MODE_WRT, .smooth = smooth};
      take_picture(s, &l, placed == 2 ? plain : picture[placed]);
      pktrt_scene_destroy(s);
      mesh_free(&ball);
    }
    const double worst = farthest_apart(picture[0], picture[1]);
    const double control = farthest_apart(picture[0], plain);
    CHECK(worst < 1e-4 && control > 0.1, "worst %g, control %g", worst, control);
    say("%s: at most %.1e apart; control, inside out: %.2f", smooth ? "smooth" : "flat", worst, control);
  }
}

/* What is closed and mirrored is left where it was entered when its transform is set anew, mirrored or not. */
static void mirrors_are_set_anew(void) {
  static const float key[3][12] = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}, {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0},
      {0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0}};
  static const float middle[3] = {0.1f, 0.2f, 0.15f};
  world w = world_of(mesh_box());
  const pktrt_mesh_desc m = mesh_desc(&w.m[0]);
  const pktrt_instance_desc d = {0, 1, key[0], 0, PKTRT_INTERPOLATION_LINEAR};
  pktrt_scene *s = stage_open();
  CHECK(pktrt_add_model(s, &m, 1, NULL) == PKTRT_OK && pktrt_add_instance(s, &d, NULL) == PKTRT_OK);
  stage_commit(s);
  for (int i = 0; i < 6; i++) {
    const float *to = key[i % 3];
    const pktrt_ray ray = ray_of(0.1f, 0.2f, 9, 0, 0, -1);
    pktrt_hit hit;
    pktrt_surface_info info;
    CHECK(pktrt_set_transform(s, 0, 0, to) == PKTRT_OK && (i < 3 ? pktrt_refit(s) : pktrt_commit(s)) == PKTRT_OK);
    CHECK(pktrt_winding(s, 0, middle, 0) == 1, "transform %d: winds %d times", i, pktrt_winding(s, 0, middle, 0));
    CHECK(pktrt_intersect(s, &ray, &hit));
    pktrt_surface(s, &ray, &hit, &info);
    CHECK(!info.inside, "transform %d", i);
    CHECK((hit.normal[2] > 0) == (determinant(to) > 0), "transform %d: the normal is that of the corners", i);
  }
  pktrt_scene_destroy(s);
  world_free(&w);
}

/* Needles in the plane z = 0, so thin that their normal is that of the hit, not of the corners in doubles. Rays leave them
   nearly along that plane, where corners decide the side, or not so, and start on the side that they go to. */
static void rays_leave_needles(void) {
  size_t astray = 0, rays = 0, flipped = 0;
  rng r = rng_of(25);
  for (int mirror = 0; mirror < 8; mirror++) {
    mesh needle = mesh_of(3, 1);
    float to[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const float corner[9] = {0, 0, 0, 1, 0x1p-32f, 0, 2, 0, 0};
    memcpy(needle.p, corner, sizeof corner);
    for (uint32_t c = 0; c < 3; c++) needle.i[c] = c;
    for (int a = 0; a < 3; a++)
      if (mirror >> a & 1) to[5 * a] = -1;
    const pktrt_mesh_desc m = mesh_desc(&needle);
    const pktrt_instance_desc d = {0, 1, to, 0, PKTRT_INTERPOLATION_LINEAR};
    pktrt_scene *s = stage_open();
    CHECK(pktrt_add_model(s, &m, 1, NULL) == PKTRT_OK && pktrt_add_instance(s, &d, NULL) == PKTRT_OK);
    stage_commit(s);

    for (int i = 0; i < 200; i++) {
      const float steep = i % 2 ? 0x1p-30f : 1, up = rng_below(&r, 2) ? steep : -steep;
      const float direction[3] = {rng_sign(&r), rng_sign(&r), up};
      const float u = 0.5f * rng_unit(&r), v = 0.5f * rng_unit(&r);
      pktrt_ray out;
      pktrt_spawn_at(s, 0, 0, u, v, 0, direction, &out);
      astray += !(out.origin[2] * up > 0);
      flipped += determinant(to) < 0;
      rays++;
    }
    pktrt_scene_destroy(s);
    mesh_free(&needle);
  }
  CHECK(astray == 0 && flipped == rays / 2, "%zu of %zu rays start on the other side", astray, rays);
}

void suite_mirrored(void) {
  run("inside and outside of a mirrored instance are its model's, for surfaces and the rays that leave them",
      sides_of_hits);
  run("a mirrored instance winds around points as its model does", windings);
  run("pictures of mirrored glass, still and moving, have the bits of mirrored models whose corners are turned round",
      pictures_of_mirrored_glass);
  run("a ball of glass placed by x to -x is the ball", ball_is_the_ball);
  run("rays leave needles of mirrored instances on the side that they go to", rays_leave_needles);
  run("an instance is mirrored, or no longer, from the refit or commit on that takes its transform over",
      mirrors_are_set_anew);
}
