"""Every link between pages leads somewhere, and so does every page that a source names.

docs_links_test.py ROOT    the check, after a proof that it fails where it must

Rules:
  1. The target of a relative link of a page exists, and so does the heading after its #.
  2. Each `docs/...` in a text file of the project exists.
  3. The index, docs/README.md, links to every page of docs/*/.
"""

import re
import sys
import tempfile
from pathlib import Path
from typing import Iterator

PARTS = [".ci", "cmake", "data-synthetic", "docs", "lib", "tests", "tools"]  # and the root's files
SKIPPED = {"node_modules", "out", "__pycache__"}
BLOCK = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
CODE = re.compile(r"`[^`\n]*`")
LINK = re.compile(r"\]\(([^)\s]+)\)")
HEADING = re.compile(r"^#+ +(.*)$", re.MULTILINE)
MENTION = re.compile(r"(?<![\w.-])docs/[\w./-]*")
URL = re.compile(r"\w+://\S+")


def files(root: Path) -> Iterator[Path]:
    yield from (path for path in root.iterdir() if path.is_file())
    for part in PARTS:
        for path in (root / part).rglob("*"):
            if path.is_file() and not SKIPPED & set(path.relative_to(root).parts):
                yield path


def anchors(page: Path) -> set[str]:
    """The names of a page's headings, as GitHub makes them."""
    found: set[str] = set()
    for heading in HEADING.findall(BLOCK.sub("", page.read_text())):
        text = LINK.sub("]", heading).lower()
        name = re.sub(r"[^\w\- ]", "", text).replace(" ", "-")
        number = 0
        while name + (f"-{number}" if number else "") in found:
            number += 1
        found.add(name + (f"-{number}" if number else ""))
    return found


def dead_links(page: Path, text: str) -> Iterator[str]:
    for target in LINK.findall(CODE.sub("", BLOCK.sub("", text))):
        if URL.match(target):
            continue
        path, _, anchor = target.partition("#")
        there = page.parent / path if path else page
        if not there.exists():
            yield f"links to {target}, which does not exist"
        elif anchor and anchor not in anchors(there):
            yield f"links to {target}, which has no such heading"


def dead_mentions(root: Path, text: str) -> Iterator[str]:
    for name in MENTION.findall(URL.sub("", text)):
        if not (root / name.rstrip("./-")).exists():
            yield f"names {name}, which does not exist"


def missing_in_index(root: Path) -> Iterator[str]:
    index = root / "docs/README.md"
    links = LINK.findall(index.read_text())
    linked = {(index.parent / link.partition("#")[0]).resolve() for link in links}
    for page in sorted((root / "docs").glob("*/*.md")):
        if page.resolve() not in linked:
            yield f"docs/README.md: does not link to {page.relative_to(root)}"


def faults(root: Path) -> Iterator[str]:
    for path in sorted(files(root)):
        if path.resolve() == Path(__file__).resolve():
            continue
        try:
            text = path.read_text(encoding="utf-8")
        except UnicodeDecodeError:
            continue
        if path.suffix == ".md":
            yield from (f"{path.relative_to(root)}: {fault}" for fault in dead_links(path, text))
        yield from (f"{path.relative_to(root)}: {fault}" for fault in dead_mentions(root, text))
    yield from missing_in_index(root)


def faults_of_tree(**changed: str) -> int:
    """Number of faults of a small project with these texts in place of the right ones."""
    texts = {
        "index": "[a](tasks/a.md)",
        "page": "# A `b` c\n[c](#a-b-c)",
        "source": "// docs/tasks/a.md.",
    } | changed
    places = {"index": "docs/README.md", "page": "docs/tasks/a.md", "source": "lib/a.hpp"}
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name, place in places.items():
            (root / place).parent.mkdir(parents=True, exist_ok=True)
            (root / place).write_text(texts[name])
        return len(list(faults(root)))


def prove() -> None:
    assert faults_of_tree() == 0
    assert faults_of_tree(index="[a](tasks/a.md#a-b-c)") == 0
    assert faults_of_tree(index="[a](tasks/a.md) `[b](c.md)`\n```\n[b](c.md)\n```\n") == 0
    assert faults_of_tree(source="// https://example.org/docs/b.md") == 0
    assert faults_of_tree(index="no link") == 1
    assert faults_of_tree(index="[a](tasks/a.md) [b](tasks/b.md)") == 1
    assert faults_of_tree(index="[a](tasks/a.md#b)") == 1
    assert faults_of_tree(page="[c](#a-b-c)") == 1
    assert faults_of_tree(page="see docs/b.md") == 1
    assert faults_of_tree(source='path + "/docs/a.md"') == 1


if __name__ == "__main__":
    prove()
    sys.exit("\n".join(faults(Path(sys.argv[1]).resolve())) or None)
