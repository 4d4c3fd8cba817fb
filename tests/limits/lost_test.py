"""Commands whose writing goes wrong: what is on the disk is the old output or the new one, whole.

lost_test.py                      one trial of every third pair (in the suite)
lost_test.py --trials N --seed S  N trials of each kind of trouble and command (--details: a row each;
                                  --only X: of one trouble or command)
"""

import argparse
import os
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import trial

LIMIT_S = 30.0
NOBODY = 65534

CORNERS = "set --observations corners.csv --model"
# name -> what writes {out}; and other options or input, for an output that differs.
COMMANDS = {
    "detect": ("detect set --no-cache --out {out}", "--refinement stock"),
    "calibrate": (f"calibrate {CORNERS} f --out {{out}}", "--sigma-px 1"),
    "--uncertainty": (f"calibrate {CORNERS} f --uncertainty {{out}}.svg", "--sigma-px 1"),
    "watch": ("watch set/images --target target.yaml --timeout 0.01 --no-cache --out {out}",
              "--model f"),
    "report": ("report camera.yaml --dataset set --out {out}.html", "--refinement stock"),
    "board": ("board target.yaml --out {out}.pdf", "--tile a4"),
    "board png": ("board target.yaml --out {out}.png", "--dpi 90"),
    "convert": ("convert camera.yaml {out} --to ros", "--model f --max-difference-px 1000"),
    "project": ("project points.csv --camera camera.yaml --out {out}", "--view 000.png"),
    "unproject": ("unproject pixels.csv --camera camera.yaml --out {out}", "--view 000.png"),
    "render": ("render scene.yaml --views 3 --out {out} --force", "--seed 5"),
    "detect --draw": ("detect set --no-cache --draw {out}", "--refinement stock"),
    "pose --draw": ("pose set --camera camera.yaml --draw {out}", "--refinement stock"),
    "reproject": ("reproject photo.png more.png --camera camera.yaml --undistort all --mask --maps "
                  "--force --out {out}", "--border 9"),
    "calibrate many": ("calibrate set set2 --no-cache --out {out} --model f", "--sigma-px 1"),
    "fleet": ("fleet cams --limits limits.yaml --out {out}.csv", ""),
    "convert folder": ("convert camera.yaml {out} --to colmap", "--model f --max-difference-px 1000"),
    "completion": ("completion --share {out}", ""),
}


def words_of(name, place, is_other=False):
    line, other = COMMANDS[name]
    return (line + (" " + other if is_other else "")).format(out=place / "out").split()


def contents(place):
    """Every file below the folder with its bytes; a report names its own place."""
    files = {}
    for path in sorted(place.rglob("*")):
        if path.is_file() and path.name != "filler":
            content = re.sub(rb"/tmp\w{8}/out", b"/PLACE/out", path.read_bytes())
            files[str(path.relative_to(place))] = content
    return files


def left_behind(files):
    return [name for name in files if ".tagcal-" in name or ".partial" in name
            or ".replaced" in name or ".resume" in name]


class Case:
    """A command with its old and its new output."""

    def __init__(self, name, shop):
        self.name, self.shop = name, shop
        self.old = self.clean_run(True) if COMMANDS[name][1] else {}
        start = time.monotonic()
        self.new = self.clean_run(False)
        self.seconds = time.monotonic() - start
        self.largest = max(len(content) for content in self.new.values())

    def clean_run(self, is_other):
        with tempfile.TemporaryDirectory(dir=self.shop) as folder:
            done = trial.run(words_of(self.name, Path(folder), is_other), self.shop)
            assert done.code == 0, (self.name, done.err)
            return contents(Path(folder))

    def is_calibration(self, content):
        """watch writes one after each picture: of fewer views, but with all keys."""
        last_key = re.findall(rb"^\w+:", self.new["out"], re.MULTILINE)[-1]
        return self.name == "watch" and content.endswith(b"\n") and last_key in content

    def put_old(self, place):
        for name, content in self.old.items():
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            (place / name).write_bytes(content)

    def verdict(self, place):
        """old, new, files (each of them old or new), or half; and what else is there."""
        found = contents(place)
        left = left_behind(found)
        kept = {name: found[name] for name in found if name not in left}
        if kept in (self.new, self.old | self.new):
            return "new", left
        if kept in (self.old, self.new | self.old):
            return "old", left
        whole = all(content in (self.old.get(name), self.new.get(name))
                    or self.is_calibration(content) for name, content in kept.items())
        return ("files" if whole and set(self.old) <= set(kept) else "half"), left


def outcome(case, place, code, err, signals=()):
    """A verdict and the mistakes of a trial."""
    verdict, left = case.verdict(place)
    wrong = []
    if case.name == "watch":
        signals += (3,)  # it ends with what it has, perhaps before it has read a picture
    if verdict == "half":
        wrong.append("half: " + ", ".join(sorted(contents(place))))
    if code == 0 and verdict != "new" and case.name != "watch":
        wrong.append(f"exit code 0, but {verdict}")
    if code not in (0, 2) and code not in signals:
        wrong.append(f"exit code {code}")
    if code == 2 and not trial.is_one_error_line(err):
        wrong.append("not one line")
    if left and -signal.SIGKILL not in signals:
        wrong.append("left " + ", ".join(left))
    return verdict, [f"{what}: {err[-200:]}" for what in wrong]


def stopped(case, place, chance, number):
    case.put_old(place)
    with tempfile.TemporaryFile() as out:
        process = trial.start(words_of(case.name, place), case.shop, out.fileno(), out.fileno())
        time.sleep(chance.uniform(0, 1.2 * case.seconds))
        os.kill(process, number)
        code, _ = trial.wait(process, LIMIT_S)
    return outcome(case, place, code, "tagcal: \n", (-number,))


def killed(case, place, chance):
    return stopped(case, place, chance, signal.SIGKILL)


def terminated(case, place, chance):
    return stopped(case, place, chance, signal.SIGTERM)


def full_disk(case, place, chance):
    if os.geteuid() != 0 or not shutil.which("mount"):
        return "skipped", []
    size = sum(-(-len(content) // 4096) + 1 for content in (case.old | case.new).values()) * 8192
    if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size + 262144}", "tmpfs", place],
                      capture_output=True).returncode != 0:
        return "skipped", []
    try:
        case.put_old(place)
        space = os.statvfs(place)
        free = space.f_bavail * space.f_frsize
        leave = chance.uniform(0, 1.1 * sum(map(len, case.new.values())) + 8192)
        (place / "filler").write_bytes(b"\0" * max(0, int(free - leave)))
        done = trial.run(words_of(case.name, place), case.shop, LIMIT_S)
        return outcome(case, place, done.code, done.err)
    finally:
        subprocess.run(["umount", place], check=True)


def file_limit(case, place, chance):
    """As `ulimit -f`, with the signal that ends a program by default."""
    case.put_old(place)
    most = int(chance.uniform(0, 1.1 * case.largest))

    def prepare():
        signal.signal(signal.SIGXFSZ, signal.SIG_DFL)
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))

    # Streams are pipes: the limit is for files.
    command = subprocess.Popen([trial.COMMAND, *words_of(case.name, place)], cwd=case.shop,
                               stdout=subprocess.PIPE, stderr=subprocess.PIPE, preexec_fn=prepare)
    _, err = command.communicate(timeout=LIMIT_S)
    return outcome(case, place, command.returncode, err.decode())


def read_only(case, place, chance):
    case.put_old(place)
    for path in [place, *place.rglob("*")]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    as_nobody = (lambda: os.setuid(NOBODY)) if os.geteuid() == 0 else None
    done = trial.run(words_of(case.name, place), case.shop, LIMIT_S, as_nobody)
    verdict, wrong = outcome(case, place, done.code, done.err)
    for path in [place, *place.rglob("*")]:
        path.chmod(0o777)
    return verdict, wrong + ([] if verdict == "old" else [f"{verdict} in a read-only folder"])


def vanished(case, place, chance):
    """The folder gets another name; what is in it then is old or new."""
    case.put_old(place)
    moved = place.with_name(place.name[:-1] + "M")
    with tempfile.TemporaryFile() as out:
        process = trial.start(words_of(case.name, place), case.shop, out.fileno(), out.fileno())
        time.sleep(chance.uniform(0, 1.2 * case.seconds))
        place.rename(moved)
        code, _ = trial.wait(process, LIMIT_S)
        out.seek(0)
        err = out.read().decode(errors="replace")
    # What was begun may stay: its name is not known any more.
    verdict, wrong = outcome(case, moved, 2 if code == 0 else code, err or "tagcal: \n",
                             (-signal.SIGKILL,))
    wrong = [what for what in wrong if code != 0 or not what.startswith("not one line")]
    shutil.rmtree(moved)
    shutil.rmtree(place, ignore_errors=True)
    place.mkdir()
    return verdict, wrong


def twice(case, place, chance):
    """Two processes, with outputs that differ; the folder is new for them in half of the trials."""
    if chance.random() < 0.5:
        case.put_old(place)
    streams, processes = [], []
    for is_other in (False, True):
        streams.append(tempfile.TemporaryFile())
        number = streams[-1].fileno()
        processes.append(trial.start(words_of(case.name, place, is_other), case.shop, number, number))
        time.sleep(chance.choice([0, chance.uniform(0, case.seconds)]))
    wrong, codes = [], []
    for process, stream in zip(processes, streams):
        code, _ = trial.wait(process, LIMIT_S)
        codes.append(code)
        stream.seek(0)
        err = stream.read().decode(errors="replace")
        stream.close()
        if code not in (0, 2) or (code == 2 and not trial.is_one_error_line(err)):
            wrong.append(f"exit code {code}: {err[-200:]}")
    verdict, left = case.verdict(place)
    if verdict not in ("old", "new"):
        wrong.append(f"{verdict}: {sorted(contents(place))}")
    return verdict, wrong + ([f"left {left}"] if left else [])


TROUBLES = {"kill -9": killed, "SIGTERM": terminated, "full disk": full_disk,
            "ulimit -f": file_limit, "read-only": read_only, "folder vanishes": vanished,
            "two processes": twice}


def trials_of(trouble, case, count, seed):
    chance = random.Random(f"{seed} {trouble} {case.name}")
    verdicts, wrong = {}, []
    for _ in range(1 if trouble == "read-only" else count):
        with tempfile.TemporaryDirectory(dir=case.shop) as folder:
            Path(folder).chmod(0o777)
            verdict, mistakes = TROUBLES[trouble](case, Path(folder), chance)
        verdicts[verdict] = verdicts.get(verdict, 0) + 1
        wrong += [f"{trouble}, {case.name}: {mistake}" for mistake in mistakes]
    return verdicts, wrong


def table(results):
    """Sums of verdicts, by trouble or by trouble and command."""
    columns = ["old", "new", "files", "half", "skipped"]
    sums = {}
    for key, verdicts in results:
        row = sums.setdefault(key, dict.fromkeys(columns, 0))
        for verdict, count in verdicts.items():
            row[verdict] += count
    head = ["trouble", "command"][:len(next(iter(sums)))]
    lines = [head + columns, ["---"] * (len(head) + len(columns))]
    lines += [[*key, *map(str, row.values())] for key, row in sums.items()]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--trials", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--only", default="")
    parser.add_argument("--details", action="store_true")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        shop = trial.workshop(temporary)
        shop.chmod(0o755)
        (shop / "set2").symlink_to("set")
        shutil.copy(shop / "set/images/001.png", shop / "more.png")
        cases = [Case(name, shop) for name in COMMANDS]
        pairs = [(trouble, case) for trouble in TROUBLES for case in cases
                 if arguments.only in (trouble, case.name, "")]
        if not arguments.trials:
            pairs = pairs[::3]
        with ThreadPoolExecutor(2) as pool:
            results = list(pool.map(
                lambda pair: trials_of(*pair, max(1, arguments.trials), arguments.seed), pairs))
    wrong = [mistake for _, mistakes in results for mistake in mistakes]
    print(table([((trouble, case.name) if arguments.details else (trouble,), verdicts)
                 for (trouble, case), (verdicts, _) in zip(pairs, results)]))
    print("\n".join([*wrong, f"{len(wrong)} mistakes"]))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
