"""Cameras and motions, with OpenCV as a witness."""

import pickle

import cv2
import numpy as np
import pytest

import tagcal

RNG = np.random.default_rng(3)
POINTS = RNG.uniform([-1, -0.8, 1.5], [1, 0.8, 4], (500, 3))
MATRIX = np.array([[700, 0, 330], [0, 705, 236], [0, 0, 1.0]])
POSE = tagcal.Pose([0.1, -0.2, 0.3], [0.05, -0.1, 0.2])


RATIONAL = [-0.2, 0.06, 0.001, -0.0005, 0.01, 0.1, 0.02, 0.01]


# OpenCV returns its rational lens with six zeros.
@pytest.mark.parametrize("distortion", [[], [-0.2, 0.06], RATIONAL, RATIONAL + 6 * [0]])
def test_perspective_projects_as_opencv(distortion):
    camera = tagcal.Camera.from_matrix(MATRIX, (640, 480), distortion)
    pixels = camera.project(POINTS, POSE)
    padded = np.zeros(14)
    padded[: len(distortion)] = distortion
    expected, _ = cv2.projectPoints(POINTS, POSE.rotation_vector, POSE.translation, MATRIX, padded)
    assert np.allclose(pixels, expected[:, 0], atol=1e-9, rtol=0)


def test_fisheye_projects_as_opencv():
    coefficients = [0.01, -0.02, 0.003, -0.001]
    camera = tagcal.Camera.from_matrix(MATRIX, (640, 480), coefficients, fisheye=True)
    expected, _ = cv2.fisheye.projectPoints(
        POINTS[:, None], POSE.rotation_vector, POSE.translation, MATRIX, np.array(coefficients)
    )
    assert np.allclose(camera.project(POINTS, POSE), expected[:, 0], atol=1e-9, rtol=0)


def test_a_point_without_a_pixel_is_nan():
    camera = tagcal.Camera.pinhole(600, 600, 319.5, 239.5, (640, 480))
    pixels = camera.project([[0.1, 0, 2], [0.1, 0, -2], [np.nan, 0, 1]])
    assert pixels[0] == pytest.approx([349.5, 239.5])
    assert np.isnan(pixels[1:]).all()
    assert np.isnan(camera.unproject([[np.nan, 1]])).all()


def test_unproject_inverts_project():
    camera = tagcal.Camera.perspective(700, 705, 330, 236, (640, 480), [-0.2, 0.06, 0.001, -0.0005])
    rays = camera.unproject(camera.project(POINTS[:50]))
    assert np.allclose(rays, POINTS[:50] / np.linalg.norm(POINTS[:50], axis=1)[:, None], atol=1e-9)
    parallel = tagcal.Camera.parallel(100, 100, 50, 50, (100, 100))
    origins, directions = parallel.rays([[60, 50]])
    assert origins[0] == pytest.approx([0.1, 0, 0])
    assert directions[0] == pytest.approx([0, 0, 1])
    with pytest.raises(tagcal.Error, match="no common centre; use rays"):
        parallel.unproject([[60, 50]])


def test_jacobians_are_those_of_opencv():
    camera = tagcal.Camera.from_matrix(MATRIX, (640, 480), [-0.2, 0.06, 0.001, -0.0005])
    pixels, by_pose, by_parameters = camera.jacobians(POINTS, POSE, model="opencv4")
    rotation, translation = POSE.rotation_vector, POSE.translation
    _, jacobian = cv2.projectPoints(
        POINTS, rotation, translation, MATRIX, np.array([-0.2, 0.06, 0.001, -0.0005])
    )
    n = len(POINTS)
    assert by_pose.shape == (n, 2, 6) and by_parameters.shape == (n, 2, 8)
    assert np.allclose(by_pose[..., 3:], jacobian[:, 3:6].reshape(n, 2, 3), rtol=1e-6, atol=1e-6)
    assert np.allclose(by_parameters, jacobian[:, 6:14].reshape(n, 2, 8), rtol=1e-6, atol=1e-6)
    assert np.array_equal(pixels, camera.project(POINTS, POSE))
    with pytest.raises(tagcal.Error, match='"fisheye4" is no model of a perspective lens'):
        camera.jacobians(POINTS, model="fisheye4")


def test_out_is_filled_and_returned():
    camera = tagcal.Camera.pinhole(600, 600, 319.5, 239.5, (640, 480))
    for offset in (0, 1):  # 16-byte aligned, and not
        out = np.zeros(2 * len(POINTS) + 1)[offset : offset + 2 * len(POINTS)].reshape(-1, 2)
        assert camera.project(POINTS, out=out) is out
        assert np.array_equal(out, camera.project(POINTS))
    one = np.zeros(2)
    camera.project(POINTS[0], out=one)
    assert np.array_equal(one, out[0])
    assert camera.project(np.zeros((0, 3))).shape == (0, 2)


def test_a_camera_tells_what_it_is():
    camera = tagcal.Camera.perspective(700, 705, 330, 236, (640, 480), [-0.2])
    assert repr(camera) == "<Camera perspective 640 x 480 fx=700 fy=705 cx=330 cy=236 k1=-0.2>"
    assert camera.size == (640, 480)
    assert camera.parameters["k1"] == -0.2
    assert np.array_equal(camera.matrix, MATRIX)
    assert camera.distortion[0] == -0.2 and len(camera.distortion) == 8
    assert camera.to_dict()["lens"] == "perspective"
    assert pickle.loads(pickle.dumps(camera)) == camera
    assert camera.resized((320, 240)).matrix[0, 0] == pytest.approx(350)
    assert camera.contains([639.4, 0]) and not camera.contains([639.6, 0])


@pytest.mark.parametrize(
    "arguments, message",
    [
        ((0, 600, 0, 0, (640, 480)), "fx"),
        ((600, np.nan, 0, 0, (640, 480)), "fy"),
        ((600, 600, 0, 0, (640, 0)), "size: must be (width, height), whole numbers > 0, got (640, 0)"),
        ((600, 600, 0, 0, (640.5, 480)), "size: must be (width, height)"),
        ((600, 600, 0, 0, 640), "size: must have the shape (2,)"),
    ],
)
def test_a_camera_refuses(arguments, message):
    with pytest.raises(tagcal.Error) as error:
        tagcal.Camera.pinhole(*arguments)
    assert message in str(error.value)


def test_motions():
    a = tagcal.Pose([0.1, 0.2, 0.3], [1, 2, 3])
    b = tagcal.Pose.from_matrix(a.matrix)
    assert a.angle_to(b) < 1e-12 and a.distance_to(b) == 0
    assert np.allclose((a @ a.inverse()).matrix, np.eye(4), atol=1e-15)
    assert np.allclose(a.rotation_matrix, cv2.Rodrigues(np.array([0.1, 0.2, 0.3]))[0], atol=1e-12)
    assert np.allclose(a.transform(POINTS), POINTS @ a.rotation_matrix.T + a.translation)
    assert pickle.loads(pickle.dumps(a)) == a
    assert tagcal.Pose(a.quaternion, a.translation) == a
    assert tagcal.Pose(a.rotation_matrix, a.translation).angle_to(a) < 1e-12
    looking = tagcal.Pose.looking_at([0, 0, -2], [0, 0, 0], [0, 1, 0])
    assert np.allclose(looking.transform([0, 0, 0]), [0, 0, 2])
    with pytest.raises(tagcal.Error, match="rotation"):
        tagcal.Pose(2 * np.eye(3), [0, 0, 0])
    with pytest.raises(tagcal.Error, match="must not be the quaternion 0"):
        tagcal.Pose([0, 0, 0, 0], [0, 0, 0])
