/* 11_picture.h - what program, exercise and check of chapter 11 share: materials, a scene, and the same scene in the
   library. */
#ifndef PICTURE_H
#define PICTURE_H

#include "../svg.h"
#include "course.h"

/* [material] */
typedef struct picture_material {
  vec albedo;   /* the part of the light that a matte surface scatters, by channel; black for mirror and glass */
  float mirror; /* the part of the light that is reflected as in a mirror, at any angle; 0: none */
  float ior;    /* glass: its index of refraction, that of air is 1; 0: the surface is not glass */
  bool tiles;   /* squares of edge 1 in x and z; every other one has a sixth of the albedo */
} picture_material;

/* One of the rays that go on where a ray has met a surface. */
typedef struct picture_way {
  pktrt_ray_type type; /* PKTRT_RAY_REFLECTION or PKTRT_RAY_REFRACTION */
  vec direction;       /* of unit length */
  float share;         /* the part of the light that comes from there, (0,1] */
} picture_way;
/* [end] */

/* The exercise: finds the ways on from a surface and returns how many there are, 0 to 2; a reflected ray comes first.
   - direction: of the ray that has met the surface, of unit length.
   - normal: of unit length, to the outside of the body, from whichever side the ray came. */
uint32_t picture_scatter(const picture_material *material, vec direction, vec normal, picture_way way[2]);

/* >>scene ---------------------------------------------------------------------------------------------------------- */

enum { PICTURE_FLOOR, PICTURE_PANEL, PICTURE_CUBE, PICTURE_GEM, PICTURE_MATTE, PICTURE_BALL, PICTURE_PARTS };

typedef struct picture_scene {
  course_scene triangles;
  uint32_t first[PICTURE_PARTS + 1];        /* the first triangle of each part; the last: the number of triangles */
  picture_material material[PICTURE_PARTS]; /* of each part */
  vec lamp, intensity, ambient;             /* a point light, in W/sr; the radiance of the surroundings */
} picture_scene;

/* Adds a vertex and returns its number. */
EX_UNUSED static uint32_t picture_vertex(course_scene *scene, vec position) {
  scene->position[scene->vertices] = position;
  return scene->vertices++;
}

/* Adds a triangle, counter-clockwise as seen from a point on the other side of `centre`: of a convex body whose middle
   that is. */
EX_UNUSED static void picture_triangle(course_scene *scene, const uint32_t vertex[3], vec centre) {
  const vec p0 = scene->position[vertex[0]];
  const vec across = vec_cross(vec_sub(scene->position[vertex[1]], p0), vec_sub(scene->position[vertex[2]], p0));
  const bool outwards = vec_dot(across, vec_sub(p0, centre)) > 0;
  uint32_t *corner = scene->corner[scene->triangles++];

  corner[0] = vertex[0];
  corner[1] = vertex[outwards ? 1 : 2];
  corner[2] = vertex[outwards ? 2 : 1];
}

/* Adds a parallelogram: a corner and two edges. */
EX_UNUSED static void picture_quad(course_scene *scene, vec corner, vec edge, vec other, vec centre) {
  const uint32_t first = picture_vertex(scene, corner);
  picture_vertex(scene, vec_add(corner, edge));
  picture_vertex(scene, vec_add(vec_add(corner, edge), other));
  picture_vertex(scene, vec_add(corner, other));

  const uint32_t half[2][3] = {{first, first + 1, first + 2}, {first, first + 2, first + 3}};
  for (int k = 0; k < 2; k++) picture_triangle(scene, half[k], centre);
}

/* Adds a cube on its lower face, with one upright edge turned by the angle of cosine 0.8 and sine 0.6. */
EX_UNUSED static void picture_cube(course_scene *scene, vec centre, float edge) {
  const float half = edge / 2;
  const vec axis[3] = {{{0.8f * half, 0, 0.6f * half}}, {{0, half, 0}}, {{-0.6f * half, 0, 0.8f * half}}};

  for (int a = 0; a < 3; a++) {
    const vec u = axis[(a + 1) % 3];
    const vec v = axis[(a + 2) % 3];
    const vec to_corner = vec_add(u, v);
    for (int side = -1; side <= 1; side += 2) {
      const vec middle = vec_add(centre, vec_scale(axis[a], (float)side));
      picture_quad(scene, vec_sub(middle, to_corner), vec_scale(u, 2), vec_scale(v, 2), centre);
    }
  }
}

/* Adds an octahedron, turned like the cube. */
EX_UNUSED static void picture_octahedron(course_scene *scene, vec centre, float radius) {
  const vec axis[3] = {
      {{0.8f * radius, 0, 0.6f * radius}}, {{0, 1.2f * radius, 0}}, {{-0.6f * radius, 0, 0.8f * radius}}};
  uint32_t vertex[3][2];

  for (int a = 0; a < 3; a++) {
    vertex[a][0] = picture_vertex(scene, vec_sub(centre, axis[a]));
    vertex[a][1] = picture_vertex(scene, vec_add(centre, axis[a]));
  }
  for (int k = 0; k < 8; k++) {
    const uint32_t face[3] = {vertex[0][k & 1], vertex[1][k >> 1 & 1], vertex[2][k >> 2]};
    picture_triangle(scene, face, centre);
  }
}

/* Adds a face of a ball as four triangles: the middles of its edges move out to the ball. */
EX_UNUSED static void picture_fine_face(course_scene *scene, const uint32_t corner[3], vec centre, float radius) {
  uint32_t middle[3];
  for (int k = 0; k < 3; k++) {
    const vec p0 = vec_sub(scene->position[corner[k]], centre);
    const vec p1 = vec_sub(scene->position[corner[(k + 1) % 3]], centre);
    middle[k] = picture_vertex(scene, vec_add(centre, vec_scale(vec_unit(vec_add(p0, p1)), radius)));
  }

  picture_triangle(scene, middle, centre);
  for (int k = 0; k < 3; k++) {
    const uint32_t outer[3] = {corner[k], middle[k], middle[(k + 2) % 3]};
    picture_triangle(scene, outer, centre);
  }
}

/* Returns true if all three vertices are at most `distance` from each other. */
EX_UNUSED static bool picture_near(const course_scene *scene, const uint32_t corner[3], float distance) {
  for (int k = 0; k < 3; k++) {
    const vec edge = vec_sub(scene->position[corner[k]], scene->position[corner[(k + 1) % 3]]);
    if (vec_dot(edge, edge) > distance * distance) return false;
  }
  return true;
}

/* Adds an icosahedron: its vertices are at (0, +-1, +-g) and cyclic permutations, g being the golden ratio; a face is
   three vertices at distance 2 from each other. If `fine`, each face becomes four. */
EX_UNUSED static void picture_icosahedron(course_scene *scene, vec centre, float radius, bool fine) {
  const float golden = 1.618034f;
  const float unit = radius / 1.902113f; /* the root of 1 + g^2 */
  const uint32_t first = scene->vertices;

  for (int i = 0; i < 12; i++) {
    float from[3];
    from[i / 4] = 0;
    from[(i / 4 + 1) % 3] = i & 1 ? unit : -unit;
    from[(i / 4 + 2) % 3] = i & 2 ? golden * unit : -golden * unit;
    /* Turned, so that no face is upright. */
    const vec turned = {{0.8f * from[0] - 0.6f * from[1], 0.6f * from[0] + 0.8f * from[1], from[2]}};
    picture_vertex(scene, vec_add(centre, turned));
  }

  for (uint32_t i = 0; i < 12 * 12 * 12; i++) {
    const uint32_t corner[3] = {first + i / 144, first + i / 12 % 12, first + i % 12};
    if (corner[0] >= corner[1] || corner[1] >= corner[2] || !picture_near(scene, corner, 2.2f * unit)) continue;
    if (fine) picture_fine_face(scene, corner, centre, radius);
    else picture_triangle(scene, corner, centre);
  }
}

/* A floor of tiles that reflects a little; on it a mirror panel, a cube and an icosahedron of glass, a matte octahedron
   and a mirror body of 80 faces. Everything stands a little above the floor. */
EX_UNUSED static picture_scene picture_make(void) {
  picture_scene made;
  course_scene *scene = &made.triangles;
  memset(&made, 0, sizeof made);
  *scene = course_scene_empty();

  made.first[PICTURE_FLOOR] = scene->triangles;
  picture_quad(scene, vec_make(-9, 0, -9), vec_make(18, 0, 0), vec_make(0, 0, 16), vec_make(0, -1, 0));
  made.material[PICTURE_FLOOR].albedo = vec_make(0.72f, 0.68f, 0.6f);
  made.material[PICTURE_FLOOR].mirror = 0.12f;
  made.material[PICTURE_FLOOR].tiles = true;

  made.first[PICTURE_PANEL] = scene->triangles;
  picture_quad(
      scene, vec_make(-3.6f, 0.02f, -1.1f), vec_make(3, 0, -1.75f), vec_make(-0.1f, 2.9f, -0.2f), vec_make(-3, 1, -5));
  made.material[PICTURE_PANEL].mirror = 0.9f;

  made.first[PICTURE_CUBE] = scene->triangles;
  picture_cube(scene, vec_make(1.3f, 0.77f, 1.55f), 1.5f);
  made.material[PICTURE_CUBE].ior = 1.5f;

  made.first[PICTURE_GEM] = scene->triangles;
  picture_icosahedron(scene, vec_make(-1.45f, 1.02f, 1.5f), 1, false);
  made.material[PICTURE_GEM].ior = 1.5f;

  made.first[PICTURE_MATTE] = scene->triangles;
  picture_octahedron(scene, vec_make(-0.1f, 1.22f, -0.9f), 1);
  made.material[PICTURE_MATTE].albedo = vec_make(0.75f, 0.14f, 0.08f);

  made.first[PICTURE_BALL] = scene->triangles;
  picture_icosahedron(scene, vec_make(2.4f, 1.12f, -1.7f), 1.1f, true);
  made.material[PICTURE_BALL].mirror = 0.85f;

  made.first[PICTURE_PARTS] = scene->triangles;
  made.lamp = vec_make(4.5f, 8, 5);
  made.intensity = vec_make(260, 245, 220);
  made.ambient = vec_make(0.22f, 0.24f, 0.28f);
  return made;
}

/* Returns the radiance of the sky: pale at the horizon and below it, blue above. The direction has unit length. */
EX_UNUSED static vec picture_sky(vec direction) {
  const float up = fmaxf(0, direction.at[1]);
  return vec_make(0.66f - 0.5f * up, 0.78f - 0.46f * up, 0.9f - 0.2f * up);
}

/* Returns the part of the scene that a triangle is of. */
EX_UNUSED static uint32_t picture_part(const picture_scene *scene, uint32_t triangle) {
  uint32_t part = 0;
  while (triangle >= scene->first[part + 1]) part++;
  return part;
}

/* Returns the albedo of a point. */
EX_UNUSED static vec picture_albedo(const picture_material *material, vec point) {
  const int tile = (int)floorf(point.at[0]) + (int)floorf(point.at[2]);
  return material->tiles && tile % 2 != 0 ? vec_scale(material->albedo, 1.0f / 6) : material->albedo;
}

/* >>library -------------------------------------------------------------------------------------------------------- */

/* The tiles, as a texture of the library. */
EX_UNUSED static void picture_texture(void *user, const pktrt_points *points) {
  const picture_material *material = (const picture_material *)user;
  for (uint32_t i = 0; i < points->n; i++) {
    const vec albedo =
        picture_albedo(material, vec_make(points->position[0][i], points->position[1][i], points->position[2][i]));
    for (int c = 0; c < 3; c++) points->albedo[c][i] = albedo.at[c];
  }
}

/* The sky, as an environment of the library. */
EX_UNUSED static void picture_environment(
    void *user, uint32_t n, const float *const direction[3], float *const radiance[3]) {
  (void)user;
  for (uint32_t i = 0; i < n; i++) {
    const vec sky = picture_sky(vec_make(direction[0][i], direction[1][i], direction[2][i]));
    for (int c = 0; c < 3; c++) radiance[c][i] = sky.at[c];
  }
}

/* The same scene in the library, a mesh for each part. The caller destroys it before `scene` goes. */
EX_UNUSED static pktrt_scene *picture_library(picture_scene *scene) {
  pktrt_scene *library = pktrt_scene_create(NULL);
  pktrt_light light;
  memset(&light, 0, sizeof light);
  memcpy(light.position, scene->lamp.at, sizeof light.position);
  memcpy(light.intensity, scene->intensity.at, sizeof light.intensity);
  bool good = library && !pktrt_add_light(library, &light, NULL);

  for (uint32_t part = 0; good && part < PICTURE_PARTS; part++) {
    picture_material *mine = &scene->material[part];
    pktrt_material material;
    pktrt_mesh_desc mesh;
    memset(&material, 0, sizeof material);
    memset(&mesh, 0, sizeof mesh);
    memcpy(material.albedo, mine->albedo.at, sizeof material.albedo);
    if (mine->mirror > 0) material.specular = PKTRT_SPECULAR_MIRROR;
    if (mine->ior > 0) material.specular = PKTRT_SPECULAR_DIELECTRIC;
    if (mine->tiles) material.texture = picture_texture;
    material.user = mine;
    material.ior[0] = mine->ior;
    for (int c = 0; c < 3; c++) material.reflectance[c] = mine->mirror;

    mesh.positions = scene->triangles.position[0].at;
    mesh.vertex_count = scene->triangles.vertices;
    mesh.indices = scene->triangles.corner[scene->first[part]];
    mesh.triangle_count = scene->first[part + 1] - scene->first[part];
    good = !pktrt_add_material(library, &material, &mesh.material) && !pktrt_add_mesh(library, &mesh, NULL);
  }

  if (!good || pktrt_commit(library)) {
    ex_fail("%s", pktrt_last_error(library));
    exit(1);
  }
  return library;
}

/* Renders the scene by the library's Whitted mode, with one ray through the middle of each pixel. cutoff < 0: none. */
EX_UNUSED static void picture_render(const picture_scene *scene, pktrt_scene *library, course_picture *picture,
    float cutoff, uint32_t depth, pktrt_stats *stats) {
  const vec eye = {{2.7f, 4.1f, 7.3f}};
  const vec target = {{0.1f, 1.2f, -0.1f}};
  pktrt_render_desc desc;
  memset(&desc, 0, sizeof desc);
  desc.width = picture->width;
  desc.height = picture->height;
  desc.pixels = picture->pixel[0].at;
  desc.mode = PKTRT_MODE_WRT;
  desc.samples = 1;
  desc.camera.fov_y = 39.597752f; /* 2 atan 0.36, in degrees */
  desc.max_depth = depth;
  desc.attenuation = cutoff;
  desc.glass_shadows = PKTRT_GLASS_SHADOWS_BLOCK;
  desc.stats = stats;
  desc.environment = picture_environment;
  for (int a = 0; a < 3; a++) {
    desc.camera.eye[a] = eye.at[a];
    desc.camera.target[a] = target.at[a];
    desc.ambient[a] = scene->ambient.at[a];
  }
  if (pktrt_render(library, &desc)) {
    ex_fail("%s", pktrt_last_error(library));
    exit(1);
  }
}

#endif
