"""Targets: their points, their classes, and wrong arguments."""

import copy
import pickle
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
import tagcal
from tagcal import Board

TURNED = tagcal.Pose([0.0, 0.0, 0.1], [0.2, 0.0, 0.0])
BOARDS = [
    Board.grid(4, 3, 0.06, 0.3),
    Board.grid(2, 2, 0.06, 0.3, "tag25h9", border_bits=1, first_id=7),
    Board.checkerboard(7, 5, 0.03, row_spacing=0.04, first_id=2),
    Board.charuco(6, 5, 0.04, 0.03, "DICT_5X5_100", legacy=True, first_marker_id=3),
    Board.circle_grid(4, 11, 0.02, 0.012, asymmetric=True, first_id=2),
    Board.tag(0.16, 3),
    Board.tags([5, 1], [0.1, 0.2], [tagcal.Pose(), TURNED]),
    Board.points([[0.0, 0, 0], [1, 0, 0], [0, 1, 0.5]], ids=[4, 2, 9]),
    Board.grid(4, 3, 0.06, 0.3).made_of("glass", 0.001),
]


def test_grid_is_kalibrs() -> None:
    board = Board.grid(6, 5, 0.088, 0.3)
    assert (board.kind, board.family, board.border_bits) == ("grid", "tag36h11", 2)
    assert len(board) == 120 and board.tag_ids == list(range(30))
    assert board.ids[:5].tolist() == [[0, 0], [0, 1], [0, 2], [0, 3], [1, 0]]
    np.testing.assert_allclose(
        board.positions[:5],
        [[0, 0, 0], [0.088, 0, 0], [0.088, 0.088, 0], [0, 0.088, 0], [0.088 * 1.3, 0, 0]],
        atol=1e-15,
    )
    np.testing.assert_allclose(board.extent_m, [0.088 * 7.5, 0.088 * 6.2, 0])


def test_corners_of_a_checkerboard_are_opencvs() -> None:
    board = Board.checkerboard(7, 5, 0.03)
    grid = np.zeros((35, 3))
    grid[:, :2] = 0.03 * np.mgrid[0:7, 0:5].T.reshape(-1, 2)  # as in OpenCV's tutorial
    np.testing.assert_allclose(board.positions, grid, atol=1e-15)
    assert board.ids.tolist() == [[i, 0] for i in range(35)]


def test_centres_of_circles_are_opencvs_from_below() -> None:
    board = Board.circle_grid(4, 11, 0.02, 0.008, asymmetric=True)
    theirs = np.array([[(2 * j + i % 2) * 0.02, i * 0.02, 0] for i in range(11) for j in range(4)])
    np.testing.assert_allclose(board.positions, theirs, atol=1e-15)  # an odd number of rows
    assert board.extent_m == pytest.approx([0.14, 0.2, 0])
    assert Board.circle_grid(4, 3, 0.02, 0.008).extent_m == pytest.approx([0.06, 0.04, 0])


def test_charuco_is_opencvs() -> None:
    aruco = pytest.importorskip("cv2").aruco
    board = Board.charuco(6, 5, 0.04, 0.03, "DICT_5X5_100")
    codes = aruco.getPredefinedDictionary(aruco.DICT_5X5_100)
    if hasattr(aruco, "CharucoBoard_create"):  # before OpenCV 4.7
        theirs = aruco.CharucoBoard_create(6, 5, 0.04, 0.03, codes)
        corners, ids = theirs.chessboardCorners, theirs.ids
    else:
        theirs = aruco.CharucoBoard((6, 5), 0.04, 0.03, codes)
        corners, ids = theirs.getChessboardCorners(), theirs.getIds()
    assert len(board) == len(corners) == 20
    assert board.tag_ids == ids.ravel().tolist()
    assert board.extent_m == pytest.approx([0.16, 0.12, 0])


def test_single_tags_stand_where_they_are_put() -> None:
    np.testing.assert_allclose(
        Board.tag(0.2).positions, 0.1 * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]])
    )
    board = Board.tags([5, 1], 0.2, [tagcal.Pose(), TURNED])
    assert board.ids[:, 0].tolist() == [1] * 4 + [5] * 4
    np.testing.assert_allclose(
        board.positions[:4], TURNED.transform(Board.tag(0.2).positions), atol=1e-15
    )
    matrices = np.stack([np.eye(4), TURNED.matrix])
    np.testing.assert_allclose(
        Board.tags([5, 1], 0.2, matrices).positions, board.positions, atol=1e-15
    )


def test_points_are_ordered_by_id() -> None:
    board = Board.points([[1.0, 2, 3], [4, 5, 6]], ids=[8, 3])
    assert board.ids.tolist() == [[3, 0], [8, 0]]
    np.testing.assert_array_equal(board.positions, [[4, 5, 6], [1, 2, 3]])
    assert Board.points(np.eye(3)).ids.tolist() == [[0, 0], [1, 0], [2, 0]]


@pytest.mark.parametrize("board", BOARDS, ids=lambda board: board.kind)
def test_boards_are_kept_whole(board: Board) -> None:
    for same in (
        pickle.loads(pickle.dumps(board)),
        copy.deepcopy(board),
        Board.from_dict(board.to_dict()),
    ):
        assert same == board
        np.testing.assert_array_equal(same.ids, board.ids)
        np.testing.assert_array_equal(same.positions, board.positions)
    assert board != BOARDS[(BOARDS.index(board) + 1) % len(BOARDS)]
    assert "\n" not in repr(board)


def test_boards_say_what_they_are() -> None:
    assert [repr(board) for board in BOARDS] == [
        "<Board grid of 4 x 3 tags of 0.06 m, tag36h11, border of 2 bits>",
        "<Board grid of 2 x 2 tags of 0.06 m, tag25h9, border of 1 bit>",
        "<Board checkerboard of 7 x 5 corners, 0.03 m apart>",
        "<Board charuco of 6 x 5 squares, DICT_5X5_100, 0.04 m apart>",
        "<Board asymmetric grid of 4 x 11 circles, 0.02 m apart>",
        "<Board tag 3 of 0.16 m, tag36h11, border of 1 bit>",
        "<Board 2 tags of tag36h11, border of 1 bit>",
        "<Board 3 points>",
        "<Board grid of 4 x 3 tags of 0.06 m, tag36h11, border of 2 bits>",
    ]
    placed = tagcal.PlacedBoard(BOARDS[5], TURNED)
    assert repr(placed) == (
        "<PlacedBoard tag 3 of 0.16 m, tag36h11, border of 1 bit, at (0.2, 0, 0) m>"
    )
    again = pickle.loads(pickle.dumps(placed))
    assert again.board == placed.board and again.world_from_board == TURNED


def test_boards_are_of_paper_unless_stated(tmp_path: Path) -> None:
    for board in BOARDS[:-1]:
        assert (board.flatness, board.print) == ("paper", "paper")
        assert "flatness" not in board.to_dict()
        made = board.made_of(flatness=0.0003, print="aluminium")
        assert (made.flatness, made.print) == (0.0003, "aluminium")
        assert made != board and made.made_of() == board
        tagcal.write_target(tmp_path / "target.yaml", made)
        again = tagcal.read_target(tmp_path / "target.yaml")
        assert (again.flatness, again.print) == (0.0003, "aluminium")


def test_families_are_listed() -> None:
    assert tagcal.tag_family_names()[0] == "tag36h11"
    assert "DICT_4X4_50" in tagcal.tag_dictionary_names()


def test_views_are_kept_whole() -> None:
    some = np.array([[[0.01, 0.002], [0.002, 0.03]], [[np.nan] * 2] * 2])
    view = tagcal.View([[1, 0], [1, 2]], [[1.5, 2], [3, 4]], some, "a.png")
    for same in (
        pickle.loads(pickle.dumps(view)),
        tagcal.View(view.ids, view.pixels, view.covariances, view.image),
    ):
        np.testing.assert_array_equal(same.ids, view.ids)
        np.testing.assert_array_equal(same.pixels, view.pixels)
        np.testing.assert_array_equal(same.covariances, some)
        assert same.image == "a.png"


def placed(*boards: Board) -> list[tagcal.PlacedBoard]:
    return [tagcal.PlacedBoard(board, tagcal.Pose()) for board in boards]


EMPTY = np.zeros((0, 3))
MISTAKES: list[tuple[Callable[[], Any], str]] = [
    (lambda: Board.grid(0, 3, 0.06, 0.3), "board: columns: must be > 0, got 0"),
    (lambda: Board.grid(4, 3, -0.06, 0.3), "board: tag_size: must be > 0, got -0.06"),
    (lambda: Board.grid(4, 3, 0.06, np.nan), "board: tag_spacing: must be >= 0, got nan"),
    (lambda: Board.grid(4, 3, 1e308, 9), "board: its sizes are too large"),
    (
        lambda: Board.grid(10**9, 10**9, 0.06, 0.3),
        "board: columns * rows: must be at most 100000, got 1000000000000000000",
    ),
    (
        lambda: Board.grid(30, 30, 0.06, 0.3),
        "board: tag id: must be in 0..586 of tag36h11, got 587",
    ),
    (
        lambda: Board.grid(4, 3, 0.06, 0.3, border_bits=3),
        "border_bits: must be 1 or 2 for tag36h11, got 3",
    ),
    (
        lambda: Board.grid(4, 3, 0.06, 0.3, "tagStandard41h12", 1, corner_squares=True),
        "board: corner_squares: tagStandard41h12 cannot have them, its border is not black",
    ),
    (lambda: Board.tag(0.1, family="36h11"), "family: must be one of tag36h11, "),
    (lambda: Board.checkerboard(1, 5, 0.03), "board: must have 2 x 2 corners or more, got 1 x 5"),
    (
        lambda: Board.charuco(6, 5, 0.03, 0.04, "DICT_4X4_50"),
        "board: markers must be smaller than a square of 0.03 m, got 0.04",
    ),
    (
        lambda: Board.charuco(2, 5, 0.04, 0.03, "DICT_4X4_50"),
        "board: must have 3 x 3 squares or more, got 2 x 5",
    ),
    (lambda: Board.tag(0), "size: must be > 0, got 0"),
    (lambda: Board.tag(0.1, -1), "id: must be >= 0, got -1"),
    (lambda: Board.tags([1, 1], 0.1, [TURNED] * 2), "ids: 1 occurs twice"),
    (lambda: Board.tags([1, 2.5], 0.1, [TURNED] * 2), "ids: must be whole numbers >= 0, got 2.5"),
    (lambda: Board.tags([1, 2], [0.1], [TURNED] * 2), "size: must be a number, or have the shape "),
    (
        lambda: Board.tags([1, 2], 0.1, TURNED),
        "board_from_tags: must have as many rows as ids (2), got 1",
    ),
    (
        lambda: Board.tags([1], 0.1, [3 * np.eye(4)]),
        "board_from_tags[0]: the last row of a pose must be 0, 0, 0, 1",
    ),
    (lambda: Board.points(EMPTY), "positions: must have 1 to 100000 rows, got 0"),
    (lambda: Board.points([[1, 2, np.inf]]), "positions: must be finite, got inf in row 0"),
    (
        lambda: BOARDS[0].made_of("bronze"),
        'flatness: must be paper, aluminium, glass or a share, got "bronze"',
    ),
    (
        lambda: BOARDS[0].made_of(print=-0.001),
        "board: print: must be > 0 and at most 0.1, got -0.001",
    ),
    (
        lambda: BOARDS[0].made_of(np.nan),
        "board: flatness: must be > 0 and at most 0.1, got nan",
    ),
    (lambda: Board.from_dict({"kind": "circles"}), "fields: kind: must be charuco, checkerboard, "),
    (
        lambda: tagcal.detect(np.zeros((9, 9), np.uint8), placed(BOARDS[0], BOARDS[0])),
        "target: two boards have id 0",
    ),
    (
        lambda: tagcal.detect(
            np.zeros((9, 9), np.uint8),
            placed(
                Board.charuco(6, 5, 0.04, 0.03, "DICT_5X5_100"),
                Board.charuco(6, 5, 0.04, 0.03, "DICT_5X5_100", first_id=50),
            ),
        ),
        "target: two boards have marker 0 of DICT_5X5_100",
    ),
    (
        lambda: tagcal.detect(np.zeros((9, 9), np.uint8), ["board.yaml"]),
        "target[0]: must be a Board, a PlacedBoard or a list of these, got str",
    ),
]


@pytest.mark.parametrize("call, message", MISTAKES, ids=range(len(MISTAKES)))
def test_wrong_arguments_are_named(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(tagcal.Error) as error:
        call()
    assert str(error.value).startswith(message)
