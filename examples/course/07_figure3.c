/* 07_figure3.c - figure 3 of the paper: sixteen rays, what they send out, and the packets that this makes.

   Prints the packets of each assembly as section 3.2.1 lists them, and draws out/course/07_figure3.svg: a panel for each
   assembly, a colour for each packet. */
#define PKTRT_IMPLEMENTATION
#include "07_figure3.h"
#include "../svg.h"

/* [assemblies] */
static const struct assembly {
  pktrt_assembly assembly;
  const char *name;
} assemblies[] = {
    {PKTRT_ASSEMBLY_NONE, "no packets"},
    {PKTRT_ASSEMBLY_RUNS, "runs"},
    {PKTRT_ASSEMBLY_MATERIALS, "groups"},
    {PKTRT_ASSEMBLY_RAY_TYPES, "ray types"},
    {PKTRT_ASSEMBLY_OCTANTS, "octants"},
    {PKTRT_ASSEMBLY_BLIND, "blind"},
};
/* [end] */
enum { ASSEMBLIES = sizeof assemblies / sizeof assemblies[0] };

/* The number of the packet that holds the ray which primary ray i sent out, of a type. */
static uint32_t packet_of(const figure_log *log, pktrt_ray_type type, uint32_t i) {
  for (uint32_t k = 0; k < log->count; k++)
    for (uint32_t r = 0; r < log->packet[k].n; r++)
      if ((log->packet[k].type == type || log->packet[k].type == PKTRT_RAY_OTHER) && log->packet[k].ray[r] == i)
        return k;
  return PKTRT_NONE;
}

/* Draws a short secondary ray in the colour of its packet: nine hues a ninth of the circle apart, then those between. */
static void draw_secondary(
    svg *s, const figure_log *log, pktrt_ray_type type, uint32_t i, double x, double y, double dx, double dy) {
  char colour[64];
  const uint32_t packet = packet_of(log, type, i);
  if (packet == PKTRT_NONE || !figure_sends(FIGURE_MET[i], type)) return;
  snprintf(colour, sizeof colour, "hsl(%u,75%%,%d%%)", (unsigned)(packet * 5 % 9 * 40 + packet / 9 * 13),
      packet % 2 ? 38 : 50);
  const double l = (type == PKTRT_RAY_SHADOW ? 46 : 34) / hypot(dx, dy);
  svg_ray(s, x, y, x + l * dx, y + l * dy, colour, 2);
  if (type == PKTRT_RAY_SHADOW) svg_dot(s, x + l * dx, y + l * dy, 3, colour);
}

/* A panel as figure 3 is drawn: rays fan out from the eye and meet things side by side. */
static void draw_panel(svg *s, double left, double top, const char *name, const figure_log *log) {
  static const char *const fill[] = {"#ccc", "#da8", "#99a", "#bde"};
  const double eye[2] = {left + 20, top + 24}, light[2] = {left + 110, top + 24}, y = top + 120;
  svg_text(s, left + 400, top + 30, 14, SVG_RIGHT, "%s: %u packet%s", name, (unsigned)log->count,
      log->count == 1 ? "" : "s");
  svg_dot(s, eye[0], eye[1], 4, "#000");
  svg_dot(s, light[0], light[1], 5, "#fb0");
  for (uint32_t i = 0; i < FIGURE_RAYS; i++) {
    const double x = left + 32 + 24 * i;
    svg_box(s, x - 12, y, x + 12, y + 10, fill[strchr("dfmg", FIGURE_MET[i]) - "dfmg"], NULL);
    svg_line(s, eye[0], eye[1], x, y, "#ddd", 1);
    svg_text(s, x, y + 9, 9, SVG_MIDDLE, "%u", (unsigned)i + 1);
  }
  for (uint32_t i = 0; i < FIGURE_RAYS; i++) {
    const double x = left + 32 + 24 * i, dx = x - eye[0], dy = y - eye[1];
    draw_secondary(s, log, PKTRT_RAY_SHADOW, i, x, y, light[0] - x, light[1] - y);
    draw_secondary(s, log, PKTRT_RAY_REFLECTION, i, x, y, dx, -dy);
    draw_secondary(s, log, PKTRT_RAY_REFRACTION, i, x, y + 10, 0.6 * dx, dy);
  }
}

/* Prints how many rays of each type the sixteen rays send out, and how many packets each assembly makes. */
static void print_figures(const uint32_t packets[ASSEMBLIES]) {
  static const char *const types[PKTRT_RAY_TYPE_COUNT] = {"primary", "shadow", "reflected", "refracted", "other"};
  static const char *const names[ASSEMBLIES] = {"none", "runs", "groups", "types", "octants", "blind"};
  uint32_t all = 0;
  for (int type = PKTRT_RAY_SHADOW; type <= PKTRT_RAY_REFRACTION; type++) {
    uint32_t rays = 0;
    for (uint32_t i = 0; i < FIGURE_RAYS; i++) rays += figure_sends(FIGURE_MET[i], (pktrt_ray_type)type) ? 1 : 0;
    course_figure(types[type], "%u", (unsigned)rays);
    all += rays;
  }
  course_figure("rays", "%u", (unsigned)all);
  for (int k = 0; k < ASSEMBLIES; k++) course_figure(names[k], "%u", (unsigned)packets[k]);
}

int main(void) {
  static figure_log log;
  uint32_t packets[ASSEMBLIES];
  uint32_t place[FIGURE_RAYS];
  char text[1024];
  svg s;
  course_make_folder();
  if (!svg_begin(&s, "out/course/07_figure3.svg", 860, 535)) return 1;
  figure_places(place);
  printf("rays 1 to 16 by pixel:\n");
  for (uint32_t pixel = 0; pixel < FIGURE_RAYS; pixel++)
    for (unsigned i = 0; i < FIGURE_RAYS; i++)
      if (place[i] == pixel) printf("%4u%s", i + 1, pixel % 4 == 3 ? "\n" : "");
  /* [main] */
  for (int k = 0; k < ASSEMBLIES; k++) {
    figure_trace(FIGURE_MET, place, assemblies[k].assembly, &log);
    packets[k] = log.count;
    uint32_t rays = 0;
    for (uint32_t i = 0; i < log.count; i++) rays += log.packet[i].n;
    printf("\n%s, %u rays in %u packet%s:\n  %s\n", assemblies[k].name, (unsigned)rays, (unsigned)log.count,
        log.count == 1 ? "" : "s", figure_text(log.packet, log.count, text));
    draw_panel(&s, k % 2 * 430, k / 2 * 180, assemblies[k].name, &log);
  }
  /* [end] */
  print_figures(packets);
  return !svg_end(&s);
}
