"""Pages of results: a table in notebooks, and the page of `tagcal report`."""

import os
import shutil
import subprocess
import tempfile
from html import escape
from pathlib import Path
from typing import Optional, Union

from tagcal import _core

File = Union[str, "os.PathLike[str]"]


def _row(*cells: str) -> str:
    return "<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>"


def table_of(calibration: _core.Calibration) -> str:
    """The verdict, the parameters and the findings of a calibration, as HTML."""
    rows = []
    if calibration.camera is not None:
        for name, value in calibration.camera.parameters.items():
            sigma = calibration.sigmas.get(name, 0.0)
            if value or sigma:
                rows.append(_row(name, f"{value:.6g}", f"{sigma:.2g}" if sigma else "held"))
    head = "<tr><th>parameter</th><th>value</th><th>standard deviation</th></tr>"
    text = f"<p><b>{escape(repr(calibration).strip('<>'))}</b></p>"
    if rows:
        text += f"<table>{head}{''.join(rows)}</table>"
    findings = [f"{f.severity} {f.code}: {f.sentence}" for f in calibration.findings]
    if findings:
        text += "<ul>" + "".join(f"<li>{escape(finding)}</li>" for finding in findings) + "</ul>"
    return text


def _program() -> str:
    """The command: that of this build, else the one on the PATH."""
    built = Path(_core.__file__).parents[2] / "tools" / "tagcal"
    program = str(built) if built.is_file() else shutil.which("tagcal")
    if program is None:
        raise _core.Error("report: needs the command tagcal, which is not on the PATH")
    return program


def report(
    calibration: Union[_core.Calibration, _core.UncertainCamera, _core.Camera],
    file: File = "report.html",
    *,
    dataset: Union[_core.Dataset, _core.DatasetFolder, File, None] = None,
    other: Union[_core.Calibration, _core.UncertainCamera, _core.Camera, None] = None,
) -> Path:
    """Writes the HTML page of a calibration that `tagcal report` makes, and returns its path.

    `dataset`: a Dataset, or the folder of one with pictures, whose corners, residuals and views are
    shown. `other`: a second camera to compare with. It runs the command `tagcal`, which must be
    installed. Raises Error with the command's words if it refuses.
    """
    if isinstance(calibration, _core.Calibration) and calibration.camera is None:
        raise _core.Error(f"calibration: has no camera: {repr(calibration).strip('<>')}")
    with tempfile.TemporaryDirectory() as folder:
        words: list[File] = [_program(), "report"]
        for name, camera in (("camera", calibration), ("other", other)):
            if camera is not None:
                words.append(Path(folder) / f"{name}.yaml")
                _core.write_camera(words[-1], camera)
        if isinstance(dataset, _core.DatasetFolder):
            dataset = dataset.dataset
        if isinstance(dataset, _core.Dataset):
            seen = _core.Dataset(dataset.size, dataset.target, dataset.views)
            _core.write_dataset(Path(folder) / "dataset", seen)
            dataset = Path(folder) / "dataset"
        if dataset is not None:
            words += ["--dataset", dataset]
        done = subprocess.run([*words, "--out", file], capture_output=True, text=True)
        if done.returncode != 0:
            raise _core.Error("report: " + (done.stderr or done.stdout).strip())
    return Path(file)
