"""Drawings: what they show, and that nothing is drawn twice, shown or warned of."""

import subprocess
import sys
import warnings
from pathlib import Path
from typing import Any, Iterator

import matplotlib

matplotlib.use("Agg")

import numpy as np  # noqa: E402
import pytest  # noqa: E402
import tagcal  # noqa: E402
from desk import SIZE, desk  # noqa: E402
from matplotlib import pyplot  # noqa: E402

DATASET = desk()
CALIBRATION = tagcal.calibrate(DATASET)
CAMERA = CALIBRATION.camera


@pytest.fixture(autouse=True)
def clean() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield
        for number in pyplot.get_fignums():
            pyplot.figure(number).canvas.draw()  # layout and text can warn only now
    pyplot.close("all")


def check_image_axes(axes: Any) -> None:
    assert axes.get_xlim() == (-0.5, SIZE[0] - 0.5)
    assert axes.get_ylim() == (SIZE[1] - 0.5, -0.5)
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [px]", "y [px]")
    assert axes.get_aspect() in (1, "equal")


def arrows_of(axes: Any) -> Any:
    (arrows,) = [c for c in axes.collections if type(c).__name__ == "Quiver"]
    return arrows


def key_of(axes: Any) -> Any:
    (key,) = [a for a in axes.get_children() if type(a).__name__ == "QuiverKey"]
    return key


def test_residuals() -> None:
    axes = tagcal.plot.residuals(CALIBRATION, DATASET)
    check_image_axes(axes)
    assert axes.get_title() == "residuals of 1442 corners in 12 views, rms 0.0117 px"
    arrows = arrows_of(axes)
    assert arrows.N == CALIBRATION.num_corners
    rms = np.sqrt(np.mean(arrows.U**2 + arrows.V**2))
    assert rms == pytest.approx(CALIBRATION.rms_px, rel=1e-9)
    (rejected,) = axes.lines
    assert len(rejected.get_xdata()) == len(CALIBRATION.outliers)
    assert key_of(axes).text.get_text() == "0.05 px (x 2000)"
    assert arrows.scale == pytest.approx(1 / 2000)
    beside = axes.figure.axes[1]
    assert sum(bar.get_height() * bar.get_width() for bar in beside.patches) == pytest.approx(1)
    assert beside.get_xlabel() == "residual / claimed sd"


def test_residuals_in_axes_of_the_user() -> None:
    figure, (left, right) = pyplot.subplots(1, 2)
    assert tagcal.plot.residuals(CALIBRATION, DATASET, ax=left) is left
    assert tagcal.plot.residual_distribution(CALIBRATION, DATASET, ax=right) is right
    assert figure.axes == [left, right]
    assert pyplot.get_fignums() == [figure.number]


def exact_dataset(bend_m: float, noise: str, sigma_px: float = 0.3) -> tagcal.Dataset:
    """Views of a bent board, with noise of "one" size or each corner's own."""
    random = np.random.default_rng(1)
    board = tagcal.Board.grid(6, 6, 0.088, 0.3, border_bits=1)
    low, high = board.positions.min(axis=0), board.positions.max(axis=0)
    unit = (board.positions - (low + high) / 2)[:, :2] / ((high - low) / 2)[:2]
    points = board.positions + [0, 0, 1] * (bend_m * (1 - unit[:, :1] ** 2))
    views = []
    camera = tagcal.Camera.pinhole(900, 900, 639.5, 399.5, SIZE)
    for pose in tagcal.poses_on_dome(10, 1.0, 1.3, (low + high) / 2, 0.8, 1.4):
        sigma = np.full(len(points), sigma_px)
        if noise != "one":
            sigma *= random.uniform(0.5, 2, len(points))
        seen = camera.project(points, pose)
        seen += sigma[:, None] * random.standard_normal(seen.shape)
        if noise == "more than the corners' own":
            seen += sigma_px * random.standard_normal(seen.shape)
        inside = np.array([camera.contains(pixel) for pixel in seen])
        covariances = sigma[:, None, None] ** 2 * np.eye(2)
        claimed = None if noise == "one" else covariances[inside]
        views.append(tagcal.View(board.ids[inside], seen[inside], claimed))
    return tagcal.Dataset(SIZE, board, views)


@pytest.mark.parametrize(
    "bend_m, noise",
    [(0, "one"), (0, "corners"), (0, "more than the corners' own"), (0.004, "one")],
)
def test_residuals_are_those_of_the_calibration(bend_m: float, noise: str) -> None:
    dataset = exact_dataset(bend_m, noise)
    found = tagcal.calibrate(dataset, model="f", board_warp=bend_m > 0)
    arrows = arrows_of(tagcal.plot.residuals(found, dataset))
    rms = np.sqrt(np.mean(arrows.U**2 + arrows.V**2))
    assert rms == pytest.approx(found.rms_px, rel=1e-6)
    beside = tagcal.plot.residual_distribution(found, dataset)
    legend = [text.get_text() for text in beside.get_legend().get_texts()]
    (text,) = [text for text in legend if "residuals" in text]
    assert 0.96 <= float(text.split()[-1]) <= 1.04


def test_residuals_of_the_weak_model() -> None:
    dataset = exact_dataset(0, "one")
    found = tagcal.calibrate(dataset, model="weak")
    assert found.camera is None
    arrows = arrows_of(tagcal.plot.residuals(found, dataset))
    rms = np.sqrt(np.mean(arrows.U**2 + arrows.V**2))
    assert rms == pytest.approx(found.rms_px, rel=1e-6)


def test_residuals_need_views_and_their_data_set() -> None:
    refused = tagcal.calibrate(tagcal.Dataset(SIZE, DATASET.target, DATASET.views[:0]))
    with pytest.raises(tagcal.Error, match="calibration: has no views, so no residuals"):
        tagcal.plot.residuals(refused, DATASET)
    other = tagcal.Dataset(SIZE, DATASET.target, DATASET.views[:3])
    with pytest.raises(tagcal.Error, match="dataset: has fewer views than the calibration"):
        tagcal.plot.residuals(CALIBRATION, other)
    with pytest.raises(tagcal.Error, match="calibration: must be a Calibration, got Dataset"):
        tagcal.plot.residuals(DATASET, CALIBRATION)  # type: ignore[arg-type]


def test_coverage() -> None:
    axes = tagcal.plot.coverage(DATASET)
    check_image_axes(axes)
    assert axes.get_title() == "1444 corners in 12 views; 84% of the cells have corners"
    (dots,) = axes.lines
    assert len(dots.get_xdata()) == 1444
    (cells,) = axes.collections
    assert cells.get_array().sum() == 1444
    assert axes.figure.axes[1].get_ylabel() == "corners in a cell"


def test_coverage_of_views() -> None:
    axes = tagcal.plot.coverage(DATASET.views[:1], CAMERA)
    assert " corners in 1 view;" in axes.get_title()
    with pytest.raises(tagcal.Error, match="camera: is needed with views"):
        tagcal.plot.coverage(DATASET.views)
    with pytest.raises(tagcal.Error, match="dataset: must be a Dataset or a list of View"):
        tagcal.plot.coverage([[1, 2]], CAMERA)  # type: ignore[list-item]
    assert tagcal.plot.coverage([], CAMERA).get_title().startswith("0 corners in 0 views")


def test_uncertainty() -> None:
    axes = tagcal.plot.uncertainty(CALIBRATION)
    check_image_axes(axes)
    expected = tagcal.projection_uncertainty(CALIBRATION).region_px
    assert axes.get_title() == f"sd at infinity: {expected:.2g} px where corners were (RMS)"
    assert axes.figure.axes[1].get_ylabel() == "sd of the projection [px]"
    labels = [float(text.get_text().removesuffix(" px")) for text in axes.texts]
    sigma_px = tagcal.projection_uncertainty(CALIBRATION).sigma_px
    assert len(labels) > 1 and sigma_px.min() <= min(labels) < max(labels) <= sigma_px.max()
    (hull,) = axes.lines
    assert len(hull.get_xdata()) == len(CALIBRATION.seen.hull) + 1
    near = tagcal.plot.uncertainty(CALIBRATION.uncertain_camera, 0.9)
    assert near.get_title().startswith("sd at 0.9 m: ")


def test_uncertainty_where_a_fisheye_has_no_ray() -> None:
    camera = tagcal.Camera.fisheye(200, 200, 639.5, 399.5, SIZE, [0.1, -0.2])
    covariance = np.diag([1.0, 1, 1, 1, 1e-4, 1e-4, 1e-4, 1e-4])
    seen = tagcal.SeenRegion(SIZE, [(500, 300), (800, 300), (800, 500), (500, 500)])
    uncertain = tagcal.UncertainCamera(camera, "fisheye4", covariance, seen=seen)
    axes = tagcal.plot.uncertainty(uncertain)
    assert axes.collections[0].get_array().mask.any()


def test_uncertainty_needs_a_camera() -> None:
    weak = tagcal.calibrate(exact_dataset(0, "one"), model="weak")
    with pytest.raises(tagcal.Error, match="calibration: has no camera"):
        tagcal.plot.uncertainty(weak)
    with pytest.raises(tagcal.Error, match="calibration: must be a Calibration or .*, got Camera"):
        tagcal.plot.uncertainty(CAMERA)  # type: ignore[arg-type]


def test_difference() -> None:
    assert DATASET.truth is not None
    axes = tagcal.plot.difference(CALIBRATION, DATASET.truth.camera)
    check_image_axes(axes)
    found = tagcal.diff(CALIBRATION, DATASET.truth.camera)
    assert found is not None and found.rms_px < 0.01
    assert axes.get_title().startswith(f"difference at infinity: {found.rms_px:.2g} px RMS")
    assert np.allclose(arrows_of(axes).U, found.difference_px[..., 0].ravel())
    same = tagcal.plot.difference(DATASET.truth.camera, DATASET.truth.camera)
    assert float(same.get_title().split()[3]) < 1e-9


def test_poses() -> None:
    axes: Any = tagcal.plot.poses(CALIBRATION, DATASET)
    assert axes.get_title() == "12 cameras"
    assert [text.get_text() for text in axes.texts] == [str(i) for i in range(12)]
    assert len(axes.lines) == 1 + 36 + 2 * 12  # the board, its tags, pyramids with roofs
    labels = (axes.get_xlabel(), axes.get_ylabel(), axes.get_zlabel())
    assert labels == ("x [m]", "y [m]", "z [m]")
    centre = CALIBRATION.views[3].camera_from_world.inverse().translation
    assert np.allclose(axes.texts[3].get_position_3d(), centre)
    ranges = [np.ptp(axes.get_xlim()), np.ptp(axes.get_ylim()), np.ptp(axes.get_zlim())]
    box = axes._box_aspect
    assert np.allclose(box / box[0], np.array(ranges) / ranges[0])  # one scale


@pytest.mark.parametrize("kind", ["pose", "list", "estimate", "estimates", "none"])
def test_poses_of_all_kinds(kind: str) -> None:
    pose = CALIBRATION.views[0].camera_from_world
    board = DATASET.target[0].board
    points = DATASET.target[0].world_from_board.transform(board.positions)[:8]
    assert CAMERA is not None
    pixels = CAMERA.project(points, pose)
    views: Any = {
        "pose": pose,
        "list": [pose, CALIBRATION.views[1].camera_from_world],
        "estimate": tagcal.estimate_pose(points, pixels, CAMERA),
        "estimates": tagcal.estimate_poses(points, pixels[None], CAMERA),
        "none": [pose, tagcal.estimate_pose(points[:2], pixels[:2], CAMERA)],
    }[kind]
    axes = tagcal.plot.poses(views, board)
    expected = {"list": "2 cameras", "none": "1 camera; 1 without an answer"}
    assert axes.get_title() == expected.get(kind, "1 camera")


def test_poses_of_other_things() -> None:
    pose = tagcal.Pose()
    with pytest.raises(tagcal.Error, match="views: must be a Calibration, a Pose, .*, got int"):
        tagcal.plot.poses(3)
    with pytest.raises(tagcal.Error, match="views: .*, got str"):
        tagcal.plot.poses(["a"])
    with pytest.raises(tagcal.Error, match="target: must be a Board, .*, got str"):
        tagcal.plot.poses(pose, "board")
    with pytest.raises(tagcal.Error, match='ax: must be of projection="3d"'):
        tagcal.plot.poses(pose, ax=pyplot.figure().add_subplot())
    assert tagcal.plot.poses([]).get_title() == "0 cameras"
    pyplot.close("all")


def run(program: str, *options: str) -> str:
    done = subprocess.run(
        [sys.executable, *options, "-c", program], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_import_loads_no_matplotlib() -> None:
    run(
        "import sys, tagcal; assert 'plot' in dir(tagcal); assert 'tagcal.plot' not in sys.modules;"
        "tagcal.plot.poses; assert not any(m.startswith('matplotlib') for m in sys.modules)"
    )


def test_without_matplotlib(tmp_path: Path) -> None:
    message = run(
        "import sys; sys.modules['matplotlib'] = None\n"
        "import tagcal\n"
        "try: tagcal.plot.poses(tagcal.Pose())\n"
        "except ImportError as error: print(error)"
    )
    assert message.startswith("tagcal.plot needs matplotlib: install python3-matplotlib (Debian)")


def test_an_unknown_name_is_an_attribute_error() -> None:
    with pytest.raises(AttributeError, match="module 'tagcal' has no attribute 'plott'"):
        tagcal.plott
