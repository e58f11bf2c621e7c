/* Mesh files that assimp reads, by the reader of the examples: normals that files lack are smooth, but not across edges; a
   file that wants more memory than there is ends in one line. Built without a sanitizer and with AddressSanitizer.
   usage: mesh_file, in a folder that it may write to */
#define _GNU_SOURCE
#include "../examples/common.h"

#include "../pktrt.h"

#include "../examples/mesh_file.h"

#include <sys/resource.h>
#include <sys/wait.h>

static int checks, failures;

static void check(bool good, const char *sentence, const char *figures) {
  checks++;
  failures += !good;
  printf("  %s %s (%s)\n", good ? "ok     " : "FAILED ", sentence, figures);
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

/* >>memory --------------------------------------------------------------------------------------------------------- */

/* Loads a file in a process of its own, which has 2 GB; returns its exit status, and what it says. */
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
    const bool ok = world && mesh_file_load(world, path);
    pktrt_scene_destroy(world);
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

int main(void) {
  normals();
  memory();
#ifdef MESH_FILE_ASAN
  const char *built = "with AddressSanitizer";
#else
  const char *built = "plain";
#endif
  printf("test-mesh-file: %d of %d checks passed, %s\n", checks - failures, checks, built);
  return failures != 0;
}
