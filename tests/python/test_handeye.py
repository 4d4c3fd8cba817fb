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


def desk_poses() -> tuple[list[tagcal.PoseEstimate], list[tagcal.Pose]]:
    dataset = tagcal.read_dataset(DESK).dataset
    camera = tagcal.calibrate(dataset)
    robot = tagcal.read_robot_poses(Path(DESK) / "robot.csv")
    return (
        [tagcal.estimate_view_pose(v, dataset.target, camera) for v in dataset.views],
        robot.base_from_hand,
    )


def test_poses_find_what_the_views_find() -> None:
    poses, robot = desk_poses()
    by_views = desk_on_a_robot()
    found = tagcal.calibrate_handeye_from_poses(poses, robot, "hand", threads=2)
    assert found.is_answer and found.num_corners == 0 and np.isnan(found.rms_px), found
    assert " px" not in repr(found) and " px" in repr(by_views)
    step = found.mount_from_camera.translation - by_views.mount_from_camera.translation
    assert np.abs(step).max() < 1e-4
    sigma, same = (np.sqrt(np.diag(f.covariance)) for f in (found, by_views))
    assert sigma == pytest.approx(same, rel=0.05)


def test_poses_of_another_program_count_by_their_covariance() -> None:
    poses, robot = desk_poses()
    best = [p.hypotheses[0] for p in poses]
    given = [(h.camera_from_target, h.noise_covariance) for h in best]
    found = tagcal.calibrate_handeye_from_poses(given, robot, "hand")
    same = tagcal.calibrate_handeye_from_poses(poses, robot, "hand")
    assert np.array_equal(found.mount_from_camera.matrix, same.mount_from_camera.matrix)
    matrices = [(pose.matrix, np.asarray(covariance).tolist()) for pose, covariance in given]
    wide = [(pose, 1e6 * covariance) for pose, covariance in given]
    again = tagcal.calibrate_handeye_from_poses(matrices, robot, "hand")
    assert again.covariance == pytest.approx(found.covariance, rel=1e-6, abs=1e-15)
    vague = tagcal.calibrate_handeye_from_poses(wide, robot, "hand")
    # Towards the board (z) the camera's place is as well known as the size of the print.
    assert np.all(np.diag(vague.covariance)[:5] > 4 * np.diag(found.covariance)[:5])


def test_a_view_without_a_pose_takes_no_part() -> None:
    poses, robot = desk_poses()
    given = [None if i == 3 else pose for i, pose in enumerate(poses)]
    found = tagcal.calibrate_handeye_from_poses(given, robot, "hand")
    assert found.is_answer and found.unusable == [3] and len(found.views) == 11


def test_poses_of_a_rig_share_its_covariance() -> None:
    dataset = tagcal.read_dataset(DESK).dataset
    lens = tagcal.calibrate(dataset).camera
    _, robot = desk_poses()
    place = tagcal.Pose([1, 0, 0, 0], [0.1, 0, 0])
    exact = tagcal.KnownRig([lens, lens], [tagcal.Pose(), place])
    loose = np.zeros((12, 12))
    loose[3:6, 3:6] = 1e-6 * np.eye(3)  # 1 mm of the first camera in the rig
    rig = tagcal.KnownRig([lens, lens], [tagcal.Pose(), place], covariance=loose)

    def sigma_m(known: tagcal.KnownRig) -> float:
        poses = [tagcal.estimate_rig_pose([v, None], dataset.target, known) for v in dataset.views]
        found = tagcal.calibrate_handeye_from_poses(poses, robot, "hand", rig=known)
        assert found.is_answer, found
        with pytest.raises(tagcal.Error, match="rig: is missing"):
            tagcal.calibrate_handeye_from_poses(poses, robot, "hand")
        return float(np.sqrt(found.covariance[3, 3]))

    assert sigma_m(rig) == pytest.approx(np.hypot(sigma_m(exact), 1e-3), rel=0.1)


def test_refuses_bad_poses() -> None:
    poses, robot = desk_poses()
    pose = tagcal.Pose()
    for bad, words in [
        (1, "poses: must be PoseEstimate"),
        ((pose, np.zeros((3, 3))), r"must have the shape .*6, 6"),
        ((pose, np.zeros((6, 6))), "positive definite"),
        ((pose, None), "poses"),
        ((1, np.eye(6)), "poses"),
    ]:
        with pytest.raises(tagcal.Error, match=words):
            tagcal.calibrate_handeye_from_poses([bad, *poses[1:]], robot, "hand")  # type: ignore
    with pytest.raises(tagcal.Error, match="must have 12 poses"):
        tagcal.calibrate_handeye_from_poses(poses, robot[1:], "hand")


def test_refuses_bad_arguments() -> None:
    dataset = tagcal.read_dataset(DESK).dataset
    camera = tagcal.calibrate(dataset)
    with pytest.raises(tagcal.Error, match="must have 12 poses"):
        tagcal.calibrate_handeye(dataset.views, dataset.target, camera, [], "hand")
    with pytest.raises(tagcal.Error, match="mount"):
        tagcal.calibrate_handeye(dataset.views, dataset.target, camera, [], "arm")
