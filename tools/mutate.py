"""Plants deliberate mistakes into a copy of the sources, one at a time, and runs the tests.

A mistake that no test notices has SURVIVED: a test is missing. tests/mutations.txt is the list.
The copy is build/mutate/tree, a clone at the commit of this checkout: what is not committed is not
in it. build/mutate/results.tsv keeps the verdicts; a mistake that was judged at this commit with
the same text is not judged again.
"""

import argparse
import collections
import os
import pathlib
import re
import subprocess
import sys
import time

from mutation_list import check, read_list

ROOT = pathlib.Path(__file__).resolve().parent.parent
LIST = ROOT / "tests" / "mutations.txt"
WORK = ROOT / "build" / "mutate"
TREE = WORK / "tree"
RESULTS = WORK / "results.tsv"
BUILD = TREE / "build" / "release"
# Folders of tests/ in which the tests of a layer stand, where their names differ.
FOLDERS = {"tools": ("cli",), "validate": ("study",)}
LEAST_SHARE = 0.95
# The first is red with any mistake, as the list then does not apply; the others test packages.
NOT_RUN = ("mutations_test", "consumer_test", "python_test_package")
TEST_SECONDS = 120  # an endless loop counts as noticed
SLOW_SECONDS = 0.7  # of a test that runs after the others

SURVIVED, NOT_BY_LAYER = "SURVIVED", "not noticed by its layer"

Verdict = collections.namedtuple("Verdict", "id digest commit verdict test seconds")

# One shared library: a mistake is compiled and linked once, not into every program again. Without
# the macro that CMake defines for it, the compiler's cache also serves the other builds.
SHARED = """set(BUILD_SHARED_LIBS ON)
set(CMAKE_LINK_DEPENDS_NO_SHARED ON)
string(APPEND CMAKE_EXE_LINKER_FLAGS " -Wl,--copy-dt-needed-entries")  # tests use libpng too
cmake_language(DEFER CALL set_target_properties tagcal tagcal_validate PROPERTIES DEFINE_SYMBOL "")
cmake_language(DEFER CALL set_target_properties tagcal_study PROPERTIES DEFINE_SYMBOL "")
"""


def run(command, **options):
  return subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                        errors="replace", **options)


def must(command, **options):
  done = run(command, **options)
  if done.returncode != 0:
    sys.exit(f"mutate.sh: {' '.join(map(str, command))} failed:\n{done.stdout[-3000:]}")
  return done.stdout


def build(jobs):
  return run(["cmake", "--build", BUILD, "--parallel", str(jobs)])


def prepare(commit, jobs):
  """Brings the copy to the commit and builds it."""
  WORK.mkdir(parents=True, exist_ok=True)
  if not TREE.exists():
    must(["git", "clone", "--quiet", "--shared", "--no-checkout", ROOT, TREE])
  must(["git", "checkout", "--quiet", "--force", "--detach", commit], cwd=TREE)
  shared = WORK / "shared.cmake"
  if not shared.exists() or shared.read_text() != SHARED:
    shared.write_text(SHARED)
  must(["cmake", "--preset", "release", f"-DCMAKE_PROJECT_tagcal_INCLUDE={shared}",
        "-DTAGCAL_BUILD_PYTHON=ON", "-DPython_EXECUTABLE=/usr/bin/python3"], cwd=TREE)
  built = build(jobs)
  if built.returncode != 0:
    sys.exit(f"mutate.sh: the sources do not build:\n{built.stdout[-3000:]}")


class Tests:
  """The tests of the copy; which are slow is measured without a mistake."""

  def __init__(self, commit, jobs):
    self.jobs = jobs
    known = WORK / f"tests-{commit}.txt"
    if not known.exists():
      print("the tests without a mistake", flush=True)
      failed, output = self._ctest(["-E", f"^({'|'.join(NOT_RUN)})$"])
      if failed:
        sys.exit(f"mutate.sh: fails without a mistake: {failed}\n{output[-3000:]}")
      times = re.findall(r"Test +#\d+: (\S+) .*Passed +([\d.]+) sec", output)
      known.write_text("".join(f"{name} {seconds}\n" for name, seconds in times))
    self.seconds = {name: float(seconds) for name, seconds in
                    (line.split() for line in known.read_text().splitlines())}

  def _ctest(self, choice):
    done = run(["ctest", "--test-dir", BUILD, "--parallel", str(self.jobs), "--timeout",
                str(TEST_SECONDS), "--stop-on-failure", *choice])
    failed = re.findall(r"Test +#\d+: (\S+) \.*\**(?:Failed|Timeout|Exception|Not Run|Subprocess)",
                        done.stdout)
    if done.returncode != 0 and not failed:
      sys.exit(f"mutate.sh: ctest:\n{done.stdout[-3000:]}")
    return (failed[0] if failed else None), done.stdout

  def _of_layer(self, layer):
    if layer == "python":
      return {name for name in self.seconds if name.startswith("python_")}
    folders = FOLDERS.get(layer, (layer,))
    return {path.stem for folder in folders for path in (TREE / "tests" / folder).glob("*_test.cpp")}

  def first_failure(self, mistake, layer_only):
    """The name of a test that notices the mistake, or None."""
    names = set(self.seconds)
    own = ({mistake.test} if mistake.test else set()) & names
    layer = self._of_layer(mistake.layer) & names
    quick = {name for name in names if self.seconds[name] < SLOW_SECONDS}
    stages = (own, layer & quick, layer) + (() if layer_only else (quick, names))
    done = set()
    for stage in stages:
      names_now = sorted(stage - done)
      if names_now:
        failed, _ = self._ctest(["-R", f"^({'|'.join(names_now)})$"])
        if failed:
          return failed
      done |= stage
    return None


def judge(mistake, tests, options):
  """Plants the mistake, builds, tests and takes it out again."""
  path = TREE / mistake.file
  right = path.read_text()
  try:
    path.write_text(right.replace(mistake.line, mistake["with"]))
    built = build(options.jobs)
    (WORK / f"{mistake.id}.log").write_text(built.stdout)
    if built.returncode != 0:
      return "does not build", "-"
    test = tests.first_failure(mistake, options.layer_only)
    if test:
      return "noticed", test
    return (NOT_BY_LAYER if options.layer_only else SURVIVED), "-"
  finally:
    path.write_text(right)


def read_results():
  if not RESULTS.exists():
    return []
  return [Verdict(*line.split("\t")) for line in RESULTS.read_text().splitlines()]


def last_results(mistakes):
  """The last verdict on each entry with the text of today."""
  digests = {mistake.id: mistake.digest for mistake in mistakes}
  return {v.id: v for v in read_results() if digests.get(v.id) == v.digest}


JUDGED = ("noticed", SURVIVED)


def print_shares(title, mistakes, results, key):
  print(f"\n{title:<24} planted  noticed")
  groups = collections.defaultdict(list)
  for mistake in mistakes:
    if mistake.id in results:
      groups[mistake[key]].append(results[mistake.id].verdict == "noticed")
  for name, noticed in sorted(groups.items()):
    print(f"{name:<24} {len(noticed):7}  {sum(noticed):7}")


def print_table(mistakes):
  """Returns the share of the mistakes that were noticed."""
  results = {name: v for name, v in last_results(mistakes).items() if v.verdict in JUDGED}
  print_shares("layer", mistakes, results, "layer")
  print_shares("kind", mistakes, results, "kind")
  noticed = sum(v.verdict == "noticed" for v in results.values())
  share = noticed / max(1, len(results))
  seconds = sum(float(v.seconds) for v in results.values()) / max(1, len(results))
  print(f"\n{noticed} of {len(results)} mistakes noticed ({100 * share:.1f} %), "
        f"{len(mistakes) - len(results)} not judged, {seconds:.0f} s each")
  for mistake in mistakes:
    verdict = results.get(mistake.id)
    if verdict and verdict.verdict != "noticed":
      reason = f"equivalent: {mistake.equivalent}" if mistake.equivalent else mistake.why
      print(f"SURVIVED {mistake.id} ({mistake.file}): {reason}")
  return share


def wanted(mistakes, options, commit):
  results = last_results(mistakes)
  unknown = set(options.ids) - {mistake.id for mistake in mistakes}
  if unknown:
    sys.exit(f"mutate.sh: {', '.join(sorted(unknown))}: not in {LIST}")

  def is_wanted(mistake):
    if options.ids:
      return mistake.id in options.ids
    last = results.get(mistake.id)
    if options.survivors:
      return last is not None and last.verdict != "noticed"
    if last is None or options.new:
      return last is None
    return last.commit != commit or (last.verdict == NOT_BY_LAYER and not options.layer_only)

  return one_of_each_layer([mistake for mistake in mistakes if is_wanted(mistake)])


def one_of_each_layer(mistakes):
  """In turns, so that a run that is cut off is a sample of all layers."""
  count, turns = collections.Counter(), []
  for mistake in mistakes:
    turns.append((count[mistake.layer], len(turns), mistake))
    count[mistake.layer] += 1
  return [mistake for _, _, mistake in sorted(turns, key=lambda turn: turn[:2])]


def judge_all(mistakes, options):
  commit = must(["git", "rev-parse", "HEAD"], cwd=ROOT).strip()
  todo = wanted(mistakes, options, commit)
  if not todo:
    return
  end = time.time() + 60 * options.minutes
  prepare(commit, options.jobs)
  tests = Tests(commit, options.jobs)
  for mistake in todo:
    if time.time() > end:
      break
    complaint = mistake.complaint(TREE)
    if complaint:
      sys.exit(f"mutate.sh: {mistake.id}: {complaint}")
    start = time.time()
    verdict, test = judge(mistake, tests, options)
    seconds = time.time() - start
    with RESULTS.open("a") as file:
      values = Verdict(mistake.id, mistake.digest, commit, verdict, test, f"{seconds:.0f}")
      file.write("\t".join(values) + "\n")
    by = f" by {test}" if verdict == "noticed" else ""
    print(f"{mistake.id}: {verdict}{by} ({seconds:.0f} s)", flush=True)


def main():
  parser = argparse.ArgumentParser(prog="mutate.sh", description=__doc__,
                                   formatter_class=argparse.RawDescriptionHelpFormatter)
  parser.add_argument("ids", nargs="*", metavar="ID", help="judge these, also if judged before")
  parser.add_argument("--check", action="store_true",
                      help="only test that each entry of the list applies to the sources")
  parser.add_argument("--table", action="store_true", help="only print the table of the results")
  parser.add_argument("--survivors", action="store_true", help="judge those that survived again")
  parser.add_argument("--new", action="store_true",
                      help="judge those that were judged at no commit")
  parser.add_argument("--layer-only", action="store_true",
                      help="run only the tests of the layer; what they miss is not judged yet")
  parser.add_argument("--minutes", type=float, default=1e9, help="begin none after so many minutes")
  parser.add_argument("--jobs", type=int, default=os.cpu_count(), help="processes at once")
  parser.add_argument("--list", type=pathlib.Path, default=LIST, help="the list of mistakes")
  options = parser.parse_args()
  try:
    mistakes = read_list(options.list)
  except ValueError as error:
    sys.exit(f"mutate.sh: {options.list}: {error}")
  complaints = check(mistakes, ROOT)
  for complaint in complaints:
    print(f"{options.list}: {complaint}", file=sys.stderr)
  if options.check or complaints:
    sys.exit(1 if complaints else 0)
  if not options.table:
    judge_all(mistakes, options)
  sys.exit(0 if print_table(mistakes) >= LEAST_SHARE else 1)


if __name__ == "__main__":
  main()
