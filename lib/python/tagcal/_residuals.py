"""The residuals of a calibration, corner by corner."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Optional

import numpy as np
from numpy.typing import NDArray

import tagcal

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Residuals:
    """The corners of the views that take part in a calibration, in the order of the data set."""

    pixels: Array  # (N, 2), where they were seen
    vectors: Array  # (N, 2), seen less projected, px; NaN outside the lens' domain
    whitened: Array  # (N, 2), in claimed standard deviations, uncorrelated; NaN if these are 0
    is_inlier: NDArray[np.bool_]  # (N,)


def _bent(points: Array, target: list[tagcal.PlacedBoard], warp: tagcal.BoardWarp) -> Array:
    """Moves the points of the one flat board, as BoardWarp defines it."""
    board, world_from_board = target[0].board, target[0].world_from_board
    low, high = board.positions.min(axis=0)[:2], board.positions.max(axis=0)[:2]
    in_board = world_from_board.inverse().transform(points)[:, :2] - (low + high) / 2
    place = in_board / ((high - low) / 2)
    by = np.zeros_like(points)
    by[:, 1] = warp.aspect * in_board[:, 1]
    by[:, 2] = ((1 - place**2) @ warp.bend_mm + warp.twist_mm * place.prod(axis=1)) / 1e3
    bent: Array = points + by @ world_from_board.rotation_matrix.T
    return bent


def _projected(
    camera: Optional[tagcal.Camera],
    size: tuple[int, int],
    view: tagcal.CalibratedView,
    points: Array,
) -> Array:
    if camera is not None:
        return camera.project(points, view.camera_from_world)
    assert view.scale_px_per_m is not None  # model weak
    centre = (np.array(size) - 1) / 2
    pixels: Array = view.scale_px_per_m * view.camera_from_world.transform(points)[:, :2] + centre
    return pixels


def _noise(calibration: tagcal.Calibration, view: tagcal.View) -> Array:
    """The covariances (N, 2, 2) that the calibration claims for the corners of a view, px^2."""
    identity = np.eye(2)
    if not calibration.sigma_of_corners:
        return np.broadcast_to(calibration.sigma_px**2 * identity, (len(view), 2, 2))
    own = view.covariances.copy()
    own[np.isnan(own).any(axis=(1, 2))] = 0.25 * identity  # CalibrateOptions: 0.5 px without one
    return own + calibration.model_error_px**2 * identity


def _whitened(vectors: Array, covariances: Array) -> Array:
    if len(vectors) == 0 or np.linalg.det(covariances).min() <= 0:
        return np.full_like(vectors, np.nan)
    factors = np.linalg.cholesky(covariances)
    result: Array = np.linalg.solve(factors, vectors[:, :, None])[:, :, 0]
    return result


def residuals_of(calibration: tagcal.Calibration, dataset: tagcal.Dataset) -> Residuals:
    """Those of the answer (CalibratedView.residuals_px), and of rejected corners those of the board
    in its estimated shape. Raises Error if there are none, or if the data set is another one."""
    for name, value, kind in [
        ("calibration", calibration, tagcal.Calibration),
        ("dataset", dataset, tagcal.Dataset),
    ]:
        if not isinstance(value, kind):
            raise tagcal.Error(f"{name}: must be a {kind.__name__}, got {type(value).__name__}")
    if not calibration.views:
        raise tagcal.Error(f"calibration: has no views, so no residuals: {calibration}")
    rejected = {(outlier.view, outlier.corner) for outlier in calibration.outliers}
    all_points, all_pixels = dataset.to_points()
    if calibration.views[-1].view >= len(all_points):
        raise tagcal.Error("dataset: has fewer views than the calibration: it is another one")
    parts = []
    for found in calibration.views:
        points, pixels = all_points[found.view], all_pixels[found.view]
        if calibration.board_warp is not None:
            points = _bent(points, dataset.target, calibration.board_warp)
        vectors = pixels - _projected(calibration.camera, dataset.size, found, points)
        inlier = np.array([(found.view, i) not in rejected for i in range(len(points))])
        if np.count_nonzero(inlier) != len(found.residuals_px):
            raise tagcal.Error("dataset: has other corners than the calibration: it is another one")
        vectors[inlier] = -found.residuals_px
        whitened = _whitened(vectors, _noise(calibration, dataset.views[found.view]))
        parts.append((pixels, vectors, whitened, inlier))
    pixels, vectors, whitened, inliers = (np.concatenate(part) for part in zip(*parts))
    return Residuals(pixels, vectors, whitened, inliers.astype(bool))
