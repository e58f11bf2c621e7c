/* Mesh files that assimp reads, by the reader of the examples: normals that files lack are smooth, but not across
   edges; materials, textures, cameras and lights are what the files say; a file that wants more memory than there
   is ends in one line. Built without a sanitizer and with AddressSanitizer. usage: mesh_file, in a folder that it
   may write to */
#define _GNU_SOURCE
#include "../examples/common.h"

#include "../pktrt.h"

#include "../examples/mesh_view.h"

#include <sys/resource.h>
#include <sys/wait.h>

static int checks, failures;

static void check(bool good, const char *sentence, const char *figures) {
  checks++;
  failures += !good;
  printf("  %s %s", good ? "ok     " : "FAILED ", sentence);
  if (figures[0]) printf(" (%s)", figures);
  printf("\n");
}

#ifdef MESH_FILE_ASAN
const char *__asan_default_options(void);
const char *__asan_default_options(void) { return "max_allocation_size_mb=1000"; }
#endif

/* >>files ---------------------------------------------------------------------------------------------------------- */

static FILE *ply_begin(const char *path, unsigned long vertices, unsigned long triangles) {
  FILE *file = fopen(path, "w");
  if (!file) exit(2);
  fprintf(file, "ply\nformat ascii 1.0\nelement vertex %lu\nproperty float x\nproperty float y\nproperty float z\n",
      vertices);
  fprintf(file, "element face %lu\nproperty list uchar int vertex_indices\nend_header\n", triangles);
  return file;
}

static void write_cube(const char *path) {
  static const int face[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  FILE *file = ply_begin(path, 8, 12);
  for (int i = 0; i < 8; i++) fprintf(file, "%d %d %d\n", i % 2 * 2 - 1, i / 2 % 2 * 2 - 1, i / 4 * 2 - 1);
  for (int i = 0; i < 6; i++) {
    fprintf(file, "3 %d %d %d\n", face[i][0], face[i][1], face[i][2]);
    fprintf(file, "3 %d %d %d\n", face[i][0], face[i][2], face[i][3]);
  }
  fclose(file);
}

enum { ACROSS = 24, ALONG = 12 };

/* A ball of ALONG x ACROSS quads; flat: a triangle without area is among its triangles. */
static void write_ball(const char *path, bool flat) {
  FILE *file = ply_begin(path, (ALONG + 1) * ACROSS, ALONG * ACROSS * 2 + flat);
  for (int i = 0; i <= ALONG; i++)
    for (int k = 0; k < ACROSS; k++) {
      const double a = 3.14159265358979 * i / ALONG;
      const double b = 2 * 3.14159265358979 * k / ACROSS;
      fprintf(file, "%.7f %.7f %.7f\n", sin(a) * cos(b), cos(a), sin(a) * sin(b));
    }
  for (int i = 0; i < ALONG; i++)
    for (int k = 0; k < ACROSS; k++) {
      const int at = i * ACROSS + k;
      const int next = i * ACROSS + (k + 1) % ACROSS;
      fprintf(file, "3 %d %d %d\n", at, next + ACROSS, next);
      fprintf(file, "3 %d %d %d\n", at, at + ACROSS, next + ACROSS);
    }
  if (flat) fprintf(file, "3 %d %d %d\n", 3 * ACROSS, 3 * ACROSS, 4 * ACROSS);
  fclose(file);
}

/* Two squares that meet at z = 0, the second turned against the first by so many degrees. */
static void write_fold(const char *path, double degrees) {
  const double angle = degrees * 3.14159265358979 / 180;
  FILE *file = ply_begin(path, 6, 4);
  fprintf(file, "-1 0 1\n1 0 1\n-1 0 0\n1 0 0\n");
  for (int side = -1; side <= 1; side += 2) fprintf(file, "%d %.9g %.9g\n", side, -sin(angle), -cos(angle));
  fprintf(file, "3 0 1 3\n3 0 3 2\n3 2 3 5\n3 2 5 4\n");
  fclose(file);
}

/* A triangle in the plane z = 0 with normals of its own, which lean towards x. */
static void write_leaning(const char *path) {
  FILE *file = fopen(path, "w");
  if (!file) exit(2);
  fprintf(file, "v -1 -1 0\nv 1 -1 0\nv 0 1 0\nvn 0.6 0 0.8\nf 1//1 2//1 3//1\n");
  fclose(file);
}

/* >>normals -------------------------------------------------------------------------------------------------------- */

/* Angles in degrees between shading normals and others: the geometric ones, and directions from the origin. */
typedef struct angles {
  unsigned seen;
  double from_faces, faces_from_ball, from_ball;
} angles;

/* Returns the angle between two lines, in degrees. */
static double angle_between(const float a[3], const float b[3]) {
  double cosine = 0, p = 0, q = 0;
  for (int i = 0; i < 3; i++) {
    cosine += (double)a[i] * (double)b[i];
    p += (double)a[i] * (double)a[i];
    q += (double)b[i] * (double)b[i];
  }
  cosine = fabs(cosine) / sqrt(p * q);
  return acos(cosine > 1 ? 1 : cosine) * 180 / 3.14159265358979;
}

static double larger(double a, double b) { return a > b ? a : b; }

/* Looks at a file's mesh from many sides, and from inside. */
static angles look_at(const char *path) {
  angles found = {0, 0, 0, 0};
  uint32_t random = 1;
  pktrt_scene *world = pktrt_scene_create(NULL);
  if (!world || !mesh_file_load(world, path) || pktrt_commit(world) != PKTRT_OK) exit(2);
  for (int i = 0; i < 4000; i++) {
    float from[3], to[3];
    for (int a = 0; a < 6; a++) {
      random = random * 1664525u + 1013904223u;
      const float x = (float)(random >> 8) / 8388608 - 1;
      if (a < 3) from[a] = 4 * x;
      else to[a - 3] = 0.9f * x - from[a - 3];
    }
    const pktrt_ray ray = pktrt_make_ray(from, to);
    pktrt_hit hit;
    pktrt_surface_info surface;
    if (!pktrt_intersect(world, &ray, &hit)) continue;
    pktrt_surface(world, &ray, &hit, &surface);
    found.seen++;
    found.from_faces = larger(found.from_faces, angle_between(surface.normal, surface.shading_normal));
    found.from_ball = larger(found.from_ball, angle_between(surface.position, surface.shading_normal));
    found.faces_from_ball = larger(found.faces_from_ball, angle_between(surface.position, surface.normal));
  }
  pktrt_scene_destroy(world);
  return found;
}

static void normals(void) {
  char text[200];
  write_cube("cube.ply");
  write_ball("ball.ply", false);
  write_ball("flat.ply", true);
  write_fold("fold50.ply", 50);
  write_fold("fold70.ply", 70);
  write_leaning("leaning.obj");

  angles a = look_at("cube.ply");
  snprintf(text, sizeof text, "%u points, shaded %.3g degrees off their faces", a.seen, a.from_faces);
  check(a.seen > 500 && a.from_faces < 0.1, "a cube without normals is shaded as a cube", text);

  a = look_at("ball.ply");
  snprintf(text, sizeof text, "%u points, shaded %.3g degrees off a ball, faces are %.3g", a.seen, a.from_ball,
      a.faces_from_ball);
  check(a.seen > 500 && a.from_ball < 3 && a.faces_from_ball > 6, "control: a ball without normals is smooth", text);

  a = look_at("flat.ply");
  snprintf(text, sizeof text, "%u points, shaded %.3g degrees off a ball", a.seen, a.from_ball);
  check(a.seen > 500 && a.from_ball < 3, "so it is with a triangle that has no area", text);

  a = look_at("fold70.ply");
  snprintf(text, sizeof text, "%u points, %.3g degrees", a.seen, a.from_faces);
  check(a.seen > 500 && a.from_faces < 0.1, "a fold of 70 degrees is an edge", text);

  a = look_at("fold50.ply");
  snprintf(text, sizeof text, "%u points, %.3g degrees", a.seen, a.from_faces);
  check(a.seen > 500 && a.from_faces > 20, "control: one of 50 degrees is none", text);

  a = look_at("leaning.obj");
  snprintf(text, sizeof text, "%u points, %.3g degrees", a.seen, a.from_faces);
  check(a.seen > 100 && fabs(a.from_faces - 36.87) < 0.1, "normals that a file has are kept", text);
}

/* >>materials ------------------------------------------------------------------------------------------------------ */

static void write_text(const char *path, const char *text) {
  FILE *file = fopen(path, "w");
  if (!file) exit(2);
  fputs(text, file);
  fclose(file);
}

/* An .obj with one square for each material m0, m1 ... of its .mtl, in the plane z = 0, square i from x = 2 i to 2
   i + 1. Texture coordinates are those of the square, or `vt`, four lines. */
static void write_squares(const char *name, unsigned count, const char *mtl, const char *vt) {
  char path[64];
  snprintf(path, sizeof path, "%s.mtl", name);
  write_text(path, mtl);
  snprintf(path, sizeof path, "%s.obj", name);
  FILE *file = fopen(path, "w");
  if (!file) exit(2);
  fprintf(file, "mtllib %s.mtl\n%s", name, vt ? vt : "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n");
  for (unsigned i = 0; i < count; i++) {
    const unsigned x = 2 * i, v = 4 * i;
    fprintf(file, "v %u 0 0\nv %u 0 0\nv %u 1 0\nv %u 1 0\nusemtl m%u\n", x, x + 1, x + 1, x, i);
    fprintf(file, "f %u/1 %u/2 %u/3 %u/4\n", v + 1, v + 2, v + 3, v + 4);
  }
  fclose(file);
}

/* A scene with a file in it. */
typedef struct opened {
  pktrt_scene *world;
  mesh_file file;
  bool ok;
} opened;

static opened open_file(const char *path) {
  opened o;
  o.world = pktrt_scene_create(NULL);
  if (!o.world) exit(2);
  o.ok = mesh_file_open(&o.file, o.world, path, false) && pktrt_commit(o.world) == PKTRT_OK;
  return o;
}

static void close_file(opened *o) {
  pktrt_scene_destroy(o->world);
  mesh_file_close(&o->file);
}

/* What a ray meets, after the hook. */
typedef struct met {
  bool some;
  uint32_t mesh, instance, material;
  float albedo[3], reflectance[3], emission[3], normal[3], opacity, exponent;
  pktrt_surface_info surface;
} met;

/* Returns the material of an index in the scene; NULL: none of the file. */
static const material_file *made_of(const opened *o, uint32_t index) {
  for (uint32_t i = 0; i < o->file.materials.count; i++)
    if (o->file.materials.material[i].index == index) return &o->file.materials.material[i];
  return NULL;
}

/* Looks from a point in a direction. */
static met look(const opened *o, const float from[3], const float to[3]) {
  met m;
  pktrt_hit hit;
  pktrt_points p;
  const pktrt_ray ray = pktrt_make_ray(from, to);
  memset(&m, 0, sizeof m);
  memset(&p, 0, sizeof p);
  m.some = pktrt_intersect(o->world, &ray, &hit);
  if (!m.some) return m;
  pktrt_surface(o->world, &ray, &hit, &m.surface);
  m.mesh = hit.mesh;
  m.instance = m.surface.instance;
  m.material = m.surface.material;
  const material_file *f = made_of(o, m.material);
  if (!f) return m;
  p.n = 1, p.mesh = &hit.mesh, p.triangle = &hit.triangle, p.time = &ray.time;
  p.barycentric[0] = &hit.u, p.barycentric[1] = &hit.v, p.opacity = &m.opacity, p.exponent = &m.exponent;
  for (int a = 0; a < 3; a++) {
    p.position[a] = &m.surface.position[a], p.direction[a] = &to[a], p.normal[a] = &m.surface.shading_normal[a];
    p.albedo[a] = &m.albedo[a], p.reflectance[a] = &m.reflectance[a], p.emission[a] = &m.emission[a];
    p.normal_out[a] = &m.normal[a];
    m.albedo[a] = f->made.albedo[a], m.reflectance[a] = f->made.reflectance[a], m.emission[a] = f->made.emission[a];
    m.normal[a] = m.surface.shading_normal[a];
  }
  p.texcoord[0] = &m.surface.texcoord[0], p.texcoord[1] = &m.surface.texcoord[1];
  m.opacity = 1 - f->made.transparency, m.exponent = f->made.exponent;
  if (f->made.texture) f->made.texture(f->made.user, &p);
  return m;
}

/* Looks straight at (x, y) in the plane z = 0. */
static met look_at_place(const opened *o, float x, float y) {
  const float from[3] = {x, y, 1}, to[3] = {0, 0, -1};
  return look(o, from, to);
}

static bool is_near(const float *a, double x, double y, double z) {
  return fabs((double)a[0] - x) < 2e-3 && fabs((double)a[1] - y) < 2e-3 && fabs((double)a[2] - z) < 2e-3;
}

/* Checks three numbers. */
static void expect(const float *a, double x, double y, double z, const char *sentence) {
  char text[200];
  snprintf(text, sizeof text, "%g %g %g, not %g %g %g", (double)a[0], (double)a[1], (double)a[2], x, y, z);
  check(is_near(a, x, y, z), sentence, is_near(a, x, y, z) ? "" : text);
}

static const pktrt_material *made(const opened *o, unsigned square) {
  const met m = look_at_place(o, 2 * (float)square + 0.3f, 0.4f);
  const material_file *f = m.some ? made_of(o, m.material) : NULL;
  static const pktrt_material none;
  return f ? &f->made : &none;
}

static void mtl_is_mapped(void) {
  write_squares("mtl", 9,
      "newmtl m0\nKd 0.2 0.4 0.6\nillum 1\nKs 1 1 1\nNs 30\n"
      "newmtl m1\nKd 0 0 0\nKe 3 2 1\nillum 1\n"
      "newmtl m2\nKd 1 1 1\nKs 1 1 1\nNi 1.33\nd 0.1\nillum 7\n"
      "newmtl m3\nKd 0.5 0.5 0.5\nKs 0.9 0.6 0.2\nNs 40\nillum 2\n"
      "newmtl m4\nKd 0.1 0.2 0.3\nKs 0.2 0.2 0.2\nNs 90\nNi 1.6\nillum 2\n"
      "newmtl m5\nKd 0.3 0.3 0.3\nd 0.25\nillum 1\n"
      "newmtl m6\nKd 5 -1 nan\nNi -3\nKs 1e30 nan 1e30\nNs nan\nillum 3\nd 7\n"
      "newmtl m7\nKd 0 0 0\nKs 1 1 1\nNs 1000\nillum 3\n"
      "newmtl m8\nKd 0.5 0.5 0.5\nKs 0.5 0.5 0.5\nNs 60\nillum 5\n",
      NULL);
  opened o = open_file("mtl.obj");
  char text[200];
  check(o.ok, "an .obj with nine materials is read", "");
  const pktrt_material *m = made(&o, 0);
  expect(m->albedo, 0.2, 0.4, 0.6, "Kd is the albedo");
  check(m->specular == PKTRT_SPECULAR_NONE, "with illum 1 it reflects nothing", "");
  expect(made(&o, 1)->emission, 3, 2, 1, "Ke is what it emits");
  snprintf(text, sizeof text, "%u lights", (unsigned)o.file.lights);
  check(o.file.lights == 1 && o.file.own_lights == 0 && o.file.glow > 0, "a square that emits is a light", text);
  m = made(&o, 2);
  check(m->specular == PKTRT_SPECULAR_DIELECTRIC && fabsf(m->ior[0] - 1.33f) < 1e-4f, "illum 7 is glass of Ni", "");
  m = made(&o, 3);
  check(m->specular == PKTRT_SPECULAR_MIRROR && m->lobe == PKTRT_LOBE_PHONG && m->exponent == 40,
      "coloured Ks is a mirror with the exponent Ns", "");
  expect(m->reflectance, 0.9, 0.6, 0.2, "which reflects Ks");
  expect(m->albedo, 0.1, 0.4, 0.5, "and leaves the rest to Kd");
  m = made(&o, 4);
  check(m->specular == PKTRT_SPECULAR_COAT && fabsf(m->ior[0] - 1.6f) < 1e-4f && m->exponent == 90,
      "grey Ks is a coat of Ni", "");
  expect(m->reflectance, 0.4, 0.4, 0.4, "of 2 Ks times Fresnel");
  m = made(&o, 5);
  check(
      m->blend && fabsf(m->transparency - 0.75f) < 1e-4f && m->specular == PKTRT_SPECULAR_NONE, "d below 1 blends", "");
  m = made(&o, 6);
  expect(m->albedo, 0, 0, 0, "colours are clamped, and NaN is 0: of albedo, beside a mirror that takes all");
  expect(m->reflectance, 1, 0, 1, "and of reflectance");
  m = made(&o, 7);
  check(m->specular == PKTRT_SPECULAR_MIRROR && m->lobe == PKTRT_LOBE_IDEAL, "Ns 1000 is an ideal mirror", "");
  check(made(&o, 8)->specular == PKTRT_SPECULAR_MIRROR, "with illum 5 grey Ks is a mirror, too", "");
  check(o.file.scatters, "the file is one for distribution ray tracing", "");
  close_file(&o);

  write_text("none.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  o = open_file("none.obj");
  check(o.ok && !o.file.scatters && o.file.lights == 0, "a file without materials is read", "");
  expect(made(&o, 0)->albedo, 0.6, 0.6, 0.6, "and has assimp's grey");
  close_file(&o);
}

/* >>textures ------------------------------------------------------------------------------------------------------- */

/* Four texels, upper row first: 255 0 0, 0 255 0, 0 0 255, 188 188 188, or any one. */
static void write_picture(const char *path, int width, int height, const unsigned char *rgba) {
  if (!stbi_write_png(path, width, height, 4, rgba, 4 * width)) exit(2);
}

static const unsigned char four[16] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 188, 188, 188, 0};

/* Runs something with standard error in a file; what was said is read into `said`. */
static opened open_quietly(const char *path, char *said, size_t room) {
  fflush(stderr);
  const int before = dup(STDERR_FILENO), to = open("said.txt", O_RDWR | O_CREAT | O_TRUNC, 0666);
  if (before < 0 || to < 0) exit(2);
  dup2(to, STDERR_FILENO);
  const opened o = open_file(path);
  fflush(stderr);
  dup2(before, STDERR_FILENO);
  close(before);
  lseek(to, 0, SEEK_SET);
  const ssize_t n = read(to, said, room - 1);
  said[n > 0 ? n : 0] = 0;
  close(to);
  return o;
}

/* A PNG that announces a huge size, with a right checksum. */
static void write_huge(const char *path) {
  static const unsigned char start[] = {0x89, 'P', 'N', 'G', 13, 10, 26, 10, 0, 0, 0, 13};
  unsigned char head[17] = {'I', 'H', 'D', 'R', 0x7f, 0xff, 0xff, 0xff, 0x7f, 0xff, 0xff, 0xff, 8, 6, 0, 0, 0};
  uint32_t crc = 0xffffffffu;
  for (int i = 0; i < 17; i++) {
    crc ^= head[i];
    for (int b = 0; b < 8; b++) crc = crc & 1 ? crc >> 1 ^ 0xedb88320u : crc >> 1;
  }
  crc = ~crc;
  const unsigned char sum[4] = {
      (unsigned char)(crc >> 24), (unsigned char)(crc >> 16), (unsigned char)(crc >> 8), (unsigned char)crc};
  FILE *file = fopen(path, "wb");
  if (!file) exit(2);
  fwrite(start, 1, sizeof start, file);
  fwrite(head, 1, sizeof head, file);
  fwrite(sum, 1, sizeof sum, file);
  fclose(file);
}

static void obj_textures(void) {
  char said[2000];
  static const unsigned char one[4] = {128, 255, 0, 255};
  mkdir("folder", 0777);
  write_picture("folder/four.png", 2, 2, four);
  write_picture("one.png", 1, 1, one);
  write_text("corrupt.png", "\x89PNG but not really");
  write_huge("huge.png");
  write_text("strange.dds", "DDS ");
  write_squares("textures", 9,
      "newmtl m0\nKd 1 1 1\nmap_Kd folder\\four.png\nillum 1\n"
      "newmtl m1\nKd 0.5 1 1\nmap_Kd one.png\nillum 1\n"
      "newmtl m2\nKd 0.3 0.3 0.3\nmap_Kd absent.png\nillum 1\n"
      "newmtl m3\nKd 0.4 0.4 0.4\nmap_Kd corrupt.png\nillum 1\n"
      "newmtl m4\nKd 0.5 0.5 0.5\nmap_Kd huge.png\nillum 1\n"
      "newmtl m5\nKd 0.6 0.6 0.6\nmap_Kd strange.dds\nillum 1\n"
      "newmtl m6\nKd 0.7 0.7 0.7\nmap_Kd *7\nillum 1\n"
      "newmtl m7\nKd 1 1 1\nmap_Kd folder/four.png\nmap_d folder/four.png\nillum 1\n"
      "newmtl m8\nKd 0.7 0.7 0.7\nmap_Kd folder\nmap_Ke one.png\nKe 1 1 1\nillum 1\n",
      NULL);
  opened o = open_quietly("textures.obj", said, sizeof said);
  check(o.ok, "textures that cannot be read do not keep a file from being read", "");
  met m = look_at_place(&o, 0.25f, 0.75f);
  expect(m.albedo, 1, 0, 0, "a texture's upper left is where u is small and v large, and a backslash parts folders");
  m = look_at_place(&o, 0.25f, 0.25f);
  expect(m.albedo, 0, 0, 1, "its lower left is where both are small");
  m = look_at_place(&o, 0.75f, 0.25f);
  expect(m.albedo, 0.503, 0.503, 0.503, "codes are sRGB");
  m = look_at_place(&o, 0.5f, 0.75f);
  expect(m.albedo, 0.5, 0.5, 0, "between texels it is a mean of linear light");
  m = look_at_place(&o, 2.9f, 0.1f);
  expect(m.albedo, 0.5 * 0.2159, 1, 0, "a picture of one texel is that, times Kd");
  m = look_at_place(&o, 4.5f, 0.5f);
  expect(m.albedo, 0.3, 0.3, 0.3, "without its picture a surface has Kd");
  expect(look_at_place(&o, 6.5f, 0.5f).albedo, 0.4, 0.4, 0.4, "so it has with a corrupt one");
  expect(look_at_place(&o, 8.5f, 0.5f).albedo, 0.5, 0.5, 0.5, "with one that announces a huge size");
  expect(look_at_place(&o, 10.5f, 0.5f).albedo, 0.6, 0.6, 0.6, "with one of an unknown kind");
  expect(look_at_place(&o, 12.5f, 0.5f).albedo, 0.7, 0.7, 0.7, "with one that should be within the file, but is not");
  check(strstr(said, "not used: ") &&
            strstr(said,
                "2 textures of an unknown kind, 2 textures that cannot be read, 2 textures that are not there, 1 glow"),
      "what is not used is said in one line", strstr(said, "note:") ? "" : said);
  m = look_at_place(&o, 14.75f, 0.25f);
  check(m.opacity == 0 && look_at_place(&o, 14.25f, 0.25f).opacity == 1 && made(&o, 7)->blend, "map_d blends by alpha",
      "");
  expect(look_at_place(&o, 16.5f, 0.5f).emission, 0.2159, 1, 0, "map_Ke is of what it emits");
  check(o.file.lights == 0, "which makes it no light", "");
  close_file(&o);
}

static void far_coordinates(void) {
  char said[2000];
  write_squares("places", 1, "newmtl m0\nKd 1 1 1\nmap_Kd folder/four.png\nillum 1\n",
      "vt nan nan\nvt inf 0\nvt 1e30 -1e30\nvt 0 -inf\n");
  opened o = open_quietly("places.obj", said, sizeof said);
  const met m = look_at_place(&o, 0.5f, 0.4f);
  check(o.ok && m.some && m.albedo[0] >= 0 && m.albedo[0] <= 1 && m.albedo[1] >= 0 && m.albedo[2] <= 1,
      "texture coordinates that are huge, infinite or NaN show some texel", said);
  close_file(&o);
  write_squares(
      "repeat", 1, "newmtl m0\nKd 1 1 1\nmap_Kd folder/four.png\nillum 1\n", "vt 3 -2\nvt 4 -2\nvt 4 -1\nvt 3 -1\n");
  o = open_file("repeat.obj");
  expect(look_at_place(&o, 0.25f, 0.75f).albedo, 1, 0, 0, "beyond its edges a picture is repeated");
  close_file(&o);
}

/* What files of other programs do. */
static void habits(void) {
  static const unsigned char one[4] = {128, 255, 0, 255};
  char said[2000];
  write_picture("letters.png", 1, 1, one);
  write_squares("habits", 4,
      "newmtl m0\nKd 0.2 0.4 0.6\nTr 1\nillum 2\n"
      "newmtl m1\nKd 1 1 1\nmap_Kd LETTERS.Png\nillum 1\n"
      "newmtl m2\nKd 0.5 0.5 0.5\nKe 0.5 0.25 0.125\nillum 1\n"
      "newmtl m3\nKd 0.2 0.4 0.6\nTr 0.25\nillum 1\n",
      NULL);
  opened o = open_quietly("habits.obj", said, sizeof said);
  const pktrt_material *m = made(&o, 0);
  check(o.ok && !m->blend && m->transparency <= 0, "what would be invisible as a whole is opaque", said);
  m = made(&o, 3);
  check(m->blend && fabsf(m->transparency - 0.25f) < 1e-4f, "control: what is so in part blends", "");
  expect(look_at_place(&o, 2.5f, 0.5f).albedo, 0.2159, 1, 0, "a picture is found whatever the case of its name");
  expect(made(&o, 2)->emission, 0.5, 0.25, 0.125, "a faint glow is seen");
  check(o.file.lights == 0 && strstr(said, "1 glow as a light"), "but is no light, which is said", said);
  close_file(&o);
}

/* >>gltf ----------------------------------------------------------------------------------------------------------- */

/* Appends bytes as base64. */
static void print_base64(FILE *file, const unsigned char *bytes, size_t n) {
  static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  for (size_t i = 0; i < n; i += 3) {
    const uint32_t b =
        (uint32_t)bytes[i] << 16 | (i + 1 < n ? (uint32_t)bytes[i + 1] << 8 : 0) | (i + 2 < n ? bytes[i + 2] : 0);
    const char text[4] = {
        digits[b >> 18], digits[b >> 12 & 63], i + 1 < n ? digits[b >> 6 & 63] : '=', i + 2 < n ? digits[b & 63] : '='};
    fwrite(text, 1, 4, file);
  }
}

/* Writes JSON, whose quotes are single ones here. */
static void print_json(FILE *file, const char *text) {
  for (; *text; text++) fputc(*text == '\'' ? '"' : *text, file);
}

/* A .gltf whose mesh i is a square with material i; textures 0 to 2 are pictures within the file: those of `four`,
   of metal and roughness (0.5 and 1, then 0.25 and 0), and of a normal that leans towards u by (0.6, 0, 0.8). */
static void write_gltf(const char *path, const char *materials, unsigned count, const char *nodes, const char *rest) {
  static const float vertices[20] = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 1, 1, 1, 1, 0, 0, 0}; /* v is downwards */
  static const unsigned char corners[6] = {0, 1, 2, 0, 2, 3};
  static const unsigned char metal[8] = {0, 128, 255, 255, 0, 64, 0, 255};
  static const unsigned char leaning[4] = {204, 128, 230, 255};
  static const char *const pictures[3] = {"four.png", "metal.png", "leaning.png"};
  unsigned char data[88];
  FILE *file = fopen(path, "w");
  if (!file) exit(2);
  memcpy(data, vertices, 80);
  memcpy(data + 80, corners, 6);
  write_picture("four.png", 2, 2, four);
  write_picture("metal.png", 2, 1, metal);
  write_picture("leaning.png", 1, 1, leaning);
  print_json(file,
      "{'asset':{'version':'2.0'},'extensionsUsed':['KHR_materials_transmission','KHR_materials_volume',"
      "'KHR_materials_ior','KHR_texture_transform','KHR_lights_punctual','KHR_materials_emissive_strength',"
      "'KHR_materials_unlit'],'scene':0,");
  print_json(file, rest);
  print_json(file, ",'nodes':[");
  print_json(file, nodes);
  print_json(file, "],'materials':[");
  print_json(file, materials);
  print_json(file, "],'meshes':[");
  for (unsigned i = 0; i < count; i++) {
    print_json(file, i ? ",{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':1},'indices':2,'material':"
                       : "{'primitives':[{'attributes':{'POSITION':0,'TEXCOORD_0':1},'indices':2,'material':");
    fprintf(file, "%u}]}", i);
  }
  print_json(file, "],'textures':[{'source':0,'sampler':0},{'source':1},{'source':2},{'source':0,'sampler':1}],"
                   "'samplers':[{},{'wrapS':33071,'wrapT':33648}],'images':[");
  for (int i = 0; i < 3; i++) {
    unsigned char bytes[1000];
    FILE *picture = fopen(pictures[i], "rb");
    const size_t n = picture ? fread(bytes, 1, sizeof bytes, picture) : 0;
    if (picture) fclose(picture);
    if (i) fputc(',', file);
    print_json(file, "{'mimeType':'image/png','uri':'data:image/png;base64,");
    print_base64(file, bytes, n);
    print_json(file, "'}");
  }
  print_json(file, "],'accessors':[{'bufferView':0,'componentType':5126,'count':4,'type':'VEC3','min':[0,0,0],"
                   "'max':[1,1,0]},{'bufferView':1,'componentType':5126,'count':4,'type':'VEC2'},"
                   "{'bufferView':2,'componentType':5121,'count':6,'type':'SCALAR'}],'bufferViews':["
                   "{'buffer':0,'byteOffset':0,'byteLength':48},{'buffer':0,'byteOffset':48,'byteLength':32},"
                   "{'buffer':0,'byteOffset':80,'byteLength':6}],'buffers':[{'byteLength':88,'uri':"
                   "'data:application/octet-stream;base64,");
  memset(data + 86, 0, 2);
  print_base64(file, data, 88);
  print_json(file, "'}]}");
  fclose(file);
}

/* The reflectance of what reflects f0 straight, of no roughness, at a cosine. */
static double schlick(double f0, double cosine) { return f0 + (1 - f0) * pow(1 - cosine, 5); }

/* Square i, from x = 2 i, has the i-th of thirteen materials. */
static void write_factors(void) {
  char nodes[1000] = "";
  for (int i = 0; i < 13; i++) {
    const size_t n = strlen(nodes);
    snprintf(nodes + n, sizeof nodes - n, "%s{'mesh':%d,'translation':[%d,0,0]}", i ? "," : "", i, 2 * i);
  }
  write_gltf("factors.gltf",
      "{'pbrMetallicRoughness':{'baseColorFactor':[0.9,0.6,0.3,1],'metallicFactor':1,"
      "'roughnessFactor':0.5}},"
      "{'pbrMetallicRoughness':{'baseColorFactor':[0.2,0.4,0.6,1],'metallicFactor':0,"
      "'roughnessFactor':0.5}},"
      "{'pbrMetallicRoughness':{'baseColorFactor':[0.2,0.4,0.6,1],'metallicFactor':1,"
      "'roughnessFactor':0.9}},"
      "{'pbrMetallicRoughness':{'baseColorFactor':[0.2,0.4,0.6,1],'metallicFactor':0.5,"
      "'roughnessFactor':0}},"
      "{'extensions':{'KHR_materials_transmission':{'transmissionFactor':1},"
      "'KHR_materials_ior':{'ior':1.4},"
      "'KHR_materials_volume':{'thicknessFactor':1,'attenuationColor':[0.5,1,0.25],"
      "'attenuationDistance':2}},"
      "'pbrMetallicRoughness':{'metallicFactor':0,'roughnessFactor':0}},"
      "{'extensions':{'KHR_materials_transmission':{'transmissionFactor':0.75}},"
      "'pbrMetallicRoughness':{'baseColorFactor':[0.5,0.6,0.7,1],'metallicFactor':0,"
      "'roughnessFactor':0}},"
      "{'alphaMode':'MASK','alphaCutoff':0.3,'pbrMetallicRoughness':{'baseColorTexture':{"
      "'index':0},'metallicFactor':0,'roughnessFactor':1}},"
      "{'alphaMode':'BLEND','pbrMetallicRoughness':{'baseColorFactor':[1,1,1,0.4],"
      "'metallicFactor':0,'roughnessFactor':1}},"
      "{'emissiveFactor':[1,0.5,0.25],'extensions':{'KHR_materials_emissive_strength':{"
      "'emissiveStrength':8}}},"
      "{'pbrMetallicRoughness':{'baseColorFactor':[0.9,0.6,0.3,1],'metallicRoughnessTexture':{"
      "'index':1}}},"
      "{'extensions':{'KHR_materials_unlit':{}},'pbrMetallicRoughness':{"
      "'baseColorFactor':[0.1,0.2,0.3,1]}},"
      "{'pbrMetallicRoughness':{'baseColorFactor':[7,-1,0.5,1],'metallicFactor':-3,"
      "'roughnessFactor':9}},"
      "{'alphaMode':'BLEND','pbrMetallicRoughness':{'metallicFactor':0,'roughnessFactor':1}}",
      13, nodes, "'scenes':[{'nodes':[0,1,2,3,4,5,6,7,8,9,10,11,12]}]");
}

static void metals(const opened *o) {
  const pktrt_material *m = made(o, 0);
  met p = look_at_place(o, 0.4f, 0.4f);
  check(m->specular == PKTRT_SPECULAR_MIRROR && fabsf(m->exponent - 7.5f) < 1e-3f && fabsf(p.exponent - 7.5f) < 1e-3f,
      "metal of roughness 0.5 is a mirror with exponent 7.5", "");
  expect(p.reflectance, 0.9, 0.6, 0.3, "which reflects its colour, straight");
  expect(p.albedo, 0, 0, 0, "and is not diffuse");
  m = made(o, 1);
  check(m->specular == PKTRT_SPECULAR_COAT && fabsf(m->exponent - 7.5f) < 1e-3f && !m->texture,
      "what is no metal has a coat", "");
  expect(m->albedo, 0.2, 0.4, 0.6, "over its colour");
  check(made(o, 2)->specular == PKTRT_SPECULAR_NONE, "of roughness 0.9 it is diffuse, metal or not", "");
  const float from[3] = {6.4f, 0.4f, 1}, aslant[3] = {0, 0.8f, -0.6f};
  p = look(o, from, aslant);
  check(made(o, 3)->lobe == PKTRT_LOBE_IDEAL, "without roughness it is ideal", "");
  check(!p.some, "control: this ray passes by", "");
  const float below[3] = {6.4f, -0.9f, 1};
  p = look(o, below, aslant);
  expect(p.reflectance, schlick(0.12, 0.6), schlick(0.22, 0.6), schlick(0.32, 0.6),
      "half a metal reflects half as it, by the angle");
  expect(p.albedo, 0.1 * (1 - schlick(0.12, 0.6)), 0.2 * (1 - schlick(0.22, 0.6)), 0.3 * (1 - schlick(0.32, 0.6)),
      "and is half diffuse");
}

static void transparent_and_textured(const opened *o) {
  met p;
  const pktrt_material *m = made(o, 4);
  check(m->specular == PKTRT_SPECULAR_DIELECTRIC && fabsf(m->ior[0] - 1.4f) < 1e-4f,
      "transmission with a thickness is glass", "");
  expect(m->absorption, 0.34657, 0, 0.69315, "which absorbs by attenuation colour and distance");
  m = made(o, 5);
  check(m->specular == PKTRT_SPECULAR_THIN && m->transmission == 0.75f, "without thickness it is a thin sheet", "");
  expect(m->albedo, 0.5, 0.6, 0.7, "tinted by its colour");
  m = made(o, 6);
  check(m->cutout && !m->blend && look_at_place(o, 12.75f, 0.25f).opacity == 0 &&
            look_at_place(o, 12.25f, 0.25f).opacity == 1,
      "a mask is a cutout by the texture's alpha", "");
  check(look_at_place(o, 12.55f, 0.25f).opacity == 1 && look_at_place(o, 12.65f, 0.25f).opacity == 0, "at its cutoff",
      "");
  m = made(o, 7);
  check(m->blend && fabsf(m->transparency - 0.6f) < 1e-4f, "blend lets rays through by alpha", "");
  check(!made(o, 12)->blend, "but not where alpha is 1", "");
  m = made(o, 8);
  expect(m->emission, 8, 4, 2, "emission is times its strength");
  check(o->file.lights == 1, "and makes a light", "");
  p = look_at_place(o, 18.25f, 0.5f);
  expect(p.reflectance, 0.9, 0.6, 0.3, "a texture says where it is metal");
  check(fabs((double)p.exponent - (0.5 / pow(128 / 255.0, 4) - 0.5)) < 0.01, "and how rough", "");
  p = look_at_place(o, 18.75f, 0.5f);
  expect(p.reflectance, 0.04, 0.04, 0.04, "and where it is not");
  m = made(o, 10);
  expect(m->emission, 0.1, 0.2, 0.3, "what is unlit emits its colour");
  expect(m->albedo, 0, 0, 0, "and reflects nothing");
  expect(made(o, 11)->albedo, 1, 0, 0.5, "factors are clamped");
}

static void gltf_factors(void) {
  write_factors();
  opened o = open_file("factors.gltf");
  check(o.ok, "a .gltf with thirteen materials and pictures within it is read", "");
  metals(&o);
  transparent_and_textured(&o);
  close_file(&o);
}

static void write_places(void) {
  write_gltf("places.gltf",
      "{'pbrMetallicRoughness':{'metallicFactor':0,'roughnessFactor':1},'normalTexture':{'index':2}},"
      "{'pbrMetallicRoughness':{'metallicFactor':0,'roughnessFactor':1,'baseColorTexture':{"
      "'index':0,'extensions':"
      "{'KHR_texture_transform':{'offset':[0.3,0.2],'rotation':0.5,'scale':[1.5,0.5]}}}}},"
      "{'pbrMetallicRoughness':{'metallicFactor':0,'roughnessFactor':1,'baseColorTexture':{"
      "'index':3,'extensions':"
      "{'KHR_texture_transform':{'offset':[-1,1]}}}}},"
      "{'emissiveFactor':[1,1,1]}",
      4,
      "{'mesh':0},{'mesh':0,'translation':[3,0,0],'rotation':[0,0,0.70710678,0.70710678]},"
      "{'mesh':1,'translation':[4,0,0]},{'mesh':2,'translation':[6,0,0]},{'mesh':3,"
      "'translation':[8,0,0]},"
      "{'mesh':3,'translation':[10,0,0],'scale':[-1,1,1]},"
      "{'camera':0,'translation':[1,2,3],'rotation':[0,0.70710678,0,0.70710678]},"
      "{'translation':[0,10,0],'children':[8]},{'translation':[0,0,5],'extensions':{"
      "'KHR_lights_punctual':{'light':0}}},"
      "{'rotation':[-0.70710678,0,0,0.70710678],'extensions':{'KHR_lights_punctual':{'light':1}}}",
      "'scenes':[{'nodes':[0,1,2,3,4,5,6,7,9]}],"
      "'cameras':[{'type':'perspective','perspective':{'yfov':0.7,'aspectRatio':2,'znear':0.1}}],"
      "'extensions':{'KHR_lights_punctual':{'lights':[{'type':'point','intensity':30,"
      "'color':[1,0.5,0]},"
      "{'type':'directional','intensity':2}]}}");
}

static void gltf_places(void) {
  char text[300];
  write_places();
  opened o = open_file("places.gltf");
  pktrt_scene_info info;
  pktrt_get_scene_info(o.world, &info);
  snprintf(text, sizeof text, "%u instances, %u triangles", (unsigned)info.instance_count, (unsigned)info.triangles);
  check(o.ok && info.instance_count == 2 && info.triangles == 10, "a mesh of two nodes is a model with two instances",
      text);
  met m = look_at_place(&o, 0.4f, 0.4f);
  expect(m.normal, 0.6, 0.0039, 0.8039, "a normal map bends normals towards u");
  m = look_at_place(&o, 2.6f, 0.4f);
  check(m.some && m.instance == 1, "control: this is the second instance", "");
  expect(m.normal, -0.0039, 0.6, 0.8039, "in an instance that is turned, u is turned, too");

  const double u = 0.3, w = 0.6; /* glTF's, w downwards; place (4 + u, 1 - w) */
  const double s = sin(0.5), c = cos(0.5);
  const double x = 0.3 + c * 1.5 * u + s * 0.5 * w, y = 0.2 - s * 1.5 * u + c * 0.5 * w;
  image four_again;
  float rgba[4];
  memset(&four_again, 0, sizeof four_again);
  if (!image_from_rgba8(&four_again, 2, 2, four, true)) exit(2);
  image_at(&four_again, (float)x, (float)(1 - y), IMAGE_REPEAT, IMAGE_REPEAT, rgba);
  m = look_at_place(&o, 4 + (float)u, 1 - (float)w);
  expect(m.albedo, (double)rgba[0], (double)rgba[1], (double)rgba[2],
      "a texture's transform moves, turns and scales as glTF says");
  image_free(&four_again);
  expect(look_at_place(&o, 6.9f, 0.9f).albedo, 0, 0, 1, "a texture is clamped across and mirrored up and down");

  m = look_at_place(&o, 9.6f, 0.5f);
  check(m.some && !m.surface.inside, "what is mirrored keeps its outside", "");
  snprintf(
      text, sizeof text, "%u lights, %u of them of their own", (unsigned)o.file.lights, (unsigned)o.file.own_lights);
  check(o.file.lights == 4 && o.file.own_lights == 2, "lights of nodes and what emits are lights", text);
  const float sum[3] = {
      (float)(o.file.light_place[0] / 30), (float)(o.file.light_place[1] / 30), (float)(o.file.light_place[2] / 30)};
  expect(sum, 0, 10, 5, "a point light is where its nodes put it");
  check(fabs(o.file.light_sum[0] - 2) < 1e-4 && fabs(o.file.light_sum[1] - 30) < 1e-3, "as bright as it says", "");
  check(o.file.has_camera && fabsf(o.file.camera.fov_y - 40.107f) < 0.01f, "the camera has the file's angle", "");
  expect(o.file.camera.eye, 1, 2, 3, "and place");
  expect(o.file.camera.target, -1, 0, 0, "and direction");
  close_file(&o);
}

/* A triangle whose corners are red, green and blue. */
static void vertex_colours(void) {
  write_text("colours.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "property uchar red\nproperty uchar green\nproperty uchar blue\nelement face 1\n"
      "property list uchar int vertex_indices\nend_header\n"
      "0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n");
  opened o = open_file("colours.ply");
  const met m = look_at_place(&o, 0.5f, 0.25f);
  const float *colour = made_of(&o, m.material) ? made_of(&o, m.material)->colour : m.albedo;
  check(o.ok && m.some && colour[0] > 0, "a file with colours of vertices is read", "");
  expect(m.albedo, 0.25 * (double)colour[0], 0.5 * (double)colour[1], 0.25 * (double)colour[2],
      "they are mixed between corners");
  close_file(&o);
}

/* A floor under a lamp that is all the light there is. */
static void lamps(void) {
  static float pixels[16 * 16 * 3];
  bool ok = true;
  pktrt_render_desc d;
  char text[100];
  write_text("lamp.mtl", "newmtl floor\nKd 0.5 0.5 0.5\nillum 1\nnewmtl lamp\nKd 0 0 0\nKe 10 5 0\nillum 1\n");
  write_text("lamp.obj",
      "mtllib lamp.mtl\nv -1 0 1\nv 1 0 1\nv 1 0 -1\nv -1 0 -1\nv -1 2 1\nv 1 2 1\nv 1 2 -1\nv -1 2 -1\n"
      "usemtl floor\nf 1 2 3 4\nusemtl lamp\nf 5 6 7 8\n");
  opened o = open_file("lamp.obj");
  memset(&d, 0, sizeof d);
  const mesh_view view = {"lamp.obj", 1, false, false, false};
  const bool own = mesh_view_light(&view, &o.file, o.world, &d, &ok);
  check(o.ok && ok && own && o.file.lights == 1, "a lamp is light enough", "");
  d.width = d.height = 16;
  d.pixels = pixels;
  d.mode = PKTRT_MODE_DRT;
  d.samples = 64;
  d.camera.eye[1] = 1;
  d.camera.fov_y = 2;
  memset(d.ambient, 0, sizeof d.ambient);
  if (pktrt_render(o.world, &d) != PKTRT_OK) exit(2);
  /* A square of side 2 at distance 2 from a point under its middle: view factor 0.2395. */
  const double red = (double)pixels[0], green = (double)pixels[1];
  snprintf(text, sizeof text, "%g %g %g", red, green, (double)pixels[2]);
  check(fabs(red - 5 * 0.2395) < 0.06 && fabs(green - 2.5 * 0.2395) < 0.03 && !(pixels[2] > 0),
      "it lights the floor by its colour and size", text);
  const double exposed = mesh_view_exposure(&d, pixels) * red;
  snprintf(text, sizeof text, "%g", exposed);
  check(fabs(exposed - 0.8) < 0.06, "the automatic exposure makes nine tenths at most 0.8", text);
  close_file(&o);
}

/* Pictures of two brightnesses, and of what is behind. */
static void exposures(void) {
  float pixels[300];
  pktrt_render_desc d;
  memset(&d, 0, sizeof d);
  d.width = d.height = 10;
  for (int c = 0; c < 3; c++) d.background[c] = 7;
  for (int i = 0; i < 300; i++) pixels[i] = i < 60 ? 7 : i < 288 ? 2.0f : 100.0f; /* 20, 76, 4 pixels */
  char text[100];
  double exposed = 2 * mesh_view_exposure(&d, pixels);
  snprintf(text, sizeof text, "%g", exposed);
  check(fabs(exposed - 0.8) < 0.03, "a twentieth of a picture may be brighter than what is exposed for", text);
  for (int i = 240; i < 300; i++) pixels[i] = 100;
  exposed = 100 * mesh_view_exposure(&d, pixels);
  snprintf(text, sizeof text, "%g", exposed);
  check(fabs(exposed - 0.8) < 0.03, "but not a fifth", text);
}

/* The fold of 50 degrees with texture coordinates that do not meet along it. */
static void seams(void) {
  const double angle = 50 * 3.14159265358979 / 180;
  FILE *file = fopen("seam.obj", "w");
  if (!file) exit(2);
  fprintf(file, "v -1 0 1\nv 1 0 1\nv -1 0 0\nv 1 0 0\n");
  for (int side = -1; side <= 1; side += 2) fprintf(file, "v %d %.9g %.9g\n", side, -sin(angle), -cos(angle));
  fprintf(
      file, "vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\nvt 0.5 0.5\nf 1/1 2/2 4/3\nf 1/1 4/3 3/4\nf 3/5 4/1 6/2\nf 3/5 6/2 5/3\n");
  fclose(file);
  char text[100];
  opened o = open_file("seam.obj");
  const float from[3] = {0.1f, 1, 0.01f}, to[3] = {0, -1, 0};
  const met m = look(&o, from, to);
  const double off = angle_between(m.surface.normal, m.surface.shading_normal);
  snprintf(text, sizeof text, "%.3g degrees", off);
  check(o.ok && off > 20, "normals are smooth across seams of texture coordinates", text);
  close_file(&o);
}

/* >>memory --------------------------------------------------------------------------------------------------------- */

/* Renders a small picture, so that hooks are called. */
static bool draw(pktrt_scene *world, const mesh_file *file) {
  static float pixels[16 * 16 * 3];
  pktrt_render_desc d;
  pktrt_scene_info info;
  memset(&d, 0, sizeof d);
  d.width = d.height = 16;
  d.pixels = pixels;
  d.mode = PKTRT_MODE_DRT;
  d.samples = 2;
  const mesh_view view = {"it", 1, false, false, false};
  bool ok = pktrt_commit(world) == PKTRT_OK;
  pktrt_get_scene_info(world, &info);
  if (!ok || info.degenerate >= info.triangles) return ok;
  if (file->has_camera) mesh_view_take_camera(file, &info, &d.camera);
  else if (!mesh_view_frame_bounds(&view, &info, &d.camera)) return false;
  mesh_view_light(&view, file, world, &d, &ok);
  return ok && (pktrt_render(world, &d) == PKTRT_OK || ex_fail("%s", pktrt_last_error(world)));
}

/* Loads a file in a process of its own, which has 2 GB, and draws it; returns its exit status, and what it says. */
static int load_apart(const char *path, char *said, size_t room) {
  int ends[2], status = 0;
  size_t n = 0;
  if (pipe(ends) != 0) exit(2);
  fflush(stdout);
  const pid_t child = fork();
  if (child < 0) exit(2);
  if (child == 0) {
#ifndef MESH_FILE_ASAN
    const struct rlimit least = {(rlim_t)2 << 30, (rlim_t)2 << 30};
    setrlimit(RLIMIT_AS, &least);
#endif
    dup2(ends[1], STDERR_FILENO);
    close(ends[0]);
    close(ends[1]);
    pktrt_scene *world = pktrt_scene_create(NULL);
    mesh_file opened_file;
    const bool ok = world && mesh_file_open(&opened_file, world, path, false) && draw(world, &opened_file);
    pktrt_scene_destroy(world);
    mesh_file_close(&opened_file);
    _exit(ok ? 0 : 1);
  }
  close(ends[1]);
  for (ssize_t got; n + 1 < room && (got = read(ends[0], said + n, room - n - 1)) > 0;) n += (size_t)got;
  said[n] = 0;
  close(ends[0]);
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

static bool one_line_about(const char *said, const char *path) {
  const char *end = strchr(said, '\n');
  return strncmp(said, "error: ", 7) == 0 && strstr(said, path) && end && !end[1];
}

static void memory(void) {
  static const unsigned long counts[4][2] = {{4294967295u, 1}, {1u << 30, 1}, {3, 4294967295u}, {3, 1u << 30}};
  char said[2000], path[40], text[2100];
  for (int i = 0; i < 4; i++) {
    snprintf(path, sizeof path, "much%d.ply", i);
    FILE *file = ply_begin(path, counts[i][0], counts[i][1]);
    fprintf(file, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    fclose(file);
    const int status = load_apart(path, said, sizeof said);
    snprintf(text, sizeof text, "status %d: %.*s", status, (int)strcspn(said, "\n"), said);
    check(status == 1 && one_line_about(said, path), "a .ply file that wants too much memory ends in one line", text);
  }
  const int status = load_apart("ball.ply", said, sizeof said);
  snprintf(text, sizeof text, "status %d", status);
  check(status == 0 && !said[0], "control: one that is as long as it says is read", text);
}

/* >>damage --------------------------------------------------------------------------------------------------------- */

/* Changes some bytes of a file, and says what becomes of it. */
static bool survives(const char *from, const char *path, const char *drawn, uint32_t *random) {
  static char bytes[20000], said[4000];
  FILE *file = fopen(from, "rb");
  if (!file) exit(2);
  const size_t n = fread(bytes, 1, sizeof bytes, file);
  fclose(file);
  for (int i = 0; i < 3; i++) {
    static const char better[] = "0123456789-.e{}[]\",:nai*";
    *random = *random * 1664525u + 1013904223u;
    const size_t at = (*random >> 4) % n;
    *random = *random * 1664525u + 1013904223u;
    bytes[at] = better[(*random >> 8) % (sizeof better - 1)];
  }
  file = fopen(path, "wb");
  if (!file) exit(2);
  fwrite(bytes, 1, n, file);
  fclose(file);
  const int status = load_apart(drawn, said, sizeof said);
  const bool ok =
      (status == 0 || status == 1) && !strstr(said, "Sanitizer") && (status == 0 || strstr(said, "error: "));
  if (!ok) printf("  %s: status %d: %s\n", path, status, said);
  return ok;
}

static void damage(void) {
  enum { TIMES = 60 };
  uint32_t random = 1;
  char text[100];
  unsigned good = 0;
  write_text("damaged.obj",
      "mtllib damaged.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl m4\nf 1/1 2/2 3/3\n");
  for (int i = 0; i < TIMES; i++) {
    good += survives("factors.gltf", "damaged.gltf", "damaged.gltf", &random);
    good += survives("places.gltf", "damaged.gltf", "damaged.gltf", &random);
    good += survives("mtl.mtl", "damaged.mtl", "damaged.obj", &random);
  }
  snprintf(text, sizeof text, "%u of %d", good, 3 * TIMES);
  check(good == 3 * TIMES, "files with wrong bytes are read and drawn, or refused", text);
}

int main(void) {
  normals();
  mtl_is_mapped();
  obj_textures();
  habits();
  far_coordinates();
  gltf_factors();
  gltf_places();
  vertex_colours();
  lamps();
  exposures();
  seams();
  memory();
  damage();
#ifdef MESH_FILE_ASAN
  const char *built = "with AddressSanitizer";
#else
  const char *built = "plain";
#endif
  printf("test-mesh-file: %d of %d checks passed, %s\n", checks - failures, checks, built);
  return failures != 0;
}
