"""A fixed list of commands, and how far the answers of two programs are apart.

Units: a corner, a camera's parameter and a pose are compared in their own standard deviations, any
other number relative to itself (in a list: to the largest of the list). Words must be equal.
"""

import csv
import json
import math
import os
import re
import subprocess
from pathlib import Path
from typing import NamedTuple

SOURCE = Path(__file__).resolve().parents[2]
GOLDEN = SOURCE / "data-synthetic/golden/desk"
SCENES = {"desk": 6, "checkerboard": 6, "charuco": 6, "fisheye_room": 6, "tabletop": 3}  # views
# Models by name on the golden data set; its truth is opencv4. opencv8 is not among them: the minimum
# of a rational lens that such data do not determine is a valley (docs/reference/models.md).
MODELS = ("weak", "f", "f+c", "pinhole", "radial1", "radial2", "opencv4", "opencv5", "fisheye4", "ds", "eucm")

# What two programs may differ by: kernels with and without AVX2, libraries with and without AVX2
# and AVX-512, other compilers and other optimisation. They round differently in the last bits, and
# iterations that stop at a tolerance make this larger: the fit of a tag or a corner stops if the
# next step is expected to be below sqrt(kTagConvergedSize) = 0.32 sd (detect/policy/policy.hpp), so
# in rare corners one program makes a step more. Measured by processors_test.py and
# tools/compare_builds.sh, and rounded up.
TOLERANCES = {
    "corner, sd": 0.5,             # the worst corner of all
    "corners, RMS sd": 0.05,       # of one command
    "covariance, relative": 0.3,   # of the worst corner
    "camera, sd": 1e-4,            # of a calibration from the same corners
    "pose, sd": 1e-4,              # of one view from the same corners
    # Standard deviations, residuals. They include the larger models that the data support as well.
    "other, relative": 0.01,
    "extrapolated, relative": 0.1,  # standard deviations of the projection where no corner was seen
    "pixels, px": 1e-6,            # of project and unproject
}
EXTRAPOLATED = ("whole_image_max_px", "nodes_without_ray")
ROUNDING = 1e-9  # no number of an answer matters below this, in metres, radians or pixels


class Program(NamedTuple):
    """The command, and what its environment has besides."""
    name: str
    command: str
    environment: dict = {}

    def run(self, *arguments, codes=(0,)):
        """Standard output."""
        done = subprocess.run([self.command, *map(str, arguments)], capture_output=True, text=True,
                              stdin=subprocess.DEVNULL, env={**os.environ, **self.environment})
        if done.returncode not in codes:
            raise SystemExit(f"{self.name}: tagcal {' '.join(map(str, arguments))}: "
                             f"exit code {done.returncode}\n{done.stderr}")
        return done.stdout


def make_inputs(program, folder):
    """Data sets, corners and cameras that all programs read."""
    for name, views in SCENES.items():
        scene = SOURCE / f"data-synthetic/scenes/{name}.yaml"
        program.run("render", scene, "--views", views, "--out", folder / name)
        program.run("detect", folder / name, "--no-cache", "--out", folder / f"{name}.csv")
        program.run("calibrate", folder / name, "--observations", folder / f"{name}.csv",
                    "--out", folder / f"{name}.yaml")
    rows = ["x_m,y_m,z_m"] + [f"{x / 50},{y / 50},1" for x in range(-20, 21) for y in range(-12, 13)]
    (folder / "points.csv").write_text("\n".join(rows) + "\n")
    rows = ["u_px,v_px"] + [f"{u},{v}" for u in range(0, 1280, 40) for v in range(0, 800, 40)]
    (folder / "pixels.csv").write_text("\n".join(rows) + "\n")


def answers(program, inputs, out):
    """Name -> text of each command's answer."""
    found = {}
    for name, views in SCENES.items():
        data, corners, camera = inputs / name, inputs / f"{name}.csv", inputs / f"{name}.yaml"
        program.run("render", SOURCE / f"data-synthetic/scenes/{name}.yaml", "--views", views,
                    "--out", out / name)
        found[f"render {name}"] = folder_bytes(out / name)
        found[f"detect {name}"] = program.run("detect", data, "--no-cache")
        found[f"calibrate {name}"] = program.run("calibrate", data, "--observations", corners, "--json")
        found[f"pose {name}"] = program.run("pose", data, "--observations", corners, "--camera", camera,
                                            "--json")
        found[f"validate {name}"] = program.run("validate", camera, "--dataset", data, "--observations",
                                                corners, "--json")
        if name != "fisheye_room":
            found[f"project {name}"] = program.run("project", inputs / "points.csv", "--camera", camera)
            found[f"unproject {name}"] = program.run("unproject", inputs / "pixels.csv", "--camera", camera)
    for model in MODELS:
        found[f"calibrate golden as {model}"] = program.run("calibrate", GOLDEN, "--model", model, "--json",
                                                            codes=(0, 3))
    found["calibrate golden"] = program.run("calibrate", GOLDEN, "--json")
    found["pose tabletop, focal length too"] = program.run(
        "pose", inputs / "tabletop", "--observations", inputs / "tabletop.csv", "--unknown-focal", "--json")
    found["detect --family"] = program.run("detect", inputs / "desk/images", "--family", "tag36h11",
                                           "--no-cache")
    found["diff"] = program.run("diff", inputs / "desk.yaml", inputs / "checkerboard.yaml", "--json")
    return found


def folder_bytes(folder):
    return {str(file.relative_to(folder)): file.read_bytes()
            for file in sorted(folder.rglob("*")) if file.is_file()}


class Difference:
    """The largest difference in each unit, and where it is; and what differs in kind."""

    def __init__(self):
        self.largest = {unit: (0.0, "") for unit in TOLERANCES}
        self.mistakes = []

    def add(self, unit, value, where):
        if not value <= self.largest[unit][0]:  # NaN too
            self.largest[unit] = (value, where)

    def refuse(self, where, a, b):
        self.mistakes.append(f"{where}: {str(a)[:100]} | {str(b)[:100]}")

    def beyond(self):
        """What is beyond the tolerances, one line each."""
        return self.mistakes + [
            f"{where}: {value:.2g} {unit}, more than {TOLERANCES[unit]:g}"
            for unit, (value, where) in self.largest.items() if not value <= TOLERANCES[unit]]


def compare(of_a, of_b):
    difference = Difference()
    for name, a in of_a.items():
        b = of_b[name]
        if name.startswith("render"):
            compare_renders(name, a, b, difference)
        elif name.startswith("detect"):
            compare_corners(name, a, b, difference)
        elif name.startswith(("project", "unproject")):
            compare_pixels(name, a, b, difference)
        else:
            compare_json(name, json.loads(a), json.loads(b), difference)
    return difference


def compare_renders(name, a, b, difference):
    """Pictures have equal bytes; the numbers of the other files are compared."""
    if a.keys() != b.keys():
        return difference.refuse(name, sorted(a), sorted(b))
    for file, content in a.items():
        if content == b[file]:
            continue
        if file.startswith("images"):
            difference.refuse(f"{name}: {file}", "other bytes", "")
        else:
            compare_text(f"{name}: {file}", content.decode(), b[file].decode(), difference)


NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?", re.I)


def compare_text(where, a, b, difference):
    if NUMBER.sub("#", a) != NUMBER.sub("#", b):
        return difference.refuse(where, "other words", "")
    for x, y in zip(NUMBER.findall(a), NUMBER.findall(b)):
        add_relative(where, float(x), float(y), 0.0, difference)


def rows_of(text):
    return list(csv.DictReader(text.splitlines()))


def compare_corners(name, a, b, difference):
    keys = ("image", "tag_id", "corner")
    rows_a, rows_b = rows_of(a), rows_of(b)
    if [[row.get(k) for k in keys] for row in rows_a] != [[row.get(k) for k in keys] for row in rows_b]:
        return difference.refuse(name, f"{len(rows_a)} corners", f"{len(rows_b)}, or others")
    squares = []
    for x, y in zip(rows_a, rows_b):
        where = f"{name}: {' '.join(x.get(k) or '-' for k in keys)}"
        if "sxx_px2" not in x:  # tags without a target: x0_px .. without covariances
            for key in x:
                compare_field(f"{where}: {key}", x[key], y[key], difference)
            continue
        scale = max(float(x["sxx_px2"]), float(x["syy_px2"]))
        for axis, variance in (("x_px", "sxx_px2"), ("y_px", "syy_px2")):
            off = abs(float(x[axis]) - float(y[axis])) / math.sqrt(float(x[variance]))
            squares.append(off * off)
            difference.add("corner, sd", off, where)
        for key in ("sxx_px2", "sxy_px2", "syy_px2"):
            difference.add("covariance, relative", abs(float(x[key]) - float(y[key])) / scale, where)
    if squares:
        difference.add("corners, RMS sd", math.sqrt(sum(squares) / len(squares)), name)


def compare_field(where, x, y, difference):
    try:
        numbers = float(x), float(y)
    except ValueError:
        if x != y:
            difference.refuse(where, x, y)
        return
    add_relative(where, *numbers, 0.0, difference)


def compare_pixels(name, a, b, difference):
    rows_a, rows_b = rows_of(a), rows_of(b)
    if len(rows_a) != len(rows_b):
        return difference.refuse(name, len(rows_a), len(rows_b))
    for number, (x, y) in enumerate(zip(rows_a, rows_b)):
        for key in x:
            where = f"{name}: row {number}: {key}"
            if x[key] and y[key] and key in ("u_px", "v_px", "dx", "dy", "dz"):
                difference.add("pixels, px", abs(float(x[key]) - float(y[key])), where)
            elif not x[key] or not y[key]:
                compare_field(where, x[key], y[key], difference)


def compare_json(where, a, b, difference):
    if isinstance(a, dict) and isinstance(b, dict):
        if a.keys() != b.keys():
            difference.refuse(where, sorted(a), sorted(b))
            return
        compare_known(where, a, b, difference)
        for key in a:
            if key not in KNOWN:
                compare_json(f"{where}: {key}", a[key], b[key], difference)
    elif isinstance(a, list) and isinstance(b, list) and len(a) == len(b):
        numbers = [abs(x) for x in flat(a) if is_number(x)]
        for number, (x, y) in enumerate(zip(a, b)):
            if is_number(x) and is_number(y):
                add_relative(f"{where}: {number}", x, y, max(numbers), difference)
            elif isinstance(x, list) and numbers:
                compare_rows(where, x, y, max(numbers), difference)
            else:
                compare_json(f"{where}: {number}", x, y, difference)
    elif is_number(a) and is_number(b):
        add_relative(where, a, b, 0.0, difference)
    elif isinstance(a, str) and isinstance(b, str):
        if NUMBER.sub("#", a) != NUMBER.sub("#", b):
            difference.refuse(where, a, b)
    elif a != b:
        difference.refuse(where, a, b)


# Compared in standard deviations, or not at all: times; the scores of models that fit badly.
KNOWN = ("camera", "camera_from_board", "camera_in_target", "seconds", "steps")


def compare_known(where, a, b, difference):
    if is_tree(a.get("camera")) and is_tree(a.get("sigma")):
        for x, y, sigma in zip(flat(a["camera"]), flat(b["camera"]), flat(a["sigma"])):
            if is_number(sigma) and sigma > 0:
                difference.add("camera, sd", abs(x - y) / sigma, f"{where}: camera")
            else:
                compare_json(f"{where}: camera", x, y, difference)
    if is_tree(a.get("camera_from_board")) and is_tree(a.get("covariance")):
        variances = [a["covariance"][i][i] for i in range(6)]
        for key, unit, least in (("rotation", 2.0, min(variances[:3])), ("translation_m", 1.0, min(variances[3:]))):
            for x, y in zip(a["camera_from_board"][key], b["camera_from_board"][key]):
                difference.add("pose, sd", unit * abs(x - y) / math.sqrt(least), f"{where}: {key}")
    if "steps" in a and [s["model"] for s in a["steps"] if s["taken"]] != \
            [s["model"] for s in b["steps"] if s["taken"]]:
        difference.refuse(f"{where}: steps", a["steps"], b["steps"])


def compare_rows(where, a, b, scale, difference):
    for x, y in zip(flat(a), flat(b)):
        if is_number(x) and is_number(y):
            add_relative(where, x, y, scale, difference)
        elif x != y:
            difference.refuse(where, x, y)


def is_tree(value):
    return isinstance(value, (dict, list))


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def flat(tree):
    if isinstance(tree, dict):
        return [leaf for value in tree.values() for leaf in flat(value)]
    if isinstance(tree, list):
        return [leaf for value in tree for leaf in flat(value)]
    return [tree]


def add_relative(where, a, b, scale, difference):
    """`scale`: the largest number of the same list."""
    if abs(a - b) <= ROUNDING * min(1.0, max(abs(a), abs(b), scale)) or max(abs(a), abs(b)) < ROUNDING:
        return
    unit = "extrapolated, relative" if where.endswith(EXTRAPOLATED) else "other, relative"
    if "sigma_mm" in where:  # of the board's shape, by the spread between views that is estimated
        unit = "covariance, relative"
    difference.add(unit, abs(a - b) / max(abs(a), abs(b), scale), where)


def table_head(first):
    return f"| {first} | " + " | ".join(TOLERANCES) + " |\n" + "|---" * (1 + len(TOLERANCES)) + "|"


def table_row(first, difference):
    return f"| {first} | " + " | ".join(f"{value:.1g}" for value, _ in difference.largest.values()) + " |"
