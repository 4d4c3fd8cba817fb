"""Rendered pictures, depths and exact corners; and wrong arguments."""

import subprocess
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, Callable

import numpy as np
import pytest
import tagcal
from tagcal import Board, Scene, Sensor

COMMAND = Path(tagcal.__file__).parents[2] / "tools" / "tagcal"  # beside a build's package
CAMERA = tagcal.Camera.perspective(200, 201, 80, 59, (160, 120), [-0.1, 0.02])
GRID = Board.grid(2, 2, 0.06, 0.3)
POSE = tagcal.Pose.looking_at([0.15, -0.1, 0.3], [0.07, 0.07, 0], [0, 0, 1])


RECIPE = """
camera: {{image_size: [160, 120], model: opencv5, fx: 200, fy: 201, cx: 80, cy: 59,
         distortion: [-0.1, 0.02]}}
boards:
  - target: {{target_type: aprilgrid, tagCols: 2, tagRows: 2, tagSize: 0.06, tagSpacing: 0.3}}
  - target: {{target_type: tags, first_id: 9, border_bits: 1, tags: [{{id: 9, size: 0.05}}]}}
    world_from_board: {{translation_m: [0.25, 0.05, 0.01]}}
occluders:
  - {{corners: [[0, 0, 0.05], [0.03, 0, 0.05], [0.03, 0.02, 0.05]], level: 0.2}}
path: {{type: dome, min_distance_m: 0.3, max_distance_m: 0.4, target_m: [0.1, 0.07, 0],
       min_elevation_deg: 45}}
views: 3
jitter: {{position_m: 0.02, target_m: 0.01, roll_deg: 30}}
sensor: {{exposure: 1.1, blur_px: 0.6, noise_levels: 3, bits: {bits}, gamma: 0.8,
         vignetting: [-0.3]}}
light: {{ambient: 0.4, point: {{position_m: [0.1, 0.1, 1], strength: 0.7}}}}
background_level: 0.4
ink_spread_m: 0.0002
"""


@pytest.mark.skipif(not COMMAND.exists(), reason="needs the command of the same build")
@pytest.mark.parametrize("bits", [8, 16])
def test_pictures_are_those_of_the_command(bits: int, tmp_path: Path) -> None:
    cv2 = pytest.importorskip("cv2")
    (tmp_path / "scene.yaml").write_text(RECIPE.format(bits=bits))
    run = [COMMAND, "render", "scene.yaml", "--out", "out", "--seed", "5", "--depth"]
    subprocess.run([str(part) for part in run], cwd=tmp_path, check=True, capture_output=True)
    second = tagcal.PlacedBoard(Board.tag(0.05, 9), tagcal.Pose([1, 0, 0, 0], [0.25, 0.05, 0.01]))
    poses = tagcal.poses_on_dome(
        3,
        0.3,
        0.4,
        target=[0.1, 0.07, 0],
        min_elevation_rad=np.deg2rad(45),
        position_jitter_m=0.02,
        target_jitter_m=0.01,
        roll_jitter_rad=np.deg2rad(30),
        seed=5,
    )
    scene = Scene(
        CAMERA,
        [tagcal.PlacedBoard(GRID, tagcal.Pose()), second],
        poses,
        sensor=Sensor(1.1, 0.6, 3, bits, 0.8, [-0.3]),
        occluders=[tagcal.Occluder([[0, 0, 0.05], [0.03, 0, 0.05], [0.03, 0.02, 0.05]], 0.2)],
        light=tagcal.Light(0.4, tagcal.PointLamp([0.1, 0.1, 1], 0.7)),
        background_level=0.4,
        ink_spread_m=0.0002,
    )
    for view in range(3):
        expected = cv2.imread(str(tmp_path / f"out/images/{view:03}.png"), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(tagcal.render(scene, view, seed=5), expected)
        depth = tagcal.render_depth(scene, view, seed=5)
        millimetres = cv2.imread(str(tmp_path / f"out/depth/{view:03}.png"), cv2.IMREAD_UNCHANGED)
        np.testing.assert_array_equal(np.nan_to_num(np.round(depth.astype(float) / 0.001)), millimetres)


def test_visible_corners_are_opencvs() -> None:
    cv2 = pytest.importorskip("cv2")
    view = tagcal.visible_corners(Scene(CAMERA, GRID, POSE))
    np.testing.assert_array_equal(view.ids, GRID.ids)
    expected, _ = cv2.projectPoints(
        GRID.positions, POSE.rotation_vector, POSE.translation, CAMERA.matrix, CAMERA.distortion
    )
    np.testing.assert_allclose(view.pixels, expected[:, 0], atol=1e-9)
    assert np.isnan(view.covariances).all() and view.image == "000.png"


def test_levels_and_depths_are_those_of_the_scene() -> None:
    above = tagcal.Pose.looking_at([0, 0, 0.5], [0, 0, 0], [0, 1, 0])
    tag = Board.tag(0.1)
    scene = Scene(CAMERA, tag, above, paper_level=0.8, ink_level=0.2, background_level=0.6)
    light = tagcal.render_light(scene)
    assert light.dtype == np.float32 and light.shape == (120, 160)
    # The tag spans 40 px about (80, 59), its border 5 px.
    assert light[[0, 59, 59], [0, 57, 62]] == pytest.approx([0.6, 0.8, 0.2], abs=1e-5)
    depth = tagcal.render_depth(scene)
    assert depth[59, 80] == pytest.approx(0.5, abs=1e-6) and np.isnan(depth[0, 0])
    image = tagcal.render(scene)
    np.testing.assert_array_equal(image, np.floor(255 * light.astype(float) + 0.5))
    bright = Scene(CAMERA, tag, above, sensor=Sensor(exposure=9, bits=16))
    assert tagcal.render(bright).max() == 65535


def test_occluders_hide_corners() -> None:
    lid = tagcal.Occluder([[-1, -1, 0.01], [0.07, -1, 0.01], [0.07, 1, 0.01], [-1, 1, 0.01]])
    view = tagcal.visible_corners(Scene(CAMERA, GRID, POSE, occluders=[lid]))
    hidden = GRID.positions[:, 0] < 0.067  # where the line of sight meets the board
    np.testing.assert_array_equal(view.ids, GRID.ids[~hidden])
    box = tagcal.cuboid([0.1, 0.2, 0.3], POSE.inverse())
    assert len(box) == 6
    assert len(tagcal.visible_corners(Scene(CAMERA, GRID, POSE, occluders=box))) == 0


def test_seeds_and_threads() -> None:
    scene = Scene(CAMERA, GRID, [POSE] * 3, sensor=Sensor(noise_levels=4))
    first = tagcal.render(scene, 0, seed=1)
    np.testing.assert_array_equal(tagcal.render(scene, 0, seed=1), first)
    assert (tagcal.render(scene, 1, seed=1) != first).any()
    assert (tagcal.render(scene, 0, seed=2) != first).any()
    with ThreadPoolExecutor(2) as pool:
        images = list(pool.map(lambda view: tagcal.render(scene, view, seed=1), range(3)))
    for view in range(3):
        np.testing.assert_array_equal(images[view], tagcal.render(scene, view, seed=1))


def test_a_sensor_processes_its_pictures() -> None:
    pictures = [
        tagcal.render(Scene(CAMERA, GRID, POSE, sensor=sensor, print_grid_m=grid), 0)
        for sensor, grid in [
            (Sensor(noise_levels=2), 0.0),
            (Sensor(noise_levels=2), 0.0007),
            (Sensor(noise_levels=2, mosaic=tagcal.Mosaic(gains=(0.5, 1, 0.7))), 0.0),
            (Sensor(noise_levels=2, mosaic=tagcal.Mosaic("GRBG", (0.5, 1, 0.7), False)), 0.0),
            (Sensor(noise_levels=2, denoise=tagcal.Denoise(6, 1)), 0.0),
            (Sensor(noise_levels=2, sharpen=tagcal.Sharpen(0.8, 1.2)), 0.0),
            (Sensor(noise_levels=2, jpeg=50), 0.0),
        ]
    ]
    for i, picture in enumerate(pictures):
        for other in pictures[:i]:
            assert (picture != other).any()
    sensor = Sensor(mosaic=tagcal.Mosaic("GBRG"), sharpen=tagcal.Sharpen(0.8, 1.2), jpeg=50)
    assert sensor.mosaic is not None and repr(sensor.mosaic) == "<Mosaic GBRG>"
    assert sensor.sharpen is not None and sensor.sharpen.to_dict() == {
        "amount": 0.8,
        "radius_px": 1.2,
    }
    assert sensor.jpeg == 50 and sensor.denoise is None


def test_a_scene_says_what_it_is() -> None:
    light = tagcal.Light(0.5, tagcal.DirectionalLamp([0, 0, -1], 0.6))
    sensor = Sensor(blur_px=0.7, vignetting="cos4", focus_distance_m=0.4, aperture_m=0.002)
    scene = Scene(CAMERA, GRID, np.stack([POSE.matrix] * 2), sensor=sensor, light=light)
    assert repr(scene) == "<Scene 1 board, 2 views of 160 x 120>"
    assert len(scene) == 2 and scene.camera == CAMERA and not scene.moves
    assert scene.target[0].board == GRID and scene.target_in_view(1)[0].board == GRID
    assert scene.sensor.vignetting == "cos4" and scene.sensor.focus_distance_m == 0.4
    assert scene.light is not None and isinstance(scene.light.lamp, tagcal.DirectionalLamp)
    assert repr(scene.sensor) == "<Sensor 8 bits, blur 0.7 px, noise 0 levels>"
    assert [pose.matrix.tolist() for pose in tagcal.camera_poses(scene)] == [
        pose.matrix.tolist() for pose in [tagcal.Pose.from_matrix(POSE.matrix)] * 2
    ]


def test_the_data_set_of_a_scene_is_exact() -> None:
    scene = Scene(CAMERA, GRID, tagcal.poses_on_ring(5, 0.3, [0.07, 0.07, 0.2], [0.07, 0.07, 0]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        data = tagcal.exact_dataset(scene)
    assert len(data) == 5 and data.size == (160, 120)
    for i, view in enumerate(data.views):
        np.testing.assert_array_equal(view.pixels, tagcal.visible_corners(scene, i).pixels)
    assert data.truth is not None and data.truth.camera == CAMERA


def test_paths_are_where_they_are_asked_for() -> None:
    target = np.array([0.1, 0.2, 0.3])
    for pose in tagcal.poses_on_dome(20, 0.5, 0.8, target, 0.3, 1.2):
        eye = pose.inverse().translation - target
        distance = np.linalg.norm(eye)
        assert 0.5 - 1e-9 <= distance <= 0.8 + 1e-9
        assert 0.3 <= np.arcsin(eye[2] / distance) <= 1.2
        np.testing.assert_allclose(pose.transform(target), [0, 0, distance], atol=1e-12)
    ends = [pose.inverse().translation for pose in tagcal.poses_on_line(2, [1, 0, 1], [0, 1, 1])]
    np.testing.assert_allclose(ends, [[1, 0, 1], [0, 1, 1]], atol=1e-12)
    eyes = [pose.inverse().translation for pose in tagcal.poses_on_ring(4, 2, [0, 0, 1])]
    np.testing.assert_allclose(eyes, [[2, 0, 1], [0, 2, 1], [-2, 0, 1], [0, -2, 1]], atol=1e-12)


SCENE = Scene(CAMERA, GRID, POSE)
LINE = [[0, 0, 0], [1, 0, 0], [2, 0, 0]]


def processed(**settings: Any) -> Scene:
    return Scene(CAMERA, GRID, POSE, sensor=Sensor(**settings))


MISTAKES: list[tuple[Callable[[], Any], str]] = [
    (lambda: tagcal.render(SCENE, 1), "view: must be in 0..0, got 1"),
    (lambda: tagcal.render_depth(SCENE, -1), "view: must be in 0..0, got -1"),
    (lambda: Scene(CAMERA, GRID, []), "camera_from_world: must have a pose"),
    (
        lambda: Scene(CAMERA, GRID, [POSE, np.eye(3)]),
        "camera_from_world[1]: must have the shape (4, 4), got (3, 3)",
    ),
    (
        lambda: Scene(CAMERA, GRID, 3.0),
        "camera_from_world: must be a Pose, a list of these or an array (N, 4, 4), got float",
    ),
    (lambda: Scene(CAMERA, 3, POSE), "target: must be a Board, a PlacedBoard or a list of these"),
    (
        lambda: Scene(tagcal.Camera.pinhole(1, 1, 0, 0, (2**20, 2**20)), GRID, POSE),
        "camera: its image must have at most 100000000 pixels, got 1048576x1048576",
    ),
    (
        lambda: Scene(CAMERA, GRID, POSE, paper_level=2),
        "paper_level: must be in 0..1, a share of full white, got 2",
    ),
    (
        lambda: Scene(CAMERA, GRID, POSE, ink_spread_m=0.1),
        "ink_spread_m: must not be above paper_margin_m, got 0.1",
    ),
    (
        lambda: Scene(CAMERA, GRID, POSE, sensor=Sensor(vignetting=[-2])),
        "vignetting: ",
    ),
    (
        lambda: Scene(
            tagcal.Camera.fisheye(50, 50, 80, 60, (160, 120)),
            GRID,
            POSE,
            sensor=Sensor(focus_distance_m=1, aperture_m=0.01),
        ),
        "focus: needs a perspective lens, not a fisheye one",
    ),
    (lambda: Sensor(blur_px=101), "blur_px: must be at most 100, got 101"),
    (lambda: Sensor(noise_levels=np.nan), "noise_levels: must be >= 0, got nan"),
    (lambda: Sensor(bits=12), "bits: must be 8 or 16, got 12"),
    (lambda: Sensor(gamma=0), "gamma: must be > 0, got 0"),
    (lambda: Sensor(exposure=-1), "exposure: must be > 0, got -1"),
    (lambda: Sensor(vignetting="dark"), "vignetting: must be cos4 or a list of coefficients"),
    (lambda: processed(jpeg=0), "jpeg: must be from 1 to 100, got 0"),
    (lambda: processed(bits=16, jpeg=90), "jpeg: has 8 bits only; leave out `bits: 16`"),
    (lambda: processed(mosaic=tagcal.Mosaic("RGB")), "mosaic: pattern: must be RGGB, BGGR"),
    (lambda: Scene(CAMERA, GRID, POSE, print_grid_m=-1), "print_grid_m: must be >= 0, got -1"),
    (lambda: Sensor(aperture_m=0.01), "aperture_m: needs a focus_distance_m"),
    (lambda: tagcal.Occluder(LINE), "corners: must not lie on a line"),
    (lambda: tagcal.Occluder(LINE[:2]), "corners: must have 3 to 1000 rows, got 2"),
    (
        lambda: tagcal.Occluder([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 1]]),
        "corners: must lie in a plane, but corner ",
    ),
    (lambda: tagcal.Occluder(np.eye(3), 1.5), "level: must be in 0..1, a share of full white"),
    (lambda: tagcal.cuboid([1, 0, 1], POSE), "cuboid: size_m: all sizes must be > 0"),
    (lambda: tagcal.DirectionalLamp([0, 0, 0]), "direction: must not be zero"),
    (lambda: tagcal.PointLamp([0, 0, 1], -1), "strength: must be >= 0, got -1"),
    (lambda: tagcal.Light(np.inf), "ambient: must be >= 0, got inf"),
    (lambda: tagcal.poses_on_dome(0, 1, 2), "views: must be 1 to 100000, got 0"),
    (
        lambda: tagcal.poses_on_dome(5, 2, 1),
        "min_distance_m: must not be above max_distance_m, 1, got 2",
    ),
    (lambda: tagcal.poses_on_ring(5, -1), "radius_m: must be > 0, got -1"),
    (lambda: tagcal.poses_on_line(5, [0, 0], [1, 1, 1]), "start: must have the shape (3,), got (2,)"),
]


@pytest.mark.parametrize("call, message", MISTAKES, ids=range(len(MISTAKES)))
def test_wrong_arguments_are_named(call: Callable[[], Any], message: str) -> None:
    with pytest.raises(tagcal.Error) as error:
        call()
    assert str(error.value).startswith(message)
