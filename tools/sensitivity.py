"""What changes if a constant of policy.hpp is another: each times 0.7 and 1.4, one at a time.

A copy of the sources is built in build/sensitivity, whose policy headers read a factor from the
environment. The studies run once as they are and once for each constant and factor:
  corners  random worlds from corners        answers  corners found in pictures (detect_answers)
  halves   halves of the real sets in tests  maps     maps of where poses and calibrations fail
Printed are, of the first and the last two, the shares of their rows (worlds, halves; in maps the
trials of a cell) whose text changes, or a number by more than 1 %; of `answers` what becomes of the
corners: right ones (%), wrong ones, the error of the right ones and its square over the claimed one
(%, geometric means over the pictures), and those beyond five claimed standard deviations.
build/sensitivity/results.tsv keeps them: a run that was interrupted is continued, and results of
other sources are not used.
"""

import argparse
import csv
import hashlib
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
WORK = ROOT / "build" / "sensitivity"
TREE = WORK / "tree"
POLICIES = {"estimate": "lib/tagcal/estimate/policy/policy.hpp",
            "uncertainty": "lib/tagcal/uncertainty/policy/policy.hpp",
            "detect": "lib/tagcal/detect/policy/policy.hpp"}
FACTORS = (0.7, 1.4)
MAPS = ("tag-tilt-distance flatness line points near-camera wrong-corners swapped focal-tilt-noise "
        "focal-distance calibrate-views-tilt calibrate-parallel calibrate-repeated "
        "calibrate-extrapolation calibrate-wrong-views").split()
SETS = "bouguet_left bouguet_right opencv_left visp_circles euroc_cam0".split()
TIMES = ("render_s", "detect_s", "calibrate_s", "own_s", "time_us")
STUDIES = {"estimate": ("corners", "halves", "maps"), "uncertainty": ("corners", "halves", "maps"),
           "detect": ("answers",)}

READER_NAME = "tagcal/internal/policy_factor.hpp"
READER = """#pragma once
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <string_view>
namespace tagcal::internal::policy {
inline double factor_of(std::string_view name) {
  const char* const varied = std::getenv("TAGCAL_CONSTANT");
  return varied && name == varied ? std::atof(std::getenv("TAGCAL_FACTOR")) : 1;
}
inline double scaled(double value, double by) { return value * by; }
inline int scaled(int value, double by) { return static_cast<int>(std::lround(value * by)); }
inline std::size_t scaled(std::size_t value, double by) {
  return static_cast<std::size_t>(std::lround(static_cast<double>(value) * by));
}
inline unsigned scaled(unsigned value, double by) {
  return static_cast<unsigned>(std::lround(value * by));
}
}  // namespace tagcal::internal::policy
"""
SCALAR = re.compile(r"inline constexpr (double|int|unsigned|std::size_t) (k\w+) = ([^;]+);")
LIST = re.compile(r"inline constexpr (double|int|std::array<(?:double|int), \d+>) (k\w+)((?:\[\d*\])?)"
                  r" = \{([^}]+)\};")
SHARE = re.compile(r"inline constexpr Share (k\w+)\{(\d+), (\d+)\};")


def constants(layer):
  text = (ROOT / POLICIES[layer]).read_text()
  found = [(m.start(), m[1] if p is SHARE else m[2]) for p in (SCALAR, LIST, SHARE)
           for m in p.finditer(text)]
  return [name for _, name in sorted(found)]


def variable(text):
  def elements(match):
    number = "double" if "double" in match[1] else "int"
    values = ", ".join(f'scaled({number}{{{v.strip()}}}, factor_of("{match[2]}"))'
                       for v in match[4].split(","))
    return f"inline const {match[1]} {match[2]}{match[3]} = {{{values}}};"

  text = SCALAR.sub(r'inline const \1 \2 = scaled(\1{\3}, factor_of("\2"));', text)
  text = LIST.sub(elements, text)
  text = SHARE.sub(r'inline const Share \1{scaled(100 * \2, factor_of("\1")), 100 * \3};', text)
  return text.replace("#include <cstddef>\n", f'#include "{READER_NAME}"\n', 1)


def prepare():
  """Copies the sources, with variable policies; says which sources they are."""
  digest = hashlib.sha256()
  listed = subprocess.run(["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
                          cwd=ROOT, capture_output=True, text=True, check=True).stdout
  names = {name for name in listed.split("\0") if name and (ROOT / name).is_file()}
  for path in (TREE / "lib").rglob("*.?pp"):
    if str(path.relative_to(TREE)) not in names | {f"lib/{READER_NAME}"}:
      path.unlink()  # of an earlier version
  write(TREE / "lib" / READER_NAME, READER.encode())
  for name in sorted(names):
    text = (ROOT / name).read_bytes()
    if name.startswith(("lib/", "tools/studies/")):
      digest.update(name.encode() + text)
    if name in POLICIES.values():
      text = variable(text.decode()).encode()
    elif name.endswith(("pp", ".h")) and b"policy::k" in text:
      text = re.sub(rb"constexpr (?=[^\n;(){]*policy::k)", b"const ", text)
    write(TREE / name, text)
  return digest.hexdigest()[:16]


def write(path, text):
  if not path.is_file() or path.read_bytes() != text:
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(text)


def build(jobs):
  folder = TREE / "build"
  for command in (["cmake", "-S", TREE, "-B", folder, "-G", "Ninja", "-D",
                   "CMAKE_BUILD_TYPE=Release"],
                  ["cmake", "--build", folder, "-j", str(jobs), "--target",
                   "tagcal-study"]):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if done.returncode != 0:
      sys.exit(f"sensitivity.py: {' '.join(map(str, command))} failed:\n{done.stdout[-3000:]}")
  return folder


def rows_of(study, programs, sets, constant=None, factor=1):
  """The rows of a study as dictionaries of texts, without times; None if it fails with the
  constant."""
  out = WORK / "run"
  shutil.rmtree(out, ignore_errors=True)
  out.mkdir(parents=True)
  program = programs / "tools/tagcal-study"
  command = {
      "corners": [program, "worlds", "run", "--seed", "31", "--threads", "1", "--count", "200",
                  "--corners-only", "--out", out / "worlds.csv"],
      "answers": [program, "detect_answers", "--csv", out / "answers.csv", "--pictures",
                  WORK / "pictures", *sets],
      "halves": [program, "halves", "--count", "4", "--csv", out / "halves.csv",
                 *(ROOT / "tests/data/real_corners" / s for s in SETS)],
      "maps": [program, "stability", "--ours", "--trials", "5", "--seed",
               "9", "--threads", "1", "--out", out, *MAPS],
  }[study]
  environment = dict(os.environ)
  if constant:
    environment |= {"TAGCAL_CONSTANT": constant, "TAGCAL_FACTOR": str(factor)}
  done = subprocess.run(command, env=environment, stdout=subprocess.DEVNULL,
                        stderr=subprocess.PIPE, text=True)
  if done.returncode != 0 and not constant:
    sys.exit(f"sensitivity.py: {study} failed: {done.stderr[-500:]}")
  if done.returncode != 0:
    return None
  rows = []
  for path in sorted(out.glob("*.csv")):
    with path.open() as file:
      for row in csv.DictReader(line for line in file if not line.startswith("#")):
        rows.append({k: v for k, v in row.items() if k not in TIMES})
  return rows


def differs(a, b):
  if a == b:
    return False
  try:
    x, y = float(a), float(b)
  except ValueError:
    return re.sub(r"[-\d.e+]+", "#", a) != re.sub(r"[-\d.e+]+", "#", b)
  return not abs(x - y) <= 0.01 * max(abs(x), abs(y), 1e-6)


def changed(before, after):
  """Percentage of the rows that differ; no number if the study failed."""
  if after is None:
    return "failed"
  if len(before) != len(after):
    return "100.0"
  count = sum(any(differs(x, y) for x, y in zip(a.values(), b.values()))
              for a, b in zip(before, after))
  return f"{100 * count / len(before):.1f}"


def changed_answers(before, after):
  """What becomes of the corners that are found."""
  if after is None:
    return "failed"
  rows = [[{k: float(v) for k, v in row.items() if k not in ("task", "trial", "picture")} for row in of]
          for of in (before, after)]
  right, wrong, beyond = ([sum(f(row) for row in of) for of in rows] for f in (
      lambda row: row["found"] - row["wrong"], lambda row: row["wrong"], lambda row: row["beyond"]))

  def growth(square, count):
    ratios = [math.log(b[square] / count(b) / (a[square] / count(a))) for a, b in zip(*rows)
              if min(a[square], b[square]) > 1e-9 and min(count(a), count(b)) > 0]
    return math.exp(sum(ratios) / max(1, len(ratios)))

  error = math.sqrt(growth("squares", lambda row: row["found"] - row["wrong"]))
  claim = growth("distances", lambda row: row["claimed"])
  return (f"{100 * (right[1] / max(1, right[0]) - 1):+.2f} | {wrong[1] - wrong[0]:+.0f} | "
          f"{100 * (error - 1):+.2f} | {100 * (claim - 1):+.2f} | {beyond[1] - beyond[0]:+.0f}")


HEADS = {"answers": ("right, %", "wrong", "error, %", "square over claim, %", "beyond 5 sd")}


def main():
  parser = argparse.ArgumentParser(description=__doc__,
                                   formatter_class=argparse.RawDescriptionHelpFormatter)
  parser.add_argument("layer", choices=POLICIES)
  parser.add_argument("constants", nargs="*", help="default: all of the layer")
  parser.add_argument("--jobs", type=int, default=2, help="of the build")
  parser.add_argument("--sets", nargs="*", default=(), type=lambda s: pathlib.Path(s).resolve(),
                      help="folders of real pictures with a target.yaml, for `answers`")
  options = parser.parse_args()
  known = constants(options.layer)
  if unknown := set(options.constants) - set(known):
    sys.exit(f"sensitivity.py: {', '.join(sorted(unknown))}: no constant of {options.layer}")
  sources = prepare()
  programs = build(options.jobs)
  results = WORK / "results.tsv"
  done = {}
  if results.is_file():
    for line in results.read_text().splitlines():
      digest, name, factor, study, share = line.split("\t")
      if digest == sources:
        done[name, float(factor), study] = share
  studies = STUDIES[options.layer]
  before = {}
  heads = [head for s in studies for head in HEADS.get(s, (f"{s}, %",))]
  print("| constant | factor | " + " | ".join(heads) + " |")
  print("|---|" + "--:|" * (1 + len(heads)))
  for name in options.constants or known:
    for factor in FACTORS:
      for study in studies:
        if (name, factor, study) in done:
          continue
        if study not in before:
          before[study] = rows_of(study, programs, options.sets)
        after = rows_of(study, programs, options.sets, name, factor)
        share = (changed_answers if study == "answers" else changed)(before[study], after)
        done[name, factor, study] = share
        with results.open("a") as file:
          file.write(f"{sources}\t{name}\t{factor}\t{study}\t{share}\n")
      shares = " | ".join(done[name, factor, s] for s in studies)
      print(f"| {name} | {factor} | {shares} |", flush=True)


if __name__ == "__main__":
  main()
