"""The pages that the test opens, made by the built command from small rendered data sets."""

import csv
import json
import random
import re
import subprocess
from pathlib import Path
from typing import Any, Callable, NamedTuple

DESK = Path(__file__).resolve().parents[2] / "data-synthetic/golden/desk"

GOOD_SCENE = """
camera: {image_size: [640, 400], model: radial1, f: 520, cx: 317, cy: 203, distortion: [-0.1]}
boards:
  - target: {target_type: aprilgrid, tagCols: 6, tagRows: 5, tagSize: 0.04, tagSpacing: 0.3,
             border_bits: 1, corner_squares: false}
path: {type: dome, target_m: [0.15, 0.125, 0], min_distance_m: 0.28, max_distance_m: 0.5,
       min_elevation_deg: 40, max_elevation_deg: 85}
jitter: {target_m: 0.06, roll_deg: 40}
views: 16
sensor: {blur_px: 0.7, noise_levels: 2}
"""

FISHEYE_SCENE = """
camera: {image_size: [640, 480], model: fisheye4, f: 200, cx: 319.5, cy: 239.5,
         distortion: [0.02, 0, 0, 0]}
boards:
  - target: {target_type: aprilgrid, tagCols: 6, tagRows: 6, tagSize: 0.088, tagSpacing: 0.3}
path: {type: dome, target_m: [0.33, 0.33, 0], min_distance_m: 0.4, max_distance_m: 0.7,
       min_elevation_deg: 40, max_elevation_deg: 85}
jitter: {target_m: 0.2, roll_deg: 60}
views: 8
sensor: {blur_px: 0.7, noise_levels: 2}
"""

RIG_SCENE = """
rig:
  cameras:
    - {name: left, camera: {image_size: [480, 360], model: pinhole, f: 400}}
    - name: middle
      camera: {image_size: [480, 360], model: pinhole, f: 400}
      rig_from_camera: {translation_m: [0.06, 0.01, 0], roll_pitch_yaw_deg: [1, 0, 2]}
    - name: right
      camera: {image_size: [400, 300], model: pinhole, f: 330}
      rig_from_camera: {translation_m: [0.12, 0.002, 0.001], roll_pitch_yaw_deg: [1, 2, 3]}
boards:
  - target: {target_type: aprilgrid, tagCols: 4, tagRows: 4, tagSize: 0.08, tagSpacing: 0.3}
    world_from_board: {translation_m: [-0.2, -0.2, 0]}
path: {type: dome, min_distance_m: 0.6, max_distance_m: 0.9, min_elevation_deg: 50}
jitter: {target_m: 0.05, roll_deg: 180}
views: 14
sensor: {blur_px: 0.6, noise_levels: 2}
"""

# Names that would run or end a script if they were taken for HTML. "/" makes a folder of the last.
HOSTILE_PICTURES = {"000.png": "<img src=x onerror=alert(1)>.png",
                    "001.png": "<script>alert(2)</script>.png"}  # has no file: "/"
HOSTILE_FOLDER = "</script><img src=x onerror=alert(3)>"


START = '<script type="application/json" id="data">'
BLOCK = re.compile(f"{START}(.*?)</script>", re.DOTALL)


class Page(NamedTuple):
    file: Path
    data: Any  # the JSON object in it


def data_of(file: Path) -> Any:
    text = file.read_text()
    block = BLOCK.search(text)
    assert block, f"{file}: no data"
    return json.loads(block[1])


def changed(page: Page, name: str, change: Callable[[Any], None]) -> Page:
    """A page beside this one with other data in it."""
    data = json.loads(json.dumps(page.data))
    change(data)
    before, after = BLOCK.split(page.file.read_text(), maxsplit=1)[::2]
    text = json.dumps(data).replace("<", "\\u003c")
    file = page.file.with_name(name)
    file.write_text(f"{before}{START}{text}</script>{after}")
    return Page(file, data)


class Maker:
    """Runs the command in a folder and remembers nothing but the folder."""

    def __init__(self, command: str, folder: Path) -> None:
        self.command = command
        self.folder = folder

    def run(self, *arguments: str, exit_code: int = 0) -> str:
        done = subprocess.run([self.command, *arguments], cwd=self.folder, capture_output=True,
                              text=True, stdin=subprocess.DEVNULL)
        assert done.returncode == exit_code, f"tagcal {' '.join(arguments)}\n{done.stderr}"
        return done.stdout

    def render(self, name: str, scene: str) -> None:
        (self.folder / f"{name}.scene.yaml").write_text(scene)
        self.run("render", f"{name}.scene.yaml", "--out", name)

    def exact_rows(self, name: str) -> list[list[str]]:
        """The corners of a set, after the line of heads."""
        with open(self.folder / name / "observations_exact.csv", newline="") as file:
            return list(csv.reader(file))[1:]

    def spill(self, name: str, rows: list[list[str]], folder: Path) -> None:
        """A data set of these corners on the target and the pictures of the set "name"."""
        folder.mkdir(exist_ok=True)
        with open(folder / "corners.csv", "w", newline="") as file:
            writer = csv.writer(file)
            writer.writerows([["image", "tag_id", "corner", "x_px", "y_px"], *rows])
        for part in ("target.yaml", "images"):
            link = folder / part
            if not link.exists():
                link.symlink_to(self.folder / name / part)
        (folder / "dataset.yaml").write_text(
            "image_size: [640, 400]\ntarget: target.yaml\nimages: images\n"
            "observations: corners.csv\n")


def good(maker: Maker) -> None:
    maker.run("calibrate", "good", "--out", "camera.yaml", "--report", "good.html")


def fisheye(maker: Maker) -> None:
    maker.render("fisheye", FISHEYE_SCENE)
    maker.run("calibrate", "fisheye", "--report", "fisheye.html")


def findings(maker: Maker) -> None:
    """Noise, wrong corners in four pictures, a missing picture, and a model that is too small."""
    noise = random.Random(1)
    rows = maker.exact_rows("good")
    spoilt = ("001.png", "004.png", "005.png", "011.png")
    for count, row in enumerate(rows):
        wrong = 9 if count % 9 == 0 and row[0] in spoilt else 0
        row[3:] = [str(float(x) + noise.gauss(0, 0.2) + wrong) for x in row[3:]]
    rows = [["not-there.png" if row[0] == "007.png" else row[0], *row[1:]] for row in rows]
    maker.spill("good", rows, maker.folder / "spoilt")
    maker.run("calibrate", "spoilt", "--model", "f", "--sigma-px", "0.2", "--out", "spoilt.yaml",
              "--report", "findings.html")


def no_answer(maker: Maker) -> None:
    """Three tags of one picture, which are too few for the model."""
    rows = [row for row in maker.exact_rows("good") if row[0] == "000.png" and int(row[1]) < 3]
    maker.spill("good", rows, maker.folder / "one")
    maker.run("calibrate", "one", "--model", "opencv8", "--sigma-px", "1", "--report",
              "no_answer.html", exit_code=3)


def difference(maker: Maker) -> None:
    maker.run("report", "camera.yaml", "spoilt.yaml", "--out", "difference.html")


def poses(maker: Maker) -> None:
    answer = maker.run("pose", "good", "--camera", "camera.yaml", "--json")
    (maker.folder / "poses.json").write_text(answer)
    maker.run("report", "poses.json", "--dataset", "good", "--camera", "camera.yaml", "--out",
              "poses.html")


def bare(maker: Maker) -> None:
    maker.run("report", "camera.yaml", "--out", "bare.html")


def hostile(maker: Maker) -> None:
    """Pictures, a data set and a camera with names that are HTML."""
    folder = maker.folder / HOSTILE_FOLDER
    rows = [[HOSTILE_PICTURES.get(row[0], row[0]), *row[1:]] for row in maker.exact_rows("good")]
    pictures = folder / "set" / "images"
    pictures.mkdir(parents=True)
    for picture in (maker.folder / "good" / "images").iterdir():
        name = HOSTILE_PICTURES.get(picture.name, picture.name)
        if "/" not in name:
            (pictures / name).symlink_to(picture)
    maker.spill("good", rows, folder / "set")
    camera = folder / "camera.yaml"
    camera.write_text((maker.folder / "camera.yaml").read_text())
    maker.run("report", str(camera), "--dataset", str(folder / "set"), "--out", "hostile.html")


def rig(maker: Maker) -> None:
    """Three cameras; one picture of the right one is taken for that of another instant."""
    maker.render("trio", RIG_SCENE)
    wrong = {5: "009.png", 9: ""}
    rows = [f"{n:03}.png,{n:03}.png,{wrong.get(n, f'{n:03}.png')}" for n in range(14)]
    (maker.folder / "pairs.csv").write_text("\n".join(["left,middle,right", *rows]) + "\n")
    folders = [f"trio/{name}/images" for name in ("left", "middle", "right")]
    maker.run("rig", *folders, "--target", "trio/target.yaml", "--pair", "pairs.csv", "--out",
              "trio.yaml", "--report", "rig.html")


def rig_file(maker: Maker) -> None:
    maker.run("report", "trio.yaml", "--out", "rig_file.html")


def on_robot(maker: Maker, page: str, change: Callable[[str], str], exit_code: int) -> None:
    """The desk's camera on a robot whose table is changed."""
    (maker.folder / "robot.csv").write_text(change((DESK / "robot.csv").read_text()))
    maker.run("handeye", str(DESK), "--camera", str(DESK / "truth.yaml"), "--robot", "robot.csv",
              "--mount", "hand", "--report", page, exit_code=exit_code)


def handeye(maker: Maker) -> None:
    """One of the robot's poses is off by 27 mm."""
    on_robot(maker, "handeye.html", lambda table: table.replace("004.png,0.", "004.png,0.1"), 0)


def handeye_refused(maker: Maker) -> None:
    on_robot(maker, "handeye_refused.html", lambda table: table.replace("_m", "_mm"), 3)


# In the order in which they are made: later ones use files of earlier ones.
MAKERS: list[Callable[[Maker], None]] = [
    good, fisheye, findings, no_answer, difference, poses, bare, hostile, rig, rig_file, handeye,
    handeye_refused]


def make_pages(command: str, folder: Path) -> dict[str, Page]:
    maker = Maker(command, folder)
    maker.render("good", GOOD_SCENE)
    pages = {}
    for make in MAKERS:
        make(maker)
        file = folder / f"{make.__name__}.html"
        pages[make.__name__] = Page(file, data_of(file))
    return pages
