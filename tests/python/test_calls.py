"""A call whose arguments fit no signature says what is wrong in one line."""

import inspect
import pydoc
import re

import numpy as np
import pytest
import tagcal
import tagcal.plot
from desk import desk

CAMERA = tagcal.Camera.pinhole(500, 500, 319.5, 239.5, (640, 480))
POINTS, PIXELS = np.zeros((4, 3)), np.zeros((4, 2))


@pytest.mark.parametrize(
    "call, message",
    [
        (
            lambda: tagcal.calibrate(desk(), modle="f"),
            "calibrate() has no argument 'modle': did you mean 'model'?",
        ),
        (
            lambda: tagcal.estimate_pose(POINTS, PIXELS, CAMERA, sigma=1),
            "estimate_pose() has no argument 'sigma': did you mean 'sigma_px'?",
        ),
        (
            lambda: CAMERA.project(POINTS, zz=1),
            "Camera.project() has no argument 'zz': it has points, camera_from_points, out",
        ),
        (
            lambda: tagcal.Board.tag(size=0.1, idd=7),
            "tag() has no argument 'idd': did you mean 'id'?",
        ),
        (
            lambda: tagcal.Pose(rotatoin=[0, 0, 0], translation=[0, 0, 0]),
            "Pose() has no argument 'rotatoin': did you mean 'rotation'?",
        ),
        (
            lambda: tagcal.estimate_pose(POINTS, PIXELS),
            "estimate_pose() needs the argument 'camera'",
        ),
        (
            lambda: tagcal.estimate_pose(POINTS, PIXELS, [1, 2]),
            "estimate_pose(): camera: must be a Camera, got list",
        ),
        (
            lambda: tagcal.estimate_pose(POINTS, PIXELS, CAMERA, camera=CAMERA),
            "estimate_pose() got 'camera' twice",
        ),
        (
            lambda: tagcal.estimate_pose(POINTS, PIXELS, CAMERA, "x"),
            "estimate_pose(): sigma_px: must be a number, got str",
        ),
        (lambda: tagcal.calibrate(desk(), 3), "calibrate(): model: must be a text, got int"),
        (lambda: tagcal.model_names(1), "model_names() has 0 arguments, got 1"),
        (
            lambda: tagcal.calibrate_rig([], "f", 0.1),
            "calibrate_rig(): arguments after 'model' are named",
        ),
        (
            lambda: tagcal.calibrate(desk(), start=3),
            "calibrate(): start: must be a Camera or None, got int",
        ),
        (
            lambda: tagcal.detect_all(["a.png"], tagcal.Board.tag(0.1, 1), names=3),
            "detect_all(): names: must be a list of text or None, got int",
        ),
    ],
)
def test_wrong_call(call, message):
    with pytest.raises(TypeError) as error:
        call()
    assert str(error.value) == message
    assert not isinstance(error.value, tagcal.Error)


def test_every_function_explains_itself():
    """No call without arguments, or with one that does not exist, has more than one line."""
    for name in tagcal._core.__all__:
        value = getattr(tagcal, name)
        functions = [value] if not inspect.isclass(value) else []
        if inspect.isclass(value) and value is not tagcal.Error:
            functions = [
                getattr(value, member)
                for member, kind in vars(value).items()
                if isinstance(kind, staticmethod) or not member.startswith("_")
                if not isinstance(kind, property) and callable(getattr(value, member))
            ]
        for function in functions:
            with pytest.raises(TypeError) as error:
                function(no_such_argument=1)
            assert re.fullmatch(r"[\w.]+\(\).*'no_such_argument'.*", str(error.value))


def test_help_is_short_and_names_every_class_and_function():
    text = pydoc.plain(pydoc.render_doc(tagcal))
    assert len(text.splitlines()) < 1000
    for name in tagcal._core.__all__:
        assert re.search(rf"^ *{name}[:(]", text, re.MULTILINE), name
    assert "report(" in text


def test_star_import_has_all_names():
    names: dict[str, object] = {}
    exec("from tagcal import *", names)
    assert set(tagcal._core.__all__) | {"report"} <= set(names)


def test_plot_exports_its_functions_only():
    public = {name for name in dir(tagcal.plot) if not name.startswith("_")}
    assert public == set(tagcal.plot.__all__)
