/* scene_rtrt.h - "rtrt": six cartoon characters dance on a polished stage, under letters and a mirror ball. Included by
   scenes.h, after its builder.

   Each character is a rig and some surfaces around it. The rig is a set of stations: frames along the spine, the arms
   and the legs, as functions of time. Surfaces are modelled around the rig's pose at time 0: zero sets of smooth unions
   of ellipsoids and hoses, made into closed meshes on a grid (body, gloves, shoes), and patches on ellipsoids (faces).
   To deform, a vertex goes along with the stations near its place at time 0: what a character wears stays on it.

   Contents: kinds, actors, rig, deformation, surfaces, grid, faces, bodies, stage, materials, make. */
#ifndef SCENE_RTRT_H
#define SCENE_RTRT_H

/* >>kinds ---------------------------------------------------------------------------------------------------------- */

/* The parts of a character, a mesh each. */
enum { RTRT_BODY, RTRT_GLOVES, RTRT_SHOES, RTRT_WHITE, RTRT_BLACK, RTRT_IRIS, RTRT_PINK, RTRT_TRIM, RTRT_PARTS };

enum { RTRT_IMP, RTRT_ROBOT, RTRT_DROP, RTRT_BEAR, RTRT_CYCLOPS, RTRT_FROG, RTRT_ACTORS };

enum {
  RTRT_KEY,
  RTRT_STRIP,
  RTRT_HOUSE,
  RTRT_CAST,
  RTRT_FLOOR = RTRT_CAST + (int)RTRT_ACTORS * RTRT_PARTS,
  RTRT_RISER,
  RTRT_GILT,
  RTRT_CURTAIN,
  RTRT_LETTERS,
  RTRT_FACETS,
  RTRT_BULBS,
  RTRT_GLASS,
  RTRT_CHROME,
  RTRT_MARBLE,
  RTRT_SWEET_1,
  RTRT_SWEET_2,
  RTRT_SWEET_3,
  RTRT_SWEET_4,
  RTRT_KINDS
};

/* The first of an actor's materials. */
static uint32_t rtrt_look(uint32_t actor) { return RTRT_CAST + actor * RTRT_PARTS; }

/* clang-format off */
static const sc_kind rtrt_kinds[RTRT_KINDS] = {
    {"key light", {0.9f, 0.9f, 0.9f}, 1},            {"strip light", {0.9f, 0.9f, 0.9f}, 1},
    {"house", {0.10f, 0.03f, 0.03f}, 1},
    {"imp", {0.78f, 0.115f, 0.045f}, 0},             {"imp's gloves", {0.82f, 0.78f, 0.68f}, 0},
    {"imp's shoes", {0.78f, 0.45f, 0.05f}, 0},       {"imp's eyes", {0.86f, 0.85f, 0.82f}, 0},
    {"imp's pupils", {0.012f, 0.010f, 0.010f}, 0},   {"imp's iris", {0.82f, 0.46f, 0.06f}, 0},
    {"imp's tongue", {0.78f, 0.16f, 0.15f}, 0},      {"imp's feelers", {0.85f, 0.50f, 0.05f}, 0},
    {"robot", {0.56f, 0.57f, 0.58f}, 0},             {"robot's gloves", {0.70f, 0.70f, 0.70f}, 0},
    {"robot's shoes", {0.60f, 0.06f, 0.03f}, 0},     {"robot's eyes", {0.86f, 0.85f, 0.82f}, 0},
    {"robot's pupils", {0.012f, 0.010f, 0.010f}, 0}, {"robot's iris", {0.82f, 0.46f, 0.06f}, 0},
    {"robot's tongue", {0.78f, 0.16f, 0.15f}, 0},    {"robot's bolts", {0.70f, 0.08f, 0.03f}, 0},
    {"drop", {0.30f, 0.62f, 0.66f}, 0},              {"drop's gloves", {0.82f, 0.78f, 0.68f}, 0},
    {"drop's shoes", {0.06f, 0.30f, 0.42f}, 0},      {"drop's eyes", {0.86f, 0.85f, 0.82f}, 0},
    {"drop's pupils", {0.012f, 0.010f, 0.010f}, 0},  {"drop's iris", {0.82f, 0.46f, 0.06f}, 0},
    {"drop's cheeks", {0.78f, 0.16f, 0.15f}, 0},     {"drop's trim", {0.80f, 0.25f, 0.22f}, 0},
    {"bear", {0.72f, 0.46f, 0.12f}, 0},              {"bear's gloves", {0.82f, 0.78f, 0.68f}, 0},
    {"bear's shoes", {0.10f, 0.045f, 0.025f}, 0},    {"bear's eyes", {0.86f, 0.85f, 0.82f}, 0},
    {"bear's pupils", {0.012f, 0.010f, 0.010f}, 0},  {"bear's iris", {0.82f, 0.46f, 0.06f}, 0},
    {"bear's tongue", {0.78f, 0.16f, 0.15f}, 0},     {"bear's muzzle", {0.46f, 0.22f, 0.10f}, 0},
    {"cyclops", {0.36f, 0.10f, 0.42f}, 0},           {"cyclops' gloves", {0.82f, 0.78f, 0.68f}, 0},
    {"cyclops' shoes", {0.80f, 0.45f, 0.05f}, 0},    {"cyclops' eye", {0.86f, 0.85f, 0.82f}, 0},
    {"cyclops' pupil", {0.012f, 0.010f, 0.010f}, 0}, {"cyclops' iris", {0.82f, 0.46f, 0.06f}, 0},
    {"cyclops' tongue", {0.78f, 0.16f, 0.15f}, 0},   {"cyclops' horns", {0.84f, 0.72f, 0.48f}, 0},
    {"frog", {0.20f, 0.52f, 0.10f}, 0},              {"frog's gloves", {0.82f, 0.78f, 0.68f}, 0},
    {"frog's shoes", {0.75f, 0.10f, 0.12f}, 0},      {"frog's eyes", {0.86f, 0.85f, 0.82f}, 0},
    {"frog's pupils", {0.012f, 0.010f, 0.010f}, 0},  {"frog's iris", {0.82f, 0.46f, 0.06f}, 0},
    {"frog's tongue", {0.78f, 0.16f, 0.15f}, 0},     {"frog's belly", {0.72f, 0.74f, 0.35f}, 0},
    {"floor", {0.40f, 0.30f, 0.20f}, 1},             {"risers", {0.030f, 0.055f, 0.105f}, 0},
    {"gilt", {0.72f, 0.46f, 0.14f}, 0},              {"curtain", {0.055f, 0.225f, 0.290f}, 0},
    {"letters", {0.54f, 0.15f, 0.16f}, 0},           {"mirror ball", {0.60f, 0.62f, 0.64f}, 1},
    {"bulbs", {0.95f, 0.80f, 0.50f}, 0},             {"glass", {0.55f, 0.60f, 0.60f}, 0},
    {"chrome", {0.56f, 0.57f, 0.58f}, 0},            {"marble", {0.70f, 0.66f, 0.62f}, 0},
    {"sweets, red", {0.70f, 0.03f, 0.03f}, 0},       {"sweets, yellow", {0.82f, 0.50f, 0.03f}, 0},
    {"sweets, green", {0.10f, 0.45f, 0.08f}, 0},     {"sweets, blue", {0.04f, 0.16f, 0.55f}, 0}};
/* clang-format on */

/* >>actors --------------------------------------------------------------------------------------------------------- */

/* Lengths of a character are relative to its size; it looks along +z, its left is +x. Where there are two of a thing,
   the first is on the left. Dancing goes with sine and cosine of psi, which turns `beats` times in a loop. */
typedef struct rtrt_actor {
  double place[3], yaw, size;
  double legs, torso;       /* from the floor to the hips, from there to the middle of the head */
  double belly[3], head[3]; /* half axes of ellipsoids, */
  double melt;              /* and how softly one becomes the other */
  double arm, leg;          /* radii */
  double shoulder[2], hip;  /* shoulder: out of the chest, up from it; hip: out */
  double beats, phase;
  double hop, dip, squash;       /* up in the air; down in the knees; both, in proportion of height */
  double sway, lean, twist, nod; /* of the hips, in lengths; of the spine and the head, in degrees */
  double step;                   /* height to which a foot is lifted */
  double stance[2];              /* a foot's place, out and to the front */
  double hand[2][3][3];          /* from the chest: mean, and what goes with the sine and the cosine */
  double curl[2];                /* how much a hand turns up */
  double mesh;                   /* size of its triangles, relative */
} rtrt_actor;

/* clang-format off */
static const rtrt_actor rtrt_cast[RTRT_ACTORS] = {
    {{0.05, 0.0, 0.62}, 2.0, 1.06, 0.37, 0.60, {0.215, 0.235, 0.195}, {0.275, 0.245, 0.245}, 0.10,
     0.042, 0.055, {0.17, 0.01}, 0.11, 2.0, 166.0, 0.31, 0.06, 0.10, 0.02, 5.0, 5.0, 7.0, 0.0, {0.15, 0.02},
     {{{0.55, 0.43, 0.10}, {0.05, 0.08, 0.05}, {-0.03, -0.22, 0.05}},
      {{-0.55, 0.42, 0.10}, {0.05, 0.08, 0.0}, {0.03, -0.22, 0.05}}}, {0.9, 0.9}, 0.92},
    {{-1.18, 0.0, 0.50}, 18.0, 1.02, 0.40, 0.62, {0.185, 0.215, 0.165}, {0.285, 0.225, 0.235}, 0.05,
     0.040, 0.050, {0.15, 0.06}, 0.10, 2.0, 80.0, 0.0, 0.07, 0.06, 0.08, 9.0, 16.0, 8.0, 0.12, {0.13, 0.02},
     {{{0.40, 0.10, 0.18}, {0.04, 0.06, 0.04}, {0.04, -0.14, 0.05}},
      {{-0.42, 0.24, 0.12}, {0.0, 0.06, 0.0}, {0.14, 0.22, 0.02}}}, {0.8, 1.0}, 0.96},
    {{1.24, 0.0, 0.46}, -16.0, 1.04, 0.35, 0.56, {0.255, 0.25, 0.225}, {0.235, 0.235, 0.22}, 0.22,
     0.050, 0.062, {0.18, 0.05}, 0.12, 2.0, 282.0, 0.04, 0.07, 0.08, 0.08, 10.0, 8.0, 10.0, 0.10, {0.15, 0.02},
     {{{0.41, 0.24, 0.12}, {-0.02, -0.05, 0.0}, {0.02, 0.22, 0.02}},
      {{-0.46, 0.06, 0.14}, {0.02, -0.08, 0.02}, {0.04, -0.18, 0.02}}}, {0.9, 0.8}, 0.97},
    {{-0.88, 0.21, -0.74}, 10.0, 1.22, 0.34, 0.64, {0.30, 0.29, 0.27}, {0.26, 0.235, 0.235}, 0.10,
     0.060, 0.075, {0.22, 0.06}, 0.14, 2.0, 100.0, 0.0, 0.07, 0.07, 0.08, 8.0, 10.0, 8.0, 0.06, {0.17, 0.02},
     {{{0.44, 0.36, 0.12}, {0.02, 0.04, 0.0}, {0.12, 0.06, 0.05}},
      {{-0.44, 0.36, 0.12}, {-0.02, 0.04, 0.0}, {0.12, -0.06, 0.05}}}, {1.0, 1.0}, 1.04},
    {{0.94, 0.21, -0.78}, -8.0, 1.30, 0.34, 0.62, {0.26, 0.29, 0.235}, {0.265, 0.27, 0.245}, 0.20,
     0.055, 0.070, {0.19, 0.04}, 0.13, 2.0, 262.0, 0.05, 0.06, 0.07, 0.08, 9.0, 8.0, 9.0, 0.08, {0.16, 0.02},
     {{{0.46, 0.36, 0.10}, {-0.04, -0.04, 0.0}, {0.14, -0.08, 0.0}},
      {{-0.46, 0.30, 0.10}, {0.02, -0.02, 0.0}, {0.14, 0.08, 0.0}}}, {1.0, 1.0}, 1.04},
    {{-0.40, 0.0, 1.32}, 6.0, 0.66, 0.30, 0.50, {0.25, 0.22, 0.22}, {0.31, 0.215, 0.25}, 0.12,
     0.046, 0.058, {0.19, 0.05}, 0.13, 3.0, 140.0, 0.16, 0.06, 0.10, 0.03, 6.0, 8.0, 8.0, 0.0, {0.17, 0.04},
     {{{0.52, 0.13, 0.14}, {0.04, 0.10, 0.02}, {0.0, -0.22, 0.04}},
      {{-0.52, 0.13, 0.14}, {-0.04, 0.10, 0.02}, {0.0, -0.22, 0.04}}}, {0.9, 0.9}, 1.24}};
/* clang-format on */

/* >>rig ------------------------------------------------------------------------------------------------------------ */

/* Stations: the spine from the hips to the head, then limbs: arms left and right, legs left and right; the last station
   of a limb is the hand or foot. */
enum { RTRT_BELLY = 1, RTRT_CHEST = 2, RTRT_HEAD = 4, RTRT_SPINE = 5, RTRT_LIMB = 9 };
enum { RTRT_LEGS = RTRT_SPINE + 2 * RTRT_LIMB, RTRT_STATIONS = RTRT_SPINE + 4 * RTRT_LIMB };

typedef struct rtrt_rig {
  sc_frame root, at[RTRT_STATIONS];
  sc_v3 curve[4][4]; /* limbs are Bezier curves */
  double reach[RTRT_STATIONS];
} rtrt_rig;

static sc_v3 rtrt_along(const sc_frame *f, double x, double y, double z) {
  return sc_add(sc_mul(f->x, x), sc_add(sc_mul(f->y, y), sc_mul(f->z, z)));
}
static sc_v3 rtrt_at(const sc_frame *f, double x, double y, double z) { return sc_add(f->o, rtrt_along(f, x, y, z)); }
static double rtrt_length(sc_v3 a) { return sqrt(sc_dot(a, a)); }

static sc_frame rtrt_scaled(const sc_frame *f, double x, double y, double z) {
  sc_frame r = *f;
  r.x = sc_mul(f->x, x), r.y = sc_mul(f->y, y), r.z = sc_mul(f->z, z);
  return r;
}

/* Turns a frame on itself: by `yaw` around y (z to x), `pitch` around x (y to z), then `roll` around z (x to y). */
static sc_frame rtrt_turned(const sc_frame *f, double yaw, double pitch, double roll) {
  sc_frame r = *f, t;
  double c = sc_cos(yaw), s = sc_sin(yaw);
  r.z = sc_add(sc_mul(f->z, c), sc_mul(f->x, s)), r.x = sc_sub(sc_mul(f->x, c), sc_mul(f->z, s));
  t = r, c = sc_cos(pitch), s = sc_sin(pitch);
  r.y = sc_add(sc_mul(t.y, c), sc_mul(t.z, s)), r.z = sc_sub(sc_mul(t.z, c), sc_mul(t.y, s));
  t = r, c = sc_cos(roll), s = sc_sin(roll);
  r.x = sc_add(sc_mul(t.x, c), sc_mul(t.y, s)), r.y = sc_sub(sc_mul(t.y, c), sc_mul(t.x, s));
  return r;
}

static sc_v3 rtrt_bezier(const sc_v3 *p, double t) {
  double s = 1.0 - t, a = s * s * s, b = 3.0 * s * s * t, c = 3.0 * s * t * t, d = t * t * t;
  return sc_add(sc_add(sc_mul(p[0], a), sc_mul(p[1], b)), sc_add(sc_mul(p[2], c), sc_mul(p[3], d)));
}
static sc_v3 rtrt_slope(const sc_v3 *p, double t) {
  double s = 1.0 - t;
  sc_v3 a = sc_mul(sc_sub(p[1], p[0]), 3.0 * s * s), b = sc_mul(sc_sub(p[2], p[1]), 6.0 * s * t);
  return sc_add(sc_add(a, b), sc_mul(sc_sub(p[3], p[2]), 3.0 * t * t));
}

/* How far up the body is, 0 to 1 twice in a turn; and a foot of a hopper, which leaves the floor later. */
static double rtrt_rise(const rtrt_actor *a, double psi) { return 0.5 - 0.5 * sc_cos((a->hop > 0.1 ? 1 : 2) * psi); }
static double rtrt_lift(const rtrt_actor *a, double psi) {
  double t = (rtrt_rise(a, psi) - 0.25) / 0.75;
  return t > 0.0 ? a->hop * t * t * (3.0 - 2.0 * t) : 0.0;
}

/* Hips to head: what bends the spine is spread evenly. Squashing keeps the volume. */
static void rtrt_spine(const rtrt_actor *a, double psi, rtrt_rig *r) {
  double rise = rtrt_rise(a, psi), tall = 1.0 + a->squash * (2.0 * rise - 1.0), wide = 1.0 / sqrt(tall);
  double s = sc_sin(psi);
  sc_frame f = r->root;
  uint32_t k;
  f.o = rtrt_at(&r->root, a->sway * s, a->legs * tall - a->dip * (1.0 - rise) + rtrt_lift(a, psi), 0.0);
  f = rtrt_turned(&f, 0.4 * a->twist * sc_cos(psi), 0.0, 0.4 * a->lean * s);
  for (k = 0; k < RTRT_SPINE; k++) {
    if (k == RTRT_HEAD) f = rtrt_turned(&f, 0.0, 0.5 * a->nod * sc_cos(2.0 * psi), a->nod * sc_sin(psi - 40.0));
    r->at[k] = rtrt_scaled(&f, wide, tall, wide);
    r->reach[k] = a->size * (k == RTRT_HEAD ? a->head[0] : k == 3 ? 0.5 * (a->head[0] + a->belly[0]) : a->belly[0]);
    f.o = rtrt_at(&f, 0.0, 0.25 * a->torso * tall, 0.0);
    f = rtrt_turned(&f, 0.25 * a->twist * sc_cos(psi), 1.5 * sc_cos(2.0 * psi), -0.4 * a->lean * s);
  }
}

/* Frames along a limb from its curve: y along it, the direction `front` next to z. Stretching makes a limb thinner. */
static void rtrt_limb(rtrt_rig *r, uint32_t limb, sc_v3 front, double radius) {
  const sc_v3 *p = r->curve[limb];
  uint32_t k, first = RTRT_SPINE + limb * RTRT_LIMB;
  for (k = 0; k + 1 < RTRT_LIMB; k++) {
    double t = (double)k / (RTRT_LIMB - 2);
    sc_v3 y = rtrt_slope(p, t);
    double stretch = rtrt_length(y), thin = 1.0 / sqrt(stretch);
    sc_frame *f = &r->at[first + k];
    f->o = rtrt_bezier(p, t);
    f->x = sc_mul(sc_unit(sc_cross(y, front)), thin);
    f->z = sc_mul(sc_unit(sc_cross(f->x, y)), thin);
    f->y = y;
    r->reach[first + k] = radius;
  }
}

/* Like a leg, an arm that is too long bends. */
static void rtrt_arm(const rtrt_actor *a, double psi, uint32_t side, rtrt_rig *r) {
  double out = side ? -1.0 : 1.0, s = sc_sin(psi), c = sc_cos(psi), e[3], room, elbow;
  const sc_frame *chest = &r->at[RTRT_CHEST];
  sc_frame from = r->root, *hand = &r->at[RTRT_SPINE + (side + 1) * RTRT_LIMB - 1];
  sc_v3 *p = r->curve[side], end, to;
  uint32_t i;
  from.o = chest->o;
  for (i = 0; i < 3; i++) e[i] = a->hand[side][0][i] + s * a->hand[side][1][i] + c * a->hand[side][2][i];
  end = rtrt_at(&from, e[0], e[1], e[2]);
  p[0] = rtrt_at(chest, 0.6 * out * a->shoulder[0], a->shoulder[1], 0.0);
  p[1] = rtrt_at(chest, out * (a->shoulder[0] + 0.14), a->shoulder[1] + 0.01, 0.02);
  to = sc_unit(sc_add(sc_unit(sc_sub(end, p[0])), sc_mul(sc_unit(r->root.y), a->curl[side])));
  p[3] = end;
  p[2] = sc_sub(end, sc_mul(to, 0.17 * a->size));
  room = rtrt_length(sc_sub(end, p[0])) / a->size;
  elbow = room < 0.5 ? 0.5 * sqrt(0.25 - room * room) : 0.0;
  for (i = 1; i < 3; i++) p[i] = sc_add(p[i], rtrt_along(&r->root, 0.5 * out * elbow, -0.7 * elbow, 0.0));
  rtrt_limb(r, side, r->root.z, a->size * a->arm);
  hand->o = sc_add(end, sc_mul(to, 0.05 * a->size)); /* as large as the character, its palm to the front */
  hand->x = sc_mul(sc_unit(sc_cross(to, r->root.z)), a->size);
  hand->y = sc_mul(to, a->size);
  hand->z = sc_cross(hand->x, to);
  r->reach[RTRT_SPINE + (side + 1) * RTRT_LIMB - 1] = 0.07 * a->size;
}

/* A leg that is too long for the way to the foot bends at the knee. */
static void rtrt_leg(const rtrt_actor *a, double psi, uint32_t side, rtrt_rig *r) {
  double out = side ? -1.0 : 1.0, s = out * sc_sin(psi), up = rtrt_lift(a, psi), room, knee, third;
  const sc_frame *hips = &r->at[0];
  sc_frame *foot = &r->at[RTRT_SPINE + (side + 3) * RTRT_LIMB - 1];
  sc_v3 *p = r->curve[2 + side], bend;
  if (s > 0.0) up += a->step * s * s;
  *foot = r->root;
  foot->o = rtrt_at(&r->root, out * a->stance[0], 0.085 + up, a->stance[1] + 0.3 * up * (a->hop > 0.1 ? -1.0 : 1.0));
  *foot = rtrt_turned(foot, out * 16.0, 70.0 * up, 0.0);
  p[0] = rtrt_at(hips, out * a->hip, 0.0, 0.0);
  p[3] = foot->o;
  room = rtrt_length(sc_sub(p[3], p[0]));
  third = 0.33 * room / a->size;
  knee = a->legs * a->size * a->legs * a->size - room * room;
  knee = knee > 0.0 ? 0.6 * sqrt(knee) / a->size : 0.0;
  bend = rtrt_along(&r->root, 0.5 * out * knee, 0.0, 0.8 * knee);
  p[1] = sc_add(rtrt_at(hips, out * a->hip, -third, 0.0), bend);
  p[2] = sc_add(rtrt_at(foot, 0.0, third, 0.0), bend);
  rtrt_limb(r, 2 + side, r->root.z, a->size * a->leg);
  r->reach[RTRT_SPINE + (side + 3) * RTRT_LIMB - 1] = 0.085 * a->size;
}

static void rtrt_pose(const rtrt_actor *a, double time, rtrt_rig *r) {
  double psi = 360.0 * a->beats * time + a->phase;
  sc_frame world = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  uint32_t side;
  world.o = sc_v(a->place[0], a->place[1], a->place[2]);
  r->root = rtrt_turned(&world, a->yaw, 0.0, 0.0);
  r->root = rtrt_scaled(&r->root, a->size, a->size, a->size);
  rtrt_spine(a, psi, r);
  for (side = 0; side < 2; side++) {
    rtrt_arm(a, psi, side, r);
    rtrt_leg(a, psi, side, r);
  }
}

/* >>deformation ---------------------------------------------------------------------------------------------------- */

/* The map that takes a station from one pose to another. Axes of a station are perpendicular. */
static sc_frame rtrt_motion(const sc_frame *from, const sc_frame *to) {
  sc_v3 x = sc_mul(from->x, 1.0 / sc_dot(from->x, from->x)), y = sc_mul(from->y, 1.0 / sc_dot(from->y, from->y));
  sc_v3 z = sc_mul(from->z, 1.0 / sc_dot(from->z, from->z)), o = from->o;
  sc_frame r;
  r.x = rtrt_along(to, x.x, y.x, z.x);
  r.y = rtrt_along(to, x.y, y.y, z.y);
  r.z = rtrt_along(to, x.z, y.z, z.z);
  r.o = sc_sub(to->o, rtrt_along(&r, o.x, o.y, o.z));
  return r;
}

/* Where a vertex goes with the stations `first` up to `end`. They count with e^-4, where e is the distance from the
   sphere of their reach, bent smoothly into a small positive number inside: nearly as if the nearest decided. */
static sc_v3 rtrt_moved(const rtrt_rig *rest, const sc_frame *motion, uint32_t first, uint32_t end, sc_v3 p) {
  sc_v3 sum = sc_v(0.0, 0.0, 0.0);
  double total = 0.0, soft = 0.0025 * sc_dot(rest->root.y, rest->root.y);
  uint32_t k;
  for (k = first; k < end; k++) {
    sc_v3 d = sc_sub(p, rest->at[k].o);
    double out = sqrt(sc_dot(d, d)) - rest->reach[k], e = out + sqrt(out * out + soft), w = 1.0 / (e * e);
    w *= w;
    sum = sc_add(sum, sc_mul(rtrt_at(&motion[k], p.x, p.y, p.z), w));
    total += w;
  }
  return sc_mul(sum, 1.0 / total);
}

/* Normals of vertices: the sum of the cross products of the edges at each corner, over the squares of their lengths,
   which is exact where the neighbours lie on a sphere (Max, Weights for computing vertex normals, 1999). */
static void rtrt_normals(const scene_mesh *m, const float *positions, float *normals) {
  uint32_t i, k;
  for (i = 0; i < 3 * m->vertex_count; i++) normals[i] = 0.0f;
  for (i = 0; i < m->triangle_count; i++)
    for (k = 0; k < 3; k++) {
      const uint32_t *v = m->indices + 3 * i;
      sc_v3 p = sc_get(positions, v[k]);
      sc_v3 e = sc_sub(sc_get(positions, v[(k + 1) % 3]), p), f = sc_sub(sc_get(positions, v[(k + 2) % 3]), p);
      double squares = sc_dot(e, e) * sc_dot(f, f), w = squares > 0.0 ? 1.0 / squares : 0.0;
      sc_v3 n = sc_mul(sc_cross(e, f), w);
      float *to = normals + 3 * v[k];
      to[0] += (float)n.x, to[1] += (float)n.y, to[2] += (float)n.z;
    }
  for (i = 0; i < m->vertex_count; i++) {
    sc_v3 n = sc_unit(sc_get(normals, i));
    normals[3 * i] = sc_snap(n.x), normals[3 * i + 1] = sc_snap(n.y), normals[3 * i + 2] = sc_snap(n.z);
  }
}

/* Gloves go with the arms, shoes with the legs, what is in the face or on the head with the spine: all stay in shape
   whatever comes near. */
static void rtrt_deform(const scene *s, const scene_mesh *m, double time, float *positions, float *normals) {
  static const uint32_t part_end[3] = {RTRT_STATIONS, RTRT_LEGS, RTRT_STATIONS};
  static const uint32_t part_first[3] = {0, RTRT_SPINE, RTRT_LEGS};
  const rtrt_actor *a = &rtrt_cast[(m->material - RTRT_CAST) / RTRT_PARTS];
  uint32_t part = (m->material - RTRT_CAST) % RTRT_PARTS, first = part < 3 ? part_first[part] : 0;
  uint32_t end = part < 3 ? part_end[part] : (uint32_t)RTRT_SPINE;
  rtrt_rig rest, now;
  sc_frame motion[RTRT_STATIONS];
  uint32_t i;
  (void)s;
  rtrt_pose(a, 0.0, &rest);
  rtrt_pose(a, time, &now);
  for (i = 0; i < RTRT_STATIONS; i++) motion[i] = rtrt_motion(&rest.at[i], &now.at[i]);
  for (i = 0; i < m->vertex_count; i++) {
    sc_v3 p = rtrt_moved(&rest, motion, first, end, sc_get(m->positions, i));
    positions[3 * i] = sc_snap(p.x), positions[3 * i + 1] = sc_snap(p.y), positions[3 * i + 2] = sc_snap(p.z);
  }
  rtrt_normals(m, positions, normals);
}

/* >>surfaces ------------------------------------------------------------------------------------------------------- */

/* An ellipsoid (centre and half axes in p), or a hose along a Bezier curve (p) from radius r0 to r1. */
typedef struct rtrt_blob {
  sc_v3 p[4], middle;
  double r0, r1, blend, bound; /* blend: the distance within which it melts into others; it lies within the bound */
  bool hose;
} rtrt_blob;

typedef struct rtrt_field { /* a smooth union, perhaps cut flat: nothing is left beyond the plane */
  rtrt_blob blob[32];
  uint32_t n;
  bool cut;
  sc_v3 cut_at, cut_normal;
} rtrt_field;

static rtrt_blob *rtrt_blob_new(rtrt_field *g, double blend) {
  rtrt_blob *b = &g->blob[g->n < SC_COUNT(g->blob) - 1 ? g->n++ : g->n];
  memset(b, 0, sizeof *b);
  b->blend = blend;
  return b;
}

static void rtrt_ball(
    rtrt_field *g, const sc_frame *f, double x, double y, double z, double rx, double ry, double rz, double blend) {
  rtrt_blob *b = rtrt_blob_new(g, blend);
  double l;
  uint32_t i;
  b->p[0] = b->middle = rtrt_at(f, x, y, z);
  b->p[1] = sc_mul(f->x, rx), b->p[2] = sc_mul(f->y, ry), b->p[3] = sc_mul(f->z, rz);
  for (i = 1; i < 4; i++) {
    l = rtrt_length(b->p[i]);
    if (l > b->bound) b->bound = l;
  }
}

static void rtrt_hose(rtrt_field *g, const sc_v3 *p, double r0, double r1, double blend) {
  rtrt_blob *b = rtrt_blob_new(g, blend);
  uint32_t i;
  b->hose = true, b->r0 = r0, b->r1 = r1;
  for (i = 0; i < 4; i++) b->p[i] = p[i], b->middle = sc_add(b->middle, sc_mul(p[i], 0.25));
  for (i = 0; i < 4; i++) {
    double l = rtrt_length(sc_sub(p[i], b->middle));
    if (l > b->bound) b->bound = l;
  }
  b->bound += r0 > r1 ? r0 : r1;
}

/* A straight hose, from and to given in a frame. */
static void rtrt_rod(rtrt_field *g, const sc_frame *f, sc_v3 from, sc_v3 to, double r0, double r1, double blend) {
  sc_v3 p[4];
  uint32_t i;
  for (i = 0; i < 4; i++) {
    sc_v3 q = sc_add(from, sc_mul(sc_sub(to, from), i / 3.0));
    p[i] = rtrt_at(f, q.x, q.y, q.z);
  }
  rtrt_hose(g, p, r0, r1, blend);
}

/* Distance to a blob, near it; from far away too short. Ellipsoid: level over slope. Hose: Newton's method finds the
   nearest point of the curve, from the best of nine. */
static double rtrt_blob_distance(const rtrt_blob *b, sc_v3 at) {
  sc_v3 d = sc_sub(at, b->p[0]);
  double best = 0.0, t = 0.0;
  uint32_t i;
  if (!b->hose) {
    double level = 0.0, slope = 0.0;
    for (i = 1; i < 4; i++) {
      double l2 = sc_dot(b->p[i], b->p[i]), q = sc_dot(d, b->p[i]) / l2;
      level += q * q, slope += q * q / l2;
    }
    level = sqrt(level), slope = sqrt(slope);
    return slope > 0.0 ? level * (level - 1.0) / slope : -0.5 * b->bound;
  }
  for (i = 0; i <= 8; i++) {
    sc_v3 e = sc_sub(at, rtrt_bezier(b->p, i / 8.0));
    double l = sc_dot(e, e);
    if (i == 0 || l < best) best = l, t = i / 8.0;
  }
  for (i = 0; i < 3; i++) {
    sc_v3 e = sc_sub(at, rtrt_bezier(b->p, t)), v = rtrt_slope(b->p, t);
    t += sc_dot(e, v) / sc_dot(v, v);
    t = t < 0.0 ? 0.0 : t > 1.0 ? 1.0 : t;
  }
  return rtrt_length(sc_sub(at, rtrt_bezier(b->p, t))) - (b->r0 + (b->r1 - b->r0) * t);
}

/* Smooth minimum: cubic where the two differ by less than k. */
static double rtrt_melt(double a, double b, double k) {
  double d = a > b ? a - b : b - a, h = d < k ? (k - d) / k : 0.0;
  return (a < b ? a : b) - h * h * h * k / 6.0;
}

static double rtrt_distance(const rtrt_field *g, sc_v3 p) {
  double d = 1e9;
  uint32_t i;
  for (i = 0; i < g->n; i++) {
    const rtrt_blob *b = &g->blob[i];
    double far = rtrt_length(sc_sub(p, b->middle)) - b->bound;
    if (far < d + b->blend) d = rtrt_melt(d, rtrt_blob_distance(b, p), b->blend);
  }
  return g->cut ? -rtrt_melt(-d, -sc_dot(sc_sub(p, g->cut_at), g->cut_normal), 0.02) : d;
}

/* >>grid ----------------------------------------------------------------------------------------------------------- */

typedef struct rtrt_grid {
  const rtrt_field *field;
  sc_v3 low;
  double step;
  uint32_t n[3], *vertex; /* points along each axis; the vertex of the cell above each point */
  float *value;
} rtrt_grid;

static size_t rtrt_index(const rtrt_grid *g, uint32_t i, uint32_t j, uint32_t k) {
  return ((size_t)k * g->n[1] + j) * g->n[0] + i;
}
static sc_v3 rtrt_point(const rtrt_grid *g, double i, double j, double k) {
  return sc_v(g->low.x + i * g->step, g->low.y + j * g->step, g->low.z + k * g->step);
}

/* Values at the points of a block of 8 x 8 x 8, or only a sign where the surface is too far away to matter. */
static void rtrt_grid_block(rtrt_grid *g, uint32_t i0, uint32_t j0, uint32_t k0) {
  double middle = rtrt_distance(g->field, rtrt_point(g, i0 + 3.5, j0 + 3.5, k0 + 3.5));
  bool far = middle * middle > 100.0 * g->step * g->step;
  uint32_t i, j, k;
  for (k = k0; k < k0 + 8 && k < g->n[2]; k++)
    for (j = j0; j < j0 + 8 && j < g->n[1]; j++)
      for (i = i0; i < i0 + 8 && i < g->n[0]; i++)
        g->value[rtrt_index(g, i, j, k)] = (float)(far ? middle : rtrt_distance(g->field, rtrt_point(g, i, j, k)));
}

/* From a point near the surface onto it, along the gradient. */
static sc_v3 rtrt_project(const rtrt_field *f, sc_v3 p) {
  double e = 1e-4, d, x, y, z, l;
  uint32_t i;
  for (i = 0; i < 2; i++) {
    d = rtrt_distance(f, p);
    x = (rtrt_distance(f, sc_v(p.x + e, p.y, p.z)) - d) / e, y = (rtrt_distance(f, sc_v(p.x, p.y + e, p.z)) - d) / e;
    z = (rtrt_distance(f, sc_v(p.x, p.y, p.z + e)) - d) / e;
    l = x * x + y * y + z * z;
    if (l > 0.1) p = sc_sub(p, sc_mul(sc_v(x, y, z), d / l));
  }
  return p;
}

/* The vertex of a cell that the surface crosses: the mean of where it crosses the cell's edges, put on the surface. */
static void rtrt_grid_cell(sc_build *b, rtrt_grid *g, uint32_t i, uint32_t j, uint32_t k) {
  sc_v3 sum = sc_v(0.0, 0.0, 0.0);
  double v[8], crossings = 0.0;
  uint32_t c, axis;
  for (c = 0; c < 8; c++) v[c] = (double)g->value[rtrt_index(g, i + (c & 1), j + (c >> 1 & 1), k + (c >> 2))];
  for (c = 0; c < 8; c++)
    for (axis = 0; axis < 3; axis++) {
      uint32_t bit = 1u << axis, d = c | bit;
      double t;
      if (c & bit || (v[c] < 0.0) == (v[d] < 0.0)) continue;
      t = v[c] / (v[c] - v[d]);
      sum = sc_add(sum, sc_v((c & 1) + (axis == 0 ? t : 0.0), (c >> 1 & 1) + (axis == 1 ? t : 0.0),
                            (c >> 2) + (axis == 2 ? t : 0.0)));
      crossings += 1.0;
    }
  if (crossings == 0.0) return;
  sum = sc_mul(sum, 1.0 / crossings);
  sum = rtrt_project(g->field, rtrt_point(g, i + sum.x, j + sum.y, k + sum.z));
  g->vertex[rtrt_index(g, i, j, k)] = sc_vertex(b, sum, sc_v(0.0, 1.0, 0.0));
}

/* Two triangles, along the shorter diagonal. */
static void rtrt_grid_quad(sc_build *b, uint32_t p, uint32_t q, uint32_t r, uint32_t s) {
  const float *at = b->mesh->positions;
  sc_v3 d = sc_sub(sc_get(at, r), sc_get(at, p)), e = sc_sub(sc_get(at, s), sc_get(at, q));
  bool pr = sc_dot(d, d) < 1.000001 * sc_dot(e, e);
  sc_triangle(b, p, q, pr ? r : s);
  sc_triangle(b, pr ? p : q, r, s);
}

/* Around each edge of the grid that the surface crosses, its four cells' vertices make a quadrilateral. */
static void rtrt_grid_edges(sc_build *b, const rtrt_grid *g, uint32_t i, uint32_t j, uint32_t k) {
  size_t at = rtrt_index(g, i, j, k), one[3];
  uint32_t axis;
  bool in = g->value[at] < 0.0f;
  one[0] = 1, one[1] = g->n[0], one[2] = (size_t)g->n[0] * g->n[1];
  for (axis = 0; axis < 3; axis++) {
    size_t u = one[(axis + 1) % 3], w = one[(axis + 2) % 3];
    uint32_t p, q, r, s;
    if (in == (g->value[at + one[axis]] < 0.0f)) continue;
    p = g->vertex[at - u - w], q = g->vertex[at - w], r = g->vertex[at], s = g->vertex[at - u];
    if (in) rtrt_grid_quad(b, p, q, r, s);
    else rtrt_grid_quad(b, s, r, q, p);
  }
}

static void rtrt_grid_mesh(sc_build *b, rtrt_grid *g) {
  sc_mark mark = sc_begin(b);
  uint32_t i, j, k;
  for (k = 0; k < g->n[2]; k += 8)
    for (j = 0; j < g->n[1]; j += 8)
      for (i = 0; i < g->n[0]; i += 8) rtrt_grid_block(g, i, j, k);
  for (k = 0; k + 1 < g->n[2]; k++)
    for (j = 0; j + 1 < g->n[1]; j++)
      for (i = 0; i + 1 < g->n[0]; i++) rtrt_grid_cell(b, g, i, j, k);
  for (k = 1; k + 1 < g->n[2] && !b->failed; k++)
    for (j = 1; j + 1 < g->n[1]; j++)
      for (i = 1; i + 1 < g->n[0]; i++) rtrt_grid_edges(b, g, i, j, k);
  sc_smooth(b, mark);
}

/* Adds the surface of a field to the mesh, with triangles of about the given size. */
static void rtrt_surface(sc_build *b, const rtrt_field *f, double step) {
  sc_v3 low = sc_v(1e9, 1e9, 1e9), high = sc_v(-1e9, -1e9, -1e9);
  rtrt_grid g;
  size_t points;
  uint32_t i;
  for (i = 0; i < f->n; i++) {
    const rtrt_blob *o = &f->blob[i];
    double r = o->bound + 0.2 * o->blend + 3.0 * step;
    sc_v3 p = sc_sub(o->middle, sc_v(r, r, r)), q = sc_add(o->middle, sc_v(r, r, r));
    low = sc_v(p.x < low.x ? p.x : low.x, p.y < low.y ? p.y : low.y, p.z < low.z ? p.z : low.z);
    high = sc_v(q.x > high.x ? q.x : high.x, q.y > high.y ? q.y : high.y, q.z > high.z ? q.z : high.z);
  }
  g.field = f, g.low = low, g.step = step;
  g.n[0] = (uint32_t)((high.x - low.x) / step), g.n[1] = (uint32_t)((high.y - low.y) / step);
  g.n[2] = (uint32_t)((high.z - low.z) / step);
  points = (size_t)g.n[0] * g.n[1] * g.n[2];
  g.value = (float *)malloc(points * sizeof(float));
  g.vertex = (uint32_t *)malloc(points * sizeof(uint32_t));
  if (!g.value || !g.vertex) b->failed = true;
  else rtrt_grid_mesh(b, &g);
  free(g.value);
  free(g.vertex);
}

/* >>faces ---------------------------------------------------------------------------------------------------------- */

/* A closed ellipsoid: the unit sphere in a frame. */
static void rtrt_globe(sc_build *b, const sc_frame *f, uint32_t rows, uint32_t segments) {
  sc_mark mark = sc_begin(b);
  sc_frame keep = b->at;
  b->at = *f;
  sc_sphere_band(b, 1.0, 0.0, 180.0, rows, segments);
  b->at = keep;
  sc_smooth(b, mark);
}

/* Directions from the middle of an ellipsoid (a frame with its half axes): z of the result points x degrees to its left
   and y degrees up. */
static sc_frame rtrt_aim(double x, double y) {
  sc_frame f;
  f.z = sc_v(sc_sin(x) * sc_cos(y), sc_sin(y), sc_cos(x) * sc_cos(y));
  f.x = sc_v(sc_cos(x), 0.0, -sc_sin(x));
  f.y = sc_cross(f.z, f.x);
  f.o = sc_v(0.0, 0.0, 0.0);
  return f;
}

/* The point of an ellipsoid that lies x and y degrees beside an aim, lifted a little. */
static sc_v3 rtrt_spot(const sc_frame *ball, const sc_frame *aim, double x, double y, double lift) {
  double angle = sqrt(x * x + y * y), s = angle > 0.0 ? sc_sin(angle) / angle : 0.0;
  sc_v3 d = sc_mul(rtrt_at(aim, s * x, s * y, sc_cos(angle)), 1.0 + lift);
  return rtrt_at(ball, d.x, d.y, d.z);
}

/* A patch on an ellipsoid: an outline in degrees, seen from outside against the clock, star-shaped around (cx, cy). It
   bulges by `lift`; its rim stays above the surface, whose facets would nibble at it. */
static void rtrt_patch(sc_build *b, const sc_frame *ball, const sc_frame *aim, const sc_pt *p, uint32_t n, double cx,
    double cy, double lift, uint32_t rows) {
  sc_mark mark = sc_begin(b);
  uint32_t i, j, before = sc_vertex(b, rtrt_spot(ball, aim, cx, cy, lift), sc_v(0, 1, 0)), row;
  for (j = 1; j <= rows; j++, before = row) {
    double u = (double)j / rows, l = lift * (1.0 - 0.55 * u * u * u * u);
    row = sc_begin(b).vertex;
    for (i = 0; i < n; i++)
      sc_vertex(b, rtrt_spot(ball, aim, cx + u * (p[i].x - cx), cy + u * (p[i].y - cy), l), sc_v(0, 1, 0));
    for (i = 0; i < n; i++) {
      uint32_t k = (i + 1) % n;
      sc_triangle(b, before + (j > 1 ? i : 0), row + i, row + k);
      if (j > 1) sc_triangle(b, before + i, row + k, before + k);
    }
  }
  sc_smooth(b, mark);
}

static void rtrt_disc(sc_build *b, const sc_frame *ball, double x, double y, double rx, double ry, double lift) {
  sc_frame aim = rtrt_aim(x, y);
  sc_pt p[20];
  uint32_t i;
  for (i = 0; i < SC_COUNT(p); i++) p[i].x = rx * sc_cos(18.0 * i), p[i].y = ry * sc_sin(18.0 * i), p[i].corner = 0;
  rtrt_patch(b, ball, &aim, p, SC_COUNT(p), 0.0, 0.0, lift, 3);
}

typedef struct rtrt_face { /* angles on the head in degrees, half axes relative to size */
  double eye[2], eye_size[3], gaze[2], pupil;
  uint32_t eyes;
  double mouth[2], smile; /* how far down, half its width; how far its corners are up */
  double open;            /* 0: a line */
  double brow[3];         /* height above the eye, half its width, tilt; no width: none */
  double iris;            /* 0: none */
  double lid;             /* degrees by which the eyelids come down */
  bool bright;            /* a white mouth, on a visor */
} rtrt_face;

static const rtrt_face rtrt_faces[RTRT_ACTORS] = {
    {{21, 12}, {0.068, 0.092, 0.050}, {0, 4}, 32, 2, {-20, 32}, 9, 22, {24, 9, -8}, 0, 0, false},
    {{21, 6}, {0.062, 0.078, 0.045}, {6, 4}, 32, 2, {-25, 22}, 7, 0, {0, 0, 0}, 0, 0, true},
    {{23, 0}, {0.058, 0.078, 0.045}, {-6, 4}, 34, 2, {-27, 18}, 6, 12, {26, 8, -6}, 0, 0, false},
    {{20, 18}, {0.056, 0.070, 0.042}, {0, 2}, 36, 2, {-28, 17}, 6, 0, {22, 9, -6}, 0, 0, false},
    {{0, 14}, {0.125, 0.125, 0.085}, {-4, -6}, 24, 1, {-24, 34}, 8, 14, {0, 0, 0}, 40, 22, false},
    {{32, 42}, {0.082, 0.088, 0.070}, {-6, -24}, 30, 2, {-8, 46}, 12, 16, {0, 0, 0}, 0, 0, false}};

/* What is painted on an eyeball: iris, pupil, highlight. Both eyes look the same way, as far as that is possible. */
static void rtrt_pupil(sc_build *b, uint32_t kind, const rtrt_face *f, const sc_frame *eye, double side) {
  double x = f->gaze[0] - side * 0.85 * f->eye[0], y = f->gaze[1];
  if (f->iris > 0.0) {
    sc_use(b, kind + RTRT_IRIS);
    rtrt_disc(b, eye, x, y, f->iris, f->iris, 0.03);
  }
  sc_use(b, kind + RTRT_BLACK);
  rtrt_disc(b, eye, x, y, f->pupil, f->pupil, f->iris > 0.0 ? 0.055 : 0.04);
  sc_use(b, kind + RTRT_WHITE);
  rtrt_disc(b, eye, x - 11.0, y + 12.0, 9.0, 9.0, 0.07);
}

/* Eyeball on the head, its z outwards; then eyelid and brow. */
static void rtrt_eye(
    sc_build *b, uint32_t kind, const rtrt_actor *a, const rtrt_face *f, const sc_frame *head, double side) {
  sc_frame aim = rtrt_aim(side * f->eye[0], f->eye[1]), eye, lid;
  sc_v3 p[5];
  int i;
  eye.z = sc_unit(rtrt_along(head, aim.z.x / sc_dot(head->x, head->x), aim.z.y / sc_dot(head->y, head->y),
      aim.z.z / sc_dot(head->z, head->z)));
  eye.x = sc_unit(sc_cross(head->y, eye.z));
  eye.y = sc_cross(eye.z, eye.x);
  eye.o = rtrt_spot(head, &aim, 0.0, 0.0, 0.0);
  eye = rtrt_scaled(&eye, f->eye_size[0] * a->size, f->eye_size[1] * a->size, f->eye_size[2] * a->size);
  sc_use(b, kind + RTRT_WHITE);
  rtrt_globe(b, &eye, 10, 20);
  rtrt_pupil(b, kind, f, &eye, side);
  if (f->lid > 0.0) {
    lid = rtrt_scaled(&eye, 1.08, 1.08, 1.08);
    sc_use(b, kind + RTRT_BODY);
    rtrt_disc(b, &lid, 0.0, 96.0 - f->lid, 60.0, 60.0, 0.02);
  }
  if (f->brow[1] > 0.0) {
    for (i = -2; i <= 2; i++)
      p[i + 2] =
          rtrt_spot(head, &aim, 0.5 * f->brow[1] * i, f->brow[0] - 0.875 * i * i + 0.2 * side * i * f->brow[2], 0.03);
    sc_use(b, kind + RTRT_BLACK);
    sc_tube(b, p, 5, 2, false, 0.013 * a->size, 0.013 * a->size, 10);
  }
}

/* A line, or an open mouth with a tongue: a parabola above, from which half an ellipse hangs. */
static void rtrt_mouth(sc_build *b, uint32_t kind, const rtrt_actor *a, const rtrt_face *f, const sc_frame *head) {
  sc_frame aim = rtrt_aim(0.0, f->mouth[0]);
  sc_pt p[32];
  sc_v3 line[13];
  uint32_t i;
  sc_use(b, kind + (f->bright ? RTRT_WHITE : RTRT_BLACK));
  for (i = 0; i < 32; i++) {
    double u = sc_cos(11.25 * (i + 0.5)), s = sc_sin(11.25 * (i + 0.5)), top = f->smile * u * u;
    p[i].x = f->mouth[1] * u, p[i].y = s > 0.0 ? top : top + f->open * s, p[i].corner = 0;
  }
  if (f->open > 0.0) {
    rtrt_patch(b, head, &aim, p, 32, 0.0, -0.45 * f->open, 0.02, 5);
    for (i = 0; i < 32; i++) {
      double u = sc_cos(11.25 * i), s = sc_sin(11.25 * i);
      p[i].x = 0.55 * f->mouth[1] * u, p[i].y = (s > 0.0 ? 0.28 : 0.24) * f->open * s - 0.68 * f->open;
    }
    sc_use(b, kind + RTRT_PINK);
    rtrt_patch(b, head, &aim, p, 32, 0.0, -0.66 * f->open, 0.035, 3);
  } else {
    for (i = 0; i < 13; i++) {
      double u = (i - 6.0) / 6.0;
      line[i] = rtrt_spot(head, &aim, f->mouth[1] * u, f->smile * u * u, f->bright ? 0.03 : 0.01);
    }
    sc_tube(b, line, 13, 1, false, 0.012 * a->size, 0.012 * a->size, 10);
  }
}

static void rtrt_head(sc_build *b, uint32_t kind, const rtrt_actor *a, const rtrt_face *f, const rtrt_rig *r) {
  sc_frame head = rtrt_scaled(&r->at[RTRT_HEAD], a->head[0], a->head[1], a->head[2]);
  uint32_t i;
  for (i = 0; i < f->eyes; i++) rtrt_eye(b, kind, a, f, &head, f->eyes == 1 ? 0.0 : i ? -1.0 : 1.0);
  rtrt_mouth(b, kind, a, f, &head);
}

/* >>bodies --------------------------------------------------------------------------------------------------------- */

static void rtrt_trunk(rtrt_field *g, const rtrt_actor *a, const rtrt_rig *r) {
  double s = a->size;
  uint32_t i;
  g->n = 0, g->cut = false;
  rtrt_ball(g, &r->at[RTRT_BELLY], 0, 0, 0, a->belly[0], a->belly[1], a->belly[2], a->melt * s);
  rtrt_ball(g, &r->at[RTRT_HEAD], 0, 0, 0, a->head[0], a->head[1], a->head[2], a->melt * s);
  for (i = 0; i < 2; i++) {
    rtrt_hose(g, r->curve[i], 1.15 * a->arm * s, 0.9 * a->arm * s, 0.05 * s);
    rtrt_hose(g, r->curve[2 + i], 1.15 * a->leg * s, 0.9 * a->leg * s, 0.05 * s);
  }
}

/* A hand in its frame: fingers along y, the thumb towards the body. */
static void rtrt_hand(rtrt_field *g, const rtrt_actor *a, const rtrt_rig *r, uint32_t side, double fat) {
  const sc_frame *f = &r->at[RTRT_SPINE + (side + 1) * RTRT_LIMB - 1];
  double in = side ? 1.0 : -1.0, s = rtrt_length(f->y), k = 0.022 * s, cuff = 0.9 * a->arm + 0.016;
  int i;
  rtrt_ball(g, f, 0, 0, 0, 0.052 * fat, 0.056 * fat, 0.040 * fat, k);
  rtrt_rod(g, f, sc_v(0.035 * in, -0.01, 0), sc_v(0.078 * in * fat, 0.040 * fat, 0.012), 0.022 * fat * s,
      0.020 * fat * s, k);
  for (i = -1; i <= 1; i++)
    rtrt_rod(g, f, sc_v(0.028 * i, 0.03, 0), sc_v(0.047 * i * fat, (i ? 0.098 : 0.112) * fat, 0.008), 0.021 * fat * s,
        0.020 * fat * s, 0.014 * s);
  rtrt_ball(g, f, 0, -0.058, 0, cuff, 0.018, cuff, 0.008 * s);
}

static void rtrt_shoe(rtrt_field *g, const rtrt_rig *r, uint32_t side, double fat) {
  const sc_frame *f = &r->at[RTRT_SPINE + (side + 3) * RTRT_LIMB - 1];
  double s = rtrt_length(f->y);
  rtrt_ball(g, f, 0, -0.035, 0.085 * fat, 0.074 * fat, 0.062, 0.095 * fat, 0.05 * s);
  rtrt_ball(g, f, 0, -0.035, -0.010, 0.060 * fat, 0.070, 0.068 * fat, 0.05 * s);
  g->cut = true;
  g->cut_at = rtrt_at(f, 0.0, -0.085, 0.0), g->cut_normal = sc_mul(f->y, -1.0 / s);
}

static void rtrt_extremities(sc_build *b, uint32_t kind, const rtrt_actor *a, const rtrt_rig *r) {
  rtrt_field g;
  uint32_t i;
  for (i = 0; i < 2; i++) {
    memset(&g, 0, sizeof g);
    rtrt_hand(&g, a, r, i, 1.15);
    sc_use(b, kind + RTRT_GLOVES);
    rtrt_surface(b, &g, 0.0184 * a->mesh * a->size);
    memset(&g, 0, sizeof g);
    rtrt_shoe(&g, r, i, 1.1);
    sc_use(b, kind + RTRT_SHOES);
    rtrt_surface(b, &g, 0.024 * a->mesh * a->size);
  }
}

/* A thin thing on the head: a hose in the head's frame with a ball on its end. */
static void rtrt_stalk(rtrt_field *g, const rtrt_rig *r, sc_v3 p0, sc_v3 p1, sc_v3 p2, double thick, double ball) {
  const sc_frame *f = &r->at[RTRT_HEAD];
  double s = rtrt_length(f->x);
  sc_v3 p[4];
  p[0] = rtrt_at(f, p0.x, p0.y, p0.z), p[1] = p[2] = rtrt_at(f, p1.x, p1.y, p1.z), p[3] = rtrt_at(f, p2.x, p2.y, p2.z);
  rtrt_hose(g, p, thick * s, (ball > 0.0 ? 0.8 : 0.35) * thick * s, 0.03 * s);
  if (ball > 0.0) rtrt_ball(g, f, p2.x, p2.y, p2.z, ball, ball, ball, 0.01 * s);
}

static void rtrt_imp(sc_build *b, uint32_t kind, const rtrt_actor *a, const rtrt_rig *r, rtrt_field *body) {
  rtrt_field g;
  int i;
  (void)body;
  for (i = -1; i <= 1; i += 2) {
    memset(&g, 0, sizeof g);
    rtrt_stalk(&g, r, sc_v(0.10 * i, 0.20, 0), sc_v(0.13 * i, 0.40, 0.0), sc_v(0.24 * i, 0.42, 0.03), 0.017, 0.052);
    sc_use(b, kind + RTRT_TRIM);
    rtrt_surface(b, &g, 0.019 * a->size);
  }
}

static void rtrt_robot(sc_build *b, uint32_t kind, const rtrt_actor *a, const rtrt_rig *r, rtrt_field *body) {
  const sc_frame *f = &r->at[RTRT_HEAD];
  sc_frame head = rtrt_scaled(f, a->head[0], a->head[1], a->head[2]);
  rtrt_field g;
  int i;
  (void)body;
  sc_use(b, kind + RTRT_BLACK); /* visor */
  rtrt_disc(b, &head, 0, -2, 56, 44, 0.025);
  sc_use(b, kind + RTRT_TRIM);
  for (i = -1; i <= 1; i += 2) {
    sc_frame ear = *f;
    ear.o = rtrt_at(f, 0.285 * i, 0, 0);
    ear = rtrt_scaled(&ear, 0.045, 0.085, 0.085);
    rtrt_globe(b, &ear, 10, 20);
    ear.o = rtrt_at(f, 0.335 * i, 0, 0);
    ear = rtrt_scaled(&ear, 0.8, 0.4, 0.4);
    rtrt_globe(b, &ear, 7, 14);
  }
  memset(&g, 0, sizeof g);
  rtrt_stalk(&g, r, sc_v(0, 0.20, 0), sc_v(0, 0.27, 0), sc_v(0, 0.34, 0), 0.018, 0.048);
  rtrt_surface(b, &g, 0.019 * a->size);
}

static void rtrt_drop(sc_build *b, uint32_t kind, const rtrt_actor *a, const rtrt_rig *r, rtrt_field *body) {
  const sc_frame *f = &r->at[RTRT_HEAD];
  sc_frame head = rtrt_scaled(f, a->head[0], a->head[1], a->head[2]);
  uint32_t i;
  sc_v3 p[4];
  p[0] = rtrt_at(f, 0, 0.08, 0), p[1] = rtrt_at(f, 0, 0.26, 0), p[2] = rtrt_at(f, -0.01, 0.34, 0);
  p[3] = rtrt_at(f, 0.08, 0.40, 0);
  rtrt_hose(body, p, 0.165 * a->size, 0.030 * a->size, 0.12 * a->size);
  for (i = 0; i < 2; i++) {
    sc_use(b, kind + RTRT_PINK);
    rtrt_disc(b, &head, i ? -44 : 44, -18, 8, 6, 0.02);
  }
}

static void rtrt_bear(sc_build *b, uint32_t kind, const rtrt_actor *a, const rtrt_rig *r, rtrt_field *body) {
  const sc_frame *f = &r->at[RTRT_HEAD];
  sc_frame nose;
  rtrt_field g;
  int i;
  for (i = -1; i <= 1; i += 2) {
    sc_frame ear = *f;
    ear.o = rtrt_at(f, 0.19 * i, 0.19, 0);
    rtrt_ball(body, &ear, 0, 0, 0, 0.095, 0.095, 0.06, 0.04 * a->size);
    ear = rtrt_scaled(&ear, 0.095, 0.095, 0.06);
    sc_use(b, kind + RTRT_TRIM);
    rtrt_disc(b, &ear, 8.0 * i, 6, 42, 42, 0.06);
  }
  memset(&g, 0, sizeof g);
  rtrt_ball(&g, f, 0, -0.075, 0.19, 0.115, 0.085, 0.085, 0.02);
  sc_use(b, kind + RTRT_TRIM);
  rtrt_surface(b, &g, 0.026 * a->size);
  nose = *f;
  nose.o = rtrt_at(f, 0, -0.035, 0.265);
  nose = rtrt_scaled(&nose, 0.042, 0.030, 0.030);
  sc_use(b, kind + RTRT_BLACK);
  rtrt_globe(b, &nose, 8, 16);
}

static void rtrt_cyclops(sc_build *b, uint32_t kind, const rtrt_actor *a, const rtrt_rig *r, rtrt_field *body) {
  rtrt_field g;
  int i;
  (void)body;
  for (i = -1; i <= 1; i += 2) {
    memset(&g, 0, sizeof g);
    rtrt_stalk(&g, r, sc_v(0.13 * i, 0.17, 0), sc_v(0.27 * i, 0.22, 0), sc_v(0.27 * i, 0.38, 0.03), 0.058, 0.0);
    sc_use(b, kind + RTRT_TRIM);
    rtrt_surface(b, &g, 0.024 * a->mesh * a->size);
  }
}

static void rtrt_frog(sc_build *b, uint32_t kind, const rtrt_actor *a, const rtrt_rig *r, rtrt_field *body) {
  sc_frame belly = rtrt_scaled(&r->at[RTRT_BELLY], a->belly[0], a->belly[1], a->belly[2]);
  sc_frame head = rtrt_scaled(&r->at[RTRT_HEAD], a->head[0], a->head[1], a->head[2]);
  int i;
  for (i = -1; i <= 1; i += 2) {
    sc_frame aim = rtrt_aim(i * rtrt_faces[RTRT_FROG].eye[0], rtrt_faces[RTRT_FROG].eye[1]), eye = r->at[RTRT_HEAD];
    eye.o = rtrt_spot(&head, &aim, 0, 0, -0.14);
    rtrt_ball(body, &eye, 0, 0.0, -0.015, 0.098, 0.10, 0.09, 0.05 * a->size);
  }
  sc_use(b, kind + RTRT_TRIM);
  rtrt_disc(b, &belly, 0.0, -6.0, 44.0, 46.0, 0.025);
}

static void rtrt_character(sc_build *b, uint32_t who) {
  static void (*const own[RTRT_ACTORS])(sc_build *, uint32_t, const rtrt_actor *, const rtrt_rig *, rtrt_field *) = {
      rtrt_imp, rtrt_robot, rtrt_drop, rtrt_bear, rtrt_cyclops, rtrt_frog};
  const rtrt_actor *a = &rtrt_cast[who];
  uint32_t kind = rtrt_look(who);
  rtrt_field body;
  rtrt_rig rig;
  memset(&body, 0, sizeof body);
  rtrt_pose(a, 0.0, &rig);
  rtrt_trunk(&body, a, &rig);
  own[who](b, kind, a, &rig, &body);
  sc_use(b, kind + RTRT_BODY);
  rtrt_surface(b, &body, 0.032 * a->mesh * a->size);
  rtrt_head(b, kind, a, &rtrt_faces[who], &rig);
  rtrt_extremities(b, kind, a, &rig);
}

/* >>stage ---------------------------------------------------------------------------------------------------------- */

static void rtrt_ground(sc_build *b) {
  static const double low[][3] = {{1900, 0, 1}, {1900, 190}, {1894, 205}, {1880, 211, 1}, {0, 211, 1}};
  static const double high[][3] = {{1100, 200, 1}, {1100, 400}, {1094, 415}, {1080, 421, 1}, {0, 421, 1}};
  sc_frame keep;
  uint32_t i;
  sc_use(b, RTRT_FLOOR);
  sc_quad(b, sc_v(-9, 0, 9), sc_v(9, 0, 9), sc_v(9, 0, -9), sc_v(-9, 0, -9));
  keep = sc_place(b, 0.0, 0.0, -1.75, 0.0);
  sc_use(b, RTRT_RISER);
  SC_LATHE(b, 112, low, 1);
  sc_place(b, 0.0, 0.0, -0.55, 0.0);
  SC_LATHE(b, 72, high, 1);
  b->at = keep;
  sc_place(b, 0.0, 0.0, -1.75, 0.0);
  sc_use(b, RTRT_GILT);
  sc_torus(b, 0.012, 1.905, 0.012, 80, 5);
  for (i = 0; i < 27; i++) {
    double angle = 90.0 + 6.2 * (i - 13.0);
    sc_frame inner = sc_place(b, 1.905 * sc_cos(angle), 0.105, 1.905 * sc_sin(angle), 0.0);
    sc_use(b, RTRT_BULBS);
    sc_sphere_band(b, 0.020, 0.0, 180.0, 5, 8);
    b->at = inner;
  }
  b->at = keep;
}

/* Curtain: pleats on an arc, deeper towards the floor. */
static void rtrt_curtain(sc_build *b) {
  uint32_t i, j, n = 500, rows = 1;
  sc_mark mark;
  sc_use(b, RTRT_CURTAIN);
  mark = sc_begin(b);
  for (i = 0; i <= n; i++)
    for (j = 0; j <= rows; j++) {
      double angle = 180.0 + 180.0 * i / n, v = (double)j / rows, deep = 0.085 - 0.03 * v;
      double fold = deep * sc_sin(100.0 * angle + 120.0 * sc_sin(7.0 * angle)) + 0.05 * sc_sin(7.3 * angle + 60.0 * v);
      double x = (4.4 + fold) * sc_cos(angle), z = (3.3 + 0.75 * fold) * sc_sin(angle) - 0.2;
      sc_vertex(b, sc_v(x, 5.6 * v, z), sc_v(0, 0, 1));
    }
  for (i = 0; i < n; i++)
    for (j = 0; j < rows; j++) {
      uint32_t p = mark.vertex + i * (rows + 1) + j, q = p + rows + 1;
      sc_triangle(b, p, q, q + 1);
      sc_triangle(b, p, q + 1, p + 1);
    }
  sc_smooth(b, mark);
}

/* Letters like balloons, half a metre high, in their own frames; they hang from threads. */
static void rtrt_letter(sc_build *b, double x, double y, double z, double yaw, bool r) {
  sc_frame f = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  double thick = 0.066, k = 0.03;
  rtrt_field g;
  memset(&g, 0, sizeof g);
  f = rtrt_turned(&f, yaw, 0.0, 0.0);
  f.o = sc_v(x, y, z);
  if (r) {
    sc_v3 p[4];
    rtrt_rod(&g, &f, sc_v(-0.14, 0.0, 0), sc_v(-0.14, 0.46, 0), thick, thick, k);
    p[0] = rtrt_at(&f, -0.14, 0.46, 0), p[1] = rtrt_at(&f, 0.25, 0.50, 0), p[2] = rtrt_at(&f, 0.25, 0.17, 0);
    p[3] = rtrt_at(&f, -0.13, 0.21, 0);
    rtrt_hose(&g, p, thick, thick, k);
    rtrt_rod(&g, &f, sc_v(0.0, 0.20, 0), sc_v(0.16, 0.0, 0), thick, thick, k);
  } else {
    rtrt_rod(&g, &f, sc_v(0.0, 0.0, 0), sc_v(0.0, 0.45, 0), thick, thick, k);
    rtrt_rod(&g, &f, sc_v(-0.18, 0.46, 0), sc_v(0.18, 0.46, 0), thick, thick, k);
  }
  sc_use(b, RTRT_LETTERS);
  rtrt_surface(b, &g, 0.041);
  sc_use(b, RTRT_GILT);
  sc_rod(b, sc_v(x, y + 0.5, z), sc_v(x, 6.0, z), 0.004, 6);
}

/* Facets of glass on a ball, which hangs from a rod. */
static void rtrt_mirror_ball(sc_build *b, double x, double y, double z, double radius) {
  uint32_t i, j, k, rows = 18, columns = 36;
  sc_frame keep = sc_place(b, x, y, z, 7.0);
  sc_use(b, RTRT_GILT);
  sc_sphere_band(b, 0.985 * radius, 0.0, 180.0, 10, 20);
  sc_rod(b, sc_v(0, 0.97 * radius, 0), sc_v(0, 4.0, 0), 0.012, 8);
  sc_use(b, RTRT_FACETS);
  for (j = 0; j < rows; j++)
    for (i = 0; i < columns; i++) {
      sc_v3 p[4], middle = sc_v(0, 0, 0);
      for (k = 0; k < 4; k++) {
        double up = 90.0 - 180.0 * (j + (k < 2 ? 1 : 0)) / rows;
        double a = -360.0 * (i + (k == 1 || k == 2 ? 1 : 0)) / columns;
        p[k] = sc_v(radius * sc_cos(up) * sc_cos(a), radius * sc_sin(up), radius * sc_cos(up) * sc_sin(a));
        middle = sc_add(middle, sc_mul(p[k], 0.25));
      }
      for (k = 0; k < 4; k++) p[k] = sc_add(middle, sc_mul(sc_sub(p[k], middle), 0.93));
      sc_quad(b, p[0], p[1], p[2], p[3]);
    }
  b->at = keep;
}

/* A bowl of sweets. */
static void rtrt_bowl(sc_build *b, double x, double z) {
  static const double bowl[][3] = {{0, 0, 1}, {95, 0, 1}, {104, 4}, {104, 10}, {70, 18}, {40, 30}, {48, 42}, {110, 62},
      {170, 110}, {204, 170}, {214, 226}, {209, 232}, {203, 226}, {192, 172}, {158, 116}, {104, 74}, {52, 56}, {0, 52}};
  static const double ring[3][3] = {{0.0, 0.096, 1}, {0.078, 0.104, 6}, {0.105, 0.165, 9}};
  sc_frame keep = sc_place(b, x, 0.0, z, 0.0);
  uint32_t i, k, n = 0;
  sc_use(b, RTRT_GLASS);
  SC_LATHE(b, 48, bowl, 1);
  for (k = 0; k < 4; k++) {
    uint32_t count = k < 3 ? (uint32_t)ring[k][2] : 5;
    for (i = 0; i < count; i++, n++) {
      double angle = 360.0 * i / count + 23.0 * k, r = k < 3 ? ring[k][0] : 0.055, y = k < 3 ? ring[k][1] : 0.205;
      sc_frame inner = sc_place(b, r * sc_cos(angle), y, r * sc_sin(angle), 0.0);
      sc_use(b, RTRT_SWEET_1 + (n * 7 + k) % 4);
      sc_sphere_band(b, 0.038, 0.0, 180.0, 7, 14);
      b->at = inner;
    }
  }
  b->at = keep;
}

static void rtrt_orb(sc_build *b, uint32_t kind, double x, double z, double radius, uint32_t rows) {
  sc_frame keep = sc_place(b, x, radius, z, 0.0);
  sc_use(b, kind);
  sc_sphere_band(b, radius, 0.0, 180.0, rows, 2 * rows);
  b->at = keep;
}

/* The house, behind the camera: only reflections see it. */
static void rtrt_house(sc_build *b) {
  uint32_t i, n = 20;
  sc_use(b, RTRT_HOUSE);
  for (i = 0; i < n; i++) {
    double a = 180.0 * i / n, c = 180.0 * (i + 1) / n, r = 9.0;
    sc_quad(b, sc_v(r * sc_cos(a), 0, r * sc_sin(a)), sc_v(r * sc_cos(c), 0, r * sc_sin(c)),
        sc_v(r * sc_cos(c), 7.0, r * sc_sin(c)), sc_v(r * sc_cos(a), 7.0, r * sc_sin(a)));
  }
}

static void rtrt_balloon(sc_build *b, uint32_t kind, double x, double y, double z, double radius, double tilt) {
  static const double skin[][3] = {{0, -1140}, {90, -1130}, {40, -1070}, {240, -950}, {560, -700}, {850, -320},
      {985, 60}, {930, 480}, {690, 810}, {350, 980}, {0, 1030}};
  sc_frame keep = sc_place(b, x, y, z, 0.0);
  sc_v3 p[4];
  sc_turn_z(b, tilt);
  b->at = rtrt_scaled(&b->at, radius, radius, radius);
  sc_use(b, kind);
  SC_LATHE(b, 20, skin, 2);
  b->at = keep;
  p[0] = sc_v(x + 1.1 * radius * sc_sin(tilt), y - 1.1 * radius * sc_cos(tilt), z), p[3] = sc_v(x, 0.0, z);
  p[1] = sc_add(sc_mul(p[0], 0.7), sc_mul(p[3], 0.3)), p[2] = sc_v(x - 0.05, 0.3 * y, z);
  sc_use(b, RTRT_GILT);
  sc_tube(b, p, 4, 5, false, 0.003, 0.003, 4);
}

/* Scraps of paper in front of the stage. */
static void rtrt_confetti(sc_build *b) {
  uint32_t i;
  for (i = 0; i < 150; i++) {
    double x = -2.3 + 4.6 * sc_random(&b->random), z = 0.3 + 3.0 * sc_random(&b->random);
    double turn = 360.0 * sc_random(&b->random), roll = 10.0 * sc_random(&b->random), s = 0.012;
    sc_frame keep = sc_place(b, x, 0.004, z, turn);
    sc_turn_z(b, roll);
    sc_use(b, RTRT_SWEET_1 + i % 4);
    sc_quad(b, sc_v(-s, 0, 1.5 * s), sc_v(s, 0, 1.5 * s), sc_v(s, 0, -1.5 * s), sc_v(-s, 0, -1.5 * s));
    b->at = keep;
  }
}

/* A flat lamp: half extents w, h; it looks at a point. */
static void rtrt_lamp(sc_build *b, uint32_t kind, sc_v3 at, sc_v3 to, double w, double h) {
  sc_frame keep = sc_aim(b, at, to);
  sc_use(b, kind);
  sc_quad(b, sc_v(-w, 0, h), sc_v(w, 0, h), sc_v(w, 0, -h), sc_v(-w, 0, -h));
  b->at = keep;
}

/* >>materials ------------------------------------------------------------------------------------------------------ */

/* Fabric with a pile: brighter where it is seen from the side. */
static void rtrt_velvet(void *user, const pktrt_points *p) {
  uint32_t i, k;
  (void)user;
  for (i = 0; i < p->n; i++) {
    double c = 0.0, f;
    for (k = 0; k < 3; k++) c -= (double)p->direction[k][i] * (double)p->normal[k][i];
    f = c < 0.0 ? 1.0 : c > 1.0 ? 0.0 : 1.0 - c;
    f = 0.70 + 2.2 * f * f * f;
    sc_tint(p->albedo, i, f);
  }
}

/* The curtain is brighter behind the group, as if washed by footlights. */
static void rtrt_drape(void *user, const pktrt_points *p) {
  uint32_t i;
  rtrt_velvet(user, p);
  for (i = 0; i < p->n; i++) {
    double x = (double)p->position[0][i], y = (double)p->position[1][i] - 1.0;
    sc_tint(p->albedo, i, 0.35 + 1.15 / (1.0 + 0.10 * x * x + 0.16 * y * y));
  }
}

/* Three balconies with gilt fronts, and lamps below each. */
static void rtrt_balconies(void *user, const pktrt_points *p) {
  uint32_t i;
  (void)user;
  for (i = 0; i < p->n; i++) {
    double x = (double)p->position[0][i], y = (double)p->position[1][i], row = floor(y / 1.5), up = y / 1.5 - row;
    double u = x / 0.6 - floor(x / 0.6) - 0.5, v = (up - 0.15) * 2.5, glow = 1.0 / (1.0 + 30.0 * (u * u + v * v));
    bool lamp = u * u + v * v<0.02, front = up> 0.45 && up < 0.75;
    double base = row < 1.0 ? 0.05 : front ? 0.42 + 0.08 * sc_sin(600.0 * x) : 0.05 + 0.30 * glow;
    if (lamp && row >= 1.0) base = 2.2;
    p->emission[0][i] = sc_snap(base);
    p->emission[1][i] = sc_snap(base * 0.86);
    p->emission[2][i] = sc_snap(base * (lamp ? 0.58 : 0.74));
  }
}

/* Lines that wander: where noise passes its middle value. 0 far from them, 1 on them. */
static double rtrt_vein(sc_corners near[3], double x, double y, double z, double width) {
  double v = sc_noise_near(&near[0], x, y, z) + 0.5 * sc_noise_near(&near[1], 2.1 * x, 2.1 * y, 2.1 * z);
  v += 0.25 * sc_noise_near(&near[2], 4.3 * x, 4.3 * y, 4.3 * z);
  v = (v - 0.875) / width;
  return 1.0 / (1.0 + v * v);
}

/* Tiles of cream and dark stone, set at 45 degrees, with veins and narrow joints. */
static void rtrt_tiles(void *user, const pktrt_points *p) {
  static const double stone[2][3] = {{0.70, 0.61, 0.48}, {0.060, 0.040, 0.034}};
  sc_corners near[4] = {sc_nowhere, sc_nowhere, sc_nowhere, sc_nowhere};
  uint32_t i, k;
  (void)user;
  for (i = 0; i < p->n; i++) {
    double x = (double)p->position[0][i], z = (double)p->position[2][i];
    double u = (x + z) * 1.25 + 64.1, v = (x - z) * 1.25 + 64.3;
    double a = sc_floor(u), c = sc_floor(v), fu = u - a, fv = v - c, e = fu < fv ? fu : fv, vein, tint;
    int dark = (int)(a + c) & 1;
    if (1.0 - fu < e) e = 1.0 - fu;
    if (1.0 - fv < e) e = 1.0 - fv;
    vein = rtrt_vein(near, 1.7 * u + 5.3 * a, 3.1 * c, 1.7 * v, 0.03);
    tint = 0.86 + 0.14 * sc_noise_near(&near[3], 0.5 + 3.7 * a, 0.5 + 1.3 * c, 0.5) + (dark ? 1.5 : -0.16) * vein;
    for (k = 0; k < 3; k++) p->albedo[k][i] = (float)(e < 0.010 ? 0.04 : stone[dark][k]);
    if (e >= 0.010) sc_tint(p->albedo, i, tint);
  }
}

static void rtrt_marble(void *user, const pktrt_points *p) {
  sc_corners near[3] = {sc_nowhere, sc_nowhere, sc_nowhere};
  uint32_t i;
  (void)user;
  for (i = 0; i < p->n; i++) {
    double x = (double)p->position[0][i], y = (double)p->position[1][i], z = (double)p->position[2][i];
    sc_tint(p->albedo, i, 1.0 - 0.75 * rtrt_vein(near, 14.0 * x, 14.0 * y, 14.0 * z, 0.05));
  }
}

static void rtrt_three(float *to, double x, double y, double z) {
  to[0] = sc_snap(x), to[1] = sc_snap(y), to[2] = sc_snap(z);
}

static void rtrt_coat(scene *s, uint32_t kind, float exponent) {
  pktrt_material *m = &s->materials[kind].m;
  m->specular = PKTRT_SPECULAR_COAT;
  m->ior[0] = 1.5f;
  m->lobe = exponent > 0.0f ? PKTRT_LOBE_PHONG : PKTRT_LOBE_IDEAL;
  m->exponent = exponent;
}

static void rtrt_metal(scene *s, uint32_t kind, const double *eta_k, float exponent) {
  pktrt_material *m = &s->materials[kind].m;
  m->specular = PKTRT_SPECULAR_CONDUCTOR;
  rtrt_three(m->ior, eta_k[0], eta_k[1], eta_k[2]);
  rtrt_three(m->extinction, eta_k[3], eta_k[4], eta_k[5]);
  m->lobe = exponent > 0.0f ? PKTRT_LOBE_PHONG : PKTRT_LOBE_IDEAL;
  m->exponent = exponent;
}

static void rtrt_clear(scene *s, uint32_t kind, double ior, double r, double g, double b) {
  pktrt_material *m = &s->materials[kind].m;
  m->specular = PKTRT_SPECULAR_DIELECTRIC;
  m->ior[0] = (float)ior;
  rtrt_three(m->absorption, r, g, b);
}

static void rtrt_materials(scene *s) {
  static const double chrome[6] = {3.1, 3.1, 2.3, 3.3, 3.3, 3.1}, gold[6] = {0.17, 0.35, 1.5, 3.1, 2.7, 1.9};
  static const double silver[6] = {0.15, 0.14, 0.13, 4.0, 3.1, 2.3};
  uint32_t i, k;
  for (i = 0; i < RTRT_ACTORS; i++) {
    uint32_t kind = rtrt_look(i);
    for (k = 0; k < RTRT_PARTS; k++) rtrt_coat(s, kind + k, k == RTRT_GLOVES ? 30.0f : k == RTRT_TRIM ? 120.0f : 0.0f);
    s->materials[kind + RTRT_GLOVES].m.specular = PKTRT_SPECULAR_NONE;
  }
  rtrt_coat(s, rtrt_look(RTRT_IMP), 600.0f);
  rtrt_coat(s, rtrt_look(RTRT_FROG), 80.0f);
  rtrt_metal(s, rtrt_look(RTRT_ROBOT), silver, 0.0f);
  rtrt_metal(s, rtrt_look(RTRT_BEAR), gold, 50.0f);
  rtrt_clear(s, rtrt_look(RTRT_DROP), 1.45, 2.0, 0.36, 0.24);
  s->materials[rtrt_look(RTRT_CYCLOPS)].m.specular = PKTRT_SPECULAR_NONE;
  s->materials[rtrt_look(RTRT_CYCLOPS)].m.texture = rtrt_velvet;
  rtrt_coat(s, RTRT_FLOOR, 0.0f);
  s->materials[RTRT_FLOOR].m.texture = rtrt_tiles;
  rtrt_coat(s, RTRT_RISER, 0.0f);
  rtrt_coat(s, RTRT_GILT, 0.0f);
  s->materials[RTRT_CURTAIN].m.texture = rtrt_drape;
  s->materials[RTRT_LETTERS].m.specular = PKTRT_SPECULAR_MIRROR; /* foil */
  rtrt_three(s->materials[RTRT_LETTERS].m.reflectance, 0.45, 0.36, 0.33);
  rtrt_metal(s, RTRT_FACETS, silver, 0.0f);
  rtrt_metal(s, RTRT_CHROME, chrome, 0.0f);
  rtrt_clear(s, RTRT_GLASS, 1.5, 0.9, 0.3, 0.5);
  rtrt_coat(s, RTRT_MARBLE, 0.0f);
  s->materials[RTRT_MARBLE].m.texture = rtrt_marble;
  for (i = 0; i < 4; i++) rtrt_coat(s, RTRT_SWEET_1 + i, 0.0f);
  rtrt_three(s->materials[RTRT_BULBS].m.emission, 3.2, 2.1, 0.9);
  s->materials[RTRT_HOUSE].m.texture = rtrt_balconies;
  rtrt_three(s->materials[RTRT_STRIP].m.emission, 3.0, 3.3, 3.8);
  rtrt_three(s->materials[RTRT_KEY].m.emission, 17.5, 15.9, 13.8);
}

/* >>make ----------------------------------------------------------------------------------------------------------- */

/* A gentle arc to the left, to the right and back; the eye rises a little on its way. */
static void rtrt_camera(double time, pktrt_camera *c) {
  double yaw = 4.0 - 13.0 * sc_sin(360.0 * time), r = 6.2;
  memset(c, 0, sizeof *c);
  rtrt_three(c->eye, r * sc_sin(yaw), 0.86 + 0.12 * (1.0 - sc_cos(360.0 * time)), r * sc_cos(yaw));
  rtrt_three(c->target, 0.0, 1.17, 0.0);
  c->fov_y = 33.0f;
  c->aperture = 0.075f;
  c->focus = 5.6f;
}

static void rtrt_quad_light(scene *s, sc_v3 at, sc_v3 to, double w, double h, double r, double g, double b) {
  pktrt_light *l = &s->lights[s->light_count++];
  sc_v3 z = sc_unit(sc_sub(to, at)), x = sc_unit(sc_cross(sc_v(0.0, 1.0, 0.0), z)), y = sc_cross(z, x), corner;
  corner = sc_sub(at, sc_add(sc_mul(x, w), sc_mul(y, h)));
  l->kind = PKTRT_LIGHT_QUAD;
  rtrt_three(l->position, corner.x, corner.y, corner.z);
  rtrt_three(l->edge[0], 2.0 * w * x.x, 2.0 * w * x.y, 2.0 * w * x.z);
  rtrt_three(l->edge[1], 2.0 * h * y.x, 2.0 * h * y.y, 2.0 * h * y.z);
  rtrt_three(l->intensity, r, g, b);
}

/* As in a photographer's studio: the key light, which reflections show; a cool fill light; a rim light from behind. */
static void rtrt_lights(scene *s) {
  pktrt_light *l = &s->lights[s->light_count++];
  l->kind = PKTRT_LIGHT_MESH;
  l->mesh = RTRT_KEY;
  rtrt_three(l->intensity, 1.0, 1.0, 1.0);
  rtrt_quad_light(s, sc_v(4.0, 2.6, 3.4), sc_v(0.0, 0.9, 0.0), 0.8, 1.1, 4.6, 5.6, 7.0);
  rtrt_quad_light(s, sc_v(1.2, 4.6, -2.4), sc_v(0.0, 0.9, 0.0), 1.6, 0.35, 12.0, 10.5, 10.5);
}

static void rtrt_make(sc_build *b) {
  scene *s = b->out;
  uint32_t i;
  b->random = 1958u;
  rtrt_lamp(b, RTRT_KEY, sc_v(-3.4, 4.4, 3.7), sc_v(0.0, 0.9, 0.0), 1.8, 1.3);
  rtrt_lamp(b, RTRT_STRIP, sc_v(4.5, 2.4, 1.6), sc_v(0.0, 1.0, 0.0), 0.35, 1.7);
  for (i = 0; i < RTRT_ACTORS; i++) rtrt_character(b, i);
  rtrt_ground(b);
  rtrt_curtain(b);
  rtrt_house(b);
  rtrt_letter(b, -1.16, 2.40, -1.3, 14.0, true);
  rtrt_letter(b, -0.60, 2.47, -1.5, 8.0, false);
  rtrt_letter(b, 0.56, 2.45, -1.5, -8.0, true);
  rtrt_letter(b, 1.14, 2.42, -1.3, -14.0, false);
  rtrt_mirror_ball(b, -0.02, 2.68, -1.6, 0.27);
  rtrt_balloon(b, RTRT_SWEET_1, -1.70, 1.88, -0.7, 0.25, 7.0);
  rtrt_balloon(b, RTRT_SWEET_2, -1.50, 1.45, -1.0, 0.22, 3.0);
  rtrt_balloon(b, RTRT_SWEET_4, 1.56, 2.00, -0.8, 0.25, -6.0);
  rtrt_balloon(b, RTRT_SWEET_3, 1.78, 1.50, -0.7, 0.22, -9.0);
  rtrt_confetti(b);
  rtrt_bowl(b, -0.84, 1.9);
  rtrt_orb(b, RTRT_CHROME, 1.16, 1.75, 0.17, 18);
  rtrt_orb(b, RTRT_MARBLE, 0.86, 2.2, 0.10, 14);
  rtrt_orb(b, RTRT_GLASS, 1.15, 2.35, 0.075, 14);
  if (b->failed) return;
  rtrt_materials(s);
  for (i = RTRT_CAST; i < RTRT_FLOOR; i++) {
    s->meshes[i].deforms = true;
    rtrt_normals(&s->meshes[i], s->meshes[i].positions, s->meshes[i].normals);
  }
  rtrt_lights(s);
  rtrt_three(s->background, 0.16, 0.17, 0.20);
  rtrt_three(s->ambient, 0.06, 0.06, 0.07);
}

#endif /* SCENE_RTRT_H */
