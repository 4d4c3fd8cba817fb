"""Data sets for the tests: data-synthetic/golden/desk, and one that OpenCV projects."""

import csv
import json
import subprocess
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest
import tagcal

SOURCE = Path(__file__).parents[2]
DESK = SOURCE / "data-synthetic/golden/desk"
SIZE = (1280, 800)
COMMAND = Path(tagcal.__file__).parents[2] / "tools/tagcal"  # if it is built
K = np.array([[902.5, 0, 651.2], [0, 901.3, 391.7], [0, 0, 1]])
DISTORTION = np.array([-0.15, 0.05, 0.0005, -0.0003, 0.0])


def desk() -> tagcal.Dataset:
    board = tagcal.Board.grid(6, 6, 0.088, 0.3, border_bits=1)
    placed = tagcal.PlacedBoard(board, tagcal.Pose([1, 0, 0, 0], [-0.33, -0.33, 0]))
    seen: dict[str, tuple[list, list]] = {}
    with (DESK / "observations.csv").open() as file:
        for row in csv.DictReader(file):
            ids, pixels = seen.setdefault(row["image"], ([], []))
            ids.append((int(row["tag_id"]), int(row["corner"])))
            pixels.append((float(row["x_px"]), float(row["y_px"])))
    views = [tagcal.View(ids, pixels, image=name) for name, (ids, pixels) in seen.items()]
    truth = tagcal.Truth(tagcal.Camera.from_matrix(K, SIZE, DISTORTION))
    return tagcal.Dataset(SIZE, placed, views, truth)


def command_json(*arguments: object) -> Any:
    """The --json of the command on the same data; skips the test if it is not built."""
    if not COMMAND.exists():
        pytest.skip("the command is not built")
    words = [str(COMMAND), *map(str, arguments), "--json"]
    return json.loads(subprocess.run(words, capture_output=True, text=True).stdout)


def opencv_lists(sigma_px: float = 0.0, num_views: int = 8) -> tuple[list, list, list]:
    """Points, pixels by cv2.projectPoints, and poses of a board of 9 x 7 points; some not seen."""
    random = np.random.default_rng(5)
    board = np.array([[0.05 * x, 0.05 * y, 0.0] for y in range(7) for x in range(9)])
    points, pixels, poses = [], [], []
    for view in range(num_views):
        tilt = 0.6 * np.array([np.cos(2.4 * view), np.sin(2.4 * view), 0.2 * view])
        middle = np.array([0.1 * np.cos(1.3 * view), 0.06 * np.sin(1.3 * view), 0.5 + 0.02 * view])
        pose = tagcal.Pose(tilt, middle) @ tagcal.Pose([1, 0, 0, 0], [-0.2, -0.15, 0])
        rvec, tvec = pose.rotation_vector, pose.translation
        seen = cv2.projectPoints(board, rvec, tvec, K, DISTORTION)[0][:, 0]
        inside = np.all((seen > 0) & (seen < np.array(SIZE) - 1), axis=1)
        points.append(board[inside])
        pixels.append((seen + sigma_px * random.standard_normal(seen.shape))[inside])
        poses.append(pose)
    return points, pixels, poses
