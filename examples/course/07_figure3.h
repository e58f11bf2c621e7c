/* 07_figure3.h - what program, exercise and check of chapter 7 share: sixteen rays, what they met, and packets. */
#ifndef FIGURE3_H
#define FIGURE3_H

#include "course.h"

enum { FIGURE_RAYS = 16, FIGURE_PACKETS = 3 * FIGURE_RAYS };

/* What rays 1 to 16 of the paper's figure meet: d diffuse, f the floor (diffuse and a mirror), m metal, g glass. Elsewhere
   also . for nothing. */
#define FIGURE_MET "ddddffmmggmmgggg"

typedef struct figure_packet {
  pktrt_ray_type type;             /* PKTRT_RAY_OTHER: of all types */
  uint32_t n, ray[FIGURE_PACKETS]; /* the primary rays that sent them out, counted from 0 on, ascending */
} figure_packet;

/* The exercise: both put the secondary rays of one type into packets and return how many packets there are. A ray that
   meets met[i] sends out what figure_sends() says. `type` need not be set. */
uint32_t figure_runs(const char met[FIGURE_RAYS], pktrt_ray_type type, figure_packet *packet);
uint32_t figure_groups(const char met[FIGURE_RAYS], pktrt_ray_type type, figure_packet *packet);

/* [sends] */
/* Tells whether a ray that meets this sends out a ray of a type. */
EX_UNUSED static bool figure_sends(char met, pktrt_ray_type type) {
  return type == PKTRT_RAY_SHADOW       ? met == 'd' || met == 'f'
         : type == PKTRT_RAY_REFLECTION ? met == 'f' || met == 'm' || met == 'g'
                                        : met == 'g'; /* refraction */
}
/* [end] */

/* [log] */
typedef struct figure_log {
  uint32_t count, place[FIGURE_RAYS]; /* place[i]: 4 y + x of the pixel that primary ray i goes through */
  figure_packet packet[FIGURE_PACKETS];
} figure_log;

/* Called by the library for each packet before it is traced. */
EX_UNUSED static void figure_log_packet(void *user, const pktrt_packet *p) {
  figure_log *log = (figure_log *)user;
  for (uint32_t i = 0; p->depth == 0 && i < p->n; i++) log->place[p->rays[i]] = 4 * p->y[i] + p->x[i];
  if (p->depth != 1 || log->count == FIGURE_PACKETS) return;
  figure_packet *to = &log->packet[log->count++];
  to->type = p->type, to->n = p->n;
  memcpy(to->ray, p->rays, p->n * sizeof *p->rays);
}
/* [end] */

/* Sixteen squares before the camera fill a picture of 4 x 4 pixels; ray i meets met[i]. */
EX_UNUSED static void figure_trace(
    const char *met, const uint32_t place[FIGURE_RAYS], pktrt_assembly assembly, figure_log *log) {
  static const char letters[] = "dfmg";
  static const uint32_t corners[6] = {0, 1, 2, 0, 2, 3};
  static float pixels[FIGURE_RAYS * 3];
  pktrt_material material[4];
  pktrt_light light;
  pktrt_mesh_desc mesh;
  pktrt_render_desc d;
  uint32_t index[4];
  pktrt_scene *s = pktrt_scene_create(NULL);
  memset(material, 0, sizeof material), memset(&light, 0, sizeof light), memset(&mesh, 0, sizeof mesh);
  memset(&d, 0, sizeof d), memset(log, 0, sizeof *log);
  d.samples = 1;
  material[1].specular = PKTRT_SPECULAR_MIRROR, material[2].specular = PKTRT_SPECULAR_CONDUCTOR;
  material[3].specular = PKTRT_SPECULAR_DIELECTRIC;
  for (int c = 0; c < 3; c++) {
    material[0].albedo[c] = 0.8f, material[1].albedo[c] = 0.5f, material[1].reflectance[c] = 0.4f;
    material[2].ior[c] = 1.4f, material[2].extinction[c] = 3, light.intensity[c] = 100;
  }
  bool good = s != NULL;
  for (int i = 0; i < 4 && good; i++) good = !pktrt_add_material(s, &material[i], &index[i]);
  mesh.vertex_count = 4, mesh.indices = corners, mesh.triangle_count = 2;
  for (uint32_t i = 0; i < FIGURE_RAYS && good; i++) {
    const float x = (float)(place[i] % 4) - 1.5f, y = 1.5f - (float)(place[i] / 4), h = 0.45f;
    const float square[12] = {x - h, y - h, 0, x + h, y - h, 0, x + h, y + h, 0, x - h, y + h, 0};
    if (met[i] == '.') continue;
    mesh.positions = square, mesh.material = index[strchr(letters, met[i]) - letters];
    good = !pktrt_add_mesh(s, &mesh, NULL);
  }
  light.position[2] = 10;
  d.width = d.height = 4, d.pixels = pixels, d.mode = PKTRT_MODE_WRT;
  d.camera.eye[2] = 5, d.camera.fov_y = 43.6f; /* four units high where the squares are */
  d.path = PKTRT_PATH_PAPER, d.packet_size = 4, d.assembly = assembly;
  d.packet = figure_log_packet, d.user = log;
  if (!good || pktrt_add_light(s, &light, NULL) || pktrt_commit(s) || pktrt_render(s, &d))
    ex_fail("%s", pktrt_last_error(s)), exit(1);
  pktrt_scene_destroy(s);
}

/* Asks the library which pixel each ray of a packet of 4 x 4 goes through. */
EX_UNUSED static void figure_places(uint32_t place[FIGURE_RAYS]) {
  static const uint32_t rows[FIGURE_RAYS] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
  figure_log log;
  figure_trace(FIGURE_MET, rows, PKTRT_ASSEMBLY_RAY_TYPES, &log);
  memcpy(place, log.place, sizeof log.place);
}

/* Writes packets as the paper does, by type and first ray: "shadow (1,2,3,4) (5,6); reflection (5,6) ...". Sorts them. */
EX_UNUSED static const char *figure_text(figure_packet *p, uint32_t count, char text[1024]) {
  static const char *const names[PKTRT_RAY_TYPE_COUNT] = {"primary", "shadow", "reflection", "refraction", "all types"};
  size_t at = 0;
  text[0] = 0;
  for (uint32_t i = 1; i < count; i++)
    for (uint32_t j = i; j > 0; j--) {
      const figure_packet later = p[j];
      if (p[j - 1].type < later.type || (p[j - 1].type == later.type && p[j - 1].ray[0] <= later.ray[0])) break;
      p[j] = p[j - 1], p[j - 1] = later;
    }
  for (uint32_t i = 0; i < count; i++) {
    const bool begins = i == 0 || p[i].type != p[i - 1].type;
    if (begins) at += (size_t)snprintf(text + at, 1024 - at, "%s%s", i ? "; " : "", names[p[i].type]);
    for (uint32_t k = 0; k < p[i].n && at < 1000; k++)
      at += (size_t)snprintf(text + at, 1024 - at, "%s%u", k ? "," : " (", (unsigned)p[i].ray[k] + 1);
    if (at < 1000) at += (size_t)snprintf(text + at, 1024 - at, ")");
  }
  return text;
}

#endif
