"""A program may have set a locale with decimal commas: what tagcal reads, writes and says stays the same."""

import locale
import os
import subprocess
from collections.abc import Iterator
from pathlib import Path

import desk
import pytest
import tagcal


@pytest.fixture
def german(tmp_path: Path) -> Iterator[None]:
    made = tmp_path / "de_DE.UTF-8"
    try:
        subprocess.run(["localedef", "-i", "de_DE", "-f", "UTF-8", made], capture_output=True, check=False)
    except FileNotFoundError:
        pytest.skip("localedef is missing")
    before, path = locale.setlocale(locale.LC_ALL), os.environ.get("LOCPATH")
    os.environ["LOCPATH"] = str(tmp_path)
    try:
        locale.setlocale(locale.LC_ALL, "de_DE.UTF-8")
    except locale.Error:
        pytest.skip("localedef cannot make de_DE.UTF-8")
    finally:
        os.environ.pop("LOCPATH")
        if path is not None:
            os.environ["LOCPATH"] = path
    yield
    locale.setlocale(locale.LC_ALL, before)


def everything(folder: Path) -> str:
    folder.mkdir()
    data = desk.desk()
    calibration = tagcal.calibrate(data)
    tagcal.write_camera(folder / "camera.yaml", calibration)
    read = tagcal.read_camera(folder / "camera.yaml")
    with pytest.raises(tagcal.Error) as error:
        tagcal.Board.grid(6, 6, -0.5, 0.3)
    texts = [repr(calibration), str(calibration), repr(read), repr(calibration.camera), repr(data), str(error.value)]
    return "\n".join([*texts, (folder / "camera.yaml").read_text()])


def test_decimal_commas_change_nothing(tmp_path: Path, request: pytest.FixtureRequest) -> None:
    expected = everything(tmp_path / "c")
    request.getfixturevalue("german")
    assert locale.format_string("%.1f", 1.5) == "1,5"
    assert everything(tmp_path / "de") == expected
