# The plot of depth in docs/course/viewing.md: gnuplot docs/course/viewing/depth.gp > docs/course/viewing/depth.png
# The curves are opengl_depth, phigs_depth and depth_resolution_m of tagcal/viewing/canonical.hpp.
near = 0.6
far = 3.0
set terminal png size 900,380 font 'Sans,10'
set multiplot layout 1,2
set grid lc rgb '#dddddd'
set xlabel 'distance ahead, m'

# 0 at the near plane, 1 at the far plane.
share(z) = far / (far - near) * (1 - near / z)

set title 'value in the buffer, near 0.6 m, far 3 m'
set ylabel 'depth'
set key at graph 0.97, 0.48
set xrange [near:far]
set yrange [-1.05:1.05]
plot 2 * share(x) - 1 title 'OpenGL' lw 2 lc rgb '#0072b2', \
     -share(x) title 'PHIGS' lw 2 lc rgb '#d55e00', \
     share(x) title '0 to 1' lw 2 lc rgb '#009e73', \
     1 - share(x) title 'reversed' lw 2 lc rgb '#cc79a7'

# One step of the buffer, as a length. 24 bits: equal steps. Reversed floats: the step of a number v is v / 2^23 at the most, and
# v = n (f - z) / (z (f - n)) is small far away, where the slope is small too.
resolution(z, n, f, bits) = z**2 * (f - n) / (f * n) / (2**bits - 1)
reversed(z, n, f) = z**2 * (f - n) / (f * n) * (n * (f - z) / (z * (f - n))) / 2**23
set title 'one step of the buffer, far 1000 m'
set ylabel 'mm'
set key at graph 0.03, 0.97 top left Left reverse
set logscale xy
set format y '10^{%T}'
set xrange [0.1:900]
set yrange [1e-6:1e7]
set samples 400
plot 1000 * resolution(x, 0.1, 1000, 16) title 'near 0.1 m, 16 bits' lw 2 lc rgb '#0072b2', \
     1000 * resolution(x, 0.1, 1000, 24) title 'near 0.1 m, 24 bits' lw 2 lc rgb '#009e73', \
     [1:900] 1000 * resolution(x, 1, 1000, 24) title 'near 1 m, 24 bits' lw 2 lc rgb '#000000', \
     1000 * reversed(x, 0.1, 1000) title 'near 0.1 m, reversed float' lw 2 lc rgb '#cc79a7'
