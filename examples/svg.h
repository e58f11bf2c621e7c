/* svg.h - drawings as SVG: boxes, lines, rays, bars of ranges, text. Units are pixels, y points down.

     svg s;
     if (!svg_begin(&s, "out/tree.svg", 640, 480)) ...       says what went wrong
     svg_box(&s, 10, 10, 50, 30, "#fdd", "#a00");            colours as SVG has them; NULL: none
     svg_text(&s, 15, 25, 12, SVG_LEFT, "node %u", n);
     if (!svg_end(&s)) ...                                   the file is closed in any case

   Include this file early, since common.h, which it includes, asks the system headers for POSIX. */
#ifndef SVG_H
#define SVG_H

#include "common.h"

typedef struct svg {
  FILE *file;
  const char *path; /* must live as long as the drawing */
} svg;

enum { SVG_LEFT, SVG_MIDDLE, SVG_RIGHT }; /* the end of a text that stands at its x */

EX_UNUSED static bool svg_begin(svg *s, const char *path, double width, double height) {
  s->path = path;
  s->file = fopen(path, "wb");
  if (!s->file) return ex_fail("%s: cannot be written: %s", path, strerror(errno));
  fprintf(s->file, "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"%g\" height=\"%g\" viewBox=\"0 0 %g %g\" ", width,
      height, width, height);
  fprintf(s->file, "font-family=\"sans-serif\">\n<rect width=\"100%%\" height=\"100%%\" fill=\"#fff\"/>\n");
  return true;
}

EX_UNUSED static bool svg_end(svg *s) {
  fprintf(s->file, "</svg>\n");
  const bool good = !ferror(s->file), closed = fclose(s->file) == 0;
  s->file = NULL;
  return (good && closed) || ex_fail("%s: could not be written", s->path);
}

/* Corners in any order. */
EX_UNUSED static void svg_box(svg *s, double x0, double y0, double x1, double y1, const char *fill, const char *line) {
  fprintf(s->file, "<rect x=\"%.4g\" y=\"%.4g\" width=\"%.4g\" height=\"%.4g\" fill=\"%s\" stroke=\"%s\"/>\n",
      fmin(x0, x1), fmin(y0, y1), fabs(x1 - x0), fabs(y1 - y0), fill ? fill : "none", line ? line : "none");
}

EX_UNUSED static void svg_line(svg *s, double x0, double y0, double x1, double y1, const char *colour, double width) {
  fprintf(
      s->file, "<path d=\"M%.4g %.4gL%.4g %.4g\" stroke=\"%s\" stroke-width=\"%g\"/>\n", x0, y0, x1, y1, colour, width);
}

EX_UNUSED static void svg_dot(svg *s, double x, double y, double radius, const char *colour) {
  fprintf(s->file, "<circle cx=\"%.4g\" cy=\"%.4g\" r=\"%g\" fill=\"%s\"/>\n", x, y, radius, colour);
}

/* A line with a head at its end: two strokes, each turned from the way back by half a right angle and less. */
EX_UNUSED static void svg_ray(svg *s, double x0, double y0, double x1, double y1, const char *colour, double width) {
  const double l = hypot(x1 - x0, y1 - y0), k = l > 0 ? (2 + 3 * width) / l : 0, x = k * (x0 - x1), y = k * (y0 - y1);
  svg_line(s, x0, y0, x1, y1, colour, width);
  svg_line(s, x1, y1, x1 + x - 0.5 * y, y1 + y + 0.5 * x, colour, width);
  svg_line(s, x1, y1, x1 + x + 0.5 * y, y1 + y - 0.5 * x, colour, width);
}

/* A bar of n cells in a frame; those from first to last, both included, are filled. first > last: none. */
EX_UNUSED static void svg_range(svg *s, double x, double y, double width, double height, unsigned first, unsigned last,
    unsigned n, const char *colour) {
  const double cell = width / n;
  if (first <= last) svg_box(s, x + cell * first, y, x + cell * (last + 1), y + height, colour, NULL);
  svg_box(s, x, y, x + width, y + height, NULL, "#888");
}

/* The base line at y; what SVG would take for its own is escaped. */
EX_UNUSED EX_PRINTF(6, 7) static void svg_text(
    svg *s, double x, double y, double size, int anchor, const char *format, ...) {
  static const char *const anchors[] = {"start", "middle", "end"};
  char text[512];
  va_list args;
  va_start(args, format);
  vsnprintf(text, sizeof text, format, args);
  va_end(args);
  fprintf(s->file, "<text x=\"%.4g\" y=\"%.4g\" font-size=\"%g\" text-anchor=\"%s\">", x, y, size, anchors[anchor]);
  for (const char *c = text; *c; c++)
    if (*c == '<' || *c == '&') fputs(*c == '<' ? "&lt;" : "&amp;", s->file);
    else fputc(*c, s->file);
  fprintf(s->file, "</text>\n");
}

#endif /* SVG_H */
