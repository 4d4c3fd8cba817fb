"""Poses, focal lengths and minimal solvers."""

import threading

import cv2
import numpy as np
import pytest

import tagcal
from desk import command_json

HALF = 0.05
TAG = HALF * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]], dtype=float)
CAMERA = tagcal.Camera.pinhole(600, 600, 319.5, 239.5, (640, 480))
POSE = tagcal.Pose([0.6, 0.4, 0.1], [0.02, 0.03, 0.6])
BOX = np.array([[x, y, z] for x in (0, 0.1) for y in (0, 0.12) for z in (0, 0.08)])


def test_exact_pixels_give_the_pose():
    estimate = tagcal.estimate_pose(TAG, CAMERA.project(TAG, POSE), CAMERA, sigma_px=0.1)
    assert estimate.is_answer and estimate.status == "ok"
    assert estimate.camera_from_target.angle_to(POSE) < 1e-9
    assert estimate.camera_from_target.distance_to(POSE) < 1e-9
    assert estimate.sigma_px == 0.1
    best = estimate.hypotheses[0]
    assert best.covariance.shape == (6, 6) and np.linalg.eigvalsh(best.covariance).min() > 0
    assert repr(estimate).startswith("<PoseEstimate ok, target at (0.02, 0.03, 0.6) m")
    assert estimate.to_dict()["hypotheses"][0]["camera_from_target"]["translation"][2] == pytest.approx(0.6)


def test_opencv_agrees_where_noise_is_small():
    pixels = CAMERA.project(BOX, POSE) + np.random.default_rng(1).normal(0, 0.01, (8, 2))
    ours = tagcal.estimate_pose(BOX, pixels, CAMERA, sigma_px=0.01).camera_from_target
    _, rotation, translation = cv2.solvePnP(BOX, pixels, CAMERA.matrix, None)
    theirs = tagcal.Pose(rotation.ravel(), translation.ravel())
    assert ours.angle_to(theirs) < 1e-5 and ours.distance_to(theirs) < 1e-5


def test_two_poses_of_a_small_tag_have_odds():
    far = tagcal.Pose([0.3, 0.1, 0], [0, 0, 4])
    pixels = CAMERA.project(TAG, far) + np.random.default_rng(2).normal(0, 0.5, (4, 2))
    estimate = tagcal.estimate_pose(TAG, pixels, CAMERA, sigma_px=0.5)
    assert estimate.status == "ambiguous"
    assert sum(h.probability for h in estimate.hypotheses) == pytest.approx(1)
    assert "of 2 poses" in repr(estimate)


def test_no_answer_is_said():
    line = np.array([[i, 0, 0] for i in range(5)]) * 0.1
    estimate = tagcal.estimate_pose(line, CAMERA.project(line, POSE), CAMERA)
    assert estimate.status == "degenerate" and not estimate.is_answer
    assert estimate.hypotheses == []
    assert [f.severity for f in estimate.findings if f.severity == "refusal"]
    with pytest.raises(tagcal.Error, match="no answer: degenerate: "):
        estimate.camera_from_target
    assert "no answer" in repr(estimate)


def test_a_wrong_corner_is_rejected():
    pixels = CAMERA.project(BOX, POSE)
    pixels[3] += 40
    estimate = tagcal.estimate_pose(BOX, pixels, CAMERA, sigma_px=0.1)
    assert estimate.outliers == [3]
    assert estimate.camera_from_target.angle_to(POSE) < 1e-6


def test_covariances_and_groups():
    pixels = CAMERA.project(BOX, POSE)
    same = tagcal.estimate_pose(BOX, pixels, CAMERA, sigma_px=0.2).hypotheses[0].covariance
    one = tagcal.estimate_pose(BOX, pixels, CAMERA, covariances=0.04 * np.eye(2)).hypotheses[0]
    assert np.allclose(one.covariance, same, rtol=1e-6)
    each = np.tile(0.04 * np.eye(2), (8, 1, 1))
    grouped = tagcal.estimate_pose(BOX, pixels, CAMERA, covariances=each, groups=range(8))
    assert np.allclose(grouped.hypotheses[0].covariance, same, rtol=1e-6)


def test_each_corner_counts_with_its_own_covariance():
    pixels = CAMERA.project(BOX, POSE) + np.random.default_rng(6).normal(0, 0.2, (8, 2))
    each = np.tile(0.04 * np.eye(2), (8, 1, 1))
    each[3] *= 1e8  # as good as not seen
    all_corners = tagcal.estimate_pose(BOX, pixels, CAMERA, covariances=each).hypotheses[0]
    others = [0, 1, 2, 4, 5, 6, 7]
    seven = tagcal.estimate_pose(BOX[others], pixels[others], CAMERA, covariances=0.04 * np.eye(2)).hypotheses[0]
    assert all_corners.camera_from_target.angle_to(seven.camera_from_target) < 1e-6
    assert np.allclose(all_corners.covariance, seven.covariance, rtol=1e-4, atol=1e-14)


def test_a_wrong_corner_is_kept_if_all_are_asked_for():
    pixels = CAMERA.project(BOX, POSE)
    pixels[3] += 40
    kept = tagcal.estimate_pose(BOX, pixels, CAMERA, sigma_px=0.1, reject_outliers=False)
    assert kept.outliers == []


def test_many_targets_in_one_call():
    rng = np.random.default_rng(4)
    poses = [tagcal.Pose([0.6, a, 0], [0, 0, 0.7]) for a in np.linspace(-0.5, 0.5, 30)]
    pixels = np.array([CAMERA.project(TAG, pose) for pose in poses]) + rng.normal(0, 0.1, (30, 4, 2))
    pixels[7] = pixels[7, :1]  # four times the same pixel
    all_at_once = tagcal.estimate_poses(TAG, pixels, CAMERA, sigma_px=0.1)
    in_threads = tagcal.estimate_poses(np.tile(TAG, (30, 1, 1)), pixels, CAMERA, sigma_px=0.1, threads=2)
    assert len(all_at_once) == 30
    assert np.array_equal(all_at_once.camera_from_target, in_threads.camera_from_target, equal_nan=True)
    for i, pixel in enumerate(pixels):
        one = tagcal.estimate_pose(TAG, pixel, CAMERA, sigma_px=0.1)
        assert one.status == all_at_once.status[i] == all_at_once[i].status
        if one.is_answer:
            assert np.array_equal(one.camera_from_target.matrix, all_at_once.camera_from_target[i])
            assert np.array_equal(one.hypotheses[0].covariance, all_at_once.covariance[i])
        else:
            assert i == 7 and np.isnan(all_at_once.camera_from_target[i]).all()
    with pytest.raises(IndexError):
        all_at_once[30]
    with pytest.raises(tagcal.Error, match=r"pixels: must have the shape \(N, M, 2\), got \(4, 2\)"):
        tagcal.estimate_poses(TAG, pixels[0], CAMERA)


def test_pose_and_focal_length():
    estimate = tagcal.estimate_pose_and_focal(BOX, CAMERA.project(BOX, POSE), (640, 480), sigma_px=0.1)
    assert estimate.is_answer
    assert estimate.focal_px == pytest.approx(600, abs=1e-3)
    assert 0 < estimate.sigma_focal_px < 60
    frontal = CAMERA.project(TAG, tagcal.Pose([0, 0, 0], [0, 0, 1]))
    refused = tagcal.estimate_pose_and_focal(TAG, frontal, (640, 480), sigma_px=0.1)
    assert refused.status == "focal_not_observable" and refused.focal_px == 0


def test_the_pose_of_a_view():
    with pytest.raises(tagcal.Error, match="target: must be a Board, a PlacedBoard or a list of these, got int"):
        tagcal.estimate_view_pose(tagcal.View([], np.zeros((0, 2))), 1, CAMERA)


def test_solvers_find_the_truth():
    def found(poses):
        return min(pose.angle_to(POSE) + pose.distance_to(POSE) for pose in poses) < 1e-6

    rays = CAMERA.unproject(CAMERA.project(BOX, POSE))
    assert found(tagcal.p3p(BOX[[0, 3, 5]], rays[[0, 3, 5]]))
    assert found(tagcal.pnp(BOX, rays))
    homography = tagcal.homography(TAG[:, :2], CAMERA.unproject(CAMERA.project(TAG, POSE)))
    assert found(tagcal.ippe(homography))
    centred = CAMERA.project(BOX, POSE) - [319.5, 239.5]
    assert found([pose for pose, focal in tagcal.p4pf(BOX[[0, 3, 5, 6]], centred[[0, 3, 5, 6]])])
    pose, focal = tagcal.plane_pose_and_focal(TAG[:, :2], CAMERA.project(TAG, POSE) - [319.5, 239.5])
    assert found([pose]) and focal == pytest.approx(600)
    assert len(tagcal.weak_perspective_poses(TAG, CAMERA.project(TAG, POSE) - [319.5, 239.5])) == 2
    with pytest.raises(tagcal.Error, match="points: must have 3 rows, got 8"):
        tagcal.p3p(BOX, rays)


def test_threads_give_the_answers_of_one():
    pixels = CAMERA.project(BOX, POSE) + np.random.default_rng(5).normal(0, 0.3, (200, 8, 2))
    expected = tagcal.estimate_poses(BOX, pixels, CAMERA).camera_from_target
    results = [None, None]

    def work(k):
        results[k] = tagcal.estimate_poses(BOX, pixels, CAMERA).camera_from_target

    threads = [threading.Thread(target=work, args=(k,)) for k in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(result, expected) for result in results)


def test_answers_are_those_of_cpp_to_the_last_bit(tmp_path):
    """The command prints doubles with all of their digits."""
    camera = tagcal.Camera.perspective(700, 705, 330, 236, (640, 480), [-0.2, 0.06, 0.001, -0.0005])
    random = np.random.default_rng(4)
    tagcal.write_camera(tmp_path / "camera.yaml", camera)
    points = random.uniform([-1, -1, -0.1], [1, 1, 4], (5000, 3))
    np.savetxt(tmp_path / "points.csv", points, "%.17g", ",", header="x_m,y_m,z_m", comments="")
    given = [tmp_path / "points.csv", "--camera", tmp_path / "camera.yaml"]
    rows = command_json("project", *given)["points"]
    pixels = np.array([(row["u_px"], row["v_px"]) for row in rows], dtype=float)  # None: nan
    assert np.isnan(pixels).any()
    assert np.array_equal(camera.project(points), pixels, equal_nan=True)

    tag, views = tagcal.Board.tag(2 * HALF), []
    for i in range(300):
        place = random.uniform([0.4, -3, 0.6], [1.5, 3, 1.5])
        seen = camera.project(tag.positions, tagcal.Pose.on_orbit([0, 0, 0], *place))
        views.append(tagcal.View(tag.ids, seen + random.normal(0, 0.1, (4, 2)), image=f"{i}.png"))
    tagcal.write_dataset(tmp_path / "tags", tagcal.Dataset((640, 480), tag, views))
    told = command_json("pose", tmp_path / "tags", "--camera", given[2], "--sigma-px", 0.1)["views"]
    assert [view.image for view in views] == [answer["image"] for answer in told]
    for view, answer in zip(views, told):
        best = tagcal.estimate_pose(tag.positions, view.pixels, camera, 0.1).hypotheses[0]
        pose, shown = best.camera_from_target, answer["camera_from_board"]
        quaternion = pose.quaternion if pose.quaternion[0] >= 0 else -pose.quaternion  # as printed
        assert np.array_equal(quaternion, shown["rotation"])
        assert np.array_equal(pose.translation, shown["translation_m"])
        assert np.array_equal(best.covariance, answer["covariance"])
