"""Runs of the command in a folder with one of each input; what they cost is measured."""

import os
import signal
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

COMMAND = str(Path(os.environ.get("TAGCAL_COMMAND", "build/release/tools/tagcal")).resolve())
# Without optimisation and under a sanitizer a program takes other memory and time.
IS_MEASURED = not os.environ.get("TAGCAL_SANITIZE")
SANITIZER = 99

SCENE = """camera: {image_size: [640, 400], model: radial1, f: 520, distortion: [-0.1]}
boards:
- target: {target_type: aprilgrid, tagCols: 4, tagRows: 3, tagSize: 0.06, tagSpacing: 0.3}
path: {type: dome, target_m: [0.14, 0.1, 0], min_distance_m: 0.5, min_elevation_deg: 50}
jitter: {target_m: 0.02, roll_deg: 20}
views: 6
sensor: {blur_px: 0.7, noise_levels: 2}
"""


class Run(NamedTuple):
    code: int  # negative: the signal that ended it; SANITIZER: a sanitizer complained
    out: str
    err: str
    cpu_s: float
    peak_mb: float


def start(arguments, folder, out, err, prepare=None, command=None):
    """The process id of the command, with its streams in files. `prepare` runs in the child."""
    process = os.fork()
    if process:
        return process
    try:
        os.chdir(folder)
        for number, stream in ((0, os.open("/dev/null", os.O_RDONLY)), (1, out), (2, err)):
            os.dup2(stream, number)
        if prepare:
            prepare()
        os.execv(command or COMMAND, [command or COMMAND, *arguments])
    finally:
        os._exit(127)


def wait(process, limit_s):
    """Exit code and costs; a process that takes longer than the limit of wall time is killed."""
    end = time.monotonic() + limit_s
    while True:
        done, status, usage = os.wait4(process, os.WNOHANG)
        if done:
            break
        if time.monotonic() > end:
            os.kill(process, signal.SIGKILL)
        time.sleep(0.002)
    return os.waitstatus_to_exitcode(status), usage


def run(arguments, folder, limit_s=60, prepare=None):
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as err:
        process = start([str(a) for a in arguments], folder, out.fileno(), err.fileno(), prepare)
        code, usage = wait(process, limit_s)
        texts = []
        for stream in (out, err):
            stream.seek(0)
            texts.append(stream.read().decode(errors="replace"))
    if "Sanitizer: " in texts[1] or ": runtime error: " in texts[1]:
        code = SANITIZER
    return Run(code, *texts, usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024)


def workshop(folder):
    """Fills a folder: scene.yaml, set, target.yaml, corners.csv, camera.yaml, poses.json, .."""
    folder = Path(folder)
    (folder / "scene.yaml").write_text(SCENE)
    (folder / "points.csv").write_text("x_m,y_m,z_m\n0.02,0.02,0.2\n")
    (folder / "pixels.csv").write_text("u_px,v_px\n100,100\n")
    for arguments in (["render", "scene.yaml", "--out", "set"],
                      ["detect", "set", "--no-cache", "--out", "corners.csv"],
                      ["calibrate", "set", "--observations", "corners.csv", "--model", "radial1",
                       "--out", "camera.yaml"],
                      ["pose", "set", "--observations", "corners.csv", "--camera", "camera.yaml",
                       "--json"]):
        done = run(arguments, folder)
        assert done.code == 0, (arguments, done.err)
        if arguments[0] == "pose":
            (folder / "poses.json").write_text(done.out)
    (folder / "target.yaml").write_bytes((folder / "set/target.yaml").read_bytes())
    (folder / "cams").mkdir()
    (folder / "cams/one.yaml").write_bytes((folder / "camera.yaml").read_bytes())
    (folder / "limits.yaml").write_text("rms_px: 100\n")
    (folder / "photo.png").write_bytes((folder / "set/images/000.png").read_bytes())
    return folder


def is_one_error_line(text):
    """One line of tagcal's own, besides warnings, notes and progress."""
    lines = [line for line in text.splitlines() if line.startswith("tagcal: ")
             and not line.startswith(("tagcal: warning: ", "tagcal: note: "))]
    return len(lines) == 1 and not text.count("terminate called")
