"""Good files of all kinds with some bytes changed, through the commands that read them: a documented
exit code, one line if they are refused, no time without end.

mutated_test.py                         a few hundred (in the suite)
mutated_test.py --trials N --seed S     more; files that broke something are kept in build/mutated
"""

import argparse
import random
import re
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import hostile_test
import trial

SOURCE = Path(__file__).resolve().parents[2]
CORPUS = SOURCE / "tests/fuzz/corpus"
KEPT = SOURCE / "build/mutated"
# A changed number may ask for much work: more pictures, larger ones, a board of more tags. A
# sanitizer makes it 20 to 50 times slower.
LIMIT_S = 60 if trial.IS_MEASURED else 300

COMMANDS = {**hostile_test.COMMANDS, "dataset": ["calibrate {file}", "detect {file}", "view {file}",
                                                 "validate camera.yaml --dataset {file}",
                                                 "pose {file} --camera camera.yaml"]}
FORMATS = ("opencv", "kalibr", "ros", "mrcal", "basalt", "nerfstudio", "colmap", "tagcal")
TOKENS = [b"nan", b".inf", b"-1", b"0", b"1e308", b"4294967296", b"99999999999999999999", b"\0", b"[", b"]", b"{",
          b"}", b": ", b"- ", b'"', b"'", b"&a ", b"*a", b"#", b"\n", b",", b"\xff\xfe", b"\xc3(", b"%s%n", b"\r",
          b"!!binary ", b"../", b"|\n"]


def seeds(folder):
    """Kind -> good files."""
    found = {kind: [] for kind in COMMANDS}
    for kind, name in (("scene", "scene"), ("target", "target"), ("camera", "camera"), ("table", "corners"),
                       ("picture", "picture")):
        found[kind] += [p for p in sorted((CORPUS / name).iterdir()) if p.stat().st_size < 200_000]
    found["scene"].append(folder / "scene.yaml")
    found["target"].append(folder / "target.yaml")
    found["camera"] += [folder / "camera.yaml", folder / "set/truth.yaml"]
    found["table"] += [folder / "corners.csv", folder / "poses.json", folder / "points.csv", folder / "pixels.csv"]
    found["picture"].append(folder / "photo.png")
    found["dataset"] += [p for p in sorted((CORPUS / "dataset").iterdir())] + [folder / "set/dataset.yaml"] * 3
    for name in FORMATS:
        out = folder / f"camera.{name}"
        trial.run(["convert", "camera.yaml", out, "--to", name], folder)
        found["camera"] += [out] if out.is_file() else sorted(out.glob("*.txt"))
    return found


def changed_number(data, rng):
    numbers = list(re.finditer(rb"-?\d+\.?\d*", data))
    if not numbers:
        return data
    at = rng.choice(numbers)
    value = rng.choice([b"0", b"-1", b"1e9", b"2147483648", b".nan", b"-" + at[0], at[0] + b"0", at[0] + b"e5", b"0.5"])
    return data[:at.start()] + value + data[at.end():]


def mutated(data, rng):
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        at, to = sorted(rng.randrange(len(data) + 1) for _ in range(2))
        to = min(to, at + rng.choice((1, 4, 30, len(data))))
        data = rng.choice((
            lambda: data[:at] + bytes([rng.randrange(256)]) + data[at + 1:],
            lambda: data[:at] + rng.choice(TOKENS) + data[at:],
            lambda: data[:at] + data[to:],
            lambda: data[:to] + data[at:to] + data[to:],
            lambda: data[:at],
            lambda: changed_number(data, rng),
            lambda: data[:at] + bytes(b ^ 1 << rng.randrange(8) for b in data[at:at + 1]) + data[at + 1:],
        ))()
        data = data or b" "
    return data


def placed(kind, content, place, seed, folder):
    """The changed file, where its command finds it; of a data set the folder."""
    if kind == "dataset":
        for file in (folder / "set").iterdir():
            if file.name != "dataset.yaml":
                (place / file.name).symlink_to(file)
        (place / "dataset.yaml").write_bytes(content)
        return place
    file = place / seed.name
    file.write_bytes(content)
    return file


def outcome(number, seed_number, folder, found):
    """What was wrong with one trial ("": nothing), and a copy of the file that did it."""
    rng = random.Random(f"{seed_number} {number}")
    kind = rng.choice(sorted(COMMANDS))
    seed, command = rng.choice(found[kind]), rng.choice(COMMANDS[kind])
    content = mutated(seed.read_bytes(), rng)
    with tempfile.TemporaryDirectory(dir=folder) as temporary:
        place = Path(temporary)
        (place / "in").mkdir()
        file = placed(kind, content, place / "in", seed, folder)
        done = trial.run(hostile_test.words_of(command, file, place / "out"), folder, LIMIT_S)
    wrong = ""
    if done.code not in (0, 1, 2, 3):
        wrong = f"exit code {done.code}"
    elif done.code == 2 and not trial.is_one_error_line(done.err):
        wrong = "not one line"
    if not wrong:
        return kind, ""
    KEPT.mkdir(parents=True, exist_ok=True)
    (KEPT / f"{seed_number}-{number}-{seed.name}").write_bytes(content)
    return kind, f"{seed_number}-{number}-{seed.name}: {wrong}: tagcal {command}\n{done.err[-1500:]}"


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--trials", type=int, default=300)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=2)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder = trial.workshop(temporary)
        (folder / "empty").mkdir()
        found = seeds(folder)
        numbers = range(options.first, options.first + options.trials)
        with ThreadPoolExecutor(options.jobs) as pool:
            done = list(pool.map(lambda n: outcome(n, options.seed, folder, found), numbers))
    wrong = [what for _, what in done if what]
    print("\n".join(wrong))
    counts = ", ".join(f"{sum(k == kind for k, _ in done)} {kind}" for kind in sorted(COMMANDS))
    print(f"{len(done)} runs ({counts}), {sum(map(len, found.values()))} good files: {len(wrong)} mistakes")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
