"""Corner sets of many cameras, what their calibrations leave on the disk, and processes to kill.

The engines' tests print one line a step. FLEET_SETS is the number of sets (2000).
"""

import json
import os
import random
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
COMMAND = str(Path(os.environ.get("TAGCAL_COMMAND", ROOT / "build/release/tools/tagcal")).resolve())
SETS = int(os.environ.get("FLEET_SETS", "2000"))
SKIPPED = 77
SCENE = """camera: {image_size: [640, 400], model: f, f: 520}
boards:
- target: {target_type: aprilgrid, tagCols: 4, tagRows: 3, tagSize: 0.06, tagSpacing: 0.3}
path: {type: dome, target_m: [0.14, 0.1, 0], min_distance_m: 0.5, min_elevation_deg: 50}
jitter: {target_m: 0.02, roll_deg: 20}
views: 5
"""


def skip(reason):
    print("skipped:", reason)
    sys.exit(SKIPPED)


def tagcal(place, *arguments, code=0):
    done = subprocess.run([COMMAND, *map(str, arguments)], cwd=place, capture_output=True, text=True)
    assert code is None or done.returncode == code, (arguments, done.returncode, done.stderr[-500:])
    return done


def make_sets(place, count=SETS, seed=1):
    """cameras/c0000, ..: rendered corners with the focal length and the noise of each camera."""
    (place / "scene.yaml").write_text(SCENE)
    tagcal(place, "render", "scene.yaml", "--out", "rendered")
    header, *lines = (place / "rendered/observations_exact.csv").read_text().splitlines()
    rows = [line.rsplit(",", 2) for line in lines]
    corners = [(head, float(x) - 319.5, float(y) - 199.5) for head, x, y in rows]
    chance = random.Random(seed)
    for i in range(count):
        scale = 1 + 0.004 * chance.gauss(0, 1)
        folder = place / f"cameras/c{i:04}"
        folder.mkdir(parents=True)
        (folder / "dataset.yaml").write_text(
            "image_size: [640, 400]\ntarget: ../../rendered/target.yaml\nobservations: corners.csv\n")
        noise = [chance.gauss(0, 0.2) for _ in range(64)]
        start = chance.randrange(64)
        (folder / "corners.csv").write_text("\n".join(
            [header] + [f"{head},{319.5 + scale * x + noise[(start + 7 * k) % 61]:.4f},"
                        f"{199.5 + scale * y + noise[(start + 11 * k) % 59]:.4f}"
                        for k, (head, x, y) in enumerate(corners)]) + "\n")


def options(out):
    return ["--model", "f", "--threads", "1", "--out", out, "--resume"]


def calibrate_serially(place, out="serial"):
    """Returns the seconds that it took."""
    begin = time.monotonic()
    done = tagcal(place, "calibrate", *sorted(str(p) for p in (place / "cameras").glob("*")),
                  *options(out), code=None)
    assert done.returncode in (0, 3), done.stderr[-500:]
    return time.monotonic() - begin


def contents(folder):
    """All files but what a killed process left: the README of limits says that they are no harm."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*")
            if path.is_file() and not path.name.startswith(".tagcal-")}


def check_equal(place, out, serial="serial"):
    ours, theirs = contents(place / out), contents(place / serial)
    missing, extra = theirs.keys() - ours.keys(), ours.keys() - theirs.keys()
    assert not missing and not extra, (sorted(missing)[:5], sorted(extra)[:5])
    other = [name for name in theirs if ours[name] != theirs[name]]
    assert not other, f"{len(other)} files differ: {other[:5]}"
    print(f"{out}: {len(ours)} files equal those of the serial run")


def num_done(place, out):
    folder = place / out / "summary"
    return len(list(folder.glob("*.json"))) if folder.is_dir() else 0


def times(place, out):
    return {path.name: path.stat().st_mtime_ns for path in (place / out / "summary").glob("*.json")}


def check_nothing_twice(before, after):
    """A run that comes later does not calibrate what is done."""
    again = [name for name, at in before.items() if after[name] != at]
    assert not again, f"{len(again)} sets calibrated twice: {again[:5]}"


def wait_for(what, condition, limit_s=120.0):
    end = time.monotonic() + limit_s
    while not condition():
        assert time.monotonic() < end, f"{what}: not within {limit_s:.0f} s"
        time.sleep(0.05)


def processes_of(place, word):
    """Processes with this word in their command line that were started for this folder."""
    found = []
    for entry in Path("/proc").glob("[0-9]*"):
        try:
            line = (entry / "cmdline").read_bytes().replace(b"\0", b" ").decode(errors="replace")
            environment = (entry / "environ").read_bytes()
            here = os.readlink(entry / "cwd")
        except OSError:
            continue
        ours = str(place) in line or str(place).encode() in environment or here.startswith(str(place))
        if ours and word in line:
            found.append(int(entry.name))
    return found


def kill_one(place, word):
    """kill -9; returns whether there was one."""
    for process in processes_of(place, word):
        try:
            os.kill(process, signal.SIGKILL)
            print(f"killed a process of {word}")
            return True
        except ProcessLookupError:
            continue
    return False


def file_of_page(name):
    """The file that docs/tasks/fleets.md shows under this name."""
    page = (ROOT / "docs/tasks/fleets.md").read_text()
    found = re.search(rf"<!-- file: {re.escape(name)} -->\n```\w*\n(.*?)^```$", page, re.M | re.S)
    assert found, f"fleets.md has no file {name}"
    return found.group(1)


def check_fleet(place, out):
    """The table has each set once."""
    done = tagcal(place, "fleet", out, "--json", code=None)
    assert done.returncode in (0, 1), done.stderr
    names = [unit["name"] for unit in json.loads(done.stdout)["units"]]
    assert names == sorted(p.name for p in (place / "cameras").iterdir()), len(names)
