"""calibrate, against the command, the truth and cv2.calibrateCamera."""

import json

import cv2
import numpy as np
import pytest
import tagcal
from desk import DESK, DISTORTION, SIZE, K, command_json, desk, opencv_lists

KEPT = {"reject_outliers": False}


@pytest.fixture(scope="module")
def calibration() -> tagcal.Calibration:
    return tagcal.calibrate(desk())


def test_is_the_answer_of_the_command_to_the_last_bit(calibration: tagcal.Calibration) -> None:
    command = command_json("calibrate", DESK, "--advise")
    for name in ["status", "model", "fixed", "rms_px", "sigma_px", "sigma_of_corners", "halves",
                 "model_error_px", "variance_inflation", "num_corners", "weak_directions",
                 "findings", "board_warp"]:  # fmt: skip
        assert calibration.to_dict()[name] == command[name], name
    parameters, sigmas = calibration.camera.parameters, calibration.sigmas
    for found, expected in [(parameters, command["camera"]), (sigmas, command["sigma"])]:
        assert [found[n] for n in ["fx", "fy", "cx", "cy"]] == list(expected.values())[:4]
        names = ["k1", "k2", "p1", "p2", "k3"]
        assert [found[n] for n in names] == expected["distortion"]
    assert calibration.seen.share == command["seen_share"]
    for view, expected in zip(calibration.views, command["views"], strict=True):
        assert view.camera_from_world.quaternion.tolist() == expected["rotation"]
        assert view.camera_from_world.translation.tolist() == expected["translation_m"]
        assert (view.image, view.num_corners) == (expected["image"], expected["num_corners"])
        assert view.rms_px == expected["rms_px"]
    for outlier, expected in zip(calibration.outliers, command["outliers"], strict=True):
        assert outlier.id == (expected["tag_id"], expected["corner"])
        assert outlier.residual_px == expected["residual_px"]
    for step, expected in zip(calibration.steps, command["steps"], strict=True):
        assert (step.model, step.cost, step.bic) == tuple(expected[n] for n in ("model", "cost",
                                                                                "bic"))
        assert (step.taken, step.sentence) == (expected["taken"], expected["sentence"])
    for found, expected in zip(calibration.projection, command["projection"], strict=True):
        assert (found.region_px, found.region_max_px) == (expected["rms_px"], expected["max_px"])
        assert found.sigma_px.shape == (13, 21)
        assert found.sigma_px[6, 10] == expected["centre_px"]
    advice = tagcal.advise(desk(), calibration)
    assert advice.pixel.tolist() == command["advice"]["pixel"]
    for name in ["distance_m", "focal_sigma_now_px", "focal_sigma_px", "projection_px", "fills",
                 "sentence"]:  # fmt: skip
        assert getattr(advice, name) == command["advice"][name], name


def test_reads_well_and_gives_plain_values(calibration: tagcal.Calibration) -> None:
    fx, sd = calibration.camera.parameters["fx"], calibration.sigmas["fx"]
    assert 0.01 < sd < 0.05  # two digits, three decimals
    assert repr(calibration) == (
        f"<Calibration ok, opencv4, f {fx:.3f} +- {sd:.3f} px, rms {calibration.rms_px:.4f} px>"
    )
    assert calibration.camera.parameters["fx"] == pytest.approx(902.5, abs=3 * sd)
    assert calibration.is_answer and calibration.solver_camera == calibration.camera
    assert calibration.covariance.shape == (8, 8)
    assert calibration.free_parameters == ["fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2"]
    assert calibration.sigmas["fx"] == np.sqrt(calibration.covariance[0, 0])
    assert repr(calibration.claim) == "<Claim opencv5, 9 parameters>"
    assert calibration.claim.parameters[:4] == ["fx", "fy", "cx", "cy"]
    plain = json.loads(json.dumps(calibration.to_dict()))
    assert plain["views"][3]["image"] == "003.png"
    assert np.array(plain["claim"]["covariance"]).shape == (9, 9)
    assert repr(calibration.seen) == "<SeenRegion 80.9 % of the image>"
    assert repr(calibration.projection[0]).startswith("<ProjectionUncertainty at infinity: rms 0.0")
    assert repr(calibration.views[0]) == '<CalibratedView "000.png" 104 corners, rms 0.012 px>'
    outlier = calibration.outliers[0]
    view = desk().views[outlier.view]
    assert tuple(view.ids[outlier.corner]) == outlier.id and view.image == outlier.image


def test_finds_the_truth_without_noise() -> None:
    points, pixels, poses = opencv_lists()
    found = tagcal.calibrate(points, pixels, SIZE, "opencv4")
    # Not to the rounding: the priors of lens and board pull as they do for the least noise that is
    # assumed.
    assert found.status == "ok" and found.rms_px < 1e-6
    np.testing.assert_allclose(found.camera.matrix, K, atol=1e-4)
    np.testing.assert_allclose(found.camera.distortion[:5], DISTORTION, atol=1e-7)
    for view, pose in zip(found.views, poses, strict=True):
        assert view.camera_from_world.distance_to(pose) < 1e-7
        assert view.camera_from_world.angle_to(pose) < 1e-7


def test_agrees_with_opencv_on_the_same_lists() -> None:
    points, pixels, _ = opencv_lists(0.1, 12)
    found = tagcal.calibrate(points, pixels, SIZE, model="opencv5", **KEPT)
    rms, matrix, distortion, *_, sigmas, _, _ = cv2.calibrateCameraExtended(
        [p.astype(np.float32) for p in points],
        [p.astype(np.float32) for p in pixels],
        SIZE,
        None,
        None,
    )
    # Ours has four unknowns more, the shape of the board, and priors: the minima differ by a part of
    # the standard deviations, which ours estimates in part from the scatter of the 12 views.
    assert found.rms_px == pytest.approx(rms, rel=2e-3)
    expected = np.array([found.sigmas[name] for name in found.free_parameters])
    # OpenCV 4.6 counts points, not coordinates, when it estimates the noise from the residuals.
    num_points, unknowns = sum(map(len, points)), 9 + 6 * len(points)
    wrong = np.sqrt((2 * num_points - unknowns) / (num_points - unknowns))
    ratio = sigmas[:9, 0] / expected
    assert ratio == pytest.approx(1, rel=0.15) or ratio == pytest.approx(wrong, rel=0.15)
    theirs = [*matrix[[0, 1, 0, 1], [0, 1, 2, 2]], *distortion.ravel()]
    ours = [found.camera.parameters[name] for name in found.free_parameters]
    assert np.all(np.abs(np.subtract(ours, theirs)) < 0.5 * expected)


def test_lists_of_float32_and_data_sets_are_the_same_problem() -> None:
    points, pixels, _ = opencv_lists(0.1)
    points32 = [p.astype(np.float32).reshape(-1, 1, 3) for p in points]
    pixels32 = [p.astype(np.float32).reshape(-1, 1, 2) for p in pixels]
    of_lists = tagcal.calibrate(points32, pixels32, SIZE)
    of_data = tagcal.calibrate(tagcal.Dataset.from_points(points32, pixels32, SIZE), threads=2)
    assert of_lists.camera == of_data.camera
    np.testing.assert_array_equal(of_lists.covariance, of_data.covariance)


def test_one_view_from_the_front_is_refused() -> None:
    board = np.array([[0.05 * x, 0.05 * y, 0.0] for y in range(7) for x in range(9)])
    pixels = board[:, :2] * 1000 + [400, 200]
    found = tagcal.calibrate([board], [pixels], SIZE)
    assert not found.is_answer and found.status == "focal_not_observable"
    assert found.camera is None and found.covariance is None and found.sigmas == {}
    assert repr(found).startswith("<Calibration no answer: focal_not_observable: ")
    assert any(finding.severity == "refusal" for finding in found.findings)
    with pytest.raises(tagcal.Error, match="^no answer: focal_not_observable: "):
        found.uncertain_camera
    with pytest.raises(tagcal.Error, match="^camera: no answer: focal_not_observable: "):
        tagcal.projection_uncertainty(found)
    data = tagcal.Dataset.from_points([board], [pixels], SIZE)
    assert "tilted" in tagcal.advise(data, found).sentence
    assert found.views[0].scale_px_per_m == pytest.approx(1000)  # what it does determine


def test_a_refused_model_shows_no_poses() -> None:
    board = np.array([[0.05 * x, 0.05 * y, 0.0] for y in range(7) for x in range(9)])
    pixels = [scale * board[:, :2] + [400, 200] for scale in (900, 1000, 1100)]
    found = tagcal.calibrate([board] * 3, pixels, SIZE, model="f+c")
    assert not found.is_answer and found.solver_camera is not None
    assert found.camera is None and found.views == []


def test_a_view_of_wrong_corners_is_rejected() -> None:
    points, pixels, _ = opencv_lists(0.1)
    pixels[3] = np.random.default_rng(8).permutation(pixels[3])
    found = tagcal.calibrate(points, pixels, SIZE)
    assert found.status == "ok" and [v.view for v in found.views] == [0, 1, 2, 4, 5, 6, 7]
    assert found.camera.parameters["fx"] == pytest.approx(902.5, abs=5 * found.sigmas["fx"])
    kept = tagcal.calibrate(points, pixels, SIZE, **KEPT)
    assert all(outlier.view == 3 for outlier in kept.outliers)  # it has no pose to start from


def test_nothing_to_calibrate_is_no_answer() -> None:
    for lists in [([], []), ([np.zeros((0, 3))], [np.zeros((0, 2))])]:
        found = tagcal.calibrate(*lists, SIZE)
        assert found.status == "degenerate" and found.camera is None and found.solver_camera is None
        assert found.views == [] and found.free_parameters == []
        json.dumps(found.to_dict())


def test_every_option_has_its_effect() -> None:
    points, pixels, _ = opencv_lists(0.1)

    def calibrated(**options: object) -> tagcal.Calibration:
        found = tagcal.calibrate(points, pixels, SIZE, **options)
        assert found.status == "ok", found
        return found

    plain = calibrated(model="opencv4")
    assert plain.model == "opencv4" and plain.sigma_from_residuals
    stated = calibrated(model="opencv4", sigma_px=0.2)
    assert stated.sigma_px == 0.2 and not stated.sigma_from_residuals
    held = calibrated(model="opencv4", fixed={"cx": 651, "k2": 0.05})
    assert held.fixed == {"cx": 651.0, "k2": 0.05} and held.camera.parameters["cx"] == 651
    assert held.sigmas["cx"] == 0 and held.covariance.shape == (6, 6)
    assert held.free_parameters == ["fx", "fy", "cy", "k1", "p1", "p2"]
    near = calibrated(model="opencv4", start=plain.camera)
    assert near.camera.parameters["fx"] == pytest.approx(plain.camera.parameters["fx"], rel=1e-9)
    assert calibrated(model="opencv4", start_focal_px=850).camera.matrix[0, 0] == pytest.approx(
        plain.camera.matrix[0, 0], rel=1e-9
    )
    assert len(calibrated(tolerance_px=0.5).camera.parameters) == len(plain.camera.parameters)
    assert calibrated(tolerance_px=0.5).model != plain.model
    bent = calibrated(model="opencv4", board_warp=True).board_warp
    assert np.all(np.abs(bent.bend_mm) < 5 * bent.sigma_mm)
    still = calibrated(model="opencv4", times_s=np.arange(len(pixels)) / 30).readout
    assert abs(still.seconds) < 4 * still.sigma_s and still.num_views == len(pixels)
    assert calibrated(model="opencv4").readout is None
    far = calibrated(model="opencv4", distances_m=[np.inf, 0.5, 2]).projection
    median = calibrated(model="opencv4").projection[1].distance_m
    assert [p.distance_m for p in far] == [np.inf, median, 0.5, 2.0]
    spoiled = [p.copy() for p in pixels]
    spoiled[2][7] += 40
    found = tagcal.calibrate(points, spoiled, SIZE)
    assert [(o.view, o.corner) for o in found.outliers] == [(2, 7)]
    assert tagcal.calibrate(points, spoiled, SIZE, reject_outliers=False).outliers == []
    weak = calibrated(model="weak")
    assert weak.camera is None and weak.views[0].scale_px_per_m > 0 and weak.covariance is None
    with pytest.raises(tagcal.Error, match="^model weak has no camera for all views"):
        weak.uncertain_camera


@pytest.mark.parametrize(
    "options, message",
    [
        ({"model": "opencv9"}, "model: must be one of .*opencv5.*; got opencv9"),
        ({"sigma_px": -1}, r"sigma_px: must be >= 0 \(0: estimated\), got -1"),
        ({"sigma_px": np.nan}, "sigma_px: must be >= 0"),
        ({"start_focal_px": np.inf}, r"start_focal_px: must be >= 0 \(0: none\), got inf"),
        ({"tolerance_px": -0.1}, "tolerance_px: must be >= 0"),
        ({"tolerance_px": 0.1, "model": "opencv5"}, "tolerance_px: needs model auto, got opencv5"),
        ({"max_iterations": 0}, "max_iterations: must be > 0, got 0"),
        ({"threads": -1}, r"threads: must be >= 0 \(0: one per core\), got -1"),
        ({"distances_m": [1, 0]}, "distances_m: must be > 0, infinity too, got 0"),
        ({"distances_m": [np.nan]}, "distances_m: must be > 0, infinity too, got nan"),
        ({"times_s": [0, np.nan]}, "times_s: must be finite, got nan"),
        ({"times_s": [0, 1]}, "times_s: must have the time of each of .* views, got 2"),
        ({"fixed": {"k1": 0.1}}, "fixed: k1 needs a model by its name"),
        ({"fixed": {"fz": 1}}, "fixed: must be one of f, fx, fy, .*; got fz"),
        ({"fixed": {"": 1}}, "fixed: must be one of f, fx, fy, .*; got "),
        ({"fixed": {"fx": -1}}, "fixed: fx must be > 0, got -1"),
        ({"fixed": {"cx": np.nan}}, "fixed: cx must be a number, got nan"),
        ({"model": "weak", "board_warp": True}, "board_warp: model weak has no perspective"),
        (
            {"start": tagcal.Camera.pinhole(600, 600, 320, 240, (640, 480))},
            "start: must have the image size of the data set",
        ),
        (
            {"start": tagcal.Camera.fisheye(600, 600, 640, 400, SIZE), "model": "f"},
            "start: is a fisheye lens, model f needs another kind of lens",
        ),
    ],
)
def test_options_that_are_refused(options: dict, message: str) -> None:
    with pytest.raises(tagcal.Error, match="^" + message) as error:
        tagcal.calibrate(desk(), **options)
    assert "\n" not in str(error.value)


def test_a_bend_needs_one_flat_board() -> None:
    points = np.random.default_rng(1).uniform(-0.1, 0.1, (20, 3))
    pixels = points[:, :2] * 900 + 400
    with pytest.raises(tagcal.Error, match="^board_warp: needs exactly one board, and a flat one"):
        tagcal.calibrate([points], [pixels], SIZE, board_warp=True)


def test_options_are_keywords() -> None:
    with pytest.raises(tagcal.Error, match="^calibrate: after a Dataset and the model all argume"):
        tagcal.calibrate(desk(), "auto", 0.1)
    with pytest.raises(TypeError):
        tagcal.calibrate(desk(), modell="auto")
