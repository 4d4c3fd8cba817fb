"""calibrate_rig, on corners that cv2.projectPoints makes."""

from pathlib import Path

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


def test_the_pose_of_a_rig() -> None:
    sets = datasets()
    answer = tagcal.calibrate_rig(sets)
    rig = tagcal.known_rig(answer)
    views = [s.views[3] for s in sets]
    pose = tagcal.estimate_rig_pose(views, sets[0].target, rig)
    assert pose.rig.is_answer, pose
    assert pose.takes_part == [True, True]
    assert "ok, by 2 cameras" in repr(pose)
    alone = tagcal.estimate_rig_pose([views[0], None], sets[0].target, rig)
    assert alone.takes_part == [True, False]
    assert alone.of_cameras[1].status == "degenerate"
    both, one = (p.rig.hypotheses[0] for p in (pose, alone))
    assert both.camera_from_target.distance_to(one.camera_from_target) < 0.01


def test_a_rig_of_a_file_and_of_its_parts(tmp_path: Path) -> None:
    answer = tagcal.calibrate_rig(datasets())
    rig = tagcal.known_rig(answer)
    (tmp_path / "rig.yaml").write_text(answer.to_yaml())
    of_file = tagcal.known_rig(tmp_path / "rig.yaml")
    np.testing.assert_allclose(of_file.covariance, rig.covariance, rtol=1e-4, atol=1e-14)
    assert [c.name for c in of_file.cameras] == ["cam0", "cam1"]
    places = [c.camera_from_rig for c in answer.cameras]
    made = tagcal.KnownRig([c.camera for c in answer.cameras], places, covariance=np.eye(12))
    assert made.covariance.shape == (12, 12)
    assert made.cameras[1].claim is None
    for arguments in [([], [None]), ([c.camera for c in answer.cameras], places[:1])]:
        with pytest.raises(tagcal.Error, match="camera_from_rig"):
            tagcal.KnownRig(*arguments)
    with pytest.raises(tagcal.Error, match="covariance"):
        tagcal.KnownRig([c.camera for c in answer.cameras], places, covariance=np.eye(6))
    with pytest.raises(tagcal.Error, match="views"):
        tagcal.estimate_rig_pose([None], datasets(1)[0].target, rig)


def test_the_advised_pair_is_of_these_cameras() -> None:
    following = tagcal.calibrate_rig(datasets(), names=["left", "right"]).next
    assert following is not None
    assert following.sentence.startswith("show the board to left and right at the same time")


def test_wrong_arguments_are_named() -> None:
    sets = datasets(6)
    for arguments in [{"pair": "both"}, {"names": ["a"]}, {"reference": 2}, {"reference": -1},
                      {"pair": "time"}, {"find_clocks": True}, {"find_readouts": True}]:  # fmt: skip
        with pytest.raises(tagcal.Error):
            tagcal.calibrate_rig(sets, **arguments)  # type: ignore[arg-type]
    with pytest.raises(tagcal.Error):
        tagcal.calibrate_rig([])


def test_a_rectified_pair_is_that_of_opencv() -> None:
    cameras = [tagcal.Camera.pinhole(600, 601, 320, 240, SIZE),
               tagcal.Camera.pinhole(610, 612, 330, 238, SIZE)]
    rotation, translation = cv2.Rodrigues(SECOND_FROM_FIRST[0])[0], SECOND_FROM_FIRST[1]
    matrix = np.vstack([np.hstack([rotation, translation]), [0, 0, 0, 1]])
    rig = tagcal.KnownRig(cameras, [np.eye(4), matrix])
    pair = tagcal.rectify(rig)
    matrices = [np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1.0]])
                for fx, fy, cx, cy in [(600, 601, 320, 240), (610, 612, 330, 238)]]
    none = np.zeros(5)
    theirs = cv2.stereoRectify(matrices[0], none, matrices[1], none, SIZE, rotation, translation,
                               alpha=-1)[:5]
    for ours, their in zip([*pair.R, *pair.P, pair.Q], theirs):
        assert np.allclose(ours, their, rtol=0, atol=1e-9)
    x = np.array([0.1, 0.2, 2])
    pixels = [camera.project(x[None])[0] if camera is cameras[0]
              else camera.project((rotation @ x + translation[:, 0])[None])[0] for camera in cameras]
    found = tagcal.vertical_disparity(rig, pair, *pixels, sigma_px=0.1)
    assert abs(found.difference_px) < 1e-9 < found.sigma_px
    assert found.sigma_of_rig_px == 0
    assert tagcal.rectify(rig, longlat=True).targets[0].kind == "transverse"
    with pytest.raises(tagcal.Error, match="alpha must be from 0 to 1"):
        tagcal.rectify(rig, alpha=2)
    with pytest.raises(tagcal.Error, match="of pinholes only"):
        print(tagcal.rectify(rig, longlat=True).Q)


def test_triangulates_a_corner() -> None:
    sets = datasets()
    rig = tagcal.known_rig(tagcal.calibrate_rig(sets))
    views = [s.views[3] for s in sets]
    point = tagcal.triangulate(rig, [v.pixels[7] for v in views], sigma_px=0.1)
    assert point.status == "ok"
    pose = tagcal.estimate_rig_pose(views, sets[0].target, rig).rig.camera_from_target
    board = tagcal.Board.checkerboard(9, 6, 0.05)
    off = point.x - (pose.rotation_matrix @ board.positions[7] + pose.translation)
    assert off @ np.linalg.solve(point.covariance, off) < 25
    assert point.contradicting == []
    assert tagcal.triangulate(rig, [views[0].pixels[7], None]).status == "few_cameras"
    with pytest.raises(tagcal.Error, match="must have 2 items"):
        tagcal.triangulate(rig, [None])
