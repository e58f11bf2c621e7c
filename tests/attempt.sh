# shellcheck shell=bash
# What scripts of checks share; to be sourced. excerpt: of the output of one that fails, what is shown.
passed=0 failed=0 skipped=0
excerpt() { head -20; }

attempt() { # what, command...
  local what=$1 out
  shift
  if out=$("$@" 2>&1); then
    passed=$((passed + 1)) && echo "passed  $what"
  else
    failed=$((failed + 1)) && printf 'FAILED  %s\n%s\n' "$what" "$(printf '%s\n' "$out" | excerpt)"
  fi
}
fails() { ! "$@"; } # for controls
have() { # tools...
  local tool
  for tool; do
    command -v "$tool" >/dev/null || { echo "skipped: $tool is not installed (make deps-extra)"; skipped=$((skipped + 1)); return 1; }
  done
}
