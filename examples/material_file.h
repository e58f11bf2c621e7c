/* Materials of files as pktrt's: colours, textures and normal maps by one texture hook. Include after common.h and
   pktrt.h. One material of a file becomes one of pktrt:

     metal and roughness    Above roughness 0.8 diffuse, metal or not. Metallic 0 without a texture of it: diffuse with a
     (glTF)                 coat by ior. Else a mirror, whose reflectance the hook sets by point and angle,
                            F0 + (max(1 - roughness, F0) - F0) (1 - cos)^5 with F0 = ((ior - 1) / (ior + 1))^2 mixed
                            with the colour by metallic, over the albedo colour (1 - metallic) (1 - reflectance).
     roughness              Phong exponent 0.5 / roughness^4 - 0.5; ideal below 0.05.
     specular, glossiness   The same with F0 of the file, metallic 0 and roughness 1 - glossiness.
     transmission           With a thickness glass that absorbs by attenuation; without, a thin sheet tinted by colour.
     alpha                  Mask: a cutout at its cutoff. Blend: a ray goes on with probability 1 - alpha.
     unlit                  Emits its colour and reflects nothing.
     Kd, Ks, Ns, Ni, d,     illum 0, 1 or no Ks: diffuse. Coloured Ks, or illum 3, 5, 8: a mirror of Ks, whose lobe has
     illum (.mtl, others)   the exponent Ns, ideal from 1000 on. Grey Ks: a coat of 2 Ks, at most 1, times Fresnel of
                            Ni. d below 1: with illum 4, 6, 7, 9 glass of Ni, else blend; d 0, as of Tr 1: opaque.
     emission               Is seen, and gives light where no texture changes it, but in files before glTF where it is
                            faint (mesh_file.h).

   Colours are clamped to [0,1], and what is NaN is 0. Textures are of colours (sRGB), of metal and roughness, emission,
   opacity, reflectance and normals (in the space of tangents), with one set of coordinates for each material.

   Contents: meshes, maps, hook, classic, physical, strength, read. */
#ifndef EXAMPLES_MATERIAL_FILE_H
#define EXAMPLES_MATERIAL_FILE_H

#include "image.h"
#include <dirent.h>
#include <strings.h>

#define MATERIAL_MAX_EMISSION 1e6f /* radiance */
#define MATERIAL_MAX_EXPONENT 1e6f
#define MATERIAL_IDEAL_ROUGHNESS 0.05f
#define MATERIAL_DIFFUSE_ROUGHNESS 0.8f
#define MATERIAL_MAX_TEXELS (1u << 28) /* of all pictures of a file together */

/* >>meshes --------------------------------------------------------------------------------------------------------- */

/* What hooks need of a mesh beyond what the library hands them. Zeroed: nothing. */
typedef struct material_mesh {
  uint32_t triangle_count;
  const uint32_t *indices;
  const float *tangents;  /* tangent and bitangent of each vertex, six floats; NULL: none */
  const float *colours;   /* linear RGBA of each vertex; NULL: white */
  const float *transform; /* of an instance, 3 x 4 by rows; NULL: none */
} material_mesh;

/* The meshes of a scene by their index there; those of instances beyond the last are looked up by their model's. */
typedef struct material_meshes {
  const pktrt_scene *world;
  material_mesh *mesh;
  uint32_t count;
  bool of_model; /* the list is of a model's meshes */
} material_meshes;

/* Returns what is known of a mesh of the scene; NULL if nothing is. */
static const material_mesh *material_find_mesh(const material_meshes *meshes, uint32_t mesh, uint32_t triangle) {
  if (meshes->of_model && !pktrt_get_mesh_source(meshes->world, mesh, NULL, &mesh)) return NULL;
  if (mesh >= meshes->count || triangle >= meshes->mesh[mesh].triangle_count) return NULL;
  return &meshes->mesh[mesh];
}

/* Mixes `width` floats, of `stride` a vertex, of the corners of point i. */
static void material_mix(const material_mesh *mesh, const pktrt_points *points, uint32_t i, const float *values,
    size_t width, float *mixed) {
  const uint32_t *corner = mesh->indices + 3 * (size_t)points->triangle[i];
  const float u = points->barycentric[0][i];
  const float v = points->barycentric[1][i];
  const float *p = values + width * corner[0];
  const float *q = values + width * corner[1];
  const float *r = values + width * corner[2];
  for (size_t k = 0; k < width; k++) mixed[k] = (1 - u - v) * p[k] + u * q[k] + v * r[k];
}

/* >>maps ----------------------------------------------------------------------------------------------------------- */

/* What textures change. */
enum {
  MATERIAL_MAP_COLOUR,
  MATERIAL_MAP_ROUGHNESS, /* green: roughness, blue: metallic */
  MATERIAL_MAP_GLOW,
  MATERIAL_MAP_OPACITY,
  MATERIAL_MAP_NORMAL,
  MATERIAL_MAP_SHINE, /* reflectance */
  MATERIAL_MAPS
};

typedef struct material_map {
  const image *picture; /* NULL: none */
  bool asked;           /* the file has one, which cannot be used */
  float place[2][3];    /* coordinates of the picture = place (u, v, 1) */
  image_wrap wrap[2];
} material_map;

typedef enum material_alpha { MATERIAL_OPAQUE = 0, MATERIAL_MASK, MATERIAL_BLEND } material_alpha;

typedef struct material_file {
  pktrt_material made; /* its `user` is this one, if it has a hook */
  uint32_t index;      /* in the scene */
  bool is_default;     /* the file says nothing of it */
  material_map map[MATERIAL_MAPS];
  uint32_t coordinates; /* which set of the file's */
  float colour[3], alpha, cutoff;
  float f0[3], metallic, roughness; /* of what the hook makes a mirror by angle */
  bool by_angle, unlit;
  bool opacity_is_alpha; /* of its map; else it is grey */
  float bend;            /* scale of the normal map */
  material_alpha transparent;
  const material_meshes *meshes;
} material_file;

/* A number in [lo, hi]; what is NaN is lo. */
static float material_within(float x, float lo, float hi) {
  if (!(x > lo)) return lo;
  return x < hi ? x : hi;
}

EX_UNUSED static float material_most(const float rgb[3]) {
  const float two = rgb[0] > rgb[1] ? rgb[0] : rgb[1];
  return two > rgb[2] ? two : rgb[2];
}

static float material_exponent(float roughness) {
  const float squared = roughness * roughness;
  const float exponent = squared > 0 ? 0.5f / (squared * squared) - 0.5f : MATERIAL_MAX_EXPONENT;
  return material_within(exponent, 0, MATERIAL_MAX_EXPONENT);
}

/* >>hook ----------------------------------------------------------------------------------------------------------- */

/* Gets what a map has at a point; without one, ones. */
static void material_sample(const material_map *map, const pktrt_points *points, uint32_t i, float rgba[4]) {
  float at[2];
  const float u = points->texcoord[0][i];
  const float v = points->texcoord[1][i];
  for (int a = 0; a < 4; a++) rgba[a] = 1;
  if (!map->picture) return;
  for (int a = 0; a < 2; a++) at[a] = map->place[a][0] * u + map->place[a][1] * v + map->place[a][2];
  image_at(map->picture, at[0], at[1], map->wrap[0], map->wrap[1], rgba);
}

static float material_dot(const float a[3], const float b[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

/* Makes a vector of unit length; false if it has none. */
static bool material_normalise(float a[3]) {
  const float squared = material_dot(a, a);
  if (!(squared > 1e-30f && squared < 1e30f)) return false;
  for (int c = 0; c < 3; c++) a[c] /= sqrtf(squared);
  return true;
}

/* Bends the normal of a point by its map. */
static void material_bend(const material_file *m, const material_mesh *mesh, const pktrt_points *points, uint32_t i) {
  float axis[2][6], code[4], normal[3], frame[6];
  material_sample(&m->map[MATERIAL_MAP_NORMAL], points, i, code);
  material_mix(mesh, points, i, mesh->tangents, 6, frame);
  for (int c = 0; c < 3; c++) normal[c] = points->normal[c][i];
  for (int k = 0; k < 2; k++) {
    const float *from = frame + 3 * k;
    const float *row = mesh->transform;
    for (int c = 0; c < 3; c++, row += row ? 4 : 0) axis[k][c] = row ? material_dot(row, from) : from[c];
    const float along = material_dot(axis[k], normal);
    for (int c = 0; c < 3; c++) axis[k][c] -= along * normal[c];
    if (!material_normalise(axis[k])) return;
  }
  const float x = m->bend * (2 * code[0] - 1);
  const float y = m->bend * (2 * code[1] - 1);
  const float z = 2 * code[2] - 1;
  for (int c = 0; c < 3; c++) points->normal_out[c][i] = x * axis[0][c] + y * axis[1][c] + z * normal[c];
}

/* Sets albedo, reflectance and exponent of a mirror that reflects by the angle. */
static void material_reflect(const material_file *m, const float colour[3], const pktrt_points *points, uint32_t i) {
  float texel[4], normal[3], direction[3];
  material_sample(&m->map[MATERIAL_MAP_ROUGHNESS], points, i, texel);
  const float roughness = m->roughness * texel[1];
  const bool matte = roughness > MATERIAL_DIFFUSE_ROUGHNESS;
  const float metallic = matte ? 0 : m->metallic * texel[2];
  material_sample(&m->map[MATERIAL_MAP_SHINE], points, i, texel);

  for (int c = 0; c < 3; c++) {
    normal[c] = points->normal_out[c][i];
    direction[c] = points->direction[c][i];
  }
  const float cosine = material_normalise(normal) ? fabsf(material_dot(normal, direction)) : 1;
  const float aside = material_within(1 - cosine, 0, 1);
  const float fifth = aside * aside * aside * aside * aside;
  for (int c = 0; c < 3; c++) {
    const float f0 = m->f0[c] * texel[c] * (1 - metallic) + colour[c] * metallic;
    const float most = f0 > 1 - roughness ? f0 : 1 - roughness;
    const float reflected = matte ? 0 : material_within(f0 + (most - f0) * fifth, 0, 1);
    points->reflectance[c][i] = reflected;
    points->albedo[c][i] = colour[c] * (1 - metallic) * (1 - reflected);
  }
  points->exponent[i] = material_exponent(roughness);
}

/* Sets albedo and reflectance of what reflects by the library's rules. */
static void material_tint(const material_file *m, const float colour[3], const pktrt_points *points, uint32_t i) {
  float texel[4];
  material_sample(&m->map[MATERIAL_MAP_SHINE], points, i, texel);
  for (int c = 0; c < 3; c++) {
    const float reflected = points->reflectance[c][i] * material_within(texel[c], 0, 1);
    const float rest = m->made.specular == PKTRT_SPECULAR_MIRROR ? 1 - reflected : 1;
    if (m->map[MATERIAL_MAP_SHINE].picture) points->reflectance[c][i] = reflected;
    points->albedo[c][i] = colour[c] < rest ? colour[c] : rest;
  }
}

static void material_set_opacity(const material_file *m, float alpha, const pktrt_points *points, uint32_t i) {
  float texel[4];
  material_sample(&m->map[MATERIAL_MAP_OPACITY], points, i, texel);
  alpha *= m->opacity_is_alpha ? texel[3] : texel[0];
  if (m->transparent == MATERIAL_MASK) points->opacity[i] = alpha >= m->cutoff;
  else if (m->transparent == MATERIAL_BLEND) points->opacity[i] = material_within(alpha, 0, 1);
}

/* The texture hook of all materials of files. */
EX_UNUSED static void material_texture(void *user, const pktrt_points *points) {
  const material_file *m = (const material_file *)user;
  for (uint32_t i = 0; i < points->n; i++) {
    const material_mesh *mesh = material_find_mesh(m->meshes, points->mesh[i], points->triangle[i]);
    float texel[4], vertex[4] = {1, 1, 1, 1}, colour[3];
    material_sample(&m->map[MATERIAL_MAP_COLOUR], points, i, texel);
    if (mesh && mesh->colours) material_mix(mesh, points, i, mesh->colours, 4, vertex);
    for (int c = 0; c < 3; c++) colour[c] = material_within(m->colour[c] * texel[c] * vertex[c], 0, 1);
    if (m->map[MATERIAL_MAP_OPACITY].picture) texel[3] = 1;
    material_set_opacity(m, m->alpha * texel[3] * vertex[3], points, i);

    if (mesh && mesh->tangents && m->map[MATERIAL_MAP_NORMAL].picture) material_bend(m, mesh, points, i);
    if (m->by_angle) material_reflect(m, colour, points, i);
    else material_tint(m, colour, points, i);

    material_sample(&m->map[MATERIAL_MAP_GLOW], points, i, texel);
    for (int c = 0; c < 3; c++) {
      points->emission[c][i] = m->unlit ? colour[c] : m->made.emission[c] * texel[c];
      if (m->unlit) points->albedo[c][i] = 0;
    }
  }
}

#ifdef HAVE_ASSIMP
#include <assimp/material.h>
#include <assimp/scene.h>
#include <assimp/GltfMaterial.h>

/* >>classic -------------------------------------------------------------------------------------------------------- */

#define MATERIAL_KEY_ILLUM "$mat.illum", 0, 0

/* What is read of a file's materials, and what of these is not used. */
typedef struct material_files {
  const char *path; /* of the file */
  const C_STRUCT aiScene *file;
  material_file *material;
  uint32_t count;
  material_meshes *meshes; /* of its own, so that this may be moved */
  struct material_picture *picture;
  uint32_t picture_count;
  uint64_t texels;
  unsigned textures; /* used */
  /* Not used. */
  unsigned unknown, broken, missing, other_maps, other_coordinates, layers, frosted;
  bool lacks_stb;
} material_files;

/* Reads a number in [lo, hi]; `otherwise` where the material has none. */
static float material_number(
    const C_STRUCT aiMaterial *from, const char *key, unsigned type, unsigned at, float otherwise) {
  ai_real value = 0;
  if (aiGetMaterialFloatArray(from, key, type, at, &value, NULL) != aiReturn_SUCCESS) return otherwise;
  return material_within((float)value, 0, 1e9f);
}

static bool material_has(const C_STRUCT aiMaterial *from, const char *key, unsigned type, unsigned at) {
  const C_STRUCT aiMaterialProperty *property;
  return aiGetMaterialProperty(from, key, type, at, &property) == aiReturn_SUCCESS;
}

/* Reads a colour, each component in [0, most]. False, and nothing is changed, where the material has none. */
static bool material_colour(const C_STRUCT aiMaterial *from, const char *key, float most, float rgb[3]) {
  C_STRUCT aiColor4D colour;
  if (aiGetMaterialColor(from, key, 0, 0, &colour) != aiReturn_SUCCESS) return false;
  rgb[0] = material_within((float)colour.r, 0, most);
  rgb[1] = material_within((float)colour.g, 0, most);
  rgb[2] = material_within((float)colour.b, 0, most);
  return true;
}

static float material_least(const float rgb[3]) {
  const float two = rgb[0] < rgb[1] ? rgb[0] : rgb[1];
  return two < rgb[2] ? two : rgb[2];
}

/* Where the mirror leaves less than the albedo, the albedo is what it leaves. */
static void material_share(pktrt_material *made) {
  for (int c = 0; c < 3; c++)
    if (made->albedo[c] > 1 - made->reflectance[c]) made->albedo[c] = 1 - made->reflectance[c];
}

static void material_set_lobe(pktrt_material *made, float exponent, bool ideal) {
  made->lobe = ideal ? PKTRT_LOBE_IDEAL : PKTRT_LOBE_PHONG;
  made->exponent = ideal ? 0 : material_within(exponent, 1, MATERIAL_MAX_EXPONENT);
}

/* The index of refraction of a file, or 1.5 where it has none; 1 is what files have that mean none. */
static float material_ior(const C_STRUCT aiMaterial *from) {
  const float ior = material_number(from, AI_MATKEY_REFRACTI, 1.5f);
  return ior > 1.001f ? material_within(ior, 1, 10) : 1.5f;
}

/* Kd, Ks, Ns, Ni, d and illum, as of .mtl and of files before glTF. */
static void material_read_classic(material_file *m, const C_STRUCT aiMaterial *from) {
  pktrt_material *made = &m->made;
  float shine[3] = {0, 0, 0};
  int illum = 2;
  const bool is_mtl = aiGetMaterialIntegerArray(from, MATERIAL_KEY_ILLUM, &illum, NULL) == aiReturn_SUCCESS;
  const float exponent = material_number(from, AI_MATKEY_SHININESS, 0);
  const bool ideal = exponent >= 1000 || exponent < 1; /* none is given with what is a mirror by illum */
  const bool glass = illum == 4 || illum == 6 || illum == 7 || illum == 9;
  material_colour(from, "$clr.specular", 1, shine);
  m->alpha = material_within(material_number(from, AI_MATKEY_OPACITY, 1), 0, 1);
  if (is_mtl && illum < 2) memset(shine, 0, sizeof shine);
  /* Files disagree on which end is opaque, those with Tr too. */
  if (!(m->alpha > 0) && !(is_mtl && glass)) m->alpha = 1;

  if (is_mtl && glass && m->alpha < 1) {
    made->specular = PKTRT_SPECULAR_DIELECTRIC;
    made->ior[0] = material_ior(from);
    m->alpha = 1;
    return;
  }
  if (m->alpha < 1) m->transparent = MATERIAL_BLEND;
  const bool mirror = is_mtl && (illum == 3 || illum == 5 || illum == 8);
  if (!(material_most(shine) > 0) || (!mirror && exponent < 1)) return;

  const bool coloured = material_most(shine) - material_least(shine) > 0.1f;
  if (coloured || mirror) {
    made->specular = PKTRT_SPECULAR_MIRROR;
    memcpy(made->reflectance, shine, sizeof shine);
  } else {
    made->specular = PKTRT_SPECULAR_COAT;
    made->ior[0] = material_ior(from);
    for (int c = 0; c < 3; c++) made->reflectance[c] = material_within(2 * shine[c], 0, 1);
  }
  material_set_lobe(made, exponent, ideal);
}

/* >>physical ------------------------------------------------------------------------------------------------------- */

/* Glass or a thin sheet. */
static void material_read_transmission(
    material_files *files, material_file *m, const C_STRUCT aiMaterial *from, float transmission) {
  pktrt_material *made = &m->made;
  float tint[3] = {1, 1, 1};
  const float distance = material_number(from, AI_MATKEY_VOLUME_ATTENUATION_DISTANCE, 0);
  made->ior[0] = material_ior(from);
  files->frosted += m->roughness > 0.2f;
  if (!(material_number(from, AI_MATKEY_VOLUME_THICKNESS_FACTOR, 0) > 0)) {
    made->specular = PKTRT_SPECULAR_THIN;
    made->transmission = material_within(transmission, 1e-3f, 1);
    return;
  }
  made->specular = PKTRT_SPECULAR_DIELECTRIC;
  material_colour(from, "$clr.attenuationColor", 1, tint);
  material_colour(from, "$mat.volume.attenuationColor", 1, tint);
  for (int c = 0; c < 3; c++)
    if (distance > 0)
      made->absorption[c] = material_within(-logf(material_within(tint[c], 1e-4f, 1)) / distance, 0, 1e9f);
}

/* Metal and roughness, or specular and glossiness. */
static void material_read_physical(material_files *files, material_file *m, const C_STRUCT aiMaterial *from) {
  pktrt_material *made = &m->made;
  const bool glossy = material_has(from, AI_MATKEY_GLOSSINESS_FACTOR);
  const float transmission = material_number(from, AI_MATKEY_TRANSMISSION_FACTOR, 0);
  const float ior = material_ior(from);
  m->metallic = glossy ? 0 : material_within(material_number(from, AI_MATKEY_METALLIC_FACTOR, 1), 0, 1);
  m->roughness = material_within(material_number(from, AI_MATKEY_ROUGHNESS_FACTOR, 1), 0, 1);
  if (glossy) m->roughness = 1 - material_within(material_number(from, AI_MATKEY_GLOSSINESS_FACTOR, 1), 0, 1);
  for (int c = 0; c < 3; c++) m->f0[c] = (ior - 1) * (ior - 1) / ((ior + 1) * (ior + 1));
  if (glossy) material_colour(from, "$clr.specular", 1, m->f0);
  files->layers += material_number(from, AI_MATKEY_CLEARCOAT_FACTOR, 0) > 0;
  files->layers += material_has(from, AI_MATKEY_SHEEN_COLOR_FACTOR);
  if (m->unlit) return;
  if (transmission > 0 && m->metallic < 0.5f) {
    material_read_transmission(files, m, from, transmission);
    return;
  }

  const bool textured = m->map[MATERIAL_MAP_ROUGHNESS].picture != NULL;
  const bool ideal = m->roughness < MATERIAL_IDEAL_ROUGHNESS && !textured;
  if (m->roughness > MATERIAL_DIFFUSE_ROUGHNESS && !textured) return;
  if (!glossy && !textured && !(m->metallic > 0)) {
    made->specular = PKTRT_SPECULAR_COAT;
    made->ior[0] = ior;
  } else {
    made->specular = PKTRT_SPECULAR_MIRROR;
    m->by_angle = true;
  }
  material_set_lobe(made, material_exponent(m->roughness), ideal);
}

/* >>strength ------------------------------------------------------------------------------------------------------- */

/* How bright emission is, which assimp before 5.3 does not read of glTF: found in the file's JSON. */

static const char *material_skip_blanks(const char *at, const char *end) {
  while (at < end && (*at == ' ' || *at == '\n' || *at == '\t' || *at == '\r' || *at == ',' || *at == ':')) at++;
  return at;
}

/* Returns where a value ends. Only brackets and strings are looked at. */
static const char *material_skip_value(const char *at, const char *end) {
  size_t depth = 0;
  bool quoted = false;
  for (; at < end; at++) {
    if (quoted && *at == '\\') at++;
    else if (*at == '"') quoted = !quoted;
    else if (quoted) continue;
    else if (*at == '{' || *at == '[') depth++;
    else if ((*at == '}' || *at == ']' || *at == ',') && depth == 0) return at;
    else if ((*at == '}' || *at == ']') && --depth == 0) return at + 1;
  }
  return end;
}

/* Returns the value of a key of the object at `at`; NULL: it is no object, or has no such key. */
static const char *material_find_key(const char *at, const char *end, const char *key) {
  const size_t n = strlen(key);
  if (!at || at >= end || *at != '{') return NULL;
  for (at = material_skip_blanks(at + 1, end); at < end && *at == '"'; at = material_skip_blanks(at, end)) {
    const char *name = ++at;
    while (at < end && *at != '"') at += *at == '\\' && at + 1 < end ? 2 : 1;
    const bool same = (size_t)(at - name) == n && !memcmp(name, key, n);
    at = material_skip_blanks(at < end ? at + 1 : end, end);
    if (same) return at;
    at = material_skip_value(at, end);
  }
  return NULL;
}

/* Multiplies the emission of a file's materials by what its JSON has for each. */
static void material_strengthen(material_files *files, const char *json, const char *end) {
  const char *at = material_find_key(material_skip_blanks(json, end), end, "materials");
  if (!at || at >= end || *at != '[') return;
  at = material_skip_blanks(at + 1, end);
  for (uint32_t i = 0; i < files->count && at < end && *at != ']'; i++) {
    const char *found = material_find_key(at, end, "extensions");
    found = material_find_key(found, end, "KHR_materials_emissive_strength");
    found = material_find_key(found, end, "emissiveStrength");
    float *emission = files->material[i].made.emission;
    const float strength = found ? material_within(strtof(found, NULL), 0, MATERIAL_MAX_EMISSION) : 1;
    for (int c = 0; c < 3; c++) emission[c] = material_within(emission[c] * strength, 0, MATERIAL_MAX_EMISSION);
    at = material_skip_blanks(material_skip_value(at, end), end);
  }
}

/* Reads the JSON of a .gltf or .glb file for what assimp leaves out of it. */
static void material_read_strengths(material_files *files) {
  enum { MOST = 1 << 26 };
  unsigned char head[20];
  const bool binary = ex_has_suffix(files->path, ".glb");
  if (!binary && !ex_has_suffix(files->path, ".gltf")) return;
  FILE *file = fopen(files->path, "rb");
  size_t n = MOST;
  if (file && binary) {
    const bool ok = fread(head, 1, 20, file) == 20;
    n = ok ? head[12] | (size_t)head[13] << 8 | (size_t)head[14] << 16 | (size_t)head[15] << 24 : 0;
  } else if (file && fseek(file, 0, SEEK_END) == 0) {
    const long size = ftell(file);
    n = size > 0 ? (size_t)size : 0;
    rewind(file);
  }
  char *json = file && n > 0 && n <= MOST ? (char *)malloc(n + 1) : NULL;
  if (json) {
    n = fread(json, 1, n, file);
    json[n] = 0;
    material_strengthen(files, json, json + n);
  }
  free(json);
  if (file) fclose(file);
}

/* >>read ----------------------------------------------------------------------------------------------------------- */

/* A picture of a file, which several maps may show. */
typedef struct material_picture {
  char name[1100];
  bool srgb;
  image *made; /* NULL: it cannot be read */
} material_picture;

static bool material_is_picture(const char *name) {
  static const char *const kinds[] = {"png", "jpg", "jpeg", "bmp", "tga", "hdr"};
  for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
    if (ex_has_suffix(name, kinds[i])) return true;
  return false;
}

/* Looks for a file in a folder, `found` up to `folder`, whatever the case of its letters; of several the first by
   their codes. */
static bool material_find_in_folder(const char *name, int folder, char *found, size_t room) {
  char at[4096];
  bool some = false;
  struct stat info;
  snprintf(at, sizeof at, "%.*s", folder, found);
  DIR *entries = opendir(folder > 0 ? at : ".");
  for (const struct dirent *entry; entries && (entry = readdir(entries));) {
    if (strcasecmp(entry->d_name, name) != 0 || (some && strcmp(entry->d_name, found + folder) >= 0)) continue;
    const int wrote = snprintf(found + folder, room - (size_t)folder, "%s", entry->d_name);
    some = wrote > 0 && (size_t)wrote < room - (size_t)folder;
  }
  if (entries) closedir(entries);
  return some && stat(found, &info) == 0 && S_ISREG(info.st_mode);
}

/* Writes where a picture is: beside the file that names it, by its path from there or by its name alone. False:
   nowhere. */
static bool material_find_picture(const char *path, const char *name, char *found, size_t room) {
  char plain[1024];
  struct stat info;
  size_t n = 0;
  const char *slash = strrchr(path, '/');
  const int folder = slash ? (int)(slash - path) + 1 : 0;
  for (const char *c = name; *c && n + 1 < sizeof plain; c++, n++) {
    unsigned code = 0;
    const bool coded = c[0] == '%' && sscanf(c + 1, "%2x", &code) == 1 && code >= 32 && c[1] && c[2];
    plain[n] = coded ? (char)code : *c == '\\' ? '/' : *c;
    if (coded) c += 2;
  }
  plain[n] = 0;
  const char *last = strrchr(plain, '/');
  const char *const tries[] = {plain, last ? last + 1 : plain};
  for (int i = 0; i < 2; i++) {
    const int wrote = snprintf(found, room, "%.*s%s", tries[i][0] == '/' ? 0 : folder, path, tries[i]);
    if (wrote > 0 && (size_t)wrote < room && stat(found, &info) == 0 && S_ISREG(info.st_mode)) return true;
  }
  return (size_t)folder < room && material_find_in_folder(last ? last + 1 : plain, folder, found, room);
}

/* Returns the picture within the file that a name means, as in "*3"; NULL: it means none. */
static const C_STRUCT aiTexture *material_find_embedded(const C_STRUCT aiScene *file, const char *name) {
  if (name[0] == '*') {
    const unsigned long index = strtoul(name + 1, NULL, 10);
    return index < file->mNumTextures ? file->mTextures[index] : NULL;
  }
  for (unsigned i = 0; i < file->mNumTextures; i++)
    if (file->mTextures[i] && file->mTextures[i]->mFilename.length > 0 &&
        !strcmp(file->mTextures[i]->mFilename.data, name))
      return file->mTextures[i];
  return NULL;
}

/* Makes a picture of one within the file. */
static bool material_read_embedded(material_files *files, material_picture *picture, const C_STRUCT aiTexture *from) {
  char name[1200];
  snprintf(name, sizeof name, "%.900s: its picture %.200s", files->path, picture->name);
  if (from->mHeight == 0) return image_load_memory(picture->made, name, from->pcData, from->mWidth, picture->srgb);
  const size_t n = (size_t)from->mWidth * from->mHeight;
  if (n == 0 || n > MATERIAL_MAX_TEXELS) return ex_fail("%s: it has no size that is possible", name);
  unsigned char *rgba = (unsigned char *)malloc(4 * n);
  for (size_t i = 0; rgba && i < n; i++) {
    rgba[4 * i] = from->pcData[i].r;
    rgba[4 * i + 1] = from->pcData[i].g;
    rgba[4 * i + 2] = from->pcData[i].b;
    rgba[4 * i + 3] = from->pcData[i].a;
  }
  const bool ok = rgba && image_from_rgba8(picture->made, from->mWidth, from->mHeight, rgba, picture->srgb);
  free(rgba);
  return ok || (!rgba && ex_fail("%s: not enough memory", name));
}

/* Reads a picture; counts it, and leaves it none, where that fails. */
static void material_read_picture(material_files *files, material_picture *picture) {
  char path[4096];
  const C_STRUCT aiTexture *embedded = material_find_embedded(files->file, picture->name);
  const char *kind = embedded ? embedded->achFormatHint : picture->name;
#ifndef HAVE_STB_IMAGE
  if (!embedded || embedded->mHeight == 0) {
    files->lacks_stb = true;
    return;
  }
#endif
  const bool raw = embedded && (embedded->mHeight > 0 || !kind[0]);
  if (!embedded && picture->name[0] == '*') {
    files->missing++;
    return;
  }
  if (!raw && !material_is_picture(kind)) {
    files->unknown++;
    return;
  }
  if (!embedded && !material_find_picture(files->path, picture->name, path, sizeof path)) {
    files->missing++;
    return;
  }
  picture->made = (image *)calloc(1, sizeof *picture->made);
  bool ok = picture->made != NULL && files->texels < MATERIAL_MAX_TEXELS;
  if (ok)
    ok = embedded ? material_read_embedded(files, picture, embedded) : image_load(picture->made, path, picture->srgb);
  if (ok) {
    files->texels += (uint64_t)picture->made->width * picture->made->height;
    return;
  }
  free(picture->made);
  picture->made = NULL;
  files->broken++;
}

/* Returns a picture by its name, or NULL if there is none that can be shown. */
static const image *material_get_picture(material_files *files, const char *name, bool srgb) {
  for (uint32_t i = 0; i < files->picture_count; i++)
    if (files->picture[i].srgb == srgb && !strcmp(files->picture[i].name, name)) return files->picture[i].made;
  const size_t n = (size_t)files->picture_count + 1;
  material_picture *grown = (material_picture *)realloc(files->picture, n * sizeof *grown);
  if (!grown) return NULL;
  files->picture = grown;
  material_picture *picture = &grown[files->picture_count++];
  memset(picture, 0, sizeof *picture);
  snprintf(picture->name, sizeof picture->name, "%s", name);
  for (size_t last = strlen(picture->name); last > 0 && picture->name[last - 1] == ' '; last--)
    picture->name[last - 1] = 0; /* Meshlab's .ply */
  picture->srgb = srgb;
  material_read_picture(files, picture);
  return picture->made;
}

/* Sets where a map lies. assimp turns glTF's transforms, which are about the upper left corner, to such about the
   middle; this turns them back, for coordinates that begin in the lower left corner. */
static void material_place_map(
    material_map *map, const C_STRUCT aiMaterial *from, C_ENUM aiTextureType type, unsigned at) {
  C_STRUCT aiUVTransform t;
  map->place[0][0] = map->place[1][1] = 1;
  if (!material_has(from, AI_MATKEY_GLTF_ALPHAMODE)) return;
  if (aiGetMaterialUVTransform(from, AI_MATKEY_UVTRANSFORM(type, at), &t) != aiReturn_SUCCESS) return;
  const float size[2] = {(float)t.mScaling.x, (float)t.mScaling.y};
  const float cosine = cosf((float)t.mRotation);
  const float sine = -sinf((float)t.mRotation);
  const float left = (float)t.mTranslation.x - 0.5f * size[0] * (1 - cosine + sine);
  const float down = 0.5f * size[1] * (sine + cosine - 1) + 1 - size[1] - (float)t.mTranslation.y;
  /* glTF's (u, w), w = 1 - v: u' = left + cosine su u + sine sw w, w' = down - sine su u + cosine sw w */
  const float place[2][3] = {{cosine * size[0], -sine * size[1], left + sine * size[1]},
      {sine * size[0], cosine * size[1], 1 - down - cosine * size[1]}};
  for (int a = 0; a < 6; a++)
    if (!(fabsf(place[a / 3][a % 3]) < 1e6f)) return;
  memcpy(map->place, place, sizeof place);
}

/* Reads a texture of a kind, if the material has one and no other in its place. */
static void material_read_map(
    material_files *files, material_file *m, const C_STRUCT aiMaterial *from, int which, C_ENUM aiTextureType type) {
  C_STRUCT aiString path;
  C_ENUM aiTextureMapping mapping = aiTextureMapping_UV;
  C_ENUM aiTextureMapMode wrap[3] = {aiTextureMapMode_Wrap, aiTextureMapMode_Wrap, aiTextureMapMode_Wrap};
  unsigned coordinates = 0;
  bool first = true;
  material_map *map = &m->map[which];
  if (map->picture || map->asked ||
      aiGetMaterialTexture(from, type, 0, &path, &mapping, &coordinates, NULL, NULL, wrap, NULL) != aiReturn_SUCCESS)
    return;
  for (int i = 0; i < MATERIAL_MAPS; i++) first = first && !m->map[i].picture;
  if (mapping != aiTextureMapping_UV || coordinates >= AI_MAX_NUMBER_OF_TEXTURECOORDS ||
      (!first && coordinates != m->coordinates)) {
    map->asked = true;
    files->other_coordinates++;
    return;
  }
  map->picture = material_get_picture(
      files, path.data, which == MATERIAL_MAP_COLOUR || which == MATERIAL_MAP_GLOW || which == MATERIAL_MAP_SHINE);
  if (!map->picture) return;
  files->textures++;
  m->coordinates = coordinates;
  for (int a = 0; a < 2; a++)
    map->wrap[a] = wrap[a] == aiTextureMapMode_Mirror ? IMAGE_MIRROR
                   : wrap[a] == aiTextureMapMode_Wrap ? IMAGE_REPEAT
                                                      : IMAGE_CLAMP;
  material_place_map(map, from, type, 0);
}

/* Reads all textures that are used, and counts the others. */
static void material_read_maps(material_files *files, material_file *m, const C_STRUCT aiMaterial *from) {
  static const C_ENUM aiTextureType others[] = {aiTextureType_AMBIENT, aiTextureType_HEIGHT, aiTextureType_SHININESS,
      aiTextureType_DISPLACEMENT, aiTextureType_REFLECTION, aiTextureType_TRANSMISSION, aiTextureType_CLEARCOAT,
      aiTextureType_SHEEN};
  material_read_map(files, m, from, MATERIAL_MAP_COLOUR, aiTextureType_BASE_COLOR);
  material_read_map(files, m, from, MATERIAL_MAP_COLOUR, aiTextureType_DIFFUSE);
  material_read_map(files, m, from, MATERIAL_MAP_ROUGHNESS, aiTextureType_UNKNOWN);
  material_read_map(files, m, from, MATERIAL_MAP_GLOW, aiTextureType_EMISSIVE);
  material_read_map(files, m, from, MATERIAL_MAP_OPACITY, aiTextureType_OPACITY);
  material_read_map(files, m, from, MATERIAL_MAP_NORMAL, aiTextureType_NORMALS);
  material_read_map(files, m, from, MATERIAL_MAP_SHINE, aiTextureType_SPECULAR);
  m->bend = material_number(from, "$tex.scale", aiTextureType_NORMALS, 0, 1);
  for (size_t i = 0; i < sizeof others / sizeof *others; i++)
    files->other_maps += aiGetMaterialTextureCount(from, others[i]) > 0;
}

/* Reads how a material is transparent, where it is of glTF. */
static void material_read_alpha(material_file *m, const C_STRUCT aiMaterial *from) {
  C_STRUCT aiString mode;
  C_STRUCT aiColor4D colour;
  if (aiGetMaterialString(from, AI_MATKEY_GLTF_ALPHAMODE, &mode) != aiReturn_SUCCESS) return;
  if (!strcmp(mode.data, "MASK")) m->transparent = MATERIAL_MASK;
  if (!strcmp(mode.data, "BLEND")) m->transparent = MATERIAL_BLEND;
  m->cutoff = material_number(from, AI_MATKEY_GLTF_ALPHACUTOFF, 0.5f);
  if (aiGetMaterialColor(from, AI_MATKEY_BASE_COLOR, &colour) == aiReturn_SUCCESS)
    m->alpha = material_within((float)colour.a, 0, 1);
}

/* Tells whether a picture is transparent anywhere. */
static bool material_has_alpha(const image *picture) {
  const size_t n = (size_t)picture->width * picture->height;
  for (size_t i = 0; picture->codes && i < n; i++)
    if (picture->codes[4 * i + 3] < 255) return true;
  return false;
}

/* Makes the hook part of the material where anything asks for it. */
static void material_set_hook(material_file *m, bool vertex_colours) {
  pktrt_material *made = &m->made;
  const image *opacity = m->map[MATERIAL_MAP_OPACITY].picture;
  const image *colour = m->map[MATERIAL_MAP_COLOUR].picture;
  const bool solid = !(m->alpha < 1) && !opacity && !vertex_colours && !(colour && material_has_alpha(colour));
  if (solid) m->transparent = MATERIAL_OPAQUE; /* whatever the file calls it */
  bool asked = vertex_colours || m->by_angle || m->transparent == MATERIAL_MASK;
  if (opacity && m->transparent == MATERIAL_OPAQUE) m->transparent = MATERIAL_BLEND;
  m->opacity_is_alpha = opacity && material_has_alpha(opacity);
  for (int i = 0; i < MATERIAL_MAPS; i++) asked = asked || m->map[i].picture;
  made->cutout = m->transparent == MATERIAL_MASK;
  made->blend = m->transparent == MATERIAL_BLEND && made->specular != PKTRT_SPECULAR_DIELECTRIC;
  if (made->blend) made->transparency = 1 - m->alpha;
  if (!asked) return;
  made->texture = material_texture;
  made->user = m;
}

/* Reads one of the file's materials. */
static void material_read(
    material_files *files, material_file *m, const C_STRUCT aiMaterial *from, bool vertex_colours) {
  static const float grey[3] = {0.8f, 0.8f, 0.8f};
  pktrt_material *made = &m->made;
  int shading = 0;
  const bool gltf = material_has(from, AI_MATKEY_GLTF_ALPHAMODE);
  /* Roughness alone is what assimp's reader of .fbx makes of the shininess of any material. */
  const bool physical =
      material_has(from, AI_MATKEY_METALLIC_FACTOR) || material_has(from, AI_MATKEY_GLOSSINESS_FACTOR);
  m->alpha = 1;
  m->cutoff = 0.5f;
  m->meshes = files->meshes;
  memcpy(m->colour, grey, sizeof grey);
  if (!material_colour(from, "$clr.base", 1, m->colour)) material_colour(from, "$clr.diffuse", 1, m->colour);
  material_colour(from, "$clr.emissive", MATERIAL_MAX_EMISSION, made->emission);
  const float brighter = material_number(from, AI_MATKEY_EMISSIVE_INTENSITY, 1);
  for (int c = 0; c < 3; c++)
    made->emission[c] = material_within(made->emission[c] * brighter, 0, MATERIAL_MAX_EMISSION);
  material_read_maps(files, m, from);
  if (m->map[MATERIAL_MAP_COLOUR].picture && !(material_most(m->colour) > 0))
    m->colour[0] = m->colour[1] = m->colour[2] = 1;
  aiGetMaterialIntegerArray(from, AI_MATKEY_SHADING_MODEL, &shading, NULL);
  m->unlit = gltf && shading == aiShadingMode_NoShading;
  material_read_alpha(m, from);
  if (physical || gltf) material_read_physical(files, m, from);
  else material_read_classic(m, from);

  if (made->specular != PKTRT_SPECULAR_DIELECTRIC) memcpy(made->albedo, m->colour, sizeof m->colour);
  if (m->unlit) {
    memcpy(made->emission, m->colour, sizeof m->colour);
    memset(made->albedo, 0, sizeof made->albedo);
  }
  if (made->specular == PKTRT_SPECULAR_MIRROR) material_share(made);
  material_set_hook(m, vertex_colours);
}

EX_UNUSED static void material_free(material_files *files) {
  for (uint32_t i = 0; i < files->picture_count; i++) {
    if (files->picture[i].made) image_free(files->picture[i].made);
    free(files->picture[i].made);
  }
  if (files->meshes) free(files->meshes->mesh);
  free(files->meshes);
  free(files->picture);
  free(files->material);
}
#endif

#endif /* EXAMPLES_MATERIAL_FILE_H */
