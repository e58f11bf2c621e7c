# shellcheck shell=bash
# What scripts that drive programs share; to be sourced. said: files of what was said, shown if a check fails; aloud: 1, checks
# that pass are told.
checks=0 failed=0
said=errors.txt aloud=

check() { # sentence, command...
  local sentence=$1
  shift
  checks=$((checks + 1))
  if "$@"; then
    [ -z "$aloud" ] || echo "  ok      $sentence"
    return 0
  fi
  echo "  FAILED  $sentence: $*"
  # shellcheck disable=SC2086
  sed 's/^/          it said: /' $said | head -20
  failed=$((failed + 1))
}
fails() { ! "$@"; } # for controls
