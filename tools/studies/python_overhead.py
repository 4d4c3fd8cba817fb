"""What a call from Python costs beside the same call from C++, and beside OpenCV's.

    PYTHONPATH=build/release/python python3 tools/studies/python_overhead.py \
        build/release/tools/tagcal-study

Runs the program given, which makes the numbers, answers and times of C++, and repeats all of it
through the module: answers are compared bit by bit. Rounds alternate; the fastest of each counts.
"""

import csv
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

import cv2
import numpy as np

import tagcal

ROUNDS = 15
NOISE = 0.1
HALF_SIDE = 0.05
CORNERS = HALF_SIDE * np.array([[-1, 1, 0], [1, 1, 0], [1, -1, 0], [-1, -1, 0]], dtype=float)
CAMERA = tagcal.Camera.perspective(
    700, 705, 330, 236, (640, 480), [-0.2, 0.06, 0.001, -0.0005]
)


def seconds(work):
    start = time.perf_counter()
    work()
    return time.perf_counter() - start


def fastest(works):
    """The least seconds of each of several functions, in alternating rounds."""
    rounds = [[seconds(work) for work in works] for _ in range(ROUNDS)]
    return np.min(rounds, axis=0)


def in_two_threads(work):
    threads = [threading.Thread(target=work) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()


def tag_rows(folder, cpp_us):
    pixels = np.fromfile(folder / "tag_pixels.f64").reshape(-1, 4, 2)
    answers = np.fromfile(folder / "tag_answers.f64").reshape(len(pixels), -1)
    tags = list(pixels)
    matrix, distortion = CAMERA.matrix, CAMERA.distortion

    def one_by_one():
        return [tagcal.estimate_pose(CORNERS, tag, CAMERA, NOISE) for tag in tags]

    def in_one_call():
        return tagcal.estimate_poses(CORNERS, pixels, CAMERA, NOISE)

    def opencv():
        for tag in tags:
            cv2.solvePnPGeneric(CORNERS, tag, matrix, distortion, flags=cv2.SOLVEPNP_IPPE_SQUARE)

    times = fastest([one_by_one, in_one_call, opencv, lambda: in_two_threads(in_one_call)])
    each, batch, cv, two = 1e6 * times / len(tags)
    best = [estimate.hypotheses[0] for estimate in one_by_one()]
    ours = [
        np.concatenate([h.camera_from_target.matrix.T.ravel(), h.covariance.T.ravel()])
        for h in best
    ]
    print(f"estimate_pose, one tag     {each:6.2f} us, {each - cpp_us:+5.2f} us to C++ ({cpp_us:.2f} us)")
    print(f"estimate_poses, each of {len(tags)} {batch:5.2f} us, {batch - cpp_us:+5.2f} us to C++")
    print(f"cv2.solvePnPGeneric        {cv:6.2f} us, {cv / each:.2f} times estimate_pose")
    print(f"two threads at once        {two / batch:6.2f} times the time of one (estimate_poses)")
    print(f"answers equal to the bit   {np.array_equal(ours, answers)}")


def projection_rows(folder, cpp_ms):
    points = np.fromfile(folder / "points.f64").reshape(-1, 3)
    expected = np.fromfile(folder / "pixels.f64").reshape(-1, 2)
    out = np.empty_like(expected)
    matrix, distortion, zero = CAMERA.matrix, CAMERA.distortion, np.zeros(3)
    ours, new, cv = 1e3 * fastest(
        [
            lambda: CAMERA.project(points, out=out),
            lambda: CAMERA.project(points),
            lambda: cv2.projectPoints(points, zero, zero, matrix, distortion),
        ]
    )
    print(f"Camera.project, out=       {ours:6.2f} ms of {len(points)} points, {ours / cpp_ms:.2f} times C++")
    print(f"Camera.project, new array  {new:6.2f} ms")
    print(f"cv2.projectPoints          {cv:6.2f} ms, {cv / ours:.1f} times Camera.project")
    print(f"pixels equal to the bit    {np.array_equal(out, expected, equal_nan=True)}")


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: python_overhead.py PROGRAM")
    with tempfile.TemporaryDirectory() as folder:
        times = Path(folder) / "times.csv"
        subprocess.run([sys.argv[1], "python_numbers", folder, "--csv", times], check=True,
                       stdout=subprocess.DEVNULL)
        lines = [line for line in times.open() if not line.startswith("#")]
        cpp = {row["task"].split(",")[0]: float(row["time"]) for row in csv.DictReader(lines)}
        tag_rows(Path(folder), cpp["pose"])
        projection_rows(Path(folder), cpp["project"])


if __name__ == "__main__":
    main()
