"""Runs the whole chain for hours: crashes, memory that grows, work that becomes slower.

    PYTHONPATH=build/release/python python3 tools/studies/soak.py run --minutes 40
    python3 tools/studies/soak.py table

A piece is one process that renders, detects, calibrates and estimates poses again and again in the
same few random worlds (docs/trust/worlds.md), each time with new noise; so its memory must stay and
its times may be compared. After each round it also sends one new world through the commands
`render`, `detect` and `calibrate`, each a process of its own, which may end with an answer (0) or
without one (3) and with nothing on stderr but lines of its own. A world whose pictures show fewer than 12
corners (its tags are too small or too blurred) must be refused as bad input (2). The rounds of all
pieces are in build/soak/rounds.csv; a later piece goes on with the next seeds. `table` ends with 1
if a bound is broken.
"""

import argparse
import csv
import resource
import shutil
import statistics
import subprocess
import sys
import time
from pathlib import Path

FOLDER = Path("build/soak")
ROUNDS = FOLDER / "rounds.csv"
TROUBLES = FOLDER / "troubles"
KEYS = ["piece", "round", "seed", "seconds", "commands_s", "rss_kb", "calibrations", "answers",
        "codes", "troubles"]
# Messages, and the lines of progress of a process that takes more than a second.
OWN_LINES = ("tagcal: ", "wrote ", "rendering: ", "detecting: ", "calibrating: ")
MIN_CORNERS = 12  # fewer in all are bad input for `calibrate` (tools/job/find_corners.cpp)
WORLDS = 12  # of 2 to 40 views, about 10 s a round
# glibc keeps freed memory for the next round: the first tenth fills its arenas. What then still
# grows by more than a kB a calibration is a leak: the smallest object of a result is larger.
GROWTH_KB = 1.0
# Two runs of the same work on one machine differ by some percent.
SLOWER = 1.10


def program(name):
    return f"build/release/tools/{name}"


def resident_kb():
    """Without pages of files, which the system drops and reads again as it likes."""
    with open("/proc/self/statm", encoding="ascii") as file:
        _, resident, shared = file.read().split()[:3]
        return (int(resident) - int(shared)) * 4


def world(index):
    file = FOLDER / f"world_{index}.yaml"
    if not file.exists():
        command = [program("tagcal-study"), "worlds", "scene", "--index", str(index), "--out",
                   str(file)]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return file


def children_seconds():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def chain(tagcal, scene, seed):
    """From the scene to poses, in this process; true if there is a camera."""
    pictures = [tagcal.render(scene, view, seed=seed) for view in range(len(scene))]
    views = [tagcal.detect(picture, scene.target) for picture in pictures]
    views = [view for view in views if len(view.ids) > 0]
    height, width = pictures[0].shape
    answer = tagcal.calibrate(tagcal.Dataset((width, height), scene.target, views))
    if answer.camera is None:
        return False
    for view in views:
        tagcal.estimate_view_pose(view, scene.target, answer.camera, camera_error_px=0.1)
    return True


def expected_codes(name, corners):
    if name != "calibrate":
        return (0,)
    with open(corners, encoding="utf-8", newline="") as file:
        enough = sum(1 for _ in csv.DictReader(file)) >= MIN_CORNERS
    return (0, 3) if enough else (2,)


def commands(index):
    """One world in three processes: exit codes, and a sentence for what must not be."""
    scene, folder, corners = world(index), FOLDER / "one", FOLDER / "one.csv"
    codes, trouble = [], None
    for arguments in (
        ["render", scene, "--out", folder, "--force", "--seed", str(index)],
        ["detect", folder, "--out", corners],
        ["calibrate", folder, "--observations", corners],
    ):
        run = subprocess.run(
            [program("tagcal"), *map(str, arguments)], capture_output=True, text=True, check=False
        )
        codes.append(run.returncode)
        own = all(line.startswith(OWN_LINES) for line in run.stderr.splitlines())
        if not own or run.returncode not in expected_codes(arguments[0], corners):
            trouble = f"{arguments[0]}: {run.returncode}\n{run.stderr}"
            break
    if trouble:
        TROUBLES.mkdir(exist_ok=True)
        shutil.copy(scene, TROUBLES)
        (TROUBLES / f"world_{index}.txt").write_text(trouble, encoding="utf-8")
    scene.unlink()
    return codes, trouble


def rounds_so_far():
    if not ROUNDS.exists():
        return []
    with open(ROUNDS, encoding="ascii", newline="") as file:
        return list(csv.DictReader(file))


def run_piece(minutes, first_seed):
    import tagcal  # the table needs no module

    FOLDER.mkdir(parents=True, exist_ok=True)
    earlier = rounds_so_far()
    piece = 1 + max((int(row["piece"]) for row in earlier), default=0)
    last_seed = int(earlier[-1]["seed"]) if earlier else 0
    seed = first_seed - 1 if first_seed else last_seed
    scenes = [tagcal.read_scene(world(index)) for index in range(WORLDS)]
    end = time.monotonic() + 60 * minutes
    with open(ROUNDS, "a", encoding="ascii", newline="") as file:
        rows = csv.DictWriter(file, KEYS)
        if not earlier:
            rows.writeheader()
        number = 0
        while time.monotonic() < end:
            seed, number = seed + 1, number + 1
            start = time.process_time()
            answers = sum(chain(tagcal, scene, seed) for scene in scenes)
            seconds = time.process_time() - start
            before = children_seconds()
            codes, trouble = commands(WORLDS + seed)
            times = [f"{seconds:.3f}", f"{children_seconds() - before:.3f}"]
            row = [piece, number, seed, *times, resident_kb(), WORLDS, answers]
            rows.writerow(dict(zip(KEYS, [*row, "/".join(map(str, codes)), int(bool(trouble))])))
            file.flush()


def piece_row(piece, rows):
    """Cells of the table, and whether the bounds hold."""
    tenth = max(1, len(rows) // 10)
    filled, last = rows[tenth:] or rows, rows[-1]
    memory = [int(row["rss_kb"]) for row in filled]
    count = [i * WORLDS for i in range(len(filled))]
    growth = 0.0
    if len(filled) > 2:
        growth = statistics.linear_regression(count, memory).slope
    seconds = [float(row["seconds"]) for row in rows]
    slower = statistics.median(seconds[-tenth:]) / statistics.median(seconds[:tenth])
    commands_s = sum(float(row["commands_s"]) for row in rows)
    troubles = sum(int(row["troubles"]) for row in rows)
    # A short piece has too few rounds for a slope or a ratio to mean anything.
    holds = troubles == 0 and (len(rows) < 50 or (growth < GROWTH_KB and slower < SLOWER))
    cells = [
        piece,
        f"{(sum(seconds) + commands_s) / 60:.0f}",
        len(rows) * WORLDS,
        f"{memory[0] / 1024:.1f}",
        f"{int(last['rss_kb']) / 1024:.1f}",
        f"{growth:.3f}",
        f"{slower:.3f}",
        len(rows),
        troubles,
    ]
    return cells, holds


def print_table():
    rows = rounds_so_far()
    if not rows:
        sys.exit("soak.py: no round has run yet")
    heads = ["piece", "CPU minutes", "calibrations", "MB after a tenth", "MB at the end",
             "kB a calibration", "last / first tenth", "worlds by command", "troubles"]
    print("| " + " | ".join(heads) + " |")
    print("|---" * len(heads) + "|")
    all_hold = True
    for piece in sorted({int(row["piece"]) for row in rows}):
        cells, holds = piece_row(piece, [row for row in rows if int(row["piece"]) == piece])
        print("| " + " | ".join(map(str, cells)) + " |")
        all_hold = all_hold and holds
    sys.exit(0 if all_hold else 1)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    actions = parser.add_subparsers(dest="action", required=True)
    run = actions.add_parser("run", help="one piece")
    run.add_argument("--minutes", type=float, required=True)
    run.add_argument("--seed", type=int, help="of the first round, default: after the last one")
    actions.add_parser("table", help="what all pieces found")
    options = parser.parse_args()
    if options.action == "run":
        run_piece(options.minutes, options.seed)
    else:
        print_table()


if __name__ == "__main__":
    main()
