"""Every file option of every command with folders, devices, pipes, sockets, broken links, and files
that are empty, binary or not to be read: one line and a documented exit code within 2 s, and nothing
is left behind.

special_test.py          every second pair of option and kind (in the suite)
special_test.py --all    every pair
"""

import os
import re
import socket
import struct
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import trial

MOST_S = 2.0  # of CPU; nothing waits for more than half a second, but the machine may be busy
LIMIT_S = 20.0

# command, option ("" for an argument) -> the line, with {file} in the place of the file.
INPUTS = {
    ("render", ""): "render {file} --out {out}",
    ("detect", ""): "detect {file}",
    ("detect", "pictures"): "detect --target target.yaml {file}",
    ("detect", "strict"): "detect --target target.yaml --strict {file} photo.png",
    ("detect", "list"): "detect --target target.yaml @{file}",
    ("detect", "--target"): "detect --target {file} photo.png",
    ("detect", "--camera"): "detect set --camera {file}",
    ("calibrate", ""): "calibrate {file}",
    ("calibrate", "several"): "calibrate {file} set --out {out} --model f",
    ("calibrate", "--target"): "calibrate --target {file} photo.png",
    ("calibrate", "--observations"): "calibrate set --observations {file}",
    ("calibrate", "--start"): "calibrate set --start {file}",
    ("watch", ""): "watch {file} --target target.yaml --timeout 0.1",
    ("watch", "--target"): "watch new --target {file} --timeout 0.1",
    ("validate", ""): "validate {file} --dataset set",
    ("validate", "--dataset"): "validate camera.yaml --dataset {file}",
    ("validate", "--observations"): "validate camera.yaml --dataset set --observations {file}",
    ("report", ""): "report {file} --out {out}.html",
    ("report", "other"): "report camera.yaml {file} --out {out}.html",
    ("report", "--dataset"): "report camera.yaml --dataset {file} --out {out}.html",
    ("report", "--observations"): "report camera.yaml --dataset set --observations {file} --out "
                                  "{out}.html",
    ("report", "--target"): "report camera.yaml --target {file} photo.png --out {out}.html",
    ("report", "--camera"): "report poses.json --dataset set --camera {file} --out {out}.html",
    ("pose", ""): "pose {file} --camera camera.yaml",
    ("pose", "--target"): "pose --target {file} photo.png --camera camera.yaml",
    ("pose", "--observations"): "pose set --camera camera.yaml --observations {file}",
    ("pose", "--camera"): "pose set --camera {file}",
    ("handeye", ""): "handeye {file} --camera arm/truth.yaml --robot arm/robot.csv --mount hand",
    ("handeye", "--target"): "handeye --target {file} photo.png --camera arm/truth.yaml --robot arm/robot.csv "
                             "--mount hand",
    ("handeye", "--observations"): "handeye arm --camera arm/truth.yaml --robot arm/robot.csv --mount hand "
                                   "--observations {file}",
    ("handeye", "--camera"): "handeye arm --camera {file} --robot arm/robot.csv --mount hand",
    ("handeye", "--robot"): "handeye arm --camera arm/truth.yaml --robot {file} --mount hand",
    ("handeye", "--times"): "handeye arm --camera arm/truth.yaml --robot path.txt --mount hand --times {file}",
    ("board", ""): "board {file} --out {out}.svg",
    ("view", ""): "view {file}",
    ("view", "--camera"): "view set --camera {file}",
    ("diff", ""): "diff {file} camera.yaml",
    ("diff", "other"): "diff camera.yaml {file}",
    ("fleet", ""): "fleet {file}",
    ("fleet", "--units"): "fleet cams --units {file}",
    ("fleet", "--limits"): "fleet cams --limits {file}",
    ("check", ""): "check {file} --camera camera.yaml",
    ("check", "--target"): "check --target {file} photo.png --camera camera.yaml",
    ("check", "--observations"): "check set --camera camera.yaml --observations {file}",
    ("check", "--camera"): "check set --camera {file}",
    ("convert", ""): "convert {file} {out}.yaml --to opencv",
    ("convert", "--poses"): "convert camera.yaml {out}.json --to nerfstudio --poses {file}",
    ("convert", "--target"): "convert corners.csv {out}.vnl --target {file}",
    ("reproject", ""): "reproject {file} --camera camera.yaml --undistort all --out {out}",
    ("reproject", "--camera"): "reproject photo.png --camera {file} --undistort all --out {out}",
    ("reproject", "--to-camera"): "reproject photo.png --camera camera.yaml --to-camera {file} "
                                  "--out {out}",
    ("reproject", "--target"): "reproject photo.png --camera camera.yaml --plane --target {file} "
                               "--m-per-px 0.001 --out {out}",
    ("reproject", "rig"): "reproject photo.png other.png --camera {file} --cameras cam0,cam1 --rectify {out}",
    ("triangulate", ""): "triangulate {file} --camera chain.yaml --out {out}.csv",
    ("triangulate", "--camera"): "triangulate pixels_of_rig.csv --camera {file} --out {out}.csv",
    ("project", ""): "project {file} --camera camera.yaml",
    ("project", "--camera"): "project points.csv --camera {file}",
    ("unproject", ""): "unproject {file} --camera camera.yaml",
    ("unproject", "--camera"): "unproject pixels.csv --camera {file}",
}

AMONG_PICTURES = {
    "detect": "detect --target target.yaml {file}",
    "strict": "detect --target target.yaml --strict {file}",
    "watch": "watch {file} --target target.yaml --model f --timeout 1.2 --no-cache --out /dev/null",
    "pose": "pose --target target.yaml --camera camera.yaml {file}/*.png",
}

OUTPUTS = {
    ("render", "--out"): "render scene.yaml --views 1 --out {file}",
    ("render", "--resume"): "render scene.yaml --views 1 --resume --out {file}",
    ("detect", "--out"): "detect set --no-cache --out {file}",
    ("detect", "cache"): "detect set --out {file}",
    ("calibrate", "--keep"): "calibrate a.mcap --target target.yaml --model f --keep {file}",
    ("detect", "--draw"): "detect set --no-cache --draw {file}",
    ("calibrate", "--out"): "calibrate set --observations corners.csv --model f --out {file}",
    ("calibrate", "several"): "calibrate set set2 --model f --no-cache --out {file}",
    ("calibrate", "--uncertainty"): "calibrate set --observations corners.csv --model f "
                                    "--uncertainty {file}.svg",
    ("calibrate", "--report"): "calibrate set --observations corners.csv --model f --report "
                               "{file}.html",
    ("watch", "--out"): "watch set/images --target target.yaml --model f --timeout 0.01 --no-cache "
                        "--out {file}",
    ("report", "--out"): "report camera.yaml --out {file}",
    ("pose", "--draw"): "pose set --observations corners.csv --camera camera.yaml --draw {file}",
    ("handeye", "--out"): "handeye arm --camera arm/truth.yaml --robot arm/robot.csv --mount hand --out {file}",
    ("handeye", "--report"): "handeye arm --camera arm/truth.yaml --robot arm/robot.csv --mount hand --report "
                             "{file}.html",
    ("handeye", "--ros"): "handeye arm --camera arm/truth.yaml --robot arm/robot.csv --mount hand --ros {file}",
    ("board", "--out"): "board target.yaml --out {file}.pdf",
    ("fleet", "--out"): "fleet cams --limits limits.yaml --out {file}.csv",
    ("fleet", "page"): "fleet cams --limits limits.yaml --out {file}.html",
    ("convert", ""): "convert camera.yaml {file} --to ros",
    ("convert", "folder"): "convert camera.yaml {file} --to colmap",
    ("convert", "--picture"): "convert camera.yaml {out}.yaml --to tagcal --model radial2 --picture "
                              "{file}.svg",
    ("reproject", "--out"): "reproject photo.png --camera camera.yaml --undistort all --out {file}",
    ("reproject", "--rectify"): "reproject photo.png other.png --camera chain.yaml --cameras cam0,cam1 "
                                "--rectify {file}",
    ("pose", "--out"): "pose set --observations corners.csv --camera camera.yaml --out {file}.csv",
    ("triangulate", "--out"): "triangulate pixels_of_rig.csv --camera chain.yaml --out {file}",
    ("project", "--out"): "project points.csv --camera camera.yaml --out {file}",
    ("unproject", "--out"): "unproject pixels.csv --camera camera.yaml --out {file}",
    ("completion", "--share"): "completion --share {file}",
}

# Options whose name of a value says that it is a file.
FILES = {"T.yaml", "CSV", "FILE", "FILE|DIR", "FILE.html", "CAMERA", "C.yaml", "OTHER.yaml", "DIR",
         "D", "DATASET", "JSON", "SVG"}
KINDS = ["folder", "device", "pipe", "socket", "dangling", "loop", "unreadable", "empty", "binary"]


def make(folder, kind, suffix=""):
    """A thing of this kind."""
    path = folder / f"{kind}{suffix}"
    if kind == "folder":
        path.mkdir()
    elif kind == "device":
        path.symlink_to("/dev/zero")
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "socket":
        with socket.socket(socket.AF_UNIX) as end:
            end.bind(str(path))
    elif kind == "dangling":
        path.symlink_to(folder / "nowhere" / "at-all")
    elif kind == "loop":
        path.symlink_to(path.name)
    elif kind == "unreadable":
        path.write_text("image_size: [1, 1]\n")
        path.chmod(0)
    elif kind == "empty":
        path.write_bytes(b"")
    elif kind == "binary":
        path.write_bytes(bytes(range(256)) * 8)
    return path


def state(path):
    """What a thing is; a folder with what is in it."""
    if path.is_symlink():
        return os.readlink(path)
    return sorted(p.name for p in path.iterdir()) if path.is_dir() else path.stat().st_mode


def run(words, shop, kind):
    """As nobody where a file must not be read: root reads all."""
    is_root = kind == "unreadable" and os.geteuid() == 0
    done = trial.run(words, shop, LIMIT_S, (lambda: os.setuid(65534)) if is_root else None)
    return done._replace(code=124) if trial.IS_MEASURED and done.cpu_s > MOST_S else done


def check_among_pictures(shop, place, kind, line):
    """A thing that is named like a picture, in a folder of pictures: it is left out."""
    (place / "good.png").symlink_to(shop / "photo.png")
    make(place, kind, ".png")
    done = run(line.format(file=place).split(), shop, kind)
    wrong = done.code not in ((0, 2) if "--strict" in line else (0, 3))
    return [f"exit code {done.code}: {done.err[-200:]}"] if wrong else []


def check_input(shop, place, kind, line):
    path = make(place, kind)
    done = run(line.format(file=path, out=place / "out").split(), shop, kind)
    found = []
    # watch follows a folder without pictures; of several data sets the others are answered.
    fine = (3,) if kind == "folder" and line.startswith("watch {") else (2,)
    if "{file} set " in line:
        fine = (2, 3)
    if done.code not in fine:
        found.append(f"exit code {done.code}")
    elif done.code == 2 and not trial.is_one_error_line(done.err):
        found.append("not one line")
    written = [p.name for p in place.glob("out*")]
    if written and 3 not in fine:
        found.append("wrote " + " ".join(written))
    return [f"{what}: {done.err[-200:]}" for what in found]


def check_output(shop, place, kind, line):
    suffix = re.search(r"\{file\}(\.\w+)?", line).group(1) or ""
    path = make(place, kind, suffix)
    before = state(path)
    done = run(line.format(file=place / kind, out=place / "out").split(), shop, kind)
    found = []
    if done.code not in (0, 2):
        found.append(f"exit code {done.code}")
    if done.code == 2 and not trial.is_one_error_line(done.err):
        found.append("not one line")
    if kind in ("device", "pipe", "socket", "loop", "unreadable") and state(path) != before:
        found.append("was replaced")
    left = [p.name for p in place.rglob("*") if ".tagcal-" in p.name or ".partial" in p.name]
    if left and "--resume" not in line:
        found.append("left " + " ".join(left))
    return [f"{what}: {done.err[-200:]}" for what in found]


def uncovered(folder):
    """Options with a file that the tables do not have."""
    missing = []
    for command in {name for name, _ in INPUTS} | {name for name, _ in OUTPUTS}:
        text = trial.run([command, "--help"], folder).out
        for option, value in re.findall(r"^  (--[\w-]+) (\S+)", text, re.MULTILINE):
            if value in FILES and (command, option) not in INPUTS and (command, option) not in OUTPUTS:
                missing.append(f"{command} {option} {value}")
    return missing


def add_rig(shop):
    """Two cameras like that of the workshop, and a point that both see."""
    (shop / "other.png").write_bytes((shop / "photo.png").read_bytes())
    text = (shop / "camera.yaml").read_text()
    width, height = (int(re.search(f"image_{side}: (\\d+)", text).group(1)) for side in ("width", "height"))
    place = "T_cn_cnm1: [[1, 0, 0, -0.1], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]"
    (shop / "chain.yaml").write_text("".join(
        f"cam{i}: {{camera_model: pinhole, intrinsics: [{width}, {width}, {width / 2}, {height / 2}], "
        f"distortion_model: none, resolution: [{width}, {height}]{', ' + place if i else ''}}}\n"
        for i in range(2)))
    (shop / "pixels_of_rig.csv").write_text("point,camera,u_px,v_px\np,cam0,100,100\np,cam1,90,100\n")


def add_arm(shop):
    """A camera on a robot's hand."""
    golden = Path(__file__).resolve().parents[2] / "data-synthetic" / "golden" / "desk"
    (shop / "arm").symlink_to(golden)
    (shop / "path.txt").write_text("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n")


def add_bag(shop):
    """An MCAP file of the data set's pictures."""
    def text(data):
        return struct.pack("<I", len(data)) + data

    def record(op, data):
        return bytes([op]) + struct.pack("<Q", len(data)) + data

    magic = b"\x89MCAP0\r\n"
    bag = magic + record(3, struct.pack("<H", 1) + text(b"sensor_msgs/CompressedImage") + text(b"") + text(b""))
    bag += record(4, struct.pack("<HH", 1, 1) + text(b"/camera") + text(b"ros1") + text(b""))
    for i, picture in enumerate(sorted((shop / "set" / "images").glob("*.png"))):
        message = struct.pack("<III", i, 1000, i) + text(b"camera") + text(b"png") + text(picture.read_bytes())
        bag += record(5, struct.pack("<HIQQ", 1, i, i, i) + message)
    (shop / "a.mcap").write_bytes(bag + record(2, bytes(20)) + magic)


def main(every):
    with tempfile.TemporaryDirectory() as temporary:
        shop = trial.workshop(temporary)
        (shop / "new").mkdir()
        (shop / "set2").symlink_to("set")
        add_rig(shop)
        add_arm(shop)
        add_bag(shop)
        shop.chmod(0o755)
        trials = [(check, kind, line) for check, lines in ((check_input, INPUTS),
                                                           (check_output, OUTPUTS),
                                                           (check_among_pictures, AMONG_PICTURES))
                  for i, line in enumerate(lines.values()) for k, kind in enumerate(KINDS)
                  if every or (i + k) % 2 == 0]

        def work(numbered):
            number, (check, kind, line) = numbered
            place = shop / f"trial{number}"
            place.mkdir()
            place.chmod(0o777)
            return [f"{kind}: tagcal {line}\n  {what}" for what in check(shop, place, kind, line)]

        with ThreadPoolExecutor(2) as pool:
            mistakes = sum(pool.map(work, enumerate(trials)), [])
        mistakes += [f"not tried: {option}" for option in uncovered(shop)]
    print("\n".join(mistakes))
    print(f"{len(INPUTS) + len(AMONG_PICTURES)} inputs and {len(OUTPUTS)} outputs, "
          f"{len(KINDS)} kinds of files, "
          f"{len(trials)} trials: {len(mistakes)} mistakes")
    return 1 if mistakes else 0


if __name__ == "__main__":
    sys.exit(main("--all" in sys.argv[1:]))
