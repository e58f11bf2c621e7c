/* 04_range.h - chapter 4's drawing of events: which rays of a packet go on at each child. */
#ifndef RANGE_H
#define RANGE_H

#include "../svg.h"
#include "course.h"

enum { RANGE_ROW = 13, RANGE_TOP = 40, RANGE_LABEL = 135, RANGE_CELL = 5 }; /* pixels; a cell is the width of a ray */

/* Tells whether an event is a verdict on a child. */
static bool range_is_verdict(const pktrt_event *e) {
  return e->kind >= PKTRT_EVENT_FIRST_HIT && e->kind <= PKTRT_EVENT_ALL_MISS;
}

/* Returns how many rows the drawing of a log has. */
static uint32_t range_rows(const course_log *log) {
  uint32_t rows = 0;
  for (size_t i = 0; i < log->count; i++) rows += range_is_verdict(&log->event[i]);
  return rows;
}

/* Draws a row for each verdict: the child, the rays that enter or are dropped, and a dot for each hit. */
static void range_log(svg *s, double x, const char *title, const course_log *log, uint32_t rays) {
  static const char *const colour[] = {"", "#3a3", "#95d", "#9cf", "#e80", "#e55"};
  double y = RANGE_TOP;

  svg_text(s, x, 18, 14, SVG_LEFT, "%s", title);
  for (size_t i = 0; i < log->count; i++) {
    const pktrt_event *e = &log->event[i];
    if (!range_is_verdict(e)) continue;

    const bool entered = e->kind == PKTRT_EVENT_FIRST_HIT || e->kind == PKTRT_EVENT_LATER_HIT;
    const char *to = !entered ? "" : e[1].kind == PKTRT_EVENT_NODE ? ": node" : ": leaf";
    svg_text(s, x + 10 * (double)e->depth - 10, y, 11, SVG_LEFT, "place %u%s", (unsigned)e->child, to);
    svg_range(s, x + RANGE_LABEL, y - 9, RANGE_CELL * rays, 10, e->ray, e->ray + e->active - 1, rays, colour[e->kind]);

    /* The hits of a leaf follow the event that tells of the leaf. */
    for (size_t j = i + 2; entered && j < log->count && log->event[j].kind >= PKTRT_EVENT_HIT; j++)
      if (log->event[j].kind == PKTRT_EVENT_HIT)
        svg_dot(s, x + RANGE_LABEL + RANGE_CELL * (log->event[j].ray + 0.5), y - 4, 2.2, "#000");
    y += RANGE_ROW;
  }
}

/* Draws the log of the chapter's packet on the left and the log of the library's on the right. The longer log
   determines the height of the drawing. Returns false if the file cannot be written. */
EX_UNUSED static bool range_draw(const char *path, const course_log *mine, const course_log *theirs, uint32_t rays) {
  const uint32_t left = range_rows(mine), right = range_rows(theirs);
  const double column = RANGE_LABEL + RANGE_CELL * rays + 15;
  svg s;

  if (!svg_begin(&s, path, 15 + 2 * column, RANGE_TOP + RANGE_ROW * (left > right ? left : right))) return false;
  range_log(&s, 15, "first active ray alone, children from place 7 to 0", mine, rays);
  range_log(&s, 15 + column, "the library: all of its steps, children from near to far", theirs, rays);
  return svg_end(&s);
}

#endif /* RANGE_H */
