"""Files of every format: round trips, OpenCV as a witness, and what wrong files say."""

import os
import shutil
import subprocess
import warnings
from pathlib import Path

import cv2
import numpy as np
import pytest
import tagcal

SOURCE = Path(__file__).parents[2]
DESK = SOURCE / "data-synthetic/golden/desk"
SIZE = (640, 480)
CAMERA = tagcal.Camera.perspective(600.5, 601.25, 319, 241, SIZE, [-0.1, 0.02, 0.001, -0.002])
POSE = tagcal.Pose([0.5, 0.3, 0.1], [0.02, 0.03, 0.6])


def pictures() -> list[np.ndarray]:
    draw = np.random.default_rng(0)
    return [
        draw.integers(0, top, shape, dtype)
        for dtype, top in ((np.uint8, 256), (np.uint16, 65536))
        for shape in ((7, 9), (7, 9, 3))
    ]


@pytest.mark.parametrize("end", [".png", ".tif", ".ppm", ".pgm"])
def test_pictures_come_back_and_opencv_reads_them(tmp_path: Path, end: str) -> None:
    for i, image in enumerate(pictures()):
        if (end == ".pgm") != (image.ndim == 2) and end in (".pgm", ".ppm"):
            continue
        file = tmp_path / f"a{i}{end}"
        tagcal.write_picture(file, image)
        back = tagcal.read_picture(os.fspath(file))
        assert back.dtype == image.dtype
        np.testing.assert_array_equal(back, image)
        theirs = cv2.imread(str(file), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(theirs[..., ::-1] if image.ndim == 3 else theirs, image)
        assert tagcal.read_image_size(file) == (9, 7)
        if image.dtype == np.uint8 and image.ndim == 2:
            np.testing.assert_array_equal(tagcal.read_image(file), image)
    files = [Path(file).name for file in tagcal.list_pictures(tmp_path)]
    assert files == sorted(files) and len(files) in (2, 4)


def test_one_camera_comes_back_in_every_format(tmp_path: Path) -> None:
    names = [f.name for f in tagcal.camera_formats() if not f.only_written]
    assert "opencv" in names and "kalibr" in names
    pinhole = tagcal.Camera.pinhole(600.5, 600.5, 319, 241, SIZE)
    written = 0
    for name in names:
        if name == "wpilib":
            continue  # no size of the pictures
        out = tmp_path / (name + {"colmap": "", "nerfstudio": ".json"}.get(name, ".yaml"))
        notes = tagcal.write_camera(out, pinhole, name)
        assert isinstance(notes, list)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            back = tagcal.read_camera(out)
        assert back.camera == pinhole, name
        assert back.camera.size == SIZE
        written += 1
    assert written == len(names) - 1


@pytest.mark.parametrize("name", ["a.yaml", "a.xml"])
def test_opencv_reads_our_cameras(tmp_path: Path, name: str) -> None:
    tagcal.write_camera(tmp_path / name, CAMERA)
    storage = cv2.FileStorage(str(tmp_path / name), cv2.FILE_STORAGE_READ)
    np.testing.assert_array_equal(storage.getNode("camera_matrix").mat(), CAMERA.matrix)
    theirs = storage.getNode("distortion_coefficients").mat().ravel()
    np.testing.assert_array_equal(theirs[:4], CAMERA.distortion[:4])
    assert storage.getNode("image_width").real() == 640


def test_we_read_cameras_of_opencv(tmp_path: Path) -> None:
    file = tmp_path / "theirs.yml"
    storage = cv2.FileStorage(str(file), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("camera_matrix", CAMERA.matrix)
    storage.write("distortion_coefficients", CAMERA.distortion[:5].reshape(1, -1))
    storage.release()
    assert tagcal.read_camera(file).camera == CAMERA


def test_what_is_known_of_a_camera_comes_back(tmp_path: Path) -> None:
    covariance = np.diag([1.0, 0.25, 0.25, 0.01])
    seen = tagcal.SeenRegion(SIZE, [[10, 10], [600, 20], [300, 400]])
    pinhole = tagcal.Camera.pinhole(600, 601, 319, 241, SIZE)
    known = tagcal.UncertainCamera(pinhole, "pinhole", covariance, seen=seen, camera_error_px=0.1)
    assert tagcal.write_camera(tmp_path / "a.yaml", known) == []
    back = tagcal.read_camera(tmp_path / "a.yaml")
    assert back.model == "pinhole" and back.camera_error_px == 0.1
    np.testing.assert_array_equal(back.covariance, covariance)
    np.testing.assert_array_equal(back.seen.hull, seen.hull)
    assert back.sigmas["fx"] == 1


def test_several_cameras_with_names_and_poses(tmp_path: Path) -> None:
    right = tagcal.Camera.fisheye(300, 300, 319, 241, SIZE, [0.01, 0.002])
    cameras = [
        tagcal.FileCamera(CAMERA, "cam0", tagcal.Pose()),
        tagcal.FileCamera(right, "cam1", POSE),
    ]
    file = tmp_path / "camchain.yaml"
    notes = tagcal.write_camera(file, tagcal.CameraFile(cameras))
    assert isinstance(notes, list)
    back = tagcal.read_cameras(file)
    assert back.format == "kalibr" and [c.name for c in back.cameras] == ["cam0", "cam1"]
    assert back.cameras[1].calibration.camera == right
    np.testing.assert_allclose(back.cameras[1].camera_from_rig.matrix, POSE.matrix, atol=1e-12)
    assert tagcal.read_camera(f"{file}:cam1").camera == right
    with pytest.raises(tagcal.Error, match="cam0"):
        tagcal.read_camera(file)
    assert repr(back).startswith("<CameraFile kalibr, 2 cameras, 0 poses")


def test_poses_of_images(tmp_path: Path) -> None:
    pinhole = tagcal.Camera.pinhole(600, 600, 319, 241, SIZE)
    tagcal.write_camera(tmp_path / "sparse", pinhole, "colmap", poses={"a.png": POSE})
    back = tagcal.read_cameras(tmp_path / "sparse")
    assert [p.image for p in back.poses] == ["a.png"]
    np.testing.assert_allclose(back.poses[0].camera_from_world.matrix, POSE.matrix, atol=1e-12)
    notes = tagcal.write_camera(tmp_path / "a.yaml", pinhole, "kalibr", poses={"a.png": POSE})
    assert any("poses" in note for note in notes)


def test_lens_of_another_tool(tmp_path: Path) -> None:
    values = {"fx": 300.0, "fy": 300.0, "cx": 319.0, "cy": 241.0, "xi": -0.2, "alpha": 0.55}
    file = tmp_path / "camchain.yaml"
    file.write_text(
        "cam0:\n  camera_model: ds\n  intrinsics: [-0.2, 0.55, 300, 300, 319, 241]\n"
        "  distortion_model: none\n  distortion_coeffs: []\n  resolution: [640, 480]\n"
    )
    camera = tagcal.read_cameras(file).cameras[0]
    assert camera.calibration.camera.parameters == values
    assert tagcal.fit_lens(camera.calibration, "fisheye4").camera.size == SIZE
    assert tagcal.read_camera(file).camera.lens == "double sphere"


def test_calibration_is_written_and_read(tmp_path: Path) -> None:
    answer = tagcal.calibrate(tagcal.read_dataset(DESK).dataset, model="opencv5")
    tagcal.write_camera(tmp_path / "a.yaml", answer)
    assert (tmp_path / "a.yaml").read_text() == tagcal.calibration_yaml(answer)
    back = tagcal.read_camera(tmp_path / "a.yaml")
    assert back.camera == answer.camera and back.model == answer.model
    np.testing.assert_array_equal(back.covariance, answer.covariance)
    assert isinstance(tagcal.write_camera(tmp_path / "a.xml", answer), list)


def boards() -> list[tagcal.Board]:
    return [
        tagcal.Board.grid(3, 2, 0.088, 0.3),
        tagcal.Board.checkerboard(7, 5, 0.03),
        tagcal.Board.points([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0.02], [0.1, 0.1, 0]]),
    ]


@pytest.mark.parametrize("board", boards(), ids=lambda b: b.kind)
def test_targets_come_back(tmp_path: Path, board: tagcal.Board) -> None:
    tagcal.write_target(tmp_path / "t.yaml", board)
    back = tagcal.read_target(tmp_path / "t.yaml")
    assert repr(back) == repr(board)
    np.testing.assert_array_equal(back.ids, board.ids)


def test_unknown_key_of_a_target_is_a_warning(tmp_path: Path) -> None:
    file = tmp_path / "t.yaml"
    tagcal.write_target(file, boards()[0])
    file.write_text(file.read_text() + "colour: blue\n")
    with pytest.warns(UserWarning, match="colour"):
        tagcal.read_target(file)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(UserWarning, match="colour"):
            tagcal.read_target(file)
    with pytest.warns(UserWarning):
        assert tagcal.read_target(file, first_id=20).ids[0, 0] == 20


def test_data_set_comes_back(tmp_path: Path) -> None:
    folder = tagcal.read_dataset(DESK)
    data = folder.dataset
    assert folder.observations == str(DESK / "observations.csv") and folder.images == []
    assert data.truth.camera.size == data.size and len(data) > 3
    assert tagcal.write_dataset(tmp_path / "new", data) == []
    back = tagcal.read_dataset(tmp_path / "new").dataset
    assert repr(back) == repr(data)
    for mine, theirs in zip(back.views, data.views):
        np.testing.assert_array_equal(mine.ids, theirs.ids)
        np.testing.assert_array_equal(mine.pixels, theirs.pixels)
    assert back.truth.camera == data.truth.camera
    truth = tagcal.read_truth(tmp_path / "new/truth.yaml")
    tagcal.write_truth(tmp_path / "again.yaml", truth)
    assert tagcal.read_truth(tmp_path / "again.yaml").to_dict() == truth.to_dict()


def test_views_that_a_table_cannot_hold(tmp_path: Path) -> None:
    board = boards()[0]
    one = tagcal.View([[0, 0]], [[1.0, 2.0]], image="a")
    empty = tagcal.View(np.zeros((0, 2)), np.zeros((0, 2)), image="b")
    same = tagcal.Dataset(SIZE, board, [one, one])
    with pytest.raises(tagcal.Error, match='two views have the image "a"'):
        tagcal.write_dataset(tmp_path / "same", same)
    assert not (tmp_path / "same").exists()
    notes = tagcal.write_dataset(tmp_path / "new", tagcal.Dataset(SIZE, board, [one, empty]))
    assert notes == ["dropped: 1 view without corners"]


@pytest.mark.parametrize("end", [".csv", ".vnl", ".yaml", ".xml", ".json"])
def test_corners_come_back(tmp_path: Path, end: str) -> None:
    board = boards()[1]
    draw = np.random.default_rng(1)
    n = len(board.ids)
    views = [
        tagcal.View(board.ids, draw.uniform(0, 400, (n, 2)).round(3), image=f"{i}.png")
        for i in range(2)
    ]
    assert isinstance(tagcal.write_corners(tmp_path / f"c{end}", views, board), list)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        back = tagcal.read_observations(tmp_path / f"c{end}", board)
    for mine, theirs in zip(back, views, strict=True):
        order = np.argsort(mine.ids[:, 0])
        np.testing.assert_array_equal(mine.ids[order], theirs.ids)
        np.testing.assert_allclose(mine.pixels[order], theirs.pixels, atol=1e-4)
    covariances = tagcal.View(board.ids, views[0].pixels, np.eye(2), "a")
    notes = tagcal.write_corners(tmp_path / f"d{end}", [covariances], board)
    assert notes == [] if end == ".csv" else any("covariances" in note for note in notes)


def test_scene_is_read() -> None:
    scene = tagcal.read_scene(sorted((SOURCE / "data-synthetic/scenes").glob("*.yaml"))[0])
    assert len(scene) > 0 and scene.camera.size[0] > 0


def test_a_folder_that_cannot_be_written(tmp_path: Path) -> None:
    blocked = tmp_path / "file"
    blocked.write_text("x")
    for write in (
        lambda: tagcal.write_picture(blocked / "a.png", pictures()[0]),
        lambda: tagcal.write_camera(blocked / "a.yaml", CAMERA),
        lambda: tagcal.write_target(blocked / "a.yaml", boards()[0]),
        lambda: tagcal.write_dataset(blocked / "a", tagcal.read_dataset(DESK).dataset),
        lambda: tagcal.write_corners(blocked / "a.csv", [], boards()[0]),
    ):
        with pytest.raises(tagcal.Error, match="file/a"):
            write()
    assert blocked.read_text() == "x"
    if os.geteuid() != 0:  # root may write everywhere
        tmp_path.chmod(0o500)
        with pytest.raises(tagcal.Error, match="Permission denied"):
            tagcal.write_camera(tmp_path / "a.yaml", CAMERA)
        tmp_path.chmod(0o700)


READERS = [
    tagcal.read_image, tagcal.read_picture, tagcal.read_image_size, tagcal.list_pictures,
    tagcal.read_camera, tagcal.read_cameras, tagcal.read_target, tagcal.read_dataset,
    tagcal.read_scene, tagcal.read_truth, tagcal.read_poses,
    lambda file: tagcal.read_observations(file, tagcal.Board.checkerboard(7, 5, 0.03)),
]  # fmt: skip


@pytest.mark.parametrize("read", READERS)
def test_files_that_are_none_are_named(tmp_path: Path, read: object) -> None:
    nonsense = tmp_path / "nonsense.yaml"
    nonsense.write_bytes(b"\xff\x00\x01 a: [")
    (tmp_path / "empty").write_text("")
    for file in (nonsense, tmp_path / "empty", tmp_path / "missing", "/dev/null"):
        with pytest.raises(tagcal.Error) as error:
            read(file)  # type: ignore[operator]
        assert os.fspath(file) in str(error.value) and "\n" not in str(error.value)
    with pytest.raises(tagcal.Error):
        read("")  # type: ignore[operator]
    with pytest.raises(TypeError):
        read(None)  # type: ignore[operator]


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: tagcal.write_camera("a.zip", CAMERA), "format: is needed, as the name a.zip"),
        (lambda: tagcal.write_camera("a.yaml", CAMERA, "cahvor"), 'format: .*got "cahvor"'),
        (lambda: tagcal.write_camera("", CAMERA), "file: must be the path of a file"),
        (lambda: tagcal.write_camera("a.yaml", 3), "camera: must be a Camera.*got int"),
        (lambda: tagcal.write_picture("a.gif", pictures()[0]), "a.gif"),
        (lambda: tagcal.write_picture("a.jpg", pictures()[2]), "a.jpg"),
        (lambda: tagcal.write_picture("a.png", np.zeros((2, 2))), "image: must be uint8 or uint16"),
        (lambda: tagcal.write_picture("a.png", np.zeros((0, 2), np.uint8)), "image: "),
        (lambda: tagcal.read_target("a.yaml", first_id=-1), "first_id: must be >= 0, got -1"),
        (lambda: tagcal.read_target("a.yaml", tag_size_m=np.nan), "tag_size_m: must be > 0"),
        (lambda: tagcal.CameraFile([]), "cameras: must have one"),
        (lambda: tagcal.write_corners("a.txt", [], boards()[0]), "format: .*the name a.txt"),
    ],
)
def test_wrong_arguments(call: object, message: str) -> None:
    with pytest.raises(tagcal.Error, match=message):
        call()  # type: ignore[operator]


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="needs ffmpeg")
def test_frames_of_a_video_are_pictures(tmp_path: Path) -> None:
    pictures = [np.full((48, 64), 20 * i, np.uint8) for i in range(6)]
    for i, picture in enumerate(pictures):
        tagcal.write_picture(tmp_path / f"{i}.png", picture)
    clip = tmp_path / "clip.mkv"
    subprocess.run(["ffmpeg", "-loglevel", "error", "-framerate", "10", "-i", str(tmp_path / "%d.png"),
                    "-c:v", "ffv1", "-pix_fmt", "gray", str(clip)], check=True)
    video = tagcal.read_sequence(clip)
    assert video.image_size == (64, 48)
    assert np.allclose(video.times_s, np.arange(6) / 10)
    for i, picture in enumerate(pictures):
        assert np.array_equal(tagcal.read_image(f"{clip}@{i:06}"), picture)
    with pytest.raises(tagcal.Error, match="has 6 frames"):
        tagcal.read_image(f"{clip}@000006")
