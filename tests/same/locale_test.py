"""Decimal commas: the command gives the same bytes under LC_ALL=de_DE.UTF-8 as under C, and reads
what it wrote there. The locale is made by localedef, so it need not be installed.

locale_test.py
"""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import threads_test

COMMANDS = [command for command in threads_test.COMMANDS if "squares" not in command and "charuco" not in command
            and "reproject" not in command] + [
    f"convert tags.camera.yaml {out} --to {name}" for name, out in (
        ("tagcal", "copy.yaml"), ("opencv", "opencv.yaml"), ("kalibr", "kalibr.yaml"), ("ros", "ros.yaml"),
        ("colmap", "colmap"), ("mrcal", "of.cameramodel"), ("nerfstudio", "nerf.json"))] + [
    "convert opencv.yaml again.yaml --to tagcal",
    "convert nerf.json nerf.yaml --to tagcal",
    "convert of.cameramodel mrcal.yaml --to tagcal",
    "convert colmap colmap.yaml --to tagcal",
    "board tags/target.yaml --out board.pdf",
    "board tags/target.yaml --out board.svg",
    "view tags.camera.yaml --opengl",
    "diff tags.camera.yaml again.yaml --distance 1.5",
    "validate tags.camera.yaml --dataset tags --observations tags.csv",
    "reproject tags/images/000.png --camera tags.camera.yaml --undistort 512.5 --rotate 1.5,-2.5,0 --out turned",
    "calibrate tags --observations tags.csv --model radial1 --fix k1=-0.125,f=520.5 --sigma-px 0.25 --json",
    "detect tags --no-cache --refinement edges",
]


def main():
    if not shutil.which("localedef"):
        print("skipped: localedef is missing (package libc-bin)")
        return 77
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        made = subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", folder / "de_DE.UTF-8"],
                              capture_output=True, text=True)
        german = {"LC_ALL": "de_DE.UTF-8", "LANG": "de_DE.UTF-8", "LOCPATH": str(folder)}
        printed = subprocess.run(["printf", "%.1f", "1,5"], env=german, capture_output=True, text=True)
        if printed.stdout != "1,5":  # the locale is not in force
            print(f"skipped: localedef cannot make de_DE.UTF-8 (package locales): {made.stderr.strip()}")
            return 77
        threads_test.COMMANDS[:] = COMMANDS
        one = threads_test.outcome(folder / "c", 1, {"LC_ALL": "C"})
        other = threads_test.outcome(folder / "de", 1, german)
    mistakes = [name for name in sorted(one.keys() | other.keys()) if one.get(name) != other.get(name)]
    print(f"{len(COMMANDS)} commands, {len(one)} outputs")
    print("\n".join(f"{name}: not as under LC_ALL=C" for name in mistakes))
    return 1 if mistakes else 0


if __name__ == "__main__":
    sys.exit(main())
