/* walk_events.c - tells the events of a packet's walk as text, to compare with what the page shows.

     cc -O2 examples/web/walk_events.c examples/web/web.c examples/web/web_file.c -o walk_events -lm
     ./walk_events [scene kind side x y spacing morton steps [shown width height time ex ey ez tx ty tz]]

   The numbers are those of walk_packet() and walk_trace(). Scene 2 is one of web_open(), whose number is `shown`, in a
   picture of so many pixels, with things where they are at `time`; then come eye and target, if not the scene's own. Each
   line is the words of an event, t by its bits. Then come the rays of the packets of figure 3, for each assembly. */
#define PKTRT_IMPLEMENTATION
#include "walk.c"

static void print_words(const uint32_t *list, uint32_t words) {
  for (uint32_t i = 0; i < list[0] * words; i++)
    printf("%u%c", (unsigned)list[1 + i], i % words + 1 < words ? ' ' : '\n');
}

int main(int argc, char **argv) {
  uint32_t n[8] = {0, 0, 8, 96, 32, 1, 0, 0};
  for (int i = 1; i < argc && i <= 8; i++) n[i - 1] = (uint32_t)strtoul(argv[i], NULL, 10);
  if (n[0] == WALK_SHOWN && argc > 12) {
    double camera[6];
    if (pktrt_isa_available(PKTRT_ISA_SCALAR)) web_use_isa(PKTRT_ISA_SCALAR);
    if (web_open((unsigned)strtoul(argv[9], NULL, 10), 1) || web_pose(strtod(argv[12], NULL), 0)) {
      printf("%s\n", web_error());
      return 1;
    }
    const float *const own = web_first_camera();
    for (int i = 0; i < 6; i++) camera[i] = argc > 18 ? strtod(argv[13 + i], NULL) : (double)own[i];
    web_camera(camera[0], camera[1], camera[2], camera[3], camera[4], camera[5], 0, 0);
    if (walk_show((uint32_t)strtoul(argv[10], NULL, 10), (uint32_t)strtoul(argv[11], NULL, 10))) return 1;
  }
  print_words(walk_packet(n[0], n[1], n[2], n[3], n[4], n[5], n[6]), sizeof(walk_ray) / 4);
  print_words(walk_trace(n[7]), sizeof(walk_event) / 4);
  for (uint32_t a = 0; a <= PKTRT_ASSEMBLY_NONE; a++) /* ray 1 is the last digit: `ddddffmm`, `ggmmgggg` */
    print_words(walk_figure(a, 022110000, 033332233), sizeof(walk_member) / 4);
  return 0;
}
