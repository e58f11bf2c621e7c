/* 07_solution.c - RUNS and GROUPS of section 3.2. */
#include "07_figure3.h"

uint32_t figure_runs(const char met[FIGURE_RAYS], pktrt_ray_type type, figure_packet *packet) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < FIGURE_RAYS; i++) {
    if (!figure_sends(met[i], type)) continue;
    if (i == 0 || met[i] != met[i - 1]) packet[count++].n = 0;
    figure_packet *p = &packet[count - 1];
    p->ray[p->n++] = i;
  }
  return count;
}

uint32_t figure_groups(const char met[FIGURE_RAYS], pktrt_ray_type type, figure_packet *packet) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < FIGURE_RAYS; i++) {
    if (!figure_sends(met[i], type)) continue;
    uint32_t k = 0;
    while (k < count && met[packet[k].ray[0]] != met[i]) k++;
    if (k == count) packet[count++].n = 0;
    packet[k].ray[packet[k].n++] = i;
  }
  return count;
}
