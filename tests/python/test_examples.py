"""Every program of docs/tasks/python.md runs and prints what the page shows."""

import re
import struct
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

import cv2  # noqa: E402
import numpy as np  # noqa: E402
import page  # noqa: E402
import pytest  # noqa: E402
from matplotlib import pyplot  # noqa: E402

PAGE = page.ROOT / "docs/tasks/python.md"
PICTURES = re.findall(r"!\[[^\]]+\]\(python/(\w+\.png)\)", PAGE.read_text())


def test_the_page_prints_what_it_shows_and_makes_its_pictures(tmp_path: Path) -> None:
    assert page.run(PAGE, tmp_path) == []
    pyplot.close("all")
    assert len(PICTURES) == 6
    for name in set(PICTURES) - {"tag.png"}:
        assert size_of(tmp_path / name) == size_of(PAGE.parent / "python" / name), name


def size_of(png: Path) -> tuple[int, int]:
    width, height = struct.unpack(">II", png.read_bytes()[16:24])
    return width, height


def test_the_picture_of_the_tag_is_the_one_that_the_page_renders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)  # where the page writes it
    first, second = list(page.cells(PAGE))[:2]
    shown = cv2.imread(str(PAGE.parent / "python/tag.png"), cv2.IMREAD_GRAYSCALE)
    names = {"__name__": "page"}
    exec(first.program.replace("docs/tasks/python", str(PAGE.parent / "python")), names)
    exec(second.program, names)
    assert np.array_equal(shown, names["picture"])


def test_all_pictures_are_on_the_page() -> None:
    assert sorted(PICTURES) == sorted(path.name for path in (PAGE.parent / "python").glob("*.png"))


@pytest.mark.parametrize("shown, is_same", [("a 1\n", True), ("a ...\n", True), ("a 2\n", False)])
def test_another_output_is_found(shown: str, is_same: bool, tmp_path: Path) -> None:
    path = tmp_path / "page.md"
    program = "```python\nx = 1\n```\n\nThen\n\n```python\nprint('a', x)\n```\n"
    path.write_text(f"{program}```\n{shown}```\n")
    folder = tmp_path / "folder"
    folder.mkdir()
    assert page.run(path, folder) == ([] if is_same else ["page.md:8: prints\na 1\n"])
