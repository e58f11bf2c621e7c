/* The first line of a CSV file, for scripts that keep figures: provenance COMMAND... prints where they come from. */
#include "provenance.h"

int main(int argc, char **argv) {
  static char command[4096];
  if (argc < 2)
    return fprintf(stderr, "usage: provenance COMMAND...   the line that begins the figures of a command\n"), 2;
  join_command(command, sizeof command, argc - 1, argv + 1);
  write_provenance(stdout, command);
  return fflush(stdout) != 0;
}
