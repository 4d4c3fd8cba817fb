"""Uncertainty of the projection, points with covariances, comparisons, advice, fits of lenses."""

import json
import pickle

import numpy as np
import pytest
import tagcal
from desk import DESK, SIZE, command_json, desk, opencv_lists

POINT = np.array([0.1, -0.05, 1.2])
INFINITY = float("inf")


@pytest.fixture(scope="module")
def data() -> tagcal.Dataset:
    return desk()


@pytest.fixture(scope="module")
def calibration(data: tagcal.Dataset) -> tagcal.Calibration:
    return tagcal.calibrate(data, "opencv4")


@pytest.fixture(scope="module")
def uncertain(calibration: tagcal.Calibration) -> tagcal.UncertainCamera:
    return calibration.uncertain_camera


def test_a_camera_knows_what_its_calibration_knows(
    calibration: tagcal.Calibration, uncertain: tagcal.UncertainCamera
) -> None:
    fx, sd = calibration.camera.parameters["fx"], calibration.sigmas["fx"]
    assert repr(uncertain) == f"<UncertainCamera opencv4, fx {fx:.3f} +- {sd:.2g}, 1280 x 800>"
    made = tagcal.UncertainCamera(
        calibration.camera,
        "opencv4",
        calibration.covariance,
        seen=calibration.seen,
        camera_error_px=calibration.camera_error_px,
    )
    np.testing.assert_array_equal(made.covariance, uncertain.covariance)
    assert made.sigmas == uncertain.sigmas == calibration.sigmas
    assert made.to_dict() == uncertain.to_dict()


def test_projection_of_points_has_the_covariance_of_lens_and_point(
    uncertain: tagcal.UncertainCamera,
) -> None:
    noise = np.diag([1e-6, 4e-6, 9e-6]) + 1e-7
    pixels, covariances = uncertain.project([POINT, -POINT], noise)
    _, by_pose, by_lens = uncertain.camera.jacobians(POINT, model="opencv4")
    by_point = by_pose[0][:, 3:]
    expected = by_lens[0] @ uncertain.covariance @ by_lens[0].T + by_point @ noise @ by_point.T
    np.testing.assert_allclose(covariances[0], expected, rtol=1e-12)
    np.testing.assert_array_equal(pixels[0], uncertain.camera.project(POINT))
    assert np.isnan(pixels[1]).all() and np.isnan(covariances[1]).all()  # behind the camera
    exact = tagcal.UncertainCamera(uncertain.camera)
    pixel, none = exact.project(POINT)
    assert pixel.shape == (2,) and none.shape == (2, 2) and not none.any()


def numeric_covariance(function, pixel: np.ndarray, sigma_px: float) -> np.ndarray:
    step = 1e-4
    columns = [(function(pixel + d) - function(pixel - d)) / (2 * step) for d in step * np.eye(2)]
    jacobian = np.stack(columns, axis=1)
    return sigma_px**2 * jacobian @ jacobian.T


def test_points_of_pixels_have_the_covariance_of_the_pixel(
    uncertain: tagcal.UncertainCamera,
) -> None:
    exact = tagcal.UncertainCamera(uncertain.camera)
    pixel = uncertain.camera.project(POINT)
    camera_from_plane = tagcal.Pose([0.4, 0.2, 0.1], [0.0, 0.1, 1.5])
    functions = {
        "direction": lambda camera, p, c: camera.direction(p, c),
        "depth": lambda camera, p, c: camera.point_at_depth(p, 1.2, covariances=c),
        "plane": lambda camera, p, c: camera.point_on_plane(p, camera_from_plane, c),
    }
    for name, function in functions.items():
        x, covariance = function(exact, pixel, 0.04 * np.eye(2))
        expected = numeric_covariance(lambda p: function(exact, p, None)[0], pixel, 0.2)
        np.testing.assert_allclose(covariance, expected, atol=1e-6 * np.max(expected))
        wider = function(uncertain, pixel, 0.04 * np.eye(2))[1]
        assert np.trace(wider) > np.trace(covariance), name
    np.testing.assert_allclose(functions["depth"](exact, pixel, None)[0], POINT, atol=1e-9)
    on_plane = functions["plane"](exact, pixel, None)[0]
    assert on_plane[2] == 0
    back = exact.project(camera_from_plane.transform(on_plane))[0]
    np.testing.assert_allclose(back, pixel, atol=1e-9)


def test_a_depth_may_be_uncertain_and_differ_from_point_to_point(
    uncertain: tagcal.UncertainCamera,
) -> None:
    exact = tagcal.UncertainCamera(uncertain.camera)
    pixels = uncertain.camera.project([POINT, 2 * POINT])
    points, covariances = exact.point_at_depth(pixels, [1.2, 2.4], [0.1, 0.0])
    np.testing.assert_allclose(points, [POINT, 2 * POINT], atol=1e-9)
    ray = POINT / POINT[2]
    np.testing.assert_allclose(covariances[0], 0.01 * np.outer(ray, ray), rtol=1e-6)
    assert not covariances[1].any()


def test_maps_at_any_distance_and_grid(calibration: tagcal.Calibration) -> None:
    for of_answer in calibration.projection:
        found = tagcal.projection_uncertainty(calibration, of_answer.distance_m)
        np.testing.assert_array_equal(found.sigma_px, of_answer.sigma_px)  # the model by its name
        assert found.region_px == of_answer.region_px
    grid = tagcal.ImageGrid(SIZE, columns=41, rows=25)
    fine = tagcal.projection_uncertainty(calibration, 1.0, grid)
    assert fine.sigma_px.shape == (25, 41) and grid.pixels.shape == (25, 41, 2)
    coarse = tagcal.projection_uncertainty(calibration, 1.0)
    np.testing.assert_allclose(fine.sigma_px[::2, ::2], coarse.sigma_px, rtol=1e-9)
    pixels = tagcal.ImageGrid(SIZE, 33, 21).pixels.reshape(-1, 2)
    whole = tagcal.projection_uncertainty(calibration.uncertain_camera, samples=pixels)
    assert whole.region_px > tagcal.projection_uncertainty(calibration).region_px
    weak = tagcal.weak_directions(calibration)
    assert [w.to_dict() for w in weak] == [w.to_dict() for w in calibration.weak_directions]


def test_two_cameras_differ_as_the_command_says(
    calibration: tagcal.Calibration, data: tagcal.Dataset
) -> None:
    turned = tagcal.diff(calibration, data.truth.camera)
    assert turned.rms_px < 3 * tagcal.projection_uncertainty(calibration).region_px
    near = tagcal.diff(data.truth.camera, calibration.camera, 1.0)
    assert near.difference_px.shape == (13, 21, 2) and near.distance_m == 1
    assert repr(near).startswith("<LensDifference at 1 m: rms 0.0")
    other = tagcal.Camera.pinhole(900, 900, 640, 400, SIZE)
    assert tagcal.diff(calibration, other).rms_px > 1
    camera = tagcal.Camera.pinhole(900, 900, 660, 390, SIZE)  # a turn explains most of it
    assert tagcal.diff(other, camera).rms_px < 5 < np.hypot(20, 10)


def test_the_difference_is_that_of_two_projections() -> None:
    a = tagcal.Camera.perspective(900, 900, 640, 400, SIZE, [-0.1])
    b = tagcal.Camera.pinhole(890, 905, 650, 390, SIZE)
    found = tagcal.diff(a, b)
    nodes = found.grid.pixels
    expected = b.project(a.unproject(nodes.reshape(-1, 2)), found.b_from_a).reshape(nodes.shape) - nodes
    np.testing.assert_allclose(found.difference_px, expected, atol=1e-6)


def test_files_give_the_same_difference_as_the_command(tmp_path) -> None:
    files = [tmp_path / "a.yaml", tmp_path / "b.yaml"]
    for file, model in zip(files, ["opencv4", "radial2"], strict=True):
        command_json("calibrate", DESK, "--model", model, "--out", file)
    command = command_json("diff", *files)["differences"]
    a, b = (tagcal.calibrate(desk(), model) for model in ["opencv4", "radial2"])
    for distance, expected in zip([INFINITY, 1.0], command, strict=True):
        found = tagcal.diff(a, b, distance)
        assert (found.rms_px, found.max_px) == (expected["rms_px"], expected["max_px"])
        lengths = np.hypot(*np.moveaxis(found.difference_px, 2, 0))
        np.testing.assert_allclose(lengths, expected["difference_px"], rtol=1e-14)


def test_views_are_selected_as_by_the_command(
    data: tagcal.Dataset, calibration: tagcal.Calibration
) -> None:
    found = tagcal.select_views(data, calibration, 5)
    command = command_json("calibrate", DESK, "--model", "opencv4", "--select", 5)["selection"]
    assert [v.image for v in found.views] == [v["image"] for v in command["views"]]
    assert found.all_px == command["all_views_projection_px"]
    assert [v.projection_px for v in found.views] == [
        v["projection_px"] or INFINITY for v in command["views"]
    ]
    part = tagcal.Dataset(data.size, data.target, [data.views[v.view] for v in found.views])
    assert tagcal.calibrate(part, "opencv4").status == "ok"
    for function in [lambda: tagcal.select_views(part, calibration, 2),
                     lambda: tagcal.advise(part, calibration)]:  # fmt: skip
        with pytest.raises(tagcal.Error, match="^dataset: must be the one that was calibrated, vi"):
            function()
    with pytest.raises(tagcal.Error, match="^count: must be > 0, got 0"):
        tagcal.select_views(data, calibration, 0)


def test_a_view_to_take_next(data: tagcal.Dataset, calibration: tagcal.Calibration) -> None:
    advised = tagcal.advise(data, calibration)
    assert advised.focal_sigma_px < advised.focal_sigma_now_px
    assert advised.sentence.startswith("show the board in the middle of the image, ")
    assert advised.camera_from_board.translation[2] == pytest.approx(advised.distance_m, abs=0.4)
    assert json.loads(json.dumps(advised.to_dict()))["tilt_rad"] == advised.tilt_rad


def test_lenses_of_other_models_project_alike(calibration: tagcal.Calibration) -> None:
    larger = tagcal.fit_lens(calibration, "opencv5")
    assert larger.refusal is None and larger.seen.max_px < 1e-9
    assert larger.sigmas["k3"] == 0 and larger.covariance.shape == (9, 9)
    assert larger.sigmas["fx"] == pytest.approx(calibration.sigmas["fx"], rel=1e-9)
    other = tagcal.fit_lens(calibration, "fisheye4")
    assert "fisheye4 differs from the lens by up to" in other.refusal
    assert repr(other).startswith("<LensFit refused: model fisheye4 differs")
    accepted = tagcal.fit_lens(calibration.camera, "fisheye4", max_difference_px=20)
    assert accepted.refusal is None and accepted.camera.lens == "fisheye"
    assert accepted.covariance is None and accepted.difference_px.shape == (
        accepted.grid.rows, accepted.grid.columns
    )  # fmt: skip


def test_a_double_sphere_is_a_camera() -> None:
    source = tagcal.Camera.double_sphere(400, 401, 320, 240, (640, 480), -0.2, 0.55)
    assert source.parameters["xi"] == -0.2 and repr(source).startswith("<Camera double sphere 640")
    assert pickle.loads(pickle.dumps(source)) == source
    pixels = np.array([[100.0, 200.0], [320, 240]])
    np.testing.assert_allclose(source.project(3 * source.unproject(pixels)), pixels, atol=1e-9)
    fit = tagcal.fit_lens(source, "fisheye4")
    assert fit.camera.lens == "fisheye" and fit.refusal is None
    np.testing.assert_allclose(fit.camera.project(source.unproject(pixels)), pixels, atol=0.1)


def test_where_the_camera_is(calibration: tagcal.Calibration, data: tagcal.Dataset) -> None:
    camera = calibration.camera
    pose = tagcal.Pose.looking_at([0.3, -0.4, 0.5], [0, 0, 0], [0, 0, 1])
    points = np.array([[-0.1, -0.1, 0], [0.1, -0.1, 0], [0.1, 0.1, 0], [-0.1, 0.1, 0]])
    estimate = tagcal.estimate_pose(points, camera.project(points, pose), camera, sigma_px=0.1)
    place = tagcal.camera_in_target(estimate.hypotheses[0])
    np.testing.assert_allclose(place.position_m, [0.3, -0.4, 0.5], atol=1e-6)
    assert place.azimuth_rad == pytest.approx(np.arctan2(0.4, -0.3), abs=1e-5)
    assert place.elevation_rad == pytest.approx(-np.arctan2(0.5, 0.5), abs=1e-5)
    assert place.roll_rad == pytest.approx(0, abs=1e-5) and not place.gimbal_lock
    assert np.all(np.linalg.eigvalsh(place.covariance) > 0)
    assert repr(place).startswith("<CameraInTarget at (0.3, -0.4, 0.5) m, azimuth 2.214")


def test_the_region_of_corners() -> None:
    region = tagcal.SeenRegion((640, 480), [[10, 10], [600, 20], [300, 400], [200, 100]])
    np.testing.assert_array_equal(region.hull, [[10, 10], [600, 20], [300, 400]])
    assert region.contains([[300, 200], [5, 5], [np.nan, 1]]).tolist() == [True, False, False]
    assert region.contains([300, 200]).shape == () and region.contains([300, 200])
    assert region.contains(region.samples()).all() and 0.3 < region.share < 0.4
    assert region.missing_parts == ["lower left corner", "lower right corner"]
    assert region.gaps.startswith("no corners in the lower left and lower right corners of the ima")
    empty = tagcal.SeenRegion((640, 480), np.zeros((0, 2)))
    assert empty.hull.shape == (0, 2) and empty.share == 0 and empty.missing_parts == []


def test_a_camera_against_opencv_and_the_truth(data: tagcal.Dataset, tmp_path) -> None:
    found = tagcal.calibrate(data)
    check = tagcal.validate(found, data)
    assert check.opencv_agrees and check.num_views == 12 and check.num_beyond_truth == 0
    assert max(abs(p.in_sigmas or 0) for p in check.parameters) < 5
    assert repr(check) == ("<Validation OpenCV agrees, rms 0.2369 px over 12 views, no parameter "
                           "beyond 5 sd of the truth>")  # fmt: skip
    file = tmp_path / "camera.yaml"
    command_json("calibrate", DESK, "--out", file)
    command = command_json("validate", file, "--dataset", DESK)
    for name in ["rms_px", "max_projection_difference_px", "max_jacobian_difference", "warnings",
                 "num_compared", "num_views", "num_without_pose", "parameters"]:  # fmt: skip
        assert check.to_dict()[name] == command[name], name
    wrong = tagcal.Camera.pinhole(700, 700, 640, 400, SIZE)
    assert tagcal.validate(wrong, data).rms_px > 1
    with pytest.raises(tagcal.Error, match="^camera: must have the image size of the data set"):
        tagcal.validate(tagcal.Camera.pinhole(700, 700, 320, 240, (640, 480)), data)


def grid(columns: int, rows: int) -> tagcal.ImageGrid:
    return tagcal.ImageGrid(SIZE, columns, rows)


@pytest.mark.parametrize(
    "call, message",
    [
        (lambda c, u: tagcal.diff(3, c), "a: must be a Camera, an UncertainCamera or a Calibratio"),
        (lambda c, u: tagcal.diff(c, c, 0), "distance_m: must be > 0, infinity too, got 0"),
        (lambda c, u: tagcal.diff(c, c, 1, True, [[1, 2]]), "samples: give them or whole_image, n"),
        (lambda c, u: tagcal.diff(c, c, samples=[1, 2, 3]), r"samples: must have the shape \(N, 2"),
        (lambda c, u: tagcal.projection_uncertainty(c.camera), "camera: must have a covariance, a"),
        (lambda c, u: tagcal.weak_directions(c.camera), "camera: must have a covariance, as"),
        (lambda c, u: tagcal.fit_lens(c, "weak"), "model: a lens with parallel rays cannot be fit"),
        (lambda c, u: tagcal.fit_lens(c, "f", -1), r"max_difference_px: must be >= 0 \(0: 0.1 px"),
        (lambda c, u: grid(1, 5), "columns, rows: must be >= 2, at most 262144 nodes in all, got "),
        (lambda c, u: grid(2**31 - 1, 2), "columns, rows: must be >= 2, at most 262144 nodes in a"),
        (lambda c, u: u.project(POINT, np.eye(2)), r"covariances: must have the shape \(1, 3, 3\)"),
        (lambda c, u: u.project(POINT, -np.eye(3)), "covariances: must have variances from 0 to 1"),
        (lambda c, u: u.point_at_depth([1, 2], 0), "depth_m: must be > 0, got 0"),
        (lambda c, u: u.point_at_depth([1, 2], [1, 2]), r"depth_m: must be a number or have the s"),
        (lambda c, u: u.point_on_plane([1, 2], 7), r"camera_from_plane: must have the shape \(4, "),
        (lambda c, u: tagcal.UncertainCamera(c.camera, None, [[1]]), "covariance: needs the model"),
        (lambda c, u: tagcal.UncertainCamera(c.camera, "f", np.eye(2)), r"covariance: must have t"),
        (lambda c, u: tagcal.UncertainCamera(c.camera, "fisheye4"), "model: fisheye4 has another "),
        (lambda c, u: tagcal.UncertainCamera(c.camera, camera_error_px=-1), "camera_error_px: mus"),
        (lambda c, u: tagcal.Camera.double_sphere(1, 1, 0, 0, SIZE, 1, 0.5), "lens: xi must be "),
        (lambda c, u: tagcal.Camera.extended_unified(1, 1, 0, 0, SIZE, 2), "lens: alpha must be f"),
        (lambda c, u: tagcal.SeenRegion(SIZE, [[1, np.inf]]), "pixels: must be finite, got inf in"),
    ],
)
def test_arguments_that_are_refused(call, message: str, calibration, uncertain) -> None:
    with pytest.raises(tagcal.Error, match="^" + message) as error:
        call(calibration, uncertain)
    assert "\n" not in str(error.value)


def test_noise_of_the_answers_is_what_they_say() -> None:
    """Over several noisy data sets the focal length scatters as its standard deviation says."""
    errors = []
    points, exact, _ = opencv_lists(num_views=6)
    random = np.random.default_rng(3)
    for _ in range(12):
        pixels = [p + 0.1 * random.standard_normal(p.shape) for p in exact]
        found = tagcal.calibrate(points, pixels, SIZE, "opencv4")
        errors.append((found.camera.parameters["fx"] - 902.5) / found.sigmas["fx"])
    assert 0.5 < np.std(errors) < 1.7 and np.max(np.abs(errors)) < 4
