"""A program of a user, checked by `mypy --strict` in test_types.py and run there."""

import numpy as np
import tagcal
from numpy.typing import NDArray


def tag_corners(side_m: float) -> NDArray[np.float64]:
    return side_m / 2 * np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], float)


def main() -> None:
    camera = tagcal.Camera.perspective(600, 600, 319.5, 239.5, size=(640, 480), distortion=[0.01])
    truth = tagcal.Pose.looking_at(eye=[0.2, 0.1, 0.6], target=[0, 0, 0], up=[0, 1, 0])
    points = tag_corners(0.08)
    pixels: NDArray[np.float64] = camera.project(points, truth)
    camera.project(points, camera_from_points=truth.matrix, out=pixels)
    origins, directions = camera.rays(pixels)
    assert origins.shape == directions.shape

    estimate: tagcal.PoseEstimate = tagcal.estimate_pose(points, pixels, camera, sigma_px=0.1)
    sentences: list[str] = [finding.sentence for finding in estimate.findings]
    angle: float = estimate.camera_from_target.angle_to(truth)
    print(estimate.status, len(sentences), f"{angle:.1e}")
    try:
        tagcal.Pose.from_matrix(np.eye(3))
    except tagcal.Error as error:
        print(error)


if __name__ == "__main__":
    main()
