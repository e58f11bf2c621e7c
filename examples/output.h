/* Files that are there whole or not at all, and what becomes of interrupts. Include after common.h. POSIX.

   What is written goes to temporary names beside the targets; when everything is written, they are renamed. A run
   that fails or is interrupted leaves no file, and files of an earlier run as they were. What is no regular file, a
   device or a pipe, is written directly. */
#ifndef EXAMPLES_OUTPUT_H
#define EXAMPLES_OUTPUT_H

#include "common.h"
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <sys/stat.h>

/* >>interrupts ----------------------------------------------------------------------------------------------------- */

/* What a signal does. */
enum {
  INTERRUPT_ENDS,    /* ends the program at once: there is nothing to put in order */
  INTERRUPT_CANCELS, /* is noted, for the work to stop soon; a second one ends the program at once */
  INTERRUPT_WAITS,   /* is noted: files are being made */
  INTERRUPT_TOO_LATE /* nothing: they get their names */
};
static volatile sig_atomic_t interrupt_does = INTERRUPT_ENDS;
static volatile sig_atomic_t interrupt_number; /* of the signal that came; 0: none */
static int interrupt_stderr;                   /* a copy: assimp works without standard error */
static bool interrupt_bar;                     /* it may have a progress bar, which is no finished line */

/* The one line about it is written here, at once. */
static void interrupt_arrived(int number) {
  static const char line[] = "\nerror: interrupted\n";
  const int skip = interrupt_bar ? 0 : 1;
  const bool first = interrupt_number == 0;
  if (interrupt_does == INTERRUPT_TOO_LATE) return;
  interrupt_number = number;
  const ssize_t written = first ? write(interrupt_stderr, line + skip, sizeof line - 1 - (size_t)skip) : 0;
  (void)written;
  if (interrupt_does == INTERRUPT_WAITS || (interrupt_does == INTERRUPT_CANCELS && first)) return;
  signal(number, SIG_DFL); /* what started this program shall see that a signal ended it */
  raise(number);
}

/* What the caller ignores, as nohup does SIGHUP, stays ignored. System calls are not restarted: a pipe that nobody
   reads would keep the program waiting. */
EX_UNUSED static void interrupt_take(void) {
  static const int numbers[] = {SIGINT, SIGTERM, SIGHUP};
  interrupt_stderr = dup(STDERR_FILENO);
  interrupt_bar = isatty(STDERR_FILENO);
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
    struct sigaction now;
    if (sigaction(numbers[i], NULL, &now) != 0 || now.sa_handler == SIG_IGN) continue;
    memset(&now, 0, sizeof now);
    now.sa_handler = interrupt_arrived;
    sigaction(numbers[i], &now, NULL);
  }
}

/* Ends a program that has put its files in order, by the signal that was noted: a shell sees status 128 and its
   number. */
EX_UNUSED static int interrupt_status(void) {
  const int number = interrupt_number;
  signal(number, SIG_DFL);
  raise(number);
  return 128 + number; /* the signal is blocked */
}

/* >>files ---------------------------------------------------------------------------------------------------------- */

enum { OUTPUT_PATH = 4096 };

typedef struct output_file {
  char name[OUTPUT_PATH];      /* as the user said; "": no such output */
  char path[OUTPUT_PATH];      /* of the file itself, where the name is a link */
  char temporary[OUTPUT_PATH]; /* "": there is none at present */
  mode_t mode;                 /* permissions of the file that is replaced, or of any new one */
  bool direct, is_stdout;
} output_file;

static bool output_refuse(const output_file *o, const char *what, int error) {
  return ex_fail("%s: %s: %s", o->name, what, strerror(error));
}

/* Makes the temporary file; a descriptor, or -1 after saying why not. Its name is not that of the target with something
   behind, for that may already be as long as a name can be. */
static int output_make_temporary(output_file *o) {
  const char *slash = strrchr(o->path, '/');
  const int folder = slash ? (int)(slash - o->path) + 1 : 0;
  int made = -1, error = ENAMETOOLONG;
  for (unsigned i = 0; made < 0 && i < 100; i++) {
    const int n = snprintf(o->temporary, OUTPUT_PATH, "%.*s.pktrt-%ld-%u.tmp", folder, o->path, (long)getpid(), i);
    if (n < 0 || n >= OUTPUT_PATH) break;
    made = open(o->temporary, O_WRONLY | O_CREAT | O_EXCL, o->mode);
    error = errno;
    if (made < 0 && error != EEXIST) break;
  }
  if (made >= 0) {
    fchmod(made, o->mode); /* whatever the umask; some file systems know no permissions */
    return made;
  }
  o->temporary[0] = '\0';
  output_refuse(o, "no file can be made beside it", error);
  return -1;
}

static void output_discard(output_file *o) {
  if (o->temporary[0]) unlink(o->temporary);
  o->temporary[0] = '\0';
}

/* Finds where the file is and which permissions it has. One that is not there is made and removed again, which also
   tells where a link points to. */
static bool output_locate(output_file *o) {
  struct stat info;
  const bool there = stat(o->name, &info) == 0;
  if (!there) {
    const int made = errno == ENOENT ? open(o->name, O_WRONLY | O_CREAT, 0666) : -1;
    if (made < 0) return output_refuse(o, "cannot be written", errno);
    fstat(made, &info);
    close(made);
  }
  o->mode = info.st_mode & 0777;
  const bool found = realpath(o->name, o->path) != NULL;
  const int error = errno;
  if (!there) unlink(found ? o->path : o->name);
  return found || output_refuse(o, "cannot be written", error);
}

/* Whether a name is that of a device, of a pipe, or of what standard output goes to. */
EX_UNUSED static bool output_is_direct(const char *name, bool *is_stdout) {
  struct stat info, standard;
  *is_stdout = false;
  if (stat(name, &info) != 0 || S_ISDIR(info.st_mode)) return false;
  *is_stdout = fstat(STDOUT_FILENO, &standard) == 0 && standard.st_dev == info.st_dev && standard.st_ino == info.st_ino;
  return *is_stdout || !S_ISREG(info.st_mode);
}

/* Finds out, before the work and not after it, whether the file o->name can be written, and how. Nothing is lost yet,
   and nothing left. */
EX_UNUSED static bool output_check(output_file *o) {
  struct stat info;
  if (stat(o->name, &info) == 0) {
    if (S_ISDIR(info.st_mode)) return output_refuse(o, "cannot be written", EISDIR);
    if (access(o->name, W_OK) != 0) return output_refuse(o, "cannot be written", errno);
    o->direct = output_is_direct(o->name, &o->is_stdout);
    if (o->direct) return true; /* unopened: the reader of a pipe would see its end */
  }
  if (!output_locate(o)) return false;
  const int made = output_make_temporary(o);
  if (made < 0) return false;
  close(made);
  output_discard(o);
  return true;
}

/* Standard output has a place that what is printed later must know of: it is not opened again. */
static FILE *output_open(output_file *o) {
  const int to = o->is_stdout ? dup(STDOUT_FILENO) : o->direct ? open(o->name, O_WRONLY) : output_make_temporary(o);
  FILE *file = to >= 0 ? fdopen(to, "wb") : NULL;
  if (!file && (o->direct || to >= 0) && !interrupt_number) output_refuse(o, "cannot be written", errno);
  if (!file && to >= 0) close(to);
  return file;
}

/* Writes a picture, see ex_write_channels, which is not in its place before output_publish. */
EX_UNUSED static bool output_write(
    output_file *o, const float *pixels, unsigned width, unsigned height, unsigned channels) {
  FILE *file = output_open(o);
  return file && ex_write_stream(file, o->name, pixels, width, height, channels);
}

/* Puts what was written in its place. */
EX_UNUSED static bool output_publish(output_file *o) {
  if (!o->temporary[0]) return true;
  if (rename(o->temporary, o->path) != 0) return output_refuse(o, "cannot be put in its place", errno);
  o->temporary[0] = '\0';
  return true;
}

#endif /* EXAMPLES_OUTPUT_H */
