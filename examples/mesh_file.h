/* Meshes from files, for examples and benchmarks:

     .tri                    uint32 triangle count, then count * 9 float32 vertex coordinates, little endian: a triangle soup
     .obj, .ply, .gltf ...   whatever assimp reads, if this program was built with it (HAVE_ASSIMP)

   Files come from anywhere: nothing in them is believed before it is checked. Coordinates and indices are checked by
   pktrt_add_mesh, whose words are passed on. Include after common.h and pktrt.h. */
#ifndef EXAMPLES_MESH_FILE_H
#define EXAMPLES_MESH_FILE_H

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>

#ifdef HAVE_ASSIMP
#include <assimp/cimport.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#endif

/* >>tri ------------------------------------------------------------------------------------------------------------ */

static uint32_t mesh_file_u32(const unsigned char *b) {
  return b[0] | (uint32_t)b[1] << 8 | (uint32_t)b[2] << 16 | (uint32_t)b[3] << 24;
}

/* Reads the count and compares it with the file's length, so that an absurd one never gets as far as malloc. */
static bool mesh_file_tri_count(FILE *file, const char *path, off_t size, uint32_t *count) {
  unsigned char header[4];
  if (fread(header, 1, 4, file) != 4) return ex_fail("%s: too short for a .tri file, not even a triangle count", path);
  *count = mesh_file_u32(header);
  uint64_t need = 4 + (uint64_t)*count * 36, have = (uint64_t)size;
  if (need != have)
    return ex_fail("%s: announces %lu triangles, which take %llu bytes, but has %llu bytes", path,
                   (unsigned long)*count, (unsigned long long)need, (unsigned long long)have);
  if (*count > UINT32_MAX / 3) return ex_fail("%s: %lu triangles are too many", path, (unsigned long)*count);
  return *count > 0 || ex_fail("%s: no triangles", path);
}

/* The coordinates of a .tri file, 9 * *count floats to be freed by the caller; NULL after saying why not. */
static float *mesh_file_read_tri(const char *path, off_t size, uint32_t *count) {
  FILE *file = fopen(path, "rb");
  float *positions = NULL;
  if (!file) {
    ex_fail("%s: cannot be read: %s", path, strerror(errno));
    return NULL;
  }
  if (mesh_file_tri_count(file, path, size, count)) {
    size_t n = (size_t)*count * 9;
    positions = (float *)malloc(n * sizeof(float));
    if (!positions) {
      ex_fail("%s: not enough memory for %lu triangles", path, (unsigned long)*count);
    } else if (fread(positions, sizeof(float), n, file) != n) {
      ex_fail("%s: cannot be read to its end", path);
      free(positions);
      positions = NULL;
    } else {
      for (size_t i = 0; i < n; i++) { /* a no-op on little-endian machines, and the compiler knows */
        unsigned char bytes[4];
        memcpy(bytes, &positions[i], 4);
        uint32_t bits = mesh_file_u32(bytes);
        memcpy(&positions[i], &bits, 4);
      }
    }
  }
  fclose(file);
  return positions;
}

/* Meshes that are kept for pktrt_add_model, with copies of their own. A zeroed one is empty. */
typedef struct mesh_file_meshes {
  pktrt_mesh_desc *mesh;
  uint32_t count;
} mesh_file_meshes;

EX_UNUSED static void mesh_file_free(mesh_file_meshes *kept) {
  for (uint32_t i = 0; i < kept->count; i++) {
    free((void *)kept->mesh[i].positions);
    free((void *)kept->mesh[i].normals);
    free((void *)kept->mesh[i].indices);
  }
  free(kept->mesh);
  memset(kept, 0, sizeof *kept);
}

/* A copy of n values of 4 bytes, *ok false where memory is lacking; NULL of NULL. */
static void *mesh_file_duplicate(const void *from, size_t n, bool *ok) {
  void *to = from ? malloc(n * 4 + 1) : NULL;
  if (to) memcpy(to, from, n * 4);
  else if (from) *ok = false;
  return to;
}

static bool mesh_file_keep(mesh_file_meshes *kept, const char *path, const pktrt_mesh_desc *mesh) {
  const size_t values = (size_t)mesh->vertex_count * 3;
  bool ok = true;
  pktrt_mesh_desc *grown = (pktrt_mesh_desc *)realloc(kept->mesh, ((size_t)kept->count + 1) * sizeof *grown);
  if (grown) {
    pktrt_mesh_desc *copy = &grown[kept->count++];
    kept->mesh = grown;
    *copy = *mesh;
    copy->positions = (const float *)mesh_file_duplicate(mesh->positions, values, &ok);
    copy->normals = (const float *)mesh_file_duplicate(mesh->normals, values, &ok);
    copy->indices = (const uint32_t *)mesh_file_duplicate(mesh->indices, (size_t)mesh->triangle_count * 3, &ok);
  }
  return (grown && ok) || ex_fail("%s: not enough memory for a model of %lu meshes", path, (unsigned long)kept->count);
}

/* Adds a mesh to the scene, or if there is a list, keeps it there. */
static bool mesh_file_add(pktrt_scene *world, const char *path, const pktrt_mesh_desc *mesh, mesh_file_meshes *kept) {
  if (kept) return mesh_file_keep(kept, path, mesh);
  pktrt_status status = pktrt_add_mesh(world, mesh, NULL);
  return status == PKTRT_OK || ex_fail("%s: %s", path, pktrt_last_error(world));
}

static bool mesh_file_add_tri(pktrt_scene *world, const char *path, off_t size, mesh_file_meshes *kept) {
  uint32_t count = 0;
  float *positions = mesh_file_read_tri(path, size, &count);
  if (!positions) return false;
  pktrt_mesh_desc mesh;
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = positions;
  mesh.vertex_count = count * 3;
  mesh.triangle_count = count;
  bool ok = mesh_file_add(world, path, &mesh, kept);
  free(positions);
  return ok;
}

/* >>assimp --------------------------------------------------------------------------------------------------------- */

#ifdef HAVE_ASSIMP
static char mesh_file_last_words[512]; /* prepared before the crash: a signal handler can only write them, */
static int mesh_file_stderr;           /* here, for assimp's own words at its end go nowhere */

static void mesh_file_crashed(int number) {
  (void)number;
  ssize_t written = write(mesh_file_stderr, mesh_file_last_words, strlen(mesh_file_last_words));
  _exit(written < 0 ? 2 : 1);
}

#if defined(__SANITIZE_ADDRESS__)
#define MESH_FILE_ASAN
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define MESH_FILE_ASAN
#endif
#endif

/* AddressSanitizer ends a program that wants too much memory by no signal, and writes to where assimp's words go. */
#ifdef MESH_FILE_ASAN
#ifdef __cplusplus
extern "C"
#endif
    void
    __sanitizer_set_death_callback(void (*callback)(void));

static void mesh_file_died(void) { mesh_file_crashed(0); }
static void mesh_file_watch_death(bool on) { __sanitizer_set_death_callback(on ? mesh_file_died : NULL); }
#else
static void mesh_file_watch_death(bool on) { (void)on; }
#endif

/* aiImportFile, which parses forty formats and does not survive every hostile file: where it crashes, also by running out of
   stack, or counts to four billion because the file says so, the program ends with one line instead of a core dump or never.
   The time allowed is 20 s and a second per megabyte. */
static const struct aiScene *mesh_file_import(const char *path, off_t size, unsigned steps) {
  static const int numbers[] = {SIGSEGV, SIGBUS, SIGFPE, SIGABRT, SIGILL, SIGALRM};
  static char stack[65536];
  struct sigaction crash, before[6];
  stack_t alternative;
  memset(&crash, 0, sizeof crash);
  memset(&alternative, 0, sizeof alternative);
  alternative.ss_sp = stack;
  alternative.ss_size = sizeof stack;
  crash.sa_handler = mesh_file_crashed;
  crash.sa_flags = SA_ONSTACK;
  snprintf(mesh_file_last_words, sizeof mesh_file_last_words,
           "error: %.400s: assimp crashes on this file, hangs, or wants more memory than there is\n", path);
  mesh_file_stderr = dup(STDERR_FILENO);
  int nowhere = open("/dev/null", O_WRONLY);
  if (nowhere >= 0) dup2(nowhere, STDERR_FILENO);
  sigaltstack(&alternative, NULL);
  for (int i = 0; i < 6; i++) sigaction(numbers[i], &crash, &before[i]);
  struct aiPropertyStore *settings = aiCreatePropertyStore();
  aiSetImportPropertyInteger(settings, AI_CONFIG_PP_RVC_FLAGS,
                             aiComponent_TEXCOORDS | aiComponent_COLORS | aiComponent_TANGENTS_AND_BITANGENTS);
  mesh_file_watch_death(true);
  alarm(20 + (unsigned)(size >> 20));
  const struct aiScene *file = aiImportFileExWithProperties(path, steps, NULL, settings);
  alarm(0);
  mesh_file_watch_death(false);
  aiReleasePropertyStore(settings);
  for (int i = 0; i < 6; i++) sigaction(numbers[i], &before[i], NULL);
  alternative.ss_flags = SS_DISABLE;
  sigaltstack(&alternative, NULL);
  dup2(mesh_file_stderr, STDERR_FILENO);
  close(mesh_file_stderr);
  if (nowhere >= 0) close(nowhere);
  return file;
}

static float mesh_file_clamp(float x) { return x > 0.0f ? x < 1.0f ? x : 1.0f : 0.0f; }

/* The diffuse colour of a material of the file; *index stays 0, the default, where it names none. */
static bool mesh_file_add_material(pktrt_scene *world, const char *path, const struct aiMaterial *from,
                                   uint32_t *index) {
  struct aiColor4D color;
  pktrt_material material;
  if (aiGetMaterialColor(from, AI_MATKEY_COLOR_DIFFUSE, &color) != aiReturn_SUCCESS) return true;
  memset(&material, 0, sizeof material);
  material.albedo[0] = mesh_file_clamp(color.r);
  material.albedo[1] = mesh_file_clamp(color.g);
  material.albedo[2] = mesh_file_clamp(color.b);
  return pktrt_add_material(world, &material, index) == PKTRT_OK || ex_fail("%s: %s", path, pktrt_last_error(world));
}

static void mesh_file_copy(float *to, const struct aiVector3D *from, unsigned n) {
  for (size_t i = 0; i < n; i++) {
    to[3 * i] = (float)from[i].x;
    to[3 * i + 1] = (float)from[i].y;
    to[3 * i + 2] = (float)from[i].z;
  }
}

/* A file's normals may be zero or NaN; then the mesh is shaded flat. */
static bool mesh_file_normals_usable(const float *normals, unsigned n) {
  for (size_t i = 0; i < n; i++) {
    float m = fabsf(normals[3 * i]) + fabsf(normals[3 * i + 1]) + fabsf(normals[3 * i + 2]);
    if (!(m > 0.0f && m < INFINITY)) return false;
  }
  return true;
}

/* One end of an edge, at the vertex that a triangle's corner is at: the vertex at its other end. */
typedef struct mesh_file_end {
  uint32_t other, corner;
} mesh_file_end;

static int mesh_file_compare_ends(const void *a, const void *b) {
  const mesh_file_end *p = (const mesh_file_end *)a, *q = (const mesh_file_end *)b;
  if (p->other != q->other) return p->other < q->other ? -1 : 1;
  return (p->corner > q->corner) - (p->corner < q->corner);
}

/* Computes the normal of each triangle, as long as twice its area. */
static void mesh_file_face_normals(const pktrt_mesh_desc *mesh, double *normal) {
  for (size_t i = 0; i < mesh->triangle_count; i++, normal += 3) {
    const uint32_t *corner = mesh->indices + 3 * i;
    const float *p0 = mesh->positions + 3 * (size_t)corner[0];
    const float *p1 = mesh->positions + 3 * (size_t)corner[1];
    const float *p2 = mesh->positions + 3 * (size_t)corner[2];
    double e[3], f[3];
    for (int a = 0; a < 3; a++) {
      e[a] = (double)p1[a] - (double)p0[a];
      f[a] = (double)p2[a] - (double)p0[a];
    }
    normal[0] = e[1] * f[2] - e[2] * f[1];
    normal[1] = e[2] * f[0] - e[0] * f[2];
    normal[2] = e[0] * f[1] - e[1] * f[0];
  }
}

/* Tells whether two triangles turn by less than 60 degrees, so that an edge of both is smooth. Those without area have
   smooth edges with none. */
static bool mesh_file_is_smooth(const double *a, const double *b) {
  const double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const double sizes = sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]) * sqrt(b[0] * b[0] + b[1] * b[1] + b[2] * b[2]);
  return sizes > 0 && cosine > 0.5 * sizes;
}

/* The first corner of those that are joined to one. */
static uint32_t mesh_file_first_joined(uint32_t *joined, uint32_t corner) {
  while (joined[corner] != corner) corner = joined[corner] = joined[joined[corner]];
  return corner;
}

/* What computing normals takes, for each vertex or corner of a mesh; and what it makes, a vertex for each corner at most. */
typedef struct mesh_file_smoothing {
  double *face;        /* normals of triangles */
  uint32_t *first;     /* where a vertex begins among the corners by vertex; the last is where all end */
  uint32_t *by_vertex; /* the corners, by vertex */
  uint32_t *joined;    /* an earlier corner that has the same normal, or itself */
  mesh_file_end *ends; /* of the edges at one vertex */
  float *positions, *normals;
  uint32_t *indices;
} mesh_file_smoothing;

static void mesh_file_free_smoothing(mesh_file_smoothing *s) {
  free(s->face);
  free(s->first);
  free(s->by_vertex);
  free(s->joined);
  free(s->ends);
  free(s->positions);
  free(s->normals);
  free(s->indices);
}

static bool mesh_file_alloc_smoothing(mesh_file_smoothing *s, const pktrt_mesh_desc *mesh) {
  const size_t corners = (size_t)mesh->triangle_count * 3;
  s->face = (double *)malloc(corners * sizeof *s->face);
  s->first = (uint32_t *)calloc((size_t)mesh->vertex_count + 2, sizeof *s->first);
  s->by_vertex = (uint32_t *)malloc(corners * sizeof *s->by_vertex);
  s->joined = (uint32_t *)malloc(corners * sizeof *s->joined);
  s->ends = (mesh_file_end *)malloc(2 * corners * sizeof *s->ends);
  s->positions = (float *)malloc(3 * corners * sizeof *s->positions);
  s->normals = (float *)malloc(3 * corners * sizeof *s->normals);
  s->indices = (uint32_t *)malloc(corners * sizeof *s->indices);
  return s->face && s->first && s->by_vertex && s->joined && s->ends && s->positions && s->normals && s->indices;
}

/* Sorts the corners by their vertices. */
static void mesh_file_sort_corners(mesh_file_smoothing *s, const pktrt_mesh_desc *mesh) {
  const uint32_t corners = mesh->triangle_count * 3;
  for (uint32_t c = 0; c < corners; c++) s->first[mesh->indices[c] + 2]++;
  for (size_t v = 2; v < (size_t)mesh->vertex_count + 2; v++) s->first[v] += s->first[v - 1];
  for (uint32_t c = 0; c < corners; c++) s->by_vertex[s->first[mesh->indices[c] + 1]++] = c;
}

/* Joins the corners at one vertex whose triangles share a smooth edge there. */
static void mesh_file_join_corners(mesh_file_smoothing *s, const pktrt_mesh_desc *mesh, uint32_t vertex) {
  size_t n = 0;
  for (uint32_t i = s->first[vertex]; i < s->first[vertex + 1]; i++) {
    const uint32_t corner = s->by_vertex[i];
    const uint32_t *triangle = mesh->indices + (size_t)(corner / 3) * 3;
    s->joined[corner] = corner;
    for (uint32_t k = 1; k < 3; k++) {
      s->ends[n].other = triangle[(corner % 3 + k) % 3];
      s->ends[n++].corner = corner;
    }
  }

  qsort(s->ends, n, sizeof *s->ends, mesh_file_compare_ends);
  for (size_t i = 1; i < n; i++) {
    const uint32_t a = s->ends[i - 1].corner, b = s->ends[i].corner;
    if (s->ends[i - 1].other != s->ends[i].other) continue;
    if (!mesh_file_is_smooth(s->face + (size_t)(a / 3) * 3, s->face + (size_t)(b / 3) * 3)) continue;
    const uint32_t p = mesh_file_first_joined(s->joined, a), q = mesh_file_first_joined(s->joined, b);
    s->joined[p > q ? p : q] = p > q ? q : p;
  }
}

/* Makes a vertex for all joined corners at one. Returns how many vertices there are then. */
static uint32_t mesh_file_split_vertex(mesh_file_smoothing *s, const pktrt_mesh_desc *mesh, uint32_t vertex,
                                       uint32_t n) {
  const uint32_t begin = s->first[vertex], end = s->first[vertex + 1];
  for (uint32_t i = begin; i < end; i++) {
    const uint32_t corner = s->by_vertex[i];
    const uint32_t first = mesh_file_first_joined(s->joined, corner);
    if (first == corner) {
      memcpy(s->positions + 3 * (size_t)n, mesh->positions + 3 * (size_t)vertex, 12);
      s->indices[corner] = n++;
    }
    s->indices[corner] = s->indices[first];
  }
  return n;
}

/* Returns what a triangle's normal counts at one of its corners: 1 over the squares of both edges there (N. Max, Weights for
   Computing Vertex Normals from Facet Normals, 1999), by which vertices on a ball get its normals. */
static double mesh_file_weight(const pktrt_mesh_desc *mesh, uint32_t corner) {
  const uint32_t *triangle = mesh->indices + (size_t)(corner / 3) * 3;
  const float *p = mesh->positions + 3 * (size_t)mesh->indices[corner];
  double product = 1;
  for (uint32_t k = 1; k < 3; k++) {
    const float *q = mesh->positions + 3 * (size_t)triangle[(corner % 3 + k) % 3];
    double square = 0;
    for (int a = 0; a < 3; a++) square += ((double)q[a] - (double)p[a]) * ((double)q[a] - (double)p[a]);
    product *= square;
  }
  return product > 0 ? 1 / product : 0;
}

/* Sums up the normals of the triangles at each of n new vertices, and scales the sums. Vertices of triangles without area
   alone, which no ray hits, get any normal. */
static bool mesh_file_sum_normals(mesh_file_smoothing *s, const pktrt_mesh_desc *mesh, uint32_t n) {
  double *sum = (double *)calloc((size_t)n * 3 + 1, sizeof *sum);
  if (!sum) return false;
  for (uint32_t c = 0; c < mesh->triangle_count * 3; c++) {
    const double weight = mesh_file_weight(mesh, c);
    for (size_t a = 0; a < 3; a++) sum[3 * (size_t)s->indices[c] + a] += weight * s->face[(size_t)(c / 3) * 3 + a];
  }

  for (size_t i = 0; i < n; i++) {
    const double *m = sum + 3 * i;
    const double size = sqrt(m[0] * m[0] + m[1] * m[1] + m[2] * m[2]);
    const bool some = size > 0 && size < (double)INFINITY;
    for (size_t a = 0; a < 3; a++) s->normals[3 * i + a] = some ? (float)(m[a] / size) : a == 2;
  }
  free(sum);
  return true;
}

/* Gives a mesh normals, which are smooth but across edges where triangles turn by 60 degrees or more: vertices there become
   several. The mesh's arrays are those of `s` then. False: no memory. */
static bool mesh_file_smooth(mesh_file_smoothing *s, pktrt_mesh_desc *mesh) {
  uint32_t n = 0;
  if (!mesh_file_alloc_smoothing(s, mesh)) return false;
  mesh_file_face_normals(mesh, s->face);
  mesh_file_sort_corners(s, mesh);
  for (uint32_t v = 0; v < mesh->vertex_count; v++) {
    mesh_file_join_corners(s, mesh, v);
    n = mesh_file_split_vertex(s, mesh, v, n);
  }
  if (!mesh_file_sum_normals(s, mesh, n)) return false;
  mesh->positions = s->positions;
  mesh->normals = s->normals;
  mesh->indices = s->indices;
  mesh->vertex_count = n;
  return true;
}

static bool mesh_file_lacks_memory(const char *path, unsigned vertices) {
  return ex_fail("%s: not enough memory for a mesh of %u vertices", path, vertices);
}

static bool mesh_file_add_aimesh(pktrt_scene *world, const char *path, const struct aiMesh *from, uint32_t material,
                                 mesh_file_meshes *kept) {
  unsigned vertices = from->mNumVertices, triangles = 0;
  float *positions = (float *)malloc(sizeof(float) * 3 * vertices);
  float *normals = (float *)malloc(sizeof(float) * 3 * vertices);
  uint32_t *indices = (uint32_t *)malloc(sizeof(uint32_t) * 3 * from->mNumFaces);
  mesh_file_smoothing smoothing;
  memset(&smoothing, 0, sizeof smoothing);
  bool ok = positions && normals && indices && from->mNumFaces <= UINT32_MAX / 3;
  if (ok) {
    pktrt_mesh_desc mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh_file_copy(positions, from->mVertices, vertices);
    if (from->mNormals) mesh_file_copy(normals, from->mNormals, vertices);
    for (unsigned f = 0; f < from->mNumFaces; f++)
      if (from->mFaces[f].mNumIndices == 3) memcpy(indices + 3 * triangles++, from->mFaces[f].mIndices, 12);
    mesh.positions = positions;
    mesh.normals = from->mNormals && mesh_file_normals_usable(normals, vertices) ? normals : NULL;
    mesh.vertex_count = vertices;
    mesh.indices = indices;
    mesh.triangle_count = triangles;
    mesh.material = material;
    for (size_t c = 0; ok && c < (size_t)triangles * 3; c++) ok = indices[c] < vertices;
    if (!ok) ex_fail("%s: a triangle has a vertex that is not there", path);
    else if (!from->mNormals && triangles > 0)
      ok = mesh_file_smooth(&smoothing, &mesh) || mesh_file_lacks_memory(path, vertices);
    ok = ok && (triangles == 0 || mesh_file_add(world, path, &mesh, kept));
  } else {
    mesh_file_lacks_memory(path, vertices);
  }
  mesh_file_free_smoothing(&smoothing);
  free(positions);
  free(normals);
  free(indices);
  return ok;
}

static bool mesh_file_add_assimp(pktrt_scene *world, const char *path, off_t size, mesh_file_meshes *kept) {
  const struct aiScene *file =
      mesh_file_import(path, size,
                       aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_PreTransformVertices |
                           aiProcess_JoinIdenticalVertices | aiProcess_RemoveComponent);
  if (!file) return ex_fail("%s: %s", path, aiGetErrorString());
  uint32_t *materials = (uint32_t *)calloc((size_t)file->mNumMaterials + 1, sizeof(uint32_t));
  bool ok = materials || ex_fail("%s: not enough memory", path);
  bool some = false;
  for (unsigned i = 0; ok && i < file->mNumMaterials; i++)
    ok = mesh_file_add_material(world, path, file->mMaterials[i], &materials[i]);
  for (unsigned i = 0; ok && i < file->mNumMeshes; i++) {
    const struct aiMesh *mesh = file->mMeshes[i];
    if (!(mesh->mPrimitiveTypes & aiPrimitiveType_TRIANGLE)) continue;
    some = true;
    ok = mesh_file_add_aimesh(world, path, mesh,
                              mesh->mMaterialIndex < file->mNumMaterials ? materials[mesh->mMaterialIndex] : 0, kept);
  }
  free(materials);
  aiReleaseImport(file);
  return ok && (some || ex_fail("%s: no triangles", path));
}
#endif

static bool mesh_file_read(pktrt_scene *world, const char *path, mesh_file_meshes *kept) {
  struct stat info;
  if (stat(path, &info) != 0) return ex_fail("%s: cannot be read: %s", path, strerror(errno));
  if (!S_ISREG(info.st_mode)) return ex_fail("%s: not a regular file", path);
  if (ex_has_suffix(path, ".tri")) return mesh_file_add_tri(world, path, info.st_size, kept);
#ifdef HAVE_ASSIMP
  return mesh_file_add_assimp(world, path, info.st_size, kept);
#else
  return ex_fail("%s: this program was built without assimp and reads .tri files only", path);
#endif
}

/* Adds the meshes of a file to the scene; false after one line that says why not. */
EX_UNUSED static bool mesh_file_load(pktrt_scene *world, const char *path) { return mesh_file_read(world, path, NULL); }

/* Adds their materials only, and keeps the meshes, for pktrt_add_model; mesh_file_free them in any case. */
EX_UNUSED static bool mesh_file_load_kept(pktrt_scene *world, const char *path, mesh_file_meshes *kept) {
  memset(kept, 0, sizeof *kept);
  return mesh_file_read(world, path, kept);
}

#endif /* EXAMPLES_MESH_FILE_H */
