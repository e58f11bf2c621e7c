/* 10_figures.h - the figures and plots of 10_sampler.c. */
#ifndef SAMPLER_FIGURES_H
#define SAMPLER_FIGURES_H

#include "course.h"
#include "../svg.h"

enum { SAMPLERS = PKTRT_SAMPLER_COUNT + 1, STEPS = 5 }; /* those of the library and ours; 1, 4, ... 256 samples */
enum { WIDTH = 48, HEIGHT = 36, PIXELS = WIDTH * HEIGHT, NOISE_WIDTH = 72, NOISE_HEIGHT = 54 };

/* Returns the name of a sampler. */
static const char *name_of(int sampler) {
  return sampler < PKTRT_SAMPLER_COUNT ? pktrt_sampler_string((pktrt_sampler)sampler) : "additive";
}

/* Returns the slope of the line through the logarithms of errors over those of samples: least squares, in steps of log 4. */
static double slope_of(const double error[STEPS]) {
  double sum = 0, weight = 0;
  for (int k = 1; k < STEPS; k++) { /* one sample lies at random for all: it is left out */
    const double at = k - 0.5 * STEPS;
    sum += at * log(error[k]);
    weight += at * at;
  }
  return sum / weight / log(4);
}

/* Prints the figure `name.samples`, or `name.samples.what`. */
static void figure(const char *name, uint32_t samples, const char *what, const char *format, double value) {
  char full_name[64];
  snprintf(full_name, sizeof full_name, "%s.%u%s%s", name, (unsigned)samples, *what ? "." : "", what);
  course_figure(full_name, format, value);
}

/* Plots errors over what they took, by factors of four from `least` on. passes NULL: there are none. */
static void plot(const char *path, const char *title, double least, double x[SAMPLERS][STEPS],
    double error[SAMPLERS][STEPS], const double *passes, const double *estimate) {
  static const char *const colors[SAMPLERS] = {"#d33", "#888", "#d90", "#393", "#27c", "#0aa", "#93c", "#000"};
  svg s;
  if (!svg_begin(&s, path, 580, 380)) exit(1);
#define PLOT_X(x) (60 + 80 * log2((x) / least) / 2)
#define PLOT_Y(e) (30.0 - 70.0 * log2((e) / 0.25) / 2)
  for (int k = 0; k < STEPS; k++) {
    const double at = 60 + 80 * k, y = 30 + 70 * k;
    svg_line(&s, at, 20, at, 350, "#ddd", 1);
    svg_line(&s, 60, y, 430, y, "#ddd", 1);
    svg_text(&s, at, 368, 12, SVG_MIDDLE, "%.3g", least * pow(4, k));
    svg_text(&s, 54, y + 4, 12, SVG_RIGHT, "%.4f", pow(0.25, k + 1));
  }
  for (int i = 0; i < SAMPLERS; i++) {
    for (int k = 1; k < STEPS; k++)
      svg_line(&s, PLOT_X(x[i][k - 1]), PLOT_Y(error[i][k - 1]), PLOT_X(x[i][k]), PLOT_Y(error[i][k]), colors[i], 1.5);
    svg_line(&s, 440, 40 + 18 * i, 460, 40 + 18 * i, colors[i], 1.5);
    svg_text(&s, 466, 44 + 18 * i, 12, SVG_LEFT, "%s", name_of(i));
  }
  for (int k = 1; passes && k < STEPS; k++) {
    svg_dot(&s, PLOT_X(x[0][k]), PLOT_Y(estimate[k]), 4, "#730");
    if (k > 1) svg_line(&s, PLOT_X(x[0][k - 1]), PLOT_Y(passes[k - 1]), PLOT_X(x[0][k]), PLOT_Y(passes[k]), "#730", 1);
  }
  svg_text(&s, 240, 14, 12, SVG_MIDDLE, "%s", title);
  if (!svg_end(&s)) exit(1);
}

#endif
