/* version.h - one version of pktrt that renders, behind calls that all versions share. It includes none of them. */
#ifndef ERROR_VERSION_H
#define ERROR_VERSION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { LIGHTS_ALL, LIGHTS_ONE_DEEPER, LIGHTS_ONE, LIGHTS }; /* as pktrt_light_choice numbers them */

typedef struct request { /* a scene, and what its pictures are judged by */
  const char *scene;     /* a built-in one, or "closed-NAME": one of closed.h */
  uint32_t width, height;
  uint32_t reference_samples; /* 0: no truth is wanted */
  int lights;                 /* of the runs; references take LIGHTS_ALL */
  bool adaptive; /* runs are in adaptive passes of a quarter of their samples; else all pixels get the same */
  bool shown;    /* errors are those of the picture as a screen shows it, and adaptive passes lower these if they can */
  const char *references; /* a directory of this version's own */
  unsigned threads;       /* for references */
} request;

typedef struct judged { /* a picture */
  double mse;     /* of a channel, in units of radiance or of white; the truth's own squared error is subtracted */
  double seconds; /* processor time of one thread: the least of several equal ones, where they are short */
} judged;

typedef struct version {
  const char *name;
  int number;                     /* its PKTRT_VERSION */
  void (*begin)(void);            /* once, before any version opens a scene: it finds the cores of the process */
  void *(*open)(const request *); /* a scene in DRT with its truth; ends the program if it cannot be */
  void (*close)(void *opened);
  judged (*take)(void *opened, uint32_t samples, uint32_t seed);
  const double *(*truth)(const void *opened, const double **doubt); /* doubt: squared error by pixel; NULL: exact */
} version;

extern const version version_before, version_now;

#endif /* ERROR_VERSION_H */
