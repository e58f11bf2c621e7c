/* 05_boxes.h - chapter 5's drawing of a packet and the boxes of the children that the packet visits. */
#ifndef BOXES_H
#define BOXES_H

#include "course.h"
#include "section.h"

/* Draws one packet and the boxes of the children that it visits, coloured by verdict, from the side and from above. The
   boxes that planes drop and the packet are drawn last, with thick lines. The packet has n <= 256 rays with one origin.
   The program ends if the file cannot be written. */
EX_UNUSED static void boxes_draw(
    const char *path, const pktrt_scene *library, const pktrt_node *nodes, const course_ray *rays, uint32_t n) {
  static const char *const fill[] = {"", "#3a32", "#98c2", "#29d3", "#e802", "#d332"};
  static const char *const line[] = {"", "#3a3", "#98c", "#29d", "#e80", "#d33"};
  svg drawing;
  course_log log = {NULL, 0, 0};
  course_hit hit[256];
  course_make_folder();
  course_library_packet(
      library, rays, n, PKTRT_PAPER_STEP_INTERVALS | PKTRT_PAPER_STEP_FRUSTUM | PKTRT_PAPER_STEP_ORDER, hit, &log);
  if (!svg_begin(&drawing, path, 960, 660)) exit(1);
  for (int above = 0; above < 2; above++) {
    const section s =
        section_begin(&drawing, !above, 7.6, above ? -1 : -0.7, 59, 0, above ? 316 : 0, 960, above ? 344 : 304);
    const float *eye = rays[0].origin.at;
    for (int thick = 0; thick < 2; thick++) {
      fprintf(drawing.file, "<g stroke-width=\"%g\">\n", thick ? 2.5 : 0.7);
      for (size_t j = 0; j < log.count; j++) {
        const pktrt_event *e = &log.event[j];
        if (e->kind == PKTRT_EVENT_NODE || e->kind > PKTRT_EVENT_ALL_MISS) continue;
        if ((e->kind == PKTRT_EVENT_FRUSTUM_CULL) != thick) continue;
        section_box(&s, nodes[e->index].lo[e->child], nodes[e->index].hi[e->child], fill[e->kind], line[e->kind]);
      }
      fprintf(drawing.file, "</g>\n");
    }
    for (uint32_t r = 0; r < n; r++) section_ray(&s, rays[r], fminf(hit[r].t, 20), "#555", 1.2);
    svg_dot(&drawing, section_u(&s, eye), section_v(&s, eye), 5, "#000");
    svg_text(&drawing, section_u(&s, eye) + 8, section_v(&s, eye) + 20, 16, SVG_LEFT, "eye");
    svg_text(&drawing, 950, 20, 16, SVG_RIGHT, above ? "from above" : "from the side");
    section_end(&s);
  }
  if (!svg_end(&drawing)) exit(1);
}

#endif /* BOXES_H */
