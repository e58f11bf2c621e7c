/* 07_check.c - checks the exercise of chapter 7 against the lists of section 3.2.1, then against the library's packets. */
#define PKTRT_IMPLEMENTATION
#include "07_figure3.h"

enum { OTHERS = 200 };

typedef uint32_t assemble(const char *met, pktrt_ray_type type, figure_packet *packet);
static const struct method {
  const char *name, *paper; /* paper: as section 3.2.1 lists them */
  assemble *function;
  pktrt_assembly library;
} methods[2] = {
    {"runs",
        "shadow (1,2,3,4) (5,6); reflection (5,6) (7,8) (9,10) (11,12) (13,14,15,16); refraction (9,10) (13,14,15,16)",
        figure_runs, PKTRT_ASSEMBLY_RUNS},
    {"groups", "shadow (1,2,3,4) (5,6); reflection (5,6) (7,8,11,12) (9,10,13,14,15,16); refraction (9,10,13,14,15,16)",
        figure_groups, PKTRT_ASSEMBLY_MATERIALS},
};

/* All packets of the student's, as text; or NULL, having said what cannot be. */
static const char *answer(const struct method *m, const char *met, char text[1024]) {
  static figure_packet packet[3 * FIGURE_PACKETS];
  uint32_t count = 0;
  for (int type = PKTRT_RAY_SHADOW; type <= PKTRT_RAY_REFRACTION; type++) {
    const uint32_t more = m->function(met, (pktrt_ray_type)type, packet + count);
    if (more > FIGURE_RAYS) return ex_fail("%s: %u packets of sixteen rays", m->name, (unsigned)more), NULL;
    for (uint32_t k = count; k < count + more; k++) {
      packet[k].type = (pktrt_ray_type)type;
      if (packet[k].n < 1 || packet[k].n > FIGURE_RAYS)
        return ex_fail("%s: a packet of %u rays", m->name, (unsigned)packet[k].n), NULL;
    }
    count += more;
  }
  return figure_text(packet, count, text);
}

static bool same(const struct method *m, const char *met, const char *expected) {
  char text[1024];
  const char *got = answer(m, met, text);
  if (got && !strcmp(got, expected)) return true;
  printf("%s of %s\n  expected: %s\n  got: %s\n", m->name, met, expected,
      !got   ? "what cannot be"
      : *got ? got
             : "none");
  return false;
}

/* Sixteen other things: runs of one to four, so that all that may be adjacent is. */
static void make_other(char met[FIGURE_RAYS + 1], uint32_t *state) {
  uint32_t left = 0;
  for (uint32_t i = 0; i < FIGURE_RAYS; i++, left--) {
    if (left == 0) left = 1 + (uint32_t)(4 * course_random(state)), met[i] = "dfmg."[(int)(5 * course_random(state))];
    else met[i] = met[i - 1];
  }
  met[FIGURE_RAYS] = 0;
}

static const char *check(void) {
  static figure_log log;
  uint32_t place[FIGURE_RAYS], state = 7;
  char met[FIGURE_RAYS + 1], text[1024];
  for (int k = 0; k < 2; k++) {
    if (!same(&methods[k], FIGURE_MET, methods[k].paper)) return "the packets are not those of section 3.2.1";
    printf("%s: the packets of section 3.2.1.\n", methods[k].name);
  }
  figure_places(place);
  for (int i = 0; i < OTHERS; i++) {
    make_other(met, &state);
    if (!strpbrk(met, "dfmg")) continue; /* the library would have no scene */
    for (int k = 0; k < 2; k++) {
      figure_trace(met, place, methods[k].library, &log);
      if (!same(&methods[k], met, figure_text(log.packet, log.count, text))) return "the library makes other packets";
    }
  }
  printf("The library's packets for %d other sets of sixteen, by runs and by groups.\n", OTHERS);
  course_figure("sets", "%d", OTHERS);
  return NULL;
}

int main(void) { return course_result(7, check()); }
