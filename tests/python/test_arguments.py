"""Bad arguments raise an error that says which, and what it must be."""

import numpy as np
import pytest

import fuzz_arguments
import tagcal

TAG = fuzz_arguments.TAG
CAMERA = fuzz_arguments.CAMERA
PIXELS = CAMERA.project(TAG, fuzz_arguments.POSE)
NAN = TAG.copy()
NAN[2, 1] = np.nan


@pytest.mark.parametrize(
    "points, message",
    [
        (None, "points: must be an array, got None"),
        ("abc", "points: must be an array of real numbers, got dtype <U3"),
        (TAG.astype(complex), "points: must be an array of real numbers, got dtype complex128"),
        (TAG.astype(bool), "points: must be an array of real numbers, got dtype bool"),
        ([[0, 1], [2]], "points: must be an array of"),
        (TAG[:, :2], "points: must have the shape (N, 3), got (4, 2)"),
        (TAG[None], "points: must have the shape (N, 3), got (1, 4, 3)"),
        (TAG[:3], "pixels: must have as many rows as points (3), got 4"),
        (NAN, "points: must be finite, got nan in row 2"),
    ],
)
def test_points(points, message):
    with pytest.raises(tagcal.Error) as error:
        tagcal.estimate_pose(points, PIXELS, CAMERA)
    assert str(error.value).startswith(message)


@pytest.mark.parametrize(
    "options, message",
    [
        ({"sigma_px": -1}, "sigma_px: must be >= 0 (0: estimated), got -1"),
        ({"sigma_px": np.nan}, "sigma_px: must be >= 0 (0: estimated), got nan"),
        ({"max_iterations": 0}, "max_iterations: must be > 0, got 0"),
        ({"groups": [1, 2]}, "groups: must have the shape (4,)"),
        ({"groups": [1, 2, 3, 0.5]}, "groups: must be whole numbers, got 0.5"),
        ({"covariances": np.eye(3)}, "covariances: must have the shape (4, 2, 2) or (2, 2)"),
        ({"covariances": -np.eye(2)}, "covariances: must be symmetric and positive definite"),
        ({"covariances": [[1, 0.5], [0.4, 1]]}, "covariances: must be symmetric and positive"),
    ],
)
def test_options(options, message):
    with pytest.raises(tagcal.Error) as error:
        tagcal.estimate_pose(TAG, PIXELS, CAMERA, **options)
    assert str(error.value).startswith(message)


@pytest.mark.parametrize(
    "out, message",
    [
        (np.zeros((4, 3)), "(4, 2), got (4, 3)"),
        (np.zeros((4, 2), dtype=np.float32), "got dtype float32"),
        (np.zeros((2, 4)).T, "got strides"),
        ([0] * 8, "got list"),
    ],
)
def test_out(out, message):
    with pytest.raises(tagcal.Error, match="out: must be a writable, C-contiguous") as error:
        CAMERA.project(TAG, fuzz_arguments.POSE, out=out)
    assert message in str(error.value)


def test_read_only_out():
    out = np.zeros((4, 2))
    out.flags.writeable = False
    with pytest.raises(tagcal.Error, match="got a read-only one"):
        CAMERA.project(TAG, fuzz_arguments.POSE, out=out)


def test_an_error_is_a_value_error():
    assert issubclass(tagcal.Error, ValueError)
    assert tagcal.Error.__module__ == "tagcal"


@pytest.mark.parametrize("change", ["list", "float32", "fortran", "reversed", "unaligned", "strided"])
def test_any_layout_gives_the_same_answer(change):
    points = TAG.astype(np.float32).astype(float)
    expected = CAMERA.project(points, fuzz_arguments.POSE)
    if change == "list":
        points = points.tolist()
    elif change == "float32":
        points = points.astype(np.float32)
    elif change == "fortran":
        points = np.asfortranarray(points)
    elif change == "reversed":
        points = np.ascontiguousarray(points[::-1])[::-1]
    elif change == "unaligned":
        memory = np.zeros(points.nbytes + 1, dtype=np.uint8)[1:]
        memory[:] = np.frombuffer(points.tobytes(), dtype=np.uint8)
        points = memory.view(float).reshape(4, 3)
    else:
        points = np.repeat(points, 2, axis=1)[:, ::2]
    assert np.array_equal(CAMERA.project(points, fuzz_arguments.POSE), expected)


def test_random_arguments_never_crash(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    counts, _ = fuzz_arguments.fuzz(4000, seed=5)
    assert counts["answers"] > 500
    assert counts["Error"] > 200
