"""`tagcal pose --family`: each tag in a picture has its own pose, also where ids repeat."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
import tagcal
from desk import COMMAND, command_json

CAMERA = tagcal.Camera.pinhole(500, 500, 319.5, 149.5, (640, 300))
POSES = [tagcal.Pose([np.pi, 0.3, 0.2], [x, 0.02, 0.5]) for x in (-0.15, 0.15)]
OPTIONS = ("--family", "tag36h11", "--tag-size", "8cm", "--sigma-px", 0.1)


@pytest.fixture()
def files(tmp_path: Path) -> tuple[Path, Path]:
    tag = tagcal.Board.tag(0.08, 7)
    left, right = (tagcal.render(tagcal.Scene(CAMERA, tag, pose)) for pose in POSES)
    tagcal.write_picture(tmp_path / "twice.png", np.hstack([left[:, :320], right[:, 320:]]))
    tagcal.write_camera(tmp_path / "camera.yaml", CAMERA)
    return tmp_path / "twice.png", tmp_path / "camera.yaml"


def test_an_id_seen_twice_has_two_poses(files: tuple[Path, Path]) -> None:
    picture, camera = files
    views = command_json("pose", picture, "--camera", camera, *OPTIONS)["views"]
    assert [view["image"] for view in views] == ["twice.png tag 7", "twice.png tag 7 (2)"]
    poses = [view["camera_from_board"] for view in views]
    found = [tagcal.Pose(pose["rotation"], pose["translation_m"]) for pose in poses]
    for pose in POSES:
        nearest = min(found, key=pose.distance_to)
        assert nearest.distance_to(pose) < 2e-3
        assert nearest.angle_to(pose) < 0.02
        found.remove(nearest)


def run(*arguments: object) -> "subprocess.CompletedProcess[str]":
    if not COMMAND.exists():
        pytest.skip("the command is not built")
    return subprocess.run([str(COMMAND), *map(str, arguments)], capture_output=True, text=True)


def test_what_is_missing_is_named(files: tuple[Path, Path]) -> None:
    picture, camera = files
    known = ("--camera", camera)
    no_tag = "no picture shows a tag of tag25h9"
    for words, code, text in (
        ((picture, *known, "--family", "tag36h11"), 2, "--family: needs --tag-size"),
        ((picture, *known, *OPTIONS, "--target", camera), 2, "--family, --target: only one"),
        ((picture, *known, "--border-bits", 2), 2, "--border-bits: needs --family"),
        ((picture, *known, *OPTIONS[2:], "--family", "tag25h9"), 3, no_tag),
    ):
        done = run("pose", *words)
        assert done.returncode == code, done
        assert text in done.stdout + done.stderr


def test_drawings_show_the_picture(files: tuple[Path, Path], tmp_path: Path) -> None:
    picture, camera = files
    done = run("pose", picture, "--camera", camera, *OPTIONS, "--draw", tmp_path / "drawn")
    assert done.returncode == 0, done.stderr
    drawings = sorted((tmp_path / "drawn").iterdir())
    assert len(drawings) == 2
    assert all(tagcal.read_picture(d).shape[:2] == (300, 640) for d in drawings)
