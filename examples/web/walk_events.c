/* walk_events.c - tells the events of a packet's walk as text, to compare with what the page shows.

     cc -O2 examples/web/walk_events.c -o walk_events -lm
     ./walk_events [scene kind side x y spacing morton steps]

   The numbers are those of walk_packet() and walk_trace(). Each line is the words of an event, t by its bits. Then come
   the rays of the packets of figure 3, for each assembly. */
#define PKTRT_IMPLEMENTATION
#include "walk.c"

static void print_words(const uint32_t *list, uint32_t words) {
  for (uint32_t i = 0; i < list[0] * words; i++)
    printf("%u%c", (unsigned)list[1 + i], i % words + 1 < words ? ' ' : '\n');
}

int main(int argc, char **argv) {
  uint32_t n[8] = {0, 0, 8, 96, 32, 1, 0, 0};
  for (int i = 1; i < argc && i <= 8; i++) n[i - 1] = (uint32_t)strtoul(argv[i], NULL, 10);
  print_words(walk_packet(n[0], n[1], n[2], n[3], n[4], n[5], n[6]), sizeof(walk_ray) / 4);
  print_words(walk_trace(n[7]), sizeof(walk_event) / 4);
  for (uint32_t a = 0; a <= PKTRT_ASSEMBLY_NONE; a++) /* ray 1 is the last digit: `ddddffmm`, `ggmmgggg` */
    print_words(walk_figure(a, 022110000, 033332233), sizeof(walk_member) / 4);
  return 0;
}
