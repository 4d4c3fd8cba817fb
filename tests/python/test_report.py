"""Pages of calibrations: a table in notebooks, and the page of the command."""

from pathlib import Path

import pytest
import tagcal
from desk import COMMAND, desk


@pytest.fixture(scope="module")
def calibration() -> tagcal.Calibration:
    return tagcal.calibrate(desk())


def test_notebooks_show_a_table(calibration: tagcal.Calibration) -> None:
    text = calibration._repr_html_()
    assert "Calibration ok, opencv4" in text
    assert text.count("<tr>") == 1 + len(calibration.free_parameters)
    assert f"{calibration.camera.parameters['fx']:.6g}" in text
    assert all(f.code in text for f in calibration.findings)


def test_notebooks_show_a_refusal() -> None:
    dataset = desk()
    refused = tagcal.calibrate(tagcal.Dataset(dataset.size, dataset.target, []))
    assert "degenerate" in refused._repr_html_()
    assert "<table>" not in refused._repr_html_()
    with pytest.raises(tagcal.Error, match="calibration: has no camera: Calibration no answer"):
        tagcal.report(refused)


needs_command = pytest.mark.skipif(not COMMAND.exists(), reason="the command is not built")


@needs_command
def test_page(calibration: tagcal.Calibration, tmp_path: Path) -> None:
    alone = tagcal.report(calibration, tmp_path / "alone.html")
    assert alone == tmp_path / "alone.html"
    with_corners = tagcal.report(calibration, tmp_path / "page.html", dataset=desk())
    assert alone.read_text().startswith("<!")
    assert len(with_corners.read_text()) > len(alone.read_text())
    other = tagcal.report(calibration.camera, tmp_path / "two.html", other=calibration)
    assert 'id="data"' in other.read_text()


@needs_command
def test_a_page_that_is_refused(calibration: tagcal.Calibration, tmp_path: Path) -> None:
    with pytest.raises(tagcal.Error, match="report: .*no_such"):
        tagcal.report(calibration, tmp_path / "page.html", dataset=tmp_path / "no_such")


def test_without_the_command(
    calibration: tagcal.Calibration, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(tagcal._core, "__file__", str(tmp_path / "a/b/c.so"))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(tagcal.Error, match="report: needs the command tagcal"):
        tagcal.report(calibration, tmp_path / "page.html")
