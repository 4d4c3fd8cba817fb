"""The pieces of tools/pages.txt and their stamps; tools/pages.sh runs it."""

import dataclasses
import datetime
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
WORK = ROOT / "build/pages"
STAMP = re.compile(r"^\*Measured: `(\w+)`, version (\w+) of (\d{4}-\d\d-\d\d)\.\*$", re.MULTILINE)


@dataclasses.dataclass
class Piece:
    name: str
    page: Path  # relative to the root
    output: str  # block, folder or part
    command: str
    paths: list[str]

    @property
    def mark(self) -> str:
        return f"<!-- measured: {self.name} -->"


@dataclasses.dataclass
class Stamp:
    version: str
    date: str

    def line(self, name: str) -> str:
        return f"*Measured: `{name}`, version {self.version} of {self.date}.*"


def git(root: Path, *arguments: str) -> str | None:
    """What git prints; no value if it fails, as in a tree without history, or is not there."""
    if not shutil.which("git"):
        return None
    done = subprocess.run(["git", "-C", root, *arguments], capture_output=True, text=True)
    return done.stdout.strip() if done.returncode == 0 else None


def pieces(root: Path = ROOT) -> list[Piece]:
    common: list[str] = []
    found = []
    for line in (root / "tools/pages.txt").read_text().splitlines():
        if not line or line.startswith("#"):
            continue
        fields = [field.strip() for field in line.split("|")]
        if fields[0] == "common":
            common = fields[1].split()
            continue
        name, page, output, command, paths = fields
        found.append(Piece(name, Path(page), output, command, common + paths.split()))
    return found


def stamps_of(text: str) -> dict[str, Stamp]:
    return {name: Stamp(version, date) for name, version, date in STAMP.findall(text)}


def stamp_of(piece: Piece, root: Path = ROOT) -> Stamp | None:
    file = root / piece.page
    return stamps_of(file.read_text()).get(piece.name) if file.is_file() else None


def with_stamps(text: str, stamps: dict[str, Stamp]) -> str:
    """A page whose stamps stand at its end."""
    lines = [stamp.line(name) for name, stamp in stamps.items()]
    return "\n".join([STAMP.sub("", text).rstrip() + "\n", *lines]) + "\n"


def changes_since(piece: Piece, stamp: Stamp, root: Path = ROOT) -> str | None:
    """The last change of what a piece measures, after its stamp: "" for none; no value without git."""
    log = ["log", "-1", "--format=%h of %as: %s"]
    if git(root, "merge-base", "--is-ancestor", stamp.version, "HEAD") is not None:
        return git(root, *log, f"{stamp.version}..HEAD", "--", *piece.paths)
    return git(root, *log, f"--since={stamp.date} 23:59:59", "--", *piece.paths)


def with_block(text: str, piece: Piece, block: str, stamp: Stamp) -> str:
    begin = text.index(piece.mark) + len(piece.mark)
    old = STAMP.search(text, begin)
    if not old or old[1] != piece.name:
        sys.exit(f"pages.py: {piece.page}: no stamp of {piece.name} below its mark")
    return text[:begin] + f"\n\n{block.strip()}\n\n" + stamp.line(piece.name) + text[old.end():]


def begin(work: Path, version: str) -> Path:
    """A folder that has the rows of a run of this version that did not end, and no others."""
    begun = work / "version"
    if not begun.is_file() or begun.read_text() != version:
        shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True, exist_ok=True)
    begun.write_text(version)
    return begun


def run(piece: Piece) -> None:
    work, out = WORK / piece.name, WORK / piece.name / "out"
    stamp = version()
    begun = begin(work, stamp.version)
    command = piece.command.replace("{out}", str(out)).replace("{work}", str(work))
    path = f'PATH="{ROOT}/build/release/tools:$PATH"; set -euo pipefail; '
    done = subprocess.run(["bash", "-c", path + command], cwd=ROOT, stdout=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"pages.py: {piece.name} failed: {command}")
    page = ROOT / piece.page
    before = page.read_text() if page.is_file() else ""
    stamps = stamps_of(before)
    if piece.output == "block":
        page.write_text(with_block(before, piece, done.stdout, stamp))
    else:
        if piece.output == "part":  # the page has to be drawn again, and has no stamp until then
            stamps = {part.name: stamps[part.name] for part in pieces() if part.output == "part" and part.name in stamps}
        for file in out.iterdir():
            drawn = piece.output == "folder" and file.suffix != ".svg" and file.name != "trials.csv"
            if drawn or piece.output == "part" and file.suffix == ".csv":
                shutil.copy(file, page.parent)
        page.write_text(with_stamps(page.read_text(), stamps | {piece.name: stamp}))
    begun.unlink()


def version() -> Stamp:
    if git(ROOT, "diff", "--quiet", "HEAD", "--", "lib", "tools/studies") is None:
        sys.exit("pages.py: commit the changes of lib and tools/studies first: a stamp names a version")
    commit = git(ROOT, "rev-parse", "--short", "HEAD") or sys.exit("pages.py: needs the history in git")
    return Stamp(commit, datetime.date.today().isoformat())


def main() -> None:
    arguments = sys.argv[1:]
    only_list = arguments[:1] == ["--list"]
    names = arguments[only_list:]
    known = pieces()
    if unknown := set(names) - {piece.name for piece in known}:
        sys.exit(f"pages.py: {', '.join(sorted(unknown))}: no piece of tools/pages.txt")
    for piece in known:
        stamp = stamp_of(piece)
        if names and piece.name not in names and (stamp or piece.output != "folder" or only_list):
            continue
        change = changes_since(piece, stamp) if stamp else "never"
        if only_list:
            state = "up to date" if not change else f"older than {change}" if stamp else "not made"
            print(f"{piece.name:28} {stamp.version if stamp else '':10} {state}")
        elif names or change:
            print(f"{piece.name}: {piece.page}", file=sys.stderr)
            run(piece)


if __name__ == "__main__":
    main()
