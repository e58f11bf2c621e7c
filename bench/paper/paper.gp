# Plots of what bench/paper/paper.c has measured: gnuplot -e "name='figure6'" bench/paper/paper.gp
# reads out/results/NAME.csv and writes out/results/NAME.svg (or NAME.png with -e "png=1").
# Columns: 1 varied, 2 value, 3 scene, 6 path, 7 isa, 8 packet, 9 assembly, 12 of, 14 boxes, 15 triangles, 16 box tests in vectors of
# tests, each per ray, 20 speed-up, 21 the paper's.

results = exists("results") ? results : "out/results"
csv = sprintf("%s/%s.csv", results, name)
wide = name eq "table1" ? 1100 : name eq "figure7" ? 960 : 900
high = name eq "figure7" ? 760 : 420
if (exists("png")) {
  set terminal pngcairo size wide, high font "sans,11" background "white"
} else {
  set terminal svg size wide, high font "sans,13" background "white"
}
set output sprintf("%s/%s.%s", results, name, exists("png") ? "png" : "svg")
set datafile separator ","

rows(test) = sprintf("< awk -F, '%s' %s", test, csv) # those lines alone
ink = "#1f5fa8"; fire = "#c8501e"; leaf = "#3b8c3b"; sand = "#b8860b"; plum = "#7a4a9e"
set border 3 lc rgb "#404040"
set tics nomirror
set grid ytics lc rgb "#d8d8d8" lw 1
set key top left reverse Left samplen 2 spacing 1.1
set yrange [0:*]
set offsets 0, 0, graph 0.5, 0 # room for the key

if (name eq "table1") {
  isas = system(sprintf("awk -F, '$6 == \"fast\" && !seen[$7]++ {print $7}' %s", csv))
  of(scene, path, isa) = rows(sprintf('$1 == "" && $12 == "all" && $9 == "ray types" && $3 == "%s" && $6 == "%s" && $7 == "%s"', \
                                      scene, path, isa))
  lanes = word(isas, 1)
  set multiplot layout 1, 3 title "Table 1: Whitted's mode, packets by ray type against single secondary rays"
  set logscale x 2
  set xrange [1.7:19]
  set yrange [0:6]
  set xtics ("2x2" 2, "4x4" 4, "8x8" 8, "16x16" 16)
  set xlabel "packets of primary rays"
  set ylabel "rays per second in those of single rays"
  do for [scene in "conference rtrt poolhall"] {
    set title scene
    plot of(scene, "paper", lanes) using 8:21 with linespoints dt 2 pt 6 lc rgb "#606060" title "the paper", \
         of(scene, "paper", lanes) using 8:20 with linespoints pt 7 lw 2 lc rgb ink title "paper path, ".lanes, \
         for [isa in isas] of(scene, "fast", isa) using 8:20 with linespoints pt (isa eq lanes ? 9 : 5) lw 2 \
           lc rgb (isa eq lanes ? fire : sand) title "fast path, ".isa
  }
  unset multiplot
}

if (name eq "figure6") {
  of(path, sort) = rows(sprintf('$1 == "" && $12 == "%s" && $6 == "%s"', sort, path))
  set multiplot layout 1, 2 title "Figure 6: tests per ray against packet size, Whitted's mode, conference"
  set logscale x 2
  set xrange [1.7:19]
  set xtics ("2x2" 2, "4x4" 4, "8x8" 8, "16x16" 16)
  set xlabel "packets"
  do for [i = 15:14:-1] {
    set title i == 15 ? "triangle tests" : "box tests"
    set ylabel (i == 15 ? "triangles" : "boxes")." per ray"
    plot of("paper", "all") using 8:i with linespoints pt 7 lw 3 lc rgb ink title "paper path, all rays", \
         of("paper", "primary") using 8:i with linespoints pt 6 lc rgb plum title "primary", \
         of("paper", "shadow") using 8:i with linespoints pt 4 lc rgb leaf title "shadow", \
         of("paper", "reflection") using 8:i with linespoints pt 8 lc rgb sand title "reflection", \
         rows('$1 == "steps" && $12 == "all"') using 8:i with linespoints dt 3 pt 12 lw 2 lc rgb ink title "all rays, steps of 2007", \
         of("fast", "all") using 8:i with linespoints dt 2 pt 9 lw 3 lc rgb fire title "fast path, all rays"
  }
  unset multiplot
}

if (name eq "figure7") {
  of(what, path) = rows(sprintf('$12 == "all" && $3 == "conference" && $1 == "%s" && $6 == "%s"', what, path))
  growth(what, path) = sprintf("< awk -F, '$12 == \"all\" && $3 == \"rtrt\" && $1 == \"%s\" && $6 == \"%s\" " \
                               ."{t = $14 + $15; if (!n++) first = t; print $2 \",\" t / first}' %s", what, path, csv)
  set multiplot layout 2, 2 title "Figure 7: distribution ray tracing, 16 samples per pixel, packets of 8x8"
  set ylabel "tests per ray"
  set offsets 0, 0, graph 1, 0
  do for [what in "aperture light_size gloss"] {
    column1 = what eq "light_size" ? "light size" : what
    set title what eq "gloss" ? "gloss, conference" : column1.", conference"
    set xlabel what eq "aperture" ? "diameter of the lens, in that of the scene" : \
               what eq "gloss" ? "exponent of the Phong lobes" : "width of the lamps, in that of the scene"
    if (what eq "gloss") { set logscale x 10 }
    plot of(column1, "paper") using 2:14 with linespoints pt 7 lw 2 lc rgb ink title "paper path, boxes", \
         of(column1, "paper") using 2:15 with linespoints dt 2 pt 6 lw 2 lc rgb ink title "triangles", \
         of(column1, "fast") using 2:14 with linespoints pt 9 lw 2 lc rgb fire title "fast path, boxes", \
         of(column1, "fast") using 2:15 with linespoints dt 2 pt 8 lw 2 lc rgb fire title "triangles"
  }
  unset logscale x
  set title "shutter, rtrt"
  set xlabel "shutter, in the time of the animation's loop"
  set ylabel "tests per ray, shut = 1"
  set yrange [0.9:*]
  plot growth("shutter united", "paper") using 1:2 with linespoints dt 2 pt 6 lw 2 lc rgb ink \
         title "paper path, united boxes", \
       growth("shutter", "paper") using 1:2 with linespoints pt 7 lw 2 lc rgb ink title "boxes that move", \
       growth("shutter united", "fast") using 1:2 with linespoints dt 2 pt 8 lw 2 lc rgb fire \
         title "fast path, united boxes", \
       growth("shutter", "fast") using 1:2 with linespoints pt 9 lw 2 lc rgb fire title "boxes that move"
  unset multiplot
}

if (name eq "figure8") {
  # By bounces up to 10; all rays stand at 12.
  of(assembly) = sprintf("< awk -F, '$3 == \"conference\" && $6 == \"paper\" && $9 == \"%s\" && ($12 == \"all\" || " \
                         ."($12 ~ /^depth/ && substr($12, 7) + 0 <= 10)) {d = $12 == \"all\" ? 12 : substr($12, 7); " \
                         ."print d \",\" $15 \",\" $16}' %s | sort -n", assembly, csv)
  set multiplot layout 1, 2 title "Figure 8: tests per ray by bounces from the camera, paper path, conference"
  set xrange [-0.7:12.7]
  set xtics ("0" 0, "2" 2, "4" 4, "6" 6, "8" 8, "10" 10, "all" 12)
  set xlabel "bounces"
  set style fill solid 0.9
  set boxwidth 0.38
  do for [i = 2:3] {
    set title i == 2 ? "triangle tests" : "box tests, in vectors of eight"
    set ylabel i == 2 ? "triangles per ray" : "vectors per ray"
    plot of("ray types") using ($1 - 0.2):i with boxes lc rgb ink title "ray types", \
         of("runs") using ($1 + 0.2):i with boxes lc rgb sand title "runs"
  }
  unset multiplot
}
