"""The functions of tagcal.plot."""

from __future__ import annotations

import collections.abc
import math
from typing import TYPE_CHECKING, Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

import tagcal
from tagcal._plot_images import (
    BLACK,
    BLUE,
    VERMILION,
    draw_arrows,
    draw_hull,
    draw_map,
    image_figure,
    load,
    prepare_image,
)
from tagcal._plot_poses import boards_of, draw_camera, outlines, poses_of, pyramid, set_limits
from tagcal._residuals import Residuals, residuals_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    Views = Union[tagcal.Dataset, tagcal.DetectedViews, collections.abc.Sequence[tagcal.View]]

__all__ = ["coverage", "difference", "poses", "residual_distribution", "residuals", "uncertainty"]

Array = NDArray[np.float64]


def _count(n: int, noun: str) -> str:
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


# Residuals


def _draw_residuals(axes: Any, found: Residuals, width_px: int) -> None:
    accepted = found.is_inlier
    draw_arrows(axes, found.pixels[accepted], found.vectors[accepted], width_px, BLUE)
    rejected = found.pixels[~found.is_inlier]
    if len(rejected):
        axes.plot(*rejected.T, "x", color=VERMILION, markersize=5, label="rejected")
        axes.legend(loc="upper right")


def _draw_distribution(axes: Any, found: Residuals) -> None:
    values = found.whitened[found.is_inlier].ravel()
    values = values[np.isfinite(values)]
    edges = np.linspace(-5, 5, 51)
    observed = float(np.sqrt(np.mean(values**2))) if len(values) else math.nan
    if len(values):
        axes.hist(
            np.clip(values, -5, 5), edges, density=True, color=BLUE, alpha=0.6,
            label=f"residuals, sd {observed:.2f}",
        )
    normal = np.exp(-(edges**2) / 2) / math.sqrt(2 * math.pi)
    axes.plot(edges, normal, color=BLACK, label="claimed, sd 1")
    axes.set(xlim=(-5, 5), xlabel="residual / claimed sd", ylabel="density")
    axes.set_title("against the claimed noise")
    axes.legend(loc="upper right", fontsize="small")


def residuals(
    calibration: tagcal.Calibration, dataset: tagcal.Dataset, *, ax: Optional[Axes] = None
) -> Axes:
    """The residuals (seen less projected) of a calibration as enlarged vectors over the image.

    The arrow below the image shows the scale; crosses are rejected corners. A new figure has the
    residual distribution beside the image, in a second pair of axes. Residuals without a pattern
    are noise; a pattern over the image is a lens or a board that the model does not have.
    """
    found = residuals_of(calibration, dataset)
    axes: Any = ax
    if axes is None:
        figure = image_figure(dataset.size, 3.5)
        axes, beside = figure.subplots(1, 2, gridspec_kw={"width_ratios": [2, 1]})
        _draw_distribution(beside, found)
    title = f"residuals of {_count(int(found.is_inlier.sum()), 'corner')}"
    title += f" in {_count(len(calibration.views), 'view')}, rms {calibration.rms_px:.3g} px"
    prepare_image(axes, dataset.size, title)
    _draw_residuals(axes, found, dataset.size[0])
    return axes


def residual_distribution(
    calibration: tagcal.Calibration, dataset: tagcal.Dataset, *, ax: Optional[Axes] = None
) -> Axes:
    """The distribution of the residuals in claimed standard deviations, beside a normal one.

    Both coordinates of every accepted corner count; correlated ones are decorrelated first. Values
    beyond 5 count as 5. A wider histogram than the curve means that the noise was underestimated.
    """
    found = residuals_of(calibration, dataset)
    axes: Any = ax
    if axes is None:
        axes = load("pyplot").figure(figsize=(5, 4), constrained_layout=True).add_subplot()
    _draw_distribution(axes, found)
    return axes


# Where corners were, and how sure the projection is there


def coverage(
    dataset: Views,
    camera: Optional[tagcal.Camera] = None,
    *,
    ax: Optional[Axes] = None,
) -> Axes:
    """Where in the image the corners of all views are: points over the counts in square cells.

    `dataset`: a Dataset, or views as `detect_all` returns them, which need `camera` (its size alone
    counts). Cells without corners stay white: there the lens is extrapolated.
    """
    size, views = _size_and_views(dataset, camera)
    pixels = np.concatenate([np.zeros((0, 2)), *(view.pixels for view in views)])
    axes: Any = ax if ax is not None else image_figure(size, 1.2).add_subplot()
    edges = [np.linspace(-0.5, side - 0.5, 1 + round(16 * side / max(size))) for side in size]
    histogram: Any = np.histogram2d  # whose types do not know edges of float
    counts: Array = histogram(pixels[:, 0], pixels[:, 1], bins=edges)[0]
    shown = np.where(counts > 0, counts, np.nan).T
    colours = axes.pcolormesh(*edges, shown, cmap="viridis_r", vmin=0, vmax=max(1, counts.max()))
    axes.plot(*pixels.T, ".", color=BLACK, markersize=1)
    axes.figure.colorbar(colours, ax=axes, label="corners in a cell")
    title = f"{_count(len(pixels), 'corner')} in {_count(len(views), 'view')}"
    prepare_image(axes, size, f"{title}; {np.mean(counts > 0):.0%} of the cells have corners")
    return axes


def _size_and_views(
    dataset: Views, camera: Optional[tagcal.Camera]
) -> tuple[tuple[int, int], list[tagcal.View]]:
    if isinstance(dataset, tagcal.Dataset):
        return dataset.size, dataset.views
    if not isinstance(dataset, (tagcal.DetectedViews, list, tuple)) or not all(
        isinstance(dataset[i], tagcal.View) for i in range(len(dataset))
    ):
        raise tagcal.Error("dataset: must be a Dataset or a list of View")
    if camera is None:
        raise tagcal.Error("camera: is needed with views, for the size of the image")
    return camera.size, [dataset[i] for i in range(len(dataset))]


# Maps over the image


def _distance_text(distance_m: float) -> str:
    return "at infinity" if math.isinf(distance_m) else f"at {distance_m:.3g} m"


def uncertainty(
    calibration: Union[tagcal.Calibration, tagcal.UncertainCamera],
    distance_m: float = math.inf,
    *,
    ax: Optional[Axes] = None,
) -> Axes:
    """The standard deviation of the projection over the image, px per coordinate, of points at a
    distance: colours, with contours at 1, 2 and 5 times the powers of ten.

    The dashed line surrounds the corners; outside of it the lens is extrapolated. White: no ray, or
    a standard deviation above the image's diagonal. A moved camera is subtracted, as in
    `projection_uncertainty`.
    """
    if not isinstance(calibration, (tagcal.Calibration, tagcal.UncertainCamera)):
        kind = type(calibration).__name__
        raise tagcal.Error(f"calibration: must be a Calibration or an UncertainCamera, got {kind}")
    camera = calibration.camera
    if camera is None:
        raise tagcal.Error(f"calibration: has no camera: {calibration}")
    grid = tagcal.ImageGrid(camera.size, 97, 61)
    found = tagcal.projection_uncertainty(calibration, distance_m, grid)
    axes: Any = ax if ax is not None else image_figure(camera.size, 1.2).add_subplot()
    draw_map(axes, grid, found.sigma_px, "sd of the projection [px]")
    draw_hull(axes, calibration.seen.hull)
    title = f"sd {_distance_text(distance_m)}: {found.region_px:.2g} px where corners were (RMS)"
    prepare_image(axes, camera.size, title)
    return axes


def difference(
    a: Union[tagcal.Camera, tagcal.UncertainCamera, tagcal.Calibration],
    b: Union[tagcal.Camera, tagcal.UncertainCamera, tagcal.Calibration],
    distance_m: float = math.inf,
    *,
    ax: Optional[Axes] = None,
) -> Axes:
    """How far two cameras project apart over the image, px, of points at a distance, less what a
    moved camera explains (`diff`): colours with contours, and arrows from the pixel by a to that by
    b, enlarged as the arrow below the image says. The title counts where corners were.
    """
    found = tagcal.diff(a, b, distance_m)
    if found is None:
        raise tagcal.Error("b: fewer than six common pixels with a, so no difference")
    size = found.grid.size
    axes: Any = ax if ax is not None else image_figure(size, 1.2).add_subplot()
    lengths: Array = np.hypot(found.difference_px[..., 0], found.difference_px[..., 1])
    draw_map(axes, found.grid, lengths, "difference [px]")
    title = f"difference {_distance_text(distance_m)}: {found.rms_px:.2g} px RMS"
    prepare_image(axes, size, f"{title}, {found.max_px:.2g} px at most")
    nodes, vectors = found.grid.pixels.reshape(-1, 2), found.difference_px.reshape(-1, 2)
    draw_arrows(axes, nodes, vectors, size[0], BLACK)
    return axes


# Poses


def poses(
    views: Any,
    target: Any = None,
    camera: Optional[tagcal.Camera] = None,
    *,
    ax: Optional[Axes] = None,
) -> Axes:
    """Cameras as pyramids in the frame of the target (or world), in metres, in 3D.

    `views`: a Calibration, a Pose (camera_from_target), a PoseEstimate, or a list of poses or
    estimates, PoseEstimates too. Numbers at the cameras count the views from 0; estimates without
    an answer are not drawn. A roof marks the upper edge of a camera's image. `target`: a Board, a
    PlacedBoard, a list of these or a Dataset: outlines of boards and tags. `camera` gives the
    pyramids their shape (by default the camera of a Calibration). `ax` must be of projection "3d".
    """
    found = poses_of(views)
    drawn = {i: pose for i, pose in enumerate(found) if pose is not None}
    boards = boards_of(target)
    axes: Any = ax
    if axes is None:
        figure = load("pyplot").figure(figsize=(7, 6), constrained_layout=True)
        axes = figure.add_subplot(projection="3d")
    elif getattr(axes, "name", "") != "3d":
        raise tagcal.Error('ax: must be of projection="3d"')
    points: list[Any] = [] if boards else [np.zeros((1, 3))]
    for board, world_from_board in boards:
        for outline in outlines(board):
            points.append(world_from_board.transform(outline))
            axes.plot(*points[-1].T, color=BLACK, linewidth=0.8)
    centre = np.mean(np.concatenate(points), axis=0)
    distances = [float(np.linalg.norm(pose.transform(centre))) for pose in drawn.values()]
    depth_m = 0.12 * float(np.median(distances or 1))
    shape = pyramid(camera or getattr(views, "camera", None), depth_m)
    for i, pose in drawn.items():
        points.append(draw_camera(axes, pose, shape, {"color": BLUE, "linewidth": 0.8}))
        if len(found) > 1:
            axes.text(*points[-1][0], str(i), fontsize="small")
    set_limits(axes, np.concatenate(points))
    missing = len(found) - len(drawn)
    title = _count(len(drawn), "camera") + (f"; {missing} without an answer" if missing else "")
    axes.set_title(title)
    return axes
