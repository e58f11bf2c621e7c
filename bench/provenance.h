/* provenance.h - where figures come from: the line that begins each CSV file of results, as in

     # version 0.6.0; machine Sapphire Rapids, AVX-512, 2 cores; date 2026-11-22; command build/paper table1

   The command comes last, for it may have a semicolon. bench/readme.awk prints the line under the tables of the file, and
   .ci/figures asks for it. Stands by itself, without the rest of bench.h, for the tests that keep figures. */
#ifndef PROVENANCE_H
#define PROVENANCE_H

#include "../pktrt.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

/* What /proc/cpuinfo says of the first processor, "" or 0 where it says nothing. */
typedef struct processor {
  char vendor[32], name[128], flags[8192];
  int family, model;
} processor;

static void read_processor(processor *p) {
  static char line[8192];
  memset(p, 0, sizeof *p);
  FILE *f = fopen("/proc/cpuinfo", "r");
  while (f && fgets(line, sizeof line, f) && line[0] != '\n') {
    char *value = strchr(line, ':');
    if (!value) continue;
    value += value[1] == ' ' ? 2 : 1;
    value[strcspn(value, "\n;")] = 0; /* a semicolon would end the machine */
    if (!strncmp(line, "vendor_id", 9)) snprintf(p->vendor, sizeof p->vendor, "%.31s", value);
    else if (!strncmp(line, "model name", 10)) snprintf(p->name, sizeof p->name, "%.127s", value);
    else if (!strncmp(line, "cpu family", 10)) p->family = atoi(value);
    else if (!strncmp(line, "model", 5)) p->model = atoi(value);
    else if (!strncmp(line, "flags", 5) || !strncmp(line, "Features", 8))
      snprintf(p->flags, sizeof p->flags, "%.8190s ", value);
  }
  if (f) fclose(f);
}

/* The class of a processor: rented machines hide the name of the model, but not its number. */
static const char *class_of(const processor *p) {
  static const struct {
    const char *vendor; /* a word of the name that tells vendors with the same numbers apart */
    int family, first, last;
    const char *name;
  } known[] = {{"Intel", 6, 0x55, 0x55, "Skylake or Cascade Lake"}, {"Intel", 6, 0x6a, 0x6c, "Ice Lake"},
      {"Intel", 6, 0x8f, 0x8f, "Sapphire Rapids"}, {"Intel", 6, 0xcf, 0xcf, "Emerald Rapids"},
      {"Intel", 6, 0xad, 0xae, "Granite Rapids"}, {"AMD", 23, 0x31, 0x31, "Zen 2"}, {"AMD", 25, 0x00, 0x0f, "Zen 3"},
      {"AMD", 25, 0x10, 0x1f, "Zen 4"}, {"AMD", 25, 0xa0, 0xaf, "Zen 4"}, {"AMD", 26, 0x00, 0x1f, "Zen 5"}};
  for (size_t i = 0; i < sizeof known / sizeof *known; i++)
    if (strstr(p->name, known[i].vendor) && p->family == known[i].family && p->model >= known[i].first &&
        p->model <= known[i].last)
      return known[i].name;
  return p->name[0] ? p->name : "unknown";
}

/* Whether the name of a processor tells which one it is, as most do by a number. */
static bool name_tells(const processor *p) { return strpbrk(p->name, "0123456789") || !p->family; }

/* What figures name a processor by: its class, or what it calls itself, with family and model where that tells nothing. */
static const char *short_name(const processor *p, char text[256]) {
  const char *class_name = class_of(p);
  if (class_name != p->name || name_tells(p)) snprintf(text, 256, "%s", class_name);
  else snprintf(text, 256, "%s (family %d model %d)", p->name, p->family, p->model);
  return text;
}

static const char *widest_vectors(const processor *p) {
  return strstr(p->flags, "avx512f ") ? "AVX-512"
         : strstr(p->flags, "avx2 ")  ? "AVX2"
         : strstr(p->flags, "sse2 ")  ? "SSE2"
         : strstr(p->flags, "asimd ") ? "NEON"
                                      : "no known vectors";
}

/* Returns the number of processors, 0 where nothing tells. */
static long count_cores(void) {
#ifdef _WIN32
  const char *number = getenv("NUMBER_OF_PROCESSORS");
  return number ? atol(number) : 0;
#else
  return sysconf(_SC_NPROCESSORS_ONLN);
#endif
}

static void write_provenance(FILE *to, const char *command) {
  static processor p;
  char date[32] = "unknown", name[256];
  const time_t now = time(NULL);
  const struct tm *today = localtime(&now);
  const long cores = count_cores();
  read_processor(&p);
  if (today) strftime(date, sizeof date, "%Y-%m-%d", today);
  fprintf(to, "# version %d.%d.%d; machine %s, %s, %ld core%s; date %s; command %s\n", PKTRT_VERSION / 10000,
      PKTRT_VERSION / 100 % 100, PKTRT_VERSION % 100, short_name(&p, name), widest_vectors(&p), cores,
      cores == 1 ? "" : "s", date, command);
}

/* A program's arguments as one line, as long as there is room. To be kept before getopt moves them. */
static void join_command(char *to, size_t room, int argc, char **argv) {
  size_t at = 0;
  to[0] = 0;
  for (int i = 0; i < argc && at + 1 < room; i++) {
    const int n = snprintf(to + at, room - at, strchr(argv[i], ' ') ? "%s\"%s\"" : "%s%s", i ? " " : "", argv[i]);
    if (n < 0) break;
    at += (size_t)n;
  }
  for (char *c = to; *c; c++)
    if (*c == '\n') *c = ' ';
}

#endif /* PROVENANCE_H */
