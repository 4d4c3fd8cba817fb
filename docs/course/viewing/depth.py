"""The plot of depth in docs/course/viewing.md: python3 docs/course/viewing/depth.py draws depth.png.

The curves are opengl_depth, phigs_depth and depth_resolution_m of tagcal/viewing/canonical.hpp.
"""

from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot

BLUE, VERMILION, GREEN, PURPLE = "#0072b2", "#d55e00", "#009e73", "#cc79a7"


def share(z, near=0.6, far=3.0):
    """0 at the near plane, 1 at the far plane."""
    return far / (far - near) * (1 - near / z)


def resolution_m(z, near, far, bits):
    return z**2 * (far - near) / (far * near) / (2**bits - 1)


def reversed_m(z, near, far):
    """Reversed floats: the step of a number v is v / 2^23 at the most, and v = n (f - z) / (z (f - n))
    is small far away, where the slope is small too."""
    value = near * (far - z) / (z * (far - near))
    return z**2 * (far - near) / (far * near) * value / 2**23


figure, (left, right) = pyplot.subplots(1, 2, figsize=(9, 3.8), layout="constrained")
z = np.linspace(0.6, 3, 200)
left.plot(z, 2 * share(z) - 1, color=BLUE, label="OpenGL")
left.plot(z, -share(z), color=VERMILION, label="PHIGS")
left.plot(z, share(z), color=GREEN, label="0 to 1")
left.plot(z, 1 - share(z), color=PURPLE, label="reversed")
left.set(title="value in the buffer, near 0.6 m, far 3 m", ylabel="depth")
z = np.geomspace(0.1, 900, 400)
right.loglog(z, 1e3 * resolution_m(z, 0.1, 1000, 16), color=BLUE, label="near 0.1 m, 16 bits")
right.loglog(z, 1e3 * resolution_m(z, 0.1, 1000, 24), color=GREEN, label="near 0.1 m, 24 bits")
far = z[z >= 1]
right.loglog(far, 1e3 * resolution_m(far, 1, 1000, 24), color="black", label="near 1 m, 24 bits")
right.loglog(z, 1e3 * reversed_m(z, 0.1, 1000), color=PURPLE, label="near 0.1 m, reversed float")
right.set(title="one step of the buffer, far 1000 m", ylabel="mm")
for axes in (left, right):
    axes.set_xlabel("distance ahead, m")
    axes.grid(color="#dddddd")
left.legend(fontsize="small", loc=(0.66, 0.16))
right.legend(fontsize="small")
figure.savefig(Path(__file__).with_suffix(".png"), dpi=100)
