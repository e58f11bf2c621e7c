# Plots of what bench/error/error.c has measured: gnuplot -e "name='closed'" bench/error/error.gp
# reads out/results/error_NAME.csv and writes out/results/error_NAME.svg (or .png with -e "png=1"). NAME: slopes, closed,
# scenes, adaptive.

results = exists("results") ? results : "out/results"
csv = sprintf("%s/error_%s.csv", results, name)
rows = name eq "slopes" ? 2 : name eq "scenes" ? 2 : 3
wide = 1500
high = 320 * rows
if (exists("png")) {
  set terminal pngcairo size wide, high font "sans,11" background "white"
} else {
  set terminal svg size wide, high font "sans,13" background "white"
}
set output sprintf("%s/error_%s.%s", results, name, exists("png") ? "png" : "svg")
set datafile separator ","
set border 3 lc rgb "#404040"
set tics nomirror
set grid lc rgb "#e0e0e0" lw 1
set key outside right top Left reverse samplen 1.2 spacing 1
set logscale xy
set format xy "10^{%L}"

samplers = "sobol random jittered interleaved halton hammersley blue-noise"
array ink[7] = ["#1f5fa8", "#303030", "#b8860b", "#3b8c3b", "#c8501e", "#7a4a9e", "#40a0a0"]
pick(test) = sprintf("< awk -F, '%s' %s", test, csv)

# The fitted slope of a sampler, as it stands in a column of its rows.
slope(test, column) = real(system(sprintf("awk -F, '%s {print $%d; exit}' %s", test, column, csv)))
named(word, value) = sprintf("%s, %.2f", word, value)

if (name eq "slopes") {
  # 1 sampler, 2 integrand, 3 kind, 4 dimensions, 5 samples, 6 rmse, 7 slope
  set multiplot layout 2, 3 title "RMSE over samples, with fitted slopes: integrands over the unit cube"
  set xlabel "samples"
  set ylabel "RMSE"
  shown = "bump:1 bump:2 bump:4 interval:1 triangle:2 half-space:4"
  do for [k = 1:6] {
    what = word(shown, k); at = strstrt(what, ":")
    test(s) = sprintf('$1 == "%s" && $2 == "%s" && $4 == %s', s, what[1:at-1], what[at+1:*])
    set title sprintf("%s, %s dimension%s", what[1:at-1], what[at+1:*], what[at+1:*] eq "1" ? "" : "s")
    plot for [i = 1:7] pick(test(word(samplers, i))) using 5:6 with linespoints pt 7 ps 0.4 lw (i == 1 ? 3 : 1.3) \
           lc rgb ink[i] title named(word(samplers, i), slope(test(word(samplers, i)), 7))
  }
  unset multiplot
}

if (name eq "closed" || name eq "scenes") {
  # 1 scene, 2 mode, 3 sampler, 4 passes, 5 samples, 7 seconds, 8 rmse, 9 and 10 its interval, 12 slope
  stages = system(sprintf("awk -F, '!/^#/ && $1 != \"scene\" && !seen[$1 \":\" $2]++ {print $1 \":\" $2}' %s", csv))
  set multiplot layout rows, 3 title "True RMSE against run time, one set of 1 to 256 samples, with fitted slopes over samples"
  set xlabel "seconds"
  set ylabel "RMSE"
  do for [k = 1:words(stages)] {
    what = word(stages, k); at = strstrt(what, ":")
    test(s) = sprintf('$3 == "%s" && $4 == 1 && $1 == "%s" && $2 == "%s"', s, what[1:at-1], what[at+1:*])
    set title sprintf("%s, %s", what[1:at-1], what[at+1:*])
    plot for [i = 1:7] pick(test(word(samplers, i))) using 7:8 with linespoints pt 7 ps 0.4 lw (i == 1 ? 3 : 1.3) \
           lc rgb ink[i] title named(word(samplers, i), slope(test(word(samplers, i)), 12)), \
         pick(test("sobol")) using 7:8:9:10 with yerrorbars pt 0 lc rgb ink[1] notitle
  }
  unset multiplot
}

if (name eq "adaptive") {
  # 1 scene, 2 way, 3 samples, 4 seconds, 5 rmse
  stages = system(sprintf("awk -F, '!/^#/ && $1 != \"scene\" && !seen[$1]++ {print $1}' %s", csv))
  set multiplot layout 3, 4 title "True RMSE against run time, passes of 8 samples: uniform and adaptive"
  set xlabel "seconds"
  set ylabel "RMSE"
  do for [k = 1:words(stages)] {
    what = word(stages, k)
    set title what
    plot pick(sprintf('$1 == "%s" && $2 == "uniform"', what)) using 4:5 with linespoints pt 7 ps 0.5 lw 2 lc rgb ink[2] \
           title "uniform", \
         pick(sprintf('$1 == "%s" && $2 == "adaptive rmse"', what)) using 4:5 with linespoints pt 7 ps 0.5 lw 2 \
           lc rgb ink[5] title "adaptive"
  }
  unset multiplot
}
