"""Results can be pickled, so that processes exchange them and caches keep them."""

import copy
import multiprocessing
import pickle

import numpy as np
import pytest
import tagcal
from desk import DESK, desk
from test_handeye import desk_on_a_robot
from test_rig import datasets

WITHOUT = {
    "Error": "an exception",
    "Scene": "its paths are functions",
    "CameraFormat": "a row of a table",
}


def seen_classes(value: object, found: dict[type, object]) -> None:
    """Adds one instance of each class of tagcal in the fields of a result."""
    if type(value).__module__.startswith("tagcal"):
        found.setdefault(type(value), value)
        for name in getattr(value, "_fields", ()):
            seen_classes(getattr(value, name), found)
    if isinstance(value, (list, tuple)):
        for element in value:
            seen_classes(element, found)


@pytest.fixture(scope="module")
def results() -> dict[type, object]:
    folder = tagcal.read_dataset(DESK)
    dataset = folder.dataset
    calibration = tagcal.calibrate(desk())
    camera = calibration.camera
    board = tagcal.Board.grid(2, 2, 0.08, 0.3)
    smooth, sharp = tagcal.Denoise(2.0, 1.0), tagcal.Sharpen(0.5, 1.0)
    sensor = tagcal.Sensor(mosaic=tagcal.Mosaic(), denoise=smooth, sharpen=sharp)
    poses = tagcal.poses_on_ring(2, 0.3, [0.1, 0.1, 0.6], [0.1, 0.1, 0])
    picture = tagcal.render(tagcal.Scene(camera, board, poses))
    view = tagcal.detect(picture, board)
    points, pixels = (x[0][:4] for x in dataset.to_points())
    weak = tagcal.calibrate(dataset, "weak")
    rig_sets = datasets(6)
    rig = tagcal.calibrate_rig(rig_sets)
    seen_by_rig = [s.views[0] for s in rig_sets]
    rig_pixels = [view.pixels[0] for view in seen_by_rig]
    everything = [
        folder, calibration, weak, sensor, view,
        calibration.uncertain_camera,
        tagcal.DirectionalLamp([0, 0, -1]), tagcal.PointLamp([0, 0, 1]), tagcal.Light(0.5),
        tagcal.cuboid([1, 1, 1], poses[0]),
        tagcal.detect_all([picture], board),
        tagcal.detect_tags(picture, border_bits=2),
        tagcal.explain(picture, board),
        tagcal.explain(picture, tagcal.Board.tag(0.08, 99)),
        tagcal.refine_tag(picture, 0, view.pixels[:4]),
        tagcal.refine_corner(np.zeros((40, 40), np.uint8), np.diag([9, 9, 1.0])),
        tagcal.estimate_pose(points, pixels, camera),
        tagcal.estimate_poses(points, pixels[None], camera),
        tagcal.estimate_pose_and_focal(*(x[0] for x in dataset.to_points()), dataset.size),
        rig, tagcal.known_rig(rig),
        tagcal.estimate_rig_pose(seen_by_rig, rig_sets[0].target, tagcal.known_rig(rig)),
        tagcal.check_camera(dataset, tagcal.Camera.pinhole(850, 850, 639.5, 399.5, camera.size)),
        desk_on_a_robot(), desk_on_a_robot("base"), tagcal.read_robot_poses(DESK / "robot.csv"),
        tagcal.rectify(tagcal.known_rig(rig)),
        tagcal.vertical_disparity(
            tagcal.known_rig(rig), tagcal.rectify(tagcal.known_rig(rig)), *rig_pixels),
        tagcal.triangulate(tagcal.known_rig(rig), rig_pixels),
        tagcal.diff(calibration, dataset.truth.camera),
        tagcal.select_views(dataset, calibration, 2),
        tagcal.advise(dataset, calibration),
        tagcal.camera_in_target(tagcal.estimate_pose(points, pixels, camera).hypotheses[0]),
        tagcal.fit_lens(calibration, "opencv5"),
        tagcal.panorama_of(camera), tagcal.angular_range(camera),
        tagcal.several_pinholes(camera, 5),
        tagcal.PlaneRaster([0, 0], 0.001, (9, 9)),
        tagcal.read_cameras(DESK / "truth.yaml"),
        tagcal.validate(calibration, dataset),
        tagcal.calibrate(dataset, times_s=np.arange(12) / 30),
        population(), tagcal.unit_distances(population(), np.zeros((1, 2)), np.eye(2)[None]),
        tagcal.estimate_history(8 * [calibration]),
        tagcal.estimate_trend(
            np.zeros((3, 2)), np.tile(np.eye(2), (3, 1, 1)), [[1.0], [2.0], [3.0]]),
    ]  # fmt: skip
    found: dict[type, object] = {}
    seen_classes(everything, found)
    return found


def population() -> tagcal.Population:
    values = np.random.default_rng(1).normal(size=(60, 2))
    return tagcal.estimate_population(values, np.tile(0.1 * np.eye(2), (60, 1, 1)))


def state(value: object) -> object:
    return value.__reduce_ex__(2)[2]


def same(a: object, b: object) -> bool:
    if isinstance(a, np.ndarray):
        return a.dtype == b.dtype and np.array_equal(a, b, equal_nan=True)
    if isinstance(a, (list, tuple)):
        return type(a) is type(b) and len(a) == len(b) and all(map(same, a, b))
    if type(a).__module__.startswith("tagcal"):
        return type(a) is type(b) and same(state(a), state(b))
    return type(a) is type(b) and (a == b or a != a)


def test_every_class_is_the_same_after_pickle(results: dict[type, object]) -> None:
    for value in results.values():
        if type(value).__name__ in WITHOUT:
            continue
        for again in (pickle.loads(pickle.dumps(value)), copy.deepcopy(value)):
            assert type(again) is type(value)
            assert " object at " in repr(value) or repr(again) == repr(value)
            assert same(state(again), state(value)), value
            if hasattr(value, "to_dict"):
                assert repr(again.to_dict()) == repr(value.to_dict())


def test_every_class_has_a_state(results: dict[type, object]) -> None:
    """Those that no result above has are made in rare cases only."""
    classes = {getattr(tagcal, name) for name in tagcal._core.__all__}
    classes = {c for c in classes if isinstance(c, type)}
    assert {c.__name__ for c in classes if "__getstate__" not in vars(c)} == set(WITHOUT)
    missing = {c.__name__ for c in classes - set(results)} - set(WITHOUT)
    assert missing <= {"NotReported", "UnfittedTag", "ImageSequence", "WeakDirection"}, missing


def test_what_has_no_state_says_so() -> None:
    camera = tagcal.Camera.pinhole(100, 100, 9, 9, (20, 20))
    scene = tagcal.Scene(camera, tagcal.Board.tag(0.1, 1), tagcal.Pose())
    with pytest.raises(TypeError, match="Scene"):
        pickle.dumps(scene)


def test_a_state_of_another_version_is_refused() -> None:
    finding = tagcal.calibrate(desk(), "f").findings[0]
    version, members = state(finding)
    assert version == tagcal.__version__
    for wrong in ((version + "x", members), (version, members[:-1]), (version, None), (version,)):
        again = tagcal.Finding.__new__(tagcal.Finding)
        with pytest.raises(tagcal.Error, match="no state of a Finding of tagcal " + version):
            again.__setstate__(wrong)


def calibrated(model: str) -> tagcal.Calibration:
    return tagcal.calibrate(desk(), model)


def test_processes_return_calibrations() -> None:
    with multiprocessing.get_context("spawn").Pool(2) as pool:
        several = pool.map(calibrated, ["radial1", "opencv4"])
    assert [c.model for c in several] == ["radial1", "opencv4"]
    assert several[0].camera == calibrated("radial1").camera
