"""Processes that share one folder: two of the same work, killed ones, and a full disk."""

import os
import shutil
import signal
import subprocess
import tempfile
import time
from pathlib import Path

import fleets

COUNT = min(fleets.SETS, 300)


def start(place, out, *more):
    sets = sorted(str(p) for p in (place / "cameras").glob("*"))
    return subprocess.Popen([fleets.COMMAND, "calibrate", *sets, *fleets.options(out), *more],
                            cwd=place, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def two_jobs(place):
    """Both at once: each set once, by one or the other."""
    jobs = [start(place, "two") for _ in range(2)]
    fleets.wait_for("a first set", lambda: fleets.num_done(place, "two") > 0)
    assert all(job.wait(300) == 0 for job in jobs)
    fleets.check_equal(place, "two")


def killed(place):
    """kill -9 after each quarter; what is done stays done."""
    for quarter in range(1, 5):
        before = fleets.times(place, "killed")
        job = start(place, "killed")
        while job.poll() is None and fleets.num_done(place, "killed") < quarter * COUNT // 4:
            time.sleep(0.002)
        if quarter < 4:
            job.kill()
            print("killed at", fleets.num_done(place, "killed"))
        assert job.wait() == (0 if quarter == 4 else -signal.SIGKILL)
        fleets.check_nothing_twice(before, fleets.times(place, "killed"))
    fleets.check_equal(place, "killed")


def chunks(place):
    """Chunks of other sizes, also more than there are sets, and in another order: the same bytes."""
    sets = sorted(str(p) for p in (place / "cameras").glob("*"))[:40]
    fleets.tagcal(place, "calibrate", *sets, *fleets.options("forty"))
    for count in (3, 50):
        for k in range(count, 0, -1):
            fleets.tagcal(place, "calibrate", *sets[::-1], *fleets.options(f"by{count}"), "--chunk",
                          f"{k}/{count}")
        fleets.check_equal(place, f"by{count}", "forty")


def full_disk(place):
    """One line and exit code 2, nothing half there; with space again it goes on."""
    out = place / "full"
    out.mkdir()
    if os.geteuid() != 0 or not shutil.which("mount") or subprocess.run(
            ["mount", "-t", "tmpfs", "-o", "size=400k", "tmpfs", out], capture_output=True).returncode != 0:
        print("full disk: skipped, needs root and mount")
        return
    try:
        sets = sorted(str(p) for p in (place / "cameras").glob("*"))
        done = fleets.tagcal(place, "calibrate", *sets, *fleets.options("full"), code=2)
        assert "No space left" in done.stdout, done.stdout[-300:]
        serial = fleets.contents(place / "serial")
        left = fleets.contents(out)
        half = [name for name in left if left[name] != serial[name]]
        assert left and not half, half[:5]
        assert not list(out.rglob(".tagcal-*"))
        subprocess.run(["mount", "-o", "remount,size=64m", out], check=True)
        before = {name for name in left if name.startswith("summary/") and name.endswith("json")}
        times = fleets.times(place, "full")
        fleets.tagcal(place, "calibrate", *sets, *fleets.options("full"))
        fleets.check_nothing_twice(times, fleets.times(place, "full"))
        assert before
        fleets.check_equal(place, "full")
    finally:
        subprocess.run(["umount", out], check=True)


def other_work(place):
    """Other options are refused, and leave everything as it was."""
    before = fleets.contents(place / "two")
    sets = sorted(str(p) for p in (place / "cameras").glob("*"))
    done = fleets.tagcal(place, "calibrate", *sets, *fleets.options("two"), "--sigma-px", "1", code=2)
    assert done.stderr.count("\n") == 1 and "other options" in done.stderr, done.stderr
    assert fleets.contents(place / "two") == before


def main():
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder)
        fleets.make_sets(place, COUNT)
        fleets.calibrate_serially(place)
        for test in (two_jobs, killed, chunks, full_disk, other_work):
            test(place)
        fleets.check_fleet(place, "two")


main()
