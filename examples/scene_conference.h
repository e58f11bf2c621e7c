/* scene_conference.h - a conference room; part of scenes.h, which includes it.

   A long oval table stands along x in the middle of the room, the origin on the floor below its centre. Windows with
   blinds are at -z, the door and the whiteboard at +z, a display at +x. The camera starts at the end at -x.
   Everything is reflective, most things glossy: varnish with Phong lobes, a few metals, glass and water.

   Contents: kinds, finishes, textures, surfaces, room, furniture, things on the table, motion, camera and lights. */
#ifndef SCENE_CONFERENCE_H
#define SCENE_CONFERENCE_H

/* >>kinds ---------------------------------------------------------------------------------------------------------- */

enum {
  CONF_CARPET,
  CONF_PLASTER,
  CONF_PANEL,
  CONF_TRIM,
  CONF_TILE,
  CONF_GRID,
  CONF_LAMPS_1, /* two mesh lights */
  CONF_LAMPS_2,
  CONF_SPOT,
  CONF_STEEL,
  CONF_SILVER,
  CONF_CHROME,
  CONF_BRASS,
  CONF_TABLE,
  CONF_TABLE_EDGE,
  CONF_BLACK,
  CONF_PLASTIC,
  CONF_WHITE,
  CONF_LEATHER,
  CONF_PORCELAIN,
  CONF_COFFEE,
  CONF_GLASS,
  CONF_GLASS_WET, /* where glass meets water */
  CONF_WATER,
  CONF_PAPER,
  CONF_SCREEN,
  CONF_BOARD,
  CONF_PICTURE,
  CONF_ORANGE,
  CONF_APPLE,
  CONF_RED,
  CONF_BLUE,
  CONF_YELLOW,
  CONF_POT,
  CONF_STEM,
  CONF_CITY,
  CONF_MOVE_LEATHER, /* the rest deforms: chairs that swivel, */
  CONF_MOVE_METAL,
  CONF_MOVE_PLASTIC,
  CONF_ROLL_METAL, /* their feet, which only roll, */
  CONF_ROLL_PLASTIC,
  CONF_SLATS, /* blinds, */
  CONF_DOOR,
  CONF_HANDLE,
  CONF_SEA, /* a globe, */
  CONF_LAND,
  CONF_CRADLE, /* the outer balls of a Newton's cradle, */
  CONF_LEAVES,
  CONF_HANDS, /* and the second hand of the clock */
  CONF_KINDS
};

/* clang-format off */
static const sc_kind conference_kinds[CONF_KINDS] = {
  {"carpet", {0.115f, 0.135f, 0.165f}, 1},        {"plaster", {0.66f, 0.63f, 0.57f}, 1},
  {"panelling", {0.45f, 0.26f, 0.12f}, 0},        {"trim", {0.16f, 0.075f, 0.035f}, 0},
  {"ceiling tiles", {0.85f, 0.84f, 0.81f}, 1},    {"ceiling grid", {0.74f, 0.74f, 0.72f}, 1},
  {"lamps 1", {0.0f, 0.0f, 0.0f}, 1},            {"lamps 2", {0.0f, 0.0f, 0.0f}, 1},
  {"spots", {0.9f, 0.85f, 0.7f}, 1},              {"steel", {0.45f, 0.45f, 0.46f}, 0},
  {"silver lacquer", {0.36f, 0.37f, 0.38f}, 0},
  {"chrome", {0.50f, 0.50f, 0.52f}, 0},           {"brass", {0.58f, 0.40f, 0.14f}, 0},
  {"table", {0.22f, 0.10f, 0.045f}, 0},           {"table edge", {0.085f, 0.036f, 0.017f}, 0},
  {"black lacquer", {0.012f, 0.012f, 0.014f}, 0}, {"black plastic", {0.03f, 0.03f, 0.032f}, 0},
  {"white plastic", {0.70f, 0.70f, 0.68f}, 0},    {"leather", {0.022f, 0.085f, 0.105f}, 0},
  {"porcelain", {0.78f, 0.77f, 0.73f}, 0},        {"coffee", {0.030f, 0.012f, 0.006f}, 0},
  {"glass", {0.50f, 0.55f, 0.54f}, 0},            {"wet glass", {0.42f, 0.50f, 0.52f}, 0},
  {"water", {0.42f, 0.50f, 0.52f}, 0},            {"paper", {0.80f, 0.79f, 0.75f}, 0},
  {"screens", {0.02f, 0.02f, 0.02f}, 1},          {"whiteboard", {0.82f, 0.83f, 0.83f}, 1},
  {"pictures", {0.5f, 0.5f, 0.5f}, 1},            {"oranges", {0.80f, 0.27f, 0.02f}, 0},
  {"apples", {0.34f, 0.46f, 0.05f}, 0},           {"red", {0.50f, 0.035f, 0.025f}, 0},
  {"blue", {0.03f, 0.10f, 0.32f}, 0},             {"yellow", {0.72f, 0.47f, 0.05f}, 0},
  {"flower pots", {0.62f, 0.60f, 0.56f}, 0},      {"stems", {0.11f, 0.075f, 0.035f}, 0},
  {"city", {0.1f, 0.1f, 0.1f}, 1},                {"moving leather", {0.022f, 0.085f, 0.105f}, 0},
  {"swivelling metal", {0.50f, 0.50f, 0.52f}, 0}, {"swivelling plastic", {0.03f, 0.03f, 0.032f}, 0},
  {"rolling metal", {0.50f, 0.50f, 0.52f}, 0},    {"rolling plastic", {0.03f, 0.03f, 0.032f}, 0},
  {"blinds", {0.66f, 0.65f, 0.61f}, 0},           {"door", {0.30f, 0.145f, 0.062f}, 0},
  {"door handle", {0.45f, 0.45f, 0.46f}, 0},      {"sea", {0.05f, 0.16f, 0.30f}, 0},
  {"land", {0.50f, 0.38f, 0.17f}, 0},             {"swinging balls", {0.50f, 0.50f, 0.52f}, 0},
  {"leaves", {0.065f, 0.17f, 0.035f}, 0},         {"clock hand", {0.60f, 0.03f, 0.02f}, 0}};
/* clang-format on */

#define CONF_X 6.6 /* half the length, half the width, and the height of the room: 22 x 13 tiles of 0.6 m */
#define CONF_Z 3.9
#define CONF_Y 3.2
#define CONF_A 3.6 /* half axes of the table, height of its top */
#define CONF_B 1.0
#define CONF_TOP 0.74
#define CONF_WINDOWS 3
#define CONF_SLAT_COUNT 42 /* in each window */
#define CONF_SEATS 24
#define CONF_PLANTS 3
#define CONF_LEAF_COUNT 64

/* >>finishes ------------------------------------------------------------------------------------------------------- */

/* What a kind reflects. Exponent 0: ideal. Metals: index and extinction by channel. */
typedef struct conf_finish {
  uint32_t kind;
  pktrt_specular specular;
  float exponent, ior[3], extinction[3];
} conf_finish;

static const conf_finish conf_finishes[] = {{CONF_CARPET, PKTRT_SPECULAR_COAT, 6, {1.08f, 0, 0}, {0, 0, 0}},
    {CONF_PLASTER, PKTRT_SPECULAR_COAT, 20, {1.12f, 0, 0}, {0, 0, 0}},
    {CONF_PANEL, PKTRT_SPECULAR_COAT, 220, {1.48f, 0, 0}, {0, 0, 0}},
    {CONF_TRIM, PKTRT_SPECULAR_COAT, 220, {1.48f, 0, 0}, {0, 0, 0}},
    {CONF_TILE, PKTRT_SPECULAR_COAT, 8, {1.06f, 0, 0}, {0, 0, 0}},
    {CONF_GRID, PKTRT_SPECULAR_COAT, 60, {1.40f, 0, 0}, {0, 0, 0}},
    {CONF_STEEL, PKTRT_SPECULAR_CONDUCTOR, 180, {2.36f, 2.30f, 2.20f}, {4.40f, 4.20f, 3.90f}},
    {CONF_SILVER, PKTRT_SPECULAR_COAT, 90, {1.60f, 0, 0}, {0, 0, 0}},
    {CONF_CHROME, PKTRT_SPECULAR_CONDUCTOR, 0, {2.30f, 2.25f, 2.05f}, {4.60f, 4.50f, 4.40f}},
    {CONF_BRASS, PKTRT_SPECULAR_CONDUCTOR, 300, {0.44f, 0.53f, 1.09f}, {3.70f, 2.77f, 1.83f}},
    {CONF_TABLE, PKTRT_SPECULAR_COAT, 5000, {1.55f, 0, 0}, {0, 0, 0}},
    {CONF_TABLE_EDGE, PKTRT_SPECULAR_COAT, 5000, {1.55f, 0, 0}, {0, 0, 0}},
    {CONF_BLACK, PKTRT_SPECULAR_COAT, 0, {1.50f, 0, 0}, {0, 0, 0}},
    {CONF_PLASTIC, PKTRT_SPECULAR_COAT, 60, {1.46f, 0, 0}, {0, 0, 0}},
    {CONF_WHITE, PKTRT_SPECULAR_COAT, 300, {1.46f, 0, 0}, {0, 0, 0}},
    {CONF_LEATHER, PKTRT_SPECULAR_COAT, 36, {1.48f, 0, 0}, {0, 0, 0}},
    {CONF_PORCELAIN, PKTRT_SPECULAR_COAT, 0, {1.50f, 0, 0}, {0, 0, 0}},
    {CONF_COFFEE, PKTRT_SPECULAR_COAT, 0, {1.33f, 0, 0}, {0, 0, 0}},
    {CONF_GLASS, PKTRT_SPECULAR_DIELECTRIC, 0, {1.50f, 0, 0}, {0, 0, 0}},
    {CONF_GLASS_WET, PKTRT_SPECULAR_DIELECTRIC, 0, {1.128f, 0, 0}, {0, 0, 0}}, /* glass over water */
    {CONF_WATER, PKTRT_SPECULAR_DIELECTRIC, 0, {1.33f, 0, 0}, {0, 0, 0}},
    {CONF_PAPER, PKTRT_SPECULAR_COAT, 12, {1.25f, 0, 0}, {0, 0, 0}},
    {CONF_SCREEN, PKTRT_SPECULAR_COAT, 400, {1.45f, 0, 0}, {0, 0, 0}},
    {CONF_BOARD, PKTRT_SPECULAR_COAT, 500, {1.50f, 0, 0}, {0, 0, 0}},
    {CONF_PICTURE, PKTRT_SPECULAR_COAT, 900, {1.50f, 0, 0}, {0, 0, 0}},
    {CONF_ORANGE, PKTRT_SPECULAR_COAT, 60, {1.45f, 0, 0}, {0, 0, 0}},
    {CONF_APPLE, PKTRT_SPECULAR_COAT, 300, {1.48f, 0, 0}, {0, 0, 0}},
    {CONF_RED, PKTRT_SPECULAR_COAT, 120, {1.48f, 0, 0}, {0, 0, 0}},
    {CONF_BLUE, PKTRT_SPECULAR_COAT, 120, {1.48f, 0, 0}, {0, 0, 0}},
    {CONF_YELLOW, PKTRT_SPECULAR_COAT, 120, {1.48f, 0, 0}, {0, 0, 0}},
    {CONF_POT, PKTRT_SPECULAR_COAT, 500, {1.50f, 0, 0}, {0, 0, 0}},
    {CONF_STEM, PKTRT_SPECULAR_COAT, 10, {1.30f, 0, 0}, {0, 0, 0}},
    {CONF_MOVE_LEATHER, PKTRT_SPECULAR_COAT, 36, {1.48f, 0, 0}, {0, 0, 0}},
    {CONF_MOVE_METAL, PKTRT_SPECULAR_CONDUCTOR, 0, {2.30f, 2.25f, 2.05f}, {4.60f, 4.50f, 4.40f}},
    {CONF_MOVE_PLASTIC, PKTRT_SPECULAR_COAT, 60, {1.46f, 0, 0}, {0, 0, 0}},
    {CONF_ROLL_METAL, PKTRT_SPECULAR_CONDUCTOR, 0, {2.30f, 2.25f, 2.05f}, {4.60f, 4.50f, 4.40f}},
    {CONF_ROLL_PLASTIC, PKTRT_SPECULAR_COAT, 60, {1.46f, 0, 0}, {0, 0, 0}},
    {CONF_SLATS, PKTRT_SPECULAR_COAT, 120, {1.45f, 0, 0}, {0, 0, 0}},
    {CONF_DOOR, PKTRT_SPECULAR_COAT, 220, {1.48f, 0, 0}, {0, 0, 0}},
    {CONF_HANDLE, PKTRT_SPECULAR_CONDUCTOR, 180, {2.36f, 2.30f, 2.20f}, {4.40f, 4.20f, 3.90f}},
    {CONF_SEA, PKTRT_SPECULAR_COAT, 400, {1.50f, 0, 0}, {0, 0, 0}},
    {CONF_LAND, PKTRT_SPECULAR_COAT, 400, {1.50f, 0, 0}, {0, 0, 0}},
    {CONF_CRADLE, PKTRT_SPECULAR_CONDUCTOR, 0, {2.30f, 2.25f, 2.05f}, {4.60f, 4.50f, 4.40f}},
    {CONF_LEAVES, PKTRT_SPECULAR_COAT, 60, {1.40f, 0, 0}, {0, 0, 0}},
    {CONF_HANDS, PKTRT_SPECULAR_COAT, 120, {1.48f, 0, 0}, {0, 0, 0}}};

/* >>textures ------------------------------------------------------------------------------------------------------- */

/* Textures of pictures, paper and screens live on quads, which they know by the numbers of their triangles, so that
   these may stand anywhere; the others are functions of the place in the room. */

static double conf_part(double x) { return x - sc_floor(x); }
static double conf_abs(double x) { return x < 0.0 ? -x : x; }
static double conf_clamp(double x) { return x < 0.0 ? 0.0 : x > 1.0 ? 1.0 : x; }

/* A colour in [0,64), on the grid of sc_snap for the same reason. */
static void conf_put(float *const to[3], uint32_t i, const double *rgb, double factor) {
  uint32_t c;
  for (c = 0; c < 3; c++) to[c][i] = sc_snap(rgb[c] * factor);
}

typedef struct conf_wood {
  double light[3], dark[3], width, rings; /* of a sheet of veneer, metres; rings per metre */
  uint32_t along;                         /* axis of the grain */
} conf_wood;

static const conf_wood conf_walnut = {{0.235, 0.122, 0.063}, {0.090, 0.043, 0.022}, 0.45, 60.0, 2};
static const conf_wood conf_cherry = {{0.500, 0.285, 0.135}, {0.330, 0.165, 0.070}, 0.60, 45.0, 1};

/* Plain-sawn veneer: sheets are cut from a log at a varying distance from its pith, whence the arches. */
static void conf_grain(void *user, const pktrt_points *p) {
  const conf_wood *w = (const conf_wood *)user;
  const float *const *at = p->position;
  sc_corners near[2] = {sc_nowhere, sc_nowhere};
  uint32_t i, c;
  for (i = 0; i < p->n; i++) {
    double x = at[w->along][i], a = (double)at[(w->along + 1) % 3][i] + (double)at[(w->along + 2) % 3][i];
    double sheet = sc_floor(a / w->width), b = a - (sheet + 0.5) * w->width, seed = 7.3 * sheet, rgb[3];
    double depth = 0.20 * sc_noise_near(&near[0], 0.55 * x + seed, seed, 0.5) - 0.03;
    double wander = 0.7 * sc_noise_near(&near[1], 2.5 * x, 14.0 * a, seed);
    double ring = conf_part(w->rings * sqrt(b * b + depth * depth) + wander);
    double t = conf_clamp(0.75 * ring * ring + 0.35 * sc_noise(9.0 * x, 260.0 * a, seed));
    for (c = 0; c < 3; c++) rgb[c] = w->light[c] + t * (w->dark[c] - w->light[c]);
    conf_put(p->albedo, i, rgb, 0.9 + 0.2 * sc_cell(sheet, 5.0, 9.0));
  }
}

/* Carpet tiles of half a metre, their pile turned by a quarter from one to the next, flecked. */
static void conf_carpet(void *user, const pktrt_points *p) {
  sc_corners near = sc_nowhere;
  uint32_t i;
  (void)user;
  for (i = 0; i < p->n; i++) {
    double x = p->position[0][i], z = p->position[2][i],
           odd = 2.0 * conf_part(sc_floor(2.0 * x) / 2.0 + sc_floor(2.0 * z) / 2.0);
    double line = sc_cell(40.0 * (odd > 0.5 ? x : z), 2.0 * x + 60.0, 2.0 * z);
    double fleck = sc_noise(150.0 * x, 150.0 * z, 1.5), soft = sc_noise_near(&near, 9.0 * x, 9.0 * z, 7.5);
    sc_tint(p->albedo, i, 0.72 + 0.12 * odd + 0.35 * fleck + 0.12 * soft + 0.10 * line);
  }
}

/* Mineral fibre: pinholes and short cracks. */
static void conf_tile(void *user, const pktrt_points *p) {
  uint32_t i;
  (void)user;
  for (i = 0; i < p->n; i++) {
    double x = p->position[0][i], z = p->position[2][i];
    double hole = sc_noise(70.0 * x, 110.0 * z, 0.5) * sc_noise(31.0 * x + 8.0, 31.0 * z, 2.5);
    if (hole > 0.55) sc_tint(p->albedo, i, 0.62);
  }
}

/* Where point i lies in a mesh of quads, made by sc_quad or sc_heights: which, and from (0,0) to (1,1) in it. */
static uint32_t conf_on_quad(const pktrt_points *p, uint32_t i, double *s, double *t) {
  double u = p->barycentric[0][i], v = p->barycentric[1][i];
  bool second = p->triangle[i] & 1;
  *s = second ? u : u + v;
  *t = second ? u + v : v;
  return p->triangle[i] / 2;
}

/* Lines of words, none of which can be read: whether there is ink at (s, t); `wide` is the width of a line in heights
   of a letter, y runs down the lines. */
static bool conf_words(double s, double y, double wide, uint32_t page) {
  double line = floor(y), h = y - line, letter = s * wide * 2.2, word = s * wide * 0.33;
  double end = 0.6 + 0.4 * sc_cell(line, page, 3.0);
  if (line < 0.0 || s < 0.0 || s > end || sc_cell(line, page, 8.0) < 0.12) return false; /* ragged; blank lines */
  if (conf_part(word) < 0.30 * sc_cell(word, line, page)) return false;
  return h > 0.2 && h < 0.55 + 0.25 * sc_cell(letter, line, page) && conf_part(letter) > 0.3;
}

/* A slide: heading, a bar chart of rays per second against packet size, a few lines of text. */
static void conf_slide(double s, double t, uint32_t page, double *rgb) {
  static const double bars[4] = {0.34, 0.66, 0.83, 0.92};
  static const double hues[7][3] = {{0.85, 0.30, 0.10}, {0.90, 0.62, 0.08}, {0.18, 0.55, 0.30}, {0.08, 0.33, 0.68},
      {0.86, 0.89, 0.92}, {0.03, 0.11, 0.27}, {0.12, 0.12, 0.13}};
  double bar = floor(s * 8.9 - 0.5), x = conf_part(s * 8.9 - 0.5), h = (t - 0.12) / 0.62;
  uint32_t pick = 4;
  if (t > 0.84) pick = conf_words(s * 1.15 - 0.06, (0.965 - t) * 11.0, 20.0, page + 23) ? 4 : 5;
  else if (s > 0.05 && s < 0.505 && t > 0.105 && t < 0.12) pick = 6;
  else if (bar >= 0.0 && bar < 4.0 && x > 0.18 && x < 0.82 && h > 0.0 && h < bars[((uint32_t)bar + page) % 4])
    pick = (uint32_t)bar;
  else if (s > 0.55 && t > 0.12 && conf_words((s - 0.56) * 2.4, (0.78 - t) * 14.0, 13.0, page)) pick = 6;
  memcpy(rgb, hues[pick], 3 * sizeof *rgb);
}

/* Screens glow with a slide each, within a dark rim. */
static void conf_screen(void *user, const pktrt_points *p) {
  double s, t, rgb[3];
  uint32_t i, quad;
  (void)user;
  for (i = 0; i < p->n; i++) {
    quad = conf_on_quad(p, i, &s, &t);
    conf_slide(s, t, quad, rgb);
    conf_put(p->emission, i, rgb, s < 0.012 || s > 0.988 || t < 0.018 || t > 0.982 ? 0.0 : 0.85);
  }
}

#define CONF_SHEET_X 4u /* a sheet of paper is a grid */
#define CONF_SHEET_Y 6u

/* Printed sheets: a heading and lines, on every third a figure. */
static void conf_print(void *user, const pktrt_points *p) {
  uint32_t i, cell, page;
  double s, t;
  (void)user;
  for (i = 0; i < p->n; i++) {
    double rgb[3] = {0.80, 0.79, 0.76};
    bool ink = false;
    cell = conf_on_quad(p, i, &s, &t);
    page = cell / (CONF_SHEET_X * CONF_SHEET_Y);
    s = (s + cell % CONF_SHEET_X) / CONF_SHEET_X;
    t = (t + cell / CONF_SHEET_X % CONF_SHEET_Y) / CONF_SHEET_Y;
    if (page % 3 == 0 && t > 0.45 && t < 0.80 && s > 0.12 && s < 0.88)
      conf_slide((s - 0.12) / 0.76, (t - 0.45) / 0.35, page, rgb);
    else if (t > 0.84) ink = conf_words((s - 0.12) * 1.4, (0.93 - t) * 20.0, 16.0, page);
    else ink = t > 0.08 && t < 0.82 && conf_words((s - 0.12) * 1.28, (0.82 - t) * 44.0, 36.0, page);
    conf_put(p->albedo, i, rgb, ink ? 0.12 : 1.0);
  }
}

/* Distance of (x, y) from the line from a to b. */
static double conf_line(double x, double y, const double *a, const double *b) {
  double dx = b[0] - a[0], dy = b[1] - a[1], h = conf_clamp(((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy));
  double ex = x - a[0] - h * dx, ey = y - a[1] - h * dy;
  return sqrt(ex * ex + ey * ey);
}

/* The drawing on the whiteboard: a frustum of rays from an eye, boxes in it, a sphere that sends some of them on.
   Units: heights of the board. Returns the pen, -1 for none. */
static int conf_sketch_at(double x, double y) {
  static const double lines[][6] = {/* from, to, pen, dashes per unit */
      {0.18, 0.50, 1.05, 0.86, 0, 0}, {0.18, 0.50, 1.05, 0.14, 0, 0}, {0.18, 0.50, 1.02, 0.62, 1, 0},
      {0.18, 0.50, 1.00, 0.50, 1, 0}, {0.18, 0.50, 1.02, 0.38, 1, 0}, {1.02, 0.62, 0.80, 0.93, 3, 14},
      {1.00, 0.50, 0.55, 0.51, 3, 14}, {1.02, 0.38, 0.80, 0.07, 3, 14}, {0.62, 0.22, 1.48, 0.22, 2, 0},
      {1.48, 0.22, 1.48, 0.80, 2, 0}, {1.48, 0.80, 0.62, 0.80, 2, 0}, {0.62, 0.80, 0.62, 0.22, 2, 0},
      {0.92, 0.29, 1.42, 0.29, 2, 0}, {1.42, 0.29, 1.42, 0.72, 2, 0}, {1.42, 0.72, 0.92, 0.72, 2, 0},
      {0.92, 0.72, 0.92, 0.29, 2, 0}};
  double sphere = sqrt((x - 1.17) * (x - 1.17) + (y - 0.5) * (y - 0.5)),
         eye = sqrt((x - 0.15) * (x - 0.15) + (y - 0.5) * (y - 0.5));
  uint32_t k;
  int pen = -1;
  for (k = 0; k < SC_COUNT(lines); k++)
    if (conf_line(x, y, lines[k], lines[k] + 2) < 0.0055 && conf_part((x + y) * lines[k][5]) < 0.6)
      pen = (int)lines[k][4];
  if (conf_abs(sphere - 0.18) < 0.006 || conf_abs(eye - 0.035) < 0.006 || eye < 0.012) pen = 0;
  if (x > 1.60 && y > 0.2 && conf_words((x - 1.62) * 2.4, (0.86 - y) * 11.0, 11.0, 77)) pen = 2;
  return pen;
}

/* The whiteboard: that drawing by an unsteady hand. */
static void conf_sketch(void *user, const pktrt_points *p) {
  static const double pens[4][3] = {{0.05, 0.05, 0.06}, {0.62, 0.05, 0.04}, {0.05, 0.12, 0.52}, {0.04, 0.36, 0.10}};
  double s, t;
  uint32_t i;
  (void)user;
  for (i = 0; i < p->n; i++) {
    int pen;
    conf_on_quad(p, i, &s, &t);
    pen = conf_sketch_at(
        2.1 * s + 0.010 * sc_noise(14.0 * t, 9.0 * s, 0.5), t + 0.010 * sc_noise(14.0 * s, 9.0 * t, 4.5));
    if (pen >= 0) conf_put(p->albedo, i, pens[pen], 1.0);
  }
}

/* Paintings: hills of colour, one in front of the other. */
static void conf_paint(void *user, const pktrt_points *p) {
  static const double palette[6][3] = {{0.78, 0.60, 0.32}, {0.70, 0.32, 0.10}, {0.45, 0.10, 0.06}, {0.10, 0.22, 0.30},
      {0.05, 0.10, 0.18}, {0.62, 0.58, 0.48}};
  double s, t;
  uint32_t i, k;
  (void)user;
  for (i = 0; i < p->n; i++) {
    uint32_t pick = conf_on_quad(p, i, &s, &t), quad = pick;
    for (k = 1; k < 6; k++)
      if (t < 0.95 - 0.17 * k + 0.32 * (sc_noise(2.2 * s + 13.7 * quad, 3.1 * k, 0.5) - 0.4)) pick = quad + k;
    conf_put(p->albedo, i, palette[pick % 6], 0.8 + 0.4 * sc_noise(30.0 * s, 7.0 * t, 13.7 * quad));
  }
}

/* What is seen through the windows: sky, the towers of a hazy city before it, nearer ones darker. */
static void conf_city(void *user, const pktrt_points *p) {
  uint32_t i, row;
  (void)user;
  for (i = 0; i < p->n; i++) {
    double x = p->position[0][i], y = p->position[1][i], up = conf_clamp((y + 8.0) / 24.0), rgb[3];
    rgb[0] = 1.55 - 0.83 * up, rgb[1] = 1.65 - 0.53 * up, rgb[2] = 1.75 - 0.15 * up;
    for (row = 0; row < 3; row++) {
      double u = x * (0.30 - 0.07 * row) + 17.0 * row, haze = 0.75 - 0.24 * row;
      if (y > 7.0 - 4.5 * row + 7.0 * sc_cell(u, row, 1.0) || conf_part(u) < 0.1) continue;
      if (conf_part(10.0 * u) > 0.3 && conf_part(1.1 * y) > 0.35) haze *= 0.8; /* windows */
      rgb[0] = 0.95 * haze, rgb[1] = 1.05 * haze, rgb[2] = 1.22 * haze;
    }
    conf_put(p->emission, i, rgb, 1.0);
  }
}

/* >>surfaces ------------------------------------------------------------------------------------------------------- */

typedef sc_v3 (*conf_surface)(double u, double v, const void *context);

/* The surface f over the unit square, seen from where du x dv points to. `around`: u = 0 and u = 1 are the same. */
static void conf_grid(sc_build *b, uint32_t nu, uint32_t nv, bool around, conf_surface f, const void *context) {
  sc_mark mark = sc_begin(b);
  uint32_t columns = around ? nu : nu + 1, i, j;
  for (j = 0; j <= nv; j++)
    for (i = 0; i < columns; i++) sc_vertex(b, f((double)i / nu, (double)j / nv, context), sc_v(0.0, 1.0, 0.0));
  for (j = 0; j < nv; j++)
    for (i = 0; i < nu; i++) {
      uint32_t v = mark.vertex + j * columns + i, w = mark.vertex + j * columns + (i + 1) % columns;
      sc_triangle(b, v, w, w + columns);
      sc_triangle(b, v, w + columns, v + columns);
    }
  sc_smooth(b, mark);
}

/* Puts a thing somewhere. */
static void conf_at(sc_build *b, double x, double y, double z, double yaw, void (*thing)(sc_build *)) {
  sc_frame keep = sc_place(b, x, y, z, yaw);
  thing(b);
  b->at = keep;
}

/* A rectangle in the plane of the walls. */
static void conf_face(sc_build *b, double x0, double y0, double x1, double y1, double z) {
  sc_quad(b, sc_v(x0, y0, z), sc_v(x1, y0, z), sc_v(x1, y1, z), sc_v(x0, y1, z));
}

/* |v|^(3/4) with the sign of v: (a power(cos), b power(sin)) is an oval, |x/a|^(8/3) + |z/b|^(8/3) = 1. */
static double conf_power(double v) {
  double r = sqrt(v < 0.0 ? -v : v);
  return (v < 0.0 ? -r : r) * sqrt(r);
}

/* z of the table's edge at x, by bisection. */
static double conf_edge(double x) {
  double lo = 0.0, hi = 1.0;
  uint32_t i;
  for (i = 0; i < 40; i++) {
    double mid = (lo + hi) / 2.0;
    if (CONF_A * conf_power(mid) < (x < 0.0 ? -x : x)) lo = mid;
    else hi = mid;
  }
  return CONF_B * conf_power(sqrt(1.0 - lo * lo));
}

/* The turn by an angle around an axis (a unit vector) through a point. */
static sc_frame conf_rotation(sc_v3 pivot, sc_v3 axis, double degrees) {
  double c = sc_cos(degrees), s = sc_sin(degrees);
  sc_v3 *turned[3], unit = sc_v(1.0, 0.0, 0.0);
  sc_frame f;
  uint32_t i;
  turned[0] = &f.x, turned[1] = &f.y, turned[2] = &f.z;
  for (i = 0; i < 3; i++) {
    *turned[i] =
        sc_add(sc_add(sc_mul(unit, c), sc_mul(sc_cross(axis, unit), s)), sc_mul(axis, sc_dot(axis, unit) * (1 - c)));
    unit = sc_v(unit.z, unit.x, unit.y);
  }
  f.o = sc_sub(pivot, sc_add(sc_mul(f.x, pivot.x), sc_add(sc_mul(f.y, pivot.y), sc_mul(f.z, pivot.z))));
  return f;
}

/* >>room ----------------------------------------------------------------------------------------------------------- */

/* Boards with gaps between them in front of a dark ground. */
static void conf_boards(sc_build *b, double x0, double y0, double x1, double y1, uint32_t columns, uint32_t rows) {
  double w = (x1 - x0) / columns, h = (y1 - y0) / rows;
  uint32_t i, k;
  sc_use(b, CONF_TRIM);
  conf_face(b, x0, y0, x1, y1, 0.004);
  sc_use(b, CONF_PANEL);
  for (k = 0; k < rows; k++)
    for (i = 0; i < columns; i++)
      sc_box(b, x0 + w * i + 0.004, y0 + h * k + 0.004, -0.01, x0 + w * (i + 1) - 0.004, y0 + h * (k + 1) - 0.004,
          0.022, 0.003);
}

/* Skirting along a wall. */
static void conf_skirting(sc_build *b, double x0, double x1) {
  static const double skirting[][3] = {{30, 0, 1}, {30, 85, 1}, {26, 95}, {16, 100, 1}, {0, 100, 1}};
  sc_pt path[2] = {{0, 0, 1}, {0, 0, 1}};
  path[0].x = x1, path[1].x = x0;
  sc_use(b, CONF_TRIM);
  sc_moulding(b, path, 2, false, skirting, SC_COUNT(skirting), 2);
}

/* Boards up to the chair rail, plaster above. */
static void conf_wainscot(sc_build *b, double x0, double x1) {
  static const double rail[][3] = {
      {0, 930, 1}, {30, 930, 1}, {38, 938}, {40, 952}, {36, 962}, {26, 968, 1}, {0, 968, 1}};
  sc_pt path[2] = {{0, 0, 1}, {0, 0, 1}};
  uint32_t n = (uint32_t)((x1 - x0) / 0.6 + 0.5);
  path[0].x = x1, path[1].x = x0;
  conf_boards(b, x0, 0.09, x1, 0.935, n ? n : 1, 1);
  conf_skirting(b, x0, x1);
  sc_moulding(b, path, 2, false, rail, SC_COUNT(rail), 2);
  sc_use(b, CONF_PLASTER);
  conf_face(b, x0, 0.93, x1, CONF_Y + 0.08, 0.0);
}

static const double conf_openings[CONF_WINDOWS][4] = {{1.0, 0.92, 4.2, 2.80}, {5.0, 0.92, 8.2, 2.80},
    {9.0, 0.92, 12.2, 2.80}}; /* x0, y0, x1, y1 in the frame of the wall */

/* Frame, sill and reveals of a window; there are no panes. */
static void conf_window(sc_build *b, const double *o) {
  static const double casing[][3] = {{70, 0, 1}, {70, 18, 1}, {64, 24}, {12, 20}, {0, 16, 1}, {0, -10, 1}};
  uint32_t i;
  sc_use(b, CONF_PLASTER);
  sc_quad(b, sc_v(o[0], o[1], -0.3), sc_v(o[0], o[1], 0), sc_v(o[0], o[3], 0), sc_v(o[0], o[3], -0.3));
  sc_quad(b, sc_v(o[2], o[1], 0), sc_v(o[2], o[1], -0.3), sc_v(o[2], o[3], -0.3), sc_v(o[2], o[3], 0));
  sc_quad(b, sc_v(o[0], o[3], 0), sc_v(o[2], o[3], 0), sc_v(o[2], o[3], -0.3), sc_v(o[0], o[3], -0.3));
  sc_use(b, CONF_TRIM);
  sc_border(b, o[0], o[1], o[2], o[3], casing, SC_COUNT(casing), 2);
  sc_box(b, o[0] - 0.1, o[1] - 0.04, -0.3, o[2] + 0.1, o[1] + 0.004, 0.09, 0.006);
  sc_use(b, CONF_STEEL);
  for (i = 0; i < 3; i++) {
    double x = o[0] + (o[2] - o[0]) * i / 2.0, w = i == 1 ? 0.03 : 0.05;
    sc_box(b, x - w, o[1], -0.25, x + w, o[3], -0.19, 0.004);
  }
  sc_box(b, o[0], o[1], -0.249, o[2], o[1] + 0.06, -0.191, 0.004);
  sc_box(b, o[0], o[3] - 0.05, -0.249, o[2], o[3], -0.191, 0.004);
  sc_box(b, o[0], 2.28, -0.248, o[2], 2.32, -0.192, 0.004);
}

/* The axis of a slat of the blinds, its middle, in the room. */
static sc_v3 conf_slat(uint32_t window, uint32_t slat) {
  const double *o = conf_openings[window];
  return sc_v((o[0] + o[2]) / 2.0 - CONF_X, o[3] - 0.085 - 0.042 * slat, -CONF_Z - 0.07);
}

static sc_v3 conf_slat_surface(double u, double v, const void *context) { /* slightly arched across */
  const double *o = (const double *)context;
  double z = 0.048 * (0.5 - u);
  return sc_v((0.5 - v) * (o[2] - o[0] - 0.06), 0.004 * (1.0 - 4.0 * z * z / (0.048 * 0.048)), z);
}

/* A blind; slats are built at the tilt that they have at time 0. */
static void conf_blind(sc_build *b, uint32_t window) {
  const double *o = conf_openings[window];
  double bottom = conf_slat(window, CONF_SLAT_COUNT - 1).y - 0.045;
  uint32_t i, k;
  sc_use(b, CONF_SLATS);
  for (i = 0; i < CONF_SLAT_COUNT; i++) {
    sc_v3 at = conf_slat(window, i);
    sc_frame keep = sc_place(b, at.x + CONF_X, at.y, at.z + CONF_Z, 0.0);
    sc_turn_x(b, 12.0 + 4.0 * window);
    conf_grid(b, 4, 3, false, conf_slat_surface, o);
    b->at = keep;
  }
  sc_use(b, CONF_WHITE);
  sc_box(b, o[0] + 0.02, o[3] - 0.055, -0.10, o[2] - 0.02, o[3] - 0.005, -0.04, 0.004);
  sc_box(b, o[0] + 0.03, bottom - 0.012, -0.095, o[2] - 0.03, bottom + 0.012, -0.045, 0.004);
  for (i = 0; i < 4; i++)
    for (k = 0; k < 2; k++) { /* ladder cords */
      double x = o[0] + 0.35 + (o[2] - o[0] - 0.7) * i / 3.0, z = k ? -0.044 : -0.096;
      sc_rod(b, sc_v(x, o[3] - 0.05, z), sc_v(x, bottom, z), 0.0015, 4);
    }
  sc_rod(b, sc_v(o[2] - 0.2, o[3] - 0.05, -0.035), sc_v(o[2] - 0.21, 1.45, -0.03), 0.005, 8);
}

/* The wall with the windows, and the city far behind it. */
static void conf_window_wall(sc_build *b) {
  double x = 0.0;
  uint32_t i;
  sc_use(b, CONF_PLASTER);
  for (i = 0; i <= CONF_WINDOWS; i++) {
    double end = i < CONF_WINDOWS ? conf_openings[i][0] : 2.0 * CONF_X;
    conf_face(b, x, 0.90, end, CONF_Y + 0.08, 0.0);
    if (i == CONF_WINDOWS) break;
    conf_face(b, end, 2.80, conf_openings[i][2], CONF_Y + 0.08, 0.0);
    x = conf_openings[i][2];
  }
  conf_boards(b, 0.0, 0.09, 2.0 * CONF_X, 0.905, 22, 1);
  conf_skirting(b, 0.0, 2.0 * CONF_X);
  for (i = 0; i < CONF_WINDOWS; i++) {
    conf_window(b, conf_openings[i]);
    conf_blind(b, i);
  }
  sc_use(b, CONF_CITY);
  conf_face(b, -25.0, -6.0, 45.0, 16.0, -40.0);
}

#define CONF_DOOR_X0 0.9 /* in the frame of its wall */
#define CONF_DOOR_X1 1.9
#define CONF_DOOR_ANGLE 32.0 /* at time 0 */
static sc_v3 conf_hinge(void) { return sc_v(CONF_X - CONF_DOOR_X0, 0.0, CONF_Z + 0.02); }

/* The leaf stands ajar into the corridor behind it. */
static void conf_door(sc_build *b) {
  static const double casing[][3] = {{90, 0, 1}, {90, 22, 1}, {84, 28}, {14, 24}, {0, 18, 1}, {0, -120, 1}};
  static const double rose[][3] = {{26, 0, 1}, {26, 7}, {23, 9, 1}, {0, 9, 1}};
  double w = CONF_DOOR_X1 - CONF_DOOR_X0;
  sc_frame keep = b->at, leaf;
  sc_v3 p[4];
  uint32_t side;
  sc_use(b, CONF_TRIM);
  sc_border(b, CONF_DOOR_X0, -0.2, CONF_DOOR_X1, 2.15, casing, SC_COUNT(casing), 2);
  sc_place(b, CONF_DOOR_X0, 0.0, -0.02, CONF_DOOR_ANGLE);
  sc_use(b, CONF_DOOR);
  sc_box(b, 0.004, 0.008, -0.045, w - 0.004, 2.145, 0.0, 0.003);
  for (side = 0; side < 2; side++) {
    double z0 = side ? -0.053 : -0.001, z1 = side ? -0.044 : 0.008;
    sc_box(b, 0.12, 0.16, z0, w - 0.12, 0.92, z1, 0.004);
    sc_box(b, 0.12, 1.04, z0, w - 0.12, 2.02, z1, 0.004);
  }
  sc_use(b, CONF_HANDLE);
  leaf = sc_place(b, w - 0.06, 1.02, 0.0, 0.0);
  sc_turn_x(b, 90.0);
  SC_LATHE(b, 24, rose, 2);
  b->at = leaf;
  p[0] = sc_v(w - 0.06, 1.02, 0.0), p[1] = sc_v(w - 0.06, 1.02, 0.045), p[2] = sc_v(w - 0.085, 1.02, 0.058);
  p[3] = sc_v(w - 0.19, 1.02, 0.058);
  sc_tube(b, p, 4, 4, false, 0.009, 0.009, 10);
  b->at = keep;
}

/* What is behind the door: a corridor. */
static void conf_corridor(sc_build *b) {
  double x0 = CONF_DOOR_X0 - 1.2, x1 = CONF_DOOR_X1 + 1.2, z = -2.0, y = 2.5;
  sc_use(b, CONF_PLASTER);
  conf_face(b, x0, 0.0, x1, y, z);
  sc_quad(b, sc_v(x0, 0, z), sc_v(x0, y, z), sc_v(x0, y, -0.12), sc_v(x0, 0, -0.12));
  sc_quad(b, sc_v(x1, 0, z), sc_v(x1, 0, -0.12), sc_v(x1, y, -0.12), sc_v(x1, y, z));
  sc_quad(b, sc_v(x0, y, z), sc_v(x1, y, z), sc_v(x1, y, -0.12), sc_v(x0, y, -0.12));
  sc_quad(b, sc_v(x1, 0, -0.12), sc_v(CONF_DOOR_X1, 0, -0.12), sc_v(CONF_DOOR_X1, y, -0.12), sc_v(x1, y, -0.12));
  sc_quad(b, sc_v(CONF_DOOR_X0, 0, -0.12), sc_v(x0, 0, -0.12), sc_v(x0, y, -0.12), sc_v(CONF_DOOR_X0, y, -0.12));
  sc_use(b, CONF_CARPET);
  sc_quad(b, sc_v(x0, 0, 0.0), sc_v(x1, 0, 0.0), sc_v(x1, 0, z), sc_v(x0, 0, z));
}

/* The wall with the door: wainscot but there, plaster above. */
static void conf_door_wall(sc_build *b) {
  conf_wainscot(b, 0.0, CONF_DOOR_X0 - 0.09);
  conf_wainscot(b, CONF_DOOR_X1 + 0.09, 2.0 * CONF_X);
  sc_use(b, CONF_PLASTER);
  conf_face(b, CONF_DOOR_X0 - 0.09, 2.15, CONF_DOOR_X1 + 0.09, CONF_Y + 0.08, 0.0);
  conf_door(b);
  conf_corridor(b);
}

/* An end of the room: boards up to the ceiling. */
static void conf_end_wall(sc_build *b) {
  conf_boards(b, 0.0, 0.09, 2.0 * CONF_Z, CONF_Y + 0.08, 6, 3);
  conf_skirting(b, 0.0, 2.0 * CONF_Z);
}

/* A lamp takes the place of a tile. It lies above the bars, so that nothing near it is lit by it: sampling lights is at
   its worst there. For the same reason lamps themselves are black but for their emission. */
static void conf_lamp(sc_build *b, uint32_t kind, double x0, double z0) {
  double x1 = x0 + 0.592, z1 = z0 + 0.592, y = CONF_Y + 0.006;
  x0 += 0.008, z0 += 0.008;
  sc_use(b, kind);
  sc_quad(b, sc_v(x0, y, z0), sc_v(x1, y, z0), sc_v(x1, y, z1), sc_v(x0, y, z1));
}

/* What lies in a field of the grid of the ceiling: lamp, spot, air, else a tile. Lamps come in blocks of four. */
static char conf_field(uint32_t i, uint32_t j) {
  uint32_t k = i < 11 ? i : 21 - i;
  if ((j == 4 || j == 5 || j == 7 || j == 8) && (k == 4 || k == 5 || k == 7 || k == 8)) return 'L';
  if ((j == 1 || j == 11) && i % 3 == 2) return 's';
  if (j == 6 && (i == 2 || i == 19)) return 'a';
  return 't';
}

/* A spot: trim ring and glowing disc. */
static void conf_spot(sc_build *b, double x, double z) {
  static const double ring[][3] = {{62, 22, 1}, {60, 4}, {66, -3}, {76, 2, 1}, {77, 8, 1}};
  static const double disc[][3] = {{0, 18, 1}, {62, 18, 1}};
  sc_frame keep = sc_place(b, x, CONF_Y - 0.006, z, 0.0);
  sc_use(b, CONF_CHROME);
  SC_LATHE(b, 28, ring, 3);
  sc_use(b, CONF_SPOT);
  SC_LATHE(b, 20, disc, 1);
  b->at = keep;
}

/* An outlet of air: nested frames. */
static void conf_outlet(sc_build *b, double x, double z) {
  static const double blade[][3] = {{0, -4, 1}, {36, 12, 1}, {36, 16, 1}, {0, 0, 1}};
  uint32_t i;
  sc_frame keep = sc_place(b, x, CONF_Y, z, 0.0);
  sc_turn_x(b, 90.0);
  sc_use(b, CONF_GRID);
  for (i = 0; i < 5; i++) {
    double h = 0.035 + 0.048 * i;
    sc_border(b, -h, -h, h, h, blade, SC_COUNT(blade), 1);
  }
  b->at = keep;
}

/* Ceiling: tiles whose faces hang a little below the bars that carry them. */
static void conf_ceiling(sc_build *b) {
  uint32_t i, j, k;
  for (i = 0; i < 22; i++)
    for (j = 0; j < 13; j++) {
      double x = -CONF_X + 0.6 * i, z = -CONF_Z + 0.6 * j, c = 0.010, d = 0.016, y = CONF_Y, low = CONF_Y - 0.007;
      char field = conf_field(i, j);
      sc_v3 p[8];
      if (field == 'L') conf_lamp(b, i < 11 ? CONF_LAMPS_1 : CONF_LAMPS_2, x, z);
      if (field == 'L') continue;
      if (field == 's') conf_spot(b, x + 0.3, z + 0.3);
      if (field == 'a') conf_outlet(b, x + 0.3, z + 0.3);
      sc_use(b, CONF_TILE);
      p[0] = sc_v(x + c, y, z + c), p[1] = sc_v(x + 0.6 - c, y, z + c), p[2] = sc_v(x + 0.6 - c, y, z + 0.6 - c);
      p[3] = sc_v(x + c, y, z + 0.6 - c);
      p[4] = sc_v(x + d, low, z + d), p[5] = sc_v(x + 0.6 - d, low, z + d), p[6] = sc_v(x + 0.6 - d, low, z + 0.6 - d);
      p[7] = sc_v(x + d, low, z + 0.6 - d);
      if (field == 'a') continue;
      for (k = 0; k < 4; k++) sc_quad(b, p[k], p[(k + 1) % 4], p[4 + (k + 1) % 4], p[4 + k]);
      sc_quad(b, p[4], p[5], p[6], p[7]);
    }
  sc_use(b, CONF_GRID);
  for (i = 0; i <= 22; i++) {
    double x = -CONF_X + 0.6 * i, y = CONF_Y - 0.001 * (i & 1);
    sc_quad(b, sc_v(x - 0.012, y, -CONF_Z), sc_v(x + 0.012, y, -CONF_Z), sc_v(x + 0.012, y, CONF_Z),
        sc_v(x - 0.012, y, CONF_Z));
  }
  for (j = 0; j <= 13; j++) {
    double z = -CONF_Z + 0.6 * j, y = CONF_Y - 0.0005;
    sc_quad(b, sc_v(-CONF_X, y, z - 0.012), sc_v(CONF_X, y, z - 0.012), sc_v(CONF_X, y, z + 0.012),
        sc_v(-CONF_X, y, z + 0.012));
  }
}

/* Floor, ceiling, walls. */
static void conf_room(sc_build *b) {
  sc_use(b, CONF_CARPET);
  sc_quad(b, sc_v(-CONF_X, 0, CONF_Z), sc_v(CONF_X, 0, CONF_Z), sc_v(CONF_X, 0, -CONF_Z), sc_v(-CONF_X, 0, -CONF_Z));
  conf_ceiling(b);
  sc_use(b, CONF_PLASTER); /* what carries it keeps out the sun */
  sc_quad(b, sc_v(-7.2, CONF_Y + 0.07, -4.5), sc_v(7.2, CONF_Y + 0.07, -4.5), sc_v(7.2, CONF_Y + 0.07, 4.5),
      sc_v(-7.2, CONF_Y + 0.07, 4.5));
  conf_at(b, -CONF_X, 0.0, -CONF_Z, 0.0, conf_window_wall);
  conf_at(b, CONF_X, 0.0, -CONF_Z, -90.0, conf_end_wall);
  conf_at(b, CONF_X, 0.0, CONF_Z, 180.0, conf_door_wall);
  conf_at(b, -CONF_X, 0.0, CONF_Z, 90.0, conf_end_wall);
}

/* >>furniture ------------------------------------------------------------------------------------------------------ */

/* The oval of the table, its axes shrunk so that the line lies `in` metres inside. */
static void conf_oval(sc_frame *f, uint32_t n, double in) {
  uint32_t i;
  for (i = 0; i < n; i++) {
    double c = sc_cos(360.0 * i / n), s = sc_sin(360.0 * i / n), x = c * conf_power(sqrt(c < 0.0 ? -c : c));
    double z = s * conf_power(sqrt(s < 0.0 ? -s : s)); /* the gradient: the power 5/3 of the coordinates, nearly */
    f[i].x = sc_unit(sc_v(x / CONF_A, 0.0, z / CONF_B));
    f[i].y = sc_v(0.0, 1.0, 0.0);
    f[i].o = sc_sub(sc_v(CONF_A * conf_power(c), 0.0, CONF_B * conf_power(s)), sc_mul(f[i].x, in));
  }
}

/* Table top: a dark edge, a line of brass, within it veneer in strips from edge to edge. */
static void conf_table_top(sc_build *b) {
  static const double edge[][3] = {
      {-400, -45, 1}, {-60, -45, 1}, {-15, -43}, {-3, -34}, {-1, -22}, {-3, -9}, {-12, 0, 1}, {-110, 0, 1}};
  static const double line[][3] = {{-110, 0, 1}, {-119, 0, 1}};
  sc_frame f[96], keep = sc_place(b, 0.0, CONF_TOP, 0.0, 0.0);
  sc_pt round[SC_MAX_POINTS];
  uint32_t n = SC_COUNT(f), i;
  conf_oval(f, n, 0.0);
  sc_use(b, CONF_TABLE_EDGE);
  sc_sweep(b, f, n, true, round, sc_round(edge, SC_COUNT(edge), 3, round), false, 1);
  sc_use(b, CONF_BRASS);
  sc_sweep(b, f, n, true, round, sc_round(line, SC_COUNT(line), 1, round), false, 1);
  conf_oval(f, n, 0.119);
  sc_use(b, CONF_TABLE);
  for (i = 0; i < n / 2; i++) sc_quad(b, f[n - i == n ? 0 : n - i].o, f[n - i - 1].o, f[i + 1].o, f[i].o);
  sc_use(b, CONF_BLACK); /* lids over sockets */
  for (i = 0; i < 3; i++) sc_box(b, -2.26 + 2.0 * i, -0.01, -0.075, -1.74 + 2.0 * i, 0.0025, 0.075, 0.002);
  sc_use(b, CONF_STEEL);
  for (i = 0; i < 3; i++) sc_box(b, -2.04 + 2.0 * i, 0.0, -0.073, -1.96 + 2.0 * i, 0.004, -0.05, 0.001);
  b->at = keep;
}

/* The table: its top, and three drums on plinths that carry it. */
static void conf_table(sc_build *b) {
  static const double drum[][3] = {{0, 60, 1}, {150, 60, 1}, {150, 640, 1}, {120, 660}, {110, 700, 1}, {0, 700, 1}};
  static const double plinth[][3] = {{0, 0, 1}, {165, 0, 1}, {168, 4}, {168, 56}, {165, 60, 1}, {0, 60, 1}};
  int i;
  conf_table_top(b);
  for (i = -1; i <= 1; i++) {
    sc_frame keep = sc_place(b, 2.1 * i, 0.0, 0.0, 0.0);
    sc_use(b, CONF_TABLE_EDGE);
    sc_lathe_around(b, 0.30, 0.16, 40, drum, SC_COUNT(drum), 3);
    sc_use(b, CONF_STEEL);
    sc_lathe_around(b, 0.30, 0.16, 40, plinth, SC_COUNT(plinth), 2);
    b->at = keep;
  }
}

/* Chairs: soft pads on a sling between two rails. The line of the sling from the lip of the seat over the back to the
   top, {z, y}; the chair looks to +z. */
#define CONF_PADS 9u
static const double conf_sling[13][2] = {{0.205, 0.395}, {0.245, 0.425}, {0.200, 0.458}, {0.060, 0.452},
    {-0.090, 0.438}, {-0.190, 0.440}, {-0.245, 0.495}, {-0.262, 0.605}, {-0.272, 0.725}, {-0.305, 0.850},
    {-0.345, 0.970}, {-0.378, 1.060}, {-0.398, 1.072}};
static const double conf_pad_steps[8] = {0.0, 0.05, 0.14, 0.30, 0.50, 0.70, 0.86, 0.95};

/* The frame of the sling at s in [0,12]: y points out of the pads, z along the line. */
static sc_frame conf_sling_at(double s) {
  double p[2], d[2];
  uint32_t k, i = s < 0.02 ? 0 : s > 11.98 ? 11 : (uint32_t)s;
  sc_frame f;
  for (k = 0; k < 2; k++) {
    double a = conf_sling[i ? i - 1 : 0][k], q = conf_sling[i][k], r = conf_sling[i + 1][k], t = s - i;
    double e = conf_sling[i + 2 < 13 ? i + 2 : 12][k];
    p[k] = sc_spline(a, q, r, e, t);
    d[k] = sc_spline(a, q, r, e, t + 0.01) - sc_spline(a, q, r, e, t - 0.01);
  }
  f.o = sc_v(0.0, p[1], p[0]), f.x = sc_v(1.0, 0.0, 0.0), f.z = sc_unit(sc_v(0.0, d[1], d[0]));
  f.y = sc_cross(f.z, f.x);
  return f;
}

/* u around the section of the pads, v along the sling. */
static sc_v3 conf_pad(double u, double v, const void *context) {
  uint32_t j = (uint32_t)(v * CONF_PADS * 8 + 0.5), pad = j / 8;
  double q = pad < CONF_PADS ? conf_pad_steps[j % 8] : 1.0,
         s = 12.0 * (pad < CONF_PADS ? pad + q : CONF_PADS) / CONF_PADS;
  double c = sc_cos(360.0 * u), n = -sc_sin(360.0 * u), half = 0.245 - (s > 6.0 ? 0.0035 * (s - 6.0) : 0.0);
  double e = (2 * q - 1) * (2 * q - 1), puff = 0.006 + 0.022 * sqrt(1.0 - e * e), x;
  sc_frame f = conf_sling_at(s);
  (void)context;
  if (j == 0 || pad == CONF_PADS) puff = 0.002;
  x = (c < 0.0 ? -1.0 : 1.0) * sqrt(c < 0.0 ? -c : c);
  n = n < 0.0 ? -0.010 * sqrt(-n) : puff * sqrt(n);
  n += (s > 5.0 ? 0.030 : 0.016) * x * x; /* hollow across */
  return sc_add(f.o, sc_add(sc_mul(f.x, half * x), sc_mul(f.y, n)));
}

typedef struct conf_chair_kinds {
  uint32_t leather, metal, plastic, foot, castor;
} conf_chair_kinds;

/* Rail and armrest of one side, braces under the seat. */
static void conf_chair_sides(sc_build *b, const conf_chair_kinds *k) {
  static const double arm[][2] = {{0.110, 0.440}, {0.165, 0.520}, {0.155, 0.625}, {0.085, 0.660}, {-0.10, 0.660},
      {-0.215, 0.640}, {-0.265, 0.575}}; /* z, y */
  static const double rest[][3] = {{0, 0, 1}, {22, 0, 1}, {26, 6}, {25, 14}, {17, 20}, {0, 22}};
  sc_v3 p[16];
  int side;
  uint32_t i;
  for (side = -1; side <= 1; side += 2) {
    sc_use(b, k->metal);
    for (i = 0; i < 13; i++) {
      sc_frame f = conf_sling_at(0.8 + 10.7 * i / 12.0);
      p[i] = sc_add(f.o, sc_add(sc_v(side * 0.252, 0.0, 0.0), sc_mul(f.y, 0.014)));
    }
    sc_tube(b, p, 13, 2, false, 0.0125, 0.0125, 6);
    for (i = 0; i < SC_COUNT(arm); i++) p[i] = sc_v(side * (i ? 0.285 : 0.262), arm[i][1], arm[i][0]);
    p[SC_COUNT(arm) - 1].x = side * 0.262;
    sc_tube(b, p, SC_COUNT(arm), 2, false, 0.011, 0.011, 8);
    sc_use(b, k->plastic);
    {
      sc_frame keep = sc_place(b, side * 0.285, 0.664, -0.01, 0.0);
      sc_lathe_around(b, 0.001, 0.105, 16, rest, SC_COUNT(rest), 1);
      b->at = keep;
    }
  }
  sc_use(b, k->metal);
  for (i = 0; i < 3; i++) {
    double z = i < 2 ? 0.12 - 0.22 * i : -0.295, y = i < 2 ? 0.437 : 0.83, dip = i < 2 ? 0.395 : 0.83;
    p[0] = sc_v(-0.25, y, z), p[1] = sc_v(-0.12, dip, z), p[2] = sc_v(0.12, dip, z), p[3] = sc_v(0.25, y, z);
    sc_tube(b, p, 4, 3, false, 0.011, 0.011, 6);
  }
}

/* Five arms on castors, and the column. */
static void conf_chair_foot(sc_build *b, const conf_chair_kinds *k) {
  static const double hub[][3] = {{0, 85, 1}, {38, 85, 1}, {42, 92}, {40, 125}, {30, 135, 1}, {26, 136, 1},
      {26, 260, 1}, {17, 262, 1}, {17, 375, 1}};
  static const double wheel[][3] = {{0, 0, 1}, {22, 0, 1}, {25, 6}, {22, 15, 1}, {0, 16, 1}};
  uint32_t i, side;
  sc_use(b, k->foot);
  SC_LATHE(b, 20, hub, 1);
  for (i = 0; i < 5; i++) {
    sc_frame keep = sc_place(b, 0.0, 0.0, 0.0, 72.0 * i + 18.0), arm = b->at;
    sc_v3 p[4];
    p[0] = sc_v(0, 0.112, 0.02), p[1] = sc_v(0, 0.108, 0.12), p[2] = sc_v(0, 0.088, 0.23), p[3] = sc_v(0, 0.070, 0.315);
    sc_use(b, k->foot);
    sc_tube(b, p, 4, 2, false, 0.024, 0.014, 8);
    sc_use(b, k->castor);
    for (side = 0; side < 2; side++) {
      b->at = arm;
      sc_place(b, side ? 0.006 : -0.006, 0.025, 0.325, 0.0);
      sc_turn_z(b, side ? -90.0 : 90.0);
      SC_LATHE(b, 12, wheel, 1);
    }
    b->at = arm;
    sc_rod(b, sc_v(0, 0.03, 0.305), sc_v(0, 0.075, 0.305), 0.006, 6);
    b->at = keep;
  }
}

/* All of a chair that swivels. */
static void conf_chair_seat(sc_build *b, const conf_chair_kinds *k) {
  sc_use(b, k->leather);
  conf_grid(b, 16, CONF_PADS * 8, true, conf_pad, NULL);
  conf_chair_sides(b, k);
  sc_use(b, k->plastic);
  sc_box(b, -0.075, 0.365, -0.13, 0.075, 0.405, 0.13, 0.012);
  sc_rod(b, sc_v(0.07, 0.385, 0.05), sc_v(0.21, 0.375, 0.05), 0.006, 8);
}

/* Where chair i stands and where it looks at time 0: 18 along the sides, two at the ends, four along a wall. */
static void conf_seat(uint32_t i, double *x, double *z, double *yaw) {
  static const double others[6][3] = {{4.02, 0.10, -96.0}, {-4.05, -0.12, 84.0}, {-1.2, 3.38, 176.0},
      {-2.0, 3.36, 183.0}, {-2.8, 3.39, 178.0}, {-3.6, 3.35, 187.0}};
  if (i < 18) {
    double out = 0.30 + 0.10 * sc_sin(1234.0 * i + 60.0) * sc_sin(777.0 * i);
    *x = 0.74 * ((int)(i % 9) - 4) + 0.03 * sc_sin(1700.0 * i);
    *z = (conf_edge(*x) + out) * (i < 9 ? -1.0 : 1.0);
    *yaw = (i < 9 ? 0.0 : 180.0) + 14.0 * sc_sin(3331.0 * i + 10.0) - (i < 9 ? 1.0 : -1.0) * 3.0 * (*x);
  } else *x = others[i - 18][0], *z = others[i - 18][1], *yaw = others[i - 18][2];
}

/* Chairs that move: which, by how many degrees they swivel, by how many metres they roll, how often in the loop. */
static const double conf_movers[5][4] = {
    {10, 38.0, 0.06, 1}, {1, -46.0, 0.04, 1}, {14, 30.0, 0.05, 2}, {18, 55.0, 0.05, 1}, {5, -28.0, 0.05, 2}};

/* All chairs, those that move in meshes of their own. */
static void conf_chairs(sc_build *b) {
  static const conf_chair_kinds still = {CONF_LEATHER, CONF_CHROME, CONF_PLASTIC, CONF_CHROME, CONF_PLASTIC};
  static const conf_chair_kinds moving = {
      CONF_MOVE_LEATHER, CONF_MOVE_METAL, CONF_MOVE_PLASTIC, CONF_ROLL_METAL, CONF_ROLL_PLASTIC};
  bool moves[CONF_SEATS] = {false};
  uint32_t i, k;
  for (k = 0; k < SC_COUNT(conf_movers); k++) moves[(uint32_t)conf_movers[k][0]] = true;
  for (k = 0; k < SC_COUNT(conf_movers) + CONF_SEATS; k++) { /* movers first, in their order */
    double x, z, yaw;
    sc_frame keep;
    i = k < SC_COUNT(conf_movers) ? (uint32_t)conf_movers[k][0] : k - SC_COUNT(conf_movers);
    if (k >= SC_COUNT(conf_movers) && moves[i]) continue;
    conf_seat(i, &x, &z, &yaw);
    keep = sc_place(b, x, 0.0, z, yaw);
    conf_chair_seat(b, moves[i] ? &moving : &still);
    b->at = keep;
    sc_place(b, x, 0.0, z, yaw + 31.0 * i);
    conf_chair_foot(b, moves[i] ? &moving : &still);
    b->at = keep;
  }
}

/* A cupboard, 1.6 m long, its back at z = 0. */
static void conf_sideboard(sc_build *b) {
  uint32_t i;
  sc_use(b, CONF_TRIM);
  sc_box(b, -0.78, 0.0, 0.04, 0.78, 0.08, 0.42, 0.003);
  sc_box(b, -0.8, 0.08, 0.025, 0.8, 0.78, 0.44, 0.004);
  sc_box(b, -0.82, 0.78, 0.025, 0.82, 0.81, 0.47, 0.005);
  for (i = 0; i < 4; i++) {
    double x = -0.8 + 0.4 * i;
    sc_use(b, CONF_TABLE_EDGE);
    sc_box(b, x + 0.004, 0.086, 0.43, x + 0.396, 0.774, 0.458, 0.003);
    sc_use(b, CONF_STEEL);
    sc_rod(b, sc_v(x + (i & 1 ? 0.04 : 0.36), 0.5, 0.475), sc_v(x + (i & 1 ? 0.04 : 0.36), 0.66, 0.475), 0.006, 8);
  }
}

/* Books side by side along x. */
static void conf_books(sc_build *b, uint32_t n) {
  static const uint32_t covers[6] = {CONF_RED, CONF_BLUE, CONF_YELLOW, CONF_WHITE, CONF_PLASTIC, CONF_TRIM};
  double x = 0.0;
  uint32_t i;
  for (i = 0; i < n; i++) {
    double w = 0.02 + 0.03 * sc_random(&b->random), h = 0.21 + 0.08 * sc_random(&b->random),
           d = 0.15 + 0.04 * sc_random(&b->random);
    sc_use(b, covers[(uint32_t)(6.0 * sc_random(&b->random))]);
    sc_box(b, x, 0.0, 0.02, x + w, h, 0.02 + d, 0.003);
    x += w + 0.001;
  }
}

/* The big display: set in a thin frame. */
static void conf_display(sc_build *b) {
  sc_use(b, CONF_PLASTIC);
  sc_box(b, -1.24, 1.05, 0.02, 1.24, 2.47, 0.075, 0.008);
  sc_use(b, CONF_SCREEN);
  conf_face(b, -1.215, 1.075, 1.215, 2.445, 0.0765);
}

/* Whiteboard with a tray, pens and a sponge. */
static void conf_whiteboard(sc_build *b) {
  static const double rim[][3] = {{18, 0, 1}, {18, 20, 1}, {14, 24}, {0, 22, 1}, {-4, 10, 1}};
  static const double pen[][3] = {
      {0, 0, 1}, {7, 0, 1}, {8, 4}, {8, 85, 1}, {9, 86, 1}, {9, 128}, {7, 132, 1}, {0, 132, 1}};
  static const uint32_t inks[4] = {CONF_PLASTIC, CONF_RED, CONF_BLUE, CONF_APPLE};
  uint32_t i;
  sc_use(b, CONF_BOARD);
  conf_face(b, 0.0, 1.10, 2.52, 2.30, 0.012);
  sc_use(b, CONF_STEEL);
  sc_border(b, 0.0, 1.10, 2.52, 2.30, rim, SC_COUNT(rim), 2);
  sc_box(b, 0.5, 1.055, 0.0, 2.02, 1.07, 0.085, 0.004);
  for (i = 0; i < 4; i++) {
    sc_frame keep = sc_place(b, 0.75 + 0.19 * i, 1.079, 0.045, 0.0);
    sc_turn_z(b, -90.0);
    sc_use(b, inks[i]);
    SC_LATHE(b, 12, pen, 1);
    b->at = keep;
  }
  sc_use(b, CONF_PLASTIC);
  sc_box(b, 1.62, 1.070, 0.02, 1.77, 1.105, 0.07, 0.005);
}

/* A framed painting, its middle at the height of the eyes. */
static void conf_picture(sc_build *b, double x, double w, double h) {
  static const double frame[][3] = {{34, 0, 1}, {34, 26, 1}, {30, 30}, {6, 26}, {0, 20, 1}, {-3, 8, 1}};
  double y = 1.72 - h / 2.0;
  sc_use(b, CONF_PICTURE);
  conf_face(b, x, y, x + w, y + h, 0.012);
  sc_use(b, CONF_TRIM);
  sc_border(b, x, y, x + w, y + h, frame, SC_COUNT(frame), 2);
}

/* The clock: twelve marks, hour and minute hands; the second hand turns once in the loop. */
static sc_v3 conf_clock(void) { return sc_v(CONF_X - 1.4, 2.55, CONF_Z - 0.035); }
static void conf_clock_face(sc_build *b) {
  static const double body[][3] = {{0, 0, 1}, {165, 0, 1}, {170, 5}, {170, 30}, {164, 36}, {156, 34, 1}};
  static const double dial[][3] = {{158, 26, 1}, {0, 26, 1}};
  uint32_t i;
  sc_frame keep = b->at, face;
  sc_turn_x(b, 90.0);
  sc_use(b, CONF_CHROME);
  SC_LATHE(b, 48, body, 2);
  sc_use(b, CONF_WHITE);
  SC_LATHE(b, 48, dial, 1);
  b->at = keep;
  for (i = 0; i < 15; i++) {
    face = b->at;
    sc_turn_z(b, i < 12 ? 30.0 * i : i == 12 ? 52.0 : i == 13 ? -60.0 : 0.0);
    sc_use(b, i < 14 ? CONF_PLASTIC : CONF_HANDS);
    if (i < 12) sc_box(b, -0.004, 0.118, 0.026, 0.004, 0.142, 0.029, 0.0);
    else
      sc_box(b, i < 14 ? -0.005 : -0.002, -0.03, 0.026 + 0.002 * (i - 12), i < 14 ? 0.005 : 0.002,
          i == 12 ? 0.08 : 0.125, 0.029 + 0.002 * (i - 12), 0.0);
    b->at = face;
  }
}

/* A globe on a stand: sea and land are patches of the same sphere. */
static sc_v3 conf_globe_centre(void) { return sc_v(2.0, 1.02, -3.05); }
static sc_v3 conf_globe_axis(void) { return sc_v(0.3987, 0.9171, 0.0); } /* leaning by 23.5 degrees */
static void conf_globe_ball(sc_build *b) {
  uint32_t i, j, k, nu = 72, nv = 40;
  for (j = 0; j < nv; j++)
    for (i = 0; i < nu; i++) {
      uint32_t v[4];
      sc_v3 n[4];
      double h;
      for (k = 0; k < 4; k++) {
        double a = 360.0 * (i + (k == 2 || k == 3)) / nu, c = 180.0 * (j + (k == 1 || k == 2)) / nv;
        n[k] = sc_v(sc_sin(c) * sc_cos(a), sc_cos(c), -sc_sin(c) * sc_sin(a));
      }
      h = sc_noise(1.7 * n[0].x + 9.0, 1.7 * n[0].y + 4.0, 1.7 * n[0].z + 7.0);
      h += 0.35 * sc_noise(5.0 * n[0].x + 9.0, 5.0 * n[0].y + 5.0, 5.0 * n[0].z + 7.0);
      sc_use(b, h > 0.70 ? CONF_LAND : CONF_SEA);
      for (k = 0; k < 4; k++) v[k] = sc_vertex(b, sc_mul(n[k], 0.27), n[k]);
      sc_triangle(b, v[0], v[1], v[2]);
      sc_triangle(b, v[0], v[2], v[3]);
    }
}
/* The globe, its stand, and the ring that holds its axis. */
static void conf_globe(sc_build *b) {
  static const double stand[][3] = {{0, 0, 1}, {210, 0, 1}, {214, 10}, {200, 24}, {90, 45}, {40, 80}, {28, 130},
      {24, 300}, {36, 400}, {26, 440}, {22, 640}, {40, 690}, {30, 715}, {0, 720}};
  sc_v3 c = conf_globe_centre(), axis = conf_globe_axis();
  sc_frame keep = sc_place(b, c.x, 0.0, c.z, 0.0);
  sc_use(b, CONF_TRIM);
  SC_LATHE(b, 32, stand, 2);
  sc_use(b, CONF_BRASS);
  sc_place(b, 0.0, c.y, 0.0, 0.0);
  sc_turn_x(b, 90.0);
  sc_torus(b, 0.0, 0.297, 0.011, 64, 8);
  b->at = keep;
  sc_aim(b, c, sc_add(c, axis));
  sc_rod(b, sc_v(0.0, -0.297, 0.0), sc_v(0.0, 0.297, 0.0), 0.007, 8);
  conf_globe_ball(b);
  b->at = keep;
}

typedef struct conf_blade {
  double length, width, rise, droop;
} conf_blade;
static sc_v3 conf_leaf(double u, double v, const void *context) { /* along +z from the stem, folded along its middle */
  const conf_blade *c = (const conf_blade *)context;
  double w = c->width * sqrt(v) * (1.0 - v * v) * 1.5 + 0.003 * (1.0 - v), x = 2.0 * u - 1.0;
  return sc_v(w * x, c->length * v * (c->rise - c->droop * v) + 0.35 * w * (x < 0.0 ? -x : x),
      c->length * v * (1.0 - 0.25 * v * c->rise));
}

/* A dracaena: three stems in a pot, each with a tuft of leaves. */
static void conf_plant(sc_build *b) {
  static const double pot[][3] = {
      {0, 0, 1}, {130, 0, 1}, {140, 8}, {172, 300}, {180, 372}, {178, 378}, {168, 374}, {160, 330, 1}};
  static const double soil[][3] = {{163, 335, 1}, {0, 345, 1}};
  static const double stems[3][3] = {{0.06, 1.10, 0.02}, {-0.07, 0.80, 0.05}, {0.0, 1.42, -0.07}}; /* x, height, z */
  uint32_t i;
  sc_use(b, CONF_POT);
  SC_LATHE(b, 40, pot, 2);
  sc_use(b, CONF_STEM);
  SC_LATHE(b, 20, soil, 1);
  for (i = 0; i < 3; i++)
    sc_rod(b, sc_v(0.6 * stems[i][0], 0.33, 0.6 * stems[i][2]), sc_v(stems[i][0], stems[i][1], stems[i][2]), 0.016, 8);
  sc_use(b, CONF_LEAVES);
  for (i = 0; i < CONF_LEAF_COUNT; i++) {
    double q = (double)(i / 3) / (CONF_LEAF_COUNT / 3), up = 0.25 - 0.30 * q;
    conf_blade c;
    sc_frame keep =
        sc_place(b, stems[i % 3][0], stems[i % 3][1] + up, stems[i % 3][2], 137.5 * i + 20.0 * sc_random(&b->random));
    c.length = 0.42 + 0.16 * sc_random(&b->random) - 0.10 * (1.0 - q), c.width = 0.024 + 0.008 * sc_random(&b->random);
    c.rise = 1.9 - 1.7 * q, c.droop = 0.7 + 0.9 * sc_random(&b->random);
    sc_place(b, 0.0, 0.0, 0.008, 0.0);
    conf_grid(b, 2, 9, false, conf_leaf, &c);
    b->at = keep;
  }
}

/* A projector under the ceiling, looking to +x. */
static void conf_projector(sc_build *b) {
  static const double lens[][3] = {{46, 0, 1}, {46, 50, 1}, {40, 52, 1}, {34, 30, 1}};
  static const double front[][3] = {{34, 30, 1}, {20, 38}, {0, 41}};
  static const double plate[][3] = {{0, -18, 1}, {70, -18, 1}, {76, -12}, {76, 0, 1}};
  sc_frame keep = b->at;
  uint32_t i;
  sc_use(b, CONF_WHITE);
  sc_rod(b, sc_v(0.0, -0.5, 0.0), sc_v(0.0, 0.0, 0.0), 0.022, 16);
  SC_LATHE(b, 32, plate, 2);
  sc_box(b, -0.19, -0.62, -0.23, 0.19, -0.49, 0.23, 0.022);
  for (i = 0; i < 10; i++) sc_box(b, -0.12 + 0.022 * i, -0.60, -0.233, -0.108 + 0.022 * i, -0.51, 0.233, 0.0);
  sc_place(b, 0.185, -0.555, 0.09, 0.0);
  sc_turn_z(b, -90.0);
  sc_use(b, CONF_PLASTIC);
  SC_LATHE(b, 32, lens, 1);
  sc_use(b, CONF_BLACK);
  SC_LATHE(b, 24, front, 3);
  b->at = keep;
}

static const double conf_plants[CONF_PLANTS][3] = {
    {5.95, -3.2, 0.0}, {5.9, 3.15, 70.0}, {-5.9, 3.2, 140.0}}; /* x, z, yaw */

/* What stands on the floor and hangs from ceiling and walls. */
static void conf_furnish(sc_build *b) {
  sc_frame keep = b->at;
  uint32_t i;
  conf_table(b);
  conf_chairs(b);
  conf_globe(b);
  for (i = 0; i < CONF_PLANTS; i++)
    conf_at(b, conf_plants[i][0], 0.0, conf_plants[i][1], conf_plants[i][2], conf_plant);
  conf_at(b, 0.5, CONF_Y, 0.0, 0.0, conf_projector);
  conf_at(b, CONF_X, 0.0, 0.0, -90.0, conf_display);
  conf_at(b, CONF_X, 0.0, 0.0, -90.0, conf_sideboard);
  conf_at(b, -CONF_X, 0.0, 0.9, 90.0, conf_sideboard);
  conf_at(b, -CONF_X, 0.0, -0.9, 90.0, conf_sideboard);
  sc_place(b, CONF_X, 0.81, -0.62, -90.0);
  conf_books(b, 12);
  b->at = keep;
  sc_place(b, -CONF_X, 0.81, 0.6, 90.0);
  conf_books(b, 16);
  b->at = keep;
  sc_place(b, CONF_X, 0.0, CONF_Z, 180.0);
  sc_place(b, 2.75, 0.0, 0.0, 0.0);
  conf_whiteboard(b);
  b->at = keep;
  sc_place(b, CONF_X, 0.0, CONF_Z, 180.0);
  conf_picture(b, 6.1, 1.0, 0.8);
  conf_picture(b, 8.3, 0.7, 0.9);
  conf_picture(b, 10.4, 1.2, 0.8);
  sc_place(b, 1.4, 2.55, 0.0, 0.0);
  conf_clock_face(b);
  b->at = keep;
}

/* >>things on the table -------------------------------------------------------------------------------------------- */

/* A laptop, open, its user at -z. */
static void conf_laptop(sc_build *b) {
  sc_frame keep = b->at;
  uint32_t i, k;
  sc_use(b, CONF_SILVER);
  sc_box(b, -0.165, 0.002, -0.115, 0.165, 0.016, 0.115, 0.003);
  sc_use(b, CONF_PLASTIC);
  sc_box(b, -0.145, 0.0155, -0.018, 0.145, 0.0163, 0.088, 0.0);
  sc_box(b, -0.05, 0.0155, -0.100, 0.05, 0.0163, -0.036, 0.0);
  for (k = 0; k < 5; k++)
    for (i = 0; i < 14; i++) {
      double x = -0.142 + 0.0204 * i, z = -0.014 + 0.0202 * k;
      bool space = k == 0 && i >= 4 && i < 10;
      if (!space || i == 4) sc_box(b, x, 0.016, z, x + 0.0176 + (space ? 0.102 : 0.0), 0.0188, z + 0.0172, 0.0012);
    }
  sc_use(b, CONF_SILVER);
  sc_rod(b, sc_v(-0.12, 0.016, 0.114), sc_v(0.12, 0.016, 0.114), 0.005, 8);
  sc_place(b, 0.0, 0.017, 0.114, 0.0);
  sc_turn_x(b, 16.0);
  sc_box(b, -0.165, 0.0, -0.003, 0.165, 0.222, 0.004, 0.002);
  sc_use(b, CONF_PLASTIC);
  sc_box(b, -0.162, 0.004, -0.0036, 0.162, 0.219, -0.002, 0.0);
  sc_use(b, CONF_SCREEN);
  sc_quad(b, sc_v(0.152, 0.016, -0.004), sc_v(-0.152, 0.016, -0.004), sc_v(-0.152, 0.210, -0.004),
      sc_v(0.152, 0.210, -0.004));
  b->at = keep;
}

/* A tumbler with water: glass, glass against water, and the water's surface meet in one ring of vertices. */
static void conf_tumbler(sc_build *b) {
  static const double glass[][3] = {
      {0, 0, 1}, {27, 0, 1}, {30, 3}, {32, 30}, {36, 118}, {35.2, 120}, {34.2, 118}, {32, 76, 1}};
  static const double wet[][3] = {{32, 76, 1}, {29.6, 30}, {27.5, 13}, {22, 9}, {0, 9}};
  static const double water[][3] = {{32, 76, 1}, {0, 76, 1}};
  sc_use(b, CONF_GLASS);
  SC_LATHE(b, 32, glass, 2);
  sc_use(b, CONF_GLASS_WET);
  SC_LATHE(b, 32, wet, 2);
  sc_use(b, CONF_WATER);
  SC_LATHE(b, 32, water, 1);
}

/* A carafe, a good half full. */
static void conf_carafe(sc_build *b) {
  static const double glass[][3] = {{0, 0, 1}, {46, 0, 1}, {56, 6}, {63, 40}, {60, 100}, {42, 155}, {27, 195},
      {25, 220}, {36, 258}, {35.5, 260}, {33.8, 258}, {22.6, 220}, {24.4, 195}, {39.4, 155}, {52, 123, 1}};
  static const double wet[][3] = {{52, 123, 1}, {57.2, 100}, {60, 40}, {55, 12}, {44, 6}, {0, 6}};
  static const double water[][3] = {{52, 123, 1}, {0, 123, 1}};
  sc_use(b, CONF_GLASS);
  SC_LATHE(b, 44, glass, 2);
  sc_use(b, CONF_GLASS_WET);
  SC_LATHE(b, 44, wet, 2);
  sc_use(b, CONF_WATER);
  SC_LATHE(b, 44, water, 1);
}

/* A cup of coffee on a saucer with a spoon. */
static void conf_cup(sc_build *b) {
  static const double saucer[][3] = {{0, 2, 1}, {28, 0}, {36, 2}, {72, 15}, {74, 17}, {71, 18}, {36, 6}, {0, 5}};
  static const double cup[][3] = {{0, 8, 1}, {20, 8}, {24, 5, 1}, {26, 6}, {33, 18}, {40, 45}, {43, 72}, {42, 74},
      {40.5, 72}, {37, 44}, {28, 18}, {0, 12}};
  static const double coffee[][3] = {{39.6, 60, 1}, {0, 60, 1}};
  static const double handle[][2] = {{0.040, 0.060}, {0.058, 0.064}, {0.066, 0.048}, {0.056, 0.030}, {0.036, 0.030}};
  sc_v3 p[5];
  uint32_t i;
  sc_use(b, CONF_PORCELAIN);
  SC_LATHE(b, 32, saucer, 2);
  SC_LATHE(b, 32, cup, 2);
  for (i = 0; i < 5; i++) p[i] = sc_v(handle[i][0], handle[i][1], 0.0);
  sc_tube(b, p, 5, 4, false, 0.0045, 0.0045, 10);
  sc_use(b, CONF_COFFEE);
  SC_LATHE(b, 32, coffee, 1);
  sc_use(b, CONF_CHROME);
  p[0] = sc_v(-0.055, 0.0185, 0.03), p[1] = sc_v(-0.03, 0.017, 0.055), p[2] = sc_v(0.02, 0.024, 0.085);
  sc_tube(b, p, 3, 4, false, 0.004, 0.002, 8);
}

/* A microphone on a goose neck, speaker at -z. */
static void conf_microphone(sc_build *b) {
  static const double base[][3] = {{0, 0, 1}, {17, 0, 1}, {20, 4}, {18, 22}, {10, 28}, {0, 29}};
  static const double head[][3] = {{4, 0, 1}, {7.5, 4}, {8.5, 14}, {8.5, 44}, {6, 51}, {0, 54}};
  static const double ring[][3] = {{4.5, -9, 1}, {6.2, -8}, {6.2, 0, 1}, {4, 1, 1}};
  sc_frame keep = b->at;
  sc_v3 p[5];
  sc_use(b, CONF_PLASTIC);
  sc_lathe_around(b, 0.022, 0.030, 24, base, SC_COUNT(base), 2);
  p[0] = sc_v(0, 0.027, 0.02), p[1] = sc_v(0, 0.12, 0.025), p[2] = sc_v(0, 0.23, 0.0), p[3] = sc_v(0, 0.295, -0.06);
  p[4] = sc_v(0, 0.315, -0.12);
  sc_use(b, CONF_CHROME);
  sc_tube(b, p, 5, 5, false, 0.0042, 0.0036, 8);
  sc_aim(b, p[4], sc_v(0, 0.318, -0.2));
  sc_use(b, CONF_PLASTIC);
  SC_LATHE(b, 18, head, 2);
  sc_use(b, CONF_RED);
  SC_LATHE(b, 16, ring, 2);
  b->at = keep;
}

/* A three-armed telephone for conferences. */
static void conf_telephone(sc_build *b) {
  static const double body[][3] = {
      {0, 4, 1}, {165, 4, 1}, {172, 10}, {165, 20}, {110, 38}, {70, 52}, {45, 56, 1}, {0, 56, 1}};
  static const double speaker[][3] = {{45, 55, 1}, {45, 58}, {42, 60, 1}, {0, 57}};
  uint32_t i;
  b->flutes = 3, b->flute_depth = 0.42;
  sc_use(b, CONF_PLASTIC);
  SC_LATHE(b, 72, body, 2);
  b->flutes = 0;
  sc_use(b, CONF_STEEL);
  SC_LATHE(b, 32, speaker, 2);
  for (i = 0; i < 12; i++) {
    double x = -0.018 + 0.018 * (i % 3), z = -0.055 - 0.014 * (i / 3);
    sc_use(b, i == 9 ? CONF_APPLE : i == 11 ? CONF_RED : CONF_WHITE);
    sc_box(b, x - 0.006, 0.030 - 0.0035 * (i / 3), z - 0.0045, x + 0.006, 0.054 - 0.0040 * (i / 3), z + 0.0045, 0.001);
  }
}

static double conf_curl(double x, double y, const void *context) { /* a sheet is never quite flat */
  double k = *(const double *)context;
  return 0.0006 + 0.020 * (1.0 + k) * (x + 0.105) * (y + 0.149) * (y + 0.149) +
         0.10 * (0.5 - 0.5 * k) * x * x * (y + 0.149);
}

/* A sheet of paper, its reader at -z; height y above the table. */
static void conf_sheet(sc_build *b, double x, double y, double z, double yaw, double curl) {
  sc_frame keep = sc_place(b, x, y, z, 180.0 + yaw);
  sc_turn_x(b, -90.0);
  sc_use(b, CONF_PAPER);
  sc_heights(b, -0.105, -0.1485, 0.105, 0.1485, CONF_SHEET_X, CONF_SHEET_Y, conf_curl, &curl);
  b->at = keep;
}

/* A pen that lies along the yaw. */
static void conf_pen(sc_build *b, double x, double z, double yaw, uint32_t kind) {
  static const double body[][3] = {
      {0, 0, 1}, {2.6, 1}, {4.6, 16, 1}, {5.0, 18, 1}, {5.0, 128, 1}, {3.5, 133}, {0, 134}};
  static const double tip[][3] = {{0, -5}, {0.8, -4}, {2.7, 3, 1}};
  static const double clip[][3] = {{5.3, 84, 1}, {5.3, 90, 1}};
  sc_frame keep = sc_place(b, x, 0.0052, z, yaw);
  sc_turn_x(b, 90.0);
  sc_use(b, kind);
  SC_LATHE(b, 16, body, 2);
  sc_use(b, CONF_CHROME);
  SC_LATHE(b, 12, tip, 2);
  SC_LATHE(b, 16, clip, 1);
  sc_box(b, -0.0015, 0.088, -0.0075, 0.0015, 0.130, -0.0055, 0.0004);
  b->at = keep;
}

/* A folder with papers that stick out. */
static void conf_folder(sc_build *b, uint32_t kind) {
  sc_use(b, kind);
  sc_box(b, -0.115, 0.0, -0.16, 0.115, 0.003, 0.16, 0.0008);
  conf_sheet(b, 0.006, 0.003, 0.008, 3.0, -1.0);
  conf_sheet(b, -0.003, 0.004, -0.004, -4.0, -0.8);
}

/* A bowl of glass with oranges and apples. */
static void conf_fruit(sc_build *b) {
  static const double bowl[][3] = {{0, 0, 1}, {50, 0, 1}, {56, 5}, {66, 12}, {120, 45}, {150, 92}, {150, 95}, {146, 94},
      {115, 50}, {60, 18}, {0, 12}};
  static const double apple[][3] = {{0, 6}, {10, 1}, {24, 8}, {38, 36}, {36, 56}, {22, 68}, {8, 66}, {0, 59}};
  static const double stalk[][3] = {{1.6, 58, 1}, {1.4, 72}, {2.0, 80, 1}, {0, 80, 1}};
  static const double at[8][4] = {{0.058, 0.050, 0.0, 0}, {-0.040, 0.050, 0.050, 0}, {-0.035, 0.050, -0.055, 1},
      {0.035, 0.060, 0.085, 1}, {0.040, 0.062, -0.080, 0}, {-0.098, 0.070, 0.0, 1}, {0.0, 0.112, 0.010, 0},
      {0.03, 0.115, -0.05, 2}};
  uint32_t i;
  sc_use(b, CONF_GLASS);
  SC_LATHE(b, 56, bowl, 2);
  for (i = 0; i < 8; i++) {
    sc_frame keep = sc_place(b, at[i][0], at[i][1], at[i][2], 77.0 * i);
    sc_turn_x(b, 20.0 * sc_sin(100.0 * i));
    sc_use(b, at[i][3] < 0.5 ? CONF_ORANGE : at[i][3] < 1.5 ? CONF_APPLE : CONF_RED);
    if (at[i][3] < 0.5) sc_sphere_band(b, 0.040, 0.0, 180.0, 14, 28);
    else {
      sc_place(b, 0.0, -0.036, 0.0, 0.0);
      SC_LATHE(b, 28, apple, 2);
      sc_use(b, CONF_STEM);
      SC_LATHE(b, 8, stalk, 1);
    }
    b->at = keep;
  }
}

/* Newton's cradle: five balls in a row along x; the first and the last swing, by turns. */
#define CONF_BALL 0.021
#define CONF_HANG 0.150
/* Where it stands; how far a ball has swung at a time; where a ball hangs along the row. */
static void conf_cradle_place(double *x, double *y, double *z, double *yaw) {
  *x = -2.42, *y = CONF_TOP, *z = 0.02, *yaw = 72.0;
}
static double conf_cradle_angle(uint32_t last, double time) {
  double a = 40.0 * sc_sin(1080.0 * time + 30.0);
  return last ? (a < 0.0 ? -a : 0.0) : (a > 0.0 ? -a : 0.0);
}
static double conf_cradle_ball(uint32_t i) { return 2.004 * CONF_BALL * ((int)i - 2); }

/* Base, two frames, five balls on two strings each. */
static void conf_cradle(sc_build *b) {
  static const double slab[][3] = {{0, 0, 1}, {6, 0, 1}, {8, 3}, {8, 15}, {6, 18, 1}, {0, 18, 1}};
  double top = 0.018 + 0.205, x, y, z, yaw;
  sc_v3 p[6];
  uint32_t i, k;
  sc_frame keep = b->at;
  conf_cradle_place(&x, &y, &z, &yaw);
  sc_place(b, x, y, z, yaw);
  sc_use(b, CONF_BLACK);
  sc_lathe_around(b, 0.135, 0.085, 16, slab, SC_COUNT(slab), 2);
  sc_use(b, CONF_CHROME);
  for (k = 0; k < 2; k++) {
    double side = k ? 0.07 : -0.07;
    p[0] = sc_v(-0.12, 0.018, side), p[1] = sc_v(-0.12, top - 0.03, side), p[2] = sc_v(-0.105, top, side);
    p[3] = sc_v(0.105, top, side), p[4] = sc_v(0.12, top - 0.03, side), p[5] = sc_v(0.12, 0.018, side);
    sc_tube(b, p, 6, 5, false, 0.0042, 0.0042, 10);
  }
  for (i = 0; i < 5; i++) {
    sc_frame row = sc_place(b, conf_cradle_ball(i), top, 0.0, 0.0);
    sc_use(b, i % 4 ? CONF_CHROME : CONF_CRADLE);
    if (i % 4 == 0) sc_turn_z(b, conf_cradle_angle(i / 4, 0.0));
    for (k = 0; k < 2; k++)
      sc_rod(b, sc_v(0.0, -CONF_HANG + 0.95 * CONF_BALL, 0.0), sc_v(0.0, 0.0, k ? 0.07 : -0.07), 0.0005, 4);
    sc_place(b, 0.0, -CONF_HANG, 0.0, 0.0);
    sc_sphere_band(b, CONF_BALL, 0.0, 180.0, 20, 36);
    b->at = row;
  }
  b->at = keep;
}

/* What lies before a seat, in the frame of the table's edge there, looking inwards. Bits: 1 laptop, 2 papers, 4 cup,
   8 tumbler, 16 microphone, 32 folder. */
static void conf_setting(sc_build *b, uint32_t what, uint32_t number) {
  static const uint32_t covers[4] = {CONF_BLUE, CONF_RED, CONF_YELLOW, CONF_PLASTIC};
  double r = sc_random(&b->random), q = sc_random(&b->random);
  sc_frame keep = b->at;
  if (what & 1) {
    sc_place(b, 0.02 * r, 0.0, 0.24, 10.0 * (q - 0.5));
    conf_laptop(b);
    b->at = keep;
  }
  if (what & 2) {
    double x = what & 1 ? 0.33 : 0.05 * (r - 0.5), yaw = 24.0 * (q - 0.5);
    conf_sheet(b, x, 0.0, 0.24, yaw, r);
    conf_sheet(b, x + 0.04 * q, 0.0012, 0.27 + 0.04 * r, yaw - 11.0 + 30.0 * r, q);
    sc_place(b, 0.0, 0.002, 0.0, 0.0);
    conf_pen(b, x + 0.05 - 0.12 * q, 0.17 + 0.1 * r, 40.0 - 90.0 * r, covers[number % 4]);
    b->at = keep;
  }
  if (what & 32) {
    sc_place(b, 0.03 * (q - 0.5), 0.0, 0.22, 30.0 * (r - 0.5));
    conf_folder(b, covers[(number + 1) % 3]);
    b->at = keep;
  }
  if (what & 4) conf_at(b, -0.24, 0.0, 0.25 + 0.1 * q, 360.0 * r, conf_cup);
  if (what & 8) conf_at(b, 0.20 + 0.05 * r, 0.0, 0.42 + 0.06 * q, 0.0, conf_tumbler);
  if (what & 16) conf_at(b, -0.06 + 0.1 * r, 0.0, 0.50, 12.0 * (q - 0.5), conf_microphone);
  b->at = keep;
}

/* The table laid. */
static void conf_table_things(sc_build *b) {
  static const uint32_t sides[18] = {2 | 8 | 16, 1 | 4, 2 | 8 | 16, 32 | 4, 2 | 8 | 16, 1 | 8, 2 | 4 | 16, 32 | 8,
      2 | 8 | 16, 1 | 8, 2 | 4 | 16, 32 | 8, 2 | 16, 1 | 4, 2 | 8 | 16, 2 | 4, 32 | 16, 1 | 8};
  static const double carafes[4][2] = {{-1.95, -0.36}, {-0.35, 0.28}, {1.35, -0.25}, {2.75, 0.22}};
  uint32_t i;
  sc_frame keep = b->at;
  for (i = 0; i < 18; i++) {
    double x = 0.74 * ((int)(i % 9) - 4), side = i < 9 ? -1.0 : 1.0;
    sc_place(b, x, CONF_TOP + 0.0002, side * conf_edge(x), (i < 9 ? 0.0 : 180.0) - side * -4.0 * x);
    conf_setting(b, sides[i], i);
    b->at = keep;
  }
  for (i = 0; i < 4; i++) conf_at(b, carafes[i][0], CONF_TOP + 0.0002, carafes[i][1], 0.0, conf_carafe);
  conf_at(b, -1.15, CONF_TOP, 0.30, 0.0, conf_fruit);
  conf_at(b, 0.35, CONF_TOP, -0.05, 20.0, conf_telephone);
  sc_place(b, -CONF_A, CONF_TOP + 0.0002, 0.0, 90.0);
  conf_setting(b, 2 | 4, 3);
  b->at = keep;
  sc_place(b, CONF_A, CONF_TOP + 0.0002, 0.0, -90.0);
  conf_setting(b, 1 | 8 | 16, 2);
  b->at = keep;
  conf_cradle(b);
}

/* >>motion --------------------------------------------------------------------------------------------------------- */

/* Kinds that deform are rows of parts with equal numbers of vertices; each part has, at each time, an affine map from
   where it rests. `first` is the first vertex of the part. */
typedef struct conf_motion {
  uint32_t kind, parts;
  sc_frame (*pose)(uint32_t part, sc_v3 first, double time);
} conf_motion;

static sc_frame conf_pose_foot(uint32_t part, sc_v3 first, double time) { /* rolls along the way it looks */
  const double *m = conf_movers[part];
  sc_frame f = conf_rotation(sc_v(0.0, 0.0, 0.0), sc_v(0.0, 1.0, 0.0), 0.0);
  double x, z, yaw, d = -m[2] * sc_sin(360.0 * m[3] * time);
  (void)first;
  conf_seat((uint32_t)m[0], &x, &z, &yaw);
  f.o = sc_v(d * sc_sin(yaw), 0.0, d * sc_cos(yaw));
  return f;
}

static sc_frame conf_pose_seat(uint32_t part, sc_v3 first, double time) { /* with the foot, and swivels */
  const double *m = conf_movers[part];
  sc_v3 rolled = conf_pose_foot(part, first, time).o;
  sc_frame f;
  double x, z, yaw;
  conf_seat((uint32_t)m[0], &x, &z, &yaw);
  f = conf_rotation(sc_v(x, 0.0, z), sc_v(0.0, 1.0, 0.0), m[1] * sc_sin(360.0 * m[3] * time));
  f.o = sc_add(f.o, rolled);
  return f;
}

static sc_frame conf_pose_slat(uint32_t part, sc_v3 first, double time) { /* blinds tilt, one after the other */
  uint32_t window = part / CONF_SLAT_COUNT;
  double angle = 14.0 * (sc_sin(360.0 * time + 50.0 * window) - sc_sin(50.0 * window));
  (void)first;
  return conf_rotation(conf_slat(window, part % CONF_SLAT_COUNT), sc_v(1.0, 0.0, 0.0), angle);
}

/* The door swings on its hinges. */
static sc_frame conf_pose_door(uint32_t part, sc_v3 first, double time) {
  (void)part, (void)first;
  return conf_rotation(conf_hinge(), sc_v(0.0, 1.0, 0.0), 26.0 * sc_sin(360.0 * time));
}

/* The globe turns once in the loop. */
static sc_frame conf_pose_globe(uint32_t part, sc_v3 first, double time) {
  (void)part, (void)first;
  return conf_rotation(conf_globe_centre(), sc_unit(conf_globe_axis()), 360.0 * time);
}

/* A ball swings around the line through the upper ends of its strings. */
static sc_frame conf_pose_ball(uint32_t part, sc_v3 first, double time) {
  double x, y, z, yaw, at = conf_cradle_ball(4 * part),
                       angle = conf_cradle_angle(part, time) - conf_cradle_angle(part, 0.0);
  (void)first;
  conf_cradle_place(&x, &y, &z, &yaw);
  return conf_rotation(
      sc_v(x + at * sc_cos(yaw), y + 0.018 + 0.205, z - at * sc_sin(yaw)), sc_v(sc_sin(yaw), 0.0, sc_cos(yaw)), angle);
}

static sc_frame conf_pose_leaf(uint32_t part, sc_v3 first, double time) { /* sways from where it leaves the stem */
  double yaw = 137.5 * part, phase = 77.0 * part, turn = part % 3 == 0 ? 720.0 : 360.0;
  return conf_rotation(first, sc_v(sc_cos(yaw), 0.0, sc_sin(yaw)), 5.0 * (sc_sin(turn * time + phase) - sc_sin(phase)));
}

/* The second hand of the clock turns once in the loop. */
static sc_frame conf_pose_hand(uint32_t part, sc_v3 first, double time) {
  (void)part, (void)first;
  return conf_rotation(conf_clock(), sc_v(0.0, 0.0, 1.0), 360.0 * time);
}

static const conf_motion conf_motions[] = {{CONF_MOVE_LEATHER, SC_COUNT(conf_movers), conf_pose_seat},
    {CONF_MOVE_METAL, SC_COUNT(conf_movers), conf_pose_seat},
    {CONF_MOVE_PLASTIC, SC_COUNT(conf_movers), conf_pose_seat},
    {CONF_ROLL_METAL, SC_COUNT(conf_movers), conf_pose_foot},
    {CONF_ROLL_PLASTIC, SC_COUNT(conf_movers), conf_pose_foot},
    {CONF_SLATS, CONF_WINDOWS *CONF_SLAT_COUNT, conf_pose_slat}, {CONF_DOOR, 1, conf_pose_door},
    {CONF_HANDLE, 1, conf_pose_door}, {CONF_SEA, 1, conf_pose_globe}, {CONF_LAND, 1, conf_pose_globe},
    {CONF_CRADLE, 2, conf_pose_ball}, {CONF_LEAVES, CONF_PLANTS *CONF_LEAF_COUNT, conf_pose_leaf},
    {CONF_HANDS, 1, conf_pose_hand}};

/* All maps are rotations and shifts, so normals turn like everything else. */
static void conference_deform(const scene *s, const scene_mesh *m, double time, float *positions, float *normals) {
  const conf_motion *motion = NULL;
  sc_frame f = conf_rotation(sc_v(0.0, 0.0, 0.0), sc_v(0.0, 1.0, 0.0), 0.0);
  uint32_t i, k, each;
  (void)s;
  for (i = 0; i < SC_COUNT(conf_motions); i++)
    if (conf_motions[i].kind == m->material) motion = &conf_motions[i];
  each = motion ? m->vertex_count / motion->parts : m->vertex_count;
  for (i = 0; i < m->vertex_count; i++) {
    if (motion && i % each == 0) f = motion->pose(i / each, sc_get(m->positions, i), time);
    for (k = 0; k < (m->normals ? 2u : 1u); k++) {
      sc_v3 v = sc_get(k ? m->normals : m->positions, i);
      float *to = (k ? normals : positions) + 3 * i;
      v = sc_add(sc_mul(f.x, v.x), sc_add(sc_mul(f.y, v.y), sc_mul(f.z, v.z)));
      if (k == 0) v = sc_add(v, f.o);
      to[0] = sc_snap(v.x), to[1] = sc_snap(v.y), to[2] = sc_snap(v.z);
    }
  }
}

/* >>camera and lights ---------------------------------------------------------------------------------------------- */

/* Once around the table, rising and sinking a little; from the end of the room at time 0. */
static void conference_camera(double time, pktrt_camera *c) {
  double turn = 360.0 * time + 158.7, x = sc_cos(turn), z = sc_sin(turn), in = 0.5 - 0.5 * sc_cos(360.0 * time);
  memset(c, 0, sizeof *c);
  c->eye[0] = sc_snap(5.0 * x), c->eye[1] = sc_snap(1.66 + 0.3 * in), c->eye[2] = sc_snap(2.75 * z);
  c->target[0] = sc_snap(-0.966 * x), c->target[1] = sc_snap(0.80 + 0.05 * in), c->target[2] = sc_snap(-0.6 * z);
  c->fov_y = 50.0f;
  c->aperture = 0.015f;
  c->focus = 2.6f;
}

static void conf_set(float to[3], double r, double g, double b) {
  to[0] = (float)r, to[1] = (float)g, to[2] = (float)b;
}

/* Two fields of lamps in the ceiling, and the sun through the blinds. */
static void conf_lights(scene *s) {
  uint32_t i;
  pktrt_light *l = s->lights;
  s->light_count = 3;
  for (i = 0; i < 2; i++) {
    l[i].kind = PKTRT_LIGHT_MESH, l[i].mesh = CONF_LAMPS_1 + i;
    conf_set(l[i].intensity, 1.0, 1.0, 1.0);
    conf_set(s->materials[CONF_LAMPS_1 + i].m.emission, 3.7, 3.55, 3.25);
  }
  l[2].kind = PKTRT_LIGHT_DIRECTIONAL;
  conf_set(l[2].direction, -0.42, -0.36, 0.80);
  conf_set(l[2].intensity, 12.5, 10.8, 8.5);
  conf_set(s->materials[CONF_SPOT].m.emission, 6.0, 5.2, 3.8);
  conf_set(s->background, 0.72, 1.12, 1.60);
  conf_set(s->ambient, 0.25, 0.25, 0.255);
}

/* Kinds get what they reflect, and textures. */
static void conf_materials(scene *s) {
  static const uint32_t matte[3] = {CONF_CARPET, CONF_PLASTER, CONF_TILE};
  uint32_t i;
  for (i = 0; i < SC_COUNT(conf_finishes); i++) {
    const conf_finish *f = &conf_finishes[i];
    pktrt_material *m = &s->materials[f->kind].m;
    m->specular = f->specular;
    memcpy(m->ior, f->ior, sizeof m->ior);
    memcpy(m->extinction, f->extinction, sizeof m->extinction);
    m->lobe = f->exponent > 0.0f ? PKTRT_LOBE_PHONG : PKTRT_LOBE_IDEAL;
    m->exponent = f->exponent;
  }
  for (i = 0; i < 3; i++) conf_set(s->materials[matte[i]].m.reflectance, 0.3, 0.3, 0.3);
  conf_set(s->materials[CONF_GLASS].m.absorption, 1.2, 0.5, 0.7);
  conf_set(s->materials[CONF_WATER].m.absorption, 0.5, 0.15, 0.1);
  s->materials[CONF_TABLE].m.texture = conf_grain, s->materials[CONF_TABLE].m.user = (void *)&conf_walnut;
  s->materials[CONF_PANEL].m.texture = conf_grain, s->materials[CONF_PANEL].m.user = (void *)&conf_cherry;
  s->materials[CONF_CARPET].m.texture = conf_carpet;
  s->materials[CONF_TILE].m.texture = conf_tile;
  s->materials[CONF_SCREEN].m.texture = conf_screen;
  s->materials[CONF_PAPER].m.texture = conf_print;
  s->materials[CONF_BOARD].m.texture = conf_sketch;
  s->materials[CONF_PICTURE].m.texture = conf_paint;
  s->materials[CONF_CITY].m.texture = conf_city;
}

/* Everything, at rest. */
static void conference_make(sc_build *b) {
  uint32_t i;
  b->random = 1985u;
  conf_room(b);
  conf_furnish(b);
  conf_table_things(b);
  if (b->failed) return;
  for (i = 0; i < SC_COUNT(conf_motions); i++) b->out->meshes[conf_motions[i].kind].deforms = true;
  conf_materials(b->out);
  conf_lights(b->out);
}

#endif /* SCENE_CONFERENCE_H */
