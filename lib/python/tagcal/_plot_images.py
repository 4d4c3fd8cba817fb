"""What the drawings over an image share: axes in pixels, arrows, maps."""

from __future__ import annotations

import importlib
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

import tagcal

Array = NDArray[np.float64]

# Okabe and Ito, "Color Universal Design" (2008).
BLACK, BLUE, VERMILION = "#000000", "#0072B2", "#D55E00"


def load(name: str) -> Any:
    """A module of matplotlib, which is loaded when something is drawn."""
    try:
        return importlib.import_module("matplotlib." + name)
    except ImportError as error:
        raise ImportError(
            "tagcal.plot needs matplotlib: install python3-matplotlib (Debian) or matplotlib "
            f"(pip); {error}"
        ) from error


def image_figure(size: tuple[int, int], beside: float) -> Any:
    """A figure for one image, with room beside it, in inches."""
    shown = 6.0 * min(1.0, 1.2 * size[0] / size[1])
    return load("pyplot").figure(
        figsize=(shown + 0.8 + beside, shown * size[1] / size[0] + 0.9), constrained_layout=True
    )


def prepare_image(axes: Any, size: tuple[int, int], title: str) -> None:
    """x right, y down, both in pixels; the border of the image is that of the axes."""
    width, height = size
    axes.set(xlim=(-0.5, width - 0.5), ylim=(height - 0.5, -0.5), aspect="equal")
    axes.set(xlabel="x [px]", ylabel="y [px]", title=title)


def draw_hull(axes: Any, hull: Array) -> None:
    """A dashed line around the part of the image where corners were."""
    if len(hull):
        axes.plot(*np.vstack([hull, hull[:1]]).T, "--", color="white", linewidth=1.5)


def round_number(x: float) -> float:
    """The largest of .., 1, 2, 5, 10, 20, .. that is not above x > 0."""
    power = 10.0 ** math.floor(math.log10(x))
    return power * max(step for step in (1, 2, 5) if step * power <= x * (1 + 1e-9))


def draw_arrows(axes: Any, pixels: Array, vectors: Array, width_px: int, colour: str) -> None:
    """Enlarged vectors (N, 2), px, and below the prepared image one of a known length."""
    finite = np.isfinite(vectors).all(axis=1)
    pixels, vectors = pixels[finite], vectors[finite]
    typical = float(np.quantile(np.hypot(*vectors.T), 0.9)) if len(vectors) else 0.0
    scale = round_number(width_px / 20 / typical) if typical > 0 else 1.0
    arrows = axes.quiver(
        *pixels.T, *vectors.T, color=colour, width=0.002, angles="xy", scale_units="xy",
        scale=1 / scale,
    )
    key = round_number(width_px / 10 / scale)
    axes.apply_aspect()
    height_pt = axes.get_window_extent().height * 72 / axes.figure.dpi
    beside_label = -26 / height_pt  # at the height of the label of the x axis
    axes.quiverkey(arrows, 0.9, beside_label, key, f"{key:g} px (x {scale:g})", labelpos="W")


def scale_of_map(values: Array, largest: float) -> tuple[float, float, list[float]]:
    """The limits of a logarithmic scale, and the contours at 1, 2 and 5 between them."""
    positive = values[np.isfinite(values) & (values > 0) & (values <= largest)]
    if len(positive) == 0:
        return 0.1, 1.0, []
    high = float(positive.max())
    low = max(float(positive.min()), high / 1e3)  # a single node near 0 has no say
    if high < 2 * low:  # an even map must not look uneven
        low, high = low / 2, high * 2
    powers = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    levels = [step * 10.0**power for power in powers for step in (1, 2, 5)]
    return low, high, [level for level in levels if low < level < high]


def draw_map(axes: Any, grid: tagcal.ImageGrid, values: Array, label: str) -> None:
    """Colours of values (rows, columns) on a logarithmic scale, with contours.

    What is not finite or above the image's diagonal stays white.
    """
    x, y = grid.pixels[0, :, 0], grid.pixels[:, 0, 1]
    largest = math.hypot(*grid.size)
    low, high, levels = scale_of_map(values, largest)
    shown = np.where(values <= largest, np.maximum(values, low), np.nan)
    norm = load("colors").LogNorm(low, high)
    shading = "nearest" if np.isnan(shown).any() else "gouraud"  # which cannot leave nodes out
    colours = axes.pcolormesh(x, y, shown, norm=norm, cmap="viridis", shading=shading)
    axes.figure.colorbar(colours, ax=axes, label=label, format="%g")
    if levels:
        contours = axes.contour(x, y, shown, levels, colors=BLACK, linewidths=0.7)
        outline = load("patheffects").withStroke(linewidth=2.5, foreground="white")
        for text in axes.clabel(contours, fmt="%g px", fontsize="small"):
            text.set_path_effects([outline])
