"""Memory that does not grow with what it need not: calibrate() with many views (tagcal-study
big_data), and detect on folders of 100 and 250 pictures.

memory_test.py                         the marks, with 3,000 views and small pictures
memory_test.py --pictures 20 200 1000  detect on so many pictures of 12 megapixels; prints a table
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path

COMMAND = str(Path(os.environ.get("TAGCAL_COMMAND", "build/release/tools/tagcal")).resolve())
STUDY = os.environ.get("TAGCAL_STUDY", "build/release/tools/tagcal-study")
VIEWS = 3000
MOST_BYTES = 220   # a corner beyond the input: 200, and 6 to 8 MB of code and libraries with so few views
MOST_KEPT = 0.5  # of the levels of further pictures in the peak memory of detect

SCENE = """camera: {{image_size: [{0}, {1}], model: radial1, f: {0}, distortion: [-0.1]}}
boards: [{{target: {{target_type: aprilgrid, tagCols: 3, tagRows: 2, tagSize: 0.04, tagSpacing: 0.3}}}}]
path: {{type: dome, min_distance_m: 0.9, max_distance_m: 1, min_elevation_deg: 60}}
views: 4
"""


def bytes_a_corner(model):
    done = subprocess.run([STUDY, "big_data", str(VIEWS), "--model", model], capture_output=True, text=True, check=True)
    fields = [field.strip() for field in done.stdout.splitlines()[-1].split("|")]
    return float(fields[4]), done.stdout.splitlines()[-1]


def peak_of(arguments, folder):
    """Peak memory in MB and CPU time of the command, which must end well."""
    process = os.fork()
    if process == 0:
        os.chdir(folder)
        os.dup2(os.open("/dev/null", os.O_WRONLY), 1)
        os.dup2(os.open("/dev/null", os.O_WRONLY), 2)
        os.execv(COMMAND, [COMMAND, *arguments])
    _, status, usage = os.wait4(process, 0)
    assert status == 0, arguments
    return usage.ru_maxrss / 1024, usage.ru_utime + usage.ru_stime


def detect_peaks(size, counts, threads):
    """(pictures, MB, CPU seconds) of detect on folders of links to a few pictures."""
    peaks = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        (folder / "scene.yaml").write_text(SCENE.format(*size))
        peak_of(["render", "scene.yaml", "--out", "set"], folder)
        pictures = sorted((folder / "set/images").iterdir())
        for count in counts:
            many = folder / f"of{count}"
            many.mkdir()
            for i in range(count):
                os.link(pictures[i % len(pictures)], many / f"{i:05}.png")
            peaks.append((count, *peak_of(["detect", "--target", "set/target.yaml", str(many), "--no-cache",
                                           "--threads", str(threads), "--out", "corners.csv"], folder)))
    return peaks


def main():
    if "--pictures" in sys.argv:
        print("| pictures of 12 MP | peak memory, MB | CPU, s |\n|---|---|---|")
        for count in map(int, sys.argv[sys.argv.index("--pictures") + 1:]):
            for row in detect_peaks((4000, 3000), [count], 2):
                print("| {} | {:.0f} | {:.0f} |".format(*row), flush=True)
        return 0
    if os.environ.get("TAGCAL_SANITIZE"):
        print("skipped: under a sanitizer a program takes other memory")
        return 77
    mistakes = []
    if Path(STUDY).exists():
        for model in ("opencv5", "auto"):
            found, row = bytes_a_corner(model)
            print(row)
            if found > MOST_BYTES:
                mistakes.append(f"calibrate, model {model}: {found} bytes a corner, more than {MOST_BYTES}")
    # On one thread: of two, a busy machine may let one find all of the few pictures, in one heap. The
    # heap of Debian 13 grows once, by 9 MB, in any of the first 250 pictures.
    (few, few_mb, _), (many, many_mb, _) = detect_peaks((640, 480), (100, 250), 1)
    print(f"detect: {few_mb:.0f} MB for {few} pictures, {many_mb:.0f} MB for {many}")
    if many_mb - few_mb > MOST_KEPT * (many - few) * 640 * 480 / 1e6:
        mistakes.append(f"detect: {many_mb:.0f} MB for {many} pictures, {few_mb:.0f} MB for {few}")
    print("\n".join(mistakes))
    return 1 if mistakes else 0


if __name__ == "__main__":
    sys.exit(main())
