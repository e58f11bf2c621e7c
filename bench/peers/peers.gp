# Plot of what bench/peers/peers.c has measured: gnuplot bench/peers/peers.gp
# reads out/results/peers.csv and writes out/results/peers.svg (or .png with -e "png=1").
# Columns: 1 scene, 2 scenes, 4 setting, 5 isa, 6 what, 8 library, 9 mode, 12 best, 20 required, 21 aim.

results = exists("results") ? results : "out/results"
csv = sprintf("%s/peers.csv", results)
if (exists("png")) {
  set terminal pngcairo size 1100, 760 font "sans,11" background "white"
} else {
  set terminal svg size 1100, 760 font "sans,13" background "white"
}
set output sprintf("%s/peers.%s", results, exists("png") ? "png" : "svg")
set datafile separator ","

kinds = "primary shadow shadow-from-light mirror second-mirror diffuse ao"
# Ratios of one panel, at the place of their kind, to the fastest mode ("many") or the fastest robust one ("many robust"); of the
# scenes "built-in", "generated" or "meshes", or their means.
of(setting, isa, scenes, means, mode) = \
  sprintf("< awk -F, 'BEGIN {n = split(\"%s\", k, \" \"); for (i = 1; i <= n; i++) at[k[i]] = i} ", kinds) \
  .sprintf("$8 == \"ratio\" && $9 == \"%s\" && $4 == \"%s\" && $5 == \"%s\" && ", mode, setting, isa) \
  .sprintf("$2 == \"%s\" && ($1 == \"mean\") == %d && $6 in at ", scenes, means) \
  ."{print at[$6] \",\" $12 \",\" ($20 > 0 ? $20 : \"-\") \",\" ($21 > 0 ? $21 : \"-\")} " \
  ."END {print \"0,-,-,-\"}' ".csv # a line for those that have none

ink = "#1f5fa8"; fire = "#c8501e"; leaf = "#3b8c3b"; plum = "#7a4a9e"; sand = "#b8860b"
set datafile missing "-"
set border 3 lc rgb "#404040"
set tics nomirror
set grid ytics lc rgb "#d8d8d8" lw 1
set key top left reverse Left samplen 2 spacing 1.1 maxrows 3
set logscale y 2
set yrange [0.2:24]
set ytics (0.25, 0.5, 1, 2, 4, 8, 16)
set xrange [0.4:7.6]
set bmargin 3.5
unset errorbars
set xtics ("primary" 1, "shadow" 2, "from\nlight" 3, "mirror" 4, \
           "second\nmirror" 5, "diffuse" 6, "ambient\nocclusion" 7)
set arrow 1 from graph 0, first 1 to graph 1, first 1 nohead lc rgb "#404040" lw 1

isas = system(sprintf("awk -F, '$8 == \"ratio\" && $5 ~ /^avx/ && !seen[$5]++ {printf \"%%s \", $5}' %s", csv))
set multiplot layout 2, words(isas) title "Rays per second of pktrt in those of Embree's fastest mode"
do for [setting in "'at rest' 'moving 1%'"] {
  do for [isa in isas] {
    set title setting.", ".isa
    plot of(setting, isa, "built-in", 1, "many") using 1:3:(0.38) with xerrorbars pt 0 lw 2 lc rgb leaf title "required", \
         of(setting, isa, "built-in", 1, "many") using 1:4:(0.38) with xerrorbars pt 0 lw 2 dt 3 lc rgb plum title "aim", \
         of(setting, isa, "built-in", 0, "many") using ($1 - 0.08):2 with points pt 6 ps 0.6 lc rgb ink title "built-in", \
         of(setting, isa, "built-in", 1, "many") using ($1 - 0.08):2 with points pt 13 ps 1.3 lc rgb ink title "mean", \
         of(setting, isa, "built-in", 1, "many robust") using ($1 - 0.24):2 with points pt 12 ps 1.2 lc rgb sand title "mean, robust", \
         of(setting, isa, "meshes", 0, "many") using ($1 + 0.12):2 with points pt 4 ps 0.6 lc rgb fire title "meshes", \
         of(setting, isa, "meshes", 1, "many") using ($1 + 0.12):2 with points pt 5 ps 1 lc rgb fire title "mean"
  }
}
unset multiplot
