#!/usr/bin/env bash
# Drives the viewer under Xvfb with keys and mouse, reads its title, and looks at the screen.
# usage: view.sh [directory of view, render and screenshot], from the project's directory
set -u
bin=${1:-build}
for tool in Xvfb xdotool; do
  command -v $tool >/dev/null || { echo "view.sh: $tool is not installed (make deps-extra)"; exit 1; }
done
dir=$(mktemp -d)
export SDL_VIDEODRIVER=x11
failed=0 x_server='' viewer='' window='' titles="$dir/titles"
stop() {
  [ -z "$viewer" ] || kill "$viewer" 2>/dev/null
  [ -z "$x_server" ] || kill "$x_server" 2>/dev/null
  wait
  rm -rf "$dir"
}
trap stop EXIT

check() { # sentence, command...
  local sentence=$1
  shift
  if "$@"; then
    echo "  ok      $sentence"
  else
    echo "  FAILED  $sentence: $*"
    [ -z "$window" ] || title
    failed=$((failed + 1))
  fi
}
fails() { ! "$@"; } # for controls
differ() { fails cmp -s "$1" "$2"; }

# --- the viewer and its window ---

start_x() { # -fbdir keeps the screen in a file, which is the screenshot
  Xvfb -displayfd 3 -screen 0 800x600x24 -fbdir "$dir" 3>"$dir/display" 2>"$dir/xvfb.txt" &
  x_server=$!
  for _ in {1..100}; do
    [ -s "$dir/display" ] && export DISPLAY=":$(cat "$dir/display")" && return
    sleep 0.1
  done
  cat "$dir/xvfb.txt"
  exit 1
}
start() { # options...: until its window has a title
  "$bin/view" -o "$dir/view.png" "$@" >"$dir/out.txt" 2>"$dir/errors.txt" &
  viewer=$!
  window=$(timeout 30 xdotool search --sync --onlyvisible --name 'frames/s' | head -1)
  [ -n "$window" ] && return
  cat "$dir/errors.txt"
  exit 1
}
ends_well() { # seconds: the viewer ends by itself within them, with status 0 and no complaint
  for ((i = 0; i < 20 * $1; i++)); do
    kill -0 "$viewer" 2>/dev/null || break
    sleep 0.05
  done
  kill -0 "$viewer" 2>/dev/null && { echo "it goes on"; return 1; }
  wait "$viewer"
  local status=$?
  viewer='' window=''
  [ $status = 0 ] && [ ! -s "$dir/errors.txt" ]
}
title() { xdotool getwindowname "$window"; }
title_has() { # pattern: within 30 seconds
  for _ in {1..600}; do
    title | tee -a "$titles" | grep -Eq -- "$1" && return
    sleep 0.05
  done
  return 1
}
press() { xdotool key "$@"; }
saved() { # name: S was pressed when all passes are done, and the picture is kept by that name
  title_has ', done' || return 1
  rm -f "$dir/view.png"
  press s
  for _ in {1..100}; do
    grep -c "^$dir/view.png" "$dir/out.txt" >"$dir/count"
    [ "$(cat "$dir/count")" = "$((saves + 1))" ] && break
    sleep 0.05
  done
  saves=$(cat "$dir/count")
  mv "$dir/view.png" "$dir/$1.png"
}
saves=0
screen_shows() { # name of a picture, pixels aside: the window shows it
  local X=0 Y=0
  eval "$(xdotool getwindowgeometry --shell "$window" | grep -E '^[XY]=[0-9]+$')"
  cp "$dir/Xvfb_screen0" "$dir/screen"
  "$bin/screenshot" "$dir/screen" $((X + ${2:-0})) "$Y" "$dir/$1.png"
}

# --- what is checked ---

errors_fall() { # titles: several estimates were shown, and the last is less than the first by nearly the root of the passes between
  grep -Eo 'error [0-9.]+, [0-9]+ spp' "$1" | uniq | awk '{ n++; if (n == 1) { first = $2 + 0; from = $3 } last = $2 + 0; to = $3 }
    END { most = 1.25 * first * sqrt(from / to)
      printf "%d errors, from %g at %d spp to %g at %d\n", n, first, from, last, to
      exit !(n >= 2 && from < to && last > 0 && last < first && last < most) }'
}
shows_frames_per_second() { awk -v t="$(title)" 'BEGIN { exit !(match(t, /[0-9.]+ frames/) && substr(t, RSTART) + 0 > 0) }'; }
drag() {
  local X=0 Y=0
  eval "$(xdotool getwindowgeometry --shell "$window" | grep -E '^[XY]=[0-9]+$')"
  xdotool mousemove $((X + 100)) $((Y + 100)) mousedown "$1" mousemove_relative 20 7
  title_has 'spp - ' # a preview
  xdotool mousemove_relative 20 7 mouseup "$1"
}
resized() { # width, height: after the size of the window has been changed to these
  xdotool windowsize "$window" "$1" "$2" && title_has 'spp - ' && saved sized && grep -q ": $1 x $2\$" "$dir/out.txt"
}
screen_moves() {
  cp "$dir/Xvfb_screen0" "$dir/before" && sleep 0.5 && cp "$dir/Xvfb_screen0" "$dir/after" && differ "$dir/before" "$dir/after"
}
time_has_passed() { ! title | grep -q 'time 0.00'; }
same_as_render() { # name, what is seen: the picture that render makes of it
  "$bin/render" ${2:---scene rtrt} --mode wrt --size 240x180 --spp 1 --no-progress -o "$dir/render.png" >/dev/null &&
    cmp "$dir/render.png" "$dir/$1.png"
}
refused() { # word, arguments...: in one line on standard error
  local word=$1
  shift
  fails timeout 20 "$bin/view" "$@" >/dev/null 2>"$dir/refusal" && [ "$(wc -l <"$dir/refusal")" = 1 ] && grep -q -- "$word" "$dir/refusal"
}

check "bad sizes are refused" refused size --size 10
check "bad packets are refused" refused packet --packet 3
check "bad files are refused" refused png -o view.jpg
check "unknown options are refused" refused unknown --frobnicate
SDL_VIDEODRIVER=none check "without a display it ends in one line" refused 'no window'

start_x
echo "refining"
cp "$dir/Xvfb_screen0" "$dir/blank"
start --mode drt --size 240x180 --passes 24 --spp 1
check "ends with all passes done" title_has ', 24 spp, done'
check "the title shows frames per second" shows_frames_per_second
check "passes lower the error that the title shows" errors_fall "$titles"
check "S saves the picture" saved first
check "the screen shows that picture" screen_shows first
check "control: not a pixel aside" fails screen_shows first 1
check "control: a screen without a window is noticed" fails "$bin/screenshot" "$dir/blank" 0 0 "$dir/first.png"
tac "$titles" >"$dir/seltit"
check "control: errors that grow are noticed" fails errors_fall "$dir/seltit"

echo "keys"
press p
check "P changes the packets" title_has 'done - packets 16'
check "S saves the picture" saved packets
check "which is the same" cmp "$dir/first.png" "$dir/packets.png"
press plus period
check "+ and . change aperture and shutter" title_has 'done.*aperture 0.0938, shutter 0.00521'
check "S saves the picture" saved blurred
check "which is another" differ "$dir/first.png" "$dir/blurred.png"
check "the screen shows it" screen_shows blurred
check "control: and not the one before" fails screen_shows first
press m
check "M changes the mode" title_has '^rtrt rcs.*done'
press r
check "R changes it back" title_has '^rtrt drt.*done'
check "S saves the picture" saved again
check "which is the first again" cmp "$dir/first.png" "$dir/again.png"

press c
check "C shows what it costs" title_has '^rtrt drt: boxes.*done'
check "S saves the colours" saved heat
check "which are another picture" differ "$dir/first.png" "$dir/heat.png"
check "the screen shows them" screen_shows heat
press c c
check "C shows the picture again" title_has '^rtrt drt, .*done'
check "S saves the picture" saved cold
check "which is the first again" cmp "$dir/first.png" "$dir/cold.png"

echo "mouse"
drag 1
check "S saves the picture" saved orbit
check "which is another" differ "$dir/first.png" "$dir/orbit.png"
check "the screen shows it" screen_shows orbit
xdotool click 4
check "the wheel changes it" title_has 'spp - '
check "S saves the picture" saved near
check "which is another" differ "$dir/orbit.png" "$dir/near.png"
check "the window can be resized" resized 200 150
check "the screen shows that" screen_shows sized

echo "animation"
check "control: the screen rests" fails screen_moves
press space
check "space starts it" title_has 'frames/s.*moving'
check "the screen moves" screen_moves
press space
check "space ends it" title_has 'done'
check "time has passed" time_has_passed
check "S saves the picture" saved pose
check "the screen shows it" screen_shows pose
press Escape
check "Escape ends it" ends_well 5

echo "against render"
saves=0
start --mode wrt --size 240x180 --passes 1 --spp 1
check "S saves the picture" saved plain
check "it is that of render" same_as_render plain
check "control: another is not" fails same_as_render first
press q
check "Q ends it" ends_well 5

echo "a file"
saves=0
# one triangle: (0, 0, 0), (1, 0, 0), (0, 1, 0)
one='\0\0\200\77' none='\0\0\0\0'
printf "\1\0\0\0$none$none$none$one$none$none$none$one$none" >"$dir/triangle.tri"
start --mode wrt --size 240x180 --passes 1 --spp 1 "$dir/triangle.tri"
check "its name is in the title" title_has 'triangle.tri wrt.*done'
check "S saves the picture" saved file
check "it is that of render" same_as_render file "--mesh $dir/triangle.tri"
check "control: the scene is another" fails same_as_render file
drag 1
check "S saves the picture" saved turned
check "which is another" differ "$dir/file.png" "$dir/turned.png"
press q
check "Q ends it" ends_well 5

echo "at once"
start --mode drt --size 640x480 --spp 64 # the first pass takes seconds
check "the first pass is not yet done" title_has 'error -, 1 spp'
press Escape
check "Escape ends it within one second" ends_well 1

[ $failed = 0 ] && echo "view: all checks passed" && exit
echo "view: $failed checks failed"
exit 1
