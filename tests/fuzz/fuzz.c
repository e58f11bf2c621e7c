/* What the fuzz targets share: bytes, memory, sentences, materials and lights. */
#include "fuzz.h"
#include "../meshes.h"

/* --- bytes --- */

uint32_t take_u8(feed *b) {
  if (!b->left) return 0;
  b->left--;
  return *b->p++;
}

uint32_t take_u32(feed *b) {
  uint32_t x = 0;
  for (int i = 0; i < 4; i++) x |= take_u8(b) << 8 * i;
  return x;
}

uint32_t take_below(feed *b, uint32_t n) { return take_u8(b) % n; }

float take_tame(feed *b) { return (float)((int)take_u8(b) - 128) / 16; }

float take_float(feed *b) {
  /* clang-format off */
  static const float odd[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, FLT_MIN, -FLT_MIN, 0x1p-149f, -0x1p-149f, 0x1p-126f,
                              PKTRT_MAX_COORD, -PKTRT_MAX_COORD, 1.2676507e30f, -1.2676507e30f, -0.0f, 0.0f, 1, -1, 0.5f, 1e-30f,
                              1e30f, 3e38f, 1e10f, 1e-10f, 1 + FLT_EPSILON, 16777216, 2147483648.0f, 65536, 180, 360, 0.99999994f};
  /* clang-format on */
  const uint32_t kind = take_u8(b);
  if (kind < 160) return (float)((int)kind - 80) / 16;
  if (kind < 248) return odd[(kind - 160) % COUNT(odd)];
  const uint32_t bits = take_u32(b);
  float x;
  memcpy(&x, &bits, sizeof x);
  return x;
}

void take_floats(feed *b, float *to, int n) {
  for (int i = 0; i < n; i++) to[i] = take_float(b);
}
void take_tames(feed *b, float *to, int n) {
  for (int i = 0; i < n; i++) to[i] = take_tame(b);
}

/* --- memory --- */

static void *fuzz_allocate(void *user, size_t size, size_t align) {
  fuzz_memory *m = user;
  m->calls++;
  if (size > (size_t)64 << 20 || (m->fail_at && --m->fail_at == 0)) {
    m->failed++;
    return NULL;
  }
  void *p = NULL;
  if (posix_memalign(&p, align, size)) return NULL;
  memset(p, 0xA5, size); /* whoever reads memory before writing it sees rubbish, the same one every time */
  m->blocks++;
  return p;
}

static void fuzz_release(void *user, void *p, size_t size) {
  fuzz_memory *m = user;
  memset(p, 0x5A, size); /* of the size that it says: one too large is seen by AddressSanitizer */
  m->blocks--;
  free(p);
}

static void fuzz_backwards(void *user, size_t n, void (*body)(void *arg, size_t i), void *arg) {
  (void)user;
  while (n--) body(arg, n);
}

pktrt_scene_desc fuzz_scene_desc(fuzz_memory *memory, pktrt_isa isa, bool parallel) {
  pktrt_scene_desc d;
  memset(&d, 0, sizeof d);
  memset(memory, 0, sizeof *memory);
  d.allocate = fuzz_allocate, d.release = fuzz_release, d.user = memory, d.isa = isa;
  if (parallel) d.parallel_for = fuzz_backwards;
  return d;
}

void *fuzz_block(size_t size) {
  void *p = malloc(size ? size : 1);
  if (!p) abort();
  return p;
}

/* --- what every target looks at --- */

const char *fuzz_no_sentence(const pktrt_scene *s) {
  const char *text = pktrt_last_error(s);
  if (!text || strlen(text) < 10) return "A call is refused without a sentence.";
  return strchr(text, '\n') ? "The sentence of a refusal has several lines." : NULL;
}

bool fuzz_all_finite(const float *x, size_t n) {
  for (size_t i = 0; i < n; i++)
    if (!isfinite(x[i])) return false;
  return true;
}

const char *fuzz_bad_hit(const pktrt_ray *r, const pktrt_hit *h, bool hit) {
  if (!hit) {
    const pktrt_hit zero = {r->tmax, 0, 0, {0, 0, 0}, PKTRT_NONE, PKTRT_NONE};
    return same_bits(h, &zero, sizeof zero) ? NULL : "A miss says more than the tmax of its ray.";
  }
  double n2 = 0;
  for (int a = 0; a < 3; a++) n2 += (double)h->normal[a] * (double)h->normal[a];
  if (!ref_valid(r)) return "A ray that is not valid hits.";
  if (!(h->t > r->tmin && h->t < r->tmax)) return "A hit lies outside the interval.";
  if (h->mesh == PKTRT_NONE || h->triangle == PKTRT_NONE) return "A hit has no triangle.";
  if (!(h->u >= 0 && h->v >= 0 && (1 - h->u) - h->v >= 0)) return "Barycentrics lie outside the triangle.";
  return fabs(sqrt(n2) - 1) < 0x1p-22 ? NULL : "A normal is not of unit length.";
}

static bool within(const float *x, int n, float lo, float hi) { /* false for NaN */
  for (int i = 0; i < n; i++)
    if (!(x[i] >= lo && x[i] <= hi)) return false;
  return true;
}

/* What the comments of pktrt_material ask for, and the limits of what can be computed. */
pktrt_material fuzz_material(feed *b, bool *good) {
  pktrt_material m;
  memset(&m, 0, sizeof m);
  const uint32_t kind = take_u8(b), odd = take_u8(b);
  m.specular = (pktrt_specular)((int)(kind % 8) - (kind % 8 == 7 ? 8 : 0)); /* 6 and -1 are none */
  m.lobe = (pktrt_lobe)(kind / 8 % 4 == 3 ? -1 : (int)(kind / 8 % 4));
  for (int a = 0; a < 3; a++) {
    m.albedo[a] = (float)take_below(b, 9) / 16, m.reflectance[a] = (float)take_below(b, 9) / 16;
    m.ior[a] = (float)take_u8(b) / 64, m.extinction[a] = (float)take_below(b, 64) / 8;
    m.absorption[a] = (float)take_u8(b) / 32, m.emission[a] = (float)take_u8(b) / 16;
  }
  m.exponent = (float)(take_u8(b) * take_u8(b));
  m.transmission = (float)(kind / 32) / 7, m.transparency = (float)(kind / 32) / 8, m.blend = kind >= 128;
  float *const fields[] = {m.albedo, m.reflectance, m.ior, m.extinction, m.absorption, m.emission, &m.exponent,
      &m.transmission, &m.transparency};
  if (odd) fields[odd % 9][odd % 9 < 6 ? odd / 9 % 3 : 0] = take_float(b);
  *good = (int)m.specular >= 0 && m.specular < PKTRT_SPECULAR_COUNT && (int)m.lobe >= 0 && m.lobe <= PKTRT_LOBE_PHONG &&
          !(m.blend && m.specular == PKTRT_SPECULAR_DIELECTRIC) && within(m.albedo, 3, 0, 1) &&
          within(m.reflectance, 3, 0, 1) && within(m.ior, 3, 0, 1e6f) && within(m.extinction, 3, 0, 1e6f) &&
          within(m.absorption, 3, 0, FLT_MAX) && within(m.emission, 3, 0, FLT_MAX) && within(&m.exponent, 1, 0, 1e9f) &&
          within(&m.transmission, 1, 0, 1) && within(&m.transparency, 1, 0, 1);
  for (int a = 0; a < 3 && m.specular == PKTRT_SPECULAR_MIRROR; a++)
    *good &= m.albedo[a] + m.reflectance[a] <= 1.00001f;
  return m;
}

pktrt_light fuzz_light(feed *b, bool *good) {
  pktrt_light l;
  memset(&l, 0, sizeof l);
  const uint32_t kind = take_u8(b), odd = take_u8(b);
  l.kind = (pktrt_light_kind)(kind % 16 == 15 ? -1 : kind % 16 == 14 ? 6 : (int)(kind % 6));
  take_tames(b, l.position, 3), take_tames(b, l.direction, 3), take_tames(b, l.edge[0], 6);
  for (int a = 0; a < 3; a++) l.intensity[a] = (float)take_u8(b) / 8;
  l.radius = (float)take_u8(b) / 64;
  l.mesh = take_below(b, 5);
  float *const fields[] = {l.position, l.direction, l.intensity, l.edge[0], l.edge[1], &l.radius};
  if (odd) fields[odd % 6][odd % 6 < 5 ? odd / 6 % 3 : 0] = take_float(b);
  const float far = PKTRT_MAX_COORD;
  *good = (int)l.kind >= 0 && l.kind < PKTRT_LIGHT_KIND_COUNT && within(l.intensity, 3, 0, FLT_MAX);
  if (l.kind == PKTRT_LIGHT_POINT || l.kind == PKTRT_LIGHT_QUAD || l.kind == PKTRT_LIGHT_SPHERE)
    *good &= within(l.position, 3, -far, far);
  if (l.kind == PKTRT_LIGHT_QUAD) *good &= within(l.edge[0], 3, -far, far) && within(l.edge[1], 3, -far, far);
  if (l.kind == PKTRT_LIGHT_SPHERE) *good &= within(&l.radius, 1, 0, far);
  if (l.kind == PKTRT_LIGHT_DIRECTIONAL)
    *good &= within(l.direction, 3, -far, far) && (l.direction[0] != 0 || l.direction[1] != 0 || l.direction[2] != 0);
  return l;
}
