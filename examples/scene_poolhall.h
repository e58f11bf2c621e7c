/* scene_poolhall.h - the pool hall: three tables in play, a bar, the evening outside. Included by scenes.h, after its
   builder. One function per thing; the room is 16 by 10 metres, its floor at y = 0. */
#ifndef SCENE_POOLHALL_H
#define SCENE_POOLHALL_H

/* >>kinds ---------------------------------------------------------------------------------------------------------- */

enum {
  HALL_PLANK_1,
  HALL_PLANK_2,
  HALL_PLANK_3,
  HALL_PLANK_4,
  HALL_PLASTER,
  HALL_CEILING,
  HALL_PANEL,
  HALL_TRIM,
  HALL_CLOTH,
  HALL_RAIL,
  HALL_CARVED,
  HALL_LEATHER,
  HALL_NET,
  HALL_IVORY,
  HALL_BALL_1,
  HALL_BALL_2,
  HALL_BALL_3,
  HALL_BALL_4,
  HALL_BALL_5,
  HALL_BALL_6,
  HALL_BALL_7,
  HALL_BALL_8,
  HALL_MAPLE,
  HALL_CHALK,
  HALL_BRASS,
  HALL_STEEL,
  HALL_ENAMEL,
  HALL_OPAL,
  HALL_BAR_TOP,
  HALL_SEAT,
  HALL_BENTWOOD,
  HALL_GREEN_GLASS,
  HALL_BROWN_GLASS,
  HALL_CLEAR_GLASS,
  HALL_LABEL,
  HALL_CURTAIN,
  HALL_GILT,
  HALL_SKY,
  HALL_HILL,
  HALL_SLATE,
  HALL_TREES,
  HALL_INK,
  HALL_BULB,
  HALL_LIGHT_1, /* the middle bulb of each table's lamp */
  HALL_LIGHT_2,
  HALL_LIGHT_3,
  HALL_GLOBE,   /* of the fan that is a light, */
  HALL_GLOBE_2, /* and of the other one */
  HALL_MIRROR,
  HALL_PANE,
  HALL_TUMBLER,
  HALL_WHISKY_IN_GLASS, /* the surface between the two */
  HALL_WHISKY,
  HALL_BEER_IN_GLASS,
  HALL_FOAM,
  HALL_FAN_WOOD, /* what turns: wood and brass of either fan */
  HALL_FAN_BRASS,
  HALL_FAN_2_WOOD,
  HALL_FAN_2_BRASS,
  HALL_MOVING, /* ball, ivory and ink of each ball that moves, see hall_moving */
  HALL_KINDS = HALL_MOVING + 12
};

/* clang-format off */
static const sc_kind poolhall_kinds[HALL_KINDS] = {
  {"floor planks, light", {0.36f, 0.19f, 0.085f}, 1}, {"floor planks, red", {0.30f, 0.14f, 0.06f}, 1},
  {"floor planks, dark", {0.25f, 0.125f, 0.055f}, 1}, {"floor planks, pale", {0.40f, 0.225f, 0.11f}, 1},
  {"plaster", {0.70f, 0.53f, 0.34f}, 1},              {"ceiling", {0.74f, 0.63f, 0.48f}, 1},
  {"panelling", {0.23f, 0.098f, 0.042f}, 0},          {"mouldings and beams", {0.19f, 0.080f, 0.035f}, 0},
  {"cloth", {0.022f, 0.195f, 0.088f}, 0},              {"rails", {0.215f, 0.080f, 0.034f}, 0},
  {"carved mahogany", {0.23f, 0.075f, 0.030f}, 0},    {"leather", {0.055f, 0.030f, 0.018f}, 0},
  {"nets", {0.55f, 0.46f, 0.31f}, 0},                 {"ivory", {0.80f, 0.74f, 0.60f}, 0},
  {"ball yellow", {0.80f, 0.50f, 0.02f}, 0},          {"ball blue", {0.02f, 0.06f, 0.42f}, 0},
  {"ball red", {0.62f, 0.02f, 0.02f}, 0},             {"ball violet", {0.16f, 0.03f, 0.30f}, 0},
  {"ball orange", {0.80f, 0.20f, 0.01f}, 0},          {"ball green", {0.01f, 0.22f, 0.07f}, 0},
  {"ball maroon", {0.26f, 0.015f, 0.02f}, 0},         {"ball black", {0.012f, 0.012f, 0.013f}, 0},
  {"maple", {0.62f, 0.42f, 0.21f}, 0},                {"chalk", {0.03f, 0.16f, 0.45f}, 0},
  {"brass", {0.58f, 0.37f, 0.10f}, 0},                {"steel", {0.42f, 0.42f, 0.43f}, 0},
  {"enamel", {0.012f, 0.10f, 0.055f}, 0},             {"opal glass", {0.95f, 0.88f, 0.70f}, 0},
  {"bar top", {0.30f, 0.13f, 0.05f}, 0},              {"red leather", {0.33f, 0.025f, 0.02f}, 0},
  {"bentwood", {0.16f, 0.06f, 0.025f}, 0},            {"green glass", {0.03f, 0.19f, 0.06f}, 0},
  {"brown glass", {0.27f, 0.10f, 0.02f}, 0},          {"clear glass", {0.55f, 0.58f, 0.55f}, 0},
  {"labels", {0.75f, 0.66f, 0.45f}, 0},               {"curtains", {0.30f, 0.018f, 0.022f}, 0},
  {"gilt frames", {0.62f, 0.40f, 0.11f}, 0},          {"painted sky", {0.45f, 0.50f, 0.50f}, 1},
  {"painted hills", {0.10f, 0.17f, 0.06f}, 1},        {"slate", {0.05f, 0.06f, 0.06f}, 1},
  {"trees", {0.020f, 0.034f, 0.022f}, 1},              {"ink", {0.015f, 0.015f, 0.015f}, 0},
  {"bulbs", {0.80f, 0.75f, 0.65f}, 0},                {"bulb of table 1", {0.80f, 0.75f, 0.65f}, 0},
  {"bulb of table 2", {0.80f, 0.75f, 0.65f}, 0},      {"bulb of table 3", {0.80f, 0.75f, 0.65f}, 0},
  {"lamp globe", {0.80f, 0.75f, 0.65f}, 0},
  {"lamp globe, far", {0.80f, 0.75f, 0.65f}, 0},      {"bar mirror", {0.10f, 0.10f, 0.10f}, 1},
  {"panes", {0.03f, 0.045f, 0.08f}, 1},               {"tumbler", {0.50f, 0.34f, 0.14f}, 0},
  {"whisky, sides", {0.45f, 0.20f, 0.03f}, 0},        {"whisky, top", {0.45f, 0.20f, 0.03f}, 0},
  {"beer, sides", {0.50f, 0.27f, 0.04f}, 0},          {"foam", {0.80f, 0.74f, 0.60f}, 0},
  {"fan blades", {0.23f, 0.075f, 0.030f}, 0},         {"fan arms", {0.58f, 0.37f, 0.10f}, 0},
  {"fan blades, far", {0.23f, 0.075f, 0.030f}, 0},    {"fan arms, far", {0.58f, 0.37f, 0.10f}, 0},
  {"cue ball", {0.80f, 0.74f, 0.60f}, 0},             {"cue ball, ivory", {0.80f, 0.74f, 0.60f}, 0},
  {"cue ball, ink", {0.015f, 0.015f, 0.015f}, 0},     {"rolling ball 9", {0.80f, 0.50f, 0.02f}, 0},
  {"rolling ball 9, ivory", {0.80f, 0.74f, 0.60f}, 0}, {"rolling ball 9, ink", {0.015f, 0.015f, 0.015f}, 0},
  {"rolling ball 2", {0.02f, 0.06f, 0.42f}, 0},       {"rolling ball 2, ivory", {0.80f, 0.74f, 0.60f}, 0},
  {"rolling ball 2, ink", {0.015f, 0.015f, 0.015f}, 0}, {"spinning ball 12", {0.16f, 0.03f, 0.30f}, 0},
  {"spinning ball 12, ivory", {0.80f, 0.74f, 0.60f}, 0}, {"spinning ball 12, ink", {0.015f, 0.015f, 0.015f}, 0}
};
/* clang-format on */

#define HALL_X 16.0 /* length, width and height of the room */
#define HALL_Z 10.0
#define HALL_Y 3.6
#define HALL_A 1.27 /* half the playing field, from cushion nose to cushion nose (nine-foot table) */
#define HALL_C 0.635
#define HALL_BED 0.79
#define HALL_POCKET 0.062 /* radius of a pocket */
#define HALL_BALL 0.028575

/* Floor: 62 rows of planks; all edges are cut by a millimetre, so that neighbours meet in a groove. */
static void hall_floor(sc_build *b) {
  uint32_t row, rows = 62;
  for (row = 0; row < rows; row++) {
    double z0 = HALL_Z * row / rows, z1 = HALL_Z * (row + 1) / rows, x = 0.0, cut = 0.0012, deep = -0.0005;
    double next = 0.5 + 1.7 * sc_random(&b->random);
    while (x < HALL_X) {
      double x1 = next > HALL_X - 0.4 ? HALL_X : next;
      sc_v3 p[8];
      sc_use(b, HALL_PLANK_1 + (uint32_t)(4.0 * sc_random(&b->random)));
      p[0] = sc_v(x, deep, z0), p[1] = sc_v(x, deep, z1), p[2] = sc_v(x1, deep, z1), p[3] = sc_v(x1, deep, z0);
      p[4] = sc_v(x + cut, 0, z0 + cut), p[5] = sc_v(x + cut, 0, z1 - cut);
      p[6] = sc_v(x1 - cut, 0, z1 - cut), p[7] = sc_v(x1 - cut, 0, z0 + cut);
      sc_quad(b, p[4], p[5], p[6], p[7]);
      sc_quad(b, p[0], p[1], p[5], p[4]);
      sc_quad(b, p[1], p[2], p[6], p[5]);
      sc_quad(b, p[2], p[3], p[7], p[6]);
      sc_quad(b, p[3], p[0], p[4], p[7]);
      x = x1;
      next = x + 1.4 + 1.2 * sc_random(&b->random);
    }
  }
}

/* A wall in its own frame: x along, y up, z into the room. Openings are ordered along x: x0, y0, x1, y1. */
typedef struct hall_wall {
  double x, z, yaw, length;
  double open[3][4];
  uint32_t opens; /* those that reach the floor are doors */
  bool windows;
} hall_wall;

static const hall_wall hall_walls[4] = {
    {0.0, 0.0, 0.0, HALL_X, {{2.3, 1.25, 3.7, 2.95}, {4.3, 1.25, 5.7, 2.95}, {6.3, 1.25, 7.7, 2.95}}, 3, true},
    {HALL_X, 0.0, -90.0, HALL_Z, {{0.9, 0.0, 1.95, 2.2}, {3.1, 1.25, 4.5, 2.95}, {5.6, 1.25, 7.0, 2.95}}, 3, true},
    {HALL_X, HALL_Z, 180.0, HALL_X, {{4.0, 0.0, 5.05, 2.2}, {0, 0, 0, 0}, {0, 0, 0, 0}}, 1, false},
    {0.0, HALL_Z, 90.0, HALL_Z, {{3.0, 1.25, 4.4, 2.95}, {5.6, 1.25, 7.0, 2.95}, {0, 0, 0, 0}}, 2, true}};

static void hall_plaster(sc_build *b, const hall_wall *w) {
  double x = 0.0;
  uint32_t i;
  sc_use(b, HALL_PLASTER);
  for (i = 0; i <= w->opens; i++) {
    const double *o = w->open[i < w->opens ? i : 0];
    double end = i < w->opens ? o[0] : w->length;
    sc_quad(b, sc_v(x, 0, 0), sc_v(end, 0, 0), sc_v(end, HALL_Y, 0), sc_v(x, HALL_Y, 0));
    if (i == w->opens) break;
    if (o[1] > 0.0) sc_quad(b, sc_v(o[0], 0, 0), sc_v(o[2], 0, 0), sc_v(o[2], o[1], 0), sc_v(o[0], o[1], 0));
    sc_quad(b, sc_v(o[0], o[3], 0), sc_v(o[2], o[3], 0), sc_v(o[2], HALL_Y, 0), sc_v(o[0], HALL_Y, 0));
    x = o[2];
  }
}

/* Wainscot from x0 to x1: board, stiles, raised fields, skirting and cap. */
static void hall_wainscot(sc_build *b, double x0, double x1) {
  static const double skirting[][3] = {{35, 0, 1}, {35, 130, 1}, {30, 145}, {22, 150}, {18, 165, 1}, {0, 165, 1}};
  static const double cap[][3] = {
      {18, 1000, 1}, {30, 1010}, {34, 1030}, {50, 1045, 1}, {55, 1050}, {55, 1060}, {50, 1065, 1}, {0, 1065, 1}};
  uint32_t i, n = (uint32_t)((x1 - x0) / 0.62 + 0.5);
  double pitch;
  sc_pt path[2] = {{0, 0, 1}, {0, 0, 1}};
  if (n == 0) n = 1;
  pitch = (x1 - x0) / n;
  sc_use(b, HALL_PANEL);
  sc_quad(b, sc_v(x0, 0, 0.008), sc_v(x1, 0, 0.008), sc_v(x1, 1.03, 0.008), sc_v(x0, 1.03, 0.008));
  sc_box(b, x0, 0.14, 0.0, x1, 0.24, 0.0215, 0.003);
  sc_box(b, x0, 0.92, 0.0, x1, 1.02, 0.0215, 0.003);
  for (i = 0; i < n; i++) {
    double x = x0 + pitch * i;
    if (i) sc_box(b, x - 0.05, 0.235, 0.0, x + 0.05, 0.925, 0.022, 0.003);
    sc_box(b, x + 0.075, 0.262, -0.03, x + pitch - 0.075, 0.898, 0.019, 0.012);
  }
  sc_box(b, x0, 0.235, 0.0, x0 + 0.05, 0.925, 0.022, 0.003);
  sc_box(b, x1 - 0.05, 0.235, 0.0, x1, 0.925, 0.022, 0.003);
  sc_use(b, HALL_TRIM);
  path[0].x = x1, path[1].x = x0;
  sc_moulding(b, path, 2, false, skirting, SC_COUNT(skirting), 2);
  sc_moulding(b, path, 2, false, cap, SC_COUNT(cap), 2);
}

static double hall_fold(double x, double y, const void *context) { /* pleats, gathered at the tie-back */
  const double *c = (const double *)context;                       /* width, height of the tie-back */
  double gather = 1.0 / (1.0 + 9.0 * (y - c[1]) * (y - c[1]));
  return 0.02 * (1.0 + 0.35 * sc_sin(900.0 * y + 700.0 * x)) * sc_sin(360.0 * 8.0 * x / c[0]) * (1.0 - 0.45 * gather) +
         0.03 * gather;
}

static void hall_curtains(sc_build *b, double x0, double x1) {
  static const double knob[][3] = {{0, 0}, {20, 5}, {30, 25}, {20, 45}, {8, 55}, {0, 60}};
  double width[2] = {0.36, 1.45};
  uint32_t i, side;
  sc_use(b, HALL_CURTAIN);
  for (side = 0; side < 2; side++) {
    sc_frame keep = sc_place(b, side ? x1 - 0.16 : x0 - 0.2, 0.0, 0.12, 0.0);
    sc_heights(b, 0.0, 1.1, width[0], 3.09, 48, 9, hall_fold, width);
    b->at = keep;
  }
  sc_use(b, HALL_BRASS);
  sc_rod(b, sc_v(x0 - 0.3, 3.12, 0.12), sc_v(x1 + 0.3, 3.12, 0.12), 0.014, 10);
  for (side = 0; side < 2; side++) {
    sc_frame keep = sc_place(b, side ? x1 + 0.3 : x0 - 0.3, 3.12, 0.12, 0.0);
    sc_turn_z(b, side ? -90.0 : 90.0);
    SC_LATHE(b, 12, knob, 2);
    b->at = keep;
    for (i = 0; i < 6; i++) { /* rings */
      keep = sc_place(b, (side ? x1 - 0.14 : x0 - 0.18) + 0.063 * i, 3.115, 0.12, 0.0);
      sc_turn_z(b, 90.0);
      sc_torus(b, 0.0, 0.022, 0.0035, 10, 4);
      b->at = keep;
    }
  }
}

static const double hall_casing[][3] = {
    {110, 0, 1}, {110, 30, 1}, {100, 36}, {90, 30, 1}, {20, 22, 1}, {12, 30}, {0, 30, 1}, {0, -220, 1}};

/* A sash window in an opening, the frame 12 cm behind the wall; one sheet of glass stands for all panes. */
static void hall_window(sc_build *b, const double *o) {
  double w = (o[2] - o[0]) / 3.0, h = (o[3] - o[1]) / 4.0, z = -0.12;
  uint32_t i;
  sc_use(b, HALL_TRIM);
  sc_border(b, o[0], o[1], o[2], o[3], hall_casing, SC_COUNT(hall_casing), 2);
  sc_box(b, o[0] - 0.15, o[1] - 0.045, -0.2, o[2] + 0.15, o[1] + 0.004, 0.085, 0.006);
  sc_box(b, o[0] - 0.01, o[1] - 0.01, z - 0.05, o[0] + 0.06, o[3] + 0.01, z, 0.005);
  sc_box(b, o[2] - 0.06, o[1] - 0.01, z - 0.05, o[2] + 0.01, o[3] + 0.01, z, 0.005);
  sc_box(b, o[0], o[1] - 0.01, z - 0.049, o[2], o[1] + 0.07, z - 0.001, 0.005);
  sc_box(b, o[0], o[3] - 0.06, z - 0.049, o[2], o[3] + 0.01, z - 0.001, 0.005);
  for (i = 1; i < 3; i++) sc_box(b, o[0] + w * i - 0.012, o[1], z - 0.04, o[0] + w * i + 0.012, o[3], z - 0.01, 0.004);
  for (i = 1; i < 4; i++) {
    double t = i == 2 ? 0.028 : 0.012;
    sc_box(b, o[0], o[1] + h * i - t, z - 0.041, o[2], o[1] + h * i + t, z - 0.009, 0.004);
  }
  sc_use(b, HALL_PANE);
  sc_box(b, o[0], o[1], z - 0.027, o[2], o[3], z - 0.023, 0.0);
  hall_curtains(b, o[0], o[2]);
}

static void hall_door(sc_build *b, const double *o) {
  static const double knob[][3] = {{28, 0, 1}, {28, 6, 1}, {10, 8}, {10, 30}, {26, 42}, {30, 55}, {20, 68}, {0, 71}};
  static const double fields[3][2] = {{0.18, 0.78}, {0.92, 1.42}, {1.54, 2.02}};
  double mid = (o[0] + o[2]) / 2.0;
  sc_frame keep;
  uint32_t i, side;
  sc_use(b, HALL_TRIM);
  sc_border(b, o[0], -0.2, o[2], o[3], hall_casing, SC_COUNT(hall_casing), 2);
  sc_use(b, HALL_PANEL);
  sc_box(b, o[0], 0.006, -0.06, o[2], o[3], -0.02, 0.003);
  sc_box(b, o[0], -0.02, -0.2, o[2], 0.012, 0.0, 0.004);
  for (i = 0; i < 3; i++)
    for (side = 0; side < 2; side++) {
      double x0 = side ? mid + 0.05 : o[0] + 0.12, x1 = side ? o[2] - 0.12 : mid - 0.05;
      static const double bead[][3] = {{12, -21, 1}, {9, -12}, {0, -10}, {-8, -14}, {-12, -21, 1}};
      sc_border(b, x0, fields[i][0], x1, fields[i][1], bead, SC_COUNT(bead), 2);
      sc_box(b, x0 + 0.04, fields[i][0] + 0.04, -0.04, x1 - 0.04, fields[i][1] - 0.04, -0.011, 0.009);
    }
  sc_use(b, HALL_BRASS);
  keep = sc_place(b, o[2] - 0.06, 1.02, -0.02, 0.0);
  sc_turn_x(b, 90.0);
  SC_LATHE(b, 20, knob, 3);
  b->at = keep;
}

/* Ceiling: boards, beams across, joists between them, a cornice around. */
static void hall_ceiling(sc_build *b) {
  static const double cornice[][3] = {{0, 3360, 1}, {18, 3360, 1}, {22, 3385}, {20, 3400, 1}, {35, 3415}, {60, 3450},
      {100, 3500}, {120, 3530, 1}, {130, 3535, 1}, {130, 3605, 1}};
  static const sc_pt room[] = {{0, HALL_Z, 1}, {HALL_X, HALL_Z, 1}, {HALL_X, 0, 1}, {0, 0, 1}};
  uint32_t i, k;
  sc_use(b, HALL_CEILING);
  sc_quad(b, sc_v(0, HALL_Y, 0), sc_v(HALL_X, HALL_Y, 0), sc_v(HALL_X, HALL_Y, HALL_Z), sc_v(0, HALL_Y, HALL_Z));
  sc_use(b, HALL_TRIM);
  sc_moulding(b, room, 4, true, cornice, SC_COUNT(cornice), 3);
  for (i = 0; i < 7; i++) {
    double x = 2.0 + 2.0 * i;
    sc_box(b, x - 0.1, 3.34, -0.05, x + 0.1, 3.65, HALL_Z + 0.05, 0.012);
    for (k = 0; k < 2; k++) { /* corbels under the ends of the beams */
      static const double corbel[][3] = {
          {0, 2980, 1}, {50, 3000}, {70, 3080}, {100, 3140}, {200, 3200}, {270, 3270}, {280, 3345, 1}, {0, 3345, 1}};
      sc_frame keep = sc_place(b, x, 0.0, k ? HALL_Z : 0.0, k ? 180.0 : 0.0);
      sc_prism(b, corbel, SC_COUNT(corbel), 3, -0.07, 0.0, 0.07, 0.0, 0.03, 3.25);
      b->at = keep;
    }
  }
  for (i = 0; i < 15; i++) {
    double z = HALL_Z * (i + 1) / 16.0;
    for (k = 0; k < 8; k++) sc_box(b, 2.0 * k + 0.09, 3.49, z - 0.04, 2.0 * k + 1.91, 3.65, z + 0.04, 0.006);
  }
}

/* Trees behind the windows, black against the evening sky: a ragged fence two metres behind the wall. */
static void hall_trees(sc_build *b, double length) {
  double y0 = 2.0, phase = 360.0 * sc_random(&b->random);
  uint32_t i, n = 5 * (uint32_t)length;
  sc_use(b, HALL_TREES);
  for (i = 0; i < n; i++) {
    double x0 = -2.0 + (length + 4.0) * i / n, x1 = -2.0 + (length + 4.0) * (i + 1) / n;
    double y1 = 1.95 + 0.35 * sc_sin(110.0 * x1 + phase) + 0.2 * sc_sin(277.0 * x1) + 0.16 * sc_random(&b->random);
    sc_quad(b, sc_v(x0, 0.0, -2.0), sc_v(x1, 0.0, -2.0), sc_v(x1, y1, -2.0), sc_v(x0, y0, -2.0));
    y0 = y1;
  }
}

static void hall_room(sc_build *b) {
  uint32_t i, k;
  hall_floor(b);
  hall_ceiling(b);
  for (i = 0; i < 4; i++) {
    const hall_wall *w = &hall_walls[i];
    sc_frame keep = sc_place(b, w->x, 0.0, w->z, w->yaw);
    double x = 0.0;
    hall_plaster(b, w);
    for (k = 0; k < w->opens; k++) {
      const double *o = w->open[k];
      if (o[1] > 0.0) {
        hall_window(b, o);
      } else {
        hall_door(b, o);
        if (o[0] - 0.11 > x) hall_wainscot(b, x, o[0] - 0.11);
        x = o[2] + 0.11;
      }
    }
    hall_wainscot(b, x, w->length);
    if (w->windows) hall_trees(b, w->length);
    b->at = keep;
  }
}

/* The leather-covered iron around a pocket. x, z point away from the field at a corner; z does at a side. */
static void hall_pocket_iron(sc_build *b, bool corner) {
  static const double section[][3] = {{1000, -30, 1}, {1000, 26}, {985, 37}, {945, 45}, {860, 48}, {120, 48}, {30, 44},
      {0, 30}, {0, -50, 1}, {1000, -30, 1}};
  double from = corner ? -76.0 : -5.0, to = corner ? 166.0 : 185.0, out = corner ? 0.142 : 0.122,
         reach = corner ? 0.067 : 0.076;
  uint32_t n = sc_segments(b, 28), i;
  sc_frame f[32];
  sc_pt round[SC_MAX_POINTS];
  uint32_t count = sc_round(section, SC_COUNT(section), 1, round);
  for (i = 0; i <= n + 2; i++) { /* the first and last end square, flush with the rails */
    uint32_t k = i == 0 ? 0 : i > n + 1 ? n : i - 1;
    double t = from + (to - from) * k / n, c = sc_cos(t), s = sc_sin(t), u, v, px = HALL_POCKET * c,
           pz = HALL_POCKET * s;
    if (corner) {
      u = t < 0.0 ? out : t < 90.0 ? out * c : -(t - 90.0) / (to - 90.0) * reach;
      v = t < 0.0 ? t / from * -reach : t < 90.0 ? out * s : out;
      if (i == 0) pz = -reach;
      if (i == n + 2) px = -reach;
    } else {
      u = reach * (1.0 - 2.0 * k / n);
      v = out + 0.012 * (1.0 - u * u / (reach * reach));
      if (i == 0) px = reach;
      if (i == n + 2) px = -reach;
    }
    f[i].o = sc_v(px, 0.0, pz), f[i].x = sc_v(u - px, 0.0, v - pz), f[i].y = sc_v(0.0, 1.0, 0.0);
  }
  sc_sweep(b, f, n + 3, false, round, count, false, 1);
  sc_cap(b, &f[0], round, count, 0.5, 0.0, true);
  sc_cap(b, &f[n + 2], round, count, 0.5, 0.0, false);
}

/* Leather bag below a pocket, a rim around its top and a net over it: strands wind both ways. */
static void hall_pocket_net(sc_build *b) {
  static const double bag[][3] = {{0, -262}, {22, -258}, {36, -245}, {41, -222}, {53, -165}, {64, -90, 1}, {70, -85},
      {71, -50}, {68, -5, 1}, {66, -5, 1}, {62, -100}, {35, -235}, {0, -250}};
  uint32_t strands = b->detail < 1.0 ? 6 : 8, i, k, dir;
  sc_use(b, HALL_LEATHER);
  SC_LATHE(b, 24, bag, 1);
  sc_use(b, HALL_NET);
  for (dir = 0; dir < 2; dir++)
    for (i = 0; i < strands; i++) {
      sc_v3 p[6];
      for (k = 0; k < 6; k++) {
        double t = k / 5.0, a = 360.0 * i / strands + (dir ? 75.0 : -75.0) * t,
               r = 0.0655 + 0.002 * t * (1.0 - t) - 0.0235 * t;
        p[k] = sc_v(r * sc_cos(a), -0.09 - 0.13 * t, r * sc_sin(a));
      }
      sc_tube(b, p, 6, 1, false, 0.0017, 0.0017, 4);
    }
}

/* The cloth on the slate: a rectangle of six points, and around it six fans towards the pockets with quads in
   between. */
static void hall_bed(sc_build *b) {
  double ex = HALL_A + 0.03, ez = HALL_C + 0.03, ix = HALL_A - 0.12, iz = HALL_C - 0.12;
  static const double side[6][3] = {
      {1, 1, 1}, {0, 1, 1}, {-1, 1, 1}, {-1, -1, 1}, {0, -1, 1}, {1, -1, 1}}; /* x, z of the pockets */
  sc_v3 inner[6], edge[6][13];
  uint32_t i, k, n = 12;
  for (i = 0; i < 6; i++) {
    double sx = side[i][0], sz = side[i][1];
    bool corner = sx * sx > 0.5;
    double px = sx * (HALL_A + 0.035), pz = sz * (HALL_C + (corner ? 0.035 : 0.055)), x0, z0, x1, z1;
    double da = ex - (HALL_A + 0.035),
           dz = ez - (HALL_C + (corner ? 0.035 : 0.055)); /* edges of the bed, seen from the pocket */
    double h = sqrt(HALL_POCKET * HALL_POCKET - dz * dz), hx = sqrt(HALL_POCKET * HALL_POCKET - da * da);
    inner[i] = sc_v(sx * ix, 0.0, sz * iz);
    /* walk around against the clock, seen from above: from the pocket's first cut of the edge to its second */
    if (corner && sx * sz > 0) x0 = sx * da, z0 = -sz * hx, x1 = -sx * h, z1 = sz * dz;
    else if (corner) x0 = -sx * h, z0 = sz * dz, x1 = sx * da, z1 = -sz * hx;
    else x0 = sz * h, z0 = sz * dz, x1 = -sz * h, z1 = sz * dz;
    for (k = 0; k <= n; k++) { /* along the arc: chord points pushed out to the circle, on the field's side */
      double t = (double)k / n, x = x0 + (x1 - x0) * t - sx * 0.02,
             z = z0 + (z1 - z0) * t - (corner ? sz * 0.02 : sz * 0.03), l;
      if (k == 0) x = x0, z = z0;
      if (k == n) x = x1, z = z1;
      l = HALL_POCKET / sqrt(x * x + z * z);
      edge[i][k] = sc_v(px + x * l, 0.0, pz + z * l);
    }
  }
  sc_use(b, HALL_CLOTH);
  for (i = 0; i < 6; i++) {
    sc_v3 up = sc_v(0, 1, 0), down = sc_v(0, -0.045, 0);
    uint32_t next = (i + 1) % 6, centre = sc_vertex(b, inner[i], up), v = 0, before = 0;
    sc_mark mark;
    for (k = 0; k <= n; k++, before = v) {
      v = sc_vertex(b, edge[i][k], up);
      if (k) sc_triangle(b, centre, v, before);
    }
    sc_quad(b, inner[i], inner[next], edge[next][0], edge[i][n]);
    mark = sc_begin(b);
    for (k = 0; k <= n; k++) {
      v = sc_vertex(b, edge[i][k], up);
      sc_vertex(b, sc_add(edge[i][k], down), up);
      if (k) sc_triangle(b, v - 2, v, v - 1), sc_triangle(b, v - 1, v, v + 1);
    }
    sc_smooth(b, mark);
  }
  sc_quad(b, inner[2], inner[1], inner[4], inner[3]);
  sc_quad(b, inner[1], inner[0], inner[5], inner[4]);
}

/* One stretch of rail and cushion, facing +z in its frame (nose line z = 0), and its three sights. Where a cushion
   ends it is sheared, less at the side pockets, and reaches out of the rail up to the round of the pocket. */
static void hall_rail(sc_build *b, double x0, double shear0, double x1, double shear1, double first, double step) {
  static const double wood[][3] = {{-30, -100, 1}, {30, -92}, {75, -75}, {105, -45}, {140, -34, 1}, {158, -34, 1},
      {171, -26}, {175, 0}, {174, 25}, {166, 43}, {150, 47, 1}, {49, 47, 1}, {49, -4, 1}, {-35, -12, 1},
      {-30, -100, 1}};
  static const double rubber[][3] = {
      {50, -2, 1}, {50, 45.5, 1}, {10, 40.5}, {2, 38.5}, {0, 36}, {3, 31}, {28, -2, 1}, {50, -2, 1}};
  static const double stone[][3] = {{8, 0, 1}, {8, 0.6, 1}, {0, 0.6, 1}};
  double over0 = shear0 < -1.0 ? 0.003 : 0.0125, over1 = shear1 < -1.0 ? 0.003 : 0.0125;
  uint32_t i;
  sc_use(b, HALL_RAIL);
  sc_prism(b, wood, SC_COUNT(wood), 2, x0, 0.0, x1, 0.0, 0.06, -0.02);
  sc_use(b, HALL_CLOTH);
  sc_prism(b, rubber, SC_COUNT(rubber), 2, x0 - over0 - 0.05 * shear0, shear0, x1 + over1 + 0.05 * shear1, -shear1,
      0.03, 0.02);
  sc_use(b, HALL_IVORY);
  for (i = 0; i < 3; i++) {
    sc_frame keep = sc_place(b, first + step * i, 0.0468, 0.105, 0.0);
    b->at.x = sc_mul(b->at.x, 0.75), b->at.z = sc_mul(b->at.z, 1.5);
    sc_lathe_around(b, 0.0, 0.0, 4, stone, SC_COUNT(stone), 1);
    b->at = keep;
  }
}

static void hall_leg(sc_build *b) {
  static const double foot[][3] = {{0, 0, 1}, {50, 0, 1}, {66, 14}, {70, 34}, {58, 56, 1}, {46, 60, 1}, {43, 68},
      {46, 80, 1}, {56, 82}, {60, 90}, {56, 98}, {48, 100, 1}};
  static const double shaft[][3] = {{47, 98, 1}, {50, 120}, {58, 200}, {66, 270}, {68, 302, 1}};
  static const double vase[][3] = {{68, 300, 1}, {78, 302}, {81, 310}, {78, 318}, {66, 321, 1}, {56, 330}, {62, 345},
      {84, 375}, {90, 400}, {78, 428}, {56, 444, 1}, {66, 447}, {69, 455}, {64, 464, 1}};
  sc_use(b, HALL_CARVED);
  SC_LATHE(b, 24, foot, 1);
  b->flutes = 12, b->flute_depth = 0.10;
  SC_LATHE(b, 48, shaft, 1);
  b->flutes = 0;
  SC_LATHE(b, 28, vase, 2);
  sc_box(b, -0.085, 0.46, -0.085, 0.085, 0.545, 0.085, 0.006);
}

/* A table, its middle at the origin on the floor, long along x. */
static void hall_table(sc_build *b) {
  static const double apron[][3] = {{0, 530, 1}, {100, 530, 1}, {116, 535}, {121, 548}, {116, 561}, {106, 566, 1},
      {104, 590, 1}, {104, 660, 1}, {108, 664}, {120, 672, 1}, {120, 765, 1}, {0, 765, 1}};
  double corner = 0.035, xs = HALL_A + corner - 0.067, zs = HALL_C + corner - 0.067;
  sc_frame keep, bed;
  uint32_t i;
  sc_use(b, HALL_CARVED);
  sc_lathe_around(b, HALL_A - 0.14, HALL_C - 0.14, 48, apron, SC_COUNT(apron), 2);
  for (i = 0; i < 6; i++) {
    keep = sc_place(b, ((int)(i % 3) - 1) * (HALL_A - 0.14), 0.0, (i < 3 ? 1 : -1) * (HALL_C - 0.13), 0.0);
    hall_leg(b);
    b->at = keep;
  }
  bed = sc_place(b, 0.0, HALL_BED, 0.0, 0.0);
  hall_bed(b);
  for (i = 0; i < 2; i++) {
    double turn = 180.0 * i, step = HALL_A / 4.0;
    keep = sc_place(b, 0.0, 0.0, i ? -HALL_C : HALL_C, turn);
    hall_rail(b, -xs, -1.28, -0.076, -0.25, -3 * step, step);
    hall_rail(b, 0.076, -0.25, xs, -1.28, step, step);
    b->at = keep;
    keep = sc_place(b, i ? -HALL_A : HALL_A, 0.0, 0.0, 90.0 + turn);
    hall_rail(b, -zs, -1.28, zs, -1.28, -step, step);
    b->at = keep;
  }
  for (i = 0; i < 6; i++) {
    int sx = (int)(i % 3) - 1, sz = i < 3 ? 1 : -1;
    static const double turns[6] = {-90.0, 0.0, 0.0, 180.0, 180.0, 90.0};
    keep = sc_place(b, sx * (HALL_A + corner), 0.0, sz * (HALL_C + (sx ? corner : 0.055)), turns[i]);
    sc_use(b, HALL_LEATHER);
    hall_pocket_iron(b, sx != 0);
    hall_pocket_net(b);
    b->at = keep;
  }
  b->at = bed;
}

/* Digits as strokes through points of a grid, 4 wide and 6 high: x and y of each. */
static void hall_digit(sc_build *b, uint32_t digit, double x, double size) {
  static const char *const strokes[10] = {"103041453616050110", "042620", "05163645430040", "0516364544334241301001",
      "30360242", "460603334241301001", "36160501103041423303", "064610", "13040516364544331302011030414233",
      "10304145361605041343"};
  const char *p = strokes[digit];
  double thick = 0.36, r = HALL_BALL + 0.0005;
  for (; p[2]; p += 2) {
    double x0 = p[0] - '2', y0 = p[1] - '3', x1 = p[2] - '2', y1 = p[3] - '3';
    double dx = x1 - x0, dy = y1 - y0, l = thick / sqrt(dx * dx + dy * dy);
    sc_mark mark = sc_begin(b);
    uint32_t k;
    for (k = 0; k < 4; k++) { /* the corners around it, thrown onto the ball */
      double along = k == 1 || k == 2 ? l : -l, aside = k < 2 ? -l : l;
      double u = size * ((along > 0.0 ? x1 : x0) + along * dx - aside * dy) + x;
      double v = size * ((along > 0.0 ? y1 : y0) + along * dy + aside * dx);
      sc_v3 n = sc_unit(sc_v(u, sqrt(r * r - u * u - v * v), -v));
      sc_vertex(b, sc_mul(n, r), n);
    }
    sc_triangle(b, mark.vertex, mark.vertex + 1, mark.vertex + 2);
    sc_triangle(b, mark.vertex, mark.vertex + 2, mark.vertex + 3);
  }
}

/* A ball at the origin; 0 is the cue ball, 9 to 15 have a band. The discs of the numbers are caps that stand out a
   quarter of a millimetre. `rows`: a third of all rows. `kinds`: ball, ivory, ink. */
static void hall_ball_of(sc_build *b, uint32_t number, uint32_t rows, const uint32_t *kinds) {
  sc_frame keep = b->at;
  uint32_t k;
  sc_turn_z(b, 70.0 * sc_random(&b->random) + 10.0);
  sc_turn_x(b, 360.0 * sc_random(&b->random));
  sc_use(b, kinds[0]);
  sc_sphere_band(
      b, HALL_BALL, number > 8 ? 60.0 : 0.0, number > 8 ? 120.0 : 180.0, number > 8 ? rows : 3 * rows, 6 * rows);
  sc_use(b, kinds[1]);
  if (number > 8) sc_sphere_band(b, HALL_BALL, 0.0, 60.0, rows, 6 * rows);
  if (number > 8) sc_sphere_band(b, HALL_BALL, 120.0, 180.0, rows, 6 * rows);
  for (k = 0; k < 2 && number; k++) {
    sc_turn_z(b, 90.0 + 90.0 * k);
    sc_use(b, kinds[1]);
    sc_sphere_band(b, HALL_BALL + 0.00025, 0.0, 24.0, 3, 2 * rows + 2);
    sc_use(b, kinds[2]);
    if (number > 9) hall_digit(b, 1, -0.0036, 0.0015);
    hall_digit(b, number % 10, number > 9 ? 0.0032 : 0.0, number > 9 ? 0.0015 : 0.0020);
  }
  b->at = keep;
}

/* `facing`: about where one of its numbers shows to, as a yaw; 0: anywhere. */
static void hall_ball(sc_build *b, uint32_t number, double x, double z, uint32_t rows, double facing) {
  double turn = sc_random(&b->random);
  sc_frame keep = sc_place(b, x, HALL_BALL, z, facing != 0.0 ? facing + 110.0 * (turn - 0.5) : 360.0 * turn);
  uint32_t kinds[3] = {HALL_IVORY, HALL_IVORY, HALL_INK};
  if (number) kinds[0] = (uint32_t)HALL_BALL_1 + (number - 1) % 8;
  hall_ball_of(b, number, rows, kinds);
  b->at = keep;
}

/* A cue, tip at the origin, 1.47 m along y. */
static void hall_cue(sc_build *b) {
  static const double tip[][3] = {{0, 0}, {4.5, 1}, {6.2, 4}, {6.2, 10, 1}};
  static const double ferrule[][3] = {{6.3, 10, 1}, {6.5, 35, 1}};
  static const double shaft[][3] = {{6.5, 35, 1}, {6.8, 300}, {10.5, 740, 1}};
  static const double butt[][3] = {
      {10.8, 740, 1}, {11.2, 760, 1}, {12.8, 1100}, {14.8, 1450}, {14.5, 1465}, {12, 1470}, {0, 1470}};
  static const double ring[][3] = {{10.8, 735, 1}, {11.8, 737, 1}, {11.8, 760, 1}, {11, 762, 1}};
  sc_use(b, HALL_CHALK);
  SC_LATHE(b, 14, tip, 1);
  sc_use(b, HALL_IVORY);
  SC_LATHE(b, 14, ferrule, 1);
  sc_use(b, HALL_MAPLE);
  SC_LATHE(b, 14, shaft, 3);
  sc_use(b, HALL_RAIL);
  SC_LATHE(b, 14, butt, 2);
  sc_use(b, HALL_BRASS);
  SC_LATHE(b, 14, ring, 1);
}

/* A cue that lies with its tip on the cloth and on the rail towards (x1, z1); both in the frame of the bed. */
static void hall_cue_on_rail(sc_build *b, double x0, double z0, double x1, double z1, double rise) {
  sc_frame keep = sc_aim(b, sc_v(x0, 0.0068, z0), sc_v(x1, 0.0068 + rise, z1));
  hall_cue(b);
  b->at = keep;
}

static void hall_chalk(sc_build *b, double x, double z, double yaw) {
  sc_frame keep = sc_place(b, x, 0.0475, z, yaw);
  sc_use(b, HALL_CHALK);
  sc_box(b, -0.011, 0.0, -0.011, 0.011, 0.021, 0.011, 0.0015);
  b->at = keep;
}

/* The wooden triangle, its apex ball at the origin and pointing to -x. */
static void hall_triangle(sc_build *b) {
  static const double wood[][3] = {{16, 4}, {17, 30}, {14, 45}, {9, 49}, {3, 45}, {1, 30}, {1, 4, 1}, {16, 4, 1}};
  double side = 8.0 * HALL_BALL;
  sc_frame f[21];
  sc_pt round[SC_MAX_POINTS];
  uint32_t count = sc_round(wood, SC_COUNT(wood), 2, round), i, n = 0, corner;
  for (corner = 0; corner < 3; corner++)
    for (i = 0; i < 7; i++, n++) { /* around the corner balls, clockwise from above */
      double cx = corner == 0 ? 0.0 : side * sc_cos(30.0), cz = corner == 0 ? 0.0 : side * (corner == 1 ? -0.5 : 0.5);
      double a = 120.0 + 120.0 * corner + 20.0 * i;
      f[n].x = sc_v(sc_cos(a), 0.0, sc_sin(a)), f[n].y = sc_v(0.0, 1.0, 0.0);
      f[n].o = sc_add(sc_v(cx, 0.0, cz), sc_mul(f[n].x, HALL_BALL + 0.001));
    }
  sc_use(b, HALL_CARVED);
  sc_sweep(b, f, n, true, round, count, false, 1);
}

static void hall_rack_balls(sc_build *b) {
  static const uint32_t order[15] = {1, 9, 2, 10, 8, 3, 11, 7, 14, 4, 5, 13, 15, 6, 12};
  uint32_t row, k, n = 0;
  for (row = 0; row < 5; row++)
    for (k = 0; k <= row; k++)
      hall_ball(b, order[n++], row * 2.0004 * HALL_BALL * sc_cos(30.0), (k - row / 2.0) * 2.0004 * HALL_BALL, 5, 0.0);
}

/* A lamp over a table: three shades under a bar that hangs on two rods. The mouth of the shades is at y = 0; a bowl of
   frosted glass in each holds the bulb. `light`: the kind of the middle bowl. */
static void hall_lamp(sc_build *b, double ceiling, uint32_t light) {
  static const double shade[][3] = {
      {232, -4, 1}, {236, 0}, {232, 12}, {205, 50}, {140, 105}, {80, 145}, {52, 175}, {46, 200, 1}};
  static const double inside[][3] = {
      {46, 195, 1}, {50, 172}, {78, 141}, {138, 101}, {202, 46}, {229, 10}, {231, -4, 1}};
  static const double cap[][3] = {
      {50, 185, 1}, {52, 200}, {45, 215}, {28, 225, 1}, {24, 240}, {28, 255}, {18, 270}, {12, 300, 1}};
  static const double bulb[][3] = {{0, -22}, {60, -16}, {115, 4}, {150, 30, 1}};
  static const double rose[][3] = {{0, 0, 1}, {12, 0, 1}, {30, 20}, {55, 35}, {60, 50, 1}};
  static const double finial[][3] = {{0, 0}, {12, 6}, {24, 22}, {16, 40}, {10, 50, 1}};
  double bar = 0.40;
  int i;
  for (i = -1; i <= 1; i++) {
    sc_frame keep = sc_place(b, 0.72 * i, 0.0, 0.0, 0.0);
    sc_use(b, HALL_ENAMEL);
    SC_LATHE(b, 48, shade, 2);
    sc_use(b, HALL_OPAL);
    SC_LATHE(b, 48, inside, 1);
    sc_use(b, i ? (uint32_t)HALL_BULB : light);
    SC_LATHE(b, 40, bulb, 1);
    sc_use(b, HALL_BRASS);
    SC_LATHE(b, 24, cap, 1);
    sc_torus(b, -0.002, 0.234, 0.0045, 48, 5);
    sc_rod(b, sc_v(0, 0.29, 0), sc_v(0, bar, 0), 0.008, 10);
    b->at = keep;
  }
  sc_rod(b, sc_v(-0.86, bar, 0), sc_v(0.86, bar, 0), 0.015, 14);
  for (i = -1; i <= 1; i += 2) {
    sc_frame keep = sc_place(b, 0.86 * i, bar, 0.0, 0.0);
    sc_turn_z(b, 90.0 * i);
    SC_LATHE(b, 14, finial, 2);
    b->at = keep;
    sc_rod(b, sc_v(0.36 * i, bar, 0), sc_v(0.36 * i, ceiling, 0), 0.007, 8);
    keep = sc_place(b, 0.36 * i, ceiling - 0.05, 0, 0);
    SC_LATHE(b, 20, rose, 2);
    b->at = keep;
    keep = sc_place(b, 0.36 * i, bar, 0, 0);
    sc_turn_z(b, 90.0);
    sc_torus(b, 0.0, 0.02, 0.006, 16, 6);
    b->at = keep;
  }
}

/* A bottle of one of four kinds. */
static void hall_bottle(sc_build *b, uint32_t kind, uint32_t material) {
  /* clang-format off */
  static const double shapes[4][10][3] = {
    {{0, 4, 1}, {34, 0}, {37, 6}, {37, 185}, {33, 210}, {16, 245}, {13.5, 300, 1}, {16, 302, 1}, {16, 312, 1},
        {0, 312, 1}},
    {{0, 4, 1}, {40, 0}, {43, 6}, {43, 160}, {41, 180}, {18, 200}, {14.5, 250, 1}, {18, 252, 1}, {18, 268, 1},
        {0, 268, 1}},
    {{0, 4, 1}, {50, 0}, {55, 10}, {52, 80}, {35, 130}, {16, 170}, {14, 220, 1}, {19, 223, 1}, {19, 235, 1},
        {0, 235, 1}},
    {{0, 4, 1}, {28, 0}, {31, 5}, {31, 130}, {27, 160}, {14, 195}, {12.5, 235, 1}, {14.5, 237, 1}, {14.5, 246, 1},
        {0, 246, 1}}};
  /* clang-format on */
  static const double cork[][3] = {{11, 0, 1}, {11, 14}, {8, 17}, {0, 17}};
  static const double label[4][3] = {{38, 60, 150}, {44, 50, 140}, {0, 0, 0}, {32, 40, 110}};
  sc_frame keep;
  uint32_t i;
  sc_use(b, material);
  SC_LATHE(b, 22, shapes[kind], 2);
  sc_use(b, HALL_LABEL);
  if (label[kind][0] > 0.0) {
    double paper[4][3] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}}; /* its edges reach into the bottle */
    for (i = 0; i < 4; i++)
      paper[i][0] = label[kind][0] - (i % 3 ? 0.0 : 2.0), paper[i][1] = label[kind][i < 2 ? 1 : 2];
    sc_lathe_around(b, 0.0, 0.0, 22, (const double(*)[3])paper, 4, 1);
  }
  sc_use(b, HALL_GILT);
  keep = sc_place(b, 0, 0.001 * shapes[kind][9][1], 0, 0);
  SC_LATHE(b, 14, cork, 1);
  b->at = keep;
}

static void hall_glass(sc_build *b, bool stem) {
  static const double pint[][3] = {
      {0, 0, 1}, {27, 0, 1}, {29, 4}, {31, 60}, {40, 145}, {39, 147}, {37, 145}, {28, 60}, {26, 12}, {0, 10}};
  static const double wine[][3] = {{0, 0, 1}, {33, 0, 1}, {32, 3}, {8, 7}, {4, 20}, {4, 75}, {10, 88}, {34, 115},
      {37, 145}, {31, 175, 1}, {29, 175, 1}, {35, 145}, {32, 117}, {0, 92}};
  sc_use(b, HALL_CLEAR_GLASS);
  if (stem) SC_LATHE(b, 20, wine, 2);
  else SC_LATHE(b, 24, pint, 1);
}

/* A glass that holds something. Its surface ends where the liquid begins; there liquid meets glass. */
typedef double hall_profile[8][3];
static void hall_drink(
    sc_build *b, const hall_profile dry, const hall_profile wet, uint32_t n, uint32_t kind_in_glass, uint32_t kind) {
  double level[2][3] = {{0, 0, 1}, {0, 0, 1}};
  level[0][0] = wet[n - 1][0], level[0][1] = level[1][1] = wet[n - 1][1];
  sc_use(b, HALL_TUMBLER);
  sc_lathe_around(b, 0.0, 0.0, 56, dry, 8, 3);
  sc_use(b, kind_in_glass);
  sc_lathe_around(b, 0.0, 0.0, 56, wet, n, 3);
  sc_use(b, kind);
  sc_lathe_around(b, 0.0, 0.0, 56, (const double(*)[3])level, 2, 1);
}
static void hall_whisky(sc_build *b) {
  static const hall_profile dry = {
      {0, 0, 1}, {33, 0}, {37, 4}, {40, 50}, {41.5, 90}, {40.5, 91.2}, {39.3, 90}, {36.6, 40, 1}};
  static const hall_profile wet = {{0, 13, 1}, {26, 13.5}, {33, 16}, {34.8, 22}, {36.6, 40, 1}};
  hall_drink(b, dry, wet, 5, HALL_WHISKY_IN_GLASS, HALL_WHISKY);
}
static void hall_beer(sc_build *b) {
  static const hall_profile dry = {
      {0, 0, 1}, {28, 0}, {31, 4}, {33, 60}, {41, 146}, {40, 148}, {38.8, 146}, {37.2, 130, 1}};
  static const hall_profile wet = {{0, 9, 1}, {24, 9.5}, {28, 14}, {29.5, 60}, {37.2, 130, 1}};
  static const double foam[][3] = {{37.1, 118, 1}, {37.1, 130}, {37.4, 136}, {30, 141}, {12, 142}, {0, 142}};
  hall_drink(b, dry, wet, 5, HALL_BEER_IN_GLASS, HALL_FOAM);
  sc_use(b, HALL_FOAM);
  SC_LATHE(b, 40, foam, 2);
}

static void hall_stool(sc_build *b) {
  static const double base[][3] = {{0, 0, 1}, {200, 0, 1}, {205, 6}, {195, 16}, {120, 30}, {45, 48}, {34, 75},
      {30, 110, 1}, {24, 112, 1}, {24, 620, 1}, {36, 640}, {70, 690}, {110, 705, 1}};
  static const double seat[][3] = {{0, 715}, {150, 715}, {178, 725}, {184, 750}, {172, 775}, {110, 790}, {0, 793}};
  static const double band[][3] = {
      {165, 700, 1}, {180, 700, 1}, {183, 708}, {180, 722, 1}, {165, 724, 1}, {165, 700, 1}};
  uint32_t i;
  sc_use(b, HALL_STEEL);
  SC_LATHE(b, 28, base, 2);
  sc_torus(b, 0.28, 0.155, 0.010, 36, 8);
  for (i = 0; i < 4; i++)
    sc_rod(b, sc_v(0, 0.28, 0), sc_v(0.15 * sc_cos(90.0 * i + 20.0), 0.28, 0.15 * sc_sin(90.0 * i + 20.0)), 0.007, 8);
  sc_use(b, HALL_BRASS);
  SC_LATHE(b, 36, band, 2);
  sc_use(b, HALL_SEAT);
  SC_LATHE(b, 36, seat, 3);
}

/* A bentwood chair, looking to +z. */
static void hall_chair(sc_build *b) {
  static const double rim[][3] = {
      {170, 435, 1}, {198, 435, 1}, {207, 445}, {206, 465}, {196, 471}, {170, 468, 1}, {170, 435, 1}};
  static const double pad[][3] = {{0, 450, 1}, {172, 450, 1}, {172, 466}, {155, 476}, {100, 482}, {0, 484}};
  static const double outer[11][3] = {{-0.185, 0, -0.235}, {-0.172, 0.22, -0.20}, {-0.160, 0.44, -0.165},
      {-0.172, 0.62, -0.19}, {-0.168, 0.78, -0.225}, {-0.10, 0.885, -0.25}, {0.10, 0.885, -0.25}, {0.168, 0.78, -0.225},
      {0.172, 0.62, -0.19}, {0.160, 0.44, -0.165}, {0.172, 0.22, -0.20}};
  static const double inner[9][3] = {{-0.10, 0.46, -0.175}, {-0.105, 0.58, -0.19}, {-0.10, 0.70, -0.212},
      {-0.06, 0.78, -0.228}, {0.0, 0.805, -0.235}, {0.06, 0.78, -0.228}, {0.10, 0.70, -0.212}, {0.105, 0.58, -0.19},
      {0.10, 0.46, -0.175}};
  sc_v3 p[12];
  int i;
  sc_use(b, HALL_BENTWOOD);
  for (i = 0; i < 11; i++) p[i] = sc_v(outer[i][0], outer[i][1], outer[i][2]);
  p[11] = sc_v(0.185, 0.0, -0.235);
  sc_tube(b, p, 12, 4, false, 0.0145, 0.0145, 10);
  for (i = 0; i < 9; i++) p[i] = sc_v(inner[i][0], inner[i][1], inner[i][2]);
  sc_tube(b, p, 9, 3, false, 0.010, 0.010, 8);
  for (i = -1; i <= 1; i += 2) {
    p[0] = sc_v(0.135 * i, 0.45, 0.12), p[1] = sc_v(0.155 * i, 0.22, 0.155), p[2] = sc_v(0.175 * i, 0.0, 0.19);
    sc_tube(b, p, 3, 3, false, 0.017, 0.0125, 10);
  }
  sc_torus(b, 0.26, 0.19, 0.009, 32, 7);
  SC_LATHE(b, 36, rim, 2);
  sc_use(b, HALL_SEAT);
  SC_LATHE(b, 36, pad, 2);
}

static void hall_cafe_table(sc_build *b) {
  static const double top[][3] = {{0, 715, 1}, {340, 715, 1}, {352, 722}, {352, 735}, {340, 742, 1}, {0, 742, 1}};
  static const double column[][3] = {{0, 100, 1}, {45, 100}, {50, 140}, {28, 180}, {32, 240}, {55, 340}, {45, 420},
      {26, 500, 1}, {35, 505}, {35, 520, 1}, {26, 525, 1}, {30, 600}, {60, 690}, {140, 716, 1}};
  uint32_t i;
  sc_use(b, HALL_BAR_TOP);
  SC_LATHE(b, 56, top, 2);
  sc_use(b, HALL_CARVED);
  SC_LATHE(b, 28, column, 2);
  for (i = 0; i < 3; i++) {
    sc_frame keep = sc_place(b, 0, 0, 0, 120.0 * i);
    sc_v3 p[5];
    p[0] = sc_v(0, 0.15, 0.02), p[1] = sc_v(0, 0.17, 0.10), p[2] = sc_v(0, 0.10, 0.20), p[3] = sc_v(0, 0.025, 0.28),
    p[4] = sc_v(0, 0.018, 0.33);
    sc_tube(b, p, 5, 4, false, 0.024, 0.016, 10);
    b->at = keep;
  }
}

/* Beer tap: a column with three handles. */
static void hall_tap(sc_build *b) {
  static const double column[][3] = {
      {0, 0, 1}, {70, 0, 1}, {72, 12}, {50, 25}, {38, 50}, {36, 250}, {46, 280}, {44, 330}, {25, 360}, {0, 370}};
  static const double handle[][3] = {{6, 0, 1}, {7, 30}, {14, 60}, {17, 130}, {12, 170}, {0, 180}};
  int i;
  sc_use(b, HALL_BRASS);
  SC_LATHE(b, 28, column, 3);
  for (i = -1; i <= 1; i++) {
    sc_frame keep = sc_place(b, 0, 0.30, 0, 35.0 * i);
    sc_v3 p[4];
    p[0] = sc_v(0, 0, -0.03), p[1] = sc_v(0, 0.005, -0.09), p[2] = sc_v(0, -0.01, -0.12), p[3] = sc_v(0, -0.06, -0.125);
    sc_use(b, HALL_BRASS);
    sc_tube(b, p, 4, 3, false, 0.012, 0.008, 10);
    sc_place(b, 0, 0.012, -0.085, 0.0);
    sc_use(b, HALL_BALL_8);
    SC_LATHE(b, 16, handle, 2);
    b->at = keep;
  }
}

/* Counter with its front towards +z, from x = -w to w; origin on the floor below the front. */
static void hall_counter(sc_build *b, double w) {
  static const double slab[][3] = {{0, 1060, 1}, {30, 1060, 1}, {42, 1066}, {42, 1098}, {30, 1110, 1}, {0, 1110, 1}};
  static const double foot[][3] = {{30, 0, 1}, {30, 120, 1}, {22, 140}, {10, 145, 1}, {0, 145, 1}};
  static const double under[][3] = {{0, 950, 1}, {15, 955}, {25, 980}, {50, 1020}, {75, 1040, 1}, {85, 1062, 1}};
  static const double bead[][3] = {{16, 0, 1}, {12, 12}, {0, 16}, {-10, 11}, {-16, 0, 1}};
  sc_pt path[4] = {{0, 0, 1}, {0, 0, 1}, {0, 0, 1}, {0, 0, 1}};
  uint32_t n = 8, i;
  sc_frame keep;
  sc_use(b, HALL_PANEL);
  sc_box(b, -w, 0.0, -0.55, w, 1.065, 0.0, 0.004);
  sc_use(b, HALL_BAR_TOP);
  keep = sc_place(b, 0, 0, -0.25, 0);
  sc_lathe_around(b, w + 0.06, 0.36, 32, slab, SC_COUNT(slab), 3);
  b->at = keep;
  path[0].x = path[3].x = w, path[1].x = path[2].x = -w, path[2].y = path[3].y = -0.55;
  sc_use(b, HALL_TRIM);
  sc_moulding(b, path, 4, true, foot, SC_COUNT(foot), 2);
  sc_moulding(b, path, 4, true, under, SC_COUNT(under), 3);
  for (i = 0; i <= n; i++) { /* pilasters, panels between them */
    double x = -w + 2.0 * w * i / n, step = 2.0 * w / n;
    sc_use(b, HALL_TRIM);
    sc_box(b, x - 0.055 + (i == 0 ? 0.055 : 0), 0.14, -0.01, x + 0.055 - (i == n ? 0.055 : 0), 0.955, 0.022, 0.006);
    if (i == n) break;
    keep = sc_place(b, 0, 0, 0, 0);
    sc_border(b, x + 0.11, 0.22, x + step - 0.11, 0.88, bead, SC_COUNT(bead), 2);
    sc_use(b, HALL_PANEL);
    sc_box(b, x + 0.15, 0.26, -0.02, x + step - 0.15, 0.84, 0.013, 0.011);
    b->at = keep;
  }
  sc_use(b, HALL_BRASS); /* foot rail */
  sc_rod(b, sc_v(-w - 0.02, 0.22, 0.17), sc_v(w + 0.02, 0.22, 0.17), 0.022, 16);
  for (i = 0; i <= n; i += 2) {
    double x = -w + 0.06 + (2.0 * w - 0.12) * i / n;
    sc_v3 p[4];
    p[0] = sc_v(x, 0.30, 0.015), p[1] = sc_v(x, 0.31, 0.07), p[2] = sc_v(x, 0.28, 0.13), p[3] = sc_v(x, 0.23, 0.17);
    sc_tube(b, p, 4, 3, false, 0.012, 0.012, 10);
  }
  for (i = 0; i < 2; i++) {
    keep = sc_place(b, (i ? 0.45 : -0.55) * w, 1.11, -0.2, 0.0);
    hall_tap(b);
    b->at = keep;
  }
}

/* Cupboard and shelves with bottles along a wall (z = 0), from x = -w to w. */
static void hall_back_bar(sc_build *b, double w) {
  static const double crown[][3] = {
      {0, 2500, 1}, {12, 2505}, {30, 2540}, {60, 2580}, {75, 2600, 1}, {85, 2600, 1}, {85, 2640, 1}, {0, 2640, 1}};
  static const double column[][3] = {{50, 960, 1}, {52, 990}, {45, 1010, 1}, {36, 1020}, {34, 1100}, {40, 1500},
      {32, 2300, 1}, {42, 2310}, {50, 2340}, {50, 2360, 1}};
  static const uint32_t glass[4] = {HALL_GREEN_GLASS, HALL_BROWN_GLASS, HALL_CLEAR_GLASS, HALL_BROWN_GLASS};
  sc_pt path[4] = {{0, 0.01, 1}, {0, 0.42, 1}, {0, 0.42, 1}, {0, 0.01, 1}};
  uint32_t i, k, bays = 4, doors = 8;
  path[0].x = path[1].x = w, path[2].x = path[3].x = -w;
  sc_use(b, HALL_PANEL);
  sc_box(b, -w, 0.0, 0.01, w, 0.93, 0.45, 0.004);
  sc_box(b, -w, 0.93, 0.01, w, 2.55, 0.05, 0.0);
  sc_box(b, -w, 2.36, 0.01, w, 2.60, 0.42, 0.004);
  sc_use(b, HALL_MIRROR);
  sc_quad(b, sc_v(-w, 0.95, 0.051), sc_v(w, 0.95, 0.051), sc_v(w, 2.38, 0.051), sc_v(-w, 2.38, 0.051));
  sc_use(b, HALL_BAR_TOP);
  sc_box(b, -w - 0.03, 0.925, 0.01, w + 0.03, 0.965, 0.49, 0.006);
  sc_use(b, HALL_TRIM);
  sc_moulding(b, path, 4, false, crown, SC_COUNT(crown), 3);
  for (i = 0; i < doors; i++) {
    double x = -w + 2.0 * w * i / doors, step = 2.0 * w / doors;
    sc_box(b, x + 0.02, 0.10, 0.40, x + step - 0.02, 0.86, 0.462, 0.004);
    sc_use(b, HALL_PANEL);
    sc_box(b, x + 0.10, 0.18, 0.42, x + step - 0.10, 0.78, 0.472, 0.010);
    sc_use(b, HALL_TRIM);
  }
  for (k = 0; k < 3; k++) sc_box(b, -w, 1.30 + 0.36 * k, 0.04, w, 1.325 + 0.36 * k, 0.30, 0.004);
  sc_use(b, HALL_OPAL); /* a strip light below each shelf */
  for (k = 0; k < 4; k++) sc_box(b, -w + 0.1, 1.288 + 0.36 * k, 0.06, w - 0.1, 1.301 + 0.36 * k, 0.085, 0.002);
  sc_use(b, HALL_CARVED);
  for (i = 0; i <= bays; i++) {
    double x = -w + 0.06 + (2.0 * w - 0.12) * i / bays;
    sc_frame keep = sc_place(b, x, 0.0, 0.34, 0.0);
    SC_LATHE(b, 24, column, 1);
    sc_box(b, -0.012, 0.96, -0.30, 0.012, 2.37, -0.045, 0.0);
    b->at = keep;
  }
  for (k = 0; k < 4; k++)
    for (i = 0; i < 18; i++) {
      double x = -w + 0.17 + (2.0 * w - 0.34) * (i + 0.5) / 18.0 + 0.03 * (sc_random(&b->random) - 0.5);
      double z = k ? 0.17 : 0.22, gap = (2.0 * w - 0.12) / bays, from = -w + 0.06, at = (x - from) / gap;
      uint32_t kind = (uint32_t)(4.0 * sc_random(&b->random)), pick = (uint32_t)(4.0 * sc_random(&b->random));
      sc_frame keep;
      if (at - floor(at) < 0.09 || at - floor(at) > 0.91) continue; /* a column stands here */
      keep = sc_place(b, x, k ? 0.966 + 0.36 * k - 0.001 : 0.966, z, 40.0 * sc_random(&b->random));
      if (k == 2 && i % 3) hall_glass(b, true);
      else hall_bottle(b, kind, glass[pick]);
      b->at = keep;
    }
}

/* Wall rack for cues. */
static void hall_cue_rack(sc_build *b, double x, uint32_t cues) {
  double w = 0.09 * cues / 2.0 + 0.05;
  uint32_t i;
  sc_frame keep = sc_place(b, x, 0.0, 0.0, 0.0);
  sc_use(b, HALL_CARVED);
  sc_box(b, -w, 1.12, 0.0, w, 2.62, 0.018, 0.006);
  sc_box(b, -w - 0.02, 1.10, 0.0, w + 0.02, 1.14, 0.12, 0.008);
  sc_box(b, -w - 0.02, 2.20, 0.0, w + 0.02, 2.235, 0.085, 0.008);
  sc_box(b, -w - 0.04, 2.60, 0.0, w + 0.04, 2.66, 0.06, 0.01);
  for (i = 0; i < cues; i++) {
    double cx = (i - (cues - 1) / 2.0) * 0.09;
    sc_frame inner = sc_aim(b, sc_v(cx, 2.611, 0.095), sc_v(cx, 1.141, 0.085));
    hall_cue(b);
    b->at = inner;
  }
  b->at = keep;
}

/* A framed landscape: sky, sun and three ridges, millimetres in front of each other. */
static void hall_picture(sc_build *b, double x, double y, double w, double h) {
  static const double frame[][3] = {
      {70, 0, 1}, {70, 20, 1}, {62, 34}, {50, 38}, {40, 28, 1}, {18, 18}, {12, 22}, {0, 18, 1}, {-4, 6, 1}};
  static const double sun[][3] = {{50, 0, 1}, {50, 0.5, 1}, {0, 0.5, 1}};
  sc_frame keep = sc_place(b, x, y, 0.0, 0.0);
  uint32_t ridge, i, n = 14;
  double phase = 360.0 * sc_random(&b->random);
  sc_use(b, HALL_GILT);
  sc_border(b, 0, 0, w, h, frame, SC_COUNT(frame), 2);
  sc_use(b, HALL_SKY);
  sc_quad(b, sc_v(0, 0, 0.007), sc_v(w, 0, 0.007), sc_v(w, h, 0.007), sc_v(0, h, 0.007));
  for (ridge = 0; ridge < 3; ridge++) {
    double z = 0.008 + 0.001 * ridge, x0 = 0.0, y0 = 0.0;
    sc_use(b, ridge == 0 ? HALL_SLATE : ridge == 1 ? HALL_HILL : HALL_PLANK_3);
    for (i = 0; i <= n; i++) {
      double x1 = w * i / n, y1 = h * (0.5 - 0.16 * ridge + 0.07 * sc_sin(phase + 500.0 * i / n + 130.0 * ridge) +
                                          0.03 * sc_sin(1300.0 * i / n + phase));
      if (i) sc_quad(b, sc_v(x0, 0, z), sc_v(x1, 0, z), sc_v(x1, y1, z), sc_v(x0, y0, z));
      x0 = x1, y0 = y1;
    }
  }
  sc_use(b, HALL_IVORY);
  sc_place(b, w * 0.68, h * 0.74, 0.0075, 0.0);
  sc_turn_x(b, 90.0);
  SC_LATHE(b, 28, sun, 1);
  b->at = keep;
}

/* Dart board: 20 sectors of six rings, then the bull; wires are left out. */
static void hall_dart_board(sc_build *b, double x, double y) {
  static const double rings[7] = {0.016, 0.099, 0.107, 0.162, 0.170, 0.20, 0.225};
  static const double bull[][3] = {{6.5, 0, 1}, {6.5, 1.5, 1}, {0, 1.5, 1}};
  static const double outer[][3] = {{16, 0, 1}, {16, 0.8, 1}, {0, 0.8, 1}};
  static const double body[][3] = {{228, -40, 1}, {228, -4}, {224, 0}, {222, -2, 1}};
  sc_frame keep = sc_place(b, x, y, 0.04, 0.0);
  uint32_t ring, i, k;
  for (ring = 0; ring < 6; ring++)
    for (i = 0; i < 20; i++) {
      bool narrow = ring == 1 || ring == 3, odd = i & 1;
      sc_use(b, ring >= 4 ? HALL_BALL_8
                : narrow  ? (odd ? HALL_BALL_6 : HALL_BALL_3)
                          : (odd ? HALL_IVORY : HALL_BALL_8));
      for (k = 0; k < 3; k++) {
        double a = 18.0 * i + 6.0 * k - 9.0, d = a + 6.0, r = rings[ring], s = rings[ring + 1];
        sc_quad(b, sc_v(r * sc_cos(a), r * sc_sin(a), 0), sc_v(s * sc_cos(a), s * sc_sin(a), 0),
            sc_v(s * sc_cos(d), s * sc_sin(d), 0), sc_v(r * sc_cos(d), r * sc_sin(d), 0));
      }
    }
  sc_turn_x(b, 90.0);
  sc_use(b, HALL_BALL_6);
  SC_LATHE(b, 24, outer, 1);
  sc_use(b, HALL_BALL_3);
  SC_LATHE(b, 16, bull, 1);
  sc_use(b, HALL_BALL_8);
  SC_LATHE(b, 60, body, 1);
  b->at = keep;
}

/* Scoreboard: a slate in a frame, beads on two wires above it. */
static void hall_scoreboard(sc_build *b, double x, double y) {
  sc_frame keep = sc_place(b, x, y, 0.0, 0.0), bead;
  uint32_t wire, i;
  sc_use(b, HALL_CARVED);
  sc_border(b, 0.0, 0.0, 1.3, 0.85, hall_casing, SC_COUNT(hall_casing) - 1, 2);
  sc_use(b, HALL_SLATE);
  sc_quad(b, sc_v(0, 0, 0.01), sc_v(1.3, 0, 0.01), sc_v(1.3, 0.85, 0.01), sc_v(0, 0.85, 0.01));
  for (wire = 0; wire < 2; wire++) {
    double h = 0.74 - 0.09 * wire;
    sc_use(b, HALL_STEEL);
    sc_rod(b, sc_v(0.0, h, 0.035), sc_v(1.3, h, 0.035), 0.002, 6);
    for (i = 0; i < 30; i++) {
      sc_use(b, i % 10 == 4 ? HALL_BALL_8 : wire ? HALL_BALL_3 : HALL_IVORY);
      bead = sc_place(b, i < 11 + 7 * wire ? 0.06 + 0.025 * i : 1.24 - 0.025 * (29 - i), h, 0.035, 0.0);
      sc_turn_z(b, 90.0);
      sc_sphere_band(b, 0.012, 0.0, 180.0, 5, 10);
      b->at = bead;
    }
  }
  b->at = keep;
}

static const double hall_fans[2][3] = {{9.0, 5.31, 31.0}, {5.0, 3.44, 0.0}}; /* x, z, yaw */

/* Ceiling fan with a lamp globe. */
static void hall_fan(sc_build *b, const double *at, uint32_t globe_kind, uint32_t wood, uint32_t brass) {
  static const double motor[][3] = {{0, -500, 1}, {50, -500, 1}, {90, -485}, {130, -460}, {140, -420}, {130, -380},
      {80, -345}, {30, -330, 1}, {18, -320, 1}, {18, -70, 1}, {30, -60}, {60, -30}, {70, 0, 1}};
  static const double globe[][3] = {{0, -665}, {50, -655}, {98, -610}, {105, -565}, {85, -520}, {60, -495, 1}};
  static const double blade[][3] = {{0, -4, 1}, {66, -4, 1}, {70, 0}, {66, 4, 1}, {0, 4, 1}};
  sc_frame outer = sc_place(b, at[0], HALL_Y, at[1], at[2]);
  uint32_t i;
  sc_use(b, HALL_CARVED);
  SC_LATHE(b, 36, motor, 2);
  sc_use(b, globe_kind);
  SC_LATHE(b, 36, globe, 3);
  for (i = 0; i < 5; i++) {
    sc_frame keep = sc_place(b, 0.0, -0.43, 0.0, 72.0 * i + 20.0);
    sc_use(b, brass);
    sc_box(b, 0.12, -0.006, -0.025, 0.26, 0.0, 0.025, 0.002);
    sc_place(b, 0.49, 0.0, 0.0, 0.0);
    sc_turn_x(b, 12.0);
    sc_use(b, wood);
    sc_lathe_around(b, 0.22, 0.001, 24, blade, SC_COUNT(blade), 2);
    b->at = keep;
  }
  b->at = outer;
}

static void hall_at(sc_build *b, double x, double y, double z, double yaw, void (*thing)(sc_build *)) {
  sc_frame keep = sc_place(b, x, y, z, yaw);
  thing(b);
  b->at = keep;
}

/* Positions of the balls on the two tables in play, in the frame of the bed; number first. */
static const double hall_play_1[9][3] = {{1, -0.72, -0.30}, {3, -0.14, -0.12}, {8, 0.44, 0.07}, {11, -0.85, 0.33},
    {5, 0.83, -0.36}, {14, 0.63, 0.38}, {6, -0.33, -0.42}, {15, -1.05, -0.08}, {4, -0.05, 0.05}};
static const double hall_play_3[10][3] = {{0, 0.55, -0.25}, {7, -0.80, 0.42}, {10, 0.20, 0.40}, {8, -0.30, 0.10},
    {13, -0.95, -0.22}, {2, 0.90, 0.30}, {5, -0.10, -0.40}, {14, 0.35, 0.02}, {1, -0.55, -0.10}, {12, 1.10, -0.50}};

/* Balls of the first table that move: the cue ball to and fro between the cushions, 9 and 2 in turn between a cushion
   and each other, 12 on its spot like a top. Number, x, and z at time 0; of 9 and 2, z where they meet. */
enum { HALL_CUE_BALL, HALL_ROLLING_9, HALL_ROLLING_2, HALL_SPINNING_12, HALL_MOVING_BALLS };
static const double hall_moving[HALL_MOVING_BALLS][3] = {
    {0, -0.42, 0.20}, {9, 0.22, 0.0}, {2, 0.22, 0.0}, {12, -0.98, 0.12}};

#define HALL_TO_CAMERA 225.0
static const double hall_tables[3][3] = {{4.0, 6.75, 0.0}, {9.1, 6.56, 0.0}, {6.7, 3.44, 0.0}}; /* x, z, yaw */

/* >>motion --------------------------------------------------------------------------------------------------------- */

/* Where ball `i` of hall_moving is along z. Each goes to its cushion and back at one speed, about 4 cm in a sixtieth of
   the loop. Of 9 and 2, one stands while the other is on its way, and takes over its speed when they meet. */
static double hall_ball_z(uint32_t i, double time) {
  double reach = HALL_C - HALL_BALL, z = hall_moving[i][2], t;
  if (i == HALL_SPINNING_12) return z;
  if (i == HALL_CUE_BALL) { /* t: way since it left the cushion at -reach, of 4 reach */
    t = z + reach + 4.0 * reach * time;
    t -= 4.0 * reach * floor(t / (4.0 * reach));
    return t < 2.0 * reach ? t - reach : 3.0 * reach - t;
  }
  t = time + (i == HALL_ROLLING_9 ? 0.15 : 0.65);
  t = 4.0 * (t - floor(t)) - 1.0; /* under way in [-1,1], at the cushion at 0 */
  t = HALL_BALL + (t > 1.0 ? 0.0 : (reach - HALL_BALL) * (1.0 - (t < 0.0 ? -t : t)));
  return i == HALL_ROLLING_9 ? z + t : z - t;
}

static sc_v3 hall_ball_at(uint32_t i, double time) { /* its centre in the room */
  return sc_v(hall_tables[0][0] + hall_moving[i][1], HALL_BED + HALL_BALL, hall_tables[0][1] + hall_ball_z(i, time));
}

/* The map from rest to the pose at `time` of what moves. A ball that was struck slides before it rolls: 9 and 2 turn
   0.6 times as fast as rolling asks. Nobody sees a plain cue ball turn. */
static sc_frame hall_motion(uint32_t kind, double time) {
  sc_frame f;
  sc_v3 from, to;
  double turn = 0.0;
  f.x = sc_v(1, 0, 0), f.y = sc_v(0, 1, 0), f.z = sc_v(0, 0, 1);
  if (kind >= HALL_MOVING) {
    uint32_t i = (kind - HALL_MOVING) / 3;
    from = hall_ball_at(i, 0.0), to = hall_ball_at(i, time);
    if (i == HALL_ROLLING_9 || i == HALL_ROLLING_2) turn = 0.6 * (to.z - from.z) / HALL_BALL * (180.0 / SC_PI);
    f.y = sc_v(0.0, sc_cos(turn), sc_sin(turn)), f.z = sc_v(0.0, -sc_sin(turn), sc_cos(turn));
    turn = i == HALL_SPINNING_12 ? 5.0 * 360.0 * time : 0.0;
  } else {
    uint32_t i = kind >= HALL_FAN_2_WOOD;
    from = to = sc_v(hall_fans[i][0], 0.0, hall_fans[i][1]);
    turn = (i ? -2.0 : 2.0) * 360.0 * time;
  }
  if (turn != 0.0) f.x = sc_v(sc_cos(turn), 0.0, -sc_sin(turn)), f.z = sc_v(sc_sin(turn), 0.0, sc_cos(turn));
  f.o = sc_sub(to, sc_add(sc_mul(f.x, from.x), sc_add(sc_mul(f.y, from.y), sc_mul(f.z, from.z))));
  return f;
}

static void poolhall_deform(const scene *s, const scene_mesh *m, double time, float *positions, float *normals) {
  sc_frame f = hall_motion(m->material, time - floor(time));
  uint32_t i;
  (void)s;
  for (i = 0; i < m->vertex_count; i++) {
    sc_v3 p = sc_get(m->positions, i), n = sc_get(m->normals, i);
    p = sc_add(f.o, sc_add(sc_mul(f.x, p.x), sc_add(sc_mul(f.y, p.y), sc_mul(f.z, p.z))));
    n = sc_add(sc_mul(f.x, n.x), sc_add(sc_mul(f.y, n.y), sc_mul(f.z, n.z)));
    positions[3 * i] = sc_snap(p.x), positions[3 * i + 1] = sc_snap(p.y), positions[3 * i + 2] = sc_snap(p.z);
    normals[3 * i] = sc_snap(n.x), normals[3 * i + 1] = sc_snap(n.y), normals[3 * i + 2] = sc_snap(n.z);
  }
}

static void hall_moving_balls(sc_build *b) { /* in the frame of the bed */
  uint32_t i, k;
  for (i = 0; i < HALL_MOVING_BALLS; i++) {
    uint32_t kinds[3];
    sc_frame keep = sc_place(b, hall_moving[i][1], HALL_BALL, hall_ball_z(i, 0.0), HALL_TO_CAMERA);
    for (k = 0; k < 3; k++) kinds[k] = HALL_MOVING + 3 * i + k;
    hall_ball_of(b, (uint32_t)hall_moving[i][0], 8, kinds);
    b->at = keep;
  }
}

/* >>furnishing ----------------------------------------------------------------------------------------------------- */

static void hall_games(sc_build *b) {
  sc_frame keep, bed;
  uint32_t i;
  for (i = 0; i < 3; i++) {
    uint32_t k;
    keep = sc_place(b, hall_tables[i][0], 0.0, hall_tables[i][1], hall_tables[i][2]);
    b->detail = i ? 0.55 : 1.0;
    hall_table(b);
    bed = sc_place(b, 0.0, HALL_BED, 0.0, 0.0);
    if (i == 0) {
      for (k = 0; k < SC_COUNT(hall_play_1); k++)
        hall_ball(b, (uint32_t)hall_play_1[k][0], hall_play_1[k][1], hall_play_1[k][2], 8, HALL_TO_CAMERA);
      hall_moving_balls(b);
      hall_at(b, -1.10, 0.047, 0.735, 0.0, hall_whisky);
      hall_at(b, 0.42, 0.047, 0.735, 0.0, hall_beer);
      hall_cue_on_rail(b, 0.42, -0.28, 1.22, 0.92, 0.090);
      hall_chalk(b, -0.55, 0.745, 20.0);
      hall_chalk(b, 0.42, -0.75, 50.0);
    } else if (i == 1) {
      sc_frame spot = sc_place(b, HALL_A / 2.0, 0.0, 0.0, 0.0);
      hall_rack_balls(b);
      hall_triangle(b);
      b->at = spot;
      b->at = spot;
      sc_place(b, -HALL_A, 0.0, 0.1, 0.0);
      hall_ball(b, 0, 0.0, 0.0, 5, 0.0);
      b->at = spot;
      hall_cue_on_rail(b, -0.35, 0.30, -1.28, -0.85, 0.090);
      hall_chalk(b, 0.25, 0.74, 10.0);
    } else {
      for (k = 0; k < SC_COUNT(hall_play_3); k++)
        hall_ball(b, (uint32_t)hall_play_3[k][0], hall_play_3[k][1], hall_play_3[k][2], 5, 0.0);
      hall_chalk(b, -0.2, 0.74, 30.0);
    }
    b->at = bed;
    sc_place(b, 0.0, 1.92, 0.0, 0.0);
    hall_lamp(b, HALL_Y - 1.92, HALL_LIGHT_1 + i);
    b->at = keep;
  }
}

static void hall_seats(sc_build *b) {
  static const double chairs[8][3] = {{13.55, 5.0, 100.0}, {14.75, 5.5, 240.0}, {14.3, 4.2, -15.0}, {13.6, 8.2, 80.0},
      {14.9, 8.0, -100.0}, {2.2, 1.0, 60.0}, {3.5, 1.15, -70.0}, {4.9, 0.7, 5.0}};
  static const double tables[3][2] = {{14.2, 5.0}, {14.25, 8.15}, {2.85, 1.1}};
  uint32_t i;
  for (i = 0; i < 8; i++) hall_at(b, chairs[i][0], 0.0, chairs[i][1], chairs[i][2], hall_chair);
  for (i = 0; i < 3; i++) hall_at(b, tables[i][0], 0.0, tables[i][1], 0.0, hall_cafe_table);
  for (i = 0; i < 7; i++) hall_at(b, 9.75 + 0.72 * i, 0.0, 2.62 + 0.04 * sc_sin(2000.0 * i), 50.0 * i, hall_stool);
}

static void hall_bar(sc_build *b) {
  sc_frame keep = sc_place(b, 11.9, 0.0, 2.05, 0.0);
  uint32_t i;
  hall_counter(b, 2.75);
  for (i = 0; i < 9; i++) {
    sc_frame inner = sc_place(b, -2.4 + 0.57 * i + 0.1 * sc_sin(777.0 * i), 1.11, 0.0 - 0.12 * (i % 2), 0.0);
    if (i % 4 == 3) hall_bottle(b, i % 3, i % 8 == 3 ? HALL_BROWN_GLASS : HALL_GREEN_GLASS);
    else hall_glass(b, i % 3 == 1);
    b->at = inner;
  }
  b->at = keep;
  keep = sc_place(b, 11.9, 0.0, 0.0, 0.0);
  hall_back_bar(b, 2.6);
  b->at = keep;
}

static void hall_walls_hung(sc_build *b) {
  sc_frame keep = b->at;
  hall_picture(b, 8.2, 1.6, 0.7, 0.9);
  hall_picture(b, 0.8, 1.6, 0.8, 1.0);
  hall_picture(b, 15.0, 1.6, 0.6, 0.8);
  sc_place(b, HALL_X, 0.0, 0.0, -90.0);
  hall_cue_rack(b, 2.5, 7);
  hall_dart_board(b, 8.0, 1.73);
  hall_picture(b, 8.7, 1.5, 0.9, 0.65);
  hall_picture(b, 4.8, 1.75, 0.5, 0.65);
  b->at = keep;
  sc_place(b, HALL_X, 0.0, HALL_Z, 180.0);
  hall_scoreboard(b, 6.2, 1.45);
  hall_picture(b, 1.4, 1.6, 1.2, 0.8);
  hall_picture(b, 9.2, 1.6, 1.2, 0.8);
  hall_cue_rack(b, 12.6, 7);
  b->at = keep;
  sc_place(b, 0.0, 0.0, HALL_Z, 90.0);
  hall_picture(b, 1.2, 1.6, 1.0, 0.7);
  hall_picture(b, 4.75, 1.7, 0.5, 0.65);
  hall_picture(b, 7.8, 1.6, 1.0, 0.7);
  b->at = keep;
}

/* >>materials ------------------------------------------------------------------------------------------------------ */

static pktrt_material *hall_material(sc_build *b, uint32_t kind) { return &b->out->materials[kind].m; }

static void hall_lobe(pktrt_material *m, float exponent) { /* 0: a mirror-like one */
  m->lobe = exponent > 0.0f ? PKTRT_LOBE_PHONG : PKTRT_LOBE_IDEAL;
  m->exponent = exponent;
}

/* Varnish, lacquer, enamel, phenolic resin: clear above a diffuse base. */
static void hall_coats(sc_build *b) {
  static const struct {
    uint32_t first, last;
    float ior, exponent;
  } coats[] = {{HALL_PLANK_1, HALL_PLANK_4, 1.5f, 4000}, {HALL_PANEL, HALL_PANEL, 1.45f, 60},
      {HALL_RAIL, HALL_RAIL, 1.5f, 0}, {HALL_CARVED, HALL_CARVED, 1.5f, 250}, {HALL_LEATHER, HALL_LEATHER, 1.4f, 0},
      {HALL_IVORY, HALL_BALL_8, 1.55f, 0}, {HALL_INK, HALL_INK, 1.55f, 0}, {HALL_MOVING, HALL_KINDS - 1, 1.55f, 0},
      {HALL_MAPLE, HALL_MAPLE, 1.5f, 200}, {HALL_ENAMEL, HALL_ENAMEL, 1.55f, 0}, {HALL_BAR_TOP, HALL_BAR_TOP, 1.5f, 0},
      {HALL_SEAT, HALL_BENTWOOD, 1.45f, 40}, {HALL_SLATE, HALL_SLATE, 1.5f, 20},
      {HALL_FAN_WOOD, HALL_FAN_WOOD, 1.5f, 250}, {HALL_FAN_2_WOOD, HALL_FAN_2_WOOD, 1.5f, 250}};
  uint32_t i, kind;
  for (i = 0; i < SC_COUNT(coats); i++)
    for (kind = coats[i].first; kind <= coats[i].last; kind++) {
      pktrt_material *m = hall_material(b, kind);
      m->specular = PKTRT_SPECULAR_COAT;
      m->ior[0] = coats[i].ior;
      hall_lobe(m, coats[i].exponent);
    }
}

static void hall_metals(sc_build *b) {
  static const struct {
    uint32_t kind;
    float exponent, ior[3], extinction[3];
  } metals[] = {{HALL_BRASS, 0, {0.45f, 0.53f, 1.10f}, {3.70f, 2.77f, 1.83f}},
      {HALL_FAN_BRASS, 0, {0.45f, 0.53f, 1.10f}, {3.70f, 2.77f, 1.83f}},
      {HALL_FAN_2_BRASS, 0, {0.45f, 0.53f, 1.10f}, {3.70f, 2.77f, 1.83f}},
      {HALL_STEEL, 0, {3.1f, 3.2f, 2.3f}, {3.3f, 3.3f, 3.1f}}, /* chromium */
      {HALL_GILT, 40, {0.18f, 0.42f, 1.37f}, {3.4f, 2.35f, 1.77f}}};
  uint32_t i;
  for (i = 0; i < SC_COUNT(metals); i++) {
    pktrt_material *m = hall_material(b, metals[i].kind);
    m->specular = PKTRT_SPECULAR_CONDUCTOR;
    memcpy(m->ior, metals[i].ior, sizeof m->ior);
    memcpy(m->extinction, metals[i].extinction, sizeof m->extinction);
    hall_lobe(m, metals[i].exponent);
  }
}

/* Bottles are solid, as if glass and content bent light alike. Absorption is by metre. */
static void hall_glasses(sc_build *b) {
  static const struct {
    uint32_t kind;
    float ior, absorption[3];
  } glasses[] = {{HALL_PANE, 1.5f, {0, 0, 0}}, {HALL_CLEAR_GLASS, 1.5f, {1.2f, 0.4f, 0.9f}},
      {HALL_TUMBLER, 1.5f, {1.2f, 0.4f, 0.9f}}, {HALL_GREEN_GLASS, 1.42f, {55, 9, 38}},
      {HALL_BROWN_GLASS, 1.4f, {8, 26, 90}}, {HALL_WHISKY, 1.35f, {3, 16, 62}},
      {HALL_WHISKY_IN_GLASS, 1.35f / 1.5f, {3, 16, 62}}, {HALL_BEER_IN_GLASS, 1.34f / 1.5f, {3, 12, 48}}};
  uint32_t i;
  for (i = 0; i < SC_COUNT(glasses); i++) {
    pktrt_material *m = hall_material(b, glasses[i].kind);
    m->specular = PKTRT_SPECULAR_DIELECTRIC;
    m->ior[0] = glasses[i].ior;
    memcpy(m->absorption, glasses[i].absorption, sizeof m->absorption);
  }
}

static void hall_glow(sc_build *b, uint32_t kind, float radiance) {
  pktrt_material *m = hall_material(b, kind);
  m->emission[0] = radiance, m->emission[1] = 0.81f * radiance, m->emission[2] = 0.56f * radiance;
}

static sc_v3 hall_point(const pktrt_points *p, uint32_t i) {
  return sc_v((double)p->position[0][i], (double)p->position[1][i], (double)p->position[2][i]);
}
/* Planks: the grain runs along x, and each row of planks is from another tree. */
static void hall_floor_texture(void *user, const pktrt_points *p) {
  sc_corners near[2] = {sc_nowhere, sc_nowhere};
  uint32_t i;
  (void)user;
  for (i = 0; i < p->n; i++) {
    sc_v3 at = hall_point(p, i);
    double row = sc_floor(at.z * 6.2);
    sc_tint(p->albedo, i, sc_wood(near, at.x + 3.7 * row, at.z, row, 42.0, 1.0));
  }
}
/* Rails: the grain runs along x, at the heads of the tables along z. */
static void hall_rail_texture(void *user, const pktrt_points *p) {
  sc_corners near[2] = {sc_nowhere, sc_nowhere};
  uint32_t i, k;
  (void)user;
  for (i = 0; i < p->n; i++) {
    sc_v3 at = hall_point(p, i);
    double along = at.x, across = at.z;
    for (k = 0; k < 3; k++) {
      double dx = at.x - hall_tables[k][0], dz = at.z - hall_tables[k][1];
      if (dx * dx > HALL_A * HALL_A && dx * dx < 2.5 && dz * dz < 0.42) along = at.z, across = at.x;
    }
    sc_tint(p->albedo, i, sc_wood(near, 1.6 * along, across, at.y, 70.0, 1.0));
  }
}
/* What stands upright; then what lies along x. */
static void hall_upright_texture(void *user, const pktrt_points *p) {
  sc_corners near[2] = {sc_nowhere, sc_nowhere};
  uint32_t i;
  (void)user;
  for (i = 0; i < p->n; i++) {
    sc_v3 at = hall_point(p, i);
    sc_tint(p->albedo, i, sc_wood(near, 1.4 * at.y, at.x + at.z, at.z, 30.0, 0.6));
  }
}
static void hall_bar_texture(void *user, const pktrt_points *p) {
  sc_corners near[2] = {sc_nowhere, sc_nowhere};
  uint32_t i;
  (void)user;
  for (i = 0; i < p->n; i++) {
    sc_v3 at = hall_point(p, i);
    sc_tint(p->albedo, i, sc_wood(near, at.x, at.z, at.y, 55.0, 1.0));
  }
}
/* Plaster and cloth: a little uneven, in two sizes. */
static void hall_uneven_texture(void *user, const pktrt_points *p) {
  const double *scale = (const double *)user;
  sc_corners near[2] = {sc_nowhere, sc_nowhere};
  uint32_t i;
  for (i = 0; i < p->n; i++) {
    sc_v3 at = hall_point(p, i), fine = sc_mul(at, scale[1]);
    at = sc_mul(at, scale[0]);
    sc_tint(p->albedo, i,
        1.0 + scale[2] *
                  (sc_noise_near(&near[0], at.x, at.y, at.z) + sc_noise_near(&near[1], fine.x, fine.y, fine.z) - 1.0));
  }
}

static void hall_materials(sc_build *b) {
  static double plaster[3] = {1.3, 7.0, 0.10}, cloth[3] = {9.0, 900.0, 0.16}; /* `user` is not const */
  pktrt_material *mirror = hall_material(b, HALL_MIRROR);
  uint32_t i;
  hall_coats(b);
  hall_metals(b);
  hall_glasses(b);
  mirror->specular = PKTRT_SPECULAR_MIRROR;
  mirror->reflectance[0] = 0.85f, mirror->reflectance[1] = 0.83f, mirror->reflectance[2] = 0.81f;
  for (i = HALL_PLANK_1; i <= HALL_PLANK_4; i++) hall_material(b, i)->texture = hall_floor_texture;
  hall_material(b, HALL_RAIL)->texture = hall_rail_texture;
  hall_material(b, HALL_CARVED)->texture = hall_material(b, HALL_PANEL)->texture = hall_upright_texture;
  hall_material(b, HALL_BAR_TOP)->texture = hall_bar_texture;
  hall_material(b, HALL_PLASTER)->texture = hall_material(b, HALL_CLOTH)->texture = hall_uneven_texture;
  hall_material(b, HALL_PLASTER)->user = plaster;
  hall_material(b, HALL_CLOTH)->user = cloth;
  hall_glow(b, HALL_OPAL, 2.5f);
  for (i = HALL_BULB; i <= HALL_LIGHT_3; i++) hall_glow(b, i, 12.0f);
  hall_glow(b, HALL_GLOBE, 16.0f);
  hall_glow(b, HALL_GLOBE_2, 8.0f);
}

/* >>poolhall ------------------------------------------------------------------------------------------------------- */

/* `factor`: a lamp lights for the other two bulbs, too, and for what its shades reflect; and our bulbs are dimmer than
   real ones, which would leave sparks wherever a rough surface mirrors them. */
static void hall_light(scene *s, uint32_t kind, float factor) {
  pktrt_light *l = &s->lights[s->light_count++];
  l->kind = PKTRT_LIGHT_MESH;
  l->mesh = kind;
  l->intensity[0] = l->intensity[1] = l->intensity[2] = factor;
}

static void poolhall_make(sc_build *b) {
  scene *s = b->out;
  uint32_t i;
  b->random = 2007u;
  b->detail = 0.6;
  hall_materials(b);
  hall_room(b);
  hall_games(b);
  b->detail = 0.75;
  hall_bar(b);
  b->detail = 0.62;
  hall_seats(b);
  hall_walls_hung(b);
  hall_fan(b, hall_fans[0], HALL_GLOBE, HALL_FAN_WOOD, HALL_FAN_BRASS);
  hall_fan(b, hall_fans[1], HALL_GLOBE_2, HALL_FAN_2_WOOD, HALL_FAN_2_BRASS);
  if (b->failed) return;
  for (i = HALL_FAN_WOOD; i < HALL_KINDS; i++) s->meshes[i].deforms = true;
  for (i = 0; i < 3; i++) hall_light(s, HALL_LIGHT_1 + i, i ? 28.0f : 23.0f);
  hall_light(s, HALL_GLOBE, 21.0f);
  s->background[0] = 0.055f, s->background[1] = 0.09f, s->background[2] = 0.18f;
  s->ambient[0] = 0.23f, s->ambient[1] = 0.20f, s->ambient[2] = 0.18f;
}

/* Along the first table and back on another way; slow where it begins. */
static void poolhall_camera(double time, pktrt_camera *c) {
  double aside = 0.5 - 0.5 * sc_cos(360.0 * time), sway = sc_sin(360.0 * time);
  sway *= sway * sway;
  memset(c, 0, sizeof *c);
  c->eye[0] = sc_snap(1.80 + 0.7 * aside);
  c->eye[1] = sc_snap(1.58 + 0.2 * aside);
  c->eye[2] = sc_snap(8.45 + 0.2 * sway);
  c->target[0] = 5.75f, c->target[1] = 1.0f, c->target[2] = 5.05f;
  c->fov_y = 52.0f;
  c->aperture = 0.010f;
  c->focus = 1.8f;
}

#endif /* SCENE_POOLHALL_H */
