"""The commands on the pages: those that can be run are run, and all have the options that they name.

docs_commands_test.py ROOT TAGCAL          the check, after a proof that it fails where it must
docs_commands_test.py ROOT TAGCAL PAGE     prints what the commands of a page print

Rules:
  1. In the pages of RUN each line of a code block that begins with `$ ` is run, in order and in one
     folder, and prints the lines below it. `...` stands for any lines. Numbers may differ by 10 % or
     by two units of their last digit, because rounding differs between machines. Lines on progress
     are left out, and lines on files written unless the page has one.
  2. Each option of a `tagcal COMMAND` in a code block of any page is in the command's help.
"""

import os
import re
import subprocess
import sys
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Iterator

RUN = ["README.md", "docs/reference/findings.md", "docs/tasks/first_calibration.md",
       "docs/tasks/pictures.md", "docs/tasks/pose.md", "docs/tasks/rigs.md", "docs/tasks/stereo.md"]
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
PROGRESS = re.compile(r"(detecting|rendering|calibrating|thumbnails): |wrote .*\.corners-cache$")
NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")
OPTION = re.compile(r"(?<=\s)--[a-z][a-z-]*")
CALL = re.compile(r"(?:^|[|;&(]|\bdo)\s*(?:\$ )?tagcal\s+([a-z]+)\b([^|;&\n]*)", re.MULTILINE)


def blocks(text: str) -> list[str]:
    """The blocks for a shell, with continued lines joined."""
    return [block.replace("\\\n", "  ") for language, block in BLOCK.findall(text)
            if language == "sh" or not language and block.startswith("$ ")]


def commands(text: str) -> Iterator[tuple[str, list[str]]]:
    """Each command that a page runs, and the lines that it shows below it."""
    for block in blocks(text):
        parts = re.split(r"^\$ ", block, flags=re.MULTILINE)
        for part in parts[1:]:
            command, *shown = part.rstrip("\n").split("\n")
            yield command, shown


def close(shown: str, printed: str) -> bool:
    a, b = float(shown), float(printed)
    digits = len(shown.partition("e")[0].partition(".")[2])
    unit = 10.0 ** (int(shown.partition("e")[2] or 0) - digits)
    return abs(a - b) <= max(2.01 * unit, 0.1 * abs(a))


def same(shown: str, printed: str) -> bool:
    """Equal words and gaps, with close numbers."""
    if " ".join(NUMBER.sub("0", shown).split()) != " ".join(NUMBER.sub("0", printed).split()):
        return False
    return all(map(close, NUMBER.findall(shown), NUMBER.findall(printed)))


def first_missing(shown: list[str], printed: list[str]) -> str | None:
    """The first line of a page that is not printed where the page has it."""
    at, free = 0, False
    for line in shown:
        if line.strip() == "...":
            free = True
            continue
        last = len(printed) if free else min(at + 1, len(printed))
        found = next((i for i in range(at, last) if same(line, printed[i])), None)
        if found is None:
            return line
        at, free = found + 1, False
    return None if free or at == len(printed) else f"(the end, but there is: {printed[at]})"


def run_commands(root: Path, tagcal: Path, text: str) -> Iterator[tuple[str, list[str], list[str], int]]:
    with tempfile.TemporaryDirectory() as folder:
        for name in ("data-synthetic", "tests"):
            (Path(folder) / name).symlink_to(root / name)
        (Path(folder) / "bin").mkdir()
        (Path(folder) / "bin/tagcal").symlink_to(tagcal)
        environment = os.environ | {"PATH": f"{folder}/bin:{os.environ['PATH']}", "COLUMNS": "100"}
        for command, shown in commands(text):
            done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, text=True,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
            printed = [line for line in done.stdout.rstrip("\n").split("\n") if not PROGRESS.match(line)]
            if not any(line.startswith("wrote ") for line in shown):
                printed = [line for line in printed if not line.startswith("wrote ")]
            yield command, shown, printed, done.returncode


def different(root: Path, tagcal: Path, text: str) -> Iterator[str]:
    for command, shown, printed, code in run_commands(root, tagcal, text):
        missing = first_missing(shown, printed) if shown else None
        if code != 0:
            yield f"exit code {code}: {command}\n" + "\n".join(printed)
        elif missing is not None:
            yield f"not printed: {missing}\n  by: {command}\n" + "\n".join(printed)


@lru_cache
def options_of(tagcal: Path, command: str) -> set[str] | None:
    found: set[str] = set()
    for help_option in ("--help", "--help-all"):
        done = subprocess.run([tagcal, command, help_option], text=True, capture_output=True, check=False)
        if done.returncode == 0 and f"tagcal {command} " in done.stdout:
            found |= set(re.findall(r"--[a-z][a-z-]*", done.stdout))
    return found or None


def unknown_options(tagcal: Path, text: str) -> Iterator[str]:
    for block in blocks(text):
        for command, rest in CALL.findall(block):
            if command in ("chart", "stability", "help"):  # of tagcal-study, and a word before others
                continue
            known = options_of(tagcal, command)
            if known is None:
                yield f"tagcal has no command {command}"
                continue
            for option in OPTION.findall(re.sub(r"(\s#|'|\").*", "", rest)):
                if option not in known and option not in ("--help", "--version"):
                    yield f"tagcal {command} has no option {option}"


def prove(tagcal: Path) -> None:
    assert same("fx 900.045 +- 0.018", "fx   900.046 +-  0.019")
    assert not same("fx 900.045 +- 0.018", "fx 900.045 +- 0.030")
    assert not same("OK: f", "OK: f+c")
    assert first_missing(["a", "...", "c"], ["a", "b", "c"]) is None
    assert first_missing(["a", "c"], ["a", "b", "c"]) == "c"
    assert first_missing(["a", "..."], ["a", "b", "c"]) is None
    assert first_missing(["a"], ["a", "b"]) is not None
    page = "```\n$ echo 1.00\n1.01\n$ true  # nothing\n```\n"
    assert [command for command, _ in commands(page)] == ["echo 1.00", "true  # nothing"]
    assert not list(unknown_options(tagcal, "```sh\ntagcal board a.yaml --out b.pdf   # --never\n```\n"))
    assert len(list(unknown_options(tagcal, "```sh\ntagcal board a.yaml \\\n  --never b\n```\n"))) == 1
    assert len(list(unknown_options(tagcal, "```sh\ntagcal never\n```\n"))) == 1


def main(root: Path, tagcal: Path, *names: str) -> int:
    for name in names:
        for command, _, printed, _ in run_commands(root, tagcal, (root / name).read_text()):
            print(f"$ {command}", *printed, sep="\n")
    if names:
        return 0
    prove(tagcal)
    found = []
    for page in sorted([root / "README.md", *(root / "docs").rglob("*.md")]):
        name = str(page.relative_to(root))
        found += [f"{name}: {fault}" for fault in unknown_options(tagcal, page.read_text())]
        if name in RUN:
            found += [f"{name}: {fault}" for fault in different(root, tagcal, page.read_text())]
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve(), *sys.argv[3:]))
