/* A fuzz target as libFuzzer calls it: compile with -DTARGET=fuzz_scene or another one. */
#include "fuzz.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  const char *wrong = TARGET(data, size, false);
  if (!wrong) return 0;
  fprintf(stderr, "%s\n", wrong);
  abort();
}
