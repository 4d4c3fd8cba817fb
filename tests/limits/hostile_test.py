"""Hostile small files through every command that reads their kind.

hostile_test.py          each file through one command (in the suite)
hostile_test.py --all    every file through every command; prints the table of
                         docs/reference/limits.md
"""

import re
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pictures
import texts
import trial

MOST_CPU_S = 1.0
MOST_CPU_S_PER_MEGAPIXEL = 0.5  # of a whole picture of one colour; usual ones take 0.1 to 1 s
MOST_MB = 100.0  # above a run without work

COMMANDS = {
    "scene": ["view {file}", "render {file} --out {out} --force --threads 1"],
    "target": ["detect --target {file} nothing.png", "board {file} --out {out}.svg",
               "board {file} --out {out}.pdf --paper a4", "board {file} --out {out}.png --dpi 5",
               "detect --target {file} photo.png", "calibrate --target {file} photo.png",
               "pose --target {file} photo.png --camera camera.yaml",
               "convert corners.csv {out}.vnl --target {file}", "watch empty --target {file} --timeout 0.01",
               "report camera.yaml --target {file} photo.png --out {out}.html",
               "reproject --camera camera.yaml photo.png --plane --target {file} --out {out} --force"],
    "camera": ["convert {file} {out}.yaml --to opencv", "view {file}", "diff {file} {file}", "diff {file} camera.yaml",
               "convert {file} {out}.yaml --to tagcal --model radial2", "validate {file} --dataset set",
               "report {file} --out {out}.html", "report {file} camera.yaml --out {out}.html",
               "pose set --camera {file}", "detect set --camera {file}", "calibrate set --start {file}",
               "reproject photo.png --camera {file} --undistort all --out {out} --force",
               "reproject photo.png --camera camera.yaml --to-camera {file} --out {out} --force",
               "project points.csv --camera {file}", "unproject pixels.csv --camera {file}"],
    "table": ["calibrate set --observations {file}", "pose set --camera camera.yaml --observations {file}",
              "project {file} --camera camera.yaml", "unproject {file} --camera camera.yaml",
              "convert {file} {out}.csv --target target.yaml", "detect --target target.yaml @{file}",
              "report {file} --camera camera.yaml --out {out}.html", "view {file}",
              "convert camera.yaml {out}.json --to nerfstudio --poses {file}",
              "validate camera.yaml --dataset set --observations {file}"],
    "picture": ["detect --target target.yaml --strict {file}", "calibrate --target target.yaml {file}",
                "pose --target target.yaml --camera camera.yaml {file}", "detect --family tag36h11 {file}",
                "reproject {file} --camera camera.yaml --undistort all --out {out} --force",
                "report camera.yaml --target target.yaml {file} --out {out}.html"],
}

# What is asked here is much work: drawing 48,000 tags, the table of a family with so many codes (140
# MB in AprilTag), a checkerboard of 12 m, resampling through a lens that bends a ray by 1e308.
ASKED = ("most-52h13", "most-corners", "most-squares", "coefficients-")


def write_files(folder):
    """Writes the files; returns kind -> paths."""
    paths = {kind: [] for kind in COMMANDS}

    def write(kinds, name, content):
        path = folder / f"{kinds[0]}-{name}"
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        for kind in kinds:
            paths[kind].append(path)

    for kind, files in (("scene", texts.scenes()), ("target", texts.targets()),
                        ("camera", texts.cameras()), ("table", texts.tables())):
        for name, text in files.items():
            write([kind], name if "." in name else f"{name}.yaml", text)
    for name, text in texts.any_yaml().items():
        write(["scene", "target", "camera", "table"], f"any-{name}.yaml", text)
    for name, content in pictures.hostile().items():
        write(["picture"], name, content)
    return paths


def jobs(paths, every):
    for kind, files in paths.items():
        for i, file in enumerate(files):
            commands = COMMANDS[kind] if every else [COMMANDS[kind][i % len(COMMANDS[kind])]]
            for command in commands:
                yield kind, command, file


def words_of(command, file, out):
    return [word.format(file=file, out=out) for word in command.split()]


def most_cpu_s(file):
    size = re.search(r"solid-(\d+)x(\d+)\.", file.name)
    pixels = int(size[1]) * int(size[2]) if size else 0
    return max(MOST_CPU_S, MOST_CPU_S_PER_MEGAPIXEL * min(pixels, 4e6) / 1e6)


def mistakes(done, command, file, idle_mb):
    found = []
    if done.code not in (0, 1, 2, 3):
        found.append(f"exit code {done.code}")
    if done.code == 2 and not trial.is_one_error_line(done.err):
        found.append("not one line")
    is_asked = any(name in file.name for name in ASKED) and not command.endswith("nothing.png")
    if trial.IS_MEASURED and not is_asked:
        if done.cpu_s > most_cpu_s(file):
            found.append(f"{done.cpu_s:.2f} s")
        if done.peak_mb - idle_mb > MOST_MB:
            found.append(f"{done.peak_mb - idle_mb:.0f} MB")
    return found


def main(every):
    with tempfile.TemporaryDirectory() as temporary:
        folder = trial.workshop(temporary)
        (folder / "empty").mkdir()
        idle_mb = trial.run(["--version"], folder).peak_mb
        all_jobs = list(jobs(write_files(folder), every))

        def work(numbered):
            number, (kind, command, file) = numbered
            done = trial.run(words_of(command, file, folder / f"out{number}"), folder)
            for again in range(2):  # processor time grows where other programs share the caches
                if done.cpu_s > most_cpu_s(file):
                    more = trial.run(words_of(command, file, folder / f"out{number}-{again}"), folder)
                    done = min(done, more, key=lambda run: run.cpu_s)
            return kind, command, file, done

        with ThreadPoolExecutor(2) as pool:
            results = list(pool.map(work, enumerate(all_jobs)))
    bad = 0
    print("| kind | files | runs | most CPU, s | most memory, MB |\n|---|---|---|---|---|")
    for kind in COMMANDS:
        of_kind = [r for r in results if r[0] == kind]
        plain = [r for r in of_kind if not any(name in r[2].name for name in ASKED)]
        print(f"| {kind} | {len({r[2] for r in of_kind})} | {len(of_kind)} "
              f"| {max(r[3].cpu_s for r in plain):.2f} "
              f"| {max(r[3].peak_mb for r in plain) - idle_mb:.0f} |")
    for _, command, file, done in results:
        for what in mistakes(done, command, file, idle_mb):
            bad += 1
            print(f"{what}: tagcal {command.format(file=file.name, out='OUT')}\n  {done.err[-300:]}")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main("--all" in sys.argv[1:]))
