"""Data sets from views, and from OpenCV's lists of points and pixels."""

import numpy as np
import pytest
import tagcal

SIZE = (640, 480)
BOARD = np.array([[0.03 * x, 0.03 * y, 0.0] for y in range(4) for x in range(5)])


def pixels_of(points: np.ndarray, view: int) -> np.ndarray:
    camera = tagcal.Camera.pinhole(600, 600, 319.5, 239.5, SIZE)
    pose = tagcal.Pose([0.1 * view, 0.2, 0.0], [-0.05, -0.05, 0.6])
    return camera.project(points, pose)


def test_lists_of_opencv_give_a_data_set_and_come_back() -> None:
    points = [BOARD, BOARD[5:], BOARD[::2]]
    pixels = [pixels_of(p, v) for v, p in enumerate(points)]
    data = tagcal.Dataset.from_points(points, pixels, SIZE, images=["a", "b", "c"])
    assert repr(data) == "<Dataset 640 x 480, 1 board, 3 views, 45 corners>"
    assert len(data) == 3 and data.size == SIZE and data.truth is None
    assert [view.image for view in data.views] == ["a", "b", "c"]
    assert data.views[1].ids[:, 0].tolist() == list(range(5, 20))
    back_points, back_pixels = data.to_points()
    for v in range(3):
        np.testing.assert_array_equal(back_points[v], points[v])
        np.testing.assert_array_equal(back_pixels[v], pixels[v])


def as_opencv_finds_them(array: np.ndarray) -> np.ndarray:
    return array.astype(np.float32).reshape(-1, 1, array.shape[1])


def test_every_shape_of_opencv_is_taken() -> None:
    pixels = [pixels_of(BOARD, v) for v in range(2)]
    expected = tagcal.Dataset.from_points([BOARD, BOARD], pixels, SIZE)
    same = [
        (BOARD, pixels),
        (np.array([BOARD, BOARD]), np.array(pixels)),
        ([BOARD[None], BOARD[None]], [p[None] for p in pixels]),
        ((BOARD[:, None], BOARD[:, None]), tuple(p[:, None] for p in pixels)),
        ([BOARD.tolist(), BOARD.tolist()], [p.tolist() for p in pixels]),
    ]
    for object_points, image_points in same:
        data = tagcal.Dataset.from_points(object_points, image_points, SIZE)
        np.testing.assert_array_equal(data.views[1].ids, expected.views[1].ids)
        np.testing.assert_array_equal(data.views[1].pixels, expected.views[1].pixels)
    found = [as_opencv_finds_them(p) for p in pixels]
    data = tagcal.Dataset.from_points([as_opencv_finds_them(BOARD)] * 2, found, SIZE)
    np.testing.assert_array_equal(data.views[1].pixels, pixels[1].astype(np.float32))


def test_a_data_set_is_made_of_its_parts() -> None:
    whole = tagcal.Dataset.from_points(BOARD, [pixels_of(BOARD, v) for v in range(3)], SIZE)
    camera = tagcal.Camera.pinhole(600, 600, 319.5, 239.5, SIZE)
    truth = tagcal.Truth(camera, {"a": tagcal.Pose()})
    part = tagcal.Dataset(whole.size, whole.target, whole.views[1:], truth)
    assert len(part) == 2 and part.truth.camera == camera
    assert part.truth.camera_from_world == {"a": tagcal.Pose()}
    assert repr(part).endswith("40 corners, with truth>")
    with pytest.raises(tagcal.Error, match="^truth: its camera must have the size of the data set"):
        tagcal.Dataset((64, 48), whole.target, [], truth)
    stranger = tagcal.View([(77, 0)], [(1.0, 2.0)])
    with pytest.raises(tagcal.Error, match=r"^views\[0\]: has the corner \(77, 0\), which the "):
        tagcal.Dataset(SIZE, whole.target, [stranger])


@pytest.mark.parametrize(
    "points, pixels, message",
    [
        ([BOARD], [], r"image_points: must have as many views as object_points \(1\), got 0"),
        ([BOARD[:, :2]], [BOARD[:, :2]], r"object_points\[0\]: must have the shape \(N, 3\), got"),
        ([BOARD], [BOARD[1:, :2]], r"image_points\[0\]: must have as many rows as object_points"),
        (BOARD, [BOARD[1:, :2]], r"image_points\[0\]: must have as many rows as object_points \(2"),
        (3, [BOARD], "object_points: must be a list of arrays, one for each view, got int"),
        ([BOARD], None, "image_points: must be a list of arrays, one for each view, got NoneType"),
        ([None], [None], r"object_points\[0\]: must be an array, got None"),
        ([BOARD * np.nan], [BOARD[:, :2]], r"object_points\[0\]: must be finite, got nan in row 0"),
        ([BOARD[:2]], [[[1, 2], [np.inf, 4]]], r"image_points\[0\]: must be finite, got inf in ro"),
        ([BOARD * 0], [BOARD[:, :2]], r"view 0: the point \(0, 0, 0\) occurs twice"),
    ],
)
def test_lists_that_are_refused(points: object, pixels: object, message: str) -> None:
    with pytest.raises(tagcal.Error, match="^" + message) as error:
        tagcal.Dataset.from_points(points, pixels, SIZE)
    assert "\n" not in str(error.value)


def test_height_and_width_in_the_wrong_order_are_named() -> None:
    pixels = [pixels_of(BOARD, 0) + [250, 0]]
    message = r"the pixel \(.*\) is outside the image; size, \(width, height\), is \(480, 640\)"
    with pytest.raises(tagcal.Error, match=r"^image_points\[0\]: " + message):
        tagcal.Dataset.from_points(BOARD, pixels, SIZE[::-1])
    data = tagcal.Dataset.from_points(BOARD, pixels, SIZE)
    with pytest.raises(tagcal.Error, match=r"^views\[0\]: " + message):
        tagcal.Dataset(SIZE[::-1], data.target, data.views)


def test_names_and_sizes_are_checked() -> None:
    pixels = [pixels_of(BOARD, 0)]
    with pytest.raises(tagcal.Error, match=r"^images: must have a name for each view \(1\), got 2"):
        tagcal.Dataset.from_points(BOARD, pixels, SIZE, images=["a", "b"])
    with pytest.raises(tagcal.Error, match=r"^size: must be \(width, height\)"):
        tagcal.Dataset.from_points(BOARD, pixels, (0, 480))
