"""Each piece of tools/pages.txt has a stamp on its page, and the stamps that are old are printed; the
numbers that quote a measured table (quoted_numbers.txt) are those of the table.

docs_test.py ROOT    the check, after a proof that it fails where it must

Fails for a piece without a stamp, a stamp of no piece, a block without a mark, a path that is not
there, and a quoted number that is more than one unit of its last digit off. A stamp that is older than
the last change of what it measures is printed only: the numbers may still be right, and tools/pages.sh
takes hours. Without the history of git nothing is known to be old.
"""

import re
import sys
import tempfile
from pathlib import Path
from typing import Iterator

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tools"))
import pages


def mistakes(root: Path) -> Iterator[str]:
    pieces = pages.pieces(root)
    known: dict[Path, set[str]] = {}
    for piece in pieces:
        yield from (f"tools/pages.txt: {piece.name}: there is no {path}" for path in piece.paths
                    if not (root / path).exists())
        known.setdefault(piece.page, set()).add(piece.name)
        page = root / piece.page
        text = page.read_text() if page.is_file() else ""
        if piece.name not in pages.stamps_of(text):
            yield f"{piece.page}: has no stamp of {piece.name}"
        if piece.output == "block" and piece.mark not in text:
            yield f"{piece.page}: has no {piece.mark}"
    for page in sorted((root / "docs").rglob("*.md")):
        place = page.relative_to(root)
        for name in pages.stamps_of(page.read_text()).keys() - known.get(place, set()):
            yield f"{place}: {name} is no piece of tools/pages.txt"


CELL = re.compile(r"(\w+)\[([^]]*)\]\[([^]]*)\]")  # piece[first cells of a row; ..][column, or its number]


def cell(text: str, row: list[str], column: str) -> float:
    """The number at the beginning of a cell of one of the tables in a text."""
    head: list[str] = []
    for line in text.splitlines():
        cells = [part.strip() for part in line.strip().strip("|").split("|")] if line.startswith("|") else []
        head = cells and (head or cells)
        if cells[:len(row)] == row and (column.isdigit() or column in head):
            found = cells[int(column) - 1 if column.isdigit() else head.index(column)]
            return float(re.match(r"[-+.\de]*", found)[0])
    raise KeyError(f"no table has {'; '.join(row)} and {column}")


def wrong_quotes(root: Path, quotes: str) -> Iterator[str]:
    known = {piece.name: piece for piece in pages.pieces(root)}

    def value_of(match: re.Match) -> str:
        piece = known[match[1]]
        text = (root / piece.page).read_text()
        if piece.output == "block":
            text = text[text.index(piece.mark):text.index(f"*Measured: `{piece.name}`")]
        return repr(cell(text, [part.strip() for part in match[2].split(";")], match[3]))

    for line in quotes.splitlines():
        if not line or line.startswith("#"):
            continue
        page, words, formula = (field.strip() for field in line.split("|"))
        pattern = re.escape(words).replace(r"\ ", r"\s+").replace(r"\#", r"([\d,.]*\d)")
        found = re.search(pattern, (root / page).read_text())
        try:
            value = eval(CELL.sub(value_of, formula), {})
        except KeyError as missing:
            yield f"{page}: {formula}: {missing.args[0]}"
            continue
        if not found:
            yield f"{page}: does not say: {words}"
        elif abs(float(found[1].replace(",", "")) - value) > 10.0 ** -len(found[1].partition(".")[2]):
            yield f"{page}: says {found[1]}, but {formula} is {value:.4g}"


def old_stamps(root: Path) -> Iterator[str]:
    for piece in pages.pieces(root):
        stamp = pages.stamp_of(piece, root)
        if stamp and (change := pages.changes_since(piece, stamp, root)):
            yield f"{piece.page}: {piece.name} of {stamp.date} is older than {change}"


def prove() -> None:
    """The check finds each kind of mistake in a small tree, and none in a right one."""
    place = Path("docs") / "a.md"
    row = f"a_b | {place} | block | true | lib\n"
    stamp = "*Measured: `a_b`, version 0123abc of 2026-01-31.*\n"
    right = "<!-- measured: a_b -->\n\n1\n\n" + stamp
    cases = [(row, right, 0), (row, stamp, 1), (row, "1\n", 2), ("", right, 1),
             (row.replace("lib", "no"), right, 1)]
    for table, page, expected in cases:
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            for name in ("docs", "lib", "tools"):
                (root / name).mkdir()
            (root / "tools/pages.txt").write_text(table)
            (root / place).write_text(page)
            found = list(mistakes(root))
            assert len(found) == expected, (table, page, found)
            if not expected:
                quoted = "It is 2,004 | x | y |\n\n| a | b |\n|---|---|\n| r | 1002, 3 |\n" + stamp
                (root / place).write_text("<!-- measured: a_b -->\n" + quoted)
                for words, formula, wrong in (("It is #", "a_b[r][b] * 2", 0), ("It is #", "a_b[r][2]", 1),
                                              ("It was #", "a_b[r][b] * 2", 1), ("It is #", "a_b[s][b]", 1)):
                    assert len(list(wrong_quotes(root, f"{place} | {words} | {formula}"))) == wrong, words
    piece = pages.Piece("a_b", place, "block", "true", [])
    made = pages.with_block(right, piece, "2\n", pages.Stamp("4567def", "2026-02-01"))
    assert made == right.replace("\n1\n", "\n2\n").replace("0123abc of 2026-01-31", "4567def of 2026-02-01")
    made = pages.with_stamps("1\n\n" + stamp, pages.stamps_of(stamp) | {"c": pages.Stamp("4567def", "2026-02-01")})
    assert made == "1\n\n" + stamp + "*Measured: `c`, version 4567def of 2026-02-01.*\n", made
    with tempfile.TemporaryDirectory() as folder:
        rows = Path(folder) / "a_b/rows.csv"
        for version, ends, kept in (("1", False, False), ("1", True, True), ("1", False, False), ("2", False, False)):
            begun = pages.begin(rows.parent, version)
            assert rows.exists() == kept, "rows of a run that ended, or of another version, do not count"
            rows.write_text("1")
            if ends:
                begun.unlink()


def main() -> int:
    prove()
    root = Path(sys.argv[1])
    for line in old_stamps(root):
        print(f"old: {line}")
    found = [*mistakes(root), *wrong_quotes(root, (root / "tests/quoted_numbers.txt").read_text())]
    print("\n".join(found))
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
