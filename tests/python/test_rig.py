"""calibrate_rig, on corners that cv2.projectPoints makes."""

import cv2
import numpy as np
import pytest
import tagcal
from desk import DISTORTION, SIZE, K

SECOND_FROM_FIRST = np.array([[0.02], [-0.1], [0.03]]), np.array([[-0.12], [0.004], [0.01]])


def datasets(num_instants: int = 14) -> list[tagcal.Dataset]:
    random = np.random.default_rng(3)
    board = tagcal.Board.checkerboard(9, 6, 0.05)
    ids, x = board.ids, board.positions
    views: list[list[tagcal.View]] = [[], []]
    for i in range(num_instants):
        rotation = random.uniform(-0.5, 0.5, (3, 1)) + [[np.pi], [0], [0]]
        centre = cv2.Rodrigues(rotation)[0] @ x.mean(axis=0)
        translation = np.array([0, 0, 0.9]) + random.uniform(-0.15, 0.15, 3) - centre
        first = rotation, translation.reshape(3, 1)
        second = cv2.composeRT(*first, *SECOND_FROM_FIRST)[:2]
        for camera, pose in enumerate([first, second]):
            pixels = cv2.projectPoints(x, *pose, K, DISTORTION)[0][:, 0]
            pixels = pixels + random.normal(0, 0.1, pixels.shape)
            views[camera].append(tagcal.View(ids, pixels, image=f"{i:03d}.png"))
    return [tagcal.Dataset(SIZE, board, v) for v in views]


def test_finds_the_second_camera() -> None:
    rig = tagcal.calibrate_rig(datasets(), names=["left", "right"])
    assert rig.is_answer, rig
    right = rig.cameras[1]
    assert right.name == "right"
    error = right.camera_from_rig.translation - SECOND_FROM_FIRST[1][:, 0]
    assert np.all(np.abs(error) < 5 * np.sqrt(np.diag(right.covariance)[3:]))
    assert rig.pairs[0].baseline_m == pytest.approx(np.linalg.norm(SECOND_FROM_FIRST[1]), abs=2e-3)
    assert rig.covariance.shape[0] >= 6
    assert "cameras:" in rig.to_yaml()
    assert "2 cameras" in repr(rig)


def test_known_cameras_are_held() -> None:
    sets = datasets()
    known = [tagcal.calibrate(s).uncertain_camera for s in sets]
    rig = tagcal.calibrate_rig(sets, cameras=known)
    assert rig.is_answer, rig
    assert rig.cameras[0].camera.parameters == known[0].camera.parameters


def test_wrong_arguments_are_named() -> None:
    sets = datasets(6)
    for arguments in [{"pair": "both"}, {"names": ["a"]}, {"reference": 2}, {"reference": -1},
                      {"pair": "time"}, {"find_clocks": True}]:  # fmt: skip
        with pytest.raises(tagcal.Error):
            tagcal.calibrate_rig(sets, **arguments)  # type: ignore[arg-type]
    with pytest.raises(tagcal.Error):
        tagcal.calibrate_rig([])
