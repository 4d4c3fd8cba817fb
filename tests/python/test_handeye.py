"""calibrate_handeye, on the data set of the desk, whose camera is on a robot's hand."""

from pathlib import Path

import numpy as np
import pytest
import tagcal
from desk import DESK

HAND_FROM_CAMERA_M = [0.045, -0.062, 0.085]  # data-synthetic/golden/README.md


def desk_on_a_robot(mount: str = "hand") -> tagcal.HandeyeCalibration:
    dataset = tagcal.read_dataset(DESK).dataset
    robot = tagcal.read_robot_poses(Path(DESK) / "robot.csv")
    assert robot.images == [v.image for v in dataset.views]
    camera = tagcal.calibrate(dataset).uncertain_camera
    return tagcal.calibrate_handeye(
        dataset.views, dataset.target, camera, robot.base_from_hand, mount
    )


def test_finds_the_camera_in_the_hand() -> None:
    found = desk_on_a_robot()
    assert found.is_answer, found
    error = found.mount_from_camera.translation - HAND_FROM_CAMERA_M
    assert np.all(np.abs(error) < 4 * np.sqrt(np.diag(found.covariance)[3:6]))
    assert found.robot_sigma_m == pytest.approx(0.5e-3, abs=0.3e-3)
    assert found.next is not None and "move the hand" in found.next.sentence
    assert "mount_from_camera" in found.to_yaml()


def test_names_the_reading_that_fits() -> None:
    found = desk_on_a_robot("base")
    assert found.status == "wrong_direction"
    assert found.reading is not None and "mount hand" in found.reading.change
    with pytest.raises(tagcal.Error, match="there is no answer"):
        found.to_yaml()


def test_refuses_bad_arguments() -> None:
    dataset = tagcal.read_dataset(DESK).dataset
    camera = tagcal.calibrate(dataset)
    with pytest.raises(tagcal.Error, match="must have 12 poses"):
        tagcal.calibrate_handeye(dataset.views, dataset.target, camera, [], "hand")
    with pytest.raises(tagcal.Error, match="mount"):
        tagcal.calibrate_handeye(dataset.views, dataset.target, camera, [], "arm")
