/* words.h - what values of the library's enumerations are called on a command line. Include pktrt.h first. */
#ifndef EXAMPLES_WORDS_H
#define EXAMPLES_WORDS_H

#include "common.h"

/* In the order of the enumerations; the last word is NULL: see ex_parse_word. */
static const char *const mode_words[] = {"rcs", "wrt", "drt", NULL};
static const char *const path_words[] = {"fast", "paper", "single", NULL};

static const char *const *sampler_words(void) { /* the library's own */
  static const char *words[PKTRT_SAMPLER_COUNT + 1];
  for (int i = 0; i < PKTRT_SAMPLER_COUNT; i++) words[i] = pktrt_sampler_string((pktrt_sampler)i);
  return words;
}

static void print_words(const char *before, const char *const *words) {
  printf("%s", before);
  for (int i = 0; words[i]; i++) printf(" %s", words[i]);
  printf("\n");
}

#endif /* EXAMPLES_WORDS_H */
