"""Runs the programs of a page (docs/tasks/python.md) in order, as the cells of a notebook.

    page.py PAGE FOLDER    # runs the page in FOLDER, where it leaves its pictures

A block ```python is a cell; all cells share their names. A block without a language that follows it
is what the cell prints: "..." stands for any text, spaces count as one.
"""

import contextlib
import doctest
import io
import os
import re
import sys
from pathlib import Path
from typing import Any, Iterator, NamedTuple

ROOT = Path(__file__).parents[2]
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE
BLOCK = re.compile(r"^```(\w*)\n(.*?)^```$\n*", re.MULTILINE | re.DOTALL)


class Cell(NamedTuple):
    line: int  # of the page
    program: str
    output: str


def cells(page: Path) -> Iterator[Cell]:
    text = page.read_text()
    blocks = list(BLOCK.finditer(text))
    for block, following in zip(blocks, [*blocks[1:], None]):
        if block[1] != "python":
            continue
        is_output = following and following[1] == "" and following.start() == block.end()
        line = text.count("\n", 0, block.start(2)) + 1
        yield Cell(line, block[2], following[2] if following and is_output else "")


def run(page: Path, folder: Path) -> list[str]:
    """What differs from the page, cell by cell. `folder` gets the links docs and data-synthetic."""
    for name in ["docs", "data-synthetic"]:
        (folder / name).symlink_to(ROOT / name)
    names: dict[str, Any] = {"__name__": "page"}
    wrong = []
    before = os.getcwd()
    os.chdir(folder)
    try:
        for cell in cells(page):
            printed = io.StringIO()
            program = compile("\n" * (cell.line - 1) + cell.program, str(page), "exec")
            with contextlib.redirect_stdout(printed):
                exec(program, names)
            if not doctest.OutputChecker().check_output(cell.output, printed.getvalue(), FLAGS):
                wrong.append(f"{page.name}:{cell.line}: prints\n{printed.getvalue()}")
    finally:
        os.chdir(before)
    return wrong


if __name__ == "__main__":
    differences = run(Path(sys.argv[1]).absolute(), Path(sys.argv[2]))
    sys.exit("\n".join(differences) or None)
