"""Equal bytes for any number of threads: every command with --threads, on tags, a checkerboard and
a ChArUco board. All files, standard output and standard error are compared; times are left out.

threads_test.py
"""

import os
import re
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import answers

COMMAND = str(Path(os.environ.get("TAGCAL_COMMAND", "build/release/tools/tagcal")).resolve())
THREADS = (1, 2, 3, 7)

VIEWS = """boards: [{{target: {target}, world_from_board: {{translation_m: [{at}, 0]}}}}]
path: {{type: dome, min_distance_m: 0.45, max_distance_m: 0.6, min_elevation_deg: 45}}
jitter: {{target_m: 0.02, roll_deg: 30}}
views: 4
sensor: {{blur_px: 0.7, noise_levels: 2}}
"""
CAMERA = "camera: {image_size: [640, 400], model: radial1, f: 520, cx: 317, cy: 203, distortion: [-0.1]}\n"
TARGETS = {
    "tags": ("{target_type: aprilgrid, tagCols: 4, tagRows: 3, tagSize: 0.06, tagSpacing: 0.3}", "-0.15, -0.11"),
    "squares": ("{target_type: checkerboard, targetCols: 8, targetRows: 5, rowSpacingMeters: 0.035,"
                " colSpacingMeters: 0.035}", "-0.12, -0.07"),
    "charuco": ("{target_type: charuco, squareCols: 7, squareRows: 5, squareSize: 0.05, markerSize: 0.037,"
                " dictionary: DICT_5X5_100}", "-0.175, -0.125"),
}

# Everything is read from the render of the same number of threads, so paths differ in nothing.
COMMANDS = [f"render {name}.yaml --out {name} --seed 3" for name in TARGETS] + [
    command.format(name) for name in TARGETS for command in (
        "detect {0} --no-cache --out {0}.csv --verbose",
        "detect {0} --no-cache --out {0}.twice.csv --draw {0}.drawn --explain",
        "calibrate {0} --observations {0}.csv --out {0}.camera.yaml --advise --verbose --uncertainty {0}.svg",
        "calibrate {0} --observations {0}.csv --model radial1 --json",
        "calibrate {0} --observations {0}.csv --model opencv4 --board-warp --json",
        "pose {0} --observations {0}.csv --camera {0}.camera.yaml --json --draw {0}.axes",
        "pose {0} --observations {0}.csv --unknown-focal --verbose",
        "report {0}.camera.yaml --dataset {0} --observations {0}.csv --out {0}.html",
        "detect {0} --no-cache --camera {0}.camera.yaml --out {0}.straight.csv")] + [
    "calibrate tags --no-cache --refine-corners --model auto --select 3 --json",
    "calibrate tags squares charuco --model auto --no-cache --out fleet --json",
    "calibrate tags squares charuco --model radial1 --no-cache",
    "detect tags/images --family tag36h11 --no-cache --out family.csv --verbose",
    "watch tags/images --target tags/target.yaml --no-cache --timeout 0.05 --every 0.01 --out watched.yaml",
    "report tags.poses.json --dataset tags --camera tags.camera.yaml --out poses.html",
    "reproject tags/images/000.png tags/images/001.png tags/images/002.png --camera tags.camera.yaml --undistort all"
    " --interpolation lanczos4 --out straight --maps --mask",
    "reproject tags/images/000.png --camera tags.camera.yaml --panorama equirectangular --tiles 200x150 --out tiles",
]
WITH_THREADS = ("render", "detect", "calibrate", "pose", "report", "reproject", "watch")
# Progress, which is printed after a second; times, the last column of a table of data sets, and what
# a page says of how it was made.
LEFT_OUT = re.compile(r'^.*: (?:\d+ of \d+(?:, [\d.]+/s.*)?|\d+ s)\n|"seconds": \{[^}]*\}|^ *time .*$|\b[0-9.]+ (?:m?s|seconds)\b'
                      r'|(?<=\d) +\d+\.\d\d$|--threads \d|"date":"[-0-9]*"', re.M)


def run(arguments, folder, environment):
    return subprocess.run([COMMAND, *arguments.split()], cwd=folder, capture_output=True, text=True,
                          stdin=subprocess.DEVNULL, env={**os.environ, **environment})


def outcome(folder, threads, environment={}):
    """Name -> bytes of all that the commands leave, print and complain about."""
    folder.mkdir()
    for name, (target, at) in TARGETS.items():
        (folder / f"{name}.yaml").write_text(CAMERA + VIEWS.format(target=target, at=at))
    found = {}
    for command in COMMANDS:
        has_threads = command.split()[0] in WITH_THREADS
        done = run(command + f" --threads {threads}" * has_threads, folder, environment)
        if done.returncode not in (0, 3):
            raise SystemExit(f"tagcal {command}: exit code {done.returncode}\n{done.stderr}")
        if command.startswith("pose tags") and "--json" in command:
            (folder / "tags.poses.json").write_text(done.stdout)
        found[f"{command}: exit code"] = done.returncode
        for stream in ("stdout", "stderr"):
            found[f"{command}: {stream}"] = LEFT_OUT.sub("", getattr(done, stream))
    for name, content in answers.folder_bytes(folder).items():
        found[name] = LEFT_OUT.sub("", content.decode()) if name.endswith(".html") else content
    return found


def main():
    with tempfile.TemporaryDirectory() as temporary, ThreadPoolExecutor(2) as pool:
        found = dict(zip(THREADS, pool.map(lambda n: outcome(Path(temporary) / str(n), n), THREADS)))
    one = found[THREADS[0]]
    refused = sum(1 for name, content in one.items() if name.endswith("exit code") and content)
    mistakes = [f"{refused} commands without an answer"] if refused > 3 else []
    for threads, other in found.items():
        for name in sorted(one.keys() | other.keys()):
            if one.get(name) != other.get(name):
                mistakes.append(f"{name}: with {threads} threads not as with {THREADS[0]}")
    print(f"{len(COMMANDS)} commands, {len(one)} outputs, {', '.join(map(str, THREADS))} threads")
    print("\n".join(mistakes))
    return 1 if mistakes else 0


if __name__ == "__main__":
    sys.exit(main())
