/* Features that meet, two by two (thorough runs: three by three): a covering array has every pair of levels of 29 factors in
   one of its rows. Each row is a small scene that came about in its own way and is rendered in all modes, by all instruction
   sets, in packets. Its pictures, buffers and errors are compared, bit for bit, with ONE PLAIN PATH: a scene that is built at
   once, indexed, in one group, by the scalar instruction set, each pixel alone, each ray alone. Bits cannot tell where both
   would share a fault. So pictures of RCS, and in WRT those of mirrors and metals, are computed anew by a few lines in double;
   texture coordinates, sides and starts of rays are compared with what the scene is made of. */
#include "pictures.h"

/* --- factors and their levels --- */

typedef enum factor_name {
  SAMPLING,
  LIGHT,
  VISIBLE,
  CHOICE,
  MATERIAL,
  TEXTURE,
  NORMALS,
  GEOMETRY,
  MOTION,
  SHUTTER,
  CAMERA,
  LENS,
  GLASS_SHADOWS,
  DEPTH,
  BRANCHING,
  PHONG,
  PASSES,
  SKY,
  FLOOR,
  CURTAIN,
  CASE,
  /* These change no bit of a picture. */
  SOUP,
  GROUPS,
  HISTORY,
  OUTPUTS,
  TILE,
  ASSEMBLY,
  SHADOWS,
  QUALITY,
  FACTORS,
  FIRST_NEUTRAL = SOUP
} factor_name;

enum { MOST_LEVELS = 12 };

typedef struct factor {
  const char *name;
  const char *level[MOST_LEVELS + 1]; /* ends with NULL */
} factor;

enum { ONE_SAMPLE, RANDOM_2, INTERLEAVED_4, BLUE_NOISE_2, CUSTOM_3 };
enum { POINT, DIRECTIONAL, QUAD, SPHERE, MESH, MOVING_MESH, GLOWING_PLACE, ENVIRONMENT };
enum { MATT, MIRROR, GLOSS, COAT, GLOSSY_COAT, METAL, GLOSSY_METAL, GLASS, CUTOUT, SHADER, THIN, BLEND };
enum { NO_TEXTURE, BY_COORDINATES, BY_POINT };
enum { FLAT, SMOOTH, SMOOTH_IGNORED };
enum { DIRECT, PLACED, MIRRORED, UNEVEN, MANY };
enum { STILL, TWO_KEYS, THREE_KEYS, MOVING_PLACE, BOTH_MOVE };
enum { FRESH, REFITTED, KEY_BY_KEY, HIDDEN, REPLACED, REBUILT };
enum { ALONE, BUFFERS, COUNTS, COST };
enum { ONE_PASS, THREE_PASSES, ADAPTIVE };
enum { CONSTANT, CALLBACK, PREPARED, DARK };
enum { NO_CURTAIN, SHEET, PLACED_SHEET };
enum { NO_CASE, AROUND_LAMP, AROUND_CAMERA, MOVING_AROUND_CAMERA };

static const factor factors[FACTORS] = {
    [SAMPLING] = {"sampling", {"one sample", "random", "interleaved", "blue noise", "custom"}},
    [LIGHT] = {"light",
        {"point", "directional", "quad", "sphere", "mesh", "moving mesh", "glowing place", "environment"}},
    [VISIBLE] = {"lamps", {"unseen", "visible"}},
    [CHOICE] = {"choice of lights", {"all", "one deeper", "one"}},
    [MATERIAL] = {"material", {"matt", "mirror", "gloss", "coat", "glossy coat", "metal", "glossy metal", "glass",
                                  "cutout", "shader", "thin", "blend"}},
    [TEXTURE] = {"texture", {"none", "by coordinates", "by point"}},
    [NORMALS] = {"normals", {"flat", "smooth", "smooth, ignored"}},
    [GEOMETRY] = {"geometry", {"direct", "placed", "mirrored", "uneven", "many"}},
    [MOTION] = {"motion", {"still", "two keys", "three keys", "moving place", "both"}},
    [SHUTTER] = {"shutter", {"at 0", "at 0.6", "open", "half open"}},
    [CAMERA] = {"camera", {"still", "moving"}},
    [LENS] = {"lens", {"pinhole", "wide"}},
    [GLASS_SHADOWS] = {"shadows at glass", {"pass", "block"}},
    [DEPTH] = {"depth", {"default", "1", "3", "4, all followed", "strong attenuation"}},
    [BRANCHING] = {"branching", {"by mode", "both", "choose", "first"}},
    [PHONG] = {"lobes", {"careful", "naive"}},
    [PASSES] = {"passes", {"one", "three", "adaptive"}},
    [SKY] = {"sky", {"constant", "callback", "prepared", "dark, ambient"}},
    [FLOOR] = {"floor", {"matt", "gloss", "mirror"}},
    [CURTAIN] = {"curtain", {"none", "cutout", "placed cutout"}},
    [CASE] = {"case of glass", {"none", "around lamp", "around camera", "moving around camera"}},
    [SOUP] = {"triangles", {"indexed", "loose"}},
    [GROUPS] = {"groups", {"one", "groups", "masks", "groups and masks"}},
    [HISTORY] = {"history", {"fresh", "refitted", "key by key", "hidden and shown", "replaced", "rebuilt"}},
    [OUTPUTS] = {"outputs", {"alone", "buffers", "counts", "cost"}},
    [TILE] = {"tiles", {"one", "of 4", "of 5", "of 1, threads"}},
    [ASSEMBLY] = {"assembly", {"ray types", "runs", "materials", "octants", "blind", "none"}},
    [SHADOWS] = {"shadow packets", {"per light", "together"}},
    [QUALITY] = {"quality", {"default", "fast", "high"}},
};

/* Returns how many levels a factor has. */
static uint32_t levels_of(uint32_t which) {
  uint32_t count = 0;
  while (count < MOST_LEVELS && factors[which].level[count]) count++;
  return count;
}

typedef struct row {
  uint8_t level[FACTORS];
} row;

/* Returns whether two levels cannot be in one row: a place that moves needs an instance. */
static bool clash(uint32_t f, uint32_t a, uint32_t g, uint32_t b) {
  if (f == MOTION && g == GEOMETRY) return a >= MOVING_PLACE && b == DIRECT;
  return f == GEOMETRY && g == MOTION && clash(g, b, f, a);
}

/* Writes the levels of a row that are not the first of their factors. */
static const char *row_text(const row *r) {
  static char text[1024];
  size_t used = 0;
  text[0] = 0;
  for (uint32_t f = 0; f < FACTORS; f++) {
    if (r->level[f] == 0 || used + 64 > sizeof text) continue;
    used +=
        (size_t)snprintf(text + used, sizeof text - used, "%s: %s; ", factors[f].name, factors[f].level[r->level[f]]);
  }
  return text;
}

/* --- the covering array --- */

enum { MOST_SYMBOLS = 128, CANDIDATES = 24 };

/* Which tuples of `strength` levels are covered. A symbol is a level of a factor. */
typedef struct coverage {
  uint32_t strength; /* 2 or 3 */
  uint32_t symbols;
  uint32_t first[FACTORS]; /* symbol of a factor's first level */
  uint32_t factor_of[MOST_SYMBOLS];
  uint8_t *covered;     /* by two or three symbols, the factors in rising order */
  size_t allowed, left; /* tuples: all without a clash, those not yet covered */
} coverage;

/* Returns the place of a tuple; the third symbol is not looked at if pairs are covered. Factors may come in any order. */
static size_t tuple_index(const coverage *c, uint32_t x, uint32_t y, uint32_t z) {
  uint32_t s[3] = {x, y, z};
  for (uint32_t i = 1; i < c->strength; i++) {
    for (uint32_t j = i; j > 0 && s[j] < s[j - 1]; j--) {
      const uint32_t swapped = s[j];
      s[j] = s[j - 1];
      s[j - 1] = swapped;
    }
  }
  const size_t pair = (size_t)s[0] * MOST_SYMBOLS + s[1];
  return c->strength == 2 ? pair : pair * MOST_SYMBOLS + s[2];
}

/* Returns whether two symbols can be in one row. */
static bool symbols_fit(const coverage *c, uint32_t x, uint32_t y) {
  const uint32_t f = c->factor_of[x];
  const uint32_t g = c->factor_of[y];
  return f != g && !clash(f, x - c->first[f], g, y - c->first[g]);
}

/* Opens a coverage with nothing covered and counts the tuples that are allowed. */
static coverage coverage_open(uint32_t strength) {
  coverage c;
  memset(&c, 0, sizeof c);
  c.strength = strength;

  for (uint32_t f = 0; f < FACTORS; f++) {
    c.first[f] = c.symbols;
    for (uint32_t a = 0; a < levels_of(f); a++) c.factor_of[c.symbols++] = f;
  }
  if (c.symbols > MOST_SYMBOLS) abort();

  c.covered = calloc((size_t)MOST_SYMBOLS * MOST_SYMBOLS * (strength == 3 ? MOST_SYMBOLS : 1), 1);
  if (!c.covered) abort();
  for (uint32_t x = 0; x < c.symbols; x++) {
    for (uint32_t y = x + 1; y < c.symbols; y++) {
      if (!symbols_fit(&c, x, y)) continue;
      c.allowed += strength == 2;
      for (uint32_t z = y + 1; z < c.symbols && strength == 3; z++)
        c.allowed += symbols_fit(&c, x, z) && symbols_fit(&c, y, z);
    }
  }
  c.left = c.allowed;
  return c;
}

/* Marks the tuples of a row as covered and returns how many are new. */
static size_t coverage_add(coverage *c, const row *r) {
  size_t fresh = 0;
  for (uint32_t f = 0; f < FACTORS; f++) {
    for (uint32_t g = f + 1; g < FACTORS; g++) {
      for (uint32_t h = g + 1; h < (c->strength == 2 ? g + 2 : FACTORS); h++) {
        const uint32_t z = c->strength == 2 ? 0 : c->first[h] + r->level[h];
        uint8_t *at = &c->covered[tuple_index(c, c->first[f] + r->level[f], c->first[g] + r->level[g], z)];
        fresh += !*at;
        *at = 1;
      }
    }
  }
  c->left -= fresh;
  return fresh;
}

/* Returns how many tuples a symbol would newly cover with those that are chosen. */
static size_t gain_of(const coverage *c, uint32_t symbol, const uint32_t *chosen, uint32_t count) {
  size_t gain = 0;
  for (uint32_t i = 0; i < count; i++) {
    if (c->strength == 2) gain += !c->covered[tuple_index(c, symbol, chosen[i], 0)];
    for (uint32_t j = i + 1; j < count && c->strength == 3; j++)
      gain += !c->covered[tuple_index(c, symbol, chosen[i], chosen[j])];
  }
  return gain;
}

/* Finds a tuple that is not covered, the first from a random symbol on, and returns how many symbols it has. */
static uint32_t find_uncovered(const coverage *c, rng *r, uint32_t chosen[3]) {
  const uint32_t start = rng_below(r, c->symbols);
  for (uint32_t i = 0; i < c->symbols; i++) {
    const uint32_t x = (start + i) % c->symbols;
    for (uint32_t y = 0; y < c->symbols; y++) {
      if (!symbols_fit(c, x, y)) continue;
      for (uint32_t z = 0; z < (c->strength == 2 ? 1 : c->symbols); z++) {
        if (c->strength == 3 && !(symbols_fit(c, x, z) && symbols_fit(c, y, z))) continue;
        if (c->covered[tuple_index(c, x, y, z)]) continue;
        chosen[0] = x;
        chosen[1] = y;
        chosen[2] = z;
        return c->strength;
      }
    }
  }
  return 0;
}

/* Makes one row around a tuple that is not covered: factors follow in random order, each with the level that covers most
   with those before and clashes with none. Returns how many tuples the row newly covers. */
static size_t candidate_row(const coverage *c, rng *r, row *out) {
  uint32_t chosen[FACTORS];
  uint32_t count = find_uncovered(c, r, chosen);
  size_t total = 1;
  bool has[FACTORS] = {false};
  uint32_t order[FACTORS];

  for (uint32_t i = 0; i < count; i++) has[c->factor_of[chosen[i]]] = true;
  for (uint32_t i = 0; i < FACTORS; i++) {
    const uint32_t j = rng_below(r, i + 1);
    order[i] = order[j];
    order[j] = i;
  }

  for (uint32_t i = 0; i < FACTORS; i++) {
    const uint32_t f = order[i];
    if (has[f]) continue;
    uint32_t best = MOST_SYMBOLS;
    size_t best_gain = 0;
    const uint32_t turn = rng_below(r, levels_of(f));
    for (uint32_t a = 0; a < levels_of(f); a++) {
      const uint32_t symbol = c->first[f] + (a + turn) % levels_of(f);
      bool fits = true;
      for (uint32_t k = 0; k < count && fits; k++) fits = symbols_fit(c, symbol, chosen[k]);
      if (!fits) continue;
      const size_t gain = gain_of(c, symbol, chosen, count);
      if (best < MOST_SYMBOLS && gain <= best_gain) continue;
      best = symbol;
      best_gain = gain;
    }
    total += best_gain;
    chosen[count++] = best;
  }

  for (uint32_t i = 0; i < count; i++) {
    const uint32_t f = c->factor_of[chosen[i]];
    out->level[f] = (uint8_t)(chosen[i] - c->first[f]);
  }
  return total;
}

/* Fills rows, at most so many, until all tuples are covered; returns how many there are. The same rows for the same seed. */
static size_t make_rows(uint32_t strength, row *rows, size_t most, size_t *left) {
  coverage c = coverage_open(strength);
  rng r = rng_of(2007);
  size_t count = 0;

  while (c.left > 0 && count < most) {
    size_t best = 0;
    for (int i = 0; i < CANDIDATES; i++) {
      row candidate;
      const size_t gain = candidate_row(&c, &r, &candidate);
      if (gain <= best) continue;
      best = gain;
      rows[count] = candidate;
    }
    if (!CHECK(coverage_add(&c, &rows[count]) > 0, "row %zu covers nothing", count)) break;
    count++;
  }

  *left = c.left;
  free(c.covered);
  return count;
}

/* Returns how many of the allowed pairs no row has, but for one that is left out: counted plainly, pair by pair. */
static size_t pairs_missing(const row *rows, size_t count, size_t without, size_t *allowed) {
  size_t missing = 0;
  *allowed = 0;
  for (uint32_t f = 0; f < FACTORS; f++) {
    for (uint32_t g = f + 1; g < FACTORS; g++) {
      for (uint32_t a = 0; a < levels_of(f); a++) {
        for (uint32_t b = 0; b < levels_of(g); b++) {
          if (clash(f, a, g, b)) continue;
          size_t i = 0;
          while (i < count && (i == without || rows[i].level[f] != a || rows[i].level[g] != b)) i++;
          missing += i == count;
          ++*allowed;
        }
      }
    }
  }
  return missing;
}

enum { MOST_ROWS = 200 };

/* Fills the rows of the covering array of pairs, once for all tests, and returns them. */
static const row *pair_rows(size_t *count) {
  static row rows[MOST_ROWS];
  static size_t made;
  size_t left = 0;
  if (made == 0) made = make_rows(2, rows, MOST_ROWS, &left);
  *count = made;
  return rows;
}

static void all_pairs_are_covered(void) {
  size_t count = 0;
  size_t allowed = 0;
  const row *rows = pair_rows(&count);
  CHECK(pairs_missing(rows, count, SIZE_MAX, &allowed) == 0);
  CHECK(count < MOST_ROWS && allowed > 5000, "%zu rows, %zu pairs", count, allowed);
  for (size_t i = 0; i < count; i++) CHECK(!clash(MOTION, rows[i].level[MOTION], GEOMETRY, rows[i].level[GEOMETRY]));

  size_t needed = 0;
  const size_t dropped = small_run ? 4 : count;
  for (size_t i = 0; i < dropped; i++) needed += pairs_missing(rows, count, i, &allowed) > 0;
  CHECK(needed * 10 >= dropped * 9, "the control: of %zu rows only %zu are needed", dropped, needed);
  say("%zu pairs in %zu rows; without one of %zu rows a pair is missing %zu times", allowed, count, dropped, needed);
}

/* --- what stands in the scene --- */

enum { FLOOR_THING, SUBJECT, COMPANION, OTHER_COMPANION, LAMP, CURTAIN_THING, CASE_THING, MOST_THINGS };
enum { MOST_KEYS = 3, MOST_COPIES = 4 };

/* A mesh, given directly or as the model of instances. Texture coordinates are affine in the place within the mesh. */
typedef struct thing {
  bool there;
  bool placed;                     /* by transforms; else these are part of the positions */
  mesh shape;                      /* with its keys */
  float *coordinates, *normals;    /* normals: NULL, or for all keys */
  float transform[MOST_KEYS * 12]; /* keys of the place */
  uint32_t place_keys, copies;     /* copies: further instances */
  uint32_t role;                   /* material */
  uint32_t group, mask;
  uint32_t model, instance, index; /* as the scene has them */
} thing;

/* Returns a texture coordinate of a place within a mesh. */
static float coordinate_of(int which, const float p[3]) {
  return which ? 0.25f * p[0] - 0.5f * p[1] + 0.375f * p[2] + 0.125f
               : 0.5f * p[0] + 0.25f * p[1] - 0.125f * p[2] + 0.5f;
}

/* How a shape moves within itself: its key k is as large as this, and shifted so. Times between keys lie between. */
static float key_scale(uint32_t key) { return 1 + 0.125f * (float)key; }
static float key_shift(uint32_t key, int axis) {
  return (axis == 0 ? 0.375f : axis == 1 ? 0.125f : -0.25f) * (float)key;
}

/* Gives a shape its further keys. */
static void give_keys(mesh *m, uint32_t keys) {
  const size_t floats = 3 * (size_t)m->nv;
  m->p = realloc(m->p, keys * floats * sizeof *m->p);
  if (!m->p) abort();
  m->keys = keys;
  for (size_t i = floats; i < keys * floats; i++) {
    const uint32_t key = (uint32_t)(i / floats);
    m->p[i] = key_scale(key) * m->p[i % floats] + key_shift(key, (int)(i % 3));
  }
}

/* Fills in a thing of a shape, which it takes, at a place: three rows of four. */
static void set_thing(
    thing *t, mesh shape, uint32_t keys, bool smooth, const float place[12], bool placed, uint32_t role) {
  t->there = true;
  t->placed = placed;
  t->shape = shape;
  t->role = role;
  t->place_keys = 1;
  t->coordinates = calloc(2 * (size_t)shape.nv, sizeof(float));
  t->normals = smooth ? calloc(3 * (size_t)shape.nv * keys, sizeof(float)) : NULL;
  if (!t->coordinates || (smooth && !t->normals)) abort();

  for (uint32_t v = 0; v < shape.nv; v++) {
    const float *p = shape.p + 3 * (size_t)v;
    for (int k = 0; k < 2; k++) t->coordinates[2 * v + (uint32_t)k] = coordinate_of(k, p);
    const float length = sqrtf(dot3(p, p));
    for (uint32_t i = 0; i < 3 * keys && smooth; i++)
      t->normals[3 * ((size_t)(i / 3) * shape.nv + v) + i % 3] = p[i % 3] / length;
  }

  give_keys(&t->shape, keys);
  memcpy(t->transform, place, 12 * sizeof(float));
  for (uint32_t k = 0; k < MOST_KEYS; k++) {
    float *to = t->transform + 12 * k;
    memcpy(to, place, 12 * sizeof(float));
    to[3] -= 0.25f * (float)k;
    to[7] += 0.125f * (float)k;
    to[4] += 0.125f * (float)k; /* and it turns a little */
  }

  for (size_t i = 0; i < (size_t)t->shape.nv * keys && !placed; i++) {
    float *p = t->shape.p + 3 * i;
    for (int a = 0; a < 3; a++) p[a] = place[5 * a] * p[a] + place[4 * a + 3];
  }
}

/* Takes the indices of a thing away: three vertices for each triangle, each a copy. */
static void make_loose(thing *t) {
  const uint32_t count = 3 * t->shape.nt;
  mesh loose = mesh_of(count * t->shape.keys, t->shape.nt);
  float *coordinates = calloc(2 * (size_t)count, sizeof(float));
  float *normals = t->normals ? calloc(3 * (size_t)count * t->shape.keys, sizeof(float)) : NULL;
  if (!coordinates || (t->normals && !normals)) abort();
  loose.nv = count;
  loose.keys = t->shape.keys;

  for (uint32_t i = 0; i < count; i++) {
    const uint32_t v = t->shape.i[i];
    loose.i[i] = i;
    memcpy(coordinates + 2 * (size_t)i, t->coordinates + 2 * (size_t)v, 2 * sizeof(float));
    for (uint32_t k = 0; k < loose.keys; k++) {
      const size_t to = 3 * ((size_t)k * count + i);
      const size_t from = 3 * ((size_t)k * t->shape.nv + v);
      memcpy(loose.p + to, t->shape.p + from, 3 * sizeof(float));
      if (normals) memcpy(normals + to, t->normals + from, 3 * sizeof(float));
    }
  }

  mesh_free(&t->shape);
  free(t->coordinates);
  free(t->normals);
  t->shape = loose;
  t->coordinates = coordinates;
  t->normals = normals;
}

/* Returns a sheet in the plane z = 0, [-1, 1]^2, of four by four squares that face z. */
static mesh sheet_shape(void) {
  mesh m = mesh_grid(4, 1);
  for (uint32_t v = 0; v < m.nv; v++) {
    m.p[3 * v + 1] = -m.p[3 * v + 2];
    m.p[3 * v + 2] = 0;
  }
  return m;
}

/* Returns long thin triangles that criss-cross among small ones: of what trees of the high quality split. */
static mesh beams_shape(void) {
  mesh m = mesh_soup(64, 0.0625f, 4);
  rng r = rng_of(6);
  for (uint32_t i = 0; i < 9 * 16; i++) {
    const uint32_t within = i % 9;
    m.p[i] = within < 6 ? rng_sign(&r) : m.p[i - 3] + 0.0625f * rng_sign(&r);
  }
  return m;
}

static const float eye[3] = {0.25f, 1.25f, 4.25f};
static const float lamp_at[3] = {0.75f, 2, 0.875f};

/* Fills in all that stands in the scene of a row. */
static void make_things(const row *r, thing things[MOST_THINGS]) {
  static const float floor_place[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  static const float subject_place[4][12] = {{0.625f, 0, 0, -0.375f, 0, 0.625f, 0, 0.75f, 0, 0, 0.625f, 0},
      {0.625f, 0, 0, -0.375f, 0, 0.625f, 0, 0.75f, 0, 0, 0.625f, 0},
      {-0.625f, 0, 0, -0.375f, 0, 0.5f, 0.25f, 0.75f, 0, 0, 0.625f, 0},
      {0.875f, 0.25f, 0, -0.375f, 0, 0.375f, 0.125f, 0.75f, 0.125f, 0, 0.75f, 0}};
  static const float companion_place[12] = {0.25f, 0, 0, 0.875f, 0, 0.375f, 0, 0.375f, 0, 0, 0.25f, -0.75f};
  static const float other_place[12] = {0.375f, 0, 0, -1.25f, 0, 0.375f, 0, 0.75f, 0, 0, 0.375f, -0.5f};
  static const float sheet_place[12] = {0.75f, 0, 0, 0.375f, 0, 0.5f, 0, 0.875f, 0, 0, 1, 1.5f};
  const uint8_t *level = r->level;
  memset(things, 0, MOST_THINGS * sizeof *things);

  const uint32_t geometry = level[GEOMETRY];
  const uint32_t motion = level[MOTION];
  const uint32_t keys = motion == TWO_KEYS || motion == BOTH_MOVE ? 2 : motion == THREE_KEYS ? 3 : 1;
  set_thing(&things[FLOOR_THING], mesh_grid(4, 4), 1, false, floor_place, false, FLOOR_THING);
  set_thing(&things[SUBJECT], mesh_sphere(1, 0.0625f, 3), keys, level[NORMALS] != FLAT,
      subject_place[geometry == MANY ? PLACED : geometry], geometry != DIRECT, SUBJECT);
  if (motion >= MOVING_PLACE) things[SUBJECT].place_keys = motion == BOTH_MOVE ? 3 : 2;
  if (geometry == MANY) things[SUBJECT].copies = MOST_COPIES;
  set_thing(&things[COMPANION], mesh_box(), keys, false, companion_place, false, COMPANION);
  set_thing(&things[OTHER_COMPANION], beams_shape(), keys, false, other_place, false, OTHER_COMPANION);

  if (level[LIGHT] >= MESH && level[LIGHT] <= GLOWING_PLACE) {
    const float place[12] = {0.25f, 0, 0, lamp_at[0], 0, 0.25f, 0, lamp_at[1], 0, 0, 0.25f, lamp_at[2]};
    set_thing(&things[LAMP], sheet_shape(), level[LIGHT] == MOVING_MESH ? 2 : 1, false, place,
        level[LIGHT] == GLOWING_PLACE, LAMP);
  }
  if (level[CURTAIN] != NO_CURTAIN)
    set_thing(
        &things[CURTAIN_THING], sheet_shape(), 1, false, sheet_place, level[CURTAIN] == PLACED_SHEET, CURTAIN_THING);
  if (level[CASE] != NO_CASE) {
    const float *at = level[CASE] == AROUND_LAMP ? lamp_at : eye;
    const float place[12] = {0.5f, 0, 0, at[0], 0, 0.5f, 0, at[1], 0, 0, 0.5f, at[2]};
    set_thing(
        &things[CASE_THING], mesh_box(), level[CASE] == MOVING_AROUND_CAMERA ? 3 : 1, false, place, false, CASE_THING);
  }

  for (uint32_t i = 0; i < MOST_THINGS; i++) {
    thing *t = &things[i];
    if (!t->there) continue;
    if (level[SOUP]) make_loose(t);
    if (level[GROUPS] & 1) t->group = 1 + i % 3;
    if (level[GROUPS] & 2) t->mask = 1u << i % 4;
  }
}

/* Gives the memory of all things back. */
static void free_things(thing things[MOST_THINGS]) {
  for (uint32_t i = 0; i < MOST_THINGS; i++) {
    if (!things[i].there) continue;
    mesh_free(&things[i].shape);
    free(things[i].coordinates);
    free(things[i].normals);
  }
}

/* --- materials, lights, hooks --- */

/* Returns whether a place of a pattern of checks is dark. */
static bool is_dark(float u, float v) {
  const int i = (int)floorf(4 * u);
  const int j = (int)floorf(4 * v);
  return ((i + j) & 1) != 0;
}

static void texture_by_coordinates(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    if (!is_dark(p->texcoord[0][i], p->texcoord[1][i])) continue;
    for (int k = 0; k < 3; k++) {
      p->albedo[k][i] *= 0.25f + 0.125f * (float)k;
      p->reflectance[k][i] *= 0.5f;
    }
  }
}

static void texture_by_point(void *user, const pktrt_points *p) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    p->albedo[0][i] *= 0.5f + 0.5f * p->barycentric[0][i];
    p->albedo[1][i] *= p->triangle[i] % 3 ? 1.0f : 0.5f;
    p->albedo[2][i] *= 1 - 0.5f * p->time[i];
    p->reflectance[0][i] *= p->mesh[i] & 1 ? 1.0f : 0.75f;
    p->reflectance[1][i] *= 0.75f + 0.25f * p->normal[1][i] * p->direction[2][i];
    p->emission[2][i] += 0.03125f * (p->position[0][i] > 0 ? p->position[0][i] : 0);
  }
}

/* Cuts stripes by coordinates, then goes on as one of the other textures. */
static void cut_stripes(const pktrt_points *p) {
  for (uint32_t i = 0; i < p->n; i++) {
    const float stripe = 3 * p->texcoord[0][i] + p->texcoord[1][i];
    if (stripe - floorf(stripe) < 0.5f) p->opacity[i] = 0;
  }
}

static void cut(void *user, const pktrt_points *p) {
  (void)user;
  cut_stripes(p);
}

static void cut_by_coordinates(void *user, const pktrt_points *p) {
  cut_stripes(p);
  texture_by_coordinates(user, p);
}

static void cut_by_point(void *user, const pktrt_points *p) {
  cut_stripes(p);
  texture_by_point(user, p);
}

static void shade_by_normal(void *user, const pktrt_points *p, float *radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < p->n; i++) {
    for (int k = 0; k < 3; k++) radiance[k][i] = 0.5f + 0.5f * p->normal[k][i] * p->albedo[k][i];
    radiance[0][i] += 0.25f * p->texcoord[0][i] * p->texcoord[0][i];
    radiance[1][i] += 0.25f * p->time[i];
  }
}

static void bright_sky(void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const float to_sun = 0.6f * direction[0][i] + 0.64f * direction[1][i] + 0.48f * direction[2][i];
    const float value = to_sun > 0.96875f ? 20.0f : 0.25f + 0.125f * direction[1][i];
    for (int k = 0; k < 3; k++) radiance[k][i] = value * (1 - 0.125f * (float)k);
  }
}

static float hashed_sample(void *user, uint32_t x, uint32_t y, uint32_t sample, uint32_t dimension, uint32_t seed) {
  (void)user;
  const uint64_t bits = mix64(mix64((uint64_t)x << 32 | y) ^ mix64((uint64_t)sample << 32 | dimension) ^ seed);
  return (float)(bits >> 40) * 0x1p-24f;
}

/* Returns the material of a thing. */
static pktrt_material material_for(const row *r, uint32_t role) {
  static void (*const plain[3])(void *, const pktrt_points *) = {NULL, texture_by_coordinates, texture_by_point};
  static void (*const cutting[3])(void *, const pktrt_points *) = {cut, cut_by_coordinates, cut_by_point};
  pktrt_material m = material_of(0.5, PKTRT_SPECULAR_NONE, 0);
  m.albedo[1] = 0.625f;
  m.texture = role == SUBJECT || role == FLOOR_THING ? plain[r->level[TEXTURE]] : NULL;

  if (role == LAMP) return lamp_of(6);
  if (role == CURTAIN_THING) {
    m.texture = cut;
    m.cutout = true;
  }
  if (role == CASE_THING) {
    m.specular = PKTRT_SPECULAR_DIELECTRIC;
    m.ior[0] = 1.125f;
    m.absorption[0] = 0.5f;
    m.absorption[1] = 0.25f;
  }
  if (role == FLOOR_THING && r->level[FLOOR]) {
    m.specular = PKTRT_SPECULAR_MIRROR;
    m.lobe = r->level[FLOOR] == 1 ? PKTRT_LOBE_PHONG : PKTRT_LOBE_IDEAL;
    m.exponent = 24;
    for (int k = 0; k < 3; k++) m.reflectance[k] = 0.25f;
  }
  if (role != SUBJECT) return m;

  const uint32_t kind = r->level[MATERIAL];
  if (kind == MIRROR || kind == GLOSS) {
    m.specular = PKTRT_SPECULAR_MIRROR;
    for (int k = 0; k < 3; k++) m.albedo[k] *= 0.5f;
    for (int k = 0; k < 3; k++) m.reflectance[k] = 0.5f;
  }
  if (kind == COAT || kind == GLOSSY_COAT) m.specular = PKTRT_SPECULAR_COAT;
  if (kind == METAL || kind == GLOSSY_METAL) {
    m.specular = PKTRT_SPECULAR_CONDUCTOR;
    for (int k = 0; k < 3; k++) m.ior[k] = 0.25f + 0.5f * (float)k;
    for (int k = 0; k < 3; k++) m.extinction[k] = 3;
  }
  if (kind == GLASS) {
    m.specular = PKTRT_SPECULAR_DIELECTRIC;
    m.ior[0] = 1.5f;
    m.absorption[1] = 0.75f;
    m.absorption[2] = 0.25f;
  }
  if (kind == GLOSS || kind == GLOSSY_COAT || kind == GLOSSY_METAL) {
    m.lobe = PKTRT_LOBE_PHONG;
    m.exponent = 12;
  }
  if (kind == CUTOUT) {
    m.cutout = true;
    m.texture = cutting[r->level[TEXTURE]];
  }
  if (kind == SHADER) m.shader = shade_by_normal;
  if (kind == THIN) {
    m.specular = PKTRT_SPECULAR_THIN;
    m.transmission = 0.75f;
  }
  if (kind == BLEND) {
    m.blend = true;
    m.transparency = 0.375f;
  }
  return m;
}

/* A lamp that is always there, on the back of the room, and faces the camera. */
static const quad back_lamp = {{-1.5, 0.5, -1.5}, {{0.75, 0, 0}, {0, 0.75, 0}}};

/* Fills in the row's lights and returns how many there are: that of the factor, two dim ones. */
static uint32_t lights_for(const row *r, uint32_t lamp_mesh, pktrt_light lights[3]) {
  static const pktrt_light_kind kinds[8] = {PKTRT_LIGHT_POINT, PKTRT_LIGHT_DIRECTIONAL, PKTRT_LIGHT_QUAD,
      PKTRT_LIGHT_SPHERE, PKTRT_LIGHT_MESH, PKTRT_LIGHT_MESH, PKTRT_LIGHT_POINT, PKTRT_LIGHT_ENVIRONMENT};
  static const double intensities[8] = {8, 1.5, 6, 6, 1, 1, 0.5, 1};
  const uint32_t which = r->level[LIGHT];
  const bool visible = r->level[VISIBLE] == 1;
  lights[0] = light_of(kinds[which], intensities[which]);
  if (which == QUAD) {
    const quad down = {{0.5, 2, 0.625}, {{0.5, 0, 0}, {0, 0, 0.5}}}; /* cross(x, z) is -y */
    lights[0] = quad_light(&down, intensities[which]);
  }
  for (int k = 0; k < 3 && which != QUAD; k++) lights[0].position[k] = lamp_at[k];
  lights[0].direction[0] = -0.5f;
  lights[0].direction[1] = -1;
  lights[0].direction[2] = -0.25f;
  lights[0].radius = 0.25f;
  lights[0].mesh = lamp_mesh;
  lights[0].visible = visible;

  lights[1] = quad_light(&back_lamp, 0.75);
  lights[1].visible = visible;
  lights[2] = light_of(PKTRT_LIGHT_POINT, 0.75);
  vec_put(vec_of(-2, 1.5, 2), lights[2].position);
  return 3;
}

/* --- how a scene came about --- */

/* Fills in where the vertices of a thing's key are, or its place: elsewhere by so many steps. */
static void displaced(const thing *t, uint32_t key, int steps, float *out) {
  const float by[3] = {0.375f * (float)steps, 0.25f * (float)steps, -0.5f * (float)steps};
  const size_t count = t->placed ? 12 : 3 * (size_t)t->shape.nv;
  memcpy(out, (t->placed ? t->transform : t->shape.p) + count * key, count * sizeof *out);
  for (size_t i = 0; i < count; i++) {
    if (t->placed) out[i] += i % 4 == 3 ? by[i / 4] : 0;
    else out[i] = steps ? out[i] * (1 + 0.125f * (float)(i % 2)) + by[i % 3] : out[i];
  }
}

enum { MOST_FLOATS = 4096 };

/* Returns how many keys of a thing can be set. */
static uint32_t keys_of(const thing *t) { return t->placed ? t->place_keys : t->shape.keys; }

/* Sets one key of a thing. */
static void move_key(pktrt_scene *s, const thing *t, uint32_t key, int steps) {
  float at[MOST_FLOATS];
  displaced(t, key, steps, at);
  const pktrt_status status =
      t->placed ? pktrt_set_transform(s, t->instance, key, at) : pktrt_set_positions(s, t->index, key, at);
  CHECK(status == PKTRT_OK, "%s", pktrt_last_error(s));
}

/* Sets all keys of all things. */
static void move_things(pktrt_scene *s, const thing *things, int steps) {
  for (uint32_t i = 0; i < MOST_THINGS; i++) {
    for (uint32_t k = 0; things[i].there && k < keys_of(&things[i]); k++) move_key(s, &things[i], k, steps);
  }
}

/* Adds a thing, elsewhere by so many steps. A model is added once, and again shown by a new instance. */
static void add_thing(pktrt_scene *s, thing *t, uint32_t material, bool loose, int steps) {
  static float positions[MOST_KEYS * MOST_FLOATS];
  pktrt_mesh_desc d = mesh_desc(&t->shape);
  d.texcoords = t->coordinates;
  d.normals = t->normals;
  d.material = material;
  d.group = t->placed ? 0 : t->group;
  d.mask = t->mask;
  if (loose) d.indices = NULL;

  if (!t->placed) {
    for (uint32_t k = 0; k < t->shape.keys; k++) displaced(t, k, steps, positions + 3 * (size_t)t->shape.nv * k);
    d.positions = positions;
    CHECK(pktrt_add_mesh(s, &d, &t->index) == PKTRT_OK, "%s", pktrt_last_error(s));
    return;
  }

  float transforms[12 * MOST_KEYS];
  pktrt_instance_desc place;
  memset(&place, 0, sizeof place);
  if (t->model == PKTRT_NONE) CHECK(pktrt_add_model(s, &d, 1, &t->model) == PKTRT_OK, "%s", pktrt_last_error(s));
  for (uint32_t k = 0; k < t->place_keys; k++) displaced(t, k, steps, transforms + 12 * k);
  place.model = t->model;
  place.key_count = t->place_keys;
  place.transforms = transforms;
  CHECK(pktrt_add_instance(s, &place, &t->instance) == PKTRT_OK, "%s", pktrt_last_error(s));
}

/* Adds the further instances of a thing: small, in a row, some of them turned over. */
static void add_copies(pktrt_scene *s, const thing *t) {
  for (uint32_t i = 0; i < t->copies; i++) {
    const float size = i & 1 ? -0.1875f : 0.1875f;
    const float place[12] = {
        size, 0, 0, 0.375f * (float)i - 1, 0, 0.1875f, 0.0625f, 0.25f, 0.0625f, 0, 0.1875f, 0.875f};
    const pktrt_instance_desc d = {t->model, 1, place, 0, PKTRT_INTERPOLATION_LINEAR};
    CHECK(pktrt_add_instance(s, &d, NULL) == PKTRT_OK, "%s", pktrt_last_error(s));
  }
}

/* Hides or shows all things. */
static void enable_things(pktrt_scene *s, const thing *things, bool enabled) {
  for (uint32_t i = 0; i < MOST_THINGS; i++)
    if (things[i].there) CHECK(pktrt_set_enabled(s, things[i].index, enabled) == PKTRT_OK, "%s", pktrt_last_error(s));
}

enum { WIDE = 8, HIGH = 5, PIXELS = WIDE * HIGH, FLOATS = 3 * PIXELS };

/* A row's scene, with what stands in it. */
typedef struct stand {
  pktrt_scene *s;
  thing things[MOST_THINGS];
  float before[FLOATS]; /* a picture before the last step of its history */
  bool has_before;
  uint32_t commits, refits, glances;
} stand;

/* Commits what has changed, or refits where nothing was added or removed. */
static void commit_or_refit(stand *st, bool refit) {
  CHECK((refit ? pktrt_refit(st->s) : pktrt_commit(st->s)) == PKTRT_OK, "%s", pktrt_last_error(st->s));
  st->refits += refit;
  st->commits += !refit;
}

/* Takes a small picture of what there is now, so that what pictures keep is there before the scene changes. */
static void glance(stand *st, float *pixels) {
  st->glances++;
  pktrt_render_desc view = stage_view(PKTRT_MODE_DRT, WIDE, HIGH, pixels, vec_from(eye), vec_of(0.125, 0.75, 0));
  for (int k = 0; k < 3; k++) view.ambient[k] = 0.25f;
  view.max_depth = 2;
  stage_render(st->s, &view);
}

/* Lets the scene, in which all things stand elsewhere or are as they will be, come to its last state. */
static void live_through(stand *st, const row *r, const uint32_t material[MOST_THINGS]) {
  const uint32_t history = r->level[HISTORY];
  pktrt_scene *s = st->s;
  thing *things = st->things;
  if (history == FRESH) return;

  if (history == HIDDEN) {
    enable_things(s, things, false);
    commit_or_refit(st, true);
  }
  glance(st, st->before);
  st->has_before = true;

  if (history == HIDDEN) {
    enable_things(s, things, true);
    commit_or_refit(st, true);
  }
  if (history == REFITTED || history == REBUILT) {
    move_things(s, things, 0);
    commit_or_refit(st, history == REFITTED);
  }
  if (history == REBUILT) {
    CHECK(pktrt_mark_changed(s) == PKTRT_OK);
    commit_or_refit(st, false);
  }
  for (uint32_t i = 0; i < MOST_THINGS && history == KEY_BY_KEY; i++) {
    if (!things[i].there) continue;
    for (uint32_t k = keys_of(&things[i]); k-- > 0;) {
      float between[FLOATS];
      move_key(s, &things[i], k, 2);
      commit_or_refit(st, true);
      if (k == 0) glance(st, between);
      move_key(s, &things[i], k, 0);
      commit_or_refit(st, true);
    }
  }
  for (uint32_t i = 0; i < MOST_THINGS && history == REPLACED; i++) {
    thing *t = &things[i];
    if (!t->there) continue;
    const uint32_t index = t->index;
    const uint32_t instance = t->instance;
    const pktrt_status status = t->placed ? pktrt_remove_instance(s, t->instance) : pktrt_remove_mesh(s, t->index);
    CHECK(status == PKTRT_OK, "%s", pktrt_last_error(s));
    commit_or_refit(st, false);
    add_thing(s, t, material[i], r->level[SOUP] == 1, 0);
    CHECK(t->index == index && t->instance == instance, "thing %u is mesh %u, instance %u, not %u and %u", (unsigned)i,
        (unsigned)t->index, (unsigned)t->instance, (unsigned)index, (unsigned)instance);
    commit_or_refit(st, false);
  }
}

static pktrt_render_desc view_for(const row *r, pktrt_mode mode);

/* Opens the scene of a row. */
static void stand_open(stand *st, const row *r, pktrt_isa isa) {
  static const pktrt_build_quality qualities[3] = {PKTRT_BUILD_DEFAULT, PKTRT_BUILD_FAST, PKTRT_BUILD_HIGH};
  memset(st, 0, sizeof *st);
  pktrt_scene_desc d = scene_desc_of(isa, r->level[TILE] == 3 ? 3 : 0);
  d.quality = qualities[r->level[QUALITY]];
  d.rebuild = PKTRT_REBUILD_NEVER;
  st->s = pktrt_scene_create(&d);
  if (!CHECK(st->s != NULL, "%s", pktrt_last_error(NULL))) abort();
  make_things(r, st->things);

  uint32_t material[MOST_THINGS] = {0};
  for (uint32_t i = 0; i < MOST_THINGS; i++) {
    const pktrt_material m = material_for(r, i);
    material[i] = stage_material(st->s, &m);
  }

  const uint32_t history = r->level[HISTORY];
  const bool elsewhere = history != FRESH && history != HIDDEN;
  uint32_t next = 0;
  for (uint32_t i = 0; i < MOST_THINGS; i++) {
    thing *t = &st->things[i];
    if (!t->there) continue;
    t->model = PKTRT_NONE;
    t->index = next;
    add_thing(st->s, t, material[i], r->level[SOUP] == 1, elsewhere);
    CHECK(t->index == next, "mesh %u, not %u", (unsigned)t->index, (unsigned)next);
    next++;
  }
  add_copies(st->s, &st->things[SUBJECT]);

  pktrt_light lights[3];
  const uint32_t count = lights_for(r, st->things[LAMP].index, lights);
  for (uint32_t i = 0; i < count; i++) stage_light(st->s, &lights[i]);
  commit_or_refit(st, false);
  live_through(st, r, material);

  if (r->level[SKY] == PREPARED && r->level[LIGHT] == ENVIRONMENT) {
    float none[FLOATS];
    pktrt_render_desc view = view_for(r, PKTRT_MODE_DRT);
    view.pixels = none;
    CHECK(pktrt_prepare_environment(st->s, &view) == PKTRT_OK, "%s", pktrt_last_error(st->s));
  }
}

static void stand_close(stand *st) {
  pktrt_scene_destroy(st->s);
  free_things(st->things);
}

/* --- pictures --- */

/* Returns what a row asks for, without pixels and outputs. */
static pktrt_render_desc view_for(const row *r, pktrt_mode mode) {
  static const pktrt_sampler samplers[5] = {PKTRT_SAMPLER_SOBOL, PKTRT_SAMPLER_RANDOM, PKTRT_SAMPLER_INTERLEAVED,
      PKTRT_SAMPLER_BLUE_NOISE, PKTRT_SAMPLER_CUSTOM};
  static const uint32_t samples[5] = {1, 2, 4, 2, 3};
  static const uint32_t depths[5] = {0, 1, 3, 4, 0};
  static const float attenuations[5] = {0, 0, 0, -1, 0.25f};
  static const uint32_t tiles[4] = {64, 4, 5, 1};
  static const uint32_t packets[4] = {8, 2, 4, 16};
  static const float times[4] = {0, 0.625f, 0, 0.25f};
  static const float shutters[4] = {0, 0, 1, 0.5f};
  const uint8_t *level = r->level;

  pktrt_render_desc d = stage_view(mode, WIDE, HIGH, NULL, vec_from(eye), vec_of(0.125, 0.75, 0));
  d.samples = samples[level[SAMPLING]];
  d.sampler = samplers[level[SAMPLING]];
  if (d.sampler == PKTRT_SAMPLER_CUSTOM) d.custom_sampler = hashed_sample;
  d.seed = 5;
  d.lights = (pktrt_light_choice)level[CHOICE];
  d.normals = level[NORMALS] == SMOOTH_IGNORED ? PKTRT_NORMALS_GEOMETRIC : PKTRT_NORMALS_SMOOTH;
  d.camera.fov_y = 48;
  d.camera.time = times[level[SHUTTER]];
  d.camera.shutter = shutters[level[SHUTTER]];
  if (level[CAMERA]) {
    d.camera.moving = true;
    memcpy(d.camera.eye_end, d.camera.eye, sizeof d.camera.eye);
    memcpy(d.camera.target_end, d.camera.target, sizeof d.camera.target);
    d.camera.eye_end[0] += 0.75f;
    d.camera.up_end[0] = 0.125f;
    d.camera.up_end[1] = 1;
  }
  d.camera.aperture = level[LENS] ? 0.25f : 0.0f;
  d.glass_shadows = level[GLASS_SHADOWS] ? PKTRT_GLASS_SHADOWS_BLOCK : PKTRT_GLASS_SHADOWS_PASS;
  d.max_depth = depths[level[DEPTH]];
  d.attenuation = attenuations[level[DEPTH]];
  d.branching = (pktrt_branching)level[BRANCHING];
  d.phong_mapping = level[PHONG] ? PKTRT_PHONG_NAIVE : PKTRT_PHONG_CAREFUL;
  d.passes = level[PASSES] == ONE_PASS ? 1 : 3;
  d.adaptive = level[PASSES] == ADAPTIVE;
  if (level[SKY] == CALLBACK || level[SKY] == PREPARED) d.environment = bright_sky;
  for (int k = 0; k < 3; k++) {
    d.background[k] = level[SKY] == CONSTANT ? 0.375f + 0.125f * (float)k : level[SKY] == DARK ? 0.03125f : 0;
    d.ambient[k] = level[SKY] == DARK ? 0.1875f : 0;
  }
  d.tile_size = tiles[level[TILE]];
  d.packet_size = packets[level[TILE]];
  d.assembly = (pktrt_assembly)level[ASSEMBLY];
  d.shadows = level[SHADOWS] ? PKTRT_SHADOWS_TOGETHER : PKTRT_SHADOWS_PER_LIGHT;
  return d;
}

/* All that a render writes and that must have the same bits; what is not asked for stays as it was cleared. */
typedef struct output {
  float pixels[FLOATS], depth[PIXELS], normal[FLOATS], albedo[FLOATS];
  uint32_t count[PIXELS];
  float pixel_error[PIXELS], block_error[1];
  pktrt_report report;
} output;

/* What a render did besides: it differs from way to way. */
typedef struct work {
  pktrt_stats stats;
  float cost[PIXELS];
  size_t reports;          /* calls of progress */
  size_t packets, squares; /* packets that were told, and the sum of their squared sizes */
} work;

static bool count_progress(void *user, float done) {
  work *w = user;
  (void)done;
  __sync_fetch_and_add(&w->reports, 1);
  return true;
}

static void count_packet(void *user, const pktrt_packet *packet) {
  work *w = user;
  __sync_fetch_and_add(&w->packets, 1);
  __sync_fetch_and_add(&w->squares, (size_t)packet->n * packet->n);
}

/* Asks for buffers: of what primary rays meet, or of errors. */
static void ask_for(pktrt_render_desc *d, const row *r, output *out, bool surfaces, bool errors) {
  d->pixels = out->pixels;
  if (surfaces && r->level[OUTPUTS] == BUFFERS) {
    d->depth = out->depth;
    d->normal = out->normal;
    d->albedo = out->albedo;
    d->sample_count = out->count;
  }
  if (errors && r->level[PASSES] != ONE_PASS) {
    d->report = &out->report;
    d->pixel_error = out->pixel_error;
    d->block_error = out->block_error;
  }
}

/* A clock that stands still, so that reports have the same bits. */
static double no_time(void *user) {
  (void)user;
  return 0;
}

/* Renders a row as it asks for. */
static void render_row(const stand *st, const row *r, pktrt_mode mode, pktrt_path path, output *out, work *w) {
  pktrt_render_desc d = view_for(r, mode);
  memset(out, 0, sizeof *out);
  memset(w, 0, sizeof *w);
  d.path = path;
  d.user = w;
  d.seconds = no_time;
  d.progress = count_progress;
  ask_for(&d, r, out, true, true);
  if (r->level[OUTPUTS] == COUNTS) {
    d.stats = &w->stats;
    d.packet = count_packet;
  }
  if (r->level[OUTPUTS] == COST) d.cost = w->cost;
  if (r->level[SKY] == PREPARED) { /* of which no other user pointer must know */
    d.user = NULL;
    d.progress = NULL;
    d.packet = NULL;
  }
  CHECK(pktrt_render(st->s, &d) == PKTRT_OK, "%s; %s", pktrt_last_error(st->s), row_text(r));
}

/* Renders a row the plain way: each ray alone and, but where passes depend on the whole picture, each pixel alone; errors
   from the sums of passes that were rendered pixel by pixel. */
static void render_plain(const stand *st, const row *r, pktrt_mode mode, output *out) {
  row asked = *r;
  asked.level[TILE] = asked.level[ASSEMBLY] = asked.level[SHADOWS] = 0;
  pktrt_render_desc d = view_for(&asked, mode);
  memset(out, 0, sizeof *out);
  d.path = PKTRT_PATH_SINGLE;
  d.seconds = no_time;
  d.tile_size = 1;

  if (d.adaptive) {
    ask_for(&d, r, out, true, true);
    CHECK(pktrt_render(st->s, &d) == PKTRT_OK, "%s", pktrt_last_error(st->s));
    return;
  }

  ask_for(&d, r, out, true, false);
  const bool by_tiles = d.passes == 1 || r->level[OUTPUTS] == BUFFERS;
  for (uint32_t i = 0; i < PIXELS && by_tiles; i++)
    CHECK(pktrt_render_tile(st->s, &d, i % WIDE, i / WIDE, 1, 1) == PKTRT_OK, "%s", row_text(r));
  if (d.passes == 1) return;

  pktrt_pixel_sums sums[PIXELS];
  memset(sums, 0, sizeof sums);
  pktrt_render_desc passes = view_for(&asked, mode);
  float pixels[FLOATS];
  passes.path = PKTRT_PATH_SINGLE;
  passes.seconds = no_time;
  ask_for(&passes, r, out, false, true);
  memcpy(pixels, out->pixels, sizeof pixels);
  for (uint32_t i = 0; i < PIXELS * passes.passes; i++) {
    double means[3];
    const uint32_t at = i % PIXELS;
    CHECK(pktrt_render_pass(st->s, &passes, i / PIXELS, at % WIDE, at / WIDE, 1, 1, means) == PKTRT_OK);
    pktrt_add_pass(means, 1, &sums[at]);
  }
  CHECK(pktrt_finish_passes(st->s, &passes, passes.passes, sums) == PKTRT_OK, "%s", pktrt_last_error(st->s));
  CHECK(!by_tiles || same_bits(pixels, out->pixels, sizeof pixels), "pixels of passes and of tiles; %s", row_text(r));
}

/* Returns the first of a render's outputs whose bits differ, or NULL. */
static const char *difference(const output *a, const output *b) {
  if (!same_bits(a->pixels, b->pixels, sizeof a->pixels)) return "pixels";
  if (!same_bits(a->depth, b->depth, sizeof a->depth)) return "depths";
  if (!same_bits(a->normal, b->normal, sizeof a->normal)) return "normals";
  if (!same_bits(a->albedo, b->albedo, sizeof a->albedo)) return "albedos";
  if (!same_bits(a->count, b->count, sizeof a->count)) return "counts of samples";
  if (!same_bits(a->pixel_error, b->pixel_error, sizeof a->pixel_error)) return "errors of pixels";
  if (!same_bits(a->block_error, b->block_error, sizeof a->block_error)) return "the error of a block";
  const pktrt_report *p = &a->report;
  const pktrt_report *q = &b->report;
  const bool same = p->rounds == q->rounds && p->samples_min == q->samples_min && p->samples_max == q->samples_max &&
                    same_bits(&p->rmse, &q->rmse, sizeof p->rmse) &&
                    same_bits(&p->relative_mse, &q->relative_mse, sizeof p->relative_mse) && p->stop == q->stop;
  return same ? NULL : "the report";
}

/* Returns a row with the levels that change no bit at their first. */
static row plain_row(const row *r) {
  row plain = *r;
  for (uint32_t f = FIRST_NEUTRAL; f < FACTORS; f++) plain.level[f] = 0;
  return plain;
}

typedef struct tally {
  size_t rows, pictures, wrong, before;
  size_t lit; /* pixels that are not black */
} tally;

/* Compares a row's pictures with those of the plain path. */
static void compare_row(const row *r, size_t number, tally *all) {
  static output want, got;
  static work w;
  static stand plain, st[8];
  const row bare = plain_row(r);
  stand_open(&plain, &bare, isas[0]);
  for (int k = 0; k < isa_count; k++) stand_open(&st[k], r, isas[k]);
  all->rows++;

  for (int mode = PKTRT_MODE_RCS; mode <= PKTRT_MODE_DRT; mode++) {
    render_plain(&plain, r, (pktrt_mode)mode, &want);
    for (uint32_t i = 0; i < FLOATS; i++) all->lit += want.pixels[i] > 0;

    for (int k = 0; k <= isa_count; k++) { /* at last the paper's path, by one set */
      const bool paper = k == isa_count;
      if (paper && (number + (size_t)mode) % 2) continue;
      if (!paper && mode != PKTRT_MODE_DRT && (number + (size_t)mode) % (size_t)isa_count != (size_t)k) continue;
      const int isa = paper ? (int)(number % (size_t)isa_count) : k;
      render_row(&st[isa], r, (pktrt_mode)mode, paper ? PKTRT_PATH_PAPER : PKTRT_PATH_FAST, &got, &w);
      const char *differs = difference(&want, &got);
      all->pictures++;
      all->wrong += differs != NULL;
      CHECK(!differs, "row %zu, mode %d, %s, %s path: %s differ; %s", number, mode, pktrt_isa_string(isas[isa]),
          paper ? "paper" : "fast", differs, row_text(r));
    }
  }

  /* Interactions with the order of rays take three or four levels: those that reorder them, with what DRT has left in `want`. */
  const int last = (int)(number % (size_t)isa_count);
  for (uint32_t k = PKTRT_ASSEMBLY_MATERIALS; k <= PKTRT_ASSEMBLY_OCTANTS; k++) {
    row assembled = *r;
    assembled.level[ASSEMBLY] = (uint8_t)k;
    render_row(&st[last], &assembled, PKTRT_MODE_DRT, PKTRT_PATH_FAST, &got, &w);
    const char *differs = difference(&want, &got);
    all->pictures++;
    all->wrong += differs != NULL;
    CHECK(!differs, "row %zu, %s: %s differ; %s", number, factors[ASSEMBLY].level[k], differs, row_text(r));
  }

  if (st[0].has_before) {
    float after[FLOATS];
    glance(&st[0], after);
    all->before += !same_bits(st[0].before, after, sizeof after);
  }
  for (int k = 0; k < isa_count; k++) stand_close(&st[k]);
  stand_close(&plain);
}

static void pairs_have_the_bits_of_the_plain_path(void) {
  size_t count = 0;
  const row *rows = pair_rows(&count);
  tally all;
  memset(&all, 0, sizeof all);
  size_t aged = 0;
  const size_t wanted = small_run ? 8 : count;
  for (size_t i = 0; i < wanted; i++) {
    compare_row(&rows[i], i, &all);
    aged += rows[i].level[HISTORY] != FRESH;
  }
  CHECK(all.wrong == 0, "%zu pictures differ", all.wrong);
  CHECK(all.lit * 2 > all.rows * 3 * FLOATS, "most pixels show something");
  CHECK(all.before == aged, "the control: %zu of %zu pictures before a scene's last step differ", all.before, aged);
  say("%zu rows, %zu pictures: %zu differ from the plain path", all.rows, all.pictures, all.wrong);
}

/* Three by three: as many rows of that array as thoroughness allows, those that cover most first. */
static void triples_have_the_bits_of_the_plain_path(void) {
  enum { MOST_TRIPLE_ROWS = 2000 };
  row *rows = calloc(MOST_TRIPLE_ROWS, sizeof *rows);
  if (!rows) abort();
  tally all;
  memset(&all, 0, sizeof all);
  size_t left = 0;
  const size_t count = make_rows(3, rows, thorough(MOST_TRIPLE_ROWS) / 4 + 1, &left);
  for (size_t i = 0; i < count; i++) compare_row(&rows[i], i, &all);
  CHECK(all.wrong == 0, "%zu pictures differ", all.wrong);
  say("%zu rows, %zu pictures: %zu differ; %zu triples of levels are left", all.rows, all.pictures, all.wrong, left);
  free(rows);
}

/* --- RCS anew, in double --- */

/* What the pictures are computed from, one sample in the middle of each pixel; faults are the controls. */
typedef struct anew {
  const stand *st;
  pktrt_render_desc view;
  pktrt_material material[MOST_THINGS];
  pktrt_light lights[3];
  uint32_t light_count;
  float time;
  bool reflects;                                  /* WRT */
  bool no_cutouts, no_shadows, no_textures, flat; /* controls */
} anew;

/* Returns which thing a mesh is of: those that are there in their order, then copies of the subject. */
static uint32_t role_of_mesh(const stand *st, uint32_t index) {
  for (uint32_t i = 0; i < MOST_THINGS; i++)
    if (st->things[i].there && st->things[i].index == index) return i;
  return SUBJECT;
}

/* What a point looks like, after its texture. */
typedef struct looks {
  pktrt_surface_info info;
  vec normal; /* to shade with */
  double albedo[3], reflectance[3], emission[3];
  float opacity;
  uint32_t role;
  bool shaded;
  double radiance[3]; /* of a shader */
} looks;

/* Returns what a hit looks like. */
static looks look_at(const anew *a, const pktrt_ray *ray, const pktrt_hit *hit) {
  looks out;
  memset(&out, 0, sizeof out);
  pktrt_surface(a->st->s, ray, hit, &out.info);
  out.role = role_of_mesh(a->st, hit->mesh);
  const pktrt_material *m = &a->material[out.role];
  const bool smooth = a->view.normals == PKTRT_NORMALS_SMOOTH && !a->flat;
  const float *normal = smooth ? out.info.shading_normal : out.info.normal;
  out.normal = vec_unit(vec_from(normal));

  float direction[3];
  float values[10] = {m->albedo[0], m->albedo[1], m->albedo[2], m->reflectance[0], m->reflectance[1], m->reflectance[2],
      m->emission[0], m->emission[1], m->emission[2], 1};
  float radiance[3] = {0, 0, 0};
  float *const written[3] = {&radiance[0], &radiance[1], &radiance[2]};
  float time = ray->time;
  vec_put(vec_unit(vec_from(ray->direction)), direction);
  for (int k = 0; k < 3 && m->specular == PKTRT_SPECULAR_CONDUCTOR; k++) values[3 + k] = 1;
  pktrt_points p;
  memset(&p, 0, sizeof p);
  p.n = 1;
  for (int k = 0; k < 3; k++) {
    p.position[k] = &out.info.position[k];
    p.direction[k] = &direction[k];
    p.normal[k] = &normal[k];
    p.albedo[k] = &values[k];
    p.reflectance[k] = &values[3 + k];
    p.emission[k] = &values[6 + k];
  }
  p.barycentric[0] = &hit->u;
  p.barycentric[1] = &hit->v;
  p.texcoord[0] = &out.info.texcoord[0];
  p.texcoord[1] = &out.info.texcoord[1];
  p.time = &time;
  p.mesh = &hit->mesh;
  p.triangle = &hit->triangle;
  p.opacity = &values[9];
  if (m->texture && !a->no_textures) m->texture(NULL, &p);
  if (m->shader) m->shader(NULL, &p, (float **)written);

  out.shaded = m->shader != NULL;
  out.opacity = a->no_cutouts ? 1 : values[9];
  for (int k = 0; k < 3; k++) {
    out.albedo[k] = (double)values[k];
    out.reflectance[k] = (double)values[3 + k];
    out.emission[k] = (double)values[6 + k];
    out.radiance[k] = (double)radiance[k];
  }
  return out;
}

/* Finds the nearest hit that is there, cutouts considered. */
static bool first_there(const anew *a, const pktrt_ray *ray, pktrt_hit *hit, looks *found) {
  const pktrt_hit *previous = NULL;
  while (pktrt_intersect_after(a->st->s, ray, previous, hit)) {
    *found = look_at(a, ray, hit);
    if (found->opacity >= 0.5f) return true;
    previous = hit;
  }
  return false;
}

/* Finds the way from a point up to the weighted mean of its feet on the planes of the triangle's vertices, which it may
   lie below. Returns false if their normals are nearly the triangle's. */
static bool way_up(const anew *a, const pktrt_ray *ray, const pktrt_hit *hit, const looks *at, vec *up) {
  const double weight[3] = {1 - (double)hit->u - (double)hit->v, (double)hit->u, (double)hit->v};
  bool curved = false;
  *up = vec_of(0, 0, 0);
  if (a->view.normals != PKTRT_NORMALS_SMOOTH || a->flat) return false;
  for (int c = 0; c < 3; c++) {
    pktrt_hit corner = *hit;
    pktrt_surface_info info;
    corner.t = NAN;
    corner.u = c == 1;
    corner.v = c == 2;
    pktrt_surface(a->st->s, ray, &corner, &info);
    const vec normal = vec_from(info.shading_normal);
    const double height = vec_dot(normal, vec_sub(vec_from(at->info.position), vec_from(info.position)));
    const double along = vec_dot(normal, vec_from(at->info.normal));
    curved = curved || along * along < 0.9996;
    if (height < 0) *up = vec_sub(*up, vec_mul(normal, weight[c] * height));
  }
  return curved;
}

/* Returns whether nothing is between a hit and a point, so far of the way; of a direction, in it. Ways below the
   triangle begin above it. */
static bool is_lit(const anew *a, const pktrt_ray *ray, const pktrt_hit *hit, const looks *at, vec way, double end) {
  float direction[3];
  vec up = vec_of(0, 0, 0);
  pktrt_ray shadow;
  pktrt_hit blocker;
  looks found;
  const bool below = vec_dot(way, vec_from(at->info.normal)) <= 0;
  if (below && !way_up(a, ray, hit, at, &up)) return false;
  vec_put(way, direction);
  pktrt_spawn(a->st->s, ray, hit, below ? at->info.normal : direction, &shadow);
  if (below) {
    vec_put(up, shadow.direction);
    shadow.tmax = 1;
    if (pktrt_occluded(a->st->s, &shadow)) return false;
    vec_put(vec_add(vec_from(shadow.origin), up), shadow.origin);
    vec_put(end <= 1 ? vec_sub(way, up) : way, shadow.direction);
  }
  shadow.tmax = (float)end;
  return a->no_shadows || !first_there(a, &shadow, &blocker, &found);
}

/* Returns the radiance of the sky. */
static void sky_anew(const anew *a, vec direction, double out[3]) {
  float d[3];
  float value[3];
  const float *const rows_in[3] = {&d[0], &d[1], &d[2]};
  float *const rows_out[3] = {&value[0], &value[1], &value[2]};
  vec_put(vec_unit(direction), d);
  if (a->view.environment) bright_sky(NULL, 1, rows_in, rows_out);
  for (int k = 0; k < 3; k++) out[k] = (double)(a->view.environment ? value[k] : a->view.background[k]);
}

/* Adds the light of one lamp at a surface, by its middle, over the albedo. */
static void lamp_anew(const anew *a, const pktrt_light *light, const pktrt_ray *ray, const pktrt_hit *hit,
    const looks *at, double sum[3]) {
  const vec here = vec_from(at->info.position);
  vec middle = vec_from(light->position);
  double strength = 1;
  double end = 1 - 0x1p-22;
  double sky[3] = {1, 1, 1};

  if (light->kind == PKTRT_LIGHT_QUAD) {
    const vec edge[2] = {vec_from(light->edge[0]), vec_from(light->edge[1])};
    const vec facing = vec_cross(edge[0], edge[1]); /* as long as the lamp is large */
    middle = vec_add(middle, vec_mul(vec_add(edge[0], edge[1]), 0.5));
    strength = fmax(0, vec_dot(facing, vec_unit(vec_sub(here, middle))));
  }
  if (light->kind == PKTRT_LIGHT_SPHERE) {
    strength = PI * (double)(light->radius * light->radius);
    end = 1 - (double)light->radius / vec_length(vec_sub(middle, here));
  }
  vec way = vec_sub(middle, here);
  double falloff = 1 / vec_dot(way, way);
  if (light->kind == PKTRT_LIGHT_DIRECTIONAL) {
    way = vec_mul(vec_from(light->direction), -1);
    falloff = 1;
    end = INFINITY;
  }
  if (light->kind == PKTRT_LIGHT_ENVIRONMENT) {
    way = at->normal;
    falloff = PI;
    end = INFINITY;
    sky_anew(a, way, sky);
  }
  const double cosine = vec_dot(vec_unit(way), at->normal);
  if (cosine <= 0 || strength <= 0 || !is_lit(a, ray, hit, at, way, end)) return;
  for (int k = 0; k < 3; k++) sum[k] += (double)light->intensity[k] * sky[k] * strength * falloff * cosine / PI;
}

/* Returns how far along a ray a visible lamp is, or infinity. */
static double lamp_distance(const pktrt_light *light, const pktrt_ray *ray) {
  const vec o = vec_from(ray->origin);
  const vec d = vec_from(ray->direction);
  if (!light->visible) return INFINITY;
  if (light->kind == PKTRT_LIGHT_QUAD) {
    const vec edge[2] = {vec_from(light->edge[0]), vec_from(light->edge[1])};
    const vec facing = vec_cross(edge[0], edge[1]);
    const double slope = vec_dot(facing, d);
    const double t = vec_dot(facing, vec_sub(vec_from(light->position), o)) / slope;
    const vec off = vec_sub(vec_add(o, vec_mul(d, t)), vec_from(light->position));
    const double x = vec_dot(off, edge[0]) / vec_dot(edge[0], edge[0]); /* the edges are perpendicular here */
    const double y = vec_dot(off, edge[1]) / vec_dot(edge[1], edge[1]);
    return slope < 0 && t > 0 && x >= 0 && x <= 1 && y >= 0 && y <= 1 ? t : INFINITY;
  }
  if (light->kind == PKTRT_LIGHT_SPHERE) {
    const vec off = vec_sub(o, vec_from(light->position));
    const double b = vec_dot(off, d) / vec_dot(d, d);
    const double c = (vec_dot(off, off) - (double)(light->radius * light->radius)) / vec_dot(d, d);
    return b * b > c && -b - sqrt(b * b - c) > 0 ? -b - sqrt(b * b - c) : INFINITY;
  }
  return INFINITY;
}

/* Computes the radiance that a ray brings. In WRT mirrors and metals send on one ray each, until so many generations are
   there. */
static void radiance_anew(const anew *a, const pktrt_ray *ray, uint32_t generations, double out[3]) {
  pktrt_hit hit;
  looks at;
  memset(&at, 0, sizeof at);
  const bool met = first_there(a, ray, &hit, &at);
  double nearest = met ? (double)hit.t : INFINITY;
  const pktrt_light *seen = NULL;
  for (uint32_t i = 0; i < a->light_count; i++) {
    const double t = lamp_distance(&a->lights[i], ray);
    if (!(t < nearest)) continue;
    nearest = t;
    seen = &a->lights[i];
  }

  if (!met) sky_anew(a, vec_from(ray->direction), out);
  for (int k = 0; k < 3 && seen; k++) out[k] = (double)seen->intensity[k];
  if (!met || seen) return;
  double sum[3] = {(double)a->view.ambient[0], (double)a->view.ambient[1], (double)a->view.ambient[2]};
  for (uint32_t i = 0; i < a->light_count; i++) lamp_anew(a, &a->lights[i], ray, &hit, &at, sum);

  const pktrt_material *m = &a->material[at.role];
  const bool metal = a->reflects && m->specular == PKTRT_SPECULAR_CONDUCTOR;
  for (int k = 0; k < 3; k++)
    out[k] = at.shaded ? at.radiance[k] : at.emission[k] + (metal ? 0 : at.albedo[k] * sum[k]);
  if (at.shaded || !a->reflects || m->specular == PKTRT_SPECULAR_NONE || generations == 0) return;

  float direction[3];
  double further[3];
  pktrt_ray away;
  const vec way = vec_unit(vec_from(ray->direction));
  const vec flat_normal = vec_from(at.info.normal);
  const vec normal = vec_dot(way, at.normal) < 0 ? at.normal : flat_normal;
  vec mirrored = reflected(way, normal);
  if (vec_dot(mirrored, flat_normal) <= 0) mirrored = reflected(way, flat_normal);
  vec_put(mirrored, direction);
  pktrt_spawn(a->st->s, ray, &hit, direction, &away);
  radiance_anew(a, &away, generations - 1, further);
  for (int k = 0; k < 3; k++) {
    const double share =
        metal ? conductor_exact(-vec_dot(way, normal), (double)m->ior[k], (double)m->extinction[k]) : 1;
    out[k] += share * at.reflectance[k] * further[k];
  }
}

/* Computes one pixel. */
static void pixel_anew(const anew *a, uint32_t x, uint32_t y, double out[3]) {
  pktrt_ray ray;
  CHECK(pktrt_camera_ray(&a->view.camera, WIDE, HIGH, x + 0.5, y + 0.5, NULL, a->time, &ray));
  ray.time = a->time;
  radiance_anew(a, &ray, a->view.max_depth, out);
}

/* Returns how many pixels of a picture are not those that are computed anew. */
static size_t pixels_unlike(const anew *a, const float *pixels) {
  size_t unlike = 0;
  for (uint32_t i = 0; i < PIXELS; i++) {
    double want[3];
    bool same = true;
    pixel_anew(a, i % WIDE, i / WIDE, want);
    for (int k = 0; k < 3; k++) same &= fabs((double)pixels[3 * i + (uint32_t)k] - want[k]) <= 1e-4 * want[k] + 1e-5;
    unlike += !same;
  }
  return unlike;
}

/* Compares pictures of all rows, as far as the few lines above know what is in them: one sample, one pass, no light that is a
   mesh; in WRT neither glass nor gloss nor varnish, all rays followed. */
static void compare_anew(pktrt_mode mode) {
  static output got;
  static work w;
  static stand st;
  size_t count = 0;
  const row *rows = pair_rows(&count);
  size_t pictures = 0;
  size_t unlike = 0;
  size_t without[4] = {0, 0, 0, 0};
  const size_t wanted = small_run ? 12 : count;
  for (size_t i = 0; i < wanted; i++) {
    row r = rows[i];
    r.level[SAMPLING] = ONE_SAMPLE;
    r.level[PASSES] = ONE_PASS;
    if (r.level[LIGHT] == MESH || r.level[LIGHT] == MOVING_MESH) r.level[LIGHT] = GLOWING_PLACE;
    if (r.level[MATERIAL] == BLEND) r.level[MATERIAL] = CUTOUT; /* no chance here */
    if (mode == PKTRT_MODE_WRT) {
      const uint8_t known[MOST_LEVELS] = {
          MATT, MIRROR, MIRROR, MATT, METAL, METAL, METAL, MIRROR, CUTOUT, SHADER, MIRROR, CUTOUT};
      r.level[MATERIAL] = known[r.level[MATERIAL]];
      r.level[FLOOR] = r.level[FLOOR] ? 2 : 0;
      r.level[CASE] = NO_CASE;
      r.level[DEPTH] = 3;
    }
    stand_open(&st, &r, PKTRT_ISA_AUTO);
    render_row(&st, &r, mode, PKTRT_PATH_FAST, &got, &w);

    anew a;
    memset(&a, 0, sizeof a);
    a.st = &st;
    a.reflects = mode == PKTRT_MODE_WRT;
    a.view = view_for(&r, mode);
    a.time = a.view.camera.time + 0.5f * a.view.camera.shutter;
    a.light_count = lights_for(&r, 0, a.lights);
    for (uint32_t k = 0; k < MOST_THINGS; k++) a.material[k] = material_for(&r, k);
    const size_t wrong = pixels_unlike(&a, got.pixels);
    CHECK(wrong <= 1, "%s, row %zu: %zu of %d pixels; %s", a.reflects ? "WRT" : "RCS", i, wrong, (int)PIXELS,
        row_text(&r));
    unlike += wrong;
    pictures++;

    for (int k = 0; k < 4; k++) {
      anew b = a;
      b.no_cutouts = k == 0;
      b.no_shadows = k == 1;
      b.no_textures = k == 2;
      b.flat = k == 3;
      without[k] += pixels_unlike(&b, got.pixels) > 1;
    }
    stand_close(&st);
  }
  CHECK(unlike * 500 <= pictures * PIXELS, "%zu pixels", unlike);
  for (int k = 0; k < 4 && !small_run; k++)
    CHECK(without[k] > (k == 3 ? 0u : 10u), "control %d: %zu pictures differ", k, without[k]);
  say("%zu pictures, %zu pixels: %zu unlike; controls without cutouts, shadows, textures, normals: %zu, %zu, %zu, %zu",
      pictures, pictures * PIXELS, unlike, without[0], without[1], without[2], without[3]);
}

static void ray_casting_anew(void) { compare_anew(PKTRT_MODE_RCS); }

static void mirrors_anew(void) { compare_anew(PKTRT_MODE_WRT); }

/* --- queries --- */

/* Mixes what stands at evenly spread keys, `count` floats each, at a time. */
static void mix_keys(const float *keys, uint32_t key_count, uint32_t count, double time, double *out) {
  const double at = time * (double)(key_count - 1);
  const uint32_t first = key_count < 2 ? 0 : at >= key_count - 1 ? key_count - 2 : (uint32_t)at;
  const double part = key_count < 2 ? 0 : at - (double)first;
  for (uint32_t i = 0; i < count; i++) {
    const double from = (double)keys[count * first + i];
    const double to = key_count < 2 ? from : (double)keys[count * (first + 1) + i];
    out[i] = from + part * (to - from);
  }
}

/* Takes a vector back through the 3 x 3 part of a place. */
static vec solved(const double m[12], vec v) {
  const vec x = vec_of(m[0], m[4], m[8]);
  const vec y = vec_of(m[1], m[5], m[9]);
  const vec z = vec_of(m[2], m[6], m[10]);
  const double volume = vec_dot(x, vec_cross(y, z));
  return vec_of(
      vec_dot(v, vec_cross(y, z)) / volume, vec_dot(x, vec_cross(v, z)) / volume, vec_dot(x, vec_cross(y, v)) / volume);
}

/* Takes a point and a direction of the scene to where the shape of a thing was when it was made. */
static void to_shape(const thing *t, double time, vec *point, vec *direction) {
  double place[12];
  mix_keys(t->transform, t->placed ? t->place_keys : 1, 12, time, place);
  *point = solved(place, vec_sub(*point, vec_of(place[3], place[7], place[11])));
  *direction = solved(place, *direction);

  float motion[4 * MOST_KEYS];
  double moved[4];
  for (uint32_t k = 0; k < t->shape.keys; k++) {
    motion[4 * k] = key_scale(k);
    for (int a = 0; a < 3; a++) motion[4 * k + 1 + (uint32_t)a] = key_shift(k, a);
  }
  mix_keys(motion, t->shape.keys, 4, time, moved);
  *point = vec_mul(vec_sub(*point, vec_of(moved[1], moved[2], moved[3])), 1 / moved[0]);
}

typedef struct query_tally {
  size_t hits, coordinates, insides, starts, spots, bits; /* hits, and of these what is wrong */
  size_t inside, displaced; /* controls: inside; coordinates that another time would have */
} query_tally;

/* Compares what is said about a hit with what its thing is made of. */
static void check_hit(const stand *st, const pktrt_ray *ray, const pktrt_hit *hit, query_tally *all) {
  pktrt_surface_info info;
  pktrt_surface(st->s, ray, hit, &info);
  const vec there = vec_add(vec_from(ray->origin), vec_mul(vec_from(ray->direction), (double)hit->t));
  all->hits++;
  all->spots += vec_length(vec_sub(there, vec_from(info.position))) > 1e-5;

  /* A ray from there along the normal, and one back to the camera, start there and do not meet the triangle. */
  float back[3];
  vec_put(vec_mul(vec_from(ray->direction), -1), back);
  for (int i = 0; i < 2; i++) {
    pktrt_ray away;
    pktrt_hit met;
    pktrt_spawn_at(st->s, hit->mesh, hit->triangle, hit->u, hit->v, ray->time, i ? back : info.normal, &away);
    const bool again = pktrt_intersect(st->s, &away, &met) && met.mesh == hit->mesh && met.triangle == hit->triangle;
    const vec offset = vec_sub(vec_from(away.origin), there);
    const bool is_behind = vec_dot(offset, vec_from(info.normal)) < -1e-6;
    all->starts += again || is_behind || vec_length(offset) > 1e-5 || !(away.time == ray->time);
  }

  const thing *t = NULL;
  for (uint32_t i = 0; i < MOST_THINGS; i++)
    if (st->things[i].there && st->things[i].index == hit->mesh) t = &st->things[i];
  if (!t) return; /* a copy */
  vec point = there;
  vec direction = vec_from(ray->direction);
  to_shape(t, (double)ray->time, &point, &direction);
  vec later = there;
  vec unused = direction;
  to_shape(t, ray->time > 0.5f ? 0 : 1, &later, &unused);

  float within[3];
  float elsewhere[3];
  vec_put(point, within);
  vec_put(later, elsewhere);
  bool same = true;
  bool same_later = true;
  for (int k = 0; k < 2; k++) {
    same &= fabsf(info.texcoord[k] - coordinate_of(k, within)) < 1e-4f;
    same_later &= fabsf(info.texcoord[k] - coordinate_of(k, elsewhere)) < 1e-4f;
  }
  all->coordinates += !same;
  all->displaced += !same_later;

  vec corner[3];
  for (uint32_t c = 0; c < 3; c++) corner[c] = vec_from(t->shape.p + 3 * (size_t)t->shape.i[3 * hit->triangle + c]);
  const double along = vec_dot(direction, vec_cross(vec_sub(corner[1], corner[0]), vec_sub(corner[2], corner[0])));
  all->insides += info.inside != (along > 0);
  all->inside += info.inside;
}

static void queries_of_all_pairs(void) {
  static stand plain, st;
  size_t count = 0;
  const row *rows = pair_rows(&count);
  query_tally all;
  memset(&all, 0, sizeof all);
  const size_t wanted = small_run ? 12 : count;
  for (size_t i = 0; i < wanted; i++) {
    pktrt_ray rays[PIXELS];
    pktrt_hit want[PIXELS];
    const row bare = plain_row(&rows[i]);
    const pktrt_render_desc view = view_for(&bare, PKTRT_MODE_DRT);
    stand_open(&plain, &bare, isas[0]);
    for (uint32_t k = 0; k < PIXELS; k++) {
      const float time = (float)(k % 17) / 16;
      CHECK(pktrt_camera_ray(&view.camera, WIDE, HIGH, k % WIDE + 0.5, k / WIDE + 0.25, NULL, time, &rays[k]));
      rays[k].time = time;
      pktrt_intersect(plain.s, &rays[k], &want[k]);
    }

    for (int isa = 0; isa < isa_count; isa++) {
      pktrt_hit got[PIXELS];
      stand_open(&st, &rows[i], isas[isa]);
      pktrt_intersect_n(st.s, rays, got, PIXELS);
      for (uint32_t k = 0; k < PIXELS; k++) {
        all.bits += !same_bits(&got[k], &want[k], sizeof got[k]);
        pktrt_hit every[8];
        const size_t crossings = isa == 0 ? pktrt_intersect_all(st.s, &rays[k], every, COUNT(every)) : 0;
        for (size_t c = 0; c < crossings && c < COUNT(every); c++) check_hit(&st, &rays[k], &every[c], &all);
      }
      stand_close(&st);
    }
    stand_close(&plain);
  }
  CHECK(all.bits == 0, "%zu hits have other bits than by the plain path", all.bits);
  CHECK(all.spots == 0 && all.starts == 0, "%zu positions, %zu starts of rays", all.spots, all.starts);
  CHECK(all.coordinates == 0, "%zu texture coordinates", all.coordinates);
  CHECK(all.insides == 0, "%zu sides", all.insides);
  CHECK(all.inside > 0 && all.displaced > 0, "the controls: %zu, %zu", all.inside, all.displaced);
  say("%zu hits, all as expected; %zu from inside; %zu have other coordinates at another time", all.hits, all.inside,
      all.displaced);
}

/* --- each level makes a difference --- */

/* What tells the ways apart in which a row's picture, whose bits are the same, came about. */
typedef struct signature {
  uint64_t nodes, leaf_blocks, bytes, trees, grouped, masked;
  double sah[2];
  uint64_t commits, refits, glances, samples, reports, packets, squares, buffers, costs;
} signature;

/* Renders a row in one mode and tells how it came about; told_apart: by the packets of the paper's path, too. */
static void sign_row(const row *r, pktrt_mode mode, bool told_apart, output *out, signature *sign) {
  static work w;
  static stand st;
  memset(sign, 0, sizeof *sign);
  stand_open(&st, r, PKTRT_ISA_AUTO);
  pktrt_scene_info info;
  pktrt_get_scene_info(st.s, &info);
  sign->nodes = info.nodes;
  sign->leaf_blocks = info.leaf_blocks;
  sign->bytes = info.mesh_bytes;
  sign->sah[0] = info.sah_at_build;
  sign->sah[1] = info.sah_now;
  pktrt_tree tree;
  while (pktrt_get_tree(st.s, (uint32_t)sign->trees, &tree)) {
    sign->grouped += tree.group != 0;
    sign->masked += tree.mask != UINT32_MAX && tree.mask != 0;
    sign->trees++;
  }
  sign->commits = st.commits;
  sign->refits = st.refits;
  sign->glances = st.glances;

  render_row(&st, r, mode, PKTRT_PATH_FAST, out, &w);
  sign->samples = w.stats.samples;
  for (uint32_t i = 0; i < PIXELS; i++) {
    sign->costs += w.cost[i] > 0;
    sign->buffers += out->depth[i] > 0;
  }

  if (told_apart) {
    static output unused;
    row told = *r;
    told.level[OUTPUTS] = COUNTS;
    render_row(&st, &told, mode, PKTRT_PATH_PAPER, &unused, &w);
    sign->reports = w.reports;
    sign->packets = w.packets;
    sign->squares = w.squares;
  }
  stand_close(&st);
}

/* Returns whether a level in place of another changes a row's picture, in any mode; of what must not change it, the way in
   which it came about. */
static bool makes_a_difference(const row *r, uint32_t f, uint32_t other) {
  static output with, without;
  signature a;
  signature b;
  row changed = *r;
  changed.level[f] = (uint8_t)other;
  for (int mode = PKTRT_MODE_DRT; mode >= PKTRT_MODE_RCS; mode--) {
    sign_row(r, (pktrt_mode)mode, f >= FIRST_NEUTRAL, &with, &a);
    sign_row(&changed, (pktrt_mode)mode, f >= FIRST_NEUTRAL, &without, &b);
    const bool same = same_bits(with.pixels, without.pixels, sizeof with.pixels);
    CHECK(
        same || f < FIRST_NEUTRAL, "%s, %s: pixels differ; %s", factors[f].name, factors[f].level[other], row_text(r));
    if (f < FIRST_NEUTRAL ? !same : !same_bits(&a, &b, sizeof a)) return true;
  }
  return false;
}

static void each_level_makes_a_difference(void) {
  size_t count = 0;
  const row *rows = pair_rows(&count);
  size_t pairs = 0;
  size_t tried = 0;
  size_t made = 0;
  for (uint32_t f = 0; f < FACTORS; f++) {
    for (uint32_t a = 0; a < levels_of(f); a++) {
      for (uint32_t b = a + 1; b < levels_of(f); b++) {
        const bool alike = f == NORMALS && a == FLAT && b == SMOOTH_IGNORED;
        bool differs = false;
        if (pairs++ % (small_run ? 16 : 1)) continue;
        for (size_t i = 0, looked = 0; i < count && !differs && looked < (alike ? 3u : 99u); i++) {
          const row *r = &rows[i];
          if (r->level[f] != a || (f >= FIRST_NEUTRAL && r->level[SKY] == PREPARED)) continue;
          if (f == MOTION && clash(MOTION, b, GEOMETRY, r->level[GEOMETRY])) continue;
          if (f == GEOMETRY && clash(GEOMETRY, b, MOTION, r->level[MOTION])) continue;
          differs = makes_a_difference(r, f, b);
          made += differs;
          tried++;
          looked++;
        }
        CHECK(differs != alike, "%s: \"%s\" and \"%s\" are %s", factors[f].name, factors[f].level[a],
            factors[f].level[b], differs ? "not alike" : "alike in all rows");
      }
    }
  }
  say("%zu pairs of levels of one factor: %zu of %zu exchanges of one for the other make a difference", pairs, made,
      tried);
}

void suite_cover(void) {
  run("every pair of levels of 29 factors is in a row of the covering array", all_pairs_are_covered);
  run("pictures of ray casting are those that are computed anew in double", ray_casting_anew);
  run("pictures of mirrors and metals in WRT are those that are computed anew in double", mirrors_anew);
  run("hits of all pairs of features have the bits, sides, texture coordinates and starts that they should",
      queries_of_all_pairs);
  run("each level of each factor makes a difference", each_level_makes_a_difference);
  run("pictures of all pairs of features have the bits of one plain path", pairs_have_the_bits_of_the_plain_path);
  run("pictures of triples of features have the bits of one plain path", triples_have_the_bits_of_the_plain_path);
}
