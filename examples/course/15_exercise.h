/* 15_exercise.h - what the exercise of chapter 15 is given, and what it gives. */
#ifndef COURSE_15_EXERCISE_H
#define COURSE_15_EXERCISE_H

#include "course.h"

/* What a packet's walk took. */
typedef struct account {
  uint64_t nodes;       /* opened */
  uint64_t culled;      /* children dropped by intervals or by the frustum */
  uint64_t box_vectors; /* tests of a group of eight rays against a box */
  uint64_t boxes;       /* the active rays in these tests */
} account;

/* A speed-up and its factors: speedup = lanes * fewer * rest. */
typedef struct account_split {
  double speedup; /* cost of all single rays over cost of all packets */
  double lanes;   /* box tests over box vectors, of all packets */
  double fewer;   /* box tests of all single rays over those of all packets */
  double rest;    /* what box tests do not explain */
} account_split;

/* Yours. */
account account_of(const pktrt_event *event, size_t events, uint32_t rays, bool shadow);
account_split account_predict(const account *alone, const account *packet, size_t packets, double node_cost);

#endif /* COURSE_15_EXERCISE_H */
