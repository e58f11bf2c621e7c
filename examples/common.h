/* What several examples share and what is no ray tracing: arguments, time, threads (threads.h), a progress bar, picture
   files.

   Include this file first: it asks the system headers for POSIX and getopt_long. It is all static, so that every
   example stays one translation unit; some examples use only a part of it. C99 and C++11. */
#ifndef EXAMPLES_COMMON_H
#define EXAMPLES_COMMON_H

#ifndef _GNU_SOURCE
#define _GNU_SOURCE
#endif
#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#ifdef __has_include
#if !__has_include(<stb/stb_image_write.h>)
#error "stb_image_write.h is not installed: `make deps` installs it; `make deps-local` needs no root"
#endif
#endif
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

#include "../pktrt.h"
#include "threads.h"
#ifdef _WIN32 /* windows.h, which threads.h needs, defines these words as nothing */
#undef far
#undef near
#endif

#ifdef __GNUC__
#define EX_UNUSED __attribute__((unused))
#define EX_PRINTF(text, first) __attribute__((format(printf, text, first)))
#else
#define EX_UNUSED
#define EX_PRINTF(text, first)
#endif

/* An upper bound that keeps every size stb_image_write computes within an int: (3 * 16384 + 1) * 16384 < 2^31. */
#define EX_MAX_SIZE 16384u

/* >>errors --------------------------------------------------------------------------------------------------------- */

/* One line on standard error; control characters, which file names and texts of libraries may hold, become blanks. */
static void ex_say(const char *kind, char *line) {
  for (char *c = line; *c; c++)
    if ((unsigned char)*c < 32 || *c == 127) *c = ' ';
  fprintf(stderr, "%s: %s\n", kind, line);
}

/* Says what is wrong. Returns false, so that a failing function can end with `return ex_fail(...)`. */
EX_UNUSED EX_PRINTF(1, 2) static bool ex_fail(const char *format, ...) {
  char line[1024];
  va_list args;
  va_start(args, format);
  vsnprintf(line, sizeof line, format, args);
  va_end(args);
  ex_say("error", line);
  return false;
}

/* A `log` for pktrt_scene_desc: prints warnings, each once, for an animation would repeat those of its first frame. */
EX_UNUSED static void ex_log(void *user, int level, const char *sentence) {
  enum { KEPT = 16, LENGTH = 512 };
  static char told[KEPT][LENGTH];
  static unsigned count;
  char line[LENGTH];
  (void)user;
  if (level != 0) return;
  snprintf(line, sizeof line, "%s", sentence);
  for (unsigned i = 0; i < count && i < KEPT; i++)
    if (!strcmp(told[i], line)) return;
  memcpy(told[count++ % KEPT], line, sizeof line);
  ex_say("warning", line);
}

/* >>arguments ------------------------------------------------------------------------------------------------------ */

/* Each reads the value of the option --name and returns whether it is good; if not, it has said what would be. */

/* A decimal number, alone, within [lo, hi]; of an argument that is no option. */
EX_UNUSED static bool ex_parse_argument(
    const char *name, const char *text, unsigned long lo, unsigned long hi, unsigned *value) {
  char *end = NULL;
  errno = 0;
  unsigned long v = strtoul(text, &end, 10);
  if (text[0] < '0' || text[0] > '9' || *end || errno || v < lo || v > hi)
    return ex_fail("%s: \"%s\" is not a whole number from %lu to %lu", name, text, lo, hi);
  *value = (unsigned)v;
  return true;
}

/* The number that is a program's only argument, or what it is unless told. Ends the program if it is no good. */
EX_UNUSED static unsigned ex_only_argument(
    int argc, char **argv, const char *name, unsigned unless_told, unsigned long lo, unsigned long hi) {
  unsigned value = unless_told;
  if (argc > 2) ex_fail("%s: an argument too many: the only one is %s", argv[2], name);
  if (argc > 2 || (argc == 2 && !ex_parse_argument(name, argv[1], lo, hi, &value))) exit(1);
  return value;
}

EX_UNUSED static bool ex_parse_uint(
    const char *name, const char *text, unsigned long lo, unsigned long hi, unsigned *value) {
  char option[32];
  snprintf(option, sizeof option, "--%s", name);
  return ex_parse_argument(option, text, lo, hi, value);
}

/* A number, alone, within [lo, hi]; written this way round, NaN is in no range. */
EX_UNUSED static bool ex_parse_real(const char *name, const char *text, double lo, double hi, double *value) {
  static const char blanks[] = " \t\n\v\f\r"; /* strtod would skip them */
  char *end = NULL;
  double v = strtod(text, &end);
  if (end == text || strchr(blanks, text[0]) || *end || !(v >= lo && v <= hi))
    return ex_fail("--%s: \"%s\" is not a number from %g to %g", name, text, lo, hi);
  *value = v;
  return true;
}

EX_UNUSED static bool ex_parse_size(const char *text, unsigned *width, unsigned *height) {
  char first[16];
  const char *x = strchr(text, 'x');
  if (!x || (size_t)(x - text) >= sizeof first) return ex_fail("--size: \"%s\" is not of the form 1024x768", text);
  memcpy(first, text, (size_t)(x - text));
  first[x - text] = 0;
  return ex_parse_uint("size", first, 1, EX_MAX_SIZE, width) && ex_parse_uint("size", x + 1, 1, EX_MAX_SIZE, height);
}

/* The place of text in a list of words, which is also the value of the enumeration. */
EX_UNUSED static bool ex_parse_word(const char *name, const char *text, const char *const *words, int *value) {
  char all[256] = "";
  for (int i = 0; words[i]; i++) {
    if (!strcmp(text, words[i])) {
      *value = i;
      return true;
    }
    snprintf(all + strlen(all), sizeof all - strlen(all), "%s%s", i ? ", " : "", words[i]);
  }
  return ex_fail("--%s: \"%s\" is none of: %s", name, text, all);
}

/* >>time ----------------------------------------------------------------------------------------------------------- */

EX_UNUSED static double ex_seconds(void) {
  struct timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* >>progress ------------------------------------------------------------------------------------------------------- */

typedef struct ex_progress { /* the `user` of ex_progress_show */
  pthread_mutex_t lock;      /* tiles are finished by any thread */
  bool on;
  int shown; /* the last percentage drawn */
} ex_progress;

/* The bar is for people: it is drawn only where standard error is a terminal. */
EX_UNUSED static void ex_progress_start(ex_progress *p, bool wanted) {
  pthread_mutex_init(&p->lock, NULL);
  p->on = wanted && isatty(STDERR_FILENO);
  p->shown = -1;
}

EX_UNUSED static bool ex_progress_show(void *user, float done) {
  ex_progress *p = (ex_progress *)user;
  if (!p->on) return true;
  pthread_mutex_lock(&p->lock);
  int percent = (int)(100.0f * done);
  if (percent > p->shown) { /* later tiles may report earlier */
    static const char full[] = "##################################################";
    fprintf(stderr, "\r[%-50.*s] %3d%%", percent / 2, full, percent);
    p->shown = percent;
  }
  pthread_mutex_unlock(&p->lock);
  return true;
}

EX_UNUSED static void ex_progress_end(ex_progress *p) {
  if (p->on) fprintf(stderr, "\r%58s\r", "");
  pthread_mutex_destroy(&p->lock);
}

/* >>pictures ------------------------------------------------------------------------------------------------------- */

/* Linear value of an sRGB code in [0,1]: ((c + 0.055) / 1.055)^2.4 with a straight piece near black. x^2.4 is x^2
   (x^2)^(1/5), the root by Newton's method: plain arithmetic, so the same picture bytes come out with every C
   library, which pow() does not promise. x^2 is in [0.0056, 1] here and the start 1 above the root, whence
   convergence falls monotonically. */
EX_UNUSED static double ex_srgb_decode(double c) {
  if (c <= 0.04045) return c / 12.92;
  double x = (c + 0.055) / 1.055, a = x * x, root = 1.0;
  for (int i = 0; i < 40; i++) root = (4.0 * root + a / (root * root * root * root)) / 5.0;
  return a * root;
}

static void ex_write_bytes(void *user, void *data, int size) {
  FILE *file = (FILE *)user;
  if (size > 0) fwrite(data, 1, (size_t)size, file); /* errors stick to the stream; ex_write_channels asks for them */
}

/* Of PNGs that are written; zeroed, plain clamping. */
static pktrt_tone ex_tone;
static float ex_exposure;

static bool ex_write_png(FILE *file, const float *pixels, unsigned width, unsigned height) {
  size_t n = (size_t)width * height * 3;
  unsigned char *codes = (unsigned char *)malloc(n);
  if (!codes) return false;
  pktrt_to_srgb8(pixels, n / 3, ex_exposure, ex_tone, codes);
  int ok = stbi_write_png_to_func(ex_write_bytes, file, (int)width, (int)height, 3, codes, (int)width * 3);
  free(codes);
  return ok != 0;
}

/* Portable float map of one or three channels: the linear values themselves, rows from the bottom up; the sign of
   the scale tells the byte order. */
static bool ex_write_pfm(FILE *file, const float *pixels, unsigned width, unsigned height, unsigned channels) {
  const uint16_t one = 1;
  unsigned char little;
  size_t row = (size_t)width * channels;
  memcpy(&little, &one, 1);
  fprintf(file, "%s\n%u %u\n%s\n", channels == 3 ? "PF" : "Pf", width, height, little ? "-1.0" : "1.0");
  for (unsigned y = height; y > 0; y--) fwrite(pixels + (y - 1) * row, sizeof(float), row, file);
  return true;
}

EX_UNUSED static bool ex_has_suffix(const char *name, const char *suffix) {
  size_t n = strlen(name), m = strlen(suffix);
  if (n < m) return false;
  for (size_t i = 0; i < m; i++) {
    char c = name[n - m + i];
    if ((c >= 'A' && c <= 'Z' ? (char)(c + 32) : c) != suffix[i]) return false;
  }
  return true;
}

/* Writes linear values, row 0 at the top, and closes the file: three channels as .png (sRGB, 8 bit) or .pfm (linear
   floats), one as .pfm, by the name that it is called by. Says what went wrong. */
EX_UNUSED static bool ex_write_stream(
    FILE *file, const char *name, const float *pixels, unsigned width, unsigned height, unsigned channels) {
  errno = 0;
  bool ok = ex_has_suffix(name, ".pfm") ? ex_write_pfm(file, pixels, width, height, channels)
                                        : ex_write_png(file, pixels, width, height);
  ok = !ferror(file) && ok;
  int error = errno; /* fclose would overwrite it */
  if (fclose(file) != 0) {
    if (ok) error = errno;
    ok = false;
  }
  return ok || ex_fail("%s: could not be written: %s", name, error ? strerror(error) : "out of memory");
}

EX_UNUSED static bool ex_write_channels(
    const char *path, const float *pixels, unsigned width, unsigned height, unsigned channels) {
  FILE *file = fopen(path, "wb");
  if (!file) return ex_fail("%s: cannot be written: %s", path, strerror(errno));
  return ex_write_stream(file, path, pixels, width, height, channels);
}

/* Makes a folder, unless it is there. Where that fails, so does what follows, and says why. */
EX_UNUSED static void ex_make_folder(const char *path) {
#ifdef _WIN32
  mkdir(path);
#else
  mkdir(path, 0777);
#endif
}

/* Makes the folder out/ if the picture goes there. */
EX_UNUSED static bool ex_write_picture(const char *path, const float *pixels, unsigned width, unsigned height) {
  if (!strncmp(path, "out/", 4)) ex_make_folder("out");
  return ex_write_channels(path, pixels, width, height, 3);
}

#endif /* EXAMPLES_COMMON_H */
