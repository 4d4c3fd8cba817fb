"""Calls every function, constructor, method and property with random bad arguments.

    PYTHONPATH=build/release/python python3 tests/python/fuzz_arguments.py [CALLS] [SEED]

Each call has good arguments, by the names and types of its signature, of which one or two are
replaced by bad ones. It may succeed or raise an error that names the argument; it must not crash,
raise an error of the interpreter, or take more than LONGEST_S of CPU time.
"""

import collections
import faulthandler
import inspect
import os
import random
import re
import sys
import tempfile
import time

import numpy as np

import tagcal

LONGEST_S = 50 if "asan" in os.environ.get("LD_PRELOAD", "") else 5
ALLOWED = (ValueError, TypeError, IndexError, OverflowError, OSError)  # tagcal.Error: a ValueError
# pybind11 2.10 ends the program if __setstate__ of a class gets an instance of a derived one.
NOT_CALLED = ("__new__", "__class__", "__setstate__")
Parameter = collections.namedtuple("Parameter", "name type has_default")


def split_arguments(text):
    """The parts of a list at its commas outside of brackets."""
    parts, depth, start = [], 0, 0
    for i, c in enumerate(text):
        depth += (c in "[(<{") - (c in "])>}")
        if c == "," and depth == 0:
            parts.append(text[start:i])
            start = i + 1
    parts.append(text[start:])
    return [part.strip() for part in parts if part.strip()]


def signatures(function):
    """The lists of parameters in the docstring that pybind11 makes, one for each overload."""
    found = []
    for line in (function.__doc__ or "").splitlines():
        match = re.match(r"\s*(?:\d+\. )?\w+\((.*)\) -> ", line)
        if not match:
            continue
        parameters = []
        for part in split_arguments(match[1]):
            name, _, rest = part.partition(":")
            kind, _, default = rest.partition(" = ")
            parameters.append(Parameter(name.strip("* "), kind.strip(), bool(default)))
        found.append(parameters)
    return found


def public_calls():
    """(label, function, parameters, is_method) of all that users can call."""
    calls = []
    for name in tagcal._core.__all__:
        value = getattr(tagcal, name)
        if not inspect.isclass(value):
            calls += [(name, value, parameters, False) for parameters in signatures(value)]
            continue
        for member_name, member in vars(value).items():
            label = f"{name}.{member_name}"
            function = getattr(value, member_name)
            if isinstance(member, property):
                calls.append((label, member.fget, [Parameter("self", f"tagcal.{name}", False)], True))
            elif member_name == "__init__":
                for parameters in signatures(function):
                    calls.append((name, value, parameters[1:], False))
            elif isinstance(member, staticmethod):
                calls += [(label, function, p, False) for p in signatures(function)]
            elif callable(function) and member_name not in NOT_CALLED:
                calls += [(label, function, p, True) for p in signatures(function)]
    return calls


HALF = 0.05
TAG = HALF * np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], dtype=float)
CAMERA = tagcal.Camera.perspective(600, 605, 319.5, 239.5, (640, 480), [-0.1, 0.02])
POSE = tagcal.Pose([0.5, 0.3, 0.1], [0.02, 0.03, 0.6])


def good_arrays():
    """Good values by the names of parameters; several where functions differ."""
    grid = np.array([[x, y, 0.0] for y in range(5) for x in range(6)]) * 0.03
    seen = CAMERA.project(TAG, POSE)
    views = [CAMERA.project(grid, tagcal.Pose([a, 0.3, 0], [-0.1, 0, 0.5])) for a in (-0.5, 0.1, 0.6)]
    return {
        "points": [TAG, TAG[:3], TAG[:, :2], grid],
        "pixels": [seen, seen[:3], views[0], np.stack([seen, seen])],
        "pixels_from_centre": [seen - [319.5, 239.5]],
        "rays": [CAMERA.unproject(seen), CAMERA.unproject(seen[:3]), CAMERA.unproject(views[0])],
        "size": [(640, 480)],
        "image": [np.full((48, 64), 128, dtype=np.uint8), np.zeros((480, 640), dtype=np.uint8)],
        "object_points": [[grid] * 3],
        "image_points": [views],
        "ids": [np.arange(4), np.arange(8).reshape(4, 2) % 3],
        "matrix": [CAMERA.matrix, POSE.matrix],
        "distortion": [[0.1, 0.2]],
        "camera_from_plane": [POSE.matrix[:3, [0, 1, 3]]],
        "eye": [[0.1, 0.2, 0.3]],
        "up": [[0, 0, 1]],
        "rotation": [[1, 0, 0, 0], [0.1, 0.2, 0.3]],
        "translation": [[0.1, 0.2, 0.3]],
        "world_from_board": [POSE.matrix],
        "world_from_cuboid": [POSE.matrix],
        "camera_from_world": [[POSE.matrix] * 3, np.stack([POSE.matrix] * 2)],
        "board_from_tags": [np.stack([POSE.matrix] * 4)],
        "positions": [TAG],
        "corners": [TAG, seen],
        "direction": [[0.1, 0.2, 0.3]],
        "images": [[np.full((48, 64), 128, dtype=np.uint8)] * 2],
        "image_from_squares": [[[20, 0, 30], [1, 20, 30], [0, 0, 1]]],
        "size_m": [[0.1, 0.2, 0.3]],
    }


FILES = ["a.png", "b.yaml", "c.csv", "d.json", "folder", "camera.yaml", "target.yaml", "set"]


def good_records(arrays):
    """Records of which other functions make more, and files of them in the working folder."""
    dataset = tagcal.Dataset.from_points(
        arrays["object_points"][0], arrays["image_points"][0], (640, 480), images=["a", "b", "c"]
    )
    calibration = tagcal.calibrate(dataset, model="f", sigma_px=0.1)
    board = tagcal.Board.grid(2, 2, 0.03, 0.3)
    scene = tagcal.Scene(CAMERA, board, [POSE.matrix, POSE.matrix])
    picture = tagcal.render(scene)
    tagcal.write_picture("a.png", picture)
    tagcal.write_camera("camera.yaml", calibration)
    tagcal.write_target("target.yaml", board)
    tagcal.write_dataset("set", dataset)
    arrays["image"] = [*arrays["image"], picture]
    return {
        "Board": [board],
        "Calibration": [calibration],
        "Camera": [CAMERA],
        "Dataset": [dataset],
        "Pose": [POSE],
        "Scene": [scene],
        "View": [dataset.views[0], tagcal.detect(picture, board)],
    }


def good_value(parameter, arrays, pool, draw):
    name, kind = parameter.name, parameter.type
    if name in arrays and draw.random() < 0.9:
        return draw.choice(arrays[name])
    if kind == "ArrayLike":
        return draw.choice(draw.choice(list(arrays.values())) + [[0.1, 0.2, 0.3]])
    for type_name in re.findall(r"tagcal\.(\w+)", kind):
        if pool.get(type_name):
            return draw.choice(pool[type_name])
    if kind == "ImageLike":
        return draw.choice(arrays["image"])
    if kind == "CameraLike":
        return draw.choice([*pool["Camera"], *pool["Calibration"]])
    if kind == "TargetLike":
        return draw.choice(pool.get("Board") or [None])
    if "PathLike" in kind:
        return draw.choice(FILES)
    if kind == "str":
        return draw.choice(["tag36h11", "DICT_4X4_50", "auto", "opencv5", "a"])
    if kind in ("float", "int", "bool"):
        return draw.choice([1, 2, 4]) if kind != "float" else draw.choice([0.1, 1.0, 3.0])
    return None


def bad_value(pool, arrays, draw):
    special = [
        None, True, 0, -1, 1, 2**31 - 1, 2**31, -(2**63), 2**64, 1e308, -1e-308, 0.0, float("nan"),
        float("inf"), -float("inf"), "", "x", "tag36h11", "\0", "a" * 5000, b"\xff", object(), [],
        (), {}, [None], [[1, 2], [3]], ["a", "b"], {"fx": float("nan")}, {"a": "b"}, 1j, len, tagcal,
        tagcal.Camera, range(3), set(), "/dev/full", "/proc/self/mem", ".", "..",
    ]
    kind = draw.randrange(4)
    if kind == 0:
        return draw.choice(special)
    if kind == 1:
        records = [record for records in pool.values() for record in records]
        return draw.choice(records) if records else None
    shape = tuple(draw.choice([0, 1, 2, 3, 4, 5, 6, 9]) for _ in range(draw.randrange(5)))
    dtype = draw.choice(["f8", "f4", "i8", "u1", "u2", "i4", "?", "c16", "O", "U3", ">f8", "f2", "M8[s]"])
    if kind == 2:
        array = np.zeros(shape, dtype=dtype)
        if dtype in ("f8", "f4", ">f8"):
            array += np.random.default_rng(draw.getrandbits(32)).normal(0, 10.0 ** draw.randrange(-9, 9), shape)
    else:
        array = draw.choice(draw.choice(list(arrays.values())))
        if not isinstance(array, np.ndarray):
            array = np.array(array, dtype=float) if draw.random() < 0.5 else TAG
        array = array.copy()
        if array.dtype.kind == "f" and array.size:
            array.flat[draw.randrange(array.size)] = draw.choice([np.nan, np.inf, 1e300, -1e300, 0, 1e-300])
    change = draw.randrange(8)
    if change == 0 and array.ndim:
        array = array[::-1]
    elif change == 1 and array.ndim > 1:
        array = array[..., ::2]
    elif change == 2:
        array = np.asfortranarray(array)
    elif change == 3:
        array.flags.writeable = False
    elif change == 4:
        array = np.broadcast_to(array, (3, *array.shape))
    elif change == 5 and array.dtype.kind != "O":  # not aligned
        memory = np.zeros(array.nbytes + 1, dtype="u1")[1:]
        memory[:] = np.frombuffer(array.tobytes(), dtype="u1")
        array = memory.view(array.dtype).reshape(array.shape) if array.nbytes else array
    return array


def remember(pool, value):
    """Keeps records as arguments of later calls."""
    values = value if isinstance(value, (list, tuple)) else [value]
    for item in values[:3]:
        name = type(item).__name__
        if name in tagcal._core.__all__:
            known = pool.setdefault(name, [])
            if len(known) < 12:
                known.append(item)


def one_call(call, pool, arrays, draw):
    label, function, parameters, _ = call
    arguments = {}
    for parameter in parameters:
        if parameter.has_default and draw.random() < 0.7:
            continue
        arguments[parameter.name] = good_value(parameter, arrays, pool, draw)
    for _ in range(draw.choice([0, 1, 1, 2])):
        if parameters:
            parameter = draw.choice(parameters)  # most classes are refused by their types alone
            if "tagcal." not in parameter.type or draw.random() < 0.1:
                arguments[parameter.name] = bad_value(pool, arrays, draw)
    positional = []
    if "self" in arguments:
        positional.append(arguments.pop("self"))
    for name in ("arg0", "arg1"):
        if name in arguments:
            positional.append(arguments.pop(name))
    return label, function, positional, arguments


def fuzz(num_calls, seed, log=None):
    """Returns counts of outcomes; raises AssertionError with the call for a wrong one."""
    draw = random.Random(seed)
    arrays = good_arrays()
    pool = good_records(arrays)
    calls = public_calls()
    working = [call for call in calls if call[2] != [] and not call[3]]  # the rest: methods, getters
    counts = collections.Counter()
    for _ in range(num_calls):
        label, function, positional, arguments = one_call(
            draw.choice(working if draw.random() < 0.7 else calls), pool, arrays, draw
        )
        if log:
            log.seek(0)
            log.truncate()
            log.write(f"{label} {positional!r:.2000} {arguments!r:.4000}\n")
            log.flush()
        start = time.process_time()
        try:
            result = function(*positional, **arguments)
            repr(result)
            remember(pool, result)
            counts["answers"] += 1
            counts[f"answer of {label}"] += 1
        except ALLOWED as error:
            counts[type(error).__name__] += 1
            message = str(error)
            if isinstance(error, tagcal.Error) and ("\n" in message or not message):
                raise AssertionError(f"{label} {positional} {arguments}: {message!r}") from error
        except Exception as error:
            raise AssertionError(f"{label} {positional} {arguments}: {error!r}") from error
        took = time.process_time() - start
        assert took < LONGEST_S, f"{label} {positional} {arguments}: {took:.1f} s"
    return counts, sorted({label for label, *_ in calls} - {
        key.removeprefix("answer of ") for key in counts if key.startswith("answer of ")
    })


def main():
    num_calls = int(sys.argv[1]) if len(sys.argv) > 1 else 100_000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    log_name = os.path.abspath("fuzz_arguments.log")  # the last call, if it crashes
    faulthandler.enable()
    with tempfile.TemporaryDirectory() as folder, open(log_name, "w") as log:
        os.chdir(folder)
        counts, unanswered = fuzz(num_calls, seed, log)
        os.chdir("/")
    os.remove(log_name)
    print(", ".join(f"{n} {k}" for k, n in counts.most_common() if not k.startswith("answer of")))
    print("never with an answer:", ", ".join(unanswered) or "none")


if __name__ == "__main__":
    main()
