/* Meshes from files, for examples and benchmarks, with materials (material_file.h), lights and a camera if there are any:

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
#include <assimp/version.h>
#endif

#include "material_file.h"

#define MESH_FILE_MAX_TRIANGLES (1u << 28)
#define MESH_FILE_MAX_LIGHTS 1000u

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
    free((void *)kept->mesh[i].texcoords);
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
    copy->texcoords = (const float *)mesh_file_duplicate(mesh->texcoords, (size_t)mesh->vertex_count * 2, &ok);
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

/* What a file brought beside its meshes. Zeroed: nothing. */
typedef struct mesh_file {
  mesh_file_meshes kept; /* if asked for */
  bool scatters;         /* materials do more than to be diffuse */
  uint32_t lights;       /* in the scene, emitting meshes among them */
  uint32_t own_lights;   /* of these, what the file calls so */
  double light_sum[2];   /* of their intensities: of directional ones, and of points */
  double light_place[3]; /* sum of the points' places, by intensity */
  double glow;           /* power of emitting meshes */
  bool has_camera;
  pktrt_camera camera; /* its target is a direction */
  void **owned;
  size_t owned_count;
  material_mesh *of_model; /* what hooks need of the meshes that are models, by their place in the file */
#ifdef HAVE_ASSIMP
  material_files materials;
#endif
} mesh_file;

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
static const C_STRUCT aiScene *mesh_file_import(const char *path, off_t size, unsigned steps) {
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
  C_STRUCT aiPropertyStore *settings = aiCreatePropertyStore();
  /* Of what is removed only where that is asked for. */
  aiSetImportPropertyInteger(settings, AI_CONFIG_PP_RVC_FLAGS,
      aiComponent_TEXCOORDS | aiComponent_COLORS | aiComponent_TANGENTS_AND_BITANGENTS);
  mesh_file_watch_death(true);
  alarm(20 + (unsigned)(size >> 20));
  const C_STRUCT aiScene *file = aiImportFileExWithProperties(path, steps, NULL, settings);
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
static uint32_t mesh_file_split_vertex(
    mesh_file_smoothing *s, const pktrt_mesh_desc *mesh, uint32_t vertex, uint32_t n) {
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

/* >>shapes --------------------------------------------------------------------------------------------------------- */

/* A mesh on its way from the file to the scene; arrays of `vertices`, or NULL. */
typedef struct mesh_file_shape {
  uint32_t vertices, triangles;
  float *positions, *normals, *texcoords;
  float *tangents; /* tangent and bitangent */
  float *colours;  /* RGBA */
  uint32_t *indices;
} mesh_file_shape;

static void mesh_file_free_shape(mesh_file_shape *shape) {
  free(shape->positions);
  free(shape->normals);
  free(shape->texcoords);
  free(shape->tangents);
  free(shape->colours);
  free(shape->indices);
  memset(shape, 0, sizeof *shape);
}

static float mesh_file_finite(float x) { return fabsf(x) < 1e30f ? x : 0; }

/* Writes n vectors to every `stride` floats. */
static void mesh_file_copy(float *to, size_t stride, const C_STRUCT aiVector3D *from, unsigned n) {
  for (size_t i = 0; i < n; i++) {
    to[stride * i] = (float)from[i].x;
    to[stride * i + 1] = (float)from[i].y;
    if (stride > 2) to[stride * i + 2] = (float)from[i].z;
  }
}

/* Returns the normals of a mesh, scaled to unit length; NULL if any is zero or NaN, then the mesh is shaded flat, or if
   there is no memory, which *lacks tells. */
static float *mesh_file_take_normals(const C_STRUCT aiMesh *from, bool *lacks) {
  float *normals = (float *)malloc(((size_t)from->mNumVertices + 1) * 12);
  *lacks = normals == NULL;
  if (!normals) return NULL;
  mesh_file_copy(normals, 3, from->mNormals, from->mNumVertices);
  for (size_t i = 0; i < from->mNumVertices; i++) {
    float *n = normals + 3 * i;
    const double squared = (double)n[0] * (double)n[0] + (double)n[1] * (double)n[1] + (double)n[2] * (double)n[2];
    if (!(squared > 0 && squared < (double)INFINITY)) {
      free(normals);
      return NULL;
    }
    for (int a = 0; a < 3; a++) n[a] = (float)((double)n[a] / sqrt(squared));
  }
  return normals;
}

/* Takes what a mesh has beyond its positions. False: no memory. */
static bool mesh_file_take_rest(mesh_file_shape *shape, const C_STRUCT aiMesh *from, uint32_t coordinates, bool bent) {
  const size_t n = from->mNumVertices;
  bool lacks = false;
  if (from->mNormals) shape->normals = mesh_file_take_normals(from, &lacks);
  if (coordinates < AI_MAX_NUMBER_OF_TEXTURECOORDS && from->mTextureCoords[coordinates]) {
    shape->texcoords = (float *)malloc(8 * n + 1);
    lacks = lacks || !shape->texcoords;
    if (shape->texcoords) mesh_file_copy(shape->texcoords, 2, from->mTextureCoords[coordinates], from->mNumVertices);
    for (size_t i = 0; shape->texcoords && i < 2 * n; i++) shape->texcoords[i] = mesh_file_finite(shape->texcoords[i]);
  }
  if (bent && shape->normals && from->mTangents && from->mBitangents) {
    shape->tangents = (float *)malloc(24 * n + 1);
    lacks = lacks || !shape->tangents;
    if (shape->tangents) {
      mesh_file_copy(shape->tangents, 6, from->mTangents, from->mNumVertices);
      mesh_file_copy(shape->tangents + 3, 6, from->mBitangents, from->mNumVertices);
    }
  }
  if (from->mColors[0]) {
    shape->colours = (float *)malloc(16 * n + 1);
    lacks = lacks || !shape->colours;
    for (size_t i = 0; shape->colours && i < n; i++) {
      shape->colours[4 * i] = material_within((float)from->mColors[0][i].r, 0, 1);
      shape->colours[4 * i + 1] = material_within((float)from->mColors[0][i].g, 0, 1);
      shape->colours[4 * i + 2] = material_within((float)from->mColors[0][i].b, 0, 1);
      shape->colours[4 * i + 3] = material_within((float)from->mColors[0][i].a, 0, 1);
    }
  }
  return !lacks;
}

static bool mesh_file_lacks_memory(const char *path, unsigned vertices) {
  return ex_fail("%s: not enough memory for a mesh of %u vertices", path, vertices);
}

/* Takes the triangles and vertices of a mesh. False after saying why not. */
static bool mesh_file_take(
    mesh_file_shape *shape, const char *path, const C_STRUCT aiMesh *from, uint32_t coordinates, bool bent) {
  memset(shape, 0, sizeof *shape);
  if (from->mNumFaces > UINT32_MAX / 9) return mesh_file_lacks_memory(path, from->mNumVertices);
  shape->vertices = from->mNumVertices;
  shape->positions = (float *)malloc(12 * (size_t)from->mNumVertices + 1);
  shape->indices = (uint32_t *)malloc(12 * (size_t)from->mNumFaces + 1);
  if (!shape->positions || !shape->indices || !mesh_file_take_rest(shape, from, coordinates, bent))
    return mesh_file_lacks_memory(path, from->mNumVertices);
  mesh_file_copy(shape->positions, 3, from->mVertices, from->mNumVertices);
  for (unsigned f = 0; f < from->mNumFaces; f++)
    if (from->mFaces[f].mNumIndices == 3)
      memcpy(shape->indices + 3 * (size_t)shape->triangles++, from->mFaces[f].mIndices, 12);
  for (size_t c = 0; c < 3 * (size_t)shape->triangles; c++)
    if (shape->indices[c] >= shape->vertices) return ex_fail("%s: a triangle has a vertex that is not there", path);
  return true;
}

/* Replaces an array of `width` floats a vertex by one of `width` floats a corner. False: no memory. */
static bool mesh_file_spread(float **values, size_t width, const uint32_t *indices, size_t corners) {
  float *spread = *values ? (float *)malloc(4 * width * corners + 1) : NULL;
  if (!*values) return true;
  if (!spread) return false;
  for (size_t c = 0; c < corners; c++) memcpy(spread + width * c, *values + width * indices[c], 4 * width);
  free(*values);
  *values = spread;
  return true;
}

typedef struct mesh_file_place {
  float position[3];
  uint32_t vertex;
} mesh_file_place;

static int mesh_file_compare_places(const void *a, const void *b) {
  const mesh_file_place *p = (const mesh_file_place *)a, *q = (const mesh_file_place *)b;
  for (int i = 0; i < 3; i++)
    if (p->position[i] < q->position[i] || p->position[i] > q->position[i])
      return p->position[i] < q->position[i] ? -1 : 1;
  return (p->vertex > q->vertex) - (p->vertex < q->vertex);
}

/* Returns for each corner the first vertex that has its position, where files have several for the sake of texture
   coordinates or colours; NULL: no memory. */
static uint32_t *mesh_file_weld(const mesh_file_shape *shape) {
  const size_t n = shape->vertices, corners = 3 * (size_t)shape->triangles;
  mesh_file_place *places = (mesh_file_place *)malloc(n * sizeof *places + 1);
  uint32_t *first = (uint32_t *)malloc(4 * n + 1), *welded = (uint32_t *)malloc(4 * corners + 1);
  if (places && first && welded) {
    for (size_t i = 0; i < n; i++) {
      for (size_t a = 0; a < 3; a++) places[i].position[a] = mesh_file_finite(shape->positions[3 * i + a]);
      places[i].vertex = (uint32_t)i;
    }
    qsort(places, n, sizeof *places, mesh_file_compare_places);
    for (size_t i = 0; i < n; i++) {
      const bool same = i > 0 && places[i].position[0] == places[i - 1].position[0] &&
                        places[i].position[1] == places[i - 1].position[1] &&
                        places[i].position[2] == places[i - 1].position[2];
      first[places[i].vertex] = same ? first[places[i - 1].vertex] : places[i].vertex;
    }
    for (size_t c = 0; c < corners; c++) welded[c] = first[shape->indices[c]];
  }
  free(places);
  free(first);
  if (places && first) return welded;
  free(welded);
  return NULL;
}

/* Gives a shape without normals smooth ones; then it has three vertices a triangle if it has more than positions.
   False: no memory. */
static bool mesh_file_smooth_shape(mesh_file_shape *shape) {
  const size_t corners = 3 * (size_t)shape->triangles;
  mesh_file_smoothing smoothing;
  pktrt_mesh_desc mesh;
  memset(&smoothing, 0, sizeof smoothing);
  memset(&mesh, 0, sizeof mesh);
  uint32_t *welded = mesh_file_weld(shape);
  mesh.positions = shape->positions, mesh.vertex_count = shape->vertices;
  mesh.indices = welded, mesh.triangle_count = shape->triangles;
  bool ok = welded && mesh_file_smooth(&smoothing, &mesh);
  if (ok && !shape->texcoords && !shape->colours) {
    free(shape->positions);
    free(shape->indices);
    shape->vertices = mesh.vertex_count;
    shape->positions = smoothing.positions, smoothing.positions = NULL;
    shape->normals = smoothing.normals, smoothing.normals = NULL;
    shape->indices = smoothing.indices, smoothing.indices = NULL;
  } else if (ok) {
    ok = mesh_file_spread(&shape->positions, 3, shape->indices, corners) &&
         mesh_file_spread(&shape->texcoords, 2, shape->indices, corners) &&
         mesh_file_spread(&shape->colours, 4, shape->indices, corners) &&
         mesh_file_spread(&smoothing.normals, 3, smoothing.indices, corners);
    shape->normals = smoothing.normals, smoothing.normals = NULL;
    shape->vertices = (uint32_t)corners;
    for (size_t c = 0; ok && c < corners; c++) shape->indices[c] = (uint32_t)c;
  }
  mesh_file_free_smoothing(&smoothing);
  free(welded);
  return ok;
}

/* Gives a shape tangents and bitangents: at each vertex the sums over its triangles of the directions in which u
   and v grow. False: no memory. */
static bool mesh_file_find_tangents(mesh_file_shape *shape) {
  shape->tangents = (float *)calloc((size_t)shape->vertices * 6 + 1, sizeof(float));
  if (!shape->tangents) return false;
  for (size_t t = 0; t < shape->triangles; t++) {
    const uint32_t *corner = shape->indices + 3 * t;
    const float *p[3], *w[3];
    double axis[6];
    for (int k = 0; k < 3; k++) {
      p[k] = shape->positions + 3 * (size_t)corner[k];
      w[k] = shape->texcoords + 2 * (size_t)corner[k];
    }
    const double u1 = (double)w[1][0] - (double)w[0][0], v1 = (double)w[1][1] - (double)w[0][1];
    const double u2 = (double)w[2][0] - (double)w[0][0], v2 = (double)w[2][1] - (double)w[0][1];
    const double turn = u1 * v2 - u2 * v1 < 0 ? -1 : 1;
    double squares[2] = {0, 0};
    for (int a = 0; a < 3; a++) {
      const double e = (double)p[1][a] - (double)p[0][a], f = (double)p[2][a] - (double)p[0][a];
      axis[a] = turn * (e * v2 - f * v1);
      axis[3 + a] = turn * (f * u1 - e * u2);
      squares[0] += axis[a] * axis[a];
      squares[1] += axis[3 + a] * axis[3 + a];
    }
    for (int a = 0; a < 6; a++) {
      const double square = squares[a / 3];
      if (!(square > 0 && square < (double)INFINITY)) continue;
      for (int k = 0; k < 3; k++) shape->tangents[6 * (size_t)corner[k] + (size_t)a] += (float)(axis[a] / sqrt(square));
    }
  }
  return true;
}

/* Moves a shape by a matrix of 3 x 4; one that mirrors turns its triangles around, so that outside stays outside. */
static void mesh_file_move(mesh_file_shape *shape, const float m[12]) {
  double c[9]; /* cofactors: what normals are multiplied by */
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 3; k++) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, k1 = (k + 1) % 3, k2 = (k + 2) % 3;
      c[3 * i + k] = (double)m[4 * i1 + k1] * (double)m[4 * i2 + k2] - (double)m[4 * i1 + k2] * (double)m[4 * i2 + k1];
    }
  const double determinant = (double)m[0] * c[0] + (double)m[1] * c[1] + (double)m[2] * c[2];
  const double side = determinant < 0 ? -1 : 1;
  for (size_t i = 0; i < shape->vertices; i++) {
    float *p = shape->positions + 3 * i, moved[3];
    for (int a = 0; a < 3; a++) moved[a] = m[4 * a] * p[0] + m[4 * a + 1] * p[1] + m[4 * a + 2] * p[2] + m[4 * a + 3];
    memcpy(p, moved, sizeof moved);
    for (int k = 0; shape->tangents && k < 2; k++) {
      float *t = shape->tangents + 6 * i + 3 * k;
      for (int a = 0; a < 3; a++) moved[a] = m[4 * a] * t[0] + m[4 * a + 1] * t[1] + m[4 * a + 2] * t[2];
      memcpy(t, moved, sizeof moved);
    }
    if (!shape->normals) continue;
    float *n = shape->normals + 3 * i;
    double turned[3], square = 0;
    for (int a = 0; a < 3; a++) {
      turned[a] = side * (c[3 * a] * (double)n[0] + c[3 * a + 1] * (double)n[1] + c[3 * a + 2] * (double)n[2]);
      square += turned[a] * turned[a];
    }
    for (int a = 0; a < 3 && square > 0 && square < (double)INFINITY; a++) n[a] = (float)(turned[a] / sqrt(square));
  }
  for (size_t t = 0; side < 0 && t < shape->triangles; t++) {
    const uint32_t second = shape->indices[3 * t + 1];
    shape->indices[3 * t + 1] = shape->indices[3 * t + 2];
    shape->indices[3 * t + 2] = second;
  }
}

static double mesh_file_area(const mesh_file_shape *shape) {
  double area = 0;
  for (size_t t = 0; t < shape->triangles; t++) {
    double e[3], f[3];
    for (int a = 0; a < 3; a++) {
      const double p = (double)shape->positions[3 * (size_t)shape->indices[3 * t] + (size_t)a];
      e[a] = (double)shape->positions[3 * (size_t)shape->indices[3 * t + 1] + (size_t)a] - p;
      f[a] = (double)shape->positions[3 * (size_t)shape->indices[3 * t + 2] + (size_t)a] - p;
    }
    const double x = e[1] * f[2] - e[2] * f[1], y = e[2] * f[0] - e[0] * f[2], z = e[0] * f[1] - e[1] * f[0];
    area += 0.5 * sqrt(x * x + y * y + z * z);
  }
  return area;
}

/* >>nodes ---------------------------------------------------------------------------------------------------------- */

typedef struct mesh_file_box {
  float lo[3], hi[3];
} mesh_file_box;

/* A file on its way to the scene. */
typedef struct mesh_file_reader {
  pktrt_scene *world;
  const char *path;
  const C_STRUCT aiScene *file;
  mesh_file *to;
  bool plain, as_model;
  uint32_t *uses;     /* of each mesh, by nodes */
  uint32_t *model;    /* of each mesh, one more than its index; 0: none yet */
  mesh_file_box *box; /* of the models' vertices */
  uint64_t triangles;
  uint32_t scene_meshes;
  double lo[3], hi[3]; /* of all vertices, by their nodes */
  bool some;
  /* Not used. */
  unsigned spots, other_lights, dark_glows, shapes;
} mesh_file_reader;

static bool mesh_file_refused(const mesh_file_reader *r) {
  return ex_fail("%s: %s", r->path, pktrt_last_error(r->world));
}

static bool mesh_file_no_memory(const mesh_file_reader *r) { return ex_fail("%s: not enough memory", r->path); }

/* Keeps memory as long as the file's scene; false: no memory, also for `block` NULL, and it is freed. */
static bool mesh_file_own(mesh_file *to, void *block) {
  void **grown = block ? (void **)realloc(to->owned, (to->owned_count + 1) * sizeof *grown) : NULL;
  if (!grown) {
    free(block);
    return false;
  }
  to->owned = grown;
  grown[to->owned_count++] = block;
  return true;
}

static material_file *mesh_file_material(const mesh_file_reader *r, const C_STRUCT aiMesh *from) {
  return from->mMaterialIndex < r->to->materials.count ? &r->to->materials.material[from->mMaterialIndex] : NULL;
}

/* Notes what hooks need of a mesh, and takes that from the shape. */
static bool mesh_file_note(mesh_file_reader *r, mesh_file_shape *shape, material_mesh *noted) {
  if (!shape->tangents && !shape->colours) return true;
  bool ok = mesh_file_own(r->to, shape->indices);
  noted->indices = shape->indices, shape->indices = NULL;
  noted->triangle_count = shape->triangles;
  if (shape->tangents) ok = mesh_file_own(r->to, shape->tangents) && ok;
  noted->tangents = shape->tangents, shape->tangents = NULL;
  if (shape->colours) ok = mesh_file_own(r->to, shape->colours) && ok;
  noted->colours = shape->colours, shape->colours = NULL;
  return ok;
}

/* Lets hooks find a mesh by its index. */
static bool mesh_file_list(mesh_file_reader *r, uint32_t index, const material_mesh *noted) {
  material_meshes *meshes = r->to->materials.meshes;
  if (!noted->indices) return true;
  if (index >= meshes->count) {
    const size_t n = (size_t)index + 1 + index / 2;
    material_mesh *grown = (material_mesh *)realloc(meshes->mesh, n * sizeof *grown);
    if (!grown) return false;
    memset(grown + meshes->count, 0, (n - meshes->count) * sizeof *grown);
    meshes->mesh = grown;
    meshes->count = (uint32_t)n;
  }
  meshes->mesh[index] = *noted;
  return true;
}

/* Makes a shape of a mesh of the file, moved unless `place` is NULL. False after saying why not. */
static bool mesh_file_shape_of(
    mesh_file_reader *r, const C_STRUCT aiMesh *from, const float *place, mesh_file_shape *shape) {
  const material_file *material = mesh_file_material(r, from);
  const bool bent = material && material->map[MATERIAL_MAP_NORMAL].picture;
  if (!mesh_file_take(shape, r->path, from, material ? material->coordinates : 0, bent)) return false;
  r->triangles += shape->triangles;
  if (r->triangles > MESH_FILE_MAX_TRIANGLES)
    return ex_fail("%s: more than %lu triangles, those of meshes that are there several times counted each time",
        r->path, (unsigned long)MESH_FILE_MAX_TRIANGLES);
  if (shape->triangles == 0) return true;
  bool ok = from->mNormals || mesh_file_smooth_shape(shape);
  if (ok && bent && shape->texcoords && !shape->tangents) ok = mesh_file_find_tangents(shape);
  if (ok && place) mesh_file_move(shape, place);
  return ok || mesh_file_lacks_memory(r->path, from->mNumVertices);
}

static pktrt_mesh_desc mesh_file_describe(const mesh_file_shape *shape, const material_file *material) {
  pktrt_mesh_desc mesh;
  memset(&mesh, 0, sizeof mesh);
  mesh.positions = shape->positions;
  mesh.normals = shape->normals;
  mesh.texcoords = shape->texcoords;
  mesh.vertex_count = shape->vertices;
  mesh.indices = shape->indices;
  mesh.triangle_count = shape->triangles;
  mesh.material = material ? material->index : 0;
  return mesh;
}

/* Widens the bounds by the vertices of a shape that has been moved, or is to be, unless `place` is NULL. */
static void mesh_file_widen(mesh_file_reader *r, const mesh_file_shape *shape, const float *place) {
  for (size_t i = 0; i < shape->vertices; i++) {
    const float *p = shape->positions + 3 * i;
    for (int a = 0; a < 3; a++) {
      double x = (double)p[a];
      if (place)
        x = (double)place[4 * a] * (double)p[0] + (double)place[4 * a + 1] * (double)p[1] +
            (double)place[4 * a + 2] * (double)p[2] + (double)place[4 * a + 3];
      if (x < r->lo[a]) r->lo[a] = x;
      if (x > r->hi[a]) r->hi[a] = x;
    }
  }
}

static bool mesh_file_is_gltf(const char *path) { return ex_has_suffix(path, ".gltf") || ex_has_suffix(path, ".glb"); }

/* Makes a light of a mesh that emits. Formats before glTF have emission for what is to look less dark: below 1 it is
   seen, and gives no light. */
static bool mesh_file_shine(mesh_file_reader *r, uint32_t index, const material_file *material, double area) {
  const float *emission = material->made.emission;
  pktrt_light light;
  if (!(material_most(emission) > 0) || material->unlit) return true;
  const bool faint = !mesh_file_is_gltf(r->path) && material_most(emission) < 1;
  if (faint || material->map[MATERIAL_MAP_GLOW].picture || r->to->lights >= MESH_FILE_MAX_LIGHTS) {
    r->dark_glows++;
    return true;
  }
  memset(&light, 0, sizeof light);
  light.kind = PKTRT_LIGHT_MESH;
  light.mesh = index;
  for (int c = 0; c < 3; c++) light.intensity[c] = 1;
  r->to->glow += 2 * 3.14159265358979 * area * (double)material_most(emission);
  r->to->lights++;
  return pktrt_add_light(r->world, &light, NULL) == PKTRT_OK || mesh_file_refused(r);
}

/* Adds a mesh where a node has it. */
static bool mesh_file_add_baked(mesh_file_reader *r, const C_STRUCT aiMesh *from, const float *place) {
  const material_file *material = mesh_file_material(r, from);
  mesh_file_shape shape;
  material_mesh noted;
  uint32_t index = 0;
  memset(&noted, 0, sizeof noted);
  bool ok = mesh_file_shape_of(r, from, place, &shape);
  if (ok && shape.triangles > 0) {
    const pktrt_mesh_desc mesh = mesh_file_describe(&shape, material);
    mesh_file_widen(r, &shape, NULL);
    if (r->as_model) {
      index = r->to->kept.count;
      ok = mesh_file_keep(&r->to->kept, r->path, &mesh);
    } else {
      ok = pktrt_add_mesh(r->world, &mesh, &index) == PKTRT_OK || mesh_file_refused(r);
      r->scene_meshes++;
      if (ok && material && !r->plain) ok = mesh_file_shine(r, index, material, mesh_file_area(&shape));
    }
    if (ok && !r->plain)
      ok = (mesh_file_note(r, &shape, &noted) && mesh_file_list(r, index, &noted)) || mesh_file_no_memory(r);
  }
  mesh_file_free_shape(&shape);
  return ok;
}

/* Adds a model of one mesh, if there is none yet. */
static bool mesh_file_add_model(mesh_file_reader *r, unsigned which) {
  const C_STRUCT aiMesh *from = r->file->mMeshes[which];
  mesh_file_shape shape;
  if (r->model[which]) return true;
  bool ok = mesh_file_shape_of(r, from, NULL, &shape);
  if (ok && shape.triangles > 0) {
    uint32_t model = 0;
    const pktrt_mesh_desc mesh = mesh_file_describe(&shape, mesh_file_material(r, from));
    ok = pktrt_add_model(r->world, &mesh, 1, &model) == PKTRT_OK || mesh_file_refused(r);
    if (ok) r->model[which] = model + 1;
    for (int a = 0; a < 3; a++) r->box[which].lo[a] = r->box[which].hi[a] = shape.positions[a];
    for (size_t i = 3; i < 3 * (size_t)shape.vertices; i++) {
      const size_t a = i % 3;
      if (shape.positions[i] < r->box[which].lo[a]) r->box[which].lo[a] = shape.positions[i];
      if (shape.positions[i] > r->box[which].hi[a]) r->box[which].hi[a] = shape.positions[i];
    }
    if (ok && !r->plain) ok = mesh_file_note(r, &shape, &r->to->of_model[which]) || mesh_file_no_memory(r);
  }
  mesh_file_free_shape(&shape);
  return ok;
}

/* Shows a mesh that several nodes have. */
static bool mesh_file_add_instance(mesh_file_reader *r, unsigned which, const float place[12]) {
  pktrt_instance_desc instance;
  if (!mesh_file_add_model(r, which)) return false;
  if (!r->model[which]) return true; /* it has no triangles */
  memset(&instance, 0, sizeof instance);
  instance.model = r->model[which] - 1;
  instance.transforms = place;
  if (pktrt_add_instance(r->world, &instance, NULL) != PKTRT_OK)
    return mesh_file_add_baked(
        r, r->file->mMeshes[which], place); /* flattened, which is no instance, or refused again */
  float corners[24];
  mesh_file_shape ends;
  memset(&ends, 0, sizeof ends);
  ends.positions = corners;
  ends.vertices = 8;
  for (int i = 0; i < 24; i++) corners[i] = i / 3 >> i % 3 & 1 ? r->box[which].hi[i % 3] : r->box[which].lo[i % 3];
  mesh_file_widen(r, &ends, place);
  material_mesh noted = r->to->of_model[which];
  const uint32_t index = r->scene_meshes++;
  if (!noted.indices) return true;
  float *copy = (float *)malloc(12 * sizeof *copy);
  if (copy) memcpy(copy, place, 12 * sizeof *copy);
  noted.transform = copy;
  return (mesh_file_own(r->to, copy) && mesh_file_list(r, index, &noted)) || mesh_file_no_memory(r);
}

/* Places the meshes of a node. */
static bool mesh_file_add_node(mesh_file_reader *r, const C_STRUCT aiNode *node, const float place[12]) {
  static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  bool ok = true;
  for (unsigned i = 0; ok && i < node->mNumMeshes; i++) {
    const unsigned which = node->mMeshes[i];
    if (which >= r->file->mNumMeshes) continue;
    const C_STRUCT aiMesh *mesh = r->file->mMeshes[which];
    if (!(mesh->mPrimitiveTypes & aiPrimitiveType_TRIANGLE)) {
      r->shapes++;
      continue;
    }
    const material_file *material = mesh_file_material(r, mesh);
    const bool emits = material && material_most(material->made.emission) > 0;
    const bool moved = memcmp(place, identity, sizeof identity) != 0;
    r->some = true;
    if (r->uses[which] > 1 && !emits && !r->as_model) ok = mesh_file_add_instance(r, which, place);
    else ok = mesh_file_add_baked(r, mesh, moved ? place : NULL);
  }
  return ok;
}

/* c = a b, matrices of 3 x 4 by rows. */
static void mesh_file_multiply(const float a[12], const C_STRUCT aiMatrix4x4 *b, float c[12]) {
  const float m[12] = {(float)b->a1, (float)b->a2, (float)b->a3, (float)b->a4, (float)b->b1, (float)b->b2, (float)b->b3,
      (float)b->b4, (float)b->c1, (float)b->c2, (float)b->c3, (float)b->c4};
  for (int i = 0; i < 3; i++)
    for (int k = 0; k < 4; k++)
      c[4 * i + k] = a[4 * i] * m[k] + a[4 * i + 1] * m[4 + k] + a[4 * i + 2] * m[8 + k] + (k == 3 ? a[4 * i + 3] : 0);
}

/* A node that waits to be visited, and how it lies. */
typedef struct mesh_file_waiting {
  const C_STRUCT aiNode *node;
  float place[12];
} mesh_file_waiting;

/* Visits all nodes, a node before its children, which come in their order; not by recursion, for a file may nest
   them deep. */
static bool mesh_file_visit(
    mesh_file_reader *r, bool (*visit)(mesh_file_reader *, const C_STRUCT aiNode *, const float place[12])) {
  static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  size_t n = 0, room = 64;
  mesh_file_waiting *waiting = (mesh_file_waiting *)malloc(room * sizeof *waiting);
  bool ok = waiting != NULL;
  if (ok && r->file->mRootNode) {
    waiting[0].node = r->file->mRootNode;
    mesh_file_multiply(identity, &r->file->mRootNode->mTransformation, waiting[0].place);
    n = 1;
  }
  while (ok && n > 0) {
    const mesh_file_waiting now = waiting[--n];
    if (!visit(r, now.node, now.place)) {
      free(waiting);
      return false;
    }
    while (ok && n + now.node->mNumChildren > room) {
      mesh_file_waiting *grown = (mesh_file_waiting *)realloc(waiting, 2 * room * sizeof *grown);
      ok = grown != NULL;
      if (ok) waiting = grown, room *= 2;
    }
    for (unsigned i = now.node->mNumChildren; ok && i > 0; i--) {
      waiting[n].node = now.node->mChildren[i - 1];
      mesh_file_multiply(now.place, &waiting[n].node->mTransformation, waiting[n].place);
      n++;
    }
  }
  free(waiting);
  return ok || mesh_file_no_memory(r);
}

static bool mesh_file_count_uses(mesh_file_reader *r, const C_STRUCT aiNode *node, const float place[12]) {
  (void)place;
  for (unsigned i = 0; i < node->mNumMeshes; i++)
    if (node->mMeshes[i] < r->file->mNumMeshes) r->uses[node->mMeshes[i]]++;
  return true;
}

/* >>lights --------------------------------------------------------------------------------------------------------- */

static bool mesh_file_same_name(const C_STRUCT aiString *a, const C_STRUCT aiString *b) {
  return a->length == b->length && !memcmp(a->data, b->data, a->length);
}

/* out = place (x, y, z, w) */
static void mesh_file_apply(const float place[12], const C_STRUCT aiVector3D *v, float w, float out[3]) {
  for (int a = 0; a < 3; a++)
    out[a] = place[4 * a] * (float)v->x + place[4 * a + 1] * (float)v->y + place[4 * a + 2] * (float)v->z +
             w * place[4 * a + 3];
}

static bool mesh_file_usable(const float v[3], float most) {
  return fabsf(v[0]) <= most && fabsf(v[1]) <= most && fabsf(v[2]) <= most;
}

/* Returns the factor that makes a light's colour its intensity. glTF's lights are in candela and lux, and weaken by the
   square of the distance. Those of other formats make a white surface that faces them as bright as they are, by an
   attenuation of their own; here they do so at their distance from the middle of the scene. */
static double mesh_file_scale(const mesh_file_reader *r, const C_STRUCT aiLight *from, const float position[3]) {
  double square = 0, most = 0;
  if (mesh_file_is_gltf(r->path)) return 1;
  if (from->mType == aiLightSource_DIRECTIONAL) return 3.14159265358979;
  for (int a = 0; a < 3; a++) {
    square += pow(0.5 * (r->lo[a] + r->hi[a]) - (double)position[a], 2);
    most += pow(0.5 * (r->hi[a] - r->lo[a]), 2);
  }
  square = fmax(square, 0.25 * most);
  double weakens = (double)from->mAttenuationConstant + (double)from->mAttenuationLinear * sqrt(square) +
                   (double)from->mAttenuationQuadratic * square;
  if (ex_has_suffix(r->path, ".3ds")) weakens = 1; /* its files say nothing of this, and assimp the same of all */
  return 3.14159265358979 * square / (weakens > 0 && weakens < 1e30 ? weakens : 1);
}

static bool mesh_file_add_light(mesh_file_reader *r, const C_STRUCT aiLight *from, const float place[12]) {
  pktrt_light light;
  mesh_file *to = r->to;
  memset(&light, 0, sizeof light);
  const bool directional = from->mType == aiLightSource_DIRECTIONAL;
  const bool point = from->mType == aiLightSource_POINT || from->mType == aiLightSource_SPOT;
  if ((!directional && !point) || to->lights >= MESH_FILE_MAX_LIGHTS) {
    r->other_lights++;
    return true;
  }
  r->spots += from->mType == aiLightSource_SPOT;
  light.kind = directional ? PKTRT_LIGHT_DIRECTIONAL : PKTRT_LIGHT_POINT;
  mesh_file_apply(place, &from->mPosition, 1, light.position);
  mesh_file_apply(place, &from->mDirection, 0, light.direction);
  const double scale = mesh_file_scale(r, from, light.position);
  light.intensity[0] = material_within((float)(scale * (double)from->mColorDiffuse.r), 0, 1e30f);
  light.intensity[1] = material_within((float)(scale * (double)from->mColorDiffuse.g), 0, 1e30f);
  light.intensity[2] = material_within((float)(scale * (double)from->mColorDiffuse.b), 0, 1e30f);
  const bool usable = directional ? mesh_file_usable(light.direction, 1e15f) && material_normalise(light.direction)
                                  : mesh_file_usable(light.position, 1e15f);
  if (!usable || !(material_most(light.intensity) > 0)) return true;
  to->light_sum[0] += directional ? (double)material_most(light.intensity) : 0;
  if (point) {
    to->light_sum[1] += (double)material_most(light.intensity);
    for (int a = 0; a < 3; a++)
      to->light_place[a] += (double)light.position[a] * (double)material_most(light.intensity);
  }
  to->lights++;
  to->own_lights++;
  return pktrt_add_light(r->world, &light, NULL) == PKTRT_OK || mesh_file_refused(r);
}

/* The first camera of the file. glTF's importer puts the place of a camera's node into the camera as well, and
   takes the angle up and down times the aspect for that across. */
static void mesh_file_take_camera(mesh_file_reader *r, const C_STRUCT aiCamera *from, const float place[12]) {
  const bool gltf = mesh_file_is_gltf(r->path);
  const C_STRUCT aiVector3D zero = {0, 0, 0};
  pktrt_camera *camera = &r->to->camera;
  mesh_file_apply(place, gltf ? &zero : &from->mPosition, 1, camera->eye);
  mesh_file_apply(place, &from->mLookAt, 0, camera->target);
  mesh_file_apply(place, &from->mUp, 0, camera->up);
  const double across = (double)from->mHorizontalFOV, aspect = from->mAspect > 0 ? (double)from->mAspect : 0;
  const bool linear = aiGetVersionMajor() < 5 || (aiGetVersionMajor() == 5 && aiGetVersionMinor() < 3);
  double up = across;
  if (aspect > 0) up = gltf && linear ? across / aspect : 2 * atan(tan(across / 2) / aspect);
  if (from->mOrthographicWidth > 0) {
    camera->projection = PKTRT_PROJECTION_ORTHOGRAPHIC;
    camera->width = 2 * (float)from->mOrthographicWidth;
  } else if (!(up > 0.001 && up < 3.1)) {
    return;
  }
  camera->fov_y = camera->projection == PKTRT_PROJECTION_ORTHOGRAPHIC ? 0 : (float)(up * 57.29577951308232);
  if (!(mesh_file_usable(camera->eye, 1e15f) && mesh_file_usable(camera->target, 1e15f) &&
          material_normalise(camera->target)))
    return;
  const float along = material_normalise(camera->up) ? material_dot(camera->up, camera->target) : 1;
  if (!(fabsf(along) < 0.94f)) { /* assimp has +y for what is z in .3ds; y is tried by the library */
    const bool along_z = fabsf(camera->target[2]) > 0.94f;
    memset(camera->up, 0, sizeof camera->up);
    camera->up[2] = along_z ? 0.0f : 1.0f;
  }
  r->to->has_camera = true;
}

/* Takes the lights and the camera that are at a node, by its name. */
static bool mesh_file_light_node(mesh_file_reader *r, const C_STRUCT aiNode *node, const float place[12]) {
  const C_STRUCT aiScene *file = r->file;
  if (file->mNumCameras > 0 && !r->to->has_camera && mesh_file_same_name(&file->mCameras[0]->mName, &node->mName))
    mesh_file_take_camera(r, file->mCameras[0], place);
  for (unsigned i = 0; i < file->mNumLights && i < MESH_FILE_MAX_LIGHTS; i++)
    if (mesh_file_same_name(&file->mLights[i]->mName, &node->mName) && !mesh_file_add_light(r, file->mLights[i], place))
      return false;
  return true;
}

/* >>notes ---------------------------------------------------------------------------------------------------------- */

typedef struct mesh_file_line {
  char text[900];
  bool some;
} mesh_file_line;

/* Adds "3 things" to a line, if there are any. */
static void mesh_file_say(mesh_file_line *line, unsigned count, const char *one, const char *several) {
  const size_t n = strlen(line->text);
  if (count == 0) return;
  snprintf(line->text + n, sizeof line->text - n, "%s%u %s", line->some ? ", " : "", count, count == 1 ? one : several);
  line->some = true;
}

/* Says in one line what of a file is not used. */
static void mesh_file_tell(const mesh_file_reader *r) {
  const material_files *m = &r->to->materials;
  const C_STRUCT aiScene *file = r->file;
  mesh_file_line line;
  unsigned skins = 0, morphs = 0;
  memset(&line, 0, sizeof line);
  for (unsigned i = 0; i < file->mNumMeshes; i++) {
    skins += file->mMeshes[i]->mNumBones > 0;
    morphs += file->mMeshes[i]->mNumAnimMeshes > 0;
  }
  snprintf(line.text, sizeof line.text, "%.400s: not used: ", r->path);
  mesh_file_say(&line, m->unknown, "texture of an unknown kind", "textures of an unknown kind");
  mesh_file_say(&line, m->broken, "texture that cannot be read", "textures that cannot be read");
  mesh_file_say(&line, m->missing, "texture that is not there", "textures that are not there");
  mesh_file_say(&line, m->other_maps, "texture of what is no colour, roughness, emission, opacity or normal",
      "textures of what is no colour, roughness, emission, opacity or normal");
  mesh_file_say(
      &line, m->other_coordinates, "texture with coordinates of its own", "textures with coordinates of their own");
  mesh_file_say(&line, m->layers, "clearcoat or sheen", "clearcoats or sheens");
  mesh_file_say(&line, m->frosted, "roughness of glass", "roughnesses of glass");
  mesh_file_say(&line, file->mNumAnimations, "animation", "animations");
  mesh_file_say(&line, skins, "skeleton", "skeletons");
  mesh_file_say(&line, morphs, "mesh's morph targets", "meshes' morph targets");
  mesh_file_say(&line, r->shapes, "mesh of points or lines", "meshes of points or lines");
  mesh_file_say(&line, file->mNumCameras > 1 ? file->mNumCameras - 1 : 0, "further camera", "further cameras");
  mesh_file_say(&line, r->spots, "cone of a spotlight", "cones of spotlights");
  mesh_file_say(&line, r->other_lights, "light", "lights");
  mesh_file_say(&line, r->dark_glows, "glow as a light (it is seen)", "glows as lights (they are seen)");
  if (line.some) ex_say("note", line.text);
  if (m->lacks_stb) {
    snprintf(line.text, sizeof line.text, "%.400s: textures are left out, this program was built without stb_image",
        r->path);
    ex_say("note", line.text);
  }
}

/* >>read ----------------------------------------------------------------------------------------------------------- */

/* Adds the materials. Plain ones are diffuse; without a colour of theirs, the default's. */
static bool mesh_file_add_materials(mesh_file_reader *r) {
  material_files *files = &r->to->materials;
  const unsigned n = r->file->mNumMaterials;
  bool *coloured = (bool *)calloc((size_t)n + 1, sizeof *coloured);
  files->path = r->path;
  files->file = r->file;
  files->meshes = (material_meshes *)calloc(1, sizeof *files->meshes);
  files->material = (material_file *)calloc((size_t)n + 1, sizeof *files->material);
  bool ok = (files->meshes && files->material && coloured) || mesh_file_no_memory(r);
  if (ok) {
    files->meshes->world = r->world;
    files->meshes->of_model = r->as_model;
  }
  for (unsigned i = 0; ok && i < r->file->mNumMeshes; i++)
    if (r->file->mMeshes[i]->mColors[0] && r->file->mMeshes[i]->mMaterialIndex < n)
      coloured[r->file->mMeshes[i]->mMaterialIndex] = true;
  for (unsigned i = 0; ok && i < n; i++) {
    material_file *m = &files->material[files->count++];
    const C_STRUCT aiMaterial *from = r->file->mMaterials[i];
    if (!r->plain) material_read(files, m, from, coloured[i]);
    else if (!material_colour(from, "$clr.diffuse", 1, m->made.albedo)) m->is_default = true;
    r->to->scatters = r->to->scatters || m->made.specular != PKTRT_SPECULAR_NONE;
  }
  if (ok && !r->plain && aiGetVersionMajor() * 100 + aiGetVersionMinor() < 503) material_read_strengths(files);
  for (unsigned i = 0; ok && i < n; i++) {
    material_file *m = &files->material[i];
    if (!m->is_default) ok = pktrt_add_material(r->world, &m->made, &m->index) == PKTRT_OK || mesh_file_refused(r);
  }
  free(coloured);
  return ok;
}

static bool mesh_file_add_scene(mesh_file_reader *r) {
  const size_t n = (size_t)r->file->mNumMeshes + 1;
  r->uses = (uint32_t *)calloc(n, sizeof *r->uses);
  r->model = (uint32_t *)calloc(n, sizeof *r->model);
  r->box = (mesh_file_box *)calloc(n, sizeof *r->box);
  r->to->of_model = (material_mesh *)calloc(n, sizeof *r->to->of_model);
  bool ok = (r->uses && r->model && r->box && r->to->of_model) || mesh_file_no_memory(r);
  ok = ok && mesh_file_add_materials(r) && mesh_file_visit(r, mesh_file_count_uses) &&
       mesh_file_visit(r, mesh_file_add_node);
  if (ok && !r->plain && !r->as_model) ok = mesh_file_visit(r, mesh_file_light_node);
  free(r->uses);
  free(r->model);
  free(r->box);
  return ok && (r->some || ex_fail("%s: no triangles", r->path));
}

/* Frees what assimp has read. It crashes (5.2) as it frees the pictures of a .3mf, so these stay. */
static void mesh_file_release(mesh_file_reader *r) {
  C_STRUCT aiScene *file = (C_STRUCT aiScene *)r->file;
  if (ex_has_suffix(r->path, ".3mf")) {
    file->mNumTextures = 0;
    file->mTextures = NULL;
  }
  aiReleaseImport(file);
  r->to->materials.file = NULL;
}

static bool mesh_file_add_assimp(mesh_file_reader *r, off_t size) {
  r->file = mesh_file_import(r->path, size,
      aiProcess_Triangulate | aiProcess_SortByPType | aiProcess_JoinIdenticalVertices |
          (r->plain ? (unsigned)aiProcess_RemoveComponent : 0));
  if (!r->file) return ex_fail("%s: %s", r->path, aiGetErrorString());
  const bool ok = mesh_file_add_scene(r);
  if (ok && !r->plain) mesh_file_tell(r);
  mesh_file_release(r);
  return ok;
}
#endif

/* >>open ----------------------------------------------------------------------------------------------------------- */

static bool mesh_file_read(mesh_file *to, pktrt_scene *world, const char *path, bool plain, bool as_model) {
  struct stat info;
  memset(to, 0, sizeof *to);
  if (stat(path, &info) != 0) return ex_fail("%s: cannot be read: %s", path, strerror(errno));
  if (!S_ISREG(info.st_mode)) return ex_fail("%s: not a regular file", path);
  if (ex_has_suffix(path, ".tri")) return mesh_file_add_tri(world, path, info.st_size, as_model ? &to->kept : NULL);
#ifdef HAVE_ASSIMP
  mesh_file_reader reader;
  memset(&reader, 0, sizeof reader);
  reader.world = world;
  reader.path = path;
  reader.to = to;
  for (int a = 0; a < 3; a++) {
    reader.lo[a] = (double)INFINITY;
    reader.hi[a] = -(double)INFINITY;
  }
  reader.plain = plain;
  reader.as_model = as_model;
  return mesh_file_add_assimp(&reader, info.st_size);
#else
  (void)plain;
  return ex_fail("%s: this program was built without assimp and reads .tri files only", path);
#endif
}

/* Frees what a file brought; after the scene's last render, for textures are of it. */
EX_UNUSED static void mesh_file_close(mesh_file *file) {
  mesh_file_free(&file->kept);
  for (size_t i = 0; i < file->owned_count; i++) free(file->owned[i]);
  free(file->owned);
  free(file->of_model);
#ifdef HAVE_ASSIMP
  material_free(&file->materials);
#endif
  memset(file, 0, sizeof *file);
}

/* Adds the meshes of a file to the scene with their materials and lights; as_model: keeps the meshes in file->kept, for
   pktrt_add_model, and adds materials alone. False after one line that says why not. Says in one line what is not used.
   mesh_file_close it in any case. */
EX_UNUSED static bool mesh_file_open(mesh_file *file, pktrt_scene *world, const char *path, bool as_model) {
  return mesh_file_read(file, world, path, false, as_model);
}

/* Adds the meshes of a file to the scene, all of them diffuse, without textures and lights; false after one line
   that says why not. */
EX_UNUSED static bool mesh_file_load(pktrt_scene *world, const char *path) {
  mesh_file file;
  const bool ok = mesh_file_read(&file, world, path, true, false);
  mesh_file_close(&file);
  return ok;
}

#endif /* EXAMPLES_MESH_FILE_H */
