"""Drawings of data sets, calibrations and poses, each by one call. They need matplotlib.

Every function draws in the axes `ax` if they are given, else in a new figure, and returns the axes:
`ax.figure.savefig("file.png")` writes the picture. No function calls `show`. Maps have the colours
of "viridis", marks those of Okabe and Ito: both are told apart by all kinds of colour vision.
"""

from tagcal._plot import (
    coverage as coverage,
    difference as difference,
    poses as poses,
    residual_distribution as residual_distribution,
    residuals as residuals,
    uncertainty as uncertainty,
)

__all__ = ["coverage", "difference", "poses", "residual_distribution", "residuals", "uncertainty"]
