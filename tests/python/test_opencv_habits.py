"""Arrays as users of OpenCV have them are taken where they have one meaning."""

import cv2
import numpy as np
import pytest
import tagcal

CAMERA = tagcal.Camera.pinhole(500, 500, 199.5, 149.5, (400, 300))
BOARD = tagcal.Board.tag(0.08, 7)
POSE = tagcal.Pose([np.pi, 0.1, 0.2], [0.01, 0.02, 0.3])
PICTURE = tagcal.render(tagcal.Scene(CAMERA, BOARD, POSE))


@pytest.mark.parametrize("code", [cv2.COLOR_GRAY2BGR, cv2.COLOR_GRAY2BGRA])
def test_colour_pictures_are_searched(code):
    grey = tagcal.detect(PICTURE, BOARD)
    assert len(grey) == 4
    colour = tagcal.detect(cv2.cvtColor(PICTURE, code), BOARD)
    assert np.array_equal(colour.pixels, grey.pixels)
    view = np.ascontiguousarray(cv2.cvtColor(PICTURE, code)[:, ::-1])[:, ::-1]  # any strides
    assert np.array_equal(tagcal.detect(view, BOARD).pixels, grey.pixels)
    wide = PICTURE.astype(np.uint16) * 256
    expected = tagcal.detect(wide, BOARD).pixels
    assert np.array_equal(tagcal.detect(cv2.cvtColor(wide, code), BOARD).pixels, expected)


def test_bgr_and_rgb_give_the_same_corners():
    tinted = np.stack([PICTURE, PICTURE // 2 + 60, PICTURE // 3 + 30], axis=2)
    blue_first = tagcal.detect(tinted, BOARD)
    red_first = tagcal.detect(np.ascontiguousarray(tinted[:, :, ::-1]), BOARD)
    assert len(blue_first) == 4
    assert np.array_equal(blue_first.pixels, red_first.pixels)


def test_other_shapes_of_pictures_are_refused():
    for shape in ((30, 40, 2), (30, 40, 5), (1, 30, 40, 3), (30,)):
        with pytest.raises(tagcal.Error, match="image: must "):
            tagcal.detect(np.zeros(shape, np.uint8), BOARD)


def test_no_distortion_is_none():
    k = CAMERA.matrix
    assert tagcal.Camera.from_matrix(k, (400, 300), None) == CAMERA
    assert tagcal.Camera.perspective(500, 500, 199.5, 149.5, (400, 300), distortion=None) == CAMERA
    assert tagcal.Camera.fisheye(500, 500, 199.5, 149.5, (400, 300), None).lens == "fisheye"


@pytest.mark.parametrize("shape", [(5,), (1, 5), (5, 1)])
def test_distortion_is_a_row_or_a_column(shape):
    coefficients = np.array([-0.1, 0.01, 0, 0, 0.001]).reshape(shape)
    camera = tagcal.Camera.perspective(500, 500, 199.5, 149.5, (400, 300), coefficients)
    assert camera.parameters["k3"] == 0.001
    assert tagcal.Camera.from_matrix(CAMERA.matrix, (400, 300), coefficients) == camera


def test_poses_are_matrices_or_vectors_of_any_shape():
    assert tagcal.Pose(np.eye(4)) == tagcal.Pose()
    assert tagcal.Pose(POSE.matrix).angle_to(POSE) < 1e-12
    assert tagcal.Pose(POSE) == POSE
    assert POSE.distance_to(POSE.matrix) == 0
    points = np.array([[-0.04, -0.04, 0], [0.04, -0.04, 0], [0.04, 0.04, 0], [-0.04, 0.04, 0]])
    pixels = CAMERA.project(points, POSE)
    assert np.abs(CAMERA.project(points, POSE.matrix) - pixels).max() < 1e-9
    _, rvec, tvec = cv2.solvePnP(points, pixels, CAMERA.matrix, None)
    assert rvec.shape == (3, 1)
    assert tagcal.Pose(rvec, tvec).distance_to(POSE) < 1e-6
    assert tagcal.Pose(rvec.T, tvec.T) == tagcal.Pose(rvec.ravel(), tvec.ravel())
    with pytest.raises(tagcal.Error, match=r"matrix: must have the shape \(4, 4\), got \(3, 3\)"):
        tagcal.Pose(np.eye(3))


def test_pixels_outside_of_the_image():
    pixels = [[-50, 5000], [0, 0], [-0.5, 299.4], [400, 10], [np.nan, 3]]
    assert CAMERA.contains(pixels).tolist() == [False, True, True, False, False]
    assert CAMERA.contains([10, 10]) is True
    assert np.isfinite(CAMERA.unproject(pixels[0])).all()  # a ray all the same
