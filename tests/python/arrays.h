/* Arrays in files of the current directory, for the programs here that test.py compares Python with. */
#ifndef ARRAYS_H
#define ARRAYS_H

#include <stdio.h>
#include <stdlib.h>

static void fail(const char *what, const char *why) {
  fprintf(stderr, "tests/python: %s: %s\n", what, why);
  exit(1);
}

/* Returns the file's elements of `size` bytes, and their number in *count. */
static void *load(const char *name, size_t size, size_t *count) {
  FILE *file = fopen(name, "rb");
  if (!file || fseek(file, 0, SEEK_END)) fail(name, "cannot be read");
  const long bytes = ftell(file);
  void *to = malloc((size_t)bytes + 1);
  rewind(file);
  if (!to || fread(to, 1, (size_t)bytes, file) != (size_t)bytes) fail(name, "cannot be read to its end");
  fclose(file);
  *count = (size_t)bytes / size;
  return to;
}

static void save(const char *name, const void *from, size_t bytes) {
  FILE *file = fopen(name, "wb");
  if (!file || fwrite(from, 1, bytes, file) != bytes || fclose(file)) fail(name, "cannot be written");
}

#endif /* ARRAYS_H */
