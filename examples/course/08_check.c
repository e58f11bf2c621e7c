/* 08_check.c - checks the exercise of chapter 8: traces the student's packets, and compares hits and vector tests. */
#define PKTRT_IMPLEMENTATION
#include "08_reflect.h"

enum { MOST = 1 << 16 };

/* The rays of one depth, and packets of them; a packet for each 256 of them is the paper's BLIND. */
static reflect_ray rays[MOST];
static uint32_t order[MOST], end[MOST];
static pktrt_hit hits[MOST], expected[MOST];

/* Bits of x and y by turns. */
static uint32_t morton(const reflect_ray *r) {
  uint32_t m = 0;
  for (int bit = 0; bit < 16; bit++) m |= (r->x >> bit & 1) << 2 * bit | (r->y >> bit & 1) << (2 * bit + 1);
  return m;
}

static int by_pixel(const void *a, const void *b) {
  const reflect_ray *x = (const reflect_ray *)a, *y = (const reflect_ray *)b;
  const uint32_t mx = morton(x), my = morton(y);
  return mx != my ? (mx < my ? -1 : 1) : memcmp(x, y, sizeof *x);
}

/* Fetches the rays of one depth; order and end become the library's packets of them. Returns how many rays there are. */
static uint32_t fetch(const reflect_log *log, uint32_t depth, uint32_t *packets) {
  uint32_t n = 0;
  *packets = 0;
  for (uint32_t k = 0, begin = 0; k < log->packets; begin = log->end[k++]) {
    if (log->ray[begin].depth != depth) continue;
    for (uint32_t i = begin; i < log->end[k] && n < MOST; i++) order[n] = n, rays[n++] = log->ray[i];
    end[(*packets)++] = n;
  }
  return n;
}

/* Tells whether the student's packets hold each ray once; says what is wrong. */
static bool whole(uint32_t n, uint32_t packets) {
  static uint8_t seen[MOST];
  memset(seen, 0, sizeof seen);
  if (packets == 0 || packets > n) return printf("  %u packets of %u rays\n", (unsigned)packets, (unsigned)n), false;
  for (uint32_t k = 0, begin = 0; k < packets; begin = end[k++])
    if (end[k] <= begin || end[k] - begin > 256 || end[k] > n)
      return printf("  packet %u is from %u to %u, of %u rays\n", (unsigned)k, (unsigned)begin, (unsigned)end[k],
                 (unsigned)n),
             false;
  if (end[packets - 1] != n)
    return printf("  the last packet ends at %u, not %u\n", (unsigned)end[packets - 1], (unsigned)n), false;
  for (uint32_t i = 0; i < n; i++)
    if (order[i] >= n || seen[order[i]]++)
      return printf("  order[%u] is %u, %s\n", (unsigned)i, (unsigned)order[i],
                 order[i] >= n ? "which is no ray" : "for the second time"),
             false;
  return true;
}

/* Cuts the order of n rays into packets of `size` rays, the last one perhaps smaller; returns how many there are. */
static uint32_t cut(uint32_t n, uint32_t size) {
  uint32_t packets = 0;
  for (uint32_t begin = 0; begin < n; begin += size) end[packets++] = begin + size < n ? begin + size : n;
  return packets;
}

/* Traces the student's packets of each bounce. Returns NULL if they pass, or why they do not. */
static const char *check(const pktrt_scene *s, const reflect_log *log) {
  double all = 0, library = 0, blind = 0, mine = 0;
  double twelve = 0, sixteen = 0;
  for (uint32_t depth = 1; depth <= REFLECT_DEPTH; depth++) {
    uint32_t packets, n = fetch(log, depth, &packets);
    if (n == 0) continue;
    library += (double)reflect_trace(s, rays, order, end, packets, hits);
    qsort(rays, n, sizeof *rays, by_pixel);
    packets = cut(n, 256);
    blind += (double)reflect_trace(s, rays, order, end, packets, expected);
    for (uint32_t i = 0; i < n; i++) {
      const pktrt_ray ray = pktrt_make_ray(rays[i].origin, rays[i].direction);
      pktrt_intersect(s, &ray, &expected[i]);
    }
    memset(order, 0, sizeof order), memset(end, 0, sizeof end);
    packets = reflect_assemble(rays, n, order, end);
    printf("bounce %u: %u rays in %u packets\n", (unsigned)depth, (unsigned)n, (unsigned)packets);
    if (!whole(n, packets)) return "the packets do not hold each ray once, 1 to 256 in each";
    mine += (double)reflect_trace(s, rays, order, end, packets, hits);
    if (memcmp(hits, expected, n * sizeof *hits)) return "hits are not those of single rays";
    all += n;

    /* For the text: the same order cut into packets of 12 and of 16 rays. */
    packets = cut(n, 12);
    twelve += (double)reflect_trace(s, rays, order, end, packets, hits);
    packets = cut(n, 16);
    sixteen += (double)reflect_trace(s, rays, order, end, packets, hits);
  }
  printf("Each ray is in one packet, and hits what it hits alone.\n");
  const double most = REFLECT_SHARE * library;
  printf("Vector tests per ray: blind, by 256: %.2f; ray types as the library has them: %.2f; yours: %.2f "
         "(at most %.2f).\n",
      blind / all, library / all, mine / all, most / all);
  course_figure("blind", "%.2f", blind / all);
  course_figure("types", "%.2f", library / all);
  course_figure("most", "%.2f", most / all);
  course_figure("mine", "%.2f", mine / all);
  course_figure("by12", "%.2f", twelve / all);
  course_figure("by16", "%.2f", sixteen / all);

  if (mine >= blind) return "blind packets need no more";
  if (mine > library) return "the library's ray types need fewer";
  if (mine > most) return "that is not a sixth fewer than the library's ray types need";
  return NULL;
}

int main(void) {
  static float pixels[REFLECT_SIZE * REFLECT_SIZE * 3];
  pktrt_scene *s = reflect_scene();
  reflect_log log = reflect_log_make();
  pktrt_render_desc d = reflect_view(pixels);
  d.packet = reflect_log_packet, d.user = &log;
  if (pktrt_render(s, &d)) return ex_fail("%s", pktrt_last_error(s)), 1;
  const char *why = check(s, &log);
  reflect_log_free(&log);
  pktrt_scene_destroy(s);
  return course_result(8, why);
}
