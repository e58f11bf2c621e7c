/* .tri files of any bytes, by the reader of the examples: read, or refused in one line. */
#define _GNU_SOURCE
#include <stdio.h>
static FILE *said; /* what the examples say to standard error */
#undef stderr
#define stderr said
#include "../../examples/common.h"

#include "fuzz.h"

#define IMAGE_NO_STB /* the tests of pictures have it */
#include "../../examples/mesh_file.h"

static char path[64];

static void remove_file(void) { remove(path); }

static bool write_file(const uint8_t *data, size_t size) {
  if (!path[0]) {
    snprintf(path, sizeof path, "/tmp/pktrt-XXXXXX.tri");
    const int fd = mkstemps(path, 4);
    if (fd < 0) return false;
    close(fd);
    atexit(remove_file);
  }
  remove(path); /* to overwrite a file takes some file systems fifty times as long */
  FILE *to = fopen(path, "wb");
  const bool ok = to && fwrite(data, 1, size, to) == size;
  return to && fclose(to) == 0 && ok;
}

static bool good_file(const uint8_t *data, size_t size) {
  feed b = {data, size};
  const uint64_t count = take_u32(&b);
  if (size < 40 || size != 4 + 36 * count) return false;
  while (b.left) {
    const uint32_t bits = take_u32(&b);
    float x;
    memcpy(&x, &bits, sizeof x);
    if (!(fabsf(x) <= PKTRT_MAX_COORD)) return false;
  }
  return true;
}

static const char *look_at(pktrt_scene *s, size_t triangles, const char *line, bool ok) {
  pktrt_scene_info info;
  pktrt_ray r = ray_of(0.1f, 0.2f, 9, 0.01f, -0.02f, -1);
  pktrt_hit h;
  if (pktrt_commit(s) != PKTRT_OK) return "What was read cannot be committed.";
  pktrt_get_scene_info(s, &info);
  if (info.triangles != (ok ? triangles : 0)) return "Not all triangles were read, or some of a bad file.";
  const char *end = strchr(line, '\n');
  if (ok && line[0]) return "A good file is read and complained of.";
  if (!ok && (!end || end[1] || strncmp(line, "error: ", 7) != 0 || !strstr(line, path)))
    return "A refusal is not one line that names the file.";
  return fuzz_bad_hit(&r, &h, pktrt_intersect(s, &r, &h));
}

const char *fuzz_mesh_file(const uint8_t *data, size_t size, bool broken) {
  char line[2048];
  fuzz_memory memory;
  memset(line, 0, sizeof line);
  if (!write_file(data, size)) return NULL;
  said = fmemopen(line, sizeof line - 1, "w");
  if (!said) return NULL;
  const pktrt_scene_desc d = fuzz_scene_desc(&memory, PKTRT_ISA_AUTO, false);
  pktrt_scene *s = pktrt_scene_create(&d);
  const bool ok = s && mesh_file_load(s, path);
  fclose(said);
  const char *wrong = NULL;
  if (ok != (good_file(data, size) != broken)) wrong = "A bad file is read, or a good one is not.";
  else if (s) wrong = look_at(s, (size - 4) / 36, line, ok);
  pktrt_scene_destroy(s);
  return !wrong && memory.blocks ? "Memory is kept after destroy." : wrong;
}
