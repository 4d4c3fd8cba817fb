"""Cameras and boards in 3D: the function `poses` of tagcal.plot."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

import tagcal

Array = NDArray[np.float64]


def poses_of(views: Any) -> list[Optional[tagcal.Pose]]:
    """camera_from_world of all that `poses` takes; None for an estimate without an answer."""
    if isinstance(views, tagcal.Pose):
        return [views]
    if isinstance(views, (tagcal.PoseEstimate, tagcal.PoseAndFocalEstimate)):
        return [views.camera_from_target if views.is_answer else None]
    if hasattr(views, "camera_from_world"):
        return [views.camera_from_world]
    views = getattr(views, "views", views)
    if isinstance(views, (str, bytes)) or not hasattr(views, "__getitem__"):
        raise tagcal.Error(
            "views: must be a Calibration, a Pose, a PoseEstimate, or a list of these, got "
            + type(views).__name__
        )
    return [pose for i in range(len(views)) for pose in poses_of(views[i])]


def boards_of(target: Any) -> list[tuple[tagcal.Board, tagcal.Pose]]:
    """The boards of a target or of a data set, each with world_from_board."""
    if target is None:
        return []
    if isinstance(target, tagcal.Board):
        return [(target, tagcal.Pose())]
    if isinstance(target, tagcal.PlacedBoard):
        return [(target.board, target.world_from_board)]
    if isinstance(target, tagcal.Dataset):
        target = target.target
    if not isinstance(target, (list, tuple)):
        raise tagcal.Error(
            "target: must be a Board, a PlacedBoard, a list of these or a Dataset, got "
            + type(target).__name__
        )
    return [board for element in target for board in boards_of(element)]


def outlines(board: tagcal.Board) -> Iterator[Array]:
    """Closed polygons (N, 3) in the board frame: the border of a flat board, and all tags."""
    points, tags = board.positions, board.ids[:, 0]
    if np.ptp(points[:, 2]) == 0:
        (x0, y0, z), (x1, y1, _) = points.min(axis=0), points.max(axis=0)
        yield np.array([(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z), (x0, y0, z)])
    for tag in np.unique(tags):
        corners = points[tags == tag]
        if len(corners) == 4:
            yield corners[[0, 1, 2, 3, 0]]


def pyramid(camera: Optional[tagcal.Camera], depth_m: float) -> Array:
    """Apex, upper left, upper right, lower right, lower left (5, 3) in the camera frame."""
    image = np.array([(-0.5, -0.375, 1), (0.5, -0.375, 1), (0.5, 0.375, 1), (-0.5, 0.375, 1)])
    if camera is not None and camera.lens != "parallel":
        right, bottom = camera.size[0] - 0.5, camera.size[1] - 0.5
        rays = camera.unproject([(-0.5, -0.5), (right, -0.5), (right, bottom), (-0.5, bottom)])
        if np.all(rays[:, 2] > 0.3):  # a wider one would hide the others
            image = rays / rays[:, 2:]
    return depth_m * np.vstack([np.zeros(3), image])


def draw_camera(axes: Any, pose: tagcal.Pose, shape: Array, style: dict[str, Any]) -> Array:
    """A pyramid with a roof over the image's upper edge; returns its corners (5, 3)."""
    apex, a, b, c, d = corners = pose.inverse().transform(shape)
    path = np.array([apex, a, b, c, d, a, apex, b, apex, c, apex, d])
    axes.plot(*path.T, **style)
    roof = np.array([a, (a + b) / 2 + 0.3 * (a - d), b])
    axes.plot(*roof.T, **style)
    result: Array = np.vstack([corners, roof])
    return result


def set_limits(axes: Any, points: Array) -> None:
    """One scale for all three axes, around the points (N, 3)."""
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.05 * max(float(np.max(high - low)), 1e-6)
    low, high = low - margin, high + margin
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axes.set_box_aspect(high - low)
    axes.set(xlabel="x [m]", ylabel="y [m]", zlabel="z [m]")
