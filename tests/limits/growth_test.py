"""Inputs of one size and of four times the size: what the command costs must grow as they do.

growth_test.py          skipped (77) where costs are not those of the release program
growth_test.py NAME..   only these

Work that goes through a list for each of its own entries costs sixteen times as much.
"""

import json
import math
import sys
import tempfile
from pathlib import Path

import pictures
import trial

SKIPPED = 77
TIMES = 4
# In the middle, as factors, between work that grows as its input and work that grows as its square.
MOST_TIMES = 8
SLACK_S = 0.1  # start, and the noise of a busy machine
TARGET = "{target_type: aprilgrid, tagCols: 1, tagRows: 1, tagSize: 0.1, tagSpacing: 0.3}\n"
CHECKERBOARD = ("{target_type: checkerboard, targetCols: 7, targetRows: 6, rowSpacingMeters: 0.03, "
                "colSpacingMeters: 0.03}\n")
CIRCLES = "{target_type: circlegrid, targetCols: 8, targetRows: 6, spacingMeters: 0.03}\n"
POSE = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 2], [0, 0, 0, 1]]


def kalibr(folder, count):
    same = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    (folder / "chain.yaml").write_text("".join(
        f"cam{i}: {{camera_model: pinhole, intrinsics: [500, 500, 320, 240], distortion_model: none, "
        f"resolution: [640, 480]{', T_cn_cnm1: ' + str(same) if i else ''}}}\n" for i in range(count)))
    return ["convert", "chain.yaml", "out.yaml", "--to", "kalibr"]


def nerfstudio(folder, count):
    frames = [{"file_path": f"{i}.png", "transform_matrix": POSE, "w": 640, "h": 480, "fl_x": 500 + i}
              for i in range(count)]
    (folder / "transforms.json").write_text(json.dumps({"frames": frames}))
    return ["convert", "transforms.json", "out.yaml", "--to", "kalibr"]


def colmap(folder, count):
    (folder / "cameras.txt").write_text("".join(
        f"{i} PINHOLE 640 480 500 500 320 240\n" for i in range(count)))
    (folder / "images.txt").write_text("".join(
        f"{i} 1 0 0 0 0 0 2 {i} {i}.png\n\n" for i in range(count)))
    return ["convert", "cameras.txt", "out.yaml", "--to", "kalibr"]


def corners(folder, count):
    (folder / "corners.csv").write_text("image,tag_id,corner,x_px,y_px\n" + "".join(
        f"{i}.png,0,{k},{10 * k},{10 * k * k}\n" for i in range(count) for k in range(4)))
    (folder / "target.yaml").write_text(TARGET)
    return ["convert", "corners.csv", "out.csv", "--target", "target.yaml"]


def boards(folder, count):
    """A target that is named so often, and as long as the list of its names."""
    (folder / "long.yaml").write_text(TARGET + "#" * 60 * count)
    (folder / "dataset.yaml").write_text("image_size: [640, 480]\nobservations: none.csv\ntarget:\n" + "".join(
        f"  - {{file: long.yaml, first_id: {i}}}\n" for i in range(count)))
    (folder / "none.csv").write_text("image,tag_id,corner,x_px,y_px\n")
    return ["calibrate", "."]


def tiff(folder, count):
    """A directory of entries each of which has the whole file for its values."""
    size = 12 * (count + 10)
    entries = [(256, 4, 1, 64), (257, 4, 1, 64), (258, 3, 1, 8), (259, 3, 1, 1), (262, 3, 1, 1),
               (273, 4, 1, 8), (278, 4, 1, 64), (279, 4, 1, 4096)]
    entries += [(400 + i, 1, size, 8) for i in range(count)]
    (folder / "many.tif").write_bytes(pictures.tiff(entries, b"\0" * 4096))
    return ["detect", "--family", "tag36h11", "many.tif"]


def checkers(folder, count):
    """Squares of 10 px over a whole picture."""
    side = round((100 * count) ** 0.5)
    rows = [b"".join((b"\x20" * 10, b"\xe0" * 10)[(i + shift) % 2] for i in range(side // 10 + 1))[:side]
            for shift in (0, 1)]
    (folder / "squares.pgm").write_bytes(b"P5 %d %d 255\n" % (side, side)
                                         + b"".join(rows[y // 10 % 2] for y in range(side)))
    (folder / "checkerboard.yaml").write_text(CHECKERBOARD)
    return ["detect", "--target", "checkerboard.yaml", "squares.pgm"]


def circles(folder, count):
    """More discs than the target has, in one large lattice."""
    side = round(count ** 0.5)
    row = [b"".join((b"\x20" if abs(x) <= half else b"\xe0") for x in range(-7, 7)) * side
           for half in (math.sqrt(max(0, 21 - y * y)) if abs(y) < 5 else -1 for y in range(-7, 7))]
    (folder / "discs.pgm").write_bytes(b"P5 %d %d 255\n" % (14 * side, 14 * side) + b"".join(row) * side)
    (folder / "circles.yaml").write_text(CIRCLES)
    return ["detect", "--target", "circles.yaml", "discs.pgm"]


def corners_of_board(folder, count):
    """A checkerboard of so many corners, all of which are found."""
    side = round(count ** 0.5)
    white, edge = b"\xe0" * 12, b"\xe0" * 12 * (side + 3)
    rows = [white + b"".join((b"\x20" * 12, white)[(i + k) % 2] for i in range(side + 1)) + white
            for k in (0, 1)]
    (folder / "board.pgm").write_bytes(b"P5 %d %d 255\n" % (len(edge), len(edge)) + 12 * edge
                                       + b"".join(12 * rows[k % 2] for k in range(side + 1)) + 12 * edge)
    (folder / "board.yaml").write_text(
        f"{{target_type: checkerboard, targetCols: {side}, targetRows: {side}, rowSpacingMeters: 0.03, "
        "colSpacingMeters: 0.03}\n")
    return ["detect", "--target", "board.yaml", "board.pgm"]


# Exit code, and so many that the larger one takes a second or more if the work grows as its square.
INPUTS = {kalibr: (0, 3000), nerfstudio: (0, 3000), colmap: (0, 10000), corners: (0, 10000),
          boards: (2, 1000), tiff: (2, 16000), checkers: (0, 4000), circles: (0, 400),
          corners_of_board: (0, 1500)}


def cost(make, code, count):
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        done = trial.run(make(folder, count), folder, limit_s=600)
        assert done.code == code, (make.__name__, done.code, done.err[:500])
        return done.cpu_s


def main(names):
    if not trial.IS_MEASURED:
        return SKIPPED
    bad = 0
    print("| input | size | CPU, s | with four times the size |\n|---|---|---|---|")
    for make, (code, count) in INPUTS.items():
        if names and make.__name__ not in names:
            continue
        small, large = cost(make, code, count), cost(make, code, TIMES * count)
        is_bad = large > MOST_TIMES * small + SLACK_S
        bad += is_bad
        print(f"| {make.__name__} | {count} | {small:.2f} | {large:.2f}{' BAD' if is_bad else ''} |")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
