"""The same answers on other processors: every kernel of tagcal and of the libraries below it that
this processor offers is forced, and all answers are compared with those of the default.

processors_test.py        prints the largest differences; exit code 1 beyond TOLERANCES
processors_test.py --all  also with each of the libraries by itself
"""

import os
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import answers

COMMAND = str(Path(os.environ.get("TAGCAL_COMMAND", "build/release/tools/tagcal")).resolve())
OWN = {"TAGCAL_PROCESSOR": "any"}  # internal/processor.hpp
MATHS = {"GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX512F,-AVX2,-FMA,-FMA4,-AVX"}  # sin, atan2, exp, ..
NO_AVX512 = {"OPENCV_CPU_DISABLE": "AVX512-SKX"}
NO_AVX = {"OPENCV_CPU_DISABLE": "AVX512-SKX,AVX2,FMA3,FP16,AVX"}
PATHS = {
    "default": {},
    "tagcal without AVX2": OWN,
    "OpenCV without AVX-512, glibc without AVX2": {**NO_AVX512, **MATHS},
    "none of them": {**OWN, **MATHS, **NO_AVX},
}
EACH = {"OpenCV without AVX-512": NO_AVX512, "OpenCV without AVX": NO_AVX, "glibc without FMA, AVX2, AVX-512": MATHS}


def main():
    flags = Path("/proc/cpuinfo").read_text(errors="replace") if Path("/proc/cpuinfo").exists() else ""
    if " avx2 " not in flags:
        print("skipped: this processor has no AVX2, so there is one path")
        return 77
    paths = PATHS | EACH if "--all" in sys.argv[1:] else PATHS
    beyond = []
    with tempfile.TemporaryDirectory() as temporary:
        folder = Path(temporary)
        usual = answers.Program("default", COMMAND)
        answers.make_inputs(usual, folder)
        with ThreadPoolExecutor(2) as pool:
            found = list(pool.map(lambda path: answers.answers(
                answers.Program(path, COMMAND, paths[path]), folder, folder / path), paths))
    print(answers.table_head("path"))
    for path, of_path in zip(paths, found):
        difference = answers.compare(found[0], of_path)
        if paths[path].get("TAGCAL_PROCESSOR") and not any(value for value, _ in difference.largest.values()):
            beyond.append(f"{path}: not one byte differs, so it was not forced")
        print(answers.table_row(path, difference))
        beyond += [f"{path}: {line}" for line in difference.beyond()]
    print("\n".join(beyond))
    return 1 if beyond else 0


if __name__ == "__main__":
    sys.exit(main())
