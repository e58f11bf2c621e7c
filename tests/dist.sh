#!/usr/bin/env bash
# The tarball of `make dist`: the same bytes from here, from a clone, and from the tarball itself, whatever time, umask and folder;
# and that it holds what git has. FULL=1: what the README begins with, make deps demo test, in the unpacked tarball.
# usage: [FULL=1] dist.sh, from the project's directory
set -u
unset MAKEFLAGS MAKELEVEL MFLAGS SOURCE_DATE_EPOCH DESTDIR PREFIX CFLAGS LDFLAGS # of the make that runs this
work=build/dist
rm -rf $work
root="$PWD/$work/with two blanks"
mkdir -p "$root"
name=pktrt-$(sed -n '1s/.* v\([0-9.]*\) .*/\1/p' pktrt.h)
tarball="$PWD/build/$name.tar.gz"
. tests/attempt.sh

pack() { # folder, command...
  (cd "$1" && shift && "$@" make --no-print-directory dist)
}
packs() { # folder, command...: the same bytes
  pack "$@" && cmp "$tarball" "$1/build/$name.tar.gz"
}
packs_elsewhere() { # folder: in another time zone, its files for its owner alone
  chmod -R go-rwx "$1" && packs "$1" env TZ=Asia/Tokyo LC_ALL=C sh -c 'umask 077; "$@"' sh
}

rm -f "$tarball"
attempt "a tarball is packed, $name.tar.gz" pack . env
[ -s "$tarball" ] || { echo "dist: there is nothing to look at"; exit 1; }

# --- what is in it ---

unpacks() { (cd "$root" && gzip -dc "$tarball" | tar -x) && [ -s "$root/$name/pktrt.h" ]; }
holds_what_git_has() {
  (cd "$root/$name" && find . -type f | sed 's,^\./,,' | LC_ALL=C sort) >$work/unpacked.txt
  git ls-files | LC_ALL=C sort | diff - $work/unpacked.txt && xargs -d '\n' -I % cmp % "$root/$name/%" <$work/unpacked.txt
}
holds_what_it_must() {
  local file
  for file in pktrt.h README.md Makefile */*.mk examples/hello.c tests/test.h; do cmp $file "$root/$name/$file" || return 1; done
  grep -q 'ALTERNATIVE A: MIT licence' "$root/$name/pktrt.h"
}
is_of_nobody() { # its entries: owner 0, modes 644 and 755, one time, in order
  gzip -dc "$tarball" | TZ=UTC tar -tv --numeric-owner >$work/entries.txt
  awk '$1 !~ /^-rw(-r--r--|xr-xr-x)$/ || $2 != "0/0" || $4 " " $5 != (NR == 1 ? at = $4 " " $5 : at) {print; bad = 1} END {exit bad}' \
    $work/entries.txt && awk '{print $6}' $work/entries.txt | LC_ALL=C sort -c
}
has_no_name_and_time() { [ "$(head -c 8 "$tarball" | od -An -tx1 | tr -d ' \n')" = 1f8b080000000000 ]; } # gzip's header
attempt "it is unpacked into a folder of its name" unpacks
attempt "header, examples, tests and licence are there" holds_what_it_must
attempt "its entries have one time, and tell nothing of who packed them" is_of_nobody
attempt "nor does its compression" has_no_name_and_time

# --- the same bytes ---

clone() { # a clone, with what is not yet committed here
  git clone -q . "$root/a clone" && git ls-files -z | tar --null -T - -c | tar -x -C "$root/a clone" &&
    git -C "$root/a clone" add -A && find "$root/a clone" -name '*.[ch]' -exec touch {} +
}
if [ -e .git ] && command -v git >/dev/null; then
  attempt "it holds what git has, and no more" holds_what_git_has
  attempt "a clone is made" clone
  attempt "later, in a clone, which others must not read: the same bytes" packs_elsewhere "$root/a clone"
  attempt "control: SOURCE_DATE_EPOCH makes others" fails packs "$root/a clone" env SOURCE_DATE_EPOCH=1000000000
  echo >>"$root/a clone/README.md"
  attempt "control: so does a line more" fails packs_elsewhere "$root/a clone"
else
  echo "skipped: here is no git to compare with"
  skipped=$((skipped + 1))
fi

attempt "unpacked, where no git is, it packs itself: the same bytes" packs_elsewhere "$root/$name"

# --- what it is for ---

attempt "the header is installed from it" make --no-print-directory -C "$root/$name" install PREFIX="$root/installed"
attempt "it is the header" cmp pktrt.h "$root/installed/include/pktrt.h"
needs_a_clone() { GIT_DIR=/nowhere make --no-print-directory -C "$root/$name" before 2>&1 | grep 'it needs a clone'; }
attempt "what takes a header of before from git says that it needs a clone" needs_a_clone
nine_pictures() { [ "$(find "$root/$name/out" -name '*.png' | wc -l)" = 9 ]; }
if [ -n "${FULL:-}" ]; then
  attempt "make deps demo test" make --no-print-directory -C "$root/$name" deps demo test
  attempt "it has made nine pictures" nine_pictures
fi

echo "dist: $passed passed, $failed failed; $skipped skipped"
[ $passed -gt 0 ] && [ $failed = 0 ] && { [ $skipped = 0 ] || [ -z "${MATRIX_ALL:-}" ]; }
