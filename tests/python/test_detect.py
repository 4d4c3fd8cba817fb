"""Corners in rendered pictures against the exact ones, and wrong arguments."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
import tagcal
from numpy.typing import NDArray
from tagcal import Board

CAMERA = tagcal.Camera.perspective(500, 505, 201, 148, (400, 300), [-0.1, 0.02])
POSE = tagcal.Pose.looking_at([0.15, -0.1, 0.35], [0.1, 0.075, 0], [0, 0, 1])
SENSOR = tagcal.Sensor(blur_px=0.7, noise_levels=2)
GRID = Board.grid(3, 2, 0.06, 0.3)
SCENE = tagcal.Scene(CAMERA, GRID, POSE, sensor=SENSOR)
IMAGE = tagcal.render(SCENE)
EXACT = tagcal.visible_corners(SCENE)
OTHERS = {
    "checkerboard": Board.checkerboard(6, 5, 0.03),
    "charuco": Board.charuco(6, 5, 0.03, 0.022, "DICT_4X4_50"),
    "tag": Board.tags([11], 0.12, [tagcal.Pose([0.0, 0, 0], [0.1, 0.075, 0])]),
}


def test_corners_of_a_picture_are_the_exact_ones() -> None:
    view = tagcal.detect(IMAGE, GRID, CAMERA)
    np.testing.assert_array_equal(view.ids, GRID.ids)
    error = view.pixels - EXACT.pixels
    assert np.sqrt((error**2).sum(1).mean()) < 0.03
    # The covariances say how large the errors are: chi-square of 48, 99.99 %.
    chi2 = np.einsum("ni,nij,nj->", error, np.linalg.inv(view.covariances), error)
    assert 18 < chi2 < 94
    assert view.warnings == [] and view.unfitted == []
    assert repr(view) == '<DetectedView "picture" 24 corners>'


@pytest.mark.parametrize("name", OTHERS)
def test_every_kind_of_target_is_found(name: str) -> None:
    scene = tagcal.Scene(CAMERA, OTHERS[name], POSE, sensor=SENSOR)
    view = tagcal.detect(tagcal.render(scene), OTHERS[name], CAMERA)
    exact = tagcal.visible_corners(scene)
    np.testing.assert_array_equal(view.ids, exact.ids)
    assert np.abs(view.pixels - exact.pixels).max() < 0.1


def test_a_picture_leads_to_the_pose_of_its_camera() -> None:
    view = tagcal.detect(IMAGE, GRID, CAMERA)
    found = tagcal.estimate_view_pose(view, GRID, CAMERA, camera_error_px=0.0)
    assert found.status == "ok"
    assert found.camera_from_target.distance_to(POSE) < 2e-4
    assert found.camera_from_target.angle_to(POSE) < 5e-4


def test_the_error_of_a_known_camera_counts() -> None:
    view = tagcal.detect(IMAGE, GRID, CAMERA)
    known = tagcal.UncertainCamera(CAMERA, camera_error_px=0.3)
    found = tagcal.estimate_view_pose(view, GRID, known).hypotheses[0]
    stated = tagcal.estimate_view_pose(view, GRID, CAMERA, camera_error_px=0.3).hypotheses[0]
    exact = tagcal.estimate_view_pose(view, GRID, CAMERA, camera_error_px=0.0).hypotheses[0]
    np.testing.assert_array_equal(found.covariance, stated.covariance)
    assert np.diag(found.covariance).min() > 10 * np.diag(exact.covariance).min()


def test_a_tag_without_a_board_leads_to_its_pose() -> None:
    scene = tagcal.Scene(CAMERA, OTHERS["tag"], POSE, sensor=SENSOR)
    (tag,) = tagcal.detect_tags(tagcal.render(scene), camera=CAMERA)
    assert tag.id == 11 and tag.corners.shape == (4, 2)
    assert tag.covariance is not None and tag.covariances is not None
    assert tag.covariance.shape == (8, 8)
    np.testing.assert_array_equal(tag.covariances[1], tag.covariance[2:4, 2:4])
    found = tagcal.estimate_pose(
        Board.tag(0.12).positions, tag.corners, CAMERA, covariances=tag.covariances
    )
    truth = POSE @ tagcal.Pose([0.0, 0, 0], [0.1, 0.075, 0])
    assert found.camera_from_target.distance_to(truth) < 1e-3


def test_parts_of_larger_pictures_are_searched_in_place() -> None:
    large = np.zeros((400, 600), np.uint8)
    large[50:350, 100:500] = IMAGE
    expected = tagcal.detect(IMAGE, GRID).pixels
    every_second = np.repeat(IMAGE, 2, axis=1)[:, ::2]
    for same in (
        large[50:350, 100:500], np.asfortranarray(IMAGE), IMAGE[::-1][::-1], every_second
    ):  # fmt: skip
        np.testing.assert_array_equal(tagcal.detect(same, GRID).pixels, expected)
    IMAGE.flags.writeable = False
    np.testing.assert_array_equal(tagcal.detect(IMAGE, GRID).pixels, expected)


def written(folder: Path, image: NDArray[Any]) -> Path:
    cv2 = pytest.importorskip("cv2")
    file = folder / "a.png"
    cv2.imwrite(str(file), image)
    return file


def test_sixteen_bits_are_scaled_as_in_files(tmp_path: Path) -> None:
    wide = IMAGE.astype(np.uint16) * 16  # 12-bit data
    file = written(tmp_path, wide)
    of_file = tagcal.detect(file, GRID)
    assert of_file.image == "a.png" and len(of_file) == 24
    np.testing.assert_array_equal(tagcal.detect(wide, GRID).pixels, of_file.pixels)
    np.testing.assert_array_equal(tagcal.detect(str(file), GRID).pixels, of_file.pixels)


def test_many_pictures_are_those_one_by_one(tmp_path: Path) -> None:
    file = written(tmp_path, IMAGE)
    blank = np.full((300, 400), 128, np.uint8)
    images = [IMAGE, file, blank, IMAGE.astype(np.uint16)]
    one = tagcal.detect_all(images, GRID, threads=1)
    two = tagcal.detect_all(images, GRID, threads=2)
    assert [view.image for view in two.views] == ["images[0]", "a.png", "images[2]", "images[3]"]
    assert [len(view) for view in two.views] == [24, 24, 0, 24] and len(two) == 4
    assert two[2].warnings == two.warnings == ["images[2]: no tag of the boards found"]
    assert repr(two) == "<DetectedViews 4 pictures, 72 corners, 1 warning>"
    for a, b, image in zip(one.views, two.views, images):
        np.testing.assert_array_equal(a.pixels, b.pixels)
        np.testing.assert_array_equal(a.pixels, tagcal.detect(image, GRID).pixels)
    with ThreadPoolExecutor(2) as pool:
        for view in pool.map(lambda image: tagcal.detect(image, GRID), [IMAGE] * 4):
            np.testing.assert_array_equal(view.pixels, one[0].pixels)


def test_files_that_cannot_be_read_are_named(tmp_path: Path) -> None:
    damaged = tmp_path / "b.png"
    damaged.write_bytes(b"\x89PNG\r\n\x1a\n but no more")
    with pytest.raises(tagcal.Error, match="b.png: "):
        tagcal.detect_all([IMAGE, damaged], GRID)
    views = tagcal.detect_all([IMAGE, damaged], GRID, skip_unreadable=True).views
    assert [len(view) for view in views] == [24, 0]
    assert "b.png" in views[1].unreadable and views[0].unreadable == ""


def test_a_wrong_border_is_found_out() -> None:
    wrong = Board.grid(3, 2, 0.06, 0.3, border_bits=1)
    view = tagcal.detect(IMAGE, wrong)
    assert any("border_bits 2" in w and "write border_bits: 2" in w for w in view.warnings)
    why = tagcal.explain(IMAGE, wrong)
    assert why.size == (400, 300) and why.reported == []
    assert [tag.id for tag in why.not_reported] == list(range(6))
    assert [(kind.family, kind.border_bits) for kind in why.decoded] == [("tag36h11", 2)]
    assert "border" in why.mistakes[0] and "\n" not in repr(why)
    assert tagcal.explain(IMAGE, GRID).reported == list(range(6))


def test_views_of_the_detector_are_views() -> None:
    view = tagcal.detect(IMAGE, GRID, name="left")
    assert isinstance(view, tagcal.View)
    assert set(view.to_dict()) >= {"image", "ids", "pixels", "covariances", "warnings"}
    again = pickle.loads(pickle.dumps(view))
    assert type(again) is tagcal.DetectedView and again.image == "left"
    np.testing.assert_array_equal(again.covariances, view.covariances)
    for tag in tagcal.detect_tags(IMAGE, border_bits=2)[:1]:
        same = pickle.loads(pickle.dumps(tag))
        np.testing.assert_array_equal(same.corners, tag.corners)
        np.testing.assert_array_equal(same.covariance, tag.covariance)


@pytest.mark.parametrize("bits", [8, 16])
def test_a_tag_is_refined_from_a_rough_start(bits: int) -> None:
    scene = tagcal.Scene(CAMERA, GRID, POSE, sensor=tagcal.Sensor(blur_px=0.7, bits=bits))
    exact = tagcal.visible_corners(scene).pixels[8:12]
    image = tagcal.render(scene)
    fit = tagcal.refine_tag(image, 2, exact + [0.6, -0.5], border_bits=2, tag_spacing=0.3)
    assert fit.status == "converged" and fit.corners is not None
    assert np.abs(fit.corners - exact).max() < (0.02 if bits == 8 else 0.002)
    assert fit.blur_px == pytest.approx(0.7, abs=0.05)
    off = tagcal.refine_tag(image, 2, exact + 1000, border_bits=2)
    assert off.status == "out_of_image" and off.corners is None


def test_views_are_refined_under_a_known_lens() -> None:
    for board in [GRID, OTHERS["checkerboard"]]:
        scene = tagcal.Scene(CAMERA, board, POSE, sensor=SENSOR)
        image = tagcal.render(scene)
        views = tagcal.detect_all([image], board, names=["a"])
        dataset = tagcal.Dataset(CAMERA.size, board, views.views)
        (view,) = tagcal.refine_views([image], dataset, CAMERA, names=["a"], threads=1)
        seen = tagcal.visible_corners(scene)
        exact = {tuple(i): p for i, p in zip(seen.ids.tolist(), seen.pixels)}
        errors = [p - exact[tuple(i)] for i, p in zip(view.ids.tolist(), view.pixels)]
        assert len(view) == len(views[0]) > 20 and np.abs(errors).max() < 0.1
        assert not np.array_equal(view.pixels, views[0].pixels)
        (same,) = tagcal.refine_views([image], dataset, CAMERA, names=["b"])
        np.testing.assert_array_equal(same.pixels, views[0].pixels)
    with pytest.raises(tagcal.Error, match="must be "):
        tagcal.refine_views([IMAGE[:200]], dataset, CAMERA, names=["a"])


def test_a_corner_of_squares_is_refined() -> None:
    board = Board.checkerboard(6, 5, 0.03)
    scene = tagcal.Scene(CAMERA, board, POSE, sensor=SENSOR)
    image = tagcal.render(scene)
    exact = tagcal.visible_corners(scene)
    i = exact.ids[:, 0].tolist().index(14)  # column 2, row 2
    corner = board.positions[14]
    square = corner + 0.03 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    homography = tagcal.homography(
        [[0, 0], [1, 0], [0, 1], [1, 1]],
        np.c_[CAMERA.project(square, POSE) + [0.8, -0.7], np.ones(4)],
    )
    assert homography is not None
    fit = tagcal.refine_corner(image, homography, camera=CAMERA)
    assert fit.status == "converged" and fit.corner is not None and fit.covariance is not None
    assert np.abs(fit.corner - exact.pixels[i]).max() < 0.1
    wrong = tagcal.refine_corner(image, homography, starts_black=False, camera=CAMERA)
    assert wrong.status != "converged"


MISTAKES: list[tuple[Callable[[], Any], str]] = [
    (
        lambda: tagcal.detect(np.zeros((30, 40)), GRID),
        "image: must be uint8 or uint16, got float64; convert it, for example with "
        "(255 * image).astype(np.uint8)",
    ),
    (
        lambda: tagcal.detect([[1, 2], [3, 4]], GRID),
        "image: must be an array (height, width) or the path of a file, got list",
    ),
    (
        lambda: tagcal.detect(None, GRID),
        "image: must be an array (height, width) or the path of a file, got NoneType",
    ),
    (lambda: tagcal.detect("none.png", GRID), "none.png: no such file"),
    (lambda: tagcal.detect(np.zeros((0, 9), np.uint8), GRID), "image: width and height must be > 0"),
    (
        lambda: tagcal.detect(np.broadcast_to(np.uint8(0), (2**20, 2**20)), GRID),
        "image: must have at most 100000000 pixels, got 1048576x1048576",
    ),
    (
        lambda: tagcal.detect(IMAGE[:200], GRID, CAMERA),
        "picture: must be 400x300 pixels as the camera's, got 400x200",
    ),
    (
        lambda: tagcal.detect(IMAGE, Board.points(np.eye(3))),
        "target: has no tags, squares or circles to detect, only points",
    ),
    (lambda: tagcal.detect(IMAGE, []), "target: must have a board"),
    (
        lambda: tagcal.detect(IMAGE, GRID, refinement="best"),
        'refinement: must be fit, edges or stock, got "best"',
    ),
    (lambda: tagcal.detect(IMAGE, GRID, max_hamming=3), "max_hamming: must be 0, 1 or 2, got 3"),
    (
        lambda: tagcal.detect_all([IMAGE, "a\0"], GRID),
        "images[1]: is no path of a file",
    ),
    (
        lambda: tagcal.detect_all([IMAGE], GRID, names=["a", "b"]),
        "names: must have as many rows as images (1), got 2",
    ),
    (
        lambda: tagcal.detect_all([IMAGE], GRID, threads=-1),
        "threads: must be >= 0 (0: one per core), got -1",
    ),
    (lambda: tagcal.detect_tags(IMAGE, "tag9"), "family: must be one of tag36h11, "),
    (
        lambda: tagcal.detect_tags(IMAGE, border_bits=0),
        "border_bits: must be 1 or 2 for tag36h11, got 0",
    ),
    (
        lambda: tagcal.refine_tag(IMAGE, 1, np.eye(2)),
        "corners: must have the shape (4, 2), got 2 rows",
    ),
    (lambda: tagcal.refine_tag(IMAGE, 600, np.zeros((4, 2))), "board: tag id: must be in 0..586 "),
    (lambda: tagcal.refine_corner(IMAGE, np.eye(3), squares=12), "squares: must be 1 to 11, got 12"),
    (lambda: tagcal.refine_corner(IMAGE, np.eye(3), gamma=0), "gamma: must be > 0, got 0"),
]


@pytest.mark.parametrize("call, message", MISTAKES, ids=range(len(MISTAKES)))
def test_wrong_arguments_are_named(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(tagcal.Error) as error:
        call()
    assert str(error.value).startswith(message)


def test_a_tag_under_any_camera_reads_inside_its_memory() -> None:
    """Rows of places are read by whole packs, the last one too: the address sanitizer tells."""
    camera = tagcal.Camera.pinhole(0.1, 0.1, 3, 3, (640, 480))
    corners = [[292.5, 216.9], [392.6, 233.8], [384.6, 320.4], [292.6, 301.5]]
    image = np.full((480, 640), 128, dtype=np.uint8)
    for right in range(8):
        moved = np.array(corners) + [right, 0]
        fit = tagcal.refine_tag(image, 1, moved, border_bits=2, camera=camera, gamma=3.0)
        assert fit.status != "converged"
